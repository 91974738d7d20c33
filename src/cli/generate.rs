//! `nonius generate JOB -o DIR`, or `--compare`

mod compare;

use crate::cli::outcome::{Outcome, Output};
use crate::cli::plot::Plot;
use crate::cli::screen::{More, Screen, paragraphs, shell_word, wrapped};
use crate::cli::show;
use crate::control::controller::Role;
use crate::judge::conformity::Verdict;
use crate::kit::manifest::MANIFEST;
use crate::kit::{Inputs, Kit, cannot_emulate, emulator, generate, remarks};
use crate::page::{Curves, Locale, Picture, terms};
use crate::text::problem::Problems;
use crate::visit::files::Files;
use crate::visit::inputs;
use clap::Args;
use std::path::{Path, PathBuf};

// Options of `generate`.
#[derive(Args, Debug)]
#[command(mut_arg("output", |arg| arg.required_unless_present("compare").value_name("DIR")
    .help("Directory of the kit; must not exist yet, or must be empty")))]
pub(super) struct Options {
    /// The job (TOML); `-` = standard input
    job: PathBuf,
    /// Write nothing: what each backlash policy and spacing would leave, a line for each
    #[arg(long, conflicts_with = "output")]
    compare: bool,
    #[command(flatten)]
    output: Output,
    #[command(flatten)]
    plot: Plot,
}

pub(super) fn run(options: &Options, files: &dyn Files) -> Result<Outcome, Problems> {
    if options.compare {
        return compare::run(&inputs::read(files, &options.job)?, options.output.print);
    }
    let directory = options.output.free_directory(files)?;
    let inputs = inputs::read(files, &options.job)?;
    let kit = generate(&inputs)?;
    let own = kit.files.iter().map(|file| (file.path.as_str(), file.bytes.as_slice()));
    let next_steps = next_steps(&options.job, directory, &inputs, &kit);
    let (manifest, screen) = (kit.manifest_bytes()?, screen(&inputs, &kit));
    let outcome = options.output.deliver_directory(own, manifest, &screen, next_steps);
    let outcome = outcome.answering(kit.verdict == Verdict::Pass);
    let picture = |locale: Locale<'_>| picture(locale, &inputs, &kit);
    options.plot.beside(outcome, options.output.force, picture)
}

/// The nine errors as found and as forecast.
fn picture(locale: Locale<'_>, inputs: &Inputs, kit: &Kit) -> Result<Picture, Problems> {
    let (tables, state) = (&kit.compiled.tables, &kit.compiled.state);
    let control = emulator(&inputs.profile, tables, state).map_err(|e| cannot_emulate(&e))?;
    let curves = Curves {
        machine: inputs.machine(),
        loaded: Some((&kit.plan, control.as_ref())),
        as_left: None,
        limit_um: inputs.job.acceptance.max_deviation_um,
    };
    let heading = format!(
        "{}: {}, {}",
        inputs.job.machine.name,
        locale.words("nine_errors"),
        inputs.profile.name
    );
    terms(locale, &heading, &curves).map_err(|e| cannot_emulate(&e))
}

fn screen(inputs: &Inputs, kit: &Kit) -> Screen {
    let job = &inputs.job;
    let (model, compiled) = (inputs.as_measured(), &kit.compiled);
    let heading = format!(
        "machine {} - {}, measured {}",
        job.machine.name,
        inputs.profile.name,
        job.measurement.date.as_deref().unwrap_or("at a date not stated")
    );
    let verdict = show::verdict(kit.verdict, job, Some(&kit.forecast), false, &kit.manifest.doubts);
    let ways = kit.ways.iter().map(|way| format!("\n  {way}"));
    let ways = ways.chain(kit.manifest.what_decides.iter().map(|what| format!("\n{what}")));
    let verdict: String = std::iter::once(verdict).chain(ways).collect();
    let proofs = kit.files.iter().filter(|f| f.role == Role::SignProof);
    let proofs: Vec<&str> = proofs.map(|file| file.path.as_str()).collect();
    Screen {
        verdict: format!("{verdict}\n{heading}"),
        figures: paragraphs(&[
            show::forecast(&kit.forecast, &compiled.placements),
            show::squareness_and_reversals(model),
        ]),
        findings: remarks(&kit.plan, compiled, Some(&kit.forecast)),
        always: show::to_decide(&compiled.assumptions)
            .chain(show::assumed_signs(&compiled.assumptions, &proofs))
            .collect(),
        more: vec![
            More::new(
                compiled.placements.len(),
                ["table with its points and counts", "tables with their points and counts"],
                [show::placements(&compiled.placements), show::slopes(model)].join("\n"),
            ),
            show::assumptions(&compiled.assumptions),
            show::preconditions(&compiled.preconditions),
        ],
    }
}

/// What was written, and what to do with it.
fn next_steps(job: &Path, directory: &Path, inputs: &Inputs, kit: &Kit) -> String {
    let names = kit.files.iter().map(|file| file.path.as_str());
    let names: Vec<&str> = names.chain([MANIFEST]).collect();
    let mut lines = vec![format!("wrote {}: {}", directory.display(), names.join(", "))];
    lines.extend(checklist(kit).map(|name| {
        let path = directory.join(name);
        format!("print first: {}, step by step what to do at the machine", path.display())
    }));
    lines.push(before_loading(inputs, kit));
    lines.push(format!(
        "check the USB stick with: nonius verify {} --tables {}",
        shell_word(job),
        shell_word(directory)
    ));
    let wrapped: Vec<String> = lines.iter().map(|line| wrapped(line)).collect();
    wrapped.join("\n")
}

/// The checklist of a kit: of several that say the same the last one, which is the page to be printed.
fn checklist(kit: &Kit) -> Option<&str> {
    let mut files = kit.files.iter().rev();
    let found = files.find(|file| file.role == Role::Checklist);
    found.map(|file| file.path.as_str())
}

/// Archive, what switches off, and where the order of loading stands.
fn before_loading(inputs: &Inputs, kit: &Kit) -> String {
    let disable = kit.files.iter().find(|file| file.role == Role::Disable);
    let family = inputs.profile.family;
    let off = match disable {
        Some(file) => format!("{} switches off what the files replace", file.path),
        None => format!("no file of this kit switches off what is there{}", family.off_by_hand),
    };
    let order = match (checklist(kit), family.page) {
        (Some(file), Some(page)) => {
            format!("; order of loading and rollback: {file}, why: {page}")
        }
        (Some(file), None) => format!("; order of loading and rollback: {file}"),
        (None, Some(page)) => {
            format!("; order of loading: {page}, as this kit has no checklist")
        }
        (None, None) => String::new(),
    };
    format!("before loading: archive the control; {off}{order}")
}
