//! Readings of the body diagonals: what is read from them, and what is refused in which words.
use nonius::inputs::job::{AxisMaterial, DiagonalMeasurement, Job, Material, MeasuredData};
use nonius::inputs::readings::Readings;
use nonius::quantity::axis::{Axis, Direction, PerAxis};
use nonius::quantity::diagonal::{Diagonal, Pass, PathKind, Run, Volume};
use nonius::quantity::units::Millimetres;
use nonius::text::document::Source;
use std::fs;
use std::path::{Path, PathBuf};

mod mistakes;

fn golden(case: &str) -> (DiagonalMeasurement, Readings) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/diagonals");
    let source = |file: &str| -> Source {
        let path: PathBuf = folder.join(case).join(file);
        Source::from_bytes(file, &fs::read(path).expect("it is there")).expect("it is text")
    };
    let job = Job::read(source("job.toml")).expect("it is a job");
    let MeasuredData::Diagonals(measurement) = job.measurement.data else {
        panic!("{case} has no readings");
    };
    let readings = Readings::read(source(&measurement.readings), &measurement);
    (measurement.clone(), readings.expect("the readings are complete"))
}

fn find(readings: &Readings, diagonal: Diagonal, number: u32, pass: Pass) -> &Run {
    let wanted = |run: &&Run| (run.diagonal, run.number, run.pass) == (diagonal, number, pass);
    readings.runs.iter().find(wanted).expect("the run is there")
}

#[test]
fn the_golden_readings_are_read_completely() {
    for (case, steps, runs) in [
        ("case_a_ideal", 30, 4),
        ("case_b_setup", 30, 4),
        ("case_c_angles", 30, 4),
        ("case_c2_mirror", 30, 4),
        ("case_d_bidirectional", 10, 24),
    ] {
        let (measurement, readings) = golden(case);
        assert_eq!(measurement.volume.steps, steps, "{case}");
        assert_eq!(readings.runs.len(), runs, "{case}");
        for run in &readings.runs {
            assert_eq!(run.deviations.len(), 3 * steps + 1, "{case} {}", run.diagonal);
            assert_eq!(run.temperatures_c, PerAxis::default());
            assert!(readings.offset_known(run));
        }
    }
}

#[test]
fn a_reading_stands_at_its_node() {
    let (_, readings) = golden("case_a_ideal");
    let run = find(&readings, Diagonal::Ppp, 1, Pass::Forward);
    assert_eq!(run.deviations[0].um(), 0.0);
    assert_eq!(run.deviations[2].um(), 1.591414825);
    let (_, readings) = golden("case_d_bidirectional");
    let run = find(&readings, Diagonal::Ppp, 1, Pass::Reverse);
    assert_eq!(run.deviations[0].um(), -6.4112);
    assert_eq!(run.deviations[7].um(), 2.5334);
}

#[test]
fn linear_measurements_of_the_job_are_read() {
    let (measurement, _) = golden("case_b_setup");
    let axes: Vec<Axis> = measurement.linear.iter().map(|l| l.axis).collect();
    assert_eq!(axes, Axis::ALL);
}

/// A box of 90 × 72 × 72 mm in two steps of each axis.
fn measurement(kind: PathKind) -> DiagonalMeasurement {
    let (mut measurement, _) = golden("case_a_ideal");
    measurement.kind = kind;
    measurement.volume = Volume {
        start: PerAxis::from_fn(|_| Millimetres::new(0.0)),
        size: PerAxis {
            x: Millimetres::new(90.0),
            y: Millimetres::new(72.0),
            z: Millimetres::new(72.0),
        },
        steps: 2,
        order: Axis::ALL,
    };
    measurement
}

const HEADER: &str = "diagonal,run,direction,node,moved,deviation_um";
/// Axis that moves to nodes 0 … 6 in the order XYZ.
const MOVED: [&str; 7] = ["", "x", "y", "z", "x", "y", "z"];

/// The rows of a walk: node, axis and ten times the node as deviation.
fn walk(name: &str, direction: &str, moved: [&str; 7]) -> Vec<String> {
    (0..7)
        .map(|node| format!("{name},1,{direction},{node},{},{}", moved[node], 10 * node))
        .collect()
}

/// All forward runs of single-axis steps.
fn step_rows() -> Vec<String> {
    ["PPP", "NPP", "PNP", "PPN"].iter().flat_map(|name| walk(name, "forward", MOVED)).collect()
}

fn file(header: &str, rows: &[String]) -> String {
    format!("{header}\n{}\n", rows.join("\n"))
}

fn read(text: &str, measurement: &DiagonalMeasurement) -> Result<Readings, String> {
    let source = Source::from_bytes("readings.csv", text.as_bytes()).expect("it is text");
    Readings::read(source, measurement).map_err(|problems| problems.render())
}

/// The header and rows with one more column, the same in every row.
fn with_column(name: &str, value: impl Fn(usize) -> String) -> String {
    let rows = step_rows();
    let wider = rows.iter().enumerate();
    let wider: Vec<String> = wider.map(|(at, row)| format!("{row},{}", value(at))).collect();
    file(&format!("{HEADER},{name}"), &wider)
}

/// The displacement of every node instead of its deviation, by a function of the nominal one, mm.
fn displacements(measurement: &DiagonalMeasurement, of: impl Fn(f64) -> f64) -> String {
    let mut rows = Vec::new();
    for diagonal in Diagonal::ALL {
        for (node, moved) in MOVED.iter().enumerate() {
            let nominal = measurement.volume.nominal_mm(diagonal, measurement.kind, node);
            rows.push(format!("{diagonal},{node},{moved},{:.6}", of(nominal)));
        }
    }
    file("diagonal,node,moved,displacement_mm", &rows)
}

#[test]
fn columns_in_any_order_with_semicolons_and_decimal_commas_are_the_same_readings() {
    let measurement = measurement(PathKind::Step);
    let plain = read(&file(HEADER, &step_rows()), &measurement).expect("it is complete");
    let mut text = "\u{feff}deviation_mm;moved;node;diagonal\r\n".to_string();
    for row in step_rows().iter().rev() {
        let cells: Vec<&str> = row.split(',').collect();
        let um: f64 = cells[5].parse().expect("a number");
        let mm = format!("{}", um / 1000.0).replace('.', ",");
        text += &format!("{mm};{};{};{}\r\n", cells[4].to_uppercase(), cells[3], cells[0]);
    }
    let other = read(&text, &measurement).expect("it is complete");
    for (a, b) in plain.runs.iter().zip(&other.runs) {
        assert_eq!(a.diagonal, b.diagonal);
        for (a, b) in a.deviations.iter().zip(&b.deviations) {
            assert!((a.um() - b.um()).abs() < 1e-9);
        }
    }
}

#[test]
fn the_nominal_displacement_is_subtracted_and_the_sign_of_the_laser_turned() {
    let mut measurement = measurement(PathKind::Step);
    for (sign, factor) in [(Direction::Plus, 1.0), (Direction::Minus, -1.0)] {
        measurement.laser_sign = sign;
        let text = displacements(&measurement, |mm| factor * mm * (1.0 + 50e-6));
        let readings = read(&text, &measurement).expect("it is complete");
        for run in &readings.runs {
            let end = run.deviations[6].um();
            let expected = measurement.volume.diagonal_mm() * 0.05;
            assert!((end - expected).abs() < 1e-3, "{end} µm, expected {expected} µm");
        }
    }
    measurement.laser_sign = Direction::Minus;
    let readings = read(&file(HEADER, &step_rows()), &measurement).expect("it is complete");
    assert_eq!(readings.runs[0].deviations[6].um(), -60.0);
}

#[test]
fn a_run_under_its_reverse_name_is_turned_to_the_forward_nodes_and_its_offset_stays_open() {
    let measurement = measurement(PathKind::Step);
    let backwards = ["", "z", "y", "x", "z", "y", "x"];
    let mut rows = step_rows();
    for name in ["NNN", "PNN", "NPN", "NNP"] {
        rows.extend(walk(name, "forward", backwards));
    }
    let readings = read(&file(HEADER, &rows), &measurement).expect("it is complete");
    let run = find(&readings, Diagonal::Npp, 1, Pass::Reverse);
    let um: Vec<f64> = run.deviations.iter().map(|d| d.um()).collect();
    assert_eq!(um, [-60.0, -50.0, -40.0, -30.0, -20.0, -10.0, 0.0]);
    assert!(!readings.offset_known(run));
    assert!(readings.offset_known(find(&readings, Diagonal::Npp, 1, Pass::Forward)));
}

#[test]
fn a_displacement_under_the_reverse_name_gives_the_deviation_of_its_own_travel() {
    let measurement = measurement(PathKind::Straight);
    let (volume, kind) = (&measurement.volume, measurement.kind);
    let mut rows = Vec::new();
    for diagonal in Diagonal::ALL {
        for node in 0..=2 {
            let mm = volume.nominal_mm(diagonal, kind, node) * (1.0 + 100e-6);
            rows.push(format!("{diagonal},{node},{mm}"));
            rows.push(format!("{},{node},{mm}", diagonal.reverse_name()));
        }
    }
    let text = file("diagonal,node,displacement_mm", &rows);
    let readings = read(&text, &measurement).expect("it is complete");
    let whole = volume.diagonal_mm() * 0.1;
    for run in &readings.runs {
        let change = run.deviations[2].um() - run.deviations[0].um();
        assert!((change - whole).abs() < 1e-6, "{} {}", run.diagonal, run.pass.word());
    }
}

#[test]
fn temperatures_go_with_their_nodes() {
    let mut measurement = measurement(PathKind::Step);
    let scale = AxisMaterial { alpha_per_k: 11.5e-6, temperature_c: None };
    measurement.material = Some(Material {
        material_corrected: false,
        air_corrected: true,
        axes: PerAxis { x: None, y: Some(scale), z: None },
    });
    let text = with_column("t_y_c", |row| format!("{}", 20.0 + 0.1 * (row % 7) as f64));
    let readings = read(&text, &measurement).expect("it is complete");
    let temperatures = &readings.runs[3].temperatures_c;
    let y = temperatures.y.as_ref().expect("the column is there");
    assert_eq!((y.len(), y[0], temperatures.x.is_none()), (7, 20.0, true));
}

/// A mistake: what is changed, the words of the problem, and the words of the next step.
type Mistake = (&'static str, String, &'static str, &'static str);

fn refused(name: &str, text: &str, measurement: &DiagonalMeasurement, problem: &str, help: &str) {
    let said = match read(text, measurement) {
        Err(said) => said,
        Ok(_) => panic!("{name} was accepted"),
    };
    assert!(said.contains(problem), "{name}:\n{said}");
    assert!(said.contains(help), "{name}:\n{said}");
    assert!(text.is_empty() || said.contains("--> readings.csv:"), "{name}:\n{said}");
}

fn changed(from: &str, to: &str) -> String {
    let text = file(HEADER, &step_rows());
    assert!(text.contains(from), "{from} is not in the file");
    text.replacen(from, to, 1)
}

fn without(rows: impl Fn(&str) -> bool) -> String {
    let kept: Vec<String> = step_rows().into_iter().filter(|row| !rows(row)).collect();
    file(HEADER, &kept)
}

fn with(more: Vec<String>) -> String {
    let mut rows = step_rows();
    rows.extend(more);
    file(HEADER, &rows)
}

#[test]
fn a_way_back_that_counts_along_the_forward_run_keeps_the_forward_name() {
    let straight = measurement(PathKind::Straight);
    let (volume, kind) = (&straight.volume, straight.kind);
    let mut rows = Vec::new();
    for diagonal in Diagonal::ALL {
        for node in 0..=2 {
            let mm = volume.nominal_mm(diagonal, kind, node);
            rows.push(format!("{diagonal},{node},{mm}"));
            rows.push(format!("{},{node},{}", diagonal.reverse_name(), -mm));
        }
    }
    let text = file("diagonal,node,displacement_mm", &rows);
    refused(
        "negative",
        &text,
        &straight,
        "NNN run 1 forward, node 1: the displacement is -67.949 mm, expected about 67.949 mm",
        "a run named NNN counts along its own travel",
    );
}

/// Displacements tell the order of the steps by millimetres.
#[test]
fn displacements_of_steps_in_another_order_are_refused_with_that_order() {
    let measurement = measurement(PathKind::Step);
    let mut walked = measurement.clone();
    walked.volume.order = [Axis::Y, Axis::X, Axis::Z];
    let mut rows = Vec::new();
    for diagonal in Diagonal::ALL {
        for (node, moved) in MOVED.iter().enumerate() {
            let mm = walked.volume.nominal_mm(diagonal, walked.kind, node);
            rows.push(format!("{diagonal},{node},{moved},{mm:.6}"));
        }
    }
    refused(
        "another order",
        &file("diagonal,node,moved,displacement_mm", &rows),
        &measurement,
        "PPP run 1 forward, node 1: the displacement is",
        "this is what steps that went Y, X, Z read: check `order` in the job",
    );
}

#[test]
fn temperatures_that_the_job_does_not_explain_are_refused() {
    let mut measurement = measurement(PathKind::Step);
    let scale = |temperature_c| Some(AxisMaterial { alpha_per_k: 11.5e-6, temperature_c });
    let material = |x| {
        Some(Material {
            material_corrected: false,
            air_corrected: false,
            axes: PerAxis { x, y: None, z: None },
        })
    };
    let text = with_column("t_x_c", |_| "21".into());
    measurement.material = material(None);
    refused(
        "no expansion",
        &text,
        &measurement,
        "does not give the expansion of axis X",
        "add `x = { alpha_per_k",
    );
    measurement.material = material(scale(Some(21.0)));
    refused(
        "two temperatures",
        &text,
        &measurement,
        "the temperature of axis X is given twice",
        "keep one",
    );
    measurement.material = material(scale(None));
    let plain = file(HEADER, &step_rows());
    refused(
        "no temperature",
        &plain,
        &measurement,
        "there is no temperature of axis X",
        "mean temperature",
    );
}

#[test]
fn all_problems_of_a_file_are_shown_at_once() {
    let text = without(|row| row.starts_with("PPN") || row.starts_with("PPP,1,forward,2"))
        .replacen("NPP,1,forward,4,x", "NPP,1,forward,4,z", 1);
    let said = read(&text, &measurement(PathKind::Step)).expect_err("three mistakes");
    assert_eq!(said.matches("problem: ").count(), 3, "{said}");
}

#[test]
fn a_damaged_file_is_read_or_refused_and_stops_nothing() {
    let mut rows = step_rows();
    rows.extend(walk("NNN", "forward", ["", "z", "y", "x", "z", "y", "x"]));
    let text = file(HEADER, &rows);
    for kind in [PathKind::Step, PathKind::Straight] {
        let measurement = measurement(kind);
        for at in 0..text.len() {
            for with in ["", "9", "99", ";", "\"", "-", "\n"] {
                let damaged = format!("{}{with}{}", &text[..at], &text[at + 1..]);
                if let Err(said) = read(&damaged, &measurement) {
                    assert!(said.starts_with("problem: "), "{said}");
                }
            }
        }
    }
}
