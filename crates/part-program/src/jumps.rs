//! Where lines lead to: subprograms, loops and labels, found by an index of the text that is made when the first one is
//! asked for.

use crate::flow::{Label, begin as begin_of, label};
use crate::lines::{Mark, Text, without_mark};
use crate::scan::words;
use crate::wrong::Refused;
use std::collections::BTreeMap;

/// Labels in a file.
const MOST_LABELS: usize = 10_000;

/// The labels of a text.
#[derive(Debug, Default)]
pub(super) struct Index {
    /// Where the lines with a label begin; of `END` where the next one does.
    labels: BTreeMap<Label, Vec<Mark>>,
    /// Where the programs begin, ascending.
    programs: Vec<Mark>,
    /// Blocks that were gone to, by the beginning of their program and their N.
    blocks: BTreeMap<(u64, u32), Option<Mark>>,
}

impl Index {
    /// Reads the whole text; it stands anywhere then.
    pub(super) fn read(text: &mut dyn Text) -> Result<Index, Refused> {
        text.go_to(Mark::default())?;
        let mut index = Index::default();
        loop {
            let begin = text.mark();
            let Some(line) = text.next_line()? else {
                return Ok(index);
            };
            let number = line.number;
            let bytes = without_mark(line).bytes;
            let program = || program_number(bytes).filter(|_| begin_of(bytes).is_none());
            let label = label(bytes).or_else(|| program().map(Label::Program));
            let Some(label) = label else { continue };
            let place = if matches!(label, Label::End(_)) { text.mark() } else { begin };
            index.add(label, place, number)?;
        }
    }

    fn add(&mut self, label: Label, place: Mark, line: usize) -> Result<(), Refused> {
        let places = self.labels.entry(label.clone()).or_default();
        if let Label::Program(number) = label {
            if !places.is_empty() {
                return Err(Refused::new(format!(
                    "program O{number} is given twice in the file, again in line {line}"
                ))
                .help("give one of them another number"));
            }
            self.programs.push(place);
        }
        places.push(place);
        if self.labels.values().map(Vec::len).sum::<usize>() > MOST_LABELS {
            return Err(Refused::new(format!(
                "the file holds more than {MOST_LABELS} subprograms and loops"
            )));
        }
        Ok(())
    }

    /// The only one, or the first, of its kind.
    pub(super) fn first(&self, label: &Label) -> Option<Mark> {
        self.labels.get(label)?.first().copied()
    }

    /// The first one behind a place; `END` by its end.
    pub(super) fn after(&self, label: &Label, here: Mark) -> Option<Mark> {
        let places = self.labels.get(label)?;
        places.get(places.partition_point(|place| place.bytes <= here.bytes)).copied()
    }

    /// The last one before a place.
    pub(super) fn before(&self, label: &Label, here: Mark) -> Option<Mark> {
        let places = self.labels.get(label)?;
        let count = places.partition_point(|place| place.bytes < here.bytes);
        places[..count].last().copied()
    }

    /// The block N… of the program that holds a place, and how many lines were read for it.
    pub(super) fn block(
        &mut self,
        text: &mut dyn Text,
        number: u32,
        here: Mark,
    ) -> Result<(Option<Mark>, usize), Refused> {
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
            if sequence_number(without_mark(line).bytes) != Some(number) {
                continue;
            }
            let line = line.number;
            if found.replace(mark).is_some() {
                return Err(Refused::new(format!(
                    "the program goes to N{number}, which is given twice, again in line {line}"
                ))
                .help("give one of the blocks another number"));
            }
        }
        self.blocks.insert((begin.bytes, number), found);
        Ok((found, lines))
    }
}

/// The number of a line that begins with `O` or `:`.
fn program_number(line: &[u8]) -> Option<u32> {
    numbered(line, b"OoNn:", b'N', b'O')
}

fn sequence_number(line: &[u8]) -> Option<u32> {
    numbered(line, b"Nn/", b'/', b'N')
}

/// The number of the first word behind those of a letter, where it has the wanted one; a line with another first
/// letter is passed over at once.
fn numbered(line: &[u8], first: &[u8], behind: u8, wanted: u8) -> Option<u32> {
    let letter = line.iter().find(|byte| !byte.is_ascii_whitespace())?;
    let mut words = first.contains(letter).then(|| words(line).filter_map(Result::ok))?;
    let word = words.find(|word| word.letter != behind)?;
    number_of(word.letter == wanted, word.value)
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "the number is checked to lie in the range before it is used"
)]
fn number_of(is_one: bool, value: f64) -> Option<u32> {
    (is_one && (0.0..=99_999_999.0).contains(&value)).then_some(value as u32)
}
