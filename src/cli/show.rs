//! Tables and lines for people.

use crate::control::claims::{Assumption, Precondition, shared};
use crate::inputs::job::Job;
use crate::judge::conformity::Verdict;
use crate::judge::forecast::Forecast;
use crate::machine::model::ErrorModel;
use crate::quantity::axis::{Axis, Direction, ErrorTerm};
use crate::quantity::units::Figure;
use crate::write::compensation::Placement;
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};

/// A column with its heading.
pub(super) enum Column {
    /// Text.
    Left(&'static str),
    /// Numbers.
    Right(&'static str),
}

/// An aligned table without lines.
pub(super) fn table(columns: &[Column], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let mut table = Table::new();
    table
        .load_preset(presets::NOTHING)
        .set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(columns.iter().map(|column| match column {
        Column::Left(name) | Column::Right(name) => *name,
    }));
    for row in rows {
        table.add_row(row);
    }
    for (index, column) in columns.iter().enumerate() {
        if let Some(shown) = table.column_mut(index) {
            shown.set_padding((0, 2));
            if matches!(column, Column::Right(_)) {
                shown.set_cell_alignment(CellAlignment::Right);
            }
        }
    }
    let lines: Vec<String> = table
        .lines()
        .map(|line| line.trim_end().to_string())
        .collect();
    lines.join("\n")
}

/// Where each term went: points, count, what the grid leaves, and the form where it leaves something.
pub(super) fn placements(placements: &[Placement]) -> String {
    let formed = placements.iter().any(|p| p.fit_residual_um.is_some());
    let mut columns = vec![
        Column::Left("term"),
        Column::Left("moving"),
        Column::Left("place in the control"),
        Column::Right("points"),
        Column::Right("count/µm"),
        Column::Right("grid leaves/µm"),
    ];
    let mut legend = vec![
        "count: smallest step of a table value; grid leaves: largest difference of curve and table"
            .to_string(),
    ];
    if formed {
        columns.push(Column::Right("form leaves/µm"));
        legend.push("form leaves: what three straight pieces cannot follow".to_string());
    }
    let rows = placements.iter().map(|p| {
        let mut row = vec![
            p.term.to_string(),
            p.direction.map_or("+ and -", Direction::symbol).to_string(),
            p.place.clone(),
            p.points.to_string(),
            if p.count_um > 0.0 {
                short(p.count_um)
            } else {
                "unrounded".to_string()
            },
            format!("{:.3}", p.grid_residual_um),
        ];
        if formed {
            let fit = p.fit_residual_um;
            row.push(fit.map_or_else(|| "-".to_string(), |um| format!("{um:.3}")));
        }
        row
    });
    format!("{}\n  {}", table(&columns, rows), legend.join("; "))
}

fn short(number: f64) -> String {
    let text = format!("{:.6}", Figure(number));
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

/// Every measured term before and after, with the place of its table.
pub(super) fn forecast(forecast: &Forecast, placements: &[Placement]) -> String {
    let columns = [
        Column::Left("term"),
        Column::Right("before/µm"),
        Column::Right("after/µm"),
        Column::Right("U(95 %)/µm"),
        Column::Left("table"),
    ];
    let reversal = forecast.without_reversal_um.map_or_else(String::new, |um| {
        format!(", without reversal (about {um:.3} µm on the diagonals)")
    });
    let terms = forecast.terms.iter().map(|t| {
        vec![
            t.term.to_string(),
            format!("{:.3}", t.before_um),
            format!("{:.3}", t.after_um),
            expanded(t.expanded_um),
            format!(
                "{}{}",
                places(placements, t.term, t.compensated),
                if t.term.is_positioning() {
                    reversal.as_str()
                } else {
                    ""
                }
            ),
        ]
    });
    let missing = forecast.not_determined.iter().map(|term| {
        let dash = || "-".to_string();
        vec![
            term.to_string(),
            "not determined".to_string(),
            dash(),
            dash(),
            "none".to_string(),
        ]
    });
    let diagonals = forecast.diagonals.iter().map(|d| {
        vec![
            format!("diagonal {}", d.name),
            format!("{:.3}", d.before_um),
            format!("{:.3}", d.after_um),
            expanded(d.expanded_um),
            format!("max - min{reversal}"),
        ]
    });
    let rows = table(&columns, terms.chain(missing).chain(diagonals));
    let all = together(forecast).map(|line| format!("\n{line}"));
    rows + &all.unwrap_or_default()
}

/// Where the control holds a term.
fn places(placements: &[Placement], term: ErrorTerm, compensated: bool) -> String {
    let place = |p: &Placement| match p.direction {
        None => p.place.clone(),
        Some(direction) => format!("{} ({})", p.place, direction.symbol()),
    };
    let own = placements.iter().filter(|p| p.term == term);
    let own: Vec<String> = own.map(place).collect();
    match (compensated, own.is_empty()) {
        (false, _) => "none".to_string(),
        (true, true) => "yes".to_string(),
        (true, false) => own.join(", "),
    }
}

/// The largest of all terms with the U that holds for all of them together.
pub(super) fn together(forecast: &Forecast) -> Option<String> {
    let expanded = forecast.max_expanded_um()?;
    Some(format!(
        "  U: with 95 % the largest value of the line exceeds its figure by no more; of all terms {:.3} µm, U = {expanded:.3} µm",
        forecast.max_residual_um()
    ))
}

pub(super) fn expanded(expanded_um: Option<f64>) -> String {
    expanded_um.map_or_else(|| "not stated".to_string(), |um| format!("{um:.3}"))
}

/// Slope of each cross term.
pub(super) fn slopes(model: &ErrorModel) -> String {
    let slopes: Vec<String> = model
        .measured()
        .filter(|(term, _)| term.is_cross())
        .map(|(term, measured)| {
            format!("{term} {:+.3}", Figure(measured.end_point_slope_um_per_m()))
        })
        .collect();
    match slopes.is_empty() {
        true => String::new(),
        false => format!(
            "slopes of the cross terms (end points), µm/m: {}",
            slopes.join(", ")
        ),
    }
}

/// Squareness where both terms of a pair were measured.
pub(super) fn squareness(model: &ErrorModel) -> String {
    let pairs = [(Axis::X, Axis::Y), (Axis::X, Axis::Z), (Axis::Y, Axis::Z)];
    let squareness: Vec<String> = pairs
        .into_iter()
        .filter_map(|(a, b)| {
            Some(format!(
                "{}{} {:+.3}",
                a.key(),
                b.key(),
                Figure(model.squareness_um_per_m(a, b)?)
            ))
        })
        .collect();
    match squareness.is_empty() {
        true => String::new(),
        false => format!(
            "squareness, µm/m: {} (positive: less than 90° between the positive axes)",
            squareness.join(", ")
        ),
    }
}

/// Reversal of each axis, where both directions were measured.
pub(super) fn reversals(model: &ErrorModel) -> String {
    let texts: Vec<String> = model
        .measured()
        .filter_map(|(term, measured)| {
            Some(format!("{term} {:+.3}", Figure(measured.reversal()?.um())))
        })
        .collect();
    if texts.is_empty() {
        return String::new();
    }
    format!(
        "reversal B (mean moving + minus mean moving -), µm: {}",
        texts.join(", ")
    )
}

/// The terms whose uncertainty counts as 0 because nobody stated it.
fn without_uncertainty(forecast: &Forecast) -> String {
    let without: Vec<String> = forecast
        .terms
        .iter()
        .filter(|t| t.u_um.is_none())
        .map(|t| t.term.to_string())
        .collect();
    if without.is_empty() {
        String::new()
    } else if without.len() == forecast.terms.len() {
        "; U is not stated and counted as 0".to_string()
    } else {
        format!(
            "; U of {} is not stated and counted as 0",
            without.join(", ")
        )
    }
}

/// Verdict with the limits it was judged by.
/// Below it stands what does not keep them.
pub(super) fn verdict(
    verdict: Verdict,
    job: &Job,
    forecast: Option<&Forecast>,
    differs: bool,
    doubts: &[String],
) -> String {
    let acceptance = job.acceptance;
    let mut limits = Vec::new();
    if let Some(um) = acceptance.max_deviation_um {
        let terms = forecast.map_or_else(|| "every term".to_string(), Forecast::terms_words);
        limits.push(format!("{terms} within {um} µm"));
    }
    if let Some(um) = acceptance.max_diagonal_um {
        limits.push(format!("max - min of every body diagonal within {um} µm"));
    }
    let asked = if limits.is_empty() {
        "no acceptance is stated in the job".to_string()
    } else {
        limits.join(", ")
    };
    let uncertainty = match forecast {
        Some(forecast) if !limits.is_empty() => {
            let directions = forecast.directions_words();
            let directions = directions.map_or_else(String::new, |words| format!("; {words}"));
            let unused = job.measurement.unused_keys().join(", ");
            let unused = match unused.is_empty() {
                true => String::new(),
                false => format!("; stated and not counted: {unused}"),
            };
            let silent = forecast.not_counted(acceptance);
            let silent: String = silent.iter().map(|words| format!("; {words}")).collect();
            format!(
                "; {}{directions}{}{silent}{unused}",
                forecast.range_words(),
                without_uncertainty(forecast)
            )
        }
        _ => String::new(),
    };
    let short =
        acceptance.max_diagonal_um.is_some() && forecast.is_some_and(|f| f.diagonals.is_empty());
    let missing = if short {
        "; body diagonals need all nine errors, none measured in one direction only"
    } else {
        ""
    };
    let nothing_asked = limits.is_empty() && verdict == Verdict::Pass;
    let mut lines = vec![if nothing_asked {
        "verdict: no acceptance is stated in the job, so there is nothing to judge".to_string()
    } else {
        format!(
            "verdict: {} (asked: {asked}{uncertainty}{missing})",
            verdict.word()
        )
    }];
    if differs {
        lines.push("  because the files differ from the job, or from their manifest".to_string());
    }
    let misses = forecast.map(|f| f.misses(acceptance)).unwrap_or_default();
    lines.extend(misses.iter().map(|miss| format!("  {miss}")));
    lines.extend(doubts.iter().map(|doubt| format!("  DOUBTFUL: {doubt}")));
    lines.join("\n")
}

/// Assumed facts with their consequence; behind them those that cannot matter for this kit.
pub(super) fn assumptions(assumptions: &[Assumption]) -> String {
    let mut lines = Vec::new();
    for a in assumptions.iter().filter(|a| a.without_effect.is_none()) {
        lines.push(format!("  {} = {}", a.fact, a.value));
        lines.push(format!("      if wrong: {}", a.consequence));
    }
    if !lines.is_empty() {
        lines.insert(0, "assumed, not shown by any control yet:".to_string());
    }
    let idle: Vec<String> = assumptions
        .iter()
        .filter_map(|a| Some(format!("  {} = {}: {}", a.fact, a.value, a.without_effect?)))
        .collect();
    if !idle.is_empty() {
        lines.push("assumed too, without effect on this kit:".to_string());
        lines.extend(idle);
    }
    lines.join("\n")
}

/// What a person has to see to, one sentence each; axes of which the same is asked share one.
pub(super) fn preconditions(preconditions: &[Precondition]) -> String {
    if preconditions.is_empty() {
        return String::new();
    }
    let mut lines = vec!["preconditions on the control, for a person to see to:".to_string()];
    for (what, p) in shared(preconditions) {
        lines.push(format!("  {what} must be {}:", p.value));
        lines.push(format!("      {} [{}]", p.why, p.source));
    }
    lines.join("\n")
}

/// The signs that are only assumed, in one line, with what proves them.
pub(super) fn assumed_signs(assumptions: &[Assumption], proofs: &[&str]) -> Vec<String> {
    let signs = assumptions
        .iter()
        .filter(|a| a.fact.ends_with("_sign") && a.without_effect.is_none());
    let signs: Vec<String> = signs.map(|a| format!("{} = {}", a.fact, a.value)).collect();
    let proof = match proofs {
        [] => "prove it with one small bump before use".to_string(),
        files => format!("prove it first: {} (checklist.md)", files.join(", ")),
    };
    let line = format!(
        "SIGN ASSUMED, not seen on a control: {}; {proof}",
        signs.join(", ")
    );
    (!signs.is_empty()).then_some(line).into_iter().collect()
}

/// Assumptions that can matter for a kit.
pub(super) fn effective(assumptions: &[Assumption]) -> usize {
    let matter = assumptions.iter().filter(|a| a.without_effect.is_none());
    matter.count()
}

/// Paragraphs with a blank line between; empty ones are left out.
pub(super) fn paragraphs(parts: &[String]) -> String {
    let parts: Vec<&str> = parts
        .iter()
        .map(String::as_str)
        .filter(|part| !part.is_empty())
        .collect();
    parts.join("\n\n")
}
