//! As found, forecast, as left: the page and the document.

use super::second::Second;
use super::{absent, agreement, heading};
use crate::after::{Comparison, Control, Line, compare};
use crate::cli::show::{self, Column};
use crate::cli::{Answer, Format, print, print_json};
use crate::forecast::{COVERAGE_FACTOR, Verdict};
use crate::kit::{Inputs, Verification, emulator};
use crate::manifest::picometres;
use crate::problem::Problems;
use serde_json::{Map, Value, json};
use std::path::Path;

/// Everything that goes on the page.
struct Page<'a> {
    inputs: &'a Inputs,
    verification: &'a Verification,
    second: &'a Second,
    comparison: Comparison,
    verdict: Verdict,
}

pub(super) fn answer(
    inputs: &Inputs,
    directory: &Path,
    verification: &Verification,
    second: &Second,
    format: Format,
) -> Result<Answer, Problems> {
    let page = page(inputs, verification, second)?;
    match format {
        Format::Json => print_json(&page.document())?,
        Format::Text => print(&page.text(directory))?,
    };
    Ok(if page.verdict == Verdict::Pass {
        Answer::Yes
    } else {
        Answer::No
    })
}

fn page<'a>(
    inputs: &'a Inputs,
    verification: &'a Verification,
    second: &'a Second,
) -> Result<Page<'a>, Problems> {
    let plan = &verification.plan;
    let state = &verification.compiled.state;
    let control = emulator(&inputs.profile, &verification.found, state)
        .and_then(|emulator| Control::new(plan, emulator.as_ref()));
    let comparison = compare(
        &inputs.model,
        plan,
        control.as_ref().ok(),
        verification.forecast.as_ref(),
        &second.measurement,
    )?;
    let verdict = judged(inputs, verification, &comparison);
    Ok(Page {
        inputs,
        verification,
        second,
        comparison,
        verdict,
    })
}

/// The as-left figures against the acceptance; what is missing or doubtful decides nothing in
/// favour, and files that differ from the job fail.
fn judged(inputs: &Inputs, verification: &Verification, comparison: &Comparison) -> Verdict {
    if !verification.disagreements.is_empty() {
        return Verdict::Fail;
    }
    let asked = inputs.job.acceptance;
    let verdict = comparison.as_left.verdict(asked);
    let unknown = asked.max_deviation_um.is_some() && !comparison.missing.is_empty();
    if unknown || !comparison.doubts.is_empty() {
        return verdict.max(Verdict::Undecided);
    }
    verdict
}

impl Page<'_> {
    /// Doubts, and what the limit asks for and was not measured.
    fn doubts(&self) -> Vec<String> {
        let mut doubts = self.comparison.doubts.clone();
        let missing: Vec<String> = self
            .comparison
            .missing
            .iter()
            .map(ToString::to_string)
            .collect();
        if self.inputs.job.acceptance.max_deviation_um.is_some() && !missing.is_empty() {
            doubts.push(format!(
                "not measured afterwards, so nothing is known of what is left: {}",
                missing.join(", ")
            ));
        }
        doubts
    }

    fn text(&self, directory: &Path) -> String {
        let verification = self.verification;
        show::paragraphs(&[
            heading(self.inputs, directory),
            self.measured_after(),
            agreement(verification),
            lines(&self.comparison),
            show::verdict(
                self.verdict,
                self.inputs.job.acceptance,
                Some(&self.comparison.as_left),
                !verification.disagreements.is_empty(),
                &self.doubts(),
            ),
            absent(&self.comparison.notes),
            absent(&verification.absent),
            show::assumptions(&verification.compiled.assumptions),
        ])
    }

    fn measured_after(&self) -> String {
        let names: Vec<&str> = self
            .second
            .hashes
            .iter()
            .map(|file| file.path.as_str())
            .collect();
        format!(
            "measured afterwards, with the tables active: {}",
            names.join(", ")
        )
    }

    fn document(&self) -> Value {
        let verification = self.verification;
        let misses = self.comparison.as_left.misses(self.inputs.job.acceptance);
        let causes: Vec<String> = verification
            .disagreements
            .iter()
            .cloned()
            .chain(misses)
            .chain(self.doubts())
            .collect();
        let notes: Vec<String> = self
            .comparison
            .notes
            .iter()
            .chain(&verification.absent)
            .chain(&verification.compiled.notes)
            .cloned()
            .collect();
        json!({
            "schema": 1,
            "verdict": self.verdict.word(),
            "after": self.second.hashes,
            "terms": figures(&self.comparison.terms),
            "max_residual_um": largest(&self.comparison.terms),
            "diagonals": figures(&self.comparison.diagonals),
            "causes": causes,
            "assumptions": verification.compiled.assumptions,
            "notes": notes,
        })
    }
}

/// The largest as-left figure of the terms, else nothing.
fn largest(lines: &[Line]) -> Option<f64> {
    let after = lines.iter().filter_map(|line| line.after_um);
    after.reduce(f64::max).map(picometres)
}

fn figures(lines: &[Line]) -> Value {
    let mut document = Map::new();
    for line in lines {
        let um = |value: Option<f64>| value.map(picometres);
        document.insert(
            line.name.clone(),
            json!({
                "before_um": um(line.before_um),
                "forecast_um": um(line.forecast_um),
                "after_um": um(line.after_um),
                "u_um": um(line.u_um),
                "max_residual_um": um(line.after_um),
                "difference_um": um(line.difference_um),
            }),
        );
    }
    Value::Object(document)
}

fn lines(comparison: &Comparison) -> String {
    let columns = [
        Column::Left("term"),
        Column::Right("as found/µm"),
        Column::Right("forecast/µm"),
        Column::Right("as left/µm"),
        Column::Right("U(k=2)/µm"),
        Column::Right("off forecast/µm"),
    ];
    let terms = comparison
        .terms
        .iter()
        .map(|line| row(line.name.clone(), line));
    let diagonals = comparison.diagonals.iter();
    let diagonals = diagonals.map(|line| row(format!("diagonal {}", line.name), line));
    format!(
        "{}\n  terms: largest deviation, zero at the reference; diagonals: max - min; U of as left;\n  off forecast: largest difference of as left and forecast at a measured position",
        show::table(&columns, terms.chain(diagonals))
    )
}

fn row(name: String, line: &Line) -> Vec<String> {
    let um = |value: Option<f64>| value.map_or_else(|| "-".to_string(), |um| format!("{um:.3}"));
    let measured = |value: Option<f64>| match value {
        None => "not measured".to_string(),
        some => um(some),
    };
    let expanded = match (line.after_um, line.u_um) {
        (None, _) => "-".to_string(),
        (Some(_), None) => "not stated".to_string(),
        (Some(_), Some(u)) => format!("{:.3}", COVERAGE_FACTOR * u),
    };
    vec![
        name,
        measured(line.before_um),
        um(line.forecast_um),
        measured(line.after_um),
        expanded,
        um(line.difference_um),
    ]
}
