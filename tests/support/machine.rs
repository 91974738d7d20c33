//! Generated machines: deviations, job and error table, with the deviations evaluated here.
//!
//! Straight lines are evaluated with code of the tests' own, cubics through the public curve; the
//! zero, the mean of both directions and the reversal are computed here once more.

use super::{Lines, Random};
use nonius::control::controller::{Dialect, Profile};
use nonius::quantity::{
    Axis, Deviation, Direction, ErrorCurve, ErrorTerm, Interpolation, Millimetres,
};

/// Deviation of one term in one direction as measured, µm over mm, plus a squareness.
#[derive(Clone, Debug)]
pub(crate) struct Errors {
    pub(crate) points: Lines,
    /// What goes through the points where that is no straight line.
    cubic: Option<ErrorCurve>,
    pub(crate) slope_um_per_m: f64,
}

impl Errors {
    pub(crate) fn new(mm: Vec<f64>, um: Vec<f64>, kind: Interpolation) -> Errors {
        let cubic = (kind != Interpolation::Linear).then(|| {
            let positions: Vec<_> = mm.iter().copied().map(Millimetres::new).collect();
            let values: Vec<_> = um.iter().copied().map(Deviation::from_um).collect();
            ErrorCurve::through(&positions, &values, kind)
        });
        Errors { points: Lines { mm, um }, cubic, slope_um_per_m: 0.0 }
    }

    pub(crate) fn range(&self) -> (f64, f64) {
        let mm = &self.points.mm;
        (mm[0], mm[mm.len() - 1])
    }

    pub(crate) fn at(&self, x: f64) -> f64 {
        let (low, high) = self.range();
        let cubic = self.cubic.as_ref().map(|curve| curve.at(Millimetres::new(x)).um());
        let base = cubic.unwrap_or_else(|| self.points.at(x));
        base + self.slope_um_per_m / 1000.0 * x.clamp(low, high)
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Term {
    pub(crate) term: ErrorTerm,
    pub(crate) directed: bool,
    pub(crate) plus: Option<Errors>,
    pub(crate) minus: Option<Errors>,
    pub(crate) reference: f64,
    pub(crate) homing: Direction,
}

impl Term {
    pub(crate) fn errors(&self, direction: Direction) -> Option<&Errors> {
        match direction {
            Direction::Plus => self.plus.as_ref(),
            Direction::Minus => self.minus.as_ref(),
        }
    }

    pub(crate) fn both_ways(&self) -> bool {
        self.directed && self.plus.is_some() && self.minus.is_some()
    }

    /// As measured: what is subtracted so that the reference direction is zero at the reference.
    pub(crate) fn zero(&self) -> f64 {
        let own = self.errors(self.homing);
        let curve = own.or(self.plus.as_ref()).or(self.minus.as_ref());
        curve.unwrap().at(self.reference)
    }

    /// Deviation relative to the reference.
    pub(crate) fn deviation(&self, direction: Direction, x: f64) -> f64 {
        self.errors(direction).unwrap().at(x) - self.zero()
    }

    pub(crate) fn mean(&self, x: f64) -> f64 {
        let (plus, minus, (low, high)) = self.both();
        let x = x.clamp(low, high);
        (plus.at(x) + minus.at(x)) / 2.0
    }

    /// Both directions, and the range that they share.
    fn both(&self) -> (&Errors, &Errors, (f64, f64)) {
        let (plus, minus) = (self.plus.as_ref().unwrap(), self.minus.as_ref().unwrap());
        let low = plus.range().0.max(minus.range().0);
        (plus, minus, (low, plus.range().1.min(minus.range().1)))
    }

    /// ISO 230-2: mean of (moving + minus moving −) over the targets of both directions.
    pub(crate) fn reversal(&self) -> f64 {
        let (plus, minus, (low, high)) = self.both();
        let mut places: Vec<f64> =
            [&plus.points.mm[..], &minus.points.mm[..], &[low, high]].concat();
        places.retain(|x| *x >= low && *x <= high);
        places.sort_by(f64::total_cmp);
        places.dedup();
        let sum: f64 = places.iter().map(|x| plus.at(*x) - minus.at(*x)).sum();
        sum / places.len() as f64
    }

    /// What the table that acts in `direction` has to cancel; `two_tables`: one for each.
    pub(crate) fn target(
        &self,
        machine: &Machine,
        two_tables: bool,
        direction: Direction,
        x: f64,
    ) -> f64 {
        if !self.both_ways() {
            let is_measured = self.errors(direction).is_some();
            return self.deviation(if is_measured { direction } else { direction.opposite() }, x);
        }
        let from_reference = |direction: Direction| {
            let errors = self.errors(direction).unwrap();
            errors.at(x) - errors.at(self.reference)
        };
        match machine.policy.unwrap() {
            "forward-only" => from_reference(Direction::Plus),
            "curve-and-parameter" => {
                from_reference(self.homing) + self.reversal_in_table(machine, direction)
            }
            "two-tables" if two_tables => self.deviation(direction, x),
            _ => self.mean(x) - self.mean(self.reference),
        }
    }

    /// What a table carries of the reversal where it stands in place of the backlash parameter.
    pub(crate) fn reversal_in_table(&self, machine: &Machine, direction: Direction) -> f64 {
        let carries = machine.replaces_backlash
            && machine.policy == Some("curve-and-parameter")
            && self.both_ways()
            && self.term.is_positioning();
        match (carries && direction != self.homing, self.homing) {
            (false, _) => 0.0,
            (true, Direction::Plus) => -self.reversal(),
            (true, Direction::Minus) => self.reversal(),
        }
    }

    /// Every place where a measured curve bends.
    pub(crate) fn knots(&self) -> Vec<f64> {
        let both = [&self.plus, &self.minus];
        both.into_iter().flatten().flat_map(|errors| errors.points.mm.clone()).collect()
    }
}

#[derive(Clone, Debug)]
pub(crate) struct MachineAxis {
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) reference: f64,
    pub(crate) names: Vec<String>,
    pub(crate) unit_um: Option<f64>,
    pub(crate) interpolated: bool,
}

impl MachineAxis {
    pub(crate) fn parts(&self, count: u32) -> impl Iterator<Item = f64> {
        let (low, length) = (self.low, self.high - self.low);
        (0..=count).map(move |part| low + length * f64::from(part) / f64::from(count))
    }
}

pub(crate) struct Machine {
    pub(crate) axes: Vec<MachineAxis>,
    pub(crate) terms: Vec<Term>,
    pub(crate) policy: Option<&'static str>,
    pub(crate) fit: &'static str,
    pub(crate) kind: Interpolation,
    pub(crate) inch: bool,
    /// A table stands in place of the backlash parameter.
    pub(crate) replaces_backlash: bool,
    pub(crate) reserved: Vec<[u32; 2]>,
    pub(crate) job: String,
    pub(crate) csv: String,
    pub(crate) features: Vec<&'static str>,
}

impl Machine {
    pub(crate) fn axis(&self, axis: Axis) -> &MachineAxis {
        &self.axes[Axis::ALL.iter().position(|a| *a == axis).unwrap()]
    }

    pub(crate) fn pairs(&self, term: ErrorTerm) -> Vec<(&str, &str)> {
        let base = &self.axis(term.along).names[0];
        let outputs = &self.axis(term.of).names;
        let pair = |output| (if term.is_positioning() { output } else { base }, output);
        outputs.iter().map(pair).map(|(b, o)| (b.as_str(), o.as_str())).collect()
    }
}

const POLICIES: [&str; 4] = ["mean", "two-tables", "forward-only", "curve-and-parameter"];

const CURVES: [(Interpolation, &str); 4] = [
    (Interpolation::Linear, "linear"),
    (Interpolation::Linear, "linear"),
    (Interpolation::Pchip, "pchip"),
    (Interpolation::NaturalSpline, "natural-spline"),
];

/// The machine number `seed` for a profile.
pub(crate) fn machine(profile: &Profile, seed: usize) -> Machine {
    let own: u64 = profile.id.bytes().map(u64::from).sum();
    let mut random = Random::new(seed as u64 * 10_000 + own);
    let fanuc = matches!(profile.dialect, Dialect::Fanuc(_));
    let siemens = matches!(profile.dialect, Dialect::Siemens(_));
    let linuxcnc = matches!(profile.dialect, Dialect::Linuxcnc(_));
    let declared = matches!(profile.dialect, Dialect::Declared(_));
    // No table moves another axis.
    let own_only = linuxcnc || !super::has_cross_terms(profile);
    let isg = matches!(profile.dialect, Dialect::Isg(_));
    // A control that uses no points beyond the travel gets travels that end on the grid.
    let ends_on_grid = matches!(
        &profile.dialect, Dialect::Declared(facts) if !facts.points_beyond_travel.value
    );
    let mut features = Vec::new();
    // Cycled, so that every value meets the others; the rest is drawn.
    let directions = seed % 7; // 0, 1: undirected · 2 … 5: both, one policy each · 6: one way
    let policy = (2..=5).contains(&directions).then(|| POLICIES[directions - 2]);
    let (kind, curve) = CURVES[(seed / 7) % 4];
    let fit = ["sample", "sample", "least-squares", "minimax"][(seed / 3) % 4];
    let inch = seed % 5 == 3;
    let steep = seed % 6 == 1;
    let nine = !random.one_in(3);
    features.extend([policy.unwrap_or(["undirected", "one way"][directions / 6]), fit, curve]);
    features.extend(inch.then_some("inch"));
    features.extend(steep.then_some("steep"));
    features.push(if nine { "nine terms" } else { "fewer terms" });

    let unit_um = random.of(&[1.0, 0.1, 2.5]);
    let stated_unit =
        (profile.detection_unit_required.value || (fanuc && random.one_in(3))).then_some(unit_um);
    // A file that takes X, Y and Z alone has no name for the second axis.
    let numbered = profile.axis_names.value[0].parse::<u32>().is_ok();
    let gantry = random.one_in(4) && !isg && (!declared || numbered);
    features.extend(gantry.then_some("gantry"));
    let mut measured = ErrorTerm::ALL.to_vec();
    measured.retain(|term| nine || !random.one_in(2) || (own_only && *term == ErrorTerm::ALL[0]));
    if measured.is_empty() {
        measured.push(ErrorTerm::ALL[random.below(9)]);
    }

    let mut axes = Vec::new();
    let mut terms = Vec::new();
    let mut csv = String::from("axis,direction,position_mm,ex_um,ey_um,ez_um\n");
    let mut machine_text = String::new();
    let mut axes_text = String::new();
    let mut slopes = Vec::new();
    for (index, axis) in Axis::ALL.into_iter().enumerate() {
        let length = random.of(&match ends_on_grid {
            true => [100.0, 240.0, 500.0, 720.0, 900.0, 1200.0],
            false => [100.0, 240.0, 500.0, 720.0, 900.0, 1234.567],
        });
        let low = random.of(&[0.0, -length, -length / 4.0, 17.5]);
        let high = low + length;
        let (from, to) = match random.one_in(3) {
            true => (low + 0.11 * length, high - 0.08 * length),
            false => (low, high),
        };
        let reference = match random.below(6) {
            0 => low,
            1 => high,
            3.. if ends_on_grid => low + 0.5 * length,
            2 if ends_on_grid => low,
            2 => low + 0.05 * length, // off the measured range, where that is shorter
            3 => low + 0.5 * length,
            _ => random.between(low, high),
        };
        let rounded = |x: f64| (x * 1000.0).round() / 1000.0;
        let (from, to, reference) = (rounded(from), rounded(to), rounded(reference));
        features.push(match reference {
            _ if reference < from || reference > to => "reference not measured",
            _ if reference <= low || reference >= high => "reference at an end",
            _ => "reference inside",
        });
        let homing = if random.one_in(2) { Direction::Minus } else { Direction::Plus };
        let homing_stated = homing == Direction::Minus || random.one_in(2);
        let (key, travel) = (axis.key(), [low, high]);
        machine_text += &format!(
            "[machine.axes.{key}]\ntravel_mm = {travel:?}\nreference_mm = {reference:?}\n"
        );
        let stated = homing_stated.then(|| format!("reference_direction = \"{homing}\"\n"));
        machine_text.extend(stated);
        let mut names = vec![profile.axis_names.value[index].clone()];
        if gantry && index == 0 {
            let other = if siemens { "AX4" } else { "x2" };
            names.push(if numbered { "4" } else { other }.to_string());
        }

        let along: Vec<ErrorTerm> = measured.iter().copied().filter(|t| t.along == axis).collect();
        let range = (from, to);
        let measured =
            Measured { directions, kind, steep, unit_um, range, reference, homing, length };
        let step_limit = match along[..] {
            [] => 1.0,
            _ => measured.add_terms(&mut random, &along, &mut terms, &mut csv),
        };
        let interpolated = fanuc && random.one_in(3);
        features.extend(interpolated.then_some("interpolated"));
        let (feature, grid) = grid_text(&mut random, length, ends_on_grid, step_limit, fit);
        features.extend(feature);
        axes_text += &format!("[compensation.axes.{key}]\n{grid}\n");
        axes_text.extend(stated_unit.map(|unit| format!("detection_unit_um = {unit:?}\n")));
        axes_text.extend((names.len() > 1).then(|| format!("ids = {names:?}\n")));
        axes_text.extend(interpolated.then_some("interpolated = true\n"));
        if fanuc && random.one_in(4) {
            features.push("first_point");
            axes_text += &format!("first_point = {}\n", 150 + 150 * index);
        }
        if fanuc && random.one_in(4) {
            features.push("parameter_3605");
            axes_text += &format!("parameter_3605 = \"100000{}0\"\n", u8::from(interpolated));
        }
        let is_second = siemens && random.one_in(4);
        axes_text.extend(is_second.then_some("measuring_system = 2\n"));
        axes.push(MachineAxis { low, high, reference, names, unit_um: stated_unit, interpolated });
    }

    // Squareness of slopes that the measurement does not contain.
    if random.one_in(4) {
        for (key, name) in [("xy", "EXY"), ("xz", "EXZ"), ("yz", "EYZ")] {
            let term = ErrorTerm::from_name(name).unwrap();
            let own = terms.iter_mut().find(|t: &&mut Term| t.term == term);
            if let Some(own) = own.filter(|_| !random.one_in(3)) {
                let slope = random.between(-30.0, 30.0);
                for errors in [&mut own.plus, &mut own.minus].into_iter().flatten() {
                    errors.slope_um_per_m = slope;
                }
                slopes.push(format!("{key} = {slope:?}"));
            }
        }
    }
    let squareness = match slopes[..] {
        [] => String::new(),
        _ => format!("[measurement.squareness_um_per_m]\n{}\n", slopes.join("\n")),
    };
    features.extend((!slopes.is_empty()).then_some("squareness"));

    let reserved: Vec<[u32; 2]> = match random.below(4) {
        _ if !fanuc => Vec::new(),
        0 => vec![[0, 20], [600, 640], [6000, 6010], [3000, 3100]],
        1 => vec![[6120, 6140]],
        _ => Vec::new(),
    };
    let mut control =
        format!("controller = \"{}\"\nfit = \"{fit}\"\ncurve = \"{curve}\"\n", profile.id);
    control.extend(inch.then_some("control_unit = \"inch\"\n"));
    let asked = policy.filter(|_| terms.iter().any(Term::both_ways));
    control.extend(asked.map(|policy| format!("backlash = \"{policy}\"\n")));
    if siemens && random.one_in(3) {
        features.push("first_table");
        control += &format!("first_table = {}\n", 1 + random.below(3));
    }
    if fanuc && random.one_in(3) {
        features.push("first_set");
        control += &format!("first_set = {}\n", 1 + random.below(2));
    }
    if !reserved.is_empty() {
        features.push("reserved_points");
        control += &format!("reserved_points = {reserved:?}\n");
    }
    if random.one_in(4) && terms.len() > 1 {
        features.push("listed terms");
        let two_ways = matches!(policy, Some("two-tables" | "curve-and-parameter"));
        let is_listed = |(index, term): &(usize, &Term)| {
            index % 2 == 0
                || (own_only && term.term.is_positioning())
                || (two_ways && term.both_ways())
        };
        let names = terms.iter().enumerate().filter(is_listed);
        let names: Vec<String> = names.map(|(_, term)| term.term.to_string()).collect();
        control += &format!("terms = {names:?}\n");
    }
    let replaces_backlash = super::replaces_backlash(profile);
    let job = format!(
        "schema = 1\n[machine]\nname = \"machine {seed}\"\n{machine_text}\
         [measurement]\nerrors = \"errors.csv\"\nactive_while_measuring = \"none\"\nuncertainty.noise_um = 0.0001\n{squareness}\
         [compensation]\n{control}{axes_text}\
         [limits]\nmax_correction_um = 5000.0\nmax_slope_um_per_mm = 50.0\n"
    );
    Machine {
        axes,
        terms,
        policy,
        fit,
        kind,
        inch,
        replaces_backlash,
        reserved,
        job,
        csv,
        features,
    }
}

fn grid_text(
    random: &mut Random,
    length: f64,
    ends_on_grid: bool,
    residual_um: f64,
    fit: &str,
) -> (Option<&'static str>, String) {
    let parts = random.of(&match ends_on_grid {
        true => [4.0, 8.0, 10.0, 20.0, 40.0],
        false => [4.0, 9.0, 15.0, 30.0, 60.0],
    });
    let dividing = format!("spacing_mm = {:?}", length / parts);
    match random.below(6) {
        0 | 1 if ends_on_grid => (Some("points"), format!("points = {}", parts + 1.0)),
        _ if ends_on_grid => (None, dividing),
        0 => (Some("points"), format!("points = {}", 3 + random.below(50))),
        1 if fit != "minimax" => {
            (Some("max_residual_um"), format!("max_residual_um = {residual_um:.3}"))
        }
        2 | 3 => (Some("dividing spacing"), dividing),
        _ => {
            let spacing = ((length / parts * 1.0417) * 1000.0).round() / 1000.0;
            (Some("other spacing"), format!("spacing_mm = {spacing:?}"))
        }
    }
}

struct Measured {
    directions: usize,
    kind: Interpolation,
    steep: bool,
    unit_um: f64,
    range: (f64, f64),
    reference: f64,
    homing: Direction,
    length: f64,
}

impl Measured {
    /// Its terms with their rows; gives a residual that a grid can keep.
    fn add_terms(
        self,
        random: &mut Random,
        along: &[ErrorTerm],
        terms: &mut Vec<Term>,
        csv: &mut String,
    ) -> f64 {
        let Measured { directions, kind, steep, unit_um, range: (from, to), .. } = self;
        let Measured { reference, homing, length, .. } = self;
        let count = 4 + random.below(12);
        let targets = |random: &mut Random, from: f64, to: f64| -> Vec<f64> {
            let step = (to - from) / (count - 1) as f64;
            let even = random.one_in(2);
            let place = |i: usize| match i {
                0 => from,
                _ if i == count - 1 => to,
                _ => {
                    let shift = if even { 0.0 } else { random.between(-0.3, 0.3) };
                    ((from + step * (i as f64 + shift)) * 1000.0).round() / 1000.0
                }
            };
            (0..count).map(place).collect()
        };
        let places: Vec<(Option<Direction>, Vec<f64>)> = match directions {
            0 | 1 => vec![(None, targets(random, from, to))],
            6 => vec![(Some(random.of(&Direction::BOTH)), targets(random, from, to))],
            _ => {
                let plus = targets(random, from, to);
                let shorter = ((to - 0.04 * length) * 1000.0).round() / 1000.0;
                let minus = match random.one_in(3) {
                    true => targets(random, from, shorter),
                    false => plus.clone(),
                };
                vec![(Some(Direction::Plus), plus), (Some(Direction::Minus), minus)]
            }
        };
        let mut largest = 0.0_f64;
        let mut columns: Vec<Vec<Option<Vec<f64>>>> = vec![vec![None; 3]; places.len()];
        for term in along {
            let size = random.of(&[0.0, 2.0, 12.0, 12.0, 45.0]);
            let offset = random.between(-3.0, 3.0);
            let tilt = match steep && random.one_in(2) {
                true if unit_um < 0.5 => 0.08,
                true => 0.25,
                false => 0.0,
            };
            let waves = 1.0 + random.below(3) as f64;
            let reversal = if size > 0.0 { random.between(-8.0, 4.0) } else { 0.0 };
            let mut curves: Vec<Errors> = Vec::new();
            let of = Axis::ALL.iter().position(|a| *a == term.of).unwrap();
            for (index, (direction, mm)) in places.iter().enumerate() {
                let lost = if *direction == Some(Direction::Minus) { -reversal } else { 0.0 };
                let mut deviation = |x: &f64| {
                    let part = (x - from) / (to - from);
                    let wave = (part * waves * std::f64::consts::TAU).sin() * size / 2.0;
                    let noise = random.between(-0.04, 0.04) * size;
                    let is_flat = size <= 0.0 && tilt <= 0.0;
                    if is_flat { 0.0 } else { offset + wave + noise + tilt * (x - from) + lost }
                };
                let um: Vec<f64> = mm.iter().map(&mut deviation).collect();
                largest = um.iter().fold(largest, |most, um| most.max(um.abs()));
                columns[index][of] = Some(um.clone());
                curves.push(Errors::new(mm.clone(), um, kind));
            }
            let of = |way: Direction| {
                let found = places.iter().position(|(own, _)| own.is_none_or(|own| own == way));
                found.map(|index| curves[index].clone())
            };
            let (plus, minus) = (of(Direction::Plus), of(Direction::Minus));
            let (term, directed) = (*term, places[0].0.is_some());
            terms.push(Term { term, directed, plus, minus, reference, homing });
        }
        for ((direction, mm), columns) in places.iter().zip(&columns) {
            let sign = direction.map_or("", Direction::symbol);
            for (row, x) in mm.iter().enumerate() {
                let cell = |um: &Option<Vec<f64>>| um.as_ref().map(|um| format!("{:?}", um[row]));
                let cells = columns.iter().map(|um| cell(um).unwrap_or_default());
                let (key, cells) = (along[0].along.key(), cells.collect::<Vec<_>>().join(","));
                *csv += &format!("{key},{sign},{x:?},{cells}\n");
            }
        }
        (0.12 * largest).max(0.05)
    }
}
