//! Kits that follow each other, as the program reads and writes them.

use super::*;

/// Runs the program in a directory: exit status and standard output.
fn nonius(directory: &std::path::Path, arguments: &str) -> (i32, String) {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_nonius"))
        .args(arguments.split_whitespace())
        .current_dir(directory)
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    (output.status.code().unwrap(), text)
}

#[test]
fn the_history_of_a_kit_is_followed_and_its_breaks_are_named() {
    let directory = tempfile::tempdir().unwrap();
    let at = directory.path();
    let job = |active: &str, errors: &str| {
        small(
            "siemens-840d-sl",
            &format!("active_while_measuring = \"{active}\""),
            "",
            SIEMENS_AXES,
        )
        .replace("errors.csv", errors)
    };
    std::fs::write(at.join("1.toml"), job("none", "1.csv")).unwrap();
    std::fs::write(at.join("2.toml"), job("kit1", "2.csv")).unwrap();
    std::fs::write(at.join("1.csv"), FULL).unwrap();
    std::fs::write(at.join("2.csv"), FULL.replace(",8,-3", ",1,1")).unwrap();
    for number in ["1", "2"] {
        let (status, text) = nonius(at, &format!("generate {number}.toml -o kit{number}"));
        assert_eq!(status, 0, "{text}");
        // What a person notes in it changes neither the update nor the chain.
        let checklist = at.join(format!("kit{number}/checklist.md"));
        let page = std::fs::read_to_string(&checklist).unwrap();
        std::fs::write(&checklist, format!("{page}\nMD32450 was 0.003\n")).unwrap();
    }
    let (status, text) = nonius(at, "verify 2.toml --tables kit2");
    assert!(status == 0 && text.contains("job and tables agree"), "{text}");
    let (status, text) = nonius(at, "history kit2");
    assert!(status == 0 && text.contains("1  kit1") && text.contains("begins here"), "{text}");
    std::fs::rename(at.join("kit1"), at.join("kit1.previous")).unwrap();
    assert_eq!(nonius(at, "history kit2").0, 0, "`--force` leaves it there");
    std::fs::rename(at.join("kit1.previous"), at.join("elsewhere")).unwrap();
    let (status, text) = nonius(at, "history kit2");
    assert!(
        status == 1 && text.contains("BREAKS here: the predecessor `kit1` is not found"),
        "{text}"
    );
    std::fs::rename(at.join("elsewhere"), at.join("kit1")).unwrap();
    std::fs::write(at.join("kit1/NONIUS_EEC.MPF"), "M30\n").unwrap();
    let (status, text) = nonius(at, "history kit2 --format json");
    assert!(status == 1 && text.contains("was changed after it was made"), "{text}");
}

#[test]
fn tables_that_a_kit_contains_are_not_removed_by_force() {
    let directory = tempfile::tempdir().unwrap();
    let at = directory.path();
    let job = |active: &str| {
        let measurement = format!("active_while_measuring = \"{active}\"");
        small("siemens-840d-sl", &measurement, "", SIEMENS_AXES)
    };
    std::fs::write(at.join("errors.csv"), FULL).unwrap();
    std::fs::write(at.join("1.toml"), job("none")).unwrap();
    std::fs::write(at.join("2.toml"), job("kit.previous")).unwrap();
    for kit in ["kit.previous", "kit"] {
        assert_eq!(nonius(at, &format!("generate 1.toml -o {kit}")).0, 0);
    }
    let read = || std::fs::read(at.join("kit.previous/manifest.json")).unwrap();
    let before = read();
    for (kit, expected) in [("kit", 0), ("kit/", 0), ("kit.previous", 2)] {
        let (status, _) = nonius(at, &format!("generate 2.toml -o {kit} --force"));
        assert_eq!(status, expected, "{kit}");
        assert_eq!(read(), before, "{kit}");
    }
    assert_eq!(nonius(at, "generate 2.toml -o other --force").0, 0);
}
