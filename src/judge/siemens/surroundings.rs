//! What a read-out holds around the tables: limit and unit of CEC.

use super::data::{CEC_LIMIT, CEC_UNIT, UNIT, UNIT_CHANGES};
use crate::control::controller::ControlUnit;
use crate::control::table::siemens::SiemensTables;
use crate::judge::active::Held;
use crate::judge::findings::InControl;

/// The last digit of a value in a table; sums are not exact in binary.
const LAST_DIGIT: f64 = 1e-6;

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
