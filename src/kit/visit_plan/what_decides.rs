//! What keeps a limit from being decided, and the cheapest measurements that decide it, with what each would
//! come to: computed as `plan` computes it, for the noise that was found.

use super::compared::{MOST_RUNS, cheapest, fewest_runs, together};
use super::design::{Design, value_um};
use super::variant::{DIGITS, Share, Variant, Visit, listed};
use crate::inputs::job::{Job, MeasuredData};
use crate::judge::conformity::{Magnitude, Verdict, expanded_um};
use crate::judge::forecast::{Forecast, Missed};
use crate::machine::model::ErrorModel;
use crate::machine::separation::table::ErrorSource;
use crate::machine::separation::{Part, Separation};
use crate::quantity::axis::{Axis, ErrorTerm, Rotation};
use crate::quantity::units::{Squared, rounded};
use serde::Serialize;
use std::fmt;

/// Acts that are told.
const MOST: usize = 3;
/// Share of the visits that have to come to an answer before it is promised.
const SURE: f64 = 0.9;
/// So many standard deviations an estimated noise may be larger the next time: 90 %.
const ROOM: f64 = 1.28;

/// What a second measurement can always be used for.
const NEW_TABLES: &str = "new tables from this measurement";

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
    /// Time that it takes at the machine, min; `None` = nothing is measured, or not known.
    pub minutes: Option<f64>,
    /// What the largest of all errors, or of all diagonals, would be at most, µm.
    pub at_most_um: f64,
    /// `pass` where that can be counted on, `undecided` where it cannot.
    pub verdict: &'static str,
    /// What is measured for it.
    #[serde(skip)]
    pub measured: Measured,
}

/// What is measured in addition, or again, and whether new tables are made from it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// These axes along their length.
    pub linear: Vec<Axis>,
    /// These angles.
    pub angles: Vec<Rotation>,
    /// All once more, in so many runs.
    pub runs: Option<u32>,
    /// From all that is then there.
    pub new_tables: bool,
}

/// Figures to be decided: of a forecast, or of a machine as left.
#[derive(Clone, Copy)]
pub(crate) struct Judged<'a> {
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

impl Judged<'_> {
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
        let described = design.visit(design.described().clone()).ok()?;
        let as_left = self.expected.map(|_| self.model);
        let parts = design.parts(&described, missed, as_left);
        let additions = design.additions(&described, &parts);
        let mut acts: Vec<Act> =
            self.new_tables(&described, &described, missed).into_iter().collect();
        if missed.verdict == Verdict::Undecided {
            acts.extend(self.measurements(&design, &described, &additions, missed));
        }
        let passes = |act: &Act| act.verdict == Verdict::Pass.word();
        if self.expected.is_some() && !acts.iter().any(passes) {
            let new_tables = |visit: &Visit| self.new_tables(&described, visit, missed);
            let all = together(&described.variant, &additions);
            let best =
                cheapest(&design, &all, |visit| new_tables(visit).as_ref().is_some_and(passes));
            acts.extend(best.as_ref().and_then(new_tables));
        }
        Some((described.largest(parts), acts))
    }

    /// Of an error table the noise that the job states becomes less in the mean of more runs; nothing else is known.
    fn of_table(&self, missed: &Missed) -> Option<(Vec<Share>, Vec<Act>)> {
        let term = ErrorTerm::from_name(&missed.name)?;
        let points = self.model.terms[term].as_ref()?.uncertainty.iter();
        let point = points.max_by(|a, b| a.u_um.total_cmp(&b.u_um)).filter(|p| p.u_um > 0.0)?;
        let from_zero = (point.at - self.job.machine.axes[term.along]?.reference).mm();
        let um_per_m = if term.is_positioning() { self.model.laser_um_per_m } else { 0.0 };
        let laser = (um_per_m * from_zero / 1000.0).squared();
        let is_table = matches!(self.job.measurement.data, MeasuredData::Errors(_));
        let noise_um = self.job.measurement.uncertainty.noise_um.filter(|_| is_table);
        let noise = 2.0 * noise_um.unwrap_or(0.0).squared();
        let stated = (point.u_um.squared() - noise - laser).max(0.0);
        let parts = vec![(Part::Noise, noise), (Part::Laser, laser), (Part::Stated, stated)];
        let parts = missed.shares(parts).into_iter();
        let share = |(part, um)| Share::new(part, None, um);
        let zero = self.figures.terms.iter().flat_map(|term| &term.figures);
        let zero: Vec<Magnitude> = zero.map(|of| Magnitude { um: 0.0, ..*of }).collect();
        let remade = self.remade(missed, expanded_um(&zero, self.figures.sigma));
        let new_tables = Measured { new_tables: true, ..Measured::default() };
        let acts = remade.map(|of| Act::new(NEW_TABLES.to_string(), None, of, new_tables));
        let runs = |runs: u32| {
            let less = noise * (1.0 - 1.0 / f64::from(runs)) / point.u_um.squared();
            let measured = Measured { runs: Some(runs), ..Measured::default() };
            let answer = self.scaled(missed, (1.0 - less).sqrt(), 0.0);
            Act::new(format!("mean of {runs} runs"), None, answer, measured)
        };
        let is_useful = missed.verdict == Verdict::Undecided && noise > 0.0;
        let mut all = (2..=MOST_RUNS).filter(|_| is_useful).map(runs);
        let least = all.clone().find(|act| act.verdict == Verdict::Pass.word());
        Some((
            parts.map(share).collect(),
            acts.into_iter().chain(least.or_else(|| all.next_back())).collect(),
        ))
    }

    /// Better tables from what was measured after loading, with what is doubtful of it, or is measured like this in its
    /// place.
    fn new_tables(&self, own: &Visit, visit: &Visit, missed: &Missed) -> Option<Act> {
        let is_again = visit.variant.run.runs > own.variant.run.runs;
        let doubtful_um = if is_again { 0.0 } else { missed.doubtful_of(self.figures) };
        let off_um = missed.of(&visit.forecast)? + doubtful_um;
        Some(self.act(own, visit, self.remade(missed, off_um)?, true))
    }

    /// What new tables are at most, that are so much off their points.
    fn remade(&self, missed: &Missed, off_um: f64) -> Option<(f64, Verdict)> {
        let at_most_um = off_um + missed.left_of(self.expected?);
        let is_kept = at_most_um <= missed.limit_um;
        Some((at_most_um, if is_kept { Verdict::Pass } else { Verdict::Undecided }))
    }

    fn act(&self, own: &Visit, visit: &Visit, answer: (f64, Verdict), new_tables: bool) -> Act {
        let variant = &visit.variant;
        let runs = Some(variant.run.runs).filter(|runs| *runs > own.variant.run.runs);
        let minutes = visit.minutes - runs.map_or(own.minutes, |_| 0.0);
        let (linear, angles) = (variant.linear.clone(), variant.angles.clone());
        let measured = Measured { linear, angles, runs, new_tables };
        let change = (*variant != own.variant).then(|| variant.change(&own.variant));
        let minutes = change.as_ref().map(|_| minutes.round());
        let what = match (change, new_tables) {
            (Some(change), false) => change,
            (Some(change), true) => format!("{change}, then new tables"),
            (None, _) => NEW_TABLES.to_string(),
        };
        Act::new(what, minutes, answer, measured)
    }

    /// More runs, linear axes, angles; where none of them decides, the cheapest of all together that does.
    fn measurements(
        &self,
        design: &Design<'_>,
        described: &Visit,
        additions: &[Variant],
        missed: &Missed,
    ) -> Vec<Act> {
        let own = &described.variant;
        let answer = |visit: &Visit| self.answer(described, visit, missed);
        let decides = |visit: &Visit| answer(visit).is_some_and(|of| of.1 != Verdict::Undecided);
        let visit = |variant| design.visit(variant).ok();
        let runs = fewest_runs(design, own, decides).or_else(|| visit(own.in_runs(MOST_RUNS)));
        let mut visits: Vec<Visit> =
            additions.iter().cloned().filter_map(visit).chain(runs).collect();
        if !visits.iter().any(decides) {
            visits.extend(cheapest(design, &together(own, additions), decides));
        }
        visits.retain(|visit| visit.variant != *own);
        let act = |visit: &Visit| Some(self.act(described, visit, answer(visit)?, false));
        visits.iter().filter_map(act).collect()
    }

    /// What the largest is at most after a measurement, and the verdict that can be counted on.
    fn answer(&self, own: &Visit, visit: &Visit, missed: &Missed) -> Option<(f64, Verdict)> {
        if self.expected.is_some() && missed.diagonal.is_none() {
            let runs = [own, visit].map(|visit| f64::from(visit.variant.run.runs));
            let noise = (runs[1] > runs[0]).then(|| (runs[1] / runs[0]).sqrt());
            let found = value_um(self.model);
            let (um, passes) =
                visit.expected.outlook(self.job, Some((&found, noise)), missed.limit_um)?;
            let is_sure = passes >= SURE;
            return Some((um, if is_sure { Verdict::Pass } else { Verdict::Undecided }));
        }
        let freedom = visit.expected.noise.and_then(|noise| noise.freedom_f64());
        let room = freedom.map_or(0.0, |freedom| ROOM / (2.0 * freedom).sqrt());
        Some(self.scaled(missed, missed.of(&visit.forecast)? / missed.of(&own.forecast)?, room))
    }

    /// The same with so many times the uncertainty; what was measured as left will be another draw of it.
    fn scaled(&self, missed: &Missed, times: f64, room: f64) -> (f64, Verdict) {
        let u_um = times * missed.u_um;
        let room_um = match self.expected {
            None => room * u_um,
            Some(_) => ROOM / self.figures.sigma.one_sided() * missed.u_um.hypot(u_um),
        };
        let at_most_um = missed.at_most_um - missed.u_um + u_um;
        let is_kept = at_most_um + room_um <= missed.limit_um;
        (at_most_um, if is_kept { Verdict::Pass } else { Verdict::Undecided })
    }
}

impl Act {
    fn new(
        what: String,
        minutes: Option<f64>,
        (at_most_um, verdict): (f64, Verdict),
        measured: Measured,
    ) -> Act {
        let (at_most_um, verdict) = (rounded(at_most_um, DIGITS), verdict.word());
        Act { what, minutes, at_most_um, verdict, measured }
    }

    /// What passes by its time, then what is at most least.
    fn rank(&self) -> f64 {
        let passes = self.verdict == Verdict::Pass.word();
        if passes { self.minutes.unwrap_or(0.0) } else { 1e6 + self.at_most_um }
    }
}

impl fmt::Display for WhatDecides {
    /// A line for what decides, one for each act, one for what is proved.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let WhatDecides { term, left_um, at_most_um, .. } = self;
        write!(
            out,
            "what decides: {term}, {left_um:.3} µm left; beside it {}",
            listed(&self.parts)
        )?;
        for Act { what, minutes, at_most_um, verdict, .. } in &self.acts {
            let minutes = minutes.map_or(String::new(), |minutes| format!(" ({minutes:.0} min)"));
            write!(out, "\n  {what}{minutes}: at most {at_most_um:.3} µm: {verdict}")?;
        }
        write!(out, "\n  the smallest limit that these data prove is {at_most_um:.3} µm")
    }
}
