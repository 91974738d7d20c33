//! Renishaw static data (`.rtl`), linear.
//!
//! ```text
//!   TARGET DATA::  Target-count, Targets (mm), Flags
//!   RUNS::         Run-count: each direction counts as a run
//!   DEVIATIONS::   run  target  deviation (µm)
//! ```
//! A deviation belongs to the target whose number stands in its line; the order of the lines means
//! nothing. docs/import.md §2 names the sources.

mod runs;

pub use self::runs::{MeasuredRuns, measured_runs};

use crate::axis::{Axis, Direction};
use crate::document::Source;
use crate::error_table::DraftSeries;
use crate::import::lines::{Line, Word, lines, looks_like_number};
use crate::import::placing::{Placing, mean};
use crate::import::stated::{Runs, Sign, Stated, missing};
use crate::import::{Component, Kind, Reading};
use crate::problem::{Place, Problem, Problems, shown};
use std::collections::BTreeMap;

/// More runs or targets than this are a damaged file.
const MOST: usize = 10_000;
const AGAIN: &str = "the file is incomplete or damaged: save it again";
/// Keys of USER-TEXT; several may share a line.
const USER_KEYS: [&str; 7] = [
    "Machine",
    "Serial No",
    "Date",
    "By",
    "Axis",
    "Location",
    "TITLE",
];

pub(super) fn read(source: &Source, stated: &Stated) -> Result<Reading, Problems> {
    let sections = Sections::of(source)?;
    let mut problems = Problems::none();
    let file = problems.take(File::read(&sections));
    let term = required_deviation(stated, &mut problems);
    let sign = stated.required_sign(&mut problems);
    let axis = stated_axis(
        &sections,
        term.map(|t| t.along).or(stated.axis),
        &mut problems,
    );
    let Some(file) = file else {
        return Err(problems);
    };
    let placing = Placing::of(&file.targets, &file.targets_place, stated, &mut problems);
    let runs = file.runs_travelled(stated, &mut problems);
    let (Some(term), Some(sign), Some(placing), Some(runs)) = (term, sign, placing, runs) else {
        return Err(problems);
    };
    let mut facts = user_facts(&sections);
    facts.extend(axis);
    facts.push("unit: deviations in µm, targets in mm (the format's)".to_string());
    facts.extend(placing.words(Some(term)));
    facts.extend(runs.words(&placing));
    problems.or_ok(Reading {
        series: file.series(term, sign, &placing, &runs),
        facts,
        squareness: Vec::new(),
    })
}

/// A linear file holds lengths, not angles.
fn required_deviation(stated: &Stated, problems: &mut Problems) -> Option<Component> {
    let term = stated.required_term(problems)?;
    if let Kind::Angle(_) = term.kind {
        problems.push(
            Problem::new(format!(
                "`--term {term}` is an angle, but the file holds lengths"
            ))
            .help("state one of EXX, EYX, EZX, EXY, EYY, EZY, EXZ, EYZ, EZZ"),
        );
    }
    Some(term)
}

/// Lines of each section, by its name in capital letters.
struct Sections<'a> {
    source: &'a Source,
    found: Vec<(String, Vec<Line<'a>>)>,
}

impl<'a> Sections<'a> {
    fn of(source: &'a Source) -> Result<Self, Problems> {
        let mut found: Vec<(String, Vec<Line<'a>>)> = Vec::new();
        for line in lines(source) {
            if let Some(name) = line.text.trim().strip_suffix("::") {
                found.push((name.trim().to_uppercase(), Vec::new()));
            } else if let Some((_, lines)) = found.last_mut() {
                lines.push(line);
            }
        }
        if found.is_empty() {
            return Err(Problem::new(
                "there is no section such as `HEADER::`, expected a file of the format `rtl`",
            )
            .at(source.place(&(0..0)))
            .help("take the file as it was saved, or leave `--from` out")
            .into());
        }
        let sections = Sections { source, found };
        let mut problems = Problems::none();
        for needed in ["TARGET DATA", "RUNS", "DEVIATIONS", "EOF"] {
            if sections.lines(needed).is_none() {
                problems.push(sections.absent(&format!("there is no section `{needed}::`")));
            }
        }
        problems.or_ok(sections)
    }

    fn lines(&self, section: &str) -> Option<&[Line<'a>]> {
        let found = self.found.iter().find(|(name, _)| name == section);
        found.map(|(_, lines)| lines.as_slice())
    }

    fn value(&self, section: &str, key: &str) -> Option<Word<'a>> {
        let mut pairs = self.lines(section)?.iter().filter_map(Line::key_value);
        pairs.find_map(|(found, value)| (found == key).then_some(value))
    }

    /// A problem at the end of the file, where something is missing.
    fn absent(&self, message: &str) -> Problem {
        let end = self.source.text.trim_end().len();
        let start = self.source.text[..end].rfind('\n').map_or(0, |at| at + 1);
        Problem::new(message)
            .at(self.source.place(&(start..end)))
            .help(AGAIN)
    }

    fn count(
        &self,
        section: &str,
        key: &str,
        label: &str,
        problems: &mut Problems,
    ) -> Option<usize> {
        let Some(value) = self.value(section, key) else {
            problems.push(self.absent(&format!("there is no `{label}` in section `{section}::`")));
            return None;
        };
        let count = value.count(&format!("`{label}`"), problems)?;
        if count > MOST {
            problems.push(
                Problem::new(format!("`{label}` is {count}, expected at most {MOST}"))
                    .at(value.place())
                    .help(AGAIN),
            );
            return None;
        }
        Some(count)
    }
}

/// What the sections hold.
struct File<'a> {
    targets: Vec<f64>,
    targets_place: Place,
    runs: usize,
    flags: Option<Word<'a>>,
    /// Deviation of run and target (both from 1).
    deviations: BTreeMap<(usize, usize), f64>,
}

impl<'a> File<'a> {
    fn read(sections: &Sections<'a>) -> Result<Self, Problems> {
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

    fn run(&self, run: usize) -> Vec<f64> {
        let of_run = self.deviations.range((run, 0)..=(run, usize::MAX));
        of_run.map(|(_, um)| *um).collect()
    }

    /// Which runs went which way: from the flags, which `--runs` must not contradict.
    fn runs_travelled(&self, stated: &Stated, problems: &mut Problems) -> Option<Travelled> {
        let flagged = self.flagged();
        if let (Some(flagged), Some(stated), Some(flags)) = (flagged, stated.runs, self.flags)
            && flagged != stated
        {
            problems.push(
                Problem::new(format!(
                    "`--runs {}` contradicts the flags of the file, which say {}",
                    stated.word(),
                    flagged.word()
                ))
                .at(flags.place())
                .help("leave `--runs` out"),
            );
            return None;
        }
        let Some(runs) = flagged.or(stated.runs) else {
            problems.push(self.runs_not_known());
            return None;
        };
        let odd: Vec<usize> = (1..=self.runs).step_by(2).collect();
        let even: Vec<usize> = (2..=self.runs).step_by(2).collect();
        match runs {
            Runs::Bidirectional if odd.len() == even.len() => Some(Travelled::both(odd, even)),
            Runs::Bidirectional => {
                problems.push(self.odd_count());
                None
            }
            Runs::Unidirectional => self.one_way(odd, even, stated, problems),
        }
    }

    /// The second flag, where it is one of the two that are known.
    fn flagged(&self) -> Option<Runs> {
        match self.flags?.text.split_whitespace().nth(1)? {
            "0" => Some(Runs::Bidirectional),
            "1" => Some(Runs::Unidirectional),
            _ => None,
        }
    }

    fn runs_not_known(&self) -> Problem {
        let problem = missing(
            "--runs",
            "the second number of `Flags` does not say whether even runs go back",
            "add `--runs bidirectional` (even runs go back) or `--runs unidirectional`",
        );
        match self.flags {
            Some(flags) => problem.at(flags.place()),
            None => problem,
        }
    }

    fn odd_count(&self) -> Problem {
        let message = format!(
            "`Run-count` is {} in a bidirectional file, expected an even number: each direction counts as a run",
            self.runs
        );
        let problem = Problem::new(message)
            .help("complete the last return run, or save the file without its outward run");
        match self.flags {
            Some(flags) => problem.at(flags.place()),
            None => problem,
        }
    }

    /// Return runs that were never made stand in the file as zeros.
    fn one_way(
        &self,
        odd: Vec<usize>,
        even: Vec<usize>,
        stated: &Stated,
        problems: &mut Problems,
    ) -> Option<Travelled> {
        let is_empty = |run: &usize| self.run(*run).iter().all(|um| *um == 0.0);
        if even.iter().all(is_empty) {
            return Some(Travelled {
                forward: odd,
                reverse: Vec::new(),
                dropped: even,
            });
        }
        if stated.runs == Some(Runs::Unidirectional) {
            return Some(Travelled {
                forward: (1..=self.runs).collect(),
                reverse: Vec::new(),
                dropped: Vec::new(),
            });
        }
        let problem = missing(
            "--runs",
            "the flags say unidirectional, but the even runs are not empty",
            "add `--runs unidirectional` if every run went from the first target to the last; else save the file as bidirectional",
        );
        problems.push(match self.flags {
            Some(flags) => problem.at(flags.place()),
            None => problem,
        });
        None
    }

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

    fn one_series(
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
            series.uncertainties_um[of] = spread.map(|u| placing.uncertainties(&u));
        }
        series
    }
}

/// Numbers of the runs of each way.
struct Travelled {
    forward: Vec<usize>,
    reverse: Vec<usize>,
    dropped: Vec<usize>,
}

impl Travelled {
    fn both(forward: Vec<usize>, reverse: Vec<usize>) -> Travelled {
        Travelled {
            forward,
            reverse,
            dropped: Vec::new(),
        }
    }

    fn words(&self, placing: &Placing) -> Vec<String> {
        let of = |runs: &[usize], direction: Direction| {
            (!runs.is_empty()).then(|| format!("{} moving {direction}", runs.len()))
        };
        let counts = [
            of(&self.forward, placing.run),
            of(&self.reverse, placing.run.opposite()),
        ];
        let counts: Vec<String> = counts.into_iter().flatten().collect();
        let repeated = self.forward.len() > 1;
        let u = if repeated {
            "; mean of each direction, u = s/√runs (k = 1)"
        } else {
            "; one run tells nothing about the uncertainty"
        };
        let mut words = vec![format!("runs: {}{u}", counts.join(", "))];
        if !self.dropped.is_empty() {
            let dropped: Vec<String> = self.dropped.iter().map(usize::to_string).collect();
            words.push(format!(
                "runs {} hold only zeros in a unidirectional file: they were never made and are left out",
                dropped.join(", ")
            ));
        }
        words
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

/// Key and value of USER-TEXT; fields may share a line.
fn user_fields<'a>(sections: &Sections<'a>) -> Vec<(&'static str, Word<'a>)> {
    let mut fields = Vec::new();
    for line in sections.lines("USER-TEXT").unwrap_or_default() {
        let mut starts: Vec<(usize, usize, &'static str)> = USER_KEYS
            .into_iter()
            .filter_map(|key| key_at(line.text, key).map(|(from, value)| (from, value, key)))
            .collect();
        starts.sort_unstable();
        for (index, (_, value, key)) in starts.iter().enumerate() {
            let end = starts.get(index + 1).map_or(line.text.len(), |next| next.0);
            if *value <= end {
                fields.push((*key, line.part(*value, end)));
            }
        }
    }
    fields
}

/// Where `key` followed by a colon begins as a word of its own, and where its value begins.
fn key_at(text: &str, key: &str) -> Option<(usize, usize)> {
    text.match_indices(key).find_map(|(at, _)| {
        let alone = !text[..at].ends_with(char::is_alphanumeric);
        let rest = &text[at + key.len()..];
        let colon = rest
            .trim_start()
            .starts_with(':')
            .then(|| rest.find(':'))??;
        alone.then_some((at, at + key.len() + colon + 1))
    })
}

fn user_facts(sections: &Sections<'_>) -> Vec<String> {
    let fields = user_fields(sections).into_iter();
    fields
        .filter(|(key, value)| *key != "Axis" && !value.text.is_empty())
        .map(|(key, value)| format!("the file says: {key}: {}", shown(value.text)))
        .collect()
}

/// The axis that the file names; it must be the one that was stated.
fn stated_axis(
    sections: &Sections<'_>,
    expected: Option<Axis>,
    problems: &mut Problems,
) -> Option<String> {
    let fields = user_fields(sections);
    let (_, word) = fields.iter().find(|(key, _)| *key == "Axis")?;
    let letters: String = word
        .text
        .chars()
        .take_while(|c| c.is_alphabetic())
        .collect();
    if word.text.is_empty() {
        return None;
    }
    if letters.chars().count() != 1 {
        return Some(format!(
            "the file says: Axis: {} (names none of X, Y, Z; that of `--term` is used)",
            shown(word.text)
        ));
    }
    if Axis::from_letter(&letters) == expected || expected.is_none() {
        return Some(format!("the file says: Axis: {}", shown(word.text)));
    }
    let stated = expected.map(Axis::letter).unwrap_or_default();
    problems.push(
        Problem::new(format!(
            "the file says axis `{}`, but {stated} was stated as the moving axis",
            shown(word.text)
        ))
        .at(word.place())
        .help("state the term of the axis that moved, or take the right file"),
    );
    None
}
