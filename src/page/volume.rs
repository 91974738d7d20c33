//! The errors in the volume: vectors in a fixed isometric view, how pairs of places differ, and what
//! each error contributes.

use super::locale::Locale;
use super::picture::{Ink, Mark, Panel, Picture, Scale};
use super::scale::count;
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::units::larger;
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

fn ends(model: &VolumeModel) -> PerAxis<(f64, f64)> {
    PerAxis::from_fn(|axis| model.range(axis))
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

fn view(locale: Locale<'_>, side: &Side<'_>, longest_um: f64) -> Panel {
    let seen = Volume { ends: ends(side.model) };
    let travel = seen.travel();
    let mm_per_um = if longest_um > 0.0 { LONGEST * travel / longest_um } else { 0.0 };
    let arrows = places(side.model).into_iter().map(|place| {
        let error = side.model.error_at(place);
        [projected(place), projected(error.times(mm_per_um))]
    });
    let room = LONGEST * travel / 2.0;
    let (left, low) = (seen.corner([0, 0, 0]).0 - room, seen.corner([1, 0, 0]).1 - room);
    let (right, high) = (seen.corner([1, 1, 1]).0 + room, seen.corner([0, 1, 1]).1 + room);
    let mut marks = seen.marks();
    marks.push(Mark::Arrows(side.ink, arrows.collect()));
    let (um, shown) = locale.below(longest_um);
    marks.extend(Mark::scale((left, low), um * mm_per_um, 0.03 * travel, shown));
    Panel {
        title: format!(
            "{}, {} {} {}",
            side.name,
            locale.words("longest_arrow"),
            locale.deviation(longest_of(side.model), 3),
            locale.um().sign
        ),
        across: Scale::new("", left, right),
        up: Scale::new("", low, high),
        marks,
        is_view: true,
    }
}

/// The box of the measured volume, as it is seen.
struct Volume {
    ends: PerAxis<(f64, f64)>,
}

impl Volume {
    fn travel(&self) -> f64 {
        let lengths = self.ends.iter().map(|(_, (low, high))| high - low);
        lengths.fold(0.0, larger)
    }

    /// 0 = the low end of X, Y, Z, 1 = the high one.
    fn corner(&self, [x, y, z]: [u8; 3]) -> (f64, f64) {
        let end = |(low, high): (f64, f64), n: u8| if n == 0 { low } else { high };
        projected(PerAxis {
            x: end(self.ends.x, x),
            y: end(self.ends.y, y),
            z: end(self.ends.z, z),
        })
    }

    /// Twelve edges, and the names of the axes at their ends.
    fn marks(&self) -> Vec<Mark> {
        let mut marks = Vec::new();
        for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            for edge in [[[0, a, b], [1, a, b]], [[a, 0, b], [a, 1, b]], [[a, b, 0], [a, b, 1]]] {
                marks.push(Mark::Edge(edge.map(|corner| self.corner(corner)).to_vec()));
            }
        }
        let outer = 0.09 * self.travel();
        let names = [
            ("X", [1, 0, 0], (0.0, -outer)),
            ("Y", [1, 1, 0], (outer, -outer / 2.0)),
            ("Z", [0, 0, 1], (-outer, 0.0)),
        ];
        for (name, corner, (dx, dy)) in names {
            let (x, y) = self.corner(corner);
            marks.push(Mark::Words((x + dx, y + dy), name.to_string()));
        }
        marks
    }
}

/// Share of all pairs of nodes in each bin, %.
fn distribution(locale: Locale<'_>, sides: &[Side<'_>]) -> Option<Panel> {
    let mut marks = Vec::new();
    let (mut widest, mut highest) = (0.0, 0.0);
    for side in sides {
        let Some(histogram) = &side.assessment.histogram else {
            continue;
        };
        let pairs = histogram.pairs as f64;
        let mut from = 0.0;
        let mut bars = Vec::new();
        for count in histogram.counts.each() {
            let percent = 100.0 * count.unwrap_or(0.0) / pairs;
            bars.push((from, from + histogram.bin_um, percent));
            from += histogram.bin_um;
            highest = larger(highest, percent);
        }
        widest = larger(widest, from);
        marks.push(Mark::Bars(side.ink, bars));
    }
    let across = Scale::new(&locale.words("difference"), 0.0, widest).shown_in(locale.um());
    let up = Scale::new(&locale.words("pairs"), 0.0, 1.05 * highest);
    (!marks.is_empty()).then(|| Panel::chart(locale.words("differences"), across, up, marks))
}

fn contributions(locale: Locale<'_>, sides: &[Side<'_>]) -> Panel {
    let first = sides.first().map(|side| side.assessment.contributions.as_slice());
    let named = first.unwrap_or_default().iter().take(MOST_NAMED);
    let components: Vec<_> = named.map(|part| part.component).collect();
    let mut marks = Vec::new();
    let width = 0.8 / larger(count(sides.len()), 1.0);
    let mut offset = 0.1;
    for side in sides {
        let mut at = offset;
        let mut bars = Vec::new();
        for component in &components {
            let own = side.assessment.contributions.iter();
            let part = own.filter(|part| part.component == *component).map(|part| part.um);
            bars.extend(part.map(|um| (at, at + width, um)));
            at += 1.0;
        }
        marks.push(Mark::Bars(side.ink, bars));
        offset += width;
    }
    let um = locale.around(marks.iter().flat_map(Mark::heights));
    let names: Vec<String> = components.iter().map(|component| component.iso_name()).collect();
    let across = Scale { names, ..Scale::new("", 0.0, count(components.len())) };
    Panel::chart(locale.words("contributions"), across, Scale::of_um(locale, um), marks)
}

/// Contributions that are drawn; the command lists all.
const MOST_NAMED: usize = 10;
