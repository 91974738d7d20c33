//! `nonius import FILE -o errors.csv`

use crate::cli::outcome::Outcome;
use crate::cli::show::{Column, paragraphs, table};
use crate::cli::{Format, inputs, write};
use crate::inputs::import::stated::{Stated, word};
use crate::inputs::import::{
    self, Component, Imported, Measurement, encoding_word, squareness_lines, terms_of,
};
use crate::kit::sha256;
use crate::quantity::axis::Direction;
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
    /// Format of the file [default: by what stands in it]
    #[arg(long, value_name = "FORMAT")]
    from: Option<import::Format>,
    /// Encoding of its text, where it does not show: windows-1252 (= latin-1), windows-1250, gbk,
    /// utf-16le, utf-16be or utf-8
    #[arg(long, value_name = "ENCODING", value_parser = encoding_word)]
    encoding: Option<&'static encoding_rs::Encoding>,
    #[command(flatten)]
    stated: Stated,
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
    let stated = &options.stated;
    let imported = import::import(file, options.from, options.encoding, stated)?;
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
        Format::Json => Outcome::json(&document(file, &options.output, stated, &imported))?,
        Format::Text => Outcome::text(&series_table(&imported)),
    };
    Ok(outcome.writing(ready).saying(talk(&imported)).saying(next))
}

/// What the file says, what was done with it, what belongs into the job.
fn talk(imported: &Imported) -> String {
    let mut facts = vec![format!("read as {}", word(imported.format))];
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
        "format": word(imported.format),
        "output": output.display().to_string(),
        "stated": given,
        "facts": imported.facts,
        "warnings": imported.warnings,
        "series": series,
        "squareness_um_per_m": squareness,
    })
}
