//! A whole measurement of step diagonals, from its runs to the nine errors.

use super::closure::{Closure, Known, closure};
use super::corrections::{AngleEffects, bow_um_per_urad, without_angles, without_expansion};
use super::curves::{Curve, curves, end_slope, mean, plus_line, with_slope};
use super::doubt;
use super::increments::{Group, Increments, Means, mean_increments};
use super::line::ReferenceLine;
use super::metric::{Metric, PerPlane, Plane, StraightLine, displacement_ratios, solve};
use super::noise::{
    CorrectedRun, Noise, NoiseSource, coverage_factor, effective_freedom, means, run_counts,
};
use super::repeats::repeats;
use super::reversal::{Turn, ran_over, turn, without_jumps};
use super::straight::{DiagonalFigures, Totals, figures, totals, u_squareness};
use super::tilt::{Tilt, tilts};
use super::uncertainty::{AlongCurve, Budget, Side, SlopeFrom};
use crate::axis::{Axis, Direction, ErrorTerm, PerAxis, PerTerm};
use crate::diagonal::{Diagonal, Pass, PathKind, PerDiagonal, Run, Volume};
use crate::job::{DiagonalMeasurement, Frame, SetUp, StatedUncertainty};
use std::borrow::Cow;

/// Uncertainty that weighs totals and lines where neither noise nor a statement gives one, µm/m.
const WEIGHT_UM_PER_M: f64 = 1.0;
/// By how much totals are changed to see what hangs on them, µm.
const DIFFERENCE_UM: f64 = 1.0;

/// One separated curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Evidence {
    /// Deviations at the interval ends, lowest first, µm; the first is 0 (a − curve: the reversal).
    pub deviation_um: Curve,
    /// Standard uncertainties (k = 1) against the first position, µm; `None` = not known.
    pub u_um: Option<Vec<f64>>,
    /// The part of them that comes from the noise of the readings, µm.
    pub u_noise_um: Option<Vec<f64>>,
}

impl Evidence {
    fn new(deviation_um: Curve, along: Option<AlongCurve>) -> Evidence {
        let (u_um, u_noise_um) = along.map(|along| (along.u_um, along.noise_um)).unzip();
        Evidence {
            deviation_um,
            u_um,
            u_noise_um,
        }
    }

    /// Effective degrees of freedom of a point's uncertainty; `None` = unlimited.
    pub fn freedom(&self, index: usize, noise: Option<Noise>) -> Option<f64> {
        let u = *self.u_um.as_ref()?.get(index)?;
        effective_freedom(u, *self.u_noise_um.as_ref()?.get(index)?, noise?)
    }

    /// U of a point, µm: its uncertainty with the coverage factor of its degrees of freedom.
    pub fn expanded_um(&self, index: usize, noise: Option<Noise>) -> Option<f64> {
        let u = *self.u_um.as_ref()?.get(index)?;
        Some(u * coverage_factor(self.freedom(index, noise)))
    }
}

/// The nine errors; `None` = not determined.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct NineErrors {
    /// Without regard to direction, or the mean of both.
    pub mean: PerTerm<Option<Evidence>>,
    /// Moving in +, with two directions.
    pub plus: Option<PerTerm<Option<Evidence>>>,
    /// Moving in −. Where the reversal is not determined it starts at 0, too.
    pub minus: Option<PerTerm<Option<Evidence>>>,
}

impl NineErrors {
    /// The curves of a direction.
    pub fn directed(&self, direction: Direction) -> Option<&PerTerm<Option<Evidence>>> {
        match direction {
            Direction::Plus => self.plus.as_ref(),
            Direction::Minus => self.minus.as_ref(),
        }
    }
}

/// What a measurement of step diagonals says, and what it does not.
#[derive(Clone, Debug, PartialEq)]
pub struct Separation {
    /// The measured box.
    pub volume: Volume,
    /// What was assumed of the set-up.
    pub setup: SetUp,
    /// The nine errors.
    pub errors: NineErrors,
    /// Their shapes beside the line through the ends, µm: determined whatever the set-up.
    pub shapes: PerTerm<Curve>,
    /// Slopes as they fall out of the increments, µm/m: they hold the tilt of the mirror.
    pub naive_slopes_um_per_m: PerTerm<f64>,
    /// Squareness φ, µm/m, from the totals.
    pub squareness_um_per_m: PerPlane<Option<f64>>,
    /// Its standard uncertainty, µm/m; `None` = not known.
    pub u_squareness_um_per_m: Option<PerPlane<f64>>,
    /// φ of least squares lines through the separated curves, µm/m.
    pub squareness_least_squares_um_per_m: PerPlane<Option<f64>>,
    /// Scales, squareness, rank.
    pub metric: Metric,
    /// Tilt of the mirror; `None` = not determined, or assumed to be none.
    pub tilts: Option<PerDiagonal<Tilt>>,
    /// What is left over.
    pub closure: Closure,
    /// Noise of a single reading.
    pub noise: Option<Noise>,
    /// Figures of the diagonals.
    pub diagonals: PerDiagonal<DiagonalFigures>,
    /// Max − min over all diagonals, µm.
    pub range_over_all_um: f64,
    /// Whether the axes ran over the far end; `None` without reverse passes, and where neither the
    /// job nor the readings tell.
    pub overrun: Option<bool>,
    /// Reversals from a turn without overrun.
    pub turn: Option<Turn>,
    /// Reversal along the diagonals that cannot be told apart by axis, µm: no curve holds it.
    pub hidden_reversal_um: Option<f64>,
    /// S, µm·mm.
    pub scale_sum_um_mm: f64,
    /// What is not determined, in words.
    pub undetermined: Vec<String>,
    /// Why the result is doubtful, one sentence each; empty = nothing speaks against it.
    /// `separate` then answers no, and a verdict on a kit made from it is undecided at most.
    pub doubts: Vec<String>,
    /// What was assumed and what the uncertainty holds, in words.
    pub labels: Vec<String>,
    /// The corrected runs.
    pub runs: Vec<CorrectedRun>,
    /// The runs whose zero is that of the forward run: all, or the forward passes only.
    pub zeroed_runs: Vec<CorrectedRun>,
    /// The mean readings as measured; jumps of a turn are still in them.
    pub means: Means,
}

impl Separation {
    /// Whether the two directions stand apart in the error table: the reversal is determined.
    pub fn has_directed_table(&self) -> bool {
        self.turn.is_some() && self.errors.minus.is_some()
    }

    /// The terms that the readings do not determine.
    pub fn missing(&self) -> Vec<ErrorTerm> {
        let terms = self.errors.mean.iter();
        let missing = terms.filter(|(_, found)| found.is_none());
        missing.map(|(term, _)| term).collect()
    }

    /// Whether all nine errors are determined and nothing speaks against them: the answer of
    /// `separate`.
    pub fn stands(&self) -> bool {
        self.doubts.is_empty() && self.missing().is_empty()
    }

    /// Rank and number of unknowns: of formula (7), or of the slopes where the set-up is assumed.
    pub const fn rank(&self) -> (usize, usize) {
        match self.setup {
            SetUp::Solve => (self.metric.rank, 6),
            SetUp::AssumePerfect => (9, 9),
        }
    }

    /// Groups of readings that were separated.
    pub fn groups(&self) -> &'static [Group] {
        self.means.groups()
    }
}

/// What goes into a separation beside the readings.
#[derive(Clone, Debug)]
pub struct Campaign<'a> {
    /// How it was measured.
    pub measurement: &'a DiagonalMeasurement,
    /// `[measurement.uncertainty]`.
    pub stated: StatedUncertainty,
    /// Slopes of single axes and other beams.
    pub lines: Vec<Line>,
    /// Effects of angular errors on the readings.
    pub angles: Option<AngleEffects>,
    /// Whether reverse readings count from the forward start; else only their increments hold.
    pub reverse_zero_known: bool,
}

/// A straight line beside the diagonals; the uncertainty where it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Direction, of length 1.
    pub direction: PerAxis<f64>,
    /// Displacement error by length, µm/m.
    pub slope_um_per_m: f64,
    /// Standard uncertainty (k = 1), µm/m.
    pub u_um_per_m: Option<f64>,
}

/// The readings less expansion of the scales and angular effects.
pub fn corrected(campaign: &Campaign<'_>, runs: &[Run]) -> Vec<CorrectedRun> {
    let measurement = campaign.measurement;
    let kind = measurement.kind;
    let correct = |run: &Run| {
        let material = measurement
            .material
            .filter(|material| !material.material_corrected);
        let mut readings_um = match material {
            Some(material) => without_expansion(&measurement.volume, kind, &material, run),
            None => run
                .deviations
                .iter()
                .map(|deviation| deviation.um())
                .collect(),
        };
        if let Some(effects) = &campaign.angles {
            let pass = usize::from(run.pass == Pass::Reverse);
            without_angles(&mut readings_um, &effects[run.diagonal][pass]);
        }
        CorrectedRun {
            diagonal: run.diagonal,
            number: run.number,
            pass: run.pass,
            readings_um,
        }
    };
    runs.iter().map(correct).collect()
}

/// Separates a complete measurement of step diagonals.
pub fn separate(campaign: &Campaign<'_>, runs: &[Run]) -> Separation {
    let measurement = campaign.measurement;
    let volume = &measurement.volume;
    let runs = corrected(campaign, runs);
    let counts = run_counts(&runs);
    let measured = means(&runs);
    let repeats = repeats(&runs);
    let known = known_noise(&campaign.stated, repeats.noise);
    let guess = || {
        let rough = Known {
            skip_ends: true,
            ..Known::default()
        };
        known.or_else(|| closure(volume, &measured, &counts, rough).noise())
    };
    let overrun = measurement.overrun.filter(|_| measured.reverse.is_some());
    let overrun = overrun.or_else(|| {
        let judgeable = measured.reverse.is_some() && campaign.reverse_zero_known;
        judgeable.then(|| ran_over(&measured, volume, &counts, guess()?))?
    });
    let turned = overrun == Some(false);
    let means = separable(&measured, volume, turned);
    let judged = Known {
        noise: known,
        outliers: &repeats.outliers,
        skip_ends: means.reverse.is_some() && overrun != Some(true),
    };
    let closure = closure(volume, &means, &counts, judged);
    let noise = known.or_else(|| closure.noise());
    let budget = Budget {
        volume,
        noise,
        runs: &counts,
        turned,
        stated: campaign.stated,
        material: measurement.material,
    };
    let (solved, raw) = solve_readings(campaign, &budget, &means);
    let turn = turn(&measured, volume, &counts, noise).filter(|_| turned);
    let errors = solved.errors(&budget, &raw, turn.as_ref());
    let zeroed = |run: &&CorrectedRun| campaign.reverse_zero_known || run.pass == Pass::Forward;
    let zeroed_runs: Vec<CorrectedRun> = runs.iter().filter(zeroed).cloned().collect();
    let (mut diagonals, range_over_all_um) = figures(&zeroed_runs, PathKind::Step);
    for diagonal in Diagonal::ALL {
        diagonals[diagonal].end_um = solved.ends_um[diagonal];
    }
    let u_end = budget.u_end_um(means.reverse.is_some());
    let labels = labels(campaign, &budget, &means, overrun, turn.as_ref());
    let doubts = doubt::of_closure(&closure, noise, volume, measurement.setup);
    let hidden = (overrun == Some(true) && campaign.reverse_zero_known)
        .then(|| doubt::hidden_reversal_um(&measured, noise))
        .flatten();
    let both_ways = means.reverse.is_some();
    Separation {
        volume: volume.clone(),
        setup: measurement.setup,
        shapes: PerTerm::from_fn(|term| {
            with_slope(volume, term.along, &solved.mean_raw[term], 0.0)
        }),
        naive_slopes_um_per_m: solved.naive_slopes(volume),
        squareness_um_per_m: solved.squareness(measurement.setup),
        u_squareness_um_per_m: u_end.map(|u| u_squareness(volume, u)),
        squareness_least_squares_um_per_m: least_squares_squareness(volume, &errors.mean),
        tilts: tilts(volume, &solved.ratios, &solved.metric)
            .filter(|_| measurement.setup == SetUp::Solve),
        undetermined: solved.undetermined(both_ways, turn.is_some()),
        scale_sum_um_mm: solved.totals.scale_sum_um_mm,
        metric: solved.metric,
        errors,
        closure,
        noise,
        diagonals,
        range_over_all_um,
        overrun,
        turn,
        hidden_reversal_um: hidden,
        doubts,
        labels,
        runs,
        zeroed_runs,
        means: measured,
    }
}

/// The readings that are separated: without the jumps of a turn.
fn separable<'a>(measured: &'a Means, volume: &Volume, turned: bool) -> Cow<'a, Means> {
    if turned {
        Cow::Owned(without_jumps(measured, volume))
    } else {
        Cow::Borrowed(measured)
    }
}

fn solve_readings(
    campaign: &Campaign<'_>,
    budget: &Budget<'_>,
    means: &Means,
) -> (Solved, Vec<PerTerm<Curve>>) {
    let volume = budget.volume;
    let groups = means.groups();
    let increments: Vec<Increments> = groups
        .iter()
        .map(|group| means.increments(volume, *group))
        .collect();
    let raw: Vec<PerTerm<Curve>> = increments.iter().map(|m| curves(volume, m)).collect();
    let solved = Solved::new(campaign, budget, &increments, &raw);
    (solved, raw)
}

/// Nine curves (without regard to direction, without uncertainties) and squareness of mean
/// readings as measured: what a trial of a simulation repeats.
pub fn curves_of(
    campaign: &Campaign<'_>,
    budget: &Budget<'_>,
    means: &Means,
) -> (NineErrors, PerPlane<Option<f64>>) {
    let means = separable(means, budget.volume, budget.turned);
    let (solved, _) = solve_readings(campaign, budget, &means);
    let mean = PerTerm::from_fn(|term| {
        let curve = solved.turned(term, &solved.mean_raw[term])?;
        Some(Evidence::new(curve, None))
    });
    let errors = NineErrors {
        mean,
        plus: None,
        minus: None,
    };
    (errors, solved.squareness(campaign.measurement.setup))
}

/// Repeats say most; a stated noise comes next; a single run is left with its closure.
fn known_noise(stated: &StatedUncertainty, repeats: Option<Noise>) -> Option<Noise> {
    let stated = stated.noise_um.map(|sigma_um| Noise {
        sigma_um,
        freedom: None,
        source: NoiseSource::Stated,
    });
    repeats.or(stated)
}

/// Slopes and what they come from.
struct Solved {
    volume: Volume,
    setup: SetUp,
    frame: Frame,
    mean_raw: PerTerm<Curve>,
    ratios: PerDiagonal<PerAxis<f64>>,
    metric: Metric,
    ends_um: PerDiagonal<f64>,
    totals: Totals,
    u_end_um_per_m: f64,
    lines: Vec<StraightLine>,
}

impl Solved {
    fn new(
        campaign: &Campaign<'_>,
        budget: &Budget<'_>,
        increments: &[Increments],
        raw: &[PerTerm<Curve>],
    ) -> Solved {
        let measurement = campaign.measurement;
        let volume = &measurement.volume;
        let means = mean_increments(increments);
        let ratios = displacement_ratios(volume, &means);
        let length_m = volume.diagonal_mm() / 1000.0;
        let u_end = budget
            .u_end_um(increments.len() == 2)
            .map(|u| u / length_m)
            .filter(|u| *u > 0.0);
        let u_end = u_end.unwrap_or(WEIGHT_UM_PER_M);
        let line = |line: &Line| StraightLine {
            direction: line.direction,
            slope_um_per_m: line.slope_um_per_m,
            u_um_per_m: line.u_um_per_m.filter(|u| *u > 0.0).unwrap_or(u_end),
        };
        let lines: Vec<StraightLine> = campaign.lines.iter().map(line).collect();
        let end = |d: Diagonal| {
            let of_axis = |axis: Axis| volume.steps_f64() * means[d][axis];
            Axis::ALL.into_iter().map(of_axis).sum::<f64>()
        };
        let ends_um = PerDiagonal::from_fn(end);
        Solved {
            volume: volume.clone(),
            setup: measurement.setup,
            frame: measurement.frame,
            mean_raw: PerTerm::from_fn(|term| {
                mean(&raw.iter().map(|group| &group[term]).collect::<Vec<_>>())
            }),
            metric: solve(volume, &ratios, u_end, &lines),
            ratios,
            totals: totals(volume, &ends_um),
            ends_um,
            u_end_um_per_m: u_end,
            lines,
        }
    }

    fn naive_slopes(&self, volume: &Volume) -> PerTerm<f64> {
        PerTerm::from_fn(|term| end_slope(volume, term.along, &self.mean_raw[term]))
    }

    fn squareness(&self, setup: SetUp) -> PerPlane<Option<f64>> {
        match setup {
            SetUp::Solve => self.metric.squareness,
            SetUp::AssumePerfect => PerPlane {
                xy: Some(self.totals.squareness_um_per_m.xy),
                xz: Some(self.totals.squareness_um_per_m.xz),
                yz: Some(self.totals.squareness_um_per_m.yz),
            },
        }
    }

    /// Slope of a term, µm/m; `None` = not determined.
    fn slope(&self, term: ErrorTerm) -> Option<f64> {
        let naive = |term: ErrorTerm| end_slope(&self.volume, term.along, &self.mean_raw[term]);
        match (self.setup, self.frame) {
            (SetUp::Solve, Frame::XPrimary) => self.metric_slope(term),
            (SetUp::Solve, Frame::AsMeasured) if term.is_positioning() => {
                self.metric.scale[term.along]
            }
            // The rotation is that of the separated slopes, their sum that of the totals.
            (SetUp::Solve, Frame::AsMeasured) => {
                let twin = ErrorTerm {
                    of: term.along,
                    along: term.of,
                };
                let turn = (naive(term) - naive(twin)) / 2.0;
                Some(self.metric.squareness.of(plane_of(term))? / 2.0 + turn)
            }
            (SetUp::AssumePerfect, Frame::AsMeasured) => Some(naive(term)),
            (SetUp::AssumePerfect, Frame::XPrimary) if term.is_positioning() => Some(naive(term)),
            (SetUp::AssumePerfect, Frame::XPrimary) if carries_squareness(term) => {
                Some(self.totals.squareness_um_per_m.of(plane_of(term)))
            }
            (SetUp::AssumePerfect, Frame::XPrimary) => Some(0.0),
        }
    }

    fn metric_slope(&self, term: ErrorTerm) -> Option<f64> {
        if term.is_positioning() {
            self.metric.scale[term.along]
        } else if carries_squareness(term) {
            self.metric.squareness.of(plane_of(term))
        } else {
            Some(0.0)
        }
    }

    /// How scales and squareness change with the total of each diagonal, µm/m for each µm: a
    /// total grows by a part of the length when all measured steps along it do.
    fn gains(&self) -> PerDiagonal<Metric> {
        let part = DIFFERENCE_UM / (1000.0 * self.volume.diagonal_mm());
        PerDiagonal::from_fn(|d| {
            let mut ratios = self.ratios;
            ratios[d] = PerAxis::from_fn(|axis| (1.0 + part) * ratios[d][axis]);
            solve(&self.volume, &ratios, self.u_end_um_per_m, &self.lines)
        })
    }

    fn slope_from(&self, term: ErrorTerm, gains: &PerDiagonal<Metric>) -> SlopeFrom {
        let difference = |of: &dyn Fn(&Metric) -> Option<f64>| {
            let here = of(&self.metric).unwrap_or(0.0);
            let by =
                |d: Diagonal| of(&gains[d]).map_or(0.0, |there| (there - here) / DIFFERENCE_UM);
            PerDiagonal::from_fn(by)
        };
        let mut by_end = PerDiagonal::default();
        let u_um_per_m = match (self.setup, self.frame) {
            (SetUp::AssumePerfect, Frame::AsMeasured) => return SlopeFrom::Increments,
            (SetUp::AssumePerfect, Frame::XPrimary) if term.is_positioning() => {
                return SlopeFrom::Increments;
            }
            (SetUp::Solve, _) if term.is_positioning() => {
                by_end = difference(&|metric| metric.scale[term.along]);
                self.metric.u_scale(term.along)
            }
            (_, Frame::XPrimary) if !carries_squareness(term) => 0.0,
            _ => {
                by_end = difference(&|metric| metric.squareness.of(plane_of(term)));
                self.metric.u_squareness(plane_of(term))
            }
        };
        SlopeFrom::Elsewhere { u_um_per_m, by_end }
    }

    /// A separated curve with the slope of the mean curve put right.
    fn turned(&self, term: ErrorTerm, curve: &Curve) -> Option<Curve> {
        let raw_slope = end_slope(&self.volume, term.along, &self.mean_raw[term]);
        let change = self.slope(term)? - raw_slope;
        Some(plus_line(&self.volume, term.along, curve, change))
    }

    fn errors(
        &self,
        budget: &Budget<'_>,
        raw: &[PerTerm<Curve>],
        turn: Option<&Turn>,
    ) -> NineErrors {
        let gains = self.gains();
        let both_ways = raw.len() == 2;
        let along = |term: ErrorTerm, side: Side<'_>| {
            budget.curve(term, side, self.slope_from(term, &gains), both_ways)
        };
        let mean = PerTerm::from_fn(|term| {
            let curve = self.turned(term, &self.mean_raw[term])?;
            Some(Evidence::new(curve, along(term, Side::Mean)))
        });
        let directed = |direction: Direction| {
            let [plus, minus] = raw else { return None };
            let evidence = |term: ErrorTerm| {
                let mean = &mean[term].as_ref()?.deviation_um;
                let reversal = reversal(term, &plus[term], &minus[term], turn);
                let curve = directed_curve(mean, &reversal, direction);
                Some(Evidence::new(
                    curve,
                    along(term, Side::Moving(direction, turn)),
                ))
            };
            Some(PerTerm::from_fn(evidence))
        };
        NineErrors {
            plus: directed(Direction::Plus),
            minus: directed(Direction::Minus),
            mean,
        }
    }

    fn undetermined(&self, both_ways: bool, from_turn: bool) -> Vec<String> {
        let mut words = match self.setup {
            SetUp::Solve => self.metric.undetermined(),
            SetUp::AssumePerfect => Vec::new(),
        };
        if both_ways && !from_turn {
            words.push(
                "reversal of each axis: a turn with overrun (or with a zero of its own) holds at most its sum along the diagonals; turn once without overrun, or measure each axis in both directions".to_string(),
            );
        }
        words
    }
}

/// B of a term along its axis, µm: from the turn, else against its unknown value at the low end.
fn reversal(term: ErrorTerm, plus: &[f64], minus: &[f64], turn: Option<&Turn>) -> Vec<f64> {
    let walk: Vec<f64> = plus.iter().zip(minus).map(|(p, m)| p - m).collect();
    match turn {
        Some(turn) => turn.along(term, &walk),
        None => walk,
    }
}

/// The curve of a direction: the mean of both is that of curves which start at 0, and the − curve
/// lies B below the + curve.
fn directed_curve(mean: &[f64], reversal: &[f64], direction: Direction) -> Curve {
    let start = reversal.first().copied().unwrap_or(0.0);
    let value = |(mean, b): (&f64, &f64)| match direction {
        Direction::Plus => mean + (b - start) / 2.0,
        Direction::Minus => mean - (b + start) / 2.0,
    };
    mean.iter().zip(reversal).map(value).collect()
}

/// In the X-primary frame EXY, EXZ and EYZ carry the squareness of their plane.
fn carries_squareness(term: ErrorTerm) -> bool {
    term.of < term.along
}

fn plane_of(term: ErrorTerm) -> Plane {
    match (term.of.min(term.along), term.of.max(term.along)) {
        (Axis::X, Axis::Y) => Plane::Xy,
        (Axis::X, _) => Plane::Xz,
        _ => Plane::Yz,
    }
}

fn least_squares_squareness(
    volume: &Volume,
    errors: &PerTerm<Option<Evidence>>,
) -> PerPlane<Option<f64>> {
    let slope = |term: ErrorTerm| {
        let positions: Vec<f64> = volume
            .positions(term.along)
            .iter()
            .map(|p| p.mm())
            .collect();
        let curve = &errors[term].as_ref()?.deviation_um;
        Some(ReferenceLine::LeastSquares.slope_um_per_m(&positions, curve))
    };
    let of = |plane: Plane| {
        let (a, b) = plane.axes();
        Some(slope(ErrorTerm { of: a, along: b })? + slope(ErrorTerm { of: b, along: a })?)
    };
    PerPlane {
        xy: of(Plane::Xy),
        xz: of(Plane::Xz),
        yz: of(Plane::Yz),
    }
}

/// What is known of the reverse passes.
fn way_back(campaign: &Campaign<'_>, means: &Means, overrun: Option<bool>) -> Vec<String> {
    if means.reverse.is_none() {
        return vec!["forward passes only: NPP moves X in -, PNP moves Y in -, PPN moves Z in -, so reversal is mixed into the curves".into()];
    }
    let from = if campaign.measurement.overrun.is_some() {
        "as stated"
    } else {
        "judged from the readings"
    };
    let mut said = vec![match overrun {
        Some(true) => format!("the axes ran over the far end before the reverse passes ({from})"),
        Some(false) => format!("the axes turned at the far end without overrun ({from}): the lost motion is taken off the last cell of the reverse passes"),
        None => "whether the axes ran over the far end cannot be judged from the readings: no reversal stands out of their noise, or offset and jumps contradict each other. State `overrun`; until then a lost motion that is hidden in the noise may stand in the last interval".into(),
    }];
    if !campaign.reverse_zero_known {
        said.push(
            "reverse runs count from their own start, so only their increments are used".into(),
        );
    }
    said
}

/// What the turn's reversals rest on.
fn of_the_turn(turn: &Turn) -> String {
    let terms = ErrorTerm::ALL.into_iter();
    let kept: Vec<String> = terms
        .filter(|term| !term.is_positioning() && turn.in_curves[*term])
        .map(|term| term.to_string())
        .collect();
    let cross = if kept.is_empty() {
        "no reversal of a cross term stands out of its noise, so their - curves start at 0 like the + curves".to_string()
    } else {
        format!(
            "reversal of cross terms stands out of its noise in {}, taken as constant along the axis; the other - curves start at 0",
            kept.join(", ")
        )
    };
    format!(
        "reversal of each axis from the turn, at both ends of the axis (three diagonals turn at its high end, one at its low end); {cross}"
    )
}

fn labels(
    campaign: &Campaign<'_>,
    budget: &Budget<'_>,
    means: &Means,
    overrun: Option<bool>,
    turn: Option<&Turn>,
) -> Vec<String> {
    let measurement = campaign.measurement;
    let mut labels = Vec::new();
    if measurement.setup == SetUp::AssumePerfect {
        labels.push("set-up assumed perfect: mirror and beam exactly along the four diagonals; a tilt of 10 arcsec falsifies slopes by tens of um/m".to_string());
    }
    labels.push(match measurement.frame {
        Frame::XPrimary => "frame: X primary, XY plane secondary (EYX, EZX, EZY without slope; EXY, EXZ, EYZ carry the squareness)".to_string(),
        Frame::AsMeasured => "frame as measured: slopes of cross terms hold an arbitrary rotation; only their sums are the machine's".to_string(),
    });
    labels.extend(way_back(campaign, means, overrun));
    labels.extend(turn.map(of_the_turn));
    if means.reverse.is_some() {
        labels.push("directions are those in which each axis really moved: + curves from forward passes of the diagonals that travel it in +, reverse passes of the others".to_string());
    }
    if measurement
        .material
        .is_some_and(|material| !material.air_corrected)
    {
        labels.push("the readings are not corrected for air, and nothing corrects them here: about 1 um/m of scale for each K of air temperature or 3.7 hPa".to_string());
    }
    for axis in Axis::ALL {
        let gain = super::curves::noise_gain(&measurement.volume, axis);
        if gain > 3.0 {
            labels.push(format!("{axis} is a short edge of the box: noise of its deviations is {gain:.1} times that of an increment"));
        }
    }
    let bow = bow_um_per_urad(&measurement.volume, measurement.target);
    labels.extend(budget.sentences(campaign.angles.is_some(), &bow));
    if campaign.lines.iter().any(|line| line.u_um_per_m.is_none()) {
        labels.push(
            "a linear axis or beam states no uncertainty: it is weighed like a diagonal"
                .to_string(),
        );
    }
    labels
}
