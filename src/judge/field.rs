//! What a control adds to the errors of a machine, as its emulator tells: one response for each error, pair of axes
//! of the control and direction.

use crate::quantity::{
    AT_PLACE_MM, Correction, Direction, ErrorTerm, Millimetres, PerAxis, PerTerm,
};
use crate::read::emulate::{Emulated, Emulator, NodeTable, Response};
use crate::write::plan::axis_pairs;

/// A correction that no laser resolves is none, µm.
const SMALLEST_UM: f64 = 0.01;

/// What an axis of a control gets while another one, or itself, moves in + and in −.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Pair {
    /// The moving axis, as the control calls it.
    pub(super) base: String,
    /// The corrected one.
    pub(crate) output: String,
    ways: [Response; 2],
}

impl Pair {
    /// Asks an emulator.
    pub(super) fn of(control: &dyn Emulator, base: &str, output: &str) -> Emulated<Pair> {
        let way = |direction| control.response(base, output, direction);
        let ways = [way(Direction::Plus)?, way(Direction::Minus)?];
        Ok(Pair { base: base.to_string(), output: output.to_string(), ways })
    }

    pub(crate) fn way(&self, direction: Direction) -> &Response {
        &self.ways[usize::from(direction == Direction::Minus)]
    }

    /// The same with straight lines between the nodes, where a control steps.
    pub(super) fn straightened(&self) -> Pair {
        Pair { ways: self.ways.each_ref().map(Response::straightened), ..self.clone() }
    }

    pub(super) fn tables(&self) -> impl Iterator<Item = &NodeTable> {
        self.ways.iter().flat_map(Response::tables)
    }

    /// Places of the nodes of all tables, ascending, each once; none where only a constant acts.
    pub(super) fn nodes(&self) -> Vec<Millimetres> {
        let nodes = self.tables().flat_map(|table| table.nodes().map(|(at, _)| at));
        let mut nodes: Vec<Millimetres> = nodes.collect();
        nodes.sort_by(|a, b| a.mm().total_cmp(&b.mm()));
        nodes.dedup_by(|a, b| (a.mm() - b.mm()).abs() < AT_PLACE_MM);
        nodes
    }
}

/// What a control adds to each error; of a gantry by several pairs of axes, of which the first counts where one is
/// asked for. Default: nothing.
#[derive(Clone, Debug)]
pub struct Field(PerTerm<Vec<Pair>>);

impl Default for Field {
    fn default() -> Field {
        Field(PerTerm::from_fn(|_| vec![Pair::default()]))
    }
}

impl Field {
    /// Asks an emulator for the axes of these names. An error that is not needed may concern an axis that the
    /// control does not have, which gets nothing.
    pub(crate) fn of(
        names: &PerAxis<Vec<String>>,
        control: &dyn Emulator,
        is_needed: impl Fn(ErrorTerm) -> bool,
    ) -> Emulated<Field> {
        let mut field = Field(PerTerm::default());
        for term in ErrorTerm::ALL {
            for (base, output) in axis_pairs(names, term) {
                match Pair::of(control, base, output) {
                    Ok(pair) => field.0[term].push(pair),
                    Err(reason) if is_needed(term) => return Err(reason),
                    Err(_) => {}
                }
            }
        }
        Ok(field)
    }

    pub(crate) fn pairs(&self) -> impl Iterator<Item = (ErrorTerm, &Pair)> {
        self.0.iter().flat_map(|(term, pairs)| pairs.iter().map(move |pair| (term, pair)))
    }

    /// What acts on an error while its axis moves in a direction, by each pair of axes.
    pub(crate) fn ways(
        &self,
        term: ErrorTerm,
        direction: Direction,
    ) -> impl Iterator<Item = &Response> {
        self.0[term].iter().map(move |pair| pair.way(direction))
    }

    /// What an error gets.
    pub(super) fn put(&mut self, term: ErrorTerm, pair: Pair) {
        self.0[term] = vec![pair];
    }

    /// The same with straight lines between the nodes, where a control steps.
    pub(super) fn straightened(&self) -> Field {
        Field(PerTerm::from_fn(|term| self.0[term].iter().map(Pair::straightened).collect()))
    }

    /// The correction of an error while its axis moves in a direction.
    pub(crate) fn correction(
        &self,
        term: ErrorTerm,
        direction: Direction,
        at: Millimetres,
    ) -> Correction {
        self.ways(term, direction).next().map_or(Correction::ZERO, |way| way.correction(at))
    }

    /// Whether an error is corrected alike in both directions.
    pub(crate) fn is_undirected(&self, term: ErrorTerm) -> bool {
        self.0[term].first().is_none_or(|pair| pair.ways[0] == pair.ways[1])
    }

    /// What the tables alone add, µm.
    pub(super) fn tables_um(&self, term: ErrorTerm, direction: Direction, at: Millimetres) -> f64 {
        let tables = self.ways(term, direction).take(1).flat_map(Response::tables);
        tables.map(|table| table.correction(at).um()).sum()
    }

    /// What is added beside the tables (a backlash parameter), µm.
    pub(super) fn constant_um(&self, term: ErrorTerm, direction: Direction) -> f64 {
        let anywhere = Millimetres::new(0.0);
        self.correction(term, direction, anywhere).um() - self.tables_um(term, direction, anywhere)
    }

    /// Whether what is added beside the tables depends on the direction, as far as a laser resolves it.
    pub(super) fn has_parameter(&self, term: ErrorTerm) -> bool {
        let [plus, minus] = Direction::BOTH.map(|way| self.constant_um(term, way));
        (plus - minus).abs() > SMALLEST_UM
    }

    /// Whether its tables for + and − differ.
    pub(super) fn has_two_tables(&self, term: ErrorTerm) -> bool {
        self.0[term]
            .first()
            .is_some_and(|Pair { ways: [plus, minus], .. }| plus.tables() != minus.tables())
    }

    /// Whether a table acts on an error.
    pub(super) fn has_table(&self, term: ErrorTerm) -> bool {
        self.0[term].first().is_some_and(|pair| pair.tables().next().is_some())
    }

    /// Places of the nodes of its tables.
    pub(super) fn nodes(&self, term: ErrorTerm) -> Vec<Millimetres> {
        self.0[term].first().map_or_else(Vec::new, Pair::nodes)
    }
}
