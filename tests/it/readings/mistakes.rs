//! Readings that are refused, each with its place and the next step.

use super::*;

/// A mistake in the rows of steps (`-`: rows that begin so are left out, `+`: a row more), the words of the
/// problem, and those of the next step.
const OF_STEPS: &str = "\
moved -> mooved | unknown column `mooved` | did you mean `moved`?
PPP,1 -> PPP,0 | `run` is `0`, expected a whole number from 1 | number the repeated runs
PPP,1 -> PPX,1 | readings.csv:2:1¶ | P and N
1,forward -> 1,foward | `direction` is `foward`, expected `forward` or `reverse` | `reverse` = back over the same nodes
forward,3,z -> forward,3.0,z | `node` is `3.0`, expected a whole number from 0 | nodes count from 0
3,z -> 3,w | `moved` is `w`, expected `x`, `y`, `z` or, at node 0, an empty cell | name the axis
3,z,30 -> 3,z, | `deviation_um` is empty, expected a number | never filled in
3,z,30 -> 3,z,NaN | `deviation_um` is `NaN`, expected a finite number | plain number
3,z,30 -> 3,z,30,5 | the row has 7 cells, expected 6 | decimal comma needs semicolons
4,x -> 4,y | PPP run 1 forward, node 4: Y moved, expected X by the order XYZ | is empty at node 0
0,,0 -> 0,x,0 | PPP run 1 forward, node 0: X moved, expected no axis | is empty at node 0
3,z,30 -> 3,z,3e5 | PPP run 1 forward, node 3: the deviation is 300 mm, which no machine has | the unit in the column's name
6,z,60 -> 6,z,3e5 | PPP run 1 forward, node 6: the deviation is 300 mm, which no machine has | the unit in the column's name
3,z,30 -> 3,z,68000 | PPP run 1 forward, node 3: the deviation is 68 mm | named `displacement_mm`
- PPP,1,forward,2 | PPP run 1 forward: node 2 is missing | never filled in
- NPP,1,forward,1 NPP,1,forward,3 NPP,1,forward,4 NPP,1,forward,5 | NPP run 1 forward: nodes 1 and 3 to 5 are missing | never filled in
- PNP PPN | there is no forward run of PNP and PPN | all four body diagonals
+ PPP,1,forward,4,x,40 | PPP run 1 forward: node 4 stands more than once | in the column `run`
+ PPP,1,forward,9,z,40 | PPP run 1 forward reaches node 9, but the last node of this path is 6 | check `steps` and `kind`
+ PPN,1,forward,4000000000,z,40 | `node` is `4000000000`, expected a whole number | nodes count
empty | `readings.csv` holds no readings, expected a header and a row for each node | first line: diagonal
header alone | there is no forward run of PPP, NPP, PNP and PPN | needs all four body diagonals
no header | the first line holds numbers | first line: diagonal
no column of nodes | there is no column for the node, expected `node` | first line
no unit | column `deviation` has no unit, expected `deviation_um`, `deviation_mm` | part of the column's name
two units | column `displacement_mm` gives the same as column `deviation_um` before it | keep one
another word | the same in  | `reverse` = back over the same nodes
not filled in | the same in  | never filled in
another order | PPP run 1 forward, node 1: Z moved, expected X by the order XYZ | write `order = \"ZXY\"` in the job
moved on the way back | PPP run 1 reverse, node 0: X moved, expected no axis | in reverse rows too
one way back | there is no reverse run of NPP, PNP and PPN | leave its rows out
way back of another run | PPP run 2 reverse has no forward rows of the same run | the same number
way back in forward order | NNN run 1 forward takes the axes in the order XYZ, as the forward run does, so its nodes are not those of PPP: walked backwards, the order is ZYX | measure the return pass over the same nodes
way back of a way back | NNN run 1 reverse: `NNN` already names the return pass of PPP | write `PPP` and `reverse`
way back twice | PPP run 1 reverse stands a second time as NNN run 1 forward | different runs
temperature | `t_x_c` gives temperatures, but the job does not say whether | `material_corrected` and `air_corrected`
fahrenheit | `t_x_c` is 68 °C, expected -10 … 50 °C | degrees Celsius
temperature missing | PPP run 1 forward, node 4: `t_x_c` is empty | for the whole run
straight runs of 2 | the runs end at node 2, but single-axis runs with `steps = 2` end at node 6 | write `kind = \"straight\"`
straight runs of 6 | there is no column `moved` | `kind = \"straight\"`
";

/// The readings of steps with one of these mistakes.
fn file_with(mistake: &str) -> String {
    let column = |value: &'static str| with_column("t_x_c", |_| value.into());
    match mistake {
        "empty" => String::new(),
        "header alone" => format!("{HEADER}\n"),
        "no header" => "PPP,1,2\n".into(),
        "no column of nodes" => "diagonal,moved,deviation_um\nPPP,,0\n".into(),
        "no unit" => "diagonal,node,moved,deviation\n".into(),
        "two units" => "diagonal,node,deviation_um,displacement_mm\n".into(),
        "another word" => steps().replace(",forward,", ",fwd,"),
        "not filled in" => {
            let empty = |row: &String| row[..=row.rfind(',').unwrap()].to_string();
            file(HEADER, &step_rows().iter().map(empty).collect::<Vec<_>>())
        }
        "another order" => file(HEADER, &walks("forward", ["", "z", "x", "y", "z", "x", "y"])),
        "moved on the way back" => with(walks("reverse", ["x", "y", "z", "x", "y", "z", ""])),
        "one way back" => with(walk("PPP", "reverse", MOVED)),
        "way back of another run" => {
            steps() + &walk("PPP", "reverse", MOVED).join("\n").replace("PPP,1", "PPP,2")
        }
        "way back in forward order" => with(walk("NNN", "forward", MOVED)),
        "way back of a way back" => with(walk("NNN", "reverse", MOVED)),
        "way back twice" => {
            with([walks("reverse", MOVED), walk("NNN", "forward", BACKWARDS)].concat())
        }
        "temperature" => column("21"),
        "fahrenheit" => column("68"),
        "temperature missing" => {
            with_column("t_x_c", |row| if row == 4 { String::new() } else { "21".into() })
        }
        "straight runs of 2" => straight_with_moved(),
        "straight runs of 6" => straight(6),
        edit => match (edit.split_at(2), edit.split_once(" -> ")) {
            (("- ", heads), _) => without(|row| heads.split(' ').any(|head| row.starts_with(head))),
            (("+ ", row), _) => with(vec![row.into()]),
            (_, words) => words.map(|(from, to)| changed(from, to)).unwrap(),
        },
    }
}

fn straight(last: usize) -> String {
    of_nodes("diagonal,node,deviation_um", last, |d, node| format!("{d},{node},0"))
}

fn straight_with_moved() -> String {
    of_nodes("diagonal,node,moved,deviation_um", 2, |d, node| format!("{d},{node},,0"))
}

#[test]
fn mistakes_in_runs_of_steps_are_refused_with_place_and_next_step() {
    let measurement = measurement(PathKind::Step);
    for row in OF_STEPS.lines() {
        let [mistake, problem, help] = row.split(" | ").collect::<Vec<_>>()[..] else {
            panic!("{row}")
        };
        refused(&file_with(mistake), &measurement, &problem.replace('¶', "\n"), help);
    }
}

#[test]
fn mistakes_in_straight_runs_are_refused() {
    let measurement = measurement(PathKind::Straight);
    let says = "straight runs have no column `moved`";
    refused(&straight_with_moved(), &measurement, says, "`kind = \"step\"`");
    let says = "the runs end at node 6, but straight runs with `steps = 2` end at node 2";
    refused(&steps(), &measurement, says, "write `kind = \"step\"`");
    let says = "the readings look like `steps = 5`";
    refused(&straight(5), &measurement, "end at node 5", says);
}

#[test]
fn displacements_of_another_sign_or_unit_are_refused() {
    let mut measurement = measurement(PathKind::Step);
    let turned = displacements(&measurement, |mm| -mm);
    let says = "the displacement is -29.802 mm, expected about 29.802 mm";
    refused(&turned, &measurement, says, "write `laser_sign = \"-\"`");
    let inches = displacements(&measurement, |mm| mm / 25.4);
    refused(&inches, &measurement, "expected about", "check the unit in the column's name");
    measurement.laser_sign = Direction::Minus;
    let plain = displacements(&measurement, |mm| mm);
    refused(&plain, &measurement, "expected about -", "write `laser_sign = \"+\"`");
}
