//! The page that is handed over: its figures are those of the commands, its bytes are the same twice, text of
//! others is harmless, and a browser shows it without anything cut off.
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn nonius(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_nonius"));
    let command = command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments);
    command.output().expect("the program runs")
}

fn document(arguments: &[&str]) -> Value {
    let output = nonius(&[arguments, &["--format", "json"]].concat());
    let words = String::from_utf8_lossy(&output.stderr);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{arguments:?}: {words}"))
}

fn page(arguments: &[&str]) -> String {
    let output = nonius(&[&["report"], arguments, &["-o", "-"]].concat());
    assert_ne!(output.status.code(), Some(2), "{}", String::from_utf8_lossy(&output.stderr));
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
        (number, command.to_string(), at.to_string(), shown.to_string())
    });
    figures.collect()
}

fn kit(folder: &Path, job: &str) -> PathBuf {
    let kit = folder.join("kit");
    let output = nonius(&["generate", job, "-q", "-o", kit.to_str().expect("a name")]);
    assert_ne!(output.status.code(), Some(2), "{}", String::from_utf8_lossy(&output.stderr));
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
        ("assess", document(&["assess", job, "--tables", tables, "--grid", "11,11,11"])),
        ("kit", serde_json::from_slice(&manifest).expect("a manifest is JSON")),
    ];
    check_documents(page, &documents, 30);
}

/// Compares every figure with the document that it names; there are more than `least` of them.
fn check_documents(page: &str, documents: &[(&str, Value)], least: usize) {
    let figures = figures(page);
    assert!(figures.len() > least, "only {} figures", figures.len());
    for (number, command, at, shown) in figures {
        let found = documents.iter().find(|(name, _)| *name == command);
        let (_, document) = found.unwrap_or_else(|| panic!("{command} is no command"));
        let value = document.pointer(&at).and_then(Value::as_f64);
        assert_eq!(value, Some(number), "{command} {at}");
        let shown = shown.replace('\u{2212}', "-").replace(',', ".");
        let decimals = shown.split_once('.').map_or(0, |(_, after)| after.len());
        let read: f64 = shown.parse().expect("a figure is a number");
        let digits = u32::try_from(decimals).expect("few decimals");
        let half = 0.5 / nonius::quantity::units::power_of_ten(digits);
        assert!((read - number).abs() <= half * 1.001, "{command} {at}: {shown} for {number}");
    }
}

/// The sentences of a part.
fn items(page: &str, part: &str) -> Vec<String> {
    let (_, rest) = page.split_once(&format!("<section id=\"{part}\"")).expect("the part");
    let (part, _) = rest.split_once("</section>").expect("the end of the part");
    let items = part.split("<li>").skip(1);
    let items = items.map(|item| item.split("</li>").next().expect("an item").to_string());
    items.collect()
}

/// A job of a folder without what it says of tables.
fn without_tables(folder: &Path, job: &str) -> String {
    let text = std::fs::read_to_string(job).expect("a job");
    let (before, after) = text.split_once("[compensation]").expect("tables");
    let acceptance = after.find("[acceptance]").map_or("", |at| &after[at..]);
    let path = folder.join("job.toml");
    std::fs::write(&path, format!("{before}{acceptance}")).expect("a job");
    path.to_str().expect("a name").to_string()
}

/// Largest |value − value at the reference| of a column, µm, by hand.
fn largest(table: &str, axis: &str, column: usize) -> f64 {
    let rows = table.lines().filter(|line| line.starts_with(axis));
    let value = |line: &str| line.split(',').nth(column)?.parse().ok();
    let values: Vec<f64> = rows.filter_map(value).collect();
    let from_first = values.iter().map(|um| (um - values[0]).abs());
    from_first.fold(0.0, f64::max)
}

/// Machine H states no tables: each error as found, diagonals, volume, and no word of a forecast.
#[test]
fn without_tables_it_shows_the_machine_as_found() {
    let job = "fixtures/machine_h/job.toml";
    let assess = document(&["assess", job, "--grid", "11,11,11"]);
    let english = page(&[job]);
    check_documents(&english, &[("assess", assess.clone())], 18);
    let table = std::fs::read_to_string("fixtures/machine_h/errors.csv").expect("a table");
    for (term, axis, column) in [("EXX", "x", 2), ("EYY", "y", 3), ("EZZ", "z", 4)] {
        let found = &assess["terms"][term]["before_um"];
        let um = found.as_f64().expect("a figure");
        assert!((um - largest(&table, axis, column)).abs() < 1e-6, "{term} {um}");
    }
    assert!(english.contains("AS FOUND") && english.contains("no tables are given"));
    for word in ["Forecast", "As left", "PASS", "Tables of the control", "Rollback"] {
        assert!(!english.contains(word), "{word}");
    }
    assert!(english.contains("/definitions/diagonals_um/PNP") && english.contains("EYX"));
    let folder = tempfile::tempdir().expect("a place to write to");
    let place = folder.path().join("page.html");
    let place = place.to_str().expect("a name");
    let output = nonius(&["report", job, "-o", place, "--format", "json"]);
    let said: Value = serde_json::from_slice(&output.stdout).expect("a document");
    assert_eq!((&said["verdict"], output.status.code()), (&"as-found".into(), Some(0)));
}

/// Of an error table alone nobody knows the machine; U is that of a value known to 1 µm: 1.96 µm (95 %).
#[test]
fn an_error_table_alone_will_do() {
    let folder = tempfile::tempdir().expect("a place to write to");
    let table = folder.path().join("errors.csv");
    let rows = "axis,position_mm,ex_um,u_ex_um\nx,0,0,0\nx,100,2,0.1\nx,200,50,1\n";
    std::fs::write(&table, rows).expect("a table");
    let table = table.to_str().expect("a name");
    let found = page(&[table]);
    let assess = document(&["assess", table, "--grid", "11,1,1"]);
    let terms = &assess["terms"]["EXX"];
    assert_eq!(terms["before_um"].as_f64(), Some(50.0));
    let expanded = terms["expanded_um"].as_f64().expect("U");
    assert!((expanded - 1.95996).abs() < 0.0001, "{expanded}");
    assert!(found.contains("errors.csv") && found.contains("<code>"), "its hash");
    assert!(!found.contains("/definitions/diagonals_um"), "one error makes no diagonal");
    assert!(items(&found, "missing_found").iter().any(|item| item.starts_with("EYY")));
}

/// Readings without tables: figures of the diagonals, squareness from the totals with its U, the doubt first.
#[test]
fn readings_without_tables_keep_their_doubts() {
    let folder = tempfile::tempdir().expect("a place to write to");
    let case_d = Path::new("fixtures/diagonals/case_d_bidirectional");
    std::fs::copy(case_d.join("readings.csv"), folder.path().join("readings.csv"))
        .expect("readings");
    let job = case_d.join("job.toml");
    let job = without_tables(folder.path(), job.to_str().expect("a name"));
    let found = page(&[&job]);
    let separate = document(&["separate", &job, "--trials", "0"]);
    let assess = document(&["assess", &job, "--grid", "11,11,11"]);
    for plane in ["xy", "xz", "yz"] {
        let squareness = &assess["squareness"][plane];
        assert_eq!(squareness["before_um_per_m"], separate["squareness_um_per_m"][plane]);
        let u = separate["u_squareness_um_per_m"][plane].as_f64().expect("u");
        let expanded = squareness["expanded_um_per_m"].as_f64().expect("U");
        assert!((1.9..2.1).contains(&(expanded / u)), "{plane}: {expanded}, u {u}");
    }
    let standards = document(&["standards", &job]);
    check_documents(&found, &[("assess", assess), ("standards", standards)], 30);
    let (verdict, _) = found.split_once("Largest deviation").expect("the first page");
    assert!(verdict.contains("reversal"), "the reversal that no curve holds is a doubt");
    assert!(!verdict.contains('\u{2264}'), "a limit that nothing was judged by");
}

#[test]
fn runs_of_an_axis_are_shown_by_standard() {
    let job = "fixtures/machine_h/job.toml";
    let runs = "fixtures/standards/x_axis.csv";
    let found = page(&[job, "--linear", runs, "--linear", runs]);
    let documents = [
        ("assess", document(&["assess", job, "--grid", "11,11,11"])),
        ("standards:1", document(&["standards", runs])),
        ("standards:2", document(&["standards", runs])),
    ];
    check_documents(&found, &documents, 40);
    assert!(found.contains("standards:2 /iso_230_2/A_um"));
    assert!(found.contains("the travel is not stated") && !found.contains("--travel-mm"));
    let output =
        nonius(&["report", job, "--linear", "fixtures/formats/sample_synthetic.rtl", "-o", "-"]);
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.code() == Some(2) && words.contains("expected runs of one axis (CSV)"),
        "{words}"
    );
}

/// Angles need the order of the axes: without it the page says why it has no figures of the volume.
#[test]
fn a_volume_that_cannot_be_computed_is_told() {
    let folder = tempfile::tempdir().expect("a place to write to");
    let from = Path::new("fixtures/machines/five_points");
    let table = std::fs::read_to_string(from.join("errors.csv")).expect("a table");
    let with_angle = table.lines().map(|line| match line {
        line if line.starts_with('#') => line.to_string(),
        line if line.starts_with("axis") => format!("{line},ec_urad"),
        line => format!("{line},1"),
    });
    let table = with_angle.collect::<Vec<_>>().join("\n");
    std::fs::write(folder.path().join("errors.csv"), table).expect("a table");
    let job = std::fs::read_to_string(from.join("generic.toml")).expect("a job");
    let job = job.lines().filter(|line| !line.starts_with("chain"));
    let job = job.collect::<Vec<_>>().join("\n");
    let place = folder.path().join("job.toml");
    std::fs::write(&place, job).expect("a job");
    let page = page(&[place.to_str().expect("a name")]);
    assert!(items(&page, "volume")[0].contains("`machine.chain` is missing"));
}

/// What both measurements find stands once.
#[test]
fn a_finding_stands_once() {
    let folder = tempfile::tempdir().expect("a place to write to");
    let from = Path::new("fixtures/nine_errors_900");
    std::fs::copy(from.join("errors.csv"), folder.path().join("errors.csv")).expect("a copy");
    let job = std::fs::read_to_string(from.join("siemens-840d-sl.toml")).expect("a job");
    let job = job.lines().filter(|line| !line.starts_with("active_while_measuring"));
    let job = job.collect::<Vec<_>>().join("\n");
    let place = folder.path().join("job.toml");
    let unused = "[measurement.uncertainty]\ntemperature_k = 0.3\n";
    std::fs::write(&place, format!("{job}\n{unused}")).expect("a job");
    let job = place.to_str().expect("a name");
    let kit = kit(folder.path(), job);
    let tables = kit.to_str().expect("a name");
    let verify = document(&["verify", job, "--tables", tables, "--after", job]);
    let notes = verify["notes"].as_array().expect("notes").iter();
    let is_unused = |words: &str| words.starts_with("`temperature_k`");
    let both = notes.filter(|note| is_unused(note.as_str().unwrap_or_default()));
    assert_eq!(both.count(), 2, "one of each measurement");
    let left = page(&[job, "--tables", tables, "--after", job]);
    let once = items(&left, "findings").into_iter().filter(|item| is_unused(item));
    assert_eq!(once.count(), 1);
}

#[test]
fn every_figure_is_that_of_its_command() {
    let folder = tempfile::tempdir().expect("a place to write to");
    let job = "fixtures/nine_errors_900/siemens-840d-sl.toml";
    let kit = kit(folder.path(), job);
    let tables = kit.to_str().expect("a name");
    check_figures(&page(&[job, "--tables", tables]), job, &kit, None);
    check_figures(&page(&[job, "--tables", tables, "--language", "de"]), job, &kit, None);
    // As left: the same machine measured with the tables, which the simulation predicts.
    let after = folder.path().join("after.csv");
    let after = after.to_str().expect("a name");
    let made = nonius(&["simulate", job, "--tables", tables, "--errors", "-o", after]);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let left = page(&[job, "--tables", tables, "--after", after]);
    assert!(left.contains("/terms/EXX/after_um") && left.contains("As left"));
    assert!(left.contains("REHEARSAL") && left.contains("the values afterwards were simulated"));
    check_figures(&left, job, &kit, Some(after));
    // Who measured it again, and with what, where a second job says so.
    let text = std::fs::read_to_string(job).expect("a job");
    let text = text.replace("\"errors.csv\"", "\"after.csv\"");
    let text = text.replace("= \"none\"", "= \"kit\"");
    let text = text.replace("2026-11-20", "2026-11-23");
    let text =
        format!("{text}\n[measurement.protocol]\nby = \"A. Person\"\ntripod = \"granite\"\n");
    let second = folder.path().join("after.toml");
    std::fs::write(&second, text).expect("a job");
    let second = second.to_str().expect("a name");
    let left = page(&[job, "--tables", tables, "--after", second]);
    for said in
        ["As found: 2026-11-20; As left: 2026-11-23", "As left: A. Person", "As left: granite"]
    {
        assert!(left.contains(said), "{said}");
    }
}

/// Each family, with a second measurement: its page is as long as it gets.
#[test]
fn it_works_for_every_control() {
    let folder = tempfile::tempdir().expect("a place to write to");
    for id in ["siemens-828d", "fanuc-30i", "fanuc-0i-f", "fanuc-16i", "generic"] {
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
    assert!(!page.contains(complete) && !page.contains("No file of this kit disables"));
    assert!(page.contains("has no manifest.json"));
    assert!(page.contains("U is not stated and counted as 0"), "what the verdict rests on");
}

#[test]
fn it_works_from_errors_or_readings_alone_in_every_language() {
    for job in ["fixtures/start/errors/job.toml", "fixtures/start/readings/job.toml"] {
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
    assert!((read - number / 0.0254).abs() < 0.0501, "{shown} for {number} µm");
    assert!(page.contains("µin"));
}

/// What stands in the pictures of a page, and what a reader who cannot see them is told.
fn drawn(page: &str) -> Vec<String> {
    let pictures = page.split("<svg ").skip(1);
    let pictures = pictures.map(|rest| rest.split("</svg>").next().expect("a picture"));
    let texts = pictures.flat_map(|picture| {
        let texts = picture.split('<').filter_map(|rest| {
            let (tag, words) = rest.split_once('>')?;
            let tag = tag.split(' ').next()?;
            ["text", "title", "desc"].contains(&tag).then_some(words)
        });
        let label = picture.split("aria-label=\"").nth(1);
        texts.chain(label.and_then(|rest| rest.split('"').next()))
    });
    texts.map(str::to_string).collect()
}

/// Pictures of every kind that stands on a page: curves with tables and as left, runs, diagonals, volume.
fn pages_with_pictures(folder: &Path, options: &[&str]) -> String {
    let job = "fixtures/nine_errors_900/siemens-840d-sl.toml";
    let kit = kit(folder, job);
    let tables = kit.to_str().expect("a name");
    let after = folder.join("after.csv");
    let after = after.to_str().expect("a name");
    nonius(&["simulate", job, "--tables", tables, "--errors", "-o", after]);
    let runs = "fixtures/standards/x_axis.csv";
    let left = [job, "--tables", tables, "--after", after, "--linear", runs];
    let readings = ["fixtures/start/readings/job.toml"];
    let found = ["fixtures/machine_h/job.toml"];
    let pages = [&left[..], &readings, &found];
    pages.map(|of| page(&[of, options].concat())).concat()
}

/// Words of four letters or more, as they are written.
fn words(texts: &[String]) -> BTreeSet<&str> {
    let words = texts.iter().flat_map(|text| text.split(|c: char| !c.is_alphabetic()));
    words.filter(|word| word.chars().count() > 3).collect()
}

#[test]
fn pictures_speak_the_language_of_their_page() {
    let folder = tempfile::tempdir().expect("a place to write to");
    let drawn_in = |language| {
        let folder = folder.path().join(language);
        drawn(&pages_with_pictures(&folder, &["--language", language]))
    };
    let english = drawn_in("en");
    let english_words = words(&english);
    assert!(english_words.len() > 40, "{english:?}");
    // Names of machines, controls and files.
    let names = ["golden", "SINUMERIK", "Siemens", "axis", "machine"];
    let [german, chinese] = ["de", "zh"].map(drawn_in);
    for (language, texts) in [("de", &german), ("zh", &chinese)] {
        assert_eq!(texts.len(), english.len(), "{language}");
        let own = words(texts);
        let left = own.intersection(&english_words).copied();
        let left: Vec<&str> = left.filter(|word| !names.contains(word)).collect();
        assert!(left.is_empty(), "{language}: {left:?}");
        assert!(texts.iter().all(|text| !text.contains('{')), "{texts:?}");
    }
    let is_point = |w: &[u8]| w[0].is_ascii_digit() && w[1] == b'.' && w[2].is_ascii_digit();
    let point = |text: &&String| text.as_bytes().windows(3).any(is_point);
    assert_eq!(german.iter().find(point), None, "a decimal point");
    let arrow = "vorgefunden, längster Pfeil 36,851 µm";
    assert!(german.iter().any(|text| text == arrow), "{german:?}");
}

/// The text of a part of a page, without its elements; spans and links are words of it.
fn text_of(part: &str) -> String {
    let texts = part.split('<').filter_map(|rest| rest.split_once('>'));
    texts.map(|(_, text)| text).collect::<Vec<_>>().join(" ")
}

/// Machine 900, of which nothing is decided: U is large, a limit for the diagonals, keys without use, a doubt.
fn undecided(folder: &Path) -> String {
    let from = Path::new("fixtures/nine_errors_900");
    let table = std::fs::read_to_string(from.join("errors.csv")).expect("a table");
    let rows = table.lines().map(|line| match line.as_bytes()[0] {
        b'#' => line.to_string(),
        b'a' => format!("{line},u_ex_um,u_ey_um,u_ez_um"),
        _ => format!("{line},3.2,3.2,3.2"),
    });
    let table = rows.collect::<Vec<_>>().join("\n");
    std::fs::write(folder.join("errors.csv"), table).expect("a table");
    let job = std::fs::read_to_string(from.join("siemens-840d-sl.toml")).expect("a job");
    let job = job.replace("active_while_measuring = \"none\"\n", "");
    let limits = "max_deviation_um = 4.0\nmax_diagonal_um = 6.0\nrange_mm = { x = [0.0, 850.0] }";
    let job = job.replace("max_deviation_um = 10.0", limits);
    let place = folder.join("job.toml");
    let unused = "[measurement.uncertainty]\ntemperature_k = 0.3\n";
    std::fs::write(&place, format!("{job}\n{unused}")).expect("a job");
    place.to_str().expect("a name").to_string()
}

/// Everything on the first page is in the reader's language; the program's own sentences stand behind it, under
/// words that say so.
#[test]
fn the_first_page_speaks_the_readers_language() {
    let folder = tempfile::tempdir().expect("a place to write to");
    let job = undecided(folder.path());
    let first = |language| {
        let page = page(&[&job, "--language", language]);
        let (_, body) = page.split_once("<body>").expect("a body");
        let (first, behind) = body.split_once("</section>").expect("the first page");
        let lists = behind.split("<ul lang=\"en\">");
        let said: Vec<bool> = lists.map(|before| before.trim_end().ends_with("</p>")).collect();
        let (_, said) = said.split_last().expect("a list of findings");
        let is_english = language == "en";
        assert!(!said.is_empty() && said.iter().all(|is| *is != is_english), "{language}");
        text_of(first)
    };
    let english = vec![first("en")];
    let english = words(&english);
    assert!(english.contains("temperature_k") || english.contains("temperature"), "{english:?}");
    let names = ["golden", "SINUMERIK", "Siemens", "temperature", "Position", "Name"];
    for language in ["de", "zh"] {
        let own = vec![first(language)];
        let own = words(&own);
        let left = own.intersection(&english).copied();
        let left: Vec<&str> = left.filter(|word| !names.contains(word)).collect();
        assert!(left.is_empty(), "{language}: {left:?}");
        assert!(!own.iter().any(|word| word.contains('{')));
    }
}

/// A few lines on the first page, the worst first; all of them, with the figures of `verify`, behind it.
#[test]
fn nothing_that_decides_is_lost() {
    let folder = tempfile::tempdir().expect("a place to write to");
    let job = undecided(folder.path());
    let kit = kit(folder.path(), &job);
    let tables = kit.to_str().expect("a name");
    let whole = page(&[&job, "--tables", tables, "--language", "de", "--unit", "inch"]);
    let verify = document(&["verify", &job, "--tables", tables]);
    let causes = verify["causes"].as_array().expect("causes").iter();
    let causes = causes.map(|cause| cause.as_str().expect("a sentence"));
    let misses = causes.filter(|cause| cause.contains("the limit is")).count();
    assert_eq!(misses, 13, "nine errors and four diagonals");
    let reasons = items(&whole, "reasons");
    assert_eq!(reasons.len(), misses);
    let (verdict, _) = whole.split_once("</section>").expect("the first page");
    let (_, verdict) = verdict.split_once("class=\"verdict").expect("the verdict");
    let shown: Vec<&str> = verdict.split("<li>").skip(1).collect();
    let more = format!("{} weitere", misses - 3);
    assert!(shown.len() == 5 && shown[3].starts_with(&more), "{shown:?}");
    assert!(shown[4].starts_with("Zweifel an der Messung (1)"), "{shown:?}");
    for (line, reason) in shown.iter().zip(&reasons[..3]) {
        assert!(line.starts_with(reason.as_str()), "{line} / {reason}");
    }
    let u = verify["diagonals"]["PPP"]["expanded_um"].as_f64().expect("U");
    let u = format!("{:.2}", u / 0.0254).replace('.', ",");
    assert!(text_of(&reasons[0]).contains(&u), "{reasons:?}: {u}");
    assert!(reasons[0].contains("236,2 µin") && !reasons[0].contains("µm "), "{reasons:?}");
    let findings = items(&whole, "findings");
    assert!(findings.iter().any(|words| words.contains("active_while_measuring")));
    assert!(!findings.iter().any(|words| words.contains("the limit is")));
}

/// 900 mm are 35.43 in: 10 in lie at 254/900 of the axis; EXX ends at 18 µm = 708.66 µin on a scale of ±1000 µin.
#[test]
fn pictures_of_a_page_in_inches_are_in_inches() {
    let folder = tempfile::tempdir().expect("a place to write to");
    let page = pages_with_pictures(folder.path(), &["--unit", "inch"]);
    let texts = drawn(&page);
    let metric = texts.iter().find(|text| {
        let units = text.split([' ', ',', ';']);
        units.into_iter().any(|unit| unit == "mm" || unit == "µm")
    });
    assert_eq!(metric, None);
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
    // A serial number goes into comments of the control's files, which refuse it: as found there are none.
    let (job, _) = job.split_once("[compensation]").expect("tables");
    let lines = job.lines().map(|line| match line.starts_with("name = ") {
        true => format!("{line}\nserial = \"{evil}\""),
        false => line.to_string(),
    });
    let protocol = format!("[measurement.protocol]\nby = \"{evil}\"\n\"a<b>\" = \"</section>\"");
    let lines: Vec<String> = lines.chain([protocol]).collect();
    let path = folder.path().join("job.toml");
    std::fs::write(&path, lines.join("\n")).expect("a job");
    let output = nonius(&["report", path.to_str().expect("a name"), "-o", "-"]);
    let page = String::from_utf8_lossy(&output.stdout);
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(page.contains("&lt;img src=x onerror="), "{words}");
    assert!(!page.contains("<img src=x") && !page.contains("a<b>"));
    assert!(page.contains("\\3c img src\\3d x"), "in the style of the print");
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
        ("long.toml", &format!("{english}\nother = \"x\"\n"), "unknown keys: other"),
    ] {
        let texts = put(name, text);
        let output = nonius(&["report", job, "--language", &texts, "-o", "-"]);
        let words = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && words.contains(says), "{words}");
    }
}

/// What each file of a kit is for, in the reader's language.
#[test]
fn the_purpose_of_a_file_is_no_word_of_the_manifest() {
    let folder = tempfile::tempdir().expect("a place to write to");
    let job = "fixtures/nine_errors_900/siemens-840d-sl.toml";
    let kit = kit(folder.path(), job);
    let tables = kit.to_str().expect("a name");
    for (language, proof) in [("en", "sign proof"), ("de", "Vorzeichenprobe"), ("zh", "符号验证")]
    {
        let page = page(&[job, "--tables", tables, "--language", language]);
        let (_, files) = page.split_once("NONIUS_EEC.MPF</td>").expect("the files");
        let files = files.split("</table>").next().expect("a table");
        assert!(files.contains(&format!(">{proof}<")), "{language}: {files}");
        assert!(!files.contains(">sign-proof<") && !files.contains(">table<"), "{files}");
    }
}
