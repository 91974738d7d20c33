//! Measured while tables were active: new = old + residual.
//!
//! A machine with known errors gets tables of other errors (on another grid), is measured under
//! them, and the new tables have to hold old + residual at their points, whatever the control.

use crate::support;
use crate::support::{Random, control, generate, inputs, response, um_at, words};
use nonius::judge::active::{ActiveControl, ReadOutFor, from_kit, from_read_out};
use nonius::judge::findings::InForecast;
use nonius::kit::{self, Inputs, Kit};
use nonius::quantity::axis::Direction;
use nonius::read::emulate::Response;
use nonius::text::finding::{Finding, Severity, of_severity};
use nonius::write::findings::TableFinding;
use std::fmt::Write;

/// What is told of the files that were active.
fn notes_of(active: &ActiveControl) -> String {
    words(&of_severity(&active.findings, Severity::Note)).join("\n")
}

/// A one-axis job with what is added to `[measurement]` and `[compensation]`.
fn small(controller: &str, measurement: &str, compensation: &str, axes: &str) -> String {
    format!(
        "schema = 1\n[machine]\nname = \"M\"\n[measurement]\nerrors = \"errors.csv\"\n{measurement}\n[compensation]\ncontroller = \"{controller}\"\n{compensation}\n[machine.axes.x]\ntravel_mm = [0, 100]\nreference_mm = 0\n[machine.axes.y]\ntravel_mm = [0, 100]\nreference_mm = 0\n{axes}"
    )
}

const ACTIVE: &str = "active_while_measuring = \"old\"";
const SIEMENS_AXES: &str = "[compensation.axes.x]\nspacing_mm = 50\nid = \"AX1\"\n[compensation.axes.y]\nspacing_mm = 50\nid = \"AX2\"\n";
const FANUC_AXES: &str = "[compensation.axes.x]\nspacing_mm = 50\nid = \"1\"\ndetection_unit_um = 1.0\n[compensation.axes.y]\nspacing_mm = 50\nid = \"2\"\ndetection_unit_um = 1.0\n";
const FULL: &str =
    "axis,position_mm,ex_um,ey_um\nx,0,0,0\nx,50,4,2\nx,100,8,-3\ny,0,0,0\ny,50,1,6\ny,100,5,3\n";
const EXX_ONLY: &str = "axis,position_mm,ex_um\nx,0,0\nx,50,1\nx,100,-1\n";

fn read_out(job: &str, errors: &str, file: &str) -> Result<Inputs, String> {
    let found = inputs(job, errors);
    from_read_out(
        &found.job,
        &found.profile,
        "old",
        vec![("old.txt".into(), file.into())],
        ReadOutFor::OldTables,
    )
    .and_then(|active| found.with_active(active))
    .map_err(|p| p.render())
}

#[test]
fn a_term_that_was_not_measured_is_kept_or_dropped_as_the_job_says() {
    let job = |more: &str| small("siemens-840d-sl", &format!("{ACTIVE}\n{more}"), "", SIEMENS_AXES);
    let (before, old) = generate(
        &small("siemens-840d-sl", "active_while_measuring = \"none\"", "", SIEMENS_AXES),
        FULL,
    );
    let files = || old.files.iter().map(|f| (f.path.clone(), f.bytes.clone())).collect();
    let with = |more: &str| {
        let found = inputs(&job(more), EXX_ONLY);
        let active =
            from_kit(&found.job, &found.profile, "old", &old.manifest_bytes().unwrap(), files())
                .unwrap();
        found.with_active(active)
    };
    let refused = with("").unwrap_err().render();
    for term in ["EYX", "EXY", "EYY"] {
        assert!(refused.contains(&format!("correct {term}, which was not measured")), "{refused}");
    }
    let kept = with("active_terms_not_measured = \"keep\"").unwrap();
    let new = kit::generate(&kept).unwrap();
    assert_eq!(new.forecast.terms.len(), 1, "only EXX was measured");
    let (was, is) = (control(&before.profile, &old), control(&kept.profile, &new));
    for (base, output) in [("AX1", "AX2"), ("AX2", "AX1"), ("AX2", "AX2")] {
        for x in [0.0, 20.0, 50.0, 90.0, 100.0] {
            let of = |c: &dyn nonius::read::emulate::Emulator| {
                um_at(&response(c, base, output, Direction::Plus), x)
            };
            assert!((of(was.as_ref()) - of(is.as_ref())).abs() < 1e-9, "{base}→{output} at {x}");
        }
    }
    let dropped = kit::generate(&with("active_terms_not_measured = \"drop\"").unwrap()).unwrap();
    let what: Vec<&str> = dropped.compiled.preconditions.iter().map(|p| p.what.as_str()).collect();
    for stale in [
        "SD41300 $SN_CEC_TABLE_ENABLE[0]",
        "SD41300 $SN_CEC_TABLE_ENABLE[1]",
        "MD32700 $MA_ENC_COMP_ENABLE[0,AX2]",
    ] {
        assert!(what.contains(&stale), "{stale} in {what:?}");
    }
}

#[test]
fn steps_are_taken_off_where_the_laser_stood_and_lines_between() {
    let job = small("fanuc-30i", ACTIVE, "", FANUC_AXES);
    let errors = "axis,position_mm,ex_um\nx,0,0\nx,50,4\nx,100,8\n";
    let (_, old) =
        generate(&small("fanuc-30i", "active_while_measuring = \"none\"", "", FANUC_AXES), errors);
    // The machine errs by 0.08 µm/mm; at 20 mm the step of the first section has not come, at 40 mm it has.
    let residual = "axis,position_mm,ex_um\nx,0,0\nx,20,1.6\nx,40,-0.8\nx,50,0\nx,100,0\n";
    let found = inputs(&job, residual);
    let files = old.files.iter().map(|f| (f.path.clone(), f.bytes.clone())).collect();
    let active =
        from_kit(&found.job, &found.profile, "old", &old.manifest_bytes().unwrap(), files).unwrap();
    let found = found.with_active(active).unwrap();
    let exx = nonius::quantity::axis::ErrorTerm::from_name("EXX").unwrap();
    let measured = found.model.terms[exx].as_ref().unwrap();
    let curve = measured.measured.curve(Direction::Plus).unwrap();
    for x in [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 75.0, 100.0] {
        let um = curve.at(nonius::quantity::units::Millimetres::new(x)).um();
        assert!((um - 0.08 * x).abs() < 1e-9, "{um} at {x}");
    }
}

/// Both directions, so that every policy is possible; X and Y each correct the other too.
const BOTH_WAYS: &str = "axis,direction,position_mm,ex_um,ey_um\nx,+,0,0,0\nx,+,50,4,2\nx,+,100,8,-3\nx,-,0,5,1\nx,-,50,9,3\nx,-,100,13,-2\ny,+,0,0,0\ny,+,50,1,6\ny,+,100,5,3\ny,-,0,1,4\ny,-,50,2,10\ny,-,100,6,7\n";
/// The policy of the tables in the control, and of the new ones.
const WAYS: [(&str, &str); 5] = [
    ("mean", "mean"),
    ("mean", "curve-and-parameter"),
    ("two-tables", "two-tables"),
    ("two-tables", "mean"),
    ("mean", "two-tables"),
];

fn old_and_new(controller: &str, axes: &str, (old, new): (&str, &str)) -> (Kit, String, String) {
    let job = |active: &str, policy: &str| {
        small(controller, active, &format!("backlash = \"{policy}\""), axes)
    };
    let none = "active_while_measuring = \"none\"";
    let (_, before) = generate(&job(none, old), BOTH_WAYS);
    let left = BOTH_WAYS.replace(",8,-3", ",3,1").replace(",13,-2", ",5,2");
    (before, job(ACTIVE, new), left)
}

fn files_of(kit: &Kit, role: nonius::control::controller::Role) -> Vec<nonius::read::KitFile<'_>> {
    let files = kit.files.iter().filter(|file| file.role == role);
    files.map(|file| nonius::read::KitFile { path: &file.path, role, bytes: &file.bytes }).collect()
}

/// What the axes get, at places on and between the points, in both directions.
fn acts(control: &dyn nonius::read::emulate::Emulator, names: [&str; 2]) -> Vec<f64> {
    let mut all = Vec::new();
    for base in names {
        for output in names {
            for direction in Direction::BOTH {
                let response = response(control, base, output, direction);
                all.extend([0.0, 20.0, 50.0, 75.0, 100.0].map(|x| um_at(&response, x)));
            }
        }
    }
    all
}

mod old_plus_residual;

mod read_outs;

mod siemens_control;

mod fanuc_control;

mod what_acted;

mod kits_on_disk;

#[test]
fn a_kit_of_another_machine_is_refused() {
    let job = |machine: &str| {
        let page = small("siemens-840d-sl", ACTIVE, "", SIEMENS_AXES);
        page.replace("name = \"M\"", machine)
    };
    let read = |kit_of: &str, job_of: &str| {
        let (_, old) = generate(&job(kit_of).replace("\"old\"", "\"none\""), FULL);
        let found = inputs(&job(job_of), FULL);
        let files = old.files.iter().map(|f| (f.path.clone(), f.bytes.clone()));
        let manifest = old.manifest_bytes().unwrap();
        from_kit(&found.job, &found.profile, "old", &manifest, files.collect())
            .map(|active| notes_of(&active))
            .map_err(|problems| problems.render())
    };
    let one = "name = \"M\"\nserial = \"1\"\nchain = \"wXYZt\"";
    assert_eq!(read(one, one).unwrap(), "");
    let other = read(&one.replace("\"1\"", "\"999\""), one).unwrap_err();
    assert!(other.contains("its serial number is `999`, that of the job `1`"), "{other}");
    let renamed = read(&one.replace("\"M\"", "\"other mill\""), one).unwrap();
    assert!(renamed.contains("the machine name `other mill`, the job `M`"), "{renamed}");
    let unsure = read("name = \"other mill\"", one).unwrap_err();
    assert!(unsure.contains("its name is `other mill`, that of the job `M`"), "{unsure}");
    let chain = read("name = \"M\"\nchain = \"XwYZt\"", one).unwrap_err();
    assert!(chain.contains("its chain is `XwYZt`, that of the job `wXYZt`"), "{chain}");
    assert_eq!(read("name = \"M\"", one).unwrap(), "", "what is not stated does not contradict");
}

#[test]
fn a_parameter_that_acted_without_tables_is_in_the_new_ones() {
    let job = |policy: &str, more: &str| {
        small(
            "siemens-840d-sl",
            &format!("active_while_measuring = \"none\"\n{more}"),
            &format!("backlash = \"{policy}\""),
            SIEMENS_AXES,
        )
    };
    let both = "axis,direction,position_mm,ex_um\nx,+,0,0\nx,+,100,2\nx,-,0,1\nx,-,100,3\n";
    let with = |policy: &str, more: &str| {
        let found = inputs(&job(policy, more), both);
        let active = nonius::judge::active::without_tables(&found.job, &found.profile).unwrap();
        let found = match active {
            Some(active) => found.with_active(active).unwrap(),
            None => found,
        };
        kit::generate(&found).unwrap_or_else(|p| panic!("{}", p.render()))
    };
    let minus_at_reference = |kit: &Kit| match &kit.compiled.tables {
        nonius::control::table::Tables::Siemens(tables) => tables.cec[1].values[0].unwrap(),
        _ => panic!("it is a Siemens control"),
    };
    let (zero, four) =
        (with("two-tables", ""), with("two-tables", "active_backlash_um = { x = 4.0 }"));
    // The laser saw 1 µm of lost motion; 4 µm more were taken up by the parameter that is now 0.
    assert_eq!(minus_at_reference(&zero), 0.001);
    assert_eq!(minus_at_reference(&four), 0.005);
    assert!(four.manifest.predecessor.is_none());
    let x = nonius::quantity::axis::Axis::X;
    let parameter = |more: &str| with("curve-and-parameter", more).plan.backlash_um[x].unwrap();
    assert!((parameter("") - 1.0).abs() < 1e-9);
    assert!((parameter("active_backlash_um = { x = 4.0 }") - 5.0).abs() < 1e-9);
    let says = |kit: &Kit| {
        let assumed =
            kit.manifest.assumptions.iter().any(|a| a.fact == "backlash_while_measuring_x");
        let noted = kit
            .manifest
            .notes
            .iter()
            .any(|n| matches!(n.kind(), Some(TableFinding::ParameterReplaced { .. })));
        let demanded =
            kit.manifest.preconditions.iter().any(|p| p.why.contains("as 0 while measuring"));
        [assumed, noted, demanded]
    };
    assert_eq!(says(&zero), [true; 3]);
    assert_eq!(says(&with("curve-and-parameter", "")), [true; 3]);
    assert_eq!(says(&four), [false; 3]);
    assert_eq!(says(&with("mean", "")), [false; 3], "the parameter stays as it was");
}
