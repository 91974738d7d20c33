//! Files of real controls, read where they lie, nothing copied: told in counts, ranges and largest values.
use crate::support::{error_rows, holds, inputs, job_of, response, shared, shown, um_at};
use nonius::control::controller::Role;
use nonius::control::table::Tables;
use nonius::control::table::siemens::SiemensGrid;
use nonius::judge::active::{ActiveControl, ReadOutFor, from_read_out};
use nonius::kit::{self, Inputs, emulator};
use nonius::quantity::Direction;
use nonius::read::emulate::Emulator;
use nonius::text::{Problems, Severity, of_severity};

type Files = Vec<(String, Vec<u8>)>;

/// Files of a folder; `None`, told in one line, where they do not lie beside the repository.
fn real(folder: &str, names: &[&str]) -> Option<Files> {
    let folder = shared(&format!("real/{folder}"))?;
    let read = |name: &&str| (name.to_string(), std::fs::read(folder.join(name)).unwrap());
    Some(names.iter().map(read).collect())
}

/// A job for three axes, measured with `active`; `axis` = lines of `[compensation.axes]`.
fn job(control: &str, active: &str, travel: [[f64; 2]; 3], axis: fn(usize) -> String) -> Inputs {
    let ends = [0, 1, 2].map(|index| (["x", "y", "z"][index], travel[index].to_vec()));
    let um = |_: &str, _: &str, mm: f64| [mm, -mm, mm / 2.0].map(|mm| mm / 100.0);
    let errors = error_rows("ex_um,ey_um,ez_um", &ends, &[""], um);
    let axes = (0..3).map(|index| (["x", "y", "z"][index], travel[index], 0.0, axis(index)));
    let measurement = format!("active_while_measuring = \"{active}\"");
    let compensation = format!("controller = \"{control}\"\nbacklash = \"mean\"");
    inputs(&job_of(&measurement, &compensation, axes), &errors)
}

/// A five-axis machine: three linear axes on the second measuring system.
fn siemens(active: &str) -> Inputs {
    job("siemens-840d-sl", active, [[0.0, 950.0], [-850.0, 0.0], [-650.0, 0.0]], |index| {
        format!("spacing_mm = 50\nid = \"AX{}\"\nmeasuring_system = 2", index + 1)
    })
}

fn fanuc(active: &str) -> Inputs {
    job("fanuc-0i-f", active, [[-1000.0, 0.0], [-1100.0, 0.0], [-770.0, 30.0]], |index| {
        let spacing = [40.0, 27.5, 27.5][index];
        format!("spacing_mm = {spacing}\nid = \"{}\"\ndetection_unit_um = 0.1", index + 1)
    })
}

fn read(job: &Inputs, files: Files, purpose: ReadOutFor) -> Result<ActiveControl, Problems> {
    from_read_out(&job.job, &job.profile, "files", files, purpose)
}

/// What was active, and what a kit on top of it is judged to leave.
fn understood(job: fn(&str) -> Inputs, files: Files) -> String {
    let with = job("files");
    let active = shown(read(&with, files.clone(), ReadOutFor::OldTables));
    let mut said = told(&active);
    let control = emulator(&with.profile, &active.tables, &active.state).unwrap();
    said += &corrections(control.as_ref(), &with);
    for assumption in &active.assumptions {
        said += &format!("assumed: {} = {}\n", assumption.fact, assumption.value);
    }
    let made = shown(kit::generate(&shown(with.with_active(active))));
    let back = made.files.iter().filter(|f| f.role == Role::Rollback).count();
    said += &format!("kit: {} with {back} rollback files\n", made.verdict.word());
    let judging = job("none");
    let found = shown(read(&judging, files, ReadOutFor::Judging));
    let judged = shown(kit::verify_read_out(&judging, &found));
    let causes = judged.disagreements().len();
    let doubts = of_severity(&judged.findings, Severity::Doubt).len();
    said + &format!("verify: {causes} causes, {doubts} doubts\n")
}

fn told(active: &ActiveControl) -> String {
    let notes = of_severity(&active.findings, Severity::Note).len();
    let mut said = format!("{notes} notes, CEC tables of others {:?}\n", active.others.cec_tables);
    let range = |grid: SiemensGrid, values: usize| {
        format!("{values} points, {} to {} by {}", grid.min, grid.max, grid.step)
    };
    match &active.tables {
        Tables::Siemens(tables) => {
            for table in &tables.tables {
                let (from, to) = (&table.input_axis, &table.output_axis);
                let range = range(table.grid, table.values.len());
                said += &match table.place.cec() {
                    None => format!("ENC_COMP[{}]: {range}\n", table.place.index()),
                    Some(number) => format!("CEC {number}: {from} -> {to}, {range}\n"),
                };
            }
        }
        Tables::Fanuc(memory) => {
            let own = memory.parameters.keys().filter(|key| key.number == 3623);
            let axes: Vec<_> = own.filter_map(|key| key.axis).collect();
            said += &format!("{} points, pitch of axes {axes:?}\n", memory.points.len());
            let others = active.others.points.iter().map(|p| (p.first, p.last));
            said += &format!("points of others: {:?}\n", others.collect::<Vec<_>>());
        }
        _ => {}
    }
    said
}

/// The largest correction of each pair of axes that is connected, µm.
fn corrections(control: &dyn Emulator, job: &Inputs) -> String {
    let mut said = String::new();
    for (base, output) in control.connected_axes() {
        let largest = |direction| {
            let way = response(control, &base, &output, direction);
            (-1700..1000).map(|mm| um_at(&way, f64::from(mm)).abs()).fold(0.0, f64::max)
        };
        let um = largest(Direction::Plus).max(largest(Direction::Minus));
        if um > 0.0 {
            said += &format!("{base} -> {output}: corrects up to {um:.1} um\n");
        }
    }
    let own = job.job.compensation.axes.iter().filter(|(_, axis)| axis.is_some()).count();
    said + &format!("{own} axes of the job\n")
}

#[test]
fn a_five_axis_840d_sl_is_understood_from_its_files_and_its_switches_without_tables_are_refused() {
    let Some(files) = real("siemens", &["AX_EEC.INI", "INITIAL.INI", "NC_CEC.INI"]) else { return };
    insta::assert_snapshot!("real-siemens", understood(siemens, files));
    let Some(archive) = real("siemens", &["test.arc"]) else { return };
    let refused = read(&siemens("files"), archive, ReadOutFor::OldTables).unwrap_err().render();
    assert!(refused.contains("export `AX_EEC.INI` (ENC_COMP) and `NC_CEC.INI` (CEC)"), "{refused}");
    let Some(files) = real("siemens", &["INITIAL.INI"]) else { return };
    let refused = read(&siemens("files"), files.clone(), ReadOutFor::OldTables);
    let refused = refused.unwrap_err().render();
    for says in [
        "$MA_ENC_COMP_ENABLE[1,AX1], [1,AX2], [1,AX3] is 1",
        "$SN_CEC_TABLE_ENABLE of CEC tables 0, 1, 2, 3, 4, 5 and 2 more is 1",
        "read out the tables too ($AA_ENC_COMP, `AX_EEC.INI`)",
        "read out the tables too ($AN_CEC, `NC_CEC.INI`)",
    ] {
        assert!(refused.contains(says), "{refused}");
    }
    let found = read(&siemens("none"), files, ReadOutFor::Judging).unwrap();
    let beside = of_severity(&found.findings, Severity::Doubt);
    assert_eq!(beside.len(), 2, "{beside:?}");
}

#[test]
fn each_file_of_tables_is_accepted_as_it_is() {
    for name in ["AX_EEC.INI", "NC_CEC.INI"] {
        println!("{name}");
        let Some(files) = real("siemens", &[name]) else { return };
        let job = siemens("files");
        let active = shown(read(&job, files, ReadOutFor::OldTables));
        let other = if name == "AX_EEC.INI" { "CEC" } else { "ENC_COMP" };
        let is_other = |fact: &str| fact.starts_with(other);
        assert!(active.assumptions.iter().any(|a| is_other(&a.fact)), "{name}");
        shown(kit::generate(&shown(job.with_active(active))));
    }
}

#[test]
fn a_complete_fanuc_backup_is_understood() {
    let Some(files) = real("fanuc", &["HM100TS_CNC-PARA.TXT", "HM100TS_PITCH.TXT"]) else { return };
    let (parameters, points) = (files[..1].to_vec(), files[1..].to_vec());
    insta::assert_snapshot!("real-fanuc", understood(fanuc, files));
    let job = fanuc("files");
    let active = shown(read(&job, parameters, ReadOutFor::OldTables));
    holds(&job.with_active(active).unwrap_err().render(), &["point 1 is missing"]);
    let refused = read(&fanuc("files"), points, ReadOutFor::OldTables).unwrap_err().render();
    assert!(refused.contains("1536 points and no parameter 3620 to 3624"), "{refused}");
    let short = real("fanuc", &["Jir8taiwan_CNC-PARA.TXT"]).unwrap();
    shown(read(&fanuc("files"), short, ReadOutFor::Judging));
}
