//! What judge, kit and command line ask of a family of controls; the files of a kit, and the examples of a profile, read
//! through it.

use crate::control::control_state::ControlState;
use crate::control::controller::{
    Added, Dialect, Encoding, Example, ExampleFile, KitFile, Profile, Role,
};
use crate::control::table::Tables;
use crate::control::table::siemens::MachineDatum;
use crate::quantity::{Direction, Figure, Millimetres};
use crate::read::emulate::{Emulated, Emulator};
use crate::read::findings::ReadFinding;
use crate::text::{Finding, Problem, Problems, joined, not_utf_8, shown};
use encoding_rs::UTF_16LE;
use std::borrow::Cow;

/// A family of controls; the facts of its profiles implement it, in its folder.
pub(crate) trait Family {
    /// All files of a kit, names and texts, as one memory, in the order in which they are loaded.
    fn read_kit(&self, texts: &[(&str, &str)], roles: &[Role]) -> Result<ReadBack, Problems>;

    /// A control that holds these tables.
    fn control(&self, tables: &Tables, state: &ControlState) -> Emulated<Box<dyn Emulator>>;

    /// Whether a text may mean something to the control, whole or damaged.
    ///
    /// **limits** it errs on the careful side; a text for people that quotes such a word counts too.
    fn may_obey(&self, text: &str) -> bool;

    /// Whether a text was read out of the control as a whole: what a kit writes is of concern throughout.
    fn is_whole(&self, _text: &str) -> bool {
        false
    }

    /// Why a file of the control is none that can be read, and which one to name in its place.
    fn refusal(&self, _name: &str, _bytes: &[u8]) -> Option<Problem> {
        None
    }
}

/// The family of a profile.
pub(crate) fn family(dialect: &Dialect) -> &dyn Family {
    match dialect {
        Dialect::Siemens(facts) => facts,
        Dialect::Fanuc(facts) => facts,
        Dialect::Declared(facts) => facts,
        Dialect::Linuxcnc(facts) => facts,
        Dialect::Isg(facts) => facts,
    }
}

/// The control of a profile with tables in its memory.
pub fn emulator(
    profile: &Profile,
    tables: &Tables,
    state: &ControlState,
) -> Emulated<Box<dyn Emulator>> {
    family(&profile.dialect).control(tables, state)
}

/// What a control holds after all files were loaded.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadBack {
    /// Tables, parameters and points.
    pub tables: Tables,
    /// Remarks of the reader.
    pub notes: Vec<Finding>,
    /// Parameters of tables that no file writes, so that the control keeps older ones (Siemens).
    pub unwritten: Vec<String>,
    /// Machine and setting data of every file, also of files that set none (Siemens).
    pub machine_data: Vec<FileData>,
}

impl From<Tables> for ReadBack {
    fn from(tables: Tables) -> ReadBack {
        ReadBack { tables, notes: Vec::new(), unwritten: Vec::new(), machine_data: Vec::new() }
    }
}

/// The machine and setting data that one file sets.
#[derive(Clone, Debug, PartialEq)]
pub struct FileData {
    /// Name of the file.
    pub path: String,
    /// What it is for.
    pub role: Role,
    /// What it sets.
    pub data: Vec<MachineDatum>,
}

/// Reads all files of a kit through the reader of the profile's family. Checklists and reports are
/// not read, and files that stand apart (`rollback`, `sign-proof`) are not part of the kit's memory.
pub fn read(profile: &Profile, files: &[KitFile]) -> Result<ReadBack, Problems> {
    read_role(profile, files, |role| !role.stands_apart())
}

/// Reads the files of one role that stands apart as a memory of their own.
pub fn read_apart(profile: &Profile, files: &[KitFile], role: Role) -> Result<ReadBack, Problems> {
    read_role(profile, files, |other| other == role)
}

fn read_role(
    profile: &Profile,
    files: &[KitFile],
    is_wanted: impl Fn(Role) -> bool,
) -> Result<ReadBack, Problems> {
    let mut problems = Problems::none();
    let mut texts = Vec::new();
    let is_read = |file: &&KitFile| file.role.is_read_back() && is_wanted(file.role);
    for file in files.iter().filter(is_read) {
        match kit_text(profile, &file.bytes) {
            Some(text) => texts.push((file, text)),
            None => problems.push(not_text(profile, &file.path, &file.bytes)),
        }
    }
    if texts.is_empty() && problems.is_empty() {
        return Err(Problem::new("there is no file to read back").into());
    }
    let roles: Vec<Role> = texts.iter().map(|(file, _)| file.role).collect();
    let texts: Vec<(&str, &str)> =
        texts.iter().map(|(file, text)| (file.path.as_str(), &**text)).collect();
    match problems.take(family(&profile.dialect).read_kit(&texts, &roles)) {
        Some(read) => problems.or_ok(read),
        None => Err(problems),
    }
}

/// The last part of a path.
pub(crate) fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

/// The names of files as a sentence has them.
pub(super) fn quoted(texts: &[(&str, &str)]) -> String {
    joined(texts.iter().map(|(name, _)| format!("`{}`", shown(name))))
}

/// Files that a control may load and that no reader takes: whatever else is read back,
/// nothing shows what the control will hold.
pub(crate) fn unread(profile: &Profile, files: &[KitFile]) -> Option<Finding> {
    let is_unread = |name: &str| {
        let mut known = profile.files.iter().filter(|file| file.is_loaded_unread());
        known.any(|file| file.is_called(name))
    };
    let names = files.iter().map(|file| file.path.as_str());
    let files: Vec<String> =
        names.filter(|name| is_unread(name)).map(|name| format!("`{}`", shown(name))).collect();
    (!files.is_empty()).then(|| ReadFinding::Unread { files }.into())
}

/// A file with more data of no concern to the compensation than this was read out of a control as a whole,
/// which has thousands; a person may have added a few lines.
pub(super) const READ_OUT_AS_A_WHOLE: usize = 100;

/// Whether a file is one of a control as a whole, such as its parameter file.
pub fn is_whole(profile: &Profile, bytes: &[u8]) -> bool {
    let family = family(&profile.dialect);
    let is_one = || text(profile, bytes).is_some_and(|text| family.is_whole(&text));
    family.refusal("", bytes).is_some() || is_one()
}

/// A file that was read out of a control as text.
pub fn read_out_text<'a>(
    profile: &Profile,
    name: &str,
    bytes: &'a [u8],
) -> Result<Cow<'a, str>, Problem> {
    if let Some(refusal) = family(&profile.dialect).refusal(name, bytes) {
        return Err(refusal);
    }
    text(profile, bytes).ok_or_else(|| not_text(profile, name, bytes))
}

/// A file of a kit as text.
fn kit_text<'a>(profile: &Profile, bytes: &'a [u8]) -> Option<Cow<'a, str>> {
    match profile.encoding() {
        Encoding::Utf8 => std::str::from_utf8(bytes).ok().map(Cow::Borrowed),
        Encoding::Utf16Le => utf16(bytes),
    }
}

/// A file of two bytes for each character, the low one first; `None` of one that holds no zero byte: letters and
/// digits would have one each.
fn utf16(bytes: &[u8]) -> Option<Cow<'_, str>> {
    let bytes = bytes.strip_prefix(b"\xFF\xFE").unwrap_or(bytes);
    let text = UTF_16LE.decode_without_bom_handling_and_without_replacement(bytes);
    text.filter(|_| bytes.contains(&0))
}

/// The byte order mark.
const MARK: char = '\u{feff}';

fn not_text(profile: &Profile, name: &str, bytes: &[u8]) -> Problem {
    match profile.encoding() {
        Encoding::Utf8 => not_utf_8(name, bytes),
        Encoding::Utf16Le => Problem::new(format!(
            "`{name}` is not text in UTF-16 (low byte first), as this control has it"
        ))
        .help("name the files that the control wrote as text"),
    }
}

/// A file of a control as text: as [`kit_text`], of UTF-8 without its byte order mark, or one byte for each
/// character (Latin-1), as older controls write comments and messages. `None` where it is neither.
fn text<'a>(profile: &Profile, bytes: &'a [u8]) -> Option<Cow<'a, str>> {
    if profile.encoding() != Encoding::Utf8 {
        return kit_text(profile, bytes);
    }
    match std::str::from_utf8(bytes) {
        Ok(text) => Some(Cow::Borrowed(text.strip_prefix(MARK).unwrap_or(text))),
        Err(_) if bytes.contains(&0) => None,
        Err(_) => Some(bytes.iter().map(|byte| char::from(*byte)).collect()),
    }
}

/// Whether a file may mean something to the control of a profile ([`Family::may_obey`]).
pub(crate) fn may_be_meant_for(profile: &Profile, file: &KitFile) -> bool {
    let text = kit_text(profile, &file.bytes);
    family(&profile.dialect).may_obey(&text.unwrap_or_else(|| String::from_utf8_lossy(&file.bytes)))
}

// What the reader and the emulated control make of a profile's examples, against what stands there.

/// A correction of a manual is printed to this, µm.
const PRINTED_UM: f64 = 1e-3;

/// Reads the files of each example and compares what the control would add for them.
///
/// **limits** backlash parameters count as 0
pub fn check_examples(profile: &Profile) -> Result<(), Problems> {
    Problems::all(profile.examples.iter().map(|example| check(profile, example))).map(drop)
}

fn check(profile: &Profile, example: &Example) -> Result<(), Problems> {
    let file = |own: &ExampleFile| {
        let (path, bytes) = (own.path.clone(), own.text.clone().into_bytes());
        KitFile { path, role: Role::Table, bytes }
    };
    let files: Vec<KitFile> = example.files.iter().map(file).collect();
    let wrong = |words: String| Problem::new(format!("example of {}: {words}", example.source));
    let read = read(profile, &files)?;
    let control = emulator(profile, &read.tables, &example.state()).map_err(|why| wrong(why.0))?;
    let compared = example.adds.iter().map(|added| {
        let other = otherwise(control.as_ref(), added);
        let help = "compare file, facts and what stands in `adds`";
        other.map_or(Ok(()), |words| Err(wrong(words).help(help)))
    });
    Problems::all(compared).map(drop)
}

/// What the control adds where it is not what stands there.
fn otherwise(control: &dyn Emulator, added: &Added) -> Option<String> {
    let Added { axis, by, at_mm, moving, um } = added;
    let base = by.as_ref().unwrap_or(axis);
    let ways = Direction::BOTH.into_iter().filter(|way| moving.is_none_or(|own| own == *way));
    let gets = |way: Direction| match control.response(base, axis, way) {
        Err(why) => Some(why.0),
        Ok(response) => {
            let got = response.correction(Millimetres::new(*at_mm)).um();
            ((got - um).abs() > PRINTED_UM).then(|| {
                let [got, um, at] = [got, *um, *at_mm].map(|own| Figure(own).trimmed(6));
                format!("{axis} gets {got} µm at {base} {at} mm moving in {way}, expected {um} µm")
            })
        }
    };
    ways.filter_map(gets).next()
}

#[cfg(test)]
mod tests {
    use super::check_examples;
    use crate::control::controller::builtin;

    #[test]
    fn every_profile_reads_its_examples_or_says_why_there_is_none() {
        for id in builtin::ids() {
            let mut profile = builtin::profile(id).unwrap();
            assert_eq!(profile.examples.is_empty(), profile.no_example.is_some(), "{id}");
            check_examples(&profile).unwrap_or_else(|p| panic!("{id}: {}", p.render()));
            for own in 0..profile.examples.len() {
                for added in 0..profile.examples[own].adds.len() {
                    profile.examples[own].adds[added].um += 0.01;
                    let told = check_examples(&profile).expect_err(id).render();
                    assert!(told.contains("expected"), "{told}");
                    profile.examples[own].adds[added].um -= 0.01;
                }
            }
        }
    }
}
