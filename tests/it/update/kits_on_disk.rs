//! Kits that follow each other, as the program reads and writes them.

use super::*;
use crate::support::{Ran, Visit, replaced};

fn job(active: &str) -> String {
    siemens(&format!("active_while_measuring = \"{active}\""))
}

#[test]
fn the_history_of_a_kit_is_followed_and_its_breaks_are_named() {
    let visit = Visit::new();
    visit.put("1.toml", job("none").replace("errors.csv", "1.csv"));
    visit.put("2.toml", job("kit1").replace("errors.csv", "2.csv"));
    visit.put("1.csv", FULL).put("2.csv", FULL.replace(",8,-3", ",1,1"));
    for number in [1, 2] {
        visit.yes(&format!("generate {number}.toml -o kit{number}"));
        // What a person notes in it changes neither the update nor the chain.
        let checklist = format!("kit{number}/checklist.md");
        visit.put(&checklist, visit.read(&checklist) + "\nMD32450 was 0.003\n");
    }
    visit.run("verify 2.toml --tables kit2").ends(0).says("job and tables agree");
    let history = || -> Ran { visit.run("history kit2") };
    let rename = |from: &str, to: &str| std::fs::rename(visit.at(from), visit.at(to)).unwrap();
    history().ends(0).says("1  kit1").says("begins here");
    rename("kit1", "kit1.previous"); // `--force` leaves it there
    history().ends(0);
    rename("kit1.previous", "elsewhere");
    history().ends(1).says("BREAKS here: the predecessor `kit1` is not found");
    // A kit of the name that its predecessor has is not taken for it.
    let manifest = visit.read("kit2/manifest.json");
    visit.put("kit2/manifest.json", replaced(&manifest, "\"kit1\"", "\"elsewhere/kit2\""));
    history().ends(1).says("BREAKS here: the predecessor `elsewhere/kit2` is not found");
    visit.put("kit2/manifest.json", manifest);
    rename("elsewhere", "kit1");
    visit.put("kit1/NONIUS_EEC.MPF", "M30\n");
    visit.run("history kit2 --format json").ends(1).says("was changed after it was made");
}

#[test]
fn tables_that_a_kit_contains_are_not_removed_by_force() {
    let visit = Visit::new();
    visit.put("errors.csv", FULL).put("1.toml", job("none")).put("2.toml", job("kit.previous"));
    visit.yes("generate 1.toml -o kit.previous");
    visit.yes("generate 1.toml -o kit");
    let before = visit.read("kit.previous/manifest.json");
    for (kit, expected) in [("kit", 0), ("kit/", 0), ("kit.previous", 2)] {
        visit.run(&format!("generate 2.toml -o {kit} --force")).ends(expected);
        assert_eq!(visit.read("kit.previous/manifest.json"), before, "{kit}");
    }
    visit.yes("generate 2.toml -o other --force");
}
