//! Figures of the body diagonals by standard, for people and for documents.

use crate::cli::outcome::joined;
use crate::cli::screen::table;
use crate::cli::show::um;
use crate::inputs::target_runs::Runs;
use crate::machine::standards::iso_230_2::AxisFigures;
use crate::machine::standards::{DiagonalFigures, Diagonals, diagonal, diagonal_runs};
use crate::page::{Locale, Picture, targets};
use crate::quantity::{Diagonal, PathKind, Run, Volume};
use crate::text::Problem;
use serde_json::{Value, json};

/// `runs`: only those that count from the start of the forward run, or the two directions
/// cannot be compared; `length_is_known`: whether somebody knows the size of the box.
pub(super) fn by_standard(
    volume: &Volume,
    kind: PathKind,
    runs: &[Run],
    length_is_known: bool,
) -> Result<Diagonals, Problem> {
    let each = Diagonal::ALL.into_iter();
    let each = each.map(|d| Ok((d.name(), diagonal_runs(volume, kind, d, runs)?)));
    let runs = each.collect::<Result<Vec<_>, Problem>>()?;
    let named: Vec<(&str, &Runs)> = runs.iter().map(|(name, runs)| (*name, runs)).collect();
    Ok(diagonal(&named, kind, length_is_known))
}

impl Diagonals {
    /// Means and bands along each diagonal, with words for its length.
    pub(super) fn picture(&self, locale: Locale<'_>, heading: &str, across: &str) -> Picture {
        let named = self.diagonals.iter().map(|of| (of.name.clone(), &of.figures));
        targets(locale, heading, across, &named.collect::<Vec<_>>())
    }

    /// Every figure of every diagonal; what no diagonal has gets no column.
    pub(super) fn table(&self) -> String {
        let diagonals = &self.diagonals;
        let is_there =
            |name: &&&str| diagonals.iter().any(|of| figure(&of.figures.axis, name).is_some());
        let there: Vec<&str> = FIGURES.iter().filter(is_there).copied().collect();
        let headings = there.iter().map(|name| format!("\t>{}", name.replace('_', " ")));
        let rows = diagonals.iter().map(|of| {
            let figures = there.iter().map(|name| um(figure(&of.figures.axis, name)) + "\t");
            format!("{}\t{}{}", of.name, figures.collect::<String>(), um(of.range_um))
        });
        let heading = format!("diagonal, µm{}\t>max - min", headings.collect::<String>());
        table(&heading, rows)
    }

    /// The table of the diagonals as they were read, with their far ends and the figures of all four.
    pub(super) fn as_read(&self, end_um: impl Fn(Diagonal) -> f64) -> String {
        let ends = Diagonal::ALL.map(|d| format!("{d} {}", um(Some(end_um(d)))));
        let machine = match (self.e_d_um, self.b_d_um) {
            (Some(e_d), Some(b_d)) => {
                format!("machine: E_d {e_d:.3} µm, B_d {b_d:.3} µm (largest of the four)")
            }
            _ => {
                "no E and B: they need runs in both directions that count from one zero".to_string()
            }
        };
        format!(
            "Body diagonals as read (corrected readings, no compensation forecast), {}\n{}\nfar end less start, mean of all runs (µm): {}\nlargest range {} µm; over all four {} µm\n{machine}",
            self.label,
            self.table(),
            ends.join(", "),
            um(self.largest_range_um),
            um(self.range_over_all_um),
        )
    }
}

/// Figures of a diagonal in the order of the table.
const FIGURES: [&str; 12] =
    ["E", "E_up", "E_down", "M", "B", "B_mean", "R", "R_up", "R_down", "A", "A_up", "A_down"];

fn figure(of: &AxisFigures, wanted: &str) -> Option<f64> {
    let named = of.named_um().into_iter().find(|(name, _)| *name == wanted);
    named.and_then(|(_, um)| um)
}

/// Every figure of a diagonal.
pub(super) fn diagonal_json(of: &DiagonalFigures) -> Value {
    let range = ("range", of.range_um);
    joined([
        json!({ "targets": of.figures.targets.len(), "runs": counts(of.runs) }),
        named_um(of.figures.axis.named_um().into_iter().chain([range])),
    ])
}

/// How many runs there are of each direction.
pub(super) fn counts([up, down]: [usize; 2]) -> Value {
    json!({ "up": up, "down": down })
}

/// Figures under their letter and unit; `null` where one is absent.
pub(super) fn named_um<'a>(figures: impl IntoIterator<Item = (&'a str, Option<f64>)>) -> Value {
    let figures = figures.into_iter();
    let figures = figures.map(|(name, um)| (format!("{name}_um"), json!(um)));
    Value::Object(figures.collect())
}
