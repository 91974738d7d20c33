//! Tables that a person types in: sheet, list, what was read from the screen (refused: cases/refuses/typed.txt).
use crate::support::{Ran, Visit, cells, own_profile, replaced};

/// Five points an axis with 1 µm as the smallest step, typed as `value` in `unit`, with the kit.
fn typed(value: &str, unit: &str, spacing: &str) -> Visit {
    let visit = Visit::with_job("machines/five_points/generic.toml");
    let spacing = format!("{spacing}\ndetection_unit_um = 1.0");
    visit.edit("job.toml", "\"generic\"", "\"own.toml\"");
    visit.edit("job.toml", "spacing_mm = 100.0", &spacing);
    let fact = |name: &str, value: &str| {
        format!("[facts.{name}]\nvalue = \"{value}\"\nevidence = \"manual\"\nsource = \"test\"\n")
    };
    let own = own_profile("generic", &(fact("typed_value", value) + &fact("typed_unit", unit)));
    visit.put("own.toml", replaced(&own, "name = \"own\"", "name = \"<b>Own\""));
    visit.yes("generate job.toml -q -o kit");
    visit
}

fn list(visit: &Visit) -> String {
    visit.read("kit/typed.csv")
}

fn judged(visit: &Visit, list: &str) -> Ran {
    visit.put("seen/screen.csv", list).run("verify job.toml --tables seen -v")
}

/// The list with every value seen as it was to be typed, and every sum.
fn all_seen(list: &str) -> String {
    let (header, rows) = list.split_once('\n').unwrap();
    let filled = rows.lines().map(|row| format!("{row}{}\n", cells(row)[8]));
    format!("{header}\n{}", filled.collect::<String>())
}

#[test]
fn every_sense_and_unit_reads_back_to_the_same_tables() {
    for (value, of_y) in [
        ("deviation", [4.0, 2.0, 0.0, -3.0, -6.0, -3.0]),
        ("correction", [-4.0, -2.0, 0.0, 3.0, 6.0, 3.0]),
        ("increment", [0.0, 2.0, 2.0, 3.0, 3.0, 10.0]),
    ] {
        for (unit, scale) in [("um", 1.0), ("mm", 1000.0)] {
            let visit = typed(value, unit, "spacing_mm = 100.0");
            let list = list(&visit);
            let rows = list.lines().filter(|row| row.starts_with("EYY,y,y,,"));
            let found: Vec<f64> = rows.map(|row| cells(row)[8].parse().unwrap()).collect();
            let expected = of_y.map(|um| um / scale);
            assert_eq!(found, expected, "{value} {unit}: EYY at -200 … 200 mm, sum");
            judged(&visit, &all_seen(&list)).ends(0);
            // As a spreadsheet may write it.
            judged(&visit, &all_seen(&list).replace(',', ";").replace('.', ",")).ends(0);
            // Nobody looked at the screen.
            judged(&visit, &list).ends(2).says("`seen` is empty in");
        }
    }
}

#[test]
fn the_sheet_shows_what_the_list_holds_and_obeys_nothing() {
    let visit = typed("correction", "um", "spacing_mm = 10.0");
    let sheet = visit.read("kit/tables.html");
    let mut rest = sheet.as_str();
    let (mut points, mut pages) = (0, 0);
    for row in list(&visit).lines().skip(1) {
        let [page, point, position, value] = [5, 6, 7, 8].map(|column| cells(row)[column]);
        let shown = match point {
            "sum" => format!("Sum of page {page}</td><td>{value}</td>"),
            _ => format!("<tr><td>{point}</td><td>{position}</td><td>{value}</td><td></td>"),
        };
        (_, rest) = rest.split_once(&shown).unwrap_or_else(|| panic!("{row}\n{sheet}"));
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
        let visit = typed(value, "um", "spacing_mm = 100.0");
        let seen = all_seen(&list(&visit));
        let row_of = |point: &str| {
            let is_it = |row: &&str| cells(row)[0] == "EYY" && cells(row)[6] == point;
            seen.lines().find(is_it).unwrap()
        };
        let (row, sum) = (row_of("3"), row_of("sum"));
        let other = format!("{}8", row.strip_suffix('3').unwrap());
        // the sum of what was seen is that of the sheet: the list contradicts itself
        let mistyped = seen.replace(row, &other);
        let line = 1 + mistyped.lines().position(|line| line == other).unwrap();
        let differs = format!("`seen` differs from the value in line {line}\n");
        judged(&visit, &mistyped).ends(2).says("`seen` adds up to").says(&differs);
        // without a sum the value is taken as the control's, and differs from the job
        let (unsummed, _) = sum.rsplit_once(',').unwrap();
        let ran = judged(&visit, &mistyped.replace(sum, &format!("{unsummed},"))).ends(1);
        ran.says("EYY (y while y moves)").says(" 100.0000 mm");
    }
}

/// A profile whose list counts, or has digits of its own, holds what is typed: in no other unit is it read.
#[test]
fn a_list_in_counts_or_with_decimals_is_held_as_it_stands() {
    for (id, value, of_y, foreign) in [
        ("centroid", "correction_count", [-8.0, -4.0, 0.0, 6.0, 12.0, 6.0], "correction_um"),
        // From the reference outwards: below it 2 µm in each section, above it 3, counts of 0.5 µm.
        (
            "mitsubishi-e68",
            "outward_increment_count",
            [4.0, 4.0, 0.0, 6.0, 6.0, 20.0],
            "increment_count",
        ),
        ("haas", "correction_inch", [-2e-4, -1e-4, 0.0, 1e-4, 2e-4, 0.0], "correction_count"),
    ] {
        let visit = Visit::with_job(&format!("machines/five_points/{id}.toml"));
        let job = visit.read("job.toml").replace("unit_um = 1.0", "unit_um = 0.5");
        visit.put("job.toml", &job).yes("generate job.toml -q -o kit");
        let list = list(&visit);
        let rows = list.lines().filter(|row| row.starts_with("EYY,Y,Y,,"));
        let found: Vec<f64> = rows.map(|row| cells(row)[8].parse().unwrap()).collect();
        assert_eq!(found, of_y, "{id}: EYY at -200 … 200 mm, sum");
        let seen = all_seen(&list);
        judged(&visit, &seen).ends(0).says(if id == "haas" { "SIGN ASSUMED" } else { "" });
        visit.yes("new --from job.toml --read-out seen -o next");
        let asks = visit.read("next/job.toml").contains("active_backlash_um = \"\"");
        assert_eq!(asks, id == "centroid", "{id}: two tables replace the backlash parameter");
        // The bytes say what they did, the control of this job makes twice as much of a count.
        visit.put("job.toml", job.replace("unit_um = 0.5", "unit_um = 1.0"));
        judged(&visit, &seen).ends(if id == "haas" { 0 } else { 1 });
        let other = seen.replacen(value, foreign, 1);
        // Also where it means something else in the same unit: a deviation, a change from the point before.
        judged(&visit, &other).ends(2).says(&format!("unknown column `{foreign}`"));
        visit.put("seen/screen.csv", "term,base_axis\n");
        visit.run("verify job.toml --tables seen").ends(2).says("is no list with a column");
    }
    let visit = Visit::with_job("machines/five_points/mitsubishi-e68.toml").with_any_kit();
    let wrong = all_seen(&list(&visit)).replace("EYY,Y,Y,,0,2,2,0,0,0", "EYY,Y,Y,,0,2,2,0,1,1");
    let wrong = wrong.replace("2,sum,,20,20", "2,sum,,21,21");
    judged(&visit, &wrong).ends(2).says("the reference point has an increment, expected 0");
}

#[test]
fn a_bump_typed_as_the_checklist_says_moves_the_axis_as_it_says() {
    // Points of Y, whose reference is number 2: what is typed, and where the axis goes at 1 or 3.
    type Bump = &'static [(usize, i32)];
    let one: [Bump; 2] = [&[(1, 5)], &[(3, 5)]];
    for (value, words, bumps, to_um) in [
        ("deviation", "one deviation of +", one, [-5.0, -5.0]),
        ("correction", "one correction of +", one, [5.0, 5.0]),
        ("increment", "next one in +", [&[(1, 5), (2, -5)], &[(3, 5), (4, -5)]], [5.0, 5.0]),
        ("outward_increment", "outwards +", [&[(1, 5), (0, -5)], &[(3, 5), (4, -5)]], [-5.0, 5.0]),
    ] {
        let visit = typed(value, "um", "spacing_mm = 100.0");
        assert!(visit.read("kit/checklist.md").contains(words), "{value}");
        let left = |bump: Bump| -> Vec<f64> {
            let row = |row: &str| {
                let own = cells(row);
                let is_own =
                    |at: usize| own[0] == "EYY" && ["sum", &at.to_string()].contains(&own[6]);
                let typed: i32 = bump.iter().filter(|of| is_own(of.0)).map(|of| of.1).sum();
                let is_head = own[0] == "term";
                if is_head {
                    row.to_string()
                } else {
                    format!("{},{typed},{typed}", own[..8].join(","))
                }
            };
            visit.put(
                "bump/typed.csv",
                list(&visit).lines().map(row).collect::<Vec<_>>().join("\n"),
            );
            visit.yes("simulate job.toml --errors --tables bump --force -o left.csv");
            let left = visit.read("left.csv");
            let rows = left.lines().filter(|row| row.starts_with("y,+,"));
            rows.map(|row| cells(row)[4].parse().unwrap()).collect()
        };
        for (bump, (um, place)) in bumps.into_iter().zip(to_um.into_iter().zip([1, 3])) {
            let moved = left(bump).into_iter().zip(left(&[])).map(|(with, still)| with - still);
            let off = |(at, um_at): (usize, f64)| um_at - if at == place { um } else { 0.0 };
            assert!(moved.enumerate().map(off).all(|off| off.abs() < 1e-6), "{value} {bump:?}");
        }
    }
}
