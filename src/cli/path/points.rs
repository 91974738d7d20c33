//! The samples of a path as CSV, written as they come: whole or not at all.

use super::holes::length;
use crate::cli::inputs::plain_words;
use crate::cli::write;
use crate::problem::{Problem, Problems};
use crate::tool_path::{PathMap, Sample};
use crate::units::Figure;
use std::io::{BufWriter, Seek, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A file that is being written beside its place; that of standard output is a temporary one.
pub(super) struct Points {
    /// `None` = standard output.
    path: Option<PathBuf>,
    writer: BufWriter<NamedTempFile>,
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
        let file = match path {
            Some(path) => write::partial_file(path, force)?,
            None => NamedTempFile::new().map_err(|error| not_written(None, &error))?,
        };
        let mut points = Points {
            path: path.map(Path::to_path_buf),
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

    /// Puts the file into place.
    pub(super) fn finish(mut self, force: bool) -> Result<(), Problems> {
        let flushed = self.writer.flush();
        self.note(flushed);
        let failed = |error: &std::io::Error| not_written(self.path.as_deref(), error);
        if let Some(error) = &self.failed {
            return Err(failed(error));
        }
        let file = self.writer.into_inner().map_err(|e| failed(e.error()))?;
        match &self.path {
            Some(path) => write::put(file, path, force).map_err(|error| failed(&error)),
            None => to_stdout(file).map_err(|error| failed(&error)),
        }
    }
}

/// A reader that went away (`| head`) is no failure.
fn to_stdout(mut file: NamedTempFile) -> std::io::Result<()> {
    file.rewind()?;
    let mut out = std::io::stdout().lock();
    match std::io::copy(&mut file, &mut out).and_then(|_| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error),
        _ => Ok(()),
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
