//! What a control held of all that a kit changes.

use crate::control::table::Tables;
use crate::judge::active::{ActiveControl, Held, Origin};
use crate::quantity::Axis;
use crate::read::siemens::MachineDatum;
use crate::text::grouped;
use crate::write::compensation::Compiled;
use crate::write::plan::{Plan, Task};

/// A kit, and what the control held before it.
pub(crate) struct Before<'a> {
    pub(crate) task: Task<'a>,
    pub(crate) plan: &'a Plan,
    pub(crate) compiled: &'a Compiled,
    pub(crate) active: &'a ActiveControl,
    pub(crate) held: &'a Held,
}

impl<'a> Before<'a> {
    /// What was read out of the control; `None` where nothing was.
    pub(crate) fn of(
        task: Task<'a>,
        plan: &'a Plan,
        compiled: &'a Compiled,
        active: &'a ActiveControl,
    ) -> Option<Before<'a>> {
        let Origin::ReadOut(held) = &active.origin else {
            return None;
        };
        Some(Before { task, plan, compiled, active, held })
    }

    /// Who changes the backlash parameter of an axis, where it gets tables of its positioning.
    pub(super) fn backlash(&self, axis: Axis) -> Option<ChangedBy> {
        self.plan.of_axis(axis).next()?;
        let is_set = self.plan.sets_backlash(axis);
        Some(if is_set { ChangedBy::Precondition } else { ChangedBy::Nobody })
    }

    /// The tables of the kit, those that the control holds and those that act.
    pub(super) const fn tables(&self) -> [&Tables; 3] {
        [&self.compiled.tables, &self.held.tables, &self.active.tables]
    }
}

/// What the control held of all that the kit changes.
pub(crate) struct Old {
    pub(crate) tables: Tables,
    /// Switches, backlash and weights (Siemens).
    pub(crate) data: Vec<MachineDatum>,
    /// What no file that was read out holds.
    pub(crate) unknown: Vec<Unknown>,
    /// Tables that keep the values of the kit, switched off: they were reserved without a grid.
    pub(crate) stays: Vec<String>,
}

/// Something that the kit changes and no rollback file restores.
pub(crate) struct Unknown {
    /// Names, as the control shows them.
    pub(crate) what: String,
    pub(crate) by: ChangedBy,
}

/// What changes a datum beside the tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ChangedBy {
    /// A file of the kit.
    File,
    /// A person, because a precondition asks for a value.
    Precondition,
    /// Nobody: it acts in addition to the tables and goes along where it was read out.
    Nobody,
}

/// One name for all data of a kind: `MD32700 $MA_ENC_COMP_ENABLE[0,AX1], [0,AX2]`. `lacking`: of each its name, which of
/// those of this name, and by whom it is changed.
pub(crate) fn unknown(lacking: Vec<(String, String, ChangedBy)>) -> Vec<Unknown> {
    let groups = grouped(lacking.into_iter().map(|(name, index, by)| ((name, by), index)));
    let named = |((name, by), indices): ((String, ChangedBy), Vec<String>)| Unknown {
        what: name + &indices.join(", "),
        by,
    };
    groups.into_iter().map(named).collect()
}
