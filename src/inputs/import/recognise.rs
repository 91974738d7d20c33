//! What a file is, and what can be understood of it that nobody stated: its columns, and the axis that it names.
//! It is shown, and taken with `--yes`; sign, unit, material and first target are never among it.

use crate::inputs::error_table::{Component, Kind};
use crate::inputs::import::intake::Intake;
use crate::inputs::import::mapping::{Mapping, column_of, unit_of_name};
use crate::inputs::import::parameters::is_isg_header;
use crate::inputs::import::stated::{Format, Stated, Travel};
use crate::inputs::import::{pos, rtl};
use crate::inputs::kind::head;
use crate::inputs::refusals;
use crate::text::{Line, Problem, Source, lines};

/// Within so many lines the columns are named.
const MOST_LINES: usize = 100;
/// A line of more cells names no columns.
const MOST_COLUMNS: usize = 1000;

/// The format of a file, and what was stated with what is understood beside it.
pub(super) fn recognised(
    source: &Source,
    from: Option<Format>,
    stated: &Stated,
) -> Result<(Format, Stated), Problem> {
    let mut whole = stated.clone();
    let known = if stated.columns.is_some() { Some(Format::Columns) } else { format_of(source) };
    let mut format = from.or(known);
    let is_open = stated.columns.is_none() && format.is_none_or(|own| own == Format::Columns);
    let understood = || lines(source).take(MOST_LINES).find_map(|line| columns(&line));
    if let Some((columns, mapping)) = is_open.then(understood).flatten() {
        format = Some(Format::Columns);
        whole.columns = Some(columns);
        whole.travel = stated.travel.or((!mapping.has_directions()).then_some(Travel::Both));
    }
    let Some(format) = format else {
        let first = 0..head(&source.text, "//").len().min(source.text.len());
        return Err(refusals::not_recognised(&source.name).at(source.place(&first)));
    };
    // In a `.pos` the name of the axis is often left as it was.
    let moved = match format {
        Format::Rtl => stated.axis.or_else(|| rtl::axis(&Intake::of(source, stated, format))),
        Format::Pos => stated.axis,
        _ => None,
    };
    let positioning = moved.map(|along| Component { kind: Kind::Deviation(along), along });
    whole.term = stated.term.or(positioning);
    Ok((format, whole))
}

/// The format, by what stands in the file, else by the ending of its name.
fn format_of(source: &Source) -> Option<Format> {
    let first = head(&source.text, "//");
    let has_key = |key: &str| {
        let mut lines = source.text.lines().map(str::trim);
        lines.any(|line| line.starts_with(key) && line.contains(':'))
    };
    let name = source.name.to_ascii_lowercase();
    let signs = [
        (Format::Rtl, first.eq_ignore_ascii_case("HEADER::")),
        (Format::Ren, has_key("Compensation start") || has_key("Compensation type")),
        (Format::Etalon, first.starts_with('[')),
        (Format::Isg, is_isg_header(first)),
        (Format::Pos, pos::is_first_line(first) || name.ends_with(".pos")),
        (Format::Rtl, name.ends_with(".rtl")),
        (Format::Ren, name.ends_with(".ren")),
    ];
    signs.into_iter().find(|(_, is)| *is).map(|(format, _)| format)
}

/// Words of columns as people write them, and ours.
const WORDS: [(&str, &str); 17] = [
    ("axis", "axis"),
    ("target", "target"),
    ("targets", "target"),
    ("nominal", "target"),
    ("position", "position"),
    ("pos", "position"),
    ("actual", "actual"),
    ("deviation", "deviation"),
    ("dev", "deviation"),
    ("delta", "deviation"),
    ("error", "deviation"),
    ("up", "up"),
    ("dn", "dn"),
    ("down", "dn"),
    ("run", "run"),
    ("direction", "direction"),
    ("dir", "direction"),
];

/// The mapping of a line that names a place and what was read there, each with its unit.
fn columns(line: &Line<'_>) -> Option<(String, Mapping)> {
    let cells = line.cells();
    let is_word =
        |wanted| cells.iter().any(|c| word_of(c).is_some_and(|(word, ..)| word == wanted));
    let has_targets = is_word("target");
    if !(2..=MOST_COLUMNS).contains(&cells.len()) || !(has_targets || is_word("position")) {
        return None;
    }
    // Without an axis beside it a position is a target, whose machine coordinate a person states.
    let is_target = |name: &str| name == "position_mm" && !is_word("axis");
    let ours = |name: &str| match word_of(name) {
        Some(("position", "", unit)) if has_targets => Some(format!("actual_{}", unit?)),
        _ if column_of(name).is_some() && !is_target(name) => Some(name.to_string()),
        Some(("position", "", unit)) => Some(format!("target_{}", unit?)),
        Some((word @ ("run" | "direction" | "axis"), "", _)) => Some(word.to_string()),
        Some((word, run, unit)) => Some(format!("{word}{run}_{}", unit?)),
        None => None,
    };
    // A word that is known but whose unit is not said is no column to be left out.
    let is_unclear = |name: &str| word_of(name).is_some() && ours(name).is_none();
    let named = cells.iter().filter_map(|name| Some(format!("{name}={}", ours(name)?)));
    let columns = named.collect::<Vec<String>>().join(",");
    let is_clear = !cells.iter().any(|cell| is_unclear(cell));
    let mapping = Mapping::read(&columns).ok().filter(|mapping| is_clear && mapping.is_whole())?;
    Some((columns, mapping))
}

/// The word of a column, the number behind it and its unit.
fn word_of(name: &str) -> Option<(&'static str, &str, Option<&'static str>)> {
    let named = unit_of_name(name).map(|(before, unit)| (before, Some(unit)));
    let (before, unit) = named.unwrap_or((name, None));
    let before = before.trim();
    let letters = before.trim_end_matches(|c: char| c.is_ascii_digit());
    let word = letters.trim().to_lowercase();
    let (_, ours) = WORDS.iter().find(|(known, _)| *known == word)?;
    Some((ours, &before[letters.len()..], unit))
}
