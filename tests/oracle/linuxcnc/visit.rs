//! A whole visit on a real control: measuring program → control → a simulated laser on the moving machine → `separate` →
//! `generate` → the control with the kit → measured again → `verify --after`; then the update and the rollback.

use super::control::Run;
use super::loops::path;
use super::machine::{Machine, Stand, stands};
use super::proof::{Tables, drive, signs_are_proved};
use crate::support::{DIAGONALS, Visit};

/// What a laser shows on the moving machine: `readings.csv` with its last column, the displacement of the mirror along the
/// diagonal, mm, filled in from what the control did in one program for each diagonal.
fn filled(machine: &Machine, positions: &str, readings: &str, seen: &Run) -> String {
    let rows: Vec<Vec<&str>> =
        positions.lines().skip(1).map(|row| row.split(',').collect()).collect();
    // The point that carries the mirror, mm.
    let reached = |stand: &Stand| {
        let errors = machine.errors_um(stand.drive, stand.upwards);
        [0, 1, 2].map(|axis| stand.drive[axis] + errors[axis] / 1000.0)
    };
    let mut values = Vec::new();
    for (diagonal, cycles) in DIAGONALS.iter().zip(&seen.cycles) {
        let own = rows.iter().filter(|row| row[0] == *diagonal);
        let own: Vec<[f64; 3]> =
            own.map(|row| [6, 7, 8].map(|column| row[column].parse().unwrap())).collect();
        let reached: Vec<[f64; 3]> = at(&own, &stands(cycles)).iter().map(reached).collect();
        values.extend(displacements(&own, &reached));
    }
    let (header, lines) = readings.split_once('\n').unwrap();
    assert_eq!(lines.lines().count(), values.len());
    let rows = lines.lines().zip(&values).map(|(line, value)| format!("{line}{value:.7}\n"));
    format!("{header}\n{}", rows.collect::<String>())
}

/// The standstills at the places of the readings, in their order; two readings of one place in a row are of one standstill.
fn at(readings: &[[f64; 3]], stands: &[Stand]) -> Vec<Stand> {
    let mut left = stands;
    let is_at = |stand: &Stand, place: &[f64; 3]| {
        let axes = stand.command.iter().zip(place);
        axes.into_iter().all(|(is, should)| (is - should).abs() < 1e-4)
    };
    let mut next = |place: &[f64; 3]| {
        let found = left.iter().position(|stand| is_at(stand, place));
        left = &left[found.unwrap_or_else(|| panic!("no standstill at {place:?}"))..];
        left[0]
    };
    readings.iter().map(&mut next).collect()
}

/// How far each place lies along the line from the first place to the farthest one, from the first one, mm.
fn displacements(nominal: &[[f64; 3]], reached: &[[f64; 3]]) -> Vec<f64> {
    let from =
        |places: &[[f64; 3]], n: usize| [0, 1, 2].map(|axis| places[n][axis] - places[0][axis]);
    let length = |of: [f64; 3]| of.iter().map(|part| part * part).sum::<f64>().sqrt();
    let all = 0..nominal.len();
    let ways = all.clone().map(|n| from(nominal, n));
    let far = ways.max_by(|a, b| length(*a).total_cmp(&length(*b))).unwrap();
    let along = |of: [f64; 3]| of.iter().zip(&far).map(|(a, b)| a * b).sum::<f64>() / length(far);
    all.map(|n| along(from(reached, n))).collect()
}

fn job(machine: &Machine, readings: &str, active: &str) -> String {
    let measured = format!(
        "readings = \"{readings}\"\nactive_while_measuring = \"{active}\"\n\
         uncertainty = {{ angle_urad = 0, setup_ppm = 0, tilt_arcsec = 0, laser_ppm = 0, beam_mrad = 0 }}\n\
         [measurement.step_diagonal]\nstart_mm = {{ x = 10.0, y = 10.0, z = -190.0 }}\n\
         size_mm = {{ x = 380.0, y = 280.0, z = 180.0 }}\nsteps = 5\norder = \"XYZ\"\nsetup = \"assume-perfect\"\noverrun = false\n\
         [program]\nwhat = \"step-diagonal\"\ndwell_s = 0.2\nfeed_mm_per_min = 30000\nalignment_pass = false\noverrun_mm = 0"
    );
    let control = "controller = \"linuxcnc\"\ncontrol_unit = \"mm\"\nbacklash = \"two-tables\"\nterms = [\"EXX\", \"EYY\", \"EZZ\"]";
    let job = machine.job(&measured, control, [38.0, 28.0, 18.0]);
    job + "[acceptance]\nmax_deviation_um = 2.0\n"
}

pub(crate) fn visit(machine: &Machine) -> String {
    let visit = Visit::new();
    let measure = |tables| {
        let programs = DIAGONALS.map(|diagonal| visit.read(&format!("run/NONIUS_{diagonal}.ngc")));
        let seen = drive(&visit, machine, tables, programs.to_vec());
        let [positions, readings] =
            ["positions", "readings"].map(|name| visit.read(&format!("run/{name}.csv")));
        filled(machine, &positions, &readings, &seen)
    };
    visit.put("job.toml", job(machine, "readings.csv", "none"));
    visit.yes("program job.toml -o run");
    visit.put("readings.csv", measure(Tables::None));
    visit.yes("separate job.toml");
    visit.yes("generate job.toml -o kit");
    signs_are_proved(&visit, machine, &["EXX"]);
    visit.put("after.csv", measure(Tables::Kit("kit")));
    visit.put("after.toml", job(machine, "after.csv", "kit"));
    let said = visit.run("verify job.toml --tables kit --after after.toml").ends(0).all();
    updated_and_rolled_back(&visit, machine);
    said
}

/// Places of a diagonal where the machine stands, up and down.
const STOPS: usize = 6;

/// New tables from the second measurement leave less than the first ones; after the rollback the machine is as it was.
fn updated_and_rolled_back(visit: &Visit, machine: &Machine) {
    visit.yes("generate after.toml -o update");
    let left = |tables| {
        let seen = drive(visit, machine, tables, vec![path(machine, STOPS, 1.0)]);
        let of = |stand: &Stand| {
            let errors = machine.errors_um(stand.drive, stand.upwards);
            let axis = |axis: usize| {
                ((stand.drive[axis] - stand.command[axis]) * 1000.0 + errors[axis]).abs()
            };
            [0, 1, 2].map(axis).into_iter().fold(0.0, f64::max)
        };
        let stands = stands(&seen.cycles[0]);
        assert!(stands.len() >= 2 * STOPS - 1, "{stands:?}");
        stands.iter().map(of).fold(0.0, f64::max)
    };
    let [none, kit, update, back] =
        [Tables::None, Tables::Kit("kit"), Tables::Kit("update"), Tables::Kit("kit")].map(left);
    println!(
        "largest error in the volume: {none:.3} µm, kit {kit:.3}, update {update:.3}, rolled back to the kit {back:.3}"
    );
    assert!(kit < none && update <= kit + 0.1 && (back - kit).abs() < 0.002);
}
