//! The sections of a Renishaw file, `NAME::`, lines, `EOF::`, and the targets and runs that they hold.

use crate::inputs::import::findings::ImportFinding;
use crate::inputs::import::reading::{Way, Ways};
use crate::inputs::import::stated::{RUNS, Runs, Stated};
use crate::inputs::import::words::{AGAIN, Fields, Piece, lines};
use crate::text::document::Source;
use crate::text::problem::{Place, Problem, Problems, shown};
use std::collections::BTreeMap;

/// More runs or targets than this are a damaged file.
const MOST: usize = 10_000;
/// Lines of each section, by its name in capital letters.
pub(super) struct Sections<'a> {
    source: &'a Source,
    found: BTreeMap<String, Vec<Piece<'a>>>,
}

impl<'a> Sections<'a> {
    /// Lines of a section that is given twice stand together: readings that come twice are found there.
    pub(super) fn of(source: &'a Source) -> Result<Self, Problems> {
        let mut sections = Sections { source, found: BTreeMap::new() };
        let mut own = String::new();
        for line in lines(source) {
            if let Some(name) = line.text.trim().strip_suffix("::") {
                own = name.trim().to_uppercase();
                sections.found.entry(own.clone()).or_default();
            } else if let Some(lines) = sections.found.get_mut(&own) {
                lines.push(line);
            }
        }
        if sections.found.is_empty() {
            let message =
                "there is no section such as `HEADER::`, expected a file of the format `rtl`";
            let help = "take the file as it was saved, or leave `--from` out";
            return Err(Problem::new(message).at(source.place(&(0..0))).help(help).into());
        }
        let mut problems = Problems::none();
        for needed in ["TARGET DATA", "RUNS", "DEVIATIONS", "EOF"] {
            if !sections.found.contains_key(needed) {
                problems.push(sections.absent(&format!("there is no section `{needed}::`")));
            }
        }
        problems.or_ok(sections)
    }

    pub(super) fn lines(&self, section: &str) -> &[Piece<'a>] {
        self.found.get(section).map_or(&[], Vec::as_slice)
    }

    pub(super) fn fields(&self, section: &str) -> Fields<'a> {
        Fields::of(self.lines(section))
    }

    /// A problem at the end of the file, where something is missing.
    fn absent(&self, message: &str) -> Problem {
        let end = self.source.text.trim_end().len();
        let start = self.source.text[..end].rfind('\n').map_or(0, |at| at + 1);
        Problem::new(message).at(self.source.place(&(start..end))).help(AGAIN)
    }

    /// A whole number from 1, and where it stands.
    fn count(&self, section: &str, label: &str) -> Result<(usize, Piece<'a>), Problems> {
        let Some(value) = self.fields(section).value(label) else {
            let message = format!("there is no `{label}` in section `{section}::`");
            return Err(self.absent(&message).into());
        };
        let mut problems = Problems::none();
        let count = value.count(&format!("`{label}`"), &mut problems);
        if let Some(count) = count.filter(|count| *count > MOST) {
            let message = format!("`{label}` is {count}, expected at most {MOST}");
            problems.push(value.problem(message, AGAIN));
        }
        problems.or_ok((count.unwrap_or(0), value))
    }
}

/// What the sections hold.
pub(super) struct File<'a> {
    /// mm, as the file counts.
    pub(super) targets: Vec<f64>,
    pub(super) place: Place,
    flags: Option<Piece<'a>>,
    /// Deviations of each run at each target, µm.
    runs: Vec<Vec<f64>>,
}

impl<'a> File<'a> {
    pub(super) fn read(sections: &Sections<'a>) -> Result<Self, Problems> {
        let mut problems = Problems::none();
        let count = problems.take(sections.count("TARGET DATA", "Target-count"));
        let runs = problems.take(sections.count("RUNS", "Run-count"));
        let (targets, place) = read_targets(sections, &mut problems);
        let (Some((count, _)), Some(runs)) = (count, runs) else {
            return Err(problems);
        };
        if count != targets.len() {
            let found = targets.len();
            let message =
                format!("{found} targets are listed, expected {count} as in `Target-count`");
            problems.push(Problem::new(message).at(place.clone()).help(AGAIN));
        }
        let runs = problems.take(read_runs(sections, runs, count));
        problems.or_ok(File {
            targets,
            place,
            flags: sections.fields("TARGET DATA").value("Flags"),
            runs: runs.unwrap_or_default(),
        })
    }

    /// From the first target to the last.
    pub(super) fn length_mm(&self) -> f64 {
        let ends = self.targets.first().zip(self.targets.last());
        ends.map_or(0.0, |(first, last)| (last - first).abs())
    }

    /// Which runs went which way, by the second flag, which `--runs` must not contradict; where the even runs do
    /// not look like that, it has to be stated. And what is said of return runs that were never made, which stand in the
    /// file as zeros.
    pub(super) fn ways(
        &self,
        stated: &Stated,
        problems: &mut Problems,
    ) -> Option<(Ways, Option<ImportFinding>)> {
        let every_second = |from: usize| self.runs.iter().skip(from).step_by(2).cloned();
        let (odd, even): (Vec<_>, Vec<_>) = (every_second(0).collect(), every_second(1).collect());
        let is_measured = even.iter().flatten().any(|um| *um != 0.0);
        let is_zero = !even.is_empty() && !is_measured;
        let at_flags = |problem: Problem| match self.flags {
            Some(flags) => problem.at(flags.place()),
            None => problem,
        };
        let (flagged, unclear) = match self.flags.and_then(|f| f.text.split_whitespace().nth(1)) {
            Some("0") if is_zero => {
                (None, Some("the flags say bidirectional, but every even run holds only zeros"))
            }
            Some("0") => (Some(Runs::Bidirectional), None),
            Some("1") if is_measured => (
                Some(Runs::Unidirectional),
                Some("the flags say unidirectional, but the even runs are not empty"),
            ),
            Some("1") => (Some(Runs::Unidirectional), None),
            _ => (None, Some(RUNS.why)),
        };
        if let (Some(why), None) = (unclear, stated.runs) {
            problems.push(at_flags(RUNS.missing_because(why)));
            return None;
        }
        let (forward, back) = (Way::Forward, Way::Reverse);
        match RUNS.settled(flagged.zip(self.flags), stated.runs, stated, problems)? {
            Runs::Bidirectional if odd.len() == even.len() => {
                Some((vec![(forward, odd), (back, even)], None))
            }
            Runs::Bidirectional => {
                let count = self.runs.len();
                let message = format!(
                    "`Run-count` is {count} in a bidirectional file, expected an even number: each direction counts as a run"
                );
                let help = "complete the last return run, or save the file without its outward run";
                problems.push(at_flags(Problem::new(message).help(help)));
                None
            }
            Runs::Unidirectional if is_measured => Some((vec![(forward, self.runs.clone())], None)),
            Runs::Unidirectional => {
                let runs = (2..=self.runs.len()).step_by(2).collect();
                let never_made = is_zero.then_some(ImportFinding::NeverMade { runs });
                Some((vec![(forward, odd)], never_made))
            }
        }
    }
}

/// Numbers behind `Targets :`, over as many lines as there are, and where they stand.
fn read_targets(sections: &Sections<'_>, problems: &mut Problems) -> (Vec<f64>, Place) {
    let lines = sections.lines("TARGET DATA");
    let beside = sections.fields("TARGET DATA").value("Targets");
    let is_head = |line: &Piece<'_>| line.key_value().is_some_and(|(key, _)| key == "targets");
    let (Some(at), Some(beside)) = (lines.iter().position(is_head), beside) else {
        problems.push(sections.absent("there is no `Targets` in section `TARGET DATA::`"));
        return (Vec::new(), sections.source.place(&(0..0)));
    };
    let below = lines[at + 1..].iter();
    let below = below.take_while(|line| line.key_value().is_none()).copied();
    let all = std::iter::once(beside).chain(below);
    let filled: Vec<Piece<'_>> = all.filter(|line| !line.is_blank()).collect();
    let place = match filled.first() {
        Some(first) if beside.is_blank() => first.place(),
        _ => lines[at].place(),
    };
    let mut words = Vec::new();
    for line in filled {
        words.extend(line.words(char::is_whitespace));
        if words.len() > MOST {
            let message = format!("here are more than {MOST} targets, expected at most so many");
            problems.push(line.problem(message, AGAIN));
            break;
        }
    }
    let numbers = words.iter();
    let numbers = numbers.filter_map(|word| word.number("a target", problems));
    (numbers.collect(), place)
}

/// Deviations of each run at each target; all of them are there.
fn read_runs(
    sections: &Sections<'_>,
    (runs, run_count): (usize, Piece<'_>),
    targets: usize,
) -> Result<Vec<Vec<f64>>, Problems> {
    let mut problems = Problems::none();
    let mut found = BTreeMap::new();
    for line in sections.lines("DEVIATIONS") {
        let is_label = !line.begins_with_number() && line.text.trim_end().ends_with(':');
        if line.is_blank() || is_label {
            continue;
        }
        let Some(words) = line.row(3, char::is_whitespace, &mut problems) else {
            continue;
        };
        let run = numbered(&words[0], "run", (runs, "Run-count"), &mut problems);
        let target = numbered(&words[1], "target", (targets, "Target-count"), &mut problems);
        let deviation = words[2].number("a deviation", &mut problems);
        if let (Some(run), Some(target), Some(um)) = (run, target, deviation)
            && found.insert((run, target), um).is_some()
        {
            let message = format!("target {target} of run {run} is given twice");
            problems.push_with(|| line.problem(message, AGAIN));
        }
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    for run in 1..=runs {
        let missing = (1..=targets).filter(|target| !found.contains_key(&(run, *target)));
        let missing: Vec<String> = missing.map(|target| target.to_string()).collect();
        let message = match missing.len() {
            0 => continue,
            count if count == targets => {
                format!("run {run} is missing, expected {runs} runs as in `Run-count`")
            }
            _ => format!("run {run} has no deviation at target {}", shown(&missing.join(", "))),
        };
        let help =
            "a missing value is never filled in: save the file again, or without the broken run";
        problems.push_with(|| run_count.problem(message, help));
        if problems.is_full() {
            break; // few lines may promise 10 000 runs of 10 000 targets
        }
    }
    let um: Vec<f64> = found.into_values().collect();
    problems.or_ok(um.chunks(targets).map(<[f64]>::to_vec).collect())
}

fn numbered(
    word: &Piece<'_>,
    what: &str,
    (most, key): (usize, &str),
    problems: &mut Problems,
) -> Option<usize> {
    let number = word.count(&format!("the number of a {what}"), problems)?;
    if number > most {
        let message = format!("{what} {number} is beyond `{key}`, which is {most}");
        problems.push_with(|| word.problem(message, AGAIN));
    }
    Some(number).filter(|number| *number <= most)
}
