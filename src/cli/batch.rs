//! `nonius batch QUESTIONS`: a question each line (JSON), answered by a line each, in the same order.
//!
//! ```text
//!   {"id": 17, "command": "generate", "job": "job.toml" or {…}, "options": ["-o", "kit"],
//!    "files": {"errors.csv": "axis,…" or {"axis": ["x", …], "position_mm": [0, …], …}}}
//!   {"line": 1, "question": sha256, "id": 17, "status": 0, "document": {…}, "problems": [], "files": {"kit/…": "…"}}
//! ```
//! A question is answered as the program answers its command with `--format json`. Whatever it writes is in its answer
//! and nowhere else, so a line that is answered again changes nothing. Files that it does not hold are read from disk.

use crate::cli::outcome::{Answer, Outcome, is_reader_gone};
use crate::cli::refusals;
use crate::quantity::Figure;
use crate::text::{LARGEST_FILE_MIB, Problem, Problems, sha256, shown};
use crate::visit::files::{Files, Memory, not_put_out, plain_words, printed};
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
    answered: &(dyn Fn(&[u8]) -> Answered + Sync),
    out: &mut dyn Write,
) -> Result<Outcome, Problems> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.jobs).build();
    let pool = pool.map_err(refusals::no_pool)?;
    let mut questions = Questions::open(&options.questions)?;
    let mut all_yes = true;
    let place = options.output.as_deref().filter(|place| *place != Path::new("-"));
    let mut file = match place {
        Some(place) if options.resume => {
            let (file, were_yes) = resumed(place, &mut questions)?;
            all_yes = were_yes;
            Some(file)
        }
        None if options.resume => return Err(refusals::no_answers_to_resume().into()),
        Some(place) => Some(File::create_new(place).map_err(|e| {
            at(place, &e).help("choose another name, or `--resume` where the run was interrupted")
        })?),
        None => None,
    };
    loop {
        let asked = questions.take(AT_ONCE * pool.current_num_threads())?;
        if asked.is_empty() {
            questions.progress.finish_and_clear();
            break;
        }
        let answers: Vec<Answered> =
            pool.install(|| asked.par_iter().map(|(_, question)| answered(question)).collect());
        let mut lines = Vec::new();
        for ((number, question), answer) in asked.iter().zip(answers) {
            all_yes &= answer.status == 0;
            let (head, Answered { status, line }) = (head(*number, question), answer);
            lines.extend(format!("{head}{status},{line}\n").bytes());
        }
        match &mut file {
            Some(file) => file.write_all(&lines).map_err(|e| not_put_out(&e))?,
            None => match out.write_all(&lines).and_then(|()| out.flush()) {
                Err(error) if is_reader_gone(&error) => break,
                written => written.map_err(|e| not_put_out(&e))?,
            },
        }
    }
    Ok(Outcome::bytes(Vec::new()).answering(all_yes))
}

/// How the answer to a question begins: its exit status follows.
fn head(number: usize, question: &[u8]) -> String {
    format!("{{\"line\":{number},\"question\":\"{}\",\"status\":", sha256(question))
}

fn at(path: &Path, error: &std::io::Error) -> Problem {
    Problem::new(format!("`{}`: {}", printed(path), plain_words(error)))
}

/// The questions that are not read yet.
struct Questions {
    name: PathBuf,
    lines: Box<dyn BufRead>,
    read: usize,
    /// One that is asked again.
    again: Option<NumberedLine>,
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
        let (name, progress) = (path.to_path_buf(), ProgressBar::new(bytes));
        Ok(Questions { name, lines, read: 0, again: None, progress })
    }

    /// The next one with its number; of one that is too long the beginning.
    fn next(&mut self) -> Result<Option<NumberedLine>, Problem> {
        let refuse = |error| at(&self.name, &error);
        let mut line = Vec::new();
        let mut bytes =
            (&mut self.lines).take(LONGEST).read_until(b'\n', &mut line).map_err(refuse)? as u64;
        if bytes == LONGEST && !line.ends_with(b"\n") {
            bytes += self.lines.skip_until(b'\n').map_err(refuse)? as u64;
        }
        self.read += 1;
        self.progress.inc(bytes);
        let begin = if self.read == 1 { "\u{feff}".as_bytes() } else { b"" };
        let line = line.strip_prefix(begin).unwrap_or(&line).trim_ascii_end();
        Ok((bytes > 0).then(|| (self.read, line.to_vec())))
    }

    fn take(&mut self, most: usize) -> Result<Vec<NumberedLine>, Problem> {
        let again = self.again.take().map(Ok);
        let next = std::iter::from_fn(|| self.next().transpose());
        again.into_iter().chain(next).take(most).collect()
    }
}

/// A question and the number of its line.
type NumberedLine = (usize, Vec<u8>);

/// Bytes of a question.
const LONGEST: u64 = LARGEST_FILE_MIB << 20;

/// The file of an interrupted run, behind its last whole line, and whether all its answers are yes. Each line has to answer the
/// question that is asked; behind them stands at most a part of the next.
fn resumed(place: &Path, questions: &mut Questions) -> Result<(File, bool), Problem> {
    let refuse = |error: std::io::Error| at(place, &error);
    let options = File::options().read(true).write(true).create(true).truncate(false).open(place);
    let mut old = BufReader::new(options.map_err(refuse)?);
    let (mut whole, mut all_yes, mut next) = (0, true, None);
    loop {
        let mut line = Vec::new();
        old.read_until(b'\n', &mut line).map_err(refuse)?;
        if line.is_empty() {
            break;
        }
        next = questions.next()?;
        let begins = next.as_ref().is_some_and(|(number, question)| {
            let head = head(*number, question);
            line.starts_with(head.as_bytes()) || head.as_bytes().starts_with(&line)
        });
        if !begins {
            let file = printed(place);
            return Err(match next {
                Some(_) => refusals::other_question(questions.read, file),
                None => refusals::more_answers(file),
            });
        }
        if !line.ends_with(b"\n") {
            break;
        }
        let status = next.take().map(|(number, question)| head(number, &question).len());
        all_yes &= status.and_then(|at| line.get(at)) == Some(&b'0');
        whole += line.len() as u64;
    }
    questions.again = next;
    let mut file = old.into_inner();
    file.set_len(whole).and_then(|()| file.seek(SeekFrom::Start(whole))).map_err(refuse)?;
    Ok((file, all_yes))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Question {
    id: Option<Value>,
    command: String,
    job: Option<FileContent>,
    #[serde(default)]
    options: Vec<String>,
    #[serde(default)]
    files: BTreeMap<String, FileContent>,
}

/// How a job is called that a question holds.
const JOB: &str = "job.toml";

/// What a file holds, or the path of a job.
#[derive(Deserialize)]
#[serde(untagged)]
enum FileContent {
    Text(String),
    /// What is no text.
    Bytes(Vec<u8>),
    /// Of a job (`.toml`) its sections and keys, of a table its columns.
    Parts(Map<String, Value>),
}

/// What `batch` prints of an answer.
#[derive(Serialize)]
struct AnswerLine<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<Value>,
    document: Value,
    #[serde(flatten)]
    problems: &'a Problems,
    #[serde(skip_serializing_if = "str::is_empty")]
    said: &'a str,
    files: BTreeMap<String, Value>,
}

/// An answer.
pub struct Answered {
    /// Exit status of the command.
    pub status: u8,
    /// The rest of the answer (JSON, behind `"status"`).
    line: String,
}

impl Answered {
    /// The answer as JSON.
    pub fn json(&self) -> String {
        format!("{{\"status\":{},{}", self.status, self.line)
    }
}

/// How a command is run on files.
type Run = fn(&dyn Files, &[&str]) -> Answer;

/// The answer to one question; what it does not hold is read beneath.
pub(super) fn answered(question: &[u8], beneath: Box<dyn Files>, run: Run) -> Answered {
    let mut id = None;
    let made = asked(question).and_then(|question| {
        id = question.id;
        let (memory, job) = memory(question.job, question.files)?;
        let given = memory.all();
        let memory = memory.over(beneath);
        let options = question.options;
        let is_open = !options.iter().any(|word| word.starts_with("--format"));
        let format = is_open.then_some(["--format", "json"]).into_iter().flatten();
        let words = std::iter::once(&question.command).chain(&job).chain(&options);
        let answer = run(&memory, &words.map(String::as_str).chain(format).collect::<Vec<_>>());
        let mut made = memory.all();
        made.retain(|name, bytes| given.get(name) != Some(bytes));
        Ok((answer, made))
    });
    let (answer, files) = made.unwrap_or_else(|problem| {
        let problems = Problems::from(problem);
        let err = problems.render();
        (Answer { status: 2, err, problems, ..Answer::default() }, BTreeMap::new())
    });
    line(id, &answer, files)
}

fn asked(question: &[u8]) -> Result<Question, Problem> {
    match question.len() as u64 >= LONGEST {
        true => Err(refusals::long_question()),
        false => serde_json::from_slice(question).map_err(refusals::no_question),
    }
}

fn line(id: Option<Value>, answer: &Answer, files: BTreeMap<String, Vec<u8>>) -> Answered {
    let text = |bytes: Vec<u8>| match String::from_utf8(bytes) {
        Ok(text) => Value::from(text),
        Err(other) => Value::from(other.into_bytes()),
    };
    let document = serde_json::from_slice(&answer.out);
    let line = AnswerLine {
        id,
        document: document.unwrap_or_else(|_| text(answer.out.clone())),
        problems: &answer.problems,
        said: if answer.status == 2 { answer.err.as_str() } else { "" },
        files: files.into_iter().map(|(name, bytes)| (name, text(bytes))).collect(),
    };
    // What is derived has only keys that are words.
    let line = serde_json::to_string(&line).unwrap_or_default().split_off(1);
    Answered { status: answer.status, line }
}

/// The files that a question holds, and the path of its job.
fn memory(
    job: Option<FileContent>,
    mut files: BTreeMap<String, FileContent>,
) -> Result<(Memory, Option<String>), Problem> {
    let path = match job {
        Some(FileContent::Text(path)) => Some(path),
        Some(sections) => {
            if files.insert(JOB.to_string(), sections).is_some() {
                return Err(refusals::two_jobs(JOB));
            }
            Some(JOB.to_string())
        }
        None => None,
    };
    let mut held = Vec::new();
    for (name, page) in files {
        let bytes = match page {
            FileContent::Text(text) => text.into_bytes(),
            FileContent::Bytes(bytes) => bytes,
            FileContent::Parts(sections) if name.ends_with(".toml") => toml::to_string(&sections)
                .map_err(|error| refusals::no_job(&name, error))?
                .into_bytes(),
            FileContent::Parts(columns) => table(&name, &columns)?.into_bytes(),
        };
        held.push((name, bytes));
    }
    Ok((Memory::of(held.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice()))), path))
}

/// Columns as a table (CSV); `null` = an empty cell. `remarks` are its comments.
fn table(name: &str, columns: &Map<String, Value>) -> Result<String, Problem> {
    let mut text = String::new();
    let (mut names, mut lists) = (Vec::new(), Vec::new());
    for (column, values) in columns {
        let values = values.as_array();
        let values = values.ok_or_else(|| refusals::no_column(name, shown(column)))?;
        let cells = values.iter().map(|value| match value {
            Value::Null => String::new(),
            Value::String(text) => text.clone(),
            other => other.as_f64().map_or_else(|| other.to_string(), |it| Figure(it).to_string()),
        });
        let cells: Vec<String> = cells.collect();
        if column == REMARKS {
            let lines = cells.iter().flat_map(|remark| remark.lines());
            text.extend(lines.map(|line| format!("# {line}\n")));
            continue;
        }
        let is_odd = |cell: &&String| cell.contains([',', ';', '"', '#', '\n', '\r']);
        if let Some(cell) = cells.iter().chain([column]).find(is_odd) {
            return Err(refusals::no_cell(name, shown(cell)));
        }
        names.push(column.as_str());
        lists.push(cells);
    }
    let rows = lists.first().map_or(0, Vec::len);
    if lists.iter().any(|list| list.len() != rows) {
        return Err(refusals::uneven_columns(name));
    }
    text += &(names.join(",") + "\n");
    for row in 0..rows {
        text += &(lists.iter().map(|list| list[row].as_str()).collect::<Vec<_>>().join(",") + "\n");
    }
    Ok(text)
}

/// The column that holds the comments of a table, a line each.
const REMARKS: &str = "remarks";

#[cfg(test)]
mod tests {
    use super::{Answered, Options, head, run};
    use std::path::PathBuf;

    fn answered(question: &[u8]) -> Answered {
        let status = if question == b"bad" { 2 } else { 0 };
        Answered { status, line: format!("\"of\":{}}}", question.len()) }
    }

    fn batch(
        questions: &str,
        output: Option<&PathBuf>,
        resume: bool,
    ) -> Result<(bool, String), String> {
        let folder = tempfile::tempdir().unwrap();
        let questions_file = folder.path().join("questions");
        std::fs::write(&questions_file, questions).unwrap();
        let output = output.cloned();
        let options = Options { questions: questions_file, output, resume, jobs: 2 };
        let mut out = Vec::new();
        let outcome = run(&options, &answered, &mut out).map_err(|problems| problems.render())?;
        let (yes, _) = outcome.deliver(&mut Vec::new()).unwrap();
        Ok((yes, String::from_utf8(out).unwrap()))
    }

    fn expected(questions: &[&str]) -> String {
        let line = |(index, question): (usize, &&str)| {
            let (question, answer) = (question.as_bytes(), answered(question.as_bytes()));
            format!("{}{},{}\n", head(index + 1, question), answer.status, answer.line)
        };
        questions.iter().enumerate().map(line).collect()
    }

    #[test]
    fn answers_come_in_the_order_of_the_questions() {
        let many: Vec<String> = (0..1000).map(|number| number.to_string()).collect();
        let many: Vec<&str> = many.iter().map(String::as_str).collect();
        assert_eq!(batch(&(many.join("\n") + "\r\n"), None, false), Ok((true, expected(&many))));
        assert_eq!(batch("1\n\nbad", None, false), Ok((false, expected(&["1", "", "bad"]))));
    }

    /// Whatever a killed run left: no whole line, half a line, all lines.
    #[test]
    fn a_run_that_was_interrupted_goes_on_with_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("answers");
        let whole = expected(&["a", "b", "bad", "d"]);
        for length in 0..=whole.len() {
            std::fs::write(&place, &whole[..length]).unwrap();
            assert_eq!(batch("a\nb\nbad\nd\n", Some(&place), true), Ok((false, String::new())));
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
        let said = batch("a\nb\n", Some(&place), false).unwrap_err();
        assert!(said.contains("it exists, so it is not overwritten") && said.contains("--resume"));
        assert_eq!(std::fs::read_to_string(&place).unwrap(), old);
        std::fs::write(&place, "no answers, and no end of a line").unwrap();
        assert!(batch("a\n", Some(&place), true).is_err(), "a file of something else");
    }
}
