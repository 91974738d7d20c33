//! Whole files of a machine of five points an axis: a snapshot was checked by hand when it was accepted.
use crate::support::{self, five_points, fixtures, in_repository};
use nonius::control::controller::builtin;
use nonius::kit::Kit;

fn kit(profile: &str) -> Kit {
    let (job, errors) = five_points(profile);
    support::generate(&job.replace('\r', ""), &errors.replace('\r', "")).1
}

/// Control characters made visible; the line end of a file stays a line end.
fn visible(bytes: &[u8]) -> String {
    let units = bytes.chunks_exact(2).map(|two| u16::from_le_bytes([two[0], two[1]]));
    let text = match bytes.contains(&0) {
        false => String::from_utf8(bytes.to_vec()).unwrap(),
        true => format!("UTF-16LE\n{}", String::from_utf16(&units.collect::<Vec<_>>()).unwrap()),
    };
    text.replace("\n\r\r", "␊␍␍¶").replace("\r\n", "␍␊¶").replace('\r', "␍").replace('¶', "\n")
}

/// Compares with the snapshot of a name. How it was checked by hand stands in it, and stays when it is accepted anew.
pub(super) fn is_as_checked(name: &str, text: &str) {
    let kept = fixtures(&format!("../tests/it/snapshots/{name}.snap"));
    let kept = std::fs::read_to_string(kept).unwrap_or_default();
    let checked = kept.lines().find_map(|line| line.strip_prefix("description: "));
    let checked = checked.map(|words| serde_json::from_str(words).unwrap_or(words.to_string()));
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.set_description(checked.as_deref().unwrap_or("?"));
    settings.bind(|| insta::assert_snapshot!(name, text));
    assert!(checked.is_some(), "{name}.snap: add `description: ` how it was checked by hand");
}

/// A file without a snapshot differs too. All that differ are named at the end.
#[test]
fn every_file_of_every_profile_is_as_it_was_checked() {
    let mut differ = Vec::new();
    for profile in builtin::ids() {
        let mut files = kit(profile).files;
        // The printed checklist holds what the other one holds (tests/it/field_kit.rs): one shows its layout.
        files.retain(|file| file.path != "checklist.html" || profile == "generic");
        for file in &files {
            let name = format!("{profile}-{}", file.path);
            if std::panic::catch_unwind(|| is_as_checked(&name, &visible(&file.bytes))).is_err() {
                differ.push(name);
            }
        }
    }
    assert!(differ.is_empty(), "{differ:#?}");
}

#[test]
fn the_manifest_and_the_list_of_controllers_are_as_they_were_checked() {
    let manifest = kit("fanuc-0i-f").manifest_bytes().unwrap();
    is_as_checked("fanuc-0i-f-manifest.json", &visible(&manifest));
    is_as_checked("controllers-list", &in_repository("controllers list").ends(0).out);
}
