//! Readings of the body diagonals: what is read from them, and what is refused in which words.
use crate::support::{DIAGONALS, golden_readings, readings};
use nonius::inputs::job::{AxisMaterial, DiagonalMeasurement, Material};
use nonius::inputs::readings::Readings;
use nonius::quantity::{
    Axis, Diagonal, Direction, Millimetres, Pass, PathKind, PerAxis, Run, Volume,
};

mod mistakes;

fn find(readings: &Readings, diagonal: Diagonal, pass: Pass) -> &Run {
    let wanted = |run: &&Run| (run.diagonal, run.number, run.pass) == (diagonal, 1, pass);
    readings.runs.iter().find(wanted).unwrap()
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
        let (measurement, readings) = golden_readings(case);
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
    let (_, readings) = golden_readings("case_a_ideal");
    let run = find(&readings, Diagonal::Ppp, Pass::Forward);
    assert_eq!([0, 2].map(|node| run.deviations[node].um()), [0.0, 1.591414825]);
    let (_, readings) = golden_readings("case_d_bidirectional");
    let run = find(&readings, Diagonal::Ppp, Pass::Reverse);
    assert_eq!([0, 7].map(|node| run.deviations[node].um()), [-6.4112, 2.5334]);
}

/// A box of 90 × 72 × 72 mm in two steps of each axis.
fn measurement(kind: PathKind) -> DiagonalMeasurement {
    let [x, y, z] = [90.0, 72.0, 72.0].map(Millimetres::new);
    let start = PerAxis::from_fn(|_| Millimetres::new(0.0));
    let volume = Volume { start, size: PerAxis { x, y, z }, steps: 2, order: Axis::ALL };
    DiagonalMeasurement { kind, volume, ..golden_readings("case_a_ideal").0 }
}

const HEADER: &str = "diagonal,run,direction,node,moved,deviation_um";
/// Axis that moves to nodes 0 … 6 in the order XYZ.
const MOVED: [&str; 7] = ["", "x", "y", "z", "x", "y", "z"];

/// The same on the way back of a run under its reverse name.
const BACKWARDS: [&str; 7] = ["", "z", "y", "x", "z", "y", "x"];

/// The rows of a walk: node, axis and ten times the node as deviation.
fn walk(name: &str, direction: &str, moved: [&str; 7]) -> Vec<String> {
    let row = |node: usize| format!("{name},1,{direction},{node},{},{}", moved[node], 10 * node);
    (0..7).map(row).collect()
}

/// The walks of all diagonals.
fn walks(direction: &str, moved: [&str; 7]) -> Vec<String> {
    DIAGONALS.iter().flat_map(|name| walk(name, direction, moved)).collect()
}

/// All forward runs of single-axis steps.
fn step_rows() -> Vec<String> {
    walks("forward", MOVED)
}

fn file(header: &str, rows: &[String]) -> String {
    format!("{header}\n{}\n", rows.join("\n"))
}

/// The header and all forward runs of single-axis steps.
fn steps() -> String {
    file(HEADER, &step_rows())
}

/// A file with the rows of every node of every diagonal.
fn of_nodes(header: &str, last: usize, rows: impl Fn(Diagonal, usize) -> String) -> String {
    let nodes = |d: Diagonal| (0..=last).map(move |node| (d, node));
    let all = Diagonal::ALL.into_iter().flat_map(nodes);
    file(header, &all.map(|(d, node)| rows(d, node)).collect::<Vec<_>>())
}

fn complete(text: &str, measurement: &DiagonalMeasurement) -> Readings {
    readings(text, measurement).unwrap_or_else(|said| panic!("{said}"))
}

/// The header and rows with one more column.
fn with_column(name: &str, value: impl Fn(usize) -> String) -> String {
    let rows = step_rows();
    let wider = rows.iter().enumerate().map(|(at, row)| format!("{row},{}", value(at)));
    file(&format!("{HEADER},{name}"), &wider.collect::<Vec<_>>())
}

/// The displacement of every node instead of its deviation, by a function of the nominal one, mm.
fn displacements(measurement: &DiagonalMeasurement, of: impl Fn(f64) -> f64) -> String {
    of_nodes("diagonal,node,moved,displacement_mm", 6, |diagonal, node| {
        let nominal = measurement.volume.nominal_mm(diagonal, measurement.kind, node);
        format!("{diagonal},{node},{},{:.6}", MOVED[node], of(nominal))
    })
}

/// Straight runs with their ways back under the reverse names: the factors of the nominal displacement.
fn there_and_back(measurement: &DiagonalMeasurement, there: f64, back: f64) -> String {
    of_nodes("diagonal,node,displacement_mm", 2, |diagonal, node| {
        let mm = measurement.volume.nominal_mm(diagonal, measurement.kind, node);
        let reverse = diagonal.reverse_name();
        format!("{diagonal},{node},{}\n{reverse},{node},{}", mm * there, mm * back)
    })
}

#[test]
fn columns_in_any_order_with_semicolons_and_a_laser_that_was_not_zeroed_are_the_same_readings() {
    let measurement = measurement(PathKind::Step);
    let plain = complete(&steps(), &measurement);
    let mut text = "\u{feff}deviation_mm;moved;node;diagonal;;\r\n".to_string();
    for row in step_rows().iter().rev() {
        let cells: Vec<&str> = row.split(',').collect();
        let zero_um = if cells[0] == "PPP" { 12.5 } else { 0.0 };
        let um = cells[5].parse::<f64>().unwrap() + zero_um;
        let mm = format!("{}", um / 1000.0).replace('.', ",");
        text += &format!("{mm};{};{};{};;\r\n", cells[4].to_uppercase(), cells[3], cells[0]);
    }
    let other = complete(&text, &measurement);
    assert!(other.notes()[0].to_string().ends_with("readings of PPP 12.500 µm"));
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
        for run in complete(&text, &measurement).runs {
            let end = run.deviations[6].um();
            let expected = measurement.volume.diagonal_mm() * 0.05;
            assert!((end - expected).abs() < 1e-3, "{end} µm, expected {expected} µm");
        }
    }
    measurement.laser_sign = Direction::Minus;
    assert_eq!(complete(&steps(), &measurement).runs[0].deviations[6].um(), -60.0);
}

#[test]
fn a_run_under_its_reverse_name_is_turned_to_the_forward_nodes_and_its_offset_stays_open() {
    let measurement = measurement(PathKind::Step);
    let names = ["NNN", "PNN", "NPN", "NNP"];
    let more = names.map(|name| walk(name, "forward", BACKWARDS)).concat();
    let readings = complete(&with(more), &measurement);
    let run = find(&readings, Diagonal::Npp, Pass::Reverse);
    let um: Vec<f64> = run.deviations.iter().map(|d| d.um()).collect();
    assert_eq!(um, [-60.0, -50.0, -40.0, -30.0, -20.0, -10.0, 0.0]);
    assert!(!readings.offset_known(run));
    assert!(readings.offset_known(find(&readings, Diagonal::Npp, Pass::Forward)));
}

#[test]
fn a_displacement_under_the_reverse_name_gives_the_deviation_of_its_own_travel() {
    let measurement = measurement(PathKind::Straight);
    let text = there_and_back(&measurement, 1.0 + 100e-6, 1.0 + 100e-6);
    let readings = complete(&text, &measurement);
    let whole = measurement.volume.diagonal_mm() * 0.1;
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
    let temperatures = &complete(&text, &measurement).runs[3].temperatures_c;
    let y = temperatures.y.as_ref().unwrap();
    assert_eq!((y.len(), y[0], temperatures.x.is_none()), (7, 20.0, true));
}

/// Refused with the words of the problem, the place, and the words of the next step.
#[track_caller]
fn refused(text: &str, measurement: &DiagonalMeasurement, problem: &str, help: &str) {
    let said = readings(text, measurement).err().unwrap_or_else(|| panic!("accepted: {problem}"));
    let place = if text.is_empty() { "" } else { "--> readings.csv:" };
    for words in [problem, help, place] {
        assert!(said.contains(words), "expected `{words}` in\n{said}\nfor `{problem}`");
    }
}

fn changed(from: &str, to: &str) -> String {
    let text = steps();
    assert!(text.contains(from), "{from} is not in the file");
    text.replacen(from, to, 1)
}

fn without(rows: impl Fn(&str) -> bool) -> String {
    let kept: Vec<String> = step_rows().into_iter().filter(|row| !rows(row)).collect();
    file(HEADER, &kept)
}

fn with(more: Vec<String>) -> String {
    file(HEADER, &[step_rows(), more].concat())
}

#[test]
fn a_way_back_that_counts_along_the_forward_run_keeps_the_forward_name() {
    let straight = measurement(PathKind::Straight);
    let text = there_and_back(&straight, 1.0, -1.0);
    let says =
        "NNN run 1 forward, node 1: the displacement is -67.949 mm, expected about 67.949 mm";
    refused(&text, &straight, says, "a run named NNN counts along its own travel");
}

/// Displacements tell the order of the steps by millimetres.
#[test]
fn displacements_of_steps_in_another_order_are_refused_with_that_order() {
    let measurement = measurement(PathKind::Step);
    let mut walked = measurement.clone();
    walked.volume.order = [Axis::Y, Axis::X, Axis::Z];
    let text = displacements(&walked, |mm| mm);
    let says = "PPP run 1 forward, node 1: the displacement is";
    let help = "this is what steps that went Y, X, Z read: check `order` in the job";
    refused(&text, &measurement, says, help);
}

#[test]
fn temperatures_that_the_job_does_not_explain_are_refused() {
    let mut measurement = measurement(PathKind::Step);
    let text = with_column("t_x_c", |_| "21".into());
    let scale = |temperature_c| Some(AxisMaterial { alpha_per_k: 11.5e-6, temperature_c });
    let unknown = "does not give the expansion of axis X";
    let twice = "the temperature of axis X is given twice";
    let missing = "there is no temperature of axis X";
    for (x, text, problem, help) in [
        (None, &text, unknown, "add `x = { alpha_per_k"),
        (scale(Some(21.0)), &text, twice, "keep one"),
        (scale(None), &steps(), missing, "mean temperature"),
    ] {
        let axes = PerAxis { x, y: None, z: None };
        measurement.material =
            Some(Material { material_corrected: false, air_corrected: false, axes });
        refused(text, &measurement, problem, help);
    }
}

#[test]
fn all_problems_of_a_file_are_shown_at_once() {
    let text = without(|row| row.starts_with("PPN") || row.starts_with("PPP,1,forward,2"))
        .replacen("NPP,1,forward,4,x", "NPP,1,forward,4,z", 1);
    let said = readings(&text, &measurement(PathKind::Step)).unwrap_err();
    assert_eq!(said.matches("problem: ").count(), 3, "{said}");
}

#[test]
fn a_damaged_file_is_read_or_refused_and_stops_nothing() {
    let text = with(walk("NNN", "forward", BACKWARDS));
    for kind in [PathKind::Step, PathKind::Straight] {
        let measurement = measurement(kind);
        for at in 0..text.len() {
            for with in ["", "9", "99", ";", "\"", "-", "\n"] {
                let damaged = format!("{}{with}{}", &text[..at], &text[at + 1..]);
                if let Err(said) = readings(&damaged, &measurement) {
                    assert!(said.starts_with("problem: "), "{said}");
                }
            }
        }
    }
}
