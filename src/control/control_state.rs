//! The control outside the kit's files: what the job states and a person has to see to.
//!
//! The emulators need it beside the tables (reference, unit, backlash parameter, switches that
//! no file of a kit writes). Each entry is listed as a precondition or an assumption.

use crate::quantity::{Correction, Deviation, Direction, Millimetres};

/// What an axis of the control is, apart from the files: what the job states as precondition.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisState {
    /// The control's name of the axis (`AX1`, or `1`).
    pub name: String,
    /// Reference position, machine coordinates (Fanuc 1240).
    pub reference: Millimetres,
    /// Direction of the reference return (Fanuc 1006#5).
    pub reference_direction: Direction,
    /// Detection unit, µm (Fanuc).
    pub detection_unit_um: Option<f64>,
    /// Backlash parameter in µm, positive = ordinary lost motion (MD32450, 1851/1852); 0 if none.
    pub backlash_um: f64,
    /// Bidirectional pitch compensation is switched on (Fanuc 3605#0), where no file says so.
    pub bidirectional: bool,
    /// Interpolated pitch compensation is switched on (Fanuc 3605#1), where no file says so.
    pub interpolated: bool,
    /// Both ends of its travel, whatever the reference.
    pub ends: (Millimetres, Millimetres),
    /// Where it rests while other axes are measured.
    pub rest: Millimetres,
}

impl AxisState {
    /// An axis for tests: reference and rest at 0, returned to in +, nothing in its parameters.
    #[cfg(test)]
    pub(crate) fn plain(name: &str, travel_mm: [f64; 2]) -> AxisState {
        AxisState {
            name: name.to_string(),
            reference: Millimetres::new(0.0),
            reference_direction: Direction::Plus,
            detection_unit_um: None,
            backlash_um: 0.0,
            bidirectional: false,
            interpolated: false,
            ends: travel_mm.map(Millimetres::new).into(),
            rest: Millimetres::new(0.0),
        }
    }

    /// Both ends of its travel, with the reference where it lies outside.
    pub(crate) fn travel(&self) -> [Millimetres; 2] {
        let (low, high) = self.ends;
        let reference = self.reference.mm();
        [low.mm().min(reference), high.mm().max(reference)].map(Millimetres::new)
    }

    /// What the backlash parameter adds while the axis moves in `direction`.
    ///
    /// **sign** with positive backlash the encoder leads: having reversed, the machine lags by that
    /// much and has to go further · **source** zero belongs to the direction of the reference
    /// return (Siemens machine data MD32450).
    pub fn backlash(&self, direction: Direction) -> Correction {
        let lag_um = match (self.reference_direction, direction) {
            (Direction::Plus, Direction::Minus) => self.backlash_um,
            (Direction::Minus, Direction::Plus) => -self.backlash_um,
            _ => 0.0,
        };
        -Deviation::from_um(lag_um)
    }
}

/// State of the control outside the files.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlState {
    /// Unit of positions in the control's files.
    pub unit: crate::control::controller::ControlUnit,
    /// Its axes.
    pub axes: Vec<AxisState>,
}

impl ControlState {
    /// The axis of a name, regardless of case.
    pub fn axis(&self, name: &str) -> Option<&AxisState> {
        self.axes.iter().find(|axis| axis.name.eq_ignore_ascii_case(name))
    }
}
