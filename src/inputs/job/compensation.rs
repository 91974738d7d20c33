//! `[compensation]`: what the control shall hold.

use crate::control::controller::ControlUnit;
use crate::inputs::refusals;
use crate::quantity::{ErrorTerm, Fit, Interpolation, PerAxis};
use crate::text::{LIMITS, LONGEST_MM, Section, Word, did_you_mean, joined, section, shown, words};

/// What is asked of a job: whether it needs `[compensation]`, and which empty keys have to be filled in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UseOf {
    /// Tables for a control.
    Tables,
    /// Figures of the machine as it was measured: `[compensation]` may be absent, and of two
    /// directions the mean counts.
    Figures,
    /// What would be read on that machine: like its figures, but angles alone will not do.
    Readings,
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
        if tables { UseOf::Tables } else { UseOf::Figures }
    }

    /// Whether a key has to be filled in for it; `key` = its dotted path, entries of a list without number.
    pub(super) fn needs(self, key: &str) -> bool {
        let section = key.split('.').next().unwrap_or_default();
        match self {
            UseOf::Tables | UseOf::Figures | UseOf::Readings => true,
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

/// Policies as a job states them: `"mean"`, or `{ x = "two-tables", y = "mean" }`.
pub(crate) fn policies_as_stated(policies: &PerAxis<Option<BacklashPolicy>>) -> String {
    if let Some(policy) = policies.x.filter(|_| one_for_all(policies)) {
        return format!("\"{}\"", policy.word());
    }
    let own = policies.iter().filter_map(|(axis, policy)| Some((axis, (*policy)?)));
    let each = own.map(|(axis, policy)| format!("{} = \"{}\"", axis.key(), policy.word()));
    format!("{{ {} }}", joined(each))
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

section! {
    /// `[compensation.axes.*]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct AxisSettings(section: &Section<'_>) {
        /// distance of the points; or points, or max_residual_um: exactly one
        spacing_mm: Option<f64> = between(1e-6..=LONGEST_MM, "mm");
        /// their number
        points: Option<u32> = count(2..=u32::MAX, "write a larger number");
        /// as few as keep this residual
        max_residual_um: Option<f64> = between(LIMITS, "µm");
        /// How its points are chosen.
        pub grid: Option<GridRequest> => grid(section, spacing_mm, points, max_residual_um);
        /// the physical axis on the control
        id: Option<String> = text();
        /// several of a gantry
        several as ids: Option<Vec<String>> = texts();
        /// How the control names its physical axes (several for a gantry); empty = the profile's default.
        pub ids: Vec<String> => ids(section, id.as_ref(), several.as_ref());
        /// Siemens: 1 or 2
        pub measuring_system: Option<u32> = count(1..=2, SYSTEMS);
        /// required on Fanuc; on generic tables it switches rounding on
        pub detection_unit_um: Option<f64> = between(1e-6..=1000.0, "µm");
        /// Fanuc: where the pitch points of this axis begin
        pub first_point: Option<u32> = whole();
        /// Fanuc: as found, bit 7 first
        pub parameter_3605: Option<u8> = parsed(bits, BITS);
        /// Fanuc: interpolated pitch compensation (3605#1) is on; absent: as the active tables hold it, else to be
        /// decided
        pub interpolated: Option<bool> = flag();
        /// with spacing_mm only: first point of the table
        pub start_mm: Option<f64> = millimetres();
        /// last point
        pub end_mm: Option<f64> = millimetres();
        /// where the grid passes the measured range; or "refuse"
        pub outside: OutsideMeasured = choice(OutsideMeasured::WORDS), or OutsideMeasured::Hold;
    }
}

const SYSTEMS: &str = "1 = motor encoder or first system, 2 = direct scale";
const BITS: [&str; 2] = [
    "eight digits 0 or 1, bit 7 first",
    "read the parameter out of the control and copy it, e.g. \"00000000\"",
];

impl AxisSettings {
    /// Whether Fanuc 3605#1 is taken to be on: as stated, else as found, else off.
    pub(crate) fn is_interpolated(&self) -> bool {
        self.interpolated.unwrap_or(self.parameter_3605.is_some_and(|bits| bits & 0b10 != 0))
    }
}

section! {
    /// `[compensation]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Compensation(section: &Section<'_>) {
        /// Fanuc: point numbers that are in use elsewhere
        pub reserved_points: Option<Vec<[u32; 2]>> = with(blocks);
        /// an id of `nonius controllers list`, or the path of a profile of one's own
        pub controller: String = text(), or "generic".to_string(), must CONTROLLER;
        /// "inch" where the basic system of the control is inch
        pub control_unit: ControlUnit = choice(ControlUnit::WORDS), or ControlUnit::Millimetre;
        /// all that are measured and that the control can take; or ["EXX", "EYY", …]
        pub terms: WantedTerms = with(terms);
        /// "mean", "two-tables", "forward-only" or "curve-and-parameter" (docs/method.md section 14)
        pub backlash: PerAxis<Option<BacklashPolicy>> = with(policies);
        /// "linear", "pchip", "natural-spline": between measured points
        pub curve: Interpolation = choice(&CURVES), or Interpolation::Linear;
        /// "sample", "least-squares", "minimax": table values
        pub fit: Fit = choice(&FITS), or Fit::Sample;
        /// Siemens: first CEC table that is free
        pub first_table: Option<u32> = whole();
        /// Fanuc: first straightness set that is free, from 1
        pub first_set: Option<u32> = count(1..=u32::MAX, "sets count from 1");
        /// every axis that moves in a compensated term
        pub axes: PerAxis<Option<AxisSettings>> = axes(|s, axis| s.sub(axis.key(), axis_settings));
    }
}

const CONTROLLER: &str = "an id of `nonius controllers list`, or the path of a profile";
const CURVES: [(&str, Interpolation); 3] = [
    ("linear", Interpolation::Linear),
    ("pchip", Interpolation::Pchip),
    ("natural-spline", Interpolation::NaturalSpline),
];
const FITS: [(&str, Fit); 3] =
    [("sample", Fit::Sample), ("least-squares", Fit::LeastSquares), ("minimax", Fit::Minimax)];

/// One policy for all axes, or one for each.
fn policies(section: &Section<'_>, key: &'static str) -> PerAxis<Option<BacklashPolicy>> {
    let words = BacklashPolicy::WORDS;
    if section.is_section(key) {
        return section.axes(key, |own, axis| own.choice(axis.key(), words));
    }
    let policy = section.choice(key, words);
    PerAxis::from_fn(|_| policy)
}

/// `"all"`, or a list of terms, each once.
fn terms(section: &Section<'_>, key: &'static str) -> WantedTerms {
    if !section.is_list(key) {
        if let Some(word) = section.text(key).filter(|word| word != "all") {
            section.refuse(key, refusals::no_terms_word(shown(&word)));
        }
        return WantedTerms::All;
    }
    let names = section.texts(key).unwrap_or_default();
    let mut listed = Vec::new();
    for name in &names {
        match ErrorTerm::from_name(name) {
            Some(term) if listed.contains(&term) => {
                section.refuse(key, refusals::term_twice(shown(name)));
            }
            Some(term) => listed.push(term),
            None => {
                let names = ErrorTerm::ALL.map(|term| term.to_string());
                let all = format!("terms: {}", names.join(", "));
                let help = did_you_mean(name, names.iter().map(String::as_str), &all);
                section.refuse(key, refusals::unknown_term(shown(name), help));
            }
        }
    }
    if names.is_empty() {
        section.refuse(key, refusals::no_term_at_all());
    }
    WantedTerms::Listed(listed)
}

fn axis_settings(section: &Section<'_>) -> Option<AxisSettings> {
    let settings = AxisSettings::read(section)?;
    if let (Some(start), Some(end)) = (settings.start_mm, settings.end_mm) {
        section.in_order("end_mm", [start, end]);
    }
    Some(settings)
}

fn grid(
    section: &Section<'_>,
    spacing_mm: Option<f64>,
    points: Option<u32>,
    max_residual_um: Option<f64>,
) -> Option<GridRequest> {
    section.not_both("points", "spacing_mm", "keep one");
    section.not_both("max_residual_um", "spacing_mm", "keep one");
    section.not_both("max_residual_um", "points", "keep one");
    let residual = max_residual_um.map(GridRequest::MaxResidual);
    spacing_mm.map(GridRequest::Spacing).or(points.map(GridRequest::Points)).or(residual)
}

/// `id`, or the `ids` of a gantry.
fn ids(section: &Section<'_>, id: Option<&String>, ids: Option<&Vec<String>>) -> Vec<String> {
    section.not_both("ids", "id", "`ids` is for a gantry of several physical axes");
    let key = if ids.is_some() { "ids" } else { "id" };
    let all = ids.cloned().unwrap_or_else(|| id.cloned().into_iter().collect());
    for (index, id) in all.iter().enumerate() {
        let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let is_twice = all[..index].contains(id);
        if id.is_empty() || !id.chars().all(is_name) || is_twice {
            let what = if is_twice { "is given twice" } else { "is no name of an axis" };
            section.refuse(key, refusals::no_axis_id(shown(id), what));
        }
    }
    all
}

fn bits(text: &str) -> Option<u8> {
    let is_plain = text.len() == 8 && !text.contains('+');
    u8::from_str_radix(text, 2).ok().filter(|_| is_plain)
}

/// Blocks of numbers, each from its first to its last.
fn blocks(section: &Section<'_>, key: &'static str) -> Option<Vec<[u32; 2]>> {
    let blocks = section.whole_pairs(key);
    let mut all = blocks.iter().flatten();
    if let Some([first, last]) = all.find(|[first, last]| first > last) {
        section.refuse(key, refusals::block_backwards(first, last));
    }
    blocks
}
