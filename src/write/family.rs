//! What differs from one family of controls to the next. Each family is a folder of this room that implements
//! the trait for the facts of its profiles; nothing else of the room asks which family it is.

use crate::control::control_state::ControlState;
use crate::control::controller::{ControlUnit, Dialect, Mechanism, Profile};
use crate::control::table::Tables;
use crate::inputs::job::Compensation;
use crate::quantity::{Deviation, ErrorTerm};
use crate::text::Problems;
use crate::write::compiled::{Bump, Compiled, Placement};
use crate::write::control_text::{Seen, Switch};
use crate::write::grid::LengthDigit;
use crate::write::selection::TableStock;
use crate::write::task::{Plan, PlannedTable, Target, Task};

/// A family of controls, on the writing side.
pub(crate) trait Family {
    /// What a name of an axis has to be, where it is not.
    fn expected_name(&self, name: &str) -> Option<&'static str>;

    /// The last digit of positions and spacings in the files.
    fn length_digit(&self, unit: ControlUnit) -> LengthDigit;

    /// Whether there can be a table for each direction of a term.
    fn takes_directions(&self, _term: ErrorTerm) -> bool {
        false
    }

    /// Whether a table stands in place of the backlash parameter of its axis, which then does nothing.
    fn replaces_backlash(&self) -> bool {
        false
    }

    /// The tables that the control has few of; `None` where it has enough for everything.
    fn budget(&self, _compensation: &Compensation) -> Option<TableStock> {
        None
    }

    /// Most points of a table for these targets, and of what.
    fn point_limit(&self, targets: &[&Target]) -> (u32, &'static str);

    /// Smallest distance of two points of an axis with this largest feed, mm.
    fn least_spacing_mm(&self, _max_feed: f64) -> f64 {
        0.0
    }

    /// Whether a point may lie behind the end of the travel.
    fn takes_points_beyond(&self) -> bool {
        true
    }

    /// Why the control cannot take a term at all; `None` = it can.
    fn refuses(&self, _term: ErrorTerm) -> Option<String> {
        None
    }

    /// Whether measured angles go into the files of this job.
    fn takes_angles(&self, _task: Task<'_>) -> bool {
        false
    }

    /// Puts a plan into the control's numbers.
    fn compile(&self, task: Task<'_>, plan: &Plan) -> Result<Compiled, Problems>;

    /// Whether a kit uses what a fact belongs to; what cannot be judged counts as used.
    fn uses(&self, _mechanism: Mechanism, _plan: &Plan, _tables: &Tables) -> bool {
        true
    }

    /// Whether the names of the axes say which axis of the control is meant.
    fn names_reach_axes(&self) -> bool {
        true
    }

    /// What the templates see of tables: names with finished texts; `None` for those of another family.
    fn context(&self, emitted: &Emitted<'_>) -> Option<Seen>;

    /// What the control's display shows once these tables act, a sentence each; none where no display is known.
    fn displayed(&self, _tables: &Tables, _state: &ControlState) -> Vec<String> {
        Vec::new()
    }

    /// Whether this control of the family has a mechanism.
    fn has(&self, _mechanism: Mechanism) -> bool {
        true
    }

    /// Whether a table belongs to one of these mechanisms.
    fn belongs(&self, _mechanism: Mechanism, _table: &PlannedTable) -> bool {
        true
    }

    /// Largest changes of a bump in one section that are tried in turn, counts; `None` = the slope alone limits.
    fn section_limits(&self, _mechanism: Mechanism) -> Vec<Option<i64>> {
        vec![None]
    }

    /// Whether a proof is a slope from the reference to the far end of the travel in place of a bump.
    fn proves_by_slope(&self) -> bool {
        false
    }

    /// Height above which the control cuts a table off, µm.
    fn cut_off_um(&self, _task: Task<'_>, _table: &PlannedTable) -> f64 {
        f64::INFINITY
    }

    /// The tables of a kit of one mechanism, zero but for the bump in the table of a term.
    fn proof_tables(&self, _proof: &ProofOf<'_>) -> Option<Tables> {
        None
    }

    /// What no proof of a kit writes and would keep what the control holds, zero in one of the proofs.
    fn zero_the_rest(&self, _kit: &Tables, _proofs: &mut [&mut Tables]) {}
}

/// What the files with tables are rendered from: those of the kit, or one that stands apart.
pub(crate) struct Emitted<'a> {
    pub(crate) task: Task<'a>,
    pub(crate) compiled: &'a Compiled,
    pub(crate) tables: &'a Tables,
    /// Where terms are that may be named.
    pub(crate) placements: &'a [Placement],
    /// What a file that stands apart is, in place of the measurement that the tables of the kit are from.
    pub(crate) notice: Option<&'static str>,
    /// Whether numbers keep the digits they were read with, also beyond those of the profile.
    pub(crate) as_read: bool,
    /// Machine data that it restores (Siemens).
    pub(crate) switches: Vec<Switch>,
}

impl<'a> Emitted<'a> {
    /// The kit itself.
    pub(crate) fn of_kit(task: Task<'a>, compiled: &'a Compiled) -> Self {
        let Compiled { tables, placements, .. } = compiled;
        let (notice, switches) = (None, Vec::new());
        Emitted { task, compiled, tables, placements, notice, as_read: false, switches }
    }
}

/// The bump of a sign proof, and where it stands.
pub(crate) struct ProofOf<'a> {
    pub(crate) task: Task<'a>,
    pub(crate) plan: &'a Plan,
    /// The tables of the kit.
    pub(crate) kit: &'a Tables,
    pub(crate) mechanism: Mechanism,
    pub(crate) term: ErrorTerm,
    pub(crate) bump: &'a Bump,
}

impl ProofOf<'_> {
    /// What a table with this many points pretends: the bump, or zeros where it is not the one.
    pub(super) fn deviations(&self, has_bump: bool, points: usize) -> Vec<Deviation> {
        match has_bump {
            true => self.bump.deviations(),
            false => vec![Deviation::ZERO; points],
        }
    }
}

/// The family of a profile's control.
pub(crate) fn family(profile: &Profile) -> &dyn Family {
    match &profile.dialect {
        Dialect::Siemens(facts) => facts,
        Dialect::Fanuc(facts) => facts,
        Dialect::Declared(facts) => facts,
        Dialect::Linuxcnc(facts) => facts,
        Dialect::Isg(facts) => facts,
    }
}
