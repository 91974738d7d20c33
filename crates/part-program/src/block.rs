//! One block: its words sorted by letter, its G and M words by what they do.

use crate::Language;
use crate::codes::name_of;
use crate::expression::{Variables, natural, nearly_natural};
use crate::lexer::{Counts, Lexer, Word};
use crate::wrong::{Span, Wrong, refuse};

/// M98.
pub(crate) const CALL: u16 = 980;
/// M6.
pub(crate) const TOOL_CHANGE: u16 = 60;
/// G or M words in one block; a control takes fewer.
const MOST_CODES: usize = 16;

/// A call of a cycle; `MCALL` makes it modal, and alone ends that.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CycleCall {
    pub(crate) modal: bool,
    /// 81, 82 or 83, with its arguments.
    pub(crate) cycle: Option<(u16, Vec<Option<f64>>)>,
    pub(crate) span: Span,
}

/// A G or M word: its number in tenths (`G54.1` = 541), and where it stands.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CodeWord {
    pub(crate) tenths: u16,
    pub(crate) span: Span,
}

impl CodeWord {
    /// As it is written in manuals.
    pub(crate) fn name(self, letter: char) -> String {
        let plain = || format!("{letter}{}", f64::from(self.tenths) / 10.0);
        name_of(self.tenths).map_or_else(plain, str::to_string)
    }
}

/// The words of a line.
#[derive(Clone, Debug, Default)]
pub(crate) struct Block {
    /// Those of letters, `%` and `/`.
    words: [Word; 28],
    /// Bit per letter: it stands in the block.
    present: u32,
    /// Bit per letter: somebody asked for it.
    used: u32,
    /// Siemens: a cycle, the name of a tool, how far ADIS lets the control leave the path.
    pub(crate) cycle: Option<CycleCall>,
    pub(crate) tool_name: Option<(String, Span)>,
    pub(crate) adis: Option<f64>,
    pub(crate) g: Vec<CodeWord>,
    pub(crate) m: Vec<CodeWord>,
    pub(crate) wrong: Vec<Wrong>,
}

fn index(letter: u8) -> usize {
    match letter {
        b'%' => 26,
        b'/' => 27,
        letter => usize::from(letter - b'A'),
    }
}

fn bit(letter: u8) -> u32 {
    1 << index(letter)
}

impl Block {
    /// Takes the words of a line in place of the former ones; of Siemens those to the first that is wrong.
    pub(crate) fn read(&mut self, line: &[u8], language: Language, variables: &Variables) {
        self.forget();
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        if let Some(at) = line.iter().position(|byte| *byte == b'\r') {
            let what = "a carriage return inside a line: blocks have to end with a line feed";
            let help = "save the program with line ends LF or CR LF";
            return self.wrong.push(Wrong::new((at, at + 1), what, help));
        }
        let mut words = Lexer { line, language, variables: Some(variables), ..Lexer::default() };
        while let Some(word) = words.next() {
            let taken = match language {
                Language::Iso => word.map(|word| self.take(word)),
                Language::Siemens => word.and_then(|word| words.item(word, self)),
            };
            if let Err(wrong) = taken {
                self.wrong.push(wrong);
                if language == Language::Siemens {
                    return;
                }
            }
        }
    }

    fn forget(&mut self) {
        (self.present, self.used) = (0, 0);
        (self.cycle, self.tool_name, self.adis) = (None, None, None);
        self.g.clear();
        self.m.clear();
        self.wrong.clear();
    }

    /// Takes a word; what is wrong with it goes into the list.
    pub(crate) fn take(&mut self, word: Word) {
        if let Err(wrong) = self.put(word) {
            self.wrong.push(wrong);
        }
    }

    fn put(&mut self, word: Word) -> Result<(), Wrong> {
        match word.letter {
            b'G' | b'M' => self.take_code(word),
            b'%' if self.present != 0 || !self.is_empty() => {
                let what = "`%` inside a block, expected it at the beginning of a line";
                refuse(word.span, what, "put it into a line of its own")
            }
            b'/' if !self.is_empty() => {
                let what =
                    "`/` inside a block is not executed, expected it at the beginning of the line";
                let help = "put `/` first, or write the optional words in a line of their own";
                refuse(word.span, what, help)
            }
            letter if self.has(letter) => {
                let what = format!("`{}` is given twice in the block", char::from(letter));
                refuse(word.span, what, "keep one of the two")
            }
            letter => {
                self.words[index(letter)] = word;
                self.present |= bit(letter);
                Ok(())
            }
        }
    }

    fn take_code(&mut self, word: Word) -> Result<(), Wrong> {
        let (letter, tenths) = (char::from(word.letter), word.value * 10.0);
        let whole = natural(tenths.round()).and_then(|whole| u16::try_from(whole).ok());
        let whole = whole.filter(|whole| *whole <= 9999);
        let Some(tenths) = whole.filter(|whole| (tenths - f64::from(*whole)).abs() <= 1e-6) else {
            let help = "expected a number from 0 to 999 with at most one decimal";
            return refuse(word.span, format!("there is no `{letter}{}`", word.value), help);
        };
        self.add(word.letter, CodeWord { tenths, span: word.span })
    }

    /// A G or M word, also one with a name (`TRANS`).
    pub(crate) fn add(&mut self, letter: u8, code: CodeWord) -> Result<(), Wrong> {
        let codes = if letter == b'G' { &mut self.g } else { &mut self.m };
        if codes.len() == MOST_CODES {
            let what = format!("the block has more than {MOST_CODES} {} words", char::from(letter));
            return refuse(code.span, what, "split the block");
        }
        codes.push(code);
        Ok(())
    }

    /// Whether a coordinate counts from the present place, where `active` is what the modes say.
    pub(crate) fn is_incremental(&self, letter: u8, active: bool) -> bool {
        match self.word(letter).map_or(Counts::AsActive, |word| word.counts) {
            Counts::AsActive => active,
            counts => counts == Counts::Incremental,
        }
    }

    /// Whether nothing was written before (a sequence number does not count).
    pub(crate) fn is_empty(&self) -> bool {
        self.g.is_empty() && self.m.is_empty() && self.present & !bit(b'N') == 0
    }

    pub(crate) fn has(&self, letter: u8) -> bool {
        self.present & bit(letter) != 0
    }

    /// Whether any of the letters stands in the block.
    pub(crate) fn has_any(&self, letters: &[u8]) -> bool {
        letters.iter().any(|letter| self.has(*letter))
    }

    fn word(&self, letter: u8) -> Option<&Word> {
        self.has(letter).then(|| &self.words[index(letter)])
    }

    /// The number of a letter, which then counts as used.
    pub(crate) fn value(&mut self, letter: u8) -> Option<f64> {
        self.used |= bit(letter);
        self.word(letter).map(|word| word.value)
    }

    /// Whether the number of a letter has a decimal point.
    pub(crate) fn has_point(&self, letter: u8) -> bool {
        self.word(letter).is_some_and(|word| word.has_point)
    }

    /// Where a letter of the block stands.
    pub(crate) fn span(&self, letter: u8) -> Span {
        self.words[index(letter)].span
    }

    /// A whole number from 0, which then counts as used.
    pub(crate) fn whole(&mut self, letter: u8) -> Result<Option<u32>, Wrong> {
        let Some(value) = self.value(letter) else {
            return Ok(None);
        };
        if let Some(number) = nearly_natural(value) {
            return Ok(Some(number));
        }
        let what = format!("`{}` is {value}, expected a whole number from 0", char::from(letter));
        refuse(self.span(letter), what, "write it without sign and decimals")
    }

    /// Whether a letter stands in the block that nobody asked for; it then counts as used.
    pub(crate) fn takes(&mut self, letter: u8) -> bool {
        let free = self.present & !self.used & bit(letter) != 0;
        self.used |= bit(letter);
        free
    }

    /// Words that nobody asked for.
    pub(crate) fn unused(&self) -> Vec<Word> {
        let left = self.present & !self.used & !bit(b'/');
        let letters = if left == 0 { b""[..].iter() } else { b"ABCDEFGHIJKLMNOPQRSTUVWXYZ".iter() };
        letters.filter(|l| left & bit(**l) != 0).map(|l| self.words[index(*l)]).collect()
    }

    /// The first of the M words with this number.
    pub(crate) fn m_word(&self, tenths: u16) -> Option<CodeWord> {
        self.m.iter().find(|word| word.tenths == tenths).copied()
    }
}
