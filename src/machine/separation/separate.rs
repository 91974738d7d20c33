//! A whole measurement of step diagonals, from its runs to the nine errors.

use crate::machine::separation::angle_bound::counted_angles;

use super::agreement::Agreement;
use super::campaign::{Campaign, corrected};
use super::closure::{Closure, Known, closure};
use super::corrections::recorded;
use super::curves::{Curve, with_slope};
use super::evidence::{Evidence, NineErrors, least_squares_squareness};
use super::exchange::{AsRead, names};
use super::increments::{Group, Means};
use super::labels::labels;
use super::linear_reversal::{self, LinearReversals};
use super::metric::{Metric, PerPlane, Plane};
use super::noise::{CorrectedRun, Noise, coverage_factor, known_noise, means, run_counts};
use super::not_counted::{Figures, NotCounted};
use super::repeats::repeats;
use super::reversal::{Turn, ran_over, separable, turn};
use super::solved::{naive_squareness, solve_readings};
use super::straight::{DiagonalFigures, figures};
use super::tilt::{Tilt, tilts};
use super::uncertainty::Budget;
use super::{doubt, unmeasured};
use crate::inputs::job::{Material, SetUp};
use crate::machine::separation::evidence::set_apart;
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerTerm};
use crate::quantity::diagonal::{Diagonal, Pass, PathKind, PerDiagonal, Run, Volume};

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
    /// What the job does not state and no uncertainty holds.
    pub not_counted: NotCounted,
    /// Effective degrees of freedom of that; `None` = unlimited, or not known.
    pub squareness_freedom: PerPlane<Option<f64>>,
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
    /// Whether the axes ran over the far end; `None` without reverse passes, and where neither the
    /// job nor the readings tell.
    pub overrun: Option<bool>,
    /// Reversals from a turn without overrun.
    pub turn: Option<Turn>,
    /// Reversals from linear measurements in both directions; none where the turn tells them.
    pub linear_reversals: LinearReversals,
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
    /// Expansion of the scales at the mean of the recorded temperatures.
    pub material: Option<Material>,
    /// The corrected runs.
    pub runs: Vec<CorrectedRun>,
    /// The runs whose zero is that of the forward run: all, or the forward passes only.
    pub zeroed_runs: Vec<CorrectedRun>,
    /// The mean readings as measured; jumps of a turn are still in them.
    pub means: Means,
}

impl Separation {
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
    ) -> Option<&Evidence> {
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
        self.doubts.is_empty() && self.missing().is_empty()
    }

    /// φ as the sum of two separated slopes, µm/m: it holds the tilt of the mirror.
    pub(crate) fn naive_squareness_um_per_m(&self, plane: Plane) -> f64 {
        naive_squareness(&self.naive_slopes_um_per_m, plane)
    }

    /// U of φ, µm/m: its uncertainty with the coverage factor of its degrees of freedom.
    pub fn expanded_squareness_um_per_m(&self, plane: Plane) -> Option<f64> {
        let k = coverage_factor(self.squareness_freedom.of(plane));
        self.u_squareness_um_per_m.of(plane).map(|u| k * u)
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

/// Separates a complete measurement of step diagonals.
pub fn separate(campaign: &Campaign<'_>, raw_runs: &[Run]) -> Separation {
    let measurement = campaign.measurement;
    let volume = &measurement.volume;
    let material = measurement.material;
    let material = material.map(|material| recorded(&material, raw_runs));
    let runs = corrected(campaign, raw_runs);
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
        material,
    };
    let (mut solved, raw) = solve_readings(campaign, &budget, &means);
    let agreement = solved.agreement(&budget);
    let refuted = agreement.as_ref().is_some_and(Agreement::is_refuted);
    if refuted {
        solved.metric.u_known = Default::default();
    }
    let gains = solved.gains(&budget);
    let turn = turn(&measured, volume, &counts, noise).filter(|_| turned);
    let mut errors = solved.errors(&budget, &gains, &raw, turn.as_ref());
    let reversals = campaign.reversals.clone();
    let reversals = if turned {
        LinearReversals::default()
    } else {
        reversals
    };
    set_apart(&mut errors, &reversals);
    let slope_gains = solved.slope_gains(&gains);
    let angles = campaign.angle_evidence();
    let angles = angles.bound(volume, measurement.target, &slope_gains);
    unmeasured::book(
        &mut errors,
        volume,
        &campaign.stated,
        angles.as_ref(),
        &|term| solved.keeps_separated_slope(term),
    );
    let counted = counted_angles(angles.as_ref(), &campaign.stated);
    let u_squareness = solved.u_squareness(&budget, &gains, &counted);
    let figures_of = Figures {
        volume,
        errors: &errors,
        u_squareness: u_squareness.map(|u| Some(u?.u_um_per_m)),
        gains: &slope_gains,
    };
    let reflector = measurement.target;
    let not_counted = NotCounted::of(&figures_of, &campaign.stated, reflector, angles.as_ref());
    let zeroed = |run: &&CorrectedRun| campaign.reverse_zero_known || run.pass == Pass::Forward;
    let zeroed_runs: Vec<CorrectedRun> = runs.iter().filter(zeroed).cloned().collect();
    let (mut diagonals, range_over_all_um) = figures(&zeroed_runs, PathKind::Step);
    for diagonal in Diagonal::ALL {
        diagonals[diagonal].end_um = solved.ends_um[diagonal];
    }
    let mut labels = labels(campaign, &budget, &means, overrun, turn.as_ref());
    labels.extend(linear_reversal::label(
        &reversals,
        measured.reverse.is_none(),
    ));
    labels.extend(solved.labels(agreement.is_some()));
    let mut doubts = doubt::of_closure(&closure, noise, volume, measurement.setup);
    let as_read = AsRead {
        closure: &closure,
        noise,
        overrun,
    };
    let names = names(campaign, raw_runs, &as_read);
    doubts.splice(0..0, names.doubt);
    doubts.extend(doubt::of_noise(noise, campaign.stated.noise_um));
    labels.extend(names.blind);
    doubts.extend(agreement.as_ref().and_then(Agreement::contradiction));
    let of_turn = turn.iter();
    doubts.extend(
        of_turn.flat_map(|turn| linear_reversal::contradictions(turn, &campaign.reversals)),
    );
    let hidden = (overrun == Some(true) && campaign.reverse_zero_known)
        .then(|| doubt::hidden_reversal_um(&measured, noise, volume, &reversals))
        .flatten();
    Separation {
        volume: volume.clone(),
        setup: measurement.setup,
        shapes: PerTerm::from_fn(|term| {
            with_slope(volume, term.along, &solved.mean_raw[term], 0.0)
        }),
        naive_slopes_um_per_m: solved.naive_slopes(volume),
        squareness_um_per_m: solved.squareness(measurement.setup),
        not_counted,
        u_squareness_um_per_m: u_squareness.map(|u| Some(u?.u_um_per_m)),
        squareness_freedom: u_squareness.map(|u| u?.freedom),
        squareness_least_squares_um_per_m: least_squares_squareness(volume, &errors.mean),
        tilts: tilts(volume, &solved.ratios, &solved.metric)
            .filter(|_| measurement.setup == SetUp::Solve && !refuted),
        undetermined: solved.undetermined(turn.is_some(), &reversals),
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
        linear_reversals: reversals,
        hidden_reversal_um: hidden,
        doubts,
        labels,
        runs,
        zeroed_runs,
        means: measured,
    }
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
