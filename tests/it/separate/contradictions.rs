//! Slopes, signs and sizes that contradict the diagonals.

use super::*;

/// Case B with its three linear axes changed.
fn changed_case_b(change: impl Fn(String) -> String) -> tempfile::TempDir {
    copy("case_b_setup", change)
}

fn disagrees(directory: &Path) {
    let output = nonius(directory, "separate job.toml --trials 0 -v");
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("they DISAGREE"), "{text}");
    let output = nonius(directory, "separate job.toml --trials 0 --format json");
    assert_eq!(output.status.code(), Some(1));
    let page: Value = serde_json::from_slice(&output.stdout).unwrap();
    let probability = page["redundancy"]["probability"].as_f64().unwrap();
    assert!(probability < 0.01, "{probability}");
    let words = page["redundancy"]["contradiction"].as_str().unwrap();
    assert!(words.contains("laser_sign") && words.contains("size of the box"));
    assert_eq!(page["doubts"][0], words);
    assert!(page["errors"]["EXX"].get("u_um").is_none());
    assert!(page.get("setup_arcsec").is_none());
    let output = nonius(directory, "generate job.toml -o kit");
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(!text.contains("verdict: pass"), "{text}");
    assert!(text.contains("DOUBTFUL: linear axes and diagonals DISAGREE"), "{text}");
    let output = nonius(directory, "verify job.toml --tables kit --format json");
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let page: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_ne!(page["verdict"], "pass");
    assert!(page["causes"].to_string().contains("DISAGREE"));
}

#[test]
fn slopes_that_contradict_the_diagonals_are_told_and_nothing_passes() {
    let z = "slope_um_per_m = 13.888888889";
    for wrong in [
        "slope_um_per_m = 113.9",
        "slope_um_per_m = -13.9\nu_um_per_m = 0.5",
        "slope_um_per_m = 113.9\nu_um_per_m = 0.5",
    ] {
        let directory = changed_case_b(|job| job.replace(z, wrong));
        disagrees(directory.path());
    }
    let all_known = changed_case_b(|job| {
        let job = job.replace(z, "slope_um_per_m = -13.9");
        let with_u =
            |job: String, line: &str| job.replace(line, &format!("{line}\nu_um_per_m = 0.5"));
        ["20.000000000", "-16.666666667", "-13.9"]
            .iter()
            .fold(job, |job, slope| with_u(job, &format!("slope_um_per_m = {slope}")))
    });
    disagrees(all_known.path());
}

#[test]
fn a_wrong_sign_of_the_laser_or_size_of_the_box_is_told() {
    let sign = changed_case_b(|job| job.replace("steps = 30", "steps = 30\nlaser_sign = \"-\""));
    disagrees(sign.path());
    let size = changed_case_b(|job| {
        job.replace("y = 720.0000, z = 720.0000 }", "y = 720.0000, z = 620.0000 }")
    });
    disagrees(size.path());
}

#[test]
fn the_golden_case_agrees() {
    let page = json(&fixture("case_b_setup"), "separate job.toml --trials 0 --format json");
    assert!(page["redundancy"]["probability"].as_f64().unwrap() > 0.05, "{page}");
    assert!(page["redundancy"]["contradiction"].is_null());
    assert_eq!(page["redundancy"]["degrees_of_freedom"], 1);
    let text = stdout(&nonius(&fixture("case_b_setup"), "separate job.toml -v"));
    assert!(text.contains("they agree"), "{text}");
}
