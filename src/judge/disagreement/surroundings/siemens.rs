//! Unit of the control, limit and unit of CEC, reference point of a Siemens control.

use super::Surroundings;
use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::LengthUnit;
use crate::control::table::siemens::SiemensTables;
use crate::judge::active::Held;
use crate::read::siemens::MachineValue;

impl Surroundings {
    pub(super) fn of_siemens(&mut self, state: &ControlState, wanted: &SiemensTables, held: &Held) {
        for output in outputs(wanted) {
            let limited = max_sum(wanted, state.unit, &output, held);
            self.disagreements.extend(limited);
            self.scaling(state.unit, &output, held);
        }
        for axis in &state.axes {
            let own = wanted.lec.iter().find(|table| table.axis == axis.name);
            self.reference(axis, own.map_or(0, |table| table.encoder), state.unit, held);
        }
        self.absent(absent(wanted, held));
    }

    /// MD32711, which counts where MD10260 = 1.
    fn scaling(&mut self, unit: LengthUnit, output: &str, held: &Held) {
        let Some(metric) = number(held, "MA_CEC_SCALING_SYSTEM_METRIC", &[output.to_string()])
        else {
            return;
        };
        if LengthUnit::of_metric(metric) == unit {
            return;
        }
        let words = format!(
            "MD32711 of {output} is {metric}, the job has its CEC tables in {}",
            unit.word()
        );
        match number(held, "MN_CONVERT_SCALING_SYSTEM", &[]) {
            Some(converts) if converts <= 0.0 => {}
            Some(_) => self.disagreements.push(words),
            None => self.beside.push(format!(
                "{words}; it counts where MD10260 = 1, which no file holds"
            )),
        }
    }

    /// MD34100, the position at the zero mark of an incremental measuring system. With an absolute or
    /// a distance-coded one (MD34200 other than 1) it says nothing (both from memory). The index of
    /// MD34100 is a reference cam, that of MD34200 the measuring system.
    fn reference(&mut self, axis: &AxisState, encoder: u32, unit: LengthUnit, held: &Held) {
        const SAME_MM: f64 = 1e-3;
        const ZERO_MARK: f64 = 1.0;
        let indices = ["0".to_string(), axis.name.clone()];
        let Some(position) = number(held, "MA_REFP_SET_POS", &indices) else {
            return;
        };
        let system = [encoder.to_string(), axis.name.clone()];
        let mode = number(held, "MA_ENC_REFP_MODE", &system);
        if mode.is_some_and(|mode| (mode - ZERO_MARK).abs() > 0.0) {
            return;
        }
        if (position * unit.in_mm() - axis.reference.mm()).abs() > SAME_MM {
            self.beside.push(format!(
                "MD34100 $MA_REFP_SET_POS[0,{}] is {position} {}, the job has the reference point at {} mm: with an incremental measuring system the tables are not zero where the axis is referenced",
                axis.name,
                unit.word(),
                axis.reference.mm()
            ));
        }
    }
}

/// The axes that CEC tables correct, each once.
fn outputs(tables: &SiemensTables) -> Vec<String> {
    let mut outputs: Vec<String> = tables.cec.iter().map(|t| t.output_axis.clone()).collect();
    outputs.sort_unstable();
    outputs.dedup();
    outputs
}

fn number(held: &Held, name: &str, indices: &[String]) -> Option<f64> {
    match held.datum(name, indices)?.value {
        MachineValue::Number(number) => Some(number),
        MachineValue::Text(_) => None,
    }
}

/// The last digit of a value in a table, in the unit of the control; sums are not exact in binary.
const LAST_DIGIT: f64 = 1e-6;

/// MD32720 below what the tables of an axis may add up to. It is in the unit of the tables.
fn max_sum(tables: &SiemensTables, unit: LengthUnit, output: &str, held: &Held) -> Option<String> {
    let limit = number(held, "MA_CEC_MAX_SUM", &[output.to_string()])?;
    let sum = tables.largest_cec_sum(output);
    (limit < sum - LAST_DIGIT / 2.0).then(|| {
        let sum = (sum / LAST_DIGIT).round() * LAST_DIGIT;
        format!("MD32720 of {output} is {limit} {unit}, and the CEC corrections that the job asks for may add up to {sum:.6} {unit}: what is more is cut off (alarm 20124)", unit = unit.word())
    })
}

/// Preconditions on machine data that no file holds.
fn absent(tables: &SiemensTables, held: &Held) -> Vec<String> {
    let mut absent = Vec::new();
    if held.datum("MN_SCALING_SYSTEM_IS_METRIC", &[]).is_none() {
        absent.push("MD10240".to_string());
    }
    for output in outputs(tables) {
        for (name, number) in [
            ("MA_CEC_MAX_SUM", "MD32720"),
            ("MA_CEC_SCALING_SYSTEM_METRIC", "MD32711"),
        ] {
            if held.datum(name, std::slice::from_ref(&output)).is_none() {
                absent.push(format!("{number} of {output}"));
            }
        }
    }
    absent
}
