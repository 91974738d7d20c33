//! No output replaces an input, `--force` removes only what this program made, no input is cut or exchanged in silence.

use super::large::patiently;
use crate::support::{Ran, Visit, below, copies, own_profile, replaced, succeeds};
use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

const WOULD_REPLACE: &str = "which this run reads";
const MAKE: &str = "generate job.toml -o kit";
const FORCE: &str = "generate job.toml -o kit --force";

/// A measuring run along the axes of `start/errors`.
pub(super) const PROGRAM: &str = "\n[program]\nwhat = \"single-axis\"\nbidirectional = false\n\
    steps = 5\nstart_mm = { x = 10.0, y = 10.0, z = -190.0 }\n\
    size_mm = { x = 300.0, y = 200.0, z = 100.0 }\n";

#[track_caller]
fn expect(visit: &Visit, command: &str, status: i32, says: &str) {
    told(patiently(visit, command, Stdio::null()).ends(status), says);
}

#[track_caller]
fn told(ran: Ran, says: &str) {
    assert!(ran.err.contains(says), "expected `{says}` of {}\n{}", ran.command, ran.err);
}

#[track_caller]
fn refused(visit: &Visit, command: &str, says: &str) {
    let before = visit.files();
    expect(visit, command, 2, says);
    assert!(visit.files() == before, "{command} changed something");
}

/// By its own name: fixtures/cases/refuses/outputs.txt.
#[cfg(unix)]
#[test]
fn no_output_replaces_an_input_through_links_other_ways_or_standard_input() {
    use std::os::unix::fs::symlink;
    let visit = Visit::of("diagonals/case_b_setup");
    fs::hard_link(visit.at("readings.csv"), visit.at("hard.csv")).unwrap();
    symlink("readings.csv", visit.at("soft.csv")).unwrap();
    symlink(".", visit.at("here")).unwrap();
    let around = format!("./../{}/job.toml", visit.folder().file_name().unwrap().display());
    for output in ["hard.csv", "here/readings.csv", "soft.csv", &around] {
        let says = if output == "soft.csv" { "is a link" } else { WOULD_REPLACE };
        refused(&visit, &format!("simulate job.toml -o {output} --force"), says);
    }
    visit.refuses("$N simulate - -o job.toml --force < job.toml").says(WOULD_REPLACE);
}

#[cfg(unix)]
#[test]
fn an_output_is_a_regular_file_or_new() {
    use std::os::unix::fs::FileTypeExt;
    let visit = Visit::of("start/errors");
    fifo(&visit.at("pipe"));
    fs::create_dir(visit.at("folder")).unwrap();
    // A device of the test's own; only root can make one.
    let device = visit.at("device");
    let has_device = succeeds(Command::new("mknod").arg(&device).args(["c", "1", "3"]));
    for output in ["pipe", "folder", "device"].into_iter().take(2 + usize::from(has_device)) {
        let says = if output == "folder" { "is a directory" } else { "is no regular file" };
        refused(&visit, &format!("simulate job.toml --errors -o {output} --force"), says);
    }
    let kind = |path: &Path| fs::symlink_metadata(path).unwrap().file_type();
    assert!(kind(&visit.at("pipe")).is_fifo());
    assert!(!has_device || kind(&device).is_char_device());
    // Nor a link: what it leads to would stay where it is.
    for target in ["not-there", "folder"] {
        let link = format!("link-{target}");
        std::os::unix::fs::symlink(target, visit.at(&link)).unwrap();
        for output in [&link, &format!("{link}/")] {
            visit.refuses(&format!("$N generate job.toml -o {output} --force"));
        }
        assert!(visit.at(&link).is_symlink());
    }
}

#[cfg(unix)]
fn fifo(path: &Path) {
    assert!(succeeds(Command::new("mkfifo").arg(path)), "mkfifo");
}

#[test]
fn force_twice_keeps_job_and_measurement_that_were_moved_into_the_kit() {
    let visit = Visit::of("start/errors");
    let inputs = ["job.toml", "errors.csv"].map(|name| (name, visit.read(name)));
    expect(&visit, MAKE, 0, "wrote");
    for (name, _) in &inputs {
        fs::rename(visit.at(name), visit.at("kit").join(name)).unwrap();
    }
    refused(&visit, "generate kit/job.toml -o kit --force", WOULD_REPLACE);
    visit.run("generate kit.previous/job.toml -o kit --force");
    for (name, text) in inputs {
        assert_eq!(copies(&visit.files(), text.as_bytes()), 1, "{name}");
    }
}

/// Put into a kit, put where older kits are kept, readings filled in: each further run moves what is there away.
#[test]
fn force_removes_nothing_of_a_users() {
    for (name, force, own, moved) in [
        ("kit", FORCE, "kit/archive.arc", &["", "-2", "-3"][..]),
        ("kit", FORCE, "kit.previous/photo.jpg", &["-2", "-3"]),
        ("run", "program run.toml -o run --force", "run/readings-z.csv", &["", "-2"]),
    ] {
        let visit = Visit::of("start/errors");
        visit.put("run.toml", visit.read("job.toml") + PROGRAM);
        expect(&visit, force, 0, "wrote");
        assert_eq!(visit.has(own), name == "run", "{own}");
        visit.put(own, "what a person put there");
        if own.starts_with("kit.previous") {
            visit.put("kit.previous/manifest.json", r#"{"files":[]}"#);
        }
        for number in moved {
            let old = below(&visit.files(), name);
            let previous = format!("{name}.previous{number}");
            expect(&visit, force, 0, &format!("moved {name} to {previous}\n"));
            assert!(below(&visit.files(), &previous) == old, "{previous} is the old one");
        }
        assert_eq!(copies(&visit.files(), b"what a person put there"), 1, "{own}");
        let (_, file) = own.split_once('/').unwrap();
        assert!(visit.at(&format!("{name}.previous/{file}")).is_file(), "{own}");
        assert!(visit.at(&format!("{name}.previous-2/manifest.json")).is_file(), "{own}");
    }
}

#[cfg(unix)]
#[test]
fn what_is_replaced_keeps_its_permissions() {
    let visit = Visit::of("start/errors");
    let simulate = "simulate job.toml --errors -o after.csv --force";
    for (name, command, mode) in [("after.csv", simulate, 0o600), ("kit", FORCE, 0o2750)] {
        expect(&visit, command, 0, "wrote");
        visit.set_mode(name, mode);
        expect(&visit, command, 0, "wrote");
        assert_eq!(visit.mode(name), mode, "{name}");
    }
}

#[test]
fn standard_input_beyond_the_limit_is_refused_like_a_file() {
    let visit = Visit::of("start/errors");
    let job = visit.read("job.toml");
    for (bytes, status, refusal) in [
        (256 << 10, 0, ""),
        ((256 << 10) + 1, 2, "more than 256 KiB"),
        ((64 << 20) + 1, 2, "more than 64 MiB"),
    ] {
        // A valid job, as long as comments make it.
        let comments = format!("{}\n", "#".repeat(79)).repeat(bytes / 80 + 1);
        visit.put("long.toml", &format!("{job}{comments}")[..bytes]);
        let stdin = File::open(visit.at("long.toml")).unwrap();
        told(patiently(&visit, "context -", stdin.into()).ends(status), refusal);
        expect(&visit, "context long.toml", status, refusal);
    }
}

#[cfg(unix)]
#[test]
fn devices_and_pipes_without_a_writer_are_refused_at_once_and_one_with_a_writer_is_read() {
    let visit = Visit::of("start/errors");
    let job = visit.read("job.toml");
    fifo(&visit.at("pipe"));
    let inputs = [("/dev/zero", "is no regular file"), ("pipe", "nothing was written into it")];
    for (input, says) in inputs {
        visit.put("other.toml", replaced(&job, "errors.csv", input));
        refused(&visit, "generate other.toml -o kit", says);
        refused(&visit, &format!("generate {input} -o kit"), says);
        refused(&visit, &format!("import {input} -o x.csv"), says);
    }
    refused(&visit, "path job.toml /dev/zero", "is no regular file");
    // A shell's `<(…)` is a pipe with a writer. Opened for both, it does not wait for the reader; the bytes fit in.
    let mut both = File::options().read(true).write(true).open(visit.at("pipe")).unwrap();
    std::io::Write::write_all(&mut both, job.as_bytes()).unwrap();
    let writer = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_secs(3));
        drop(both);
    });
    expect(&visit, "generate pipe -o kit", 0, "wrote");
    writer.join().unwrap();
}

#[test]
fn history_follows_no_path_out_of_a_kit() {
    let visit = Visit::of("start/errors");
    expect(&visit, MAKE, 0, "wrote");
    let mut document = visit.document("kit/manifest.json");
    for path in ["../errors.csv", "/dev/zero", "sub/x.csv", "..\\errors.csv", ".."] {
        document["files"][0]["path"] = path.into();
        visit.put("kit/manifest.json", document.to_string());
        let ran = patiently(&visit, "history kit", Stdio::null()).ends(1);
        ran.says(&format!("`{path}` is no plain file name"));
    }
}

#[test]
fn a_template_that_cannot_be_read_is_not_replaced_by_the_built_in_one() {
    let file = "[[files]]\nrole = 'table'\npath = 'TABLE.CSV'\ntemplate = 'generic.csv.tera'\n";
    let visit = Visit::of("start/errors");
    visit
        .edit("job.toml", "siemens-840d-sl", "shop.toml")
        .put("shop.toml", own_profile("generic", file));
    expect(&visit, MAKE, 0, "wrote");
    visit.put("generic.csv.tera", b"{# Fr\xe4se #}{{ nothing }}");
    refused(&visit, "generate job.toml -o other", "generic.csv.tera");
    refused(&visit, "controllers check shop.toml", "generic.csv.tera");
    fs::remove_file(visit.at("generic.csv.tera")).unwrap();
    fs::create_dir(visit.at("generic.csv.tera")).unwrap();
    refused(&visit, "generate job.toml -o other", "generic.csv.tera");
}
