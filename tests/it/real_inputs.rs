//! Files of other people's instruments and CAM systems, read where they lie: what is understood, what refused and why.
use crate::support::words as said_of;
use crate::support::{Visit, holds, shared};
use nonius::control::controller::TableSign;
use nonius::inputs::import::stated::{ImportFacts, MaterialCorrected};
use nonius::inputs::import::{Component, Imported};
use nonius::quantity::{Axis, Direction};
use nonius::text::{Problems, Severity, of_severity};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The names and paths of the files of a folder; `None` where the data are not there.
fn files(folder: &str) -> Option<BTreeMap<String, PathBuf>> {
    let entries = fs::read_dir(shared(&format!("real/{folder}"))?).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let named = paths.map(|path| (path.file_name().unwrap().to_str().unwrap().to_string(), path));
    Some(named.filter(|(name, _)| !name.ends_with(".tsv")).collect())
}

/// What a person has to state for each of the four.
fn stated(name: &str) -> ImportFacts {
    let (term, axis, run) = match name {
        // The operator left `TestAxis: (X)` as it was.
        name if name.contains("8055_Y") => ("EYY", Some(Axis::Y), Direction::Minus),
        // Of the 8065 one position of the averages was added by hand, one taken away: they are not read.
        name if name.contains("_X_") => ("EXX", None, Direction::Plus),
        // Its rows were edited and contradict themselves.
        _ => ("EXX", None, Direction::Minus),
    };
    ImportFacts {
        term: Component::from_name(term),
        axis,
        first_target_at_mm: Some(0.0),
        targets_run: Some(run),
        sign: Some(TableSign::AsError),
        material_corrected: Some(MaterialCorrected::NotStated),
        ..ImportFacts::default()
    }
}

fn imported(path: &Path, stated: &ImportFacts) -> Result<Imported, Problems> {
    crate::import::run("file.pos", fs::read(path).unwrap(), stated, None)
}

/// What was understood, without what the file holds: counts, range, unit, way, surroundings.
fn understood(imported: &Imported) -> String {
    let mut words = String::new();
    for series in &imported.draft.series {
        let (first, last) = (series.positions[0].mm(), series.positions.last().unwrap().mm());
        let way = series.direction.map_or("both", Direction::symbol);
        let count = series.positions.len();
        words += &format!("{} {way}: {count} points, {first} … {last} mm\n", series.axis);
    }
    let told = ["unit", "values:", "runs:", "not measured"];
    let facts = said_of(&of_severity(&imported.findings, Severity::Label)).into_iter();
    let facts = facts.filter(|fact| told.iter().any(|told| fact.starts_with(told)));
    words.extend(facts.map(|fact| fact + "\n"));
    for warning in said_of(&of_severity(&imported.findings, Severity::Note)) {
        words += &format!("warning: {}\n", warning.split([':', '(']).next().unwrap());
    }
    words
}

#[test]
fn laser_exports_are_read_as_they_are_and_nothing_is_guessed() {
    let Some(files) = files("api") else { return };
    let mut words = String::new();
    for (name, path) in &files {
        let refused = |p: Problems| p.to_string().lines().take(1).collect::<String>() + "\n";
        let said = imported(path, &stated(name)).map_or_else(refused, |own| understood(&own));
        words += &format!("{name}\n{said}\n");
        let nothing = imported(path, &ImportFacts::default()).unwrap_err().to_string();
        holds(&nothing, &["--term", "--sign", "--material-corrected"]);
        let turned = ImportFacts { sign: Some(TableSign::AsCorrection), ..stated(name) };
        assert!(imported(path, &turned).is_err(), "{name}");
    }
    insta::assert_snapshot!("laser_exports_are_read_as_they_are", words);
}

/// A machine with so much travel that no program leaves it.
fn machine() -> Visit {
    let axes = ["x", "y", "z"].map(|axis| {
        format!("[machine.axes.{axis}]\ntravel_mm = [-9000.0, 9000.0]\nreference_mm = 0.0\n")
    });
    let offsets = ["G54", "G55", "G56"].map(|name| {
        format!("[[path.offset]]\nsystem = \"{name}\"\nx_mm = 0.0\ny_mm = 0.0\nz_mm = 0.0\n")
    });
    let tool = |number| format!("[[path.tool]]\nnumber = {number}\nlength_mm = 100.0\n");
    let mut job = "schema = 1\n[machine]\nname = \"M\"\n".to_string() + &axes.concat();
    job += "[measurement]\nerrors = \"errors.csv\"\nactive_while_measuring = \"none\"\n[path]\n";
    job += &offsets.concat();
    job.extend((1..=20).map(tool));
    let errors = "axis,position_mm,ex_um,ey_um,ez_um\nx,-9000,-90,0,0\nx,9000,90,0,0\n\
                  y,-9000,0,-90,0\ny,9000,0,90,0\nz,-9000,0,0,-90\nz,9000,0,0,90\n";
    Visit::with(job, errors)
}

fn kind(said: &str) -> &'static str {
    let kinds = [
        ("turning programs", "turning"),
        ("is a variable of the control", "variable of the control"),
        ("has no value", "variable that is not set"),
        ("write G90.1 before", "absolute centres"),
        ("the end of the arc lies", "arc misses its circle"),
        ("the language of another control", "language of another control"),
        ("text belongs into", "language of another control"),
        ("`L` belongs to no word", "Siemens language"),
    ];
    kinds.iter().find(|(words, _)| said.contains(words)).map_or("other", |(_, kind)| kind)
}

fn outcome(visit: &Visit, program: &Path) -> String {
    let program = fs::canonicalize(program).unwrap();
    let ran = visit.run(&format!("path job.toml --format json \"{}\"", program.display()));
    match ran.status {
        Some(2) => format!("refused: {}", kind(&ran.err)),
        _ => {
            assert!(ran.ends(0).json().is_object());
            "ran".to_string()
        }
    }
}

#[test]
fn part_programs_of_others_run_or_are_refused_for_their_reason() {
    let Some(files) = files("gcode") else { return };
    let visit = machine();
    let outcomes = files.iter().map(|(name, path)| format!("{name}: {}", outcome(&visit, path)));
    let list: Vec<String> = outcomes.collect();
    insta::assert_snapshot!(list.join("\n"));
}
