//! However large or bad an input is, the program ends and its memory stays in proportion: at most
//! 8 × (input + output) + 32 MiB. Beyond a stated limit an input is refused, and nothing is written that
//! would be refused when it is read.

use crate::COUNTED;
use crate::support::{Entry, Ran, Visit, fixture, in_parallel, page, program, replaced, short_or};
use nonius::text::{LARGEST_PAGE, LONGEST_LINE_BYTES, MOST_LINES, MOST_POINTS, MOST_ROWS};
use std::env;
use std::ffi::OsString;
use std::fs;
use std::process::{Command, ExitCode, Output, Stdio, exit};
use std::time::{Duration, Instant};
use tempfile::NamedTempFile;

/// For hundred times what any of these runs takes; a square of the input, or waiting for nothing, would take hours.
pub(super) fn patiently(visit: &Visit, command: &str, stdin: Stdio) -> Ran {
    let files = [(); 2].map(|()| NamedTempFile::new().unwrap());
    let [out, err] = files.each_ref().map(|file| file.reopen().unwrap());
    let mut program = program(visit.folder(), command);
    let mut child = program.stdin(stdin).stdout(out).stderr(err).spawn().unwrap();
    let begun = Instant::now();
    let status = loop {
        match child.try_wait().unwrap() {
            Some(status) => break status,
            None if begun.elapsed() > Duration::from_secs(120) => child.kill().unwrap(),
            None => std::thread::sleep(Duration::from_millis(2)),
        }
    };
    let [stdout, stderr] = files.map(|file| fs::read(file.path()).unwrap());
    Ran::of(command, &Output { status, stdout, stderr })
}

/// The process of [`counted`]: a command under an allocator that counts.
#[test]
fn counted_run() {
    let (Ok(file), Ok(words)) = (env::var("NONIUS_COUNTED"), env::var("NONIUS_WORDS")) else {
        return; // by itself it is no test
    };
    let (held, asked) = (COUNTED.allocated(), COUNTED.total_allocated());
    let ended = nonius::cli::run(words.lines().map(OsString::from));
    let counts = [COUNTED.max_allocated() - held, COUNTED.total_allocated() - asked];
    fs::write(file, format!("{} {}", counts[0], counts[1])).unwrap();
    let status = [0, 1, 2].into_iter().find(|status| ExitCode::from(*status) == ended);
    exit(status.map_or(101, i32::from));
}

/// Runs a command in a process of its own: the most bytes that it held, and all that it asked for.
fn counted(visit: &Visit, command: &str) -> (Ran, [usize; 2]) {
    let own = program(visit.folder(), command);
    let words = own.get_args().map(|word| word.to_str().unwrap());
    let words = ["nonius"].into_iter().chain(words).collect::<Vec<_>>().join("\n");
    let file = NamedTempFile::new().unwrap();
    let mut run = Command::new(env::current_exe().unwrap());
    run.args(["large::counted_run", "--exact", "--nocapture"]).current_dir(visit.folder());
    run.env("NONIUS_COUNTED", file.path()).env("NONIUS_WORDS", words);
    let ran = Ran::of(command, &run.env("RUST_MIN_STACK", "8388608").output().unwrap());
    let counts = fs::read_to_string(file.path()).unwrap();
    let counts: Vec<usize> = counts.split(' ').filter_map(|count| count.parse().ok()).collect();
    let counts = counts.try_into().unwrap_or_else(|_| panic!("{command}\n{}", ran.all()));
    (ran, counts)
}

fn with_job(control: &str) -> Visit {
    Visit::with_job(&format!("nine_errors_900/{control}.toml"))
}

fn run(visit: &Visit, command: &str) -> Ran {
    patiently(visit, command, Stdio::null())
}

fn lines(count: usize, line: impl Fn(usize) -> String) -> String {
    (0..count).map(|number| line(number) + "\n").collect()
}

const GENERATE: &str = "generate job.toml -o made";
const READ_OUT: &str = "verify job.toml --tables out";
const KIT: &str = "verify job.toml --tables kit";
const RTL: &str = "import a.rtl -o out.csv --term EXX --first-target-at-mm 0 --targets-run + --sign as-error --runs bidirectional --material-corrected yes";
const ETALON: &str = "import a.txt -o out.csv --from etalon --sign as-error";
const COLUMNS: &str = "import a.csv -o out.csv --columns pos=position_mm,ex=ex_um --axis x --sign as-error --direction both";
const TYPED: &str =
    "term,base_axis,output_axis,direction,zero_mm,page,point,position_mm,increment_um,seen\n";
const ROWS: &str = "term,base_axis,output_axis,direction,index,position_mm,deviation_um,correction_um,increment_um\n";

fn beside(control: &str, name: &str, text: &str, command: &str) -> Visit {
    let visit = with_job(control);
    if command.starts_with(KIT) {
        visit.yes("generate job.toml -o kit");
    }
    visit.put(name, text);
    visit
}

#[test]
fn the_work_of_refusing_an_input_grows_with_it_not_with_its_square() {
    let flaws = lines(LARGEST_PAGE / 20, |n| format!("k{n} {n}"));
    let unknown = lines(LARGEST_PAGE / 20, |n| format!("k{n} = {n}"));
    let columns = format!("{}\n1;2\n", ";p".repeat(LARGEST_PAGE / 8));
    let layout = "{% for row in rows %}{{ row }}{% endfor %}\n".repeat(LARGEST_PAGE / 40);
    let report = "report job.toml -o page.html --template page.tera";
    let names = lines(MOST_LINES / 2 - 10, |n| format!("[Q{n}]\nVALUE = 1"));
    let sections = lines(MOST_LINES - 10, |n| format!("S{n}::"));
    let axes = lines(MOST_ROWS - 10, |n| format!("EXX,A{n},A{n},,0,0,0,0,"));
    let (good, bad) = ("N06000Q1A1P40\n".repeat(300_000), "N03620Q1A1X5\n".repeat(5000));
    for (name, text, command, says) in [
        ("job.toml", flaws, GENERATE, "not valid TOML"),
        ("job.toml", unknown, GENERATE, "unknown key `k0`"),
        ("runs.csv", columns, "standards runs.csv", "columns, at most 1000 are read"),
        ("job.toml", "k = 1\r".repeat(40_000), GENERATE, "too many for a line"),
        ("page.tera", layout, report, "KiB, too much for"),
        ("a.txt", names, ETALON, "unknown parameter `Q0`"),
        ("a.rtl", sections, RTL, "there is no section `RUNS::`"),
        ("out/table.csv", format!("{ROWS}{axes}"), READ_OUT, "is another axis"),
        ("out/PARA.TXT", format!("%\n{good}{bad}%\n"), READ_OUT, "the same in 1999 more lines"),
    ] {
        let control = if name == "out/PARA.TXT" { "fanuc-30i" } else { "generic" };
        run(&beside(control, name, &text, command), command).ends(2).says(says);
    }
}

#[test]
fn a_manifest_that_lists_too_much_is_refused_and_what_stands_twice_is_told_once() {
    let visit = with_job("fanuc-30i").with_kit();
    let again = r#"{"path":"PITCH.TXT"},"#.repeat(3);
    visit.edit("kit/manifest.json", "\"files\": [", &format!("\"files\": [\n{again}"));
    let twice = "`PITCH.TXT` is listed twice";
    let judged = visit.run(KIT).ends(1).all();
    assert_eq!(judged.matches(twice).count(), 1, "{judged}");
    visit.run("history kit").ends(1).says(twice);
    let entries = vec![r#"{"path":"x","role":"table","sha256":"0"}"#; 1_000_000].join(",");
    visit.put("kit/manifest.json", format!("{{\"files\":[{entries}]}}"));
    visit.put("job2.toml", replaced(&visit.read("job.toml"), "= \"none\"", "= \"kit\""));
    let limit = format!("{} KiB, too much for a manifest", LARGEST_PAGE >> 10);
    for command in [KIT, "history kit", "generate job2.toml -o kit2"] {
        run(&visit, command).ends(2).says(&limit);
    }
}

#[test]
fn memory_stays_in_proportion_to_input_and_output() {
    const MB: usize = 1_000_000;
    let rtl = |count: usize| fixture("formats/sample_synthetic.rtl") + &"\n".repeat(count);
    let errors = |rest: String| format!("axis,position_mm,ex_um\n{rest}\n");
    let list = |count: usize| {
        let job = fixture("nine_errors_900/generic.toml");
        format!("{job}\n[k]\nk = [\n{}]\n", "1,1,1,1,1,1,1,1,\n".repeat(count))
    };
    let array = |elements: String| format!("{{\"schema\":1,\"rows\":[\n{elements}1]}}");
    let points = lines(MOST_ROWS - 10, |n| {
        let increment = if n == 0 { "" } else { "0" };
        format!("EXX,X,X,,{n},{}.{:02},0,0,{increment}", n / 100, n % 100)
    });
    let typed = lines(MOST_ROWS - 10, |n| format!("EXX,X,X,,0,1,{n},{n},0,"));
    let pairs = lines(MOST_LINES - 10, |n| format!("{}.{:03},1", n / 1000, n % 1000));
    let dense = |control: &str, spacing_mm: f64| {
        let job = fixture(&format!("nine_errors_900/{control}.toml"));
        replaced(&job, "spacing_mm = ", &format!("spacing_mm = {spacing_mm} # "))
    };
    let pattern = |n: usize| format!("'(?:[a-z]{{0,100}}[0-9]{{0,100}}){{0,45}}q{n}',\n");
    let facts = "[facts.lines]\nvalue = [\n";
    let weihong = page("controllers/weihong.toml");
    let profile = |patterns: String| replaced(&weihong, facts, &format!("{facts}{patterns}"));
    let patterns = profile((0..1000).map(pattern).collect());
    let long_pattern = profile(format!("'{}q',\n", r"\w".repeat(30_000)));
    let said = |key: &str| {
        let said = lines(MOST_LINES - 200, |n| format!("# {key}: text of number {n}"));
        said + &fixture("nine_errors_900/errors.csv")
    };
    let row = |n: usize| {
        let at = format!("{}.{:02}", n / 100, n % 100);
        format!("{at},{at}{},{at}1", n % 10)
    };
    let runs = format!("target_mm,up1_mm,dn1_mm\n{}", lines(24_000, row));
    let of_axis = |axis: &str, sign: &str| {
        lines(16_600, |n| format!("{axis},{sign}{}.{:02},0.1,0.1,0.1", n / 25, n % 25 * 4))
    };
    let z = of_axis("z", "-").lines().rev().map(|row| format!("{row}\n")).collect::<String>();
    let rows = of_axis("x", "") + &of_axis("y", "") + &z;
    let after = format!("axis,position_mm,ex_um,ey_um,ez_um\n{rows}");
    let siemens = fixture("nine_errors_900/siemens-840d-sl.toml");
    let walked = siemens
        + "\n[program]\nwhat = \"single-axis\"\nruns = 100\nsteps = 1000\n\
        start_mm = { x = 10.0, y = 10.0, z = -710.0 }\nsize_mm = { x = 870.0, y = 690.0, z = 690.0 }\n";
    let archive = |data: String| format!("%_N_AX_EEC_INI\n{data}M17\n");
    let (manifest, json, csv) = ("kit/manifest.json", "out/table.json", "out/table.csv");
    let (generic, backlash) = ("generic", "$MA_BACKLASH[0,AX1]=1\n");
    let cases = [
        (generic, "a.rtl", rtl(5 * MB), RTL),
        (generic, "a.rtl", rtl(MOST_LINES - 100), RTL),
        (generic, "errors.csv", errors("x\n".repeat(5 * MB)), GENERATE),
        (generic, "errors.csv", errors("x\n".repeat(MOST_LINES - 10)), GENERATE),
        (generic, "errors.csv", errors(format!("x{}", ",".repeat(5 * MB))), GENERATE),
        (generic, "job.toml", list(LARGEST_PAGE / 18), GENERATE),
        (generic, "job.toml", list(5 * MB / 17), GENERATE),
        (generic, manifest, array("1,".repeat(LARGEST_PAGE / 2 - 20)), KIT),
        (generic, manifest, array("{},".repeat(2 * MB)), KIT),
        (generic, json, array("{},\n".repeat(MOST_ROWS - 1)), READ_OUT),
        (generic, json, array("{},".repeat(2 * MB)), READ_OUT),
        (generic, json, array(format!("[{}1],", "1,".repeat(2 * MB))), READ_OUT),
        (generic, csv, format!("{ROWS}{points}"), READ_OUT),
        (generic, csv, format!("{ROWS}{}", "x\n".repeat(3 * MB)), READ_OUT),
        (generic, csv, format!("{TYPED}{typed}EXX,X,X,,,1,sum,,0,\n"), READ_OUT),
        (generic, "a.csv", format!("pos,ex\n{pairs}"), COLUMNS),
        (generic, "job.toml", dense(generic, 0.75), GENERATE),
        ("linuxcnc", "job.toml", dense("linuxcnc", 4.0), "generate job.toml --compare"),
        ("isg-volcomp", "job.toml", dense("isg-volcomp", 0.75), GENERATE),
        (generic, "job.toml", dense(generic, 0.75), "generate job.toml --compare"),
        (generic, "job.toml", dense(generic, 0.75), "report job.toml -o r.html"),
        (generic, "job.toml", dense(generic, 0.75), "assess job.toml --with-tables"),
        ("siemens-840d-sl", "job.toml", dense("siemens-840d-sl", 0.75), GENERATE),
        ("klipper-skew", "job.toml", dense("klipper-skew", 1e-4), "generate job.toml --compare"),
        (generic, "p.toml", patterns, "controllers check p.toml"),
        (generic, "p.toml", long_pattern, "controllers check p.toml"),
        (generic, "p.toml", "k = [1, 2, 3, 4, 5]\n".repeat(MOST_LINES), "controllers check p.toml"),
        (generic, "errors.csv", said("doubt"), "report errors.csv -o r.html"),
        (generic, "errors.csv", said("doubt"), "report job.toml -o r.html"),
        (generic, "errors.csv", said("note"), GENERATE),
        (generic, "errors.csv", said("not determined: EXX"), "assess errors.csv --format json"),
        (generic, "runs.csv", runs.clone(), "report errors.csv --linear runs.csv -o r.html"),
        (generic, "runs.csv", runs, "standards runs.csv --format json"),
        (generic, "after.csv", after, "verify job.toml --tables kit --after after.csv"),
        ("siemens-840d-sl", "out/all.arc", archive("\n".repeat(3 * MB)), READ_OUT),
        ("siemens-840d-sl", "out/all.arc", archive(backlash.repeat(200_000)), READ_OUT),
        ("fanuc-30i", "out/PARA.TXT", format!("%\n{}%\n", "N1\n".repeat(MB)), READ_OUT),
        ("siemens-840d-sl", "job.toml", walked, "program job.toml -o run"),
    ];
    // Every third, or all where `NONIUS_SIMULATIONS` is set.
    let cases: Vec<_> = cases.iter().step_by(short_or(3, 1)).collect();
    let judged = in_parallel(&cases, |(control, name, text, command)| {
        let visit = beside(control, name, text, command);
        let of = |entry: &Entry| if let Entry::File(bytes) = entry { bytes.len() } else { 0 };
        let size = || visit.files().values().map(of).sum::<usize>();
        let before = size();
        let (ran, [peak, _]) = counted(&visit, command);
        let told = ran.all();
        assert!(matches!(ran.status, Some(0..=2)), "{name}\n{told}");
        let bytes = size().max(before) + told.len();
        let (kb, of_kb, most) = (peak >> 10, bytes >> 10, bytes / 128 + (32 << 10));
        let of = format!("{of_kb} kB read and written: {command}, {name}");
        let words = format!("{kb} kB of at most {most} for {of}");
        println!("{words}");
        (kb > most).then_some(words)
    });
    assert_eq!(judged.into_iter().flatten().collect::<Vec<String>>(), [""; 0]);
}

/// In all, of inputs of 10³ to 5 · 10⁴ lines (comparisons alone: text/finding.rs, import/located.rs).
#[test]
fn what_is_asked_for_grows_with_the_input_not_with_its_square() {
    const FORM: &str =
        "import x.txt --form f.csv --columns #1=displacement_mm --captures cumulative -o o.csv";
    let said =
        |n: usize| lines(n, |n| format!("# doubt: {n}")) + &fixture("nine_errors_900/errors.csv");
    let form = |n: usize| {
        let rows = lines(n, |k| format!("{},{},+,", k % (n / 2), 1 + 2 * k / n));
        format!("target_mm,run,direction,deviation_um\n{rows}")
    };
    let header = |n: usize| format!("{}\n", ",".repeat(n));
    for (name, text, most, command) in [
        ("errors.csv", &said as &dyn Fn(usize) -> String, 49_000, "report errors.csv -o r.html"),
        ("f.csv", &form, 49_000, FORM),
        ("out/t.csv", &header, 60_000, READ_OUT),
    ] {
        let asked = [1_500, 10_000, most].map(|n| {
            let visit = beside("generic", name, &text(n), command);
            visit.put("x.txt", lines(n - 1, |n| format!("{n}.000")));
            (n as f64, counted(&visit, command).1[1] as f64)
        });
        for pair in asked.windows(2) {
            let exponent = (pair[1].1 / pair[0].1).ln() / (pair[1].0 / pair[0].0).ln();
            assert!(exponent <= 1.15, "{command}: {exponent} from {asked:?}");
        }
    }
}

#[test]
fn nothing_is_written_that_would_be_refused_when_it_is_read() {
    let visit = with_job("generic");
    let job = visit.read("job.toml");
    visit.edit("job.toml", "spacing_mm = ", "spacing_mm = 0.5 # ");
    let most = format!("points, expected at most {MOST_POINTS}");
    run(&visit, "generate job.toml -o kit").ends(2).says(&most);
    assert!(!visit.has("kit"));
    visit.edit("job.toml", "spacing_mm = 0.5", "spacing_mm = 0.75");
    for command in ["generate job.toml -o kit", KIT, "history kit"] {
        run(&visit, command).ends(0);
    }
    let windy = "it was a windy day in the hall, and the door was open; ".repeat(6);
    let doubts = lines(1000, |n| format!("# doubt: {n}: {windy}"));
    visit.put("errors.csv", doubts + &visit.read("errors.csv")).put("job.toml", &job);
    run(&visit, "generate job.toml -o doubtful").ends(2).says("`manifest.json` holds more than");
    assert!(!visit.has("doubtful"));
    let visit = with_job("siemens-840d-sl");
    let program = "\n[program]\nwhat = \"step-diagonal\"\nstart_mm = { x = 0.0, y = 0.0, z = -720.0 }\n\
                   size_mm = { x = 900.0, y = 720.0, z = 720.0 }\nsteps = 360\norder = \"XYZ\"\n\
                   bidirectional = false\n";
    visit.put("job.toml", visit.read("job.toml") + program);
    let simulate = "simulate job.toml --without-tables -o many.csv --runs";
    let many = run(&visit, &format!("{simulate} 100"));
    many.ends(2).says("there would be 432400 readings, expected at most");
    assert!(!visit.has("many.csv"));
    run(&visit, &format!("{simulate} 10")).ends(0);
}

#[test]
fn the_limits_stand_in_the_contract() {
    let page = page("docs/interface.md").split_whitespace().collect::<Vec<_>>().join(" ");
    for limit in [
        format!("{} 000 lines", MOST_LINES / 1000),
        format!("{} 000 rows", MOST_ROWS / 1000),
        format!("{} 000 points", MOST_POINTS / 1000),
        format!("{} KiB", LARGEST_PAGE >> 10),
        format!("{} KiB for a line", LONGEST_LINE_BYTES >> 10),
    ] {
        assert!(page.contains(&limit), "docs/interface.md does not state {limit}");
    }
}
