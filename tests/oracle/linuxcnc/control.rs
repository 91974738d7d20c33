//! LinuxCNC, a real control, without a machine: started on files of a kit, homed, led through a part program, every servo
//! cycle recorded. Stops by itself and leaves no process behind.

use crate::support::skipped;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Stdio};
use tempfile::TempDir;

pub(crate) const LETTERS: [&str; 3] = ["X", "Y", "Z"];

/// A servo cycle, s.
pub(crate) const CYCLE_S: f64 = 1e-3;

/// The unprivileged user that the control runs as where the test is root: it refuses to run as root.
const NOBODY: &str = "65534";

#[derive(Clone, Default)]
pub(crate) struct Setup<'a> {
    /// `mm` or `inch`.
    pub(crate) unit: &'a str,
    /// Travel of each joint, in that unit; homing is at 0, without a move.
    pub(crate) travel: [[f64; 2]; 3],
    /// Acceleration of the joints, mm/s². The reversal of a table is ramped at half of it.
    pub(crate) acceleration_mm: f64,
    /// What stands first in the section of each joint: the lines of the kit.
    pub(crate) joints: [String; 3],
    /// Files beside the configuration: name and bytes. One that ends in `.hal` is that of a kit, and is sourced.
    pub(crate) files: Vec<(String, Vec<u8>)>,
    /// More lines of the HAL file.
    pub(crate) hal: String,
    pub(crate) jog: Option<f64>,
    pub(crate) programs: Vec<String>,
}

/// One joint in one servo cycle, machine units.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Joint {
    /// Commanded position, as the part program says.
    pub(crate) command: f64,
    /// Commanded position of the drive, without the offset of homing.
    pub(crate) drive: f64,
    /// Commanded speed, in machine units each second.
    pub(crate) speed: f64,
    /// Offset of homing: what the drive is told is this much more.
    pub(crate) offset: f64,
    /// What the table says, before a change of direction is ramped.
    pub(crate) table: f64,
    /// What is added of that.
    pub(crate) added: f64,
}

pub(crate) type Cycle = [Joint; 3];

pub(crate) struct Run {
    /// Every servo cycle of jogging before homing.
    pub(crate) jog: Vec<Cycle>,
    /// Every servo cycle of each part program, in order.
    pub(crate) cycles: Vec<Vec<Cycle>>,
    pub(crate) messages: String,
}

/// The version of the installed control; where there is none, that is said and the test is to be skipped.
pub(crate) fn installed() -> Option<String> {
    let package = Command::new("dpkg-query")
        .args(["--show", "--showformat=${Version}", "linuxcnc-uspace"])
        .output();
    let version = package.ok().filter(|output| output.status.success());
    if version.is_none() {
        skipped(
            "LinuxCNC is not installed (apt-get install --no-install-recommends linuxcnc-uspace)",
        );
    }
    version.map(|output| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// On a busy computer a start can time out inside LinuxCNC, so that nothing is recorded, and what one of its programs
/// refuses can get lost on the way to the next: it is started so often, until every part program has moved a joint.
const STARTS: usize = 3;

/// Starts the control, runs the part programs and ends the control. One at a time on one computer.
pub(crate) fn run(setup: &Setup<'_>) -> Run {
    let cycles_of = |folder: &TempDir, number: usize| {
        let text = fs::read_to_string(folder.path().join(format!("cycles-{number}.txt")));
        cycles(&text.unwrap_or_default())
    };
    let programs = 0..setup.programs.len();
    let moves = |cycle: &Cycle| cycle.iter().any(|joint| joint.speed != 0.0);
    let is_recorded = |(folder, _): &(TempDir, String)| {
        programs.clone().all(|number| cycles_of(folder, number).iter().any(moves))
    };
    let (folder, log) =
        (1..STARTS).map(|_| started(setup)).find(is_recorded).unwrap_or_else(|| started(setup));
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap_or_default();
    let messages = read("messages.txt");
    let recorded = |number: usize| {
        let cycles = cycles_of(&folder, number);
        assert!(cycles.iter().any(moves), "no motion recorded\n{messages}\n{log}");
        cycles
    };
    Run {
        jog: cycles(&read("cycles-jog.txt")),
        cycles: programs.clone().map(recorded).collect(),
        messages,
    }
}

/// A control that says this and does not start: it must not run a part program.
pub(crate) fn is_refused(setup: &Setup<'_>, told: &str) {
    let mut logs = Vec::new();
    let mut start = || {
        let (folder, log) = started(setup);
        let is_refused = log.contains(told) && !folder.path().join("cycles-0.txt").exists();
        logs.push(log);
        is_refused
    };
    assert!((0..STARTS).any(|_| start()), "expected `{told}` and no part program in\n{logs:?}");
}

/// The folder in which the control ran, and what it printed.
fn started(setup: &Setup<'_>) -> (TempDir, String) {
    let folder = tempfile::Builder::new().prefix("linuxcnc-").tempdir().unwrap();
    lay_out(setup, folder.path());
    let log = start(folder.path());
    assert_eq!(processes_in(folder.path()), Vec::<String>::new(), "left");
    (folder, log)
}

fn lay_out(setup: &Setup<'_>, folder: &Path) {
    let write = |name: &str, bytes: &[u8]| fs::write(folder.join(name), bytes).unwrap();
    for (name, bytes) in &setup.files {
        write(name, bytes);
    }
    let hal = format!("{}{}", include_str!("machine.hal"), setup.hal);
    write("machine.hal", hal.as_bytes());
    write("drives.hal", drives(setup).as_bytes());
    write("machine.ini", configuration(setup).as_bytes());
    for (number, program) in setup.programs.iter().enumerate() {
        write(&format!("run-{number}.ngc"), program.as_bytes());
    }
    if let Some(distance) = setup.jog {
        write("jog.txt", distance.to_string().as_bytes());
    }
    write("ui.py", include_bytes!("ui.py"));
    let runs = fs::Permissions::from_mode(0o755);
    fs::set_permissions(folder.join("ui.py"), runs.clone()).unwrap();
    fs::set_permissions(folder, runs).unwrap();
}

/// The HAL file of the kit, and the joints that it does not correct: their drives and encoders as in a machine without it.
fn drives(setup: &Setup<'_>) -> String {
    let kit = setup.files.iter().find(|(name, _)| name.ends_with(".hal"));
    let corrections = kit.map_or("", |(_, bytes)| std::str::from_utf8(bytes).unwrap());
    let source = kit.map_or(String::new(), |(name, _)| format!("source {name}\n"));
    let own = (0..3).filter(|joint| !corrections.contains(&format!("joint.{joint}.motor-pos-cmd")));
    let nets = own.map(|joint| {
        format!(
            "net nonius-{joint}-drive joint.{joint}.motor-pos-cmd\n\
             net nonius-{joint}-encoder joint.{joint}.motor-pos-fb\n"
        )
    });
    source + &nets.collect::<String>()
}

fn configuration(setup: &Setup<'_>) -> String {
    let unit_mm = if setup.unit == "inch" { 25.4 } else { 1.0 };
    let (speed, acceleration) = (500.0 / unit_mm, setup.acceleration_mm / unit_mm);
    let mut ini = format!(
        "[EMC]\nVERSION = 1.1\nMACHINE = nonius\nDEBUG = 0\n\
         [DISPLAY]\nDISPLAY = ./ui.py\nCYCLE_TIME = 0.1\n\
         [TASK]\nTASK = milltask\nCYCLE_TIME = 0.005\n\
         [RS274NGC]\nPARAMETER_FILE = machine.var\n\
         [EMCMOT]\nEMCMOT = motmod\nCOMM_TIMEOUT = 4.0\nBASE_PERIOD = 0\nSERVO_PERIOD = 1000000\n\
         [EMCIO]\nEMCIO = io\nCYCLE_TIME = 0.1\n\
         [HAL]\nHALFILE = machine.hal\n\
         [KINS]\nKINEMATICS = trivkins\nJOINTS = 3\n\
         [TRAJ]\nCOORDINATES = X Y Z\nLINEAR_UNITS = {}\nANGULAR_UNITS = degree\n\
         DEFAULT_LINEAR_VELOCITY = {speed}\nMAX_LINEAR_VELOCITY = {}\n",
        setup.unit,
        2.0 * speed
    );
    for (joint, letter) in LETTERS.into_iter().enumerate() {
        let travel = &setup.travel[joint];
        let limits = format!(
            "MIN_LIMIT = {}\nMAX_LIMIT = {}\nMAX_VELOCITY = {speed}\nMAX_ACCELERATION = {acceleration}\n",
            travel[0], travel[1]
        );
        ini += &format!(
            "[AXIS_{letter}]\n{limits}[JOINT_{joint}]\n{}\nTYPE = LINEAR\n{limits}\
             HOME = 0\nHOME_OFFSET = 0\nHOME_SEQUENCE = 0\nFERROR = 1\nMIN_FERROR = 0.5\n",
            setup.joints[joint]
        );
    }
    ini
}

fn start(folder: &Path) -> String {
    // One at a time: the shared memory of the control is the computer's.
    let lock = fs::File::create(std::env::temp_dir().join("one-linuxcnc-at-a-time")).unwrap();
    lock.lock().unwrap();
    let root =
        fs::metadata("/proc/self").is_ok_and(|own| std::os::unix::fs::MetadataExt::uid(&own) == 0);
    // A minute more than any program here takes.
    let mut words = vec!["timeout", "--kill-after=10", "300"];
    if root {
        let whose = format!("{NOBODY}:{NOBODY}");
        let given = Command::new("chown").arg("-R").arg(whose).arg(folder).status();
        assert!(given.unwrap().success());
        words.extend(["setpriv", "--reuid", NOBODY, "--regid", NOBODY, "--clear-groups"]);
    }
    words.extend(["linuxcnc", "-r", "machine.ini"]);
    let output = Command::new(words[0])
        .args(&words[1..])
        .current_dir(folder)
        .env("HOME", folder)
        .env_remove("DISPLAY")
        .stdin(Stdio::null())
        .output()
        .unwrap();
    String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned()
}

fn processes_in(folder: &Path) -> Vec<String> {
    let all = fs::read_dir("/proc").unwrap().flatten();
    let here = all.filter(|process| {
        fs::read_link(process.path().join("cwd")).is_ok_and(|place| place.starts_with(folder))
    });
    here.map(|process| process.file_name().to_string_lossy().into_owned()).collect()
}

/// The lines of `halsampler -t`: number of the cycle, then six figures for each joint. Cycles may be missing before the first
/// move only: the recorder starts while the control waits.
fn cycles(text: &str) -> Vec<Cycle> {
    let numbered = |line: &str| {
        let figures: Vec<f64> = line.split(' ').flat_map(str::parse).collect();
        assert_eq!(figures.len(), 19, "{line}");
        figures
    };
    let lines: Vec<Vec<f64>> =
        text.lines().filter(|line| *line != "overrun").map(numbered).collect();
    let lost = |two: &[Vec<f64>]| (two[1][0] - two[0][0] - 1.0).abs() > 0.5;
    let from = lines.windows(2).rposition(lost).map_or(0, |last| last + 1);
    let joint = |of: &[f64]| Joint {
        command: of[0],
        drive: of[1] - of[2],
        offset: of[2],
        speed: of[3],
        table: of[4],
        added: of[5],
    };
    let cycle = |of: &Vec<f64>| [1, 7, 13].map(|from| joint(&of[from..from + 6]));
    let cycles: Vec<Cycle> = lines.iter().map(cycle).collect();
    let (waiting, recorded) = cycles.split_at(from);
    let rests = |cycle: &Cycle| cycle.iter().all(|joint| joint.speed == 0.0);
    assert!(waiting.iter().all(rests), "a cycle is missing");
    recorded.to_vec()
}
