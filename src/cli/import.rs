//! `nonius import FILE -o errors.csv`, and lists of captures into a form

use crate::cli::outcome::{Outcome, Output, held};
use crate::cli::screen::{Screen, paragraphs, table};
use crate::inputs::error_table::Series;
use crate::inputs::import::stated::{ImportFacts, word};
use crate::inputs::import::{self, Imported, Kind, List, fill, squareness_lines};
use crate::judge::active::HashedFile;
use crate::quantity::{Diagonal, Direction};
use crate::text::{Finding, NamedEntries, Problems, Severity, Source, of_severity};
use crate::visit::files::{Files, file_name, with_slashes};
use crate::visit::job_files::InputFile;
use clap::Args;
use serde::Serialize;
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
    #[command(flatten)]
    stated: ImportFacts,
    #[command(flatten)]
    output: Output,
}

pub(super) fn run(options: &Options, files: &dyn Files) -> Result<Outcome, Problems> {
    if let Some(form) = &options.form {
        return fill_in(options, form, files);
    }
    options.output.ensure_new(files, "the error table")?;
    let file = InputFile::read(files, options.file.as_deref().unwrap_or(Path::new("-")))?;
    let imported = import::import(file.measurement(), &options.stated)?;
    let place = options.output.place().unwrap_or(Path::new("-"));
    let document = Document {
        source: &file.hash,
        format: word(imported.format),
        output: with_slashes(place),
        stated: options.stated.given().into_iter().collect(),
        facts: of_severity(&imported.findings, Severity::Label),
        warnings: of_severity(&imported.findings, Severity::Note),
        series: imported.draft.series.iter().map(OfSeries::of).collect(),
        squareness_um_per_m: imported.squareness.iter().map(|s| (s.pair, s.um_per_m)).collect(),
    };
    let next = format!(
        "\nnext: name it in [measurement] of a job, `errors = \"{}\"`; a list joins the tables of several axes, `errors = [\"x.csv\", \"y.csv\"]`",
        file_name(place)
    );
    // What the file says, what was done with it, what belongs into the job.
    let facts = document.facts.iter().map(|fact| format!("\n{fact}"));
    let screen = || Screen {
        figures: paragraphs(&[
            series_table(&imported, &document.series),
            squareness_lines(&imported.squareness).join("\n"),
        ]),
        always: document.warnings.iter().map(|words| format!("warning: {words}")).collect(),
        ..Screen::of(format!("read as {}{}", document.format, facts.collect::<String>()))
    };
    options.output.deliver(files, Some(held(imported.text.clone())), screen, || &document, &next)
}

/// The summary for scripts.
#[derive(Serialize)]
struct Document<'a> {
    source: &'a HashedFile,
    format: String,
    output: String,
    stated: NamedEntries<&'static str, String>,
    facts: Vec<Finding>,
    warnings: Vec<Finding>,
    series: Vec<OfSeries>,
    squareness_um_per_m: NamedEntries<&'static str, f64>,
}

/// The same of lists that fill in a form.
#[derive(Serialize)]
struct OfForm<'a> {
    format: &'static str,
    lists: Vec<&'a HashedFile>,
    stated: NamedEntries<&'static str, String>,
}

/// What a series holds.
#[derive(Serialize)]
struct OfSeries {
    axis: &'static str,
    direction: Option<&'static str>,
    terms: Vec<String>,
    points: usize,
    from_mm: Option<f64>,
    to_mm: Option<f64>,
}

impl OfSeries {
    fn of(series: &Series) -> OfSeries {
        let [from_mm, to_mm] = series.ends_mm();
        OfSeries {
            axis: series.axis.key(),
            direction: series.direction.map(Direction::symbol),
            terms: series.components().map(|component| component.to_string()).collect(),
            points: series.positions.len(),
            from_mm,
            to_mm,
        }
    }
}

fn series_table(imported: &Imported, all: &[OfSeries]) -> String {
    let rows = imported.draft.series.iter().zip(all).map(|(series, of)| {
        let end = |mm: Option<f64>| mm.map_or_else(String::new, |mm| mm.to_string());
        let (from, to, travel) = (end(of.from_mm), end(of.to_mm), of.direction.unwrap_or("both"));
        let has_u = series.uncertainties.keys().any(|kind| matches!(kind, Kind::Deviation(_)));
        let u = if has_u { "yes" } else { "not stated" };
        let (points, terms) = (of.points, of.terms.join(" "));
        format!("{}\t{travel}\t{points}\t{from}\t{to}\t{terms}\t{u}", series.axis)
    });
    table("axis\ttravel\t>points\t>from/mm\t>to/mm\tmeasured\tu", rows)
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
    let lists = named.map(|(of, file)| Ok((of, InputFile::read(files, file)?)));
    let given: Vec<(Option<Diagonal>, InputFile<'_>)> = lists.collect::<Result<_, Problems>>()?;
    let lists: Vec<List<'_>> = given.iter().map(|(of, file)| (*of, file.measurement())).collect();
    let text = fill(&form, &lists, &options.stated)?;
    let document = OfForm {
        format: "list",
        lists: given.iter().map(|(_, file)| &file.hash).collect(),
        stated: options.stated.given().into_iter().collect(),
    };
    let screen = || Screen::of("every capture of the form has its value".to_string());
    options.output.deliver(files, Some(held(text)), screen, || document, "")
}
