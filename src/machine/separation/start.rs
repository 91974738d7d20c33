//! The corrected readings, what their runs say by themselves, and what is uncertain of them.

use super::campaign::Campaign;
use super::corrections::{expansion_um, recorded};
use super::curves::{closure_sign, noise_gain};
use super::readings::{
    ENOUGH, Group, Noise, NoiseSource, Outlier, float, means, pass_of, repeats, walks,
};
use super::uncertainty::{model, of_rotation};
use crate::inputs::job::Material;
use crate::quantity::{
    Axis, Deviation, Diagonal, Direction, ErrorTerm, Pass, PathKind, PerAxis, PerTerm, Rotation,
    Run, Squared, Volume,
};
use nonius_numerics::rows::{Cause, Layout, Model, Row};

/// A ramp below this share of the readings that make it is their rounding.
const ROUNDING: f64 = 1e-9;

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
    /// What is uncertain of what is measured.
    pub(super) model: Model,
    /// The noise that counts, where it is known by now.
    pub(super) noise: Option<Noise>,
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
        z.resize(layout.entries(), 0.0);
        Start {
            campaign,
            model: model(campaign, material, layout),
            noise: None,
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
        self.runs.iter().filter(|run| is_known || run.pass == Pass::Forward).cloned().collect()
    }

    /// Lets this noise count.
    pub(super) fn set_noise(&mut self, noise: Option<Noise>) {
        let square = noise.map_or(0.0, |noise| noise.sigma_um.squared());
        self.model.own.iter_mut().zip(&self.counts).for_each(|(own, runs)| *own = square / runs);
        self.model.freedom = noise.map(|noise| noise.freedom_f64().unwrap_or(f64::INFINITY));
        self.noise = noise;
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

    // Formulas (1) to (3) as rows over what was measured. The slopes hold the tilt of the mirror.

    /// The groups of readings of one pass, or of both.
    pub(super) fn groups(&self) -> &'static [Group] {
        if self.both_ways() { &[Some(Direction::Plus), Some(Direction::Minus)] } else { &[None] }
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

    /// What rolls do to the readings that make ramps of the closure of this size, µm from its first interval to its
    /// last: for each axis, by each order of the axes that may be.
    pub(super) fn rolls(&self, ramps_um: &PerAxis<f64>) -> Vec<Vec<Vec<f64>>> {
        let (orders, layout) = (self.campaign.angles.evidence.orders(), self.model.layout);
        let of_axis = |axis: Axis| {
            let rotation = Rotation { about: axis, along: axis };
            let of_order = |order: &[Axis; 3]| {
                let [Cause { mut column, .. }, _] =
                    of_rotation(self.campaign, layout, 1.0, *order, rotation);
                column[layout.line(0)..].fill(0.0); // the readings alone
                let w = |at| self.mean(|group| self.closure(group, axis, at)).dot(&column);
                let ramp = w(self.volume().steps - 1) - w(0);
                let share = ramps_um[axis] / ramp;
                let largest = column.iter().fold(0.0, |most: f64, um| most.max(um.abs()));
                let is_ramp = ramp.abs() > ROUNDING * largest;
                is_ramp.then(|| column.iter().map(|um| share * um).collect())
            };
            orders.iter().filter_map(of_order).collect()
        };
        Axis::ALL.into_iter().filter(|axis| ramps_um[*axis] > 0.0).map(of_axis).collect()
    }
}

/// σ of a reading before the closure is judged: repeats say most; else the closure itself, unless it leaves few
/// degrees of freedom and the job states one.
fn known_noise(campaign: &Campaign<'_>, repeats: Option<Noise>) -> Option<Noise> {
    let stated_um = campaign.stated.noise_um;
    let measurement = campaign.measurement;
    let of_closure =
        3 * measurement.volume.steps >= ENOUGH + 3 && measurement.kind == PathKind::Step;
    let (stated, source) = (stated_um.filter(|_| !of_closure), NoiseSource::Stated);
    let stated = stated.map(|sigma_um| Noise { sigma_um, freedom: None, source });
    repeats.map(|found| found.with_stated(stated_um)).or(stated)
}
