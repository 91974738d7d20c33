//! **nonius** turns laser measurements of a machine tool into the compensation files its
//! control loads, and proves that they help.
pub mod units;
pub mod axis;
pub mod problem;
pub mod controller;
pub mod table;
pub mod readback;
pub mod emulate;
