//! ISG kernel (TwinCAT CNC): the parameters of a volumetric compensation (docs/isg.md §3).
//!
//! Positions and deviations in mm, angles in rad, as in the files.

use crate::quantity::{Axis, ErrorTerm, PerAxis, Rotation};
use std::fmt;

/// One of the parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Parameter {
    /// `EXX` …: a deviation, by the position of its axis.
    Deviation(ErrorTerm),
    /// `EAX` …: a rotation, by the position of its axis.
    Angle(Rotation),
    /// `C0Y` …: how an axis is turned, wherever it stands.
    Turned(Rotation),
}

impl Parameter {
    /// µm in a mm of the file.
    const PER_MM: f64 = 1e3;
    /// µrad in a rad of the file.
    pub(crate) const PER_RAD: f64 = 1e6;

    /// All of them, as they are named in files.
    pub(crate) fn all() -> impl Iterator<Item = Parameter> {
        let deviations = ErrorTerm::ALL.into_iter().map(Parameter::Deviation);
        let angles = Rotation::all().map(Parameter::Angle);
        deviations.chain(angles).chain(Rotation::all().map(Parameter::Turned))
    }

    /// The axis whose position it depends on; `None` of a constant.
    pub(crate) const fn along(self) -> Option<Axis> {
        match self {
            Parameter::Deviation(term) => Some(term.along),
            Parameter::Angle(rotation) => Some(rotation.along),
            Parameter::Turned(_) => None,
        }
    }

    /// The moving axis and the axis that deviates; `None` of what is no deviation.
    pub(crate) const fn pair(self) -> Option<(Axis, Axis)> {
        match self {
            Parameter::Deviation(term) => Some((term.along, term.of)),
            Parameter::Angle(_) | Parameter::Turned(_) => None,
        }
    }

    /// The number of the file in µm or µrad.
    pub(crate) const fn per_unit(self) -> f64 {
        match self {
            Parameter::Deviation(_) => Self::PER_MM,
            Parameter::Angle(_) | Parameter::Turned(_) => Self::PER_RAD,
        }
    }
}

impl fmt::Display for Parameter {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Parameter::Deviation(term) => write!(out, "{term}"),
            Parameter::Angle(rotation) => write!(out, "{rotation}"),
            Parameter::Turned(rotation) => {
                let name = rotation.to_string(); // E, about, along
                let about = name.chars().nth(1).unwrap_or('?');
                write!(out, "{about}0{}", rotation.along)
            }
        }
    }
}

/// A point of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IsgPoint {
    /// Position of the axis, mm.
    pub position: f64,
    /// The parameter there, mm or rad.
    pub value: f64,
}

/// A parameter with its values.
#[derive(Clone, Debug, PartialEq)]
pub struct IsgCurve {
    /// Which.
    pub parameter: Parameter,
    /// Ascending; of a constant one point at 0.
    pub points: Vec<IsgPoint>,
}

/// One volumetric compensation.
#[derive(Clone, Debug, PartialEq)]
pub struct IsgTables {
    /// Logical axis numbers; `None` = not stated.
    pub axes: PerAxis<Option<u32>>,
    /// The axes from the workpiece to the tool.
    pub chain: [Axis; 3],
    /// Axes of which the correction is turned round (`negate`).
    pub negated: PerAxis<bool>,
    /// Axes that get no correction (`set_to_zero`).
    pub zeroed: PerAxis<bool>,
    /// The parameters, in their order.
    pub curves: Vec<IsgCurve>,
}

impl IsgTables {
    /// A control without a compensation.
    pub const NONE: IsgTables = IsgTables {
        axes: PerAxis { x: None, y: None, z: None },
        chain: Axis::ALL,
        negated: PerAxis { x: false, y: false, z: false },
        zeroed: PerAxis { x: false, y: false, z: false },
        curves: Vec::new(),
    };

    /// The curve of a parameter.
    pub(crate) fn curve(&self, parameter: Parameter) -> Option<&IsgCurve> {
        self.curves.iter().find(|own| own.parameter == parameter)
    }

    /// The axis of a logical axis number.
    pub(crate) fn axis(&self, number: &str) -> Option<Axis> {
        let is_own = |axis: &Axis| self.axes[*axis].is_some_and(|own| own.to_string() == number);
        Axis::ALL.into_iter().find(is_own)
    }

    /// Whether angles swing what an axis carries.
    pub(crate) fn has_angles(&self) -> bool {
        let is_angle = |curve: &IsgCurve| matches!(curve.parameter, Parameter::Angle(_));
        self.curves.iter().any(is_angle)
    }
}
