//! A whole measurement of step diagonals, from its runs to the nine errors; or one that is still to be made.
//!
//! ```text
//!   passes, runs ─→ corrected readings of 0 ─→ separation, σ = what is expected ─→ U, rank, what stays open
//! ```
//! Readings without any error go through the separation itself, so what it says of uncertainty, degrees of freedom and
//! what stays open is what it will say of the readings.

use super::campaign::{Campaign, LinearReversal, LinearReversals, Start};
use super::closure::{Closure, closure, large_noise};
use super::curves::Curve;
use super::exchange::names;
use super::findings::SeparationFinding;
use super::labels;
use super::linear::{Layout, Model};
use super::metric::Metric;
use super::noise::{Noise, NoiseSource, ReadingPlace};
use super::patterns::Patterns;
use super::reversal::{Turn, contradictions, hidden_reversal_um, ran_over};
use super::solved::{NineErrors, SeparatedError, Solved, Tilt};
use super::uncertainty::{Budget, of_length_ppm, rolls};
use crate::inputs::error_table::Silence;
use crate::inputs::job::{DiagonalMeasurement, Frame, SetUp, StatedUncertainty};
use crate::machine::separation::closure::Agreement;
use crate::quantity::{
    Axis, Deviation, Diagonal, Direction, ErrorTerm, Pass, PathKind, PerAxis, PerDiagonal, PerTerm,
    Run, Volume,
};
use crate::text::{Finding, Severity};

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
    pub(super) model: Model,
    /// What speaks against the result by its size: of each, what its possible causes do to what was measured.
    pub(super) anomalies: Vec<Vec<Vec<f64>>>,
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
        known && self.errors.minus.is_some()
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
        let terms = self.errors.mean.iter();
        let missing = terms.filter(|(_, found)| found.is_none());
        missing.map(|(term, _)| term).collect()
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
    let start = Start::new(campaign, raw_runs);
    let (mut found, patterns) = of_start(campaign, &start);
    // What remains to be said: the names of the diagonals, noise, lines and reversals.
    let budget = Budget { campaign, start: &start, noise: found.noise, overrun: found.overrun };
    let recorded = patterns.map(|patterns| (&found.closure, &found.model, patterns));
    let names = recorded.and_then(|recorded| names(&budget, raw_runs, recorded));
    let turn = found.turn.iter().flat_map(|turn| contradictions(turn, &campaign.reversals));
    found.doubts.extend(large_noise(found.noise, campaign.stated.noise_um).into_iter().chain(turn));
    match names {
        Some(names) if names.severity() > Severity::Note => found.doubts.insert(0, names),
        blind => found.labels.extend(blind),
    }
    found
}

/// What the runs say together.
fn of_start(campaign: &Campaign<'_>, start: &Start) -> (Separation, Option<Patterns>) {
    let budget = Budget { campaign, start, noise: None, overrun: overrun(campaign, start) };
    let model = budget.model();
    let (closure, patterns) = closure(&budget, Some(&model));
    let noise = noise_of(campaign, start, &closure);
    let mut separation = evaluated(&Budget { noise, ..budget }, closure, model);
    let notes = of_noise(start.noise, noise, campaign.stated.noise_um);
    separation.labels.extend(notes.map(Finding::from));
    (separation, patterns)
}

/// What speaks against the noise of repeated runs, and against the stated one.
fn of_noise(
    known: Option<Noise>,
    counts: Option<Noise>,
    stated_um: Option<f64>,
) -> impl Iterator<Item = SeparationFinding> {
    let found = counts.filter(|noise| noise.source != NoiseSource::Stated);
    let repeated = known.filter(|noise| noise.source == NoiseSource::Repeats);
    let scatter = found.zip(repeated).filter(|(found, repeated)| found.source != repeated.source);
    let scatter = scatter.map(|(found, repeated)| {
        let (um, repeated_um) = (found.sigma_um, repeated.sigma_um);
        SeparationFinding::Scatter { um, repeated_um }
    });
    let stated = found.zip(stated_um).filter(|(found, stated_um)| found.contradicts(*stated_um));
    let contradicted =
        |(noise, stated_um)| SeparationFinding::NoiseContradicted { noise, stated_um };
    scatter.into_iter().chain(stated.map(contradicted))
}

/// σ that counts. Where repeated runs agree better with each other than the closure lets the readings be, they
/// differ from one walk to the next by more than repeats show, and the closure's counts.
fn noise_of(campaign: &Campaign<'_>, start: &Start, closure: &Closure) -> Option<Noise> {
    let of_scatter = closure
        .noise()
        .map(|found| Noise { sigma_um: start.expected_um.unwrap_or(found.sigma_um), ..found });
    let found = start.noise.filter(|noise| noise.source != NoiseSource::Stated);
    let is_larger =
        found.and_then(|found| closure.test(&found)).is_some_and(|test| test.is_larger());
    match found.filter(|_| !is_larger) {
        Some(found) => Some(found),
        None => of_scatter.map(|found| found.with_stated(campaign.stated.noise_um)).or(start.noise),
    }
}

/// Disturbed readings; ramps of the closure beyond noise and stated angles; equations that contradict each other.
fn anomalies(
    budget: &Budget<'_>,
    layout: Layout,
    closure: &Closure,
    agreement: Option<&Agreement>,
) -> Vec<Vec<Vec<f64>>> {
    let single = |place: usize, size: f64| {
        let mut column = vec![0.0; layout.len()];
        column[place] = size;
        column
    };
    let place = |of: &ReadingPlace| layout.reading(of.pass, of.diagonal, of.node);
    let disturbed = closure.outliers.iter().map(|outlier| {
        let places = outlier.readings.iter().map(place);
        places.map(|place| single(place, outlier.of_mean_um)).collect()
    });
    let roll = closure.ramps.iter().filter(|ramps| ramps.is_roll());
    let roll = roll.flat_map(|ramps| rolls(budget, layout, &ramps.beyond_um));
    let refuted = agreement.filter(|agreement| agreement.is_refuted());
    let refuted = refuted.map(|agreement| {
        let by = agreement.false_by_um_per_m.iter().enumerate().filter(|(_, by)| **by > 0.0);
        by.map(|(index, by)| single(layout.neglected(index), *by)).collect()
    });
    disturbed.chain(roll).chain(refuted).collect()
}

/// What readings say.
fn evaluated(budget: &Budget<'_>, closure: Closure, model: Model) -> Separation {
    let Budget { campaign, start, noise, overrun } = *budget;
    let (volume, turned) = (budget.volume(), budget.turned());
    let mut solved = Solved::new(budget, model);
    let agreement = solved.judged();
    let turn = turned.then(|| solved.turn()).flatten();
    let reversals = if turned { LinearReversals::default() } else { campaign.reversals.clone() };
    let apart = solved.apart(turn.as_ref(), &reversals);
    let errors = solved.errors(&apart);
    let anomalies = anomalies(budget, solved.model.layout, &closure, agreement.as_ref());
    let labels = labels::of_steps(budget, turn.as_ref())
        .chain(labels::of_reversals(&reversals, !budget.both_ways()))
        .chain(solved.labels(agreement.is_some()));
    let mut labels: Vec<Finding> = labels.map(Finding::from).collect();
    let of_closure = closure.doubts(noise, volume, campaign.measurement.setup).into_iter();
    let contradiction = agreement.as_ref().and_then(Agreement::contradiction);
    // What no known cause makes has no size.
    let has_size = !anomalies.iter().any(Vec::is_empty);
    let (of_size, doubts): (Vec<Finding>, Vec<Finding>) = of_closure
        .chain(contradiction.map(Finding::from))
        .partition(|found| has_size && found.severity() == Severity::Note);
    labels.extend(of_size);
    let hides = overrun == Some(true) && campaign.reverse_zero_known;
    let hidden = hides.then(|| hidden_reversal_um(start, noise, volume, &reversals));
    Separation {
        volume: volume.clone(),
        setup: campaign.measurement.setup,
        frame: campaign.measurement.frame,
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
        model: solved.model,
        closure,
        noise,
        end_um: solved.ends_um,
        overrun,
        turn,
        hidden_reversal_um: hidden.flatten(),
        linear_reversals: reversals,
        metric: solved.metric,
        runs: start.runs.clone(),
        zeroed_runs: start.zeroed_runs(campaign.reverse_zero_known),
    }
}

/// Whether the axes ran past the end point: as stated, else as the readings tell.
fn overrun(campaign: &Campaign<'_>, start: &Start) -> Option<bool> {
    let budget = Budget { campaign, start, noise: None, overrun: None };
    let judged = || {
        let noise = start.noise.or_else(|| closure(&budget, None).0.noise());
        ran_over(&budget, noise?)
    };
    let stated = campaign.measurement.overrun;
    let found = || stated.or_else(|| campaign.reverse_zero_known.then(judged)?);
    budget.both_ways().then(found)?
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
    start.noise = start.noise.map(|noise| Noise { sigma_um: noise_um, ..noise });
    start.expected_um = Some(noise_um);
    start.change_um.clone_from(change_um);
    of_start(campaign, &start).0
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
    pub(crate) fn reversal(self, volume: &Volume, runs: u32) -> LinearReversal {
        let u_um = std::f64::consts::SQRT_2 * self.of_mean_um(runs);
        let places = volume.steps + 1;
        LinearReversal { um: vec![0.0; places], u_um: Some(vec![u_um; places]) }
    }

    /// Standard uncertainty of the slope over a whole axis, from so many runs in both directions, µm/m.
    ///
    /// formula  u² = 2σ²/(2r L²) + scale²: the mean of both directions at both ends
    pub(crate) fn of_slope_um_per_m(
        self,
        measurement: &DiagonalMeasurement,
        axis: Axis,
        runs: u32,
    ) -> f64 {
        let ends = 1000.0 * self.of_mean_um(runs) / measurement.volume.size[axis].mm();
        ends.hypot(of_length_ppm(self.stated, measurement.material, axis))
    }
}
