//! Causes that no uncertainty holds because the job does not state them: how large they may be before a
//! verdict changes. To say nothing must not look better than to state a bound.

use super::reasons::{Hold, NotCounted};
use super::{Change, DiagonalForecast, Forecast, Silent, TermForecast, Uncounted};
use crate::inputs::error_table::Remarks;
use crate::inputs::job::Acceptance;
use crate::judge::conformity::{Magnitude, Verdict};
use crate::quantity::axis::ErrorTerm;
use crate::quantity::units::rounded_down;

/// Halvings of the search for a bound.
const ROUNDS: usize = 30;
/// A larger bound is never asked for, µrad or mrad.
const LARGEST: f64 = 1000.0;
/// A smaller one is none.
const SMALLEST: f64 = 0.01;

/// What a table says of itself.
pub(super) fn silent(remarks: &Remarks) -> Vec<Silent> {
    let angles = remarks
        .angles_not_counted
        .clone()
        .map(|by_term| Silent { what: Uncounted::Angles, by_term });
    let beam =
        remarks.beam_not_counted.clone().map(|by_term| Silent { what: Uncounted::Beam, by_term });
    angles.into_iter().chain(beam).collect()
}

impl Forecast {
    /// What is not counted, and below which bound of it a pass holds.
    pub(super) fn not_counted(&self, acceptance: Acceptance) -> Vec<NotCounted> {
        let passes = !acceptance.asks_nothing() && self.verdict(acceptance) == Verdict::Pass;
        let hold = |silent: &Silent| match self.holds_below(silent, acceptance) {
            none if none < SMALLEST => Hold::Without,
            bound => Hold::Below(rounded_down(bound.min(LARGEST))),
        };
        let one =
            |silent: &Silent| NotCounted { what: silent.what, hold: passes.then(|| hold(silent)) };
        self.silent.iter().map(one).collect()
    }

    /// The largest bound with which the acceptance is still kept.
    fn holds_below(&self, silent: &Silent, acceptance: Acceptance) -> f64 {
        let passes = |bound: f64| self.widened(silent, bound).verdict(acceptance) == Verdict::Pass;
        if passes(LARGEST) {
            return LARGEST;
        }
        let (mut low, mut high) = (0.0, LARGEST);
        for _ in 0..ROUNDS {
            let middle = f64::midpoint(low, high);
            if passes(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }

    fn widened(&self, silent: &Silent, bound: f64) -> Forecast {
        let times = match silent.what {
            Uncounted::Angles => bound,
            Uncounted::Beam => bound * bound,
        };
        let of = |term: ErrorTerm| times * silent.by_term[term];
        Forecast {
            terms: self.terms.iter().map(|t| t.widened(of(t.term))).collect(),
            diagonals: self.diagonals.iter().map(|d| d.widened(&of)).collect(),
            ..self.clone()
        }
    }
}

fn wider(figures: &[Magnitude], by_um: f64) -> Vec<Magnitude> {
    let one = |figure: &Magnitude| Magnitude { um: figure.um, u_um: figure.u_um.hypot(by_um) };
    figures.iter().map(one).collect()
}

impl TermForecast {
    fn widened(&self, by_um: f64) -> TermForecast {
        TermForecast { figures: wider(&self.figures, by_um), ..self.clone() }
    }
}

impl DiagonalForecast {
    fn widened(&self, of: &dyn Fn(ErrorTerm) -> f64) -> DiagonalForecast {
        let along = |term: ErrorTerm| self.cosines[term.of] * of(term);
        let by_um = ErrorTerm::ALL.into_iter().map(along);
        let by_um = by_um.fold(0.0, f64::hypot);
        let own_um = self.change.u_um.unwrap_or(0.0);
        let change =
            Change { u_um: Some(own_um.hypot(std::f64::consts::SQRT_2 * by_um)), ..self.change };
        DiagonalForecast { halves: wider(&self.halves, by_um), change, ..self.clone() }
    }
}
