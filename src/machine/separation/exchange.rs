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
//! Noise moves a gain as well, by √(4(n − 1)) between names that this machine tells apart by nothing
//! else. The margin is what it makes in one of a hundred sound measurements:
//!
//! ```text
//!   m = z·√(4(n − 1)), at least 9        Φ(z) = 1 − 0.006/k; k: assignments that lie within 3·√(4(n − 1))
//!                                        of the best; 9: odds of e^4.5 to one
//! ```
//! so neither a machine that tells no names apart is accused, nor one that leaves a single pair open
//! (docs/accuracy.md §8, tests/studies/exchanged.rs).

use super::campaign::{Campaign, corrected};
use super::closure::{Closure, Start, closure};
use super::findings::SeparationFinding;
use super::noise::{DIGIT_UM, Noise, Outlier, UNRESOLVED_UM, float};
use super::patterns::{Known, Patterns};
use super::readings::{Means, RunCounts, means, run_counts};
use super::reversal::separable;
use crate::inputs::job::SetUp;
use crate::quantity::axis::Axis;
use crate::quantity::diagonal::{Diagonal, PerDiagonal, Run};
use crate::text::finding::Finding;
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

/// What the closure of the readings says under the names of the file.
pub(super) struct AsRead<'a> {
    pub(super) start: &'a Start,
    pub(super) closure: &'a Closure,
    pub(super) noise: Option<Noise>,
    pub(super) overrun: Option<bool>,
}

/// What the readings say of their names and of the order of their steps.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Names {
    /// Another assignment is clearly likelier.
    pub(super) doubt: Option<Finding>,
    /// Slips that these readings would hardly show.
    pub(super) blind: Option<Finding>,
}

/// Compares the recorded names with every other way to share them out.
pub(super) fn names(campaign: &Campaign<'_>, runs: &[Run], as_read: &AsRead<'_>) -> Names {
    let Some(trial) = Trial::new(campaign, runs, as_read) else {
        return Names::default();
    };
    let doubt = trial.likelier();
    let blind = doubt.is_none().then(|| trial.hardly_shown()).flatten();
    Names { doubt: doubt.map(Finding::from), blind: blind.map(Finding::from) }
}

/// Under which diagonal's name the readings of a file belong: by the name in the file.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Naming(PerDiagonal<Diagonal>);

impl Naming {
    /// All 24, the recorded one first.
    fn all() -> Vec<Naming> {
        let mut found = vec![Vec::new()];
        for _ in Diagonal::ALL {
            let longer = |part: &Vec<Diagonal>| -> Vec<Vec<Diagonal>> {
                let free = Diagonal::ALL.into_iter().filter(|d| !part.contains(d));
                free.map(|d| [part.as_slice(), &[d]].concat()).collect()
            };
            found = found.iter().flat_map(longer).collect();
        }
        let naming = |belong: Vec<Diagonal>| {
            let mut belong = belong.into_iter();
            Naming(PerDiagonal::from_fn(|name| belong.next().unwrap_or(name)))
        };
        found.into_iter().map(naming).collect()
    }

    fn renamed(&self, runs: &[Run]) -> Vec<Run> {
        let mut runs = runs.to_vec();
        for run in &mut runs {
            run.diagonal = self.0[run.diagonal];
        }
        runs
    }

    /// The names that are not their own: name in the file, diagonal that was walked.
    fn moved(&self) -> Vec<(Diagonal, Diagonal)> {
        let all = self.0.iter().map(|(name, walked)| (name, *walked));
        all.filter(|(name, walked)| name != walked).collect()
    }

    /// The order of the steps that looks the same, if there is one: PPP keeps its name, and each
    /// other diagonal stands for the axis that it walks in −.
    fn as_order(&self, recorded: [Axis; 3]) -> Option<[Axis; 3]> {
        let keeps = self.0[Diagonal::Ppp] == Diagonal::Ppp;
        let named = |axis: Axis| {
            let walks_back = |d: Diagonal, axis: Axis| d.sign(axis) < 0.0;
            let mut all = self.0.iter();
            let (name, _) = all.find(|(_, walked)| walks_back(**walked, axis))?;
            Axis::ALL.into_iter().find(|axis| walks_back(name, *axis))
        };
        let [first, second, third] = recorded.map(named);
        keeps.then_some([first?, second?, third?])
    }

    /// What happened, if these names are right; `recorded`: the order of the steps in the job.
    fn words(&self, recorded: [Axis; 3]) -> String {
        let moved = self.moved();
        let list = |all: Vec<Diagonal>| all.iter().map(ToString::to_string).collect::<Vec<_>>();
        let (names, walked): (Vec<_>, Vec<_>) = moved.into_iter().unzip();
        let (names, walked) = (list(names).join(", "), list(walked));
        let exchanged = match walked.as_slice() {
            [other, one] => format!("the readings of {one} and {other} were exchanged"),
            _ => format!("the readings named {names} were those of {}", walked.join(", ")),
        };
        match self.as_order(recorded) {
            Some(order) => format!("{exchanged}, or the steps went {}", in_words(order)),
            None => exchanged,
        }
    }
}

fn in_words(order: [Axis; 3]) -> String {
    order.map(|axis| axis.to_string()).join(", ")
}

/// One way to share out the names and what it leaves over.
#[derive(Clone, Copy)]
struct Tried {
    naming: Naming,
    /// Q for readings of 1 µm, disturbed readings of single runs left out.
    square: f64,
}

/// All ways, and what they are compared by.
struct Trial<'a, 'c> {
    campaign: &'a Campaign<'c>,
    runs: &'a [Run],
    as_read: &'a AsRead<'a>,
    recorded: Tried,
    others: Vec<Tried>,
    /// ν of each.
    freedom: usize,
    /// σ where repeats or the job give it, µm.
    sigma_um: Option<f64>,
}

impl<'a, 'c> Trial<'a, 'c> {
    /// `None` where the closure has no degrees of freedom.
    fn new(
        campaign: &'a Campaign<'c>,
        runs: &'a [Run],
        as_read: &'a AsRead<'a>,
    ) -> Option<Trial<'a, 'c>> {
        let volume = &campaign.measurement.volume;
        // Ways that share counts and disturbed readings share the least-squares problem.
        let mut shared: Option<(RunCounts, Vec<Outlier>, Patterns)> = None;
        let mut tried = Naming::all().into_iter().map_while(|naming| {
            let renamed = Renamed::new(campaign, runs, &naming, as_read);
            let same = |(counts, outliers, _): &(RunCounts, Vec<Outlier>, Patterns)| {
                *counts == renamed.counts && *outliers == renamed.outliers
            };
            if !shared.as_ref().is_some_and(same) {
                let known = renamed.known(as_read.start.noise);
                let mut left = known.patterns(volume, &renamed.means, &renamed.counts)?;
                // What stated angles do belongs to no other name.
                let angles = as_read.start.angles.iter().flatten();
                angles.for_each(|angle| left.leave_out_effect(volume, angle));
                shared = Some((renamed.counts, renamed.outliers, left));
            }
            let (_, _, left) = shared.as_ref()?;
            let square = left.square_of(volume, &renamed.means);
            Some((Tried { naming, square }, left.scatter().1))
        });
        let (recorded, freedom) = tried.next()?;
        let others: Vec<Tried> = tried.map(|(tried, _)| tried).collect();
        // Of 24 ways the best leaves less than noise: a stated σ that these readings do not contradict tells.
        let stated_um = campaign.stated.noise_um;
        let stated_um =
            stated_um.filter(|um| as_read.noise.is_some_and(|found| !found.contradicts(*um)));
        let known_um = as_read.start.noise.map(|noise| noise.sigma_um).or(stated_um);
        (freedom > 0).then_some(Trial {
            campaign,
            runs,
            as_read,
            recorded,
            others,
            freedom,
            sigma_um: known_um.map(|um| um.max(DIGIT_UM)),
        })
    }

    /// 2 ln of the odds of `better` against what leaves `worse` over.
    fn gain(&self, worse: f64, better: f64) -> f64 {
        let freedom = float(self.freedom);
        match self.sigma_um {
            Some(sigma_um) => {
                let spread = ChiSquared::new(freedom).map_or(freedom, |s| s.inverse_cdf(BELIEVED));
                (worse - better) / (sigma_um * sigma_um).max(better / spread)
            }
            None => {
                let digit = freedom * DIGIT_UM * DIGIT_UM;
                freedom * ((worse + digit) / (better + digit)).ln()
            }
        }
    }

    /// m, where `best` leaves this over.
    fn margin(&self, best: f64) -> f64 {
        let deviation = 2.0 * self.intervals().sqrt();
        let near = |one: &&Tried| self.gain(one.square, best) < NEAR * deviation;
        let competing = float(self.others.iter().filter(near).count().max(1));
        let z = Normal::standard().inverse_cdf(1.0 - ACCUSED / competing);
        (z * deviation).max(CLEARLY)
    }

    /// n − 1.
    fn intervals(&self) -> f64 {
        self.campaign.measurement.volume.steps_f64() - 1.0
    }

    /// The names that are clearly likelier than the recorded ones and leave nothing to doubt. What
    /// disturbed readings and roll explain of the recorded names is left out of these before.
    fn likelier(&self) -> Option<SeparationFinding> {
        let by_square = |a: &&Tried, b: &&Tried| a.square.total_cmp(&b.square);
        let best = self.others.iter().min_by(by_square)?;
        let before = self.as_read.closure;
        let seen = before.sigma_um().unwrap_or(0.0) > UNRESOLVED_UM;
        let left = before.weighted_square.min(self.recorded.square);
        let gain = self.gain(left, best.square) + self.accused();
        if !seen || gain <= self.margin(best.square) {
            return None;
        }
        let after = self.judged(&best.naming)?;
        let order = self.campaign.measurement.volume.order;
        Some(SeparationFinding::OtherNames {
            walked: best.naming.words(order),
            after_um: after.sigma_um()?,
            before_um: before.sigma_um()?,
            odds: (gain / 2.0).min(999.0),
            is_order: best.naming.as_order(order).is_some(),
        })
    }

    /// What the readings that the closure of the recorded names calls disturbed count against these:
    /// that just this reading is off has a chance of its own.
    fn accused(&self) -> f64 {
        let singly = |o: &&Outlier| o.readings.iter().all(|place| place.run.is_none());
        let accused = self.as_read.closure.outliers.iter().filter(singly).count();
        DISTURBED * float(accused)
    }

    /// The closure under other names; `None` where it leaves a doubt.
    fn judged(&self, naming: &Naming) -> Option<Closure> {
        let volume = &self.campaign.measurement.volume;
        let renamed = Renamed::new(self.campaign, self.runs, naming, self.as_read);
        let known = renamed.known(self.as_read.start.noise);
        let closure = closure(volume, &renamed.means, &renamed.counts, known);
        let noise = self.as_read.start.noise.or_else(|| closure.noise());
        let doubts = closure.doubts(noise, volume, SetUp::Solve);
        doubts.is_empty().then_some(closure)
    }

    /// Probability that these names, had they been right, would have been found: the gain is
    /// normal about G with variance 4G + 4(n − 1) for each exchange, and so is G itself, which these
    /// readings tell, taken one standard deviation low; two and by ln where σ is that of the
    /// closure.
    fn power(&self, slip: &Tried) -> f64 {
        let (worse, better) = (slip.square, self.recorded.square);
        let gain = self.gain(worse, better);
        let scatter =
            |square: f64, many: f64| (8.0 * (square.max(0.0) + many * self.intervals())).sqrt();
        let (square, share) = match self.sigma_um {
            Some(_) => (gain, 1.0),
            None => {
                let digit = float(self.freedom) * DIGIT_UM * DIGIT_UM;
                let ratio = (worse + digit) / (better + digit);
                (float(self.freedom) * (ratio - 1.0), 1.0 / ratio)
            }
        };
        let moved = float(slip.naming.moved().len().saturating_sub(1));
        let spread = share * scatter(square, moved);
        let low = self.sigma_um.map_or(2.0, |_| 1.0);
        let far = (gain - self.margin(better)) / spread.max(f64::MIN_POSITIVE);
        Normal::standard().cdf(far - low)
    }

    /// The exchanges of two names and the orders that would be found in less than 95 %; no order is
    /// shown surely by a single run, whose closure is its own yardstick.
    fn hardly_shown(&self) -> Option<SeparationFinding> {
        let recorded = self.campaign.measurement.volume.order;
        let is_weak = |slip: &&Tried| self.power(slip) < SURE;
        let exchanges = self.others.iter().filter(|one| one.naming.moved().len() == 2);
        let weak: Vec<&Tried> = exchanges.clone().filter(is_weak).collect();
        if weak.len() == exchanges.count() {
            return Some(SeparationFinding::NothingShown);
        }
        let orders = self.others.iter().filter_map(|one| {
            let order = one.naming.as_order(recorded)?;
            (self.sigma_um.is_none() || is_weak(&one)).then(|| in_words(order))
        });
        let orders = orders.collect::<Vec<_>>().join(" or ");
        let pairs = weak.iter().filter_map(|slip| {
            let (one, other) = *slip.naming.moved().first()?;
            Some(format!("{one} and {other}"))
        });
        let pairs = pairs.collect::<Vec<_>>().join(" or ");
        let said = !pairs.is_empty() || !orders.is_empty();
        said.then_some(SeparationFinding::HardlyShown { pairs, orders })
    }
}

/// The readings under some names.
struct Renamed {
    counts: RunCounts,
    means: Means,
    outliers: Vec<Outlier>,
    skip_ends: bool,
}

impl Renamed {
    fn new(
        campaign: &Campaign<'_>,
        runs: &[Run],
        naming: &Naming,
        as_read: &AsRead<'_>,
    ) -> Renamed {
        let volume = &campaign.measurement.volume;
        let runs = corrected(campaign, &naming.renamed(runs));
        let means = means(&runs);
        let means = separable(&means, volume, as_read.overrun == Some(false)).into_owned();
        let mut outliers = as_read.start.outliers.clone();
        for place in outliers.iter_mut().flat_map(|o| &mut o.readings) {
            place.diagonal = naming.0[place.diagonal];
        }
        Renamed {
            skip_ends: means.reverse.is_some() && as_read.overrun != Some(true),
            counts: run_counts(&runs),
            outliers,
            means,
        }
    }

    fn known(&self, noise: Option<Noise>) -> Known<'_> {
        Known { noise, outliers: &self.outliers, skip_ends: self.skip_ends, angles: &[] }
    }
}
