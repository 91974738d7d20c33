//! Laws of the rehearsal: what `simulate` predicts is what the test's own arithmetic reads on the
//! same machine, and what `separate` takes apart again.
use crate::support::diagonals::{Machine, box_of, measurement, mm, seeded, volume};
use crate::support::{self, error_table, shown};
use nonius::inputs::error_table::{self as table, Kind};
use nonius::inputs::findings::Remark;
use nonius::inputs::job::{Frame, SetUp};
use nonius::kit::simulate::{
    Noise, Rehearsal, SIMULATED, SimulatedMachine, Simulation, Wishes, readings, rehearsed,
    single_axes, write,
};
use nonius::kit::{Inputs, Loaded, generate};
use nonius::quantity::{Axis, Diagonal, ErrorTerm, Millimetres, Pass, PathKind, PerAxis};
use proptest::prelude::*;

/// Readings are written with nine decimals.
const FILE_DIGITS_UM: f64 = 1e-9;
/// The test's own sums over travels of two metres.
const DUST_UM: f64 = 1e-8;

/// Job and error table of a machine, in both directions where it loses motion; `back`: reverse passes, after an overrun?
fn inputs(machine: &Machine, back: Option<bool>) -> Inputs {
    let volume = &machine.volume;
    let axes = Axis::ALL.map(|axis| {
        let low = volume.start[axis].mm();
        let travel = [low, low + volume.size[axis].mm()];
        (axis.key(), travel, low, format!("points = {}", volume.steps + 1))
    });
    let is_directed = machine.lost_um != PerAxis::default();
    let policy = if is_directed { "backlash = \"two-tables\"" } else { "" };
    let compensation = format!("controller = \"generic\"\n{policy}");
    let mut job = support::job_of(support::UNCORRECTED, &compensation, axes);
    let [start, size] = [volume.start, volume.size].map(|places| {
        Axis::ALL.map(|axis| format!("{} = {:?}", axis.key(), places[axis].mm())).join(", ")
    });
    job += &format!(
        "[program]\nwhat = \"step-diagonal\"\nstart_mm = {{ {start} }}\nsize_mm = {{ {size} }}\nsteps = {}\norder = \"{}\"\nbidirectional = {}\n",
        volume.steps,
        volume.order.map(|axis| axis.letter().to_string()).concat(),
        back.is_some()
    );
    if let Some(overrun) = back {
        job += if overrun { "overrun_mm = 2.0\n" } else { "overrun_mm = 0.0\n" };
    }
    let errors = machine.error_table(is_directed, 12, None, |_, _, _, um| Some(um));
    support::inputs(&job, &errors)
}

fn simulate(inputs: &Inputs, loaded: Option<&Loaded<'_>>, wishes: Wishes) -> Simulation {
    let machine = shown(SimulatedMachine::new(inputs, loaded, 0.0));
    let rehearsal = Rehearsal::of(inputs, wishes).unwrap();
    shown(readings(&machine, &rehearsal))
}

fn any_machine() -> impl Strategy<Value = Machine> {
    let edge = || 200u32..2000;
    let orders = prop::sample::select(vec![[0, 1, 2], [1, 0, 2], [2, 0, 1], [2, 1, 0]]);
    let box_ = (edge(), edge(), edge(), -1000i32..1000, orders, 2usize..16);
    (box_, any::<u64>()).prop_map(|((x, y, z, start, order, steps), seed)| {
        let mut volume = volume([f64::from(x), f64::from(y), f64::from(z)], steps);
        let start = f64::from(start);
        volume.start = mm(start, start / 4.0, -start);
        volume.order = order.map(|index: usize| Axis::ALL[index]);
        Machine::random(&volume, &mut seeded(seed))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(support::published::short_or(16, 64)))]

    #[test]
    fn the_prediction_is_what_the_test_reads_on_the_same_machine(mut machine in any_machine(), directed: bool, overrun: bool) {
        if directed {
            machine.lost_um = PerAxis { x: -8.0, y: 5.0, z: -3.0 };
        }
        let found = simulate(&inputs(&machine, Some(overrun)), None, Wishes::default());
        for run in &found.runs {
            let back = (run.pass == Pass::Reverse).then_some(overrun);
            let wanted = &machine.readings(back)[run.diagonal];
            prop_assert_eq!(run.deviations.len(), wanted.len());
            for (node, (found, wanted)) in run.deviations.iter().zip(wanted).enumerate() {
                let off = (found.um() - wanted).abs();
                prop_assert!(off <= DUST_UM, "{} {:?} node {node}: off by {off}", run.diagonal, run.pass);
            }
        }
        prop_assert_eq!(found.runs.len(), 8);
    }

    #[test]
    fn tables_of_the_machine_leave_nothing(mut machine in any_machine(), directed: bool) {
        if directed {
            machine.lost_um = PerAxis { x: -8.0, y: -5.0, z: -3.0 };
        }
        // Points on the measured positions: steps that are whole millimetres.
        for axis in Axis::ALL {
            let step = (machine.volume.step_mm(axis)).round().max(1.0);
            machine.volume.size[axis] = Millimetres::new(step * machine.volume.steps_f64());
        }
        let inputs = inputs(&machine, Some(true));
        let kit = shown(generate(&inputs));
        let loaded = shown(rehearsed(&inputs, &kit.files, None));
        let after = simulate(&inputs, Some(&loaded), Wishes::default());
        for run in &after.runs {
            for left in &run.deviations {
                // A table of the generic control has six decimals of a millimetre.
                prop_assert!(left.um().abs() < 6e-6, "{} {:?}: {left:?}", run.diagonal, run.pass);
            }
        }
    }
}

fn one_machine() -> Machine {
    Machine::random(&box_of(30), &mut seeded(7))
}

fn plain_inputs() -> Inputs {
    inputs(&one_machine(), None)
}

fn noisy(runs: u32, seed: u64, both_directions: bool) -> Wishes {
    let noise = Noise { um: 0.4, seed };
    Wishes { runs: Some(runs), both_directions, noise, ..Wishes::default() }
}

#[test]
fn noise_hangs_on_its_seed_alone_has_the_stated_size_and_leaves_the_first_reading_zero() {
    let inputs = plain_inputs();
    let three = simulate(&inputs, None, noisy(3, 5, false));
    assert_eq!(three.runs, simulate(&inputs, None, noisy(3, 5, false)).runs);
    let one = simulate(&inputs, None, noisy(1, 5, true));
    for run in one.runs.iter().filter(|run| run.pass == Pass::Forward) {
        assert!(three.runs.contains(run), "{} run 1", run.diagonal);
    }
    let other = simulate(&inputs, None, noisy(3, 6, false));
    assert_ne!(three.runs, other.runs);
    let exact = simulate(&inputs, None, Wishes::default());
    let found = simulate(&inputs, None, noisy(20, 3, false));
    let (mut sum, mut count) = (0.0, 0.0);
    for run in &found.runs {
        let clean = exact.runs.iter().find(|r| r.diagonal == run.diagonal).unwrap();
        if run.number == 1 {
            assert!(run.deviations[0].um().abs() < FILE_DIGITS_UM);
        }
        // Differences of neighbours know nothing of the zero: twice the variance.
        let off = run.deviations.iter().zip(&clean.deviations).map(|(a, b)| a.um() - b.um());
        for pair in off.collect::<Vec<f64>>().windows(2) {
            sum += (pair[1] - pair[0]).powi(2) / 2.0;
            count += 1.0;
        }
    }
    let sigma = f64::sqrt(sum / count);
    assert!((sigma - 0.4).abs() < 0.01, "{sigma} of {count} differences");
}

#[test]
fn the_file_reads_back_to_the_same_runs_and_says_what_it_is() {
    let (inputs, wishes) = (plain_inputs(), noisy(2, 9, true));
    let rehearsal = Rehearsal::of(&inputs, wishes).unwrap();
    let found = simulate(&inputs, None, wishes);
    let text = write(&found, &rehearsal, &[format!("note: {SIMULATED}: a test")]);
    let given = measurement(&box_of(30), SetUp::Solve, Frame::XPrimary);
    let read = support::readings(&text, &given).unwrap_or_else(|said| panic!("{said}"));
    let mut runs = found.runs;
    runs.sort_by_key(|run| (run.diagonal, run.number, run.pass));
    assert_eq!(read.runs, runs);
    let words = format!("{SIMULATED}: a test");
    assert_eq!(read.notes(), [Remark::Simulated { words }.into()]);
}

#[test]
fn straight_runs_are_the_cell_ends_of_step_runs() {
    let (inputs, wishes) = (plain_inputs(), Wishes { straight: true, ..Wishes::default() });
    let step = simulate(&inputs, None, Wishes::default());
    let straight = simulate(&inputs, None, wishes);
    let rehearsal = Rehearsal::of(&inputs, wishes).unwrap();
    assert_eq!(rehearsal.measurement.kind, PathKind::Straight);
    for (whole, ends) in step.runs.iter().zip(&straight.runs) {
        let cell_ends: Vec<_> = whole.deviations.iter().step_by(3).copied().collect();
        assert_eq!(ends.deviations, cell_ends, "{}", whole.diagonal);
    }
    let figures =
        |of: &Simulation| Diagonal::ALL.map(|d| of.diagonals[d]).map(|d| (d.end_um, d.range_um));
    assert_eq!(figures(&straight), figures(&step));
}

#[test]
fn a_change_of_scale_is_the_same_along_every_diagonal() {
    let inputs = plain_inputs();
    let rehearsal = Rehearsal::of(&inputs, Wishes::default()).unwrap();
    let ends = |scale: f64| {
        let warm = shown(SimulatedMachine::new(&inputs, None, scale));
        let found = readings(&warm, &rehearsal).unwrap();
        Diagonal::ALL.map(|d| found.diagonals[d].end_um)
    };
    // 11.5 um/m over a diagonal of sqrt(900^2 + 720^2 + 720^2) = 1358.970 mm.
    for (cold, warm) in ends(0.0).into_iter().zip(ends(11.5)) {
        assert!((warm - cold - 15.628_16).abs() < 1e-4, "{}", warm - cold);
    }
}

#[test]
fn the_error_table_holds_what_is_left_at_every_measured_position() {
    let mut machine = one_machine();
    machine.lost_um.y = -6.0;
    let inputs = inputs(&machine, None);
    let plain = shown(SimulatedMachine::new(&inputs, None, 0.0));
    let note = format!("note: {SIMULATED}: a test");
    let left = single_axes(&plain, 1, Noise::default(), vec![note.clone()]);
    let found = error_table(&table::write(&left));
    assert_eq!(found.remarks.lines(), [note]);
    for along in Axis::ALL {
        for series in found.series(along) {
            assert_eq!(series.positions, machine.volume.positions(along));
            for of in Axis::ALL {
                let term = ErrorTerm { of, along };
                let wanted = machine.directed(term, series.direction.unwrap());
                for (found, wanted) in series.values[&Kind::Deviation(of)].iter().zip(wanted) {
                    assert!((found - wanted).abs() < 2e-9, "{term}");
                }
            }
        }
    }
}
