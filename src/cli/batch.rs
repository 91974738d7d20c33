//! `nonius batch QUESTIONS`: a question each line (JSON), answered by a line each, in the same order.
//!
//! ```text
//!   {"id": 17, "command": "generate", "job": "job.toml" or {…}, "options": ["-o", "kit"],
//!    "files": {"errors.csv": "axis,…" or {"axis": ["x", …], "position_mm": [0, …], …}}}
//!   {"line": 1, "question": sha256, "id": 17, "status": 0, "document": {…}, "problems": [], "files": {"kit/…": "…"}}
//! ```
//! A question is answered as the program answers its command with `--format json`. Whatever it writes is in its answer
//! and nowhere else, so a line that is answered again changes nothing. Files that it does not hold are read from disk.

use crate::cli::outcome::{Answer, Outcome};
use crate::quantity::units::Figure;
use crate::text::document::{LARGEST_FILE_MIB, sha256};
use crate::text::problem::{Problem, Problems};
use crate::visit::files::{Files, not_put_out, plain_words, printed};
use crate::visit::memory::Memory;
use clap::Args;
use indicatif::ProgressBar;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

// Options of `batch`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// The questions (JSON lines); `-` = standard input
    questions: PathBuf,
    /// The file of the answers [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Go on where an interrupted run ended: FILE holds the answers to the first questions
    #[arg(long, requires = "output")]
    resume: bool,
    /// Number of questions that are answered at once [default: one for each processor]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    jobs: usize,
}

/// Questions that are held at once, for each that is answered at once.
const AT_ONCE: usize = 32;

/// Answers every question.
pub(super) fn run(
    options: &Options,
    answered: &(dyn Fn(&str) -> Answered + Sync),
    out: &mut dyn Write,
) -> Result<Outcome, Problems> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.jobs).build();
    let pool = pool.map_err(|error| Problem::new(format!("cannot work at once: {error}")))?;
    let mut questions = Questions::open(&options.questions)?;
    let mut file = match &options.output {
        Some(place) if options.resume => Some(resumed(place, &mut questions)?),
        Some(place) => Some(File::create_new(place).map_err(|e| {
            at(place, &e).help("choose another name, or `--resume` where the run was interrupted")
        })?),
        None => None,
    };
    let mut all_yes = true;
    loop {
        let asked = questions.take(AT_ONCE * pool.current_num_threads())?;
        if asked.is_empty() {
            questions.progress.finish_and_clear();
            return Ok(Outcome::bytes(Vec::new()).answering(all_yes));
        }
        let answers: Vec<Answered> =
            pool.install(|| asked.par_iter().map(|(_, question)| answered(question)).collect());
        let mut lines = Vec::new();
        for ((number, question), answer) in asked.iter().zip(answers) {
            all_yes &= answer.status == 0;
            lines.extend(head(*number, question).bytes());
            lines.extend(answer.line.bytes().skip(1).chain(*b"\n"));
        }
        match &mut file {
            Some(file) => file.write_all(&lines).map_err(|e| not_put_out(&e))?,
            None => out.write_all(&lines).map_err(|e| not_put_out(&e))?,
        }
    }
}

/// How the answer to a question begins.
fn head(number: usize, question: &str) -> String {
    format!("{{\"line\":{number},\"question\":\"{}\",", sha256(question.as_bytes()))
}

fn at(path: &Path, error: &std::io::Error) -> Problem {
    Problem::new(format!("`{}`: {}", printed(path), plain_words(error)))
}

/// The questions that are not read yet.
struct Questions {
    name: PathBuf,
    lines: Box<dyn BufRead>,
    read: usize,
    progress: ProgressBar,
}

impl Questions {
    fn open(path: &Path) -> Result<Questions, Problem> {
        let (bytes, lines): (_, Box<dyn BufRead>) = match path == Path::new("-") {
            true => (0, Box::new(std::io::stdin().lock())),
            false => {
                let file = File::open(path).map_err(|error| at(path, &error))?;
                (file.metadata().map_or(0, |of| of.len()), Box::new(BufReader::new(file)))
            }
        };
        Ok(Questions {
            name: path.to_path_buf(),
            lines,
            read: 0,
            progress: ProgressBar::new(bytes),
        })
    }

    /// The next one with its number.
    fn next(&mut self) -> Result<Option<(usize, String)>, Problem> {
        let mut line = Vec::new();
        let longest = LARGEST_FILE_MIB << 20;
        let read = (&mut self.lines).take(longest).read_until(b'\n', &mut line);
        let bytes = read.map_err(|error| at(&self.name, &error))? as u64;
        self.read += 1;
        if bytes == longest {
            let words = format!("line {} holds {LARGEST_FILE_MIB} MiB or more", self.read);
            return Err(Problem::new(words).help("a question is one line"));
        }
        self.progress.inc(bytes);
        let text = String::from_utf8_lossy(&line);
        Ok((bytes > 0).then(|| (self.read, text.trim_end_matches(['\n', '\r']).to_string())))
    }

    fn take(&mut self, most: usize) -> Result<Vec<(usize, String)>, Problem> {
        let next = std::iter::from_fn(|| self.next().transpose());
        next.take(most).collect()
    }
}

/// The file of an interrupted run, behind its last whole line: whose question has to be the one that is asked.
fn resumed(place: &Path, questions: &mut Questions) -> Result<File, Problem> {
    let refuse = |error: std::io::Error| at(place, &error);
    let options = File::options().read(true).write(true).open(place);
    let mut old = BufReader::new(options.map_err(refuse)?);
    let (mut line, mut whole) = (Vec::new(), 0);
    while old.read_until(b'\n', &mut line).map_err(refuse)? > 0 && line.ends_with(b"\n") {
        let asked = questions.next()?.map(|(number, question)| head(number, &question));
        if !asked.as_ref().is_some_and(|head| line.starts_with(head.as_bytes())) {
            let number = questions.read;
            let words = format!("line {number} of `{}` answers another question", printed(place));
            return Err(Problem::new(words).help("name the file that this run wrote, or a new one"));
        }
        whole += line.len() as u64;
        line.clear();
    }
    let mut file = old.into_inner();
    file.set_len(whole).and_then(|()| file.seek(SeekFrom::Start(whole))).map_err(refuse)?;
    Ok(file)
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Question {
    id: Option<Value>,
    command: String,
    job: Option<Page>,
    #[serde(default)]
    options: Vec<String>,
    #[serde(default)]
    files: BTreeMap<String, Page>,
}

/// How a job is called that a question holds.
const JOB: &str = "job.toml";

/// What a file holds, or the path of a job.
#[derive(Deserialize)]
#[serde(untagged)]
enum Page {
    Text(String),
    /// What is no text.
    Bytes(Vec<u8>),
    /// Of a job (`.toml`) its sections and keys, of a table its columns.
    Parts(Map<String, Value>),
}

/// What `batch` prints of an answer.
#[derive(Serialize)]
struct Line<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<Value>,
    status: u8,
    document: Value,
    #[serde(flatten)]
    problems: &'a Problems,
    #[serde(skip_serializing_if = "str::is_empty")]
    said: &'a str,
    files: BTreeMap<String, Value>,
}

/// An answer, and its exit status.
pub struct Answered {
    /// Exit status of the command.
    pub status: u8,
    /// The answer (JSON).
    pub line: String,
}

/// How a command is run on files.
type Run = fn(&dyn Files, &[&str]) -> Answer;

/// The answer to one question; what it does not hold is read beneath.
pub(super) fn answered(question: &str, beneath: Box<dyn Files>, run: Run) -> Answered {
    let read = serde_json::from_str(question).map_err(|error| {
        let words = format!("this is no question: {error}");
        Problem::new(words).help("see `nonius batch` in docs/interface.md")
    });
    let (id, asked) = match read {
        Ok(Question { id, command, job, options, files }) => {
            (id, memory(job, files).map(|(memory, job)| (command, job, options, memory)))
        }
        Err(problem) => (None, Err(problem)),
    };
    let (answer, files) = match asked {
        Ok((command, job, options, memory)) => {
            let given = memory.all();
            let memory = memory.over(beneath);
            let words = std::iter::once(&command).chain(&job).chain(&options);
            let words: Vec<&str> = words.map(String::as_str).chain(["--format", "json"]).collect();
            let answer = run(&memory, &words);
            let mut made = memory.all();
            made.retain(|name, bytes| given.get(name) != Some(bytes));
            (answer, made)
        }
        Err(problem) => {
            let problems = Problems::from(problem);
            let err = problems.render();
            (Answer { status: 2, err, problems, ..Answer::default() }, BTreeMap::new())
        }
    };
    line(id, &answer, files)
}

fn line(id: Option<Value>, answer: &Answer, files: BTreeMap<String, Vec<u8>>) -> Answered {
    let text = |bytes: Vec<u8>| match String::from_utf8(bytes) {
        Ok(text) => Value::from(text),
        Err(other) => Value::from(other.into_bytes()),
    };
    let document = serde_json::from_slice(&answer.out);
    let said = if answer.status == 2 { answer.err.as_str() } else { "" };
    let line = Line {
        id,
        status: answer.status,
        document: document.unwrap_or_else(|_| text(answer.out.clone())),
        problems: &answer.problems,
        said,
        files: files.into_iter().map(|(name, bytes)| (name, text(bytes))).collect(),
    };
    let line = serde_json::to_string(&line).unwrap_or_default();
    Answered { status: answer.status, line }
}

/// The files that a question holds, and the path of its job.
fn memory(
    job: Option<Page>,
    mut files: BTreeMap<String, Page>,
) -> Result<(Memory, Option<String>), Problem> {
    let path = match job {
        Some(Page::Text(path)) => Some(path),
        Some(sections) => {
            files.insert(JOB.to_string(), sections);
            Some(JOB.to_string())
        }
        None => None,
    };
    let mut held = Vec::new();
    for (name, page) in files {
        let bytes = match page {
            Page::Text(text) => text.into_bytes(),
            Page::Bytes(bytes) => bytes,
            Page::Parts(sections) if name.ends_with(".toml") => toml::to_string(&sections)
                .map_err(|error| Problem::new(format!("`{name}` is no job: {error}")))?
                .into_bytes(),
            Page::Parts(columns) => table(&name, &columns)?.into_bytes(),
        };
        held.push((name, bytes));
    }
    let held = held.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice()));
    Ok((Memory::of(held), path))
}

/// Columns as a table (CSV); `null` = an empty cell.
fn table(name: &str, columns: &Map<String, Value>) -> Result<String, Problem> {
    let wrong = |what: &str| Problem::new(format!("`{name}`: {what}"));
    let lists = columns.values().map(|values| {
        values.as_array().ok_or_else(|| wrong("every column is a list of numbers or words"))
    });
    let lists = lists.collect::<Result<Vec<_>, _>>()?;
    let rows = lists.first().map_or(0, |list| list.len());
    if lists.iter().any(|list| list.len() != rows) {
        return Err(wrong("its columns are not of one length"));
    }
    let cell = |value: &Value| match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.as_f64().map_or_else(|| other.to_string(), |it| Figure(it).to_string()),
    };
    let names: Vec<&str> = columns.keys().map(String::as_str).collect();
    let rows = (0..rows).map(|row| {
        let cells = lists.iter().map(|list| cell(&list[row]));
        cells.collect::<Vec<_>>().join(",")
    });
    Ok(std::iter::once(names.join(",")).chain(rows).map(|row| row + "\n").collect())
}

#[cfg(test)]
mod tests {
    use super::{Answered, Options, head, run};
    use std::path::PathBuf;

    fn answered(question: &str) -> Answered {
        let status = if question == "bad" { 2 } else { 0 };
        Answered { status, line: format!("{{\"of\":\"{question}\"}}") }
    }

    fn batch(questions: &str, output: Option<&PathBuf>, resume: bool) -> Result<String, String> {
        let folder = tempfile::tempdir().unwrap();
        let questions_file = folder.path().join("questions");
        std::fs::write(&questions_file, questions).unwrap();
        let output = output.cloned();
        let options = Options { questions: questions_file, output, resume, jobs: 2 };
        let mut out = Vec::new();
        run(&options, &answered, &mut out).map_err(|problems| problems.render())?;
        Ok(String::from_utf8(out).unwrap())
    }

    fn expected(questions: &[&str]) -> String {
        let line = |(index, question): (usize, &&str)| {
            format!("{}{}\n", head(index + 1, question), &answered(question).line[1..])
        };
        questions.iter().enumerate().map(line).collect()
    }

    #[test]
    fn answers_come_in_the_order_of_the_questions() {
        let many: Vec<String> = (0..1000).map(|number| number.to_string()).collect();
        let many: Vec<&str> = many.iter().map(String::as_str).collect();
        assert_eq!(batch(&(many.join("\n") + "\r\n"), None, false), Ok(expected(&many)));
        assert_eq!(batch("1\n\nbad", None, false), Ok(expected(&["1", "", "bad"])));
    }

    /// Whatever a killed run left: no whole line, half a line, all lines.
    #[test]
    fn a_run_that_was_interrupted_goes_on_with_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("answers");
        let whole = expected(&["a", "b", "bad", "d"]);
        for length in 0..=whole.len() {
            std::fs::write(&place, &whole[..length]).unwrap();
            assert_eq!(batch("a\nb\nbad\nd\n", Some(&place), true), Ok(String::new()));
            assert_eq!(std::fs::read_to_string(&place).unwrap(), whole, "{length}");
        }
    }

    #[test]
    fn answers_to_other_questions_are_never_gone_on_with_or_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("answers");
        let old = expected(&["a", "b"]);
        std::fs::write(&place, &old).unwrap();
        let said = batch("a\nc\nd\n", Some(&place), true).unwrap_err();
        assert!(said.contains("line 2") && said.contains("answers another question"), "{said}");
        assert!(batch("a\n", Some(&place), true).is_err(), "more answers than questions");
        assert!(batch("a\nb\n", Some(&place), false).unwrap_err().contains("--resume"));
        assert_eq!(std::fs::read_to_string(&place).unwrap(), old);
    }
}
