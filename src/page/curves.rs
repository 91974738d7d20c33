//! The nine errors as curves: as found, as forecast, as left, at one scale.

use super::locale::Locale;
use super::picture::{Ink, Mark, Panel, Picture, Scale};
use crate::judge::forecast::Machine;
use crate::machine::model::{ErrorModel, MeasuredTerm};
use crate::machine::separation::Separation;
use crate::quantity::axis::{Direction, ErrorTerm};
use crate::quantity::curve::ErrorCurve;
use crate::quantity::units::Millimetres;
use crate::read::emulate::{Emulated, Emulator, Response};
use crate::write::plan::{Plan, axis_pairs};

/// What the nine curves are drawn from; what is not there is not drawn.
#[derive(Clone, Copy)]
pub struct Curves<'a> {
    /// As found.
    pub machine: Machine<'a>,
    /// The tables as the control would add them, emulated from their bytes.
    pub loaded: Option<(&'a Plan, &'a dyn Emulator)>,
    /// As left.
    pub as_left: Option<&'a ErrorModel>,
    /// The largest deviation that is asked for, µm.
    pub limit_um: Option<f64>,
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
pub fn terms(locale: Locale<'_>, heading: &str, curves: &Curves<'_>) -> Emulated<Picture> {
    let mut panels = Vec::new();
    for term in ErrorTerm::ALL {
        panels.push(curves.marks(term)?.map(|marks| (term, marks)));
    }
    let numbers = panels.iter().flatten().flat_map(|(_, marks)| marks);
    let um = locale.around(numbers.flat_map(Mark::heights));
    let panels = panels.into_iter().map(|known| {
        let (term, mut marks) = known?;
        let limits = curves.limit_um.into_iter().flat_map(|limit| [limit, -limit]);
        let within = limits.filter(|at| (um.0..=um.1).contains(at));
        marks.extend(within.map(|at| Mark::Level(Ink::Limit, at)));
        Some(panel(locale, term, marks, um, curves.range(term)))
    });
    let mut panels: Vec<Option<Panel>> = panels.collect();
    // A few errors stand in one row, without the empty places of the others.
    if panels.iter().flatten().count() <= COLUMNS {
        panels.retain(Option::is_some);
    }
    Ok(Picture {
        title: heading.to_string(),
        description: locale.between("curves_alt", um),
        columns: COLUMNS,
        panels,
        note: locale.words(match curves.loaded {
            Some(_) => "curves_note_tables",
            None => "curves_note",
        }),
    })
}

/// The nine errors as the readings of the diagonals give them, zero at the low end of each axis, with
/// bands of U (95 %) where it is known; both directions where they stand apart.
pub fn separated(locale: Locale<'_>, heading: &str, separation: &Separation) -> Picture {
    let marks = ErrorTerm::ALL.map(|term| {
        let positions = separation.volume.positions(term.along);
        let mm: Vec<f64> = positions.iter().map(|at| at.mm()).collect();
        let ways = match separation.errors.minus.is_some() && separation.is_directed(term.along) {
            false => vec![(Ink::AsFound, None)],
            true => vec![(Ink::Up, Some(Direction::Plus)), (Ink::Down, Some(Direction::Minus))],
        };
        let found = ways.into_iter().filter_map(|(ink, way)| {
            let evidence = separation.of_table(term, way)?;
            let um = |n: &usize| evidence.deviation_um[*n];
            let u = |n: &usize| evidence.expanded_um(*n);
            let all: Vec<usize> = (0..evidence.deviation_um.len().min(mm.len())).collect();
            let points: Vec<(f64, f64)> = all.iter().map(|n| (mm[*n], um(n))).collect();
            let band = all.iter().map(|n| Some((mm[*n], um(n) - u(n)?, um(n) + u(n)?)));
            let band: Option<Vec<_>> = band.collect();
            let band = band.map(|places| Mark::Band(ink, places));
            let line = [Mark::Line(ink, points.clone()), Mark::Dots(ink, points)];
            Some(band.into_iter().chain(line))
        });
        let marks: Vec<Mark> = found.flatten().collect();
        (term, mm, marks)
    });
    let um =
        locale.around(marks.iter().flat_map(|(.., marks)| marks.iter().flat_map(Mark::heights)));
    let panels = marks.into_iter().map(|(term, mm, marks)| {
        let ends = (mm.first().copied()?, mm.last().copied()?);
        (!marks.is_empty()).then(|| panel(locale, term, marks, um, ends))
    });
    Picture {
        title: heading.to_string(),
        description: locale.between("separated_alt", um),
        columns: 3,
        panels: panels.collect(),
        note: locale.words("separated_note"),
    }
}

fn panel(
    locale: Locale<'_>,
    term: ErrorTerm,
    marks: Vec<Mark>,
    um: (f64, f64),
    (from, to): (f64, f64),
) -> Panel {
    let across = locale.mm();
    let axis = format!("{} / {}", term.along.letter(), across.sign);
    let kind = match term.is_positioning() {
        true => "positioning",
        false => "straightness",
    };
    let across = Scale::new(&axis, from, to).shown_in(across);
    Panel::chart(format!("{term} {}", locale.words(kind)), across, Scale::of_um(locale, um), marks)
}

impl Curves<'_> {
    fn found(&self, term: ErrorTerm) -> Option<&MeasuredTerm> {
        self.machine.as_measured.terms[term].as_ref()
    }

    fn left(&self, term: ErrorTerm) -> Option<&MeasuredTerm> {
        self.as_left?.terms[term].as_ref()
    }

    /// The places that any of the curves covers, mm.
    fn range(&self, term: ErrorTerm) -> (f64, f64) {
        let measured = self.found(term).into_iter().chain(self.left(term));
        let ranges = measured.flat_map(MeasuredTerm::curves).map(ErrorCurve::measured_range);
        let all = ranges.reduce(|(low, high), (from, to)| {
            let low = if from < low { from } else { low };
            (low, if to > high { to } else { high })
        });
        all.map_or((0.0, 1.0), |(from, to)| (from.mm(), to.mm()))
    }

    /// What is drawn of a term, bands first; `None` where it was never measured.
    fn marks(&self, term: ErrorTerm) -> Emulated<Option<Vec<Mark>>> {
        let (found, left) = (self.found(term), self.left(term));
        let (forecast, places) = self.forecast(term)?;
        let stages = [
            (Ink::AsFound, found, found.map_or_else(Vec::new, lines)),
            (Ink::Forecast, found, forecast),
            (Ink::AsLeft, left, left.map_or_else(Vec::new, lines)),
        ];
        let last = stages.iter().rfind(|(.., lines)| !lines.is_empty());
        let bands = last.into_iter().flat_map(|(ink, known, lines)| {
            let bands = lines.iter().filter_map(|line| band(*ink, (*known)?, line));
            bands.collect::<Vec<Mark>>()
        });
        let mut marks: Vec<Mark> = bands.collect();
        for (ink, _, lines) in stages {
            marks.extend(lines.into_iter().map(|line| Mark::Line(ink, line.points)));
        }
        let dots = left.into_iter().flat_map(MeasuredTerm::curves);
        marks.extend(dots.map(|curve| Mark::Dots(Ink::AsLeft, knots(curve))));
        marks.extend((!places.is_empty()).then_some(Mark::Places(places)));
        Ok((!marks.is_empty()).then_some(marks))
    }

    /// Deviation without compensation + emulated correction in each direction, and the points of the
    /// tables.
    fn forecast(&self, term: ErrorTerm) -> Emulated<(Vec<CurveLine>, Vec<f64>)> {
        let (mut lines, mut places): (Vec<CurveLine>, Vec<f64>) = (Vec::new(), Vec::new());
        let (Some((plan, control)), Some(known)) =
            (self.loaded, self.machine.uncompensated.terms[term].as_ref())
        else {
            return Ok((lines, places));
        };
        for direction in Direction::BOTH {
            let Some(curve) = known.measured.curve(direction) else {
                continue;
            };
            for (base, output) in axis_pairs(&plan.names, term) {
                let response = control.response(base, output, direction)?;
                let points = sampled(curve, Some(&response));
                if !lines.iter().any(|line| line.points == points) {
                    lines.push(CurveLine { direction, points });
                }
                let nodes = response.tables().iter().flat_map(|table| table.nodes());
                places.extend(nodes.map(|(at, _)| at.mm()));
            }
        }
        let (from, to) = self.range(term);
        places.retain(|at| (from..=to).contains(at));
        places.sort_by(f64::total_cmp);
        places.dedup();
        Ok((lines, places))
    }
}

/// A line of a term, moving one way.
struct CurveLine {
    direction: Direction,
    points: Vec<(f64, f64)>,
}

/// The measured curves; one without regard to the direction once.
fn lines(known: &MeasuredTerm) -> Vec<CurveLine> {
    let mut lines: Vec<CurveLine> = Vec::new();
    for direction in Direction::BOTH {
        let points = known.measured.curve(direction).map(|curve| sampled(curve, None));
        if let Some(points) = points.filter(|new| lines.iter().all(|line| line.points != *new)) {
            lines.push(CurveLine { direction, points });
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
    let breaks = added.map(|response| response.breaks(from, to));
    let breaks = breaks.into_iter().flatten();
    let beside = breaks.flat_map(|mm| [mm - BESIDE_MM, mm + BESIDE_MM]);
    places.extend(beside.filter(|mm| (from.mm()..=to.mm()).contains(mm)));
    places.sort_by(f64::total_cmp);
    let at = |mm: f64| {
        let at = Millimetres::new(mm);
        let um = match added {
            None => curve.at(at).um(),
            Some(response) => (curve.at(at) + response.correction(at)).um(),
        };
        (mm, um)
    };
    places.into_iter().map(at).collect()
}

fn knots(curve: &ErrorCurve) -> Vec<(f64, f64)> {
    let knots = curve.knots().iter();
    knots.map(|at| (at.mm(), curve.at(*at).um())).collect()
}

/// ±2 u of the values of its direction about a line, straight between the measured positions; none where no
/// u is stated.
fn band(ink: Ink, known: &MeasuredTerm, line: &CurveLine) -> Option<Mark> {
    let mut u: Vec<(f64, f64)> = Vec::new();
    let is_own = |way: Option<Direction>| way.is_none_or(|way| way == line.direction);
    for point in known.uncertainty.iter().filter(|point| is_own(point.direction)) {
        u.push((point.at.mm(), K * point.u_um));
    }
    u.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let width = |mm: f64| {
        let after = u.iter().position(|(at, _)| *at >= mm);
        let ((a, low), (b, high)) = match after {
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
