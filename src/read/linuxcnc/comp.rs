//! A table of a joint: `nominal forward reverse`, one row for each line.
//!
//! LinuxCNC stops reading without a word at the first line that does not begin with three numbers, drops rows
//! that do not ascend, and takes 256 (usrmotintf.cc, usrmotLoadComp). A file in which a row is lost so is
//! refused at that place: nobody meant it.

use crate::control::controller::LinuxcncFacts;
use crate::control::table::Point;
use crate::read::lexer::{Complaint, Cursor, lines, located};
use crate::text::Problems;
use std::ops::Range;

/// LinuxCNC reads a line in pieces of this many characters.
const LONGEST_LINE: usize = 253;

/// Positions and values of a table lie below it, in mm or inch.
const LONGEST: f64 = 1e6;

/// The rows of a file.
pub(super) fn rows(file: &str, text: &str, facts: &LinuxcncFacts) -> Result<Vec<Point>, Problems> {
    let refuse = |complaint| Err(located(file, text, vec![complaint]));
    let mut rows: Vec<Point> = Vec::new();
    let mut lines = lines(text).map(|span| (row(text, &span), span));
    let stop = loop {
        match lines.next() {
            Some((Some(row), span)) => match wrong(&rows, row, &span, facts.rows.value) {
                Some(complaint) => return refuse(complaint),
                None => rows.push(row),
            },
            other => break other.map_or(0..0, |(_, span)| span),
        }
    };
    if lines.any(|(row, _)| row.is_some()) {
        return refuse(stops(stop));
    }
    if rows.is_empty() { refuse(no_row(stop)) } else { Ok(rows) }
}

/// Whether the first line is a row.
pub(super) fn begins_with_a_row(text: &str) -> bool {
    lines(text).next().is_some_and(|span| row(text, &span).is_some())
}

/// The three numbers that a line begins with.
fn row(text: &str, span: &Range<usize>) -> Option<Point> {
    let mut cursor = Cursor::new(text, span.clone(), &[' ', '\t']);
    let [position, forward] = [number(&mut cursor)?, number(&mut cursor)?];
    Some(Point { position, forward, reverse: Some(number(&mut cursor)?) })
}

/// A number as `scanf` takes it; what stands behind it is left.
fn number(cursor: &mut Cursor<'_>) -> Option<f64> {
    cursor.peek_word();
    let start = cursor.at;
    cursor.eat("+-");
    let whole = cursor.digits();
    let point = cursor.peek() == Some('.');
    cursor.at += usize::from(point);
    if whole.is_empty() && cursor.digits().is_empty() {
        return None;
    }
    cursor.digits();
    let mantissa = cursor.at;
    if cursor.take(|c| "eE".contains(c)).len() == 1 {
        cursor.take(|c| "+-".contains(c));
    }
    if cursor.digits().is_empty() {
        cursor.at = mantissa;
    }
    let number = cursor.text(start..cursor.at).parse::<f64>().ok()?;
    Some(number + 0.0) // −0 is 0
}

/// What is wrong with a row behind those before it.
fn wrong(before: &[Point], row: Point, span: &Range<usize>, most: u32) -> Option<Complaint> {
    let is_length = |number: f64| number.abs() < LONGEST;
    let complaint = |message: String, help: &str| Some(Complaint::new(span.clone(), message, help));
    if span.len() > LONGEST_LINE {
        let message = format!("a line of {} characters, LinuxCNC takes {LONGEST_LINE}", span.len());
        return complaint(message, "write three numbers in a line");
    }
    if ![row.position, row.forward].into_iter().chain(row.reverse).all(is_length) {
        let message = "a number beyond every machine".to_string();
        return complaint(message, "write positions and values in the machine unit");
    }
    let last = before.last().map(|last| last.position);
    if let Some(last) = last.filter(|last| row.position <= *last) {
        let message = format!(
            "position {} does not lie above {last} of the row before: LinuxCNC drops the row",
            row.position
        );
        return complaint(message, "rows ascend, each position once");
    }
    if before.len() >= most as usize {
        let message = format!("a row behind the {most} that LinuxCNC takes: it runs without it");
        return complaint(message, "use a larger spacing");
    }
    None
}

fn stops(span: Range<usize>) -> Complaint {
    Complaint::new(
        span,
        "LinuxCNC stops reading here without a word: rows below this line do nothing",
        "a table holds no comment, header or blank line",
    )
}

fn no_row(span: Range<usize>) -> Complaint {
    Complaint::new(
        span,
        "no row begins the file: LinuxCNC runs without this table, and says nothing",
        "a table holds `nominal forward reverse` in each line and nothing else",
    )
}
