//! The report in a browser (Chromium, Linux) and before a validator (HTML Tidy): nothing is wider than the window, no text of
//! a picture is cut off or lies on another, every link leads somewhere, the print has its pages. Skipped, with a
//! word, where they are not installed.
#![allow(
    clippy::expect_used,
    clippy::print_stderr,
    reason = "a test may stop at the first thing that is not as expected, and says what it skips"
)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn installed(program: &str) -> bool {
    let found = Command::new(program).arg("--version").output().is_ok();
    if !found {
        eprintln!("skipped: {program} is not installed");
    }
    found
}

/// Reports of an error table, of readings, and of a kit with a second measurement.
fn reports(folder: &Path) -> Vec<PathBuf> {
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_nonius"));
        let command = command
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .args(arguments);
        let output = command.output().expect("the program runs");
        let words = String::from_utf8_lossy(&output.stderr);
        assert_ne!(output.status.code(), Some(2), "{arguments:?}: {words}");
    };
    let place = |name: &str| folder.join(name).to_str().expect("a name").to_string();
    let job = "fixtures/nine_errors_900/siemens-840d-sl.toml";
    let (kit, after) = (place("kit"), place("after.csv"));
    run(&["generate", job, "-q", "-o", &kit]);
    run(&["simulate", job, "--tables", &kit, "--errors", "-o", &after]);
    let readings = "fixtures/start/readings/job.toml";
    run(&["report", readings, "-o", &place("readings.html")]);
    run(&[
        "report",
        readings,
        "--language",
        "de",
        "-o",
        &place("german.html"),
    ]);
    run(&[
        "report",
        job,
        "--tables",
        &kit,
        "--after",
        &after,
        "--language",
        "zh",
        "-o",
        &place("left.html"),
    ]);
    ["readings.html", "german.html", "left.html"]
        .map(|name| folder.join(name))
        .to_vec()
}

fn chromium(folder: &Path, arguments: &[&str]) -> Output {
    let data = format!("--user-data-dir={}", folder.join("browser").display());
    let output = Command::new("chromium")
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
        ])
        .args([
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
        ])
        .args(["--disable-quic", "--allow-file-access-from-files", &data])
        .args(arguments)
        .output();
    output.expect("the browser runs")
}

/// Measures a page in a frame of some width and writes down what is wrong.
const MEASURE: &str = r#"<!DOCTYPE html><body style="margin:0"><iframe id="f" src="PAGE" style="border:0;width:WIDTHpx;height:900px"></iframe><pre id="r">not measured</pre><script>
f.onload = () => {
  const d = f.contentDocument, root = d.documentElement, out = [];
  if (root.scrollWidth > root.clientWidth) out.push('the page is ' + root.scrollWidth + ' wide in ' + root.clientWidth);
  for (const svg of d.querySelectorAll('svg')) {
    const box = svg.getBoundingClientRect();
    const texts = [...svg.querySelectorAll('text')].map(e => [e.textContent, e.getBoundingClientRect()]);
    texts.forEach(([words, r], i) => {
      if (r.left < box.left - 1 || r.right > box.right + 1 || r.top < box.top - 1 || r.bottom > box.bottom + 1) out.push('cut off: ' + words);
      for (const [other, o] of texts.slice(i + 1)) {
        const wide = Math.min(r.right, o.right) - Math.max(r.left, o.left), high = Math.min(r.bottom, o.bottom) - Math.max(r.top, o.top);
        if (wide > 1 && high > 2) out.push('on each other: ' + words + ' / ' + other);
      }
    });
  }
  for (const e of d.querySelectorAll('body *')) {
    if (e.closest('svg') || e.closest('.wide') || e.closest('figure')) continue;
    if (e.getBoundingClientRect().right > root.clientWidth + 1) out.push('beyond the edge: ' + e.tagName + ' ' + e.textContent.slice(0, 40));
  }
  for (const a of d.querySelectorAll('a')) if (!d.getElementById(a.getAttribute('href').slice(1))) out.push('leads nowhere: ' + a.href);
  r.textContent = 'measured ' + d.querySelectorAll('text').length + ' texts\n' + out.join('\n');
};
</script>"#;

#[test]
fn nothing_is_cut_off_or_lies_on_another() {
    if !installed("chromium") {
        return;
    }
    let folder = tempfile::tempdir().expect("a place to write to");
    for report in reports(folder.path()) {
        let name = report
            .file_name()
            .expect("a name")
            .to_str()
            .expect("a plain name");
        for width in [1280, 390, 794] {
            let page = MEASURE
                .replace("PAGE", name)
                .replace("WIDTH", &width.to_string());
            let place = folder.path().join("measure.html");
            std::fs::write(&place, page).expect("a page");
            let url = format!("file://{}", place.display());
            let output = chromium(
                folder.path(),
                &["--virtual-time-budget=5000", "--dump-dom", &url],
            );
            let dom = String::from_utf8_lossy(&output.stdout);
            let found = dom
                .split("<pre id=\"r\">")
                .nth(1)
                .and_then(|rest| rest.split("</pre>").next());
            let found = found.expect("what was measured");
            let (texts, wrong) = found.split_once('\n').unwrap_or((found, ""));
            assert!(
                texts.starts_with("measured "),
                "{name}, {width} px: {texts}"
            );
            assert_eq!(wrong, "", "{name}, {width} px");
        }
    }
}

#[test]
fn the_print_has_its_pages() {
    if !installed("chromium") {
        return;
    }
    let folder = tempfile::tempdir().expect("a place to write to");
    for report in reports(folder.path()) {
        let print = folder.path().join("print.pdf");
        let to = format!("--print-to-pdf={}", print.display());
        let url = format!("file://{}", report.display());
        chromium(folder.path(), &["--no-pdf-header-footer", &to, &url]);
        let bytes = std::fs::read(&print).expect("a print");
        let text = String::from_utf8_lossy(&bytes);
        let pages = text
            .lines()
            .filter(|line| line.trim_end().ends_with("/Type /Page"))
            .count();
        assert!(
            (3..=7).contains(&pages),
            "{}: {pages} pages",
            report.display()
        );
    }
}

#[test]
fn the_html_is_valid() {
    if !installed("tidy") {
        return;
    }
    let folder = tempfile::tempdir().expect("a place to write to");
    for report in reports(folder.path()) {
        let output = Command::new("tidy")
            .args(["-q", "-e", "-utf8"])
            .arg(&report)
            .output();
        let output = output.expect("the validator runs");
        let words = String::from_utf8_lossy(&output.stderr);
        assert_eq!(words, "", "{}", report.display());
    }
}
