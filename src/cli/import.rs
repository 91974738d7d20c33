//! `nonius import FILE -o errors.csv`

use crate::cli::outcome::Outcome;
use crate::cli::show::{Column, paragraphs, table};
use crate::cli::{Format, inputs, write};
use crate::inputs::import::choices::{
    Decimal, Encoding, MaterialCorrected, Rows, Runs, Sign, Travel, Values,
};
use crate::inputs::import::stated::Stated;
use crate::inputs::import::{self, Component, Imported, Measurement, squareness_lines, terms_of};
use crate::kit::sha256;
use crate::quantity::axis::{Axis, Direction};
use crate::text::delimited::LengthUnit;
use crate::text::problem::{Problem, Problems};
use clap::Args;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

// Options of `import`. What a file does not carry has to be stated; see docs/import.md.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// The measurement; `-` = standard input
    file: PathBuf,
    /// The error table (CSV); `-` = standard output
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Replace an existing error table
    #[arg(long)]
    force: bool,
    /// Format of the file: rtl, ren, pos, etalon, isg or columns [default: by what stands in it]
    #[arg(long, value_name = "FORMAT", value_parser = format_word)]
    from: Option<import::Format>,
    /// Encoding of its text, where it does not show: windows-1252 (= latin-1), windows-1250, gbk,
    /// utf-16le, utf-16be or utf-8
    #[arg(long, value_name = "ENCODING", value_parser = encoding_word)]
    encoding: Option<Encoding>,
    /// The moving axis
    #[arg(long, value_parser = axis_word)]
    axis: Option<Axis>,
    /// What was measured, e.g. EXX (positioning of X) or EYX (deviation in Y while X moves)
    #[arg(long, value_parser = term_word)]
    term: Option<Component>,
    /// Machine coordinate of the first target, mm
    #[arg(long, value_name = "MM", allow_hyphen_values = true, value_parser = millimetres)]
    first_target_at_mm: Option<f64>,
    /// Way of the axis from the first target to the last, in machine coordinates: + or -
    #[arg(long, value_name = "+|-", allow_hyphen_values = true, value_parser = direction_word)]
    targets_run: Option<Direction>,
    /// Direction of travel of rows that do not name one: +, - or both
    #[arg(long, value_name = "+|-|both", allow_hyphen_values = true, value_parser = travel_word)]
    direction: Option<Travel>,
    /// Way of the axis, in machine coordinates, in rows whose direction is +: + or -
    #[arg(long, value_name = "+|-", allow_hyphen_values = true, value_parser = direction_word)]
    plus_moves: Option<Direction>,
    /// as-error = measured - target, as the file counts; as-correction = what has to be added
    #[arg(long, value_parser = sign_word)]
    sign: Option<Sign>,
    /// Unit of the values: um, mm, in or uin
    #[arg(long, value_parser = unit_word)]
    unit: Option<LengthUnit>,
    /// How the values of a compensation table count: absolute (others cannot be read)
    #[arg(long, value_parser = values_word)]
    values: Option<Values>,
    /// unidirectional, or bidirectional (even runs go back)
    #[arg(long, value_parser = runs_word)]
    runs: Option<Runs>,
    /// Which rows of a file that holds both: measured, or averages (the maker's)
    #[arg(long, value_parser = rows_word)]
    rows: Option<Rows>,
    /// Whether the instrument brought the readings to 20 °C of the material: yes, no or not-stated
    #[arg(long, value_parser = material_word)]
    material_corrected: Option<MaterialCorrected>,
    /// Sign before the decimals of a delimited text, where it does not show: point or comma
    #[arg(long, value_parser = decimal_word)]
    decimal: Option<Decimal>,
    /// Which column holds what (#3 = the third one), e.g. "AXn [mm]=position_mm,Delta [mm]=ex_mm"
    #[arg(long, value_name = "NAME=COLUMN,…")]
    columns: Option<String>,
    /// What to print
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

pub(super) fn run(options: &Options) -> Result<Outcome, Problems> {
    let to_stdout = options.output == Path::new("-");
    if to_stdout && options.format == Format::Json {
        return Err(Problem::new(
            "the error table and the summary cannot both go to standard output",
        )
        .help("name a file with `-o`, or leave `--format json` out")
        .into());
    }
    if !to_stdout {
        write::ensure_new(&options.output, options.force)?;
    }
    let (path, bytes) = inputs::read_argument(&options.file)?;
    let file = Measurement {
        path: &path,
        name: &inputs::file_name(&options.file),
        sha256: &sha256(&bytes),
        bytes: &bytes,
    };
    let stated = options.stated();
    let imported = import::import(file, options.from, options.encoding, &stated)?;
    if to_stdout {
        let talk = talk(&imported);
        return Ok(Outcome::bytes(imported.text.into_bytes()).saying(talk));
    }
    let ready = write::write_file(&options.output, imported.text.as_bytes(), options.force)?;
    let next = format!(
        "wrote {}\nnext: name it in [measurement] of a job, `errors = \"{}\"`; a list joins the tables of several axes, `errors = [\"x.csv\", \"y.csv\"]`",
        options.output.display(),
        inputs::file_name(&options.output)
    );
    let outcome = match options.format {
        Format::Json => Outcome::json(&document(file, &options.output, &stated, &imported))?,
        Format::Text => Outcome::text(&series_table(&imported)),
    };
    Ok(outcome.writing(ready).saying(talk(&imported)).saying(next))
}

impl Options {
    fn stated(&self) -> Stated {
        Stated {
            axis: self.axis,
            term: self.term,
            first_target_at_mm: self.first_target_at_mm,
            targets_run: self.targets_run,
            travel: self.direction,
            plus_moves: self.plus_moves,
            sign: self.sign,
            unit: self.unit,
            values: self.values,
            runs: self.runs,
            rows: self.rows,
            material_corrected: self.material_corrected,
            decimal: self.decimal,
            columns: self.columns.clone(),
        }
    }
}

/// What the file says, what was done with it, what belongs into the job.
fn talk(imported: &Imported) -> String {
    let mut facts = vec![format!("read as {}", imported.format.word())];
    facts.extend(imported.facts.iter().cloned());
    let warnings = imported.warnings.iter().map(|w| format!("warning: {w}"));
    paragraphs(&[
        facts.join("\n"),
        warnings.collect::<Vec<String>>().join("\n"),
        squareness_lines(&imported.squareness).join("\n"),
    ])
}

fn series_table(imported: &Imported) -> String {
    let columns = [
        Column::Left("axis"),
        Column::Left("travel"),
        Column::Right("points"),
        Column::Right("from/mm"),
        Column::Right("to/mm"),
        Column::Left("measured"),
        Column::Left("u"),
    ];
    let rows = imported.draft.series.iter().map(|series| {
        let end = |mm: Option<&f64>| mm.map_or_else(String::new, f64::to_string);
        let terms: Vec<String> = terms_of(series).iter().map(Component::to_string).collect();
        let has_u = series.uncertainties_um.iter().any(|(_, u)| u.is_some());
        vec![
            series.axis.to_string(),
            series
                .direction
                .map_or("both", Direction::symbol)
                .to_string(),
            series.positions_mm.len().to_string(),
            end(series.positions_mm.first()),
            end(series.positions_mm.last()),
            terms.join(" "),
            if has_u { "yes" } else { "not stated" }.to_string(),
        ]
    });
    table(&columns, rows)
}

/// The summary for scripts.
fn document(file: Measurement<'_>, output: &Path, stated: &Stated, imported: &Imported) -> Value {
    let series: Vec<Value> = imported
        .draft
        .series
        .iter()
        .map(|series| {
            let terms: Vec<String> = terms_of(series).iter().map(Component::to_string).collect();
            json!({
                "axis": series.axis.key(),
                "direction": series.direction.map(Direction::symbol),
                "terms": terms,
                "points": series.positions_mm.len(),
                "from_mm": series.positions_mm.first(),
                "to_mm": series.positions_mm.last(),
            })
        })
        .collect();
    let given = stated.given().into_iter();
    let given: Map<String, Value> = given
        .map(|(option, value)| (option.to_string(), json!(value)))
        .collect();
    let squareness = imported.squareness.iter();
    let squareness: Map<String, Value> = squareness
        .map(|s| (s.pair.to_string(), json!(s.um_per_m)))
        .collect();
    json!({
        "schema": 1,
        "source": { "path": file.name, "sha256": file.sha256 },
        "format": imported.format.word(),
        "output": output.display().to_string(),
        "stated": given,
        "facts": imported.facts,
        "warnings": imported.warnings,
        "series": series,
        "squareness_um_per_m": squareness,
    })
}

/// The value with this word, or the words that there are.
pub(super) fn by_word<T: Copy>(
    text: &str,
    all: &[T],
    word: impl Fn(T) -> &'static str,
) -> Result<T, String> {
    let found = all.iter().copied().find(|value| word(*value) == text);
    let words: Vec<&str> = all.iter().map(|value| word(*value)).collect();
    found.ok_or_else(|| format!("expected {}", words.join(", ")))
}

fn format_word(text: &str) -> Result<import::Format, String> {
    by_word(text, &import::Format::ALL, import::Format::word)
}

pub(super) fn encoding_word(text: &str) -> Result<Encoding, String> {
    match text {
        "latin-1" => Ok(Encoding::Windows1252),
        _ => by_word(text, &Encoding::ALL, Encoding::word),
    }
}

pub(super) fn axis_word(text: &str) -> Result<Axis, String> {
    Axis::from_letter(text).ok_or_else(|| "expected x, y or z".to_string())
}

fn term_word(text: &str) -> Result<Component, String> {
    Component::from_name(text).ok_or_else(|| "expected EXX, EYX … EZZ, EAX … ECZ".to_string())
}

pub(super) fn millimetres(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|mm| mm.abs() <= LONGEST_MM);
    number.ok_or_else(|| "expected a number of mm, with a decimal point".to_string())
}

/// A kilometre: no machine is longer.
const LONGEST_MM: f64 = 1e6;

pub(super) fn direction_word(text: &str) -> Result<Direction, String> {
    by_word(text, &Direction::BOTH, Direction::symbol)
}

fn travel_word(text: &str) -> Result<Travel, String> {
    let all = [
        Travel::One(Direction::Plus),
        Travel::One(Direction::Minus),
        Travel::Both,
    ];
    by_word(text, &all, Travel::word)
}

pub(super) fn sign_word(text: &str) -> Result<Sign, String> {
    by_word(text, &[Sign::AsError, Sign::AsCorrection], Sign::word)
}

fn unit_word(text: &str) -> Result<LengthUnit, String> {
    by_word(text, &LengthUnit::ALL, LengthUnit::word)
}

fn rows_word(text: &str) -> Result<Rows, String> {
    by_word(text, &[Rows::Measured, Rows::Averages], Rows::word)
}

fn values_word(text: &str) -> Result<Values, String> {
    by_word(text, &[Values::Absolute], Values::word)
}

pub(super) fn material_word(text: &str) -> Result<MaterialCorrected, String> {
    let all = [
        MaterialCorrected::Yes,
        MaterialCorrected::No,
        MaterialCorrected::NotStated,
    ];
    by_word(text, &all, MaterialCorrected::word)
}

fn decimal_word(text: &str) -> Result<Decimal, String> {
    by_word(text, &[Decimal::Point, Decimal::Comma], Decimal::word)
}

pub(super) fn runs_word(text: &str) -> Result<Runs, String> {
    by_word(
        text,
        &[Runs::Unidirectional, Runs::Bidirectional],
        Runs::word,
    )
}
