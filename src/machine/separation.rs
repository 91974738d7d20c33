//! Four body diagonals, walked in single-axis steps → nine errors, and what cannot be known.
//!
//! ```text
//!  readings ─→ corrections ─→ means over runs ─→ increments, filed under machine intervals
//!              temperature,    repeatability            │
//!              angles                  ┌────────────────┼─────────────────┐
//!                                      ▼                ▼                 ▼
//!                          shapes (formula 1)   closure (formula 2)   totals → metric (formula 7)
//!                                      │                │                 │   + linear axes, beams
//!                                      │         outliers, σ, χ²          ▼
//!                                      └───────────→ nine errors ←─── scales, squareness,
//!                                                       │             mirror tilt, rank
//!                                                       ▼
//!                                       uncertainty, Monte Carlo, report
//! ```
//! Reading errors are measured − nominal displacement along the laser, so an increment over a
//! step of axis k is, in the nine-error model (docs/method.md §3),
//!
//! ```text
//!   m_d = Σ_j s_dk s_dj (V_j/R) δ_j                        (d = PPP, NPP, PNP, PPN)
//!   δ_j = R/(4 V_j) Σ_d s_dk s_dj m_d                      (1)  least squares: the columns are orthogonal
//!   w   = Σ_d s_dk (s_x s_y s_z)_d m_d = 0                 (2)  what is left over: the closure
//! ```
//! A tilted mirror adds the same amount to every increment of a (diagonal, axis) pair. It leaves
//! the shapes of all nine curves alone and makes their slopes worthless; the slopes are taken
//! from the totals instead, see [`metric`].

pub mod campaign;
pub mod closure;
pub mod corrections;
pub mod curves;
mod exchange;
pub mod findings;
pub(crate) mod joint;
mod labels;
mod linear;
pub mod metric;
pub mod monte_carlo;
pub mod noise;
pub mod patterns;

pub mod readings;
pub mod reversal;
mod separate;
pub mod solved;
pub mod straight;
pub mod table;
pub mod uncertainty;

pub use self::campaign::{Campaign, MeasuredLine};
pub use self::linear::Part;
pub(crate) use self::separate::{Instrument, expected};
pub use self::separate::{Separation, separate};
pub use self::solved::{NineErrors, SeparatedError};
