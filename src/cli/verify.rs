//! `nonius verify JOB --tables DIR [--after FILE|JOB]`: the screen, and the document for scripts. With a second measurement
//! as found, forecast and as left stand beside each other.

use crate::cli::outcome::{Outcome, Shows};
use crate::cli::screen::{Screen, list, table};
use crate::cli::show::{self, PlaneFigures, planes, um};
use crate::control::claims::Assumption;
use crate::inputs::job::Job;
use crate::judge::active::HashedFile;
use crate::judge::after::{AfterMeasurement, ComparedLine, Comparison};
use crate::judge::causes::{Cause, Diagnosis};
use crate::judge::conformity::Verdict;
use crate::judge::findings::OfTerm;
use crate::judge::forecast::{Change, DiagonalForecast, Forecast, Grounds};
use crate::kit::visit_plan::{OpenFigures, WhatDecides};
use crate::kit::{Inputs, SecondLook, Verification, remarks, second_look};
use crate::machine::model::ErrorModel;
use crate::page::{Locale, Picture};
use crate::quantity::ErrorTerm;
use crate::text::{Finding, NamedEntries, Problems, Severity, of_severity};
use crate::visit::files::{Files, printed};
use crate::visit::inputs::{self, read_directory};
use crate::visit::second::{self, Second};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

// Options of `verify`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// The job (TOML); `-` = standard input
    job: PathBuf,
    /// Directory with the control's files
    #[arg(long, value_name = "DIR")]
    tables: PathBuf,
    /// A measurement with these tables active, against the forecast: an error table (CSV) or a job (TOML)
    #[arg(long, value_name = "FILE|JOB")]
    after: Option<PathBuf>,
    #[command(flatten)]
    shows: Shows,
}

pub(super) fn run(options: &Options, files: &dyn Files) -> Result<Outcome, Problems> {
    let inputs = inputs::read(files, &options.job)?;
    let page = Page::read(files, &inputs, &options.job, &options.tables, options.after.as_deref())?;
    let picture = |locale: Locale<'_>| page.picture(locale);
    let outcome = options.shows.outcome(files, || page.screen(), || page.document(), picture)?;
    Ok(outcome.answering(page.verdict() == Verdict::Pass))
}

/// Everything that goes on the page.
pub(super) struct Page<'a> {
    inputs: &'a Inputs,
    pub(super) verification: Verification<'a>,
    second: Option<(Second, SecondLook)>,
    pub(super) decides: Option<WhatDecides>,
}

/// What scripts read.
#[derive(Serialize)]
pub(super) struct Document<'a> {
    verdict: &'static str,
    scope: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    after: Option<&'a [HashedFile]>,
    terms: NamedEntries<String, Figures<'a>>,
    max_residual_um: Option<f64>,
    max_residual_expanded_um: Option<f64>,
    max_residual_at_most_um: Option<f64>,
    diagonals: Option<NamedEntries<String, Figures<'a>>>,
    squareness: NamedEntries<&'static str, PlaneFigures>,
    causes: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    diagnosis: Option<Option<&'a Diagnosis>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    what_decides: Option<&'a WhatDecides>,
    assumptions: &'a [Assumption],
    notes: Vec<Finding>,
}

/// A figure as measured and as forecast, or by both measurements.
#[derive(Serialize)]
#[serde(untagged)]
enum Figures<'a> {
    Forecast {
        before_um: f64,
        forecast_um: f64,
        u_um: Option<f64>,
        expanded_um: Option<f64>,
        at_most_um: Option<f64>,
        /// Of terms alone.
        #[serde(skip_serializing_if = "Option::is_none")]
        max_residual_um: Option<f64>,
    },
    Compared(&'a ComparedLine),
}

impl<'a> Page<'a> {
    /// The files of a directory, and of a measurement with them active.
    pub(super) fn read(
        files: &dyn Files,
        inputs: &'a Inputs,
        job: &Path,
        directory: &Path,
        after: Option<&Path>,
    ) -> Result<Page<'a>, Problems> {
        let second = after.map(|path| Second::read(files, inputs, path, directory)).transpose()?;
        let verification = read_directory(files, inputs, directory)?.verify(inputs)?;
        let second = second.map(|mut second| {
            second.ensure_active(inputs, &verification.loaded)?;
            if let Some(control) = &verification.effect {
                let before = inputs.machine().uncompensated;
                second.measurement.zeroed(before, control, &inputs.job);
            }
            let corrected = || second::corrected(files, inputs, job);
            let look = second_look(&verification, &second.measurement, corrected)?;
            Ok::<_, Problems>((second, look))
        });
        Ok(Page::of(verification, second.transpose()?).decided())
    }

    /// Tables, and a measurement with them active where there is one.
    fn of(verification: Verification<'a>, second: Option<(Second, SecondLook)>) -> Page<'a> {
        Page { inputs: verification.loaded.asked.inputs, verification, second, decides: None }
    }

    /// Tables that nobody has measured with.
    pub(super) fn of_tables(verification: Verification<'a>) -> Page<'a> {
        Page::of(verification, None).decided()
    }

    /// Those of a kit, of which what decides is known.
    pub(super) fn of_kit(verification: Verification<'a>, decides: Option<WhatDecides>) -> Page<'a> {
        Page { decides, ..Page::of(verification, None) }
    }

    fn decided(mut self) -> Page<'a> {
        self.decides = self.what_decides();
        self
    }
}

impl Page<'_> {
    pub(super) fn verdict(&self) -> Verdict {
        self.look().map_or(self.verification.verdict, |look| look.verdict)
    }

    fn look(&self) -> Option<&SecondLook> {
        self.second.as_ref().map(|(_, look)| look)
    }

    /// What the figures are of: the machine as left, else the forecast.
    fn judged(&self) -> Option<&Forecast> {
        self.look().map(|look| &look.comparison.as_left).or(self.verification.forecast.as_ref())
    }

    pub(super) fn doubts(&self) -> &[Finding] {
        self.look().map_or(&self.verification.doubts, |look| &look.doubts)
    }

    /// What keeps the limit from being decided; where something else speaks against a pass, that comes first.
    fn what_decides(&self) -> Option<WhatDecides> {
        let is_sound = self.verification.agrees() && self.doubts().is_empty();
        let forecast = self.verification.forecast.as_ref().filter(|_| is_sound)?;
        let Some((second, look)) = &self.second else {
            return self.inputs.judged(forecast).what_decides();
        };
        if look.diagnosis.as_ref().is_some_and(|found| !found.as_forecast) {
            return None;
        }
        let job = &self.inputs.job;
        let judged = OpenFigures {
            job: &Job { acceptance: job.acceptance, ..second.job.as_ref().unwrap_or(job).clone() },
            errors: second.errors.as_ref(),
            model: self.as_left()?,
            figures: &look.comparison.as_left,
            expected: Some(forecast),
        };
        judged.what_decides()
    }

    /// The verdict, then what the data say of the causes.
    pub(super) fn screen(&self) -> Screen {
        let (compiled, own) =
            (&self.verification.loaded.asked.compiled, &self.verification.notes());
        let forecast = self.verification.forecast.as_ref();
        let table = |forecast| show::forecast(forecast, &compiled.placements);
        let (figures, findings) = match &self.second {
            None => {
                let remarks = remarks(&self.verification.loaded.asked.plan, compiled, forecast);
                (forecast.map(table), [show::notes(own), remarks].concat())
            }
            Some((second, look)) => {
                let notes = of_severity(&look.comparison.findings, Severity::Note);
                let notes = notes.iter().chain(&second.notes);
                (Some(lines(&look.comparison)), show::notes(notes.chain(own)))
            }
        };
        Screen {
            verdict: self.head().join("\n"),
            figures: figures.unwrap_or_default(),
            findings,
            always: self.always(),
            more: vec![show::assumptions(self.assumptions())],
        }
    }

    /// What is asked of whoever measured first, and whether the signs of the control are known.
    fn always(&self) -> Vec<String> {
        let signs = match self.sign_shown() {
            Some(date) => vec![format!("sign shown by the second measurement{date}")],
            None => show::assumed_signs(self.assumptions(), &[]),
        };
        let notes = match self.second {
            None => self.verification.loaded.asked.compiled.notes.as_slice(),
            Some(_) => &[],
        };
        show::questions(notes).chain(signs).collect()
    }

    /// The nine errors as found, as forecast, as left.
    pub(super) fn picture(&self, locale: Locale<'_>) -> Picture {
        let effect = self.verification.effect.as_ref();
        let mut picture = show::nine_errors(locale, self.inputs, effect, self.as_left());
        if self.is_simulated() {
            picture.note = format!("{}; {}", locale.words("simulated"), picture.note);
        }
        picture
    }

    /// `date` and protocol of the second measurement, as its job states them.
    pub(super) fn protocol_after(&self) -> Vec<(String, String)> {
        self.second.as_ref().map(|(second, _)| second.protocol()).unwrap_or_default()
    }

    /// What the verdict is made of; asked is what the tables were made for, too.
    pub(super) fn grounds(&self) -> Grounds {
        let of = |judged: &Forecast| judged.grounds(&self.inputs.job);
        let mut grounds = self.judged().map(of).unwrap_or_default();
        if !grounds.terms.is_empty() {
            let asked = self.verification.forecast.iter().flat_map(|of| &of.terms);
            let all: Vec<ErrorTerm> = asked.map(|of| of.term).chain(grounds.terms).collect();
            grounds.terms = ErrorTerm::ALL.into_iter().filter(|of| all.contains(of)).collect();
        }
        grounds
    }

    fn squareness(&self) -> NamedEntries<&'static str, PlaneFigures> {
        let errors = self.second.as_ref();
        let errors = errors.and_then(|(second, _)| second.errors.as_ref());
        let left = self.as_left().map(|model| (model, errors));
        planes((self.inputs.as_measured(), Some(&self.inputs.errors)), Some(left))
    }

    /// The errors as left, where they were measured.
    fn as_left(&self) -> Option<&ErrorModel> {
        match self.second.as_ref().map(|(second, _)| &second.measurement) {
            Some(AfterMeasurement::Errors(model)) => Some(model),
            _ => None,
        }
    }

    fn head(&self) -> Vec<String> {
        let disagreements = self.verification.disagreements();
        let directory = self.verification.loaded.directory.as_deref();
        let tables = match directory {
            None => "its tables by this job, in no file".to_string(),
            Some(from) => format!("tables read from {}", printed(Path::new(from))),
        };
        let agreement = directory.map(|_| match disagreements.as_slice() {
            [] => "job and tables agree".to_string(),
            differences => list("job and tables DISAGREE:", differences),
        });
        let verdict = show::verdict(
            self.verdict(),
            &self.inputs.job,
            &self.grounds(),
            !disagreements.is_empty(),
            self.doubts(),
        );
        let heading =
            format!("{} - {}, {tables}", self.inputs.job.machine.name, self.inputs.profile.name);
        let mut lines: Vec<String> = self.rehearsal().into_iter().collect();
        lines.push(verdict);
        lines.extend(self.decides.as_ref().map(ToString::to_string));
        lines.extend(self.look().into_iter().flat_map(explanation));
        lines.extend(agreement.into_iter().chain([heading]));
        lines.extend(self.second.as_ref().map(|(second, _)| second.files_words()));
        lines
    }

    /// Whether either measurement was simulated.
    pub(super) fn is_simulated(&self) -> bool {
        self.simulated().contains(&true)
    }

    /// Whether each was.
    fn simulated(&self) -> [bool; 2] {
        let first = self.inputs.as_measured().remarks.simulated().next();
        let second = self.second.as_ref();
        [first.is_some(), second.is_some_and(|(second, _)| second.measurement.is_simulated())]
    }

    /// Said where both measurements were simulated.
    fn rehearsal(&self) -> Option<String> {
        let words = "REHEARSAL: both measurements were simulated, this says nothing of a machine";
        (self.simulated() == [true; 2]).then(|| words.to_string())
    }

    /// What was assumed of the control matters until a measurement has shown that every mechanism acts as
    /// forecast, whatever the verdict is.
    pub(super) fn assumptions(&self) -> &[Assumption] {
        let diagnosis = self.look().and_then(|look| look.diagnosis.as_ref());
        match diagnosis.is_some_and(|found| found.shows_signs && !found.hides_tables) {
            true => &[],
            false => &self.verification.loaded.asked.compiled.assumptions,
        }
    }

    /// Where the second measurement has shown a sign that was assumed: ` of` its date, empty where that is not stated.
    pub(super) fn sign_shown(&self) -> Option<String> {
        let assumed = &self.verification.loaded.asked.compiled.assumptions;
        let is_shown = self.assumptions().is_empty() && assumed.iter().any(Assumption::is_sign);
        let (second, _) = self.second.as_ref().filter(|_| is_shown)?;
        let date = second.protocol().into_iter().find(|(key, _)| key == "date");
        Some(date.map_or_else(String::new, |(_, date)| format!(" of {date}")))
    }

    pub(super) fn document(&self) -> Document<'_> {
        let compiled = &self.verification.loaded.asked.compiled;
        let forecast = self.verification.forecast.as_ref();
        let grounds = self.grounds();
        let stated = self.verification.disagreements();
        let causes = stated.iter().map(ToString::to_string);
        let causes = causes.chain(grounds.misses.iter().map(ToString::to_string));
        let causes = causes.chain(self.doubts().iter().map(ToString::to_string));
        let scope = self.rehearsal().into_iter();
        let scope = scope.chain(show::scope(&self.inputs.job, &grounds));
        let terms = forecast.iter().flat_map(|of| &of.terms);
        let terms = terms.map(|of| (of.term.to_string(), Figures::forecast(&of.change, true)));
        let diagonal =
            |of: &DiagonalForecast| (of.diagonal.to_string(), Figures::forecast(&of.change, false));
        let page = Document {
            verdict: self.verdict().word(),
            scope: scope.chain(self.always()).collect(),
            after: None,
            terms: terms.collect(),
            max_residual_um: forecast.map(Forecast::max_residual_um),
            max_residual_expanded_um: self.judged().and_then(Forecast::max_expanded_um),
            max_residual_at_most_um: self.judged().and_then(Forecast::all_at_most_um),
            diagonals: forecast.map(|of| of.diagonals.iter().map(diagonal).collect()),
            squareness: self.squareness(),
            causes: causes.collect(),
            diagnosis: None,
            what_decides: self.decides.as_ref(),
            assumptions: &compiled.assumptions,
            notes: [self.verification.notes(), compiled.notes.clone()].concat(),
        };
        let Some((second, look)) = &self.second else {
            let worsened = forecast.map(Forecast::worsened).unwrap_or_default();
            let notes = [page.notes, worsened].concat();
            return Document { notes, ..page };
        };
        let comparison = &look.comparison;
        let own = of_severity(&comparison.findings, Severity::Note);
        let after = comparison.terms.iter().filter_map(|line| line.after_um);
        Document {
            after: Some(&second.hashes),
            terms: Figures::compared(&comparison.terms),
            max_residual_um: after.reduce(f64::max),
            diagonals: Some(Figures::compared(&comparison.diagonals)),
            causes: [page.causes, explanation(look)].concat(),
            diagnosis: Some(look.diagnosis.as_ref()),
            notes: [&own[..], &second.notes, &page.notes].concat(),
            ..page
        }
    }
}

/// What the data say of the causes, one line each.
fn explanation(look: &SecondLook) -> Vec<String> {
    let Some(found) = &look.diagnosis else {
        return Vec::new();
    };
    let off = format!(
        "as left is {:.3} µm off the forecast (root mean square, with the zero of each term left free); sigma {:.3} µm, {}",
        found.off_um, found.basis.sigma_um, found.basis.words
    );
    if found.as_forecast {
        let words = match found.hides_tables {
            true => format!(
                "whether the tables act does not show: as left agrees with the forecast, and as well with the machine without tables ({off}); state the noise of both measurements (`noise_um`; `u_um_per_m` of linear axes)"
            ),
            false => format!(
                "the tables act as forecast, no fault shows ({off}): the residual is that of the plan, or noise"
            ),
        };
        return (look.verdict != Verdict::Pass).then_some(words).into_iter().collect();
    }
    let said = |cause: &Cause| {
        let kind = cause.kind.to_uppercase();
        format!("{kind}: {} (leaves {:.3} µm unexplained)", cause.words, cause.left_um)
    };
    let likely = match (found.causes.as_slice(), &look.lost_motion) {
        ([], Some(words)) => format!(
            "LOST MOTION, no fault of the tables: without regard to the direction as left is as forecast; {words}"
        ),
        ([], None) => {
            "no single cause of those tried explains it: unknown, or several at once".to_string()
        }
        ([only], _) => format!("likely cause: {}", said(only)),
        (several, _) => list(
            "likely causes, which these data cannot tell apart:",
            &several.iter().map(said).collect::<Vec<_>>(),
        ),
    };
    let mut lines = vec![format!("NOT AS FORECAST: {off}")];
    lines.extend(likely.lines().map(str::to_string));
    let is_off = |term: &&Finding| !matches!(term.kind(), Some(OfTerm::AsForecast { .. }));
    let off = found.by_term.iter().filter(is_off).filter(|_| look.lost_motion.is_none());
    lines.extend(off.map(|words| format!("  {words}")));
    lines.extend(found.decides.iter().map(|words| format!("to decide: {words}")));
    lines
}

impl Figures<'_> {
    /// As measured and as forecast.
    fn forecast(of: &Change, is_term: bool) -> Figures<'static> {
        Figures::Forecast {
            before_um: of.before_um,
            forecast_um: of.after_um,
            u_um: of.u_um,
            expanded_um: of.expanded_um,
            at_most_um: of.at_most_um,
            max_residual_um: is_term.then_some(of.after_um),
        }
    }

    fn compared(lines: &[ComparedLine]) -> NamedEntries<String, Figures<'_>> {
        lines.iter().map(|line| (line.name.clone(), Figures::Compared(line))).collect()
    }
}

fn lines(comparison: &Comparison) -> String {
    let measured = |um| show::figure(um, "not measured");
    let row = |what: &str, line: &ComparedLine| {
        let at_most =
            line.after_um.map_or_else(|| "-".to_string(), |_| show::stated(line.at_most_um));
        let (before, after) = (measured(line.before_um), measured(line.after_um));
        let (forecast, off) = (um(line.forecast_um), um(line.difference_um));
        format!("{what}{}\t{before}\t{forecast}\t{after}\t{at_most}\t{off}", line.name)
    };
    let terms = comparison.terms.iter().map(|line| row("", line));
    let diagonals = comparison.diagonals.iter().map(|line| row("diagonal ", line));
    let all = show::largest_of_all(&comparison.as_left);
    let all = all.map(|(um, at_most)| format!("{}\t\t\t{um}\t{at_most}\t", show::OF_ALL));
    let heading = "term\t>as found/µm\t>forecast/µm\t>as left/µm\t>at most/µm\t>off forecast/µm";
    format!(
        "{}\n  terms: largest deviation, zero at the reference; diagonals: max - min; at most: of as left;\n  off forecast: largest difference of as left and forecast at a measured position{}",
        table(heading, terms.chain(all).chain(diagonals)),
        show::at_most(&comparison.as_left)
    )
}
