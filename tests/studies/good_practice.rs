//! Good practice: whole visits to machines whose truth is known, judged by the program and, beside it, by a dense estimator
//! that knows nothing of it: from the same readings it solves all nine errors and mirrors at once by least squares, draws
//! what is stated, and judges by the same rule (docs/method.md §23). It is what the program could reach.
use super::causes::job_text;
use super::coverage_bounds::{Angle, Rigid, Shape, uniform, unit};
use crate::support::diagonals::{Machine, Readings, box_of, dot, float, normal, own, seeded};
use crate::support::{in_parallel, is_whole, published_if_whole, share, short_or};
use chacha20::ChaCha8Rng;
use nalgebra::{DMatrix, DVector};
use nonius::cli::answer;
use nonius::quantity::{Axis, Diagonal, Direction, ErrorTerm, PerAxis, PerDiagonal, Rotation};
use nonius::visit::files::Memory;
use serde_json::Value;
use std::fmt::Write;

const SEED: u64 = 1000;
const VISITS: u64 = 40;
const STEPS: usize = 18;
const SIZE: [f64; 3] = [900.0, 720.0, 720.0];
/// Of the slope of a linear axis, µm/m.
const U_LINE: f64 = 0.5;
/// Tool offset (µm) and scale (10⁻⁶) drift so far (one standard deviation), with this time constant (h).
const DRIFT: (f64, f64) = (0.7, 1.5);
/// Scatter of the place where an axis comes to rest, µm.
const REPEATABILITY_UM: f64 = 0.2;
const DRAWS: usize = 1000;

/// Of 40 visits under a limit (µm): how many kits have to pass at least, and how many second measurements.
type Limit = (f64, [Option<u64>; 2]);

struct Row {
    name: &'static str,
    runs: u32,
    /// σ of a reading, stated too, µm.
    noise: f64,
    /// Bound of the angles, stated too, µrad; of another shape than the bound means.
    urad: f64,
    is_other: bool,
    /// Scale from one set-up to the next, 10⁻⁶: of the readings, and as stated.
    setup: (f64, f64),
    linear: &'static [Axis],
    limits: &'static [Limit],
}

const ONE: Row = Row {
    name: "1 run, σ 0.3",
    runs: 1,
    noise: 0.3,
    urad: 10.0,
    is_other: false,
    setup: (0.0, 1.0),
    linear: &Axis::ALL,
    limits: &[(10.0, [Some(39), Some(38)]), (15.0, [Some(39), Some(38)])],
};

const ROWS: [Row; 7] = [
    ONE,
    Row {
        name: "1 run, σ 1",
        noise: 1.0,
        limits: &[(10.0, [None, None]), (15.0, [Some(40), Some(29)])],
        ..ONE
    },
    Row { name: "3 runs, σ 0.3", runs: 3, limits: &[(10.0, [Some(39), Some(38)])], ..ONE },
    Row {
        name: "3 runs, σ 1",
        runs: 3,
        noise: 1.0,
        limits: &[(10.0, [Some(39), Some(33)]), (15.0, [Some(40), Some(39)])],
        ..ONE
    },
    Row { name: "20 µrad", urad: 20.0, limits: &[(12.0, [Some(36), None])], ..ONE },
    Row {
        name: "20 µrad of another shape",
        urad: 20.0,
        is_other: true,
        limits: &[(12.0, [Some(36), None]), (10.0, [None, None])],
        ..ONE
    },
    Row {
        name: "two linear axes, scales by 3.4·10⁻⁶",
        setup: (3.45, 3.4),
        linear: &[Axis::X, Axis::Y],
        limits: &[(14.0, [Some(36), None]), (10.0, [None, None])],
        ..ONE
    },
];

impl Row {
    /// By the share of the travel: as the bound means it, or a line and a bow that are 0 at the low end.
    fn angle(&self, random: &mut ChaCha8Rng) -> Angle {
        if !self.is_other {
            return Shape::Meant.drawn(self.urad, random);
        }
        let [one, other] = [(); 2].map(|()| self.urad * uniform(random));
        Box::new(move |s| 0.4 * one * s + 0.6 * other * 4.0 * s * (1.0 - s))
    }

    fn job(&self, of: &Session, active: &str, limit: f64) -> String {
        let line = |(axis, slope): &(Axis, f64)| {
            format!(
                "[[measurement.step_diagonal.linear]]\naxis = \"{axis}\"\nslope_um_per_m = {slope}\nu_um_per_m = {U_LINE}\n"
            )
        };
        let (Row { noise, urad, setup: (_, setup), .. }, [x, y, z]) = (self, SIZE);
        let measurement = format!(
            "readings = \"{}.csv\"\nactive_while_measuring = \"{active}\"\n\
             [measurement.uncertainty]\nnoise_um = {noise}\nangle_urad = {urad}\nbeam_mrad = 0.5\nsetup_ppm = {setup}\n\
             [measurement.step_diagonal]\nstart_mm = {{ x = 0, y = 0, z = 0 }}\nsize_mm = {{ x = {x}, y = {y}, z = {z} }}\nsteps = {STEPS}\norder = \"XYZ\"\n{}",
            of.name,
            of.lines.iter().map(line).collect::<String>(),
        );
        let acceptance = format!("max_deviation_um = {limit}");
        let parts = (measurement.as_str(), "controller = \"generic\"", acceptance.as_str());
        let text = job_text([("x", 0.0, x), ("y", 0.0, y), ("z", 0.0, z)], parts, float(STEPS), "");
        text.replace("\"M\"", "\"M\"\nchain = \"wXYZt\"")
    }
}

/// What was measured in one go: readings (CSV, and their means for the estimator), and slopes of linear axes, µm/m.
struct Session {
    name: &'static str,
    csv: String,
    means: Readings,
    lines: Vec<(Axis, f64)>,
    ends_h: f64,
}

struct Drift {
    scale_ppm: PerAxis<f64>,
    offset_um: PerAxis<f64>,
}

impl Drift {
    fn drawn(random: &mut ChaCha8Rng) -> Drift {
        let (um, ppm) = (DRIFT.0, DRIFT.0 / 0.7);
        let offset_um = PerAxis::from_fn(|_| um * normal(random));
        Drift { offset_um, scale_ppm: PerAxis::from_fn(|_| ppm * normal(random).abs()) }
    }

    /// Its share after so many hours.
    fn grown(hours: f64) -> f64 {
        1.0 - (-hours / DRIFT.1).exp()
    }

    /// µm at a place (mm from the low corner).
    fn at(&self, hours: f64, mm: PerAxis<f64>) -> PerAxis<f64> {
        let grown = Drift::grown(hours);
        PerAxis::from_fn(|axis| {
            grown * (self.offset_um[axis] + 1e-3 * self.scale_ppm[axis] * mm[axis])
        })
    }
}

fn measured(
    name: &'static str,
    row: &Row,
    rigid: &mut Rigid,
    drift: &Drift,
    begins_h: f64,
    random: &mut ChaCha8Rng,
) -> Session {
    let volume = box_of(STEPS);
    rigid.set_up(1e-4, 3e-4, random);
    let truth = rigid.truth();
    let line = |(at, axis): (usize, &Axis)| {
        let warmed = Drift::grown(begins_h + 0.3 * float(at)) * drift.scale_ppm[*axis];
        (*axis, truth.slope(own(*axis)) + warmed + U_LINE * normal(random))
    };
    let lines = row.linear.iter().enumerate().map(line).collect();
    let clean = rigid.readings(None);
    let (mut hours, mut csv) =
        (begins_h + 0.9, "diagonal,run,direction,node,moved,deviation_um\n".to_string());
    let means = PerDiagonal::from_fn(|d| {
        hours += 0.5;
        let (laser, ppm) = (volume.laser(d), row.setup.0 * normal(random));
        let start = |axis: Axis| match d.forward(axis) {
            Direction::Plus => 0.0,
            Direction::Minus => SIZE[axis as usize],
        };
        let mut sums = vec![0.0; 3 * STEPS + 1];
        for run in 1..=row.runs {
            let mut rest = PerAxis::from_fn(|_| REPEATABILITY_UM * normal(random));
            let mut first = 0.0;
            for node in 0..=3 * STEPS {
                hours += 6.0 / 3600.0;
                let (way, _) = rigid.nine.state(d, node, None);
                let mut moved = String::new();
                if node > 0 {
                    let axis = Axis::ALL[(node - 1) % 3];
                    rest[axis] = REPEATABILITY_UM * normal(random);
                    moved = axis.to_string().to_lowercase();
                }
                let off =
                    drift.at(hours, PerAxis::from_fn(|axis| start(axis) + way[axis])).plus(rest);
                let um = clean[d][node]
                    + dot(&laser, &off)
                    + 1e-3 * ppm * dot(&laser, &way)
                    + row.noise * normal(random);
                first = if node == 0 { um } else { first };
                sums[node] += (um - first) / f64::from(row.runs);
                writeln!(csv, "{d},{run},forward,{node},{moved},{:.4}", um - first).unwrap();
            }
        }
        sums
    });
    Session { name, csv, means, lines, ends_h: hours }
}

/// Takes off the corrections of a kit; gives how far its errors lie from those of the estimator, µm.
fn compensate(nine: &mut Machine, kit: &str, found: &DVector<f64>) -> f64 {
    let mut rows = kit.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = rows.next().unwrap();
    let column = |name: &str| header.iter().position(|own| *own == name).unwrap();
    let [term, index, um] = ["term", "index", "correction_um"].map(column);
    let apart = |row: Vec<&str>| {
        let term = ErrorTerm::from_name(row[term]).unwrap();
        let (node, um) = (row[index].parse().unwrap(), row[um].parse::<f64>().unwrap());
        nine.curves[term][node] += um;
        if node == 0 { um.abs() } else { (found[place(term, node)] + um).abs() }
    };
    rows.map(apart).fold(0.0, f64::max)
}

/// Where the error of a node, 1 … n, stands in a vector of all.
fn place(term: ErrorTerm, node: usize) -> usize {
    (3 * (term.along as usize) + term.of as usize) * STEPS + node - 1
}

fn vector(machine: &Machine) -> DVector<f64> {
    let mut all = DVector::zeros(9 * STEPS);
    for term in ErrorTerm::ALL {
        (1..=STEPS).for_each(|node| all[place(term, node)] = machine.curves[term][node]);
    }
    all
}

/// The dense estimator of a row, and what was drawn of its errors, a column each.
struct Dense {
    /// Readings and slopes → nine errors in the X-primary frame.
    gain: DMatrix<f64>,
    /// Readings and slopes → what is left over, and its square by a noise of 1 µm.
    rest: DMatrix<f64>,
    square: f64,
    /// Of a noise of 1 µm; of lines and set-ups; of angles.
    noise: DMatrix<f64>,
    each_time: DMatrix<f64>,
    angles: DMatrix<f64>,
}

const INCREMENTS: usize = 4 * 3 * STEPS;

/// Increments of all diagonals, then the slopes of linear axes.
fn data(readings: &Readings, slopes: impl Iterator<Item = f64>) -> DVector<f64> {
    let increments = |d| readings[d].windows(2).map(|two| two[1] - two[0]);
    let all = Diagonal::ALL.into_iter().flat_map(increments);
    DVector::from_vec(all.chain(slopes).collect())
}

impl Dense {
    fn of(row: &Row) -> Dense {
        let design = design(row.linear);
        let (rows, columns) = design.shape();
        // Increments count alike; a line, as it stands beside the total of a diagonal.
        let (setup, length) = (row.setup.1, SIZE.map(|mm| mm * mm).iter().sum::<f64>().sqrt());
        let total =
            2.0 * row.noise * row.noise / f64::from(row.runs) + (1e-3 * setup * length).powi(2);
        let of_line = total / float(3 * STEPS) / (U_LINE * U_LINE + setup * setup);
        let weight = |row: usize| if row < INCREMENTS { 1.0 } else { of_line };
        let weighted = DMatrix::from_fn(columns, rows, |c, r| design[(r, c)] * weight(r));
        // What no reading sees (the frame) stays near 0 and is turned away behind.
        let equations = &weighted * &design + DMatrix::identity(columns, columns) * 1e-7;
        let solve = equations.cholesky().unwrap().solve(&weighted);
        let rest = DMatrix::identity(rows, rows) - &design * &solve;
        let gain = solve.column_iter().map(|errors| {
            let mut machine = Machine::perfect(&box_of(STEPS));
            for term in ErrorTerm::ALL {
                (1..=STEPS).for_each(|node| machine.curves[term][node] = errors[place(term, node)]);
            }
            vector(&machine.x_primary())
        });
        let gain = DMatrix::from_columns(&gain.collect::<Vec<_>>());
        let mut random = seeded(SEED);
        let mut drawn = |of: &mut dyn FnMut(&mut ChaCha8Rng) -> DVector<f64>| {
            let columns: Vec<_> = (0..DRAWS).map(|_| of(&mut random)).collect();
            DMatrix::from_columns(&columns)
        };
        let noise = drawn(&mut |random| {
            let readings =
                PerDiagonal::from_fn(|_| (0..=3 * STEPS).map(|_| normal(random)).collect());
            data(&readings, row.linear.iter().map(|_| 0.0))
        });
        let volume = box_of(STEPS);
        let machine = Machine::perfect(&volume);
        let each_time = drawn(&mut |random| {
            let readings = PerDiagonal::from_fn(|d| {
                let (laser, ppm) = (volume.laser(d), setup * normal(random));
                let um = |node| 1e-3 * ppm * dot(&laser, &machine.state(d, node, None).0);
                (0..=3 * STEPS).map(um).collect()
            });
            data(&readings, row.linear.iter().map(|_| U_LINE.hypot(setup) * normal(random)))
        });
        let shapes: [fn(f64) -> f64; 2] = [|s| 2.0 * s - 1.0, |s| -(2.0 * s - 1.0).powi(2)];
        let patterns: Vec<DVector<f64>> = Rotation::all()
            .flat_map(|rotation| shapes.map(|shape| (rotation, shape)))
            .map(|(rotation, shape)| {
                let angles: Vec<(Rotation, Angle)> = vec![(rotation, Box::new(shape))];
                let rigid = Rigid::new(machine.clone(), angles);
                let truth = rigid.truth();
                let slopes = row.linear.iter().map(|axis| truth.slope(own(*axis)));
                &gain * data(&rigid.readings(None), slopes) - vector(&truth)
            })
            .collect();
        let angles = drawn(&mut |random| {
            let sizes = patterns.iter().map(|of| of * (row.urad / 2.0 * uniform(random)));
            sizes.sum::<DVector<f64>>()
        });
        let square = (&rest * &noise).norm_squared() / float(DRAWS);
        let (noise, each_time) = (&gain * noise, &gain * each_time);
        Dense { gain, rest, square, noise, each_time, angles }
    }

    /// Nine errors and the standard deviation of a mean of readings that is found with them.
    fn found(&self, of: &Session) -> (DVector<f64>, f64) {
        let data = data(&of.means, of.lines.iter().map(|(_, slope)| *slope));
        let mut rest = &self.rest * &data;
        rest.rows_mut(INCREMENTS, data.len() - INCREMENTS).fill(0.0);
        let sigma = (rest.norm_squared() / self.square).sqrt();
        (&self.gain * data, sigma)
    }

    /// The most that tables from these readings leave, 95 %.
    fn forecast(&self, sigma: f64) -> f64 {
        let error = |draw: usize| {
            let sum = self.noise.column(draw) * sigma
                + self.each_time.column(draw)
                + self.angles.column(draw);
            sum.amax()
        };
        quantile((0..DRAWS).map(error).collect())
    }

    /// The most that a second measurement leaves: angles are common, the rest is new each time.
    fn as_left(&self, found: &DVector<f64>, sigma: f64) -> f64 {
        let mean_square = |of: &DMatrix<f64>| of.component_mul(of).column_mean();
        let u = mean_square(&self.noise) * (sigma * sigma) + mean_square(&self.each_time);
        let mut random = seeded(SEED);
        let most = |draw: usize| {
            let g = normal(&mut random);
            let seen = found + self.angles.column(draw);
            seen.iter().zip(u.iter()).map(|(um, u)| um.abs() + g * u.sqrt()).fold(0.0, f64::max)
        };
        quantile((0..DRAWS).map(most).collect())
    }
}

fn quantile(mut all: Vec<f64>) -> f64 {
    all.sort_by(f64::total_cmp);
    all[DRAWS * 95 / 100]
}

/// Nine errors, two leans of each mirror (mrad) → increments, µm, and slopes, µm/m: what each of them alone shows.
fn design(linear: &[Axis]) -> DMatrix<f64> {
    let perfect = Machine::perfect(&box_of(STEPS));
    let shown = |machine: &Machine| {
        data(&machine.readings(None), linear.iter().map(|axis| machine.slope(own(*axis))))
    };
    let mut columns = vec![DVector::zeros(0); 9 * STEPS];
    for (term, node) in ErrorTerm::ALL.into_iter().flat_map(|t| (1..=STEPS).map(move |n| (t, n))) {
        let mut machine = perfect.clone();
        machine.curves[term][node] = 1.0;
        columns[place(term, node)] = shown(&machine);
    }
    for d in Diagonal::ALL {
        let laser = perfect.volume.laser(d);
        let across = unit(laser.cross(PerAxis { x: 0.0, y: 0.0, z: 1.0 }));
        for lean in [across, laser.cross(across)] {
            let mut machine = perfect.clone();
            // So small that its square is none.
            machine.lean[d] = lean.times(1e-7);
            columns.push(shown(&machine) * 1e4);
        }
    }
    DMatrix::from_columns(&columns)
}

/// One visit: the true largest error, what it is at most for program and estimator (kit, second measurement), who
/// passes it, and how far their tables lie apart; µm.
struct Visited {
    truth: f64,
    at_most: [[f64; 2]; 2],
    passes: [[bool; 2]; 2],
    apart: f64,
}

fn visited(row: &Row, limit: f64, dense: &Dense, seed: u64) -> Visited {
    let mut random = seeded(seed);
    let angles = Rotation::all().map(|rotation| (rotation, row.angle(&mut random))).collect();
    let mut rigid = Rigid::new(Machine::random(&box_of(STEPS), &mut random), angles);
    let drift = Drift::drawn(&mut random);
    let first = measured("job", row, &mut rigid, &drift, 0.0, &mut random);
    let (found, sigma) = dense.found(&first);
    let forecast = dense.forecast(sigma);
    let files = Memory::of([
        ("job.toml", row.job(&first, "none", limit).as_bytes()),
        ("job.csv", first.csv.as_bytes()),
    ]);
    let said = |files: &Memory, words: &str| {
        let said = answer(files, words.split(' '));
        assert!(said.status < 2, "{}", said.err);
        said.out
    };
    said(&files, "generate job.toml -o kit");
    let mut all = files.all();
    let kit = String::from_utf8(all["kit/compensation.csv"].clone()).unwrap();
    let apart = compensate(&mut rigid.nine, &kit, &found);
    let truth = vector(&rigid.truth()).amax();
    let second = measured("after", row, &mut rigid, &drift, first.ends_h + 0.3, &mut random);
    let (left, sigma) = dense.found(&second);
    let ideal = [forecast, dense.as_left(&left, sigma)];
    let job = row.job(&second, "kit", limit);
    all.extend([("after.toml".into(), job.into()), ("after.csv".into(), second.csv.into())]);
    let files = Memory::of(all.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice())));
    let said = ["", " --after after.toml"].map(|after| -> Value {
        let words = format!("verify job.toml --tables kit --format json{after}");
        serde_json::from_slice(&said(&files, &words)).unwrap()
    });
    let own = [0, 1].map(|at| said[at]["max_residual_at_most_um"].as_f64().unwrap());
    let passes = [[0, 1].map(|at| said[at]["verdict"] == "pass"), ideal.map(|um| um <= limit)];
    println!("{}, {seed}: {truth:.2} µm, at most {own:.2?}, dense {ideal:.2?}", row.name);
    Visited { truth, at_most: [own, ideal], passes, apart }
}

#[test]
fn visits_of_good_practice_pass_as_a_dense_estimator_says() {
    let many = share(VISITS, 1);
    let mut list = format!("{many} visits of each row, seed {SEED}.\n");
    for row in short_or(&ROWS[..1], &ROWS) {
        let dense = Dense::of(row);
        write!(list, "\n* {}:", row.name).unwrap();
        for (number, limit) in row.limits[..short_or(1, row.limits.len())].iter().enumerate() {
            let between = if number == 0 { "" } else { " ·" };
            list += &format!("{between} {}", under_limit(row, limit, &dense, many));
        }
    }
    println!("{list}");
    published_if_whole("good practice", "good_practice", &list);
}

fn under_limit(row: &Row, (limit, wanted): &Limit, dense: &Dense, many: u64) -> String {
    let visits = in_parallel(0..many, |seed| visited(row, *limit, dense, SEED + seed));
    for Visited { at_most: [own, ideal], apart, .. } in &visits {
        // The step formula weighs lines and totals a little otherwise.
        assert!(*apart < 0.5, "{}: tables {apart} µm apart", row.name);
        let is_near = own.iter().zip(ideal).all(|(own, ideal)| (own / ideal - 1.0).abs() < 0.3);
        assert!(is_near, "{}: {own:?}, dense {ideal:?}", row.name);
    }
    let count = |of: &dyn Fn(&Visited) -> bool| visits.iter().filter(|own| of(own)).count();
    let is_bad = |of: &Visited| of.truth > *limit;
    let passed = |who: usize| [0, 1].map(|what| count(&|of| of.passes[who][what]));
    let ([kits, seconds], [best_kits, best_seconds]) = (passed(0), passed(1));
    for (passed, wanted) in [kits, seconds].into_iter().zip(wanted) {
        let held = wanted.is_none_or(|wanted| passed as u64 * 40 >= wanted * many);
        assert!(held || !is_whole(), "{}: {passed} of {many} pass", row.name);
    }
    let wrong = [0, 1].map(|what| count(&|of| of.passes[0][what] && is_bad(of)));
    let bad = match count(&is_bad) {
        0 => String::new(),
        bad => format!(", {bad} bad: {}, {} pass", wrong[0], wrong[1]),
    };
    format!("{limit} µm {kits} ({best_kits}), {seconds} ({best_seconds}){bad}")
}
