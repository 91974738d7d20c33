//! Readings of the body diagonals: what is read from them. What is refused: fixtures/cases/refuses/readings.txt.
use crate::support::{fixture, measured_by, readings};
use nonius::inputs::job::{AxisMaterial, DiagonalMeasurement, Material};
use nonius::inputs::readings::Readings;
use nonius::quantity::{Diagonal, Direction, Pass, PathKind, PerAxis, Run};

fn find(readings: &Readings, diagonal: Diagonal, pass: Pass) -> &Run {
    let wanted = |run: &&Run| (run.diagonal, run.number, run.pass) == (diagonal, 1, pass);
    readings.runs.iter().find(wanted).unwrap()
}

/// A box of 90 × 72 × 72 mm in two steps of each axis, X first; its readings are ten times the node.
fn measurement(kind: PathKind) -> DiagonalMeasurement {
    DiagonalMeasurement { kind, ..measured_by(&fixture("base/step-readings/job.toml")) }
}

fn steps() -> String {
    fixture("base/step-readings/readings.csv")
}

/// The same along the whole box, with the rows of these walks back, whose nodes count from the far corner.
fn with_walks_back(names: &[&str]) -> String {
    let moved = ["", "z", "y", "x", "z", "y", "x"].into_iter().enumerate();
    let row = |name: &str, (node, axis)| format!("{name},1,forward,{node},{axis},{}\n", 10 * node);
    let walk = |name: &&str| moved.clone().map(|step| row(name, step)).collect::<String>();
    steps() + &names.iter().map(walk).collect::<String>()
}

/// A file with a row of every node of every diagonal.
fn of_nodes(header: &str, last: usize, row: impl Fn(Diagonal, usize) -> String) -> String {
    let nodes = |d: Diagonal| (0..=last).map(move |node| (d, node));
    let rows = Diagonal::ALL.into_iter().flat_map(nodes).map(|(d, node)| row(d, node) + "\n");
    format!("{header}\n{}", rows.collect::<String>())
}

fn complete(text: &str, measurement: &DiagonalMeasurement) -> Readings {
    readings(text, measurement).unwrap_or_else(|said| panic!("{said}"))
}

#[test]
fn columns_in_any_order_with_semicolons_and_a_laser_that_was_not_zeroed_are_the_same_readings() {
    let measurement = measurement(PathKind::Step);
    let plain = complete(&steps(), &measurement);
    let mut text = "\u{feff}deviation_mm;moved;node;diagonal;;\r\n".to_string();
    for row in steps().lines().skip(1).collect::<Vec<_>>().into_iter().rev() {
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
        let mut um = a.deviations.iter().zip(&b.deviations);
        assert!(um.all(|(a, b)| (a.um() - b.um()).abs() < 1e-9), "{}", a.diagonal);
    }
}

#[test]
fn the_nominal_displacement_is_subtracted_and_the_sign_of_the_laser_turned() {
    let mut measurement = measurement(PathKind::Step);
    for (sign, factor) in [(Direction::Plus, 1.0), (Direction::Minus, -1.0)] {
        measurement.laser_sign = sign;
        let text = of_nodes("diagonal,node,moved,displacement_mm", 6, |diagonal, node| {
            let nominal = measurement.volume.nominal_mm(diagonal, PathKind::Step, node);
            let moved = ["", "x", "y", "z", "x", "y", "z"][node];
            format!("{diagonal},{node},{moved},{:.6}", factor * nominal * (1.0 + 50e-6))
        });
        for run in complete(&text, &measurement).runs {
            let end = run.deviations[6].um();
            let expected = measurement.volume.diagonal_mm() * 0.05;
            assert!((end - expected).abs() < 1e-3, "{end} µm, expected {expected} µm");
        }
    }
    assert_eq!(complete(&steps(), &measurement).runs[0].deviations[6].um(), -60.0);
}

#[test]
fn a_run_under_its_reverse_name_is_turned_to_the_forward_nodes_and_its_offset_stays_open() {
    let text = with_walks_back(&["NNN", "PNN", "NPN", "NNP"]);
    let readings = complete(&text, &measurement(PathKind::Step));
    let run = find(&readings, Diagonal::Npp, Pass::Reverse);
    let um: Vec<f64> = run.deviations.iter().map(|d| d.um()).collect();
    assert_eq!(um, [-60.0, -50.0, -40.0, -30.0, -20.0, -10.0, 0.0]);
    assert!(!readings.offset_known(run));
    assert!(readings.offset_known(find(&readings, Diagonal::Npp, Pass::Forward)));
    // A displacement gives the deviation of its own travel.
    let measurement = measurement(PathKind::Straight);
    let text = of_nodes("diagonal,node,displacement_mm", 2, |diagonal, node| {
        let mm = measurement.volume.nominal_mm(diagonal, PathKind::Straight, node) * (1.0 + 100e-6);
        format!("{diagonal},{node},{mm}\n{},{node},{mm}", diagonal.reverse_name())
    });
    let whole = measurement.volume.diagonal_mm() * 0.1;
    for run in &complete(&text, &measurement).runs {
        let change = run.deviations[2].um() - run.deviations[0].um();
        assert!((change - whole).abs() < 1e-6, "{} {}", run.diagonal, run.pass.word());
    }
}

#[test]
fn temperatures_go_with_their_nodes() {
    let mut measurement = measurement(PathKind::Step);
    let y = Some(AxisMaterial { alpha_per_k: 11.5e-6, temperature_c: None });
    let axes = PerAxis { y, ..PerAxis::default() };
    measurement.material = Some(Material { material_corrected: false, air_corrected: true, axes });
    let rows = steps().lines().skip(1).enumerate().fold(String::new(), |rows, (at, row)| {
        format!("{rows}{row},{}\n", 20.0 + 0.1 * (at % 7) as f64)
    });
    let text = format!("diagonal,run,direction,node,moved,deviation_um,t_y_c\n{rows}");
    let temperatures = &complete(&text, &measurement).runs[3].temperatures_c;
    let y = temperatures.y.as_ref().unwrap();
    assert_eq!((y.len(), y[0], temperatures.x.is_none()), (7, 20.0, true));
}

#[test]
fn a_damaged_file_is_read_or_refused_and_stops_nothing() {
    let text = with_walks_back(&["NNN"]);
    for measurement in [PathKind::Step, PathKind::Straight].map(measurement) {
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
