//! Blocks of a part program: their words, what stays in force from block to block, and what a block does.

use crate::control::controller::ControlUnit;
use crate::quantity::axis::{Axis, PerAxis};
use crate::read::lexer::{Complaint, Cursor};
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
    Dwell(f64, Option<u32>),
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
        let found = letters.find(|(_, own)| own.starts_with(letter));
        found.map(|(axis, _)| axis)
    }
}

/// How a block moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::read) enum Motion {
    Rapid,
    Feed,
}

/// What a word of a vocabulary means here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::read) enum Meaning {
    /// Named and without effect on these moves (planes, exact stop).
    Neutral,
    Motion(Motion),
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
    /// Names, and addresses with their number as written.
    pub(in crate::read) words: &'static [(&'static str, Meaning)],
    /// Whether increments need the word for machine coordinates in their block too.
    pub(in crate::read) increments_need_machine: bool,
    /// The blocks of a program.
    pub(in crate::read) blocks: fn(&str) -> Result<Vec<Code>, Complaint>,
}

/// A line without its comments in brackets; `None` where their brackets do not match.
pub(in crate::read) fn without_comments(line: &str) -> Option<String> {
    let mut code = String::new();
    let mut inside = false;
    for letter in line.chars() {
        match (letter, inside) {
            ('(', false) => inside = true,
            (')', true) => inside = false,
            ('(' | ')', _) => return None,
            (_, true) => {}
            (_, false) => code.push(letter),
        }
    }
    (!inside).then_some(code)
}

/// What is wrong with a part of a program.
pub(in crate::read) fn refuse(span: Range<usize>, message: impl Into<String>) -> Complaint {
    let help = "a template of your own may lay out the words, not add others (docs/program.md)";
    Complaint::new(span, message, help)
}

/// What a program does, block by block.
pub(super) fn steps(
    text: &str,
    vocabulary: &Vocabulary,
    own: &OwnWords<'_>,
) -> Result<Vec<Step>, Complaint> {
    let mut modal = Modal::default();
    let mut steps = Vec::new();
    for (start, code) in (vocabulary.blocks)(text)? {
        let span = start..start + code.len();
        let actions = modal.block(&code, vocabulary, own);
        let actions = actions.map_err(|message| refuse(span.clone(), message))?;
        steps.extend(actions.into_iter().map(|action| Step { action, span: span.clone() }));
    }
    Ok(steps)
}

/// Words that stay in force.
#[derive(Default)]
struct Modal {
    motion: Option<Motion>,
    incremental: Option<bool>,
    unit: Option<ControlUnit>,
    feed: Option<f64>,
    per_minute: bool,
}

/// What one block says.
#[derive(Default)]
struct Said {
    number: Option<u32>,
    /// The numbers of axes, feed and seconds, by their address.
    numbers: Vec<(char, f64)>,
    machine: bool,
    dwell: bool,
    of_axes: bool,
    actions: Vec<Action>,
}

impl Modal {
    /// What a block does, or what is wrong with it.
    fn block(
        &mut self,
        code: &str,
        vocabulary: &Vocabulary,
        own: &OwnWords<'_>,
    ) -> Result<Vec<Action>, String> {
        let mut said = self.said(code, vocabulary, own)?;
        if said.dwell {
            said.actions.push(dwell(&said, own)?);
        } else if !said.of_axes {
            let moves = self.motion(&said, vocabulary, own)?;
            said.actions.extend(moves);
        }
        let cancels = |action: &Action| matches!(action, Action::Cancel(_));
        if said.actions.len() > 1 && !said.actions.iter().all(cancels) {
            return Err("this block does more than one thing".to_string());
        }
        Ok(said.actions)
    }

    fn said(
        &mut self,
        code: &str,
        vocabulary: &Vocabulary,
        own: &OwnWords<'_>,
    ) -> Result<Said, String> {
        let mut said = Said::default();
        let mut cursor = Cursor::new(code, 0..code.len(), &[' ', '\t']);
        while cursor.peek_word().is_some() {
            let (written, address) = word(&mut cursor)?;
            let known = vocabulary.words.iter().find(|(word, _)| *word == written);
            match (known, address) {
                (Some((_, meaning)), _) => self.take(*meaning, &mut said),
                (None, Some(('N', number))) => said.number = number.parse().ok(),
                (None, Some((letter, number)))
                    if letter == 'F' || letter == own.seconds || own.axis(letter).is_some() =>
                {
                    let value = number.parse().ok().filter(|v: &f64| v.is_finite());
                    let value = value.ok_or("a number cannot be read")?;
                    if said.numbers.iter().any(|(known, _)| *known == letter) {
                        return Err(format!("`{letter}` is given twice in a block"));
                    }
                    said.numbers.push((letter, value));
                }
                _ => return Err(format!("`{written}` is not a word of a measuring run")),
            }
        }
        Ok(said)
    }

    fn take(&mut self, meaning: Meaning, said: &mut Said) {
        match meaning {
            Meaning::Neutral => {}
            Meaning::Motion(motion) => self.motion = Some(motion),
            Meaning::FeedPerMinute => self.per_minute = true,
            Meaning::Absolute => self.incremental = Some(false),
            Meaning::Incremental => self.incremental = Some(true),
            Meaning::Unit(unit) => self.unit = Some(unit),
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

    fn motion(
        &mut self,
        said: &Said,
        vocabulary: &Vocabulary,
        own: &OwnWords<'_>,
    ) -> Result<Option<Action>, String> {
        let unit_mm = self.unit.map(ControlUnit::in_mm);
        let mut place = PerAxis::<Option<f64>>::default();
        for (letter, value) in &said.numbers {
            match own.axis(*letter) {
                Some(axis) => {
                    let unit = unit_mm.ok_or("a position before mm or inch is chosen")?;
                    place[axis] = Some(value * unit);
                }
                None if *letter == 'F' => {
                    let unit = unit_mm.ok_or("a feed before mm or inch is chosen")?;
                    self.feed = Some(value * unit);
                }
                None => return Err(format!("`{letter}` names no axis and stands in no dwell")),
            }
        }
        if place.iter().all(|(_, value)| value.is_none()) {
            return match said.machine {
                true => Err("machine coordinates without a position".to_string()),
                false => Ok(None),
            };
        }
        match (self.motion, self.incremental, said.machine) {
            (Some(Motion::Rapid), Some(false), true) => Ok(Some(Action::ToMachine(place))),
            (Some(Motion::Feed), Some(true), machine)
                if machine == vocabulary.increments_need_machine =>
            {
                let feed = self.feed.filter(|_| self.per_minute);
                let feed = feed.ok_or("a move without a feed per minute")?;
                let by = PerAxis::from_fn(|axis| place[axis].unwrap_or(0.0));
                Ok(Some(Action::By(by, feed)))
            }
            _ => Err("a measuring run moves to machine coordinates at rapid traverse, then by increments at a feed; this is neither".to_string()),
        }
    }
}

fn dwell(said: &Said, own: &OwnWords<'_>) -> Result<Action, String> {
    match said.numbers.as_slice() {
        [(letter, seconds)] if *letter == own.seconds && *seconds > 0.0 => {
            Ok(Action::Dwell(*seconds, said.number))
        }
        _ => Err(format!("a dwell names its seconds as `{}` and nothing else", own.seconds)),
    }
}

/// A word as written; of an address its letter and number. Two or more letters are a name, one letter is the
/// address of the number behind it.
type Word<'a> = (&'a str, Option<(char, &'a str)>);

fn word<'a>(cursor: &mut Cursor<'a>) -> Result<Word<'a>, String> {
    let start = cursor.at;
    let rest = cursor.text(cursor.rest());
    let name = cursor.take(|c| c.is_ascii_alphabetic());
    let number = cursor.take(|c| c.is_ascii_digit() || "+-.".contains(c));
    let mut letters = name.chars();
    match (letters.next(), letters.next()) {
        (Some(_), Some(_)) if number.is_empty() => Ok((name, None)),
        (Some(letter), None) if number.parse::<f64>().is_ok() => {
            Ok((cursor.text(start..cursor.at), Some((letter, number))))
        }
        _ => Err(format!("`{rest}` is no word")),
    }
}
