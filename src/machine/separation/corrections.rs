//! What is taken off the readings before they are separated: expansion of the scales and the
//! effects of angular errors. The raw readings stay as they are.

use super::curves::{at, mean};
use crate::inputs::error_table::{ErrorTable, Kind, Series};
use crate::inputs::job::{DiagonalMeasurement, Levers, Material, Reflector};
use crate::machine::findings::SeparationFinding;
use crate::quantity::{
    Axis, Chain, Diagonal, Direction, Pass, PathKind, PerAxis, PerDiagonal, Rotation, Run, Volume,
    displaced,
};
use crate::text::{Problem, joined};

/// How far a table may fall short of the measured box, mm.
const END_TOLERANCE_MM: f64 = 0.01;
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
pub(super) fn recorded(mut material: Material, runs: &[Run]) -> Material {
    for axis in Axis::ALL {
        let recorded = runs.iter().filter_map(|run| run.temperatures_c[axis].as_ref());
        let mut all = recorded.flatten().copied().peekable();
        if let (Some(known), Some(_)) = (&mut material.axes[axis], all.peek()) {
            known.temperature_c = Some(mean(all));
        }
    }
    material
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

/// Rotation of an axis at a machine position less that where its angles are zero (mean of the directions), µrad.
/// What was not measured counts as zero; [`AngleEvidence`] names it.
fn rotation(
    (table, levers): (&ErrorTable, Levers),
    axis: Axis,
    position: f64,
    direction: Direction,
) -> PerAxis<f64> {
    let all = table.series(axis);
    let series = all.iter().find(|s| s.direction == Some(direction)).or_else(|| all.first());
    PerAxis::from_fn(|about| {
        let urad =
            |s: &Series, place| Some(at(&s.positions, s.values.get(&Kind::Angle(about))?, place));
        let zero = levers.angles_zero[axis]
            .map_or(0.0, |zero| mean(all.iter().filter_map(|s| urad(s, zero.mm()))));
        series.and_then(|s| urad(s, position)).map_or(0.0, |urad| urad - zero)
    })
}

/// The problem of positions that do not cover the measured box; what is measured there and what to measure, in words.
pub(super) fn falls_short(
    table: &ErrorTable,
    series: &Series,
    (volume, axis): (&Volume, Axis),
    (is_measured, what): (&str, &str),
) -> Option<Problem> {
    let (first, last) = series.positions.first().zip(series.positions.last())?;
    let (low, high) = (volume.start[axis].mm(), (volume.start[axis] + volume.size[axis]).mm());
    let is_short = first.mm() > low + END_TOLERANCE_MM || last.mm() < high - END_TOLERANCE_MM;
    let (first, last) = (first.mm(), last.mm());
    let words = || {
        format!(
            "{is_measured} measured from {first} to {last} mm, but the diagonals go from {low} to {high} mm"
        )
    };
    let help = format!("measure {what} over the whole box; nothing is extrapolated");
    is_short.then(|| Problem::new(words()).at(table.header.clone()).help(help))
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
        let evidence = AngleEvidence {
            missing: Rotation::all().collect(),
            order: chain.map(Chain::order),
            ..AngleEvidence::default()
        };
        AngleEffects { by_pass: None, evidence }
    }

    /// Of a table; `order`: the axes from workpiece to tool; `origin`: where the levers count from, mm
    /// ([`Levers::origin`]).
    pub fn of_table(
        table: &ErrorTable,
        (order, levers, origin): ([Axis; 3], Levers, PerAxis<f64>),
        measurement: &DiagonalMeasurement,
    ) -> AngleEffects {
        let volume = &measurement.volume;
        let tool = PerAxis::from_fn(|axis| levers.tool.map_or(0.0, |tool| tool[axis].mm()));
        let ray = (volume, measurement.kind, measurement.target);
        let of = |diagonal: Diagonal, pass: Pass| {
            of_rotations(ray, diagonal, |place| {
                let way = |axis| diagonal.travelled(axis, pass);
                let turned = |axis| rotation((table, levers), axis, place[axis], way(axis));
                displaced(order, turned, place.minus(origin), tool)
            })
        };
        let by_pass = PerDiagonal::from_fn(|diagonal| Pass::BOTH.map(|pass| of(diagonal, pass)));
        // Known in every direction that the table has.
        let is_missing = |of: &Rotation| {
            let all = table.series(of.along);
            all.is_empty() || !all.iter().all(|s| s.values.contains_key(&Kind::Angle(of.about)))
        };
        let uncertain = Rotation::all().filter_map(|rotation| {
            let all = table.series(rotation.along).iter();
            let known = all.filter_map(|s| s.uncertainties.get(&Kind::Angle(rotation.about)));
            Some((rotation, known.flatten().copied().reduce(f64::max).filter(|u| *u > 0.0)?))
        });
        let change = |axis: Axis| {
            let low = volume.start[axis].mm();
            let at = |place: f64| rotation((table, levers), axis, place, Direction::Plus);
            let change = at(low + volume.size[axis].mm()).minus(at(low));
            change.iter().map(|(_, urad)| urad.abs()).fold(0.0, f64::max)
        };
        let evidence = AngleEvidence {
            missing: Rotation::all().filter(is_missing).collect(),
            uncertain: uncertain.collect(),
            order: Some(order),
            levers,
            origin,
            largest_urad: Axis::ALL.map(change).into_iter().fold(0.0, f64::max),
        };
        AngleEffects { by_pass: Some(by_pass), evidence }
    }

    /// Effects on a pass, µm by node; `None` where no angle was measured.
    pub fn of(&self, diagonal: Diagonal, pass: Pass) -> Option<&[f64]> {
        Some(&self.by_pass.as_ref()?[diagonal][usize::from(pass == Pass::Reverse)])
    }
}

/// What is known of the nine angular errors and of their levers.
#[derive(Clone, Debug, Default, PartialEq)]
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
    /// Whether anything was measured.
    pub(super) fn has_angles(&self) -> bool {
        self.missing.len() < Rotation::all().count()
    }

    /// The orders that the axes may have.
    pub(super) fn orders(&self) -> &[[Axis; 3]] {
        self.order.as_ref().map_or(&Axis::ORDERS, std::slice::from_ref)
    }

    /// What was not measured, what counts of it, and what the levers were taken for.
    pub(super) fn labels(&self, urad: Option<f64>) -> [Option<SeparationFinding>; 3] {
        let (names, chain_is_stated) = (joined(&self.missing), self.order.is_some());
        let missing = SeparationFinding::AnglesMissing { names, urad, chain_is_stated };
        let without_u = self.missing.len() + self.uncertain.len() < 9;
        let lines = SeparationFinding::OnLines { lines: self.origin, without_u };
        let tool = SeparationFinding::ToolAssumed { far_um: 0.1 * self.largest_urad };
        [
            (!self.missing.is_empty()).then_some(missing),
            self.has_angles().then_some(lines),
            (self.has_angles() && self.levers.tool.is_none()).then_some(tool),
        ]
    }
}
