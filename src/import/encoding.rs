//! Bytes → text. UTF-8 and UTF-16 show themselves; other encodings have to be stated.

use crate::document::Source;
use crate::import::Measurement;
use crate::import::stated::Encoding;
use crate::problem::{Place, Problem, Problems};
use encoding_rs::{GBK, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};

/// The text, and its encoding in words.
pub(super) fn decode(
    file: Measurement<'_>,
    stated: Option<Encoding>,
) -> Result<(Source, &'static str), Problems> {
    let (marked, word) = match encoding_rs::Encoding::for_bom(file.bytes) {
        Some((encoding, _)) if encoding == UTF_16LE || encoding == UTF_16BE => {
            (Some(encoding), "UTF-16 (byte order mark)")
        }
        Some(_) => (Some(UTF_8), "UTF-8 (byte order mark)"),
        None => (None, ""),
    };
    if let (Some(marked), Some(stated)) = (marked, stated)
        && (marked != UTF_8 || stated != Encoding::Utf8)
    {
        let message = format!(
            "`--encoding {}` contradicts `{}`, which begins with the mark of {}",
            stated.word(),
            file.path,
            marked.name()
        );
        return Err(Problem::new(message).help("leave `--encoding` out").into());
    }
    let (encoding, word) = match (marked, stated) {
        (Some(marked), _) => (marked, word),
        (None, Some(Encoding::Latin1)) => (WINDOWS_1252, "Latin-1, as stated"),
        (None, Some(Encoding::Gbk)) => (GBK, "GBK, as stated"),
        (None, _) => (UTF_8, "UTF-8"),
    };
    let (text, broken) = encoding.decode_with_bom_removal(file.bytes);
    if broken {
        return Err(wrong_bytes(file.path, &text, encoding.name()));
    }
    Ok((Source::from_bytes(file.path, text.as_bytes())?, word))
}

fn wrong_bytes(path: &str, text: &str, encoding: &str) -> Problems {
    let at = text.find('\u{fffd}').unwrap_or(0);
    let place = Place::in_text(path, text, at, at + '\u{fffd}'.len_utf8());
    Problem::new(format!("the file holds a letter that is not {encoding}"))
        .at(place)
        .help("state its encoding: `--encoding latin-1` (western Windows), `--encoding gbk` (Chinese Windows) or `--encoding utf-8`")
        .into()
}
