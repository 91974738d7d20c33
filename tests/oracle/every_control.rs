//! One machine on every control: the table of docs/controllers.md is what `generate` and `verify` say.
use crate::support::*;
use nonius::control::controller::builtin;
use nonius::quantity::Axis::{X, Y, Z};
use serde_json::Value;

/// The golden machine of 900 mm with another control, and its kit, which has to be read back as what the job asks for.
fn visit(id: &str) -> (Visit, Value) {
    let visit = Visit::with_job("nine_errors_900/fanuc-30i.toml");
    visit.edit("job.toml", "fanuc-30i", id);
    let kit = visit.run("generate job.toml -o kit --format json").json();
    visit.run("verify job.toml --tables kit").says("job and tables agree");
    (visit, kit)
}

fn texts<'a>(values: &'a Value, key: &str) -> Vec<&'a str> {
    let values = values.as_array().into_iter().flatten(); // absent where there is none
    values.map(|value| value[key].as_str().unwrap()).collect()
}

/// The sign facts that this kit has a proof of, and how well each is known.
fn signs(id: &str, kit: &Value) -> String {
    let profile = builtin::profile(id).unwrap();
    let mut proofs = texts(&kit["sign_proofs"], "sign");
    proofs.dedup();
    let evidence = |sign: &&str| {
        let own = profile.statements.iter().find(|s| s.fact == *sign).unwrap();
        let evidence = serde_json::to_value(own.evidence).unwrap();
        format!("`{sign}` {}", evidence.as_str().unwrap())
    };
    match proofs[..] {
        [] => "no sign proof".to_string(),
        _ => proofs.iter().map(evidence).collect::<Vec<_>>().join(", "),
    }
}

fn row(id: &str, kit: &Value) -> String {
    let mut served = texts(&kit["tables"], "term");
    served.dedup();
    let after = |term: &&str| number(&kit["forecast"]["terms"][*term]["after_um"]);
    let left = served.iter().map(after).fold(0.0, f64::max);
    let all = number(&kit["forecast"]["max_residual_um"]);
    let served = if served.len() == 9 { "all nine".to_string() } else { served.join(" ") };
    let (signs, evidence) = (signs(id, kit), evidence(id));
    format!("| `{id}` | {served} | {left:.3} | {all:.3} | {signs} | {evidence} |\n")
}

#[test]
fn the_table_of_one_machine_is_what_every_control_gives_and_checklists_begin_with_the_work() {
    let mut table = String::from(
        "| control | terms with a table | left of these/µm | left of all nine/µm | sign | evidence |\n\
         | --- | --- | ---: | ---: | --- | --- |\n",
    );
    for id in builtin::ids() {
        let (visit, kit) = visit(id);
        table += &row(id, &kit);
        checklist_begins_with_the_work(id, &visit);
    }
    let begin = "<!-- tests/oracle/every_control.rs writes the table: NONIUS_UPDATE=1 -->\n";
    stands_between("docs/controllers.md", begin, "<!-- end -->", &table);
}

/// Few words stand above it, and what only has to be compared in the annex, with blanks in a size to write on; what is
/// overwritten or moves an axis is not hidden there.
fn checklist_begins_with_the_work(id: &str, visit: &Visit) {
    let sheet = visit.read("kit/checklist.md");
    let (work, annex) = sheet.split_once("\n## Annex").unwrap();
    let (above, _) = work.split_once("\n1. [ ] ").unwrap();
    let bullets = above.lines().filter(|line| line.starts_with("- ")).count();
    assert!(bullets <= 4, "{id}: {bullets} bullets above the steps\n{above}");
    let compared = work.contains("what the annex lists under this number");
    let found = sheet.contains("; found: ________") || work.contains(": found ________");
    assert_eq!(compared, found, "{id}");
    let page = visit.read("kit/checklist.html");
    assert!(page.contains(".annex li:has(.blank){font-size:9.6pt"), "{id}");
    for harm in ["must be free", "moves the axis", "moves axes"] {
        let mut hidden = annex.lines().filter(|line| line.contains("; found: "));
        assert_eq!(hidden.find(|line| line.contains(harm)), None, "{id}");
    }
    assert!(work.lines().count() <= 70, "{id}: too many lines before the annex\n{work}");
}

#[test]
fn the_900_mm_machine_is_as_an_independent_simulation_has_it() {
    let job = fixture("nine_errors_900/generic.toml");
    let slopes_um_per_m = [(X, Y, 19.166666667), (X, Z, -13.055555556), (Y, Z, 12.5)];
    let ranges_um = [18.543452999, 12.715510628, 13.843169661, 21.457424184];
    for (id, last_digits_um) in [("generic", 1e-6), ("siemens-840d-sl", 9.0 * 0.0005)] {
        let job = replaced(&job, "\"generic\"", &format!("\"{id}\""));
        let (inputs, kit) = generate(&job, &fixture("nine_errors_900/errors.csv"));
        for (first, second, phi) in slopes_um_per_m {
            near(id, inputs.model.squareness_um_per_m(first, second).unwrap(), phi, 1e-6);
        }
        for (n, own) in kit.forecast.diagonals.iter().enumerate() {
            let (name, change) = (own.diagonal.name(), own.change);
            assert_eq!(name, DIAGONALS[n]);
            near(name, change.before_um, ranges_um[n], 1e-6);
            // Table points lie on the measured ones: nothing but rounding is left.
            assert!(change.after_um <= 2.0 * last_digits_um, "{id} {name}: {}", change.after_um);
        }
    }
}
