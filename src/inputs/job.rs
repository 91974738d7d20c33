//! The job: everything needed to make a kit again (contract §2.3).
//!
//! A job that exists is valid in itself; whether it fits the measured errors and the control is
//! checked later, with [`Job::problem_at`] pointing back at the key.

mod compensation;
mod diagonals;
mod machine;
mod measurement;
mod path;
mod program;

pub use self::compensation::{
    AxisSettings, BacklashPolicy, Compensation, GridRequest, OutsideMeasured, UseOf, WantedTerms,
};
pub(crate) use self::compensation::{one_for_all, policies_as_stated};
pub(crate) use self::diagonals::TEMPERATURES_C;
pub use self::diagonals::{
    AxisMaterial, Beam, DiagonalMeasurement, Frame, Linear, LinearSlope, Material, Reflector, SetUp,
};
pub use self::machine::{Acceptance, LARGEST_BUMP_UM, LEAST_BUMP_UM, Limits, Machine, MachineAxis};
pub(crate) use self::measurement::day;
pub use self::measurement::{
    ActiveSettings, ActiveTables, Levers, MeasuredData, Measurement, NotMeasured, StatedUncertainty,
};
pub use self::path::PathRequest;
pub use self::program::{ProgramRequest, RunType, TargetGrid, WayBack};
use crate::control::controller::Profile;
use crate::inputs::kind::{has_column, head};
use crate::inputs::refusals;
pub(crate) use crate::inputs::refusals::{without_grid, without_unit};
use crate::quantity::{Axis, Chain};
use crate::text::{Key, Pages, Problem, Problems, Section, Source, read_page, states};
use toml::de::{DeTable, DeValue};

/// A checked job.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// The file.
    pub source: Source,
    /// `[machine]`.
    pub machine: Machine,
    /// `[measurement]`.
    pub measurement: Measurement,
    /// `[compensation]`.
    pub compensation: Compensation,
    /// `[limits]`.
    pub limits: Limits,
    /// `[acceptance]`.
    pub acceptance: Acceptance,
    /// `[program]`.
    pub program: Option<ProgramRequest>,
    /// `[path]`.
    pub path: PathRequest,
}

impl Job {
    /// Reads and checks a job; all problems of the page are given at once.
    pub fn read(source: Source) -> Result<Job, Problems> {
        Job::read_for(source, UseOf::Tables)
    }

    /// Reads and checks a job for what is asked of it: keys that it does not need may be empty.
    pub fn read_for(source: Source, use_of: UseOf) -> Result<Job, Problems> {
        Job::read_with((source, &[], |_, _| ()), use_of, |_| ())
    }

    /// The same. One that is refused is refused for everything at once: also for a control that `find` does not
    /// know, for axes without a grid or a detection unit, as far as the page alone shows them, and for the tables that it
    /// names, at which `look_at` looks (`true` = readings).
    ///
    /// **limits** an axis with a section counts as one that is compensated: its measured errors are not read.
    pub fn read_with_its_tables(
        source: Source,
        use_of: UseOf,
        find: impl Fn(&str) -> Result<Profile, Problems>,
        look_at: impl Fn(&str, bool) -> Result<(), Problems>,
    ) -> Result<Job, Problems> {
        Job::read_with((source, &[], |_, _| ()), use_of, |root| {
            if let Some(compensation) = root.section("compensation") {
                ask_for_all(&compensation, find);
            }
            if let Some(measurement) = root.section("measurement") {
                let (errors, readings) = measurement::tables(&measurement);
                let errors = errors.iter().map(|path| look_at(path, false));
                let looked = errors.chain(readings.iter().map(|path| look_at(path, true)));
                looked.for_each(|looked| root.note_all(looked.err().unwrap_or_default()));
            }
        })
    }

    fn read_with(
        pages: Pages<'_>,
        use_of: UseOf,
        besides: impl FnOnce(&Section<'_>),
    ) -> Result<Job, Problems> {
        refuse_table(&pages.0)?;
        let needs = |key: &str| use_of.needs(key);
        let (job, source) = read_page(pages, needs, |root| job(root, use_of), besides)?;
        Ok(Job { source, ..job })
    }

    /// Reads a job that is judged against a first one. Without [machine] it states what differs: every
    /// other key is that of the first job.
    pub(crate) fn read_second(source: Source, first: &Job) -> Result<Job, Problems> {
        let below: &[(&str, &str)] = match states(&source, "machine") {
            true => &[],
            false => &[(&first.source.name, &first.source.text)],
        };
        Job::read_with((source, below, lay_over), UseOf::Tables, |_| ())
    }

    /// A problem at a key of the job, by its dotted path.
    pub(crate) fn problem_at(&self, path: &str, message: impl Into<String>) -> Problem {
        self.source.problem_at(path, message)
    }

    /// The chain, without which nothing can be said of angles; `path` = the key that asks for them.
    pub(crate) fn chain_for_angles(&self, path: &str) -> Result<Chain, Problem> {
        self.machine.chain.ok_or_else(|| {
            self.problem_at(path, "angles act through levers, which need the order of the axes: `machine.chain` is missing")
                .help("state it, e.g. `chain = \"wXYZt\"`")
        })
    }
}

fn refuse_other_schema(root: &Section<'_>) {
    let schema = root.whole("schema");
    if schema != Some(1) && (schema.is_some() || !root.has("schema")) {
        let found = schema.map_or("missing".to_string(), |schema| schema.to_string());
        root.refuse("schema", refusals::other_schema(found));
    }
}

/// The job of a page, without the page.
fn job(root: &Section<'_>, use_of: UseOf) -> Option<Job> {
    ROOT.into_iter().for_each(|key| _ = root.has(key));
    refuse_other_schema(root);
    for key in ["machine", "measurement"] {
        root.required_section(key);
    }
    let machine = root.sub("machine", Machine::read);
    let axes = machine.as_ref().map(|machine| machine.axes).unwrap_or_default();
    let measurement = root.sub("measurement", |s| Measurement::read(s, &axes));
    if matches!(use_of, UseOf::Tables | UseOf::Programs) {
        root.required_section("compensation");
    }
    let program = root.sub("program", |s| ProgramRequest::read(s, measurement.as_ref()));
    let path = root.sub_or_usual("path", |s| PathRequest::read(s, &axes));
    let compensation = root.sub_or_usual("compensation", Compensation::read);
    let limits = root.sub_or_usual("limits", Limits::read);
    let acceptance = root.sub_or_usual("acceptance", |s| Acceptance::read(s, &axes));
    Some(Job {
        source: Source::default(),
        compensation: compensation?,
        limits: limits?,
        acceptance: acceptance?,
        program,
        path: path?,
        machine: machine?,
        measurement: measurement?,
    })
}

/// A table in place of the job would be refused line by line.
fn refuse_table(source: &Source) -> Result<(), Problem> {
    let head = head(&source.text, "#").to_ascii_lowercase();
    if head.contains(['=', '[']) || !head.contains([',', ';', '\t']) {
        return Ok(());
    }
    let (what, key) = match (has_column(&head, "diagonal"), has_column(&head, "axis")) {
        (true, _) => ("a table of readings", "readings"),
        (false, true) => ("an error table", "errors"),
        (false, false) => ("a table", "errors"),
    };
    Err(refusals::table_not_job(&source.name, what, key))
}

/// The keys of a job, each with the section that it stands in; those of `[path]` are in docs/volume.md §8.
pub fn keys() -> impl Iterator<Item = (&'static str, Key)> {
    let sections = [
        ("machine", Machine::KEYS),
        ("machine.axes.x", MachineAxis::KEYS),
        ("measurement", Measurement::KEYS),
        ("measurement", ActiveSettings::KEYS),
        ("measurement", Levers::KEYS),
        ("measurement.step_diagonal", DiagonalMeasurement::KEYS),
        ("measurement.step_diagonal", diagonals::BoxKeys::KEYS),
        ("measurement.step_diagonal.linear", Linear::KEYS),
        ("measurement.step_diagonal.beam", Beam::KEYS),
        ("measurement.step_diagonal.material", Material::KEYS),
        ("measurement.step_diagonal.material.x", AxisMaterial::KEYS),
        ("measurement.uncertainty", StatedUncertainty::KEYS),
        ("compensation", Compensation::KEYS),
        ("compensation.axes.x", AxisSettings::KEYS),
        ("limits", Limits::KEYS),
        ("acceptance", Acceptance::KEYS),
        ("program", ProgramRequest::KEYS),
        ("program", program::TargetKeys::KEYS),
    ];
    sections.into_iter().flat_map(|(path, keys): (&'static str, &'static [Option<Key>])| {
        keys.iter().flatten().map(move |key| (path, *key))
    })
}

/// The keys of a job, in the order in which it is read: an unknown one is told once.
const ROOT: [&str; 8] =
    ["schema", "machine", "measurement", "compensation", "limits", "acceptance", "program", "path"];

fn ask_for_all(section: &Section<'_>, find: impl Fn(&str) -> Result<Profile, Problems>) {
    let profile = section.text("controller").and_then(|word| {
        let refuse = |own: &Problem| {
            section.problem("controller", &own.message, own.help.clone().unwrap_or_default());
        };
        find(&word).map_err(|problems| problems.iter().for_each(refuse)).ok()
    });
    let Some(axes) = section.section("axes") else {
        return;
    };
    for axis in Axis::ALL {
        if let Some(section) = axes.section(axis.key()) {
            ask(&section, axis, profile.as_ref());
        }
    }
}

fn ask(section: &Section<'_>, axis: Axis, profile: Option<&Profile>) {
    let path = section.path();
    let chosen = ["spacing_mm", "points", "max_residual_um"];
    if !chosen.into_iter().any(|key| section.has(key)) {
        section.refuse("", without_grid(axis, path));
    }
    let counts = profile.filter(|profile| profile.detection_unit_required.value);
    if let Some(profile) = counts.filter(|_| !section.has("detection_unit_um")) {
        section.refuse("", without_unit(path, &profile.name));
    }
}

// A second job that states only in what it differs from the first: the TOML of one over that of the other.

/// What was measured or noted on one day belongs to that day: a second job never takes it from the first.
const OF_THE_DAY: [&str; 9] = [
    "date",
    "instrument",
    "protocol",
    "angles",
    "squareness_um_per_m",
    "active_while_measuring",
    "active_terms_not_measured",
    "active_reference",
    "active_backlash_um",
];
/// Likewise in `[measurement.step_diagonal]`.
const OF_THE_RUN: [&str; 3] = ["linear", "beam", "material"];

/// Takes from the job below what a page does not state; a list is taken whole. Errors and readings exclude each
/// other, so whoever states one takes nothing of the other.
fn lay_over<'a>(own: &mut DeTable<'a>, mut below: DeTable<'a>) {
    if let Some(measured) = own.get("measurement").and_then(|m| m.get_ref().as_table())
        && let Some(DeValue::Table(first)) = below.get_mut("measurement").map(|m| m.get_mut())
    {
        let others: &[&str] = match measured.contains_key("errors") {
            true => &["readings", "step_diagonal"],
            false if measured.contains_key("readings") => &["errors"],
            false => &[],
        };
        others.iter().chain(&OF_THE_DAY).for_each(|key| _ = first.remove(*key));
        if let Some(DeValue::Table(run)) = first.get_mut("step_diagonal").map(|run| run.get_mut()) {
            OF_THE_RUN.iter().for_each(|key| _ = run.remove(*key));
        }
    }
    take_missing(own, below);
}

fn take_missing<'a>(own: &mut DeTable<'a>, below: DeTable<'a>) {
    for (key, value) in below {
        let name: &str = key.get_ref();
        match own.get_mut(name).map(toml::Spanned::get_mut) {
            None => _ = own.insert(key, value),
            Some(DeValue::Table(own)) => {
                if let DeValue::Table(below) = value.into_inner() {
                    take_missing(own, below);
                }
            }
            Some(_) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A second job that states nothing but its readings takes the set-up of the first, nothing of its day.
    #[test]
    fn what_belongs_to_a_day_is_not_taken_over() {
        let day = OF_THE_DAY.map(|key| format!("{key} = 1\n")).concat();
        let run = OF_THE_RUN.map(|key| format!("{key} = 1\n")).concat();
        let first =
            format!("[measurement]\nnoise = 1\n{day}[measurement.step_diagonal]\nsteps = 4\n{run}");
        let below = DeTable::parse(&first).unwrap().into_inner();
        let mut own = DeTable::parse("[measurement]\nreadings = 'b.csv'").unwrap().into_inner();
        lay_over(&mut own, below);
        let measured = own.get("measurement").unwrap().get_ref().as_table().unwrap();
        let mut keys: Vec<&str> = measured.keys().map(|key| key.get_ref().as_ref()).collect();
        keys.sort_unstable();
        assert_eq!(keys, ["noise", "readings", "step_diagonal"]);
        let run = measured["step_diagonal"].get_ref().as_table().unwrap();
        assert_eq!(run.len(), 1, "only `steps` is taken over: {run:?}");
    }
}
