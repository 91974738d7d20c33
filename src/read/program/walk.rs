//! Walks a program and says where it is not what it should be.

use crate::quantity::axis::{Axis, Direction, PerAxis};
use crate::quantity::diagonal::Pass;
use crate::quantity::units::Figure;
use crate::read::program::positions::Position;
use crate::read::program::{Cancelled, Deed, Step};
use crate::text::problem::{Place, Problem, Problems};
use std::collections::BTreeSet;
use std::ops::Range;

/// What a program has to keep.
#[derive(Clone, Debug)]
pub struct Bounds {
    /// Travel of each axis, mm.
    pub travel: PerAxis<(f64, f64)>,
    /// Largest feed of each axis, mm/min, where it is known.
    pub max_feed: PerAxis<Option<f64>>,
    /// Standstill at every node, s.
    pub dwell_s: f64,
    /// The last digit of a position, mm.
    pub digit_mm: f64,
    /// Whether the axes run over the far end before the way back.
    pub overrun: bool,
}

/// What was found on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct Walked {
    /// Smallest and largest commanded coordinate, mm.
    pub reach: PerAxis<(f64, f64)>,
    /// What the program cancels before it moves.
    pub cancelled: BTreeSet<Cancelled>,
    /// Standstills that were read.
    pub readings: usize,
}

/// Walks the steps of a program along the rows of its readings. All problems are given at once.
pub fn walk(
    (file, text): (&str, &str),
    steps: &[Step],
    rows: &[Position],
    bounds: &Bounds,
) -> Result<Walked, Problems> {
    let mut walker = Walker {
        rows,
        bounds,
        here: None,
        approached: PerAxis::default(),
        heading: PerAxis::default(),
        since: Vec::new(),
        turned: PerAxis::default(),
        read: 0,
        ended: false,
        cancelled: BTreeSet::new(),
        reach: None,
        found: Vec::new(),
    };
    for step in steps {
        walker.step(step);
    }
    walker.finish(text.len());
    let mut problems = Problems::none();
    for (span, message) in &walker.found {
        let place = Place::in_text(file, text, span.start, span.end);
        problems.push(
            Problem::new(message.clone())
                .at(place)
                .help("this program must not be used; nothing was written"),
        );
    }
    problems.or_ok(Walked {
        reach: walker.reach.unwrap_or_default(),
        cancelled: walker.cancelled,
        readings: walker.read,
    })
}

struct Walker<'a> {
    rows: &'a [Position],
    bounds: &'a Bounds,
    /// Where the axes are, once all three have gone to machine coordinates.
    here: Option<PerAxis<f64>>,
    /// Axes that have gone to machine coordinates.
    approached: PerAxis<Option<f64>>,
    /// Direction in which each axis moved last.
    heading: PerAxis<Option<Direction>>,
    /// Moves since the last standstill.
    since: Vec<PerAxis<f64>>,
    /// Whether an axis has moved since the last reading forward.
    turned: PerAxis<bool>,
    read: usize,
    ended: bool,
    cancelled: BTreeSet<Cancelled>,
    reach: Option<PerAxis<(f64, f64)>>,
    found: Vec<(Range<usize>, String)>,
}

impl Walker<'_> {
    fn find(&mut self, span: &Range<usize>, message: String) {
        self.found.push((span.clone(), message));
    }

    fn step(&mut self, step: &Step) {
        if self.ended {
            self.find(
                &step.span,
                "a block follows the end of the program".to_string(),
            );
            return;
        }
        match &step.deed {
            Deed::Cancel(what) => {
                if self.here.is_some() {
                    self.find(
                        &step.span,
                        "something is cancelled after the first move".to_string(),
                    );
                }
                self.cancelled.insert(*what);
            }
            Deed::Stop => {}
            Deed::End => self.ended = true,
            Deed::ToMachine(place) => self.approach(place, &step.span),
            Deed::By(by, feed) => self.feed(by, *feed, &step.span),
            Deed::Dwell(seconds, block) => self.dwell(*seconds, *block, &step.span),
        }
    }

    fn approach(&mut self, place: &PerAxis<Option<f64>>, span: &Range<usize>) {
        if self.here.is_some() {
            self.find(
                span,
                "machine coordinates are approached a second time".to_string(),
            );
        }
        for needed in [Cancelled::ToolLength, Cancelled::ToolRadius] {
            if !self.cancelled.contains(&needed) {
                self.find(
                    span,
                    format!("the first move comes before {needed:?} is cancelled"),
                );
            }
        }
        let together = place.x.or(place.y).is_some();
        if place.z.is_some() && (together || self.approached.x.and(self.approached.y).is_none()) {
            let message = "Z goes to the first place before X and Y are there, or with them";
            self.find(span, message.to_string());
        }
        for (axis, mm) in place.iter() {
            if let Some(mm) = mm {
                self.approached[axis] = Some(*mm);
                self.judge_travel(axis, *mm, span);
            }
        }
        let PerAxis { x, y, z } = self.approached;
        if let (Some(x), Some(y), Some(z)) = (x, y, z) {
            self.arrive(PerAxis { x, y, z });
        }
    }

    fn feed(&mut self, by: &PerAxis<f64>, feed: f64, span: &Range<usize>) {
        let Some(here) = self.here else {
            self.find(
                span,
                "an increment before all three axes are at machine coordinates".to_string(),
            );
            return;
        };
        for axis in Axis::ALL {
            let way = by[axis];
            if way.abs() < self.bounds.digit_mm / 2.0 {
                continue;
            }
            let direction = if way > 0.0 {
                Direction::Plus
            } else {
                Direction::Minus
            };
            self.heading[axis] = Some(direction);
            self.turned[axis] = true;
            let largest = self.bounds.max_feed[axis];
            if largest.is_some_and(|largest| feed > largest + 1e-3) {
                self.find(
                    span,
                    format!("the feed of {feed} mm/min is too high for {axis}"),
                );
            }
        }
        self.since.push(*by);
        let place = PerAxis::from_fn(|axis| here[axis] + by[axis]);
        for (axis, mm) in place.iter() {
            self.judge_travel(axis, *mm, span);
        }
        self.arrive(place);
    }

    fn judge_travel(&mut self, axis: Axis, mm: f64, span: &Range<usize>) {
        let (low, high) = self.bounds.travel[axis];
        let slack = self.bounds.digit_mm / 10.0;
        if mm < low - slack || mm > high + slack {
            self.find(
                span,
                format!(
                    "{axis} is sent to {:.4} mm, outside its travel {low} … {high} mm",
                    Figure(mm)
                ),
            );
        }
    }

    fn arrive(&mut self, place: PerAxis<f64>) {
        let reach = self
            .reach
            .unwrap_or(PerAxis::from_fn(|axis| (place[axis], place[axis])));
        self.reach = Some(PerAxis::from_fn(|axis| {
            (
                reach[axis].0.min(place[axis]),
                reach[axis].1.max(place[axis]),
            )
        }));
        self.here = Some(place);
    }

    fn dwell(&mut self, seconds: f64, block: Option<u32>, span: &Range<usize>) {
        let rows = self.rows;
        let Some(row) = rows.get(self.read) else {
            self.find(span, "a standstill that belongs to no reading".to_string());
            return;
        };
        if seconds < self.bounds.dwell_s - 1e-3 {
            self.find(
                span,
                format!(
                    "the standstill is {seconds} s, expected {} s",
                    self.bounds.dwell_s
                ),
            );
        }
        if block != Some(row.block) {
            self.find(
                span,
                format!("the block of reading {} has another number", row.block),
            );
        }
        self.judge_place(row, span);
        self.judge_step(row, span);
        self.judge_headings(row, span);
        self.since.clear();
        if row.pass == Pass::Forward {
            self.turned = PerAxis::default();
        }
        self.read += 1;
    }

    fn judge_place(&mut self, row: &Position, span: &Range<usize>) {
        let Some(here) = self.here else {
            self.find(span, "a reading before any position".to_string());
            return;
        };
        for axis in Axis::ALL {
            if (here[axis] - row.place[axis]).abs() > self.bounds.digit_mm / 10.0 {
                self.find(
                    span,
                    format!(
                        "node {} is read at {axis} {:.4} mm, expected {} mm",
                        row.node,
                        Figure(here[axis]),
                        row.place[axis]
                    ),
                );
            }
        }
    }

    /// Between two nodes of a pass lies one move: of the axis that `moved` names on the forward
    /// path, of all axes where it names none.
    fn judge_step(&mut self, row: &Position, span: &Range<usize>) {
        let Some(before) = self
            .read
            .checked_sub(1)
            .and_then(|index| self.rows.get(index))
        else {
            return;
        };
        if (before.run, before.pass) != (row.run, row.pass) {
            return;
        }
        let moved = match row.pass {
            Pass::Forward => row.moved,
            Pass::Reverse => before.moved,
        };
        let moves = |axis: Axis, by: &PerAxis<f64>| by[axis].abs() > self.bounds.digit_mm / 2.0;
        let right = match self.since.as_slice() {
            [by] => Axis::ALL.iter().all(|axis| match moved {
                Some(moved) => moves(*axis, by) == (*axis == moved),
                None => moves(*axis, by),
            }),
            _ => false,
        };
        if !right {
            self.find(
                span,
                format!("node {} is not reached by one move of its own", row.node),
            );
        }
    }

    /// Every measured axis has arrived in the direction of the pass. Where it turns without
    /// overrun, an axis keeps its heading until it moves: that step shows its reversal.
    fn judge_headings(&mut self, row: &Position, span: &Range<usize>) {
        for axis in Axis::ALL {
            let Some(wanted) = row.of.travelled(axis, row.pass) else {
                continue;
            };
            let turning = row.pass == Pass::Reverse && !self.bounds.overrun && !self.turned[axis];
            if self.heading[axis] != Some(wanted) && !turning {
                self.find(
                    span,
                    format!(
                        "{axis} has not arrived at node {} moving {}",
                        row.node,
                        wanted.symbol()
                    ),
                );
            }
        }
    }

    fn finish(&mut self, end: usize) {
        if !self.ended {
            self.find(&(end..end), "the program has no end".to_string());
        }
        if self.read < self.rows.len() {
            self.find(
                &(end..end),
                format!("{} of {} readings are taken", self.read, self.rows.len()),
            );
        }
    }
}
