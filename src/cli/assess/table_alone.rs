//! An error table that no job describes: the machine is what was measured.

use super::basis::Basis;
use crate::inputs::error_table::ErrorTable;
use crate::inputs::job::{Job, UseOf};
use crate::machine::model::ErrorModel;
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::chain::Chain;
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems};
use crate::volume::volume_model::VolumeModel;
use std::fmt::Write;

/// Whether a file is a table (CSV) rather than a job: its first line of content names columns.
pub(super) fn is_table(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    let is_content = |line: &&str| !line.is_empty() && !line.starts_with('#');
    let text = text.trim_start_matches('\u{feff}');
    let head = text.lines().map(str::trim).find(is_content);
    head.is_some_and(|head| !head.contains(['=', '[']) && head.contains([',', ';', '\t']))
}

/// The model of a table and what it rests on: each axis travels where it was measured, its reference is its lowest
/// measured position.
pub(super) fn volume(
    name: &str,
    bytes: &[u8],
    chain: Option<Chain>,
) -> Result<(VolumeModel, Basis), Problems> {
    let table = ErrorTable::read(Source::from_bytes(name, bytes)?)?;
    let page = page(&table, chain);
    let job = Job::read_for(Source::from_bytes(name, page.as_bytes())?, UseOf::Figures)?;
    let model = ErrorModel::for_figures(&job, &table)?;
    if chain.is_none() && model.rotations.iter().any(|(_, angle)| angle.is_some()) {
        return Err(Problem::new(
            "the table holds angles, which act through levers: the order of the axes is missing",
        )
        .at(table.header.clone())
        .help("state it, e.g. `--chain wXYZt`, or give a job with `machine.chain`")
        .into());
    }
    let volume = VolumeModel::build(&job, &model)?;
    let basis = Basis::of_table(&job, &model, &volume);
    Ok((volume, basis))
}

/// The least job that such a table needs.
fn page(table: &ErrorTable, chain: Option<Chain>) -> String {
    let mut page = "schema = 1\n[machine]\nname = \"error table\"\n".to_string();
    let mut line = |text: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(page, "{text}");
    };
    if let Some(chain) = chain {
        line(format!("chain = \"{chain}\""));
    }
    let ranges = PerAxis::from_fn(|axis| {
        let positions = table.series(axis).iter().flat_map(|s| &s.positions);
        positions.fold(None, |ends: Option<(f64, f64)>, at| {
            let (low, high) = ends.unwrap_or((at.mm(), at.mm()));
            Some((low.min(at.mm()), high.max(at.mm())))
        })
    });
    for axis in Axis::ALL {
        if let Some((low, high)) = ranges[axis] {
            line(format!("[machine.axes.{}]", axis.key()));
            line(format!("travel_mm = [{low:?}, {high:?}]"));
            line(format!("reference_mm = {low:?}"));
        }
    }
    line("[measurement]\nerrors = \"-\"".to_string());
    page
}
