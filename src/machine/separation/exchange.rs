//! Diagonals whose readings stand under each other's name, and steps that went in another order.
//!
//! The four programs are alike, so a file that was saved under another diagonal's name, and a walk
//! whose steps went in another order than recorded, are complete and plausible. Each of the 24 ways
//! to share out the names is a hypothesis of its own with as many unknowns: nine curves, the
//! constants of the closure. So they are compared by what each leaves over,
//!
//! ```text
//!   Q(names) = min over c of (w − Kc)ᵀ C⁻¹ (w − Kc)       w, C as in `closure`, K: constants of the axes
//!   gain     = (Q(recorded) − Q(other))/σ², or ν ln of the ratio where no σ is known     2 ln of the odds
//! ```
//! The closure holds signs only, no edges of the box: renaming the axes changes nothing in it. So
//! every other order of the steps is the same to it as one way to share out NPP, PNP and PPN, and
//! the 24 ways hold the 6 orders. Of a name and an order that are wrong together in the matching way
//! nothing is seen.
//!
//! Noise moves a gain as well, by a standard deviation s between names that this machine tells apart by nothing else.
//! The margin is what it makes in one of a hundred sound measurements:
//!
//! ```text
//!   m = z·s, at least 9        Φ(z) = 1 − 0.006/k; k: assignments that lie within 3 s of the best; 9: odds of e^4.5 to one
//!   s² = 4(ν − tr P P′), P, P′: what is left of readings under these names and the others. Computed for n = 6 … 30:
//!        1.2 ν where two of NPP, PNP, PPN change places, 1.5 ν all three, 2.1 ν two and two, else at most 3.4 ν
//! ```
//! so neither a machine that tells no names apart is accused, nor one that leaves a single pair open
//! (docs/accuracy.md §8, tests/studies/exchanged.rs).

use super::closure::{Closure, Patterns, closure};
use super::readings::{DIGIT_UM, Outlier, UNRESOLVED_UM, float, means, walks};
use super::start::{Start, corrected};
use crate::machine::findings::SeparationFinding;
use crate::quantity::{Axis, Diagonal, PerDiagonal, Run, Squared};
use crate::text::{Finding, joined};
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

/// 2 ln of the odds from which another assignment counts, however few the steps.
const CLEARLY: f64 = 9.0;
/// Share of sound measurements that may be accused; the tails of a gain are wider than normal.
const ACCUSED: f64 = 0.006;
/// Assignments that are nearer to the best than so many standard deviations of noise compete with it.
const NEAR: f64 = 3.0;
/// 2 ln of a thousand to one against any one reading being off.
const DISTURBED: f64 = 14.0;
/// Below this probability of finding it, the page says that a slip would hardly show.
const SURE: f64 = 0.95;
/// A scatter of the best assignment above this quantile belies the noise that is known otherwise.
const BELIEVED: f64 = 0.999;

/// Under which diagonal's name the readings of a file belong: by the name in the file.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Naming(PerDiagonal<Diagonal>);

impl Naming {
    /// All 24, the recorded one first.
    fn all() -> impl Iterator<Item = Naming> {
        let walked = |number: usize| [64, 16, 4, 1].map(|part| Diagonal::ALL[number / part % 4]);
        let is_whole = |walked: &[Diagonal; 4]| Diagonal::ALL.iter().all(|d| walked.contains(d));
        let all = (0..256).map(walked).filter(is_whole);
        all.map(|walked| Naming(PerDiagonal::from_fn(|name| walked[name as usize])))
    }

    /// The names that are not their own: name in the file, diagonal that was walked.
    fn moved(&self) -> Vec<(Diagonal, Diagonal)> {
        let all = self.0.iter().map(|(name, walked)| (name, *walked));
        all.filter(|(name, walked)| name != walked).collect()
    }

    /// The order of the steps that looks the same, if there is one: PPP keeps its name, and each
    /// other diagonal stands for the axis that it walks in −.
    fn as_order(&self, recorded: [Axis; 3]) -> Option<[Axis; 3]> {
        let back = |d: Diagonal| Axis::ALL.into_iter().find(|axis| d.sign(*axis) < 0.0);
        let named = |axis| back(self.0.iter().find(|(_, d)| back(**d) == Some(axis))?.0);
        let [first, second, third] = recorded.map(named);
        let keeps = self.0[Diagonal::Ppp] == Diagonal::Ppp;
        keeps.then_some([first?, second?, third?])
    }

    /// What happened, if these names are right; `recorded`: the order of the steps in the job.
    fn words(&self, recorded: [Axis; 3]) -> String {
        let (names, walked): (Vec<_>, Vec<_>) = self.moved().into_iter().unzip();
        let exchanged = match walked.as_slice() {
            [other, one] => format!("the readings of {one} and {other} were exchanged"),
            _ => {
                let (names, walked) = (joined(names), joined(walked));
                format!("the readings named {names} were those of {walked}")
            }
        };
        match self.as_order(recorded) {
            Some(order) => format!("{exchanged}, or the steps went {}", joined(order)),
            None => exchanged,
        }
    }
}

/// One way to share out the names and Q of what it leaves over, disturbed readings of single runs left out.
type Tried = (Naming, f64);

/// All ways, and what they are compared by.
struct Trial<'a> {
    start: &'a Start<'a>,
    raw_runs: &'a [Run],
    /// Q of the recorded names.
    recorded: f64,
    others: Vec<Tried>,
    /// ν of each.
    freedom: f64,
    /// Q/σ² that is believed at most.
    believed: f64,
    /// σ where repeats or the job give it, µm.
    sigma_um: Option<f64>,
}

/// Gives the readings of a start these names, and the disturbed ones among them.
fn rename(other: &mut Start<'_>, (start, raw_runs): (&Start<'_>, &[Run]), naming: &Naming) {
    let runs = raw_runs.iter().map(|run| Run { diagonal: naming.0[run.diagonal], ..run.clone() });
    let (readings, counts) = means(walks(&corrected(start.campaign, runs.collect())));
    other.z[..readings.len()].copy_from_slice(&readings);
    other.counts = counts;
    other.outliers.clone_from(&start.outliers);
    for place in other.outliers.iter_mut().flat_map(|o| &mut o.readings) {
        place.diagonal = naming.0[place.diagonal];
    }
}

/// Compares the recorded names with every other way to share them out: a doubt where another assignment is clearly
/// likelier, else a note of slips that these readings would hardly show. `None`, too, where the closure has no degrees of
/// freedom. The last is the closure under the recorded names, with its least-squares problem.
pub(super) fn names(
    start: &Start<'_>,
    raw_runs: &[Run],
    (closure, mut patterns): (&Closure, Patterns),
) -> Option<Finding> {
    // Of 24 ways the best leaves less than noise: a stated σ that these readings do not contradict tells.
    let stated_um = start.campaign.stated.noise_um;
    let stated_um = stated_um.filter(|um| start.noise.is_some_and(|found| !found.contradicts(*um)));
    let known_um = start.known.map(|noise| noise.sigma_um).or(stated_um);
    // Ways that share counts and disturbed readings share the least-squares problem. What stated angles do belongs
    // to no other name.
    patterns.restart(&start.outliers, &start.model);
    let (mut others, freedom) = (Vec::new(), float(patterns.scatter().1));
    let mut other = start.clone();
    for naming in Naming::all() {
        let shared = (other.counts.clone(), other.outliers.clone());
        rename(&mut other, (start, raw_runs), &naming);
        if (&other.counts, &other.outliers) != (&shared.0, &shared.1) {
            patterns = Patterns::new(&other)?;
            patterns.restart(&other.outliers, &start.model);
        }
        others.push((naming, patterns.square_of(&other.z)));
    }
    let recorded = others.remove(0).1;
    let sigma_um = known_um.map(|um| um.max(DIGIT_UM));
    let believed = ChiSquared::new(freedom).ok()?.inverse_cdf(BELIEVED);
    let trial = Trial { start, raw_runs, recorded, others, freedom, believed, sigma_um };
    trial.likelier(closure).or_else(|| trial.hardly_shown()).map(Finding::from)
}

impl Trial<'_> {
    /// What scatters less than the last digit of a reading is as good as nothing.
    fn ratio(&self, worse: f64, better: f64) -> f64 {
        let digit = self.freedom * DIGIT_UM.squared();
        (worse + digit) / (better + digit)
    }

    /// 2 ln of the odds of `better` against what leaves `worse` over.
    fn gain(&self, worse: f64, better: f64) -> f64 {
        let Some(sigma_um) = self.sigma_um else {
            return self.freedom * self.ratio(worse, better).ln();
        };
        (worse - better) / sigma_um.squared().max(better / self.believed)
    }

    /// s of these names.
    fn deviation(&self, naming: &Naming) -> f64 {
        let twice = |d: Diagonal| naming.0[naming.0[d]];
        let share = match (naming.0[Diagonal::Ppp], naming.moved().len()) {
            (Diagonal::Ppp, 2) => 1.2,
            (Diagonal::Ppp, _) => 1.5,
            (_, 4) if Diagonal::ALL.iter().all(|d| twice(*d) == *d) => 2.1,
            _ => 3.4,
        };
        (share * self.freedom).sqrt()
    }

    /// m of these names, where the best leave this over.
    fn margin(&self, naming: &Naming, best: f64) -> f64 {
        let near = |one: &&Tried| self.gain(one.1, best) < NEAR * self.deviation(&one.0);
        let competing = float(self.others.iter().filter(near).count().max(1));
        let z = Normal::standard().inverse_cdf(1.0 - ACCUSED / competing);
        (z * self.deviation(naming)).max(CLEARLY)
    }

    /// The names that are clearly likelier than the recorded ones and leave nothing to doubt. What
    /// disturbed readings and roll explain of the recorded names is left out of these before.
    fn likelier(&self, before: &Closure) -> Option<SeparationFinding> {
        let (naming, best) = self.others.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let seen = before.sigma_um().unwrap_or(0.0) > UNRESOLVED_UM;
        // That just the readings are off that the closure of the recorded names calls disturbed has a chance of its own.
        let singly = |o: &&Outlier| o.readings.iter().all(|place| place.run.is_none());
        let accused = DISTURBED * float(before.outliers.iter().filter(singly).count());
        let gain = self.gain(before.weighted_square.min(self.recorded), *best) + accused;
        if !seen || gain <= self.margin(naming, *best) {
            return None;
        }
        let mut other = self.start.clone();
        rename(&mut other, (self.start, self.raw_runs), naming);
        other.model.angles.clear();
        let (after, _) = closure(&other);
        let leaves_doubts = !after.doubts(other.volume(), None).is_empty();
        let order = other.volume().order;
        let found = SeparationFinding::OtherNames {
            walked: naming.words(order),
            after_um: after.sigma_um()?,
            before_um: before.sigma_um()?,
            odds: (gain / 2.0).min(999.0),
            is_order: naming.as_order(order).is_some(),
        };
        (!leaves_doubts).then_some(found)
    }

    /// Probability that these names, had they been right, would have been found: the gain is
    /// normal about G with variance 4G + s², and so is G itself, which these
    /// readings tell, taken one standard deviation low; two and by ln where σ is that of the
    /// closure.
    fn power(&self, (naming, worse): &Tried) -> f64 {
        let gain = self.gain(*worse, self.recorded);
        let ratio = self.ratio(*worse, self.recorded);
        let (square, share, low) = match self.sigma_um {
            Some(_) => (gain, 1.0, 1.0),
            None => (self.freedom * (ratio - 1.0), 1.0 / ratio, 2.0),
        };
        let by_noise = self.deviation(naming).squared();
        let spread = share * (8.0 * square.max(0.0) + 2.0 * by_noise).sqrt();
        let far = (gain - self.margin(naming, self.recorded)) / spread.max(f64::MIN_POSITIVE);
        Normal::standard().cdf(far - low)
    }

    /// The exchanges of two names and the orders that would be found in less than 95 %; no order is
    /// shown surely by a single run, whose closure is its own yardstick.
    fn hardly_shown(&self) -> Option<SeparationFinding> {
        let recorded = self.start.volume().order;
        let is_weak = |slip: &&Tried| self.power(slip) < SURE;
        let exchanges = self.others.iter().filter(|(naming, _)| naming.moved().len() == 2);
        let weak: Vec<&Tried> = exchanges.clone().filter(is_weak).collect();
        if weak.len() == exchanges.count() {
            return Some(SeparationFinding::NothingShown);
        }
        let orders = self.others.iter().filter_map(|one| {
            let order = one.0.as_order(recorded)?;
            (self.sigma_um.is_none() || is_weak(&one)).then(|| joined(order))
        });
        let orders = orders.collect::<Vec<_>>().join(" or ");
        let pairs = weak.iter().filter_map(|(naming, _)| {
            let (one, other) = *naming.moved().first()?;
            Some(format!("{one} and {other}"))
        });
        let pairs = pairs.collect::<Vec<_>>().join(" or ");
        let said = !pairs.is_empty() || !orders.is_empty();
        said.then_some(SeparationFinding::HardlyShown { pairs, orders })
    }
}
