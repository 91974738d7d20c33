//! A control that holds one correction for each pair of axes and each direction: what most families make of their
//! tables.
//!
//! ```text
//!   correction(A while B moves) = that of the pair (B, A) in the direction
//!                                 − backlash of A where A = B, unless the table of A stands in place of it
//! ```

use crate::control::control_state::{AxisState, ControlState};
use crate::quantity::Direction;
use crate::read::emulate::{CannotEmulate, Emulated, Emulator, Response};

/// What one axis gets because another one, or itself, stands somewhere.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    pub(super) base: String,
    pub(super) output: String,
    /// While the base axis moves in +, and in −.
    pub(super) ways: [Response; 2],
}

impl Pair {
    pub(super) fn is_for(&self, base: &str, output: &str) -> bool {
        self.base.eq_ignore_ascii_case(base) && self.output.eq_ignore_ascii_case(output)
    }
}

/// A control with its tables in memory.
#[derive(Clone, Debug)]
pub(super) struct PairControl {
    pairs: Vec<Pair>,
    /// Whether the table of an axis for itself stands in place of its backlash parameter.
    replaces_backlash: bool,
    state: ControlState,
}

impl PairControl {
    /// A control with these corrections, one for each pair.
    ///
    /// **limits** fails if an axis is not one of the control
    pub(super) fn new(
        pairs: Vec<Pair>,
        replaces_backlash: bool,
        state: &ControlState,
    ) -> Emulated<PairControl> {
        for name in pairs.iter().flat_map(|pair| [&pair.base, &pair.output]) {
            known_axis(state, name)?;
        }
        Ok(PairControl { pairs, replaces_backlash, state: state.clone() })
    }
}

impl Emulator for PairControl {
    fn connected_axes(&self) -> Vec<(String, String)> {
        let names = |pair: &Pair| (pair.base.clone(), pair.output.clone());
        self.pairs.iter().map(names).collect()
    }

    fn response(&self, base: &str, output: &str, direction: Direction) -> Emulated<Response> {
        let own = self.pairs.iter().find(|pair| pair.is_for(base, output));
        let way = usize::from(direction == Direction::Minus);
        let mut response = own.map(|own| own.ways[way].clone()).unwrap_or_default();
        let is_replaced = self.replaces_backlash && own.is_some();
        if base.eq_ignore_ascii_case(output) && !is_replaced {
            response.shift(known_axis(&self.state, base)?.backlash(direction));
        }
        Ok(response)
    }
}

/// The axis of a name.
pub(super) fn known_axis<'a>(state: &'a ControlState, name: &str) -> Emulated<&'a AxisState> {
    let axis = state.axis(name);
    axis.ok_or_else(|| CannotEmulate(format!("foreign axis: the job has no axis `{name}`")))
}
