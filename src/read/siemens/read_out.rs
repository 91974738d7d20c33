//! What a control wrote of itself: what the lines of its files say of the compensation.
//!
//! ```text
//!   file ─→ sections (%_N_NAME_EXT) ─→ lines: of a table, of machine data, of no concern
//! ```
//! A file holds active data (`…_INI`) and part programs (`…_MPF`, `…_SPF`), one or many after the other. A
//! program lies in the memory and does nothing until somebody runs it, so what it would write is no
//! state of the control.

use super::statement::{BLANKS, block_number, code_of, is_end, take_word};
use super::variable::{data, is_of_table};
use crate::control::controller::ControlUnit;
use crate::read::lexer::{Cursor, lines};
use std::ops::Range;

/// Whether a file is a commissioning archive of an 840D sl: its first header begins so (a real one of 2016).
pub(super) fn is_archive(bytes: &[u8]) -> bool {
    bytes.starts_with(b"@@MMCIBN.")
}

/// The lines of a file with the part program that each stands in: a section that is one, or lies in a
/// folder of programs and workpieces. A file without headers is a program where its own name says so.
pub(super) fn sections<'a>(
    file: &'a str,
    text: &'a str,
) -> impl Iterator<Item = (Range<usize>, Option<&'a str>)> {
    const APART: [&str; 5] = ["_N_WKS_DIR", "_N_MPF_DIR", "_N_SPF_DIR", "_N_CST_DIR", "_N_CUS_DIR"];
    let mut lines = lines(text).peekable();
    let mut program = is_program(file).then_some(file);
    std::iter::from_fn(move || {
        let line = lines.next()?;
        if let Some(name) = header(&text[line.clone()]) {
            let next = lines.peek().map_or("", |next| text[next.clone()].trim());
            let path = next.to_ascii_uppercase();
            let lies_apart =
                path.starts_with(";$PATH=") && APART.iter().any(|folder| path.contains(folder));
            program = (is_program(name) || lies_apart).then_some(name);
        }
        Some((line, program))
    })
}

/// The name in the header of a section.
pub(super) fn header(line: &str) -> Option<&str> {
    line.trim().strip_prefix("%_N_")
}

/// Whether a name is that of a part program.
pub(super) fn is_program(name: &str) -> bool {
    let name = name.to_ascii_uppercase().replace('.', "_");
    name.ends_with("_MPF") || name.ends_with("_SPF")
}

/// What a line is to the compensation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Concern {
    /// None.
    Nothing,
    /// An assignment of no concern.
    PassedOver,
    /// `METRIC` or `INCH`: the unit of the data, whichever the control counts in.
    Unit(ControlUnit),
    /// An end word.
    End,
    /// Of a table.
    Table,
    /// A machine or setting datum that is read beside tables; or no plain assignment that writes data of the
    /// compensation all the same, as `IF R1==1 $MA_CEC_ENABLE[AX1]=0`, or is a broken one.
    Data,
}

/// What a line is to the compensation, and its code.
pub(super) fn concern(text: &str, line: &Range<usize>) -> (Concern, Range<usize>) {
    let code = code_of(text, line);
    let without = without_checksum(&text[code.clone()]);
    let code = code.start..code.start + without.len();
    let mut cursor = Cursor::new(text, code.clone(), BLANKS);
    cursor.peek_word();
    block_number(&mut cursor);
    let found = match cursor.peek_word() {
        None => Concern::Nothing,
        Some('$') => assignment(&mut cursor),
        Some(_) => word(&mut cursor),
    };
    (found, code)
}

fn assignment(cursor: &mut Cursor<'_>) -> Concern {
    let whole = cursor.text(cursor.rest());
    cursor.at += 1;
    let name = take_word(cursor);
    // Of the reference point values the first alone: the others are for further reference cams.
    let is_other_cam = || {
        let mut behind = cursor.clone();
        behind.eat("[");
        behind.peek_word();
        name == "MA_REFP_SET_POS" && behind.digits() != "0"
    };
    if is_of_table(&name) {
        Concern::Table
    } else if data().any(|known| known == name) && !is_other_cam() {
        Concern::Data
    } else if whole.contains('=') {
        Concern::PassedOver
    } else {
        mentions_data(whole)
    }
}

fn word(cursor: &mut Cursor<'_>) -> Concern {
    const LONGEST: usize = 6;
    let whole = cursor.text(cursor.rest());
    if whole.len() > LONGEST {
        return mentions_data(whole);
    }
    match whole.to_ascii_uppercase().as_str() {
        "METRIC" => Concern::Unit(ControlUnit::Millimetre),
        "INCH" => Concern::Unit(ControlUnit::Inch),
        word if is_end(word) => Concern::End,
        _ => Concern::Nothing,
    }
}

fn mentions_data(code: &str) -> Concern {
    if !code.contains('$') {
        return Concern::Nothing;
    }
    let code = code.to_ascii_uppercase();
    let mut names = data().chain(["AA_ENC_COMP", "AN_CEC"]);
    match names.any(|name| code.contains(&format!("${name}"))) {
        true => Concern::Data,
        false => Concern::Nothing,
    }
}

/// Code without the checksum that a control may write behind an assignment: blank, apostrophe,
/// four hexadecimal digits (MD11230 `MD_FILE_STYLE`; 840D/810D Start-Up Guide 03/2006, 11.12.1).
/// It is ignored, not checked: how it is computed is not published.
fn without_checksum(code: &str) -> &str {
    let Some((statement, sum)) = code.rsplit_once('\'') else {
        return code;
    };
    let digits = sum.trim_end();
    let is_sum = digits.len() == 4 && digits.bytes().all(|b| b.is_ascii_hexdigit());
    match is_sum && statement.contains('=') && statement.ends_with([' ', '\t']) {
        true => statement,
        false => code,
    }
}
