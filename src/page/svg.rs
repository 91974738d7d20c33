//! Pictures as SVG: the only place that knows lengths on paper.

use super::locale::{Locale, Ticks};
use super::picture::{Ink, Mark, Panel, Picture, Scale};
use crate::quantity::{Figure, smaller};
use crate::text::escaped;
use std::fmt::Write;

/// Width of the plot of a panel when three stand in a row, in points of 1/96 inch.
const ROW: f64 = 840.0;
const LEFT: f64 = 46.0;
const RIGHT: f64 = 10.0;
const TITLE: f64 = 20.0;
const FOOT: f64 = 34.0;
const HEAD: f64 = 50.0;
const NOTE: f64 = 20.0;
/// Mean width of a letter, as part of its size (Helvetica, Arial).
const LETTER: f64 = 0.56;
const SMALL: f64 = 10.0;
/// Letters of a title to small ones.
const LARGER: f64 = 1.2;
/// From here on a letter is as wide as its size (Chinese, Japanese, Korean).
const WIDE: char = '\u{2e80}';

/// Colours that the colour-blind tell apart (Okabe and Ito), and dashes for print in grey.
pub(super) fn style() -> String {
    include_str!("../../templates/picture.css").lines().collect()
}

impl Picture {
    /// The picture as a file of its own: SVG 1.1, text as text.
    pub fn svg(&self, locale: Locale<'_>) -> String {
        let names = " xmlns=\"http://www.w3.org/2000/svg\"";
        drawn(self, locale, names, &format!("<style>{}</style>\n", style()))
    }
}

/// Part of a page that has the style once.
pub(super) fn inline(picture: &Picture, locale: Locale<'_>) -> String {
    drawn(picture, locale, "", "")
}

fn drawn(picture: &Picture, locale: Locale<'_>, names: &str, style: &str) -> String {
    let columns = picture.columns.max(1);
    let of_panel = [220.0, 230.0, 176.0][columns.min(3) - 1];
    let rows = picture.panels.len().div_ceil(columns) as f64;
    let (w, h) = (ROW, HEAD + rows * of_panel + NOTE);
    let [title, description] = [&picture.title, &picture.description].map(|words| escaped(words));
    let mut out = Drawing(format!(
        "<svg{names} viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" role=\"img\" aria-label=\"{title}\">
<title>{title}</title>
<desc>{description}</desc>
{style}<rect class=\"paper\" width=\"{w}\" height=\"{h}\"/>
"
    ));
    out.text("h", (LEFT - 36.0, 20.0), &picture.title);
    legend(&mut out, locale, &picture.inks());
    for (number, panel) in picture.panels.iter().enumerate() {
        if let Some(panel) = panel {
            draw(&mut out, locale, panel, plot(number, columns, of_panel));
        }
    }
    out.text("", (LEFT - 36.0, h - 7.0), &picture.note);
    out.put(format_args!("</svg>"));
    out.0
}

/// The plot of a panel of this height.
fn plot(number: usize, columns: usize, height: f64) -> Plot {
    let (column, row) = ((number % columns) as f64, (number / columns) as f64);
    let width = ROW / columns as f64;
    Plot {
        left: column * width + LEFT,
        top: HEAD + row * height + TITLE,
        width: width - LEFT - RIGHT,
        height: height - TITLE - FOOT,
    }
}

/// About the width of small words.
fn width(words: &str) -> f64 {
    let wide = words.chars().filter(|letter| *letter >= WIDE).count();
    let narrow = words.chars().count() - wide;
    (wide as f64 + narrow as f64 * LETTER) * SMALL
}

/// Where a panel's marks go.
#[derive(Clone, Copy)]
struct Plot {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
}

/// Numbers of a panel to places on the paper.
struct Map<'a> {
    locale: Locale<'a>,
    plot: Plot,
    across: &'a Scale,
    up: &'a Scale,
}

impl Map<'_> {
    fn x(&self, number: f64) -> f64 {
        self.plot.left + self.plot.width * part(self.across, number)
    }

    fn y(&self, number: f64) -> f64 {
        self.plot.top + self.plot.height * (1.0 - part(self.up, number))
    }

    fn at(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.x(x), self.y(y))
    }

    fn path(&self, points: impl Iterator<Item = (f64, f64)>) -> String {
        path(points.map(|at| self.at(at)))
    }

    /// Round numbers of the shown unit: where they lie, and what they say.
    fn ticks(&self, scale: &Scale, most: usize) -> Vec<(f64, String)> {
        let times = scale.shown_times;
        let ticks = Ticks::between(scale.from * times, scale.to * times, most);
        let label = |at: &f64| (at / times, self.locale.decimal(&ticks.label(*at)));
        ticks.at.iter().map(label).collect()
    }

    fn bottom(&self) -> f64 {
        self.plot.top + self.plot.height
    }
}

fn part(scale: &Scale, number: f64) -> f64 {
    let span = scale.to - scale.from;
    if span > 0.0 { (number - scale.from) / span } else { 0.5 }
}

fn draw(out: &mut Drawing, locale: Locale<'_>, panel: &Panel, place: Plot) {
    let plot = if panel.is_view { even(panel, place) } else { place };
    let map = Map { locale, plot, across: &panel.across, up: &panel.up };
    // A long title stays inside the picture.
    let most = place.left + place.width + RIGHT - LARGER * width(&panel.title);
    out.text("t", (smaller(plot.left, most), plot.top - 6.0), &panel.title);
    if !panel.is_view {
        axes(out, &map);
    }
    for mark in &panel.marks {
        draw_mark(out, &map, mark);
    }
    if !panel.is_view {
        out.rect("frame", [plot.left, plot.top, plot.width, plot.height]);
    }
}

/// The same number of points for a unit both ways, in the middle of the place.
fn even(panel: &Panel, plot: Plot) -> Plot {
    let (wide, high) = (panel.across.to - panel.across.from, panel.up.to - panel.up.from);
    let (whole, foot) = (plot.width + LEFT - 10.0, plot.height + FOOT - 10.0);
    let unit = (whole / wide).min(foot / high);
    Plot {
        left: plot.left - LEFT + 10.0 + (whole - unit * wide) / 2.0,
        top: plot.top,
        width: unit * wide,
        height: unit * high,
    }
}

fn axes(out: &mut Drawing, map: &Map<'_>) {
    let (plot, bottom) = (map.plot, map.bottom());
    for (at, label) in map.ticks(map.up, 5) {
        let y = map.y(at);
        let class = if at.abs() > 0.0 { "grid" } else { "zero" };
        out.path(class, &path([(plot.left, y), (plot.left + plot.width, y)]));
        out.text("e", (plot.left - 4.0, y + 3.5), &label);
    }
    for (at, label) in labels(map) {
        let x = map.x(at);
        out.path("zero", &path([(x, bottom), (x, bottom + 3.0)]));
        // A long label at the end of an axis stays inside the picture.
        let most = plot.left + plot.width + RIGHT - width(&label) / 2.0;
        out.text("m", (smaller(x, most), bottom + 14.5), &label);
    }
    out.text("m", (plot.left + plot.width / 2.0, bottom + 27.5), &map.across.label);
    let [x, y] = [plot.left - 34.0, plot.top + plot.height / 2.0].map(short);
    let label = escaped(&map.up.label);
    out.put(format_args!(
        "<text class=\"m\" transform=\"translate({x},{y}) rotate(-90)\">{label}</text>"
    ));
}

/// Where a label stands at the lower edge, and what it says.
fn labels(map: &Map<'_>) -> Vec<(f64, String)> {
    if !map.across.names.is_empty() {
        let names = map.across.names.iter().enumerate();
        return names.map(|(n, name)| (n as f64 + 0.5, name.clone())).collect();
    }
    map.ticks(map.across, most_labels(map))
}

/// As many labels as stand beside each other without touching.
fn most_labels(map: &Map<'_>) -> usize {
    let ends = [map.across.from, map.across.to].map(|end| Figure(end * map.across.shown_times));
    let longest = ends.iter().map(|end| format!("{end:.0}").len() + 2).max();
    let room = map.plot.width / ((longest.unwrap_or(1) + 1) as f64 * SMALL * LETTER);
    (2..=9).rev().find(|most| *most as f64 <= room).unwrap_or(2)
}

fn draw_mark(out: &mut Drawing, map: &Map<'_>, mark: &Mark) {
    let ink = mark.ink().map_or("", Ink::word);
    let class = |kind: &str| format!("{ink} {kind}");
    match mark {
        Mark::Line(_, points) => out.path(&class("line"), &map.path(points.iter().copied())),
        Mark::Dots(_, points) => {
            points.iter().for_each(|at| out.dot(&class("dot"), map.at(*at)));
        }
        Mark::Band(_, places) => {
            let upper = places.iter().map(|(x, _, high)| (*x, *high));
            let lower = places.iter().rev().map(|(x, low, _)| (*x, *low));
            out.path(&class("band"), &(map.path(upper.chain(lower)) + "Z"));
        }
        Mark::Bars(_, bars) => {
            for (from, to, height) in bars {
                let (left, top) = map.at((*from, height.max(0.0)));
                let (right, bottom) = map.at((*to, height.min(0.0)));
                out.rect(&class("bar"), [left, top, right - left, bottom - top]);
            }
        }
        Mark::Arrows(_, arrows) => {
            for [(x, y), (dx, dy)] in arrows {
                let arrow = arrow(map.at((*x, *y)), map.at((x + dx, y + dy)));
                out.path(&class("arrow"), &arrow);
            }
        }
        Mark::Edge(points) => out.path("edge", &map.path(points.iter().copied())),
        Mark::Words(at, words) => out.text("m", map.at(*at), words),
        Mark::Places(places) => {
            for at in places {
                let (x, bottom) = (map.x(*at), map.bottom());
                out.path("place", &path([(x, bottom), (x, bottom - 5.0)]));
            }
        }
    }
}

fn legend(out: &mut Drawing, locale: Locale<'_>, inks: &[Ink]) {
    let mut left = LEFT - 36.0;
    for ink in inks.iter().copied() {
        let word = ink.word();
        out.path(&format!("{word} line"), &path([(left, 36.0), (left + 26.0, 36.0)]));
        if ink == Ink::AsLeft {
            out.dot(&format!("{word} dot"), (left + 13.0, 36.0));
        }
        let words = locale.words(&format!("legend_{word}"));
        out.text("", (left + 31.0, 39.5), &words);
        left += 31.0 + 24.0 + width(&words);
    }
}

/// The text of a drawing.
struct Drawing(String);

impl Drawing {
    fn put(&mut self, what: std::fmt::Arguments<'_>) {
        // Writing to a text never fails.
        let _ = writeln!(self.0, "{what}");
    }

    fn text(&mut self, class: &str, (x, y): (f64, f64), words: &str) {
        if !words.is_empty() {
            let class = match class {
                "" => String::new(),
                class => format!(" class=\"{class}\""),
            };
            let (x, y) = (short(x), short(y));
            self.put(format_args!("<text{class} x=\"{x}\" y=\"{y}\">{}</text>", escaped(words)));
        }
    }

    fn rect(&mut self, class: &str, place: [f64; 4]) {
        let [x, y, width, height] = place.map(short);
        self.put(format_args!(
            "<rect class=\"{class}\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"/>"
        ));
    }

    fn path(&mut self, class: &str, d: &str) {
        self.put(format_args!("<path class=\"{class}\" d=\"{d}\"/>"));
    }

    fn dot(&mut self, class: &str, (x, y): (f64, f64)) {
        let (x, y) = (short(x), short(y));
        self.put(format_args!("<circle class=\"{class}\" cx=\"{x}\" cy=\"{y}\" r=\"1.9\"/>"));
    }
}

/// A stroke with a head of two barbs; a short one has a short head.
fn arrow(from: (f64, f64), to: (f64, f64)) -> String {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = dx.hypot(dy);
    let barb = (0.35 * length).min(4.0) / length.max(1e-9);
    let (bx, by) = (dx * barb, dy * barb);
    let end = |side: f64| (to.0 - bx - side * 0.5 * by, to.1 - by + side * 0.5 * bx);
    path([from, to]) + &path([end(1.0), to, end(-1.0)])
}

/// `M x,y L x,y …`.
fn path(points: impl IntoIterator<Item = (f64, f64)>) -> String {
    let mut d = String::new();
    for (x, y) in points {
        let pen = if d.is_empty() { 'M' } else { 'L' };
        // Writing to a text never fails.
        let _ = write!(d, "{pen}{},{}", short(x), short(y));
    }
    d
}

/// A place on the paper: a hundredth of a point is finer than any printer.
fn short(number: f64) -> String {
    Figure(number).trimmed(2)
}
