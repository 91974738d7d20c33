//! What Klipper's skew correction adds to a commanded position (docs/klipper.md §2):
//!
//! ```text
//!   x' = x − y·xy − z·(xz − xy·yz)        y' = y − z·yz        z' = z
//! ```
//! A response counts from the reference: what is added there is a shift of all positions, which no error against
//! the reference sees.

use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::KlipperFacts;
use crate::control::table::klipper::{KlipperTables, Skew};
use crate::quantity::axis::Direction;
use crate::quantity::units::{Correction, UM_PER_MM};
use crate::read::emulate::{Emulated, Emulator, Response};
use crate::read::pairs::known_axis;

/// A printer with a profile loaded.
#[derive(Clone, Debug)]
pub struct KlipperControl {
    /// By base and output, what is added in a mm, µm.
    slopes: Vec<([&'static str; 2], f64)>,
    state: ControlState,
}

impl KlipperControl {
    /// A printer that holds this profile.
    pub fn new(
        tables: &KlipperTables,
        facts: &KlipperFacts,
        state: &ControlState,
    ) -> KlipperControl {
        let slope = |factor: f64| facts.skew_sign.value.correction(factor * UM_PER_MM).um();
        let of = |skew: &Skew| {
            vec![
                (["y", "x"], slope(skew.xy)),
                (["z", "x"], slope(skew.xz - skew.xy * skew.yz)),
                (["z", "y"], slope(skew.yz)),
            ]
        };
        KlipperControl {
            slopes: tables.skew.as_ref().map_or_else(Vec::new, of),
            state: state.clone(),
        }
    }
}

impl Emulator for KlipperControl {
    fn connected_axes(&self) -> Vec<(String, String)> {
        let acting = self.slopes.iter().filter(|(_, slope)| slope.abs() > 0.0);
        let pairs = acting.map(|([base, output], _)| (base.to_string(), output.to_string()));
        pairs.collect()
    }

    fn response(&self, base: &str, output: &str, _direction: Direction) -> Emulated<Response> {
        let (base, output) = (known_axis(&self.state, base)?, known_axis(&self.state, output)?);
        let is_it = |pair: &[&str; 2]| pair[..] == [&*base.name, &*output.name];
        let own = self.slopes.iter().find(|(pair, _)| is_it(pair));
        let line = own.and_then(|(_, slope)| line(base, *slope));
        Ok(line.unwrap_or_default())
    }
}

/// Over the travel, zero at the reference.
fn line(base: &AxisState, slope: f64) -> Option<Response> {
    let (low, high) = base.travel;
    let at = |place| Correction::from_um(slope * (place - base.reference.mm()));
    let ends = [low.mm(), high.mm()];
    Response::straight(&ends, &ends.map(at))
}
