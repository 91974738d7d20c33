//! Measured while tables were active: new = old + residual.
//!
//! A machine with known errors gets tables of other errors (on another grid), is measured under
//! them, and the new tables have to hold old + residual at their points, whatever the control.

mod fanuc_control;
mod kits_on_disk;
mod old_plus_residual;
mod read_outs;
mod siemens_control;

use crate::support::{self, *};
use nonius::control::control_state::ControlState;
use nonius::control::controller::{Profile, Role, builtin};
use nonius::control::table::Tables;
use nonius::judge::active::{ActiveControl, ReadOutFor, from_kit, from_read_out, without_tables};
use nonius::judge::findings::InForecast;
use nonius::kit::{self, Inputs, Kit};
use nonius::quantity::{Axis, Direction, Millimetres};
use nonius::read::emulate::Emulator;
use nonius::text::{Finding, Problems, Severity, of_severity};
use nonius::write::findings::TableFinding;

fn notes_of(active: &ActiveControl) -> String {
    words(&of_severity(&active.findings, Severity::Note)).join("\n")
}

#[track_caller]
fn is_near(um: f64, wanted: f64) {
    assert!((um - wanted).abs() < 1e-9, "{um} µm, not {wanted}");
}

pub(super) fn small(controller: &str, measurement: &str, compensation: &str, axes: &str) -> String {
    format!(
        "schema = 1\n[machine]\nname = \"M\"\n[measurement]\nerrors = \"errors.csv\"\n{measurement}\n[compensation]\ncontroller = \"{controller}\"\n{compensation}\n[machine.axes.x]\ntravel_mm = [0, 100]\nreference_mm = 0\n[machine.axes.y]\ntravel_mm = [0, 100]\nreference_mm = 0\n{axes}"
    )
}

fn siemens(measurement: &str) -> String {
    small("siemens-840d-sl", measurement, "", SIEMENS_AXES)
}

fn fanuc(measurement: &str) -> String {
    small("fanuc-30i", measurement, "", FANUC_AXES)
}

const ACTIVE: &str = "active_while_measuring = \"old\"";
const KEEP: &str = "active_while_measuring = \"old\"\nactive_terms_not_measured = \"keep\"";
pub(super) const SIEMENS_AXES: &str = "[compensation.axes.x]\nspacing_mm = 50\nid = \"AX1\"\n[compensation.axes.y]\nspacing_mm = 50\nid = \"AX2\"\n";
pub(super) const FANUC_AXES: &str = "[compensation.axes.x]\nspacing_mm = 50\nid = \"1\"\ndetection_unit_um = 1.0\n[compensation.axes.y]\nspacing_mm = 50\nid = \"2\"\ndetection_unit_um = 1.0\n";
const FULL: &str =
    "axis,position_mm,ex_um,ey_um\nx,0,0,0\nx,50,4,2\nx,100,8,-3\ny,0,0,0\ny,50,1,6\ny,100,5,3\n";
const EXX_ONLY: &str = "axis,position_mm,ex_um\nx,0,0\nx,50,1\nx,100,-1\n";
/// 1 µm of lost motion.
const EXX_BOTH_WAYS: &str =
    "axis,direction,position_mm,ex_um\nx,+,0,0\nx,+,100,2\nx,-,0,1\nx,-,100,3\n";

/// The ENC_COMP table of AX1 with 0 at 0 mm and a value at 100 mm.
fn lec(mm: &str) -> String {
    format!(
        "$AA_ENC_COMP[0,0,AX1]=0\n$AA_ENC_COMP[0,1,AX1]={mm}\n$AA_ENC_COMP_STEP[0,AX1]=100\n$AA_ENC_COMP_MIN[0,AX1]=0\n$AA_ENC_COMP_MAX[0,AX1]=100\n"
    )
}

/// The inputs of a job while the tables of a file acted that was read out.
#[track_caller]
fn taken(job: &str, errors: &str, file: &str) -> Inputs {
    let found = inputs(job, errors);
    let files = vec![("old.txt".into(), file.into())];
    let read = from_read_out(&found.job, &found.profile, "old", files, ReadOutFor::OldTables);
    let taken = read.and_then(|active| found.with_active(active));
    taken.unwrap_or_else(|problems| panic!("{}\n{file}", problems.render()))
}

fn of_kit(found: &Inputs, old: &Kit) -> Result<ActiveControl, Problems> {
    let files = old.files.iter().map(|f| (f.path.clone(), f.bytes.clone())).collect();
    from_kit(&found.job, &found.profile, "old", &old.manifest_bytes().unwrap(), files)
}

#[test]
fn a_term_that_was_not_measured_is_kept_or_dropped_as_the_job_says() {
    let (before, old) = generate(&siemens(UNCORRECTED), FULL);
    let with = |more: &str| {
        let found = inputs(&siemens(&format!("{ACTIVE}\n{more}")), EXX_ONLY);
        let active = shown(of_kit(&found, &old));
        found.with_active(active)
    };
    let refused = with("").unwrap_err().render();
    for term in ["EYX", "EXY", "EYY"] {
        holds(&refused, &[&format!("correct {term}, which was not measured")]);
    }
    let kept = shown(with("active_terms_not_measured = \"keep\""));
    let new = shown(kit::generate(&kept));
    assert_eq!(new.forecast.terms.len(), 1, "only EXX was measured");
    let (was, is) = (control(&before.profile, &old), control(&kept.profile, &new));
    for (base, output) in [("AX1", "AX2"), ("AX2", "AX1"), ("AX2", "AX2")] {
        for x in [0.0, 20.0, 50.0, 90.0, 100.0] {
            let of = |c: &dyn Emulator| um_at(&response(c, base, output, Direction::Plus), x);
            is_near(of(was.as_ref()), of(is.as_ref()));
        }
    }
    let dropped = shown(kit::generate(&shown(with("active_terms_not_measured = \"drop\""))));
    let what = dropped.compiled.preconditions.iter().map(|p| format!("\n{}\n", p.what));
    let what: String = what.collect();
    let of_cec = [0, 1].map(|number| format!("\nSD41300 $SN_CEC_TABLE_ENABLE[{number}]\n"));
    holds(&what, &[&of_cec[0], &of_cec[1], "\nMD32700 $MA_ENC_COMP_ENABLE[0,AX2]\n"]);
}

#[test]
fn steps_are_taken_off_where_the_laser_stood_and_lines_between() {
    let errors = "axis,position_mm,ex_um\nx,0,0\nx,50,4\nx,100,8\n";
    let (_, old) = generate(&fanuc(UNCORRECTED), errors);
    // The machine errs by 0.08 µm/mm; at 20 mm the step of the first section has not come, at 40 mm it has.
    let residual = "axis,position_mm,ex_um\nx,0,0\nx,20,1.6\nx,40,-0.8\nx,50,0\nx,100,0\n";
    let found = inputs(&fanuc(ACTIVE), residual);
    let active = shown(of_kit(&found, &old));
    let found = shown(found.with_active(active));
    let measured = &found.model.terms[term("EXX")].as_ref().unwrap().measured;
    let curve = measured.curve(Direction::Plus).unwrap();
    for x in [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 75.0, 100.0] {
        is_near(curve.at(Millimetres::new(x)).um(), 0.08 * x);
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

/// The kit in the control, the job of the next one, and what was measured for it.
fn old_and_new(controller: &str, axes: &str, (old, new): (&str, &str)) -> (Kit, String, String) {
    let job = |active: &str, policy: &str| {
        small(controller, active, &format!("backlash = \"{policy}\""), axes)
    };
    let (_, before) = generate(&job(UNCORRECTED, old), BOTH_WAYS);
    let left = BOTH_WAYS.replace(",8,-3", ",3,1").replace(",13,-2", ",5,2");
    (before, job(ACTIVE, new), left)
}

/// What the axes get of tables, at places on and between the points, in both directions.
fn acts(profile: &Profile, tables: &Tables, state: &ControlState, names: [&str; 2]) -> Vec<f64> {
    let control = kit::emulator(profile, tables, state).unwrap_or_else(|no| panic!("{}", no.0));
    let mut all = Vec::new();
    for base in names {
        for output in names {
            for direction in Direction::BOTH {
                let response = response(control.as_ref(), base, output, direction);
                all.extend([0.0, 20.0, 50.0, 75.0, 100.0].map(|x| um_at(&response, x)));
            }
        }
    }
    all
}

/// Another serial number, chain or, where that is all there is, name: fixtures/cases/refuses/active.txt.
#[test]
fn a_kit_whose_name_alone_differs_is_told_and_what_is_not_stated_contradicts_nothing() {
    let one = "name = \"M\"\nserial = \"1\"\nchain = \"wXYZt\"";
    let renamed = one.replace("\"M\"", "\"other mill\"");
    let differs = "the machine name `other mill`, the job `M`";
    for (kit_of, said) in [(one, ""), (&renamed, differs), ("name = \"M\"", "")] {
        let job = |machine: &str| siemens(ACTIVE).replace("name = \"M\"", machine);
        let (_, old) = generate(&job(kit_of).replace("\"old\"", "\"none\""), FULL);
        let notes = notes_of(&shown(of_kit(&inputs(&job(one), FULL), &old)));
        assert!(notes.contains(said) && notes.is_empty() == said.is_empty(), "{notes}");
    }
}

#[test]
fn a_parameter_that_acted_without_tables_is_in_the_new_ones() {
    let with = |policy: &str, more: &str| {
        let policy = format!("backlash = \"{policy}\"");
        let job =
            small("siemens-840d-sl", &format!("{UNCORRECTED}\n{more}"), &policy, SIEMENS_AXES);
        let found = inputs(&job, EXX_BOTH_WAYS);
        let found = match shown(without_tables(&found.job, &found.profile)) {
            Some(active) => shown(found.with_active(active)),
            None => found,
        };
        shown(kit::generate(&found))
    };
    let four_um = "active_backlash_um = { x = 4.0 }";
    let minus_at_reference = |kit: &Kit| match &kit.compiled.tables {
        Tables::Siemens(tables) => tables.cec().nth(1).unwrap().values[0].unwrap(),
        _ => panic!("it is a Siemens control"),
    };
    let (zero, four) = (with("two-tables", ""), with("two-tables", four_um));
    // The laser saw 1 µm of lost motion; 4 µm more were taken up by the parameter that is now 0.
    assert_eq!(minus_at_reference(&zero), 0.001);
    assert_eq!(minus_at_reference(&four), 0.005);
    assert!(four.manifest.predecessor.is_none());
    let parameter = |kit: &Kit| kit.plan.backlash_um[Axis::X].unwrap();
    let beside = with("curve-and-parameter", "");
    is_near(parameter(&beside), 1.0);
    is_near(parameter(&with("curve-and-parameter", four_um)), 5.0);
    let says = |kit: &Kit| {
        let manifest = &kit.manifest;
        let is_it = |n: &Finding| matches!(n.kind(), Some(TableFinding::ParameterReplaced { .. }));
        [
            manifest.assumptions.iter().any(|a| a.fact == "backlash_while_measuring_x"),
            manifest.notes.iter().any(is_it),
            manifest.preconditions.iter().any(|p| p.why.contains("as 0 while measuring")),
        ]
    };
    assert_eq!([&zero, &beside, &four].map(says), [[true; 3], [true; 3], [false; 3]]);
    assert_eq!(says(&with("mean", "")), [false; 3], "the parameter stays as it was");
}
