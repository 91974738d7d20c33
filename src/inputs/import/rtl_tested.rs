//! The single runs of an `.rtl` file, as a positioning test needs them: a mean holds no
//! repeatability.

use crate::inputs::import::choices::{Encoding, Sign};
use crate::inputs::import::placing::Placing;
use crate::inputs::import::rtl::linear_kind;
use crate::inputs::import::rtl_file::File;
use crate::inputs::import::rtl_runs::Travelled;
use crate::inputs::import::rtl_sections::Sections;
use crate::inputs::import::rtl_texts::{
    environment_facts, material_words, stated_axis, user_facts,
};
use crate::inputs::import::stated::Stated;
use crate::inputs::import::{Component, Format, Kind, Measurement, encoding, refused};
use crate::quantity::axis::{Axis, Direction};
use crate::text::document::Source;
use crate::text::problem::Problems;

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
const TAKES: [&str; 5] = [
    "--axis",
    "--targets-run",
    "--sign",
    "--runs",
    "--material-corrected",
];

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
    let Some(mut measured) = problems.take(read(&source, stated)) else {
        return Err(problems);
    };
    measured.facts.insert(0, format!("text: {words}"));
    problems.or_ok(measured)
}

fn read(source: &Source, stated: &Stated) -> Result<MeasuredRuns, Problems> {
    let sections = Sections::of(source)?;
    let mut problems = Problems::none();
    let kind = linear_kind(&sections, &mut problems);
    let file = problems.take(File::read(&sections));
    let sign = stated.required_sign(&mut problems);
    let axis = stated_axis(&sections, stated, &mut problems);
    let Some(file) = file else {
        return Err(problems);
    };
    let warnings = material_words(&sections, stated, file.length_mm(), &mut problems);
    let placed = Stated {
        first_target_at_mm: first_target_mm(&file.targets, stated),
        ..stated.clone()
    };
    let placing = Placing::of(&file.targets, &file.targets_place, &placed, &mut problems);
    let ways = file.runs_travelled(stated, &mut problems);
    let (Some(sign), Some(placing), Some(ways)) = (sign, placing, ways) else {
        return Err(problems);
    };
    let mut facts = user_facts(&sections);
    facts.extend(axis);
    facts.extend(kind);
    facts.extend(environment_facts(&sections));
    facts.push("targets: counted from the zero of the file, not of the machine".to_string());
    facts.extend(placing.sense_words(POSITIONING));
    // The first sentence is about means.
    facts.extend(ways.words(&placing).into_iter().skip(1));
    facts.extend(warnings);
    let (up_um, down_um) = file.by_direction(&ways, &placing, sign);
    problems.or_ok(MeasuredRuns {
        targets_mm: placing.positions_mm(),
        up_um,
        down_um,
        facts,
    })
}

/// Of each target the deviations of all runs; `None` where there is no run.
type OfTargets = Option<Vec<Vec<f64>>>;

impl File<'_> {
    /// Runs moving + and −.
    fn by_direction(
        &self,
        ways: &Travelled,
        placing: &Placing,
        sign: Sign,
    ) -> (OfTargets, OfTargets) {
        let of = |runs: &[usize]| -> OfTargets {
            let one = |run: &usize| placing.deviations(&self.run(*run), POSITIONING, sign);
            let each: Vec<Vec<f64>> = runs.iter().map(one).collect();
            let at = |target: usize| each.iter().map(|of_run| of_run[target]).collect();
            (!runs.is_empty()).then(|| (0..self.targets.len()).map(at).collect())
        };
        let (out, back) = (of(&ways.forward), of(&ways.reverse));
        match placing.run {
            Direction::Plus => (out, back),
            Direction::Minus => (back, out),
        }
    }
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
