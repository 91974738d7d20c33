//! Where lines lead to: subprograms, loops and labels, found by an index of the text that is made when the first one is
//! asked for.

use crate::inputs::nc::flow::{Label, label};
use crate::inputs::nc::lines::{Mark, Text, without_mark};
use crate::inputs::nc::scan::words;
use crate::text::problem::Problem;
use std::collections::BTreeMap;

/// Labels in a file.
const MOST_LABELS: usize = 10_000;

/// A line with a label: where it begins and ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    pub(super) begin: Mark,
    pub(super) end: Mark,
}

/// The labels of a text.
#[derive(Debug, Default)]
pub(super) struct Index {
    labels: BTreeMap<Label, Vec<Spot>>,
    /// Where the programs begin, ascending.
    programs: Vec<Mark>,
    /// Blocks that were gone to, by the beginning of their program and their N.
    blocks: BTreeMap<(u64, u32), Option<Mark>>,
}

impl Index {
    /// Reads the whole text; it stands anywhere then.
    pub(super) fn read(text: &mut dyn Text) -> Result<Index, Problem> {
        text.go_to(Mark::default())?;
        let mut index = Index::default();
        loop {
            let begin = text.mark();
            let Some(line) = text.next_line()? else {
                return Ok(index);
            };
            let number = line.number;
            let bytes = without_mark(line).bytes;
            let label = label(bytes).or_else(|| program_number(bytes).map(Label::Program));
            let Some(label) = label else { continue };
            let end = text.mark();
            index.add(label, Spot { begin, end }, number)?;
        }
    }

    fn add(&mut self, label: Label, spot: Spot, line: usize) -> Result<(), Problem> {
        let name = match &label {
            Label::Program(number) => Some(format!("program O{number}")),
            _ => None,
        };
        let spots = self.labels.entry(label.clone()).or_default();
        if let Some(name) = name.filter(|_| !spots.is_empty()) {
            return Err(Problem::new(format!(
                "{name} is given twice in the file, again in line {line}"
            ))
            .help("give one of them another number"));
        }
        spots.push(spot);
        if matches!(label, Label::Program(_)) {
            self.programs.push(spot.begin);
        }
        if self.labels.values().map(Vec::len).sum::<usize>() > MOST_LABELS {
            return Err(Problem::new(format!(
                "the file holds more than {MOST_LABELS} subprograms and loops"
            )));
        }
        Ok(())
    }

    /// The only one, or the first, of its kind.
    pub(super) fn first(&self, label: &Label) -> Option<Spot> {
        self.labels.get(label)?.first().copied()
    }

    /// The first one behind a place.
    pub(super) fn after(&self, label: &Label, here: Mark) -> Option<Spot> {
        let spots = self.labels.get(label)?;
        spots.get(spots.partition_point(|spot| spot.begin.bytes < here.bytes)).copied()
    }

    /// The last one before a place.
    pub(super) fn before(&self, label: &Label, here: Mark) -> Option<Spot> {
        let spots = self.labels.get(label)?;
        let count = spots.partition_point(|spot| spot.begin.bytes < here.bytes);
        spots[..count].last().copied()
    }

    /// The block N… of the program that holds a place, and how many lines were read for it.
    pub(super) fn block(
        &mut self,
        text: &mut dyn Text,
        number: u32,
        here: Mark,
    ) -> Result<(Option<Mark>, usize), Problem> {
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
                return Err(Problem::new(format!(
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
    let first = line.iter().find(|byte| !byte.is_ascii_whitespace())?;
    if !matches!(first, b'O' | b'o' | b'N' | b'n' | b':') {
        return None;
    }
    let mut words = words(line).filter_map(Result::ok);
    let word = words.find(|word| word.letter != b'N')?;
    number_of(word.letter == b'O', word.value)
}

fn sequence_number(line: &[u8]) -> Option<u32> {
    let first = line.iter().find(|byte| !byte.is_ascii_whitespace())?;
    if !matches!(first, b'N' | b'n' | b'/') {
        return None;
    }
    let mut words = words(line).filter_map(Result::ok);
    let word = words.find(|word| word.letter != b'/')?;
    number_of(word.letter == b'N', word.value)
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "the number is checked to lie in the range before it is used"
)]
fn number_of(is_one: bool, value: f64) -> Option<u32> {
    (is_one && (0.0..=99_999_999.0).contains(&value)).then_some(value as u32)
}
