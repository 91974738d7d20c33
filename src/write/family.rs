//! What differs from one family of controls to the next, and what each makes of a plan. A family implements the trait
//! for the facts of its profiles; nothing else of the room asks which family it is.

use crate::control::claims::{Assumption, Precondition, SeenTo};
use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::{ControlUnit, Dialect, Mechanism, Profile, Proof};
use crate::control::table::Tables;
use crate::inputs::job::{ActiveTables, AxisSettings, BacklashPolicy, Compensation, Job};
use crate::quantity::{Axis, Deviation, Direction, ErrorTerm, Millimetres, PerAxis, rounded};
use crate::text::{Finding, Problems};
use crate::write::control_text::Seen;
use crate::write::grid::{Grid, LengthDigit, as_number, whole};
use crate::write::selection::TableStock;
use crate::write::task::{Plan, PlannedTable, Target, Task};
use serde::Serialize;

/// A family of controls, on the writing side.
pub(crate) trait Family {
    /// What a name of an axis has to be, where it is not.
    fn expected_name(&self, axis: Axis, name: &str) -> Option<&'static str>;

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
    fn uses(&self, mechanism: Mechanism, plan: &Plan, _tables: &Tables) -> bool {
        plan.tables.iter().any(|own| self.belongs(mechanism, own))
    }

    /// Whether the names of the axes say which axis of the control is meant.
    fn names_reach_axes(&self) -> bool {
        true
    }

    /// What the templates see of tables: names with finished texts.
    fn context(&self, emitted: &FileSource<'_>) -> Seen;

    /// What the control's display shows once these tables act, a sentence each; none where no display is known.
    fn displayed(&self, _tables: &Tables, _state: &ControlState) -> Vec<String> {
        Vec::new()
    }

    /// Whether a table is made by a mechanism; what cannot be judged is.
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
pub(crate) struct FileSource<'a> {
    pub(crate) task: Task<'a>,
    pub(crate) compiled: &'a Compiled,
    pub(crate) tables: &'a Tables,
    /// Where terms are that may be named.
    pub(crate) placements: &'a [Placement],
    /// What a file that stands apart is, in place of the measurement that the tables of the kit are from.
    pub(crate) notice: Option<&'static str>,
    /// Whether numbers keep the digits they were read with, also beyond those of the profile.
    pub(crate) as_read: bool,
}

impl<'a> FileSource<'a> {
    /// The kit itself.
    pub(crate) fn of_kit(task: Task<'a>, compiled: &'a Compiled) -> Self {
        let Compiled { tables, placements, .. } = compiled;
        FileSource { task, compiled, tables, placements, notice: None, as_read: false }
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
        if has_bump { self.bump.deviations() } else { vec![Deviation::ZERO; points] }
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

// The tables as they are written, what the control remembers with them and why it has to, and the bump of a
// sign proof.

/// Where one planned table went and how coarse it is there.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Placement {
    /// Which error.
    pub term: ErrorTerm,
    /// Direction of the moving axis it acts in; `None` = both.
    pub direction: Option<Direction>,
    /// The place in the control's words, e.g. `ENC_COMP[0,AX1]` or `points 0…30`.
    pub place: String,
    /// Number of points.
    pub points: usize,
    /// The smallest step the table can express, µm (contract §1, count).
    pub count_um: f64,
    /// Largest difference of curve and unrounded table over the whole axis, µm.
    pub grid_residual_um: f64,
    /// What the form of the control leaves at its points beyond rounding, µm (four-point
    /// straightness only).
    pub fit_residual_um: Option<f64>,
}

impl Placement {
    /// A planned table at its place, without a residual of the control's form.
    pub(crate) fn of(planned: &PlannedTable, place: String, count_um: f64) -> Placement {
        Placement {
            term: planned.term,
            direction: planned.direction,
            place,
            points: planned.grid.count(),
            count_um,
            grid_residual_um: planned.grid_residual_um,
            fit_residual_um: None,
        }
    }
}

/// A kit before it becomes text.
#[derive(Clone, Debug, PartialEq)]
pub struct Compiled {
    /// What the files will write.
    pub tables: Tables,
    /// Where each planned table went.
    pub placements: Vec<Placement>,
    /// The state of the control that the job states or requires.
    pub state: ControlState,
    /// What is assumed.
    pub assumptions: Vec<Assumption>,
    /// What a person has to see to.
    pub preconditions: Vec<Precondition>,
    /// What switches old tables on that no file overwrites: the disable file, where there is one, sets it to 0.
    pub stale: Vec<String>,
    /// What the user should know.
    pub notes: Vec<Finding>,
}

impl Compiled {
    /// Tables of which nothing else is known.
    pub(super) fn of(tables: Tables, placements: Vec<Placement>, state: ControlState) -> Compiled {
        Compiled {
            tables,
            placements,
            state,
            assumptions: Vec::new(),
            preconditions: Vec::new(),
            stale: Vec::new(),
            notes: Vec::new(),
        }
    }
}

/// The state of the control that the job states: one entry for each physical axis.
/// `backlash_um` is what the backlash parameter will hold, −B rounded as it is named.
pub(crate) fn control_state(
    task: Task<'_>,
    plan: &Plan,
    backlash_um: impl Fn(Axis) -> f64,
) -> ControlState {
    let is_bidirectional = |axis| plan.has_two_tables(axis);
    stated_control(task.job, &plan.names, backlash_um, is_bidirectional)
}

/// The same, of axes with these names.
pub(crate) fn stated_control(
    job: &Job,
    names: &PerAxis<Vec<String>>,
    backlash_um: impl Fn(Axis) -> f64,
    is_bidirectional: impl Fn(Axis) -> bool,
) -> ControlState {
    let mut axes = Vec::new();
    let rest = job.measurement.levers.origin(&job.machine.axes);
    for (axis, names) in names.iter() {
        let Some(machine) = job.machine.axes[axis] else {
            continue;
        };
        let settings = job.compensation.axes[axis].as_ref();
        axes.extend(names.iter().map(|name| AxisState {
            name: name.clone(),
            reference: machine.reference,
            reference_direction: machine.homing(),
            detection_unit_um: settings.and_then(|s| s.detection_unit_um),
            backlash_um: backlash_um(axis),
            bidirectional: is_bidirectional(axis),
            interpolated: settings.is_some_and(AxisSettings::is_interpolated),
            ends: (machine.low, machine.high),
            rest: Millimetres::new(rest[axis]),
        }));
    }
    ControlState { unit: job.compensation.control_unit, axes }
}

/// The deviations that a column for one direction cancels: the table for its direction, and for an axis whose
/// table stands in place of its backlash parameter the reversal that the policy leaves to that.
pub(crate) fn column(
    plan: &Plan,
    term: ErrorTerm,
    replaced: Option<&AxisState>,
    direction: Direction,
) -> Vec<Deviation> {
    let acts = |table: &&PlannedTable| {
        table.term == term && table.direction.is_none_or(|own| own == direction)
    };
    let parameter = replaced.map(|axis| AxisState {
        backlash_um: plan.backlash_um[term.of].unwrap_or(0.0),
        ..axis.clone()
    });
    let by_parameter = parameter.map_or(Deviation::ZERO, |axis| -axis.backlash(direction));
    let values = plan.tables.iter().find(acts).map(|table| table.values.iter());
    let values = values.into_iter().flatten();
    values.map(|value| Deviation::from_um(value.um() + by_parameter.um())).collect()
}

/// What the backlash parameter of an axis has to be: −B as `named`, 0 beside two tables, or as it was.
pub(crate) fn backlash_parameter(
    task: Task<'_>,
    plan: &Plan,
    axis: Axis,
    what: String,
    named: impl Fn(f64) -> String,
    source: &str,
) -> Precondition {
    let equal = task.job.compensation.backlash[axis] == Some(BacklashPolicy::TwoTables);
    let (value, why) = match (plan.backlash_um[axis], counts_as_zero(task.job, axis)) {
        (Some(um), true) if equal => (
            named(um),
            "both directions are equal, so one table holds the error and no reversal is left for the parameter. The measurement counts the parameter as 0 while measuring (else state `active_backlash_um`)",
        ),
        (Some(um), false) if equal => (
            named(um),
            "both directions of the machine without compensation are equal (the parameter that was active while measuring is taken off), so one table holds the error and no reversal is left for the parameter",
        ),
        (Some(um), true) => (
            named(um),
            "−B of the measurement, which counts the backlash parameter as 0 while measuring (else state `active_backlash_um`); the table holds the curve of the reference direction",
        ),
        (Some(um), false) => (
            named(um),
            "−B of the machine without compensation: the parameter that was active while measuring is contained in it; the table holds the curve of the reference direction",
        ),
        (None, true) if plan.has_two_tables(axis) => (
            "0".into(),
            "the reversal is in the two tables; counted twice it would turn round. The measurement counts the parameter as 0 while measuring (else state `active_backlash_um`)",
        ),
        (None, false) if plan.has_two_tables(axis) => (
            "0".into(),
            "the reversal is in the two tables, with the parameter that was active while measuring; counted twice it would turn round",
        ),
        (None, _) => {
            let why = "backlash acts in addition to the table and adds to it";
            return Precondition::new(what, "as during the measurement", why, source);
        }
    };
    Precondition::new(what, value, why, source).seen_to(SeenTo::Entered)
}

/// A backlash parameter in micrometres as it is named: to a tenth of one.
pub(crate) fn backlash_text(um: f64) -> (String, f64) {
    const DECIMALS: u32 = 1;
    let um = rounded(um, DECIMALS);
    (format!("{um:.1} µm"), um)
}

/// Whether the backlash parameter of an axis counts as 0 while measuring because nothing says what
/// it was. Where files are named it has to be known (`active`).
pub(crate) fn counts_as_zero(job: &Job, axis: Axis) -> bool {
    let measurement = &job.measurement;
    let stated = measurement.active_settings.backlash_um[axis];
    !matches!(measurement.active, ActiveTables::Path(_)) && stated.is_none()
}

/// One bump of one mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct SignProof {
    /// What it proves the sign of.
    pub of: &'static Proof,
    /// The term whose table holds the bump.
    pub term: ErrorTerm,
    /// Its place and size.
    pub bump: Bump,
    /// Everything that the file writes.
    pub tables: Tables,
}

/// A bump on the grid of a moving axis: it rises over some sections and falls over as many.
///
/// **unit** whole counts of the table · **limits** at most `limits.max_bump_um`; at least one
/// section away from the reference; inside the travel; at most `limits.max_slope_um_per_mm` and,
/// on Fanuc, the largest increment in each section (four points: where there is room for that)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bump {
    pub(crate) grid: Grid,
    pub(crate) peak: i64,
    pub(crate) rise: i64,
    pub(crate) counts: i64,
    pub(crate) count_um: f64,
    /// A straight line from the reference through its peak.
    pub(crate) is_slope: bool,
}

impl Bump {
    /// Where it begins, is highest, and ends, machine coordinates; a slope has no end, only its beginning.
    pub fn places(&self) -> [Millimetres; 3] {
        let (from, to) = match self.is_slope {
            true => (0, 0),
            false => (self.peak - self.rise, self.peak + self.rise),
        };
        [from, self.peak, to].map(|n| self.grid.position(n))
    }

    /// The deviation that the table pretends at the peak.
    pub(crate) fn height(&self) -> Deviation {
        Deviation::from_um(as_number(self.counts) * self.count_um)
    }

    /// Counts at a node, counted from the reference; a half is rounded up.
    pub(crate) fn counts_at(&self, node: i64) -> i64 {
        let inside = (self.rise - (node - self.peak).abs()).max(0);
        (2 * self.counts * inside + self.rise) / (2 * self.rise)
    }

    /// The deviations that a table of this grid pretends.
    pub(crate) fn deviations(&self) -> Vec<Deviation> {
        (self.grid.first..=self.grid.last)
            .map(|node| Deviation::from_um(as_number(self.counts_at(node)) * self.count_um))
            .collect()
    }
}

/// The largest whole number that is not above a number, but for floating point.
pub(crate) fn whole_below(number: f64) -> i64 {
    const DUST: f64 = 1e-9;
    whole((number + DUST).floor())
}
