//! What a template may say, and how much work it is, before it is rendered.
//!
//! The engine bounds neither loops nor texts that grow (`{% set s = s ~ s %}` forty times is a terabyte), and
//! has no place to count them. So a template says what a layout needs and no more: names, loops over lists
//! of the context, choices. Then no value is longer than one of the context, each tag is done in a time that
//! does not depend on the lists, and how many tags are executed follows from the lengths of the lists.
//!
//! ```text
//!   template ─→ tags ─→ words, each allowed ─→ loops inside each other ─┐
//!   context  ─→ lengths of the lists ──────────────────────────────────┴─→ tags to be executed
//! ```

use std::ops::Range;

/// Filters whose work and whose result do not grow with a list.
const FILTERS: [&str; 7] = [
    "default", "first", "last", "length", "lower", "trim", "upper",
];
/// Words behind which a bracket groups; behind any other it would call a function.
const GROUPING: [&str; 5] = ["if", "elif", "and", "or", "not"];
const SIGNS: [&str; 13] = [
    "==", "!=", "<=", ">=", "<", ">", "=", ".", ",", "|", "(", ")", "-",
];
const COMPARING: [&str; 6] = ["==", "!=", "<=", ">=", "<", ">"];

/// Where a template says more than a layout.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Wrong {
    /// Bytes of the template.
    pub(super) span: Range<usize>,
    /// What was found and what was expected.
    pub(super) message: String,
}

/// The tags of a template, and its loops.
#[derive(Clone, Debug, Default)]
pub(super) struct Layout {
    tags: u64,
    loops: Vec<Loop>,
}

/// `{% for name in path %} … {% else %} … {% endfor %}`.
#[derive(Clone, Debug, Default)]
struct Loop {
    name: String,
    path: Vec<String>,
    body: Layout,
    /// What is done where the list is empty.
    otherwise: Layout,
}

/// What is open at a place of a template.
enum Open {
    Choice,
    Loop { begun: Loop, in_else: bool },
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
        let mut open = Vec::new();
        let mut whole = Layout::default();
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
            innermost(&mut whole, &mut open).tags += 1;
            match kind {
                "for" => open.push(Open::Loop {
                    begun: loop_of(&tokens, tag)?,
                    in_else: false,
                }),
                "if" => open.push(Open::Choice),
                "else" => {
                    if let Some(Open::Loop { in_else, .. }) = open.last_mut() {
                        *in_else = true;
                    }
                }
                "endfor" | "endif" => {
                    if let Some(Open::Loop { begun, .. }) = open.pop() {
                        innermost(&mut whole, &mut open).loops.push(begun);
                    }
                }
                "" | "elif" => {}
                other => return Err(wrong(tokens[0].1.clone(), &format!("`{other}`"))),
            }
        }
        Ok(whole)
    }

    /// Tags that rendering executes, at most: both branches of a choice count. `None` = more than `most`.
    pub(super) fn work(&self, context: &tera::Context, most: u64) -> Option<u64> {
        let mut scope = Scope {
            context,
            names: Vec::new(),
        };
        self.add(&mut scope, 0, most)
    }

    fn add<'a>(&'a self, scope: &mut Scope<'a>, done: u64, most: u64) -> Option<u64> {
        let mut done = done.checked_add(self.tags).filter(|done| *done <= most)?;
        for own in &self.loops {
            let list = scope.value(&own.path);
            let length = list.map_or(1, |list| list.len().unwrap_or(0));
            if length == 0 {
                done = own.otherwise.add(scope, done, most)?;
            } else if own.body.loops.is_empty() {
                let all = own.body.tags.checked_mul(length as u64)?;
                done = done.checked_add(all).filter(|done| *done <= most)?;
            } else {
                for item in items(list, length) {
                    scope.names.push((&own.name, item));
                    let added = own.body.add(scope, done, most);
                    scope.names.pop();
                    done = added?;
                }
            }
        }
        Some(done)
    }
}

/// What a loop goes over: the values of a list or of a map; of anything else they are not known.
fn items(
    list: Option<&tera::Value>,
    length: usize,
) -> Box<dyn Iterator<Item = Option<&tera::Value>> + '_> {
    let values = list.and_then(tera::Value::as_array).map(<[_]>::iter);
    match (values, list.and_then(tera::Value::as_map)) {
        (Some(values), _) => Box::new(values.map(Some)),
        (None, Some(map)) => Box::new(map.values().map(Some)),
        (None, None) => Box::new(std::iter::repeat_n(None, length)),
    }
}

/// The names that a tag sees.
struct Scope<'a> {
    context: &'a tera::Context,
    /// Of the loops around it; an item that is not known has no lists in it.
    names: Vec<(&'a str, Option<&'a tera::Value>)>,
}

impl<'a> Scope<'a> {
    /// `None` = not known: the engine refuses it, or it is a letter of a text.
    fn value(&self, path: &[String]) -> Option<&'a tera::Value> {
        let (first, rest) = path.split_first()?;
        let mut own = self.names.iter().rev();
        let root = match own.find(|(name, _)| name == first) {
            Some((_, item)) => (*item)?,
            None => self.context.get(first)?,
        };
        rest.iter().try_fold(root, |value, name| {
            let map = value.as_map()?;
            map.iter()
                .find_map(|(key, value)| (key.as_str() == Some(name)).then_some(value))
        })
    }
}

fn innermost<'a>(whole: &'a mut Layout, open: &'a mut [Open]) -> &'a mut Layout {
    let around = open.iter_mut().rev().find_map(|open| match open {
        Open::Choice => None,
        Open::Loop { begun, in_else } => Some(match in_else {
            true => &mut begun.otherwise,
            false => &mut begun.body,
        }),
    });
    around.unwrap_or(whole)
}

/// The next `{{ … }}` or `{% … %}` from `at` on, comments passed over; one that does not end is wrong.
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
                (
                    sign.map(|sign| Token::Sign(sign)),
                    sign.map_or(length, |sign| sign.len()),
                )
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

/// `for name in path`, and nothing else.
fn loop_of(tokens: &[Placed<'_>], tag: Range<usize>) -> Result<Loop, Wrong> {
    let words: Vec<&Token<'_>> = tokens.iter().map(|(token, _)| token).collect();
    let [
        Token::Word("for"),
        Token::Word(name),
        Token::Word("in"),
        path @ ..,
    ] = words.as_slice()
    else {
        return Err(wrong(tag, "this loop"));
    };
    let mut names = Vec::new();
    for (index, token) in path.iter().enumerate() {
        match token {
            Token::Word(word) if index % 2 == 0 => names.push((*word).to_string()),
            Token::Sign(".") if index % 2 == 1 => {}
            _ => return Err(wrong(tag, "this loop")),
        }
    }
    Ok(Loop {
        name: (*name).to_string(),
        path: names,
        ..Loop::default()
    })
}

fn wrong(span: Range<usize>, found: &str) -> Wrong {
    Wrong {
        span,
        message: format!("{found} is more than a layout needs"),
    }
}
