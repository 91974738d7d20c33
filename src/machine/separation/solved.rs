//! Slopes of the nine curves and what they come from: increments, totals and lines.

use super::agreement::{Agreement, agreement};
use super::beams::without_shapes;
use super::campaign::Campaign;
use super::curves::{Curve, curves, end_slope, mean, plus_line};
use super::evidence::{Evidence, NineErrors};
use super::increments::{Increments, Means, mean_increments};
use super::linear_reversal::LinearReversals;
use super::metric::{
    EndGains, Metric, PerPlane, Plane, StraightLine, displacement_ratios, end_gains, solve, stepped,
};
use super::plane::per_plane;
use super::reversal::Turn;
use super::slope_gains::SlopeGains;
use super::uncertainty::{Budget, Side, Slope, SlopeFrom, SlopeUncertainty};
use crate::inputs::job::{Frame, SetUp};
use crate::machine::separation::totals::{Totals, totals};
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis, PerTerm};
use crate::quantity::diagonal::{Diagonal, PerDiagonal, Volume};

/// Slopes and the curves of every group of readings.
pub(super) fn solve_readings(
    campaign: &Campaign<'_>,
    budget: &Budget<'_>,
    means: &Means,
) -> (Solved, Vec<PerTerm<Curve>>) {
    let volume = budget.volume;
    let groups = means.groups();
    let increments: Vec<Increments> = groups
        .iter()
        .map(|group| means.increments(volume, *group))
        .collect();
    let raw: Vec<PerTerm<Curve>> = increments.iter().map(|m| curves(volume, m)).collect();
    let solved = Solved::new(campaign, budget, &increments, &raw);
    (solved, raw)
}

/// Slopes and what they come from.
pub(super) struct Solved {
    volume: Volume,
    setup: SetUp,
    frame: Frame,
    pub(super) mean_raw: PerTerm<Curve>,
    pub(super) ratios: PerDiagonal<PerAxis<f64>>,
    pub(super) metric: Metric,
    pub(super) ends_um: PerDiagonal<f64>,
    pub(super) totals: Totals,
    lines: Vec<StraightLine>,
    pub(super) both_ways: bool,
}

impl Solved {
    fn new(
        campaign: &Campaign<'_>,
        budget: &Budget<'_>,
        increments: &[Increments],
        raw: &[PerTerm<Curve>],
    ) -> Solved {
        let measurement = campaign.measurement;
        let volume = &measurement.volume;
        let means = mean_increments(increments);
        let ratios = displacement_ratios(volume, &means);
        let both_ways = increments.len() == 2;
        let mean_raw = PerTerm::from_fn(|term| {
            mean(&raw.iter().map(|group| &group[term]).collect::<Vec<_>>())
        });
        let lines = campaign.lines.iter();
        let lines: Vec<StraightLine> = lines
            .map(|line| without_shapes(budget, both_ways, &mean_raw, line))
            .collect();
        let end = |d: Diagonal| {
            let of_axis = |axis: Axis| volume.steps_f64() * means[d][axis];
            Axis::ALL.into_iter().map(of_axis).sum::<f64>()
        };
        let ends_um = PerDiagonal::from_fn(end);
        Solved {
            volume: volume.clone(),
            setup: measurement.setup,
            frame: measurement.frame,
            mean_raw,
            metric: solve(volume, &stepped(&ratios), &budget.totals(both_ways), &lines),
            ratios,
            totals: totals(volume, &ends_um),
            ends_um,
            lines,
            both_ways,
        }
    }

    pub(super) fn naive_slopes(&self, volume: &Volume) -> PerTerm<f64> {
        PerTerm::from_fn(|term| end_slope(volume, term.along, &self.mean_raw[term]))
    }

    pub(super) fn squareness(&self, setup: SetUp) -> PerPlane<Option<f64>> {
        match setup {
            SetUp::Solve => self.metric.squareness,
            SetUp::AssumePerfect => PerPlane {
                xy: Some(self.totals.squareness_um_per_m.xy),
                xz: Some(self.totals.squareness_um_per_m.xz),
                yz: Some(self.totals.squareness_um_per_m.yz),
            },
        }
    }

    /// Slope of a term, µm/m; `None` = not determined.
    fn slope(&self, term: ErrorTerm) -> Option<f64> {
        let naive = |term: ErrorTerm| end_slope(&self.volume, term.along, &self.mean_raw[term]);
        match (self.setup, self.frame) {
            (SetUp::Solve, Frame::XPrimary) => self.metric_slope(term),
            (SetUp::Solve, Frame::AsMeasured) if term.is_positioning() => {
                self.metric.scale[term.along]
            }
            // The rotation is that of the separated slopes, their sum that of the totals.
            (SetUp::Solve, Frame::AsMeasured) => {
                let twin = ErrorTerm {
                    of: term.along,
                    along: term.of,
                };
                let turn = (naive(term) - naive(twin)) / 2.0;
                Some(self.metric.squareness.of(plane_of(term))? / 2.0 + turn)
            }
            (SetUp::AssumePerfect, Frame::AsMeasured) => Some(naive(term)),
            (SetUp::AssumePerfect, Frame::XPrimary) if term.is_positioning() => Some(naive(term)),
            (SetUp::AssumePerfect, Frame::XPrimary) if carries_squareness(term) => {
                Some(self.totals.squareness_um_per_m.of(plane_of(term)))
            }
            (SetUp::AssumePerfect, Frame::XPrimary) => Some(0.0),
        }
    }

    fn metric_slope(&self, term: ErrorTerm) -> Option<f64> {
        if term.is_positioning() {
            self.metric.scale[term.along]
        } else if carries_squareness(term) {
            self.metric.squareness.of(plane_of(term))
        } else {
            Some(0.0)
        }
    }

    /// Whether the slope of a term is that of the increments, with the tilt of the mirror.
    pub(super) fn keeps_separated_slope(&self, term: ErrorTerm) -> bool {
        match (self.setup, self.frame) {
            (SetUp::Solve, _) => false,
            (SetUp::AssumePerfect, Frame::AsMeasured) => true,
            (SetUp::AssumePerfect, Frame::XPrimary) => term.is_positioning(),
        }
    }

    /// Where the slope of a term comes from; `None` where its uncertainty is not known.
    fn slope_from(
        &self,
        budget: &Budget<'_>,
        gains: &EndGains,
        term: ErrorTerm,
    ) -> Option<SlopeFrom> {
        if self.keeps_separated_slope(term) {
            return Some(SlopeFrom::Increments);
        }
        let slope = match (self.setup, self.frame) {
            (SetUp::Solve, _) if term.is_positioning() => Slope {
                u_um_per_m: self.metric.u_scale(term.along)?,
                by_end: gains.scale(term.along),
                rotation_um_per_m: 0.0,
            },
            (SetUp::Solve, Frame::AsMeasured) => {
                let half = self.squareness_slope(budget, gains, plane_of(term))?;
                let (noise, all) = budget.u_turn(term, self.both_ways)?;
                Slope {
                    u_um_per_m: (half.u_um_per_m / 2.0).hypot(all),
                    by_end: PerDiagonal::from_fn(|d| half.by_end[d] / 2.0),
                    rotation_um_per_m: noise,
                }
            }
            (_, Frame::XPrimary) if !carries_squareness(term) => Slope::default(),
            _ => self.squareness_slope(budget, gains, plane_of(term))?,
        };
        Some(SlopeFrom::Elsewhere(slope))
    }

    /// φ as a slope; `None` where its uncertainty is not known.
    fn squareness_slope(
        &self,
        budget: &Budget<'_>,
        gains: &EndGains,
        plane: Plane,
    ) -> Option<Slope> {
        let of_totals = budget.u_squareness(self.both_ways)?.of(plane);
        let (u_um_per_m, by_end) = match self.setup {
            SetUp::Solve => (self.metric.u_squareness(plane)?, gains.squareness(plane)),
            SetUp::AssumePerfect => (of_totals, self.by_end_of_totals(plane)),
        };
        Some(Slope {
            u_um_per_m,
            by_end,
            rotation_um_per_m: 0.0,
        })
    }

    /// Change of φ of formula (4) with each total, µm/m for each µm.
    fn by_end_of_totals(&self, plane: Plane) -> PerDiagonal<f64> {
        PerDiagonal::from_fn(|d| {
            let one = PerDiagonal::from_fn(|other| f64::from(other == d));
            totals(&self.volume, &one).squareness_um_per_m.of(plane)
        })
    }

    /// Uncertainty of φ; `angles` = that of the unmeasured angles, µm/m.
    pub(super) fn u_squareness(
        &self,
        budget: &Budget<'_>,
        gains: &EndGains,
        angles: &PerPlane<f64>,
    ) -> PerPlane<Option<SlopeUncertainty>> {
        per_plane(Plane::ALL.map(|plane| {
            let slope = self.squareness_slope(budget, gains, plane)?;
            let u_um_per_m = slope.u_um_per_m.hypot(angles.of(plane));
            budget.of_slope(
                &Slope {
                    u_um_per_m,
                    ..slope
                },
                self.both_ways,
            )
        }))
    }

    /// Slopes and squareness as functions of totals and separated slopes.
    pub(super) fn slope_gains(&self, gains: &EndGains) -> SlopeGains {
        let squareness = |plane: Plane| match self.setup {
            SetUp::Solve => gains.squareness(plane),
            SetUp::AssumePerfect => self.by_end_of_totals(plane),
        };
        let part = |plane: Plane, share: f64| {
            let all = squareness(plane);
            PerDiagonal::from_fn(|d| share * all[d])
        };
        let none = PerDiagonal::default();
        let of = |term: ErrorTerm| match (self.setup, self.frame) {
            _ if self.keeps_separated_slope(term) => (none, [1.0, 0.0]),
            _ if term.is_positioning() => (gains.scale(term.along), [0.0; 2]),
            (_, Frame::AsMeasured) => (part(plane_of(term), 0.5), [0.5, -0.5]),
            (_, Frame::XPrimary) if carries_squareness(term) => {
                (part(plane_of(term), 1.0), [0.0; 2])
            }
            (_, Frame::XPrimary) => (none, [0.0; 2]),
        };
        SlopeGains {
            by_end: PerTerm::from_fn(|term| of(term).0),
            by_separated: PerTerm::from_fn(|term| of(term).1),
            squareness: per_plane(Plane::ALL.map(squareness)),
            own_slopes: self.frame == Frame::AsMeasured,
        }
    }

    /// How the slopes change with the totals.
    pub(super) fn gains(&self, budget: &Budget<'_>) -> EndGains {
        end_gains(
            &self.volume,
            &stepped(&self.ratios),
            &budget.totals(self.both_ways),
            &self.lines,
        )
    }

    /// The redundancy of (7); `None` where there is none or where the set-up is assumed.
    pub(super) fn agreement(&self, budget: &Budget<'_>) -> Option<Agreement> {
        if self.setup == SetUp::AssumePerfect || self.lines.is_empty() {
            return None;
        }
        let totals = budget.totals(self.both_ways);
        agreement(
            &self.volume,
            &stepped(&self.ratios),
            &totals,
            &self.lines,
            &self.metric,
        )
    }

    /// What the solution of (7) rests on, in words.
    pub(super) fn labels(&self, is_checked: bool) -> Vec<String> {
        let mut said: Vec<String> = self.frame_label().into_iter().collect();
        if self.setup == SetUp::AssumePerfect {
            return said;
        }
        if self.metric.is_complete() && !is_checked {
            said.push("nothing checks the linear axes and beams: with no redundancy a slope of the wrong sign or unit goes unnoticed; measure the third axis along its length".to_string());
        }
        if !self.metric.is_complete() {
            let of =
                |plane: Plane| format!("{} {:.3}", plane.key(), 10.0 * self.metric.leak.of(plane));
            said.push(format!(
                "the uncertainty of the squareness leaves out what is not determined of the scales: through the tilts of the mirror each 10 µm/m of it moves the squareness by up to (µm/m) {}",
                Plane::ALL.map(of).join(", ")
            ));
        }
        if self.frame == Frame::AsMeasured {
            said.push("uncertainties of the cross terms hold the noise of their rotation, not the tilt of the mirror that is in it".to_string());
        }
        said
    }

    /// A separated curve with the slope of the mean curve put right.
    pub(super) fn turned(&self, term: ErrorTerm, curve: &Curve) -> Option<Curve> {
        let raw_slope = end_slope(&self.volume, term.along, &self.mean_raw[term]);
        let change = self.slope(term)? - raw_slope;
        Some(plus_line(&self.volume, term.along, curve, change))
    }

    pub(super) fn errors(
        &self,
        budget: &Budget<'_>,
        gains: &EndGains,
        raw: &[PerTerm<Curve>],
        turn: Option<&Turn>,
    ) -> NineErrors {
        let along = |term: ErrorTerm, side: Side<'_>| {
            let slope = self.slope_from(budget, gains, term)?;
            budget.curve(term, side, slope, self.both_ways)
        };
        let mean = PerTerm::from_fn(|term| {
            let curve = self.turned(term, &self.mean_raw[term])?;
            Some(Evidence::new(curve, along(term, Side::Mean)))
        });
        let directed = |direction: Direction| {
            let [plus, minus] = raw else { return None };
            let evidence = |term: ErrorTerm| {
                let mean = &mean[term].as_ref()?.deviation_um;
                let reversal = reversal(term, &plus[term], &minus[term], turn);
                let curve = directed_curve(mean, &reversal, direction);
                Some(Evidence::new(
                    curve,
                    along(term, Side::Moving(direction, turn)),
                ))
            };
            Some(PerTerm::from_fn(evidence))
        };
        NineErrors {
            plus: directed(Direction::Plus),
            minus: directed(Direction::Minus),
            mean,
        }
    }

    /// Where the curves keep the slopes of the increments, their squareness is another one than
    /// that of the totals.
    fn frame_label(&self) -> Option<String> {
        let kept = (self.setup, self.frame) == (SetUp::AssumePerfect, Frame::AsMeasured);
        let slopes = self.naive_slopes(&self.volume);
        kept.then(|| {
            format!(
                "the curves keep their separated slopes, whose squareness (µm/m: {}) holds the tilt of the mirror and the noise of all increments; that of the totals ({}) holds neither: believe the totals",
                planes_in_words(|plane| naive_squareness(&slopes, plane)),
                planes_in_words(|plane| self.totals.squareness_um_per_m.of(plane))
            )
        })
    }

    pub(super) fn undetermined(&self, from_turn: bool, known: &LinearReversals) -> Vec<String> {
        let mut words = match self.setup {
            SetUp::Solve => self.metric.undetermined(),
            SetUp::AssumePerfect => Vec::new(),
        };
        let open: Vec<String> = Axis::ALL
            .into_iter()
            .filter(|axis| known[*axis].is_none())
            .map(|axis| axis.to_string())
            .collect();
        if self.both_ways && !from_turn && !open.is_empty() {
            let of = match open.len() {
                3 => "each axis".to_string(),
                _ => open.join(", "),
            };
            words.push(format!(
                "reversal of {of}: with overrun (or a zero of their own) the reverse runs hold at most its sum along the diagonals; reverse once without overrun and state `overrun = false`, or name a linear measurement of the axis with rows of both directions (`errors` of [[measurement.step_diagonal.linear]])"
            ));
        }
        words
    }
}

/// B of a term along its axis, µm: from the turn, else against its unknown value at the low end.
fn reversal(term: ErrorTerm, plus: &[f64], minus: &[f64], turn: Option<&Turn>) -> Vec<f64> {
    let walk: Vec<f64> = plus.iter().zip(minus).map(|(p, m)| p - m).collect();
    match turn {
        Some(turn) => turn.along(term, &walk),
        None => walk,
    }
}

/// The curve of a direction: the mean of both is that of curves which start at 0, and the − curve
/// lies B below the + curve.
fn directed_curve(mean: &[f64], reversal: &[f64], direction: Direction) -> Curve {
    let start = reversal.first().copied().unwrap_or(0.0);
    let value = |(mean, b): (&f64, &f64)| match direction {
        Direction::Plus => mean + (b - start) / 2.0,
        Direction::Minus => mean - (b + start) / 2.0,
    };
    mean.iter().zip(reversal).map(value).collect()
}

/// In the X-primary frame EXY, EXZ and EYZ carry the squareness of their plane.
fn carries_squareness(term: ErrorTerm) -> bool {
    term.of < term.along
}

/// φ as the sum of two separated slopes, µm/m.
pub(super) fn naive_squareness(slopes_um_per_m: &PerTerm<f64>, plane: Plane) -> f64 {
    let (a, b) = plane.axes();
    let (one, other) = (ErrorTerm { of: a, along: b }, ErrorTerm { of: b, along: a });
    slopes_um_per_m[one] + slopes_um_per_m[other]
}

/// XY, XZ and YZ of a squareness in words, µm/m.
fn planes_in_words(of: impl Fn(Plane) -> f64) -> String {
    let words = Plane::ALL.map(|plane| {
        let value = (of(plane) * 1000.0).round() / 1000.0 + 0.0;
        format!("{} {value:.3}", plane.key().to_uppercase())
    });
    words.join(", ")
}

fn plane_of(term: ErrorTerm) -> Plane {
    match (term.of.min(term.along), term.of.max(term.along)) {
        (Axis::X, Axis::Y) => Plane::Xy,
        (Axis::X, _) => Plane::Xz,
        _ => Plane::Yz,
    }
}
