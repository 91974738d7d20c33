//! Bytes to what the control would add. Knows nothing of how they were written.

pub mod emulate;
pub mod readback;
