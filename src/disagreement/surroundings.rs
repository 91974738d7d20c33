//! What a read-out holds around the tables, against what the job asks of the control there: limit
//! and unit of CEC, the way a Fanuc control plays its points, a second backlash parameter.

use crate::active::{ActiveControl, Held, Origin};
use crate::axis::Axis;
use crate::compensation::Compiled;
use crate::control_state::AxisState;
use crate::controller::LengthUnit;
use crate::plan::Plan;
use crate::readback::siemens::MachineValue;
use crate::table::Tables;
use crate::table::fanuc::{FanucMemory, ParameterValue};
use crate::table::siemens::SiemensTables;

/// What was found around the tables, one sentence each.
#[derive(Clone, Debug, Default)]
pub struct Surroundings {
    /// What contradicts the job.
    pub disagreements: Vec<String>,
    /// What acts beside the tables and is not emulated, or may: nothing is decided in favour.
    pub beside: Vec<String>,
    /// What no file holds and is taken as the job asks.
    pub notes: Vec<String>,
}

/// Compares them; what is not read out of a control has no surroundings.
pub fn surroundings(plan: &Plan, wanted: &Compiled, active: &ActiveControl) -> Surroundings {
    let mut found = Surroundings::default();
    let Origin::ReadOut(held) = &active.origin else {
        return found;
    };
    match (&wanted.tables, &held.tables) {
        (Tables::Siemens(tables), _) => {
            for output in outputs(tables) {
                found
                    .disagreements
                    .extend(max_sum(tables, wanted.state.unit, &output, held));
                found.scaling(wanted.state.unit, &output, held);
            }
            for axis in &wanted.state.axes {
                found.reference(axis, wanted.state.unit, held);
            }
            found.absent(siemens_absent(tables, held));
        }
        (Tables::Fanuc(tables), Tables::Fanuc(memory)) => {
            for axis in &wanted.state.axes {
                let number = axis.name.parse().ok();
                if tables.parameter(3623, number).is_some() {
                    found.switches(axis, tables, memory);
                }
                found.rapid(plan, axis, memory);
            }
            found.absent(fanuc_absent(&wanted.state.axes, tables, memory));
        }
        _ => {}
    }
    found
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

impl Surroundings {
    /// MD32711, which counts where MD10260 = 1.
    fn scaling(&mut self, unit: LengthUnit, output: &str, held: &Held) {
        let Some(metric) = number(held, "MA_CEC_SCALING_SYSTEM_METRIC", &[output.to_string()])
        else {
            return;
        };
        if (metric > 0.0) == (unit == LengthUnit::Millimetre) {
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

    /// MD34100, the position at the reference mark of an incremental measuring system (from memory;
    /// with an absolute one it says nothing).
    fn reference(&mut self, axis: &AxisState, unit: LengthUnit, held: &Held) {
        const SAME_MM: f64 = 1e-3;
        let indices = ["0".to_string(), axis.name.clone()];
        let Some(position) = number(held, "MA_REFP_SET_POS", &indices) else {
            return;
        };
        if (position * unit.in_mm() - axis.reference.mm()).abs() > SAME_MM {
            self.beside.push(format!(
                "MD34100 $MA_REFP_SET_POS[0,{}] is {position} {}, the job has the reference point at {} mm: with an incremental measuring system the tables are not zero where the axis is referenced",
                axis.name,
                unit.word(),
                axis.reference.mm()
            ));
        }
    }

    fn absent(&mut self, what: Vec<String>) {
        if !what.is_empty() {
            self.notes.push(format!(
                "no file holds {}: taken as the job asks, see to the preconditions",
                what.join(", ")
            ));
        }
    }

    /// 3605 bits 0 and 1 of an axis with a pitch table.
    fn switches(&mut self, axis: &AxisState, wanted: &FanucMemory, held: &FanucMemory) {
        let number = axis.name.parse().ok();
        let bits = |memory: &FanucMemory| match memory.parameter(3605, number) {
            Some(ParameterValue::Bits(bits)) => Some(bits),
            _ => None,
        };
        let of_state = u8::from(axis.bidirectional) | (u8::from(axis.interpolated) << 1);
        let asked = bits(wanted).unwrap_or(of_state) & 0b11;
        let name = &axis.name;
        let Some(found) = bits(held) else {
            self.notes.push(format!(
                "no file holds 3605 of axis {name}: bit 0 (table for each direction) and bit 1 (interpolated) are taken as the job asks, {} and {}",
                asked & 1,
                asked >> 1
            ));
            return;
        };
        let meanings = [
            "a table for each direction",
            "lines between the points, not steps",
        ];
        for (bit, meaning) in meanings.iter().enumerate() {
            let (is, should) = ((found >> bit) & 1, (asked >> bit) & 1);
            if is != should {
                self.disagreements.push(format!(
                    "3605#{bit} of axis {name} is {is}, the job is for {should} (1 = {meaning})"
                ));
            }
        }
    }

    /// 1852 beside 1851 where the job sets the backlash parameter. Which of the two acts in rapid
    /// traverse depends on a bit (1800#4, from memory) that is not read.
    fn rapid(&mut self, plan: &Plan, axis: &AxisState, held: &FanucMemory) {
        let number = axis.name.parse().ok();
        let of = |parameter| match held.parameter(parameter, number) {
            Some(ParameterValue::Integer(counts)) => Some(counts.to_string()),
            Some(ParameterValue::Real(counts)) => Some(counts.to_string()),
            _ => None,
        };
        let sets = |own: &Axis| plan.names[*own].contains(&axis.name) && plan.sets_backlash(*own);
        if !Axis::ALL.iter().any(sets) {
            return;
        }
        let name = &axis.name;
        match (of(1851), of(1852)) {
            (cutting, Some(rapid)) if cutting.as_ref() != Some(&rapid) => {
                let cutting = cutting.unwrap_or("in no file".to_string());
                self.beside.push(format!(
                    "1852 of axis {name} is {rapid}, 1851 is {cutting}, and the job asks for the same in both: where the control takes 1852 in rapid traverse, the axis stands elsewhere than forecast after it"
                ));
            }
            (Some(_), None) => self.notes.push(format!(
                "no file holds 1852 of axis {name}: taken as its 1851"
            )),
            _ => {}
        }
    }
}

/// Preconditions on machine data that no file holds.
fn siemens_absent(tables: &SiemensTables, held: &Held) -> Vec<String> {
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

/// The same of Fanuc parameters, for the axes with a pitch table.
fn fanuc_absent(axes: &[AxisState], wanted: &FanucMemory, held: &FanucMemory) -> Vec<String> {
    let mut absent = Vec::new();
    if held.parameters.keys().all(|key| key.number != 3602) {
        absent.push("3602".to_string());
    }
    for axis in axes {
        let number = axis.name.parse().ok();
        let own = wanted.parameter(3623, number).is_some();
        for parameter in [1006, 1240].into_iter().filter(|_| own) {
            if held.parameter(parameter, number).is_none() {
                absent.push(format!("{parameter} of axis {}", axis.name));
            }
        }
    }
    absent
}
