//! Where lines lead to: subprograms, loops and labels, found by an index of the text that is made when the first one is
//! asked for.

use crate::Language;
use crate::expression::natural;
use crate::flow::{Flow, Label, begin, loop_label};
use crate::lexer::words;
use crate::lines::{Mark, Text, without_mark};
use crate::wrong::Refused;
use std::collections::BTreeMap;

/// Labels in a file.
const MOST_LABELS: usize = 10_000;

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
    /// Reads the whole text; it stands anywhere then.
    pub(crate) fn read(text: &mut dyn Text) -> Result<Index, Refused> {
        text.go_to(Mark::default())?;
        let mut index = Index::default();
        loop {
            let start = text.mark();
            let Some(line) = text.next_line()? else {
                return Ok(index);
            };
            let (bytes, number) = (without_mark(line).bytes, line.number);
            let label = match begin(bytes, Language::Iso) {
                Some(at) => loop_label(bytes, at),
                None => numbered(bytes, b"OoNn:", b'N', b'O').map(|number| (b'O', number)),
            };
            let Some(label) = label else { continue };
            let place = if label.0 == b'E' { text.mark() } else { start };
            index.add(label, place, number)?;
        }
    }

    fn add(&mut self, label: Label, place: Mark, line: usize) -> Result<(), Refused> {
        let places = self.labels.entry(label).or_default();
        if let (b'O', number) = label {
            if !places.is_empty() {
                let message =
                    format!("program O{number} is given twice in the file, again in line {line}");
                return Err(Refused::new(message).help("give one of them another number"));
            }
            self.programs.push(place);
        }
        places.push(place);
        self.count += 1;
        if self.count > MOST_LABELS {
            let message = format!("the file holds more than {MOST_LABELS} subprograms and loops");
            return Err(Refused::new(message));
        }
        Ok(())
    }

    /// Where a line leads that stands before `here`, and how many lines were read to find it; else what is missing.
    pub(crate) fn target(
        &mut self,
        flow: Flow,
        text: &mut dyn Text,
        here: Mark,
    ) -> Result<(Result<Mark, String>, usize), Refused> {
        let places = |label: Label| self.labels.get(&label).map_or(&[][..], Vec::as_slice);
        let (found, missing) = match flow {
            Flow::GoTo(number) => {
                let (found, passed) = self.block(text, number, here)?;
                return Ok((found.ok_or(format!("N{number}")), passed));
            }
            Flow::Call(program, _) => (places((b'O', program)).first(), format!("O{program}")),
            Flow::Repeat(number) => {
                let mut before = places((b'D', number)).iter().rev();
                (before.find(|place| place.bytes < here.bytes), format!("DO{number}"))
            }
            Flow::Leave(number) => {
                let mut behind = places((b'E', number)).iter();
                (behind.find(|place| place.bytes > here.bytes), format!("END{number}"))
            }
            Flow::Next | Flow::Return | Flow::End | Flow::TextEnd => (None, String::new()),
        };
        Ok((found.copied().ok_or(missing), 0))
    }

    /// The block N… of the program that holds a place, and how many lines were read for it.
    fn block(
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
            if numbered(without_mark(line).bytes, b"Nn/", b'/', b'N') != Some(number) {
                continue;
            }
            let line = line.number;
            if found.replace(mark).is_some() {
                let message = format!(
                    "the program goes to N{number}, which is given twice, again in line {line}"
                );
                return Err(Refused::new(message).help("give one of the blocks another number"));
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
