//! Header of an error table → what each column holds.

use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::units::MM_PER_INCH;
use crate::text::delimited::{Expected, LENGTHS_UM, Line, columns_of};
use crate::text::problem::{Place, Problem, Problems};

/// What a column holds; factors turn the column's unit into mm, µm or µrad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Column {
    Axis,
    Direction,
    Position { to_mm: f64 },
    Deviation { of: Axis, to_um: f64 },
    Uncertainty { of: Axis, to_um: f64 },
    Angle { about: Axis, to_urad: f64 },
    AngleUncertainty { about: Axis },
}

/// The heading of a column of deviations.
#[derive(Clone, Debug, PartialEq)]
pub struct Heading {
    /// As it is written, e.g. `ex_mm`.
    pub name: String,
    /// Micrometres in its unit.
    pub to_um: f64,
    /// Where it stands.
    pub place: Place,
}

impl Heading {
    /// The same heading for values in micrometres, e.g. `ex_um`.
    pub(crate) fn in_micrometres(&self) -> String {
        let quantity = self.name.rsplit_once('_').map(|(quantity, _)| quantity);
        format!("{}_um", quantity.unwrap_or(&self.name))
    }
}

pub(super) const FIRST_LINE: &str = "first line: axis,position_mm,ex_um,ey_um,ez_um";

const MRAD: f64 = 1000.0;
/// Microradians in one second of arc.
const ARCSEC: f64 = std::f64::consts::PI / (180.0 * 3600.0) * 1e6;

fn known_columns() -> Vec<(String, Column)> {
    let mut known = vec![
        ("axis".to_string(), Column::Axis),
        ("direction".to_string(), Column::Direction),
        ("position_mm".to_string(), Column::Position { to_mm: 1.0 }),
        (
            "position_in".to_string(),
            Column::Position { to_mm: MM_PER_INCH },
        ),
    ];
    let angles = [("urad", 1.0), ("mrad", MRAD), ("arcsec", ARCSEC)];
    for (of, letter, angle) in [
        (Axis::X, 'x', 'a'),
        (Axis::Y, 'y', 'b'),
        (Axis::Z, 'z', 'c'),
    ] {
        for (unit, to_um) in LENGTHS_UM {
            known.push((format!("e{letter}_{unit}"), Column::Deviation { of, to_um }));
            known.push((
                format!("u_e{letter}_{unit}"),
                Column::Uncertainty { of, to_um },
            ));
        }
        for (unit, to_urad) in angles {
            known.push((
                format!("e{angle}_{unit}"),
                Column::Angle { about: of, to_urad },
            ));
            known.push((
                format!("u_e{angle}_{unit}"),
                Column::AngleUncertainty { about: of },
            ));
        }
    }
    known
}

pub(super) struct Columns {
    pub(super) kinds: Vec<Column>,
    pub(super) names: Vec<String>,
}

impl Columns {
    pub(super) fn read(header: &Line<'_>) -> Result<Columns, Problems> {
        let expected = Expected {
            known: known_columns(),
            same: same_content,
            first_line: FIRST_LINE,
            columns: "columns: axis, direction, position_mm, ex_um, ey_um, ez_um, u_ex_um …",
        };
        let (kinds, names) = columns_of(header, &expected)?;
        let mut problems = Problems::none();
        require_columns(header, &kinds, &mut problems);
        problems.or_ok(Columns { kinds, names })
    }

    pub(super) fn position_unit(&self) -> &'static str {
        let inch = |kind: &Column| matches!(kind, Column::Position { to_mm } if *to_mm > 1.0);
        if self.kinds.iter().any(inch) {
            "in"
        } else {
            "mm"
        }
    }

    /// The headings of the deviations in X, Y and Z.
    pub(super) fn headings(&self, header: &Line<'_>) -> PerAxis<Option<Heading>> {
        let mut headings = PerAxis::default();
        for (index, kind) in self.kinds.iter().enumerate() {
            if let Column::Deviation { of, to_um } = *kind {
                headings[of] = Some(Heading {
                    name: self.names[index].clone(),
                    to_um,
                    place: header.cell_place(index),
                });
            }
        }
        headings
    }

    pub(super) fn index_of(&self, wanted: impl Fn(&Column) -> bool) -> Option<usize> {
        self.kinds.iter().position(wanted)
    }
}

fn same_content(a: &Column, b: &Column) -> bool {
    match (a, b) {
        (Column::Position { .. }, Column::Position { .. }) => true,
        (Column::Deviation { of: a, .. }, Column::Deviation { of: b, .. })
        | (Column::Uncertainty { of: a, .. }, Column::Uncertainty { of: b, .. })
        | (Column::Angle { about: a, .. }, Column::Angle { about: b, .. })
        | (Column::AngleUncertainty { about: a }, Column::AngleUncertainty { about: b }) => a == b,
        (Column::Axis, Column::Axis) | (Column::Direction, Column::Direction) => true,
        _ => false,
    }
}

fn require_columns(header: &Line<'_>, kinds: &[Column], problems: &mut Problems) {
    let whole = header.whole();
    let mut require = |present: bool, what: &str, example: &str| {
        if !present {
            problems.push(
                Problem::new(format!("there is no column for {what}, expected {example}"))
                    .at(whole.clone())
                    .help(FIRST_LINE),
            );
        }
    };
    require(kinds.contains(&Column::Axis), "the axis", "`axis`");
    require(
        kinds
            .iter()
            .any(|kind| matches!(kind, Column::Position { .. })),
        "the position",
        "`position_mm` or `position_in`",
    );
    require(
        kinds
            .iter()
            .any(|kind| matches!(kind, Column::Deviation { .. } | Column::Angle { .. })),
        "any deviation",
        "`ex_um`, `ey_um` or `ez_um`",
    );
}
