//! Slopes of the nine curves, from increments, totals and lines, and the curves with their uncertainties.
//!
//! ```text
//!   slope(term) = share · figure + a · (separated slope) + b · (separated slope of the twin)
//!   figure      = a scale or a squareness: of (7), or of the totals where the set-up is assumed (4)
//! ```

use super::campaign::MeasuredLine;
use super::curves::{Curve, ReferenceLine};
use super::metric::{Agreement, Equation, Equations, Metric, UM_PER_M};
use super::start::Start;
use crate::inputs::job::{Frame, SetUp};
use crate::quantity::{
    Axis, Diagonal, Direction, ErrorTerm, PerAxis, PerDiagonal, PerPlane, PerTerm, Plane,
    URAD_PER_ARCSEC, Volume,
};
use nonius_numerics::rows::{CurveRows, Row, Uncertainty};
use std::sync::Arc;

/// Curves as rows over what was measured, and what their slopes come from.
pub(super) struct CurvesAndSlopes<'a> {
    pub(super) start: Start<'a>,
    /// Increments of the mean curves over each interval.
    mean_steps: PerTerm<Arc<[Row]>>,
    /// Slopes of the increments, µm/m.
    pub(super) naive: PerTerm<f64>,
    /// Displacement per commanded unit: q_dk = s_dk (V_k/R + n m̄_dk/V_k), without dimension.
    ratios: PerDiagonal<PerAxis<f64>>,
    equations: Equations,
    /// Scales and squareness by what was measured.
    pub(super) metric: Metric,
    pub(super) ends_um: PerDiagonal<f64>,
}

/// φ by the totals of the diagonals (4), µm/m.
fn of_totals(volume: &Volume, ends: &PerDiagonal<Row>, plane: Plane) -> Row {
    let (a, b) = plane.axes();
    let area = volume.size[a].mm() * volume.size[b].mm();
    let share = 1000.0 * volume.diagonal_mm() / (4.0 * area);
    Row::sum(Diagonal::ALL.map(|d| (share * d.sign(a) * d.sign(b), &ends[d])))
}

/// S = X²p_xx + Y²p_yy + Z²p_zz, µm·mm: the one combination of the scales that the readings at the far ends tell, µm.
pub fn scale_sum_um_mm(volume: &Volume, ends_um: &PerDiagonal<f64>) -> f64 {
    volume.diagonal_mm() * ends_um.iter().map(|(_, um)| um).sum::<f64>() / 4.0
}

impl<'a> CurvesAndSlopes<'a> {
    pub(super) fn new(mut start: Start<'a>) -> CurvesAndSlopes<'a> {
        let (campaign, volume, known) = (start.campaign, start.volume(), start.noise.is_some());
        let z = &start.z;
        let step = |term, at| start.mean(|group| start.delta(term, group, at));
        let mean_steps = PerTerm::from_fn(|term| -> Arc<[Row]> {
            (0..volume.steps).map(|at| step(term, at)).collect()
        });
        let sums = PerDiagonal::from_fn(|d| PerAxis::from_fn(|axis| start.sum(d, axis)));
        let ratio = |d: Diagonal, axis: Axis| {
            let length_um = volume.size[axis].mm() * 1000.0;
            d.sign(axis) * (volume.cosine(axis) + sums[d][axis].dot(z) / length_um)
        };
        let ratios = PerDiagonal::from_fn(|d| PerAxis::from_fn(|axis| ratio(d, axis)));
        let total = |d: Diagonal| Row::sum(sums[d].iter().map(|(_, sum)| (1.0, sum)));
        let ends = PerDiagonal::from_fn(total);
        // (7) of step runs: q_dᵀ h q_d = (q_d² − 1)/2.
        let of_diagonal = |d: Diagonal| {
            let (direction, nominal) = (ratios[d], volume.laser(d));
            let value = (direction.dot(direction) - 1.0) / 2.0 / UM_PER_M;
            let row = Row::sum([(1000.0 / volume.diagonal_mm(), &ends[d])]);
            Equation { direction, nominal, value, row, known, own: 0.0 }
        };
        let of_line = |(index, line): (usize, &MeasuredLine)| {
            let mut row = Row::of(start.model.layout.line(index));
            row.add(-1.0, shapes_in(volume, &mean_steps, line));
            Equation::of_line(line, row, z)
        };
        let lines = campaign.lines.iter().enumerate().map(of_line);
        let all = Diagonal::ALL.map(of_diagonal).into_iter().chain(lines).collect();
        let equations = Equations::new(all, &mut start.model);
        let (z, model) = (&start.z, &start.model);
        let mut metric = equations.metric(model);
        if campaign.measurement.setup == SetUp::AssumePerfect {
            for plane in Plane::ALL {
                metric.set_squareness(plane, of_totals(volume, &ends, plane), z, model);
            }
        }
        let ends_um = PerDiagonal::from_fn(|d| ends[d].dot(z));
        let length = |axis: Axis| volume.size[axis].mm() / 1000.0;
        let rise =
            |term: ErrorTerm| mean_steps[term].iter().map(|step: &Row| step.dot(z)).sum::<f64>();
        let naive = PerTerm::from_fn(|term| rise(term) / length(term.along));
        CurvesAndSlopes { naive, ratios, metric, equations, ends_um, mean_steps, start }
    }

    /// What is assumed of the set-up.
    pub(super) fn setup(&self) -> SetUp {
        self.start.campaign.measurement.setup
    }

    fn metres(&self, term: ErrorTerm) -> f64 {
        self.start.volume().size[term.along].mm() / 1000.0
    }

    /// What the slope of a term is made of: shares of its figure, of its separated slope, of that of its twin.
    fn rule(&self, term: ErrorTerm) -> [f64; 3] {
        let measurement = self.start.campaign.measurement;
        match (measurement.setup, measurement.frame) {
            (SetUp::AssumePerfect, frame)
                if term.is_positioning() || frame == Frame::AsMeasured =>
            {
                [0.0, 1.0, 0.0]
            }
            // The rotation is that of the separated slopes, their sum that of the totals.
            (SetUp::Solve, Frame::AsMeasured) if term.is_cross() => [0.5, 0.5, -0.5],
            // EXY, EXZ and EYZ carry the squareness of their plane.
            _ if term.of <= term.along => [1.0, 0.0, 0.0],
            _ => [0.0; 3],
        }
    }

    /// The mean curve of a term, its slope put right; `None` = its slope is not determined.
    fn mean_rows(&self, term: ErrorTerm) -> Option<CurveRows> {
        let [share, own, of_twin] = self.rule(term);
        let (twin, metres, found) = (term.twin(), self.metres(term), self.metric.of(term));
        let steps = self.mean_steps[term].clone();
        let figure = if share > 0.0 { share * found.um_per_m? } else { 0.0 };
        let slope = figure + own * self.naive[term] + of_twin * self.naive[twin];
        let mut line = Row::default();
        // A separated slope stays as it is.
        if own < 1.0 {
            for (times, of) in [(own - 1.0, term), (of_twin * metres / self.metres(twin), twin)] {
                self.mean_steps[of].iter().for_each(|step| line.add(times, step));
            }
            line.add(share * metres, &found.row);
        }
        let line_um = (slope - self.naive[term]) * metres;
        Some(CurveRows { start: Row::default(), steps, line, line_um })
    }

    /// The curves beside the lines through their ends: determined whatever the set-up.
    pub(super) fn shapes(&self) -> PerTerm<Curve> {
        PerTerm::from_fn(|term| {
            let curve = CurveRows { steps: self.mean_steps[term].clone(), ..CurveRows::default() };
            curve.values(&self.start.z, -self.naive[term] * self.metres(term))
        })
    }

    /// The redundancy of (7); `None` where there is none or where the set-up is assumed.
    pub(super) fn judged(&self) -> Option<Agreement> {
        (self.setup() == SetUp::Solve).then(|| self.equations.agreement(&self.metric))?
    }

    /// The nine errors with their uncertainties; `apart`: B of each term, and whether its uncertainty is known.
    pub(super) fn errors(&self, apart: &PerTerm<Option<(CurveRows, bool)>>) -> NineErrors {
        let mean = |term| Some(self.evidence(term, self.mean_rows(term)?, true));
        // The mean of both is that of curves which start at 0.
        let directed = |side: f64| {
            PerTerm::from_fn(|term| {
                let (b, is_known) = apart[term].as_ref()?;
                let mut rows = self.mean_rows(term)?.beside(side / 2.0, b);
                rows.start.add((side - 1.0) / 2.0, &b.start);
                Some(self.evidence(term, rows, *is_known))
            })
        };
        let directed = apart.iter().any(|(_, b)| b.is_some()).then(|| [1.0, -1.0].map(directed));
        NineErrors { mean: PerTerm::from_fn(mean), directed }
    }

    /// A curve with its uncertainties, if those of what stands beside the mean are known.
    fn evidence(&self, term: ErrorTerm, rows: CurveRows, is_known: bool) -> SeparatedError {
        let [share, own, _] = self.rule(term);
        // A separated slope holds the tilt of the mirror.
        let slope_is_known = match share > 0.0 {
            true => self.metric.of(term).is_known,
            false => own < 1.0 || self.start.campaign.stated.tilt_arcsec.is_some(),
        };
        let variances = || rows.variances(&self.start.model).into_iter();
        let u = || variances().map(|variance| self.start.model.uncertainty(variance)).collect();
        let u = (is_known && slope_is_known).then(u).flatten();
        SeparatedError { deviation_um: rows.values(&self.start.z, rows.line_um), u, rows }
    }

    /// η_d = q_d − Aᵀ u_d with the slopes of the X-primary frame; `None` where scales or squareness
    /// are not determined, because then the tilts are not either.
    pub(super) fn tilts(&self) -> Option<PerDiagonal<Tilt>> {
        if self.setup() == SetUp::AssumePerfect || !self.metric.is_complete() {
            return None;
        }
        // X primary: EXY, EXZ and EYZ carry the squareness (p_xy = φxy …).
        let slope = |of: Axis, along: Axis| {
            self.metric.of(ErrorTerm { of, along }).um_per_m.filter(|_| of <= along).unwrap_or(0.0)
        };
        Some(PerDiagonal::from_fn(|diagonal| {
            let u = self.start.volume().laser(diagonal);
            let turned = PerAxis::from_fn(|along| PerAxis::from_fn(|of| slope(of, along)).dot(u));
            let eta = self.ratios[diagonal].minus(u).minus(turned.times(UM_PER_M));
            let size = eta.length();
            let direction = eta.times(if size > 0.0 { 1.0 / size } else { 0.0 });
            Tilt { arcsec: size / UM_PER_M / URAD_PER_ARCSEC, direction }
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

/// φ as the sum of two separated slopes, µm/m: it holds the tilt of the mirror.
pub(crate) fn naive_squareness(slopes_um_per_m: &PerTerm<f64>, plane: Plane) -> f64 {
    let [one, other] = plane.terms();
    slopes_um_per_m[one] + slopes_um_per_m[other]
}

/// What the separated shapes contribute to a line between its own ends, µm/m. Between places x₁ and x₂ of
/// each axis k, Σ_jk v_j (D_j(k)(x₂) − D_j(k)(x₁)) = L·vᵀhv + that of the shapes.
fn shapes_in(volume: &Volume, steps: &PerTerm<Arc<[Row]>>, line: &MeasuredLine) -> Row {
    let Some([from, to]) = line.ends else {
        return Row::default();
    };
    let per_m = 1000.0 / PerAxis::from_fn(|axis| (to[axis] - from[axis]).mm()).length();
    let mut all = Row::default();
    for term in ErrorTerm::ALL {
        let (length, n) = (volume.size[term.along].mm(), volume.steps_f64());
        for (sign, end) in [(1.0, to), (-1.0, from)] {
            let at = (end[term.along] - volume.start[term.along]).mm() / length;
            for (index, step) in steps[term].iter().enumerate() {
                let passed = (at * n - index as f64).clamp(0.0, 1.0);
                all.add(sign * per_m * line.direction[term.of] * (passed - at), step);
            }
        }
    }
    all
}

/// One separated curve.
#[derive(Clone, Debug, PartialEq)]
pub struct SeparatedError {
    /// Deviations at the interval ends, lowest first, µm; the first is 0 (a − curve: the reversal).
    pub deviation_um: Curve,
    /// Uncertainties against the first position, µm; `None` = not known.
    pub u: Option<Vec<Uncertainty>>,
    /// How it hangs on what was measured.
    pub(super) rows: CurveRows,
}

impl SeparatedError {
    /// Standard uncertainties (k = 1) against the first position, µm; `None` = not known.
    pub fn u_um(&self) -> Option<Vec<f64>> {
        Some(self.u.as_ref()?.iter().map(|point| point.u).collect())
    }

    /// U of a point, µm: its uncertainty with the coverage factor of its degrees of freedom.
    pub fn expanded_um(&self, index: usize) -> Option<f64> {
        self.u.as_ref()?.get(index).map(Uncertainty::expanded)
    }
}

/// The nine errors; `None` = not determined.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct NineErrors {
    /// Without regard to direction, or the mean of both.
    pub mean: PerTerm<Option<SeparatedError>>,
    /// Moving in + and moving in −, with two directions. Where the reversal is not determined both start at 0.
    pub directed: Option<[PerTerm<Option<SeparatedError>>; 2]>,
}

impl NineErrors {
    /// The curves of a direction.
    pub fn directed(&self, direction: Direction) -> Option<&PerTerm<Option<SeparatedError>>> {
        self.directed.as_ref().map(|ways| &ways[direction as usize])
    }

    /// φ of least squares lines through the separated curves, µm/m.
    pub fn least_squares_squareness(&self, volume: &Volume) -> PerPlane<Option<f64>> {
        let slope = |term: ErrorTerm| {
            let positions: Vec<f64> = volume.positions(term.along).iter().map(|p| p.mm()).collect();
            let curve = &self.mean[term].as_ref()?.deviation_um;
            Some(ReferenceLine::LeastSquares.slope_um_per_m(&positions, curve))
        };
        PerPlane::from_fn(|plane| plane.terms().map(slope).into_iter().sum())
    }
}
