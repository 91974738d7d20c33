//! `nonius separate JOB [-o errors.csv]`, and its document (contract §5). Lengths and angles are rounded where a document is
//! printed; here only what has no unit.

mod text;
mod words;

use crate::cli::outcome::{Known, Outcome, Output, Plot, held};
use crate::cli::refusals;
use crate::inputs::error_table;
use crate::inputs::job::SetUp;
use crate::machine::separation::Separation;
use crate::machine::separation::campaign::Estimate;
use crate::machine::separation::monte_carlo::{Trials, simulate};
use crate::machine::separation::readings::{Noise, NoiseSource, coverage_factor};
use crate::machine::separation::reversal::Turn;
use crate::machine::separation::solved::scale_sum_um_mm;
use crate::machine::separation::straight::{ClosureTest, ClosureTests, StraightResult};
use crate::machine::standards::{DiagonalFigures, Diagonals, by_standard, repeatability_um};
use crate::page::separated;
use crate::quantity::{
    Axis, Diagonal, Direction, Millimetres, Pass, PathKind, PerAxis, PerDiagonal, PerTerm, Run,
    Volume, Xyz, picometres,
};
use crate::text::{Finding, NamedEntries, Problems};
use crate::visit::files::Files;
use crate::visit::job_files::{CampaignFiles, read_campaign};
use clap::Args;
use serde::Serialize;
use serde_json::{Value, json};
use std::path::PathBuf;
use words::{Results, advice, straight_screen};

// Options of `separate`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// The job (TOML) with readings of the body diagonals; `-` = standard input
    job: PathBuf,
    /// Trials of the Monte Carlo simulation of ranges and straightness; 0 = none
    #[arg(long, default_value_t = 2000, value_parser = trials)]
    trials: usize,
    /// Seed of the simulation
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    output: Output,
    #[command(flatten)]
    plot: Plot,
}

const MOST_TRIALS: usize = 200_000;

fn trials(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(1) | Err(_) => Err(format!("expected 0 or a whole number from 2 to {MOST_TRIALS}")),
        Ok(many) if many > MOST_TRIALS => Err(format!("at most {MOST_TRIALS}")),
        Ok(trials) => Ok(trials),
    }
}

pub(super) fn run(options: &Options, files: &dyn Files) -> Result<Outcome, Problems> {
    let output = &options.output;
    output.ensure_new(files, "the error table")?;
    let campaign = read_campaign(files, &options.job)?;
    if campaign.measurement.kind == PathKind::Straight {
        return straight_runs(options, &campaign);
    }
    let separation = campaign.separate()?;
    let plan = Trials { trials: options.trials, seed: options.seed };
    let simulated = || simulate(&separation, plan, files.progress(plan.trials));
    let simulated = (plan.trials > 0).then(simulated).flatten();
    let csv = output.is_asked_for().then(|| held(error_table::write(&campaign.draft(&separation))));
    let figures = by_standard(&separation.volume, PathKind::Step, &separation.zeroed_runs, true)?;
    let found = (&separation, &figures, simulated.as_ref());
    // Nothing is asked for under an assumed set-up.
    let advice = match separation.setup {
        SetUp::Solve => advice(&separation.metric),
        SetUp::AssumePerfect => Vec::new(),
    };
    let document = || of_steps(found, &advice);
    let outcome = output.deliver(files, csv, || text::screen(found, &advice), document, "")?;
    // No, where an error is not determined or something contradicts the result.
    options.plot.beside(files, outcome.answering(separation.stands()), output.force, |locale| {
        let words = locale.words("nine_errors_separated");
        separated(locale, &format!("{}: {words}", campaign.job.machine.name), &separation)
    })
}

fn straight_runs(options: &Options, campaign: &CampaignFiles) -> Result<Outcome, Problems> {
    if options.output.is_asked_for() {
        return Err(refusals::no_errors_to_write().into());
    }
    let result = campaign.straight()?;
    let figures = by_standard(&result.volume, PathKind::Straight, &result.zeroed_runs, true)?;
    let (open, advice) = (result.metric.undetermined(), advice(&result.metric));
    let screen = || straight_screen(&result, &figures, (&open, &advice));
    let document = || of_straight(&result, &figures, (&open, &advice));
    Ok(options.output.print.outcome(screen, document)?.answering(result.doubts.is_empty()))
}

/// Of both directions together, or of one.
#[derive(Serialize)]
struct Entry<'a> {
    position_mm: Vec<Millimetres>,
    deviation_um: &'a [f64],
    u_um: Option<Vec<f64>>,
}

/// The figures of all four diagonals together, and of each.
#[derive(Serialize)]
struct AllDiagonals<'a> {
    range_over_all_um: Option<f64>,
    scale_sum_um_mm: f64,
    e_d_um: Option<f64>,
    b_d_um: Option<f64>,
    label: &'a str,
    #[serde(flatten)]
    each: NamedEntries<Diagonal, Known<OfDiagonal<'a>>>,
}

#[derive(Serialize)]
struct OfDiagonal<'a> {
    end_reading_um: f64,
    range_um: Option<f64>,
    figures_um: &'a DiagonalFigures,
    repeatability_um: Option<NamedEntries<&'static str, Option<f64>>>,
    closure_largest_um: Option<f64>,
    closure_end_um: Option<f64>,
}

/// σ of a single reading and where it comes from.
#[derive(Serialize)]
struct OfNoise {
    sigma_um: f64,
    degrees_of_freedom: Option<usize>,
    coverage_factor: f64,
    source: NoiseSource,
    /// Of steps alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    closure_probability: Option<Option<f64>>,
}

#[derive(Serialize)]
struct Ends {
    low: Estimate,
    high: Estimate,
    constancy_probability: Option<f64>,
}

/// Of step diagonals; `advice`: what would determine what is open.
pub(super) fn of_steps((of, figures, simulated): Results<'_>, advice: &[String]) -> Known<Value> {
    let (metric, closure) = (&of.metric, &of.closure);
    let (u_squareness, tilts, turn) = (metric.u_squareness(), of.tilts.as_ref(), of.turn.as_ref());
    let sigma = of.noise.map(|noise| noise.sigma_um);
    let u_mean = |sigma| PerAxis::from_fn(|axis| closure.u_mean_um(axis, sigma));
    let (rank, unknowns) = of.rank();
    let noise = of.noise.map(|noise| {
        let test = closure.test(&noise);
        OfNoise::of(noise, Some(test.map(|test| test.probability)))
    });
    let diagonals = (&of.volume, &of.end_um, Some(of.runs.as_slice()), None);
    Known(json!({
        "errors": entries(of),
        "squareness_um_per_m": metric.squareness_um_per_m(),
        "u_squareness_um_per_m": u_squareness.map(|u| Some(u?.u)),
        "squareness_freedom": u_squareness.map(|u| u?.freedom),
        "redundancy": of.agreement,
        "squareness_least_squares_um_per_m": of.errors.least_squares_squareness(&of.volume),
        "setup_arcsec": tilts.map(|tilts| PerDiagonal::from_fn(|d| tilts[d].arcsec)),
        "setup_direction": tilts.map(|tilts| PerDiagonal::from_fn(|d| Xyz(tilts[d].direction))),
        "closure_um": closure.by_interval,
        "mean_closure_um": closure.mean,
        "closure_expected_um": sigma.map(|sigma| closure.scatter.times(sigma)),
        "mean_closure_expected_um": sigma.map(u_mean),
        "closure_ramp": closure.ramps,
        "rank": { "rank": rank, "unknowns": unknowns,
            "undetermined": of.undetermined, "advice": advice },
        "outliers": closure.outliers,
        "diagonals": AllDiagonals::of(figures, diagonals),
        "noise": noise,
        "reversal_um": turn.map(|turn| PerTerm::from_fn(|term| turn.reversal[term].um)),
        "u_reversal_um": turn.map(|turn| PerTerm::from_fn(|term| turn.reversal[term].u_um)),
        "reversal_change_um": turn.map(|turn| &turn.change_um),
        "reversal_at_ends": turn.map(|turn| PerAxis::from_fn(|axis| Ends::of(turn, axis))),
        "reversal_by_diagonal": turn.map(|turn| &turn.by_diagonal),
        "separated_slope_um_per_m": of.naive_slopes_um_per_m,
        "shape_um": of.shapes,
        "monte_carlo": simulated,
        "doubts": of.doubts,
        "not_stated": of.silence.not_stated,
        "neglected": of.silence.neglected,
        "labels": of.labels,
    }))
}

/// Of straight runs.
pub(super) fn of_straight(
    of: &StraightResult,
    figures: &Diagonals,
    (undetermined, advice): (&[Finding], &[String]),
) -> Known<Value> {
    let metric = &of.metric;
    let scale = |axis| metric.scale(axis).um_per_m;
    let scales = |found: &dyn Fn(Axis) -> Option<f64>| Known(PerAxis::from_fn(found));
    let diagonals = (&of.volume, &of.end_um, None, of.closure.as_ref());
    Known(json!({
        "squareness_um_per_m": metric.squareness_um_per_m(),
        "u_squareness_um_per_m": metric.u_squareness().map(|u| Some(u?.u)),
        "redundancy": of.agreement,
        "scale_um_per_m": scales(&scale),
        "u_scale_um_per_m": scales(&|axis| scale(axis).and(Some(metric.scale(axis).u?.u))),
        "rank": { "rank": metric.rank, "unknowns": 6,
            "undetermined": undetermined, "advice": advice },
        "diagonals": AllDiagonals::of(figures, diagonals),
        "noise": of.noise.map(|noise| OfNoise::of(noise, None)),
        "closure_test": of.closure,
        "doubts": of.doubts,
        "not_stated": of.silence.not_stated,
        "neglected": of.silence.neglected,
        "labels": of.labels,
    }))
}

/// Of both directions together, and of each where they are known apart.
fn entries(separation: &Separation) -> NamedEntries<String, Known<Entry<'_>>> {
    let directed = |way: Direction| Some((way.symbol(), separation.errors.directed(way)?));
    let directed = Direction::BOTH.into_iter().filter_map(directed);
    let all = std::iter::once(("", &separation.errors.mean)).chain(directed);
    let entries = all.flat_map(|(suffix, errors)| {
        errors.iter().filter_map(move |(term, found)| {
            let found = found.as_ref()?;
            let position_mm = separation.volume.positions(term.along);
            let entry =
                Entry { position_mm, deviation_um: &found.deviation_um, u_um: found.u_um() };
            Some((format!("{term}{suffix}"), Known(entry)))
        })
    });
    entries.collect()
}

/// The closure test of a diagonal with the larger difference of its two directions.
fn largest(tests: &[ClosureTest], diagonal: Diagonal) -> Option<&ClosureTest> {
    let of = tests.iter().filter(|test| test.diagonal == diagonal);
    of.max_by(|a, b| a.largest_um.total_cmp(&b.largest_um))
}

impl OfNoise {
    fn of(noise: Noise, closure_probability: Option<Option<f64>>) -> OfNoise {
        let Noise { sigma_um, freedom: degrees_of_freedom, source } = noise;
        let coverage_factor = coverage_factor(noise.freedom_f64());
        OfNoise { sigma_um, degrees_of_freedom, coverage_factor, source, closure_probability }
    }
}

/// The box, far ends, the runs of steps, closure tests of straight runs.
type Diagonally<'a> =
    (&'a Volume, &'a PerDiagonal<f64>, Option<&'a [Run]>, Option<&'a ClosureTests>);

impl AllDiagonals<'_> {
    fn of<'a>(
        all: &'a Diagonals,
        (volume, end_um, runs, tests): Diagonally<'_>,
    ) -> AllDiagonals<'a> {
        let each = end_um.iter().zip(all.diagonals.iter()).map(|((diagonal, end_um), (_, of))| {
            let test = tests.and_then(|tests| largest(&tests.tests, diagonal));
            let passes = |runs| {
                Pass::BOTH.map(|pass: Pass| (pass.word(), repeatability_um(runs, diagonal, pass)))
            };
            let figures = OfDiagonal {
                end_reading_um: *end_um,
                range_um: of.range_um,
                figures_um: of,
                repeatability_um: runs.map(|runs| passes(runs).into_iter().collect()),
                closure_largest_um: test.map(|test| test.largest_um),
                closure_end_um: test.map(|test| test.end_um),
            };
            (diagonal, Known(figures))
        });
        AllDiagonals {
            range_over_all_um: all.range_over_all_um,
            scale_sum_um_mm: scale_sum_um_mm(volume, end_um),
            e_d_um: all.e_d_um,
            b_d_um: all.b_d_um,
            label: &all.label,
            each: each.collect(),
        }
    }
}

impl Ends {
    fn of(turn: &Turn, axis: Axis) -> Ends {
        let [low, high] = turn.ends[axis];
        Ends { low, high, constancy_probability: turn.constancy[axis].map(picometres) }
    }
}
