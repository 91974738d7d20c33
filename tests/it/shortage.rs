//! Controls with fewer tables than terms, and tables at the reference.
use crate::support;
use nonius::control::claims::{Precondition, SeenTo};
use nonius::control::controller::builtin;
use nonius::kit::Kit;
use nonius::machine::model::ErrorModel;
use nonius::quantity::ErrorTerm;
use nonius::text::Finding;
use nonius::write::findings::TableFinding;
use nonius::write::plan::{PlannedTable, Task, plan};

pub(super) fn job(controller: &str, more: &str, reference: f64, spacing: f64) -> String {
    let keys = format!("spacing_mm = {spacing:?}\ndetection_unit_um = 1.0");
    let axes = ["x", "y", "z"].map(|axis| (axis, [0.0, 100.0], reference, keys.clone()));
    support::job_of(support::UNCORRECTED, &format!("controller = \"{controller}\"\n{more}"), axes)
}

/// What is planned is what a kit holds: four whole kits of each control show it.
#[test]
fn every_table_is_exactly_zero_at_a_reference_between_measured_points() {
    for id in support::any_grid_ids() {
        let profile = builtin::profile(id).unwrap();
        let own = if support::has_cross_terms(&profile) { "ey" } else { "ex" };
        let table = format!("axis,position_mm,{own}_um\nx,0,1.812\nx,50,6.457\nx,100,4.722\n");
        let errors = support::error_table(&table);
        for reference in 1..100 {
            let text = job(id, "", f64::from(reference), 10.0);
            let job = support::read_job(&text);
            let model = ErrorModel::build(&job, &errors).unwrap();
            let task = Task { job: &job, profile: &profile, model: &model };
            let tables = plan(task).unwrap_or_else(|p| panic!("{}\n{text}", p.render())).tables;
            for planned in &tables {
                let um = planned.values[planned.grid.nodes().reference_node].um();
                assert!(um == 0.0, "{id}, reference {reference} mm: {um:e} µm");
            }
            if reference % 30 == 7 {
                assert_eq!(support::generate(&text, &table).1.plan.tables, tables, "{id}");
            }
        }
    }
}

#[test]
fn errors_measured_moving_back_count_in_the_selection() {
    let table = "axis,direction,position_mm,ex_um,ey_um,ez_um\nx,-,0,0,0,0\nx,-,100,3,80,80\n\
                 y,-,0,0,0,0\ny,-,100,3,3,3\nz,-,0,0,0,0\nz,-,100,3,3,3\n";
    let (_, kit) = support::generate(&job("fanuc-0i-f", "", 0.0, 50.0), table);
    let omitted: Vec<String> = kit.plan.omitted.iter().map(|o| o.term.to_string()).collect();
    assert_eq!(omitted.len(), 3, "{omitted:?}");
    assert!(!omitted.contains(&"EYX".to_string()), "{omitted:?}");
    assert!(!omitted.contains(&"EZX".to_string()), "{omitted:?}");
}

/// A kit of a control with eight CEC tables, of which `more` may say that they are in use.
fn of_828d(more: &str) -> Kit {
    let axes =
        ["x", "y", "z"].map(|axis| (axis, (0..31).map(|row| f64::from(row) / 0.3).collect()));
    let errors = support::error_rows("ex_um,ey_um,ez_um", &axes, &["+", "-"], |axis, way, at| {
        let index = usize::from(axis == "y") + 2 * usize::from(axis == "z");
        let reversal = if way == "-" { 2.0 } else { 0.0 };
        [0, 1, 2].map(|of| {
            let size = 4.0 + ((index * 3 + of) * 5 % 9) as f64;
            let (x, of) = (at / 100.0, of as f64);
            size * (x * (1.5 + of)).sin() + reversal * (1.0 + 0.1 * of)
        })
    });
    let policy = format!("backlash = \"two-tables\"\n{more}");
    support::generate(&job("siemens-828d", &policy, 0.0, 10.0), &errors).1
}

#[test]
fn where_cec_tables_are_few_positioning_gets_the_mean_before_a_term_is_left_out() {
    let plan = of_828d("").plan;
    let has_table = |term: ErrorTerm| plan.tables.iter().any(|t| t.term == term);
    assert!(ErrorTerm::ALL.into_iter().all(has_table), "{:?}", plan.omitted);
    let is_cec = |t: &&PlannedTable| t.term.is_cross() || t.direction.is_some();
    assert_eq!(plan.tables.iter().filter(is_cec).count(), 8);
    let is_mean = |n: &&Finding| matches!(n.kind(), Some(TableFinding::MeanOnly { .. }));
    assert_eq!(plan.notes.iter().filter(is_mean).count(), 7, "{:?}", plan.notes);
    let kit = of_828d("first_table = 8");
    let terms: Vec<String> = kit.plan.tables.iter().map(|t| t.term.to_string()).collect();
    assert_eq!(terms, ["EXX", "EYY", "EZZ"]);
    assert!(kit.plan.tables.iter().all(|t| t.direction.is_none()));
    let said = "8 CEC tables, of which 8 are in use (`first_table`), for 18";
    for omission in &kit.plan.omitted {
        assert!(omission.reason.contains(said), "{}", omission.reason);
    }
    let mut backlash = kit.compiled.preconditions.iter().filter(|p| p.what.contains("BACKLASH"));
    assert!(backlash.all(|p| p.value == "as during the measurement"));
}

/// X and Y are the same in both directions, Z is not; only X and Z shall have two tables.
#[test]
fn equal_directions_and_policies_of_their_own_get_one_table() {
    let table = "axis,direction,position_mm,ex_um,ez_um\nx,+,0,0,0\nx,+,100,3,0\nx,-,0,0,0\nx,-,100,3.0000005,0\n\
                 z,+,0,0,0\nz,+,100,0,5\nz,-,0,0,-2\nz,-,100,0,4\n";
    let policies = "backlash = { x = \"two-tables\", y = \"mean\", z = \"two-tables\" }";
    for id in support::any_grid_ids() {
        let (_, kit) = support::generate(&job(id, policies, 0.0, 50.0), table);
        let directed = |term: &str| {
            let term = ErrorTerm::from_name(term).unwrap();
            let tables = kit.plan.tables.iter().filter(|t| t.term == term);
            tables.map(|t| t.direction.is_some()).collect::<Vec<bool>>()
        };
        assert_eq!(directed("EXX"), [false], "{id}");
        let profile = builtin::profile(id).unwrap();
        if !support::has_two_directions(&profile) {
            assert_eq!(directed("EZZ"), [false], "{id}");
            continue;
        }
        assert_eq!(directed("EZZ"), [true, true], "{id}");
        assert_eq!(kit.plan.backlash_um.x.map(f64::to_bits), Some(0.0_f64.to_bits()), "{id}");
        if support::replaces_backlash(&profile) {
            continue; // its tables stand in place of the parameter
        }
        let of_backlash = |p: &&Precondition| p.why.contains("no reversal is left");
        let stated = kit.compiled.preconditions.iter().find(of_backlash);
        let stated = stated.unwrap_or_else(|| panic!("{id}: {:#?}", kit.compiled.preconditions));
        assert!(stated.when == SeenTo::Entered && stated.value.starts_with('0'), "{stated:?}");
        if id.starts_with("siemens") {
            // The pair of an earlier kit would add to ENC_COMP.
            let of_pair = |p: &&Precondition| p.what.contains("from an axis to itself, ");
            let pairs = kit.compiled.preconditions.iter().filter(of_pair);
            let pairs: Vec<&str> = pairs.map(|p| p.what.as_str()).collect();
            assert!(matches!(pairs[..], [x] if x.ends_with("AX1")), "{pairs:?}");
        }
        let words = "both directions are equal, so one table is written";
        let said = |note: &Finding| match note.kind() {
            Some(TableFinding::OfTarget { terms, note }) => {
                terms[0].to_string() == "EXX" && note == words
            }
            _ => false,
        };
        assert!(kit.plan.notes.iter().any(said), "{id}");
        let mean = policies.replace("z = \"two-tables\"", "z = \"mean\"");
        let (_, kit) = support::generate(&job(id, &mean, 0.0, 50.0), table);
        assert!(kit.plan.tables.iter().all(|t| t.direction.is_none()), "{id}");
    }
}
