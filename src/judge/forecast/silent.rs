//! Causes that no uncertainty holds because the job does not state them: how large they may be before
//! a verdict changes. To say nothing must not look better than to state a bound.

use crate::judge::forecast::figures::Silent;

use super::{DiagonalForecast, Forecast, TermForecast};
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
pub(super) fn of(remarks: &Remarks) -> Vec<Silent> {
    let angles = remarks.angles_not_counted.clone().map(|by_term| Silent {
        what: "angles",
        unit: "µrad",
        is_square: false,
        by_term,
    });
    let beam = remarks.beam_not_counted.clone().map(|by_term| Silent {
        what: "beam against mirror normal",
        unit: "mrad",
        is_square: true,
        by_term,
    });
    angles.into_iter().chain(beam).collect()
}

impl Forecast {
    /// What is not counted, and below which bound of it a pass holds; one phrase each.
    pub fn not_counted(&self, acceptance: Acceptance) -> Vec<String> {
        let passes = !acceptance.asks_nothing() && self.verdict(acceptance) == Verdict::Pass;
        let phrase = |silent: &Silent| match passes {
            false => format!("{} not counted", silent.what),
            true => match self.holds_below(silent, acceptance) {
                none if none < SMALLEST => {
                    format!("{} not counted, holds without any", silent.what)
                }
                bound => format!(
                    "{} not counted, holds below {} {}",
                    silent.what,
                    rounded_down(bound.min(LARGEST)),
                    silent.unit
                ),
            },
        };
        let mut phrases: Vec<String> = self.silent.iter().map(phrase).collect();
        if let (true, [_, _, ..]) = (passes, phrases.as_slice()) {
            phrases.push("each by itself".to_string());
        }
        phrases
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
        let times = if silent.is_square {
            bound * bound
        } else {
            bound
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
    let one = |figure: &Magnitude| Magnitude {
        um: figure.um,
        u_um: figure.u_um.hypot(by_um),
    };
    figures.iter().map(one).collect()
}

impl TermForecast {
    fn widened(&self, by_um: f64) -> TermForecast {
        TermForecast {
            figures: wider(&self.figures, by_um),
            ..self.clone()
        }
    }
}

impl DiagonalForecast {
    fn widened(&self, of: &dyn Fn(ErrorTerm) -> f64) -> DiagonalForecast {
        let along = |term: ErrorTerm| self.cosines[term.of] * of(term);
        let by_um = ErrorTerm::ALL.into_iter().map(along);
        let by_um = by_um.fold(0.0, f64::hypot);
        DiagonalForecast {
            halves: wider(&self.halves, by_um),
            u_um: Some(
                self.u_um
                    .unwrap_or(0.0)
                    .hypot(std::f64::consts::SQRT_2 * by_um),
            ),
            ..self.clone()
        }
    }
}
