//! No verdict is surer than what it rests on: one U everywhere, limits on the largest of many, parts of the travel.
use crate::support::{DIAGONALS, UNCORRECTED, Visit, error_rows, holds, job_of, number, replaced};
use serde_json::Value;
use std::fs;

const GENERATE: &str = "generate job.toml -o kit";
const VERIFY: &str = "verify job.toml --tables kit";
const AFTER: &str = "verify job.toml --tables kit --after after.csv";

/// The first part of what a command prints, its verdict: it begins with a word and holds others.
#[track_caller]
fn verdict(visit: &Visit, command: &str, begins: &str, words: &[&str]) -> String {
    let ran = visit.run(command).answers();
    let (_, page) = ran.out.split_once("verdict: ").unwrap();
    let said = page.split("\n\n").next().unwrap().replace("\n    ", " ");
    assert!(said.starts_with(begins), "{command}: expected `{begins}`\n{said}");
    holds(&said, words);
    said
}

/// Axes of one travel, reference and spacing; `lines` go under [acceptance].
fn job(axes: &[&str], [high, reference, spacing]: [u32; 3], u: &str, lines: &str) -> String {
    let axis =
        |axis| (axis, [0.0, high.into()], reference.into(), format!("spacing_mm = {spacing}"));
    job_of(&format!("{UNCORRECTED}\n{u}"), "controller = \"generic\"", axes.iter().map(axis))
        + "[acceptance]\n"
        + lines
        + "\n"
}

/// X alone, 0 to 900 mm every 30 mm.
fn one_axis(uncertainty: &str, lines: &str) -> String {
    job(&["x"], [900, 0, 30], uncertainty, lines)
}

fn wave(to: u32, size: f64) -> String {
    let row = |x| format!("x,{x},{:.4}\n", size * (f64::from(x) / 100.0).sin());
    let rows: String = (0..=to).step_by(30).map(row).collect();
    format!("axis,position_mm,ex_um\n{rows}")
}

const NOISE: &str = "[measurement.uncertainty]\nnoise_um = 0.5\n";

/// 0.5 µm at every position and at the reference: 0.5·√2 wherever it is asked for.
#[test]
fn the_noise_at_the_reference_is_in_every_u_and_a_limit_is_judged_for_all_positions() {
    let visit = Visit::with(one_axis(NOISE, "max_deviation_um = 1.1"), wave(900, 8.0));
    visit.run(GENERATE).ends(1);
    let kit = visit.document("kit/manifest.json");
    let verify = visit.json(VERIFY);
    let after = visit.put("after.csv", wave(900, 0.4)).json(AFTER);
    for terms in [&kit["forecast"]["terms"], &verify["terms"], &after["terms"]] {
        let stated = number(&terms["EXX"]["u_um"]);
        assert!((stated - 0.5 * std::f64::consts::SQRT_2).abs() < 1e-6, "{terms}");
    }
    assert_eq!(verify["verdict"], "undecided");
    // 31 values of u = 0.707 µm: the largest true one lies within 2.2 µm, not within 1.4 µm.
    for (limit, expected) in [("2.3", "pass"), ("2.0", "undecided")] {
        let job = one_axis(NOISE, &format!("max_deviation_um = {limit}"));
        let page = Visit::with(&job, wave(900, 8.0)).with_any_kit().json(VERIFY);
        assert_eq!(page["verdict"], expected, "{limit}: {page}");
    }
}

#[test]
fn few_degrees_of_freedom_widen_u() {
    let known =
        "axis,position_mm,ex_um,u_ex_um\nx,0,0e-3,0.5\nx,450,450e-3,0.5\nx,900,900e-3,0.5\n";
    let job = one_axis("", "max_deviation_um = 3").replace("spacing_mm = 30", "spacing_mm = 450");
    let few = format!("# degrees of freedom: 3\n{known}");
    let pages = [&few, known].map(|errors| Visit::with(&job, errors).with_any_kit().json(VERIFY));
    let [with, without] = pages.map(|page| number(&page["terms"]["EXX"]["expanded_um"]));
    assert!(with > 1.7 * without, "{with} µm, {without} µm");
}

#[test]
fn a_part_of_the_travel_decides_nothing_unless_it_is_what_is_asked_for() {
    let limit = "max_deviation_um = 5";
    let visit = Visit::with(one_axis("", limit), wave(300, 8.0));
    let parts = ["EXX within 5 µm", "33 % of the travel of X"];
    let said = verdict(&visit, GENERATE, "undecided", &parts);
    assert!(!said.contains("every term"), "{said}");
    visit.put("after.csv", wave(300, 0.4));
    verdict(&visit, AFTER, "undecided", &[]);
    visit.put("job.toml", one_axis("", &format!("{limit}\nrange_mm = {{ x = [0, 300] }}")));
    verdict(&visit, VERIFY, "pass", &["X from 0 to 300 mm"]);
    verdict(&visit, AFTER, "pass", &[]);
    // What lies outside the stated range is not judged.
    let job = one_axis("", "max_deviation_um = 5");
    let job = replaced(&job, "= 30\n", "= 30\nend_mm = 870\noutside = \"hold\"\n");
    let visit = Visit::with(&job, wave(870, 2.0) + "x,900,50\n").with_any_kit();
    assert_eq!(visit.json(VERIFY)["verdict"], "fail");
    visit.put("job.toml", job + "range_mm = { x = [0, 870] }\n");
    assert_eq!(visit.json(VERIFY)["verdict"], "pass");
}

#[test]
fn what_nobody_measured_afterwards_is_no_second_measurement() {
    let job = one_axis("", "max_deviation_um = 20");
    let visit = Visit::with(&job, wave(900, 8.0)).with_any_kit();
    for (size, words) in [(0.0, "an empty column"), (8.0, "those of the first measurement")] {
        visit.put("after.csv", wave(900, size));
        verdict(&visit, AFTER, "undecided", &[words]);
    }
    visit.run("simulate job.toml --errors --noise-um 0.2 --seed 1 -o after.csv --force");
    verdict(&visit, AFTER, "undecided", &["simulated"]);
    // Both simulated: a rehearsal, judged and called so.
    let simulate = "--errors --noise-um 0.2 --seed";
    visit.run(&format!("simulate job.toml --without-tables {simulate} 2 -o errors2.csv"));
    visit.put("second.toml", replaced(&job, "errors.csv", "errors2.csv"));
    visit.run("generate second.toml -o kit2");
    visit.run(&format!("simulate second.toml {simulate} 3 -o after2.csv"));
    let ran = visit.run("verify second.toml --tables kit2 --after after2.csv");
    ran.says("REHEARSAL").says("verdict: pass");
}

/// The nine terms of a cube of 1 m about its reference, wavy, without any stated u.
fn cube(places: &[f64], size: f64) -> String {
    let axes = ["x", "y", "z"].map(|axis| (axis, places.to_vec()));
    error_rows("ex_um,ey_um,ez_um", &axes, &[""], |_, _, x| {
        let wave = size * (x / 150.0).sin();
        [2.0 * wave, wave, -wave]
    })
}

fn cube_job(uncertainty: &str, lines: &str) -> String {
    let uncertainty = format!("[measurement.uncertainty]\n{uncertainty}\n");
    job(&["x", "y", "z"], [1000, 500, 100], &uncertainty, lines)
}

const TENTHS: [f64; 11] = [0., 100., 200., 300., 400., 500., 600., 700., 800., 900., 1000.];

/// One scale for all positions and axes: 5 µm/m over the 1.732 m of a diagonal, wherever the reference is.
#[test]
fn the_scale_of_the_laser_counts_once_along_a_diagonal() {
    let visit = Visit::with(cube_job("laser_ppm = 5", "max_diagonal_um = 16"), cube(&TENTHS, 1.0))
        .with_any_kit();
    let page = visit.json(VERIFY);
    for diagonal in DIAGONALS {
        let u = number(&page["diagonals"][diagonal]["u_um"]);
        assert!((u - 5.0 * 3.0_f64.sqrt()).abs() < 1e-3, "{diagonal}: {u}");
        let expanded = number(&page["diagonals"][diagonal]["expanded_um"]);
        let is_twice = (1.9..4.0).contains(&(expanded / u));
        assert!(is_twice, "{diagonal}: {expanded}, not that of twice {u}");
    }
    assert_eq!(page["verdict"], "undecided");
    verdict(&visit, VERIFY, "", &["U of EYX, EZX, EXY, EZY, EXZ, EYZ is not stated"]);
}

/// Ends and nothing between; a cluster and a far end: nothing is known of the rest.
#[test]
fn what_was_not_measured_decides_nothing() {
    let job = cube_job("noise_um = 0.1", "max_deviation_um = 5\nmax_diagonal_um = 9");
    for places in [&[0.0, 1000.0][..], &[0.0, 10.0, 20.0, 1000.0]] {
        let visit = Visit::with(&job, cube(places, 1.0));
        verdict(&visit, GENERATE, "undecided", &["of the travel of X"]);
    }
    // One column that stands still beside good ones: no laser read it.
    let job = cube_job("noise_um = 0.1", "max_deviation_um = 5");
    let visit = Visit::with(&job, cube(&TENTHS, 1.0)).with_any_kit();
    let after = cube(&TENTHS, 0.2);
    let (head, rows) = after.split_once('\n').unwrap();
    let still = |row: &str| format!("\n{},0", row.rsplit_once(',').unwrap().0);
    visit.put("after.csv", head.to_string() + &rows.lines().map(still).collect::<String>());
    verdict(&visit, AFTER, "undecided", &["EZX, EZY, EZZ"]);
}

#[test]
fn the_verdict_names_what_no_figure_holds() {
    let job = cube_job("noise_um = 0.1\ntemperature_k = 1", "max_deviation_um = 5");
    let words = ["reversal not measured", "not counted: temperature_k"];
    verdict(&Visit::with(&job, cube(&TENTHS, 1.0)), GENERATE, "", &words);
    let job = one_axis("", "max_deviation_um = 5");
    let plus = wave(900, 8.0).replace("axis,position_mm", "axis,direction,position_mm");
    verdict(&Visit::with(&job, plus.replace("\nx,", "\nx,+,")), GENERATE, "", &["moving + only"]);
    // A forgotten state of the control leaves it undecided.
    let visit = Visit::with(&job, wave(900, 8.0));
    visit.edit("job.toml", "active_while_measuring = \"none\"\n", "");
    verdict(&visit, GENERATE, "undecided", &["`active_while_measuring` is not stated"]);
}

/// `at most 1.234 µm` of what a page leaves; on half of the digit shown it may be `off_um`, as documents have 10⁻⁶ µm.
fn left_on(page: &Value, job: &str, off_um: f64) -> String {
    let left = |rows: &str| {
        let rows = page[rows].as_object().into_iter().flatten();
        let um = rows.map(|(_, row)| number(&row["forecast_um"])).fold(0.0, f64::max);
        format!("{:.3} µm", (um + off_um).max(0.0))
    };
    let (terms, diagonals) = (left("terms"), left("diagonals") + " on the diagonals");
    match (job.contains("max_deviation_um"), job.contains("max_diagonal_um")) {
        (true, true) => format!("{terms} and {diagonals}"),
        (false, true) => diagonals,
        _ => terms,
    }
}

/// Each policy that is offered leaves what was said of it once the job asks for it; `least` are offered.
fn offers_hold(visit: &Visit, job: &str, own: &str, least: usize) -> Vec<String> {
    visit.put("job.toml", job);
    let said = verdict(visit, "generate job.toml -o own", "", &[]);
    // The policies that the advice offers, and what each would leave.
    let lines = said.lines().filter_map(|line| line.trim().strip_prefix("`backlash = "));
    let offers: Vec<_> = lines.filter_map(|line| line.split_once("` would leave ")).collect();
    assert!(offers.len() >= least, "{} offered\n{said}", offers.len());
    let policy = |policy: &str| format!("backlash = {policy}\n");
    assert!(job.contains(&policy(own)));
    for (index, (other, told)) in offers.iter().enumerate() {
        visit.put("other.toml", replaced(job, &policy(own), &policy(other)));
        let made = visit.json(&format!("generate other.toml -o other-{index}"));
        let page = visit.json(&format!("verify other.toml --tables other-{index}"));
        let tables = made["tables"].as_array().map_or(0, Vec::len);
        let tables = format!("{tables} {}", if tables == 1 { "table" } else { "tables" });
        let verdict = page["verdict"].as_str().unwrap();
        let fits =
            |off_um| *told == format!("{} with {tables}: {verdict}", left_on(&page, job, off_um));
        assert!(fits(-5e-7) || fits(5e-7), "{other}: {}\n{said}", left_on(&page, job, 0.0));
    }
    offers.into_iter().map(|(policy, _)| policy.to_string()).collect()
}

fn with_policy(job: &str, policy: &str) -> String {
    replaced(job, "\"generic\"\n", &format!("\"generic\"\nbacklash = {policy}\n"))
}

const BOTH_WAYS: &str = "axis,direction,position_mm,ex_um\nx,+,0,0\nx,+,450,2\nx,+,900,5\nx,-,0,3\nx,-,450,4\nx,-,900,8\n";

/// X alone in both directions, 3 µm of reversal.
fn lost_motion_job(policy: &str) -> String {
    with_policy(&replaced(&one_axis("", "max_deviation_um = 1.2"), "= 30\n", "= 450\n"), policy)
}

/// The best comes first, for the diagonals too where they alone are limited; also of readings.
#[test]
fn another_backlash_policy_leaves_what_was_said_of_it() {
    for (errors, job, least) in [
        (BOTH_WAYS, lost_motion_job("\"mean\""), 2),
        (&cube_both_ways(), cube_both_ways_job("\"mean\"", "max_diagonal_um = 2"), 1),
        (&cube_both_ways(), cube_both_ways_job("\"mean\"", BOTH_LIMITS), 1),
    ] {
        let offered = offers_hold(&Visit::with("", errors), &job, "\"mean\"", least);
        assert_eq!(offered[0], "\"two-tables\"", "{offered:?}");
    }
    let visit = Visit::of("diagonals/case_d_bidirectional");
    visit
        .edit("job.toml", "[compensation]\n", "[compensation]\nbacklash = \"mean\"\n")
        .edit("job.toml", "steps = 10\n", "steps = 10\noverrun = false\n")
        .edit("job.toml", "max_deviation_um = 10.0", "max_deviation_um = 0.3");
    offers_hold(&visit, &visit.read("job.toml"), "\"mean\"", 1);
}

/// The errors without compensation depend on the policy: with some the old backlash parameter belongs to them.
#[test]
fn it_is_offered_beside_active_tables_too() {
    let visit = Visit::with(lost_motion_job("\"forward-only\""), BOTH_WAYS);
    visit.run("generate job.toml -o old");
    let job = replaced(&lost_motion_job("\"mean\""), "\"none\"\n", "\"old\"\n");
    // Without the old parameter, what replaces it is refused, so it is not offered.
    assert!(offers_hold(&visit, &job, "\"mean\"", 0).is_empty());
    let known = replaced(&job, "\"old\"\n", "\"old\"\nactive_backlash_um = { x = 1.5 }\n");
    fs::remove_dir_all(visit.at("own")).unwrap();
    let offered = offers_hold(&visit, &known, "\"mean\"", 2);
    assert_eq!(offered[0], "\"two-tables\"", "{offered:?}");
}

/// Three axes in both directions, each with a reversal of its own.
fn cube_both_ways() -> String {
    let axes = ["x", "y", "z"].map(|axis| (axis, TENTHS.to_vec()));
    error_rows("ex_um,ey_um,ez_um", &axes, &["+", "-"], |axis, way, x| {
        let lost = |own: &str, um: f64| if (own, "-") == (axis, way) { um } else { 0.0 };
        let wave = 3.0 * (x / 150.0).sin();
        // Four decimals, as they stand in a table.
        [("x", 4.0), ("y", 3.0), ("z", 0.2)]
            .map(|(own, um)| ((wave + lost(own, um)) * 1e4).round() / 1e4)
    })
}

fn cube_both_ways_job(policy: &str, lines: &str) -> String {
    with_policy(&cube_job("", lines), policy)
}

const BOTH_LIMITS: &str = "max_deviation_um = 1.2\nmax_diagonal_um = 2";

#[test]
fn of_policies_for_each_axis_one_is_changed() {
    let own = "{ x = \"mean\", y = \"two-tables\", z = \"mean\" }";
    let visit = Visit::with("", cube_both_ways());
    let offered = offers_hold(&visit, &cube_both_ways_job(own, "max_deviation_um = 1.2"), own, 2);
    let best = "{ x = \"two-tables\", y = \"two-tables\", z = \"mean\" }";
    assert!(offered.contains(&best.to_string()), "{offered:?}");
    assert!(offered.iter().all(|policy| policy.contains("y = \"two-tables\"")), "{offered:?}");
}

/// Each line of the comparison is the kit that the job would get; nothing is written.
#[test]
fn compared_policies_leave_what_their_kits_leave() {
    let visit = Visit::with(cube_both_ways_job("\"mean\"", BOTH_LIMITS), cube_both_ways());
    let before = visit.files();
    let page = visit.run("generate job.toml --compare").ends(1).out;
    assert_eq!(page.lines().filter(|line| line.starts_with('"')).count(), 12, "{page}");
    assert!(page.lines().all(|line| line.chars().count() <= 100), "{page}");
    let found = visit.json("generate job.toml --compare");
    assert_eq!(visit.files(), before, "nothing is written");
    let lines = found["compared"].as_array().unwrap();
    assert_eq!((lines.len(), &lines[0]["backlash"]["x"]), (21, &Value::from("mean")));
    for (index, line) in lines.iter().enumerate() {
        let own = |axis: &str| format!("{axis} = {}", line["backlash"][axis]);
        let policy = format!("{{ {} }}", ["x", "y", "z"].map(own).join(", "));
        let spacing = match line["spacing"].as_str().unwrap() {
            "half" => "spacing_mm = 50",
            "twice" => "spacing_mm = 200",
            _ => "spacing_mm = 100",
        };
        visit.put("other.toml", cube_both_ways_job(&policy, BOTH_LIMITS));
        visit.edit("other.toml", "spacing_mm = 100", spacing);
        visit.run(&format!("generate other.toml -o kit-{index}"));
        let made = visit.json(&format!("verify other.toml --tables kit-{index}"));
        assert_eq!(line["verdict"], made["verdict"], "{line}");
        for (one, all) in [("term", "terms"), ("diagonal", "diagonals")] {
            let name = line[one]["name"].as_str().unwrap();
            assert_eq!(line[one]["after_um"], made[all][name]["forecast_um"], "{line}");
        }
    }
}

#[test]
fn a_second_visit_within_the_limit_leaves_the_control_as_it_is() {
    let job = one_axis("", "max_deviation_um = 2");
    let visit = Visit::with(&job, wave(900, 8.0));
    let advice = "the control can be left as it is";
    assert!(!verdict(&visit, GENERATE, "", &[]).contains(advice));
    visit.put("second.toml", replaced(&job, "\"none\"", "\"kit\""));
    visit.put("errors.csv", wave(900, 1.5));
    verdict(&visit, "generate second.toml -o again", "", &[advice]);
    visit.put("errors.csv", wave(900, 2.5));
    assert!(!verdict(&visit, "generate second.toml -o third", "", &[]).contains(advice));
    // Where the diagonals alone are limited, it is they that are said to keep it.
    let job = cube_job("", "max_diagonal_um = 9");
    let visit = Visit::with(&job, cube(&TENTHS, 5.0)).with_any_kit();
    visit.put("second.toml", replaced(&job, "\"none\"", "\"kit\""));
    visit.put("errors.csv", cube(&TENTHS, 1.0));
    let words = &format!("µm on the diagonals): {advice}");
    verdict(&visit, "generate second.toml -o again", "", &[words]);
}

/// Straightness about its own line holds no squareness; slopes that hold it count twice with a stated one.
#[test]
fn squareness_stands_in_the_slopes_or_is_stated() {
    let not_stated = "squareness not stated: state `squareness_um_per_m`";
    let table = |y: &str| {
        let rows: String = (0..=900).step_by(90).map(|at| format!("x,{at},0,0\n")).collect();
        format!("axis,position_mm,ex_um,ey_um\n{rows}{}", y.replace(';', "\n"))
    };
    let ends = table("y,0,0,0;y,450,7,0;y,900,0,0");
    let least_squares = table("y,0,-1,0;y,450,2,0;y,900,-1,0");
    let sloped = table("y,0,0,0;y,450,7,0;y,900,9,0");
    for (errors, xy, expected, said) in [
        (&ends, "", "undecided", not_stated),
        (&least_squares, "", "undecided", not_stated),
        (&ends, "0.0", "pass", ""),
        (&ends, "9.0", "pass", ""),
        (&sloped, "", "pass", ""),
        (&sloped, "11.0", "undecided", "the slopes of EXY and EYX hold 10.000 µm/m: both count"),
        (&sloped, "-11.0", "undecided", "the slopes of EXY and EYX hold 10.000 µm/m: both count"),
        (&sloped, "-40.0", "pass", ""),
    ] {
        let stated = format!("squareness_um_per_m = {{ xy = {xy} }}\n");
        let stated = if xy.is_empty() { "" } else { &stated };
        let job = job(&["x", "y"], [900, 0, 30], stated, "max_deviation_um = 5");
        let visit = Visit::with(job, errors.as_str());
        verdict(&visit, GENERATE, expected, &[said]);
        let is_open = visit.json(VERIFY)["squareness"]["xy"]["before_um_per_m"].is_null();
        assert_eq!(is_open, said == not_stated, "{xy}");
    }
    // Of the 21 it is one that a level table does not hold.
    for (errors, known) in [(&ends, 4), (&sloped, 5)] {
        let visit = Visit::new();
        visit.put("errors.csv", errors);
        assert_eq!(visit.json("assess errors.csv")["errors_measured"], known);
    }
    // Nor is it known as left, where no table corrects a slope; nor of an update, where the old kit did not.
    let first = job(&["x", "y"], [900, 0, 30], "", "max_deviation_um = 8");
    let first = replaced(&first, "[compensation]\n", "[compensation]\nterms = [\"EXX\"]\n");
    let visit = Visit::with(&first, ends.as_str()).with_any_kit();
    visit.put("after.csv", &ends);
    verdict(&visit, AFTER, "undecided", &[not_stated]);
    let active = "active_while_measuring = \"kit\"";
    visit.put("job.toml", replaced(&first, "active_while_measuring = \"none\"", active));
    verdict(&visit, "generate job.toml -o new", "undecided", &[not_stated]);
}
