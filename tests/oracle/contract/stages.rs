//! Three measured stages as one machine (ISO 230-2 runs, read where they lie, not part of this repository): their
//! reversals change along the axes, and they are short and steep, up to 8 µm on 1 mm.

use super::{Seen, check};
use crate::support::machine::{Errors, Machine, MachineAxis, Term};
use crate::support::{self, UNCORRECTED, in_parallel, job_of, shared};
use nonius::control::controller::{Profile, builtin};
use nonius::quantity::{Axis, Direction, ErrorTerm, Interpolation};
use std::path::Path;

/// Targets, mm, and the mean deviation of five runs there, µm, moving up and down.
type Stage = (Vec<f64>, [Vec<f64>; 2]);

fn stage(data: &Path, axis: Axis) -> Stage {
    let name = format!("iso230_2_ess_b02_{}.csv", axis.key());
    let text = std::fs::read_to_string(data.join(name)).unwrap();
    let rows = text.lines().filter(|line| !line.starts_with(['#', 'i']));
    let cells = |line: &str| line.split(',').map(|cell| cell.parse().unwrap()).collect();
    let rows: Vec<Vec<f64>> = rows.map(cells).collect();
    let mean = |first: usize| {
        let um = |row: &Vec<f64>| row[first..first + 5].iter().sum::<f64>() / 5.0 - row[1];
        rows.iter().map(|row| um(row) * 1000.0).collect()
    };
    (rows.iter().map(|row| row[1]).collect(), [mean(2), mean(7)])
}

/// The machine that has them, with points on the targets. A Fanuc control adds at most 7 × 100 × 0.1 µm from one
/// point to the next, less than the steepest stage asks for, so it has one more between any two.
fn machine(stages: &[Stage; 3], profile: &Profile, policy: &'static str) -> Machine {
    let unit_um = profile.detection_unit_required.value.then_some(0.1);
    let parts = if profile.id.starts_with("fanuc") { 2.0 } else { 1.0 };
    let (mut axes, mut terms, mut keys) = (Vec::new(), Vec::new(), Vec::new());
    let mut csv = String::from("axis,direction,position_mm,ex_um,ey_um,ez_um\n");
    for (axis, (mm, ways)) in Axis::ALL.into_iter().zip(stages) {
        let (low, high, spacing) = (mm[0], mm[mm.len() - 1], (mm[1] - mm[0]) / parts);
        let unit = unit_um.map(|um| format!("detection_unit_um = {um}"));
        let own = format!("spacing_mm = {spacing:?}\n{}", unit.unwrap_or_default());
        keys.push((axis.key(), [low, high], 0.0, own));
        for (way, um) in Direction::BOTH.iter().zip(ways) {
            for (x, um) in mm.iter().zip(um) {
                let cells =
                    Axis::ALL.map(|of| if of == axis { um.to_string() } else { String::new() });
                csv += &format!("{},{way},{x},{}\n", axis.key(), cells.join(","));
            }
        }
        let name = profile.axis_names.value[axis as usize].clone();
        let (names, reference, interpolated) = (vec![name], 0.0, false);
        axes.push(MachineAxis { low, high, reference, names, unit_um, interpolated });
        let [plus, minus] =
            ways.clone().map(|um| Some(Errors::new(mm.clone(), um, Interpolation::Linear)));
        let (term, homing) = (ErrorTerm { of: axis, along: axis }, Direction::Plus);
        terms.push(Term { term, directed: true, plus, minus, reference, homing });
    }
    let control = format!("controller = \"{}\"\nbacklash = \"{policy}\"", profile.id);
    let job = job_of(UNCORRECTED, &control, keys) + "[limits]\nmax_slope_um_per_mm = 20.0\n";
    Machine {
        axes,
        terms,
        policy: Some(policy),
        fit: "sample",
        kind: Interpolation::Linear,
        inch: false,
        replaces_backlash: support::replaces_backlash(profile),
        reserved: Vec::new(),
        job,
        csv,
        features: Vec::new(),
    }
}

#[test]
fn measured_stages_keep_the_contract() {
    let Some(data) = shared("iso230-2") else { return };
    let stages = Axis::ALL.map(|axis| stage(&data, axis));
    in_parallel(support::positioning_ids(), |id| {
        let profile = builtin::profile(id).unwrap();
        for policy in ["mean", "two-tables"] {
            let mut seen = Seen::default();
            check(&profile, &machine(&stages, &profile, policy), &mut seen);
            assert_eq!(seen.compensated, 3, "{id} {policy}");
        }
    });
}
