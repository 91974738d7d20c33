//! What the sections of a file of static data hold.

use crate::inputs::error_table::DraftSeries;
use crate::inputs::import::choices::Sign;
use crate::inputs::import::lines::{Line, Word, looks_like_number};
use crate::inputs::import::placing::{Placing, mean, pooled};
use crate::inputs::import::rtl_sections::{AGAIN, MOST, Sections};
use crate::inputs::import::{Component, Kind};
use crate::quantity::axis::Direction;
use crate::text::problem::{Place, Problem, Problems, shown};
use std::collections::BTreeMap;

/// What the sections hold.
pub(super) struct File<'a> {
    pub(super) targets: Vec<f64>,
    pub(super) targets_place: Place,
    pub(super) runs: usize,
    pub(super) flags: Option<Word<'a>>,
    /// Deviation of run and target (both from 1).
    pub(super) deviations: BTreeMap<(usize, usize), f64>,
}

impl<'a> File<'a> {
    pub(super) fn read(sections: &Sections<'a>) -> Result<Self, Problems> {
        let mut problems = Problems::none();
        let count = sections.count("TARGET DATA", "targetcount", "Target-count", &mut problems);
        let runs = sections.count("RUNS", "runcount", "Run-count", &mut problems);
        let (targets, targets_place) = read_targets(sections, &mut problems);
        if let Some(count) = count.filter(|count| *count != targets.len()) {
            problems.push(
                Problem::new(format!(
                    "{} targets are listed, expected {count} as in `Target-count`",
                    targets.len()
                ))
                .at(targets_place.clone())
                .help(AGAIN),
            );
        }
        let (Some(count), Some(runs)) = (count, runs) else {
            return Err(problems);
        };
        let deviations = read_deviations(sections, runs, count, &mut problems);
        problems.or_ok(File {
            targets,
            targets_place,
            runs,
            flags: sections.value("TARGET DATA", "flags"),
            deviations,
        })
    }

    /// Deviations of a run, µm.
    pub(super) fn run(&self, run: usize) -> Vec<f64> {
        let of_run = self.deviations.range((run, 0)..=(run, usize::MAX));
        of_run.map(|(_, um)| *um).collect()
    }

    /// From the first target to the last.
    pub(super) fn length_mm(&self) -> f64 {
        match (self.targets.first(), self.targets.last()) {
            (Some(first), Some(last)) => (last - first).abs(),
            _ => 0.0,
        }
    }

    pub(super) fn one_series(
        &self,
        term: Component,
        sign: Sign,
        placing: &Placing,
        runs: &[usize],
        direction: Direction,
    ) -> DraftSeries {
        let figures: Vec<(f64, Option<f64>)> = (1..=self.targets.len())
            .map(|target| {
                let readings = runs
                    .iter()
                    .filter_map(|run| self.deviations.get(&(*run, target)));
                mean(&readings.copied().collect::<Vec<f64>>())
            })
            .collect();
        let means: Vec<f64> = figures.iter().map(|(mean, _)| *mean).collect();
        let spread: Option<Vec<f64>> = figures.iter().map(|(_, u)| *u).collect();
        let mut series = DraftSeries::new(term.along, Some(direction), placing.positions_mm());
        term.put(&mut series, placing.deviations(&means, term, sign));
        if let Kind::Deviation(of) = term.kind {
            series.uncertainties_um[of] = spread.map(|u| placing.uncertainties(&pooled(&u)));
        }
        series
    }
}

/// Numbers behind `Targets :`, over as many lines as there are.
fn read_targets(sections: &Sections<'_>, problems: &mut Problems) -> (Vec<f64>, Place) {
    let lines = sections.lines("TARGET DATA").unwrap_or_default();
    let is_head = |line: &&Line<'_>| line.key_value().is_some_and(|(key, _)| key == "targets");
    let Some(at) = lines.iter().position(|line| is_head(&line)) else {
        let problem = sections.absent("there is no `Targets` in section `TARGET DATA::`");
        let start = sections.source.place(&(0..0));
        problems.push(problem);
        return (Vec::new(), start);
    };
    let mut place = lines[at].place();
    let beside = lines[at].key_value().map(|(_, value)| value.line());
    let mut words: Vec<Word<'_>> = beside.iter().flat_map(blank_separated).collect();
    let behind = lines[at + 1..].iter();
    for line in behind.take_while(|line| line.key_value().is_none()) {
        if words.is_empty() && !line.is_blank() {
            place = line.place();
        }
        words.extend(blank_separated(line));
        if words.len() > MOST {
            let message = format!("here are more than {MOST} targets, expected at most so many");
            problems.push(Problem::new(message).at(line.place()).help(AGAIN));
            break;
        }
    }
    let numbers = words
        .iter()
        .filter_map(|word| word.number("a target", problems));
    (numbers.collect(), place)
}

fn blank_separated<'a>(line: &Line<'a>) -> Vec<Word<'a>> {
    line.words(char::is_whitespace)
}

fn read_deviations(
    sections: &Sections<'_>,
    runs: usize,
    targets: usize,
    problems: &mut Problems,
) -> BTreeMap<(usize, usize), f64> {
    let mut found = BTreeMap::new();
    let before = problems.is_empty();
    for line in sections.lines("DEVIATIONS").unwrap_or_default() {
        let words = blank_separated(line);
        let is_row = words
            .first()
            .is_some_and(|word| looks_like_number(word.text));
        if line.is_blank() || (!is_row && line.text.trim_end().ends_with(':')) {
            continue;
        }
        let [run, target, deviation] = words[..] else {
            problems.push_with(|| {
                Problem::new(format!(
                    "the line has {} words, expected run, target and deviation",
                    words.len()
                ))
                .at(line.place())
                .help(AGAIN)
            });
            continue;
        };
        let run = numbered(run, "run", runs, "Run-count", problems);
        let target = numbered(target, "target", targets, "Target-count", problems);
        let deviation = deviation.number("a deviation", problems);
        let (Some(run), Some(target), Some(um)) = (run, target, deviation) else {
            continue;
        };
        if found.insert((run, target), um).is_some() {
            problems.push_with(|| {
                Problem::new(format!("target {target} of run {run} stands twice"))
                    .at(line.place())
                    .help(AGAIN)
            });
        }
    }
    if before && problems.is_empty() {
        refuse_missing(sections, runs, targets, &found, problems);
    }
    found
}

fn numbered(
    word: Word<'_>,
    what: &str,
    most: usize,
    key: &str,
    problems: &mut Problems,
) -> Option<usize> {
    let number = word.count(&format!("the number of a {what}"), problems)?;
    if number > most {
        problems.push_with(|| {
            Problem::new(format!(
                "{what} {number} is beyond `{key}`, which is {most}"
            ))
            .at(word.place())
            .help(AGAIN)
        });
        return None;
    }
    Some(number)
}

fn refuse_missing(
    sections: &Sections<'_>,
    runs: usize,
    targets: usize,
    found: &BTreeMap<(usize, usize), f64>,
    problems: &mut Problems,
) {
    for run in 1..=runs {
        if problems.is_full() {
            return; // few lines may promise 10 000 runs of 10 000 targets
        }
        let missing: Vec<String> = (1..=targets)
            .filter(|target| !found.contains_key(&(run, *target)))
            .map(|target| target.to_string())
            .collect();
        if missing.is_empty() {
            continue;
        }
        let message = if missing.len() == targets {
            format!("run {run} is missing, expected {runs} runs as in `Run-count`")
        } else {
            format!(
                "run {run} has no deviation at target {}",
                shown(&missing.join(", "))
            )
        };
        problems.push_with(|| match sections.value("RUNS", "runcount") {
            Some(count) => Problem::new(message)
                .at(count.place())
                .help("a missing value is never filled in: save the file again, or without the broken run"),
            None => sections.absent(&message),
        });
    }
}
