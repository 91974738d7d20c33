//! Machine H: a machine of 12 × 4 × 2 m with errors in closed form, tabulated in
//! fixtures/machine_h. It passes through figure 2 of paper 002 at (9, 3.5, 1.35) m.
use nonius::quantity::Axis;
use nonius::volume::space::grid_map::{AxisNode, GridMap, Vector};
use std::f64::consts::PI;

/// Offsets of the measurement of Y and Z, m.
const Y_OFFSET: f64 = 0.5;
const Z_OFFSET: f64 = 1.0;

/// Squareness: x for a metre of y, x for a metre of z, y for a metre of z, µm/m.
const XY: f64 = -77.0;
const XZ: f64 = 181.0;
const YZ: f64 = 23.0;

fn wave(turns: f64, part: f64) -> f64 {
    (PI * turns * part).sin()
}

/// Translation in µm and rotation in µrad of X at `x` m.
pub(crate) fn x_errors(x: f64) -> (Vector, Vector) {
    let u = x / 9.0;
    let shift = [
        331.98 * u + 25.0 * wave(1.0, u) + 14.0 * wave(12.0, u),
        -38.554 * wave(0.5, u) + 7.0 * wave(8.0, u),
        -39.759 * wave(0.5, u) + 6.0 * wave(10.0, u),
    ];
    let turn = [
        7.0 * (2.0 * PI * u).cos() - 3.0 * wave(4.0, u),
        28.5 * wave(0.5, u) + 5.0 * wave(6.0, u),
        -20.5 * u - 8.0 * wave(4.0, u),
    ];
    (shift, turn)
}

/// Translation in µm and rotation in µrad of Y at `y` m, without squareness.
pub(crate) fn y_errors(y: f64) -> (Vector, Vector) {
    let v = y / 3.5;
    let shift = [
        -32.193 * wave(0.5, v) + 6.0 * wave(10.0, v),
        9.2 * v + 12.0 * wave(4.0, v),
        21.126 * wave(0.5, v) + 3.0 * wave(8.0, v),
    ];
    (shift, [-4.333 * wave(0.5, v), 9.0 * wave(2.0, v), 0.0])
}

/// Translation in µm of Z at `z` m, without squareness.
pub(crate) fn z_errors(z: f64) -> Vector {
    let w = z / 1.35;
    [
        1.303 * w + 4.0 * wave(1.0, w),
        -18.188 * wave(0.5, w) + 2.0 * wave(6.0, w),
        9.2 * w + 5.0 * wave(4.0, w),
    ]
}

fn nodes(length: f64, count: usize) -> Vec<f64> {
    let last = (count - 1) as f64;
    (0..count).map(|n| length * (n as f64 / last)).collect()
}

/// The map with so many nodes on X, Y and Z, errors zero at none of them in particular.
pub(crate) fn machine_h(counts: [usize; 3]) -> GridMap {
    let x = |at: f64| {
        let (translation_um, rotation_urad) = x_errors(at);
        AxisNode { translation_um, rotation_urad, arm_m: at }
    };
    let y = |at: f64| {
        let ((mut translation_um, rotation_urad), arm_m) = (y_errors(at), at - Y_OFFSET);
        translation_um[0] += XY * arm_m;
        AxisNode { translation_um, rotation_urad, arm_m }
    };
    let z = |at: f64| {
        let (mut translation_um, arm_m) = (z_errors(at), at - Z_OFFSET);
        translation_um[0] += XZ * arm_m;
        translation_um[1] += YZ * arm_m;
        AxisNode { translation_um, rotation_urad: [0.0; 3], arm_m }
    };
    let axes = [
        nodes(12.0, counts[0]).into_iter().map(x).collect(),
        nodes(4.0, counts[1]).into_iter().map(y).collect(),
        nodes(2.0, counts[2]).into_iter().map(z).collect(),
    ];
    GridMap::new([Axis::X, Axis::Y, Axis::Z], &axes).expect("a sound map")
}
