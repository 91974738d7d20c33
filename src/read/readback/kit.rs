//! All files of a kit as one memory of the control.

use crate::control::controller::{Dialect, Profile, Role};
use crate::control::table::Tables;
use crate::read::readback::{fanuc, generic, siemens};
use crate::text::problem::{Problem, Problems, shown};

/// A file of a kit as it lies on the disk.
#[derive(Clone, Copy, Debug)]
pub struct KitFile<'a> {
    /// Its name.
    pub path: &'a str,
    /// What it is for.
    pub role: Role,
    /// Its bytes.
    pub bytes: &'a [u8],
}

/// What a control holds after all files were loaded.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadBack {
    /// Tables, parameters and points.
    pub tables: Tables,
    /// Remarks of the reader.
    pub notes: Vec<String>,
    /// Parameters of tables that no file writes, so that the control keeps older ones (Siemens).
    pub unwritten: Vec<String>,
    /// Machine and setting data of every file, also of files that set none (Siemens).
    pub machine_data: Vec<FileData>,
}

/// The machine and setting data that one file sets.
#[derive(Clone, Debug, PartialEq)]
pub struct FileData {
    /// Name of the file.
    pub path: String,
    /// What it is for.
    pub role: Role,
    /// What it sets.
    pub data: Vec<siemens::MachineDatum>,
}

/// Reads all files of a kit through the reader of the profile's dialect. Checklists and reports are
/// not read, and files that stand apart (`rollback`, `sign-proof`) are not part of the kit's memory.
pub fn read(profile: &Profile, files: &[KitFile<'_>]) -> Result<ReadBack, Problems> {
    read_role(profile, files, |role| !role.stands_apart())
}

/// Reads the files of one role that stands apart as a memory of their own.
pub fn read_apart(
    profile: &Profile,
    files: &[KitFile<'_>],
    role: Role,
) -> Result<ReadBack, Problems> {
    read_role(profile, files, |other| other == role)
}

fn read_role(
    profile: &Profile,
    files: &[KitFile<'_>],
    is_wanted: impl Fn(Role) -> bool,
) -> Result<ReadBack, Problems> {
    let mut problems = Problems::none();
    let mut texts = Vec::new();
    let is_read = |file: &&KitFile<'_>| file.role.is_read_back() && is_wanted(file.role);
    for file in files.iter().filter(is_read) {
        match std::str::from_utf8(file.bytes) {
            Ok(text) => texts.push((file, text)),
            Err(_) => problems.push(Problem::new(format!("`{}` is not text", file.path))),
        }
    }
    if texts.is_empty() && problems.is_empty() {
        problems.push(Problem::new("there is no file to read back"));
    }
    let read = match &profile.dialect {
        Dialect::Siemens(_) => problems.take(read_siemens(&texts)),
        Dialect::Fanuc(facts) => {
            let memories = each(&texts, |path, text| fanuc::read(path, text, facts));
            problems.take(
                memories
                    .and_then(fanuc::merge)
                    .map(|memory| plain(Tables::Fanuc(memory))),
            )
        }
        Dialect::Generic(_) => {
            let tables = each(&texts, generic::read);
            problems.take(
                tables
                    .and_then(generic::merge)
                    .map(|table| plain(Tables::Generic(table))),
            )
        }
    };
    match read {
        Some(read) => problems.or_ok(read),
        None => Err(problems),
    }
}

/// Files that a control may load and that no reader takes, in a sentence: whatever else is read back,
/// nothing shows what the control will hold.
pub(crate) fn unread(profile: &Profile, files: &[KitFile<'_>]) -> Option<String> {
    let is_unread = |name: &str| {
        let mut known = profile.files.iter().filter(|file| file.is_loaded_unread());
        known.any(|file| file.path.eq_ignore_ascii_case(name))
    };
    let names = files.iter().map(|file| file.path);
    let names: Vec<String> = names
        .filter(|name| is_unread(name))
        .map(|name| format!("`{}`", shown(name)))
        .collect();
    let (is, it) = match names.len() {
        0 => return None,
        1 => ("is", "it"),
        _ => ("are", "them"),
    };
    Some(format!(
        "{} {is} not read back (role `report`), so nothing shows what a control holds that loads {it}: give {it} the role `table` in the layout of the dialect, or, if no control loads {it}, state `loaded = false` in the profile",
        names.join(", ")
    ))
}

/// Whether a file may mean something to the control, whole or damaged: `$` variables (Siemens),
/// numbered blocks (Fanuc), the column of positions (generic).
///
/// **limits** it errs on the careful side; a text for people that quotes such a word counts too.
pub(crate) fn may_be_meant_for(profile: &Profile, file: &KitFile<'_>) -> bool {
    let text = String::from_utf8_lossy(file.bytes);
    let numbered = |line: &str| {
        let number = line.trim_start().strip_prefix(['N', 'n']);
        number.is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
    };
    match &profile.dialect {
        Dialect::Siemens(_) => text.contains('$'),
        Dialect::Fanuc(_) => text.split(['\n', '\r']).any(numbered),
        Dialect::Generic(_) => text.contains("position_mm"),
    }
}

fn plain(tables: Tables) -> ReadBack {
    ReadBack {
        tables,
        notes: Vec::new(),
        unwritten: Vec::new(),
        machine_data: Vec::new(),
    }
}

/// Reads every text; the problems of all of them are given at once.
fn each<T>(
    texts: &[(&KitFile<'_>, &str)],
    read: impl Fn(&str, &str) -> Result<T, Problems>,
) -> Result<Vec<T>, Problems> {
    let mut problems = Problems::none();
    let contents = texts
        .iter()
        .filter_map(|(file, text)| problems.take(read(file.path, text)))
        .collect();
    problems.or_ok(contents)
}

/// A rollback holds a control's own tables, with their grids as they were.
fn read_siemens(texts: &[(&KitFile<'_>, &str)]) -> Result<ReadBack, Problems> {
    let is_rollback = texts.iter().all(|(file, _)| file.role == Role::Rollback);
    let contents = each(
        texts,
        if is_rollback {
            siemens::read_out
        } else {
            siemens::read
        },
    )?;
    let machine_data = texts
        .iter()
        .zip(&contents)
        .map(|((file, _), contents)| FileData {
            path: file.path.to_string(),
            role: file.role,
            data: contents.machine_data.clone(),
        })
        .collect();
    let merged = siemens::merge(contents)?;
    Ok(ReadBack {
        tables: Tables::Siemens(merged.tables),
        notes: merged.notes,
        unwritten: merged.unwritten,
        machine_data,
    })
}
