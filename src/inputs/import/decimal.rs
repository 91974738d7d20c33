//! Which sign stands before the decimals of a file's numbers: `1,000` may be one or a thousand.

use crate::inputs::import::choices::Decimal;
use crate::text::delimited::Line;
use crate::text::problem::{Problem, Problems, shown};
use std::borrow::Cow;

/// A cell that holds a number.
pub(super) struct NumberCell<'a> {
    pub(super) line: Line<'a>,
    pub(super) index: usize,
    pub(super) text: Cow<'a, str>,
}

impl NumberCell<'_> {
    fn problem(&self, message: String, help: &str) -> Problem {
        Problem::new(message)
            .at(self.line.cell_place(self.index))
            .help(help)
    }

    fn has(&self, sign: char) -> bool {
        self.text.contains(sign)
    }

    /// As a thousand or more would be written with a comma between thousands, e.g. `1,000`.
    fn may_be_thousands(&self) -> bool {
        let digits = self.text.trim_start_matches(['+', '-']);
        let Some((before, behind)) = digits.split_once(',') else {
            return false;
        };
        let is_digits = |part: &str| part.chars().all(|c| c.is_ascii_digit());
        (1..=3).contains(&before.len())
            && is_digits(before)
            && !before.starts_with('0')
            && behind.len() == 3
            && is_digits(behind)
    }
}

const PLAIN: &str =
    "write all numbers with a decimal point or all with a comma, and nothing between thousands";

/// The sign before the decimals: as stated, else as all numbers of the file show it. `cells` gives all of
/// them, as often as it is asked.
pub(super) fn decimal_of<'a, C: Iterator<Item = NumberCell<'a>>>(
    cells: &impl Fn() -> C,
    stated: Option<Decimal>,
    problems: &mut Problems,
) -> Decimal {
    let commas = || cells().filter(|cell| cell.has(','));
    let Some(first) = commas().next() else {
        refuse_points(cells, stated, problems);
        return stated.unwrap_or(Decimal::Point);
    };
    let text = shown(&first.text);
    match stated {
        Some(Decimal::Point) => problems.push(first.problem(
            format!("`{text}` holds a comma, but `--decimal point` was stated"),
            "write nothing between thousands",
        )),
        Some(Decimal::Comma) => refuse_points(cells, stated, problems),
        None if first.line.delimiter() == b',' => problems.push(first.problem(
            format!("`{text}` holds a comma in a file whose columns are separated by commas: it may stand between thousands"),
            "write nothing between thousands; if it stands before decimals, add `--decimal comma`",
        )),
        None if cells().any(|cell| cell.has('.')) => refuse_mixed(cells, problems),
        None if commas().all(|cell| cell.may_be_thousands()) => problems.push(first.problem(
            format!("`{text}` may be a thousand or a decimal: no number of the file shows what its comma means"),
            "add `--decimal comma` if decimals stand behind it; else write nothing between thousands",
        )),
        None => return Decimal::Comma,
    }
    stated.unwrap_or(Decimal::Comma)
}

/// A point in a file whose decimals were stated to stand behind a comma.
fn refuse_points<'a, C: Iterator<Item = NumberCell<'a>>>(
    cells: &impl Fn() -> C,
    stated: Option<Decimal>,
    problems: &mut Problems,
) {
    if stated != Some(Decimal::Comma) {
        return;
    }
    for cell in cells().filter(|cell| cell.has('.')) {
        problems.push_with(|| {
            cell.problem(
                format!(
                    "`{}` holds a point, but `--decimal comma` was stated",
                    shown(&cell.text)
                ),
                "write nothing between thousands, or leave `--decimal` out",
            )
        });
    }
}

/// One file writes its decimals in one way; else a comma may stand between thousands.
fn refuse_mixed<'a, C: Iterator<Item = NumberCell<'a>>>(
    cells: &impl Fn() -> C,
    problems: &mut Problems,
) {
    let with_sign = || cells().filter(|cell| cell.has(',') || cell.has('.'));
    let Some(comma) = with_sign().next().map(|cell| cell.has(',')) else {
        return;
    };
    for cell in
        with_sign().filter(|cell| cell.has(',') != comma || (cell.has(',') && cell.has('.')))
    {
        problems.push_with(|| {
            cell.problem(
                format!(
                    "`{}` has another decimal separator than the numbers above it",
                    shown(&cell.text)
                ),
                PLAIN,
            )
        });
    }
}
