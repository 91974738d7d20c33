//! docs/interface.md shows every key of a job with the words of the struct that it is read into.
use crate::support::{fixtures, page};
use nonius::inputs::job::keys;
use nonius::text::Key;

/// A line of a job with the words of its key behind it, and that key; `section` is that of the line, or becomes it.
fn with_words(line: &str, section: &mut String) -> (String, Option<(&'static str, Key)>) {
    let bare = line.split_once(" # ").map_or(line, |(bare, _)| bare).trim_end();
    let header = bare.trim_matches(['[', ']']);
    let one = header.strip_suffix(".x").filter(|one| one.ends_with(".axes")).unwrap_or(header);
    let (of, name) = if bare.starts_with('[') {
        *section = header.to_string();
        one.rsplit_once('.').unwrap_or_default()
    } else {
        (section.as_str(), bare.trim_start_matches("# ").split(['=', ' ']).next().unwrap())
    };
    let told = keys().find(|(own, key)| (*own, key.name) == (of, name));
    let words = told.map(|(_, key)| format!("{bare:<34} # {}", key.words.trim_start()));
    (words.unwrap_or_else(|| line.to_string()), told)
}

#[test]
fn the_interface_shows_every_key_with_its_words() {
    let old = page("docs/interface.md");
    let (mut section, mut is_job, mut shown) = (String::new(), false, Vec::new());
    let lines = old.lines().map(|line| {
        if line.starts_with("```") {
            (is_job, section) = (line == "```toml", String::new());
        }
        if !is_job {
            return line.to_string();
        }
        let (line, key) = with_words(line, &mut section);
        shown.extend(key);
        line
    });
    let new = lines.collect::<Vec<String>>().join("\n") + "\n";
    if std::env::var_os("NONIUS_UPDATE").is_some() {
        std::fs::write(fixtures("../docs/interface.md"), &new).unwrap();
    }
    let is_new = new == page("docs/interface.md");
    assert!(is_new, "docs/interface.md has other words than the keys: NONIUS_UPDATE=1");
    for (section, key) in keys() {
        let is_shown = shown.contains(&(section, key));
        assert!(is_shown, "docs/interface.md does not show `{}` of [{section}]", key.name);
    }
}
