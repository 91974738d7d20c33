//! From the bytes to the correction that the control would apply, independent of how they were written.
//!
//! ```text
//!   bytes ─→ family: its reader ─→ Tables ─→ its control ─→ Response (base axis, output axis, direction)
//! ```
//! Each family of controls has a folder with a reader of its files, written only from the references of the
//! formats, and an emulator of its control. A reader shares only the table type ([`crate::control::table`])
//! with the templates; it accepts what a control accepts, and names line and column where a control would stop.

pub mod declared;
pub mod emulate;
mod family;
pub mod fanuc;
mod findings;
pub mod generic;
pub mod isg;
mod lexer;
pub mod linuxcnc;
mod listed;
pub mod program;
mod refusals;
pub mod siemens;

pub use self::family::{
    FileData, ReadBack, check_examples, emulator, is_whole, read, read_apart, read_out_text,
};
pub(crate) use self::family::{file_name, may_be_meant_for, unread};
pub(crate) use self::findings::ReadFinding;
