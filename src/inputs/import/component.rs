//! EXX … ECZ: a deviation or a rotation while one axis moves.

use crate::inputs::error_table::DraftSeries;
use crate::quantity::axis::{Axis, ErrorTerm, Rotation};
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
        let kinds = [Kind::Deviation as fn(Axis) -> Kind, Kind::Angle];
        let all = kinds.into_iter().flat_map(|kind| {
            ErrorTerm::ALL.map(|term| Component { kind: kind(term.of), along: term.along })
        });
        let mut named = all.filter(|component| component.to_string() == name);
        named.next()
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
        let along = self.along;
        match self.kind {
            Kind::Deviation(of) => ErrorTerm { of, along }.fmt(out),
            Kind::Angle(about) => Rotation { about, along }.fmt(out),
        }
    }
}

/// The terms of a series, e.g. `EXX EAX`.
pub(crate) fn terms_of(series: &DraftSeries) -> Vec<Component> {
    let along = series.axis;
    let deviations = series.deviations_um.iter();
    let deviations = deviations.map(|(of, um)| (Kind::Deviation(of), um.is_some()));
    let angles = series.angles_urad.iter();
    let angles = angles.map(|(about, urad)| (Kind::Angle(about), urad.is_some()));
    let measured = deviations.chain(angles).filter(|(_, is)| *is);
    measured.map(|(kind, _)| Component { kind, along }).collect()
}
