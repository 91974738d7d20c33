//! Where a run writes: killed, twenty at once, standard output closed, places that are read-only, links, or inputs.

use crate::support::*;
use std::ffi::OsStr;
use std::fs;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// Every whole kit of a visit passes `verify`, which checks the manifest; nothing else is there.
fn only_whole_kits(visit: &Visit) {
    let is_kit = |name: &&String| name.starts_with("kit") && !name.contains(".partial-");
    for name in visit.names().iter().filter(is_kit) {
        visit.run(&format!("verify job.toml --tables {name}")).ends(0);
    }
}

/// Twenty runs, started together: how many of them wrote. The others were refused, and each says what it did.
fn twenty(visit: &Visit, words: &str) -> usize {
    let spawned = |_| {
        let mut command = program(visit.folder(), words);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts")
    };
    let children: Vec<Child> = (0..20).map(spawned).collect();
    let mut wrote = 0;
    for child in children {
        let ran = Ran::of(words, &child.wait_with_output().expect("the program ends"));
        let is_others = |line: &&str| is_of_windows() && line.contains(".partial-"); // told, not removed
        let refused =
            ran.err.lines().find(|l| !is_others(l)).is_some_and(|l| l.starts_with("problem: "));
        match ran.status {
            Some(0 | 1) if ran.err.contains("wrote ") => wrote += 1,
            Some(2) if refused && !ran.err.contains("wrote ") => {}
            other => panic!("{other:?}: {}", ran.err),
        }
    }
    assert_eq!(visit.files().keys().find(|name| name.contains(".partial-")), None);
    wrote
}

#[test]
fn of_twenty_at_once_one_writes_and_the_others_are_refused() {
    let visit = Visit::of("start/errors");
    for (words, output) in [
        ("generate job.toml -o kit", "kit"),
        ("generate job.toml -o new/deep/kit", "new"),
        ("simulate job.toml --errors -o put.csv", "put.csv"),
    ] {
        let before = visit.files();
        assert_eq!(twenty(&visit, words), 1, "{words}");
        let name = difference(&before, &visit.files());
        let is_ours = |name: &str| name == output || name.starts_with(&format!("{output}/"));
        assert!(name.split(", ").all(is_ours), "{words}: {name}");
        only_whole_kits(&visit);
    }
    let visit = Visit::of("base/form");
    assert_eq!(twenty(&visit, FILL_IN), 1);
    assert!(visit.read("form.csv").contains("1,1,+,500\n"));
}

#[test]
fn twenty_at_once_with_force_lose_nothing() {
    let visit = Visit::of("start/errors").with_kit();
    let own = "what a person wrote\n";
    visit.put("kit/archive.arc", own);
    assert!(twenty(&visit, "generate job.toml -o kit --force") > 0);
    let found = visit.files();
    assert_eq!(copies(&found, own.as_bytes()), 1);
    assert!(below(&found, "kit").is_some());
    only_whole_kits(&visit);
    assert!(twenty(&visit, "simulate job.toml --errors -o put.csv --force") > 0);
}

/// A form of three captures, filled in from a list in the same place.
const FILL_IN: &str = "import list.txt --form form.csv --columns \"#1=displacement_mm\" --captures cumulative \
    --decimal comma -o form.csv --force";

#[cfg(unix)]
#[test]
fn a_form_that_comes_in_by_standard_input_is_not_replaced() {
    let line = FILL_IN.replace("--form form.csv", "--form - < form.csv");
    Visit::of("base/form").refuses(&format!("$N {line}")).says("would replace");
}

#[cfg(unix)]
#[test]
fn files_beyond_what_the_user_may_write_leave_nothing() {
    let ran = Visit::of("start/errors").refuses("ulimit -f 8; exec $N generate job.toml -o kit");
    ran.says("cannot write");
}

#[test]
fn a_form_that_was_saved_meanwhile_is_not_replaced() {
    if !cfg!(target_os = "linux") || !is_installed("strace") {
        return;
    }
    let visit = Visit::of("base/form");
    let slowly =
        "strace -f -q -o /dev/null -e inject=rename,renameat,renameat2:delay_enter=2000000";
    let mut traced = visit.by_shell(&format!("exec {slowly} $N {FILL_IN}"));
    let run = traced.stdin(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    while !visit.files().keys().any(|name| name.contains(".partial-")) {
        std::thread::sleep(Duration::from_millis(10));
    }
    std::thread::sleep(Duration::from_millis(200));
    let own = visit.read("form.csv").replace("+,\n", "+,7\n");
    visit.put("form.csv", own.as_str());
    let ran = Ran::of("import", &run.wait_with_output().unwrap()).ends(2);
    ran.says("somebody changed it while this run was at work");
    assert_eq!((visit.read("form.csv"), visit.files().len()), (own, 2));
}

#[cfg(unix)]
#[test]
fn with_a_closed_standard_output_the_same_is_written() {
    for words in [
        "generate job.toml -o kit",
        "generate job.toml -o new/kit --format json",
        "simulate job.toml --errors -o put.csv",
    ] {
        let (undisturbed, visit) = (Visit::of("start/errors"), Visit::of("start/errors"));
        let expected = undisturbed.run(words);
        let closed = visit.shell(&format!("exec $N {words} >&-"));
        assert_eq!(closed.status, expected.status, "{words}: {}", closed.err);
        assert_eq!(closed.err, expected.err);
        assert!(visit.files() == undisturbed.files(), "{words}");
    }
}

/// A name that is no text, and a directory that may not be read: not by its owner alone, as root may all.
#[cfg(unix)]
#[test]
fn names_and_directories_that_cannot_be_read_are_told_in_the_right_words() {
    use std::os::unix::{ffi::OsStrExt, process::CommandExt};
    let visit = Visit::of("start/errors").with_kit();
    fs::create_dir(visit.at("closed")).unwrap();
    visit.set_mode(".", 0o777);
    visit.set_mode("closed", 0o000);
    for words in
        ["history closed", "generate job.toml -o closed", "verify job.toml --tables closed"]
    {
        let mut nobody = program(visit.folder(), words);
        let Ok(output) = nobody.uid(65534).output() else {
            skipped("another user cannot run the program");
            break;
        };
        Ran::of(words, &output).ends(2).says("permission denied");
    }
    visit.set_mode("closed", 0o777);
    fs::write(visit.at("kit").join(OsStr::from_bytes(b"x\xff")), "").unwrap();
    let ran = visit.run("verify job.toml --tables kit").ends(2);
    ran.says(r#"the name "x\xFF" of a file in it is not UTF-8"#);
}

#[cfg(unix)]
#[test]
fn a_place_that_is_read_only_is_refused() {
    let visit = Visit::of("start/errors");
    let closed = visit.at("closed");
    fs::create_dir(&closed).expect("a directory");
    visit.yes("generate job.toml -o closed/kit");
    visit.yes("simulate job.toml --errors -o closed/put.csv");
    visit.set_mode("closed", 0o555);
    // The administrator may write there all the same, unless all that is below is mounted read-only.
    let mount = |options: &[&str]| succeeds(Command::new("mount").args(options).arg(&closed));
    let is_mounted = mount(&["--bind", &closed.to_string_lossy()]);
    let is_closed = fs::create_dir(closed.join("try")).is_err() || {
        fs::remove_dir(closed.join("try")).expect("just made");
        is_mounted && mount(&["-o", "remount,bind,ro"])
    };
    let before = visit.files();
    let ran = [
        "generate job.toml -o closed/new",
        "generate job.toml -o closed/new/kit",
        "generate job.toml -o closed/kit --force",
        "simulate job.toml --errors -o closed/put.csv --force",
        "simulate job.toml --errors -o closed/new.csv",
    ]
    .map(|words| visit.run(words));
    let after = visit.files();
    if is_mounted {
        assert!(succeeds(Command::new("umount").arg(&closed)));
    }
    visit.set_mode("closed", 0o755);
    if !is_closed {
        return skipped("nothing is closed to this user, and nothing can be mounted");
    }
    for ran in ran {
        let ran = ran.ends(2);
        assert!(ran.err.contains("nothing was written"), "{}: {}", ran.command, ran.err);
    }
    assert_eq!(difference(&before, &after), "");
}

#[cfg(unix)]
#[test]
fn a_kit_is_written_through_a_link_to_its_folder() {
    let visit = Visit::of("start/errors");
    fs::create_dir(visit.at("stick")).expect("a directory");
    std::os::unix::fs::symlink("stick", visit.at("link")).expect("a link");
    visit.yes("generate job.toml -o link/kit");
    visit.yes("generate job.toml -o link/kit --force");
    let found = visit.files();
    assert!(below(&found, "stick/kit.previous").is_some());
    assert!(below(&found, "stick/kit") == below(&found, "stick/kit.previous"));
}

#[test]
fn the_page_is_written_where_the_program_holds_it() {
    let visit = Visit::new();
    let ran = visit.run("page -o nonius.html");
    if visit.has("nonius.html") {
        ran.ends(0).says("wrote nonius.html");
        visit.run("page -o nonius.html").ends(2);
        assert!(visit.yes("page -o -").ends_with(&visit.read("nonius.html")));
        return;
    }
    ran.ends(2).says("this program was built without the page");
}
