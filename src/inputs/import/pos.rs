//! API XD Laser position export (`.pos`), linear.
//!
//! ```text
//!   API X-D Laser Measurement Linear Data Table …
//!   TestAxis: (X)   Unit: inch   RunNum: 1   NumofPos: 27   TestType: Unidirection
//!   Position  LasRead  LinearError  Status  AirTemp  AirPress  MatTemp …   ← what was measured
//!   API Linear Error Compensation Table …                                 ← averages: not read
//! ```
//! `LinearError` is measured − target. docs/import.md §6 names the sources.

use crate::control::controller::TableSign;
use crate::inputs::import::findings::ImportFinding;
use crate::inputs::import::reading::{FileContents, Passes, Way, Ways};
use crate::inputs::import::stated::{Format, Stated};
use crate::inputs::import::words::{AGAIN, Fields, Piece, Row, lines, rows};
use crate::quantity::units::UM_PER_MM;
use crate::text::delimited::LengthUnit;
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems, shown};

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

pub(super) fn read(source: &Source, stated: &Stated) -> Result<FileContents, Problems> {
    let lines = lines(source);
    let first = first_line(&lines, source)?;
    let mut problems = Problems::none();
    let term = stated.required_term(Format::Pos, &mut problems);
    let sign = stated.required_sign(&mut problems);
    let fields = fields(&lines);
    let axis = fields.value("TestAxis");
    let axis = axis.and_then(|axis| stated.axis_warning(&axis, Format::Pos, &mut problems));
    let version = fields.value("File Version").map_or("none", |word| word.text);
    let version = (version != KNOWN_VERSION)
        .then(|| ImportFinding::OtherVersion { version: shown(version), known: KNOWN_VERSION });
    let mut said = FileContents::saying(fields.said(&COPIED).chain(axis).chain(version));
    let header = Header::read(&fields, &first, &mut problems);
    let measured = problems.take(Measured::read(&lines, source));
    let (Some(header), Some(measured)) = (header, measured) else {
        return Err(problems);
    };
    if sign == Some(TableSign::AsCorrection) {
        let message =
            "`--sign as-correction` contradicts the file, whose `LinearError` is measured − target";
        problems.push(measured.heading.problem(message, "state `--sign as-error`"));
    }
    // Errors follow from reading and position, so they have their unit.
    let (positions, values) = (header.unit.word(), header.unit.word());
    said.find([ImportFinding::Units { positions, values }]);
    measured.refuse_contradictions(&mut problems);
    measured.refuse_bad_status(&mut problems);
    let passes = problems.take(header.passes(&measured));
    said.find(measured.warm_up());
    said.find(measured.material_warning(stated, &mut problems));
    said.find(measured.surroundings());
    let Some(passes) = passes else {
        return Err(problems);
    };
    let of_runs = passes.of_runs(stated);
    passes.reading((term, sign), said, of_runs, stated, problems)
}

/// Whether a text begins as such a file does.
pub(super) fn is_first_line(text: &str) -> bool {
    let text = text.trim().to_lowercase();
    text.starts_with("api ") && text.contains("laser measurement") && text.contains("data table")
}

fn first_line<'a>(lines: &[Piece<'a>], source: &Source) -> Result<Piece<'a>, Problem> {
    let first = lines.iter().find(|line| !line.is_blank());
    let is_linear = |first: &&Piece<'_>| {
        is_first_line(first.text) && first.text.to_lowercase().contains("linear data table")
    };
    first.copied().filter(|first| is_linear(&first)).ok_or_else(|| {
        Problem::new("the first line is not that of a full export of the format `pos`, expected a `Linear Data Table` of API")
            .at(first.map_or_else(|| source.place(&(0..0)), Piece::place))
            .help("save the linear measurement itself, not an evaluation; or export a CSV and map its columns: `--columns \"Position=target_mm,Error=ex_mm\"`")
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

/// What the fields say of the rows.
struct Header {
    unit: LengthUnit,
    positions: usize,
    runs: usize,
    /// Whether the runs go there and back.
    both: bool,
}

impl Header {
    fn read(fields: &Fields<'_>, first: &Piece<'_>, problems: &mut Problems) -> Option<Header> {
        let mut field = |label: &str| {
            let word = fields.value(label);
            if word.is_none() {
                problems.push(first.problem(format!("there is no `{label}`"), AGAIN));
            }
            Some((word?, format!("`{label}`")))
        };
        let [unit, positions, runs, kind] =
            ["Unit", "NumofPos", "RunNum", "TestType"].map(&mut field);
        let unit = unit.and_then(|(word, label)| {
            let expected = "a unit of length such as mm or inch";
            word.meaning(&label, expected, LengthUnit::from_text, problems)
        });
        let [positions, runs] = [positions, runs]
            .map(|field| field.and_then(|(word, label)| word.count(&label, problems)));
        let both = kind.and_then(|(word, label)| {
            let ways = |text: &str| match &text.to_lowercase() {
                text if text.starts_with("bi") => Some(true),
                text if text.starts_with("uni") => Some(false),
                _ => None,
            };
            word.meaning(&label, "`Unidirection` or `Bidirection`", ways, problems)
        });
        Some(Header { unit: unit?, positions: positions?, runs: runs?, both: both? })
    }

    /// Rows of each pass: `NumofPos` each, `RunNum` in one direction or in both. They go forward where the
    /// positions are those of the first pass, back where they come the other way round.
    fn passes(&self, measured: &Measured<'_>) -> Result<Passes, Problem> {
        let Header { unit, positions, runs, both } = *self;
        let back = if both { runs } else { 0 };
        let found = measured.rows.len();
        let expected = positions.saturating_mul(runs.saturating_add(back));
        if found != expected {
            let ways = if both { ", there and back" } else { "" };
            let message = format!(
                "{found} rows are measured, expected {expected}: {positions} positions, {runs} runs{ways}"
            );
            return Err(measured.heading.problem(message, AGAIN));
        }
        let column = |rows: &[Row<'_>], index: usize| -> Vec<f64> {
            rows.iter().map(|row| row.numbers[measured.at[index]] * unit.um()).collect()
        };
        let um = column(&measured.rows[..positions], 0);
        let mut ways: Ways = vec![(Way::Forward, Vec::new()), (Way::Reverse, Vec::new())];
        for pass in measured.rows.chunks(positions) {
            let (at, mut errors) = (column(pass, 0), column(pass, 1));
            let is_back = at != um;
            if is_back && !at.iter().rev().eq(&um) {
                let message = "a run has other positions than the first one";
                return Err(pass[0].line.problem(message, AGAIN));
            }
            if is_back {
                errors.reverse();
            }
            ways[usize::from(is_back)].1.push(errors);
        }
        let [forward, reverse] = [ways[0].1.len(), ways[1].1.len()];
        if [forward, reverse] != [runs, back] {
            let message = format!(
                "{forward} runs go from the first position to the last and {reverse} go back, expected {runs} and {back} as in `RunNum` and `TestType`"
            );
            let help = "the order of the rows shows the way of the axis; it is known from no file of this kind, so it is not guessed";
            return Err(measured.heading.problem(message, help));
        }
        ways.retain(|(_, runs)| !runs.is_empty());
        let targets = um.iter().map(|um| um / UM_PER_MM).collect();
        Ok(Passes { targets, place: measured.heading.place(), ways })
    }
}

/// What was measured.
struct Measured<'a> {
    heading: Piece<'a>,
    columns: Vec<&'a str>,
    /// Where the columns of the measurement stand.
    at: [usize; 4],
    rows: Vec<Row<'a>>,
}

impl<'a> Measured<'a> {
    fn read(lines: &[Piece<'a>], source: &Source) -> Result<Self, Problems> {
        for (number, heading) in lines.iter().enumerate() {
            let words = heading.words(char::is_whitespace);
            let columns: Vec<&str> = words.iter().map(|word| word.text).collect();
            let at = NEEDED.map(|name| columns.iter().position(|column| *column == name));
            if let [Some(position), Some(error), Some(reading), Some(status)] = at {
                let below = lines[number + 1..].iter();
                let below = below.take_while(|line| line.begins_with_number());
                let rows = rows(below, columns.len(), char::is_whitespace)?;
                let at = [position, error, reading, status];
                return Ok(Measured { heading: *heading, columns, at, rows });
            }
        }
        let message = format!(
            "there is no table with the columns {}: the file holds no measured rows",
            NEEDED.join(", ")
        );
        let help =
            "save the measurement with its readings, or map the columns of a CSV with `--columns`";
        Err(Problem::new(message).at(source.place(&(0..0))).help(help).into())
    }

    /// Rows with such a state of the laser.
    fn with_status(&self, is_such: impl Fn(f64) -> bool) -> Vec<&Row<'a>> {
        let [.., status] = self.at;
        self.rows.iter().filter(|row| is_such(row.numbers[status])).collect()
    }

    /// Error = reading − position in every row, with one sign of the reading: else one of them was changed.
    fn refuse_contradictions(&self, problems: &mut Problems) {
        let [position, error, reading, _] = self.at;
        let expected =
            |row: &Row<'_>, sign: f64| sign * row.numbers[reading] - row.numbers[position];
        let missed = |sign: f64| -> Vec<&Row<'a>> {
            let is_off =
                |row: &&Row<'_>| (expected(row, sign) - row.numbers[error]).abs() > LAST_DECIMALS;
            self.rows.iter().filter(is_off).collect()
        };
        let both = [1.0, -1.0].map(|sign| (missed(sign), sign));
        let Some((missed, sign)) = both.iter().min_by_key(|(missed, _)| missed.len()) else {
            return;
        };
        let Some(first) = missed.first() else { return };
        let message = format!(
            "{} of {} rows contradict themselves: here the error is {}, but reading less position is {:.6}",
            missed.len(),
            self.rows.len(),
            first.numbers[error],
            expected(first, *sign)
        );
        problems.push(first.line.problem(message, AGAIN));
    }

    /// Readings that the laser itself calls bad.
    fn refuse_bad_status(&self, problems: &mut Problems) {
        let bad = self.with_status(|status| ![0.0, WARM_UP].contains(&status));
        let Some(row) = bad.first() else {
            return;
        };
        let [.., status] = self.at;
        let status = row.numbers[status];
        let mut states = STATES.iter().zip(0_u8..);
        let state = states.find(|(_, number)| [f64::from(*number)].contains(&status));
        let message = format!(
            "the laser's status is {status} ({}) in {} of {} rows",
            state.map_or("unknown", |(words, _)| words),
            bad.len(),
            self.rows.len()
        );
        let help = "such a reading is no measurement: measure the run again";
        problems.push(row.line.problem(message, help));
    }

    fn warm_up(&self) -> Option<ImportFinding> {
        let (rows, of) =
            (self.with_status(|status| [WARM_UP].contains(&status)).len(), self.rows.len());
        (rows > 0).then_some(ImportFinding::WarmingUp { rows, of })
    }

    /// Names and values of air and material in words; `None` = no sensor was connected.
    fn sensors(&self) -> impl Iterator<Item = (&'a str, Option<String>)> {
        let others = self.columns.iter().enumerate();
        let others = others.filter(|(index, _)| !self.at.contains(index));
        others.map(|(index, name)| {
            let values = || self.rows.iter().map(|row| row.numbers[index]);
            let low = values().fold(f64::INFINITY, f64::min);
            let high = values().fold(f64::NEG_INFINITY, f64::max);
            let words = if low < high { format!("{low} … {high}") } else { low.to_string() };
            (*name, values().any(|value| ![NO_SENSOR].contains(&value)).then_some(words))
        })
    }

    /// The file names no unit of its temperatures.
    fn material_warning(&self, stated: &Stated, problems: &mut Problems) -> Option<ImportFinding> {
        let mut sensors = self.sensors();
        let material = sensors.find(|(name, is)| name.starts_with("MatTemp") && is.is_some());
        let (name, values) = material?;
        let noted =
            format!("a temperature of the material ({name} {})", values.unwrap_or_default());
        let stake = "the file names no unit of it";
        stated.material_warning(&noted, self.heading.place(), stake, problems)
    }

    /// Air and material as the file has them; it names no unit of theirs.
    fn surroundings(&self) -> impl Iterator<Item = ImportFinding> {
        let (noted, absent): (Vec<_>, Vec<_>) = self.sensors().partition(|(_, is)| is.is_some());
        let values: Vec<String> = noted
            .iter()
            .filter_map(|(name, is)| Some(format!("{name} {}", is.as_ref()?)))
            .collect();
        let sensors: Vec<String> = absent.iter().map(|(name, _)| name.to_string()).collect();
        let noted = (!values.is_empty()).then_some(ImportFinding::Surroundings { values });
        let absent = (!sensors.is_empty()).then_some(ImportFinding::NotMeasured { sensors });
        noted.into_iter().chain(absent)
    }
}
