//! Files read out of a control: the lines that concern the compensation, the rest passed over.
//!
//! An archive of machine data or a full parameter file holds thousands of numbers of no concern,
//! in forms that the readers of compensation files refuse. Here such lines are blanked out, at
//! the same places, so that the strict readers judge what is left and their line numbers hold.

mod archive;
mod fanuc;
mod siemens;

pub use fanuc::fanuc;
pub use siemens::{Programs, SiemensText, has_active_data, siemens};

use crate::control::controller::Dialect;
use crate::read::family::family;
use crate::text::problem::Problem;
use std::borrow::Cow;

/// A file with more data of no concern than this was read out of a control as a whole, which has
/// thousands. What a kit writes is of concern throughout; a person may have added a few lines.
const READ_OUT_AS_A_WHOLE: usize = 100;

/// Whether a file is a control's whole parameter file or archive.
pub fn is_whole(bytes: &[u8], dialect: &Dialect) -> bool {
    if archive::is_archive(bytes) {
        return true;
    }
    let Some(text) = text(bytes) else {
        return false;
    };
    family(dialect).passed_over(&text) > READ_OUT_AS_A_WHOLE
}

/// Name and text.
pub type Text<'a> = (String, Cow<'a, str>);

/// The file that a text is of: an archive for its files.
pub(crate) fn file_of(name: &str) -> &str {
    name.split("/_N_").next().unwrap_or(name)
}

/// A file as text, an archive as its files: `all.arc/_N_AX_EEC_INI`.
pub fn texts<'a>(name: &str, bytes: &'a [u8]) -> Result<Vec<Text<'a>>, Problem> {
    let not_text = |name: &str| {
        Problem::new(format!("`{name}` is not text"))
            .help("name the files that the control wrote as text")
    };
    if !archive::is_archive(bytes) {
        let text = text(bytes).ok_or_else(|| not_text(name))?;
        return Ok(vec![(name.to_string(), text)]);
    }
    let parts = archive::parts(name, bytes)?;
    let own = |part: archive::Part<'a>| {
        let name = format!("{name}/{}", part.name);
        let text = text(part.bytes).ok_or_else(|| not_text(&name))?;
        Ok((name, text))
    };
    parts.into_iter().map(own).collect()
}

/// A file as text: UTF-8 without its byte order mark, or one byte for each character (Latin-1), as
/// older controls write comments and messages. `None` where it is neither.
fn text(bytes: &[u8]) -> Option<Cow<'_, str>> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Some(Cow::Borrowed(text.strip_prefix('\u{feff}').unwrap_or(text))),
        Err(_) if bytes.contains(&0) => None,
        Err(_) => Some(bytes.iter().map(|byte| char::from(*byte)).collect()),
    }
}
