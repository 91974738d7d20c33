//! `nonius plan`: its U against simulated visits, each with a machine, mirrors, noise and lasers of its own, and against
//! the U of the readings; what its page says. 25 visits of each kind by default, since fewer do not tell the U of the
//! readings; with `NONIUS_SIMULATIONS=all` all of them, and the table of docs/accuracy.md §8.
use crate::support::diagonals as simulated;
use crate::support::diagonals::{
    Machine, Readings, Share, float, noisy_runs, normal, seeded, squareness_error, volume,
};
use crate::support::visit::{self};
use crate::support::{fixture, is_held, is_whole, published, share, short_or, shown, source};
use nonius::inputs::error_table::{ErrorTable, write};
use nonius::inputs::job::{Frame, Job, SetUp, StatedUncertainty, UseOf};
use nonius::judge::after::{AfterMeasurement, compare};
use nonius::judge::conformity::Verdict;
use nonius::judge::forecast::Machine as AsMeasured;
use nonius::kit::visit_plan::{Design, SetUpTimes, Visit, VisitPlan, plan};
use nonius::machine::model::ErrorModel;
use nonius::machine::separation::campaign::Estimate;
use nonius::machine::separation::table::draft;
use nonius::machine::separation::{MeasuredLine, Separation, separate};
use nonius::quantity::{Axis, Diagonal, ErrorTerm, Pass, PathKind, PerAxis, PerDiagonal, Plane};
use nonius::write::plan::Plan;
use rand_chacha::ChaCha8Rng;
use std::fmt::Write as _;

const SEED: u64 = 19;
const VISITS: u64 = 500;
const TIMES: SetUpTimes = SetUpTimes { diagonal_min: 30.0, linear_min: 20.0 };

/// One row of the table.
struct Row {
    name: &'static str,
    size: [f64; 3],
    /// Where the reference lies: the share of the travel.
    reference: f64,
    steps: usize,
    /// Keys of `[program]`.
    program: &'static str,
    /// σ of a reading, µm, and whether the job states it.
    noise: (f64, bool),
    laser_ppm: f64,
    setup_ppm: f64,
    linear: &'static [Axis],
    /// Whether U may hold more than it says.
    is_bound: bool,
}

const PLAIN: Row = Row {
    name: "one direction, linear X and Y",
    size: [900.0, 720.0, 720.0],
    reference: 0.0,
    steps: 15,
    program: "bidirectional = false",
    noise: (0.3, true),
    laser_ppm: 0.0,
    setup_ppm: 0.0,
    linear: &[Axis::X, Axis::Y],
    is_bound: false,
};

const SET_UPS: &str = "30 steps, 0.2 ppm from one set-up to the next";
const ONE_LASER: &str = "the same laser everywhere, wrong by 0.5 ppm";

const ROWS: &[Row] = &[
    PLAIN,
    Row { name: "noise not stated", noise: (1.0, false), ..PLAIN },
    Row { name: "linear X, Y and Z", linear: &Axis::ALL, ..PLAIN },
    Row { name: "no linear axis: cross terms and squareness", linear: &[], ..PLAIN },
    Row { name: "three runs", program: "bidirectional = false\nruns = 3", ..PLAIN },
    Row { name: "return pass without overrun", program: "overrun_mm = 0", ..PLAIN },
    Row {
        name: "return pass after overrun, short Z",
        size: [800.0, 500.0, 250.0],
        steps: 10,
        program: "overrun_mm = 2",
        ..PLAIN
    },
    Row { name: SET_UPS, steps: 30, setup_ppm: 0.2, ..PLAIN },
    Row { name: ONE_LASER, laser_ppm: 0.5, is_bound: true, ..PLAIN },
];

impl Row {
    fn text(&self) -> String {
        let [x, y, z] = self.size;
        let noise = match self.noise {
            (um, true) => format!("noise_um = {um:?}\n"),
            (_, false) => String::new(),
        };
        let axis = |(axis, size)| {
            let reference = self.reference * size;
            format!(
                "axes.{axis} = {{ travel_mm = [0.0, {size:?}], reference_mm = {reference:?} }}\n"
            )
        };
        let axes = [("x", x), ("y", y), ("z", z)].map(axis).concat();
        format!(
            "schema = 1\n[machine]\nname = \"VMC\"\nchain = \"wXYZt\"\n{axes}[measurement]\nerrors = \"none.csv\"\n\
             [measurement.uncertainty]\n{noise}laser_ppm = {:?}\nbeam_mrad = 0.0\nsetup_ppm = {:?}\n\
             [program]\nwhat = \"step-diagonal\"\nstart_mm = {{ x = 0.0, y = 0.0, z = 0.0 }}\n\
             size_mm = {{ x = {x:?}, y = {y:?}, z = {z:?} }}\nsteps = {}\norder = \"XYZ\"\n{}\n",
            self.laser_ppm, self.setup_ppm, self.steps, self.program
        )
    }

    fn visit(&self, job: &Job) -> Visit {
        let design = Design::of(job, None, TIMES).unwrap();
        let mut variant = design.described.clone();
        variant.linear = self.linear.to_vec();
        design.visit(variant).unwrap()
    }
}

fn read(text: &str) -> Job {
    shown(Job::read_for(source("job.toml", text), UseOf::Figures))
}

/// Readings of a laser whose scale is off by so much in each set-up, 10⁻⁶.
fn scaled(machine: &Machine, readings: &Readings, ppm: &PerDiagonal<f64>) -> Readings {
    let at = |d: Diagonal, node| machine.volume.nominal_mm(d, PathKind::Step, node) / 1000.0;
    PerDiagonal::from_fn(|d| {
        let nodes = readings[d].iter().enumerate();
        nodes.map(|(node, um)| um + ppm[d] * at(d, node)).collect()
    })
}

/// The truth of a machine, and what a visit finds.
fn visited(row: &Row, planned: &Visit, job: &Job, seed: u64) -> (Machine, Separation) {
    let mut random = seeded(seed);
    let machine = Machine::random(&volume(row.size, row.steps), &mut random);
    let found = measured(row, planned, job, machine.clone(), &mut random);
    (machine.x_primary(), found)
}

fn measured(
    row: &Row,
    planned: &Visit,
    job: &Job,
    mut machine: Machine,
    random: &mut ChaCha8Rng,
) -> Separation {
    machine.lean_randomly(1e-4, random);
    let over = planned.expected.overrun;
    let laser = row.laser_ppm * normal(random);
    let ppm = PerDiagonal::from_fn(|_| laser + row.setup_ppm * normal(random));
    let mut passes = vec![(Pass::Forward, scaled(&machine, &machine.readings(None), &ppm))];
    let back = over.map(|_| (Pass::Reverse, scaled(&machine, &machine.readings(over), &ppm)));
    passes.extend(back);
    let all = noisy_runs(&passes, planned.variant.run.runs, row.noise.0, random);
    let truth = machine.x_primary();
    let line = |line: &MeasuredLine| {
        let axis = Axis::ALL.into_iter().find(|axis| line.direction[*axis] > 0.5).unwrap();
        let u = line.u_um_per_m.unwrap();
        let own = (u * u - row.laser_ppm * row.laser_ppm).sqrt();
        let slope = truth.slope(ErrorTerm { of: axis, along: axis });
        MeasuredLine { slope_um_per_m: slope + laser + own * normal(random), ..*line }
    };
    let lines = planned.lines.iter().map(line).collect();
    let mut measurement = simulated::measurement(&truth.volume, SetUp::Solve, Frame::XPrimary);
    measurement.overrun = over;
    let mut campaign = simulated::campaign(&measurement, lines);
    campaign.stated = job.measurement.uncertainty;
    // An axis that is measured by itself is measured in five runs in both directions at every target.
    let u_um = (2.0 / 5.0_f64).sqrt() * row.noise.0;
    for axis in &planned.variant.linear {
        let mut of = |_| Estimate { um: u_um * normal(random), u_um: Some(u_um) };
        campaign.reversals[*axis] = Some((0..=row.steps).map(&mut of).collect());
    }
    separate(&campaign, &all)
}

/// What a second measurement says of a machine whose tables take off what the first one found.
fn second_passes(row: &Row, planned: &Visit, job: &Job, seed: u64) -> bool {
    let (mut machine, found) = visited(row, planned, job, seed);
    for term in ErrorTerm::ALL {
        let found = &found.errors.mean[term].as_ref().unwrap().deviation_um;
        machine.curves[term].iter_mut().zip(found).for_each(|(um, found)| *um -= found);
    }
    let mut random = seeded(seed + 500_000);
    let second = measured(row, planned, job, machine, &mut random);
    let mut job = job.clone();
    job.measurement.uncertainty = StatedUncertainty::default(); // the table holds it
    let job = &job;
    let text = write(&draft(&second, job, Vec::new()));
    let model = ErrorModel::build(job, &ErrorTable::read(source("after.csv", &text)).unwrap());
    let model = model.unwrap();
    let plan = Plan { names: PerAxis::from_fn(|axis| vec![axis.to_string()]), ..Plan::default() };
    let after = AfterMeasurement::Errors(Box::new(model.clone()));
    let seen = compare(AsMeasured::alone(&model), &plan, None, None, &after, job).unwrap();
    seen.as_left.verdict(job.acceptance) == Verdict::Pass
}

/// Where a plan promises a second measurement that passes with some probability, as many do.
#[test]
fn as_many_second_measurements_pass_as_a_plan_promises() {
    let many = share(400, 10);
    const NONE: &str = "[measurement.uncertainty]\nangle_urad = 0\n";
    let [first, linear, three, turn, set_ups] = [0, 2, 4, 5, 7].map(|row| &ROWS[row]);
    let high =
        &Row { name: "linear X, Y and Z, reference at the high end", reference: 1.0, ..*linear };
    let middle = &Row { name: "three runs, reference in the middle", reference: 0.5, ..*three };
    let rows = [
        (first, 1.6),
        (linear, 1.7),
        (three, 1.7),
        (set_ups, 1.5),
        (turn, 1.6),
        (high, 1.7),
        (middle, 1.7),
    ];
    for (index, (row, factor)) in (0..).zip(rows) {
        let text = row.text().replace("[measurement.uncertainty]\n", NONE);
        let limit_um = factor * row.visit(&read(&text)).at_most_um().unwrap();
        let job = read(&format!("{text}[acceptance]\nmax_deviation_um = {limit_um}\n"));
        let planned = row.visit(&job);
        let promised = Design::of(&job, None, TIMES).unwrap().chance(&planned).unwrap();
        let seeds = (0..many).map(|visit| SEED + 2_000_000 * (index + 1) + visit);
        let passed = seeds.filter(|seed| second_passes(row, &planned, &job, *seed)).count();
        let passed = float(passed) / many as f64;
        let name = row.name;
        println!("{name}, limit {limit_um:.2} µm: promised {promised:.3}, passed {passed:.3}");
        let (low, high) = ((promised - 0.05).max(0.0), (promised + 0.05).min(1.0));
        let slack = 2.0 * (promised * (1.0 - promised) / many as f64).sqrt();
        let strict = (low - slack)..=(high + slack);
        assert!(is_held(passed, many as usize, low..=high, strict), "{}", row.name);
    }
}

/// How often the truth lay within the U of the plan; sums of the U of plan and readings.
#[derive(Default)]
struct Shares {
    held: Share,
    planned: f64,
    read: f64,
}

impl Shares {
    fn add(&mut self, error: f64, planned: f64, read: f64) {
        // What the frame sets to zero is not uncertain.
        if planned > 1e-9 {
            self.held.add(error, planned);
            self.planned += planned;
            self.read += read;
        }
    }

    fn ratio(&self) -> f64 {
        self.read / self.planned
    }
}

/// Points, far ends, squareness.
fn count(shares: &mut [Shares; 3], truth: &Machine, planned: &Separation, found: &Separation) {
    for term in ErrorTerm::ALL {
        let [plan, read] = [planned, found].map(|of| of.errors.mean[term].as_ref());
        let (Some(plan), Some(read)) = (plan, read) else {
            assert_eq!(plan.is_some(), read.is_some(), "{term}");
            continue;
        };
        for (index, wanted) in truth.curves[term].iter().enumerate() {
            let error = read.deviation_um[index] - wanted;
            let u = plan.expanded_um(index).unwrap();
            // One in a thousand visits finds its lines in contradiction, and gives no U.
            let of_readings = read.expanded_um(index).unwrap_or(u);
            shares[0].add(error, u, of_readings);
            if index + 1 == plan.deviation_um.len() {
                shares[1].add(error, u, of_readings);
            }
        }
    }
    for plane in Plane::ALL {
        let [plan, read] =
            [planned, found].map(|of| of.metric.squareness(plane).expanded_um_per_m());
        shares[2].add(squareness_error(truth, found, plane), plan.unwrap(), read.or(plan).unwrap());
    }
}

#[test]
fn the_u_of_a_plan_holds_the_truth_of_simulated_visits() {
    let many = share(VISITS, 25);
    let mut table = "| visit | points within U, % | U of the readings by U of the plan |\n| --- | ---: | ---: |".to_string();
    for (index, row) in (0..).zip(ROWS) {
        let job = read(&row.text());
        let planned = row.visit(&job);
        let mut shares = <[Shares; 3]>::default();
        for visit in 0..many {
            let seed = SEED + 1_000_000 * index + visit;
            let (truth, found) = visited(row, &planned, &job, seed);
            count(&mut shares, &truth, &planned.expected, &found);
        }
        judge(row, &shares, many);
        let (held, ratio) = (100.0 * shares[0].held.value(), shares[0].ratio());
        write!(table, "\n| {} | {held:.1} | {ratio:.3} |", row.name).unwrap();
    }
    println!("{table}");
    if is_whole() {
        let page = format!("{VISITS} visits of each row, seed {SEED}.\n\n{table}");
        published("plan", "plan", &page);
    }
}

/// 93 … 97 %, or 93 % and more where the same error of the laser is counted in several places. A part of the
/// visits scatters more: three standard deviations of as many visits are allowed to it (σ of 42 degrees of freedom: 11 %).
fn judge(row: &Row, shares: &[Shares; 3], many: u64) {
    let many = many as usize;
    let slack = if is_whole() { 0.0 } else { 3.0 * (0.0454 * 0.9546 / float(many)).sqrt() };
    let highest = if row.is_bound { 1.0 } else { 0.97 };
    for share in shares.iter().filter(|share| share.held.all > 0) {
        let (value, ratio) = (share.held.value(), share.ratio());
        let off = if is_whole() { 0.03 } else { 0.03 + 3.0 * 0.11 / float(many).sqrt() };
        let strict = 0.93 - slack..=highest + slack;
        assert!(is_held(value, many, 0.93..=highest, strict), "{}: {value}", row.name);
        assert!((ratio - 1.0).abs() < off, "{}: U of the readings {ratio}", row.name);
    }
}

/// Axes and what each change of the described run brings.
#[test]
fn a_variant_opens_what_it_measures_and_the_cheapest_that_will_do_is_found() {
    let text = "schema = 1\n[machine]\nname = \"VMC\"\n\
        axes.x = { travel_mm = [0.0, 800.0], reference_mm = 0.0 }\n\
        axes.y = { travel_mm = [0.0, 500.0], reference_mm = 0.0 }\n\
        axes.z = { travel_mm = [-400.0, 0.0], reference_mm = 0.0 }\n\
        [measurement]\nreadings = \"not-there.csv\"\nuncertainty = { noise_um = 0.5, angle_urad = 0, setup_ppm = 0 }\n\
        [measurement.step_diagonal]\nstart_mm = { x = 0.0, y = 0.0, z = -400.0 }\n\
        size_mm = { x = 800.0, y = 500.0, z = 400.0 }\nsteps = 8\norder = \"XYZ\"\n";
    let planned = |acceptance: &str| {
        let job = read(&format!("{text}{acceptance}"));
        let design = Design::of(&job, None, TIMES).unwrap();
        let VisitPlan { visits, forecast, second, .. } = plan(&design).unwrap();
        (job.acceptance, visits, forecast, second)
    };
    let (acceptance, open, forecast, _) = planned("");
    let described = &open[0];
    assert_eq!(described.open.len(), 3, "positioning: {:?}", described.open);
    assert!(!described.reaches(acceptance) && described.reversals().is_empty());
    let cheapest = &open[forecast.unwrap()];
    assert_eq!(cheapest.variant.linear.len(), 2, "two linear axes determine all");
    assert_eq!(cheapest.reversals(), cheapest.variant.linear);
    let u = |visit: &Visit| visit.at_most_um().unwrap();
    let limit = |um: f64| format!("[acceptance]\nmax_deviation_um = {um}\n");
    let (_, tight, forecast, second) = planned(&limit(0.8 * u(cheapest)));
    let better = &tight[forecast.unwrap()];
    assert!(better.minutes > cheapest.minutes && u(better) < 0.8 * u(cheapest));
    let sure = second.map(|index| &tight[index]);
    assert!(sure.is_none_or(|sure| sure.minutes >= better.minutes && sure.chance >= Some(0.8)));
    let never = short_or(None, Some(0.001)).map(|um| planned(&limit(um)));
    assert!(never.is_none_or(|(_, _, forecast, second)| forecast.is_none() && second.is_none()));
}

/// The job of the start, its acceptance as given, planned.
fn planned(max_deviation_um: &str, edit: (&str, &str), arguments: &str) -> visit::Ran {
    let visit = visit::Visit::new();
    visit.put("job.toml", fixture("start/readings/job.toml"));
    let limit = format!("max_deviation_um = {max_deviation_um}");
    visit.edit("job.toml", "max_deviation_um = 10.0", &limit).edit("job.toml", edit.0, edit.1);
    let ran = visit.run(&format!("plan job.toml {arguments}"));
    assert!(ran.err.is_empty(), "{}", ran.err);
    ran
}

const AS_IT_IS: (&str, &str) = ("steps = 4 ", "steps = 4 ");

#[test]
fn the_page_is_one_screen_and_the_document_holds_its_figures() {
    let text = planned("5.0", AS_IT_IS, "").ends(1).out;
    assert!(text.contains("; the acceptance (5 µm of every term) is not reached"), "{text}");
    assert!(text.lines().count() <= 45, "{text}");
    let Some(arguments) = short_or(None, Some("--format json")) else { return };
    let document = planned("5.0", AS_IT_IS, arguments).ends(1).json();
    let visits = document["visits"].as_array().unwrap();
    for visit in visits {
        let um = visit["together_expanded_um"].as_f64().unwrap();
        assert!(text.contains(&format!("{um:.3}")), "{text}");
    }
    let cheapest = document["best"].as_str().unwrap();
    let cheapest = visits.iter().find(|visit| visit["name"] == cheapest).unwrap();
    for visit in visits {
        let quicker = visit["minutes"].as_f64() < cheapest["minutes"].as_f64();
        assert!(!quicker || visit["reached"] == false || visit["spacing_mm"].is_object());
    }
    planned("9.0", AS_IT_IS, "-q").ends(0);
}

/// A set-up that is assumed, or a line without uncertainty, leaves no U: nothing is then reached.
#[test]
fn what_has_no_known_u_is_not_reached() {
    planned("900.0", AS_IT_IS, "-q").ends(0);
    let assumed = ("steps = 4 ", "setup = \"assume-perfect\"\nsteps = 4 ");
    planned("900.0", assumed, "").ends(1).says("U is not known for EXX, EYY, EZZ");
}
