//! The samples of a path as CSV, written as they come: whole or not at all; and the worst of the holes
//! that canned cycles drill.

use crate::cli::outcome::Output;
use crate::quantity::Figure;
use crate::text::Problems;
use crate::visit::files::{Begun, Files, Long, Ready, not_put_out, not_written};
use crate::volume::space::pair::dot;
use crate::volume::tool_path::Sample;
use serde::Serialize;
use std::io::{BufWriter, Seek, Write};
use std::path::Path;

/// A file that is being written beside its place; that of standard output is a temporary one.
pub(super) struct Points {
    /// `None` = standard output.
    ready: Option<Box<dyn Ready>>,
    writer: BufWriter<Box<dyn Long>>,
    written: std::io::Result<()>,
}

const COLUMNS: &str =
    "line,s_mm,x_mm,y_mm,z_mm,ex_um,ey_um,ez_um,e_um,tangent_um,normal_um,held,hole";
const AFTER: &str =
    ",after_ex_um,after_ey_um,after_ez_um,after_e_um,after_tangent_um,after_normal_um";

impl Points {
    pub(super) fn create(
        files: &dyn Files,
        output: &Output,
        has_after: bool,
    ) -> Result<Points, Problems> {
        let (long, ready) = output.begin(files)?;
        let mut writer = BufWriter::with_capacity(1 << 18, long);
        let after = if has_after { AFTER } else { "" };
        let written = writeln!(writer, "{COLUMNS}{after}");
        Ok(Points { ready, writer, written })
    }

    /// Writes one sample; `after_um` = the error with tables.
    pub(super) fn write(&mut self, sample: &Sample, after_um: Option<[f64; 3]>) {
        if self.written.is_ok() {
            self.written = row(&mut self.writer, sample, after_um);
        }
    }

    /// All samples, to be delivered.
    pub(super) fn content(mut self, place: Option<&Path>) -> Result<Begun, Problems> {
        let written = self.written.and_then(|()| self.writer.flush());
        let (mut long, _) = self.writer.into_parts();
        written.and_then(|()| long.rewind()).map_err(|error| match place {
            Some(place) => not_written("cannot write", place, &error),
            None => not_put_out(&error).into(),
        })?;
        Ok((long, self.ready))
    }
}

fn row(out: &mut impl Write, sample: &Sample, after_um: Option<[f64; 3]>) -> std::io::Result<()> {
    let [x, y, z] = sample.place.map(Figure);
    write!(out, "{},{:.4},{x:.4},{y:.4},{z:.4},", sample.line, sample.s_mm)?;
    error(out, sample, sample.error_um)?;
    write!(out, ",{},", if sample.is_held { "yes" } else { "no" })?;
    if let Some(hole) = sample.hole {
        write!(out, "{hole}")?;
    }
    if let Some(after_um) = after_um {
        write!(out, ",")?;
        error(out, sample, after_um)?;
    }
    writeln!(out)
}

/// The vector, its length, its parts along the path and across it.
fn error(out: &mut impl Write, sample: &Sample, error: [f64; 3]) -> std::io::Result<()> {
    let (size, tangent) = (length(error), dot(&sample.ahead, &error));
    let [x, y, z] = error.map(Figure);
    write!(out, "{x:.6},{y:.6},{z:.6},{size:.6},{:.6},", Figure(tangent))?;
    match sample.left {
        Some(left) => write!(out, "{:.6}", Figure(dot(&left, &error))),
        None => Ok(()),
    }
}

/// Holes that are kept; the CSV has all of them.
const MOST_HOLES: usize = 20;

/// A hole at its bottom.
#[derive(Serialize)]
pub(super) struct Hole {
    #[serde(rename = "hole")]
    pub(super) number: u64,
    pub(super) line: usize,
    /// Machine coordinates.
    pub(super) at_mm: [f64; 3],
    pub(super) error_um: [f64; 3],
    pub(super) e_um: f64,
    /// With tables.
    pub(super) after_um: Option<[f64; 3]>,
    pub(super) after_e_um: Option<f64>,
}

/// The holes with the largest errors, the worst first; of equal ones the first.
#[derive(Default)]
pub(super) struct Holes(Vec<Hole>);

impl Holes {
    /// Takes a sample if it is the bottom of a hole; `after_um` = the error with tables.
    pub(super) fn take(&mut self, sample: &Sample, after_um: Option<[f64; 3]>) {
        let Some(number) = sample.hole else { return };
        let size = length(sample.error_um);
        let place = self.0.partition_point(|hole| hole.e_um >= size);
        if place == MOST_HOLES {
            return;
        }
        self.0.truncate(MOST_HOLES - 1);
        let hole = Hole {
            number,
            line: sample.line,
            at_mm: sample.place,
            error_um: sample.error_um,
            e_um: size,
            after_um,
            after_e_um: after_um.map(length),
        };
        self.0.insert(place, hole);
    }

    pub(super) fn worst(&self) -> &[Hole] {
        &self.0
    }
}

/// Of an error vector.
fn length(error: [f64; 3]) -> f64 {
    dot(&error, &error).sqrt()
}
