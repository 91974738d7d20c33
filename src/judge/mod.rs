//! Does it help, and if not, why.
//!
//! `family` is what each family of controls tells in its own way of what was read out, in a folder of its own.

mod fanuc;
mod generic;
mod siemens;

pub mod active;
pub mod after;
pub(crate) mod before;
pub mod causes;
pub mod conformity;
pub mod disagreement;
pub(crate) mod family;
pub mod findings;
pub mod forecast;
