//! What the reader and the emulated control make of a profile's examples, against what stands there.

use crate::control::controller::{Added, Example, Profile, Role};
use crate::quantity::{Direction, Figure, Millimetres};
use crate::read::emulate::Emulator;
use crate::read::family::{KitFile, emulator, read};
use crate::text::{Problem, Problems};

/// A correction of a manual is printed to this, µm.
const PRINTED_UM: f64 = 1e-3;

/// Reads the files of each example and compares what the control would add for them.
///
/// **limits** backlash parameters count as 0
pub fn check_examples(profile: &Profile) -> Result<(), Problems> {
    Problems::all(profile.examples.iter().map(|example| check(profile, example))).map(drop)
}

fn check(profile: &Profile, example: &Example) -> Result<(), Problems> {
    let role = Role::Table;
    let files = example.files.iter();
    let files = files.map(|own| KitFile { path: &own.path, role, bytes: own.text.as_bytes() });
    let files: Vec<KitFile<'_>> = files.collect();
    let wrong = |words: String| Problem::new(format!("example of {}: {words}", example.source));
    let read = read(profile, &files)?;
    let control = emulator(profile, &read.tables, &example.state());
    let control = control.map_err(|why| wrong(why.0))?;
    let compared = example.adds.iter().map(|added| {
        let other = otherwise(control.as_ref(), added);
        let help = "compare file, facts and what stands in `adds`";
        other.map_or(Ok(()), |words| Err(wrong(words).help(help)))
    });
    Problems::all(compared).map(drop)
}

/// What the control adds where it is not what stands there.
fn otherwise(control: &dyn Emulator, added: &Added) -> Option<String> {
    let Added { axis, by, at_mm, moving, um } = added;
    let base = by.as_ref().unwrap_or(axis);
    let ways = Direction::BOTH.into_iter().filter(|way| moving.is_none_or(|own| own == *way));
    let gets = |way: Direction| match control.response(base, axis, way) {
        Err(why) => Some(why.0),
        Ok(response) => {
            let got = response.correction(Millimetres::new(*at_mm)).um();
            ((got - um).abs() > PRINTED_UM).then(|| {
                let [got, um, at] = [got, *um, *at_mm].map(|own| Figure(own).trimmed(6));
                format!("{axis} gets {got} µm at {base} {at} mm moving in {way}, expected {um} µm")
            })
        }
    };
    ways.filter_map(gets).next()
}

#[cfg(test)]
mod tests {
    use super::check_examples;
    use crate::control::controller::builtin;

    #[test]
    fn every_profile_reads_its_examples_or_says_why_there_is_none() {
        for id in builtin::ids() {
            let mut profile = builtin::profile(id).unwrap();
            assert_eq!(profile.examples.is_empty(), profile.no_example.is_some(), "{id}");
            check_examples(&profile).unwrap_or_else(|p| panic!("{id}: {}", p.render()));
            for own in 0..profile.examples.len() {
                for added in 0..profile.examples[own].adds.len() {
                    profile.examples[own].adds[added].um += 0.01;
                    let told = check_examples(&profile).expect_err(id).render();
                    assert!(told.contains("expected"), "{told}");
                    profile.examples[own].adds[added].um -= 0.01;
                }
            }
        }
    }
}
