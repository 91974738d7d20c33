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

use super::campaign::Campaign;
use super::curves::noise_gain;
use super::metric::PerPlane;
use super::plane::Unknown;
use super::slopes::SlopeGains;
use crate::inputs::job::{Reflector, StatedUncertainty};
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis, PerTerm, Rotation};
use crate::quantity::diagonal::{Diagonal, PathKind, PerDiagonal, Volume};

/// Standard uncertainties (k = 1) that a bound of 1 µrad on every unmeasured angle makes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AngleBound {
    /// Along the curves, µm for each µrad, by interval end.
    pub(super) curves_um: PerTerm<Vec<f64>>,
    /// Of the squareness, µm/m for each µrad.
    pub(super) squareness_um_per_m: PerPlane<f64>,
}

/// Below this a value of 1 µrad does not move a curve, µm.
const DUST_UM: f64 = 1e-12;

impl AngleBound {
    /// Of the rotations that were not measured, `None` where all were; where the order of the axes is
    /// not known, the largest of all orders for every figure.
    pub(super) fn of(campaign: &Campaign<'_>, gains: &SlopeGains) -> Option<AngleBound> {
        let evidence = campaign.angle_evidence();
        let volume = &campaign.measurement.volume;
        if evidence.missing.is_empty() {
            return None;
        }
        let mut largest = Squares::none(volume);
        let walks = Walks::new(volume, campaign.measurement.target);
        let mut known: Vec<(Rotation, PerAxis<bool>, Squares)> = Vec::new();
        let orders = evidence.order.as_ref();
        for order in orders.map_or(&Axis::ORDERS[..], std::slice::from_ref) {
            let mut all = Squares::none(volume);
            for rotation in &evidence.missing {
                let carried = carried(order, rotation.along);
                let same = |(r, c, _): &(_, _, _)| (r, c) == (rotation, &carried);
                let place = known.iter().position(same).unwrap_or_else(|| {
                    let effects = Rotated::new(&walks, *rotation, carried).effects(gains);
                    known.push((*rotation, carried, effects));
                    known.len() - 1
                });
                all.combine(&known[place].2, |sum, effect| sum + effect * effect);
            }
            largest.combine(&all, f64::max);
        }
        let u = |square: f64| (square / 3.0).sqrt();
        Some(AngleBound {
            curves_um: PerTerm::from_fn(|term| {
                largest.curves[term].iter().map(|s| u(*s)).collect()
            }),
            squareness_um_per_m: largest.squareness.map(u),
        })
    }

    /// Uncertainty of φ with the bound that the job states, µm/m; 0 where it states none.
    pub(super) fn counted(bound: Option<&AngleBound>, stated: &StatedUncertainty) -> PerPlane<f64> {
        let counted = bound.zip(stated.angle_urad);
        counted.map_or_else(PerPlane::default, |(bound, urad)| {
            bound.squareness_um_per_m.map(|u| urad * u)
        })
    }

    /// Largest on a curve, µm for each µrad.
    pub(super) fn largest_um(&self, term: ErrorTerm) -> f64 {
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
        self.squareness =
            PerPlane::from_fn(|plane| of(self.squareness.of(plane), other.squareness.of(plane)));
    }
}

/// The axes that an axis carries: those after it on the way from the workpiece to the tool.
fn carried(order: &[Axis; 3], by: Axis) -> PerAxis<bool> {
    let place = |axis: Axis| order.iter().position(|other| *other == axis);
    PerAxis::from_fn(|axis| place(axis) > place(by))
}

/// What a value of a rotation changes.
struct Change {
    ends_um: PerDiagonal<f64>,
    /// Of the separated increments, by interval, µm.
    steps_um: PerTerm<Vec<f64>>,
    /// Their sums, µm.
    totals_um: PerTerm<f64>,
}

/// The passes along the diagonals, whatever turns.
struct Walks<'a> {
    volume: &'a Volume,
    /// Places of the nodes from the low corner of the box, mm.
    inside_mm: PerDiagonal<Vec<PerAxis<f64>>>,
    /// R/4V of formula (1).
    gain: PerAxis<f64>,
    /// 1 where the mirror turns with the tool, else 0.
    mirror: f64,
}

impl Walks<'_> {
    fn new(volume: &Volume, reflector: Reflector) -> Walks<'_> {
        let places = |d: Diagonal| -> Vec<PerAxis<f64>> {
            let nodes = 0..=3 * volume.steps;
            let place = |node| volume.inside_mm(d, PathKind::Step, node);
            nodes.map(place).collect()
        };
        Walks {
            volume,
            inside_mm: PerDiagonal::from_fn(places),
            gain: PerAxis::from_fn(|axis| noise_gain(volume, axis) / 2.0),
            mirror: f64::from(reflector == Reflector::FlatMirror),
        }
    }
}

/// One rotation of 1 µrad at the readings.
struct Rotated<'a> {
    walks: &'a Walks<'a>,
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
    fn new(walks: &'a Walks<'a>, rotation: Rotation, carried: PerAxis<bool>) -> Rotated<'a> {
        let volume = walks.volume;
        let about = PerAxis::from_fn(|axis| f64::from(axis == rotation.about));
        let middle = PerAxis::from_fn(|axis| volume.size[axis].mm() / 2.0);
        let by_node = |d: Diagonal, at_start: bool| -> Vec<f64> {
            let c = volume.laser(d).cross(about).times(1.0 / 1000.0);
            let lever = PerAxis::from_fn(|axis| f64::from(carried[axis]) * c[axis]);
            let places = &walks.inside_mm[d];
            let Some(start) = places.first() else {
                return Vec::new();
            };
            let weight = |here: &PerAxis<f64>| {
                let from = if at_start { start } else { here };
                lever.dot(from.minus(middle)) - walks.mirror * c.dot(here.minus(*start))
            };
            places.iter().map(weight).collect()
        };
        let true_slope = |term: ErrorTerm| {
            let along = PerAxis::from_fn(|axis| f64::from(axis == term.along));
            f64::from(carried[term.along]) * about.cross(along)[term.of]
        };
        Rotated {
            walks,
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
            steps_um: PerTerm::from_fn(|_| vec![0.0; volume.steps]),
            totals_um: PerTerm::default(),
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
        let metres = |axis: Axis| self.volume.size[axis].mm() / 1000.0;
        let separated = PerTerm::from_fn(|term| change.totals_um[term] / metres(term.along));
        let truth = |term| middle * gains.in_frame(term, &self.true_slopes);
        for term in ErrorTerm::ALL {
            let found = gains.slope(term, &change.ends_um, &separated);
            let line = found - separated[term] - truth(term);
            let line_um = line * metres(term.along) / self.volume.steps_f64();
            let steps = &change.steps_um[term];
            if line_um.abs() < DUST_UM && steps.iter().all(|um| um.abs() < DUST_UM) {
                continue;
            }
            // The first value of a curve is 0.
            let sums = effects.curves[term].iter_mut().skip(1);
            let mut moved = 0.0;
            for (sum, step) in sums.zip(steps) {
                moved += step + line_um;
                *sum += moved.abs();
            }
        }
        effects.squareness = PerPlane::from_fn(|plane| {
            let [one, other] = plane.terms().map(|term| self.true_slopes[term]);
            let found = gains.of_figure(Unknown::Squareness(plane), &change.ends_um);
            effects.squareness.of(plane) + (found - middle * (one + other)).abs()
        });
    }

    /// What 1 µrad at interval end `index` ≥ 1 of the axis changes.
    fn fill(&self, change: &mut Change, index: usize) {
        let n = self.volume.steps;
        change.ends_um = PerDiagonal::default();
        change.totals_um = PerTerm::default();
        for term in ErrorTerm::ALL {
            change.steps_um[term].fill(0.0);
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
            let step = um * self.walks.gain[of] * d.sign(along) * d.sign(of);
            let term = ErrorTerm { of, along };
            change.steps_um[term][interval] += step;
            change.totals_um[term] += step;
        }
    }
}
