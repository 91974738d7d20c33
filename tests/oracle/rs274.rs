//! `nonius path` against the interpreter of LinuxCNC (`rs274 -g`), which prints the moves that it makes: feed length to
//! 2e-4 and the box of the feed moves to 3 µm, what its four decimals of an inch allow.
//!
//! Where `rs274` or the programs of the real collection are absent, a test says so and passes.

mod canonical;
mod own;
mod real;

use crate::support::{Visit, is_installed, number, shared};
use canonical::{Walked, walked};
use std::fs;
use std::process::Command;
use std::sync::{Mutex, PoisonError};

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

struct Bench(Visit);

impl Bench {
    fn new() -> Bench {
        let row = |axis: &str| format!("{axis},-{TRAVEL_MM},0,0,0\n{axis},{TRAVEL_MM},0,0,0\n");
        let rows = ["x", "y", "z"].map(row).concat();
        let tool = |n| format!("T{n} P{n} Z{:.6}\n", tool_mm(n) / MM_PER_INCH);
        let visit = Visit::new();
        visit.put("errors.csv", format!("axis,position_mm,ex_um,ey_um,ez_um\n{rows}"));
        visit.put("tool.tbl", (1..=9).map(tool).collect::<String>());
        Bench(visit)
    }

    fn ours(&self, program: &[u8], keys: &str) -> Result<Walked, String> {
        self.0.put("job.toml", job(keys)).put("part.nc", program);
        let ran = self.0.run("path job.toml part.nc --format json");
        if ran.status != Some(0) {
            return Err(ran.err);
        }
        let mut walked = Walked::nowhere();
        walked.length_mm = number(&ran.json()["length_mm"]);
        for row in self.0.run("path job.toml part.nc -o -").out.lines().skip(1) {
            let cells: Vec<&str> = row.split(',').collect();
            walked.reach([2, 3, 4].map(|cell| cells[cell].parse().unwrap()));
        }
        Ok(walked)
    }

    fn theirs(&self, program: &str, inch: bool) -> Result<Walked, String> {
        // The tools of all that run at once lie in one place of the home directory.
        static ONE: Mutex<()> = Mutex::new(());
        let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
        self.0.put("theirs.ngc", between_percents(program, inch)).put("theirs.var", parameters());
        let _ = fs::remove_file(self.0.at("out.txt"));
        let arguments = ["-g", "-v", "theirs.var", "-t", "tool.tbl", "theirs.ngc", "out.txt"];
        let mut rs274 = Command::new("rs274");
        // Its tools lie in the home directory, where a LinuxCNC that runs beside has its own.
        rs274.args(arguments).current_dir(self.0.folder()).env("HOME", self.0.folder());
        let output = rs274.output().expect("the program starts");
        let calls = fs::read_to_string(self.0.at("out.txt")).unwrap_or_default();
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
        text += &format!("[machine.axes.{axis}]\n{travel}");
    }
    text += "[measurement]\nerrors = \"errors.csv\"\nactive_while_measuring = \"none\"\n[path]\n";
    text += "sample_mm = 1000.0\nsecond_reference_mm = { x = 0.0, y = 0.0, z = 0.0 }\n";
    text += keys;
    let plain = (1..=6).map(|n| (format!("G{}", 53 + n), n));
    let more = (7..=9).map(|n| (format!("G59.{}", n - 6), n));
    let siemens = [("G500".to_string(), 1), ("G505".to_string(), 5)]; // as G54, G58
    for (name, system) in plain.chain(more).chain(siemens) {
        let [x, y, z] = zero_mm(system);
        let zero = format!("x_mm = {x:?}\ny_mm = {y:?}\nz_mm = {z:?}\n");
        text += &format!("\n[[path.offset]]\nsystem = \"{name}\"\n{zero}");
    }
    for number in 1..=9 {
        let length = tool_mm(number);
        let name = if number == 2 { "name = \"DRILL\"\n" } else { "" };
        text += &format!("[[path.tool]]\nnumber = {number}\n{name}length_mm = {length:?}\n");
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
        text += &format!("{key}\t{value:.9}\n");
    }
    text
}

/// The program with its unit before it and M2 behind it, which LinuxCNC asks for.
fn between_percents(program: &str, inch: bool) -> String {
    let mut lines: Vec<&str> = Vec::new();
    let mut begun = false;
    for line in program.split('\n').map(|line| line.trim_end_matches('\r')) {
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

/// Whether both went the same way, else in words what they did.
fn compare(ours: &Walked, theirs: &Walked) -> Result<(), String> {
    let length = (ours.length_mm - theirs.length_mm).abs();
    let ends = ours.reach_mm.iter().flatten().zip(theirs.reach_mm.iter().flatten());
    let box_mm = ends.map(|(our, their)| (our - their).abs()).fold(0.0, f64::max);
    if length <= 2e-4 * theirs.length_mm && box_mm <= 0.003 {
        return Ok(());
    }
    let both = format!("  ours   {ours:?}\n  theirs {theirs:?}");
    Err(format!("length by {length:.4} mm, box by {box_mm:.4} mm\n{both}"))
}

type Unit = (&'static str, &'static str);
const MM: Unit = ("mm", "iso");
const INCH: Unit = ("inch", "iso");
const SIEMENS: Unit = ("mm", "siemens");

fn outcome(bench: &Bench, both: (&[u8], &str), unit: Unit, keys: &str) -> Result<(), String> {
    let keys = format!("program_unit = \"{}\"\nlanguage = \"{}\"\n{keys}", unit.0, unit.1);
    let ours = bench.ours(both.0, &keys).map_err(|said| format!("refused: {said}"))?;
    let theirs = bench.theirs(both.1, unit == INCH);
    compare(&ours, &theirs.map_err(|said| format!("LinuxCNC: {said}"))?)
}

#[test]
fn real_programs_go_where_linuxcnc_goes() {
    let Some(directory) = shared("real/gcode") else { return };
    if !is_installed("rs274") {
        return;
    }
    let bench = Bench::new();
    let mut unexpected = Vec::new();
    let names = fs::read_dir(&directory).unwrap().map(|file| file.unwrap().file_name());
    let names: Vec<String> = names.map(|name| name.into_string().unwrap()).collect();
    assert_eq!(names.len(), 51, "fifty programs and PROVENANCE.tsv");
    for name in names.iter().filter(|name| !name.ends_with(".tsv")) {
        let bytes = fs::read(directory.join(name)).unwrap();
        let mut theirs = String::from_utf8_lossy(&bytes).into_owned();
        for (here, there) in real::DIALECT {
            theirs = theirs.replace(here, there);
        }
        let found = outcome(&bench, (&bytes, &theirs), real::unit(name), real::KEYS);
        if !real::is_expected(name, &found) {
            unexpected.push(format!("{name}: {found:?}"));
        }
    }
    assert!(unexpected.is_empty(), "{}", unexpected.join("\n"));
}

#[test]
fn own_programs_go_where_linuxcnc_goes() {
    if !is_installed("rs274") {
        return;
    }
    let bench = Bench::new();
    let iso = own::PROGRAMS.lines().map(|row| (row, MM));
    let siemens = own::SIEMENS.lines().map(|row| (row, SIEMENS));
    let (mut different, mut count) = (Vec::new(), 0);
    for (row, unit) in iso.chain(siemens) {
        let cells: Vec<String> = row.split(" | ").map(|cell| cell.replace('¶', "\n")).collect();
        let (program, theirs) = (cells[1].as_bytes(), &cells[cells.len() - 1]);
        if let Err(words) = outcome(&bench, (program, theirs), unit, "") {
            different.push(format!("{}: {words}", cells[0]));
        }
        count += 1;
    }
    assert_eq!(count, 15);
    assert!(different.is_empty(), "{}", different.join("\n"));
}
