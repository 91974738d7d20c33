//! A whole measurement of step diagonals, from its runs to the nine errors.

use super::closure::{Closure, closure};
use super::corrections::{AngleEffects, without_angles, without_expansion};
use super::curves::{Curve, curves, end_slope, mean, plus_line, with_slope};
use super::increments::{Group, Increments, Means, mean_increments};
use super::line::ReferenceLine;
use super::metric::{Metric, PerPlane, Plane, StraightLine, displacement_ratios, solve};
use super::noise::{CorrectedRun, Noise, NoiseSource, from_repeats, means, run_counts};
use super::reversal::{Turn, ran_over, turn, without_jumps};
use super::straight::{DiagonalFigures, Totals, figures, totals, u_squareness};
use super::tilt::{Tilt, tilts};
use super::uncertainty::{Budget, SlopeFrom};
use super::unmeasured::{self, AngleEvidence};
use crate::axis::{Axis, Direction, ErrorTerm, PerAxis, PerTerm};
use crate::diagonal::{Diagonal, Pass, PathKind, PerDiagonal, Run, Volume};
use crate::job::{DiagonalMeasurement, Frame, SetUp, StatedUncertainty};

/// Uncertainty that weighs totals and lines where neither noise nor a statement gives one, µm/m.
const WEIGHT_UM_PER_M: f64 = 1.0;

/// One separated curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Evidence {
    /// Deviations at the interval ends, lowest first, µm; the first is 0 (a − curve: the reversal).
    pub deviation_um: Curve,
    /// Standard uncertainties (k = 1) against the first position, µm; `None` = not known.
    pub u_um: Option<Vec<f64>>,
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
    /// Whether the axes ran over the far end; `None` without reverse passes.
    pub overrun: Option<bool>,
    /// Reversals from a turn without overrun.
    pub turn: Option<Turn>,
    /// S, µm·mm.
    pub scale_sum_um_mm: f64,
    /// What is not determined, in words.
    pub undetermined: Vec<String>,
    /// What was assumed and what the uncertainty holds, in words.
    pub labels: Vec<String>,
    /// The corrected runs.
    pub runs: Vec<CorrectedRun>,
    /// The runs whose zero is that of the forward run: all, or the forward passes only.
    pub zeroed_runs: Vec<CorrectedRun>,
    /// The mean readings that were separated.
    pub means: Means,
}

impl Separation {
    /// Whether the two directions stand apart in the error table: the reversal is determined.
    pub fn has_directed_table(&self) -> bool {
        self.turn.is_some() && self.errors.minus.is_some()
    }

    /// Rank and number of unknowns: of formula (7), or of the slopes where the set-up is assumed.
    pub const fn rank(&self) -> (usize, usize) {
        match self.setup {
            SetUp::Solve => (self.metric.rank, 6),
            SetUp::AssumePerfect => (9, 9),
        }
    }

    /// φ as the sum of two separated slopes, µm/m: it holds the tilt of the mirror.
    pub fn naive_squareness_um_per_m(&self, plane: Plane) -> f64 {
        naive_squareness(&self.naive_slopes_um_per_m, plane)
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

impl Campaign<'_> {
    /// What is known of the angular errors.
    pub fn angle_evidence(&self) -> AngleEvidence {
        let angles = self.angles.as_ref();
        angles.map_or_else(|| AngleEvidence::nothing(None), |a| a.evidence.clone())
    }
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
        let angles = campaign.angles.as_ref();
        if let Some(effect) = angles.and_then(|angles| angles.of(run.diagonal, run.pass)) {
            without_angles(&mut readings_um, effect);
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
    let repeats = from_repeats(&runs);
    let known = known_sigma(&campaign.stated, repeats);
    let guess = || {
        let sigma = || closure(volume, &measured, &counts, None, true).sigma_um();
        known.or_else(sigma).unwrap_or(0.0)
    };
    let overrun = measurement.overrun.filter(|_| measured.reverse.is_some());
    let overrun = overrun.or_else(|| {
        let judgeable = measured.reverse.is_some() && campaign.reverse_zero_known;
        judgeable.then(|| ran_over(&measured, volume, guess()))?
    });
    let turned = overrun == Some(false) && campaign.reverse_zero_known;
    let means = if turned {
        without_jumps(&measured, volume)
    } else {
        measured.clone()
    };
    let closure = closure(volume, &means, &counts, known, turned);
    let noise = noise(&campaign.stated, repeats, &closure);
    let budget = Budget {
        volume,
        noise,
        runs: &counts,
        stated: campaign.stated,
        material: measurement.material,
    };
    let groups = means.groups();
    let (solved, raw) = solve_readings(campaign, &budget, &means);
    let change = PerTerm::from_fn(|term| change_um(&raw, term));
    let turn = turn(&measured, volume, &change).filter(|_| turned);
    let mut errors = solved.errors(&budget, groups, &raw, turn.as_ref());
    unmeasured::book(
        &mut errors,
        volume,
        measurement.target,
        &campaign.stated,
        &campaign.angle_evidence(),
        &|term| solved.slope_from(term) == SlopeFrom::Increments,
    );
    let zeroed = |run: &&CorrectedRun| campaign.reverse_zero_known || run.pass == Pass::Forward;
    let zeroed_runs: Vec<CorrectedRun> = runs.iter().filter(zeroed).cloned().collect();
    let (mut diagonals, range_over_all_um) = figures(&zeroed_runs, PathKind::Step);
    for diagonal in Diagonal::ALL {
        diagonals[diagonal].end_um = solved.ends_um[diagonal];
    }
    let u_end = budget.u_end_um(groups.len());
    let labels = labels(campaign, &budget, &means, overrun, solved.frame_label());
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
        undetermined: solved.undetermined(means.reverse.is_some(), turn.is_some()),
        scale_sum_um_mm: solved.totals.scale_sum_um_mm,
        metric: solved.metric,
        errors,
        closure,
        noise,
        diagonals,
        range_over_all_um,
        overrun,
        turn,
        labels,
        runs,
        zeroed_runs,
        means,
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
    let solved = Solved::new(campaign, budget, &increments, &raw, groups.len());
    (solved, raw)
}

/// Nine curves (without regard to direction, without uncertainties) and squareness of mean
/// readings: what a trial of a simulation repeats.
pub fn curves_of(
    campaign: &Campaign<'_>,
    budget: &Budget<'_>,
    means: &Means,
) -> (NineErrors, PerPlane<Option<f64>>) {
    let (solved, _) = solve_readings(campaign, budget, means);
    let mean = PerTerm::from_fn(|term| {
        Some(Evidence {
            deviation_um: solved.turned(term, &solved.mean_raw[term])?,
            u_um: None,
        })
    });
    let errors = NineErrors {
        mean,
        plus: None,
        minus: None,
    };
    (errors, solved.squareness(campaign.measurement.setup))
}

/// Δ of the reversal of a term from the low end of its axis to the high end, µm.
fn change_um(raw: &[PerTerm<Curve>], term: ErrorTerm) -> f64 {
    match raw {
        [plus, minus] => plus[term]
            .last()
            .zip(minus[term].last())
            .map_or(0.0, |(p, m)| p - m),
        _ => 0.0,
    }
}

fn known_sigma(stated: &StatedUncertainty, repeats: Option<Noise>) -> Option<f64> {
    repeats.map(|noise| noise.sigma_um).or(stated.noise_um)
}

/// Repeats say most; a stated noise comes next; a single run is left with its closure.
fn noise(stated: &StatedUncertainty, repeats: Option<Noise>, closure: &Closure) -> Option<Noise> {
    let stated = stated.noise_um.map(|sigma_um| Noise {
        sigma_um,
        freedom: None,
        source: NoiseSource::Stated,
    });
    let scatter = closure.sigma_um().map(|sigma_um| Noise {
        sigma_um,
        freedom: Some(closure.freedom),
        source: NoiseSource::Closure,
    });
    repeats.or(stated).or(scatter)
}

/// Uncertainty of a total by its length, µm/m, and the lines with theirs. Where one is not known
/// it is a weight only.
pub(super) fn weighed_lines(
    campaign: &Campaign<'_>,
    u_end_um: Option<f64>,
) -> (f64, Vec<StraightLine>) {
    let length_m = campaign.measurement.volume.diagonal_mm() / 1000.0;
    let u_end = u_end_um.map(|u| u / length_m).filter(|u| *u > 0.0);
    let u_end = u_end.unwrap_or(WEIGHT_UM_PER_M);
    let line = |line: &Line| StraightLine {
        direction: line.direction,
        slope_um_per_m: line.slope_um_per_m,
        u_um_per_m: line.u_um_per_m.filter(|u| *u > 0.0).unwrap_or(u_end),
    };
    (u_end, campaign.lines.iter().map(line).collect())
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
}

impl Solved {
    fn new(
        campaign: &Campaign<'_>,
        budget: &Budget<'_>,
        increments: &[Increments],
        raw: &[PerTerm<Curve>],
        passes: usize,
    ) -> Solved {
        let measurement = campaign.measurement;
        let volume = &measurement.volume;
        let means = mean_increments(increments);
        let ratios = displacement_ratios(volume, &means);
        let (u_end, lines) = weighed_lines(campaign, budget.u_end_um(passes));
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

    fn slope_from(&self, term: ErrorTerm) -> SlopeFrom {
        let u_um_per_m = match (self.setup, self.frame) {
            (SetUp::AssumePerfect, Frame::AsMeasured) => return SlopeFrom::Increments,
            (SetUp::AssumePerfect, Frame::XPrimary) if term.is_positioning() => {
                return SlopeFrom::Increments;
            }
            (SetUp::Solve, _) if term.is_positioning() => self.metric.u_scale(term.along),
            (_, Frame::XPrimary) if !carries_squareness(term) => 0.0,
            _ => self.metric.u_squareness(plane_of(term)),
        };
        SlopeFrom::Elsewhere { u_um_per_m }
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
        groups: &[Group],
        raw: &[PerTerm<Curve>],
        turn: Option<&Turn>,
    ) -> NineErrors {
        let mean = PerTerm::from_fn(|term| {
            Some(Evidence {
                deviation_um: self.turned(term, &self.mean_raw[term])?,
                u_um: budget.mean_curve(term, groups, self.slope_from(term)),
            })
        });
        let directed = |group: usize, reversal: Option<&Turn>| {
            PerTerm::from_fn(|term| {
                let curve = self.turned(term, &raw[group][term])?;
                // The − curve lies B below the + curve.
                let offset = reversal.map_or(0.0, |turn| -turn.reversal_um[term]);
                let from_turn = reversal.is_some();
                Some(Evidence {
                    deviation_um: curve.iter().map(|value| value + offset).collect(),
                    u_um: budget.directed_curve(term, groups, self.slope_from(term), from_turn),
                })
            })
        };
        let both = raw.len() == 2;
        NineErrors {
            mean,
            plus: both.then(|| directed(0, None)),
            minus: both.then(|| directed(1, turn)),
        }
    }

    /// Where the curves keep the slopes of the increments, their squareness is another one than
    /// that of the totals.
    fn frame_label(&self) -> Option<String> {
        let kept = (self.setup, self.frame) == (SetUp::AssumePerfect, Frame::AsMeasured);
        let slopes = self.naive_slopes(&self.volume);
        kept.then(|| {
            format!(
                "the curves keep their separated slopes, whose squareness (µm/m: {}) holds the tilt of the mirror and the noise of all increments; that of the totals ({}) holds neither: believe the totals",
                planes_in_words(|plane| naive_squareness(&slopes, plane)),
                planes_in_words(|plane| self.totals.squareness_um_per_m.of(plane))
            )
        })
    }

    fn undetermined(&self, both_ways: bool, from_turn: bool) -> Vec<String> {
        let mut words = match self.setup {
            SetUp::Solve => self.metric.undetermined(),
            SetUp::AssumePerfect => Vec::new(),
        };
        if both_ways && !from_turn {
            words.push(
                "reversal of each axis: with overrun (or a zero of their own) the reverse runs hold at most its sum along the diagonals; reverse once without overrun and state `overrun = false`, or measure each axis in both directions".to_string(),
            );
        }
        words
    }
}

/// XY, XZ and YZ of a squareness in words, µm/m.
fn planes_in_words(of: impl Fn(Plane) -> f64) -> String {
    let words = Plane::ALL.map(|plane| {
        let value = (of(plane) * 1000.0).round() / 1000.0 + 0.0;
        format!("{} {value:.3}", plane.key().to_uppercase())
    });
    words.join(", ")
}

/// In the X-primary frame EXY, EXZ and EYZ carry the squareness of their plane.
fn carries_squareness(term: ErrorTerm) -> bool {
    term.of < term.along
}

/// φ as the sum of two separated slopes, µm/m.
fn naive_squareness(slopes_um_per_m: &PerTerm<f64>, plane: Plane) -> f64 {
    let (a, b) = plane.axes();
    let (one, other) = (ErrorTerm { of: a, along: b }, ErrorTerm { of: b, along: a });
    slopes_um_per_m[one] + slopes_um_per_m[other]
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

fn labels(
    campaign: &Campaign<'_>,
    budget: &Budget<'_>,
    means: &Means,
    overrun: Option<bool>,
    of_slopes: Option<String>,
) -> Vec<String> {
    let measurement = campaign.measurement;
    let mut labels = Vec::new();
    if measurement.setup == SetUp::AssumePerfect {
        let tilt = match campaign.stated.tilt_arcsec {
            Some(arcsec) => format!("included in U as {arcsec} arcsec (k = 1, tilt_arcsec) in each direction"),
            None => "not included, so that no U is given where the slope is a separated one: state `tilt_arcsec` in [measurement.uncertainty]".to_string(),
        };
        labels.push(format!("set-up assumed perfect: mirror and beam exactly along the four diagonals; a tilt of 10 arcsec falsifies slopes by tens of µm/m; it is {tilt}"));
    }
    labels.push(match measurement.frame {
        Frame::XPrimary => "frame: X primary, XY plane secondary (EYX, EZX, EZY without slope; EXY, EXZ, EYZ carry the squareness)".to_string(),
        Frame::AsMeasured => "frame as measured: slopes of cross terms hold an arbitrary rotation; only their sums, the squareness, are free of it".to_string(),
    });
    labels.extend(of_slopes);
    match overrun {
        None if means.reverse.is_some() => labels.push("reverse runs count from their own start, so only their increments are used".to_string()),
        None => labels.push("forward runs only: NPP moves X in -, PNP moves Y in -, PPN moves Z in -, so reversal is mixed into the curves".to_string()),
        Some(over) => {
            let from = if measurement.overrun.is_some() { "as stated" } else { "judged from the readings" };
            let what = if over { "the axes ran over the far end before the reverse runs" } else { "the axes turned at the far end without overrun: reversal of each axis from the turn, taken as constant in the end intervals" };
            labels.push(format!("{what} ({from})"));
        }
    }
    if means.reverse.is_some() {
        labels.push("directions are those in which each axis really moved: + curves from forward runs of the diagonals that travel it in +, reverse runs of the others".to_string());
    }
    for axis in Axis::ALL {
        let gain = super::curves::noise_gain(&measurement.volume, axis);
        if gain > 3.0 {
            labels.push(format!("{axis} is a short edge of the box: noise of its deviations is {gain:.1} times that of an increment"));
        }
    }
    labels.extend(common_labels(campaign, budget));
    labels
}

/// What is assumed of readings of any kind, and what their uncertainty holds.
pub(super) fn common_labels(campaign: &Campaign<'_>, budget: &Budget<'_>) -> Vec<String> {
    let measurement = campaign.measurement;
    let mut labels = Vec::new();
    if measurement
        .material
        .is_some_and(|material| !material.air_corrected)
    {
        labels.push("the readings are not corrected for air, and nothing corrects them here: about 1 µm/m of scale for each K of air temperature or 3.7 hPa".to_string());
    }
    labels.extend(budget.sentences());
    let (angles, stated) = (campaign.angle_evidence(), campaign.stated.angle_urad);
    let path = (measurement.kind, measurement.target);
    labels.extend(angles.sentences(&measurement.volume, path, stated));
    if campaign.lines.iter().any(|line| line.u_um_per_m.is_none()) {
        labels.push(
            "a linear axis or beam states no uncertainty: it is weighed like a diagonal"
                .to_string(),
        );
    }
    labels
}
