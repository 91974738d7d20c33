//! Does it help, and if not, why.

pub mod active;
pub mod conformity;
pub mod forecast;
pub mod after;
pub mod causes;
pub mod disagreement;
