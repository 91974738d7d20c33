//! Lines that are no words of a block: variables that are set, and what decides which line comes next. Where those lines
//! are tells an index of the text, which is made when the first one is asked for.
//!
//! ```text
//!   #1 = [#2 + 3]        IF [#1 GT 5] GOTO 20     IF [#1 GT 5] THEN #1 = 0     GOTO 20
//!   WHILE [#1 LT 5] DO1 … END1                    (Fanuc)
//!   R1 = R2 + 3                                   (Siemens)
//! ```
//!
//! limits  words behind `O…` (loops, conditions and subprograms of LinuxCNC) are refused

use crate::Language;
use crate::expression::{is_of_control, natural};
use crate::lexer::{Lexer, words};
use crate::run::{Mark, Text, without_mark};
use crate::wrong::{Refused, Wrong, refuse};
use std::collections::BTreeMap;

const FLOW: &str = "docs/volume.md lists the conditions and loops that are executed";

/// A place of the text that lines go to, by its word and number: `O1` of a program, `N1`, `DO1`, `END1`.
pub(crate) type Label = (&'static str, u32);

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
    /// GOTO to a block; `WHILE … DO1` whose condition does not hold to its `END1`, which goes to its `DO1`.
    To(Label),
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
        return lexer.whole_number().ok().map(|number| ("END", number));
    }
    // The condition of a loop may name variables; its number stands behind the last `DO` before a comment.
    let text = line.split(|byte| matches!(byte, b'(' | b';')).next()?.to_ascii_uppercase();
    lexer.at = 2 + text.windows(2).rposition(|pair| pair == b"DO")?;
    let number = lexer.whole_number().ok().filter(|_| matches!(text[at], b'W' | b'D'));
    number.map(|number| ("DO", number))
}

/// Variables with the values that a line sets.
pub(crate) type Values = Vec<(String, f64)>;

impl Lexer<'_> {
    /// Executes the statement that begins here: where it leads, and what it sets.
    pub(crate) fn statement(mut self) -> Result<(Flow, Values), Wrong> {
        if self.takes(b'O') {
            let what = "a word behind `O…` is not executed";
            let help = "the name of a program belongs into `( … )`; loops and subprograms of LinuxCNC are written out, e.g. by the CAM system";
            return refuse((self.at - 1, self.line.len()), what, help);
        }
        if self.peek() == Some(self.language.variable()) {
            return Ok((Flow::Next, self.set()?));
        }
        let flow = if self.takes_word("IF") {
            let holds = self.condition()?;
            if self.takes_word("THEN") {
                let at = self.at;
                return match self.peek() {
                    Some(b'#') if holds => Ok((Flow::Next, self.set()?)),
                    Some(b'#') => Ok((Flow::Next, Values::new())),
                    _ => refuse((at - 4, at), "only a variable is set behind `THEN`", FLOW),
                };
            }
            let to = self.numbered("GOTO")?;
            if holds { Flow::To(("N", to)) } else { Flow::Next }
        } else if self.takes_word("WHILE") {
            let holds = self.condition()?;
            let number = self.numbered("DO")?;
            if holds { Flow::Next } else { Flow::To(("END", number)) }
        } else if self.takes_word("END") {
            Flow::To(("DO", self.whole_number()?))
        } else if self.run_of(u8::is_ascii_alphabetic) == "DO" {
            self.numbered("DO")?;
            Flow::Next
        } else {
            Flow::To(("N", self.numbered("GOTO")?))
        };
        self.ended()?;
        Ok((flow, Values::new()))
    }

    /// `#1 = 5 #2 = 6`: a block that reads what it sets is refused, as controls differ in the order.
    fn set(&mut self) -> Result<Values, Wrong> {
        let mut values = Vec::new();
        while self.peek() == Some(self.language.variable()) {
            let start = self.at;
            let name = self.name()?;
            let place = (start, self.at);
            let wrong = |what| refuse(place, what, "expected e.g. `#1 = 5`");
            if is_of_control(&name) {
                return wrong(format!(
                    "`{name}` is a variable of the control: setting it may move zeros or axes"
                ));
            }
            if !self.takes(b'=') {
                return wrong(format!("expected `=` behind `{name}`"));
            }
            let value = self.expression()?;
            if self.set.contains(&name) {
                return wrong(format!("`{name}` is set twice in the block"));
            }
            values.push(value);
            self.set.push(name);
        }
        self.ended()?;
        Ok(std::mem::take(&mut self.set).into_iter().zip(values).collect())
    }

    fn condition(&mut self) -> Result<bool, Wrong> {
        self.peek();
        let start = self.at;
        let value = self.brackets()?;
        let holds = value > 0.0;
        if (value - f64::from(u8::from(holds))).abs() <= 0.0 {
            return Ok(holds);
        }
        let what = format!("the condition has the value {value}");
        refuse((start, self.at), what, "compare numbers in it, e.g. `[#1 GT 5]`")
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
                let what = "something stands behind the statement, expected the end of the line";
                Err(self.wrong(what, "write it in a line of its own"))
            }
        }
    }
}

/// Labels in a file.
const MOST_LABELS: usize = 10_000;

/// Where a line leads, and how many lines were read to find it.
type JumpTarget = (Option<Mark>, usize);

/// The labels of a text.
#[derive(Debug, Default)]
pub(crate) struct Index {
    /// Where the lines with a label begin; of `END` where the next one does.
    labels: BTreeMap<Label, Vec<Mark>>,
    count: usize,
    /// Where the programs begin, ascending.
    programs: Vec<Mark>,
    /// Blocks that were gone to, by the beginning of their program and their N.
    blocks: BTreeMap<(u64, u32), Option<Mark>>,
}

impl Index {
    /// Reads the whole text.
    pub(crate) fn read(text: &mut dyn Text) -> Result<Index, Refused> {
        let here = text.mark();
        text.go_to(Mark::default())?;
        let mut index = Index::default();
        loop {
            let start = text.mark();
            let Some(line) = text.next_line()? else {
                text.go_to(here)?;
                return Ok(index);
            };
            let (bytes, number) = (without_mark(line).bytes, line.number);
            let label = match begin(bytes, Language::Iso) {
                Some(at) => loop_label(bytes, at),
                None => numbered(bytes, b"OoNn:", b'N', b'O').map(|number| ("O", number)),
            };
            let Some(label) = label else { continue };
            index.add(label, if label.0 == "END" { text.mark() } else { start }, number)?;
        }
    }

    fn add(&mut self, label: Label, place: Mark, line: usize) -> Result<(), Refused> {
        let places = self.labels.entry(label).or_default();
        if let ("O", number) = label {
            if !places.is_empty() {
                let what =
                    format!("program O{number} is given twice in the file, again in line {line}");
                return Err(Refused::new(what).help("give one of them another number"));
            }
            self.programs.push(place);
        }
        places.push(place);
        self.count += 1;
        if self.count > MOST_LABELS {
            let what = format!("the file holds more than {MOST_LABELS} subprograms and loops");
            return Err(Refused::new(what));
        }
        Ok(())
    }

    /// Where the line before leads, and how many lines were read to find it; the text stands anywhere then.
    pub(crate) fn target(
        &mut self,
        label: Label,
        text: &mut dyn Text,
    ) -> Result<JumpTarget, Refused> {
        if label.0 == "N" {
            return self.block(text, label.1);
        }
        let here = text.mark().bytes;
        let places = self.labels.get(&label).map_or(&[][..], Vec::as_slice);
        let place = match label.0 {
            "O" => places.first(),
            "DO" => places[..places.partition_point(|place| place.bytes < here)].last(),
            _ => places.get(places.partition_point(|place| place.bytes <= here)),
        };
        Ok((place.copied(), 0))
    }

    /// The block N… of the program that holds the line before.
    fn block(&mut self, text: &mut dyn Text, number: u32) -> Result<JumpTarget, Refused> {
        let here = text.mark();
        let count = self.programs.partition_point(|begin| begin.bytes < here.bytes);
        let begin = self.programs[..count].last().copied().unwrap_or_default();
        let end = self.programs.get(count).map_or(u64::MAX, |next| next.bytes);
        if let Some(known) = self.blocks.get(&(begin.bytes, number)) {
            return Ok((*known, 0));
        }
        text.go_to(begin)?;
        let (mut found, mut lines) = (None, 0);
        while text.mark().bytes < end {
            let mark = text.mark();
            let Some(line) = text.next_line()? else { break };
            lines += 1;
            if numbered(without_mark(line).bytes, b"Nn/", b'/', b'N') != Some(number) {
                continue;
            }
            let line = line.number;
            if found.replace(mark).is_some() {
                let what = format!(
                    "the program goes to N{number}, which is given twice, again in line {line}"
                );
                return Err(Refused::new(what).help("give one of the blocks another number"));
            }
        }
        self.blocks.insert((begin.bytes, number), found);
        Ok((found, lines))
    }
}

/// The number of the first word behind those of a letter, where it has the wanted one; a line with another first
/// letter is passed over at once.
fn numbered(line: &[u8], first: &[u8], behind: u8, wanted: u8) -> Option<u32> {
    let letter = line.iter().find(|byte| !byte.is_ascii_whitespace())?;
    let mut words =
        first.contains(letter).then(|| words(line, Language::Iso).filter_map(Result::ok))?;
    let word = words.find(|word| word.letter != behind)?;
    natural(word.value).filter(|_| word.letter == wanted)
}
