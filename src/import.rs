//! Another maker's measurement → our error table (contract §2.1).
//!
//! ```text
//!   bytes ─→ encoding ─→ format ─→ rtl · ren · etalon · isg · columns ─→ Draft ─→ CSV
//!                            ▲
//!                 stated: what the file does not carry
//! ```
//! What the file states is used and said. What it does not carry (component, machine coordinate
//! of the first target, sense of the targets, sign, unit) has to be stated; nothing is guessed,
//! and a statement that contradicts the file is a problem. docs/import.md has the whole list.

mod columns;
mod components;
mod encoding;
mod etalon;
mod isg;
mod lines;
mod placing;
mod ren;
mod rtl;
pub mod stated;

pub use self::rtl::{MeasuredRuns, measured_runs};

use crate::axis::Axis;
use crate::document::Source;
use crate::error_table::{Draft, DraftSeries};
use crate::problem::{Problem, Problems};
use stated::{Encoding, Stated};
use std::fmt;

/// Formats that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Renishaw static data, linear.
    Rtl,
    /// Renishaw compensation table.
    Ren,
    /// Etalon exchange format.
    Etalon,
    /// ISG volumetric compensation.
    Isg,
    /// Any delimited text, by a mapping of its columns.
    Columns,
}

impl Format {
    /// All of them, in the order of the documentation.
    pub const ALL: [Format; 5] = [
        Format::Rtl,
        Format::Ren,
        Format::Etalon,
        Format::Isg,
        Format::Columns,
    ];

    /// The word of `--from`.
    pub const fn word(self) -> &'static str {
        match self {
            Format::Rtl => "rtl",
            Format::Ren => "ren",
            Format::Etalon => "etalon",
            Format::Isg => "isg",
            Format::Columns => "columns",
        }
    }

    const fn described(self) -> &'static str {
        match self {
            Format::Rtl => "rtl (Renishaw static data, linear)",
            Format::Ren => "ren (Renishaw compensation table)",
            Format::Etalon => "etalon (Etalon exchange format)",
            Format::Isg => "isg (ISG volumetric compensation)",
            Format::Columns => "columns (delimited text with a stated mapping)",
        }
    }

    /// The options that have a meaning for the format.
    const fn takes(self) -> &'static [&'static str] {
        match self {
            Format::Rtl => &[
                "--axis",
                "--term",
                "--first-target-at-mm",
                "--targets-run",
                "--sign",
                "--runs",
            ],
            Format::Ren => &[
                "--axis",
                "--term",
                "--first-target-at-mm",
                "--targets-run",
                "--sign",
                "--unit",
                "--values",
            ],
            Format::Etalon | Format::Isg => &["--sign"],
            Format::Columns => &[
                "--columns",
                "--axis",
                "--direction",
                "--first-target-at-mm",
                "--targets-run",
                "--sign",
            ],
        }
    }
}

/// A file to be imported.
#[derive(Clone, Copy, Debug)]
pub struct Measurement<'a> {
    /// The file as the user named it, for messages.
    pub path: &'a str,
    /// Its name without folders, for the table.
    pub name: &'a str,
    /// SHA-256 of its bytes, in hexadecimal digits.
    pub sha256: &'a str,
    /// Its bytes.
    pub bytes: &'a [u8],
}

/// Two axes whose squareness a file gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Squareness {
    /// `xy`, `xz` or `yz`.
    pub pair: &'static str,
    /// φ in µm/m; positive = the angle between the two positive axis directions is less than 90°.
    pub um_per_m: f64,
    /// The name in the file, e.g. `C0Y`.
    pub name: &'static str,
}

/// What a file gave, in our words.
#[derive(Clone, Debug, Default)]
struct Reading {
    series: Vec<DraftSeries>,
    /// What the file states and what was done with it.
    facts: Vec<String>,
    squareness: Vec<Squareness>,
}

/// An imported measurement.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The format that was read.
    pub format: Format,
    /// The error table, with the comment lines that say where it comes from.
    pub draft: Draft,
    /// What the file states and what was done with it, one sentence each.
    pub facts: Vec<String>,
    /// Squareness cannot stand in an error table; it belongs into the job.
    pub squareness: Vec<Squareness>,
}

/// Reads a measurement.
pub fn import(
    file: Measurement<'_>,
    from: Option<Format>,
    encoding: Option<Encoding>,
    stated: &Stated,
) -> Result<Imported, Problems> {
    refuse_known(file)?;
    let (source, encoding) = encoding::decode(file, encoding)?;
    let format = match from {
        Some(format) => format,
        None => recognised(&source, stated)?,
    };
    let mut problems = stated.foreign_to(format.word(), format.takes());
    let read = match format {
        Format::Rtl => rtl::read,
        Format::Ren => ren::read,
        Format::Etalon => etalon::read,
        Format::Isg => isg::read,
        Format::Columns => columns::read,
    };
    let reading = problems.take(read(&source, stated));
    let reading = match reading {
        Some(reading) if problems.is_empty() => reading,
        _ => return Err(problems),
    };
    let mut facts = vec![format!("text: {encoding}")];
    facts.extend(reading.facts);
    let mut comments = vec![
        source_comment(file.name, file.sha256),
        format!("format: {}", format.described()),
    ];
    let given = stated.given();
    comments.extend(
        given
            .iter()
            .map(|(o, value)| format!("stated: {o} {value}")),
    );
    comments.extend(facts.iter().cloned());
    comments.extend(squareness_lines(&reading.squareness));
    Ok(Imported {
        format,
        draft: Draft {
            comments,
            series: reading.series,
        },
        facts,
        squareness: reading.squareness,
    })
}

/// What to put into the job for the squareness of a file; nothing if it gives none.
pub fn squareness_lines(squareness: &[Squareness]) -> Vec<String> {
    if squareness.is_empty() {
        return Vec::new();
    }
    let mut lines = vec![
        "squareness does not stand in this table; put into the job, unless the slopes above contain it:".to_string(),
        "  [measurement.squareness_um_per_m]".to_string(),
    ];
    lines.extend(squareness.iter().map(|s| {
        format!(
            "  {} = {}    # from {}",
            s.pair,
            toml_number(s.um_per_m),
            s.name
        )
    }));
    lines.push(
        "  positive = the angle between the two positive axis directions is less than 90°"
            .to_string(),
    );
    lines
}

fn toml_number(number: f64) -> String {
    format!("{number:?}")
}

const SOURCE: &str = "source: ";
const SHA256: &str = " sha256 ";

fn source_comment(name: &str, sha256: &str) -> String {
    format!("{SOURCE}{name}{SHA256}{sha256}")
}

/// The file that an error table was imported from, by its comment line: name and SHA-256.
pub fn source_of(table: &str) -> Option<(String, String)> {
    let comments = table.lines().take_while(|line| line.starts_with('#'));
    comments
        .map(|line| line.trim_start_matches('#').trim())
        .find_map(|comment| {
            let (name, hash) = comment.strip_prefix(SOURCE)?.rsplit_once(SHA256)?;
            let is_hash = hash.len() == 64 && hash.bytes().all(|b| b.is_ascii_hexdigit());
            is_hash.then(|| (name.to_string(), hash.to_string()))
        })
}

/// Files of which it is known that they cannot become a table, and what to export instead.
fn refuse_known(file: Measurement<'_>) -> Result<(), Problems> {
    let head = &file.bytes[..file.bytes.len().min(4096)];
    let head = String::from_utf8_lossy(head);
    let ending = file.name.rsplit_once('.').map_or("", |(_, ending)| ending);
    let kind = stated_kind(&head).unwrap_or_else(|| ending.to_ascii_lowercase());
    let refusal = match kind.as_str() {
        "rtx" => Some((
            "is a dynamic recording (`.rtx`), which has no targets",
            "measure at targets and save static data (`.rtl`)",
        )),
        "rta" | "rtr" => Some((
            "holds angles, and the unit of the values in this format is not known",
            "export a CSV with the unit, and map its columns: `--columns \"Position=target_mm,Pitch=eb_urad\"`",
        )),
        "rts" | "rtq" | "rtf" => Some((
            "holds straightness, squareness or flatness in a form that is not known",
            "export a CSV with the evaluated deviations, and map its columns: `--columns \"Position=target_mm,Deviation=ey_um\"`",
        )),
        "pos" => Some((
            "is a text export whose form is not known",
            "export a CSV with one row a position, and map its columns: `--columns \"Position=target_mm,Error=ex_mm\"`",
        )),
        "xls" | "xlsx" | "ods" => Some((
            "is a spreadsheet",
            "save it as CSV, and map its columns with `--columns`",
        )),
        _ if head.contains("Bidirectional Avg Error") => Some((
            "is an API evaluation, which holds averages of runs only",
            "export a CSV with one row a position, and map its columns: `--columns \"Position=target_mm,Error=ex_mm\"`",
        )),
        _ => None,
    };
    match refusal {
        None => Ok(()),
        Some((what, instead)) => Err(Problem::new(format!("`{}` {what}", file.path))
            .help(instead)
            .into()),
    }
}

/// The file type that a Renishaw header states.
fn stated_kind(head: &str) -> Option<String> {
    head.lines().find_map(|line| {
        let (key, value) = line.split_once(':')?;
        let is_type = key.trim().eq_ignore_ascii_case("file type");
        is_type.then(|| value.trim().to_ascii_lowercase())
    })
}

/// The format, by what stands in the file.
fn recognised(source: &Source, stated: &Stated) -> Result<Format, Problems> {
    if stated.columns.is_some() {
        return Ok(Format::Columns);
    }
    let content = || {
        source
            .text
            .lines()
            .map(str::trim)
            .filter(|line| !line.is_empty())
    };
    let code = || content().filter(|line| !line.starts_with("//"));
    let first = code().next().unwrap_or("");
    let has_key = |key: &str| content().any(|line| line.starts_with(key) && line.contains(':'));
    if first.eq_ignore_ascii_case("HEADER::") {
        Ok(Format::Rtl)
    } else if has_key("Compensation start") || has_key("Compensation type") {
        Ok(Format::Ren)
    } else if first.starts_with('[') {
        Ok(Format::Etalon)
    } else if isg::is_header(first) {
        Ok(Format::Isg)
    } else if source.name.to_ascii_lowercase().ends_with(".rtl") {
        Ok(Format::Rtl)
    } else if source.name.to_ascii_lowercase().ends_with(".ren") {
        Ok(Format::Ren)
    } else {
        Err(Problem::new(format!("the format of `{}` is not recognised", source.name))
            .at(source.place(&(0..first.len().min(source.text.len()))))
            .help("map its columns with `--columns`, or state `--from rtl`, `ren`, `etalon` or `isg`. Of the files of Optodyne, API, CARTO and others nothing is known that could be relied on: export a CSV there")
            .into())
    }
}

/// A component of the error table: a deviation or a rotation while one axis moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Component {
    /// What deviates.
    pub kind: Kind,
    /// The moving axis.
    pub along: Axis,
}

/// Deviation or rotation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Deviation in the direction of an axis.
    Deviation(Axis),
    /// Rotation about an axis.
    Angle(Axis),
}

impl Component {
    /// The component of a name such as `EYX` or `ECX`.
    pub fn from_name(name: &str) -> Option<Component> {
        let [b'E', of, along] = name.as_bytes() else {
            return None;
        };
        let kind = match of {
            b'X' => Kind::Deviation(Axis::X),
            b'Y' => Kind::Deviation(Axis::Y),
            b'Z' => Kind::Deviation(Axis::Z),
            b'A' => Kind::Angle(Axis::X),
            b'B' => Kind::Angle(Axis::Y),
            b'C' => Kind::Angle(Axis::Z),
            _ => return None,
        };
        let along = Axis::ALL
            .into_iter()
            .find(|a| a.letter() == char::from(*along))?;
        Some(Component { kind, along })
    }

    /// Whether an axis is measured along itself (`EXX`): the sense of its targets is then that of
    /// the deviation.
    fn is_positioning(self) -> bool {
        self.kind == Kind::Deviation(self.along)
    }

    /// Sets the values of the component in a series of its axis, µm or µrad.
    fn put(self, series: &mut DraftSeries, values: Vec<f64>) {
        match self.kind {
            Kind::Deviation(of) => series.deviations_um[of] = Some(values),
            Kind::Angle(about) => series.angles_urad[about] = Some(values),
        }
    }
}

impl fmt::Display for Component {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of = match self.kind {
            Kind::Deviation(of) => of.letter(),
            Kind::Angle(Axis::X) => 'A',
            Kind::Angle(Axis::Y) => 'B',
            Kind::Angle(Axis::Z) => 'C',
        };
        write!(out, "E{of}{}", self.along)
    }
}

/// The terms of a series, e.g. `EXX EAX`.
pub fn terms_of(series: &DraftSeries) -> Vec<Component> {
    let along = series.axis;
    let deviations = Axis::ALL
        .into_iter()
        .filter(|of| series.deviations_um[*of].is_some());
    let angles = Axis::ALL
        .into_iter()
        .filter(|of| series.angles_urad[*of].is_some());
    let kinds = deviations
        .map(Kind::Deviation)
        .chain(angles.map(Kind::Angle));
    kinds.map(|kind| Component { kind, along }).collect()
}
