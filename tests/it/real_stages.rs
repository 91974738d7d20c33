//! Measured machines: three real stages (ISO 230-2 runs, read where they lie, not part of this
//! repository), and the shipped nine errors against an independent simulation.
use crate::support::{self, Lines, fixture, shared};
use nonius::control::controller::{Dialect, builtin};
use nonius::control::table::Tables;
use nonius::control::table::fanuc::ParameterValue;
use nonius::quantity::{Axis, Direction, ErrorTerm};
use std::path::Path;

/// Detection unit of the Fanuc jobs, µm.
const UNIT_UM: f64 = 0.1;
/// Half a count of the Siemens tables (six decimals of a millimetre), µm.
const HALF_COUNT_UM: f64 = 0.0005;

/// Mean deviation of five runs, µm, moving up and down.
struct Stage {
    up: Lines,
    down: Lines,
}

impl Stage {
    fn read(path: &Path) -> Stage {
        let text = std::fs::read_to_string(path).unwrap();
        let rows = text.lines().filter(|line| !line.starts_with(['#', 'i']));
        let cells = |line: &str| line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let rows: Vec<Vec<f64>> = rows.map(cells).collect();
        let mean = |first: usize| {
            let um = |row: &Vec<f64>| row[first..first + 5].iter().sum::<f64>() / 5.0 - row[1];
            Lines {
                mm: rows.iter().map(|row| row[1]).collect(),
                um: rows.iter().map(|row| um(row) * 1000.0).collect(),
            }
        };
        Stage { up: mean(2), down: mean(7) }
    }

    fn spacing(&self) -> f64 {
        self.up.mm[1] - self.up.mm[0]
    }

    /// The same with a target between any two, on the straight line.
    fn halved(&self) -> Stage {
        let halve = |lines: &Lines| {
            let pairs = lines.mm.windows(2).flat_map(|p| [p[0], (p[0] + p[1]) / 2.0]);
            let mm: Vec<f64> = pairs.chain(lines.mm.last().copied()).collect();
            let um = mm.iter().map(|x| lines.at(*x)).collect();
            Lines { mm, um }
        };
        Stage { up: halve(&self.up), down: halve(&self.down) }
    }

    /// Deviation relative to that moving up at 0, at every target: up, down.
    fn relative(&self) -> [Vec<f64>; 2] {
        let zero = self.up.at(0.0);
        [&self.up, &self.down].map(|lines| lines.um.iter().map(|um| um - zero).collect())
    }

    /// Reversal B at every target, and at 0.
    fn reversal(&self) -> (Vec<f64>, f64) {
        let pairs = self.up.um.iter().zip(&self.down.um);
        (pairs.map(|(up, down)| up - down).collect(), self.up.at(0.0) - self.down.at(0.0))
    }
}

fn largest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().fold(0.0, |most, um| most.max(um.abs()))
}

/// The three stages as one machine; the end of the test, told in one line, without the data.
fn stages() -> Option<Vec<(Axis, Stage)>> {
    let data = shared("iso230-2")?;
    let file = |axis: Axis| data.join(format!("iso230_2_ess_b02_{}.csv", axis.key()));
    Some(Axis::ALL.map(|axis| (axis, Stage::read(&file(axis)))).into())
}

fn errors_csv(stages: &[(Axis, Stage)]) -> String {
    let mut csv = String::from("axis,direction,position_mm,ex_um,ey_um,ez_um\n");
    for (axis, stage) in stages {
        let before = ",".repeat(Axis::ALL.iter().position(|of| of == axis).unwrap());
        for (sign, lines) in [("+", &stage.up), ("-", &stage.down)] {
            for (x, um) in lines.mm.iter().zip(&lines.um) {
                let cells = format!("{before}{um:?}{}", &",,"[before.len()..]);
                csv += &format!("{},{sign},{x:?},{cells}\n", axis.key());
            }
        }
    }
    csv
}

/// Points of the tables: on the targets. A Fanuc control adds at most 7 × 100 × 0.1 µm from one
/// point to the next, less than the steepest stage asks for, so it has one more between any two.
fn job(stages: &[(Axis, Stage)], controller: &str, policy: &str) -> String {
    let parts = if controller.starts_with("fanuc") { 2.0 } else { 1.0 };
    job_with(stages, controller, policy, parts)
}

fn job_with(stages: &[(Axis, Stage)], controller: &str, policy: &str, parts: f64) -> String {
    let unit = format!("detection_unit_um = {UNIT_UM:?}\n");
    let unit = if support::needs_unit(controller) { &unit[..] } else { "" };
    // The stages are short and steep: up to 8 µm on 1 mm.
    let mut job = format!(
        "schema = 1\n[measurement]\nerrors = \"errors.csv\"\nactive_while_measuring = \"none\"\n\
         [compensation]\ncontroller = \"{controller}\"\nbacklash = \"{policy}\"\n\
         [limits]\nmax_slope_um_per_mm = 20.0\n[machine]\nname = \"three stages\"\n"
    );
    for (axis, stage) in stages {
        let (axis, mm, spacing) = (axis.key(), &stage.up.mm, stage.spacing() / parts);
        let (low, high) = (mm[0], mm[mm.len() - 1]);
        job += &format!(
            "[machine.axes.{axis}]\ntravel_mm = [{low:?}, {high:?}]\nreference_mm = 0.0\nreference_direction = \"+\"\n\
             [compensation.axes.{axis}]\nspacing_mm = {spacing:?}\n{unit}"
        );
    }
    job
}

/// Largest |deviation + correction| over both directions if the control steps in the middle of
/// every section from one total to the next (a whole number of counts).
///
/// `wanted`: what the table of a direction is made from; `constant`: parameter 3627.
fn left_by_steps(stage: &Stage, count: f64, tables: [(&[f64], f64); 2]) -> f64 {
    let mut left = 0.0_f64;
    for (deviation, (wanted, constant)) in stage.relative().iter().zip(tables) {
        let reference = stage.up.mm.iter().position(|x| x.abs() < 1e-9).unwrap();
        let correction = |(node, um): (usize, &f64)| match node == reference {
            true => constant,
            false => ((-um - constant) / count).round() * count + constant,
        };
        let correction: Vec<f64> = wanted.iter().enumerate().map(correction).collect();
        for section in 1..deviation.len() {
            let (a, b) = (deviation[section - 1], deviation[section]);
            let middle = (a + b) / 2.0;
            let (low, high) = (correction[section - 1], correction[section]);
            left = largest(&[left, a + low, middle + low, middle + high, b + high]);
        }
    }
    left
}

/// Largest error of the forecast's figures: they are sums of a few rounded numbers.
const FIGURE_UM: f64 = 1e-6;

/// Table points on the targets: what is left of each is known to half a count.
#[test]
fn three_stages_with_the_mean_of_both_directions_or_a_table_for_each() {
    let Some(stages) = stages() else { return };
    for id in support::positioning_ids() {
        for policy in ["mean", "two-tables"] {
            check_stages(&stages, id, policy);
        }
    }
}

fn check_stages(stages: &[(Axis, Stage)], id: &str, policy: &str) {
    let profile = builtin::profile(id).unwrap();
    let (_, kit) = support::generate(&job(stages, id, policy), &errors_csv(stages));
    let tables = support::loaded(&profile, &kit);
    for ((axis, stage), number) in stages.iter().zip(1..) {
        let own = ErrorTerm { of: *axis, along: *axis };
        let term = kit.forecast.terms.iter().find(|t| t.term == own).unwrap();
        let name = format!("{id} {own} {policy}");
        let before = largest(stage.relative().iter().flatten());
        let (found, left) = (term.change.before_um, term.change.after_um);
        assert!((found - before).abs() <= FIGURE_UM, "{name}: before {found}, expected {before}");

        // One table with the mean leaves half the reversal in each direction, shifted by half
        // the reversal at the reference, where moving up is zero:
        //   up:   d_up − m + m(0) = +B/2 − B(0)/2;   down: −B/2 − B(0)/2
        // so the larger of the two is (|B| + |B(0)|)/2. Two tables leave nothing.
        let (reversal, at_zero) = stage.reversal();
        let ideal = match support::has_two_directions(&profile) && policy != "mean" {
            true => 0.0,
            false => (largest(&reversal) + at_zero.abs()) / 2.0,
        };
        let (after, near) = match (&profile.dialect, &tables) {
            (Dialect::Declared(facts), _) => {
                let unit = support::needs_unit(id).then_some(UNIT_UM);
                (ideal, support::count_um(facts, unit) / 2.0)
            }
            (Dialect::Siemens(_) | Dialect::Linuxcnc(_) | Dialect::Isg(_), _) => {
                (ideal, HALF_COUNT_UM)
            }
            (Dialect::Fanuc(_), Tables::Fanuc(memory)) => {
                let Some(ParameterValue::Integer(times)) = memory.parameter(3623, Some(number))
                else {
                    panic!("no 3623 of axis {number}")
                };
                let count = UNIT_UM * times as f64;
                let fine = stage.halved();
                let [up, down] = fine.relative();
                let pairs = up.iter().zip(&down);
                let mean: Vec<f64> = pairs.map(|(up, down)| (up + down + at_zero) / 2.0).collect();
                let constant = (at_zero / UNIT_UM).round() * UNIT_UM;
                let tables: [(&[f64], f64); 2] = match policy {
                    "mean" => [(&mean, 0.0), (&mean, 0.0)],
                    _ => [(&up, 0.0), (&down, constant)],
                };
                (left_by_steps(&fine, count, tables), 0.0)
            }
            _ => panic!("{name}: tables of another control"),
        };
        let near = near + FIGURE_UM;
        assert!((left - after).abs() <= near, "{name}: after {left}, expected {after}");
        assert!(left < before, "{name} helps");
    }
}

/// The refusal names the direction's table that is too steep, not the other one.
#[test]
fn a_stage_too_steep_for_the_control_is_refused_with_its_figure() {
    let Some(stages) = stages() else { return };
    let changes =
        |lines: &Lines| largest(&lines.um.windows(2).map(|p| p[1] - p[0]).collect::<Vec<f64>>());
    let stage = &stages[1].1;
    let steepest = changes(&stage.up).max(changes(&stage.down));
    assert!(steepest > 70.0, "the stage is no longer too steep");
    let job = job_with(&stages, "fanuc-30i", "two-tables", 1.0);
    let refused = nonius::kit::generate(&support::inputs(&job, &errors_csv(&stages)));
    let text = refused.expect_err("a refusal").render();
    let expected = format!("EYY changes by {steepest:.1} µm between two points");
    assert!(text.contains(&expected), "another refusal");
}

/// Ordinary lost motion: moving down the machine lags, it stands too far in +.
#[test]
fn the_emulated_stages_stand_where_they_should() {
    let Some(stages) = stages() else { return };
    for id in support::positioning_ids().filter(|id| !id.starts_with("fanuc")) {
        let profile = builtin::profile(id).unwrap();
        if !support::has_two_directions(&profile) {
            continue; // what the mean leaves stands above
        }
        let half = match &profile.dialect {
            Dialect::Declared(facts) => {
                support::count_um(facts, support::needs_unit(id).then_some(UNIT_UM)) / 2.0
            }
            _ if support::needs_unit(id) => UNIT_UM / 2.0,
            _ => HALF_COUNT_UM,
        };
        let (_, kit) = support::generate(&job(&stages, id, "two-tables"), &errors_csv(&stages));
        let control = support::control(&profile, &kit);
        for ((_, stage), name) in stages.iter().zip(&profile.axis_names.value) {
            let zero = stage.up.at(0.0);
            for (direction, lines) in
                [(Direction::Plus, &stage.up), (Direction::Minus, &stage.down)]
            {
                let response = support::response(control.as_ref(), name, name, direction);
                let (low, high) = (lines.mm[0], lines.mm[lines.mm.len() - 1]);
                for part in 0..=500 {
                    let x = low + (high - low) * f64::from(part) / 500.0;
                    let left = (lines.at(x) - zero + support::um_at(&response, x)).abs();
                    assert!(left <= half + FIGURE_UM, "{id} {name}{direction} at {x}: {left}");
                }
            }
        }
    }
}

/// Range of every body diagonal as measured, µm, from an independent simulation.
const DIAGONALS_UM: [(&str, f64); 4] =
    [("PPP", 18.543452999), ("NPP", 12.715510628), ("PNP", 13.843169661), ("PPN", 21.457424184)];
/// φ of every pair of axes, µm/m, from the same simulation.
const SQUARENESS_UM_PER_M: [(Axis, Axis, f64); 3] =
    [(Axis::X, Axis::Y, 19.166666667), (Axis::X, Axis::Z, -13.055555556), (Axis::Y, Axis::Z, 12.5)];

#[test]
fn nine_errors_of_the_900_mm_machine_on_every_control() {
    let errors = fixture("nine_errors_900/errors.csv");
    for id in support::positioning_ids() {
        let example = if support::needs_unit(id) { "fanuc-30i" } else { "generic" };
        let job = fixture(&format!("nine_errors_900/{example}.toml"));
        let job = job.replace(&format!("\"{example}\""), &format!("\"{id}\""));
        let (inputs, kit) = support::generate(&job, &errors);
        assert_eq!(kit.manifest.controller, id);
        for (first, second, expected) in SQUARENESS_UM_PER_M {
            let phi = inputs.model.squareness_um_per_m(first, second).unwrap();
            assert!((phi - expected).abs() <= FIGURE_UM, "{id} φ{first}{second}: {phi}");
        }
        assert_eq!(kit.forecast.diagonals.len(), 4);
        for (diagonal, (name, before)) in kit.forecast.diagonals.iter().zip(DIAGONALS_UM) {
            assert_eq!(diagonal.diagonal.name(), name);
            let (found, left) = (diagonal.change.before_um, diagonal.change.after_um);
            assert!((found - before).abs() <= FIGURE_UM, "{id} {name}: {found}");
            // Without its straightness and squareness a diagonal may become larger.
            assert!(left < before || !kit.plan.omitted.is_empty(), "{id} {name}: {left} after");
            // Table points lie on the measured ones: nothing but rounding is left.
            let exact = match id {
                "generic" => FIGURE_UM,
                "siemens-840d-sl" => 9.0 * HALF_COUNT_UM,
                _ => continue,
            };
            assert!(left <= 2.0 * exact, "{id} {name}: {left} after");
        }
        let expected = match id {
            "fanuc-0i-f" | "fanuc-16i" | "isg-axis" => 3, // ISG has one for each axis
            _ if support::has_cross_terms(&inputs.profile) => 0,
            _ => 6, // no table moves another axis
        };
        assert_eq!(kit.plan.omitted.len(), expected, "{id}: terms without a table");
    }
}
