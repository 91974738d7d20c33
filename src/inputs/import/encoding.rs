//! Bytes → text. UTF-8 and marked UTF-16 show themselves; other encodings have to be stated.

use crate::inputs::import::Measurement;
use crate::inputs::import::choices::Encoding;
use crate::text::document::Source;
use crate::text::problem::{Place, Problem, Problems};
use encoding_rs::{GBK, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1250, WINDOWS_1252};

/// The text, and its encoding in words.
pub(super) fn decode(
    file: Measurement<'_>,
    stated: Option<Encoding>,
) -> Result<(Source, String), Problems> {
    let marked = encoding_rs::Encoding::for_bom(file.bytes).map(|(encoding, _)| encoding);
    if let (Some(marked), Some(stated)) = (marked, stated)
        && marked != codec(stated)
    {
        let message = format!(
            "`--encoding {}` contradicts `{}`, which begins with the mark of {}",
            stated.word(),
            file.path,
            marked.name()
        );
        return Err(Problem::new(message).help("leave `--encoding` out").into());
    }
    if let (None, None, Some(order)) = (marked, stated, unmarked_utf_16(file.bytes)) {
        return Err(Problem::new(format!(
            "`{}` looks like UTF-16 without its mark: every second byte is zero",
            file.path
        ))
        .help(format!("state its encoding: `--encoding {}`", order.word()))
        .into());
    }
    let encoding = marked.or(stated.map(codec)).unwrap_or(UTF_8);
    let (text, broken) = encoding.decode_with_bom_removal(file.bytes);
    if broken {
        return Err(wrong_bytes(file.path, &text, encoding));
    }
    let known_by = match (marked, stated) {
        (Some(_), _) => " (byte order mark)",
        (None, Some(_)) => ", as stated",
        (None, None) => "",
    };
    let word = format!("{}{known_by}", encoding.name());
    Ok((Source::from_bytes(file.path, text.as_bytes())?, word))
}

fn codec(encoding: Encoding) -> &'static encoding_rs::Encoding {
    match encoding {
        Encoding::Utf8 => UTF_8,
        Encoding::Utf16Le => UTF_16LE,
        Encoding::Utf16Be => UTF_16BE,
        Encoding::Windows1252 => WINDOWS_1252,
        Encoding::Windows1250 => WINDOWS_1250,
        Encoding::Gbk => GBK,
    }
}

/// Latin letters and digits in UTF-16 have a zero byte each, behind or before the other one.
fn unmarked_utf_16(bytes: &[u8]) -> Option<Encoding> {
    const LOOKED_AT: usize = 512;
    let pairs = || bytes.chunks_exact(2).take(LOOKED_AT);
    let zeros = |at: usize| {
        pairs()
            .filter(|pair| pair[at] == 0 && pair[1 - at] != 0)
            .count()
    };
    let most = |count: usize| count > 0 && count * 4 > pairs().len() * 3;
    match (zeros(0), zeros(1)) {
        (_, behind) if most(behind) => Some(Encoding::Utf16Le),
        (before, _) if most(before) => Some(Encoding::Utf16Be),
        _ => None,
    }
}

fn wrong_bytes(path: &str, text: &str, encoding: &'static encoding_rs::Encoding) -> Problems {
    let at = text.find('\u{fffd}').unwrap_or(0);
    let place = Place::in_text(path, text, at, at + '\u{fffd}'.len_utf8());
    let others: Vec<String> = OFTEN_MET
        .into_iter()
        .filter(|(other, _)| codec(*other) != encoding)
        .map(|(other, users)| format!("`--encoding {}` ({users})", other.word()))
        .collect();
    Problem::new(format!(
        "the file holds a letter that is not {}",
        encoding.name()
    ))
    .at(place)
    .help(format!("state its encoding: {}", others.join(", ")))
    .into()
}

/// Encodings of instrument programs, and who writes them.
const OFTEN_MET: [(Encoding, &str); 4] = [
    (Encoding::Utf8, "newer programs"),
    (Encoding::Windows1252, "Windows in western Europe"),
    (Encoding::Windows1250, "Windows in central Europe"),
    (Encoding::Gbk, "Windows in China"),
];
