//! Doubts as a user meets them: on the screen, in the table, in the kits made from readings and table.

use super::*;

fn fixture(case: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/diagonals").join(case)
}

fn copy(
    case: &str,
    job: impl Fn(String) -> String,
    readings: impl Fn(String) -> String,
) -> tempfile::TempDir {
    let directory = tempfile::tempdir().unwrap();
    let read = |name: &str| fs::read_to_string(fixture(case).join(name)).unwrap();
    let put = |name: &str, text: String| fs::write(directory.path().join(name), text).unwrap();
    put("readings.csv", readings(read("readings.csv")));
    put("job.toml", job(read("job.toml")));
    directory
}

fn said(output: &Output, status: i32) -> String {
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    let talk = String::from_utf8(output.stderr.clone()).unwrap();
    assert_eq!(output.status.code(), Some(status), "{text}{talk}");
    text + &talk
}

fn json(output: &Output, status: i32) -> Value {
    said(output, status);
    serde_json::from_slice(&output.stdout).unwrap()
}

fn manifest(directory: &Path, kit: &str) -> Value {
    serde_json::from_slice(&fs::read(directory.join(kit).join("manifest.json")).unwrap()).unwrap()
}

/// The job of the table that `separate -o errors.csv` wrote.
fn two_step(directory: &Path) {
    let job = fs::read_to_string(directory.join("job.toml")).unwrap();
    let (before, after) = job.split_once("[measurement.step_diagonal]").unwrap();
    let (_, after) = after.split_once("[compensation]").unwrap();
    let before = before.replace("readings = \"readings.csv\"", "errors = \"errors.csv\"");
    let job = format!("{before}[compensation]{after}");
    fs::write(directory.join("nine.toml"), job).unwrap();
}

/// Case B with 0.3 µm noise and one reading 20 µm off.
fn disturbed_case_b() -> tempfile::TempDir {
    let spoil = |text: String| {
        let mut random = ChaCha8Rng::seed_from_u64(20);
        let mut out = String::new();
        for line in text.lines().filter(|line| !line.starts_with('#')) {
            let (before, um) = line.rsplit_once(',').unwrap();
            let Ok(um) = um.parse::<f64>() else {
                out += &format!("{line}\n");
                continue;
            };
            let off = if before == "PPP,1,forward,58,x" { 20.0 } else { 0.0 };
            let noise = SIGMA_UM * simulated::normal(&mut random);
            let um = if before.contains(",0,") { um } else { um + noise + off };
            out += &format!("{before},{um:.6}\n");
        }
        out
    };
    copy("case_b_setup", |job| job, spoil)
}

#[test]
fn a_disturbed_reading_reaches_every_output() {
    let directory = disturbed_case_b();
    let words = "PPP forward node 58";
    let text = said(&nonius(directory.path(), "separate job.toml -o errors.csv"), 1);
    assert!(text.contains("DOUBTFUL") && text.contains(words), "{text}");
    let page = json(&nonius(directory.path(), "separate job.toml --format json"), 1);
    assert!(page["doubts"].to_string().contains(words), "{page}");
    let csv = fs::read_to_string(directory.path().join("errors.csv")).unwrap();
    assert!(csv.lines().any(|l| l.starts_with("# doubt:") && l.contains(words)), "{csv}");
    two_step(directory.path());
    for (job, kit) in [("job.toml", "one"), ("nine.toml", "two")] {
        let text = said(&nonius(directory.path(), &format!("generate {job} -o {kit}")), 1);
        let (_, verdict) = text.split_once("verdict: undecided").unwrap();
        assert!(verdict.contains(words), "{text}");
        let page = manifest(directory.path(), kit);
        assert!(page["doubts"].to_string().contains(words), "{page}");
        let verify = format!("verify {job} --tables {kit} --format json");
        let page = json(&nonius(directory.path(), &verify), 1);
        assert_eq!(page["verdict"], "undecided");
        assert!(page["causes"].to_string().contains(words), "{page}");
    }
}

#[test]
fn a_kit_without_scales_is_undecided_and_says_what_is_missing() {
    let without = |job: String| {
        let (before, after) = job.split_once("[[measurement.step_diagonal.linear]]").unwrap();
        let (_, after) = after.split_once("[compensation]").unwrap();
        format!("{before}[compensation]{after}")
    };
    let directory = copy("case_b_setup", without, |readings| readings);
    let text = said(&nonius(directory.path(), "separate job.toml -o errors.csv"), 1);
    assert!(text.contains("Determined: 6 of 9 errors"), "{text}");
    two_step(directory.path());
    for (job, kit) in [("job.toml", "one"), ("nine.toml", "two")] {
        let text = said(&nonius(directory.path(), &format!("generate {job} -o {kit}")), 1);
        assert!(text.contains("verdict: undecided"), "{text}");
        assert!(text.contains("EXX   not determined"), "{text}");
        assert!(text.contains("no table for EXX, EYY, EZZ: not determined by the measurement: scale of X, Y and Z can be traded"), "{text}");
        let omitted = manifest(directory.path(), kit)["omitted"].clone();
        let terms = omitted.as_array().unwrap().iter().map(|o| o["term"].as_str().unwrap());
        assert_eq!(terms.collect::<Vec<_>>(), ["EXX", "EYY", "EZZ"]);
    }
    // Whoever asks for the six alone misses nothing.
    let asked = |job: String| {
        without(job).replace(
            "[compensation]\n",
            "[compensation]\nterms = [\"EYX\", \"EZX\", \"EXY\", \"EZY\", \"EXZ\", \"EYZ\"]\n",
        )
    };
    let directory = copy("case_b_setup", asked, |readings| readings);
    let text = said(&nonius(directory.path(), "generate job.toml -o kit"), 0);
    assert!(!text.contains("DOUBTFUL"), "{text}");
}

fn with_policy(policy: &str) -> impl Fn(String) -> String + '_ {
    move |job| {
        job.replace("[compensation]\n", &format!("[compensation]\nbacklash = \"{policy}\"\n"))
    }
}

#[test]
fn readings_in_both_directions_need_a_word_on_the_reversal() {
    let directory = copy("case_d_bidirectional", |job| job, |readings| readings);
    let text = said(&nonius(directory.path(), "generate job.toml -o kit"), 2);
    assert!(text.contains("`backlash` is not stated"), "{text}");
    let end = |policy: &str| {
        let directory = copy("case_d_bidirectional", with_policy(policy), |readings| readings);
        said(&nonius(directory.path(), "separate job.toml -o errors.csv"), 0);
        let csv = fs::read_to_string(directory.path().join("errors.csv")).unwrap();
        let last = csv.lines().rfind(|line| line.starts_with("x,")).unwrap();
        let cell = last.split(',').nth(last.matches(",+,").count() + 2).unwrap();
        cell.parse::<f64>().unwrap()
    };
    let page =
        json(&nonius(&fixture("case_d_bidirectional"), "separate job.toml --format json"), 0);
    let wanted = |name: &str| page["errors"][name]["deviation_um"][10].as_f64().unwrap();
    assert!((end("mean") - wanted("EXX")).abs() < 1e-5);
    assert!((end("forward-only") - wanted("EXX+")).abs() < 1e-5);
    assert!((end("forward-only") - end("mean")).abs() > 0.5);
}

#[test]
fn a_reversal_that_no_curve_holds_is_said_beside_the_figures() {
    for policy in ["mean", "forward-only"] {
        let directory = copy("case_d_bidirectional", with_policy(policy), |readings| readings);
        said(&nonius(directory.path(), "separate job.toml -o errors.csv"), 0);
        two_step(directory.path());
        for (job, kit) in [("job.toml", "one"), ("nine.toml", "two")] {
            let text = said(&nonius(directory.path(), &format!("generate {job} -o {kit}")), 1);
            assert!(text.contains("verdict: undecided"), "{text}");
            assert!(!text.contains("reversal not measured"), "{text}");
            let marked =
                text.lines().find(|line| line.starts_with("EXX  ") && line.contains("without"));
            // B_d of the reference is 9.146 µm.
            assert!(marked.unwrap().contains("without reversal (about 9.146 µm"), "{text}");
            let page = manifest(directory.path(), kit);
            assert_eq!(page["forecast"]["without_reversal_um"], 9.146);
        }
    }
}

#[test]
fn an_assumed_set_up_is_said_of_the_kit_made_from_the_table() {
    let directory = copy("case_a_ideal", |job| job, |readings| readings);
    said(&nonius(directory.path(), "separate job.toml -o errors.csv"), 0);
    two_step(directory.path());
    let text = said(&nonius(directory.path(), "generate nine.toml -o kit --explain"), 0);
    for words in [
        "set-up assumed perfect",
        "reversal is mixed into the curves",
        "angular errors without a measurement, counted as zero",
    ] {
        assert!(text.contains(&format!("note: {words}")) || text.contains(words), "{text}");
        let notes = manifest(directory.path(), "kit")["notes"].to_string();
        assert!(notes.contains(words), "{notes}");
    }
}

#[test]
fn where_nothing_is_asked_nothing_is_judged_and_worse_is_said() {
    let no_limit = |job: String| {
        let (before, _) = job.split_once("[acceptance]").unwrap();
        // A count of 20 µm: the tables cannot follow the curves.
        before
            .replace("siemens-840d-sl", "generic")
            .replace("[compensation.axes.x]\n", "[compensation.axes.x]\ndetection_unit_um = 20.0\n")
    };
    let directory = copy("case_b_setup", no_limit, |readings| readings);
    let text = said(&nonius(directory.path(), "generate job.toml -o kit"), 0);
    assert!(
        text.contains("no acceptance is stated in the job, so there is nothing to judge"),
        "{text}"
    );
    assert!(!text.contains("verdict: pass"), "{text}");
    assert!(
        text.contains("WARNING: diagonal PPP becomes larger with the tables: 18.543 →"),
        "{text}"
    );
    let notes = manifest(directory.path(), "kit")["notes"].to_string();
    assert!(notes.contains("diagonal PPP becomes larger"), "{notes}");
}

/// A thousandth of the golden errors: values in mm under a column in µm.
#[test]
fn values_in_mm_under_a_column_in_um_are_doubted() {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/nine_errors_900");
    let table = fs::read_to_string(golden.join("errors.csv")).unwrap();
    let thousandth = |cell: &str| cell.parse::<f64>().map(|um| (um / 1000.0).to_string());
    let slipped = |line: &str| -> String {
        let cells = line.split(',').enumerate().map(|(column, cell)| {
            let is_value = column > 1;
            thousandth(cell).ok().filter(|_| is_value).unwrap_or_else(|| cell.to_string())
        });
        cells.collect::<Vec<_>>().join(",") + "\n"
    };
    let directory = tempfile::tempdir().unwrap();
    let put = |name: &str, text: String| fs::write(directory.path().join(name), text).unwrap();
    put("errors.csv", table.lines().map(slipped).collect());
    let job = fs::read_to_string(golden.join("generic.toml")).unwrap();
    put("job.toml", job.clone());
    let words = "no error exceeds 0.018 µm, and a machine tool below 0.1 µm throughout is unlikely";
    for command in ["generate job.toml -o kit", "verify job.toml --tables kit"] {
        let text = said(&nonius(directory.path(), command), 1);
        assert!(text.contains("verdict: undecided"), "{text}");
        assert!(text.contains(&format!("DOUBTFUL: {words}")), "{text}");
    }
    let text = said(&nonius(directory.path(), "assess job.toml"), 0);
    assert!(text.contains(&format!("doubt: {words}")), "{text}");
    // Whoever states a noise below the errors means them.
    let noise = "date = \"2026-11-20\"\nuncertainty = { noise_um = 0.002 }\n";
    put("fine.toml", job.replace("date = \"2026-11-20\"\n", noise));
    let text = said(&nonius(directory.path(), "generate fine.toml -o fine"), 0);
    assert!(!text.contains("DOUBTFUL"), "{text}");
    // A noise above them says nothing of their unit.
    let coarse = job.replace("date = \"2026-11-20\"\n", &noise.replace("0.002", "0.5"));
    put("coarse.toml", coarse);
    let text = said(&nonius(directory.path(), "generate coarse.toml -o coarse"), 1);
    assert!(text.contains("or state a `noise_um` below it"), "{text}");
    let tiny = "axis,position_mm,ex_um\nx,0,0\nx,900,0.00042\n";
    put("errors.csv", tiny.to_string());
    let text = said(&nonius(directory.path(), "generate job.toml -o tiny"), 1);
    assert!(text.contains("no error exceeds 0.00042 µm"), "{text}");
}
