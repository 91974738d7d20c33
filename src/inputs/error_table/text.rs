//! Writing an error table: rows in memory → the CSV of contract §2.1.
//!
//! ```text
//!   # comment lines, as given
//!   axis,direction,position_mm,ex_um,u_ex_um,ea_urad
//!   x,+,0,1.5,0.1,-2.25
//! ```
//! Axes in the order X, Y, Z; within an axis the series in the order of the draft. Only what was
//! measured has a column. Numbers are the shortest text that reads back to the same number, lines
//! end with LF: the same draft gives the same bytes everywhere.

use crate::quantity::axis::{Axis, Direction, PerAxis};
use crate::quantity::units::Figure;
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
    pub series: Vec<DraftSeries>,
}

/// All measured positions of one axis in one direction (or without regard to direction).
#[derive(Clone, Debug, PartialEq)]
pub struct DraftSeries {
    /// The moving axis.
    pub axis: Axis,
    /// Direction of travel; `None` = both.
    pub direction: Option<Direction>,
    /// Machine coordinates, mm, strictly ascending.
    pub positions_mm: Vec<f64>,
    /// Deviations in X, Y, Z, µm, one for each position; `None` = not measured.
    pub deviations_um: PerAxis<Option<Vec<f64>>>,
    /// Standard uncertainties (k = 1) of the deviations, µm.
    pub uncertainties_um: PerAxis<Option<Vec<f64>>>,
    /// Rotations about X, Y, Z, µrad, right-handed.
    pub angles_urad: PerAxis<Option<Vec<f64>>>,
    /// Standard uncertainties (k = 1) of the rotations, µrad.
    pub angle_uncertainties_urad: PerAxis<Option<Vec<f64>>>,
}

impl DraftSeries {
    /// A series at positions where nothing was measured yet.
    pub fn new(axis: Axis, direction: Option<Direction>, positions_mm: Vec<f64>) -> DraftSeries {
        DraftSeries {
            axis,
            direction,
            positions_mm,
            deviations_um: PerAxis::default(),
            uncertainties_um: PerAxis::default(),
            angles_urad: PerAxis::default(),
            angle_uncertainties_urad: PerAxis::default(),
        }
    }
}

/// The text of a draft.
pub fn write(draft: &Draft) -> String {
    let columns = measured_columns(draft);
    let directed = draft.series.iter().any(|series| series.direction.is_some());
    let mut header = vec!["axis".to_string()];
    header.extend(directed.then(|| "direction".to_string()));
    header.push("position_mm".to_string());
    header.extend(columns.iter().map(|column| column.name()));
    let of = |axis: Axis| draft.series.iter().filter(move |series| series.axis == axis);
    let rows = Axis::ALL.into_iter().flat_map(of).flat_map(|series| {
        let rows = 0..series.positions_mm.len();
        rows.map(|row| cells(series, row, directed, &columns))
    });
    let table = std::iter::once(header).chain(rows).map(|cells| cells.join(","));
    let comments = draft.comments.iter().map(|comment| plain::comment(comment));
    comments.chain(table).map(|line| line + "\n").collect()
}

fn cells(series: &DraftSeries, row: usize, directed: bool, columns: &[Column]) -> Vec<String> {
    let mut cells = vec![series.axis.key().to_string()];
    if directed {
        cells.push(series.direction.map_or("", Direction::symbol).to_string());
    }
    cells.push(number(series.positions_mm.get(row).copied()));
    for column in columns {
        let values = column.of(series);
        cells.push(number(values.and_then(|values| values.get(row).copied())));
    }
    cells
}

/// Empty = not measured.
fn number(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| Figure(value).to_string())
}

/// What a column of values holds.
#[derive(Clone, Copy)]
enum Column {
    Deviation(Axis),
    Uncertainty(Axis),
    Angle(Axis),
    AngleUncertainty(Axis),
}

impl Column {
    fn name(self) -> String {
        match self {
            Column::Deviation(of) => format!("e{}_um", of.key()),
            Column::Uncertainty(of) => format!("u_e{}_um", of.key()),
            Column::Angle(Axis::X) => "ea_urad".to_string(),
            Column::Angle(Axis::Y) => "eb_urad".to_string(),
            Column::Angle(Axis::Z) => "ec_urad".to_string(),
            Column::AngleUncertainty(about) => format!("u_{}", Column::Angle(about).name()),
        }
    }

    fn of(self, series: &DraftSeries) -> Option<&Vec<f64>> {
        match self {
            Column::Deviation(of) => series.deviations_um[of].as_ref(),
            Column::Uncertainty(of) => series.uncertainties_um[of].as_ref(),
            Column::Angle(about) => series.angles_urad[about].as_ref(),
            Column::AngleUncertainty(about) => series.angle_uncertainties_urad[about].as_ref(),
        }
    }
}

/// Deviations, then angles, then uncertainties; only those that some series holds.
fn measured_columns(draft: &Draft) -> Vec<Column> {
    let kinds: [fn(Axis) -> Column; 4] =
        [Column::Deviation, Column::Angle, Column::Uncertainty, Column::AngleUncertainty];
    let mut columns: Vec<Column> = kinds.into_iter().flat_map(|kind| Axis::ALL.map(kind)).collect();
    columns.retain(|column| draft.series.iter().any(|s| column.of(s).is_some()));
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inputs::error_table::ErrorTable;
    use crate::text::document::Source;

    /// X in both directions with uncertainties, Z without direction and with an angle.
    fn draft() -> Draft {
        let mut plus = DraftSeries::new(Axis::X, Some(Direction::Plus), vec![-0.1, 1.0 / 3.0]);
        plus.deviations_um.x = Some(vec![0.1 + 0.2, -0.0]);
        plus.uncertainties_um.x = Some(vec![1e-7, 2.5]);
        let mut minus = plus.clone();
        minus.direction = Some(Direction::Minus);
        let mut z = DraftSeries::new(Axis::Z, None, vec![-720.0, 1e-9]);
        z.deviations_um.y = Some(vec![f64::MIN_POSITIVE, 123_456.789]);
        z.angles_urad.z = Some(vec![1.0, -2.25]);
        Draft { comments: vec!["first\nline ".to_string()], series: vec![z, plus, minus] }
    }

    fn read(text: &str) -> ErrorTable {
        let source = Source::from_bytes("errors.csv", text.as_bytes()).expect("it is text");
        ErrorTable::read(source).expect("it is a table")
    }

    #[test]
    fn only_what_was_measured_has_a_column() {
        let mut x = DraftSeries::new(Axis::X, None, vec![0.0, 30.0]);
        x.deviations_um.y = Some(vec![0.0, -0.25]);
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
            let mm: Vec<f64> = found.positions.iter().map(|p| p.mm()).collect();
            assert_eq!(mm, wanted.positions_mm);
            for of in Axis::ALL {
                let um =
                    |d: &Vec<crate::quantity::units::Deviation>| d.iter().map(|d| d.um()).collect();
                assert_eq!(found.deviations[of].as_ref().map(um), wanted.deviations_um[of]);
                assert_eq!(found.uncertainties_um[of], wanted.uncertainties_um[of]);
                assert_eq!(found.angles_urad[of], wanted.angles_urad[of]);
            }
        }
    }
}
