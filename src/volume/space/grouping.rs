//! The grouping method of paper 002, section 4.2, kept for comparison. **It is not exact.**
//!
//! Vectors of about the same direction form a group, and only the long ones of a group are
//! compared. What is left out shares the direction of the one that stays, not its place: with a
//! constant error added, which changes no difference, the result may be too small by half.

use super::grid_map::Vector;
use super::pair::{self, Ends, Longest, Point};

/// Tolerances of the grouping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Largest sum of the absolute differences between a unit vector and the mean of a group
    /// (table 1 of the paper: 0.05, 0.1, 0.2).
    pub angular: f64,
    /// Part of a group's longest vector below which a vector is dismissed (the paper: 0.9).
    pub magnitude: f64,
}

/// What the method keeps and finds.
#[derive(Clone, Debug, PartialEq)]
pub struct Grouping {
    /// Number of groups.
    pub groups: usize,
    /// Numbers of the vectors that are kept (*records*), ascending.
    pub records: Vec<usize>,
    /// The longest difference of two records; `None` where nothing is kept.
    pub longest: Option<Longest>,
}

struct Group {
    sum: Vector,
    mean: Vector,
    joined: f64,
    largest: f64,
    members: Vec<(usize, f64)>,
}

/// Groups the vectors in their order and compares what is kept.
///
/// source paper 002 in the reading that comes nearest to its table 1: the sum of the differences
///        is of absolute values, the mean is of all that joined, and a new longest vector dismisses
///        earlier members that are too short beside it. Vectors of length 0 are skipped
/// limits a lower bound of the volumetric accuracy, without a bound of what is missing
pub fn grouping(vectors: &[Vector], tolerance: Tolerance) -> Grouping {
    let mut groups: Vec<Group> = Vec::new();
    for (number, vector) in vectors.iter().enumerate() {
        let [x, y, z] = vector;
        let length = (x * x + y * y + z * z).sqrt();
        if length <= 0.0 {
            continue;
        }
        let unit = vector.map(|c| c / length);
        let near = |group: &&mut Group| apart(&unit, &group.mean) <= tolerance.angular;
        match groups.iter_mut().find(near) {
            Some(group) => group.join(number, unit, length, tolerance.magnitude),
            None => groups.push(Group::of(number, unit, length)),
        }
    }
    let members = groups.iter().flat_map(|group| &group.members);
    let mut records: Vec<usize> = members.map(|(number, _)| *number).collect();
    records.sort_unstable();
    Grouping { groups: groups.len(), longest: compare(vectors, &records), records }
}

fn apart(unit: &Vector, mean: &Vector) -> f64 {
    (unit[0] - mean[0]).abs() + (unit[1] - mean[1]).abs() + (unit[2] - mean[2]).abs()
}

fn compare(vectors: &[Vector], records: &[usize]) -> Option<Longest> {
    let mut longest = Longest::none(*records.first()?);
    let point = |number: &usize| Point { at: vectors[*number], number: *number };
    let top: Vec<Point> = records.iter().map(point).collect();
    pair::compare(&Ends { bottom: top.clone(), top }, &mut longest);
    Some(longest)
}

impl Group {
    fn of(number: usize, unit: Vector, length: f64) -> Group {
        Group {
            sum: unit,
            mean: unit,
            joined: 1.0,
            largest: length,
            members: vec![(number, length)],
        }
    }

    fn join(&mut self, number: usize, unit: Vector, length: f64, magnitude: f64) {
        for (sum, c) in self.sum.iter_mut().zip(unit) {
            *sum += c;
        }
        self.joined += 1.0;
        self.mean = self.sum.map(|c| c / self.joined);
        if length < magnitude * self.largest {
            return;
        }
        if length > self.largest {
            self.largest = length;
            self.members.retain(|(_, other)| *other >= magnitude * length);
        }
        self.members.push((number, length));
    }
}
