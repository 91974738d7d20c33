//! Whether figures keep a limit, with their uncertainty: decision rules.
//!
//! ```text
//!   |figure| + what may be off ≤ limit, for every one of many figures
//!
//!   forecast   pass  all together with 95 %          fail  one of them exceeds it with 95 %
//!   measured   pass  each by itself with 95 %        fail  one exceeds it, with 95 % over all of them
//! ```
//! A forecast is passed before anything was measured, so the risk that *any* figure exceeds the
//! limit has to be small. A measurement of its own passes only if every figure does, so the risk of a
//! wrong pass is that of the worst figure alone (intersection of one-sided tests), while a fail on
//! the worst of many needs joint evidence.
//!
//! Joint probabilities hold whatever the correlation of the figures is: the probability that
//! normal deviates all stay within symmetric bounds is at least the product of the single ones
//! (Šidák, J. Amer. Statist. Assoc. 62 (1967) 626–633). Where σ was estimated, all share its
//! error: the product is averaged over χ² (multivariate Student). Nothing is drawn by chance.

use crate::machine::separation::readings::student;
use crate::quantity::larger;
use crate::text::words;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use statrs::function::erf::erfc;
use std::sync::Arc;

/// Probability behind every U and every verdict.
pub const CONFIDENCE: f64 = 0.95;
/// From here on an estimated σ is as good as a known one: k differs by less than 0.3 %.
const MANY: f64 = 1000.0;
/// Places at which the distribution of an estimated σ is averaged.
const PLACES: u32 = 32;
/// Rounds of the search for U; ten are enough as a rule.
const ROUNDS: usize = 60;
/// Precision of U relative to u.
const PRECISION: f64 = 1e-6;
/// From here on erfc is below 2e-17: thousands of such figures do not change a sum near 1.
const SURE: f64 = 6.0;

words! {
    /// Answer to the question whether a limit is kept; the worse one is the larger.
    #[derive(PartialOrd, Ord)]
    pub enum Verdict {
        /// The limit is kept, or none is stated.
        Pass = "pass",
        /// Neither is shown.
        Undecided = "undecided",
        /// The limit is exceeded.
        Fail = "fail",
    }
}

/// One of the figures that are judged together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Magnitude {
    /// Its magnitude, µm.
    pub um: f64,
    /// Standard uncertainty (k = 1), µm; 0 = none, or none is stated.
    pub u_um: f64,
}

/// How the σ behind the uncertainties is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Sigma {
    /// Degrees of freedom of its estimate; `None` = it is known.
    freedom: Option<f64>,
    /// Estimates of σ in units of the true one, each with its weight.
    estimates: Arc<[(f64, f64)]>,
}

impl Default for Sigma {
    fn default() -> Self {
        Sigma::with_freedom(None)
    }
}

impl Sigma {
    /// σ that was estimated with so many degrees of freedom; `None` = it is known.
    pub(crate) fn with_freedom(freedom: Option<f64>) -> Sigma {
        let freedom = freedom.filter(|freedom| *freedom < MANY);
        Sigma { freedom, estimates: estimates(freedom).into() }
    }

    /// Degrees of freedom; `None` = σ is as good as known.
    pub fn freedom(&self) -> Option<f64> {
        self.freedom
    }

    /// Factor of a one-sided statement on a single figure: 1.645, more where σ is an estimate.
    pub(crate) fn one_sided(&self) -> f64 {
        student(CONFIDENCE, self.freedom)
    }

    /// Factor c with which |deviate| ≤ c·u holds for `count` figures together, with 95 % or more.
    pub(crate) fn joint(&self, count: usize) -> f64 {
        self.joint_at(count, CONFIDENCE)
    }

    /// The same with another probability.
    pub(crate) fn joint_at(&self, count: usize, confidence: f64) -> f64 {
        expanded_at(&vec![Magnitude { um: 0.0, u_um: 1.0 }; count], self, confidence)
    }
}

/// Small estimates decide, so they lie denser: at probabilities p = t², t spread evenly.
fn estimates(freedom: Option<f64>) -> Vec<(f64, f64)> {
    let spread = |freedom| Some((freedom, ChiSquared::new(freedom).ok()?));
    let Some((freedom, spread)) = freedom.and_then(spread) else {
        return vec![(1.0, 1.0)];
    };
    let estimate = |index: u32| {
        let t = (f64::from(index) + 0.5) / f64::from(PLACES);
        let sigma = (spread.inverse_cdf(t * t) / freedom).sqrt();
        (sigma, 2.0 * t / f64::from(PLACES))
    };
    (0..PLACES).map(estimate).collect()
}

/// U of the largest figure, µm: with at least 95 % no true figure exceeds the largest one by more. `largest_um`: by how
/// much the largest error of all may be off, where that is known besides: whatever the figures, |figure + error| is at
/// most the largest of each together.
///
/// formula  smallest U with mean over σ of Π_i P(|e_i| ≤ largest + U − |figure_i|) = 0.95
/// limits   0 without figures and without uncertainty
pub fn expanded_um(figures: &[Magnitude], sigma: &Sigma, largest_um: Option<f64>) -> f64 {
    let is_less =
        |um: &f64| chance_within(figures, sigma, self::largest_um(figures) + um) < CONFIDENCE;
    largest_um.filter(is_less).unwrap_or_else(|| expanded_at(figures, sigma, CONFIDENCE))
}

fn expanded_at(figures: &[Magnitude], sigma: &Sigma, confidence: f64) -> f64 {
    let largest = largest_um(figures);
    let u = figures.iter().map(|f| f.u_um).fold(0.0, larger);
    if u <= 0.0 {
        return 0.0;
    }
    let surplus = |um: f64| chance_within(figures, sigma, largest + um) - confidence;
    let mut high = 2.0 * u;
    while surplus(high) < 0.0 {
        high *= 1.5;
    }
    root(surplus, high, PRECISION * u)
}

/// Where a rising function that is not negative at `high` meets zero between 0 and there: false
/// position (Illinois), from the side on which it is not negative.
fn root(of: impl Fn(f64) -> f64, mut high: f64, precision: f64) -> f64 {
    let (mut low, mut at_low, mut at_high) = (0.0, of(0.0), of(high));
    for _ in 0..ROUNDS {
        if high - low <= precision || at_high <= 0.0 {
            break;
        }
        let middle = low + (high - low) * (-at_low / (at_high - at_low)).clamp(0.05, 0.95);
        let at = of(middle);
        if at < 0.0 {
            (low, at_low, at_high) = (middle, at, at_high / 2.0);
        } else {
            (high, at_high, at_low) = (middle, at, at_low / 2.0);
        }
    }
    high
}

/// A forecast: pass if all figures keep the limit with 95 % together, fail if one exceeds it with 95 %.
/// `together_um`: see [`expanded_um`].
pub(crate) fn judge_forecast(
    figures: &[Magnitude],
    sigma: &Sigma,
    together_um: Option<f64>,
    limit_um: f64,
) -> Verdict {
    let one_sided = sigma.one_sided();
    if figures.iter().any(|f| f.um - one_sided * f.u_um > limit_um) {
        return Verdict::Fail;
    }
    if together_um.is_some_and(|um| largest_um(figures) + um <= limit_um) {
        return Verdict::Pass;
    }
    let all = chance_within(figures, sigma, limit_um);
    if all >= CONFIDENCE { Verdict::Pass } else { Verdict::Undecided }
}

/// A measurement of its own: pass if each figure keeps the limit one-sidedly with 95 %, fail if one
/// exceeds it with 95 % over all of them. `beyond_um`: how far the largest may lie beyond itself, where that is
/// known of all together.
pub(crate) fn judge_measured(
    figures: &[Magnitude],
    sigma: &Sigma,
    beyond_um: Option<f64>,
    limit_um: f64,
) -> Verdict {
    let exceeds = |joint: f64| figures.iter().any(|f| f.um - joint * f.u_um > limit_um);
    if measured_at_most_um(figures, sigma, beyond_um) <= limit_um {
        Verdict::Pass
    } else if exceeds(sigma.joint(figures.len())) {
        Verdict::Fail
    } else {
        Verdict::Undecided
    }
}

/// What measured figures are at most, each by itself with 95 %, µm: the largest of value + 1.645 u, Student's where σ
/// was estimated. `beyond_um`: see [`judge_measured`].
pub(super) fn measured_at_most_um(
    figures: &[Magnitude],
    sigma: &Sigma,
    beyond_um: Option<f64>,
) -> f64 {
    let one_sided = sigma.one_sided();
    let singly = || figures.iter().map(|f| f.um + one_sided * f.u_um).fold(0.0, larger);
    beyond_um.map_or_else(singly, |um| largest_um(figures) + um)
}

/// The largest of them, µm; 0 where there is none.
pub fn largest_um(figures: &[Magnitude]) -> f64 {
    figures.iter().map(|f| f.um).fold(0.0, larger)
}

/// Probability, at least, that no true figure exceeds the limit.
fn chance_within(figures: &[Magnitude], sigma: &Sigma, limit_um: f64) -> f64 {
    if figures.iter().any(|f| f.um > limit_um) {
        return 0.0;
    }
    let uncertain = figures.iter().filter(|f| f.u_um > 0.0);
    let room = |f: &Magnitude| (limit_um - f.um) / f.u_um / std::f64::consts::SQRT_2;
    let rooms: Vec<f64> = uncertain.map(room).collect();
    let all = |(sigma, weight): &(f64, f64)| {
        let outside = rooms.iter().map(|room| room * sigma).filter(|room| *room < SURE).map(erfc);
        weight * outside.map(|p| (-p).ln_1p()).sum::<f64>().exp()
    };
    sigma.estimates.iter().map(all).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known() -> Sigma {
        Sigma::default()
    }

    fn close(got: f64, expected: f64, tolerance: f64) {
        assert!(
            (got - expected).abs() <= tolerance,
            "got {got}, expected {expected} ± {tolerance}"
        );
    }

    #[test]
    fn one_figure_has_the_factors_of_the_normal_distribution() {
        close(known().joint(1), 1.959_964, 1e-4);
        close(known().one_sided(), 1.644_854, 1e-4);
    }

    #[test]
    fn many_figures_need_the_factor_of_sidak() {
        close(known().joint(10), 2.799, 1e-2); // 1 − 0.95^(1/10) two-sided
        close(known().joint(270), 3.730, 1e-2);
    }

    #[test]
    fn an_estimated_sigma_widens_it_as_student_does() {
        let sigma = Sigma::with_freedom(Some(3.0));
        close(sigma.one_sided(), 2.353_363, 1e-4);
        close(sigma.joint(1), 3.182, 0.05);
        assert!(sigma.joint(10) > 4.5);
    }

    #[test]
    fn without_uncertainty_the_figures_decide() {
        let figures = [Magnitude { um: 1.0, u_um: 0.0 }];
        for (limit, verdict) in [(1.0, Verdict::Pass), (0.9, Verdict::Fail)] {
            assert_eq!(judge_forecast(&figures, &known(), None, limit), verdict);
            assert_eq!(judge_measured(&figures, &known(), None, limit), verdict);
        }
        assert_eq!(expanded_um(&figures, &known(), None).to_bits(), 0.0_f64.to_bits());
    }

    #[test]
    fn a_forecast_is_judged_by_the_very_u_that_is_printed() {
        let figures: Vec<Magnitude> =
            (0..30).map(|i| Magnitude { um: f64::from(i) / 30.0, u_um: 0.4 }).collect();
        let bound = largest_um(&figures) + expanded_um(&figures, &known(), None);
        assert_eq!(judge_forecast(&figures, &known(), None, bound * 1.0001), Verdict::Pass);
        assert_eq!(judge_forecast(&figures, &known(), None, bound * 0.9999), Verdict::Undecided);
    }

    #[test]
    fn a_measurement_passes_on_each_figure_and_fails_on_all_together() {
        let figures = |um| vec![Magnitude { um, u_um: 1.0 }; 100];
        assert_eq!(judge_measured(&figures(8.3), &known(), None, 10.0), Verdict::Pass);
        assert_eq!(judge_measured(&figures(12.0), &known(), None, 10.0), Verdict::Undecided);
        assert_eq!(judge_measured(&figures(13.6), &known(), None, 10.0), Verdict::Fail);
    }
}
