//! **nonius** turns laser measurements of a machine tool into the compensation files its control loads,
//! and forecasts the residual errors from the written bytes.
//!
//! ```text
//!  another maker's file ─→ import ─→ errors.csv
//!
//!  errors.csv ─→ error_table ─┐                      controllers/*.toml ─→ controller
//!  job.toml   ─→ job ─────────┤                                               │
//!                             ▼                                               │
//!              model: nine error curves, zero at the reference                │
//!                             ▼                                               ▼
//!     target (two directions) ─→ selection ─→ grid, fit ─→ plan ─→ family: counts
//!                                                                       ▼
//!                                                     templates/ ─→ emit ─→ BYTES
//!                                                                             ▼
//!              forecast ←─ its control: the correction ←─ reader of the family: bytes → table
//!                  ▼
//!        verdict, manifest.json
//! ```
//!
//! Before a measurement: job.toml ─→ visit_plan: variants of the run ─→ separation of readings of 0 ─→ U, time.
//!
//! For the measurement: job.toml ─→ program: motion ─→ templates/ ─→ part programs ─→ read back, executed.
//!
//! At the machine: a second measurement ─→ after: as found, forecast, as left ─→ causes where they differ.
//!
//! As a rehearsal: curves, bytes of the tables ─→ simulate: readings, marked as simulated.
//!
//! In the volume: model ─→ volume_model: 21 errors, any chain ─→ space ─→ definitions, assessment
//! (without and with the emulated tables).
//!
//! Along a tool path: part program ─→ crate part_program: moves ─→ tool_path: error along them.
//!
//! Separately: runs.csv ─→ target_runs ─→ standards, the positioning figures of one axis.
//!
//! Twelve rooms and the command line, in data-flow order; a room imports only from those before it
//! (checked by `tests/it/order.rs`):
//!
//! | room | what it is |
//! | --- | --- |
//! | [`quantity`] | axes, units, signs, positions, curves: the crate `nonius_numerics` |
//! | [`text`] | reads files; reports problems with file, line and column |
//! | [`control`] | facts about a control, and the tables in its memory |
//! | [`inputs`] | the user's files: job, error table, readings, part programs |
//! | [`machine`] | the errors of the machine: separation, model, figures by standard |
//! | [`write`] | from the errors to the bytes for the control |
//! | [`read`] | from the bytes to the correction of the control; imports only `quantity`, `text`, `control` and the crate `part_program` |
//! | [`volume`] | errors in the volume and along a tool path |
//! | [`judge`] | forecast, verdict, and causes of a difference |
//! | [`kit`] | the directory of files for a control, its history, its rehearsal |
//! | [`page`] | pictures, and the report that is handed over |
//! | [`visit`] | a job with everything that it names, on a disk or in memory |
//! | [`cli`] | arguments, screens, disk, terminal: no domain logic |
//!
//! `write` and `read` share only `control`, so reading back finds a mistake in a template. Only
//! `cli` touches files and terminal.
//!
//! Where to find what:
//! * **where a sign changes**: `impl Neg` of deviation and of correction in [`quantity`]; the sign of a control's
//!   table: [`control::controller::TableSign`]
//! * **where a limit of a control comes from**: `controllers/<id>.toml`, each fact with its source
//! * **where values are rounded**: in the family of [`write`], once, on totals
//! * **what a control does with a table**: the `Emulator` of its family in [`read`]
//! * **where a new control goes**: a profile alone; or, for a new family, `write/<family>`, `read/<family>`, `judge/<family>`,
//!   its facts and tables in `control`, a profile, templates (CONTRIBUTING.md)
//!
//! Another program runs any command on files in memory with [`cli::answer`]; without the feature `disk` nothing here
//! touches a disk (a browser).
//!
//! The library serves the program and its tests; its interface may change in every version.
//! docs/interface.md is the contract for other programs.

pub mod quantity;

pub mod text;

pub mod control;

pub mod inputs;

pub mod machine;

pub mod write;

pub mod read;

pub mod volume;

pub mod judge;

pub mod kit;

pub mod page;

pub mod visit;

pub mod cli;
