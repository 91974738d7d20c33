//! One line of a Siemens file: its grammar, without the meaning of the variables.
//!
//! ```text
//!   line   = ["%" name] | ["N" digits] [ assign | word ] [";" comment]
//!   assign = "$" name ["[" index {"," index} "]"] "=" value      no index: machine data of the whole control
//!   value  = number | "(" axis ")" | '"' axis '"' | TRUE | FALSE
//! ```
//! Blank, tab and `&` separate; case does not matter (SINUMERIK Programming Manual 12/2019,
//! structure of a part program). Whatever is not in this grammar is a complaint: a word that this
//! program does not know could move the machine.

use crate::read::lexer::{Complaint, Cursor};
use crate::read::refusals;
use crate::text::{is_unseen, nearest};
use std::borrow::Cow;
use std::ops::Range;

/// What separates words.
pub(super) const BLANKS: &[char] = &[' ', '\t', '&'];

/// What a line says.
#[derive(Debug)]
pub(super) enum Statement<'a> {
    /// Nothing that changes a table: blank, comment, header, `CHANDATA(1)`, `STOPRE`, which waits until the
    /// blocks before it are done.
    Nothing,
    /// `NEWCONF`: machine data that were written act from here on. It writes none, so where none waits
    /// it changes nothing.
    Activate,
    /// `M0`: the program waits for cycle start.
    Stop,
    /// `M17`, `M30`, `M2` or `M02`.
    End,
    /// An assignment to a `$` variable.
    Set(Assignment<'a>),
}

/// `$NAME[index,…]=value`.
#[derive(Debug)]
pub(super) struct Assignment<'a> {
    /// Name without `$`, upper case.
    pub(super) name: Cow<'a, str>,
    /// Name and indices in the text.
    pub(super) head: Range<usize>,
    /// The indices, upper case.
    pub(super) indices: Vec<Cow<'a, str>>,
    /// Where the value stands.
    pub(super) value_span: Range<usize>,
    /// The value; a complaint if it cannot be read.
    pub(super) value: Result<Value, Complaint>,
}

impl Assignment<'_> {
    /// As files write it, with indices of which `01` and `1` are the same: `$MA_BACKLASH[0,AX1]`.
    pub(super) fn variable(&self) -> String {
        let plain = self.indices.iter().map(|index| match index.parse::<u32>() {
            Ok(number) => number.to_string(),
            Err(_) => index.to_string(),
        });
        match plain.collect::<Vec<String>>().join(",") {
            none if none.is_empty() => format!("${}", self.name),
            indices => format!("${}[{indices}]", self.name),
        }
    }
}

/// The right side of an assignment.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    /// A number.
    Number(f64),
    /// `TRUE` or `FALSE`.
    Truth(bool),
    /// A name in parentheses or quotes, upper case.
    Name(String),
}

/// The code of a line, without the comment behind it.
pub(super) fn code_of(source: &str, line: &Range<usize>) -> Range<usize> {
    let comment = source[line.clone()].find(';');
    line.start..comment.map_or(line.end, |at| line.start + at)
}

/// Whether a word ends a file.
pub(super) fn is_end(word: &str) -> bool {
    ["M17", "M30", "M2", "M02"].contains(&word)
}

/// Reads the code of a line.
pub(super) fn statement(source: &str, code: Range<usize>) -> Result<Statement<'_>, Complaint> {
    let mut cursor = Cursor::new(source, code, BLANKS);
    if cursor.peek_word() == Some('%') {
        return header(&cursor);
    }
    block_number(&mut cursor);
    let found = match cursor.peek_word() {
        None => Statement::Nothing,
        Some('$') => Statement::Set(assignment(&mut cursor)?),
        Some(_) => word(&mut cursor)?,
    };
    let unreadable = matches!(&found, Statement::Set(set) if set.value.is_err());
    if unreadable || cursor.peek_word().is_none() {
        return Ok(found);
    }
    Err(Complaint::new(cursor.rest(), refusals::rest(cursor.text(cursor.rest()))))
}

/// Refuses characters that a control does not read, and in `seen` those that nobody sees.
pub(super) fn check_characters(
    source: &str,
    seen: &Range<usize>,
    code: &Range<usize>,
) -> Result<(), Complaint> {
    let plain = |byte: &u8| *byte == b'\t' || (b' '..=b'~').contains(byte);
    // Every byte is looked at, which takes less time than to stop at the first that is not plain.
    if source.as_bytes()[seen.clone()].iter().fold(true, |all, byte| all & plain(byte)) {
        return Ok(());
    }
    for (offset, c) in source[seen.clone()].char_indices() {
        let at = seen.start + offset;
        let span = at..at + c.len_utf8();
        // Among them U+2028: an editor shows a line end there; a control ends a comment at LF alone
        // (SINUMERIK Programming Manual 12/2019 p. 52) and would run less, or more, than a person sees.
        if is_unseen(c) && c != '\t' {
            let kind = if c.is_control() { "control " } else { "" };
            let code = format!("{:04X}", u32::from(c));
            return Err(Complaint::new(span, refusals::unseen(kind, code)));
        }
        if !c.is_ascii() && at < code.end {
            return Err(Complaint::new(span, refusals::not_ascii_in_code(c)));
        }
    }
    Ok(())
}

/// `%_N_<name>_<ext>` in column 1 of the first line; name up to 24 letters, digits and `_`
/// (HMI Advanced Operator's Guide 03.04, archive formats).
fn header<'a>(cursor: &Cursor<'a>) -> Result<Statement<'a>, Complaint> {
    const LONGEST_NAME: usize = 24;
    let span = cursor.rest();
    if span.start != 0 {
        return Err(Complaint::new(span, refusals::header_elsewhere()));
    }
    let text = cursor.text(span.clone()).to_ascii_uppercase();
    let well_formed = text.strip_prefix("%_N_").and_then(|name| name.rsplit_once('_')).is_some_and(
        |(name, extension)| {
            (1..=LONGEST_NAME).contains(&name.len())
                && extension.len() == 3
                && name.chars().chain(extension.chars()).all(is_of_word)
        },
    );
    if well_formed {
        return Ok(Statement::Nothing);
    }
    Err(Complaint::new(span, refusals::other_header(text)))
}

fn word<'a>(cursor: &mut Cursor<'a>) -> Result<Statement<'a>, Complaint> {
    const WORDS: [&str; 8] = ["M17", "M30", "M2", "M02", "M0", "NEWCONF", "STOPRE", "CHANDATA"];
    let line = cursor.rest();
    let word = take_word(cursor);
    match &*word {
        "NEWCONF" => return Ok(Statement::Activate),
        "STOPRE" => return Ok(Statement::Nothing),
        "M0" | "M00" => return Ok(Statement::Stop),
        "CHANDATA" => return channel_data(cursor),
        end if is_end(end) => return Ok(Statement::End),
        _ => {}
    }
    let near = nearest(&word, WORDS).map(|known| format!("did you mean `{known}`?"));
    let help = near.unwrap_or_else(|| refusals::ONLY_DATA.to_string());
    let found = cursor.text(line.clone());
    Err(Complaint::new(line, refusals::other_word(found, help)))
}

/// The data that follow belong to a channel. Tables are those of the machine, but names of axes may be
/// the channel's own (K3 p. 248), and nothing says what another channel makes of them: only the first,
/// as in the manual's examples (K3 p. 242), is taken.
fn channel_data<'a>(cursor: &mut Cursor<'a>) -> Result<Statement<'a>, Complaint> {
    let start = cursor.at;
    let opened = cursor.eat("(").is_some();
    cursor.peek_word();
    let number = cursor.digits();
    let closed = !number.is_empty() && cursor.eat(")").is_some();
    Err(match number.trim_start_matches('0') {
        "1" if opened && closed => return Ok(Statement::Nothing),
        other if opened && closed => {
            Complaint::new(start..cursor.at, refusals::other_channel(other))
        }
        _ => Complaint::new(cursor.here(), refusals::no_channel()),
    })
}

fn assignment<'a>(cursor: &mut Cursor<'a>) -> Result<Assignment<'a>, Complaint> {
    let start = cursor.at;
    cursor.at += 1;
    let name = take_word(cursor);
    let indices = match cursor.eat("[") {
        Some(_) => indices(cursor, &name)?,
        None => Vec::new(),
    };
    let head = start..cursor.at;
    if cursor.eat("=").is_none() {
        return Err(Complaint::new(cursor.here(), refusals::no_sign(cursor.text(head))));
    }
    cursor.peek_word();
    let value_span = cursor.rest();
    Ok(Assignment { name, head, indices, value_span, value: value(cursor) })
}

/// Room for a measuring system, a point and an axis; what does not fit the variable is complained
/// of there.
const USUAL_INDICES: usize = 3;

fn indices<'a>(cursor: &mut Cursor<'a>, name: &str) -> Result<Vec<Cow<'a, str>>, Complaint> {
    let wrong = |cursor: &Cursor<'_>, expected: &str| {
        Complaint::new(cursor.here(), refusals::in_index(expected, name))
    };
    let mut indices = Vec::with_capacity(USUAL_INDICES);
    loop {
        cursor.peek_word();
        let index = take_word(cursor);
        if index.is_empty() {
            return Err(wrong(cursor, "a number or an axis"));
        }
        indices.push(index);
        match cursor.eat(",]") {
            Some(',') => {}
            Some(_) => return Ok(indices),
            None => return Err(wrong(cursor, "`,` or `]`")),
        }
    }
}

fn value(cursor: &mut Cursor<'_>) -> Result<Value, Complaint> {
    let span = cursor.rest();
    let text = cursor.text(span.clone());
    let refuse =
        |wrong: &str, help| Err(Complaint::new(span.clone(), refusals::value(text, wrong, help)));
    match cursor.peek() {
        Some(open @ ('(' | '"')) => {
            cursor.at += 1;
            cursor.peek_word();
            let name = take_word(cursor);
            let is_name = name.starts_with(|c: char| c.is_ascii_alphabetic());
            let close = if open == '(' { ")" } else { "\"" };
            if is_name && cursor.eat(close).is_some() {
                return Ok(Value::Name(name.into_owned()));
            }
            refuse("is not an axis name", "write `(AX1)` or `\"AX1\"`")
        }
        Some(c) if c.is_ascii_alphabetic() => match &*take_word(cursor) {
            "TRUE" => Ok(Value::Truth(true)),
            "FALSE" => Ok(Value::Truth(false)),
            _ => refuse(
                "is not a value",
                "write a number; an axis name needs parentheses, as `(AX1)`",
            ),
        },
        Some(_) => number(cursor).or_else(|(message, help)| refuse(message, help)),
        None => Err(Complaint::new(cursor.here(), refusals::no_value())),
    }
}

/// Sign, digits and `.digits`; no comma, no exponent. Else what it is and what to write.
fn number(cursor: &mut Cursor<'_>) -> Result<Value, (&'static str, &'static str)> {
    const NOT_A_NUMBER: (&str, &str) = ("is not a number", "write sign, digits, `.` and digits");
    let start = cursor.at;
    if matches!(cursor.peek(), Some('+' | '-')) {
        cursor.at += 1;
    }
    let mut complete = !cursor.digits().is_empty();
    if cursor.peek() == Some('.') {
        cursor.at += 1;
        complete &= !cursor.digits().is_empty();
    }
    match cursor.peek() {
        Some(',') => Err(("has a decimal comma", "write a decimal point")),
        Some('e' | 'E') if complete => Err(("has an exponent", "write all digits, as `0.001`")),
        Some(c) if c.is_ascii_alphanumeric() || "._/".contains(c) => Err(NOT_A_NUMBER),
        _ if !complete => Err(NOT_A_NUMBER),
        _ => match cursor.text(start..cursor.at).parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(Value::Number(number)),
            _ => Err(NOT_A_NUMBER),
        },
    }
}

fn is_of_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

/// Letters, digits and `_`, in upper case.
pub(super) fn take_word<'a>(cursor: &mut Cursor<'a>) -> Cow<'a, str> {
    let word = cursor.take(is_of_word);
    match word.contains(|c: char| c.is_ascii_lowercase()) {
        true => Cow::Owned(word.to_ascii_uppercase()),
        false => Cow::Borrowed(word),
    }
}

/// Skips `N` with digits, a block number or the number of a machine datum in an archive.
pub(super) fn block_number(cursor: &mut Cursor<'_>) {
    let start = cursor.at;
    if cursor.eat("nN").is_some() && cursor.digits().is_empty() {
        cursor.at = start;
    }
}
