//! Text files of rows and columns that users write: comma or semicolon, a header, comments.
//!
//! Every cell keeps its place. The unit is part of a column's name; a decimal comma is read only
//! where semicolons separate the columns. What the columns mean is the reader's who asks:
//! [`crate::inputs::error_table`], `crate::inputs::readings`.

use crate::quantity::{MM_PER_INCH, UM_PER_MM};
use crate::text::{
    LARGEST_NUMBER, Place, Problem, Problems, Source, counted, nearest, refusals, shown, words,
};
use std::borrow::Cow;
use std::ops::Range;

words! {
    /// A unit of length that a measurement is given in, as in the names of columns and on the command line.
    #[derive(clap::ValueEnum)]
    pub enum LengthUnit {
        /// Micrometres.
        Um = "um",
        /// Millimetres.
        Mm = "mm",
        /// Inches.
        In = "in",
        /// Microinches.
        Uin = "uin",
    }
}

impl LengthUnit {
    /// How many micrometres it has.
    pub const fn um(self) -> f64 {
        let inch = MM_PER_INCH * UM_PER_MM;
        [1.0, UM_PER_MM, inch, inch / 1e6][self as usize]
    }

    /// The unit of a text as people write it, such as `mm`, `µm` or `inch`.
    pub(crate) fn from_text(text: &str) -> Option<LengthUnit> {
        match text.trim().to_lowercase().as_str() {
            "um" | "µm" | "μm" | "micron" | "microns" => Some(LengthUnit::Um),
            "mm" => Some(LengthUnit::Mm),
            "in" | "inch" | "inches" => Some(LengthUnit::In),
            "uin" | "µin" | "μin" | "microinch" => Some(LengthUnit::Uin),
            _ => None,
        }
    }
}

/// One line of the file. Its cells and places are found when they are asked for: a table may have
/// a million of them.
#[derive(Clone, Copy)]
pub struct Line<'a> {
    source: &'a Source,
    number: usize,
    /// Where it begins in the text of its source.
    pub(crate) start: usize,
    text: &'a str,
    delimiter: u8,
    decimal_comma: bool,
}

impl<'a> Line<'a> {
    /// The line with other separators between its columns; a comma is read as a decimal comma where
    /// `decimal_comma` says so.
    pub(crate) const fn separated_by(&self, delimiter: u8, decimal_comma: bool) -> Line<'a> {
        Line { delimiter, decimal_comma, ..*self }
    }

    /// The line without its last cells, if they are empty.
    fn without_last(mut self, cells: usize) -> Line<'a> {
        for _ in 0..cells {
            let shorter = self.text.trim_end_matches([' ', '\t']);
            self.text = shorter.strip_suffix(char::from(self.delimiter)).unwrap_or(self.text);
        }
        self
    }

    /// What separates its columns.
    pub(crate) const fn delimiter(&self) -> u8 {
        self.delimiter
    }

    /// What stands in the line.
    pub const fn text(&self) -> &'a str {
        self.text
    }

    /// Whether it holds nothing but separators, as spreadsheets write below a table.
    pub(crate) fn is_empty_row(&self) -> bool {
        self.text.chars().all(|c| c == char::from(self.delimiter) || c == '"' || c.is_whitespace())
    }

    /// Number of the line in the file, from 1.
    pub const fn number(&self) -> usize {
        self.number
    }

    /// Its cells, without quotation marks and the spaces around them.
    pub fn cells(&self) -> Vec<Cow<'a, str>> {
        spans_of(self.text, self.delimiter).map(|span| unquoted(self.text[span].trim())).collect()
    }

    /// Its cells, if they are as many as in the header.
    pub(crate) fn cells_under(&self, columns: usize) -> Result<Vec<Cow<'a, str>>, Problem> {
        if self.text.bytes().filter(|byte| *byte == b'"').count() % 2 == 1 {
            return Err(refusals::open_quote().at(self.whole()));
        }
        let cells = self.cells();
        let help = match cells.len() {
            found if found == columns => return Ok(cells),
            found if found > columns => TOO_MANY_CELLS,
            _ => {
                "every row has as many cells as the header: a cell that may be empty keeps its separator"
            }
        };
        Err(refusals::other_length(counted(cells.len(), "cell"), columns, help).at(self.whole()))
    }

    fn place(&self, span: Range<usize>) -> Place {
        self.source.place(&(self.start + span.start..self.start + span.end))
    }

    /// The place of the whole line.
    pub fn whole(&self) -> Place {
        self.place(0..self.text.len())
    }

    /// The place of a cell.
    pub(crate) fn cell_place(&self, index: usize) -> Place {
        let mut spans = spans_of(self.text, self.delimiter);
        let span = spans.nth(index).unwrap_or(self.text.len()..self.text.len());
        let cell = &self.text[span.clone()];
        let start = span.end - cell.trim_start().len();
        self.place(start..start + cell.trim().len().max(1))
    }

    /// The finite number of a cell; `expected` is the next step where it is none.
    pub(crate) fn number_in(
        &self,
        index: usize,
        cell: &str,
        name: &str,
        expected: &str,
        problems: &mut Problems,
    ) -> Option<f64> {
        let number = written_number(cell, self.decimal_comma);
        if let Some(number) = number.filter(|number| number.abs() <= LARGEST_NUMBER) {
            return Some(number);
        }
        problems.push_with(|| {
            let found = match cell {
                "" => "empty".to_string(),
                _ => format!("`{}`", shown(cell)),
            };
            let (what, help) = match number {
                Some(_) => ("which is too large for any machine", "check the cell"),
                None if cell.contains(',') && !self.decimal_comma => {
                    ("expected a finite number", DECIMAL_COMMA)
                }
                None => ("expected a finite number", expected),
            };
            let problem = refusals::other_number(name, found, what, help);
            problem.at(self.cell_place(index)).in_column(index)
        });
        None
    }
}

const TOO_MANY_CELLS: &str = "a decimal comma needs semicolons between the columns, or write a decimal point; if it is none, remove what is too much";
const DECIMAL_COMMA: &str =
    "a decimal comma needs semicolons between the columns; or write a decimal point";

/// What people write as a number, also with the minus sign U+2212 of word processors.
pub(crate) fn written_number(cell: &str, decimal_comma: bool) -> Option<f64> {
    let point = if decimal_comma { Cow::from(cell.replace(',', ".")) } else { Cow::from(cell) };
    match point.strip_prefix('\u{2212}') {
        Some(magnitude) => plain_number(&format!("-{magnitude}")),
        None => plain_number(&point),
    }
}

/// A finite number of digits, signs, a decimal point and an exponent; no words such as `inf` and `NaN`.
pub(crate) fn plain_number(text: &str) -> Option<f64> {
    let plain =
        text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'+' | b'-' | b'.' | b'e' | b'E'));
    let number = text.parse::<f64>().ok();
    let number = number.filter(|number| plain && number.is_finite())?;
    Some(number + 0.0) // −0 becomes 0
}

/// Every line of a text; what separates its columns is taken from the line itself: the first of
/// semicolon, tab and comma that it holds.
pub fn lines(source: &Source) -> impl Iterator<Item = Line<'_>> {
    let mut next = 0;
    source.text.split('\n').zip(1..).map(move |(text, number)| {
        let start = next;
        next += text.len() + 1;
        let found = [b';', b'\t', b','].into_iter().find(|d| text.contains(char::from(*d)));
        let delimiter = found.unwrap_or(b',');
        Line {
            source,
            number,
            start,
            text: text.trim_end_matches('\r'),
            delimiter,
            decimal_comma: delimiter == b';',
        }
    })
}

/// The header and the rows below it, without comments, empty rows and the empty columns that spreadsheets leave
/// on the right; `None` = neither.
pub(crate) fn header_and_rows(source: &Source) -> Option<(Line<'_>, Vec<Line<'_>>)> {
    let content = lines(source)
        .filter(|line| !line.text.trim().is_empty() && !line.text.trim_start().starts_with('#'));
    let mut content = content.peekable();
    let delimiter = match content.peek() {
        Some(header) if header.text.contains(';') => b';',
        _ => b',',
    };
    let mut lines = content
        .map(|line| line.separated_by(delimiter, delimiter == b';'))
        .filter(|line| !line.is_empty_row());
    let header = lines.next()?;
    let nameless = header.cells().iter().rev().take_while(|name| name.is_empty()).count();
    Some((header.without_last(nameless), lines.map(|line| line.without_last(nameless)).collect()))
}

/// A cell without the quotation marks around it; two of them inside stand for one.
fn unquoted(cell: &str) -> Cow<'_, str> {
    let inside = cell.strip_prefix('"').and_then(|c| c.strip_suffix('"'));
    match inside {
        Some(inside) if inside.contains('"') => Cow::Owned(inside.replace("\"\"", "\"")),
        Some(inside) => Cow::Borrowed(inside.trim()),
        None => Cow::Borrowed(cell),
    }
}

/// Where the cells stand, with the blanks around them.
fn spans_of(line: &str, delimiter: u8) -> impl Iterator<Item = Range<usize>> {
    let mut quoted = false;
    let is_end = move |byte: &u8| {
        quoted ^= *byte == b'"';
        *byte == delimiter && !quoted
    };
    let mut start = 0;
    line.as_bytes().split(is_end).map(move |cell| {
        let end = start + cell.len();
        std::mem::replace(&mut start, end + 1)..end
    })
}

/// Columns of a table; runs of a linear axis are far fewer.
const MOST_COLUMNS: usize = 1000;

/// Whatever a line with more of them is, it is no header of a table.
pub(crate) fn refuse_many_columns(header: &Line<'_>, help: &str) -> Result<(), Problem> {
    match header.cells().len() {
        0..=MOST_COLUMNS => Ok(()),
        count => Err(refusals::many_columns(count, MOST_COLUMNS, help).at(header.whole())),
    }
}

/// A table without header, or with tabs, would be one unknown column after the other.
pub(crate) fn refuse_other_first_line(header: &Line<'_>, help: &str) -> Result<(), Problem> {
    refuse_many_columns(header, help)?;
    let message = if header.text.contains('\t') {
        "the columns are separated by tabs, expected commas or semicolons"
    } else if header.cells().iter().any(|cell| cell.parse::<f64>().is_ok()) {
        "the first line holds numbers, expected the names of the columns"
    } else {
        return Ok(());
    };
    Err(Problem::new(message).help(help).at(header.whole()))
}

/// What stands before the unit of a name.
fn quantity(name: &str) -> Option<&str> {
    name.rsplit_once('_').map(|(quantity, _)| quantity)
}

/// That no known column has this name: which was meant, or `columns`, the next step where none is near.
pub(crate) fn unknown_column(name: &str, known: &[&str], columns: &str) -> Problem {
    let with_unit = |wanted: &str| -> Vec<String> {
        let of = known.iter().filter(|known| quantity(known) == Some(wanted));
        of.map(|name| format!("`{name}`")).collect()
    };
    let found = shown(name);
    let other = quantity(name).map(with_unit).unwrap_or_default();
    for (list, what) in [(with_unit(name), "no unit"), (other, "an unknown unit")] {
        if !list.is_empty() {
            return refusals::column_unit(found, what, list.join(", "));
        }
    }
    let Some(near) = nearest(name, known.iter().copied()) else {
        return refusals::unknown_column(found, columns);
    };
    // A quantity may stand in several units; which of them was meant nobody knows.
    let meant = match with_unit(quantity(near).unwrap_or(near)).as_slice() {
        [] => format!("`{near}`"),
        meant => meant.join(" or "),
    };
    refusals::unknown_column(found, format!("did you mean {meant}?"))
}

#[cfg(test)]
mod tests {
    use super::{plain_number, written_number};

    #[test]
    fn a_number_beyond_all_numbers_is_none() {
        for text in ["1e900", "-1e900", "inf", "NaN", ""] {
            assert_eq!(plain_number(text), None, "{text}");
        }
        assert_eq!(plain_number("-1.5e1"), Some(-15.0));
        // A minus of a control is a hyphen.
        assert_eq!([plain_number("−1.5"), written_number("−1,5", false)], [None; 2]);
        assert_eq!([written_number("−1,5", true), written_number("−-1", true)], [Some(-1.5), None]);
    }
}
