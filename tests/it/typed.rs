//! Tables that a person types in: the printed sheet, the list beside it, and what was read back from the screen.
use crate::support::run::ended;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// Five points an axis with 1 µm as the smallest step, typed as `value` in `unit`.
fn visit(value: &str, unit: &str, spacing: &str) -> TempDir {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/machines/five_points");
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    fs::copy(folder.join("errors.csv"), at("errors.csv")).unwrap();
    let job = fs::read_to_string(folder.join("generic.toml")).unwrap();
    let job = job
        .replace("\"generic\"", "\"own.toml\"")
        .replace("spacing_mm = 100.0", &format!("{spacing}\ndetection_unit_um = 1.0"));
    fs::write(at("job.toml"), job).unwrap();
    let fact = |name: &str, value: &str| {
        format!("[facts.{name}]\nvalue = \"{value}\"\nevidence = \"manual\"\nsource = \"test\"\n")
    };
    let own = "schema = 1\nid = \"own\"\nname = \"<b>Own\"\nbased_on = \"generic\"\n";
    let facts = [fact("typed_value", value), fact("typed_unit", unit)].concat();
    fs::write(at("own.toml"), format!("{own}{facts}")).unwrap();
    let (status, _, talk) = ended(place.path(), "generate job.toml -q -o kit");
    assert_eq!(status, Some(0), "{talk}");
    fs::create_dir(at("seen")).unwrap();
    place
}

fn list(visit: &TempDir) -> String {
    fs::read_to_string(visit.path().join("kit/typed.csv")).unwrap()
}

/// What `verify` says of a list alone.
fn judged(visit: &TempDir, list: &str) -> (Option<i32>, String) {
    fs::write(visit.path().join("seen/screen.csv"), list).unwrap();
    let (status, page, talk) = ended(visit.path(), "verify job.toml --tables seen -v");
    (status, page + &talk)
}

/// The list with every value seen as it was to be typed, and every sum.
fn all_seen(list: &str) -> String {
    let (header, rows) = list.split_once('\n').unwrap();
    let filled = rows.lines().map(|row| {
        let cells: Vec<&str> = row.split(',').collect();
        format!("{row}{}\n", cells[8])
    });
    format!("{header}\n{}", filled.collect::<String>())
}

#[test]
fn every_sense_and_unit_reads_back_to_the_same_tables() {
    for (value, of_y) in [
        ("deviation", ["4", "2", "0", "-3", "-6", "-3"]),
        ("correction", ["-4", "-2", "0", "3", "6", "3"]),
        ("increment", ["0", "2", "2", "3", "3", "10"]),
    ] {
        for unit in ["um", "mm"] {
            let visit = visit(value, unit, "spacing_mm = 100.0");
            let list = list(&visit);
            let is_y = |row: &&str| row.starts_with("EYY,y,y,,");
            let found: Vec<f64> = list
                .lines()
                .filter(is_y)
                .map(|row| row.split(',').nth(8).unwrap().parse().unwrap())
                .collect();
            let scale = if unit == "mm" { 1000.0 } else { 1.0 };
            let expected = of_y.map(|text| text.parse::<f64>().unwrap() / scale);
            assert_eq!(found, expected, "{value} {unit}: EYY at -200 … 200 mm, sum");
            let (status, page) = judged(&visit, &all_seen(&list));
            assert_eq!(status, Some(0), "{value} {unit}\n{page}");
            let (status, told) = judged(&visit, &list);
            assert_eq!(status, Some(2), "nobody looked at the screen\n{told}");
            assert!(told.contains("`seen` is empty in"), "{told}");
        }
    }
}

#[test]
fn the_sheet_shows_what_the_list_holds_and_obeys_nothing() {
    let visit = visit("correction", "um", "spacing_mm = 10.0");
    let sheet = fs::read_to_string(visit.path().join("kit/tables.html")).unwrap();
    let mut rest = sheet.as_str();
    let (mut points, mut pages) = (0, 0);
    for row in list(&visit).lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        let [page, point, position, value] = [5, 6, 7, 8].map(|column| cells[column]);
        let shown = match point {
            "sum" => format!("Sum of page {page}</td><td>{value}</td>"),
            _ => format!("<tr><td>{point}</td><td>{position}</td><td>{value}</td><td></td>"),
        };
        let (_, after) = rest.split_once(&shown).unwrap_or_else(|| panic!("{row}\n{sheet}"));
        rest = after;
        points += usize::from(point != "sum");
        pages += usize::from(point == "sum");
    }
    // X has tables for both directions of EXX and EYX
    assert_eq!((points, pages), (11 * 41, 11 * 2), "41 points are two pages");
    assert!(!sheet.contains("<b>") && sheet.contains("&lt;b&gt;Own"), "{sheet}");
}

#[test]
fn a_mistyped_value_is_named_with_its_place() {
    for value in ["correction", "increment"] {
        let visit = visit(value, "um", "spacing_mm = 100.0");
        let seen = all_seen(&list(&visit));
        let is_row = |point: &str, row: &str| {
            let cells: Vec<&str> = row.split(',').collect();
            cells[0] == "EYY" && cells[6] == point
        };
        let row = seen.lines().find(|row| is_row("3", row)).unwrap();
        let sum = seen.lines().find(|row| is_row("sum", row)).unwrap();
        let other = format!("{}8", row.strip_suffix('3').unwrap());
        // the sum of what was seen is that of the sheet: the list contradicts itself
        let mistyped = seen.replace(row, &other);
        let (status, words) = judged(&visit, &mistyped);
        assert_eq!(status, Some(2), "{words}");
        assert!(words.contains("`seen` adds up to"), "{words}");
        let line = 1 + mistyped.lines().position(|line| line == other).unwrap();
        let place = format!("`seen` differs from the value in line {line}\n");
        assert!(words.contains(&place), "{words}");
        // without a sum the value is taken as the control's, and differs from the job
        let (unsummed, _) = sum.rsplit_once(',').unwrap();
        let (status, words) = judged(&visit, &mistyped.replace(sum, &format!("{unsummed},")));
        assert_eq!(status, Some(1), "{words}");
        assert!(words.contains("EYY (y while y moves)"), "{words}");
        assert!(words.contains(" 100.0000 mm"), "{words}");
    }
}

#[test]
fn a_list_that_is_not_whole_is_refused_at_its_place() {
    let visit = visit("increment", "um", "spacing_mm = 100.0");
    let list = list(&visit);
    let seen = all_seen(&list);
    let first = list.lines().nth(2).unwrap();
    let cut: String = list.lines().take(4).map(|row| format!("{row}\n")).collect();
    for (changed, words) in [
        (
            seen.replace(&format!("{first}{}", first.split(',').nth(8).unwrap()), first),
            "`seen` is empty in 1 of",
        ),
        (cut, "page `1` has no sum"),
        (list.replace("increment_um", "increment"), "column `increment` is unknown"),
        (list.replace(",increment_um", ",increment_um,correction_um"), "expected one"),
        (list.replace("EXX,x,x,,0,", "EXX,x,x,,50,"), "no point of this table lies at `zero_mm`"),
        (list.replace(",1,sum,", ",1,total,"), "`point` is `total`"),
        (
            list.replacen("0,1,0,0,0,", "0,1,0,0,5,", 1).replacen("sum,,-8,", "sum,,-3,", 1),
            "has an increment, expected 0",
        ),
    ] {
        assert_ne!(changed, list, "{words}");
        let (status, told) = judged(&visit, &changed);
        assert_eq!(status, Some(2), "{words}\n{told}");
        assert!(told.contains(words) && told.contains("screen.csv:"), "{words}\n{told}");
    }
}

#[test]
fn a_spreadsheet_may_write_semicolons_and_decimal_commas() {
    let visit = visit("correction", "mm", "spacing_mm = 100.0");
    let list = all_seen(&list(&visit)).replace(',', ";").replace('.', ",");
    let (status, page) = judged(&visit, &list);
    assert_eq!(status, Some(0), "{page}");
}

#[test]
fn nobody_types_nine_decimals() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/machines/five_points");
    let place = tempfile::tempdir().unwrap();
    let kit = place.path().join("kit");
    let job = folder.join("generic.toml");
    let command = format!("generate {} -q -o {}", job.display(), kit.display());
    let (status, _, talk) = ended(place.path(), &command);
    assert_eq!(status, Some(0), "{talk}");
    assert!(!kit.join("tables.html").exists() && !kit.join("typed.csv").exists());
}
