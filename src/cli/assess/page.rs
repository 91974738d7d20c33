//! What `assess` prints, and what its figures rest on: frame, levers, tables that were active, how much
//! of the machine was measured (what is missing must not look like an error of 0); each error as it was measured.

use crate::cli::show::{PlaneFigures, planes};
use crate::inputs::error_table::Remarks;
use crate::inputs::job::{ActiveTables, Frame, Job};
use crate::judge::after::alone;
use crate::judge::forecast::Change;
use crate::kit::Inputs;
use crate::machine::findings::ModelFinding;
use crate::machine::model::ErrorModel;
use crate::page::{Ink, Locale, Picture, Side, volume};
use crate::quantity::{Axis, ErrorTerm, Millimetres, PerAxis, Rotation, Xyz};
use crate::text::{Finding, NamedEntries, Problem, Severity};
use crate::visit::inputs::CorrectedMachine;
use crate::volume::assessment::{Assessment, Grid, GridChoice, Request, assess};
use crate::volume::findings::VolumeFinding;
use crate::volume::volume_model::{Component, Missing, VolumeModel};
use serde::Serialize;

/// What is printed; the document for scripts is the same (contract §5).
#[derive(Serialize)]
pub(in crate::cli) struct Page {
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
    found: AsFound,
    /// As it is.
    #[serde(flatten)]
    pub(in crate::cli) before: Assessment,
    pub(super) missing: Vec<Missing>,
    labels: Vec<Finding>,
    /// As tables leave it.
    pub(super) after: Option<CorrectedMachine<Assessment>>,
}

impl Page {
    /// Of a machine as it was measured, and as tables leave it.
    pub(super) fn of(
        inputs: &Inputs,
        volume: VolumeModel,
        corrected: Option<CorrectedMachine>,
        grid: GridChoice,
        request: &Request,
    ) -> Result<Page, Problem> {
        let bare = inputs.under_tables.as_ref().map(|_| volume.with_errors_of(&inputs.model));
        let others = corrected.iter().map(|corrected| &corrected.volume).chain(&bare);
        let nodes = Grid::of(grid, &volume, &others.collect::<Vec<_>>())?;
        let mut basis = Basis::of(inputs, &volume);
        basis.labels.extend(corrected.iter().flat_map(|corrected| corrected.notes.clone()));
        if let (Some(active), Some(bare)) = (&mut basis.active, bare) {
            active.va_without_um = Some(va_um(&bare, &nodes)?);
        }
        let after = corrected.map(|corrected| {
            let figures = assess(&corrected.volume, &nodes, request)?;
            Ok::<_, Problem>(corrected.with(figures))
        });
        Ok(Page {
            name: inputs.job.machine.name.clone(),
            grid,
            errors_measured: volume.known_errors(),
            found: AsFound::of(inputs),
            before: assess(&volume, &nodes, request)?,
            missing: volume.missing(),
            volume,
            labels: [&basis.doubts[..], &basis.labels].concat(),
            basis,
            after: after.transpose()?,
        })
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
            assessment: &after.figures,
        });
        let sides: Vec<Side<'_>> = std::iter::once(before).chain(after).collect();
        volume(locale, &format!("{}: {}", self.name, locale.words("errors_in_volume")), &sides)
    }

    /// The machine as it is, and as tables leave it.
    pub(super) fn sides(&self) -> impl Iterator<Item = (&'static str, &Assessment)> {
        let after = self.after.as_ref();
        let after = after.map(|after| ("with the tables", &after.figures));
        std::iter::once(("as it is", &self.before)).chain(after)
    }
}

/// The volumetric accuracy of a machine at these nodes, µm.
pub(super) fn va_um(volume: &VolumeModel, nodes: &Grid) -> Result<f64, Problem> {
    Ok(assess(volume, nodes, &Request::default())?.definitions.va_um)
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
    pub(super) tool_offset_mm: Option<Xyz<Millimetres>>,
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
    fn of(inputs: &Inputs, volume: &VolumeModel) -> Basis {
        let (job, measured) = (&inputs.job, inputs.as_measured());
        let measurement = &job.measurement;
        let open = measurement.active == ActiveTables::NotStated;
        let open = open.then_some(VolumeFinding::ActiveNotStated);
        let stated = outside(job).into_iter().chain(open).map(Finding::from);
        let stated = stated.chain(inputs.notes.iter().cloned()).chain(measurement.notes());
        let labels = volume.labels.iter().cloned();
        let (doubtful, labels): (Vec<_>, Vec<_>) =
            labels.partition(|label| label.severity() == Severity::Doubt);
        let labels = labels.into_iter().chain(stated).chain(said(&inputs.model.remarks));
        let doubts = doubts(job, measured).chain(doubtful);
        let levers = &measurement.levers;
        let unknown = volume.unknown_axes();
        let range = |axis| (!unknown.contains(&axis)).then(|| volume.range(axis));
        let active = match &measurement.active {
            ActiveTables::Path(tables) => Some(tables.clone()),
            _ => None,
        };
        Basis {
            chain: volume.chain_is_stated.then(|| volume.chain.to_string()),
            frame: measured.remarks.frame.map_or("as given", Frame::word),
            volume_mm: PerAxis::from_fn(range),
            tool_offset_mm: levers.tool.map(Xyz),
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
    let reversal = remarks.hidden_reversal_um.map(|um| ModelFinding::HiddenReversal { um }.into());
    missing.map(Finding::from).chain(reversal).chain(remarks.notes.iter().cloned())
}

/// Values that no machine tool has, which are more often a unit error.
fn doubts(job: &Job, model: &ErrorModel) -> impl Iterator<Item = Finding> {
    let deviations = model
        .measured()
        .map(|(term, measured)| (term.to_string(), measured.largest_um(), "µm", UNLIKELY_UM));
    let angles = Rotation::all().filter_map(|rotation| {
        let curve = model.rotations[rotation].as_ref()?.mean();
        let (from, to) = curve.measured_range();
        Some((rotation.to_string(), curve.largest_magnitude(from, to), "µrad", UNLIKELY_URAD))
    });
    let squareness = job.measurement.squareness.iter().map(|(term, slope)| {
        (Component::Squareness(*term).to_string(), slope.abs(), "µm/m", UNLIKELY_URAD)
    });
    let small = model.unlikely_small(job.measurement.uncertainty.noise_um);
    deviations
        .chain(angles)
        .chain(squareness)
        .filter(|(_, largest, _, limit)| largest > limit)
        .map(|(name, largest, unit, limit)| VolumeFinding::Unlikely { name, largest, unit, limit })
        .chain(small.map(|why| VolumeFinding::Doubtful { why }))
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

/// What the measurement says by itself.
#[derive(Serialize)]
struct AsFound {
    terms: NamedEntries<ErrorTerm, Largest>,
    squareness: NamedEntries<&'static str, PlaneFigures>,
}

/// Of a term.
#[derive(Serialize)]
struct Largest {
    before_um: f64,
    u_um: Option<f64>,
    expanded_um: Option<f64>,
    at_most_um: Option<f64>,
}

impl AsFound {
    fn of(inputs: &Inputs) -> AsFound {
        let model = inputs.as_measured();
        let terms = alone(model, &inputs.job).terms.into_iter().map(|found| {
            let Change { before_um, u_um, expanded_um, at_most_um, .. } = found.change;
            (found.term, Largest { before_um, u_um, expanded_um, at_most_um })
        });
        AsFound { terms: terms.collect(), squareness: planes((model, Some(&inputs.errors)), None) }
    }
}
