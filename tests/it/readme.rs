//! The README shows what the program prints, and its table of evidence is that of the profiles.
use crate::support::*;
use nonius::control::controller::builtin;

#[test]
fn the_readme_shows_what_the_main_job_prints() {
    let visit = Visit::new();
    let (kit, drawn) = (visit.at("kit"), visit.at("before-after.svg"));
    let (kit, drawn) = (kit.display(), drawn.display());
    let job = "fixtures/nine_errors_900/fanuc-30i.toml";
    let command = format!("generate {job} -o \"{kit}\" --plot \"{drawn}\"");
    let printed = in_repository(&command).ends(0).out;
    is_shown(&page("README.md"), "checked by tests/it/readme.rs", &printed);
    let drawn = visit.read("before-after.svg");
    let kept = fixtures("../docs/before-after.svg");
    if std::env::var_os("NONIUS_UPDATE").is_some() {
        std::fs::write(&kept, &drawn).unwrap();
    }
    let kept = std::fs::read_to_string(kept).expect("the picture of the README");
    assert_eq!(drawn, kept, "the picture of the README is what the program draws: NONIUS_UPDATE=1");
}

#[test]
fn the_contents_name_every_page() {
    let folder = std::fs::read_dir(fixtures("../docs")).unwrap();
    let names = folder.map(|file| file.unwrap().file_name().into_string().unwrap());
    let mut pages: Vec<String> = names.filter(|name| name.ends_with(".md")).collect();
    pages.retain(|name| name != "SUMMARY.md");
    let contents = page("docs/SUMMARY.md");
    let links = contents.lines().filter_map(|line| line.split_once("](")?.1.strip_suffix(')'));
    let mut listed: Vec<String> = links.map(str::to_string).collect();
    pages.sort();
    listed.sort();
    assert_eq!(pages, listed);
}

#[test]
fn the_first_kit_is_made_as_it_is_written() {
    let (page, visit) = (page("docs/first-kit.md"), Visit::of("start/readings"));
    let mut printed = String::new();
    for command in page.lines().filter_map(|line| line.strip_prefix("nonius ")) {
        printed += &visit.run(command).ends(0).out;
    }
    for part in page.split("<!-- checked").skip(1) {
        is_shown(part, "by tests/it/readme.rs", &printed);
    }
}

/// Every command of the example in docs/visit.md §12, as it is written there.
#[cfg(unix)]
#[test]
fn the_rehearsal_runs_as_it_is_written() {
    let script = block_behind(&page("docs/visit.md"), "run by tests/it/readme.rs");
    let visit = Visit::new();
    std::os::unix::fs::symlink(fixtures(""), visit.at("fixtures")).unwrap();
    let ran = visit.shell(&format!("set -e; PATH=\"$(dirname $N):$PATH\"\n{script}")).ends(0);
    assert_eq!(ran.out.matches("verdict: pass").count(), 3, "{}", ran.out);
    ran.says("REHEARSAL: both measurements were simulated");
    assert!(visit.has("out/visit/report.html"));
}

#[test]
fn the_table_of_evidence_is_that_of_the_profiles() {
    let (readme, controllers) = (page("README.md"), page("docs/controllers.md"));
    for id in builtin::ids() {
        let figures = evidence(id) + " |";
        assert!(readme.contains(&format!("`{id}`")), "README names {id}");
        let begin = format!("| `{id}` |");
        let rows = readme.lines().chain(controllers.lines());
        let rows: Vec<&str> = rows.filter(|line| line.starts_with(&begin)).collect();
        assert!(!rows.is_empty(), "no page has a row for {id}");
        for row in rows {
            let is_same = row.ends_with(&figures);
            assert!(is_same, "{id}: a page says\n{row}\nthe profile says {figures}");
        }
    }
}

/// The jobs to begin with work as they stand for every control (with the errors: tests/it/foreign_text.rs).
#[test]
fn the_jobs_to_start_from_are_named_and_that_of_readings_works_for_every_control() {
    for start in ["fixtures/start/errors", "fixtures/start/readings"] {
        assert!(page("docs/interface.md").contains(start), "interface.md does not name {start}");
    }
    for id in builtin::ids() {
        let visit = Visit::of("start/readings");
        visit.edit("job.toml", "siemens-840d-sl", id);
        if needs_unit(id) {
            visit.edit("job.toml", "# detection_unit_um", "detection_unit_um");
        }
        visit.yes("generate job.toml -o kit");
    }
}

/// How many readings of the shipped job can be off, each alone, so that `separate` finds nothing.
#[test]
fn as_many_readings_can_be_off_unnoticed_as_is_told() {
    let text = fixture("start/readings/readings.csv");
    let moved = |line: &&str| [",x,", ",y,", ",z,"].iter().any(|axis| line.contains(axis));
    for (off_um, noise_um, told) in [
        (5.0, None, 26),
        (15.0, None, 0),
        (1000.0, None, 0),
        (5.0, Some(0.3), 4),
        (3.0, Some(0.3), 26),
    ] {
        let visit = Visit::of("start/readings");
        if let Some(um) = noise_um {
            visit.edit("job.toml", "# noise_um = 0.3", &format!("noise_um = {um}"));
        }
        let is_unnoticed = |line: &&str| {
            let (head, um) = line.rsplit_once(',').unwrap();
            let off = um.parse::<f64>().unwrap() + off_um;
            visit.put("readings.csv", replaced(&text, line, &format!("{head},{off:.3}")));
            // The trials say how far off the result may be, not what is found.
            visit.run("separate job.toml --trials 0").status == Some(0)
        };
        let readings = text.lines().filter(moved);
        assert_eq!(readings.clone().count(), 48);
        assert_eq!(readings.filter(is_unnoticed).count(), told, "{off_um}, {noise_um:?}");
    }
    holds(
        &page("docs/accuracy.md").replace('\n', " "),
        &[
            "26 of the 48 readings can be off by 5 µm unnoticed, none of them by 15 µm or more",
            "Where the scatter is stated (`noise_um = 0.3`) 4 can be off by 5 µm",
            "off by 3 µm 26 pass even then",
        ],
    );
}
