//! Writing an error table: rows in memory → the CSV of contract §2.1.
//!
//! ```text
//!   # comment lines, as given
//!   axis,direction,position_mm,ex_um,ea_urad,u_ex_um
//!   x,+,0,1.5,-2.25,0.1
//! ```
//! Axes in the order X, Y, Z; within an axis the series in the order of the draft. Only what was
//! measured has a column. Numbers are the shortest text that reads back to the same number, lines
//! end with LF: the same draft gives the same bytes everywhere.

use crate::inputs::error_table::read::{Series, known_columns};
use crate::inputs::table::{Column, Content};
use crate::quantity::{Axis, Direction, Figure};
use crate::text::plain;

/// An error table that is going to be written.
///
/// Whoever fills it keeps to the rules of the format: positions strictly ascending, as many values
/// as positions, an axis either with directions or without. [`super::ErrorTable::read`] judges
/// what was written like any other table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Draft {
    /// Lines above the header, without their `#`.
    pub comments: Vec<String>,
    /// The measured curves.
    pub series: Vec<Series>,
}

/// The text of a draft.
pub fn write(draft: &Draft) -> String {
    let columns = columns(draft);
    let header = columns.iter().map(|column| column.name.clone()).collect::<Vec<String>>();
    let of = |axis: Axis| draft.series.iter().filter(move |series| series.axis == axis);
    let rows = Axis::ALL.into_iter().flat_map(of).flat_map(|series| {
        let columns = &columns;
        let rows = 0..series.positions.len();
        rows.map(|row| columns.iter().map(|column| cell(series, column.content, row)).collect())
    });
    let table = std::iter::once(header).chain(rows).map(|cells| cells.join(","));
    let comments = draft.comments.iter().map(|comment| plain::comment(comment));
    comments.chain(table).map(|line| line + "\n").collect()
}

/// Empty = not measured.
fn cell(series: &Series, holds: Content, row: usize) -> String {
    match holds {
        Content::Axis => series.axis.key().to_string(),
        Content::Direction => series.direction.map_or("", Direction::symbol).to_string(),
        _ => series.number(holds, row).map_or_else(String::new, |it| Figure(it).to_string()),
    }
}

/// Where and which way, then deviations, angles and uncertainties; only those that some series holds.
fn columns(draft: &Draft) -> Vec<Column> {
    let mut columns = known_columns();
    columns.dedup_by_key(|column| column.content);
    columns.retain(|column| {
        let is_held = |series: &Series| !cell(series, column.content, 0).is_empty();
        let is_needed = matches!(column.content, Content::Axis | Content::Position);
        is_needed || draft.series.iter().any(is_held)
    });
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inputs::error_table::ErrorTable;
    use crate::quantity::{Deviation, Millimetres};
    use crate::text::Source;

    fn series(axis: Axis, direction: Option<Direction>, mm: &[f64]) -> Series {
        Series::new(axis, direction, mm.iter().copied().map(Millimetres::new).collect())
    }

    fn um(um: &[f64]) -> Option<Vec<Deviation>> {
        Some(um.iter().copied().map(Deviation::from_um).collect())
    }

    /// X in both directions with uncertainties, Z without direction and with an angle.
    fn draft() -> Draft {
        let mut plus = series(Axis::X, Some(Direction::Plus), &[-0.1, 1.0 / 3.0]);
        plus.deviations.x = um(&[0.1 + 0.2, -0.0]);
        plus.uncertainties_um.x = Some(vec![1e-7, 2.5]);
        let mut minus = plus.clone();
        minus.direction = Some(Direction::Minus);
        let mut z = series(Axis::Z, None, &[-720.0, 1e-9]);
        z.deviations.y = um(&[f64::MIN_POSITIVE, 123_456.789]);
        z.angles_urad.z = Some(vec![1.0, -2.25]);
        Draft { comments: vec!["first\nline ".to_string()], series: vec![z, plus, minus] }
    }

    fn read(text: &str) -> ErrorTable {
        let source = Source::from_bytes("errors.csv", text.as_bytes()).expect("it is text");
        ErrorTable::read(source).expect("it is a table")
    }

    #[test]
    fn only_what_was_measured_has_a_column() {
        let mut x = series(Axis::X, None, &[0.0, 30.0]);
        x.deviations.y = um(&[0.0, -0.25]);
        let draft = Draft { comments: vec!["made by hand".to_string()], series: vec![x] };
        let expected = "# made by hand\naxis,position_mm,ey_um\nx,0,0\nx,30,-0.25\n";
        assert_eq!(write(&draft), expected);
    }

    #[test]
    fn comments_come_first_and_axes_in_their_order() {
        let text = write(&draft());
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "# first�line");
        assert_eq!(lines[1], "axis,direction,position_mm,ex_um,ey_um,ec_urad,u_ex_um");
        assert_eq!(lines[2], "x,+,-0.1,0.30000000000000004,,,0.0000001");
        assert!(lines[6].starts_with("z,,-720,,"), "{}", lines[6]);
        assert!(!text.contains('\r') && text.ends_with('\n'));
    }

    #[test]
    fn what_is_written_reads_back_to_the_same_numbers() {
        let draft = draft();
        let text = write(&draft);
        assert!(!text.contains(&"0".repeat(20)), "{text}");
        let table = read(&text);
        for wanted in &draft.series {
            let found = table.series(wanted.axis);
            let found = found.iter().find(|s| s.direction == wanted.direction);
            let found = found.expect("the series is there");
            let wanted = Series { lines: found.lines.clone(), ..wanted.clone() };
            assert_eq!(*found, wanted);
        }
    }
}
