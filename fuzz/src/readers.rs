//! One case for each reader of the library, in this process. The answer is the text that the reader's result or
//! refusal comes to; src/case.rs judges it.

use crate::bundle::Bundle;
use clap::ValueEnum;
use nonius::control::controller::{
    Dialect, FanucFacts, KitFile, Profile, ProfileSource, Role, builtin, load,
};
use nonius::inputs::error_table::{ErrorTable, Remarks};
use nonius::inputs::import::stated::{ImportFacts, axis_word, direction_word};
use nonius::inputs::import::{
    Component, Measurement, encoding_word, import as import_file, measured_runs,
};
use nonius::inputs::job::{Job, UseOf};
use nonius::inputs::problems;
use nonius::inputs::target_runs::{RunFacts, Runs, Values};
use nonius::machine::standards::{iso_230_2, vdi_3441};
use nonius::read::{
    fanuc as read_fanuc, generic, program as read_program, siemens as read_siemens,
};
use nonius::text::{LengthUnit, Problem, Problems, Source};
use part_program::{G43WithoutH, Language, Line, Mark, Refused, Setup, Text, WithoutPoint, run};
use std::sync::OnceLock;

/// What a reader answered, in words.
pub type Answer = Result<String, Problems>;

/// A job, for tables and for figures.
pub fn job(input: &[u8]) -> Answer {
    let figures = Job::read_for(Source::from_bytes("job.toml", input)?, UseOf::Figures);
    let job = Job::read(Source::from_bytes("job.toml", input)?)?;
    figures.map(|_| format!("{:?}", job.measurement.data))
}

/// A profile with its templates; the first file is the profile.
pub fn profile(input: &[u8]) -> Answer {
    let profile = profile_of(&Bundle::read(input), None)?;
    Ok(format!("{} {}", profile.id, profile.statements.len()))
}

/// A profile of a bundle, by its name; the first file that is one without a name.
pub fn profile_of(bundle: &Bundle, name: Option<&str>) -> Result<Profile, Problems> {
    let first = bundle.0.first().map_or("", |(name, _)| name.as_str());
    let name = name.unwrap_or(first);
    let bytes = bundle.file(name).ok_or_else(|| Problem::new("no such profile"))?;
    let own =
        |name: &str| bundle.file(name).and_then(|bytes| String::from_utf8(bytes.to_vec()).ok());
    let template = |name: &str, is_own: bool| {
        own(name).filter(|_| is_own).map(Into::into).or_else(|| builtin::template(name))
    };
    load::profile(
        Source::from_bytes(name, bytes)?,
        ProfileSource::File(name.to_string()),
        &template,
        &builtin::page,
    )
}

/// An error table.
pub fn errors(input: &[u8]) -> Answer {
    let source = Source::from_bytes("errors.csv", input)?;
    let remarks = Remarks::read(&source.text).lines();
    let table = ErrorTable::read(source)?;
    let again = ErrorTable::merged(vec![table])?;
    Ok(format!("{} {}", again.is_some(), remarks.len()))
}

/// Runs of one axis, in every way that they can be stated, and the figures of the standards.
pub fn target_runs(input: &[u8]) -> Answer {
    let mut answer = String::new();
    for unit in [None, Some(LengthUnit::Um), Some(LengthUnit::Mm)] {
        for values in [None, Some(Values::Positions), Some(Values::Deviations)] {
            let source = Source::from_bytes("runs.csv", input)?;
            match Runs::read(&source, RunFacts { unit, values }) {
                Ok(runs) => answer += &figures(&runs)?,
                Err(problems) => answer += &problems.render(),
            }
        }
    }
    Ok(answer)
}

fn figures(runs: &Runs) -> Answer {
    let travel = iso_230_2::Travel::of(runs, None)?;
    let (figures, conditions) = (iso_230_2::figures(runs), iso_230_2::conditions(runs, travel));
    let (remarks, others) = (iso_230_2::remarks(runs, travel), vdi_3441::figures(runs));
    Ok(format!("{figures:?} {conditions:?} {remarks:?} {others:?}"))
}

/// A measurement of another maker: `=== options` with the options of `import`, then the file.
pub fn import(input: &[u8]) -> Answer {
    let bundle = Bundle::read(input);
    let options = String::from_utf8_lossy(bundle.file("options").unwrap_or_default()).into_owned();
    let bytes = bundle.0.last().map_or(&[][..], |(_, bytes)| bytes);
    let file = Measurement { path: "x", name: "x", sha256: "0", bytes };
    let mut stated = ImportFacts::default();
    let words: Vec<&str> = options.split_whitespace().collect();
    for pair in words.windows(2) {
        match pair[0] {
            "--from" => stated.from = choice(pair[1]),
            "--encoding" => stated.encoding = encoding_word(pair[1]).ok(),
            option => state(&mut stated, option, pair[1]),
        }
    }
    let single = ImportFacts { columns: None, ..stated.clone() };
    let runs = measured_runs(file, &single).is_ok();
    let imported = import_file(file, &stated)?;
    // Findings are made fit for a terminal where they are printed; the target `commands` looks at that.
    let findings = imported.findings.len();
    Ok(format!("{}\n{findings} {runs}", imported.text))
}

fn choice<T: ValueEnum>(word: &str) -> Option<T> {
    T::from_str(word, false).ok()
}

fn state(stated: &mut ImportFacts, option: &str, word: &str) {
    match option {
        "--axis" => stated.axis = axis_word(word).ok(),
        "--term" => stated.term = Component::from_name(word),
        "--first-target-at-mm" => {
            stated.first_target_at_mm = word.parse().ok().filter(|mm: &f64| mm.abs() <= 1e6)
        }
        "--targets-run" => stated.targets_run = direction_word(word).ok(),
        "--direction" => stated.travel = choice(word),
        "--plus-moves" => stated.plus_moves = direction_word(word).ok(),
        "--sign" => stated.sign = choice(word),
        "--unit" => stated.unit = choice(word),
        "--values" => stated.values = choice(word),
        "--runs" => stated.runs = choice(word),
        "--material-corrected" => stated.material_corrected = choice(word),
        "--decimal" => stated.decimal = choice(word),
        "--columns" => stated.columns = Some(word.to_string()),
        _ => {}
    }
}

/// A Siemens file: as a kit's, and as one of a control.
pub fn siemens(input: &[u8]) -> Answer {
    let source = Source::from_bytes("x.mpf", input)?;
    let read_out =
        read_siemens::read_out("x.mpf", &source.text, true).map(|contents| contents.notes);
    let contents = read_siemens::read("x.mpf", &source.text)?;
    let merged = read_siemens::merge(vec![contents])?;
    Ok(format!("{:?} {:?}", merged.notes, read_out.is_ok()))
}

/// What was read out of a control.
pub fn read_out(input: &[u8]) -> Answer {
    let facts = fanuc_facts()?;
    let text = nonius::read::read_out_text(&built_in("siemens-840d-sl")?, "x.txt", input)?;
    let siemens = match read_siemens::read_out("x.txt", &text, true) {
        Ok(contents) => format!("{:?}", contents.notes),
        Err(problems) => problems.render(),
    };
    let fanuc = read_fanuc::read_out("x.txt", &text, &facts, CONTROL_UNIT)
        .map_or_else(|problems| problems.render(), |_| String::new());
    read_siemens::has_active_data("x.txt", &text);
    Ok(siemens + &fanuc)
}

const CONTROL_UNIT: nonius::control::controller::ControlUnit =
    nonius::control::controller::ControlUnit::Millimetre;

/// A built-in profile; each is read once, before the first case counts.
pub fn built_in(id: &str) -> Result<Profile, Problems> {
    static READ: OnceLock<Vec<Profile>> = OnceLock::new();
    let all = READ.get_or_init(|| {
        let profiles = builtin::ids().into_iter().map(builtin::profile);
        profiles.filter_map(Result::ok).collect()
    });
    match all.iter().find(|profile| profile.id == id) {
        Some(profile) => Ok(profile.clone()),
        None => builtin::profile(id),
    }
}

fn fanuc_facts() -> Result<FanucFacts, Problems> {
    match built_in("fanuc-30i")?.dialect {
        Dialect::Fanuc(facts) => Ok(facts),
        _ => Err(Problem::new("no profile of Fanuc").into()),
    }
}

/// A Fanuc parameter file.
pub fn fanuc(input: &[u8]) -> Answer {
    let facts = fanuc_facts()?;
    let source = Source::from_bytes("x.txt", input)?;
    let read_out = read_fanuc::read_out("x.txt", &source.text, &facts, CONTROL_UNIT).is_ok();
    let memory = read_fanuc::read("x.txt", &source.text, &facts)?;
    read_fanuc::merge(vec![memory.clone(), memory]).map(|_| format!("{read_out}"))
}

/// What the reader of a control makes of files of a kit.
fn kit<'a>(id: &str, files: impl Iterator<Item = (&'a str, &'a [u8])>) -> Answer {
    let role = Role::Table;
    let files =
        files.map(|(path, bytes)| KitFile { path: path.to_string(), role, bytes: bytes.to_vec() });
    let read = nonius::read::read(&built_in(id)?, &files.collect::<Vec<_>>())?;
    // What is said of names passes this on its way to a person.
    Ok(nonius::text::page(&format!("{read:?}")).into_owned())
}

/// The same of the parts of a bundle.
fn bundle(id: &str, input: &[u8]) -> Answer {
    let parts = Bundle::read(input).0;
    kit(id, parts.iter().map(|(path, bytes)| (&**path, &**bytes)))
}

/// The ini lines of a machine, the tables that they name and a HAL file: the parts of a bundle.
pub fn linuxcnc(input: &[u8]) -> Answer {
    bundle("linuxcnc-hal", input)
}

/// A file of a control whose profile declares it.
pub fn declared(input: &[u8]) -> Answer {
    kit("weihong", std::iter::once(("axeserr.dat", input)))
}

/// The list of a volumetric compensation and its parameter files: the parts of a bundle.
pub fn isg(input: &[u8]) -> Answer {
    bundle("isg-volcomp", input)
}

/// A configuration of Klipper.
pub fn klipper(input: &[u8]) -> Answer {
    kit("klipper-skew", std::iter::once(("printer.cfg", input)))
}

/// The generic table.
pub fn generic_table(input: &[u8]) -> Answer {
    let source = Source::from_bytes("x", input)?;
    let table = generic::read("x", &source.text)?;
    generic::merge(vec![table.clone(), table]).map(|rows| rows.len().to_string())
}

/// A part program of a measuring run, in every language, and the list of positions.
pub fn measuring_program(input: &[u8]) -> Answer {
    let mut answer = String::new();
    for id in ["siemens-840d-sl", "fanuc-30i", "linuxcnc"] {
        let profile = built_in(id)?;
        let Some(facts) = &profile.program else {
            continue;
        };
        let words = read_program::OwnWords {
            letters: &facts.axis_letters.value,
            seconds: facts.dwell_address(),
        };
        answer += &match read_program::read(facts.language, &words, "x.mpf", input) {
            Ok(steps) => steps.len().to_string(),
            Err(problems) => problems.render(),
        };
    }
    let rows = read_program::walk::read("positions.csv", input)?;
    Ok(format!("{answer} {}", rows.len()))
}

/// A part program of a user, up to some thousand moves.
pub fn nc(input: &[u8]) -> Answer {
    let setup = Setup {
        language: if input.len() % 7 == 6 { Language::Siemens } else { Language::Iso },
        start: [100.0, 100.0, 0.0],
        reference: [0.0; 3],
        second_reference: Some([0.0; 3]),
        systems: [(1, [100.0, 100.0, -50.0]), (2, [0.0; 3]), (148, [1.0; 3])].into_iter().collect(),
        tools: [(1, 100.0), (2, 50.0)].into_iter().collect(),
        tool_names: [("A".to_string(), 1)].into_iter().collect(),
        inch: Some(input.len() % 5 == 4),
        without_point: if input.len().is_multiple_of(2) {
            WithoutPoint::Unit
        } else {
            WithoutPoint::Increment
        },
        g43_without_h: if input.len().is_multiple_of(3) {
            G43WithoutH::LastH
        } else {
            G43WithoutH::Tool
        },
        arc_mm: None,
        skip_deletable: input.len().is_multiple_of(7),
    };
    let (mut length, mut moves) = (0.0, 0);
    let mut lines = Lines { bytes: input, at: Mark::default(), left: 20_000 };
    let ran = run(&mut lines, &setup, |step| {
        moves += 1;
        length += step.length_mm() + step.at(0.5)[0].abs();
        let enough = || Refused::new("enough moves").help("stop");
        if moves > 5000 { Err(enough()) } else { Ok(()) }
    })
    .map_err(|refused| problems("x.nc", refused))?;
    Ok(format!("{length} {ran:?}"))
}

/// As `src/cli/path/program_text.rs` has it.
const LONGEST_LINE: usize = 4096;

/// A program in memory that ends after some thousand lines, however often it goes back.
struct Lines<'a> {
    bytes: &'a [u8],
    at: Mark,
    left: usize,
}

impl Text for Lines<'_> {
    fn next_line(&mut self) -> Result<Option<Line<'_>>, Refused> {
        let rest = &self.bytes[(self.at.bytes as usize).min(self.bytes.len())..];
        if rest.is_empty() || self.left == 0 {
            return Ok(None);
        }
        let end = rest.iter().position(|byte| *byte == b'\n');
        let line = &rest[..end.unwrap_or(rest.len())];
        if line.len() > LONGEST_LINE {
            return Err(Refused::new("a longer line than `path` reads"));
        }
        self.at.bytes += end.map_or(rest.len(), |end| end + 1) as u64;
        self.at.lines += 1;
        self.left -= 1;
        Ok(Some(Line { number: self.at.lines, bytes: line.strip_suffix(b"\r").unwrap_or(line) }))
    }

    fn mark(&self) -> Mark {
        self.at
    }

    fn go_to(&mut self, mark: Mark) -> Result<(), Refused> {
        self.at = mark;
        Ok(())
    }
}
