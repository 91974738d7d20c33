//! What a read-out holds around the tables, against what the job asks of the control there.

mod fanuc;
mod siemens;

use crate::control::table::Tables;
use crate::judge::active::{ActiveControl, Origin};
use crate::write::compensation::Compiled;
use crate::write::plan::Plan;

/// What was found around the tables, one sentence each.
#[derive(Clone, Debug, Default)]
pub struct Surroundings {
    /// What contradicts the job.
    pub disagreements: Vec<String>,
    /// What acts beside the tables and is not emulated, or may: nothing is decided in favour.
    pub beside: Vec<String>,
    /// What no file holds and is taken as the job asks.
    pub notes: Vec<String>,
}

/// Compares them; what is not read out of a control has no surroundings.
pub fn surroundings(plan: &Plan, wanted: &Compiled, active: &ActiveControl) -> Surroundings {
    let mut found = Surroundings::default();
    let Origin::ReadOut(held) = &active.origin else {
        return found;
    };
    let state = &wanted.state;
    match (&wanted.tables, &held.tables) {
        (Tables::Siemens(tables), _) => found.of_siemens(state, tables, held),
        (Tables::Fanuc(tables), Tables::Fanuc(memory)) => {
            found.of_fanuc(plan, state, tables, memory);
        }
        _ => {}
    }
    found
}

impl Surroundings {
    fn absent(&mut self, what: Vec<String>) {
        if !what.is_empty() {
            self.notes.push(format!(
                "no file holds {}: taken as the job asks, see to the preconditions",
                what.join(", ")
            ));
        }
    }
}
