//! A visit after an earlier one: its job and its tables once more, without what belonged to that day.

use super::{Begun, COMMENTS, error_table, quoted, table_name};
use crate::control::controller::JobKey;
use crate::inputs::error_table::{ErrorTable, Kind, Series};
use crate::inputs::job::{ActiveTables, Job, Linear, LinearSlope, UseOf};
use crate::kit::refusals;
use crate::quantity::{Axis, Plane};
use crate::read::file_name;
use crate::text::{Problems, Source, header_and_rows, line};
use std::ops::Range;

/// Decisions and values of the earlier day that a new kit may not take over unseen.
const OF_THE_DAY: [&str; 3] =
    ["active_terms_not_measured", "active_reference", "active_backlash_um"];

/// What the earlier visit left.
pub struct Earlier<'a> {
    /// Its job, that of its kit.
    pub job: &'a Job,
    /// The errors that it measured, or its readings.
    pub measured: TableToFill,
    /// The key of the job that places tables in the control; `None` = files are replaced.
    pub place: Option<&'static str>,
    /// The key of the backlash parameters, of a control of which no file holds them.
    pub backlash: Option<&'a JobKey>,
    /// What is active now as the new job names it: its kit, or what was read out; empty where none is known.
    pub kit: String,
    /// What was read out of the control for keys of the job.
    pub held: Vec<(String, String)>,
}

/// A table that is measured once more.
pub enum TableToFill {
    /// All error tables in one.
    Errors(Box<ErrorTable>),
    /// The file of readings.
    Readings(Source),
}

impl Earlier<'_> {
    /// The new visit; `rebased` = a path of the job as the new one names it.
    pub fn again(&self, rebased: impl Fn(&str) -> String) -> Result<Begun, Problems> {
        let table = match &self.measured {
            TableToFill::Errors(table) => (false, positions(table)),
            TableToFill::Readings(source) => (true, emptied(source)),
        };
        let how = self.job.measurement.diagonals();
        let key = |linear: &Linear| linear.axis.key();
        let linear: Option<Vec<&str>> = how.map(|how| how.linear.iter().map(key).collect());
        let steps = how.and_then(|how| u32::try_from(how.volume.steps).ok());
        let programs = table.0 && self.job.program.is_some();
        let job = self.page(table_name(table.0), rebased)?;
        Ok(Begun::of(job, table, linear.as_deref(), programs, steps)?)
    }

    /// The job, with its comments.
    fn page(&self, name: &str, rebased: impl Fn(&str) -> String) -> Result<String, Problems> {
        let (job, kit) = (self.job, quoted(&self.kit));
        let mut page = PageEdits { source: &job.source, changes: Vec::new() };
        let data = match &self.measured {
            TableToFill::Errors(_) => "measurement.errors",
            TableToFill::Readings(_) => "measurement.readings",
        };
        page.remove("measurement.active_while_measuring", "active_while_measuring");
        page.insert_above(data, format!("active_while_measuring = {kit}\n"));
        self.state_place(&mut page);
        for (key, value) in &self.held {
            let (section, name) = key.rsplit_once('.').unwrap_or(("", key));
            if !page.set(key, value.clone()) {
                // Beside one that every job states there.
                let own = if section == "compensation" { "controller" } else { "reference_mm" };
                page.insert_above(&format!("{section}.{own}"), format!("{name} = {value}\n"));
            }
        }
        page.set(data, quoted(name));
        page.set("measurement.date", quoted(""));
        page.set("measurement.instrument", quoted(""));
        for key in OF_THE_DAY {
            page.remove(&format!("measurement.{key}"), key);
        }
        if let Some(JobKey { key, text, .. }) = self.backlash {
            let line = format!("{key} = {}", quoted(""));
            page.insert_above(data, format!("{line:<COMMENTS$} # {text}\n"));
        }
        for plane in Plane::ALL {
            page.set(&format!("measurement.squareness_um_per_m.{}", plane.key()), quoted(""));
        }
        if let Some(angles) = &job.measurement.angles {
            page.set("measurement.angles", quoted(&rebased(angles)));
        }
        let controller = &job.compensation.controller;
        if controller.contains(['/', '\\', '.']) {
            page.set("compensation.controller", quoted(&rebased(controller)));
        }
        self.empty_run(&mut page);
        let head = format!(
            "# Begun from {}: \"\" is to be filled in, and the empty cells of {name}.\n",
            line(&job.source.name)
        );
        self.checked(head + &page.text())
    }

    /// The key that decides whether the new tables lie in the place of the old ones.
    fn state_place(&self, page: &mut PageEdits<'_>) {
        let compensation = &self.job.compensation;
        let (key, as_before) = match self.place {
            Some("first_table") => ("first_table", compensation.first_table.unwrap_or(0)),
            Some("first_set") => ("first_set", compensation.first_set.unwrap_or(1)),
            _ => return,
        };
        page.remove(&format!("compensation.{key}"), key);
        let line = format!("{key} = {as_before}");
        let words = "as before: the tables of the old kit are replaced; with the first free number they stay in the control, and must be off";
        page.insert_above("compensation.controller", format!("{line:<COMMENTS$} # {words}\n"));
    }

    /// Slopes and temperatures of the earlier run.
    fn empty_run(&self, page: &mut PageEdits<'_>) {
        const RUN: &str = "measurement.step_diagonal";
        let Some(how) = self.job.measurement.diagonals() else {
            return;
        };
        for (index, linear) in how.linear.iter().enumerate() {
            let key = |key: &str| format!("{RUN}.linear[{index}].{key}");
            page.set(&key("slope_um_per_m"), quoted(""));
            if let LinearSlope::Errors(path) = &linear.slope {
                page.set(&key("errors"), quoted(file_name(path)));
            }
        }
        for index in 0..how.beams.len() {
            page.set(&format!("{RUN}.beam[{index}].slope_um_per_m"), quoted(""));
        }
        for axis in Axis::ALL {
            page.set(&format!("{RUN}.material.{}.temperature_c", axis.key()), quoted(""));
        }
    }

    /// A page that was laid out in a way that nobody foresaw is not changed by halves.
    fn checked(&self, text: String) -> Result<String, Problems> {
        let read = Source::from_bytes("job.toml", text.as_bytes())
            .and_then(|source| Job::read_for(source, UseOf::Begun));
        let expected = ActiveTables::Path(self.kit.clone());
        let is_new = |job: &Job| {
            let mut of_the_day = job.measurement.active_settings.backlash_um.iter();
            let is_kit = self.kit.is_empty() || job.measurement.active == expected;
            is_kit && of_the_day.all(|(_, um)| um.is_none())
        };
        match read {
            Ok(job) if is_new(&job) => Ok(text),
            Err(problems) if !self.held.is_empty() => Err(problems),
            _ => Err(refusals::other_layout(&self.job.source.name).into()),
        }
    }
}

/// Changes of a text, by the places of its keys.
struct PageEdits<'a> {
    source: &'a Source,
    changes: Vec<(Range<usize>, String)>,
}

impl PageEdits<'_> {
    /// Writes another value where the key is stated.
    fn set(&mut self, key: &str, value: String) -> bool {
        let span = self.source.span_of(key);
        self.changes.extend(span.clone().map(|span| (span, value)));
        span.is_some()
    }

    /// The line in which the value of a key begins.
    fn line(&self, key: &str) -> Option<Range<usize>> {
        let span = self.source.span_of(key)?;
        let text = &self.source.text;
        let start = text[..span.start].rfind('\n').map_or(0, |end| end + 1);
        let end = text[span.end..].find('\n').map_or(text.len(), |end| span.end + end + 1);
        Some(start..end)
    }

    fn insert_above(&mut self, key: &str, line: String) {
        let start = self.line(key).map(|line| line.start..line.start);
        self.changes.extend(start.map(|start| (start, line)));
    }

    /// Leaves out the line of a key.
    fn remove(&mut self, path: &str, key: &str) {
        let line = self.line(path);
        let is_own = |line: &Range<usize>| {
            let text = self.source.text[line.clone()].trim_start();
            text.trim_start_matches(['"', '\'']).starts_with(key)
        };
        self.changes.extend(line.filter(is_own).map(|line| (line, String::new())));
    }

    fn text(mut self) -> String {
        self.changes.sort_by_key(|(span, _)| span.start);
        let mut text = self.source.text.clone();
        for (span, value) in self.changes.into_iter().rev() {
            text.replace_range(span, &value);
        }
        text
    }
}

/// The measured positions of a table, without values.
fn positions(table: &ErrorTable) -> String {
    let all = || Axis::ALL.into_iter().flat_map(|axis| table.series(axis));
    let is_angle = |kind: &Kind| matches!(kind, Kind::Angle(_));
    let has_angles = |series: &Series| series.values.keys().any(is_angle);
    let are_directed = all().any(|series| series.direction.is_some());
    error_table(all().any(has_angles), are_directed, |axis, way| {
        let own = table.series(axis).iter().filter(|series| series.direction == way);
        let mut mm: Vec<f64> = own.flat_map(|s| s.positions.iter().map(|p| p.mm())).collect();
        mm.sort_by(f64::total_cmp);
        mm.dedup();
        mm
    })
}

/// The rows of readings, without values.
fn emptied(source: &Source) -> String {
    const PLACE: [&str; 5] = ["diagonal", "run", "direction", "node", "moved"];
    let Some((header, rows)) = header_and_rows(source) else {
        return String::new();
    };
    let names = header.cells();
    let separator = char::from(header.delimiter()).to_string();
    let row = |cells: Vec<std::borrow::Cow<'_, str>>| {
        let kept = names.iter().zip(cells);
        let kept = kept.map(|(name, cell)| if PLACE.contains(&&**name) { cell } else { "".into() });
        kept.collect::<Vec<_>>().join(&separator)
    };
    let rows = rows.iter().map(|line| row(line.cells()));
    std::iter::once(names.join(&separator)).chain(rows).collect::<Vec<_>>().join("\n") + "\n"
}
