//! What a control wrote of itself: the files of an archive, and what their lines say of the compensation.
//!
//! ```text
//!   archive ─→ files ─→ sections (%_N_NAME_EXT) ─→ lines: of a table, of machine data, of no concern
//! ```
//! An archive holds active data (`…_INI`) and part programs (`…_MPF`, `…_SPF`) one after the other. A
//! program lies in the memory and does nothing until somebody runs it, so what it would write is no
//! state of the control.
//!
//! The commissioning archive of an 840D sl is split at its headers:
//!
//! ```text
//!   header (512 bytes) │ content, filled with zeros to a multiple of 512 │ header │ content │ …
//!     0 name, 50 name and 384 folder as the HMI shows them, 124 size, 148 sum of the header
//! ```
//! The first content lists all files, so one that is not there is missed.
//! Plain text between the headers, nothing is compressed. From a real archive of 2016 (first header
//! `@@MMCIBN.002`); in all of its 325 headers the number at 148 is the sum of the other bytes, so a
//! place that is no header is found. Older archives with `%_N_…` headers are text and need no splitting.

use super::statement::{BLANKS, block_number, code_of, is_end, take_word};
use super::variable::{data, is_of_table};
use crate::control::controller::ControlUnit;
use crate::read::family::Part;
use crate::read::lexer::{Cursor, lines};
use crate::text::problem::Problem;
use std::collections::BTreeSet;
use std::ops::Range;

/// Size of a header, and of the unit that contents fill.
const BLOCK: usize = 512;
/// Places in a header.
const NAME: Range<usize> = 0..50;
const SHOWN: Range<usize> = 50..100;
const SIZE: Range<usize> = 124..136;
const SUM: Range<usize> = 148..156;
const FOLDER: Range<usize> = 384..BLOCK;
/// How the first header begins.
const BEGIN: &[u8] = b"@@MMCIBN.";
/// The folder of the active data.
const ACTIVE_DATA: &str = "\\_NC_ACT.DIR\\";

/// Whether a file is such an archive.
pub(super) fn is_archive(bytes: &[u8]) -> bool {
    bytes.starts_with(BEGIN)
}

/// The active data and part programs of an archive; what else lies in it (drives, definitions,
/// descriptions) holds no compensation.
///
/// limits refused where a header does not add up, a content is cut off, or active data that the archive
///        lists are not in it
pub(super) fn parts<'a>(file: &str, bytes: &'a [u8]) -> Result<Vec<Part<'a>>, Problem> {
    let mut parts = Vec::new();
    let mut active = BTreeSet::new();
    let mut list: &[u8] = &[];
    let mut at = 0;
    while at < bytes.len() {
        let found = entry(bytes, at).ok_or_else(|| damaged(file, &format!("at byte {at}")))?;
        if at == 0 {
            list = found.bytes;
        }
        let name = found.name;
        let is_program = name.ends_with("_MPF") || name.ends_with("_SPF");
        let is_active = found.folder == ACTIVE_DATA;
        active.extend(is_active.then_some(found.shown));
        if !found.bytes.is_empty() && (is_active || is_program) {
            parts.push((format!("{file}/{name}"), found.bytes));
        }
        at = found.next;
    }
    let Some(name) = listed(list).find(|name| !active.contains(name.as_str())) else {
        return Ok(parts);
    };
    let what = format!("`{name}`, which it lists, is missing");
    Err(damaged(file, &what))
}

/// The active data that the first content lists, as the HMI shows them.
fn listed(list: &[u8]) -> impl Iterator<Item = String> {
    let lines = list.split(|byte| *byte == b'\n').map(String::from_utf8_lossy);
    let names =
        lines.filter_map(|line| Some(line.trim_end().strip_prefix(ACTIVE_DATA)?.to_string()));
    names.collect::<Vec<_>>().into_iter()
}

/// What stands behind a header.
struct Entry<'a> {
    /// Its name as in the control, such as `_N_AX_EEC_INI`.
    name: &'a str,
    bytes: &'a [u8],
    shown: &'a str,
    folder: &'a str,
    /// Where the next header begins.
    next: usize,
}

fn entry(bytes: &[u8], at: usize) -> Option<Entry<'_>> {
    let header = bytes.get(at..at + BLOCK)?;
    let sum = |range: &[u8]| range.iter().map(|byte| u32::from(*byte)).sum::<u32>();
    let own: u32 = text_of(&header[SUM])?.parse().ok()?;
    if own != sum(&header[..SUM.start]) + sum(&header[SUM.end..]) {
        return None;
    }
    let size: usize = text_of(&header[SIZE])?.parse().ok()?;
    let start = at + BLOCK;
    let next = start.checked_add(size.checked_next_multiple_of(BLOCK)?)?;
    let content = bytes.get(start..next)?;
    Some(Entry {
        name: text_of(&header[NAME])?,
        bytes: &content[..size],
        shown: text_of(&header[SHOWN])?,
        folder: text_of(&header[FOLDER])?,
        next,
    })
}

/// A text field, without the zeros behind it.
fn text_of(field: &[u8]) -> Option<&str> {
    let end = field.iter().position(|byte| *byte == 0);
    std::str::from_utf8(&field[..end.unwrap_or(field.len())]).ok()
}

fn damaged(file: &str, what: &str) -> Problem {
    Problem::new(format!("the archive `{file}` is damaged or cut off: {what}"))
        .help("copy the archive from the control again, or name the files read out one by one (AX_EEC.INI, NC_CEC.INI, INITIAL.INI)")
}

/// The lines of a file with the part program that each stands in: a section that is one, or lies in a
/// folder of programs and workpieces. A file without headers is a program where its own name says so.
pub(super) fn sections<'a>(
    file: &'a str,
    text: &'a str,
) -> impl Iterator<Item = (Range<usize>, Option<&'a str>)> {
    const APART: [&str; 5] = ["_N_WKS_DIR", "_N_MPF_DIR", "_N_SPF_DIR", "_N_CST_DIR", "_N_CUS_DIR"];
    let mut lines = lines(text).peekable();
    let mut program = is_program(file).then_some(file);
    std::iter::from_fn(move || {
        let line = lines.next()?;
        if let Some(name) = header(&text[line.clone()]) {
            let next = lines.peek().map_or("", |next| text[next.clone()].trim());
            let path = next.to_ascii_uppercase();
            let lies_apart =
                path.starts_with(";$PATH=") && APART.iter().any(|folder| path.contains(folder));
            program = (is_program(name) || lies_apart).then_some(name);
        }
        Some((line, program))
    })
}

/// The name in the header of a section.
pub(super) fn header(line: &str) -> Option<&str> {
    line.trim().strip_prefix("%_N_")
}

/// Whether a name is that of a part program.
pub(super) fn is_program(name: &str) -> bool {
    let name = name.to_ascii_uppercase().replace('.', "_");
    name.ends_with("_MPF") || name.ends_with("_SPF")
}

/// What a line is to the compensation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Concern {
    /// None.
    Nothing,
    /// An assignment of no concern.
    PassedOver,
    /// `METRIC` or `INCH`: the unit of the data, whichever the control counts in.
    Unit(ControlUnit),
    /// An end word.
    End,
    /// Of a table.
    Table,
    /// A machine or setting datum that is read beside tables; or no plain assignment that writes data of the
    /// compensation all the same, as `IF R1==1 $MA_CEC_ENABLE[AX1]=0`, or is a broken one.
    Data,
}

/// What a line is to the compensation, and its code.
pub(super) fn concern(text: &str, line: &Range<usize>) -> (Concern, Range<usize>) {
    let code = code_of(text, line);
    let without = without_checksum(&text[code.clone()]);
    let code = code.start..code.start + without.len();
    let mut cursor = Cursor::new(text, code.clone(), BLANKS);
    cursor.peek_word();
    block_number(&mut cursor);
    let found = match cursor.peek_word() {
        None => Concern::Nothing,
        Some('$') => assignment(&mut cursor),
        Some(_) => word(&mut cursor),
    };
    (found, code)
}

fn assignment(cursor: &mut Cursor<'_>) -> Concern {
    let whole = cursor.text(cursor.rest());
    cursor.at += 1;
    let name = take_word(cursor);
    // Of the reference point values the first alone: the others are for further reference cams.
    let is_other_cam = || {
        let mut behind = cursor.clone();
        behind.eat("[");
        behind.peek_word();
        name == "MA_REFP_SET_POS" && behind.digits() != "0"
    };
    if is_of_table(&name) {
        Concern::Table
    } else if data().any(|known| known == name) && !is_other_cam() {
        Concern::Data
    } else if whole.contains('=') {
        Concern::PassedOver
    } else {
        mentions_data(whole)
    }
}

fn word(cursor: &mut Cursor<'_>) -> Concern {
    const LONGEST: usize = 6;
    let whole = cursor.text(cursor.rest());
    if whole.len() > LONGEST {
        return mentions_data(whole);
    }
    match whole.to_ascii_uppercase().as_str() {
        "METRIC" => Concern::Unit(ControlUnit::Millimetre),
        "INCH" => Concern::Unit(ControlUnit::Inch),
        word if is_end(word) => Concern::End,
        _ => Concern::Nothing,
    }
}

fn mentions_data(code: &str) -> Concern {
    if !code.contains('$') {
        return Concern::Nothing;
    }
    let code = code.to_ascii_uppercase();
    let mut names = data().chain(["AA_ENC_COMP", "AN_CEC"]);
    match names.any(|name| code.contains(&format!("${name}"))) {
        true => Concern::Data,
        false => Concern::Nothing,
    }
}

/// Code without the checksum that a control may write behind an assignment: blank, apostrophe,
/// four hexadecimal digits (MD11230 `MD_FILE_STYLE`; 840D/810D Start-Up Guide 03/2006, 11.12.1).
/// It is ignored, not checked: how it is computed is not published.
fn without_checksum(code: &str) -> &str {
    let Some((statement, sum)) = code.rsplit_once('\'') else {
        return code;
    };
    let digits = sum.trim_end();
    let is_sum = digits.len() == 4 && digits.bytes().all(|b| b.is_ascii_hexdigit());
    match is_sum && statement.contains('=') && statement.ends_with([' ', '\t']) {
        true => statement,
        false => code,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on has to stop")]

    use super::*;

    fn header(name: &str, size: usize, folder: &str) -> Vec<u8> {
        let mut header = vec![0; BLOCK];
        let mut put = |at: usize, text: &str| {
            header[at..at + text.len()].copy_from_slice(text.as_bytes());
        };
        put(NAME.start, name);
        put(SHOWN.start, name);
        put(SIZE.start, &size.to_string());
        put(FOLDER.start, folder);
        let sum: u32 = header.iter().map(|byte| u32::from(*byte)).sum();
        let sum = sum.to_string();
        header[SUM.start..SUM.start + sum.len()].copy_from_slice(sum.as_bytes());
        header
    }

    fn archive(files: &[(&str, &str, &str)]) -> Vec<u8> {
        let list = files.iter().map(|(name, folder, _)| format!("{folder}{name}\n"));
        let list: String = list.collect();
        let first = ("@@MMCIBN.002", "", list.as_str());
        let mut bytes = Vec::new();
        for (name, folder, text) in std::iter::once(&first).chain(files) {
            bytes.extend(header(name, text.len(), folder));
            bytes.extend(text.as_bytes());
            bytes.resize(bytes.len().next_multiple_of(BLOCK), 0);
        }
        bytes
    }

    #[test]
    fn an_archive_is_split_at_its_headers() {
        let long = "$AN_CEC[0,0]=0\n".repeat(50);
        let bytes = archive(&[
            ("_N_AX_EEC_INI", ACTIVE_DATA, "METRIC\nM17\n"),
            ("_N_MACCESS_DEF", "\\DEF.DIR\\", "REDEF $MA_CEC_ENABLE APW 7\n"),
            ("_N_COMP_MPF", "\\MPF.DIR\\", &long),
            ("@@_N_IBN_SS", ACTIVE_DATA, ""),
        ]);
        assert!(is_archive(&bytes));
        let parts = parts("all.arc", &bytes).unwrap();
        let names: Vec<&str> = parts.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["all.arc/_N_AX_EEC_INI", "all.arc/_N_COMP_MPF"]);
        assert_eq!(parts[0].1, b"METRIC\nM17\n");
        assert_eq!(parts[1].1, long.as_bytes());
    }

    #[test]
    fn a_damaged_archive_is_refused() {
        let whole = archive(&[("_N_AX_EEC_INI", ACTIVE_DATA, &"0".repeat(2000))]);
        for length in [600, 1024, 1500, 2000, whole.len() - 1] {
            assert!(parts("all.arc", &whole[..length]).is_err(), "{length}");
        }
        let mut changed = whole;
        changed[2 * BLOCK + SIZE.start] = b'1';
        assert!(parts("all.arc", &changed).is_err());
    }
}
