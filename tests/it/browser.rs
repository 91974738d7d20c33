//! The report, the checklist and the sheet of a kit in a browser (Chromium, Linux) and before a validator (HTML Tidy): nothing is wider than the window, no text of
//! a picture is cut off or lies on another, every link leads somewhere, the print has its pages. Skipped, with a
//! word, where they are not installed.

use crate::support::{G54, Ran, Visit, fixture, in_repository, is_installed, replaced};
use std::process::{Command, Output};

const JOB: &str = "fixtures/nine_errors_900/siemens-840d-sl.toml";
const READINGS: &str = "fixtures/start/readings/job.toml";

fn run(visit: &Visit, command: &str) -> Ran {
    in_repository(&command.replace("OUT", &visit.folder().display().to_string()))
}

/// Reports of an error table, of readings, and of a kit with a second measurement.
fn reports(visit: &Visit) -> [&'static str; 6] {
    let after = "--tables OUT/kit --after OUT/after.csv";
    let table = fixture("machines/five_points/generic.toml");
    let spacing = "spacing_mm = 100.0";
    let unit = format!("{spacing}\ndetection_unit_um = 1.0");
    visit.put("five/typed.toml", replaced(&table, spacing, &unit));
    visit.copy("machines/five_points/errors.csv", "five/errors.csv");
    for command in [
        &format!("generate {JOB} -q -o OUT/kit"),
        &format!("simulate {JOB} --tables OUT/kit --errors -o OUT/after.csv"),
        &format!("report {READINGS} -o OUT/readings.html"),
        &format!("report {READINGS} --language de --unit inch -o OUT/german.html"),
        &format!("report {JOB} {after} --language zh -o OUT/left.html"),
        "generate OUT/five/typed.toml -q -o OUT/typed",
    ] {
        run(visit, command).answers();
    }
    let pictures = pictures(visit, after).concat();
    let page = format!(
        "<!DOCTYPE html><html lang=\"en\"><head><title>pictures</title></head><body style=\"margin:0\"><div class=\"wide\" style=\"overflow-x:auto\">{pictures}</div></body></html>"
    );
    visit.put("pictures.html", page);
    visit.put("checklist.html", visit.read("kit/checklist.html"));
    visit.put("tables.html", visit.read("typed/tables.html"));
    ["checklist.html", "tables.html", "readings.html", "german.html", "left.html", "pictures.html"]
}

fn pictures(visit: &Visit, after: &str) -> Vec<String> {
    visit.put("path.toml", fixture("nine_errors_900/generic.toml") + G54);
    visit.copy("nine_errors_900/errors.csv", "errors.csv");
    let part = "G90 G21\nG0 X10 Y10 Z-100\nG1 Z-110 F1000\nX800\nG2 Y600 I0 J295\nG81 X200 Y200 Z-120 R-105 F200\nX600 Y500\nG80\nM30\n";
    visit.put("part.nc", part);
    let case_d = "fixtures/diagonals/case_d_bidirectional/job.toml";
    let commands = [
        &format!("generate {JOB} -o OUT/second"),
        &format!("verify {JOB} {after}"),
        &format!("separate {READINGS} --trials 0"),
        &format!("separate {case_d} --trials 0"),
        &format!("assess {JOB} --tables OUT/kit --grid 7,7,7 --histogram 1"),
        "path OUT/path.toml OUT/part.nc --with-tables",
        "standards fixtures/standards/x_axis.csv",
        &format!("standards {case_d}"),
    ];
    let draw = |(number, command): (usize, &&str)| {
        let name = format!("{number}.svg");
        let ran = run(visit, &format!("{command} --plot OUT/{name}"));
        assert!(visit.has(&name), "{command}: {}", ran.all());
        let svg = visit.read(&name);
        assert!(svg.contains("<title>") && svg.contains("<desc>"), "{command}");
        assert!(!svg.contains("NaN") && !svg.contains(">inf"), "{command}");
        svg
    };
    commands.iter().enumerate().map(draw).collect()
}

/// Machine 900 with a limit; U so large that nothing is decided, and a doubt, where it is `undecided`.
fn judged(visit: &Visit, verdict: &str) {
    let (job, table) = (format!("{verdict}/job.toml"), format!("{verdict}/errors.csv"));
    visit.copy("nine_errors_900/siemens-840d-sl.toml", &job);
    visit.copy("nine_errors_900/errors.csv", &table);
    let um = match verdict {
        "pass" => "10",
        "fail" => "0.0001",
        _ => {
            visit.edit(&job, "active_while_measuring = \"none\"\n", "");
            visit.with_column(&table, ",u_ex_um,u_ey_um,u_ez_um", ",3.2,3.2,3.2");
            "4"
        }
    };
    let limits = format!("max_deviation_um = {um}\nmax_diagonal_um = {um}");
    visit.edit(&job, "max_deviation_um = 10.0", &limits);
    let protocol = "[measurement.protocol]\nby = \"A. Person\"\ninstrument = \"laser 4711\"\ntemperature_c = 20.5\ntemperature_end_c = 20.9\ncustomer = \"A company\"\nlocation = \"hall 2\"\n";
    visit.put(&job, format!("{}\n{protocol}", visit.read(&job)));
}

/// Prints a page of the folder; how many sheets it takes.
fn printed(visit: &Visit, page: &str) -> usize {
    let to = format!("--print-to-pdf={}", visit.at("print.pdf").display());
    chromium(visit, page, &["--no-pdf-header-footer", &to]);
    let bytes = std::fs::read(visit.at("print.pdf")).expect("a print");
    let text = String::from_utf8_lossy(&bytes);
    text.lines().filter(|line| line.trim_end().ends_with("/Type /Page")).count()
}

/// The first pages, with the place for two signatures, are a sheet each, however long the verdict is.
#[test]
fn signatures_stand_on_the_first_sheet() {
    if !is_installed("chromium") {
        return;
    }
    let visit = Visit::new();
    let mut sheets = [("letter", Vec::new()), ("A4", Vec::new())];
    for verdict in ["pass", "undecided", "fail"] {
        judged(&visit, verdict);
        let job = format!("OUT/{verdict}/job.toml");
        let tables = format!("{job} --tables OUT/{verdict}/kit");
        run(&visit, &format!("generate {job} -q -o OUT/{verdict}/kit")).answers();
        run(&visit, &format!("simulate {tables} --errors -o OUT/{verdict}.csv")).answers();
        let left = format!("--after OUT/{verdict}.csv");
        for (after, language, sizes) in [
            ("", "en", 0..1),
            ("", "de", 0..1),
            ("", "zh", 1..2),
            (&left, "en", 1..2),
            (&left, "de", 0..2),
            (&left, "zh", 0..1),
        ] {
            let options = format!("{after} --language {language} --force -o OUT/page.html");
            run(&visit, &format!("report {tables} {options}")).answers();
            let whole = visit.read("page.html");
            let (first, _) = whole.split_once("</section>").expect("the first page");
            assert!(first.contains("class=\"sign\""), "{first}");
            for (_, pages) in &mut sheets[sizes] {
                pages.push((language, first.to_string()));
            }
        }
    }
    for (size, pages) in sheets {
        let (head, _) = pages[0].1.split_once("<body>").expect("a head");
        let mut sheet = replaced(head, "@page{size:auto", &format!("@page{{size:{size}"));
        sheet += "<body>";
        for (language, page) in &pages {
            let (_, body) = page.split_once("<body>").expect("a body");
            let div = format!("<div lang=\"{language}\" style=\"break-after:page\">");
            sheet += &format!("{div}{body}</section></div>");
        }
        visit.put("sheet.html", sheet);
        assert_eq!(printed(&visit, "sheet.html"), pages.len(), "{size}");
    }
}

fn chromium(visit: &Visit, page: &str, arguments: &[&str]) -> Output {
    Command::new("chromium")
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run"])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
        .args(["--disable-quic", "--allow-file-access-from-files"])
        .arg(format!("--user-data-dir={}", visit.at("browser").display()))
        .args(arguments)
        .arg(format!("file://{}", visit.at(page).display()))
        .output()
        .expect("the browser runs")
}

#[test]
fn pages_are_whole_in_any_window_and_on_paper_and_their_html_is_valid() {
    let visit = Visit::new();
    let reports = reports(&visit);
    let again = run(&visit, "assess fixtures/start/errors/job.toml --plot OUT/0.svg");
    again.ends(2).says("is not overwritten");
    if is_installed("chromium") {
        // Measures pages in frames of three widths and writes down what is wrong.
        let measure = include_str!("browser.html").replace("PAGES", &reports.join(" "));
        visit.put("measure.html", measure);
        let options = ["--virtual-time-budget=5000", "--dump-dom"];
        let output = chromium(&visit, "measure.html", &options);
        let dom = String::from_utf8_lossy(&output.stdout);
        let found = dom.split("<pre id=\"r\">").nth(1).and_then(|rest| rest.split("</pre>").next());
        let found: Vec<&str> = found.expect("what was measured").lines().collect();
        assert!(found.iter().all(|line| line.starts_with("measured ")), "{found:#?}");
        assert_eq!(found.len(), 3 * reports.len(), "{found:#?}");
        for report in reports {
            let pages = printed(&visit, report);
            assert!((2..=8).contains(&pages), "{report}: {pages} pages");
        }
    }
    if is_installed("tidy") {
        // Pictures are files of their own; a page has their style once, in its head.
        for report in reports.into_iter().filter(|page| *page != "pictures.html") {
            let output =
                Command::new("tidy").args(["-q", "-e", "-utf8"]).arg(visit.at(report)).output();
            let words = output.expect("the validator runs").stderr;
            assert_eq!(String::from_utf8_lossy(&words), "", "{report}");
        }
    }
}
