//! What goes into a separation: how it was measured, the corrected readings and what their runs say by themselves, lines
//! beside them; from a job and the tables it names.

use super::corrections::{AngleEffects, AngleModel, expansion_um, falls_short, recorded};
use super::curves::{at, mean};
use super::linear::Layout;
use super::noise::{ENOUGH, Noise, NoiseSource, Outlier, repeats};
use super::readings::{Walk, walks};
use crate::inputs::error_table::{Cause, ErrorTable, Silence};
use crate::inputs::job::{
    Beam, DiagonalMeasurement, Job, Linear, LinearSlope, Material, SetUp, StatedUncertainty,
};
use crate::machine::model::measured::{check_zeros, no_angles};
use crate::quantity::{
    Axis, Deviation, Diagonal, Direction, Millimetres, Pass, PathKind, PerAxis, PerTerm, Run,
    Volume,
};
use crate::text::{Problem, Problems};

/// What goes into a separation beside the readings.
#[derive(Clone, Debug)]
pub struct Campaign<'a> {
    /// How it was measured.
    pub measurement: &'a DiagonalMeasurement,
    /// `[measurement.uncertainty]`.
    pub stated: StatedUncertainty,
    /// Slopes of single axes and other beams.
    pub lines: Vec<MeasuredLine>,
    /// Reversal of single axes from linear measurements in both directions.
    pub reversals: LinearReversals,
    /// Effects of angular errors on the readings.
    pub angles: AngleEffects,
    /// Whether reverse readings count from the forward start; else only their increments hold.
    pub reverse_zero_known: bool,
}

impl Campaign<'_> {
    /// What the job leaves unsaid, or says to be nothing.
    pub(super) fn silence(&self) -> Silence {
        let stated = &self.stated;
        let is_perfect = self.measurement.setup == SetUp::AssumePerfect;
        let lacks_u = self.lines.iter().any(|line| line.u_um_per_m.is_none());
        let all = [
            (Cause::Angles, !self.angles.evidence.missing.is_empty(), stated.angle_urad),
            (Cause::SetUps, true, stated.setup_ppm),
            (Cause::Slopes, lacks_u, None),
            (Cause::Tilt, is_perfect, stated.tilt_arcsec),
        ];
        let of = |is: fn(Option<f64>) -> bool| {
            let found = all.into_iter().filter(|(_, is_open, bound)| *is_open && is(*bound));
            found.map(|(cause, ..)| cause).collect()
        };
        Silence {
            not_stated: of(|bound| bound.is_none()),
            neglected: of(|bound| bound.is_some_and(|bound| bound <= 0.0)),
        }
    }
}

/// A straight line beside the diagonals; the uncertainty where it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredLine {
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
pub(super) fn corrected(campaign: &Campaign<'_>, mut runs: Vec<Run>) -> Vec<Run> {
    let measurement = campaign.measurement;
    let material = measurement.material.as_ref();
    let material = material.filter(|material| !material.material_corrected);
    for run in &mut runs {
        let (volume, kind) = (&measurement.volume, measurement.kind);
        let effect = campaign.angles.of(run.diagonal, run.pass);
        let reading = |(node, deviation): (usize, &Deviation)| {
            let expansion = material.map_or(0.0, |of| expansion_um(volume, kind, of, run, node));
            let effect = effect.map_or(0.0, |effect| effect[node]);
            Deviation::from_um(deviation.um() - expansion - effect)
        };
        run.deviations = run.deviations.iter().enumerate().map(reading).collect();
    }
    runs
}

/// The runs of a measurement and what they say by themselves.
#[derive(Clone)]
pub(super) struct Start {
    /// Expansion of the scales at the mean of the recorded temperatures.
    pub(super) material: Option<Material>,
    /// The corrected runs.
    pub(super) runs: Vec<Run>,
    /// Their means; jumps of a turn are still in them.
    pub(super) walks: Vec<Walk>,
    /// Disturbed readings of single runs.
    pub(super) outliers: Vec<Outlier>,
    /// σ of a reading where repeats or the job give it.
    pub(super) noise: Option<Noise>,
    /// σ of a measurement that is still to be made, where the closure would tell it, µm.
    pub(super) expected_um: Option<f64>,
    /// By how much reversals are known to change along their axes from elsewhere, µm.
    pub(super) change_um: PerTerm<f64>,
}

impl Start {
    pub(super) fn new(campaign: &Campaign<'_>, raw_runs: &[Run]) -> Start {
        let material = campaign.measurement.material;
        let material = material.map(|material| recorded(&material, raw_runs));
        Start::of(campaign, corrected(campaign, raw_runs.to_vec()), material)
    }

    /// Of corrected runs.
    pub(super) fn of(campaign: &Campaign<'_>, runs: Vec<Run>, material: Option<Material>) -> Start {
        let (noise, outliers) = repeats(&runs);
        Start {
            material,
            expected_um: None,
            change_um: PerTerm::from_fn(|_| 0.0),
            walks: walks(&runs),
            outliers,
            noise: known_noise(campaign, noise),
            runs,
        }
    }

    /// What is measured beside so many lines.
    pub(super) fn layout(&self, lines: usize) -> Layout {
        let nodes = self.walks.first().map_or(0, |walk| walk.um.len());
        Layout { nodes, passes: self.walks.len() / Diagonal::ALL.len(), lines, apart: 0 }
    }

    /// The mean readings, in the order of a [`Layout`].
    pub(super) fn means(&self) -> Vec<f64> {
        self.walks.iter().flat_map(|walk| &walk.um).copied().collect()
    }

    /// The runs whose zero is that of the forward run: all, or the forward passes only.
    pub(super) fn zeroed_runs(&self, reverse_zero_known: bool) -> Vec<Run> {
        let zeroed = |run: &&Run| reverse_zero_known || run.pass == Pass::Forward;
        self.runs.iter().filter(zeroed).cloned().collect()
    }

    /// How many runs each of them is the mean of.
    pub(super) fn counts(&self) -> Vec<f64> {
        let each = self.walks.iter().flat_map(|walk| walk.um.iter().map(|_| walk.runs));
        each.collect()
    }
}

/// σ of a reading before the closure is judged: repeats say most; else the closure itself, unless it leaves few
/// degrees of freedom and the job states one.
fn known_noise(campaign: &Campaign<'_>, repeats: Option<Noise>) -> Option<Noise> {
    let stated_um = campaign.stated.noise_um;
    let measurement = campaign.measurement;
    let of_closure =
        3 * measurement.volume.steps >= ENOUGH + 3 && measurement.kind == PathKind::Step;
    let stated = stated_um.filter(|_| !of_closure).map(|sigma_um| Noise {
        sigma_um,
        freedom: None,
        source: NoiseSource::Stated,
    });
    repeats.map(|found| found.with_stated(stated_um)).or(stated)
}

/// Error tables that a job with readings names.
#[derive(Clone, Debug, Default)]
pub struct NamedTables {
    /// For each `[[measurement.step_diagonal.linear]]`, in the order of the job; `None` where the
    /// slope is stated.
    pub linear: Vec<Option<ErrorTable>>,
    /// `measurement.angles`.
    pub angles: Option<ErrorTable>,
}

/// The campaign of a job.
pub fn campaign<'a>(
    job: &Job,
    measurement: &'a DiagonalMeasurement,
    tables: &NamedTables,
    reverse_zero_known: bool,
) -> Result<Campaign<'a>, Problems> {
    let mut problems = Problems::none();
    let mut lines = Vec::new();
    let mut reversals = LinearReversals::default();
    for (linear, table) in measurement.linear.iter().zip(&tables.linear) {
        let (table, volume) = (table.as_ref(), &measurement.volume);
        let Some((line, ways)) = problems.take(linear_line(volume, linear, table)) else {
            continue;
        };
        lines.push(line);
        let found = || LinearReversal::of(&ways);
        reversals[linear.axis] = reversals[linear.axis].take().or_else(found);
    }
    lines.extend(measurement.beams.iter().map(beam_line));
    let angles = tables.angles.as_ref().map(|table| angles(job, measurement, table));
    let angles = angles.and_then(|angles| problems.take(angles));
    problems.or_ok(Campaign {
        measurement,
        stated: job.measurement.uncertainty,
        lines,
        reversals,
        angles: angles.unwrap_or_else(|| AngleEffects::unmeasured(job.machine.chain)),
        reverse_zero_known,
    })
}

/// A linear measurement of an axis in a direction at the interval ends of the box, lowest first: values, µm, and standard
/// uncertainties (k = 1); `None` = the table gives none.
pub(super) type Way = (Option<Direction>, Vec<f64>, Option<Vec<f64>>);

/// B of a positioning error at the interval ends of the box, from a linear measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearReversal {
    /// Moving + minus moving −, lowest place first, µm.
    pub um: Vec<f64>,
    /// Standard uncertainties (k = 1), µm; `None` = the table gives none.
    pub u_um: Option<Vec<f64>>,
}

/// The linear measurements in both directions, by axis; `None` = there is none.
pub type LinearReversals = PerAxis<Option<LinearReversal>>;

impl LinearReversal {
    /// Of a linear measurement, each direction with its values and their uncertainties at the interval ends; `None`
    /// without both.
    pub(super) fn of(ways: &[Way]) -> Option<Self> {
        let way = |direction| ways.iter().find(|(way, ..)| *way == Some(direction));
        let ((_, plus, u_plus), (_, minus, u_minus)) =
            (way(Direction::Plus)?, way(Direction::Minus)?);
        let pairs = |a: &[f64], b: &[f64], of: fn(f64, f64) -> f64| {
            a.iter().zip(b).map(|(a, b)| of(*a, *b)).collect()
        };
        let u_um = u_plus.as_ref().zip(u_minus.as_ref());
        Some(LinearReversal {
            um: pairs(plus, minus, |plus, minus| plus - minus),
            u_um: u_um.map(|(a, b)| pairs(a, b, f64::hypot)),
        })
    }

    /// The largest of its uncertainties: its readings may share causes.
    pub(super) fn u_largest_um(&self) -> Option<f64> {
        Some(self.u_um.as_ref()?.iter().copied().fold(0.0, f64::max))
    }
}

/// The slope of a linear axis, and the directions in which its table gives it.
///
/// formula  positioning error at the high end of the box less that at its low end, by the length between; mean of the
///          directions: the totals of the diagonals see the same two ends. u = √(u²(high) + u²(low)) by the length, the
///          directions taken as wrong alike; `None` without a `u_…` column
fn linear_line(
    volume: &Volume,
    linear: &Linear,
    table: Option<&ErrorTable>,
) -> Result<(MeasuredLine, Vec<Way>), Problems> {
    let (stated, ways) = match (&linear.slope, table) {
        (LinearSlope::Stated(slope), _) => (Some(*slope), Vec::new()),
        (LinearSlope::Errors(_), Some(table)) => (None, over_box(volume, linear.axis, table)?),
        (LinearSlope::Errors(path), None) => {
            return Err(Problem::new(format!("`{path}` was not read")).into());
        }
        (LinearSlope::NotYet, _) => {
            let words = format!("the slope of axis {} is not stated", linear.axis);
            return Err(Problem::new(words).help("state `slope_um_per_m`").into());
        }
    };
    let per_m = |um: &[f64], of: fn(f64, f64) -> f64| {
        1000.0 * of(um[volume.steps], um[0]) / volume.size[linear.axis].mm()
    };
    let slopes = ways.iter().map(|(_, um, _)| per_m(um, |high, low| high - low));
    let u = ways.iter().map(|(.., u_um)| Some(per_m(u_um.as_ref()?, f64::hypot)));
    let u = u.collect::<Option<Vec<f64>>>().filter(|u| !u.is_empty());
    let line = MeasuredLine {
        direction: PerAxis::from_fn(|axis| f64::from(axis == linear.axis)),
        slope_um_per_m: stated.unwrap_or_else(|| mean(slopes)),
        u_um_per_m: linear.u_um_per_m.or(u.map(|u| mean(u.into_iter()))),
        ends: None,
    };
    Ok((line, ways))
}

/// A linear measurement at the interval ends of the box.
fn over_box(volume: &Volume, axis: Axis, table: &ErrorTable) -> Result<Vec<Way>, Problems> {
    let nodes = volume.positions(axis);
    let words = (format!("E{axis}{axis} is"), "the axis");
    let mut ways = Vec::new();
    for series in table.series(axis) {
        let Some(values) = &series.deviations[axis] else { continue };
        if let Some(problem) = falls_short(table, series, (volume, axis), &words) {
            return Err(problem.into());
        }
        let over = |um: &[f64]| -> Vec<f64> {
            nodes.iter().map(|node| at(&series.positions, um, node.mm())).collect()
        };
        let um: Vec<f64> = values.iter().map(|value| value.um()).collect();
        let u_um = series.uncertainties_um[axis].as_deref().map(over);
        ways.push((series.direction, over(&um), u_um));
    }
    if ways.is_empty() {
        let words = format!(
            "the table holds no positioning error of {axis} (E{axis}{axis}), expected its linear measurement"
        );
        let help = "name a table with rows of that axis and its own direction";
        return Err(Problem::new(words).at(table.header.clone()).help(help).into());
    }
    Ok(ways)
}

/// A beam between two places inside the box, as the job was checked for.
fn beam_line(beam: &Beam) -> MeasuredLine {
    let way = PerAxis::from_fn(|axis| (beam.to[axis] - beam.from[axis]).mm());
    MeasuredLine {
        direction: PerAxis::from_fn(|axis| way[axis] / way.length()),
        slope_um_per_m: beam.slope_um_per_m,
        u_um_per_m: beam.u_um_per_m,
        ends: Some([beam.from, beam.to]),
    }
}

/// What the angular errors of a table do to the readings of a measurement.
pub fn angles(
    job: &Job,
    measurement: &DiagonalMeasurement,
    table: &ErrorTable,
) -> Result<AngleEffects, Problems> {
    let chain = job.chain_for_angles("measurement.angles")?;
    let levers = job.measurement.levers;
    let (order, origin) = (chain.order(), levers.origin(&job.machine.axes));
    if let Some(problem) = no_angles(table) {
        return Err(problem.into());
    }
    let model = AngleModel { table, order, levers, origin, measurement };
    let mut problems = Problems::none();
    model.check(&mut problems);
    check_zeros(job, table, &mut problems);
    problems.or_ok(()).map(|()| model.effects())
}
