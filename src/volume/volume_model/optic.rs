//! Straightness that was measured with the optic on a table: the lever of the table's own travel.

use super::{MM_PER_M, VolumeModel};
use crate::machine::model::{ErrorModel, Measured};
use crate::quantity::axis::{Axis, ErrorTerm, PerAxis, PerTerm, Rotation};
use crate::quantity::chain::unit;
use crate::quantity::curve::{ErrorCurve, Interpolation};
use crate::quantity::units::{Deviation, Millimetres};

impl VolumeModel {
    /// r × (x − optic) at the positions where the straightness was measured, e.g. of X: + ECX·(x − optic)
    /// to EYX, − EBX·(x − optic) to EZX, µm.
    ///
    /// source  docs/volumetric.md §2: once, as the data are read, not between the measured positions
    pub(super) fn optics(
        &self,
        model: &ErrorModel,
        kind: Interpolation,
    ) -> PerTerm<Option<ErrorCurve>> {
        PerTerm::from_fn(|term: ErrorTerm| {
            let optic = self.levers.straightness_optic[term.along]?;
            let measured = model.terms[term].as_ref()?;
            if term.is_positioning() {
                return None;
            }
            let curve = Measured::mean(&measured.measured);
            let added = |place: &Millimetres| self.swung(term, *place, optic);
            let added: Vec<Deviation> = curve.knots().iter().map(added).collect();
            Some(ErrorCurve::through(curve.knots(), &added, kind))
        })
    }

    fn swung(&self, term: ErrorTerm, place: Millimetres, optic: Millimetres) -> Deviation {
        let axis: Axis = term.along;
        let rotation = PerAxis::from_fn(|about| {
            let curve = self.rotations[Rotation { about, along: axis }].as_ref();
            curve.map_or(0.0, |curve| curve.at(place).um())
        });
        let own = unit(axis).times((place - optic).mm());
        Deviation::from_um(rotation.cross(own)[term.of] / MM_PER_M)
    }
}
