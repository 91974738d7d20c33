//! What a read-out holds around the tables: limit and unit of CEC, reference points.

use super::data::{CEC_LIMIT, CEC_UNIT, Datum, REFERENCE, REFERENCE_MODE, UNIT, UNIT_CHANGES};
use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::ControlUnit;
use crate::control::table::siemens::SiemensTables;
use crate::judge::active::Held;
use crate::judge::findings::InControl;

/// The last digit of a value in a table; sums are not exact in binary.
const LAST_DIGIT: f64 = 1e-6;

/// Unit of the control, limit and unit of CEC, reference points.
pub(super) fn found(state: &ControlState, wanted: &SiemensTables, held: &Held) -> Vec<InControl> {
    let mut found = cec_limits(held, wanted, state.unit);
    found.extend(state.axes.iter().filter_map(|axis| {
        let own = wanted.lec.iter().find(|table| table.axis == axis.name);
        reference(axis, own.map_or(0, |table| table.encoder), state.unit, held)
    }));
    found
}

/// MD34100, the position at the zero mark of an incremental measuring system. With an absolute or
/// a distance-coded one (MD34200 other than 1) it says nothing (both from memory). The index of
/// MD34100 is a reference cam, that of MD34200 the measuring system.
fn reference(axis: &AxisState, encoder: u32, unit: ControlUnit, held: &Held) -> Option<InControl> {
    const SAME_MM: f64 = 1e-3;
    const ZERO_MARK: f64 = 1.0;
    let of =
        |datum: Datum, index: u32| held.number(datum.1, &[index.to_string(), axis.name.clone()]);
    let position = of(REFERENCE, 0)?;
    let mode = of(REFERENCE_MODE, encoder);
    let counts = mode.is_none_or(|mode| (mode - ZERO_MARK).abs() <= 0.0);
    let own_mm = axis.reference.mm();
    let is_other = (position * unit.in_mm() - own_mm).abs() > SAME_MM;
    (counts && is_other).then(|| InControl::ReferencePoint {
        axis: axis.name.clone(),
        position,
        unit: unit.word(),
        own_mm,
    })
}

/// Preconditions on machine data that no file holds.
pub(super) fn absent(tables: &SiemensTables, held: &Held) -> Vec<String> {
    let mut absent = Vec::new();
    if held.datum(UNIT.1, &[]).is_none() {
        absent.push(UNIT.0.to_string());
    }
    for output in tables.cec_outputs() {
        let lacks = |name: &str| held.datum(name, std::slice::from_ref(&output)).is_none();
        let lacking = [CEC_LIMIT, CEC_UNIT].into_iter().filter(|(name, _)| lacks(name));
        absent.extend(lacking.map(|(_, number)| format!("{number} of {output}")));
    }
    absent
}

/// What else decides how far CEC tables act on an axis: MD32720 cuts their sum, MD32711 (where
/// MD10260 = 1) says their unit.
pub(super) fn cec_limits(held: &Held, tables: &SiemensTables, unit: ControlUnit) -> Vec<InControl> {
    let mut findings = Vec::new();
    for axis in tables.cec_outputs() {
        let index = std::slice::from_ref(&axis);
        let sum = tables.largest_cec_sum(&axis);
        let limit = held.number(CEC_LIMIT.1, index);
        if let Some(limit) = limit.filter(|limit| *limit < sum - LAST_DIGIT / 2.0) {
            findings.push(InControl::CutOff {
                axis: axis.clone(),
                limit,
                sum: (sum / LAST_DIGIT).round() * LAST_DIGIT,
                unit: unit.word(),
            });
        }
        let metric = held.number(CEC_UNIT.1, index);
        let converts = held.number(UNIT_CHANGES.1, &[]);
        let Some(metric) = metric.filter(|metric| ControlUnit::of_metric(*metric) != unit) else {
            continue;
        };
        let unit = unit.word();
        findings.extend(match converts {
            None => Some(InControl::MayBeCecUnit { axis, metric, unit }),
            Some(on) => (on > 0.0).then_some(InControl::CecUnit { axis, metric, unit }),
        });
    }
    findings
}
