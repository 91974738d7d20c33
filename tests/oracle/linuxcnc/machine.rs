//! Machines with errors that are formulas of the test: what they reach when their drives are told something, and what
//! a laser along a diagonal shows. Nothing of the program is used here.

use super::control::{Cycle, Joint};
use crate::support::job_measured;
use std::f64::consts::TAU;

/// A machine with planted errors; lengths in mm, errors in µm.
pub(crate) struct Machine {
    pub(crate) name: &'static str,
    /// Machine coordinates of both ends of each axis; every reference point is at 0.
    pub(crate) travel: [[f64; 2]; 3],
    /// Growth of each scale, µm/m.
    pub(crate) slope: [f64; 3],
    /// Wave of each scale, µm, once over the travel.
    pub(crate) wave: [f64; 3],
    /// What an axis lags behind when it moves in the negative direction, µm.
    pub(crate) reversal: [f64; 3],
    /// Bow of axis (row) in direction (column), µm; the diagonal is not used.
    pub(crate) bow: [[f64; 3]; 3],
    /// Out of square and out of line: tilt of axis (row) towards direction (column), µm/m.
    pub(crate) tilt: [[f64; 3]; 3],
}

impl Machine {
    fn length(&self, axis: usize) -> f64 {
        self.travel[axis][1] - self.travel[axis][0]
    }

    /// Error of `axis` in `direction`, arriving upwards or downwards, µm: reached less commanded, 0 at the reference up.
    pub(crate) fn error_um(&self, axis: usize, direction: usize, at: f64, upwards: bool) -> f64 {
        let turn = TAU * at / self.length(axis);
        if axis == direction {
            let lag = if upwards { 0.0 } else { self.reversal[axis] };
            return self.slope[axis] * at / 1000.0 + self.wave[axis] * turn.sin() + lag;
        }
        self.tilt[axis][direction] * at / 1000.0 + self.bow[axis][direction] * (1.0 - turn.cos())
    }

    /// The error of the machine's point, µm, with its drives at `at` after they arrived as stated.
    pub(crate) fn errors_um(&self, at: [f64; 3], upwards: [bool; 3]) -> [f64; 3] {
        let sum = |direction: usize| {
            let of = |axis: usize| self.error_um(axis, direction, at[axis], upwards[axis]);
            (0..3).map(of).sum()
        };
        [0, 1, 2].map(sum)
    }

    /// A job that measures and compensates the machine so; the reference points are approached upwards.
    pub(crate) fn job(&self, measurement: &str, compensation: &str, spacing: [f64; 3]) -> String {
        let axes = [("x", 0), ("y", 1), ("z", 2)].map(|(name, axis)| {
            (name, self.travel[axis], 0.0, format!("spacing_mm = {:?}", spacing[axis]))
        });
        job_measured(measurement, compensation, axes)
    }

    pub(crate) fn error_table(&self, points: usize) -> String {
        let mut rows = String::from("axis,position_mm,direction,ex_um,ey_um,ez_um\n");
        for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
            for (word, upwards) in [("+", true), ("-", false)] {
                for point in 0..points {
                    let part = point as f64 / (points - 1) as f64;
                    let at = self.travel[axis][0] + part * self.length(axis);
                    let of = |direction| self.error_um(axis, direction, at, upwards);
                    let [x, y, z] = [0, 1, 2].map(of);
                    rows += &format!("{letter},{at:.6},{word},{x:.9},{y:.9},{z:.9}\n");
                }
            }
        }
        rows
    }
}

/// Where the machine stands still: the joints, and whether each arrived upwards.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stand {
    pub(crate) command: [f64; 3],
    pub(crate) drive: [f64; 3],
    pub(crate) added: [f64; 3],
    pub(crate) upwards: [bool; 3],
}

/// The places where all joints rest after the first move, every ramp over, as they are at the end of it.
pub(crate) fn stands(run: &[Cycle]) -> Vec<Stand> {
    let (mut found, mut upwards, mut still, mut moved) = (Vec::new(), [true; 3], 0, false);
    for (number, cycle) in run.iter().enumerate() {
        for (joint, up) in cycle.iter().zip(&mut upwards) {
            if joint.speed != 0.0 {
                *up = joint.speed > 0.0;
            }
        }
        let is_same = |(now, next): (&Joint, &Joint)| (next.drive - now.drive).abs() < 1e-9;
        let goes_on = run.get(number + 1).is_some_and(|next| {
            next.iter().all(|joint| joint.speed == 0.0) && cycle.iter().zip(next).all(is_same)
        });
        moved |= cycle.iter().any(|joint| joint.speed != 0.0);
        // A dwell lasts its seconds, and on a busy computer the control makes fewer cycles in them than it should.
        if moved && still >= 20 && !goes_on {
            found.push(Stand {
                command: cycle.map(|joint| joint.command),
                drive: cycle.map(|joint| joint.drive),
                added: cycle.map(|joint| joint.added),
                upwards,
            });
        }
        still = if goes_on { still + 1 } else { 0 };
    }
    found
}
