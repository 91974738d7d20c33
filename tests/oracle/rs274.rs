//! `nonius path` against the interpreter of LinuxCNC (`rs274 -g`), which prints the moves that it makes: feed length to
//! 2e-4 and the box of the feed moves to 3 µm, what its four decimals of an inch allow.
//!
//! Where `rs274` or the programs of the real collection are absent, a test says so and passes.

mod canonical;
mod own;
mod real;

use canonical::{Walked, walked};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::{Mutex, PoisonError};
use tempfile::TempDir;

/// Part of the length by which the two may differ.
const LENGTH_PART: f64 = 2e-4;
const BOX_MM: f64 = 0.003;
/// No machine has it: no program leaves it.
const TRAVEL_MM: f64 = 50_000.0;
const MM_PER_INCH: f64 = 25.4;

/// Zero of a coordinate system, G54 = 1 … G59.3 = 9, the same in both.
fn zero_mm(system: u32) -> [f64; 3] {
    [10.0 * f64::from(system), 20.0, 30.0]
}

fn tool_mm(number: u32) -> f64 {
    25.4 * f64::from(number)
}

/// A directory with job, error table, tool table and parameters of both.
struct Bench {
    directory: TempDir,
}

impl Bench {
    fn new() -> Bench {
        let bench = Bench { directory: tempfile::tempdir().unwrap() };
        let rows = ["x", "y", "z"]
            .map(|axis| format!("{axis},-{TRAVEL_MM},0,0,0\n{axis},{TRAVEL_MM},0,0,0\n"));
        let errors = format!("axis,position_mm,ex_um,ey_um,ez_um\n{}", rows.concat());
        bench.write("errors.csv", &errors);
        let tools: String =
            (1..=9).map(|n| format!("T{n} P{n} Z{:.6}\n", tool_mm(n) / MM_PER_INCH)).collect();
        bench.write("tool.tbl", &tools);
        bench
    }

    fn path(&self) -> &Path {
        self.directory.path()
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path().join(name), text).unwrap();
    }

    fn run(&self, program: &str, arguments: &[&str]) -> Output {
        Command::new(program)
            .args(arguments)
            .current_dir(self.path())
            .output()
            .expect("the program starts")
    }

    /// What `path` makes of a program, or what it says.
    fn ours(&self, program: &[u8], keys: &str) -> Result<Walked, String> {
        self.write("job.toml", &job(keys));
        fs::write(self.path().join("part.nc"), program).unwrap();
        let nonius = env!("CARGO_BIN_EXE_nonius");
        let arguments = ["path", "job.toml", "part.nc", "--format", "json"];
        let output = self.run(nonius, &arguments);
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into_owned());
        }
        let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let length_mm = found["length_mm"].as_f64().unwrap();
        let rows = self.run(nonius, &["path", "job.toml", "part.nc", "-o", "-"]);
        Ok(Walked { length_mm, reach_mm: box_of(&String::from_utf8(rows.stdout).unwrap()) })
    }

    /// What LinuxCNC makes of it, or what it says.
    fn theirs(&self, program: &str, inch: bool) -> Result<Walked, String> {
        // The tools of all that run at once lie in one place of the home directory.
        static ONE: Mutex<()> = Mutex::new(());
        let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
        self.write("theirs.ngc", &between_percents(program, inch));
        self.write("theirs.var", &parameters());
        let _ = fs::remove_file(self.path().join("out.txt"));
        let arguments = ["-g", "-v", "theirs.var", "-t", "tool.tbl", "theirs.ngc", "out.txt"];
        let output = self.run("rs274", &arguments);
        let calls = fs::read_to_string(self.path().join("out.txt")).unwrap_or_default();
        if output.status.success() && calls.contains("PROGRAM_END") {
            return Ok(walked(&calls));
        }
        let said = [output.stdout, output.stderr].concat();
        Err(String::from_utf8_lossy(&said).into_owned())
    }
}

fn job(keys: &str) -> String {
    let mut text = String::from("schema = 1\n[machine]\nname = \"M\"\n");
    for axis in ["x", "y", "z"] {
        let travel = format!("travel_mm = [-{TRAVEL_MM:?}, {TRAVEL_MM:?}]\nreference_mm = 0.0\n");
        let _ = write!(text, "[machine.axes.{axis}]\n{travel}");
    }
    text += "[measurement]\nerrors = \"errors.csv\"\nactive_while_measuring = \"none\"\n[path]\n";
    text += "sample_mm = 1000.0\nsecond_reference_mm = { x = 0.0, y = 0.0, z = 0.0 }\n";
    text += keys;
    let mut names: Vec<(String, u32)> = (1..=6).map(|n| (format!("G{}", 53 + n), n)).collect();
    names.extend((7..=9).map(|n| (format!("G59.{}", n - 6), n)));
    names.extend([("G500".to_string(), 1), ("G505".to_string(), 5)]); // as G54, G58
    for (name, system) in names {
        let [x, y, z] = zero_mm(system);
        let zero = format!("x_mm = {x:?}\ny_mm = {y:?}\nz_mm = {z:?}\n");
        let _ = write!(text, "\n[[path.offset]]\nsystem = \"{name}\"\n{zero}");
    }
    for number in 1..=9 {
        let length = tool_mm(number);
        let name = if number == 2 { "name = \"DRILL\"\n" } else { "" };
        let _ = write!(text, "[[path.tool]]\nnumber = {number}\n{name}length_mm = {length:?}\n");
    }
    text
}

/// LinuxCNC's parameters, in inches: the zeros, and the reference points at the machine's zero.
fn parameters() -> String {
    let mut text = String::new();
    let mut keys: Vec<u32> = (5161..=5169).chain(5181..=5189).chain(5210..=5220).collect();
    keys.extend((0..9).flat_map(|system| 5221 + 20 * system..=5230 + 20 * system));
    for key in keys {
        let (system, axis) = ((key.max(5220) - 5220) / 20, (key.max(5220) - 5220) % 20);
        let value = match axis {
            _ if key == 5220 => 1.0,
            1..=3 => zero_mm(system + 1)[axis as usize - 1] / MM_PER_INCH,
            _ => 0.0,
        };
        let _ = writeln!(text, "{key}\t{value:.9}");
    }
    text
}

/// The program with its unit before it and M2 behind it, which LinuxCNC asks for.
fn between_percents(program: &str, inch: bool) -> String {
    let mut parts = program.split('\n').map(|line| line.trim_end_matches('\r'));
    let mut lines: Vec<&str> = Vec::new();
    let mut begun = false;
    for line in &mut parts {
        if line.starts_with('%') {
            if std::mem::replace(&mut begun, true) {
                break;
            }
        } else {
            begun |= !line.trim().is_empty();
            lines.push(line);
        }
    }
    let unit = if inch { "G20" } else { "G21" };
    format!("{unit}\n{}\nM2\n", lines.join("\n"))
}

/// The box of the samples.
fn box_of(rows: &str) -> [[f64; 2]; 3] {
    let mut reach = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    for row in rows.lines().skip(1) {
        let mut cells = row.split(',').skip(2);
        for [least, most] in &mut reach {
            let mm: f64 = cells.next().unwrap().parse().unwrap();
            (*least, *most) = (least.min(mm), most.max(mm));
        }
    }
    reach
}

/// Whether both went the same way, else in words what they did.
fn compare(ours: &Walked, theirs: &Walked) -> Result<(), String> {
    let length = (ours.length_mm - theirs.length_mm).abs();
    let box_mm = (0..3).flat_map(|axis| [0, 1].map(|end| (axis, end)));
    let box_mm = box_mm
        .map(|(axis, end)| (ours.reach_mm[axis][end] - theirs.reach_mm[axis][end]).abs())
        .fold(0.0, f64::max);
    if length <= LENGTH_PART * theirs.length_mm && box_mm <= BOX_MM {
        return Ok(());
    }
    Err(format!(
        "length by {length:.4} mm, box by {box_mm:.4} mm\n  ours   {ours:?}\n  theirs {theirs:?}"
    ))
}

/// Whether `rs274` is installed.
fn is_installed() -> bool {
    let found = Command::new("rs274").arg("-?").output().is_ok();
    if !found {
        eprintln!("skipped: `rs274` (LinuxCNC) is not installed");
    }
    found
}

/// Unit and language of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unit {
    Mm,
    Inch,
    Siemens,
}

/// What came of the comparison of a program.
fn outcome(
    bench: &Bench,
    (ours, theirs): (&[u8], &str),
    unit: Unit,
    keys: &str,
) -> Result<(), String> {
    let (inch, language) = match unit {
        Unit::Mm => ("mm", "iso"),
        Unit::Inch => ("inch", "iso"),
        Unit::Siemens => ("mm", "siemens"),
    };
    let keys = format!("program_unit = \"{inch}\"\nlanguage = \"{language}\"\n{keys}");
    let ours = bench.ours(ours, &keys).map_err(|said| format!("refused: {said}"))?;
    let theirs = bench.theirs(theirs, unit == Unit::Inch);
    compare(&ours, &theirs.map_err(|said| format!("LinuxCNC: {said}"))?)
}

/// Real programs, each with what is expected of it.
#[test]
fn real_programs_go_where_linuxcnc_goes() {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/real/gcode");
    if !directory.is_dir() {
        eprintln!("skipped: the collection of real programs is not here");
        return;
    }
    if !is_installed() {
        return;
    }
    let bench = Bench::new();
    let mut unexpected = Vec::new();
    for (name, unit, expected) in real::PROGRAMS {
        let bytes = fs::read(directory.join(name)).unwrap();
        let mut theirs = String::from_utf8_lossy(&bytes).into_owned();
        for (here, there) in real::DIALECT {
            theirs = theirs.replace(here, there);
        }
        let found = outcome(&bench, (&bytes, &theirs), *unit, real::KEYS);
        if !real::is_so(*expected, &found) {
            unexpected.push(format!("{name}: expected {expected:?}, found {found:?}"));
        }
    }
    let files = fs::read_dir(&directory).unwrap().count();
    assert_eq!(real::PROGRAMS.len() + 1, files, "one line for each file beside PROVENANCE.tsv");
    assert!(unexpected.is_empty(), "{}", unexpected.join("\n"));
}

/// Programs of our own: cycles, subprograms, offsets, variables.
#[test]
fn own_programs_go_where_linuxcnc_goes() {
    if !is_installed() {
        return;
    }
    let bench = Bench::new();
    let mut different = Vec::new();
    for (name, program) in own::PROGRAMS {
        if let Err(words) = outcome(&bench, (program.as_bytes(), program), Unit::Mm, "") {
            different.push(format!("{name}: {words}"));
        }
    }
    for (name, program, theirs) in own::SIEMENS {
        if let Err(words) = outcome(&bench, (program.as_bytes(), theirs), Unit::Siemens, "") {
            different.push(format!("{name}: {words}"));
        }
    }
    assert!(different.is_empty(), "{}", different.join("\n"));
}
