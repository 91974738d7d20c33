//! Files read out of a control: the lines that concern the compensation, the rest passed over.
//!
//! An archive of machine data or a full parameter file holds thousands of numbers of no concern,
//! in forms that the readers of compensation files refuse. Here such lines are blanked out, at
//! the same places, so that the strict readers judge what is left and their line numbers hold.

mod fanuc;
mod siemens;

pub use fanuc::fanuc;
pub use siemens::{Programs, SiemensText, has_active_data, siemens};

use crate::controller::Dialect;
use std::borrow::Cow;

/// A file with more data of no concern than this was read out of a control as a whole, which has
/// thousands. What a kit writes is of concern throughout; a person may have added a few lines.
const READ_OUT_AS_A_WHOLE: usize = 100;

/// Whether a file is a control's whole parameter file or archive.
pub fn is_whole(text: &str, dialect: &Dialect) -> bool {
    let passed_over = match dialect {
        Dialect::Siemens(_) => siemens("", text, true).passed_over,
        Dialect::Fanuc(facts) => fanuc(text, facts).1,
        Dialect::Generic(_) => 0,
    };
    passed_over > READ_OUT_AS_A_WHOLE
}

/// A file as text: UTF-8 without its byte order mark, or one byte for each character (Latin-1), as
/// older controls write comments and messages. `None` where it is neither.
pub fn text(bytes: &[u8]) -> Option<Cow<'_, str>> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Some(Cow::Borrowed(text.strip_prefix('\u{feff}').unwrap_or(text))),
        Err(_) if bytes.contains(&0) => None,
        Err(_) => Some(bytes.iter().map(|byte| char::from(*byte)).collect()),
    }
}
