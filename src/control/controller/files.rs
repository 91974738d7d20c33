//! `[[files]]` of a profile: what a kit consists of.

use crate::control::controller::fact::{Mechanism, Role, TableForm};
use crate::control::refusals;
use crate::text::{Section, Word, section, shown};
use std::borrow::Cow;

/// A template, such as a page names it.
#[derive(Clone, Debug, PartialEq)]
pub struct Template {
    /// Its name.
    pub name: String,
    /// Its text; that of a built-in one is borrowed.
    pub text: Cow<'static, str>,
}

/// A file of a kit, or of a measuring run: as it will be written, or as it was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KitFile<R = Role> {
    /// Its name.
    pub path: String,
    /// What it is for.
    pub role: R,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

section! {
    /// One file that a profile emits.
    #[derive(Clone, Debug, PartialEq)]
    pub struct EmittedFile(section: &Section<'_>, root: &Section<'_>, known: Templates<'_>) {
        /// What it is for.
        pub role: Role = choice(Role::WORDS), must ROLES;
        /// What a sign proof proves; other files have none.
        pub mechanism: Option<Mechanism> = with(|s, key| mechanism(s, key, role, known.proved));
        /// Whether a control may load it; `false` is stated only of a `report`.
        pub may_be_loaded as loaded: bool = with(|s, key| loaded(s, key, role)), or true;
        /// Its name in the kit; of one for each item of a list with the item's field in braces.
        pub path: String = text(), must "a file name";
        /// How it is laid out.
        pub template: Template => known.named(section, (root, "files")), must;
        /// Emitted only if the kit holds such tables (`lec`, `cec`, `points`); absent = always.
        pub when: Option<String> = text();
        /// The list of which each item gets a file of its own (`joints`); absent = one file.
        pub each: Option<String> = text();
    }
}

const ROLES: &str =
    "`table`, `parameters`, `enable`, `disable`, `rollback`, `sign-proof`, `checklist` or `report`";

impl EmittedFile {
    /// Whether it is a page for a browser: its template sees every text as HTML.
    pub(crate) fn is_page(&self) -> bool {
        self.path.to_ascii_lowercase().ends_with(".html")
    }

    /// What stands before and behind the field in braces, and the field: `joint-{number}.comp`.
    pub(crate) fn field(&self) -> Option<[&str; 3]> {
        let (before, rest) = self.path.split_once('{')?;
        let (field, behind) = rest.split_once('}')?;
        Some([before, field, behind])
    }

    /// Whether a file is called so, in capitals or not.
    pub fn is_called(&self, name: &str) -> bool {
        let Some([before, _, behind]) = self.field() else {
            return self.path.eq_ignore_ascii_case(name);
        };
        let name = name.to_ascii_lowercase();
        let inside = name.strip_prefix(&before.to_ascii_lowercase());
        let inside = inside.and_then(|rest| rest.strip_suffix(&behind.to_ascii_lowercase()));
        inside.is_some_and(|item| {
            !item.is_empty() && item.bytes().all(|byte| byte.is_ascii_alphanumeric())
        })
    }

    /// Whether a control may load the file, and no reader of this program takes it.
    pub(crate) fn is_loaded_unread(&self) -> bool {
        self.role == Role::Report && self.may_be_loaded
    }
}

/// Finds the text of a template by its name, for the page itself (`true`) or for one that it builds on, whose
/// templates are built in.
pub type TemplateFinder<'a> = &'a dyn Fn(&str, bool) -> Option<Cow<'static, str>>;

/// The templates that a page may name, and what its files can prove.
#[derive(Clone, Copy)]
pub(crate) struct Templates<'a> {
    pub(super) find: TemplateFinder<'a>,
    /// Where the page itself ends in the text that all its pages make.
    pub(super) own_end: usize,
    /// What sign proofs can prove.
    pub(super) proved: &'a [(&'static str, Mechanism)],
}

impl Templates<'_> {
    /// Name and text of the template that a section names; `key` says whose page that is.
    pub(super) fn named(
        &self,
        section: &Section<'_>,
        (root, key): (&Section<'_>, &str),
    ) -> Option<Template> {
        section.require("template", "the name of a template");
        let name = section.text("template")?;
        let is_own = root.begins_at(key).is_none_or(|at| at < self.own_end);
        let text = (self.find)(&name, is_own);
        if text.is_none() {
            section.refuse("template", refusals::no_template(shown(&name)));
        }
        Some(Template { name, text: text? })
    }
}

/// The files of the form that the control takes.
pub(super) fn files(
    root: &Section<'_>,
    form: Option<String>,
    templates: Templates<'_>,
) -> Option<Vec<EmittedFile>> {
    let sections = root.sections("files");
    if sections.is_empty() {
        root.refuse("files", refusals::no_files());
        return None;
    }
    let mut files: Vec<EmittedFile> = Vec::new();
    let mut are_whole = true;
    for section in &sections {
        let of_form = section.choice("form", TableForm::WORDS).map(TableForm::word);
        match file(root, section, templates) {
            Some(file) if of_form.is_none() || of_form == form.as_deref() => {
                if files.iter().any(|o| o.path.eq_ignore_ascii_case(&file.path)) {
                    section.refuse("path", refusals::twice(shown(&file.path)));
                }
                files.push(file);
            }
            read => are_whole &= read.is_some(),
        }
    }
    if are_whole && !files.iter().any(|file| file.role == Role::Table) {
        root.refuse("files", refusals::no_table());
    }
    are_whole.then_some(files)
}

fn file(
    root: &Section<'_>,
    section: &Section<'_>,
    templates: Templates<'_>,
) -> Option<EmittedFile> {
    let file = EmittedFile::read(section, root, templates);
    section.refuse_unknown_keys();
    let file = file?;
    if !is_plain_file_name(&each_plain(section, &file)) {
        section.refuse("path", refusals::no_file_name(shown(&file.path)));
    }
    Some(file)
}

fn mechanism(
    section: &Section<'_>,
    key: &'static str,
    role: Option<Role>,
    proved: &[(&'static str, Mechanism)],
) -> Option<Mechanism> {
    let fits = |role| section.has(key) == (role == Role::SignProof);
    if !role.is_none_or(fits) {
        section.refuse("role", refusals::mechanism_of_proof());
    }
    section.choice(key, proved)
}

fn loaded(section: &Section<'_>, key: &'static str, role: Option<Role>) -> Option<bool> {
    if section.has(key) && role.is_some_and(|role| role != Role::Report) {
        section.refuse(key, refusals::loaded_of_report());
    }
    section.flag(key)
}

/// The name of one file: `path` without the braces around the field of its item.
fn each_plain(section: &Section<'_>, file: &EmittedFile) -> String {
    let plain = file.path.replacen('{', "", 1).replacen('}', "", 1);
    if (plain.len() + 2 == file.path.len()) != file.each.is_some() {
        section.refuse("path", refusals::each_without_field());
    }
    plain
}

fn is_plain_file_name(path: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
    !path.is_empty()
        && !path.starts_with(['.', '-'])
        && !path.ends_with('.')
        && path.chars().all(plain)
        && !path.eq_ignore_ascii_case("manifest.json")
        && !is_device_of_windows(path)
}

/// Names that Windows gives to devices, with any ending.
fn is_device_of_windows(path: &str) -> bool {
    let stem = path.split('.').next().unwrap_or("").to_ascii_lowercase();
    let before_digit = stem.strip_suffix(|c: char| c.is_ascii_digit());
    ["con", "prn", "aux", "nul"].contains(&stem.as_str())
        || before_digit.is_some_and(|word| ["com", "lpt"].contains(&word))
}
