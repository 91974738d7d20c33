//! The expected positions, read back with the files of readings that belong to them; and a walk along a program,
//! which says where it is not what they ask for.

use crate::quantity::{Axis, Diagonal, Direction, Figure, LaserPath, Pass, PerAxis};
use crate::read::lexer::{Complaint, located};
use crate::read::program::blocks::{Action, Cancelled, Step};
use crate::read::refusals;
use crate::text::{Problem, Problems};
use std::collections::BTreeSet;
use std::ops::Range;

/// What a program has to keep.
#[derive(Clone, Debug, Default)]
pub struct Bounds {
    /// Travel of each axis, mm.
    pub travel: PerAxis<(f64, f64)>,
    /// Largest feed of each axis, mm/min, where it is known.
    pub max_feed: PerAxis<Option<f64>>,
    /// Standstill at every node, s.
    pub dwell_s: f64,
    /// The last digit of a position, mm.
    pub digit_mm: f64,
    /// Whether the axes run past the end point before the return pass.
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
    let mut walker = Walker { rows, bounds: bounds.clone(), ..Walker::default() };
    for step in steps {
        walker.at = step.span.clone();
        walker.step(&step.action);
    }
    walker.at = text.len()..text.len();
    walker.finish();
    located(file, text, walker.found).or_ok(Walked {
        reach: walker.reach.unwrap_or_default(),
        cancelled: walker.cancelled,
        readings: walker.read,
    })
}

#[derive(Default)]
struct Walker<'a> {
    rows: &'a [Position],
    bounds: Bounds,
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
    found: Vec<Complaint>,
    /// The block that is walked.
    at: Range<usize>,
}

impl Walker<'_> {
    fn find(&mut self, message: impl Into<String>) {
        self.found.push(Complaint::new(self.at.clone(), refusals::otherwise(message.into())));
    }

    fn step(&mut self, action: &Action) {
        if self.ended {
            return self.find("a block follows the end of the program");
        }
        match action {
            Action::Cancel(what) => {
                if self.here.is_some() {
                    self.find("something is cancelled after the first move");
                }
                self.cancelled.insert(*what);
            }
            Action::Stop => {}
            Action::End => self.ended = true,
            Action::ToMachine(place) => self.approach(place),
            Action::By(by, feed) => self.feed(by, *feed),
            Action::Dwell(seconds, block) => self.dwell(*seconds, *block),
        }
    }

    fn approach(&mut self, place: &PerAxis<Option<f64>>) {
        if self.here.is_some() {
            self.find("machine coordinates are approached a second time");
        }
        for needed in [Cancelled::ToolLength, Cancelled::ToolRadius] {
            if !self.cancelled.contains(&needed) {
                self.find(format!("the first move comes before {needed:?} is cancelled"));
            }
        }
        let together = place.x.or(place.y).is_some();
        if place.z.is_some() && (together || self.approached.x.and(self.approached.y).is_none()) {
            self.find("Z goes to the first place before X and Y are there, or with them");
        }
        for (axis, mm) in place.iter() {
            if let Some(mm) = mm {
                self.approached[axis] = Some(*mm);
                self.judge_travel(axis, *mm);
            }
        }
        if let Some(place) = self.approached.all() {
            self.arrive(place);
        }
    }

    fn feed(&mut self, by: &PerAxis<f64>, feed: f64) {
        let Some(here) = self.here else {
            return self.find("an increment before all three axes are at machine coordinates");
        };
        for axis in Axis::ALL {
            if !self.moves(axis, by) {
                continue;
            }
            self.heading[axis] = Some(match by[axis] > 0.0 {
                true => Direction::Plus,
                false => Direction::Minus,
            });
            self.turned[axis] = true;
            let largest = self.bounds.max_feed[axis];
            if largest.is_some_and(|largest| feed > largest + 1e-3) {
                self.find(format!("the feed of {feed} mm/min is too high for {axis}"));
            }
        }
        self.since.push(*by);
        let place = PerAxis::from_fn(|axis| here[axis] + by[axis]);
        for (axis, mm) in place.iter() {
            self.judge_travel(axis, *mm);
        }
        self.arrive(place);
    }

    fn moves(&self, axis: Axis, by: &PerAxis<f64>) -> bool {
        by[axis].abs() >= self.bounds.digit_mm / 2.0
    }

    fn judge_travel(&mut self, axis: Axis, mm: f64) {
        let (low, high) = self.bounds.travel[axis];
        let slack = self.bounds.digit_mm / 10.0;
        if mm < low - slack || mm > high + slack {
            let mm = Figure(mm);
            self.find(format!(
                "{axis} is sent to {mm:.4} mm, outside its travel {low} … {high} mm"
            ));
        }
    }

    fn arrive(&mut self, place: PerAxis<f64>) {
        let reach = self.reach;
        self.reach = Some(PerAxis::from_fn(|axis| {
            let (low, high) = reach.map_or((place[axis], place[axis]), |reach| reach[axis]);
            (low.min(place[axis]), high.max(place[axis]))
        }));
        self.here = Some(place);
    }

    fn dwell(&mut self, seconds: f64, block: Option<f64>) {
        let rows = self.rows;
        let Some(row) = rows.get(self.read) else {
            return self.find("a standstill that belongs to no reading");
        };
        let wanted = self.bounds.dwell_s;
        if seconds < wanted - 1e-3 {
            self.find(format!("the standstill is {seconds} s, expected {wanted} s"));
        }
        if block.is_none_or(|block| (block - f64::from(row.block)).abs() > 0.0) {
            let number = row.block;
            self.find(format!("the block of reading {number} has another number"));
        }
        self.judge_place(row);
        self.judge_step(row);
        self.judge_headings(row);
        self.since.clear();
        if row.pass == Pass::Forward {
            self.turned = PerAxis::default();
        }
        self.read += 1;
    }

    fn judge_place(&mut self, row: &Position) {
        let Some(here) = self.here else {
            return self.find("a reading before any position");
        };
        for axis in Axis::ALL {
            let (is, wanted) = (here[axis], row.place[axis]);
            if (is - wanted).abs() > self.bounds.digit_mm / 10.0 {
                let (node, is) = (row.node, Figure(is));
                self.find(format!(
                    "node {node} is read at {axis} {is:.4} mm, expected {wanted} mm"
                ));
            }
        }
    }

    /// Between two nodes of a pass lies one move: of the axis that `moved` names on the forward
    /// path, of all axes where it names none.
    fn judge_step(&mut self, row: &Position) {
        let before = self.read.checked_sub(1).map(|index| &self.rows[index]);
        let Some(before) = before.filter(|b| (b.run, b.pass) == (row.run, row.pass)) else {
            return;
        };
        let moved = match row.pass {
            Pass::Forward => row.moved,
            Pass::Reverse => before.moved,
        };
        let is_right = |by: &PerAxis<f64>| {
            let mut axes = Axis::ALL.into_iter();
            axes.all(|axis| self.moves(axis, by) == moved.is_none_or(|moved| moved == axis))
        };
        if !matches!(self.since.as_slice(), [by] if is_right(by)) {
            let node = row.node;
            self.find(format!("node {node} is not reached by one move of its own"));
        }
    }

    /// Every measured axis has arrived in the direction of the pass. Where it turns without
    /// overrun, an axis keeps its heading until it moves: that step shows its reversal.
    fn judge_headings(&mut self, row: &Position) {
        for axis in Axis::ALL {
            let Some(wanted) = row.of.travelled(axis, row.pass) else {
                continue;
            };
            let turning = row.pass == Pass::Reverse && !self.bounds.overrun && !self.turned[axis];
            if self.heading[axis] != Some(wanted) && !turning {
                let (node, wanted) = (row.node, wanted.symbol());
                self.find(format!("{axis} has not arrived at node {node} moving {wanted}"));
            }
        }
    }

    fn finish(&mut self) {
        if !self.ended {
            self.find("the program has no end");
        }
        let (read, rows) = (self.read, self.rows.len());
        if read < rows {
            self.find(format!("{read} of {rows} readings are taken"));
        }
    }
}

// The expected positions, read back, and the files of readings that belong to them.

/// One row: where a reading is taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Position {
    /// Diagonal or axis.
    pub of: LaserPath,
    /// Number of the run.
    pub run: u32,
    /// Forward or reverse.
    pub pass: Pass,
    /// Node along the forward path.
    pub node: usize,
    /// Axis of the forward step to this node.
    pub moved: Option<Axis>,
    /// Nominal displacement, mm.
    pub nominal_mm: f64,
    /// Machine coordinates, mm.
    pub place: PerAxis<f64>,
    /// Number of the block that stands still there.
    pub block: u32,
}

/// Reads the file.
pub fn read(file: &str, bytes: &[u8]) -> Result<Vec<Position>, Problems> {
    let text =
        std::str::from_utf8(bytes).map_err(|_| Problem::new(format!("`{file}` is no text")))?;
    let rows = text.lines().enumerate().skip(1);
    let position = |(index, line)| {
        let wrong = || format!("`{file}`, line {}: `{line}` is no position", index + 1);
        row(line).ok_or_else(|| Problem::new(wrong()).into())
    };
    rows.map(position).collect()
}

fn row(line: &str) -> Option<Position> {
    let cells: Vec<&str> = line.split(',').collect();
    let [of, run, pass, node, moved, nominal, x, y, z, block] = cells.try_into().ok()?;
    let number = |text: &str| text.parse::<f64>().ok().filter(|number| number.is_finite());
    let of = match (Diagonal::from_name(of), Axis::from_letter(of)) {
        (Some((diagonal, Pass::Forward)), _) => LaserPath::Diagonal(diagonal),
        (_, Some(axis)) => LaserPath::Axis(axis),
        _ => return None,
    };
    let [x, y, z] = [x, y, z].map(number);
    Some(Position {
        of,
        run: run.parse().ok()?,
        pass: Pass::BOTH.into_iter().find(|known| known.word() == pass)?,
        node: node.parse().ok()?,
        moved: match moved {
            "" => None,
            letter => Some(Axis::from_letter(letter)?),
        },
        nominal_mm: number(nominal)?,
        place: PerAxis { x, y, z }.all()?,
        block: block.parse().ok()?,
    })
}

/// What the files of readings say otherwise than the positions, at most one sentence for each file.
/// Single axes have a file each; all diagonals are in one.
pub(crate) fn form_differences(rows: &[Position], forms: &[&[u8]]) -> Vec<String> {
    let same_file = |a: &Position, b: &Position| match (a.of, b.of) {
        (LaserPath::Axis(a), LaserPath::Axis(b)) => a == b,
        _ => true,
    };
    let groups: Vec<&[Position]> = rows.chunk_by(same_file).collect();
    if groups.len() != forms.len() {
        return vec![format!("{} files of readings, expected {}", forms.len(), groups.len())];
    }
    let wrong = groups.into_iter().zip(forms).filter(|(group, form)| !is_form_of(group, form));
    let words = |row: &Position| {
        let name = row.of.name();
        format!("the file of readings that begins with {name} has other rows than positions.csv")
    };
    wrong.map(|(group, _)| words(&group[0])).collect()
}

/// Whether a file asks for the readings of these rows, in their order, and states none of them.
fn is_form_of(rows: &[Position], form: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(form) else {
        return false;
    };
    let has_moved = text.lines().next().is_some_and(|l| l.contains(",moved,"));
    let lines: Vec<&str> = text.lines().skip(1).collect();
    let mut pairs = rows.iter().zip(&lines);
    lines.len() == rows.len() && pairs.all(|(row, line)| asks_for(row, line, has_moved))
}

fn asks_for(row: &Position, line: &str, has_moved: bool) -> bool {
    let Position { run, pass, node, .. } = row;
    match row.of {
        LaserPath::Axis(axis) => {
            let direction = row.of.travelled(axis, *pass).map_or("", Direction::symbol);
            line.split_once(',').is_some_and(|(target, rest)| {
                target.parse() == Ok(row.place[axis]) && rest == format!("{run},{direction},")
            })
        }
        LaserPath::Diagonal(diagonal) => {
            let moved = row.moved.map_or("", Axis::key);
            let moved = match has_moved {
                true => format!(",{moved}"),
                false => moved.to_string(), // which no line without the column ends with
            };
            let (of, pass) = (diagonal.name(), pass.word());
            line == format!("{of},{run},{pass},{node}{moved},")
        }
    }
}
