//! Positioning at targets, the way the standards draw it: mean and ±2 s for each direction.

use super::locale::Locale;
use super::picture::{Ink, Mark, Picture, Scale, at_one_height};
use crate::machine::standards::ByDirection;
use crate::machine::standards::iso_230_2::{Figures, K, TargetFigures};

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
        (name.clone(), Scale::new(across, from, to).shown_in(locale.mm()), marks(figures))
    });
    Picture {
        title: heading.to_string(),
        description: locale.words("targets_alt"),
        columns: if of.len() > 1 { 2 } else { 1 },
        panels: at_one_height(locale, drawn).0,
        note: locale.words("targets_note"),
    }
}

fn marks(figures: &Figures) -> Vec<Mark> {
    let ways = [(Ink::Up, true), (Ink::Down, false)].into_iter();
    let measured = ways.filter_map(|(ink, is_up)| {
        let of = |of: &ByDirection| if is_up { of.up_um } else { of.down_um };
        let targets = figures.targets.iter();
        let known =
            targets.filter_map(|t| Some((t.target_mm, of(&t.mean)?, of(&t.s).map(|s| K * s))));
        Mark::measured(ink, known)
    });
    let (bands, lines): (Vec<_>, Vec<_>) = measured.unzip();
    bands.into_iter().flatten().chain(lines.into_iter().flatten()).collect()
}
