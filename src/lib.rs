//! **nonius** turns laser measurements of a machine tool into the compensation files its
//! control loads, and proves that they help.
pub mod units;

pub mod axis;

pub mod problem;

pub mod document;

pub mod error_table;

pub mod controller;

pub mod curve;

pub mod fit;

pub mod job;

pub mod model;

pub mod grid;

pub mod target;

pub mod selection;

pub mod plan;

pub mod claims;

pub mod table;

pub mod control_state;

pub mod compensation;

pub mod emit;

pub mod readback;

pub mod emulate;

pub mod forecast;

pub mod disagreement;

pub mod manifest;

pub mod kit;

pub mod cli;
