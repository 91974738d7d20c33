//! Figures of the body diagonals: of a job with readings, or of readings alone.

use super::axis::{conditions, likely_words, missed};
use crate::cli::diagonals::{StandardFigures, diagonal_json, named_um};
use crate::cli::outcome::{Outcome, PlotOnly, Print, joined};
use crate::cli::screen::{Screen, paragraphs, table};
use crate::cli::show::{self, um};
use crate::inputs::readings::Readings;
use crate::machine::findings::StandardFinding;
use crate::machine::separation::Separation;
use crate::machine::standards::{DIAGONALS, Diagonals};
use crate::page::{Locale, Picture};
use crate::quantity::{Direction, PathKind, Run};
use crate::text::{Finding, Problems, Source};
use crate::visit::campaign::read_campaign;
use crate::visit::files::Files;
use serde_json::{Map, Value, json};
use std::path::Path;

/// Words for the lower edge of a picture, by their key.
const ALONG: &str = "along_diagonal";
const ALONG_STEPS: &str = "along_diagonal_steps";

/// Figures of the readings that a job names.
pub(super) fn of_job(
    on: &dyn Files,
    path: &Path,
    print: Print,
    plot: &PlotOnly,
) -> Result<Outcome, Problems> {
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
    let figures = StandardFigures::of(&measurement.volume, measurement.kind, &runs, true)?;
    let page = Page {
        name: &measurement.readings,
        across: ALONG,
        notes: notes(all > runs.len()).into_iter().chain(files.readings.zeroed()).collect(),
        figures,
    };
    page.outcome(print, plot)
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
        figures: StandardFigures::of(&separation.volume, PathKind::Step, runs, true)?,
    };
    let heading = locale.words("readings_corrected");
    Ok((page.document(), page.picture(locale, &heading)))
}

/// Figures of readings alone: those that the box has no part in.
pub(super) fn of_readings(
    source: Source,
    print: Print,
    plot: &PlotOnly,
) -> Result<Outcome, Problems> {
    let name = source.name.clone();
    let (readings, volume, kind) = Readings::without_job(source)?;
    let known = readings.runs.iter().cloned();
    let known: Vec<Run> = known.filter(|run| readings.offset_known(run)).collect();
    let mut notes = notes(known.len() < readings.runs.len());
    notes.extend(readings.zeroed());
    notes.push(StandardFinding::NoJob.into());
    let figures = StandardFigures::of(&volume, kind, &known, false)?;
    let name = &name;
    let page = Page { name, across: ALONG_STEPS, notes, figures };
    page.outcome(print, plot)
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
    figures: StandardFigures,
    notes: Vec<Finding>,
}

impl Page<'_> {
    fn outcome(&self, print: Print, plot: &PlotOnly) -> Result<Outcome, Problems> {
        let outcome = print.outcome(|| self.screen(), || self.document())?;
        plot.beside(outcome, |locale| self.picture(locale, self.name))
    }

    fn picture(&self, locale: Locale<'_>, heading: &str) -> Picture {
        let across = locale.words(self.across);
        self.figures.picture(locale, heading, &across)
    }

    fn screen(&self) -> Screen {
        let runs = self.figures.runs.iter().map(|(name, runs)| {
            let [up, down] = Direction::BOTH.map(|way| runs.count(way));
            format!("{name} {up} up, {down} down")
        });
        let all = &self.figures.all;
        let rows = machine_figures(all).map(|(name, what, figure)| {
            let letter = if name.ends_with("_d") { name } else { "" };
            format!("{letter}\t{what}\t{}", um(figure))
        });
        let heading = format!("conditions of ISO 230-6 ({})", likely_words(DIAGONALS));
        Screen {
            verdict: format!(
                "{} - body diagonals, runs: {}\nfigures in the style of ISO 230-6:2002 and ASME B5.54\n{}",
                self.name,
                runs.collect::<Vec<_>>().join("; "),
                all.label
            ),
            figures: paragraphs(&[self.figures.table(), table("figure\t\t>value/µm", rows)]),
            findings: [missed(&all.conditions), show::notes(&self.notes)].concat(),
            more: vec![conditions(&heading, &all.conditions)],
            ..Screen::default()
        }
    }

    fn document(&self) -> Value {
        let all = &self.figures.all;
        let diagonals = self.figures.each();
        let diagonals =
            diagonals.map(|(name, runs, of)| (name.to_string(), diagonal_json(runs, of)));
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
