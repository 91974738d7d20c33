//! The commissioning archive of an 840D sl, split into its files.
//!
//! ```text
//!   header (512 bytes) │ content, filled with zeros to a multiple of 512 │ header │ content │ …
//!     0 name, 124 size, 148 sum of the header, 384 folder as the HMI shows it
//! ```
//! Plain text between the headers, nothing is compressed. From a real archive of 2016 (first header
//! `@@MMCIBN.002`); in all of its 325 headers the number at 148 is the sum of the other bytes, so a
//! place that is no header is found. Older archives with `%_N_…` headers are text and need no splitting.

use crate::problem::Problem;

/// Size of a header, and of the unit that contents fill.
const BLOCK: usize = 512;
/// Places in a header.
const NAME: std::ops::Range<usize> = 0..50;
const SIZE: std::ops::Range<usize> = 124..136;
const SUM: std::ops::Range<usize> = 148..156;
const FOLDER: std::ops::Range<usize> = 384..BLOCK;
/// How the first header begins.
const BEGIN: &[u8] = b"@@MMCIBN.";
/// The folder of the active data.
const ACTIVE_DATA: &str = "\\_NC_ACT.DIR\\";

/// A file of an archive.
pub(super) struct Part<'a> {
    /// Its name as in the control, such as `_N_AX_EEC_INI`.
    pub(super) name: &'a str,
    /// Its bytes.
    pub(super) bytes: &'a [u8],
}

/// Whether a file is such an archive.
pub(super) fn is_archive(bytes: &[u8]) -> bool {
    bytes.starts_with(BEGIN)
}

/// The active data and part programs of an archive; what else lies in it (drives, definitions,
/// descriptions) holds no compensation.
///
/// limits refused where a header does not add up or a content is cut off
pub(super) fn parts<'a>(file: &str, bytes: &'a [u8]) -> Result<Vec<Part<'a>>, Problem> {
    let mut parts = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let (part, folder, next) = entry(bytes, at).ok_or_else(|| damaged(file, at))?;
        let is_program = part.name.ends_with("_MPF") || part.name.ends_with("_SPF");
        if !part.bytes.is_empty() && (folder == ACTIVE_DATA || is_program) {
            parts.push(part);
        }
        at = next;
    }
    Ok(parts)
}

/// The file whose header begins at `at`, its folder, and where the next header begins.
fn entry(bytes: &[u8], at: usize) -> Option<(Part<'_>, &str, usize)> {
    let header = bytes.get(at..at + BLOCK)?;
    let sum = |range: &[u8]| range.iter().map(|byte| u32::from(*byte)).sum::<u32>();
    let own: u32 = word(&header[SUM])?.parse().ok()?;
    if own != sum(&header[..SUM.start]) + sum(&header[SUM.end..]) {
        return None;
    }
    let size: usize = word(&header[SIZE])?.parse().ok()?;
    let start = at + BLOCK;
    let part = Part {
        name: word(&header[NAME])?,
        bytes: bytes.get(start..start.checked_add(size)?)?,
    };
    let next = start + size.checked_next_multiple_of(BLOCK)?;
    Some((part, word(&header[FOLDER])?, next))
}

/// A text field, without the zeros behind it.
fn word(field: &[u8]) -> Option<&str> {
    let end = field.iter().position(|byte| *byte == 0);
    std::str::from_utf8(&field[..end.unwrap_or(field.len())]).ok()
}

fn damaged(file: &str, at: usize) -> Problem {
    Problem::new(format!(
        "the archive `{file}` is damaged or cut off: what begins at byte {at} is not a complete file of it"
    ))
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
        put(SIZE.start, &size.to_string());
        put(FOLDER.start, folder);
        let sum: u32 = header.iter().map(|byte| u32::from(*byte)).sum();
        let sum = sum.to_string();
        header[SUM.start..SUM.start + sum.len()].copy_from_slice(sum.as_bytes());
        header
    }

    fn archive(files: &[(&str, &str, &str)]) -> Vec<u8> {
        let mut bytes = header("@@MMCIBN.002", 0, "");
        for (name, folder, text) in files {
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
        let names: Vec<&str> = parts.iter().map(|part| part.name).collect();
        assert_eq!(names, ["_N_AX_EEC_INI", "_N_COMP_MPF"]);
        assert_eq!(parts[0].bytes, b"METRIC\nM17\n");
        assert_eq!(parts[1].bytes, long.as_bytes());
    }

    #[test]
    fn a_damaged_archive_is_refused() {
        let whole = archive(&[("_N_AX_EEC_INI", ACTIVE_DATA, &"0".repeat(2000))]);
        for length in [600, 1024, 1500, 2900] {
            assert!(parts("all.arc", &whole[..length]).is_err(), "{length}");
        }
        let mut changed = whole;
        changed[BLOCK + SIZE.start] = b'1';
        assert!(parts("all.arc", &changed).is_err());
    }
}
