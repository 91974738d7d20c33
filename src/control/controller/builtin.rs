//! The profiles and templates that are compiled into the program.

use crate::control::controller::{Profile, ProfileSource, load};
use crate::control::refusals;
use crate::text::{Problem, Problems, Source, nearest, shown};
use std::borrow::Cow;
use std::sync::OnceLock;

// PROFILES, BASES, which profiles build on and that are no control by themselves, and TEMPLATES: name and text of
// every file of their folders, by name (build.rs).
include!(concat!(env!("OUT_DIR"), "/built_in.rs"));

/// Ids of the built-in profiles, in the order of `controllers list`.
pub fn ids() -> Vec<&'static str> {
    PROFILES.iter().map(|(file, _)| file.trim_end_matches(".toml")).collect()
}

/// The TOML page of a built-in profile, or of one that others build on.
pub fn page(id: &str) -> Option<&'static str> {
    Some(placed(id)?.1)
}

/// The same with its place among all pages.
fn placed(id: &str) -> Option<(usize, &'static str)> {
    let mut pages = PROFILES.iter().chain(BASES).enumerate();
    let found = pages.find(|(_, (file, _))| file.trim_end_matches(".toml") == id);
    found.map(|(place, (_, text))| (place, *text))
}

/// The text of a built-in template.
pub fn template(name: &str) -> Option<Cow<'static, str>> {
    TEMPLATES.iter().find(|(file, _)| *file == name).map(|(_, text)| Cow::Borrowed(*text))
}

/// A built-in profile by its id; its page is read once in a process.
pub fn profile(id: &str) -> Result<Profile, Problems> {
    static READ: [OnceLock<Result<Profile, Problems>>; PROFILES.len() + BASES.len()] =
        [const { OnceLock::new() }; PROFILES.len() + BASES.len()];
    let Some((place, text)) = placed(id) else {
        return Err(unknown(id).into());
    };
    let read = || {
        let source = Source::from_bytes(&format!("controllers/{id}.toml"), text.as_bytes())?;
        load::profile(source, ProfileSource::BuiltIn, &|name, _| template(name), &page)
    };
    READ[place].get_or_init(read).clone()
}

fn unknown(word: &str) -> Problem {
    let list = ids().join(", ");
    let built_in =
        format!("built in: {list}; or give the path of a profile of your own (ending in .toml)");
    let help = match meant(word) {
        Some((id, name)) => format!("did you mean `{id}` ({name})? {built_in}"),
        None => built_in,
    };
    refusals::unknown_controller(shown(word), help)
}

/// The control that a word names: most of its parts stand in the id and the full name, one of them
/// with a digit (`31i` in `FANUC Series 30i/31i/32i-B`); else the word stands in them without their
/// hyphens (`840dsl`); else the id that is written most alike.
fn meant(word: &str) -> Option<(&'static str, String)> {
    let full_name = |id: &str| profile(id).map(|known| known.name).unwrap_or_default();
    let parts = parts(word);
    let known = |id: &str| self::parts(&format!("{id} {}", full_name(id)));
    let has_digit = |part: &String| part.contains(|c: char| c.is_ascii_digit());
    let shared = |id: &&'static str| {
        let known = known(id);
        let shared: Vec<&String> = parts.iter().filter(|part| known.contains(part)).collect();
        if shared.iter().any(|part| has_digit(part)) { shared.len() } else { 0 }
    };
    let last_first = ids().into_iter().rev(); // of equal ones the first is meant
    let best = last_first.max_by_key(shared).filter(|id| shared(id) > 0);
    let model = Some(parts.concat()).filter(has_digit);
    let of_model = || {
        let model = model.as_deref()?;
        ids().into_iter().find(|id| known(id).concat().contains(model))
    };
    let id = best.or_else(of_model).or_else(|| nearest(word, ids()))?;
    Some((id, full_name(id)))
}

/// The parts of a name in small letters: `fanuc-30i` has `fanuc` and `30i`.
fn parts(name: &str) -> Vec<String> {
    name.split(|c: char| !c.is_ascii_alphanumeric())
        .filter(|part| !part.is_empty())
        .map(str::to_ascii_lowercase)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::meant;

    #[test]
    fn a_model_is_found_by_its_name() {
        let words = [
            ("fanuc-31i", "fanuc-30i"),
            ("FANUC 32i-B", "fanuc-30i"),
            ("fanuc-18i", "fanuc-16i"),
            ("fanuc-0i-c", "fanuc-16i"),
            ("fanuc-0i", "fanuc-0i-f"),
            ("siemens-840d", "siemens-840d-sl"),
            ("simens-828d", "siemens-828d"),
            ("840dsl", "siemens-840d-sl"),
            ("Sinumerik828D", "siemens-828d"),
            ("fanuc30i", "fanuc-30i"),
        ];
        for (word, id) in words {
            assert_eq!(meant(word).map(|(id, _)| id), Some(id), "{word}");
        }
        assert_eq!(meant("tnc-640"), None);
    }
}
