//! Formulas (1) and (3): the increments of the nine curves and the totals of the diagonals, as rows over what was
//! measured.

use super::curves::{closure_sign, noise_gain};
use super::linear::{Layout, Row};
use super::readings::{Group, pass_of};
use crate::quantity::axis::{Axis, Direction, ErrorTerm};
use crate::quantity::diagonal::{Diagonal, Pass, Volume};

/// Formulas (1) and (2) as rows over what was measured. The slopes hold the tilt of the mirror.
#[derive(Clone, Copy)]
pub(super) struct Steps<'a> {
    pub(super) volume: &'a Volume,
    pub(super) layout: Layout,
    /// Whether the axes turned without overrun: of the last cell the forward increments stand for both passes.
    turned: bool,
}

impl<'a> Steps<'a> {
    pub(super) fn new(volume: &'a Volume, layout: Layout, turned: bool) -> Steps<'a> {
        Steps { volume, layout, turned }
    }

    /// The groups of readings of one pass, or of both.
    pub(super) fn groups(&self) -> &'static [Group] {
        match self.layout.passes {
            2 => &[Some(Direction::Plus), Some(Direction::Minus)],
            _ => &[None],
        }
    }

    /// m: the reading at the end of a step less that at its beginning.
    fn increment(&self, group: Group, d: Diagonal, axis: Axis, interval: usize) -> Row {
        let step = self.volume.interval(d, axis, interval);
        let is_turn = self.turned && step + 1 == self.volume.steps;
        let pass = if is_turn { Pass::Forward } else { pass_of(group, d, axis) };
        self.moved(pass, d, axis, step)
    }

    /// The reading of a pass at the far end of a step less that at the near one.
    pub(super) fn moved(&self, pass: Pass, d: Diagonal, axis: Axis, step: usize) -> Row {
        let node = self.volume.node_after(axis, step);
        let at = |node| self.layout.reading(pass, d, node);
        Row(vec![(at(node), 1.0), (at(node - 1), -1.0)])
    }

    /// J: the reverse less the forward increment of the last step of an axis.
    pub(super) fn jump(&self, d: Diagonal, axis: Axis) -> Row {
        let of = |pass| self.moved(pass, d, axis, self.volume.steps - 1);
        Row::sum([(1.0, of(Pass::Reverse)), (-1.0, of(Pass::Forward))])
    }

    /// w: closure of an interval.
    pub(super) fn closure(&self, group: Group, axis: Axis, interval: usize) -> Row {
        let of = |d: Diagonal| (closure_sign(d, axis), self.increment(group, d, axis, interval));
        Row::sum(Diagonal::ALL.map(of))
    }

    /// δ of an interval of a term for one group of readings.
    pub(super) fn of(&self, term: ErrorTerm, group: Group, interval: usize) -> Row {
        let gain = noise_gain(self.volume, term.of) / 2.0;
        let of = |d: Diagonal| {
            let sign = gain * d.sign(term.along) * d.sign(term.of);
            (sign, self.increment(group, d, term.along, interval))
        };
        Row::sum(Diagonal::ALL.map(of))
    }

    /// The mean of the groups.
    pub(super) fn mean(&self, of: impl Fn(Group) -> Row) -> Row {
        let groups = self.groups();
        Row::sum(groups.iter().map(|group| (1.0 / groups.len() as f64, of(*group))))
    }

    /// δ of each interval of a term, mean of the groups.
    pub(super) fn mean_of(&self, term: ErrorTerm) -> Vec<Row> {
        let interval = |at| self.mean(|group| self.of(term, group, at));
        (0..self.volume.steps).map(interval).collect()
    }

    /// Sum of the increments of a (diagonal, axis) pair, mean of the groups.
    pub(super) fn sum(&self, d: Diagonal, axis: Axis) -> Row {
        let all = 0..self.volume.steps;
        let of = |group| all.clone().map(move |at| (1.0, self.increment(group, d, axis, at)));
        self.mean(|group| Row::sum(of(group)))
    }
}
