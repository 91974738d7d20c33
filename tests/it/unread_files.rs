//! What a control loads is protected: files without reader (role `report`) get no *pass*; changed or deleted they fail.

use crate::support::{Ran, Visit, own_profile, tree};
use std::fs;

const UNREAD: &str = "`loaded.csv` is not read back (role `report`)";
const CHANGED: &str = "`loaded.csv` was changed after it was made";
const VERIFY: &str = "verify job.toml --tables kit";

/// A kit of a control that loads `loaded.csv`, in a layout that no reader takes, with more keys; what `generate` said.
fn kit(keys: &str) -> (Visit, Ran) {
    let file = |role: &str, path: &str, template: &str| {
        format!("[[files]]\nrole = \"{role}\"\npath = \"{path}\"\ntemplate = \"{template}\"\n")
    };
    let table = file("table", "shop.csv", "generic.csv.tera");
    let loaded = file("report", "loaded.csv", "loaded.csv.tera");
    let checklist = file("checklist", "checklist.md", "checklist.md.tera");
    let shop = own_profile("generic", &format!("{table}{loaded}{keys}\n{checklist}"));
    let template = "place;value\n{% for row in rows -%}\n{{ row.position_mm }};{{ row.correction_um }}\n{% endfor -%}\n";
    let visit = Visit::with_job("nine_errors_900/generic.toml");
    visit
        .edit("job.toml", "controller = \"generic\"", "controller = \"shop.toml\"")
        .put("shop.toml", shop)
        .put("loaded.csv.tera", template);
    let ran = visit.run("generate job.toml -o kit");
    (visit, ran)
}

#[test]
fn a_file_that_no_reader_takes_gets_no_pass_unless_no_control_loads_it() {
    let (visit, ran) = kit("");
    ran.ends(1).says("verdict: undecided").says(UNREAD);
    for page in ["manifest.json", "checklist.md"] {
        assert!(visit.read(&format!("kit/{page}")).contains(UNREAD), "{page} says so too");
    }
    visit.run(VERIFY).ends(1).says("job and tables agree").says("verdict: undecided").says(UNREAD);
    fs::remove_file(visit.at("kit/manifest.json")).unwrap();
    visit.run(VERIFY).ends(1).says("verdict: undecided").says(UNREAD);
    // Notes in the checklist stay a note.
    let (visit, ran) = kit("loaded = false");
    ran.ends(0);
    visit.run(VERIFY).ends(0).says("verdict: pass").omits(UNREAD);
    visit
        .append("kit/checklist.md", "done, A.B.\n")
        .run(VERIFY)
        .ends(0)
        .says("`checklist.md` was changed after it was made");
}

/// A script that makes many kits asks for none: all else has the same bytes.
#[test]
fn a_kit_without_its_checklist_has_all_other_files() {
    let visit = Visit::with_job("nine_errors_900/siemens-840d-sl.toml");
    visit.yes("generate job.toml -q -o kit");
    visit.yes("generate job.toml -q -o bare --without-checklist");
    let [mut kit, mut bare] = ["kit", "bare"].map(|folder| tree(&visit.at(folder)));
    for pages in ["checklist.html", "checklist.md"] {
        assert!(kit.remove(pages).is_some() && !bare.contains_key(pages), "{pages}");
    }
    assert!(kit.remove("manifest.json") != bare.remove("manifest.json") && kit == bare);
    visit.run("verify job.toml --tables bare").ends(0).says("job and tables agree");
}

#[test]
fn a_file_that_no_reader_takes_fails_turned_deleted_or_unlisted_and_makes_no_predecessor() {
    for keys in ["", "loaded = false"] {
        let (visit, _) = kit(keys);
        let good = visit.read("kit/loaded.csv");
        let fails = |says: &str| {
            let ran = visit.run(VERIFY).ends(1).says("verdict: fail").says(says);
            ran.omits("what differs is something else");
        };
        // Its signs turned.
        visit.put("kit/loaded.csv", good.replace(";-", ";"));
        fails(CHANGED);
        visit.run("history kit").ends(1).says(CHANGED);
        let ran =
            visit.run_with("job.toml", "\"none\"", "\"kit\"", "generate job.toml -o new").ends(2);
        ran.says("`loaded.csv` of the kit `kit` was changed after it was made");
        fs::remove_file(visit.at("kit/loaded.csv")).unwrap();
        fails("`loaded.csv` is listed in manifest.json but missing");
        visit.put("kit/loaded.csv", good);
        visit.edit("kit/manifest.json", "\"loaded.csv\"", "\"shop.csv\"");
        fails("`loaded.csv` is not listed in manifest.json");
    }
}
