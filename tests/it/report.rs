//! The page that is handed over: figures as of the commands, the same bytes twice, text of others harmless.
use crate::support::visit::page as repository_page;
use crate::support::{Visit, holds, in_parallel, lacks, number, replaced};
use serde_json::Value;
use std::collections::BTreeSet;

const SIEMENS: &str = "nine_errors_900/siemens-840d-sl.toml";

#[track_caller]
fn page(visit: &Visit, arguments: &str) -> String {
    visit.run(&format!("report {arguments} -o -")).answers().omits("\u{fffd}").out
}

/// Every figure of a page: its number, the command, the place in the document, what is shown.
fn figures(page: &str) -> impl Iterator<Item = (f64, &str, &str, &str)> {
    page.split("<span data-value=\"").skip(1).map(|rest| {
        let (number, rest) = rest.split_once("\" data-of=\"").unwrap();
        let (of, rest) = rest.split_once("\">").unwrap();
        let (shown, _) = rest.split_once("</span>").unwrap();
        let (command, at) = of.split_once(' ').unwrap();
        (number.parse().unwrap(), command, at, shown)
    })
}

fn check_figures(visit: &Visit, page: &str, after: &str) {
    let documents = [
        ("verify", visit.json(&format!("verify job.toml --tables kit {after}"))),
        ("assess", visit.json("assess job.toml --tables kit --grid 11,11,11")),
        ("kit", visit.document("kit/manifest.json")),
    ];
    check_documents(page, &documents, 30);
}

/// Compares every figure with the document that it names; there are more than `least` of them.
fn check_documents(page: &str, documents: &[(&str, Value)], least: usize) {
    assert!(figures(page).count() > least, "only {} figures", figures(page).count());
    for (number, command, at, shown) in figures(page) {
        let found = documents.iter().find(|(name, _)| *name == command);
        let (_, document) = found.unwrap_or_else(|| panic!("{command} is no command"));
        assert_eq!(document.pointer(at).and_then(Value::as_f64), Some(number), "{command} {at}");
        let shown = shown.replace('\u{2212}', "-").replace(',', ".");
        let decimals = shown.split_once('.').map_or(0, |(_, after)| after.len());
        let half = 0.5 / nonius::quantity::power_of_ten(u32::try_from(decimals).unwrap());
        let off = (shown.parse::<f64>().unwrap() - number).abs();
        assert!(off <= half * 1.001, "{command} {at}: {shown} for {number}");
    }
}

fn items(page: &str, part: &str) -> Vec<String> {
    let (_, rest) = page.split_once(&format!("<section id=\"{part}\"")).unwrap();
    let (part, _) = rest.split_once("</section>").unwrap();
    part.split("<li>").skip(1).map(|item| item.split("</li>").next().unwrap().to_string()).collect()
}

#[test]
fn without_tables_it_shows_the_machine_as_found() {
    let visit = Visit::with_job("machine_h/job.toml");
    let assess = visit.json("assess job.toml --grid 11,11,11");
    let english = page(&visit, "job.toml");
    check_documents(&english, &[("assess", assess.clone())], 18);
    let table = visit.read("errors.csv");
    for (term, axis, column) in [("EXX", "x", 2), ("EYY", "y", 3), ("EZZ", "z", 4)] {
        let um = number(&assess["terms"][term]["before_um"]);
        // Largest |value − value at the reference| of the column, by hand.
        let rows = table.lines().filter(|line| line.starts_with(axis));
        let values = rows.filter_map(|line| line.split(',').nth(column)?.parse::<f64>().ok());
        let values: Vec<f64> = values.collect();
        let largest = values.iter().map(|um| (um - values[0]).abs()).fold(0.0, f64::max);
        assert!((um - largest).abs() < 1e-6, "{term} {um}");
    }
    holds(&english, &["AS FOUND", "no tables are given", "/definitions/diagonals_um/PNP", "EYX"]);
    lacks(&english, &["Forecast", "As left", "PASS", "Tables of the control", "Rollback"]);
    let said = visit.run("report job.toml -o page.html --format json").ends(0).json();
    assert_eq!(said["verdict"], "as-found");
}

/// Of an error table alone nobody knows the machine; U is that of a value known to 1 µm: 1.96 µm (95 %).
#[test]
fn an_error_table_alone_will_do() {
    let visit = Visit::new();
    visit.put("errors.csv", "axis,position_mm,ex_um,u_ex_um\nx,0,0,0\nx,100,2,0.1\nx,200,50,1\n");
    let found = page(&visit, "errors.csv");
    let terms = &visit.json("assess errors.csv --grid 11,1,1")["terms"]["EXX"];
    assert_eq!(terms["before_um"], 50.0);
    let expanded = number(&terms["expanded_um"]);
    assert!((expanded - 1.95996).abs() < 0.0001, "{expanded}");
    holds(&found, &["errors.csv", "<code>"]); // its hash
    lacks(&found, &["/definitions/diagonals_um"]); // one error makes no diagonal
    assert!(items(&found, "missing_found").iter().any(|item| item.starts_with("EYY")));
}

#[test]
fn readings_without_tables_keep_their_doubts() {
    let visit = Visit::of("diagonals/case_d_bidirectional");
    let job = visit.read("job.toml");
    let (before, after) = job.split_once("[compensation]").unwrap();
    let acceptance = after.find("[acceptance]").map_or("", |at| &after[at..]);
    visit.put("job.toml", format!("{before}{acceptance}"));
    let found = page(&visit, "job.toml");
    visit.yes("simulate job.toml --without-tables -o as-found.csv");
    let separate = visit.json("separate job.toml --trials 0");
    let assess = visit.json("assess job.toml --grid 11,11,11");
    for plane in ["xy", "xz", "yz"] {
        let squareness = &assess["squareness"][plane];
        assert_eq!(squareness["before_um_per_m"], separate["squareness_um_per_m"][plane]);
        let u = number(&separate["u_squareness_um_per_m"][plane]);
        let expanded = number(&squareness["expanded_um_per_m"]);
        assert!((1.9..2.1).contains(&(expanded / u)), "{plane}: {expanded}, u {u}");
    }
    let standards = visit.json("standards job.toml");
    check_documents(&found, &[("assess", assess), ("standards", standards)], 30);
    let (verdict, _) = found.split_once("Largest deviation").unwrap();
    holds(verdict, &["reversal"]); // the reversal that no curve holds is a doubt
    lacks(verdict, &["\u{2264}"]); // a limit that nothing was judged by
}

#[test]
fn runs_of_an_axis_are_shown_by_standard() {
    let visit = Visit::with_job("machine_h/job.toml");
    visit.copy("standards/x_axis.csv", "runs.csv");
    let found = page(&visit, "job.toml --linear runs.csv --linear runs.csv");
    let runs = visit.json("standards runs.csv");
    let assess = visit.json("assess job.toml --grid 11,11,11");
    let documents = [("assess", assess), ("standards:1", runs.clone()), ("standards:2", runs)];
    check_documents(&found, &documents, 40);
    holds(&found, &["standards:2 /iso_230_2/A_um", "the travel is not stated"]);
    lacks(&found, &["--travel-mm"]);
    visit.copy("formats/sample_synthetic.rtl", "runs.rtl");
    let refused = visit.run("report job.toml --linear runs.rtl -o -");
    refused.ends(2).says("expected runs of one axis (CSV)");
}

#[test]
fn a_logo_is_a_picture_and_a_table_alone_names_no_machine() {
    let visit = Visit::with_job("nine_errors_900/generic.toml");
    let svg =
        "\u{feff}<?xml version='1.0'?>\n<!-- made by hand -->\n<!DOCTYPE svg>\n<svg width='1'/>";
    visit.put("logo", svg);
    let found = page(&visit, "errors.csv --logo logo");
    holds(&found, &["<title>Geometric errors as found</title>", "data:image/svg+xml;base64,"]);
    let others: [&[u8]; 6] = [
        b"<html><svg/></html>",
        b"<!-- <svg> --><html/>",
        b"<svgs/>",
        b"\x89PNG",
        b"\x89PNG\r\n\x1a\n\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0",
        b"\xff\xd8\xff and nothing else",
    ];
    for other in others {
        let ran = visit.put("logo", other).run("report errors.csv --logo logo -o -");
        ran.ends(2).says("is no picture that a page can hold");
    }
}

/// Angles need the order of the axes: without it the page says why it has no figures of the volume.
#[test]
fn a_volume_that_cannot_be_computed_is_told() {
    let visit = Visit::with_job("machines/five_points/generic.toml");
    visit.with_column("errors.csv", ",ec_urad", ",1");
    visit.edit("job.toml", "\nchain = ", "\n# chain = ");
    assert!(items(&page(&visit, "job.toml"), "volume")[0].contains("`machine.chain` is missing"));
}

/// A job that does not say what acted while measuring, with a key that nothing uses.
fn doubted(visit: &Visit) {
    visit.edit("job.toml", "active_while_measuring = \"none\"\n", "");
    let unused = "[measurement.uncertainty]\ntemperature_k = 0.3\n\n[acceptance]\n";
    visit.edit("job.toml", "[acceptance]\n", unused);
}

#[test]
fn a_finding_stands_once() {
    let visit = Visit::with_job(SIEMENS);
    doubted(&visit);
    visit.run("generate job.toml -q -o kit").answers();
    let verify = visit.json("verify job.toml --tables kit --after job.toml");
    let notes = verify["notes"].as_array().unwrap().iter().map(|note| note.as_str().unwrap());
    let of_temperature = |note: &str| note.starts_with("`temperature_k`");
    assert_eq!(notes.filter(|note| of_temperature(note)).count(), 2, "one of each measurement");
    let findings = items(&page(&visit, "job.toml --tables kit --after job.toml"), "findings");
    assert_eq!(findings.iter().filter(|item| of_temperature(item)).count(), 1);
}

#[test]
fn every_figure_is_that_of_its_command() {
    let visit = Visit::with_job(SIEMENS).with_any_kit();
    let found = page(&visit, "job.toml --tables kit");
    check_figures(&visit, &found, "");
    // No curve is drawn as forecast that is that of the machine as found.
    let lines = |ink: &str| -> BTreeSet<&str> {
        let begin = format!("<path class=\"{ink} line\" d=\"");
        let drawn = found.split(begin.as_str()).skip(1);
        drawn.map(|rest| rest.split('"').next().unwrap()).collect()
    };
    assert!(lines("forecast").len() > 9 && lines("forecast").is_disjoint(&lines("found")));
    check_figures(&visit, &page(&visit, "job.toml --tables kit --language de"), "");
    // As left: the same machine measured with the tables, which the simulation predicts.
    visit.yes("simulate job.toml --tables kit --errors -o after.csv");
    let left = page(&visit, "job.toml --tables kit --after after.csv");
    holds(&left, &["/terms/EXX/after_um", "As left"]);
    holds(&left, &["REHEARSAL", "the values afterwards were simulated"]);
    check_figures(&visit, &left, "--after after.csv");
    // Who measured it again, and with what, where a second job says so.
    let protocol = "\n[measurement.protocol]\nby = \"A. Person\"\ntripod = \"granite\"\n";
    visit.put("after.toml", visit.read("job.toml") + protocol);
    visit.edit("after.toml", "\"errors.csv\"", "\"after.csv\"");
    visit.edit("after.toml", "\"none\"", "\"kit\"").edit("after.toml", "11-20", "11-23");
    let left = page(&visit, "job.toml --tables kit --after after.toml");
    let dates = "As found: 2026-11-20; As left: 2026-11-23";
    holds(&left, &[dates, "As left: A. Person", "As left: granite"]);
}

/// Each family, with a second measurement: its page is as long as it gets.
#[test]
fn it_works_for_every_control() {
    in_parallel(["siemens-828d", "fanuc-30i", "fanuc-0i-f", "fanuc-16i", "generic"], |id| {
        let visit = Visit::with_job(&format!("nine_errors_900/{id}.toml")).with_any_kit();
        let left = page(&visit, "job.toml --tables kit --after errors.csv");
        check_figures(&visit, &left, "--after errors.csv");
        assert_eq!(page(&visit, "job.toml"), page(&visit, "job.toml"), "{id}");
    });
}

#[test]
fn files_are_named_by_purpose_and_nothing_is_called_complete_that_is_not_known() {
    let visit = Visit::with_job(SIEMENS).with_any_kit();
    let complete = "All nine errors were measured";
    holds(&page(&visit, "job.toml --tables kit"), &[complete]);
    // What each file of a kit is for, in the reader's language.
    for (language, proof) in [("en", "sign proof"), ("de", "Vorzeichenprobe"), ("zh", "符号验证")]
    {
        let page = page(&visit, &format!("job.toml --tables kit --language {language}"));
        let (_, files) = page.split_once("NONIUS_EEC.MPF</td>").unwrap();
        let files = files.split("</table>").next().unwrap();
        holds(files, &[&format!(">{proof}<")]);
        lacks(files, &[">sign-proof<", ">table<"]);
    }
    std::fs::remove_file(visit.at("kit/manifest.json")).unwrap();
    let page = page(&visit, "job.toml --tables kit");
    lacks(&page, &[complete, "No file of this kit disables"]);
    // The last is what the verdict rests on.
    holds(&page, &["has no manifest.json", "U is not stated and counted as 0"]);
}

#[test]
fn it_works_from_errors_or_readings_alone_in_every_language_and_in_inches() {
    for job in ["start/errors", "start/readings"] {
        for language in ["en", "de", "zh"] {
            let page = page(&Visit::of(job), &format!("job.toml --language {language}"));
            holds(&page, &[&format!("<html lang=\"{language}\">")]);
            assert!(page.len() < 1_000_000, "{job}: {} bytes", page.len());
            lacks(&page, &["<script", "http://", "https://"]);
        }
    }
    let page = page(&Visit::of("start/errors"), "job.toml --unit inch"); // the document: in µm
    let mut errors = figures(&page).filter(|(um, _, at, _)| at.ends_with("before_um") && *um > 1.0);
    let (um, .., shown) = errors.next().unwrap();
    assert!((shown.parse::<f64>().unwrap() - um / 0.0254).abs() < 0.0501, "{shown} for {um} µm");
    let first = text_of(page.split("</section>").next().unwrap());
    assert!(first.contains("µin") && !first.contains(" mm"), "{first}");
}

/// What stands in the pictures of a page, and what a reader who cannot see them is told.
fn drawn(page: &str) -> Vec<String> {
    let word = |rest: &str| {
        let (tag, words) = rest.split_once('>')?;
        let is_text = ["text", "title", "desc"].contains(&tag.split(' ').next()?);
        is_text.then(|| words.to_string())
    };
    let pictures = page.split("<svg ").skip(1).map(|rest| rest.split("</svg>").next().unwrap());
    let texts = pictures.flat_map(|picture| {
        let label = picture.split("aria-label=\"").nth(1).and_then(|rest| rest.split('"').next());
        picture.split('<').filter_map(word).chain(label.map(str::to_string))
    });
    texts.collect()
}

/// What pictures of every kind that stands on a page are made from.
fn with_pictures() -> [Visit; 3] {
    let visit = Visit::with_job(SIEMENS).with_any_kit();
    visit.yes("simulate job.toml --tables kit --errors -o after.csv");
    visit.copy("standards/x_axis.csv", "x_axis.csv");
    [visit, Visit::of("start/readings"), Visit::with_job("machine_h/job.toml")]
}

/// Their pages: curves with tables and as left, runs, diagonals, volume.
fn pages_with_pictures([left, readings, found]: &[Visit; 3], options: &str) -> String {
    let of_left = "job.toml --tables kit --after after.csv --linear x_axis.csv";
    let as_found = [readings, found].map(|visit| page(visit, &format!("job.toml {options}")));
    page(left, &format!("{of_left} {options}")) + &as_found.concat()
}

fn words(texts: &[String]) -> BTreeSet<&str> {
    let words = texts.iter().flat_map(|text| text.split(|c: char| !c.is_alphabetic()));
    words.filter(|word| word.chars().count() > 3).collect()
}

/// No word of the English texts is left in others but names; nothing is left to fill in.
fn is_translated(language: &str, texts: &[String], english: &[String], names: &[&str]) {
    let (own, english) = (words(texts), words(english));
    let left: Vec<_> = own.intersection(&english).filter(|word| !names.contains(word)).collect();
    assert!(left.is_empty(), "{language}: {left:?}");
    assert!(texts.iter().all(|text| !text.contains('{')), "{texts:?}");
}

#[test]
fn pictures_speak_the_language_of_their_page() {
    let visits = with_pictures();
    let pages = |language| pages_with_pictures(&visits, &format!("--language {language}"));
    let [english, german, chinese] = ["en", "de", "zh"].map(|language| drawn(&pages(language)));
    assert!(words(&english).len() > 40, "{english:?}");
    // Names of machines, controls and files.
    let names = ["golden", "SINUMERIK", "Siemens", "axis", "machine"];
    for (language, texts) in [("de", &german), ("zh", &chinese)] {
        assert_eq!(texts.len(), english.len(), "{language}");
        is_translated(language, texts, &english, &names);
    }
    let is_point = |w: &[u8]| w[0].is_ascii_digit() && w[1] == b'.' && w[2].is_ascii_digit();
    let point = |text: &&String| text.as_bytes().windows(3).any(is_point);
    assert_eq!(german.iter().find(point), None, "a decimal point");
    assert!(german.contains(&"vorgefunden, längster Pfeil 36,851 µm".to_string()), "{german:?}");
}

/// The text of a part of a page, without its elements; spans and links are words of it.
fn text_of(part: &str) -> String {
    let texts = part.split('<').filter_map(|rest| rest.split_once('>'));
    texts.map(|(_, text)| text).collect::<Vec<_>>().join(" ")
}

/// Machine 900, of which nothing is decided: U is large, a limit for the diagonals, keys without use, a doubt.
fn undecided() -> Visit {
    let visit = Visit::with_job(SIEMENS);
    visit.with_column("errors.csv", ",u_ex_um,u_ey_um,u_ez_um", ",3.2,3.2,3.2");
    doubted(&visit);
    let limits = "max_deviation_um = 4.0\nmax_diagonal_um = 6.0\nrange_mm = { x = [0.0, 850.0] }";
    visit.edit("job.toml", "max_deviation_um = 10.0", limits);
    visit
}

/// The program's own sentences stand behind it, under words that say so.
#[test]
fn the_first_page_speaks_the_readers_language() {
    let visit = undecided();
    let first = |language| {
        let page = page(&visit, &format!("job.toml --language {language}"));
        let (_, body) = page.split_once("<body>").unwrap();
        let (first, behind) = body.split_once("</section>").unwrap();
        let lists = behind.split("<ul lang=\"en\">");
        let said: Vec<bool> = lists.map(|before| before.trim_end().ends_with("</p>")).collect();
        let (_, said) = said.split_last().unwrap();
        let is_english = language == "en";
        assert!(!said.is_empty() && said.iter().all(|is| *is != is_english), "{language}");
        [text_of(first)]
    };
    let english = first("en");
    assert!(words(&english).contains("temperature"), "{english:?}");
    let names = ["golden", "SINUMERIK", "Siemens", "temperature", "Position", "Name"];
    for language in ["de", "zh"] {
        is_translated(language, &first(language), &english, &names);
    }
}

/// A few lines on the first page, the worst first; all of them, with the figures of `verify`, behind it.
#[test]
fn nothing_that_decides_is_lost() {
    let visit = undecided().with_any_kit();
    let whole = page(&visit, "job.toml --tables kit --language de --unit inch");
    let verify = visit.json("verify job.toml --tables kit");
    let causes = verify["causes"].as_array().unwrap().iter();
    let misses = causes.filter(|cause| cause.as_str().unwrap().contains("the limit is")).count();
    let reasons = items(&whole, "reasons");
    assert_eq!([misses, reasons.len()], [13; 2], "nine errors and four diagonals");
    let (verdict, _) = whole.split_once("</section>").unwrap();
    let (_, verdict) = verdict.split_once("class=\"verdict").unwrap();
    let shown: Vec<&str> = verdict.split("<li>").skip(1).collect();
    assert!(shown.len() == 5 && shown[3].starts_with("10 weitere"), "{shown:?}");
    assert!(shown[4].starts_with("Zweifel an der Messung (1)"), "{shown:?}");
    for (line, reason) in shown.iter().zip(&reasons[..3]) {
        assert!(line.starts_with(reason.as_str()), "{line} / {reason}");
    }
    let u = number(&verify["diagonals"]["NPP"]["at_most_um"]) / 0.0254;
    let u = format!("{u:.2}").replace('.', ",");
    assert!(text_of(&reasons[0]).contains(&u), "{reasons:?}: {u}");
    assert!(reasons[0].contains("236,2 µin") && !reasons[0].contains("µm "), "{reasons:?}");
    let findings = items(&whole, "findings").concat();
    holds(&findings, &["active_while_measuring"]);
    lacks(&findings, &["the limit is"]);
}

/// 900 mm are 35.43 in: 10 in lie at 254/900 of the axis; EXX ends at 18 µm = 708.66 µin on a scale of ±1000 µin.
#[test]
fn pictures_of_a_page_in_inches_are_in_inches() {
    let page = pages_with_pictures(&with_pictures(), "--unit inch");
    let texts = drawn(&page);
    let mut units = texts.iter().flat_map(|text| text.split([' ', ',', ';']));
    assert_eq!(units.find(|unit| ["mm", "µm"].contains(unit)), None);
    for label in ["X / in", "µin", "difference / µin", "target / in"] {
        assert!(texts.iter().any(|text| text == label), "{label}");
    }
    let (left, width, top, height) = (46.0, 224.0, 70.0, 122.0);
    let ten = left + width * 254.0 / 900.0;
    let tick = format!("<text class=\"m\" x=\"{ten:.2}\" ");
    let is_ten = |line: &str| line.starts_with(&tick) && line.ends_with(">10</text>");
    assert!(page.lines().any(is_ten), "{tick}");
    let end = top + height * (1.0 - (18.0 / 0.0254 + 1000.0) / 2000.0);
    let found = page.split("<path class=\"found line\" d=\"").nth(2);
    let found = found.and_then(|rest| rest.split('"').next()).expect("EXX");
    assert!(found.ends_with(&format!("L270,{end:.2}")), "{end}: {found}");
}

#[test]
fn text_of_others_is_shown_and_not_obeyed() {
    let visit = Visit::of("start/errors");
    let evil = r#"<img src=x onerror=\"alert(1)\">&;()'"#;
    // A serial number goes into comments of the control's files, which refuse it: as found there are none.
    let job = visit.read("job.toml");
    let (job, _) = job.split_once("[compensation]").unwrap();
    let protocol = format!("[measurement.protocol]\nby = \"{evil}\"\n\"a<b>\" = \"</section>\"");
    let serial = format!("\nserial = \"{evil}\"\nname = ");
    visit.put("job.toml", replaced(job, "\nname = ", &serial) + &protocol);
    let page = page(&visit, "job.toml");
    holds(&page, &["&lt;img src=x onerror="]);
    lacks(&page, &["<img src=x", "a<b>"]);
    holds(&page, &["\\3c img src\\3d x"]); // in the style of the print
}

#[test]
fn a_template_and_texts_of_ones_own() {
    let visit = Visit::of("start/errors");
    visit.put("own.tera", "{{ machine.name }}: {{ verdict.word }}\n");
    let own = page(&visit, "job.toml --template own.tera");
    assert!(own.ends_with(": PASS\n"), "{own}");
    let english = repository_page("templates/report/en.toml");
    visit.put("cs.toml", replaced(&english, "\"PASS\"", "\"VYHOVUJE\""));
    holds(&page(&visit, "job.toml --language cs.toml"), &["VYHOVUJE", "<html lang=\"cs\">"]);
    visit.put("short.toml", "title = \"x\"\n");
    visit.put("long.toml", format!("{english}\nother = \"x\"\n"));
    for (texts, words) in [("short.toml", "lacks"), ("long.toml", "unknown keys: other")] {
        visit.run(&format!("report job.toml --language {texts} -o -")).ends(2).says(words);
    }
}
