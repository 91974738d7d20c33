//! What `standards` shows: figures of one axis, and of the body diagonals of a job with readings, or of readings alone.

use crate::cli::outcome::{Outcome, Shows};
use crate::cli::screen::{More, Screen, paragraphs, table};
use crate::cli::show::{self, um};
use crate::inputs::readings::Readings;
use crate::inputs::target_runs::Runs;
use crate::machine::findings::StandardFinding;
use crate::machine::separation::Separation;
use crate::machine::standards::iso_230_2::{self, AxisFigures, Travel};
use crate::machine::standards::{
    ByDirection, Condition, Conditions, Counts, DIAGONALS, Diagonals, ISO_230_2, Met, VDI_3441,
    by_standard, in_words, vdi_3441,
};
use crate::page::{Locale, Picture, targets};
use crate::quantity::{Diagonal, PathKind, Run};
use crate::text::{Finding, NamedEntries, Problem, Problems, Source, joined};
use crate::visit::files::Files;
use crate::visit::job_files::read_campaign;
use serde::Serialize;
use std::path::Path;

/// What the standards say about the runs of an axis, as documents have it.
#[derive(Serialize)]
pub(in crate::cli) struct AxisPage<'a> {
    targets: usize,
    length_mm: f64,
    travel_mm: Option<f64>,
    runs: Counts,
    iso_230_2: Iso2302,
    vdi_dgq_3441: Option<Vdi>,
    #[serde(skip)]
    name: &'a str,
}

/// By ISO 230-2.
#[derive(Serialize)]
struct Iso2302 {
    editions: [u16; 3],
    confidence: &'static str,
    condition_missed: bool,
    label: String,
    #[serde(flatten)]
    figures: iso_230_2::Figures,
    not_in_the_standard: &'static [&'static str],
    targets: Vec<Target>,
    conditions: Conditions,
    notes: Vec<Finding>,
}

/// By VDI/DGQ 3441.
#[derive(Serialize)]
struct Vdi {
    confidence: &'static str,
    #[serde(flatten)]
    figures: NamedEntries<&'static str, Option<f64>>,
    targets: Vec<Target>,
}

/// A target and its figures, each by its name.
#[derive(Serialize)]
struct Target {
    target_mm: f64,
    #[serde(flatten)]
    figures: NamedEntries<&'static str, Option<f64>>,
}

impl AxisPage<'_> {
    /// `notes`: what the file of the runs states.
    pub(super) fn of<'a>(
        name: &'a str,
        runs: &Runs,
        travel_mm: Option<f64>,
        mut notes: Vec<Finding>,
    ) -> Result<AxisPage<'a>, Problem> {
        let travel = Travel::of(runs, travel_mm)?;
        notes.extend(iso_230_2::remarks(runs, travel));
        let (figures, list) = (iso_230_2::figures(runs), iso_230_2::conditions(runs, travel));
        let iso_230_2 = Iso2302 {
            editions: iso_230_2::EDITIONS,
            confidence: ISO_230_2,
            condition_missed: list.iter().any(|of| of.met == Met::No),
            label: iso_230_2::label(&list),
            not_in_the_standard: if travel.is_long() { &["A", "R"] } else { &[] },
            targets: figures.targets.iter().map(by_iso).collect(),
            figures,
            conditions: Conditions { list },
            notes,
        };
        Ok(AxisPage {
            targets: iso_230_2.targets.len(),
            length_mm: runs.length_mm(),
            travel_mm: travel.stated_mm(),
            runs: Counts::of(runs),
            iso_230_2,
            vdi_dgq_3441: vdi_3441::figures(runs).as_ref().map(by_vdi),
            name,
        })
    }

    /// Means and bands at the targets.
    pub(in crate::cli) fn picture(&self, locale: Locale<'_>) -> Picture {
        let name = String::new();
        targets(locale, self.name, &locale.words("target"), &[(name, &self.iso_230_2.figures)])
    }

    pub(super) fn screen(&self) -> Screen {
        let AxisPage { iso_230_2: iso, vdi_dgq_3441: vdi, runs, .. } = self;
        let end = |at: Option<&Target>| in_words(at.map_or(0.0, |of| of.target_mm));
        let heading = format!(
            "{} - {} targets from {} to {} mm, runs: {} up (+), {} down (-)",
            self.name,
            self.targets,
            end(iso.targets.first()),
            end(iso.targets.last()),
            runs.up,
            runs.down,
        );
        let title = format!(
            "ISO 230-2, k = 2; the formulas are those of the editions {}\n{}",
            joined(iso.editions),
            iso.label
        );
        let list = &iso.conditions.list;
        Screen {
            figures: paragraphs(&[self.axis_table(), vdi_table(vdi.as_ref())]),
            findings: [missed(list), show::notes(&iso.notes)].concat(),
            more: vec![
                More::part("every target", target_rows(&iso.targets)),
                conditions("conditions of ISO 230-2", list),
                More::part(
                    "every target of VDI/DGQ 3441",
                    vdi.as_ref().map(|of| target_rows(&of.targets)),
                ),
            ],
            ..Screen::of(format!("{heading}\n{title}"))
        }
    }

    fn axis_table(&self) -> String {
        let axis = &self.iso_230_2.figures.axis;
        let both = |both_um| ByDirection { both_um, ..ByDirection::default() };
        let mark = if self.iso_230_2.not_in_the_standard.is_empty() {
            ""
        } else {
            ", not in the standard above 2 m"
        };
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
}

/// A line for each target; its heading names the figures.
fn target_rows(all: &[Target]) -> String {
    let rows = all.iter().map(|Target { target_mm, figures }| {
        let cells = figures.iter().map(|(_, figure)| format!("\t{}", um(*figure)));
        format!("{}{}", in_words(*target_mm), cells.collect::<String>())
    });
    let names = all.first().into_iter().flat_map(|of| of.figures.iter());
    let names = names.map(|(name, _)| name.trim_end_matches("_um").replace('_', " "));
    let names = names.map(|name| format!("\t>{name}/µm"));
    table(&format!(">target/mm{}", names.collect::<String>()), rows)
}

fn by_vdi(of: &vdi_3441::Figures) -> Vdi {
    let target = |of: &vdi_3441::TargetFigures| {
        let figures =
            [("mean_um", Some(of.mean_um)), ("U_um", Some(of.u_um)), ("s_mean_um", of.s_um)];
        Target { target_mm: of.target_mm, figures: figures.into_iter().collect() }
    };
    let figures = [
        ("P_um", of.p_um),
        ("P_a_um", Some(of.p_a_um)),
        ("P_s_um", of.p_s_um),
        ("U_um", Some(of.u_um)),
        ("U_mean_um", Some(of.u_mean_um)),
    ];
    Vdi {
        confidence: VDI_3441,
        figures: figures.into_iter().collect(),
        targets: of.targets.iter().map(target).collect(),
    }
}

fn by_iso(of: &iso_230_2::TargetFigures) -> Target {
    let figures = [
        ("mean_um", of.mean.both_um),
        ("mean_up_um", of.mean.up_um),
        ("mean_down_um", of.mean.down_um),
        ("s_up_um", of.s.up_um),
        ("s_down_um", of.s.down_um),
        ("B_um", of.b_um),
        ("R_um", of.r.both_um),
        ("R_up_um", of.r.up_um),
        ("R_down_um", of.r.down_um),
    ];
    Target { target_mm: of.target_mm, figures: figures.into_iter().collect() }
}

/// What stands beside figures and conditions that are no more than that.
pub(super) const LIKELY: &str = "likely: from secondary sources, not compared with the text";

/// Conditions that the data do not meet.
pub(super) fn missed(conditions: &[Condition]) -> Vec<String> {
    let missed = conditions.iter().filter(|of| of.met == Met::No);
    missed.map(|of| format!("not met: {}, found: {}", of.asked, of.found)).collect()
}

pub(super) fn conditions(heading: &str, conditions: &[Condition]) -> More {
    let rows = conditions.iter().map(|condition| {
        format!(
            "{}\t{}\t{}\t{} ({})",
            condition.met.word(),
            condition.asked,
            condition.found,
            joined(condition.editions),
            condition.confidence
        )
    });
    let table = table("outcome\tasked\tfound\teditions", rows);
    More::new(conditions.len(), ["condition", "conditions"], format!("{heading}\n{table}"))
}

/// The figures of VDI/DGQ 3441 in words, in their order.
const VDI: [(&str, &str); 5] = [
    ("P", "positioning uncertainty"),
    ("P_a", "positioning deviation, range of the means"),
    ("P_s", "positioning scatter, largest 6 s mean"),
    ("U", "largest reversal"),
    ("U mean", "mean reversal"),
];

fn vdi_table(of: Option<&Vdi>) -> String {
    let heading = format!("VDI/DGQ 3441 ({LIKELY})");
    let Some(Vdi { figures, .. }) = of else {
        return format!("{heading}\nnote: every figure needs both directions");
    };
    let rows = VDI.into_iter().zip(figures.iter());
    let rows = rows.map(|((name, what), (_, figure))| format!("{name}\t{what}\t{}", um(*figure)));
    format!("{heading}\n{}", table("figure\t\t>value/µm", rows))
}

/// Words for the lower edge of a picture, by their key.
const ALONG: &str = "along_diagonal";
const ALONG_STEPS: &str = "along_diagonal_steps";

/// Figures of the readings that a job names.
pub(super) fn of_job(on: &dyn Files, path: &Path) -> Result<DiagonalPage, Problems> {
    let files = read_campaign(on, path)?;
    let measurement = &files.measurement;
    let (runs, all) = match measurement.kind {
        PathKind::Step => {
            let separation = files.separate()?;
            (separation.zeroed_runs, separation.runs.len())
        }
        PathKind::Straight => {
            let found = files.straight()?;
            (found.zeroed_runs, found.runs.len())
        }
    };
    let figures = by_standard(&measurement.volume, measurement.kind, &runs, true)?;
    let notes = notes(all > runs.len()).into_iter().chain(files.readings.zeroed()).collect();
    Ok(DiagonalPage::new(&measurement.readings, ALONG, figures, notes))
}

/// Readings that were separated.
pub(in crate::cli) fn of_separation(
    readings: &str,
    separation: &Separation,
) -> Result<DiagonalPage, Problems> {
    let runs = &separation.zeroed_runs;
    let figures = by_standard(&separation.volume, PathKind::Step, runs, true)?;
    Ok(DiagonalPage::new(readings, ALONG, figures, notes(separation.runs.len() > runs.len())))
}

/// Figures of readings alone: those that the box has no part in.
pub(super) fn of_readings(source: Source) -> Result<DiagonalPage, Problems> {
    let name = source.name.clone();
    let (readings, volume, kind) = Readings::without_job(source)?;
    let known = readings.runs.iter().cloned();
    let known: Vec<Run> = known.filter(|run| readings.offset_known(run)).collect();
    let mut notes = notes(known.len() < readings.runs.len());
    notes.extend(readings.zeroed());
    notes.push(StandardFinding::NoJob.into());
    let figures = by_standard(&volume, kind, &known, false)?;
    Ok(DiagonalPage::new(&name, ALONG_STEPS, figures, notes))
}

fn notes(dropped: bool) -> Vec<Finding> {
    let dropped = dropped.then_some(StandardFinding::ReverseNames);
    std::iter::once(StandardFinding::UpIsForward).chain(dropped).map(Finding::from).collect()
}

/// What the standards say about the body diagonals, as documents have it.
#[derive(Serialize)]
pub(in crate::cli) struct DiagonalPage {
    iso_230_6: Iso2306,
    #[serde(skip)]
    name: String,
    /// Key of what stands at the lower edge of the picture.
    #[serde(skip)]
    across: &'static str,
}

/// By ISO 230-6.
#[derive(Serialize)]
struct Iso2306 {
    confidence: &'static str,
    #[serde(flatten)]
    figures: Diagonals,
    notes: Vec<Finding>,
}

impl DiagonalPage {
    fn new(
        name: &str,
        across: &'static str,
        figures: Diagonals,
        notes: Vec<Finding>,
    ) -> DiagonalPage {
        let iso_230_6 = Iso2306 { confidence: DIAGONALS, figures, notes };
        DiagonalPage { iso_230_6, name: name.to_string(), across }
    }

    pub(super) fn outcome(&self, files: &dyn Files, shows: &Shows) -> Result<Outcome, Problems> {
        let picture = |locale: Locale<'_>| self.picture(locale, &self.name);
        shows.outcome(files, || self.screen(), || self, picture)
    }

    pub(in crate::cli) fn picture(&self, locale: Locale<'_>, heading: &str) -> Picture {
        let named = self.iso_230_6.figures.diagonals.iter();
        let named: Vec<_> = named.map(|(name, of)| (name.clone(), &of.figures)).collect();
        targets(locale, heading, &locale.words(self.across), &named)
    }

    fn screen(&self) -> Screen {
        let Iso2306 { figures: all, notes, .. } = &self.iso_230_6;
        let list = &all.conditions.list;
        let runs = all.diagonals.iter();
        let runs =
            runs.map(|(name, of)| format!("{name} {} up, {} down", of.runs.up, of.runs.down));
        let rows = [
            ("E_d", "largest E of the diagonals", all.e_d_um),
            ("B_d", "largest B of the diagonals", all.b_d_um),
            ("", "ASME B5.54: largest max - min of one diagonal", all.largest_range_um),
            ("", "ASME B5.54: max - min over all diagonals", all.range_over_all_um),
        ];
        let rows = rows.map(|(name, what, figure)| format!("{name}\t{what}\t{}", um(figure)));
        Screen {
            figures: paragraphs(&[all.table(), table("figure\t\t>value/µm", rows)]),
            findings: [missed(list), show::notes(notes)].concat(),
            more: vec![conditions(&format!("conditions of ISO 230-6 ({LIKELY})"), list)],
            ..Screen::of(format!(
                "{} - body diagonals, runs: {}\nfigures in the style of ISO 230-6:2002 and ASME B5.54\n{}",
                self.name,
                runs.collect::<Vec<_>>().join("; "),
                all.label
            ))
        }
    }
}

impl Diagonals {
    /// Every figure of every diagonal; what no diagonal has gets no column.
    fn table(&self) -> String {
        let all = || self.diagonals.iter().map(|(_, of)| &of.figures.axis);
        let is_there = |name: &&&str| all().any(|axis| figure(axis, name).is_some());
        let there: Vec<&str> = FIGURES.iter().filter(is_there).copied().collect();
        let headings = there.iter().map(|name| format!("\t>{}", name.replace('_', " ")));
        let rows = self.diagonals.iter().map(|(diagonal, of)| {
            let figures = there.iter().map(|name| um(figure(&of.figures.axis, name)) + "\t");
            format!("{diagonal}\t{}{}", figures.collect::<String>(), um(of.range_um))
        });
        table(&format!("diagonal, µm{}\t>max - min", headings.collect::<String>()), rows)
    }

    /// The table of the diagonals as they were read, with their far ends and the figures of all four.
    pub(in crate::cli) fn as_read(&self, end_um: impl Fn(Diagonal) -> f64) -> String {
        let ends = Diagonal::ALL.map(|d| format!("{d} {}", um(Some(end_um(d)))));
        let machine = match (self.e_d_um, self.b_d_um) {
            (Some(e_d), Some(b_d)) => {
                format!("machine: E_d {e_d:.3} µm, B_d {b_d:.3} µm (largest of the four)")
            }
            _ => {
                "no E and B: they need runs in both directions that count from one zero".to_string()
            }
        };
        format!(
            "Body diagonals as read (corrected readings, no compensation forecast), {}\n{}\nfar end less start, mean of all runs (µm): {}\nlargest range {} µm; over all four {} µm\n{machine}",
            self.label,
            self.table(),
            ends.join(", "),
            um(self.largest_range_um),
            um(self.range_over_all_um),
        )
    }
}

/// Figures of a diagonal in the order of the table.
const FIGURES: [&str; 12] =
    ["E", "E_up", "E_down", "M", "B", "B_mean", "R", "R_up", "R_down", "A", "A_up", "A_down"];

fn figure(of: &AxisFigures, wanted: &str) -> Option<f64> {
    of.named_um().into_iter().find(|(name, _)| *name == wanted).and_then(|(_, um)| um)
}
