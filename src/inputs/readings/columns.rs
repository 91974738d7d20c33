//! Header of the readings → what each column holds.

use crate::quantity::axis::{Axis, PerAxis};
use crate::text::delimited::{Expected, LENGTHS_UM, Line, columns_of};
use crate::text::problem::{Problem, Problems};

/// What the readings are counted from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Quantity {
    /// Measured − nominal displacement.
    Deviation,
    /// The displacement as the instrument showed it.
    Displacement,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Column {
    Diagonal,
    Run,
    Direction,
    Node,
    Moved,
    Value { quantity: Quantity, to_um: f64 },
    Temperature { of: Axis },
}

const FIRST_LINE: &str = "first line: diagonal,run,direction,node,moved,deviation_um";

fn known_columns() -> Vec<(String, Column)> {
    let mut known: Vec<(String, Column)> = [
        ("diagonal", Column::Diagonal),
        ("run", Column::Run),
        ("direction", Column::Direction),
        ("node", Column::Node),
        ("moved", Column::Moved),
    ]
    .map(|(name, column)| (name.to_string(), column))
    .into();
    for (name, quantity) in [
        ("deviation", Quantity::Deviation),
        ("displacement", Quantity::Displacement),
    ] {
        known
            .extend(LENGTHS_UM.map(|(unit, to_um)| {
                (format!("{name}_{unit}"), Column::Value { quantity, to_um })
            }));
    }
    for of in Axis::ALL {
        known.push((format!("t_{}_c", of.key()), Column::Temperature { of }));
    }
    known
}

fn same_content(a: &Column, b: &Column) -> bool {
    matches!((a, b), (Column::Value { .. }, Column::Value { .. })) || a == b
}

/// The columns of a file of readings.
pub(super) struct Columns<'a> {
    pub(super) header: Line<'a>,
    pub(super) kinds: Vec<Column>,
    pub(super) names: Vec<String>,
    pub(super) quantity: Quantity,
}

impl<'a> Columns<'a> {
    pub(super) fn read(header: Line<'a>) -> Result<Columns<'a>, Problems> {
        let expected = Expected {
            known: known_columns(),
            same: same_content,
            first_line: FIRST_LINE,
            columns: "columns: diagonal, run, direction, node, moved, deviation_um or displacement_mm, t_x_c …",
        };
        let (kinds, names) = columns_of(&header, &expected)?;
        let mut problems = Problems::none();
        let quantity = kinds.iter().find_map(|kind| match kind {
            Column::Value { quantity, .. } => Some(*quantity),
            _ => None,
        });
        let required = [
            (
                kinds.contains(&Column::Diagonal),
                "the diagonal",
                "`diagonal`",
            ),
            (kinds.contains(&Column::Node), "the node", "`node`"),
            (
                quantity.is_some(),
                "the reading",
                "`deviation_um`, or `displacement_mm` for the displacement itself",
            ),
        ];
        for (_, what, example) in required.iter().filter(|(present, ..)| !present) {
            problems.push(
                Problem::new(format!("there is no column for {what}, expected {example}"))
                    .at(header.whole())
                    .help(FIRST_LINE),
            );
        }
        let quantity = quantity.unwrap_or(Quantity::Deviation);
        problems.or_ok(Columns {
            header,
            kinds,
            names,
            quantity,
        })
    }

    /// Where a column stands in the header.
    pub(super) fn index_of(&self, column: Column) -> Option<usize> {
        self.kinds.iter().position(|kind| *kind == column)
    }

    /// Where the temperatures of each axis stand.
    pub(super) fn temperatures(&self) -> PerAxis<Option<usize>> {
        PerAxis::from_fn(|of| self.index_of(Column::Temperature { of }))
    }
}
