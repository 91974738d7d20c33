//! What files hold beyond, short of or against what the job writes, in words.
//!
//! Emulation sees only what moves an axis of the job. A job owns its tables, their switches and
//! their memory and nothing else, so everything else in a file is told here: foreign points, foreign parameters, foreign machine data.

mod fanuc;
mod generic;
mod siemens;
mod words;

use crate::control::controller::{Dialect, Profile};
use crate::control::table::Tables;
use crate::judge::disagreement::Diagnosis;
use crate::read::ReadBack;

/// Everything surplus, missing or contradictory, one sentence each.
///
/// **limits** what `diagnosis` already explains is not told again; without a diagnosis (tables
/// that cannot be emulated, whose reason is told elsewhere) only what is surplus is told of the
/// tables, and everything of the machine data.
pub fn contents(
    profile: &Profile,
    wanted: &Tables,
    read: &ReadBack,
    diagnosis: Option<&Diagnosis>,
) -> Vec<String> {
    match (&profile.dialect, wanted, &read.tables) {
        (Dialect::Siemens(facts), Tables::Siemens(wanted), Tables::Siemens(found)) => {
            let mut words = siemens::tables(wanted, found, diagnosis);
            words.extend(siemens::unwritten(&read.unwritten));
            words.extend(siemens::machine_data::differences(
                wanted,
                &read.machine_data,
                facts,
            ));
            words
        }
        (Dialect::Fanuc(_), Tables::Fanuc(wanted), Tables::Fanuc(found)) => {
            fanuc::memory(wanted, found, diagnosis)
        }
        (Dialect::Generic(_), Tables::Generic(wanted), Tables::Generic(found)) => {
            generic::rows(wanted, found, diagnosis)
        }
        _ => Vec::new(),
    }
}

/// What nobody can judge because the files for it are not there, and what to see to instead.
pub fn absent(profile: &Profile, wanted: &Tables, read: &ReadBack) -> Vec<String> {
    let mut words = match (&profile.dialect, wanted) {
        (Dialect::Siemens(facts), Tables::Siemens(wanted)) => {
            siemens::machine_data::absent(wanted, &read.machine_data, facts)
        }
        _ => Vec::new(),
    };
    words.extend(read.notes.iter().cloned());
    words
}
