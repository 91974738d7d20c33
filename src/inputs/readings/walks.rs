//! The walks of a file: whether they are complete (each diagonal walked, each node once, the axes in the job's
//! order), and the deviations and temperatures of their runs.
//!
//! On a step run the nodes off the diagonal depend on that order. A run named `NNN`, numbered
//! from the far corner, meets the nodes of `PPP` only if it takes the axes in the opposite order.
//!
//! A deviation is measured − nominal displacement, positive along the forward direction, at the
//! nodes of the forward path. A run that carries the name of the reverse run (`NNN` …) counts all
//! three from its own start: its sign is turned and its nodes are renumbered here. Its zero is the
//! far corner, and what the forward runs read there belongs to another set of readings; so only
//! its increments mean anything, and [`crate::inputs::readings::Readings::offset_known`] says so.

use crate::inputs::job::TEMPERATURES_C;
use crate::inputs::readings::{ReadingRow, Walk, Walked};
use crate::inputs::refusals;
use crate::inputs::table::{Column, Content};
use crate::inputs::target_runs::Values;
use crate::quantity::{
    Axis, Deviation, Diagonal, Direction, Pass, PathKind, PerAxis, Run, UM_PER_MM, Volume, rounded,
};
use crate::text::Problem;

impl Walked<'_, '_> {
    /// Notes a problem of a row as a whole.
    pub(super) fn refuse(&self, row: &ReadingRow<'_>, problem: Problem) {
        self.table.notes.refuse(problem.at(row.line.whole()));
    }

    /// Notes diagonals without the walks that the separation needs.
    pub(super) fn check_set(&self) {
        self.require_all(Pass::Forward, refusals::ALL_DIAGONALS);
        if self.walks.keys().any(|walk| walk.pass() == Pass::Reverse) {
            self.require_all(Pass::Reverse, refusals::ALL_BACK);
        }
        for (walk, rows) in self.walks.iter().filter(|(walk, _)| walk.direction == Pass::Reverse) {
            self.check_back(*walk, rows[0]);
        }
    }

    /// Whether rows of a way back belong to forward rows, and to nothing else.
    fn check_back(&self, walk: Walk, row: &ReadingRow<'_>) {
        if walk.is_own() {
            return self.refuse(row, refusals::named_back(walk, walk.name(), walk.diagonal));
        }
        let forward = Walk { direction: Pass::Forward, ..walk };
        let twin = Walk { named: Pass::Reverse, ..forward };
        if self.walks.contains_key(&twin) {
            self.refuse(row, refusals::walked_twice(walk, twin));
        }
        if !self.walks.contains_key(&forward) {
            self.refuse(row, refusals::no_forward_rows(walk));
        }
    }

    fn require_all(&self, pass: Pass, help: &str) {
        let is_walked = |of: &Diagonal| {
            self.walks.keys().any(|walk| walk.diagonal == *of && walk.pass() == pass)
        };
        let missing = Diagonal::ALL.into_iter().filter(|diagonal| !is_walked(diagonal));
        let missing: Vec<String> = missing.map(|diagonal| diagonal.to_string()).collect();
        if !missing.is_empty() {
            self.table.refuse(refusals::no_walk(pass.word(), listed(&missing), help));
        }
    }

    /// Notes nodes that are missing, are given twice or do not exist; `false` if all runs are of another
    /// number of nodes, so that nothing else can be said of them.
    pub(super) fn check_nodes(&self) -> bool {
        for (walk, rows) in &self.walks {
            let twins = rows.windows(2).find(|pair| pair[0].node == pair[1].node);
            if let Some(&[_, row]) = twins {
                self.refuse(row, refusals::node_twice(walk, row.node));
            }
        }
        if let Some((row, problem)) = self.other_number_of_nodes() {
            self.refuse(row, problem);
            return false;
        }
        for (walk, rows) in &self.walks {
            if let Some(row) = rows.iter().find(|row| row.node > self.last) {
                self.refuse(row, refusals::beyond_last_node(walk, row.node, self.last));
            }
            let missing = missing(rows, self.last);
            if let Some((first, _)) = missing.first() {
                let before = rows.iter().rfind(|row| row.node < *first);
                let problem = refusals::nodes_missing(walk, in_words(&missing));
                self.refuse(before.unwrap_or(&rows[0]), problem);
            }
        }
        true
    }

    /// All walks are complete, but to another last node than the job's: one mistake, said once.
    fn other_number_of_nodes(&self) -> Option<(&ReadingRow<'_>, Problem)> {
        let volume = &self.path.volume;
        let end = self.walks.values().next()?.last()?;
        let found = end.node;
        let is_complete = |rows: &Vec<&ReadingRow<'_>>| {
            rows.last().is_some_and(|row| row.node == found) && missing(rows, found).is_empty()
        };
        if found == self.last || found == 0 || !self.walks.values().all(is_complete) {
            return None;
        }
        let (word, nodes, other, other_word) = match self.path.kind {
            PathKind::Step => ("single-axis", 3, PathKind::Straight, "straight"),
            PathKind::Straight => ("straight", 1, PathKind::Step, "step"),
        };
        let help = if found == volume.last_node(other) {
            format!("these look like runs of the other kind: write `kind = \"{other_word}\"`")
        } else if found % nodes == 0 {
            format!("the readings look like `steps = {}`", found / nodes)
        } else {
            "runs of single-axis steps have three nodes for each step of `steps`, and node 0"
                .to_string()
        };
        Some((end, refusals::other_last_node(found, word, volume.steps, self.last, help)))
    }

    /// Notes axes that moved in another order than that of the job.
    pub(super) fn check_moves(&self) {
        match (self.path.kind, self.table.column(Content::Moved)) {
            (PathKind::Straight, Some(column)) => {
                self.table.notes.refuse(self.table.at(column, refusals::straight_moved()));
            }
            (PathKind::Step, None) => self.table.refuse(refusals::no_moved()),
            (PathKind::Step, Some(column)) => {
                let once_named = |walk: &Walk| !(walk.is_own() && walk.direction == Pass::Reverse);
                for (walk, rows) in self.walks.iter().filter(|(walk, _)| once_named(walk)) {
                    if let Some((row, problem)) = self.wrong_move(*walk, rows) {
                        self.table.notes.refuse(problem.at(row.line.cell_place(column.index)));
                    }
                }
            }
            (PathKind::Straight, None) => {}
        }
    }

    /// The first row of a walk that names another axis than the job's order does.
    fn wrong_move<'r, 'a>(
        &self,
        walk: Walk,
        rows: &[&'r ReadingRow<'a>],
    ) -> Option<(&'r ReadingRow<'a>, Problem)> {
        let (volume, last) = (&self.path.volume, self.last);
        let forward = |node: usize| (node > 0).then(|| volume.moved(node));
        let expected = |node: usize| match walk.is_own() && node > 0 {
            true => Some(volume.moved(last + 1 - node.min(last))),
            false => forward(node),
        };
        let row = *rows.iter().find(|row| row.node <= last && row.moved != expected(row.node))?;
        let order = Axis::letters(&volume.order);
        let mut moves = rows.iter().filter(|row| row.node > 0);
        if walk.is_own() && moves.all(|row| row.moved == forward(row.node)) {
            // It takes the axes in the order of the forward run.
            let [first, second, third] = volume.order;
            let back = Axis::letters(&[third, second, first]);
            return Some((row, refusals::forward_order(walk, order, walk.diagonal, back)));
        }
        let word = |axis: Option<Axis>| axis.map_or("no axis".to_string(), |axis| axis.to_string());
        let by = expected(row.node).map_or(String::new(), |_| format!(" by the order {order}"));
        let (found, wanted) = (word(row.moved), word(expected(row.node)) + &by);
        Some((row, refusals::other_move(walk, row.node, found, wanted, self.next_step(walk, rows))))
    }

    /// What may have been meant by other axes than those of the job's order.
    fn next_step(&self, walk: Walk, rows: &[&ReadingRow<'_>]) -> String {
        let (volume, last) = (&self.path.volume, self.last);
        let follows = |order: &[Axis; 3]| {
            let mut moves = rows.iter().filter(|row| row.node > 0);
            *order != volume.order && moves.all(|row| row.moved == Some(order[(row.node + 2) % 3]))
        };
        let next = |row: &ReadingRow<'_>| (row.node < last).then(|| volume.moved(row.node + 1));
        match Axis::ORDERS.into_iter().find(follows) {
            _ if walk.is_own() => refusals::MOVED.to_string(),
            _ if rows.iter().all(|row| row.moved == next(row)) => {
                "in reverse rows too, `moved` names the axis of the forward step that ends at the node".to_string()
            }
            Some(order) => format!(
                "the whole run follows another order: write `order = \"{}\"` in the job",
                Axis::letters(&order)
            ),
            None => refusals::MOVED.to_string(),
        }
    }
}

/// Ranges of nodes from 0 to `last` that no row has.
fn missing(rows: &[&ReadingRow<'_>], last: usize) -> Vec<(usize, usize)> {
    let mut missing = Vec::new();
    let mut next = 0;
    for node in rows.iter().map(|row| row.node).filter(|node| *node <= last).chain([last + 1]) {
        if node > next {
            missing.push((next, node - 1));
        }
        next = node + 1;
    }
    missing
}

/// How many ranges a sentence names.
const MOST_RANGES: usize = 6;

/// `node 3 is`, `nodes 12 and 31 to 33 are`.
fn in_words(ranges: &[(usize, usize)]) -> String {
    let named = ranges.iter().take(MOST_RANGES);
    let range = |(from, to): &(usize, usize)| match to - from {
        0 => from.to_string(),
        1 => format!("{from}, {to}"),
        _ => format!("{from} to {to}"),
    };
    let mut parts: Vec<String> = named.map(range).collect();
    let more: usize = ranges.iter().skip(MOST_RANGES).map(|(a, b)| b - a + 1).sum();
    parts.extend((more > 0).then(|| format!("{more} more")));
    let list = listed(&parts);
    match ranges {
        [(from, to)] if from == to => format!("node {list} is"),
        _ => format!("nodes {list} are"),
    }
}

fn listed(parts: &[String]) -> String {
    match parts {
        [before @ .., last] if !before.is_empty() => format!("{} and {last}", before.join(", ")),
        _ => parts.concat(),
    }
}

/// No machine tool is off by a centimetre: the readings or the job are not what they seem.
const LARGEST_DEVIATION_UM: f64 = 1e4;
/// Last digit of a laser's display: what still counts as zero.
const ZERO_UM: f64 = 1e-3;

impl Walked<'_, '_> {
    /// Measured − nominal displacement of a row in the direction that its walk counts, µm.
    fn deviation_um(&self, row: &ReadingRow<'_>) -> f64 {
        match self.values {
            Values::Deviations => self.signed(row.um),
            Values::Positions => self.beyond_um(row, self.path.volume.order),
        }
    }

    /// How far a displacement goes beyond the nominal one of an order of the axes, µm.
    fn beyond_um(&self, row: &ReadingRow<'_>, order: [Axis; 3]) -> f64 {
        self.signed(row.um) - self.nominal_mm(row, order) * UM_PER_MM
    }

    /// A reading in the sign of the job, or a displacement in that of the readings.
    fn signed(&self, value: f64) -> f64 {
        match self.path.laser_sign {
            Direction::Plus => value,
            Direction::Minus => -value,
        }
    }

    fn nominal_mm(&self, row: &ReadingRow<'_>, order: [Axis; 3]) -> f64 {
        let volume = Volume { order, ..self.path.volume.clone() };
        let nominal = |node| volume.nominal_mm(row.walk.diagonal, self.path.kind, node);
        match row.walk.is_own() {
            true => nominal(self.last) - nominal(self.last - row.node.min(self.last)),
            false => nominal(row.node),
        }
    }

    /// What stands at the start of a diagonal's first run and is subtracted from a walk, µm; `None` where the
    /// laser was zeroed there, or before this run.
    pub(super) fn zero_um(&self, walk: Walk) -> Option<f64> {
        let start_um = |walk: &Walk| {
            let um = self.deviation_um(self.walks.get(walk)?.first()?);
            Some(um).filter(|um| um.abs() > ZERO_UM)
        };
        start_um(&Walk { direction: Pass::Forward, ..walk }).filter(|_| !walk.is_own())?;
        let mut walks = self.walks.keys();
        walks.find(|of| of.diagonal == walk.diagonal && !of.is_own()).and_then(start_um)
    }

    /// Notes readings that are no deviation of a machine.
    pub(super) fn check_readings(&self) {
        for rows in self.walks.values() {
            let is_implausible = |row: &&&ReadingRow<'_>| {
                row.node <= self.last && self.deviation_um(row).abs() > LARGEST_DEVIATION_UM
            };
            if let Some(row) = rows.iter().find(is_implausible) {
                self.refuse(row, self.implausible(row));
            }
        }
    }

    fn implausible(&self, row: &ReadingRow<'_>) -> Problem {
        let (walk, node) = (row.walk, row.node);
        let read = row.um / UM_PER_MM;
        if self.values == Values::Deviations {
            return refusals::no_such_deviation(walk, node, rounded(read, 3));
        }
        let expected = self.signed(self.nominal_mm(row, self.path.volume.order));
        let is_turned = (read + expected).abs() * UM_PER_MM <= LARGEST_DEVIATION_UM;
        let fits =
            |order: &[Axis; 3]| self.beyond_um(row, *order).abs() < LARGEST_DEVIATION_UM / 10.0;
        let help = match (Axis::ORDERS.into_iter().find(fits), is_turned) {
            (Some([first, second, third]), _) => format!("this is what steps that went {first}, {second}, {third} read: check `order` in the job against the program that was run"),
            (None, true) if walk.is_own() => format!("a run named {} counts along its own travel; give rows that count along {} under that name, with `reverse` and the nodes of the forward run", walk.name(), walk.diagonal),
            (None, true) => format!("the instrument counts the other way: write `laser_sign = \"{}\"` in the job", self.path.laser_sign.opposite()),
            (None, false) => "displacements are counted from the start of the forward run; check the unit in the column's name, and the box in the job".to_string(),
        };
        refusals::other_displacement(walk, node, rounded(read, 3), rounded(expected, 3), help)
    }

    /// Notes temperatures that are missing in part, or that the job does not say how to use.
    pub(super) fn check_temperatures(&self) {
        let material = self.path.material;
        let is_corrected = material.is_some_and(|material| material.material_corrected);
        for axis in Axis::ALL {
            let scale = material.and_then(|material| material.axes[axis]);
            let is_stated = scale.is_some_and(|scale| scale.temperature_c.is_some());
            let Some(column) = self.table.column(Content::Temperature(axis)) else {
                if scale.is_some() && !is_stated && !is_corrected {
                    self.table.refuse(refusals::no_temperature(axis, axis.key()));
                }
                continue;
            };
            let name = &column.name;
            let unusable = match scale {
                _ if material.is_none() => Some(refusals::temperatures_for_what(name)),
                Some(_) if is_stated => Some(refusals::two_temperatures(axis, name)),
                None if !is_corrected => Some(refusals::no_expansion(name, axis, axis.key())),
                _ => None,
            };
            unusable
                .into_iter()
                .for_each(|own| self.table.notes.refuse(self.table.at(column, own)));
            self.check_column(axis, column);
        }
    }

    fn check_column(&self, axis: Axis, column: &Column) {
        let name = &column.name;
        let refuse = |row: &ReadingRow<'_>, problem: Problem| {
            self.table.notes.refuse(problem.at(row.line.cell_place(column.index)));
        };
        let given = self.walks.values().flatten();
        let mut given = given.filter_map(|row| Some((*row, row.temperatures_c[axis]?)));
        if let Some((row, c)) = given.find(|(_, c)| !TEMPERATURES_C.contains(c)) {
            let (low, high) = (TEMPERATURES_C.start(), TEMPERATURES_C.end());
            refuse(row, refusals::no_room_temperature(name, c, low, high));
        }
        for (walk, rows) in &self.walks {
            let is_given = |row: &&ReadingRow<'_>| row.temperatures_c[axis].is_some();
            let empty = rows.iter().find(|row| !is_given(row));
            if let Some(row) = empty.filter(|_| rows.iter().any(is_given)) {
                refuse(row, refusals::temperature_missing(walk, row.node, name));
            }
        }
    }

    /// The run of a complete walk, less its zero.
    pub(super) fn run(&self, walk: Walk, rows: &[&ReadingRow<'_>]) -> Run {
        let mut forward: Vec<&ReadingRow<'_>> = rows.to_vec();
        let sign = if walk.is_own() { -1.0 } else { 1.0 };
        if walk.is_own() {
            forward.reverse();
        }
        let zero_um = self.zero_um(walk).unwrap_or(0.0);
        let deviation =
            |row: &&ReadingRow<'_>| Deviation::from_um(sign * self.deviation_um(row) - zero_um);
        let temperatures = |axis| forward.iter().map(|row| row.temperatures_c[axis]).collect();
        Run {
            diagonal: walk.diagonal,
            number: walk.run,
            pass: walk.pass(),
            deviations: forward.iter().map(deviation).collect(),
            temperatures_c: PerAxis::from_fn(temperatures),
        }
    }
}
