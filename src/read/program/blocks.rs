//! What both languages share: words that stay in force, and how a block becomes a deed.

use crate::control::controller::LengthUnit;
use crate::quantity::axis::{Axis, PerAxis};
use crate::read::program::steps::Complaint;
use crate::read::program::words::{Block, Word};
use crate::read::program::{Cancelled, Deed, Step};

/// How a block moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Motion {
    Rapid,
    Feed,
}

/// What a word of a language means here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// Named and without effect on these moves (planes, exact stop).
    Neutral,
    Motion(Motion),
    /// Feeds are per minute, not per turn of a spindle.
    FeedPerMinute,
    Absolute,
    Incremental,
    Unit(LengthUnit),
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

/// The rules of a language.
pub(super) struct Rules<'a> {
    /// Meaning of a name or of an address with its number, as written.
    pub(super) meaning: fn(&str) -> Option<Meaning>,
    /// Address of the seconds of a dwell.
    pub(super) seconds: char,
    /// Whether increments need the word for machine coordinates in their block too.
    pub(super) increments_need_machine: bool,
    /// Addresses of X, Y and Z.
    pub(super) letters: &'a [String],
}

/// Words that stay in force.
#[derive(Default)]
pub(super) struct Modal {
    motion: Option<Motion>,
    incremental: Option<bool>,
    unit: Option<LengthUnit>,
    feed: Option<f64>,
    per_minute: bool,
}

/// What one block says.
#[derive(Default)]
struct Said {
    number: Option<u32>,
    numbers: Vec<(char, f64)>,
    machine: bool,
    dwell: bool,
    of_axes: bool,
    deeds: Vec<Deed>,
}

impl Modal {
    /// The deeds of a block.
    pub(super) fn block(
        &mut self,
        block: &Block,
        rules: &Rules<'_>,
    ) -> Result<Vec<Step>, Complaint> {
        let said = self.said(block, rules)?;
        let mut deeds = said.deeds.clone();
        if said.dwell {
            deeds.push(dwell(&said, rules, block)?);
        } else if !said.of_axes {
            deeds.extend(self.motion(&said, rules, block)?);
        }
        if deeds.len() > 1 && !deeds.iter().all(|deed| matches!(deed, Deed::Cancel(_))) {
            return Err(refuse(block, "this block does more than one thing"));
        }
        let step = |deed| Step {
            deed,
            span: block.span.clone(),
        };
        Ok(deeds.into_iter().map(step).collect())
    }

    fn said(&mut self, block: &Block, rules: &Rules<'_>) -> Result<Said, Complaint> {
        let mut said = Said::default();
        for word in &block.words {
            let written = match word {
                Word::Name(name) => name.clone(),
                Word::Address(letter, number) => format!("{letter}{number}"),
            };
            if let Some(meaning) = (rules.meaning)(&written) {
                self.take(meaning, &mut said);
                continue;
            }
            match word {
                Word::Address('N', number) => said.number = number.parse().ok(),
                Word::Address(letter, number) if is_number_address(*letter, rules) => {
                    let value = number.parse().ok().filter(|v: &f64| v.is_finite());
                    let value = value.ok_or_else(|| refuse(block, "a number cannot be read"))?;
                    if said.numbers.iter().any(|(known, _)| known == letter) {
                        return Err(refuse(
                            block,
                            &format!("`{letter}` stands twice in a block"),
                        ));
                    }
                    said.numbers.push((*letter, value));
                }
                _ => {
                    return Err(refuse(
                        block,
                        &format!("`{written}` is not a word of a measuring run"),
                    ));
                }
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
            Meaning::Cancel(what) => said.deeds.push(Deed::Cancel(what)),
            Meaning::CancelOfAxes(what) => {
                said.of_axes = true;
                said.deeds.push(Deed::Cancel(what));
            }
            Meaning::Stop => said.deeds.push(Deed::Stop),
            Meaning::End => said.deeds.push(Deed::End),
        }
    }

    fn motion(
        &mut self,
        said: &Said,
        rules: &Rules<'_>,
        block: &Block,
    ) -> Result<Option<Deed>, Complaint> {
        let number = |letter: char| said.numbers.iter().find(|(known, _)| *known == letter);
        let moves = |letter: char| letter == 'F' || is_axis(letter, rules);
        if let Some((letter, _)) = said.numbers.iter().find(|(letter, _)| !moves(*letter)) {
            let message = format!("`{letter}` names no axis and stands in no dwell");
            return Err(refuse(block, &message));
        }
        let unit_mm = self.unit.map(LengthUnit::in_mm);
        if let Some((_, feed)) = number('F') {
            let unit =
                unit_mm.ok_or_else(|| refuse(block, "a feed before mm or inch is chosen"))?;
            self.feed = Some(feed * unit);
        }
        let place = PerAxis::from_fn(|axis| {
            let letter = letter(rules, axis)?;
            number(letter).map(|(_, value)| value * unit_mm.unwrap_or(f64::NAN))
        });
        if place.iter().all(|(_, value)| value.is_none()) {
            return match said.machine {
                true => Err(refuse(block, "machine coordinates without a position")),
                false => Ok(None),
            };
        }
        if unit_mm.is_none() {
            return Err(refuse(block, "a position before mm or inch is chosen"));
        }
        match (self.motion, self.incremental, said.machine) {
            (Some(Motion::Rapid), Some(false), true) => Ok(Some(Deed::ToMachine(place))),
            (Some(Motion::Feed), Some(true), machine)
                if machine == rules.increments_need_machine =>
            {
                let feed = self.feed.filter(|_| self.per_minute);
                let feed = feed.ok_or_else(|| refuse(block, "a move without a feed per minute"))?;
                let by = PerAxis::from_fn(|axis| place[axis].unwrap_or(0.0));
                Ok(Some(Deed::By(by, feed)))
            }
            _ => Err(refuse(
                block,
                "a measuring run moves to machine coordinates at rapid traverse, then by increments at a feed; this is neither",
            )),
        }
    }
}

fn dwell(said: &Said, rules: &Rules<'_>, block: &Block) -> Result<Deed, Complaint> {
    match said.numbers.as_slice() {
        [(letter, seconds)] if *letter == rules.seconds && *seconds > 0.0 => {
            Ok(Deed::Dwell(*seconds, said.number))
        }
        _ => Err(refuse(
            block,
            &format!(
                "a dwell names its seconds as `{}` and nothing else",
                rules.seconds
            ),
        )),
    }
}

fn letter(rules: &Rules<'_>, axis: Axis) -> Option<char> {
    let place = Axis::ALL.iter().position(|other| *other == axis)?;
    rules.letters.get(place)?.chars().next()
}

fn is_number_address(letter: char, rules: &Rules<'_>) -> bool {
    letter == 'F' || letter == rules.seconds || is_axis(letter, rules)
}

fn is_axis(letter: char, rules: &Rules<'_>) -> bool {
    Axis::ALL
        .iter()
        .any(|axis| self::letter(rules, *axis) == Some(letter))
}

fn refuse(block: &Block, message: &str) -> Complaint {
    Complaint::new(block.span.clone(), message)
}
