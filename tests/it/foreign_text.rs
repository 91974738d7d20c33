//! Text of others reaches no terminal, checklist or table with characters that a person does not see.

use crate::support::{Ran, Visit, nonius, own_profile, page, replaced};
use nonius::control::controller::builtin;
use serde_json::json;
use std::collections::HashSet;
use std::fs;
use std::process::Command;

/// Sets a terminal's title, turns the direction of the text, hides what follows, ends a line.
const FOREIGN: &str = "A\u{1b}]0;owned\u{7}\u{202e}B\u{9b}8mC\u{2028}D";

fn is_unseen(c: char) -> bool {
    let named = "\u{202e}\u{2028}\u{200b}".contains(c);
    named || (c.is_control() && !"\n\t".contains(c))
}

/// Runs the program, with arguments separated by a blank, and looks at everything that it tells.
#[track_caller]
fn told(visit: &Visit, command: &str) -> Ran {
    let mut program = Command::new(nonius());
    let program = program.args(command.split(' ')).current_dir(visit.folder());
    let output = program.output().expect("the program starts");
    let text = [&output.stdout[..], &output.stderr].concat();
    let text = String::from_utf8(text).expect("text");
    assert_eq!(text.chars().find(|c| is_unseen(*c)), None, "{command}\n{}", text.escape_debug());
    Ran::of(command, &output)
}

fn with_name(job: &str, name: &str) -> String {
    replaced(job, "name = \"VMC 400\"", &format!("name = {name}"))
}

#[test]
fn of_a_manifest() {
    let visit = Visit::of("start/errors");
    told(&visit, "generate job.toml -o kit");
    let mut document = visit.document("kit/manifest.json");
    for key in ["tool", "controller"] {
        document[key] = FOREIGN.into();
    }
    document["machine"] = json!({ "name": FOREIGN, "measured": FOREIGN });
    document["files"][0]["path"] = FOREIGN.into();
    document["inputs"][0]["path"] = FOREIGN.into();
    document["predecessor"] = json!({ "path": FOREIGN, "manifest_sha256": "0" });
    visit.put("kit/manifest.json", document.to_string());
    for format in ["text", "json"] {
        told(&visit, &format!("history kit --format {format}"));
        told(&visit, &format!("verify job.toml --tables kit --format {format}"));
    }
    document["files"] = json!([{ "path": format!("../{FOREIGN}"), "sha256": "0" }]);
    visit.put("kit/manifest.json", document.to_string());
    told(&visit, "history kit");
}

#[test]
fn of_comments_in_an_error_table() {
    let visit = Visit::of("start/errors");
    let table = visit.read("errors.csv");
    visit.put("errors.csv", format!("# doubt: {FOREIGN}\n# simulated: {FOREIGN}\n{table}"));
    told(&visit, "generate job.toml -o kit").says("owned"); // the doubt is told
    for (name, text) in visit.texts().iter().filter(|(name, _)| name.starts_with("kit/")) {
        assert_eq!(text.chars().find(|c| is_unseen(*c) && *c != '\r'), None, "{name}");
    }
    told(&visit, "assess errors.csv");
    told(&visit, "simulate job.toml --errors -o -");
}

#[test]
fn of_the_header_of_another_makers_file() {
    let visit = Visit::of("start/errors");
    visit.put("x.rtl", format!(
        "HEADER::\nFile type : rtl\nOwner: {FOREIGN}\nTARGET DATA::\nTarget-count: 2\nTargets :\n0 100\nFlags: 0 1 2 0\n\
         USER-TEXT::\nMachine: {FOREIGN},=cmd|1;\"@A1\nSerial No: {FOREIGN}\nDate: {FOREIGN}\nAxis:X\nTITLE: {FOREIGN}\n\
         RUNS::\nRun-count: 1\nDEVIATIONS::\nRun Target Data:\n1 1 0.5\n1 2 1.5\nEOF::\n"
    ));
    let stated = "--sign as-error --targets-run + --axis x --material-corrected yes";
    let import = "import x.rtl -o - --term EXX --first-target-at-mm 0";
    for command in [import, "standards x.rtl --runs unidirectional"] {
        let ran = told(&visit, &format!("{command} {stated}")).ends(0);
        let is_csv = command == import; // what a spreadsheet would take for a formula
        let is_text = ["'=cmd", ";\"'@A1"].iter().all(|text| ran.out.contains(text));
        assert!(!is_csv || is_text, "{}", ran.out);
    }
}

#[test]
fn of_names_of_machines_and_files() {
    let visit = Visit::of("start/errors");
    for name in ["A\\u202EB", "A\\u001BB", "A\\u2028B", "A\\u200BB"] {
        visit.put("named.toml", with_name(&visit.read("job.toml"), &format!("\"{name}\"")));
        told(&visit, "generate named.toml -o kit").ends(2).says("not seen");
    }
    #[cfg(unix)]
    {
        let odd = format!("{FOREIGN}.toml");
        told(&visit, &format!("generate {odd} -o kit"));
        fs::rename(visit.at("job.toml"), visit.at(&odd)).expect("a name");
        told(&visit, &format!("generate {odd} -o kit"));
    }
}

#[test]
fn of_a_template_reaches_no_control() {
    let visit = Visit::with_job("machines/five_points/klipper-skew.toml");
    let template = page("templates/klipper.cfg.tera");
    visit.put("shop.toml", page("controllers/klipper-skew.toml"));
    visit.edit("job.toml", "\"klipper-skew\"", "\"./shop.toml\"");
    for unseen in ["\u{202e}", "\u{200b}", "\u{200d}", "\u{a0}", "\u{2800}", "\u{1b}", "\r"] {
        visit.put("klipper.cfg.tera", template.replacen("printer", &format!("printer{unseen}"), 1));
        let ran = told(&visit, "generate job.toml -o kit").ends(2);
        ran.says("would hold a character that is not seen");
    }
}

#[test]
fn no_profile_names_a_file_that_a_laptop_or_shell_takes_for_something_else() {
    let visit = Visit::of("start/errors");
    visit.edit("job.toml", "siemens-840d-sl", "./shop.toml");
    for name in ["CON", "nul.csv", "Com1.MPF", "LPT9", "-rf", "A.", "..", "a/b", "a:b", "a b"] {
        let file = "[[files]]\nrole = \"table\"\ntemplate = \"generic.csv.tera\"\n";
        visit.put("shop.toml", own_profile("generic", &format!("{file}path = \"{name}\"\n")));
        told(&visit, "generate job.toml -o kit").ends(2).says("is no file name");
    }
}

/// Marks that mean something to a page, a drawing, a spreadsheet, a shell or a control.
const MARKS: &str = "A<b>\";(x)&";

/// A machine's name with them is refused or only shown; names of files and comments go nowhere.
#[test]
fn marks_of_others_mean_nothing() {
    let mut families = HashSet::new();
    for id in builtin::ids().into_iter().rev() {
        let visit = Visit::of("start/errors");
        let (named, table) = (format!("{MARKS}.toml"), format!("{MARKS}.csv"));
        visit.put(&table, format!("# {MARKS}\n{}", visit.read("errors.csv")));
        visit.edit("job.toml", "siemens-840d-sl", id);
        visit.edit("job.toml", "# detection_unit_um", "detection_unit_um");
        visit.edit("job.toml", "\"errors.csv\"", &format!("'{table}'"));
        let job = visit.read("job.toml");
        visit.put(&named, &job).put("machine.toml", with_name(&job, &format!("'{MARKS}'")));
        told(&visit, &format!("generate {named} -o kit --plot kit.svg")).answers();
        told(&visit, "generate machine.toml -o second");
        let dialect = builtin::profile(id).expect("a control").dialect;
        if families.insert(std::mem::discriminant(&dialect)) {
            told(&visit, &format!("report {named} --tables kit -o report.html"));
            told(&visit, "report machine.toml -o machine.html");
        }
        for (path, text) in visit.texts() {
            let name = path.rsplit('/').next().unwrap();
            let is_text_for_people = name.ends_with(".json") || name.ends_with(".md");
            let is_input = name.starts_with('A') || name == "machine.toml" || name == "job.toml";
            if !is_text_for_people && !is_input {
                assert!(!text.contains("<b>"), "{id}: {path}");
                let is_page = name.ends_with(".html") || name.ends_with(".svg");
                assert!(is_page || !text.contains("\";("), "{id}: {path}");
            }
        }
    }
}
