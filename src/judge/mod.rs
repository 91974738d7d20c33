//! Does it help, and if not, why.

pub mod active;
pub mod after;
pub mod causes;
pub mod conformity;
pub mod disagreement;
pub mod findings;
pub mod forecast;
