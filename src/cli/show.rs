//! What several commands show of tables and machine: verdict, forecast, places in the control,
//! assumptions, preconditions.

use crate::cli::screen::{More, headed, table};
use crate::control::claims::{Assumption, Precondition, shared};
use crate::inputs::job::Job;
use crate::judge::conformity::Verdict;
use crate::judge::field::Field;
use crate::judge::forecast::{Change, Forecast, Grounds, terms_words};
use crate::kit::Inputs;
use crate::machine::model::{ErrorModel, MeasuredTerm};
use crate::machine::separation::table::ErrorSource;
use crate::page::{Curves, Locale, Picture, terms};
use crate::quantity::{Direction, ErrorTerm, Figure, Plane};
use crate::text::{Finding, NamedEntries, Severity, joined, of_severity};
use crate::write::compensation::Placement;
use serde::Serialize;
use std::fmt::Display;

/// The nine errors of a job as found, as forecast with the tables that are loaded, as left.
pub(super) fn nine_errors(
    locale: Locale<'_>,
    inputs: &Inputs,
    loaded: Option<&Field>,
    as_left: Option<&ErrorModel>,
) -> Picture {
    let curves = Curves { inputs, loaded, as_left };
    let (machine, control) = (&inputs.job.machine.name, &inputs.profile.name);
    terms(locale, &format!("{machine}: {}, {control}", locale.words("nine_errors")), &curves)
}

/// A figure, or the word that says why there is none.
pub(super) fn figure(um: Option<f64>, absent: &str) -> String {
    um.map_or_else(|| absent.to_string(), |um| format!("{:.3}", Figure(um)))
}

/// A figure in µm, `-` where there is none.
pub(super) fn um(um: Option<f64>) -> String {
    figure(um, "-")
}

/// `what`, then all of them; nothing without any.
pub(super) fn named(what: &str, all: impl Iterator<Item = String>) -> String {
    match joined(all) {
        none if none.is_empty() => none,
        all => format!("{what}: {all}"),
    }
}

const FORMED: &str = "; fit residual: what three straight pieces cannot follow";

/// Where each term went: points, count, what the grid leaves, and the form where it leaves something.
pub(super) fn placements(placements: &[Placement]) -> String {
    let formed = placements.iter().any(|p| p.fit_residual_um.is_some());
    let (column, legend) = if formed { ("\t>fit residual/µm", FORMED) } else { ("", "") };
    let rows = placements.iter().map(|p| {
        let direction = p.direction.map_or("+ and -", Direction::symbol);
        let count = Some(p.count_um).filter(|um| *um > 0.0);
        let count = count.map_or_else(|| "unrounded".to_string(), |um| Figure(um).trimmed(6));
        let row = format!(
            "{}\t{direction}\t{}\t{}\t{count}\t{:.3}",
            p.term, p.place, p.points, p.grid_residual_um
        );
        if formed { format!("{row}\t{}", um(p.fit_residual_um)) } else { row }
    });
    let heading = "term\tmoving\tplace in the control\t>points\t>count/µm\t>grid residual/µm";
    format!(
        "{}\n  count: smallest step of a table value; grid residual: largest difference of curve and table{legend}",
        table(&format!("{heading}{column}"), rows)
    )
}

/// Every measured term before and after, with the place of its table.
pub(super) fn forecast(forecast: &Forecast, placements: &[Placement]) -> String {
    let reversal = forecast.without_reversal_um.map_or_else(String::new, |um| {
        format!(", without reversal (about {um:.3} µm on the diagonals)")
    });
    let figures = |of: &Change| {
        let (before, after, at_most) = (of.before_um, of.after_um, stated(of.at_most_um));
        format!("{before:.3}\t{after:.3}\t{at_most}")
    };
    let terms = forecast.terms.iter().map(|t| {
        let place = places(placements, t.term, t.compensated);
        let without = if t.term.is_positioning() { reversal.as_str() } else { "" };
        format!("{}\t{}\t{place}{without}", t.term, figures(&t.change))
    });
    let is_kept = |term| placements.iter().any(|p| p.term == term);
    let missing = forecast.not_determined.iter().map(|term| {
        let place = places(placements, *term, is_kept(*term));
        format!("{term}\tnot determined\t-\t-\t{place}")
    });
    let diagonals = forecast.diagonals.iter().map(|d| {
        let figures = figures(&d.change);
        format!("diagonal {}\t{figures}\tmax - min{reversal}", d.diagonal)
    });
    let all = largest_of_all(forecast);
    let all = all.map(|(um, at_most)| format!("{OF_ALL}\t\t{um}\t{at_most}\t"));
    let heading = "term\t>before/µm\t>after/µm\t>at most/µm\ttable";
    table(heading, terms.chain(missing).chain(all).chain(diagonals)) + at_most(forecast)
}

/// Where the control holds a term.
fn places(placements: &[Placement], term: ErrorTerm, compensated: bool) -> String {
    let place = |p: &Placement| match p.direction {
        None => p.place.clone(),
        Some(direction) => format!("{} ({})", p.place, direction.symbol()),
    };
    let own = placements.iter().filter(|p| p.term == term);
    match joined(own.map(place)) {
        _ if !compensated => "none".to_string(),
        none if none.is_empty() => "yes".to_string(),
        own => own,
    }
}

/// The line that decides on a limit for errors.
pub(super) const OF_ALL: &str = "largest of all";

/// The largest of all terms, and what it is at most, where there are several and U is stated.
pub(super) fn largest_of_all(forecast: &Forecast) -> Option<(String, String)> {
    let is_stated = forecast.terms.iter().all(|term| term.change.at_most_um.is_some());
    let um = forecast.all_at_most_um().filter(|_| is_stated && forecast.terms.len() > 1)?;
    Some((format!("{:.3}", forecast.max_residual_um()), format!("{um:.3}")))
}

/// What *at most* means, where it is stated.
pub(super) fn at_most(forecast: &Forecast) -> &'static str {
    let is_stated = |change: &Change| change.at_most_um.is_some();
    let terms = forecast.terms.iter().map(|term| &term.change);
    let mut all = terms.chain(forecast.diagonals.iter().map(|d| &d.change));
    if all.any(is_stated) { "\n  at most: with 95 %; this is compared with the limit" } else { "" }
}

pub(super) fn stated(um: Option<f64>) -> String {
    figure(um, "not stated")
}

/// Slope of each cross term.
pub(super) fn slopes(model: &ErrorModel) -> String {
    let cross = model.measured().filter(|(term, _)| term.is_cross());
    let slopes = cross.map(|(term, measured)| {
        format!("{term} {:+.3}", Figure(measured.end_point_slope_um_per_m()))
    });
    named("slopes of the cross terms (end points), µm/m", slopes)
}

/// Squareness where both terms of a pair were measured, and reversal where both directions were.
pub(super) fn squareness_and_reversals(model: &ErrorModel) -> String {
    let squareness = Plane::ALL.into_iter().filter_map(|plane| {
        let (first, second) = plane.axes();
        let slope = Figure(model.squareness_um_per_m(first, second)?);
        Some(format!("{} {slope:+.3}", plane.key()))
    });
    let mut squareness = named("squareness, µm/m", squareness);
    if !squareness.is_empty() {
        squareness += " (positive: less than 90° between the positive axes)";
    }
    // Equal curves tell none: one is written for both directions where nothing tells them apart.
    let is_told = |(_, own): &(_, &MeasuredTerm)| own.curves().next() != own.curves().nth(1);
    let reversals = model.measured().filter(is_told).filter_map(|(term, measured)| {
        Some(format!("{term} {:+.3}", Figure(measured.reversal()?.um())))
    });
    let reversals = named("reversal B (mean moving + minus mean moving -), µm", reversals);
    [squareness, reversals].join("\n").trim().to_string()
}

/// Verdict with the limits it was judged by; below it stands what does not keep them.
pub(super) fn verdict(
    verdict: Verdict,
    job: &Job,
    grounds: &Grounds,
    differs: bool,
    doubts: &[Finding],
) -> String {
    let limits = limits(job, grounds);
    let word = verdict.word();
    let words = match (limits.is_empty(), verdict) {
        (true, Verdict::Pass) => {
            "no acceptance is stated in the job, so there is nothing to judge".to_string()
        }
        (true, _) => format!("{word} (asked: no acceptance is stated in the job)"),
        (false, _) => format!("{word} (asked: {limits})"),
    };
    let mut lines = vec![format!("verdict: {words}")];
    lines.extend(grounds.rests_on.iter().map(|part| format!("  {part}")));
    if differs {
        lines.push("  because the files differ from the job, or from their manifest".to_string());
    }
    lines.extend(grounds.misses.iter().map(|miss| format!("  {miss}")));
    lines.extend(doubts.iter().map(|doubt| format!("  INCONSISTENT: {doubt}")));
    lines.join("\n")
}

/// What was asked, and what the verdict rests on.
pub(super) fn scope(job: &Job, grounds: &Grounds) -> Vec<String> {
    let asked = limits(job, grounds);
    let asked = (!asked.is_empty()).then(|| format!("asked: {asked}"));
    asked.into_iter().chain(grounds.rests_on.iter().map(ToString::to_string)).collect()
}

/// The limits of the job; empty without any.
fn limits(job: &Job, grounds: &Grounds) -> String {
    let acceptance = job.acceptance;
    let deviation = acceptance.max_deviation_um;
    let deviation = deviation.map(|um| format!("{} within {um} µm", terms_words(&grounds.terms)));
    let diagonal = acceptance.max_diagonal_um;
    let diagonal = diagonal.map(|um| format!("max - min of every body diagonal within {um} µm"));
    joined(deviation.into_iter().chain(diagonal))
}

/// Assumed facts with their consequence; behind them those that cannot matter for this kit.
pub(super) fn assumptions(assumptions: &[Assumption]) -> More {
    let (matter, idle): (Vec<_>, Vec<_>) =
        assumptions.iter().partition(|a| a.without_effect.is_none());
    let count = matter.len();
    let matter = matter
        .iter()
        .map(|a| format!("  {} = {}\n      if wrong: {}", a.fact, a.value, a.consequence));
    let idle = idle
        .iter()
        .map(|a| format!("  {} = {}: {}", a.fact, a.value, a.without_effect.unwrap_or_default()));
    let all = [
        headed("assumed, not shown by any control yet:", matter),
        headed("assumed too, without effect on this kit:", idle),
    ];
    More::new(count, ["assumption", "assumptions"], all.join("\n").trim_matches('\n').to_string())
}

/// What a person has to see to, one sentence each; axes of which the same is asked share one.
pub(super) fn preconditions(preconditions: &[Precondition]) -> More {
    let shared = shared(preconditions);
    let lines = shared
        .iter()
        .map(|(what, p)| format!("  {what} must be {}:\n      {} [{}]", p.value, p.why, p.source));
    let text = headed("preconditions on the control, to be checked manually:", lines);
    More::new(shared.len(), ["precondition", "preconditions"], text)
}

/// The signs that are only assumed, in one line, with what proves them.
pub(super) fn assumed_signs(assumptions: &[Assumption], proofs: &[&str]) -> Vec<String> {
    let signs = assumptions.iter().filter(|a| a.is_sign());
    let signs = joined(signs.map(|a| format!("{} = {}", a.fact, a.value)));
    let proof = match proofs {
        [] => "prove it with one small bump before use".to_string(),
        files => format!("prove it first: {} (checklist)", files.join(", ")),
    };
    let line = format!("SIGN ASSUMED, not seen on a control: {signs}; {proof}");
    (!signs.is_empty()).then_some(line).into_iter().collect()
}

/// What is assumed and has to be decided before anything is loaded, a line each.
pub(super) fn to_decide(assumptions: &[Assumption]) -> impl Iterator<Item = String> {
    let open = assumptions.iter().filter(|own| own.to_decide);
    open.map(|own| format!("DECIDE BEFORE LOADING, assumed: {}", own.words()))
}

/// What whoever measured is asked, a line each.
pub(super) fn questions(notes: &[Finding]) -> impl Iterator<Item = String> {
    of_severity(notes, Severity::Question).into_iter().map(|note| format!("LOOK: {note}"))
}

/// Notes as findings.
pub(super) fn notes(notes: impl IntoIterator<Item = impl Display>) -> Vec<String> {
    notes.into_iter().map(|note| format!("note: {note}")).collect()
}

/// What documents say of a plane.
#[derive(Serialize)]
pub(super) struct PlaneFigures {
    pub(super) before_um_per_m: f64,
    /// Only where there are tables.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) after_um_per_m: Option<Option<f64>>,
    /// U of the last of them.
    pub(super) expanded_um_per_m: Option<f64>,
}

/// A machine as it was measured, and what it was measured with where that is known.
pub(super) type ErrorsWithSource<'a> = (&'a ErrorModel, Option<&'a ErrorSource>);

/// Of each plane that is known as found: then and, where there are tables, as left, as far as that was measured.
pub(super) fn planes(
    found: ErrorsWithSource<'_>,
    left: Option<Option<ErrorsWithSource<'_>>>,
) -> NamedEntries<&'static str, PlaneFigures> {
    let planes = Plane::ALL.into_iter().filter_map(|plane| {
        let before = squareness(found, plane)?;
        let after = left.flatten().and_then(|left| squareness(left, plane));
        let figures = PlaneFigures {
            before_um_per_m: before.0,
            after_um_per_m: left.map(|_| after.map(|(um_per_m, _)| um_per_m)),
            expanded_um_per_m: after.unwrap_or(before).1,
        };
        Some((plane.key(), figures))
    });
    planes.collect()
}

/// Squareness of a plane with U (95 %; `None` = not stated), µm/m: of readings what their totals say, else the sum of
/// the slopes of both terms; `None` = not determined, or not both measured.
///
/// limits  an error table states no uncertainty of a slope
fn squareness((model, errors): ErrorsWithSource<'_>, plane: Plane) -> Option<(f64, Option<f64>)> {
    if let Some(ErrorSource::Separated { separation, .. }) = errors {
        let found = separation.metric.squareness(plane);
        return Some((found.um_per_m?, found.expanded_um_per_m()));
    }
    let (first, second) = plane.axes();
    Some((model.squareness_um_per_m(first, second)?, None))
}
