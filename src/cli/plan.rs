//! `nonius plan JOB`

use crate::cli::outcome::{Outcome, Print, number};
use crate::cli::screen::{More, Screen, list, paragraphs, table, wrapped};
use crate::cli::show::um;
use crate::inputs::job::{Job, UseOf};
use crate::judge::findings::joined;
use crate::kit::visit_plan::{Design, SetUpTimes, Visit, VisitPlan, listed as in_words, plan};
use crate::machine::findings::SeparationFinding;
use crate::quantity::{Axis, Diagonal, ErrorTerm, PerPlane, PerTerm};
use crate::text::{Finding, Problems};
use crate::visit::files::Files;
use crate::visit::job_files::{InputFile, JobFiles};
use clap::Args;
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
    let job = Job::read_for(InputFile::read(files, &options.job)?.source()?, UseOf::Plan)?;
    let named = JobFiles::new(files, job, &options.job);
    let job = &named.job;
    let times = SetUpTimes {
        diagonal_min: options.diagonal_set_up_min,
        linear_min: options.linear_set_up_min,
    };
    let angles = job.measurement.angles.as_deref();
    let angles = angles.map(|path| named.table(path, "measurement.angles"));
    let design = Design::of(job, angles.transpose()?, times)?;
    let found = plan(&design)?;
    let outcome = options.print.outcome(|| found.screen(), || document(&found))?;
    Ok(outcome.answering(found.visits[0].reaches(job.acceptance)))
}

/// `--format json` (contract §5).
fn document(found: &VisitPlan<'_>) -> Value {
    let design = found.design;
    let (instrument, acceptance) = (design.instrument, design.job.acceptance);
    let visits = found.visits.iter().enumerate();
    let visits = visits.map(|(index, visit)| of_visit(design, index, visit));
    json!({
        "machine": design.job.machine.name,
        "acceptance": { "max_deviation_um": acceptance.max_deviation_um,
                        "max_diagonal_um": acceptance.max_diagonal_um },
        "noise_um": instrument.noise_um,
        "noise_is_assumed": instrument.stated.noise_um.is_none(),
        "set_up_min": design.times,
        "linear_named": keys(&design.axes_named()),
        "linear_u_um_per_m": design.u_um_per_m(&found.visits[0]),
        "best": found.forecast.map(letter),
        "best_second": found.second.map(letter),
        "decides": found.decides,
        "visits": visits.collect::<Vec<_>>(),
        "assumed": design.assumed(&found.visits[0]),
    })
}

fn of_visit(design: &Design<'_>, index: usize, visit: &Visit) -> Value {
    let (run, expected) = (&visit.variant.run, &visit.expected);
    json!({
        "name": letter(index),
        "change": visit.variant.change(&design.described),
        "steps": run.volume.steps,
        "runs": run.runs,
        "return_pass": run.bidirectional,
        "overrun": run.runs_over(),
        "linear": keys(&visit.variant.linear),
        "angles": visit.variant.angles.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "target_spacing_mm": visit.variant.target_spacing_mm(),
        "spacing_mm": design.other_grid(&visit.variant),
        "minutes": (10.0 * visit.minutes).round() / 10.0,
        "set_ups": Diagonal::ALL.len() + visit.variant.linear.len() + visit.variant.angles.len(),
        "mirror_circle_mm": visit.mirror.map(|mirror| mirror.circle_mm),
        "expanded_um": PerTerm::from_fn(|term| visit.expanded_um(term)),
        "squareness_expanded_um_per_m": PerPlane::from_fn(|plane| expected.metric.squareness(plane).expanded_um_per_m()),
        "together_expanded_um": visit.at_most_um,
        "second_passes": visit.chance,
        "not_determined": expected.missing(),
        "reversal_of": keys(&visit.reversals()),
        "reached": visit.reaches(design.job.acceptance),
        "shortcomings": visit.shortcomings(),
    })
}

fn keys(axes: &[Axis]) -> Vec<&'static str> {
    axes.iter().map(|axis| axis.key()).collect()
}

impl VisitPlan<'_> {
    /// The page for people: the answer, the variants, their U, what it rests on.
    fn screen(&self) -> Screen {
        let described = &self.visits[0];
        let assumed = self.design.assumed(described);
        let assumed: Vec<String> = assumed.iter().map(|a| wrapped(&a.to_string())).collect();
        let labels = described.expected.labels.iter();
        // The noise is that of the assumptions.
        let is_noise =
            |label: &&Finding| matches!(label.kind(), Some(SeparationFinding::NoiseIs { .. }));
        let labels: Vec<&Finding> = labels.filter(|label| !is_noise(label)).collect();
        let lines = [Some(self.answer()), self.decided(), Some(self.proposed()), self.likely()];
        let lines: Vec<String> = lines.into_iter().flatten().collect();
        let asked = self.design.noise_asked().into_iter().map(|finding| finding.to_string());
        let short = described.shortcomings().into_iter().map(|of| format!("as described: {of}"));
        Screen {
            figures: paragraphs(&[self.variants(), list("assumed", &assumed)]),
            findings: asked.chain(short).collect(),
            more: vec![More::new(
                labels.len(),
                ["label", "labels"],
                list("labels of the separation", &labels),
            )],
            ..Screen::of(format!("{}: {}", self.design.job.machine.name, lines.join("\n")))
        }
    }

    fn answer(&self) -> String {
        let described = &self.visits[0];
        let count = ErrorTerm::ALL.len() - described.expected.missing().len();
        let at_most = described.at_most_um.filter(|_| described.open.is_empty());
        let at_most = at_most.map(|um| format!(", the forecast is at most {um:.3} µm"));
        let keeps = match (self.limits(), described.reaches(self.design.job.acceptance)) {
            (None, _) => "; no acceptance is stated".to_string(),
            (Some(limits), true) => format!("; the acceptance ({limits}) is reached"),
            (Some(limits), false) => format!("; the acceptance ({limits}) is not reached"),
        };
        format!(
            "as described, {count} of 9 errors are determined{}{keeps}",
            at_most.unwrap_or_default()
        )
    }

    fn decided(&self) -> Option<String> {
        let parts = &self.decides;
        (!parts.is_empty()).then(|| format!("what decides: {}", in_words(parts)))
    }

    fn limits(&self) -> Option<String> {
        let acceptance = self.design.job.acceptance;
        let term = acceptance.max_deviation_um.map(|um| format!("{um} µm of every term"));
        let diagonal = acceptance.max_diagonal_um.map(|um| format!("{um} µm of every diagonal"));
        let limits: Vec<String> = term.into_iter().chain(diagonal).collect();
        (!limits.is_empty()).then(|| limits.join(", "))
    }

    fn proposed(&self) -> String {
        let aim = match self.limits() {
            None => "determines all wanted errors",
            Some(_) => "reaches the acceptance by its forecast",
        };
        self.quickest(self.forecast, "the quickest that", aim)
    }

    /// What will pass after loading, too.
    fn likely(&self) -> Option<String> {
        self.limits()?;
        let aim = "passes its second measurement with 80 % or more";
        Some(self.quickest(self.second, "the quickest that also", aim))
    }

    fn quickest(&self, found: Option<usize>, which: &str, aim: &str) -> String {
        found.map_or_else(
            || format!("no variant {aim}"),
            |index| format!("{which} {aim}: {}", self.named(index)),
        )
    }

    /// A visit by its letter, with what it needs of the tables.
    fn named(&self, index: usize) -> String {
        let visit = &self.visits[index];
        let (change, minutes) = (visit.variant.change(&self.design.described), visit.minutes);
        let grid = self
            .design
            .other_grid(&visit.variant)
            .map(|mm| format!("; change spacing_mm to x {}, y {}, z {}", mm.x, mm.y, mm.z));
        format!("{} ({change}), {minutes:.0} min{}", letter(index), grid.unwrap_or_default())
    }

    fn variants(&self) -> String {
        let row = |(index, visit): (usize, &Visit)| {
            let (name, change) = (letter(index), visit.variant.change(&self.design.described));
            let reversal = or_dash(Axis::letters(&visit.reversals()));
            let open = or_dash(joined(visit.expected.missing()));
            let chance =
                visit.chance.map_or("-".into(), |chance| format!("{:.0} %", 100.0 * chance));
            format!(
                "{name}\t{change}\t{:.0}\t{:.0}\t{open}\t{reversal}\t{}\t{chance}",
                visit.minutes,
                visit.variant.target_spacing_mm(),
                um(visit.at_most_um)
            )
        };
        table(
            "\tvisit\t>min\t>targets/mm\tnot determined\treversal of\t>at most/µm\t>second passes",
            self.visits.iter().enumerate().map(row),
        )
    }
}

/// a, b, c …
fn letter(index: usize) -> String {
    ('a'..='z').nth(index).map_or_else(|| index.to_string(), String::from)
}

fn or_dash(words: String) -> String {
    if words.is_empty() { "-".to_string() } else { words }
}
