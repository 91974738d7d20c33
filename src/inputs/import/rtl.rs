//! Renishaw static data (`.rtl`), linear.
//!
//! ```text
//!   TARGET DATA::  Target-count, Targets (mm), Flags
//!   RUNS::         Run-count: each direction counts as a run
//!   DEVIATIONS::   run  target  deviation (µm)
//! ```
//! A deviation belongs to the target whose number stands in its line; the order of the lines means
//! nothing. docs/import.md §2 names the sources.

use crate::inputs::error_table::DraftSeries;
use crate::inputs::import::choices::Sign;
use crate::inputs::import::placing::Placing;
use crate::inputs::import::rtl_file::File;
use crate::inputs::import::rtl_runs::Travelled;
use crate::inputs::import::rtl_sections::Sections;
use crate::inputs::import::rtl_texts::{
    environment_facts, material_words, stated_axis, user_facts,
};
use crate::inputs::import::stated::Stated;
use crate::inputs::import::{Component, Kind, Reading};
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems, shown};

pub(super) fn read(source: &Source, stated: &Stated) -> Result<Reading, Problems> {
    let sections = Sections::of(source)?;
    let mut problems = Problems::none();
    let kind = linear_kind(&sections, &mut problems);
    let file = problems.take(File::read(&sections));
    let term = required_positioning(stated, &mut problems);
    let sign = stated.required_sign(&mut problems);
    let axis = stated_axis(&sections, stated, &mut problems);
    let Some(file) = file else {
        return Err(problems);
    };
    let warnings = material_words(&sections, stated, file.length_mm(), &mut problems);
    let placing = Placing::of(&file.targets, &file.targets_place, stated, &mut problems);
    let runs = file.runs_travelled(stated, &mut problems);
    let (Some(term), Some(sign), Some(placing), Some(runs)) = (term, sign, placing, runs) else {
        return Err(problems);
    };
    let mut facts = user_facts(&sections);
    facts.extend(axis);
    facts.extend(kind);
    facts.extend(environment_facts(&sections));
    facts.push("unit: deviations in µm, targets in mm (the format's)".to_string());
    facts.extend(placing.words());
    facts.extend(placing.sense_words(term));
    facts.extend(runs.words(&placing));
    problems.or_ok(Reading {
        series: file.series(term, sign, &placing, &runs),
        facts,
        warnings,
        ..Reading::default()
    })
}

/// Other types of the family hold angles or straightness; a stated unit must be that of the format.
pub(super) fn linear_kind(sections: &Sections<'_>, problems: &mut Problems) -> Option<String> {
    for line in sections.lines("TARGET DATA").unwrap_or_default() {
        let pair = line.key_value().filter(|(key, _)| key.starts_with("unit"));
        if let Some((_, value)) = pair.filter(|(_, v)| !v.text.eq_ignore_ascii_case("mm")) {
            problems.push(
                Problem::new(format!("the unit is `{}`, expected mm", shown(value.text)))
                    .at(value.place())
                    .help("save the file in metric units"),
            );
        }
    }
    let Some(kind) = sections.value("HEADER", "filetype") else {
        return Some("the file does not state its type: taken as linear, as `rtl` is".to_string());
    };
    if !kind.text.eq_ignore_ascii_case("rtl") {
        problems.push(
            Problem::new(format!(
                "the file type is `{}`, expected `rtl` (linear)",
                shown(kind.text)
            ))
            .at(kind.place())
            .help("export a CSV with the unit, and map its columns with `--columns`"),
        );
    }
    None
}

/// A linear measurement is one along the moving axis; straightness is measured with other optics
/// and saved in another type of file.
fn required_positioning(stated: &Stated, problems: &mut Problems) -> Option<Component> {
    let term = stated.required_term(problems)?;
    if !term.is_positioning() {
        problems.push(
            Problem::new(format!(
                "`--term {term}` is {}, but a linear file (`rtl`) holds positioning",
                match term.kind {
                    Kind::Angle(_) => "an angle",
                    Kind::Deviation(_) => "a straightness",
                }
            ))
            .help("state EXX, EYY or EZZ, or take the right file"),
        );
    }
    Some(term)
}

impl<'a> File<'a> {
    fn series(
        &self,
        term: Component,
        sign: Sign,
        placing: &Placing,
        runs: &Travelled,
    ) -> Vec<DraftSeries> {
        let ways = [
            (&runs.forward, placing.run),
            (&runs.reverse, placing.run.opposite()),
        ];
        let mut series: Vec<DraftSeries> = ways
            .into_iter()
            .filter(|(runs, _)| !runs.is_empty())
            .map(|(runs, direction)| self.one_series(term, sign, placing, runs, direction))
            .collect();
        series.sort_by_key(|series| series.direction);
        series
    }
}
