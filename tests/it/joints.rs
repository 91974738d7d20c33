//! LinuxCNC from a job to the machine's ini file and back: what is served, what BACKLASH does to a kit, what is
//! judged of files read out, and that the interpreter of LinuxCNC takes the programs (where it is installed).
use crate::support::{Visit, holds, number};
use std::process::Command;

/// Two axes; X lags by 4 µm moving down, and bends Y.
const ERRORS: &str = "axis,direction,position_mm,ex_um,ey_um\n\
    x,+,0,0,0\nx,+,50,6,3\nx,+,100,16,-4\nx,-,0,4,0\nx,-,50,10,3\nx,-,100,20,-4\n";
const ERRORS_Y: &str = "axis,position_mm,ey_um\ny,0,0\ny,50,-2\ny,100,5\n";

const NONE: &str = "active_while_measuring = \"none\"\nactive_backlash_um = { x = 0.0, y = 0.0 }";
const TWO: &str = "backlash = { x = \"two-tables\" }";
/// The table of X with the reversal in it.
const ROWS: &str = "0.000000 0.000000 -0.004000\n50.000000 -0.006000 -0.010000\n\
    100.000000 -0.016000 -0.020000\n";

fn visit(measurement: &str, compensation: &str) -> Visit {
    let axis = "{ travel_mm = [0, 100], reference_mm = 0 }";
    let job = format!(
        "schema = 1\n[machine]\nname = \"M\"\naxes = {{ x = {axis}, y = {axis} }}\n\
         [measurement]\nerrors = [\"x.csv\", \"y.csv\"]\n{measurement}\n\
         [compensation]\ncontroller = \"linuxcnc\"\n{compensation}\n\
         axes.x = {{ spacing_mm = 50, id = \"0\" }}\naxes.y = {{ spacing_mm = 50, id = \"1\" }}\n\
         [acceptance]\nmax_deviation_um = 100\n"
    );
    let visit = Visit::new();
    visit.put("x.csv", ERRORS).put("y.csv", ERRORS_Y).put("job.toml", job);
    visit
}

#[track_caller]
fn kit(measurement: &str, compensation: &str) -> Visit {
    visit(measurement, compensation).with_kit()
}

#[test]
fn a_table_is_minus_the_deviation_and_cross_terms_are_told() {
    let visit = kit(NONE, TWO);
    assert_eq!(visit.read("kit/joint-0.comp"), ROWS);
    let manifest = visit.document("kit/manifest.json");
    let why = "the control has no tables for cross terms (COMP_FILE corrects its own joint only)";
    assert_eq!(manifest["omitted"][0]["term"], "EYX");
    assert_eq!(manifest["omitted"][0]["reason"], why);
    let left = &manifest["forecast"]["terms"]["EYX"];
    assert_eq!(left["before_um"], left["after_um"], "nothing corrects it");
    visit.yes("verify job.toml --tables kit");
}

/// A COMP_FILE switches BACKLASH off: the reversal that a policy leaves to it stands in the columns, and so do 10 µm
/// that acted while measuring, which make 14 µm. With the mean the reversal comes back, and the forecast says so.
#[test]
fn what_backlash_does_is_taken_over() {
    let visit = kit(NONE, "backlash = { x = \"curve-and-parameter\" }");
    assert_eq!(visit.read("kit/joint-0.comp"), ROWS);
    holds(&visit.read("kit/checklist.md"), &["BACKLASH of [JOINT_0]"]);
    let acted = NONE.replace("x = 0.0", "x = 10.0");
    let rows = "0.000000 0.000000 -0.014000\n50.000000 -0.006000 -0.020000\n100.000000 -0.016000 -0.030000\n";
    assert_eq!(kit(&acted, TWO).read("kit/joint-0.comp"), rows);
    let mean = kit(&acted, "backlash = { x = \"mean\" }").document("kit/manifest.json");
    let after = number(&mean["forecast"]["terms"]["EXX"]["after_um"]);
    assert!((after - 14.0).abs() < 1e-3, "{after}");
}

/// Nobody measured the 10 µm of Y; a table has up to 256 rows.
#[test]
fn what_no_table_can_hold_is_refused() {
    let of_both = NONE.replace("= 0.0", "= 10.0");
    let cross = "terms = [\"EYX\"]\nbacklash = { x = \"mean\" }";
    for (measurement, compensation, grid, status, words) in [
        (NONE, cross, "spacing_mm = 50", 2, "COMP_FILE corrects its own joint only"),
        (&of_both, TWO, "spacing_mm = 50", 2, "`backlash` is not stated"),
        (NONE, TWO, "points = 256", 0, ""),
        (NONE, TWO, "points = 257", 2, "257 points, more than the 256 of a COMP_FILE"),
    ] {
        let visit = visit(measurement, compensation);
        visit.edit("job.toml", "axes.x = { spacing_mm = 50", &format!("axes.x = {{ {grid}"));
        visit.run("generate job.toml -o kit").ends(status).says(words);
    }
}

/// An ini file of a machine with the lines of a kit in it.
fn ini(lines: &str) -> String {
    let joint = |n: u32| {
        let section = format!("[JOINT_{n}]\n");
        let own = lines.split(&section).nth(1).and_then(|rest| rest.split('[').next());
        format!("{section}MIN_LIMIT = 0\nHOME_OFFSET = 0\n{}", own.unwrap_or(""))
    };
    let head = "[EMC]\nVERSION = 1.1\n[KINS]\nJOINTS = 2\n[TRAJ]\nLINEAR_UNITS = mm\n";
    format!("{head}{}{}", joint(0), joint(1))
}

/// The machine's files as they were copied, beside a job with its kit.
fn copied() -> Visit {
    let visit = kit(NONE, TWO);
    visit.put("out/machine.ini", ini(&visit.read("kit/joints.ini")));
    for name in ["joint-0.comp", "joint-1.comp"] {
        visit.put(&format!("out/{name}"), visit.read(&format!("kit/{name}")));
    }
    visit
}

#[test]
fn the_files_of_a_machine_are_judged_as_linuxcnc_reads_them() {
    let visit = copied();
    // The lines of the kit beside it say nothing for the machine's own.
    visit.put("out/joints.ini", visit.read("kit/joints.ini"));
    let verify = "verify job.toml --tables out --explain";
    visit.run(verify).ends(0);
    let latch = "HOME_LATCH_VEL of [JOINT_0] is -5";
    let ini = "machine.ini";
    for (name, from, to, status, words) in [
        (ini, "COMP_FILE_TYPE = 1", "COMP_FILE_TYPE = 0", 1, "EXX"),
        (ini, "COMP_FILE_TYPE = 1", "", 1, "EXX"),
        (ini, "MIN_LIMIT = 0", "HOME_LATCH_VEL = -5", 1, latch),
        (ini, "= joint-1.comp", "= other/joint-0.comp", 2, "in different folders"),
        (ini, "LINEAR_UNITS = mm", "LINEAR_UNITS = inch", 1, "counts in inch, the job in mm"),
        (ini, "HOME_OFFSET = 0", "HOME_OFFSET = 20", 1, "HOME_OFFSET of [JOINT_0] is 20 mm"),
        (ini, "COMP_FILE = joint-1.comp", "# none", 1, "EYY"),
        (ini, "COMP_FILE = joint-1.comp", "COMP_FILE = joint-0.comp", 1, "EYY"),
        (ini, "[JOINT_1]", "[JOINT_7]", 1, "the table of JOINT_7 belongs to a joint"),
        (ini, "MIN_LIMIT = 0", "BACKLASH = 0.010", 0, "pass"),
        (ini, "MIN_LIMIT", "#INCLUDE", 2, "includes another file"),
        ("joint-0.comp", "50.000000 -0.006000", "50.000000 0.006000", 1, "EXX"),
        ("joint-0.comp", "50.000000", "# 50\n50.000000", 2, "stops reading here without a word"),
    ] {
        println!("{name}: {to}");
        let path = format!("out/{name}");
        let text = visit.read(&path);
        visit.edit(&path, from, to);
        visit.run(verify).ends(status).says(words);
        visit.put(&path, text);
    }
}

/// Half of the errors were corrected while measuring: new = old + residual.
#[test]
fn old_tables_are_part_of_the_new_ones() {
    let visit = copied();
    visit.edit("job.toml", NONE, "active_while_measuring = \"out\"");
    visit.yes("generate job.toml -o again");
    let rows = "0.000000 0.000000 -0.008000\n50.000000 -0.012000 -0.020000\n100.000000 -0.032000 -0.040000\n";
    assert_eq!(visit.read("again/joint-0.comp"), rows);
}

#[test]
fn a_second_measurement_is_judged() {
    let visit = kit(NONE, TWO);
    visit.edit("job.toml", "max_deviation_um = 100", "max_deviation_um = 10");
    ensure_second_measurement_judged(&visit, "0.1");
    ensure_second_measurement_judged(&super::isg::kit("", ""), "0.05");
}

/// As the emulated control would give it; one without tables misses.
#[track_caller]
fn ensure_second_measurement_judged(visit: &Visit, noise_um: &str) {
    let simulate = format!("simulate job.toml --errors --noise-um {noise_um} --seed 3 --force");
    for (tables, expected) in [("--tables kit", "pass"), ("--without-tables", "fail")] {
        visit.yes(&format!("{simulate} {tables} -o after.csv"));
        // Without the remarks that say it was simulated.
        let table = visit.read("after.csv");
        let rows = table.split_inclusive('\n').filter(|line| !line.starts_with('#'));
        visit.put("after.csv", rows.collect::<String>());
        let page = visit.json("verify job.toml --tables kit --after after.csv");
        assert_eq!(page["verdict"], expected, "{tables} {page:#}");
    }
}

/// Positions reached in place of values to add: another file, the same effect.
#[test]
fn a_profile_may_write_the_other_type() {
    let own = "schema = 1\nid = \"own\"\nname = \"own\"\nbased_on = \"linuxcnc\"\n[facts.columns]\n\
               value = \"reached\"\nevidence = \"manual\"\nsource = \"a shop that writes type 0\"\n";
    let visit = visit(NONE, TWO);
    visit.put("own.toml", own).edit("job.toml", "\"linuxcnc\"", "\"own.toml\"");
    visit.yes("generate job.toml -o kit");
    let rows = "0.000000 0.000000 0.004000\n50.000000 50.006000 50.010000\n100.000000 100.016000 100.020000\n";
    assert_eq!(visit.read("kit/joint-0.comp"), rows);
    assert!(visit.read("kit/joints.ini").contains("COMP_FILE_TYPE = 0"));
}

#[test]
fn the_interpreter_of_linuxcnc_takes_the_programs() {
    let visit = visit(NONE, TWO);
    let axes = "axes = { z = { travel_mm = [-100, 0], reference_mm = 0 }, ";
    visit.edit("job.toml", "axes = { ", axes);
    let z = "[program]\nwhat = \"step-diagonal\"\nstart_mm = { x = 10, y = 10, z = -90 }\n\
             size_mm = { x = 80, y = 80, z = 80 }\nsteps = 4\norder = \"XYZ\"\n[acceptance]";
    visit.edit("job.toml", "[acceptance]", z);
    visit.yes("program job.toml -o programs");
    let files = visit.files();
    let programs: Vec<_> = files.keys().filter(|name| name.ends_with(".ngc")).collect();
    assert_eq!(programs.len(), 4);
    for name in programs {
        let mut command = Command::new("rs274");
        command.arg("-g").arg(name).env("HOME", visit.folder()).current_dir(visit.folder());
        let Ok(run) = command.output() else {
            println!("rs274 is not installed: the programs were not interpreted");
            return;
        };
        let said = String::from_utf8_lossy(&run.stdout).into_owned();
        let traverses = said.matches("STRAIGHT_TRAVERSE(").count();
        let feeds = said.matches("STRAIGHT_FEED(").count();
        assert!(run.status.success() && traverses > 1 && feeds > 12, "{said}");
        assert!(said.contains("PROGRAM_END()") && said.contains("DWELL(3.0000)"), "{said}");
    }
}
