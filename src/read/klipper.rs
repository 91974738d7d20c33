//! Reader of Klipper: the sections `[skew_correction NAME]` of a configuration, whole or a part of it.
//!
//! Written from Klipper's source (docs/klipper.md §0); it knows nothing of the program's own templates.

pub mod control;

use self::control::KlipperControl;
use crate::control::control_state::ControlState;
use crate::control::controller::KlipperFacts;
use crate::control::table::Tables;
use crate::control::table::klipper::{FACTORS, KlipperTables, Skew};
use crate::read::emulate::{Emulated, Emulator};
use crate::read::family::{Family, KitText, ReadBack, own};
use crate::read::lexer::{Complaint, MOST_COMPLAINTS, lines, located};
use crate::text::problem::{Problem, Problems, shown};
use std::ops::Range;

impl Family for KlipperFacts {
    fn read_kit(&self, files: &[KitText<'_>]) -> Result<ReadBack, Problems> {
        let texts: Vec<(&str, &str)> = files.iter().map(|file| (file.path, file.text)).collect();
        Ok(Tables::Klipper(read(&texts)?).into())
    }

    fn control(&self, tables: &Tables, state: &ControlState) -> Emulated<Box<dyn Emulator>> {
        Ok(Box::new(KlipperControl::new(own(tables)?, self, state)))
    }

    fn may_obey(&self, text: &str) -> bool {
        text.contains("skew_correction")
    }

    fn is_whole(&self, text: &str) -> bool {
        lines(text).any(|line| text[line].trim() == "[printer]")
    }
}

/// Reads the one profile that texts hold.
///
/// **limits** refuses two profiles: which of them is loaded stands in macros, which are not read
pub(crate) fn read(texts: &[(&str, &str)]) -> Result<KlipperTables, Problems> {
    let mut problems = Problems::none();
    let mut found: Vec<Skew> = Vec::new();
    for (name, text) in texts {
        found.extend(problems.take(profiles(name, text)).into_iter().flatten());
    }
    if found.len() > 1 {
        let names = found.iter().map(|skew| format!("`{}`", shown(&skew.name)));
        let names = names.collect::<Vec<_>>().join(", ");
        problems.push(
            Problem::new(format!("several skew profiles, of which one is loaded: {names}"))
                .help("name a file that holds the one that SKEW_PROFILE loads"),
        );
    }
    let skew = found.pop();
    problems.or_ok(KlipperTables { skew })
}

/// A profile while it is read.
struct Reading {
    name: String,
    factors: [Option<f64>; 3],
    span: Range<usize>,
}

/// The profiles of a text. A line of the part that SAVE_CONFIG writes begins with `#*#`.
fn profiles(file: &str, text: &str) -> Result<Vec<Skew>, Problems> {
    const SAVED: &str = "#*#";
    let (mut read, mut complaints) = (Vec::<Reading>::new(), Vec::new());
    let mut within = false;
    for span in lines(text) {
        let line = text[span.clone()].trim_start();
        let line = line.strip_prefix(SAVED).unwrap_or(line);
        let line = line.split(['#', ';']).next().unwrap_or("").trim();
        let section = line.strip_prefix('[').and_then(|line| line.strip_suffix(']'));
        if let Some(section) = section {
            let name = section.trim().strip_prefix("skew_correction ");
            within = name.is_some();
            read.extend(name.map(|name| Reading {
                name: name.trim().to_string(),
                factors: [None; 3],
                span: span.clone(),
            }));
        } else if let (true, Some(own), false) = (within, read.last_mut(), line.is_empty()) {
            let taken = own.take(line);
            complaints.extend(taken.err().map(|expected| wrong(line, span, expected)));
        }
        if complaints.len() >= MOST_COMPLAINTS {
            break;
        }
    }
    let whole: Vec<Result<Skew, Complaint>> = read.into_iter().map(Reading::whole).collect();
    let mut skews = Vec::new();
    for own in whole {
        match own {
            Ok(skew) => skews.push(skew),
            Err(complaint) => complaints.push(complaint),
        }
    }
    match complaints.is_empty() {
        true => Ok(skews),
        false => Err(located(file, text, complaints)),
    }
}

impl Reading {
    /// Takes `xy_skew = 0.001` or `xy_skew: 0.001`; `Err` = what was expected.
    fn take(&mut self, line: &str) -> Result<(), &'static str> {
        let (key, value) = line.split_once(['=', ':']).ok_or("`xy_skew = …`")?;
        let own = FACTORS.iter().position(|(_, name)| *name == key.trim());
        let own = own.ok_or("xy_skew, xz_skew or yz_skew")?;
        let plain = |c: char| c.is_ascii_digit() || "+-.eE".contains(c);
        let value = value.trim();
        let factor = value.chars().all(plain).then(|| value.parse::<f64>().ok());
        let factor = factor.flatten().filter(|factor| factor.abs() < 1.0);
        let factor = factor.ok_or("a factor below 1, mm in a mm")?;
        match self.factors[own].replace(factor + 0.0) {
            None => Ok(()),
            Some(_) => Err("each factor once"),
        }
    }

    fn whole(self) -> Result<Skew, Complaint> {
        let missing = FACTORS.iter().zip(self.factors);
        let missing = missing.filter(|(_, factor)| factor.is_none());
        let missing: Vec<&str> = missing.map(|((_, name), _)| *name).collect();
        match missing.is_empty() {
            true => Ok(Skew::none(&self.name).with(self.factors.map(Option::unwrap_or_default))),
            false => Err(Complaint::new(
                self.span,
                format!("the profile has no {}: Klipper does not start", missing.join(", ")),
                "state all three factors, 0 where nothing is to be corrected",
            )),
        }
    }
}

fn wrong(line: &str, span: Range<usize>, expected: &str) -> Complaint {
    let message = format!("`{}`, expected {expected}", shown(line));
    Complaint::new(span, message, "a profile holds xy_skew, xz_skew and yz_skew")
}

#[cfg(test)]
mod tests;
