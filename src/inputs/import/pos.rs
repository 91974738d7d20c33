//! API XD Laser position export (`.pos`), linear.
//!
//! ```text
//!   API X-D Laser Measurement Linear Data Table …
//!   TestAxis: (X)   Unit: inch   RunNum: 1   NumofPos: 27   TestType: Unidirection
//!   Position  LasRead  LinearError  Status  AirTemp  AirPress  MatTemp …   ← what was measured
//!   API Linear Error Compensation Table …                                 ← averages: not read
//! ```
//! Error = ± reading − position holds in each measured row, which shows that the values are measured − target.
//! docs/import.md §6 names the sources.

use crate::control::controller::TableSign;
use crate::inputs::import::findings::ImportFinding;
use crate::inputs::import::pos_rows::Measured;
use crate::inputs::import::reading::{FileContents, Passes, Way};
use crate::inputs::import::stated::{Format, Stated};
use crate::inputs::import::words::{AGAIN, Fields, Piece, lines};
use crate::quantity::units::UM_PER_MM;
use crate::text::delimited::{LengthUnit, plain_number};
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems, shown};

/// The version of the format that was available.
const KNOWN_VERSION: &str = "5";
/// Fields that are copied into our table.
const COPIED: [&str; 7] =
    ["Instrument(S/N)", "TestDate", "MachID", "MachName", "TestType", "ZeroOffset", "TestAxis"];
const CHANGED: &str = "the file was edited: save it again; values that were changed on purpose are imported from a CSV with `--columns`";

pub(super) fn read(source: &Source, stated: &Stated) -> Result<FileContents, Problems> {
    let lines = lines(source);
    let header = Header::of(&lines, source)?;
    let mut problems = Problems::none();
    let term = stated.required_term(Format::Pos, &mut problems);
    let sign = stated.required_sign(&mut problems);
    let mut said = header.said(stated, &mut problems);
    let unit = header.unit("Unit", &mut problems);
    let measured = problems.take(Measured::read(&lines, source));
    let (Some(unit), Some(measured)) = (unit, measured) else {
        return Err(problems);
    };
    // Errors follow from reading and position, so they have their unit.
    let (positions, values) = (unit.word(), unit.word());
    said.find([ImportFinding::Units { positions, values }]);
    let taken = header.measured(&measured, stated, &mut said, &mut problems);
    said.find(measured.material_warning(stated, &mut problems));
    let Some(mut passes) = taken else {
        return Err(problems);
    };
    for target in &mut passes.targets {
        *target = *target * unit.um() / UM_PER_MM;
    }
    passes.scale(unit.um());
    said.find(measured.surroundings());
    let of_runs = passes.of_runs(stated);
    passes.reading((term, sign), said, of_runs, stated, problems)
}

/// Whether a text begins as such a file does.
pub(super) fn is_first_line(text: &str) -> bool {
    let text = text.trim().to_lowercase();
    text.starts_with("api ") && text.contains("laser measurement") && text.contains("data table")
}

/// Lines `Key: value` above and below the tables; several may share a line, and a tab may stand between key
/// and value.
struct Header<'a> {
    first: Piece<'a>,
    fields: Fields<'a>,
}

impl<'a> Header<'a> {
    fn of(lines: &[Piece<'a>], source: &Source) -> Result<Header<'a>, Problem> {
        let first = lines.iter().find(|line| !line.is_blank());
        let is_linear = |first: &&Piece<'_>| {
            is_first_line(first.text) && first.text.to_lowercase().contains("linear data table")
        };
        let Some(first) = first.filter(is_linear) else {
            return Err(Problem::new("the first line is not that of a full export of the format `pos`, expected a `Linear Data Table` of API")
                .at(first.map_or_else(|| source.place(&(0..0)), Piece::place))
                .help("save the linear measurement itself, not an evaluation; or export a CSV and map its columns: `--columns \"Position=target_mm,Error=ex_mm\"`"));
        };
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
        let (first, fields) = (*first, Fields(fields));
        Ok(Header { first, fields })
    }

    /// What is copied, and what to look at.
    fn said(&self, stated: &Stated, problems: &mut Problems) -> FileContents {
        let axis = self.fields.value("TestAxis");
        let axis = axis.and_then(|axis| stated.axis_warning(&axis, Format::Pos, problems));
        let copied = self.fields.said(&COPIED);
        FileContents::saying(copied.chain(axis).chain(self.version_warning()))
    }

    fn version_warning(&self) -> Option<ImportFinding> {
        let version = self.fields.value("File Version");
        let version = version.map_or("none", |word| word.text);
        (version != KNOWN_VERSION)
            .then(|| ImportFinding::OtherVersion { version: shown(version), known: KNOWN_VERSION })
    }

    /// A field that has to be there.
    fn required(&self, label: &str, problems: &mut Problems) -> Option<Piece<'a>> {
        let word = self.fields.value(label);
        if word.is_none() {
            problems.push(self.first.problem(format!("there is no `{label}`"), AGAIN));
        }
        word
    }

    fn unit(&self, label: &str, problems: &mut Problems) -> Option<LengthUnit> {
        let word = self.required(label, problems)?;
        let unit = LengthUnit::from_text(word.text);
        if unit.is_none() {
            let expected = "a unit of length such as mm or inch";
            problems.push(word.unexpected(&format!("`{label}`"), expected, AGAIN));
        }
        unit
    }

    fn count(&self, label: &str, problems: &mut Problems) -> Option<usize> {
        let word = self.required(label, problems)?;
        word.count(&format!("`{label}`"), problems)
    }

    /// Whether the runs go there and back.
    fn is_bidirectional(&self, problems: &mut Problems) -> Option<bool> {
        let word = self.required("TestType", problems)?;
        let text = word.text.to_lowercase();
        let is_bidirectional = text.starts_with("bi");
        if !is_bidirectional && !text.starts_with("uni") {
            let expected = "`Unidirection` or `Bidirection`";
            problems.push(word.unexpected("`TestType`", expected, AGAIN));
            return None;
        }
        Some(is_bidirectional)
    }

    /// The measured rows, if they follow from the readings and are those of which the header speaks.
    fn measured(
        &self,
        measured: &Measured<'_>,
        stated: &Stated,
        said: &mut FileContents,
        problems: &mut Problems,
    ) -> Option<Passes> {
        let mut found = Problems::none();
        let relation = problems.take(measured.relation(CHANGED));
        measured.refuse_bad_status(&mut found);
        self.compare_ends(measured, &mut found);
        let passes = self.passes(measured, &mut found);
        let passes = problems.take(found.or_ok(passes))??;
        let relation = relation?;
        if stated.sign == Some(TableSign::AsCorrection) {
            let message = format!(
                "`--sign as-correction` contradicts the file: in every row LinearError = {relation} − Position, measured − target"
            );
            problems.push(measured.heading.problem(message, "state `--sign as-error`"));
        }
        let relation = relation.to_string();
        said.find([ImportFinding::Measured { relation }]);
        said.find(measured.warm_up());
        Some(passes)
    }

    /// The header names the first and the last position of a pass.
    fn compare_ends(&self, measured: &Measured<'_>, problems: &mut Problems) {
        let count = self.fields.value("NumofPos");
        let count: Option<usize> = count.and_then(|word| word.text.parse().ok());
        let last = count.and_then(|count| measured.rows.get(count.checked_sub(1)?));
        for (label, row) in [("IniPos", measured.rows.first()), ("EndPos", last)] {
            let expected = self.fields.value(label).and_then(|word| plain_number(word.text));
            let (Some(expected), Some(row)) = (expected, row) else {
                continue;
            };
            let (position, digit) = measured.position(row);
            if (position - expected).abs() > digit {
                let message = format!(
                    "the row stands at position {position}, expected {expected} as in `{label}`"
                );
                problems.push(row.line.problem(message, CHANGED));
            }
        }
    }

    /// Rows of each pass: `NumofPos` each, `RunNum` in one direction or in both.
    fn passes(&self, measured: &Measured<'_>, problems: &mut Problems) -> Option<Passes> {
        let positions = self.count("NumofPos", problems)?;
        let runs = self.count("RunNum", problems)?;
        let both = self.is_bidirectional(problems)?;
        let back = if both { runs } else { 0 };
        let (found, expected) =
            (measured.rows.len(), positions.saturating_mul(runs.saturating_add(back)));
        if found != expected {
            let ways = if both { ", there and back" } else { "" };
            let message = format!(
                "{found} rows are measured, expected {expected}: {positions} positions, {runs} runs{ways}"
            );
            problems.push(measured.heading.problem(message, AGAIN));
            return None;
        }
        let passes = problems.take(measured.sorted(positions))?;
        let counts = [Way::Forward, Way::Reverse].map(|way| {
            let mut of_way = passes.ways.iter().filter(|(other, _)| *other == way);
            of_way.next().map_or(0, |(_, runs)| runs.len())
        });
        if counts != [runs, back] {
            let [forward, reverse] = counts;
            let message = format!(
                "{forward} runs go from the first position to the last and {reverse} go back, expected {runs} and {back} as in `RunNum` and `TestType`"
            );
            let help = "the order of the rows shows the way of the axis; it is known from no file of this kind, so it is not guessed";
            problems.push(measured.heading.problem(message, help));
            return None;
        }
        Some(passes)
    }
}
