//! Reader of files as a profile declares them: each line by the first pattern that takes it.
//!
//! ```text
//!   line ─┬ blank, comment ──────────────────────────→ nothing
//!         ├ axis, base, output ──→ the pair of axes that the lines below are for
//!         ├ table ──→ the table of that name, until a line with base or output says of which pair it is
//!         ├ set ──→ lines of tables begin, of which the control loads one set
//!         ├ other, whole ──→ lines of something else begin
//!         ├ start, spacing, count, last ──→ of the table
//!         ├ unit ──→ has to be that of the profile
//!         └ point, position, value, forward, reverse ──→ a point of it
//! ```
//! With `point` the fields of one point may stand in several lines; without it each line is a point. A line that
//! no pattern takes is refused: what the control makes of it is not known.

mod table;

use self::table::{TableDraft, Whose};
use crate::control::control_state::ControlState;
use crate::control::controller::{
    Comments, DeclaredFacts, Factor, Field, Pattern, PointLists, Role, Said, Size,
};
use crate::control::table::{ListedTable, ListedTables, Tables};
use crate::read::emulate::{Emulated, Emulator};
use crate::read::family::{Family, ReadBack};
use crate::read::lexer::{Complaint, MOST_COMPLAINTS, lines, located};
use crate::read::{generic, listed, refusals};
use crate::text::{Problem, Problems, shown};
use std::ops::Range;

impl Family for DeclaredFacts {
    fn read_kit(&self, texts: &[(&str, &str)], _roles: &[Role]) -> Result<ReadBack, Problems> {
        Ok(Tables::Listed(tables(texts, self, false)?).into())
    }

    fn control(&self, tables: &Tables, state: &ControlState) -> Emulated<Box<dyn Emulator>> {
        let tables: &ListedTables = tables.own();
        Ok(Box::new(match self.factors.is_some() {
            true => listed::control(&acting(tables), self, state)?,
            false => listed::control(tables, self, state)?,
        }))
    }

    fn may_obey(&self, text: &str) -> bool {
        if self.typed.is_some() {
            return text.contains("position_mm");
        }
        let patterns: Vec<_> = self.lines.value.iter().filter(|own| own.has_fields()).collect();
        let is_taken = |line: &str| patterns.iter().any(|own| own.take(line).is_some());
        lines(text).any(|span| is_taken(&text[span]))
    }

    /// One with a line that only such a file has.
    fn is_whole(&self, text: &str) -> bool {
        let says = |line: &str| self.lines.value.iter().find(|own| own.take(line).is_some());
        let is_whole = |own: &Pattern| own.fields().any(|field| field == Field::Whole);
        self.has(Field::Whole) && lines(text).any(|span| says(&text[span]).is_some_and(is_whole))
    }
}

impl DeclaredFacts {
    fn is_comment(&self, line: &str) -> bool {
        let Comments::From(sign) = &self.comments.value else { return false };
        line.trim_start().starts_with(sign.as_str())
    }
}

/// Reads files of a control, names and texts in any order; of typed lists, as they were asked for or as the control shows them.
pub(crate) fn tables(
    texts: &[(&str, &str)],
    facts: &DeclaredFacts,
    as_shown: bool,
) -> Result<ListedTables, Problems> {
    match &facts.typed {
        Some(typed) => {
            let held = typed.is_held().then(|| typed.column());
            generic::tables(texts, held.as_deref(), as_shown)
        }
        None => read(texts, facts),
    }
}

/// The same of files with lines of the profile; no two of them hold a table for the same axes.
fn read(texts: &[(&str, &str)], facts: &DeclaredFacts) -> Result<ListedTables, Problems> {
    let mut problems = Problems::none();
    let (mut all, mut set) = (Vec::<ListedTable>::new(), None);
    for (name, text) in texts {
        let own = problems.take(file(name, text, facts, set.as_deref())).unwrap_or_default();
        set = set.or(own.set);
        for table in own.tables {
            if all.iter().any(|own| own.is_for(&table.base, &table.output)) {
                problems.push(refusals::another(shown(name), facts.table_name(&table)));
            }
            all.push(table);
        }
    }
    let is_whole = || texts.iter().any(|(_, text)| facts.is_whole(text));
    if problems.is_empty() && all.is_empty() && !is_whole() {
        problems.push(refusals::no_value_at_all());
    }
    problems.or_ok(ListedTables { set, ..ListedTables::of(all) })
}

/// The tables of one file, beside the set of a file before it. What they lack is told once every line was understood.
fn file(
    name: &str,
    text: &str,
    facts: &DeclaredFacts,
    set_before: Option<&str>,
) -> Result<ListedTables, Problems> {
    let mut reading = Reading {
        facts,
        axes: Axes::of_name(name, facts),
        name: Axes::of_name(name, facts),
        set: None,
        set_before,
        is_other: facts.has(Field::Set),
        drafts: Vec::new(),
        complaints: Vec::new(),
    };
    for span in lines(text) {
        reading.line(text, span);
        if reading.complaints.len() >= MOST_COMPLAINTS {
            break;
        }
    }
    if !reading.complaints.is_empty() {
        return Err(located(name, text, reading.complaints));
    }
    let mut tables = Vec::new();
    for draft in std::mem::take(&mut reading.drafts) {
        match draft.table() {
            Ok(table) => tables.push(table),
            Err(complaint) => reading.complaints.push(complaint),
        }
    }
    let set = reading.set.take();
    let is_lost = |own: &&Factor| {
        let [base, output] = own.axes();
        set.is_some() && !tables.iter().any(|table| table.is_for(base, output))
    };
    for lost in facts.factors().iter().filter(is_lost) {
        let span = set.as_ref().map_or(0..0, |(_, span)| span.clone());
        reading.complaints.push(Complaint::new(span, refusals::set_without(&lost.name)));
    }
    let set = set.map(|(name, _)| name);
    match reading.complaints.is_empty() {
        true => Ok(ListedTables { tables, set }),
        false => Err(located(name, text, reading.complaints)),
    }
}

/// Factors as they act, without those that are 0: a set holds all, also of an axis that the machine does not have.
///
/// limits  to first order. A control that lets X follow the corrected Y takes back what the lean of X makes of the
///         correction of Y, for the machine leans with its motors: the product of two factors moves nothing that leans so
fn acting(tables: &ListedTables) -> ListedTables {
    let acts = |table: &&ListedTable| !table.is_zero();
    ListedTables::of(tables.tables.iter().filter(acts).cloned().collect())
}

/// The axes that the lines are for.
#[derive(Clone, Default)]
struct Axes {
    base: Option<String>,
    output: Option<String>,
}

impl Axes {
    /// What the name of a file says.
    fn of_name(name: &str, facts: &DeclaredFacts) -> Axes {
        let name = name.rsplit(['/', '\\']).next().unwrap_or(name);
        let mut axes = Axes::default();
        let found = facts.file_name.value.iter().find_map(|own| own.take(name));
        for (field, span) in found.into_iter().flatten().flatten() {
            axes.set(field, &name[span]);
        }
        axes
    }

    /// Takes the name of an axis; a line for another axis leaves nothing of the lines before.
    fn set(&mut self, field: Field, name: &str) {
        let name = Some(name.to_string());
        match field {
            Field::Axis => *self = Axes { base: name.clone(), output: name },
            Field::Base => self.base = name,
            Field::Output => self.output = name,
            _ => {}
        }
    }

    fn pair(&self) -> Option<[String; 2]> {
        Some([self.base.clone()?, self.output.clone()?])
    }
}

/// Whether a text is a number that a factor can be.
fn is_factor(text: &str) -> bool {
    text.parse().is_ok_and(|factor: f64| factor.abs() < 1.0)
}

/// Whether a line of this pattern names the unit.
fn names_unit(pattern: &Pattern) -> bool {
    pattern.fields().any(|field| field == Field::Unit)
}

/// A file while it is read.
struct Reading<'a> {
    facts: &'a DeclaredFacts,
    axes: Axes,
    /// What the name of the file says.
    name: Axes,
    /// The set of tables that has begun, and where it says its name.
    set: Option<(String, Range<usize>)>,
    set_before: Option<&'a str>,
    /// Whether the lines are of something else.
    is_other: bool,
    drafts: Vec<TableDraft<'a>>,
    complaints: Vec<Complaint>,
}

impl Reading<'_> {
    fn complain(&mut self, span: Range<usize>, wrong: Problem) {
        self.complaints.push(Complaint::new(span, wrong));
    }

    fn line(&mut self, text: &str, span: Range<usize>) {
        let line = &text[span.clone()];
        let is_comment = self.facts.is_comment(line);
        if line.trim().is_empty() {
            return;
        }
        let patterns = self.facts.lines.value.iter();
        let mut patterns = patterns.filter(|own| !is_comment || names_unit(own));
        let Some(found) = patterns.find_map(|own| own.take(line)) else {
            if self.is_other {
                return;
            }
            if is_comment {
                return self.check_comment(line, span);
            }
            return self.complain(span, refusals::no_pattern());
        };
        for said in found {
            self.say(text, &span, said);
        }
    }

    /// Takes what a line says of one table.
    fn say(&mut self, text: &str, line: &Range<usize>, said: Said) {
        if self.is_other && !said.iter().any(|(field, _)| *field == Field::Set) {
            return;
        }
        let (mut name, mut fields, mut names_axes) = (None, Vec::new(), false);
        for (field, part) in said {
            let part = line.start + part.start..line.start + part.end;
            match field {
                Field::Axis | Field::Base | Field::Output => {
                    names_axes = true;
                    self.axes.set(field, text[part.clone()].trim());
                    self.check_name(part);
                }
                Field::Same => self.check_same(text, part),
                Field::Table => name = Some(text[part].to_string()),
                Field::Unit => self.check_unit(text, part),
                Field::Other | Field::Whole => self.is_other = true,
                Field::Set => self.begin(text[part.clone()].trim(), part),
                Field::Value if self.facts.factors.is_some() && !is_factor(&text[part.clone()]) => {
                    self.complain(part.clone(), refusals::no_factor(shown(&text[part])));
                }
                _ => fields.push((field, part)),
            }
        }
        if fields.is_empty() && name.is_none() {
            return;
        }
        let axes = match &name {
            Some(name) if !names_axes => self.facts.axes_of(name),
            _ => self.axes.pair(),
        };
        if name.is_none() && axes.is_none() {
            return self.complain(line.clone(), refusals::value_of_nobody());
        }
        let own = Whose { name, axes };
        let at = self.drafts.iter().position(|draft| draft.is_of(&own));
        let at = at.unwrap_or(self.drafts.len());
        if at == self.drafts.len() {
            self.drafts.push(TableDraft::new(self.facts, line.clone()));
        }
        self.complaints.extend(self.drafts[at].take(text, (line, own), fields).err());
    }

    /// A set of tables begins.
    fn begin(&mut self, name: &str, span: Range<usize>) {
        let first = self.set.as_ref().map(|(own, _)| own.as_str()).or(self.set_before);
        self.is_other = first.is_some();
        match first {
            None => self.set = Some((name.to_string(), span)),
            Some(own) => {
                let wrong = refusals::second_set(shown(own));
                self.complain(span, wrong);
            }
        }
    }

    /// A comment that names a unit says it as the profile does: one that begins with the word, or holds it beside a size.
    fn check_comment(&mut self, line: &str, span: Range<usize>) {
        let has_unit = self.facts.lines.value.iter().any(names_unit);
        let words = line.split(|c: char| !c.is_alphanumeric());
        let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
        let is_unit = |word: &&str| word.eq_ignore_ascii_case("unit");
        let begins = words.first().is_some_and(is_unit);
        let has_size = words.iter().any(|word| Size::of_word(word).is_some());
        if has_unit && (begins || has_size && words.iter().any(is_unit)) {
            self.complain(span, refusals::unit_in_comment());
        }
    }

    /// A line that names the corrected axis twice means one.
    fn check_same(&mut self, text: &str, span: Range<usize>) {
        let own = self.axes.output.clone().unwrap_or_default();
        if !own.eq_ignore_ascii_case(text[span.clone()].trim()) {
            self.complain(span, refusals::another_axis(shown(&own)));
        }
    }

    /// The corrected axis is that of the name of the file, where it says one.
    fn check_name(&mut self, span: Range<usize>) {
        if let [Some(own), Some(named)] = [&self.axes.output, &self.name.output]
            && !own.eq_ignore_ascii_case(named)
        {
            self.complain(span, refusals::other_than_name(shown(named)));
        }
    }

    /// The unit that a file names is that of the profile.
    fn check_unit(&mut self, text: &str, span: Range<usize>) {
        let word = text[span.clone()].trim();
        if Size::of_word(word) != Some(self.facts.value_size.value) {
            self.complain(span, refusals::another_unit(shown(word)));
        }
    }
}

#[cfg(test)]
mod tests;
