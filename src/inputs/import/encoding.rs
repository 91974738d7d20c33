//! Bytes → text, and the files that are refused as a whole. UTF-8 and marked UTF-16 show themselves; other
//! encodings have to be stated.

#[cfg(feature = "excel")]
use crate::inputs::import::spreadsheet;
use crate::inputs::import::stated::{ENCODINGS, ImportFacts, encoding_name};
use crate::inputs::refusals;
use crate::text::{Place, Problem, Problems, Source, joined};
use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE};

/// A file to be imported.
#[derive(Clone, Copy, Debug)]
pub struct Measurement<'a> {
    /// The file as the user named it, for messages.
    pub path: &'a str,
    /// Its name without folders, for the table.
    pub name: &'a str,
    /// SHA-256 of its bytes, in hexadecimal digits.
    pub sha256: &'a str,
    /// Its bytes.
    pub bytes: &'a [u8],
}

pub(super) const SOURCE: &str = "source: ";
pub(super) const SHA256: &str = " sha256 ";

impl Measurement<'_> {
    /// The comment of a table that was made from it.
    pub(super) fn comment(&self) -> String {
        format!("{SOURCE}{}{SHA256}{}", self.name, self.sha256)
    }
}

/// The text of a file that may hold a measurement, and its encoding in words. Where a mapping of columns is
/// stated, the ending of the name says nothing: the file may be the CSV that was asked for.
pub(super) fn text_of(
    file: Measurement<'_>,
    stated: &ImportFacts,
) -> Result<(Source, String), Problems> {
    let ending = file.name.rsplit_once('.').map_or("", |(_, ending)| ending);
    #[cfg(feature = "excel")]
    if SPREADSHEETS.contains(&&*ending.to_ascii_lowercase()) {
        let text = spreadsheet::text(file.path, file.bytes, stated.sheet.as_deref())?;
        let said = "a sheet of a workbook".to_string();
        return Ok((Source::from_bytes(file.path, text.as_bytes())?, said));
    }
    if stated.sheet.is_some() {
        return Err(refusals::no_spreadsheet(file.path).into());
    }
    let (encoding, known_by) = encoding_of(file, stated.encoding)?;
    let (text, is_broken) = encoding.decode_with_bom_removal(file.bytes);
    let tells = stated.columns.is_none() || is_broken;
    refuse_kind(file.path, stated_kind(&text).unwrap_or(if tells { ending } else { "" }))?;
    if is_broken {
        return Err(wrong_bytes(file.path, &text, encoding).into());
    }
    let source = Source::from_bytes(file.path, text.as_bytes())?;
    Ok((source, format!("{}{known_by}", encoding.name())))
}

/// The encoding of a file, and in words how it is known.
fn encoding_of(
    file: Measurement<'_>,
    stated: Option<&'static Encoding>,
) -> Result<(&'static Encoding, &'static str), Problem> {
    let marked = Encoding::for_bom(file.bytes).map(|(encoding, _)| encoding);
    match (marked, stated) {
        (Some(marked), Some(stated)) if marked != stated => {
            Err(refusals::other_mark(encoding_name(stated), file.path, marked.name()))
        }
        (Some(marked), _) => Ok((marked, " (byte order mark)")),
        (None, Some(stated)) => Ok((stated, ", as stated")),
        (None, None) => match unmarked_utf_16(file.bytes) {
            Some(order) => Err(refusals::unmarked(file.path, encoding_name(order))),
            None => Ok((UTF_8, "")),
        },
    }
}

/// Latin letters and digits in UTF-16 have a zero byte each, behind or before the other one.
fn unmarked_utf_16(bytes: &[u8]) -> Option<&'static Encoding> {
    const LOOKED_AT: usize = 512;
    let pairs = || bytes.chunks_exact(2).take(LOOKED_AT);
    let is_most = |at: usize| {
        pairs().filter(|pair| pair[at] == 0 && pair[1 - at] != 0).count() * 4 > pairs().len() * 3
    };
    match (is_most(1), is_most(0)) {
        (true, _) => Some(UTF_16LE),
        (_, true) => Some(UTF_16BE),
        _ => None,
    }
}

fn wrong_bytes(path: &str, text: &str, encoding: &'static Encoding) -> Problem {
    let at = text.find('\u{fffd}').unwrap_or(0);
    let place = Place::in_text(path, text, at, at + '\u{fffd}'.len_utf8());
    let others = ENCODINGS.iter().filter(|(other, users)| *other != encoding && !users.is_empty());
    let others =
        others.map(|(other, users)| format!("`--encoding {}` ({users})", encoding_name(other)));
    refusals::other_letter(encoding.name(), joined(others)).at(place)
}

const SPREADSHEETS: &[&str] = &["xls", "xlsx", "ods"];

/// Kinds of files by ending or stated type that are not read.
fn refuse_kind(path: &str, kind: &str) -> Result<(), Problem> {
    let kind = kind.to_ascii_lowercase();
    match &*kind {
        "rtx" => Err(refusals::recording(path)),
        "rta" | "rtr" => Err(refusals::angles(path)),
        "rts" | "rtq" | "rtf" => Err(refusals::straightness(path)),
        kind if SPREADSHEETS.contains(&kind) => Err(refusals::spreadsheet(path)),
        _ => Ok(()),
    }
}

/// The file type that a Renishaw header states.
fn stated_kind(head: &str) -> Option<&str> {
    head.lines().find_map(|line| {
        let (key, value) = line.split_once(':')?;
        key.trim().eq_ignore_ascii_case("file type").then(|| value.trim())
    })
}
