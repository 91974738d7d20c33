//! The control of docs/controllers.md §3, added without Rust: the page's own files, from the profile to the second visit;
//! and what the built-in profiles of this dialect ask of files and checklists.
use std::fs;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// The fenced block behind a marker of the page, without its indent.
fn block(page: &str, marker: &str) -> String {
    let rest = page.split(marker).nth(1).expect(marker);
    let lines = rest.lines().skip_while(|line| !line.trim_start().starts_with("```"));
    let lines = lines.skip(1).take_while(|line| line.trim() != "```");
    let lines = lines.map(|line| line.strip_prefix("   ").unwrap_or(line));
    lines.map(|line| format!("{line}\n")).collect()
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn page() -> String {
    let page = fs::read_to_string(root().join("docs/controllers.md")).unwrap();
    page.replace("\r\n", "\n")
}

/// A folder with the page's profile and template, and a job with its errors.
fn visit() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    put("norden.toml", &block(&page(), "as `norden.toml`:"));
    put("n5.txt.tera", &block(&page(), "the template `n5.txt.tera` beside it."));
    let machine = root().join("fixtures/machines/five_points");
    let read = |name: &str| fs::read_to_string(machine.join(name)).unwrap();
    put("errors.csv", &read("errors.csv"));
    let job = read("generic.toml").replace("\"generic\"", "\"norden.toml\"");
    put("job.toml", &job.replace("\"two-tables\"", "\"mean\""));
    folder
}

/// Status and all that is printed.
fn nonius(folder: &TempDir, line: &str) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_nonius"))
        .current_dir(folder.path())
        .args(line.split(' '))
        .output()
        .unwrap();
    let said = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(said).unwrap())
}

/// The value of a point in a file.
fn value(text: &str, table: &str, point: u32) -> i64 {
    let rest = text.split(&format!("TABLE {table}\r\n")).nth(1).expect(table);
    let begin = format!("{point} ");
    let line = rest.lines().find(|line| line.starts_with(&begin)).unwrap();
    line[begin.len()..].parse().unwrap()
}

/// A directory with one file, as read out of the control.
fn read_out(folder: &TempDir, name: &str, text: &str) {
    fs::create_dir_all(folder.path().join(name)).unwrap();
    fs::write(folder.path().join(name).join("READ.TXT"), text).unwrap();
}

fn kit_file(folder: &TempDir, name: &str) -> String {
    fs::read_to_string(folder.path().join(name)).unwrap()
}

#[test]
fn the_profile_of_the_page_makes_files_that_read_back() {
    let folder = visit();
    let (status, said) = nonius(&folder, "controllers check norden.toml");
    assert_eq!(status, Some(0), "{said}");
    let (status, said) = nonius(&folder, "generate job.toml -o kit");
    assert!(matches!(status, Some(0 | 1)), "{said}");
    let text = kit_file(&folder, "kit/N5.TXT");
    // errors.csv: Y at 200 mm has -6 µm = +120 counts of 0.05 µm; X at 400 mm the mean 9.5 less 1.5 µm = -160.
    assert_eq!(value(&text, "Y BY Y", 5), 120, "{text}");
    assert_eq!(value(&text, "X BY X", 5), -160, "{text}");
    assert_eq!(value(&text, "Z BY Y", 5), -20, "{text}");
    assert!(text.contains("FIRST -200.000 STEP 100.000 POINTS 5\r\n1 "), "{text}");
    // The sample of the manual is a file of this control.
    let sample = block(&page(), "says on pages 88 and 89:");
    read_out(&folder, "sample", &sample);
    let (status, said) = nonius(&folder, "verify job.toml --tables sample");
    assert_eq!(status, Some(1), "{said}");
    assert!(!said.contains("no pattern"), "{said}");
}

#[test]
fn what_was_read_out_is_judged() {
    let folder = visit();
    nonius(&folder, "generate job.toml -o kit");
    let text = kit_file(&folder, "kit/N5.TXT");
    read_out(&folder, "right", &text);
    let (_, made) = nonius(&folder, "verify job.toml --tables kit");
    let (status, said) = nonius(&folder, "verify job.toml --tables right");
    assert_eq!(status, Some(0), "{said}\n{made}");
    read_out(&folder, "turned", &text.replace("\n5 120\r", "\n5 -120\r"));
    let (status, said) = nonius(&folder, "verify job.toml --tables turned");
    assert_eq!(status, Some(1), "{said}");
    assert!(said.contains("EYY") && said.contains("200.0000 mm"), "{said}");
    read_out(&folder, "foreign", &text.replace("\r\nEND", "\r\nWEIGHT 2\r\nEND"));
    let (status, said) = nonius(&folder, "verify job.toml --tables foreign");
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("no pattern of the profile takes this line"), "{said}");
    assert!(said.contains("READ.TXT:9:1"), "{said}");
}

#[test]
fn a_second_measurement_builds_on_what_was_active() {
    let folder = visit();
    nonius(&folder, "generate job.toml -o kit");
    let old = kit_file(&folder, "kit/N5.TXT");
    read_out(&folder, "active", &old);
    let job = kit_file(&folder, "job.toml");
    let second = job.replace("errors.csv", "second.csv");
    let second = second.replace("= \"none\"", "= \"active\"\nactive_terms_not_measured = \"keep\"");
    fs::write(folder.path().join("second.toml"), second).unwrap();
    // What the tables left: 1 µm more at each end of Y.
    let left = "axis,position_mm,ey_um\ny,-200,1\ny,0,0\ny,200,1\n";
    fs::write(folder.path().join("second.csv"), left).unwrap();
    let (status, said) = nonius(&folder, "generate second.toml -o second");
    assert!(matches!(status, Some(0 | 1)), "{said}");
    let new = kit_file(&folder, "second/N5.TXT");
    assert_eq!(value(&new, "Y BY Y", 5), value(&old, "Y BY Y", 5) - 20, "{new}");
    assert_eq!(value(&new, "Y BY Y", 1), value(&old, "Y BY Y", 1) - 20, "{new}");
    assert_eq!(value(&new, "X BY X", 5), value(&old, "X BY X", 5), "not measured: kept\n{new}");
}

#[test]
fn each_sign_proof_is_one_bump() {
    let folder = visit();
    nonius(&folder, "generate job.toml -o kit");
    for (name, tables) in [("SIGN-OWN.TXT", 3), ("SIGN-CROSS.TXT", 6)] {
        let text = kit_file(&folder, &format!("kit/{name}"));
        assert_eq!(text.matches("TABLE").count(), tables, "{text}");
        let points = text.lines().filter_map(|line| line.split_once(' '));
        let is_point = |(number, _): &(&str, &str)| number.parse::<u32>().is_ok();
        let values = points.filter(is_point).map(|(_, value)| value.parse::<i64>().unwrap());
        let bump: Vec<i64> = values.filter(|value| *value != 0).collect();
        assert_eq!(bump, [-400], "20 um, as correction\n{text}");
    }
    let checklist = kit_file(&folder, "kit/checklist.html");
    assert!(checklist.contains("SIGN-CROSS.TXT") && checklist.contains("20.0 µm"));
}

#[test]
fn a_mistake_in_the_profile_has_its_line() {
    let folder = visit();
    let profile = kit_file(&folder, "norden.toml");
    for (right, wrong, says) in [
        ("(?<value>", "(?<vaule>", "did you mean `value`?"),
        (
            "order = { value = \"ascending\"",
            "order = { value = \"upwards\"",
            "expected one of `ascending`, `descending`",
        ),
        (
            "(?<point>\\d+) (?<value>",
            "(?<point>\\d+),(?<value>",
            "no pattern of the profile takes this line",
        ),
        ("value_size = { value = 0.05", "value_size = { value = 0.1", ""),
    ] {
        assert!(profile.contains(right), "{right}");
        fs::write(folder.path().join("norden.toml"), profile.replace(right, wrong)).unwrap();
        let (status, said) = nonius(&folder, "controllers check norden.toml");
        assert_eq!(status, Some(if says.is_empty() { 0 } else { 2 }), "{wrong}: {said}");
        assert!(said.contains(says), "{wrong}: {said}");
        assert!(says.is_empty() || said.contains("-->"), "{wrong}: {said}");
    }
}

/// The X table of a Weihong cut at 200 of 400 mm: neither judged nor built upon.
#[test]
fn a_short_table_is_refused_where_outside_is_not_known() {
    let folder = tempfile::tempdir().unwrap();
    let machine = root().join("fixtures/machines/five_points");
    let put = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let job = fs::read_to_string(machine.join("weihong.toml")).unwrap();
    let errors = fs::read_to_string(machine.join("errors.csv")).unwrap();
    let active = "= \"active\"\nactive_terms_not_measured = \"keep\"\n\
                  active_backlash_um = { x = 0.0, y = 0.0, z = 0.0 }";
    put("job.toml", &job);
    put("errors.csv", &errors);
    put("second.toml", &job.replace("= \"none\"", active));
    nonius(&folder, "generate job.toml -o kit");
    let whole = kit_file(&folder, "kit/axeserr.dat");
    let is_cut = |line: &str| line.starts_with("300.000") || line.starts_with("400.000");
    let lines = whole.lines().filter(|line| !is_cut(line));
    let short: String = lines.map(|line| format!("{line}\r\n")).collect();
    assert_eq!(whole.lines().count() - short.lines().count(), 2, "{whole}");
    let verify = "verify job.toml --tables active";
    let build_on = "generate second.toml -o second";
    let words = "the table of X covers 0.000 mm to 200.000 mm, the travel of X with its reference point is 0.000 mm to 400.000 mm, and what this control adds outside a table is not known";
    for (text, line, expected) in
        [(&whole, verify, 0), (&short, verify, 1), (&short, build_on, 2), (&whole, build_on, 0)]
    {
        read_out(&folder, "active", text);
        let (status, said) = nonius(&folder, line);
        assert_eq!(status, Some(expected), "{line}: {said}");
        assert_eq!(said.contains(words), expected > 0, "{line}: {said}");
    }
}

/// What is written has no point behind an end of the travel; a table that was read out with one is refused.
#[test]
fn a_table_beyond_the_travel_is_refused_where_the_control_uses_no_point_there() {
    const X: &str = "travel_mm = [0.0, 400.0]\nreference_mm = 0.0";
    const OUTSIDE: &str = "travel_mm = [0.0, 400.0]\nreference_mm = -50.0";
    let folder = tempfile::tempdir().unwrap();
    let machine = root().join("fixtures/machines/five_points");
    let put = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let errors = fs::read_to_string(machine.join("errors.csv")).unwrap();
    let job = fs::read_to_string(machine.join("weihong.toml")).unwrap();
    put("errors.csv", &errors);
    let no_fit = "no spacing has points at both ends of this travel";
    for (right, wrong, says) in [
        (
            "[compensation.axes.y]\nspacing_mm = 100.0",
            "[compensation.axes.y]\nspacing_mm = 75.0",
            "`spacing_mm = 50` has points at both ends of the travel and none beyond",
        ),
        ("[0.0, 400.0]", "[0.0, 399.9995]", no_fit),
        (X, OUTSIDE, no_fit),
    ] {
        assert!(job.contains(right), "{right}");
        put("job.toml", &job.replace(right, wrong));
        let (status, said) = nonius(&folder, "generate job.toml -o kit");
        assert_eq!(status, Some(2), "{wrong}: {said}");
        assert!(said.contains("would have points beyond the travel"), "{said}");
        assert!(said.contains(says), "{wrong}: {said}");
        assert!(!folder.path().join("kit").exists());
    }
    put("job.toml", &job);
    nonius(&folder, "generate job.toml -o kit");
    let text = kit_file(&folder, "kit/axeserr.dat");
    let beyond = text.replace("200.000, -0.006, -0.006", "225.000, -0.006, -0.006");
    read_out(&folder, "beyond", &beyond);
    let (status, said) = nonius(&folder, "verify job.toml --tables beyond");
    assert_eq!(status, Some(1), "{said}");
    let words = "this control does not use points beyond the travel";
    assert!(said.contains(words), "{said}");
}

/// Steps of a profile stand behind those of the one that it builds on, each at the end of its part.
#[test]
fn a_profile_adds_steps_to_the_checklist_of_its_base() {
    let folder = tempfile::tempdir().unwrap();
    let machine = root().join("fixtures/machines/five_points");
    let put = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    put("errors.csv", &fs::read_to_string(machine.join("errors.csv")).unwrap());
    let job = fs::read_to_string(machine.join("weihong.toml")).unwrap();
    put("job.toml", &job.replace("\"weihong\"", "\"own.toml\""));
    let own = "schema = 1\nid = \"own\"\nname = \"own\"\nbased_on = \"weihong\"\n\n[[steps]]\npart = \"Before anything is loaded\"\ntext = \"Call the owner.\"\nevidence = \"manual\"\nsource = \"the owner\"\n";
    put("own.toml", own);
    nonius(&folder, "generate job.toml -o kit");
    let list = kit_file(&folder, "kit/checklist.md");
    let at = |words: &str| list.find(words).unwrap_or_else(|| panic!("{words}: {list}"));
    let order = [
        "whoever keeps the profile",
        "`Screw error compensation`",
        "Call the owner.",
        "## Sign proof",
    ];
    assert!(order.map(at).is_sorted(), "{list}");
    put("own.toml", &own.replace("Before anything", "Before all"));
    let (status, said) = nonius(&folder, "generate job.toml -o other");
    assert_eq!(status, Some(2), "{said}");
    let words = "the checklist has no part `Before all is loaded`";
    assert!(
        said.contains(words) && said.contains("its parts: `Before anything is loaded`, "),
        "{said}"
    );
}

/// The real file holds all parameters of an axis; what a person may have done to it is refused.
#[test]
fn a_parameter_file_in_utf_16_is_read_with_the_table_in_it() {
    let folder = tempfile::tempdir().unwrap();
    let machine = root().join("fixtures/machines/five_points");
    for name in ["errors.csv", "fagor-8065.toml"] {
        fs::copy(machine.join(name), folder.path().join(name)).unwrap();
    }
    nonius(&folder, "generate fagor-8065.toml -o kit");
    let utf16 = |text: &str| text.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>();
    let lines = |axis: &str| {
        let bytes = fs::read(folder.path().join(format!("kit/draft-{axis}.mp"))).unwrap();
        assert_eq!((bytes.len() % 2, bytes[1]), (0, 0));
        bytes.iter().step_by(2).map(|byte| char::from(*byte)).collect::<String>()
    };
    let whole = |axis: &str| {
        let head = format!(
            "\u{feff}{axis} AXIS                        ;3100\r\nMM                            ;0\r\n2;/LSCRWDATA/REFNEED          ;0\r\n2;/BACKLASH ;0.0000\r\n2;/LOOPCH ;NO\r\n2;/LSCRWCOMP ;ON\r\n2;/LSCRWDATA/BIDIR ;YES\r\n2;/LSCRWDATA/NPOINTS ;5\r\n"
        );
        let tail = "2;/FILTER/FILTER 1/ORDER                            ;0\r\n";
        head + &lines(axis).replace('\n', "\r\n") + tail
    };
    fs::create_dir(folder.path().join("out")).unwrap();
    let put = |axis: &str, bytes: Vec<u8>| {
        fs::write(folder.path().join(format!("out/{axis}.mp")), bytes).unwrap()
    };
    for axis in ["X", "Y", "Z"] {
        put(axis, utf16(&whole(axis)));
    }
    let verify = "verify fagor-8065.toml --tables out";
    let (status, said) = nonius(&folder, verify);
    assert!(status == Some(0) && said.contains("job and tables agree"), "{said}");
    let x = whole("X");
    for (bytes, says) in [
        (x.clone().into_bytes(), "`X.mp` is not text in UTF-16"),
        (utf16(&x.replace("MM  ", "INCH")), "the file is in `INCH`"),
        (
            utf16(&x.replace("DATA/POSERROR 2", "DATA/POSEROR 2")),
            "no pattern of the profile takes this line",
        ),
        (utf16(&x.replace("POSERROR 2", "POSERROR 3")), "a second `forward` here"),
        (
            utf16(&x.replace("LSCRWCOMP ;ON", "LSCRWCOMP ;OFF")),
            "no pattern of the profile takes this line",
        ),
        (utf16(&x.replace("BIDIR ;YES", "BIDIR ;NO")), "no pattern of the profile takes this line"),
        (
            utf16(&x.replace("LSCRWDATA/BIDIR", "LSCRWDATA/TYPE")),
            "no pattern of the profile takes this line",
        ),
        (
            utf16(&x.replace("BACKLASH ;0.0000", "BACKLASH ;0.0500")),
            "no pattern of the profile takes this line",
        ),
        (
            utf16(&x.replace("NPOINTS ;5", "NPOINTS ;2")),
            "the file says 2 here, its points make it 5",
        ),
    ] {
        put("X", bytes);
        let (status, said) = nonius(&folder, verify);
        assert!(status == Some(2) && said.contains(says), "{says}: {said}");
    }
}
