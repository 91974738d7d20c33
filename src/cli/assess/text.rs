//! The page of `nonius assess` for people: the figures, then contributions, sub-volumes, distribution, grouping.

use super::page::{Active, Basis, Page};
use crate::cli::screen::{More, Screen, headed, list, paragraphs, table};
use crate::cli::show;
use crate::quantity::{Axis, Diagonal, Figure, Millimetres, PerAxis};
use crate::text::joined;
use crate::volume::assessment::{Assessment, Contribution, GridChoice, Histogram};
use crate::volume::definitions::Definitions;
use crate::volume::space::histogram::Estimate;
use crate::volume::volume_model::{Component, ERRORS};

pub(super) fn screen(page: &Page) -> Screen {
    let differences = page.after.as_ref().map_or(&[][..], |after| &after.disagreements);
    let missing: Vec<String> =
        page.missing.iter().map(|m| format!("{}: {}", m.component, m.consequence)).collect();
    let left_out = list("not measured, so left out of every figure:", &missing);
    let verdict = [headline(page), list("job and tables DISAGREE:", differences), heading(page)];
    let doubts = page.doubts().iter().map(ToString::to_string);
    Screen {
        figures: paragraphs(&[
            figures(page),
            worst_pairs(page),
            contributions(page),
            windows(page).unwrap_or_default(),
            histogram(page),
            grouping(page).unwrap_or_default(),
        ]),
        findings: doubts.chain(show::notes(&page.basis.labels)).collect(),
        more: vec![More::new(
            missing.len(),
            ["error not measured", "errors not measured"],
            left_out,
        )],
        ..Screen::of(verdict.join("\n").replace("\n\n", "\n"))
    }
}

/// A column of the machine as it is, and where there are tables one with them.
fn with_tables(page: &Page, as_it_is: &str, with: &str) -> String {
    format!("{as_it_is}{}", if page.after.is_some() { with } else { "" })
}

fn heading(page: &Page) -> String {
    let ends = Axis::ALL.map(|axis| {
        let Some((low, high)) = page.basis.volume_mm[axis] else {
            return format!("{axis} not measured and its travel not stated");
        };
        let bare = if page.volume.is_measured(axis) { "" } else { " (not measured)" };
        format!("{axis} {} … {} mm{bare}", short(low), short(high))
    });
    let chain = page.basis.chain.as_deref().unwrap_or("not stated");
    let mut lines = vec![
        format!("{}, chain {chain}", page.name),
        format!("volume {}; {}", joined(ends), nodes(page)),
    ];
    lines.extend(places(&page.basis));
    lines.join("\n")
}

fn nodes(page: &Page) -> String {
    let n = page.before.grid.0;
    let own = page.volume.own_nodes().counts();
    let more = if page.grid == GridChoice::OwnNodes && n != own {
        ", those of the tables among them"
    } else {
        ""
    };
    format!("{} x {} x {} nodes{more}", n.x, n.y, n.z)
}

/// The stated places that levers depend on.
fn places(basis: &Basis) -> Option<String> {
    let tool = basis
        .tool_offset_mm
        .map(|tool| format!("tool offset {}", place(PerAxis::from_fn(|axis| tool.0[axis].mm()))));
    let some = |what: &str, places: PerAxis<Option<Millimetres>>| {
        let stated = places.iter();
        let stated = stated.filter_map(|(axis, at)| Some(format!("{axis} {}", short((*at)?.mm()))));
        let stated = joined(stated);
        (!stated.is_empty()).then(|| format!("{what} {stated} mm"))
    };
    let all = [
        tool,
        some("offsets", basis.offsets_mm),
        some("angles zero at", basis.angles_zero_mm),
        some("straightness optic at", basis.straightness_optic_mm),
    ];
    let all: Vec<String> = all.into_iter().flatten().collect();
    (!all.is_empty()).then(|| all.join("; "))
}

/// The answer in one sentence.
fn headline(page: &Page) -> String {
    let before = &page.before;
    let claim = if before.definitions.va_exact {
        "no two places of the volume differ by more in their error"
    } else {
        "no two of these nodes differ by more in their error; other places may"
    };
    let mut lines =
        vec![format!("volumetric accuracy {:.3} µm: {claim}", before.definitions.va_um)];
    lines.extend(page.after.as_ref().map(|after| {
        let hedge = match after.figures.definitions.va_exact {
            true => "",
            false => " at these nodes; other places may differ by more",
        };
        let va = after.figures.definitions.va_um;
        let from = &after.from;
        format!("with the tables {va:.3} µm{hedge}: {from}, read back from their bytes; angular errors stay unless a table holds them")
    }));
    let measured = page.errors_measured;
    if measured < ERRORS {
        lines.push(format!(
            "{measured} of the {ERRORS} errors were measured: every figure is without the others"
        ));
    }
    lines.extend(page.basis.active.as_ref().and_then(|Active { tables, va_without_um: um }| {
        let um = (*um)?;
        Some(format!(
            "as measured, with the tables of `{tables}` active; without any tables {um:.3} µm"
        ))
    }));
    lines.push(format!(
        "frame: {}. ELv, the diagonals and, to second order, the length error stay when the axes are aligned differently; the other figures change",
        page.basis.frame_words()
    ));
    lines.join("\n")
}

fn figures(page: &Page) -> String {
    let sides: Vec<&Definitions> = page.sides().map(|(_, of)| &of.definitions).collect();
    let columns: Vec<_> = sides.iter().map(|of| rows(of)).collect();
    let rows = columns[0].iter().enumerate().map(|(row, [name, _, what])| {
        let values = columns.iter().map(|of| of[row][1].as_str());
        format!("{name}\t{}\t{what}", values.collect::<Vec<_>>().join("\t"))
    });
    let heading = with_tables(page, "figure\t>µm", "\t>with tables/µm");
    let mut lines = vec![table(&format!("{heading}\twhat it is"), rows), PAPERS.to_string()];
    let is_open = |d: &&Definitions| {
        !d.length_exact || d.max_from_reference_bound_um > d.max_from_reference_um
    };
    if sides.iter().any(is_open) {
        lines.push(
            "  a … b: the search reached its limit; a was found, no node exceeds b".to_string(),
        );
    }
    lines.join("\n")
}

/// What the numbers of the papers mean, as far as the texts name themselves.
const PAPERS: &str = "  paper 002: Defining and computing machine tool accuracy, University of Huddersfield; 000 and 001: docs/volume.md";

/// Name, value and meaning of every figure.
fn rows(d: &Definitions) -> Vec<[String; 3]> {
    let row = |name: &str, value: String, what: &str| [name.to_string(), value, what.to_string()];
    let range = |axis| {
        let what = format!("max - min of the error in {axis}");
        row(&format!("range {axis}"), measured(d.ranges_um.0[axis]), &what)
    };
    let diagonal = |diagonal| {
        row(&format!("diagonal {diagonal}"), um(d.diagonals_um[diagonal]), "max - min along it")
    };
    let from = format!("largest error seen from {}", place(d.reference_mm.0));
    let from_um = bracket(d.max_from_reference_um, d.max_from_reference_bound_um);
    let length_um = bracket(d.length_um, d.length_bound_um);
    let proposed = "root of the squared maxima of X, Y and Z + the same of the minima (paper 000 §II, whole vector)";
    let existing = "nine maxima and nine minima, each as root of squares (paper 000 §I)";
    let elsv = "ranges of the nine, summed in each direction, then root of squares";
    let elv = "ranges of EXX, EYY, EZZ, root of squares: positioning alone (paper 001)";
    let largest = [
        row("VA", um(d.va_um), "largest difference of two error vectors (paper 002)"),
        row("length error", length_um, "largest error of a distance of two nodes"),
    ];
    let others = [
        row("box", um(d.box_um), "root of the squared ranges"),
        row("largest from", from_um, &from),
        row("proposed", um(d.proposed_um), proposed),
        row("existing", measured(d.existing_um), existing),
        row("ELSv", measured(d.elsv_um), elsv),
        row("ELv", measured(d.elv_um), elv),
    ];
    [&largest[..], &Axis::ALL.map(range), &others, &Diagonal::ALL.map(diagonal)].concat()
}

fn measured(value: Option<f64>) -> String {
    show::figure(value, "not measured")
}

/// A figure, or what it lies between.
fn bracket(found_um: f64, bound_um: f64) -> String {
    match bound_um <= found_um {
        true => um(found_um),
        // Rounded up: what is printed is a bound, too.
        false => format!("{} … {}", um(found_um), um((1000.0 * bound_um).ceil() / 1000.0)),
    }
}

/// Between which places each of the two machines differs most.
fn worst_pairs(page: &Page) -> String {
    let lines = page.sides().map(|(side, of)| {
        let d = &of.definitions;
        let [[p, q], [a, b]] = [d.va_pair_mm, d.length_pair_mm].map(|pair| pair.map(|at| place(at.0)));
        let PerAxis { x, y, z } = d.va_difference_um.0;
        let [x, y, z] = [x, y, z].map(Figure);
        format!("{side}: largest difference between {p} and {q}: {x:+.3}, {y:+.3}, {z:+.3} µm in X, Y, Z; largest error of a length between {a} and {b}")
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// Parts and changes of VA below the last digit that is shown are none, µm.
const SHOWN_UM: f64 = 0.000_5;

fn contributions(page: &Page) -> String {
    let before = &page.before;
    let va = before.definitions.va_um;
    let row = |part: &Contribution| {
        let share = Figure(if va > 0.0 { 100.0 * part.um / va } else { 0.0 });
        let (name, um, without) = (error_name(part.component), um(part.um), um(part.va_without_um));
        let other = page.after.as_ref().map(|after| left(&after.figures, part.component));
        format!("{name}\t{um}\t{share:.2}\t{without}{}", other.unwrap_or_default())
    };
    let acts = |part: &&Contribution| {
        let mut sides = page.sides().filter_map(|(_, of)| Some((of, find(of, part.component)?)));
        sides.any(|(of, part)| acts(of, part))
    };
    let (acting, idle): (Vec<&Contribution>, Vec<&Contribution>) =
        before.contributions.iter().partition(acts);
    let heading = with_tables(
        page,
        "error\t>part of VA/µm\t>%\t>VA without it/µm",
        "\t>part with tables/µm\t>VA without it, with tables/µm",
    );
    let mut lines = vec![
        table(&heading, acting.into_iter().map(row)),
        "  the parts add up to VA; a negative one works against the others".to_string(),
    ];
    lines.extend(without_effect(page, &idle));
    lines.join("\n")
}

fn find(assessment: &Assessment, component: Component) -> Option<&Contribution> {
    let mut parts = assessment.contributions.iter();
    parts.find(|part| part.component == component)
}

/// Whether anything of it shows on the page.
fn acts(of: &Assessment, part: &Contribution) -> bool {
    let change = (part.va_without_um - of.definitions.va_um).abs();
    part.um.abs() >= SHOWN_UM || change >= SHOWN_UM
}

/// A table takes off squareness and straightness as one: what is left of both stands at the latter.
fn left(after: &Assessment, component: Component) -> String {
    match (find(after, component), component) {
        (Some(part), _) => format!("\t{}\t{}", um(part.um), um(part.va_without_um)),
        (None, Component::Squareness(term)) => format!("\tin {term}\t"),
        (None, _) => "\t\t".to_string(),
    }
}

/// Errors that change nothing, and angles of which nobody can say what they change.
fn without_effect(page: &Page, idle: &[&Contribution]) -> Vec<String> {
    let names = |parts: &[&&Contribution]| joined(parts.iter().map(|part| part.component));
    let (open, idle): (Vec<&&Contribution>, Vec<&&Contribution>) =
        idle.iter().partition(|part| page.volume.has_no_lever(part.component));
    let idle =
        (!idle.is_empty()).then(|| format!("  measured, without effect on VA: {}", names(&idle)));
    let open = (!open.is_empty()).then(|| {
        let axes = joined(page.volume.unknown_axes());
        format!(
            "  angles measured and not counted: {}; the travel of {axes}, their lever, is not stated",
            names(&open)
        )
    });
    idle.into_iter().chain(open).collect()
}

/// Its name, and that of ISO 230-1 where it is another.
fn error_name(component: Component) -> String {
    let (name, iso) = (component.to_string(), component.iso_name());
    if name == iso { name } else { format!("{name} ({iso})") }
}

fn windows(page: &Page) -> Option<String> {
    let found = page.before.windows.as_ref()?;
    let line = |(side, of): (&str, &Assessment)| {
        let found = of.windows.as_ref()?;
        let (best, best_at) = (found.min_um, place(found.min_at_mm.0));
        let (worst, worst_at) = (found.max_um, place(found.max_at_mm.0));
        let corner = found.corner_um;
        Some(format!(
            "  {side}: best {best:.3} µm at {best_at}, worst {worst:.3} µm at {worst_at}, corner {corner:.3} µm"
        ))
    };
    let by = |of: [String; 3]| of.join(" x ");
    let (size, grid) = (found.size_mm.0, found.grid.0);
    let head = format!(
        "volumetric accuracy of the {} sub-volumes of {} mm between {} nodes (places: corner with the smallest coordinates)",
        found.count,
        by([size.x, size.y, size.z].map(|mm| short(mm).to_string())),
        by([grid.x, grid.y, grid.z].map(|nodes| nodes.to_string())),
    );
    Some(headed(&head, page.sides().filter_map(line)))
}

fn histogram(page: &Page) -> String {
    let sides: Vec<&Histogram> = page.sides().filter_map(|(_, of)| of.histogram.as_ref()).collect();
    let [found, after @ ..] = &sides[..] else {
        return String::new();
    };
    let columns: Vec<Vec<String>> = sides.iter().map(|of| bins(of)).collect();
    let rows = (0..columns.iter().map(Vec::len).max().unwrap_or(0)).map(|bin| {
        let from = bin as f64 * found.bin_um;
        // Behind the last bin there are none for certain.
        let pairs = columns.iter().map(|bins| bins.get(bin).map_or("0", String::as_str));
        let pairs = pairs.collect::<Vec<_>>().join("\t");
        format!("{} … {}\t{pairs}", short(from), short(from + found.bin_um))
    });
    let heading = with_tables(page, "differences/µm\t>pairs", "\t>with tables");
    let others = after.iter().filter(|after| after.sampled != found.sampled);
    let others = others.map(|after| format!("\n  with the tables {}", how(after)));
    format!("{}\n  {}{}", table(&heading, rows), how(found), others.collect::<String>())
}

/// Pairs of each bin.
fn bins(histogram: &Histogram) -> Vec<String> {
    let errors = histogram.sampled.as_ref().map(|sampled| &sampled.standard_errors);
    let words = |(bin, count): (usize, Option<f64>)| {
        let Some(count) = count else {
            return "–".to_string();
        };
        let unknown = errors.is_some_and(|errors| errors.get(bin).copied().flatten().is_none());
        let at_least = if unknown { "≥ " } else { "" };
        format!("{at_least}{count:.0}")
    };
    histogram.counts.each().into_iter().enumerate().map(words).collect()
}

fn how(histogram: &Histogram) -> String {
    let Some(Estimate { drawn, standard_errors: errors, .. }) = &histogram.sampled else {
        return format!("all {} pairs of nodes were counted", histogram.pairs);
    };
    let largest = errors.iter().flatten().copied().fold(0.0, f64::max);
    let unseen = 3.0 * histogram.pairs as f64 / *drawn as f64;
    format!(
        "estimated from {drawn} of {} pairs; largest standard error of a bin {largest:.0}; – and ≥: no drawn pair fell there, fewer than {unseen:.0} pairs of all (3/n, 95 %) may",
        histogram.pairs
    )
}

fn grouping(page: &Page) -> Option<String> {
    let found = page.before.grouping.as_ref()?;
    let line = |(side, of): (&str, &Assessment)| {
        let found = of.grouping.as_ref()?;
        let longest = match found.um.zip(found.pair_mm.map(|pair| pair.map(|at| place(at.0)))) {
            Some((um, [p, q])) => format!("{um:.3} µm between {p} and {q}"),
            None => "no two vectors are kept".to_string(),
        };
        Some(format!(
            "  {side}: {longest}; exact {:.3} µm (kept {} of {} vectors, groups: {})",
            of.definitions.va_um, found.records, found.vectors, found.groups
        ))
    };
    let head = format!(
        "grouping of paper 002 §4.2, tolerances {} (angle) and {} (length), for comparison only: it may miss the largest difference",
        found.angular_tolerance, found.magnitude_tolerance
    );
    Some(headed(&head, page.sides().filter_map(line)))
}

fn place(place: PerAxis<f64>) -> String {
    format!("({}, {}, {}) mm", short(place.x), short(place.y), short(place.z))
}

/// Without the dust of binary fractions.
pub(super) fn short(mm: f64) -> f64 {
    Millimetres::new(mm).shown()
}

/// A figure with the digits of the page.
fn um(um: f64) -> String {
    show::um(Some(um))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_that_was_not_searched_to_the_end_is_a_bracket() {
        assert_eq!([bracket(1.5, 1.5), bracket(1.5, 2.0001)], ["1.500", "1.500 … 2.001"]);
    }
}
