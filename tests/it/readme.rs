//! The README shows what the program prints, and its table of evidence is that of the profiles.
use nonius::control::controller::{Evidence, builtin};
use std::path::Path;
use std::process::Command;

fn readme() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md");
    std::fs::read_to_string(path).expect("README.md is there")
}

/// The fenced block behind a line that holds `marker`.
fn block_behind(text: &str, marker: &str) -> String {
    let rest = text.split(marker).nth(1).expect("the marker stands in the README");
    let block = rest.split("```").nth(1).expect("a fenced block follows");
    block.trim_start_matches("text").trim().to_string()
}

#[test]
fn the_readme_shows_what_the_main_job_prints() {
    let folder = tempfile::tempdir().expect("a place to write to");
    let drawn = folder.path().join("before-after.svg");
    let output = Command::new(env!("CARGO_BIN_EXE_nonius"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["generate", "fixtures/nine_errors_900/fanuc-30i.toml", "-o"])
        .arg(folder.path().join("kit"))
        .arg("--plot")
        .arg(&drawn)
        .output()
        .expect("the program runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    let shown = block_behind(&readme(), "checked by tests/it/readme.rs");
    assert!(
        !shown.is_empty() && printed.contains(&shown),
        "README shows\n{shown}\n\nthe program prints\n{printed}"
    );
    let drawn = std::fs::read_to_string(drawn).expect("a picture");
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/before-after.svg");
    if std::env::var_os("NONIUS_UPDATE").is_some() {
        std::fs::write(&kept, &drawn).expect("the picture can be kept");
    }
    let kept = std::fs::read_to_string(kept).expect("the picture of the README");
    assert_eq!(drawn, kept, "the picture of the README is what the program draws: NONIUS_UPDATE=1");
}

/// Every command of the example in docs/rehearsal.md, as it is written there.
#[cfg(unix)]
#[test]
fn the_rehearsal_runs_as_it_is_written() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("docs/rehearsal.md")).expect("the page");
    let script = block_behind(&page, "run by tests/it/readme.rs");
    let script = script.trim_start_matches("sh\n");
    let folder = tempfile::tempdir().expect("a place to write to");
    std::os::unix::fs::symlink(root.join("fixtures"), folder.path().join("fixtures"))
        .expect("a link");
    let program = Path::new(env!("CARGO_BIN_EXE_nonius")).parent();
    let program = program.expect("a directory").display();
    let path = std::env::var("PATH").unwrap_or_default();
    let output = Command::new("sh")
        .args(["-e", "-c", script])
        .env("PATH", format!("{program}:{path}"))
        .current_dir(folder.path())
        .output()
        .expect("a shell");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let printed = String::from_utf8_lossy(&output.stdout);
    assert_eq!(printed.matches("verdict: pass").count(), 3, "{printed}");
    assert!(printed.contains("REHEARSAL: both measurements were simulated"));
    assert!(folder.path().join("out/visit/report.html").exists());
}

#[test]
fn the_table_of_evidence_is_that_of_the_profiles() {
    let readme = readme();
    let controllers = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/controllers.md");
    let controllers = std::fs::read_to_string(controllers).expect("a page");
    for id in builtin::ids() {
        let profile = builtin::profile(id).expect("a built-in profile");
        let count = |evidence| profile.statements.iter().filter(|s| s.evidence == evidence).count();
        let figures = format!(
            "{} / {} / {} |",
            count(Evidence::Manual),
            count(Evidence::Assumed),
            count(Evidence::Executed)
        );
        assert!(readme.contains(&format!("`{id}`")), "README names {id}");
        let begin = format!("| `{id}` |");
        let rows = readme.lines().chain(controllers.lines());
        let counts = |line: &&str| line.ends_with(" |") && line.matches(" / ").count() >= 2;
        let rows = rows.filter(|line| line.starts_with(&begin));
        let rows: Vec<&str> = rows.filter(counts).collect();
        assert!(!rows.is_empty(), "no page has a row for {id}");
        for row in rows {
            assert!(
                row.ends_with(&figures),
                "{id}: a page says\n{row}\nthe profile says {figures}"
            );
        }
    }
}

/// The jobs to begin with work as they stand, for every control, and the interface names them.
#[test]
fn the_jobs_to_start_from_work_for_every_control() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let interface = std::fs::read_to_string(root.join("docs/interface.md")).expect("a page");
    for start in ["fixtures/start/errors", "fixtures/start/readings"] {
        assert!(interface.contains(start), "interface.md does not name {start}");
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
            let profile = builtin::profile(id).expect("a built-in profile");
            if profile.detection_unit_required.value {
                own = own.replace("# detection_unit_um", "detection_unit_um");
            }
            std::fs::write(folder.path().join("job.toml"), own).expect("the job can be written");
            let output = Command::new(env!("CARGO_BIN_EXE_nonius"))
                .current_dir(folder.path())
                .args(["generate", "job.toml", "-o", "kit"])
                .output()
                .expect("the program runs");
            // Klipper leaves positioning as it is, and the verdict says so.
            let is_left = id == "klipper-skew" && output.status.code() == Some(1);
            assert!(
                output.status.success() || is_left,
                "{start}, {id}: {}",
                String::from_utf8_lossy(&output.stderr)
            );
        }
    }
}

/// How many of the readings of the shipped job can be off by `off_um`, each alone, so that
/// `separate` finds nothing; `noise_um` = what the job states of a reading.
fn unnoticed(off_um: f64, noise_um: Option<f64>) -> (usize, usize) {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/start/readings");
    let read = |name: &str| std::fs::read_to_string(from.join(name)).expect("the file is there");
    let folder = tempfile::tempdir().expect("a place to write to");
    let write = |name: &str, text: String| {
        std::fs::write(folder.path().join(name), text).expect("a file can be written");
    };
    let stated = noise_um.map(|um| format!("[measurement]\nuncertainty = {{ noise_um = {um} }}\n"));
    let stated = stated.unwrap_or("[measurement]\n".to_string());
    write("job.toml", read("job.toml").replace("[measurement]\n", &stated));
    let text = read("readings.csv");
    let lines: Vec<&str> = text.lines().collect();
    let is_reading =
        |line: &&str| line.contains(",x,") || line.contains(",y,") || line.contains(",z,");
    let readings = lines.iter().filter(|line| is_reading(line)).count();
    let mut count = 0;
    for (index, line) in lines.iter().enumerate().filter(|(_, line)| is_reading(line)) {
        let (head, um) = line.rsplit_once(',').expect("a reading has cells");
        let off = um.parse::<f64>().expect("a reading is a number") + off_um;
        let disturbed = format!("{head},{off:.3}");
        let mut all = lines.clone();
        all[index] = &disturbed;
        write("readings.csv", all.join("\n") + "\n");
        let output = Command::new(env!("CARGO_BIN_EXE_nonius"))
            .current_dir(folder.path())
            .args(["separate", "job.toml"])
            .output()
            .expect("the program runs");
        count += usize::from(output.status.success());
    }
    (count, readings)
}

#[test]
fn as_many_readings_can_be_off_unnoticed_as_is_told() {
    let cases = [(5.0, None), (15.0, None), (1000.0, None), (5.0, Some(0.3)), (3.0, Some(0.3))];
    let told = cases.map(|(um, noise)| unnoticed(um, noise));
    assert_eq!(told, [(22, 48), (0, 48), (0, 48), (0, 48), (22, 48)]);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/accuracy.md");
    let page = std::fs::read_to_string(path).expect("the page is there");
    let page = page.replace('\n', " ");
    for words in [
        "22 of the 48 readings can be off by 5 µm unnoticed, none of them by 15 µm or more",
        "Where the scatter is stated (`noise_um = 0.3`) none can be off by 5 µm",
        "off by 3 µm 22 pass even then",
    ] {
        assert!(page.contains(words), "{words}");
    }
}

/// Of readings some uncertainties are known; only of the others it can be said that they are not.
#[test]
fn terms_without_an_uncertainty_are_named() {
    let job = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/start/readings/job.toml");
    let folder = tempfile::tempdir().expect("a place to write to");
    let output = Command::new(env!("CARGO_BIN_EXE_nonius"))
        .current_dir(folder.path())
        .args(["generate", &job.display().to_string(), "-o", "kit"])
        .output()
        .expect("the program runs");
    let page = String::from_utf8_lossy(&output.stdout);
    let words = "U of EXX, EYY, EZZ is not stated and counted as 0";
    assert!(page.contains(words), "{page}");
}
