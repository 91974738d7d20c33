//! Forecast, verdict, and the causes where a second measurement differs from the forecast.
//!
//! `family` is the trait by which each family of controls, in its own folder, judges what was read out.

mod fanuc;
mod listed;
mod refusals;
mod siemens;

pub mod active;
pub mod after;
pub mod causes;
pub mod conformity;
pub mod disagreement;
pub(crate) mod family;
pub(crate) mod field;
pub mod findings;
pub mod forecast;
