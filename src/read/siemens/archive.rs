//! The commissioning archive of an 840D sl, split into its files.
//!
//! ```text
//!   header (512 bytes) │ content, filled with zeros to a multiple of 512 │ header │ content │ …
//!     0 name, 50 name and 384 folder as the HMI shows them, 124 size, 148 sum of the header
//! ```
//! The first content lists all files, so one that is not there is missed.
//! Plain text between the headers, nothing is compressed. From a real archive of 2016 (first header
//! `@@MMCIBN.002`); in all of its 325 headers the number at 148 is the sum of the other bytes, so a
//! place that is no header is found. Older archives with `%_N_…` headers are text and need no splitting.

use crate::read::family::Part;
use crate::text::problem::Problem;
use std::collections::BTreeSet;

/// Size of a header, and of the unit that contents fill.
const BLOCK: usize = 512;
/// Places in a header.
const NAME: std::ops::Range<usize> = 0..50;
const SHOWN: std::ops::Range<usize> = 50..100;
const SIZE: std::ops::Range<usize> = 124..136;
const SUM: std::ops::Range<usize> = 148..156;
const FOLDER: std::ops::Range<usize> = 384..BLOCK;
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
    match listed(list).find(|name| !active.contains(name.as_str())) {
        None => Ok(parts),
        Some(name) => Err(damaged(
            file,
            &format!("`{name}`, which it lists, is missing"),
        )),
    }
}

/// The active data that the first content lists, as the HMI shows them.
fn listed(list: &[u8]) -> impl Iterator<Item = String> {
    let lines = list
        .split(|byte| *byte == b'\n')
        .map(String::from_utf8_lossy);
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
    let own: u32 = word(&header[SUM])?.parse().ok()?;
    if own != sum(&header[..SUM.start]) + sum(&header[SUM.end..]) {
        return None;
    }
    let size: usize = word(&header[SIZE])?.parse().ok()?;
    let start = at + BLOCK;
    let next = start.checked_add(size.checked_next_multiple_of(BLOCK)?)?;
    let content = bytes.get(start..next)?;
    Some(Entry {
        name: word(&header[NAME])?,
        bytes: &content[..size],
        shown: word(&header[SHOWN])?,
        folder: word(&header[FOLDER])?,
        next,
    })
}

/// A text field, without the zeros behind it.
fn word(field: &[u8]) -> Option<&str> {
    let end = field.iter().position(|byte| *byte == 0);
    std::str::from_utf8(&field[..end.unwrap_or(field.len())]).ok()
}

fn damaged(file: &str, what: &str) -> Problem {
    Problem::new(format!("the archive `{file}` is damaged or cut off: {what}"))
        .help("copy the archive from the control again, or name the files read out one by one (AX_EEC.INI, NC_CEC.INI, INITIAL.INI)")
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
        let list = files
            .iter()
            .map(|(name, folder, _)| format!("{folder}{name}\n"));
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
            (
                "_N_MACCESS_DEF",
                "\\DEF.DIR\\",
                "REDEF $MA_CEC_ENABLE APW 7\n",
            ),
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
