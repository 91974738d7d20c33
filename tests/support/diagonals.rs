//! Readings of step diagonals, simulated with arithmetic of the tests' own: a machine of nine
//! curves, a mirror with a normal of its own in each set-up, lost motion, noise.
use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;
use nonius::inputs::job::{DiagonalMeasurement, Frame, Reflector, SetUp, StatedUncertainty};
use nonius::machine::separation::corrections::AngleEffects;
use nonius::machine::separation::{Campaign, MeasuredLine, SeparatedError, Separation, separate};
use nonius::quantity::{
    Axis, Deviation, Diagonal, Direction, ErrorTerm, Millimetres, Pass, PathKind, PerAxis,
    PerDiagonal, PerTerm, Plane, Run, Volume,
};
use rand_distr::{Distribution, StandardNormal};

/// Noise of a reading, µm, and standard uncertainty of the slope of a linear axis, µm/m, of most machines.
pub(crate) const SIGMA_UM: f64 = 0.3;
pub(crate) const U_LINE_UM_PER_M: f64 = 0.5;

pub(crate) type Readings = PerDiagonal<Vec<f64>>;

#[derive(Clone, Debug)]
pub(crate) struct Machine {
    pub volume: Volume,
    /// At the interval ends, µm; the first is 0.
    pub curves: PerTerm<Vec<f64>>,
    /// Lost motion of each axis, µm: the curve moving in − lies this much below.
    pub lost_um: PerAxis<f64>,
    /// Beside it, moving + less moving −, µm.
    pub apart_um: PerTerm<Vec<f64>>,
    /// η: lean of the mirror's normal beside the diagonal, rad.
    pub lean: PerDiagonal<PerAxis<f64>>,
}

pub(crate) fn mm(x: f64, y: f64, z: f64) -> PerAxis<Millimetres> {
    PerAxis { x: Millimetres::new(x), y: Millimetres::new(y), z: Millimetres::new(z) }
}

pub(crate) fn volume(size: [f64; 3], steps: usize) -> Volume {
    let [x, y, z] = size;
    Volume { start: mm(0.0, 0.0, 0.0), size: mm(x, y, z), steps, order: Axis::ALL }
}

pub(crate) fn box_of(steps: usize) -> Volume {
    volume([900.0, 720.0, 720.0], steps)
}

/// The positioning error of an axis.
pub(crate) fn own(axis: Axis) -> ErrorTerm {
    ErrorTerm { of: axis, along: axis }
}

pub(crate) fn seeded(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

pub(crate) fn normal(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

pub(crate) fn float(count: usize) -> f64 {
    count as f64
}

impl Machine {
    pub(crate) fn perfect(volume: &Volume) -> Machine {
        Machine {
            volume: volume.clone(),
            curves: PerTerm::from_fn(|_| vec![0.0; volume.steps + 1]),
            lost_um: PerAxis::default(),
            apart_um: PerTerm::from_fn(|_| vec![0.0; volume.steps + 1]),
            lean: PerDiagonal::default(),
        }
    }

    /// Straight lines and a bow of some micrometres with a waviness on it.
    pub(crate) fn random(volume: &Volume, random: &mut ChaCha8Rng) -> Machine {
        Machine::waving(volume, |_| 1.0, random)
    }

    /// The same, each curve with a waviness of some size.
    pub(crate) fn waving(
        volume: &Volume,
        size: impl Fn(ErrorTerm) -> f64,
        random: &mut ChaCha8Rng,
    ) -> Machine {
        let mut machine = Machine::perfect(volume);
        for term in ErrorTerm::ALL {
            let (slope, bow, wave) = (normal(random), normal(random), size(term) * normal(random));
            let at =
                |t: f64| 10.0 * slope * t + 12.0 * bow * t * (1.0 - t) + wave * (19.0 * t).sin();
            machine.set(term, at);
        }
        machine
    }

    /// A curve by its share of the travel, 0 … 1.
    pub(crate) fn set(&mut self, term: ErrorTerm, at: impl Fn(f64) -> f64) {
        let n = self.volume.steps;
        self.curves[term] = (0..=n).map(|i| at(float(i) / float(n)) - at(0.0)).collect();
    }

    /// Slope of the line through the ends, µm/m.
    pub(crate) fn slope(&self, term: ErrorTerm) -> f64 {
        self.curves[term].last().unwrap() * 1000.0 / self.volume.size[term.along].mm()
    }

    /// A curve of one direction, µm; 0 where the axis moves in + at its low end.
    pub(crate) fn directed(&self, term: ErrorTerm, way: Direction) -> Vec<f64> {
        let (side, apart) = (if way == Direction::Plus { 0.5 } else { -0.5 }, &self.apart_um[term]);
        let own = term.is_positioning() && way == Direction::Minus;
        let lost = if own { self.lost_um[term.along] } else { 0.0 };
        let both = self.curves[term].iter().zip(apart);
        both.map(|(um, b)| um + side * b - apart[0] / 2.0 - lost).collect()
    }

    /// An error table in one direction or both: `value` makes of term, direction, mm and error (µm) what stands there.
    pub(crate) fn error_table(
        &self,
        both_ways: bool,
        decimals: usize,
        u_um: Option<f64>,
        mut value: impl FnMut(ErrorTerm, Direction, f64, f64) -> Option<f64>,
    ) -> String {
        let ways = match both_ways {
            true => &[(Direction::Plus, "+"), (Direction::Minus, "-")][..],
            false => &[(Direction::Plus, "")],
        };
        let ways = Axis::ALL.into_iter().flat_map(|axis| ways.iter().map(move |way| (axis, *way)));
        let head = if u_um.is_some() { ",u_ex_um,u_ey_um,u_ez_um" } else { "" };
        let mut csv = format!("axis,direction,position_mm,ex_um,ey_um,ez_um{head}\n");
        for (along, (way, sign)) in ways {
            for (index, at) in self.volume.positions(along).iter().enumerate() {
                let um = Axis::ALL.map(|of| {
                    let term = ErrorTerm { of, along };
                    value(term, way, at.mm(), self.directed(term, way)[index])
                });
                let u = um.iter().filter(|_| u_um.is_some()).map(|um| um.and(u_um));
                let u = u.map(|u| u.map_or(String::new(), |u| u.to_string()));
                let um =
                    um.iter().map(|um| um.map_or(String::new(), |um| format!("{um:.decimals$}")));
                let cells = um.chain(u).collect::<Vec<_>>().join(",");
                csv += &format!("{},{sign},{},{cells}\n", along.key(), at.mm());
            }
        }
        csv
    }

    /// The same machine in the X-primary frame: EYX, EZX, EZY without slope.
    pub(crate) fn x_primary(&self) -> Machine {
        let mut turned = self.clone();
        for term in ErrorTerm::ALL {
            let twin = ErrorTerm { of: term.along, along: term.of };
            let slope = match term.of.cmp(&term.along) {
                std::cmp::Ordering::Equal => continue,
                std::cmp::Ordering::Less => self.slope(twin),
                std::cmp::Ordering::Greater => -self.slope(term),
            };
            let end = slope * self.volume.size[term.along].mm() / 1000.0;
            let n = self.volume.steps;
            for i in 0..=n {
                turned.curves[term][i] += end * float(i) / float(n);
            }
        }
        turned
    }

    /// Slope of what makes a plane not square, µm/m.
    pub(crate) fn squareness(&self, plane: Plane) -> f64 {
        let (of, along) = plane.axes();
        self.slope(ErrorTerm { of, along })
    }

    /// A random lean of `size` rad in every set-up.
    pub(crate) fn lean_randomly(&mut self, size: f64, random: &mut ChaCha8Rng) {
        for d in Diagonal::ALL {
            let u = self.laser(d);
            let any = PerAxis::from_fn(|_| normal(random));
            let beside = any.minus(u.times(dot(&any, &u)));
            let length = dot(&beside, &beside).sqrt();
            self.lean[d] = PerAxis::from_fn(|axis| size * beside[axis] / length);
        }
    }

    fn laser(&self, diagonal: Diagonal) -> PerAxis<f64> {
        let size = PerAxis::from_fn(|axis| self.volume.size[axis].mm());
        let length = dot(&size, &size).sqrt();
        PerAxis::from_fn(|axis| signs(diagonal)[axis as usize] * size[axis] / length)
    }

    /// Commanded travel of every axis from the start corner (mm), and its error there (µm).
    pub(crate) fn state(
        &self,
        diagonal: Diagonal,
        node: usize,
        back: Option<bool>,
    ) -> (PerAxis<f64>, PerAxis<f64>) {
        let n = self.volume.steps;
        let made = PerAxis::from_fn(|axis| {
            let turn = self.volume.order.iter().position(|a| *a == axis).unwrap();
            node / 3 + usize::from(node % 3 > turn)
        });
        let sign = |axis: Axis| signs(diagonal)[axis as usize];
        let mut error = PerAxis::default();
        for along in Axis::ALL {
            let from_low = if sign(along) > 0.0 { made[along] } else { n - made[along] };
            // Without overrun an axis has not reversed before its first move back.
            let reversed = back.is_some_and(|overrun| overrun || made[along] < n);
            let minus = (sign(along) < 0.0) != reversed;
            for of in Axis::ALL {
                let term = ErrorTerm { of, along };
                let side = if minus { -0.5 } else { 0.5 };
                error[of] += self.curves[term][from_low] + side * self.apart_um[term][from_low];
            }
            error[along] -= if minus { self.lost_um[along] } else { 0.0 };
        }
        let travel =
            |axis: Axis| sign(axis) * self.volume.size[axis].mm() * float(made[axis]) / float(n);
        (PerAxis::from_fn(travel), error)
    }

    /// Readings of a pass; `back`: whether the axes ran past the end point before the way back.
    pub(crate) fn readings(&self, back: Option<bool>) -> Readings {
        PerDiagonal::from_fn(|d| {
            let u = self.laser(d);
            let leant = u.plus(self.lean[d]);
            let length = dot(&leant, &leant).sqrt();
            let g = PerAxis::from_fn(|axis| leant[axis] / length);
            let (beside, (_, first)) = (g.minus(u), self.state(d, 0, None));
            let um = |node| {
                let (travel, error) = self.state(d, node, back);
                1000.0 * dot(&beside, &travel) + dot(&g, &error.minus(first))
            };
            (0..=3 * self.volume.steps).map(um).collect()
        })
    }

    /// Positioning slopes of some axes as a linear measurement gives them.
    pub(crate) fn lines(&self, axes: &[Axis], u_um_per_m: Option<f64>) -> Vec<MeasuredLine> {
        let line = |axis: &Axis| MeasuredLine {
            direction: PerAxis::from_fn(|other| f64::from(other == *axis)),
            slope_um_per_m: self.slope(own(*axis)),
            u_um_per_m,
            ends: None,
        };
        axes.iter().map(line).collect()
    }
}

fn signs(diagonal: Diagonal) -> [f64; 3] {
    match diagonal {
        Diagonal::Ppp => [1.0, 1.0, 1.0],
        Diagonal::Npp => [-1.0, 1.0, 1.0],
        Diagonal::Pnp => [1.0, -1.0, 1.0],
        Diagonal::Ppn => [1.0, 1.0, -1.0],
    }
}

pub(crate) fn dot(a: &PerAxis<f64>, b: &PerAxis<f64>) -> f64 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

pub(crate) fn runs(number: u32, pass: Pass, readings: &Readings) -> Vec<Run> {
    let one = |diagonal: Diagonal| {
        let deviations = readings[diagonal].iter().map(|um| Deviation::from_um(*um)).collect();
        Run { diagonal, number, pass, deviations, temperatures_c: PerAxis::default() }
    };
    Diagonal::ALL.map(one).into()
}

pub(crate) fn with_noise(readings: &Readings, sigma: f64, random: &mut ChaCha8Rng) -> Readings {
    PerDiagonal::from_fn(|d| readings[d].iter().map(|um| um + sigma * normal(random)).collect())
}

/// Runs of a visit with noise; `back`: reverse passes, too, and whether after an overrun.
pub(crate) fn visit_runs(
    readings: impl Fn(Option<bool>) -> Readings,
    back: Option<bool>,
    repeats: u32,
    sigma: f64,
    random: &mut ChaCha8Rng,
) -> Vec<Run> {
    let mut passes = vec![(Pass::Forward, readings(None))];
    passes.extend(back.map(|_| (Pass::Reverse, readings(back))));
    let mut all = Vec::new();
    for number in 1..=repeats {
        for (pass, readings) in &passes {
            all.extend(runs(number, *pass, &with_noise(readings, sigma, random)));
        }
    }
    all
}

/// Readings of lasers whose scale is off by so much in each set-up, 10⁻⁶.
pub(crate) fn stretched(volume: &Volume, readings: &Readings, ppm: &PerDiagonal<f64>) -> Readings {
    PerDiagonal::from_fn(|d| {
        let metres = |node| volume.nominal_mm(d, PathKind::Step, node) / 1000.0;
        let nodes = readings[d].iter().enumerate();
        nodes.map(|(node, um)| um + ppm[d] * metres(node)).collect()
    })
}

/// A laser and a beam without error.
pub(crate) fn exact() -> StatedUncertainty {
    let zero = Some(0.0);
    StatedUncertainty { laser_ppm: zero, beam_mrad: zero, ..StatedUncertainty::default() }
}

/// Positioning slopes of some axes, each wrong by its uncertainty.
pub(crate) fn noisy_lines(
    truth: &Machine,
    axes: &[Axis],
    u_um_per_m: f64,
    random: &mut ChaCha8Rng,
) -> Vec<MeasuredLine> {
    let mut lines = truth.lines(axes, Some(u_um_per_m));
    for line in &mut lines {
        line.slope_um_per_m += u_um_per_m * normal(random);
    }
    lines
}

/// How far the squareness found lies beside that of the machine, µm/m.
pub(crate) fn squareness_error(truth: &Machine, found: &Separation, plane: Plane) -> f64 {
    found.metric.squareness(plane).um_per_m.unwrap() - truth.squareness(plane)
}

/// The same, and its expanded uncertainty.
pub(crate) fn squareness_off(truth: &Machine, found: &Separation, plane: Plane) -> (f64, f64) {
    let expanded = found.metric.squareness(plane).expanded_um_per_m().unwrap();
    (squareness_error(truth, found, plane), expanded)
}

#[derive(Clone, Copy, Default)]
pub(crate) struct Share {
    inside: usize,
    pub all: usize,
}

impl Share {
    pub(crate) fn add(&mut self, error: f64, expanded: f64) {
        self.inside += usize::from(error.abs() <= expanded);
        self.all += 1;
    }

    pub(crate) fn value(self) -> f64 {
        float(self.inside) / float(self.all)
    }
}

pub(crate) fn measurement(volume: &Volume, setup: SetUp, frame: Frame) -> DiagonalMeasurement {
    DiagonalMeasurement {
        readings: String::new(),
        kind: PathKind::Step,
        volume: volume.clone(),
        laser_sign: Direction::Plus,
        setup,
        frame,
        target: Reflector::FlatMirror,
        overrun: None,
        linear: Vec::new(),
        beams: Vec::new(),
        material: None,
        closure_errors: None,
    }
}

pub(crate) fn campaign(
    measurement: &DiagonalMeasurement,
    lines: Vec<MeasuredLine>,
) -> Campaign<'_> {
    Campaign {
        measurement,
        stated: exact(),
        lines,
        reversals: Default::default(),
        angles: AngleEffects::unmeasured(None),
        reverse_zero_known: true,
    }
}

/// Naive: mirror assumed perfect, slopes as they fall out.
pub(crate) fn naive(volume: &Volume, runs: &[Run]) -> Separation {
    let measurement = measurement(volume, SetUp::AssumePerfect, Frame::AsMeasured);
    separate(&campaign(&measurement, Vec::new()), runs)
}

/// The set-up solved for, X primary.
pub(crate) fn solved(volume: &Volume, lines: Vec<MeasuredLine>, runs: &[Run]) -> Separation {
    let measurement = measurement(volume, SetUp::Solve, Frame::XPrimary);
    separate(&campaign(&measurement, lines), runs)
}

/// What was found of a term, both directions together.
pub(crate) fn mean(separation: &Separation, term: ErrorTerm) -> &SeparatedError {
    separation.errors.mean[term].as_ref().unwrap()
}

pub(crate) fn curve(separation: &Separation, term: ErrorTerm) -> &[f64] {
    &mean(separation, term).deviation_um
}

pub(crate) fn largest(curve: &[f64]) -> f64 {
    curve.iter().fold(0.0, |most, um| most.max(um.abs()))
}

#[track_caller]
pub(crate) fn close(found: f64, wanted: f64, tolerance: f64, what: impl std::fmt::Display) {
    let far = (found - wanted).abs();
    assert!(far <= tolerance, "{what}: {found}, expected {wanted} within {tolerance}");
}
