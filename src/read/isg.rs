//! Reader of the ISG kernel's volumetric compensation: the list (`.lis`) and the parameter files that it names.
//!
//! ```text
//!   texts ─┬ with a line `file[0] …` ── list ──→ axes, chain, switches; names of the files
//!          └ those that it names ── csv ──→ curves of the parameters
//! ```
//! Written from the pages of the maker named in docs/isg.md §0; it knows nothing of the program's own templates.

pub mod control;
mod csv;
mod line;
mod list;

use self::control::IsgControl;
use self::list::List;
use crate::control::control_state::ControlState;
use crate::control::controller::IsgFacts;
use crate::control::table::Tables;
use crate::control::table::isg::{Curve, IsgTables, Parameter};
use crate::read::emulate::{Emulated, Emulator};
use crate::read::family::{Family, KitText, ReadBack, own};
use crate::read::findings::ReadFinding;
use crate::text::{Finding, Problem, Problems, shown};

impl Family for IsgFacts {
    fn read_kit(&self, files: &[KitText<'_>]) -> Result<ReadBack, Problems> {
        let texts: Vec<(&str, &str)> = files.iter().map(|file| (file.path, file.text)).collect();
        let (tables, notes) = read(&texts)?;
        Ok(ReadBack { notes, ..Tables::Isg(tables).into() })
    }

    fn control(&self, tables: &Tables, state: &ControlState) -> Emulated<Box<dyn Emulator>> {
        Ok(Box::new(IsgControl::new(own(tables)?, self, state)?))
    }

    fn may_obey(&self, text: &str) -> bool {
        let names: Vec<String> = Parameter::all().map(|p| p.to_string()).collect();
        let mut words = text.split(|c: char| !c.is_ascii_alphanumeric());
        list::is_list(text) || words.any(|word| names.iter().any(|name| name == word))
    }
}

/// Reads a list and the parameter files that it names; names and texts in any order.
///
/// **shape** each parameter once · **unit** mm and rad, as in the files · **limits** refuses what the emulator
/// does not do: rotary axes, axes of the workpiece, several arguments, other interpolations
pub(crate) fn read(texts: &[(&str, &str)]) -> Result<(IsgTables, Vec<Finding>), Problems> {
    let (lists, others): (Vec<_>, Vec<_>) = texts.iter().partition(|(_, text)| list::is_list(text));
    let (list_name, text) = match lists[..] {
        [(name, text)] => (name, text),
        _ => return Err(not_one_list(&lists, &others).into()),
    };
    let list = List::read(list_name, text)?;
    let mut problems = Problems::none();
    let mut curves: Vec<Curve> = Vec::new();
    let mut named: Vec<&str> = Vec::new();
    for path in &list.files {
        let is_it =
            |(name, _): &&(&str, &str)| file_name(name).eq_ignore_ascii_case(file_name(path));
        let Some((name, text)) = others.iter().find(is_it) else {
            problems.push(not_there(list_name, path));
            continue;
        };
        named.push(name);
        for curve in problems.take(csv::curves(name, text)).into_iter().flatten() {
            if let Some(problem) = too_many(name, &curve) {
                problems.push(problem);
            }
            let is_twin = |other: &Curve| other.parameter == curve.parameter;
            match curves.iter().any(is_twin) {
                true => problems.push(twice(name, curve.parameter)),
                false => curves.push(curve),
            }
        }
    }
    curves.sort_by_key(|curve| curve.parameter);
    let unnamed = others.iter().filter(|(name, _)| !named.contains(name));
    let unnamed = unnamed.map(|(name, _)| {
        let file = shown(name);
        ReadFinding::NotListed { file }.into()
    });
    let unnamed = unnamed.collect();
    problems.or_ok((
        IsgTables {
            axes: list.axes,
            chain: list.chain,
            negated: list.negated,
            zeroed: list.zeroed,
            curves,
        },
        unnamed,
    ))
}

/// The last part of a path.
fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

fn names(texts: &[(&str, &str)]) -> String {
    let names = texts.iter().map(|(name, _)| format!("`{}`", shown(name)));
    names.collect::<Vec<_>>().join(", ")
}

fn not_one_list(lists: &[(&str, &str)], others: &[(&str, &str)]) -> Problem {
    let message = match lists {
        [] => format!(
            "no list stands beside {}: parameter files do not say their form, the axes or the chain",
            names(others)
        ),
        _ => format!("several lists, of which one can be read: {}", names(lists)),
    };
    let help = "name one list (`.lis`, the file of `vol_comp[0].file_name`) with the files of its `file[…]`";
    Problem::new(message).help(help)
}

fn not_there(list: &str, path: &str) -> Problem {
    let (list, path) = (shown(list), shown(path));
    Problem::new(format!("`{list}` names `{path}`, which is not there"))
        .help("name the parameter file together with the list")
}

fn twice(file: &str, parameter: Parameter) -> Problem {
    let file = shown(file);
    Problem::new(format!("{parameter} stands in `{file}` and in a file before it"))
        .help("give each parameter once")
}

/// Most points of a parameter: ten times and more what a control takes.
const MOST_POINTS: usize = 20_000;

fn too_many(file: &str, curve: &Curve) -> Option<Problem> {
    let points = curve.points.len();
    let (file, parameter) = (shown(file), curve.parameter);
    let words =
        format!("`{file}`: {parameter} has {points} points, expected at most {MOST_POINTS}");
    (points > MOST_POINTS).then(|| Problem::new(words).help("name the files of the control"))
}

#[cfg(test)]
mod tests;
