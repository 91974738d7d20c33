//! Texts of a Renishaw file: who measured what, and in which surroundings.

use crate::inputs::import::choices::MaterialCorrected;
use crate::inputs::import::lines::{Line, Word};
use crate::inputs::import::rtl_sections::Sections;
use crate::inputs::import::stated::{Stated, missing};
use crate::text::delimited::plain_number;
use crate::text::document::LARGEST_NUMBER;
use crate::text::problem::{Problem, Problems, shown};

/// Keys of USER-TEXT; several may share a line.
const USER_KEYS: [&str; 7] = [
    "Machine",
    "Serial No",
    "Date",
    "By",
    "Axis",
    "Location",
    "TITLE",
];

/// Key and value of USER-TEXT; fields may share a line.
fn user_fields<'a>(sections: &Sections<'a>) -> Vec<(&'static str, Word<'a>)> {
    let mut fields = Vec::new();
    for line in sections.lines("USER-TEXT").unwrap_or_default() {
        let mut starts: Vec<(usize, usize, &'static str)> = USER_KEYS
            .into_iter()
            .filter_map(|key| key_at(line.text, key).map(|(from, value)| (from, value, key)))
            .collect();
        starts.sort_unstable();
        for (index, (_, value, key)) in starts.iter().enumerate() {
            let end = starts.get(index + 1).map_or(line.text.len(), |next| next.0);
            if *value <= end {
                fields.push((*key, line.part(*value, end)));
            }
        }
    }
    fields
}

/// Where `key` followed by a colon begins as a word of its own, and where its value begins.
fn key_at(text: &str, key: &str) -> Option<(usize, usize)> {
    text.match_indices(key).find_map(|(at, _)| {
        let alone = !text[..at].ends_with(char::is_alphanumeric);
        let rest = &text[at + key.len()..];
        let colon = rest
            .trim_start()
            .starts_with(':')
            .then(|| rest.find(':'))??;
        alone.then_some((at, at + key.len() + colon + 1))
    })
}

pub(super) fn user_facts(sections: &Sections<'_>) -> Vec<String> {
    let fields = user_fields(sections).into_iter();
    fields
        .filter(|(key, value)| *key != "Axis" && !value.text.is_empty())
        .map(|(key, value)| format!("the file says: {key}: {}", shown(value.text)))
        .collect()
}

/// The axis that the file names; it must be the one that was stated.
pub(super) fn stated_axis(
    sections: &Sections<'_>,
    stated: &Stated,
    problems: &mut Problems,
) -> Option<String> {
    let fields = user_fields(sections);
    let (_, word) = fields.iter().find(|(key, _)| *key == "Axis")?;
    if word.text.is_empty() {
        return None;
    }
    let said = format!("the file says: Axis: {}", shown(word.text));
    let expected = stated.term.map(|term| term.along).or(stated.axis);
    let Some(letter) = only_letter(word.text) else {
        if stated.axis.is_none() {
            problems.push(
                missing(
                    "--axis",
                    &format!(
                        "the axis of the file is `{}`, which names none of X, Y, Z, or several",
                        shown(word.text)
                    ),
                    "add `--axis` with the axis that moved, the last letter of `--term`",
                )
                .at(word.place()),
            );
        }
        return Some(format!(
            "{said} (names none of X, Y, Z, or several; that of `--axis` is used)"
        ));
    };
    let Some(other) = expected.filter(|axis| axis.letter() != letter) else {
        return Some(said);
    };
    problems.push(
        Problem::new(format!(
            "the file says axis `{}`, but {other} was stated as the moving axis",
            shown(word.text)
        ))
        .at(word.place())
        .help("state the term of the axis that moved, or take the right file"),
    );
    None
}

/// The name of an axis that stands alone in a text such as `Linear Y` or `x-axis`.
fn only_letter(text: &str) -> Option<char> {
    let text = text.to_uppercase();
    let mut names: Vec<char> = text
        .split(|c: char| !c.is_alphabetic())
        .filter_map(|word| match word.as_bytes() {
            [letter] if b"ABCUVWXYZ".contains(letter) => Some(char::from(*letter)),
            _ => None,
        })
        .collect();
    names.dedup();
    match names[..] {
        [letter] => Some(letter),
        _ => None,
    }
}

/// What the instrument noted about air and material; without it, nothing.
fn environment<'a, 'b>(sections: &'b Sections<'a>) -> impl Iterator<Item = &'b Line<'a>> {
    let lines = sections.lines("ENVIRONMENT").unwrap_or_default().iter();
    lines.filter(|line| !line.is_blank())
}

pub(super) fn environment_facts(sections: &Sections<'_>) -> Vec<String> {
    environment(sections)
        .map(|line| format!("the file says: {}", shown(line.text.trim())))
        .collect()
}

/// The numbers of an environment line that are not zero: a sensor that is absent writes zeros.
fn noted(sections: &Sections<'_>, begins: &str) -> Vec<f64> {
    environment(sections)
        .filter_map(Line::key_value)
        .filter(|(key, _)| key.starts_with(begins))
        .flat_map(|(_, value)| {
            let words = value.text.split_whitespace();
            words.filter_map(plain_number).collect::<Vec<f64>>()
        })
        .filter(|number| *number != 0.0 && number.abs() <= LARGEST_NUMBER)
        .collect()
}

/// An expansion that is smaller than this is no reason to warn, µm.
const NOTABLE_UM: f64 = 1.0;
/// Reference temperature of lengths, °C (ISO 1).
const REFERENCE_C: f64 = 20.0;

/// Whether the expansion of the material was taken out cannot be seen in the file: where it notes
/// a temperature of the material it has to be stated (contract §2.3), and it is said what is at
/// stake: α·(T − 20 °C)·L, α of the file in µm/m per K, L = `length_mm`.
pub(super) fn material_words(
    sections: &Sections<'_>,
    stated: &Stated,
    length_mm: f64,
    problems: &mut Problems,
) -> Vec<String> {
    let temperatures = noted(sections, "mattemp");
    let from_20 = |c: &&f64| (**c - REFERENCE_C).abs();
    let farthest = temperatures
        .iter()
        .max_by(|a, b| from_20(a).total_cmp(&from_20(b)));
    let Some(celsius) = farthest else {
        return Vec::new();
    };
    let Some(corrected) = stated.material_corrected else {
        problems.push(
            missing(
                "--material-corrected",
                &format!("the file notes a material temperature of {celsius} °C, but not whether the readings were brought to 20 °C"),
                "add `--material-corrected yes` (the instrument did it), `no`, or `not-stated`",
            )
            .at(sections.place_of("ENVIRONMENT", "mattemp")),
        );
        return Vec::new();
    };
    let expansion = noted(sections, "expcoeff").first().map(|alpha| {
        let um = alpha * (celsius - REFERENCE_C) * length_mm / 1000.0;
        (
            um,
            format!("{alpha} µm/m per K × ({celsius} − 20) K × {length_mm} mm = {um:.1} µm"),
        )
    });
    match (corrected, expansion) {
        (MaterialCorrected::Yes, _) => Vec::new(),
        (_, Some((um, _))) if um.abs() < NOTABLE_UM => Vec::new(),
        (MaterialCorrected::No, Some((_, words))) => vec![format!(
            "the expansion of the material is still in the deviations: {words} over the measured length; this table is not valid at 20 °C"
        )],
        (MaterialCorrected::NotStated, Some((_, words))) => vec![format!(
            "whether the expansion of the material is in the deviations is not stated: {words} over the measured length are at stake"
        )],
        (_, None) => vec![format!(
            "the material had {celsius} °C, its expansion coefficient is not in the file, and the readings are not known to be brought to 20 °C"
        )],
    }
}
