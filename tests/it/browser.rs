//! The report, the checklist and the sheet of a kit in a browser (Chromium, Linux) and before a validator (HTML Tidy): nothing is wider than the window, no text of
//! a picture is cut off or lies on another, every link leads somewhere, the print has its pages. Skipped, with a
//! word, where they are not installed.
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
        let command = command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments);
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
    run(&["report", readings, "--language", "de", "--unit", "inch", "-o", &place("german.html")]);
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
    let pictures = pictures(folder, &kit, &after).concat();
    let page = format!(
        "<!DOCTYPE html><html lang=\"en\"><head><title>pictures</title></head><body style=\"margin:0\"><div class=\"wide\" style=\"overflow-x:auto\">{pictures}</div></body></html>"
    );
    std::fs::write(folder.join("pictures.html"), page).expect("a page");
    let checklist = Path::new(&kit).join("checklist.html");
    std::fs::copy(checklist, folder.join("checklist.html")).expect("a copy");
    let five = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/machines/five_points");
    let table = std::fs::read_to_string(five.join("errors.csv")).expect("a table");
    std::fs::write(folder.join("errors.csv"), table).expect("a copy");
    let words = std::fs::read_to_string(five.join("generic.toml")).expect("a job");
    let words = words.replace("spacing_mm = 100.0", "spacing_mm = 100.0\ndetection_unit_um = 1.0");
    std::fs::write(folder.join("typed.toml"), words).expect("a job");
    run(&["generate", &place("typed.toml"), "-q", "-o", &place("typed")]);
    std::fs::copy(place("typed/tables.html"), place("tables.html")).expect("a copy");
    ["checklist.html", "tables.html", "readings.html", "german.html", "left.html", "pictures.html"]
        .map(|name| folder.join(name))
        .to_vec()
}

/// What each command draws.
fn pictures(folder: &Path, kit: &str, after: &str) -> Vec<String> {
    let job = "fixtures/nine_errors_900/siemens-840d-sl.toml";
    let second = folder.join("second").to_str().expect("a name").to_string();
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/nine_errors_900");
    std::fs::copy(from.join("errors.csv"), folder.join("errors.csv")).expect("a copy");
    let words = std::fs::read_to_string(from.join("generic.toml")).expect("a job");
    let offset = "[[path.offset]]\nsystem = \"G54\"\nx_mm = 0\ny_mm = 0\nz_mm = 0\n";
    std::fs::write(folder.join("path.toml"), format!("{words}\n{offset}")).expect("a job");
    let part = "G90 G21\nG0 X10 Y10 Z-100\nG1 Z-110 F1000\nX800\nG2 Y600 I0 J295\nG81 X200 Y200 Z-120 R-105 F200\nX600 Y500\nG80\nM30\n";
    std::fs::write(folder.join("part.nc"), part).expect("a program");
    let [path_job, part] = ["path.toml", "part.nc"].map(|name| folder.join(name));
    let [path_job, part] = [&path_job, &part].map(|path| path.to_str().expect("a name"));
    let case_d = "fixtures/diagonals/case_d_bidirectional/job.toml";
    let readings = "fixtures/start/readings/job.toml";
    let commands: [&[&str]; 8] = [
        &["generate", job, "-o", &second],
        &["verify", job, "--tables", kit, "--after", after],
        &["separate", readings, "--trials", "0"],
        &["separate", case_d, "--trials", "0"],
        &["assess", job, "--tables", kit, "--grid", "7,7,7", "--histogram", "1"],
        &["path", path_job, part, "--with-tables"],
        &["standards", "fixtures/standards/x_axis.csv"],
        &["standards", case_d],
    ];
    let draw = |(number, arguments): (usize, &&[&str])| {
        let place = folder.join(format!("{number}.svg"));
        let mut command = Command::new(env!("CARGO_BIN_EXE_nonius"));
        let command = command.current_dir(env!("CARGO_MANIFEST_DIR")).args(*arguments);
        let output = command.arg("--plot").arg(&place).output().expect("the program runs");
        let words = String::from_utf8_lossy(&output.stderr);
        let svg = std::fs::read_to_string(&place);
        let svg = svg.unwrap_or_else(|_| panic!("{arguments:?}: {words}"));
        assert!(svg.contains("<title>") && svg.contains("<desc>"), "{arguments:?}");
        assert!(!svg.contains("NaN") && !svg.contains(">inf"), "{arguments:?}");
        svg
    };
    commands.iter().enumerate().map(draw).collect()
}

/// Without a browser, too.
#[test]
fn every_command_draws_and_replaces_nothing() {
    let folder = tempfile::tempdir().expect("a place to write to");
    assert_eq!(reports(folder.path()).len(), 6);
    let place = folder.path().join("0.svg");
    let mut command = Command::new(env!("CARGO_BIN_EXE_nonius"));
    let command = command.current_dir(env!("CARGO_MANIFEST_DIR"));
    let command = command.args(["assess", "fixtures/start/errors/job.toml", "--plot"]);
    let output = command.arg(&place).output().expect("the program runs");
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && words.contains("is not overwritten"), "{words}");
}

/// Machine 900 with a limit; U so large that nothing is decided, and a doubt, where it is `undecided`.
fn judged(folder: &Path, verdict: &str) -> String {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/nine_errors_900");
    let read = |name: &str| std::fs::read_to_string(from.join(name)).expect("a file");
    let (job, table) = (read("siemens-840d-sl.toml"), read("errors.csv"));
    let limits = |um: f64| format!("max_deviation_um = {um}\nmax_diagonal_um = {um}");
    let with = |um: f64| job.replace("max_deviation_um = 10.0", &limits(um));
    let (job, table) = match verdict {
        "pass" => (with(10.0), table),
        "fail" => (with(0.0001), table),
        _ => {
            let job = with(4.0).replace("active_while_measuring = \"none\"\n", "");
            let rows = table.lines().map(|line| match line.as_bytes()[0] {
                b'#' => line.to_string(),
                b'a' => format!("{line},u_ex_um,u_ey_um,u_ez_um"),
                _ => format!("{line},3.2,3.2,3.2"),
            });
            (job, rows.collect::<Vec<_>>().join("\n"))
        }
    };
    let protocol = "[measurement.protocol]\nby = \"A. Person\"\ninstrument = \"laser 4711\"\ntemperature_c = 20.5\ntemperature_end_c = 20.9\ncustomer = \"A company\"\nlocation = \"hall 2\"\n";
    let folder = folder.join(verdict);
    std::fs::create_dir(&folder).expect("a folder");
    std::fs::write(folder.join("errors.csv"), table).expect("a table");
    let place = folder.join("job.toml");
    std::fs::write(&place, format!("{job}\n{protocol}")).expect("a job");
    place.to_str().expect("a name").to_string()
}

fn pages(print: &Path) -> usize {
    let bytes = std::fs::read(print).expect("a print");
    let text = String::from_utf8_lossy(&bytes);
    let pages = text.lines();
    pages.filter(|line| line.trim_end().ends_with("/Type /Page")).count()
}

/// The first page alone, with the place for two signatures, is one sheet: as forecast and as left, however
/// long its verdict is.
#[test]
fn signatures_stand_on_the_first_sheet() {
    if !installed("chromium") {
        return;
    }
    let folder = tempfile::tempdir().expect("a place to write to");
    let place = |name: &str| folder.path().join(name).to_str().expect("a name").to_string();
    for verdict in ["pass", "undecided", "fail"] {
        let job = judged(folder.path(), verdict);
        let (kit, after) = (place(&format!("{verdict}/kit")), place(&format!("{verdict}.csv")));
        let (page, sheet, print) = (place("page.html"), place("sheet.html"), place("print.pdf"));
        let run = |arguments: &[&str]| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_nonius"));
            let output = command.args(arguments).output().expect("the program runs");
            let words = String::from_utf8_lossy(&output.stderr);
            assert_ne!(output.status.code(), Some(2), "{arguments:?}: {words}");
        };
        run(&["generate", &job, "-q", "-o", &kit]);
        run(&["simulate", &job, "--tables", &kit, "--errors", "-o", &after]);
        let forecast = ["report", &job, "--tables", &kit, "--force", "-o", &page];
        let left = [&forecast[..], &["--after", &after]].concat();
        let cases = [
            (&forecast[..], "en", "letter"),
            (&forecast, "de", "letter"),
            (&forecast, "zh", "A4"),
            (&left, "en", "A4"),
            (&left, "de", "letter"),
            (&left, "de", "A4"),
            (&left, "zh", "letter"),
        ];
        for (arguments, language, size) in cases {
            run(&[arguments, &["--language", language]].concat());
            let whole = std::fs::read_to_string(&page).expect("a page");
            let (first, _) = whole.split_once("</section>").expect("the first page");
            assert!(first.contains("class=\"sign\"") && first.contains("@page{size:auto"));
            let first = first.replace("@page{size:auto", &format!("@page{{size:{size}"));
            std::fs::write(&sheet, format!("{first}</section></body></html>")).expect("a page");
            let url = format!("file://{sheet}");
            chromium(
                folder.path(),
                &["--no-pdf-header-footer", &format!("--print-to-pdf={print}"), &url],
            );
            assert_eq!(
                pages(Path::new(&print)),
                1,
                "{verdict} {language} {size}: {}",
                arguments.len()
            );
        }
    }
}

fn chromium(folder: &Path, arguments: &[&str]) -> Output {
    let data = format!("--user-data-dir={}", folder.join("browser").display());
    let output = Command::new("chromium")
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run"])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
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
        let name = report.file_name().expect("a name").to_str().expect("a plain name");
        for width in [1280, 390, 794] {
            let page = MEASURE.replace("PAGE", name).replace("WIDTH", &width.to_string());
            let place = folder.path().join("measure.html");
            std::fs::write(&place, page).expect("a page");
            let url = format!("file://{}", place.display());
            let output =
                chromium(folder.path(), &["--virtual-time-budget=5000", "--dump-dom", &url]);
            let dom = String::from_utf8_lossy(&output.stdout);
            let found =
                dom.split("<pre id=\"r\">").nth(1).and_then(|rest| rest.split("</pre>").next());
            let found = found.expect("what was measured");
            let (texts, wrong) = found.split_once('\n').unwrap_or((found, ""));
            assert!(texts.starts_with("measured "), "{name}, {width} px: {texts}");
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
        let pages = pages(&print);
        assert!((2..=8).contains(&pages), "{}: {pages} pages", report.display());
    }
}

#[test]
fn the_html_is_valid() {
    if !installed("tidy") {
        return;
    }
    let folder = tempfile::tempdir().expect("a place to write to");
    let pages = reports(folder.path()).into_iter();
    // Pictures are files of their own; a page has their style once, in its head.
    for report in pages.filter(|page| !page.ends_with("pictures.html")) {
        let output = Command::new("tidy").args(["-q", "-e", "-utf8"]).arg(&report).output();
        let output = output.expect("the validator runs");
        let words = String::from_utf8_lossy(&output.stderr);
        assert_eq!(words, "", "{}", report.display());
    }
}
