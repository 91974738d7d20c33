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
use std::mem::take;

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

impl Change {
    /// Whether anything is known of what it is at most.
    fn is_bounded(&self, doubtful_um: f64) -> bool {
        self.u_um.is_some() || doubtful_um > 0.0
    }
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
    /// `PPP`, `NPP`, `PNP` or `PPN` (contract §2.2).
    pub name: &'static str,
    /// max − min along it; u is that of a difference of two values on it, `None` if any of the nine is
    /// not stated.
    pub change: Change,
    /// Half of max − min with the uncertainty of a value, at each place of a measured position, one where none is stated:
    /// max − min keeps a limit where every value lies within half of it about the middle.
    pub halves: Vec<Magnitude>,
    /// What may be off beside that, µm.
    pub doubtful_um: f64,
}

impl DiagonalForecast {
    /// A diagonal whose values have these standard uncertainties, µm; empty = not stated. `scale_um` =
    /// that of the laser over its length, which is one error of all values; `largest_um` = how far max − min may be off,
    /// where that is known of all values drawn together; `doubtful_um` = what may be off beside that.
    pub(in crate::judge) fn new(
        name: &'static str,
        [before_um, after_um]: [f64; 2],
        sigma: Sigma,
        u_um: &[f64],
        scale_um: f64,
        largest_um: Option<f64>,
        doubtful_um: f64,
    ) -> Self {
        let half = |u_um: f64| Magnitude { um: after_um / 2.0, u_um: u_um.hypot(scale_um / 2.0) };
        let mut halves: Vec<Magnitude> = u_um.iter().copied().map(half).collect();
        if halves.is_empty() {
            halves.push(half(0.0));
        }
        let largest = u_um.iter().copied().reduce(larger);
        DiagonalForecast {
            name,
            change: Change {
                before_um,
                after_um,
                comparable_um: after_um,
                u_um: largest.map(|u| (std::f64::consts::SQRT_2 * u).hypot(scale_um)),
                expanded_um: largest
                    .map(|_| 2.0 * expanded_um(&halves, sigma, largest_um.map(|um| um / 2.0))),
                at_most_um: None,
            },
            halves,
            doubtful_um,
        }
    }

    /// max − min as one figure, the difference of two values, with what is doubtful.
    fn difference(&self) -> Magnitude {
        let um = self.change.after_um + self.doubtful_um;
        Magnitude { um, u_um: self.change.u_um.unwrap_or(0.0) }
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
    fn new(
        name: String,
        diagonal: Option<Diagonal>,
        change: Change,
        [at_most_um, u_um]: [f64; 2],
        basis: Basis,
    ) -> Missed {
        let parts_um = match (basis, change.at_most_um) {
            (Basis::Measured, Some(own_um)) => own_um - change.after_um,
            _ => u_um,
        };
        let (limit_um, verdict) = (f64::INFINITY, Verdict::Pass);
        Missed { name, diagonal, change, at_most_um, u_um, parts_um, limit_um, verdict }
    }

    /// What the largest of its kind is at most in other figures, µm.
    pub(crate) fn of(&self, figures: &Forecast) -> Option<f64> {
        let worst = self.diagonal.map_or_else(|| figures.worst(), |_| figures.worst_diagonal());
        worst.map(|worst| worst.at_most_um)
    }

    /// What is doubtful of all of its kind in other figures, µm.
    pub(crate) fn doubtful_of(&self, figures: &Forecast) -> f64 {
        let doubtful = &figures.doubtful;
        self.diagonal.map_or_else(|| doubtful.all_um(), |_| doubtful.ranges_um())
    }

    /// What is left of the largest of its kind in other figures, µm.
    pub(crate) fn left_of(&self, figures: &Forecast) -> f64 {
        self.diagonal.map_or_else(|| figures.max_residual_um(), |_| figures.max_range_um())
    }

    /// Parts of a variance as parts of the uncertainty in µm, the largest first; without what no printed digit shows.
    pub(crate) fn shares<T>(&self, mut parts: Vec<(T, f64)>) -> Vec<(T, f64)> {
        let all: f64 = parts.iter().map(|(_, square)| square).sum();
        parts.iter_mut().for_each(|(_, part)| *part = self.parts_um * (*part / all).sqrt());
        parts.retain(|(_, um)| *um >= SHARE_UM);
        parts.sort_by(|a, b| b.1.total_cmp(&a.1));
        parts
    }
}

impl Forecast {
    /// Largest residual of all measured terms, µm.
    pub fn max_residual_um(&self) -> f64 {
        let all = self.terms.iter().map(|term| term.change.after_um);
        all.fold(0.0, larger)
    }

    /// Largest max − min along the diagonals, µm.
    pub(super) fn max_range_um(&self) -> f64 {
        self.diagonals.iter().map(|d| d.change.after_um).fold(0.0, larger)
    }

    /// The figures of a term or a diagonal of this name.
    pub(crate) fn change(&self, name: &str) -> Option<Change> {
        let term = self.terms.iter().find(|t| t.term.to_string() == name);
        let diagonal = self.diagonals.iter().find(|d| d.name == name);
        term.map(|t| t.change).or(diagonal.map(|d| d.change))
    }

    /// Figures that the tables make larger than they were measured.
    ///
    /// limits the steps of old tables between the measured positions are not in the figures as
    ///        measured; where only steps make a figure larger, the finding says so
    pub fn worsened(&self) -> Vec<Finding> {
        let terms = self.terms.iter().map(|t| (t.term.to_string(), t.change));
        let diagonals = self.diagonals.iter().map(|d| (format!("diagonal {}", d.name), d.change));
        let worsened = |(what, change): (String, Change)| {
            let (before_um, after_um) = (change.before_um, change.after_um);
            let larger = |um: f64| um > before_um + SHOWN_UM;
            let found = InForecast::Worsened {
                what,
                before_um,
                after_um,
                by_steps: !larger(change.comparable_um),
            };
            larger(after_um).then(|| found.into())
        };
        terms.chain(diagonals).filter_map(worsened).collect()
    }

    /// What is left of all terms, at every measured position, so many times what is doubtful beside it.
    fn shifted(&self, times: f64) -> Vec<Magnitude> {
        let of =
            |term: &TermForecast| shifted(&term.figures, times * self.doubtful.terms[term.term]);
        self.terms.iter().flat_map(of).collect()
    }

    /// U of [`Forecast::max_residual_um`], the largest of all terms, with 95 %, µm; `None` = no
    /// uncertainty is stated.
    pub(crate) fn max_expanded_um(&self) -> Option<f64> {
        let stated = self.terms.iter().any(|term| term.change.u_um.is_some());
        let all_um = self.largest.as_ref().map(|largest| largest.all_um);
        stated.then(|| expanded_um(&self.shifted(0.0), self.sigma, all_um))
    }

    /// What all terms together are at most, with 95 %, µm; `None` = no uncertainty is stated.
    pub(crate) fn all_at_most_um(&self) -> Option<f64> {
        let doubtful = &self.doubtful.terms;
        let stated = self.terms.iter().any(|term| term.change.is_bounded(doubtful[term.term]));
        let all_um = self.together().map(|largest| largest.all_um);
        stated.then(|| self.at_most_um(&self.shifted(1.0), all_um))
    }

    /// What does not keep its limit, errors first; `None` = all is kept, or no uncertainty is stated.
    pub(crate) fn missed(&self, asked: Acceptance) -> Option<Missed> {
        let of_errors = asked.max_deviation_um.and_then(|limit_um| {
            let verdict = self.judge_all(limit_um);
            Some(Missed { limit_um, verdict, ..self.worst()? })
        });
        let of_diagonals = asked.max_diagonal_um.and_then(|limit_um| {
            let verdict = self.judge_diagonals(&self.diagonals, limit_um);
            Some(Missed { limit_um, verdict, ..self.worst_diagonal()? })
        });
        let mut missed = [of_errors, of_diagonals].into_iter().flatten();
        missed.find(|missed| missed.verdict != Verdict::Pass)
    }

    /// The error that is at most most, whatever the limit is.
    pub(crate) fn worst(&self) -> Option<Missed> {
        let at_most = |term: &&TermForecast| term.change.at_most_um.unwrap_or(0.0);
        let stated = self.terms.iter().filter(|term| term.change.at_most_um.is_some());
        let worst = stated.max_by(|a, b| at_most(a).total_cmp(&at_most(b)))?;
        let (own, at_most_um) = (worst.change, self.all_at_most_um()?);
        let u_um = at_most_um - largest_um(&self.shifted(1.0));
        Some(Missed::new(worst.term.to_string(), None, own, [at_most_um, u_um], self.basis))
    }

    fn worst_diagonal(&self) -> Option<Missed> {
        let (all, at_most_um) = (|| self.diagonals.iter(), self.ranges_at_most_um()?);
        let at_most = |d: &&DiagonalForecast| d.change.at_most_um.unwrap_or(0.0);
        let worst = all().max_by(|a, b| at_most(a).total_cmp(&at_most(b)))?;
        let left = all().map(|d| d.change.after_um + d.doubtful_um).fold(0.0, larger);
        let diagonal = Diagonal::ALL.into_iter().find(|d| d.name() == worst.name);
        let (name, both) = (worst.name.to_string(), [at_most_um, at_most_um - left]);
        Some(Missed::new(name, diagonal, worst.change, both, self.basis))
    }

    /// What is known of all values drawn together: how far what is left may be off, or what was measured.
    fn together(&self) -> Option<&LargestErrors> {
        match self.basis {
            Basis::Forecast => self.largest.as_ref(),
            Basis::Measured => self.measured.as_ref(),
        }
    }

    /// What figures are at most, with 95 %.
    ///
    /// formula  forecast: largest + U; measured: each by itself; what is drawn together instead where it is known
    fn at_most_um(&self, figures: &[Magnitude], together_um: Option<f64>) -> f64 {
        match self.basis {
            Basis::Forecast => largest_um(figures) + expanded_um(figures, self.sigma, together_um),
            Basis::Measured => measured_at_most_um(figures, self.sigma, together_um),
        }
    }

    /// What max − min of every diagonal is at most, with 95 %, µm; `None` = no uncertainty is stated.
    pub(super) fn ranges_at_most_um(&self) -> Option<f64> {
        let stated = self.diagonals.iter().any(|d| d.change.is_bounded(d.doubtful_um));
        let ranges_um = self.together().map(|largest| largest.ranges_um / 2.0);
        stated.then(|| 2.0 * self.at_most_um(&halves(&self.diagonals, 1.0), ranges_um))
    }

    /// With what each figure is at most.
    pub(in crate::judge) fn bounded(mut self, basis: Basis) -> Forecast {
        self.basis = basis;
        let (mut terms, mut diagonals) = (take(&mut self.terms), take(&mut self.diagonals));
        for TermForecast { term, change, figures, .. } in &mut terms {
            let together_um = self.together().map(|of| of.single.terms[*term]);
            let doubtful_um = self.doubtful.terms[*term];
            let at_most_um = || self.at_most_um(&shifted(figures, doubtful_um), together_um);
            change.at_most_um = change.is_bounded(doubtful_um).then(at_most_um);
        }
        for d in &mut diagonals {
            let largest_um = self.range_um(d.name);
            let is_bounded = d.change.is_bounded(d.doubtful_um);
            d.change.at_most_um = is_bounded.then(|| match basis {
                Basis::Forecast => {
                    let halves = halves(std::slice::from_ref(d), 1.0);
                    2.0 * self.at_most_um(&halves, largest_um.map(|um| um / 2.0))
                }
                Basis::Measured => self.at_most_um(&[d.difference()], largest_um),
            });
        }
        Forecast { terms, diagonals, ..self }
    }

    /// How far max − min along a diagonal of this name may be off.
    fn range_um(&self, name: &str) -> Option<f64> {
        let diagonal = Diagonal::ALL.into_iter().find(|d| d.name() == name)?;
        self.together().map(|largest| largest.single.diagonals[diagonal])
    }

    /// `figures`: with so many times what is doubtful; `largest_um`: how far their largest error lies off, where that is
    /// known of all together.
    fn judge(
        &self,
        figures: impl Fn(f64) -> Vec<Magnitude>,
        largest_um: Option<f64>,
        limit_um: f64,
    ) -> Verdict {
        let judged = |times| match self.basis {
            Basis::Forecast => judge_forecast(&figures(times), self.sigma, largest_um, limit_um),
            Basis::Measured => judge_measured(&figures(times), self.sigma, largest_um, limit_um),
        };
        match judged(1.0) {
            Verdict::Pass => Verdict::Pass,
            _ => judged(-1.0).max(Verdict::Undecided),
        }
    }

    /// Every term together.
    pub(super) fn judge_all(&self, limit_um: f64) -> Verdict {
        let largest_um = self.together().map(|largest| largest.all_um);
        self.judge(|times| self.shifted(times), largest_um, limit_um)
    }

    /// One term.
    pub(super) fn judge_term(&self, term: &TermForecast, limit_um: f64) -> Verdict {
        let largest_um = self.together().map(|largest| largest.single.terms[term.term]);
        let doubtful_um = self.doubtful.terms[term.term];
        self.judge(|times| shifted(&term.figures, times * doubtful_um), largest_um, limit_um)
    }

    /// Diagonals of a forecast are judged together; a measured one passes on the difference of its
    /// two extreme values and fails on all its values.
    pub(super) fn judge_diagonals(&self, diagonals: &[DiagonalForecast], limit_um: f64) -> Verdict {
        let largest_um = match diagonals {
            [one] => self.range_um(one.name),
            _ => self.together().map(|largest| largest.ranges_um),
        };
        let half_um = largest_um.map(|um| um / 2.0);
        let together = self.judge(|times| halves(diagonals, times), half_um, limit_um / 2.0);
        if self.basis == Basis::Forecast {
            return together;
        }
        let differences: Vec<Magnitude> = diagonals.iter().map(|d| d.difference()).collect();
        match judge_measured(&differences, self.sigma, largest_um, limit_um) {
            Verdict::Pass => Verdict::Pass,
            _ => together.max(Verdict::Undecided),
        }
    }

    /// Compares with the acceptance of the job.
    pub fn verdict(&self, acceptance: Acceptance) -> Verdict {
        let unsaid = !self.silence.not_stated.is_empty();
        let unsaid = if unsaid { Verdict::Undecided } else { Verdict::Pass };
        let judged = |limit| self.judge_all(limit).max(unsaid);
        let terms = acceptance.max_deviation_um.map(judged);
        let diagonals = acceptance.max_diagonal_um.map(|limit| match self.diagonals.is_empty() {
            true => Verdict::Undecided,
            false => self.judge_diagonals(&self.diagonals, limit),
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

/// Half of max − min at all places of diagonals, with so many times what is doubtful.
fn halves(diagonals: &[DiagonalForecast], times: f64) -> Vec<Magnitude> {
    let of = |d: &DiagonalForecast| shifted(&d.halves, times * d.doubtful_um / 2.0);
    diagonals.iter().flat_map(of).collect()
}

/// Figures with so much more, none below 0.
fn shifted(figures: &[Magnitude], by_um: f64) -> Vec<Magnitude> {
    let of = |figure: &Magnitude| Magnitude { um: (figure.um + by_um).max(0.0), ..*figure };
    figures.iter().map(of).collect()
}
