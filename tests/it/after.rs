//! `verify --after`: the figures of the page and the verdict on what was measured.

use crate::support::{UNCORRECTED, Visit, error_rows, fixture, holds, lacks, number};
use serde_json::Value;

const ACCEPTANCE: &str = "[acceptance]\nmax_deviation_um = 1.0\n";
const KIT_ACTIVE: &str = "active_while_measuring = \"kit\"";
const LEFT: &str = "axis,position_mm,ex_um,ey_um\nx,0,0,0\nx,50,0.2,0.1\nx,100,0.3,0\n";
/// What was found, where a test states its uncertainty.
const FOUND: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [50.0, 6.0, 3.0], [100.0, 16.0, -4.0]];

/// X and Y, corrected along X.
fn job() -> String {
    let y = "[machine.axes.y]\ntravel_mm = [0.0, 100.0]\nreference_mm = 0.0\n";
    fixture("base/verify/job.toml") + y + ACCEPTANCE
}

fn visit(after: &str) -> Visit {
    let errors = "axis,position_mm,ex_um,ey_um\nx,0,0,0\nx,50,6,3\nx,100,16,-4\n";
    let visit = Visit::with(job(), errors).with_any_kit();
    visit.put("after.csv", after);
    visit
}

struct Judged {
    status: Option<i32>,
    page: Value,
}

fn verified(visit: &Visit, options: &str) -> Judged {
    let ran = visit.run(&format!("verify job.toml --tables kit {options} --format json"));
    Judged { status: ran.status, page: ran.json() }
}

fn again(visit: &Visit, after: &str) -> Judged {
    verified(visit, &format!("--after {after}"))
}

fn judged(after: &str) -> Judged {
    again(&visit(after), "after.csv")
}

impl Judged {
    #[track_caller]
    fn is(self, verdict: &str, causes: &[&str]) -> Judged {
        assert_eq!(self.page["verdict"], verdict, "{:#}", self.page);
        assert_eq!(self.status, Some(i32::from(verdict != "pass")), "{:#}", self.page);
        causes.iter().fold(self, |judged, words| judged.says("causes", words))
    }

    #[track_caller]
    fn figure(self, term: &str, key: &str, um: f64) -> Judged {
        assert_eq!(number(&self.page["terms"][term][key]), um, "{term} {key}");
        self
    }

    #[track_caller]
    fn says(self, part: &str, words: &str) -> Judged {
        holds(&self.page[part].to_string(), &[words]);
        self
    }

    #[track_caller]
    fn omits(self, part: &str, words: &str) -> Judged {
        lacks(&self.page[part].to_string(), &[words]);
        self
    }
}

fn table(rows: &[[f64; 3]], u_um: f64) -> String {
    let row = |[at, ex, ey]: &[f64; 3]| format!("x,{at},{ex},{ey},{u_um},{u_um}\n");
    let head = "axis,position_mm,ex_um,ey_um,u_ex_um,u_ey_um\n".to_string();
    head + &rows.iter().map(row).collect::<String>()
}

#[test]
fn figures_are_zero_at_the_reference_whatever_the_laser_counted_from() {
    let found = judged(&table(&[[0.0, 7.0, -3.0], [50.0, 7.3, -3.1], [100.0, 6.5, -2.8]], 0.15))
        .is("pass", &[])
        .figure("EXX", "before_um", 16.0)
        .figure("EXX", "forecast_um", 0.0)
        .figure("EXX", "after_um", 0.5) // 6.5 − 7
        // Two values of the table, each with u = 0.15: the largest and the one at the reference.
        .figure("EXX", "u_um", 0.212132)
        .figure("EXX", "difference_um", 0.5)
        .figure("EYX", "after_um", 0.2);
    assert_eq!(found.page["max_residual_um"], 0.5);
    assert_eq!(found.page["diagnosis"]["as_forecast"], true);
    assert_eq!(found.page["causes"], serde_json::json!([]));
}

#[test]
fn the_uncertainty_decides_between_fail_and_undecided() {
    for (um, u_um, verdict) in [
        (0.7, 0.1, "pass"), // u = √2·0.1, one-sided 1.645 u = 0.233
        (0.8, 0.1, "undecided"),
        (1.7, 0.2, "undecided"),
        (1.8, 0.2, "fail"), // six values: 2.63 u = 0.743
    ] {
        println!("{um}, u = {u_um}");
        let rows = [[0.0, 0.0, 0.0], [50.0, um, 0.01], [100.0, 0.0, 0.0]];
        judged(&table(&rows, u_um)).is(verdict, &[]);
    }
}

#[test]
fn what_decides_and_what_leaves_it_undecided_is_named() {
    let found = judged("axis,position_mm,ex_um\nx,0,0\nx,50,0.1\nx,100,0.1\n")
        .is("undecided", &["not measured afterwards", "EYX"]);
    assert!(found.page["terms"]["EYX"]["after_um"].is_null());
    let shorter = table(&[[0.0, 0.0, 0.0], [50.0, 0.1, 0.0]], 0.1);
    judged(&shorter).is("undecided", &["less than nine tenths decide nothing"]);
    // Slopes of cross terms that were separated hold another rotation than those of a given table.
    let frames = "as found: as given; afterwards: x-primary";
    judged(&format!("# frame: x-primary\n{LEFT}")).is("undecided", &[frames]);
    // Lost motion that the first measurement could not see.
    judged(&directed([0.0, 0.05, 0.0], 5.0))
        .is("fail", &["LOST MOTION, no fault of the tables", "EXX -5.000"])
        .omits("causes", "unknown");
    judged("axis,position_mm,ex_um,ey_um\nx,0,0,0\nx,50,2,0\nx,100,0,0\n")
        .says("causes", "EXX leaves 2.000 µm, U not stated");
    // Without limits a turned sign decides nothing.
    let visit = visit("axis,position_mm,ex_um,ey_um\nx,0,0,0\nx,50,12,6\nx,100,32,-8\n");
    visit.edit("job.toml", ACCEPTANCE, "");
    again(&visit, "after.csv").is("undecided", &["SIGN TURNED"]);
}

#[test]
fn what_may_be_the_rotation_between_two_frames_does_not_fail() {
    let table = |ex: f64, ey: f64| {
        let of = |share: f64| format!("x,{},{},{}\n", 100.0 * share, ex * share, ey * share);
        let rows = [0.0, 0.5, 1.0].map(of).concat();
        format!("# frame: as-measured\naxis,position_mm,ex_um,ey_um\n{rows}")
    };
    let visit = Visit::with(job(), table(16.0, -4.0)).with_any_kit();
    for (ex, ey, verdict) in [(0.3, 0.4, "pass"), (0.3, 30.0, "undecided"), (30.0, 0.4, "fail")] {
        visit.put("after.csv", table(ex, ey));
        again(&visit, "after.csv").is(verdict, &[]).says("notes", "another one each time");
    }
}

#[test]
fn the_limits_are_those_of_the_first_job() {
    let visit = visit(LEFT);
    let second = "schema = 1\n[measurement]\nerrors = \"after.csv\"\n";
    let judged = |limit: &str| {
        visit.put("after.toml", format!("{second}[acceptance]\nmax_deviation_um = {limit}\n"));
        visit.run("verify job.toml --tables kit --after after.toml")
    };
    judged("1.0").ends(0).says("each of EXX, EYX within 1 µm");
    judged("3.0").ends(2).says("after.toml:4:1").says("other limits than the first");
}

#[test]
fn tables_that_do_not_act_or_were_changed_fail() {
    visit(&table(&[[0.0, 0.0, 0.0], [50.0, 6.05, 3.02], [100.0, 16.0, -4.0]], 0.1))
        .run("verify job.toml --tables kit --after after.csv")
        .ends(1)
        .tells(&["NOT ACTIVE: all tables do not act", "to decide:", "verdict: fail"]);
    let visit = visit(&table(&[[0.0, 0.0, 0.0], [50.0, 0.0, 0.0], [100.0, 0.0, 0.0]], 0.1));
    visit.append("kit/compensation.csv", "\n");
    again(&visit, "after.csv").is("fail", &["hash"]);
}

#[test]
fn a_job_with_readings_gives_what_its_separated_table_gives() {
    let visit = Visit::of("start/readings").with_any_kit();
    visit.yes("separate job.toml -o separated.csv");
    visit.put("after.toml", visit.read("job.toml").replace(UNCORRECTED, KIT_ACTIVE));
    let [by_job, by_table] = ["after.toml", "separated.csv"].map(|after| again(&visit, after).page);
    for part in ["terms", "diagonals", "verdict", "diagnosis"] {
        assert_eq!(by_job[part], by_table[part]);
    }
    let exx = &by_job["terms"]["EXX"];
    assert!(exx["after_um"].is_number());
    assert_eq!(exx["after_um"], exx["before_um"], "the same readings: nothing acts");
    // Lengths that were brought to 20 °C are not compared with lengths that were not.
    let material = "[measurement.step_diagonal.material]\nmaterial_corrected = false\nair_corrected = true\nx = { alpha_per_k = 11.5e-6, temperature_c = 22.0 }\n\n[compensation]\n";
    visit.edit("job.toml", "[compensation]\n", material);
    visit.run("generate job.toml -o kit --force").answers();
    let ran = visit.run("verify job.toml --tables kit --after after.toml");
    ran.says("does not state [measurement.step_diagonal.material]");
}

fn after_job(active: &str, more: &str) -> String {
    let job = job().replace("errors.csv", "after.csv").replace(UNCORRECTED, active);
    job.replace("[compensation]", &format!("{more}[compensation]"))
}

/// A copy of the kit in another folder is the same kit: what it does is compared.
#[test]
fn a_second_job_that_does_not_say_what_was_active_is_warned_about() {
    let visit = visit(LEFT);
    visit.run("generate job.toml -o archive").answers();
    visit.put("after.toml", after_job("", ""));
    again(&visit, "after.toml").says("notes", "does not state `active_while_measuring`");
    for active in [KIT_ACTIVE, "active_while_measuring = \"archive\""] {
        visit.put("after.toml", after_job(active, ""));
        again(&visit, "after.toml").is("pass", &[]).omits("notes", "does not state");
    }
}

#[test]
fn the_scale_of_the_laser_is_in_the_uncertainty() {
    let visit = visit(LEFT);
    let stated = "[measurement.uncertainty]\nnoise_um = 0.1\nlaser_ppm = 5.0\nsetup_ppm = 1.0\n";
    visit.put("after.toml", after_job(KIT_ACTIVE, stated));
    again(&visit, "after.toml")
        // 0.1²+ 0.1² + (5 µm/m · 0.1 m)² = 0.27; no laser scale in a straightness.
        .figure("EXX", "u_um", 0.519615)
        .figure("EYX", "u_um", 0.141421)
        .says("notes", "`setup_ppm`")
        .omits("notes", "`laser_ppm` of");
}

#[test]
fn far_fewer_positions_leave_it_undecided() {
    let rows = |step: usize| {
        let row = |x: i32| format!("x,{x},{},{}\n", f64::from(x) / 1e3, f64::from(x) / 2e3);
        let rows: String = (0..=100).step_by(step).map(row).collect();
        format!("axis,position_mm,ex_um,ey_um\n{rows}")
    };
    let visit = visit(LEFT);
    visit.put("errors.csv", rows(10)).run("generate job.toml -o kit --force").answers();
    for (step, verdict) in [(20, "pass"), (25, "undecided"), (100, "undecided")] {
        visit.put("after.csv", rows(step));
        let causes = again(&visit, "after.csv").is(verdict, &[]).page["causes"].to_string();
        let is_told = causes.contains("between the targets is not known");
        assert_eq!(is_told, verdict != "pass", "every {step} mm");
    }
}

/// Errors in both directions with a lost motion, and what `generate` does with it.
fn both_ways(policy: &str, lost_um: f64) -> Visit {
    let visit = visit(LEFT);
    visit.under("[compensation]", &format!("backlash = \"{policy}\""));
    visit.put("errors.csv", directed([0.0, 6.0, 16.0], lost_um));
    visit.run("generate job.toml -o kit --force").answers();
    visit
}

/// Rows of X in both directions; moving - it stands `lost_um` further in +.
fn directed(ex_um: [f64; 3], lost_um: f64) -> String {
    let columns = "ex_um,ey_um,u_ex_um,u_ey_um";
    error_rows(columns, &[("x", vec![0.0, 50.0, 100.0])], &["+", "-"], |_, way, at| {
        let lost = if way == "-" { lost_um } else { 0.0 };
        [ex_um[at as usize / 50] + lost, at / 1e4, 0.05, 0.05]
    })
}

#[test]
fn one_direction_decides_nothing_where_both_were_found() {
    let once = "axis,direction,position_mm,ex_um,ey_um\nx,+,0,0,0\nx,+,50,0.1,0\nx,+,100,0.1,0\n";
    for policy in ["two-tables", "curve-and-parameter", "mean"] {
        println!("{policy}");
        let visit = both_ways(policy, 3.0);
        visit.put("after.csv", once);
        again(&visit, "after.csv").is("undecided", &["reversal that is left: EXX"]);
    }
}

#[test]
fn noise_hides_inactive_tables_and_a_reversal_left_on_purpose_does_not() {
    let left = both_ways("mean", 14.0);
    left.edit("errors.csv", ",0.05,0.05", ",,").run("generate job.toml -o kit --force").answers();
    left.put("after.csv", directed([0.0, 6.1, 15.9], 14.0)).edit("after.csv", ",0.05,0.05", ",,");
    let found = again(&left, "after.csv").says("causes", "NOT ACTIVE");
    assert_eq!(found.page["diagnosis"]["as_forecast"], false, "{:#}", found.page);
    // Noise as large as the errors hides whether the tables act.
    let visit = visit(&table(&[[0.0, 0.0, 0.0], [50.0, 5.0, 3.0], [100.0, 9.0, -4.0]], 20.0));
    visit.put("errors.csv", table(&FOUND, 20.0)).run("generate job.toml -o kit --force").answers();
    let found =
        again(&visit, "after.csv").says("causes", "whether the tables act does not show").page;
    assert_eq!(found["diagnosis"]["hides_tables"], true, "{found:#}");
}

#[test]
fn what_is_off_the_forecast_is_named_though_it_passes() {
    let visit = visit(&table(&[[0.0, 0.0, 0.0], [50.0, 0.6, 0.01], [100.0, 0.0, 0.0]], 0.05));
    visit.put("errors.csv", table(&FOUND, 0.05));
    let words = "explain (99.9 %, all positions together): EXX 0.600 µm (U = 0.376 µm)";
    again(&visit, "after.csv").is("pass", &[]).says("notes", words).omits("notes", "EYX");
}

/// The kit names a parameter in its manifest; the job asks for another one.
#[test]
fn the_backlash_parameter_of_a_kit_is_the_one_of_its_manifest() {
    let visit = both_ways("curve-and-parameter", 3.0);
    visit.yes("verify job.toml --tables kit");
    visit.put("errors.csv", directed([0.0, 6.0, 16.0], 5.0));
    let cause = "the kit was made for 3 µm, the job asks for 5 µm";
    verified(&visit, "").is("fail", &[cause]).figure("EXX", "forecast_um", 2.0);
    let ran = visit.run("simulate job.toml --tables kit --errors -o -");
    ran.tells(&["x,-,100,2,", "3.000 µm as manifest.json of the kit names it"]);
}

#[test]
fn simulated_noise_is_stated_once() {
    let visit = Visit::of("start/errors");
    let u = |noise_um: &str| {
        let table = visit.yes(&format!("simulate job.toml --errors --noise-um {noise_um} -o -"));
        let rows = table.lines().filter(|line| line.starts_with("x,"));
        let last = rows.map(|row| row.rsplit(',').next().unwrap().to_string());
        table.contains("u_ez_um").then(|| last.max().unwrap())
    };
    assert_eq!(u("0.5").as_deref(), Some("0.5"));
    let stated = "[measurement.uncertainty]\nnoise_um = 0.3\n\n[compensation]\n";
    visit.edit("job.toml", "[compensation]\n", stated);
    assert_eq!(u("0.5").as_deref(), Some("0.4"));
    assert_eq!(u("0.3"), None);
}
