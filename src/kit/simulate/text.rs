//! Simulated readings → the CSV of contract §2.2, with where they come from.

use super::{Rehearsal, SIMULATED, Simulation};
use crate::kit::Inputs;
use crate::kit::manifest::HashedFile;
use crate::quantity::axis::{Axis, Direction};
use crate::quantity::diagonal::{Pass, PathKind, Run};
use crate::quantity::units::Figure;
use crate::text::finding::Finding;
use crate::text::plain;
use crate::write::emit::TOOL;

/// Where a simulation comes from, for the comments of its file.
#[derive(Clone, Debug)]
pub struct SimulationSource {
    /// The tables that were active, in words.
    pub tables: String,
    /// The files that hold them.
    pub table_files: Vec<HashedFile>,
    /// By how much every scale has grown, µm/m.
    pub scale_um_per_m: f64,
    /// What was taken for granted.
    pub notes: Vec<Finding>,
}

impl SimulationSource {
    /// The comment lines of a file, without their `#`. Notes are read again
    /// ([`crate::inputs::error_table::Remarks`]) and reach whatever is made from the file.
    pub fn comments(&self, inputs: &Inputs, noise: super::Noise) -> Vec<String> {
        let job = inputs.hashes.first();
        let (name, sha256) = job.map_or(("-", "-"), |job| (&job.path, &job.sha256));
        let mut lines = vec![format!(
            "note: {SIMULATED}: predicted by {TOOL} from {name} sha256 {sha256}, {}",
            self.tables
        )];
        let sources = inputs.hashes.iter().skip(1);
        lines.extend(
            sources.map(|file| format!("predicted from: {} sha256 {}", file.path, file.sha256)),
        );
        let tables = self.table_files.iter();
        lines.extend(tables.map(|file| format!("table: {} sha256 {}", file.path, file.sha256)));
        lines.push(format!(
            "noise {} um (seed {}), change of scale {} um/m",
            noise.um, noise.seed, self.scale_um_per_m
        ));
        lines.extend(self.notes.iter().map(|words| format!("note: {words}")));
        lines
    }
}

/// The file of the readings.
pub fn write(simulation: &Simulation, rehearsal: &Rehearsal, comments: &[String]) -> String {
    let mut text = String::new();
    for comment in comments {
        text.push_str(&plain::comment(comment));
        text.push('\n');
    }
    let recorded = rehearsal.recorded();
    let recorded = || Axis::ALL.into_iter().filter(|axis| recorded[*axis]);
    let mut header = vec!["diagonal", "run", "direction", "node"];
    if rehearsal.kind == PathKind::Step {
        header.push("moved");
    }
    header.push("deviation_um");
    let mut header: Vec<String> = header.into_iter().map(str::to_string).collect();
    header.extend(recorded().map(|axis| format!("t_{}_c", axis.key())));
    text.push_str(&header.join(","));
    text.push('\n');
    for run in &simulation.runs {
        push_run(&mut text, run, rehearsal);
    }
    text
}

/// The rows of a run in the order in which they are measured.
fn push_run(text: &mut String, run: &Run, rehearsal: &Rehearsal) {
    let mut rows: Vec<String> =
        (0..run.deviations.len()).map(|node| row(run, node, rehearsal)).collect();
    if run.pass == Pass::Reverse {
        rows.reverse();
    }
    for row in rows {
        text.push_str(&row);
        text.push('\n');
    }
}

fn row(run: &Run, node: usize, rehearsal: &Rehearsal) -> String {
    let um = run.deviations[node].um();
    let um = match rehearsal.laser_sign {
        Direction::Plus => um,
        Direction::Minus => 0.0 - um,
    };
    let mut cells = vec![
        run.diagonal.to_string(),
        run.number.to_string(),
        run.pass.word().to_string(),
        node.to_string(),
    ];
    if rehearsal.kind == PathKind::Step {
        let moved = (node > 0).then(|| rehearsal.volume.moved(node));
        cells.push(moved.map_or_else(String::new, |axis| axis.key().to_string()));
    }
    cells.push(Figure(um).to_string());
    let temperatures = run.temperatures_c.iter();
    let temperatures = temperatures.filter_map(|(_, t)| t.as_ref()?.get(node).copied());
    cells.extend(temperatures.map(|celsius| celsius.to_string()));
    cells.join(",")
}
