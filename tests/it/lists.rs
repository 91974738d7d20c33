//! Lists of captures into a form: all of them, one too few, one too many, of diagonals and of one axis.
use crate::support::run::ended;
use crate::support::skipped;
use nonius::inputs::import::stated::{Counting, Stated};
use nonius::inputs::import::{List, Measurement, fill};
use nonius::quantity::diagonal::Diagonal;
use nonius::text::document::Source;
use std::fs::{read_to_string, write};
use std::path::Path;

/// The captures of case D in the order in which they are taken: three runs forth and back, scatter 0.2 µm.
/// Each with what stands before its value in a form.
fn case_d(diagonal: &str) -> Vec<(String, f64)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = path.join("fixtures/diagonals/case_d_bidirectional/readings.csv");
    let table = read_to_string(path).expect("it is there");
    let mut rows: Vec<(String, f64)> = Vec::new();
    for line in table.lines().filter(|line| line.starts_with(diagonal)) {
        let (cells, value) = line.rsplit_once(',').expect("cells");
        rows.push((cells.to_string(), value.parse().expect("a number")));
    }
    let node = |row: &(String, f64)| row.0.split(',').nth(3).unwrap().parse::<i32>().unwrap();
    let key = |row: &(String, f64)| {
        let cells: Vec<&str> = row.0.split(',').collect();
        let back = cells[2] == "reverse";
        (cells[1].to_string(), back, if back { -node(row) } else { node(row) })
    };
    rows.sort_by_key(key);
    rows
}

const DIAGONALS: [&str; 4] = ["PPP", "NPP", "PNP", "PPN"];

fn form() -> String {
    let rows = DIAGONALS.iter().flat_map(|diagonal| case_d(diagonal));
    let rows: String = rows.map(|(cells, _)| format!("{cells},\n")).collect();
    format!("diagonal,run,direction,node,moved,deviation_um\n{rows}")
}

fn list(values: &[f64]) -> String {
    values.iter().map(|value| format!("{value}\n")).collect()
}

/// What comes of lists of all diagonals, the first one being `own`.
fn filled(own: &[f64], counting: Counting, columns: &str) -> Result<String, String> {
    let texts: Vec<String> = DIAGONALS
        .iter()
        .map(|name| {
            let values: Vec<f64> = case_d(name).iter().map(|(_, value)| *value).collect();
            match (*name == "PPP", counting) {
                (true, _) => list(own),
                (false, Counting::Cumulative) => list(&values),
                (false, Counting::Incremental) => list(&increments(&values)),
            }
        })
        .collect();
    let lists: Vec<List<'_>> = Diagonal::ALL
        .into_iter()
        .zip(&texts)
        .map(|(diagonal, text)| {
            let file = Measurement {
                path: "list.txt",
                name: "list.txt",
                sha256: "0",
                bytes: text.as_bytes(),
            };
            (Some(diagonal), file)
        })
        .collect();
    let stated = Stated {
        columns: Some(columns.to_string()),
        captures: Some(counting),
        ..Stated::default()
    };
    let form = Source::from_bytes("form.csv", form().as_bytes()).unwrap();
    fill(&form, &lists, None, &stated).map_err(|problems| problems.render())
}

fn increments(values: &[f64]) -> Vec<f64> {
    values.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

fn own() -> (Vec<String>, Vec<f64>) {
    case_d("PPP").into_iter().unzip()
}

#[test]
fn as_many_values_as_captures_fill_the_form() {
    let (cells, values) = own();
    for (counting, own) in
        [(Counting::Cumulative, values.clone()), (Counting::Incremental, increments(&values))]
    {
        let text = filled(&own, counting, "#1=deviation_um").expect("they fit");
        let rows = text.lines().filter(|line| line.starts_with("PPP"));
        for (row, (cells, value)) in rows.zip(cells.iter().zip(&values)) {
            let (before, found) = row.rsplit_once(',').expect("cells");
            let found: f64 = found.parse().expect("a number");
            // The first capture of case D is not zero; increments count from it.
            let expected =
                if counting == Counting::Cumulative { *value } else { value - values[0] };
            assert_eq!(before, cells);
            assert!((found - expected).abs() < 1e-6, "{row}: {expected}");
        }
    }
}

/// The name of a capture as the refusal says it.
fn name(cells: &str) -> String {
    let cells: Vec<&str> = cells.split(',').collect();
    let moved = if cells[4].is_empty() { String::new() } else { format!(", moved {}", cells[4]) };
    format!("run {}, direction {}, node {}{moved}", cells[1], cells[2], cells[3])
}

/// Deviations alone, without the steps, are the hard case: what shows is that the runs no longer repeat.
#[test]
fn among_deviations_the_missing_capture_lies_where_it_is_said_to() {
    let (cells, values) = own();
    let (mut told, mut narrow) = (0, 0);
    for place in (0..values.len()).step_by(3) {
        let mut values = values.clone();
        values.remove(place);
        let said =
            filled(&values, Counting::Cumulative, "#1=deviation_um").expect_err("one is missing");
        assert!(said.contains("expected 186 as in the form: one is missing"), "{said}");
        let is_named = |at: &usize| said.contains(&name(&cells[*at]));
        let named: Vec<usize> = (0..cells.len()).filter(is_named).collect();
        let (Some(first), Some(last)) = (named.first(), named.last()) else {
            assert!(said.contains("cannot be told"), "{said}");
            continue;
        };
        told += 1;
        narrow += usize::from(last - first <= 5);
        assert!((first..=last).contains(&&place), "{}: {said}", name(&cells[place]));
    }
    assert!(told > 50 && narrow > 30, "{told} told, {narrow} within six captures");
}

#[test]
fn with_displacements_every_missing_or_doubled_capture_is_named() {
    let (cells, values) = own();
    let node = |cells: &String| cells.split(',').nth(3).unwrap().parse::<usize>().unwrap();
    // Projections of steps of 90, 72 and 72 mm on the diagonal of the box.
    let (steps, length) = ([90.0, 72.0, 72.0_f64], 900.0_f64.hypot(720.0).hypot(720.0));
    let nominal =
        |node: usize| (0..node).map(|k| steps[k % 3] * steps[k % 3] * 10.0 / length).sum::<f64>();
    let whole: Vec<f64> =
        cells.iter().zip(&values).map(|(cells, um)| nominal(node(cells)) + um / 1000.0).collect();
    for place in (0..whole.len()).step_by(3) {
        let mut values = whole.clone();
        values.remove(place);
        let said = filled(&values, Counting::Cumulative, "#1=displacement_mm")
            .expect_err("one is missing");
        assert!(said.contains(&name(&cells[place])), "{place}: {said}");
        let mut values = whole.clone();
        values.insert(place, whole[place] + 0.000_1);
        let said = filled(&values, Counting::Cumulative, "#1=displacement_mm")
            .expect_err("one is too many");
        let named =
            [place + 1, place + 2].iter().any(|value| said.contains(&format!("value {value}")));
        assert!(named && said.contains("more than 10⁹ : 1"), "{place}: {said}");
    }
}

#[test]
fn what_lists_do_not_carry_has_to_be_stated() {
    let place = tempfile::tempdir().expect("a place to write to");
    let at = place.path();
    let travel = "--travel 400,300,200";
    let (status, ..) = ended(at, &format!("new --controller generic {travel} --readings -o visit"));
    assert_eq!(status, Some(0));
    let form = read_to_string(at.join("visit/readings.csv")).expect("a form");
    for name in DIAGONALS {
        let count = form.lines().filter(|line| line.starts_with(name)).count();
        let values: String = (0..count).map(|k| format!("{k},5\n")).collect();
        write(at.join(format!("{name}.txt")), format!("Reading\n{values}"))
            .expect("it can be written");
    }
    let lists = "--ppp PPP.txt --npp NPP.txt --pnp PNP.txt --ppn PPN.txt";
    let command = format!("import --form visit/readings.csv {lists} -o visit/readings.csv --force");
    for (more, says) in [
        ("", "`--columns` is not stated"),
        ("", "`--captures` is not stated"),
        ("--columns #1=displacement_mm --captures cumulative", "`--decimal` is not stated"),
        ("--columns #1=length_mm --captures cumulative", "names no readings"),
        (
            "--columns #1=displacement_mm --captures cumulative --term EXX",
            "`--term` has no meaning",
        ),
        ("--columns #1=displacement_mm --captures incremental --decimal comma", "one is too many"),
    ] {
        let (status, _, said) = ended(at, &format!("{command} {more}"));
        assert_eq!(status, Some(2), "{more}");
        assert!(said.contains(says), "{more}: {said}");
        assert_eq!(read_to_string(at.join("visit/readings.csv")).unwrap(), form);
    }
    let (status, page, said) = ended(
        at,
        &format!(
            "{command} --columns Reading=displacement_mm --captures cumulative --decimal comma"
        ),
    );
    assert_eq!(status, Some(0), "{said}");
    assert!(page.contains("every capture of the form has its value"), "{page}");
    let again = ended(
        at,
        &format!(
            "{command} --columns Reading=displacement_mm --captures cumulative --decimal comma"
        ),
    );
    assert!(again.2.contains("holds a value already"), "{}", again.2);
}

/// Real bidirectional runs of a stage, as a list in the order of its captures.
#[test]
fn a_list_of_a_real_axis_misses_the_capture_that_was_taken_out() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"));
    let Ok(table) = read_to_string(path.join("../shared/data/iso230-2/iso230_2_ess_b02_x.csv"))
    else {
        return skipped::skipped();
    };
    let rows = table.lines().filter(|line| !line.starts_with(['#', 'i']));
    let rows: Vec<Vec<f64>> =
        rows.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    let (mut form, mut names, mut whole) = (String::new(), Vec::new(), Vec::new());
    for run in 1..=5 {
        let up = rows.iter().map(|row| (row[1], "+", row[1 + run]));
        let down = rows.iter().rev().map(|row| (row[1], "-", row[6 + run]));
        for (target, direction, at) in up.chain(down) {
            form += &format!("{target},{run},{direction},\n");
            names.push(format!("target_mm {target}, run {run}, direction {direction}"));
            whole.push(at - rows[0][1]);
        }
    }
    let form = format!("target_mm,run,direction,deviation_um\n{form}");
    let filled = |values: &[f64]| {
        let text = list(values);
        let file =
            Measurement { path: "x.txt", name: "x.txt", sha256: "0", bytes: text.as_bytes() };
        let stated = Stated {
            columns: Some("#1=displacement_mm".to_string()),
            captures: Some(Counting::Cumulative),
            ..Stated::default()
        };
        let form = Source::from_bytes("form.csv", form.as_bytes()).unwrap();
        let filled = fill(&form, &[(None, file)], None, &stated);
        filled.map_err(|problems| problems.render())
    };
    let text = filled(&whole).expect("they fit");
    let first: f64 = text.lines().last().unwrap().rsplit(',').next().unwrap().parse().unwrap();
    assert!((first - (rows[0][11] - rows[0][1]) * 1000.0).abs() < 1e-6, "{first}");
    for (place, name) in names.iter().enumerate() {
        let mut values = whole.clone();
        values.remove(place);
        let said = filled(&values).expect_err("one is missing");
        assert!(said.contains(name), "{name}: {said}");
    }
}

/// `cargo test --features excel --test lists`: a sheet of a workbook is a text with columns.
#[cfg(feature = "excel")]
#[test]
fn a_sheet_of_a_workbook_is_mapped_like_a_text() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let book = "import fixtures/formats/workbook_selfmade.xlsx --axis x --direction both --sign as-error -o -";
    let columns = "--columns #1=position_mm,Dev[um]=ex_um";
    let (status, _, said) = ended(root, &format!("{book} {columns}"));
    assert_eq!(status, Some(2), "the first sheet holds no table: {said}");
    let (status, _, said) = ended(root, &format!("{book} {columns} --sheet Other"));
    assert!(status == Some(2) && said.contains("its sheets: Notes, Readings"), "{said}");
    let (status, table, said) = ended(root, &format!("{book} {columns} --sheet Readings"));
    assert_eq!(status, Some(0), "{said}");
    let rows: Vec<&str> = table.lines().filter(|line| !line.starts_with('#')).collect();
    assert_eq!(rows, ["axis,position_mm,ex_um", "x,0,0", "x,100,1.25", "x,200,-0.5"]);
}
