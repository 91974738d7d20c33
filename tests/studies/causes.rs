//! Faults put into the control, the machine measured again, and what `verify --after` names.
//!
//! The faults act here on the emulated corrections of the bytes that were written, with code of
//! this test; the program sees nothing but the job, the kit and the second measurement. Asked is
//! that the true cause is in the named set, that sets are small where the data allow it, and that
//! a second measurement without fault names none. The table of all runs stands in docs/accuracy.md;
//! `NONIUS_UPDATE=1 cargo test --test causes` writes it.
use crate::support;
use crate::support::published::published;
use crate::support::{Lines, Random, generate, loaded};
use nonius::kit::{self, Inputs, Kit};
use nonius::quantity::axis::{Axis, Direction, ErrorTerm};
use nonius::quantity::diagonal::{Diagonal, Pass, PathKind, Volume};
use nonius::quantity::units::Millimetres;
use nonius::read::emulate::Emulator;
use nonius::write::plan::axis_pairs;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

/// Noise of both measurements, µm.
const NOISE_UM: f64 = 0.15;
/// Expansion that the program takes where no job states one, 1/K.
const STEEL_PER_K: f64 = 11.5e-6;

/// What is done to the control or the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Injected {
    Nothing,
    Times(Which, f64),
    Shifted([f64; 3]),
    AxesExchanged([Axis; 3]),
    Transposed,
    OutputsExchanged,
    BacklashTwice,
    BacklashNot,
    DirectionsExchanged,
    /// A table of somebody else acts on X beside those of the kit.
    ForeignTable,
    Warmer([f64; 3]),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Which {
    All,
    Positioning,
    Cross,
    Along(Axis),
    Of(Axis),
    Only(Axis, Axis),
}

impl Which {
    fn holds(self, term: ErrorTerm) -> bool {
        match self {
            Which::All => true,
            Which::Positioning => term.of == term.along,
            Which::Cross => term.of != term.along,
            Which::Along(axis) => term.along == axis,
            Which::Of(axis) => term.of == axis,
            Which::Only(of, along) => term.of == of && term.along == along,
        }
    }
}

impl Injected {
    /// The word by which the program has to name it.
    fn kind(self) -> &'static str {
        match self {
            Injected::Nothing => "no fault",
            Injected::Times(_, -1.0) => "sign turned",
            Injected::Times(_, 0.0) => "not active",
            Injected::Times(_, 2.0) => "applied twice",
            Injected::Times(_, 0.5) => "other factor",
            Injected::Times(..) => "wrong unit",
            Injected::Shifted(_) => "shifted",
            Injected::AxesExchanged(_) | Injected::Transposed | Injected::OutputsExchanged => {
                "wrong axis"
            }
            Injected::BacklashTwice => "backlash twice",
            Injected::BacklashNot => "backlash not",
            Injected::DirectionsExchanged => "directions exchanged",
            Injected::ForeignTable => "unknown",
            Injected::Warmer(_) => "temperature",
        }
    }
}

/// How the machine is measured the second time.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Second {
    Table,
    TableWithoutU,
    StraightDiagonals,
}

/// A machine with its kit.
struct Rig {
    name: &'static str,
    inputs: Inputs,
    kit: Kit,
    truth: BTreeMap<(String, &'static str), Lines>,
    both_ways: bool,
    second: Second,
    job: String,
    directory: tempfile::TempDir,
}

struct Plan {
    name: &'static str,
    controller: &'static str,
    terms: &'static [&'static str],
    backlash: Option<&'static str>,
    second: Second,
    seed: u64,
}

const NINE: [&str; 9] = ["EXX", "EYX", "EZX", "EXY", "EYY", "EZY", "EXZ", "EYZ", "EZZ"];
const RIGS: [Plan; 7] = [
    Plan {
        name: "840D sl, nine terms",
        controller: "siemens-840d-sl",
        terms: &NINE,
        backlash: None,
        second: Second::Table,
        seed: 1,
    },
    Plan {
        name: "828D, nine terms, two tables",
        controller: "siemens-828d",
        terms: &NINE,
        backlash: Some("two-tables"),
        second: Second::Table,
        seed: 2,
    },
    Plan {
        name: "30i, nine terms",
        controller: "fanuc-30i",
        terms: &NINE,
        backlash: None,
        second: Second::Table,
        seed: 3,
    },
    Plan {
        name: "0i-F, three terms, curve and parameter",
        controller: "fanuc-0i-f",
        terms: &["EXX", "EYY", "EZZ"],
        backlash: Some("curve-and-parameter"),
        second: Second::Table,
        seed: 4,
    },
    Plan {
        name: "generic, nine terms, mean",
        controller: "generic",
        terms: &NINE,
        backlash: Some("mean"),
        second: Second::Table,
        seed: 5,
    },
    Plan {
        name: "840D sl, U not stated",
        controller: "siemens-840d-sl",
        terms: &NINE,
        backlash: None,
        second: Second::TableWithoutU,
        seed: 6,
    },
    Plan {
        name: "840D sl, straight diagonals",
        controller: "siemens-840d-sl",
        terms: &NINE,
        backlash: None,
        second: Second::StraightDiagonals,
        seed: 7,
    },
];

const LENGTHS: [(Axis, f64, f64); 3] =
    [(Axis::X, 0.0, 900.0), (Axis::Y, 0.0, 600.0), (Axis::Z, -480.0, 480.0)];

fn gauss(random: &mut Random) -> f64 {
    (0..12).map(|_| random.between(0.0, 1.0)).sum::<f64>() - 6.0
}

/// A wavy curve with a slope, and its reversal.
fn curve(random: &mut Random, term: &str, low: f64, length: f64, reversal: f64) -> Lines {
    let size = if term.as_bytes()[1] == term.as_bytes()[2] { 1.0 } else { 0.5 };
    let (a, b, slope) =
        (random.between(4.0, 7.0), random.between(1.5, 3.0), random.between(-14.0, 14.0));
    let (p, q) = (random.between(0.0, 6.2), random.between(0.0, 6.2));
    let mm: Vec<f64> = (0..=30).map(|i| low + length * f64::from(i) / 30.0).collect();
    let wave = |x: f64| {
        let t = (x - low) / length * std::f64::consts::TAU;
        size * (a * (1.6 * t + p).sin() + b * (3.7 * t + q).sin() + slope * (x - low) / 1000.0)
            + reversal
    };
    let um = mm.iter().map(|x| wave(*x)).collect();
    Lines { mm, um }
}

fn rig(plan: &Plan) -> Rig {
    let mut random = Random::new(plan.seed);
    let both_ways = plan.backlash.is_some();
    let ways: &[&str] = if both_ways { &["+", "-"] } else { &[""] };
    let mut truth = BTreeMap::new();
    for term in plan.terms {
        let along = Axis::from_letter(&term[2..]).unwrap();
        let (_, low, length) = LENGTHS.into_iter().find(|(axis, ..)| *axis == along).unwrap();
        let own = random.below(1_000_000) as u64;
        for way in ways {
            let reversal =
                if *way == "-" && term.as_bytes()[1] == term.as_bytes()[2] { 6.0 } else { 0.0 };
            truth.insert(
                (term.to_string(), *way),
                curve(&mut Random::new(own), term, low, length, reversal),
            );
        }
    }
    let with_u = plan.second != Second::TableWithoutU;
    let job = job_text(plan, with_u);
    let csv = table(&truth, ways, with_u, |_, _, _, um| um + NOISE_UM * gauss(&mut random));
    let (inputs, kit) = generate(&job, &csv);
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("job.toml"), &job).unwrap();
    std::fs::write(directory.path().join("errors.csv"), &csv).unwrap();
    run(directory.path(), &["generate", "job.toml", "-o", "kit"]).unwrap();
    Rig { name: plan.name, inputs, kit, truth, both_ways, second: plan.second, job, directory }
}

fn job_text(plan: &Plan, with_u: bool) -> String {
    let mut text = String::from("schema = 1\n[machine]\nname = \"rig\"\n");
    for (axis, low, length) in LENGTHS {
        let high = low + length;
        writeln!(
            text,
            "[machine.axes.{}]\ntravel_mm = [{low:?}, {high:?}]\nreference_mm = 0.0",
            axis.key()
        )
        .unwrap();
    }
    text.push_str("[measurement]\nerrors = \"errors.csv\"\nactive_while_measuring = \"none\"\n");
    if with_u {
        writeln!(text, "[measurement.uncertainty]\nnoise_um = {NOISE_UM}").unwrap();
    }
    writeln!(text, "[compensation]\ncontroller = \"{}\"", plan.controller).unwrap();
    if let Some(policy) = plan.backlash {
        writeln!(text, "backlash = \"{policy}\"").unwrap();
    }
    for (axis, _, length) in LENGTHS {
        writeln!(text, "[compensation.axes.{}]\nspacing_mm = {:?}", axis.key(), length / 30.0)
            .unwrap();
        if plan.controller.starts_with("fanuc") {
            text.push_str("detection_unit_um = 0.1\n");
        }
    }
    text.push_str("[acceptance]\nmax_deviation_um = 3.0\nmax_diagonal_um = 6.0\n");
    text
}

/// An error table; `value` gets term, direction, position and the true deviation.
fn table(
    truth: &BTreeMap<(String, &'static str), Lines>,
    ways: &[&str],
    with_u: bool,
    mut value: impl FnMut(ErrorTerm, &str, f64, f64) -> f64,
) -> String {
    let mut csv = String::from("axis,direction,position_mm,ex_um,ey_um,ez_um");
    csv.push_str(if with_u { ",u_ex_um,u_ey_um,u_ez_um\n" } else { "\n" });
    for along in Axis::ALL {
        for way in ways {
            let of = |of: Axis| {
                truth.iter().find(|((name, w), _)| {
                    *name == (ErrorTerm { of, along }).to_string() && w == way
                })
            };
            let Some(mm) = Axis::ALL.into_iter().find_map(&of).map(|(_, lines)| lines.mm.clone())
            else {
                continue;
            };
            for x in mm {
                write!(csv, "{},{way},{x}", along.key()).unwrap();
                for direction in Axis::ALL {
                    match of(direction) {
                        Some((_, lines)) => write!(
                            csv,
                            ",{:.6}",
                            value(ErrorTerm { of: direction, along }, way, x, lines.at(x))
                        )
                        .unwrap(),
                        None => csv.push(','),
                    }
                }
                if with_u {
                    for direction in Axis::ALL {
                        match of(direction) {
                            Some(_) => write!(csv, ",{NOISE_UM}").unwrap(),
                            None => csv.push(','),
                        }
                    }
                }
                csv.push('\n');
            }
        }
    }
    csv
}

/// The control with a fault of its backlash parameters.
fn control(rig: &Rig, fault: Injected) -> Box<dyn Emulator> {
    let mut state = rig.kit.compiled.state.clone();
    for axis in &mut state.axes {
        match fault {
            Injected::BacklashTwice => axis.backlash_um += 6.0,
            Injected::BacklashNot => axis.backlash_um = 0.0,
            _ => {}
        }
    }
    kit::emulator(&rig.inputs.profile, &loaded(&rig.inputs.profile, &rig.kit), &state)
        .unwrap_or_else(|reason| panic!("{}", reason.0))
}

/// What the tables add to a term, and what is added beside them.
fn parts(rig: &Rig, control: &dyn Emulator, term: ErrorTerm, way: Direction, x: f64) -> (f64, f64) {
    let (base, output) = axis_pairs(&rig.kit.plan.names, term)[0];
    let response = support::response(control, base, output, way);
    let at = Millimetres::new(x);
    let tables: f64 = response.tables().iter().map(|table| table.correction(at).um()).sum();
    (tables, response.correction(at).um() - tables)
}

fn index(axis: Axis) -> usize {
    Axis::ALL.into_iter().position(|a| a == axis).unwrap()
}

/// What acts on the machine with the fault, µm.
fn acts(
    rig: &Rig,
    control: &dyn Emulator,
    fault: Injected,
    term: ErrorTerm,
    way: Direction,
    x: f64,
) -> f64 {
    let (tables, constant) = parts(rig, control, term, way, x);
    let of_term = |other: ErrorTerm| parts(rig, control, other, way, x).0 + constant;
    match fault {
        Injected::Times(which, factor) if which.holds(term) => factor * tables + constant,
        Injected::Shifted(mm) => {
            parts(rig, control, term, way, x - mm[index(term.along)]).0 + constant
        }
        Injected::AxesExchanged(map) => {
            let made_for = |axis: Axis| Axis::ALL[map.iter().position(|to| *to == axis).unwrap()];
            of_term(ErrorTerm { of: made_for(term.of), along: made_for(term.along) })
        }
        Injected::Transposed => of_term(ErrorTerm { of: term.along, along: term.of }),
        Injected::OutputsExchanged if term.along == Axis::X && term.of != Axis::X => {
            let of = if term.of == Axis::Y { Axis::Z } else { Axis::Y };
            of_term(ErrorTerm { of, along: Axis::X })
        }
        Injected::BacklashNot if rig.name.contains("two tables") && term.of == term.along => {
            parts(rig, control, term, Direction::Plus, x).0
        }
        Injected::DirectionsExchanged => parts(rig, control, term, way.opposite(), x).0 + constant,
        Injected::ForeignTable if term.of == Axis::X && term.along == Axis::X => {
            tables + constant + 7.0 * (x / 130.0).sin()
        }
        Injected::Warmer(kelvin) if term.of == term.along => {
            tables + constant + kelvin[index(term.along)] * STEEL_PER_K * 1e3 * x
        }
        _ => tables + constant,
    }
}

/// The second measurement with a fault.
fn measure_again(rig: &Rig, fault: Injected, random: &mut Random) {
    let control = control(rig, fault);
    let left = |term: ErrorTerm, way: &str, x: f64, um: f64| {
        let direction = Direction::from_symbol(way).unwrap_or(Direction::Plus);
        um + acts(rig, control.as_ref(), fault, term, direction, x)
    };
    let path = rig.directory.path();
    if rig.second == Second::StraightDiagonals {
        std::fs::write(path.join("after.toml"), straight_job(rig)).unwrap();
        let csv = readings(
            rig,
            |term, x| left(term, "", x, rig.truth[&(term.to_string(), "")].at(x)),
            random,
        );
        std::fs::write(path.join("after.csv"), csv).unwrap();
        return;
    }
    let ways: &[&str] = if rig.both_ways { &["+", "-"] } else { &[""] };
    let with_u = rig.second == Second::Table;
    let csv = table(&rig.truth, ways, with_u, |term, way, x, um| {
        left(term, way, x, um) + NOISE_UM * gauss(random)
    });
    std::fs::write(path.join("after.csv"), csv).unwrap();
}

fn straight_job(rig: &Rig) -> String {
    let section = "readings = \"after.csv\"\n[measurement.step_diagonal]\nkind = \"straight\"\nstart_mm = { x = 0.0, y = 0.0, z = -480.0 }\nsize_mm = { x = 900.0, y = 600.0, z = 480.0 }\nsteps = 30\n";
    let (head, tail) =
        rig.job.split_once("errors = \"errors.csv\"\nactive_while_measuring = \"none\"\n").unwrap();
    format!("{head}{section}{tail}")
}

fn readings(rig: &Rig, left: impl Fn(ErrorTerm, f64) -> f64, random: &mut Random) -> String {
    let at = |of: fn(&(Axis, f64, f64)) -> f64| {
        nonius::quantity::axis::PerAxis::from_fn(|axis| Millimetres::new(of(&LENGTHS[index(axis)])))
    };
    let volume = Volume { start: at(|a| a.1), size: at(|a| a.2), steps: 30, order: Axis::ALL };
    let mut csv = String::from("diagonal,node,deviation_um\n");
    for diagonal in Diagonal::ALL {
        let laser = volume.laser(diagonal);
        let mut start = 0.0;
        for node in 0..=30 {
            let place = volume.place(diagonal, PathKind::Straight, node);
            let sum: f64 = ErrorTerm::ALL
                .into_iter()
                .map(|t| laser[t.of] * left(t, place[t.along].mm()))
                .sum();
            let noise = if node == 0 { 0.0 } else { NOISE_UM * gauss(random) };
            if node == 0 {
                start = sum;
            }
            writeln!(csv, "{diagonal},{node},{:.6}", sum - start + noise).unwrap();
        }
    }
    assert!(rig.truth.len() == 9 && Pass::BOTH.len() == 2);
    csv
}

fn run(directory: &Path, arguments: &[&str]) -> Result<String, String> {
    let program = env!("CARGO_BIN_EXE_nonius");
    let output = Command::new(program).args(arguments).current_dir(directory).output().unwrap();
    match output.status.code() {
        Some(0 | 1) => Ok(String::from_utf8(output.stdout).unwrap()),
        _ => Err(String::from_utf8_lossy(&output.stderr).to_string()),
    }
}

/// The faults that a rig can have.
fn faults(rig: &Rig) -> Vec<Injected> {
    use Axis::{X, Y, Z};
    use Injected::{
        AxesExchanged, BacklashNot, BacklashTwice, DirectionsExchanged, ForeignTable, Nothing,
        OutputsExchanged, Shifted, Times, Transposed, Warmer,
    };
    let mut list = vec![Nothing, Nothing, Nothing, Nothing];
    list.extend(
        [Which::All, Which::Along(Y), Which::Of(Z), Which::Only(X, X)]
            .map(|which| Times(which, -1.0)),
    );
    list.extend([Which::All, Which::Along(X), Which::Only(Y, Y)].map(|which| Times(which, 0.0)));
    list.extend([Which::All, Which::Positioning, Which::Along(Z)].map(|which| Times(which, 2.0)));
    list.extend([1000.0, 0.001, 25.4, 1.0 / 25.4].map(|factor| Times(Which::All, factor)));
    list.extend([Times(Which::Positioning, 25.4), Times(Which::Of(X), 0.5)]);
    list.extend([
        Shifted([25.0, 0.0, 0.0]),
        Shifted([0.0, -40.0, 0.0]),
        Shifted([12.0, 30.0, -25.0]),
        Shifted([30.0, 0.0, 0.0]), // one node
        Shifted([10.0; 3]),        // the reference
    ]);
    list.push(ForeignTable);
    list.extend([AxesExchanged([Y, X, Z]), AxesExchanged([Y, Z, X])]);
    list.extend([
        Warmer([1.5; 3]),
        Warmer([3.0; 3]),
        Warmer([2.5, 0.0, 0.0]),
        Warmer([1.0, -2.0, 3.0]),
    ]);
    if rig.truth.len() >= 9 {
        list.extend([
            Times(Which::Cross, -1.0),
            Times(Which::Cross, 0.0),
            Transposed,
            OutputsExchanged,
        ]);
    }
    if rig.second == Second::StraightDiagonals {
        // Readings of ten millimetres are refused before they are compared.
        list.retain(|fault| *fault != Times(Which::All, 1000.0));
    }
    if rig.both_ways {
        list.push(BacklashTwice);
        if rig.name.contains("two tables") {
            list.push(DirectionsExchanged);
        }
        if !rig.name.contains("mean") {
            list.push(BacklashNot);
        }
    }
    list
}

/// One injected fault and what was named.
struct Outcome {
    rig: &'static str,
    injected: Injected,
    named: Vec<String>,
    words: Vec<String>,
    verdict: String,
    decides: bool,
}

fn outcomes(plan: &Plan) -> Vec<Outcome> {
    let rig = rig(plan);
    let mut random = Random::new(1000 + plan.seed);
    let faults = faults(&rig).into_iter();
    faults.map(|injected| outcome(&rig, injected, &mut random)).collect()
}

fn outcome(rig: &Rig, injected: Injected, random: &mut Random) -> Outcome {
    measure_again(rig, injected, random);
    let straight = rig.second == Second::StraightDiagonals;
    let file = if straight { "after.toml" } else { "after.csv" };
    let command = ["verify", "job.toml", "--tables", "kit", "--after", file, "--format", "json"];
    let text = run(rig.directory.path(), &command);
    let text = text.unwrap_or_else(|said| panic!("{}: {injected:?}: {said}", rig.name));
    let document: Value = serde_json::from_str(&text).unwrap();
    let found = &document["diagnosis"];
    let causes = found["causes"].as_array().unwrap();
    let all = |key: &str| -> Vec<String> {
        let words = causes.iter().map(|cause| cause[key].as_str().unwrap());
        words.map(str::to_string).collect()
    };
    let mut named = all("kind");
    named.sort();
    named.dedup();
    if named.is_empty() {
        let clean = found["as_forecast"].as_bool().unwrap();
        named.push(if clean { "no fault" } else { "unknown" }.to_string());
    }
    Outcome {
        rig: rig.name,
        injected,
        named,
        words: all("words"),
        verdict: document["verdict"].as_str().unwrap().to_string(),
        decides: found["decides"].is_string(),
    }
}

fn all_outcomes() -> Vec<Outcome> {
    std::thread::scope(|scope| {
        let threads: Vec<_> = RIGS.iter().map(|plan| scope.spawn(|| outcomes(plan))).collect();
        threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
    })
}

/// Rows injected, columns named.
fn confusion(outcomes: &[Outcome]) -> String {
    let kinds = [
        "no fault",
        "sign turned",
        "not active",
        "applied twice",
        "wrong unit",
        "other factor",
        "shifted",
        "wrong axis",
        "directions exchanged",
        "backlash twice",
        "backlash not",
        "temperature",
        "measurement turned",
        "unknown",
    ];
    let mut named = outcomes.iter().flat_map(|o| &o.named);
    let other = named.find(|named| !kinds.contains(&named.as_str()));
    assert_eq!(other, None, "a kind without a column");
    let mut text = String::from("| injected | runs |");
    for kind in kinds {
        write!(text, " {kind} |").unwrap();
    }
    text.push_str("\n| --- | ---: |");
    text.push_str(&" ---: |".repeat(kinds.len()));
    for row in kinds.iter().filter(|kind| outcomes.iter().any(|o| o.injected.kind() == **kind)) {
        let of_row: Vec<&Outcome> = outcomes.iter().filter(|o| o.injected.kind() == *row).collect();
        write!(text, "\n| {row} | {} |", of_row.len()).unwrap();
        for column in kinds {
            let count =
                of_row.iter().filter(|o| o.named.iter().any(|named| named == column)).count();
            let count = if count == 0 { "–".to_string() } else { count.to_string() };
            write!(text, " {count} |").unwrap();
        }
    }
    text
}

#[test]
fn the_true_cause_is_in_the_named_set_and_clean_runs_name_none() {
    let outcomes = all_outcomes();
    let injected = outcomes.iter().filter(|o| o.injected != Injected::Nothing).count();
    assert!(injected >= 60, "only {injected} faults");
    let unseen = |o: &&Outcome| o.injected != Injected::Nothing && o.named == ["no fault"];
    let hidden = outcomes.iter().filter(unseen).count();
    assert_eq!(hidden, 0, "{hidden} faults do not show");
    let mut wrong = String::new();
    for o in &outcomes {
        let found = o.named.iter().any(|named| named == o.injected.kind());
        let small = o.named.len() <= if o.rig.contains("diagonals") { 9 } else { 3 };
        let none = [Injected::Nothing, Injected::ForeignTable].contains(&o.injected);
        let decided = none || o.decides;
        if !(found && small && decided) {
            writeln!(
                wrong,
                "{}: {:?} → {:?} ({}) {:#?}",
                o.rig, o.injected, o.named, o.verdict, o.words
            )
            .unwrap();
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
    let by_table =
        outcomes.iter().filter(|o| !o.rig.contains("diagonals") && o.injected != Injected::Nothing);
    let sizes: Vec<usize> = by_table.map(|o| o.named.len()).collect();
    let mean = sizes.iter().sum::<usize>() as f64 / sizes.len() as f64;
    assert!(mean < 1.6, "sets of {mean} kinds on average");
    published("causes", "causes", &confusion(&outcomes));
}
