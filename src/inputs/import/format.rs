//! The formats that can be read, and how one is recognised.

use crate::inputs::import::isg;
use crate::inputs::import::pos_header;
use crate::inputs::import::stated::Stated;
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems};

/// Formats that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Renishaw static data, linear.
    Rtl,
    /// Renishaw compensation table.
    Ren,
    /// API position export, linear.
    Pos,
    /// Etalon exchange format.
    Etalon,
    /// ISG volumetric compensation.
    Isg,
    /// Any delimited text, by a mapping of its columns.
    Columns,
}

impl Format {
    /// All of them, in the order of the documentation.
    pub const ALL: [Format; 6] = [
        Format::Rtl,
        Format::Ren,
        Format::Pos,
        Format::Etalon,
        Format::Isg,
        Format::Columns,
    ];

    /// The word of `--from`.
    pub const fn word(self) -> &'static str {
        match self {
            Format::Rtl => "rtl",
            Format::Ren => "ren",
            Format::Pos => "pos",
            Format::Etalon => "etalon",
            Format::Isg => "isg",
            Format::Columns => "columns",
        }
    }

    pub(super) const fn described(self) -> &'static str {
        match self {
            Format::Rtl => "rtl (Renishaw static data, linear)",
            Format::Ren => "ren (Renishaw compensation table)",
            Format::Pos => "pos (API position export, linear)",
            Format::Etalon => "etalon (Etalon exchange format)",
            Format::Isg => "isg (ISG volumetric compensation)",
            Format::Columns => "columns (delimited text with a stated mapping)",
        }
    }

    /// The options that have a meaning for the format.
    pub(super) const fn takes(self) -> &'static [&'static str] {
        match self {
            Format::Rtl => &[
                "--axis",
                "--term",
                "--first-target-at-mm",
                "--targets-run",
                "--sign",
                "--runs",
                "--material-corrected",
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
            Format::Pos => &[
                "--axis",
                "--term",
                "--first-target-at-mm",
                "--targets-run",
                "--sign",
                "--rows",
                "--material-corrected",
            ],
            Format::Etalon | Format::Isg => &["--sign"],
            Format::Columns => &[
                "--columns",
                "--axis",
                "--direction",
                "--plus-moves",
                "--first-target-at-mm",
                "--targets-run",
                "--sign",
                "--decimal",
            ],
        }
    }
}

/// The format, by what stands in the file.
pub(super) fn recognised(source: &Source, stated: &Stated) -> Result<Format, Problems> {
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
    } else if pos_header::is_first_line(first) || source.name.to_ascii_lowercase().ends_with(".pos")
    {
        Ok(Format::Pos)
    } else if source.name.to_ascii_lowercase().ends_with(".rtl") {
        Ok(Format::Rtl)
    } else if source.name.to_ascii_lowercase().ends_with(".ren") {
        Ok(Format::Ren)
    } else {
        Err(Problem::new(format!("the format of `{}` is not recognised", source.name))
            .at(source.place(&(0..first.len().min(source.text.len()))))
            .help("map its columns with `--columns`, or state `--from rtl`, `ren`, `pos`, `etalon` or `isg`. Of the files of Optodyne, CARTO and others nothing is known that could be relied on: export a CSV there")
            .into())
    }
}
