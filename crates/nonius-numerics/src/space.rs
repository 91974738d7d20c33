//! Errors in space: the error vectors of a whole grid, and how far two of them can differ.
//!
//! The volumetric accuracy of a machine is the largest difference of two error vectors. A grid
//! of 21 nodes an axis has 43 million pairs, one of 401 nodes 2·10¹⁵; none of the methods here
//! but [`histogram`] looks at all of them. They work on numbers alone: no job, no file. Vectors are plain arrays: in a
//! program that is not optimised those of nalgebra take fifty times as long.
//!
//! ```text
//! curves at the nodes ─→ grid_map ─┬─→ diameter: volumetric accuracy, its pair, every sub-volume of a size
//!                                  ├─→ boxes: error of a length, ranges, largest from a place
//!                                  ├─→ histogram: all differences, or an estimate of them
//!                                  └─→ grouping: the method of paper 002, for comparison
//! places without a grid ───────────→ cloud
//! ```
//!
//! **One routine decides.** [`GridMap::at`](grid_map::GridMap::at) computes a vector in a fixed
//! order of operations, [`pair::square`] a squared difference. Everything else only leaves out
//! pairs that cannot matter, with room for rounding, so that a figure has the same digits on
//! every processor. docs/volume.md §6 tells it in brief.

pub mod grid_map;

pub mod pair;

pub mod diameter;

pub mod boxes;

pub mod histogram;
