//! LinuxCNC with a HAL file: what the reader makes of such a file (what it refuses: fixtures/cases/refuses/hal.txt), and
//! tables longer than a curve.
use crate::support::{self, fixture, shown, um_at};
use nonius::control::controller::{KitFile, Role, builtin};
use nonius::control::table::{ListedTable, Point, Tables};
use nonius::kit;
use nonius::quantity::Direction;
use nonius::read::read;

/// Two curves of X, one of 3 and one of 2 points, correct Y (joint 1). Written by hand.
#[test]
fn a_file_written_by_hand_is_read() {
    let text = fixture("base/hal/out/m.hal");
    let file = KitFile { path: "m.hal".to_string(), role: Role::Table, bytes: text.into() };
    let profile = builtin::profile("linuxcnc-hal").unwrap();
    let Tables::Listed(found) = shown(read(&profile, &[file])).tables else { panic!("lists") };
    let found: [ListedTable; 1] = found.tables.try_into().unwrap();
    assert_eq!((&*found[0].base, &*found[0].output), ("0", "1"));
    let sum = |point: &Point| (point.position, point.forward);
    let expected = [(-100.0, 0.001), (0.0, 0.0), (100.0, -0.002), (150.0, 0.002)];
    assert_eq!(found[0].points.iter().map(sum).collect::<Vec<_>>(), expected);
}

const MEASURED_MM: [f64; 5] = [0.0, 250.0, 500.0, 750.0, 1000.0];
const UM: [[f64; 5]; 2] = [[0.0, 7.0, -3.0, 4.0, 11.0], [0.0, -2.0, 5.0, 5.0, 1.0]];

/// Six cross terms over a metre.
fn long(spacing: f64) -> (String, String) {
    let mut errors = String::from("axis,position_mm,ex_um,ey_um,ez_um\n");
    for (own, axis) in ["x", "y", "z"].into_iter().enumerate() {
        for (mm, at) in MEASURED_MM.iter().zip(0..) {
            let mut cells = UM.map(|um| um[at].to_string()).to_vec();
            cells.insert(own, String::new());
            errors += &format!("{axis},{mm},{}\n", cells.join(","));
        }
    }
    let keys = format!("spacing_mm = {spacing:?}");
    let axes = ["x", "y", "z"].map(|axis| (axis, [0.0, 1000.0], 0.0, keys.clone()));
    let job = support::job_of(support::UNCORRECTED, "controller = \"linuxcnc-hal\"", axes);
    (job, errors)
}

/// 84 curves: above 64 all have 16 points, and the sum of the pieces is still the measured curve.
#[test]
fn pieces_add_up_to_a_long_table_and_more_than_hal_holds_are_refused() {
    let (job, errors) = long(5.0);
    let (_, kit) = support::generate(&job, &errors);
    let text = support::text_of(&kit, "compensation.hal");
    let sixteens = vec!["16"; 64].join(",");
    assert!(text.contains(&format!("loadrt lincurve count=84 personality={sixteens}\n")), "{text}");
    let profile = builtin::profile("linuxcnc-hal").unwrap();
    let control = support::control(&profile, &kit);
    for (output, of) in [("1", UM[0]), ("2", UM[1])] {
        let response = support::response(control.as_ref(), "0", output, Direction::Plus);
        for tenth in -100..=10_100 {
            let at = f64::from(tenth) / 10.0;
            let section = MEASURED_MM[1..4].iter().filter(|mm| at > **mm).count();
            let share = (at.clamp(0.0, 1000.0) - MEASURED_MM[section]) / 250.0;
            let deviation = of[section] + share * (of[section + 1] - of[section]);
            let left = um_at(&response, at) + deviation;
            assert!(left.abs() <= 0.000_5 + support::DUST_UM, "{output} at {at}: {left} µm");
        }
    }
    let (job, errors) = long(1.0);
    let said = kit::generate(&support::inputs(&job, &errors)).expect_err("402 curves").render();
    let words = ["402 curves of 16 points, more than the 128", "use a larger spacing"];
    support::holds(&said, &words);
}
