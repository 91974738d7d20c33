//! Readings that are refused, each with its place and the next step.

use super::*;

fn mistakes_of_steps() -> Vec<Mistake> {
    let all_reverse = |moved| {
        ["PPP", "NPP", "PNP", "PPN"]
            .iter()
            .flat_map(|name| walk(name, "reverse", moved))
            .collect::<Vec<String>>()
    };
    let none = String::new;
    vec![
        (
            "empty",
            none(),
            "`readings.csv` holds no readings, expected a header and a row for each node",
            "first line: diagonal",
        ),
        (
            "header only",
            format!("{HEADER}\n"),
            "there is no forward run of PPP, NPP, PNP and PPN",
            "needs all four body diagonals",
        ),
        (
            "numbers first",
            "PPP,1,2\n".into(),
            "the first line holds numbers",
            "first line: diagonal",
        ),
        (
            "no node",
            "diagonal,moved,deviation_um\nPPP,,0\n".into(),
            "there is no column for the node, expected `node`",
            "first line",
        ),
        (
            "no unit",
            "diagonal,node,moved,deviation\n".into(),
            "column `deviation` has no unit, expected `deviation_um`, `deviation_mm`",
            "part of the column's name",
        ),
        (
            "two readings",
            "diagonal,node,deviation_um,displacement_mm\n".into(),
            "column `displacement_mm` gives the same as column `deviation_um` before it",
            "keep one",
        ),
        (
            "misspelt",
            changed("moved", "mooved"),
            "unknown column `mooved`",
            "did you mean `moved`?",
        ),
        ("unknown diagonal", changed("PPP,1", "PPX,1"), "readings.csv:2:1\n", "P and N"),
        (
            "run 0",
            changed("PPP,1", "PPP,0"),
            "`run` is `0`, expected a whole number from 1",
            "number the repeated runs",
        ),
        (
            "direction",
            changed("1,forward", "1,foward"),
            "`direction` is `foward`, expected `forward` or `reverse`",
            "`reverse` = back over the same nodes",
        ),
        (
            "direction in every row",
            file(HEADER, &step_rows()).replace(",forward,", ",fwd,"),
            "the same in ",
            "`reverse` = back over the same nodes",
        ),
        (
            "not filled in",
            format!(
                "{}\n",
                file(HEADER, &step_rows())
                    .lines()
                    .map(|row| match row.rfind(',') {
                        Some(end) if !row.starts_with("diagonal") => row[..=end].to_string(),
                        _ => row.to_string(),
                    })
                    .collect::<Vec<String>>()
                    .join("\n")
            ),
            "the same in ",
            "never filled in",
        ),
        (
            "node",
            changed("forward,3,z", "forward,3.0,z"),
            "`node` is `3.0`, expected a whole number from 0",
            "nodes count from 0",
        ),
        (
            "moved",
            changed("3,z", "3,w"),
            "`moved` is `w`, expected `x`, `y`, `z` or, at node 0, an empty cell",
            "name the axis",
        ),
        (
            "no reading",
            changed("3,z,30", "3,z,"),
            "`deviation_um` is empty, expected a number",
            "never filled in",
        ),
        (
            "NaN",
            changed("3,z,30", "3,z,NaN"),
            "`deviation_um` is `NaN`, expected a finite number",
            "plain number",
        ),
        (
            "comma",
            changed("3,z,30", "3,z,30,5"),
            "the row has 7 cells, expected 6",
            "decimal comma needs semicolons",
        ),
        (
            "one missing",
            without(|row| row.starts_with("PPP,1,forward,2")),
            "PPP run 1 forward: node 2 is missing",
            "never filled in",
        ),
        (
            "several missing",
            without(|row| {
                row.starts_with("NPP")
                    && ["1", "3", "4", "5"].iter().any(|n| row.contains(&format!("forward,{n},")))
            }),
            "NPP run 1 forward: nodes 1 and 3 to 5 are missing",
            "never filled in",
        ),
        (
            "twice",
            with(vec!["PPP,1,forward,4,x,40".into()]),
            "PPP run 1 forward: node 4 stands more than once",
            "in the column `run`",
        ),
        (
            "beyond",
            with(vec!["PPP,1,forward,9,z,40".into()]),
            "PPP run 1 forward reaches node 9, but the last node of this path is 6",
            "check `steps` and `kind`",
        ),
        (
            "far beyond",
            with(vec!["PPN,1,forward,4000000000,z,40".into()]),
            "`node` is `4000000000`, expected a whole number",
            "nodes count",
        ),
        (
            "diagonal missing",
            without(|row| row.starts_with("PNP") || row.starts_with("PPN")),
            "there is no forward run of PNP and PPN",
            "all four body diagonals",
        ),
        (
            "another order",
            file(
                HEADER,
                &["PPP", "NPP", "PNP", "PPN"]
                    .iter()
                    .flat_map(|name| walk(name, "forward", ["", "z", "x", "y", "z", "x", "y"]))
                    .collect::<Vec<_>>(),
            ),
            "PPP run 1 forward, node 1: Z moved, expected X by the order XYZ",
            "write `order = \"ZXY\"` in the job",
        ),
        (
            "one wrong axis",
            changed("4,x", "4,y"),
            "PPP run 1 forward, node 4: Y moved, expected X by the order XYZ",
            "is empty at node 0",
        ),
        (
            "axis at node 0",
            changed("0,,0", "0,x,0"),
            "PPP run 1 forward, node 0: X moved, expected no axis",
            "is empty at node 0",
        ),
        (
            "step as walked",
            with(all_reverse(["x", "y", "z", "x", "y", "z", ""])),
            "PPP run 1 reverse, node 0: X moved, expected no axis",
            "in reverse rows too",
        ),
        (
            "one way back",
            with(walk("PPP", "reverse", MOVED)),
            "there is no reverse run of NPP, PNP and PPN",
            "leave its rows out",
        ),
        (
            "lonely way back",
            with(
                walk("PPP", "reverse", MOVED)
                    .iter()
                    .map(|row| row.replace("PPP,1", "PPP,2"))
                    .collect(),
            ),
            "PPP run 2 reverse has no forward rows of the same run",
            "the same number",
        ),
        (
            "other nodes",
            with(walk("NNN", "forward", MOVED)),
            "NNN run 1 forward takes the axes in the order XYZ, as the forward run does, so its nodes are not those of PPP: walked backwards, the order is ZYX",
            "measure the return pass over the same nodes",
        ),
        (
            "doubly reversed",
            with(walk("NNN", "reverse", MOVED)),
            "NNN run 1 reverse: `NNN` already names the return pass of PPP",
            "write `PPP` and `reverse`",
        ),
        (
            "two ways back",
            with(
                [all_reverse(MOVED), walk("NNN", "forward", ["", "z", "y", "x", "z", "y", "x"])]
                    .concat(),
            ),
            "PPP run 1 reverse stands a second time as NNN run 1 forward",
            "different runs",
        ),
        (
            "start",
            changed("0,,0", "0,,12.5"),
            "PPP run 1 forward begins with 12.5 µm at node 0, expected 0",
            "subtract this reading",
        ),
        (
            "implausible",
            changed("3,z,30", "3,z,3e5"),
            "PPP run 1 forward, node 3: the deviation is 300 mm, which no machine has",
            "the unit in the column's name",
        ),
        (
            "displacement as deviation",
            changed("3,z,30", "3,z,68000"),
            "PPP run 1 forward, node 3: the deviation is 68 mm",
            "named `displacement_mm`",
        ),
        (
            "temperature without material",
            with_column("t_x_c", |_| "21".into()),
            "`t_x_c` gives temperatures, but the job does not say whether",
            "`material_corrected` and `air_corrected`",
        ),
        (
            "Fahrenheit",
            with_column("t_x_c", |_| "68".into()),
            "`t_x_c` is 68 °C, expected -10 … 50 °C",
            "degrees Celsius",
        ),
        (
            "one temperature missing",
            with_column("t_x_c", |row| if row == 4 { String::new() } else { "21".into() }),
            "PPP run 1 forward, node 4: `t_x_c` is empty",
            "for the whole run",
        ),
        (
            "straight",
            file(
                "diagonal,node,moved,deviation_um",
                &(0..=2)
                    .flat_map(|node| Diagonal::ALL.map(|d| format!("{d},{node},,0")))
                    .collect::<Vec<_>>(),
            ),
            "the runs end at node 2, but single-axis runs with `steps = 2` end at node 6",
            "write `kind = \"straight\"`",
        ),
        (
            "no moved",
            file(
                "diagonal,node,deviation_um",
                &(0..=6)
                    .flat_map(|node| Diagonal::ALL.map(|d| format!("{d},{node},0")))
                    .collect::<Vec<_>>(),
            ),
            "there is no column `moved`",
            "`kind = \"straight\"`",
        ),
    ]
}

#[test]
fn mistakes_in_runs_of_steps_are_refused_with_place_and_next_step() {
    let measurement = measurement(PathKind::Step);
    for (name, text, problem, help) in mistakes_of_steps() {
        refused(name, &text, &measurement, problem, help);
    }
}

#[test]
fn mistakes_in_straight_runs_are_refused() {
    let straight = measurement(PathKind::Straight);
    let moved = (0..=2).flat_map(|node| Diagonal::ALL.map(|d| format!("{d},{node},,0")));
    let moved = file("diagonal,node,moved,deviation_um", &moved.collect::<Vec<_>>());
    let step = file(HEADER, &step_rows());
    refused(
        "moved",
        &moved,
        &straight,
        "straight runs have no column `moved`",
        "`kind = \"step\"`",
    );
    refused(
        "steps",
        &step,
        &straight,
        "the runs end at node 6, but straight runs with `steps = 2` end at node 2",
        "write `kind = \"step\"`",
    );
    let rows: Vec<String> =
        (0..=5).flat_map(|node| Diagonal::ALL.map(|d| format!("{d},{node},0"))).collect();
    let text = file("diagonal,node,deviation_um", &rows);
    refused("five steps", &text, &straight, "end at node 5", "the readings look like `steps = 5`");
}

#[test]
fn displacements_of_another_sign_or_unit_are_refused() {
    let mut measurement = measurement(PathKind::Step);
    let turned = displacements(&measurement, |mm| -mm);
    refused(
        "turned",
        &turned,
        &measurement,
        "the displacement is -29.802 mm, expected about 29.802 mm",
        "write `laser_sign = \"-\"`",
    );
    let inches = displacements(&measurement, |mm| mm / 25.4);
    refused(
        "inches",
        &inches,
        &measurement,
        "expected about",
        "check the unit in the column's name",
    );
    measurement.laser_sign = Direction::Minus;
    let plain = displacements(&measurement, |mm| mm);
    refused("plain", &plain, &measurement, "expected about -", "write `laser_sign = \"+\"`");
}
