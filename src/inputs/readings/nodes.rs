//! Whether the walks of a file are complete: each diagonal walked, each node once, the axes in the job's
//! order.
//!
//! On a step run the nodes off the diagonal depend on that order. A run named `NNN`, numbered
//! from the far corner, meets the nodes of `PPP` only if it takes the axes in the opposite order.

use crate::inputs::readings::{Row, Walk, Walked};
use crate::inputs::refusals;
use crate::inputs::table::Content;
use crate::quantity::{Axis, Diagonal, Pass, PathKind};
use crate::text::Problem;

impl Walked<'_, '_> {
    /// Notes a problem of a row as a whole.
    pub(super) fn refuse(&self, row: &Row<'_>, problem: Problem) {
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
    fn check_back(&self, walk: Walk, row: &Row<'_>) {
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
    fn other_number_of_nodes(&self) -> Option<(&Row<'_>, Problem)> {
        let volume = &self.path.volume;
        let end = self.walks.values().next()?.last()?;
        let found = end.node;
        let is_complete = |rows: &Vec<&Row<'_>>| {
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
        rows: &[&'r Row<'a>],
    ) -> Option<(&'r Row<'a>, Problem)> {
        let (volume, last) = (&self.path.volume, self.last);
        let forward = |node: usize| (node > 0).then(|| volume.moved(node));
        let expected = |node: usize| match walk.is_own() && node > 0 {
            true => Some(volume.moved(last + 1 - node.min(last))),
            false => forward(node),
        };
        let wrong = |row: &&&Row<'_>| row.node <= last && row.moved != expected(row.node);
        let row = *rows.iter().find(wrong)?;
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
        let help = self.next_step(walk, rows);
        Some((row, refusals::other_move(walk, row.node, found, wanted, help)))
    }

    /// What may have been meant by other axes than those of the job's order.
    fn next_step(&self, walk: Walk, rows: &[&Row<'_>]) -> String {
        let (volume, last) = (&self.path.volume, self.last);
        let follows = |order: &[Axis; 3]| {
            let mut moves = rows.iter().filter(|row| row.node > 0);
            *order != volume.order && moves.all(|row| row.moved == Some(order[(row.node + 2) % 3]))
        };
        let next = |row: &Row<'_>| (row.node < last).then(|| volume.moved(row.node + 1));
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
fn missing(rows: &[&Row<'_>], last: usize) -> Vec<(usize, usize)> {
    let mut missing = Vec::new();
    let mut next = 0;
    let nodes = rows.iter().map(|row| row.node).filter(|node| *node <= last);
    for node in nodes.chain([last + 1]) {
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
