//! A line of a Siemens program: `X=IC(5)`, `CR=10`, `R1=R2+5`, `TRANS X10`, `MCALL CYCLE81(…)`.
//!
//! It becomes the same block as a line of another control, so all that follows is the same: `CR` is the letter R, the
//! words are G words by their number in [`codes`](super::codes).

use crate::block::{Block, CycleCall};
use crate::codes::{SIEMENS_CYCLES, named_word};
use crate::expression::Reader;
use crate::flow::{Statement, behind_number, set};
use crate::grammar::SIEMENS;
use crate::scan::{Counts, Word};
use crate::variables::Variables;
use crate::wrong::Wrong;

/// Arguments of a call; CYCLE83 has twelve that are executed.
const MOST_ARGUMENTS: usize = 40;
/// A call whose first argument says how far the control may leave the path.
const TOLERANCE: &str = "CYCLE832";
/// Calls that only show something, and that one.
const SHOWS: [&str; 5] = ["MSG", "WORKPIECE", "GROUP_BEGIN", "GROUP_END", TOLERANCE];
const HELP: &str = "docs/path.md lists the words of Siemens programs that are executed";

/// Whether a line sets R parameters, and where that begins.
pub(super) fn begin(line: &[u8]) -> Option<usize> {
    let at = behind_number(line);
    let is_r = matches!(line.get(at)?, b'R' | b'r');
    (is_r && line.get(at + 1)?.is_ascii_digit()).then_some(at)
}

/// Sets them.
pub(super) fn statement(
    line: &[u8],
    at: usize,
    variables: &mut Variables,
) -> Result<Statement, Wrong> {
    set(line, at, &SIEMENS, variables)
}

/// Takes the words of a line in place of the former ones of a block, to the first that is wrong.
pub(super) fn read(block: &mut Block, line: &[u8], variables: &Variables) {
    let Some(line) = block.begin(line) else {
        return;
    };
    if let Err(wrong) = words(line, variables, block) {
        block.wrong.push(wrong);
    }
}

fn words(line: &[u8], variables: &Variables, block: &mut Block) -> Result<(), Wrong> {
    let mut reader = Reader::new(line, 0, &SIEMENS, variables);
    while let Some(sign) = reader.peek() {
        let start = reader.at;
        match sign {
            b';' => return Ok(()),
            b'%' => {
                block.take(sign_word(b'%', start));
                return Ok(());
            }
            b'/' => {
                reader.at += 1;
                while reader.line.get(reader.at).is_some_and(u8::is_ascii_digit) {
                    reader.at += 1;
                }
                block.take(sign_word(b'/', start));
            }
            b'A'..=b'Z' | b'_' | b'$' => item(&mut reader, block)?,
            _ => {
                let message = "a sign that begins no word, expected a letter";
                return Err(reader.wrong(message, "text belongs behind `;`"));
            }
        }
    }
    Ok(())
}

fn sign_word(letter: u8, start: usize) -> Word {
    Word { letter, value: 0.0, has_point: false, counts: Counts::AsActive, start, end: start + 1 }
}

/// The letters, digits and `_` that stand next.
fn identifier(reader: &mut Reader<'_>) -> String {
    reader.peek();
    let rest = reader.line[reader.at..].iter();
    let is_in = |byte: &&u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'$');
    let signs = rest.take_while(is_in);
    signs.map(|byte| char::from(byte.to_ascii_uppercase())).collect()
}

/// A word or a call.
fn item(reader: &mut Reader<'_>, block: &mut Block) -> Result<(), Wrong> {
    let start = reader.at;
    let letters = reader.letters();
    let next = reader.line.get(start + 1);
    let is_name = next.is_some_and(|byte| byte.is_ascii_alphabetic() || *byte == b'_');
    if !is_name && letters.len() == 1 {
        reader.at += 1;
        return letter(reader, block, start);
    }
    let name = identifier(reader);
    reader.at += name.len();
    let span = (start, reader.at);
    if name == "CR" && reader.peek() == Some(b'=') {
        return value(reader, block, b'R', start);
    }
    if name == "ADIS" && reader.takes(b'=') {
        let mm = reader.expression()?;
        block.adis = Some(mm);
        return Ok(());
    }
    if name == "MCALL" {
        return cycle(reader, block, true, start);
    }
    if SIEMENS_CYCLES.iter().any(|(known, ..)| *known == name) {
        reader.at = start;
        return cycle(reader, block, false, start);
    }
    if SHOWS.contains(&name.as_str()) {
        reader.peek();
        let mut arguments = Reader::new(reader.line, reader.at + 1, &SIEMENS, reader.variables);
        let tolerance = arguments.expression().ok().filter(|_| name == TOLERANCE);
        block.adis = tolerance.or(block.adis);
        return passed_over(reader, span);
    }
    match named_word(&name) {
        Some(number) => block.take_named(number, span),
        None => return Err(Wrong::new(span, format!("`{name}` is not executed"), HELP)),
    }
    Ok(())
}

/// `X10`, `X=R1+5`, `S1=1000`, `T="DRILL"`.
fn letter(reader: &mut Reader<'_>, block: &mut Block, start: usize) -> Result<(), Wrong> {
    let letter = reader.line[start].to_ascii_uppercase();
    match reader.peek() {
        Some(b'=') => value(reader, block, letter, start),
        Some(b'0'..=b'9' | b'.' | b'+' | b'-') => {
            let number = reader.primary()?;
            if reader.takes(b'=') {
                return extended(reader, letter, number, start);
            }
            if letter == b'L' {
                let message = format!("`L{number}` calls a subprogram, which is not executed");
                return Err(Wrong::new((start, reader.at), message, HELP));
            }
            put(reader, block, letter, number, start, Counts::AsActive);
            Ok(())
        }
        _ => Err(Wrong::new(
            (start, start + 1),
            format!("`{}` has no number", char::from(letter)),
            "write it like `X10.5` or `X=R1+5`",
        )),
    }
}

/// `S2=1000`, `M2=3`, `H1=5` are those of another spindle, without effect on the path.
fn extended(reader: &mut Reader<'_>, letter: u8, number: f64, start: usize) -> Result<(), Wrong> {
    if matches!(letter, b'S' | b'M' | b'H') {
        return reader.expression().map(|_| ());
    }
    let message = format!("`{}{number}=` is not executed", char::from(letter));
    Err(Wrong::new(
        (start, reader.at),
        message,
        "axes are X, Y and Z; set R parameters in a line of their own",
    ))
}

/// What stands behind `=`.
fn value(
    reader: &mut Reader<'_>,
    block: &mut Block,
    letter: u8,
    start: usize,
) -> Result<(), Wrong> {
    reader.takes(b'=');
    if letter == b'T' && reader.peek() == Some(b'"') {
        return tool_name(reader, block, start);
    }
    let word = identifier(reader);
    let counts = match word.as_str() {
        "IC" => Counts::Incremental,
        "AC" => Counts::Absolute,
        "DC" | "ACP" | "ACN" | "CAC" | "CIC" | "CDC" | "CACP" | "CACN" => {
            let message =
                format!("`{word}( )` is not executed: it is for rotary and indexing axes");
            return Err(Wrong::new((start, reader.at + word.len()), message, HELP));
        }
        _ => Counts::AsActive,
    };
    if counts != Counts::AsActive {
        reader.at += word.len();
    }
    let number = match counts {
        Counts::AsActive => reader.expression()?,
        _ => reader.brackets()?,
    };
    if counts != Counts::AsActive && !b"XYZIJK".contains(&letter) {
        let message = format!("`{word}( )` is executed with X, Y, Z, I, J, K only");
        return Err(Wrong::new((start, reader.at), message, HELP));
    }
    put(reader, block, letter, number, start, counts);
    Ok(())
}

fn put(
    reader: &Reader<'_>,
    block: &mut Block,
    letter: u8,
    value: f64,
    start: usize,
    counts: Counts,
) {
    block.take(Word { letter, value, has_point: true, counts, start, end: reader.at });
}

/// The text between quotation marks.
fn quoted(reader: &mut Reader<'_>) -> Result<String, Wrong> {
    let start = reader.at;
    let rest = &reader.line[start + 1..];
    let Some(length) = rest.iter().position(|byte| *byte == b'"') else {
        return Err(Wrong::new((start, start + 1), "the text is not closed", "close it with `\"`"));
    };
    reader.at = start + length + 2;
    Ok(String::from_utf8_lossy(&rest[..length]).trim().to_string())
}

fn tool_name(reader: &mut Reader<'_>, block: &mut Block, start: usize) -> Result<(), Wrong> {
    let name = quoted(reader)?;
    block.tool_name = Some((name, (start, reader.at)));
    Ok(())
}

/// Arguments of a call that only shows something.
fn passed_over(reader: &mut Reader<'_>, span: (usize, usize)) -> Result<(), Wrong> {
    let mut depth = 0_usize;
    while let Some(sign) = reader.peek() {
        match sign {
            b'"' => {
                quoted(reader)?;
                continue;
            }
            b'(' => depth += 1,
            b')' => depth = depth.saturating_sub(1),
            _ if depth == 0 => break,
            _ => {}
        }
        reader.at += 1;
        if depth == 0 {
            return Ok(());
        }
    }
    Err(Wrong::new(span, "the brackets of the call are not closed", "close them with `)`"))
}

/// `CYCLE81(…)`, behind `MCALL` too; it stands in a block of its own.
fn cycle(
    reader: &mut Reader<'_>,
    block: &mut Block,
    modal: bool,
    start: usize,
) -> Result<(), Wrong> {
    let name = identifier(reader);
    let place = reader.at;
    reader.at += name.len();
    let span = (start, reader.at);
    let known = SIEMENS_CYCLES.iter().find(|(known, ..)| *known == name);
    let cycle = match known {
        Some((_, number, most)) => {
            let arguments = arguments(reader)?;
            if arguments.iter().skip(*most).any(Option::is_some) {
                let message = format!("`{name}` is executed with its first {most} arguments only");
                return Err(Wrong::new(span, message, "leave out what stands behind them"));
            }
            Some((*number, arguments))
        }
        None if name.is_empty() => None,
        None => {
            let message = format!("`{name}` is not executed");
            return Err(Wrong::new((place, span.1), message, HELP));
        }
    };
    if !matches!(reader.peek(), None | Some(b';')) || !block.is_empty() {
        let help = "write MCALL and the call of the cycle in a line of their own";
        return Err(Wrong::new(span, "words beside the call of a cycle", help));
    }
    block.cycle = Some(CycleCall { modal, cycle, span });
    Ok(())
}

/// `(5, , R1)`: what is left out is missing.
fn arguments(reader: &mut Reader<'_>) -> Result<Vec<Option<f64>>, Wrong> {
    let mut arguments = Vec::new();
    if !reader.takes(b'(') {
        return Err(reader.wrong("expected `(` with the arguments here", HELP));
    }
    while arguments.len() < MOST_ARGUMENTS {
        let is_left_out = matches!(reader.peek(), Some(b',' | b')'));
        let argument = if is_left_out { None } else { Some(reader.expression()?) };
        arguments.push(argument);
        if reader.takes(b')') {
            return Ok(arguments);
        }
        if !reader.takes(b',') {
            return Err(reader.wrong("expected `,` or `)` here", HELP));
        }
    }
    Err(reader.wrong("the call has too many arguments", HELP))
}
