//! Renishaw static data (`.rtl`), linear.
//!
//! ```text
//!   TARGET DATA::  Target-count, Targets (mm), Flags
//!   RUNS::         Run-count: each direction counts as a run
//!   DEVIATIONS::   run  target  deviation (µm)
//! ```
//! A deviation belongs to the target whose number stands in its line; the order of the lines means
//! nothing. docs/measuring.md §6 names the sources.

use crate::inputs::error_table::{Component, Kind};
use crate::inputs::findings::ImportFinding;
use crate::inputs::import::encoding::{Measurement, text_of};
use crate::inputs::import::intake::{Contents, Fields, Intake, Piece, named_axis};
use crate::inputs::import::reading::{Passes, Placing, Ways};
use crate::inputs::import::stated::{Format, ImportFacts, RUNS, Runs};
use crate::inputs::{refusals, target_runs};
use crate::quantity::{Axis, Direction, Pass};
use crate::text::{Finding, LARGEST_NUMBER, Place, Problem, Problems, joined, plain_number, shown};
use std::collections::BTreeMap;

pub(super) fn read<'a>(intake: &'a Intake<'a>) -> Option<Contents> {
    let sections = Sections::of(intake);
    let (term, sign) = (intake.term(), intake.sign(None));
    let (passes, of_runs) = sections.passes()?;
    let unit = "deviations in µm, targets in mm (the format's)";
    intake.say([ImportFinding::UnitOfFormat { unit }]);
    passes.contents(term, sign, of_runs, intake)
}

/// The axis that the file names.
pub(super) fn axis<'a>(intake: &'a Intake<'a>) -> Option<Axis> {
    named_axis(Sections::of(intake).user_fields().value("Axis")?.text)
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
    stated: &ImportFacts,
) -> Result<(target_runs::Runs, Vec<Finding>), Problems> {
    let (source, name) = text_of(file, stated)?;
    let intake = Intake::of(&source, stated, Format::Rtl);
    intake.say([ImportFinding::Encoding { name }]);
    let runs = runs_of(&intake);
    let (runs, mut findings) = intake.end(runs)?;
    findings.sort_by_key(Finding::severity);
    Ok((runs, findings))
}

fn runs_of<'a>(intake: &'a Intake<'a>) -> Option<target_runs::Runs> {
    let sign = intake.sign(None);
    let sections = Sections::of(intake);
    let (passes, of_runs) = sections.passes()?;
    let first_mm = first_target_mm(&passes.targets, intake.stated);
    let placing = Placing::of(&passes.targets, &passes.place, first_mm, intake);
    let (sign, placing) = (sign?, placing?);
    let is_of_means = |found: &ImportFinding| matches!(found, ImportFinding::Runs { .. });
    let of_runs = of_runs.into_iter().filter(|found| !is_of_means(found));
    let turned = placing.turned(POSITIONING);
    intake.say([ImportFinding::OwnZero].into_iter().chain(turned).chain(of_runs));
    let moving = |direction: Direction| {
        let mut ways = passes.ways.iter();
        let (_, runs) = ways.find(|(way, _)| placing.direction(*way) == Some(direction))?;
        let runs = runs.iter().map(|run| placing.deviations(run, POSITIONING, sign));
        let runs: Vec<Vec<f64>> = runs.collect();
        let at = |target: usize| runs.iter().map(|run| run[target]).collect();
        Some((0..passes.targets.len()).map(at).collect())
    };
    let targets_mm = placing.positions.iter().map(|target| target.mm()).collect();
    let (up, down) = (moving(Direction::Plus), moving(Direction::Minus));
    intake.notes.take(target_runs::Runs::new(targets_mm, up, down))
}

/// The coordinate of the first target: that of the file, mirrored at its zero where the file counts
/// against the axis.
fn first_target_mm(targets: &[f64], stated: &ImportFacts) -> Option<f64> {
    let (first, last) = (targets.first()?, targets.last()?);
    let run = stated.targets_run.unwrap_or(Direction::Plus);
    let along = (first < last) == (run == Direction::Plus);
    Some(if along { *first } else { 0.0 - first })
}

/// More runs or targets than this are a damaged file.
const MOST: usize = 10_000;
/// Keys of USER-TEXT.
const USER_KEYS: [&str; 7] = ["Machine", "Serial No", "Date", "By", "Axis", "Location", "TITLE"];

/// Lines of each section, by its name in capital letters.
struct Sections<'a> {
    intake: &'a Intake<'a>,
    found: BTreeMap<String, Vec<Piece<'a>>>,
}

impl<'a> Sections<'a> {
    /// Lines of a section that is given twice stand together: readings that come twice are found there.
    fn of(intake: &'a Intake<'a>) -> Self {
        let mut sections = Sections { intake, found: BTreeMap::new() };
        let mut own = String::new();
        for line in intake.lines() {
            if let Some(name) = line.text.trim().strip_suffix("::") {
                own = name.trim().to_uppercase();
                sections.found.entry(own.clone()).or_default();
            } else if let Some(lines) = sections.found.get_mut(&own) {
                lines.push(line);
            }
        }
        sections
    }

    fn lines(&self, section: &str) -> &[Piece<'a>] {
        self.found.get(section).map_or(&[], Vec::as_slice)
    }

    fn fields(&self, section: &str) -> Fields<'a> {
        Fields::of(self.lines(section))
    }

    /// Key and value of USER-TEXT; several may share a line.
    fn user_fields(&self) -> Fields<'a> {
        let mut fields = Vec::new();
        for line in self.lines("USER-TEXT") {
            let found = USER_KEYS.iter().filter_map(|key| key_at(line.text, key));
            let mut starts: Vec<usize> = found.chain([line.text.len()]).collect();
            starts.sort_unstable();
            let parts = starts.windows(2).map(|ends| line.part(ends[0], ends[1]));
            fields.extend(parts.filter_map(|part| part.key_value()));
        }
        Fields(fields)
    }

    /// A section or a line that is not there: noted at the end of the file.
    fn lacks<T>(&self, what: &str) -> Option<T> {
        let source = self.intake.source;
        let end = source.text.trim_end().len();
        let start = source.text[..end].rfind('\n').map_or(0, |at| at + 1);
        self.intake.notes.refused(refusals::there_is_no(what).at(source.place(&(start..end))))
    }

    /// The runs of a file and what is said of them; what the file says is said.
    fn passes(&self) -> Option<(Passes, Vec<ImportFinding>)> {
        if self.found.is_empty() {
            return self.intake.notes.refused(refusals::no_section_at_all().at(self.intake.top()));
        }
        let needed = ["TARGET DATA", "RUNS", "DEVIATIONS", "EOF"];
        let lacking = needed.iter().filter(|needed| !self.found.contains_key(**needed));
        if lacking.map(|needed| self.lacks::<()>(&format!("section `{needed}::`"))).count() > 0 {
            return None;
        }
        let user = self.user_fields();
        self.intake.say(user.said(&USER_KEYS));
        self.check_kind();
        let axis = user.value("Axis").filter(|axis| !axis.text.is_empty());
        axis.iter().for_each(|axis| self.intake.check_axis(axis));
        let count = self.count("TARGET DATA", "Target-count");
        let run_count = self.count("RUNS", "Run-count");
        let targets = self.targets();
        let (count, run_count) = (count?.0, run_count?);
        if let Some((listed, place)) = targets.as_ref().filter(|(own, _)| own.len() != count) {
            let problem = refusals::other_targets(listed.len(), count);
            self.intake.notes.refuse(problem.at(place.clone()));
        }
        let runs = self.runs(run_count, count)?;
        let (targets, place) = targets.filter(|(targets, _)| targets.len() == count)?;
        let noted = self.lines("ENVIRONMENT").iter().filter(|line| !line.is_blank());
        self.intake.say(noted.map(|line| ImportFinding::Says { entry: shown(line.text.trim()) }));
        let ends = targets.first().zip(targets.last());
        self.check_material(ends.map_or(0.0, |(first, last)| (last - first).abs()));
        let (ways, left_out) = self.ways(&runs).unwrap_or_default();
        let passes = Passes { targets, place, ways };
        let of_runs = passes.of_runs(self.intake).into_iter().chain(left_out).collect();
        Some((passes, of_runs))
    }

    /// Other types of the family hold angles or straightness; a stated unit must be that of the format.
    fn check_kind(&self) {
        let targets = self.fields("TARGET DATA");
        let units = targets.0.iter().filter(|(key, _)| key.starts_with("unit"));
        for (_, unit) in units.filter(|(_, unit)| !unit.text.eq_ignore_ascii_case("mm")) {
            unit.unexpected("the unit", "mm", "save the file in metric units");
        }
        match self.fields("HEADER").value("File type") {
            None => self.intake.say([ImportFinding::NoType]),
            Some(kind) if kind.text.eq_ignore_ascii_case("rtl") => {}
            Some(kind) => {
                let help = "export a CSV with the unit, and map its columns with `--columns`";
                kind.unexpected("the file type", "`rtl` (linear)", help)
            }
        }
    }

    /// A whole number from 1, and where it stands.
    fn count(&self, section: &str, label: &str) -> Option<(usize, Piece<'a>)> {
        let Some(value) = self.fields(section).value(label) else {
            return self.lacks(&format!("`{label}` in section `{section}::`"));
        };
        let count = value.count(&format!("`{label}`"))?;
        if count > MOST {
            return value.refused(refusals::too_large(label, count, MOST));
        }
        Some((count, value))
    }

    /// Numbers behind `Targets :`, over as many lines as there are, and where they stand.
    fn targets(&self) -> Option<(Vec<f64>, Place)> {
        let lines = self.lines("TARGET DATA");
        let is_head = |line: &Piece<'_>| line.key_value().is_some_and(|(key, _)| key == "targets");
        let Some(at) = lines.iter().position(is_head) else {
            return self.lacks("`Targets` in section `TARGET DATA::`");
        };
        let beside = lines[at].behind(':').filter(|beside| !beside.is_blank());
        let below = lines[at + 1..].iter().take_while(|line| line.key_value().is_none());
        let mut below = below.filter(|line| !line.is_blank()).peekable();
        let first = below.peek().filter(|_| beside.is_none());
        let place = first.map_or(&lines[at], |first| *first).place();
        let mut words = Vec::new();
        for line in beside.iter().chain(below) {
            words.extend(line.words(char::is_whitespace));
            if words.len() > MOST {
                return line.refused(refusals::too_many_targets(MOST));
            }
        }
        Some((words.iter().filter_map(|word| word.number("a target")).collect(), place))
    }

    /// Deviations of each run at each target, µm; all of them are there.
    fn runs(&self, (runs, run_count): (usize, Piece<'a>), targets: usize) -> Option<Vec<Vec<f64>>> {
        let (mut found, mut whole) = (BTreeMap::new(), true);
        let is_row = |line: &&Piece<'_>| {
            let is_label = !line.begins_with_number() && line.text.trim_end().ends_with(':');
            !line.is_blank() && !is_label
        };
        for line in self.lines("DEVIATIONS").iter().filter(is_row) {
            let read = line.row(3, char::is_whitespace).and_then(|words| {
                let run = numbered(&words[0], "run", (runs, "Run-count"));
                let target = numbered(&words[1], "target", (targets, "Target-count"));
                let um = words[2].number("a deviation");
                Some(((run?, target?), um?))
            });
            let twice = read.and_then(|(place, um)| found.insert(place, um).map(|_| place));
            if let Some((run, target)) = twice {
                line.refuse(refusals::target_twice(target, run));
            }
            whole &= read.is_some() && twice.is_none();
        }
        for run in (1..=runs).filter(|_| whole) {
            let missing = (1..=targets).filter(|target| !found.contains_key(&(run, *target)));
            let missing: Vec<usize> = missing.collect();
            let problem = match missing.len() {
                0 => continue,
                count if count == targets => refusals::run_missing(run, runs),
                _ => refusals::targets_missing(run, shown(&joined(&missing))),
            };
            run_count.refuse(problem);
            if self.intake.notes.is_full() {
                break; // few lines may promise 10 000 runs of 10 000 targets
            }
        }
        let um: Vec<f64> = found.into_values().collect();
        (whole && um.len() == runs * targets)
            .then(|| um.chunks(targets).map(<[f64]>::to_vec).collect())
    }

    /// Which runs went which way, by the second flag, which `--runs` must not contradict; where the even runs do
    /// not look like that, it has to be stated. And what is said of return runs that were never made, which stand in
    /// the file as zeros.
    fn ways(&self, all: &[Vec<f64>]) -> Option<(Ways, Option<ImportFinding>)> {
        let flags = self.fields("TARGET DATA").value("Flags");
        let every_second = |from: usize| all.iter().skip(from).step_by(2).cloned();
        let (odd, even): (Vec<_>, Vec<_>) = (every_second(0).collect(), every_second(1).collect());
        let is_measured = even.iter().flatten().any(|um| *um != 0.0);
        let is_zero = !even.is_empty() && !is_measured;
        let (flagged, unclear) = match flags.and_then(|f| f.text.split_whitespace().nth(1)) {
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
        let at_flags = |problem: Problem| match flags {
            Some(flags) => flags.refused(problem),
            None => self.intake.notes.refused(problem),
        };
        let stated = self.intake.stated.runs;
        if let (Some(why), None) = (unclear, stated) {
            return at_flags(RUNS.missing_because(why));
        }
        let [forward, back] = Pass::BOTH.map(Some);
        match self.intake.settled(&RUNS, flagged.zip(flags), stated)? {
            Runs::Bidirectional if odd.len() == even.len() => {
                Some((vec![(forward, odd), (back, even)], None))
            }
            Runs::Bidirectional => at_flags(refusals::odd_runs(all.len())),
            Runs::Unidirectional if is_measured => Some((vec![(forward, all.to_vec())], None)),
            Runs::Unidirectional => {
                let runs = (2..=all.len()).step_by(2).collect();
                Some((vec![(forward, odd)], is_zero.then_some(ImportFinding::NeverMade { runs })))
            }
        }
    }

    /// Where the file notes a temperature of the material, whether its expansion was taken out has to be stated
    /// (contract §2.3); what is at stake is α·(T − 20 °C)·L, α of the file in µm/m per K, L = `length_mm`.
    fn check_material(&self, length_mm: f64) {
        let environment = self.fields("ENVIRONMENT");
        // A sensor that is absent writes zeros.
        let is_number = |number: &f64| *number != 0.0 && number.abs() <= LARGEST_NUMBER;
        let numbers = |begins: &'static str| {
            let lines = environment.0.iter().filter(move |(key, _)| key.starts_with(begins));
            lines.flat_map(move |(_, line)| {
                let numbers = line.text.split_whitespace().filter_map(plain_number);
                numbers.filter(is_number).map(move |number| (line, number))
            })
        };
        let from_20 = |celsius: f64| (celsius - REFERENCE_C).abs();
        let farthest = numbers("mattemp").max_by(|a, b| from_20(a.1).total_cmp(&from_20(b.1)));
        let Some((line, celsius)) = farthest else {
            return;
        };
        let noted = format!("a material temperature of {celsius} °C");
        let (stake, is_notable) = match numbers("expcoeff").next() {
            None => ("and no expansion coefficient".to_string(), true),
            Some((_, alpha)) => {
                let um = alpha * (celsius - REFERENCE_C) * length_mm / 1000.0;
                let stake = format!(
                    "{alpha} µm/m per K × ({celsius} − 20) K × {length_mm} mm = {um:.1} µm over the measured length"
                );
                (stake, um.abs() >= NOTABLE_UM)
            }
        };
        self.intake.check_material(noted, line.place(), stake, is_notable);
    }
}

/// An expansion that is smaller than this is no reason to warn, µm.
const NOTABLE_UM: f64 = 1.0;
/// Reference temperature of lengths, °C (ISO 1).
const REFERENCE_C: f64 = 20.0;

/// Where `key` followed by a colon begins as a word of its own.
fn key_at(text: &str, key: &str) -> Option<usize> {
    text.match_indices(key).map(|(at, _)| at).find(|at| {
        let alone = !text[..*at].ends_with(char::is_alphanumeric);
        alone && text[at + key.len()..].trim_start().starts_with(':')
    })
}

fn numbered(word: &Piece<'_>, what: &str, (most, key): (usize, &str)) -> Option<usize> {
    let number = word.count(&format!("the number of a {what}"))?;
    if number > most {
        return word.refused(refusals::beyond(what, number, key, most));
    }
    Some(number)
}
