//! What the ISG kernel adds to an axis for its volumetric compensation (docs/isg.md §2).
//!
//! ```text
//!   e(p) = Σ dᵢ(pᵢ) + Σ rᵢ(pᵢ) × (positions of the axes behind i) + Σ cᵢ × (positions of i and the axes behind it)
//!
//!   d, r, c    deviations, angles, constants of the files; straight between points, ends held
//!   behind i   nearer to the tool, by `chain`; positions from where levers count; no tool
//! ```
//! The control adds −e. The response to an axis holds its deviations, and its angles at the lever of the axes behind
//! it where they rest. What an angle does as those leave their rest is [`Emulator::rotation`], as in the model of the
//! machine.

use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::{IsgFacts, LeverOrigin, TableSign};
use crate::control::table::isg::{IsgCurve, IsgTables, Parameter};
use crate::quantity::{
    Axis, Correction, Direction, ErrorTerm, Millimetres, PerAxis, PerTerm, Rotation, unit,
};
use crate::read::emulate::{Emulated, Emulator, NodeTable, Response, cannot};
use crate::read::listed::known_axis;
use std::cmp::Ordering;

/// A control with a compensation in memory.
#[derive(Clone, Debug)]
pub struct IsgControl {
    tables: IsgTables,
    state: ControlState,
    axes: PerAxis<Option<AxisState>>,
    /// What is added for each deviation, µm.
    deviations: PerTerm<Option<Response>>,
    /// What is taken off each angle, µrad.
    angles: PerTerm<Option<Response>>,
    /// What is taken off each constant, µrad.
    turned: PerTerm<f64>,
    /// Where levers count from, mm.
    origin: PerAxis<f64>,
}

/// mm in a metre: µrad × mm = 10⁻³ µm.
const MM_PER_M: f64 = 1000.0;

impl IsgControl {
    /// A control that holds these tables.
    ///
    /// **unit** `state.unit` has no say: the files are in mm · **limits** fails if an axis is not one of the
    /// control, and where angles act on axes whose correction is turned round or left out
    pub fn new(tables: &IsgTables, facts: &IsgFacts, state: &ControlState) -> Emulated<IsgControl> {
        let is_changed = |axis: &Axis| tables.negated[*axis] || tables.zeroed[*axis];
        if tables.has_angles() && Axis::ALL.iter().any(is_changed) {
            return cannot("`negate` and `set_to_zero` beside angles are not emulated");
        }
        let mut axes = PerAxis::default();
        for (axis, number) in tables.axes.iter() {
            if let Some(number) = number {
                axes[axis] = Some(known_axis(state, &number.to_string())?.clone());
            }
        }
        let response = |parameter, sign| response(tables.curve(parameter)?, sign);
        let origin = |axis: Axis| match (facts.lever_origin.value, &axes[axis]) {
            (LeverOrigin::Reference, Some(own)) => own.reference.mm(),
            _ => 0.0,
        };
        let origin = PerAxis::from_fn(origin);
        let (error, angle) = (facts.error_sign.value, facts.angle_sign.value);
        let rotation = |term: ErrorTerm| Rotation { about: term.of, along: term.along };
        Ok(IsgControl {
            deviations: PerTerm::from_fn(|term| {
                let sign = if tables.negated[term.of] { error.turned() } else { error };
                response(Parameter::Deviation(term), sign)
            }),
            angles: PerTerm::from_fn(|term| response(Parameter::Angle(rotation(term)), angle)),
            turned: PerTerm::from_fn(|term| {
                let own = response(Parameter::Turned(rotation(term)), angle);
                own.map_or(0.0, |own| own.correction(Millimetres::new(0.0)).um())
            }),
            tables: tables.clone(),
            state: state.clone(),
            axes,
            origin,
        })
    }

    /// What is taken off the angles of an axis where it stands, µrad.
    fn angles_at(&self, along: Axis, at: f64) -> PerAxis<f64> {
        let at = Millimetres::new(at);
        PerAxis::from_fn(|about| {
            let own = self.angles[Rotation { about, along }].as_ref();
            own.map_or(0.0, |own| own.correction(at).um())
        })
    }

    /// Where an axis rests, mm.
    fn rest(&self, axis: Axis) -> f64 {
        self.axes[axis].as_ref().map_or(0.0, |own| own.rest.mm())
    }

    /// The axes from one towards the tool, or towards the workpiece, without it.
    fn beside(&self, axis: Axis, behind: bool) -> impl Iterator<Item = Axis> {
        let place = |axis: Axis| self.tables.chain.iter().position(|other| *other == axis);
        let own = place(axis);
        let side = if behind { Ordering::Greater } else { Ordering::Less };
        let is_there = move |other: &&Axis| place(**other).cmp(&own) == side;
        self.tables.chain.iter().filter(is_there).copied()
    }

    /// The most that an angle takes off anywhere, µrad.
    fn largest_angle(&self, rotation: Rotation) -> f64 {
        let own = self.angles[rotation].iter();
        let nodes = own.flat_map(|own| own.tables()).flat_map(NodeTable::nodes);
        nodes.map(|(_, value)| value.um().abs()).fold(0.0, f64::max)
    }

    /// The farthest that an axis gets from its rest, mm.
    fn farthest(&self, axis: Axis) -> f64 {
        self.axes[axis].as_ref().map_or(0.0, |own| {
            let far = |end: Millimetres| (end - own.rest).mm().abs();
            own.travel().map(far).into_iter().fold(0.0, f64::max)
        })
    }

    /// What the angles of an axis do to another as the axes behind it leave their rest, µm: at a place, or at most.
    fn swing_by(&self, along: Axis, of: Axis, at: Option<&PerAxis<f64>>) -> f64 {
        let um = self.beside(along, true).filter(|axis| *axis != of).map(|arm| match at {
            Some(at) => {
                let way = unit(arm).times(at[arm] - self.rest(arm));
                self.angles_at(along, at[along]).cross(way)[of]
            }
            None => {
                let about = Axis::ALL.into_iter().find(|axis| ![of, arm].contains(axis));
                let most = |about| self.largest_angle(Rotation { about, along });
                about.map_or(0.0, most) * self.farthest(arm)
            }
        });
        um.sum::<f64>() / MM_PER_M
    }

    /// The lever of an axis's angles while the others rest, mm.
    fn arm(&self, along: Axis) -> PerAxis<f64> {
        let arms = self.beside(along, true);
        let arms = arms.map(|axis| unit(axis).times(self.rest(axis) - self.origin[axis]));
        arms.fold(PerAxis::default(), PerAxis::plus)
    }

    /// What turns the way of an axis: the constants of it and of the axes before it.
    fn tilt(&self, along: Axis) -> PerAxis<f64> {
        let before = self.beside(along, false).chain([along]);
        let turned = before
            .map(|axis| PerAxis::from_fn(|about| self.turned[Rotation { about, along: axis }]));
        turned.fold(PerAxis::default(), PerAxis::plus)
    }

    /// What `of` gets for angles and constants while `along` stands at a place, the others at rest, µm.
    fn swung(&self, of: Axis, along: Axis, at: f64) -> f64 {
        let swung = self.angles_at(along, at).cross(self.arm(along));
        let tilted = self.tilt(along).cross(unit(along).times(at - self.origin[along]));
        let um = swung.plus(tilted)[of] / MM_PER_M;
        if self.tables.negated[of] { -um } else { um }
    }

    /// Every place where what angles and constants do while an axis moves bends; none where they do nothing.
    fn bends(&self, along: Axis) -> Vec<f64> {
        let swings = self.arm(along).length() > 0.0;
        let angle = |about| self.tables.curve(Parameter::Angle(Rotation { about, along }));
        let angles = Axis::ALL.into_iter().filter_map(angle).filter(|_| swings);
        let points = angles.flat_map(|curve| &curve.points);
        let mut places: Vec<f64> = points.map(|point| point.position).collect();
        if let (true, Some(own)) = (self.tilt(along).length() > 0.0, &self.axes[along]) {
            places.extend(own.travel().map(Millimetres::mm));
        }
        places.sort_by(f64::total_cmp);
        places.dedup_by(|a, b| a.total_cmp(b).is_eq());
        places
    }
}

impl Emulator for IsgControl {
    /// Those of deviations: what an angle does to an axis depends on where the others rest.
    fn connected_axes(&self) -> Vec<(String, String)> {
        let name = |axis: Axis| self.tables.axes[axis].map(|number| number.to_string());
        let pair =
            |(term, _): (ErrorTerm, &Option<Response>)| Some((name(term.along)?, name(term.of)?));
        self.deviations.iter().filter(|(_, own)| own.is_some()).filter_map(pair).collect()
    }

    fn response(&self, base: &str, output: &str, direction: Direction) -> Emulated<Response> {
        let (known, other) = (known_axis(&self.state, base)?, known_axis(&self.state, output)?);
        let backlash = match known.name == other.name {
            true => known.backlash(direction),
            false => Correction::ZERO,
        };
        let pair = self.tables.axis(&known.name).zip(self.tables.axis(&other.name));
        let pair = pair.filter(|(_, of)| !self.tables.zeroed[*of]);
        let mut response = Response::new(Vec::new(), backlash);
        if let Some((along, of)) = pair {
            let places = self.bends(along);
            let swung = |at: &f64| Correction::from_um(self.swung(of, along, *at));
            let values: Vec<Correction> = places.iter().map(swung).collect();
            let deviation = self.deviations[ErrorTerm { of, along }].clone();
            let swung = Response::straight(&places, &values);
            deviation.into_iter().chain(swung).for_each(|own| response.add(own));
        }
        Ok(response)
    }

    fn rotation(&self, base: &str, about: Axis) -> Option<Response> {
        self.angles[Rotation { about, along: self.tables.axis(base)? }].clone()
    }

    fn swing(&self, output: &str, at: Option<PerAxis<f64>>) -> f64 {
        let Some(of) = self.tables.axis(output) else {
            return 0.0;
        };
        let along = Axis::ALL.into_iter();
        along.map(|along| self.swing_by(along, of, at.as_ref())).sum()
    }

    fn levers(&self) -> Option<[Axis; 3]> {
        self.tables.has_angles().then_some(self.tables.chain)
    }
}

/// What is added for a curve, µm or µrad.
fn response(curve: &IsgCurve, sign: TableSign) -> Option<Response> {
    let points = curve.points.iter();
    let mm: Vec<f64> = points.clone().map(|point| point.position).collect();
    let values = points.map(|point| sign.correction(point.value * curve.parameter.per_unit()));
    Response::straight(&mm, &values.collect::<Vec<Correction>>())
}

#[cfg(test)]
mod tests;
