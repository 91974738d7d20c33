//! A page of TOML: read, and its problems with their places.

use super::section::{Noted, Section, spots};
use crate::text::{
    LARGEST_PAGE, Place, Problem, Problems, Source, refusals, refuse_large_page, shown,
};
use std::ops::Range;
use toml::de::DeTable;

/// Whether a page states a key.
pub(crate) fn states(source: &Source, key: &str) -> bool {
    let is_read = source.text.len() <= LARGEST_PAGE; // else it is refused
    is_read && DeTable::parse_recoverable(&source.text).0.get_ref().contains_key(key)
}

/// Reads a TOML page: `read` takes what it knows from the root section and gives a value if it could;
/// every problem is collected, and where there is one, `besides` notes what else is wrong. The source
/// comes back with the places of its keys. A key that `needs` refuses may be empty; it gets a dotted
/// path, entries of a list without number.
///
/// A page may build on others, the nearest first: `lay_over` takes into a page what it wants of the one below. The
/// places below are those of a text in which one page follows the other.
pub(crate) fn read_page<T>(
    (mut source, below, lay_over): Pages<'_>,
    needs: impl Fn(&str) -> bool,
    read: impl FnOnce(&Section<'_>) -> Option<T>,
    besides: impl FnOnce(&Section<'_>),
) -> Result<(T, Source), Problems> {
    refuse_large_page(&source.name, source.text.len())?;
    let mut texts = vec![source.text.clone()];
    for (name, page) in below {
        source.below.push((source.text.len(), name.to_string()));
        texts.push(format!("{}{page}", " ".repeat(source.text.len())));
        source.text.push_str(page);
    }
    let (mut root, errors) = DeTable::parse_recoverable(&texts[0]);
    if !errors.is_empty() {
        return Err(syntax_problems(&source, &errors));
    }
    for text in &texts[1..] {
        lay_over(root.get_mut(), DeTable::parse_recoverable(text).0.into_inner());
    }
    let noted = Noted::default();
    let section = Section::root(&source, root.get_ref(), &noted);
    let value = read(&section);
    section.refuse_unknown_keys();
    let mut all = Vec::new();
    spots(root.get_ref(), "", &mut all);
    let without_number =
        |path: &str| path.split('[').filter_map(|part| part.rsplit(']').next()).collect::<String>();
    let open = all.iter().filter(|(path, _, is_empty)| *is_empty && needs(&without_number(path)));
    section.note_all(to_be_filled_in(&source, open.map(|(_, span, _)| span.clone()).collect()));
    if !noted.problems.is_sound() {
        besides(&section);
    }
    noted.problems.end(())?;
    let stated = all.into_iter().filter(|(.., is_empty)| !is_empty);
    source.spots = stated.map(|(path, span, _)| (path, span)).collect();
    Ok((value.ok_or_else(|| Problem::new(format!("`{}` could not be read", source.name)))?, source))
}

/// A page, those that it builds on with their names, and how it does.
pub(crate) type Pages<'a> = (Source, &'a [(&'a str, &'a str)], LayOver);

/// Takes into a page what it wants of the one below.
pub(crate) type LayOver = for<'a> fn(&mut DeTable<'a>, DeTable<'a>);

/// All keys that are to be filled in, as one problem that shows their lines.
fn to_be_filled_in(source: &Source, mut empty: Vec<Range<usize>>) -> Problems {
    empty.sort_by_key(|span| span.start);
    let mut places = empty.iter().map(|span| source.place(span));
    let Some(first) = places.next() else {
        return Problems::none();
    };
    let mut lines: Vec<Place> = places.collect();
    lines.dedup_by_key(|place| place.line);
    let message = match empty.len() {
        1 => "a key is empty, expected a value".to_string(),
        many => format!("{many} keys are empty, expected a value of each"),
    };
    let mut problem = Problem::new(message).help("write the value in place of `\"\"`").at(first);
    problem.also = lines;
    problem.into()
}

fn syntax_problems(source: &Source, errors: &[toml::de::Error]) -> Problems {
    let mut problems = Problems::none();
    let (mut commas, mut last) = (Vec::new(), (usize::MAX, None));
    for error in errors {
        if problems.is_full() {
            break; // nobody reads further
        }
        let message = error.message().lines().next().unwrap_or("not TOML");
        let span = error.span();
        let start = span.as_ref().map_or(usize::MAX, |span| span.start);
        if let Some(comma) = decimal_comma(&source.text, start, &mut last) {
            // One comma leads to several complaints.
            if !commas.contains(&comma) {
                commas.push(comma);
                let problem = refusals::comma_in_number(with_a_point(&source.text, comma));
                problems.push(problem.at(source.place(&(comma..comma + 1))));
            }
            continue;
        }
        let mut problem = match (message, span.clone().and_then(|span| source.text.get(span))) {
            ("duplicate key", Some(key)) => refusals::key_twice(shown(key)),
            _ if in_escape(&source.text, start) => refusals::escape(),
            _ => refusals::not_toml(message),
        };
        problem.place = span.map(|span| source.place(&span));
        problems.push(problem);
    }
    problems
}

/// What to write in place of a number with a decimal comma: the number itself where it is plain, sign
/// and digits, else an example.
fn with_a_point(text: &str, comma: usize) -> String {
    let of_number = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '_' | '+' | '-');
    let whole = &text[..comma];
    let whole = &whole[whole.trim_end_matches(of_number).len()..];
    let rest = &text[comma + 1..];
    let rest = &rest[..rest.len() - rest.trim_start_matches(of_number).len()];
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    match digits(whole.strip_prefix(['-', '+']).unwrap_or(whole)) && digits(rest) {
        true => format!("write `{whole}.{rest}`"),
        false => "write a point, as in `0.5`".to_string(),
    }
}

/// Whether a complaint at `at` is one of an escape: in its line an odd number of double quotes stands
/// before it, and a backslash at it or behind the last of them.
fn in_escape(text: &str, at: usize) -> bool {
    let (Some(before), Some(rest)) = (text.get(..at), text.get(at..)) else {
        return false;
    };
    let line = before.rsplit('\n').next().unwrap_or(before);
    let begun = line.rsplit('"').next().unwrap_or(line);
    let is_open = line.matches('"').count() % 2 == 1;
    is_open && (begun.contains('\\') || rest.starts_with('\\'))
}

/// Where a decimal comma stands that a complaint at `at` follows from: there, or in braces on its
/// line, where nothing but digits stand between a comma and the next comma or brace. `last`: the start of the line
/// that was looked through last, and what was found.
fn decimal_comma(text: &str, at: usize, last: &mut (usize, Option<usize>)) -> Option<usize> {
    let bytes = text.as_bytes();
    let is_digit = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_digit);
    let between_digits = |at: &usize| {
        bytes.get(*at) == Some(&b',') && at.checked_sub(1).is_some_and(is_digit) && is_digit(at + 1)
    };
    if between_digits(&at) {
        return Some(at);
    }
    let start = text.get(..at)?.rfind('\n').map_or(0, |end| end + 1);
    if last.0 == start {
        return last.1;
    }
    let line = text[start..].split('\n').next()?;
    let in_braces = line.find('{').map_or(0..0, |open| start + open..start + line.len());
    let found = in_braces.filter(between_digits).find(|comma| {
        let rest = text[comma + 1..].trim_start_matches(|c: char| c.is_ascii_digit());
        rest.trim_start_matches(' ').starts_with([',', '}'])
    });
    *last = (start, found);
    found
}
