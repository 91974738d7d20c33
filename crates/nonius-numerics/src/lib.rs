//! Axes, units, signs, curves; and how far the errors of two places can differ. No file, no control, no job.
#![doc = include_str!("../README.md")]

pub mod quantity;
pub mod space;
