//! As found, forecast, as left: the page and the document.

use super::records::First;
use super::second::Second;
use super::{absent, agreement, heading};
use crate::cli::outcome::Outcome;
use crate::cli::screen::{Detail, More, Screen};
use crate::cli::show::{self, Column};
use crate::cli::{Answer, Format};
use crate::control::claims::Assumption;
use crate::inputs::job::{Job, MeasuredData};
use crate::judge::after::{
    AfterMeasurement, Comparison, Control, Line, Observation, compare, observations,
    unseen_reversal,
};
use crate::judge::causes::{Cause, Corrected, Diagnosis, Question, diagnose};
use crate::judge::conformity::Verdict;
use crate::judge::findings::words_of;
use crate::judge::forecast::Forecast;
use crate::kit::manifest::picometres;
use crate::kit::{Inputs, Verification, emulator};
use crate::quantity::axis::{Direction, PerAxis};
use crate::text::finding::Severity;
use crate::text::problem::{Problem, Problems};
use serde_json::{Map, Value, json};
use std::path::Path;

/// Everything that goes on the page.
struct Page<'a> {
    inputs: &'a Inputs,
    verification: &'a Verification,
    second: &'a Second,
    comparison: Comparison,
    diagnosis: Option<Diagnosis>,
    /// Lost motion that the first measurement could not see, where it alone is off the forecast.
    lost_motion: Option<String>,
    verdict: Verdict,
}

pub(super) fn answer(
    first: First<'_>,
    directory: &Path,
    verification: &Verification,
    second: &Second,
    (format, detail): (Format, Detail),
) -> Result<Outcome, Problems> {
    second.ensure_active(first.inputs, verification)?;
    let page = page(first, verification, second)?;
    let outcome = match format {
        Format::Json => Outcome::json(&page.document())?,
        Format::Text => Outcome::text(&page.screen(directory).page(detail)),
    };
    Ok(outcome.answering(Answer::yes(page.verdict == Verdict::Pass)))
}

fn page<'a>(
    first: First<'a>,
    verification: &'a Verification,
    second: &'a Second,
) -> Result<Page<'a>, Problems> {
    let inputs = first.inputs;
    let plan = &verification.plan;
    let control = emulator(&inputs.profile, &verification.found, &verification.state)
        .and_then(|emulator| Control::new(&inputs.model, plan, emulator.as_ref()));
    let comparison = compare(
        inputs.machine(),
        plan,
        control.as_ref().ok(),
        verification.forecast.as_ref(),
        &second.measurement,
        &inputs.job,
    )?;
    let mut diagnosis = None;
    let mut lost_motion = None;
    let measured = comparison.is_measured();
    if let (true, Ok(control), Some(forecast)) = (measured, &control, &verification.forecast) {
        let diagnosed = |measured: &AfterMeasurement, corrected: &[Corrected]| {
            let seen = observations(&inputs.model, measured);
            let question = question(inputs, verification, forecast, control, &seen);
            diagnose(&Question {
                corrected,
                ..question
            })
        };
        let found = causes_of(first, &second.measurement, diagnosed)?;
        if !found.as_forecast && found.causes.is_empty() {
            let as_recorded = |measured: &AfterMeasurement| diagnosed(measured, &[]);
            lost_motion = unseen(inputs, &second.measurement, as_recorded)?;
        }
        diagnosis = Some(found);
    }
    let verdict = judged(inputs, verification, &comparison, diagnosis.as_ref());
    Ok(Page {
        inputs,
        verification,
        second,
        comparison,
        diagnosis,
        lost_motion,
        verdict,
    })
}

/// The causes; slips of the first records are tried only where as left is not as forecast, since
/// each takes a separation of its own.
fn causes_of(
    first: First<'_>,
    measured: &AfterMeasurement,
    diagnosed: impl Fn(&AfterMeasurement, &[Corrected]) -> Result<Diagnosis, Problem>,
) -> Result<Diagnosis, Problems> {
    let as_recorded = diagnosed(measured, &[])?;
    if as_recorded.as_forecast {
        return Ok(as_recorded);
    }
    match first.corrected()?.as_slice() {
        [] => Ok(as_recorded),
        corrected => Ok(diagnosed(measured, corrected)?),
    }
}

/// Lost motion that the first measurement could not see, if as left is as forecast without it.
fn unseen(
    inputs: &Inputs,
    measured: &AfterMeasurement,
    diagnosed: impl Fn(&AfterMeasurement) -> Result<Diagnosis, Problem>,
) -> Result<Option<String>, Problem> {
    let AfterMeasurement::Errors(model) = measured else {
        return Ok(None);
    };
    let Some(reversal) = unseen_reversal(&inputs.model, model) else {
        return Ok(None);
    };
    let without = diagnosed(&AfterMeasurement::Errors(Box::new(reversal.without)))?;
    Ok(without.as_forecast.then_some(reversal.words))
}

fn question<'a>(
    inputs: &'a Inputs,
    verification: &Verification,
    forecast: &Forecast,
    control: &'a Control,
    seen: &'a [Observation],
) -> Question<'a> {
    let axis = |axis| inputs.job.machine.axes[axis];
    let counts = verification.compiled.placements.iter().map(|p| p.count_um);
    Question {
        before: &inputs.model,
        under_tables: inputs.under_tables.as_ref(),
        corrected: &[],
        control,
        seen,
        homing: PerAxis::from_fn(|a| axis(a).map_or(Direction::Plus, |a| a.homing())),
        reference_mm: PerAxis::from_fn(|a| axis(a).map_or(0.0, |a| a.reference.mm())),
        alpha_per_k: alpha_per_k(&inputs.job),
        count_um: counts.fold(0.0, f64::max),
        forecast_um: forecast.max_residual_um(),
        display: inputs.profile.display.as_ref().map(|f| f.value.as_str()),
    }
}

/// Steel, where the job states no scale's expansion, 1/K.
const STEEL_PER_K: f64 = 11.5e-6;

fn alpha_per_k(job: &Job) -> PerAxis<f64> {
    let material = match &job.measurement.data {
        MeasuredData::Diagonals(measurement) => measurement.material,
        MeasuredData::Errors(_) => None,
    };
    let stated = |axis| material?.axes[axis].map(|scale| scale.alpha_per_k);
    PerAxis::from_fn(|axis| stated(axis).unwrap_or(STEEL_PER_K))
}

/// The as-left figures against the acceptance; what is missing or doubtful decides nothing in
/// favour, and files that differ from the job fail. Without any limit a machine that is not as
/// forecast is not passed either.
fn judged(
    inputs: &Inputs,
    verification: &Verification,
    comparison: &Comparison,
    diagnosis: Option<&Diagnosis>,
) -> Verdict {
    if !verification.agrees() {
        return Verdict::Fail;
    }
    if !comparison.is_measured() {
        return Verdict::Undecided;
    }
    let asked = inputs.job.acceptance;
    let verdict = comparison.as_left.verdict(asked);
    let unknown = asked.max_deviation_um.is_some() && !comparison.missing.is_empty();
    let no_limit = asked.max_deviation_um.is_none() && asked.max_diagonal_um.is_none();
    let off = no_limit && diagnosis.is_some_and(|found| !found.as_forecast);
    let doubtful = !words_of(&comparison.findings, Severity::Doubt).is_empty()
        || !beside(verification).is_empty();
    if unknown || off || doubtful {
        return verdict.max(Verdict::Undecided);
    }
    verdict
}

/// What acts beside the tables.
fn beside(verification: &Verification) -> Vec<String> {
    words_of(&verification.findings, Severity::Doubt)
}

impl Page<'_> {
    /// Doubts, what acts beside the tables, and what the limit asks for and was not measured.
    fn doubts(&self) -> Vec<String> {
        let beside = &beside(self.verification);
        let mut doubts = words_of(&self.comparison.findings, Severity::Doubt);
        doubts.extend(beside.iter().cloned());
        let missing: Vec<String> = self
            .comparison
            .missing
            .iter()
            .map(ToString::to_string)
            .collect();
        if self.inputs.job.acceptance.max_deviation_um.is_some() && !missing.is_empty() {
            doubts.push(format!(
                "not measured afterwards, so nothing is known of what is left: {}",
                missing.join(", ")
            ));
        }
        doubts
    }

    /// Said where both measurements were simulated.
    fn rehearsal(&self) -> String {
        let first = self.inputs.as_measured().remarks.simulated().next();
        match first.is_some() && self.second.measurement.is_simulated() {
            true => "REHEARSAL: both measurements were simulated, this says nothing of a machine\n",
            false => "",
        }
        .to_string()
    }

    fn verdict_words(&self) -> String {
        let rehearsal = self.rehearsal();
        rehearsal
            + &show::verdict(
                self.verdict,
                &self.inputs.job,
                Some(&self.comparison.as_left),
                !self.verification.agrees(),
                &self.doubts(),
            )
    }

    /// The verdict, then what the data say of the causes.
    fn screen(&self, directory: &Path) -> Screen {
        let verification = self.verification;
        let explained = self.diagnosis.as_ref().map(|found| self.explained(found));
        let verdict: Vec<String> = std::iter::once(self.verdict_words())
            .chain(explained.filter(|words| !words.is_empty()))
            .chain([
                agreement(verification),
                heading(self.inputs, directory),
                self.measured_after(),
            ])
            .collect();
        let notes = [
            words_of(&self.comparison.findings, Severity::Note),
            self.second.notes.clone(),
            verification.notes(),
        ];
        let assumptions = self.assumptions();
        Screen {
            verdict: verdict.join("\n"),
            figures: vec![lines(&self.comparison)],
            findings: absent(&notes.concat()),
            always: show::assumed_signs(assumptions, &[]),
            more: vec![More {
                count: show::effective(assumptions),
                what: "assumptions",
                text: show::assumptions(assumptions),
            }],
        }
    }

    /// What was assumed of the control matters until a measurement has shown it.
    fn assumptions(&self) -> &[Assumption] {
        let diagnosis = self.diagnosis.as_ref();
        let shown = diagnosis.is_some_and(|found| found.as_forecast);
        match shown && self.verdict == Verdict::Pass {
            true => &[],
            false => &self.verification.compiled.assumptions,
        }
    }

    fn explained(&self, found: &Diagnosis) -> String {
        self.explanation(found).join("\n")
    }

    /// What the data say of the causes, one line each.
    fn explanation(&self, found: &Diagnosis) -> Vec<String> {
        let off = format!(
            "as left is {:.3} µm off the forecast (root mean square, with the zero of each term left free); sigma {:.3} µm, {}",
            found.off_um, found.basis.sigma_um, found.basis.words
        );
        if found.as_forecast {
            return match self.verdict {
                Verdict::Pass => Vec::new(),
                _ => vec![format!(
                    "the tables act as forecast, no fault shows ({off}): what is left was left by the plan, or lies within U"
                )],
            };
        }
        let mut lines = vec![format!("NOT AS FORECAST: {off}")];
        match found.causes.as_slice() {
            [] => lines.push(match &self.lost_motion {
                Some(words) => format!("LOST MOTION, no fault of the tables: without regard to the direction as left is as forecast; {words}"),
                None => "no single cause of those tried explains it: unknown, or several at once".to_string(),
            }),
            [only] => lines.push(format!("likely cause: {}", said(only))),
            several => {
                lines.push("likely causes, which these data cannot tell apart:".to_string());
                lines.extend(several.iter().map(|cause| format!("  - {}", said(cause))));
            }
        }
        let by_term = found.by_term.iter().filter(|_| self.lost_motion.is_none());
        lines.extend(by_term.map(|words| format!("  {words}")));
        lines.extend(
            found
                .decides
                .iter()
                .map(|words| format!("to decide: {words}")),
        );
        lines
    }

    fn measured_after(&self) -> String {
        let names: Vec<&str> = self
            .second
            .hashes
            .iter()
            .map(|file| file.path.as_str())
            .collect();
        format!(
            "measured afterwards, with the tables active: {}",
            names.join(", ")
        )
    }

    fn document(&self) -> Value {
        let verification = self.verification;
        let misses = self.comparison.as_left.misses(self.inputs.job.acceptance);
        let causes: Vec<String> = verification
            .disagreements()
            .into_iter()
            .chain(misses)
            .chain(self.doubts())
            .chain(
                self.diagnosis
                    .iter()
                    .flat_map(|found| self.explanation(found)),
            )
            .collect();
        let notes = [
            words_of(&self.comparison.findings, Severity::Note),
            self.second.notes.clone(),
            verification.notes(),
            verification.compiled.notes.clone(),
        ]
        .concat();
        json!({
            "schema": 1,
            "verdict": self.verdict.word(),
            "after": self.second.hashes,
            "terms": figures(&self.comparison.terms),
            "max_residual_um": largest(&self.comparison.terms),
            "max_residual_expanded_um": self.comparison.as_left.max_expanded_um().map(picometres),
            "diagonals": figures(&self.comparison.diagonals),
            "causes": causes,
            "diagnosis": self.diagnosis.as_ref().map(diagnosis),
            "assumptions": verification.compiled.assumptions,
            "notes": notes,
        })
    }
}

fn said(cause: &Cause) -> String {
    format!(
        "{}: {} (leaves {:.3} µm unexplained)",
        cause.kind.to_uppercase(),
        cause.words,
        cause.left_um
    )
}

fn diagnosis(found: &Diagnosis) -> Value {
    let cause = |cause: &Cause| {
        json!({
            "kind": cause.kind,
            "words": cause.words,
            "fitted": cause.fitted.iter().map(|value| picometres(*value)).collect::<Vec<f64>>(),
            "left_um": picometres(cause.left_um),
        })
    };
    json!({
        "as_forecast": found.as_forecast,
        "off_forecast_um": picometres(found.off_um),
        "sigma_um": picometres(found.basis.sigma_um),
        "sigma_from": found.basis.words,
        "values": found.basis.values,
        "curves": found.basis.curves,
        "causes": found.causes.iter().map(cause).collect::<Vec<Value>>(),
        "by_term": found.by_term,
        "decides": found.decides,
    })
}

/// The largest as-left figure of the terms, else nothing.
fn largest(lines: &[Line]) -> Option<f64> {
    let after = lines.iter().filter_map(|line| line.after_um);
    after.reduce(f64::max).map(picometres)
}

fn figures(lines: &[Line]) -> Value {
    let mut document = Map::new();
    for line in lines {
        let um = |value: Option<f64>| value.map(picometres);
        document.insert(
            line.name.clone(),
            json!({
                "before_um": um(line.before_um),
                "forecast_um": um(line.forecast_um),
                "after_um": um(line.after_um),
                "u_um": um(line.u_um),
                "expanded_um": um(line.expanded_um),
                "max_residual_um": um(line.after_um),
                "difference_um": um(line.difference_um),
            }),
        );
    }
    Value::Object(document)
}

fn lines(comparison: &Comparison) -> String {
    let columns = [
        Column::Left("term"),
        Column::Right("as found/µm"),
        Column::Right("forecast/µm"),
        Column::Right("as left/µm"),
        Column::Right("U(95 %)/µm"),
        Column::Right("off forecast/µm"),
    ];
    let terms = comparison
        .terms
        .iter()
        .map(|line| row(line.name.clone(), line));
    let diagonals = comparison.diagonals.iter();
    let diagonals = diagonals.map(|line| row(format!("diagonal {}", line.name), line));
    let together = show::together(&comparison.as_left);
    let together = together.map(|line| format!("\n{line}"));
    format!(
        "{}\n  terms: largest deviation, zero at the reference; diagonals: max - min; U of as left;\n  off forecast: largest difference of as left and forecast at a measured position{}",
        show::table(&columns, terms.chain(diagonals)),
        together.unwrap_or_default()
    )
}

fn row(name: String, line: &Line) -> Vec<String> {
    let um = |value: Option<f64>| value.map_or_else(|| "-".to_string(), |um| format!("{um:.3}"));
    let measured = |value: Option<f64>| match value {
        None => "not measured".to_string(),
        some => um(some),
    };
    let expanded = match line.after_um {
        None => "-".to_string(),
        Some(_) => show::expanded(line.expanded_um),
    };
    vec![
        name,
        measured(line.before_um),
        um(line.forecast_um),
        measured(line.after_um),
        expanded,
        um(line.difference_um),
    ]
}
