//! What LinuxCNC does with these texts, as it was seen doing it (docs/linuxcnc.md §2).
use super::{Contents, read};
use crate::control::controller::{ControlUnit, Dialect, LinuxcncFacts, builtin};
use crate::control::table::Point;
use crate::read::findings::ReadFinding;
use crate::text::Finding;

mod control;

fn facts() -> LinuxcncFacts {
    match builtin::profile("linuxcnc").unwrap().dialect {
        Dialect::Linuxcnc(facts) => facts,
        _ => unreachable!("it is LinuxCNC"),
    }
}

const INI: &str = "[JOINT_0]\nCOMP_FILE = x.comp\nCOMP_FILE_TYPE = 1\n";

fn found(texts: &[(&str, &str)]) -> Contents {
    read(texts, &facts()).unwrap_or_else(|p| panic!("{}", p.render()))
}

fn refused(texts: &[(&str, &str)]) -> String {
    read(texts, &facts()).expect_err("it is refused").render()
}

fn rows(comp: &str) -> Vec<(f64, f64, f64)> {
    let found = found(&[("m.ini", INI), ("x.comp", comp)]);
    let row = |row: &Point| (row.position, row.forward, row.reverse.unwrap());
    found.tables.tables[0].points.iter().map(row).collect()
}

#[test]
fn what_stands_behind_three_numbers_and_tabs_and_line_ends_do_not_matter() {
    let both = vec![(0.0, 0.1, 0.1), (100.0, 0.3, 0.3)];
    assert_eq!(rows("0 0.1 0.1 ; note\r\n100\t0.3 0.3 7 8 9\r\n"), both);
    assert_eq!(rows(" 0 .1 1e-1\n+1.e2 0.3 30.0E-02x"), both);
    assert_eq!(rows("0 0.1 0.1\n100 0.3 0.3\n\n# end\n"), both);
    assert_eq!(rows("-0.000 -0.0 0\n"), [(0.0, 0.0, 0.0)]);
}

/// LinuxCNC goes on without these rows, and says so of the last two only.
#[test]
fn a_table_that_loses_rows_is_refused_at_the_place() {
    let long = format!("0 0 0 {}\n100 1 1\n", "x".repeat(248));
    let many: String = (0..257).map(|k| format!("{k} 0 0\n")).collect();
    for (comp, place, words) in [
        ("# nominal\n0 0 0\n1 0 0\n", "x.comp:1:1", "stops reading here"),
        ("0 0 0\n\n1 0 0\n", "x.comp:2:1", "stops reading here"),
        ("0 0 0\n1 0\n2 0 0\n", "x.comp:2:1", "stops reading here"),
        ("0 0 0\n5 1 nan\n9 1 1\n", "x.comp:2:1", "stops reading here"),
        ("", "x.comp:1:1", "no row begins the file"),
        ("nominal forward reverse\n", "x.comp:1:1", "no row begins the file"),
        ("0 0 0\n100 0 0\n50 9 9\n", "x.comp:3:1", "does not lie above 100"),
        ("0 0 0\n0 0 0\n", "x.comp:2:1", "does not lie above 0"),
        ("0 0 0\n1 1e999 0\n", "x.comp:2:1", "beyond every machine"),
        (&long, "x.comp:1:1", "a line of 254 characters"),
        (&many, "x.comp:257:1", "behind the 256"),
    ] {
        let said = refused(&[("m.ini", INI), ("x.comp", comp)]);
        assert!(said.contains(place) && said.contains(words), "{comp}\n{said}");
    }
}

#[test]
fn without_a_type_the_columns_hold_positions() {
    let ini = INI.replace("COMP_FILE_TYPE = 1\n", "");
    let found = found(&[("m.ini", &ini), ("x.comp", "10 10.25 9.5\n")]);
    let trims = Point { position: 10.0, forward: -0.25, reverse: Some(0.5) };
    assert_eq!(found.tables.tables[0].points, [trims]);
}

#[test]
fn of_two_settings_the_first_counts_and_comments_begin_a_line() {
    let ini = "[TRAJ]\nLINEAR_UNITS=inch\n[JOINT_2]\n# BACKLASH = 9\n ; HOME_OFFSET = 3\n\
               \tBACKLASH\t=  0.25  \nBACKLASH = 7\ncomp_file = y\nMIN_LIMIT = 0 ; low\n";
    let found = found(&[("m.ini", ini)]);
    assert_eq!(found.unit, Some(ControlUnit::Inch));
    let joint = &found.joints[&2];
    assert_eq!((joint.backlash, joint.home_offset), (Some(0.25), None));
    assert_eq!(joint.comp_file, None);
    assert!(found.tables.tables.is_empty());
}

#[test]
fn an_ini_that_linuxcnc_takes_otherwise_is_refused() {
    for (ini, words) in [
        ("[JOINT_0]\nA = 1\n[EMC]\n[JOINT_0]\nCOMP_FILE = x.comp\n", "m.ini:5:1"),
        ("[JOINT_0]\n#INCLUDE joints.ini\n", "includes another file"),
        ("[JOINT_0]\nCOMP_FILE = x.comp\nCOMP_FILE_TYPE = 2\n", "expected 0 (positions reached)"),
        ("[JOINT_0]\nCOMP_FILE_TYPE = 1 # trims\n", "expected 0 (positions reached)"),
        ("[JOINT_0]\nBACKLASH = nan\n", "expected a number"),
        ("[JOINT_16]\nBACKLASH = 0\n", "from [JOINT_0] to [JOINT_15]"),
        ("[TRAJ]\nLINEAR_UNITS = cm\n", "expected mm or inch"),
        ("[JOINT_0]\nCOMP_FILE = x.comp # X\n", "names `x.comp # X`, which is not there"),
        ("[JOINT_0]\nCOMP_FILE = X.comp\n", "names `X.comp`, which is not there"),
    ] {
        let said = refused(&[("m.ini", ini), ("x.comp", "0 0 0\n")]);
        assert!(said.contains(words), "{ini}\n{said}");
    }
}

#[test]
fn a_table_without_its_ini_says_nothing() {
    let said = refused(&[("x.comp", "0 0 0\n")]);
    let words = "no ini file stands beside `x.comp`: a table says neither its joint nor its type nor its unit";
    assert!(said.contains(words), "{said}");
}

#[test]
fn the_ini_of_the_machine_counts_alone() {
    let machine = "[EMC]\n[JOINT_0]\nHOME_OFFSET = 5\nCOMP_FILE = comp/x.comp\n";
    let table = ("at/x.comp", "0 0 0\n");
    let other = ("y.comp", "0 0 0\n");
    let lines = ("joints.ini", INI);
    let found = found(&[("m.ini", machine), lines, table, other]);
    assert_eq!(found.joints[&0].home_offset, Some(5.0));
    assert_eq!(found.tables.tables[0].output, "0");
    let idle =
        ["joints.ini", "y.comp"].map(|file| ReadFinding::NotNamed { file: file.to_string() });
    assert_eq!(found.notes, idle.map(Finding::from));
    for second in [("n.ini", machine), ("n.ini", INI)] {
        let first = if second.1 == INI { INI } else { machine };
        let said = refused(&[("m.ini", first), second, table, ("x.comp", "0 0 0\n")]);
        assert!(said.contains("several ini files"), "{said}");
    }
}
