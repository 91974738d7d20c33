//! Readings that are refused, each with its place and the next step.

use super::*;

/// One change in the rows of steps, then the words of the problem, then those of the next step.
const CHANGES: &str = "\
moved -> mooved
unknown column `mooved`
did you mean `moved`?
PPP,1 -> PPP,0
`run` is `0`, expected a whole number from 1
number the repeated runs
1,forward -> 1,foward
`direction` is `foward`, expected `forward` or `reverse`
`reverse` = back over the same nodes
forward,3,z -> forward,3.0,z
`node` is `3.0`, expected a whole number from 0
nodes count from 0
3,z -> 3,w
`moved` is `w`, expected `x`, `y`, `z` or, at node 0, an empty cell
name the axis
3,z,30 -> 3,z,
`deviation_um` is empty, expected a number
never filled in
3,z,30 -> 3,z,NaN
`deviation_um` is `NaN`, expected a finite number
plain number
3,z,30 -> 3,z,30,5
the row has 7 cells, expected 6
decimal comma needs semicolons
4,x -> 4,y
PPP run 1 forward, node 4: Y moved, expected X by the order XYZ
is empty at node 0
0,,0 -> 0,x,0
PPP run 1 forward, node 0: X moved, expected no axis
is empty at node 0
0,,0 -> 0,,12.5
PPP run 1 forward begins with 12.5 µm at node 0, expected 0
subtract this reading
3,z,30 -> 3,z,3e5
PPP run 1 forward, node 3: the deviation is 300 mm, which no machine has
the unit in the column's name
3,z,30 -> 3,z,68000
PPP run 1 forward, node 3: the deviation is 68 mm
named `displacement_mm`
";

#[test]
fn a_change_in_runs_of_steps_is_refused_with_place_and_next_step() {
    let measurement = measurement(PathKind::Step);
    for mistake in CHANGES.lines().collect::<Vec<_>>().chunks(3) {
        let (from, to) = mistake[0].split_once(" -> ").unwrap();
        refused(&changed(from, to), &measurement, mistake[1], mistake[2]);
    }
}

/// Whole files, missing rows and rows too many.
fn mistakes_of_steps() -> Vec<(String, &'static str, &'static str)> {
    vec![
        (
            String::new(),
            "`readings.csv` holds no readings, expected a header and a row for each node",
            "first line: diagonal",
        ),
        (
            format!("{HEADER}\n"),
            "there is no forward run of PPP, NPP, PNP and PPN",
            "needs all four body diagonals",
        ),
        ("PPP,1,2\n".into(), "the first line holds numbers", "first line: diagonal"),
        (
            "diagonal,moved,deviation_um\nPPP,,0\n".into(),
            "there is no column for the node, expected `node`",
            "first line",
        ),
        (
            "diagonal,node,moved,deviation\n".into(),
            "column `deviation` has no unit, expected `deviation_um`, `deviation_mm`",
            "part of the column's name",
        ),
        (
            "diagonal,node,deviation_um,displacement_mm\n".into(),
            "column `displacement_mm` gives the same as column `deviation_um` before it",
            "keep one",
        ),
        (changed("PPP,1", "PPX,1"), "readings.csv:2:1\n", "P and N"),
        (
            steps().replace(",forward,", ",fwd,"),
            "the same in ",
            "`reverse` = back over the same nodes",
        ),
        (not_filled_in(), "the same in ", "never filled in"),
        (
            without(|row| row.starts_with("PPP,1,forward,2")),
            "PPP run 1 forward: node 2 is missing",
            "never filled in",
        ),
        (
            without(|row| ["1", "3", "4", "5"].iter().any(|n| is_at(row, "NPP", n))),
            "NPP run 1 forward: nodes 1 and 3 to 5 are missing",
            "never filled in",
        ),
        (
            with(vec!["PPP,1,forward,4,x,40".into()]),
            "PPP run 1 forward: node 4 stands more than once",
            "in the column `run`",
        ),
        (
            with(vec!["PPP,1,forward,9,z,40".into()]),
            "PPP run 1 forward reaches node 9, but the last node of this path is 6",
            "check `steps` and `kind`",
        ),
        (
            with(vec!["PPN,1,forward,4000000000,z,40".into()]),
            "`node` is `4000000000`, expected a whole number",
            "nodes count",
        ),
        (
            without(|row| row.starts_with("PNP") || row.starts_with("PPN")),
            "there is no forward run of PNP and PPN",
            "all four body diagonals",
        ),
        (
            file(HEADER, &walks("forward", ["", "z", "x", "y", "z", "x", "y"])),
            "PPP run 1 forward, node 1: Z moved, expected X by the order XYZ",
            "write `order = \"ZXY\"` in the job",
        ),
        (
            with(walks("reverse", ["x", "y", "z", "x", "y", "z", ""])),
            "PPP run 1 reverse, node 0: X moved, expected no axis",
            "in reverse rows too",
        ),
        (
            with(walk("PPP", "reverse", MOVED)),
            "there is no reverse run of NPP, PNP and PPN",
            "leave its rows out",
        ),
        (
            steps() + &walk("PPP", "reverse", MOVED).join("\n").replace("PPP,1", "PPP,2"),
            "PPP run 2 reverse has no forward rows of the same run",
            "the same number",
        ),
        (
            with(walk("NNN", "forward", MOVED)),
            "NNN run 1 forward takes the axes in the order XYZ, as the forward run does, so its nodes are not those of PPP: walked backwards, the order is ZYX",
            "measure the return pass over the same nodes",
        ),
        (
            with(walk("NNN", "reverse", MOVED)),
            "NNN run 1 reverse: `NNN` already names the return pass of PPP",
            "write `PPP` and `reverse`",
        ),
        (
            with([walks("reverse", MOVED), walk("NNN", "forward", BACKWARDS)].concat()),
            "PPP run 1 reverse stands a second time as NNN run 1 forward",
            "different runs",
        ),
        (
            with_column("t_x_c", |_| "21".into()),
            "`t_x_c` gives temperatures, but the job does not say whether",
            "`material_corrected` and `air_corrected`",
        ),
        (
            with_column("t_x_c", |_| "68".into()),
            "`t_x_c` is 68 °C, expected -10 … 50 °C",
            "degrees Celsius",
        ),
        (
            with_column("t_x_c", |row| if row == 4 { String::new() } else { "21".into() }),
            "PPP run 1 forward, node 4: `t_x_c` is empty",
            "for the whole run",
        ),
        (
            straight_with_moved(),
            "the runs end at node 2, but single-axis runs with `steps = 2` end at node 6",
            "write `kind = \"straight\"`",
        ),
        (straight(6), "there is no column `moved`", "`kind = \"straight\"`"),
    ]
}

/// Every reading is still an empty cell.
fn not_filled_in() -> String {
    let empty = |row: &String| row[..=row.rfind(',').unwrap()].to_string();
    file(HEADER, &step_rows().iter().map(empty).collect::<Vec<_>>())
}

/// Whether a row is that of a node of a forward run.
fn is_at(row: &str, name: &str, node: &str) -> bool {
    row.starts_with(&format!("{name},1,forward,{node},"))
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
    for (text, problem, help) in mistakes_of_steps() {
        refused(&text, &measurement, problem, help);
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
