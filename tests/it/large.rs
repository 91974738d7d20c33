//! However large or bad an input is, the program ends and its memory stays in proportion: at most
//! 8 × (input + output) + 32 MiB. Beyond a stated limit an input is refused, and nothing is written that
//! would be refused when it is read.

use nonius::text::document::{LARGEST_PAGE, MOST_LINES, MOST_ROWS};
use nonius::text::problem::LONGEST_LINE_BYTES;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Hundred times what any of these runs takes; where the work grows with the square of the input they
/// would take hours.
const PATIENCE: Duration = Duration::from_secs(120);
/// Memory for each byte of input and output, and for the program itself.
const PER_BYTE: u64 = 8;
const PROGRAM: u64 = 32 << 20;

/// What a run of the program gave.
struct Ran {
    status: Option<i32>,
    told: String,
    /// Bytes that it read and wrote.
    bytes: u64,
    /// The most memory that it held, where the system says so.
    peak: Option<u64>,
}

fn run(directory: &Path, command: &str) -> Ran {
    let before = size(directory);
    let told = directory.with_extension("told");
    let handle = || File::options().append(true).create(true).open(&told);
    let mut child = Command::new(env!("CARGO_BIN_EXE_nonius"))
        .args(command.split_whitespace())
        .current_dir(directory)
        .stdin(Stdio::null())
        .stdout(handle().expect("a file for the output"))
        .stderr(handle().expect("a file for the talk"))
        .spawn()
        .expect("the program starts");
    let begun = Instant::now();
    let mut peak = None;
    let status = loop {
        peak = memory(&child).max(peak);
        match child.try_wait().expect("the program can be waited for") {
            Some(status) => break status.code(),
            None if begun.elapsed() > PATIENCE => {
                let _ = child.kill();
                let _ = child.wait();
                break None;
            }
            None => std::thread::sleep(Duration::from_millis(2)),
        }
    };
    let bytes = size(directory).max(before) + told.metadata().map_or(0, |file| file.len());
    let text = fs::read_to_string(&told).expect("what is told is text");
    fs::remove_file(told).expect("a file can be removed");
    Ran { status, told: text, bytes, peak }
}

/// The most memory that a process held so far, without the pages of the program's own file.
fn memory(child: &Child) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{}/status", child.id())).ok()?;
    let kib = |key: &str| -> Option<u64> {
        let line = status.lines().find(|line| line.starts_with(key))?;
        line.split_whitespace().nth(1)?.parse().ok()
    };
    Some(kib("VmHWM")?.saturating_sub(kib("RssFile")?) << 10)
}

fn size(directory: &Path) -> u64 {
    let entries = fs::read_dir(directory).expect("the directory is there");
    let of = |entry: fs::DirEntry| match entry.metadata() {
        Ok(metadata) if metadata.is_dir() => size(&entry.path()),
        Ok(metadata) => metadata.len(),
        Err(_) => 0,
    };
    entries.filter_map(Result::ok).map(of).sum()
}

fn fixture(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures").join(path);
    fs::read_to_string(path).expect("the fixture is there")
}

/// A directory with a job and its table.
fn with_job(control: &str) -> TempDir {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    put(&directory, "job.toml", &job(control));
    let errors = fixture("nine_errors_900/errors.csv");
    put(&directory, "errors.csv", &errors);
    directory
}

fn job(control: &str) -> String {
    fixture(&format!("nine_errors_900/{control}.toml"))
}

/// The job with other distances of its points.
fn job_with_spacing(mm: f64) -> String {
    let spacing = format!("spacing_mm = {mm}");
    let job = job("generic").replace("spacing_mm = 30.000000", &spacing);
    job.replace("spacing_mm = 24.000000", &spacing)
}

fn put(directory: &TempDir, name: &str, text: &str) {
    let path = directory.path().join(name);
    let folder = path.parent().expect("a file lies in a folder");
    fs::create_dir_all(folder).expect("a folder can be made");
    fs::write(path, text).expect("a file can be written");
}

/// Many lines, each made from its number.
fn lines(count: usize, line: impl Fn(usize, &mut String)) -> String {
    let mut text = String::new();
    for number in 0..count {
        line(number, &mut text);
        text.push('\n');
    }
    text
}

const READ_OUT: &str = "verify job.toml --tables out";
const KIT: &str = "verify job.toml --tables kit";
const RTL: &str = "import a.rtl -o out.csv --term EXX --first-target-at-mm 0 --targets-run + --sign as-error --runs bidirectional --material-corrected yes";
const ETALON: &str = "import a.txt -o out.csv --from etalon --sign as-error";
const COLUMNS: &str = "import a.csv -o out.csv --columns pos=position_mm,ex=ex_um --axis x --sign as-error --direction both";
const GENERIC: &str = "term,base_axis,output_axis,direction,index,position_mm,deviation_um,correction_um,increment_um\n";

/// Runs a command over one large file.
fn over(control: &str, name: &str, text: &str, command: &str) -> Ran {
    let directory = with_job(control);
    if command == KIT {
        let made = run(directory.path(), "generate job.toml -o kit");
        assert_eq!(made.status, Some(0), "{}", made.told);
    }
    put(&directory, name, text);
    run(directory.path(), command)
}

fn refused(control: &str, name: &str, text: &str, command: &str, says: &str) {
    let ran = over(control, name, text, command);
    let told = ran.told.get(..1000).unwrap_or(&ran.told);
    assert!(ran.told.contains(says), "{name}: expected `{says}`\n{told}");
    let status = if command == KIT { 1 } else { 2 };
    assert_eq!(ran.status, Some(status), "{name}\n{told}");
}

#[test]
fn the_work_of_a_refusal_grows_with_the_input_not_with_its_square() {
    let flaws = lines(LARGEST_PAGE / 20, |n, text| {
        write!(text, "k{n} {n}").expect("a string");
    });
    refused("generic", "job.toml", &flaws, "generate job.toml -o kit", "not valid TOML");
    let unknown = lines(LARGEST_PAGE / 20, |n, text| {
        write!(text, "k{n} = {n}").expect("a string");
    });
    refused("generic", "job.toml", &unknown, "generate job.toml -o kit", "unknown key `k0`");
    let columns = format!("{}\n1;2\n", ";p".repeat(LARGEST_PAGE / 8));
    refused(
        "generic",
        "runs.csv",
        &columns,
        "standards runs.csv",
        "columns, at most 1000 are read",
    );
    let returns = "k = 1\r".repeat(40_000);
    refused("generic", "job.toml", &returns, "generate job.toml -o kit", "too many for a line");

    let names = lines(MOST_LINES / 2 - 10, |n, text| {
        write!(text, "[Q{n}]\nVALUE = 1").expect("a string");
    });
    refused("generic", "a.txt", &names, ETALON, "unknown parameter `Q0`");
    let sections = lines(MOST_LINES * 10, |n, text| {
        write!(text, "S{n}::").expect("a string");
    });
    refused("generic", "a.rtl", &sections, RTL, "lines, too many");
    let axes = lines(MOST_ROWS - 10, |n, text| {
        write!(text, "EXX,A{n},A{n},,0,0,0,0,").expect("a string");
    });
    let axes = format!("{GENERIC}{axes}");
    refused("generic", "out/table.csv", &axes, READ_OUT, "is another axis");

    let good = "N06000Q1A1P40\n".repeat(300_000);
    let bad = "N03620Q1A1X5\n".repeat(5000);
    let text = format!("%\n{good}{bad}%\n");
    refused("fanuc-30i", "out/PARA.TXT", &text, READ_OUT, "the same in 1999 more lines");
}

#[test]
fn a_manifest_that_lists_far_too_much_is_refused() {
    let entries = vec![r#"{"path":"x","role":"table","sha256":"0"}"#; 1_000_000].join(",");
    let text = format!("{{\"files\":[{entries}]}}");
    let directory = with_job("fanuc-30i");
    let made = run(directory.path(), "generate job.toml -o kit");
    assert_eq!(made.status, Some(0), "{}", made.told);
    put(&directory, "kit/manifest.json", &text);
    let active = job("fanuc-30i").replace("= \"none\"", "= \"kit\"");
    put(&directory, "job2.toml", &active);
    let limit = format!("{} KiB, too much for a manifest", LARGEST_PAGE >> 10);
    for command in [KIT, "history kit", "generate job2.toml -o kit2"] {
        let ran = run(directory.path(), command);
        assert_eq!(ran.status, Some(2), "{command}");
        assert!(ran.told.contains(&limit), "{command}\n{}", ran.told);
    }
}

#[test]
fn a_file_that_stands_twice_in_a_manifest_is_told_once() {
    let directory = with_job("fanuc-30i");
    run(directory.path(), "generate job.toml -o kit");
    let manifest = directory.path().join("kit/manifest.json");
    let text = fs::read_to_string(&manifest).expect("a kit has a manifest");
    let again = text.replace(
        "\"files\": [",
        "\"files\": [\n{\"path\":\"PITCH.TXT\"},{\"path\":\"PITCH.TXT\"},{\"path\":\"PITCH.TXT\"},",
    );
    assert_ne!(text, again);
    fs::write(manifest, again).expect("a file can be written");
    let judged = run(directory.path(), KIT);
    assert_eq!(judged.status, Some(1), "{}", judged.told);
    let told = judged.told.matches("`PITCH.TXT` is listed twice").count();
    assert_eq!(told, 1, "{}", judged.told);
    let history = run(directory.path(), "history kit");
    assert_eq!(history.status, Some(1), "{}", history.told);
    assert!(history.told.contains("`PITCH.TXT` is listed twice"), "{}", history.told);
}

#[test]
fn memory_stays_in_proportion_to_input_and_output() {
    const MB: usize = 1_000_000;
    let rtl = fixture("formats/sample_synthetic.rtl");
    let blank = |count: usize| "\n".repeat(count);
    let list = |count: usize| {
        format!("{}\n[k]\nk = [\n{}]\n", job("generic"), "1,1,1,1,1,1,1,1,\n".repeat(count))
    };
    let array = |elements: &str| format!("{{\"schema\":1,\"rows\":[\n{elements}1]}}");
    let points = lines(MOST_ROWS - 10, |n, text| {
        let increment = if n == 0 { "" } else { "0" };
        write!(text, "EXX,X,X,,{n},{}.{:02},0,0,{increment}", n / 100, n % 100).expect("a string");
    });
    let pairs = lines(MOST_LINES - 10, |n, text| {
        write!(text, "{}.{:03},1", n / 1000, n % 1000).expect("a string");
    });
    let generate = "generate job.toml -o made";
    let cases = [
        ("generic", "a.rtl", format!("{rtl}{}", blank(5 * MB)), RTL),
        ("generic", "a.rtl", format!("{rtl}{}", blank(MOST_LINES - 100)), RTL),
        (
            "generic",
            "errors.csv",
            format!("axis,position_mm,ex_um\n{}", "x\n".repeat(5 * MB)),
            generate,
        ),
        (
            "generic",
            "errors.csv",
            format!("axis,position_mm,ex_um\n{}", "x\n".repeat(MOST_LINES - 10)),
            generate,
        ),
        (
            "generic",
            "errors.csv",
            format!("axis,position_mm,ex_um\nx{}\n", ",".repeat(5 * MB)),
            generate,
        ),
        ("generic", "job.toml", list(LARGEST_PAGE / 18), generate),
        ("generic", "job.toml", list(5 * MB / 17), generate),
        ("generic", "kit/manifest.json", array(&"1,".repeat(LARGEST_PAGE / 2 - 20)), KIT),
        ("generic", "kit/manifest.json", array(&"{},".repeat(2 * MB)), KIT),
        ("generic", "out/table.json", array(&"{},\n".repeat(MOST_ROWS - 1)), READ_OUT),
        ("generic", "out/table.json", array(&"{},".repeat(2 * MB)), READ_OUT),
        ("generic", "out/table.json", array(&format!("[{}1],", "1,".repeat(2 * MB))), READ_OUT),
        ("generic", "out/table.csv", format!("{GENERIC}{points}"), READ_OUT),
        ("generic", "out/table.csv", format!("{GENERIC}{}", "x\n".repeat(3 * MB)), READ_OUT),
        ("generic", "a.csv", format!("pos,ex\n{pairs}"), COLUMNS),
        (
            "siemens-840d-sl",
            "out/all.arc",
            format!("%_N_AX_EEC_INI\n{}M17\n", blank(3 * MB)),
            READ_OUT,
        ),
        (
            "siemens-840d-sl",
            "out/all.arc",
            format!("%_N_AX_EEC_INI\n{}M17\n", "$MA_BACKLASH[0,AX1]=1\n".repeat(200_000)),
            READ_OUT,
        ),
        ("fanuc-30i", "out/PARA.TXT", format!("%\n{}%\n", "N1\n".repeat(MB)), READ_OUT),
    ];
    for (control, name, text, command) in &cases {
        let ran = over(control, name, text, command);
        let told = ran.told.get(..300).unwrap_or(&ran.told);
        assert!(matches!(ran.status, Some(0..=2)), "{name}\n{told}");
        let most = PER_BYTE * ran.bytes + PROGRAM;
        let Some(peak) = ran.peak.or((!cfg!(target_os = "linux")).then_some(0)) else {
            continue; // it ended before it was looked at
        };
        assert!(
            peak <= most,
            "{name}: {} kB of memory for {} kB read and written\n{told}",
            peak >> 10,
            ran.bytes >> 10
        );
    }
}

#[test]
fn nothing_is_written_that_would_be_refused_when_it_is_read() {
    let directory = with_job("generic");
    put(&directory, "job.toml", &job_with_spacing(0.01));
    let refused = run(directory.path(), "generate job.toml -o kit");
    let says = format!("rows, expected at most {MOST_ROWS}");
    assert!(refused.told.contains(&says), "{}", refused.told);
    assert_eq!(refused.status, Some(2));
    assert!(!directory.path().join("kit").exists());

    put(&directory, "job.toml", &job_with_spacing(0.15));
    for command in ["generate job.toml -o kit", KIT, "history kit"] {
        let ran = run(directory.path(), command);
        assert_eq!(ran.status, Some(0), "{command}\n{}", ran.told);
    }

    let doubts = "# doubt: it was a windy day in the hall\n".repeat(LARGEST_PAGE / 30);
    let table = fixture("nine_errors_900/errors.csv");
    put(&directory, "errors.csv", &format!("{doubts}{table}"));
    let refused = run(directory.path(), "generate job.toml -o doubtful");
    assert!(refused.told.contains("`manifest.json` holds more than"), "{}", refused.told);
    assert_eq!(refused.status, Some(2));
    assert!(!directory.path().join("doubtful").exists());
}

#[test]
fn no_more_readings_are_simulated_than_are_read() {
    let directory = with_job("siemens-840d-sl");
    let program = r#"
[program]
what = "step-diagonal"
start_mm = { x = 0.0, y = 0.0, z = -720.0 }
size_mm = { x = 900.0, y = 720.0, z = 720.0 }
steps = 360
order = "XYZ"
bidirectional = false
"#;
    let job = format!("{}{program}", job("siemens-840d-sl"));
    put(&directory, "job.toml", &job);
    let simulate = "simulate job.toml --without-tables -o many.csv --runs";
    let many = run(directory.path(), &format!("{simulate} 100"));
    let says = "there would be 432400 readings, expected at most";
    assert!(many.told.contains(says), "{}", many.told);
    assert_eq!(many.status, Some(2));
    assert!(!directory.path().join("many.csv").exists());
    let some = run(directory.path(), &format!("{simulate} 20"));
    assert_eq!(some.status, Some(0), "{}", some.told);
}

#[test]
fn the_limits_stand_in_the_contract() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/interface.md");
    let page = fs::read_to_string(path).expect("the page is there");
    let page = page.split_whitespace().collect::<Vec<_>>().join(" ");
    for limit in [
        format!("{} 000 lines", MOST_LINES / 1000),
        format!("{} 000 rows", MOST_ROWS / 1000),
        format!("{} KiB", LARGEST_PAGE >> 10),
        format!("{} KiB for a line", LONGEST_LINE_BYTES >> 10),
    ] {
        assert!(page.contains(&limit), "docs/interface.md does not state {limit}");
    }
}
