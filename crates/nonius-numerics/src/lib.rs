//! Axes, units, signs, curves; what is uncertain of figures that hang on many readings; and how far the errors of two places
//! can differ. No file, no control, no job.
#![doc = include_str!("../README.md")]

pub mod banded;
pub mod draws;
pub mod quantity;
pub mod rows;
pub mod space;
pub mod threads;
