//! Laws that hold for every machine: what may and what may not change the tables.
use crate::support::{self, DUST_UM, short_or};
use nonius::control::table::Tables;
use nonius::inputs::error_table::Kind;
use nonius::kit;
use nonius::quantity::{Axis, ErrorTerm};
use nonius::read::generic::{GenericRow, read};
use nonius::write::plan::{Task, plan};
use proptest::prelude::*;
use std::fmt::Write;

/// One axis of a machine: targets, deviations in X, Y, Z there, travel from the first to the last.
#[derive(Clone, Debug)]
struct Rail {
    mm: Vec<f64>,
    um: [Vec<f64>; 3],
    reference: f64,
    spacing: f64,
}

impl Rail {
    fn with_errors(&self, change: impl Fn(usize, usize, f64) -> f64) -> Rail {
        let mut rail = self.clone();
        for (of, column) in rail.um.iter_mut().enumerate() {
            for (row, um) in column.iter_mut().enumerate() {
                *um = change(of, row, *um);
            }
        }
        rail
    }
}

/// How positions and deviations are written: columns, mm and µm of their units.
type Unit = (&'static str, f64, f64);
const METRIC: Unit = ("position_mm,ex_um,ey_um,ez_um", 1.0, 1.0);
const INCH: Unit = ("position_in,ex_in,ey_in,ez_in", 25.4, 25_400.0);

fn csv(rails: &[Rail; 3], (names, mm, um): Unit) -> String {
    let mut text = format!("axis,{names}\n");
    for (axis, rail) in Axis::ALL.iter().zip(rails) {
        for (row, x) in rail.mm.iter().enumerate() {
            let [ex, ey, ez] = [0, 1, 2].map(|of: usize| rail.um[of][row] / um);
            writeln!(text, "{},{:?},{ex:?},{ey:?},{ez:?}", axis.key(), x / mm).unwrap();
        }
    }
    text
}

/// A job whose control is `controller`; `keys` of [compensation], `grid` of every axis.
fn job(rails: &[Rail; 3], controller: &str, keys: &str, grid: impl Fn(&Rail) -> String) -> String {
    let unit = if support::needs_unit(controller) { "detection_unit_um = 1.0" } else { "" };
    let axes = Axis::ALL.iter().zip(rails).map(|(axis, rail)| {
        let travel = [rail.mm[0], rail.mm[rail.mm.len() - 1]];
        (axis.key(), travel, rail.reference, format!("{}\n{unit}", grid(rail)))
    });
    let compensation = format!("controller = \"{controller}\"\n{keys}");
    support::job_of(support::UNCORRECTED, &compensation, axes)
        + "[limits]\nmax_correction_um = 5000.0\nmax_slope_um_per_mm = 100.0\n"
}

fn spacing(rail: &Rail) -> String {
    format!("spacing_mm = {:?}", rail.spacing)
}

fn rows(rails: &[Rail; 3], keys: &str) -> Vec<GenericRow> {
    let job = job(rails, "generic", keys, spacing);
    let (_, kit) = support::generate(&job, &csv(rails, METRIC));
    read("compensation.csv", support::text_of(&kit, "compensation.csv")).unwrap()
}

fn in_thousandths(x: f64) -> f64 {
    (x * 1000.0).round() / 1000.0
}

fn thousandths(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low..high).prop_map(in_thousandths)
}

fn rail() -> impl Strategy<Value = Rail> {
    let point = (thousandths(10.0, 80.0), [-20.0..20.0_f64, -20.0..20.0_f64, -20.0..20.0_f64]);
    let points = proptest::collection::vec(point, 3..9);
    let all = (thousandths(-500.0, 500.0), points, 0.0..1.0_f64, 1..25_u32, 0..3_usize);
    all.prop_map(|(start, points, part, parts, place)| {
        let mut mm = vec![start];
        for (step, _) in &points[1..] {
            mm.push(in_thousandths(mm[mm.len() - 1] + step));
        }
        let (low, high) = (mm[0], mm[mm.len() - 1]);
        let inside = in_thousandths(low + part * (high - low));
        Rail {
            um: [0, 1, 2].map(|of: usize| points.iter().map(|(_, um)| um[of]).collect()),
            reference: [low, high, inside][place],
            spacing: (high - low) / f64::from(parts) * 1.01,
            mm,
        }
    })
}

fn rails() -> impl Strategy<Value = [Rail; 3]> {
    [rail(), rail(), rail()]
}

fn ways(curves: &[&'static str], fits: &[&'static str]) -> impl Strategy<Value = String> {
    let (curves, fits) =
        (prop::sample::select(curves.to_vec()), prop::sample::select(fits.to_vec()));
    (curves, fits).prop_map(|(curve, fit)| format!("curve = \"{curve}\"\nfit = \"{fit}\""))
}

fn all_ways() -> impl Strategy<Value = String> {
    ways(&["linear", "pchip", "natural-spline"], &["sample", "least-squares", "minimax"])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(short_or(12, 48)))]

    #[test]
    fn the_corrections_of_a_sum_are_the_sum_of_the_corrections(
        rails in rails(),
        others in proptest::collection::vec(-20.0..20.0_f64, 9),
        // What is linear in the measured values.
        ways in ways(&["linear", "natural-spline"], &["sample", "least-squares"]),
    ) {
        let other = |of: usize, row: usize| others[(3 * row + of) % 9];
        let second = rails.clone().map(|rail| rail.with_errors(|of, row, _| other(of, row)));
        let both = rails.clone().map(|rail| rail.with_errors(|of, row, um| um + other(of, row)));
        let [a, b, sum] = [&rails, &second, &both].map(|rails| rows(rails, &ways));
        for ((a, b), sum) in a.iter().zip(&b).zip(&sum) {
            prop_assert!((a.correction_um + b.correction_um - sum.correction_um).abs() <= 1e-8);
        }
    }

    #[test]
    fn moving_the_machine_zero_moves_positions_not_corrections(
        rails in rails(),
        by in thousandths(-2000.0, 2000.0),
        ways in all_ways(),
    ) {
        let moved = rails.clone().map(|mut rail| {
            let move_by = |x: f64| ((x + by) * 1000.0).round() / 1000.0;
            rail.mm = rail.mm.iter().map(|x| move_by(*x)).collect();
            rail.reference = move_by(rail.reference);
            rail
        });
        let (before, after) = (rows(&rails, &ways), rows(&moved, &ways));
        prop_assert_eq!(before.len(), after.len());
        // The least largest residual is iterated, and several tables can have it.
        let near = if ways.contains("minimax") { 1e-6 } else { DUST_UM };
        for (a, b) in before.iter().zip(&after) {
            prop_assert!((a.position_mm + by - b.position_mm).abs() <= 2e-6);
            prop_assert!((a.correction_um - b.correction_um).abs() <= near);
        }
    }

    #[test]
    fn permuting_the_axes_permutes_the_table(rails in rails(), ways in all_ways()) {
        // X is called Y, Y is called Z, Z is called X.
        let [x, y, z] = rails.clone();
        let renamed = [z, x, y].map(|mut rail| {
            rail.um.rotate_right(1);
            rail
        });
        let next = |axis: Axis| match axis {
            Axis::X => Axis::Y,
            Axis::Y => Axis::Z,
            Axis::Z => Axis::X,
        };
        let (before, after) = (rows(&rails, &ways), rows(&renamed, &ways));
        prop_assert_eq!(before.len(), after.len());
        for row in &before {
            let own = row.term().unwrap();
            let term = ErrorTerm { of: next(own.of), along: next(own.along) }.to_string();
            let same = after.iter().find(|r| r.term == term && r.index == row.index).unwrap();
            prop_assert!((row.correction_um - same.correction_um).abs() <= DUST_UM);
            prop_assert!((row.position_mm - same.position_mm).abs() <= DUST_UM);
        }
    }

    #[test]
    fn minimax_leaves_no_more_than_sampling(rails in rails(), curve in 0..3_usize) {
        let curve = ["linear", "pchip", "natural-spline"][curve];
        let errors = csv(&rails, METRIC);
        let [sampled, minimax] = ["sample", "minimax"].map(|fit| {
            let keys = format!("curve = \"{curve}\"\nfit = \"{fit}\"");
            support::generate(&job(&rails, "generic", &keys, spacing), &errors).1.plan.tables
        });
        for (sampled, minimax) in sampled.iter().zip(&minimax) {
            prop_assert_eq!(sampled.term, minimax.term);
            prop_assert!(minimax.grid_residual_um <= sampled.grid_residual_um + DUST_UM);
        }
    }

    #[test]
    fn written_spacing_times_sections_is_max_less_min(
        rails in rails(),
        step in 3.0..60.0_f64,
        inch in any::<bool>(),
    ) {
        let keys = if inch { "control_unit = \"inch\"" } else { "" };
        let grid = |_: &Rail| format!("spacing_mm = {step:?}");
        let text = job(&rails, "siemens-840d-sl", keys, grid);
        let (inputs, kit) = support::generate(&text, &csv(&rails, METRIC));
        let Tables::Siemens(tables) = support::loaded(&inputs.profile, &kit) else { panic!("tables of another control") };
        let points: Vec<usize> = tables.tables.iter().map(|t| t.values.len()).collect();
        let texts = ["NONIUS_EEC.MPF", "NONIUS_CEC.MPF"].map(|path| support::text_of(&kit, path)).concat();
        let of = |key: &str| -> Vec<i64> {
            texts.lines().filter(|l| l.contains(&format!("_{key}["))).map(millionths).collect()
        };
        let (steps, mins, maxs) = (of("STEP"), of("MIN"), of("MAX"));
        prop_assert_eq!(steps.len(), points.len());
        for (((step, min), max), points) in steps.iter().zip(&mins).zip(&maxs).zip(&points) {
            prop_assert_eq!(step * i64::try_from(points - 1).unwrap(), max - min);
        }
    }

    #[test]
    fn an_error_table_in_inches_is_the_same_table(rails in rails()) {
        let tables = [METRIC, INCH].map(|unit| support::error_table(&csv(&rails, unit)));
        for axis in Axis::ALL {
            let [metric, inch] = [0, 1].map(|table: usize| &tables[table].series(axis)[0]);
            for (a, b) in metric.positions.iter().zip(&inch.positions) {
                prop_assert!((a.mm() - b.mm()).abs() <= DUST_UM);
            }
            for of in Axis::ALL {
                let [a, b] = [metric, inch].map(|series| &series.values[&Kind::Deviation(of)]);
                for (a, b) in a.iter().zip(b) {
                    prop_assert!((a - b).abs() <= DUST_UM);
                }
            }
        }
    }
}

proptest! {
    // Over all controls: a sixth of the cases in plain `cargo test`.
    #![proptest_config(ProptestConfig::with_cases(short_or(4, 48)))]

    #[test]
    fn so_many_points_cover_the_travel_with_the_smallest_spacing(rails in rails(), points in 3..100_u32) {
        let ids: Vec<&str> = support::any_grid_ids().collect();
        for (place, id) in ids.iter().enumerate() {
            let text = job(&rails, id, "", |_| format!("points = {points}"));
            let inputs = support::inputs(&text, &csv(&rails, METRIC));
            // A whole kit takes much longer than its plan.
            let plan = if short_or(place == points as usize % ids.len(), true) {
                kit::generate(&inputs).map(|kit| kit.plan)
            } else {
                plan(Task { job: &inputs.job, profile: &inputs.profile, model: &inputs.model })
            };
            let plan = plan.unwrap_or_else(|problems| panic!("{}", problems.render()));
            for (axis, rail) in Axis::ALL.into_iter().zip(&rails) {
                let grid = plan.grids[axis].unwrap();
                let step = grid.spacing().mm();
                prop_assert_eq!(grid.count(), points as usize);
                let (first, last) = grid.range();
                let (low, high) = (rail.mm[0], rail.mm[rail.mm.len() - 1]);
                prop_assert!(first.mm() <= low + 1e-3 * step && last.mm() >= high - 1e-3 * step);
                prop_assert!(first.mm() <= low + 1e-6 * step + 1e-9, "{} {}", first.mm(), low);
                prop_assert!(last.mm() >= high - 1e-6 * step - 1e-9, "{} {}", last.mm(), high);
                // The reference is a point.
                let index = (rail.reference - first.mm()) / step;
                prop_assert!((index - index.round()).abs() < 1e-6);
                // With a thousandth less, more points would be needed.
                let less = step - 0.001;
                let steps = |length: f64| (length / less - 1e-6).ceil();
                let needed = steps(rail.reference - low) + steps(high - rail.reference) + 1.0;
                prop_assert!(needed > f64::from(points), "{}: {} mm would do", id, less);
            }
        }
    }
}

/// The number of an assignment in millionths, from its text: `…=-12.345678` is −12345678.
fn millionths(line: &str) -> i64 {
    let (whole, decimals) = line.split('=').nth(1).unwrap().trim().split_once('.').unwrap();
    assert_eq!(decimals.len(), 6, "{line}");
    format!("{whole}{decimals}").parse().unwrap()
}

/// A millionth of a spacing was left open at an end, 5 µm of 5 m; a job may say where its table ends.
#[test]
fn a_grid_covers_a_long_travel_unless_the_job_says_where_it_ends() {
    for (request, reference, ends) in [
        ("max_residual_um = 30.0", 0.0, [0.0, 5000.0]),
        ("points = 2", 0.0, [0.0, 5000.0]),
        ("spacing_mm = 50.0\nstart_mm = 100.0\nend_mm = 400.0", 200.0, [100.0, 400.0]),
    ] {
        let um = [vec![0.0, 7.0, -3.0, 11.0], vec![0.0; 4], vec![0.0; 4]];
        let mm = vec![0.0, 1500.0, 3500.0, 5000.0];
        let rails =
            [(); 3].map(|()| Rail { mm: mm.clone(), um: um.clone(), reference, spacing: 0.0 });
        let text = job(&rails, "generic", "", |_| request.to_string());
        let inputs = support::inputs(&text, &csv(&rails, METRIC));
        let kit = kit::generate(&inputs).unwrap_or_else(|p| panic!("{}", p.render()));
        let (first, last) = kit.plan.grids.x.unwrap().range();
        let is_covered = first.mm() <= ends[0] + 2e-6 && last.mm() >= ends[1] - 2e-6;
        let is_meant = ends[1] > 400.0 || [first.mm(), last.mm()] == ends;
        assert!(is_covered && is_meant, "{request}: {first:?} to {last:?}");
    }
}
