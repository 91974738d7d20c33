//! A fact of a control, how sure it is, and how it is read from its page.

use crate::control::refusals;
use crate::quantity::{Correction, Deviation};
use crate::text::{Section, Word, words};
use serde::Serialize;
use std::cell::{Cell, RefCell};
use std::ops::RangeBounds;

words! {
    /// How well a fact is known.
    pub enum Evidence {
        /// Read in a manual of the maker, or in data that a real control wrote.
        Manual = "manual",
        /// Taken from memory, inference or a weaker source; a control may differ.
        Assumed = "assumed",
        /// Seen on a real control that executed our file.
        Executed = "executed",
    }
}

impl Evidence {
    /// How well the sense of a table is known, as a line for the person who loads the file.
    pub(crate) const fn of_sense(self) -> &'static str {
        match self {
            Evidence::Manual => "sense of the values as in the manual",
            Evidence::Executed => "sense of the values as seen on a control",
            Evidence::Assumed => {
                "sense of the values ASSUMED: prove it with one small bump before use"
            }
        }
    }
}

words! {
    /// What the numbers in a control's table mean: the machine's error, or what the control adds.
    #[derive(clap::ValueEnum)]
    pub enum TableSign {
        /// The table holds the deviation; a positive value makes the axis move in −.
        AsError = "as_error",
        /// The table holds the correction; a positive value makes the axis move in +.
        AsCorrection = "as_correction",
    }
}

impl TableSign {
    /// What the numbers of a table mean, in words.
    pub(crate) const fn words(self) -> &'static str {
        match self {
            TableSign::AsError => "error (measured - nominal)",
            TableSign::AsCorrection => "correction (added to the command)",
        }
    }

    /// The number (µm) that a table of this sense holds for a deviation.
    pub(crate) fn table_um(self, deviation: Deviation) -> f64 {
        match self {
            TableSign::AsError => deviation.um(),
            TableSign::AsCorrection => (-deviation).um(),
        }
    }

    /// The other sense.
    pub(crate) const fn turned(self) -> TableSign {
        match self {
            TableSign::AsError => TableSign::AsCorrection,
            TableSign::AsCorrection => TableSign::AsError,
        }
    }

    /// What the control adds when its table holds `um` micrometres.
    pub fn correction(self, um: f64) -> Correction {
        match self {
            TableSign::AsError => -Deviation::from_um(um),
            TableSign::AsCorrection => Correction::from_um(um),
        }
    }
}

words! {
    /// In which form tables are delivered (docs/siemens.md §3.2).
    pub enum TableForm {
        /// Part program without header, ends with `M30`.
        Program = "program",
        /// NC active data: `%_N_…_INI`, `CHANDATA(1)`, ends with `M17`.
        Data = "data",
    }
}

words! {
    /// What of a control a fact belongs to: it matters for a kit only where the kit uses that.
    pub enum Mechanism {
        /// Siemens: measuring-system error compensation.
        EncComp = "enc-comp",
        /// Siemens: cross-error compensation.
        Cec = "cec",
        /// Siemens: CEC tables that multiply each other.
        CecProducts = "cec-products",
        /// Fanuc: stored pitch error compensation.
        Pitch = "pitch",
        /// Fanuc: pitch tables of their own for travel in −.
        Bidirectional = "bidirectional",
        /// Fanuc: straightness compensation of either form.
        Straightness = "straightness",
        /// Fanuc: straightness through four points.
        FourPoint = "four-point",
        /// Fanuc: straightness with one increment for each point.
        PerPoint = "per-point",
        /// LinuxCNC: the table of a joint.
        Comp = "comp",
        /// LinuxCNC: the HAL file for cross terms.
        Hal = "hal",
        /// Declared: the table of an axis for itself.
        OwnTable = "own-table",
        /// Declared: the table of an axis that follows another.
        CrossTable = "cross-table",
        /// ISG: volumetric compensation.
        Volcomp = "volcomp",
        /// ISG: its angles.
        VolcompAngles = "volcomp-angles",
        /// Declared: factors, one for the slope of a term.
        Skew = "skew",
        /// Basic system mm.
        Metric = "metric",
        /// Basic system inch.
        Inch = "inch",
        /// Nothing: a wrong value has no consequence.
        Nothing = "none",
    }
}

impl Mechanism {
    /// Why a fact has no effect on a kit that does not use what it belongs to.
    pub(crate) const fn not_used(self) -> &'static str {
        match self {
            Mechanism::EncComp => "this kit holds no ENC_COMP table",
            Mechanism::Cec => "this kit holds no CEC table",
            Mechanism::CecProducts => "this kit holds no product of CEC tables",
            Mechanism::Pitch => "this kit holds no pitch points",
            Mechanism::Bidirectional => "this kit holds one table for both directions",
            Mechanism::Straightness => "this kit holds no straightness table",
            Mechanism::FourPoint => "this kit holds no four-point straightness",
            Mechanism::PerPoint => "this kit holds no 128-point straightness",
            Mechanism::Comp => "this kit holds no table of a joint",
            Mechanism::Hal => "this kit holds no HAL file",
            Mechanism::OwnTable => "this kit holds no table of an axis for itself",
            Mechanism::CrossTable => "this kit holds no table that follows another axis",
            Mechanism::Volcomp => "this kit holds no volumetric compensation",
            Mechanism::VolcompAngles => "this kit holds no angles",
            Mechanism::Skew => "this kit holds no skew correction",
            Mechanism::Metric => "this kit is in inch",
            Mechanism::Inch => "this kit is in mm",
            Mechanism::Nothing => "a wrong value has no consequence",
        }
    }
}

words! {
    /// What a control adds outside a table.
    pub enum Outside {
        /// The value at the end.
        Hold = "hold",
        /// Nothing.
        Zero = "zero",
        /// Not known: tables have to cover the travel.
        Unknown = "unknown",
    }
}

impl Outside {
    /// Why a table may not end inside the travel where the end value is not held.
    pub(crate) const fn why(self) -> &'static str {
        match self {
            Outside::Hold => "the value at its end is held",
            Outside::Zero => {
                "this control adds nothing outside a table: the correction would jump at its end"
            }
            Outside::Unknown => "what this control adds outside a table is not known",
        }
    }
}

/// Whether the files of a control may carry comments.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Comments {
    /// No.
    None,
    /// Yes, in the form that the reader of its family knows.
    OfFamily,
    /// Lines that begin with this sign.
    From(String),
}

impl Comments {
    /// Whether there are any.
    pub(crate) fn are_allowed(&self) -> bool {
        *self != Comments::None
    }
}

impl FactValue for Comments {
    fn read(fact: &Section<'_>) -> Option<Self> {
        match fact.as_written("value") {
            Some("true") => fact.flag("value").map(|_| Comments::OfFamily),
            Some("false") => fact.flag("value").map(|_| Comments::None),
            _ => fact.text("value").map(Comments::From),
        }
    }
}

/// A statement about a control, with its origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Fact<T> {
    /// What is stated.
    pub value: T,
    /// How well it is known.
    pub evidence: Evidence,
    /// Manual, edition, chapter; or why it is assumed.
    pub source: String,
    /// What happens on the machine if it is wrong (required for assumed facts).
    pub consequence: Option<String>,
}

words! {
    /// Basic system of the control: the unit of positions (and Siemens values) in its files.
    pub enum ControlUnit {
        /// Millimetres.
        Millimetre = "mm",
        /// Inches (25.4 mm).
        Inch = "inch",
    }
}

impl ControlUnit {
    /// Millimetres in one unit.
    pub(crate) const fn in_mm(self) -> f64 {
        match self {
            ControlUnit::Millimetre => 1.0,
            ControlUnit::Inch => crate::quantity::MM_PER_INCH,
        }
    }

    /// Least command increment of a Fanuc machine in this unit (1001#0) at IS-B, µm: 0.001 mm, 0.0001 in (B-63943EN-1 p. 109).
    pub(crate) const fn least_increment_um(self) -> f64 {
        if let ControlUnit::Inch = self { 2.54 } else { 1.0 }
    }

    /// The unit that machine data such as MD10240 and MD32711 stand for: 1 = metric, 0 = inch.
    pub(crate) fn of_metric(value: f64) -> ControlUnit {
        if value > 0.0 { ControlUnit::Millimetre } else { ControlUnit::Inch }
    }

    /// The other way: `1 (metric)` or `0 (inch)`.
    pub(crate) const fn as_metric(self) -> &'static str {
        match self {
            ControlUnit::Millimetre => "1 (metric)",
            ControlUnit::Inch => "0 (inch)",
        }
    }
}

words! {
    /// What an emitted file is for (contract §4).
    pub enum Role {
        /// Compensation values.
        Table = "table",
        /// Parameters, or memory reservation.
        Parameters = "parameters",
        /// Switches the compensation on.
        Enable = "enable",
        /// Switches it off.
        Disable = "disable",
        /// Restores what was read out of the control.
        Rollback = "rollback",
        /// Tables that are zero but for one bump, to prove the sign of a mechanism.
        SignProof = "sign-proof",
        /// What to do at the machine, for people.
        Checklist = "checklist",
        /// Whatever else a user's template writes; no reader of this program takes it, so nothing shows
        /// what a control would hold that loads it.
        Report = "report",
    }
}

impl Role {
    /// Whether the file stands beside the kit: a control loads it instead of the tables, never
    /// with them.
    pub const fn stands_apart(self) -> bool {
        matches!(self, Role::Rollback | Role::SignProof)
    }

    /// Whether a reader of this program takes the file.
    pub(crate) const fn is_read_back(self) -> bool {
        !matches!(self, Role::Checklist | Role::Report)
    }

    /// Whether people write into the file what they note; every other file has to stay as it was made.
    pub(crate) const fn is_written_into(self) -> bool {
        matches!(self, Role::Checklist)
    }
}

/// An inclusive block of point numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NumberRange {
    /// First number.
    pub first: u32,
    /// Last number.
    pub last: u32,
}

impl NumberRange {
    /// Whether a number lies in the block.
    pub const fn contains(self, number: u32) -> bool {
        self.first <= number && number <= self.last
    }

    /// Whether two blocks share a number.
    pub const fn overlaps(self, other: NumberRange) -> bool {
        self.first <= other.last && other.first <= self.last
    }

    /// Whether one of the blocks holds all its numbers.
    pub(crate) fn lies_in(self, blocks: &[NumberRange]) -> bool {
        blocks.iter().any(|block| block.contains(self.first) && block.contains(self.last))
    }
}

/// A fact as it stands in the profile, for people and for the manifest.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Statement {
    /// Name of the fact.
    pub fact: String,
    /// Its value as written in the profile.
    pub value: String,
    /// How well it is known.
    pub evidence: Evidence,
    /// Where it is from.
    pub source: String,
    /// What happens if it is wrong.
    pub consequence: Option<String>,
    /// What it belongs to; `None` = it matters for every kit.
    #[serde(skip)]
    pub mechanism: Option<Mechanism>,
}

/// A value that a page can state as a fact.
pub(super) trait FactValue: Sized {
    /// The value under the key `value`.
    fn read(fact: &Section<'_>) -> Option<Self>;
}

impl<W: Word> FactValue for W {
    fn read(fact: &Section<'_>) -> Option<Self> {
        fact.choice("value", W::WORDS)
    }
}

impl FactValue for u32 {
    fn read(fact: &Section<'_>) -> Option<Self> {
        fact.whole("value")
    }
}

impl FactValue for f64 {
    fn read(fact: &Section<'_>) -> Option<Self> {
        fact.positive("value")
    }
}

impl FactValue for bool {
    fn read(fact: &Section<'_>) -> Option<Self> {
        fact.flag("value")
    }
}

impl FactValue for String {
    fn read(fact: &Section<'_>) -> Option<Self> {
        fact.text("value")
    }
}

impl FactValue for Vec<String> {
    fn read(fact: &Section<'_>) -> Option<Self> {
        fact.texts("value")
    }
}

impl FactValue for Vec<NumberRange> {
    fn read(fact: &Section<'_>) -> Option<Self> {
        let pairs = fact.whole_pairs("value")?;
        if pairs.iter().any(|[first, last]| first > last) {
            fact.refuse("value", refusals::ends_before());
        }
        let block = |[first, last]: [u32; 2]| NumberRange { first, last };
        Some(pairs.into_iter().map(block).collect())
    }
}

/// The sections `[facts.NAME]`: value, evidence, source, consequence, mechanism.
pub(crate) struct Facts<'a> {
    pub(super) section: Section<'a>,
    pub(super) statements: RefCell<Vec<Statement>>,
    /// Whether they are of a control whose files are the generic table.
    pub(super) is_typed: Cell<bool>,
}

impl<'a> Facts<'a> {
    pub(super) fn of(section: Section<'a>) -> Facts<'a> {
        Facts { section, statements: RefCell::default(), is_typed: Cell::default() }
    }

    pub(super) fn stated<T: FactValue>(&self, name: &'static str) -> Option<Fact<T>> {
        self.read(name, T::read)
    }

    /// The same of one that may be absent.
    pub(super) fn if_stated<T: FactValue>(&self, name: &'static str) -> Option<Fact<T>> {
        self.section.has(name).then(|| self.stated(name)).flatten()
    }

    /// Whether tables list their points in lines. A control with factors in place of tables states nothing of them, nor
    /// one whose files are the generic table: what its numbers mean is the rule of its format, and a fact against it
    /// is an unknown key.
    pub(super) fn has_points(&self) -> bool {
        !self.is_typed.get() && !self.section.has("factors")
    }

    /// A fact of such points.
    pub(super) fn of_points<T: FactValue>(&self, name: &'static str) -> Option<Fact<T>> {
        self.has_points().then(|| self.stated(name)).flatten()
    }

    /// The same of one that only matters where lines of files are declared.
    pub(super) fn of_lines<T: FactValue>(&self, name: &'static str, usual: T) -> Option<Fact<T>> {
        if self.is_typed.get() { Some(Fact::rule(usual)) } else { self.stated(name) }
    }

    /// The value of a fact that was read, as it is written.
    pub(super) fn written(&self, name: &str) -> Option<String> {
        let statements = self.statements.borrow();
        Some(statements.iter().find(|statement| statement.fact == name)?.value.clone())
    }

    /// Tells of a number beyond what the program can write or a control can mean.
    pub(super) fn expect(&self, name: &str, is_right: bool, expected: &str) {
        if !is_right {
            self.section.refuse(name, refusals::out_of_range(name, expected));
        }
    }

    /// A number within bounds.
    pub(super) fn within<T: FactValue + PartialOrd>(
        &self,
        name: &'static str,
        range: impl RangeBounds<T>,
        expected: &str,
    ) -> Option<Fact<T>> {
        let fact = self.stated(name)?;
        self.expect(name, range.contains(&fact.value), expected);
        Some(fact)
    }

    /// Decimals of a number in a file.
    pub(super) fn decimals(&self, name: &'static str) -> Option<Fact<u32>> {
        self.within(name, ..=9, "0 … 9")
    }

    /// A fact whose value `value` reads. One that a family reads besides is stated once.
    pub(super) fn read<T>(
        &self,
        name: &'static str,
        value: impl FnOnce(&Section<'_>) -> Option<T>,
    ) -> Option<Fact<T>> {
        let section = self.section.required_section(name)?;
        let value = value(&section);
        section.require("value", "what is stated");
        let origin = complete_origin(&section);
        let mechanism = section.choice("mechanism", Mechanism::WORDS);
        section.refuse_unknown_keys();
        let written = section.as_written("value").unwrap_or_default();
        let fact = origin?.with(value?);
        if self.written(name).is_none() {
            self.statements.borrow_mut().push(Statement {
                fact: name.to_string(),
                value: written.trim_matches('"').to_string(),
                evidence: fact.evidence,
                source: fact.source.clone(),
                consequence: fact.consequence.clone(),
                mechanism,
            });
        }
        Some(fact)
    }
}

impl<T> Fact<T> {
    /// A rule of this program in place of a fact.
    pub(crate) fn rule(value: T) -> Fact<T> {
        Fact { value, evidence: Evidence::Manual, source: RULE.to_string(), consequence: None }
    }

    /// The same origin for another value.
    pub(crate) fn with<V>(self, value: V) -> Fact<V> {
        Fact { value, evidence: self.evidence, source: self.source, consequence: self.consequence }
    }
}

/// Where a statement of a page is from, how well it is known, and what happens if it is wrong.
pub(super) fn origin(section: &Section<'_>) -> Option<Fact<()>> {
    section.require("evidence", "`manual`, `assumed` or `executed`");
    let evidence = section.choice("evidence", Evidence::WORDS);
    let source =
        section.required_text("source", "manual, edition and chapter, or why it is assumed");
    let consequence = section.text("consequence");
    Some(Fact { value: (), evidence: evidence?, source: source?, consequence })
}

/// The same, with a consequence where it is assumed.
fn complete_origin(section: &Section<'_>) -> Option<Fact<()>> {
    let origin = origin(section);
    if section.text("evidence").as_deref() == Some(Evidence::Assumed.word()) {
        section.require("consequence", "what happens on the machine if the assumption is wrong");
    }
    origin
}

/// Where a statement is from that no control makes.
pub(crate) const RULE: &str = "a rule of this program, not of the control";

/// The same of a step or a key of a job: one that states nothing of it is a rule of this program.
pub(crate) fn origin_or_rule(section: &Section<'_>) -> Option<Fact<()>> {
    let is_stated = ["evidence", "source", "consequence"].iter().any(|key| section.has(key));
    if is_stated { complete_origin(section) } else { Some(Fact::rule(())) }
}
