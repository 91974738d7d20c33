//! What the job says of the visit, and what one variant of it costs and gives.

use super::variant::{DIGITS, Variant, Visit, expanded_um};
use crate::inputs::error_table::ErrorTable;
use crate::inputs::job::{
    DiagonalMeasurement, GridRequest, Job, Linear, LinearSlope, MeasuredData, Measurement,
    ProgramRequest, RunType,
};
use crate::judge::forecast::range_of;
use crate::kit::refusals;
use crate::machine::separation::campaign::{NamedTables, campaign};
use crate::machine::separation::corrections::AngleEvidence;
use crate::machine::separation::{Instrument, Part, Separation, expected};
use crate::quantity::{
    Axis, Diagonal, ErrorTerm, Millimetres, Pass, PathKind, PerAxis, PerTerm, rounded,
};
use crate::text::{Problem, Problems};
use crate::write::program::motion;
use crate::write::target::wants;
use serde::Serialize;
use std::cell::RefCell;

/// Noise of a single reading where the job states none, µm: the largest that `separate` takes without a word.
pub(super) const NOISE_UM: f64 = 1.0;
/// More steps than these are no variant: no published measurement has more.
const MOST_STEPS: usize = 100;
/// Targets farther apart than five a metre are no variant, mm.
const WIDEST_MM: f64 = 200.0;
/// A step that differs less from whole micrometres is one, mm.
const WHOLE_MM: f64 = 1e-7;

/// How long setting up takes, min.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SetUpTimes {
    /// Laser and mirror on one diagonal.
    #[serde(rename = "diagonal")]
    pub diagonal_min: f64,
    /// Laser and reflector along one axis.
    #[serde(rename = "linear")]
    pub linear_min: f64,
}

/// A visit as the job describes it.
#[derive(Clone, Debug)]
pub struct Design<'a> {
    pub(crate) job: &'a Job,
    angles: Option<ErrorTable>,
    /// What is known of angles; `None` = what `angles` says.
    evidence: Option<AngleEvidence>,
    /// By how much reversals are known to change along their axes, µm.
    change_um: PerTerm<f64>,
    /// The run of the job.
    pub described: Variant,
    measurement: DiagonalMeasurement,
    /// The laser.
    pub(crate) instrument: Instrument,
    pub(crate) times: SetUpTimes,
    /// Visits that were asked for: each takes a thousand draws.
    visits: RefCell<Vec<Visit>>,
}

impl<'a> Design<'a> {
    /// From `[program]` where it walks step diagonals, else from `[measurement.step_diagonal]`. `angles` =
    /// the table that `measurement.angles` names.
    pub fn of(
        job: &'a Job,
        angles: Option<ErrorTable>,
        times: SetUpTimes,
    ) -> Result<Design<'a>, Problems> {
        ensure_axes(job)?;
        let (run, measurement) = described(job).ok_or_else(|| no_run(job))?;
        let stated = job.measurement.uncertainty;
        Ok(Design {
            measurement,
            described: Variant { run, linear: Vec::new(), angles: Vec::new() },
            instrument: Instrument { noise_um: stated.noise_um.unwrap_or(NOISE_UM), stated },
            job,
            angles,
            evidence: None,
            change_um: PerTerm::from_fn(|_| 0.0),
            times,
            visits: RefCell::default(),
        })
    }

    /// A measurement that was made, with the noise that it found.
    pub(crate) fn made(job: &'a Job, found: &Separation) -> Result<Design<'a>, Problems> {
        let times = SetUpTimes { diagonal_min: 30.0, linear_min: 20.0 };
        let mut design = Design::of(job, None, times)?;
        let run = &mut design.described.run;
        run.volume = found.volume.clone();
        run.runs = found.runs.iter().map(|run| run.number).max().unwrap_or(1);
        run.bidirectional = found.is_both_ways();
        run.overrun = Millimetres::new(f64::from(found.overrun != Some(false)));
        design.instrument.noise_um = found.noise.map_or(NOISE_UM, |noise| noise.sigma_um);
        design.evidence = Some(found.angle_evidence().clone());
        design.change_um =
            found.turn.as_ref().map_or(design.change_um, |turn| turn.change_um.clone());
        for (index, linear) in design.measurement.linear.iter_mut().enumerate() {
            linear.u_um_per_m = Some(found.u_of_line(index));
        }
        Ok(design)
    }

    /// Runs that there are already, or one.
    pub(super) fn fewest_runs(&self) -> u32 {
        self.evidence.as_ref().map_or(1, |_| self.described.run.runs)
    }

    /// Axes whose linear measurement the job names: they take no time.
    pub(crate) fn axes_named(&self) -> Vec<Axis> {
        let named = self.measurement.linear.iter();
        named.map(|linear| linear.axis).collect()
    }

    /// Half and twice the steps, where a program can make them and they show enough of an axis.
    pub(super) fn in_other_steps(&self, variant: &Variant) -> Vec<Variant> {
        let steps = self.described.run.volume.steps;
        let fits = |other: &Variant| {
            let volume = &other.run.volume;
            let is_whole = |axis: Axis| {
                let um = 1000.0 * volume.step_mm(axis);
                (um - um.round()).abs() < 1000.0 * WHOLE_MM
            };
            let is_close = volume.steps > steps || other.target_spacing_mm() <= WIDEST_MM;
            is_close && volume.steps <= MOST_STEPS && Axis::ALL.into_iter().all(is_whole)
        };
        let others = [steps.div_ceil(2), 2 * steps];
        let others = others.map(|steps| variant.run_as(|run| run.volume.steps = steps));
        others.into_iter().filter(fits).collect()
    }

    /// The spacing of each axis that tables need where the targets lie farther apart than their points, mm.
    pub(crate) fn other_grid(&self, variant: &Variant) -> Option<PerAxis<f64>> {
        let volume = &variant.run.volume;
        let step = PerAxis::from_fn(|axis| volume.step_mm(axis));
        let is_wider = |axis: Axis| {
            let own = self.job.compensation.axes[axis].as_ref().and_then(|own| own.grid);
            matches!(own, Some(GridRequest::Spacing(mm)) if step[axis] > mm + WHOLE_MM)
        };
        let is_coarser = volume.steps < self.described.run.volume.steps;
        (is_coarser && Axis::ALL.into_iter().any(is_wider)).then_some(step)
    }

    /// Motion, standstills and set-ups of a variant, min.
    pub(super) fn minutes(&self, variant: &Variant) -> f64 {
        let run = |request: &ProgramRequest| motion(request).duration_s(request) / 60.0;
        let diagonals = Diagonal::ALL.map(|_| self.times.diagonal_min).iter().sum::<f64>();
        let angles = variant.angles.iter().map(|angle| &angle.along);
        let single = variant.linear.iter().chain(angles);
        let single = single.map(|axis| self.times.linear_min + run(&variant.run.along(*axis)));
        run(&variant.run) + diagonals + single.sum::<f64>()
    }

    /// What a variant costs and gives.
    pub fn visit(&self, variant: Variant) -> Result<Visit, Problems> {
        let is_same = |known: &&Visit| known.variant == variant;
        let known = self.visits.borrow().iter().find(is_same).cloned();
        known.map_or_else(|| self.new_visit(variant), Ok)
    }

    fn new_visit(&self, variant: Variant) -> Result<Visit, Problems> {
        let measurement = self.measurement(&variant);
        let job = self.job_of(&measurement);
        let linear = vec![None; measurement.linear.len()];
        let tables = NamedTables { linear, angles: self.angles.clone() };
        let mut campaign = campaign(&job, &measurement, &tables, true)?;
        for axis in self.axes_both_ways(&variant) {
            let runs = variant.run.along(axis).runs;
            campaign.reversals[axis] = Some(self.instrument.reversal(&measurement.volume, runs));
        }
        let evidence = &mut campaign.angles.evidence;
        if let Some(known) = &self.evidence {
            evidence.clone_from(known);
        }
        evidence.missing.retain(|angle| !variant.angles.contains(angle));
        let back = usize::from(variant.run.bidirectional);
        let noise_um = self.instrument.noise_um;
        let passes = &Pass::BOTH[..=back];
        let expected = expected(&campaign, passes, variant.run.runs, noise_um, &self.change_um);
        let is_open =
            |term: &ErrorTerm| wants(&job, *term) && expanded_um(&expected, *term).is_none();
        let has_diagonals = job.acceptance.max_diagonal_um.is_some()
            && expected.missing().is_empty()
            && !expected.is_one_way(&job);
        let largest = expected.largest(&job, has_diagonals);
        let diagonals = largest.as_ref().filter(|_| has_diagonals);
        let between = job.measurement.uncertainty.between();
        let range = |axis| range_of(&job, axis, &expected.volume.positions(axis));
        let visit = Visit {
            minutes: self.minutes(&variant),
            mirror: motion(&variant.run).mirror,
            at_most_um: largest.as_ref().map(|of| rounded(of.all_um + between.all_um(), DIGITS)),
            diagonals_at_most_um: diagonals
                .map(|of| rounded(of.ranges_um + between.ranges_um(), DIGITS)),
            worst: largest.as_ref().map(|of| of.single.worst()),
            ranges: Axis::ALL.into_iter().filter_map(range).collect(),
            open: ErrorTerm::ALL.into_iter().filter(is_open).collect(),
            lines: campaign.lines,
            variant,
            expected,
            chance: None,
        };
        self.visits.borrow_mut().push(visit.clone());
        Ok(visit)
    }

    /// Probability that a second measurement made like a visit keeps the limit of errors, if the machine does not
    /// change and the tables leave nothing but the errors of the first one; `None` = no limit, or an uncertainty or
    /// a statement is missing.
    pub fn chance(&self, visit: &Visit) -> Option<f64> {
        let is_known = visit.open.is_empty() && visit.expected.silence.not_stated.is_empty();
        let limit_um = self.job.acceptance.max_deviation_um.filter(|_| is_known)?;
        Some(visit.expected.outlook(self.job, None, limit_um)?.1)
    }

    /// What can be measured in addition: each linear axis, that angle of the stated ones that does most, all of them.
    pub(super) fn additions(&self, described: &Visit, parts: &[(Part, f64)]) -> Vec<Variant> {
        let named = self.axes_named();
        let axes = Axis::ALL.into_iter().filter(|axis| !named.contains(axis));
        let mut additions: Vec<Variant> =
            axes.map(|axis| self.described.with(&[axis], &[])).collect();
        let open = &described.expected.angle_evidence().missing;
        let angle = |(part, _): &(Part, f64)| match part {
            Part::Angle(angle) => open.contains(angle).then_some(*angle),
            _ => None,
        };
        if let Some(angle) = parts.iter().find_map(angle) {
            additions.extend([&[angle], open.as_slice()].map(|all| self.described.with(&[], all)));
        }
        additions.dedup();
        additions
    }

    /// How a variant is measured.
    fn measurement(&self, variant: &Variant) -> DiagonalMeasurement {
        let mut measurement = self.measurement.clone();
        measurement.volume = variant.run.volume.clone();
        measurement.overrun = variant.run.runs_over();
        for beam in &mut measurement.beams {
            beam.slope_um_per_m = 0.0;
        }
        let named = self.measurement.linear.iter().map(|linear| (linear.axis, linear.u_um_per_m));
        let axes = named.chain(variant.linear.iter().map(|axis| (*axis, None)));
        let linear = axes.map(|(axis, u_um_per_m)| Linear {
            axis,
            slope: LinearSlope::Stated(0.0),
            u_um_per_m: u_um_per_m.or_else(|| Some(self.of_line(axis, variant))),
        });
        measurement.linear = linear.collect();
        measurement
    }

    /// The axes that are measured in both directions; a slope by itself tells no reversal.
    fn axes_both_ways(&self, variant: &Variant) -> Vec<Axis> {
        let named = self.measurement.linear.iter();
        let named = named.filter(|linear| matches!(linear.slope, LinearSlope::Errors(_)));
        named.map(|linear| linear.axis).chain(variant.linear.iter().copied()).collect()
    }

    /// Standard uncertainty of the slope of an axis that is measured beside a variant, µm/m.
    pub(super) fn of_line(&self, axis: Axis, variant: &Variant) -> f64 {
        let runs = variant.run.along(axis).runs;
        let box_of = (&variant.run.volume, self.measurement.material);
        self.instrument.of_slope_um_per_m(box_of, axis, runs)
    }

    /// The job as if this had been measured.
    fn job_of(&self, measurement: &DiagonalMeasurement) -> Job {
        Job {
            measurement: Measurement {
                data: MeasuredData::Diagonals(measurement.clone()),
                squareness: Vec::new(),
                ..self.job.measurement.clone()
            },
            ..self.job.clone()
        }
    }
}

/// The run of `[program]` where it walks step diagonals, else that of the measurement; how it is measured.
fn described(job: &Job) -> Option<(ProgramRequest, DiagonalMeasurement)> {
    let measured = job.measurement.diagonals().filter(|how| how.kind == PathKind::Step);
    let is_step = |run: &&ProgramRequest| run.what == RunType::StepDiagonal;
    let program = job.program.as_ref().filter(is_step).cloned();
    let run = program.or_else(|| measured.map(ProgramRequest::of_measurement))?;
    let measurement = measured.cloned().or_else(|| run.measured())?;
    Some((run, measurement))
}

/// A diagonal moves all three axes.
fn ensure_axes(job: &Job) -> Result<(), Problems> {
    let mut problems = Problems::none();
    for axis in Axis::ALL {
        if job.machine.axes[axis].is_none() {
            problems.push(job.source.at("machine.axes", refusals::no_axis(axis, axis.key())));
        }
    }
    problems.or_ok(())
}

fn no_run(job: &Job) -> Problem {
    let key = match job.program {
        Some(_) => "program.what",
        None => "measurement",
    };
    job.source.at(key, refusals::no_run())
}
