//! What was not measured, and what the figures therefore leave out.

use super::VolumeModel;
use crate::inputs::job::Job;
use crate::machine::model::{ErrorModel, Measured};
use crate::quantity::axis::{Axis, ErrorTerm, PerAxis, Rotation};
use crate::quantity::chain::LeverEffect;
use crate::quantity::units::Millimetres;

/// An error that was not measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Missing {
    /// Its name: `EYX`, `EAX`, `squareness_xy`.
    pub name: String,
    /// What the figures leave out, in words.
    pub consequence: String,
}

impl VolumeModel {
    /// Which of the 21 errors were neither measured nor stated, and what that leaves out.
    pub fn missing(&self) -> Vec<Missing> {
        let deviations = ErrorTerm::ALL.into_iter();
        let deviations = deviations
            .filter(|term| self.deviations[*term].is_none())
            .map(|term| Missing {
                name: term.to_string(),
                consequence: format!("whatever {} does in {} while it moves", term.along, term.of),
            });
        let rotations = Rotation::all()
            .filter(|rotation| self.rotations[*rotation].is_none())
            .filter_map(|rotation| {
                let consequence = self.left_out(rotation)?;
                let name = rotation.to_string();
                Some(Missing { name, consequence })
            });
        deviations
            .chain(rotations)
            .chain(self.no_slopes())
            .collect()
    }

    /// The effects of a rotation that was not measured, at the far end of its levers; `None` = it
    /// has none.
    fn left_out(&self, rotation: Rotation) -> Option<String> {
        let mut words: Vec<String> = self
            .chain
            .effects(rotation)
            .into_iter()
            .map(|effect| self.at_far_end(effect))
            .collect();
        let tool = self.levers.tool.filter(|tool| {
            let crosswise = |axis: Axis| axis != rotation.about && tool[axis].mm().abs() > 0.0;
            Axis::ALL.into_iter().any(crosswise)
        });
        if tool.is_some() {
            words.push("the tool offset swings with it".to_string());
        }
        (!words.is_empty()).then(|| words.join("; "))
    }

    fn at_far_end(&self, effect: LeverEffect) -> String {
        let (low, high) = self.ranges[effect.arm];
        if high <= low && !self.is_measured(effect.arm) {
            return format!(
                "its effect in {} is not known: the lever is the travel of {}, which is not stated",
                effect.direction, effect.arm
            );
        }
        let origin = self.origin[effect.arm];
        let arm = (low - origin).abs().max((high - origin).abs());
        format!(
            "up to {:.3} µm in {} for each µrad (lever {} mm in {})",
            arm / super::MM_PER_M,
            effect.direction,
            Millimetres::new(arm).shown(),
            effect.arm
        )
    }

    /// Squareness that is neither stated nor can stand in slopes of measured straightness.
    fn no_slopes(&self) -> Vec<Missing> {
        let pairs = [(Axis::X, Axis::Y), (Axis::X, Axis::Z), (Axis::Y, Axis::Z)];
        let open = pairs.into_iter().filter(|(of, along)| {
            let (of, along) = (*of, *along);
            let (term, turned) = (
                ErrorTerm { of, along },
                ErrorTerm {
                    of: along,
                    along: of,
                },
            );
            let stated = self.squareness.iter().any(|s| s.term == term);
            let both = self.deviations[term].is_some() && self.deviations[turned].is_some();
            !stated && !both
        });
        open.map(|(of, along)| Missing {
            name: format!("squareness_{}{}", of.key(), along.key()),
            consequence: format!("{of} and {along} count as square"),
        })
        .collect()
    }

    /// What the model takes for granted, one sentence each.
    pub(super) fn statements(&self, job: &Job, model: &ErrorModel) -> Vec<String> {
        let mut labels = Vec::new();
        if !self.chain_is_stated {
            labels.push("the chain is not stated: without angles no figure depends on it; what missing angles leave out is told for axes that all move the tool".to_string());
        }
        labels.extend(self.of_squareness());
        labels.extend(self.of_angles(job));
        labels.extend(of_directions(model));
        labels.extend(self.of_ranges(job));
        labels.extend(
            model
                .remarks
                .doubts
                .iter()
                .map(|doubt| format!("doubt: {doubt}")),
        );
        labels
    }

    fn of_squareness(&self) -> Option<String> {
        let stated: Vec<String> = self
            .squareness
            .iter()
            .map(|s| {
                format!(
                    "{}{} {:+} µm/m",
                    s.term.of.key(),
                    s.term.along.key(),
                    s.um_per_m
                )
            })
            .collect();
        Some(if stated.is_empty() {
            "squareness is not stated apart: it counts as far as the slopes of the straightness curves hold it".to_string()
        } else {
            format!(
                "squareness as stated: {}; positive = the angle between the two positive axis directions is less than 90°",
                stated.join(", ")
            )
        })
    }

    fn of_angles(&self, job: &Job) -> Vec<String> {
        if Rotation::all().all(|rotation| self.rotations[rotation].is_none()) {
            return Vec::new();
        }
        let mut labels = vec![self.of_offsets()];
        let at_reference: Vec<String> = Rotation::all()
            .filter_map(|rotation| {
                let place = job.machine.axes[rotation.along]?.reference;
                let urad = self.rotations[rotation].as_ref()?.at(place).um();
                let zeroed = self.levers.angles_zero[rotation.along].is_some();
                (!zeroed && urad.abs() >= SHOWN_URAD).then(|| format!("{rotation} {urad:+.3} µrad"))
            })
            .collect();
        if !at_reference.is_empty() {
            labels.push(format!(
                "angles count as given: at the reference {}. Squareness that was measured with an axis standing anywhere but where its angles are zero holds them already; then state `angles_zero_mm`",
                at_reference.join(", ")
            ));
        }
        let zeroed = self.levers.angles_zero.iter();
        labels.extend(zeroed.filter_map(|(axis, place)| {
            Some(format!("angles of {axis} count from {} mm, where they are taken as zero (`angles_zero_mm`)", (*place)?.mm()))
        }));
        labels.extend(Axis::ALL.into_iter().filter(|axis| self.chain.moves_workpiece(*axis)).map(|axis| {
            match self.levers.straightness_optic[axis] {
                Some(place) => format!("{axis} carries the workpiece and its straightness was measured on the table at {} mm (`straightness_optic_mm`): its own travel is a lever", place.mm()),
                None => format!("{axis} carries the workpiece: its straightness counts as measured at the tool point, which holds its own lever already; an optic riding on the table needs `straightness_optic_mm`"),
            }
        }));
        labels
    }

    /// Where levers count from, and what of it is assumed.
    fn of_offsets(&self) -> String {
        let [_, second, third] = self.chain.order();
        let place = |axis: Axis| {
            let word = match self.levers.offsets[axis] {
                Some(_) => "stated",
                None => "assumed: the reference",
            };
            let mm = Millimetres::new(self.origin[axis]).shown();
            format!("{axis} {mm} mm ({word})")
        };
        format!(
            "levers of the angles count from {}, {} (`offsets_mm`: where these axes rested while the others were measured)",
            place(second),
            place(third)
        )
    }

    fn of_ranges(&self, job: &Job) -> Vec<String> {
        let shorter = |axis: Axis| {
            let machine = job.machine.axes[axis]?;
            let (low, high) = self.ranges[axis];
            let beyond = low > machine.low.mm() + EDGE_MM || high < machine.high.mm() - EDGE_MM;
            let [low, high] = [low, high].map(|mm| Millimetres::new(mm).shown());
            beyond.then(|| format!("{axis} is judged from {low} to {high} mm, where it was measured; its travel is {} … {} mm", machine.low.mm(), machine.high.mm()))
        };
        Axis::ALL.into_iter().filter_map(shorter).collect()
    }
}

/// Angles at the reference below this are none, µrad.
const SHOWN_URAD: f64 = 0.0005;
/// Ranges that miss the travel by less are the same, mm.
const EDGE_MM: f64 = 0.01;

fn of_directions(model: &ErrorModel) -> Vec<String> {
    let all = PerAxis::from_fn(|axis| {
        model
            .measured()
            .filter(|(term, _)| term.along == axis)
            .map(|(_, measured)| &measured.measured)
            .collect::<Vec<_>>()
    });
    let sentence = |axis: Axis| {
        let measured = &all[axis];
        if measured.iter().any(|m| m.has_both_ways()) {
            return Some(format!(
                "{axis} was measured in both directions: the mean of both counts, the reversal is not in these figures"
            ));
        }
        let one_way = |m: &&Measured| matches!(m, Measured::OneWay(..));
        measured
            .iter()
            .any(one_way)
            .then(|| format!("{axis} was measured in one direction: the figures hold for it only"))
    };
    Axis::ALL.into_iter().filter_map(sentence).collect()
}
