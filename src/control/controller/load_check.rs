//! What a profile must keep to once every fact of it was read.

use crate::control::controller::{Dialect, Profile, Role};
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems, shown};

pub(super) fn check(profile: &Profile, source: &Source) -> Problems {
    let mut problems = Problems::none();
    ensure_three_axis_names(profile, source, &mut problems);
    ensure_a_table_is_written(profile, source, &mut problems);
    ensure_sensible_numbers(profile, source, &mut problems);
    problems
}

fn ensure_three_axis_names(profile: &Profile, source: &Source, problems: &mut Problems) {
    let names = &profile.axis_names.value;
    let path = "facts.axis_names.value";
    if names.len() != 3 {
        let message = format!("`axis_names` has {} names, expected three", names.len());
        problems.push(
            source
                .problem_at(path, message)
                .help("name the axes X, Y and Z of the machine, in this order"),
        );
    }
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let other = |name: &&String| name.is_empty() || !name.chars().all(plain);
    for name in names.iter().filter(other) {
        let message = format!(
            "`{}` is no axis name, expected letters, digits and `_`",
            shown(name)
        );
        problems.push(
            source
                .problem_at(path, message)
                .help("write it as the control shows it, e.g. `AX1`"),
        );
    }
}

fn ensure_a_table_is_written(profile: &Profile, source: &Source, problems: &mut Problems) {
    if !profile.files.iter().any(|file| file.role == Role::Table) {
        problems.push(source.problem_at(
            "files",
            "no file has the role `table`, expected at least one",
        ));
    }
}

fn ensure_sensible_numbers(profile: &Profile, source: &Source, problems: &mut Problems) {
    const MOST_DECIMALS: u32 = 9;
    let decimals = match &profile.dialect {
        Dialect::Siemens(facts) => vec![facts.value_decimals.value, facts.position_decimals.value],
        Dialect::Fanuc(facts) => {
            if facts.output_fraction.value >= 1.0 {
                problems.push(source.problem_at(
                    "facts.output_fraction.value",
                    "the place of a pulse must lie between 0 and 1",
                ));
            }
            if facts.increment_max.value == 0 || facts.magnification_max.value == 0 {
                problems.push(source.problem_at(
                    "facts",
                    "`increment_max` and `magnification_max` must be at least 1",
                ));
            }
            vec![
                facts.interval_decimals_mm.value,
                facts.interval_decimals_inch.value,
            ]
        }
        Dialect::Generic(_) => Vec::new(),
    };
    if decimals.iter().any(|d| *d > MOST_DECIMALS) {
        problems.push(Problem::new(format!(
            "`{}`: at most {MOST_DECIMALS} decimals can be written",
            source.name
        )));
    }
}
