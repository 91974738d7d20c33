//! Faults put into the control, the machine measured again, and what `verify --after` names.
//!
//! The faults act here on the emulated corrections of the bytes that were written, with code of
//! this test; the program sees nothing but the job, the kit and the second measurement. Asked is
//! that the true cause is in the named set, that sets are small where the data allow it, and that
//! a second measurement without fault names none. Plain `cargo test` injects a sixth of the
//! faults into each machine, every fault into one at least; `NONIUS_SIMULATIONS=twentieth` or `all`
//! injects all and compares the table of docs/accuracy.md, with `NONIUS_UPDATE=1` it writes it.
use crate::support::{
    Lines, Random, Visit, generate, in_parallel, loaded, published, response, short_or,
};
use nonius::kit::{self, Inputs, Kit};
use nonius::quantity::{
    Axis, Diagonal, Direction, ErrorTerm, Millimetres, PathKind, PerAxis, Volume,
};
use nonius::read::emulate::Emulator;
use nonius::write::plan::axis_pairs;
use std::collections::BTreeMap;
use std::fmt::Write;

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

#[derive(Clone, Copy)]
struct Plan {
    name: &'static str,
    controller: &'static str,
    terms: &'static [&'static str],
    backlash: Option<&'static str>,
    second: Second,
    seed: u64,
}

impl Plan {
    const fn of(name: &'static str, controller: &'static str, seed: u64) -> Plan {
        let terms = &["EXX", "EYX", "EZX", "EXY", "EYY", "EZY", "EXZ", "EYZ", "EZZ"];
        Plan { name, controller, terms, backlash: None, second: Second::Table, seed }
    }

    const fn backlash(self, policy: &'static str) -> Plan {
        Plan { backlash: Some(policy), ..self }
    }

    fn ways(&self) -> &'static [&'static str] {
        if self.backlash.is_some() { &["+", "-"] } else { &[""] }
    }
}

const RIGS: [Plan; 7] = [
    Plan::of("840D sl, nine terms", "siemens-840d-sl", 1),
    Plan::of("828D, nine terms, two tables", "siemens-828d", 2).backlash("two-tables"),
    Plan::of("30i, nine terms", "fanuc-30i", 3),
    Plan {
        terms: &["EXX", "EYY", "EZZ"],
        ..Plan::of("0i-F, three terms, curve and parameter", "fanuc-0i-f", 4)
            .backlash("curve-and-parameter")
    },
    Plan::of("generic, nine terms, mean", "generic", 5).backlash("mean"),
    Plan {
        second: Second::TableWithoutU,
        ..Plan::of("840D sl, U not stated", "siemens-840d-sl", 6)
    },
    Plan {
        second: Second::StraightDiagonals,
        ..Plan::of("840D sl, straight diagonals", "siemens-840d-sl", 7)
    },
];

/// Errors by term and direction.
type Truth = BTreeMap<(ErrorTerm, &'static str), Lines>;

/// A machine with its kit.
struct Rig {
    plan: &'static Plan,
    inputs: Inputs,
    kit: Kit,
    truth: Truth,
    job: String,
    visit: Visit,
}

/// Axes of a machine with the ends of their travels, mm.
pub(super) type Travels = [(&'static str, f64, f64); 3];

const TRAVELS: Travels = [("x", 0.0, 900.0), ("y", 0.0, 600.0), ("z", -480.0, 0.0)];

pub(super) fn gauss(random: &mut Random) -> f64 {
    (0..12).map(|_| random.between(0.0, 1.0)).sum::<f64>() - 6.0
}

/// A job with so many equal sections on each axis; `unit` is a key of every axis.
pub(super) fn job_text(
    travels: Travels,
    (measurement, compensation, acceptance): (&str, &str, &str),
    sections: f64,
    unit: &str,
) -> String {
    let mut text = "schema = 1\n[machine]\nname = \"rig\"\n".to_string();
    for (axis, low, high) in travels {
        let travel = format!("travel_mm = [{low:?}, {high:?}]\nreference_mm = 0.0\n");
        text += &format!("[machine.axes.{axis}]\n{travel}");
    }
    text += &format!("[measurement]\n{measurement}\n[compensation]\n{compensation}\n");
    for (axis, low, high) in travels {
        let spacing = (high - low) / sections;
        text += &format!("[compensation.axes.{axis}]\nspacing_mm = {spacing:?}\n{unit}\n");
    }
    format!("{text}[acceptance]\n{acceptance}\n")
}

/// A wavy curve with a slope, and its reversal.
fn curve(random: &mut Random, size: f64, (low, high): (f64, f64), reversal: f64) -> Lines {
    let length = high - low;
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

fn rig(plan: &'static Plan) -> Rig {
    let mut random = Random::new(plan.seed);
    let mut truth = Truth::new();
    for term in plan.terms.iter().map(|name| ErrorTerm::from_name(name).unwrap()) {
        let (_, low, high) = TRAVELS[term.along as usize];
        let own = random.below(1_000_000) as u64;
        let size = if term.is_positioning() { 1.0 } else { 0.5 };
        for way in plan.ways() {
            let reversal = if *way == "-" && term.is_positioning() { 6.0 } else { 0.0 };
            let curve = curve(&mut Random::new(own), size, (low, high), reversal);
            truth.insert((term, *way), curve);
        }
    }
    let job = job_of(plan);
    let errors = table(plan, &truth, |_, _, _, um| um + NOISE_UM * gauss(&mut random));
    let (inputs, kit) = generate(&job, &errors);
    let visit = Visit::with(&job, errors).with_any_kit();
    Rig { plan, inputs, kit, truth, job, visit }
}

const FIRST: &str = "errors = \"errors.csv\"\nactive_while_measuring = \"none\"\n";

fn job_of(plan: &Plan) -> String {
    let noise = match plan.second {
        Second::TableWithoutU => String::new(),
        _ => format!("[measurement.uncertainty]\nnoise_um = {NOISE_UM}\n"),
    };
    let policy = plan.backlash.map(|policy| format!("backlash = \"{policy}\"\n"));
    let control = format!("controller = \"{}\"\n{}", plan.controller, policy.unwrap_or_default());
    let unit = if plan.controller.starts_with("fanuc") { "detection_unit_um = 0.1" } else { "" };
    let acceptance = "max_deviation_um = 3.0\nmax_diagonal_um = 6.0";
    job_text(TRAVELS, (&format!("{FIRST}{noise}"), &control, acceptance), 30.0, unit)
}

/// An error table; `value` gets term, direction, position and the true deviation.
fn table(
    plan: &Plan,
    truth: &Truth,
    mut value: impl FnMut(ErrorTerm, &str, f64, f64) -> f64,
) -> String {
    let with_u = plan.second != Second::TableWithoutU;
    let mut csv = String::from("axis,direction,position_mm,ex_um,ey_um,ez_um");
    csv.push_str(if with_u { ",u_ex_um,u_ey_um,u_ez_um\n" } else { "\n" });
    for along in Axis::ALL {
        for way in plan.ways() {
            let lines = Axis::ALL.map(|of| truth.get(&(ErrorTerm { of, along }, *way)));
            let positions = lines.into_iter().flatten().next().map(|lines| lines.mm.clone());
            for x in positions.unwrap_or_default() {
                write!(csv, "{},{way},{x}", along.key()).unwrap();
                for (of, lines) in Axis::ALL.into_iter().zip(lines) {
                    let term = ErrorTerm { of, along };
                    let um = lines.map(|lines| value(term, way, x, lines.at(x)));
                    csv += &um.map_or(",".to_string(), |um| format!(",{um:.6}"));
                }
                for lines in lines.iter().filter(|_| with_u) {
                    csv += &lines.map_or(",".to_string(), |_| format!(",{NOISE_UM}"));
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
    let profile = &rig.inputs.profile;
    kit::emulator(profile, &loaded(profile, &rig.kit), &state).unwrap_or_else(|e| panic!("{}", e.0))
}

/// What the tables add to a term, and what is added beside them.
fn parts(rig: &Rig, control: &dyn Emulator, term: ErrorTerm, way: Direction, x: f64) -> (f64, f64) {
    let (base, output) = axis_pairs(&rig.kit.plan.names, term)[0];
    let response = response(control, base, output, way);
    let at = Millimetres::new(x);
    let tables: f64 = response.tables().iter().map(|table| table.correction(at).um()).sum();
    (tables, response.correction(at).um() - tables)
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
            parts(rig, control, term, way, x - mm[term.along as usize]).0 + constant
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
        Injected::BacklashNot if has_two_tables(rig) && term.is_positioning() => {
            parts(rig, control, term, Direction::Plus, x).0
        }
        Injected::DirectionsExchanged => parts(rig, control, term, way.opposite(), x).0 + constant,
        Injected::ForeignTable if term.of == Axis::X && term.along == Axis::X => {
            tables + constant + 7.0 * (x / 130.0).sin()
        }
        Injected::Warmer(kelvin) if term.is_positioning() => {
            tables + constant + kelvin[term.along as usize] * STEEL_PER_K * 1e3 * x
        }
        _ => tables + constant,
    }
}

fn has_two_tables(rig: &Rig) -> bool {
    rig.plan.backlash == Some("two-tables")
}

/// The second measurement with a fault; the name of its file.
fn measure_again(rig: &Rig, fault: Injected, random: &mut Random) -> &'static str {
    let control = control(rig, fault);
    let left = |term: ErrorTerm, way: &str, x: f64, um: f64| {
        let direction = Direction::from_symbol(way).unwrap_or(Direction::Plus);
        um + acts(rig, control.as_ref(), fault, term, direction, x)
    };
    if rig.plan.second == Second::StraightDiagonals {
        let at = |term: ErrorTerm, x: f64| left(term, "", x, rig.truth[&(term, "")].at(x));
        rig.visit.put("after.csv", readings(rig, at, random));
        rig.visit.put("after.toml", rig.job.replacen(FIRST, STRAIGHT, 1));
        return "after.toml";
    }
    let csv = table(rig.plan, &rig.truth, |term, way, x, um| {
        left(term, way, x, um) + NOISE_UM * gauss(random)
    });
    rig.visit.put("after.csv", csv);
    "after.csv"
}

const STRAIGHT: &str = "readings = \"after.csv\"\n[measurement.step_diagonal]\nkind = \"straight\"
start_mm = { x = 0.0, y = 0.0, z = -480.0 }\nsize_mm = { x = 900.0, y = 600.0, z = 480.0 }\nsteps = 30\n";

fn readings(rig: &Rig, left: impl Fn(ErrorTerm, f64) -> f64, random: &mut Random) -> String {
    assert_eq!(rig.truth.len(), 9);
    let at = |mm: [f64; 3]| PerAxis::from_fn(|axis| Millimetres::new(mm[axis as usize]));
    let (start, size) = (at([0.0, 0.0, -480.0]), at([900.0, 600.0, 480.0]));
    let volume = Volume { start, size, steps: 30, order: Axis::ALL };
    let mut csv = String::from("diagonal,node,deviation_um\n");
    for diagonal in Diagonal::ALL {
        let laser = volume.laser(diagonal);
        let mut start = 0.0;
        for node in 0..=30 {
            let place = volume.place(diagonal, PathKind::Straight, node);
            let each =
                ErrorTerm::ALL.into_iter().map(|t| laser[t.of] * left(t, place[t.along].mm()));
            let sum: f64 = each.sum();
            let noise = if node == 0 { 0.0 } else { NOISE_UM * gauss(random) };
            if node == 0 {
                start = sum;
            }
            writeln!(csv, "{diagonal},{node},{:.6}", sum - start + noise).unwrap();
        }
    }
    csv
}

/// The faults that a rig can have.
fn faults(rig: &Rig) -> Vec<Injected> {
    use Axis::{X, Y, Z};
    use Injected::*;
    use Which::{All, Along, Cross, Of, Only, Positioning};
    let mut list = vec![Nothing, Nothing, Nothing, Nothing];
    list.extend([All, Along(Y), Of(Z), Only(X, X)].map(|which| Times(which, -1.0)));
    list.extend([All, Along(X), Only(Y, Y)].map(|which| Times(which, 0.0)));
    list.extend([All, Positioning, Along(Z)].map(|which| Times(which, 2.0)));
    list.extend([1000.0, 0.001, 25.4, 1.0 / 25.4].map(|factor| Times(All, factor)));
    list.extend([Times(Positioning, 25.4), Times(Of(X), 0.5)]);
    list.extend([[25.0, 0.0, 0.0], [0.0, -40.0, 0.0], [12.0, 30.0, -25.0]].map(Shifted));
    // One node, and the reference.
    list.extend([[30.0, 0.0, 0.0], [10.0; 3]].map(Shifted));
    list.push(ForeignTable);
    list.extend([AxesExchanged([Y, X, Z]), AxesExchanged([Y, Z, X])]);
    list.extend([[1.5; 3], [3.0; 3], [2.5, 0.0, 0.0], [1.0, -2.0, 3.0]].map(Warmer));
    if rig.truth.len() >= 9 {
        list.extend([Times(Cross, -1.0), Times(Cross, 0.0), Transposed, OutputsExchanged]);
    }
    if rig.plan.second == Second::StraightDiagonals {
        // Readings of ten millimetres are refused before they are compared.
        list.retain(|fault| *fault != Times(All, 1000.0));
    }
    if rig.plan.backlash.is_some() {
        list.push(BacklashTwice);
        if has_two_tables(rig) {
            list.push(DirectionsExchanged);
        }
        if rig.plan.backlash != Some("mean") {
            list.push(BacklashNot);
        }
    }
    list
}

/// One injected fault and what was named.
struct Outcome {
    plan: &'static Plan,
    injected: Injected,
    named: Vec<String>,
    words: Vec<String>,
    verdict: String,
    decides: bool,
}

impl Outcome {
    fn by_diagonals(&self) -> bool {
        self.plan.second == Second::StraightDiagonals
    }
}

fn outcomes(plan: &'static Plan) -> Vec<Outcome> {
    let rig = rig(plan);
    let mut random = Random::new(1000 + plan.seed);
    let draws = match plan.second {
        Second::StraightDiagonals => 4 * 30,
        _ => rig.truth.values().map(|lines| lines.mm.len()).sum(),
    };
    let all = faults(&rig).into_iter().enumerate().map(|(index, injected)| {
        if short_or(index % 6 == plan.seed as usize % 6, true) {
            let file = measure_again(&rig, injected, &mut random);
            return Some(outcome(&rig, injected, file));
        }
        // The noise of the others stays that of the whole simulation.
        for _ in 0..draws {
            gauss(&mut random);
        }
        None
    });
    all.flatten().collect()
}

fn outcome(rig: &Rig, injected: Injected, file: &str) -> Outcome {
    let document = rig.visit.json(&format!("verify job.toml --tables kit --after {file}"));
    let found = &document["diagnosis"];
    let all = |key: &str| -> Vec<String> {
        let causes = found["causes"].as_array().unwrap().iter();
        causes.map(|cause| cause[key].as_str().unwrap().to_string()).collect()
    };
    let mut named = all("kind");
    named.sort();
    named.dedup();
    if named.is_empty() {
        let clean = found["as_forecast"].as_bool().unwrap();
        named.push(if clean { "no fault" } else { "unknown" }.to_string());
    }
    let verdict = document["verdict"].as_str().unwrap().to_string();
    let (words, decides) = (all("words"), found["decides"].is_string());
    Outcome { plan: rig.plan, injected, named, words, verdict, decides }
}

/// The kinds in the order of the page.
const KINDS: &str = "no fault | sign turned | not active | applied twice | wrong unit | other factor | shifted | wrong axis | directions exchanged | backlash twice | backlash not | temperature | measurement turned | unknown";

/// Of each injected kind, in how many runs it was named, and what was named as well.
fn confusion(outcomes: &[Outcome]) -> String {
    let kinds: Vec<&str> = KINDS.split(" | ").collect();
    let mut named = outcomes.iter().flat_map(|o| &o.named);
    let other = named.find(|named| !kinds.contains(&named.as_str()));
    assert_eq!(other, None, "a kind that the page does not know");
    let of_kind = |injected: &&str| {
        let own: Vec<_> = outcomes.iter().filter(|o| o.injected.kind() == *injected).collect();
        let has = |o: &Outcome, kind: &str| o.named.iter().any(|named| named == kind);
        let count = |kind: &str| own.iter().filter(|o| has(o, kind)).count();
        let others = kinds.iter().filter(|kind| *kind != injected && count(kind) > 0);
        let others: Vec<_> = others.map(|kind| format!("{kind} {}", count(kind))).collect();
        let others = match others.is_empty() {
            true => String::new(),
            false => format!(" ({})", others.join(", ")),
        };
        (!own.is_empty()).then(|| format!("{injected} {}/{}{others}", count(injected), own.len()))
    };
    let all: Vec<_> = kinds.iter().filter_map(of_kind).collect();
    format!("Injected, named/runs (named as well): {}.", all.join("; "))
}

#[test]
fn the_true_cause_is_in_the_named_set_and_clean_runs_name_none() {
    let outcomes: Vec<Outcome> = in_parallel(&RIGS, outcomes).into_iter().flatten().collect();
    let faults = outcomes.iter().filter(|o| o.injected != Injected::Nothing);
    let injected = faults.clone().count();
    assert!(injected >= short_or(30, 60), "only {injected} faults");
    let hidden = faults.clone().filter(|o| o.named == ["no fault"]);
    let hidden: Vec<_> = hidden.map(|o| (o.plan.name, o.injected)).collect();
    assert_eq!(hidden, [], "faults that do not show");
    let mut wrong = String::new();
    for o in &outcomes {
        let found = o.named.iter().any(|named| named == o.injected.kind());
        let small = o.named.len() <= if o.by_diagonals() { 9 } else { 3 };
        let none = [Injected::Nothing, Injected::ForeignTable].contains(&o.injected);
        let decided = none || o.decides;
        if !(found && small && decided) {
            let (rig, injected) = (o.plan.name, o.injected);
            let said = format!("{:?} ({}) {:#?}", o.named, o.verdict, o.words);
            writeln!(wrong, "{rig}: {injected:?} → {said}").unwrap();
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
    let sizes: Vec<usize> = faults.filter(|o| !o.by_diagonals()).map(|o| o.named.len()).collect();
    let mean = sizes.iter().sum::<usize>() as f64 / sizes.len() as f64;
    assert!(mean < 1.6, "sets of {mean} kinds on average");
    let table = confusion(&outcomes);
    if short_or(false, true) {
        published("causes", "causes", &table);
    }
}
