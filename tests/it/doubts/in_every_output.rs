//! Doubts as a user meets them: on the screen, in the table, in the kits made from readings and table.

use super::*;

fn of_case(case: &str) -> Visit {
    Visit::of(&format!("diagonals/{case}"))
}

/// A case with a policy for its reversals.
fn with_policy(case: &str, policy: &str) -> Visit {
    let visit = of_case(case);
    let with = format!("[compensation]\nbacklash = \"{policy}\"");
    visit.edit("job.toml", "[compensation]", &with);
    visit
}

/// A job without what stands from a table up to `[compensation]`.
fn without(job: &str, table: &str) -> String {
    let (before, rest) = job.split_once(table).unwrap();
    let (_, after) = rest.split_once("[compensation]").unwrap();
    format!("{before}[compensation]{after}")
}

/// Writes the table and the job of what it holds.
#[track_caller]
fn two_step(visit: &Visit, status: i32) -> Ran {
    let ran = visit.run("separate job.toml -o errors.csv").ends(status);
    let job = without(&visit.read("job.toml"), "[measurement.step_diagonal]");
    visit.put("nine.toml", job.replace("readings = \"readings.csv\"", "errors = \"errors.csv\""));
    ran
}

/// A kit from the readings, and one from the table: what is said, and its manifest.
#[track_caller]
fn kits(visit: &Visit) -> [(Ran, Value); 2] {
    ["job", "nine"].map(|job| {
        let ran = visit.run(&format!("generate {job}.toml -o kit-{job}")).ends(1);
        (ran.says("verdict: undecided"), visit.document(&format!("kit-{job}/manifest.json")))
    })
}

/// Case B with 0.3 µm noise and one reading 20 µm off.
fn disturbed_case_b() -> Visit {
    let mut random = ChaCha8Rng::seed_from_u64(20);
    let spoilt = |line: &str| {
        let (before, um) = line.rsplit_once(',').unwrap();
        let Ok(um) = um.parse::<f64>() else { return format!("{line}\n") };
        let off = if before == "PPP,1,forward,58,x" { 20.0 } else { 0.0 };
        let noise = SIGMA_UM * normal(&mut random);
        let um = if before.contains(",0,") { um } else { um + noise + off };
        format!("{before},{um:.6}\n")
    };
    let visit = of_case("case_b_setup");
    let readings = visit.read("readings.csv");
    let rows = readings.lines().filter(|line| !line.starts_with('#'));
    visit.put("readings.csv", rows.map(spoilt).collect::<String>());
    visit
}

#[test]
fn a_disturbed_reading_reaches_every_output() {
    let visit = disturbed_case_b();
    let words = "PPP forward node 58";
    two_step(&visit, 1).says("DOUBTFUL").says(words);
    let page = visit.run("separate job.toml --format json").ends(1).json();
    says(&page["doubts"].to_string(), &[words]);
    let csv = visit.read("errors.csv");
    assert!(csv.lines().any(|l| l.starts_with("# doubt:") && l.contains(words)), "{csv}");
    for (ran, page) in kits(&visit) {
        let text = ran.all();
        says(text.split_once("verdict: undecided").unwrap().1, &[words]);
        says(&page["doubts"].to_string(), &[words]);
    }
    for job in ["job", "nine"] {
        let verify = format!("verify {job}.toml --tables kit-{job} --format json");
        let page = visit.run(&verify).ends(1).json();
        assert_eq!(page["verdict"], "undecided");
        says(&page["causes"].to_string(), &[words]);
    }
}

#[test]
fn a_kit_without_scales_is_undecided_and_says_what_is_missing() {
    let visit = of_case("case_b_setup");
    let table = "[[measurement.step_diagonal.linear]]";
    visit.put("job.toml", without(&visit.read("job.toml"), table));
    two_step(&visit, 1).says("Determined: 6 of 9 errors");
    for (ran, page) in kits(&visit) {
        ran.says("EXX   not determined").says("no table for EXX, EYY, EZZ: not determined by the measurement: scale of X, Y and Z can be traded");
        let omitted = page["omitted"].as_array().unwrap();
        let terms: Vec<_> = omitted.iter().map(|o| &o["term"]).collect();
        assert_eq!(terms, ["EXX", "EYY", "EZZ"]);
    }
    // Whoever asks for the six alone misses nothing.
    let asked = "[compensation]\nterms = ['EYX', 'EZX', 'EXY', 'EZY', 'EXZ', 'EYZ']";
    visit.edit("job.toml", "[compensation]", asked);
    visit.run("generate job.toml -o six").ends(0).omits("DOUBTFUL");
}

#[test]
fn readings_in_both_directions_need_a_word_on_the_reversal() {
    let case = "case_d_bidirectional";
    of_case(case).run("generate job.toml -o kit").ends(2).says("`backlash` is not stated");
    let page = of_case(case).run("separate job.toml --format json").ends(0).json();
    let [mean, forward] = [("mean", "EXX"), ("forward-only", "EXX+")].map(|(policy, name)| {
        let visit = with_policy(case, policy);
        visit.yes("separate job.toml -o errors.csv");
        let csv = visit.read("errors.csv");
        let last = csv.lines().rfind(|line| line.starts_with("x,")).unwrap();
        let cell = last.split(',').nth(last.matches(",+,").count() + 2).unwrap();
        let um: f64 = cell.parse().unwrap();
        let wanted = number(&page["errors"][name]["deviation_um"][10]);
        assert!((um - wanted).abs() < 1e-5, "{policy}: {um}, {wanted}");
        um
    });
    assert!((forward - mean).abs() > 0.5);
}

#[test]
fn a_reversal_that_no_curve_holds_is_said_beside_the_figures() {
    for policy in ["mean", "forward-only"] {
        let visit = with_policy("case_d_bidirectional", policy);
        two_step(&visit, 0);
        for (ran, page) in kits(&visit) {
            let text = ran.omits("reversal not measured").all();
            // B_d of the reference is 9.146 µm.
            let mark = "without reversal (about 9.146 µm";
            let is_marked = |line: &str| line.starts_with("EXX  ") && line.contains(mark);
            assert!(text.lines().any(is_marked), "{text}");
            assert_eq!(page["forecast"]["without_reversal_um"], 9.146);
        }
    }
}

#[test]
fn an_assumed_set_up_is_said_of_the_kit_made_from_the_table() {
    let visit = of_case("case_a_ideal");
    two_step(&visit, 0);
    let angles = "angular errors without a measurement, counted as zero";
    let words = ["set-up assumed perfect", "reversal is mixed into the curves", angles];
    says(&visit.run("generate nine.toml -o kit --explain").ends(0).all(), &words);
    says(&visit.document("kit/manifest.json")["notes"].to_string(), &words);
}

#[test]
fn where_nothing_is_asked_nothing_is_judged_and_worse_is_said() {
    let visit = of_case("case_b_setup");
    let job = visit.read("job.toml");
    visit.put("job.toml", job.split("[acceptance]").next().unwrap());
    visit.edit("job.toml", "siemens-840d-sl", "generic");
    // A count of 20 µm: the tables cannot follow the curves.
    let x = "[compensation.axes.x]\n";
    visit.edit("job.toml", x, &format!("{x}detection_unit_um = 20.0\n"));
    visit
        .run("generate job.toml -o kit")
        .ends(0)
        .says("no acceptance is stated in the job, so there is nothing to judge")
        .omits("verdict: pass")
        .says("WARNING: diagonal PPP becomes larger with the tables: 18.543 →");
    let notes = visit.document("kit/manifest.json")["notes"].to_string();
    says(&notes, &["diagonal PPP becomes larger"]);
}

/// A thousandth of the errors: values in mm under a column in µm.
#[test]
fn values_in_mm_under_a_column_in_um_are_doubted() {
    let visit = Visit::of("start/errors");
    let slipped = |(column, cell): (usize, &str)| {
        let um = cell.parse::<f64>().ok().filter(|_| column > 1);
        um.map_or(cell.to_string(), |um| (um / 1000.0).to_string())
    };
    let row = |line: &str| line.split(',').enumerate().map(slipped).collect::<Vec<_>>().join(",");
    let rows: Vec<String> = visit.read("errors.csv").lines().map(row).collect();
    visit.put("errors.csv", rows.join("\n"));
    let words = "no error exceeds 0.008 µm, and a machine tool below 0.1 µm throughout is unlikely";
    for command in ["generate job.toml -o kit", "verify job.toml --tables kit"] {
        let ran = visit.run(command).ends(1).says("verdict: undecided");
        ran.says(&format!("DOUBTFUL: {words}"));
    }
    visit.run("assess job.toml").ends(0).says(&format!("doubt: {words}"));
    let stated = |noise_um: &str| {
        let noise = format!("[measurement]\nuncertainty = {{ noise_um = {noise_um} }}\n");
        visit.put("stated.toml", visit.read("job.toml"));
        visit.edit("stated.toml", "[measurement]\n", &noise);
        visit.run(&format!("generate stated.toml -o kit-{noise_um}"))
    };
    // Whoever states a noise below the errors means them.
    stated("0.002").ends(0).omits("DOUBTFUL");
    // A noise above them says nothing of their unit.
    stated("0.5").ends(1).says("or state a `noise_um` below it");
    visit.put("errors.csv", "axis,position_mm,ex_um\nx,0,0\nx,400,0.00042\n");
    visit.run("generate job.toml -o tiny").ends(1).says("no error exceeds 0.00042 µm");
}
