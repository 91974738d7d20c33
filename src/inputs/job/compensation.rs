//! `[compensation]`: what the control shall hold.

use crate::control::controller::ControlUnit;
use crate::quantity::axis::{ErrorTerm, PerAxis};
use crate::quantity::curve::Interpolation;
use crate::quantity::fit::Fit;
use crate::text::document::keys::LIMITS;
use crate::text::document::{LONGEST_MM, Section};
use crate::text::problem::{did_you_mean, shown};
use crate::text::words::{Word, words};

/// What is asked of a job: whether it needs `[compensation]`, and which empty keys have to be filled in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UseOf {
    /// Tables for a control.
    Tables,
    /// Figures of the machine as it was measured: `[compensation]` may be absent, and of two
    /// directions the mean counts.
    Figures,
    /// The errors that readings hold.
    Separation,
    /// What a run of diagonals will determine: nothing is measured yet.
    Plan,
    /// Part programs of a run: nothing is measured yet.
    Programs,
    /// Nothing yet: every key may be empty.
    Begun,
}

impl UseOf {
    /// Figures, with tables beside them or without.
    pub const fn with(tables: bool) -> UseOf {
        match tables {
            true => UseOf::Tables,
            false => UseOf::Figures,
        }
    }

    /// Whether `[compensation]` may be absent.
    pub(super) const fn needs_control(self) -> bool {
        matches!(self, UseOf::Tables | UseOf::Programs)
    }

    /// Whether a key has to be filled in for it; `key` = its dotted path, entries of a list without number.
    pub(super) fn needs(self, key: &str) -> bool {
        let section = key.split('.').next().unwrap_or_default();
        match self {
            UseOf::Tables | UseOf::Figures => true,
            UseOf::Begun => false,
            UseOf::Separation => {
                matches!(section, "machine" | "measurement") || key == "compensation.backlash"
            }
            UseOf::Plan => section != "compensation" && !MEASURED.contains(&key),
            UseOf::Programs => {
                let of_control = ["compensation.controller", "compensation.control_unit"];
                let is_of_run = matches!(section, "machine" | "measurement" | "program");
                of_control.contains(&key) || is_of_run && !MEASURED.contains(&key)
            }
        }
    }
}

/// Keys of which nobody knows the value before the measurement.
const MEASURED: [&str; 5] = [
    "measurement.date",
    "measurement.active_while_measuring",
    "measurement.active_backlash_um",
    "measurement.step_diagonal.linear.slope_um_per_m",
    "measurement.step_diagonal.linear.u_um_per_m",
];

/// Which terms to compensate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WantedTerms {
    /// All that are measured and that the control can take.
    All,
    /// These.
    Listed(Vec<ErrorTerm>),
}

words! {
    /// What to do with the difference of the two directions of travel.
    pub enum BacklashPolicy {
        /// One table with the mean of both directions.
        Mean = "mean",
        /// One table for each direction.
        TwoTables = "two-tables",
        /// One table with the curve of the + direction.
        ForwardOnly = "forward-only",
        /// One table with the curve of the reference direction; −B goes to the backlash parameter.
        CurveAndParameter = "curve-and-parameter",
    }
}

impl BacklashPolicy {
    /// All of them.
    pub const ALL: [BacklashPolicy; 4] = [
        BacklashPolicy::Mean,
        BacklashPolicy::TwoTables,
        BacklashPolicy::ForwardOnly,
        BacklashPolicy::CurveAndParameter,
    ];
}

/// Policies as a job states them: `"mean"`, or `{ x = "two-tables", y = "mean" }`.
pub(crate) fn policies_as_stated(policies: &PerAxis<Option<BacklashPolicy>>) -> String {
    if let Some(policy) = policies.x.filter(|_| one_for_all(policies)) {
        return format!("\"{}\"", policy.word());
    }
    let own = policies.iter();
    let own = own.filter_map(|(axis, policy)| Some((axis, (*policy)?)));
    let each = own.map(|(axis, policy)| format!("{} = \"{}\"", axis.key(), policy.word()));
    format!("{{ {} }}", each.collect::<Vec<_>>().join(", "))
}

/// Whether all axes have the same policy, or none.
pub(crate) fn one_for_all(policies: &PerAxis<Option<BacklashPolicy>>) -> bool {
    policies.iter().all(|(_, policy)| *policy == policies.x)
}

/// How the points of a table are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GridRequest {
    /// This distance of two points, mm.
    Spacing(f64),
    /// This number of points.
    Points(u32),
    /// As few points as keep this residual, µm.
    MaxResidual(f64),
}

words! {
    /// Where the grid passes the measured range.
    pub enum OutsideMeasured {
        /// The end value is held, marked as not measured.
        Hold = "hold",
        /// Refused.
        Refuse = "refuse",
    }
}

/// `[compensation.axes.*]`.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisSettings {
    /// How its points are chosen.
    pub grid: Option<GridRequest>,
    /// How the control names its physical axes (several for a gantry); empty = the profile's default.
    pub ids: Vec<String>,
    /// Siemens: measuring system, 1 or 2.
    pub measuring_system: Option<u32>,
    /// Detection unit, µm.
    pub detection_unit_um: Option<f64>,
    /// Fanuc: first pitch point number of the axis.
    pub first_point: Option<u32>,
    /// Fanuc: bit parameter 3605 as found.
    pub parameter_3605: Option<u8>,
    /// Fanuc: interpolated pitch compensation (3605#1) is on; `None` = not stated.
    pub interpolated: Option<bool>,
    /// First point of the table, mm.
    pub start_mm: Option<f64>,
    /// Last point of the table, mm.
    pub end_mm: Option<f64>,
    /// Where the grid passes the measured range.
    pub outside: OutsideMeasured,
}

impl AxisSettings {
    /// Whether Fanuc 3605#1 is taken to be on: as stated, else as found, else off.
    pub(crate) fn is_interpolated(&self) -> bool {
        let found = self.parameter_3605.is_some_and(|bits| bits & 0b10 != 0);
        self.interpolated.unwrap_or(found)
    }
}

/// `[compensation]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Compensation {
    /// Id of a built-in profile, or the path of a user's own.
    pub controller: String,
    /// Basic system of the control.
    pub control_unit: ControlUnit,
    /// Which terms.
    pub terms: WantedTerms,
    /// What to do with two directions of each moving axis; no default where the data have two.
    pub backlash: PerAxis<Option<BacklashPolicy>>,
    /// Between measured points.
    pub curve: Interpolation,
    /// Table values.
    pub fit: Fit,
    /// Siemens: first CEC table that is free.
    pub first_table: Option<u32>,
    /// Fanuc: first straightness set that is free (from 1).
    pub first_set: Option<u32>,
    /// Fanuc: point numbers in use elsewhere, if the job states them.
    pub reserved_points: Option<Vec<[u32; 2]>>,
    /// Settings of each axis.
    pub axes: PerAxis<Option<AxisSettings>>,
}

impl Default for Compensation {
    /// What a job without `[compensation]` stands for: no control, straight lines between the
    /// measured points.
    fn default() -> Compensation {
        Compensation {
            controller: "generic".to_string(),
            control_unit: ControlUnit::Millimetre,
            terms: WantedTerms::All,
            backlash: PerAxis::default(),
            curve: Interpolation::Linear,
            fit: Fit::Sample,
            first_table: None,
            first_set: None,
            reserved_points: None,
            axes: PerAxis::default(),
        }
    }
}

const CURVES: [(&str, Interpolation); 3] = [
    ("linear", Interpolation::Linear),
    ("pchip", Interpolation::Pchip),
    ("natural-spline", Interpolation::NaturalSpline),
];
const FITS: [(&str, Fit); 3] =
    [("sample", Fit::Sample), ("least-squares", Fit::LeastSquares), ("minimax", Fit::Minimax)];

pub(super) fn compensation(section: &Section<'_>) -> Compensation {
    let controller = "an id of `nonius controllers list`, or the path of a profile";
    let reserved_points = section.whole_pairs("reserved_points");
    let mut blocks = reserved_points.iter().flatten();
    if let Some([first, last]) = blocks.find(|[first, last]| first > last) {
        let message = format!("the block [{first}, {last}] ends before it begins");
        section.problem("reserved_points", message, "write [first, last]");
    }
    let usual = Compensation::default();
    let controller = section.required_text("controller", controller);
    let control_unit = section.choice("control_unit", ControlUnit::WORDS);
    Compensation {
        controller: controller.unwrap_or_default(),
        control_unit: control_unit.unwrap_or(usual.control_unit),
        terms: terms(section),
        backlash: policies(section),
        curve: section.choice("curve", &CURVES).unwrap_or(usual.curve),
        fit: section.choice("fit", &FITS).unwrap_or(usual.fit),
        first_table: section.whole("first_table"),
        first_set: section.count("first_set", 1..=u32::MAX, "sets count from 1"),
        reserved_points,
        axes: section.axes(|axis| Some(axis_settings(axis))),
    }
}

/// One policy for all axes, or one for each.
fn policies(section: &Section<'_>) -> PerAxis<Option<BacklashPolicy>> {
    let words = BacklashPolicy::WORDS;
    if !section.is_section("backlash") {
        let policy = section.choice("backlash", words);
        return PerAxis::from_fn(|_| policy);
    }
    let policies = section.section("backlash").map(|own| {
        let policies = PerAxis::from_fn(|axis| own.choice(axis.key(), words));
        own.refuse_unknown_keys();
        policies
    });
    policies.unwrap_or_default()
}

const TERMS: &str = "write \"all\", or for instance [\"EXX\", \"EYX\"]";

/// `"all"`, or a list of terms, each once.
fn terms(section: &Section<'_>) -> WantedTerms {
    if !section.is_list("terms") {
        if let Some(word) = section.text("terms").filter(|word| word != "all") {
            let word = shown(&word);
            let message = format!("`terms` is `{word}`, expected `all` or a list of terms");
            section.problem("terms", message, TERMS);
        }
        return WantedTerms::All;
    }
    let names = section.texts("terms").unwrap_or_default();
    let mut listed = Vec::new();
    for name in &names {
        match ErrorTerm::from_name(name) {
            Some(term) if listed.contains(&term) => {
                let message = format!("`{}` is given twice in `terms`", shown(name));
                section.problem("terms", message, "remove one");
            }
            Some(term) => listed.push(term),
            None => unknown_term(section, name),
        }
    }
    if names.is_empty() {
        let message = "`terms` names no term, expected at least one";
        section.problem("terms", message, TERMS);
    }
    WantedTerms::Listed(listed)
}

fn unknown_term(section: &Section<'_>, name: &str) {
    let names: Vec<String> = ErrorTerm::ALL.iter().map(ToString::to_string).collect();
    let all = format!("terms: {}", names.join(", "));
    let help = did_you_mean(name, names.iter().map(String::as_str), &all);
    section.problem("terms", format!("unknown term `{}`", shown(name)), help);
}

fn axis_settings(section: &Section<'_>) -> AxisSettings {
    let system = "1 = motor encoder or first system, 2 = direct scale";
    let settings = AxisSettings {
        grid: grid_request(section),
        ids: axis_ids(section),
        measuring_system: section.count("measuring_system", 1..=2, system),
        detection_unit_um: section.between("detection_unit_um", 1e-6..=1000.0, "µm"),
        first_point: section.whole("first_point"),
        parameter_3605: bits(section, "parameter_3605"),
        interpolated: section.flag("interpolated"),
        start_mm: section.millimetres("start_mm"),
        end_mm: section.millimetres("end_mm"),
        outside: section.choice("outside", OutsideMeasured::WORDS).unwrap_or(OutsideMeasured::Hold),
    };
    if let (Some(start), Some(end)) = (settings.start_mm, settings.end_mm) {
        section.ascending("end_mm", [start, end]);
    }
    settings
}

fn grid_request(section: &Section<'_>) -> Option<GridRequest> {
    let spacing = section.between("spacing_mm", 1e-6..=LONGEST_MM, "mm");
    let points = section.count("points", 2..=u32::MAX, "write a larger number");
    let residual = section.between("max_residual_um", LIMITS, "µm");
    section.not_both("points", "spacing_mm", "keep one");
    section.not_both("max_residual_um", "spacing_mm", "keep one");
    section.not_both("max_residual_um", "points", "keep one");
    let spacing = spacing.map(GridRequest::Spacing);
    let points = points.map(GridRequest::Points);
    let residual = residual.map(GridRequest::MaxResidual);
    spacing.or(points).or(residual)
}

/// `id`, or the `ids` of a gantry.
fn axis_ids(section: &Section<'_>) -> Vec<String> {
    let id = section.text("id");
    let ids = section.texts("ids");
    let help = "`ids` is for a gantry of several physical axes";
    section.not_both("ids", "id", help);
    let key = if ids.is_some() { "ids" } else { "id" };
    let all: Vec<String> = ids.unwrap_or_else(|| id.into_iter().collect());
    for (index, id) in all.iter().enumerate() {
        let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let is_twice = all[..index].contains(id);
        if id.is_empty() || !id.chars().all(is_name) || is_twice {
            let what = if is_twice { "is given twice" } else { "is no name of an axis" };
            section.problem(
                key,
                format!("`{}` {what}, expected letters, digits and `_`", shown(id)),
                "write every physical axis once, as the control shows it, e.g. `AX1`",
            );
        }
    }
    all
}

fn bits(section: &Section<'_>, key: &'static str) -> Option<u8> {
    let text = section.text(key)?;
    let is_plain = text.len() == 8 && !text.contains('+');
    let bits = u8::from_str_radix(&text, 2).ok().filter(|_| is_plain);
    if bits.is_none() {
        let text = shown(&text);
        section.problem(
            key,
            format!("`{key}` is `{text}`, expected eight digits 0 or 1, bit 7 first"),
            "read the parameter out of the control and copy it, e.g. \"00000000\"",
        );
    }
    bits
}
