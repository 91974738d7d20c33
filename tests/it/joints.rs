//! LinuxCNC from a job to the machine's ini file and back; its interpreter takes the programs where it is installed.
use crate::support::{Visit, holds, number, own_profile};
use std::process::Command;

const NONE: &str = "active_while_measuring = \"none\"\nactive_backlash_um = { x = 0.0, y = 0.0 }";
const TWO: &str = "backlash = { x = \"two-tables\" }";
/// The table of X with the reversal in it.
const ROWS: &str = "0.000000 0.000000 -0.004000\n50.000000 -0.006000 -0.010000\n\
    100.000000 -0.016000 -0.020000\n";

/// Two axes; X lags by 4 µm moving down, and bends Y.
fn visit(measurement: &str, compensation: &str) -> Visit {
    let visit = Visit::of("base/joints");
    visit.edit("job.toml", NONE, measurement).edit("job.toml", TWO, compensation);
    visit
}

#[track_caller]
fn kit(measurement: &str, compensation: &str) -> Visit {
    visit(measurement, compensation).with_kit()
}

/// A table has up to 256 rows (fixtures/cases/refuses/controls.txt).
#[test]
fn tables_are_minus_the_deviation_and_files_of_a_machine_are_judged_as_linuxcnc_reads_them() {
    let most = visit(NONE, TWO);
    most.edit("job.toml", "axes.x = { spacing_mm = 50", "axes.x = { points = 256");
    most.yes("generate job.toml -o kit");
    let visit = kit(NONE, TWO);
    assert_eq!(visit.read("kit/joint-0.comp"), ROWS);
    let manifest = visit.document("kit/manifest.json");
    let why = "the control has no tables for cross terms (COMP_FILE corrects its own joint only)";
    assert_eq!(manifest["omitted"][0]["term"], "EYX");
    assert_eq!(manifest["omitted"][0]["reason"], why);
    let left = &manifest["forecast"]["terms"]["EYX"];
    assert_eq!(left["before_um"], left["after_um"], "nothing corrects it");
    visit.yes("verify job.toml --tables kit");
    let lines = visit.read("kit/joints.ini");
    let joint = |n: u32| {
        let section = format!("[JOINT_{n}]\n");
        let own = lines.split(&section).nth(1).and_then(|rest| rest.split('[').next());
        format!("{section}MIN_LIMIT = 0\nHOME_OFFSET = 0\n{}", own.unwrap_or(""))
    };
    let head = "[EMC]\nVERSION = 1.1\n[KINS]\nJOINTS = 2\n[TRAJ]\nLINEAR_UNITS = mm\n";
    visit.put("out/machine.ini", format!("{head}{}{}", joint(0), joint(1)));
    // The lines of the kit beside it say nothing for the machine's own.
    for name in ["joint-0.comp", "joint-1.comp", "joints.ini"] {
        visit.put(&format!("out/{name}"), visit.read(&format!("kit/{name}")));
    }
    let verify = "verify job.toml --tables out --explain";
    visit.run(verify).ends(0);
    let ini = "machine.ini";
    for (name, from, to, status, words) in [
        (ini, "COMP_FILE_TYPE = 1", "COMP_FILE_TYPE = 0", 1, "EXX"),
        (ini, "COMP_FILE_TYPE = 1", "", 1, "EXX"),
        (ini, "MIN_LIMIT = 0", "HOME_LATCH_VEL = -5", 1, "HOME_LATCH_VEL of [JOINT_0] is -5"),
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
        visit.run_with(&format!("out/{name}"), from, to, verify).ends(status).says(words);
    }
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

#[test]
fn a_profile_may_write_the_other_type() {
    let columns =
        "[facts.columns]\nvalue = \"reached\"\nevidence = \"manual\"\nsource = \"a shop\"\n";
    let visit = visit(NONE, TWO);
    visit.put("own.toml", own_profile("linuxcnc", columns)).edit(
        "job.toml",
        "\"linuxcnc\"",
        "\"own.toml\"",
    );
    visit.yes("generate job.toml -o kit");
    let rows = "0.000000 0.000000 0.004000\n50.000000 50.006000 50.010000\n100.000000 100.016000 100.020000\n";
    assert_eq!(visit.read("kit/joint-0.comp"), rows);
    assert!(visit.read("kit/joints.ini").contains("COMP_FILE_TYPE = 0"));
}

#[test]
fn the_interpreter_of_linuxcnc_takes_the_programs() {
    let visit = visit(NONE, TWO);
    let z = "name = \"M\"\naxes.z = { travel_mm = [-100, 0], reference_mm = 0 }";
    visit.edit("job.toml", "name = \"M\"", z);
    let asked = "[program]\nwhat = \"step-diagonal\"\nstart_mm = { x = 10, y = 10, z = -90 }\n\
             size_mm = { x = 80, y = 80, z = 80 }\nsteps = 4\norder = \"XYZ\"\n[acceptance]";
    visit.edit("job.toml", "[acceptance]", asked);
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
