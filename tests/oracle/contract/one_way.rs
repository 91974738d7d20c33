//! (a), (b), (d), (e): node by node and in between, one term, one output, one direction after the other.

use super::case::{Case, Held, count_um, two_tables};
use super::places::{STEEPEST_UM_PER_MM, half_position_digit, jump_um, places};
use crate::support::machine::{MachineAxis, Term};
use crate::support::{self, DUST_UM, Lines, um_at};
use nonius::control::controller::Dialect;
use nonius::quantity::axis::Direction;
use nonius::quantity::curve::Interpolation;
use nonius::read::emulate::Response;
use nonius::write::compensation::Placement;
use nonius::write::plan::PlannedTable;

/// Every claim on what one term gets, in both directions.
pub(crate) fn cancels(case: &Case<'_>, term: &Term, base: &str, output: &str) {
    for direction in Direction::BOTH {
        let way = OneWay::of(case, term, (base, output), direction);
        way.count_is_as_printed();
        way.nodes_lie_on_the_grid();
        way.nodes_cover_the_travel();
        way.nodes_cancel();
        way.places_between_nodes_cancel();
        way.reference_is_zero();
        way.parameter_holds_the_reversal();
    }
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
            response,
            held,
        }
    }

    fn name(&self) -> String {
        format!("{}{} on {}", self.term.term, self.direction, self.output)
    }

    /// The deviation that the table has to cancel.
    fn target(&self, x: f64) -> f64 {
        let two = two_tables(self.case, self.term);
        self.term.target(self.case.machine, two, self.direction, x)
    }

    /// First and last point of the planned grid.
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
        half_position_digit(self.case) * STEEPEST_UM_PER_MM
    }

    /// Half a count, or what the fit of a four-point line leaves.
    fn half_um(&self) -> f64 {
        let half = count_um(self.case, self.term.term, self.output) / 2.0;
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
        let planned = |x: f64| {
            let off = |node: &usize| (first + *node as f64 * step - x).abs();
            let nodes = 0..self.planned.values.len();
            let nearest = nodes.min_by(|a, b| off(a).total_cmp(&off(b))).unwrap();
            let carried = self.term.reversal_in_table(self.case.machine, self.direction);
            self.planned.values[nearest].um() + carried
        };
        let is_sampled = self.case.machine.fit == "sample";
        let places = self.anchored().into_iter();
        places.map(|x| if is_sampled { self.target(x) } else { planned(x) }).collect()
    }

    fn count_is_as_printed(&self) {
        let count = count_um(self.case, self.term.term, self.output);
        let printed = self.placement.count_um;
        assert!((printed - count).abs() < 1e-12, "{}: count {printed} ≠ {count}", self.name());
    }

    /// Nodes lie on the grid anchored on the reference, and every point of it is a node.
    fn nodes_lie_on_the_grid(&self) {
        let half_digit = half_position_digit(self.case);
        for (x, exact) in self.held.mm.iter().zip(self.anchored()) {
            assert!(
                (x - exact).abs() <= half_digit + 1e-9,
                "{}: node {x} is not at {exact}",
                self.name()
            );
        }
        let nodes = self.held.mm.iter().filter(|x| self.is_on_grid(**x));
        assert_eq!(
            nodes.count(),
            self.planned.grid.count(),
            "{}: nodes {:?}",
            self.name(),
            self.held.mm
        );
    }

    /// They cover the travel, but for the rounding of the written spacing.
    fn nodes_cover_the_travel(&self) {
        let digit = match &self.case.profile.dialect {
            Dialect::Fanuc(_) if self.case.machine.inch => 1e-4 * 25.4,
            Dialect::Fanuc(_) => 1e-3,
            _ => 2.0 * half_position_digit(self.case),
        };
        let short = digit * self.held.mm.len() as f64 / 2.0 + 1e-6 * self.held.step();
        let (first, last) = self.range();
        assert!(first <= self.axis.low + short && last >= self.axis.high - short);
    }

    /// Table and constant: what the tables themselves do at a point.
    fn nodes_cancel(&self) {
        let constant = match self.has_parameter() {
            true => 0.0,
            // The reversal of two tables in a constant (Fanuc 3627) belongs to the table.
            false => self.constant_um,
        };
        let bound = self.half_um() + DUST_UM + self.place_um();
        let nodes = self.held.mm.iter().zip(&self.held.um).zip(self.wanted());
        for ((x, um), wanted) in nodes.filter(|((x, _), _)| self.is_on_grid(**x)) {
            let left = wanted + um + constant;
            assert!(
                left.abs() <= bound,
                "{}: at {x}: wanted {wanted}, held {um}, left {left}, bound {bound}",
                self.name()
            );
        }
    }

    /// Half a count, the grid's own residual, half an increment of a control that adds steps.
    fn places_between_nodes_cancel(&self) {
        let (first, last) = self.range();
        let table = Lines { mm: self.anchored(), um: self.wanted() };
        let parameter = match self.has_parameter() {
            true => self.constant_um,
            false => 0.0,
        };
        let (half, place_um) = (self.half_um(), self.place_um());
        let mut worst_grid = 0.0_f64;
        for x in places(self.case, self.term, &self.held, self.axis.low, self.axis.high) {
            let target = self.target(x);
            let own = (target - table.at(x.clamp(first, last))).abs();
            worst_grid = worst_grid.max(own);
            let jump = jump_um(self.case, self.term, &self.held, x);
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
        assert!(
            printed >= seen - room && printed <= seen + near,
            "{}: grid residual {printed}, seen {seen}",
            self.name()
        );
    }

    /// Zero at the reference; the other direction carries the reversal.
    fn reference_is_zero(&self) {
        let (place_um, name) = (self.place_um(), self.name());
        let reference = self.axis.reference;
        let at_reference = um_at(&self.response, reference);
        let mut placed = self.case.kit.compiled.placements.iter();
        let has_two = placed.any(|p| p.term == self.term.term && p.direction.is_some());
        let carried = self.term.reversal_in_table(self.case.machine, self.direction);
        let has_two = has_two || carried.abs() > 0.0;
        if self.direction == self.term.homing || !(has_two || self.has_parameter()) {
            let node = self.held.um[self.held.node_at(reference)];
            let dust = if self.adds_up() { DUST_UM } else { 0.0 };
            assert!(
                node.abs() <= dust && self.constant_um.abs() < DUST_UM,
                "{name}: {node} at the reference"
            );
            assert!(
                at_reference.abs() <= place_um + DUST_UM,
                "{name}: {at_reference} at the reference"
            );
        } else if has_two {
            let reversal = self.target(reference);
            assert!(
                (at_reference + reversal).abs() <= self.half_um() + place_um + DUST_UM,
                "{name}: {at_reference} at the reference, deviation there {reversal}"
            );
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
        let constant = self.constant_um;
        assert!(
            (constant - expected).abs() <= self.parameter_digit_um() / 2.0 + 1e-6,
            "{}: constant {constant}, expected {expected}",
            self.name()
        );
    }

    /// Last digit of the backlash parameter, µm.
    fn parameter_digit_um(&self) -> f64 {
        match self.case.profile.dialect {
            Dialect::Siemens(_) if self.case.machine.inch => 0.254,
            Dialect::Siemens(_)
            | Dialect::Generic(_)
            | Dialect::Declared(_)
            | Dialect::Isg(_)
            | Dialect::Klipper(_)
            | Dialect::Linuxcnc(_) => 0.1,
            Dialect::Fanuc(_) => self.case.machine.axis(self.term.term.of).unit_um.unwrap(),
        }
    }
}
