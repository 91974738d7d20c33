//! A kit on disk and the control started with it; the sign proof as its checklist tells it, read from the control.

use super::control::{LETTERS, Run, Setup, run};
use super::loops::{ACCELERATION_MM, Case, joints, sections};
use super::machine::{Machine, stands};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Calls the program in the folder of the visit and expects its exit status.
pub(crate) fn nonius(folder: &Path, words: &str, status: i32) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_nonius"))
        .current_dir(folder)
        .args(words.split(' '))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    assert_eq!(output.status.code(), Some(status), "nonius {words}\n{said}");
    said
}

/// What a control is started with: tables of a directory, none, or those of the sign proof.
#[derive(Clone, Copy)]
pub(crate) enum Tables<'a> {
    None,
    Kit(&'a str),
    /// Those of the sign proof, `true` with every sign turned.
    SignProof(&'a str, bool),
}

impl Tables<'_> {
    /// The lines of the joints and the tables.
    fn files(self, folder: &Path) -> ([String; 3], Vec<(String, Vec<u8>)>) {
        let (kit, prefix, turned) = match self {
            Tables::None => return Default::default(),
            Tables::Kit(kit) => (kit, "", false),
            Tables::SignProof(kit, turned) => (kit, "sign-", turned),
        };
        let read = |name: &str| fs::read_to_string(folder.join(kit).join(name)).ok();
        let names = ["joint-0.comp", "joint-1.comp", "joint-2.comp", "compensation.hal"];
        let table = |name: &str| {
            let name = format!("{prefix}{name}");
            let text = read(&name)?;
            let text = if turned { with_signs_turned(&text) } else { text };
            Some((name, text.into_bytes()))
        };
        let lines = read(&format!("{prefix}joints.ini")).unwrap();
        (sections(&lines), names.into_iter().filter_map(table).collect())
    }
}

/// A table of type 1 with both columns of values negated; a HAL file with the values of all curves.
fn with_signs_turned(text: &str) -> String {
    let negated = |word: &str| (-word.parse::<f64>().unwrap()).to_string();
    let line = |line: &str| {
        let words: Vec<&str> = line.split(' ').collect();
        match words[..] {
            ["setp", pin, value] if pin.contains(".y-val-") => {
                format!("setp {pin} {}\n", negated(value))
            }
            [position, up, down] if position.parse::<f64>().is_ok() => {
                format!("{position} {} {}\n", negated(up), negated(down))
            }
            _ => format!("{line}\n"),
        }
    };
    text.lines().map(line).collect()
}

/// The control with these tables, led through part programs.
pub(crate) fn drive(
    folder: &Path,
    machine: &Machine,
    tables: Tables<'_>,
    programs: Vec<String>,
) -> Run {
    let (joints, files) = tables.files(folder);
    run(&Setup {
        unit: "mm",
        travel: machine.travel,
        acceleration_mm: ACCELERATION_MM,
        joints,
        files,
        hal: String::new(),
        jog: None,
        programs,
    })
}

/// A sign proof of a manifest.
struct Proof<'a> {
    document: &'a Value,
    /// The joint that moves, and the one that is looked at.
    base: usize,
    output: usize,
}

impl Proof<'_> {
    fn of(document: &Value) -> Proof<'_> {
        let [output, base] = joints(document["term"].as_str().unwrap());
        Proof { document, base, output }
    }

    fn number(&self, key: &str) -> f64 {
        self.document[key].as_f64().unwrap()
    }

    fn places(&self) -> [f64; 2] {
        ["from_mm", "peak_mm"].map(|key| self.number(key))
    }

    /// To both places, moving the same way to both.
    fn program(&self) -> String {
        let [from, peak] = self.places();
        let (letter, back) = (LETTERS[self.base], from + (from - peak).signum() * 5.0);
        format!(
            "G21 G90 G0 {letter}{back}\nG1 F20000 {letter}{from}\nG4 P0.2\n{letter}{peak}\nG4 P0.2\n{letter}{from}\nG0 {letter}0\nM2\n"
        )
    }

    /// Reading at the second place less that at the first, µm.
    fn reading(&self, machine: &Machine, seen: &Run, program: usize) -> f64 {
        let places = stands(&seen.cycles[program], 150);
        let at = |mm: f64| {
            let is_there = |command: f64| (command - mm).abs() < 1e-6;
            let stand = places.iter().find(|stand| is_there(stand.command[self.base]));
            let stand = stand.unwrap();
            let error = machine.errors_um(stand.drive, stand.upwards)[self.output];
            (stand.drive[self.output] - stand.command[self.output]) * 1000.0 + error
        };
        let [from, peak] = self.places();
        at(peak) - at(from)
    }
}

/// The sign proofs of the kit show what its checklist says, and the opposite with the signs turned.
pub(crate) fn signs_are_proved(folder: &Path, machine: &Machine, terms: &[&str]) {
    let manifest = fs::read_to_string(folder.join("kit/manifest.json")).unwrap();
    let manifest: Value = serde_json::from_str(&manifest).unwrap();
    let documents = manifest["sign_proofs"].as_array().unwrap();
    let proofs: Vec<Proof<'_>> = documents.iter().map(Proof::of).collect();
    let proved: Vec<&str> = documents.iter().flat_map(|of| of["term"].as_str()).collect();
    assert_eq!(proved, terms);
    let readings = |tables| -> Vec<f64> {
        let seen = drive(folder, machine, tables, proofs.iter().map(Proof::program).collect());
        let each = proofs.iter().enumerate();
        each.map(|(program, proof)| proof.reading(machine, &seen, program)).collect()
    };
    let off = readings(Tables::None);
    for (turned, key) in [(false, "shows_um"), (true, "other_sign_um")] {
        let on = readings(Tables::SignProof("kit", turned));
        for ((proof, on), off) in proofs.iter().zip(on).zip(&off) {
            let (seen, told) = (on - off, proof.number(key));
            let term = &proof.document["term"];
            println!("sign proof {term}, turned: {turned}: {seen:.3} µm, checklist {told}");
            // The machine's own error changes a little over a move of 20 µm.
            assert!((seen - told).abs() < 0.01, "{key}: {seen} µm");
        }
    }
}

/// The sign proofs of a kit made by the program from the error table of a machine.
pub(crate) fn of_case(case: &Case, terms: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("job.toml", &case.job());
    write("errors.csv", &case.error_table());
    nonius(folder.path(), "generate job.toml -o kit", 0);
    signs_are_proved(folder.path(), &case.machine, terms);
}
