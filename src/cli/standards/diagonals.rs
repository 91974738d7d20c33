//! Figures of the body diagonals: of a job with readings, or of readings alone.

use super::document::{conditions_json, insert};
use super::text::{conditions_table, likely_words, micrometres};
use crate::cli::outcome::Outcome;
use crate::cli::show::{Column, paragraphs, table};
use crate::cli::{Format, inputs};
use crate::inputs::job::{DiagonalMeasurement, Frame, Reflector, SetUp};
use crate::inputs::readings::Readings;
use crate::inputs::target_runs::Runs;
use crate::machine::separation::diagonal_runs::diagonal_runs;
use crate::machine::separation::noise::CorrectedRun;
use crate::machine::standards::iso_230_2::AxisFigures;
use crate::machine::standards::{
    DIAGONALS, DiagonalFigures, DiagonalMotion, Diagonals, diagonal, diagonal_of_unknown_length,
};
use crate::quantity::axis::{Axis, Direction, PerAxis};
use crate::quantity::diagonal::{Diagonal, PathKind, Volume};
use crate::quantity::units::Millimetres;
use crate::text::delimited::header_and_rows;
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems};
use serde_json::{Map, Value, json};
use std::path::Path;

/// Figures of the readings that a job names.
pub(super) fn of_job(path: &Path, format: Format) -> Result<Outcome, Problems> {
    let files = inputs::read_campaign(path)?;
    let measurement = &files.measurement;
    let (runs, all) = match measurement.kind {
        PathKind::Step => {
            let separation = files.separate()?;
            let all = separation.runs.len();
            (separation.zeroed_runs, all)
        }
        PathKind::Straight => {
            let runs = files.straight()?.runs;
            let all = runs.len();
            (runs, all)
        }
    };
    let runs = Measured::of(&measurement.volume, measurement.kind, &runs)?;
    let figures = diagonal(&runs.named(), motion(measurement.kind));
    let notes = notes(all > runs.count());
    runs.show(&measurement.readings, &figures, &notes, format)
}

/// Figures of readings alone: those that the box has no part in.
pub(super) fn of_readings(source: Source, format: Format) -> Result<Outcome, Problems> {
    let name = source.name.clone();
    let measurement = without_job(&source)?;
    let readings = Readings::read(source, &measurement)?;
    let known = readings
        .runs
        .iter()
        .filter(|run| readings.offset_known(run));
    let known: Vec<CorrectedRun> = known
        .map(|run| CorrectedRun {
            diagonal: run.diagonal,
            number: run.number,
            pass: run.pass,
            readings_um: run.deviations.iter().map(|of| of.um()).collect(),
        })
        .collect();
    let dropped = known.len() < readings.runs.len();
    let runs = Measured::of(&measurement.volume, measurement.kind, &known)?;
    let figures = diagonal_of_unknown_length(&runs.named(), motion(measurement.kind));
    let mut notes = notes(dropped);
    notes.push("no job: the readings are taken to be positive along the forward run (`laser_sign = \"+\"`), and nothing is corrected; give the job instead of the readings if that is not so".to_string());
    runs.show(&name, &figures, &notes, format)
}

const fn motion(kind: PathKind) -> DiagonalMotion {
    match kind {
        PathKind::Step => DiagonalMotion::StepDiagonalCellEnds,
        PathKind::Straight => DiagonalMotion::StraightRuns,
    }
}

fn notes(dropped: bool) -> Vec<String> {
    let mut notes =
        vec!["up = the forward run, in the direction of the diagonal's name".to_string()];
    if dropped {
        notes.push("runs under the names of reverse runs (NNN …) are left out: their offset to the forward runs is not known".to_string());
    }
    notes
}

// ---------------------------------------------------------------------------------------------
// Readings without a job

/// What readings say themselves of how they were measured. The box is not among it, so a box of
/// unit cells takes its place, and no figure that depends on it is made.
fn without_job(source: &Source) -> Result<DiagonalMeasurement, Problems> {
    let (header, lines) = header_and_rows(source).ok_or_else(|| {
        Problem::new(format!("`{}` holds no readings", source.name))
            .help("first line: diagonal,run,direction,node,moved,deviation_um")
    })?;
    let cells = header.cells();
    let at = |name: &str| cells.iter().position(|cell| cell == name);
    if let Some(index) = cells.iter().position(|c| c.starts_with("displacement_")) {
        return Err(Problem::new(
            "the readings are displacements: their deviations need the box, which stands in the job",
        )
        .at(header.cell_place(index))
        .help("give the job instead: `nonius standards job.toml`")
        .into());
    }
    let (node, moved) = (at("node"), at("moved"));
    let nodes: Vec<(usize, Option<Axis>)> = lines
        .iter()
        .filter_map(|line| {
            let cells = line.cells();
            let node = cells.get(node?)?.parse().ok()?;
            let moved = moved.and_then(|at| cells.get(at));
            Some((node, moved.and_then(|cell| Axis::from_letter(cell))))
        })
        .collect();
    let last = nodes.iter().map(|(node, _)| *node).max().unwrap_or(0);
    let is_step = nodes.iter().any(|(_, moved)| moved.is_some());
    let moved_to = |wanted: usize| nodes.iter().find(|(node, _)| *node == wanted)?.1;
    let order = [1, 2, 3].map(moved_to);
    let (kind, steps) = if is_step {
        (PathKind::Step, last.div_ceil(3))
    } else {
        (PathKind::Straight, last)
    };
    let edges = |mm: f64| PerAxis::from_fn(|_| Millimetres::new(mm));
    let steps = steps.max(1);
    let mut volume = Volume {
        start: edges(0.0),
        size: edges(1.0),
        steps,
        order: match order {
            [Some(first), Some(second), Some(third)] => [first, second, third],
            _ => Axis::ALL,
        },
    };
    volume.size = edges(volume.steps_f64());
    Ok(DiagonalMeasurement {
        readings: source.name.clone(),
        kind,
        volume,
        laser_sign: Direction::Plus,
        setup: SetUp::Solve,
        frame: Frame::XPrimary,
        target: Reflector::FlatMirror,
        overrun: None,
        linear: Vec::new(),
        beams: Vec::new(),
        material: None,
        closure_errors: None,
    })
}

// ---------------------------------------------------------------------------------------------
// Output

/// The runs of the four diagonals.
struct Measured(Vec<(&'static str, Runs)>);

impl Measured {
    fn of(volume: &Volume, kind: PathKind, runs: &[CorrectedRun]) -> Result<Measured, Problem> {
        let each = Diagonal::ALL.into_iter();
        let each = each.map(|d| Ok((d.name(), diagonal_runs(volume, kind, d, runs)?)));
        each.collect::<Result<_, Problem>>().map(Measured)
    }

    fn named(&self) -> Vec<(&str, &Runs)> {
        self.0.iter().map(|(name, runs)| (*name, runs)).collect()
    }

    fn count(&self) -> usize {
        let of = |runs: &Runs| {
            Direction::BOTH
                .map(|way| runs.count(way))
                .iter()
                .sum::<usize>()
        };
        self.0.iter().map(|(_, runs)| of(runs)).sum()
    }

    fn show(
        &self,
        name: &str,
        figures: &Diagonals,
        notes: &[String],
        format: Format,
    ) -> Result<Outcome, Problems> {
        match format {
            Format::Text => Ok(Outcome::text(&self.report(name, figures, notes))),
            Format::Json => Outcome::json(&self.document(figures, notes)),
        }
    }

    fn report(&self, name: &str, figures: &Diagonals, notes: &[String]) -> String {
        let runs: Vec<String> = self
            .0
            .iter()
            .map(|(name, runs)| {
                let count = |way| runs.count(way);
                let (up, down) = (count(Direction::Plus), count(Direction::Minus));
                format!("{name} {up} up, {down} down")
            })
            .collect();
        let notes: Vec<String> = notes.iter().map(|note| format!("note: {note}")).collect();
        paragraphs(&[
            format!("{name} - body diagonals, runs: {}", runs.join("; ")),
            format!(
                "figures in the style of ISO 230-6:2002 and ASME B5.54\n{}",
                figures.label
            ),
            figures_table(figures),
            machine_table(figures),
            notes.join("\n"),
            format!(
                "conditions of ISO 230-6 ({})\n{}",
                likely_words(DIAGONALS),
                conditions_table(&figures.conditions)
            ),
        ])
    }

    fn document(&self, figures: &Diagonals, notes: &[String]) -> Value {
        let mut diagonals = Map::new();
        for ((name, runs), of) in self.0.iter().zip(&figures.diagonals) {
            let entry = diagonal_json(runs, of);
            diagonals.insert((*name).to_string(), entry);
        }
        let mut part = Map::new();
        part.insert("confidence".into(), json!(DIAGONALS.word()));
        part.insert("label".into(), json!(figures.label));
        part.insert("diagonals".into(), Value::Object(diagonals));
        for (name, _, um) in machine_figures(figures) {
            insert(&mut part, name, um);
        }
        part.insert("conditions".into(), conditions_json(&figures.conditions));
        part.insert("notes".into(), json!(notes));
        json!({ "schema": 1, "iso_230_6": part })
    }
}

/// Every figure of a diagonal.
pub(in crate::cli) fn diagonal_json(runs: &Runs, of: &DiagonalFigures) -> Value {
    let count = |way| runs.count(way);
    let mut entry = Map::new();
    entry.insert("targets".into(), json!(runs.targets_mm().len()));
    entry.insert(
        "runs".into(),
        json!({ "up": count(Direction::Plus), "down": count(Direction::Minus) }),
    );
    for (letter, um) in of.figures.named_um() {
        insert(&mut entry, letter, um);
    }
    insert(&mut entry, "range", of.range_um);
    Value::Object(entry)
}

/// Figures of a diagonal in the order of the table.
const FIGURES: [(&str, &str); 12] = [
    ("E", "E"),
    ("E_up", "E up"),
    ("E_down", "E down"),
    ("M", "M"),
    ("B", "B"),
    ("B_mean", "B mean"),
    ("R", "R"),
    ("R_up", "R up"),
    ("R_down", "R down"),
    ("A", "A"),
    ("A_up", "A up"),
    ("A_down", "A down"),
];

/// Every figure of every diagonal; what no diagonal has gets no column.
pub(in crate::cli) fn figures_table(figures: &Diagonals) -> String {
    let figure = |of: &AxisFigures, wanted: &str| {
        let named = of.named_um().into_iter().find(|(name, _)| *name == wanted);
        named.and_then(|(_, um)| um)
    };
    let is_there = |(name, _): &(&str, &str)| {
        let mut all = figures.diagonals.iter();
        all.any(|of| figure(&of.figures, name).is_some())
    };
    let there: Vec<(&str, &str)> = FIGURES.into_iter().filter(is_there).collect();
    let mut columns = vec![Column::Left("diagonal, µm")];
    columns.extend(there.iter().map(|(_, heading)| Column::Right(heading)));
    columns.push(Column::Right("max - min"));
    let rows = figures.diagonals.iter().map(|of| {
        let each = there.iter();
        let each = each.map(|(name, _)| micrometres(figure(&of.figures, name)));
        let range = micrometres(of.range_um);
        let name = std::iter::once(of.name.clone());
        name.chain(each).chain([range]).collect()
    });
    table(&columns, rows)
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
        (
            "range_over_all",
            "ASME B5.54: max - min over all diagonals",
            figures.range_over_all_um,
        ),
    ]
}

fn machine_table(figures: &Diagonals) -> String {
    let columns = [
        Column::Left("figure"),
        Column::Left(""),
        Column::Right("value/µm"),
    ];
    let rows = machine_figures(figures);
    let rows = rows.map(|(name, what, um)| {
        let letter = if name.ends_with("_d") { name } else { "" };
        vec![letter.to_string(), what.to_string(), micrometres(um)]
    });
    table(&columns, rows)
}
