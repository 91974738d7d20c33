//! The JSON form: `{"schema":1,"rows":[{…}, …]}`.
//!
//! serde_json forgets where a value stood and lets the last of two equal keys win. So the file is
//! parsed twice: whole, for its syntax, and row by row from the bytes of each row.

use super::check::Reading;
use super::csv::trimmed;
use super::row::{Cell, Column, Complaint, RawRow};
use crate::table::generic::GenericTable;
use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde_json::Value;
use std::fmt;
use std::ops::Range;

const SHAPE: &str = "expected {\"schema\":1,\"rows\":[…]}";

pub(super) fn read(text: &str) -> Result<GenericTable, Vec<Complaint>> {
    if text.trim().is_empty() {
        let message = "the file is empty, expected a generic table";
        return Err(vec![Complaint::new(0..0, message, SHAPE)]);
    }
    let top: Entries = serde_json::from_str(text).map_err(|flaw| vec![syntax(text, &flaw)])?;
    let complaints = top_flaws(text, &top);
    if !complaints.is_empty() {
        return Err(complaints);
    }
    let mut reading = Reading::default();
    let rows = elements(text);
    if rows.is_empty() {
        let help = "each row is one point";
        let message = "the table has no rows";
        reading.complain(Complaint::new(key_span(text, "rows"), message, help));
    }
    for (number, span) in rows.into_iter().enumerate() {
        if reading.is_full() {
            break;
        }
        match raw_row(text, number, span) {
            Ok(raw) => reading.take(raw),
            Err(complaints) => complaints.into_iter().for_each(|c| reading.lose_row(c)),
        }
    }
    reading.finish()
}

/// Keys and values of an object, in file order, equal keys included.
struct Entries(Vec<(String, Value)>);

impl Entries {
    fn get(&self, name: &str) -> Option<&Value> {
        let found = self.0.iter().find(|(key, _)| key == name);
        found.map(|(_, value)| value)
    }

    /// Unknown, repeated and missing keys, in words, each with the key.
    fn key_flaws(&self, known: &[&'static str]) -> Vec<(&str, String)> {
        let mut flaws = Vec::new();
        for (index, (key, _)) in self.0.iter().enumerate() {
            if !known.contains(&key.as_str()) {
                flaws.push((key.as_str(), format!("unknown key `{key}`")));
            } else if self.0[..index].iter().any(|(before, _)| before == key) {
                flaws.push((key.as_str(), format!("key `{key}` stands there twice")));
            }
        }
        let missing = known.iter().filter(|key| self.get(key).is_none());
        flaws.extend(missing.map(|key| (*key, format!("key `{key}` is missing"))));
        flaws
    }
}

impl<'de> Deserialize<'de> for Entries {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Entries, D::Error> {
        struct InOrder;
        impl<'de> Visitor<'de> for InOrder {
            type Value = Entries;
            fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
                out.write_str("an object")
            }
            fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Entries, M::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                Ok(Entries(entries))
            }
        }
        input.deserialize_map(InOrder)
    }
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

fn top_flaws(text: &str, top: &Entries) -> Vec<Complaint> {
    let keys = top.key_flaws(&["schema", "rows"]).into_iter();
    let mut complaints: Vec<Complaint> = keys
        .map(|(key, message)| Complaint::new(key_span(text, key), message, SHAPE))
        .collect();
    let mut expect = |key: &str, fits: fn(&Value) -> bool, expected: &str| {
        if let Some(value) = top.get(key).filter(|value| !fits(value)) {
            let found = match value {
                Value::Array(_) => "an array".to_string(),
                Value::Object(_) => "an object".to_string(),
                plain => format!("`{plain}`"),
            };
            let message = format!("`{key}` is {found}, expected {expected}");
            complaints.push(Complaint::new(key_span(text, key), message, SHAPE));
        }
    };
    expect("schema", |value| value.as_u64() == Some(1), "1");
    expect("rows", Value::is_array, "an array of rows");
    complaints
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

fn raw_row(text: &str, number: usize, span: Range<usize>) -> Result<RawRow, Vec<Complaint>> {
    let source = &text[span.clone()];
    let label = format!("rows[{number}]: ");
    let Ok(entries) = serde_json::from_str::<Entries>(source) else {
        let help = "a row is an object with the nine columns as keys";
        let message = format!("{label}not an object");
        return Err(vec![Complaint::new(span, message, help)]);
    };
    let keys = key_spans(source);
    let place = |key: &str| {
        let is_key = |inside: &&Range<usize>| &source[inside.start + 1..inside.end - 1] == key;
        let inside = keys.iter().find(is_key).cloned().unwrap_or(0..1);
        span.start + inside.start..span.start + inside.end
    };
    let flaws = entries.key_flaws(&Column::ALL.map(Column::name));
    if !flaws.is_empty() {
        let complaint = |(key, message): (&str, String)| {
            Complaint::new(place(key), format!("{label}{message}"), help_for(key))
        };
        return Err(flaws.into_iter().map(complaint).collect());
    }
    let cells = Column::ALL.map(|column| Cell {
        value: entries.get(column.name()).cloned().unwrap_or(Value::Null),
        span: place(column.name()),
    });
    Ok(RawRow { label, span, cells })
}

fn help_for(key: &str) -> String {
    match Column::from_name(key) {
        Some(_) => "each key stands once in each row, null where it is empty".to_string(),
        None => Column::help_for(key),
    }
}
