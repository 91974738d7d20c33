//! The nine errors as curves: as found, as forecast, as left, at one scale; and positioning at targets, the way the
//! standards draw it.

use super::locale::Locale;
use super::picture::{Diagram, Ink, Mark, Panel, Picture, Scale, at_one_height};
use crate::judge::field::Field;
use crate::kit::Inputs;
use crate::machine::model::{ErrorModel, MeasuredTerm};
use crate::machine::separation::Separation;
use crate::machine::standards::ByDirection;
use crate::machine::standards::iso_230_2::{self, Figures, TargetFigures};
use crate::quantity::{Direction, ErrorCurve, ErrorTerm, Millimetres, larger, smaller};
use crate::read::emulate::Response;

/// What the nine curves are drawn from; what is not there is not drawn.
#[derive(Clone, Copy)]
pub struct Curves<'a> {
    /// As found, and what is asked for.
    pub inputs: &'a Inputs,
    /// The tables as the control would add them, emulated from their bytes.
    pub loaded: Option<&'a Field>,
    /// As left.
    pub as_left: Option<&'a ErrorModel>,
}

/// Places of a curve over the measured range; between two of them a curve is straight on paper.
const SAMPLES: u32 = 120;
/// A step of a correction is drawn as a step: a place on either side of it, mm.
const BESIDE_MM: f64 = 1e-6;
/// Panels beside each other.
const COLUMNS: usize = 3;
/// Coverage factor of the band: U = k·u with k = 2 (GUM).
const K: f64 = 2.0;

/// Nine panels, a row for each direction of the error and a column for each moving axis; µm against
/// mm, zero at the reference. Both directions of travel are drawn where both are known. A band is
/// ±2 u of the measured values of its direction, about each curve of the last stage.
pub fn terms(locale: Locale<'_>, heading: &str, curves: &Curves<'_>) -> Picture {
    let drawn = ErrorTerm::ALL.map(|term| of(locale, term, curves.range(term), curves.marks(term)));
    let (mut panels, um) = at_one_height(locale, drawn);
    let limit_um = curves.inputs.job.acceptance.max_deviation_um;
    let limits = limit_um.into_iter().flat_map(|limit| [limit, -limit]);
    let limits = limits.filter(|at| (um.0..=um.1).contains(at));
    for Panel { across, marks, .. } in panels.iter_mut().flatten() {
        let level = |at| Mark::Line(Ink::Limit, vec![(across.from, at), (across.to, at)]);
        marks.extend(limits.clone().map(level));
    }
    // A few errors stand in one row, without the empty places of the others.
    if panels.iter().flatten().count() <= COLUMNS {
        panels.retain(Option::is_some);
    }
    Picture {
        title: heading.to_string(),
        description: locale.between("curves_alt", um),
        columns: COLUMNS,
        panels,
        note: locale.words(if curves.loaded.is_some() {
            "curves_note_tables"
        } else {
            "curves_note"
        }),
    }
}

/// The nine errors as the readings of the diagonals give them, zero at the low end of each axis, with
/// bands of U (95 %) where it is known; both directions where they stand apart.
pub fn separated(locale: Locale<'_>, heading: &str, separation: &Separation) -> Picture {
    let drawn = ErrorTerm::ALL.map(|term| {
        let positions = separation.volume.positions(term.along);
        let ways = match separation.errors.directed.is_some() && separation.is_directed(term.along)
        {
            false => vec![(Ink::AsFound, None)],
            true => vec![(Ink::Up, Some(Direction::Plus)), (Ink::Down, Some(Direction::Minus))],
        };
        let found = ways.into_iter().filter_map(|(ink, way)| {
            let evidence = separation.of_table(term, way)?;
            let values = positions.iter().zip(&evidence.deviation_um).enumerate();
            let points = values.map(|(n, (at, um))| (at.mm(), *um, evidence.expanded_um(n)));
            let (band, line) = Mark::measured(ink, points)?;
            Some(band.into_iter().chain(line))
        });
        let ends = positions.first().zip(positions.last());
        let ends = ends.map_or((0.0, 0.0), |(first, last)| (first.mm(), last.mm()));
        of(locale, term, ends, found.flatten().collect())
    });
    let (panels, um) = at_one_height(locale, drawn);
    Picture {
        title: heading.to_string(),
        description: locale.between("separated_alt", um),
        columns: COLUMNS,
        panels,
        note: locale.words("separated_note"),
    }
}

/// What is drawn of an error between the ends of its axis, mm.
fn of(locale: Locale<'_>, term: ErrorTerm, (from, to): (f64, f64), marks: Vec<Mark>) -> Diagram {
    let kind = if term.is_positioning() { "positioning" } else { "straightness" };
    let axis = format!("{} / {}", term.along.letter(), locale.mm().sign);
    let across = Scale::new(&axis, from, to).shown_in(locale.mm());
    (format!("{term} {}", locale.words(kind)), across, marks)
}

impl Curves<'_> {
    fn found(&self, term: ErrorTerm) -> Option<&MeasuredTerm> {
        self.inputs.as_measured().terms[term].as_ref()
    }

    fn left(&self, term: ErrorTerm) -> Option<&MeasuredTerm> {
        self.as_left?.terms[term].as_ref()
    }

    /// The places that any of the curves covers, mm.
    fn range(&self, term: ErrorTerm) -> (f64, f64) {
        let measured = self.found(term).into_iter().chain(self.left(term));
        let ranges = measured.flat_map(MeasuredTerm::curves).map(ErrorCurve::measured_range);
        let ranges = ranges.map(|(from, to)| (from.mm(), to.mm()));
        ranges.reduce(|a, b| (smaller(a.0, b.0), larger(a.1, b.1))).unwrap_or((0.0, 1.0))
    }

    /// What is drawn of a term, bands first; nothing where it was never measured.
    fn marks(&self, term: ErrorTerm) -> Vec<Mark> {
        let (found, left) = (self.found(term), self.left(term));
        let (forecast, places) = self.forecast(term);
        let stages = [
            (Ink::AsFound, found, found.map_or_else(Vec::new, lines)),
            (Ink::Forecast, found, forecast),
            (Ink::AsLeft, left, left.map_or_else(Vec::new, lines)),
        ];
        let last = stages.iter().rfind(|(.., lines)| !lines.is_empty());
        let bands = last.into_iter().flat_map(|(ink, known, lines)| {
            lines.iter().filter_map(|line| band(*ink, (*known)?, line)).collect::<Vec<Mark>>()
        });
        let mut marks: Vec<Mark> = bands.collect();
        for (ink, _, lines) in stages {
            marks.extend(lines.into_iter().map(|line| Mark::Line(ink, line.points)));
        }
        let dots = left.into_iter().flat_map(MeasuredTerm::curves);
        marks.extend(dots.map(|curve| Mark::Dots(Ink::AsLeft, knots(curve))));
        marks.extend((!places.is_empty()).then_some(Mark::Places(places)));
        marks
    }

    /// Deviation without compensation + emulated correction in each direction, and the points of the
    /// tables.
    fn forecast(&self, term: ErrorTerm) -> (Vec<CurveLine>, Vec<f64>) {
        let (mut lines, mut places): (Vec<CurveLine>, Vec<f64>) = (Vec::new(), Vec::new());
        let known = self.inputs.model.terms[term].as_ref();
        let Some((control, known)) = self.loaded.zip(known) else {
            return (lines, places);
        };
        for direction in Direction::BOTH {
            let Some(curve) = known.measured.curve(direction) else {
                continue;
            };
            for response in control.ways(term, direction) {
                take(&mut lines, direction, sampled(curve, Some(response)));
                let nodes = response.tables().iter().flat_map(|table| table.nodes());
                places.extend(nodes.map(|(at, _)| at.mm()));
            }
        }
        let (from, to) = self.range(term);
        places.retain(|at| (from..=to).contains(at));
        places.sort_by(f64::total_cmp);
        places.dedup();
        (lines, places)
    }
}

/// A line of a term, moving one way.
struct CurveLine {
    direction: Direction,
    points: Vec<(f64, f64)>,
}

/// Notes a line, unless there is one of the same points.
fn take(lines: &mut Vec<CurveLine>, direction: Direction, points: Vec<(f64, f64)>) {
    if lines.iter().all(|line| line.points != points) {
        lines.push(CurveLine { direction, points });
    }
}

/// The measured curves; one without regard to the direction once.
fn lines(known: &MeasuredTerm) -> Vec<CurveLine> {
    let mut lines: Vec<CurveLine> = Vec::new();
    for direction in Direction::BOTH {
        if let Some(curve) = known.measured.curve(direction) {
            take(&mut lines, direction, sampled(curve, None));
        }
    }
    lines
}

/// A curve over its measured range, with what a control adds.
fn sampled(curve: &ErrorCurve, added: Option<&Response>) -> Vec<(f64, f64)> {
    let (from, to) = curve.measured_range();
    let whole = (to - from).mm();
    let even = |part| from.mm() + whole * f64::from(part) / f64::from(SAMPLES);
    let mut places: Vec<f64> = (0..=SAMPLES).map(even).collect();
    let breaks = added.map(|response| response.breaks(from, to)).into_iter().flatten();
    let beside = breaks.flat_map(|mm| [mm - BESIDE_MM, mm + BESIDE_MM]);
    places.extend(beside.filter(|mm| (from.mm()..=to.mm()).contains(mm)));
    places.sort_by(f64::total_cmp);
    let at = |mm: f64| {
        let at = Millimetres::new(mm);
        let own = curve.at(at);
        (mm, added.map_or(own.um(), |response| (own + response.correction(at)).um()))
    };
    places.into_iter().map(at).collect()
}

fn knots(curve: &ErrorCurve) -> Vec<(f64, f64)> {
    curve.knots().iter().map(|at| (at.mm(), curve.at(*at).um())).collect()
}

/// ±2 u of the values of its direction about a line, straight between the measured positions; none where no
/// u is stated.
fn band(ink: Ink, known: &MeasuredTerm, line: &CurveLine) -> Option<Mark> {
    let is_own = |way: Option<Direction>| way.is_none_or(|way| way == line.direction);
    let own = known.uncertainty.iter().filter(|point| is_own(point.direction));
    let mut u: Vec<(f64, f64)> = own.map(|point| (point.at.mm(), K * point.u_um)).collect();
    u.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let width = |mm: f64| {
        let ((a, low), (b, high)) = match u.iter().position(|(at, _)| *at >= mm) {
            Some(0) => return Some(u[0].1),
            Some(index) => (u[index - 1], u[index]),
            None => return u.last().map(|(_, um)| *um),
        };
        Some(low + (high - low) * (mm - a) / (b - a))
    };
    let places = line.points.iter().map(|(mm, um)| {
        let u = width(*mm)?;
        Some((*mm, um - u, um + u))
    });
    let places: Vec<(f64, f64, f64)> = places.collect::<Option<_>>()?;
    places.iter().any(|(_, low, high)| low < high).then_some(Mark::Band(ink, places))
}

/// A panel for each set of runs, all at one height: the mean deviation at each target moving + and
/// moving − (x̄↑, x̄↓ of ISO 230-2), µm against mm, with bands of k·s, k = 2.
pub fn targets(
    locale: Locale<'_>,
    heading: &str,
    across: &str,
    of: &[(String, &Figures)],
) -> Picture {
    let drawn = of.iter().map(|(name, figures)| {
        let at = |target: Option<&TargetFigures>| target.map_or(0.0, |t| t.target_mm);
        let (from, to) = (at(figures.targets.first()), at(figures.targets.last()));
        (name.clone(), Scale::new(across, from, to).shown_in(locale.mm()), marks_of(figures))
    });
    Picture {
        title: heading.to_string(),
        description: locale.words("targets_alt"),
        columns: if of.len() > 1 { 2 } else { 1 },
        panels: at_one_height(locale, drawn).0,
        note: locale.words("targets_note"),
    }
}

fn marks_of(figures: &Figures) -> Vec<Mark> {
    let measured = [(Ink::Up, true), (Ink::Down, false)].into_iter().filter_map(|(ink, is_up)| {
        let of = |of: &ByDirection| if is_up { of.up_um } else { of.down_um };
        let targets = figures.targets.iter();
        let known = targets
            .filter_map(|t| Some((t.target_mm, of(&t.mean)?, of(&t.s).map(|s| iso_230_2::K * s))));
        Mark::measured(ink, known)
    });
    let (bands, lines): (Vec<_>, Vec<_>) = measured.unzip();
    bands.into_iter().flatten().chain(lines.into_iter().flatten()).collect()
}
