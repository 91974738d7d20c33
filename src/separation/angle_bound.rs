//! What angular errors without a measurement can do to the figures, whatever their shape.
//!
//! A figure of the machine is one of the lines through the middle of the box; the readings meet an
//! angle elsewhere. Let r be the value of one rotation about ê at an interval end of its axis,
//! against its value at the low end of the box, c = u × ê, a the way from the middle of the box to
//! the place, of the axes that this one carries only, and m the way moved from the start:
//!
//! ```text
//!   reading       r(x_q) (c·a_q − c·m_q) − r(x_0) (c·a_0 − c·m_q)        lever; with − c·m: flat mirror
//!   true slopes   r(middle) (ê × ê_k) along each axis k that is carried
//!   effect on a figure   Σ over the interval ends |influence of r there| · bound
//!   u² = Σ over the rotations effect²/3                                  rectangular
//! ```
//! The influence of a value runs through the whole solution: increments, formula (1), totals,
//! formula (7), frame. r = 0 at the low end loses nothing: a constant angle is squareness.
//! Levers count from the middle of the box: another origin, or a tool offset, moves the machine's
//! own figures along with the readings.

use super::curves::noise_gain;
use super::metric::{PerPlane, Plane};
use super::plane::per_plane;
use super::slope_gains::SlopeGains;
use crate::axis::{Axis, Direction, ErrorTerm, PerAxis, PerTerm, Rotation};
use crate::diagonal::{Diagonal, PathKind, PerDiagonal, Volume};
use crate::job::Reflector;

/// Standard uncertainties (k = 1) that a bound of 1 µrad on every unmeasured angle makes.
#[derive(Clone, Debug, PartialEq)]
pub struct AngleBound {
    /// Along the curves, µm for each µrad, by interval end.
    pub curves_um: PerTerm<Vec<f64>>,
    /// Of the squareness, µm/m for each µrad.
    pub squareness_um_per_m: PerPlane<f64>,
}

const ALL_ORDERS: [[Axis; 3]; 6] = [
    [Axis::X, Axis::Y, Axis::Z],
    [Axis::X, Axis::Z, Axis::Y],
    [Axis::Y, Axis::X, Axis::Z],
    [Axis::Y, Axis::Z, Axis::X],
    [Axis::Z, Axis::X, Axis::Y],
    [Axis::Z, Axis::Y, Axis::X],
];

impl AngleBound {
    /// Of the rotations that were not measured; where the order of the axes is not known, the
    /// largest of all orders for every figure.
    pub fn of(
        volume: &Volume,
        reflector: Reflector,
        (missing, order): (&[Rotation], Option<[Axis; 3]>),
        gains: &SlopeGains,
    ) -> AngleBound {
        let mut largest = Squares::none(volume);
        let orders = order.as_ref().map_or(&ALL_ORDERS[..], std::slice::from_ref);
        for order in orders {
            let mut all = Squares::none(volume);
            for rotation in missing {
                let rotated = Rotated::new(volume, *order, *rotation, reflector);
                all.add(&rotated.effects(gains));
            }
            largest.raise(&all);
        }
        let u = |square: f64| (square / 3.0).sqrt();
        AngleBound {
            curves_um: PerTerm::from_fn(|term| {
                largest.curves[term].iter().map(|s| u(*s)).collect()
            }),
            squareness_um_per_m: largest.squareness.map(u),
        }
    }

    /// Largest on a curve, µm for each µrad.
    pub fn largest_um(&self, term: ErrorTerm) -> f64 {
        self.curves_um[term].iter().copied().fold(0.0, f64::max)
    }
}

/// Sums over the rotations, of squares; and of one rotation over its values, of amounts.
struct Squares {
    curves: PerTerm<Vec<f64>>,
    squareness: PerPlane<f64>,
}

impl Squares {
    fn none(volume: &Volume) -> Squares {
        Squares {
            curves: PerTerm::from_fn(|_| vec![0.0; volume.steps + 1]),
            squareness: PerPlane::default(),
        }
    }

    fn combine(&mut self, other: &Squares, of: impl Fn(f64, f64) -> f64) {
        for term in ErrorTerm::ALL {
            let pairs = self.curves[term].iter_mut().zip(&other.curves[term]);
            pairs.for_each(|(own, other)| *own = of(*own, *other));
        }
        let squareness = |plane: Plane| of(self.squareness.of(plane), other.squareness.of(plane));
        self.squareness = per_plane(Plane::ALL.map(squareness));
    }

    /// Adds the squares of the effects of a rotation.
    fn add(&mut self, effects: &Squares) {
        self.combine(effects, |sum, effect| sum + effect * effect);
    }

    fn raise(&mut self, other: &Squares) {
        self.combine(other, f64::max);
    }
}

/// What a value of a rotation changes.
struct Change {
    ends_um: PerDiagonal<f64>,
    /// First the separated increments, then their sums, µm.
    raw: PerTerm<Vec<f64>>,
}

/// One rotation of 1 µrad at the readings.
struct Rotated<'a> {
    volume: &'a Volume,
    rotation: Rotation,
    /// What 1 µrad at a node does to its reading, µm.
    own: PerDiagonal<Vec<f64>>,
    /// What 1 µrad at the start does to it, taken off, µm.
    start: PerDiagonal<Vec<f64>>,
    /// Slopes of the machine for 1 µrad in the middle, µm/m.
    true_slopes: PerTerm<f64>,
}

impl<'a> Rotated<'a> {
    fn new(
        volume: &'a Volume,
        order: [Axis; 3],
        rotation: Rotation,
        reflector: Reflector,
    ) -> Rotated<'a> {
        let about = PerAxis::from_fn(|axis| f64::from(axis == rotation.about));
        let place = |axis: Axis| order.iter().position(|other| *other == axis);
        let carried = |axis: Axis| place(axis) > place(rotation.along);
        let mirror = f64::from(reflector == Reflector::FlatMirror);
        let by_node = |d: Diagonal, at_start: bool| -> Vec<f64> {
            let c = volume.laser(d).cross(about);
            let start = volume.inside_mm(d, PathKind::Step, 0);
            let weight = |node: usize| {
                let here = volume.inside_mm(d, PathKind::Step, node);
                let part = |axis: Axis| {
                    let from = if at_start { start[axis] } else { here[axis] };
                    let arm = from - volume.size[axis].mm() / 2.0;
                    let lever = if carried(axis) { arm } else { 0.0 };
                    c[axis] * (lever - mirror * (here[axis] - start[axis])) / 1000.0
                };
                part(Axis::X) + part(Axis::Y) + part(Axis::Z)
            };
            (0..=3 * volume.steps).map(weight).collect()
        };
        let true_slope = |term: ErrorTerm| {
            let along = PerAxis::from_fn(|axis| f64::from(axis == term.along));
            f64::from(carried(term.along)) * about.cross(along)[term.of]
        };
        Rotated {
            volume,
            rotation,
            own: PerDiagonal::from_fn(|d| by_node(d, false)),
            start: PerDiagonal::from_fn(|d| by_node(d, true)),
            true_slopes: PerTerm::from_fn(true_slope),
        }
    }

    /// Sum over the values of the amounts that 1 µrad moves each figure by.
    fn effects(&self, gains: &SlopeGains) -> Squares {
        let volume = self.volume;
        let mut effects = Squares::none(volume);
        let mut change = Change {
            ends_um: PerDiagonal::default(),
            raw: PerTerm::from_fn(|_| vec![0.0; volume.steps + 1]),
        };
        for index in 1..=volume.steps {
            self.fill(&mut change, index);
            self.count(&mut effects, &change, self.middle(index), gains);
        }
        effects
    }

    /// Share of a value in that of the middle of the box.
    fn middle(&self, index: usize) -> f64 {
        match (2 * index).abs_diff(self.volume.steps) {
            0 => 1.0,
            1 => 0.5,
            _ => 0.0,
        }
    }

    /// Adds the amounts by which one value moves the figures.
    fn count(&self, effects: &mut Squares, change: &Change, middle: f64, gains: &SlopeGains) {
        let volume = self.volume;
        let metres = |axis: Axis| volume.size[axis].mm() / 1000.0;
        let separated = PerTerm::from_fn(|term| {
            change.raw[term].last().copied().unwrap_or(0.0) / metres(term.along)
        });
        let truth = |term| middle * gains.in_frame(term, &self.true_slopes);
        for term in ErrorTerm::ALL {
            let found = gains.slope(term, &change.ends_um, &separated);
            let line =
                (found - separated[term] - truth(term)) * metres(term.along) / volume.steps_f64();
            let pairs = effects.curves[term].iter_mut().zip(&change.raw[term]);
            let mut position = 0.0;
            for (sum, raw) in pairs {
                *sum += (raw + position * line).abs();
                position += 1.0;
            }
        }
        let squareness = |plane: Plane| {
            let (a, b) = plane.axes();
            let truth = self.true_slopes[ErrorTerm { of: a, along: b }]
                + self.true_slopes[ErrorTerm { of: b, along: a }];
            let found = gains.of_squareness(plane, &change.ends_um);
            effects.squareness.of(plane) + (found - middle * truth).abs()
        };
        effects.squareness = per_plane(Plane::ALL.map(squareness));
    }

    /// What 1 µrad at interval end `index` ≥ 1 of the axis changes.
    fn fill(&self, change: &mut Change, index: usize) {
        let n = self.volume.steps;
        change.ends_um = PerDiagonal::default();
        for term in ErrorTerm::ALL {
            change.raw[term].fill(0.0);
        }
        let axis = self.rotation.along;
        for d in Diagonal::ALL {
            let made = match d.forward(axis) {
                Direction::Plus => index,
                Direction::Minus => n - index,
            };
            // The nodes at which the axis has made so many steps.
            let first = made.checked_sub(1);
            let first = first.map_or(0, |step| self.volume.node_after(axis, step));
            let after = (self.volume.node_after(axis, made) - 1).min(3 * n);
            for node in first..=after {
                self.reading(change, d, node, self.own[d][node]);
            }
            if made == 0 {
                for node in 0..=3 * n {
                    self.reading(change, d, node, -self.start[d][node]);
                }
            }
        }
        for term in ErrorTerm::ALL {
            let mut sum = 0.0;
            for value in &mut change.raw[term] {
                sum += *value;
                *value = sum;
            }
        }
    }

    /// A reading stands in the increment that arrives at its node and in the one that leaves it.
    fn reading(&self, change: &mut Change, d: Diagonal, node: usize, um: f64) {
        if node > 0 {
            self.increment(change, d, node, um);
        }
        if node < 3 * self.volume.steps {
            self.increment(change, d, node + 1, -um);
        } else {
            change.ends_um[d] += um;
        }
    }

    /// Formula (1) for the increment that arrives at a node.
    fn increment(&self, change: &mut Change, d: Diagonal, node: usize, um: f64) {
        let along = self.volume.moved(node);
        let interval = self.volume.interval(d, along, (node - 1) / 3);
        for of in Axis::ALL {
            let gain = noise_gain(self.volume, of) / 2.0 * d.sign(along) * d.sign(of);
            change.raw[ErrorTerm { of, along }][interval + 1] += gain * um;
        }
    }
}
