//! The JSON form: `{"schema":1,"rows":[{…}, …]}`.
//!
//! serde_json lets the last of two equal keys win, so the text is read into [`Node`]s, which keep
//! both. It forgets where a value stood, too; the places of complaints are looked up in the text.

use super::check::Reading;
use super::csv::trimmed;
use super::row::{Cell, Column, RawRow, RowFlaw};
use crate::control::table::generic::GenericTable;
use crate::read::lexer::Complaint;
use crate::text::document::MOST_ROWS;
use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::{Number, Value};
use std::borrow::Cow;
use std::fmt;
use std::ops::Range;

const SHAPE: &str = "expected {\"schema\":1,\"rows\":[…]}";
/// What is said of the keys of one object; a file of another kind may have a million.
const MOST_KEYS_SAID: usize = 20;

pub(super) fn read(text: &str) -> Result<GenericTable, Vec<Complaint>> {
    if text.trim().is_empty() {
        let message = "the file is empty, expected a generic table";
        return Err(vec![Complaint::new(0..0, message, SHAPE)]);
    }
    let mut input = serde_json::Deserializer::from_str(text);
    let whole = WholeFile::default().deserialize(&mut input);
    let whole = whole.and_then(|found| input.end().map(|()| found));
    let found = whole.map_err(|flaw| vec![syntax(text, &flaw)])?;
    let reading = found.rows(text)?;
    reading.finish().map_err(|flaws| located(text, flaws))
}

#[derive(serde::Deserialize)]
struct Key<'a>(#[serde(borrow)] Cow<'a, str>);

/// A value that is no row and no list of rows: a cell of a row, or something unexpected. What stands in
/// arrays and objects is passed over.
enum Found<'a> {
    Cell(Cell<'a>),
    Array,
    Object,
}

impl Found<'_> {
    fn words(&self) -> String {
        match self {
            Found::Array => "an array".to_string(),
            Found::Object => "an object".to_string(),
            Found::Cell(Cell::Empty) => "`null`".to_string(),
            Found::Cell(Cell::Text(text)) => format!("`{}`", Value::from(&**text)),
            Found::Cell(Cell::Number(number)) => format!("`{number}`"),
            Found::Cell(Cell::Other(words)) => words.clone(),
        }
    }
}

/// What is made of one value, whatever stands there. What nobody asks for is passed over, not kept.
trait Taker<'a>: Sized {
    type Taken;
    /// Of a value that is neither array nor object.
    fn cell(self, cell: Cell<'a>) -> Self::Taken;
    fn array<S: SeqAccess<'a>>(self, elements: S) -> Result<Self::Taken, S::Error>;
    fn object<M: MapAccess<'a>>(self, entries: M) -> Result<Self::Taken, M::Error>;
}

/// Gives a value to its taker.
struct To<T>(T);

impl<'a, T: Taker<'a>> DeserializeSeed<'a> for To<T> {
    type Value = T::Taken;
    fn deserialize<D: Deserializer<'a>>(self, input: D) -> Result<T::Taken, D::Error> {
        input.deserialize_any(self)
    }
}

impl<'a, T: Taker<'a>> Visitor<'a> for To<T> {
    type Value = T::Taken;
    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("any valid JSON value")
    }
    fn visit_unit<E>(self) -> Result<T::Taken, E> {
        Ok(self.0.cell(Cell::Empty))
    }
    fn visit_bool<E>(self, value: bool) -> Result<T::Taken, E> {
        Ok(self.0.cell(Cell::Other(format!("`{value}`"))))
    }
    fn visit_u64<E>(self, value: u64) -> Result<T::Taken, E> {
        Ok(self.0.cell(Cell::Number(value.into())))
    }
    fn visit_i64<E>(self, value: i64) -> Result<T::Taken, E> {
        Ok(self.0.cell(Cell::Number(value.into())))
    }
    fn visit_f64<E>(self, value: f64) -> Result<T::Taken, E> {
        let number = Number::from_f64(value);
        Ok(self.0.cell(number.map_or(Cell::Empty, Cell::Number)))
    }
    fn visit_borrowed_str<E>(self, text: &'a str) -> Result<T::Taken, E> {
        Ok(self.0.cell(Cell::Text(text.into())))
    }
    fn visit_str<E>(self, text: &str) -> Result<T::Taken, E> {
        Ok(self.0.cell(Cell::Text(text.to_string().into())))
    }
    fn visit_seq<S: SeqAccess<'a>>(self, elements: S) -> Result<T::Taken, S::Error> {
        self.0.array(elements)
    }
    fn visit_map<M: MapAccess<'a>>(self, entries: M) -> Result<T::Taken, M::Error> {
        self.0.object(entries)
    }
}

/// Any value, for its cell or its kind.
struct AnyValue;

impl<'a> Taker<'a> for AnyValue {
    type Taken = Found<'a>;
    fn cell(self, cell: Cell<'a>) -> Found<'a> {
        Found::Cell(cell)
    }
    fn array<S: SeqAccess<'a>>(self, mut elements: S) -> Result<Found<'a>, S::Error> {
        while elements.next_element::<IgnoredAny>()?.is_some() {}
        Ok(Found::Array)
    }
    fn object<M: MapAccess<'a>>(self, mut entries: M) -> Result<Found<'a>, M::Error> {
        while entries.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(Found::Object)
    }
}

/// What is wrong with the keys of an object: in words, each with its key.
#[derive(Default)]
struct KeyFlaws(Vec<(String, String)>);

impl KeyFlaws {
    fn add(&mut self, key: &str, what: String) {
        if self.0.len() < MOST_KEYS_SAID {
            self.0.push((key.to_string(), what));
        }
    }

    fn unknown(&mut self, key: &str) {
        self.add(key, format!("unknown key `{key}`"));
    }

    fn twice(&mut self, key: &str) {
        self.add(key, format!("key `{key}` stands there twice"));
    }

    fn missing(&mut self, key: &str) {
        self.add(key, format!("key `{key}` is missing"));
    }
}

/// What the file holds: its rows are read one by one as they come, and none is kept as it stands.
#[derive(Default)]
struct WholeFile<'a> {
    schema: Option<Found<'a>>,
    rows: Option<Result<Reading<'a>, Found<'a>>>,
    is_empty: bool,
    flaws: KeyFlaws,
}

impl<'a> WholeFile<'a> {
    /// The rows that were read, if nothing else is wrong.
    fn rows(mut self, text: &str) -> Result<Reading<'a>, Vec<Complaint>> {
        let at_key = |key: &str, message| Complaint::new(key_span(text, key), message, SHAPE);
        if self.schema.is_none() {
            self.flaws.missing("schema");
        }
        if self.rows.is_none() {
            self.flaws.missing("rows");
        }
        let flaws = self.flaws.0.into_iter();
        let mut complaints: Vec<Complaint> =
            flaws.map(|(key, message)| at_key(&key, message)).collect();
        let unexpected = |key: &str, found: &Found<'_>, expected: &str| {
            let message = format!("`{key}` is {}, expected {expected}", found.words());
            at_key(key, message)
        };
        match &self.schema {
            Some(Found::Cell(Cell::Number(version))) if version.as_u64() == Some(1) => {}
            Some(other) => complaints.push(unexpected("schema", other, "1")),
            None => {}
        }
        match self.rows {
            Some(Err(other)) => complaints.push(unexpected("rows", &other, "an array of rows")),
            Some(Ok(reading)) if complaints.is_empty() && !self.is_empty => return Ok(reading),
            Some(Ok(_)) if complaints.is_empty() => {
                let help = "each row is one point";
                let message = "the table has no rows";
                complaints.push(Complaint::new(key_span(text, "rows"), message, help));
            }
            _ => {}
        }
        Err(complaints)
    }
}

impl<'a> DeserializeSeed<'a> for WholeFile<'a> {
    type Value = WholeFile<'a>;
    fn deserialize<D: Deserializer<'a>>(self, input: D) -> Result<WholeFile<'a>, D::Error> {
        input.deserialize_map(self)
    }
}

impl<'a> Visitor<'a> for WholeFile<'a> {
    type Value = WholeFile<'a>;
    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("an object")
    }
    fn visit_map<M: MapAccess<'a>>(mut self, mut map: M) -> Result<WholeFile<'a>, M::Error> {
        while let Some(Key(key)) = map.next_key()? {
            match &*key {
                "schema" if self.schema.is_none() => {
                    self.schema = Some(map.next_value_seed(To(AnyValue))?)
                }
                "rows" if self.rows.is_none() => {
                    let mut rows = Rows::default();
                    let other = map.next_value_seed(To(&mut rows))?;
                    self.is_empty = rows.number == 0;
                    self.rows = Some(match other {
                        None => Ok(rows.reading),
                        Some(other) => Err(other),
                    });
                }
                known => {
                    match known {
                        "schema" | "rows" => self.flaws.twice(known),
                        _ => self.flaws.unknown(known),
                    }
                    map.next_value::<IgnoredAny>()?;
                }
            }
        }
        Ok(self)
    }
}

/// The elements of `rows`, taken one by one; gives what stands there instead of an array.
#[derive(Default)]
struct Rows<'a> {
    reading: Reading<'a>,
    number: usize,
}

impl<'a> Taker<'a> for &mut Rows<'a> {
    type Taken = Option<Found<'a>>;
    fn cell(self, cell: Cell<'a>) -> Self::Taken {
        Some(Found::Cell(cell))
    }
    fn array<S: SeqAccess<'a>>(self, mut elements: S) -> Result<Self::Taken, S::Error> {
        while let Some(row) = elements.next_element_seed(To(Row::new(self.number)))? {
            self.number += 1;
            if self.number > MOST_ROWS {
                return Err(S::Error::custom(super::check::too_many_rows(0..1).message));
            }
            if self.reading.is_full() {
                continue;
            }
            match row.finish() {
                Ok(raw) => self.reading.take(&raw),
                Err(flaws) => self.reading.lose_row(flaws),
            }
        }
        Ok(None)
    }
    fn object<M: MapAccess<'a>>(self, entries: M) -> Result<Self::Taken, M::Error> {
        AnyValue.object(entries).map(Some)
    }
}

/// One row as it is read: the first value of each column, and what is wrong with its keys.
struct Row<'a> {
    number: usize,
    cells: [Option<Cell<'a>>; 9],
    flaws: KeyFlaws,
    is_object: bool,
}

impl<'a> Row<'a> {
    fn new(number: usize) -> Row<'a> {
        Row {
            number,
            cells: [const { None }; 9],
            flaws: KeyFlaws::default(),
            is_object: false,
        }
    }

    fn finish(mut self) -> Result<RawRow<'a>, Vec<RowFlaw>> {
        let number = self.number;
        if !self.is_object {
            let help = "a row is an object with the nine columns as keys";
            return Err(vec![RowFlaw::of_row(number, "not an object", help)]);
        }
        let missing = Column::ALL.into_iter().zip(&self.cells);
        for (column, _) in missing.filter(|(_, cell)| cell.is_none()) {
            self.flaws.missing(column.name());
        }
        if !self.flaws.0.is_empty() {
            let flaw = |(key, message): (String, String)| {
                RowFlaw::of_cell(number, &key, message, help_for(&key))
            };
            return Err(self.flaws.0.into_iter().map(flaw).collect());
        }
        let cells = self.cells.map(|cell| cell.unwrap_or(Cell::Empty));
        Ok(RawRow { number, cells })
    }
}

impl<'a> Taker<'a> for Row<'a> {
    type Taken = Row<'a>;
    fn cell(self, _: Cell<'a>) -> Row<'a> {
        self
    }
    fn array<S: SeqAccess<'a>>(self, elements: S) -> Result<Row<'a>, S::Error> {
        AnyValue.array(elements).map(|_| self)
    }
    fn object<M: MapAccess<'a>>(mut self, mut entries: M) -> Result<Row<'a>, M::Error> {
        self.is_object = true;
        while let Some(Key(key)) = entries.next_key()? {
            let column = Column::from_name(&key);
            match column.map(|column| &mut self.cells[column as usize]) {
                Some(cell) if cell.is_none() => {
                    *cell = Some(match entries.next_value_seed(To(AnyValue))? {
                        Found::Cell(cell) => cell,
                        other => Cell::Other(other.words()),
                    });
                    continue;
                }
                Some(_) => self.flaws.twice(&key),
                None => self.flaws.unknown(&key),
            }
            entries.next_value::<IgnoredAny>()?;
        }
        Ok(self)
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
