//! Where the zero of the program lies: coordinate systems, G52, G92 and the tool length.
//!
//! ```text
//!   machine = program + system (G54 …) + local (G52) + shift (G92) + tool length in Z (G43)
//! ```

use crate::inputs::nc::{Place, Setup};
use std::collections::BTreeMap;

#[derive(Clone, Debug)]
pub(super) struct Offsets {
    systems: BTreeMap<u32, Place>,
    tools: BTreeMap<u32, f64>,
    active: u32,
    local: Place,
    shift: Place,
    tool: Option<f64>,
    /// What the tool length changed since Z was last positioned.
    pub(super) pending_z: f64,
    base: Option<Place>,
}

impl Offsets {
    pub(super) fn new(setup: &Setup) -> Offsets {
        let mut offsets = Offsets {
            systems: setup.systems.clone(),
            tools: setup.tools.clone(),
            active: 1,
            local: [0.0; 3],
            shift: [0.0; 3],
            tool: None,
            pending_z: 0.0,
            base: None,
        };
        offsets.update();
        offsets
    }

    fn update(&mut self) {
        let system = self.systems.get(&self.active);
        self.base = system.map(|system| {
            let tool = [0.0, 0.0, self.tool.unwrap_or(0.0)];
            std::array::from_fn(|k| system[k] + self.local[k] + self.shift[k] + tool[k])
        });
    }

    /// Machine coordinates of the program's zero; `None` where that of the system is not known.
    #[inline]
    pub(super) fn base(&self) -> Option<Place> {
        self.base
    }

    pub(super) fn tool(&self) -> Option<f64> {
        self.tool
    }

    pub(super) fn active(&self) -> u32 {
        self.active
    }

    pub(super) fn select(&mut self, system: u32) {
        self.active = system;
        self.update();
    }

    /// Whether the coordinate system is in the table (or was set by G10).
    pub(super) fn knows(&self, system: u32) -> bool {
        self.systems.contains_key(&system)
    }

    /// G10 L2: sets words of a system; of one that is not known all three are needed.
    pub(super) fn set_system(&mut self, system: u32, words: [Option<f64>; 3], add: bool) -> bool {
        let known = self.systems.get(&system).copied();
        let complete = !add && words.iter().all(Option::is_some);
        let Some(old) = known.or(complete.then_some([0.0; 3])) else {
            return false;
        };
        let new = std::array::from_fn(|k| match words[k] {
            Some(value) if add => old[k] + value,
            Some(value) => value,
            None => old[k],
        });
        self.systems.insert(system, new);
        self.update();
        true
    }

    /// G52: the zero of the program within its system.
    pub(super) fn set_local(&mut self, axis: usize, value: f64) {
        self.local[axis] = value;
        self.update();
    }

    /// G92: the place `at` is called `value` from now on.
    pub(super) fn call(&mut self, axis: usize, at: f64, value: f64) {
        if let Some(base) = self.base {
            self.shift[axis] += at - (base[axis] + value);
            self.update();
        }
    }

    /// G92.1.
    pub(super) fn cancel_shift(&mut self) {
        self.shift = [0.0; 3];
        self.update();
    }

    /// G43 H: false if the length is not in the table.
    pub(super) fn use_tool(&mut self, number: u32) -> bool {
        // H0 is no length, on every control.
        let length = if number == 0 {
            Some(0.0)
        } else {
            self.tools.get(&number).copied()
        };
        if let Some(length) = length {
            self.change_tool(Some(length));
        }
        length.is_some()
    }

    /// G49.
    pub(super) fn no_tool(&mut self) {
        self.change_tool(None);
    }

    fn change_tool(&mut self, length: Option<f64>) {
        self.pending_z += length.unwrap_or(0.0) - self.tool.unwrap_or(0.0);
        self.tool = length;
        self.update();
    }
}
