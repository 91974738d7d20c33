//! `nonius standards FILE`

use crate::axis::Direction;
use crate::cli::inputs::read_argument;
use crate::cli::show::{Column, paragraphs, table};
use crate::cli::{Answer, Format, print, print_json};
use crate::document::Source;
use crate::manifest::picometres;
use crate::problem::Problems;
use crate::standards::{
    self, ByDirection, Condition, Confidence, Met,
    iso_230_2::{self, AxisFigures},
    vdi_3441,
};
use crate::target_runs::{LengthUnit, Runs, Stated, Values};
use clap::ValueEnum;
use serde_json::{Map, Value, json};
use std::path::Path;

/// Unit of columns without one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Unit {
    /// Millimetres
    Mm,
    /// Inches
    In,
    /// Micrometres
    Um,
}

/// What columns of runs hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Holding {
    /// Where the axis stood
    Positions,
    /// How far from the target it stood
    Deviations,
}

pub(super) fn run(
    file: &Path,
    unit: Option<Unit>,
    values: Option<Holding>,
    format: Format,
) -> Result<Answer, Problems> {
    let stated = Stated {
        unit: unit.map(|unit| match unit {
            Unit::Mm => LengthUnit::Millimetre,
            Unit::In => LengthUnit::Inch,
            Unit::Um => LengthUnit::Micrometre,
        }),
        values: values.map(|values| match values {
            Holding::Positions => Values::Positions,
            Holding::Deviations => Values::Deviations,
        }),
    };
    let (name, bytes) = read_argument(file)?;
    let runs = Runs::read(&Source::from_bytes(&name, &bytes)?, stated)?;
    let result = Tested::of(&runs);
    match format {
        Format::Json => print_json(&document(&runs, &result)),
        Format::Text => print(&report(&name, &runs, &result)),
    }
}

/// What the standards say about the runs.
struct Tested {
    iso: iso_230_2::Figures,
    conditions: Vec<Condition>,
    vdi: Option<vdi_3441::Figures>,
}

impl Tested {
    fn of(runs: &Runs) -> Tested {
        Tested {
            iso: iso_230_2::figures(runs),
            conditions: iso_230_2::conditions(runs),
            vdi: vdi_3441::figures(runs),
        }
    }
}

// ---------------------------------------------------------------------------------------------
// Text

fn report(name: &str, runs: &Runs, result: &Tested) -> String {
    let targets = runs.targets_mm();
    let heading = format!(
        "{name} - {} targets from {} to {} mm, runs: {} up (+), {} down (-)",
        targets.len(),
        millimetres(targets.first().copied().unwrap_or_default()),
        millimetres(targets.last().copied().unwrap_or_default()),
        runs.count(Direction::Plus),
        runs.count(Direction::Minus),
    );
    paragraphs(&[
        heading,
        format!(
            "ISO 230-2, formulas of 1997 to 2014, k = 2\n{}",
            iso_230_2::label(&result.conditions)
        ),
        axis_table(&result.iso.axis),
        notes(&iso_230_2::remarks(runs)),
        targets_table(&result.iso),
        format!(
            "conditions of ISO 230-2 ({})\n{}",
            likely_words(standards::ISO_230_2_CONDITIONS),
            conditions_table(&result.conditions)
        ),
        vdi_text(result.vdi.as_ref()),
    ])
}

fn likely_words(confidence: Confidence) -> &'static str {
    match confidence {
        Confidence::Sure => "sure",
        Confidence::Likely => "likely: from secondary sources, not compared with the text",
    }
}

fn axis_table(axis: &AxisFigures) -> String {
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
            vec![
                letter.to_string(),
                what.to_string(),
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
        std::iter::once(millimetres(of.target_mm))
            .chain(figures.map(micrometres))
            .collect()
    });
    table(&columns, rows)
}

fn conditions_table(conditions: &[Condition]) -> String {
    let columns = [
        Column::Left("outcome"),
        Column::Left("asked"),
        Column::Left("found"),
    ];
    let rows = conditions.iter().map(|condition| {
        vec![
            condition.met.word().to_string(),
            condition.asked.clone(),
            condition.found.clone(),
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
            millimetres(of.target_mm),
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
fn micrometres(um: Option<f64>) -> String {
    um.map_or_else(
        || "-".to_string(),
        |um| format!("{:.3}", (um * 1000.0).round() / 1000.0 + 0.0),
    )
}

fn millimetres(mm: f64) -> String {
    let text = format!("{mm:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

// ---------------------------------------------------------------------------------------------
// JSON

fn document(runs: &Runs, result: &Tested) -> Value {
    json!({
        "schema": 1,
        "targets": runs.targets_mm().len(),
        "length_mm": picometres(runs.length_mm()),
        "runs": { "up": runs.count(Direction::Plus), "down": runs.count(Direction::Minus) },
        "iso_230_2": iso_json(runs, result),
        "vdi_dgq_3441": result.vdi.as_ref().map(vdi_json),
    })
}

fn iso_json(runs: &Runs, result: &Tested) -> Value {
    let axis = &result.iso.axis;
    let mut document = Map::new();
    document.insert("editions".to_string(), json!("1997 to 2014"));
    document.insert("confidence".to_string(), json!(standards::ISO_230_2.word()));
    let missed = result.conditions.iter().any(|of| of.met == Met::No);
    document.insert("condition_missed".to_string(), json!(missed));
    document.insert(
        "label".to_string(),
        json!(iso_230_2::label(&result.conditions)),
    );
    for (letter, figure) in [("A", axis.a), ("E", axis.e), ("R", axis.r)] {
        insert(&mut document, letter, figure.both_um);
        insert(&mut document, &format!("{letter}_up"), figure.up_um);
        insert(&mut document, &format!("{letter}_down"), figure.down_um);
    }
    insert(&mut document, "M", axis.m_um);
    insert(&mut document, "B", axis.b_um);
    insert(&mut document, "B_mean", axis.b_mean_um);
    let targets: Vec<Value> = result.iso.targets.iter().map(iso_target_json).collect();
    document.insert("targets".to_string(), json!(targets));
    document.insert(
        "conditions".to_string(),
        conditions_json(&result.conditions),
    );
    document.insert("notes".to_string(), json!(iso_230_2::remarks(runs)));
    Value::Object(document)
}

fn iso_target_json(of: &iso_230_2::TargetFigures) -> Value {
    let mut target = Map::new();
    target.insert("target_mm".to_string(), json!(picometres(of.target_mm)));
    for (name, um) in [
        ("mean", of.mean.both_um),
        ("mean_up", of.mean.up_um),
        ("mean_down", of.mean.down_um),
        ("s_up", of.s.up_um),
        ("s_down", of.s.down_um),
        ("B", of.b_um),
        ("R", of.r.both_um),
        ("R_up", of.r.up_um),
        ("R_down", of.r.down_um),
    ] {
        insert(&mut target, name, um);
    }
    Value::Object(target)
}

fn conditions_json(conditions: &[Condition]) -> Value {
    let list: Vec<Value> = conditions
        .iter()
        .map(|of| {
            let found = (!of.found.is_empty()).then_some(&of.found);
            json!({ "asked": of.asked, "found": found, "outcome": of.met.word() })
        })
        .collect();
    json!({ "confidence": standards::ISO_230_2_CONDITIONS.word(), "list": list })
}

fn vdi_json(figures: &vdi_3441::Figures) -> Value {
    let mut document = Map::new();
    document.insert("confidence".to_string(), json!(standards::VDI_3441.word()));
    for (name, um) in [
        ("P", figures.p_um),
        ("P_a", Some(figures.p_a_um)),
        ("P_s", figures.p_s_um),
        ("U", Some(figures.u_um)),
        ("U_mean", Some(figures.u_mean_um)),
    ] {
        insert(&mut document, name, um);
    }
    let targets: Vec<Value> = figures
        .targets
        .iter()
        .map(|of| {
            let mut target = Map::new();
            target.insert("target_mm".to_string(), json!(picometres(of.target_mm)));
            insert(&mut target, "mean", Some(of.mean_um));
            insert(&mut target, "U", Some(of.u_um));
            insert(&mut target, "s_mean", of.s_um);
            Value::Object(target)
        })
        .collect();
    document.insert("targets".to_string(), json!(targets));
    Value::Object(document)
}

/// A figure under its letter and unit; `null` where it is absent.
fn insert(document: &mut Map<String, Value>, name: &str, um: Option<f64>) {
    document.insert(format!("{name}_um"), json!(um.map(picometres)));
}
