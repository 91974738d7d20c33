//! ISO 230-2: accuracy and repeatability of positioning of a numerically controlled axis.
//!
//! Letters and names are those of the 2014 edition; the formulas are the same from the edition of
//! 1997 to that of 2014. The edition of 1988 used other multiples and is not meant here.

use crate::inputs::target_runs::Runs;
use crate::machine::findings::StandardFinding;
use crate::machine::separation::curves::mean;
use crate::machine::standards::{ByDirection, Condition, Met, in_words, largest, range};
use crate::quantity::{Direction, UM_PER_MM};
use crate::text::{Finding, Problem, counted};
use serde::{Serialize, Serializer};

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

/// In documents each with its unit.
impl Serialize for AxisFigures {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_map(self.named_um().map(|(name, um)| (format!("{name}_um"), um)))
    }
}

/// All figures of the standard.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// Of each target, ascending.
    #[serde(skip)]
    pub targets: Vec<TargetFigures>,
    /// Of the axis.
    #[serde(flatten)]
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
    let r_both_um = each(|of| of.r.both_um);
    AxisFigures {
        a: ranges([bands(up, s_up), bands(down, s_down)]),
        e: ranges(means),
        r: ByDirection::of(r_um.map(|um| um.and_then(largest)), r_both_um.and_then(largest)),
        m_um: each(|of| of.mean.both_um).and_then(range),
        b_um: each(|of| of.b_um.map(f64::abs)).and_then(largest),
        b_mean_um: each(|of| of.b_um).map(|b| mean(b.into_iter())),
    }
}

/// x̄_i − 2 s_i and x̄_i + 2 s_i of every target.
fn bands(means: Option<Vec<f64>>, s: Option<Vec<f64>>) -> Option<Vec<f64>> {
    Some(means?.into_iter().zip(s?).flat_map(|(mean, s)| [mean - K * s, mean + K * s]).collect())
}

fn ranges(um: [Option<Vec<f64>>; 2]) -> ByDirection {
    let both: Option<Vec<Vec<f64>>> = um.iter().cloned().collect();
    ByDirection::of(um.map(|um| um.and_then(range)), both.and_then(|both| range(both.concat())))
}

// The conditions that runs can show, and how the figures are labelled by them.

/// Above this length of travel other conditions hold, mm.
pub const LONG_AXIS_MM: f64 = 2000.0;
/// Runs in each direction that the standard asks for up to 2 m.
const RUNS: usize = 5;
/// Fewest targets up to 2 m.
const FEWEST_TARGETS: f64 = 5.0;
/// Targets per metre up to 2 m.
const TARGETS_PER_METRE: f64 = 5.0;
/// Distance of the targets above 2 m, mm.
const LONG_SPACING_MM: f64 = 250.0;
/// "About" 250 mm: a distance that rounds to it on a scale of 10 mm is near enough.
const ABOUT_MM: f64 = 5.0;
/// Targets are spread if no gap (at the ends: both together) is larger than this many mean distances: P_i = (i − 1)p + r with
/// r up to half a distance to either side makes no larger one.
const LARGEST_GAP: f64 = 2.0;
/// Spacings that differ by less than this part of the mean one are equal: positions are written
/// with a micrometre or so, spacings are tens of millimetres.
const EQUAL_SPACING: f64 = 1e-4;
/// Edition that asks for the uncertainty of measurement.
const WITH_UNCERTAINTY: [u16; 1] = [2014];

/// The length that the conditions are about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travel {
    mm: f64,
    stated: bool,
}

impl Travel {
    /// The travel that was stated, mm, or the length from the first to the last target.
    ///
    /// limits rounded to 1 µm: targets such as 24.4 and 1024.4 mm are 1000 mm apart, whatever
    ///        their binary fractions are
    pub fn of(runs: &Runs, stated_mm: Option<f64>) -> Result<Travel, Problem> {
        let whole = |mm: f64| (mm * UM_PER_MM).round() / UM_PER_MM;
        let span = whole(runs.length_mm());
        match stated_mm.map(whole) {
            None => Ok(Travel { mm: span, stated: false }),
            Some(mm) if mm >= span => Ok(Travel { mm, stated: true }),
            Some(mm) => Err(Problem::new(format!(
                "the travel was stated as {} mm, but the targets are {} mm apart",
                in_words(mm),
                in_words(span)
            ))
            .help("state the whole travel of the axis in mm with `--travel-mm`")),
        }
    }

    /// The travel that was stated, mm.
    pub(crate) fn stated_mm(self) -> Option<f64> {
        self.stated.then_some(self.mm)
    }

    /// Whether the conditions above 2 m hold.
    pub fn is_long(self) -> bool {
        self.mm > LONG_AXIS_MM
    }

    fn words(self) -> String {
        let of = if self.stated { " of travel" } else { "" };
        format!("{} mm{of}", in_words(self.mm))
    }
}

/// Conditions of the standard that runs can show, and those that they cannot.
///
/// Up to 2 m of travel: five targets per metre and at least five, five runs in each direction,
/// targets P_i = (i − 1)p + r with r at random. Above: targets about every 250 mm, one run in each
/// direction, and only E, B and M are reported.
///
/// source ISO 230-2, clause on tests (likely: from secondary sources, which tell the editions of
///        1997, 2006 and 2014 apart in nothing but the uncertainty)
/// limits without a stated travel the length is that from the first to the last target
pub fn conditions(runs: &Runs, travel: Travel) -> Vec<Condition> {
    let mut conditions = if travel.is_long() { long(runs) } else { short(runs, travel) };
    conditions.insert(1, spread(runs, travel));
    conditions.push(directions(runs));
    let untested = [
        (
            "warm-up, temperature of machine and instrument near 20 °C or corrected to it",
            &EDITIONS[..],
        ),
        ("feed, dwell, line of measurement and position of the other axes stated", &EDITIONS[..]),
        ("uncertainty of measurement stated with every figure", &WITH_UNCERTAINTY[..]),
    ];
    let untested = untested.into_iter();
    conditions.extend(untested.map(|(asked, of)| Condition::likely(of, asked, "", Met::NotTested)));
    conditions
}

fn likely(asked: impl Into<String>, found: impl Into<String>, met: Met) -> Condition {
    Condition::likely(&EDITIONS, asked, found, met)
}

/// Up to 2 m.
fn short(runs: &Runs, travel: Travel) -> Vec<Condition> {
    let mean = mean_distance(runs);
    let equal = range(distances(runs)).is_some_and(|range| range <= EQUAL_SPACING * mean);
    let random = "distances differ; whether at random cannot be seen";
    let (found, met) = match equal {
        true => (format!("targets all {} mm apart", in_words(mean)), Met::No),
        false => (random.to_string(), Met::NotTested),
    };
    let counts = Direction::BOTH.map(|direction| runs.count(direction));
    vec![
        number_of_targets(runs, travel),
        likely("up to 2 m: targets at random distances, P_i = (i - 1)p + r", found, met),
        likely(
            "up to 2 m: five runs in each direction that is reported",
            runs_words(runs),
            Met::of(counts.into_iter().all(|count| count == 0 || count == RUNS)),
        ),
    ]
}

/// Above 2 m.
fn long(runs: &Runs) -> Vec<Condition> {
    let (spacing, length) = (mean_distance(runs), in_words(runs.length_mm()));
    let targets = runs.targets_mm().len();
    vec![
        likely(
            "above 2 m: a target about every 250 mm",
            format!("{targets} targets on {length} mm, every {spacing:.1} mm"),
            Met::of(spacing < LONG_SPACING_MM + ABOUT_MM),
        ),
        likely(
            "above 2 m: one run in each direction, and only E, B and M are reported",
            runs_words(runs),
            Met::of(Direction::BOTH.into_iter().all(|direction| runs.count(direction) == 1)),
        ),
    ]
}

/// Five targets per metre and at least five.
pub(super) fn number_of_targets(runs: &Runs, travel: Travel) -> Condition {
    let asked = (TARGETS_PER_METRE * travel.mm / 1000.0).ceil().max(FEWEST_TARGETS);
    let found = runs.targets_mm().len();
    let met = Met::of(found as f64 >= asked);
    let asked = format!("up to 2 m: five targets per metre, at least five; here {asked} or more");
    likely(asked, format!("{found} targets on {}", travel.words()), met)
}

/// Figures of both directions need both.
pub(super) fn directions(runs: &Runs) -> Condition {
    let missing = Direction::BOTH.into_iter().find(|direction| runs.count(*direction) == 0);
    let found = missing.map_or("both were measured".to_string(), |missing| {
        format!("unidirectional figures only: moving {} was not measured", way(missing))
    });
    likely("approach in both directions", found, Met::of(missing.is_none()))
}

fn distances(runs: &Runs) -> Vec<f64> {
    runs.targets_mm().windows(2).map(|pair| pair[1] - pair[0]).collect()
}

fn mean_distance(runs: &Runs) -> f64 {
    runs.length_mm() / (runs.targets_mm().len() - 1) as f64
}

/// Targets in a heap at one end say nothing about the rest of the axis.
fn spread(runs: &Runs, travel: Travel) -> Condition {
    let mean = mean_distance(runs);
    let largest = distances(runs).into_iter().fold(0.0, f64::max);
    let beyond = travel.mm - runs.length_mm();
    let mut found = format!("largest gap {largest:.1} mm, mean distance {mean:.1} mm");
    if travel.stated {
        found += &format!(", {beyond:.1} mm of travel beyond the targets");
    }
    let asked = "targets spread over the travel: nowhere more than two mean distances without one";
    likely(asked, found, Met::of(largest.max(beyond) <= LARGEST_GAP * mean))
}

/// `5 runs up, 5 down`.
pub(super) fn runs_words(runs: &Runs) -> String {
    let [up, down] = Direction::BOTH.map(|way| runs.count(way));
    format!("{} up, {down} down", counted(up, "run"))
}

/// What has to be said beside the figures: why some are absent, and which the standard does not
/// know for such an axis.
pub fn remarks(runs: &Runs, travel: Travel) -> Vec<Finding> {
    let missed = |direction: Direction| match (runs.count(direction), way(direction)) {
        (0, way) => Some(StandardFinding::OneWay { way }),
        (1, way) => Some(StandardFinding::OneRun { way }),
        _ => None,
    };
    let several = Direction::BOTH.into_iter().any(|d| runs.count(d) > 1);
    let long = (travel.is_long() && several).then_some(StandardFinding::LongAxis);
    let open =
        (!travel.stated).then(|| StandardFinding::TravelNotStated { measured: travel.words() });
    let missed = Direction::BOTH.into_iter().filter_map(missed);
    missed.chain(long).chain(open).map(Finding::from).collect()
}

const fn way(direction: Direction) -> &'static str {
    match direction {
        Direction::Plus => "up",
        Direction::Minus => "down",
    }
}

/// How the figures are labelled: not according to the standard where a condition is not met.
pub fn label(conditions: &[Condition]) -> String {
    let missed = Condition::missed(conditions);
    if missed.is_empty() {
        "no tested condition of ISO 230-2 is missed; check the others by hand".to_string()
    } else {
        format!("NOT according to ISO 230-2: {}", missed.join("; "))
    }
}
