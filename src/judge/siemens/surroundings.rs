//! What a read-out holds around the tables: limit and unit of CEC.

use crate::control::controller::ControlUnit;
use crate::control::table::siemens::SiemensTables;
use crate::judge::active::Held;
use crate::judge::findings::InControl;
use crate::judge::siemens::machine_data::{CEC_LIMIT, CEC_UNIT, UNIT, UNIT_CHANGES, number};

/// The last digit of a value in a table; sums are not exact in binary.
const LAST_DIGIT: f64 = 1e-6;

/// Preconditions on machine data that no file holds.
pub(super) fn absent(tables: &SiemensTables, held: &Held) -> Vec<String> {
    let lacks = |datum, index: &str| number(&held.data, datum, index).is_none();
    let mut absent = Vec::new();
    absent.extend(lacks(UNIT, "").then(|| UNIT.0.to_string()));
    for output in tables.cec_outputs() {
        let lacking = [CEC_LIMIT, CEC_UNIT].into_iter().filter(|datum| lacks(*datum, &output));
        absent.extend(lacking.map(|(number, _)| format!("{number} of {output}")));
    }
    absent
}

/// What else decides how far CEC tables act on an axis: MD32720 cuts their sum, MD32711 (where
/// MD10260 = 1) says their unit.
pub(super) fn cec_limits(held: &Held, tables: &SiemensTables, unit: ControlUnit) -> Vec<InControl> {
    let mut findings = Vec::new();
    for axis in tables.cec_outputs() {
        let sum = tables.largest_cec_sum(&axis);
        let limit = number(&held.data, CEC_LIMIT, &axis);
        if let Some(limit) = limit.filter(|limit| *limit < sum - LAST_DIGIT / 2.0) {
            findings.push(InControl::CutOff {
                axis: axis.clone(),
                limit,
                sum: (sum / LAST_DIGIT).round() * LAST_DIGIT,
                unit: unit.word(),
            });
        }
        let metric = number(&held.data, CEC_UNIT, &axis);
        let converts = number(&held.data, UNIT_CHANGES, "");
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
