//! A visit from an empty folder: `nonius new`, its empty cells filled in, and every command that it names.
use crate::support::*;
use nonius::control::controller::{Dialect, builtin};
use nonius::inputs::error_table::Kind;
use nonius::quantity::Axis;
use std::mem::discriminant;

const AXES: [&str; 3] = ["x", "y", "z"];
const TRAVEL: [[f64; 2]; 3] = [[0.0, 800.0], [0.0, 500.0], [-400.0, 0.0]];

/// Fills in the `""` of a job but those of `later`, and changes nothing else.
fn fill_in(at: &Visit, job: &str, slopes: [f64; 3], later: &[&str]) {
    let page = at.read(job);
    let named = |id: &&str| page.contains(&format!("controller = \"{id}\""));
    let own = builtin::ids().into_iter().find(named).map(|id| builtin::profile(id).unwrap());
    let id = |axis: usize| match own.as_ref().map(|own| (&own.dialect, &own.axis_names)) {
        Some((Dialect::Declared(_), names)) => format!("\"{}\"", names.value[axis]),
        Some((Dialect::Siemens(_), _)) => format!("\"AX{}\"", axis + 1),
        _ => format!("\"{}\"", axis + 1),
    };
    let mut axis = 0;
    let filled = page.lines().map(|line| {
        let begins = |name: &&str| {
            line.starts_with('[') && line.contains(&format!(".{name}]"))
                || line.starts_with(&format!("axis = \"{name}\""))
        };
        axis = AXES.iter().position(begins).unwrap_or(axis);
        let key = line.split(" = ").next().unwrap();
        let is_key = line.starts_with(|c: char| c.is_ascii_lowercase());
        if !is_key || !line.contains("= \"\"") || later.contains(&key) {
            return line.to_string();
        }
        let (slope, id) = (slopes[axis].to_string(), id(axis));
        let value = match key {
            "name" => "\"VMC 800\"",
            "date" => "\"2026-11-20\"",
            "active_while_measuring" => "\"none\"",
            "reference_mm" => "0.0",
            "reference_direction" => "\"+\"",
            "active_backlash_um" => "{ x = 0.0, y = 0.0, z = 0.0 }",
            "slope_um_per_m" => &slope,
            "u_um_per_m" | "setup_ppm" => "0.5",
            "angle_urad" => "0",
            "noise_um" => "0.3",
            "control_unit" => "\"mm\"",
            "first_table" => "0",
            "first_set" | "measuring_system" => "1",
            "reserved_points" => "[]",
            "id" => &id,
            "detection_unit_um" => "1.0",
            "interpolated" => "false",
            "backlash" => "\"mean\"",
            "max_deviation_um" => "10.0",
            other => panic!("nobody said what `{other}` is"),
        };
        line.replacen("\"\"", value, 1)
    });
    at.put(job, filled.collect::<Vec<_>>().join("\n"));
}

/// Positioning of X, Y and Z, µm/m.
const SLOPES: [f64; 3] = [20.0, -15.0, 25.0];

/// The invented machine as an error table, with rows at the ends of a box of diagonals too.
fn machine(at: &Visit, steps: u32, both: bool, box_ends: &[[f64; 2]; 3]) {
    let places = |axis: usize| {
        let [low, high] = TRAVEL[axis];
        let node = |node: u32| low + (high - low) * f64::from(node) / f64::from(steps);
        let mut places: Vec<f64> = (0..=steps).map(node).chain(box_ends[axis]).collect();
        places.sort_by(f64::total_cmp);
        places.dedup();
        (AXES[axis], places)
    };
    let ways: &[&str] = if both { &["+", "-"] } else { &[""] };
    // A scale that is off, and a bow on both other axes.
    let deviations = |axis: &str, way: &str, mm: f64| {
        let axis = AXES.iter().position(|own| *own == axis).unwrap();
        let mut deviations = [1.0, -0.5, 0.3].map(|bow| 4e-5 * bow * mm * mm);
        deviations[axis] = SLOPES[axis] * mm / 1000.0 - if way == "-" { 3.0 } else { 0.0 };
        deviations
    };
    let axes = [0, 1, 2].map(places);
    at.put("machine.csv", error_rows("ex_um,ey_um,ez_um", &axes, ways, deviations));
}

fn begun(at: &Visit, id: &str, more: &str) {
    let travel = "--travel 800,500,-400:0";
    let ran = at.run(&format!("new --controller {id} {travel} {more} -o visit")).ends(0);
    assert!(ran.out.contains("Z -400 … 0 mm"), "{}", ran.out);
    assert!(ran.err.replace('\\', "/").contains("/job.toml"), "{}", ran.err);
}

fn box_ends(at: &Visit) -> [[f64; 2]; 3] {
    let job = at.read("visit/job.toml");
    let of = |key: &str, axis: &str| -> f64 {
        let line = job.lines().find(|line| line.starts_with(key)).unwrap();
        let (_, value) = line.split_once(&format!("{axis} = ")).unwrap();
        value.split([',', ' ']).next().unwrap().parse().unwrap()
    };
    AXES.map(|axis| [of("start_mm", axis), of("start_mm", axis) + of("size_mm", axis)])
}

/// Slopes of the positioning in an error table between the ends of a box, µm/m, mean of the directions.
fn slopes(page: &str, ends: &[[f64; 2]; 3]) -> [f64; 3] {
    let table = error_table(page);
    Axis::ALL.map(|axis| {
        let at = |end: f64| {
            let values = table.series(axis).iter().map(|own| {
                let place = own.positions.iter().position(|at| (at.mm() - end).abs() < 1e-6);
                own.values[&Kind::Deviation(axis)][place.unwrap()]
            });
            values.sum::<f64>() / table.series(axis).len() as f64
        };
        let [low, high] = ends[axis as usize];
        1000.0 * (at(high) - at(low)) / (high - low)
    })
}

/// How far a visit is followed: until the kit is verified, until it is measured again, to its report.
#[derive(Clone, Copy, PartialEq)]
enum Until {
    Kit,
    After,
    Report,
}

/// A visit of one control from `new` on, its tables filled in by `simulate`.
fn walk(id: &str, more: &str, until: Until) {
    println!("{id} {more}");
    let at = &Visit::new();
    let are_readings = more.contains("--readings");
    let both = more.contains("--both-directions");
    begun(at, id, more);
    let ends = if are_readings { box_ends(at) } else { TRAVEL };
    let steps = more.split_once("--steps ").map_or(16, |(_, steps)| steps.parse().unwrap());
    machine(at, steps, both, &ends);
    let (table, after, form) = match are_readings {
        true if both => ("readings.csv", "after.toml", "--both-directions"),
        true => ("readings.csv", "after.toml", ""),
        false => ("errors.csv", "after.csv", "--errors"),
    };
    let simulate = |tables: &str, output: &str| {
        let machine = "--machine machine.csv";
        at.yes(&format!("simulate visit/job.toml {machine} {tables} -o {output} --force"));
    };
    let refused = at.run("generate visit/job.toml -o visit/kit").ends(2);
    let refused = refused.says("keys are empty, expected a value of each");
    match are_readings {
        true => before(at, id),
        false => drop(refused.says("the table holds no deviation")),
    }
    fill_in(at, "visit/job.toml", SLOPES, &[]);
    simulate(&format!("--without-tables {form}"), &format!("visit/{table}"));
    if are_readings {
        at.yes("separate visit/job.toml --trials 0");
    }
    let kit = at.run("generate visit/job.toml -o visit/kit").answers();
    // Nothing is assumed that the job could have stated.
    let profile = builtin::profile(id).unwrap();
    for assumed in at.document("visit/kit/manifest.json")["assumptions"].as_array().unwrap() {
        let fact = assumed["fact"].as_str().unwrap();
        let is_of_profile = profile.statements.iter().any(|stated| stated.fact == fact);
        assert!(is_of_profile || fact.starts_with("pitch_compensation_of_axis"), "{id}: {fact}");
    }
    let takes_all = ["generic", "siemens-840d-sl"].contains(&id);
    assert!(kit.status == Some(0) || !takes_all || are_readings, "{id} {more}");
    at.run("verify visit/job.toml --tables visit/kit").answers();
    let refused = at.run("verify visit/job.toml --tables visit").ends(2).says("it is no kit");
    assert_eq!(refused.all().matches("problem:").count(), 1, "{id}: {}", refused.all());
    if until == Until::Kit {
        return;
    }
    simulate(&format!("--tables visit/kit {form}"), "visit/after.csv");
    if are_readings {
        simulate("--tables visit/kit --errors", "linear.csv");
        fill_in(at, "visit/after.toml", slopes(&at.read("linear.csv"), &ends), &[]);
    }
    let tables = format!("visit/job.toml --tables visit/kit --after visit/{after}");
    at.run(&format!("verify {tables}")).answers().says("REHEARSAL").omits("NOT AS FORECAST");
    if until == Until::After {
        return;
    }
    at.run(&format!("report {tables} -o visit/report.html")).answers();
    let page = at.read("visit/report.html");
    assert!(page.contains("VMC 800") && page.contains("SIMULATED"), "{id} {more}");
    if !are_readings || short_or(false, true) {
        at.run("report visit/job.toml --tables visit/kit -o first.html").answers();
        assert!(at.read("first.html").contains("VMC 800"), "{id} {more}");
    }
}

/// What comes before the readings asks for nothing that is known only after them.
fn before(at: &Visit, id: &str) {
    let later =
        ["date", "active_while_measuring", "active_backlash_um", "slope_um_per_m", "u_um_per_m"];
    fill_in(at, "visit/job.toml", SLOPES, &later);
    at.run("plan visit/job.toml").answers();
    if builtin::profile(id).unwrap().program.is_some() {
        let ran = at.run("program visit/job.toml -o visit/programs").ends(0);
        ran.says("readings.csv, which the job names").omits("an end of the travel");
        assert!(!at.has("visit/programs/readings.csv"));
    }
    at.run("separate visit/job.toml").ends(2).omits("detection_unit_um").tells(&[
        "keys are empty, expected a value of each",
        "slope_um_per_m",
        "active_while_measuring",
        "`displacement_mm` is empty, expected a number",
    ]);
}

/// Every control: the first of its family until the first of these ends, others the second; all to reports if simulated.
fn walk_all(more: &str, [first, other]: [Option<Until>; 2]) {
    let mut families = Vec::new();
    for id in positioning_ids() {
        let family = discriminant(&builtin::profile(id).unwrap().dialect);
        let until = if families.contains(&family) { other } else { first };
        families.push(family);
        if let Some(until) = short_or(until, Some(Until::Report)) {
            walk(id, more, until);
        }
    }
}

#[test]
fn every_control_gets_from_an_empty_folder_to_a_report() {
    walk_all("", [Some(Until::After); 2]);
    walk_all("--both-directions --steps 8", [Some(Until::Report), None]);
}

/// Few steps: a second measurement of many takes seconds.
#[test]
fn every_control_gets_from_an_empty_folder_to_a_report_by_readings() {
    walk_all("--readings --steps 4", [Some(Until::Kit), None]);
    walk_all("--readings --both-directions --steps 2", [Some(Until::Report), None]);
}

#[test]
fn the_slopes_of_the_first_job_copied_to_the_second_are_blamed_on_nobody_else() {
    let at = &Visit::new();
    begun(at, "generic", "--readings");
    machine(at, 16, false, &box_ends(at));
    fill_in(at, "visit/job.toml", SLOPES, &[]);
    fill_in(at, "visit/after.toml", SLOPES, &[]);
    let simulate = "simulate visit/job.toml --machine machine.csv --force";
    at.yes(&format!("{simulate} --without-tables -o visit/readings.csv"));
    at.run("generate visit/job.toml -o visit/kit").answers();
    at.yes(&format!("{simulate} --tables visit/kit -o visit/after.csv"));
    let verified = at.run("verify visit/job.toml --tables visit/kit --after visit/after.toml");
    let blamed = "`slope_um_per_m` of XYZ afterwards is that of the first job";
    let verified = verified.ends(1).says(blamed).says("verdict: undecided").omits("TEMPERATURE");
    assert!(verified.out.starts_with("REHEARSAL"), "{}", verified.out);
}

#[test]
fn what_is_there_stays_unless_it_is_forced() {
    let at = &Visit::new();
    begun(at, "generic", "");
    at.run("new --controller generic --travel 1,2,3 -o visit").ends(2).says("visit");
    let forced = "new --controller generic --travel 1,2,-3:0in -o visit --force --format json";
    assert_eq!(at.run(forced).ends(0).json()["steps"], 10);
    assert!(at.read("visit/job.toml").contains("[-76.2, 0]") && at.has("visit.previous/job.toml"));
}

#[test]
fn a_profile_of_ones_own_is_named_from_inside_the_visit() {
    let at = &Visit::new();
    at.put("shop.toml", own_profile("fanuc-30i", ""));
    begun(at, "shop.toml", "");
    fill_in(at, "visit/job.toml", SLOPES, &[]);
    machine(at, 16, false, &TRAVEL);
    at.yes("simulate visit/job.toml --machine machine.csv --without-tables --errors -o visit/errors.csv --force");
    at.run("generate visit/job.toml -o visit/kit").answers();
}

/// The errors, or the readings, of a visit once more while its kit is active; the place of its tables is one key.
#[test]
fn a_second_visit_begins_where_the_first_one_ended() {
    for (start, table, form) in
        [("start/errors", "errors.csv", "--errors"), ("start/readings", "readings.csv", "")]
    {
        let at = &Visit::of(start).with_any_kit();
        at.run("new --from job.toml -o next").ends(0).says("`first_table` decides");
        let simulate = "simulate job.toml --tables kit --noise-um 0.1 --force";
        at.yes(&format!("{simulate} {form} -o next/{table}"));
        fill_in(at, "next/job.toml", [0.1, -0.1, 0.1], &[]);
        let page = at.read("next/job.toml");
        assert!(page.contains("\nactive_while_measuring = \"../kit\"\n") && !page.contains("none"));
        at.run("generate next/job.toml -o next/kit").answers().omits("assumed: first_table");
        let disable = |kit: &str| at.read(&format!("{kit}/NONIUS_DISABLE.MPF"));
        let off = |kit: &str| disable(kit).matches("TABLE_ENABLE[").count();
        at.edit("next/job.toml", "first_table = 0 ", "first_table = 6 ");
        at.run("generate next/job.toml -o next/beside").answers();
        assert_eq!([off("kit"), off("next/kit"), off("next/beside")], [6, 6, 12]);
        at.run("verify next/job.toml --tables next/beside").answers().says("job and tables agree");
    }
}

#[test]
fn a_read_out_fills_the_keys_that_it_knows() {
    let at = Visit::with_job("nine_errors_900/fanuc-30i.toml");
    at.put("PARA.TXT", "%\nN01240Q1A1P500.0A2P0.0\nN01320Q1A1P905.0\nN01321Q1A1P-5.0\n%\n");
    at.edit("job.toml", "[measurement]\n", "[measurement]\ninstrument = \"0815\"\n");
    let begun = at.run("new --from job.toml --read-out PARA.TXT -o next").ends(0);
    let begun = begun.says("`machine.axes.x.reference_mm = 500.0`; 1240 of axis 1 is 500 mm");
    begun.omits("axes.y").says("replace those of PARA.TXT or lie beside them");
    let page = at.read("next/job.toml");
    let active = "\nactive_while_measuring = \"../PARA.TXT\"\n";
    let travel = "travel_mm = [-5.0, 905.0]\nreference_mm = 500.0\n";
    holds(&page, &[travel, active, "\ninstrument = \"\"\n"]); // the laser of that day
    // In the unit of the control that was read out; what no key of the job holds is said.
    let inch = "%_N_INITIAL_INI\nCHANDATA(1)\nN10240 $MN_SCALING_SYSTEM_IS_METRIC=0\n\
        N34100 $MA_REFP_SET_POS[0,AX1]=10\nN32700 $MA_ENC_COMP_ENABLE[0,AX1]=1\nM17\n";
    let at = Visit::with_job("nine_errors_900/siemens-840d-sl.toml");
    let begun = at.put("INITIAL.INI", inch).run("new --from job.toml --read-out INITIAL.INI -o 2");
    begun.ends(0).says("from the read-out: MD32700");
    let page = at.read("2/job.toml");
    assert!(page.contains("control_unit = \"inch\"\n") && page.contains("= 254.0\n"), "{page}");
}

#[test]
fn a_box_in_inches_stands_on_digits_of_the_control() {
    let visit = Visit::new();
    visit.run("new --controller linuxcnc --travel 32in,20in,-16.5:0in --readings -o v").ends(0);
    let page = visit.read("v/job.toml");
    // 17 steps; a digit is 0.0001 in.
    for (key, parts) in [("start_mm = {", 1.0), ("size_mm = {", 17.0)] {
        let line = page.lines().find_map(|line| line.strip_prefix(key)).unwrap();
        let numbers = line.split(['=', ',', ' ', '}']).filter_map(|word| word.parse::<f64>().ok());
        for mm in numbers.take(3) {
            let digits = mm / parts / 0.00254;
            assert!((digits - digits.round()).abs() < 1e-3, "{key} {mm}\n{page}");
        }
    }
}
