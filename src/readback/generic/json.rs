//! The JSON form: `{"schema":1,"rows":[{…}, …]}`.
//!
//! serde_json lets the last of two equal keys win, so the text is read into [`Node`]s, which keep
//! both. It forgets where a value stood, too; the places of complaints are looked up in the text.

use super::check::Reading;
use super::csv::trimmed;
use super::row::{Cell, Column, RawRow, RowFlaw};
use crate::readback::complaint::Complaint;
use crate::table::generic::GenericTable;
use serde::de::{Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_json::{Number, Value};
use std::borrow::Cow;
use std::fmt;
use std::ops::Range;

const SHAPE: &str = "expected {\"schema\":1,\"rows\":[…]}";

pub(super) fn read(text: &str) -> Result<GenericTable, Vec<Complaint>> {
    if text.trim().is_empty() {
        let message = "the file is empty, expected a generic table";
        return Err(vec![Complaint::new(0..0, message, SHAPE)]);
    }
    let top: Entries<'_> = serde_json::from_str(text).map_err(|flaw| vec![syntax(text, &flaw)])?;
    let rows = rows(text, top)?;
    if rows.is_empty() {
        let help = "each row is one point";
        let message = "the table has no rows";
        return Err(vec![Complaint::new(key_span(text, "rows"), message, help)]);
    }
    let mut reading = Reading::default();
    for (number, row) in rows.into_iter().enumerate() {
        if reading.is_full() {
            break;
        }
        match raw_row(number, row) {
            Ok(raw) => reading.take(&raw),
            Err(flaws) => reading.lose_row(flaws),
        }
    }
    reading.finish().map_err(|flaws| located(text, flaws))
}

/// A value whose objects keep equal keys.
enum Node<'a> {
    Cell(Cell<'a>),
    Array(Vec<Node<'a>>),
    Object(Entries<'a>),
}

/// Keys and values of an object, in file order, equal keys included.
struct Entries<'a>(Vec<(Cow<'a, str>, Node<'a>)>);

#[derive(serde::Deserialize)]
struct Key<'a>(#[serde(borrow)] Cow<'a, str>);

impl From<Node<'_>> for Value {
    fn from(node: Node<'_>) -> Value {
        match node {
            Node::Cell(Cell::Empty) => Value::Null,
            Node::Cell(Cell::Text(text)) => Value::String(text.into_owned()),
            Node::Cell(Cell::Number(number)) => Value::Number(number),
            Node::Cell(Cell::Other(value)) => value,
            Node::Array(nodes) => nodes.into_iter().collect(),
            Node::Object(Entries(entries)) => entries.into_iter().collect(),
        }
    }
}

impl<'a> Deserialize<'a> for Node<'a> {
    fn deserialize<D: Deserializer<'a>>(input: D) -> Result<Node<'a>, D::Error> {
        input.deserialize_any(AnyNode)
    }
}

struct AnyNode;

impl<'a> Visitor<'a> for AnyNode {
    type Value = Node<'a>;
    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("any valid JSON value")
    }
    fn visit_unit<E>(self) -> Result<Node<'a>, E> {
        Ok(Node::Cell(Cell::Empty))
    }
    fn visit_bool<E>(self, value: bool) -> Result<Node<'a>, E> {
        Ok(Node::Cell(Cell::Other(value.into())))
    }
    fn visit_u64<E>(self, value: u64) -> Result<Node<'a>, E> {
        Ok(Node::Cell(Cell::Number(value.into())))
    }
    fn visit_i64<E>(self, value: i64) -> Result<Node<'a>, E> {
        Ok(Node::Cell(Cell::Number(value.into())))
    }
    fn visit_f64<E>(self, value: f64) -> Result<Node<'a>, E> {
        let number = Number::from_f64(value);
        Ok(Node::Cell(number.map_or(Cell::Empty, Cell::Number)))
    }
    fn visit_borrowed_str<E>(self, text: &'a str) -> Result<Node<'a>, E> {
        Ok(Node::Cell(Cell::Text(text.into())))
    }
    fn visit_str<E>(self, text: &str) -> Result<Node<'a>, E> {
        Ok(Node::Cell(Cell::Text(text.to_string().into())))
    }
    fn visit_seq<S: SeqAccess<'a>>(self, mut seq: S) -> Result<Node<'a>, S::Error> {
        let mut nodes = Vec::new();
        while let Some(node) = seq.next_element()? {
            nodes.push(node);
        }
        Ok(Node::Array(nodes))
    }
    fn visit_map<M: MapAccess<'a>>(self, map: M) -> Result<Node<'a>, M::Error> {
        InOrder.visit_map(map).map(Node::Object)
    }
}

impl<'a> Deserialize<'a> for Entries<'a> {
    fn deserialize<D: Deserializer<'a>>(input: D) -> Result<Entries<'a>, D::Error> {
        input.deserialize_map(InOrder)
    }
}

struct InOrder;

impl<'a> Visitor<'a> for InOrder {
    type Value = Entries<'a>;
    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("an object")
    }
    fn visit_map<M: MapAccess<'a>>(self, mut map: M) -> Result<Entries<'a>, M::Error> {
        let mut entries = Vec::with_capacity(Column::ALL.len());
        while let Some((Key(key), node)) = map.next_entry()? {
            entries.push((key, node));
        }
        Ok(Entries(entries))
    }
}

/// The first value of each known key, and what is wrong with the keys: each flaw in words, with
/// its key.
fn by_key<'a, const N: usize>(
    Entries(entries): Entries<'a>,
    known: [&str; N],
) -> ([Option<Node<'a>>; N], Vec<(String, String)>) {
    let mut values = [const { None }; N];
    let mut flaws = Vec::new();
    for (key, value) in entries {
        let what = match known.iter().position(|name| *name == key) {
            None => format!("unknown key `{key}`"),
            Some(at) if values[at].is_some() => format!("key `{key}` stands there twice"),
            Some(at) => {
                values[at] = Some(value);
                continue;
            }
        };
        flaws.push((key.into_owned(), what));
    }
    for (key, _) in known
        .iter()
        .zip(&values)
        .filter(|(_, value)| value.is_none())
    {
        flaws.push((key.to_string(), format!("key `{key}` is missing")));
    }
    (values, flaws)
}

fn syntax(text: &str, flaw: &serde_json::Error) -> Complaint {
    let before: usize = text
        .split_inclusive('\n')
        .take(flaw.line().saturating_sub(1))
        .map(str::len)
        .sum();
    let at = before + flaw.column().saturating_sub(1);
    let whole = flaw.to_string();
    let what = whole.split(" at line ").next().unwrap_or(&whole);
    let help = format!("{SHAPE}; the file may have been cut off");
    Complaint::new(at..at + 1, format!("the JSON cannot be read: {what}"), help)
}

/// The elements of `rows`.
fn rows<'a>(text: &str, top: Entries<'a>) -> Result<Vec<Node<'a>>, Vec<Complaint>> {
    let ([schema, rows], flaws) = by_key(top, ["schema", "rows"]);
    let at_key = |key: &str, message| Complaint::new(key_span(text, key), message, SHAPE);
    let mut complaints: Vec<Complaint> = flaws
        .into_iter()
        .map(|(key, message)| at_key(&key, message))
        .collect();
    let mut unexpected = |key: &str, found: Node<'_>, expected: &str| {
        let found = match found {
            Node::Array(_) => "an array".to_string(),
            Node::Object(_) => "an object".to_string(),
            plain => format!("`{}`", Value::from(plain)),
        };
        let message = format!("`{key}` is {found}, expected {expected}");
        complaints.push(at_key(key, message));
    };
    match schema {
        Some(Node::Cell(Cell::Number(version))) if version.as_u64() == Some(1) => {}
        Some(other) => unexpected("schema", other, "1"),
        None => {}
    }
    let rows = match rows {
        Some(Node::Array(rows)) => rows,
        Some(other) => {
            unexpected("rows", other, "an array of rows");
            Vec::new()
        }
        None => Vec::new(),
    };
    if complaints.is_empty() {
        Ok(rows)
    } else {
        Err(complaints)
    }
}

fn raw_row(number: usize, row: Node<'_>) -> Result<RawRow<'_>, Vec<RowFlaw>> {
    let Node::Object(entries) = row else {
        let help = "a row is an object with the nine columns as keys";
        return Err(vec![RowFlaw::of_row(number, "not an object", help)]);
    };
    let (values, flaws) = by_key(entries, Column::ALL.map(Column::name));
    if !flaws.is_empty() {
        let flaw = |(key, message): (String, String)| {
            RowFlaw::of_cell(number, &key, message, help_for(&key))
        };
        return Err(flaws.into_iter().map(flaw).collect());
    }
    let cells = values.map(|value| match value {
        Some(Node::Cell(cell)) => cell,
        Some(other) => Cell::Other(other.into()),
        None => Cell::Empty,
    });
    Ok(RawRow { number, cells })
}

fn help_for(key: &str) -> String {
    match Column::from_name(key) {
        Some(_) => "each key stands once in each row, null where it is empty".to_string(),
        None => Column::help_for(key),
    }
}

/// Flaws of rows with their bytes: those of the key, or of the row. A row has no line of its own,
/// so each message begins with its number.
fn located(text: &str, flaws: Vec<RowFlaw>) -> Vec<Complaint> {
    let rows = elements(text);
    let complaint = |flaw: RowFlaw| {
        let row = rows.get(flaw.row).cloned().unwrap_or(0..1);
        let span = match &flaw.cell {
            Some(key) => place_of_key(text, row, key),
            None => row,
        };
        let message = format!("rows[{}]: {}", flaw.row, flaw.message);
        Complaint::new(span, message, flaw.help)
    };
    flaws.into_iter().map(complaint).collect()
}

/// Where a key of a row stands first; the beginning of the row if it does not.
fn place_of_key(text: &str, row: Range<usize>, key: &str) -> Range<usize> {
    let source = &text[row.clone()];
    let is_key = |inside: &Range<usize>| &source[inside.start + 1..inside.end - 1] == key;
    let inside = key_spans(source).into_iter().find(is_key).unwrap_or(0..1);
    row.start + inside.start..row.start + inside.end
}

/// Where a key stands first; the beginning of the text if it does not.
fn key_span(text: &str, key: &str) -> Range<usize> {
    let quoted = format!("\"{key}\"");
    let start = text.find(&quoted);
    start.map_or(0..1, |start| start..start + quoted.len())
}

/// Where the keys of an object stand, with their quotes, in one pass; its syntax was checked.
fn key_spans(object: &str) -> Vec<Range<usize>> {
    let mut spans = Vec::new();
    let (mut start, mut escaped) = (None, false);
    for (at, byte) in object.bytes().enumerate() {
        match (start, byte) {
            _ if escaped => escaped = false,
            (Some(_), b'\\') => escaped = true,
            (Some(from), b'"') => {
                if object[at + 1..].trim_start().starts_with(':') {
                    spans.push(from..at + 1);
                }
                start = None;
            }
            (None, b'"') => start = Some(at),
            _ => {}
        }
    }
    spans
}

/// The bytes of the elements of `rows`. It is the only array or object inside the outermost
/// object, as the keys were checked before; the syntax was, too.
fn elements(text: &str) -> Vec<Range<usize>> {
    let mut ranges = Vec::new();
    let (mut depth, mut start) = (0_usize, 0);
    let (mut in_string, mut escaped) = (false, false);
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            _ if escaped => escaped = false,
            b'\\' if in_string => escaped = true,
            b'"' => in_string = !in_string,
            _ if in_string => {}
            b'{' | b'[' => {
                depth += 1;
                if depth == 2 {
                    start = at + 1;
                }
            }
            b',' | b']' if depth == 2 => {
                ranges.push(trimmed(text, start..at));
                start = at + 1;
                depth -= usize::from(byte == b']');
            }
            b'}' | b']' => depth -= 1,
            _ => {}
        }
    }
    ranges.retain(|range| !range.is_empty());
    ranges
}
