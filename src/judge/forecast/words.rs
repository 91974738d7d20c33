//! What a forecast, or an as-left measurement, says of the acceptance, in words; and of causes that no
//! uncertainty holds because the job does not state them: how large they may be before a verdict changes. To
//! say nothing must not look better than to state a bound.

use super::{Change, DiagonalForecast, Forecast, Silent, TermForecast, share};
use crate::inputs::error_table::Remarks;
use crate::inputs::job::Acceptance;
use crate::judge::conformity::{Magnitude, Verdict, expanded_um};
use crate::quantity::axis::{Direction, ErrorTerm};
use crate::quantity::units::{larger, rounded_down};

/// So many terms are named one by one.
const FEW: usize = 3;

/// One figure against its limit.
struct Judged {
    name: String,
    um: f64,
    expanded_um: Option<f64>,
    limit_um: f64,
    verdict: Verdict,
}

impl Judged {
    /// `None` where the limit is kept.
    fn miss(&self) -> Option<String> {
        let expanded = match self.expanded_um {
            None => "U not stated".to_string(),
            Some(um) => format!("U = {um:.3} µm"),
        };
        (self.verdict != Verdict::Pass).then(|| {
            format!(
                "{}{:.3} µm ({expanded}), the limit is {} µm: {}",
                self.name,
                self.um,
                self.limit_um,
                self.verdict.word()
            )
        })
    }
}

impl Forecast {
    /// Why the acceptance is not kept for sure, one sentence each.
    pub fn misses(&self, acceptance: Acceptance) -> Vec<String> {
        let terms = acceptance.max_deviation_um.iter();
        let terms = terms.flat_map(|limit| self.terms_missing(*limit));
        let diagonals = acceptance.max_diagonal_um.iter();
        let diagonals = diagonals.flat_map(|limit| self.diagonals_missing(*limit));
        let asked = !acceptance.asks_nothing();
        let ranges = self.ranges.iter().filter(|_| asked);
        let ranges = ranges.filter_map(share::JudgedRange::missing);
        terms.chain(diagonals).chain(ranges).collect()
    }

    fn terms_missing(&self, limit_um: f64) -> Vec<String> {
        let one = |term: &TermForecast| Judged {
            name: format!("{} leaves ", term.term),
            um: term.change.after_um,
            expanded_um: term.change.expanded_um,
            limit_um,
            verdict: self.judge(&term.figures, limit_um),
        };
        let all = Judged {
            name: "all terms together leave ".to_string(),
            um: self.max_residual_um(),
            expanded_um: self.max_expanded_um(),
            limit_um,
            verdict: self.judge(&self.figures(), limit_um),
        };
        singly_or_together(self.terms.iter().map(one), &all)
    }

    fn diagonals_missing(&self, limit_um: f64) -> Vec<String> {
        let one = |diagonal: &DiagonalForecast| Judged {
            name: format!("diagonal {} leaves ", diagonal.name),
            um: diagonal.change.after_um,
            expanded_um: diagonal.change.expanded_um,
            limit_um,
            verdict: self.judge_diagonals(&[diagonal], limit_um),
        };
        let diagonals: Vec<&DiagonalForecast> = self.diagonals.iter().collect();
        if diagonals.is_empty() {
            return Vec::new();
        }
        let halves: Vec<_> = diagonals.iter().flat_map(|d| d.halves.clone()).collect();
        let um = diagonals
            .iter()
            .map(|d| d.change.after_um)
            .fold(0.0, larger);
        let stated = diagonals.iter().any(|d| d.change.u_um.is_some());
        let all = Judged {
            name: "the diagonals together leave ".to_string(),
            um,
            expanded_um: stated.then(|| 2.0 * expanded_um(&halves, self.sigma)),
            limit_um,
            verdict: self.judge_diagonals(&diagonals, limit_um),
        };
        singly_or_together(self.diagonals.iter().map(one), &all)
    }

    /// On which part of the machine the verdict rests, e.g. `over the whole travel`.
    pub(crate) fn range_words(&self) -> String {
        share::words(&self.ranges)
    }

    /// What no figure holds because an axis was not measured both ways; `None` = all were.
    pub(crate) fn directions_words(&self) -> Option<String> {
        let ways: Vec<Option<Direction>> = self.terms.iter().filter_map(|t| t.one_way).collect();
        let only = |way: Direction| !ways.is_empty() && ways.iter().all(|w| *w == Some(way));
        match Direction::BOTH.into_iter().find(|way| only(*way)) {
            Some(way) => Some(format!("moving {way} only")),
            None if ways.is_empty() => None,
            None => Some("reversal not measured".to_string()),
        }
    }

    /// Which terms a verdict speaks of: never more than were measured.
    pub(crate) fn terms_words(&self) -> String {
        let names: Vec<String> = self.terms.iter().map(|t| t.term.to_string()).collect();
        match names.as_slice() {
            [] => "every term".to_string(),
            [one] => one.clone(),
            few if few.len() <= FEW => format!("each of {}", few.join(", ")),
            all if all.len() == ErrorTerm::ALL.len() => "every term".to_string(),
            some => format!("each of the {} measured terms", some.len()),
        }
    }
}

/// The figures that miss a limit by themselves; where none does, whether all together do.
fn singly_or_together(each: impl Iterator<Item = Judged>, all: &Judged) -> Vec<String> {
    let missing: Vec<String> = each.filter_map(|judged| judged.miss()).collect();
    match missing.is_empty() {
        true => all.miss().into_iter().collect(),
        false => missing,
    }
}

/// Halvings of the search for a bound.
const ROUNDS: usize = 30;
/// A larger bound is never asked for, µrad or mrad.
const LARGEST: f64 = 1000.0;
/// A smaller one is none.
const SMALLEST: f64 = 0.01;

/// What a table says of itself.
pub(super) fn silent(remarks: &Remarks) -> Vec<Silent> {
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
        let own_um = self.change.u_um.unwrap_or(0.0);
        let change = Change {
            u_um: Some(own_um.hypot(std::f64::consts::SQRT_2 * by_um)),
            ..self.change
        };
        DiagonalForecast {
            halves: wider(&self.halves, by_um),
            change,
            ..self.clone()
        }
    }
}
