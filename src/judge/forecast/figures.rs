//! The figures of a forecast.

use crate::inputs::error_table::{LargestErrors, Silence, Sizes};
use crate::inputs::job::Acceptance;
use crate::judge::conformity::{
    Magnitude, Sigma, Verdict, expanded_um, judge_forecast, judge_measured, largest_um,
    measured_at_most_um,
};
use crate::judge::findings::InForecast;
use crate::judge::forecast::share::JudgedRange;
use crate::quantity::{Diagonal, Direction, ErrorTerm, Millimetres, PerAxis, larger};
use crate::text::Finding;
use serde::Serialize;

/// A figure as measured and as the tables leave it, µm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Change {
    /// As measured.
    pub before_um: f64,
    /// With the tables.
    pub after_um: f64,
    /// `after_um`, but with straight lines between the points of a table where old tables were
    /// active, whose steps are not in `before_um` either.
    #[serde(skip)]
    pub comparable_um: f64,
    /// Largest standard uncertainty (k = 1) of a value; `None` = not stated.
    pub u_um: Option<f64>,
    /// U of `after_um`, the largest of its values, with 95 %; `None` = not stated.
    pub expanded_um: Option<f64>,
    /// What is compared with a limit: `after_um` is at most this, with 95 %, and with what is doubtful beside it;
    /// `None` = no uncertainty is stated, and nothing is doubtful.
    pub at_most_um: Option<f64>,
}

/// Forecast of one term.
#[derive(Clone, Debug, PartialEq)]
pub struct TermForecast {
    /// Which error.
    pub term: ErrorTerm,
    /// Largest |deviation| relative to the reference, |deviation + emulated correction|.
    pub change: Change,
    /// What is left around each measured position; one where no uncertainty is stated.
    pub figures: Vec<Magnitude>,
    /// Whether a table was planned for it.
    pub compensated: bool,
    /// `None` = measured both ways; else in which direction, without regard to it where it is `None`.
    pub one_way: Option<Option<Direction>>,
}

/// Forecast along one body diagonal of the measured box: max − min of the deviation along it.
#[derive(Clone, Debug, PartialEq)]
pub struct DiagonalForecast {
    /// Which.
    pub diagonal: Diagonal,
    /// max − min along it; u is that of a difference of two values on it, `None` if any of the nine is
    /// not stated.
    pub change: Change,
    /// max − min with twice the uncertainty of a value, at each place of a measured position, one where none is stated:
    /// max − min keeps a limit where every value lies within half of it about the middle.
    pub figures: Vec<Magnitude>,
    /// What may be off beside that, µm.
    pub doubtful_um: f64,
}

impl DiagonalForecast {
    /// A diagonal whose values have these standard uncertainties, µm; empty = not stated. `scale_um` =
    /// that of the laser over its length, which is one error of all values; `largest_um` = how far max − min may be off,
    /// where that is known of all values drawn together; `doubtful_um` = what may be off beside that.
    pub(in crate::judge) fn new(
        diagonal: Diagonal,
        [before_um, after_um]: [f64; 2],
        sigma: &Sigma,
        u_um: &[f64],
        scale_um: f64,
        largest_um: Option<f64>,
        doubtful_um: f64,
    ) -> Self {
        let twice = |u_um: f64| Magnitude { um: after_um, u_um: 2.0 * u_um.hypot(scale_um / 2.0) };
        let mut figures: Vec<Magnitude> = u_um.iter().copied().map(twice).collect();
        if figures.is_empty() {
            figures.push(twice(0.0));
        }
        let largest = u_um.iter().copied().reduce(larger);
        DiagonalForecast {
            diagonal,
            change: Change {
                before_um,
                after_um,
                comparable_um: after_um,
                u_um: largest.map(|u| (std::f64::consts::SQRT_2 * u).hypot(scale_um)),
                expanded_um: largest.map(|_| expanded_um(&figures, sigma, largest_um)),
                at_most_um: None,
            },
            figures,
            doubtful_um,
        }
    }
}

/// What a figure is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Of {
    /// One error.
    Term(ErrorTerm),
    /// All errors.
    Terms,
    /// One body diagonal.
    Diagonal(Diagonal),
    /// All of them.
    Diagonals,
}

/// A figure that is judged: of a term, or of a diagonal.
#[derive(Clone, Copy)]
pub(super) struct Own<'a> {
    pub(super) of: Of,
    pub(super) change: Change,
    figures: &'a [Magnitude],
    /// What may be off beside its uncertainty, µm.
    doubtful_um: f64,
    /// How far it may be off, where that is known of all values drawn together, µm.
    largest_um: Option<f64>,
}

impl<'a> Own<'a> {
    /// Judged by itself.
    pub(super) fn alone(self) -> LimitFigures<'a> {
        LimitFigures { of: self.of, each: vec![self], largest_um: self.largest_um }
    }

    /// Whether anything is known of what it is at most.
    fn is_bounded(&self) -> bool {
        self.change.u_um.is_some() || self.doubtful_um > 0.0
    }

    /// max − min of a diagonal as one figure, the difference of two values, with what is doubtful.
    fn difference(&self) -> Magnitude {
        let um = self.change.after_um + self.doubtful_um;
        Magnitude { um, u_um: self.change.u_um.unwrap_or(0.0) }
    }
}

/// Figures that keep a limit together: one, those of all terms, or those of all diagonals.
pub(super) struct LimitFigures<'a> {
    pub(super) of: Of,
    pub(super) each: Vec<Own<'a>>,
    /// How far the largest of them may be off, as of each.
    largest_um: Option<f64>,
}

impl LimitFigures<'_> {
    /// Every value, with so many times what is doubtful beside it, none below 0.
    fn shifted(&self, times: f64) -> Vec<Magnitude> {
        let of = |own: &Own<'_>| {
            let by_um = times * own.doubtful_um;
            let shifted =
                |figure: &Magnitude| Magnitude { um: (figure.um + by_um).max(0.0), ..*figure };
            own.figures.iter().map(shifted).collect::<Vec<_>>()
        };
        self.each.iter().flat_map(of).collect()
    }

    /// The largest figure that is left, µm.
    pub(super) fn left_um(&self) -> f64 {
        self.each.iter().map(|own| own.change.after_um).fold(0.0, larger)
    }
}

/// What the figures come from, which decides how they are judged ([`crate::judge::conformity`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Basis {
    /// The emulated tables.
    #[default]
    Forecast,
    /// A measurement with the tables active.
    Measured,
}

/// What the tables will leave.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forecast {
    /// What the figures come from.
    pub basis: Basis,
    /// How the σ behind the uncertainties is known.
    pub sigma: Sigma,
    /// The part of each axis that is judged, and how much of it was measured.
    pub ranges: Vec<JudgedRange>,
    /// What the job of a separation leaves unsaid.
    pub silence: Silence,
    /// The largest errors of a separation, drawn together; `None` = only the u of single values are known.
    pub largest: Option<LargestErrors>,
    /// How far errors as measured may lie beyond the largest of them, likewise.
    pub measured: Option<LargestErrors>,
    /// What may be off beside every uncertainty; 0 where nothing speaks against the errors.
    pub doubtful: Sizes,
    /// Every measured term, in the contract's order.
    pub terms: Vec<TermForecast>,
    /// The four body diagonals; empty unless all nine errors were measured, none in one direction only.
    pub diagonals: Vec<DiagonalForecast>,
    /// Stretches of each axis where the table passes the measured range.
    pub unmeasured: PerAxis<Vec<(Millimetres, Millimetres)>>,
    /// Terms that the measurement was to give and did not.
    pub not_determined: Vec<ErrorTerm>,
    /// Reversal along the diagonals that no curve holds, µm: positioning and diagonals are
    /// forecast without it.
    pub without_reversal_um: Option<f64>,
}

/// A limit that is not kept for sure.
#[derive(Clone, Debug)]
pub(crate) struct Missed {
    /// The error, or the diagonal, that is at most most.
    pub(crate) name: String,
    pub(crate) diagonal: Option<Diagonal>,
    pub(crate) change: Change,
    /// What the largest of all is at most, µm, and the part of it that is uncertain.
    pub(crate) at_most_um: f64,
    pub(crate) u_um: f64,
    /// What the parts of the uncertainty add up to, µm: of the largest of all in a forecast, else its own.
    parts_um: f64,
    pub(crate) limit_um: f64,
    pub(crate) verdict: Verdict,
}

impl Missed {
    /// What is doubtful of all of its kind in other figures, µm.
    pub(crate) fn doubtful_of(&self, figures: &Forecast) -> f64 {
        let doubtful = &figures.doubtful;
        self.diagonal.map_or_else(|| doubtful.all_um(), |_| doubtful.ranges_um())
    }

    /// What is left of the largest of its kind in other figures, µm.
    pub(crate) fn left_of(&self, figures: &Forecast) -> f64 {
        self.kind(figures).left_um()
    }

    /// All figures of its kind.
    fn kind<'a>(&self, figures: &'a Forecast) -> LimitFigures<'a> {
        self.diagonal.map_or_else(|| figures.all_terms(), |_| figures.all_diagonals())
    }

    /// Parts of a variance as parts of the uncertainty ([`shares`]).
    pub(crate) fn shares<T>(&self, parts: Vec<(T, f64)>) -> Vec<(T, f64)> {
        shares(self.parts_um, parts)
    }
}

/// Parts of a variance as parts of an uncertainty in µm, the largest first; without what no printed digit shows.
pub(crate) fn shares<T>(um: f64, mut parts: Vec<(T, f64)>) -> Vec<(T, f64)> {
    let all: f64 = parts.iter().map(|(_, square)| square).sum();
    parts.iter_mut().for_each(|(_, part)| *part = um * (*part / all).sqrt());
    parts.retain(|(_, um)| *um >= SHARE_UM);
    parts.sort_by(|a, b| b.1.total_cmp(&a.1));
    parts
}

impl Forecast {
    /// Every term.
    pub(super) fn all_terms(&self) -> LimitFigures<'_> {
        let each = self.terms.iter().map(|own| Own {
            of: Of::Term(own.term),
            change: own.change,
            figures: &own.figures,
            doubtful_um: self.doubtful.terms[own.term],
            largest_um: self.together().map(|largest| largest.single.terms[own.term]),
        });
        let largest_um = self.together().map(|largest| largest.all_um);
        LimitFigures { of: Of::Terms, each: each.collect(), largest_um }
    }

    /// Every diagonal.
    pub(super) fn all_diagonals(&self) -> LimitFigures<'_> {
        let each = self.diagonals.iter().map(|own| Own {
            of: Of::Diagonal(own.diagonal),
            change: own.change,
            figures: &own.figures,
            doubtful_um: own.doubtful_um,
            largest_um: self.together().map(|largest| largest.single.diagonals[own.diagonal]),
        });
        let largest_um = self.together().map(|largest| largest.ranges_um);
        LimitFigures { of: Of::Diagonals, each: each.collect(), largest_um }
    }

    /// Largest residual of all measured terms, µm.
    pub fn max_residual_um(&self) -> f64 {
        self.all_terms().left_um()
    }

    /// The figures of a term or a diagonal of this name.
    pub(crate) fn change(&self, name: &str) -> Option<Change> {
        let term = self.terms.iter().find(|t| t.term.to_string() == name);
        let diagonal = self.diagonals.iter().find(|d| d.diagonal.name() == name);
        term.map(|t| t.change).or(diagonal.map(|d| d.change))
    }

    /// Figures that the tables make larger than they were measured.
    ///
    /// limits the steps of old tables between the measured positions are not in the figures as
    ///        measured; where only steps make a figure larger, the finding says so
    pub fn worsened(&self) -> Vec<Finding> {
        let terms = self.terms.iter().map(|t| (t.term.to_string(), t.change));
        let diagonals =
            self.diagonals.iter().map(|d| (format!("diagonal {}", d.diagonal), d.change));
        let worsened = |(what, change): (String, Change)| {
            let (before_um, after_um) = (change.before_um, change.after_um);
            let larger = |um: f64| um > before_um + SHOWN_UM;
            let by_steps = !larger(change.comparable_um);
            let found = InForecast::Worsened { what, before_um, after_um, by_steps };
            larger(after_um).then(|| found.into())
        };
        terms.chain(diagonals).filter_map(worsened).collect()
    }

    /// U of [`Forecast::max_residual_um`], the largest of all terms, with 95 %, µm; `None` = no
    /// uncertainty is stated.
    pub(crate) fn max_expanded_um(&self) -> Option<f64> {
        let stated = self.terms.iter().any(|term| term.change.u_um.is_some());
        let all_um = self.largest.as_ref().map(|largest| largest.all_um);
        stated.then(|| expanded_um(&self.all_terms().shifted(0.0), &self.sigma, all_um))
    }

    /// What all terms together are at most, with 95 %, µm; `None` = no uncertainty is stated.
    pub(crate) fn all_at_most_um(&self) -> Option<f64> {
        self.at_most_um(&self.all_terms())
    }

    /// What does not keep its limit, errors first; `None` = all is kept, or no uncertainty is stated.
    pub(crate) fn missed(&self, asked: Acceptance) -> Option<Missed> {
        let all = [
            (asked.max_deviation_um, self.all_terms()),
            (asked.max_diagonal_um, self.all_diagonals()),
        ];
        let mut missed = all.into_iter().filter_map(|(limit, all)| self.worst_of(&all, limit?));
        missed.find(|missed| missed.verdict != Verdict::Pass)
    }

    /// The figure that is at most most, beside their limit.
    fn worst_of(&self, all: &LimitFigures<'_>, limit_um: f64) -> Option<Missed> {
        let at_most_um = self.at_most_um(all)?;
        let stated = all.each.iter().filter(|own| own.change.at_most_um.is_some());
        let at_most = |own: &&Own<'_>| own.change.at_most_um.unwrap_or(0.0);
        let Own { of, change, .. } = stated.max_by(|a, b| at_most(a).total_cmp(&at_most(b)))?;
        let u_um = at_most_um - largest_um(&all.shifted(1.0));
        let parts_um = match (self.basis, change.at_most_um) {
            (Basis::Measured, Some(own_um)) => own_um - change.after_um,
            _ => u_um,
        };
        let (name, diagonal) = match of {
            Of::Term(term) => (term.to_string(), None),
            Of::Diagonal(diagonal) => (diagonal.to_string(), Some(*diagonal)),
            Of::Terms | Of::Diagonals => return None,
        };
        let verdict = self.judge(all, limit_um);
        Some(Missed {
            name,
            diagonal,
            change: *change,
            at_most_um,
            u_um,
            parts_um,
            limit_um,
            verdict,
        })
    }

    /// What is known of all values drawn together: how far what is left may be off, or what was measured.
    fn together(&self) -> Option<&LargestErrors> {
        match self.basis {
            Basis::Forecast => self.largest.as_ref(),
            Basis::Measured => self.measured.as_ref(),
        }
    }

    /// What figures are at most, with 95 %, µm; `None` = no uncertainty is stated.
    ///
    /// formula  forecast: largest + U; measured: each by itself; what is drawn together instead where it is known
    pub(super) fn at_most_um(&self, all: &LimitFigures<'_>) -> Option<f64> {
        let stated = all.each.iter().any(Own::is_bounded);
        stated.then(|| self.bound_um(&all.shifted(1.0), all.largest_um))
    }

    fn bound_um(&self, figures: &[Magnitude], together_um: Option<f64>) -> f64 {
        match self.basis {
            Basis::Forecast => largest_um(figures) + expanded_um(figures, &self.sigma, together_um),
            Basis::Measured => measured_at_most_um(figures, &self.sigma, together_um),
        }
    }

    /// With what each figure is at most.
    pub(in crate::judge) fn bounded(mut self, basis: Basis) -> Forecast {
        self.basis = basis;
        let bound = |own: &Own<'_>| match (own.of, basis) {
            (Of::Diagonal(_), Basis::Measured) => {
                own.is_bounded().then(|| self.bound_um(&[own.difference()], own.largest_um))
            }
            _ => self.at_most_um(&own.alone()),
        };
        let [terms, diagonals] = [self.all_terms(), self.all_diagonals()]
            .map(|all| all.each.iter().map(bound).collect::<Vec<_>>());
        let terms = self.terms.iter_mut().map(|own| &mut own.change).zip(terms);
        let diagonals = self.diagonals.iter_mut().map(|own| &mut own.change).zip(diagonals);
        terms.chain(diagonals).for_each(|(change, um)| change.at_most_um = um);
        self
    }

    /// Figures of a forecast are judged together. Those of a measured diagonal pass on the difference of its two extreme
    /// values and fail on all its values.
    pub(super) fn judge(&self, all: &LimitFigures<'_>, limit_um: f64) -> Verdict {
        let (sigma, largest_um) = (&self.sigma, all.largest_um);
        let judged = |times| match self.basis {
            Basis::Forecast => judge_forecast(&all.shifted(times), sigma, largest_um, limit_um),
            Basis::Measured => judge_measured(&all.shifted(times), sigma, largest_um, limit_um),
        };
        let together = match judged(1.0) {
            Verdict::Pass => Verdict::Pass,
            _ => judged(-1.0).max(Verdict::Undecided),
        };
        if self.basis == Basis::Forecast || matches!(all.of, Of::Term(_) | Of::Terms) {
            return together;
        }
        let differences: Vec<Magnitude> = all.each.iter().map(Own::difference).collect();
        match judge_measured(&differences, sigma, largest_um, limit_um) {
            Verdict::Pass => Verdict::Pass,
            _ => together.max(Verdict::Undecided),
        }
    }

    /// Compares with the acceptance of the job.
    pub fn verdict(&self, acceptance: Acceptance) -> Verdict {
        let unsaid = !self.silence.not_stated.is_empty();
        let unsaid = if unsaid { Verdict::Undecided } else { Verdict::Pass };
        let judged = |limit| self.judge(&self.all_terms(), limit).max(unsaid);
        let terms = acceptance.max_deviation_um.map(judged);
        let diagonals = acceptance.max_diagonal_um.map(|limit| match self.diagonals.is_empty() {
            true => Verdict::Undecided,
            false => self.judge(&self.all_diagonals(), limit),
        });
        let judged = [terms, diagonals].into_iter().flatten().max();
        let short = judged.is_some() && !self.ranges.iter().all(JudgedRange::is_known);
        let short = short.then_some(Verdict::Undecided);
        judged.max(short).unwrap_or(Verdict::Pass)
    }
}

/// Differences below the last digit that is shown are none, µm.
const SHOWN_UM: f64 = 0.001;

/// What the printed digits do not show is no part, µm.
const SHARE_UM: f64 = 0.005;
