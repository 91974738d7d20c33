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

pub mod choices;
mod columns;
mod component;
mod components;
mod decimal;
mod encoding;
mod etalon;
mod format;
mod groups;
mod isg;
mod lines;
mod mapped_rows;
mod mapping;
mod placing;
mod pos;
mod pos_header;
mod pos_rows;
mod reading;
mod refused;
mod ren;
mod ren_header;
mod reversal;
mod rtl;
mod rtl_file;
mod rtl_runs;
mod rtl_sections;
mod rtl_tested;
mod rtl_texts;
pub mod stated;

pub use self::component::{Component, Kind, terms_of};
pub use self::format::Format;
use self::reading::Reading;
pub use self::reading::{Measurement, Squareness};
pub use self::rtl_tested::{MeasuredRuns, measured_runs};

use self::choices::Encoding;
use self::stated::Stated;
use crate::inputs::error_table::{self, Draft, ErrorTable};
use crate::text::document::Source;
use crate::text::problem::Problems;

/// An imported measurement.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The format that was read.
    pub format: Format,
    /// The error table, with the comment lines that say where it comes from.
    pub draft: Draft,
    /// Its text, which was read back as an error table.
    pub text: String,
    /// What the file states and what was done with it, one sentence each.
    pub facts: Vec<String>,
    /// What the user should look at before the table is used.
    pub warnings: Vec<String>,
    /// Squareness cannot stand in an error table; it belongs into the job.
    pub squareness: Vec<Squareness>,
}

/// Reads a measurement.
pub fn import(
    file: Measurement<'_>,
    from: Option<Format>,
    encoding: Option<Encoding>,
    stated: &Stated,
) -> Result<Imported, Problems> {
    refused::refuse_bytes(file)?;
    let (source, encoding) = encoding::decode(file, encoding)?;
    refused::refuse_text(file, &source.text, stated.columns.is_some())?;
    let format = match from {
        Some(format) => format,
        None => format::recognised(&source, stated)?,
    };
    let mut reading = read(format, &source, stated)?;
    reading.warnings.extend(reversal::warnings(&reading.series));
    let mut facts = vec![format!("text: {encoding}")];
    facts.extend(reading.facts.iter().cloned());
    let draft = Draft {
        comments: comments(file, format, stated, &facts, &reading),
        series: reading.series,
    };
    let text = error_table::write(&draft);
    read_back(file, &text)?;
    Ok(Imported {
        format,
        draft,
        text,
        facts,
        warnings: reading.warnings,
        squareness: reading.squareness,
    })
}

fn read(format: Format, source: &Source, stated: &Stated) -> Result<Reading, Problems> {
    let mut problems = stated.foreign_to(format.word(), format.takes());
    let read = match format {
        Format::Rtl => rtl::read,
        Format::Ren => ren::read,
        Format::Pos => pos::read,
        Format::Etalon => etalon::read,
        Format::Isg => isg::read,
        Format::Columns => columns::read,
    };
    match problems.take(read(source, stated)) {
        Some(reading) if problems.is_empty() => Ok(reading),
        _ => Err(problems),
    }
}

/// Lines above the table: where it comes from, what was stated, what the file says.
fn comments(
    file: Measurement<'_>,
    format: Format,
    stated: &Stated,
    facts: &[String],
    reading: &Reading,
) -> Vec<String> {
    let mut comments = vec![
        source_comment(file.name, file.sha256),
        format!("format: {}", format.described()),
    ];
    let given = stated.given().into_iter();
    comments.extend(given.map(|(option, value)| format!("stated: {option} {value}")));
    comments.extend(facts.iter().cloned());
    comments.extend(reading.warnings.iter().map(|w| format!("warning: {w}")));
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
    lines.extend(squareness.iter().map(|s| {
        format!(
            "  {} = {}    # from {}",
            s.pair,
            toml_number(s.um_per_m),
            s.name
        )
    }));
    lines.push(
        "  positive = the angle between the two positive axis directions is less than 90°"
            .to_string(),
    );
    lines
}

fn toml_number(number: f64) -> String {
    format!("{number:?}")
}

const SOURCE: &str = "source: ";
const SHA256: &str = " sha256 ";

fn source_comment(name: &str, sha256: &str) -> String {
    format!("{SOURCE}{name}{SHA256}{sha256}")
}

/// The file that an error table was imported from, by its comment line: name and SHA-256.
pub fn source_of(table: &str) -> Option<(String, String)> {
    let comments = table.lines().take_while(|line| line.starts_with('#'));
    comments
        .map(|line| line.trim_start_matches('#').trim())
        .find_map(|comment| {
            let (name, hash) = comment.strip_prefix(SOURCE)?.rsplit_once(SHA256)?;
            let is_hash = hash.len() == 64 && hash.bytes().all(|b| b.is_ascii_hexdigit());
            is_hash.then(|| (name.to_string(), hash.to_string()))
        })
}
