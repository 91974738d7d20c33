//! Four body diagonals, walked in single-axis steps → nine errors, and what cannot be known.
//!
//! ```text
//!  readings ─→ corrections ─→ means over runs ─→ increments, filed under machine intervals
//!              temperature,    repeatability            │
//!              angles                  ┌────────────────┼─────────────────┐
//!                                      ▼                ▼                 ▼
//!                          shapes (formula 1)   closure (formula 2)   totals → metric (formula 7)
//!                                      │                │                 │   + linear axes, beams
//!                                      │         outliers, σ, χ²          ▼
//!                                      └───────────→ nine errors ←─── scales, squareness,
//!                                                       │             mirror tilt, rank
//!                                                       ▼
//!                                       uncertainty, Monte Carlo, report
//! ```
//! Reading errors are measured − nominal displacement along the laser, so an increment over a
//! step of axis k is, in the nine-error model (docs/method.md §3),
//!
//! ```text
//!   m_d = Σ_j s_dk s_dj (V_j/R) δ_j                        (d = PPP, NPP, PNP, PPN)
//!   δ_j = R/(4 V_j) Σ_d s_dk s_dj m_d                      (1)  least squares: the columns are orthogonal
//!   w   = Σ_d s_dk (s_x s_y s_z)_d m_d = 0                 (2)  what is left over: the closure
//! ```
//! A tilted mirror adds the same amount to every increment of a (diagonal, axis) pair. It leaves
//! the shapes of all nine curves alone and makes their slopes worthless; the slopes are taken
//! from the totals instead, see [`metric`].

pub mod campaign;
pub mod closure;
pub mod corrections;
pub mod curves;
mod exchange;
pub(crate) mod joint;
mod labels;
pub mod metric;
pub mod monte_carlo;
pub mod readings;
pub mod reversal;
pub mod solved;
mod start;
pub mod straight;
pub mod table;
mod uncertainty;

pub use self::campaign::{Campaign, MeasuredLine};
use self::campaign::{Estimate, LinearReversals};
use self::closure::{Closure, Patterns, closure, large_noise};
use self::corrections::AngleEvidence;
use self::curves::Curve;
use self::exchange::names;
use self::metric::{Agreement, LineCheck, Metric};
use self::readings::{Noise, NoiseSource, ReadingPlace};
use self::reversal::{Turn, contradictions, hidden_reversal_um, ran_over};
use self::solved::{CurvesAndSlopes, Tilt};
pub use self::solved::{NineErrors, SeparatedError};
use self::start::Start;
use self::uncertainty::of_length_ppm;
use crate::inputs::error_table::Silence;
use crate::inputs::job::{Frame, Material, SetUp, StatedUncertainty};
use crate::machine::findings::SeparationFinding;
use crate::quantity::{
    Axis, Deviation, Diagonal, Direction, ErrorTerm, Pass, PathKind, PerAxis, PerDiagonal, PerTerm,
    Run, Volume,
};
use crate::text::{Finding, Severity};
use nonius_numerics::rows::Model;
pub use nonius_numerics::rows::{Part, Uncertainty};

/// What a measurement of step diagonals says, and what it does not.
#[derive(Clone, Debug, PartialEq)]
pub struct Separation {
    /// The measured box.
    pub volume: Volume,
    /// What was assumed of the set-up.
    pub setup: SetUp,
    /// How the slopes of the cross terms are stated.
    pub frame: Frame,
    /// The nine errors.
    pub errors: NineErrors,
    /// What is uncertain of the readings and lines behind them.
    model: Model,
    /// What is known of angles.
    evidence: AngleEvidence,
    /// What speaks against the result by its size: of each, what its possible causes do to what was measured.
    anomalies: Vec<Vec<Vec<f64>>>,
    /// Their shapes beside the line through the ends, µm: determined whatever the set-up.
    pub shapes: PerTerm<Curve>,
    /// Slopes as they fall out of the increments, µm/m: they hold the tilt of the mirror.
    pub naive_slopes_um_per_m: PerTerm<f64>,
    /// What the job does not state and no uncertainty holds.
    pub silence: Silence,
    /// Scales; squareness, from the totals; rank.
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
    /// Reading error of each diagonal at the far end less that at the start, mean of all runs, µm.
    pub end_um: PerDiagonal<f64>,
    /// Whether the axes ran past the end point; `None` without reverse passes, and where neither the
    /// job nor the readings tell.
    pub overrun: Option<bool>,
    /// Reversals from a turn without overrun.
    pub turn: Option<Turn>,
    /// Reversals from linear measurements in both directions; none where the turn tells them.
    pub linear_reversals: LinearReversals,
    /// Reversal along the diagonals that cannot be told apart by axis, µm: no curve holds it.
    pub hidden_reversal_um: Option<f64>,
    /// What is not determined.
    pub undetermined: Vec<Finding>,
    /// Why the result is doubtful; empty = nothing speaks against it. Otherwise `separate` answers no,
    /// and a verdict on a kit made from it is undecided at most.
    pub doubts: Vec<Finding>,
    /// What was assumed and what the uncertainty holds.
    pub labels: Vec<Finding>,
    /// The corrected runs.
    pub runs: Vec<Run>,
    /// The runs whose zero is that of the forward run: all, or the forward passes only.
    pub zeroed_runs: Vec<Run>,
}

impl Separation {
    /// Whether every diagonal was walked in both directions.
    pub(crate) fn is_both_ways(&self) -> bool {
        self.model.layout.passes == 2
    }

    /// Whether the two directions of an axis stand apart in the error table: its reversal is
    /// determined.
    pub(crate) fn is_directed(&self, axis: Axis) -> bool {
        let known = self.turn.is_some() || self.linear_reversals[axis].is_some();
        known && self.errors.directed.is_some()
    }

    /// A term of the error table, in a direction or without. Cross terms of an axis whose reversal
    /// comes from its linear measurement are the mean of both directions.
    pub(crate) fn of_table(
        &self,
        term: ErrorTerm,
        direction: Option<Direction>,
    ) -> Option<&SeparatedError> {
        let cross = !term.is_positioning() && self.linear_reversals[term.along].is_some();
        let errors = match direction.filter(|_| !cross) {
            None => &self.errors.mean,
            Some(direction) => self.errors.directed(direction)?,
        };
        errors[term].as_ref()
    }

    /// The terms that the readings do not determine.
    pub fn missing(&self) -> Vec<ErrorTerm> {
        self.errors.mean.iter().filter(|(_, of)| of.is_none()).map(|(term, _)| term).collect()
    }

    /// Whether all nine errors are determined and nothing speaks against them: the answer of
    /// `separate`.
    pub fn stands(&self) -> bool {
        self.doubts.is_empty() && self.anomalies.is_empty() && self.missing().is_empty()
    }

    /// Rank and number of unknowns: of formula (7), or of the slopes where the set-up is assumed.
    pub const fn rank(&self) -> (usize, usize) {
        match self.setup {
            SetUp::Solve => (self.metric.rank, 6),
            SetUp::AssumePerfect => (9, 9),
        }
    }
}

/// Separates a complete measurement of step diagonals.
pub fn separate(campaign: &Campaign<'_>, raw_runs: &[Run]) -> Separation {
    let mut start = Start::new(campaign, raw_runs);
    let (closure, patterns) = judged(&mut start);
    let names = patterns.and_then(|patterns| names(&start, raw_runs, (&closure, patterns)));
    let noise = start.noise.filter(|_| start.both_ways() && campaign.reverse_zero_known);
    let seen = noise.and_then(|noise| ran_over(&start, noise));
    let turned = seen.zip(campaign.measurement.overrun).filter(|(seen, stated)| seen != stated);
    let turned = turned.map(|(ran_over, _)| SeparationFinding::OtherTurn { ran_over }.into());
    let mut found = evaluated(start, closure);
    found.doubts.extend(turned);
    // What remains to be said: noise, lines and reversals, the names of the diagonals.
    let turn = found.turn.iter().flat_map(|turn| contradictions(turn, &campaign.reversals));
    found.doubts.extend(large_noise(found.noise, campaign.stated.noise_um).into_iter().chain(turn));
    match names {
        Some(names) if names.severity() > Severity::Note => found.doubts.insert(0, names),
        blind => found.labels.extend(blind),
    }
    found
}

/// What the runs say together: whether the axes ran past the end point, σ that counts. Their closure.
fn judged(start: &mut Start<'_>) -> (Closure, Option<Patterns>) {
    start.overrun = overrun(start);
    let (closure, patterns) = closure(start);
    start.set_noise(noise_of(start, &closure));
    (closure, patterns)
}

/// Whether the axes ran past the end point: as stated, else as the readings tell.
fn overrun(start: &Start<'_>) -> Option<bool> {
    let (campaign, backs) = (start.campaign, start.both_ways());
    let noise = || start.known.or_else(|| closure(start).0.noise());
    let judged = || ran_over(start, campaign.reverse_zero_known.then(noise)??);
    backs.then(|| campaign.measurement.overrun.or_else(judged))?
}

/// σ that counts. Where repeated runs agree better with each other than the closure lets the readings be, they
/// differ from one walk to the next by more than repeats show, and the closure's counts.
fn noise_of(start: &Start<'_>, closure: &Closure) -> Option<Noise> {
    let of_scatter = closure.noise().map(|found| {
        let sigma_um = start.expected_um.unwrap_or(found.sigma_um);
        Noise { sigma_um, ..found }.with_stated(start.campaign.stated.noise_um)
    });
    let is_larger = |found: &Noise| closure.test(found).is_some_and(|test| test.is_larger());
    let found = start.known.filter(|noise| noise.source != NoiseSource::Stated);
    found.filter(|found| !is_larger(found)).or(of_scatter).or(start.known)
}

/// What speaks against the noise of repeated runs, and against the stated one.
fn of_noise(start: &Start<'_>) -> impl Iterator<Item = SeparationFinding> {
    let found = start.noise.filter(|noise| noise.source != NoiseSource::Stated);
    let repeated = start.known.filter(|noise| noise.source == NoiseSource::Repeats);
    let scatter = found.zip(repeated).filter(|(found, repeated)| found.source != repeated.source);
    let scatter = scatter.map(|(found, repeated)| {
        let (um, repeated_um) = (found.sigma_um, repeated.sigma_um);
        SeparationFinding::Scatter { um, repeated_um }
    });
    let stated = found.zip(start.campaign.stated.noise_um);
    let stated = stated.filter(|(noise, stated_um)| noise.contradicts(*stated_um));
    let contradicted =
        |(noise, stated_um)| SeparationFinding::NoiseContradicted { noise, stated_um };
    scatter.into_iter().chain(stated.map(contradicted))
}

/// Disturbed readings; ramps of the closure beyond noise and stated angles; equations that contradict each other.
fn anomalies(
    start: &Start<'_>,
    closure: &Closure,
    agreement: Option<&Agreement>,
) -> Vec<Vec<Vec<f64>>> {
    let layout = start.model.layout;
    let single = |place: usize, size: f64| {
        let mut column = vec![0.0; layout.entries()];
        column[place] = size;
        column
    };
    let place = |of: &ReadingPlace| layout.reading(of.pass, of.diagonal, of.node);
    let disturbed = closure.outliers.iter().map(|outlier| {
        outlier.readings.iter().map(place).map(|place| single(place, outlier.of_mean_um)).collect()
    });
    let roll = closure.ramps.iter().filter(|ramps| ramps.roll);
    let roll = roll.flat_map(|ramps| start.rolls(&ramps.beyond_um));
    let refuted = agreement.filter(|agreement| agreement.contradiction.is_some());
    let refuted = refuted.map(|agreement| {
        let equations = agreement.diagonals.iter().chain(&agreement.lines).enumerate();
        let by = |(at, one): (usize, &LineCheck)| Some((at, one.false_by_um_per_m()?));
        equations.filter_map(by).map(|(at, by)| single(layout.neglected(at), by)).collect()
    });
    disturbed.chain(roll).chain(refuted).collect()
}

/// What readings say.
fn evaluated(start: Start<'_>, closure: Closure) -> Separation {
    let (campaign, noise) = (start.campaign, start.noise);
    let (measurement, turned) = (campaign.measurement, start.turned());
    let mut solved = CurvesAndSlopes::new(start);
    let agreement = solved.judged();
    let turn = turned.then(|| solved.turn()).flatten();
    let reversals = if turned { LinearReversals::default() } else { campaign.reversals.clone() };
    let apart = solved.apart(turn.as_ref(), &reversals);
    let errors = solved.errors(&apart);
    let start = &solved.start;
    let anomalies = anomalies(start, &closure, agreement.as_ref());
    let labels = labels::of_steps(start, turn.as_ref())
        .chain(labels::of_reversals(&reversals, !start.both_ways()))
        .chain(solved.labels(agreement.is_some()));
    let mut labels: Vec<Finding> = labels.map(Finding::from).collect();
    let perfect = noise.filter(|_| measurement.setup == SetUp::AssumePerfect);
    let of_closure = closure.doubts(start.volume(), perfect).into_iter();
    let contradiction = agreement.as_ref().and_then(|of| of.contradiction.clone());
    // What no known cause makes has no size.
    let has_size = !anomalies.iter().any(Vec::is_empty);
    let (of_size, doubts): (Vec<Finding>, Vec<Finding>) = of_closure
        .chain(contradiction)
        .partition(|found| has_size && found.severity() == Severity::Note);
    labels.extend(of_size);
    labels.extend(of_noise(start).map(Finding::from));
    let hides = start.overrun == Some(true) && campaign.reverse_zero_known;
    let hidden = hides.then(|| hidden_reversal_um(start, &reversals));
    Separation {
        volume: measurement.volume.clone(),
        setup: measurement.setup,
        frame: measurement.frame,
        shapes: solved.shapes(),
        silence: campaign.silence(),
        tilts: solved.tilts(),
        undetermined: solved.undetermined(turn.is_some(), &reversals),
        naive_slopes_um_per_m: solved.naive,
        doubts,
        anomalies,
        labels,
        agreement,
        errors,
        closure,
        noise,
        end_um: solved.ends_um,
        turn,
        hidden_reversal_um: hidden.flatten(),
        linear_reversals: reversals,
        metric: solved.metric,
        zeroed_runs: start.zeroed_runs(),
        overrun: start.overrun,
        runs: solved.start.runs,
        model: solved.start.model,
        evidence: campaign.angles.evidence.clone(),
    }
}

/// What is expected of a measurement before its readings exist: deviations of 0, with the uncertainties
/// that this many runs of these passes will have. `noise_um`: σ of a single reading. Whether the axes
/// overrun has to be stated where the return pass is one of the passes. `change_um`: by how much the reversals are
/// known to change along their axes.
pub(crate) fn expected(
    campaign: &Campaign<'_>,
    passes: &[Pass],
    runs: u32,
    noise_um: f64,
    change_um: &PerTerm<f64>,
) -> Separation {
    let nodes = campaign.measurement.volume.last_node(PathKind::Step) + 1;
    let walks = (1..=runs).flat_map(|number| passes.iter().map(move |pass| (number, *pass)));
    let run = |(number, pass), diagonal| Run {
        diagonal,
        number,
        pass,
        deviations: vec![Deviation::from_um(0.0); nodes],
        temperatures_c: PerAxis::default(),
    };
    let all = walks.flat_map(|walk| Diagonal::ALL.map(|diagonal| run(walk, diagonal)));
    let mut start = Start::of(campaign, all.collect(), campaign.measurement.material);
    start.known = start.known.map(|noise| Noise { sigma_um: noise_um, ..noise });
    start.expected_um = Some(noise_um);
    start.change_um.clone_from(change_um);
    let (closure, _) = judged(&mut start);
    evaluated(start, closure)
}

/// What a laser does wherever it measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Instrument {
    /// σ of a single reading, µm.
    pub(crate) noise_um: f64,
    /// `[measurement.uncertainty]`.
    pub(crate) stated: StatedUncertainty,
}

impl Instrument {
    /// Standard uncertainty of the mean of so many runs at one position, µm.
    fn of_mean_um(self, runs: u32) -> f64 {
        self.noise_um / f64::from(runs).sqrt()
    }

    /// The reversal of an axis of 0 as so many runs in both directions at the positions of the diagonals tell it.
    pub(crate) fn reversal(self, volume: &Volume, runs: u32) -> Vec<Estimate> {
        let u_um = std::f64::consts::SQRT_2 * self.of_mean_um(runs);
        vec![Estimate { um: 0.0, u_um: Some(u_um) }; volume.steps + 1]
    }

    /// Standard uncertainty of the slope over a whole axis, from so many runs in both directions, µm/m.
    ///
    /// formula  u² = 2σ²/(2r L²) + scale²: the mean of both directions at both ends
    pub(crate) fn of_slope_um_per_m(
        self,
        (volume, material): (&Volume, Option<Material>),
        axis: Axis,
        runs: u32,
    ) -> f64 {
        let ends = 1000.0 * self.of_mean_um(runs) / volume.size[axis].mm();
        ends.hypot(of_length_ppm(self.stated, material, axis))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Millimetres;

    /// The scale of a set-up counts for each line by itself (docs/method.md §7).
    #[test]
    fn the_slope_of_a_line_is_as_certain_as_noise_laser_and_beam_are() {
        let size = PerAxis::from_fn(|_| Millimetres::new(400.0));
        let volume = Volume { start: size, size, steps: 4, order: Axis::ALL };
        let stated = StatedUncertainty { setup_ppm: Some(2.3), ..StatedUncertainty::default() };
        let instrument = Instrument { noise_um: 0.3, stated };
        let found = instrument.of_slope_um_per_m((&volume, None), Axis::X, 5);
        // Of both directions, as σ √(2/(2·5)) / 0.4 m: 0.335; of the laser and of the beam 0.5 each.
        let expected = 0.335_f64.hypot(0.5).hypot(0.5);
        assert!((found - expected).abs() < 1e-3, "{found} {expected}");
    }
}
