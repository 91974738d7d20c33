//! API XD Laser position export (`.pos`), linear.
//!
//! ```text
//!   API X-D Laser Measurement Linear Data Table …
//!   TestAxis: (X)   Unit: inch   RunNum: 1   NumofPos: 27   TestType: Unidirection
//!   Position  LasRead  LinearError  Status  AirTemp  AirPress  MatTemp …   ← what was measured
//!   API Linear Error Compensation Table …                                 ← averages: not read
//! ```
//! `LinearError` is measured − target. docs/measuring.md §6 names the sources.

use crate::control::controller::TableSign;
use crate::inputs::findings::ImportFinding;
use crate::inputs::import::intake::{Contents, Fields, Intake, Piece};
use crate::inputs::import::reading::Passes;
use crate::inputs::refusals::{self, AGAIN};
use crate::quantity::{Pass, UM_PER_MM, ends};
use crate::text::{LengthUnit, shown};

/// The version of the format that was available.
const KNOWN_VERSION: &str = "5";
/// Fields that are copied into our table.
const COPIED: [&str; 7] =
    ["Instrument(S/N)", "TestDate", "MachID", "MachName", "TestType", "ZeroOffset", "TestAxis"];
/// Columns of the measurement: where, how much, and the state of the laser.
const NEEDED: [&str; 4] = ["Position", "LinearError", "LasRead", "Status"];
/// Error = ± reading − position within the last decimals of all three: less than this part of the unit.
const LAST_DECIMALS: f64 = 2e-6;
/// What the file calls its laser states, from 0.
const STATES: [&str; 5] = ["Laser Normal", "Warm Up", "Path Error", "Over Speed", "Wireless Error"];
/// With a state beyond that of warming up a reading is none.
const WARM_UP: f64 = 1.0;
/// A sensor that is not connected; the footer says `N/A` then.
const NO_SENSOR: f64 = -1.0;

pub(super) fn read<'a>(intake: &'a Intake<'a>) -> Option<Contents> {
    let lines = intake.lines();
    let first = first_line(&lines, intake)?;
    let fields = fields(&lines);
    let axis = fields.value("TestAxis");
    let (term, sign) = (intake.term(), intake.sign(None));
    intake.say(fields.said(&COPIED));
    axis.iter().for_each(|axis| intake.check_axis(axis));
    let version = fields.value("File Version").map_or("none", |word| word.text);
    intake.say(
        (version != KNOWN_VERSION)
            .then(|| ImportFinding::OtherVersion { version: shown(version), known: KNOWN_VERSION }),
    );
    let (header, measured) = (header(&fields, &first), PosColumns::read(&lines, intake));
    let (header, measured) = (header?, measured?);
    if sign == Some(TableSign::AsCorrection) {
        let help = "state `--sign as-error`";
        measured.heading.refuse(refusals::is_measured_less_target("`LinearError` is", help));
    }
    // Errors follow from reading and position, so they have their unit.
    let unit = header.0.word();
    intake.say([ImportFinding::Units { positions: unit, values: unit }]);
    measured.refuse_contradictions();
    measured.refuse_bad_status();
    let passes = measured.passes(header);
    intake.say(measured.warm_up());
    measured.check_material(intake);
    intake.say(measured.surroundings());
    let passes = passes?;
    passes.contents(term, sign, passes.of_runs(intake), intake)
}

/// Whether a text begins as such a file does.
pub(super) fn is_first_line(text: &str) -> bool {
    let text = text.trim().to_lowercase();
    text.starts_with("api ") && text.contains("laser measurement") && text.contains("data table")
}

fn first_line<'a>(lines: &[Piece<'a>], intake: &Intake<'_>) -> Option<Piece<'a>> {
    let first = lines.iter().find(|line| !line.is_blank());
    let is_linear =
        |text: &str| is_first_line(text) && text.to_lowercase().contains("linear data table");
    first.filter(|first| is_linear(first.text)).copied().or_else(|| {
        let place = first.map_or_else(|| intake.top(), Piece::place);
        intake.notes.refused(refusals::no_linear_data().at(place))
    })
}

/// Lines `Key: value` above and below the tables; several may share a line, and a tab may stand between key
/// and value.
fn fields<'a>(lines: &[Piece<'a>]) -> Fields<'a> {
    let mut fields = Vec::new();
    for line in lines {
        let mut open: Option<String> = None;
        for part in line.words(|c| c == '\t') {
            match (open.take(), part.key_value()) {
                (Some(key), _) => fields.push((key, part)),
                (None, Some((key, value))) if value.text.is_empty() => open = Some(key),
                (None, Some(pair)) => fields.push(pair),
                (None, None) => {}
            }
        }
    }
    Fields(fields)
}

/// What the fields say of the rows: their unit, the number of positions, of runs there and of runs back.
type Header = (LengthUnit, usize, [usize; 2]);

fn header(fields: &Fields<'_>, first: &Piece<'_>) -> Option<Header> {
    let [unit, positions, runs, kind] = ["Unit", "NumofPos", "RunNum", "TestType"].map(|label| {
        fields.value(label).or_else(|| first.refused(refusals::there_is_no(format!("`{label}`"))))
    });
    let unit = unit.and_then(|word| {
        word.read("`Unit`", "a unit of length such as mm or inch", AGAIN, LengthUnit::from_text)
    });
    let positions = positions.and_then(|word| word.count("`NumofPos`"));
    let runs = runs.and_then(|word| word.count("`RunNum`"));
    let both = kind.and_then(|word| {
        word.read("`TestType`", "`Unidirection` or `Bidirection`", AGAIN, |text| {
            let text = text.to_lowercase();
            let both = text.starts_with("bi");
            (both || text.starts_with("uni")).then_some(both)
        })
    });
    let (runs, both) = (runs?, both?);
    Some((unit?, positions?, [runs, if both { runs } else { 0 }]))
}

/// What was measured, column by column.
struct PosColumns<'a> {
    heading: Piece<'a>,
    lines: Vec<Piece<'a>>,
    positions: Vec<f64>,
    errors: Vec<f64>,
    readings: Vec<f64>,
    states: Vec<f64>,
    /// Air and material.
    sensors: Vec<(&'a str, Vec<f64>)>,
}

impl<'a> PosColumns<'a> {
    fn read(lines: &[Piece<'a>], intake: &'a Intake<'a>) -> Option<Self> {
        let words_of = |line: &Piece<'a>| -> Vec<&'a str> {
            line.words(char::is_whitespace).iter().map(|word| word.text).collect()
        };
        let is_heading = |line: &Piece<'a>| {
            let words = words_of(line);
            NEEDED.iter().all(|name| words.contains(name))
        };
        let Some(number) = lines.iter().position(is_heading) else {
            return intake
                .notes
                .refused(refusals::nothing_measured(NEEDED.join(", ")).at(intake.top()));
        };
        let heading = lines[number];
        let names = words_of(&heading);
        let below = lines[number + 1..].iter().take_while(|line| line.begins_with_number());
        let lines: Vec<Piece<'a>> = below.copied().collect();
        let columns = intake.numbers(&lines, names.len(), char::is_whitespace)?;
        let at = NEEDED.map(|name| names.iter().position(|own| *own == name).unwrap_or_default());
        let [positions, errors, readings, states] = at.map(|at| columns[at].clone());
        let others = names.into_iter().zip(columns).enumerate();
        let others = others.filter(|(index, _)| !at.contains(index));
        let sensors = others.map(|(_, sensor)| sensor).collect();
        Some(PosColumns { heading, lines, positions, errors, readings, states, sensors })
    }

    /// Rows of each pass: `NumofPos` each, `RunNum` in one direction or in both. They go forward where the
    /// positions are those of the first pass, back where they come the other way round.
    fn passes(&self, (unit, positions, [runs, back]): Header) -> Option<Passes> {
        let found = self.lines.len();
        let expected = positions.saturating_mul(runs.saturating_add(back));
        if found != expected {
            let ways = if back > 0 { ", there and back" } else { "" };
            let problem = refusals::other_rows(found, expected, positions, runs, ways);
            return self.heading.refused(problem);
        }
        let um = |column: &[f64]| column.iter().map(|own| own * unit.um()).collect::<Vec<f64>>();
        let (at, mut errors) = (um(&self.positions), um(&self.errors));
        let first = &at[..positions];
        let mut ways = Pass::BOTH.map(|pass| (Some(pass), Vec::new())).to_vec();
        let passes = at.chunks(positions).zip(errors.chunks_mut(positions));
        for (line, (at, errors)) in self.lines.iter().step_by(positions).zip(passes) {
            let is_back = at != first;
            if is_back && !at.iter().rev().eq(first) {
                return line.refused(refusals::other_positions());
            }
            if is_back {
                errors.reverse();
            }
            ways[usize::from(is_back)].1.push(errors.to_vec());
        }
        let [forward, reverse] = [ways[0].1.len(), ways[1].1.len()];
        if [forward, reverse] != [runs, back] {
            return self.heading.refused(refusals::other_ways(forward, reverse, runs, back));
        }
        ways.retain(|(_, runs)| !runs.is_empty());
        let targets = first.iter().map(|um| um / UM_PER_MM).collect();
        Some(Passes { targets, place: self.heading.place(), ways })
    }

    /// Rows with such a state of the laser.
    fn with_state(&self, is_such: impl Fn(f64) -> bool) -> Vec<usize> {
        (0..self.states.len()).filter(|at| is_such(self.states[*at])).collect()
    }

    /// Error = reading − position in every row, with one sign of the reading: else one of them was changed.
    fn refuse_contradictions(&self) {
        let expected = |at: usize, sign: f64| sign * self.readings[at] - self.positions[at];
        let is_off =
            |at: usize, sign: f64| (expected(at, sign) - self.errors[at]).abs() > LAST_DECIMALS;
        let rows = self.lines.len();
        let missed = [1.0, -1.0]
            .map(|sign| (sign, (0..rows).filter(|at| is_off(*at, sign)).collect::<Vec<usize>>()));
        let fewest = missed.into_iter().min_by_key(|(_, missed)| missed.len());
        if let Some((sign, missed)) = fewest.filter(|(_, missed)| !missed.is_empty()) {
            let (first, count) = (missed[0], missed.len());
            let (error, expected) = (self.errors[first], expected(first, sign));
            self.lines[first].refuse(refusals::contradictory(count, rows, error, expected));
        }
    }

    /// Readings that the laser itself calls bad.
    fn refuse_bad_status(&self) {
        let bad = self.with_state(|state| ![0.0, WARM_UP].contains(&state));
        let Some(first) = bad.first() else {
            return;
        };
        let status = self.states[*first];
        let mut states = STATES.iter().zip(0_u8..);
        let state = states.find(|(_, number)| [f64::from(*number)].contains(&status));
        let state = state.map_or("unknown", |(words, _)| words);
        let (count, rows) = (bad.len(), self.states.len());
        self.lines[*first].refuse(refusals::bad_status(status, state, count, rows));
    }

    fn warm_up(&self) -> Option<ImportFinding> {
        let rows = self.with_state(|state| [WARM_UP].contains(&state)).len();
        (rows > 0).then_some(ImportFinding::WarmingUp { rows, of: self.states.len() })
    }

    /// Names and values of air and material in words; `None` = no sensor was connected.
    fn noted(&self) -> impl Iterator<Item = (&'a str, Option<String>)> {
        self.sensors.iter().map(|(name, values)| {
            let (low, high) = ends(values.iter().copied());
            let words = if low < high { format!("{low} … {high}") } else { low.to_string() };
            let is_absent = values.iter().all(|value| [NO_SENSOR].contains(value));
            (*name, (!is_absent).then_some(format!("{name} {words}")))
        })
    }

    /// The file names no unit of its temperatures.
    fn check_material(&self, intake: &Intake<'_>) {
        let mut noted = self.noted().filter(|(name, _)| name.starts_with("MatTemp"));
        if let Some(values) = noted.find_map(|(_, values)| values) {
            let noted = format!("a temperature of the material ({values})");
            let stake = "the file names no unit of it".to_string();
            intake.check_material(noted, self.heading.place(), stake, true);
        }
    }

    /// Air and material as the file has them; it names no unit of theirs.
    fn surroundings(&self) -> impl Iterator<Item = ImportFinding> {
        let values: Vec<String> = self.noted().filter_map(|(_, is)| is).collect();
        let absent = self.noted().filter(|(_, is)| is.is_none());
        let sensors: Vec<String> = absent.map(|(name, _)| name.to_string()).collect();
        let noted = (!values.is_empty()).then_some(ImportFinding::Surroundings { values });
        let absent = (!sensors.is_empty()).then_some(ImportFinding::NotMeasured { sensors });
        noted.into_iter().chain(absent)
    }
}
