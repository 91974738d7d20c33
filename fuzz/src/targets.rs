//! What is fuzzed, and the inputs it starts from: the fixtures of the repository, and what the library makes of them.

use crate::bundle::Bundle;
use crate::case::{self, Ran};
use crate::mutate::Dictionary;
use crate::readers::{self, Answer};
use crate::refusals::{self, Case};
use crate::{commands, kits};
use nonius::inputs::job::keys;
use std::path::Path;

/// How a case runs.
#[derive(Clone, Copy)]
pub enum Kind {
    /// A reader of the library, in this process.
    Reader(fn(&[u8]) -> Answer),
    /// The program with a directory.
    Commands,
}

/// One thing that is fuzzed.
pub struct Target {
    /// Its name, also of its folder in `corpus/`.
    pub name: &'static str,
    kind: Kind,
    /// Its share of the time.
    pub share: u32,
    /// Inputs to start from.
    pub seeds: Vec<Vec<u8>>,
    /// The words of these inputs, and the keys of a job.
    pub words: Dictionary,
}

impl Target {
    /// Runs a case; `place` is a directory for files.
    pub fn run(&self, place: &Path, input: &[u8]) -> Ran {
        match self.kind {
            Kind::Reader(reader) => case::read(reader, input),
            Kind::Commands => commands::run(place, input),
        }
    }
}

/// Everything that seeds are taken from.
struct Fixtures {
    /// Directories of inputs, each with the arguments of its command.
    cases: Vec<Bundle>,
    /// Files of the kits of small machines, and their jobs.
    kits: Vec<Bundle>,
}

/// All targets, with their seeds.
pub fn all() -> Vec<Target> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let fixtures = Fixtures::read(&root.join("../fixtures"));
    let target = |name: &'static str, kind: Kind, share: u32, seeds: Vec<Vec<u8>>| {
        let mut corpus = Bundle::default();
        corpus.add_directory(&root.join("corpus").join(name));
        let seeds: Vec<Vec<u8>> =
            corpus.0.into_iter().map(|(_, bytes)| bytes).chain(seeds).collect();
        let keys = keys().map(|(_, key)| key.name.as_bytes());
        let words = Dictionary::of(seeds.iter().map(Vec::as_slice).chain(keys));
        Target { name, kind, share, seeds, words }
    };
    let read =
        |name, reader: fn(&[u8]) -> Answer, seeds| target(name, Kind::Reader(reader), 1, seeds);
    let f = &fixtures;
    let jobs = f.files(|name| name.ends_with("job.toml"));
    let tables = f.files(|name| {
        name.ends_with(".csv") && !name.contains("readings") && !name.contains("runs")
    });
    vec![
        read("job", readers::job, jobs),
        read("profile", readers::profile, profiles(f)),
        read("errors", readers::errors, tables),
        read("readings", kits::readings, f.bundles(|name| name.contains("readings"))),
        read(
            "target-runs",
            readers::target_runs,
            f.files(|name| name.contains("runs.csv") || name == "x_axis.csv"),
        ),
        read("import-rtl", readers::import, f.imports("rtl", ".rtl")),
        read("import-ren", readers::import, f.imports("ren", ".ren")),
        read("import-pos", readers::import, f.imports("pos", ".pos")),
        read("import-etalon", readers::import, f.imports("etalon", ".txt")),
        read("import-isg", readers::import, f.imports("isg", ".csv")),
        read("import-columns", readers::import, f.imports("columns", ".csv")),
        read(
            "siemens",
            readers::siemens,
            f.files(|name| name.ends_with(".MPF") || name.ends_with(".INI")),
        ),
        read("read-out", readers::read_out, read_outs(f)),
        read("fanuc", readers::fanuc, f.files(|name| name.ends_with(".TXT"))),
        read("declared", readers::declared, f.files(|name| name.ends_with(".dat"))),
        read("linuxcnc", readers::linuxcnc, f.kits_with(".comp")),
        read("klipper", readers::klipper, f.files(|name| name.ends_with("skew.cfg"))),
        read("isg", readers::isg, f.kits_with(".lis")),
        read(
            "generic-csv",
            readers::generic_table,
            f.files(|name| name.starts_with("compensation.csv")),
        ),
        read("generic-json", readers::generic_table, f.files(|name| name == "compensation.json")),
        read("nc", readers::nc, programs(f)),
        read("measuring-program", readers::measuring_program, f.measuring_programs()),
        read("program", kits::program, f.bundles(|name| name == "job.toml")),
        read(
            "kit",
            kits::generate,
            f.bundles(|name| name.starts_with("errors") || name.starts_with("readings")),
        ),
        read("verify", kits::verify, f.kits.iter().map(Bundle::bytes).collect()),
        target(
            "commands",
            Kind::Commands,
            3,
            f.cases.iter().map(Bundle::bytes).chain(f.with_kits()).collect(),
        ),
        target("generate", Kind::Commands, 3, f.with_jobs(GENERATE)),
        target("report", Kind::Commands, 2, f.with_jobs(REPORT)),
        target("form", Kind::Commands, 1, f.forms()),
        target("plan", Kind::Commands, 1, f.with_jobs(PLAN)),
        target("own-profile", Kind::Commands, 2, own_profiles(&f.kits)),
    ]
}

impl Fixtures {
    fn read(folder: &Path) -> Fixtures {
        let mut cases = Vec::new();
        cases.extend(refusals::all(folder).into_iter().map(refusal));
        for story in ["diagonals", "start", "paper_004", "machines"] {
            add_cases(&folder.join(story), &mut cases);
        }
        for story in ["machine_h", "standards", "nine_errors_900", "formats"] {
            add_case(&folder.join(story), &mut cases, COMMANDS);
        }
        let kits = kits_of(&folder.join("machines/five_points"));
        Fixtures { cases, kits }
    }

    fn files(&self, is: impl Fn(&str) -> bool) -> Vec<Vec<u8>> {
        let all = self.cases.iter().chain(&self.kits).flat_map(|bundle| &bundle.0);
        let name = |path: &String| path.rsplit('/').next().unwrap_or_default().to_string();
        let mut files: Vec<Vec<u8>> =
            all.filter(|(path, _)| is(&name(path))).map(|(_, bytes)| bytes.clone()).collect();
        files.sort();
        files.dedup();
        files
    }

    /// The files of a control alone, of the kits that have one with this ending.
    fn kits_with(&self, ending: &str) -> Vec<Vec<u8>> {
        let has = |bundle: &&Bundle| bundle.0.iter().any(|(name, _)| name.ends_with(ending));
        let of_control = |(name, _): &&(String, Vec<u8>)| {
            [ending, ".ini", "volcomp.csv"].iter().any(|end| name.ends_with(end))
        };
        let alone = |bundle: &Bundle| {
            let files = bundle.0.iter().filter(of_control).cloned();
            Bundle(files.collect()).bytes()
        };
        self.kits.iter().filter(has).map(alone).collect()
    }

    fn bundles(&self, is: impl Fn(&str) -> bool) -> Vec<Vec<u8>> {
        let with = |bundle: &&Bundle| {
            bundle.file("job.toml").is_some() && bundle.0.iter().any(|(name, _)| is(name))
        };
        let mut all: Vec<Vec<u8>> = self.cases.iter().filter(with).map(without_command).collect();
        all.sort();
        all.dedup();
        all
    }

    /// A file to import behind the options that a case gives for it.
    fn imports(&self, format: &str, end: &str) -> Vec<Vec<u8>> {
        let mut seeds = Vec::new();
        for bundle in &self.cases {
            let command =
                String::from_utf8_lossy(bundle.file("command").unwrap_or_default()).into_owned();
            let fits = format != "columns" || command.contains("--columns") || command.is_empty();
            let files = bundle
                .0
                .iter()
                .filter(|(name, _)| name.ends_with(end) && fits && command.starts_with("import"));
            for (_, bytes) in files {
                for options in OPTIONS.iter().copied().chain([command.as_str()]) {
                    let options = format!("{options} --from {format}").into_bytes();
                    seeds.push(
                        Bundle(vec![
                            ("options".to_string(), options),
                            ("file".to_string(), bytes.clone()),
                        ])
                        .bytes(),
                    );
                }
            }
        }
        seeds
    }

    fn measuring_programs(&self) -> Vec<Vec<u8>> {
        let jobs = self.bundles(|name| name == "job.toml");
        let made = jobs.iter().filter_map(|bundle| {
            let bundle = Bundle::read(bundle);
            let job =
                nonius::text::Source::from_bytes("job.toml", bundle.file("job.toml")?).ok()?;
            let job = nonius::inputs::job::Job::read(job).ok()?;
            let profile =
                nonius::control::controller::builtin::profile(&job.compensation.controller).ok()?;
            nonius::kit::program_kit::make(&job, &profile, &[]).ok()
        });
        let files = made.flat_map(|kit| kit.files.into_iter().map(|file| file.bytes));
        let own = [SIEMENS_PROGRAM, FANUC_PROGRAM, POSITIONS].map(|text| text.as_bytes().to_vec());
        own.into_iter().chain(files).filter(|bytes| bytes.len() < 16 << 10).collect()
    }

    /// A job with its kit in a directory.
    fn with_kits(&self) -> Vec<Vec<u8>> {
        let mut seeds = Vec::new();
        for (command, kit) in
            ON_KITS.iter().flat_map(|command| self.kits.iter().map(move |kit| (*command, kit)))
        {
            let mut case = Bundle(vec![("command".to_string(), command.as_bytes().to_vec())]);
            case.0.extend(kit.0.iter().map(|(name, bytes)| {
                let is_input = name == "job.toml" || name == "errors.csv";
                let folder = if is_input { "" } else { "kit/" };
                (format!("{folder}{name}"), bytes.clone())
            }));
            seeds.push(case.bytes());
        }
        seeds
    }

    /// Jobs that `generate` takes, with commands in turn.
    fn with_jobs(&self, commands: &[&str]) -> Vec<Vec<u8>> {
        let jobs = self.bundles(|name| name.starts_with("errors") || name.starts_with("readings"));
        let extra = [("logo.svg", LOGO), ("own.tera", PAGE), ("after.csv", AFTER)];
        let with = |(index, bytes): (usize, Vec<u8>)| {
            let command = commands[index % commands.len()];
            let named = extra.iter().filter(|(name, _)| command.contains(name));
            let files = std::iter::once(("command", command)).chain(named.copied());
            let files = files.map(|(name, text)| (name.to_string(), text.as_bytes().to_vec()));
            [Bundle(files.collect()).bytes(), bytes].concat()
        };
        let each = jobs.iter().flat_map(|job| commands.iter().map(|_| job.clone()));
        each.enumerate().map(with).collect()
    }

    /// Lists of captures, the form that they go into, and the command.
    fn forms(&self) -> Vec<Vec<u8>> {
        let forms = self.files(|name| name.starts_with("readings") && name.ends_with(".csv"));
        let empty = forms.iter().map(|form| emptied(&String::from_utf8_lossy(form)));
        let list = |count: usize| (0..count).map(|n| format!("{n}.5\n")).collect::<String>();
        let mut seeds = Vec::new();
        for (form, rows) in empty {
            for (command, count) in FORM.iter().zip([rows, rows, rows / 4, rows - rows / 3]) {
                let lists = ["x.txt", "a.txt", "b.txt", "c.txt", "d.txt"];
                let lists = lists.map(|name| (name, list(count))).into_iter();
                let files = [("command", command.to_string()), ("form.csv", form.clone())];
                let files =
                    files.into_iter().chain(lists.filter(|(name, _)| command.contains(name)));
                let files = files.map(|(name, text)| (name.to_string(), text.into_bytes()));
                seeds.push(Bundle(files.collect()).bytes());
            }
        }
        seeds
    }
}

/// A form without what was read, and how many of its rows wait for it.
fn emptied(form: &str) -> (String, usize) {
    let mut rows = 0;
    let mut cut = |line: &str| {
        let is_row = line.starts_with(|c: char| c.is_ascii_digit() || "PN".contains(c));
        rows += usize::from(is_row);
        match line.rsplit_once(',') {
            Some((rest, _)) if is_row => format!("{rest},\n"),
            _ => format!("{line}\n"),
        }
    };
    let text = form.lines().map(&mut cut).collect();
    (text, rows)
}

/// Controls of a user's own: a profile that names files by patterns, and a folder with files of such names.
fn own_profiles(kits: &[Bundle]) -> Vec<Vec<u8>> {
    fn own(kit: &Bundle) -> Option<(String, String, &Bundle)> {
        let job = String::from_utf8_lossy(kit.file("job.toml")?).into_owned();
        let (_, rest) = job.split_once("controller = \"")?;
        let id = rest.split('"').next()?;
        let page = nonius::control::controller::builtin::page(id)?;
        let is_other =
            page.contains("dialect = \"declared\"") || page.contains("dialect = \"generic\"");
        let job = job.replace(&format!("\"{id}\""), "\"./own.toml\"");
        is_other.then(|| (job, page.to_string(), kit))
    }
    let mut seeds = Vec::new();
    for (job, page, kit) in kits.iter().filter_map(own) {
        for command in OF_OWN_PROFILE {
            let texts = [("command", command), ("own.toml", &page), ("job.toml", &job)];
            let mut files: Vec<(String, Vec<u8>)> = texts
                .iter()
                .map(|(name, text)| (name.to_string(), text.as_bytes().to_vec()))
                .collect();
            for (name, bytes) in kit.0.iter().filter(|(name, _)| name != "job.toml") {
                let folder = if name == "errors.csv" { "" } else { "kit/" };
                files.push((format!("{folder}{name}"), bytes.clone()));
            }
            seeds.push(Bundle(files).bytes());
        }
    }
    seeds
}

fn without_command(bundle: &Bundle) -> Vec<u8> {
    let files = bundle.0.iter().filter(|(name, _)| name != "command");
    Bundle(files.cloned().collect()).bytes()
}

/// What a service engineer may ask of a directory of the fixtures.
const COMMANDS: &[&str] = &[
    "generate job.toml -o kit",
    "separate job.toml -o errors.csv",
    "separate job.toml --format json",
    "simulate job.toml -o simulated.csv --noise-um 0.5",
    "assess job.toml",
    "assess job.toml --format json",
    "program job.toml -o programs",
    "standards x_axis.csv --unit um",
    "standards job.toml",
    "context job.toml",
    "path job.toml part.nc -o points.csv",
    "import rtl_linear_bidirectional_selfmade.rtl -o x.csv --axis x --term EXX --sign as-error --first-target-at-mm 0 --targets-run + --material-corrected yes",
    "controllers show fanuc-30i",
];

/// What may be asked of a job with its kit.
const ON_KITS: [&str; 9] = [
    "report job.toml --tables kit -o page.html",
    "report job.toml --tables kit --after errors.csv -o page.html --explain",
    "generate job.toml -o kit --force --compare",
    "verify job.toml --tables kit",
    "verify job.toml --tables kit --format json",
    "verify job.toml --tables kit --after errors.csv",
    "history kit",
    "assess job.toml --tables kit",
    "simulate job.toml --tables kit --errors -o after.csv",
];

/// What makes kits.
const GENERATE: &[&str] = &[
    "generate job.toml -o kit",
    "generate job.toml -o kit --compare",
    "generate job.toml -o kit --plot kit.svg",
    "generate job.toml -o kit --force --format json --explain",
];

/// What makes a page.
const REPORT: &[&str] = &[
    "report job.toml -o page.html",
    "report errors.csv -o page.html --logo logo.svg",
    "report job.toml -o page.html --language de --unit inch --logo logo.svg",
    "report job.toml -o page.html --template own.tera --language zh",
    "report job.toml -o page.html --linear x_axis.csv --format json",
    "report job.toml -o page.html --after after.csv",
    "report job.toml -o page.html --after job.toml",
];

/// What comes before a kit, and behind it.
const PLAN: &[&str] = &[
    "plan job.toml",
    "new --controller siemens-840d-sl --travel 400,300,200 -o made",
    "new --controller fanuc-30i --travel 20in,-10in,250 --readings --both-directions --steps 9 -o made",
    "new --from job.toml -o made",
    "simulate job.toml --errors -o after.csv",
    "verify job.toml --tables kit --after after.csv --plot after.svg",
    "separate job.toml --plot separated.svg --trials 20",
    "assess job.toml --plot assessed.svg --grid 3,4,5 --histogram 1 --grouping 0.5",
    "program job.toml -o run --force",
    "assess job.toml --grid 5,5,5 --window 100,100,100",
    "path job.toml part.nc --with-tables --plot path.svg -o path.csv",
    "standards x_axis.csv --plot axis.svg",
    "generate job.toml --compare",
];

/// What fills a form.
const FORM: [&str; 4] = [
    "import x.txt --form form.csv --columns #1=displacement_mm --captures cumulative -o filled.csv",
    "import x.txt --form form.csv --columns #1=displacement_mm --captures incremental -o form.csv --force",
    "import --form form.csv --ppp a.txt --npp b.txt --pnp c.txt --ppn d.txt --columns #1=displacement_mm --captures cumulative -o filled.csv",
    "import x.txt --form form.csv --columns #1=displacement_mm --captures cumulative -o filled.csv --format json",
];

/// What reads and writes by the patterns of a profile.
const OF_OWN_PROFILE: [&str; 4] = [
    "controllers check ./own.toml",
    "verify job.toml --tables kit",
    "generate job.toml -o made --compare",
    "controllers show ./own.toml",
];

const LOGO: &str =
    "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 2 1\"><path d=\"M0 0h2v1z\"/></svg>\n";
const PAGE: &str = "<!DOCTYPE html><title>{{ title }}</title>\n{% for row in rows %}<p>{{ row }}</p>{% endfor %}\n";
const AFTER: &str = "axis,position_mm,exx_um\nx,0,0.5\nx,100,-0.5\nx,200,1.5\n";

/// Options under which the files of `fixtures/formats` can be imported.
const OPTIONS: [&str; 4] = [
    "--axis x --term EXX --first-target-at-mm 0 --targets-run + --sign as-error --material-corrected yes",
    "--sign as-correction --direction both --axis y --term EYY --values absolute --unit um",
    "--sign as-error --plus-moves + --runs bidirectional",
    "--columns #1=position_mm,#2=ex_um --axis x --direction + --unit um --decimal point",
];

fn add_cases(folder: &Path, cases: &mut Vec<Bundle>) {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<_> =
        entries.map(|entry| entry.path()).filter(|path| path.is_dir()).collect();
    paths.sort();
    for path in paths {
        add_case(&path, cases, COMMANDS);
    }
}

/// A refusal: its command, then its inputs.
fn refusal(case: Case) -> Bundle {
    let mut bundle = Bundle(vec![("command".to_string(), case.command.into_bytes())]);
    bundle.add(case.files);
    bundle
}

/// A directory, once for every command; a directory with jobs of other names once for each of them.
fn add_case(directory: &Path, cases: &mut Vec<Bundle>, commands: &[&str]) {
    let mut files = Bundle::default();
    files.add_directory(directory);
    files.0.retain(|(name, _)| !["expected.json", "README.md"].contains(&name.as_str()));
    let is_job = |(name, bytes): &&(String, Vec<u8>)| {
        name.ends_with(".toml") && bytes.windows(9).any(|part| part == b"[machine]")
    };
    let jobs: Vec<(String, Vec<u8>)> = files.0.iter().filter(is_job).cloned().collect();
    files.0.retain(|file| !jobs.contains(file));
    for command in commands {
        for job in jobs.iter().map(Some).chain(jobs.is_empty().then_some(None)) {
            let mut case = files.clone();
            case.0.extend(job.map(|(_, bytes)| ("job.toml".to_string(), bytes.clone())));
            case.0.insert(0, ("command".to_string(), command.as_bytes().to_vec()));
            cases.push(case);
        }
    }
}

/// The kits of the jobs in a directory, each with job, errors and manifest.
fn kits_of(folder: &Path) -> Vec<Bundle> {
    let mut cases = Vec::new();
    add_case(folder, &mut cases, &["generate"]);
    let mut kits = Vec::new();
    for case in cases {
        let inputs = kits::inputs_of(&case);
        let Ok(kit) = inputs.and_then(|inputs| nonius::kit::generate(&inputs)) else {
            continue;
        };
        let mut bundle = Bundle(case.0.into_iter().filter(|(name, _)| name != "command").collect());
        bundle.0.extend(kit.files.iter().map(|file| (file.path.clone(), file.bytes.clone())));
        bundle
            .0
            .extend(kit.manifest_bytes().ok().map(|bytes| ("manifest.json".to_string(), bytes)));
        kits.push(bundle);
    }
    kits
}

fn profiles(fixtures: &Fixtures) -> Vec<Vec<u8>> {
    use nonius::control::controller::builtin::{ids, page};
    let own = fixtures.cases.iter().filter_map(|case| {
        let is_profile = |name: &str| name.ends_with(".toml") && name != "job.toml";
        let mut files: Vec<(String, Vec<u8>)> = case
            .0
            .iter()
            .filter(|(name, _)| is_profile(name) || name.ends_with(".tera"))
            .cloned()
            .collect();
        files.sort_by_key(|(name, _)| !is_profile(name));
        (!files.is_empty()).then(|| Bundle(files).bytes())
    });
    let built_in = ids()
        .into_iter()
        .filter_map(page)
        .map(|page| Bundle(vec![("own.toml".to_string(), page.as_bytes().to_vec())]).bytes());
    own.chain(built_in).collect()
}

/// Read out of controls: the cases' own, files of kits, and the beginning of an archive.
fn read_outs(fixtures: &Fixtures) -> Vec<Vec<u8>> {
    let mut seeds = fixtures.files(|name| name.ends_with(".arc") || name.ends_with(".MPF"));
    seeds.push(b"@@MMCIBN.002".to_vec());
    seeds
}

fn programs(fixtures: &Fixtures) -> Vec<Vec<u8>> {
    let own = fixtures.files(|name| name.ends_with(".nc"));
    own.into_iter().chain(PROGRAMS.iter().map(|text| text.as_bytes().to_vec())).collect()
}

const PROGRAMS: &[&str] = &[
    "%\nO1\nG21 G90 G94 G17 G40 G49 G80\nT1 M6\nG54 G0 X0 Y0\nG43 H1 Z50.\nS1000 M3\nG1 Z-1. F100\nG2 X10. Y0 I5. J0\nG3 X0 Y0 R5.\nG18 G2 X10. Z1. I5. K0\nG91 G1 X1. Y1.\nG90 G28 Z0\nM98 P2 L3\nM30\nO2\nG91 G1 X1.\nM99\n%\n",
    "G20\nG55 G0 X1 Y1\nG81 X2. Y2. Z-1. R1. F10.\nX3.\nG83 X1. Y1. Z-2. R1. Q.1\nG73 X1. Y1. Z-2. R1. Q.1 K3\nG80\nG53 G0 Z0\nG92 X0\nG52 X1.\nG10 L2 P1 X1.\n/G1 X1. F5\nG4 P1\nG61\nG54.1 P48\nM2\n",
    "(COMMENT) N10 G17 G2 X0. Y0. I1. J1. P3 Z1. F1\n#1=5\nX[#1+2]\nG68 X0 Y0 R45.\nG51.1 X0\nG41 D1\nG43.4 H1\nG30 P2 Z0\nM00\n",
];
const SIEMENS_PROGRAM: &str = "; MEASURING RUN\nMSG(\"A\")\nM0\nG500\nD0\nTRAFOOF\nTRANS\nROT\nSCALE\nMIRROR\nG17 G40 G60 G94 G710\nSUPA G90 G0 X97.000 Y-77.000\nSUPA G91 G1 X-2.000 Y2.000 Z2.000 F1000.0\nN1 G4 F3.0\nM30\n";
const FANUC_PROGRAM: &str = "%\nO4004 (NONIUS PPN)\nM00 (A)\nG21\nG40 G49 G80\nG69\nG50\nG50.1 X0 Y0 Z0\nG17 G61 G94\nG90 G00 G53 X3.000 Y-77.000\nG91 G01 X2.000 Y2.000 Z-2.000 F1000.0\nN1 G04 X3.0\nM30\n%\n";
const POSITIONS: &str = "diagonal,run,direction,node,moved,nominal_mm,x_mm,y_mm,z_mm,block\nPPP,1,forward,0,,0,5,-75,-55,1\nPPP,1,reverse,6,y,158.429795,95,-5,55,8\n";
