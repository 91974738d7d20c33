//! Files that are refused as a whole, with what to export instead.

use crate::inputs::import::Measurement;
use crate::text::problem::{Problem, Problems};

/// What a file is, and what to export instead.
type Refusal = (&'static str, &'static str);

/// Files that are no text, or text with bytes between.
pub(super) fn refuse_bytes(file: Measurement<'_>) -> Result<(), Problems> {
    let head = &file.bytes[..file.bytes.len().min(4096)];
    let kind = stated_kind(&String::from_utf8_lossy(head));
    let kind = kind.unwrap_or_else(|| ending(file.name));
    refuse(file, not_text(&kind))
}

/// Texts of which it is known that they cannot become a table. Where a mapping of columns is
/// stated, the ending of the name says nothing: the file may be the CSV that was asked for.
pub(super) fn refuse_text(
    file: Measurement<'_>,
    text: &str,
    is_mapped: bool,
) -> Result<(), Problems> {
    let kind = stated_kind(text).or_else(|| (!is_mapped).then(|| ending(file.name)));
    let kind = kind.unwrap_or_default();
    let refusal = not_text(&kind).or_else(|| unknown_text(&kind));
    refuse(file, refusal)
}

fn refuse(file: Measurement<'_>, refusal: Option<Refusal>) -> Result<(), Problems> {
    match refusal {
        None => Ok(()),
        Some((what, instead)) => Err(Problem::new(format!("`{}` {what}", file.path))
            .help(instead)
            .into()),
    }
}

fn ending(name: &str) -> String {
    let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending);
    ending.to_ascii_lowercase()
}

fn not_text(kind: &str) -> Option<Refusal> {
    match kind {
        "rtx" => Some((
            "is a dynamic recording (`.rtx`), which has no targets",
            "measure at targets and save static data (`.rtl`)",
        )),
        "xls" | "xlsx" | "ods" => Some((
            "is a spreadsheet",
            "save it as CSV, and map its columns with `--columns`",
        )),
        _ => None,
    }
}

fn unknown_text(kind: &str) -> Option<Refusal> {
    match kind {
        "rta" | "rtr" => Some((
            "holds angles, and the unit of the values in this format is not known",
            "export a CSV with the unit, and map its columns: `--columns \"Position=target_mm,Pitch=eb_urad\"`",
        )),
        "rts" | "rtq" | "rtf" => Some((
            "holds straightness, squareness or flatness in a form that is not known",
            "export a CSV with the evaluated deviations, and map its columns: `--columns \"Position=target_mm,Deviation=ey_um\"`",
        )),
        _ => None,
    }
}

/// The file type that a Renishaw header states.
fn stated_kind(head: &str) -> Option<String> {
    head.lines().find_map(|line| {
        let (key, value) = line.split_once(':')?;
        let is_type = key.trim().eq_ignore_ascii_case("file type");
        is_type.then(|| value.trim().to_ascii_lowercase())
    })
}
