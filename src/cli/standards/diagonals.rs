//! Figures of the body diagonals: of a job with readings, or of readings alone.

use super::axis::{LIKELY, conditions, missed};
use crate::cli::diagonals::{by_standard, diagonal_json, named_um};
use crate::cli::outcome::{Outcome, Shows, joined};
use crate::cli::screen::{Screen, paragraphs, table};
use crate::cli::show::{self, um};
use crate::inputs::readings::Readings;
use crate::machine::findings::StandardFinding;
use crate::machine::separation::Separation;
use crate::machine::standards::{DIAGONALS, Diagonals};
use crate::page::{Locale, Picture};
use crate::quantity::{PathKind, Run};
use crate::text::{Finding, Problems, Source};
use crate::visit::campaign::read_campaign;
use crate::visit::files::Files;
use serde_json::{Map, Value, json};
use std::path::Path;

/// Words for the lower edge of a picture, by their key.
const ALONG: &str = "along_diagonal";
const ALONG_STEPS: &str = "along_diagonal_steps";

/// Figures of the readings that a job names.
pub(super) fn of_job(on: &dyn Files, path: &Path, shows: &Shows) -> Result<Outcome, Problems> {
    let files = read_campaign(on, path)?;
    let measurement = &files.measurement;
    let (runs, all) = match measurement.kind {
        PathKind::Step => {
            let separation = files.separate()?;
            (separation.zeroed_runs, separation.runs.len())
        }
        PathKind::Straight => {
            let runs = files.straight()?.runs;
            let all = runs.len();
            (runs, all)
        }
    };
    let figures = by_standard(&measurement.volume, measurement.kind, &runs, true)?;
    let page = Page {
        name: &measurement.readings,
        across: ALONG,
        notes: notes(all > runs.len()).into_iter().chain(files.readings.zeroed()).collect(),
        figures,
    };
    page.outcome(shows)
}

/// The document and the picture of readings that were separated.
pub(in crate::cli) fn of_separation(
    locale: Locale<'_>,
    readings: &str,
    separation: &Separation,
) -> Result<(Value, Picture), Problems> {
    let runs = &separation.zeroed_runs;
    let page = Page {
        name: readings,
        across: ALONG,
        notes: notes(separation.runs.len() > runs.len()),
        figures: by_standard(&separation.volume, PathKind::Step, runs, true)?,
    };
    let heading = locale.words("readings_corrected");
    Ok((page.document(), page.picture(locale, &heading)))
}

/// Figures of readings alone: those that the box has no part in.
pub(super) fn of_readings(source: Source, shows: &Shows) -> Result<Outcome, Problems> {
    let name = source.name.clone();
    let (readings, volume, kind) = Readings::without_job(source)?;
    let known = readings.runs.iter().cloned();
    let known: Vec<Run> = known.filter(|run| readings.offset_known(run)).collect();
    let mut notes = notes(known.len() < readings.runs.len());
    notes.extend(readings.zeroed());
    notes.push(StandardFinding::NoJob.into());
    let figures = by_standard(&volume, kind, &known, false)?;
    let name = &name;
    let page = Page { name, across: ALONG_STEPS, notes, figures };
    page.outcome(shows)
}

fn notes(dropped: bool) -> Vec<Finding> {
    let dropped = dropped.then_some(StandardFinding::ReverseNames);
    let notes = std::iter::once(StandardFinding::UpIsForward).chain(dropped);
    notes.map(Finding::from).collect()
}

struct Page<'a> {
    name: &'a str,
    /// Key of what stands at the lower edge of the picture.
    across: &'static str,
    figures: Diagonals,
    notes: Vec<Finding>,
}

impl Page<'_> {
    fn outcome(&self, shows: &Shows) -> Result<Outcome, Problems> {
        let picture = |locale: Locale<'_>| self.picture(locale, self.name);
        shows.outcome(|| self.screen(), || self.document(), picture)
    }

    fn picture(&self, locale: Locale<'_>, heading: &str) -> Picture {
        let across = locale.words(self.across);
        self.figures.picture(locale, heading, &across)
    }

    fn screen(&self) -> Screen {
        let all = &self.figures;
        let runs = all.diagonals.iter();
        let runs = runs.map(|of| format!("{} {} up, {} down", of.name, of.runs[0], of.runs[1]));
        let rows = machine_figures(all).map(|(name, what, figure)| {
            let letter = if name.ends_with("_d") { name } else { "" };
            format!("{letter}\t{what}\t{}", um(figure))
        });
        let heading = format!("conditions of ISO 230-6 ({LIKELY})");
        Screen {
            verdict: format!(
                "{} - body diagonals, runs: {}\nfigures in the style of ISO 230-6:2002 and ASME B5.54\n{}",
                self.name,
                runs.collect::<Vec<_>>().join("; "),
                all.label
            ),
            figures: paragraphs(&[all.table(), table("figure\t\t>value/µm", rows)]),
            findings: [missed(&all.conditions), show::notes(&self.notes)].concat(),
            more: vec![conditions(&heading, &all.conditions)],
            ..Screen::default()
        }
    }

    fn document(&self) -> Value {
        let all = &self.figures;
        let diagonals = all.diagonals.iter().map(|of| (of.name.clone(), diagonal_json(of)));
        let part = joined([
            json!({
                "confidence": DIAGONALS,
                "label": all.label,
                "diagonals": diagonals.collect::<Map<_, _>>(),
            }),
            named_um(machine_figures(all).map(|(name, _, um)| (name, um))),
            json!({ "conditions": { "list": all.conditions }, "notes": self.notes }),
        ]);
        json!({ "schema": 1, "iso_230_6": part })
    }
}

fn machine_figures(figures: &Diagonals) -> [(&'static str, &'static str, Option<f64>); 4] {
    [
        ("E_d", "largest E of the diagonals", figures.e_d_um),
        ("B_d", "largest B of the diagonals", figures.b_d_um),
        (
            "largest_range",
            "ASME B5.54: largest max - min of one diagonal",
            figures.largest_range_um,
        ),
        ("range_over_all", "ASME B5.54: max - min over all diagonals", figures.range_over_all_um),
    ]
}
