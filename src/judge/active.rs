//! The tables that were active while measuring: what the control held, and what it did.
//!
//! ```text
//!   kit directory, or files read out of the control ─→ readers ─→ ActiveControl
//!                                                                      ▼ emulate
//!   measured errors (residual under these tables) ──────────→ − old correction
//!                                                                      ▼
//!                                        model of the machine without compensation
//! ```
//! The new tables are planned for the machine without compensation, so new = old + residual. What
//! is forecast as *before* stays what was measured.
//!
//! A backlash parameter that the new tables do not replace acts before and after alike and is
//! left out of both; with `two-tables` and `curve-and-parameter`, which set it, it is part of the
//! old correction and has to be known.
//!
//! What acted is one thing, what a read-out holds another: [`Held`] keeps all of it for the way
//! back, with the tables that were switched off and the parameters that no table needs.

mod kit;
mod machine;
mod read_out;
mod reading;

pub use self::kit::{Fault, faults, from_kit};
pub(crate) use self::kit::{listed, named_axis};
pub(crate) use self::machine::uncompensated;
pub use self::read_out::from_read_out;
pub(crate) use self::read_out::{collisions, left_over, switched_off};
pub use self::reading::{ActiveControl, Held, Origin, Others, ReadOutFor, without_tables};
pub(crate) use self::reading::{Found, NamedBacklash, ReadOutReader};
