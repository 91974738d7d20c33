//! What is taken off the readings before they are separated: expansion of the scales and the
//! effects of angular errors. The raw readings stay as they are.

use super::curves::{at, mean};
use super::findings::SeparationFinding;
use crate::inputs::error_table::{ErrorTable, Series};
use crate::inputs::job::{AxisMaterial, Levers, Material, Reflector};
use crate::quantity::axis::{Axis, Direction, PerAxis, Rotation};
use crate::quantity::chain::{Chain, displaced};
use crate::quantity::diagonal::{Diagonal, Pass, PathKind, PerDiagonal, Run, Volume};
use crate::quantity::units::Deviation;
use crate::text::problem::{Problem, Problems};

/// How far a table may fall short of the measured box, mm.
pub(super) const END_TOLERANCE_MM: f64 = 0.01;
/// Reference temperature of ISO 1, °C.
pub const REFERENCE_C: f64 = 20.0;

/// Expansion of the scales at a node, µm: Σ_k α_k (T_k − 20 °C) u_dk (P_k(q) − P_k(0)), one
/// temperature and coefficient for each axis.
pub(crate) fn expansion_um(
    volume: &Volume,
    kind: PathKind,
    material: &Material,
    run: &Run,
    node: usize,
) -> f64 {
    let laser = volume.laser(run.diagonal);
    let here = volume.inside_mm(run.diagonal, kind, node);
    let start = volume.inside_mm(run.diagonal, kind, 0);
    let of_axis = |axis: Axis| {
        let material = material.axes[axis]?;
        let recorded = run.temperatures_c[axis].as_ref();
        let temperature = recorded.map_or(material.temperature_c, |t| t.get(node).copied())?;
        let strain = material.alpha_per_k * (temperature - REFERENCE_C);
        Some(1000.0 * strain * laser[axis] * (here[axis] - start[axis]))
    };
    Axis::ALL.into_iter().filter_map(of_axis).sum()
}

/// The material with the mean of the recorded temperatures where the readings carry their own.
pub fn recorded(material: &Material, runs: &[Run]) -> Material {
    let mean = |axis: Axis| {
        let recorded = runs.iter().filter_map(|run| run.temperatures_c[axis].as_ref());
        let mut all = recorded.flatten().copied().peekable();
        all.peek().is_some().then(|| mean(all))
    };
    Material {
        axes: PerAxis::from_fn(|axis| {
            material.axes[axis].map(|known| AxisMaterial {
                temperature_c: mean(axis).or(known.temperature_c),
                ..known
            })
        }),
        ..*material
    }
}

/// The run with the expansion of the scales taken off.
pub(crate) fn without_expansion(
    volume: &Volume,
    kind: PathKind,
    material: &Material,
    run: &Run,
) -> Vec<f64> {
    let correct = |(node, deviation): (usize, &Deviation)| {
        deviation.um() - expansion_um(volume, kind, material, run, node)
    };
    run.deviations.iter().enumerate().map(correct).collect()
}

/// What rotations of the axes do to the readings along a diagonal, µm, by node; `at`: [`displaced`] at a place, mm.
///
/// formula  u · e; flat mirror: + (Σ r − Σ r at the start) × u · lateral distance from the diagonal
pub(super) fn of_rotations(
    (volume, kind, reflector): (&Volume, PathKind, Reflector),
    diagonal: Diagonal,
    at: impl Fn(PerAxis<f64>) -> [PerAxis<f64>; 2],
) -> Vec<f64> {
    let u = volume.laser(diagonal);
    let place = |node| {
        let place = volume.place(diagonal, kind, node);
        PerAxis::from_fn(|axis| place[axis].mm())
    };
    let first = place(0);
    let [first_error, first_turned] = at(first);
    let mirror = f64::from(reflector == Reflector::FlatMirror) / 1000.0;
    let effect = |node| {
        let here = place(node);
        let ([error, turned], moved) = (at(here), here.minus(first));
        let lateral = moved.minus(u.times(u.dot(moved)));
        u.dot(error.minus(first_error)) + mirror * turned.minus(first_turned).cross(u).dot(lateral)
    };
    (0..=volume.last_node(kind)).map(effect).collect()
}

/// Measured angular errors and the levers on which they act.
#[derive(Clone, Debug)]
pub struct AngleModel<'a> {
    table: &'a ErrorTable,
    chain: [Axis; 3],
    levers: Levers,
    /// Where the levers count from, mm.
    origin: PerAxis<f64>,
    reflector: Reflector,
}

impl<'a> AngleModel<'a> {
    /// The model of a job's angles. `chain` is that of contract §1, e.g. `wXYZt`; `origin` =
    /// [`Levers::origin`].
    pub fn new(
        table: &'a ErrorTable,
        chain: Chain,
        (levers, origin): (&Levers, PerAxis<f64>),
        reflector: Reflector,
    ) -> AngleModel<'a> {
        AngleModel { table, chain: chain.order(), levers: *levers, origin, reflector }
    }

    /// Whether no angle is known.
    pub(crate) fn is_empty(&self) -> bool {
        let all = Axis::ALL.into_iter().flat_map(|axis| self.table.series(axis));
        all.flat_map(|s| s.angles_urad.iter()).all(|(_, angles)| angles.is_none())
    }

    /// Whether a rotation is known, in every direction that the table has.
    fn knows(&self, wanted: Rotation) -> bool {
        let all = self.table.series(wanted.along);
        let known = |s: &Series| s.angles_urad[wanted.about].is_some();
        !all.is_empty() && all.iter().all(known)
    }

    /// Rotation of an axis at a machine position less that where its angles are zero (mean of the directions), µrad.
    /// What was not measured counts as zero; [`AngleEvidence`] names it.
    fn rotation(&self, axis: Axis, position: f64, direction: Direction) -> PerAxis<f64> {
        let all = self.table.series(axis);
        let directed = all.iter().find(|s| s.direction == Some(direction));
        let series = directed.or_else(|| all.first());
        PerAxis::from_fn(|about| {
            let urad =
                |s: &Series, place| Some(at(&s.positions, s.angles_urad[about].as_ref()?, place));
            let zero = self.levers.angles_zero[axis]
                .map_or(0.0, |zero| mean(all.iter().filter_map(|s| urad(s, zero.mm()))));
            series.and_then(|s| urad(s, position)).map_or(0.0, |urad| urad - zero)
        })
    }

    /// What is known of the angles and their levers.
    fn evidence(&self, volume: &Volume) -> AngleEvidence {
        let missing = Rotation::all().filter(|rotation| !self.knows(*rotation));
        let mut largest_urad = 0.0f64;
        for axis in Axis::ALL {
            let low = volume.start[axis].mm();
            let at = |place: f64| self.rotation(axis, place, Direction::Plus);
            let change = at(low + volume.size[axis].mm()).minus(at(low));
            let size = change.iter().map(|(_, urad)| urad.abs());
            largest_urad = size.fold(largest_urad, f64::max);
        }
        let uncertain = Rotation::all().filter_map(|rotation| {
            let all = self.table.series(rotation.along).iter();
            let known = all.filter_map(|s| s.angle_uncertainties_urad[rotation.about].as_ref());
            Some((rotation, known.flatten().copied().reduce(f64::max).filter(|u| *u > 0.0)?))
        });
        AngleEvidence {
            uncertain: uncertain.collect(),
            missing: missing.collect(),
            order: Some(self.chain),
            levers: self.levers,
            origin: self.origin,
            largest_urad,
        }
    }

    /// What the angular errors add to the readings of a pass along a diagonal, µm, by node.
    pub fn effect_um(
        &self,
        volume: &Volume,
        kind: PathKind,
        diagonal: Diagonal,
        pass: Pass,
    ) -> Vec<f64> {
        let tool = PerAxis::from_fn(|axis| self.levers.tool.map_or(0.0, |tool| tool[axis].mm()));
        of_rotations((volume, kind, self.reflector), diagonal, |place| {
            let turned = |axis| self.rotation(axis, place[axis], diagonal.travelled(axis, pass));
            displaced(self.chain, turned, place.minus(self.origin), tool)
        })
    }

    /// Problems: angles that do not cover the measured box.
    pub fn check(&self, volume: &Volume) -> Result<(), Problems> {
        let mut problems = Problems::none();
        for axis in Axis::ALL {
            let low = volume.start[axis].mm();
            let high = (volume.start[axis] + volume.size[axis]).mm();
            let measured = |s: &&Series| s.angles_urad.iter().any(|(_, angles)| angles.is_some());
            let series = self.table.series(axis).iter().filter(measured);
            let ends = series.filter_map(|s| s.positions.first().zip(s.positions.last()));
            let short = ends.filter(|(first, last)| {
                first.mm() > low + END_TOLERANCE_MM || last.mm() < high - END_TOLERANCE_MM
            });
            short.for_each(|(first, last)| {
                let problem = Problem::new(format!(
                    "the angles of {axis} are measured from {} to {} mm, but the diagonals go from {low} to {high} mm",
                    first.mm(),
                    last.mm()
                ))
                .at(self.table.header.clone())
                .help("measure the angles over the whole box; nothing is extrapolated");
                problems.push(problem);
            });
        }
        problems.or_ok(())
    }
}

/// Effects of the measured angles on both passes along every diagonal, and what is known of the
/// angles.
#[derive(Clone, Debug)]
pub struct AngleEffects {
    /// µm by node; `None` where no angle was measured.
    by_pass: Option<PerDiagonal<[Vec<f64>; 2]>>,
    /// What was measured and what was not.
    pub evidence: AngleEvidence,
}

impl AngleEffects {
    /// No angle was measured.
    pub fn unmeasured(chain: Option<Chain>) -> AngleEffects {
        let order = chain.map(Chain::order);
        AngleEffects { by_pass: None, evidence: AngleEvidence::nothing(order) }
    }

    /// Effects on a pass, µm by node; `None` where no angle was measured.
    pub fn of(&self, diagonal: Diagonal, pass: Pass) -> Option<&[f64]> {
        let both = &self.by_pass.as_ref()?[diagonal];
        Some(&both[usize::from(pass == Pass::Reverse)])
    }
}

/// The effects of a model on all passes.
pub fn angle_effects(model: &AngleModel<'_>, volume: &Volume, kind: PathKind) -> AngleEffects {
    let of = |diagonal| Pass::BOTH.map(|pass| model.effect_um(volume, kind, diagonal, pass));
    AngleEffects { by_pass: Some(PerDiagonal::from_fn(of)), evidence: model.evidence(volume) }
}

/// What is known of the nine angular errors and of their levers.
#[derive(Clone, Debug, PartialEq)]
pub struct AngleEvidence {
    /// Rotations without a measurement: they count as zero.
    pub missing: Vec<Rotation>,
    /// The largest standard uncertainty of measured rotations, where their columns state it, µrad.
    pub uncertain: Vec<(Rotation, f64)>,
    /// The axes from workpiece to tool; `None` = `machine.chain` is not stated.
    pub order: Option<[Axis; 3]>,
    /// Places that the lever arms count from.
    pub levers: Levers,
    /// Where the lever arms count from, mm ([`Levers::origin`]).
    pub origin: PerAxis<f64>,
    /// Largest change of a measured rotation over the box, µrad.
    pub largest_urad: f64,
}

impl AngleEvidence {
    /// No angle was measured.
    pub fn nothing(order: Option<[Axis; 3]>) -> AngleEvidence {
        AngleEvidence {
            missing: Rotation::all().collect(),
            uncertain: Vec::new(),
            order,
            levers: Levers::default(),
            origin: PerAxis::default(),
            largest_urad: 0.0,
        }
    }

    /// What was not measured, what counts of it, and what the levers were taken for.
    pub(super) fn labels(&self, angle_urad: Option<f64>) -> Vec<SeparationFinding> {
        let mut labels = Vec::new();
        if !self.missing.is_empty() {
            let names: Vec<String> = self.missing.iter().map(ToString::to_string).collect();
            labels.push(SeparationFinding::AnglesMissing {
                names: names.join(", "),
                urad: angle_urad,
                chain_is_stated: self.order.is_some(),
            });
        }
        if self.missing.len() == 9 {
            return labels;
        }
        let far_um = 0.1 * self.largest_urad;
        let without_u = self.missing.len() + self.uncertain.len() < 9;
        labels.push(SeparationFinding::OnLines { lines: self.origin, without_u });
        if self.levers.tool.is_none() {
            labels.push(SeparationFinding::ToolAssumed { far_um });
        }
        labels
    }
}
