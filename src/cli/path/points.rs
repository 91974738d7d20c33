//! The samples of a path as CSV, written as they come: whole or not at all.

use super::holes::length;
use crate::cli::inputs::plain_words;
use crate::cli::write::{self, Ready, ReadyFile};
use crate::quantity::units::Figure;
use crate::text::problem::{Problem, Problems};
use crate::volume::tool_path::{PathMap, Sample};
use std::fs::File;
use std::io::{BufWriter, ErrorKind, Seek, Write};
use std::path::Path;

/// A file that is being written beside its place; that of standard output is a temporary one.
pub(super) struct Points {
    /// `None` = standard output.
    ready: Option<ReadyFile>,
    writer: BufWriter<File>,
    failed: Option<std::io::Error>,
}

const COLUMNS: &str =
    "line,s_mm,x_mm,y_mm,z_mm,ex_um,ey_um,ez_um,e_um,tangent_um,normal_um,held,hole";
const AFTER: &str =
    ",after_ex_um,after_ey_um,after_ez_um,after_e_um,after_tangent_um,after_normal_um";

impl Points {
    /// `None` = standard output.
    pub(super) fn create(
        path: Option<&Path>,
        has_after: bool,
        force: bool,
    ) -> Result<Points, Problems> {
        let ready = path.map(|path| ReadyFile::new(path, force)).transpose()?;
        let file = ready
            .as_ref()
            .map_or_else(tempfile::tempfile, ReadyFile::file);
        let file = file.map_err(|error| not_written(path, &error))?;
        let mut points = Points {
            ready,
            writer: BufWriter::with_capacity(1 << 18, file),
            failed: None,
        };
        let after = if has_after { AFTER } else { "" };
        let head = writeln!(points.writer, "{COLUMNS}{after}");
        points.note(head);
        Ok(points)
    }

    fn note(&mut self, outcome: std::io::Result<()>) {
        if let Err(error) = outcome {
            self.failed.get_or_insert(error);
        }
    }

    /// Writes one sample; `after` = the machine with its tables.
    pub(super) fn write(&mut self, sample: &Sample, after: Option<&PathMap>) {
        if self.failed.is_none() {
            let outcome = row(&mut self.writer, sample, after);
            self.note(outcome);
        }
    }

    /// All samples, for standard output.
    pub(super) fn printed(self) -> Result<File, Problems> {
        let (_, mut file) = self.finished()?;
        let rewound = file.rewind();
        rewound.map_err(|error| not_written(None, &error))?;
        Ok(file)
    }

    /// All samples, in a file.
    pub(super) fn written(self) -> Result<Ready, Problems> {
        match self.finished()? {
            (Some(ready), _) => ready.complete(),
            (None, _) => Err(not_written(None, &ErrorKind::NotFound.into())),
        }
    }

    fn finished(mut self) -> Result<(Option<ReadyFile>, File), Problems> {
        let flushed = self.writer.flush();
        self.note(flushed);
        let path = self.ready.as_ref().map(ReadyFile::place);
        if let Some(error) = &self.failed {
            return Err(not_written(path, error));
        }
        let (file, _) = self.writer.into_parts();
        Ok((self.ready, file))
    }
}

fn row(out: &mut impl Write, sample: &Sample, after: Option<&PathMap>) -> std::io::Result<()> {
    let [x, y, z] = sample.place.map(Figure);
    write!(
        out,
        "{},{:.4},{x:.4},{y:.4},{z:.4},",
        sample.line, sample.s_mm
    )?;
    error(out, sample, sample.error_um)?;
    write!(out, ",{},", if sample.is_held { "yes" } else { "no" })?;
    if let Some(hole) = sample.hole {
        write!(out, "{hole}")?;
    }
    if let Some(map) = after {
        write!(out, ",")?;
        error(out, sample, map.error_at(sample.place, sample.longer_mm))?;
    }
    writeln!(out)
}

/// The vector, its length, its parts along the path and across it.
fn error(out: &mut impl Write, sample: &Sample, error: [f64; 3]) -> std::io::Result<()> {
    let [ex, ey, ez] = error;
    let along = |way: [f64; 3]| way[0] * ex + way[1] * ey + way[2] * ez;
    let (size, tangent) = (length(error), along(sample.ahead));
    let [x, y, z] = error.map(Figure);
    write!(
        out,
        "{x:.6},{y:.6},{z:.6},{size:.6},{:.6},",
        Figure(tangent)
    )?;
    match sample.left {
        Some(left) => write!(out, "{:.6}", Figure(along(left))),
        None => Ok(()),
    }
}

fn not_written(path: Option<&Path>, error: &std::io::Error) -> Problems {
    match path {
        Some(path) => write::not_written("cannot write", path, error),
        None => {
            let words = plain_words(error);
            Problem::new(format!("standard output cannot be written: {words}")).into()
        }
    }
}
