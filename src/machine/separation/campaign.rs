//! What goes into a separation: how it was measured, the corrected readings and what their runs say by themselves, lines
//! beside them; from a job and the tables it names.

use super::corrections::{AngleEffects, expansion_um, falls_short, recorded};
use super::curves::{at, closure_sign, mean, noise_gain};
use super::linear::{Layout, Model, Row};
use super::readings::{
    ENOUGH, Group, Noise, NoiseSource, Outlier, float, means, pass_of, repeats, walks,
};
use super::uncertainty::model;
use crate::inputs::error_table::{Cause, ErrorTable, Kind, Silence};
use crate::inputs::job::{
    Beam, DiagonalMeasurement, Job, Linear, LinearSlope, Material, SetUp, StatedUncertainty,
};
use crate::machine::model::measured::{check_zeros, has_angles, no_angles};
use crate::quantity::{
    Axis, Deviation, Diagonal, Direction, ErrorTerm, Millimetres, Pass, PathKind, PerAxis, PerTerm,
    Run, Squared, Volume, unit,
};
use crate::text::{Problem, Problems};
use serde::Serialize;

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
pub(super) struct Start<'a> {
    pub(super) campaign: &'a Campaign<'a>,
    /// Expansion of the scales at the mean of the recorded temperatures.
    pub(super) material: Option<Material>,
    /// The corrected runs.
    pub(super) runs: Vec<Run>,
    /// What is uncertain of what is measured; the noise that counts, where it is known by now.
    pub(super) model: Model,
    /// z: means of the runs, in which jumps of a turn still are, then lines, then 0.
    pub(super) z: Vec<f64>,
    /// How many runs each of these means is of.
    pub(super) counts: Vec<f64>,
    /// Disturbed readings of single runs.
    pub(super) outliers: Vec<Outlier>,
    /// σ of a reading where repeats or the job give it.
    pub(super) known: Option<Noise>,
    /// σ of a measurement that is still to be made, where the closure would tell it, µm.
    pub(super) expected_um: Option<f64>,
    /// By how much reversals are known to change along their axes from elsewhere, µm.
    pub(super) change_um: PerTerm<f64>,
    /// Whether the axes ran past the end point; `None` = not known.
    pub(super) overrun: Option<bool>,
}

impl<'a> Start<'a> {
    pub(super) fn new(campaign: &'a Campaign<'a>, raw_runs: &[Run]) -> Start<'a> {
        let material = campaign.measurement.material;
        let material = material.map(|material| recorded(material, raw_runs));
        Start::of(campaign, corrected(campaign, raw_runs.to_vec()), material)
    }

    /// Of corrected runs.
    pub(super) fn of(
        campaign: &'a Campaign<'a>,
        runs: Vec<Run>,
        material: Option<Material>,
    ) -> Start<'a> {
        let (noise, outliers) = repeats(&runs);
        let (walks, lines) = (walks(&runs), campaign.lines.iter());
        let layout = Layout {
            nodes: walks.first().map_or(0, |walk| walk.um.len()),
            passes: walks.len() / Diagonal::ALL.len(),
            lines: lines.len(),
            apart: 0,
        };
        let (mut z, counts) = means(walks);
        z.extend(lines.map(|line| line.slope_um_per_m));
        z.resize(layout.len(), 0.0);
        Start {
            campaign,
            model: model(campaign, material, layout),
            material,
            z,
            counts,
            outliers,
            known: known_noise(campaign, noise),
            expected_um: None,
            change_um: PerTerm::from_fn(|_| 0.0),
            overrun: None,
            runs,
        }
    }

    /// The measured box.
    pub(super) fn volume(&self) -> &'a Volume {
        &self.campaign.measurement.volume
    }

    /// The runs whose zero is that of the forward run: all, or the forward passes only.
    pub(super) fn zeroed_runs(&self) -> Vec<Run> {
        let is_known = self.campaign.reverse_zero_known;
        let zeroed = self.runs.iter().filter(|run| is_known || run.pass == Pass::Forward);
        zeroed.cloned().collect()
    }

    /// Lets this noise count.
    pub(super) fn set_noise(&mut self, noise: Option<Noise>) {
        let square = noise.map_or(0.0, |noise| noise.sigma_um.squared());
        self.model.own.iter_mut().zip(&self.counts).for_each(|(own, runs)| *own = square / runs);
        self.model.noise = noise;
    }

    /// One more entry of what was measured: its place.
    pub(super) fn add(&mut self, um: f64, u_um: f64) -> usize {
        self.z.push(um);
        self.model.add(u_um)
    }

    /// Whether every diagonal was walked in both directions.
    pub(super) fn both_ways(&self) -> bool {
        self.model.layout.passes == 2
    }

    /// Whether the axes turned without overrun, so that jumps are taken off the reverse passes.
    pub(super) fn turned(&self) -> bool {
        self.overrun == Some(false)
    }
}

/// Formulas (1) to (3) as rows over what was measured. The slopes hold the tilt of the mirror.
impl Start<'_> {
    /// The groups of readings of one pass, or of both.
    pub(super) fn groups(&self) -> &'static [Group] {
        match self.both_ways() {
            true => &[Some(Direction::Plus), Some(Direction::Minus)],
            false => &[None],
        }
    }

    /// The reading of a pass at the far end of a step less that at the near one.
    pub(super) fn moved(&self, pass: Pass, d: Diagonal, axis: Axis, step: usize) -> Row {
        let far = self.model.layout.reading(pass, d, self.volume().node_after(axis, step));
        Row(vec![(far, 1.0), (far - 1, -1.0)])
    }

    /// J: the reverse less the forward increment of the last step of an axis.
    pub(super) fn jump(&self, d: Diagonal, axis: Axis) -> Row {
        let of = |pass| self.moved(pass, d, axis, self.volume().steps - 1);
        Row::sum([(1.0, of(Pass::Reverse)), (-1.0, of(Pass::Forward))])
    }

    /// m: the reading at the far end of an interval less that at the near one.
    fn increment(&self, group: Group, d: Diagonal, axis: Axis, interval: usize) -> Row {
        let step = self.volume().interval(d, axis, interval);
        let is_turn = self.turned() && step + 1 == self.volume().steps;
        let pass = if is_turn { Pass::Forward } else { pass_of(group, d, axis) };
        self.moved(pass, d, axis, step)
    }

    /// w: closure of an interval.
    pub(super) fn closure(&self, group: Group, axis: Axis, interval: usize) -> Row {
        let of = |d| (closure_sign(d, axis), self.increment(group, d, axis, interval));
        Row::sum(Diagonal::ALL.map(of))
    }

    /// δ of an interval of a term for one group of readings.
    pub(super) fn delta(&self, term: ErrorTerm, group: Group, interval: usize) -> Row {
        let gain = noise_gain(self.volume(), term.of) / 2.0;
        let of = |d: Diagonal| {
            let sign = gain * d.sign(term.along) * d.sign(term.of);
            (sign, self.increment(group, d, term.along, interval))
        };
        Row::sum(Diagonal::ALL.map(of))
    }

    /// The mean of the groups.
    pub(super) fn mean(&self, of: impl Fn(Group) -> Row) -> Row {
        let groups = self.groups();
        Row::sum(groups.iter().map(|group| (1.0 / float(groups.len()), of(*group))))
    }

    /// Sum of the increments of a (diagonal, axis) pair, mean of the groups.
    pub(super) fn sum(&self, d: Diagonal, axis: Axis) -> Row {
        let all = 0..self.volume().steps;
        let of = |group| all.clone().map(move |at| (1.0, self.increment(group, d, axis, at)));
        self.mean(|group| Row::sum(of(group)))
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
        let known = &mut reversals[linear.axis];
        *known = known.take().or_else(|| reversal(&ways));
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

/// What is known of a value, µm.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize)]
pub struct Estimate {
    /// The value.
    pub um: f64,
    /// Its standard uncertainty (k = 1); `None` = not known.
    pub u_um: Option<f64>,
}

impl Estimate {
    /// The difference to another, the two apart.
    fn less(self, other: Estimate) -> Estimate {
        let u_um = self.u_um.zip(other.u_um).map(|(u, other)| u.hypot(other));
        Estimate { um: self.um - other.um, u_um }
    }
}

/// A linear measurement of an axis in a direction, at the interval ends of the box, lowest first.
type Way = (Option<Direction>, Vec<Estimate>);

/// B of positioning errors by linear measurements in both directions, moving + minus moving −, at the interval ends of
/// the box, lowest first; `None` = there is none.
pub type LinearReversals = PerAxis<Option<Vec<Estimate>>>;

/// B where an axis was measured in both directions.
fn reversal(ways: &[Way]) -> Option<Vec<Estimate>> {
    let [plus, minus] = Direction::BOTH.map(|own| ways.iter().find(|(way, _)| *way == Some(own)));
    let pairs = plus?.1.iter().zip(&minus?.1);
    Some(pairs.map(|(plus, minus)| plus.less(*minus)).collect())
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
    let axis = linear.axis;
    let (stated, ways) = match (&linear.slope, table) {
        (LinearSlope::Stated(slope), _) => (Some(*slope), Vec::new()),
        (LinearSlope::Errors(_), Some(table)) => (None, over_box(volume, axis, table)?),
        _ => {
            let words = format!("the slope of axis {axis} is not stated");
            return Err(Problem::new(words).help("state `slope_um_per_m`").into());
        }
    };
    let per_m = 1000.0 / volume.size[axis].mm();
    let rises = ways.iter().map(|(_, way)| way[volume.steps].less(way[0]));
    let u: Option<Vec<f64>> = rises.clone().map(|rise| rise.u_um).collect();
    let u = u.filter(|u| !u.is_empty()).map(|u| per_m * mean(u.into_iter()));
    let line = MeasuredLine {
        direction: unit(axis),
        slope_um_per_m: stated.unwrap_or_else(|| per_m * mean(rises.map(|rise| rise.um))),
        u_um_per_m: linear.u_um_per_m.or(u),
        ends: None,
    };
    Ok((line, ways))
}

/// A linear measurement at the interval ends of the box.
fn over_box(volume: &Volume, axis: Axis, table: &ErrorTable) -> Result<Vec<Way>, Problems> {
    let words = (format!("E{axis}{axis} is"), "the axis");
    let mut ways = Vec::new();
    for series in table.series(axis) {
        let own = Kind::Deviation(axis);
        let Some(um) = series.values.get(&own) else { continue };
        if let Some(problem) = falls_short(table, series, (volume, axis), &words) {
            return Err(problem.into());
        }
        let here = |node: &Millimetres, um: &[f64]| at(&series.positions, um, node.mm());
        let u_um = series.uncertainties.get(&own);
        let of = |node| Estimate { um: here(node, um), u_um: u_um.map(|u| here(node, u)) };
        ways.push((series.direction, volume.positions(axis).iter().map(of).collect()));
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
    let (chain, levers) = (job.chain_for_angles("measurement.angles")?, job.measurement.levers);
    if let Some(problem) = no_angles(table) {
        return Err(problem.into());
    }
    let mut problems = Problems::none();
    for (axis, series) in
        Axis::ALL.into_iter().flat_map(|axis| table.series(axis).iter().map(move |s| (axis, s)))
    {
        let words = (format!("the angles of {axis} are"), "the angles");
        let short = falls_short(table, series, (&measurement.volume, axis), &words);
        short.filter(|_| has_angles(series)).into_iter().for_each(|problem| problems.push(problem));
    }
    check_zeros(job, table, &mut problems);
    let origin = levers.origin(&job.machine.axes);
    let effects = || AngleEffects::of_table(table, (chain.order(), levers, origin), measurement);
    problems.or_ok(()).map(|()| effects())
}
