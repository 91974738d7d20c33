//! What a delimited text looks like: the mapping of its columns, from their names and numbers. Our own forms say
//! all of it; what is understood of other names is shown, and taken with `--yes`.

use crate::inputs::error_table::known_columns;
use crate::inputs::import::mapping::{content_of, unit_of_name};
use crate::text::delimited::{LengthUnit, Line, lines};
use crate::text::document::Source;

/// How the columns of a text are understood.
pub(super) struct Understood {
    /// As `--columns` would state it.
    pub(super) columns: String,
    /// The line that names them.
    pub(super) line: usize,
    /// A form of ours, in which nothing is open.
    pub(super) is_ours: bool,
    /// An error table (contract §2.1), where a cell may be empty.
    pub(super) is_error_table: bool,
}

// How the names of other programs begin.
const TARGETS: [&str; 7] = ["target", "soll", "nominal", "pos", "axn", "ziel", "distance"];
const DEVIATIONS: [&str; 6] = ["deviation", "dev", "delta", "err", "abw", "diff"];
const RUNS: [&str; 2] = ["run", "lauf"];
const DIRECTIONS: [&str; 2] = ["dir", "richtung"];
// What in the name of a run says which way it went.
const UP: [&str; 4] = ["up", "forw", "hin", "vor"];
const DOWN: [&str; 6] = ["dn", "down", "back", "rev", "rück", "zur"];
/// Deviations are small beside the distance of the targets: at most this part of it.
const SMALL: f64 = 0.1;

impl Understood {
    /// Of a text whose first numbers stand below a line of names; `None` = it is not understood.
    pub(super) fn of(source: &Source) -> Option<Understood> {
        let content = lines(source)
            .filter(|line| !line.text().trim_start().starts_with('#') && !line.is_empty_row());
        let all: Vec<Line<'_>> = content.collect();
        let first = all.iter().position(|line| numbers(line).iter().flatten().count() > 1)?;
        let header = all[first.checked_sub(1)?];
        let cells = header.cells();
        let names: Vec<&str> = cells.iter().map(|cell| &**cell).collect();
        let known = known_columns();
        let is_of_table = |name: &&str| known.iter().any(|(known, _)| known == name);
        let line = header.number();
        if names.iter().all(is_of_table) && names.contains(&"axis") {
            let columns = names.join(",");
            return Some(Understood { columns, line, is_ours: true, is_error_table: true });
        }
        let rows =
            || all[first..].iter().map(|row| numbers(&row.separated_by(header.delimiter(), false)));
        let column = |index: usize, unit: LengthUnit| -> Option<Vec<f64>> {
            rows().map(|row| Some(row.get(index).copied()?? * unit.um())).collect()
        };
        let target = names.iter().position(|name| begins(name, &TARGETS))?;
        let target_unit = length_of(names[target])?;
        let targets_um = column(target, target_unit)?;
        let mut sorted = targets_um.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.dedup();
        let distances = sorted.windows(2).map(|pair| pair[1] - pair[0]);
        let small_um = SMALL * distances.fold(f64::INFINITY, f64::min);
        let mut is_ours = true;
        let mut pairs = Vec::new();
        for (index, name) in names.iter().enumerate() {
            let word = match length_of(name) {
                Some(unit) if index == target => Some(format!("target_{}", unit.word())),
                Some(unit) => run_of(name).and_then(|run| {
                    let um = column(index, unit)?;
                    let mut both = um.iter().zip(&targets_um);
                    let is_actual = both.all(|(um, target)| (um - target).abs() <= small_um);
                    is_ours &= is_actual || is(name, "deviation");
                    let what = if is_actual { "actual" } else { "deviation" };
                    Some(format!("{run}{what}_{}", unit.word()))
                }),
                None if begins(name, &RUNS) => Some("run".to_string()),
                None if begins(name, &DIRECTIONS) => Some("direction".to_string()),
                None => None,
            };
            is_ours &= is(name, "i") || word.as_ref().is_some_and(|word| is_own(name, word));
            let twins = names.iter().filter(|other| other == &name).count();
            let number = format!("#{}", index + 1);
            let name = if twins > 1 || name.contains(['=', ',']) { &number } else { *name };
            pairs.extend(word.map(|word| format!("{name}={word}")));
        }
        let words = || pairs.iter().filter_map(|pair| pair.rsplit_once('=')).map(|(_, word)| word);
        let is_known = words().all(|word| content_of(word).is_some());
        let has_values = words().any(|word| word.contains("actual") || word.contains("deviation"));
        let columns = pairs.join(",");
        let is_error_table = false;
        (is_known && has_values).then_some(Understood { columns, line, is_ours, is_error_table })
    }
}

/// The numbers of a line, where its cells hold such.
fn numbers(line: &Line<'_>) -> Vec<Option<f64>> {
    line.cells().iter().map(|cell| cell.replace(',', ".").parse().ok()).collect()
}

/// The unit of length that a name ends with.
fn length_of(name: &str) -> Option<LengthUnit> {
    unit_of_name(name).and_then(LengthUnit::from_text)
}

fn begins(name: &str, words: &[&str]) -> bool {
    let name = name.to_lowercase();
    words.iter().any(|word| name.starts_with(word))
}

/// Whether a name is this word with a unit, or without.
fn is(name: &str, word: &str) -> bool {
    name.split('_').next() == Some(word)
}

/// Whether a name of ours says as much as the word: `up1_mm` may hold actual positions, `position_mm` does.
fn is_own(name: &str, word: &str) -> bool {
    let name = name.replace("down", "dn");
    let as_positions = [name.replace('_', "_actual_"), name.replace("position", "actual")];
    name == word || as_positions.iter().any(|own| own == word)
}

/// What stands before the quantity in the word of a column of readings: `up1_`, nothing of a single column;
/// `None` = it is no reading.
fn run_of(name: &str) -> Option<String> {
    let lower = name.to_lowercase();
    let digits = lower.trim_start_matches(|c: char| !c.is_ascii_digit());
    let number: String = digits.chars().take_while(char::is_ascii_digit).collect();
    let has = |words: &[&str]| words.iter().any(|word| lower.contains(word));
    match number.parse::<usize>() {
        Err(_) if begins(name, &DEVIATIONS) || is(name, "position") => Some(String::new()),
        Err(_) => None,
        Ok(number) => match (has(&UP), has(&DOWN)) {
            (true, false) => Some(format!("up{number}_")),
            (false, true) => Some(format!("dn{number}_")),
            (false, false) if begins(name, &RUNS) => Some(format!("run{number}_")),
            _ => None,
        },
    }
}
