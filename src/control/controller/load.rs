//! A profile from its TOML page: every fact with evidence and source, checked before use.
//!
//! A profile may build on a built-in one (`based_on = "fanuc-30i"`): its page is laid over that one,
//! then read once. Whether a page is ours or a user's makes no difference.

use crate::control::checklist::{Step, steps};
use crate::control::claims::Precondition;
use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::fact::{Comments, Facts, Mechanism, origin, origin_or_rule};
pub use crate::control::controller::files::TemplateFinder;
use crate::control::controller::files::{Templates, files};
use crate::control::controller::form::ValueForm;
use crate::control::controller::program::{ProgramFacts, program_facts};
use crate::control::controller::{
    ControlUnit, DeclaredFacts, Dialect, EmittedFile, Encoding, Fact, Family, FanucFacts, IsgFacts,
    JobKey, LineEnd, LinuxcncFacts, ProfileSource, SiemensFacts, Statement, Typed, declared, fanuc,
    isg, linuxcnc, siemens,
};
use crate::control::refusals;
use crate::quantity::{Direction, Millimetres};
use crate::text::{Problems, Section, Source, Word, read_page, refuse_large_page, section, shown};
use toml::de::{DeArray, DeTable, DeValue};

/// Finds a built-in page by its id.
pub type PageFinder<'a> = &'a dyn Fn(&str) -> Option<&'static str>;

/// Reads and checks a profile. All problems of the page are given at once.
pub fn profile(
    source: Source,
    origin: ProfileSource,
    templates: TemplateFinder<'_>,
    pages: PageFinder<'_>,
) -> Result<Profile, Problems> {
    refuse_large_page(&source.name, source.text.len())?;
    let below = pages_below(&source.text, pages);
    let own_end = source.text.len();
    let templates = Templates { find: templates, own_end, proved: &proved() };
    let read = |root: &Section<'_>| read_profile(root, origin, &below, templates);
    let pages: Vec<(&str, &str)> =
        below.iter().map(|page| ("the built-in profile", *page)).collect();
    Ok(read_page((source, &pages, lay_over), |_| true, read, |_| ())?.0)
}

/// The pages that a page builds on, the nearest first.
fn pages_below(own: &str, pages: PageFinder<'_>) -> Vec<&'static str> {
    let next = |page: &str| pages(&text_of(page, "based_on")?);
    std::iter::successors(next(own), |page| next(page)).collect()
}

fn text_of(page: &str, key: &str) -> Option<String> {
    let table = DeTable::parse(page).ok()?;
    Some(table.get_ref().get(key)?.get_ref().as_str()?.to_string())
}

/// What a page takes of the one below: what it does not state. Facts are taken one by one, whole; `mechanism`, which
/// says what a fact belongs to, also by itself. Its `steps` and `preconditions` stand before the own ones; its
/// examples hold with its own facts only.
fn lay_over<'a>(own: &mut DeTable<'a>, below: DeTable<'a>) {
    for (key, value) in below {
        let name: &str = key.get_ref();
        match own.get_mut(name).map(toml::Spanned::get_mut) {
            None if matches!(name, "schema" | "id" | "name" | "example" | "no_example") => {}
            None => {
                own.insert(key, value);
            }
            Some(DeValue::Table(own)) => match (name, value.into_inner()) {
                ("facts", DeValue::Table(facts)) => lay_facts_over(own, facts),
                ("program", DeValue::Table(program)) => lay_over(own, program),
                _ => {}
            },
            Some(DeValue::Array(own)) if matches!(name, "steps" | "preconditions") => {
                if let DeValue::Array(steps) = value.into_inner() {
                    *own =
                        steps.into_iter().chain(std::mem::replace(own, DeArray::new())).collect();
                }
            }
            Some(_) => {}
        }
    }
}

fn lay_facts_over<'a>(own: &mut DeTable<'a>, below: DeTable<'a>) {
    for (key, value) in below {
        let name: &str = key.get_ref();
        match (own.get_mut(name), value.get_ref()) {
            (None, _) => {
                own.insert(key, value);
            }
            (Some(own), DeValue::Table(fact)) => {
                let mechanism = fact.iter().find(|(key, _)| key.get_ref() == "mechanism");
                if let (DeValue::Table(own), Some((key, value))) = (own.get_mut(), mechanism)
                    && !own.contains_key("mechanism")
                {
                    own.insert(key.clone(), value.clone());
                }
            }
            _ => {}
        }
    }
}

section! {
    /// A control, as the program knows it.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Profile(
        root: &Section<'_>,
        names: [String; 2],
        source: ProfileSource,
        known: Option<Known>,
        facts: &Facts<'_>,
        templates: Templates<'_>
    ) {
        /// The id, as in `controllers list`.
        pub id: String => names[0].clone();
        /// Maker and model.
        pub name: String => names[1].clone();
        /// Built in, or a user's own.
        pub origin: ProfileSource => source;
        /// What all controls of its family have in common.
        pub family: &'static Family => known.map(|(family, _)| family), must;
        /// The format family with its facts.
        pub dialect: Dialect => dialect(known, facts), must;
        /// Line end of the emitted files.
        pub line_end: Fact<LineEnd> => facts.stated("line_end"), must;
        /// Whether the control's files may carry comments.
        pub comments: Fact<Comments> => facts.stated("comments"), must;
        /// Names of the axes X, Y, Z where the job does not state them.
        pub axis_names: Fact<Vec<String>> => axis_names(facts), must;
        /// Whether the job must state a detection unit for each axis.
        pub detection_unit_required: Fact<bool> => facts.stated("detection_unit_required"), must;
        /// How the characters of the emitted files are stored; `None` = not stated, UTF-8.
        pub encoding: Option<Fact<Encoding>> => {
            let stated = facts.if_stated("encoding");
            facts.section.refuse_unknown_keys();
            stated
        };
        /// The files of a kit, in the order of the manifest.
        pub files: Vec<EmittedFile> => files(root, facts.written("table_form"), templates), must;
        /// How its part programs are written; `None` = no program can be written for it.
        pub program: Option<ProgramFacts> = sub(|own| program_facts(own, templates));
        /// Keys of a job that it needs, in order.
        pub job_keys as job: Vec<JobKey> = subs(|own| JobKey::read(own, origin_or_rule(own)));
        /// The steps of a service visit, in order.
        pub checklist: Vec<Step> => steps(root);
        /// What a person has to see to on the control whatever the kit holds.
        pub preconditions: Vec<Precondition> = subs(Precondition::read);
        /// What switches tables off, as a remark on a kit without a file for it; `None` = a person has to see to it.
        pub off_by_hand: Option<String> = text();
        /// The page that explains the order of loading.
        pub page: Option<String> = text();
        /// The display that shows the correction that acts on an axis; `None` = none is known.
        pub display: Option<Fact<String>> = sub(display);
        /// Files of others, and what the control adds for them.
        pub examples as example: Vec<Example> = subs(Example::read);
        /// Why there is none.
        pub no_example: Option<String> = text();
        /// All facts in words, in the order of the program's questions.
        pub statements: Vec<Statement> => facts.statements.take();
    }
}

impl Profile {
    /// The file of a kit that is called so.
    pub(crate) fn file(&self, name: &str) -> Option<&EmittedFile> {
        self.files.iter().find(|file| file.is_called(name))
    }

    /// What a person types into the control; `None` = it reads files.
    pub(crate) fn typed(&self) -> Option<&Typed> {
        match &self.dialect {
            Dialect::Declared(facts) => facts.typed.as_ref(),
            _ => None,
        }
    }

    /// Largest amount that its tables take, µm at a detection unit of 1 µm, where the profile declares it.
    pub(crate) fn largest_um(&self) -> f64 {
        match &self.dialect {
            Dialect::Declared(own) if own.value_form.value != ValueForm::Position => {
                own.largest_value.value * own.value_size.value.um
            }
            _ => f64::INFINITY,
        }
    }

    /// How the characters of the control's files are stored.
    pub(crate) fn encoding(&self) -> Encoding {
        self.encoding.as_ref().map_or(Encoding::Utf8, |fact| fact.value)
    }
}

fn read_profile(
    root: &Section<'_>,
    origin: ProfileSource,
    below: &[&str],
    templates: Templates<'_>,
) -> Option<Profile> {
    if root.whole("schema") != Some(1) {
        root.refuse("schema", refusals::no_schema());
    }
    let id = root.required_text("id", "a short name such as `fanuc-30i`")?;
    let name = root.required_text("name", "maker and model")?;
    let family = check_base(root, below).and_then(|()| family(root));
    let facts = root.required_section("facts").unwrap_or_else(|| root.absent("facts"));
    let states = |key| facts.begins_at(key).is_some(); // which is no fact of other controls
    let has_both = states("factors") && (states("own_sign") || states("file_name"));
    if has_both {
        facts.refuse("factors", refusals::factors_and_points());
    }
    if family.is_none() || has_both {
        root.ask_no_more(); // what else there is depends on it
        return None;
    }
    Profile::read(root, [id, name], origin, family, &Facts::of(facts), templates)
}

fn check_base(root: &Section<'_>, below: &[&str]) -> Option<()> {
    let Some(id) = root.text("based_on") else {
        return Some(());
    };
    let Some(base) = below.last() else {
        root.refuse("based_on", refusals::base_not_built_in(shown(&id)));
        return None;
    };
    let (own, base) = (root.text("dialect")?, text_of(base, "dialect")?);
    if own != base {
        root.refuse("dialect", refusals::other_dialect(shown(&own), base));
        return None;
    }
    Some(())
}

/// The facts of the family, and those that its emulator implements in one way only: a page must state
/// that way, with its source.
fn dialect(family: Option<Known>, facts: &Facts<'_>) -> Option<Dialect> {
    let dialect = family.and_then(|(_, read)| read(facts));
    let between = family.map_or("linear", |(family, _)| family.between);
    facts.read("interpolation", |f| f.choice("value", &[(between, ())]));
    let outside = family.map_or(&[][..], |(family, _)| family.outside);
    let outside: Vec<_> = outside.iter().map(|own| (own.word(), *own)).collect();
    facts.read("outside", |f| f.choice("value", &outside));
    dialect
}

fn family(root: &Section<'_>) -> Option<Known> {
    let words = FAMILIES.map(|known| (known.0.word, known));
    let list = words.map(|(word, _)| format!("`{word}`")).join(", ");
    root.require("dialect", &format!("one of {list}"));
    root.choice("dialect", &words)
}

/// `[display]`: where the control shows the correction that acts.
fn display(section: &Section<'_>) -> Option<Fact<String>> {
    let value = section.required_text("value", "the name of the display");
    Some(origin(section)?.with(value?))
}

/// Three names that every control can show.
fn axis_names(facts: &Facts<'_>) -> Option<Fact<Vec<String>>> {
    let stated = facts.stated::<Vec<String>>("axis_names")?;
    let (fact, names) = (facts.section.section("axis_names")?, &stated.value);
    if names.len() != 3 {
        fact.refuse("value", refusals::not_three_names(names.len()));
    }
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let other = |name: &&String| name.is_empty() || !name.chars().all(plain);
    for name in names.iter().filter(other) {
        fact.refuse("value", refusals::no_axis_name(shown(name)));
    }
    Some(stated)
}

// The families of controls that there are.

/// A family, and how the facts of its controls are read.
pub(super) type Known = (&'static Family, fn(&Facts<'_>) -> Option<Dialect>);

/// All of them, in the order in which they are named.
pub(super) const FAMILIES: [Known; 6] = [
    (&siemens::FAMILY, |facts| SiemensFacts::read(facts).map(Dialect::Siemens)),
    (&fanuc::FAMILY, |facts| FanucFacts::read(facts).map(Dialect::Fanuc)),
    (&declared::GENERIC, |facts| DeclaredFacts::typed(facts).map(Dialect::Declared)),
    (&declared::FAMILY, |facts| DeclaredFacts::checked(facts).map(Dialect::Declared)),
    (&linuxcnc::FAMILY, |facts| LinuxcncFacts::read(facts).map(Dialect::Linuxcnc)),
    (&isg::FAMILY, |facts| IsgFacts::read(facts).map(Dialect::Isg)),
];

/// What sign proofs can prove, with the words of profiles.
pub(super) fn proved() -> Vec<(&'static str, Mechanism)> {
    let proofs = FAMILIES.iter().flat_map(|(family, _)| family.proofs);
    let mechanisms = proofs.map(|proof| proof.mechanism);
    mechanisms.map(|own| (own.word(), own)).collect()
}

// Examples of a profile: files as a manual prints them or a control wrote them, never as this program writes
// them, and what the control adds for them. A reader and an emulator that agree with their own writer alone
// would still read a foreign file wrongly.

section! {
    /// One `[[example]]` of a profile.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Example(section: &Section<'_>) {
        /// The manual with its page, or the control that wrote the files.
        pub source: String = text(), must "the manual with its page, or the control that wrote it";
        /// Unit of the control.
        pub unit: ControlUnit = choice(ControlUnit::WORDS), or ControlUnit::Millimetre;
        /// The files of the control.
        pub files: Vec<ExampleFile> => section.subs("file", ExampleFile::read);
        /// The axes that they name.
        pub axes: Vec<ExampleAxis> => section.subs("axis", ExampleAxis::read);
        /// What the control adds, place by place.
        pub adds: Vec<Added> => {
            section.require("adds", "what the control adds for them");
            section.subs("adds", Added::read)
        };
    }
}

section! {
    /// A file of an example.
    #[derive(Clone, Debug, PartialEq)]
    pub struct ExampleFile(section: &Section<'_>) {
        /// Its name on the control.
        pub path: String = text(), must "the name of the file";
        /// What stands in it.
        pub text: String = text(), must "what stands in the file";
    }
}

section! {
    /// An axis of an example.
    #[derive(Clone, Debug, PartialEq)]
    pub struct ExampleAxis(section: &Section<'_>) {
        /// The control's name of it.
        pub name: String = text(), must "the name of the axis on the control";
        /// Ends of its travel, mm.
        pub travel_mm: [f64; 2] = pair_of_millimetres(), must "its ends, e.g. [0.0, 900.0]";
        /// Its reference point, mm.
        pub reference_mm: f64 = millimetres(), or 0.0;
        /// Direction of its reference return.
        pub reference_direction: Direction = direction(), or Direction::Plus;
        /// Its detection unit, µm.
        pub detection_unit_um: Option<f64> = positive();
    }
}

section! {
    /// What an axis gets at a place.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Added(section: &Section<'_>) {
        /// The axis that is corrected.
        pub axis: String = text(), must "the axis that is corrected";
        /// The axis that stands there; its own position where it is not stated.
        pub by: Option<String> = text();
        /// Where, mm in machine coordinates.
        pub at_mm: f64 = millimetres(), must "where, mm";
        /// Coming in which direction; `None` = both.
        pub moving: Option<Direction> = direction();
        /// How far the control moves it further in +, µm.
        pub um: f64 = number(), must "what the control adds, µm";
    }
}

impl Example {
    /// The control of the example, without its files.
    pub(crate) fn state(&self) -> ControlState {
        let axis = |own: &ExampleAxis| {
            let reference = Millimetres::new(own.reference_mm);
            AxisState {
                name: own.name.clone(),
                reference,
                reference_direction: own.reference_direction,
                detection_unit_um: own.detection_unit_um,
                backlash_um: 0.0,
                bidirectional: false,
                interpolated: false,
                ends: own.travel_mm.map(Millimetres::new).into(),
                rest: reference,
            }
        };
        ControlState { unit: self.unit, axes: self.axes.iter().map(axis).collect() }
    }
}
