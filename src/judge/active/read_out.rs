//! Files that were read out of the control: what concerns the job's axes, through the readers.

use crate::judge::active::found::{Contrary, Found, NamedBacklash, ReadOutFor, beside_words};

use super::{ActiveControl, Held, Origin, Others, axis_of, backlash_of, problem, stated};
use crate::control::controller::{Dialect, Profile, Role};
use crate::control::table::Tables;
use crate::control::table::generic::GenericRow;
use crate::inputs::job::Job;
use crate::quantity::axis::{Axis, PerAxis};
use crate::read::control_data::{self, Text};
use crate::read::generic;
use crate::text::problem::{Problem, Problems};
use crate::write::plan::axis_names;

/// One backlash parameter for an axis of the machine: the axes of a gantry have to hold the same,
/// and what only some of them hold does not tell the others'.
fn one_backlash(
    held: &NamedBacklash,
    parameter: &str,
    notes: &mut Vec<String>,
    contrary: &mut Vec<Contrary>,
) -> Option<f64> {
    let mut values = held.iter().filter_map(|(_, um)| *um);
    let first = values.next()?;
    if values.any(|um| (um - first).abs() > 0.0) {
        let names: Vec<&str> = held.iter().map(|(name, _)| name.as_str()).collect();
        let words = format!(
            "the axes {} have different backlash parameters",
            names.join(", ")
        );
        let help = format!("bring the {parameter} of a gantry's axes to one value first");
        contrary.push(Contrary::new(words, help));
    }
    let Some((name, _)) = held.iter().find(|(_, um)| um.is_none()) else {
        return Some(first);
    };
    notes.push(format!(
        "no file holds the {parameter} of axis {name}, and that of the other axis of the gantry does not tell it"
    ));
    None
}

/// Sign proofs, rollbacks and checklists of a kit, by their names.
fn stands_apart(profile: &Profile, name: &str) -> bool {
    let apart = |role: Role| role.stands_apart() || role == Role::Checklist;
    let mut own = profile.files.iter().filter(|file| apart(file.role));
    let name = name.rsplit(['/', '\\']).next().unwrap_or(name);
    own.any(|file| file.path.eq_ignore_ascii_case(name))
}

/// Reads files of the control: tables, parameters, archives.
pub fn from_read_out(
    job: &Job,
    profile: &Profile,
    path: &str,
    files: Vec<(String, Vec<u8>)>,
    purpose: ReadOutFor,
) -> Result<ActiveControl, Problems> {
    let names = axis_names(job, profile)?;
    let mut notes = Vec::new();
    let texts = texts(profile, path, &files, purpose, &mut notes)?;
    let found = match &profile.dialect {
        Dialect::Siemens(_) => super::siemens::read(job, &names, &texts, purpose)?,
        Dialect::Fanuc(facts) => super::fanuc::read(job, &names, facts, &texts, purpose)?,
        Dialect::Generic(_) => generic_tables(&names, &texts, purpose)?,
    };
    notes.extend(found.notes);
    let mut contrary = found.contrary;
    let own = job.compensation.control_unit;
    contrary.extend(found.unit.filter(|unit| *unit != own).map(|unit| {
        let words = format!(
            "the control that was read out counts in {}, the job in {}",
            unit.word(),
            own.word()
        );
        Contrary::new(words, "correct `control_unit`")
    }));
    let parameter = profile.dialect.backlash_parameter();
    let mut problems = Problems::none();
    let backlash_um = match purpose {
        ReadOutFor::Judging => PerAxis::default(),
        ReadOutFor::OldTables => {
            let one =
                |axis| one_backlash(&found.backlash[axis], parameter, &mut notes, &mut contrary);
            backlash_of(job, &PerAxis::from_fn(one), &mut problems)
        }
    };
    let mut disagreements = Vec::new();
    for Contrary { words, help } in contrary {
        match purpose {
            ReadOutFor::OldTables => problems.push(problem(job, words, &help)),
            ReadOutFor::Judging => disagreements.push(words),
        }
    }
    let state = stated(job, profile, &backlash_um)?;
    problems.or_ok(ActiveControl {
        tables: found.tables,
        state,
        path: path.to_string(),
        origin: Origin::ReadOut(found.held),
        backlash_um,
        held_backlash: Axis::ALL
            .into_iter()
            .flat_map(|a| found.backlash[a].clone())
            .collect(),
        others: found.others,
        assumptions: found.assumptions,
        notes,
        disagreements,
        beside: found.beside,
        files,
    })
}

/// The files as text, but those of a kit that are never loaded with its tables.
fn texts<'a>(
    profile: &Profile,
    path: &str,
    files: &'a [(String, Vec<u8>)],
    purpose: ReadOutFor,
    notes: &mut Vec<String>,
) -> Result<Vec<Text<'a>>, Problems> {
    let mut problems = Problems::none();
    let mut texts = Vec::new();
    for (name, bytes) in files {
        match (stands_apart(profile, name), purpose) {
            (false, _) => {}
            (true, ReadOutFor::Judging) => {
                notes.push(format!(
                    "`{name}` is a file of a kit that is not loaded with its tables: passed over"
                ));
                continue;
            }
            (true, ReadOutFor::OldTables) => problems.push(
                Problem::new(format!(
                    "`{name}` of `{path}` is a file of a kit that is not loaded with its tables, so it does not tell what was active"
                ))
                .help("name the whole kit with its manifest.json, or files that were read out of the control"),
            ),
        }
        match control_data::texts(name, bytes) {
            Ok(own) => texts.extend(own),
            Err(problem) => problems.push(problem),
        }
    }
    problems.or_ok(texts)
}

fn generic_tables(
    names: &PerAxis<Vec<String>>,
    texts: &[Text<'_>],
    purpose: ReadOutFor,
) -> Result<Found, Problems> {
    let mut problems = Problems::none();
    let mut tables = Vec::new();
    for (name, text) in texts {
        tables.extend(problems.take(generic::read(name, text)));
    }
    let mut table = generic::merge(problems.or_ok(tables)?)?;
    let held = Held::plain(Tables::Generic(table.clone()));
    let (mut notes, mut beside) = (Vec::new(), Vec::new());
    if purpose == ReadOutFor::Judging {
        // Old tables of other axes are refused: the new file would take their place.
        let has = |name: &str| axis_of(names, name).is_some();
        let others: Vec<GenericRow> = table
            .rows
            .extract_if(.., |row| !has(&row.base_axis) || !has(&row.output_axis))
            .collect();
        for row in others.iter().filter(|row| row.index == 0) {
            let (base, output) = (&row.base_axis, &row.output_axis);
            if has(output) {
                beside.push(beside_words(&format!("{} of `{output}`", row.term), base));
            } else {
                notes.push(format!("{} ({output} while {base} moves) belongs to axes that the job does not have: passed over", row.term));
            }
        }
    }
    Ok(Found {
        held,
        tables: Tables::Generic(table),
        backlash: PerAxis::default(),
        others: Others::default(),
        assumptions: Vec::new(),
        notes,
        unit: None,
        contrary: Vec::new(),
        beside,
    })
}
