//! A HAL file that corrects joints by the positions of others: its lines into statements, components with their
//! pins ([`netlist`]), and what each corrected joint gets ([`corrections`]).
//!
//! Written from the manual pages halcmd(1), lincurve(9) and sum2(9) and the runs of docs/linuxcnc.md §0. Only what
//! such a file needs is read: a line or component of another kind is refused, because it could add something.

mod corrections;
mod netlist;
mod statement;

use self::netlist::Netlist;
use self::statement::statements;
use crate::control::controller::LinuxcncFacts;
use crate::control::table::linuxcnc::CrossTable;
use crate::read::lexer::{Complaint, located};
use crate::text::problem::Problems;

/// The tables of a file, ascending by output and base.
///
/// **limits** names the first thing that is wrong: what follows from it would only repeat it
pub(super) fn tables(
    file: &str,
    text: &str,
    facts: &LinuxcncFacts,
) -> Result<Vec<CrossTable>, Problems> {
    read(text, facts).map_err(|complaint| located(file, text, vec![complaint]))
}

fn read(text: &str, facts: &LinuxcncFacts) -> Result<Vec<CrossTable>, Complaint> {
    let mut netlist = Netlist::default();
    for words in statements(text) {
        netlist.take(&words, facts)?;
    }
    corrections::of(&netlist)
}

/// Whether a text is a HAL file: one of its lines is a statement of one.
pub(super) fn is_hal(text: &str) -> bool {
    const WORDS: [&str; 4] = ["loadrt", "addf", "net", "setp"];
    statements(text).any(|words| WORDS.contains(&words[0].text))
}
