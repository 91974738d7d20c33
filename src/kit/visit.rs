//! What a visit begins with: a job with the keys that its control needs, and the table to be filled in.
//!
//! ```text
//!  profile: [[job]] ─→ lines of the job ─→ templates/job.toml.tera ─→ job.toml
//!  travel, steps    ─→ positions or nodes ─→ errors.csv or readings.csv, values empty
//!                                         ─→ after.csv: the same once more, with the tables active
//!  readings         ─→ templates/after.toml.tera ─→ after.toml: in what the second measurement differs
//! ```
//! What only a person at the machine knows stays empty, and is refused until it is filled in.

mod again;

pub use self::again::{Earlier, TableToFill};

use crate::control::controller::{JobKey, JobSection, Profile};
use crate::inputs::job::keys;
use crate::kit::refusals;
use crate::quantity::pitch::{self, DIGIT_MM};
use crate::quantity::{Axis, Diagonal, Direction, Figure, Millimetres, Pass, PerAxis};
use crate::text::{Problem, Problems, joined};
use crate::write::emit::{TOOL, filled};
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// The name of the job.
pub const JOB: &str = "job.toml";
/// The table of the second measurement.
pub const AFTER: &str = "after.csv";
/// The job of the second measurement, where it is one of readings.
pub const AFTER_JOB: &str = "after.toml";
/// The directory of the kit.
pub const KIT: &str = "kit";
/// Longest step of the axis that travels farthest, mm, while [`STEPS`] allow it: a period of 100 mm still shows.
const LONGEST_STEP_MM: f64 = 50.0;
/// Fewest and most steps that nobody asked for.
const STEPS: [u32; 2] = [10, 30];
/// What a box of diagonals leaves of the travel at each end at least, mm: the preload and the overrun of a
/// measuring run have 2 mm, and software limits may lie a little before the ends.
const MARGIN_MM: f64 = 4.0;
/// Steps more that are proposed at most so that targets show periodic errors.
const MORE_STEPS: u32 = 5;
/// Share of the travel that a box keeps at least when its steps are made shorter for that: a verdict needs 0.9.
const LEAST: f64 = 0.92;
/// Column of a job in which comments begin.
const COMMENTS: usize = 35;

/// What is asked for.
pub struct Visit<'a> {
    /// The control.
    pub profile: &'a Profile,
    /// How the job names it.
    pub controller: &'a str,
    /// Ends of the travel of each axis, mm.
    pub travel: PerAxis<(f64, f64)>,
    /// Whether they were given in inches: so are the digits of the control.
    pub inches: bool,
    /// Number of equal steps of each axis.
    pub steps: Option<u32>,
    /// Readings of the body diagonals instead of errors.
    pub readings: bool,
    /// Values of both directions of travel.
    pub both_directions: bool,
}

/// The files of a visit that was begun.
pub struct Begun {
    /// The job.
    pub job: String,
    /// The files beside it, with their names.
    pub tables: Vec<(String, String)>,
    /// The one that is filled in first.
    pub measured: &'static str,
    /// Whether it is a visit of readings.
    pub readings: bool,
    /// Whether the control has part programs of the run.
    pub programs: bool,
    /// Number of equal steps of each axis; `None` where the positions are those of an earlier table.
    pub steps: Option<u32>,
}

impl Begun {
    /// Of a job and its table, which is measured once more with the tables active: by a job of its own where these
    /// axes have a linear measurement.
    fn of(
        job: String,
        (readings, table): (bool, String),
        linear: Option<&[&str]>,
        programs: bool,
        steps: Option<u32>,
    ) -> Result<Begun, Problem> {
        let (measured, again) = (table_name(readings), format!("{AGAIN}{table}"));
        let mut tables = vec![(measured.to_string(), table), (AFTER.to_string(), again)];
        if let Some(axes) = linear {
            let context = json!({ "job": JOB, "data": AFTER, "kit": KIT, "axes": axes });
            tables.push((AFTER_JOB.to_string(), filled("after.toml.tera", &context)?));
        }
        Ok(Begun { job, tables, measured, readings, programs, steps })
    }

    /// What `verify --after` takes.
    pub const fn after(&self) -> &'static str {
        if self.readings { AFTER_JOB } else { AFTER }
    }
}

impl Visit<'_> {
    /// Its files.
    pub fn begun(&self) -> Result<Begun, Problems> {
        let axes = Axis::ALL.map(Axis::key);
        let linear = self.readings.then_some(&axes[..]);
        let table = if self.readings { self.nodes() } else { self.positions() };
        let (table, programs) = ((self.readings, table), self.has_programs());
        Ok(Begun::of(self.job()?, table, linear, programs, Some(self.steps()))?)
    }

    /// Steps of each axis: as asked for, else no longer than 50 mm where 30 are enough.
    fn steps(&self) -> u32 {
        let longest = Axis::ALL.map(|axis| self.length(axis)).into_iter().fold(0.0, f64::max);
        let [fewest, most] = STEPS;
        let usual = (fewest..most).find(|n| longest <= LONGEST_STEP_MM * f64::from(*n));
        self.steps.or(usual).unwrap_or(most)
    }

    /// A few steps more over the same travel, by which targets would show periodic errors of more pitches; `None` where
    /// nothing is gained, and where a box has its size for that.
    pub fn better_steps(&self) -> Option<u32> {
        let seen = |n: &u32| -> usize {
            let steps = Axis::ALL.map(|axis| self.length(axis) / f64::from(*n));
            steps.into_iter().map(|mm| pitch::seen(mm, *n)).sum()
        };
        let own = self.steps();
        let best = (own..=own + MORE_STEPS).rev().max_by_key(seen);
        best.filter(|best| !self.readings && seen(best) > seen(&own))
    }

    fn length(&self, axis: Axis) -> f64 {
        let (low, high) = self.travel[axis];
        high - low
    }

    /// Whether the control has part programs of the run.
    fn has_programs(&self) -> bool {
        self.readings && self.profile.program.is_some()
    }

    /// The job.
    fn job(&self) -> Result<String, Problems> {
        if self.profile.job_keys.is_empty() {
            return Err(refusals::no_job_keys(&self.profile.id).into());
        }
        let axes = Axis::ALL.map(|axis| OfAxis {
            name: axis.key(),
            machine: self.lines(JobSection::MachineAxes, Some(axis)),
            compensation: self.lines(JobSection::CompensationAxes, Some(axis)),
        });
        let has_points = self.profile.job_keys.iter().all(|key| key.key != "spacing_mm");
        let [start, size] = if self.readings { self.box_of_run()? } else { Default::default() };
        let context = json!({
            "tool": TOOL,
            "words": words(),
            "controller": { "name": self.profile.name, "quoted": quoted(self.controller) },
            "data": table_name(self.readings),
            "readings": self.readings,
            "both": self.both_directions,
            "program": self.has_programs(),
            "measurement": self.lines(JobSection::Measurement, None),
            "compensation": self.lines(JobSection::Compensation, None),
            "axes": axes,
            "steps": self.steps().to_string(),
            "points": if has_points { (self.steps() + 1).to_string() } else { String::new() },
            "start": start,
            "size": size,
        });
        Ok(filled("job.toml.tera", &context)?)
    }

    /// The lines of the profile's keys in one section.
    fn lines(&self, section: JobSection, axis: Option<Axis>) -> Vec<String> {
        let keys = self.profile.job_keys.iter().filter(|key| key.section == section);
        keys.map(|key| self.line(key, axis)).collect()
    }

    fn line(&self, own: &JobKey, axis: Option<Axis>) -> String {
        let JobKey { key, example, value, text, .. } = own;
        let value = match (value, example, axis) {
            (Some(value), ..) => format!("{key} = {value}"),
            (_, Some(example), _) => format!("# {key} = {example}"),
            (.., Some(axis)) if key == "travel_mm" => {
                let (low, high) = self.travel[axis];
                format!("{key} = [{}, {}]", millimetres(low), millimetres(high))
            }
            _ => format!("{key} = \"\""),
        };
        format!("{value:<COMMENTS$} # {text}")
    }

    /// Start and size of the box of the diagonals: the largest with equal steps that keeps the margin.
    fn box_of_run(&self) -> Result<[String; 2], Problem> {
        let (steps, digit_mm) = (f64::from(self.steps()), DIGIT_MM[usize::from(self.inches)]);
        let step = |axis| {
            let length = self.length(axis);
            let [shortest, longest] = [LEAST * length, length - 2.0 * MARGIN_MM];
            pitch::step_mm(shortest / steps, longest / steps, self.steps(), digit_mm)
        };
        if let Some(short) = Axis::ALL.into_iter().find(|axis| step(*axis) <= 0.0) {
            let length = millimetres(self.length(short));
            return Err(refusals::short_travel(short, length, steps));
        }
        let size = |axis| step(axis) * steps;
        let start = |axis| {
            let mm = self.travel[axis].0 + (self.length(axis) - size(axis)) / 2.0;
            if self.inches { (mm / digit_mm).floor() * digit_mm } else { mm }
        };
        let one = |axis: Axis, mm| format!("{} = {}", axis.key(), millimetres(mm));
        let place = |of: &dyn Fn(Axis) -> f64| joined(Axis::ALL.map(|axis| one(axis, of(axis))));
        Ok([place(&start), place(&size)])
    }

    /// The error table with its values empty.
    fn positions(&self) -> String {
        let at = |axis, step| {
            let part = self.length(axis) * f64::from(step) / f64::from(self.steps());
            self.travel[axis].0 + part
        };
        error_table(false, self.both_directions, |axis, way| {
            let is_own = way.is_some() == self.both_directions;
            (0..=self.steps()).filter(|_| is_own).map(|step| at(axis, step)).collect()
        })
    }

    /// The same of the readings.
    fn nodes(&self) -> String {
        let last = 3 * self.steps();
        let forward = (0..=last).map(|node| (Pass::Forward, node));
        let back = (0..=last).rev().map(|node| (Pass::Reverse, node));
        let back = back.filter(|_| self.both_directions);
        let nodes: Vec<(Pass, u32)> = forward.chain(back).collect();
        let mut text = READINGS.to_string();
        for diagonal in Diagonal::ALL {
            for (pass, node) in &nodes {
                let moved = ["z", "x", "y"][*node as usize % 3];
                let moved = if *node == 0 { "" } else { moved };
                text.push_str(&format!("{diagonal},{},{node},{moved},\n", pass.word()));
            }
        }
        text
    }
}

/// The lines of a job that an axis has of its own.
#[derive(Serialize)]
struct OfAxis {
    name: &'static str,
    machine: Vec<String>,
    compensation: Vec<String>,
}

/// An error table without values: rows for the positions of each axis, mm, in each way.
fn error_table(
    has_angles: bool,
    are_directed: bool,
    mm: impl Fn(Axis, Option<Direction>) -> Vec<f64>,
) -> String {
    let (angles, cells) = if has_angles { (",ea_urad,eb_urad,ec_urad", ",,,") } else { ("", "") };
    let direction = if are_directed { ",direction" } else { "" };
    let mut text = format!("{ERRORS}axis,position_mm,ex_um,ey_um,ez_um{angles}{direction}\n");
    for axis in Axis::ALL {
        for way in [None, Some(Direction::Plus), Some(Direction::Minus)] {
            let sign = way.map_or("", Direction::symbol);
            let sign = if are_directed { format!(",{sign}") } else { String::new() };
            text.extend(mm(axis, way).into_iter().map(|mm| {
                let mm = millimetres(mm);
                format!("{},{mm},,,{cells}{sign}\n", axis.key())
            }));
        }
    }
    text
}

/// What the keys of a job say, by the last name of their section and by key.
fn words() -> BTreeMap<&'static str, BTreeMap<&'static str, &'static str>> {
    let mut all = BTreeMap::<_, BTreeMap<_, _>>::new();
    for (section, key) in keys() {
        let section = section.rsplit('.').next().unwrap_or(section);
        all.entry(section).or_default().insert(key.name, key.words.trim_start());
    }
    all
}

/// The name of the table that is filled in first.
const fn table_name(readings: bool) -> &'static str {
    if readings { "readings.csv" } else { "errors.csv" }
}

const AGAIN: &str = "\
# second measurement, with the tables of the kit active
";

const ERRORS: &str = "\
# deviation = actual - commanded, micrometres, at machine coordinates
# ex_um of the rows of x is its positioning error, ey_um and ez_um its straightness; what was not measured stays empty in all rows of an axis
";

const READINGS: &str = "\
# displacement along the laser as it was read at each node, millimetres, growing on the way out; 0 at node 0
diagonal,direction,node,moved,displacement_mm
";

/// A position or length as it is written in a job.
fn millimetres(mm: f64) -> String {
    Figure(Millimetres::new(mm).shown()).to_string()
}

/// A text of a TOML page.
fn quoted(text: &str) -> String {
    Value::from(text).to_string()
}
