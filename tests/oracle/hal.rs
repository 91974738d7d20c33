//! LinuxCNC with a HAL file: what the reader makes of such a file, and tables longer than a curve.
use crate::support::{self, um_at};
use nonius::control::controller::{KitFile, Role, builtin};
use nonius::control::table::Tables;
use nonius::control::table::{ListedTable, Point};
use nonius::kit;
use nonius::quantity::Direction;
use nonius::read::read;

/// Two curves of X, one of 3 and one of 2 points, correct Y (joint 1). Written by hand.
const FILE: &str = include_str!("by_hand.hal");

fn tables(text: &str) -> Result<Vec<ListedTable>, String> {
    let profile = builtin::profile("linuxcnc-hal").unwrap();
    let file = KitFile { path: "m.hal".to_string(), role: Role::Table, bytes: text.into() };
    match read(&profile, &[file]).map_err(|p| p.render())?.tables {
        Tables::Listed(tables) => Ok(tables.tables),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_file_written_by_hand_is_read() {
    let found: [ListedTable; 1] = tables(FILE).unwrap().try_into().unwrap();
    assert_eq!((&*found[0].base, &*found[0].output), ("0", "1"));
    let sum = |point: &Point| (point.position, point.forward);
    let expected = [(-100.0, 0.001), (0.0, 0.0), (100.0, -0.002), (150.0, 0.002)];
    assert_eq!(found[0].points.iter().map(sum).collect::<Vec<_>>(), expected);
}

/// Words of [`FILE`] (¶ = the end of a line), what stands there instead, and what is said of it.
const REFUSED: &str = "\
gain1 -1 | gain1 1 | m.hal:27:19: `1` stands here, expected `setp sum2.2.gain1 -1`
setp sum2.2.gain1 -1¶ |  | m.hal:27:6: `lincurve.0.x-val-00` stands here, expected `setp sum2.2.gain1 -1`
net nonius-1-encoder sum2.2.in0 | net nonius-1-command sum2.2.in0 | m.hal:20:5: `nonius-1-command` stands here, expected `net nonius-1-encoder sum2.2.in0`
addf sum2.0 servo-thread¶addf sum2.1 servo-thread | addf sum2.1 servo-thread¶addf sum2.0 servo-thread | m.hal:6:6: `sum2.1` stands here
addf sum2.0 servo-thread | addf sum2.0 slow | m.hal:6:13: `slow` stands here
addf sum2.0 servo-thread | addf sum2.0 | m.hal:6:12: nothing stands here
addf lincurve.1 servo-thread¶ |  | m.hal:5:6: `sum2.0` stands here
setp lincurve.0.y-val-01 0¶ |  | m.hal:31:6: `lincurve.0.x-val-02` stands here, expected `setp lincurve.0.y-val-01 NUMBER`
setp lincurve.1.y-val-01 0.004¶ |  | m.hal:37:1: nothing stands here, expected `setp lincurve.1.y-val-01 NUMBER`
y-val-01 0.004 | y-val-01 0.004¶loadusr halmeter | m.hal:38:1: `loadusr` stands here, expected the end of the file
y-val-01 0.004 | y-val-01 0.004 7 | m.hal:37:32: `7` stands here
y-val-01 0.004 | y-val-01 nan | m.hal:37:26: `nan` stands here
x-val-01 0¶ | x-val-01 -100¶ | m.hal:30:26: the points of a curve do not ascend
personality=3,2 | personality=3 | m.hal:2:1: expected `loadrt lincurve count=N personality=LIST` first
personality=3,2 | personality=3,17 | of up to 128 curves of 2 to 16 points
count=2  | count=129  | of up to 128 curves
# by hand | loadrt pid count=1 | m.hal:1:1: expected `loadrt lincurve
sum2 count=3 | sum2 count=4 | m.hal:3:13: `count=4` stands here, expected `loadrt sum2 count=3`
net nonius-0-position lincurve.1.in | net nonius-x-position lincurve.1.in | m.hal:11:1: expected a line `net nonius-J-… lincurve.1.in` with the joint J
nonius-1-curve-1 lincurve.1.out | nonius-16-curve-1 lincurve.1.out | m.hal:17:1: expected a line `net nonius-J-… lincurve.1.out` with the joint J
nonius-1-curve-1 lincurve.1.out | nonius-0-curve-1 lincurve.1.out | the curves of a joint do not stand together
net nonius-0-position lincurve.1.in | net nonius-1-position lincurve.1.in | joint 1 corrects itself
0-position joint.0.pos-cmd | 0-position joint.0.pos-fb | m.hal:9:23: `joint.0.pos-fb` stands here
";

#[test]
fn what_would_not_do_what_is_meant_is_refused_at_the_place() {
    for row in REFUSED.lines() {
        let cells: Vec<String> = row.split(" | ").map(|cell| cell.replace('¶', "\n")).collect();
        assert!(FILE.contains(&cells[0]), "{row}");
        let said = tables(&FILE.replacen(&cells[0], &cells[1], 1)).expect_err(row);
        let (place, words) = match cells[2].split_once(": ") {
            Some((place, words)) if place.starts_with("m.hal:") => (place, words),
            _ => ("m.hal:", &cells[2][..]),
        };
        assert!(said.contains(place) && said.contains(words), "{row}\n{said}");
    }
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
fn pieces_add_up_to_a_long_table() {
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
}

#[test]
fn more_curves_than_hal_holds_are_refused() {
    let (job, errors) = long(1.0);
    let said = kit::generate(&support::inputs(&job, &errors)).expect_err("402 curves").render();
    assert!(said.contains("402 curves of 16 points, more than the 128"), "{said}");
    assert!(said.contains("use a larger spacing"), "{said}");
}
