//! `[[files]]`, `[[checklist]]` and `[program]` of a profile.

use crate::control::checklist::{List, ROLES, Step, Subject, When, is_placeholder, pieces};
use crate::control::controller::fact::{Facts, origin_or_rule};
use crate::control::controller::families::proved;
use crate::control::controller::program::{Language, ProgramFacts};
use crate::control::controller::{EmittedFile, Mechanism, Role, TableForm};
use crate::text::document::Section;
use crate::text::problem::shown;
use crate::text::words::Word;

/// Finds the text of a template by its name, for the page itself (`true`) or for one that it builds on, whose
/// templates are built in.
pub type TemplateFinder<'a> = &'a dyn Fn(&str, bool) -> Option<String>;

/// The templates that a page may name.
#[derive(Clone, Copy)]
pub(super) struct Templates<'a> {
    pub(super) find: TemplateFinder<'a>,
    /// Where the page itself ends in the text that all its pages make.
    pub(super) own_end: usize,
}

impl Templates<'_> {
    /// Name and text of the template that a section names; `key` says whose page that is.
    pub(super) fn named(
        &self,
        section: &Section<'_>,
        (root, key): (&Section<'_>, &str),
    ) -> Option<(String, String)> {
        let name = section.required_text("template", "the name of a template")?;
        let is_own = root.begins_at(key).is_none_or(|at| at < self.own_end);
        let text = (self.find)(&name, is_own);
        if text.is_none() {
            section.problem(
                "template",
                format!("there is no template `{}`", shown(&name)),
                "put it beside the profile, or name a built-in one (docs/templates.md)",
            );
        }
        Some((name, text?))
    }
}

/// The files of the form that the control takes.
pub(super) fn files(
    root: &Section<'_>,
    form: Option<&str>,
    templates: Templates<'_>,
) -> Option<Vec<EmittedFile>> {
    let sections = root.sections("files");
    if sections.is_empty() {
        root.problem(
            "files",
            "there is no section [[files]], expected one for each file",
            "add `[[files]]` with role, path and template",
        );
        return None;
    }
    let mut files: Vec<EmittedFile> = Vec::new();
    let mut are_whole = true;
    for section in &sections {
        let of_form = section.choice("form", TableForm::WORDS).map(TableForm::word);
        match file(root, section, templates) {
            Some(file) if of_form.is_none() || of_form == form => {
                if files.iter().any(|o| o.path.eq_ignore_ascii_case(&file.path)) {
                    section.problem(
                        "path",
                        format!("two files are called `{}`", shown(&file.path)),
                        "give each file a name of its own, in capitals or not",
                    );
                }
                files.push(file);
            }
            read => are_whole &= read.is_some(),
        }
    }
    if are_whole && !files.iter().any(|file| file.role == Role::Table) {
        root.problem(
            "files",
            "no file has the role `table`, expected at least one",
            "add a file with `role = \"table\"`",
        );
    }
    are_whole.then_some(files)
}

fn file(root: &Section<'_>, file: &Section<'_>, templates: Templates<'_>) -> Option<EmittedFile> {
    let role = file.choice("role", Role::WORDS);
    if !file.has("role") {
        file.missing(
            "role",
            "`table`, `parameters`, `enable`, `disable`, `rollback`, `sign-proof`, `checklist` or `report`",
        );
    }
    let is = |own: Role| role.is_none_or(|role| role == own);
    if file.has("mechanism") != is(Role::SignProof) && role.is_some() {
        file.problem(
            "role",
            "`mechanism` belongs to files of the role `sign-proof`, and to each of them",
            "for instance `role = \"sign-proof\"` with `mechanism = \"cec\"`",
        );
    }
    if file.has("loaded") && !is(Role::Report) {
        file.problem(
            "loaded",
            "`loaded` belongs to files of the role `report`",
            "leave it out; docs/templates.md says what each role means",
        );
    }
    let mechanism = file.choice("mechanism", &proved());
    let path = file.required_text("path", "a file name");
    let template = templates.named(file, (root, "files"));
    let may_be_loaded = file.flag("loaded").unwrap_or(true);
    let when = file.text("when");
    let each = file.text("each");
    file.refuse_unknown_keys();
    let path = path?;
    if !is_plain_file_name(&each_plain(file, &path, each.is_some())) {
        file.problem(
            "path",
            format!("`{}` is no file name that every control and laptop takes", shown(&path)),
            "use letters, digits, `_`, `-` and `.`; `manifest.json` is taken",
        );
    }
    let (template_name, template) = template?;
    Some(EmittedFile {
        role: role?,
        path,
        each,
        template_name,
        template,
        when,
        mechanism,
        may_be_loaded,
    })
}

/// The name of one file: `path` without the braces around the field of its item.
fn each_plain(file: &Section<'_>, path: &str, has_items: bool) -> String {
    let plain = path.replacen('{', "", 1).replacen('}', "", 1);
    if (plain.len() + 2 == path.len()) != has_items {
        file.problem(
            "path",
            "`each` and one field of its items in braces belong together",
            "for instance `each = \"joints\"` with `path = \"joint-{number}.comp\"`",
        );
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
    let numbered = |word: &str| {
        let number = stem.strip_prefix(word);
        number.is_some_and(|n| n.len() == 1 && n.bytes().all(|b| b.is_ascii_digit()))
    };
    ["con", "prn", "aux", "nul"].contains(&stem.as_str()) || numbered("com") || numbered("lpt")
}

/// The steps of a visit; none where the page has none. Those of `[[steps]]` stand at the end of their part.
pub(super) fn checklist(root: &Section<'_>) -> Option<Vec<Step>> {
    let sections = root.sections("checklist");
    let list: Vec<Option<Step>> = sections.iter().map(step).collect();
    let mut list: Vec<Step> = list.into_iter().collect::<Option<_>>()?;
    for section in &root.sections("steps") {
        let own = step(section)?;
        match list.iter().rposition(|step| step.part == own.part) {
            Some(last) => list.insert(last + 1, own),
            None => no_part(section, &own.part, &list),
        }
    }
    Some(list)
}

fn no_part(section: &Section<'_>, part: &str, list: &[Step]) {
    let mut parts: Vec<String> = list.iter().map(|own| format!("`{}`", own.part)).collect();
    parts.dedup();
    section.problem(
        "part",
        format!("the checklist has no part `{}`", shown(part)),
        format!("its parts: {}", parts.join(", ")),
    );
}

fn step(section: &Section<'_>) -> Option<Step> {
    let part = section.required_text("part", "the heading it stands under");
    let text = section.required_text("text", "what to do");
    let origin = origin_or_rule(section);
    let list = section.choice("list", List::WORDS);
    let when = section.text("when").map(|words| condition(section, &words));
    section.refuse_unknown_keys();
    let text = text?;
    let words = pieces(&text).into_iter().filter_map(|(_, word)| word);
    for word in words.filter(|word| !is_placeholder(word)) {
        section.problem(
            "text",
            format!("`{{{}}}` cannot be filled in", shown(word)),
            "write the word of a role of file, for instance `{enable}`, or `{reference}`",
        );
    }
    Some(Step { part: part?, list, when: when.flatten(), text: origin?.with(text) })
}

fn condition(section: &Section<'_>, words: &str) -> Option<When> {
    let (absent, word) = match words.strip_prefix("no ") {
        Some(word) => (true, word),
        None => (false, words),
    };
    let role = ROLES.into_iter().find(|role| role.word() == word);
    let mechanism = Mechanism::WORDS.iter().find(|(known, _)| *known == word);
    let subject =
        role.map(Subject::File).or(mechanism.map(|(_, mechanism)| Subject::Uses(*mechanism)));
    if subject.is_none() {
        section.problem(
            "when",
            format!("`{}` is neither a role of file nor a mechanism", shown(word)),
            "for instance `when = \"cec\"`, `when = \"rollback\"`, `when = \"no rollback\"`",
        );
    }
    Some(When { subject: subject?, absent })
}

const MOST_DECIMALS: u32 = 6;

/// The section `[program]` of a page.
pub(super) fn program_facts(
    section: &Section<'_>,
    templates: Templates<'_>,
) -> Option<ProgramFacts> {
    if !section.has("language") {
        let words = Language::WORDS.iter();
        let words: Vec<String> = words.map(|(word, _)| format!("`{word}`")).collect();
        section.missing("language", &words.join(" or "));
    }
    let language = section.choice("language", Language::WORDS);
    let extension = section.text("extension").unwrap_or("NC".to_string());
    if extension.is_empty() || !extension.chars().all(|c| c.is_ascii_alphanumeric()) {
        section.problem(
            "extension",
            "`extension` is no ending of a file, expected letters and digits",
            "for instance `extension = \"MPF\"`",
        );
    }
    let template = templates.named(section, (section, "template"));
    let facts = Facts::of(section.required_section("facts")?);
    let axis_letters = facts.read("axis_letters", three_letters);
    let machine_position = facts.stated("machine_position");
    let increment = facts.stated("increment");
    let dwell = facts.read("dwell", |fact| dwell_words(fact, language));
    let cancel = facts.stated("cancel");
    let decimals_mm = facts.read("decimals_mm", decimals);
    let decimals_inch = facts.read("decimals_inch", decimals);
    facts.section.refuse_unknown_keys();
    section.refuse_unknown_keys();
    let (template_name, template) = template?;
    Some(ProgramFacts {
        language: language?,
        extension,
        template_name,
        template,
        axis_letters: axis_letters?,
        machine_position: machine_position?,
        increment: increment?,
        dwell: dwell?,
        cancel: cancel?,
        decimals_mm: decimals_mm?,
        decimals_inch: decimals_inch?,
        statements: facts.statements.into_inner(),
    })
}

fn decimals(fact: &Section<'_>) -> Option<u32> {
    let decimals = fact.whole("value")?;
    if decimals > MOST_DECIMALS {
        fact.problem(
            "value",
            format!("a position has {decimals} decimals, expected 0 … {MOST_DECIMALS}"),
            "write the decimals that the control reads",
        );
    }
    Some(decimals)
}

/// The word of a dwell and the address of its seconds. Another address counts something else:
/// milliseconds (Fanuc `P`) or turns of a spindle (Siemens `S`).
fn dwell_words(fact: &Section<'_>, language: Option<Language>) -> Option<String> {
    let text = fact.text("value")?;
    let (addresses, expected) = language?.facts().dwell;
    if !text.ends_with(addresses) {
        fact.problem(
            "value",
            format!("`dwell` is `{}`, expected the word of a dwell and the address of its seconds: {expected}", shown(&text)),
            "seconds with a decimal point are written behind it",
        );
    }
    Some(text)
}

/// One capital letter for each of X, Y and Z: what every control takes as an address.
fn three_letters(fact: &Section<'_>) -> Option<Vec<String>> {
    let letters = fact.texts("value")?;
    let plain = |text: &String| text.len() == 1 && text.chars().all(|c| "XYZUVWABC".contains(c));
    if letters.len() != 3 || !letters.iter().all(plain) {
        fact.problem(
            "value",
            "`axis_letters` names the addresses of X, Y and Z, one letter each",
            "for instance [\"X\", \"Y\", \"Z\"]",
        );
    }
    Some(letters)
}
