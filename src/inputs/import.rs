//! Another maker's measurement → our error table (contract §2.1).
//!
//! ```text
//!   bytes ─→ encoding ─→ recognise ─→ rtl · ren · pos · etalon · isg · columns ─→ Draft ─→ CSV
//!                            ▲  └─→ understood: shown, and taken with `--yes`
//!                 stated: what the file does not carry
//! ```
//! What the file states is used and said. What it does not carry (component, machine coordinate
//! of the first target, sense of the targets, sign, unit) has to be stated; what is understood of it
//! beyond that is confirmed, and a statement that contradicts the file is a problem. docs/measuring.md
//! §5 has the options.

mod captures;
mod columns;
mod encoding;
mod intake;
mod located;
mod mapping;
mod parameters;
mod pos;
mod reading;
mod ren;
mod rtl;
#[cfg(feature = "excel")]
mod spreadsheet;
pub mod stated;

pub use self::captures::{List, fill};
pub use self::encoding::Measurement;
pub use self::intake::Squareness;
pub use self::rtl::measured_runs;
pub use self::stated::{Format, encoding_word};
pub use crate::inputs::error_table::{Component, Kind};

use self::encoding::{SHA256, SOURCE, text_of};
use self::intake::{Contents, Intake};
use self::mapping::recognised;
use self::reading::unlikely_reversals;
use self::stated::{ImportFacts, described};
use crate::inputs::error_table::{self, Draft, ErrorTable, Remarks};
pub use crate::inputs::findings::ImportFinding;
use crate::inputs::refusals;
use crate::text::{Finding, Problems, Severity, Source, of_severity};

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
pub fn import(file: Measurement<'_>, stated: &ImportFacts) -> Result<Imported, Problems> {
    let (source, name) = text_of(file, stated)?;
    let (format, whole) = recognised(&source, stated)?;
    let intake = Intake::of(&source, &whole, format);
    intake.say([ImportFinding::Encoding { name }]);
    let contents = read(&intake);
    intake.say(contents.iter().flat_map(|(series, _)| unlikely_reversals(series)));
    if let Some(options) = whole.beyond(stated) {
        match stated.yes {
            true => intake.say([ImportFinding::Understood { options }]),
            false => intake.notes.refuse(refusals::only_understood(options)),
        }
    }
    let ((series, squareness), findings) = intake.end(contents)?;
    let mut comments = vec![file.comment(), format!("format: {}", described(format))];
    comments.extend(stated.comments());
    comments.extend(of_severity(&findings, Severity::Label).iter().map(ToString::to_string));
    let warnings = of_severity(&findings, Severity::Note);
    comments.extend(warnings.iter().map(|found| format!("warning: {found}")));
    comments.extend(squareness_lines(&squareness));
    comments.extend(Remarks::read(&source.text).lines()); // what a table of ours says of itself
    let draft = Draft { comments, series };
    let text = error_table::write(&draft);
    // What will be written must be a table that `generate` takes.
    let name = format!("error table of {}", file.path);
    ErrorTable::read(Source::from_bytes(&name, text.as_bytes())?)?;
    Ok(Imported { format, draft, text, findings, squareness })
}

fn read<'a>(intake: &'a Intake<'a>) -> Option<Contents> {
    match intake.format {
        Format::Rtl => rtl::read(intake),
        Format::Ren => ren::read(intake),
        Format::Pos => pos::read(intake),
        Format::Etalon => parameters::read_etalon(intake),
        Format::Isg => parameters::read_isg(intake),
        Format::Columns => columns::read(intake),
        Format::List => intake.notes.refused(refusals::list_without_form()),
    }
}

/// What to put into the job for the squareness of a file; nothing if it gives none.
pub(crate) fn squareness_lines(squareness: &[Squareness]) -> Vec<String> {
    if squareness.is_empty() {
        return Vec::new();
    }
    let head = [
        "squareness does not stand in this table; put into the job, unless the slopes above contain it:",
        "  [measurement.squareness_um_per_m]",
    ];
    let rows =
        squareness.iter().map(|s| format!("  {} = {:?}    # from {}", s.pair, s.um_per_m, s.name));
    let end = "  # positive = the angle between the two positive axis directions is less than 90°";
    head.map(str::to_string).into_iter().chain(rows).chain([end.to_string()]).collect()
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
