//! Job TOML → [`crate::job::Job`]: every key of contract §2.3, and nothing else.

use crate::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::controller::LengthUnit;
use crate::curve::Interpolation;
use crate::document::Section;
use crate::fit::Fit;
use crate::job::{
    Acceptance, ActiveTables, AxisSettings, BacklashPolicy, Compensation, GridRequest, Limits,
    Machine, MachineAxis, Measurement, OutsideMeasured, WantedTerms,
};
use crate::problem::nearest;
use crate::units::Millimetres;

const DEFAULT_MAX_CORRECTION_UM: f64 = 500.0; // contract §2.3
const DEFAULT_MAX_SLOPE_UM_PER_MM: f64 = 1.0; // contract §2.3

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
            format!("`chain` is `{chain}`, expected each of X, Y, Z once, `w` where the workpiece is and `t` at the end"),
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
    let travel = section.pair("travel_mm");
    if let Some([low, high]) = travel
        && low >= high
    {
        section.problem(
            "travel_mm",
            format!("the travel ends at {high} mm, before it begins at {low} mm"),
            "write [smallest, largest] machine coordinate",
        );
    }
    let reference = section.number("reference_mm");
    let reference_direction = direction(section, "reference_direction");
    let max_feed = section.positive("max_feed_mm_per_min");
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
    // Keys of the contract that concern angles, readings and uncertainty of later steps.
    section.know(&[
        "angles",
        "offsets_mm",
        "tool_offset_mm",
        "uncertainty",
        "step_diagonal",
    ]);
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
    })
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
            format!("`terms` is `{word}`, expected `all` or a list of terms"),
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
                    format!("`{name}` stands twice in `terms`"),
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
    section.problem("terms", format!("unknown term `{name}`"), help);
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
    let detection_unit_um = section.positive("detection_unit_um");
    let first_point = section.whole("first_point");
    let parameter_3605 = bits(section, "parameter_3605");
    let interpolated = section.flag("interpolated").unwrap_or(false);
    let start_mm = section.number("start_mm");
    let end_mm = section.number("end_mm");
    if let (Some(start), Some(end)) = (start_mm, end_mm)
        && start >= end
    {
        section.problem(
            "end_mm",
            format!("the table ends at {end} mm, before it begins at {start} mm"),
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
    let spacing = section.positive("spacing_mm").map(GridRequest::Spacing);
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
        .positive("max_residual_um")
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
                format!("`{id}` is no axis name")
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
                format!("`{id}` stands twice"),
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
            format!("`{key}` is `{text}`, expected eight digits 0 or 1, bit 7 first"),
            "read the parameter out of the control and copy it, e.g. \"00000000\"",
        );
    }
    bits
}

fn limits(root: &Section<'_>) -> Limits {
    let section = root.section("limits");
    let read = |key, default| {
        section
            .as_ref()
            .and_then(|s| s.positive(key))
            .unwrap_or(default)
    };
    let limits = Limits {
        max_correction_um: read("max_correction_um", DEFAULT_MAX_CORRECTION_UM),
        max_slope_um_per_mm: read("max_slope_um_per_mm", DEFAULT_MAX_SLOPE_UM_PER_MM),
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
        max_deviation_um: section.positive("max_deviation_um"),
        max_diagonal_um: section.positive("max_diagonal_um"),
    };
    section.refuse_unknown_keys();
    acceptance
}
