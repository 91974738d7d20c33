//! ISO 230-2: accuracy and repeatability of positioning of a numerically controlled axis.
//!
//! Letters and names are those of the 2014 edition; the formulas are the same from the edition of
//! 1997 to that of 2014. The edition of 1988 used other multiples and is not meant here.

mod conditions;

pub use self::conditions::{LONG_AXIS_MM, Travel, conditions, label, remarks};
pub(super) use self::conditions::{directions, number_of_targets, runs_words};

use crate::inputs::target_runs::Runs;
use crate::machine::separation::curves::mean;
use crate::machine::standards::{ByDirection, largest, range};
use crate::quantity::Direction;

/// Editions whose formulas these are.
pub const EDITIONS: [u16; 3] = [1997, 2006, 2014];
/// Coverage factor: a band is k·s to either side of the mean.
pub const K: f64 = 2.0;

/// Figures of one target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetFigures {
    /// P_i, mm.
    pub target_mm: f64,
    /// x̄_i↑, x̄_i↓ and x̄_i.
    pub mean: ByDirection,
    /// s_i↑ and s_i↓; there is none of both.
    pub s: ByDirection,
    /// B_i with its sign, µm.
    pub b_um: Option<f64>,
    /// R_i↑, R_i↓ and R_i.
    pub r: ByDirection,
}

/// Figures of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisFigures {
    /// A↑, A↓, A: positioning error (1997 to 2006: accuracy).
    pub a: ByDirection,
    /// E↑, E↓, E: systematic positioning error.
    pub e: ByDirection,
    /// R↑, R↓, R: repeatability.
    pub r: ByDirection,
    /// M: range of the mean bidirectional positioning error, µm.
    pub m_um: Option<f64>,
    /// B: reversal error, the largest |B_i|, µm.
    pub b_um: Option<f64>,
    /// B̄: mean reversal error, with its sign, µm.
    pub b_mean_um: Option<f64>,
}

impl AxisFigures {
    /// Every figure under its name in documents, µm.
    pub(crate) fn named_um(&self) -> [(&'static str, Option<f64>); 12] {
        [
            ("A", self.a.both_um),
            ("A_up", self.a.up_um),
            ("A_down", self.a.down_um),
            ("E", self.e.both_um),
            ("E_up", self.e.up_um),
            ("E_down", self.e.down_um),
            ("R", self.r.both_um),
            ("R_up", self.r.up_um),
            ("R_down", self.r.down_um),
            ("M", self.m_um),
            ("B", self.b_um),
            ("B_mean", self.b_mean_um),
        ]
    }
}

/// All figures of the standard.
#[derive(Clone, Debug, PartialEq)]
pub struct Figures {
    /// Of each target, ascending.
    pub targets: Vec<TargetFigures>,
    /// Of the axis.
    pub axis: AxisFigures,
}

/// Figures of ISO 230-2.
///
///   x̄_i↑, x̄_i↓   means over the runs           s_i↑, s_i↓   standard deviations, n − 1
///   x̄_i = (x̄_i↑ + x̄_i↓)/2                      B_i = x̄_i↑ − x̄_i↓
///   R_i↑ = 4 s_i↑     R_i↓ = 4 s_i↓            R_i = max[2 s_i↑ + 2 s_i↓ + |B_i|; R_i↑; R_i↓]
///   R↑, R↓, R = max over i                     B = max |B_i|     B̄ = mean of B_i
///   E↑ = max x̄_i↑ − min x̄_i↑                   E = max[x̄_i↑; x̄_i↓] − min[x̄_i↑; x̄_i↓]
///   M = max x̄_i − min x̄_i                      A↑ = max(x̄_i↑ + 2 s_i↑) − min(x̄_i↑ − 2 s_i↑)
///   A = max[x̄_i↑ + 2 s_i↑; x̄_i↓ + 2 s_i↓] − min[x̄_i↑ − 2 s_i↑; x̄_i↓ − 2 s_i↓]
///
/// unit   µm
/// sign   B_i is negative for ordinary lost motion: moving up the axis stays behind
/// source ISO 230-2:2014, clause on evaluation; the same formulas in 1997 and 2006
/// limits s, R and A need two runs of a direction or more; B, B̄, M, E, R, A of both need both
///        directions. E is of *both* directions, and R holds |B_i|: see docs/standards.md
///
/// ```
/// use nonius::machine::standards::iso_230_2;
/// use nonius::inputs::target_runs::Runs;
/// let up = vec![vec![0.0, 2.0], vec![4.0, 6.0]]; // means 1 and 5
/// let down = vec![vec![3.0, 3.0], vec![9.0, 9.0]]; // means 3 and 9
/// let figures = iso_230_2::figures(&Runs::new(vec![0.0, 100.0], Some(up), Some(down))?).axis;
/// assert_eq!(figures.e.up_um, Some(4.0));
/// assert_eq!(figures.e.both_um, Some(8.0));
/// assert_eq!((figures.b_um, figures.b_mean_um), (Some(4.0), Some(-3.0)));
/// # Ok::<(), nonius::text::Problem>(())
/// ```
pub fn figures(runs: &Runs) -> Figures {
    let targets: Vec<TargetFigures> =
        (0..runs.targets_mm().len()).map(|index| of_target(runs, index)).collect();
    let axis = of_axis(&targets);
    Figures { targets, axis }
}

fn of_target(runs: &Runs, index: usize) -> TargetFigures {
    let um = Direction::BOTH.map(|direction| runs.deviations_um(direction)?.get(index));
    let means = um.map(|um| Some(mean(um?.iter().copied())));
    let s = um.map(|um| standard_deviation(um?));
    let bands = s.map(|s| Some(2.0 * K * s?));
    let b_um = both(means, |up, down| up - down);
    let with_b = both([both(bands, f64::midpoint), b_um], |bands, b| bands + b.abs());
    let [up, down] = bands;
    let r = with_b.and_then(|with_b| largest([Some(with_b), up, down].into_iter().flatten()));
    TargetFigures {
        target_mm: runs.targets_mm()[index],
        mean: ByDirection::of(means, both(means, f64::midpoint)),
        s: ByDirection::of(s, None),
        b_um,
        r: ByDirection::of(bands, r),
    }
}

fn both([up, down]: [Option<f64>; 2], of: fn(f64, f64) -> f64) -> Option<f64> {
    Some(of(up?, down?))
}

/// s with n − 1; `None` of one value.
fn standard_deviation(um: &[f64]) -> Option<f64> {
    let mean = mean(um.iter().copied());
    let squares: f64 = um.iter().map(|x| (x - mean) * (x - mean)).sum();
    (um.len() > 1).then(|| (squares / (um.len() - 1) as f64).sqrt())
}

fn of_axis(targets: &[TargetFigures]) -> AxisFigures {
    // A figure of the axis is absent where it is absent at one target.
    let each = |figure: fn(&TargetFigures) -> Option<f64>| -> Option<Vec<f64>> {
        targets.iter().map(figure).collect()
    };
    let means = [each(|of| of.mean.up_um), each(|of| of.mean.down_um)];
    let [s_up, s_down] = [each(|of| of.s.up_um), each(|of| of.s.down_um)];
    let [up, down] = means.clone();
    let r_um = [each(|of| of.r.up_um), each(|of| of.r.down_um)];
    AxisFigures {
        a: ranges([bands(up, s_up), bands(down, s_down)]),
        e: ranges(means),
        r: ByDirection::of(
            r_um.map(|um| um.and_then(largest)),
            each(|of| of.r.both_um).and_then(largest),
        ),
        m_um: each(|of| of.mean.both_um).and_then(range),
        b_um: each(|of| of.b_um.map(f64::abs)).and_then(largest),
        b_mean_um: each(|of| of.b_um).map(|b| mean(b.into_iter())),
    }
}

/// x̄_i − 2 s_i and x̄_i + 2 s_i of every target.
fn bands(means: Option<Vec<f64>>, s: Option<Vec<f64>>) -> Option<Vec<f64>> {
    let pairs = means?.into_iter().zip(s?);
    Some(pairs.flat_map(|(mean, s)| [mean - K * s, mean + K * s]).collect())
}

fn ranges(um: [Option<Vec<f64>>; 2]) -> ByDirection {
    let both: Option<Vec<Vec<f64>>> = um.iter().cloned().collect();
    ByDirection::of(um.map(|um| um.and_then(range)), both.and_then(|both| range(both.concat())))
}
