//! Slopes of the nine curves, from increments, totals and lines, and the curves with their uncertainties.

use super::agreement::Agreement;
use super::campaign::{Campaign, MeasuredLine};
use super::curves::{
    Curve, ReferenceLine, at, curves, end_slope, mean_curve, plus_line, with_slope,
};
use super::linear_reversal::{LinearReversal, LinearReversals};
use super::metric::{ByTotals, Equations, Metric, PerPlane, Plane, displacement_ratios, stepped};
use super::noise::{Noise, coverage_factor, effective_freedom};
use super::plane::Unknown;
use super::readings::{Increments, Means, mean_increments};
use super::reversal::Turn;
use super::slopes::{Rule, SlopeGains, Totals, totals};
use super::uncertainty::{Budget, Side, Slope, SlopeFrom, SlopeUncertainty};
use crate::inputs::job::{Frame, SetUp};
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis, PerTerm};
use crate::quantity::diagonal::{PerDiagonal, Volume};
use crate::quantity::units::Squared;

/// Seconds of arc in one radian.
const ARCSEC_PER_RADIAN: f64 = 180.0 * 3600.0 / std::f64::consts::PI;

/// Curves of every group of readings, and what their slopes come from.
pub(super) struct Solved<'a> {
    pub(super) budget: &'a Budget<'a>,
    pub(super) setup: SetUp,
    pub(super) frame: Frame,
    /// The curves of each group, with the slopes of the increments.
    raw: Vec<PerTerm<Curve>>,
    pub(super) mean_raw: PerTerm<Curve>,
    /// Slopes of the increments, µm/m.
    pub(super) naive: PerTerm<f64>,
    ratios: PerDiagonal<PerAxis<f64>>,
    equations: Equations,
    pub(super) metric: Metric,
    /// Whether linear axes and beams contradict the diagonals.
    is_refuted: bool,
    pub(super) ends_um: PerDiagonal<f64>,
    pub(super) totals: Totals,
}

impl<'a> Solved<'a> {
    pub(super) fn new(
        campaign: &Campaign<'_>,
        budget: &'a Budget<'a>,
        means: &Means,
    ) -> Solved<'a> {
        let measurement = campaign.measurement;
        let volume = budget.volume;
        let groups = means.groups().iter();
        let increments: Vec<Increments> =
            groups.map(|group| means.increments(volume, *group)).collect();
        let raw: Vec<PerTerm<Curve>> = increments.iter().map(|m| curves(volume, m)).collect();
        let mean_raw = PerTerm::from_fn(|term| mean_curve(&raw, term));
        let means = mean_increments(&increments);
        let ratios = displacement_ratios(volume, &means);
        let lines = campaign.lines.iter();
        let lines: Vec<MeasuredLine> =
            lines.map(|line| without_shapes(budget, &mean_raw, line)).collect();
        let ends_um = PerDiagonal::from_fn(|d| {
            let of_axis = |axis: Axis| volume.steps_f64() * means[d][axis];
            Axis::ALL.into_iter().map(of_axis).sum::<f64>()
        });
        let equations = Equations::new(volume, &stepped(&ratios), &budget.totals(), &lines);
        Solved {
            budget,
            setup: measurement.setup,
            frame: measurement.frame,
            naive: PerTerm::from_fn(|term| end_slope(volume, term.along, &mean_raw[term])),
            raw,
            mean_raw,
            ratios,
            metric: equations.metric(),
            is_refuted: false,
            equations,
            totals: totals(volume, &ends_um),
            ends_um,
        }
    }

    fn rule(&self, term: ErrorTerm) -> Rule {
        Rule::of(self.setup, self.frame, term)
    }

    /// Whether the slope of a term is that of the increments, with the tilt of the mirror.
    pub(super) fn keeps_separated_slope(&self, term: ErrorTerm) -> bool {
        self.rule(term).keeps_separated_slope()
    }

    /// A scale or a squareness, µm/m; `None` = not determined.
    fn figure(&self, unknown: Unknown) -> Option<f64> {
        match (self.setup, unknown) {
            (SetUp::AssumePerfect, Unknown::Squareness(plane)) => {
                Some(self.totals.squareness_um_per_m.of(plane))
            }
            _ => self.metric.value(unknown),
        }
    }

    pub(super) fn squareness(&self) -> PerPlane<Option<f64>> {
        PerPlane::from_fn(|plane| self.figure(Unknown::Squareness(plane)))
    }

    /// Slope of a term, µm/m; `None` = not determined.
    fn slope(&self, term: ErrorTerm) -> Option<f64> {
        let rule = self.rule(term);
        let figure = match rule.figure {
            None => 0.0,
            Some((unknown, share)) => share * self.figure(unknown)?,
        };
        Some(figure + rule.own * self.naive[term] + rule.of_twin * self.naive[term.twin()])
    }

    /// Slopes and squareness as functions of totals and separated slopes.
    pub(super) fn gains(&self) -> SlopeGains {
        let volume = self.budget.volume;
        // Change of φ of formula (4) with each total.
        let of_totals = |unknown: Unknown| {
            PerDiagonal::from_fn(|d| match unknown {
                Unknown::Scale(_) => 0.0,
                Unknown::Squareness(plane) => {
                    let one = PerDiagonal::from_fn(|other| f64::from(other == d));
                    totals(volume, &one).squareness_um_per_m.of(plane)
                }
            })
        };
        SlopeGains {
            rules: PerTerm::from_fn(|term| self.rule(term)),
            by_total: match self.setup {
                SetUp::Solve => self.equations.by_totals(volume),
                SetUp::AssumePerfect => ByTotals::from_fn(of_totals),
            },
            own_slopes: self.frame == Frame::AsMeasured,
        }
    }

    /// A scale or a squareness as a slope; `None` where its uncertainty is not known.
    fn figure_slope(&self, gains: &SlopeGains, unknown: Unknown) -> Option<Slope> {
        let of_totals = self.budget.u_squareness()?;
        let u_um_per_m = match (self.setup, unknown) {
            (SetUp::AssumePerfect, Unknown::Squareness(plane)) => of_totals.of(plane),
            _ => self.metric.u(unknown)?,
        };
        Some(Slope { u_um_per_m, by_end: gains.by_end(unknown), rotation_um_per_m: 0.0 })
    }

    /// Where the slope of a term comes from; `None` where its uncertainty is not known.
    fn slope_from(&self, gains: &SlopeGains, term: ErrorTerm) -> Option<SlopeFrom> {
        let rule = self.rule(term);
        if rule.keeps_separated_slope() {
            return Some(SlopeFrom::Increments);
        }
        let Some((unknown, share)) = rule.figure else {
            return Some(SlopeFrom::Elsewhere(Slope::default()));
        };
        let whole = self.figure_slope(gains, unknown)?;
        let (noise, all) = if rule.own > 0.0 { self.budget.u_turn(term)? } else { (0.0, 0.0) };
        Some(SlopeFrom::Elsewhere(Slope {
            u_um_per_m: (share * whole.u_um_per_m).hypot(all),
            by_end: PerDiagonal::from_fn(|d| share * whole.by_end[d]),
            rotation_um_per_m: noise,
        }))
    }

    /// Uncertainty of φ; `angles` = that of the unmeasured angles, µm/m.
    pub(super) fn u_squareness(
        &self,
        gains: &SlopeGains,
        angles: &PerPlane<f64>,
    ) -> PerPlane<Option<SlopeUncertainty>> {
        PerPlane::from_fn(|plane| {
            let slope = self.figure_slope(gains, Unknown::Squareness(plane))?;
            let u_um_per_m = slope.u_um_per_m.hypot(angles.of(plane));
            self.budget.of_slope(&Slope { u_um_per_m, ..slope })
        })
    }

    /// The curves beside the lines through their ends: determined whatever the set-up.
    pub(super) fn shapes(&self) -> PerTerm<Curve> {
        PerTerm::from_fn(|term| {
            with_slope(self.budget.volume, term.along, &self.mean_raw[term], 0.0)
        })
    }

    /// The redundancy of (7); `None` where there is none or where the set-up is assumed. A contradiction
    /// leaves no uncertainty of scales and squareness, and no tilt.
    pub(super) fn judged(&mut self) -> Option<Agreement> {
        let asked = self.setup == SetUp::Solve && self.equations.has_lines();
        let agreement = asked.then(|| self.equations.agreement(&self.metric))??;
        self.is_refuted = agreement.is_refuted();
        if self.is_refuted {
            self.metric.forget_uncertainties();
        }
        Some(agreement)
    }

    /// A separated curve with the slope of the mean curve put right.
    pub(super) fn turned(&self, term: ErrorTerm, curve: &Curve) -> Option<Curve> {
        let change = self.slope(term)? - self.naive[term];
        Some(plus_line(self.budget.volume, term.along, curve, change))
    }

    /// The nine errors with their uncertainties.
    pub(super) fn errors(
        &self,
        gains: &SlopeGains,
        turn: Option<&Turn>,
        reversals: &LinearReversals,
    ) -> NineErrors {
        let evidence = |term: ErrorTerm, deviation_um: Curve, side: Side<'_>| {
            let slope = self.slope_from(gains, term);
            let along = slope.and_then(|slope| self.budget.curve(term, side, slope));
            let (u_um, u_noise_um) = along.unzip();
            SeparatedError { deviation_um, u_um, u_noise_um }
        };
        let mean = PerTerm::from_fn(|term| {
            let curve = self.turned(term, &self.mean_raw[term])?;
            Some(evidence(term, curve, Side::Mean))
        });
        let directed = |direction: Direction| {
            let [plus, minus] = self.raw.as_slice() else {
                return None;
            };
            Some(PerTerm::from_fn(|term| {
                let mean = &mean[term].as_ref()?.deviation_um;
                let reversal = reversal(term, &plus[term], &minus[term], turn);
                let curve = directed_curve(mean, &reversal, direction);
                Some(evidence(term, curve, Side::Moving(direction, turn)))
            }))
        };
        let mut errors =
            NineErrors { plus: directed(Direction::Plus), minus: directed(Direction::Minus), mean };
        errors.set_apart(reversals);
        errors
    }

    /// η_d = q_d − Aᵀ u_d with the slopes of the X-primary frame; `None` where scales or squareness
    /// are not determined, because then the tilts are not either.
    pub(super) fn tilts(&self) -> Option<PerDiagonal<Tilt>> {
        let assumed = self.setup == SetUp::AssumePerfect;
        if assumed || self.is_refuted || !self.metric.is_complete() {
            return None;
        }
        // X primary: EXY, EXZ and EYZ carry the squareness (p_xy = φxy …).
        let slope = |term| Rule::of(SetUp::Solve, Frame::XPrimary, term).figure;
        let slope = |term| slope(term).and_then(|(unknown, _)| self.metric.value(unknown));
        Some(PerDiagonal::from_fn(|diagonal| {
            let u = self.budget.volume.laser(diagonal);
            let expected = |along: Axis| {
                let part = |of: Axis| slope(ErrorTerm { of, along }).unwrap_or(0.0) * u[of];
                u[along] + 1e-6 * Axis::ALL.into_iter().map(part).sum::<f64>()
            };
            let eta = PerAxis::from_fn(|axis| self.ratios[diagonal][axis] - expected(axis));
            let size = eta.length();
            Tilt {
                arcsec: size * ARCSEC_PER_RADIAN,
                direction: PerAxis::from_fn(|a| if size > 0.0 { eta[a] / size } else { 0.0 }),
            }
        }))
    }
}

/// Tilt of the mirror's normal against the nominal diagonal, in the machine's X-primary frame, for the
/// operator to correct.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tilt {
    /// Its size, seconds of arc.
    pub arcsec: f64,
    /// Unit vector into which the normal leans (machine axes); perpendicular to the diagonal.
    pub direction: PerAxis<f64>,
}

/// B of a term along its axis, µm: from the turn, else against its unknown value at the low end.
fn reversal(term: ErrorTerm, plus: &[f64], minus: &[f64], turn: Option<&Turn>) -> Vec<f64> {
    let walk: Vec<f64> = plus.iter().zip(minus).map(|(p, m)| p - m).collect();
    match turn {
        Some(turn) => turn.along(term, &walk),
        None => walk,
    }
}

/// φ as the sum of two separated slopes, µm/m.
pub(super) fn naive_squareness(slopes_um_per_m: &PerTerm<f64>, plane: Plane) -> f64 {
    let [one, other] = plane.terms();
    slopes_um_per_m[one] + slopes_um_per_m[other]
}

/// A line as formula (7) takes it, between the ends of the box: what the separated shapes contribute
/// between its own ends taken off. Between places x₁ and x₂ of each axis k,
/// Σ_jk v_j (D_j(k)(x₂) − D_j(k)(x₁)) = L·vᵀhv + that of the shapes.
fn without_shapes(
    budget: &Budget<'_>,
    mean_raw: &PerTerm<Curve>,
    line: &MeasuredLine,
) -> MeasuredLine {
    let volume = budget.volume;
    let Some([from, to]) = line.ends else {
        return *line;
    };
    let (mut shape_um, mut variance) = (0.0, 0.0);
    for term in ErrorTerm::ALL {
        let [from, to] = [from, to].map(|end| end[term.along].mm());
        if (from - to).abs() <= 0.0 {
            continue;
        }
        let shape = with_slope(volume, term.along, &mean_raw[term], 0.0);
        let positions = volume.positions(term.along);
        let share = line.direction[term.of];
        shape_um += share * (at(&positions, &shape, to) - at(&positions, &shape, from));
        let spread = budget.shape_variance(term, from, to);
        variance += share * share * spread.unwrap_or(0.0);
    }
    let square_mm = |axis: Axis| (to[axis] - from[axis]).mm().squared();
    let square_mm: f64 = Axis::ALL.into_iter().map(square_mm).sum();
    let per_m = 1000.0 / square_mm.sqrt();
    MeasuredLine {
        slope_um_per_m: line.slope_um_per_m - per_m * shape_um,
        u_um_per_m: line.u_um_per_m.map(|u| u.hypot(per_m * variance.sqrt())),
        ..*line
    }
}

/// One separated curve.
#[derive(Clone, Debug, PartialEq)]
pub struct SeparatedError {
    /// Deviations at the interval ends, lowest first, µm; the first is 0 (a − curve: the reversal).
    pub deviation_um: Curve,
    /// Standard uncertainties (k = 1) against the first position, µm; `None` = not known.
    pub u_um: Option<Vec<f64>>,
    /// The part of them that comes from the noise of the readings, µm.
    pub u_noise_um: Option<Vec<f64>>,
}

impl SeparatedError {
    /// Effective degrees of freedom of a point's uncertainty; `None` = unlimited.
    pub fn freedom(&self, index: usize, noise: Option<Noise>) -> Option<f64> {
        let u = *self.u_um.as_ref()?.get(index)?;
        effective_freedom(u, *self.u_noise_um.as_ref()?.get(index)?, noise?)
    }

    /// U of a point, µm: its uncertainty with the coverage factor of its degrees of freedom.
    pub fn expanded_um(&self, index: usize, noise: Option<Noise>) -> Option<f64> {
        let u = *self.u_um.as_ref()?.get(index)?;
        Some(u * coverage_factor(self.freedom(index, noise)))
    }

    /// The curve of a direction beside this mean of both, by a reversal that was measured apart.
    fn beside(&self, reversal: &LinearReversal, direction: Direction) -> SeparatedError {
        let u_um = self.u_um.as_ref().zip(reversal.u_um.as_ref());
        let u_um: Option<Vec<f64>> = u_um.map(|(mean, of_reversal)| {
            let start = of_reversal.first().copied().unwrap_or(0.0);
            let at = |(index, (mean, u)): (usize, (&f64, &f64))| match (index, direction) {
                (0, Direction::Plus) => *mean,
                (0, Direction::Minus) => mean.hypot(start),
                _ => mean.hypot(u.hypot(start) / 2.0),
            };
            mean.iter().zip(of_reversal).enumerate().map(at).collect()
        });
        SeparatedError {
            deviation_um: directed_curve(&self.deviation_um, &reversal.um, direction),
            u_noise_um: self.u_noise_um.clone().filter(|_| u_um.is_some()),
            u_um,
        }
    }
}

/// The curve of a direction: the mean of both is that of curves which start at 0, and the − curve
/// lies B below the + curve.
pub(super) fn directed_curve(mean: &[f64], reversal: &[f64], direction: Direction) -> Curve {
    let start = reversal.first().copied().unwrap_or(0.0);
    let value = |(mean, b): (&f64, &f64)| match direction {
        Direction::Plus => mean + (b - start) / 2.0,
        Direction::Minus => mean - (b + start) / 2.0,
    };
    mean.iter().zip(reversal).map(value).collect()
}

/// The nine errors; `None` = not determined.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct NineErrors {
    /// Without regard to direction, or the mean of both.
    pub mean: PerTerm<Option<SeparatedError>>,
    /// Moving in +, with two directions.
    pub plus: Option<PerTerm<Option<SeparatedError>>>,
    /// Moving in −. Where the reversal is not determined it starts at 0, too.
    pub minus: Option<PerTerm<Option<SeparatedError>>>,
}

impl NineErrors {
    /// The curves of a direction.
    pub fn directed(&self, direction: Direction) -> Option<&PerTerm<Option<SeparatedError>>> {
        match direction {
            Direction::Plus => self.plus.as_ref(),
            Direction::Minus => self.minus.as_ref(),
        }
    }

    /// φ of least squares lines through the separated curves, µm/m.
    pub(super) fn least_squares_squareness(&self, volume: &Volume) -> PerPlane<Option<f64>> {
        let slope = |term: ErrorTerm| {
            let positions = volume.positions(term.along);
            let positions: Vec<f64> = positions.iter().map(|p| p.mm()).collect();
            let curve = &self.mean[term].as_ref()?.deviation_um;
            Some(ReferenceLine::LeastSquares.slope_um_per_m(&positions, curve))
        };
        PerPlane::from_fn(|plane| plane.terms().map(slope).into_iter().sum())
    }

    /// Sets the two directions of each positioning error apart by its reversal.
    fn set_apart(&mut self, reversals: &LinearReversals) {
        for axis in Axis::ALL {
            let term = ErrorTerm::positioning(axis);
            let (Some(reversal), Some(mean)) = (&reversals[axis], &self.mean[term]) else {
                continue;
            };
            for (errors, direction) in
                [(&mut self.plus, Direction::Plus), (&mut self.minus, Direction::Minus)]
            {
                errors.get_or_insert_default()[term] = Some(mean.beside(reversal, direction));
            }
        }
    }
}
