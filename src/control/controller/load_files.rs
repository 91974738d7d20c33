//! `[[files]]` of a profile: which files are written, from which templates.

use crate::control::controller::{EmittedFile, Mechanism, Profile, Role, TableForm};
use crate::text::document::Section;
use crate::text::problem::shown;

pub(super) type FormFile = (Option<TableForm>, EmittedFile);

pub(super) fn read_files(
    root: &Section<'_>,
    base: Option<&Profile>,
    templates: TemplateFinder<'_>,
) -> Option<Vec<FormFile>> {
    let sections = root.sections("files");
    if sections.is_empty() {
        if let Some(base) = base {
            return Some(base.files.iter().map(|file| (None, file.clone())).collect());
        }
        root.problem(
            "files",
            "there is no section [[files]], expected one for each file",
            "add `[[files]]` with role, path and template",
        );
        return None;
    }
    let files: Vec<Option<FormFile>> = sections
        .iter()
        .map(|file| read_file(file, templates))
        .collect();
    refuse_shared_names(&sections, &files);
    files.into_iter().collect()
}

/// Two files of one name overwrite each other, unless they are forms of which one is written.
fn refuse_shared_names(sections: &[Section<'_>], files: &[Option<FormFile>]) {
    for (index, (section, file)) in sections.iter().zip(files).enumerate() {
        let Some((form, file)) = file else { continue };
        let shared = files[..index].iter().flatten().any(|(other_form, other)| {
            let both = form.is_none() || other_form.is_none() || form == other_form;
            both && other.path.eq_ignore_ascii_case(&file.path)
        });
        if shared {
            section.problem(
                "path",
                format!("two files are called `{}`", shown(&file.path)),
                "give each file a name of its own, in capitals or not",
            );
        }
    }
}

fn read_file(file: &Section<'_>, templates: TemplateFinder<'_>) -> Option<FormFile> {
    let role = file.choice("role", &Role::ALL.map(|role| (role.word(), role)));
    if !file.has("role") {
        file.missing(
            "role",
            "`table`, `parameters`, `enable`, `disable`, `rollback`, `sign-proof`, `checklist` or `report`",
        );
    }
    let mechanism = proved(file, role);
    let path = file.required_text("path", "a file name");
    let name = file.required_text("template", "the name of a template");
    let may_be_loaded = may_be_loaded(file, role);
    let when = file.text("when");
    let form = file.choice(
        "form",
        &[("program", TableForm::Program), ("data", TableForm::Data)],
    );
    file.refuse_unknown_keys();
    let (role, path, name) = (role?, path?, name?);
    if !is_plain_file_name(&path) {
        file.problem(
            "path",
            format!(
                "`{}` is no file name that every control and laptop takes",
                shown(&path)
            ),
            "use letters, digits, `_`, `-` and `.`; `manifest.json` is taken",
        );
    }
    let Some(template) = templates(&name) else {
        file.problem(
            "template",
            format!("there is no template `{}`", shown(&name)),
            "put it beside the profile, or name a built-in one (docs/templates.md)",
        );
        return None;
    };
    let file = EmittedFile {
        role,
        path,
        template_name: name,
        template,
        when,
        mechanism,
        may_be_loaded,
    };
    Some((form, file))
}

/// `loaded = false` of a report that no control ever loads; absent = it may be loaded.
fn may_be_loaded(file: &Section<'_>, role: Option<Role>) -> bool {
    if file.has("loaded") && role.is_some_and(|role| role != Role::Report) {
        file.problem(
            "loaded",
            "`loaded` belongs to files of the role `report`",
            "leave it out; docs/templates.md says what each role means",
        );
    }
    file.flag("loaded").unwrap_or(true)
}

/// The mechanism that a sign proof is for; no other file has one.
fn proved(file: &Section<'_>, role: Option<Role>) -> Option<Mechanism> {
    let proof = role == Some(Role::SignProof);
    if proof != file.has("mechanism") && role.is_some() {
        file.problem(
            if proof { "role" } else { "mechanism" },
            "`mechanism` belongs to files of the role `sign-proof`, and to each of them",
            "for instance `role = \"sign-proof\"` with `mechanism = \"cec\"`",
        );
    }
    file.choice("mechanism", &Mechanism::PROVED)
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
    let numbered = |word: &str| {
        let number = stem.strip_prefix(word);
        number.is_some_and(|n| n.len() == 1 && n.bytes().all(|b| b.is_ascii_digit()))
    };
    ["con", "prn", "aux", "nul"].contains(&stem.as_str()) || numbered("com") || numbered("lpt")
}

/// Finds the text of a template by its name; `None` if there is none.
pub(crate) type TemplateFinder<'a> = &'a dyn Fn(&str) -> Option<String>;
