//! `[compensation]` of a job.

use crate::control::controller::LengthUnit;
use crate::inputs::job::read_words::{LARGEST_LIMIT, SMALLEST_LIMIT, axes};
use crate::inputs::job::{
    AxisSettings, BacklashPolicy, Compensation, GridRequest, OutsideMeasured, WantedTerms,
};
use crate::quantity::axis::ErrorTerm;
use crate::quantity::curve::Interpolation;
use crate::quantity::fit::Fit;
use crate::text::document::{LONGEST_MM, Section};
use crate::text::problem::{nearest, shown};

const SMALLEST_DETECTION_UNIT_UM: f64 = 1e-6;
const LARGEST_DETECTION_UNIT_UM: f64 = 1000.0;
const SMALLEST_SPACING_MM: f64 = 1e-6;

pub(super) fn compensation(section: &Section<'_>) -> Option<Compensation> {
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
