//! `[path]`: what the control knows before a part program starts, and how its path is followed.

use crate::inputs::job::machine::{Axes, MachineAxis, inside_travel};
use crate::inputs::refusals;
use crate::quantity::{Axis, PerAxis};
use crate::text::{Places, Section, Word, section, shown};
use part_program::{G43WithoutH, Language, Place, Setup, WithoutPoint, system_number};
use std::collections::BTreeMap;

section! {
    /// `[path]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct PathRequest(section: &Section<'_>, axes: &Axes) {
        /// What the control knows before the program starts.
        pub setup: Setup => setup(section, axes);
        /// The job says where the axes stand before the program; else they are taken to be at the reference.
        pub has_start: bool => section.has("start_mm");
        /// how far chords may leave an arc
        pub chord_mm: f64 = between(1e-5..=1.0, "mm"), or CHORD_MM;
        /// largest distance of two samples
        pub sample_mm: f64 = between(1e-3..=1e4, "mm"), or SAMPLE_MM;
        /// length of the tool that was measured with
        pub measured_tool_mm: Option<f64> = between(0.0..=LONGEST_TOOL_MM, "mm");
        /// "all": rapid moves count too
        pub rapid as moves: bool = choice(&[("feed", false), ("all", true)]), or false;
        /// "refuse": places outside the measured range are refused
        pub refuse_outside as outside: bool =
            choice(&[("hold", false), ("refuse", true)]), or false;
        /// probed places whose mean error is the datum, machine coordinates
        pub datum: Vec<Place> = subs(|entry| datum(entry, axes));
    }
}

/// Chords leave an arc by no more than the last digit of a program.
const CHORD_MM: f64 = 0.001;
/// Errors of a machine change over tens of millimetres.
const SAMPLE_MM: f64 = 1.0;
const MOST_TOOL_NUMBER: u32 = 9999;
const LONGEST_TOOL_MM: f64 = 10_000.0;
/// Beyond a tenth of a millimetre the arc is not the one that was meant.
const COARSEST_ARC_MM: f64 = 0.1;

impl Word for Language {
    const WORDS: &'static [(&'static str, Language)] =
        &[("iso", Language::Iso), ("siemens", Language::Siemens)];
}

const WITHOUT_POINT: [(&str, WithoutPoint); 2] =
    [("unit", WithoutPoint::Unit), ("increment", WithoutPoint::Increment)];
const BLOCK_DELETE: [(&str, bool); 2] = [("execute", false), ("skip", true)];
const G43_WITHOUT_H: [(&str, G43WithoutH); 3] =
    [("refuse", G43WithoutH::Refuse), ("last-h", G43WithoutH::LastH), ("tool", G43WithoutH::Tool)];

const WITH_REFERENCES: &str = "the travel widened by `reference_outside_mm`:";
const COORDINATES: PerAxis<&str> = PerAxis { x: "x_mm", y: "y_mm", z: "z_mm" };

fn setup(section: &Section<'_>, axes: &Axes) -> Setup {
    let reference = |axis: Axis| axes[axis].map_or(0.0, |machine| machine.reference.mm());
    let usual = Setup::at(Axis::ALL.map(reference));
    let inside = |key: &'static str| {
        let place = section.place(key)?;
        for (axis, machine) in axes.iter() {
            if let Some(range) = machine.as_ref().map(MachineAxis::range_of_references) {
                section.inside(key, (axis, place[axis]), range, WITH_REFERENCES);
            }
        }
        Some(plain(place))
    };
    let start = inside("start_mm").unwrap_or(usual.start);
    let (tools, tool_names) = tools(section);
    Setup {
        start,
        tools,
        tool_names,
        language: section.choice("language", Language::WORDS).unwrap_or_default(),
        second_reference: inside("second_reference_mm"),
        systems: systems(section),
        inch: section.choice("program_unit", &[("mm", false), ("inch", true)]),
        without_point: section
            .choice("without_point", &WITHOUT_POINT)
            .unwrap_or(usual.without_point),
        g43_without_h: section
            .choice("g43_without_h", &G43_WITHOUT_H)
            .unwrap_or(usual.g43_without_h),
        arc_mm: section.between("arc_mm", 1e-4..=COARSEST_ARC_MM, "mm"),
        skip_deletable: section.choice("block_delete", &BLOCK_DELETE).unwrap_or(false),
        ..usual
    }
}

fn datum(entry: &Section<'_>, axes: &Axes) -> Option<Place> {
    let place = entry.coordinates(COORDINATES)?;
    inside_travel(entry, |axis| COORDINATES[axis], &place, axes);
    Some(plain(place))
}

fn plain(place: Places) -> Place {
    Axis::ALL.map(|axis| place[axis].mm())
}

/// `[[path.offset]]`.
fn systems(section: &Section<'_>) -> BTreeMap<u32, Place> {
    let mut systems = BTreeMap::new();
    section.subs("offset", |entry| {
        let example = "a coordinate system, e.g. \"G54\" or \"G54.1 P7\"";
        let name = entry.required_text("system", example);
        let place = entry.coordinates(COORDINATES);
        let name = name?;
        let Some(number) = system_number(&name) else {
            entry.refuse("system", refusals::no_coordinate_system(shown(&name)));
            return None;
        };
        insert(entry, "system", &mut systems, (number, plain(place?)))
    });
    systems
}

/// `[[path.tool]]`: lengths by number, and numbers by name.
fn tools(section: &Section<'_>) -> (BTreeMap<u32, f64>, BTreeMap<String, u32>) {
    let (mut tools, mut names) = (BTreeMap::new(), BTreeMap::new());
    section.subs("tool", |entry| {
        entry.require("number", "the number of the tool offset (H; T of Siemens)");
        entry.require("length_mm", "the length of the tool");
        let number = entry.count("number", 1..=MOST_TOOL_NUMBER, "H0 is no length");
        let length = entry.positive("length_mm");
        let length = length.and_then(|_| entry.between("length_mm", 0.0..=LONGEST_TOOL_MM, "mm"));
        if let Some((name, number)) = entry.text("name").zip(number)
            && names.insert(name.clone(), number).is_some()
        {
            let name = format!("name = \"{}\"", shown(&name));
            entry.refuse("name", refusals::entry_twice(name));
        }
        insert(entry, "number", &mut tools, (number?, length?))
    });
    (tools, names)
}

/// Takes an entry of a list, in which each number stands once.
fn insert<T>(
    entry: &Section<'_>,
    key: &'static str,
    list: &mut BTreeMap<u32, T>,
    (number, value): (u32, T),
) -> Option<()> {
    if list.insert(number, value).is_some() {
        let written = entry.as_written(key).unwrap_or_default();
        entry.refuse(key, refusals::entry_twice(format!("{key} = {}", shown(written))));
    }
    Some(())
}
