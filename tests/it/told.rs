//! What `generate` says beside its figures: assumptions that matter, preconditions as sentences, the verdict.

use crate::support::{Ran, Visit, holds, own_profile};

/// The job to start from with a control of one's choice, and what `generate` says of it.
fn told(controller: &str, profile: Option<&str>) -> (Visit, Ran) {
    let visit = Visit::of("start/errors");
    visit.edit("job.toml", "siemens-840d-sl", controller);
    visit.edit("job.toml", "# detection_unit_um", "detection_unit_um");
    if let Some(page) = profile {
        visit.put(controller, page);
    }
    let ran = visit.run("generate job.toml -o kit --explain").ends(0);
    (visit, ran)
}

#[test]
fn the_verdict_stands_in_the_first_line_and_names_in_other_letters_are_taken() {
    let (visit, Ran { out, .. }) = told("siemens-840d-sl", None);
    assert!(out.starts_with("verdict: pass (asked: "), "{out}");
    visit.edit("job.toml", "VMC 400", "Fräse Süd, groß");
    let ran = visit.run("generate job.toml -o \"my kit\"");
    ran.says("`Fräse Süd, groß` stands as `Fraese Sued, gross`")
        .says("nonius verify job.toml --tables \"my kit\"");
}

#[test]
fn preconditions_are_sentences_and_assumptions_without_effect_stand_apart() {
    let (_, ran) = told("fanuc-30i", None);
    let apart = "assumed too, without effect on this kit:";
    let (used, idle) = ran.out.split_once(apart).expect("both groups are there");
    let magnification = "straightness_magnification_parameter"; // a 30i kit uses it
    holds(used, &["pitch_sign = as_correction\n      if wrong: ", magnification]);
    let line = "  straightness_amount_max = 32767: this kit holds no four-point straightness\n";
    holds(idle, &[line, "interval_decimals_inch = 4: this kit is in mm"]);
    ran.says("\n  1240 of axis 1, 2, 3 must be 0 mm:\n")
        .says("the power of the control must be switched off and on after loading 3620 to 3627:")
        .says("checklist.html, why: docs/fanuc.md §1.2");
    let (_, ran) = told("fanuc-0i-f", None);
    let (used, idle) = ran.out.split_once(apart).expect("both groups are there");
    holds(used, &["straightness_amount_max"]); // a 0i-F kit uses it
    holds(idle, &[magnification]);
}

#[test]
fn what_is_to_be_decided_is_on_the_screen_and_has_its_box_in_the_steps() {
    let of_siemens = ["first_table = 0; if wrong: CEC tables already in use"];
    let of_fanuc = [
        "first_set = 1; if wrong: straightness sets already in use",
        "reserved_points = none; if wrong: points already used",
    ];
    for (id, open) in [("siemens-840d-sl", &of_siemens[..]), ("fanuc-30i", &of_fanuc)] {
        let (visit, mut ran) = told(id, None);
        let (work, page) = (visit.read("kit/checklist.md"), visit.read("kit/checklist.html"));
        let (work, annex) = work.split_once("## Annex").expect("an annex");
        let (page, _) = page.split_once("class=\"annex\"").expect("an annex");
        let boxed = "<li><span class=\"box\">&#160;</span> <strong>DECIDE,</strong>";
        for line in open {
            ran = ran.says(&format!("DECIDE BEFORE LOADING, assumed: {line}"));
            let item = format!("\n   - [ ] **DECIDE,** assumed: {line}");
            assert!(work.contains(&item), "{id}: {item}\n{work}");
            let item = format!("{boxed} assumed: {}", line.split_once(';').expect("two parts").0);
            assert!(page.contains(&item), "{id}: {item}\n{page}");
            assert!(!annex.contains(line), "{id}: {line}\n{annex}");
        }
    }
    let visit = Visit::with_job("nine_errors_900/fanuc-30i.toml");
    visit.under("[compensation]", "control_unit = \"inch\"");
    let ran = visit.run("generate job.toml -o kit");
    ran.says("DECIDE BEFORE LOADING, assumed: detection_unit_um of axis 1 = 1; if wrong: every");
}

#[test]
fn what_no_file_of_an_own_profile_sets_is_noted() {
    let file = |path: &str, template: &str| {
        format!("[[files]]\nrole = \"table\"\npath = \"{path}\"\ntemplate = \"{template}\"\n")
    };
    let files = file("EEC.MPF", "siemens-eec.mpf.tera") + &file("CEC.MPF", "siemens-cec.mpf.tera");
    let (visit, ran) = told("own.toml", Some(&own_profile("siemens-840d-sl", &files)));
    let switches = "note: no file switches the tables on";
    ran.says(&format!("{switches}; see to MD32700"))
        .says("note: no file reserves their memory; see to MD38000");
    visit.run("verify job.toml --tables kit").says(switches);
}

/// X was measured in both directions, Y and Z were not: that is neither "not measured" nor nothing.
#[test]
fn the_errors_without_a_reversal_are_named_and_one_within_its_uncertainty_is_noise() {
    let visit = Visit::with_job("machines/five_points/siemens-840d-sl.toml");
    let names = "EXY, EYY, EZY, EXZ, EYZ, EZZ";
    visit.run("generate job.toml -o kit").says(&format!("reversal of {names} not measured"));
    let page = visit.run("report job.toml --language de -o -");
    page.says(&format!("Umkehrspanne von {names} nicht gemessen"));
    let (visit, _) = told("siemens-840d-sl", None);
    visit.under("[compensation]", "backlash = \"two-tables\"");
    // EXX: 3 µm between the directions; EYX: 1 µm, with u = 0.5 µm (U of a difference 1.4 µm).
    let rows = "x,+,0,0,0,0.5,0.5\nx,+,400,3,1,0.5,0.5\nx,-,0,-3,0,0.5,0.5\nx,-,400,0,2,0.5,0.5\n";
    let head = "axis,direction,position_mm,ex_um,ey_um,u_ex_um,u_ey_um\n";
    visit.put("errors.csv", head.to_string() + rows);
    let ran = visit.run("generate job.toml -o noisy --force").omits("EXX: its reversal");
    ran.says("EYX: its reversal, 1.0 µm at most, lies within the U = 1.4 µm");
}
