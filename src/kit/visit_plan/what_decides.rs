//! What keeps a limit from being decided, and the cheapest measurements that decide it, with what each would
//! come to: computed as `plan` computes it, for the noise that was found.

use super::compared::{MOST_RUNS, cheapest, fewest_runs, together};
use super::design::{Design, value_um};
use super::variant::{DIGITS, Share, Variant, Visit, listed};
use crate::inputs::job::Job;
use crate::judge::conformity::Verdict;
use crate::judge::forecast::Forecast;
use crate::machine::model::ErrorModel;
use crate::machine::separation::table::ErrorSource;
use crate::quantity::units::rounded;
use serde::Serialize;
use std::fmt;

/// Acts that are told.
const MOST: usize = 3;
/// Share of the visits that have to come to an answer before it is promised.
const SURE: f64 = 0.9;
/// So many standard deviations an estimated noise may be larger the next time: 90 %.
const ROOM: f64 = 1.28;

/// What decides.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WhatDecides {
    /// The error that is at most most.
    pub term: String,
    /// What is left of it, µm.
    pub left_um: f64,
    /// What the largest of all errors is at most, µm: the smallest limit that these data prove.
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
    /// Time that it takes at the machine, min; `None` = nothing is measured.
    pub minutes: Option<f64>,
    /// What the largest of all errors would be at most, µm.
    pub at_most_um: f64,
    /// `pass` where that can be counted on, `undecided` where it cannot.
    pub verdict: &'static str,
}

/// Figures to be decided: of a forecast, or of a machine as left.
#[derive(Clone, Copy)]
pub(crate) struct Judged<'a> {
    /// The job of the measurement behind them, with the limits.
    pub(crate) job: &'a Job,
    /// What it found.
    pub(crate) errors: &'a ErrorSource,
    pub(crate) figures: &'a Forecast,
    /// What was measured after loading, and what the points of the tables leave, µm.
    pub(crate) as_left: Option<(&'a ErrorModel, f64)>,
}

impl Judged<'_> {
    /// What decides; `None` where all is decided, where a statement is missing, and of errors that were not
    /// separated from readings.
    pub(crate) fn what_decides(&self) -> Option<WhatDecides> {
        let ErrorSource::Separated { separation, .. } = self.errors else { return None };
        let is_silent = !self.figures.silence.not_stated.is_empty();
        let verdict = self.figures.verdict(self.job.acceptance);
        if verdict == Verdict::Pass || is_silent || self.job.acceptance.max_deviation_um.is_none() {
            return None;
        }
        let design = Design::made(self.job, separation).ok()?;
        let described = design.visit(design.described().clone()).ok()?;
        let worst = self.figures.least_certain()?;
        let parts =
            design.parts(&described, self.figures, self.as_left.map(|(errors, _)| errors))?;
        let mut acts: Vec<Act> = self.new_tables(&described).into_iter().collect();
        if verdict == Verdict::Undecided {
            let additions = design.additions(&described, &parts);
            acts.extend(self.measurements(&design, &described, &additions));
        }
        acts.sort_by(|a, b| a.rank().total_cmp(&b.rank()));
        acts.truncate(MOST);
        Some(WhatDecides {
            term: worst.term.to_string(),
            left_um: rounded(worst.change.after_um, DIGITS),
            at_most_um: rounded(self.figures.all_at_most_um()?, DIGITS),
            parts: described.largest(parts),
            acts,
        })
    }

    /// What was measured after loading gives better tables.
    fn new_tables(&self, described: &Visit) -> Option<Act> {
        let at_most_um = self.as_left?.1 + described.at_most_um()?;
        let is_kept = at_most_um <= self.job.acceptance.max_deviation_um?;
        let verdict = if is_kept { Verdict::Pass } else { Verdict::Undecided };
        Some(Act::new("new tables from this measurement".into(), None, (at_most_um, verdict)))
    }

    /// More runs, linear axes, angles; where none of them decides, the cheapest of all together that does.
    fn measurements(
        &self,
        design: &Design<'_>,
        described: &Visit,
        additions: &[Variant],
    ) -> Vec<Act> {
        let own = &described.variant;
        let answer = |visit: &Visit| self.answer(described, visit);
        let decides = |visit: &Visit| answer(visit).is_some_and(|of| of.1 != Verdict::Undecided);
        let visit = |variant| design.visit(variant).ok();
        let runs = fewest_runs(design, own, decides).or_else(|| visit(own.in_runs(MOST_RUNS)));
        let mut visits: Vec<Visit> =
            additions.iter().cloned().filter_map(visit).chain(runs).collect();
        if !visits.iter().any(decides) {
            visits.extend(cheapest(design, &together(own, additions), decides));
        }
        visits.retain(|visit| visit.variant != *own);
        let act = |visit: &Visit| {
            let again = visit.variant.run.runs > own.run.runs;
            let minutes = visit.minutes - if again { 0.0 } else { described.minutes };
            Some(Act::new(visit.variant.change(own), Some(minutes.round()), answer(visit)?))
        };
        visits.iter().filter_map(act).collect()
    }

    /// What the largest of all errors is at most after a measurement, and the verdict that can be counted on.
    fn answer(&self, own: &Visit, visit: &Visit) -> Option<(f64, Verdict)> {
        let limit_um = self.job.acceptance.max_deviation_um?;
        let answer = |um, is_kept| (um, if is_kept { Verdict::Pass } else { Verdict::Undecided });
        if let Some((errors, _)) = self.as_left {
            let runs = [own, visit].map(|visit| f64::from(visit.variant.run.runs));
            let noise = (runs[1] > runs[0]).then(|| (runs[1] / runs[0]).sqrt());
            let (um, passes) =
                visit.expected.outlook(self.job, Some((&value_um(errors), noise)), limit_um)?;
            return Some(answer(um, passes >= SURE));
        }
        let u_um = self.figures.max_expanded_um()?;
        let left_um = self.figures.all_at_most_um()? - u_um;
        let u_um = u_um * visit.at_most_um()? / own.at_most_um()?;
        let freedom = visit.expected.noise.and_then(|noise| noise.freedom_f64());
        let room = freedom.map_or(0.0, |freedom| ROOM / (2.0 * freedom).sqrt());
        Some(answer(left_um + u_um, left_um + u_um * (1.0 + room) <= limit_um))
    }
}

impl Act {
    fn new(what: String, minutes: Option<f64>, (at_most_um, verdict): (f64, Verdict)) -> Act {
        Act { what, minutes, at_most_um: rounded(at_most_um, DIGITS), verdict: verdict.word() }
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
        for Act { what, minutes, at_most_um, verdict } in &self.acts {
            let minutes = minutes.map_or(String::new(), |minutes| format!(" ({minutes:.0} min)"));
            write!(out, "\n  {what}{minutes}: at most {at_most_um:.3} µm: {verdict}")?;
        }
        write!(out, "\n  the smallest limit that these data prove is {at_most_um:.3} µm")
    }
}
