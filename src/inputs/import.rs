//! Another maker's measurement → our error table (contract §2.1).
//!
//! ```text
//!   bytes ─→ encoding ─→ format ─→ rtl · ren · pos · etalon · isg · columns ─→ Draft ─→ CSV
//!                            ▲
//!                 stated: what the file does not carry
//! ```
//! What the file states is used and said. What it does not carry (component, machine coordinate
//! of the first target, sense of the targets, sign, unit) has to be stated; nothing is guessed,
//! and a statement that contradicts the file is a problem. docs/import.md has the whole list.

mod captures;
mod columns;
mod encoding;
mod findings;
mod form;
mod groups;
mod list_column;
mod located;
mod mapping;
mod parameters;
mod pos;
mod reading;
mod ren;
mod rtl;
mod rtl_file;
#[cfg(feature = "excel")]
mod spreadsheet;
pub mod stated;
mod words;

pub use self::captures::{List, fill};
pub use self::encoding::{Measurement, encoding_word};
pub use self::reading::Squareness;
pub use self::rtl::measured_runs;
pub use self::stated::Format;
pub use crate::inputs::error_table::{Component, Kind};

use self::encoding::{SHA256, SOURCE, text_of};
pub use self::findings::ImportFinding;
use self::parameters::is_isg_header;
use self::reading::{FileContents, unlikely_reversals};
use self::stated::{Stated, described};
use crate::inputs::error_table::{self, Draft, ErrorTable};
use crate::text::document::Source;
use crate::text::finding::{Finding, Severity, of_severity};
use crate::text::problem::{Problem, Problems};

/// An imported measurement.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The format that was read.
    pub format: Format,
    /// The error table, with the comment lines that say where it comes from.
    pub draft: Draft,
    /// Its text, which was read back as an error table.
    pub text: String,
    /// What the file states and what was done with it (labels); what to look at before the table is used
    /// (notes).
    pub findings: Vec<Finding>,
    /// Squareness cannot stand in an error table; it belongs into the job.
    pub squareness: Vec<Squareness>,
}

/// Reads a measurement.
pub fn import(
    file: Measurement<'_>,
    from: Option<Format>,
    encoding: Option<&'static encoding_rs::Encoding>,
    stated: &Stated,
) -> Result<Imported, Problems> {
    let (source, name) = text_of(file, encoding, stated)?;
    let format = match from {
        Some(format) => format,
        None => recognised(&source, stated)?,
    };
    let mut reading = read(format, &source, stated)?;
    reading.find(unlikely_reversals(&reading.series));
    reading.findings.insert(0, ImportFinding::Encoding { name }.into());
    let draft =
        Draft { comments: comments(file, format, stated, &reading), series: reading.series };
    let text = error_table::write(&draft);
    read_back(file, &text)?;
    Ok(Imported { format, draft, text, findings: reading.findings, squareness: reading.squareness })
}

fn read(format: Format, source: &Source, stated: &Stated) -> Result<FileContents, Problems> {
    let read = match format {
        Format::Rtl => rtl::read,
        Format::Ren => ren::read,
        Format::Pos => pos::read,
        Format::Etalon => parameters::read_etalon,
        Format::Isg => parameters::read_isg,
        Format::Columns => columns::read,
        Format::List => {
            let message = "a list of captures does not say where they were taken";
            let help =
                "name the form that says it, `--form readings.csv` (docs/import.md section 8)";
            return Err(Problem::new(message).help(help).into());
        }
    };
    let mut problems = stated.foreign_to(format);
    let reading = problems.take(read(source, stated));
    problems.or_ok(reading.unwrap_or_default())
}

/// The format, by what stands in the file, else by the ending of its name.
fn recognised(source: &Source, stated: &Stated) -> Result<Format, Problem> {
    if stated.columns.is_some() {
        return Ok(Format::Columns);
    }
    let lines = source.text.lines().map(str::trim);
    let content = || lines.clone().filter(|line| !line.is_empty());
    let first = first_content(source);
    let has_key = |key: &str| content().any(|line| line.starts_with(key) && line.contains(':'));
    let name = source.name.to_ascii_lowercase();
    let signs = [
        (Format::Rtl, first.eq_ignore_ascii_case("HEADER::")),
        (Format::Ren, has_key("Compensation start") || has_key("Compensation type")),
        (Format::Etalon, first.starts_with('[')),
        (Format::Isg, is_isg_header(first)),
        (Format::Pos, pos::is_first_line(first) || name.ends_with(".pos")),
        (Format::Rtl, name.ends_with(".rtl")),
        (Format::Ren, name.ends_with(".ren")),
    ];
    let found = signs.into_iter().find(|(_, is)| *is);
    found.map(|(format, _)| format).ok_or_else(|| {
        Problem::new(format!("the format of `{}` is not recognised", source.name))
            .at(source.place(&(0..first.len().min(source.text.len()))))
            .help("map its columns with `--columns`, or state `--from rtl`, `ren`, `pos`, `etalon` or `isg`. Of the files of Optodyne, CARTO and others nothing is known that could be relied on: export a CSV there")
    })
}

/// The first line that is neither empty nor a comment.
fn first_content(source: &Source) -> &str {
    let mut lines = source.text.lines().map(str::trim);
    lines.find(|line| !line.is_empty() && !line.starts_with("//")).unwrap_or_default()
}

/// Lines above the table: where it comes from, what was stated, what the file says.
fn comments(
    file: Measurement<'_>,
    format: Format,
    stated: &Stated,
    reading: &FileContents,
) -> Vec<String> {
    let mut comments = vec![file.comment(), format!("format: {}", described(format))];
    let given = stated.given().into_iter();
    comments.extend(given.map(|(option, value)| format!("stated: {option} {value}")));
    let facts = of_severity(&reading.findings, Severity::Label);
    comments.extend(facts.iter().map(ToString::to_string));
    let warnings = of_severity(&reading.findings, Severity::Note);
    comments.extend(warnings.iter().map(|found| format!("warning: {found}")));
    comments.extend(squareness_lines(&reading.squareness));
    comments
}

/// What will be written must be a table that `generate` takes.
fn read_back(file: Measurement<'_>, text: &str) -> Result<(), Problems> {
    let name = format!("error table of {}", file.path);
    ErrorTable::read(Source::from_bytes(&name, text.as_bytes())?).map(|_| ())
}

/// What to put into the job for the squareness of a file; nothing if it gives none.
pub(crate) fn squareness_lines(squareness: &[Squareness]) -> Vec<String> {
    if squareness.is_empty() {
        return Vec::new();
    }
    let mut lines = vec![
        "squareness does not stand in this table; put into the job, unless the slopes above contain it:".to_string(),
        "  [measurement.squareness_um_per_m]".to_string(),
    ];
    lines.extend(
        squareness
            .iter()
            .map(|s| format!("  {} = {}    # from {}", s.pair, toml_number(s.um_per_m), s.name)),
    );
    lines.push(
        "  positive = the angle between the two positive axis directions is less than 90°"
            .to_string(),
    );
    lines
}

fn toml_number(number: f64) -> String {
    format!("{number:?}")
}

/// The file that an error table was imported from, by its comment line: name and SHA-256.
pub fn source_of(table: &str) -> Option<(String, String)> {
    let comments = table.lines().take_while(|line| line.starts_with('#'));
    comments.map(|line| line.trim_start_matches('#').trim()).find_map(|comment| {
        let (name, hash) = comment.strip_prefix(SOURCE)?.rsplit_once(SHA256)?;
        let is_hash = hash.len() == 64 && hash.bytes().all(|b| b.is_ascii_hexdigit());
        is_hash.then(|| (name.to_string(), hash.to_string()))
    })
}
