//! The errors in the volume: vectors in a fixed isometric view, how pairs of places differ, and what
//! each error contributes.

use super::locale::Locale;
use super::picture::{Ink, Mark, Panel, Picture, Scale};
use super::scale::count;
use crate::quantity::{Axis, PerAxis, larger};
use crate::volume::assessment::Assessment;
use crate::volume::volume_model::VolumeModel;

/// One state of the machine: as found, or with the tables.
#[derive(Clone)]
pub struct Side<'a> {
    /// Its ink.
    pub ink: Ink,
    /// What stands above it.
    pub name: String,
    /// The errors at any place.
    pub model: &'a VolumeModel,
    /// The figures, with the distribution if it is to be drawn.
    pub assessment: &'a Assessment,
}

/// Places of an axis at which an arrow begins.
const PLACES: u32 = 4;
/// The longest arrow, as part of the largest travel.
const LONGEST: f64 = 0.22;

/// Error vectors (the same scale for all sides), distribution of the differences of all pairs of nodes,
/// contributions to the volumetric accuracy.
pub fn volume(locale: Locale<'_>, heading: &str, sides: &[Side<'_>]) -> Picture {
    let longest = sides.iter().map(|side| longest_of(side.model)).fold(0.0, larger);
    let views = sides.iter().map(|side| Some(view(locale, side, longest)));
    let below = [distribution(locale, sides), Some(contributions(locale, sides))];
    let panels = views.chain(below).filter(Option::is_some);
    Picture {
        title: heading.to_string(),
        description: locale.words("volume_alt"),
        columns: 2,
        panels: panels.collect(),
        note: locale.words("volume_note"),
    }
}

/// X to the right and down, Y to the right and up, Z up.
fn projected(v: PerAxis<f64>) -> (f64, f64) {
    const COS_30: f64 = 0.866_025_403_784_438_6;
    ((v.x + v.y) * COS_30, v.z + (v.y - v.x) / 2.0)
}

/// The places of the arrows, machine coordinates in mm.
fn places(model: &VolumeModel) -> Vec<PerAxis<f64>> {
    let at = |axis: Axis, n: u32| {
        let (low, high) = model.range(axis);
        low + (high - low) * f64::from(n) / f64::from(PLACES - 1)
    };
    let place = |n: u32| {
        let [x, y, z] = [n % PLACES, n / PLACES % PLACES, n / PLACES.pow(2)];
        PerAxis { x: at(Axis::X, x), y: at(Axis::Y, y), z: at(Axis::Z, z) }
    };
    (0..PLACES.pow(3)).map(place).collect()
}

fn longest_of(model: &VolumeModel) -> f64 {
    places(model).into_iter().map(|place| model.error_at(place).length()).fold(0.0, larger)
}

/// An end of each axis: 0 = the low one of X, Y, Z, 1 = the high one.
type Corner = [usize; 3];

fn view(locale: Locale<'_>, side: &Side<'_>, longest_um: f64) -> Panel {
    let ends = Axis::ALL.map(|axis| side.model.range(axis)).map(|(low, high)| [low, high]);
    let travel = ends.map(|[low, high]| high - low).into_iter().fold(0.0, larger);
    let corner =
        |[a, b, c]: Corner| projected(PerAxis { x: ends[0][a], y: ends[1][b], z: ends[2][c] });
    let mm_per_um = if longest_um > 0.0 { LONGEST * travel / longest_um } else { 0.0 };
    let arrows = places(side.model).into_iter().map(|place| {
        let error = side.model.error_at(place);
        [projected(place), projected(error.times(mm_per_um))]
    });
    let room = LONGEST * travel / 2.0;
    let (left, low) = (corner([0, 0, 0]).0 - room, corner([1, 0, 0]).1 - room);
    let (right, high) = (corner([1, 1, 1]).0 + room, corner([0, 1, 1]).1 + room);
    let mut marks = edges(corner, 0.09 * travel);
    marks.push(Mark::Arrows(side.ink, arrows.collect()));
    let (um, shown) = locale.below(longest_um);
    marks.extend(Mark::scale((left, low), um * mm_per_um, 0.03 * travel, shown));
    let longest = locale.deviation(longest_of(side.model), 3);
    let (words, unit) = (locale.words("longest_arrow"), locale.um().sign);
    Panel {
        title: format!("{}, {words} {longest} {unit}", side.name),
        across: Scale::new("", left, right),
        up: Scale::new("", low, high),
        marks,
        is_view: true,
    }
}

/// The twelve edges of the measured volume, and the names of the axes so far from their ends, mm.
fn edges(corner: impl Fn(Corner) -> (f64, f64), outer: f64) -> Vec<Mark> {
    let mut marks = Vec::new();
    for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        for edge in [[[0, a, b], [1, a, b]], [[a, 0, b], [a, 1, b]], [[a, b, 0], [a, b, 1]]] {
            marks.push(Mark::Edge(edge.map(&corner).to_vec()));
        }
    }
    let names = [
        ("X", [1, 0, 0], (0.0, -outer)),
        ("Y", [1, 1, 0], (outer, -outer / 2.0)),
        ("Z", [0, 0, 1], (-outer, 0.0)),
    ];
    marks.extend(names.map(|(name, end, (dx, dy))| {
        let (x, y) = corner(end);
        Mark::Words((x + dx, y + dy), name.to_string())
    }));
    marks
}

/// Share of all pairs of nodes in each bin, %.
fn distribution(locale: Locale<'_>, sides: &[Side<'_>]) -> Option<Panel> {
    let mut marks = Vec::new();
    let (mut widest, mut highest) = (0.0, 0.0);
    for side in sides {
        let Some(histogram) = &side.assessment.histogram else {
            continue;
        };
        let mut from = 0.0;
        let bars = histogram.counts.each().into_iter().map(|count| {
            let percent = 100.0 * count.unwrap_or(0.0) / histogram.pairs as f64;
            highest = larger(highest, percent);
            let start = from;
            from += histogram.bin_um;
            (start, from, percent)
        });
        marks.push(Mark::Bars(side.ink, bars.collect()));
        widest = larger(widest, from);
    }
    let across = Scale::new(&locale.words("difference"), 0.0, widest).shown_in(locale.um());
    let up = Scale::new(&locale.words("pairs"), 0.0, 1.05 * highest);
    (!marks.is_empty()).then(|| Panel::chart(locale.words("differences"), across, up, marks))
}

fn contributions(locale: Locale<'_>, sides: &[Side<'_>]) -> Panel {
    let first = sides.first().map(|side| side.assessment.contributions.as_slice());
    let named = first.unwrap_or_default().iter().take(MOST_NAMED);
    let components: Vec<_> = named.map(|part| part.component).collect();
    let width = 0.8 / larger(count(sides.len()), 1.0);
    let mut offset = 0.1;
    let mut marks = Vec::new();
    for side in sides {
        let bars = components.iter().enumerate().filter_map(|(n, component)| {
            let mut own = side.assessment.contributions.iter();
            let part = own.find(|part| part.component == *component)?;
            Some((offset + count(n), offset + count(n) + width, part.um))
        });
        marks.push(Mark::Bars(side.ink, bars.collect()));
        offset += width;
    }
    let um = locale.around(marks.iter().flat_map(Mark::heights));
    let names: Vec<String> = components.iter().map(|component| component.iso_name()).collect();
    let across = Scale { names, ..Scale::new("", 0.0, count(components.len())) };
    Panel::chart(locale.words("contributions"), across, Scale::of_um(locale, um), marks)
}

/// Contributions that are drawn; the command lists all.
const MOST_NAMED: usize = 10;
