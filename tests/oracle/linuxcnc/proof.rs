//! A kit on disk and the control started with it; the sign proof as its checklist tells it, read from the control.

use super::control::{LETTERS, Run, Setup, run};
use super::loops::{ACCELERATION_MM, joints, sections};
use super::machine::{Machine, stands};
use crate::support::{Visit, number};
use serde_json::Value;

/// What a control is started with: tables of a directory, none, or those of the sign proof.
#[derive(Clone, Copy)]
pub(crate) enum Tables<'a> {
    None,
    Kit(&'a str),
    /// Those of the sign proof, `true` with every sign turned.
    SignProof(&'a str, bool),
}

impl Tables<'_> {
    fn files(self, visit: &Visit) -> ([String; 3], Vec<(String, Vec<u8>)>) {
        let (kit, prefix, turned) = match self {
            Tables::None => return Default::default(),
            Tables::Kit(kit) => (kit, "", false),
            Tables::SignProof(kit, turned) => (kit, "sign-", turned),
        };
        let names = ["joint-0.comp", "joint-1.comp", "joint-2.comp", "compensation.hal"];
        let table = |name: &str| {
            let (name, path) = (format!("{prefix}{name}"), format!("{kit}/{prefix}{name}"));
            let text = visit.has(&path).then(|| visit.read(&path))?;
            let text = if turned { with_signs_turned(&text) } else { text };
            Some((name, text.into_bytes()))
        };
        let lines = visit.read(&format!("{kit}/{prefix}joints.ini"));
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

pub(crate) fn drive(
    visit: &Visit,
    machine: &Machine,
    tables: Tables<'_>,
    programs: Vec<String>,
) -> Run {
    let (joints, files) = tables.files(visit);
    let (unit, travel, acceleration_mm) = ("mm", machine.travel, ACCELERATION_MM);
    run(&Setup { unit, travel, acceleration_mm, joints, files, programs, ..Setup::default() })
}

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

    fn places(&self) -> [f64; 2] {
        ["from_mm", "peak_mm"].map(|key| number(&self.document[key]))
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
        let places = stands(&seen.cycles[program]);
        let at = |mm: f64| {
            let is_there = |command: f64| (command - mm).abs() < 1e-6;
            let stand = places.iter().find(|stand| is_there(stand.command[self.base])).unwrap();
            let error = machine.errors_um(stand.drive, stand.upwards)[self.output];
            (stand.drive[self.output] - stand.command[self.output]) * 1000.0 + error
        };
        let [from, peak] = self.places();
        at(peak) - at(from)
    }
}

/// The sign proofs of the kit show what its checklist says, and the opposite with the signs turned.
pub(crate) fn signs_are_proved(visit: &Visit, machine: &Machine, terms: &[&str]) {
    let manifest = visit.document("kit/manifest.json");
    let documents = manifest["sign_proofs"].as_array().unwrap();
    let proofs: Vec<Proof<'_>> = documents.iter().map(Proof::of).collect();
    let proved: Vec<&str> = documents.iter().flat_map(|of| of["term"].as_str()).collect();
    assert_eq!(proved, terms);
    let readings = |tables| -> Vec<f64> {
        let seen = drive(visit, machine, tables, proofs.iter().map(Proof::program).collect());
        let each = proofs.iter().enumerate();
        each.map(|(program, proof)| proof.reading(machine, &seen, program)).collect()
    };
    let off = readings(Tables::None);
    for (turned, key) in [(false, "shows_um"), (true, "other_sign_um")] {
        let on = readings(Tables::SignProof("kit", turned));
        for ((proof, on), off) in proofs.iter().zip(on).zip(&off) {
            let (seen, told) = (on - off, number(&proof.document[key]));
            let term = &proof.document["term"];
            println!("sign proof {term}, turned: {turned}: {seen:.3} µm, checklist {told}");
            // The machine's own error changes a little over a move of 20 µm.
            assert!((seen - told).abs() < 0.01, "{key}: {seen} µm");
        }
    }
}
