//! What `standards` prints of an axis for people.

use crate::cli::show::{Column, paragraphs, table};
use crate::cli::standards::Results;
use crate::inputs::target_runs::Runs;
use crate::machine::standards::{
    self, ByDirection, Condition, Confidence, in_words,
    iso_230_2::{self, AxisFigures},
    vdi_3441,
};
use crate::quantity::axis::Direction;

pub(super) fn report(name: &str, runs: &Runs, results: &Results) -> String {
    let targets = runs.targets_mm();
    let heading = format!(
        "{name} - {} targets from {} to {} mm, runs: {} up (+), {} down (-)",
        targets.len(),
        in_words(targets.first().copied().unwrap_or_default()),
        in_words(targets.last().copied().unwrap_or_default()),
        runs.count(Direction::Plus),
        runs.count(Direction::Minus),
    );
    let long = results.travel.is_long();
    paragraphs(&[
        heading,
        format!(
            "ISO 230-2, k = 2; the formulas are those of the editions {}\n{}",
            editions_words(&iso_230_2::EDITIONS),
            iso_230_2::label(&results.conditions)
        ),
        axis_table(&results.iso.axis, long),
        notes(&results.notes),
        targets_table(&results.iso),
        format!(
            "conditions of ISO 230-2\n{}",
            conditions_table(&results.conditions)
        ),
        vdi_text(results.vdi.as_ref()),
    ])
}

/// `1997, 2006, 2014`.
fn editions_words(editions: &[u16]) -> String {
    let years: Vec<String> = editions.iter().map(u16::to_string).collect();
    years.join(", ")
}

pub(super) fn likely_words(confidence: Confidence) -> &'static str {
    match confidence {
        Confidence::Sure => "sure",
        Confidence::Likely => "likely: from secondary sources, not compared with the text",
    }
}

/// `long`: of an axis above 2 m, for which the standard knows no A and no R.
fn axis_table(axis: &AxisFigures, long: bool) -> String {
    let columns = [
        Column::Left("figure"),
        Column::Left(""),
        Column::Right("up/µm"),
        Column::Right("down/µm"),
        Column::Right("both/µm"),
    ];
    let both = |both_um| ByDirection {
        both_um,
        ..ByDirection::default()
    };
    let rows = [
        ("A", "positioning error (accuracy)", axis.a),
        ("E", "systematic positioning error", axis.e),
        ("R", "repeatability", axis.r),
        (
            "M",
            "range of the mean bidirectional error",
            both(axis.m_um),
        ),
        ("B", "reversal error, largest |B_i|", both(axis.b_um)),
        ("B mean", "mean reversal error", both(axis.b_mean_um)),
    ];
    table(
        &columns,
        rows.into_iter().map(|(letter, what, figure)| {
            let foreign = long && ["A", "R"].contains(&letter);
            let mark = if foreign {
                ", not in the standard above 2 m"
            } else {
                ""
            };
            vec![
                letter.to_string(),
                format!("{what}{mark}"),
                micrometres(figure.up_um),
                micrometres(figure.down_um),
                micrometres(figure.both_um),
            ]
        }),
    )
}

fn targets_table(figures: &iso_230_2::Figures) -> String {
    let columns = [
        Column::Right("target/mm"),
        Column::Right("mean up/µm"),
        Column::Right("mean down/µm"),
        Column::Right("mean/µm"),
        Column::Right("s up/µm"),
        Column::Right("s down/µm"),
        Column::Right("B/µm"),
        Column::Right("R up/µm"),
        Column::Right("R down/µm"),
        Column::Right("R/µm"),
    ];
    let rows = figures.targets.iter().map(|of| {
        let figures = [
            of.mean.up_um,
            of.mean.down_um,
            of.mean.both_um,
            of.s.up_um,
            of.s.down_um,
            of.b_um,
            of.r.up_um,
            of.r.down_um,
            of.r.both_um,
        ];
        std::iter::once(in_words(of.target_mm))
            .chain(figures.map(micrometres))
            .collect()
    });
    table(&columns, rows)
}

pub(super) fn conditions_table(conditions: &[Condition]) -> String {
    let columns = [
        Column::Left("outcome"),
        Column::Left("asked"),
        Column::Left("found"),
        Column::Left("editions"),
    ];
    let rows = conditions.iter().map(|condition| {
        vec![
            condition.met.word().to_string(),
            condition.asked.clone(),
            condition.found.clone(),
            format!(
                "{} ({})",
                editions_words(condition.editions),
                condition.confidence.word()
            ),
        ]
    });
    table(&columns, rows)
}

fn vdi_text(figures: Option<&vdi_3441::Figures>) -> String {
    let heading = format!("VDI/DGQ 3441 ({})", likely_words(standards::VDI_3441));
    let Some(figures) = figures else {
        return format!("{heading}\nnote: every figure needs both directions");
    };
    let columns = [
        Column::Left("figure"),
        Column::Left(""),
        Column::Right("value/µm"),
    ];
    let rows = [
        ("P", "positioning uncertainty", figures.p_um),
        (
            "P_a",
            "positioning deviation, range of the means",
            Some(figures.p_a_um),
        ),
        (
            "P_s",
            "positioning scatter, largest 6 s mean",
            figures.p_s_um,
        ),
        ("U", "largest reversal", Some(figures.u_um)),
        ("U mean", "mean reversal", Some(figures.u_mean_um)),
    ];
    let axis = table(
        &columns,
        rows.into_iter()
            .map(|(letter, what, um)| vec![letter.to_string(), what.to_string(), micrometres(um)]),
    );
    paragraphs(&[format!("{heading}\n{axis}"), vdi_targets(figures)])
}

fn vdi_targets(figures: &vdi_3441::Figures) -> String {
    let columns = [
        Column::Right("target/mm"),
        Column::Right("mean/µm"),
        Column::Right("U/µm"),
        Column::Right("s mean/µm"),
    ];
    let rows = figures.targets.iter().map(|of| {
        vec![
            in_words(of.target_mm),
            micrometres(Some(of.mean_um)),
            micrometres(Some(of.u_um)),
            micrometres(of.s_um),
        ]
    });
    table(&columns, rows)
}

fn notes(remarks: &[String]) -> String {
    let lines: Vec<String> = remarks.iter().map(|note| format!("note: {note}")).collect();
    lines.join("\n")
}

/// Three decimals; adding zero takes the sign off what rounds to nothing.
pub(super) fn micrometres(um: Option<f64>) -> String {
    um.map_or_else(
        || "-".to_string(),
        |um| format!("{:.3}", (um * 1000.0).round() / 1000.0 + 0.0),
    )
}
