//! The command line: the only part that touches files, terminal and arguments.
//!
//! Data go to standard output, messages to standard error. Exit status (contract §3): 0 = done and
//! within limits, 1 = the answer is no (files are written), 2 = could not do it (nothing is
//! written).

mod assess;
#[cfg(feature = "disk")]
mod batch;
mod controllers;
#[cfg(feature = "disk")]
mod disk;
mod generate;
mod history;
mod import;
mod new;
mod outcome;
mod path;
mod plan;
mod program;
mod refusals;
mod report;
mod screen;
mod separate;
mod show;
mod simulate;
mod standards;
mod verify;
#[cfg(feature = "disk")]
mod write;

use crate::text::Problems;
use crate::visit::files::{Files, printed};
#[cfg(feature = "disk")]
pub use batch::Answered;
use clap::{Args, CommandFactory, Parser, Subcommand};
pub use outcome::Answer;
use outcome::Outcome;
use screen::{Detail, spoken};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Turns laser measurements of a machine tool into the compensation files its control loads,
/// and forecasts from the written bytes what they will leave.
#[derive(Debug, Parser)]
#[command(name = "nonius", version, about, long_about = None, after_help = EXAMPLES, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "Examples:
  nonius new --controller siemens-840d-sl --travel 800,500,400 -o visit
                                        begin: a job and a table, to be filled in
  nonius generate job.toml -o kit       make the files for the control, with a forecast
  nonius verify job.toml --tables kit   read them back and judge them
  nonius verify job.toml --tables kit --after after.csv
                                        judge a second measurement, and say why it misses

Exit status: 0 done and within limits · 1 the answer is no · 2 could not do it, nothing written";

#[derive(Debug, Subcommand)]
enum Command {
    /// Begin a visit: write a job for a control, and the table to be filled in
    New(new::Options),
    /// Make the compensation files of a job, with a forecast of what they leave
    #[command(
        after_help = "Exit status: 0 made, and the forecast keeps the acceptance · 1 made, but it does not or is undecided · 2 nothing written"
    )]
    Generate(generate::Options),
    /// Read the files of a directory back and judge them against a job
    #[command(after_help = "Exit status: 0 pass · 1 fail or undecided · 2 could not judge")]
    Verify(verify::Options),
    /// Write the page that is handed over: as found, forecast, as left (HTML)
    #[command(
        after_help = "Exit status: 0 the verdict on the page is pass · 1 it is not · 2 nothing written"
    )]
    Report(report::Options),
    /// Print the chain of tables that a kit stands in, back to the first one
    #[command(
        after_help = "Exit status: 0 all is as it was made · 1 the chain breaks or a file was changed · 2 could not read"
    )]
    History(history::Options),
    /// Separate the readings of four body diagonals into the nine errors
    #[command(
        after_help = "Exit status: 0 separated · 1 separated, but something contradicts the result · 2 nothing written"
    )]
    Separate(separate::Options),
    /// What the errors do in the volume: volumetric accuracy and the other definitions
    Assess(assess::Options),
    /// Before the visit: what its run and variants of it determine, how well, and in what time
    #[command(
        after_help = "Exit status: 0 the run as described reaches the acceptance · 1 it does not, or leaves an error open · 2 could not plan"
    )]
    Plan(plan::Options),
    /// Write the part programs of a measuring run, with the expected positions
    Program(program::Options),
    /// Predict the readings of a measurement with the tables active: a rehearsal, no measurement
    Simulate(simulate::Options),
    /// Turn another maker's measurement into an error table, or lists of captures into readings
    Import(import::Options),
    /// Figures by standard: ISO 230-2 and VDI/DGQ 3441 of one axis, ISO 230-6 of the body diagonals
    Standards(standards::Options),
    /// Tell the machine's error along the path of a part program (G-code)
    Path(path::Options),
    /// Write the page that makes and judges a kit in a browser, where nothing may be installed
    Page(PageOptions),
    /// List, show or check the controls that can be written for
    Controllers {
        #[command(subcommand)]
        command: Option<controllers::Command>,
    },
    /// Print what the templates of a job's control see (always JSON)
    Context(controllers::Context),
    /// Answer many questions: a line each (JSON), answered by a line each
    #[cfg(feature = "disk")]
    #[command(
        after_help = "Exit status: 0 every answer is yes · 1 an answer is no, or a line could not be answered · 2 could not begin"
    )]
    Batch(batch::Options),
    /// Print completions for a shell
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Print the manual page
    Man,
}

#[cfg(feature = "disk")]
pub use on_disk::run;

/// The program of a computer.
#[cfg(feature = "disk")]
mod on_disk {
    use super::{Arguments, COULD_NOT, ended};
    use crate::cli::disk::Disk;
    use crate::cli::screen::{say, tell};
    use clap::Parser;
    use std::ffi::OsString;
    use std::process::ExitCode;

    /// Runs the program with its arguments (the first is its name) and gives the exit status.
    pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
        let arguments: Vec<OsString> = arguments.into_iter().collect();
        #[cfg(all(windows, feature = "page"))]
        if arguments.len() == 1 {
            return double_clicked();
        }
        match Arguments::try_parse_from(&arguments) {
            Ok(arguments) => {
                let mut out = std::io::stdout().lock();
                let answer = ended(arguments.command, &Disk::default(), &mut out);
                tell(&answer.err);
                ExitCode::from(answer.status)
            }
            Err(error) if error.use_stderr() => {
                say(&error.render().to_string());
                ExitCode::from(COULD_NOT)
            }
            Err(error) => match error.print() {
                Ok(()) => ExitCode::SUCCESS, // help and version are answers
                Err(_) => ExitCode::from(COULD_NOT),
            },
        }
    }

    /// Writes the page among the temporary files of this user and opens it.
    #[cfg(all(windows, feature = "page"))]
    fn double_clicked() -> ExitCode {
        let place = std::env::temp_dir().join("nonius.html");
        let words = ["nonius", "page", "--force", "-o"].map(OsString::from);
        let status = run(words.into_iter().chain([place.clone().into()]));
        if status == ExitCode::SUCCESS && open::that(place).is_ok() {
            say("it opens now; in a command prompt `nonius --help` lists all commands");
        }
        status
    }
}

/// Runs a command, e.g. `["generate", "job.toml", "-o", "kit"]`, on files wherever they are: as the program does, with
/// the same bytes. Its outputs are among the files then.
pub fn answer<'a>(files: &dyn Files, command: impl IntoIterator<Item = &'a str>) -> Answer {
    let mut out = Vec::new();
    files.begin_run();
    match Arguments::try_parse_from(std::iter::once("nonius").chain(command)) {
        Ok(arguments) => {
            let answer = ended(arguments.command, files, &mut out);
            Answer { out, ..answer }
        }
        Err(error) => {
            let text = error.render().to_string();
            match error.use_stderr() {
                true => Answer { status: COULD_NOT, err: spoken(&text), ..Answer::default() },
                false => Answer { out: text.into_bytes(), ..Answer::default() },
            }
        }
    }
}

/// The answer to a question of `batch`; files that it does not hold are read from this computer.
///
/// ```
/// let question = r#"{"command": "assess", "options": ["fixtures/nine_errors_900/errors.csv"]}"#;
/// assert!(nonius::cli::asked(question.as_bytes()).json().contains("19.166667"));
/// ```
#[cfg(feature = "disk")]
pub fn asked(question: &[u8]) -> Answered {
    let run = |files: &dyn Files, words: &[&str]| answer(files, words.iter().copied());
    batch::answered(question, Box::<disk::Disk>::default(), run)
}

/// What a command answers, but for its standard output.
fn ended(command: Command, files: &dyn Files, out: &mut dyn Write) -> Answer {
    match execute(command, files, out).and_then(|outcome| outcome.deliver(out)) {
        Ok((yes, talk)) => {
            let err = if talk.is_empty() { talk } else { spoken(&talk) };
            Answer { status: u8::from(!yes), err, ..Answer::default() }
        }
        Err(problems) => {
            let err = spoken(&problems.render());
            Answer { status: COULD_NOT, err, problems, ..Answer::default() }
        }
    }
}

/// Exit status: could not do it.
const COULD_NOT: u8 = 2;

#[cfg_attr(
    not(feature = "disk"),
    expect(unused_variables, reason = "batch alone answers while it works")
)]
fn execute(command: Command, files: &dyn Files, out: &mut dyn Write) -> Result<Outcome, Problems> {
    match command {
        #[cfg(feature = "disk")]
        Command::Batch(options) => batch::run(&options, &asked, out),
        Command::New(options) => new::run(&options, files),
        Command::Generate(options) => generate::run(&options, files),
        Command::Verify(options) => verify::run(&options, files),
        Command::Report(options) => report::run(&options, files),
        Command::History(options) => history::run(&options, files),
        Command::Separate(options) => separate::run(&options, files),
        Command::Assess(options) => assess::run(&options, files),
        Command::Plan(options) => plan::run(&options, files),
        Command::Program(options) => program::run(&options, files),
        Command::Simulate(options) => simulate::run(&options, files),
        Command::Import(options) => import::run(&options, files),
        Command::Standards(options) => standards::run(&options, files),
        Command::Path(options) => path::run(&options, files),
        Command::Page(options) => page(&options, files),
        Command::Controllers { command } => controllers::run(command.as_ref(), files),
        Command::Context(options) => controllers::context(&options, files),
        Command::Completions { shell } => {
            let mut page = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "nonius", &mut page);
            Ok(Outcome::bytes(page))
        }
        Command::Man => manual(),
    }
}

fn manual() -> Result<Outcome, Problems> {
    let mut page = Vec::new();
    let man = clap_mangen::Man::new(Arguments::command());
    man.render(&mut page).map_err(refusals::no_manual)?;
    Ok(Outcome::bytes(page))
}

/// The page for a browser: a visit in one file, which sends nothing anywhere. Feature `page` puts it into the program as
/// packaging/page/build made it.
#[cfg(not(feature = "page"))]
const PAGE: Option<&[u8]> = None;
#[cfg(feature = "page")]
const PAGE: Option<&[u8]> = Some(include_bytes!("../target/package/nonius.html"));

// Options of `page`.
#[derive(Args, Debug)]
struct PageOptions {
    /// The file to write (HTML); `-` = standard output
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Replace the file that is there
    #[arg(long)]
    force: bool,
}

fn page(options: &PageOptions, files: &dyn Files) -> Result<Outcome, Problems> {
    let (page, place) = (PAGE.ok_or_else(refusals::no_page)?, &options.output);
    if place == Path::new("-") {
        return Ok(Outcome::bytes(page.to_vec()));
    }
    let said = format!("wrote {}: open it in a browser", printed(place));
    let outcome = Outcome::bytes(Vec::new()).saying(Detail::default(), said);
    Ok(outcome.writing(files.write(place, page, options.force)?))
}
