//! One block: its words sorted by letter, its G and M words by what they do.

use crate::codes::{NAMED_FROM, name_of};
use crate::scan::{Counts, Word, words_with};
use crate::variables::Variables;
use crate::wrong::Wrong;

/// First and last byte (exclusive) in the line.
pub(super) type Span = (usize, usize);

/// M98.
pub(super) const CALL: u16 = 980;
/// M6.
pub(super) const TOOL_CHANGE: u16 = 60;
/// G or M words in one block; a control takes fewer.
const MOST_CODES: usize = 16;

/// A call of a cycle; `MCALL` makes it modal, and alone ends that.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CycleCall {
    pub(super) modal: bool,
    /// 81, 82 or 83, with its arguments.
    pub(super) cycle: Option<(u16, Vec<Option<f64>>)>,
    pub(super) span: (usize, usize),
}

/// A G or M word: its number in tenths (`G54.1` = 541), and where it stands.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CodeWord {
    pub(super) tenths: u16,
    pub(super) span: Span,
}

impl CodeWord {
    /// As it is written in manuals.
    pub(super) fn name(self, letter: char) -> String {
        if let Some(name) = name_of(self.tenths) {
            return name.to_string();
        }
        match self.tenths % 10 {
            0 => format!("{letter}{}", self.tenths / 10),
            part => format!("{letter}{}.{part}", self.tenths / 10),
        }
    }
}

/// The words of a line.
#[derive(Clone, Debug)]
pub(super) struct Block {
    values: [f64; 26],
    spans: [Span; 26],
    /// Bit per letter: it stands in the block.
    present: u32,
    /// Bit per letter: its number has a decimal point.
    points: u32,
    /// Bit per letter: somebody asked for it.
    used: u32,
    /// Bits per letter: `AC( )`, `IC( )`.
    absolute: u32,
    incremental: u32,
    /// Siemens: a cycle, the name of a tool, how far ADIS lets the control leave the path.
    pub(super) cycle: Option<CycleCall>,
    pub(super) tool_name: Option<(String, Span)>,
    pub(super) adis: Option<f64>,
    pub(super) g: Vec<CodeWord>,
    pub(super) m: Vec<CodeWord>,
    pub(super) percent: bool,
    pub(super) delete: bool,
    pub(super) wrong: Vec<Wrong>,
}

fn bit(letter: u8) -> u32 {
    1 << (letter - b'A')
}

impl Block {
    pub(super) fn new() -> Block {
        Block {
            values: [0.0; 26],
            spans: [(0, 0); 26],
            present: 0,
            points: 0,
            used: 0,
            absolute: 0,
            incremental: 0,
            cycle: None,
            tool_name: None,
            adis: None,
            g: Vec::with_capacity(MOST_CODES),
            m: Vec::with_capacity(MOST_CODES),
            percent: false,
            delete: false,
            wrong: Vec::new(),
        }
    }

    /// Takes the words of a line in place of the former ones.
    pub(super) fn read(&mut self, line: &[u8], variables: &Variables) {
        let Some(line) = self.begin(line) else { return };
        for word in words_with(line, variables) {
            match word {
                Ok(word) => self.take(word),
                Err(wrong) => self.wrong.push(wrong),
            }
        }
    }

    /// Forgets the former words; the line without its end, unless that stands inside.
    pub(super) fn begin<'a>(&mut self, line: &'a [u8]) -> Option<&'a [u8]> {
        (self.present, self.points, self.used) = (0, 0, 0);
        (self.absolute, self.incremental) = (0, 0);
        (self.cycle, self.tool_name, self.adis) = (None, None, None);
        self.g.clear();
        self.m.clear();
        self.wrong.clear();
        (self.percent, self.delete) = (false, false);
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        let Some(at) = line.iter().position(|byte| *byte == b'\r') else {
            return Some(line);
        };
        self.wrong.push(Wrong::new(
            (at, at + 1),
            "a carriage return inside a line: blocks have to end with a line feed",
            "save the program with line ends LF or CR LF",
        ));
        None
    }

    pub(super) fn take(&mut self, word: Word) {
        let span = (word.start, word.end);
        match word.letter {
            b'G' | b'M' => self.take_code(word, span),
            b'%' if self.is_empty() && self.present == 0 => self.percent = true,
            b'%' => self.wrong.push(Wrong::new(
                span,
                "`%` inside a block, expected it at the beginning of a line",
                "put it into a line of its own",
            )),
            b'/' if self.is_empty() => self.delete = true,
            b'/' => self.wrong.push(Wrong::new(
                span,
                "`/` inside a block is not executed, expected it at the beginning of the line",
                "put `/` first, or write the optional words in a line of their own",
            )),
            letter => self.take_value(letter, word, span),
        }
    }

    fn take_value(&mut self, letter: u8, word: Word, span: Span) {
        if self.present & bit(letter) != 0 {
            let letter = char::from(letter);
            self.wrong.push(Wrong::new(
                span,
                format!("`{letter}` is given twice in the block"),
                "keep one of the two",
            ));
            return;
        }
        let index = usize::from(letter - b'A');
        self.values[index] = word.value;
        self.spans[index] = span;
        self.present |= bit(letter);
        if word.has_point {
            self.points |= bit(letter);
        }
        match word.counts {
            Counts::AsActive => {}
            Counts::Absolute => self.absolute |= bit(letter),
            Counts::Incremental => self.incremental |= bit(letter),
        }
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "the number is checked to lie in the range before it is used"
    )]
    fn take_code(&mut self, word: Word, span: Span) {
        let letter = char::from(word.letter);
        let tenths = word.value * 10.0;
        let whole = tenths.round();
        if !(0.0..=9999.0).contains(&whole) || (tenths - whole).abs() > 1e-6 {
            self.wrong.push(Wrong::new(
                span,
                format!("there is no `{letter}{}`", word.value),
                "expected a number from 0 to 999 with at most one decimal",
            ));
            return;
        }
        let codes = if word.letter == b'G' { &mut self.g } else { &mut self.m };
        if codes.len() == MOST_CODES {
            self.wrong.push(Wrong::new(
                span,
                format!("the block has more than {MOST_CODES} {letter} words"),
                "split the block",
            ));
            return;
        }
        codes.push(CodeWord { tenths: whole as u16, span });
    }

    /// A word with a name (`TRANS`), which stands as a G word.
    pub(super) fn take_named(&mut self, index: u16, span: Span) {
        let tenths = NAMED_FROM + index;
        if self.g.len() < MOST_CODES {
            self.g.push(CodeWord { tenths, span });
        }
    }

    /// Whether a coordinate counts from the present place, where `active` is what the modes say.
    pub(super) fn is_incremental(&self, letter: u8, active: bool) -> bool {
        active && self.absolute & bit(letter) == 0 || self.incremental & bit(letter) != 0
    }

    /// Whether nothing was written before (a sequence number does not count).
    pub(super) fn is_empty(&self) -> bool {
        self.g.is_empty() && self.m.is_empty() && self.present & !bit(b'N') == 0 && !self.delete
    }

    pub(super) fn has(&self, letter: u8) -> bool {
        self.present & bit(letter) != 0
    }

    /// Whether any of the letters stands in the block.
    pub(super) fn has_any(&self, letters: &[u8]) -> bool {
        letters.iter().any(|letter| self.has(*letter))
    }

    /// The number of a letter, which then counts as used.
    pub(super) fn value(&mut self, letter: u8) -> Option<f64> {
        self.used |= bit(letter);
        self.has(letter).then(|| self.values[usize::from(letter - b'A')])
    }

    /// Whether the number of a letter has a decimal point.
    pub(super) fn has_point(&self, letter: u8) -> bool {
        self.points & bit(letter) != 0
    }

    pub(super) fn span(&self, letter: u8) -> Span {
        self.spans[usize::from(letter - b'A')]
    }

    /// A whole number from 0, which then counts as used.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "the number is checked to lie in the range before it is used"
    )]
    pub(super) fn whole(&mut self, letter: u8) -> Result<Option<u32>, Wrong> {
        let Some(value) = self.value(letter) else {
            return Ok(None);
        };
        if (0.0..=99_999_999.0).contains(&value) && (value - value.round()).abs() < 1e-9 {
            return Ok(Some(value.round() as u32));
        }
        let letter_shown = char::from(letter);
        Err(Wrong::new(
            self.span(letter),
            format!("`{letter_shown}` is {value}, expected a whole number from 0"),
            "write it without sign and decimals",
        ))
    }

    /// The same of a letter that an M98 of the block does not need for itself.
    pub(super) fn whole_if_free(&mut self, letter: u8) -> Result<Option<u32>, Wrong> {
        if self.m_word(CALL).is_some() { Ok(None) } else { self.whole(letter) }
    }

    /// Whether a letter stands in the block that nobody asked for; it then counts as used.
    pub(super) fn takes(&mut self, letter: u8) -> bool {
        let free = self.present & !self.used & bit(letter) != 0;
        self.used |= bit(letter);
        free
    }

    /// Words that nobody asked for.
    pub(super) fn unused(&self) -> impl Iterator<Item = (char, Span)> + '_ {
        let left = self.present & !self.used;
        (b'A'..=b'Z')
            .filter(move |letter| left & bit(*letter) != 0)
            .map(|letter| (char::from(letter), self.span(letter)))
    }

    /// The first of the M words with this number.
    pub(super) fn m_word(&self, tenths: u16) -> Option<CodeWord> {
        self.m.iter().find(|word| word.tenths == tenths).copied()
    }

    pub(super) fn nothing_unused(&self) -> bool {
        self.present & !self.used == 0
    }
}
