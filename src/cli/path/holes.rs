//! The error at the holes that canned cycles drill: the worst of them.

use crate::volume::tool_path::{PathMap, Sample};

/// Holes that are kept; the CSV has all of them.
const MOST_HOLES: usize = 20;

/// A hole at its bottom.
pub(super) struct Hole {
    pub(super) number: u64,
    pub(super) line: usize,
    /// Machine coordinates, mm.
    pub(super) place: [f64; 3],
    /// µm.
    pub(super) error_um: [f64; 3],
    /// With tables, µm.
    pub(super) after_um: Option<[f64; 3]>,
}

/// The holes with the largest errors, the worst first; of equal ones the first.
#[derive(Default)]
pub(super) struct Holes(Vec<Hole>);

impl Holes {
    /// Takes a sample if it is the bottom of a hole; `after` = the machine with tables.
    pub(super) fn take(&mut self, sample: &Sample, after: Option<&PathMap>) {
        let Some(number) = sample.hole else { return };
        let size = length(sample.error_um);
        let place = self.0.partition_point(|hole| length(hole.error_um) >= size);
        if place == MOST_HOLES {
            return;
        }
        self.0.truncate(MOST_HOLES - 1);
        self.0.insert(
            place,
            Hole {
                number,
                line: sample.line,
                place: sample.place,
                error_um: sample.error_um,
                after_um: after.map(|map| map.error_at(sample.place, sample.longer_mm)),
            },
        );
    }

    pub(super) fn worst(&self) -> &[Hole] {
        &self.0
    }
}

/// Of an error vector.
pub(super) fn length([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}
