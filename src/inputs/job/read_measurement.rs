//! `[measurement]` of a job.

use crate::inputs::job::read_active::active;
use crate::inputs::job::read_diagonals::diagonals;
use crate::inputs::job::read_places::{places, some_places};
use crate::inputs::job::read_words::refuse_control_characters;
use crate::inputs::job::{Levers, MachineAxis, MeasuredData, Measurement, StatedUncertainty};
use crate::quantity::axis::{Axis, ErrorTerm, PerAxis};
use crate::text::document::Section;

pub(super) fn measurement(
    section: &Section<'_>,
    axes: &PerAxis<Option<MachineAxis>>,
) -> Option<Measurement> {
    let data = data(section, axes);
    let date = section.text("date");
    refuse_control_characters(section, "date", date.as_deref());
    let (active, active_settings) = active(section);
    let squareness = squareness(section);
    let protocol = section.section("protocol").map(|s| s.entries());
    let angles = section.text("angles");
    let levers = Levers {
        offsets: some_places(section, "offsets_mm"),
        tool: places(section, "tool_offset_mm"),
        angles_zero: some_places(section, "angles_zero_mm"),
        straightness_optic: some_places(section, "straightness_optic_mm"),
    };
    let uncertainty = uncertainty(section);
    section.refuse_unknown_keys();
    let data = data?;
    let notes = match &data {
        MeasuredData::Errors(_) => unused(&uncertainty),
        MeasuredData::Diagonals(_) => Vec::new(),
    };
    Some(Measurement {
        data,
        angles,
        levers,
        date,
        active,
        active_settings,
        squareness,
        protocol: protocol.unwrap_or_default(),
        uncertainty,
        notes,
    })
}

/// Exactly one of `errors` and `readings`.
fn data(section: &Section<'_>, axes: &PerAxis<Option<MachineAxis>>) -> Option<MeasuredData> {
    let errors = error_tables(section);
    let readings = section.text("readings");
    match (section.has("errors"), section.has("readings")) {
        (true, true) => both_given(section),
        (false, false) => neither_given(section, axes),
        (true, false) => {
            if section.has("step_diagonal") {
                section.problem(
                    "step_diagonal",
                    "`[measurement.step_diagonal]` describes how readings were taken; it is allowed only with readings",
                    "remove it: `errors` are separated already",
                );
            }
            return errors.map(MeasuredData::Errors);
        }
        (false, true) => {
            if !section.has("step_diagonal") {
                section.problem("step_diagonal", "there is no section [measurement.step_diagonal], which says how the readings were taken", STEP_DIAGONAL);
            }
            let how = section.section("step_diagonal");
            let measured = how.and_then(|how| diagonals(&how, axes, readings));
            return measured.map(MeasuredData::Diagonals);
        }
    }
    None
}

const STEP_DIAGONAL: &str = "add `[measurement.step_diagonal]` with `start_mm`, `size_mm`, `steps` and `order`; fixtures/start/readings/job.toml shows one";

/// How readings were taken is described, or nothing at all is named.
fn neither_given(section: &Section<'_>, axes: &PerAxis<Option<MachineAxis>>) {
    let Some(how) = section.section("step_diagonal") else {
        section.missing(
            "errors",
            "the path of an error table (or `readings` of the body diagonals)",
        );
        return;
    };
    section.missing(
        "readings",
        "the path of the readings that [measurement.step_diagonal] describes",
    );
    diagonals(&how, axes, None); // for its problems
}

/// The path of an error table, or a list of them.
fn error_tables(section: &Section<'_>) -> Option<Vec<String>> {
    if !section.is_list("errors") {
        return section.text("errors").map(|path| vec![path]);
    }
    let paths = section.texts("errors")?;
    if paths.is_empty() {
        section.problem(
            "errors",
            "the list of error tables is empty, expected at least one path",
            "write e.g. `errors = [\"x.csv\", \"y.csv\", \"z.csv\"]`",
        );
        return None;
    }
    Some(paths)
}

fn both_given(section: &Section<'_>) {
    section.has("step_diagonal");
    section.problem(
        "readings",
        "`errors` and `readings` are both given, expected one of the two",
        "keep `readings` to separate them now, or `errors` if they are separated already",
    );
}

/// What the job states and an error table has no use for, one sentence each.
fn unused(uncertainty: &StatedUncertainty) -> Vec<String> {
    let keys = uncertainty.keys_of_readings().into_iter();
    let sentence = |key| {
        format!(
            "`{key}` of [measurement.uncertainty] is not used by this version: the uncertainty of a term is what its `u_…` column, `noise_um` and `laser_ppm` state"
        )
    };
    keys.map(sentence).collect()
}

fn uncertainty(section: &Section<'_>) -> StatedUncertainty {
    let Some(section) = section.section("uncertainty") else {
        return StatedUncertainty::default();
    };
    let stated = StatedUncertainty {
        noise_um: section.not_negative("noise_um"),
        laser_ppm: section.not_negative("laser_ppm"),
        temperature_k: section.not_negative("temperature_k"),
        alpha_per_k: section.not_negative("alpha_per_k"),
        setup_ppm: section.not_negative("setup_ppm"),
        angle_urad: section.not_negative("angle_urad"),
        beam_mrad: section.not_negative("beam_mrad"),
        tilt_arcsec: section.not_negative("tilt_arcsec"),
    };
    section.refuse_unknown_keys();
    stated
}

fn squareness(measurement: &Section<'_>) -> Vec<(ErrorTerm, f64)> {
    let Some(section) = measurement.section("squareness_um_per_m") else {
        return Vec::new();
    };
    if measurement.has("readings") {
        measurement.problem(
            "squareness_um_per_m",
            "`[measurement.squareness_um_per_m]` is given together with readings of the body diagonals, which measure the squareness themselves",
            "remove it: it would be added twice",
        );
    }
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

#[cfg(test)]
mod tests {
    #![allow(clippy::expect_used, reason = "a test that cannot go on has to stop")]

    use crate::inputs::job::Job;
    use crate::text::document::Source;

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
temperature_k = 0.3
[compensation]
controller = "generic"
"#;

    #[test]
    fn what_is_stated_and_not_used_is_named() {
        let source = Source::from_bytes("job.toml", PAGE.as_bytes()).expect("it is text");
        let measurement = Job::read(source).expect("it is a job").measurement;
        assert_eq!(measurement.uncertainty.noise_um, Some(0.5));
        let keys = ["`temperature_k`"];
        assert_eq!(measurement.notes.len(), keys.len());
        for (sentence, key) in measurement.notes.iter().zip(keys) {
            assert!(sentence.contains(key), "{sentence}");
        }
    }
}
