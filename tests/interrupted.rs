//! Killed at any moment or out of space: what lies in the directory is a complete kit, the old
//! one, or nothing.
#![allow(
    clippy::expect_used,
    reason = "a test may stop at the first thing that is not as expected"
)]

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

const JOB: &str = "fixtures/nine_errors_900/siemens-840d-sl.toml";

fn generate(into: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_nonius"));
    command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["generate", JOB, "--force", "-o"])
        .arg(into)
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    command
}

/// A directory with a manifest must pass `verify`, which checks every hash.
fn is_complete(kit: &Path) -> bool {
    Command::new(env!("CARGO_BIN_EXE_nonius"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["verify", JOB, "--tables"])
        .arg(kit)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .expect("the program runs")
        .success()
}

#[test]
fn killed_at_any_moment_nothing_looks_finished_that_is_not() {
    let folder = tempfile::tempdir().expect("a place to write to");
    let kit = folder.path().join("kit");
    for round in 0..60_u64 {
        let mut child = generate(&kit).spawn().expect("the program starts");
        std::thread::sleep(Duration::from_micros(round * 150));
        // It may have finished already; then there is nothing to kill.
        let _ = child.kill();
        child.wait().expect("the program ends");
        for entry in fs::read_dir(folder.path()).expect("a directory") {
            let path = entry.expect("an entry").path();
            let finished = path.join("manifest.json").is_file();
            let partial = path.to_string_lossy().contains(".partial-");
            assert!(partial || finished, "{} has no manifest", path.display());
            if finished && !partial {
                assert!(is_complete(&path), "{} is not complete", path.display());
            }
        }
    }
}

/// A small memory disk stands for a full stick; where it cannot be mounted, the test says so.
#[test]
#[cfg(target_os = "linux")]
fn out_of_space_leaves_nothing_behind() {
    let folder = tempfile::tempdir().expect("a place to write to");
    let stick = folder.path().join("stick");
    fs::create_dir(&stick).expect("a directory");
    let mounted = Command::new("mount")
        .args(["-t", "tmpfs", "-o", "size=16k", "tmpfs"])
        .arg(&stick)
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success());
    if !mounted {
        // Written past the capture of the test runner, so that it is seen.
        let _ = std::io::Write::write_all(
            &mut std::io::stderr(),
            b"skipped: a small memory disk cannot be mounted here\n",
        );
        return;
    }
    let output = generate(&stick.join("kit")).stderr(Stdio::piped()).output();
    let left = fs::read_dir(&stick).map(Iterator::count);
    let unmounted = Command::new("umount").arg(&stick).status();
    let output = output.expect("the program runs");
    let talk = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{talk}");
    assert!(talk.contains("no space left"), "{talk}");
    assert_eq!(
        left.expect("a directory"),
        0,
        "something was left on the stick"
    );
    assert!(unmounted.is_ok_and(|status| status.success()));
}
