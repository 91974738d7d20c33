//! `nonius import FILE -o errors.csv`, and lists of captures into a form

use crate::cli::outcome::{Outcome, Output, held};
use crate::cli::screen::{Screen, paragraphs, table};
use crate::inputs::error_table::Series;
use crate::inputs::import::stated::{Stated, word};
use crate::inputs::import::{
    self, Imported, List, Measurement, encoding_word, fill, squareness_lines,
};
use crate::quantity::{Diagonal, Direction};
use crate::text::{Problems, Severity, Source, of_severity};
use crate::visit::files::{Files, file_name, with_slashes};
use crate::visit::job_files::Given;
use clap::Args;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

// Options of `import`. What a file does not carry has to be stated; see docs/measuring.md §5.
#[derive(Args, Debug)]
#[command(mut_arg("output", |arg| arg.required(true)))]
pub(super) struct Options {
    /// The measurement, or with a form the list of an axis; `-` = standard input
    #[arg(required_unless_present = "form")]
    file: Option<PathBuf>,
    /// Fill in these readings, as `new` and `program` write them, from lists of captures
    #[arg(long)]
    form: Option<PathBuf>,
    /// With a form: the list of the diagonal PPP
    #[arg(long, value_name = "FILE", requires = "form")]
    ppp: Option<PathBuf>,
    /// With a form: that of NPP
    #[arg(long, value_name = "FILE", requires = "form")]
    npp: Option<PathBuf>,
    /// With a form: that of PNP
    #[arg(long, value_name = "FILE", requires = "form")]
    pnp: Option<PathBuf>,
    /// With a form: that of PPN
    #[arg(long, value_name = "FILE", requires = "form")]
    ppn: Option<PathBuf>,
    /// Format of the file [default: by what stands in it]
    #[arg(long, value_name = "FORMAT")]
    from: Option<import::Format>,
    /// Encoding of its text, where it does not show: windows-1252 (= latin-1), windows-1250, gbk,
    /// utf-16le, utf-16be or utf-8
    #[arg(long, value_name = "ENCODING", value_parser = encoding_word)]
    encoding: Option<&'static encoding_rs::Encoding>,
    #[command(flatten)]
    stated: Stated,
    #[command(flatten)]
    output: Output,
}

pub(super) fn run(options: &Options, files: &dyn Files) -> Result<Outcome, Problems> {
    if let Some(form) = &options.form {
        return fill_in(options, form, files);
    }
    options.output.ensure_new(files, "the error table")?;
    let file = Given::read(files, options.file.as_deref().unwrap_or(Path::new("-")))?;
    let file = file.measurement();
    let imported = import::import(file, options.from, options.encoding, &options.stated)?;
    let place = options.output.place().unwrap_or(Path::new("-"));
    let next = format!(
        "\nnext: name it in [measurement] of a job, `errors = \"{}\"`; a list joins the tables of several axes, `errors = [\"x.csv\", \"y.csv\"]`",
        file_name(place)
    );
    options.output.deliver(
        Some(held(imported.text.clone())),
        || screen(&imported),
        || document(file, place, &options.stated, &imported),
        &next,
    )
}

/// What the file says, what was done with it, what belongs into the job.
fn screen(imported: &Imported) -> Screen {
    let words = |severity| of_severity(&imported.findings, severity).into_iter();
    let facts = words(Severity::Label).map(|fact| format!("\n{fact}"));
    Screen {
        verdict: format!("read as {}{}", word(imported.format), facts.collect::<String>()),
        figures: paragraphs(&[
            series_table(imported),
            squareness_lines(&imported.squareness).join("\n"),
        ]),
        always: words(Severity::Note).map(|words| format!("warning: {words}")).collect(),
        ..Screen::default()
    }
}

fn terms(series: &Series) -> Vec<String> {
    series.components().map(|component| component.to_string()).collect()
}

fn series_table(imported: &Imported) -> String {
    let rows = imported.draft.series.iter().map(|series| {
        let end = |mm: Option<f64>| mm.map_or_else(String::new, |mm| mm.to_string());
        let [from, to] = series.ends_mm().map(end);
        let travel = series.direction.map_or("both", Direction::symbol);
        let has_u = series.uncertainties_um.iter().any(|(_, u)| u.is_some());
        let u = if has_u { "yes" } else { "not stated" };
        let (points, terms) = (series.positions.len(), terms(series).join(" "));
        format!("{}\t{travel}\t{points}\t{from}\t{to}\t{terms}\t{u}", series.axis)
    });
    table("axis\ttravel\t>points\t>from/mm\t>to/mm\tmeasured\tu", rows)
}

/// Options with what was stated.
fn statements(stated: &Stated) -> Map<String, Value> {
    let given = stated.given().into_iter();
    given.map(|(option, value)| (option.to_string(), json!(value))).collect()
}

/// The summary for scripts.
fn document(file: Measurement<'_>, output: &Path, stated: &Stated, imported: &Imported) -> Value {
    let series = imported.draft.series.iter().map(|series| {
        json!({
            "axis": series.axis.key(),
            "direction": series.direction.map(Direction::symbol),
            "terms": terms(series),
            "points": series.positions.len(),
            "from_mm": series.ends_mm()[0],
            "to_mm": series.ends_mm()[1],
        })
    });
    let squareness = imported.squareness.iter();
    let squareness = squareness.map(|s| (s.pair.to_string(), json!(s.um_per_m)));
    json!({
        "schema": 1,
        "source": { "path": file.name, "sha256": file.sha256 },
        "format": word(imported.format),
        "output": with_slashes(output),
        "stated": statements(stated),
        "facts": of_severity(&imported.findings, Severity::Label),
        "warnings": of_severity(&imported.findings, Severity::Note),
        "series": series.collect::<Vec<Value>>(),
        "squareness_um_per_m": squareness.collect::<Map<_, _>>(),
    })
}

/// Fills the form in; a file without diagonal is the list of an axis.
fn fill_in(options: &Options, form: &Path, files: &dyn Files) -> Result<Outcome, Problems> {
    options.output.ensure_new(files, "the readings")?;
    let (name, bytes) = files.form(form, options.output.place())?;
    let form = Source::from_bytes(&name, &bytes)?;
    let Options { ppp, npp, pnp, ppn, .. } = options;
    let of_diagonals = Diagonal::ALL.map(Some).into_iter().zip([ppp, npp, pnp, ppn]);
    let named = of_diagonals.chain([(None, &options.file)]);
    let named = named.filter_map(|(of, file)| Some((of, file.as_deref()?)));
    let lists = named.map(|(of, file)| Ok((of, Given::read(files, file)?)));
    let lists: Vec<(Option<Diagonal>, Given<'_>)> = lists.collect::<Result<_, Problems>>()?;
    let lists: Vec<List<'_>> = lists.iter().map(|(of, file)| (*of, file.measurement())).collect();
    let text = fill(&form, &lists, options.encoding, &options.stated)?;
    let verdict = "every capture of the form has its value".to_string();
    let sources = lists.iter();
    let sources = sources.map(|(_, list)| json!({ "path": list.name, "sha256": list.sha256 }));
    let document = json!({
        "schema": 1,
        "format": "list",
        "lists": sources.collect::<Vec<Value>>(),
        "stated": statements(&options.stated),
    });
    let screen = || Screen::of(verdict);
    options.output.deliver(Some(held(text)), screen, || document, "")
}
