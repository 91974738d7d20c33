//! What a statement is worth, and the act that *what decides* puts first: whole visits by the program itself, each
//! with a machine of its own, whose truth `simulate --errors` tells.
//!
//! `NONIUS_SIMULATIONS=all cargo test --release --test studies statements` compares docs/accuracy.md §8, with
//! `NONIUS_UPDATE=1` it writes it.
use crate::support::diagonals::{Machine, normal, volume};
use crate::support::published::{is_whole, published, share};
use crate::support::visit::Visit;
use nonius::quantity::axis::{Axis, ErrorTerm};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde_json::Value;

const SEED: u64 = 41;
const VISITS: u64 = 200;
const SIZE: [f64; 3] = [900.0, 720.0, 720.0];
const STEPS: usize = 9;
/// Limit and what is stated, all of it true.
const JOB: &str = "schema = 1\nmachine = { name = \"VMC\", chain = \"wXYZt\", axes = { x = { travel_mm = [0, 900], reference_mm = 0 }, y = { travel_mm = [0, 720], reference_mm = 0 }, z = { travel_mm = [0, 720], reference_mm = 0 } } }\n\
    acceptance = { max_deviation_um = LIMIT }\n[measurement]\nreadings = \"NAME.csv\"\nactive_while_measuring = \"ACTIVE\"\n[measurement.uncertainty]\nnoise_um = NOISE\nSTATED\n\
    [measurement.step_diagonal]\nstart_mm = { x = 0, y = 0, z = 0 }\nsize_mm = { x = 900, y = 720, z = 720 }\nsteps = 9\norder = \"XYZ\"\nlinear = [LINES]\n\
    [compensation]\ncontroller = \"generic\"\naxes = { x = { points = 10 }, y = { points = 10 }, z = { points = 10 } }\n";
const ANGLES: &str = "axis,position_mm,ea_urad,eb_urad,ec_urad\nx,0,0,0,0\nx,900,0,0,0\ny,0,0,0,0\ny,720,0,0,0\nz,0,0,0,0\nz,720,0,0,0\n";

/// A machine, measured, compensated and measured again.
struct Trial {
    visit: Visit,
    random: ChaCha8Rng,
    noise_um: f64,
    limit_um: f64,
    stated: &'static str,
}

/// Values of an error table from its first of each axis, µm, row by row.
fn errors(table: &str) -> Vec<[f64; 3]> {
    let rows = table.lines().filter(|line| line.starts_with(['x', 'y', 'z']));
    let cells = rows.map(|row| row.split(',').skip(2).map(|cell| cell.parse().unwrap()).collect());
    let rows: Vec<Vec<f64>> = cells.collect();
    let axes = rows.chunks(STEPS + 1);
    axes.flat_map(|own| own.iter().map(|row| [0, 1, 2].map(|of| row[of] - own[0][of]))).collect()
}

impl Trial {
    fn new(seed: u64, stated: &'static str) -> Trial {
        let mut random = ChaCha8Rng::seed_from_u64(SEED + seed);
        let machine = Machine::random(&volume(SIZE, STEPS), &mut random).x_primary();
        let mut even = || f64::from(random.next_u32()) / f64::from(u32::MAX);
        let (noise_um, limit_um) = (if even() < 0.5 { 0.3 } else { 1.0 }, 2.0 * 4f64.powf(even()));
        let visit = Visit::new();
        let mut table = "axis,position_mm,ex_um,ey_um,ez_um\n".to_string();
        for (along, size) in Axis::ALL.into_iter().zip(SIZE) {
            for i in 0..=STEPS {
                let um = Axis::ALL.map(|of| machine.curves[ErrorTerm { of, along }][i].to_string());
                let at = size * i as f64 / STEPS as f64;
                table += &format!("{},{at},{}\n", along.key(), um.join(","));
            }
        }
        visit.put("machine.csv", table);
        visit.put("angles.csv", ANGLES);
        Trial { visit, random, noise_um, limit_um, stated }
    }

    /// Readings and linear axes of the machine, whose errors the table holds, under these tables.
    fn measure(&mut self, name: &str, machine: &str, runs: u32) {
        let is_first = name.starts_with("job");
        let [tables, active] =
            if is_first { ["--without-tables", "none"] } else { ["--tables kit", "kit"] };
        let errors = errors(&self.visit.read(machine));
        let line = |(at, key): (usize, &str)| {
            let um = errors[(at + 1) * (STEPS + 1) - 1][at];
            let slope = 1000.0 * um / SIZE[at] + 0.5 * normal(&mut self.random);
            format!("{{ axis = \"{key}\", slope_um_per_m = {slope:?}, u_um_per_m = 0.5 }}")
        };
        let lines: Vec<String> = (0..).zip(["x", "y", "z"]).map(line).collect();
        let (noise, limit, lines) = (self.noise_um, self.limit_um.to_string(), lines.join(", "));
        let text = JOB.replace("LIMIT", &limit).replace("NAME", name).replace("ACTIVE", active);
        let text = text.replace("NOISE", &noise.to_string()).replace("STATED", self.stated);
        self.visit.put(&format!("{name}.toml"), text.replace("LINES", &lines));
        let options =
            format!("--noise-um {noise} --seed {} --runs {runs} --force", self.random.next_u32());
        let simulate = "simulate job.toml --machine machine.csv";
        self.visit.run(&format!("{simulate} {tables} -o {name}.csv {options}")).answers();
    }

    /// A kit, its verdict and what decides.
    fn made(&self, job: &str, kit: &str) -> (String, Value) {
        let ran = self.visit.run(&format!("generate {job}.toml -o {kit} --force"));
        let verdict = ran.out.strip_prefix("verdict: ").unwrap_or_else(|| panic!("{}", ran.all()));
        let word = verdict.split([' ', '\n']).next().unwrap().to_string();
        (word, self.visit.document(&format!("{kit}/manifest.json"))["what_decides"].clone())
    }

    fn left(&self, after: &str) -> (String, Value) {
        let page = format!("verify job.toml --tables kit --after {after}.toml --format json");
        let left = self.visit.run(&page).json();
        (left["verdict"].as_str().unwrap().to_string(), left["what_decides"].clone())
    }

    /// Both measurements; the largest error that the tables leave, in limits.
    fn whole(&mut self) -> [(String, Value); 2] {
        self.measure("job", "machine.csv", 1);
        let made = self.made("job", "kit");
        let simulate = "simulate job.toml --machine machine.csv --tables kit --errors";
        self.visit.run(&format!("{simulate} -o left.csv --force")).answers();
        self.measure("after", "left.csv", 1);
        [made, self.left("after")]
    }
}

/// How many are undecided though the truth lies well on one side; of these: an act is promised to decide, it does;
/// whatever stands first, it does.
#[test]
fn the_act_that_stands_first_decides() {
    let mut counts = [[0u32; 5]; 2];
    for seed in 0..share(VISITS, 4) {
        let mut trial =
            Trial::new(seed, "angle_urad = 0\nsetup_ppm = 0\nbeam_mrad = 0.5\nlaser_ppm = 0.1");
        let stages = trial.whole();
        let left = errors(&trial.visit.read("left.csv"));
        let truth =
            left.iter().flatten().fold(0f64, |most, um| most.max(um.abs())) / trial.limit_um;
        for (stage, (verdict, decides)) in stages.into_iter().enumerate() {
            if verdict != "undecided" || (0.7..1.3).contains(&truth) {
                continue;
            }
            let act = &decides["acts"][0];
            let what = act["what"].as_str().unwrap_or_default();
            let runs = what.split(' ').next().and_then(|runs| runs.parse().ok());
            let [name, machine] = [["job2", "machine.csv"], ["after2", "left.csv"]][stage];
            trial.measure(name, machine, runs.unwrap_or(1));
            let (again, _) = match (stage, what.contains("new tables")) {
                (1, false) => trial.left("after2"),
                (_, true) if runs.is_none() => trial.made("after", "again"),
                _ => trial.made(name, "again"),
            };
            println!("{seed} {name} {truth:.2} limits: {what}, {} → {again}", act["verdict"]);
            let (said, done) = (act["verdict"] == "pass", again != "undecided");
            count(&mut counts[stage], [true, said, said && done, !said, !said && done]);
        }
    }
    let mut table = "| verdict on | undecided | an act is said to decide | it does | none is | the first does |\n| --- | ---: | ---: | ---: | ---: | ---: |".to_string();
    for (name, counts) in ["forecast", "as left"].into_iter().zip(counts) {
        table += &format!("\n| {name} | {} |", counts.map(|count| count.to_string()).join(" | "));
        assert!(f64::from(counts[2]) >= 0.9 * f64::from(counts[1]) || !is_whole(), "{table}");
    }
    publish("acts", &table);
}

fn count<const N: usize>(counts: &mut [u32; N], each: [bool; N]) {
    counts.iter_mut().zip(each).for_each(|(count, own)| *count += u32::from(own));
}

fn publish(name: &str, table: &str) {
    println!("{table}");
    if is_whole() {
        published(name, "statements", &format!("{VISITS} visits, seed {SEED}.\n\n{table}"));
    }
}

/// Who leaves a true statement out gets no better verdict.
#[test]
fn silence_never_helps() {
    let rank = |verdict: &str| ["pass", "undecided", "fail"].iter().position(|own| *own == verdict);
    let keys =
        ["noise_um", "angle_urad", "setup_ppm", "beam_mrad", "laser_ppm", "u_um_per_m", "angles"];
    let mut counts = [[[0u32; 3]; 2]; 7];
    for seed in 0..share(VISITS, 2) {
        let mut trial = Trial::new(
            1000 + seed,
            "angle_urad = 5\nsetup_ppm = 0.2\nbeam_mrad = 0.5\nlaser_ppm = 0.1",
        );
        let whole = trial.whole().map(|(verdict, _)| rank(&verdict));
        let judged = |change: &dyn Fn(String) -> String| {
            for name in ["job", "after"] {
                let text = change(trial.visit.read(&format!("{name}.toml")));
                trial.visit.put(&format!("own-{name}.toml"), text);
            }
            let both = [trial.made("own-job", "own"), trial.left("own-after")];
            both.map(|(verdict, _)| rank(&verdict))
        };
        for (key, counts) in keys.into_iter().zip(&mut counts) {
            let without = |text: String, key: &str| {
                let kept = text.lines().filter(|line| !line.starts_with(key)).collect::<Vec<_>>();
                let of_lines = format!(", {key} = 0.5");
                kept.join("\n").replace(&of_lines, "")
            };
            let with_angles = |text: String| {
                let angles = "angles = \"angles.csv\"\nactive_while";
                without(text, "angle_urad").replace("active_while", angles)
            };
            let verdicts = match key {
                "angles" => [judged(&with_angles), judged(&|text| without(text, "angle_urad"))],
                _ => [whole, judged(&|text| without(text, key))],
            };
            for (stage, counts) in counts.iter_mut().enumerate() {
                let [stated, silent] = verdicts.map(|both| both[stage]);
                count(counts, [stated == Some(0), silent == Some(0), silent < stated]);
            }
        }
    }
    let mut table = "| left out | forecast passes: stated | left out | better | as left passes: stated | left out | better |\n| --- | ---: | ---: | ---: | ---: | ---: | ---: |".to_string();
    for (key, [made, left]) in keys.into_iter().zip(counts) {
        let cells = [made, left].concat().iter().map(u32::to_string).collect::<Vec<_>>();
        table += &format!("\n| `{key}` | {} |", cells.join(" | "));
        let held = [made, left].iter().all(|[stated, silent, better]| match key {
            "noise_um" => silent <= stated || !is_whole(),
            _ => *better == 0,
        });
        assert!(held, "{table}");
    }
    publish("silence", &table);
}
