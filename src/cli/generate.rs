//! `nonius generate JOB -o DIR`, or `--compare`

use crate::cli::outcome::{Outcome, Output, Plot, Print};
use crate::cli::screen::{More, Screen, paragraphs, shell_word, table, wrapped};
use crate::cli::show;
use crate::cli::verify::Page;
use crate::control::controller::Role;
use crate::inputs::job::{one_for_all, policies_as_stated};
use crate::judge::conformity::Verdict;
use crate::kit::alternatives::{Compared, Policies, compare};
use crate::kit::manifest::MANIFEST;
use crate::kit::{self, Inputs, Kit, generate, remarks};
use crate::quantity::{Axis, PerAxis};
use crate::text::Problems;
use crate::visit::files::{Files, printed};
use crate::visit::inputs;
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

// Options of `generate`.
#[derive(Args, Debug)]
#[command(mut_arg("output", |arg| arg.required_unless_present_any(["compare", "dry_run"]).value_name("DIR")
    .help("Directory of the kit; must not exist yet, or must be empty")))]
pub(super) struct Options {
    /// The job (TOML); `-` = standard input
    job: PathBuf,
    /// Write nothing: what each backlash policy and spacing would leave, a line for each
    #[arg(long, conflicts_with = "output")]
    compare: bool,
    /// Write nothing: what `verify` will say of the kit, by its tables alone
    #[arg(long, conflicts_with_all = ["output", "compare"])]
    dry_run: bool,
    /// For scripts that make many kits; whoever loads one needs its checklist
    #[arg(long, conflicts_with_all = ["compare", "dry_run"])]
    without_checklist: bool,
    #[command(flatten)]
    output: Output,
    #[command(flatten)]
    plot: Plot,
}

pub(super) fn run(options: &Options, files: &dyn Files) -> Result<Outcome, Problems> {
    if options.compare {
        return side_by_side(&inputs::read(files, &options.job)?, options.output.print);
    }
    if options.dry_run {
        let inputs = inputs::read(files, &options.job)?;
        let page = Page::of_tables(kit::forecast(&inputs)?);
        let outcome = options.output.print.outcome(|| page.screen(), || page.document())?;
        let outcome = outcome.answering(page.verdict() == Verdict::Pass);
        return options
            .plot
            .beside(files, outcome, options.output.force, |locale| page.picture(locale));
    }
    let directory = options.output.free_directory(files)?;
    let mut inputs = inputs::read(files, &options.job)?;
    if options.without_checklist {
        inputs.profile.files.retain(|file| file.role != Role::Checklist);
    }
    let kit = generate(&inputs)?;
    let own = kit.files.iter().map(|file| (file.path.as_str(), file.bytes.as_slice()));
    let next_steps = next_steps(&options.job, directory, &inputs, &kit);
    let (manifest, print) = (kit.manifest_bytes()?, options.output.print);
    let outcome = print.as_it_is(|| screen(&inputs, &kit), || &kit.manifest)?;
    let outcome =
        options.output.deliver_files(files, outcome, own, (MANIFEST, &manifest), next_steps)?;
    let outcome = outcome.answering(kit.verdict == Verdict::Pass);
    options.plot.beside(files, outcome, options.output.force, |locale| {
        show::nine_errors(locale, &inputs, Some(&kit.effect), None)
    })
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
    let verdict =
        show::verdict(kit.verdict, job, &kit.forecast.grounds(job), false, &kit.manifest.doubts);
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
        always: show::questions(&compiled.notes)
            .chain(show::to_decide(&compiled.assumptions))
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
    let mut lines = vec![format!("wrote {}: {}", printed(directory), names.join(", "))];
    lines.extend(checklist(kit).map(|name| {
        let path = directory.join(name);
        format!("print first: {}, step by step what to do at the machine", printed(&path))
    }));
    lines.push(before_loading(inputs, kit));
    let (job, kit) = (shell_word(job), shell_word(directory));
    lines.push(format!("check the USB stick with: nonius verify {job} --tables {kit}"));
    wrapped(&lines.join("\n"))
}

/// The checklist of a kit: of several that say the same the last one, which is the page to be printed.
fn checklist(kit: &Kit) -> Option<&str> {
    let mut files = kit.files.iter().rev();
    files.find(|file| file.role == Role::Checklist).map(|file| file.path.as_str())
}

/// Archive, what switches off, and where the order of loading stands.
fn before_loading(inputs: &Inputs, kit: &Kit) -> String {
    let disable = kit.files.iter().find(|file| file.role == Role::Disable);
    let profile = &inputs.profile;
    let by_hand = profile.off_by_hand.as_deref().unwrap_or(", see to it by hand");
    let off = match disable {
        Some(file) => format!("{} switches off what the files replace", file.path),
        None => format!("no file of this kit switches off what is there{by_hand}"),
    };
    let page = profile.page.as_deref();
    let why = page.map_or_else(String::new, |page| format!(", why: {page}"));
    let order = match (checklist(kit), page) {
        (Some(file), _) => format!("; order of loading and rollback: {file}{why}"),
        (None, Some(page)) => {
            format!("; order of loading: {page}, as this kit has no checklist")
        }
        (None, None) => String::new(),
    };
    format!("before loading: archive the control; {off}{order}")
}

/// `--compare`: backlash policies and spacings side by side.
fn side_by_side(inputs: &Inputs, print: Print) -> Result<Outcome, Problems> {
    let compared = compare(inputs);
    let document = SideBySide {
        machine: &inputs.job.machine.name,
        controller: &inputs.profile.id,
        compared: &compared,
    };
    let outcome = print.outcome(|| screen_of_all(inputs, &compared), || document)?;
    Ok(outcome.answering(compared.first().is_some_and(passes)))
}

/// What scripts read of it.
#[derive(Serialize)]
struct SideBySide<'a> {
    machine: &'a str,
    controller: &'a str,
    compared: &'a [Compared],
}

fn passes(compared: &Compared) -> bool {
    compared.made.as_ref().is_some_and(|made| made.verdict == Verdict::Pass)
}

fn screen_of_all(inputs: &Inputs, compared: &[Compared]) -> Screen {
    let job = &inputs.job;
    let verdict = match job.acceptance.asks_nothing() {
        true => "no acceptance is stated in the job, so there is nothing to judge".to_string(),
        false => format!(
            "{} of {} keep the acceptance of the job",
            compared.iter().filter(|c| passes(c)).count(),
            compared.len()
        ),
    };
    let heading =
        "backlash\tspacing\t>tables\t>points\tterm\t>before\t>after\t>U\tdiag.\t>after\tverdict";
    let own = inputs.job.compensation.backlash;
    let refused = |c: &Compared| {
        let first = c.refused.first()?;
        Some(format!("{}, {}: {first}", policy(c, &own), c.spacing.word()))
    };
    Screen {
        figures: paragraphs(&[format!(
            "{}\n  the first line is the job; spacing: as it asks, half and twice of it (or of its residual)\n  backlash: of all axes, or of the axis that is named with the others as in the job\n  term, diag.: of which most is left, µm; U: 95 %, - = not stated",
            table(heading, compared.iter().map(|c| row(c, &own)))
        )]),
        findings: compared.iter().filter_map(refused).collect(),
        ..Screen::of(format!(
            "{verdict}\nmachine {} - {}; nothing is written",
            job.machine.name, inputs.profile.name
        ))
    }
}

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
    let Some(made) = &compared.made else {
        return format!("{head}\t-\t-\t-\t-\t-\t-\t-\t-\trefused");
    };
    let term = made.term.as_ref().map_or("-\t-\t-\t-".to_string(), |t| {
        let expanded = show::um(t.expanded_um);
        format!("{}\t{:.3}\t{:.3}\t{expanded}", t.name, t.before_um, t.after_um)
    });
    let diagonal = made.diagonal.as_ref();
    let diagonal =
        diagonal.map_or("-\t-".to_string(), |d| format!("{}\t{:.3}", d.name, d.after_um));
    let (tables, points) = (made.tables, made.points);
    format!("{head}\t{tables}\t{points}\t{term}\t{diagonal}\t{}", made.verdict.word())
}
