//! What holds of every text that the program makes, whatever went in.

/// The text of a file, also of one in UTF-16 whose letters are all ASCII (little end first), as some controls want it.
pub fn text(bytes: &[u8]) -> String {
    let (pairs, rest) = bytes.as_chunks::<2>();
    if !pairs.is_empty() && rest.is_empty() && pairs.iter().all(|pair| pair[1] == 0) {
        return pairs.iter().map(|pair| char::from(pair[0])).collect();
    }
    String::from_utf8_lossy(bytes).into_owned()
}

/// What is wrong with a text; `input` = what it was made from, whose own words may stand in it.
pub fn judge(text: &str, input: &[u8]) -> Result<(), String> {
    // Nearly every text is long and has none of the bytes with which such a character begins.
    let may_be = |byte: u8| {
        byte < 0x20 && !b"\n\r\t".contains(&byte)
            || matches!(byte, 0x7f | 0xc2 | 0xcd | 0xd8 | 0xe1..=0xe3 | 0xef | 0xf0 | 0xf3)
    };
    let control = || text.chars().find(|c| is_control(*c));
    if let Some(found) = text.bytes().any(may_be).then(control).flatten() {
        return Err(format!("control character in the output: {:?}", around(text, found)));
    }
    // A control character or joiner is left out of a message, and the letters beside it come together.
    let own = || {
        let own = String::from_utf8_lossy(input).to_ascii_lowercase();
        let stays =
            |c: &char| "\n\r\t".contains(*c) || !c.is_control() && !"\u{200c}\u{200d}".contains(*c);
        own.chars().filter(stays).collect::<String>()
    };
    for word in ["NaN", "inf", "Infinity"] {
        let is_number = |(at, _): (usize, &str)| {
            let (before, after) = (&text[..at], &text[at + word.len()..]);
            let is_part = |c: Option<char>| c.is_some_and(|c| c.is_ascii_alphanumeric());
            // "expected `inf`" is a sentence about the language of jobs, no figure.
            let is_key = word == "inf" && before.ends_with('`') && after.starts_with('`');
            !is_key && !is_part(before.chars().next_back()) && !is_part(after.chars().next())
        };
        if text.match_indices(word).any(is_number) && !own().contains(&word.to_ascii_lowercase()) {
            return Err(format!("no number in the output: {word}"));
        }
    }
    Ok(())
}

/// No cell of a file for spreadsheets is taken for a formula: `=` or `@` at its beginning, or a sign before anything
/// but numbers.
pub fn judge_cells(text: &str) -> Result<(), String> {
    for cell in text.split(['\n', '\r', ',', ';', '\t']) {
        let cell = cell.trim_matches(['"', ' ']);
        let is_signed = cell.starts_with(['+', '-', '＋', '－']) && cell.chars().count() > 1;
        let is_number = |word: &str| word.parse().is_ok_and(f64::is_finite);
        let is_formula = cell.starts_with(['=', '@', '＝', '＠'])
            || is_signed && !cell.split_whitespace().all(is_number);
        if is_formula {
            return Err(format!(
                "a spreadsheet calculates the cell {:?}",
                cell.chars().take(40).collect::<String>()
            ));
        }
    }
    Ok(())
}

/// Characters that change what a terminal shows, that nobody sees, or that a reader of lines counts as a line end.
fn is_control(c: char) -> bool {
    let turns =
        matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let is_unseen =
        matches!(c, '\u{ad}' | '\u{61c}' | '\u{200b}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
            || matches!(c, '\u{fe00}'..='\u{fe0f}' | '\u{e0000}'..='\u{e0fff}')
            || matches!(c, '\u{34f}' | '\u{115f}' | '\u{1160}' | '\u{3164}' | '\u{ffa0}')
            || matches!(c, '\u{180b}'..='\u{180f}' | '\u{1d173}'..='\u{1d17a}');
    let ends_a_line = matches!(c, '\u{2028}' | '\u{2029}');
    c.is_control() && !"\n\r\t".contains(c) || turns || is_unseen || ends_a_line
}

/// A character, with what stands before it.
fn around(text: &str, found: char) -> String {
    let until = text.find(found).unwrap_or(0) + found.len_utf8();
    let near: Vec<char> = text[..until].chars().rev().take(20).collect();
    near.into_iter().rev().collect()
}
