//! The errors in the volume: vectors in a fixed isometric view, how pairs of places differ, and what
//! each error contributes.

use crate::page::locale::{Locale, below};
use crate::page::picture::{Ink, Mark, Panel, Picture, Scale, at_one_height};
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
    let views = sides.iter().map(|side| view(locale, side, longest));
    let panels = views.chain(distribution(locale, sides)).chain([contributions(locale, sides)]);
    Picture {
        title: heading.to_string(),
        description: locale.words("volume_alt"),
        columns: 2,
        panels: panels.map(Some).collect(),
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
    let drawn = |place| projected(side.model.error_at(place).times(mm_per_um));
    let arrows = places(side.model).into_iter().map(|place| [projected(place), drawn(place)]);
    let room = LONGEST * travel / 2.0;
    let (left, low) = (corner([0, 0, 0]).0 - room, corner([1, 0, 0]).1 - room);
    let (right, high) = (corner([1, 1, 1]).0 + room, corner([0, 1, 1]).1 + room);
    let mut marks = edges(corner, 0.09 * travel);
    marks.push(Mark::Arrows(side.ink, arrows.collect()));
    let (um, shown) = locale.below(longest_um);
    marks.extend(Mark::scale((left, low), um * mm_per_um, 0.03 * travel, shown));
    let longest = locale.deviation(longest_of(side.model), 3);
    let (words, unit) = (locale.words("longest_arrow"), locale.um().sign);
    let title = format!("{}, {words} {longest} {unit}", side.name);
    Panel::view(title, [(left, right), (low, high)], marks)
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
    let width = 0.8 / larger(sides.len() as f64, 1.0);
    let mut offset = 0.1;
    let mut marks = Vec::new();
    for side in sides {
        let bars = components.iter().enumerate().filter_map(|(n, component)| {
            let mut own = side.assessment.contributions.iter();
            let part = own.find(|part| part.component == *component)?;
            Some((offset + n as f64, offset + n as f64 + width, part.um))
        });
        marks.push(Mark::Bars(side.ink, bars.collect()));
        offset += width;
    }
    let um = locale.around(marks.iter().flat_map(Mark::heights));
    let names: Vec<String> = components.iter().map(|component| component.iso_name()).collect();
    let across = Scale { names, ..Scale::new("", 0.0, components.len() as f64) };
    Panel::chart(locale.words("contributions"), across, Scale::of_um(locale, um), marks)
}

/// Contributions that are drawn; the command lists all.
const MOST_NAMED: usize = 10;

// The error along a tool path, and at the holes that it drills.

/// Stretches of a path that are told apart on paper.
const MOST: usize = 1024;

/// Smallest and largest error in X, Y, Z on one stretch, µm; `None` = no sample fell on it.
type Stretch = Option<[(f64, f64); 3]>;

/// What is drawn of a path of any length: extremes over stretches that grow with it.
#[derive(Clone, Debug)]
pub struct Trace {
    ink: Ink,
    stretch_mm: f64,
    stretches: Vec<Stretch>,
}

impl Trace {
    /// Nothing yet.
    pub fn new(ink: Ink) -> Trace {
        Trace { ink, stretch_mm: 0.01, stretches: Vec::new() }
    }

    /// One sample: how far along the path, mm, and its error, µm.
    pub fn take(&mut self, s_mm: f64, error_um: [f64; 3]) {
        while s_mm >= self.stretch_mm * MOST as f64 {
            self.stretch_mm *= 2.0;
            let halved = self.stretches.chunks(2);
            self.stretches = halved.map(|two| two.iter().copied().fold(None, both)).collect();
        }
        #[allow(clippy::cast_possible_truncation, reason = "below MOST; a path begins at 0")]
        let index = (s_mm / self.stretch_mm) as usize;
        if self.stretches.len() <= index {
            self.stretches.resize(index + 1, None);
        }
        let own = error_um.map(|um| (um, um));
        self.stretches[index] = both(self.stretches[index], Some(own));
    }

    /// The extremes in one direction: from where they hold, µm.
    fn band(&self, of: Axis) -> Vec<(f64, f64, f64)> {
        let mut from = 0.0;
        let places = self.stretches.iter().filter_map(|stretch| {
            let middle = from + self.stretch_mm / 2.0;
            from += self.stretch_mm;
            let (low, high) = (*stretch)?[of as usize];
            Some((middle, low, high))
        });
        places.collect()
    }
}

/// Two stretches as one.
fn both(a: Stretch, b: Stretch) -> Stretch {
    a.zip(b).map(|(a, b)| [0, 1, 2].map(|n| joined(a[n], b[n]))).or(a).or(b)
}

fn joined(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0.min(b.0), a.1.max(b.1))
}

/// A hole: its place in the XY plane, mm, and its error there, µm, before and with tables.
pub type HoleErrors = ((f64, f64), Vec<(Ink, (f64, f64))>);

/// A panel for each direction of the error over the length of the path; the worst holes from above.
pub fn path(locale: Locale<'_>, heading: &str, traces: &[Trace], holes: &[HoleErrors]) -> Picture {
    let length = traces.iter().map(|t| t.stretch_mm * t.stretches.len() as f64).fold(0.0, larger);
    let drawn = Axis::ALL.map(|of| {
        let bands = traces.iter().map(|trace| (trace.ink, trace.band(of)));
        let marks = bands.flat_map(|(ink, band)| {
            let middle = band.iter().map(|(s, low, high)| (*s, f64::midpoint(*low, *high)));
            [Mark::Line(ink, middle.collect()), Mark::Band(ink, band)]
        });
        (format!("error in {of}"), Scale::new("along the path / mm", 0.0, length), marks.collect())
    });
    let mut panels = at_one_height(locale, drawn).0;
    panels.extend(from_above(holes).map(Some));
    Picture {
        title: heading.to_string(),
        description: "The error of the machine along the path, all directions at one scale."
            .to_string(),
        columns: 1,
        panels,
        note: "bands: smallest and largest error on each stretch of the path".to_string(),
    }
}

/// The holes with arrows of their errors in X and Y.
fn from_above(holes: &[HoleErrors]) -> Option<Panel> {
    let places = || holes.iter().map(|(place, _)| *place);
    let mut ends = places().map(|(x, y)| ((x, x), (y, y)));
    let first = ends.next()?;
    let (x, y) = ends.fold(first, |(x, y), own| (joined(x, own.0), joined(y, own.1)));
    let size = larger(larger(x.1 - x.0, y.1 - y.0), 1.0);
    let errors = holes.iter().flat_map(|(_, errors)| errors);
    let longest = errors.map(|(_, (dx, dy))| dx.hypot(*dy)).fold(1e-6, larger);
    let mm_per_um = 0.15 * size / longest;
    let mut marks = Vec::new();
    for ink in Ink::all() {
        let arrows = holes.iter().flat_map(|((x, y), errors)| {
            let own = errors.iter().filter(|(of, _)| *of == ink);
            own.map(|(_, (dx, dy))| [(*x, *y), (dx * mm_per_um, dy * mm_per_um)])
        });
        let arrows: Vec<_> = arrows.collect();
        if !arrows.is_empty() {
            marks.push(Mark::Dots(ink, places().collect()));
            marks.push(Mark::Arrows(ink, arrows));
        }
    }
    let room = 0.2 * size;
    let unit = below(longest);
    let (left, low) = (x.0 - room, y.0 - room);
    marks.extend(Mark::scale((left, low), unit * mm_per_um, 0.03 * size, format!("{unit} µm")));
    let title = "the worst holes from above (X to the right, Y up)".to_string();
    Some(Panel::view(title, [(left, x.1 + room), (low, y.1 + room)], marks))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_path_keeps_its_extremes() {
        let mut trace = Trace::new(Ink::AsFound);
        for n in 0..100_000 {
            let um = if n == 70_001 { 25.0 } else { 0.0 };
            trace.take(f64::from(n), [um, 0.0, -um]);
        }
        let x = trace.band(Axis::X);
        assert!(x.len() <= MOST && x.len() > MOST / 4);
        let (at, ..) = x.iter().find(|(.., high)| *high > 24.0).copied().unwrap_or_default();
        assert!((at - 70_001.0).abs() < 200.0, "{at}");
    }
}
