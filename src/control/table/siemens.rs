//! Siemens tables: `$AA_ENC_COMP` (one axis corrects itself) and `$AN_CEC` (one axis corrects
//! another, or itself depending on direction). docs/siemens.md §1.1, §2.1.
//!
//! Positions and values are in the control's basic unit (mm or inch), as in the file.

/// The grid of a table: `min`, `min + step`, … `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SiemensGrid {
    /// Position of point 0.
    pub min: f64,
    /// Distance of two points.
    pub step: f64,
    /// Position of the last point.
    pub max: f64,
}

/// (MAX−MIN)/STEP may differ this much from a whole number, in steps. Real files round STEP:
/// 770 / 19.7436 = 38.99998.
const WHOLE: f64 = 1e-3;

impl SiemensGrid {
    /// (MAX−MIN)/STEP.
    pub fn steps(&self) -> f64 {
        (self.max - self.min) / self.step
    }

    /// Whether the last point lies on MAX.
    pub(crate) fn is_whole(&self) -> bool {
        (self.steps() - self.steps().round()).abs() < WHOLE
    }

    /// Index of the last point that does not lie behind MAX; 0 where there is none.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "a cast from a float holds the nearest number that fits"
    )]
    pub(crate) fn last_whole_point(&self) -> u32 {
        (self.steps() + WHOLE).floor() as u32
    }

    /// Position of a point.
    pub fn position(&self, index: usize) -> f64 {
        self.min + index as f64 * self.step
    }

    /// Value of the point nearest to a position; beyond the table that of its end, which is held.
    pub fn nearest(&self, values: &[Option<f64>], position: f64) -> Option<f64> {
        let distance = |index: &usize| (self.position(*index) - position).abs();
        let nearest = (0..values.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        values[nearest]
    }
}

/// One measuring-system error compensation table, `$AA_ENC_COMP[e,N,axis]`.
#[derive(Clone, Debug, PartialEq)]
pub struct LecTable {
    /// Index of the measuring system in the file: 0 = first, 1 = second.
    pub encoder: u32,
    /// Name of the axis, upper case.
    pub axis: String,
    /// The grid.
    pub grid: SiemensGrid,
    /// Value of each point from index 0; `None` where the file does not write it (the control
    /// would keep what it holds).
    pub values: Vec<Option<f64>>,
    /// `$AA_ENC_COMP_IS_MODULO`.
    pub modulo: bool,
}

/// A grid whose MAX lies between two points, as real controls hold it, and what is not known of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenEnd {
    /// The last point that does not lie behind MAX.
    pub point: u32,
    /// Its position.
    pub from: f64,
    /// What the table would differ by at MAX if the control went on towards the next point, in the unit
    /// of the file without sign; `None` where no file holds that point.
    pub differs_by: Option<f64>,
}

/// Grid and values as they are taken to act, and the open end: where MAX lies between two points, the
/// value of the last one before it is held.
///
/// limits no available manual says what a control does there
pub fn closed(
    grid: SiemensGrid,
    values: &[Option<f64>],
) -> Option<(SiemensGrid, Vec<Option<f64>>, OpenEnd)> {
    if grid.is_whole() {
        return None;
    }
    let point = grid.last_whole_point();
    let count = usize::try_from(point).unwrap_or(usize::MAX).saturating_add(1);
    let at = |index: usize| values.get(index).copied().flatten();
    let from = grid.position(count - 1);
    let part = (grid.max - from) / grid.step;
    let last = at(count - 1);
    let differs_by = at(count).and_then(|next| Some((next - last?).abs() * part));
    let end = OpenEnd { point, from, differs_by };
    let closed = SiemensGrid { max: from, ..grid };
    Some((closed, values[..count.min(values.len())].to_vec(), end))
}

impl LecTable {
    /// What people call it: `ENC_COMP[0,AX1]`.
    pub(crate) fn name(&self) -> String {
        format!("ENC_COMP[{},{}]", self.encoder, self.axis)
    }
}

/// When a CEC table acts (`$AN_CEC_DIRECTION`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CecDirection {
    /// 0: whichever way the base axis moves.
    Both,
    /// 1: only while the base axis moves in +.
    Plus,
    /// −1: only while the base axis moves in −.
    Minus,
}

/// One cross-error compensation table, `$AN_CEC[t,N]`.
#[derive(Clone, Debug, PartialEq)]
pub struct CecTable {
    /// Table index t, from 0.
    pub number: u32,
    /// Name of the base axis, upper case.
    pub input_axis: String,
    /// Name of the corrected axis, upper case.
    pub output_axis: String,
    /// The grid on the base axis.
    pub grid: SiemensGrid,
    /// Value of each point from index 0.
    pub values: Vec<Option<f64>>,
    /// When it acts.
    pub direction: CecDirection,
    /// `$AN_CEC_MULT_BY_TABLE`: index + 1 of the factor table; 0 = none.
    pub multiply_by: u32,
    /// `$AN_CEC_IS_MODULO`.
    pub modulo: bool,
}

impl CecTable {
    /// What people call it: `CEC table 3`.
    pub(crate) fn name(&self) -> String {
        format!("CEC table {}", self.number)
    }
}

/// All tables of a kit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SiemensTables {
    /// ENC_COMP tables.
    pub lec: Vec<LecTable>,
    /// CEC tables.
    pub cec: Vec<CecTable>,
}

impl SiemensTables {
    /// The axes that CEC tables correct, each once.
    pub(crate) fn cec_outputs(&self) -> Vec<String> {
        let outputs = self.cec.iter().map(|table| table.output_axis.clone());
        let mut outputs: Vec<String> = outputs.collect();
        outputs.sort_unstable();
        outputs.dedup();
        outputs
    }

    /// Largest sum of CEC corrections of an output axis: the largest value of each table, the
    /// worse direction of each base axis, added up over the base axes. A bound, not a place.
    ///
    /// unit   as in the file
    pub(crate) fn largest_cec_sum(&self, output: &str) -> f64 {
        let mut of_base: std::collections::BTreeMap<&str, f64> = Default::default();
        for table in self.cec.iter().filter(|t| t.output_axis == output) {
            let largest = of_base.entry(&table.input_axis).or_default();
            *largest =
                table.values.iter().flatten().map(|value| value.abs()).fold(*largest, f64::max);
        }
        of_base.values().sum()
    }
}
