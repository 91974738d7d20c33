//! A whole measurement of step diagonals, from its runs to the nine errors.

use super::agreement::{Agreement, agreement};
use super::closure::{Closure, closure};
use super::corrections::{
    AngleEffects, bow_um_per_urad, recorded, without_angles, without_expansion,
};
use super::curves::{Curve, curves, end_slope, mean, plus_line, with_slope};
use super::increments::{Group, Increments, Means, mean_increments};
use super::line::ReferenceLine;
use super::lookup::at;
use super::metric::{Metric, PerPlane, Plane, StraightLine, displacement_ratios, solve};
use super::noise::{CorrectedRun, Noise, NoiseSource, from_repeats, means, run_counts};
use super::reversal::{Turn, ran_over, turn, without_jumps};
use super::straight::{DiagonalFigures, Totals, figures, totals};
use super::tilt::{Tilt, tilts};
use super::uncertainty::{Budget, SlopeFrom};
use crate::axis::{Axis, Direction, ErrorTerm, PerAxis, PerTerm};
use crate::diagonal::{Diagonal, Pass, PathKind, PerDiagonal, Run, Volume};
use crate::job::{DiagonalMeasurement, Frame, LinearSlope, Material, SetUp, StatedUncertainty};
use crate::units::Millimetres;

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
    pub u_squareness_um_per_m: PerPlane<Option<f64>>,
    /// φ of least squares lines through the separated curves, µm/m.
    pub squareness_least_squares_um_per_m: PerPlane<Option<f64>>,
    /// Scales, squareness, rank.
    pub metric: Metric,
    /// Whether linear axes, beams and diagonals agree; `None` where nothing is redundant or the
    /// set-up is assumed.
    pub agreement: Option<Agreement>,
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
    /// Expansion of the scales at the mean of the recorded temperatures.
    pub material: Option<Material>,
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

    /// What forbids to trust the result, in words.
    pub fn contradiction(&self) -> Option<String> {
        self.agreement.as_ref()?.contradiction()
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
    /// Where it begins and ends, inside the box (machine coordinates); `None` = every axis that
    /// moves goes from end to end of the box.
    pub ends: Option<[PerAxis<Millimetres>; 2]>,
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
    let material = measurement
        .material
        .map(|material| recorded(&material, runs));
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
        material,
    };
    let groups = means.groups();
    let (mut solved, raw) = solve_readings(campaign, &budget, &means);
    let agreement = solved.agreement(&budget, groups);
    if agreement.as_ref().is_some_and(Agreement::is_refuted) {
        solved.metric.u_known = Default::default();
    }
    let change = PerTerm::from_fn(|term| change_um(&raw, term));
    let turn = turn(&measured, volume, &change).filter(|_| turned);
    let errors = solved.errors(&budget, groups, &raw, turn.as_ref());
    let zeroed = |run: &&CorrectedRun| campaign.reverse_zero_known || run.pass == Pass::Forward;
    let zeroed_runs: Vec<CorrectedRun> = runs.iter().filter(zeroed).cloned().collect();
    let (mut diagonals, range_over_all_um) = figures(&zeroed_runs, PathKind::Step);
    for diagonal in Diagonal::ALL {
        diagonals[diagonal].end_um = solved.ends_um[diagonal];
    }
    let mut labels: Vec<String> = agreement
        .iter()
        .filter_map(Agreement::contradiction)
        .collect();
    labels.extend(self::labels(campaign, &budget, &means, overrun));
    labels.extend(solved.labels(agreement.is_some()));
    Separation {
        volume: volume.clone(),
        setup: measurement.setup,
        shapes: PerTerm::from_fn(|term| {
            with_slope(volume, term.along, &solved.mean_raw[term], 0.0)
        }),
        naive_slopes_um_per_m: solved.naive_slopes(volume),
        squareness_um_per_m: solved.squareness(measurement.setup),
        u_squareness_um_per_m: solved.u_squareness(&budget, groups),
        squareness_least_squares_um_per_m: least_squares_squareness(volume, &errors.mean),
        tilts: tilts(volume, &solved.ratios, &solved.metric)
            .filter(|_| measurement.setup == SetUp::Solve)
            .filter(|_| !agreement.as_ref().is_some_and(Agreement::is_refuted)),
        undetermined: solved.undetermined(means.reverse.is_some(), turn.is_some()),
        scale_sum_um_mm: solved.totals.scale_sum_um_mm,
        metric: solved.metric,
        agreement,
        material,
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
    let solved = Solved::new(campaign, budget, &increments, &raw, groups);
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

/// Slopes and what they come from.
struct Solved {
    volume: Volume,
    setup: SetUp,
    frame: Frame,
    mean_raw: PerTerm<Curve>,
    ratios: PerDiagonal<PerAxis<f64>>,
    lines: Vec<StraightLine>,
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
        groups: &[Group],
    ) -> Solved {
        let measurement = campaign.measurement;
        let volume = &measurement.volume;
        let means = mean_increments(increments);
        let ratios = displacement_ratios(volume, &means);
        let mean_raw = PerTerm::from_fn(|term| {
            mean(&raw.iter().map(|group| &group[term]).collect::<Vec<_>>())
        });
        let lines = campaign.lines.iter();
        let lines: Vec<StraightLine> = lines
            .map(|line| without_shapes(budget, groups, &mean_raw, line))
            .collect();
        let end = |d: Diagonal| {
            let of_axis = |axis: Axis| volume.steps_f64() * means[d][axis];
            Axis::ALL.into_iter().map(of_axis).sum::<f64>()
        };
        let ends_um = PerDiagonal::from_fn(end);
        Solved {
            volume: volume.clone(),
            setup: measurement.setup,
            frame: measurement.frame,
            mean_raw,
            metric: solve(volume, &ratios, &budget.totals(groups.len()), &lines),
            lines,
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

    /// Where the slope of a term comes from; `None` where its uncertainty is not known.
    fn slope_from(
        &self,
        budget: &Budget<'_>,
        groups: &[Group],
        term: ErrorTerm,
    ) -> Option<SlopeFrom> {
        let squareness = || self.u_squareness(budget, groups).of(plane_of(term));
        let u_um_per_m = match (self.setup, self.frame) {
            (SetUp::AssumePerfect, Frame::AsMeasured) => return Some(SlopeFrom::Increments),
            (SetUp::AssumePerfect, Frame::XPrimary) if term.is_positioning() => {
                return Some(SlopeFrom::Increments);
            }
            (SetUp::Solve, _) if term.is_positioning() => self.metric.u_scale(term.along)?,
            (SetUp::Solve, Frame::AsMeasured) => {
                (squareness()? / 2.0).hypot(budget.u_turn(term, groups)?)
            }
            (_, Frame::XPrimary) if !carries_squareness(term) => 0.0,
            _ => squareness()?,
        };
        Some(SlopeFrom::Elsewhere { u_um_per_m })
    }

    /// Standard uncertainty of φ, µm/m: the same that the cross terms carry.
    fn u_squareness(&self, budget: &Budget<'_>, groups: &[Group]) -> PerPlane<Option<f64>> {
        let totals = budget.u_squareness(groups.len());
        let of = |plane: Plane| match self.setup {
            SetUp::Solve => self.metric.u_squareness(plane).filter(|_| totals.is_some()),
            SetUp::AssumePerfect => totals.map(|u| u.of(plane)),
        };
        PerPlane {
            xy: of(Plane::Xy),
            xz: of(Plane::Xz),
            yz: of(Plane::Yz),
        }
    }

    /// The redundancy of (7); `None` where there is none or where the set-up is assumed.
    fn agreement(&self, budget: &Budget<'_>, groups: &[Group]) -> Option<Agreement> {
        if self.setup == SetUp::AssumePerfect || self.lines.is_empty() {
            return None;
        }
        let totals = budget.totals(groups.len());
        agreement(
            &self.volume,
            &self.ratios,
            &totals,
            &self.lines,
            &self.metric,
        )
    }

    /// What the solution of (7) rests on, in words.
    fn labels(&self, is_checked: bool) -> Vec<String> {
        let mut said = Vec::new();
        if self.setup == SetUp::AssumePerfect {
            return said;
        }
        if self.metric.is_complete() && !is_checked {
            said.push("nothing checks the linear axes and beams: with no redundancy a slope of the wrong sign or unit goes unnoticed; measure the third axis along its length".to_string());
        }
        if !self.metric.is_complete() {
            let of =
                |plane: Plane| format!("{} {:.3}", plane.key(), 10.0 * self.metric.leak.of(plane));
            said.push(format!(
                "the uncertainty of the squareness leaves out what is not determined of the scales: through the tilts of the mirror each 10 um/m of it moves the squareness by up to (um/m) {}",
                Plane::ALL.map(of).join(", ")
            ));
        }
        if self.frame == Frame::AsMeasured {
            said.push("uncertainties of the cross terms hold the noise of their rotation, not the tilt of the mirror that is in it".to_string());
        }
        said
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
                u_um: self
                    .slope_from(budget, groups, term)
                    .and_then(|slope| budget.mean_curve(term, groups, slope)),
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
                    u_um: self
                        .slope_from(budget, groups, term)
                        .and_then(|slope| budget.directed_curve(term, groups, slope, from_turn)),
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

/// A line with what the separated shapes contribute between its ends taken off: between places
/// x₁ and x₂ of each axis k, Σ_jk v_j (D_j(k)(x₂) − D_j(k)(x₁)) = L·vᵀhv + that of the shapes.
fn without_shapes(
    budget: &Budget<'_>,
    groups: &[Group],
    mean_raw: &PerTerm<Curve>,
    line: &Line,
) -> StraightLine {
    let volume = budget.volume;
    let (mut shape_um, mut variance, mut square_mm) = (0.0, 0.0, 0.0);
    if let Some([from, to]) = line.ends {
        square_mm = Axis::ALL
            .into_iter()
            .map(|axis| (to[axis] - from[axis]).mm().powi(2))
            .sum();
        for term in ErrorTerm::ALL {
            let [from, to] = [from, to].map(|end| end[term.along]);
            if from == to {
                continue;
            }
            let shape = with_slope(volume, term.along, &mean_raw[term], 0.0);
            let positions = volume.positions(term.along);
            let rise = at(&positions, &shape, to.mm()) - at(&positions, &shape, from.mm());
            let share = line.direction[term.of];
            shape_um += share * rise;
            let spread = budget.shape_variance(term, groups, from.mm(), to.mm());
            variance += share * share * spread.unwrap_or(0.0);
        }
    }
    let per_m = if square_mm > 0.0 {
        1000.0 / square_mm.sqrt()
    } else {
        0.0
    };
    StraightLine {
        direction: line.direction,
        slope_um_per_m: line.slope_um_per_m - per_m * shape_um,
        u_um_per_m: line.u_um_per_m.map(|u| u.hypot(per_m * variance.sqrt())),
    }
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

fn labels(
    campaign: &Campaign<'_>,
    budget: &Budget<'_>,
    means: &Means,
    overrun: Option<bool>,
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
    match overrun {
        None if means.reverse.is_some() => labels.push("reverse runs count from their own start, so only their increments are used".to_string()),
        None => labels.push("forward passes only: NPP moves X in -, PNP moves Y in -, PPN moves Z in -, so reversal is mixed into the curves".to_string()),
        Some(over) => {
            let from = if measurement.overrun.is_some() { "as stated" } else { "judged from the readings" };
            let what = if over { "the axes ran over the far end before the reverse passes" } else { "the axes turned at the far end without overrun: reversal of each axis from the turn, taken as constant in the end intervals" };
            labels.push(format!("{what} ({from})"));
        }
    }
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
    labels.extend(line_labels(campaign));
    labels
}

/// What is assumed of linear axes and beams.
fn line_labels(campaign: &Campaign<'_>) -> Vec<String> {
    let mut said = Vec::new();
    if campaign.lines.iter().any(|line| line.u_um_per_m.is_none()) {
        said.push("a linear axis or beam states no uncertainty: it is weighed like a diagonal, and neither an uncertainty nor a simulated interval is given where a result depends on it; add `u_um_per_m`".to_string());
    }
    if campaign.lines.iter().any(|line| line.u_um_per_m.is_some()) {
        said.push("`u_um_per_m` of linear axes and beams is taken to hold everything that is uncertain of them, laser and temperature included, apart from the diagonals".to_string());
    }
    let volume = &campaign.measurement.volume;
    let stated = campaign.measurement.linear.iter();
    let stated = stated.filter(|linear| matches!(linear.slope, LinearSlope::Stated(_)));
    let spans: Vec<String> = stated
        .map(|linear| {
            let low = volume.start[linear.axis].mm();
            let high = low + volume.size[linear.axis].mm();
            format!("{} {low} to {high} mm", linear.axis)
        })
        .collect();
    if !spans.is_empty() {
        said.push(format!(
            "stated slopes of linear axes are taken as those between the ends of the box ({}); give what was measured over another length as a `beam` with its two ends",
            spans.join(", ")
        ));
    }
    said
}
