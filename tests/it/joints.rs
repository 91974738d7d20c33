//! LinuxCNC from a job to the machine's ini file and back: what is served, what BACKLASH does to a kit, what is
//! judged of files read out, and that the interpreter of LinuxCNC takes the programs (where it is installed).
use crate::support::run::ended;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// Two axes; X lags by 4 µm moving down, and bends Y.
const ERRORS: &str = "axis,direction,position_mm,ex_um,ey_um\n\
    x,+,0,0,0\nx,+,50,6,3\nx,+,100,16,-4\nx,-,0,4,0\nx,-,50,10,3\nx,-,100,20,-4\n";
const ERRORS_Y: &str = "axis,position_mm,ey_um\ny,0,0\ny,50,-2\ny,100,5\n";

fn job(measurement: &str, compensation: &str) -> String {
    format!(
        "schema = 1\n[machine]\nname = \"M\"\n[measurement]\nerrors = [\"x.csv\", \"y.csv\"]\n{measurement}\n\
         [compensation]\ncontroller = \"linuxcnc\"\n{compensation}\n\
         [machine.axes.x]\ntravel_mm = [0, 100]\nreference_mm = 0\n\
         [machine.axes.y]\ntravel_mm = [0, 100]\nreference_mm = 0\n\
         [compensation.axes.x]\nspacing_mm = 50\nid = \"0\"\n\
         [compensation.axes.y]\nspacing_mm = 50\nid = \"1\"\n\
         [acceptance]\nmax_deviation_um = 100\n"
    )
}

const NONE: &str = "active_while_measuring = \"none\"\nactive_backlash_um = { x = 0.0, y = 0.0 }";
const TWO: &str = "backlash = { x = \"two-tables\" }";

fn place(job: &str) -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(directory.path().join(name), text).unwrap();
    write("job.toml", job);
    write("x.csv", ERRORS);
    write("y.csv", ERRORS_Y);
    directory
}

fn read(at: &Path, name: &str) -> String {
    fs::read_to_string(at.join(name)).unwrap()
}

fn kit(job: &str) -> TempDir {
    let directory = place(job);
    let (status, _, said) = ended(directory.path(), "generate job.toml -o kit");
    assert_eq!(status, Some(0), "{said}");
    directory
}

#[test]
fn a_table_is_minus_the_deviation_and_cross_terms_are_told() {
    let directory = kit(&job(NONE, TWO));
    let at = directory.path();
    let rows = "0.000000 0.000000 -0.004000\n50.000000 -0.006000 -0.010000\n100.000000 -0.016000 -0.020000\n";
    assert_eq!(read(at, "kit/joint-0.comp"), rows);
    let manifest: Value = serde_json::from_str(&read(at, "kit/manifest.json")).unwrap();
    let omitted = &manifest["omitted"][0];
    assert_eq!(omitted["term"], "EYX");
    let reason =
        "the control has no tables for cross terms (COMP_FILE corrects its own joint only)";
    assert_eq!(omitted["reason"], reason);
    let left = &manifest["forecast"]["terms"]["EYX"];
    assert_eq!(left["before_um"], left["after_um"], "nothing corrects it");
    let (status, _, said) = ended(at, "verify job.toml --tables kit");
    assert_eq!(status, Some(0), "{said}");
}

#[test]
fn what_no_table_can_hold_is_refused_where_nothing_else_is_asked_for() {
    let keys = "terms = [\"EYX\"]\nbacklash = { x = \"mean\" }";
    let directory = place(&job(NONE, keys));
    let (status, _, said) = ended(directory.path(), "generate job.toml -o kit");
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("COMP_FILE corrects its own joint only"), "{said}");
}

/// The reversal that a policy leaves to BACKLASH stands in the columns, for a COMP_FILE switches BACKLASH off.
#[test]
fn curve_and_parameter_stands_in_the_columns() {
    let directory = kit(&job(NONE, "backlash = { x = \"curve-and-parameter\" }"));
    let rows = "0.000000 0.000000 -0.004000\n50.000000 -0.006000 -0.010000\n100.000000 -0.016000 -0.020000\n";
    assert_eq!(read(directory.path(), "kit/joint-0.comp"), rows);
    let checklist = read(directory.path(), "kit/checklist.md");
    assert!(checklist.contains("BACKLASH of [JOINT_0]"), "{checklist}");
}

/// BACKLASH 10 µm acted while measuring: the machine itself has 14 µm, of Y 10 µm that nobody measured.
#[test]
fn what_backlash_did_while_measuring_is_taken_over() {
    let measurement =
        "active_while_measuring = \"none\"\nactive_backlash_um = { x = 10.0, y = 0.0 }";
    let directory = kit(&job(measurement, TWO));
    let rows = "0.000000 0.000000 -0.014000\n50.000000 -0.006000 -0.020000\n100.000000 -0.016000 -0.030000\n";
    assert_eq!(read(directory.path(), "kit/joint-0.comp"), rows);
    let measurement = measurement.replace("y = 0.0", "y = 10.0");
    let directory = place(&job(&measurement, TWO));
    let (status, _, said) = ended(directory.path(), "generate job.toml -o kit");
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("`backlash` is not stated"), "{said}");
}

/// With the mean the reversal comes back, and the forecast says so.
#[test]
fn the_mean_leaves_the_reversal_that_backlash_took_off() {
    let measurement =
        "active_while_measuring = \"none\"\nactive_backlash_um = { x = 10.0, y = 0.0 }";
    let directory = kit(&job(measurement, "backlash = { x = \"mean\" }"));
    let manifest: Value =
        serde_json::from_str(&read(directory.path(), "kit/manifest.json")).unwrap();
    let after = manifest["forecast"]["terms"]["EXX"]["after_um"].as_f64().unwrap();
    assert!((after - 14.0).abs() < 1e-3, "{after}");
}

/// An ini file of a machine with the lines of a kit in it.
fn ini(lines: &str) -> String {
    let joint = |n: u32| {
        let section = format!("[JOINT_{n}]\n");
        let own = lines.split(&section).nth(1).unwrap_or("");
        let own = own.split('[').next().unwrap_or("");
        format!("{section}MIN_LIMIT = 0\nHOME_OFFSET = 0\n{own}")
    };
    format!(
        "[EMC]\nVERSION = 1.1\n[KINS]\nJOINTS = 2\n[TRAJ]\nLINEAR_UNITS = mm\n{}{}",
        joint(0),
        joint(1)
    )
}

/// The machine's files as they were copied, beside a job with its kit; `change` is what somebody did to them.
fn read_out(change: impl Fn(&str, String) -> String) -> (Option<i32>, String) {
    let directory = kit(&job(NONE, TWO));
    let at = directory.path();
    fs::create_dir(at.join("out")).unwrap();
    let write = |name: &str, text: String| {
        fs::write(at.join("out").join(name), change(name, text)).unwrap();
    };
    write("machine.ini", ini(&read(at, "kit/joints.ini")));
    // The lines of the kit beside it say nothing for the machine's own.
    for name in ["joints.ini", "joint-0.comp", "joint-1.comp"] {
        write(name, read(at, &format!("kit/{name}")));
    }
    let (status, out, said) = ended(at, "verify job.toml --tables out --explain");
    (status, out + &said)
}

#[test]
fn the_files_of_a_machine_are_judged_as_linuxcnc_reads_them() {
    let (status, said) = read_out(|_, text| text);
    assert_eq!(status, Some(0), "{said}");
    for (name, from, to, expected, words) in [
        ("machine.ini", "COMP_FILE_TYPE = 1", "COMP_FILE_TYPE = 0", 1, "EXX"),
        ("machine.ini", "COMP_FILE_TYPE = 1", "", 1, "EXX"),
        (
            "machine.ini",
            "MIN_LIMIT = 0",
            "HOME_LATCH_VEL = -5",
            1,
            "HOME_LATCH_VEL of [JOINT_0] is -5",
        ),
        (
            "machine.ini",
            "COMP_FILE = joint-1.comp",
            "COMP_FILE = other/joint-0.comp",
            2,
            "in different folders",
        ),
        (
            "machine.ini",
            "LINEAR_UNITS = mm",
            "LINEAR_UNITS = inch",
            1,
            "counts in inch, the job in mm",
        ),
        (
            "machine.ini",
            "HOME_OFFSET = 0",
            "HOME_OFFSET = 20",
            1,
            "HOME_OFFSET of [JOINT_0] is 20 mm",
        ),
        ("machine.ini", "COMP_FILE = joint-1.comp", "# none", 1, "EYY"),
        ("machine.ini", "COMP_FILE = joint-1.comp", "COMP_FILE = joint-0.comp", 1, "EYY"),
        ("machine.ini", "[JOINT_1]", "[JOINT_7]", 1, "the table of JOINT_7 belongs to a joint"),
        ("machine.ini", "MIN_LIMIT = 0", "BACKLASH = 0.010", 0, "pass"),
        ("machine.ini", "MIN_LIMIT", "#INCLUDE", 2, "includes another file"),
        ("joint-0.comp", "50.000000 -0.006000", "50.000000 0.006000", 1, "EXX"),
        ("joint-0.comp", "50.000000", "# 50\n50.000000", 2, "stops reading here without a word"),
    ] {
        let (status, said) = read_out(|own, text| match own == name {
            true => text.replace(from, to),
            false => text,
        });
        assert_eq!(status, Some(expected), "{to}\n{said}");
        assert!(said.contains(words), "{to}\n{said}");
    }
}

/// Half of the errors were corrected while measuring: new = old + residual.
#[test]
fn old_tables_are_part_of_the_new_ones() {
    let first = kit(&job(NONE, TWO));
    let at = first.path();
    fs::create_dir(at.join("out")).unwrap();
    let machine = ini(&read(at, "kit/joints.ini"));
    fs::write(at.join("out/machine.ini"), machine).unwrap();
    for name in ["joint-0.comp", "joint-1.comp"] {
        fs::copy(at.join("kit").join(name), at.join("out").join(name)).unwrap();
    }
    fs::write(at.join("job.toml"), job("active_while_measuring = \"out\"", TWO)).unwrap();
    let (status, _, said) = ended(at, "generate job.toml -o again");
    assert_eq!(status, Some(0), "{said}");
    let rows = "0.000000 0.000000 -0.008000\n50.000000 -0.012000 -0.020000\n100.000000 -0.032000 -0.040000\n";
    assert_eq!(read(at, "again/joint-0.comp"), rows);
}

/// A second measurement as the emulated control would give it; one without tables misses.
#[test]
fn a_second_measurement_is_judged() {
    let directory = kit(&job(NONE, TWO));
    let at = directory.path();
    let simulate = "simulate job.toml --errors --noise-um 0.1 --seed 3 --force";
    for (tables, expected) in [("--tables kit", "pass"), ("--without-tables", "fail")] {
        let (status, _, said) = ended(at, &format!("{simulate} {tables} -o after.csv"));
        assert_eq!(status, Some(0), "{said}");
        let measured: String = read(at, "after.csv")
            .lines()
            .filter(|line| !line.starts_with('#'))
            .map(|line| format!("{line}\n"))
            .collect();
        fs::write(at.join("after.csv"), measured).unwrap();
        let job = job(NONE, TWO).replace("max_deviation_um = 100", "max_deviation_um = 10");
        fs::write(at.join("job.toml"), job).unwrap();
        let (_, page, said) =
            ended(at, "verify job.toml --tables kit --after after.csv --format json");
        let page: Value = serde_json::from_str(&page).unwrap_or_else(|_| panic!("{said}"));
        assert_eq!(page["verdict"], expected, "{tables} {page:#}");
    }
}

/// Positions reached in place of values to add: another file, the same effect.
#[test]
fn a_profile_may_write_the_other_type() {
    let own = "schema = 1\nid = \"own\"\nname = \"own\"\nbased_on = \"linuxcnc\"\n[facts.columns]\n\
               value = \"reached\"\nevidence = \"manual\"\nsource = \"a shop that writes type 0\"\n";
    let directory = place(&job(NONE, TWO).replace("\"linuxcnc\"", "\"own.toml\""));
    let at = directory.path();
    fs::write(at.join("own.toml"), own).unwrap();
    let (status, _, said) = ended(at, "generate job.toml -o kit");
    assert_eq!(status, Some(0), "{said}");
    let rows = "0.000000 0.000000 0.004000\n50.000000 50.006000 50.010000\n100.000000 100.016000 100.020000\n";
    assert_eq!(read(at, "kit/joint-0.comp"), rows);
    assert!(read(at, "kit/joints.ini").contains("COMP_FILE_TYPE = 0"));
}

#[test]
fn a_table_has_up_to_256_rows() {
    let with = |spacing: &str| {
        job(NONE, TWO).replace("spacing_mm = 50\nid = \"0\"", &format!("{spacing}\nid = \"0\""))
    };
    kit(&with("points = 256"));
    let directory = place(&with("points = 257"));
    let (status, _, said) = ended(directory.path(), "generate job.toml -o kit");
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("257 points, more than the 256 of a COMP_FILE"), "{said}");
}

#[test]
fn the_interpreter_of_linuxcnc_takes_the_programs() {
    let axes = job(NONE, TWO).replace(
        "[acceptance]",
        "[machine.axes.z]\ntravel_mm = [-100, 0]\nreference_mm = 0\n[acceptance]",
    );
    let program = "[program]\nwhat = \"step-diagonal\"\nstart_mm = { x = 10, y = 10, z = -90 }\n\
                   size_mm = { x = 80, y = 80, z = 80 }\nsteps = 4\norder = \"XYZ\"\n";
    let directory = place(&(axes + program));
    let at = directory.path();
    let (status, _, said) = ended(at, "program job.toml -o programs");
    assert_eq!(status, Some(0), "{said}");
    let files: Vec<_> = fs::read_dir(at.join("programs")).unwrap().flatten().collect();
    let programs: Vec<_> =
        files.iter().filter(|f| f.path().extension().is_some_and(|e| e == "ngc")).collect();
    assert_eq!(programs.len(), 4);
    for file in programs {
        let run = Command::new("rs274").arg("-g").arg(file.path()).current_dir(at).output();
        let Ok(run) = run else {
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
