//! Several error tables of one machine → one: a laser measures an axis a file.
//!
//! Every component of an axis comes from one table: two files have two zeros, and what lies between
//! them is not measured.

use crate::inputs::error_table::{ErrorTable, Series};
use crate::quantity::axis::{Axis, Direction};
use crate::text::problem::{Problem, Problems};

/// Ends of a range that are nearer than this are the same, mm.
const SAME_MM: f64 = 1e-6;

impl ErrorTable {
    /// One table with the series of all; `None` = there is none. What stands in two of them, or
    /// does not fit together, is a problem at its first row.
    pub fn merged(tables: Vec<ErrorTable>) -> Result<Option<ErrorTable>, Problems> {
        let mut problems = Problems::none();
        let mut tables = tables.into_iter();
        let Some(mut whole) = tables.next() else {
            return Ok(None);
        };
        for other in tables {
            for axis in Axis::ALL {
                whole.refuse_what_does_not_fit(axis, &other, &mut problems);
            }
            whole.add(other);
        }
        problems.or_ok(Some(whole))
    }

    fn add(&mut self, other: ErrorTable) {
        let before = self.more.len() + 1;
        self.more.push(other.source);
        self.more.extend(other.more);
        self.headings.extend(other.headings);
        self.remarks.extend(other.remarks);
        for axis in Axis::ALL {
            let series = other.series[axis].iter().cloned();
            self.series[axis].extend(series.map(|series| Series {
                table: before + series.table,
                ..series
            }));
        }
    }

    fn refuse_what_does_not_fit(&self, axis: Axis, other: &ErrorTable, problems: &mut Problems) {
        let Some(new) = other.series[axis].first() else {
            return;
        };
        let known = &self.series[axis];
        let twin = known.iter().find(|old| !shared(old, new, axis).is_empty());
        let refused = if let Some(old) = twin {
            let names = shared(old, new, axis).join(", ");
            Some((
                format!(
                    "{names} stands in two tables, `{}` and `{}`",
                    self.name(old),
                    other.source.name
                ),
                "give each component of an axis in one table: the zeros of two measurements differ by what nobody measured",
            ))
        } else if known
            .iter()
            .any(|old| old.direction.is_some() != new.direction.is_some())
        {
            Some((
                format!("axis {axis} is given with directions in one table and without in another"),
                "measure all components of an axis with `+` and `-`, or import them with `--direction both`",
            ))
        } else if self.other_range(axis, &other.series[axis]) {
            Some((
                format!("axis {axis} was measured over another range than in the table before"),
                "measure the components of an axis over the same range, in machine coordinates",
            ))
        } else {
            None
        };
        if let Some((message, help)) = refused {
            let problem = Problem::new(message).help(help);
            problems.push(match other.place(new, 0) {
                Some(place) => problem.at(place),
                None => problem,
            });
        }
    }

    fn name(&self, series: &Series) -> &str {
        self.source_of(series).map_or("", |s| s.name.as_str())
    }

    fn other_range(&self, axis: Axis, new: &[Series]) -> bool {
        let same_direction = |direction: Option<Direction>| {
            let known = self.series[axis].iter();
            known.filter(move |old| old.direction == direction)
        };
        let differ = |old: &Series, new: &Series| {
            ends(old)
                .iter()
                .zip(ends(new))
                .any(|(old, new)| (old - new).abs() > SAME_MM)
        };
        new.iter()
            .any(|new| same_direction(new.direction).any(|old| differ(old, new)))
    }
}

fn ends(series: &Series) -> Vec<f64> {
    let ends = [series.positions.first(), series.positions.last()];
    ends.into_iter().flatten().map(|end| end.mm()).collect()
}

/// Components of an axis that both series hold, e.g. `EXX`.
fn shared(old: &Series, new: &Series, axis: Axis) -> Vec<String> {
    let deviations = Axis::ALL.into_iter().filter_map(|of| {
        let both = old.deviations[of].is_some() && new.deviations[of].is_some();
        both.then(|| format!("E{of}{axis}"))
    });
    let about = Axis::ALL.into_iter().zip(['A', 'B', 'C']);
    let angles = about.filter_map(|(about, letter)| {
        let both = old.angles_urad[about].is_some() && new.angles_urad[about].is_some();
        both.then(|| format!("E{letter}{axis}"))
    });
    deviations.chain(angles).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::expect_used, reason = "a test that cannot go on has to stop")]

    use super::*;
    use crate::text::document::Source;

    fn table(name: &str, text: &str) -> ErrorTable {
        let source = Source::from_bytes(name, text.as_bytes()).expect("it is text");
        ErrorTable::read(source).expect("it is a table")
    }

    fn said(tables: Vec<ErrorTable>) -> String {
        ErrorTable::merged(tables).map_or_else(|p| p.render(), |_| String::new())
    }

    #[test]
    fn each_row_keeps_its_file_and_line() {
        let merged = ErrorTable::merged(vec![
            table("x.csv", "axis,position_mm,ex_um\nx,0,0\nx,9,1\n"),
            table("y.csv", "# laser\naxis,position_mm,ey_um\ny,0,0\ny,9,2\n"),
            table("xs.csv", "axis,position_mm,ey_um\nx,0,0\nx,4,1\nx,9,3\n"),
        ]);
        let merged = merged.expect("they fit").expect("there are some");
        let places: Vec<(String, usize)> = [(Axis::X, 0), (Axis::Y, 0), (Axis::X, 1)]
            .into_iter()
            .filter_map(|(axis, n)| merged.place(&merged.series(axis)[n], 1))
            .map(|place| (place.file, place.line))
            .collect();
        let expected = [("x.csv", 3), ("y.csv", 4), ("xs.csv", 3)];
        assert_eq!(
            places,
            expected.map(|(file, line)| (file.to_string(), line))
        );
    }

    #[test]
    fn what_does_not_fit_together_is_refused() {
        let x = || table("x.csv", "axis,position_mm,ex_um\nx,0,0\nx,9,1\n");
        let again = table(
            "a.csv",
            "axis,direction,position_mm,ex_um,ey_um\nx,+,0,0,0\nx,+,9,1,0\n",
        );
        let directed = table(
            "d.csv",
            "axis,direction,position_mm,ey_um\nx,+,0,0\nx,+,9,1\n",
        );
        let shorter = table("s.csv", "axis,position_mm,ey_um\nx,0,0\nx,8,1\n");
        assert!(said(vec![x(), again]).contains("EXX stands in two tables, `x.csv` and `a.csv`"));
        assert!(said(vec![x(), directed]).contains("with directions in one table"));
        assert!(said(vec![x(), shorter]).contains("another range"));
    }
}
