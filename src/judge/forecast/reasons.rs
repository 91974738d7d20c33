//! What a verdict is made of, as facts: the errors that were judged, what that rests on, what does not keep a
//! limit. In words they are the sentences of the command line and of the JSON; a page makes its own lines of them.

use super::figures::{LimitFigures, Of, Own};
use super::share::{self, JudgedRange};
use super::{Change, Forecast};
use crate::inputs::error_table::Cause;
use crate::inputs::job::{Acceptance, Job};
use crate::judge::conformity::Verdict;
use crate::quantity::{Direction, ErrorTerm};
use crate::text::joined;
use std::cmp::Ordering;
use std::fmt;

/// So many errors are named one by one.
const FEW: usize = 3;

/// What a verdict is made of; nothing where nothing was judged.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grounds {
    /// The errors that the limit for errors was applied to: never more than were measured.
    pub terms: Vec<ErrorTerm>,
    /// What it rests on and does not count.
    pub rests_on: Vec<RestsOn>,
    /// What does not keep a limit for sure, errors and diagonals in their order.
    pub misses: Vec<Miss>,
}

/// What a verdict rests on, or does not count.
#[derive(Clone, Debug, PartialEq)]
pub enum RestsOn {
    /// The part of each axis that was measured.
    Ranges(Vec<JudgedRange>),
    /// Errors between the targets: how much was added for them, µm, else at which pitches no target could show them.
    Between {
        /// As stated; 0 = not stated.
        periodic_um: f64,
        /// The part of each axis, which tells the pitches.
        ranges: Vec<JudgedRange>,
    },
    /// All was measured in this direction only.
    OneWay(Direction),
    /// These were not measured in both directions; empty = none was.
    NoReversal(Vec<ErrorTerm>),
    /// Both directions were measured; no curve holds the reversal.
    ReversalNotCounted,
    /// U of these counts as 0 because nobody stated it; empty = of all.
    WithoutU(Vec<ErrorTerm>),
    /// Causes that are zero by a statement of the job, without a measurement.
    Neglected(Vec<Cause>),
    /// Keys of the job that are stated and used in no figure.
    Unused(Vec<&'static str>),
    /// Body diagonals are asked for, and an error is missing or measured in one direction only.
    NineNeeded,
}

/// Why an acceptance is not kept for sure.
#[derive(Clone, Debug, PartialEq)]
pub enum Miss {
    /// A figure against its limit.
    Figure {
        /// What it is of.
        of: Of,
        /// What is left, µm.
        um: f64,
        /// What it is at most, with 95 %, µm; `None` = not stated.
        at_most_um: Option<f64>,
        /// The limit, µm.
        limit_um: f64,
        /// Fail or undecided.
        verdict: Verdict,
    },
    /// Too little of an axis was measured.
    Range(JudgedRange),
    /// A cause that was neither stated nor measured.
    NotStated(Cause),
}

impl Miss {
    /// The worst first: fails, then by figure + U in limits; what was not measured has no figure.
    pub(crate) fn worst_first(&self, other: &Miss) -> Ordering {
        let (own, others) = (self.rank(), other.rank());
        others.0.cmp(&own.0).then(others.1.total_cmp(&own.1))
    }

    fn rank(&self) -> (Verdict, f64) {
        match self {
            Miss::Figure { um, at_most_um, limit_um, verdict, .. } => {
                (*verdict, at_most_um.unwrap_or(*um) / limit_um)
            }
            Miss::Range(_) => (Verdict::Undecided, 0.0),
            Miss::NotStated(_) => (Verdict::Undecided, f64::INFINITY),
        }
    }
}

impl Forecast {
    /// What its verdict against the acceptance of a job is made of.
    pub(crate) fn grounds(&self, job: &Job) -> Grounds {
        let acceptance = job.acceptance;
        if acceptance.asks_nothing() {
            return Grounds::default();
        }
        Grounds {
            terms: self.terms.iter().map(|term| term.term).collect(),
            rests_on: self.rests_on(job),
            misses: self.misses(acceptance),
        }
    }

    /// Why the acceptance is not kept for sure.
    pub(crate) fn misses(&self, acceptance: Acceptance) -> Vec<Miss> {
        let limit = acceptance.max_deviation_um;
        let unsaid = self.silence.not_stated.iter().filter(|_| limit.is_some());
        let unsaid = unsaid.copied().map(Miss::NotStated);
        let terms = limit.iter().flat_map(|limit| self.missing(&self.all_terms(), *limit));
        let terms = unsaid.chain(terms);
        let diagonals = acceptance.max_diagonal_um.iter().filter(|_| !self.diagonals.is_empty());
        let diagonals = diagonals.flat_map(|limit| self.missing(&self.all_diagonals(), *limit));
        let asked = !acceptance.asks_nothing();
        let ranges = self.ranges.iter().filter(|range| asked && !range.is_known());
        terms.chain(diagonals).chain(ranges.cloned().map(Miss::Range)).collect()
    }

    /// The figures that miss a limit by themselves; where none does, whether all together do, whose U takes long
    /// and is asked for only then.
    fn missing(&self, all: &LimitFigures<'_>, limit_um: f64) -> Vec<Miss> {
        let figure =
            |of, um, at_most_um, verdict| Miss::Figure { of, um, at_most_um, limit_um, verdict };
        let missed = |all: &LimitFigures<'_>| {
            Some(self.judge(all, limit_um)).filter(|verdict| *verdict != Verdict::Pass)
        };
        let one = |own: &Own<'_>| {
            let Change { after_um, at_most_um, .. } = own.change;
            Some(figure(own.of, after_um, at_most_um, missed(&own.alone())?))
        };
        let singly: Vec<Miss> = all.each.iter().filter_map(one).collect();
        if !singly.is_empty() {
            return singly;
        }
        let together = missed(all);
        let together =
            together.map(|verdict| figure(all.of, all.left_um(), self.at_most_um(all), verdict));
        together.into_iter().collect()
    }

    /// What a verdict rests on, and what it does not count.
    fn rests_on(&self, job: &Job) -> Vec<RestsOn> {
        let unused = job.measurement.unused_keys();
        let neglected = self.silence.neglected.clone();
        let asks_diagonals = job.acceptance.max_diagonal_um.is_some();
        let nine_needed = asks_diagonals && self.diagonals.is_empty();
        let parts = [
            Some(RestsOn::Ranges(self.ranges.clone())),
            Some(RestsOn::Between {
                periodic_um: job.measurement.uncertainty.between_um(),
                ranges: self.ranges.clone(),
            }),
            self.directions(),
            self.without_u(),
            (!neglected.is_empty()).then_some(RestsOn::Neglected(neglected)),
            (!unused.is_empty()).then_some(RestsOn::Unused(unused)),
            nine_needed.then_some(RestsOn::NineNeeded),
        ];
        parts.into_iter().flatten().collect()
    }

    /// What no figure holds because an axis was not measured both ways; `None` = all were.
    fn directions(&self) -> Option<RestsOn> {
        let without = self.terms.iter().filter(|t| t.one_way.is_some());
        let names: Vec<ErrorTerm> = without.map(|t| t.term).collect();
        let only = |way: Direction| self.terms.iter().all(|t| t.one_way == Some(Some(way)));
        match Direction::BOTH.into_iter().find(|way| only(*way)) {
            _ if names.is_empty() => None,
            Some(way) => Some(RestsOn::OneWay(way)),
            None if self.without_reversal_um.is_some() => Some(RestsOn::ReversalNotCounted),
            None if names.len() == self.terms.len() => Some(RestsOn::NoReversal(Vec::new())),
            None => Some(RestsOn::NoReversal(names)),
        }
    }

    /// The terms whose uncertainty counts as 0.
    fn without_u(&self) -> Option<RestsOn> {
        let without = self.terms.iter().filter(|t| t.change.u_um.is_none());
        let without: Vec<ErrorTerm> = without.map(|t| t.term).collect();
        let all = without.len() == self.terms.len();
        (!without.is_empty()).then(|| RestsOn::WithoutU(if all { Vec::new() } else { without }))
    }
}

/// Which errors a verdict speaks of.
pub(crate) fn terms_words(terms: &[ErrorTerm]) -> String {
    match terms {
        [] => "every term".to_string(),
        [one] => one.to_string(),
        few if few.len() <= FEW => format!("each of {}", joined(few)),
        all if all.len() == ErrorTerm::ALL.len() => "every term".to_string(),
        some => format!("each of the {} measured terms", some.len()),
    }
}

impl fmt::Display for Of {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Of::Term(term) => write!(out, "{term} leaves"),
            Of::Terms => out.write_str("all terms together leave"),
            Of::Diagonal(name) => write!(out, "diagonal {name} leaves"),
            Of::Diagonals => out.write_str("the diagonals together leave"),
        }
    }
}

impl fmt::Display for Miss {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Miss::Range(range) => out.write_str(&range.missing()),
            Miss::NotStated(cause) => {
                let (what, key, advice) = (words(*cause), cause.word(), advice(*cause));
                write!(out, "{what} not stated: state `{key}` ({advice}): undecided")
            }
            Miss::Figure { of, um, at_most_um, limit_um, verdict } => {
                let at_most = match at_most_um {
                    None => "U not stated".to_string(),
                    Some(um) => format!("at most {um:.3} µm with 95 %"),
                };
                let verdict = verdict.word();
                write!(out, "{of} {um:.3} µm, {at_most}, the limit is {limit_um} µm: {verdict}")
            }
        }
    }
}

impl fmt::Display for RestsOn {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RestsOn::Ranges(ranges) => out.write_str(&share::words(ranges)),
            RestsOn::Between { periodic_um, .. } if *periodic_um > 0.0 => {
                write!(out, "{periodic_um:.3} µm added for errors between targets (periodic_um)")
            }
            RestsOn::Between { ranges, .. } => {
                out.write_str("errors between targets were not seen")?;
                match JudgedRange::hidden_pitches(ranges, (1.0, "mm")).as_str() {
                    "" => Ok(()),
                    hidden => write!(out, "; target spacing is a multiple of pitch {hidden}"),
                }
            }
            RestsOn::OneWay(way) => write!(out, "moving {way} only"),
            RestsOn::ReversalNotCounted => out.write_str("reversal measured, but not counted"),
            RestsOn::NoReversal(terms) => write!(out, "reversal{} not measured", of(terms)),
            RestsOn::WithoutU(terms) => {
                write!(out, "U{} is not stated and counted as 0", of(terms))
            }
            RestsOn::Neglected(causes) => {
                let causes = joined(causes.iter().map(|cause| words(*cause)));
                write!(out, "{causes} neglected by decision")
            }
            RestsOn::Unused(keys) => write!(
                out,
                "not counted: {} concern readings; a table of errors has to hold them in its own uncertainties",
                keys.join(", ")
            ),
            RestsOn::NineNeeded => out.write_str(
                "body diagonals need all nine errors, none measured in one direction only",
            ),
        }
    }
}

/// ` of EXX, EYX`; nothing of all.
fn of(terms: &[ErrorTerm]) -> String {
    if terms.is_empty() { String::new() } else { format!(" of {}", joined(terms)) }
}

/// What a cause is.
fn words(cause: Cause) -> &'static str {
    match cause {
        Cause::Angles => "angles",
        Cause::SetUps => "change of scale between set-ups",
        Cause::Slopes => "uncertainty of a linear axis",
        Cause::Tilt => "tilt of the mirror",
        Cause::Squareness => "squareness",
    }
}

/// How it is stated, or what makes it unnecessary.
fn advice(cause: Cause) -> &'static str {
    match cause {
        Cause::Angles => "for a machining centre 5 to 20 µrad is usual; or measure them",
        Cause::SetUps => "0.2 K × 11.5 µm/m per K = 2.3 unless the scales are compensated",
        Cause::Slopes => "the laser's certificate, air and material over that axis",
        Cause::Tilt => "or solve for the set-up with linear axes",
        Cause::Squareness => "of each plane whose straightness has no slope that could hold it",
    }
}
