//! Slopes, signs and sizes that contradict the diagonals.

use super::*;

/// Case B with parts of its job replaced.
#[track_caller]
fn disagrees(replacements: &[(&str, &str)]) {
    let visit = case("case_b_setup");
    for (old, new) in replacements {
        visit.edit("job.toml", old, new);
    }
    visit.run("separate job.toml --trials 0 -v").ends(1).says("they DISAGREE");
    let page = separated(&visit, 1);
    let redundancy = &page["redundancy"];
    assert!(number(&redundancy["probability"]) < 0.01, "{redundancy}");
    let words = redundancy["contradiction"].as_str().unwrap();
    assert!(words.contains("laser_sign") && words.contains("size of the box"));
    assert_eq!(page["doubts"][0], words);
    assert!(page["errors"]["EXX"].get("u_um").is_none());
    assert!(page.get("setup_arcsec").is_none());
    visit
        .run("generate job.toml -o kit")
        .ends(1)
        .omits("verdict: pass")
        .says("DOUBTFUL: linear axes and diagonals DISAGREE");
    let page = visit.run("verify job.toml --tables kit --format json").ends(1).json();
    assert_ne!(page["verdict"], "pass");
    assert!(page["causes"].to_string().contains("DISAGREE"));
}

const SLOPE_OF_Z: &str = "slope_um_per_m = 13.888888889";

#[test]
fn slopes_that_contradict_the_diagonals_are_told_and_nothing_passes() {
    disagrees(&[(SLOPE_OF_Z, "slope_um_per_m = 113.9")]);
    disagrees(&[(SLOPE_OF_Z, "slope_um_per_m = -13.9\nu_um_per_m = 0.5")]);
    disagrees(&[(SLOPE_OF_Z, "slope_um_per_m = 113.9\nu_um_per_m = 0.5")]);
    disagrees(&[
        ("= 20.000000000", "= 20.000000000\nu_um_per_m = 0.5"),
        ("= -16.666666667", "= -16.666666667\nu_um_per_m = 0.5"),
        (SLOPE_OF_Z, "slope_um_per_m = -13.9\nu_um_per_m = 0.5"),
    ]);
}

#[test]
fn a_wrong_sign_of_the_laser_or_size_of_the_box_is_told() {
    disagrees(&[("steps = 30", "steps = 30\nlaser_sign = \"-\"")]);
    disagrees(&[("y = 720.0000, z = 720.0000 }", "y = 720.0000, z = 620.0000 }")]);
}

#[test]
fn the_golden_case_agrees() {
    let visit = case("case_b_setup");
    let redundancy = &separated(&visit, 0)["redundancy"];
    assert!(number(&redundancy["probability"]) > 0.05, "{redundancy}");
    assert!(redundancy["contradiction"].is_null());
    assert_eq!(redundancy["degrees_of_freedom"], 1);
    visit.run("separate job.toml --trials 0 -v").ends(0).says("they agree");
}
