//! What a control would add to an axis, computed from the tables that were read back.
//!
//! ```text
//!   Tables of its files ──┐
//!   profile facts ────────┼→ control of the family → Response (base axis, output axis, direction)
//!   state of the control ─┘
//! ```
//! A control of a family turns tables into [`NodeTable`]s: corrections at equally spaced nodes and a rule
//! for what happens between them. Everything after that (evaluation, exact extremes, forecast)
//! is common to all controls. Controls follow the formal semantics of the references
//! (docs/siemens.md §2, docs/fanuc.md §2) and know nothing of how a table was made.

use crate::quantity::{Axis, Correction, Direction, Millimetres, PerAxis, SAME_PLACE_MM};

/// Why an emulator cannot tell what a control would do with these tables, in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CannotEmulate(pub String);

/// What an emulator tells, or why it cannot.
pub type Emulated<T> = Result<T, CannotEmulate>;

/// The same in words.
pub(super) fn cannot<T>(words: impl Into<String>) -> Emulated<T> {
    Err(CannotEmulate(words.into()))
}

/// What a control does between two nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Between {
    /// Straight line from node to node.
    Linear,
    /// The whole change at one place of the section: `fraction` 0 = lower end, 1 = upper end.
    Step {
        /// Place of the step inside the section.
        fraction: f64,
    },
    /// Single pulses of `pulse_um` at equal distances in the section (docs/fanuc.md §2.2).
    Pulses {
        /// Size of one pulse, µm.
        pulse_um: f64,
    },
}

/// Corrections at equally spaced nodes of a base axis. Outside the first and last node the end
/// value is held, unless `modulo`.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeTable {
    start_mm: f64,
    step_mm: f64,
    per_mm: f64,
    values_um: Vec<f64>,
    between: Between,
    pub(crate) modulo: bool,
}

impl NodeTable {
    /// A table with its first node at `start` and the corrections of its nodes.
    ///
    /// `step` must be positive and there must be at least two nodes, else nothing is returned.
    pub fn new(
        start: Millimetres,
        step: Millimetres,
        corrections: &[Correction],
        between: Between,
    ) -> Option<NodeTable> {
        let finite = start.mm().is_finite() && step.mm().is_finite();
        (finite && step.mm() > 0.0 && corrections.len() >= 2).then(|| NodeTable {
            start_mm: start.mm(),
            step_mm: step.mm(),
            per_mm: 1.0 / step.mm(),
            values_um: corrections.iter().map(|c| c.um()).collect(),
            between,
            modulo: false,
        })
    }

    /// Position of the first node.
    pub fn first(&self) -> Millimetres {
        Millimetres::new(self.start_mm)
    }

    /// Position of the last node.
    pub fn last(&self) -> Millimetres {
        Millimetres::new(self.node_mm(self.values_um.len() - 1))
    }

    fn node_mm(&self, index: usize) -> f64 {
        self.start_mm + self.step_mm * index as f64
    }

    /// Nodes as position and correction.
    pub fn nodes(&self) -> impl Iterator<Item = (Millimetres, Correction)> {
        let values = self.values_um.iter().enumerate();
        values.map(|(index, um)| (Millimetres::new(self.node_mm(index)), Correction::from_um(*um)))
    }

    /// The correction at a position.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "the section index is checked to lie inside the table before it is used"
    )]
    pub fn correction(&self, at: Millimetres) -> Correction {
        let last = self.values_um.len() - 1;
        let mut u = (at.mm() - self.start_mm) * self.per_mm;
        if self.modulo {
            u = u.rem_euclid(last as f64);
        }
        if u <= 0.0 {
            return Correction::from_um(self.values_um[0]);
        }
        if u >= last as f64 {
            return Correction::from_um(self.values_um[last]);
        }
        let section = u as usize;
        let (low, high) = (self.values_um[section], self.values_um[section + 1]);
        let inside = u - section as f64;
        Correction::from_um(match self.between {
            Between::Linear => low + inside * (high - low),
            Between::Step { fraction } if inside >= fraction => high,
            Between::Step { .. } => low,
            Between::Pulses { pulse_um } => {
                let pulses = (high - low) / pulse_um;
                low + pulse_um * pulses.signum() * (inside * pulses.abs() + 0.5).floor()
            }
        })
    }

    /// Positions inside `from..to` where the correction bends or jumps.
    fn breaks(&self, from: f64, to: f64, out: &mut Vec<f64>) {
        let last = self.values_um.len() - 1;
        let period = self.node_mm(last) - self.start_mm;
        let (mut shift, end) = if self.modulo {
            (((from - self.start_mm) / period).floor() * period, to - self.start_mm)
        } else {
            (0.0, 0.0)
        };
        loop {
            for section in 0..last {
                self.section_breaks(section, shift, out);
            }
            out.push(self.node_mm(last) + shift);
            shift += period;
            if shift > end || !self.modulo {
                break;
            }
        }
        out.retain(|x| *x > from && *x < to);
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "the number of pulses of one section is small and not negative"
    )]
    fn section_breaks(&self, section: usize, shift: f64, out: &mut Vec<f64>) {
        let low = self.node_mm(section) + shift;
        match self.between {
            Between::Linear => out.push(low),
            Between::Step { fraction } => out.push(low + fraction * self.step_mm),
            Between::Pulses { pulse_um } => {
                let change = self.values_um[section + 1] - self.values_um[section];
                let pulses = (change / pulse_um).abs();
                let count = pulses.round() as usize;
                out.extend((0..count).map(|k| low + self.step_mm * (k as f64 + 0.5) / pulses));
            }
        }
    }
}

/// A stretch of the base axis on which a correction is one straight line: both ends, with the corrections there,
/// coming from inside.
pub(crate) type Stretch = [(Millimetres, Correction); 2];

/// What one output axis gets because one base axis stands at a position, having come there in
/// one direction: the sum of node tables and a constant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Response {
    tables: Vec<NodeTable>,
    constant_um: f64,
}

impl Response {
    /// The sum of these tables and a constant correction (a backlash parameter, for instance).
    pub fn new(tables: Vec<NodeTable>, constant: Correction) -> Response {
        Response { tables, constant_um: constant.um() }
    }

    /// Straight lines between places, the ends held. Places at equal distances are one table of nodes; others
    /// are a sum of ramps, one for each section, each held at both ends. None without a place.
    pub(crate) fn straight(mm: &[f64], values: &[Correction]) -> Option<Response> {
        let (low, first) = (mm.first()?, values.first()?);
        let nodes = |low: f64, step: f64, values: &[Correction]| {
            let [low, step] = [low, step].map(Millimetres::new);
            NodeTable::new(low, step, values, Between::Linear)
        };
        let step = step_of(mm, 0.0);
        if let Some(equal) = step.and_then(|step| nodes(*low, step, values)) {
            return Some(Response::new(vec![equal], Correction::ZERO));
        }
        let ramps = mm.windows(2).zip(values.windows(2)).filter_map(|(mm, um)| {
            let rise = Correction::from_um(um[1].um() - um[0].um());
            nodes(mm[0], mm[1] - mm[0], &[Correction::ZERO, rise])
        });
        Some(Response::new(ramps.collect(), *first))
    }

    /// Adds a table.
    pub(crate) fn push(&mut self, table: NodeTable) {
        self.tables.push(table);
    }

    /// Adds what another response adds.
    pub(crate) fn add(&mut self, other: Response) {
        self.tables.extend(other.tables);
        self.constant_um += other.constant_um;
    }

    /// Adds a constant.
    pub(crate) fn shift(&mut self, by: Correction) {
        self.constant_um += by.um();
    }

    /// The correction at a position.
    pub fn correction(&self, at: Millimetres) -> Correction {
        let corrections = self.tables.iter().map(|table| table.correction(at));
        corrections.fold(Correction::from_um(self.constant_um), |sum, c| sum + c)
    }

    /// The node tables it is made of.
    pub fn tables(&self) -> &[NodeTable] {
        &self.tables
    }

    /// The same nodes with straight lines between them, where a control steps.
    #[must_use]
    pub fn straightened(&self) -> Response {
        let straight = |table: &NodeTable| NodeTable { between: Between::Linear, ..table.clone() };
        Response { tables: self.tables.iter().map(straight).collect(), ..*self }
    }

    /// The correction over `from..to` as straight stretches; jumps lie between two stretches.
    /// Exact: no position is skipped, so extremes found on the stretches are the extremes.
    pub(crate) fn stretches(&self, from: Millimetres, to: Millimetres) -> Vec<Stretch> {
        self.breaks(from, to).windows(2).map(|pair| self.stretch(pair[0], pair[1])).collect()
    }

    /// `from`, `to` and every place between them where the correction bends or jumps, mm,
    /// ascending.
    pub fn breaks(&self, from: Millimetres, to: Millimetres) -> Vec<f64> {
        let nodes: usize = self.tables.iter().map(|table| table.values_um.len()).sum();
        let mut breaks = Vec::with_capacity(nodes + 2);
        for table in &self.tables {
            table.breaks(from.mm(), to.mm(), &mut breaks);
        }
        breaks.push(from.mm());
        breaks.push(to.mm());
        breaks.sort_by(f64::total_cmp);
        breaks.dedup_by(|a, b| (*a - *b).abs() < SAME_PLACE_MM);
        breaks
    }

    fn stretch(&self, from: f64, to: f64) -> Stretch {
        // Two places inside carry the line; its ends follow, so a jump at an end cannot mislead.
        let quarter = (to - from) * 0.25;
        let a = self.correction(Millimetres::new(from + quarter)).um();
        let b = self.correction(Millimetres::new(to - quarter)).um();
        let half = (b - a) * 0.5;
        [(from, a - half), (to, b + half)]
            .map(|(mm, um)| (Millimetres::new(mm), Correction::from_um(um)))
    }
}

/// The distance of places that lie at equal distances, but for the last digit of a file and a part of the position.
pub(super) fn step_of(mm: &[f64], relative: f64) -> Option<f64> {
    const OFF_GRID_MM: f64 = 1e-6;
    let (first, last) = (mm.first()?, mm.last()?);
    let step = (last - first) / (mm.len().checked_sub(1)?) as f64;
    let is_equal = |(index, at): (usize, &f64)| {
        (first + step * index as f64 - at).abs() <= OFF_GRID_MM + relative * at.abs()
    };
    mm.iter().enumerate().all(is_equal).then_some(step)
}

/// An emulated control, loaded with tables.
pub trait Emulator {
    /// Pairs (base axis, output axis) that at least one table connects, in the control's names.
    fn connected_axes(&self) -> Vec<(String, String)>;

    /// What `output` gets while `base` moves in `direction`. Axes that no table connects give a
    /// response of zero. Fails where the semantics do not say what the control would do.
    fn response(&self, base: &str, output: &str, direction: Direction) -> Emulated<Response>;

    /// What the control takes off a rotation about `about` while `base` stands somewhere, µrad in place of µm:
    /// it acts through the positions of the axes that `base` carries, from where they rest while others are
    /// measured, without a tool. None where the control holds no angles.
    fn rotation(&self, _base: &str, _about: Axis) -> Option<Response> {
        None
    }

    /// What angles add to an axis beside its [`Emulator::response`]s: at a place, or the most anywhere in the
    /// travel (a bound, of either sign); µm.
    fn swing(&self, _output: &str, _at: Option<PerAxis<f64>>) -> f64 {
        0.0
    }

    /// The order of the axes, from the workpiece, by which its angles act. None where it holds none.
    fn levers(&self) -> Option<[Axis; 3]> {
        None
    }
}
