//! Words of a block: a letter with a number, or a name.

use crate::read::program::steps::Complaint;
use std::ops::Range;

/// One word.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Word {
    /// `G91`, `X-2.5`; the number as written.
    Address(char, String),
    /// `SUPA`.
    Name(String),
}

/// A block without its comment, and where it stands.
pub(super) struct Block {
    pub(super) words: Vec<Word>,
    pub(super) span: Range<usize>,
}

/// What a control takes for a blank; other characters that look like one are no words.
const BLANKS: [char; 2] = [' ', '\t'];

/// The words of `code`, which begins at byte `start` of the program. Two or more letters are a
/// name, one letter is the address of the number behind it.
pub(super) fn block(code: &str, start: usize) -> Result<Block, Complaint> {
    let span = start..start + code.len();
    let mut words = Vec::new();
    let mut rest = code.trim_matches(BLANKS);
    while !rest.is_empty() {
        let letters = run(rest, |c| c.is_ascii_alphabetic());
        let (name, behind) = rest.split_at(letters);
        let digits = run(behind, |c| c.is_ascii_digit() || "+-.".contains(c));
        let (number, behind) = behind.split_at(digits);
        let mut initial = name.chars();
        match (initial.next(), initial.next()) {
            (Some(_), Some(_)) if number.is_empty() => words.push(Word::Name(name.to_string())),
            (Some(letter), None) if is_number(number) => {
                words.push(Word::Address(letter, number.to_string()));
            }
            _ => {
                return Err(Complaint::new(
                    span,
                    format!("`{}` is no word", rest.trim()),
                ));
            }
        }
        rest = behind.trim_start_matches(BLANKS);
    }
    Ok(Block { words, span })
}

fn run(text: &str, belongs: impl Fn(char) -> bool) -> usize {
    text.find(|c| !belongs(c)).unwrap_or(text.len())
}

fn is_number(text: &str) -> bool {
    let digits = text.trim_start_matches(['+', '-']);
    text.len() - digits.len() <= 1
        && digits.contains(|c: char| c.is_ascii_digit())
        && text.parse::<f64>().is_ok()
}

/// The lines of a program with the byte at which each begins; CR belongs to the line end.
pub(super) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut at = 0;
    text.split('\n').map(move |line| {
        let start = at + (line.len() - line.trim_start_matches('\r').len());
        at += line.len() + 1;
        (start, line.trim_matches('\r'))
    })
}
