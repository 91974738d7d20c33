//! The page of `nonius assess` for people.

use super::page::{ERRORS, Page, count, shows, unknown_axes};
use super::parts::{contributions, grouping, histogram, place, short, um, windows};
use crate::cli::screen::{More, Screen, list, paragraphs, table};
use crate::cli::show;
use crate::inputs::job::Levers;
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::diagonal::Diagonal;
use crate::quantity::units::{Figure, Millimetres};
use crate::volume::assessment::GridChoice;
use crate::volume::definitions::Definitions;
use crate::volume::space::boxes::Largest;

pub(super) fn screen(page: &Page) -> Screen {
    let before = &page.before;
    let after = page.after.as_ref().map(|after| &after.assessment);
    let differences = page.after.as_ref().map_or(&[][..], |after| &after.disagreements);
    let missing = page.volume.missing();
    let missing: Vec<String> =
        missing.iter().map(|m| format!("{}: {}", m.component, m.consequence)).collect();
    let left_out = list("not measured, so left out of every figure:", &missing);
    let verdict = [headline(page), list("job and tables DISAGREE:", differences), heading(page)];
    Screen {
        verdict: verdict.join("\n").replace("\n\n", "\n"),
        figures: paragraphs(&[
            figures(page),
            worst_pairs(page),
            contributions(page),
            windows(page),
            histogram(before, after),
            grouping(page),
        ]),
        findings: page
            .basis
            .doubts
            .iter()
            .map(ToString::to_string)
            .chain(show::notes(&page.basis.labels))
            .collect(),
        more: vec![More::new(
            missing.len(),
            ["error not measured", "errors not measured"],
            left_out,
        )],
        ..Screen::default()
    }
}

fn heading(page: &Page) -> String {
    let unknown = unknown_axes(&page.volume);
    let ends = Axis::ALL.map(|axis| {
        let (low, high) = page.volume.range(axis);
        if unknown.contains(&axis) {
            return format!("{axis} not measured and its travel not stated");
        }
        let bare = if page.volume.is_measured(axis) { "" } else { " (not measured)" };
        format!("{axis} {} … {} mm{bare}", short(low), short(high))
    });
    let chain = match page.volume.chain_is_stated {
        true => page.volume.chain.to_string(),
        false => "not stated".to_string(),
    };
    let mut lines = vec![
        format!("{}, chain {chain}", page.name),
        format!("volume {}; {}", ends.join(", "), nodes(page)),
    ];
    lines.extend(places(&page.basis.levers));
    lines.join("\n")
}

fn nodes(page: &Page) -> String {
    let n = page.before.definitions.grid;
    let own = page.volume.own_nodes().counts();
    let more = if page.grid == GridChoice::OwnNodes && n != own {
        ", those of the tables among them"
    } else {
        ""
    };
    format!("{} x {} x {} nodes{more}", n.x, n.y, n.z)
}

/// The stated places that levers depend on.
fn places(levers: &Levers) -> Option<String> {
    let tool = levers.tool.map(|tool| {
        let mm = PerAxis::from_fn(|axis| tool[axis].mm());
        format!("tool offset {}", place(mm))
    });
    let some = |what: &str, places: PerAxis<Option<Millimetres>>| {
        let stated = places.iter();
        let stated: Vec<String> = stated
            .filter_map(|(axis, at)| Some(format!("{axis} {}", short((*at)?.mm()))))
            .collect();
        (!stated.is_empty()).then(|| format!("{what} {} mm", stated.join(", ")))
    };
    let all = [
        tool,
        some("offsets", levers.offsets),
        some("angles zero at", levers.angles_zero),
        some("straightness optic at", levers.straightness_optic),
    ];
    let all: Vec<String> = all.into_iter().flatten().collect();
    (!all.is_empty()).then(|| all.join("; "))
}

/// The answer in one sentence.
fn headline(page: &Page) -> String {
    let before = &page.before;
    let claim = if before.va_exact {
        "no two places of the volume differ by more in their error"
    } else {
        "no two of these nodes differ by more in their error; other places may"
    };
    let mut lines =
        vec![format!("volumetric accuracy {:.3} µm: {claim}", before.definitions.va.um)];
    lines.extend(page.after.as_ref().map(|after| {
        let hedge = match after.assessment.va_exact {
            true => "",
            false => " at these nodes; other places may differ by more",
        };
        let va = after.assessment.definitions.va.um;
        let from = &after.from;
        format!("with the tables {va:.3} µm{hedge}: {from}, read back from their bytes; angular errors stay unless a table holds them")
    }));
    let measured = count(&page.volume);
    if measured < ERRORS {
        lines.push(format!(
            "{measured} of the {ERRORS} errors were measured: every figure is without the others"
        ));
    }
    let alone = page.basis.active.as_ref().zip(page.basis.without_tables_um);
    lines.extend(alone.map(|(path, um)| {
        format!("as measured, with the tables of `{path}` active; without any tables {um:.3} µm")
    }));
    lines.push(format!(
        "frame: {}. ELv, the diagonals and, to second order, the length error stay when the axes are aligned differently; the other figures change",
        page.basis.frame_words()
    ));
    lines.join("\n")
}

fn figures(page: &Page) -> String {
    let before = &page.before.definitions;
    let after = page.after.as_ref().map(|a| &a.assessment.definitions);
    let with = after.map_or("", |_| "\t>with tables/µm");
    let second = after.map(|after| rows(page, after));
    let rows = rows(page, before).into_iter().enumerate();
    let rows = rows.map(|(index, (name, value, what))| {
        let other = second.as_ref().and_then(|rows| rows.get(index));
        let other = other.map_or_else(String::new, |(_, value, _)| format!("\t{value}"));
        format!("{name}\t{value}{other}\t{what}")
    });
    let heading = format!("figure\t>µm{with}\twhat it is");
    let mut lines = vec![table(&heading, rows), PAPERS.to_string()];
    let mut all = [Some(before), after].into_iter().flatten();
    if all.any(|d| !d.length.is_exact() || !d.from_origin.is_exact()) {
        lines.push(
            "  a … b: the search reached its limit; a was found, no node exceeds b".to_string(),
        );
    }
    lines.join("\n")
}

/// What the numbers of the papers mean, as far as the texts name themselves.
const PAPERS: &str = "  paper 002: Defining and computing machine tool accuracy, University of Huddersfield; 000 and 001: docs/volumetric.md";

/// Name, value and meaning of every figure.
fn rows(page: &Page, d: &Definitions) -> Vec<(String, String, String)> {
    let row =
        |(name, value, what): (&str, String, &str)| (name.to_string(), value, what.to_string());
    let range = |axis| {
        let shown = shows(&page.volume, &page.basis.levers, axis);
        let value = measured(shown.then_some(d.ranges_um[axis]));
        let what = format!("max - min of the error in {axis}");
        (format!("range {axis}"), value, what)
    };
    let from = format!("largest error seen from {}", place(d.origin_mm));
    let whole = [
        ("box", um(d.box_um), "root of the squared ranges"),
        ("largest from", bracket(&d.from_origin), from.as_str()),
    ];
    let diagonal = |diagonal| {
        let value = um(d.diagonals_um[diagonal]);
        let what = "max - min along it".to_string();
        (format!("diagonal {diagonal}"), value, what)
    };
    let rows = largest(d).map(row).into_iter();
    let rows = rows.chain(Axis::ALL.map(range)).chain(whole.map(row));
    let rows = rows.chain(of_papers(d).map(row));
    rows.chain(Diagonal::ALL.map(diagonal)).collect()
}

fn measured(value: Option<f64>) -> String {
    value.map_or_else(|| "not measured".to_string(), um)
}

fn largest(d: &Definitions) -> [(&'static str, String, &'static str); 2] {
    let va = "largest difference of two error vectors (paper 002)";
    let distance = "largest error of a distance of two nodes";
    [("VA", um(d.va.um), va), ("length error", bracket(&d.length), distance)]
}

/// A figure, or what it lies between.
fn bracket<const N: usize>(found: &Largest<N>) -> String {
    match found.is_exact() {
        true => um(found.um),
        // Rounded up: what is printed is a bound, too.
        false => format!("{} … {}", um(found.um), um((1000.0 * found.bound_um).ceil() / 1000.0)),
    }
}

/// What the papers define beside VA.
fn of_papers(d: &Definitions) -> [(&'static str, String, &'static str); 4] {
    let nine = &d.by_component;
    let proposed = "root of the squared maxima of X, Y and Z + the same of the minima (paper 000 §II, whole vector)";
    let existing = "nine maxima and nine minima, each as root of squares (paper 000 §I)";
    let elsv = "ranges of the nine, summed in each direction, then root of squares";
    let elv = "ranges of EXX, EYY, EZZ, root of squares: positioning alone (paper 001)";
    [
        ("proposed", um(d.proposed_um), proposed),
        ("existing", measured(nine.existing), existing),
        ("ELSv", measured(nine.elsv), elsv),
        ("ELv", measured(nine.elv), elv),
    ]
}

/// Between which places each of the two machines differs most.
fn worst_pairs(page: &Page) -> String {
    let lines = page.sides().map(|(side, of)| {
        let d = &of.definitions;
        let ([p, q], [a, b]) = (d.va.places_mm.map(place), d.length_mm.map(place));
        let PerAxis { x, y, z } = d.va.difference_um;
        let [x, y, z] = [x, y, z].map(Figure);
        format!("{side}: largest difference between {p} and {q}: {x:+.3}, {y:+.3}, {z:+.3} µm in X, Y, Z; largest error of a length between {a} and {b}")
    });
    lines.collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_that_was_not_searched_to_the_end_is_a_bracket() {
        let found = |bound_um| bracket(&Largest { um: 1.5, bound_um, at: [0; 3] });
        assert_eq!([found(1.5), found(2.0001)], ["1.500", "1.500 … 2.001"]);
    }
}
