//! `nonius generate JOB --compare`: backlash policies and spacings side by side.

use crate::cli::outcome::{Outcome, Print};
use crate::cli::screen::{Screen, paragraphs, table};
use crate::cli::show;
use crate::inputs::job::{BacklashPolicy, one_for_all, policies_as_stated};
use crate::judge::conformity::Verdict;
use crate::kit::Inputs;
use crate::kit::alternatives::{Compared, compare};
use crate::quantity::axis::{Axis, PerAxis};
use crate::text::problem::Problems;
use serde_json::{Value, json};

pub(super) fn run(inputs: &Inputs, print: Print) -> Result<Outcome, Problems> {
    let compared = compare(inputs);
    let outcome = print.outcome(|| screen(inputs, &compared), || document(inputs, &compared))?;
    let own = compared.first().and_then(|own| own.result.as_ref().ok());
    Ok(outcome.answering(own.is_some_and(|own| own.verdict == Verdict::Pass)))
}

fn screen(inputs: &Inputs, compared: &[Compared]) -> Screen {
    let job = &inputs.job;
    let passes = |c: &&Compared| matches!(&c.result, Ok(made) if made.verdict == Verdict::Pass);
    let verdict = match job.acceptance.asks_nothing() {
        true => "no acceptance is stated in the job, so there is nothing to judge".to_string(),
        false => format!(
            "{} of {} keep the acceptance of the job",
            compared.iter().filter(passes).count(),
            compared.len()
        ),
    };
    let heading =
        "backlash\tspacing\t>tables\t>points\tterm\t>before\t>after\t>U\tdiag.\t>after\tverdict";
    let own = inputs.job.compensation.backlash;
    let refused = |c: &Compared| {
        let first = c.result.as_ref().err()?.iter().next()?;
        Some(format!("{}, {}: {}", policy(c, &own), c.spacing.word(), first.message))
    };
    Screen {
        verdict: format!(
            "{verdict}\nmachine {} - {}; nothing is written",
            job.machine.name, inputs.profile.name
        ),
        figures: paragraphs(&[format!(
            "{}\n  the first line is the job; spacing: as it asks, half and twice of it (or of its residual)\n  backlash: of all axes, or of the axis that is named with the others as in the job\n  term, diag.: of which most is left, µm; U: 95 %, - = not stated",
            table(heading, compared.iter().map(|c| row(c, &own)))
        )]),
        findings: compared.iter().filter_map(refused).collect(),
        ..Screen::default()
    }
}

/// The backlash policies of each axis.
type Policies = PerAxis<Option<BacklashPolicy>>;

/// The policy as a job states it; where one axis has another one than in the job, that of this axis.
fn policy(compared: &Compared, own: &Policies) -> String {
    let policies = &compared.backlash;
    let mut others = Axis::ALL.into_iter().filter(|axis| policies[*axis] != own[*axis]);
    match (*policies == Policies::default(), others.next(), others.next()) {
        (true, ..) => "not stated".to_string(),
        (_, Some(axis), None) if !one_for_all(policies) => {
            format!("{axis}: {}", policies_as_stated(&PerAxis::from_fn(|_| policies[axis])))
        }
        _ => policies_as_stated(policies),
    }
}

fn row(compared: &Compared, own: &Policies) -> String {
    let head = format!("{}\t{}", policy(compared, own), compared.spacing.word());
    let Ok(made) = &compared.result else {
        return format!("{head}\t-\t-\t-\t-\t-\t-\t-\t-\trefused");
    };
    let term = made.worst_term().map_or("-\t-\t-\t-".to_string(), |t| {
        let expanded = show::um(t.expanded_um);
        format!("{}\t{:.3}\t{:.3}\t{expanded}", t.name, t.before_um, t.after_um)
    });
    let diagonal = made.worst_diagonal();
    let diagonal =
        diagonal.map_or("-\t-".to_string(), |d| format!("{}\t{:.3}", d.name, d.after_um));
    let (tables, points) = (made.tables, made.points);
    format!("{head}\t{tables}\t{points}\t{term}\t{diagonal}\t{}", made.verdict.word())
}

fn document(inputs: &Inputs, compared: &[Compared]) -> Value {
    json!({
        "schema": 1,
        "machine": inputs.job.machine.name,
        "controller": inputs.profile.id,
        "compared": compared.iter().map(entry).collect::<Vec<_>>(),
    })
}

fn entry(compared: &Compared) -> Value {
    let backlash = PerAxis::from_fn(|axis| compared.backlash[axis].map(|p| p.word()));
    let spacing = compared.spacing.word();
    match &compared.result {
        Err(problems) => {
            let refused: Vec<&String> = problems.iter().map(|problem| &problem.message).collect();
            json!({ "backlash": backlash, "spacing": spacing, "refused": refused })
        }
        Ok(made) => json!({
            "backlash": backlash,
            "spacing": spacing,
            "tables": made.tables,
            "points": made.points,
            "verdict": made.verdict.word(),
            "term": made.worst_term(),
            "diagonal": made.worst_diagonal(),
        }),
    }
}
