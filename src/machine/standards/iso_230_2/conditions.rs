//! The conditions of ISO 230-2 that runs can show, and how the figures are labelled by them.

use crate::inputs::target_runs::Runs;
use crate::machine::findings::StandardFinding;
use crate::machine::standards::iso_230_2::EDITIONS;
use crate::machine::standards::{Condition, Met, in_words, range};
use crate::quantity::{Direction, UM_PER_MM};
use crate::text::{Finding, Problem, counted};

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

    /// Its length, mm.
    pub const fn mm(self) -> f64 {
        self.mm
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
pub(in crate::machine::standards) fn number_of_targets(runs: &Runs, travel: Travel) -> Condition {
    let asked = (TARGETS_PER_METRE * travel.mm() / 1000.0).ceil().max(FEWEST_TARGETS);
    let found = runs.targets_mm().len();
    likely(
        format!("up to 2 m: five targets per metre, at least five; here {asked} or more"),
        format!("{found} targets on {}", travel.words()),
        Met::of(found as f64 >= asked),
    )
}

/// Figures of both directions need both.
pub(in crate::machine::standards) fn directions(runs: &Runs) -> Condition {
    let missing = Direction::BOTH.into_iter().find(|direction| runs.count(*direction) == 0);
    let found = missing.map_or("both were measured".to_string(), |missing| {
        format!("unidirectional figures only: moving {} was not measured", way(missing))
    });
    likely("approach in both directions", found, Met::of(missing.is_none()))
}

fn distances(runs: &Runs) -> Vec<f64> {
    let pairs = runs.targets_mm().windows(2);
    pairs.map(|pair| pair[1] - pair[0]).collect()
}

fn mean_distance(runs: &Runs) -> f64 {
    runs.length_mm() / (runs.targets_mm().len() - 1) as f64
}

/// Targets in a heap at one end say nothing about the rest of the axis.
fn spread(runs: &Runs, travel: Travel) -> Condition {
    let mean = mean_distance(runs);
    let largest = distances(runs).into_iter().fold(0.0, f64::max);
    let beyond = travel.mm() - runs.length_mm();
    let mut found = format!("largest gap {largest:.1} mm, mean distance {mean:.1} mm");
    if travel.stated {
        found += &format!(", {beyond:.1} mm of travel beyond the targets");
    }
    likely(
        "targets spread over the travel: nowhere more than two mean distances without one",
        found,
        Met::of(largest.max(beyond) <= LARGEST_GAP * mean),
    )
}

/// `5 runs up, 5 down`.
pub(in crate::machine::standards) fn runs_words(runs: &Runs) -> String {
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
        format!("NOT according to ISO 230-2: {} (see the conditions)", missed.join("; "))
    }
}
