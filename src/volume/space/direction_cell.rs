//! Cells of directions: a half sphere, cut finer only where a longest difference may point.
//!
//! For a unit direction d let w(d) be the extent of the error vectors along d. A difference of
//! length L within the angle θ of d has w(d) ≥ L·cos θ, so a cell of directions with
//! w(d) < D·cos θ holds no difference as long as D.

use super::grid_map::Vector;
use super::pair::{dot, unit};

/// A square on a face of the cube −1…1 and the directions through it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DirectionCell {
    /// Axis of the face.
    face: usize,
    /// Centre on the face.
    centre: [f64; 2],
    /// Half the side.
    half: f64,
}

impl DirectionCell {
    /// Twelve cells that hold every direction or its opposite.
    pub(super) fn half_sphere() -> impl Iterator<Item = DirectionCell> {
        let faces = (0..3).map(|face| DirectionCell {
            face,
            centre: [0.0; 2],
            half: 1.0,
        });
        faces.flat_map(|face| face.quarters())
    }

    /// The cell cut in four.
    pub(super) fn quarters(self) -> [DirectionCell; 4] {
        let half = self.half / 2.0;
        [(-half, -half), (-half, half), (half, -half), (half, half)].map(|(u, v)| DirectionCell {
            centre: [self.centre[0] + u, self.centre[1] + v],
            half,
            ..self
        })
    }

    /// True where a bound for `length` gains less than `room` from cutting the cell.
    pub(super) fn is_fine(self, length: f64, room: f64) -> bool {
        length * (1.0 - self.cosine()) <= room
    }

    fn through(self, u: f64, v: f64) -> Vector {
        let mut direction = [0.0; 3];
        direction[self.face] = 1.0;
        direction[(self.face + 1) % 3] = u;
        direction[(self.face + 2) % 3] = v;
        unit(direction).unwrap_or(direction)
    }

    /// Direction of the centre.
    pub(super) fn direction(self) -> Vector {
        self.through(self.centre[0], self.centre[1])
    }

    /// Cosine of the largest angle between the centre and a direction of the cell: a corner's.
    pub(super) fn cosine(self) -> f64 {
        let centre = self.direction();
        let [u, v] = self.centre;
        let half = self.half;
        [(-half, -half), (-half, half), (half, -half), (half, half)]
            .into_iter()
            .map(|(du, dv)| dot(&centre, &self.through(u + du, v + dv)))
            .fold(1.0, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_direction_is_within_the_angle_of_a_cell_or_its_opposite_is() {
        for n in 0..2000 {
            let turn = f64::from(n) * 2.399_963;
            let z = 1.0 - (f64::from(n) + 0.5) / 1000.0;
            let r = (1.0 - z * z).sqrt();
            let d = [r * turn.cos(), r * turn.sin(), z];
            let within =
                |cell: DirectionCell| dot(&d, &cell.direction()).abs() >= cell.cosine() - 1e-12;
            let cell = DirectionCell::half_sphere().find(|cell| within(*cell));
            let cell = cell.expect("a cell");
            assert!(cell.cosine() > 0.8);
            assert!(
                DirectionCell::half_sphere()
                    .flat_map(DirectionCell::quarters)
                    .any(within)
            );
        }
    }
}
