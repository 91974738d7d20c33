//! The samples of a path as CSV, written as they come: whole or not at all.

use crate::cli::inputs::plain_words;
use crate::problem::Problem;
use crate::tool_path::{PathMap, Sample};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A file that is being written beside its place.
pub(super) struct Points {
    path: PathBuf,
    writer: BufWriter<NamedTempFile>,
    failed: Option<std::io::Error>,
}

const COLUMNS: &str = "line,s_mm,x_mm,y_mm,z_mm,ex_um,ey_um,ez_um,e_um,tangent_um,normal_um,held";
const AFTER: &str = ",after_ex_um,after_ey_um,after_ez_um,after_e_um";

impl Points {
    pub(super) fn create(path: &Path, has_after: bool) -> Result<Points, Problem> {
        let folder = path.parent().filter(|folder| *folder != Path::new(""));
        let file = tempfile::Builder::new()
            .prefix(".points.partial-")
            .tempfile_in(folder.unwrap_or(Path::new(".")))
            .map_err(|error| not_written(path, &error))?;
        let mut points = Points {
            path: path.to_path_buf(),
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
    pub(super) fn finish(mut self, force: bool) -> Result<(), Problem> {
        let flushed = self.writer.flush();
        self.note(flushed);
        if let Some(error) = &self.failed {
            return Err(not_written(&self.path, error));
        }
        let file = self
            .writer
            .into_inner()
            .map_err(|error| not_written(&self.path, error.error()))?;
        file.as_file()
            .sync_all()
            .map_err(|error| not_written(&self.path, &error))?;
        let placed = if force {
            file.persist(&self.path)
        } else {
            file.persist_noclobber(&self.path)
        };
        placed
            .map(|_| ())
            .map_err(|error| not_written(&self.path, &error.error))
    }
}

fn row(out: &mut impl Write, sample: &Sample, after: Option<&PathMap>) -> std::io::Result<()> {
    let ([x, y, z], [ex, ey, ez]) = (sample.place, sample.error_um);
    write!(
        out,
        "{},{:.4},{x:.4},{y:.4},{z:.4},{ex:.6},{ey:.6},{ez:.6},{:.6},{:.6},",
        sample.line,
        sample.s_mm,
        length(sample.error_um),
        sample.tangent_um
    )?;
    if let Some(normal) = sample.normal_um {
        write!(out, "{normal:.6}")?;
    }
    write!(out, ",{}", if sample.is_held { "yes" } else { "no" })?;
    if let Some(map) = after {
        let error = map.error_at(sample.place, sample.longer_mm);
        let [ex, ey, ez] = error;
        write!(out, ",{ex:.6},{ey:.6},{ez:.6},{:.6}", length(error))?;
    }
    writeln!(out)
}

fn length([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

fn not_written(path: &Path, error: &std::io::Error) -> Problem {
    Problem::new(format!(
        "cannot write `{}`: {}; nothing was written",
        path.display(),
        plain_words(error)
    ))
    .help("check the place and its free space, then run the command again")
}
