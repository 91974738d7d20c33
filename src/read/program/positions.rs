//! The expected positions, read back, and the files of readings that belong to them.

use crate::quantity::{Axis, Diagonal, Direction, Pass, PerAxis};
use crate::text::{Problem, Problems};

/// What a set-up measures, as it is named in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Named {
    /// A body diagonal.
    Diagonal(Diagonal),
    /// A single axis.
    Axis(Axis),
}

/// One row: where a reading is taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Position {
    /// Diagonal or axis.
    pub of: Named,
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

impl Named {
    /// As it stands in the files.
    pub const fn name(self) -> &'static str {
        match self {
            Named::Diagonal(diagonal) => diagonal.name(),
            Named::Axis(axis) => axis.key(),
        }
    }

    /// Direction in which an axis travels on a pass; `None` = it rests.
    pub(crate) fn travelled(self, axis: Axis, pass: Pass) -> Option<Direction> {
        match (self, pass) {
            (Named::Diagonal(diagonal), pass) => Some(diagonal.travelled(axis, pass)),
            (Named::Axis(moving), _) if moving != axis => None,
            (Named::Axis(_), Pass::Forward) => Some(Direction::Plus),
            (Named::Axis(_), Pass::Reverse) => Some(Direction::Minus),
        }
    }
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
        (Some((diagonal, Pass::Forward)), _) => Named::Diagonal(diagonal),
        (_, Some(axis)) => Named::Axis(axis),
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
        (Named::Axis(a), Named::Axis(b)) => a == b,
        _ => true,
    };
    let groups: Vec<&[Position]> = rows.chunk_by(same_file).collect();
    if groups.len() != forms.len() {
        return vec![format!("{} files of readings, expected {}", forms.len(), groups.len())];
    }
    let pairs = groups.into_iter().zip(forms);
    let wrong = pairs.filter(|(group, form)| !is_form_of(group, form));
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
        Named::Axis(axis) => {
            let direction = row.of.travelled(axis, *pass).map_or("", Direction::symbol);
            line.split_once(',').is_some_and(|(target, rest)| {
                target.parse() == Ok(row.place[axis]) && rest == format!("{run},{direction},")
            })
        }
        Named::Diagonal(diagonal) => {
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
