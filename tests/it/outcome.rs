//! What a command made goes out whole or not at all: standard output, files, and what is left of a run
//! that failed, was ended or was killed.

#![cfg(unix)]
use std::fs::{self, File};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A fresh directory with a job, its errors, and readings of the diagonals.
fn place() -> tempfile::TempDir {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures");
    for (from, to) in [
        ("nine_errors_900/siemens-840d-sl.toml", "job.toml"),
        ("nine_errors_900/errors.csv", "errors.csv"),
        ("diagonals/case_b_setup/job.toml", "diagonals.toml"),
        ("diagonals/case_b_setup/readings.csv", "readings.csv"),
    ] {
        fs::copy(fixtures.join(from), directory.path().join(to)).expect("a fixture");
    }
    directory
}

/// The program by way of a shell: `$N` is the program.
fn shell(at: &Path, command: &str) -> Output {
    Command::new("sh")
        .args(["-c", command])
        .env("N", env!("CARGO_BIN_EXE_nonius"))
        .current_dir(at)
        .output()
        .expect("a shell")
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn names(at: &Path) -> Vec<String> {
    let entries = fs::read_dir(at).expect("a directory");
    let name = |entry: std::io::Result<fs::DirEntry>| entry.expect("an entry").file_name();
    let mut names: Vec<String> =
        entries.map(|entry| name(entry).to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Commands that write something, with what they write; each succeeds.
const WRITING: [(&str, &str); 6] = [
    ("generate job.toml -o new", "new"),
    ("generate job.toml -o above/deep/new", "above"),
    ("generate job.toml --format json -o new", "new"),
    ("simulate job.toml --errors -o new.csv", "new.csv"),
    ("simulate diagonals.toml --format json -o new.csv", "new.csv"),
    ("separate diagonals.toml --trials 0 -o new.csv", "new.csv"),
];

#[test]
fn where_standard_output_fails_nothing_is_written() {
    if !Path::new("/dev/full").exists() {
        return;
    }
    let place = place();
    let at = place.path();
    let before = names(at);
    for (command, _) in WRITING {
        let output = shell(at, &format!("$N {command} > /dev/full"));
        assert_eq!(output.status.code(), Some(2), "{command}");
        assert!(told(&output).contains("standard output cannot be written"));
        assert!(!told(&output).contains("wrote"), "{}", told(&output));
        assert_eq!(names(at), before, "{command}");
    }
    shell(at, "$N generate job.toml -o kit");
    let kept = names(&at.join("kit"));
    let output = shell(at, "$N generate job.toml -o kit --force > /dev/full");
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(names(&at.join("kit")), kept);
    assert!(!at.join("kit.previous").exists());
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    for (command, made) in WRITING {
        let place = place();
        let script = format!("{{ $N {command}; echo $? > status; }} | true; cat status");
        let output = shell(place.path(), &script);
        // 1 = made, but the answer is no.
        let status = String::from_utf8_lossy(&output.stdout).trim().to_string();
        assert!(status == "0" || status == "1", "{command}: {status}");
        assert!(told(&output).contains("wrote"), "{}", told(&output));
        assert!(place.path().join(made).exists(), "{command}");
    }
}

#[test]
fn a_run_that_fails_leaves_no_directory_behind() {
    let place = place();
    let at = place.path();
    let before = names(at);
    // A name of a file in the kit that is longer than a name may be.
    let profile = format!(
        "schema = 1\nid = \"own\"\nname = \"own\"\nbased_on = \"generic\"\n[[files]]\nrole = \"table\"\npath = \"{}.CSV\"\ntemplate = \"generic.csv.tera\"\n",
        "A".repeat(300)
    );
    let folder = tempfile::tempdir().expect("a place");
    fs::write(folder.path().join("own.toml"), profile).expect("a profile");
    let job = fs::read_to_string(at.join("job.toml")).expect("the job");
    let own = folder.path().join("own.toml").display().to_string();
    let job = job.replace("siemens-840d-sl", &own);
    let job = job.replace("errors.csv", &at.join("errors.csv").display().to_string());
    fs::write(folder.path().join("job.toml"), job).expect("a job");
    let from = folder.path().join("job.toml");
    let output = shell(at, &format!("$N generate {} -o a/b/kit", from.display()));
    assert_eq!(output.status.code(), Some(2), "{}", told(&output));
    assert!(told(&output).contains("cannot write"), "{}", told(&output));
    assert_eq!(names(at), before);
}

#[test]
fn what_is_written_has_the_permissions_that_the_users_mask_leaves() {
    let place = place();
    let at = place.path();
    for mask in [0o022, 0o077, 0o002] {
        let kit = format!("kit-{mask:o}");
        let script = format!(
            "umask {mask:o}; $N generate job.toml -o {kit} && $N simulate job.toml --errors -o {kit}.csv"
        );
        assert!(shell(at, &script).status.success());
        let mode = |path: PathBuf| {
            let found = fs::metadata(path).expect("it was written");
            found.permissions().mode() & 0o777
        };
        assert_eq!(mode(at.join(&kit)), 0o777 & !mask);
        assert_eq!(mode(at.join(&kit).join("manifest.json")), 0o666 & !mask);
        assert_eq!(mode(at.join(format!("{kit}.csv"))), 0o666 & !mask);
    }
}

/// A part program that takes long.
fn long_program(at: &Path, repeats: usize) {
    let block = "G1 X100 Y50 F500\nX0 Y0\n".repeat(repeats);
    fs::write(at.join("long.nc"), format!("G21 G90\n{block}M30\n")).expect("a program");
    let job = fs::read_to_string(at.join("job.toml")).expect("the job");
    let zero = "[[path.offset]]\nsystem = \"G54\"\nx_mm = 0.0\ny_mm = 0.0\nz_mm = 0.0\n";
    fs::write(at.join("path.toml"), format!("{job}\n{zero}")).expect("a job");
}

fn partials(at: &Path) -> Vec<String> {
    let mut names = names(at);
    names.retain(|name| name.contains(".partial-"));
    names
}

/// Starts a run that writes for long, and waits until it does.
fn started(at: &Path) -> std::process::Child {
    let before = partials(at);
    let mut child = Command::new(env!("CARGO_BIN_EXE_nonius"))
        .args(["path", "path.toml", "long.nc", "-o", "points.csv"])
        .current_dir(at)
        .stdout(Stdio::null())
        .stderr(File::create(at.join("talk")).expect("a file"))
        .spawn()
        .expect("the program starts");
    while partials(at).iter().all(|name| before.contains(name)) {
        let ended = child.try_wait().expect("it can be asked");
        assert!(ended.is_none(), "the run ended too early: {ended:?}");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    child
}

fn signal(child: &std::process::Child, name: &str) {
    let sent = Command::new("kill").args([format!("-{name}"), child.id().to_string()]).status();
    assert!(sent.is_ok_and(|sent| sent.success()));
}

#[test]
fn a_run_that_is_ended_cleans_up() {
    let place = place();
    let at = place.path();
    long_program(at, 200_000);
    for name in ["INT", "TERM", "HUP"] {
        let mut child = started(at);
        signal(&child, name);
        let status = child.wait().expect("it ends");
        assert_eq!(status.code(), Some(2), "{name}");
        assert_eq!(partials(at), Vec::<String>::new(), "{name}");
        assert!(!at.join("points.csv").exists());
    }
}

#[test]
fn what_a_killed_run_left_is_named_and_removed_by_the_next_but_not_what_is_at_work() {
    let place = place();
    let at = place.path();
    long_program(at, 200_000);
    let mut killed = started(at);
    signal(&killed, "KILL");
    killed.wait().expect("it ends");
    let left = partials(at);
    assert_eq!(left.len(), 1);
    // A name that a person chose is nobody's left-over.
    fs::write(at.join("points.csv.partial-backup"), "mine").expect("a file");
    let mut working = started(at);
    let of_the_working: Vec<String> = partials(at)
        .into_iter()
        .filter(|name| !left.contains(name) && !name.ends_with("backup"))
        .collect();
    let talk = fs::read_to_string(at.join("talk")).expect("what it said");
    let words = format!("removed {}, left by a run that was killed", left[0]);
    assert!(talk.contains(&words), "{talk}");
    fs::write(at.join("short.nc"), "G21 G90\nG1 X1 F100\nM30\n").expect("a program");
    let output = shell(at, "$N path path.toml short.nc -o points.csv");
    assert_eq!(output.status.code(), Some(0), "{}", told(&output));
    assert_eq!(of_the_working.len(), 1);
    assert!(at.join(&of_the_working[0]).exists(), "{}", told(&output));
    signal(&working, "TERM");
    working.wait().expect("it ends");
    assert_eq!(partials(at), ["points.csv.partial-backup"]);
}

/// `nohup`, and a shell's `&`.
#[cfg(target_os = "linux")]
#[test]
fn signals_that_the_run_was_started_to_ignore_stay_ignored() {
    let place = place();
    let at = place.path();
    long_program(at, 5_000);
    let script = "trap '' HUP; exec $N path path.toml long.nc -o points.csv";
    let mut child = Command::new("sh")
        .args(["-c", script])
        .env("N", env!("CARGO_BIN_EXE_nonius"))
        .current_dir(at)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("a shell");
    while partials(at).is_empty() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    signal(&child, "HUP");
    let status = child.wait().expect("it ends");
    assert_eq!(status.code(), Some(0));
    assert!(at.join("points.csv").exists());
}

/// A program that holds the folder's lock for its own reasons does not hold the run up.
#[cfg(target_os = "linux")]
#[test]
fn a_lock_on_the_folder_is_not_waited_for() {
    let place = place();
    let at = place.path();
    let folder = File::open(at).expect("the folder");
    folder.lock().expect("its lock");
    let output = shell(at, "$N generate job.toml -o kit");
    assert_eq!(output.status.code(), Some(0), "{}", told(&output));
}

#[test]
fn the_directory_is_never_absent_while_it_is_replaced() {
    let place = place();
    let at = place.path();
    assert!(shell(at, "$N generate job.toml -o kit").status.success());
    let manifest = at.join("kit/manifest.json");
    for _ in 0..10 {
        let mut child = Command::new(env!("CARGO_BIN_EXE_nonius"))
            .args(["generate", "job.toml", "-o", "kit", "--force"])
            .current_dir(at)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the program starts");
        while child.try_wait().expect("it can be asked").is_none() {
            if cfg!(target_os = "linux") {
                assert!(manifest.exists(), "the kit is absent");
            }
        }
    }
    assert_eq!(names(&at.join("kit")), names(&at.join("kit.previous")));
}
