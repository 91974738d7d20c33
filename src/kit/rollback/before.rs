//! What was in the control before.

use crate::control::table::Tables;
use crate::judge::active::{ActiveControl, Held};
use crate::read::siemens::MachineDatum;
use crate::write::compensation::Compiled;
use crate::write::plan::{Plan, Task};

/// A kit, and what the control held before it.
pub(super) struct Before<'a> {
    pub(super) task: Task<'a>,
    pub(super) plan: &'a Plan,
    pub(super) compiled: &'a Compiled,
    pub(super) active: &'a ActiveControl,
    pub(super) held: &'a Held,
}

/// What the control held of all that the kit changes.
pub(super) struct Old {
    pub(super) tables: Tables,
    /// Switches, backlash and weights (Siemens).
    pub(super) data: Vec<MachineDatum>,
    /// What no file that was read out holds.
    pub(super) unknown: Vec<Unknown>,
    /// What is left in the control although the kit brought it.
    pub(super) stays: Vec<String>,
}

/// Something that the kit changes and no rollback file restores.
pub(super) struct Unknown {
    /// Names, as the control shows them.
    pub(super) what: String,
    pub(super) by: ChangedBy,
}

/// What changes a datum beside the tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ChangedBy {
    /// A file of the kit.
    File,
    /// A person, because a precondition asks for a value.
    Precondition,
    /// Nobody: it acts beside the tables and goes along where it was read out.
    Nobody,
}

impl Unknown {
    pub(super) fn not_written(&self) -> String {
        let changes = match self.by {
            ChangedBy::File => "The files of this kit switch it",
            ChangedBy::Precondition | ChangedBy::Nobody => "A precondition may make you change it",
        };
        format!(
            "{}: not in the rollback files. {changes}, and the files that were read out hold it not at all or with several values. Look at it now and note it",
            self.what
        )
    }

    pub(super) fn by_hand(&self) -> String {
        match self.by {
            ChangedBy::File => format!(
                "{}: not in the rollback files; switch on what was on before this kit, as noted",
                self.what
            ),
            ChangedBy::Precondition | ChangedBy::Nobody => format!(
                "{}: not in the rollback files; where it was changed, bring back what was noted before this kit",
                self.what
            ),
        }
    }
}
