//! What keeps a limit from being decided, and the cheapest measurements that decide it, with what each would
//! come to: computed as `plan` computes it, for the noise that was found.

use super::design::Design;
use super::variant::{DIGITS, Share, Visit, listed, value_um};
use super::{MOST_RUNS, together};
use crate::inputs::job::Job;
use crate::judge::conformity::Verdict;
use crate::judge::forecast::{Forecast, Missed};
use crate::machine::model::ErrorModel;
use crate::machine::separation::joint::{AfterLoading, Outlook, Values};
use crate::machine::separation::table::ErrorSource;
use crate::machine::separation::{Part, Separation};
use crate::quantity::{Axis, ErrorTerm, Rotation, Squared, rounded};
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};
use std::f64::consts::SQRT_2;
use std::fmt;

/// Acts that are told.
const MOST: usize = 3;
/// Share of the visits that have to come to an answer before it is promised.
const SURE: f64 = 0.9;
/// Degrees of freedom of what is known.
const MANY: f64 = 1e6;
/// So many standard deviations another draw may be larger: 90 %.
const ROOM: f64 = 1.28;

/// What decides.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WhatDecides {
    /// The error, or the diagonal, that is at most most.
    pub term: String,
    /// What is left of it, µm.
    pub left_um: f64,
    /// What the largest of all errors, or of all diagonals, is at most, µm: the smallest limit that these data prove.
    pub at_most_um: f64,
    /// The largest parts of what is between them, µm; they add as squares.
    pub parts: Vec<Share>,
    /// The cheapest acts.
    pub acts: Vec<Act>,
}

/// Something to measure, or to make.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Act {
    /// What to do.
    pub what: String,
    /// Time that it takes at the machine, min; `None` = not known.
    pub minutes: Option<f64>,
    /// What the largest of all errors, or of all diagonals, would be at most, µm.
    pub at_most_um: f64,
    /// `pass` where that can be counted on, `undecided` where it cannot.
    pub verdict: Verdict,
    /// What is measured for it.
    #[serde(skip)]
    pub measured: Remeasurement,
}

/// What is measured in addition, or again, and whether new tables are made from it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Remeasurement {
    /// These axes along their length.
    pub linear: Vec<Axis>,
    /// These angles.
    pub angles: Vec<Rotation>,
    /// All once more, in so many runs.
    pub runs: Option<u32>,
    /// From all that is then there; they are loaded and measured likewise.
    pub new_tables: bool,
}

/// Figures to be decided: of a forecast, or of a machine as left.
#[derive(Clone, Copy)]
pub(crate) struct OpenFigures<'a> {
    /// The job of the measurement behind them, with the limits.
    pub(crate) job: &'a Job,
    /// What it found; `None` = a table without a job.
    pub(crate) errors: Option<&'a ErrorSource>,
    /// The same as curves.
    pub(crate) model: &'a ErrorModel,
    pub(crate) figures: &'a Forecast,
    /// Of a machine as left: what was forecast of its tables.
    pub(crate) expected: Option<&'a Forecast>,
}

impl OpenFigures<'_> {
    /// What decides; `None` where all is decided, where a statement is missing, and where nothing can be computed.
    pub(crate) fn what_decides(&self) -> Option<WhatDecides> {
        let missed = self.figures.missed(self.job.acceptance)?;
        if missed.diagonal.is_none() && !self.figures.silence.not_stated.is_empty() {
            return None;
        }
        let (parts, mut acts) = match self.errors {
            Some(ErrorSource::Separated { separation, .. }) => {
                self.of_readings(separation, &missed)?
            }
            Some(ErrorSource::Table(_)) | None => self.of_table(&missed)?,
        };
        acts.sort_by(|a, b| a.rank().total_cmp(&b.rank()));
        acts.truncate(MOST);
        Some(WhatDecides {
            left_um: rounded(missed.change.after_um, DIGITS),
            at_most_um: rounded(missed.at_most_um, DIGITS),
            term: missed.name,
            parts,
            acts,
        })
    }

    fn of_readings(&self, found: &Separation, missed: &Missed) -> Option<(Vec<Share>, Vec<Act>)> {
        let design = Design::made(self.job, found).ok()?;
        let described = design.visit(design.described.clone()).ok()?;
        let value = self.expected.map(|_| value_um(self.model));
        let value = value.as_ref().map(|value| value as Values<'_>);
        let parts = missed.shares(match (missed.diagonal, ErrorTerm::from_name(&missed.name)) {
            (Some(diagonal), _) => described.expected.parts_along(diagonal),
            (None, Some(term)) => described.expected.parts(self.job, term, value),
            (None, None) => Vec::new(),
        });
        let additions = design.additions(&described, &parts);
        let all = together(&described.variant, &additions);
        let act = |visit: &Visit, remade: bool| self.act(&described, visit, missed, remade);
        let decides = |visit: &Visit, remade: bool| act(visit, remade).is_some_and(|a| a.passes());
        let cheapest = |remade: bool| {
            let found = design.cheapest(&all, |visit| decides(visit, remade))?;
            act(&found, remade)
        };
        let mut acts = Vec::new();
        if missed.verdict == Verdict::Undecided {
            let visit = |variant| design.visit(variant).ok();
            let (own, most) = (&described.variant, described.variant.in_runs(MOST_RUNS));
            let runs = design.in_fewest_runs(own, |visit| decides(visit, false));
            let added = additions.iter().cloned().filter_map(visit);
            let visits = added.chain(runs.or_else(|| visit(most)));
            acts.extend(visits.filter_map(|visit| act(&visit, false)));
            if !acts.iter().any(Act::passes) {
                acts.extend(cheapest(false));
            }
        }
        acts.extend(act(&described, true));
        if self.expected.is_some() && !acts.iter().any(Act::passes) {
            acts.extend(cheapest(true));
        }
        Some((described.most(parts), acts))
    }

    /// Of an error table the noise that the job states becomes less in the mean of more runs; nothing else is known.
    fn of_table(&self, missed: &Missed) -> Option<(Vec<Share>, Vec<Act>)> {
        let term = ErrorTerm::from_name(&missed.name)?;
        let points = self.model.terms[term].as_ref()?.uncertainty.iter();
        let point = points.max_by(|a, b| a.u_um.total_cmp(&b.u_um)).filter(|p| p.u_um > 0.0)?;
        let from_zero = (point.at - self.job.machine.axes[term.along]?.reference).mm();
        let um_per_m = if term.is_positioning() { self.model.laser_um_per_m } else { 0.0 };
        let laser = (um_per_m * from_zero / 1000.0).squared();
        let measurement = &self.job.measurement;
        let noise_um =
            measurement.uncertainty.noise_um.filter(|_| measurement.diagonals().is_none());
        let noise = 2.0 * noise_um.unwrap_or(0.0).squared();
        let stated = (point.u_um.squared() - noise - laser).max(0.0);
        let parts = vec![(Part::Noise, noise), (Part::Laser, laser), (Part::Stated, stated)];
        let parts = missed.shares(parts).into_iter();
        let share = |(part, um)| Share::new(part, None, um);
        let left_um = self.expected.map(|expected| missed.left_of(expected));
        // In half of the visits, and in those that have to be counted on: |e − e′| + k u of the worst.
        let (sigma, terms) = (&self.figures.sigma, self.figures.terms.iter());
        let count = terms.map(|term| term.figures.len()).sum();
        let factor = |share| SQRT_2 * sigma.joint_at(count, share) + sigma.one_sided();
        let off_um = [0.5, SURE].map(|share| factor(share) * point.u_um);
        let act = |runs: u32, new_tables: bool| {
            let less = noise * (1.0 - 1.0 / f64::from(runs)) / point.u_um.squared();
            let times = (1.0 - less).sqrt();
            let answer = if new_tables {
                let [at_most_um, sure_um] = off_um.map(|um| Some(left_um? + times * um));
                (at_most_um?, sure_um? <= missed.limit_um)
            } else {
                self.scaled(missed, times, 0.0)
            };
            let mean = (runs > 1).then(|| format!("mean of {runs} runs"));
            let runs = Some(runs).filter(|runs| *runs > 1);
            let measured = Remeasurement { runs, new_tables, ..Remeasurement::default() };
            Some(Act::new(mean, measured, answer))
        };
        let most = if noise > 0.0 { MOST_RUNS } else { 1 };
        let first = if missed.verdict == Verdict::Undecided { 2 } else { most + 1 };
        let fewest = [(1, true), (first, false)].map(|(first, new_tables)| {
            let mut acts = (first..=most).filter_map(|runs| act(runs, new_tables));
            acts.clone().find(Act::passes).or_else(|| acts.next_back())
        });
        Some((parts.map(share).collect(), fewest.into_iter().flatten().collect()))
    }

    /// What is measured in a visit, and made of it; `None` where it is nothing, or nothing can be said.
    fn act(&self, own: &Visit, visit: &Visit, missed: &Missed, new_tables: bool) -> Option<Act> {
        let variant = &visit.variant;
        let runs = Some(variant.run.runs).filter(|runs| *runs > own.variant.run.runs);
        let change = (*variant != own.variant).then(|| variant.change(&own.variant));
        let (again, answer) = match (new_tables, &change) {
            (true, _) => (visit.minutes, self.remade(visit, missed, runs.is_some())?),
            (false, Some(_)) => (0.0, self.answer(own, visit, missed)?),
            (false, None) => return None,
        };
        let minutes = again + visit.minutes - runs.map_or(own.minutes, |_| 0.0);
        let (linear, angles) = (variant.linear.clone(), variant.angles.clone());
        let measured = Remeasurement { linear, angles, runs, new_tables };
        let minutes = Some(minutes.round());
        Some(Act { minutes, ..Act::new(change, measured, answer) })
    }

    /// Better tables from what was measured after loading, with what is doubtful of it, or is measured like this in its
    /// place; they are measured likewise.
    fn remade(&self, visit: &Visit, missed: &Missed, is_again: bool) -> Option<(f64, bool)> {
        let between = self.job.measurement.uncertainty.between();
        let between_um = missed.diagonal.map_or(between.all_um(), |_| between.ranges_um());
        let doubtful_um = if is_again { between_um } else { missed.doubtful_of(self.figures) };
        let left_um = doubtful_um + missed.left_of(self.expected?);
        let room_um = missed.limit_um - left_um;
        let (um, is_sure) = match missed.diagonal {
            Some(_) => {
                let um = visit.diagonals_at_most_um? - between_um; // counted already
                (um, um <= room_um)
            }
            None => sure(visit.expected.outlook(self.job, None, room_um)?),
        };
        Some((left_um + um, is_sure))
    }

    /// What the largest is at most after a measurement, and whether a pass can be counted on.
    fn answer(&self, own: &Visit, visit: &Visit, missed: &Missed) -> Option<(f64, bool)> {
        if self.expected.is_some() && missed.diagonal.is_none() {
            let again = f64::from(visit.variant.run.runs > own.variant.run.runs);
            let found: AfterLoading = (&value_um(self.model), &own.expected, again);
            return visit.expected.outlook(self.job, Some(found), missed.limit_um).map(sure);
        }
        // The noise was estimated, and is estimated anew.
        let [next, found] =
            [visit, own].map(|of| of.expected.noise.and_then(|of| of.freedom_f64()));
        let ratio = FisherSnedecor::new(next.unwrap_or(MANY), found.unwrap_or(MANY)).ok()?;
        let share = visit.expected.share_of_noise(self.job, visit.worst?);
        let room = (1.0 + share * (ratio.inverse_cdf(SURE) - 1.0)).sqrt() - 1.0;
        let at_most_um = |of: &Visit| match missed.diagonal {
            Some(_) => of.diagonals_at_most_um,
            None => of.at_most_um,
        };
        Some(self.scaled(missed, at_most_um(visit)? / at_most_um(own)?, room))
    }

    /// The same with so many times the uncertainty; what was measured as left will be another draw of it.
    fn scaled(&self, missed: &Missed, times: f64, room: f64) -> (f64, bool) {
        let u_um = times * missed.u_um;
        let room_um = match self.expected {
            None => room * u_um,
            Some(_) => ROOM / self.figures.sigma.one_sided() * missed.u_um.hypot(u_um),
        };
        let at_most_um = missed.at_most_um - missed.u_um + u_um;
        (at_most_um, at_most_um + room_um <= missed.limit_um)
    }
}

/// What it is at most in half of the visits, and whether a pass can be counted on.
fn sure((at_most_um, passes): Outlook) -> (f64, bool) {
    (at_most_um, passes >= SURE)
}

impl Act {
    fn new(change: Option<String>, measured: Remeasurement, of: (f64, bool)) -> Act {
        let what = match (change, measured.new_tables) {
            (Some(change), true) => format!("{change}, then new tables, measured again"),
            (Some(change), false) => change,
            (None, _) => "new tables from this measurement, measured again".to_string(),
        };
        let verdict = if of.1 { Verdict::Pass } else { Verdict::Undecided };
        Act { what, minutes: None, at_most_um: rounded(of.0, DIGITS), verdict, measured }
    }

    fn passes(&self) -> bool {
        self.verdict == Verdict::Pass
    }

    /// What passes by its time, then what is at most least.
    fn rank(&self) -> f64 {
        if self.passes() { self.minutes.unwrap_or(0.0) } else { 1e6 + self.at_most_um }
    }
}

impl fmt::Display for WhatDecides {
    /// A line for what decides, one for each act, one for what is proved.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let WhatDecides { term, left_um, at_most_um, .. } = self;
        let parts = listed(&self.parts);
        write!(out, "what decides: {term}, {left_um:.3} µm left; beside it {parts}")?;
        for Act { what, minutes, at_most_um, verdict, .. } in &self.acts {
            let minutes = minutes.map_or(String::new(), |minutes| format!(" ({minutes:.0} min)"));
            let verdict = verdict.word();
            write!(out, "\n  {what}{minutes}: at most {at_most_um:.3} µm: {verdict}")?;
        }
        write!(out, "\n  the smallest limit that these data prove is {at_most_um:.3} µm")
    }
}
