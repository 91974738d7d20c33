//! What `assess` prints, and what its figures rest on: frame, levers, tables that were active, how much
//! of the machine was measured (what is missing must not look like an error of 0); each error as it was measured.

use crate::cli::show::{PlaneFigures, planes};
use crate::inputs::error_table::{ErrorTable, Remarks};
use crate::inputs::job::{ActiveTables, Frame, Job, UseOf};
use crate::judge::after::alone;
use crate::judge::forecast::Change;
use crate::kit::Inputs;
use crate::machine::findings::ModelFinding;
use crate::machine::model::ErrorModel;
use crate::machine::separation::table::ErrorSource;
use crate::page::{Ink, Locale, Picture, Side, volume};
use crate::quantity::{Axis, Chain, ErrorTerm, Listed, Millimetres, PerAxis, Rotation};
use crate::text::{Finding, Named, Problem, Problems, Severity, Source};
use crate::visit::job_files::Given;
use crate::volume::assessment::{Assessment, GridChoice};
use crate::volume::findings::VolumeFinding;
use crate::volume::volume_model::{Component, Missing, VolumeModel};
use serde::Serialize;

/// What is printed; the document for scripts is the same (contract §5).
#[derive(Serialize)]
pub(in crate::cli) struct Page {
    schema: u32,
    /// Name of the machine, or of the table.
    #[serde(rename = "machine")]
    pub(in crate::cli) name: String,
    #[serde(skip)]
    pub(super) volume: VolumeModel,
    #[serde(skip)]
    pub(super) grid: GridChoice,
    /// What the figures rest on.
    #[serde(flatten)]
    pub(super) basis: Basis,
    /// How many of the 21 are known.
    pub(super) errors_measured: usize,
    /// As it was measured.
    #[serde(flatten)]
    found: Found,
    /// As it is.
    #[serde(flatten)]
    pub(in crate::cli) before: Assessment,
    pub(super) missing: Vec<Missing>,
    labels: Vec<Finding>,
    pub(super) after: Option<After>,
}

impl Page {
    pub(super) fn of(
        name: String,
        volume: VolumeModel,
        grid: GridChoice,
        basis: Basis,
        found: Found,
        before: Assessment,
    ) -> Page {
        Page {
            schema: 1,
            name,
            grid,
            errors_measured: volume.known_errors(),
            missing: volume.missing(),
            volume,
            found,
            before,
            labels: [&basis.doubts[..], &basis.labels].concat(),
            basis,
            after: None,
        }
    }

    /// Why the figures may be wrong.
    pub(in crate::cli) fn doubts(&self) -> &[Finding] {
        &self.basis.doubts
    }

    /// Vectors, contributions, and the distribution where it is asked for.
    pub(in crate::cli) fn picture(&self, locale: Locale<'_>) -> Picture {
        let before = Side {
            ink: Ink::AsFound,
            name: locale.words("legend_found"),
            model: &self.volume,
            assessment: &self.before,
        };
        let after = self.after.as_ref().map(|after| Side {
            ink: Ink::Forecast,
            name: locale.words("forecast_with_tables"),
            model: &after.volume,
            assessment: &after.assessment,
        });
        let sides: Vec<Side<'_>> = std::iter::once(before).chain(after).collect();
        let heading = format!("{}: {}", self.name, locale.words("errors_in_volume"));
        volume(locale, &heading, &sides)
    }

    /// The machine as it is, and as tables leave it.
    pub(super) fn sides(&self) -> impl Iterator<Item = (&'static str, &Assessment)> {
        let after = self.after.as_ref();
        let after = after.map(|after| ("with the tables", &after.assessment));
        std::iter::once(("as it is", &self.before)).chain(after)
    }
}

/// As tables leave it.
#[derive(Serialize)]
pub(super) struct After {
    /// Where the tables come from.
    #[serde(rename = "tables")]
    pub(super) from: String,
    #[serde(flatten)]
    pub(super) assessment: Assessment,
    #[serde(skip)]
    pub(super) volume: VolumeModel,
    /// How the files differ from what the job asks for.
    pub(super) disagreements: Vec<Finding>,
}

/// A deviation above this is more often a unit error, µm.
const UNLIKELY_UM: f64 = 5_000.0;
/// An angle above this, µrad, and a squareness above this, µm/m, likewise.
const UNLIKELY_URAD: f64 = 5_000.0;

/// What the figures rest on.
#[derive(Serialize)]
pub(super) struct Basis {
    /// The order of the axes, where it is stated.
    pub(super) chain: Option<String>,
    /// How the axes are aligned, as the measured errors state it: `as given`, `x-primary`, `as-measured`.
    pub(super) frame: &'static str,
    /// Range of each axis; `None` where nothing was measured along it and no travel is stated.
    pub(super) volume_mm: PerAxis<Option<(f64, f64)>>,
    /// The stated places that levers depend on.
    pub(super) tool_offset_mm: Option<Listed<Millimetres>>,
    pub(super) offsets_mm: PerAxis<Option<Millimetres>>,
    pub(super) angles_zero_mm: PerAxis<Option<Millimetres>>,
    pub(super) straightness_optic_mm: PerAxis<Option<Millimetres>>,
    /// The tables that were active while measuring.
    pub(super) active: Option<Active>,
    /// Why the figures may be wrong.
    #[serde(skip)]
    doubts: Vec<Finding>,
    /// What whoever reads a figure has to know.
    #[serde(skip)]
    pub(super) labels: Vec<Finding>,
}

/// Tables that were active while measuring.
#[derive(Serialize)]
pub(super) struct Active {
    pub(super) tables: String,
    /// VA of the machine without them, µm.
    pub(super) va_without_um: Option<f64>,
}

impl Basis {
    /// Of a job.
    pub(super) fn of_job(inputs: &Inputs, volume: &VolumeModel) -> Basis {
        let job = &inputs.job;
        let measurement = &job.measurement;
        let open = measurement.active == ActiveTables::NotStated;
        let open = open.then_some(VolumeFinding::ActiveNotStated);
        let stated = outside(job).into_iter().chain(open).map(Finding::from);
        let stated = stated.chain(inputs.active_notes.iter().cloned()).chain(measurement.notes());
        Basis::of(job, inputs.as_measured(), &inputs.model.remarks, volume, stated)
    }

    fn of(
        job: &Job,
        measured: &ErrorModel,
        remarks: &Remarks,
        volume: &VolumeModel,
        stated: impl Iterator<Item = Finding>,
    ) -> Basis {
        let labels = volume.labels.iter().cloned();
        let (doubtful, labels): (Vec<_>, Vec<_>) =
            labels.partition(|label| label.severity() == Severity::Doubt);
        let labels = labels.into_iter().chain(stated).chain(said(remarks));
        let doubts = doubts(job, measured).chain(doubtful);
        let levers = &job.measurement.levers;
        let unknown = volume.unknown_axes();
        let range = |axis| (!unknown.contains(&axis)).then(|| volume.range(axis));
        let active = match &job.measurement.active {
            ActiveTables::Path(tables) => Some(tables.clone()),
            _ => None,
        };
        Basis {
            chain: volume.chain_is_stated.then(|| volume.chain.to_string()),
            frame: measured.remarks.frame.map_or("as given", Frame::word),
            volume_mm: PerAxis::from_fn(range),
            tool_offset_mm: levers.tool.map(Listed),
            offsets_mm: levers.offsets,
            angles_zero_mm: levers.angles_zero,
            straightness_optic_mm: levers.straightness_optic,
            active: active.map(|tables| Active { tables, va_without_um: None }),
            doubts: doubts.collect(),
            labels: labels.collect(),
        }
    }

    /// How the axes are aligned, in words.
    pub(super) fn frame_words(&self) -> &'static str {
        match self.frame {
            "x-primary" => {
                "X primary, XY plane secondary: the separation took the slopes off EYX, EZX and EZY"
            }
            "as-measured" => {
                "as measured: the slopes of the cross terms hold an arbitrary rotation of the separation"
            }
            _ => "as given in the error table",
        }
    }
}

/// What the error table says of itself, beside the doubts that the model tells.
fn said(remarks: &Remarks) -> impl Iterator<Item = Finding> {
    let missing = remarks.not_determined.iter();
    let missing =
        missing.map(|(term, why)| VolumeFinding::NotDetermined { term: *term, why: why.clone() });
    let reversal = remarks.hidden_reversal_um;
    let reversal = reversal.map(|um| ModelFinding::HiddenReversal { um }.into());
    let missing = missing.map(Finding::from);
    missing.chain(reversal).chain(remarks.notes.iter().cloned())
}

/// Values that no machine tool has, which are more often a unit error.
fn doubts(job: &Job, model: &ErrorModel) -> impl Iterator<Item = Finding> {
    let deviations = model
        .measured()
        .map(|(term, measured)| (term.to_string(), measured.largest_um(), "µm", UNLIKELY_UM));
    let angles = Rotation::all().filter_map(|rotation| {
        let curve = model.rotations[rotation].as_ref()?.mean();
        let (from, to) = curve.measured_range();
        let largest = curve.largest_magnitude(from, to);
        Some((rotation.to_string(), largest, "µrad", UNLIKELY_URAD))
    });
    let squareness = job.measurement.squareness.iter().map(|(term, slope)| {
        let name = Component::Squareness(*term).to_string();
        (name, slope.abs(), "µm/m", UNLIKELY_URAD)
    });
    let small = model.unlikely_small(job.measurement.uncertainty.noise_um);
    let small = small.map(|why| VolumeFinding::Doubtful { why });
    deviations
        .chain(angles)
        .chain(squareness)
        .filter(|(_, largest, _, limit)| largest > limit)
        .map(|(name, largest, unit, limit)| VolumeFinding::Unlikely { name, largest, unit, limit })
        .chain(small)
        .map(Finding::from)
}

/// Offsets that no axis reaches.
fn outside(job: &Job) -> Option<VolumeFinding> {
    let beyond = |axis: Axis| {
        let place = job.measurement.levers.offsets[axis]?.mm();
        let machine = job.machine.axes[axis]?;
        let (low, high) = (machine.low.mm(), machine.high.mm());
        let is_reached = (low..=high).contains(&place);
        (!is_reached).then(|| format!("{axis} {place} mm (its travel is {low} … {high} mm)"))
    };
    let places: Vec<String> = Axis::ALL.into_iter().filter_map(beyond).collect();
    (!places.is_empty()).then_some(VolumeFinding::OutOfReach { places })
}

/// An error table without a job.
pub(super) struct Table {
    /// The least job that it needs.
    pub(super) job: Job,
    pub(super) model: ErrorModel,
    pub(super) volume: VolumeModel,
    pub(super) basis: Basis,
}

/// The model of a table and what it rests on: each axis travels where it was measured, its reference is its lowest
/// measured position.
pub(super) fn of_table(file: &Given<'_>, chain: Option<Chain>) -> Result<Table, Problems> {
    let table = ErrorTable::read(file.source()?)?;
    let page = least_job(&table, chain);
    let job = Job::read_for(Source::from_bytes(&file.name, page.as_bytes())?, UseOf::Figures)?;
    let mut model = ErrorModel::for_figures(&job, &table)?;
    model.lacks_squareness(model.level());
    if chain.is_none() && model.rotations.iter().any(|(_, angle)| angle.is_some()) {
        return Err(Problem::new(
            "the table holds angles, which act through levers: the order of the axes is missing",
        )
        .at(table.header.clone())
        .help("give a job with `machine.chain`, or state it: `assess --chain wXYZt`")
        .into());
    }
    let volume = VolumeModel::build(&job, &model)?;
    let no_job = std::iter::once(VolumeFinding::NoJob.into());
    Ok(Table {
        basis: Basis::of(&job, &model, &model.remarks, &volume, no_job),
        job,
        model,
        volume,
    })
}

/// The least job that such a table needs.
fn least_job(table: &ErrorTable, chain: Option<Chain>) -> String {
    let chain = chain.map_or_else(String::new, |chain| format!("chain = \"{chain}\"\n"));
    let axes = Axis::ALL.into_iter().filter_map(|axis| {
        let positions = || table.series(axis).iter().flat_map(|s| &s.positions).map(|at| at.mm());
        let (low, high) = (positions().reduce(f64::min)?, positions().reduce(f64::max)?);
        let axis = axis.key();
        Some(format!(
            "[machine.axes.{axis}]\ntravel_mm = [{low:?}, {high:?}]\nreference_mm = {low:?}\n"
        ))
    });
    let axes: String = axes.collect();
    format!(
        "schema = 1\n[machine]\nname = \"error table\"\n{chain}{axes}[measurement]\nerrors = \"-\"\n"
    )
}

/// What the measurement says by itself.
#[derive(Serialize)]
pub(super) struct Found {
    terms: Named<ErrorTerm, Largest>,
    squareness: Named<&'static str, PlaneFigures>,
}

/// Of a term.
#[derive(Serialize)]
struct Largest {
    before_um: f64,
    u_um: Option<f64>,
    expanded_um: Option<f64>,
    at_most_um: Option<f64>,
}

impl Found {
    /// `errors`: where the model comes from; absent = from an error table alone.
    pub(super) fn of(job: &Job, model: &ErrorModel, errors: Option<&ErrorSource>) -> Found {
        let terms = alone(model, job).terms.into_iter().map(|found| {
            let Change { before_um, u_um, expanded_um, at_most_um, .. } = found.change;
            (found.term, Largest { before_um, u_um, expanded_um, at_most_um })
        });
        Found { terms: terms.collect(), squareness: planes((model, errors), None) }
    }
}
