//! One machine on every control: the table of docs/controllers.md is what `generate` and `verify` say.
use crate::support::*;
use nonius::control::controller::builtin;
use nonius::quantity::Axis;
use serde_json::Value;

/// The golden machine of 900 mm with another control, a detection unit of 1 µm where one is asked
/// for; and its kit, which has to be read back as what the job asks for.
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

/// Largest error of the forecast's figures: they are sums of a few rounded numbers, µm.
const FIGURE_UM: f64 = 1e-6;
/// Range of every body diagonal as measured, µm, from an independent simulation.
const DIAGONALS_UM: [f64; 4] = [18.543452999, 12.715510628, 13.843169661, 21.457424184];
/// φ of every pair of axes, µm/m, from the same simulation.
const SQUARENESS_UM_PER_M: [(Axis, Axis, f64); 3] =
    [(Axis::X, Axis::Y, 19.166666667), (Axis::X, Axis::Z, -13.055555556), (Axis::Y, Axis::Z, 12.5)];

#[test]
fn nine_errors_of_the_900_mm_machine_on_every_control() {
    let errors = fixture("nine_errors_900/errors.csv");
    for id in positioning_ids() {
        let example = if needs_unit(id) { "fanuc-30i" } else { "generic" };
        let job = fixture(&format!("nine_errors_900/{example}.toml"));
        let job = job.replace(&format!("\"{example}\""), &format!("\"{id}\""));
        let (inputs, kit) = generate(&job, &errors);
        assert_eq!(kit.manifest.controller, id);
        for (first, second, expected) in SQUARENESS_UM_PER_M {
            let phi = inputs.model.squareness_um_per_m(first, second).unwrap();
            near(id, phi, expected, FIGURE_UM);
        }
        let diagonals = kit.forecast.diagonals.iter();
        let names: Vec<&str> = diagonals.clone().map(|of| of.diagonal.name()).collect();
        assert_eq!(names, DIAGONALS);
        for (diagonal, before) in diagonals.zip(DIAGONALS_UM) {
            let (name, left) = (diagonal.diagonal, diagonal.change.after_um);
            near(id, diagonal.change.before_um, before, FIGURE_UM);
            // Without its straightness and squareness a diagonal may become larger.
            assert!(left < before || !kit.plan.omitted.is_empty(), "{id} {name}: {left} after");
            // Table points lie on the measured ones: nothing but rounding is left.
            let exact = match id {
                "generic" => FIGURE_UM,
                "siemens-840d-sl" => 9.0 * 0.0005,
                _ => continue,
            };
            assert!(left <= 2.0 * exact, "{id} {name}: {left} after");
        }
        let expected = match id {
            "fanuc-0i-f" | "fanuc-16i" | "isg-axis" => 3, // ISG has one for each axis
            _ if has_cross_terms(&inputs.profile) => 0,
            _ => 6, // no table moves another axis
        };
        assert_eq!(kit.plan.omitted.len(), expected, "{id}: terms without a table");
    }
}
