//! The error along a tool path, and at the holes that it drills.

use super::locale::Locale;
use super::picture::{Ink, Mark, Panel, Picture, Scale, at_one_height};
use super::scale::{below, count};
use crate::quantity::{Axis, larger};

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
        while s_mm >= self.stretch_mm * f64::from(u32::try_from(MOST).unwrap_or(u32::MAX)) {
            self.stretch_mm *= 2.0;
            let halved = self.stretches.chunks(2);
            self.stretches = halved.map(|two| two.iter().copied().fold(None, both)).collect();
        }
        #[allow(
            clippy::cast_possible_truncation,
            reason = "the loop above keeps it below MOST; a path begins at 0"
        )]
        let index = (s_mm / self.stretch_mm) as usize;
        if self.stretches.len() <= index {
            self.stretches.resize(index + 1, None);
        }
        let own = error_um.map(|um| (um, um));
        self.stretches[index] = both(self.stretches[index], Some(own));
    }

    /// The extremes in one direction: from where they hold, µm.
    fn band(&self, of: Axis) -> Vec<(f64, f64, f64)> {
        let n = Axis::ALL.iter().position(|axis| *axis == of).unwrap_or(0);
        let mut from = 0.0;
        let places = self.stretches.iter().filter_map(|stretch| {
            let middle = from + self.stretch_mm / 2.0;
            from += self.stretch_mm;
            let (low, high) = (*stretch)?[n];
            Some((middle, low, high))
        });
        places.collect()
    }
}

/// Two stretches as one.
fn both(a: Stretch, b: Stretch) -> Stretch {
    match a.zip(b) {
        Some((a, b)) => Some([0, 1, 2].map(|n| joined(a[n], b[n]))),
        None => a.or(b),
    }
}

fn joined(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0.min(b.0), a.1.max(b.1))
}

/// A hole: its place in the XY plane, mm, and its error there, µm, before and with tables.
pub type HoleErrors = ((f64, f64), Vec<(Ink, (f64, f64))>);

/// A panel for each direction of the error over the length of the path; the worst holes from above.
pub fn path(locale: Locale<'_>, heading: &str, traces: &[Trace], holes: &[HoleErrors]) -> Picture {
    let length = traces.iter().map(|t| t.stretch_mm * count(t.stretches.len())).fold(0.0, larger);
    let drawn = Axis::ALL.map(|of| {
        let bands = traces.iter().map(|trace| (trace.ink, trace.band(of)));
        let marks = bands.flat_map(|(ink, band)| {
            let middle = band.iter().map(|(s, low, high)| (*s, f64::midpoint(*low, *high)));
            [Mark::Line(ink, middle.collect()), Mark::Band(ink, band)]
        });
        let across = Scale::new("along the path / mm", 0.0, length);
        (format!("error in {of}"), across, marks.collect())
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
            let places = holes.iter().map(|(place, _)| *place);
            marks.push(Mark::Dots(ink, places.collect()));
            marks.push(Mark::Arrows(ink, arrows));
        }
    }
    let room = 0.2 * size;
    let unit = below(longest);
    let (left, low) = (x.0 - room, y.0 - room);
    marks.extend(Mark::scale((left, low), unit * mm_per_um, 0.03 * size, format!("{unit} µm")));
    Some(Panel {
        title: "the worst holes from above (X to the right, Y up)".to_string(),
        across: Scale::new("", left, x.1 + room),
        up: Scale::new("", low, y.1 + room),
        marks,
        is_view: true,
    })
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
