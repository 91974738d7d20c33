//! `nonius path JOB PROGRAM`

mod page;

use crate::cli::assess::AskedTables;
use crate::cli::outcome::{Outcome, Output, Plot};
use crate::cli::refusals;
use crate::inputs::problems;
use crate::page::{Ink, Trace};
use crate::text::{Problem, Problems};
use crate::visit::files::{Files, Long, or_help, plain_words};
use crate::visit::inputs;
use crate::visit::job_files::InputFile;
use crate::volume::tool_path::{Profile, limits, path_map};
use crate::volume::volume_model::VolumeModel;
use clap::Args;
use page::{Holes, Page, Points, found};
use part_program::{Line, Mark, Refused, Text, run as run_program};
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

// Options of `path`.
#[derive(Args, Debug)]
#[command(mut_arg("output", |arg| {
    arg.help("Also write the error at every sample to this file (CSV); `-` = standard output")
}))]
pub(super) struct Options {
    /// The job (TOML)
    job: PathBuf,
    /// The part program; `-` = standard input
    program: PathBuf,
    #[command(flatten)]
    tables: AskedTables,
    #[command(flatten)]
    output: Output,
    #[command(flatten)]
    plot: Plot,
}

pub(super) fn run(options: &Options, files: &dyn Files) -> Result<Outcome, Problems> {
    options.output.ensure_new(files, "the samples")?;
    if options.job == Path::new("-") && options.program == Path::new("-") {
        return Err(refusals::both_on_standard_input().into());
    }
    let (page, points) = page(options, files)?;
    let content = points.map(|points| points.content(options.output.place())).transpose()?;
    let next = format!(" ({} samples)", page.before.samples);
    let output = &options.output;
    let outcome = output.deliver(files, content, || page.screen(), || page.document(), &next)?;
    options.plot.beside(files, outcome, output.force, |locale| page.picture(locale))
}

/// The page, and the samples where a file of them is asked for.
fn page(options: &Options, files: &dyn Files) -> Result<(Page, Option<Points>), Problems> {
    let job = InputFile::read(files, &options.job)?;
    let inputs = inputs::read_job(files, None, &job, options.tables.use_of())?;
    let volume = VolumeModel::build(&inputs.job, inputs.as_measured())?;
    let map = path_map(&inputs.job, &volume);
    let tables = options.tables.corrected(files, &inputs, &volume)?;
    let after_map = tables.as_ref().map(|t| path_map(&inputs.job, &t.volume));
    let mut text = ProgramText::open(files, &options.program)?;
    let program = text.name.clone();
    let mut before = Profile::new(&map, limits(&inputs.job, &volume));
    let with_map = tables.as_ref().zip(after_map.as_ref());
    let mut after = with_map.map(|(t, map)| Profile::new(map, limits(&inputs.job, &t.volume)));
    let points = options.output.is_asked_for();
    let points = points.then(|| Points::create(files, &options.output, after_map.is_some()));
    let mut points = points.transpose()?;
    let mut holes = Holes::default();
    let mut traces = vec![Trace::new(Ink::AsFound)];
    traces.extend(after_map.as_ref().map(|_| Trace::new(Ink::Forecast)));
    let ran = run_program(&mut text, &inputs.job.path.setup, |step| {
        before.follow(step, &mut |sample| {
            let after_um = after_map.as_ref();
            let after_um = after_um.map(|map| map.error_at(sample.place, sample.longer_mm));
            holes.take(sample, after_um);
            let both = [Some(sample.error_um), after_um].into_iter().flatten();
            traces.iter_mut().zip(both).for_each(|(trace, um)| trace.take(sample.s_mm, um));
            if let Some(points) = &mut points {
                points.write(sample, after_um);
            }
        })?;
        after.as_mut().map_or(Ok(()), |after| after.follow(step, &mut |_| {}))
    })
    .map_err(|refused| problems(&program, refused))?;
    let before = found(before, &program)?;
    let after = after.map(|profile| found(profile, &program)).transpose()?;
    let after = tables.zip(after).map(|(tables, followed)| tables.with(followed));
    Ok((Page { program, inputs, volume, ran, before, after, holes, traces }, points))
}

/// No control reads a longer line.
const LONGEST_LINE: u64 = 4096;
/// Filled again whenever a subprogram is called or ends that is not in it.
const BUFFER_BYTES: usize = 1 << 16;

/// A part program on disk, read line by line.
struct ProgramText {
    name: String,
    reader: BufReader<Box<dyn Long>>,
    line: Vec<u8>,
    mark: Mark,
}

impl ProgramText {
    /// Opens a file; `-` = standard input.
    fn open(files: &dyn Files, path: &Path) -> Result<ProgramText, Problem> {
        let help = "check the path of the part program";
        let (name, long) = files.long(path).map_err(|problem| or_help(problem, help))?;
        Ok(ProgramText {
            name,
            reader: BufReader::with_capacity(BUFFER_BYTES, long),
            line: Vec::new(),
            mark: Mark::default(),
        })
    }
}

fn failed(name: &str, error: &std::io::Error) -> Refused {
    Refused::new(format!("`{name}` cannot be read: {}", plain_words(error)))
}

impl Text for ProgramText {
    fn next_line(&mut self) -> Result<Option<Line<'_>>, Refused> {
        self.line.clear();
        let mut part = (&mut self.reader).take(LONGEST_LINE);
        let read =
            part.read_until(b'\n', &mut self.line).map_err(|error| failed(&self.name, &error))?;
        if read == 0 {
            return Ok(None);
        }
        let ended = self.line.last() == Some(&b'\n');
        if !ended && self.line.len() as u64 == LONGEST_LINE {
            let number = self.mark.lines + 1;
            return Err(Refused::new(format!(
                "line {number} of `{}` has more than {LONGEST_LINE} characters, expected the blocks of a part program",
                self.name
            ))
            .help("check that the file is a part program with one block in each line, ended by LF or CR LF"));
        }
        self.mark.bytes += read as u64;
        self.mark.lines += 1;
        let end = self.line.len() - usize::from(ended);
        Ok(Some(Line { number: self.mark.lines, bytes: &self.line[..end] }))
    }

    fn mark(&self) -> Mark {
        self.mark
    }

    fn go_to(&mut self, mark: Mark) -> Result<(), Refused> {
        let by = mark.bytes.cast_signed() - self.mark.bytes.cast_signed();
        // What is in the buffer is not read again.
        self.reader.seek_relative(by).map_err(|error| failed(&self.name, &error))?;
        self.mark = mark;
        Ok(())
    }
}
