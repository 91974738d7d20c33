//! (a) to (e): node by node and in between, one term, one output, one direction after the other.

use super::case::{Case, Held, STEEPEST_UM_PER_MM};
use crate::support::machine::{MachineAxis, Term};
use crate::support::{self, DUST_UM, Lines, um_at};
use nonius::control::controller::Dialect;
use nonius::quantity::{Direction, Interpolation};
use nonius::read::emulate::{Emulator, Response};
use nonius::write::compensation::Placement;
use nonius::write::plan::PlannedTable;
use std::fmt::Arguments;

/// Every claim on what one term gets, in both directions; of how many tables the sign was turned.
pub(crate) fn cancels(
    case: &Case<'_>,
    term: &Term,
    pair: (&str, &str),
    turned: &dyn Emulator,
) -> usize {
    let mut doubled = 0;
    for direction in Direction::BOTH {
        let way = OneWay::of(case, term, pair, direction);
        way.count_is_as_printed();
        way.nodes_lie_on_the_grid();
        way.nodes_cover_the_travel();
        way.nodes_cancel();
        way.places_between_nodes_cancel();
        way.reference_is_zero();
        way.parameter_holds_the_reversal();
        let turned = support::response(turned, pair.0, pair.1, direction);
        doubled += usize::from(way.turned_sign_doubles(&Held::of(&turned)));
    }
    doubled
}

struct OneWay<'a> {
    case: &'a Case<'a>,
    term: &'a Term,
    direction: Direction,
    output: &'a str,
    axis: &'a MachineAxis,
    planned: &'a PlannedTable,
    placement: &'a Placement,
    response: Response,
    held: Held,
    /// What the control adds everywhere, beside the table, µm.
    constant_um: f64,
    two_tables: bool,
}

impl<'a> OneWay<'a> {
    fn of(
        case: &'a Case<'a>,
        term: &'a Term,
        (base, output): (&str, &'a str),
        direction: Direction,
    ) -> OneWay<'a> {
        let is_it =
            |of, own: Option<Direction>| of == term.term && own.is_none_or(|own| own == direction);
        let mut planned = case.kit.plan.tables.iter();
        let mut placed = case.kit.compiled.placements.iter();
        let response = support::response(case.control, base, output, direction);
        let held = Held::of(&response);
        OneWay {
            case,
            term,
            direction,
            output,
            axis: case.machine.axis(term.term.along),
            planned: planned.find(|t| is_it(t.term, t.direction)).unwrap(),
            placement: placed.find(|p| is_it(p.term, p.direction)).unwrap(),
            constant_um: um_at(&response, held.mm[0]) - held.um[0],
            two_tables: case.two_tables(term),
            response,
            held,
        }
    }

    #[track_caller]
    fn near(&self, what: Arguments<'_>, off: f64, room: f64) {
        let OneWay { term, direction, output, .. } = self;
        assert!(
            off.abs() <= room,
            "{}{direction} on {output}: {what}: off by {off}, allowed {room}",
            term.term
        );
    }

    fn target(&self, x: f64) -> f64 {
        self.term.target(self.case.machine, self.two_tables, self.direction, x)
    }

    fn range(&self) -> (f64, f64) {
        let (first, last) = self.planned.grid.range();
        (first.mm(), last.mm())
    }

    fn is_on_grid(&self, x: f64) -> bool {
        let (first, last) = self.range();
        x >= first - 1e-3 && x <= last + 1e-3
    }

    /// The places that the nodes stand for, counted from the reference point.
    fn anchored(&self) -> Vec<f64> {
        let (step, reference) = (self.held.step(), self.axis.reference);
        let exact = |x: &f64| reference + ((x - reference) / step).round() * step;
        self.held.mm.iter().map(exact).collect()
    }

    /// What the rounding of a position moves a correction by, at most.
    fn place_um(&self) -> f64 {
        self.case.half_position_digit() * STEEPEST_UM_PER_MM
    }

    /// Half a count, or what the fit of a four-point line leaves.
    fn half_um(&self) -> f64 {
        let half = self.case.count_um(self.term.term, self.output) / 2.0;
        // LinuxCNC holds a value of a COMP_FILE as a C float.
        let largest = self.held.um.iter().fold(0.0_f64, |most, um| most.max(um.abs()));
        let is_float = self.is_of_linuxcnc() && !self.adds_up();
        let float_um = if is_float { largest * f64::from(f32::EPSILON) } else { 0.0 };
        self.placement.fit_residual_um.unwrap_or(half) + float_um
    }

    /// The curves of a HAL file add up to the table.
    fn adds_up(&self) -> bool {
        self.is_of_linuxcnc() && self.term.term.is_cross()
    }

    fn is_of_linuxcnc(&self) -> bool {
        matches!(self.case.profile.dialect, Dialect::Linuxcnc(_))
    }

    /// The table as the fit made it; `sample` is the curve itself, by the test's own figures.
    fn wanted(&self) -> Vec<f64> {
        let (first, _) = self.range();
        let step = self.held.step();
        let carried = self.term.reversal_in_table(self.case.machine, self.direction);
        let wanted = |x: f64| match self.case.machine.fit {
            "sample" => self.target(x),
            _ => {
                let node = ((x - first) / step).round() as usize;
                self.planned.values[node.min(self.planned.values.len() - 1)].um() + carried
            }
        };
        self.anchored().into_iter().map(wanted).collect()
    }

    fn count_is_as_printed(&self) {
        let count = self.case.count_um(self.term.term, self.output);
        let printed = self.placement.count_um;
        self.near(format_args!("count {printed} ≠ {count}"), printed - count, 5e-13);
    }

    /// Nodes lie on the grid anchored on the reference, and every point of it is a node.
    fn nodes_lie_on_the_grid(&self) {
        let room = self.case.half_position_digit() + 1e-9;
        for (x, exact) in self.held.mm.iter().zip(self.anchored()) {
            self.near(format_args!("node {x} is not at {exact}"), x - exact, room);
        }
        let nodes = self.held.mm.iter().filter(|x| self.is_on_grid(**x));
        assert_eq!(nodes.count(), self.planned.grid.count(), "nodes {:?}", self.held.mm);
    }

    /// They cover the travel, but for the rounding of the written spacing.
    fn nodes_cover_the_travel(&self) {
        let digit = match &self.case.profile.dialect {
            Dialect::Fanuc(_) if self.case.machine.inch => 1e-4 * 25.4,
            Dialect::Fanuc(_) => 1e-3,
            _ => 2.0 * self.case.half_position_digit(),
        };
        let short = digit * self.held.mm.len() as f64 / 2.0 + 1e-6 * self.held.step();
        let (first, last) = self.range();
        assert!(first <= self.axis.low + short && last >= self.axis.high - short);
    }

    /// Table and constant: what the tables themselves do at a point.
    fn nodes_cancel(&self) {
        // The reversal of two tables in a constant (Fanuc 3627) belongs to the table.
        let constant = if self.has_parameter() { 0.0 } else { self.constant_um };
        let bound = self.half_um() + DUST_UM + self.place_um();
        let nodes = self.held.mm.iter().zip(&self.held.um).zip(self.wanted());
        for ((x, um), wanted) in nodes.filter(|((x, _), _)| self.is_on_grid(**x)) {
            let what = format_args!("at {x}: wanted {wanted}, held {um}");
            self.near(what, wanted + um + constant, bound);
        }
    }

    /// Half a count, the grid's own residual, half an increment of a control that adds steps.
    fn places_between_nodes_cancel(&self) {
        let (first, last) = self.range();
        let table = Lines { mm: self.anchored(), um: self.wanted() };
        let parameter = if self.has_parameter() { self.constant_um } else { 0.0 };
        let (half, place_um) = (self.half_um(), self.place_um());
        let mut worst_grid = 0.0_f64;
        for x in self.case.places(self.term, &self.held, self.axis.low, self.axis.high) {
            let target = self.target(x);
            let own = (target - table.at(x.clamp(first, last))).abs();
            worst_grid = worst_grid.max(own);
            let jump = self.case.jump_um(self.term, &self.held, x);
            let correction = um_at(&self.response, x) - parameter;
            let what = format_args!("at {x}: deviation {target}, correction {correction}");
            self.near(what, target + correction, half + own + jump + place_um + DUST_UM);
        }
        self.grid_residual_is_as_printed(worst_grid);
    }

    fn grid_residual_is_as_printed(&self, seen: f64) {
        let printed = self.placement.grid_residual_um;
        let room = DUST_UM + self.place_um();
        let above = match self.case.machine.kind {
            Interpolation::Linear => room,
            _ => 0.02 * printed + 0.01,
        };
        let what = format_args!("grid residual {printed}, seen {seen}");
        self.near(what, printed - seen, if printed < seen { room } else { above });
    }

    /// Zero at the reference; the other direction carries the reversal.
    fn reference_is_zero(&self) {
        let (place_um, reference) = (self.place_um(), self.axis.reference);
        let at_reference = um_at(&self.response, reference);
        let mut placed = self.case.kit.compiled.placements.iter();
        let carried = self.term.reversal_in_table(self.case.machine, self.direction);
        let has_two = carried.abs() > 0.0
            || placed.any(|p| p.term == self.term.term && p.direction.is_some());
        let what = format_args!("at the reference");
        if self.direction == self.term.homing || !(has_two || self.has_parameter()) {
            let node = self.held.um[self.held.node_at(reference)];
            self.near(what, node, if self.adds_up() { DUST_UM } else { 0.0 });
            self.near(what, self.constant_um, DUST_UM);
            self.near(what, at_reference, place_um + DUST_UM);
        } else if has_two {
            let room = self.half_um() + place_um + DUST_UM;
            self.near(what, at_reference + self.target(reference), room);
        }
    }

    /// Whether the backlash parameter carries the reversal of this term.
    fn has_parameter(&self) -> bool {
        !self.case.machine.replaces_backlash
            && self.case.machine.policy == Some("curve-and-parameter")
            && self.term.both_ways()
            && self.term.term.is_positioning()
    }

    fn parameter_holds_the_reversal(&self) {
        if !self.has_parameter() {
            return;
        }
        let expected = match (self.direction == self.term.homing, self.term.homing) {
            (true, _) => 0.0,
            (false, Direction::Plus) => self.term.reversal(),
            (false, Direction::Minus) => -self.term.reversal(),
        };
        let last_digit = match self.case.profile.dialect {
            Dialect::Siemens(_) if self.case.machine.inch => 0.254,
            Dialect::Fanuc(_) => self.case.machine.axis(self.term.term.of).unit_um.unwrap(),
            _ => 0.1,
        };
        let what = format_args!("constant, expected {expected}");
        self.near(what, self.constant_um - expected, last_digit / 2.0 + 1e-6);
    }

    /// (c) With every sign turned the residual doubles; whether the deviation is large enough to see that.
    fn turned_sign_doubles(&self, turned: &Held) -> bool {
        let generic = support::is_generic(self.case.profile);
        for (a, b) in self.held.um.iter().zip(&turned.um) {
            assert!(generic || (a + b).abs() < DUST_UM, "the sign acts on every node");
        }
        let reference = self.axis.reference;
        let zero = self.target(reference);
        let at_reference = self.held.um[self.held.node_at(reference)];
        let (mut deviation, mut left) = (0.0_f64, 0.0_f64);
        let nodes = self.held.mm.iter().zip(&self.held.um);
        for (x, um) in nodes.filter(|(x, _)| self.is_on_grid(**x)) {
            let own = self.target(*x) - zero;
            deviation = deviation.max(own.abs());
            left = left.max((own - (um - at_reference)).abs());
        }
        // The table of a fit may leave the curve, a four-point line does.
        let count = self.case.count_um(self.term.term, self.output);
        let of_fit = self.case.machine.fit != "sample";
        let slack = count.max(self.placement.fit_residual_um.unwrap_or(0.0))
            + if of_fit { self.placement.grid_residual_um } else { 0.0 };
        let is_seen = deviation > 12.0 * slack && deviation > 0.1;
        let name = self.term.term;
        assert!(!is_seen || left >= 1.9 * deviation, "{name}: {deviation}, turned {left}");
        is_seen
    }
}
