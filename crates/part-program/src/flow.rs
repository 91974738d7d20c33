//! Lines that are no words of a block: variables that are set, and what decides which line comes next.
//!
//! ```text
//!   #1 = [#2 + 3]        IF [#1 GT 5] GOTO 20     IF [#1 GT 5] THEN #1 = 0     GOTO 20
//!   WHILE [#1 LT 5] DO1 … END1                    (Fanuc)
//! ```
//!
//! limits  words behind `O…` (loops, conditions and subprograms of LinuxCNC) are refused

use crate::expression::{Reader, whole};
use crate::grammar::{Grammar, ISO};
use crate::variables::Variables;
use crate::wrong::Wrong;

/// A place of the text that lines go to.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Label {
    /// `O1`, a program.
    Program(u32),
    /// `DO1`.
    Do(u32),
    /// `END1`.
    End(u32),
}

/// What a line asks for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Statement {
    /// Nothing more: its variables are set, or its condition does not hold.
    Done,
    GoTo(u32),
    /// `WHILE … DO1` whose condition does not hold.
    Leave(u32),
    End(u32),
}

/// Where the words of a line begin, behind `/` and N.
pub(super) fn behind_number(line: &[u8]) -> usize {
    let blank = |at: &usize| matches!(line.get(*at), Some(b' ' | b'\t'));
    let digit = |at: &usize| line.get(*at).is_some_and(u8::is_ascii_digit);
    let behind = |from: usize, is_in: &dyn Fn(&usize) -> bool| {
        (from..line.len()).find(|at| !is_in(at)).unwrap_or(line.len())
    };
    let mut at = behind(0, &blank);
    if line.get(at) == Some(&b'/') {
        at = behind(behind(at + 1, &digit), &blank);
    }
    if matches!(line.get(at), Some(b'N' | b'n')) {
        at = behind(behind(behind(at + 1, &blank), &digit), &blank);
    }
    at
}

/// Whether a word stands behind an `O…`, as in `O1 while`, or its name in brackets, as in `O<hole> call`.
fn is_word_of_linuxcnc(line: &[u8], at: usize) -> bool {
    let rest = &line[at + 1..];
    let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let word = rest[digits..].trim_ascii_start();
    let letters = word.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
    rest.starts_with(b"<") || digits > 0 && letters > 1
}

/// Where the statement of a line begins; `None` for one of words.
pub(super) fn begin(line: &[u8]) -> Option<usize> {
    let at = behind_number(line);
    let has = |word: &str| {
        let next = line.get(at..at + word.len());
        next.is_some_and(|next| next.eq_ignore_ascii_case(word.as_bytes()))
    };
    let begins = match line.get(at)?.to_ascii_uppercase() {
        b'#' => true,
        b'O' => is_word_of_linuxcnc(line, at),
        b'I' => has("IF"),
        b'W' => has("WHILE"),
        b'G' => has("GOTO"),
        b'D' => has("DO"),
        b'E' => has("END"),
        _ => false,
    };
    begins.then_some(at)
}

/// The label that a line is.
pub(super) fn label(line: &[u8]) -> Option<Label> {
    let none = Variables::default();
    let mut reader = Reader::new(line, begin(line)?, &ISO, &none);
    if reader.takes_word("END") {
        return number(&mut reader).ok().map(Label::End);
    }
    // The condition of a loop may name variables; its number stands behind the last `DO`.
    let text = line.to_ascii_uppercase();
    let at = text.windows(2).rposition(|pair| pair == b"DO")?;
    let begins = matches!(text[reader.at], b'W' | b'D');
    reader.at = at + 2;
    number(&mut reader).ok().filter(|_| begins).map(Label::Do)
}

/// Executes the statement that begins at a place of a line, as far as variables go.
pub(super) fn statement(
    line: &[u8],
    at: usize,
    variables: &mut Variables,
) -> Result<Statement, Wrong> {
    if line[at].eq_ignore_ascii_case(&b'O') {
        let message = "a word behind `O…` is not executed";
        let help = "the name of a program belongs into `( … )`; loops and subprograms of LinuxCNC are written out, e.g. by the CAM system";
        return Err(Wrong::new((at, line.len()), message, help));
    }
    if line[at] == b'#' {
        return set(line, at, &ISO, variables);
    }
    let mut reader = Reader::new(line, at, &ISO, variables);
    let statement = if reader.takes_word("IF") {
        let holds = condition(&mut reader)?;
        if reader.takes_word("THEN") {
            let at = reader.at;
            return match reader.peek() {
                Some(b'#') if holds => set(line, at, &ISO, variables),
                Some(b'#') => Ok(Statement::Done),
                _ => Err(Wrong::new((at - 4, at), "only a variable is set behind `THEN`", FLOW)),
            };
        }
        let to = numbered(&mut reader, "GOTO")?;
        if holds { Statement::GoTo(to) } else { Statement::Done }
    } else if reader.takes_word("WHILE") {
        let holds = condition(&mut reader)?;
        let number = numbered(&mut reader, "DO")?;
        if holds { Statement::Done } else { Statement::Leave(number) }
    } else if reader.takes_word("END") {
        Statement::End(number(&mut reader)?)
    } else if reader.letters() == "DO" {
        numbered(&mut reader, "DO")?;
        Statement::Done
    } else {
        Statement::GoTo(numbered(&mut reader, "GOTO")?)
    };
    ended(&mut reader)?;
    Ok(statement)
}

const FLOW: &str = "docs/path.md lists the conditions and loops that are executed";

fn condition(reader: &mut Reader<'_>) -> Result<bool, Wrong> {
    reader.peek();
    let start = reader.at;
    let value = reader.brackets()?;
    let holds = value > 0.0;
    if (value - f64::from(u8::from(holds))).abs() <= 0.0 {
        return Ok(holds);
    }
    Err(Wrong::new(
        (start, reader.at),
        format!("the condition has the value {value}"),
        "compare numbers in it, e.g. `[#1 GT 5]`",
    ))
}

fn number(reader: &mut Reader<'_>) -> Result<u32, Wrong> {
    reader.peek();
    let start = reader.at;
    let value = reader.primary()?;
    whole(value, (start, reader.at))
}

fn numbered(reader: &mut Reader<'_>, word: &str) -> Result<u32, Wrong> {
    if reader.takes_word(word) {
        return number(reader);
    }
    Err(reader.wrong(format!("expected `{word}` with a number here"), FLOW))
}

/// Nothing but a comment stands behind.
fn ended(reader: &mut Reader<'_>) -> Result<(), Wrong> {
    match reader.peek() {
        None | Some(b';') => Ok(()),
        Some(b'(') if !reader.round_brackets() => Ok(()),
        Some(_) => Err(reader.wrong(
            "something stands behind the statement, expected the end of the line",
            "write it in a line of its own",
        )),
    }
}

/// `#1 = 5 #2 = 6`: a block that reads what it sets is refused, as controls differ in the order.
pub(super) fn set(
    line: &[u8],
    at: usize,
    grammar: &'static Grammar,
    variables: &mut Variables,
) -> Result<Statement, Wrong> {
    let mut reader = Reader::new(line, at, grammar, variables);
    let mut values = Vec::new();
    while reader.peek() == Some(grammar.variable) {
        let start = reader.at;
        let name = reader.name()?;
        let place = (start, reader.at);
        let refuse = |message| Err(Wrong::new(place, message, "expected e.g. `#1 = 5`"));
        if name.is_of_control() {
            return refuse(format!(
                "`{name}` is a variable of the control: setting it may move zeros or axes"
            ));
        }
        if !reader.takes(b'=') {
            return refuse(format!("expected `=` behind `{name}`"));
        }
        values.push((name.clone(), reader.expression()?));
        if reader.set.contains(&name) {
            return refuse(format!("`{name}` is set twice in the block"));
        }
        reader.set.push(name);
    }
    ended(&mut reader)?;
    for (name, value) in values {
        variables.insert(name, value);
    }
    Ok(Statement::Done)
}
