//! Renishaw static data (`.rtl`), linear.
//!
//! ```text
//!   TARGET DATA::  Target-count, Targets (mm), Flags
//!   RUNS::         Run-count: each direction counts as a run
//!   DEVIATIONS::   run  target  deviation (µm)
//! ```
//! A deviation belongs to the target whose number stands in its line; the order of the lines means
//! nothing. docs/import.md §2 names the sources.

use crate::inputs::error_table::{Component, Kind};
use crate::inputs::import::encoding::{Measurement, text_of};
use crate::inputs::import::findings::ImportFinding;
use crate::inputs::import::reading::{FileContents, Passes, Placing};
use crate::inputs::import::rtl_file::{File, Sections};
use crate::inputs::import::stated::{Format, Stated};
use crate::inputs::import::words::{Fields, Piece};
use crate::inputs::target_runs;
use crate::quantity::axis::{Axis, Direction};
use crate::text::delimited::plain_number;
use crate::text::document::{LARGEST_NUMBER, Source};
use crate::text::finding::Finding;
use crate::text::problem::{Problems, shown};

pub(super) fn read(source: &Source, stated: &Stated) -> Result<FileContents, Problems> {
    let mut problems = Problems::none();
    let term = stated.required_term(Format::Rtl, &mut problems);
    let sign = stated.required_sign(&mut problems);
    let Some((passes, mut said, of_runs)) = passes_of(source, stated, &mut problems) else {
        return Err(problems);
    };
    let unit = "deviations in µm, targets in mm (the format's)";
    said.find([ImportFinding::UnitOfFormat { unit }]);
    passes.reading((term, sign), said, of_runs, stated, problems)
}

/// Positioning is measured along the axis itself; which one it is changes no figure.
const POSITIONING: Component = Component { kind: Kind::Deviation(Axis::X), along: Axis::X };

/// Reads the single runs of a `.rtl` file, as a positioning test needs them (a mean holds no repeatability), and
/// what the file states: runs 1, 3, 5 … went from the first target to the last, even ones back, as the file's
/// flags or `--runs` say.
///
/// sign   deviation = actual − commanded in the sense of the machine's coordinate: where the file
///        counts its targets against the axis, deviations are turned with them
/// limits the targets keep the coordinates of the file: no figure depends on where they are
pub fn measured_runs(
    file: Measurement<'_>,
    stated_encoding: Option<&'static encoding_rs::Encoding>,
    stated: &Stated,
) -> Result<(target_runs::Runs, Vec<Finding>), Problems> {
    let (source, name) = text_of(file, stated_encoding, &Stated::default())?;
    let mut problems = Problems::none();
    let sign = stated.required_sign(&mut problems);
    let Some((passes, said, of_runs)) = passes_of(&source, stated, &mut problems) else {
        return Err(problems);
    };
    let placed =
        Stated { first_target_at_mm: first_target_mm(&passes.targets, stated), ..stated.clone() };
    let placing = Placing::of(&passes.targets, &passes.place, &placed, &mut problems);
    let (Some(sign), Some(placing)) = (sign, placing) else {
        return Err(problems);
    };
    let mut found = FileContents::saying([ImportFinding::Encoding { name }]);
    found.findings.extend(said.findings);
    found.find([ImportFinding::OwnZero]);
    found.find(placing.turned(POSITIONING));
    let is_of_means = |found: &ImportFinding| matches!(found, ImportFinding::Runs { .. });
    found.find(of_runs.into_iter().filter(|found| !is_of_means(found)));
    found.findings.sort_by_key(Finding::severity);
    let moving = |direction: Direction| {
        let mut ways = passes.ways.iter();
        let (_, runs) = ways.find(|(way, _)| placing.direction(*way) == Some(direction))?;
        let runs = runs.iter().map(|run| placing.deviations(run, POSITIONING, sign));
        let runs: Vec<Vec<f64>> = runs.collect();
        let at = |target: usize| runs.iter().map(|run| run[target]).collect();
        Some((0..passes.targets.len()).map(at).collect())
    };
    let (up, down) = (moving(Direction::Plus), moving(Direction::Minus));
    let targets_mm = placing.positions().iter().map(|target| target.mm()).collect();
    let runs = target_runs::Runs::new(targets_mm, up, down)?;
    problems.or_ok((runs, found.findings))
}

/// The coordinate of the first target: that of the file, mirrored at its zero where the file counts
/// against the axis.
fn first_target_mm(targets: &[f64], stated: &Stated) -> Option<f64> {
    let (first, last) = (targets.first()?, targets.last()?);
    let run = stated.targets_run.unwrap_or(Direction::Plus);
    let along = (first < last) == (run == Direction::Plus);
    Some(if along { *first } else { 0.0 - first })
}

/// The runs of a file, what it says, and what is said of the runs; without the ways of the runs there is a
/// problem.
fn passes_of(
    source: &Source,
    stated: &Stated,
    problems: &mut Problems,
) -> Option<(Passes, FileContents, Vec<ImportFinding>)> {
    let sections = problems.take(Sections::of(source))?;
    let kind = linear_kind(&sections, problems);
    let user = user_fields(sections.lines("USER-TEXT"));
    let mut said = FileContents::saying(user.said(&USER_KEYS).chain(kind));
    if let Some(axis) = user.value("Axis").filter(|axis| !axis.text.is_empty()) {
        said.find(stated.axis_warning(&axis, Format::Rtl, problems));
    }
    let file = problems.take(File::read(&sections))?;
    let environment = sections.lines("ENVIRONMENT");
    let noted = environment.iter().filter(|line| !line.is_blank());
    said.find(noted.map(|line| ImportFinding::Says { entry: shown(line.text.trim()) }));
    let warning = material_warning(&Fields::of(environment), file.length_mm(), stated, problems);
    said.find(warning);
    let (ways, left_out) = file.ways(stated, problems).unwrap_or_default();
    let passes = Passes { targets: file.targets, place: file.place, ways };
    let mut of_runs = passes.of_runs(stated);
    of_runs.extend(left_out);
    Some((passes, said, of_runs))
}

/// Other types of the family hold angles or straightness; a stated unit must be that of the format.
fn linear_kind(sections: &Sections<'_>, problems: &mut Problems) -> Option<ImportFinding> {
    let targets = sections.fields("TARGET DATA");
    let units = targets.0.iter().filter(|(key, _)| key.starts_with("unit"));
    for (_, unit) in units.filter(|(_, unit)| !unit.text.eq_ignore_ascii_case("mm")) {
        problems.push(unit.unexpected("the unit", "mm", "save the file in metric units"));
    }
    let Some(kind) = sections.fields("HEADER").value("File type") else {
        return Some(ImportFinding::NoType);
    };
    if !kind.text.eq_ignore_ascii_case("rtl") {
        let help = "export a CSV with the unit, and map its columns with `--columns`";
        problems.push(kind.unexpected("the file type", "`rtl` (linear)", help));
    }
    None
}

/// Keys of USER-TEXT.
const USER_KEYS: [&str; 7] = ["Machine", "Serial No", "Date", "By", "Axis", "Location", "TITLE"];

/// Key and value of USER-TEXT; several may share a line.
fn user_fields<'a>(lines: &[Piece<'a>]) -> Fields<'a> {
    let mut fields = Vec::new();
    for line in lines {
        let found = USER_KEYS.iter().filter_map(|key| key_at(line.text, key));
        let mut starts: Vec<usize> = found.collect();
        starts.sort_unstable();
        for (index, start) in starts.iter().enumerate() {
            let end = starts.get(index + 1).copied().unwrap_or(line.text.len());
            fields.extend(line.part(*start, end).key_value());
        }
    }
    Fields(fields)
}

/// Where `key` followed by a colon begins as a word of its own.
fn key_at(text: &str, key: &str) -> Option<usize> {
    text.match_indices(key).map(|(at, _)| at).find(|at| {
        let alone = !text[..*at].ends_with(char::is_alphanumeric);
        alone && text[at + key.len()..].trim_start().starts_with(':')
    })
}

/// An expansion that is smaller than this is no reason to warn, µm.
const NOTABLE_UM: f64 = 1.0;
/// Reference temperature of lengths, °C (ISO 1).
const REFERENCE_C: f64 = 20.0;

/// Where the file notes a temperature of the material, whether its expansion was taken out has to be stated
/// (contract §2.3); what is at stake is α·(T − 20 °C)·L, α of the file in µm/m per K, L = `length_mm`.
fn material_warning(
    environment: &Fields<'_>,
    length_mm: f64,
    stated: &Stated,
    problems: &mut Problems,
) -> Option<ImportFinding> {
    // A sensor that is absent writes zeros.
    let numbers = |begins: &'static str| {
        let lines = environment.0.iter().filter(move |(key, _)| key.starts_with(begins));
        let words =
            lines.flat_map(|(_, line)| line.text.split_whitespace().map(move |word| (line, word)));
        let numbers = words.filter_map(|(line, word)| Some((line.place(), plain_number(word)?)));
        numbers.filter(|(_, number)| *number != 0.0 && number.abs() <= LARGEST_NUMBER)
    };
    let from_20 = |celsius: f64| (celsius - REFERENCE_C).abs();
    let farthest = numbers("mattemp").max_by(|a, b| from_20(a.1).total_cmp(&from_20(b.1)));
    let (place, celsius) = farthest?;
    let coefficient = numbers("expcoeff").next();
    let stake = coefficient.map(|(_, alpha)| {
        let um = alpha * (celsius - REFERENCE_C) * length_mm / 1000.0;
        (um, format!("{alpha} µm/m per K × ({celsius} − 20) K × {length_mm} mm = {um:.1} µm over the measured length"))
    });
    let words = stake.as_ref().map_or("and no expansion coefficient", |(_, words)| words);
    let noted = format!("a material temperature of {celsius} °C");
    let warning = stated.material_warning(&noted, place, words, problems);
    warning.filter(|_| stake.is_none_or(|(um, _)| um.abs() >= NOTABLE_UM))
}
