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

use crate::read::siemens::assignment::{Assignment, Value, is_digits};

use super::variable::is_alone;
use crate::read::lexer::Complaint;
use crate::text::plain::is_unseen;
use crate::text::problem::nearest;
use std::borrow::Cow;
use std::ops::Range;

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

/// Reads the line `line` (bytes of `source`, without its line end).
pub(super) fn statement(source: &str, line: Range<usize>) -> Result<Statement<'_>, Complaint> {
    let mut bytes = source.as_bytes()[line.clone()].iter();
    let comment = bytes.position(|byte| *byte == b';');
    let code = line.start..comment.map_or(line.end, |at| line.start + at);
    check_characters(source, &line, &code)?;
    let mut cursor = Cursor {
        source,
        at: code.start,
        end: code.end,
    };
    cursor.skip_blanks();
    if cursor.peek() == Some('%') {
        return header(&cursor);
    }
    cursor.block_number();
    let found = match cursor.peek() {
        None => Statement::Nothing,
        Some('$') => Statement::Set(assignment(&mut cursor)?),
        Some(_) => word(&mut cursor)?,
    };
    let unreadable = matches!(&found, Statement::Set(set) if set.value.is_err());
    if unreadable || cursor.at_end() {
        return Ok(found);
    }
    Err(Complaint::new(
        cursor.rest(),
        format!("`{}` follows a complete statement", &source[cursor.rest()]),
        "one line holds one statement; remove the rest or give it its own line",
    ))
}

fn check_characters(
    source: &str,
    line: &Range<usize>,
    code: &Range<usize>,
) -> Result<(), Complaint> {
    let plain = |byte: &u8| *byte == b'\t' || (b' '..=b'~').contains(byte);
    let bytes = source.as_bytes()[line.clone()].iter();
    // Every byte is looked at, which takes less time than to stop at the first that is not plain.
    if bytes.fold(true, |all, byte| all & plain(byte)) {
        return Ok(());
    }
    for (offset, c) in source[line.clone()].char_indices() {
        let at = line.start + offset;
        let span = at..at + c.len_utf8();
        // Among them U+2028: an editor shows a line end there; a control ends a comment at LF alone
        // (SINUMERIK Programming Manual 12/2019 p. 52) and would run less, or more, than a person sees.
        if is_unseen(c) && c != '\t' {
            let kind = if c.is_control() { "control " } else { "" };
            let message = format!("{kind}character U+{:04X} in the file", u32::from(c));
            return Err(Complaint::new(
                span,
                message,
                "transfer the file again as plain text",
            ));
        }
        if !c.is_ascii() && at < code.end {
            let message = format!("`{c}` is not an ASCII character");
            let help = "outside comments the control reads ASCII only";
            return Err(Complaint::new(span, message, help));
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
        return Err(Complaint::new(
            span,
            "a `%` header stands only in column 1 of the first line",
            "give every program its own file",
        ));
    }
    let text = cursor.source[span.clone()].to_ascii_uppercase();
    let well_formed = text
        .strip_prefix("%_N_")
        .and_then(|name| name.rsplit_once('_'))
        .is_some_and(|(name, extension)| {
            (1..=LONGEST_NAME).contains(&name.len())
                && extension.len() == 3
                && name.bytes().chain(extension.bytes()).all(is_word_byte)
        });
    if well_formed {
        return Ok(Statement::Nothing);
    }
    Err(Complaint::new(
        span,
        format!("`{text}` is not a header of the form `%_N_NAME_INI`"),
        "letters, digits and `_`, a name of at most 24 characters and an ending of three",
    ))
}

fn word<'a>(cursor: &mut Cursor<'a>) -> Result<Statement<'a>, Complaint> {
    const WORDS: [&str; 8] = [
        "M17", "M30", "M2", "M02", "M0", "NEWCONF", "STOPRE", "CHANDATA",
    ];
    let line = cursor.rest();
    let word = cursor.take_word();
    match &*word {
        "NEWCONF" => return Ok(Statement::Activate),
        "STOPRE" => return Ok(Statement::Nothing),
        "M17" | "M30" | "M2" | "M02" => return Ok(Statement::End),
        "M0" | "M00" => return Ok(Statement::Stop),
        "CHANDATA" => return channel_data(cursor),
        _ => {}
    }
    let help = match nearest(&word, WORDS) {
        Some(known) => format!("did you mean `{known}`?"),
        None => "a compensation file holds only `$` assignments, `CHANDATA(1)`, `NEWCONF`, \
                 `STOPRE`, `M0` and an end word; anything else could move the machine"
            .to_string(),
    };
    let message = format!("`{}` does not belong here", &cursor.source[line.clone()]);
    Err(Complaint::new(line, message, help))
}

/// The data that follow belong to a channel. Tables are those of the machine, but names of axes may be
/// the channel's own (K3 p. 248), and nothing says what another channel makes of them: only the first,
/// as in the manual's examples (K3 p. 242), is taken.
fn channel_data<'a>(cursor: &mut Cursor<'a>) -> Result<Statement<'a>, Complaint> {
    let line = cursor.at;
    let opened = cursor.eat('(');
    cursor.skip_blanks();
    let number = cursor.take_word();
    if opened && is_digits(&number) && cursor.eat(')') {
        let number = number.trim_start_matches('0');
        if number == "1" {
            return Ok(Statement::Nothing);
        }
        return Err(Complaint::new(
            line..cursor.at,
            format!("`CHANDATA({number})` names another channel, expected the first"),
            "write `CHANDATA(1)`, or leave it out where the file is a part program",
        ));
    }
    Err(Complaint::new(
        cursor.here(),
        "`CHANDATA` needs a channel number in parentheses",
        "write `CHANDATA(1)`",
    ))
}

fn assignment<'a>(cursor: &mut Cursor<'a>) -> Result<Assignment<'a>, Complaint> {
    let start = cursor.at;
    cursor.at += 1;
    let name = cursor.take_word();
    let indices = match is_alone(&name) {
        true => Vec::new(),
        false => indices(cursor, &name)?,
    };
    let head = start..cursor.at;
    if !cursor.eat('=') {
        return Err(Complaint::new(
            cursor.here(),
            format!("`=` is missing after `{}`", &cursor.source[head]),
            "write `$VARIABLE[index]=value`",
        ));
    }
    cursor.skip_blanks();
    let value_span = cursor.rest();
    let value = value(cursor);
    Ok(Assignment {
        name,
        head,
        indices,
        value_span,
        value,
    })
}

/// Room for a measuring system, a point and an axis; what does not fit the variable is complained
/// of there.
const USUAL_INDICES: usize = 3;

fn indices<'a>(cursor: &mut Cursor<'a>, name: &str) -> Result<Vec<Cow<'a, str>>, Complaint> {
    let wrong = |cursor: &Cursor<'_>, expected: &str| {
        Complaint::new(
            cursor.here(),
            format!("{expected} expected in the index of `${name}`"),
            "write whole numbers and axis names between `[` and `]`, separated by commas",
        )
    };
    if !cursor.eat('[') {
        return Err(wrong(cursor, "`[`"));
    }
    let mut indices = Vec::with_capacity(USUAL_INDICES);
    loop {
        cursor.skip_blanks();
        let index = cursor.take_word();
        if index.is_empty() {
            return Err(wrong(cursor, "a number or an axis"));
        }
        indices.push(index);
        if cursor.eat(']') {
            return Ok(indices);
        }
        if !cursor.eat(',') {
            return Err(wrong(cursor, "`,` or `]`"));
        }
    }
}

fn value(cursor: &mut Cursor<'_>) -> Result<Value, Complaint> {
    match cursor.peek() {
        Some('(') => name_between(cursor, '(', ')'),
        Some('"') => name_between(cursor, '"', '"'),
        Some(c) if c.is_ascii_alphabetic() => truth(cursor),
        Some(_) => number(cursor),
        None => Err(Complaint::new(
            cursor.here(),
            "the value is missing",
            "write a number after `=`; if the file ends here it is incomplete",
        )),
    }
}

fn name_between(cursor: &mut Cursor<'_>, open: char, close: char) -> Result<Value, Complaint> {
    let span = cursor.rest();
    cursor.eat(open);
    cursor.skip_blanks();
    let name = cursor.take_word();
    let is_name = name.starts_with(|c: char| c.is_ascii_alphabetic());
    if is_name && cursor.eat(close) {
        return Ok(Value::Name(name.into_owned()));
    }
    let message = format!("`{}` is not an axis name", &cursor.source[span.clone()]);
    Err(Complaint::new(span, message, "write `(AX1)` or `\"AX1\"`"))
}

fn truth(cursor: &mut Cursor<'_>) -> Result<Value, Complaint> {
    let span = cursor.rest();
    match &*cursor.take_word() {
        "TRUE" => Ok(Value::Truth(true)),
        "FALSE" => Ok(Value::Truth(false)),
        _ => Err(Complaint::new(
            span.clone(),
            format!("`{}` is not a value", &cursor.source[span]),
            "write a number; an axis name needs parentheses, as `(AX1)`",
        )),
    }
}

/// Sign, digits and `.digits`; no comma, no exponent.
fn number(cursor: &mut Cursor<'_>) -> Result<Value, Complaint> {
    let all = cursor.rest();
    let start = cursor.at;
    if matches!(cursor.peek(), Some('+' | '-')) {
        cursor.at += 1;
    }
    let whole = cursor.take_digits();
    let mut complete = whole > 0;
    if cursor.peek() == Some('.') {
        cursor.at += 1;
        complete &= cursor.take_digits() > 0;
    }
    let text = &cursor.source[start..cursor.at];
    let found = &cursor.source[all.clone()];
    let (message, help) = match cursor.peek() {
        Some(',') => ("has a decimal comma", "write a decimal point"),
        Some('e' | 'E') if complete => ("has an exponent", "write all digits, as `0.001`"),
        Some(c) if c.is_ascii_alphanumeric() || "._/".contains(c) => NOT_A_NUMBER,
        _ if !complete => NOT_A_NUMBER,
        _ => match text.parse::<f64>() {
            Ok(number) if number.is_finite() => return Ok(Value::Number(number)),
            _ => NOT_A_NUMBER,
        },
    };
    Err(Complaint::new(all, format!("`{found}` {message}"), help))
}

const NOT_A_NUMBER: (&str, &str) = ("is not a number", "write sign, digits, `.` and digits");

fn is_word_byte(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// A place in the code part of a line. The code part is ASCII, so bytes are characters.
struct Cursor<'a> {
    source: &'a str,
    at: usize,
    end: usize,
}

impl<'a> Cursor<'a> {
    fn peek(&self) -> Option<char> {
        let rest = &self.source.as_bytes()[self.at..self.end];
        rest.first().copied().map(char::from)
    }

    fn skip_blanks(&mut self) {
        let rest = &self.source.as_bytes()[self.at..self.end];
        let blanks = rest.iter().take_while(|byte| b" \t&".contains(byte));
        self.at += blanks.count();
    }

    fn at_end(&mut self) -> bool {
        self.skip_blanks();
        self.at == self.end
    }

    /// Takes a character if it comes next, after blanks.
    fn eat(&mut self, wanted: char) -> bool {
        self.skip_blanks();
        let found = self.peek() == Some(wanted);
        self.at += usize::from(found);
        found
    }

    /// Letters, digits and `_`, in upper case.
    fn take_word(&mut self) -> Cow<'a, str> {
        let rest = &self.source.as_bytes()[self.at..self.end];
        let other = rest.iter().position(|byte| !is_word_byte(*byte));
        let length = other.unwrap_or(rest.len());
        let word = &self.source[self.at..self.at + length];
        self.at += length;
        if word
            .bytes()
            .fold(false, |any, byte| any | byte.is_ascii_lowercase())
        {
            Cow::Owned(word.to_ascii_uppercase())
        } else {
            Cow::Borrowed(word)
        }
    }

    fn take_digits(&mut self) -> usize {
        let rest = &self.source.as_bytes()[self.at..self.end];
        let length = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
        self.at += length;
        length
    }

    /// Skips `N` with digits, a block number or the number of a machine datum in an archive.
    fn block_number(&mut self) {
        let start = self.at;
        if matches!(self.peek(), Some('n' | 'N')) {
            self.at += 1;
            if self.take_digits() == 0 {
                self.at = start;
            }
        }
        self.skip_blanks();
    }

    /// From here to the end of the code, without blanks at the end.
    fn rest(&self) -> Range<usize> {
        let text = self.source[self.at..self.end].trim_end_matches([' ', '\t', '&']);
        self.at..self.at + text.len()
    }

    /// The next character.
    fn here(&self) -> Range<usize> {
        self.at..self.at + 1
    }
}
