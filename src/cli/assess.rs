//! `nonius assess JOB|ERRORS`

mod page;
mod text;

use crate::cli::outcome::{Outcome, Shows, positive};
use crate::cli::refusals;
use crate::inputs::job::UseOf;
use crate::inputs::kind::FileKind;
use crate::kit::{Inputs, Loaded, generate};
use crate::page::bin_um;
use crate::quantity::{Axis, Chain, PerAxis};
use crate::text::{Problem, Problems};
use crate::visit::files::Files;
use crate::visit::inputs::{self, CorrectedMachine, read_directory};
use crate::visit::job_files::InputFile;
use crate::volume::assessment::{Grid, GridChoice, MOST_POINTS, Request};
use crate::volume::volume_model::VolumeModel;
use clap::Args;
pub(super) use page::Page;
use page::va_um;
use std::path::PathBuf;

/// Most nodes of one axis.
const MOST_NODES: usize = 1001;

// Options of `assess`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// The job (TOML), or an error table (CSV); `-` = standard input
    file: PathBuf,
    /// Nodes of X, Y and Z, equally spaced, e.g. 21,21,21; `nodes` = the table's own
    #[arg(long, value_name = "NX,NY,NZ", default_value = "nodes", value_parser = grid_word)]
    grid: GridChoice,
    /// Size of a sub-volume, mm: worst, best and corner one of its figures
    #[arg(long, value_name = "X,Y,Z", value_parser = window_word)]
    window: Option<PerAxis<f64>>,
    /// Distribution of all differences, in bins of this width, µm
    #[arg(long, value_name = "UM", value_parser = positive)]
    histogram: Option<f64>,
    /// Also the grouping method of paper 002 with this angular tolerance, e.g. 0.1: a lower bound
    #[arg(long, value_name = "TOL", value_parser = positive)]
    grouping: Option<f64>,
    /// Also the error at each node of the grid (with `--format json`)
    #[arg(long)]
    vectors: bool,
    #[command(flatten)]
    tables: AskedTables,
    /// Chain of the machine, for an error table with angles that no job describes, e.g. wXYZt
    #[arg(long, value_parser = chain_word)]
    chain: Option<Chain>,
    #[command(flatten)]
    shows: Shows,
}

/// Options that ask for tables; those of `path`, too.
#[derive(Args, Debug)]
pub(super) struct AskedTables {
    /// Also as the files of this directory leave the machine
    #[arg(long, value_name = "DIR", conflicts_with = "with_tables")]
    tables: Option<PathBuf>,
    /// Also as the tables that the job asks for would leave the machine
    #[arg(long)]
    with_tables: bool,
}

impl AskedTables {
    /// Whether any are asked for.
    pub(super) fn is_any(&self) -> bool {
        self.tables.is_some() || self.with_tables
    }

    /// What the job has to hold for them.
    pub(super) fn use_of(&self) -> UseOf {
        UseOf::with(self.is_any())
    }

    /// The machine with them; `volume` is the machine as it was measured.
    pub(super) fn corrected(
        &self,
        files: &dyn Files,
        inputs: &Inputs,
        volume: &VolumeModel,
    ) -> Result<Option<CorrectedMachine>, Problems> {
        let loaded = match &self.tables {
            Some(directory) => read_directory(files, inputs, directory)?.load(inputs)?,
            None if self.with_tables => generate(inputs)?.load(inputs)?,
            None => return Ok(None),
        };
        CorrectedMachine::of(volume, &loaded).map(Some)
    }
}

fn three<T: Copy>(text: &str, read: impl Fn(&str) -> Option<T>) -> Option<PerAxis<T>> {
    let parts: Option<Vec<T>> = text.split(',').map(|part| read(part.trim())).collect();
    let [x, y, z] = parts?.try_into().ok()?;
    Some(PerAxis { x, y, z })
}

fn grid_word(text: &str) -> Result<GridChoice, String> {
    if text == "nodes" {
        return Ok(GridChoice::OwnNodes);
    }
    let count = |part: &str| part.parse().ok().filter(|count| (1..=MOST_NODES).contains(count));
    let counts = three(text, count);
    counts
        .filter(|n| n.x * n.y * n.z <= MOST_POINTS)
        .map(GridChoice::Equal)
        .ok_or_else(|| {
            format!("expected `nodes` or three numbers of nodes such as 21,21,21 (1 … {MOST_NODES} each, {MOST_POINTS} together)")
        })
}

fn window_word(text: &str) -> Result<PerAxis<f64>, String> {
    let sizes = three(text, |part| positive(part).ok());
    sizes.ok_or_else(|| "expected three lengths in mm such as 300,200,200".to_string())
}

fn chain_word(text: &str) -> Result<Chain, String> {
    Chain::parse(text).ok_or_else(|| {
        "expected each of X, Y, Z once, `w` where the workpiece is and `t` at the end, e.g. wXYZt"
            .to_string()
    })
}

pub(super) fn run(options: &Options, files: &dyn Files) -> Result<Outcome, Problems> {
    let page = page(options, files)?;
    options.shows.outcome(files, || text::screen(&page), || &page, |locale| page.picture(locale))
}

fn page(options: &Options, files: &dyn Files) -> Result<Page, Problems> {
    let request = Request {
        window_mm: options.window,
        histogram_um: options.histogram,
        grouping: options.grouping,
        vectors: options.vectors,
    };
    let file = InputFile::read(files, &options.file)?;
    let inputs = match file.kind() {
        FileKind::Job => {
            let mut inputs = inputs::read_job(files, None, &file, options.tables.use_of())?;
            take_chain(&mut inputs, options.chain)?;
            inputs
        }
        _ if options.tables.is_any() => return Err(refusals::names_no_control(&file.name).into()),
        _ => inputs::of_table(&file, file.name.clone(), options.chain)?,
    };
    let volume = VolumeModel::build(&inputs.job, inputs.as_measured())?;
    check(&volume, options)?;
    let corrected = options.tables.corrected(files, &inputs, &volume)?;
    Ok(Page::of(&inputs, volume, corrected, options.grid, &request)?)
}

/// Nodes of each axis in a report: enough for its pictures.
const GRID_OF_REPORT: GridChoice = GridChoice::Equal(PerAxis { x: 11, y: 11, z: 11 });

/// The page of a report, with the tables of a control where there are any; with bins that suit the differences.
pub(super) fn for_report(inputs: &Inputs, loaded: Option<&Loaded<'_>>) -> Result<Page, Problems> {
    let volume = VolumeModel::build(&inputs.job, inputs.as_measured())?;
    let nodes = Grid::of(GRID_OF_REPORT, &volume, &[])?;
    let histogram_um = Some(bin_um(va_um(&volume, &nodes)?));
    let request = Request { histogram_um, ..Request::default() };
    let corrected = loaded.map(|loaded| CorrectedMachine::of(&volume, loaded)).transpose()?;
    Ok(Page::of(inputs, volume, corrected, GRID_OF_REPORT, &request)?)
}

/// `--chain` is for a job that states none.
fn take_chain(inputs: &mut Inputs, stated: Option<Chain>) -> Result<(), Problem> {
    let own = inputs.job.machine.chain;
    if let (Some(own), Some(other)) = (own, stated)
        && own != other
    {
        return Err(inputs.job.source.at("machine.chain", refusals::other_chain(own, other)));
    }
    inputs.job.machine.chain = own.or(stated);
    Ok(())
}

/// A sub-volume must fit into the volume, and one node of a length says nothing of it.
fn check(volume: &VolumeModel, options: &Options) -> Result<(), Problem> {
    let lengths = Axis::ALL.map(|axis| (axis, volume.range(axis).1 - volume.range(axis).0));
    for (axis, length) in lengths {
        if let GridChoice::Equal(counts) = options.grid
            && counts[axis] == 1
            && length > 0.0
        {
            return Err(refusals::one_node(axis, text::short(length)));
        }
    }
    for (axis, length) in lengths {
        if let Some(size) = options.window.map(|size| size[axis]).filter(|size| *size > length) {
            return Err(refusals::large_window(axis, size, text::short(length)));
        }
    }
    Ok(())
}
