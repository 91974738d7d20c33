//! The single runs of an `.rtl` file, as a positioning test needs them: a mean holds no
//! repeatability.

use crate::axis::{Axis, Direction};
use crate::import::choices::Encoding;
use crate::import::placing::Placing;
use crate::import::rtl::{File, linear_kind};
use crate::import::rtl_sections::Sections;
use crate::import::rtl_texts::{axis_fact, environment_facts, user_facts};
use crate::import::stated::Stated;
use crate::import::{Component, Format, Kind, Measurement, encoding, refused};
use crate::problem::Problems;

/// Deviations of every run at every target, in the order of the machine's coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredRuns {
    /// Targets, ascending, mm.
    pub targets_mm: Vec<f64>,
    /// Of each target the runs moving +, µm; `None` = not measured.
    pub up_um: Option<Vec<Vec<f64>>>,
    /// Likewise moving −.
    pub down_um: Option<Vec<Vec<f64>>>,
    /// What the file states and what was done with it, one sentence each.
    pub facts: Vec<String>,
}

/// Positioning is measured along the axis itself; which one it is changes no figure.
const POSITIONING: Component = Component {
    kind: Kind::Deviation(Axis::X),
    along: Axis::X,
};
/// What has to be stated of the file, or may be.
const TAKES: [&str; 3] = ["--targets-run", "--sign", "--runs"];

/// Reads the runs of a `.rtl` file: runs 1, 3, 5 … went from the first target to the last, even
/// ones back, as the file's flags or `--runs` say.
///
/// sign   deviation = actual − commanded in the sense of the machine's coordinate: where the file
///        counts its targets against the axis, deviations are turned with them
/// limits the targets keep the coordinates of the file: no figure depends on where they are
pub fn measured_runs(
    file: Measurement<'_>,
    stated_encoding: Option<Encoding>,
    stated: &Stated,
) -> Result<MeasuredRuns, Problems> {
    refused::refuse_bytes(file)?;
    let (source, words) = encoding::decode(file, stated_encoding)?;
    refused::refuse_text(file, &source.text, false)?;
    let mut problems = stated.foreign_to(Format::Rtl.word(), &TAKES);
    let sections = problems.take(Sections::of(&source));
    let parts = sections.and_then(|sections| {
        let kind = linear_kind(&sections, &mut problems);
        let parts = problems.take(File::read(&sections));
        let mut facts = user_facts(&sections);
        facts.extend(axis_fact(&sections));
        facts.extend(kind);
        facts.extend(environment_facts(&sections));
        parts.map(|file| (file, facts))
    });
    let sign = stated.required_sign(&mut problems);
    let Some((file, said)) = parts else {
        return Err(problems);
    };
    let placed = Stated {
        first_target_at_mm: first_target_mm(&file.targets, stated),
        ..stated.clone()
    };
    let placing = Placing::of(&file.targets, &file.targets_place, &placed, &mut problems);
    let ways = file.runs_travelled(stated, &mut problems);
    let (Some(sign), Some(placing), Some(ways)) = (sign, placing, ways) else {
        return Err(problems);
    };
    let runs_of = |runs: &[usize]| -> Option<Vec<Vec<f64>>> {
        let one = |run: &usize| placing.deviations(&file.run(*run), POSITIONING, sign);
        let each: Vec<Vec<f64>> = runs.iter().map(one).collect();
        let at = |target: usize| each.iter().map(|of_run| of_run[target]).collect();
        (!runs.is_empty()).then(|| (0..file.targets.len()).map(at).collect())
    };
    let (out, back) = (runs_of(&ways.forward), runs_of(&ways.reverse));
    let (up_um, down_um) = match placing.run {
        Direction::Plus => (out, back),
        Direction::Minus => (back, out),
    };
    let mut facts = vec![format!("text: {words}")];
    facts.extend(said);
    facts.push("targets: counted from the zero of the file, not of the machine".to_string());
    facts.extend(placing.sense_words(POSITIONING));
    facts.extend(ways.dropped_words());
    problems.or_ok(MeasuredRuns {
        targets_mm: placing.positions_mm(),
        up_um,
        down_um,
        facts,
    })
}

/// The coordinate of the first target: that of the file, mirrored at its zero where the file counts
/// against the axis.
fn first_target_mm(targets: &[f64], stated: &Stated) -> Option<f64> {
    let (first, last) = (targets.first()?, targets.last()?);
    let ascending = first < last;
    let run = stated.targets_run.unwrap_or(Direction::Plus);
    let along = ascending == (run == Direction::Plus);
    Some(if along { *first } else { 0.0 - first })
}
