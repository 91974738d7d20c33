//! What a template may say, and how much work it is, before it is rendered.
//!
//! The engine bounds neither loops nor texts that grow (`{% set s = s ~ s %}` forty times is a terabyte), and
//! has no place to count them. So a template says what a layout needs and no more: names, loops over lists
//! of the context, choices. Then no value is longer than one of the context, each tag is done in a time that
//! does not depend on the lists, and how many tags are executed at most follows from the lengths of the lists.

use std::collections::BTreeMap;
use std::ops::Range;

/// Filters whose work and whose result do not grow with a list.
const FILTERS: [&str; 7] = ["default", "first", "last", "length", "lower", "trim", "upper"];
/// Words behind which a bracket groups; behind any other it would call a function.
const GROUPING: [&str; 5] = ["if", "elif", "and", "or", "not"];
const SIGNS: [&str; 13] = ["==", "!=", "<=", ">=", "<", ">", "=", ".", ",", "|", "(", ")", "-"];
const COMPARING: [&str; 6] = ["==", "!=", "<=", ">=", "<", ">"];

/// Where a template says more than a layout.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Wrong {
    /// Bytes of the template.
    pub(super) span: Range<usize>,
    /// What was found and what was expected.
    pub(super) message: String,
}

/// Of each tag of a template the loops around it, each with the first and the last name of its list.
#[derive(Clone, Debug, Default)]
pub(super) struct Layout {
    tags: Vec<Vec<(String, String)>>,
}

#[derive(Clone, Debug, PartialEq)]
enum Token<'a> {
    Word(&'a str),
    /// A text in quotes, a number, `true` or `false`.
    Literal,
    Sign(&'a str),
}

/// A token and where it stands in the template.
type Placed<'a> = (Token<'a>, Range<usize>);

impl Layout {
    /// The layout of a template that the engine has parsed.
    pub(super) fn of(template: &str) -> Result<Layout, Wrong> {
        let mut layout = Layout::default();
        let mut open: Vec<Option<(String, String)>> = Vec::new(); // `None` is a choice
        let mut at = 0;
        while let Some(tag) = next_tag(template, at)? {
            at = tag.end;
            let is_print = template[tag.clone()].starts_with("{{");
            let tokens = tokens(template, tag.start + 2..tag.end - 2)?;
            let kind = match tokens.first() {
                Some((Token::Word(word), _)) if !is_print => *word,
                _ if is_print => "",
                _ => return Err(wrong(tag, "this tag")),
            };
            check(&tokens, is_print)?;
            layout.tags.push(open.iter().flatten().cloned().collect());
            match kind {
                "for" => open.push(Some(list_of(&tokens, tag)?)),
                "if" => open.push(None),
                "endfor" | "endif" => {
                    open.pop();
                }
                "" | "elif" | "else" => {}
                other => return Err(wrong(tokens[0].1.clone(), &format!("`{other}`"))),
            }
        }
        Ok(layout)
    }

    /// Tags that rendering executes, at most: all branches count, and each list is as long as the longest of
    /// its name. `None` = more than `most`.
    pub(super) fn work(&self, context: &tera::Context, most: u64) -> Option<u64> {
        let mut longest = BTreeMap::new();
        for (root, _) in self.tags.iter().flatten() {
            if let Some(value) = context.get(root).filter(|_| !longest.contains_key(root.as_str()))
            {
                measure(root, value, &mut longest);
            }
        }
        let of_any = longest.get(ANY).copied().unwrap_or(0);
        let turns = |(_, list): &(String, String)| {
            longest.get(list.as_str()).copied().unwrap_or(of_any).max(1)
        };
        let times = |loops: &Vec<_>| loops.iter().map(turns).fold(1, u64::saturating_mul);
        let work = self.tags.iter().map(times).fold(0, u64::saturating_add);
        (work <= most).then_some(work)
    }
}

/// The name of lists that have none of their own, and the longest of all.
const ANY: &str = "";

/// Notes the longest list, map or text of each name in a value.
fn measure<'a>(name: &'a str, value: &'a tera::Value, longest: &mut BTreeMap<&'a str, u64>) {
    let length = value.len().unwrap_or(0) as u64;
    for name in [name, ANY] {
        let known = longest.entry(name).or_default();
        *known = length.max(*known);
    }
    for item in value.as_array().into_iter().flatten() {
        measure(ANY, item, longest);
    }
    for (key, item) in value.as_map().into_iter().flatten() {
        measure(key.as_str().unwrap_or(ANY), item, longest);
    }
}

/// The next `{{ … }}` or `{% … %}` from `at` on, comments ignored; one that does not end is wrong.
fn next_tag(template: &str, mut at: usize) -> Result<Option<Range<usize>>, Wrong> {
    loop {
        let begins = |pair: &[u8]| pair[0] == b'{' && b"{%#".contains(&pair[1]);
        let Some(start) = template.as_bytes()[at..].windows(2).position(begins) else {
            return Ok(None);
        };
        let start = at + start;
        let endless = || wrong(start..start + 2, "a tag or comment without its end");
        let close = match &template[start..start + 2] {
            "{{" => "}}",
            "{%" => "%}",
            _ => {
                let inside = start + 2; // `{#}` is no whole comment
                at = inside + template[inside..].find("#}").ok_or_else(endless)? + 2;
                continue;
            }
        };
        let mut inside = start + 2;
        while !template[inside..].starts_with(close) {
            let letter = template[inside..].chars().next().ok_or_else(endless)?;
            inside += match letter {
                '"' | '\'' | '`' => quoted(&template[inside..]).ok_or_else(endless)?,
                other => other.len_utf8(),
            };
        }
        return Ok(Some(start..inside + 2));
    }
}

/// Length of a text in quotes with them.
fn quoted(text: &str) -> Option<usize> {
    let mut letters = text.char_indices();
    let (_, quote) = letters.next()?;
    let mut is_escaped = false;
    letters.find_map(|(at, letter)| {
        let ends = letter == quote && !is_escaped;
        is_escaped = letter == '\\' && !is_escaped;
        ends.then_some(at + quote.len_utf8())
    })
}

fn tokens(template: &str, inside: Range<usize>) -> Result<Vec<Placed<'_>>, Wrong> {
    let mut tokens = Vec::new();
    let mut at = inside.start;
    while at < inside.end {
        let rest = &template[at..inside.end];
        let word = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_');
        let word = &rest[..word.unwrap_or(rest.len())];
        let (token, length) = match rest.chars().next() {
            Some(c) if c.is_ascii_whitespace() => {
                at += 1;
                continue;
            }
            Some('"' | '\'' | '`') => (Some(Token::Literal), quoted(rest).unwrap_or(rest.len())),
            Some(c) if c.is_ascii_digit() => (Some(Token::Literal), word.len()),
            Some(_) if matches!(word, "true" | "false") => (Some(Token::Literal), word.len()),
            Some(_) if !word.is_empty() => (Some(Token::Word(word)), word.len()),
            other => {
                let sign = SIGNS.iter().find(|sign| rest.starts_with(**sign));
                let length = other.map_or(1, char::len_utf8);
                (sign.map(|sign| Token::Sign(sign)), sign.map_or(length, |sign| sign.len()))
            }
        };
        let span = at..at + length;
        match token {
            Some(token) => tokens.push((token, span.clone())),
            None => return Err(wrong(span.clone(), &format!("`{}`", &template[span]))),
        }
        at = span.end;
    }
    // What is left of `{{-` and `-%}`.
    if matches!(tokens.first(), Some((Token::Sign("-"), _))) {
        tokens.remove(0);
    }
    if matches!(tokens.last(), Some((Token::Sign("-"), _))) {
        tokens.pop();
    }
    Ok(tokens)
}

/// Refuses what no layout needs.
fn check(tokens: &[Placed<'_>], is_print: bool) -> Result<(), Wrong> {
    let in_for = !is_print && matches!(tokens.first(), Some((Token::Word("for"), _)));
    let token = |index: Option<usize>| index.and_then(|index| tokens.get(index)).map(|(t, _)| t);
    for (index, (own, span)) in tokens.iter().enumerate() {
        let before = token(index.checked_sub(1));
        let after = token(Some(index + 1));
        let of_list = |word: &str, words: &[&str]| words.contains(&word);
        let refused = match own {
            Token::Sign("-") => Some("`-`".to_string()),
            Token::Sign("(") => match before {
                Some(Token::Word(word))
                    if !of_list(word, &GROUPING) && !of_list(word, &FILTERS) =>
                {
                    Some(format!("`{word}(…)`"))
                }
                _ => None,
            },
            Token::Sign(sign) if of_list(sign, &COMPARING) => {
                let with_literal = [before, after].contains(&Some(&Token::Literal));
                (!with_literal).then(|| format!("`{sign}` between two names"))
            }
            Token::Word(word) if before == Some(&Token::Sign("|")) => {
                (!of_list(word, &FILTERS)).then(|| format!("the filter `{word}`"))
            }
            Token::Word("in") if !in_for => Some("`in`".to_string()),
            Token::Word(word) if word.starts_with("__") => Some(format!("`{word}`")),
            _ => None,
        };
        if let Some(found) = refused {
            return Err(wrong(span.clone(), &found));
        }
    }
    Ok(())
}

/// First and last name of the list of `for name in path`, which says nothing else.
fn list_of(tokens: &[Placed<'_>], tag: Range<usize>) -> Result<(String, String), Wrong> {
    let words: Vec<&Token<'_>> = tokens.iter().map(|(token, _)| token).collect();
    let path = match words.as_slice() {
        [Token::Word("for"), Token::Word(_), Token::Word("in"), path @ ..] => path,
        _ => return Err(wrong(tag, "this loop")),
    };
    let is_path = path.iter().enumerate().all(|(index, token)| match token {
        Token::Word(_) => index % 2 == 0,
        Token::Sign(".") => index % 2 == 1,
        _ => false,
    });
    match (path.first(), path.last()) {
        (Some(Token::Word(first)), Some(Token::Word(last))) if is_path => {
            Ok(((*first).to_string(), (*last).to_string()))
        }
        _ => Err(wrong(tag, "this loop")),
    }
}

fn wrong(span: Range<usize>, found: &str) -> Wrong {
    Wrong { span, message: format!("{found} is more than a layout needs") }
}
