//! (a) to (e): node by node and in between, one term, one output, one direction after the other.

use super::case::{Case, Held, STEEPEST_UM_PER_MM};
use crate::support::machine::{MachineAxis, Term};
use crate::support::{self, DUST_UM, Lines, um_at};
use nonius::control::controller::Dialect;
use nonius::quantity::{Direction, Interpolation};
use nonius::read::emulate::{Emulator, Response};
use nonius::write::compensation::Placement;
use nonius::write::plan::PlannedTable;

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

/// What one output axis gets while the moving axis travels one way.
struct OneWay<'a> {
    case: &'a Case<'a>,
    term: &'a Term,
    direction: Direction,
    output: &'a str,
    /// The moving axis.
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

    fn name(&self) -> String {
        format!("{}{} on {}", self.term.term, self.direction, self.output)
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
        self.placement.fit_residual_um.unwrap_or(half) + self.float_um()
    }

    /// The curves of a HAL file add up to the table.
    fn adds_up(&self) -> bool {
        let linuxcnc = matches!(self.case.profile.dialect, Dialect::Linuxcnc(_));
        linuxcnc && self.term.term.is_cross()
    }

    /// LinuxCNC holds a value of a COMP_FILE as a C float.
    fn float_um(&self) -> f64 {
        let linuxcnc = matches!(self.case.profile.dialect, Dialect::Linuxcnc(_));
        let is_float = linuxcnc && !self.adds_up();
        let largest = self.held.um.iter().fold(0.0_f64, |most, um| most.max(um.abs()));
        if is_float { largest * f64::from(f32::EPSILON) } else { 0.0 }
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
        assert!((printed - count).abs() < 1e-12, "{}: count {printed} ≠ {count}", self.name());
    }

    /// Nodes lie on the grid anchored on the reference, and every point of it is a node.
    fn nodes_lie_on_the_grid(&self) {
        let half_digit = self.case.half_position_digit();
        for (x, exact) in self.held.mm.iter().zip(self.anchored()) {
            let off = (x - exact).abs();
            assert!(off <= half_digit + 1e-9, "{}: node {x} is not at {exact}", self.name());
        }
        let nodes = self.held.mm.iter().filter(|x| self.is_on_grid(**x));
        let (name, all) = (self.name(), &self.held.mm);
        assert_eq!(nodes.count(), self.planned.grid.count(), "{name}: nodes {all:?}");
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
            let left = wanted + um + constant;
            let what = format!("at {x}: wanted {wanted}, held {um}, left {left}, bound {bound}");
            assert!(left.abs() <= bound, "{}: {what}", self.name());
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
            let left = target + correction;
            let bound = half + own + jump + place_um + DUST_UM;
            assert!(
                left.abs() <= bound,
                "{}: at {x}: deviation {target}, correction {correction}, left {left}, bound {bound} = {half} + {own} + {jump}",
                self.name()
            );
        }
        self.grid_residual_is_as_printed(worst_grid);
    }

    fn grid_residual_is_as_printed(&self, seen: f64) {
        let printed = self.placement.grid_residual_um;
        let room = DUST_UM + self.place_um();
        let near = match self.case.machine.kind {
            Interpolation::Linear => room,
            _ => 0.02 * printed + 0.01,
        };
        let is_near = (seen - room..=seen + near).contains(&printed);
        assert!(is_near, "{}: grid residual {printed}, seen {seen}", self.name());
    }

    /// Zero at the reference; the other direction carries the reversal.
    fn reference_is_zero(&self) {
        let (place_um, name, reference) = (self.place_um(), self.name(), self.axis.reference);
        let at_reference = um_at(&self.response, reference);
        let mut placed = self.case.kit.compiled.placements.iter();
        let has_two = placed.any(|p| p.term == self.term.term && p.direction.is_some());
        let carried = self.term.reversal_in_table(self.case.machine, self.direction);
        let has_two = has_two || carried.abs() > 0.0;
        if self.direction == self.term.homing || !(has_two || self.has_parameter()) {
            let node = self.held.um[self.held.node_at(reference)];
            let dust = if self.adds_up() { DUST_UM } else { 0.0 };
            let constant = self.constant_um.abs();
            assert!(node.abs() <= dust && constant < DUST_UM, "{name}: {node} at the reference");
            let room = place_um + DUST_UM;
            assert!(at_reference.abs() <= room, "{name}: {at_reference} at the reference");
        } else if has_two {
            let reversal = self.target(reference);
            let left = (at_reference + reversal).abs();
            let room = self.half_um() + place_um + DUST_UM;
            assert!(left <= room, "{name}: {at_reference} at the reference, there {reversal}");
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
        let (name, constant) = (self.name(), self.constant_um);
        let room = self.parameter_digit_um() / 2.0 + 1e-6;
        let off = (constant - expected).abs();
        assert!(off <= room, "{name}: constant {constant}, expected {expected}");
    }

    /// Last digit of the backlash parameter, µm.
    fn parameter_digit_um(&self) -> f64 {
        match self.case.profile.dialect {
            Dialect::Siemens(_) if self.case.machine.inch => 0.254,
            Dialect::Fanuc(_) => self.case.machine.axis(self.term.term.of).unit_um.unwrap(),
            _ => 0.1,
        }
    }

    /// (c) On a control that takes every sign the other way round the residual doubles. Whether the
    /// deviation is large enough to see that.
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
        let name = self.name();
        assert!(!is_seen || left >= 1.9 * deviation, "{name}: {deviation}, turned {left}");
        is_seen
    }
}
