//! A control whose profile declares how its file is written and read back: the switches by which tables of
//! controls differ, each a fact of its own (docs/own-control.md).
//!
//! ```text
//!   what a number is    value_form, own_sign, cross_sign, value_size, value_decimals, largest_value
//!   where it stands     position_size, position_decimals, order, first_point, points
//!   which tables        cross_terms, backlash; in place of tables with points `factors`
//!   how a line is read  lines, file_name, comments; their fields say how points lie, and whether a value has two directions
//! ```

use super::fact::{Comments, ControlUnit, Fact, FactValue, Facts, Mechanism, Outside, TableSign};
use super::family::{Family, Proof};
use super::form::{Form, Order, PointLists, Rounding, Size, ValueForm};
use super::pattern::{Field, Pattern};
use crate::control::refusals;
use crate::control::table::{ListedTable, ListedTables, Tables};
use crate::quantity::{Axis, ErrorTerm, UM_PER_MM};
use crate::text::{LengthUnit, Section, section, words};

pub(super) static FAMILY: Family = Family {
    word: "declared",
    backlash_parameter: "backlash parameter",
    between: "linear",
    outside: &[Outside::Hold, Outside::Zero, Outside::Unknown],
    no_tables: Tables::Listed(ListedTables::NONE),
    off: "removed",
    restarts: true,
    proofs: &[
        Proof::of(Mechanism::OwnTable, "tables of axes for themselves", "own_sign"),
        Proof::of(Mechanism::CrossTable, "tables that follow another axis", "cross_sign"),
        Proof::of(Mechanism::Skew, "skew correction", "skew_sign"),
    ],
};

pub(super) static GENERIC: Family = Family {
    word: "generic",
    backlash_parameter: "backlash parameter",
    between: "linear",
    outside: &[Outside::Hold],
    no_tables: Tables::Listed(ListedTables::NONE),
    off: "removed",
    restarts: true,
    proofs: &[],
};

words! {
    /// What the backlash parameter of an axis does beside a table of the axis.
    pub enum BesideTable {
        /// It acts in addition.
        Adds = "adds",
        /// Nothing: the table stands in its place.
        Replaced = "replaced",
    }
}

/// A number in place of a table: how far an axis leans while another one moves, mm in a mm, zero at position 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Factor {
    /// The control's name of it.
    pub name: String,
    /// The term whose slope it takes off.
    pub term: ErrorTerm,
}

impl Factor {
    /// The axis that is looked up, and the one that is corrected.
    pub(crate) fn axes(&self) -> [&'static str; 2] {
        [self.term.along, self.term.of].map(Axis::key)
    }
}

impl FactValue for Vec<Factor> {
    fn read(fact: &Section<'_>) -> Option<Self> {
        let own = fact.entries("value").into_iter();
        let own = own.map(|(name, term)| Some(Factor { name, term: ErrorTerm::from_name(&term)? }));
        let factors: Option<Vec<Factor>> = own.collect();
        if factors.as_ref().is_none_or(Vec::is_empty) {
            fact.refuse("value", refusals::no_factors());
        }
        factors
    }
}

section! {
    /// Facts of a declared control.
    #[derive(Clone, Debug, PartialEq)]
    pub struct DeclaredFacts(facts: &Facts<'_>) {
        /// The numbers that stand in place of tables.
        pub factors: Option<Fact<Vec<Factor>>> = if_stated();
        /// Why a slope has no factor.
        pub no_factor: Option<Fact<String>> = if_stated();
        /// The name of the set of factors, of which the control loads one.
        pub set_name: Option<Fact<String>> = if_stated();
        /// What the control shows of a factor, with `{of}`, `{by}` and `{value}`.
        pub shown: Option<Fact<String>> = if_stated();
        /// Sense of the table of an axis for itself.
        pub own_sign: Fact<TableSign> = of_points(), or Fact::rule(TableSign::AsCorrection);
        /// How many other axes an axis can follow.
        pub cross_terms: Fact<u32> => (!facts.section.has("factors")).then(|| facts.within("cross_terms", ..=OTHER_AXES, "0, 1 or 2")).flatten(), or Fact::rule(OTHER_AXES);
        /// What is typed in, of a control without files of its own.
        pub typed: Option<Typed> => facts.is_typed.get().then(|| Typed::read(facts)).flatten();
        /// Sense of the table of an axis that follows another, or of a factor.
        pub cross_sign: Fact<TableSign> => (factors.is_some() || !facts.is_typed.get()).then(|| facts.stated(sign_fact(factors.is_some()))).flatten(), or Fact::rule(TableSign::AsCorrection);
        /// In which form a number says it.
        pub value_form: Fact<ValueForm> = of_points(), or Fact::rule(ValueForm::Amount);
        /// Size of 1 of a value.
        pub value_size: Fact<Size> = of_points(), or Fact::rule(typed.as_ref().map_or(Size::fixed(if factors.is_some() { UM_PER_MM } else { 1.0 }), Typed::size));
        /// Decimals of values; one count is the last decimal.
        pub value_decimals: Fact<u32> => (!facts.is_typed.get() || facts.section.has("value_decimals")).then(|| facts.decimals("value_decimals")).flatten(), or Fact::rule(0);
        /// Largest value that the control takes, either sign, as in the file.
        pub largest_value: Fact<f64> = of_points(), or Fact::rule(f64::INFINITY);
        /// Size of 1 of a position.
        pub position_size: Fact<Size> = of_points(), or Fact::rule(Size::fixed(UM_PER_MM));
        /// Decimals of positions.
        pub position_decimals: Fact<u32> => facts.has_points().then(|| facts.decimals("position_decimals")).flatten(), or Fact::rule(6);
        /// Order of the points.
        pub order: Fact<Order> = of_points(), or Fact::rule(Order::Ascending);
        /// Number of the first point of a table.
        pub first_point: Fact<u32> = of_points(), or Fact::rule(0);
        /// Most points of a table; a factor is one.
        pub points: Fact<u32> => (!facts.section.has("factors")).then(|| facts.within("points", 2.., "at least 2")).flatten(), or Fact::rule(1);
        /// What the backlash parameter does beside a table.
        pub backlash: Fact<BesideTable> = of_points(), or Fact::rule(BesideTable::Adds);
        /// What a control adds outside a table.
        pub outside: Fact<Outside> => facts.of_lines("outside", Outside::Hold), must;
        /// Whether a point may lie behind the end of the travel.
        pub points_beyond_travel: Fact<bool> = of_points(), or Fact::rule(true);
        /// A column for − that is zero everywhere stands for that for +.
        pub zero_reverse_is_forward: Fact<bool> = of_points(), or Fact::rule(false);
        /// What begins a comment.
        pub comments: Fact<Comments> => facts.of_lines("comments", Comments::None), must;
        /// What a line of a file can be, in this order.
        pub lines: Fact<Vec<Pattern>> => (!facts.is_typed.get()).then(|| facts.stated("lines")).flatten(), or Fact::rule(Vec::new());
        /// What the name of a file says; a pattern that takes none says nothing.
        pub file_name: Fact<Vec<Pattern>> = of_points(), or Fact::rule(Vec::new());
    }
}

/// The fact that says the sense of what moves another axis.
const fn sign_fact(is_factor: bool) -> &'static str {
    if is_factor { "skew_sign" } else { "cross_sign" }
}

/// Axes that one axis can follow.
const OTHER_AXES: u32 = 2;

impl DeclaredFacts {
    /// Those of a control whose files are the generic table.
    pub(super) fn typed(facts: &Facts<'_>) -> Option<DeclaredFacts> {
        facts.is_typed.set(true);
        facts.stated::<u32>("points"); // as its pages have them, the first of all
        DeclaredFacts::checked(facts)
    }

    /// Reads and checks them.
    pub(super) fn checked(facts: &Facts<'_>) -> Option<DeclaredFacts> {
        let own = DeclaredFacts::read(facts)?;
        if own.value_size.value.is_of_axis {
            let required = facts.stated("detection_unit_required")?;
            let expected = "`true`: values count the detection unit";
            facts.expect("detection_unit_required", required.value, expected);
        }
        for (name, is_right, expected) in own.rules() {
            facts.expect(name, is_right, expected);
        }
        if facts.section.has("lines") {
            own.check_lines(facts);
        }
        Some(own)
    }

    /// What the switches have to be together: fact, whether it is so, what is expected.
    fn rules(&self) -> [(&'static str, bool, &'static str); 6] {
        let is_increment = self.value_form.value == ValueForm::Increment;
        let has_two = self.has_two();
        let is_ascending = self.order.value == Order::Ascending;
        let is_spaced = self.is_spaced();
        [
            (
                "position_size",
                !self.position_size.value.is_of_axis
                    && (self.millimetre_decimals().is_some()
                        || self.form(true, ControlUnit::Millimetre).is_inch()),
                "`mm`, `um`, `inch`, or a power of ten of a micrometre",
            ),
            (
                "value_form",
                !(is_increment && has_two),
                "`amount` or `position` with two columns: increments do not say what the second one holds at the reference",
            ),
            (
                "order",
                is_ascending || !(is_increment || is_spaced),
                "`ascending` with increments, or with a start and a spacing",
            ),
            (
                "backlash",
                has_two || self.backlash.value == BesideTable::Adds,
                "`adds`: one column cannot hold the reversal",
            ),
            (
                "value_size",
                self.value_form.value != ValueForm::Position
                    || self.value_size.value == self.position_size.value,
                "the size of positions: the values are positions",
            ),
            (
                "comments",
                self.comments.value != Comments::OfFamily || self.has(Field::Set),
                "`false`, or the sign that begins a comment in quotes",
            ),
        ]
    }

    /// The decimals of a millimetre that positions have; `None` where they are no such fractions.
    pub(crate) fn millimetre_decimals(&self) -> Option<u32> {
        let decimals = self.position_decimals.value;
        (0..=9)
            .find(|more| {
                let um = LengthUnit::Mm.um() / crate::quantity::power_of_ten(*more);
                (um / self.position_size.value.um - 1.0).abs() < 1e-12
            })
            .map(|more| more + decimals)
    }

    /// The numbers that stand in place of tables with points; none of a control with tables.
    pub fn factors(&self) -> &[Factor] {
        self.factors.as_ref().map_or(&[], |own| &own.value)
    }

    /// The axes of a factor: the one that is looked up, and the one that is corrected.
    pub(crate) fn axes_of(&self, factor: &str) -> Option<[String; 2]> {
        Some(self.factors().iter().find(|own| own.name == factor)?.axes().map(str::to_string))
    }

    /// What a table of these axes means.
    pub(crate) fn sign(&self, is_own: bool) -> &Fact<TableSign> {
        if is_own { &self.own_sign } else { &self.cross_sign }
    }

    /// Fields of values in a table, by the field of the file.
    pub(crate) fn value_fields(&self, is_own: bool) -> &'static [Field] {
        if is_own && self.has_two() { &[Field::Forward, Field::Reverse] } else { &[Field::Value] }
    }

    /// Whether the patterns have a field.
    pub(crate) fn has(&self, field: Field) -> bool {
        let mut all = self.lines.value.iter().chain(&self.file_name.value);
        all.any(|pattern| pattern.fields().any(|own| own == field))
    }

    /// A table of an axis for itself has a value for each direction of travel; one that follows another has one.
    pub fn has_two(&self) -> bool {
        self.has(Field::Reverse)
    }

    /// Points have no positions of their own: the first one and the distance are given.
    pub(crate) fn is_spaced(&self) -> bool {
        self.factors.is_none() && self.typed.is_none() && !self.has(Field::Position)
    }

    /// The patterns together have a field for all that a table holds.
    fn check_lines(&self, facts: &Facts<'_>) {
        let if_any = |any: bool, fields: &'static [Field]| if any { fields } else { &[] };
        let places = if_any(self.is_spaced(), &[Field::Start, Field::Spacing]);
        let cross = if_any(self.cross_terms.value > 0, &[Field::Base, Field::Value]);
        let wanted = match self.factors.is_some() {
            true => vec![Field::Table, Field::Value],
            false => [self.value_fields(true), places, cross].concat(),
        };
        for field in wanted.iter().filter(|field| !self.has(**field)) {
            let two = match self.has_two() && *field == Field::Value {
                true => ": two columns of a table that follows another axis cannot be declared",
                false => "",
            };
            facts.section.refuse("lines", refusals::no_field(field.word(), two));
        }
        let names_axes = self.has(Field::Axis) || self.has(Field::Output);
        if !names_axes && self.factors.is_none() {
            facts.section.refuse("lines", refusals::no_axis_field());
        }
    }
}

impl PointLists for DeclaredFacts {
    fn form(&self, is_own: bool, _unit: ControlUnit) -> Form {
        Form {
            sign: self.sign(is_own).value,
            value: self.value_form.value,
            value_um: self.value_size.value.um,
            is_of_axis: self.value_size.value.is_of_axis,
            value_decimals: self.value_decimals.value,
            rounding: match &self.typed {
                Some(typed) if !typed.is_held() => Rounding::None,
                _ => Rounding::LastDecimal,
            },
            largest: self.largest_value.value,
            position_um: self.position_size.value.um,
            position_decimals: self.position_decimals.value,
            order: self.order.value,
            has_two: is_own && self.has_two(),
            outside: self.outside.value,
            beyond_travel: self.points_beyond_travel.value,
            zero_reverse_is_forward: self.zero_reverse_is_forward.value,
            is_float: false,
            is_factor: self.factors.is_some(),
            names_terms: self.typed.is_some(),
        }
    }

    fn replaces_parameter(&self) -> bool {
        self.backlash.value == BesideTable::Replaced
    }

    fn table_name(&self, table: &ListedTable) -> String {
        let mut factors = self.factors().iter();
        let own = factors.find(|own| own.axes() == [table.base.as_str(), table.output.as_str()]);
        own.map_or_else(|| table.name(), |own| own.name.clone())
    }
}

// What is typed into a control without files of its own, from the generic table (docs/interface.md §4.1), whose files are
// not declared line by line but fixed.

section! {
    /// What a person types into the control. The generic table carries deviation, correction and increment, so no
    /// sign has to be assumed.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Typed(facts: &Facts<'_>) {
        /// What it is.
        pub value as typed_value: Fact<TypedValue> = stated(), must;
        /// In which unit its screen takes it.
        pub unit as typed_unit: Fact<Size> = stated(), must;
        /// Its decimals, where the control fixes them; `None` = multiples of the detection unit.
        pub decimals as value_decimals: Option<Fact<u32>> = if_stated();
        /// A point has one value for both directions.
        pub one_for_both: Option<Fact<bool>> = if_stated();
    }
}

impl Typed {
    /// The column of a typed list that holds the values.
    pub(crate) fn column(&self) -> String {
        format!("{}_{}", self.value.value.word(), self.unit_word())
    }

    /// The unit of the values, in the name of that column.
    pub(crate) fn unit_word(&self) -> &'static str {
        self.unit.value.word().unwrap_or("count")
    }

    /// Each direction can have a table. Increments do not hold what a second one has at the reference.
    pub fn takes_directions(&self) -> bool {
        let is_one = self.one_for_both.as_ref().is_some_and(|own| own.value);
        !is_one && !self.value.value.is_increment()
    }

    /// Tables hold the numbers that are typed: counts, or with the decimals of the control. Else they hold µm.
    pub(crate) fn is_held(&self) -> bool {
        self.decimals.is_some() || self.unit.value.word().is_none()
    }

    /// Size of 1 in a table.
    fn size(&self) -> Size {
        if self.is_held() { self.unit.value } else { Size::fixed(1.0) }
    }
}

words! {
    /// What a person types into a control that reads no file.
    pub enum TypedValue {
        /// The machine's error.
        Deviation = "deviation",
        /// What the control adds.
        Correction = "correction",
        /// Its change from the point before.
        Increment = "increment",
        /// The same, each change at the end of its section that is away from the reference.
        Outward = "outward_increment",
    }
}

impl TypedValue {
    /// Whether it is a change, zero where nothing is said of it.
    pub(crate) const fn is_increment(self) -> bool {
        matches!(self, TypedValue::Increment | TypedValue::Outward)
    }

    /// A bump by hand, and which way the axis has to go; nothing else moves.
    pub(crate) const fn bump(self) -> &'static str {
        match self {
            TypedValue::Deviation => {
                "type one deviation of +: at its point the axis has to move towards −"
            }
            TypedValue::Correction => {
                "type one correction of +: at its point the axis has to move towards +"
            }
            TypedValue::Increment => {
                "type a value of + at one point and as much − at the next one in +: at the first of them the axis has to move towards +, at no other"
            }
            TypedValue::Outward => {
                "type two values side by side, from the reference point outwards + and then as much −: at the first of them the axis has to move, in + of the reference towards +, in − of it towards −, at no other"
            }
        }
    }

    /// What it is, for the person who types it.
    pub(crate) const fn words(self) -> &'static str {
        match self {
            TypedValue::Deviation => "deviation of the machine (actual − commanded)",
            TypedValue::Correction => "correction, which the control adds",
            TypedValue::Increment => "change of the correction from the point before, from − to +",
            TypedValue::Outward => {
                "change of the correction, from − to +, over the section that ends at the point, seen from the reference"
            }
        }
    }
}
