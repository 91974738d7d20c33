//! A line of a part program as words: a letter and a number, or a name, with the place of each. **The one lexer of all
//! readers**: of blocks, expressions, statements and labels, and of who reads a program's words only ([`words`]).
//!
//! Blanks may stand anywhere, in ISO programs even inside a number; letters in either case. Comments `( … )` (ISO) and
//! `; …` are ignored. Numbers keep the full precision of what is written.

use crate::Language;
use crate::expression::Variables;
use crate::wrong::{Span, Wrong, refuse, refuse_long_number};

/// The letter of a [`Word`] that is a name (`TRANS`).
pub const NAME: u8 = b'_';
const NUMBERS: &str =
    "variables and expressions are not executed: let the CAM system write numbers";

/// A letter with its number, a name, or one of the signs `%` and `/`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Word {
    /// Capital letter, `%`, `/` or [`NAME`]; `O` for `:0100`, too.
    pub letter: u8,
    /// Its number; 0 after `%` and `/`, and of a name.
    pub value: f64,
    /// Whether the number is written with a decimal point.
    pub has_point: bool,
    /// Where it counts from.
    pub counts: Counts,
    /// First byte in the line, and the byte behind the last one; a number of Siemens with the blanks behind it.
    pub span: (usize, usize),
}

/// Where a coordinate counts from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Counts {
    /// As G90, G91 and the kind of the word say.
    #[default]
    AsActive,
    /// `AC( )` of Siemens: from the zero.
    Absolute,
    /// `IC( )`: from the present place.
    Incremental,
}

/// Reads a line from a place on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lexer<'a> {
    pub(crate) line: &'a [u8],
    pub(crate) at: usize,
    pub(crate) language: Language,
    /// Without them variables have no value, and numbers of ISO words are no expressions.
    pub(crate) variables: Option<&'a Variables>,
    /// Brackets that are open.
    pub(crate) depth: usize,
    /// An expression is the number of a word.
    pub(crate) in_word: bool,
    /// What the block sets before this place.
    pub(crate) set: Vec<String>,
}

/// The words of a line, which may still have its `\r`, with numbers only.
pub fn words(line: &[u8], language: Language) -> impl Iterator<Item = Result<Word, Wrong>> + '_ {
    Lexer { line, language, ..Lexer::default() }
}

impl Iterator for Lexer<'_> {
    type Item = Result<Word, Wrong>;
    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        let is_iso = self.language == Language::Iso;
        loop {
            let byte = *self.line.get(self.at)?;
            return Some(match byte {
                b' ' | b'\t' | b'\r' => {
                    self.at += 1;
                    continue;
                }
                b';' => {
                    self.at = self.line.len();
                    return None;
                }
                b'(' if is_iso => match self.comment() {
                    Ok(()) => continue,
                    Err(wrong) => Err(wrong),
                },
                b'A'..=b'Z' | b'a'..=b'z' if is_iso => self.word(byte.to_ascii_uppercase()),
                b'A'..=b'Z' | b'a'..=b'z' | b'_' | b'$' if !is_iso => self.word_or_name(),
                b':' if is_iso && self.line.get(self.at + 1).is_some_and(u8::is_ascii_digit) => {
                    self.word(b'O') // the program number of ISO tapes
                }
                b'/' | b'%' => Ok(self.sign(byte, is_iso)),
                _ => Err(self.unknown(byte)),
            });
        }
    }
}

impl Lexer<'_> {
    /// The next sign that is no blank, which stays.
    pub(crate) fn peek(&mut self) -> Option<u8> {
        while matches!(self.line.get(self.at), Some(b' ' | b'\t' | b'\r')) {
            self.at += 1;
        }
        self.line.get(self.at).map(u8::to_ascii_uppercase)
    }

    /// Passes over a sign.
    pub(crate) fn takes(&mut self, sign: u8) -> bool {
        let is_next = self.peek() == Some(sign);
        self.at += usize::from(is_next);
        is_next
    }

    /// Whether a word stands next, behind blanks; it stays.
    pub(crate) fn is_next(&mut self, word: &str) -> bool {
        self.peek();
        let next = self.line.get(self.at..self.at + word.len());
        next.is_some_and(|next| next.eq_ignore_ascii_case(word.as_bytes()))
    }

    /// Passes over a word.
    pub(crate) fn takes_word(&mut self, word: &str) -> bool {
        let is_next = self.is_next(word);
        self.at += if is_next { word.len() } else { 0 };
        is_next
    }

    /// How many of these bytes stand next.
    pub(crate) fn length_of(&self, is_in: fn(&u8) -> bool) -> usize {
        self.line[self.at..].iter().take_while(|byte| is_in(byte)).count()
    }

    /// What stands next of these bytes, in capitals; it stays.
    pub(crate) fn run_of(&self, is_in: fn(&u8) -> bool) -> String {
        let run = &self.line[self.at..self.at + self.length_of(is_in)];
        String::from_utf8_lossy(run).to_ascii_uppercase()
    }

    /// Something wrong with the next byte.
    pub(crate) fn wrong(&self, what: impl Into<String>, help: &str) -> Wrong {
        let start = self.at.min(self.line.len().saturating_sub(1));
        Wrong::new((start, start + 1), what, help)
    }

    /// Passes over a comment in brackets.
    fn comment(&mut self) -> Result<(), Wrong> {
        let start = self.at;
        let length = self.line[start..].iter().position(|byte| *byte == b')');
        self.at = length.map_or(self.line.len(), |length| start + length + 1);
        if length.is_some() {
            return Ok(());
        }
        refuse((start, self.at), "the comment is not closed in its line", "close it with `)`")
    }

    /// Of ISO: a letter with its number, whose digits blanks may part, or with an expression.
    #[inline]
    fn word(&mut self, letter: u8) -> Result<Word, Wrong> {
        let start = self.at;
        let (mut digits, mut signed, mut has_point, mut has_blank) = (0, false, false, false);
        let mut end = start + 1;
        for (at, byte) in self.line.iter().enumerate().skip(end) {
            match byte {
                b'0'..=b'9' => digits += 1,
                b'.' if !has_point => has_point = true,
                b'+' | b'-' if !signed && digits == 0 && !has_point => signed = true,
                b' ' | b'\t' => continue,
                _ => break,
            }
            has_blank |= at > end;
            end = at + 1;
        }
        self.at = end;
        let word = Word { letter, has_point, span: (start, end), ..Word::default() };
        if digits == 0 {
            return self.with_expression(word);
        }
        refuse_long_number(word.span, digits)?;
        let text = String::from_utf8_lossy(&self.line[start + 1..end]);
        let number = if has_blank { text.replace([' ', '\t'], "").parse() } else { text.parse() };
        number.map(|value| Word { value, ..word }).map_err(|_| self.no_number(word.span))
    }

    /// A variable or an expression in brackets, from its sign on: its value is in the program's unit.
    fn with_expression(&mut self, word: Word) -> Result<Word, Wrong> {
        let (start, end) = word.span;
        let next = self.line[end..].iter().find(|byte| !byte.is_ascii_whitespace());
        if self.variables.is_none() || word.has_point || !matches!(next, Some(b'[' | b'#')) {
            return Err(self.no_number(word.span));
        }
        (self.at, self.in_word) = (start + 1, true);
        let value = self.primary();
        if value.is_err() {
            (self.at, self.depth) = (self.line.len(), 0); // the rest is one expression
        }
        value.map(|value| Word { value, has_point: true, span: (start, self.at), ..word })
    }

    /// Of Siemens: a name, a letter with its number, or one before `=`.
    fn word_or_name(&mut self) -> Result<Word, Wrong> {
        let start = self.at;
        let [first, next] = [start, start + 1].map(|at| self.line.get(at).copied().unwrap_or(0));
        if !first.is_ascii_alphabetic() || next.is_ascii_alphabetic() || next == b'_' {
            self.at += self.identifier().len();
            return Ok(Word { letter: NAME, span: (start, self.at), ..Word::default() });
        }
        let letter = first.to_ascii_uppercase();
        self.at += 1;
        let mut word = Word { letter, has_point: true, span: (start, self.at), ..Word::default() };
        match self.peek() {
            Some(b'=') => {}
            Some(b'0'..=b'9' | b'.' | b'+' | b'-') => {
                word.value = self.primary()?;
                self.peek();
                word.span.1 = self.at;
            }
            _ => {
                let what = format!("`{}` has no number", char::from(letter));
                return refuse(word.span, what, "write it like `X10.5` or `X=R1+5`");
            }
        }
        Ok(word)
    }

    /// The letters, digits, `_` and `$` that stand next, in capitals; they stay.
    pub(crate) fn identifier(&mut self) -> String {
        self.peek();
        self.run_of(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'$'))
    }

    /// `/` with the number of its switch, or `%` with the name of a tape behind it.
    fn sign(&mut self, letter: u8, is_iso: bool) -> Word {
        let (start, most) = (self.at, if is_iso { 1 } else { usize::MAX });
        let is_switch = |byte: &&u8| byte.is_ascii_digit() && !(is_iso && **byte == b'0');
        let digits = self.line[start + 1..].iter().take(most).take_while(is_switch).count();
        self.at = if letter == b'/' { start + 1 + digits } else { self.line.len() };
        let end = if is_iso && letter == b'/' { self.at } else { start + 1 };
        Word { letter, span: (start, end), ..Word::default() }
    }

    fn no_number(&mut self, (start, end): Span) -> Wrong {
        let letter = char::from(self.line[start]);
        let next = self.line[end..].iter().find(|byte| !byte.is_ascii_whitespace());
        let help = match next {
            Some(b'[' | b'#') => NUMBERS,
            Some(b'=') => {
                "expected words like `X10.5`; a Siemens program needs `language = \"siemens\"` in [path]"
            }
            _ => "write letter and number, e.g. `X10.5`; text belongs into `( … )`",
        };
        self.at = if matches!(next, Some(b'[' | b'#' | b'=')) { self.line.len() } else { end };
        Wrong::new((start, end), format!("`{letter}` has no number"), help)
    }

    /// A sign that begins no word. The rest of the line is ignored where it would be misread.
    fn unknown(&mut self, byte: u8) -> Wrong {
        let start = self.at;
        let is_one = byte.is_ascii_graphic() && !matches!(byte, b'#' | b'[' | b']' | b'=' | b',');
        self.at = if is_one { start + 1 } else { self.line.len() };
        let help = match byte {
            _ if self.language == Language::Siemens => "text belongs behind `;`",
            b'#' | b'[' | b']' => NUMBERS,
            b',' => "write numbers with a point, like `X10.5`",
            _ => "text belongs into `( … )`",
        };
        Wrong::new((start, start + 1), "a sign that begins no word, expected a letter", help)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read(line: &str) -> Vec<(char, f64)> {
        words(line.as_bytes(), Language::Iso)
            .map(|word| word.expect("a word"))
            .map(|word| (char::from(word.letter), word.value))
            .collect()
    }

    #[test]
    fn tricky_lines_are_words() {
        assert_eq!(read("n10g1 x1.5y-.25"), [('N', 10.0), ('G', 1.0), ('X', 1.5), ('Y', -0.25)]);
        assert_eq!(read("X 1 0 . 5 (X99) Y+2.;Z3"), [('X', 10.5), ('Y', 2.0)]);
        assert_eq!(read("/1 G 54.1 P 7"), [('/', 0.0), ('G', 54.1), ('P', 7.0)]);
        assert_eq!(read("% tape 7"), [('%', 0.0)]);
        assert_eq!(read("X12000.123456789012345"), [('X', 12_000.123_456_789_012)]);
        assert_eq!(read("X12000.123Y0.1"), [('X', 12000.123), ('Y', 0.1)]);
        assert_eq!(read("  \t"), []);
    }

    #[test]
    fn names_and_letters_of_siemens_are_words() {
        let line = b"N10 SUPA G0 X-1.5 ; to the start";
        let read = words(line, Language::Siemens).map(|word| word.expect("a word"));
        let read: Vec<_> = read.map(|word| (word.letter, word.value, word.span)).collect();
        let [n, supa] = [(b'N', 10.0, (0, 4)), (NAME, 0.0, (4, 8))];
        assert_eq!(read, [n, supa, (b'G', 0.0, (9, 12)), (b'X', -1.5, (12, 18))]);
    }

    #[test]
    fn what_is_no_word_has_its_place() {
        let wrong = |line: &str| {
            let mut words = words(line.as_bytes(), Language::Iso);
            words.find_map(Result::err).expect("something is wrong").span
        };
        assert_eq!(wrong("G1 X#100"), (3, 4));
        assert_eq!(wrong("G1 #100=5"), (3, 4));
        assert_eq!(wrong("G1 X[1+2]"), (3, 4));
        assert_eq!(wrong("G1 X=5"), (3, 4));
        assert_eq!(wrong("G1 X--5"), (3, 5));
        assert_eq!(wrong("G1 (open"), (3, 8));
        assert_eq!(wrong("G1 X1.2.3"), (7, 8));
    }

    proptest! {
        #[test]
        fn any_line_ends(line in proptest::collection::vec(any::<u8>(), 0..200)) {
            let mut at = 0;
            for word in words(&line, Language::Iso) {
                let (start, end) = match word {
                    Ok(word) => word.span,
                    Err(wrong) => wrong.span,
                };
                prop_assert!(start >= at && end > start && end <= line.len());
                at = start + 1;
            }
        }

        #[test]
        fn numbers_keep_all_digits(value in -1e7..1e7f64, decimals in 0_usize..12) {
            let text = format!("X{value:.decimals$}");
            let word = words(text.as_bytes(), Language::Iso).next().expect("a word").expect("a number");
            let expected: f64 = text[1..].parse().expect("a number");
            prop_assert_eq!(word.value.to_bits() << 1, expected.to_bits() << 1);
        }
    }
}
