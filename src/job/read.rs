//! Job TOML → [`crate::job::Job`]: every key of contract §2.3, and nothing else.

use crate::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::controller::LengthUnit;
use crate::curve::Interpolation;
use crate::document::{LONGEST_MM, Section};
use crate::fit::Fit;
use crate::job::{
    Acceptance, ActiveTables, AxisSettings, BacklashPolicy, Compensation, GridRequest, Limits,
    Machine, MachineAxis, Measurement, OutsideMeasured, WantedTerms,
};
use crate::problem::{nearest, shown};
use crate::units::Millimetres;

const DEFAULT_MAX_CORRECTION_UM: f64 = 500.0; // contract §2.3
const DEFAULT_MAX_SLOPE_UM_PER_MM: f64 = 1.0; // contract §2.3

// Beyond these numbers a job describes no machine; within them no calculation overflows.
const SMALLEST_DETECTION_UNIT_UM: f64 = 1e-6;
const LARGEST_DETECTION_UNIT_UM: f64 = 1000.0;
const SMALLEST_SPACING_MM: f64 = 1e-6;
const SMALLEST_FEED_MM_PER_MIN: f64 = 1e-3;
const LARGEST_FEED_MM_PER_MIN: f64 = 1e6;
const SMALLEST_LIMIT: f64 = 1e-6;
const LARGEST_LIMIT: f64 = 1e9;

type Parts = (Machine, Measurement, Compensation, Limits, Acceptance);

pub(super) fn job(root: &Section<'_>) -> Option<Parts> {
    match root.whole("schema") {
        Some(1) => {}
        Some(other) => root.problem(
            "schema",
            format!("`schema` is {other}, but this version reads jobs with `schema = 1`"),
            "use the version of the program that the job was written for",
        ),
        None if root.has("schema") => {}
        None => root.problem(
            "schema",
            "`schema` is missing, expected `schema = 1` in the first line",
            "add `schema = 1` above everything else",
        ),
    }
    let machine = root.required_section("machine").and_then(|s| machine(&s));
    let measurement = root
        .required_section("measurement")
        .and_then(|s| measurement(&s));
    let compensation = root
        .required_section("compensation")
        .and_then(|s| compensation(&s));
    let limits = limits(root);
    let acceptance = acceptance(root);
    Some((machine?, measurement?, compensation?, limits, acceptance))
}

fn axes<T>(parent: &Section<'_>, read: impl Fn(&Section<'_>) -> Option<T>) -> PerAxis<Option<T>> {
    let Some(section) = parent.section("axes") else {
        return PerAxis::default();
    };
    let axes = PerAxis::from_fn(|axis| section.section(axis.key()).and_then(|axis| read(&axis)));
    section.refuse_unknown_keys();
    axes
}

fn machine(section: &Section<'_>) -> Option<Machine> {
    let name = section.required_text("name", "the machine's name");
    let serial = section.text("serial");
    refuse_control_characters(section, "name", name.as_deref());
    refuse_control_characters(section, "serial", serial.as_deref());
    let chain = section.text("chain");
    if let Some(chain) = &chain
        && !is_chain(chain)
    {
        section.problem(
            "chain",
            format!("`chain` is `{}`, expected each of X, Y, Z once, `w` where the workpiece is and `t` at the end", shown(chain)),
            "for instance `wXYZt`, `XwYZt` or `XYwZt`",
        );
    }
    let axes = axes(section, machine_axis);
    section.refuse_unknown_keys();
    Some(Machine {
        name: name?,
        serial,
        chain,
        axes,
    })
}

/// Such a text would reach files and the terminal as commands.
fn refuse_control_characters(section: &Section<'_>, key: &str, text: Option<&str>) {
    if text.is_some_and(|text| text.contains(char::is_control)) {
        section.problem(
            key,
            format!(
                "`{}` holds a line break or another control character",
                section.path_of(key)
            ),
            "write it in one line of plain letters and digits",
        );
    }
}

fn is_chain(text: &str) -> bool {
    let mut letters: Vec<char> = text.chars().collect();
    letters.sort_unstable();
    letters == ['X', 'Y', 'Z', 't', 'w'] && text.ends_with('t')
}

fn machine_axis(section: &Section<'_>) -> Option<MachineAxis> {
    if !section.has("travel_mm") {
        section.missing("travel_mm", "the ends of the travel, e.g. [0.0, 900.0]");
    }
    if !section.has("reference_mm") {
        section.missing(
            "reference_mm",
            "the machine coordinate of the reference point",
        );
    }
    let travel = section.pair_of_millimetres("travel_mm");
    if let Some([low, high]) = travel
        && low >= high
    {
        let message = if low > high {
            format!("the travel ends at {high} mm, before it begins at {low} mm")
        } else {
            format!("the travel begins and ends at {low} mm, expected two different ends")
        };
        section.problem(
            "travel_mm",
            message,
            "write [smallest, largest] machine coordinate",
        );
    }
    let reference = section.millimetres("reference_mm");
    let reference_direction = direction(section, "reference_direction");
    let max_feed = section.within(
        "max_feed_mm_per_min",
        SMALLEST_FEED_MM_PER_MIN,
        LARGEST_FEED_MM_PER_MIN,
        "mm/min",
    );
    section.refuse_unknown_keys();
    let [low, high] = travel.filter(|[low, high]| low < high)?;
    Some(MachineAxis {
        low: Millimetres::new(low),
        high: Millimetres::new(high),
        reference: Millimetres::new(reference?),
        reference_direction,
        max_feed,
    })
}

fn direction(section: &Section<'_>, key: &'static str) -> Option<Direction> {
    section.choice(key, &[("+", Direction::Plus), ("-", Direction::Minus)])
}

fn measurement(section: &Section<'_>) -> Option<Measurement> {
    let errors = section.text("errors");
    let readings = section.has("readings");
    if readings {
        section.problem("readings", "`readings` need the separation of the body diagonals, which this version does not have yet", "separate the readings first and give the nine errors as `errors = \"errors.csv\"`");
    } else if !section.has("errors") {
        section.missing("errors", "the path of an error table");
    }
    let date = section.text("date");
    refuse_control_characters(section, "date", date.as_deref());
    let active = active_tables(section);
    let squareness = section
        .section("squareness_um_per_m")
        .map(|s| squareness(&s));
    let protocol = section.section("protocol").map(|s| s.entries());
    let mut unused = angles(section);
    let noise_um = uncertainty(section, &mut unused);
    if !readings && section.has("step_diagonal") {
        section.problem(
            "step_diagonal",
            "`[measurement.step_diagonal]` describes how readings were taken; it is allowed only with readings",
            "remove it: `errors` are separated already",
        );
    }
    section.refuse_unknown_keys();
    if readings {
        return None;
    }
    Some(Measurement {
        errors: errors?,
        date,
        active,
        squareness: squareness.unwrap_or_default(),
        protocol: protocol.unwrap_or_default(),
        noise_um,
        unused,
    })
}

/// Checks what the job states for angles; gives a sentence for each that is not used.
fn angles(section: &Section<'_>) -> Vec<String> {
    let mut unused = Vec::new();
    if section.text("angles").is_some() {
        unused.push("`angles` is not used by this version, and its file is not read: angular errors are not compensated by these tables".to_string());
    }
    for key in ["offsets_mm", "tool_offset_mm"] {
        let Some(offsets) = section.section(key) else {
            continue;
        };
        for axis in Axis::ALL {
            offsets.millimetres(axis.key());
        }
        offsets.refuse_unknown_keys();
        unused.push(format!(
            "`[measurement.{key}]` is not used by this version: it matters with angles only, and angular errors are not compensated by these tables"
        ));
    }
    unused
}

/// The noise of `[measurement.uncertainty]`; the other parts are checked and named as not used.
fn uncertainty(section: &Section<'_>, unused: &mut Vec<String>) -> Option<f64> {
    let section = section.section("uncertainty")?;
    let noise_um = section.not_negative("noise_um");
    for key in ["laser_ppm", "temperature_k", "alpha_per_k"] {
        if section.not_negative(key).is_some() {
            unused.push(format!(
                "`{key}` of [measurement.uncertainty] is not used by this version: the uncertainty of a term is what its `u_…` column and `noise_um` state"
            ));
        }
    }
    section.refuse_unknown_keys();
    noise_um
}

fn active_tables(section: &Section<'_>) -> ActiveTables {
    match section.text("active_while_measuring").as_deref() {
        Some("none") => ActiveTables::None,
        Some(_) => {
            section.problem(
                "active_while_measuring",
                "tables that were active while measuring cannot be added yet",
                "measure with the compensation switched off and write \"none\"",
            );
            ActiveTables::NotStated
        }
        None => ActiveTables::NotStated,
    }
}

fn squareness(section: &Section<'_>) -> Vec<(ErrorTerm, f64)> {
    let pairs = [
        ("xy", Axis::X, Axis::Y),
        ("xz", Axis::X, Axis::Z),
        ("yz", Axis::Y, Axis::Z),
    ];
    let given = pairs
        .into_iter()
        .filter_map(|(key, of, along)| Some((ErrorTerm { of, along }, section.number(key)?)))
        .collect();
    section.refuse_unknown_keys();
    given
}

fn compensation(section: &Section<'_>) -> Option<Compensation> {
    let controller = section.required_text(
        "controller",
        "an id of `nonius controllers list`, or the path of a profile",
    );
    let control_unit = section
        .choice(
            "control_unit",
            &[("mm", LengthUnit::Millimetre), ("inch", LengthUnit::Inch)],
        )
        .unwrap_or(LengthUnit::Millimetre);
    let terms = terms(section);
    let backlash = section.choice(
        "backlash",
        &[
            BacklashPolicy::Mean,
            BacklashPolicy::TwoTables,
            BacklashPolicy::ForwardOnly,
            BacklashPolicy::CurveAndParameter,
        ]
        .map(|policy| (policy.word(), policy)),
    );
    let curve = section.choice(
        "curve",
        &[
            ("linear", Interpolation::Linear),
            ("pchip", Interpolation::Pchip),
            ("natural-spline", Interpolation::NaturalSpline),
        ],
    );
    let fit = section.choice(
        "fit",
        &[
            ("sample", Fit::Sample),
            ("least-squares", Fit::LeastSquares),
            ("minimax", Fit::Minimax),
        ],
    );
    let first_table = section.whole("first_table");
    let first_set = section.whole("first_set");
    if first_set == Some(0) {
        section.problem(
            "first_set",
            "`first_set` is 0, but straightness sets count from 1",
            "write `first_set = 1`",
        );
    }
    let reserved_points = section.whole_pairs("reserved_points").unwrap_or_default();
    if let Some([first, last]) = reserved_points.iter().find(|[first, last]| first > last) {
        section.problem(
            "reserved_points",
            format!("the block [{first}, {last}] ends before it begins"),
            "write [first, last]",
        );
    }
    let axes = axes(section, axis_settings);
    section.refuse_unknown_keys();
    Some(Compensation {
        controller: controller?,
        control_unit,
        terms,
        backlash,
        curve: curve.unwrap_or(Interpolation::Linear),
        fit: fit.unwrap_or(Fit::Sample),
        first_table,
        first_set,
        reserved_points,
        axes,
    })
}

fn terms(section: &Section<'_>) -> WantedTerms {
    if section.is_list("terms") {
        return listed_terms(section);
    }
    if let Some(word) = section.text("terms").filter(|word| word != "all") {
        let help = match ErrorTerm::from_name(&word) {
            Some(term) => format!("write `terms = [\"{term}\"]`"),
            None => "write \"all\", or for instance [\"EXX\", \"EYX\"]".to_string(),
        };
        section.problem(
            "terms",
            format!(
                "`terms` is `{}`, expected `all` or a list of terms",
                shown(&word)
            ),
            help,
        );
    }
    WantedTerms::All
}

fn listed_terms(section: &Section<'_>) -> WantedTerms {
    let mut listed = Vec::new();
    for name in section.texts("terms").unwrap_or_default() {
        match ErrorTerm::from_name(&name) {
            Some(term) if listed.contains(&term) => {
                section.problem(
                    "terms",
                    format!("`{}` stands twice in `terms`", shown(&name)),
                    "remove one",
                );
            }
            Some(term) => listed.push(term),
            None => unknown_term(section, &name),
        }
    }
    if listed.is_empty() {
        section.problem(
            "terms",
            "`terms` names no term, expected at least one",
            "write \"all\", or for instance [\"EXX\", \"EYX\"]",
        );
    }
    WantedTerms::Listed(listed)
}

fn unknown_term(section: &Section<'_>, name: &str) {
    let names: Vec<String> = ErrorTerm::ALL.iter().map(ToString::to_string).collect();
    let help = match nearest(name, names.iter().map(String::as_str)) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("terms: {}", names.join(", ")),
    };
    section.problem("terms", format!("unknown term `{}`", shown(name)), help);
}

fn axis_settings(section: &Section<'_>) -> Option<AxisSettings> {
    let grid = grid_request(section);
    let ids = axis_ids(section);
    let measuring_system = section.whole("measuring_system");
    if let Some(system) = measuring_system.filter(|e| !(1..=2).contains(e)) {
        section.problem(
            "measuring_system",
            format!("`measuring_system` is {system}, expected 1 or 2"),
            "1 = motor encoder or first system, 2 = direct scale",
        );
    }
    let detection_unit_um = section.within(
        "detection_unit_um",
        SMALLEST_DETECTION_UNIT_UM,
        LARGEST_DETECTION_UNIT_UM,
        "µm",
    );
    let first_point = section.whole("first_point");
    let parameter_3605 = bits(section, "parameter_3605");
    let interpolated = section.flag("interpolated");
    let start_mm = section.millimetres("start_mm");
    let end_mm = section.millimetres("end_mm");
    if let (Some(start), Some(end)) = (start_mm, end_mm)
        && start >= end
    {
        let message = if start > end {
            format!("the table ends at {end} mm, before it begins at {start} mm")
        } else {
            format!("the table begins and ends at {start} mm, expected two different ends")
        };
        section.problem(
            "end_mm",
            message,
            "give the smaller coordinate as `start_mm`",
        );
    }
    let outside = section.choice(
        "outside",
        &[
            ("hold", OutsideMeasured::Hold),
            ("refuse", OutsideMeasured::Refuse),
        ],
    );
    section.refuse_unknown_keys();
    Some(AxisSettings {
        grid,
        ids,
        measuring_system,
        detection_unit_um,
        first_point,
        parameter_3605,
        interpolated,
        start_mm,
        end_mm,
        outside: outside.unwrap_or(OutsideMeasured::Hold),
    })
}

fn grid_request(section: &Section<'_>) -> Option<GridRequest> {
    let spacing = section
        .within("spacing_mm", SMALLEST_SPACING_MM, LONGEST_MM, "mm")
        .map(GridRequest::Spacing);
    let points = section.whole("points");
    if let Some(few) = points.filter(|n| *n < 2) {
        section.problem(
            "points",
            format!("`points` is {few}, expected at least 2"),
            "write a larger number",
        );
    }
    let points = points.map(GridRequest::Points);
    let residual = section
        .within("max_residual_um", SMALLEST_LIMIT, LARGEST_LIMIT, "µm")
        .map(GridRequest::MaxResidual);
    let given: Vec<GridRequest> = [spacing, points, residual].into_iter().flatten().collect();
    if given.len() > 1 {
        let key = if points.is_some() {
            "points"
        } else {
            "max_residual_um"
        };
        section.problem(key, format!("[{}] asks for its grid in {} ways, expected one of `spacing_mm`, `points`, `max_residual_um`", section.path(), given.len()), "keep one");
    }
    given.first().copied()
}

fn axis_ids(section: &Section<'_>) -> Vec<String> {
    let id = section.text("id");
    let ids = section.texts("ids");
    if id.is_some() && ids.is_some() {
        section.problem(
            "ids",
            "`id` and `ids` are both given, expected one",
            "`ids` is for a gantry of several physical axes",
        );
    }
    let all: Vec<String> = ids.unwrap_or_else(|| id.into_iter().collect());
    for (index, id) in all.iter().enumerate() {
        let key = if section.as_written("ids").is_some() {
            "ids"
        } else {
            "id"
        };
        if id.is_empty() || !id.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            let found = if id.is_empty() {
                "an axis name is empty".to_string()
            } else {
                format!("`{}` is no axis name", shown(id))
            };
            section.problem(
                key,
                format!("{found}, expected letters, digits and `_`"),
                "write it as the control shows it, e.g. `AX1`",
            );
        }
        if all[..index].contains(id) {
            section.problem(
                key,
                format!("`{}` stands twice", shown(id)),
                "every physical axis once",
            );
        }
    }
    all
}

fn bits(section: &Section<'_>, key: &'static str) -> Option<u8> {
    let text = section.text(key)?;
    let bits = (text.len() == 8)
        .then(|| u8::from_str_radix(&text, 2).ok())
        .flatten();
    if bits.is_none() || text.contains('+') {
        section.problem(
            key,
            format!(
                "`{key}` is `{}`, expected eight digits 0 or 1, bit 7 first",
                shown(&text)
            ),
            "read the parameter out of the control and copy it, e.g. \"00000000\"",
        );
    }
    bits
}

fn limits(root: &Section<'_>) -> Limits {
    let section = root.section("limits");
    let read = |key, unit, default| {
        section
            .as_ref()
            .and_then(|s| s.within(key, SMALLEST_LIMIT, LARGEST_LIMIT, unit))
            .unwrap_or(default)
    };
    let limits = Limits {
        max_correction_um: read("max_correction_um", "µm", DEFAULT_MAX_CORRECTION_UM),
        max_slope_um_per_mm: read("max_slope_um_per_mm", "µm/mm", DEFAULT_MAX_SLOPE_UM_PER_MM),
    };
    if let Some(section) = section {
        section.refuse_unknown_keys();
    }
    limits
}

fn acceptance(root: &Section<'_>) -> Acceptance {
    let Some(section) = root.section("acceptance") else {
        return Acceptance::default();
    };
    let acceptance = Acceptance {
        max_deviation_um: section.within("max_deviation_um", SMALLEST_LIMIT, LARGEST_LIMIT, "µm"),
        max_diagonal_um: section.within("max_diagonal_um", SMALLEST_LIMIT, LARGEST_LIMIT, "µm"),
    };
    section.refuse_unknown_keys();
    acceptance
}

#[cfg(test)]
mod tests {
    #![allow(clippy::expect_used, reason = "a test that cannot go on has to stop")]

    use crate::document::Source;
    use crate::job::Job;

    const PAGE: &str = r#"
schema = 1
[machine]
name = "VMC"
[measurement]
errors = "errors.csv"
angles = "angles.csv"
offsets_mm = { x = 1.0, y = 2.0, z = 3.0 }
[measurement.uncertainty]
noise_um = 0.5
laser_ppm = 0.1
[compensation]
controller = "generic"
"#;

    #[test]
    fn what_is_stated_and_not_used_is_named() {
        let source = Source::from_bytes("job.toml", PAGE.as_bytes()).expect("it is text");
        let measurement = Job::read(source).expect("it is a job").measurement;
        assert_eq!(measurement.noise_um, Some(0.5));
        let keys = ["`angles`", "offsets_mm", "`laser_ppm`"];
        assert_eq!(measurement.unused.len(), keys.len());
        for (sentence, key) in measurement.unused.iter().zip(keys) {
            assert!(sentence.contains(key), "{sentence}");
        }
    }
}
