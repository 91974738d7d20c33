//! The kinematic chain: which axes carry the tool, which the workpiece, and what stands on what.
//!
//! ```text
//!   wXYZt   bed w ─→ X ─→ Y ─→ Z ─→ t      all axes move the tool          order X, Y, Z
//!   XwYZt   w on X;  Y ─→ Z ─→ t           X carries the workpiece         order X, Y, Z
//!   XYwZt   w on Y on X;  Z ─→ t           Y on X carry the workpiece      order Y, X, Z
//! ```
//! The letters stand from the foot of the machine outwards: those before `w` carry the workpiece,
//! the last of them is nearest to it. What matters for errors of the tool *relative to the
//! workpiece* is the order from the workpiece to the tool (1, 2, 3): a rotation of axis i swings
//! everything that stands after it (docs/volume.md §2).

use crate::quantity::{Axis, PerAxis, Rotation};
use std::fmt;

/// A kinematic chain in the notation of paper 002, e.g. `wXYZt` (contract §1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chain {
    /// The axes as they are written.
    letters: [Axis; 3],
    /// How many of them stand before `w`.
    carrying_workpiece: usize,
}

/// One effect of an angular error: rotation × lever.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeverEffect {
    /// Direction of the deviation.
    pub direction: Axis,
    /// The axis whose position is the lever.
    pub arm: Axis,
    /// +1 where a positive rotation and a positive arm give a positive deviation, else −1.
    pub sign: f64,
}

impl Chain {
    /// All axes move the tool, X carries Y carries Z.
    pub const ALL_AXES_MOVE_THE_TOOL: Chain = Chain { letters: Axis::ALL, carrying_workpiece: 0 };

    /// Reads a chain: each of X, Y, Z once, `w` at any place, `t` at the end.
    ///
    /// ```
    /// use nonius_numerics::quantity::Axis;
    /// use nonius_numerics::quantity::Chain;
    /// let order = |text: &str| Chain::parse(text).map(Chain::order);
    /// assert_eq!(order("XYwZt"), Some([Axis::Y, Axis::X, Axis::Z]));
    /// assert_eq!(order("XYZwt"), Some([Axis::Z, Axis::Y, Axis::X]));
    /// assert_eq!(order("wXYt"), None);
    /// ```
    pub fn parse(text: &str) -> Option<Chain> {
        let (before, after) = text.strip_suffix('t')?.split_once('w')?;
        let axis = |letter: char| Axis::ALL.into_iter().find(|axis| axis.letter() == letter);
        let letters: Option<Vec<Axis>> = before.chars().chain(after.chars()).map(axis).collect();
        let letters: [Axis; 3] = letters?.try_into().ok()?;
        let each_once = Axis::ALL.iter().all(|axis| letters.contains(axis));
        each_once.then_some(Chain { letters, carrying_workpiece: before.chars().count() })
    }

    /// Every chain: six orders, four places of `w`.
    pub fn all() -> impl Iterator<Item = Chain> {
        (0..4).flat_map(|carrying_workpiece| {
            Axis::ORDERS.map(|letters| Chain { letters, carrying_workpiece })
        })
    }

    /// The axes from the workpiece to the tool: 1, 2, 3 of the formulas.
    pub fn order(self) -> [Axis; 3] {
        let mut order = self.letters;
        order[..self.carrying_workpiece].reverse();
        order
    }

    /// The axes that swing with a rotation of `axis`: those between it and the tool.
    pub fn carried_by(self, axis: Axis) -> Vec<Axis> {
        self.order().into_iter().skip_while(|other| *other != axis).skip(1).collect()
    }

    /// Whether an axis carries the workpiece (a table).
    pub fn moves_workpiece(self, axis: Axis) -> bool {
        self.letters[..self.carrying_workpiece].contains(&axis)
    }

    /// What a rotation does through the positions of the axes after it: r × a, without tool offset.
    /// Empty for the rotations that have no effect (all of axis 3, and of axis 2 about axis 3).
    pub fn effects(self, rotation: Rotation) -> Vec<LeverEffect> {
        let effect = |arm: Axis| {
            let product = unit(rotation.about).cross(unit(arm)); // nothing where they are one axis
            let (direction, sign) = product.iter().find(|(_, part)| **part != 0.0)?;
            Some(LeverEffect { direction, arm, sign: *sign })
        };
        self.carried_by(rotation.along).into_iter().filter_map(effect).collect()
    }
}

impl fmt::Display for Chain {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (before, after) = self.letters.split_at(self.carrying_workpiece);
        write!(out, "{}w{}t", Axis::letters(before), Axis::letters(after))
    }
}

/// The unit vector of an axis.
pub fn unit(axis: Axis) -> PerAxis<f64> {
    PerAxis::from_fn(|other| f64::from(other == axis))
}

/// Error (µm) and rotation (µrad) of the tool point by small rotations of rigid axes, each of which swings what
/// stands after it.
///
/// formula  e = r₁ × (a₂ + a₃ + t) + r₂ × (a₃ + t) + r₃ × t        r = r₁ + r₂ + r₃
/// shape    `order`: axes 1, 2, 3 from the workpiece to the tool; `rotation_urad`: r by axis; `arm_mm`: a, positions
///          less the offsets of the levers; `tool_mm`: t
/// source   docs/volume.md §2
pub fn displaced(
    order: [Axis; 3],
    rotation_urad: impl Fn(Axis) -> PerAxis<f64>,
    arm_mm: PerAxis<f64>,
    tool_mm: PerAxis<f64>,
) -> [PerAxis<f64>; 2] {
    let (mut error, mut sum, mut arm) = (PerAxis::default(), PerAxis::default(), tool_mm);
    for axis in order.into_iter().rev() {
        let rotation = rotation_urad(axis);
        error = rotation.cross(arm).times(1e-3).plus(error);
        sum = rotation.plus(sum);
        arm[axis] += arm_mm[axis];
    }
    [error, sum]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_chain_reads_back_from_its_own_text() {
        let chains: Vec<Chain> = Chain::all().collect();
        assert_eq!(chains.len(), 24);
        for chain in chains {
            assert_eq!(Chain::parse(&chain.to_string()), Some(chain), "{chain}");
        }
        for wrong in ["", "XYZ", "wXYZ", "wXXZt", "wXYZtt", "twXYZ", "wxyzt", "wXYZwt", "wXYZAt"] {
            assert_eq!(Chain::parse(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn the_order_runs_from_the_workpiece_to_the_tool() {
        let order = |text: &str| {
            let order = Chain::parse(text).expect("a chain").order();
            order.map(Axis::letter).iter().collect::<String>()
        };
        assert_eq!(order("wXYZt"), "XYZ");
        assert_eq!(order("XwYZt"), "XYZ", "same rows as wXYZt");
        assert_eq!(order("XYwZt"), "YXZ", "B and M exchanged");
        assert_eq!(order("XYZwt"), "ZYX");
    }

    #[test]
    fn seventeen_of_the_errors_act_and_the_roll_of_axis_one_twice() {
        for chain in Chain::all() {
            let effects = Rotation::all().map(|rotation| chain.effects(rotation).len());
            let effects: Vec<usize> = effects.collect();
            assert_eq!(effects.iter().filter(|count| **count > 0).count(), 5, "{chain}");
            assert_eq!(effects.iter().sum::<usize>(), 6, "{chain}");
            assert_eq!(effects.iter().filter(|count| **count == 2).count(), 1, "{chain}");
        }
    }

    /// Rows of the reference for two orders: sign, arm, direction of every effect.
    #[test]
    fn the_rows_are_those_of_the_reference() {
        let rows = |text: &str| {
            let chain = Chain::parse(text).expect("a chain");
            let mut rows: Vec<String> = Rotation::all()
                .flat_map(|rotation| {
                    chain.effects(rotation).into_iter().map(move |effect| {
                        let sign = if effect.sign > 0.0 { '+' } else { '-' };
                        format!("{}:{sign}{rotation} {}", effect.direction, effect.arm)
                    })
                })
                .collect();
            rows.sort();
            rows.join(", ")
        };
        assert_eq!(rows("wXYZt"), "X:+EBX Z, X:+EBY Z, X:-ECX Y, Y:-EAX Z, Y:-EAY Z, Z:+EAX Y");
        assert_eq!(rows("wZXYt"), "X:-ECX Y, X:-ECZ Y, Y:+ECZ X, Z:+EAX Y, Z:+EAZ Y, Z:-EBZ X");
    }
}
