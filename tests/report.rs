//! The page that is handed over: its figures are those of the commands, its bytes are the same twice, text of
//! others is harmless, and a browser shows it without anything cut off.
#![allow(
    clippy::expect_used,
    reason = "a test may stop at the first thing that is not as expected"
)]

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn nonius(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_nonius"));
    let command = command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(arguments);
    command.output().expect("the program runs")
}

fn document(arguments: &[&str]) -> Value {
    let output = nonius(&[arguments, &["--format", "json"]].concat());
    let words = String::from_utf8_lossy(&output.stderr);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{arguments:?}: {words}"))
}

fn page(arguments: &[&str]) -> String {
    let output = nonius(&[&["report"], arguments, &["-o", "-"]].concat());
    assert_ne!(
        output.status.code(),
        Some(2),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).expect("the page is text")
}

/// Every figure of a page: its number, the command, the place in the document, what is shown.
fn figures(page: &str) -> Vec<(f64, String, String, String)> {
    let figures = page.split("<span data-value=\"").skip(1).map(|rest| {
        let (number, rest) = rest.split_once("\" data-of=\"").expect("where it is from");
        let (of, rest) = rest.split_once("\">").expect("the end of the mark");
        let (shown, _) = rest.split_once("</span>").expect("what is shown");
        let (command, at) = of.split_once(' ').expect("command and place");
        let number = number.parse().expect("a number");
        (
            number,
            command.to_string(),
            at.to_string(),
            shown.to_string(),
        )
    });
    figures.collect()
}

fn kit(folder: &Path, job: &str) -> PathBuf {
    let kit = folder.join("kit");
    let output = nonius(&["generate", job, "-q", "-o", kit.to_str().expect("a name")]);
    assert_ne!(
        output.status.code(),
        Some(2),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    kit
}

/// Compares every figure of a page with the documents of the commands that it names.
fn check_figures(page: &str, job: &str, kit: &Path, after: Option<&str>) {
    let tables = kit.to_str().expect("a name");
    let mut verify = vec!["verify", job, "--tables", tables];
    verify.extend(after.into_iter().flat_map(|after| ["--after", after]));
    let manifest = std::fs::read(kit.join("manifest.json")).expect("a manifest");
    let documents = [
        ("verify", document(&verify)),
        (
            "assess",
            document(&["assess", job, "--tables", tables, "--grid", "11,11,11"]),
        ),
        (
            "kit",
            serde_json::from_slice(&manifest).expect("a manifest is JSON"),
        ),
    ];
    let figures = figures(page);
    assert!(figures.len() > 30, "only {} figures", figures.len());
    for (number, command, at, shown) in figures {
        let (_, document) = documents
            .iter()
            .find(|(name, _)| *name == command)
            .expect("a command");
        let value = document.pointer(&at).and_then(Value::as_f64);
        assert_eq!(value, Some(number), "{command} {at}");
        let shown = shown.replace('\u{2212}', "-").replace(',', ".");
        let decimals = shown.split_once('.').map_or(0, |(_, after)| after.len());
        let read: f64 = shown.parse().expect("a figure is a number");
        let digits = u32::try_from(decimals).expect("few decimals");
        let half = 0.5 / nonius::quantity::units::power_of_ten(digits);
        assert!(
            (read - number).abs() <= half * 1.001,
            "{command} {at}: {shown} for {number}"
        );
    }
}

#[test]
fn every_figure_is_that_of_its_command() {
    let folder = tempfile::tempdir().expect("a place to write to");
    let job = "fixtures/nine_errors_900/siemens-840d-sl.toml";
    let kit = kit(folder.path(), job);
    let tables = kit.to_str().expect("a name");
    check_figures(&page(&[job, "--tables", tables]), job, &kit, None);
    check_figures(
        &page(&[job, "--tables", tables, "--language", "de"]),
        job,
        &kit,
        None,
    );
    // As left: the same machine measured with the tables, which the simulation predicts.
    let after = folder.path().join("after.csv");
    let after = after.to_str().expect("a name");
    let made = nonius(&["simulate", job, "--tables", tables, "--errors", "-o", after]);
    assert!(
        made.status.success(),
        "{}",
        String::from_utf8_lossy(&made.stderr)
    );
    let left = page(&[job, "--tables", tables, "--after", after]);
    assert!(left.contains("/terms/EXX/after_um") && left.contains("As left"));
    assert!(left.contains("REHEARSAL") && left.contains("the values afterwards were simulated"));
    check_figures(&left, job, &kit, Some(after));
}

/// Each family, with a second measurement: its page is as long as it gets.
#[test]
fn it_works_for_every_control() {
    let folder = tempfile::tempdir().expect("a place to write to");
    for id in [
        "siemens-828d",
        "fanuc-30i",
        "fanuc-0i-f",
        "fanuc-16i",
        "generic",
    ] {
        let job = format!("fixtures/nine_errors_900/{id}.toml");
        let kit = kit(&folder.path().join(id), &job);
        let after = "fixtures/nine_errors_900/errors.csv";
        let tables = kit.to_str().expect("a name");
        let left = page(&[&job, "--tables", tables, "--after", after]);
        check_figures(&left, &job, &kit, Some(after));
    }
}

/// What was not measured, or is not known without a manifest, is not said to be complete.
#[test]
fn nothing_is_called_complete_that_is_not_known() {
    let folder = tempfile::tempdir().expect("a place to write to");
    let complete = "All nine errors were measured";
    let job = "fixtures/nine_errors_900/siemens-840d-sl.toml";
    let kit = kit(folder.path(), job);
    let tables = kit.to_str().expect("a name");
    assert!(page(&[job, "--tables", tables]).contains(complete));
    std::fs::remove_file(kit.join("manifest.json")).expect("a manifest");
    let page = page(&[job, "--tables", tables]);
    assert!(!page.contains(complete) && !page.contains("No file of this kit switches"));
    assert!(page.contains("has no manifest.json"));
    assert!(
        page.contains("U is not stated and counted as 0"),
        "what the verdict rests on"
    );
}

#[test]
fn it_works_from_errors_or_readings_alone_in_every_language() {
    for job in [
        "fixtures/start/errors/job.toml",
        "fixtures/start/readings/job.toml",
    ] {
        for language in ["en", "de", "zh"] {
            let page = page(&[job, "--language", language]);
            assert!(page.contains(&format!("<html lang=\"{language}\">")));
            assert!(page.len() < 1_000_000, "{job}: {} bytes", page.len());
            assert!(
                !page.contains("<script")
                    && !page.contains("http://")
                    && !page.contains("https://")
            );
        }
    }
}

#[test]
fn inches_are_shown_and_the_document_stays_in_micrometres() {
    let page = page(&["fixtures/start/errors/job.toml", "--unit", "inch"]);
    let (number, .., shown) = figures(&page)
        .into_iter()
        .find(|(number, _, at, _)| at.ends_with("before_um") && *number > 1.0)
        .expect("an error");
    let read: f64 = shown.parse().expect("a figure");
    assert!(
        (read - number / 0.0254).abs() < 0.0501,
        "{shown} for {number} µm"
    );
    assert!(page.contains("µin"));
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let job = "fixtures/nine_errors_900/fanuc-30i.toml";
    assert_eq!(page(&[job]), page(&[job]));
}

/// Names of machines, files and people may hold anything.
#[test]
fn text_of_others_is_shown_and_not_obeyed() {
    let folder = tempfile::tempdir().expect("a place to write to");
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/start/errors");
    std::fs::copy(from.join("errors.csv"), folder.path().join("errors.csv")).expect("a copy");
    let job = std::fs::read_to_string(from.join("job.toml")).expect("a job");
    let evil = r#"<img src=x onerror=\"alert(1)\">&;()'"#;
    let mut lines: Vec<String> = job.lines().map(str::to_string).collect();
    for line in &mut lines {
        if line.starts_with("serial") {
            *line = format!("serial = \"{evil}\"");
        }
    }
    lines.push(format!(
        "[measurement.protocol]\nby = \"{evil}\"\n\"a<b>\" = \"</section>\""
    ));
    let path = folder.path().join("job.toml");
    std::fs::write(&path, lines.join("\n")).expect("a job");
    let output = nonius(&["report", path.to_str().expect("a name"), "-o", "-"]);
    let page = String::from_utf8_lossy(&output.stdout);
    let words = String::from_utf8_lossy(&output.stderr);
    if output.status.code() == Some(2) {
        // A serial number goes into comments of the control's files, too, which may refuse it.
        assert!(words.contains("comments"), "{words}");
        return;
    }
    assert!(page.contains("&lt;img src=x onerror="), "{words}");
    assert!(!page.contains("<img src=x") && !page.contains("a<b>"));
}

#[test]
fn a_template_and_texts_of_ones_own() {
    let folder = tempfile::tempdir().expect("a place to write to");
    let put = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("a file");
        path.to_str().expect("a name").to_string()
    };
    let job = "fixtures/start/errors/job.toml";
    let template = put("own.tera", "{{ machine.name }}: {{ verdict.word }}\n");
    let own = page(&[job, "--template", &template]);
    assert!(own.ends_with(": PASS\n"), "{own}");
    let english = Path::new(env!("CARGO_MANIFEST_DIR")).join("templates/report/en.toml");
    let english = std::fs::read_to_string(english).expect("the English texts");
    let texts = put("cs.toml", &english.replace("\"PASS\"", "\"VYHOVUJE\""));
    let own = page(&[job, "--language", &texts]);
    assert!(own.contains("VYHOVUJE") && own.contains("<html lang=\"cs\">"));
    for (name, text, says) in [
        ("short.toml", "title = \"x\"\n", "lacks"),
        (
            "long.toml",
            &format!("{english}\nother = \"x\"\n"),
            "unknown keys: other",
        ),
    ] {
        let texts = put(name, text);
        let output = nonius(&["report", job, "--language", &texts, "-o", "-"]);
        let words = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            output.status.code() == Some(2) && words.contains(says),
            "{words}"
        );
    }
}
