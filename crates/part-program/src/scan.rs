//! A line of a part program as words: a letter and a number, with the place of each.
//!
//! Blanks may stand anywhere, even inside a number; letters in either case. Comments `( … )` and
//! `; …` are ignored. Numbers keep the full precision of what is written.

use crate::wrong::{Wrong, refuse_long_number};

use crate::expression::Reader;
use crate::grammar::ISO;
use crate::variables::Variables;

/// A letter with its number, or one of the signs `%` and `/`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Word {
    /// Capital letter, `%` or `/`; `O` for `:0100`, too.
    pub letter: u8,
    /// Its number; 0 after `%` and after `/` without one.
    pub value: f64,
    /// Whether the number is written with a decimal point.
    pub has_point: bool,
    /// Where it counts from.
    pub counts: Counts,
    /// First byte in the line.
    pub start: usize,
    /// Byte behind the last one.
    pub end: usize,
}

/// Where a coordinate counts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counts {
    /// As G90, G91 and the kind of the word say.
    AsActive,
    /// `AC( )` of Siemens: from the zero.
    Absolute,
    /// `IC( )`: from the present place.
    Incremental,
}

/// The words of a line, one after the other.
#[derive(Clone, Debug)]
pub struct Words<'a> {
    line: &'a [u8],
    at: usize,
    /// Without them expressions are refused.
    variables: Option<&'a Variables>,
}

/// The words of a line, which may still have its `\r`, with numbers only.
pub fn words(line: &[u8]) -> Words<'_> {
    Words { line, at: 0, variables: None }
}

/// The words of a line, whose numbers may be variables and expressions in brackets.
pub(super) fn words_with<'a>(line: &'a [u8], variables: &'a Variables) -> Words<'a> {
    Words { line, at: 0, variables: Some(variables) }
}

impl Iterator for Words<'_> {
    type Item = Result<Word, Wrong>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let byte = *self.line.get(self.at)?;
            match byte {
                b' ' | b'\t' | b'\r' => self.at += 1,
                b';' => self.at = self.line.len(),
                b'(' => match self.comment() {
                    Ok(()) => {}
                    Err(wrong) => return Some(Err(wrong)),
                },
                b'A'..=b'Z' | b'a'..=b'z' => return Some(self.word(byte.to_ascii_uppercase())),
                b':' if self.line.get(self.at + 1).is_some_and(u8::is_ascii_digit) => {
                    return Some(self.word(b'O')); // the program number of ISO tapes
                }
                b'/' => return Some(self.slash()),
                b'%' => return Some(Ok(self.percent())),
                _ => return Some(Err(self.unknown(byte))),
            }
        }
    }
}

impl Words<'_> {
    /// Passes over a comment in brackets.
    fn comment(&mut self) -> Result<(), Wrong> {
        let start = self.at;
        let rest = &self.line[start..];
        match rest.iter().position(|byte| *byte == b')') {
            Some(length) => {
                self.at = start + length + 1;
                Ok(())
            }
            None => {
                self.at = self.line.len();
                Err(Wrong::new(
                    (start, self.at),
                    "the comment is not closed in its line",
                    "close it with `)`",
                ))
            }
        }
    }

    #[inline]
    fn word(&mut self, letter: u8) -> Result<Word, Wrong> {
        let start = self.at;
        self.at += 1;
        let (value, has_point) = self.number(start)?;
        Ok(Word { letter, value, has_point, counts: Counts::AsActive, start, end: self.at })
    }

    fn slash(&mut self) -> Result<Word, Wrong> {
        let start = self.at;
        self.at += 1;
        let digit = self.line.get(self.at).copied();
        let switch = digit.filter(|byte| (b'1'..=b'9').contains(byte));
        self.at += usize::from(switch.is_some());
        Ok(Word {
            letter: b'/',
            value: switch.map_or(0.0, |digit| f64::from(digit - b'0')),
            has_point: false,
            counts: Counts::AsActive,
            start,
            end: self.at,
        })
    }

    /// What stands behind `%` in its line is the name of a tape.
    fn percent(&mut self) -> Word {
        let start = self.at;
        self.at = self.line.len();
        Word {
            letter: b'%',
            value: 0.0,
            has_point: false,
            counts: Counts::AsActive,
            start,
            end: start + 1,
        }
    }

    /// The number of a word, and whether it has a decimal point.
    #[inline]
    fn number(&mut self, start: usize) -> Result<(f64, bool), Wrong> {
        let (mut digits, mut signed, mut point) = (0_usize, false, false);
        let first = self.at;
        let mut end = first;
        let mut has_blank = false;
        while let Some(byte) = self.line.get(self.at) {
            match byte {
                b'0'..=b'9' => digits += 1,
                b'.' if !point => point = true,
                b'+' | b'-' if !signed && digits == 0 && !point => signed = true,
                b' ' | b'\t' => {
                    self.at += 1;
                    continue;
                }
                _ => break,
            }
            has_blank |= self.at > end;
            self.at += 1;
            end = self.at;
        }
        if digits == 0 {
            let next = self.line[end..].iter().find(|byte| !byte.is_ascii_whitespace());
            let is_expression = matches!(next, Some(b'[' | b'#')) && !point;
            return match self.variables.filter(|_| is_expression) {
                Some(variables) => self.expression(first, variables),
                None => Err(self.no_number(start, end)),
            };
        }
        refuse_long_number((start, end), digits)?;
        self.at = end;
        let written = String::from_utf8_lossy(&self.line[first..end]);
        let number = match has_blank {
            true => written.replace([' ', '\t'], "").parse(),
            false => written.parse(),
        };
        match number {
            Ok(number) => Ok((number, point)),
            Err(_) => Err(self.no_number(start, end)),
        }
    }

    /// A variable or an expression in brackets, from its sign on: its value is in the program's unit.
    fn expression(&mut self, first: usize, variables: &Variables) -> Result<(f64, bool), Wrong> {
        let mut reader = Reader::new(self.line, first, &ISO, variables);
        let value = reader.number_of_word();
        self.at = match value {
            Ok(_) => reader.at,
            Err(_) => self.line.len(), // the rest is one expression
        };
        value.map(|value| (value, true))
    }

    fn no_number(&mut self, start: usize, end: usize) -> Wrong {
        self.at = end;
        let letter = char::from(self.line[start]);
        let mut rest = self.line[end..].iter();
        let next = rest.find(|byte| !byte.is_ascii_whitespace());
        let help = match next {
            Some(b'[' | b'#') => NUMBERS,
            Some(b'=') => {
                "expected words like `X10.5`; a Siemens program needs `language = \"siemens\"` in [path]"
            }
            _ => "write letter and number, e.g. `X10.5`; text belongs into `( … )`",
        };
        if matches!(next, Some(b'[' | b'#' | b'=')) {
            self.at = self.line.len(); // the rest is one expression
        }
        Wrong::new((start, end), format!("`{letter}` has no number"), help)
    }

    /// A sign that begins no word. The rest of the line is ignored where it would be misread.
    fn unknown(&mut self, byte: u8) -> Wrong {
        let start = self.at;
        let is_one = byte.is_ascii_graphic() && !matches!(byte, b'#' | b'[' | b']' | b'=' | b',');
        self.at = if is_one { start + 1 } else { self.line.len() };
        let help = match byte {
            b'#' | b'[' | b']' => NUMBERS,
            b',' => "write numbers with a point, like `X10.5`",
            _ => "text belongs into `( … )`",
        };
        let message = "a sign that begins no word, expected a letter";
        Wrong::new((start, start + 1), message, help)
    }
}

const NUMBERS: &str =
    "variables and expressions are not executed: let the CAM system write numbers";

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read(line: &str) -> Vec<(char, f64)> {
        words(line.as_bytes())
            .map(|word| word.expect("a word"))
            .map(|word| (char::from(word.letter), word.value))
            .collect()
    }

    #[test]
    fn tricky_lines_are_words() {
        assert_eq!(read("n10g1 x1.5y-.25"), [('N', 10.0), ('G', 1.0), ('X', 1.5), ('Y', -0.25)]);
        assert_eq!(read("X 1 0 . 5 (X99) Y+2.;Z3"), [('X', 10.5), ('Y', 2.0)]);
        assert_eq!(read("/1 G 54.1 P 7"), [('/', 1.0), ('G', 54.1), ('P', 7.0)]);
        assert_eq!(read("% tape 7"), [('%', 0.0)]);
        assert_eq!(read("X12000.123456789012345"), [('X', 12_000.123_456_789_012)]);
        assert_eq!(read("X12000.123Y0.1"), [('X', 12000.123), ('Y', 0.1)]);
        assert_eq!(read("  \t"), []);
    }

    #[test]
    fn what_is_no_word_has_its_place() {
        let wrong = |line: &str| {
            let found = words(line.as_bytes()).find_map(Result::err).expect("something is wrong");
            (found.start, found.end)
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
            for word in words(&line) {
                let (start, end) = match word {
                    Ok(word) => (word.start, word.end),
                    Err(wrong) => (wrong.start, wrong.end),
                };
                prop_assert!(start >= at && end > start && end <= line.len());
                at = start + 1;
            }
        }

        #[test]
        fn numbers_keep_all_digits(value in -1e7..1e7f64, decimals in 0_usize..12) {
            let text = format!("{value:.decimals$}");
            let word = words(format!("X{text}").as_bytes()).next().expect("a word").expect("a number");
            let expected: f64 = text.parse().expect("a number");
            prop_assert_eq!(word.value.to_bits() << 1, expected.to_bits() << 1);
        }
    }
}
