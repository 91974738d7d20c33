//! What a person types into a control that reads no file: numbers of points and values, in the sense and unit
//! of its screen, with a sum for each page (contract §4.2).

use crate::control::control_state::ControlState;
use crate::control::controller::{GenericFacts, TypedValue};
use crate::control::table::generic::{GenericRow, GenericTable};
use crate::quantity::axis::Direction;
use crate::quantity::units::{self, Figure};
use crate::text::delimited::LengthUnit;
use crate::write::seen::{Seen, seen};

/// Positions are written to the nanometre.
pub(super) const POSITION_DECIMALS: u32 = 6;
/// Rows of a printed page (A4 or Letter) with room for handwriting.
const ROWS_OF_A_PAGE: usize = 32;
/// Sums and millimetres are freed from binary dust below any digit of a screen.
const DUST_DECIMALS: u32 = 12;

/// What the values of the pages are.
pub(super) fn typed_words(facts: &GenericFacts) -> Seen {
    seen! {
        "column": facts.typed_column(),
        "value": facts.typed_value.value.words(),
        "unit": match facts.typed_unit.value {
            LengthUnit::Um => "µm",
            other => other.word(),
        },
    }
}

/// The pages of every table.
pub(super) fn blocks(
    table: &GenericTable,
    facts: &GenericFacts,
    state: &ControlState,
) -> Vec<Seen> {
    let mut page = 0;
    let same = |a: &GenericRow, b: &GenericRow| {
        a.term == b.term && a.output_axis == b.output_axis && a.direction == b.direction
    };
    let blocks = table.rows.chunk_by(same);
    blocks.filter_map(|rows| block(rows, facts, state, &mut page)).collect()
}

fn block(
    rows: &[GenericRow],
    facts: &GenericFacts,
    state: &ControlState,
    page: &mut usize,
) -> Option<Seen> {
    let (first, second) = (rows.first()?, rows.get(1)?);
    let zero_mm = state.axis(&first.base_axis)?.reference.mm();
    let zero_mm = units::rounded(zero_mm, POSITION_DECIMALS);
    let zero = rows.iter().find(|row| row.position_mm >= zero_mm)?;
    let spacing = units::rounded(second.position_mm - first.position_mm, POSITION_DECIMALS);
    let pages = rows.chunks(ROWS_OF_A_PAGE).map(|rows| {
        *page += 1;
        seen_page(rows, facts, *page)
    });
    Some(seen! {
        "pages": pages.collect::<Vec<Seen>>(),
        "term": first.term.to_string(),
        "base_axis": first.base_axis.as_str(),
        "output_axis": first.output_axis.as_str(),
        "direction": first.direction.map_or("", Direction::symbol),
        "zero_mm": number(zero_mm),
        "zero_point": zero.index.to_string(),
        "spacing_mm": number(spacing),
        "points": rows.len().to_string(),
    })
}

fn seen_page(rows: &[GenericRow], facts: &GenericFacts, page: usize) -> Seen {
    let values: Vec<f64> = rows.iter().map(|row| typed(row, facts)).collect();
    let seen = rows.iter().zip(&values).map(|(row, value)| {
        seen! {
            "point": row.index.to_string(),
            "position_mm": number(row.position_mm),
            "value": number(*value),
        }
    });
    seen! {
        "number": page.to_string(),
        "rows": seen.collect::<Vec<Seen>>(),
        "sum": number(units::rounded(values.iter().sum(), DUST_DECIMALS)),
    }
}

/// What is typed for a point; before the first one nothing changes.
fn typed(row: &GenericRow, facts: &GenericFacts) -> f64 {
    let um = match facts.typed_value.value {
        TypedValue::Deviation => row.deviation_um,
        TypedValue::Correction => row.correction_um,
        TypedValue::Increment => row.increment_um.unwrap_or(0.0),
    };
    units::rounded(um / facts.typed_unit.value.um(), DUST_DECIMALS)
}

/// The shortest decimal text of a number.
pub(super) fn number(value: f64) -> String {
    Figure(value).to_string()
}
