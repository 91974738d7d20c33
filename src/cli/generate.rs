//! `nonius generate JOB -o DIR`

use crate::cli::{Answer, Format, inputs, print, print_json, say, show, write};
use crate::controller::Role;
use crate::forecast::Verdict;
use crate::kit::{Inputs, Kit, generate};
use crate::problem::Problems;
use std::path::Path;

pub(super) fn run(
    job: &Path,
    directory: &Path,
    force: bool,
    format: Format,
) -> Result<Answer, Problems> {
    write::ensure_free(directory, force)?;
    let inputs = inputs::read(job)?;
    let kit = generate(&inputs)?;
    let manifest = kit.manifest_bytes()?;
    let files: Vec<write::NamedBytes<'_>> = kit
        .files
        .iter()
        .map(|file| (file.path.as_str(), file.bytes.as_slice()))
        .collect();
    write::write_kit(directory, &files, ("manifest.json", &manifest), force)?;
    match format {
        Format::Json => print_json(&kit.manifest)?,
        Format::Text => print(&report(&inputs, &kit))?,
    };
    say(&next_steps(job, directory, &kit));
    Ok(if kit.verdict == Verdict::Pass {
        Answer::Yes
    } else {
        Answer::No
    })
}

fn report(inputs: &Inputs, kit: &Kit) -> String {
    let job = &inputs.job;
    let heading = format!(
        "{} - {}, measured {}",
        job.machine.name,
        inputs.profile.name,
        job.measurement
            .date
            .as_deref()
            .unwrap_or("at a date not stated")
    );
    show::paragraphs(&[
        heading,
        show::placements(&kit.compiled.placements),
        show::forecast(&kit.forecast),
        [show::slopes(&inputs.model), show::reversals(&inputs.model)]
            .join("\n")
            .trim()
            .to_string(),
        show::remarks(&kit.plan, &kit.compiled, Some(&kit.forecast)),
        show::verdict(kit.verdict, job.acceptance, Some(&kit.forecast), false),
        show::doubts(&job.measurement.doubts),
        show::assumptions(&kit.compiled.assumptions),
        show::preconditions(&kit.compiled.preconditions),
    ])
}

fn next_steps(job: &Path, directory: &Path, kit: &Kit) -> String {
    let mut lines = Vec::new();
    for file in &kit.files {
        lines.push(format!(
            "wrote {} ({})",
            directory.join(&file.path).display(),
            purpose(file.role)
        ));
    }
    lines.push(format!(
        "wrote {}",
        directory.join("manifest.json").display()
    ));
    lines.push(
        "before loading: archive the control, and switch off what the files replace".to_string(),
    );
    lines.push(format!(
        "check what lies on the stick with: nonius verify {} --tables {}",
        job.display(),
        directory.display()
    ));
    lines.join("\n")
}

fn purpose(role: Role) -> &'static str {
    match role {
        Role::Table => "compensation values",
        Role::Parameters => "parameters or memory, read before use",
        Role::Enable => "switches on",
        Role::Disable => "switches off",
        Role::Report => "for people",
    }
}
