//! Blocks of a part program: their words, what stays in force from block to block, and what a block does.

use crate::control::controller::ControlUnit;
use crate::quantity::{Axis, PerAxis};
use crate::read::lexer::Complaint;
use crate::read::refusals;
use part_program::{Language, NAME, words};
use std::ops::Range;

/// What can be active when a program begins and would falsify its moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cancelled {
    /// Tool length.
    ToolLength,
    /// Tool radius.
    ToolRadius,
    /// Work offsets.
    Offset,
    /// Shifts of the program.
    Shift,
    /// Rotation.
    Rotation,
    /// Scaling.
    Scaling,
    /// Mirroring.
    Mirroring,
    /// Kinematic transformations.
    Transformation,
    /// Drilling cycles.
    Cycle,
}

/// One thing that a program does; lengths in mm.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Cancels something.
    Cancel(Cancelled),
    /// Waits for cycle start.
    Stop,
    /// Goes to machine coordinates; `None` = the axis stays.
    ToMachine(PerAxis<Option<f64>>),
    /// Goes by an increment at a feed, mm/min.
    By(PerAxis<f64>, f64),
    /// Stands still for some seconds, in the block with this number.
    Dwell(f64, Option<f64>),
    /// Ends.
    End,
}

/// An action and the bytes of its block.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// What is done.
    pub action: Action,
    /// Where it stands.
    pub span: Range<usize>,
}

/// What a machine or a control names itself.
#[derive(Clone, Copy, Debug)]
pub struct OwnWords<'a> {
    /// Addresses of the axes X, Y and Z.
    pub letters: &'a [String],
    /// Address of the seconds of a dwell.
    pub seconds: char,
}

impl OwnWords<'_> {
    fn axis(&self, letter: char) -> Option<Axis> {
        let mut letters = Axis::ALL.into_iter().zip(self.letters);
        letters.find(|(_, own)| own.starts_with(letter)).map(|(axis, _)| axis)
    }
}

/// What a word of a vocabulary means here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::read) enum Meaning {
    /// Named and without effect on these moves (planes, exact stop).
    Neutral,
    Rapid,
    Feed,
    /// Feeds are per minute, not per turn of a spindle.
    FeedPerMinute,
    Absolute,
    Incremental,
    Unit(ControlUnit),
    /// Positions of this block are machine coordinates.
    Machine,
    /// This block is a dwell.
    Dwell,
    Cancel(Cancelled),
    /// Cancels; the numbers of the axes in its block are no moves.
    CancelOfAxes(Cancelled),
    Stop,
    End,
}

/// A block without its comments, and the byte of the program at which it begins.
pub(in crate::read) type Code = (usize, String);

/// The words of a language of part programs.
pub(in crate::read) struct Vocabulary {
    /// How words are written.
    pub(in crate::read) language: Language,
    /// Names, and addresses with their number, beside those that other languages have, too.
    pub(in crate::read) words: &'static [(&'static str, Meaning)],
    /// The blocks of a program.
    pub(in crate::read) blocks: fn(&str) -> Result<Vec<Code>, Complaint>,
}

/// Words that mean the same in every language.
const COMMON: [(&str, Meaning); 9] = [
    ("G0", Meaning::Rapid),
    ("G1", Meaning::Feed),
    ("G4", Meaning::Dwell),
    ("G17", Meaning::Neutral),
    ("G40", Meaning::Cancel(Cancelled::ToolRadius)),
    ("G90", Meaning::Absolute),
    ("G91", Meaning::Incremental),
    ("G94", Meaning::FeedPerMinute),
    ("M0", Meaning::Stop),
];

/// Those that mean the same in every one that keeps to ISO 6983.
const ISO: [(&str, Meaning); 6] = [
    ("G20", Meaning::Unit(ControlUnit::Inch)),
    ("G21", Meaning::Unit(ControlUnit::Millimetre)),
    ("G49", Meaning::Cancel(Cancelled::ToolLength)),
    ("G53", Meaning::Machine),
    ("G64", Meaning::Neutral),
    ("G80", Meaning::Cancel(Cancelled::Cycle)),
];

impl Vocabulary {
    /// What a word means.
    fn meaning(&self, word: &str) -> Option<Meaning> {
        let iso = ISO.iter().filter(|_| self.language == Language::Iso);
        let mut words = COMMON.iter().chain(iso).chain(self.words);
        words.find(|(known, _)| *known == word).map(|(_, meaning)| *meaning)
    }
}

/// A line without its comments in brackets.
pub(in crate::read) fn without_comments(
    text: &str,
    line: &Range<usize>,
) -> Result<String, Complaint> {
    let code = outside_brackets(&text[line.clone()]);
    code.ok_or_else(|| refuse(line.clone(), "the brackets of a comment do not match"))
}

fn outside_brackets(line: &str) -> Option<String> {
    let mut parts = line.split(')');
    let last = parts.next_back().filter(|last| !last.contains('('))?;
    let code = parts.map(|part| part.split_once('(').filter(|(_, rest)| !rest.contains('(')));
    let code: Option<String> = code.map(|part| part.map(|(code, _)| code)).collect();
    Some(code? + last)
}

/// What is wrong with a part of a program.
pub(in crate::read) fn refuse(span: Range<usize>, message: impl Into<String>) -> Complaint {
    Complaint::new(span, refusals::of_program(message.into()))
}

/// What a program does, block by block.
pub(super) fn steps(
    text: &str,
    vocabulary: &Vocabulary,
    own: &OwnWords<'_>,
) -> Result<Vec<Step>, Complaint> {
    let mut reader = Reader { vocabulary, own, modal: Modal::default() };
    let mut steps = Vec::new();
    for (start, code) in (vocabulary.blocks)(text)? {
        let span = start..start + code.len();
        let actions = reader.block(&code).map_err(|message| refuse(span.clone(), message))?;
        steps.extend(actions.into_iter().map(|action| Step { action, span: span.clone() }));
    }
    Ok(steps)
}

struct Reader<'a> {
    vocabulary: &'a Vocabulary,
    own: &'a OwnWords<'a>,
    modal: Modal,
}

/// Words that stay in force.
#[derive(Default)]
struct Modal {
    /// G1, else G0.
    feeds: Option<bool>,
    incremental: Option<bool>,
    unit_mm: Option<f64>,
    feed: Option<f64>,
    per_minute: bool,
}

/// What one block says.
#[derive(Default)]
struct Said {
    number: Option<f64>,
    /// The numbers of axes, feed and seconds, by their address.
    numbers: Vec<(char, f64)>,
    machine: bool,
    dwell: bool,
    of_axes: bool,
    actions: Vec<Action>,
}

impl Reader<'_> {
    /// What a block does, or what is wrong with it.
    fn block(&mut self, code: &str) -> Result<Vec<Action>, String> {
        let mut said = self.said(code)?;
        if said.dwell {
            said.actions.push(self.dwell(&said)?);
        } else if !said.of_axes {
            said.actions.extend(self.motion(&said)?);
        }
        let cancels = |action: &Action| matches!(action, Action::Cancel(_));
        if said.actions.len() > 1 && !said.actions.iter().all(cancels) {
            return Err("this block does more than one thing".to_string());
        }
        Ok(said.actions)
    }

    fn said(&mut self, code: &str) -> Result<Said, String> {
        let mut said = Said::default();
        let no_word = |at: usize| format!("`{}` is no word", code[at..].trim_end());
        if let Some(at) = code.find(';') {
            return Err(no_word(at)); // a comment for some controls, the end of a block for others
        }
        for word in words(code.as_bytes(), self.vocabulary.language) {
            let word = word.map_err(|wrong| no_word(wrong.span.0))?;
            let written = code[word.span.0..word.span.1].trim_end();
            let letter = char::from(word.letter);
            let name = match word.letter {
                NAME => written.to_string(),
                _ => format!("{letter}{}", word.value),
            };
            let is_number = letter == 'F' || letter == self.own.seconds;
            if let Some(meaning) = self.vocabulary.meaning(&name) {
                self.take(meaning, &mut said);
            } else if letter == 'N' {
                said.number = Some(word.value);
            } else if is_number || self.own.axis(letter).is_some() {
                if said.numbers.iter().any(|(known, _)| *known == letter) {
                    return Err(format!("`{letter}` is given twice in a block"));
                }
                said.numbers.push((letter, word.value));
            } else if written.starts_with('$') {
                return Err(no_word(word.span.0));
            } else {
                return Err(format!("`{written}` is not a word of a measuring run"));
            }
        }
        Ok(said)
    }

    fn take(&mut self, meaning: Meaning, said: &mut Said) {
        match meaning {
            Meaning::Neutral => {}
            Meaning::Rapid | Meaning::Feed => self.modal.feeds = Some(meaning == Meaning::Feed),
            Meaning::FeedPerMinute => self.modal.per_minute = true,
            Meaning::Absolute => self.modal.incremental = Some(false),
            Meaning::Incremental => self.modal.incremental = Some(true),
            Meaning::Unit(unit) => self.modal.unit_mm = Some(unit.in_mm()),
            Meaning::Machine => said.machine = true,
            Meaning::Dwell => said.dwell = true,
            Meaning::Cancel(what) => said.actions.push(Action::Cancel(what)),
            Meaning::CancelOfAxes(what) => {
                said.of_axes = true;
                said.actions.push(Action::Cancel(what));
            }
            Meaning::Stop => said.actions.push(Action::Stop),
            Meaning::End => said.actions.push(Action::End),
        }
    }

    fn motion(&mut self, said: &Said) -> Result<Option<Action>, String> {
        let mut place = PerAxis::<Option<f64>>::default();
        for (letter, value) in &said.numbers {
            let mm = |what| {
                let mm = self.modal.unit_mm.map(|unit| value * unit);
                mm.ok_or_else(|| format!("a {what} before mm or inch is chosen"))
            };
            match self.own.axis(*letter) {
                Some(axis) => place[axis] = Some(mm("position")?),
                None if *letter == 'F' => self.modal.feed = Some(mm("feed")?),
                None => return Err(format!("`{letter}` names no axis and stands in no dwell")),
            }
        }
        if place.iter().all(|(_, value)| value.is_none()) {
            return match said.machine {
                true => Err("machine coordinates without a position".to_string()),
                false => Ok(None),
            };
        }
        // Siemens goes by increments from machine coordinates where `SUPA` stands in their block too.
        let with_increments = self.vocabulary.language == Language::Siemens;
        match (self.modal.feeds, self.modal.incremental, said.machine) {
            (Some(false), Some(false), true) => Ok(Some(Action::ToMachine(place))),
            (Some(true), Some(true), machine) if machine == with_increments => {
                let feed = self.modal.feed.filter(|_| self.modal.per_minute);
                let feed = feed.ok_or("a move without a feed per minute")?;
                Ok(Some(Action::By(PerAxis::from_fn(|axis| place[axis].unwrap_or(0.0)), feed)))
            }
            _ => Err("a measuring run moves to machine coordinates at rapid traverse, then by increments at a feed; this is neither".to_string()),
        }
    }

    fn dwell(&self, said: &Said) -> Result<Action, String> {
        match said.numbers.as_slice() {
            [(letter, seconds)] if *letter == self.own.seconds && *seconds > 0.0 => {
                Ok(Action::Dwell(*seconds, said.number))
            }
            _ => {
                let seconds = self.own.seconds;
                Err(format!("a dwell names its seconds as `{seconds}` and nothing else"))
            }
        }
    }
}
