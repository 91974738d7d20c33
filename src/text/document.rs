//! TOML pages that users write, read key by key with every place kept.
//!
//! Jobs and controller profiles are read through [`Section`]. It notes each problem (wrong type,
//! unknown key, missing key) with its line and goes on, so that one run shows all of them. The
//! places of all keys stay available for later checks through [`Source::place_of`].

pub(crate) mod keys;
mod page;
mod section;

pub(crate) use self::page::{Pages, read_page, states};

pub use self::keys::Key;
pub(crate) use self::keys::{part, section};
use crate::text::{LineIndex, Place, Problem, Problems, refusals};
pub use section::Section;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};
use std::ops::Range;

/// A text file with its name as the user gave it, and the places of its keys.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Source {
    /// The name, as shown in messages.
    pub name: String,
    /// The text, without byte order mark.
    pub text: String,
    /// Where the value of each key stands, by its dotted path, with the number of each entry of a list (`linear[1]`).
    spots: Vec<(String, Range<usize>)>,
    lines: LineIndex,
    /// Where the text of a page below begins, with its name.
    below: Vec<(usize, String)>,
}

/// Lines of a text that a user writes or an instrument saves, and rows of a table of corrections that the
/// program writes or reads. What is made of one line takes some 300 bytes, so this keeps all of it in
/// 15 MB; a measurement of 1000 points with five runs each way has 10 000 lines.
pub const MOST_LINES: usize = 50_000;
/// Rows of a generic table that are read: more points than any control has, by a factor of ten.
pub const MOST_ROWS: usize = 50_000;
/// Points of all tables of a kit together. A template sees each of them with 2.3 kB, and a kit is also made only to be
/// judged; nine errors in two directions with 500 points are 9000.
pub const MOST_POINTS: usize = 10_000;
/// Bytes of a page: a job or a profile (TOML), or a manifest (JSON). Each value of a page takes up to a
/// hundred bytes of memory; the largest page of the program itself has 20 kB.
pub const LARGEST_PAGE: usize = 1 << 18;

impl Source {
    /// A file from its bytes; UTF-8 with or without byte order mark, text only.
    ///
    /// limits [`MOST_LINES`] lines, none longer than [`LONGEST_LINE_BYTES`]
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Source, Problems> {
        let text = std::str::from_utf8(bytes)
            .ok()
            .filter(|text| !text.contains('\0'))
            .ok_or_else(|| not_utf_8(name, bytes))?;
        refuse_many_lines(name, text)?;
        refuse_long_lines(name, text)?;
        Ok(Source {
            name: name.to_string(),
            text: text.strip_prefix('\u{feff}').unwrap_or(text).to_string(),
            ..Source::default()
        })
    }

    /// The place of bytes of the text.
    pub fn place(&self, span: &Range<usize>) -> Place {
        let next = self.below.partition_point(|(from, _)| *from <= span.start);
        let end = self.below.get(next).map_or(self.text.len(), |(from, _)| *from);
        match next.checked_sub(1).map(|page| &self.below[page]) {
            None => self.lines.place(&self.name, &self.text[..end], span.start, span.end),
            Some((from, name)) => {
                let text = &self.text[*from..end];
                LineIndex::default().place(name, text, span.start - from, span.end - from)
            }
        }
    }

    /// The place of a key's value, by its dotted path, e.g. `compensation.axes.x.spacing_mm`.
    pub(crate) fn place_of(&self, path: &str) -> Option<Place> {
        Some(self.place(&self.span_of(path)?))
    }

    /// The same as bytes of the text.
    pub(crate) fn span_of(&self, path: &str) -> Option<Range<usize>> {
        Some(self.spots.iter().find(|(own, _)| own == path)?.1.clone())
    }

    /// A problem at a key, or at the nearest section above it that exists.
    pub(crate) fn problem_at(&self, path: &str, message: impl Into<String>) -> Problem {
        self.at(path, Problem::new(message))
    }

    /// The same of a problem that is made already.
    pub(crate) fn at(&self, path: &str, problem: Problem) -> Problem {
        let mut paths = std::iter::successors(Some(path), |path| Some(path.rsplit_once('.')?.0));
        let place = paths.find_map(|path| self.place_of(path));
        problem.at(place.unwrap_or_else(|| self.place(&(0..0))))
    }
}

/// Refuses a text of more than [`MOST_LINES`] lines.
pub(crate) fn refuse_many_lines(name: &str, text: &str) -> Result<(), Problem> {
    let beyond = text.split('\n').nth(MOST_LINES + 1);
    beyond.map_or(Ok(()), |_| Err(refusals::many_lines(name, MOST_LINES)))
}

/// No line of a file that is read as a whole has more bytes: columns are counted and parts are shown
/// without ever passing over more. The longest line of any file seen so far has 8 kB.
pub const LONGEST_LINE_BYTES: usize = 1 << 16;

/// Refuses a text with a line that is longer than anybody writes: with other line ends, or of another
/// kind.
pub(crate) fn refuse_long_lines(name: &str, text: &str) -> Result<(), Problem> {
    let long = text.split('\n').position(|line| line.len() > LONGEST_LINE_BYTES);
    long.map_or(Ok(()), |at| Err(refusals::long_line(at + 1, name, LONGEST_LINE_BYTES)))
}

/// Refuses a page that is larger than anybody writes.
pub(crate) fn refuse_large_page(name: &str, bytes: usize) -> Result<(), Problem> {
    if bytes <= LARGEST_PAGE { Ok(()) } else { Err(refusals::large_page(name, LARGEST_PAGE >> 10)) }
}

/// The text of a template: a page, too.
pub(crate) fn template_text(name: &str, bytes: &[u8]) -> Result<String, Problems> {
    refuse_large_page(name, bytes.len())?;
    Ok(Source::from_bytes(name, bytes)?.text)
}

/// A page of JSON from its bytes, or what is wrong with them, in words that follow "is damaged:".
///
/// limits [`LARGEST_PAGE`] bytes, which whoever writes such a page keeps too ([`refuse_large_page`])
pub(crate) fn json_page<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, String> {
    if bytes.len() > LARGEST_PAGE {
        let most = LARGEST_PAGE >> 10;
        return Err(format!("it holds more than {most} KiB, too much for a manifest"));
    }
    serde_json::from_slice(bytes).map_err(|error| error.to_string())
}

/// What is wrong with bytes that are not UTF-8 text.
pub(crate) fn not_utf_8(name: &str, bytes: &[u8]) -> Problem {
    let good = std::str::from_utf8(bytes).map_or_else(|error| error.valid_up_to(), str::len);
    let what = if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        "is UTF-16 text".to_string()
    } else if bytes.starts_with(b"PK") {
        "is a spreadsheet or an archive".to_string()
    } else if bytes.contains(&0) {
        "is not a text file".to_string()
    } else {
        let line = bytes[..good].split(|byte| *byte == b'\n').count();
        format!("holds a letter in another encoding in line {line}")
    };
    refusals::not_text(name, what)
}

/// Files larger than this are no job, table or profile (an error table of 10 000 points has 1 MB), and none
/// is made: what was written must be readable again.
pub const LARGEST_FILE_MIB: u64 = 64;
/// No length, deviation or feed of a machine comes near, whatever its unit.
pub const LARGEST_NUMBER: f64 = 1e9;
/// No machine has a kilometre of travel.
pub const LONGEST_MM: f64 = 1e6;

/// SHA-256 in hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_that_nobody_writes_is_refused() {
        let long = "x".repeat(LONGEST_LINE_BYTES);
        assert!(refuse_long_lines("a", &format!("{long}\n{long}")).is_ok());
        let problem = refuse_long_lines("a", &format!("1\n{long}x")).expect_err("it is longer");
        assert!(problem.message.starts_with("line 2 of `a`"), "{problem:?}");
    }

    #[test]
    fn whole_numbers_may_be_written_in_other_bases() {
        let page = "blocks = [[0x10, 0b100000]]\n[protocol]\nserial = 0x1F\n";
        let source = Source::from_bytes("job.toml", page.as_bytes()).expect("it is text");
        let read =
            |root: &Section<'_>| Some((root.whole_pairs("blocks"), root.entries("protocol")));
        let (found, _) =
            read_page((source, &[], |_, _| ()), |_| true, read, |_| ()).expect("it is a page");
        let protocol = vec![("serial".to_string(), "0x1F".to_string())];
        assert_eq!(found, (Some(vec![[16, 32]]), protocol));
    }

    #[test]
    fn a_key_of_the_page_below_stands_in_its_own_file() {
        let source = Source::from_bytes("after.toml", b"a = 1\n").expect("it is text");
        let read = |root: &Section<'_>| root.whole("b").zip(root.whole("a"));
        let below = [("job.toml", "# first\nb = 2\n")];
        let pages: Pages<'_> = (source, &below, |own, below| own.extend(below));
        let (_, source) = read_page(pages, |_| true, read, |_| ()).expect("it is a page");
        let place = |key| source.place_of(key).map(|at| (at.file, at.line, at.column));
        assert_eq!(place("a"), Some(("after.toml".to_string(), 1, 5)));
        assert_eq!(place("b"), Some(("job.toml".to_string(), 2, 5)));
    }
}
