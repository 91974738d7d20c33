//! What the integration tests share: kits from texts in memory, the control they would make of
//! the bytes, a small seeded generator, and a straight-line curve of the tests' own.
pub(crate) mod diagonals;
pub(crate) mod machine;
pub(crate) mod machine_h;
pub(crate) mod parallel;
pub(crate) mod published;
pub(crate) mod random;
pub(crate) mod random_map;
pub(crate) mod refusals;
pub(crate) mod tree;
pub(crate) mod visit;

pub(crate) use parallel::*;
pub(crate) use published::*;
pub(crate) use random::*;
pub(crate) use tree::*;
pub(crate) use visit::*;

use nonius::control::controller::{
    BesideTable, CrossTerms, DeclaredFacts, Dialect, Evidence, KitFile, Profile, Role, TableSign,
    builtin,
};
use nonius::control::table::Tables;
use nonius::inputs::error_table::ErrorTable;
use nonius::inputs::job::{DiagonalMeasurement, Job, MeasuredData};
use nonius::inputs::readings::Readings;
use nonius::kit::{self, Inputs, Kit};
use nonius::quantity::{Direction, ErrorTerm, Millimetres, power_of_ten};
use nonius::read::emulate::{Emulator, Response};
use nonius::read::read;
use nonius::text::{Finding, Problems, Source};
use std::fmt::Display;

/// Rounding of sums and products of numbers up to a few hundred micrometres.
pub(crate) const DUST_UM: f64 = 1e-9;

pub(crate) const DIAGONALS: [&str; 4] = ["PPP", "NPP", "PNP", "PPN"];

pub(crate) fn term(name: &str) -> ErrorTerm {
    ErrorTerm::from_name(name).unwrap()
}

/// What was made; its problems end the test.
#[track_caller]
pub(crate) fn shown<T>(made: Result<T, Problems>) -> T {
    made.unwrap_or_else(|problems| panic!("{}", problems.render()))
}

pub(crate) fn source(name: &str, text: &str) -> Source {
    Source::from_bytes(name, text.as_bytes()).unwrap()
}

pub(crate) fn read_job(text: &str) -> Job {
    let read = Job::read(source("job.toml", text));
    read.unwrap_or_else(|p| panic!("{}\n{text}", p.render()))
}

/// `[measurement]` of a machine whose control corrected nothing.
pub(crate) const UNCORRECTED: &str = "active_while_measuring = \"none\"";

/// A job with `errors.csv`, which is measured so.
pub(crate) fn job_of<A: Display>(
    measurement: &str,
    compensation: &str,
    axes: impl IntoIterator<Item = (A, [f64; 2], f64, String)>,
) -> String {
    job_measured(&format!("errors = \"errors.csv\"\n{measurement}"), compensation, axes)
}

/// A job: keys of `[measurement]` and `[compensation]`; each axis with travel and reference, mm, and keys of its tables.
pub(crate) fn job_measured<A: Display>(
    measurement: &str,
    compensation: &str,
    axes: impl IntoIterator<Item = (A, [f64; 2], f64, String)>,
) -> String {
    let axis = |(axis, travel, reference, keys): (A, [f64; 2], f64, String)| {
        format!(
            "[machine.axes.{axis}]\ntravel_mm = {travel:?}\nreference_mm = {reference:?}\n[compensation.axes.{axis}]\n{keys}\n"
        )
    };
    let axes: String = axes.into_iter().map(axis).collect();
    format!(
        "schema = 1\n[machine]\nname = \"M\"\n[measurement]\n{measurement}\n[compensation]\n{compensation}\n{axes}"
    )
}

/// A part program's zero at that of the machine.
pub(crate) const G54: &str =
    "\n[[path.offset]]\nsystem = \"G54\"\nx_mm = 0.0\ny_mm = 0.0\nz_mm = 0.0\n";

/// An error table of axes at places, mm, reached from each of these ways (`""`: none is named), with its `values`.
pub(crate) fn error_rows<const N: usize>(
    columns: &str,
    axes: &[(&str, Vec<f64>)],
    ways: &[&str],
    mut values: impl FnMut(&str, &str, f64) -> [f64; N],
) -> String {
    let mut text = format!("axis,direction,position_mm,{columns}\n");
    for (axis, places) in axes {
        for (way, mm) in ways.iter().flat_map(|way| places.iter().map(move |mm| (way, mm))) {
            let values = values(axis, way, *mm).map(|value| value.to_string());
            text += &format!("{axis},{way},{mm},{}\n", values.join(","));
        }
    }
    text
}

#[track_caller]
pub(crate) fn error_table(text: &str) -> ErrorTable {
    shown(ErrorTable::read(source("errors.csv", text)))
}

pub(crate) fn readings(text: &str, of: &DiagonalMeasurement) -> Result<Readings, String> {
    Readings::read(source("readings.csv", text), of).map_err(|problems| problems.render())
}

/// The measurement of the diagonals of a job.
pub(crate) fn measured_by(job: &str) -> DiagonalMeasurement {
    match read_job(job).measurement.data {
        MeasuredData::Diagonals(measurement) => measurement,
        _ => panic!("no readings in\n{job}"),
    }
}

pub(crate) fn golden_readings(case: &str) -> (DiagonalMeasurement, Readings) {
    let text = |name: &str| fixture(&format!("diagonals/{case}/{name}"));
    let measurement = measured_by(&text("job.toml"));
    let read = readings(&text(&measurement.readings), &measurement);
    (measurement, read.unwrap_or_else(|said| panic!("{said}")))
}

/// The job of a machine of five points an axis for a built-in control, and its errors.
pub(crate) fn five_points(control: &str) -> (String, String) {
    let text = |name: &str| fixture(&format!("machines/five_points/{name}"));
    (text(&format!("{control}.toml")), text("errors.csv"))
}

/// A CEC table of two points from 0 mm on, as a Siemens control writes it, without its switches.
pub(crate) fn cec(
    n: u32,
    [input, output]: [&str; 2],
    step_mm: u32,
    [low, high]: [f64; 2],
) -> String {
    format!(
        "$AN_CEC[{n},0]={low}\n$AN_CEC[{n},1]={high}\n$AN_CEC_INPUT_AXIS[{n}]=({input})\n$AN_CEC_OUTPUT_AXIS[{n}]=({output})\n$AN_CEC_STEP[{n}]={step_mm}\n$AN_CEC_MIN[{n}]=0\n$AN_CEC_MAX[{n}]={step_mm}\n"
    )
}

pub(crate) fn files_of(kit: &Kit, role: Role) -> Vec<KitFile> {
    kit.files.iter().filter(|file| file.role == role).cloned().collect()
}

#[track_caller]
pub(crate) fn text_of<'a>(kit: &'a Kit, path: &str) -> &'a str {
    let file = kit.files.iter().find(|file| file.path == path);
    let bytes = &file.unwrap_or_else(|| panic!("there is no {path}")).bytes;
    std::str::from_utf8(bytes).unwrap()
}

pub(crate) fn checklist(kit: &Kit) -> &str {
    text_of(kit, "checklist.md")
}

pub(crate) fn inputs(job: &str, errors: &str) -> Inputs {
    let (read_job, table) = (read_job(job), error_table(errors));
    let profile = builtin::profile(&read_job.compensation.controller).unwrap();
    let hashes =
        vec![kit::hashed("job.toml", job.as_bytes()), kit::hashed("errors.csv", errors.as_bytes())];
    Inputs::new(read_job, profile, &table, hashes)
        .unwrap_or_else(|p| panic!("{}\n{job}", p.render()))
}

/// The last decimal of a value of a declared control, µm; a typed list without decimals of its own has the axis' unit.
pub(crate) fn count_um(facts: &DeclaredFacts, unit_um: Option<f64>) -> f64 {
    let size = facts.value_size.value;
    match &facts.typed {
        Some(typed) if typed.decimals.is_none() && !size.is_of_axis => unit_um.unwrap_or(0.0),
        _ if size.is_of_axis => size.um * unit_um.unwrap(),
        _ => size.um / power_of_ten(facts.value_decimals.value),
    }
}

/// Whether a job for a built-in control has to state detection units.
pub(crate) fn needs_unit(id: &str) -> bool {
    builtin::profile(id).unwrap().detection_unit_required.value
}

pub(crate) fn is_generic(profile: &Profile) -> bool {
    matches!(&profile.dialect, Dialect::Declared(facts) if facts.typed.is_some())
}

/// Whether the table of an axis for itself holds both directions.
pub(crate) fn has_two_directions(profile: &Profile) -> bool {
    match &profile.dialect {
        Dialect::Declared(facts) => match &facts.typed {
            Some(typed) => typed.takes_directions(),
            None => facts.has_two(),
        },
        Dialect::Isg(_) => false,
        _ => true,
    }
}

/// Whether a table of the control can follow another axis.
pub(crate) fn has_cross_terms(profile: &Profile) -> bool {
    match &profile.dialect {
        Dialect::Linuxcnc(facts) => facts.cross_terms.value == CrossTerms::Hal,
        Dialect::Declared(facts) => facts.cross_terms.value > 0,
        _ => true,
    }
}

pub(crate) fn positioning_ids() -> impl Iterator<Item = &'static str> {
    builtin::ids().into_iter().filter(|id| *id != "klipper-skew")
}

/// Those of them that take a grid of any spacing: the others refuse one that goes beyond the travel.
pub(crate) fn any_grid_ids() -> impl Iterator<Item = &'static str> {
    positioning_ids().filter(|id| match builtin::profile(id).unwrap().dialect {
        Dialect::Declared(facts) => facts.points_beyond_travel.value,
        _ => true,
    })
}

/// Whether the table of an axis for itself stands in place of its backlash parameter.
pub(crate) fn replaces_backlash(profile: &Profile) -> bool {
    match &profile.dialect {
        Dialect::Linuxcnc(_) => true,
        Dialect::Declared(facts) => facts.backlash.value == BesideTable::Replaced,
        _ => false,
    }
}

/// The profile with every sign the other way round, for emulation only.
pub(crate) fn with_signs_turned(profile: &Profile) -> Profile {
    let mut turned = profile.clone();
    let signs = match &mut turned.dialect {
        Dialect::Siemens(facts) => vec![&mut facts.lec_sign, &mut facts.cec_sign],
        Dialect::Fanuc(facts) => vec![&mut facts.pitch_sign, &mut facts.straightness_sign],
        // The generic table says correction and deviation.
        Dialect::Declared(facts) if facts.typed.is_some() => vec![],
        Dialect::Declared(facts) => vec![&mut facts.own_sign, &mut facts.cross_sign],
        Dialect::Linuxcnc(facts) => vec![&mut facts.trim_sign, &mut facts.sum_sign],
        Dialect::Isg(facts) => vec![&mut facts.error_sign, &mut facts.angle_sign],
    };
    for sign in signs {
        sign.value = match sign.value {
            TableSign::AsError => TableSign::AsCorrection,
            TableSign::AsCorrection => TableSign::AsError,
        };
    }
    turned
}

pub(crate) fn generate(job: &str, errors: &str) -> (Inputs, Kit) {
    let inputs = inputs(job, errors);
    let kit = kit::generate(&inputs).unwrap_or_else(|p| panic!("{}\n{job}", p.render()));
    (inputs, kit)
}

/// The tables that a control would hold after loading the bytes of the kit.
pub(crate) fn loaded(profile: &Profile, kit: &Kit) -> Tables {
    shown(read(profile, &kit.files)).tables
}

/// The control, loaded with the bytes of the kit, as `profile` describes it.
pub(crate) fn control(profile: &Profile, kit: &Kit) -> Box<dyn Emulator> {
    kit::emulator(profile, &loaded(profile, kit), &kit.compiled.state)
        .unwrap_or_else(|reason| panic!("{}", reason.0))
}

/// What `output` gets while `base` moves in `direction`.
pub(crate) fn response(
    control: &dyn Emulator,
    base: &str,
    output: &str,
    direction: Direction,
) -> Response {
    control.response(base, output, direction).unwrap_or_else(|reason| panic!("{}", reason.0))
}

pub(crate) fn um_at(response: &Response, mm: f64) -> f64 {
    response.correction(Millimetres::new(mm)).um()
}

impl Random {
    pub(crate) fn of<T: Clone>(&mut self, list: &[T]) -> T {
        self.pick(list).clone()
    }

    /// A number between two others, with three decimals.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        let part = (self.bits() >> 11) as f64 / (1_u64 << 53) as f64;
        ((low + part * (high - low)) * 1000.0).round() / 1000.0
    }
}

/// Straight lines through points, the ends held. Shares nothing with the program.
#[derive(Clone, Debug)]
pub(crate) struct Lines {
    pub(crate) mm: Vec<f64>,
    pub(crate) um: Vec<f64>,
}

impl Lines {
    pub(crate) fn at(&self, x: f64) -> f64 {
        let right = match self.mm.iter().position(|knot| *knot > x) {
            Some(0) => return self.um[0],
            Some(right) => right,
            None => return self.um[self.um.len() - 1],
        };
        let (x0, x1) = (self.mm[right - 1], self.mm[right]);
        let (y0, y1) = (self.um[right - 1], self.um[right]);
        y0 + (x - x0) / (x1 - x0) * (y1 - y0)
    }
}

pub(crate) fn words(findings: &[Finding]) -> Vec<String> {
    findings.iter().map(ToString::to_string).collect()
}

/// How many facts of a profile were read in a manual, are assumed, or were seen on a control: `8/10/0`.
pub(crate) fn evidence(id: &str) -> String {
    let profile = builtin::profile(id).unwrap();
    let count = |evidence| profile.statements.iter().filter(|s| s.evidence == evidence).count();
    let all = [Evidence::Manual, Evidence::Assumed, Evidence::Executed].map(count);
    all.map(|count| count.to_string()).join("/")
}
