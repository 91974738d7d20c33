//! What to measure where scales are not determined, and under which key of the job it goes.

use crate::machine::separation::metric::Metric;
use crate::quantity::axis::Axis;

const LINEAR: &str =
    "[[measurement.step_diagonal.linear]] with axis, slope_um_per_m (or errors) and u_um_per_m";
const BEAM: &str =
    "[[measurement.step_diagonal.beam]] with from_mm, to_mm, slope_um_per_m and u_um_per_m";

/// Ways to determine the scales that are open (docs/method.md §5); empty where none is.
pub(super) fn advice(metric: &Metric) -> Vec<String> {
    let open = |axis: &Axis| metric.scale[*axis].is_none();
    let (open, known): (Vec<Axis>, Vec<Axis>) = Axis::ALL.into_iter().partition(open);
    match (open.as_slice(), known.as_slice()) {
        ([], _) => Vec::new(),
        ([a, b], [known]) => vec![
            format!("{a} or {b} measured along its length: add {LINEAR}"),
            format!("or a face diagonal of a plane with {known}: add {BEAM}"),
        ],
        _ => vec![
            format!("two axes measured along their length: add two {LINEAR}"),
            format!(
                "or face diagonals of two planes, or one axis and a face diagonal of a plane with it: add {BEAM}"
            ),
        ],
    }
}
