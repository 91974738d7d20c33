//! **nonius** turns laser measurements of a machine tool into the compensation files its
//! control loads, and forecasts from the written bytes what they will leave.
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
//!              forecast ←─ its control: what it would add ←─ reader of the family: bytes → table
//!                  ▼
//!        verdict, manifest.json
//! ```
//!
//! Before a measurement: job.toml ─→ visit_plan: variants of the run ─→ separation of readings of 0 ─→ U, time.
//!
//! For the measurement: job.toml ─→ program: motion ─→ templates/ ─→ part programs ─→ read back, walk.
//!
//! At the machine: a second measurement ─→ after: as found, forecast, as left ─→ causes, when it differs.
//!
//! Before it, as a rehearsal: curves, bytes of the tables ─→ simulate: readings that say so of themselves.
//!
//! In the volume: model ─→ volume_model: 21 errors, any chain ─→ space ─→ definitions, assessment
//! (as the machine is, and with the emulated tables).
//!
//! Along a tool path: part program ─→ nc: moves ─→ tool_path: error along them.
//!
//! Beside it: runs.csv ─→ target_runs ─→ standards, the positioning figures of one axis.
//!
//! Eleven rooms and the command line, in the order in which the data flow; a room imports only from those
//! before it (`tests/order.rs` checks it):
//!
//! | room | what it is |
//! | --- | --- |
//! | [`quantity`] | axes, units, signs, places, curves |
//! | [`text`] | files of people and machines in, problems with places out |
//! | [`control`] | what a control is and remembers |
//! | [`inputs`] | what a person brings |
//! | [`machine`] | what the machine does wrong |
//! | [`write`] | what the control shall hold, as bytes |
//! | [`read`] | bytes → what the control would add; imports only `quantity`, `text`, `control` |
//! | [`volume`] | errors in space and along a path |
//! | [`judge`] | does it help, and if not, why |
//! | [`kit`] | the directory, its history, its rehearsal |
//! | [`page`] | what a person looks at: pictures, and the page that is handed over |
//! | [`cli`] | arguments, files, pages: no domain logic |
//!
//! `write` and `read` have nothing in common but the tables of `control`, so a mistake of a template is found
//! by reading. Only `cli` touches files and terminal.
//!
//! Where to find what:
//! * **where a sign changes**: `impl Neg` of deviation and of correction in [`quantity::units`]; what a control's table means:
//!   [`control::controller::TableSign`]
//! * **where a limit of a control comes from**: `controllers/<id>.toml`, each fact with its source
//! * **where something is rounded**: [`write::siemens`], [`write::fanuc`], once, on totals
//! * **what a control does with a table**: `control.rs` in the folder of its family, [`read::siemens`] …
//! * **where a new control goes**: a profile alone; or, for a new family, `write/<family>`, `read/<family>`, `judge/<family>`,
//!   its facts and tables in `control`, a profile, templates (docs/controllers.md §3)
//!
//! The library serves the program and its tests; its interface may change in every version.
//! What other programs may rely on stands in docs/interface.md.

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

pub mod cli;
