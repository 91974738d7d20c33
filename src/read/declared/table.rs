//! A table while its lines are read, and what it has to hold in the end.

use crate::control::controller::{DeclaredFacts, Field, Order, ValueForm};
use crate::control::table::{ListedTable, Point, name};
use crate::quantity::rounded;
use crate::read::lexer::Complaint;
use crate::read::refusals;
use crate::text::shown;
use std::ops::Range;

/// Numbers of files lie below it.
const LARGEST: f64 = 1e9;

/// What a difference of two of them may be off by.
const DUST: f64 = 1e-6;

/// A number, and where it stands.
type Number = (f64, Range<usize>);

/// A point while its lines are read.
struct PointDraft {
    line: Range<usize>,
    number: Option<f64>,
    /// Position, value, forward, reverse.
    fields: Vec<(Field, Number)>,
}

impl PointDraft {
    fn of(&self, field: Field) -> Option<f64> {
        Some(self.fields.iter().find(|(own, _)| *own == field)?.1.0)
    }
}

/// Which table a line is about: by its name, its base and output axis, or both.
#[derive(Default)]
pub(super) struct Whose {
    pub(super) name: Option<String>,
    pub(super) axes: Option<[String; 2]>,
}

/// A table while its lines are read.
pub(super) struct TableDraft<'a> {
    facts: &'a DeclaredFacts,
    own: Whose,
    line: Range<usize>,
    /// Start, spacing, count, last.
    header: Vec<(Field, Number)>,
    rows: Vec<PointDraft>,
}

impl<'a> TableDraft<'a> {
    pub(super) fn new(facts: &'a DeclaredFacts, line: Range<usize>) -> TableDraft<'a> {
        TableDraft { facts, own: Whose::default(), line, header: Vec::new(), rows: Vec::new() }
    }

    /// Whether a line is about it: a name counts before axes.
    pub(super) fn is_of(&self, line: &Whose) -> bool {
        match (&line.name, &line.axes, &self.own.axes) {
            (Some(_), ..) => line.name == self.own.name,
            (None, Some(one), Some(own)) => is_same(one, own),
            _ => false,
        }
    }

    /// Takes the fields of a line that is about it, up to one point more than the control takes.
    pub(super) fn take(
        &mut self,
        text: &str,
        (line, whose): (&Range<usize>, Whose),
        fields: Vec<(Field, Range<usize>)>,
    ) -> Result<(), Complaint> {
        if let (Some(one), Some(own)) = (&whose.axes, &self.own.axes)
            && !is_same(one, own)
        {
            return Err(Complaint::new(line.clone(), refusals::second_pair()));
        }
        self.own.name = self.own.name.take().or(whose.name);
        self.own.axes = self.own.axes.take().or(whose.axes);
        let mut number = None;
        let mut of_point = Vec::new();
        for (field, span) in fields {
            let placed = (number_in(text, field, &span)?, span);
            match field {
                Field::Point => number = Some(placed.0),
                Field::Start | Field::Spacing | Field::Count | Field::Last => {
                    put(&mut self.header, field, placed)?;
                }
                _ => of_point.push((field, placed)),
            }
        }
        if of_point.is_empty() {
            return Ok(());
        }
        let most = self.facts.points.value as usize;
        let known = match most {
            1 => (!self.rows.is_empty()).then_some(0),
            _ => number.and_then(|_| self.rows.iter().rposition(|row| row.number == number)),
        };
        let at = known.unwrap_or(self.rows.len());
        if at > most {
            return Ok(()); // the point before it is refused in the end
        }
        if at == self.rows.len() {
            self.rows.push(PointDraft { line: line.clone(), number, fields: Vec::new() });
        }
        for (field, placed) in of_point {
            put(&mut self.rows[at].fields, field, placed)?;
        }
        Ok(())
    }

    fn head(&self, field: Field) -> Option<&Number> {
        self.header.iter().find(|(own, _)| *own == field).map(|(_, placed)| placed)
    }

    /// The table, once all lines are read.
    pub(super) fn table(self) -> Result<ListedTable, Complaint> {
        let Some([base, output]) = self.own.axes.clone() else {
            let name = self.own.name.as_deref().map_or(String::new(), shown);
            return Err(Complaint::new(self.line, refusals::table_of_nobody(name)));
        };
        let is_own = base.eq_ignore_ascii_case(&output);
        let what = name(&base, &output);
        self.check_size(is_own, &what)?;
        let mut points: Vec<Point> = Vec::new();
        for (index, row) in self.rows.iter().enumerate() {
            self.check_number(index, row, &what)?;
            let position = self.position(index, row)?;
            self.check_order(points.last().map(|last| last.position), position, row)?;
            points.push(point(self.facts.value_fields(is_own), position, row)?);
            let Point { forward, reverse, .. } = points[0];
            let first = if forward.abs() > 0.0 { forward } else { reverse.unwrap_or(0.0) };
            if self.facts.value_form.value == ValueForm::Increment && first.abs() > 0.0 {
                return Err(Complaint::new(
                    row.line.clone(),
                    refusals::first_increment(what, first),
                ));
            }
        }
        Ok(ListedTable { term: None, base, output, points })
    }

    /// As many points as the file and the control say.
    fn check_size(&self, is_own: bool, what: &str) -> Result<(), Complaint> {
        let facts = self.facts;
        let (rows, most) = (self.rows.len(), facts.points.value as usize);
        let wrong = |span: &Range<usize>, wrong| Err(Complaint::new(span.clone(), wrong));
        if !is_own && facts.cross_terms.value == 0 {
            return wrong(&self.line, refusals::no_cross_table(what));
        }
        if rows > most {
            return wrong(&self.rows[most].line, refusals::point_beyond(most));
        }
        if rows < most.min(2) {
            return wrong(&self.line, refusals::few_points(what, rows));
        }
        let last = facts.first_point.value as usize + rows - 1;
        // Beside positions a start and a spacing say the same once more.
        let place = |at: usize| self.rows.get(at)?.of(Field::Position);
        let spacing = place(1).zip(place(0)).map(|(second, first)| second - first);
        let counts = [(Field::Count, Some(rows as f64)), (Field::Last, Some(last as f64))];
        let places = [(Field::Start, place(0)), (Field::Spacing, spacing)];
        for (field, is) in counts.into_iter().chain(places) {
            let (Some((said, span)), Some(is)) = (self.head(field), is) else {
                continue;
            };
            if (said - is).abs() > DUST {
                return wrong(span, refusals::says_otherwise(said, is));
            }
        }
        Ok(())
    }

    /// The numbers of the points follow each other.
    fn check_number(&self, index: usize, row: &PointDraft, what: &str) -> Result<(), Complaint> {
        let expected = f64::from(self.facts.first_point.value) + index as f64;
        match row.number {
            None if self.rows[0].number.is_none() => Ok(()),
            Some(number) if (number - expected).abs() < 0.5 => Ok(()),
            _ => Err(Complaint::new(row.line.clone(), refusals::gap(expected, what))),
        }
    }

    /// Where a point lies, in the unit of the file.
    fn position(&self, index: usize, row: &PointDraft) -> Result<f64, Complaint> {
        let facts = self.facts;
        let missing =
            |field: &str| Complaint::new(row.line.clone(), refusals::point_without(field));
        match facts.is_spaced() {
            false => {
                let of_factor = facts.factors.as_ref().map(|_| 0.0);
                row.of(Field::Position).or(of_factor).ok_or_else(|| missing("position"))
            }
            true => {
                let head = |field| self.head(field).map(|placed| placed.0);
                let start = head(Field::Start).ok_or_else(|| missing("start"))?;
                let spacing = head(Field::Spacing).ok_or_else(|| missing("spacing"))?;
                Ok(rounded(start + index as f64 * spacing, facts.position_decimals.value))
            }
        }
    }

    /// Each point lies behind the one before.
    fn check_order(
        &self,
        before: Option<f64>,
        position: f64,
        row: &PointDraft,
    ) -> Result<(), Complaint> {
        let (is_behind, word) = match self.facts.order.value {
            Order::Ascending => (before.is_none_or(|before| position > before), "above"),
            Order::Descending => (before.is_none_or(|before| position < before), "below"),
        };
        match before {
            Some(before) if !is_behind => {
                Err(Complaint::new(row.line.clone(), refusals::other_order(position, word, before)))
            }
            _ => Ok(()),
        }
    }
}

fn is_same([base, output]: &[String; 2], [other_base, other_output]: &[String; 2]) -> bool {
    base.eq_ignore_ascii_case(other_base) && output.eq_ignore_ascii_case(other_output)
}

/// A point with the values that it has to have.
fn point(wanted: &[Field], position: f64, row: &PointDraft) -> Result<Point, Complaint> {
    let all = [Field::Value, Field::Forward, Field::Reverse];
    if let Some(field) = all.iter().find(|own| row.of(**own).is_some() != wanted.contains(own)) {
        let with = if row.of(*field).is_some() { "with" } else { "without" };
        return Err(Complaint::new(row.line.clone(), refusals::other_values(with, field.word())));
    }
    let mut values = wanted.iter().filter_map(|field| row.of(*field));
    Ok(Point { position, forward: values.next().unwrap_or_default(), reverse: values.next() })
}

/// Takes a field that was not there yet.
fn put(fields: &mut Vec<(Field, Number)>, field: Field, placed: Number) -> Result<(), Complaint> {
    if fields.iter().any(|(own, _)| *own == field) {
        return Err(Complaint::new(placed.1, refusals::second(field.word())));
    }
    fields.push((field, placed));
    Ok(())
}

/// The number of a field: digits with a decimal point.
fn number_in(text: &str, field: Field, span: &Range<usize>) -> Result<f64, Complaint> {
    let written = text[span.clone()].trim();
    let plain = |c: char| c.is_ascii_digit() || "+-.eE".contains(c);
    let number = written.parse::<f64>().ok();
    let number = number.filter(|number| written.chars().all(plain) && number.abs() < LARGEST);
    let whole = matches!(field, Field::Point | Field::Count | Field::Last);
    let number = number.filter(|number| !whole || number.fract().abs() <= 0.0);
    number.map(|number| number + 0.0).ok_or_else(|| {
        let kind = if whole { "a whole number" } else { "a number" };
        Complaint::new(span.clone(), refusals::other_kind(field.word(), shown(written), kind))
    })
}
