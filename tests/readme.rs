//! The README shows what the program prints, and its table of evidence is that of the profiles.
#![allow(
    clippy::expect_used,
    reason = "a test may stop at the first thing that is not as expected"
)]

use nonius::controller::{Evidence, builtin};
use std::path::Path;
use std::process::Command;

fn readme() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md");
    std::fs::read_to_string(path).expect("README.md is there")
}

/// The fenced block behind a line that holds `marker`.
fn block_behind(text: &str, marker: &str) -> String {
    let rest = text
        .split(marker)
        .nth(1)
        .expect("the marker stands in the README");
    let block = rest.split("```").nth(1).expect("a fenced block follows");
    block.trim_start_matches("text").trim().to_string()
}

#[test]
fn the_readme_shows_what_the_main_job_prints() {
    let folder = tempfile::tempdir().expect("a place to write to");
    let output = Command::new(env!("CARGO_BIN_EXE_nonius"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["generate", "fixtures/nine_errors_900/fanuc-30i.toml", "-o"])
        .arg(folder.path().join("kit"))
        .output()
        .expect("the program runs");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    let shown = block_behind(&readme(), "checked by tests/readme.rs");
    assert!(
        !shown.is_empty() && printed.contains(&shown),
        "README shows\n{shown}\n\nthe program prints\n{printed}"
    );
}

#[test]
fn the_table_of_evidence_is_that_of_the_profiles() {
    let readme = readme();
    for id in builtin::ids() {
        let profile = builtin::profile(id).expect("a built-in profile");
        let count = |evidence| {
            profile
                .statements
                .iter()
                .filter(|s| s.evidence == evidence)
                .count()
        };
        let figures = format!(
            "{} / {} / {} |",
            count(Evidence::Manual),
            count(Evidence::Assumed),
            count(Evidence::Executed)
        );
        let row = readme
            .lines()
            .find(|line| line.starts_with(&format!("| `{id}` |")))
            .expect("a row for each control");
        assert!(
            row.ends_with(&figures),
            "{id}: README says\n{row}\nthe profile says {figures}"
        );
    }
}

/// The jobs to begin with work as they stand, for every control, and the README names them.
#[test]
fn the_jobs_to_start_from_work_for_every_control() {
    let readme = readme();
    for start in ["fixtures/start/errors", "fixtures/start/readings"] {
        assert!(readme.contains(start), "README does not name {start}");
        let from = Path::new(env!("CARGO_MANIFEST_DIR")).join(start);
        let job = std::fs::read_to_string(from.join("job.toml")).expect("the job is there");
        for id in builtin::ids() {
            let folder = tempfile::tempdir().expect("a place to write to");
            for entry in std::fs::read_dir(&from).expect("the folder is there") {
                let entry = entry.expect("the folder can be read");
                std::fs::copy(entry.path(), folder.path().join(entry.file_name()))
                    .expect("a file can be copied");
            }
            let mut own = job.replace("siemens-840d-sl", id);
            if id.starts_with("fanuc") {
                own = own.replace("# detection_unit_um", "detection_unit_um");
            }
            std::fs::write(folder.path().join("job.toml"), own).expect("the job can be written");
            let output = Command::new(env!("CARGO_BIN_EXE_nonius"))
                .current_dir(folder.path())
                .args(["generate", "job.toml", "-o", "kit"])
                .output()
                .expect("the program runs");
            assert!(
                output.status.success(),
                "{start}, {id}: {}",
                String::from_utf8_lossy(&output.stderr)
            );
        }
    }
}
