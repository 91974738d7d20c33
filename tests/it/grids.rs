//! Every planned grid covers the travel, unless the job says where it begins and ends.
use crate::support;
use nonius::quantity::Axis;
use nonius::write::grid::Grid;
use nonius::write::plan::{Task, plan};
use proptest::prelude::*;

/// Rounding of binary fractions, mm; no control writes a digit as small.
const DUST_MM: f64 = 2e-6;

/// A control, and what it needs to know of an axis.
const CONTROLS: [(&str, &str); 5] = [
    ("generic", ""),
    ("siemens-840d-sl", ""),
    ("siemens-840d-sl", "\ncontrol_unit = \"inch\""),
    ("fanuc-30i", ""),
    ("fanuc-30i", "\ncontrol_unit = \"inch\""),
];

/// The grid of an axis with a bowed error; `None` = the control has not as many points, or the
/// reference cannot be one of them.
fn grid_of(control: usize, [low, high]: [f64; 2], reference: f64, request: &str) -> Option<Grid> {
    let (name, unit) = CONTROLS[control];
    let digit = if name.starts_with("fanuc") { "\ndetection_unit_um = 1.0" } else { "" };
    let job = format!(
        "schema = 1\n[machine]\nname = \"M\"\n[machine.axes.x]\ntravel_mm = [{low:?}, {high:?}]\n\
         reference_mm = {reference:?}\nreference_outside_mm = 10000.0\n[measurement]\n\
         errors = \"errors.csv\"\nactive_while_measuring = \"none\"\n[compensation]\n\
         controller = \"{name}\"{unit}\n[compensation.axes.x]\n{request}{digit}\n\
         [limits]\nmax_correction_um = 1000.0\nmax_slope_um_per_mm = 1000.0\n"
    );
    let at = |part: f64| low + part * (high - low);
    let (third, rest) = (at(0.3), at(0.7));
    let errors = format!(
        "axis,position_mm,ex_um\nx,{low:?},0\nx,{third:?},7\nx,{rest:?},-3\nx,{high:?},11\n"
    );
    let inputs = support::inputs(&job, &errors);
    let task = Task { job: &inputs.job, profile: &inputs.profile, model: &inputs.model };
    plan(task).ok()?.grids[Axis::X]
}

/// First and last point, mm.
fn ends(grid: &Grid) -> [f64; 2] {
    let (first, last) = grid.range();
    [first.mm(), last.mm()]
}

fn covers(grid: &Grid, [low, high]: [f64; 2]) -> bool {
    let [first, last] = ends(grid);
    first <= low + DUST_MM && last >= high - DUST_MM
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn every_planned_grid_covers_the_travel(
        control in 0..CONTROLS.len(),
        low_um in -3_000_000_i32..3_000_000,
        length_um in 20_000_i32..6_000_000,
        reference in -0.02..1.02_f64,
        decimals in 0_u32..7,
        at_an_end in 0_u32..3,
        kind in 0_u32..3,
        size in 0.0..1.0_f64,
    ) {
        let low = f64::from(low_um) / 1000.0;
        let high = (f64::from(low_um) + f64::from(length_um)) / 1000.0;
        let scale = f64::from(10_u32.pow(decimals));
        let reference = match at_an_end {
            0 => low,
            1 => high,
            _ => ((low + reference * (high - low)) * scale).round() / scale,
        };
        let request = match kind {
            0 => format!("spacing_mm = {:?}", (high - low) / (2.0 + (size * 60.0).round())),
            1 => format!("points = {:.0}", 3.0 + (size * 60.0).round()),
            _ => format!("max_residual_um = {:?}", 0.2 + 4.0 * size),
        };
        if let Some(grid) = grid_of(control, [low, high], reference, &request) {
            prop_assert!(
                covers(&grid, [low, high]),
                "{:?} {request}, reference {reference}: {:?} for {low} … {high} mm",
                CONTROLS[control], ends(&grid)
            );
        }
    }
}

/// Two points over 5 m: the smallest spacing was taken that covers it but for a millionth of a spacing,
/// 5 µm here.
#[test]
fn a_grid_by_its_residual_does_not_end_short_of_a_long_travel() {
    for request in ["max_residual_um = 30.0", "points = 2"] {
        let grid = grid_of(0, [0.0, 5000.0], 0.0, request).unwrap();
        assert!(covers(&grid, [0.0, 5000.0]), "{request}: {:?}", ends(&grid));
    }
}

#[test]
fn a_job_that_says_where_the_table_ends_gets_what_it_says() {
    let request = "spacing_mm = 50.0\nstart_mm = 100.0\nend_mm = 400.0";
    let grid = grid_of(0, [0.0, 500.0], 200.0, request).unwrap();
    assert_eq!(ends(&grid), [100.0, 400.0]);
}
