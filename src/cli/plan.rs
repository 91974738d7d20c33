//! `nonius plan JOB`

mod page;

use crate::cli::outcome::{Outcome, Print, number};
use crate::inputs::job::{Job, UseOf};
use crate::kit::visit_plan::{Design, SetUpTimes, Visit, plan};
use crate::machine::separation::metric::PerPlane;
use crate::quantity::axis::{Axis, PerTerm};
use crate::quantity::diagonal::Diagonal;
use crate::text::document::Source;
use crate::text::problem::Problems;
use crate::visit::files::Files;
use crate::visit::job_files::JobFiles;
use clap::Args;
use page::{Page, letter};
use serde_json::{Value, json};
use std::path::PathBuf;

// Options of `plan`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// The job (TOML) with the run of step diagonals; its readings need not exist; `-` = standard input
    job: PathBuf,
    /// Time to set laser and mirror up on one diagonal, min
    #[arg(long, value_name = "MIN", default_value_t = 30.0, value_parser = minutes)]
    diagonal_set_up_min: f64,
    /// Time to set laser and reflector up along one axis, min
    #[arg(long, value_name = "MIN", default_value_t = 20.0, value_parser = minutes)]
    linear_set_up_min: f64,
    #[command(flatten)]
    print: Print,
}

fn minutes(text: &str) -> Result<f64, String> {
    number(text, 0.0..=1440.0, "min")
}

pub(super) fn run(options: &Options, files: &dyn Files) -> Result<Outcome, Problems> {
    let (name, bytes) = files.argument(&options.job)?;
    let job = Job::read_for(Source::from_bytes(&name, &bytes)?, UseOf::Plan)?;
    let times = SetUpTimes {
        diagonal_min: options.diagonal_set_up_min,
        linear_min: options.linear_set_up_min,
    };
    let mut named = JobFiles::new(files, &job, &options.job);
    let angles = job.measurement.angles.as_deref();
    let angles = angles.map(|path| named.table(path, "measurement.angles"));
    let design = Design::of(&job, angles.transpose()?, times)?;
    let found = plan(&design)?;
    let page = Page { machine: &job.machine.name, design: &design, found: &found };
    let outcome = options.print.outcome(|| page.screen(), || document(&page))?;
    Ok(outcome.answering(found.visits[0].reaches(job.acceptance)))
}

/// `--format json` (contract §5).
fn document(page: &Page<'_>) -> Value {
    let (design, found) = (page.design, page.found);
    let (instrument, times) = (design.instrument, design.times);
    let (acceptance, u) = (design.acceptance(), design.u_um_per_m(&found.visits[0]));
    let visits = found.visits.iter().enumerate();
    let visits = visits.map(|(index, visit)| of_visit(page, index, visit));
    json!({
        "schema": 1,
        "machine": page.machine,
        "acceptance": { "max_deviation_um": acceptance.max_deviation_um,
                        "max_diagonal_um": acceptance.max_diagonal_um },
        "noise_um": instrument.noise_um,
        "noise_is_assumed": instrument.stated.noise_um.is_none(),
        "set_up_min": { "diagonal": times.diagonal_min, "linear": times.linear_min },
        "linear_named": keys(&design.axes_named()),
        "linear_u_um_per_m": { "x": u.x, "y": u.y, "z": u.z },
        "best": found.forecast.map(letter),
        "best_second": found.second.map(letter),
        "decides": found.decides,
        "visits": visits.collect::<Vec<_>>(),
        "assumed": design.assumed(&found.visits[0]),
    })
}

fn of_visit(page: &Page<'_>, index: usize, visit: &Visit) -> Value {
    let (run, expected) = (&visit.variant.run, &visit.expected);
    let missing = expected.missing().into_iter();
    json!({
        "name": letter(index),
        "change": visit.variant.change(&page.design.described),
        "steps": run.volume.steps,
        "runs": run.runs,
        "return_pass": run.bidirectional,
        "overrun": run.runs_over(),
        "linear": keys(&visit.variant.linear),
        "angles": visit.variant.angles.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "target_spacing_mm": visit.variant.target_spacing_mm(),
        "spacing_mm": page.design.other_grid(&visit.variant).map(|mm| json!({ "x": mm.x, "y": mm.y, "z": mm.z })),
        "minutes": (10.0 * visit.minutes).round() / 10.0,
        "set_ups": Diagonal::ALL.len() + visit.variant.linear.len() + visit.variant.angles.len(),
        "mirror_circle_mm": visit.mirror.map(|mirror| mirror.circle_mm),
        "expanded_um": PerTerm::from_fn(|term| visit.expanded_um(term)),
        "squareness_expanded_um_per_m": PerPlane::from_fn(|plane| expected.expanded_squareness_um_per_m(plane)),
        "together_expanded_um": visit.at_most_um(),
        "second_passes": visit.chance,
        "not_determined": missing.map(|term| term.to_string()).collect::<Vec<_>>(),
        "reversal_of": keys(&visit.reversals()),
        "reached": visit.reaches(page.design.acceptance()),
        "shortcomings": visit.shortcomings(),
    })
}

fn keys(axes: &[Axis]) -> Vec<&'static str> {
    axes.iter().map(|axis| axis.key()).collect()
}
