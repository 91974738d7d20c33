//! Figures of one axis: what `standards` prints of it.

use crate::cli::diagonals::{counts, named_um};
use crate::cli::outcome::joined;
use crate::cli::screen::{More, Screen, paragraphs, table};
use crate::cli::show::{self, um};
use crate::inputs::target_runs::Runs;
use crate::machine::standards::iso_230_2::{self, Travel};
use crate::machine::standards::{self, ByDirection, Condition, Met, VDI_3441, in_words, vdi_3441};
use crate::page::{Locale, Picture, targets};
use crate::quantity::Direction;
use crate::text::{Finding, Problem};
use serde_json::{Value, json};

/// What the standards say about the runs of an axis.
pub(super) struct Page<'a> {
    name: &'a str,
    runs: &'a Runs,
    travel: Travel,
    iso: iso_230_2::Figures,
    conditions: Vec<Condition>,
    vdi: Option<vdi_3441::Figures>,
    notes: Vec<Finding>,
}

impl Page<'_> {
    /// `notes`: what the file of the runs states.
    pub(super) fn of<'a>(
        name: &'a str,
        runs: &'a Runs,
        travel_mm: Option<f64>,
        mut notes: Vec<Finding>,
    ) -> Result<Page<'a>, Problem> {
        let travel = Travel::of(runs, travel_mm)?;
        notes.extend(iso_230_2::remarks(runs, travel));
        Ok(Page {
            name,
            runs,
            travel,
            iso: iso_230_2::figures(runs),
            conditions: iso_230_2::conditions(runs, travel),
            vdi: vdi_3441::figures(runs),
            notes,
        })
    }

    /// Means and bands at the targets.
    pub(super) fn picture(&self, locale: Locale<'_>) -> Picture {
        let name = String::new();
        let across = locale.words("target");
        targets(locale, self.name, &across, &[(name, &self.iso)])
    }

    pub(super) fn screen(&self) -> Screen {
        let targets = self.runs.targets_mm();
        let end = |at: Option<&f64>| in_words(at.copied().unwrap_or_default());
        let heading = format!(
            "{} - {} targets from {} to {} mm, runs: {} up (+), {} down (-)",
            self.name,
            targets.len(),
            end(targets.first()),
            end(targets.last()),
            self.runs.count(Direction::Plus),
            self.runs.count(Direction::Minus),
        );
        let title = format!(
            "ISO 230-2, k = 2; the formulas are those of the editions {}\n{}",
            crate::text::joined(iso_230_2::EDITIONS),
            iso_230_2::label(&self.conditions)
        );
        Screen {
            verdict: format!("{heading}\n{title}"),
            figures: paragraphs(&[self.axis_table(), vdi_table(self.vdi.as_ref())]),
            findings: [missed(&self.conditions), show::notes(&self.notes)].concat(),
            more: vec![
                More::part("every target", target_rows(self.iso.targets.iter().map(by_iso))),
                conditions("conditions of ISO 230-2", &self.conditions),
                More::part(
                    "every target of VDI/DGQ 3441",
                    self.vdi
                        .as_ref()
                        .map_or_else(String::new, |of| target_rows(of.targets.iter().map(by_vdi))),
                ),
            ],
            ..Screen::default()
        }
    }

    fn axis_table(&self) -> String {
        let axis = &self.iso.axis;
        let both = |both_um| ByDirection { both_um, ..ByDirection::default() };
        let mark = if self.travel.is_long() { ", not in the standard above 2 m" } else { "" };
        let rows = [
            ("A", "positioning error (accuracy)", mark, axis.a),
            ("E", "systematic positioning error", "", axis.e),
            ("R", "repeatability", mark, axis.r),
            ("M", "range of the mean bidirectional error", "", both(axis.m_um)),
            ("B", "reversal error, largest |B_i|", "", both(axis.b_um)),
            ("B mean", "mean reversal error", "", both(axis.b_mean_um)),
        ];
        let rows = rows.map(|(letter, what, mark, of)| {
            let [up, down, both] = [of.up_um, of.down_um, of.both_um].map(um);
            format!("{letter}\t{what}{mark}\t{up}\t{down}\t{both}")
        });
        table("figure\t\t>up/µm\t>down/µm\t>both/µm", rows)
    }

    pub(super) fn document(&self) -> Value {
        let foreign: &[&str] = if self.travel.is_long() { &["A", "R"] } else { &[] };
        let iso = joined([
            json!({
                "editions": iso_230_2::EDITIONS,
                "confidence": standards::ISO_230_2,
                "condition_missed": self.conditions.iter().any(|of| of.met == Met::No),
                "label": iso_230_2::label(&self.conditions),
            }),
            named_um(self.iso.axis.named_um()),
            json!({
                "not_in_the_standard": foreign,
                "targets": target_list(self.iso.targets.iter().map(by_iso)),
                "conditions": { "list": self.conditions },
                "notes": self.notes,
            }),
        ]);
        json!({
            "schema": 1,
            "targets": self.runs.targets_mm().len(),
            "length_mm": self.runs.length_mm(),
            "travel_mm": self.travel.stated_mm(),
            "runs": counts(Direction::BOTH.map(|way| self.runs.count(way))),
            "iso_230_2": iso,
            "vdi_dgq_3441": self.vdi.as_ref().map(vdi_document),
        })
    }
}

fn vdi_document(figures: &vdi_3441::Figures) -> Value {
    joined([
        json!({ "confidence": VDI_3441 }),
        named_um(vdi_figures(figures).map(|(name, _, um)| (name, um))),
        json!({ "targets": target_list(figures.targets.iter().map(by_vdi)) }),
    ])
}

/// A target, mm, and its figures, each by its name in the document.
type AtTarget<const N: usize> = (f64, [(&'static str, Option<f64>); N]);

fn target_rows<const N: usize>(all: impl Iterator<Item = AtTarget<N>>) -> String {
    let mut heading = String::new();
    let rows = all.map(|(mm, figures)| {
        let names = figures.map(|(name, _)| format!("\t>{}/µm", name.replace('_', " ")));
        heading = format!(">target/mm{}", names.concat());
        format!("{}\t{}", in_words(mm), figures.map(|(_, figure)| um(figure)).join("\t"))
    });
    let rows: Vec<String> = rows.collect();
    table(&heading, rows)
}

fn target_list<const N: usize>(all: impl Iterator<Item = AtTarget<N>>) -> Value {
    all.map(|(mm, figures)| joined([json!({ "target_mm": mm }), named_um(figures)])).collect()
}

fn by_vdi(of: &vdi_3441::TargetFigures) -> AtTarget<3> {
    (of.target_mm, [("mean", Some(of.mean_um)), ("U", Some(of.u_um)), ("s_mean", of.s_um)])
}

fn by_iso(of: &iso_230_2::TargetFigures) -> AtTarget<9> {
    let figures = [
        ("mean", of.mean.both_um),
        ("mean_up", of.mean.up_um),
        ("mean_down", of.mean.down_um),
        ("s_up", of.s.up_um),
        ("s_down", of.s.down_um),
        ("B", of.b_um),
        ("R", of.r.both_um),
        ("R_up", of.r.up_um),
        ("R_down", of.r.down_um),
    ];
    (of.target_mm, figures)
}

/// What stands beside figures and conditions that are no more than that.
pub(super) const LIKELY: &str = "likely: from secondary sources, not compared with the text";

/// Conditions that the data do not meet.
pub(super) fn missed(conditions: &[Condition]) -> Vec<String> {
    let missed = conditions.iter().filter(|of| of.met == Met::No);
    let missed = missed.map(|of| format!("not met: {}, found: {}", of.asked, of.found));
    missed.collect()
}

pub(super) fn conditions(heading: &str, conditions: &[Condition]) -> More {
    let rows = conditions.iter().map(|condition| {
        format!(
            "{}\t{}\t{}\t{} ({})",
            condition.met.word(),
            condition.asked,
            condition.found,
            crate::text::joined(condition.editions),
            condition.confidence
        )
    });
    let table = table("outcome\tasked\tfound\teditions", rows);
    More::new(conditions.len(), ["condition", "conditions"], format!("{heading}\n{table}"))
}

/// The figures of VDI/DGQ 3441, each by its name and in words.
fn vdi_figures(of: &vdi_3441::Figures) -> [(&'static str, &'static str, Option<f64>); 5] {
    [
        ("P", "positioning uncertainty", of.p_um),
        ("P_a", "positioning deviation, range of the means", Some(of.p_a_um)),
        ("P_s", "positioning scatter, largest 6 s mean", of.p_s_um),
        ("U", "largest reversal", Some(of.u_um)),
        ("U_mean", "mean reversal", Some(of.u_mean_um)),
    ]
}

fn vdi_table(figures: Option<&vdi_3441::Figures>) -> String {
    let heading = format!("VDI/DGQ 3441 ({LIKELY})");
    let Some(figures) = figures else {
        return format!("{heading}\nnote: every figure needs both directions");
    };
    let rows = vdi_figures(figures).map(|(name, what, figure)| {
        let letter = if name == "U_mean" { "U mean" } else { name };
        format!("{letter}\t{what}\t{}", um(figure))
    });
    format!("{heading}\n{}", table("figure\t\t>value/µm", rows))
}
