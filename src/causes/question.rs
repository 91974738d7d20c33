//! What is known when a cause is asked for.

use crate::after::{Control, Observation, Part};
use crate::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::model::ErrorModel;
use crate::units::{Deviation, Millimetres};

/// A correction that no laser resolves is none, µm.
const SMALLEST_UM: f64 = 0.01;

/// What is known when a cause is asked for.
#[derive(Clone, Debug)]
pub struct Question<'a> {
    /// As found.
    pub before: &'a ErrorModel,
    /// What the loaded tables add.
    pub control: &'a Control,
    /// The values of the second measurement.
    pub seen: &'a [Observation],
    /// Direction of the reference return of each axis.
    pub homing: PerAxis<Direction>,
    /// Reference point of each axis, mm.
    pub reference_mm: PerAxis<f64>,
    /// Expansion of each scale, 1/K.
    pub alpha_per_k: PerAxis<f64>,
    /// Largest count of the tables, µm.
    pub count_um: f64,
    /// Largest residual of the forecast, µm.
    pub forecast_um: f64,
}

impl Question<'_> {
    /// The terms that the second measurement sees.
    pub fn terms(&self) -> Vec<ErrorTerm> {
        let seen = |term: &ErrorTerm| {
            let mut parts = self.seen.iter().flat_map(|o| &o.parts);
            parts.any(|part| part.term == *term)
        };
        ErrorTerm::ALL.into_iter().filter(seen).collect()
    }

    pub(super) fn has_two_tables(&self) -> bool {
        self.tabled().any(|(term, at)| {
            let um = Direction::BOTH.map(|way| self.control.tables_um(term, way, at));
            (um[0] - um[1]).abs() > SMALLEST_UM
        })
    }

    pub(super) fn has_parameter(&self) -> bool {
        let ways = |term| Direction::BOTH.map(|way| self.control.constant_um(term, way));
        let terms = ErrorTerm::ALL.into_iter().flat_map(ways);
        terms.into_iter().any(|um| um.abs() > SMALLEST_UM)
    }

    fn tabled(&self) -> impl Iterator<Item = (ErrorTerm, Millimetres)> {
        let nodes = |term: ErrorTerm| {
            let nodes = self.control.nodes(term).into_iter();
            nodes.map(move |at| (term, at))
        };
        ErrorTerm::ALL.into_iter().flat_map(nodes)
    }

    /// What a backlash parameter of −B as found adds: it acts away from the reference direction.
    pub(super) fn parameter_um(&self, axis: Axis, direction: Direction) -> f64 {
        let reversal_um = self.reversal_um(axis).unwrap_or(0.0);
        match direction {
            own if own == self.homing[axis] => 0.0,
            Direction::Minus => reversal_um,
            Direction::Plus => (-Deviation::from_um(reversal_um)).um(),
        }
    }

    /// B of an axis as found, µm.
    pub(super) fn reversal_um(&self, axis: Axis) -> Option<f64> {
        let measured = self.before.terms[ErrorTerm {
            of: axis,
            along: axis,
        }]
        .as_ref()?;
        Some(measured.reversal()?.um())
    }

    /// Mean of both directions: the correction without its part for the reversal, µm.
    pub(super) fn without_reversal_um(&self, part: &Part) -> f64 {
        let way = |direction| {
            let tables = self.control.tables_um(part.term, direction, part.at);
            tables + self.control.constant_um(part.term, direction)
        };
        f64::midpoint(way(Direction::Plus), way(Direction::Minus))
    }

    /// Whether the data see an axis (`None` = any) in both directions, and it had a reversal.
    pub(super) fn shows_reversal(&self, axis: Option<Axis>) -> bool {
        let of = |axis: Axis| {
            let term = ErrorTerm {
                of: axis,
                along: axis,
            };
            let sees = |way: Direction| {
                let mut values = self.seen.iter();
                values.any(|o| o.parts.iter().any(|p| p.term == term && p.direction == way))
            };
            self.reversal_um(axis).is_some() && Direction::BOTH.into_iter().all(sees)
        };
        match axis {
            Some(axis) => of(axis),
            None => Axis::ALL.into_iter().any(of),
        }
    }
}
