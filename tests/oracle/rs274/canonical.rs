//! The canonical calls that `rs274` prints, as length and box of the feed moves in machine coordinates, mm.

use std::f64::consts::TAU;

/// Length of the feed moves, and from where to where they reach along each axis.
#[derive(Debug)]
pub(crate) struct Walked {
    pub(crate) length_mm: f64,
    pub(crate) reach_mm: [[f64; 2]; 3],
}

impl Walked {
    pub(crate) fn nowhere() -> Walked {
        Walked { length_mm: 0.0, reach_mm: [[f64::INFINITY, f64::NEG_INFINITY]; 3] }
    }

    pub(crate) fn reach(&mut self, place: [f64; 3]) {
        for ([least, most], mm) in self.reach_mm.iter_mut().zip(place) {
            (*least, *most) = (least.min(mm), most.max(mm));
        }
    }
}

struct Canon {
    mm: f64,
    plane: [usize; 3],
    /// G54 …, G92, tool, mm.
    zeros: [[f64; 3]; 3],
    /// Machine coordinates, mm.
    at: [f64; 3],
    walked: Walked,
}

pub(crate) fn walked(calls: &str) -> Walked {
    let (walked, plane, zeros) = (Walked::nowhere(), [0, 1, 2], [[0.0; 3]; 3]);
    let mut canon = Canon { mm: 1.0, plane, zeros, at: [0.0; 3], walked };
    for line in calls.lines() {
        // `  12 N40    STRAIGHT_FEED(1.0000, …)`
        let call = line.split_once('N').map_or("", |(_, call)| call);
        let call = call.split_once(' ').map_or("", |(_, call)| call.trim_start());
        let (name, rest) = call.split_once('(').unwrap_or((call, ""));
        let words = rest.split([',', ' ', ')']).filter(|word| !word.is_empty());
        canon.call(name, rest, &words.filter_map(|word| word.parse().ok()).collect::<Vec<f64>>());
    }
    canon.walked
}

impl Canon {
    fn call(&mut self, name: &str, rest: &str, numbers: &[f64]) {
        match name {
            "USE_LENGTH_UNITS" => self.mm = if rest.contains("INCHES") { 25.4 } else { 1.0 },
            "SELECT_PLANE" => {
                self.plane = match rest {
                    "CANON_PLANE_XY)" => [0, 1, 2],
                    "CANON_PLANE_XZ)" => [2, 0, 1],
                    "CANON_PLANE_YZ)" => [1, 2, 0],
                    other => panic!("plane {other}"),
                }
            }
            "SET_G5X_OFFSET" => self.zeros[0] = self.three(&numbers[1..]),
            "SET_G92_OFFSET" => self.zeros[1] = self.three(numbers),
            "USE_TOOL_LENGTH_OFFSET" => self.zeros[2] = self.three(numbers),
            "STRAIGHT_TRAVERSE" => self.at = self.machine(numbers),
            "STRAIGHT_FEED" => self.feed(numbers),
            "ARC_FEED" => self.arc(numbers),
            _ => {}
        }
    }

    fn three(&self, numbers: &[f64]) -> [f64; 3] {
        [0, 1, 2].map(|axis| numbers[axis] * self.mm)
    }

    fn machine(&self, numbers: &[f64]) -> [f64; 3] {
        let program = self.three(numbers);
        [0, 1, 2].map(|axis| program[axis] + self.zeros.map(|zero| zero[axis]).iter().sum::<f64>())
    }

    fn feed(&mut self, numbers: &[f64]) {
        let to = self.machine(numbers);
        let way = [0, 1, 2].map(|axis| to[axis] - self.at[axis]);
        let length = way[0].hypot(way[1]).hypot(way[2]);
        if length > 0.0 {
            self.walked.reach(self.at);
            self.walked.reach(to);
        }
        self.walked.length_mm += length;
        self.at = to;
    }

    /// Ends and centre in the plane, turns, end of the third axis.
    fn arc(&mut self, numbers: &[f64]) {
        let [first, second, third] = self.plane;
        let mut program = [0.0; 3];
        (program[first], program[second], program[third]) = (numbers[0], numbers[1], numbers[5]);
        let to = self.machine(&program);
        (program[first], program[second]) = (numbers[2], numbers[3]);
        let centre = self.machine(&program);
        let angle =
            |place: [f64; 3]| (place[second] - centre[second]).atan2(place[first] - centre[first]);
        let from = angle(self.at);
        let sign = numbers[4].signum();
        let gap = (to[first] - self.at[first]).hypot(to[second] - self.at[second]);
        let part = (sign * (angle(to) - from)).rem_euclid(TAU);
        let sweep = if gap < 1e-6 { TAU } else { part } + (numbers[4].abs() - 1.0) * TAU;
        let start = self.at;
        let radius = (start[first] - centre[first]).hypot(start[second] - centre[second]);
        self.walked.reach(start);
        self.walked.reach(to);
        for quarter in 0..4 {
            let place = f64::from(quarter) * TAU / 4.0;
            if (sign * (place - from)).rem_euclid(TAU) < sweep {
                let mut extreme = to;
                extreme[first] = centre[first] + radius * place.cos();
                extreme[second] = centre[second] + radius * place.sin();
                extreme[third] = start[third];
                self.walked.reach(extreme);
            }
        }
        self.walked.length_mm += (radius * sweep).hypot(to[third] - start[third]);
        self.at = to;
    }
}
