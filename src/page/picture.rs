//! A picture as numbers: panels with marks, in mm and µm whatever unit their axes show.

use super::locale::{Locale, Unit};
use crate::text::{Word, words};

words! {
    /// Who a mark speaks for; each is told by colour, by dash and by its sign in the legend. Its word is the class of a
    /// mark in the drawing; `legend_` and it are the key of its words.
    pub enum Ink {
        /// As found: measured before.
        AsFound = "found",
        /// What is forecast from the bytes of the tables.
        Forecast = "forecast",
        /// As left: measured afterwards.
        AsLeft = "left",
        /// Measured while the axis moved +.
        Up = "up",
        /// Measured while the axis moved -.
        Down = "down",
        /// A limit that is asked for.
        Limit = "limit",
    }
}

impl Ink {
    /// All, in the order of a legend.
    pub(super) fn all() -> impl Iterator<Item = Ink> {
        Ink::WORDS.iter().map(|(_, ink)| *ink)
    }
}

/// Something drawn in a panel; numbers in the units of its axes.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// A line through points.
    Line(Ink, Vec<(f64, f64)>),
    /// Measured values.
    Dots(Ink, Vec<(f64, f64)>),
    /// From the lower to the upper bound at each place.
    Band(Ink, Vec<(f64, f64, f64)>),
    /// A column from one place to another, as high as a number.
    Bars(Ink, Vec<(f64, f64, f64)>),
    /// Places at the lower edge, as the points of a table.
    Places(Vec<f64>),
    /// From a place by so much.
    Arrows(Ink, Vec<[(f64, f64); 2]>),
    /// A thin line that is no measurement, as the edge of a box.
    Edge(Vec<(f64, f64)>),
    /// Words at a place.
    Words((f64, f64), String),
}

impl Mark {
    /// The bar of a scale: a line from a place to the right, with its length in words so far above.
    pub(super) fn scale((x, y): (f64, f64), long: f64, above: f64, words: String) -> [Mark; 2] {
        let edge = Mark::Edge(vec![(x, y), (x + long, y)]);
        [edge, Mark::Words((x + long / 2.0, y + above), words)]
    }

    /// The band of so much about each measured value where that is known of all; the line through them, and they
    /// themselves. `None` = there are none.
    pub(super) fn measured(
        ink: Ink,
        points: impl Iterator<Item = (f64, f64, Option<f64>)>,
    ) -> Option<(Option<Mark>, [Mark; 2])> {
        let points: Vec<(f64, f64, Option<f64>)> = points.collect();
        let band = points.iter().map(|(x, y, u)| u.map(|u| (*x, y - u, y + u)));
        let band: Option<Vec<_>> = band.collect();
        let line: Vec<(f64, f64)> = points.iter().map(|(x, y, _)| (*x, *y)).collect();
        let band = band.map(|band| Mark::Band(ink, band));
        (!line.is_empty()).then(|| (band, [Mark::Line(ink, line.clone()), Mark::Dots(ink, line)]))
    }

    pub(super) fn ink(&self) -> Option<Ink> {
        match self {
            Mark::Line(ink, _) | Mark::Dots(ink, _) | Mark::Arrows(ink, _) => Some(*ink),
            Mark::Band(ink, _) | Mark::Bars(ink, _) => Some(*ink),
            Mark::Places(_) | Mark::Edge(_) | Mark::Words(..) => None,
        }
    }

    /// The heights that have to find room.
    pub(super) fn heights(&self) -> Vec<f64> {
        match self {
            Mark::Line(_, points) | Mark::Dots(_, points) => {
                points.iter().map(|(_, y)| *y).collect()
            }
            Mark::Band(_, places) => places.iter().flat_map(|(_, a, b)| [*a, *b]).collect(),
            Mark::Bars(_, bars) => bars.iter().map(|(_, _, y)| *y).collect(),
            Mark::Places(_) | Mark::Arrows(..) | Mark::Edge(_) | Mark::Words(..) => Vec::new(),
        }
    }
}

/// An axis of a panel.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// With its unit, as in `x / mm`.
    pub label: String,
    /// The smallest number.
    pub from: f64,
    /// The largest number.
    pub to: f64,
    /// Names in place of numbers: the first stands at ½, the next at 1½.
    pub names: Vec<String>,
    /// Numbers are shown times this: how many of the shown unit are one of the picture.
    pub shown_times: f64,
}

impl Scale {
    /// An axis with numbers.
    pub fn new(label: &str, from: f64, to: f64) -> Scale {
        let (label, names) = (label.to_string(), Vec::new());
        Scale { label, from, to, names, shown_times: 1.0 }
    }

    /// An axis of deviations, µm.
    pub(super) fn of_um(locale: Locale<'_>, (from, to): (f64, f64)) -> Scale {
        Scale::new(locale.um().sign, from, to).shown_in(locale.um())
    }

    /// The same axis with its numbers in another unit, which its label names.
    pub(super) fn shown_in(self, unit: Unit) -> Scale {
        Scale { shown_times: unit.each, ..self }
    }
}

/// One diagram.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// What stands above it.
    pub title: String,
    /// To the right.
    pub across: Scale,
    /// Upwards.
    pub up: Scale,
    /// What is drawn, in this order.
    pub marks: Vec<Mark>,
    /// A view of something: no axes, and one scale both ways.
    pub is_view: bool,
}

impl Panel {
    /// A diagram with axes.
    pub(super) fn chart(title: String, across: Scale, up: Scale, marks: Vec<Mark>) -> Panel {
        Panel { title, across, up, marks, is_view: false }
    }

    /// Without axes, both ways at one scale.
    pub(super) fn view(title: String, ends: [(f64, f64); 2], marks: Vec<Mark>) -> Panel {
        let [across, up] = ends.map(|(from, to)| Scale::new("", from, to));
        Panel { title, across, up, marks, is_view: true }
    }
}

/// Panels side by side under one heading and one legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The heading.
    pub title: String,
    /// What it shows, for whoever cannot see it.
    pub description: String,
    /// Panels in a row.
    pub columns: usize,
    /// Row by row; `None` leaves a place free.
    pub panels: Vec<Option<Panel>>,
    /// One sentence below.
    pub note: String,
}

/// A diagram of deviations before its height is known: its title, its axis to the right, what is drawn.
pub(super) type Diagram = (String, Scale, Vec<Mark>);

/// Diagrams at one height, and its ends, µm; one without marks leaves its place free.
pub(super) fn at_one_height(
    locale: Locale<'_>,
    drawn: impl IntoIterator<Item = Diagram>,
) -> (Vec<Option<Panel>>, (f64, f64)) {
    let drawn: Vec<Diagram> = drawn.into_iter().collect();
    let um = locale.around(drawn.iter().flat_map(|(.., marks)| marks).flat_map(Mark::heights));
    let panel = |(title, across, marks): Diagram| match marks.as_slice() {
        [] => None,
        _ => Some(Panel::chart(title, across, Scale::of_um(locale, um), marks)),
    };
    (drawn.into_iter().map(panel).collect(), um)
}

impl Picture {
    /// The inks that are used, in the order of a legend.
    pub(super) fn inks(&self) -> Vec<Ink> {
        let marks = || self.panels.iter().flatten().flat_map(|panel| &panel.marks);
        Ink::all().filter(|ink| marks().any(|mark| mark.ink() == Some(*ink))).collect()
    }
}
