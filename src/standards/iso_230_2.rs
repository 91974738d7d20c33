//! ISO 230-2: accuracy and repeatability of positioning of a numerically controlled axis.
//!
//! Letters and names are those of the 2014 edition; the formulas are the same from the edition of
//! 1997 to that of 2014. The edition of 1988 used other multiples and is not meant here.

use crate::axis::Direction;
use crate::standards::{ByDirection, Condition, Met, largest, range};
use crate::target_runs::Runs;

/// Coverage factor: a band is k·s to either side of the mean.
pub const K: f64 = 2.0;
/// Above this length of travel other conditions hold, mm.
pub const LONG_AXIS_MM: f64 = 2000.0;

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
/// use nonius::standards::iso_230_2;
/// use nonius::target_runs::Runs;
/// let up = vec![vec![0.0, 2.0], vec![4.0, 6.0]]; // means 1 and 5
/// let down = vec![vec![3.0, 3.0], vec![9.0, 9.0]]; // means 3 and 9
/// let figures = iso_230_2::figures(&Runs::new(vec![0.0, 100.0], Some(up), Some(down))?).axis;
/// assert_eq!(figures.e.up_um, Some(4.0));
/// assert_eq!(figures.e.both_um, Some(8.0));
/// assert_eq!((figures.b_um, figures.b_mean_um), (Some(4.0), Some(-3.0)));
/// # Ok::<(), nonius::problem::Problem>(())
/// ```
pub fn figures(runs: &Runs) -> Figures {
    let targets: Vec<TargetFigures> = (0..runs.targets_mm().len())
        .map(|index| of_target(runs, index))
        .collect();
    let axis = of_axis(&targets);
    Figures { targets, axis }
}

fn of_target(runs: &Runs, index: usize) -> TargetFigures {
    let at = |direction| {
        let um = runs.deviations_um(direction)?.get(index)?;
        Some((mean(um), standard_deviation(um)))
    };
    let (up, down) = (at(Direction::Plus), at(Direction::Minus));
    let (mean_up, mean_down) = (up.map(|of| of.0), down.map(|of| of.0));
    let (s_up, s_down) = (up.and_then(|of| of.1), down.and_then(|of| of.1));
    let b_um = both(mean_up, mean_down, |up, down| up - down);
    let r_up = s_up.map(|s| 2.0 * K * s);
    let r_down = s_down.map(|s| 2.0 * K * s);
    let bands = both(r_up, r_down, |up, down| (up + down) / 2.0);
    let r_both = both(bands, b_um, |bands, b| bands + b.abs());
    TargetFigures {
        target_mm: runs.targets_mm()[index],
        mean: ByDirection {
            up_um: mean_up,
            down_um: mean_down,
            both_um: both(mean_up, mean_down, |up, down| (up + down) / 2.0),
        },
        s: ByDirection {
            up_um: s_up,
            down_um: s_down,
            both_um: None,
        },
        b_um,
        r: ByDirection {
            up_um: r_up,
            down_um: r_down,
            both_um: r_both.and_then(|r| largest([Some(r), r_up, r_down].into_iter().flatten())),
        },
    }
}

fn both(up: Option<f64>, down: Option<f64>, of: impl Fn(f64, f64) -> f64) -> Option<f64> {
    Some(of(up?, down?))
}

fn mean(um: &[f64]) -> f64 {
    um.iter().sum::<f64>() / um.len() as f64
}

/// s with n − 1; `None` of one value.
fn standard_deviation(um: &[f64]) -> Option<f64> {
    let mean = mean(um);
    let squares: f64 = um.iter().map(|x| (x - mean) * (x - mean)).sum();
    (um.len() > 1).then(|| (squares / (um.len() - 1) as f64).sqrt())
}

fn of_axis(targets: &[TargetFigures]) -> AxisFigures {
    // A figure of the axis is absent where it is absent at one target.
    let each = |figure: &dyn Fn(&TargetFigures) -> Option<f64>| -> Option<Vec<f64>> {
        targets.iter().map(figure).collect()
    };
    let up = each(&|of| of.mean.up_um);
    let down = each(&|of| of.mean.down_um);
    let reversals = each(&|of| of.b_um);
    let largest_of = |values: Option<Vec<f64>>| values.and_then(largest);
    let range_of = |values: Option<Vec<f64>>| values.and_then(range);
    let bands_up = bands(up.as_ref(), each(&|of| of.s.up_um));
    let bands_down = bands(down.as_ref(), each(&|of| of.s.down_um));
    AxisFigures {
        a: ByDirection {
            up_um: range_of(bands_up.clone()),
            down_um: range_of(bands_down.clone()),
            both_um: range_of(joined(bands_up, bands_down)),
        },
        e: ByDirection {
            up_um: range_of(up.clone()),
            down_um: range_of(down.clone()),
            both_um: range_of(joined(up, down)),
        },
        r: ByDirection {
            up_um: largest_of(each(&|of| of.r.up_um)),
            down_um: largest_of(each(&|of| of.r.down_um)),
            both_um: largest_of(each(&|of| of.r.both_um)),
        },
        m_um: range_of(each(&|of| of.mean.both_um)),
        b_um: largest_of(each(&|of| of.b_um.map(f64::abs))),
        b_mean_um: reversals.map(|b| mean(&b)),
    }
}

/// x̄_i − 2 s_i and x̄_i + 2 s_i of every target.
fn bands(means: Option<&Vec<f64>>, s: Option<Vec<f64>>) -> Option<Vec<f64>> {
    let pairs = means?.iter().zip(s?);
    Some(
        pairs
            .flat_map(|(mean, s)| [mean - K * s, mean + K * s])
            .collect(),
    )
}

fn joined(up: Option<Vec<f64>>, down: Option<Vec<f64>>) -> Option<Vec<f64>> {
    Some([up?, down?].concat())
}

// ---------------------------------------------------------------------------------------------
// Conditions

/// Runs in each direction that the standard asks for up to 2 m.
const RUNS: usize = 5;
/// Fewest targets up to 2 m.
const FEWEST_TARGETS: f64 = 5.0;
/// Targets per metre up to 2 m.
const TARGETS_PER_METRE: f64 = 5.0;
/// Distance of the targets above 2 m, mm.
const LONG_SPACING_MM: f64 = 250.0;
/// Spacings that differ by less than this part of the mean one are equal: positions are written
/// with a micrometre or so, spacings are tens of millimetres.
const EQUAL_SPACING: f64 = 1e-4;

/// The conditions of the standard, with what the runs show of them.
///
/// Up to 2 m: five targets per metre and at least five, at random distances (P_i = (i − 1)p + r);
/// five runs in each direction. Above 2 m: targets about every 250 mm, one run in each direction,
/// and only E, B and M are reported.
///
/// source ISO 230-2:2014, clause on tests (likely: from secondary sources)
/// limits the length is that from the first to the last target; the travel of the axis is not in
///        the runs
pub fn conditions(runs: &Runs) -> Vec<Condition> {
    let long = runs.length_mm() > LONG_AXIS_MM;
    let mut conditions = if long {
        vec![long_spacing(runs), one_run(runs)]
    } else {
        vec![
            number_of_targets(runs),
            five_runs(runs),
            random_spacing(runs),
        ]
    };
    for asked in [
        "warm-up, temperature of machine and instrument near 20 °C or corrected to it",
        "feed, dwell, line of measurement and position of the other axes stated",
        "uncertainty of measurement stated with every figure (2014)",
    ] {
        conditions.push(Condition {
            asked: asked.to_string(),
            found: String::new(),
            met: Met::NotTested,
        });
    }
    conditions
}

fn met(yes: bool) -> Met {
    if yes { Met::Yes } else { Met::No }
}

fn number_of_targets(runs: &Runs) -> Condition {
    let asked = (TARGETS_PER_METRE * runs.length_mm() / 1000.0)
        .ceil()
        .max(FEWEST_TARGETS);
    let found = runs.targets_mm().len();
    Condition {
        asked: format!("up to 2 m: five targets per metre, at least five; here {asked} or more"),
        found: format!("{found} targets on {} mm", plain(runs.length_mm())),
        met: met(found as f64 >= asked),
    }
}

fn five_runs(runs: &Runs) -> Condition {
    let measured = Direction::BOTH
        .into_iter()
        .map(|direction| runs.count(direction))
        .filter(|count| *count > 0);
    Condition {
        asked: "up to 2 m: five runs in each direction that is reported".to_string(),
        found: runs_words(runs),
        met: met(measured.into_iter().all(|count| count == RUNS)),
    }
}

fn random_spacing(runs: &Runs) -> Condition {
    let spacings: Vec<f64> = runs
        .targets_mm()
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .collect();
    let equal = range(spacings.iter().copied())
        .is_some_and(|range| range <= EQUAL_SPACING * mean(&spacings));
    Condition {
        asked: "targets at random distances, P_i = (i - 1)p + r".to_string(),
        found: if equal {
            format!("targets all {} mm apart", plain(mean(&spacings)))
        } else {
            "distances differ; whether at random cannot be seen".to_string()
        },
        met: if equal { Met::No } else { Met::NotTested },
    }
}

fn long_spacing(runs: &Runs) -> Condition {
    let spacing = runs.length_mm() / (runs.targets_mm().len() - 1) as f64;
    Condition {
        asked: "above 2 m: a target about every 250 mm".to_string(),
        found: format!(
            "{} targets on {} mm, every {spacing:.1} mm",
            runs.targets_mm().len(),
            plain(runs.length_mm())
        ),
        // "About": a spacing that rounds to 250 mm on a scale of 10 mm is near enough.
        met: met(spacing < LONG_SPACING_MM + 5.0),
    }
}

fn one_run(runs: &Runs) -> Condition {
    Condition {
        asked: "above 2 m: one run in each direction".to_string(),
        found: runs_words(runs),
        met: met(Direction::BOTH
            .into_iter()
            .all(|direction| runs.count(direction) > 0)),
    }
}

fn runs_words(runs: &Runs) -> String {
    format!(
        "{} runs up, {} down",
        runs.count(Direction::Plus),
        runs.count(Direction::Minus)
    )
}

/// A length in mm without zeros at its end.
fn plain(mm: f64) -> String {
    let text = format!("{mm:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

/// What has to be said beside the figures: why some are absent, and which the standard does not
/// know for such an axis.
pub fn remarks(runs: &Runs) -> Vec<String> {
    let count = |direction| runs.count(direction);
    let mut remarks = Vec::new();
    for direction in Direction::BOTH {
        let way = way(direction);
        match count(direction) {
            0 => remarks.push(format!(
                "not measured moving {way}: B, M and every figure of both directions are absent"
            )),
            1 => remarks.push(format!(
                "one run moving {way}: s, R and A are absent, they need two runs or more"
            )),
            _ => {}
        }
    }
    let several = Direction::BOTH.into_iter().any(|d| count(d) > 1);
    if runs.length_mm() > LONG_AXIS_MM && several {
        remarks.push(
            "above 2 m the standard reports E, B and M only; R and A are not according to it"
                .to_string(),
        );
    }
    remarks
}

fn way(direction: Direction) -> &'static str {
    match direction {
        Direction::Plus => "up",
        Direction::Minus => "down",
    }
}

/// How the figures are labelled: not according to the standard where a condition is not met.
pub fn label(conditions: &[Condition]) -> String {
    let failed: Vec<String> = conditions
        .iter()
        .filter(|condition| condition.met == Met::No)
        .map(|condition| condition.found.clone())
        .collect();
    if failed.is_empty() {
        "no tested condition of ISO 230-2 is missed; the others are for a person to see to"
            .to_string()
    } else {
        format!(
            "NOT according to ISO 230-2: {} (see the conditions)",
            failed.join("; ")
        )
    }
}
