//! EXX … ECZ: a deviation or a rotation while one axis moves.

use crate::inputs::error_table::DraftSeries;
use crate::quantity::axis::Axis;
use std::fmt;

/// A component of the error table: a deviation or a rotation while one axis moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Component {
    /// What deviates.
    pub kind: Kind,
    /// The moving axis.
    pub along: Axis,
}

/// Deviation or rotation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Deviation in the direction of an axis.
    Deviation(Axis),
    /// Rotation about an axis.
    Angle(Axis),
}

impl Component {
    /// The component of a name such as `EYX` or `ECX`.
    pub fn from_name(name: &str) -> Option<Component> {
        let [b'E', of, along] = name.as_bytes() else {
            return None;
        };
        let kind = match of {
            b'X' => Kind::Deviation(Axis::X),
            b'Y' => Kind::Deviation(Axis::Y),
            b'Z' => Kind::Deviation(Axis::Z),
            b'A' => Kind::Angle(Axis::X),
            b'B' => Kind::Angle(Axis::Y),
            b'C' => Kind::Angle(Axis::Z),
            _ => return None,
        };
        let along = Axis::ALL
            .into_iter()
            .find(|a| a.letter() == char::from(*along))?;
        Some(Component { kind, along })
    }

    /// Whether an axis is measured along itself (`EXX`): the sense of its targets is then that of
    /// the deviation.
    pub(super) fn is_positioning(self) -> bool {
        self.kind == Kind::Deviation(self.along)
    }

    /// Sets the values of the component in a series of its axis, µm or µrad.
    pub(super) fn put(self, series: &mut DraftSeries, values: Vec<f64>) {
        match self.kind {
            Kind::Deviation(of) => series.deviations_um[of] = Some(values),
            Kind::Angle(about) => series.angles_urad[about] = Some(values),
        }
    }
}

impl fmt::Display for Component {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of = match self.kind {
            Kind::Deviation(of) => of.letter(),
            Kind::Angle(Axis::X) => 'A',
            Kind::Angle(Axis::Y) => 'B',
            Kind::Angle(Axis::Z) => 'C',
        };
        write!(out, "E{of}{}", self.along)
    }
}

/// The terms of a series, e.g. `EXX EAX`.
pub fn terms_of(series: &DraftSeries) -> Vec<Component> {
    let along = series.axis;
    let deviations = Axis::ALL
        .into_iter()
        .filter(|of| series.deviations_um[*of].is_some());
    let angles = Axis::ALL
        .into_iter()
        .filter(|of| series.angles_urad[*of].is_some());
    let kinds = deviations
        .map(Kind::Deviation)
        .chain(angles.map(Kind::Angle));
    kinds.map(|kind| Component { kind, along }).collect()
}
