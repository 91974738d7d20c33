use super::read;
use crate::control::table::isg::{IsgTables, Parameter};
use crate::quantity::Axis;

/// As the maker's page prints it (TF5280, Updating the Volumetric Compensation), with a chain.
const LIST: &str = "workpiece_axes           0\r\nX                        1\r\nY                        2\r\n\
    Z                        3\r\nInterpolation            GRID\r\nenable_splicing          FALSE\r\n\
    filter_steps             20\r\nmanual_activation        FALSE\r\nalternative_model        FALSE\r\n\
    associate_to_channel     FALSE\r\nchain YXZ # a remark\r\nfile[0]                  C:\\vc\\volcomp1.csv\r\n\
    file_format[0]           ISG_CSV\r\n";
/// As the page ISG CSV format prints it, with a second row.
const CSV: &str = "// The header contains the argument \"X\" and component errors.\n\
    X      EXX    EYX    EZX    EAX    EBX    ECX\n0.0 0.02 0.01 0.07 0.00 0.0042 0.003\n\
    10.0\t0.00 -0.1 0.01 0.00 0.0011 0.002 // the end\n#\nC0Y B0Z A0Z N0Z\n0.0000223 0 0 0\n";

fn tables(list: &str, name: &str, text: &str) -> Result<IsgTables, String> {
    let read = read(&[("v.lis", list), (name, text)]);
    read.map(|(tables, _)| tables).map_err(|problems| problems.render())
}

fn points(tables: &IsgTables, name: &str) -> Vec<(f64, f64)> {
    let parameter = Parameter::all().find(|own| own.to_string() == name);
    let curve = parameter.and_then(|parameter| tables.curve(parameter));
    let points = curve.into_iter().flat_map(|curve| &curve.points);
    points.map(|point| (point.position, point.value)).collect()
}

#[test]
fn the_printed_examples_are_read() {
    let read = tables(LIST, "volcomp1.csv", CSV).unwrap();
    assert_eq!(read.chain, [Axis::Y, Axis::X, Axis::Z]);
    assert_eq!((read.axes.x, read.axes.z), (Some(1), Some(3)));
    assert_eq!(points(&read, "EYX"), [(0.0, 0.01), (10.0, -0.1)]);
    assert_eq!(points(&read, "EBX"), [(0.0, 0.0042), (10.0, 0.0011)]);
    assert_eq!(points(&read, "C0Y"), [(0.0, 0.000_022_3)]);
}

/// What the emulator does not do, and what no control can mean, is told at its place.
#[test]
fn what_is_not_emulated_is_refused_at_its_place() {
    let list = |from: &str, to: &str| tables(&LIST.replace(from, to), "volcomp1.csv", CSV);
    for (from, to, words) in [
        ("workpiece_axes           0", "workpiece_axes 1", "v.lis:1:1"),
        ("GRID", "SCATTER", "v.lis:5:1"),
        ("alternative_model        FALSE", "alternative_model 1", "is `1`, expected 0"),
        ("chain YXZ", "chain CYXZ", "each of X, Y, Z once"),
        ("Z                        3", "Z 3\nC 7", "no rotary axis"),
        ("X                        1", "", "does not say the logical axis number of X"),
        ("file_format[0]           ISG_CSV", "", "does not say file_format[0]"),
        ("ISG_CSV", "ETALON_EXCHANGE", "v.lis:13:1"),
        ("filter_steps", "filter_step", "a key of this list"),
        ("chain YXZ", "X 4", "each key once"),
        ("volcomp1.csv", "other.csv", "which is not there"),
        ("file[0]", "file[10]", "a key of this list"),
    ] {
        let told = list(from, to).unwrap_err();
        assert!(told.contains(words), "{to}: {told}");
    }
    for (from, to, words) in [
        ("10.0\t0.00", "0.0 0.00", "does not lie above 0"),
        ("10.0\t0.00", "10.0", "6 numbers, expected 7"),
        ("X      EXX", "Z X EXX", "position of its own axis"),
        ("X      EXX", "X EXY", "position of its own axis"),
        ("-0.1", "-0,1", "volcomp1.csv:4:"),
        ("0.003\n", "1e9\n", "no number that a machine can mean"),
        ("0 0 0\n", "0 0 -1\n", "N0Z is -1: this parameter is not emulated"),
        ("#\n", "#\nX EZX\n0 1\n1 1\n#\n", "EZX stands twice"),
        ("0.0000223 0 0 0\n", "", "a header without a row"),
        ("C0Y B0Z", "C0Y squareness", "`squareness` is neither"),
    ] {
        let told = tables(LIST, "volcomp1.csv", &CSV.replace(from, to)).unwrap_err();
        assert!(told.contains(words), "{to}: {told}");
    }
}

/// A list is needed, one; files that it does not name do nothing.
#[test]
fn files_are_those_of_one_list() {
    let told = |texts: &[(&str, &str)]| read(texts).unwrap_err().render();
    assert!(told(&[("a.csv", CSV)]).contains("no list stands beside `a.csv`"));
    assert!(told(&[("a.lis", LIST), ("b.lis", LIST)]).contains("several lists"));
    let (_, notes) = read(&[("a.lis", LIST), ("volcomp1.csv", CSV), ("b.csv", CSV)]).unwrap();
    assert_eq!(notes.len(), 1);
    assert_eq!(notes[0].to_string(), "`b.csv`: the list does not name it, so it does nothing");
}
