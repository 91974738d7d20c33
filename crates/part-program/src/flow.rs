//! Lines that are no words of a block: variables that are set, and what decides which line comes next.
//!
//! ```text
//!   #1 = [#2 + 3]        IF [#1 GT 5] GOTO 20     IF [#1 GT 5] THEN #1 = 0     GOTO 20
//!   WHILE [#1 LT 5] DO1 … END1                    (Fanuc)
//!   R1 = R2 + 3                                   (Siemens)
//! ```
//!
//! limits  words behind `O…` (loops, conditions and subprograms of LinuxCNC) are refused

use crate::Language;
use crate::lexer::Lexer;
use crate::variables::{Variables, is_of_control};
use crate::wrong::{Wrong, refuse};

const FLOW: &str = "docs/path.md lists the conditions and loops that are executed";

/// A place of the text that lines go to: `O1` of a program, `DO1`, `END1` by the first letter and the number.
pub(crate) type Label = (u8, u32);

/// What comes after a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flow {
    /// The next one.
    Next,
    /// A program with this number, so often.
    Call(u32, u32),
    Return,
    /// M2, M30.
    End,
    /// The second `%`.
    TextEnd,
    /// The block with this number.
    GoTo(u32),
    /// `WHILE … DO1` whose condition does not hold: behind its `END1`.
    Leave(u32),
    /// `END1`: its `DO1`.
    Repeat(u32),
}

/// The first byte from a place on that is of another kind.
fn behind(line: &[u8], from: usize, is_in: fn(u8) -> bool) -> usize {
    let rest = line.get(from..).unwrap_or_default();
    rest.iter().position(|byte| !is_in(*byte)).map_or(line.len(), |length| from + length)
}

/// Where the words of a line begin, behind `/` and N.
fn behind_number(line: &[u8]) -> usize {
    let blank: fn(u8) -> bool = |byte| matches!(byte, b' ' | b'\t');
    let digit: fn(u8) -> bool = |byte| byte.is_ascii_digit();
    let mut at = behind(line, 0, blank);
    if line.get(at) == Some(&b'/') {
        at = behind(line, behind(line, at + 1, digit), blank);
    }
    if matches!(line.get(at), Some(b'N' | b'n')) {
        at = behind(line, behind(line, behind(line, at + 1, blank), digit), blank);
    }
    at
}

/// Whether a word stands behind an `O…`, as in `O1 while`, or its name in brackets, as in `O<hole> call`.
fn is_word_of_linuxcnc(rest: &[u8]) -> bool {
    let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let word = rest[digits..].trim_ascii_start();
    let letters = word.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
    rest.starts_with(b"<") || digits > 0 && letters > 1
}

/// Where the statement of a line begins; `None` for one of words.
#[inline]
pub(crate) fn begin(line: &[u8], language: Language) -> Option<usize> {
    let at = behind_number(line);
    let rest = &line[at..];
    let has = |word: &str| {
        rest.get(..word.len()).is_some_and(|next| next.eq_ignore_ascii_case(word.as_bytes()))
    };
    let begins = match (rest.first()?.to_ascii_uppercase(), language) {
        (b'R', Language::Siemens) => rest.get(1).is_some_and(u8::is_ascii_digit),
        (_, Language::Siemens) => false,
        (b'#', _) => true,
        (b'O', _) => is_word_of_linuxcnc(&rest[1..]),
        (b'I', _) => has("IF"),
        (b'W', _) => has("WHILE"),
        (b'G', _) => has("GOTO"),
        (b'D', _) => has("DO"),
        (b'E', _) => has("END"),
        _ => false,
    };
    begins.then_some(at)
}

/// The loop that a line begins or ends.
pub(crate) fn loop_label(line: &[u8], at: usize) -> Option<Label> {
    let mut lexer = Lexer { line, at, ..Lexer::default() };
    if lexer.takes_word("END") {
        return lexer.whole_number().ok().map(|number| (b'E', number));
    }
    // The condition of a loop may name variables; its number stands behind the last `DO`.
    let text = line.to_ascii_uppercase();
    lexer.at = 2 + text.windows(2).rposition(|pair| pair == b"DO")?;
    let number = lexer.whole_number().ok().filter(|_| matches!(text[at], b'W' | b'D'));
    number.map(|number| (b'D', number))
}

/// Executes the statement that begins at a place of a line, as far as variables go.
pub(crate) fn statement(
    line: &[u8],
    at: usize,
    language: Language,
    variables: &mut Variables,
) -> Result<Flow, Wrong> {
    if line[at].eq_ignore_ascii_case(&b'O') {
        let help = "the name of a program belongs into `( … )`; loops and subprograms of LinuxCNC are written out, e.g. by the CAM system";
        return refuse((at, line.len()), "a word behind `O…` is not executed", help);
    }
    if line[at].eq_ignore_ascii_case(&language.variable()) {
        return set(line, at, language, variables);
    }
    let mut lexer = Lexer { line, at, language, variables: Some(variables), ..Lexer::default() };
    let flow = if lexer.takes_word("IF") {
        let holds = lexer.condition()?;
        if lexer.takes_word("THEN") {
            let at = lexer.at;
            return match lexer.peek() {
                Some(b'#') if holds => set(line, at, language, variables),
                Some(b'#') => Ok(Flow::Next),
                _ => refuse((at - 4, at), "only a variable is set behind `THEN`", FLOW),
            };
        }
        let to = lexer.numbered("GOTO")?;
        if holds { Flow::GoTo(to) } else { Flow::Next }
    } else if lexer.takes_word("WHILE") {
        let holds = lexer.condition()?;
        let number = lexer.numbered("DO")?;
        if holds { Flow::Next } else { Flow::Leave(number) }
    } else if lexer.takes_word("END") {
        Flow::Repeat(lexer.whole_number()?)
    } else if lexer.run_of(u8::is_ascii_alphabetic) == "DO" {
        lexer.numbered("DO")?;
        Flow::Next
    } else {
        Flow::GoTo(lexer.numbered("GOTO")?)
    };
    lexer.ended()?;
    Ok(flow)
}

impl Lexer<'_> {
    fn condition(&mut self) -> Result<bool, Wrong> {
        self.peek();
        let start = self.at;
        let value = self.brackets()?;
        let holds = value > 0.0;
        if (value - f64::from(u8::from(holds))).abs() <= 0.0 {
            return Ok(holds);
        }
        let message = format!("the condition has the value {value}");
        refuse((start, self.at), message, "compare numbers in it, e.g. `[#1 GT 5]`")
    }

    fn numbered(&mut self, word: &str) -> Result<u32, Wrong> {
        if self.takes_word(word) {
            return self.whole_number();
        }
        Err(self.wrong(format!("expected `{word}` with a number here"), FLOW))
    }

    /// Nothing but a comment stands behind.
    fn ended(&mut self) -> Result<(), Wrong> {
        match (self.peek(), self.language) {
            (None | Some(b';'), _) | (Some(b'('), Language::Iso) => Ok(()),
            _ => {
                let message = "something stands behind the statement, expected the end of the line";
                Err(self.wrong(message, "write it in a line of its own"))
            }
        }
    }
}

/// `#1 = 5 #2 = 6`: a block that reads what it sets is refused, as controls differ in the order.
fn set(
    line: &[u8],
    at: usize,
    language: Language,
    variables: &mut Variables,
) -> Result<Flow, Wrong> {
    let mut lexer = Lexer { line, at, language, variables: Some(variables), ..Lexer::default() };
    let mut values = Vec::new();
    while lexer.peek() == Some(language.variable()) {
        let start = lexer.at;
        let name = lexer.name()?;
        let place = (start, lexer.at);
        let wrong = |message| refuse(place, message, "expected e.g. `#1 = 5`");
        if is_of_control(&name) {
            return wrong(format!(
                "`{name}` is a variable of the control: setting it may move zeros or axes"
            ));
        }
        if !lexer.takes(b'=') {
            return wrong(format!("expected `=` behind `{name}`"));
        }
        let value = lexer.expression()?;
        if lexer.set.contains(&name) {
            return wrong(format!("`{name}` is set twice in the block"));
        }
        values.push((name.clone(), value));
        lexer.set.push(name);
    }
    lexer.ended()?;
    variables.extend(values);
    Ok(Flow::Next)
}
