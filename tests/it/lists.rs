//! Lists of captures into a form: all of them, one too few, one too many, of diagonals and of one axis.
use crate::support::{DIAGONALS, Visit, fixture, shared, source};
use nonius::inputs::import::stated::{Counting, ImportFacts};
use nonius::inputs::import::{List, Measurement, fill};
use nonius::quantity::Diagonal;
use std::fs::read_to_string;

/// The captures of case D as they are taken, three runs forth and back, each with what stands before it in a form.
fn case_d(diagonal: &str) -> (Vec<String>, Vec<f64>) {
    let table = fixture("diagonals/case_d_bidirectional/readings.csv");
    let rows = table.lines().filter(|line| line.starts_with(diagonal));
    let mut rows: Vec<_> = rows.map(|line| line.rsplit_once(',').unwrap()).collect();
    rows.sort_by_key(|(cells, _)| {
        let cells: Vec<&str> = cells.split(',').collect();
        let (node, back) = (cells[3].parse::<i32>().unwrap(), cells[2] == "reverse");
        (cells[1], back, if back { -node } else { node })
    });
    let parsed = |(cells, value): (&str, &str)| (cells.to_string(), value.parse::<f64>().unwrap());
    rows.into_iter().map(parsed).unzip()
}

fn list(values: &[f64]) -> String {
    values.iter().map(|value| format!("{value}\n")).collect()
}

fn increments(values: &[f64]) -> Vec<f64> {
    values.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

fn fill_form(
    form: &str,
    lists: &[(Option<Diagonal>, String)],
    counting: Counting,
    column: &str,
) -> Result<String, String> {
    let (path, name, sha256) = ("list.txt", "list.txt", "0");
    let file = |text| Measurement { path, name, sha256, bytes: str::as_bytes(text) };
    let lists: Vec<List<'_>> = lists.iter().map(|(of, text)| (*of, file(text))).collect();
    let columns = Some(format!("#1={column}"));
    let stated = ImportFacts { columns, captures: Some(counting), ..ImportFacts::default() };
    fill(&source("form.csv", form), &lists, &stated).map_err(|problems| problems.render())
}

/// What comes of lists of all diagonals, the first one being `own`.
fn filled(own: &[f64], counting: Counting, column: &str) -> Result<String, String> {
    let mut form = "diagonal,run,direction,node,moved,deviation_um\n".to_string();
    let lists = Diagonal::ALL.into_iter().zip(DIAGONALS).map(|(diagonal, name)| {
        let (cells, values) = case_d(name);
        form.extend(cells.iter().map(|cells| format!("{cells},\n")));
        let text = match (name, counting) {
            ("PPP", _) => list(own),
            (_, Counting::Cumulative) => list(&values),
            (_, Counting::Incremental) => list(&increments(&values)),
        };
        (Some(diagonal), text)
    });
    let lists: Vec<_> = lists.collect();
    fill_form(&form, &lists, counting, column)
}

fn without(values: &[f64], place: usize) -> Vec<f64> {
    let mut values = values.to_vec();
    values.remove(place);
    values
}

#[test]
fn as_many_values_as_captures_fill_the_form() {
    let (cells, values) = case_d("PPP");
    // The first capture of case D is not zero; increments count from it.
    for (counting, own, zero) in [
        (Counting::Cumulative, values.clone(), 0.0),
        (Counting::Incremental, increments(&values), values[0]),
    ] {
        let text = filled(&own, counting, "deviation_um").unwrap();
        let rows = text.lines().filter(|line| line.starts_with("PPP"));
        for (row, (cells, value)) in rows.zip(cells.iter().zip(&values)) {
            let (before, found) = row.rsplit_once(',').unwrap();
            let found: f64 = found.parse().unwrap();
            assert_eq!(before, cells);
            assert!((found - (value - zero)).abs() < 1e-6, "{row}: {value} - {zero}");
        }
    }
}

fn name(cells: &str) -> String {
    let cells: Vec<&str> = cells.split(',').collect();
    let moved = if cells[4].is_empty() { String::new() } else { format!(", moved {}", cells[4]) };
    format!("run {}, direction {}, node {}{moved}", cells[1], cells[2], cells[3])
}

/// Deviations alone, without the steps, are the hard case: what shows is that the runs no longer repeat.
#[test]
fn among_deviations_the_missing_capture_lies_where_it_is_said_to() {
    let (cells, values) = case_d("PPP");
    let (mut told, mut narrow) = (0, 0);
    for place in (0..values.len()).step_by(3) {
        let own = without(&values, place);
        let said = filled(&own, Counting::Cumulative, "deviation_um").unwrap_err();
        assert!(said.contains("holds 185 values, expected 186 with `--captures c"), "{said}");
        let is_named = |at: &usize| said.contains(&name(&cells[*at]));
        let named: Vec<usize> = (0..cells.len()).filter(is_named).collect();
        let (Some(first), Some(last)) = (named.first(), named.last()) else {
            assert!(said.contains("fit about equally"), "{said}");
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
    let (cells, values) = case_d("PPP");
    let node = |cells: &String| cells.split(',').nth(3).unwrap().parse::<usize>().unwrap();
    // Projections of steps of 90, 72 and 72 mm on the diagonal of the box.
    let (steps, length) = ([90.0, 72.0, 72.0_f64], 900.0_f64.hypot(720.0).hypot(720.0));
    let way = |step: usize| steps[step % 3] * steps[step % 3] * 10.0 / length;
    let nominal = |cells: &String| (0..node(cells)).map(way).sum::<f64>();
    let whole = cells.iter().zip(&values).map(|(cells, um)| nominal(cells) + um / 1000.0);
    let whole: Vec<f64> = whole.collect();
    for place in (0..whole.len()).step_by(3) {
        let filled = |own: &[f64]| filled(own, Counting::Cumulative, "displacement_mm");
        let said = filled(&without(&whole, place)).unwrap_err();
        assert!(said.contains(&name(&cells[place])), "{place}: {said}");
        let mut values = whole.clone();
        values.insert(place, whole[place] + 0.000_1);
        let said = filled(&values).unwrap_err();
        let named = |value: usize| said.contains(&format!("value {value}"));
        let named = named(place + 1) || named(place + 2);
        assert!(named && said.contains("more than 10⁹ : 1"), "{place}: {said}");
    }
}

/// What lists do not carry has to be stated: fixtures/cases/refuses/import-form.txt.
#[test]
fn lists_of_all_diagonals_fill_a_form() {
    let visit = Visit::new();
    visit.yes("new --controller generic --travel 400,300,200 --readings -o visit");
    let form = visit.read("visit/readings.csv");
    for name in DIAGONALS {
        let count = form.lines().filter(|line| line.starts_with(name)).count();
        let values: String = (0..count).map(|k| format!("{k},5\n")).collect();
        visit.put(&format!("{name}.txt"), format!("Reading\n{values}"));
    }
    let lists = "--ppp PPP.txt --npp NPP.txt --pnp PNP.txt --ppn PPN.txt";
    let named = "--columns Reading=displacement_mm --captures cumulative --decimal comma";
    let form = "--form visit/readings.csv -o visit/readings.csv --force";
    let ran = visit.run(&format!("import {form} {lists} {named}")).ends(0);
    ran.says("every capture of the form has its value");
}

#[test]
fn a_list_of_a_real_axis_misses_the_capture_that_was_taken_out() {
    let Some(path) = shared("iso230-2/iso230_2_ess_b02_x.csv") else { return };
    let table = read_to_string(path).unwrap();
    let rows = table.lines().filter(|line| !line.starts_with(['#', 'i']));
    let rows: Vec<Vec<f64>> =
        rows.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    let mut form = "target_mm,run,direction,deviation_um\n".to_string();
    let (mut names, mut whole) = (Vec::new(), Vec::new());
    for run in 1..=5 {
        let up = rows.iter().map(|row| (row[1], "+", row[1 + run]));
        let down = rows.iter().rev().map(|row| (row[1], "-", row[6 + run]));
        for (target, direction, at) in up.chain(down) {
            form += &format!("{target},{run},{direction},\n");
            names.push(format!("target_mm {target}, run {run}, direction {direction}"));
            whole.push(at - rows[0][1]);
        }
    }
    let filled = |values: &[f64]| {
        fill_form(&form, &[(None, list(values))], Counting::Cumulative, "displacement_mm")
    };
    let text = filled(&whole).unwrap();
    let first: f64 = text.lines().last().unwrap().rsplit(',').next().unwrap().parse().unwrap();
    assert!((first - (rows[0][11] - rows[0][1]) * 1000.0).abs() < 1e-6, "{first}");
    for (place, name) in names.iter().enumerate() {
        let said = filled(&without(&whole, place)).unwrap_err();
        assert!(said.contains(name), "{name}: {said}");
    }
}

#[test]
fn a_sheet_of_a_workbook_is_mapped_like_a_text() {
    let visit = Visit::new();
    visit.copy("formats/workbook_selfmade.xlsx", "book.xlsx");
    let import = |more: &str| {
        let stated = "--axis x --direction both --sign as-error -o -";
        let columns = "--columns #1=position_mm,Dev[um]=ex_um";
        visit.run(&format!("import book.xlsx {stated} {columns} {more}"))
    };
    // The first sheet holds no table.
    import("").ends(2);
    import("--sheet Other").ends(2).says("its sheets: Notes, Readings");
    let table = import("--sheet Readings").ends(0).out;
    let rows: Vec<&str> = table.lines().filter(|line| !line.starts_with('#')).collect();
    assert_eq!(rows, ["axis,position_mm,ex_um", "x,0,0", "x,100,1.25", "x,200,-0.5"]);
}
