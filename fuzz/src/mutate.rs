//! New inputs from old ones: bytes, words, numbers, lines, and parts of two inputs.

use crate::bundle::Bundle;
use crate::random::Random;

/// Longer inputs are cut: what goes wrong does so in short ones, and they are faster.
const LONGEST: usize = 48 << 10;

/// Values that readers trip over, and bytes that no control may see.
const NASTY: &[&str] = &[
    "0",
    "-0",
    "-0.0",
    "1",
    "-1",
    "0.1",
    "1e-9",
    "1e9",
    "1e308",
    "-1e308",
    "1e-320",
    "1e999",
    "nan",
    "inf",
    "-inf",
    "0.0000000001",
    "255",
    "256",
    "-32768",
    "65535",
    "2147483647",
    "-2147483648",
    "4294967296",
    "9223372036854775807",
    "18446744073709551616",
    "999999999",
    "1,5",
    "1_000",
    "0x10",
    "+5",
    ".5",
    "5.",
    "''",
    "\"\"",
    "\"\"\"",
    "[]",
    "{}",
    "[[x]]",
    "\u{feff}",
    "\0",
    "\u{1b}[2J",
    "\u{202e}",
    "\u{2028}",
    "\u{85}",
    "\u{a0}",
    "ä",
    "\r",
    "\r\n",
    "\n\r\r",
    "\t",
    ";",
    "%",
    "(",
    ")",
    "$",
    "=",
    ",",
    "#",
    "/",
    "..",
    "STOPRE",
    "NEWCONF",
    "M30",
    "M17",
    "M99",
    "CHANDATA(2)",
    "$AN_CEC[0,0]=1",
    "{{ ",
    " }}",
    "{% ",
    " %}",
    "2026-02-30",
    "null",
    "true",
    "-",
    "--",
    "\u{fffd}",
    "𝟙",
    "٣",
    "(?<axis>.).*",
    ".*",
    "[^a]",
    "(?i)",
];

/// The classes of letters, each by its first and its last: controls of one and of two bytes, of one to four bytes, longer
/// in lower case, joined, turned, invisible, private, none, and what begins a formula.
const LETTERS: [(char, char); 29] = [
    ('\u{1}', '\u{1f}'),
    ('\u{7f}', '\u{9f}'),
    ('é', 'é'),
    ('ß', 'ß'),
    ('€', '€'),
    ('Ａ', 'Ｚ'),
    ('\u{130}', '\u{130}'),
    ('ǆ', 'ǆ'),
    ('\u{300}', '\u{304}'),
    ('\u{5d0}', '\u{5ea}'),
    ('\u{200e}', '\u{200f}'),
    ('\u{202a}', '\u{202e}'),
    ('\u{200b}', '\u{200d}'),
    ('\u{feff}', '\u{feff}'),
    ('\u{ad}', '\u{ad}'),
    ('\u{34f}', '\u{34f}'),
    ('\u{115f}', '\u{1160}'),
    ('\u{180b}', '\u{180f}'),
    ('\u{1d173}', '\u{1d17a}'),
    ('😀', '😄'),
    ('\u{e000}', '\u{f8ff}'),
    ('\u{10fffe}', '\u{10ffff}'),
    ('\u{e0041}', '\u{e005a}'),
    ('=', '='),
    ('@', '@'),
    ('+', '+'),
    ('＝', '＝'),
    ('\u{2000}', '\u{200a}'),
    ('\u{2800}', '\u{2800}'),
];

/// Words that stand in the inputs of a target.
#[derive(Default)]
pub struct Dictionary(Vec<Vec<u8>>);

impl Dictionary {
    /// The words of texts; each once, in order.
    pub fn of<'a>(texts: impl IntoIterator<Item = &'a [u8]>) -> Dictionary {
        let mut words: Vec<Vec<u8>> = NASTY.iter().map(|word| word.as_bytes().to_vec()).collect();
        for text in texts {
            words.extend(spans(text, is_word).map(|(start, end)| text[start..end].to_vec()));
        }
        words.retain(|word| (1..=40).contains(&word.len()));
        words.sort();
        words.dedup();
        Dictionary(words)
    }
}

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || b"_$-+.".contains(&byte) || byte >= 128
}

fn is_number(byte: u8) -> bool {
    byte.is_ascii_digit() || b"+-.".contains(&byte)
}

fn is_of_line(byte: u8) -> bool {
    byte != b'\n'
}

/// The runs of bytes of a kind.
fn spans(text: &[u8], is: fn(u8) -> bool) -> impl Iterator<Item = (usize, usize)> {
    let mut at = 0;
    std::iter::from_fn(move || {
        let start = at + text[at..].iter().position(|byte| is(*byte))?;
        at = text[start..]
            .iter()
            .position(|byte| !is(*byte))
            .map_or(text.len(), |length| start + length);
        Some((start, at))
    })
}

/// One of the runs, drawn.
fn one(random: &mut Random, text: &[u8], is: fn(u8) -> bool) -> Option<(usize, usize)> {
    let near = random.below(text.len());
    let from = text[..near].iter().rposition(|byte| !is(*byte)).map_or(0, |at| at + 1);
    spans(&text[from..], is).next().map(|(start, end)| (from + start, from + end))
}

/// A new input from one, with parts of another; several changes at once, few more often than many.
pub fn mutated(random: &mut Random, input: &[u8], other: &[u8], words: &Dictionary) -> Vec<u8> {
    let mut text = input.to_vec();
    if input.starts_with(COMMAND) && random.one_in(16) {
        match random.one_in(2) {
            true => change_command(random, &mut text, write_over_input),
            false => change_command(random, &mut text, |r, command, files| {
                one_more_option(r, command, files, words)
            }),
        }
        return text;
    }
    let changes = 1 << random.below(4);
    for _ in 0..changes {
        change(random, &mut text, other, words);
        text.truncate(LONGEST); // before a part of it is repeated once more
    }
    text
}

fn change(random: &mut Random, text: &mut Vec<u8>, other: &[u8], words: &Dictionary) {
    match random.below(13) {
        0 => change_byte(random, text),
        1 => replace_span(random, text, |random, _| vec![(random.bits() & 0xff) as u8]),
        2 => replace_span(random, text, |_, _| Vec::new()),
        3 => replace_span(random, text, |random, part| part.repeat(1 + random.below(3))),
        4 => repeat(random, text),
        5 | 6 => replace(random, text, is_word, |random, _| random.pick(&words.0).clone()),
        7 => replace(random, text, is_number, |random, _| random.pick(NASTY).as_bytes().to_vec()),
        8 => replace(random, text, is_number, nearby),
        9 => insert(random, text, words),
        10 => lines(random, text),
        11 => letter(random, text),
        _ => splice(random, text, other),
    }
}

fn change_byte(random: &mut Random, text: &mut [u8]) {
    let at = random.below(text.len());
    if let Some(byte) = text.get_mut(at) {
        match random.one_in(2) {
            true => *byte ^= 1 << random.below(8),
            false => *byte = *random.pick(b"\n\r\t ,;.-+=[](){}%$#\"'0123456789eE\x00\x1b\xff"),
        }
    }
}

fn replace_span(
    random: &mut Random,
    text: &mut Vec<u8>,
    new: impl Fn(&mut Random, &[u8]) -> Vec<u8>,
) {
    let (start, end) = random.span(text.len());
    let new = new(random, &text[start..end]);
    text.splice(start..end, new);
}

/// A part many times, so that something grows.
fn repeat(random: &mut Random, text: &mut Vec<u8>) {
    if !random.one_in(8) {
        return;
    }
    let Some((start, end)) = one(random, text, is_of_line) else {
        return;
    };
    let end = (end + 1).min(text.len());
    let many = text[start..end].repeat(1 << random.below(9));
    text.splice(start..end, many);
}

fn replace(
    random: &mut Random,
    text: &mut Vec<u8>,
    is: fn(u8) -> bool,
    new: impl Fn(&mut Random, &[u8]) -> Vec<u8>,
) {
    if let Some((start, end)) = one(random, text, is) {
        let new = new(random, &text[start..end]);
        text.splice(start..end, new);
    }
}

/// A number near by, or the other sign, or another power of ten.
fn nearby(random: &mut Random, number: &[u8]) -> Vec<u8> {
    let text = String::from_utf8_lossy(number);
    let Ok(value) = text.parse::<f64>() else {
        return number.to_vec();
    };
    let near = match random.below(6) {
        0 => value + 1.0,
        1 => value - 1.0,
        2 => -value,
        3 => value * 10.0,
        4 => value / 10.0,
        _ => value + (random.below(2001) as f64 - 1000.0) / 1000.0,
    };
    near.to_string().into_bytes()
}

fn insert(random: &mut Random, text: &mut Vec<u8>, words: &Dictionary) {
    let at = random.below(text.len() + 1);
    let word = random.pick(&words.0).clone();
    text.splice(at..at, word);
}

/// A letter of some class in or beside a word.
fn letter(random: &mut Random, text: &mut Vec<u8>) {
    let Some((start, end)) = one(random, text, is_word) else {
        return;
    };
    let at = start + random.below(end - start + 1);
    let until = (at + random.below(2)).min(end);
    let (first, last) = *random.pick(&LETTERS);
    let class = u32::from(first)..=u32::from(last);
    let drawn = first as u32 + random.below(class.count()) as u32;
    let drawn = char::from_u32(drawn).unwrap_or(first);
    text.splice(at..until, drawn.to_string().bytes());
}

/// How a bundle with a command begins.
const COMMAND: &[u8] = b"=== command\n";

/// Another command with the same files.
fn change_command(
    random: &mut Random,
    text: &mut Vec<u8>,
    changed: impl FnOnce(&mut Random, Vec<String>, &[String]) -> Vec<String>,
) {
    let mut bundle = Bundle::read(text);
    let files: Vec<String> = bundle.0.iter().skip(1).map(|(name, _)| name.clone()).collect();
    if let Some((_, command)) = bundle.0.first_mut().filter(|_| !files.is_empty()) {
        let words = String::from_utf8_lossy(command).split(' ').map(String::from).collect();
        *command = changed(random, words, &files).join(" ").into_bytes();
        *text = bundle.bytes();
    }
}

/// A command writes over one of its files.
fn write_over_input(random: &mut Random, mut words: Vec<String>, files: &[String]) -> Vec<String> {
    if let Some(option) = words.iter().position(|word| word == "-o")
        && let Some(output) = words.get_mut(option + 1)
    {
        output.clone_from(random.pick(files));
    }
    if random.one_in(2) && !words.iter().any(|word| word == "--force") {
        words.push("--force".into());
    }
    words
}

/// A command gets one more of the options that its help names, with a file, a word or something nasty behind it.
fn one_more_option(
    random: &mut Random,
    mut words: Vec<String>,
    files: &[String],
    known: &Dictionary,
) -> Vec<String> {
    let help = nonius::cli::answer(&nonius::visit::files::Memory::default(), [&*words[0], "-h"]);
    let help = String::from_utf8_lossy(&help.out).into_owned();
    let options: Vec<&str> = help.lines().map(str::trim).filter(|l| l.starts_with('-')).collect();
    if options.is_empty() {
        return words;
    }
    let mut option = random.pick(&options).split(' ').skip_while(|word| !word.starts_with("--"));
    words.extend(option.next().map(String::from));
    if option.next().is_some_and(|value| value.starts_with('<')) {
        words.push(match random.below(3) {
            0 => random.pick(files).clone(),
            1 => random.pick(NASTY).to_string(),
            _ => String::from_utf8_lossy(random.pick::<Vec<u8>>(&known.0)).into_owned(),
        });
    }
    words
}

impl Random {
    /// A place in a text and one behind it, mostly near.
    pub fn span(&mut self, length: usize) -> (usize, usize) {
        let start = self.below(length + 1);
        let most = if self.one_in(4) { length } else { 32 };
        let end = start + self.below(most.min(length - start) + 1);
        (start, end)
    }
}

/// Bytes of a part that is neither word nor line.
const LONGEST_PART: usize = 16;

/// The same input twice with one to three of its lines, words or other parts as many times each, so that the second is about
/// `size` long and the first half of that; of several, what belongs together grows together.
pub fn grown(random: &mut Random, input: &[u8], size: usize) -> Option<[Vec<u8>; 2]> {
    if input.is_empty() {
        return None;
    }
    let mut parts = Vec::new();
    for _ in 0..1 + random.below(3) {
        parts.push(match random.below(4) {
            0 => one(random, input, is_word)?,
            1 => {
                let from = random.below(input.len());
                (from, input.len().min(from + 1 + random.below(LONGEST_PART)))
            }
            _ => {
                one(random, input, is_of_line).map(|(from, to)| (from, input.len().min(to + 1)))?
            }
        });
    }
    parts.sort_unstable();
    parts.dedup_by(|next, last| next.0 < last.1);
    let count = size / parts.iter().map(|(from, to)| to - from).sum::<usize>();
    let with = |count: usize| {
        let (mut all, mut at) = (Vec::new(), 0);
        for (from, to) in &parts {
            all.extend_from_slice(&input[at..*from]);
            all.extend(input[*from..*to].repeat(count));
            at = *to;
        }
        all.extend_from_slice(&input[at..]);
        all
    };
    Some([with(count / 2), with(count)])
}

/// A line twice, gone, or in another place.
fn lines(random: &mut Random, text: &mut Vec<u8>) {
    let Some((start, end)) = one(random, text, is_of_line) else {
        return;
    };
    let end = (end + 1).min(text.len());
    let line = text[start..end].to_vec();
    let kind = random.below(3);
    if kind > 0 {
        text.drain(start..end);
    }
    if kind < 2 {
        let to = one(random, text, is_of_line).map_or(0, |(start, _)| start);
        text.splice(to..to, line);
    }
}

/// A part of another input in the place of one of this.
fn splice(random: &mut Random, text: &mut Vec<u8>, other: &[u8]) {
    let (from, to) = random.span(other.len());
    let (start, end) = random.span(text.len());
    text.splice(start..end, other[from..to].iter().copied());
}
