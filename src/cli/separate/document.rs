//! The documents of `separate --format json` (contract §5).

use super::words::advice;
use crate::cli::diagonals::StandardFigures;
use crate::inputs::job::SetUp;
use crate::kit::manifest::picometres;
use crate::machine::separation::metric::{PerPlane, Plane};
use crate::machine::separation::monte_carlo::Simulated;
use crate::machine::separation::noise::Outlier;
use crate::machine::separation::noise::{Noise, coverage_factor};
use crate::machine::separation::readings::repeatability_um;
use crate::machine::separation::reversal::{Estimate, Turn};
use crate::machine::separation::unmeasured::NotCounted;
use crate::machine::separation::{Evidence, Separation};
use crate::machine::standards::Diagonals;
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerAxis, PerTerm};
use crate::quantity::diagonal::{Diagonal, Pass, PathKind};
use crate::text::problem::Problems;
use serde_json::{Map, Value, json};

fn rounded(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| picometres(*value)).collect()
}

fn evidence(positions_mm: &[f64], evidence: &Evidence) -> Value {
    let mut entry = Map::new();
    entry.insert("position_mm".into(), json!(positions_mm));
    entry.insert(
        "deviation_um".into(),
        json!(rounded(&evidence.deviation_um)),
    );
    if let Some(u_um) = &evidence.u_um {
        entry.insert("u_um".into(), json!(rounded(u_um)));
    }
    Value::Object(entry)
}

fn errors(separation: &Separation) -> Value {
    let mut all = Map::new();
    let mut add = |suffix: &str, errors: &PerTerm<Option<Evidence>>| {
        for (term, found) in errors.iter() {
            if let Some(found) = found {
                let positions = positions(separation, term);
                all.insert(format!("{term}{suffix}"), evidence(&positions, found));
            }
        }
    };
    add("", &separation.errors.mean);
    for direction in Direction::BOTH {
        if let Some(errors) = separation.errors.directed(direction) {
            add(direction.symbol(), errors);
        }
    }
    Value::Object(all)
}

fn positions(separation: &Separation, term: ErrorTerm) -> Vec<f64> {
    let positions = separation.volume.positions(term.along);
    positions.iter().map(|position| position.mm()).collect()
}

pub(super) fn planes(values: &PerPlane<Option<f64>>) -> Value {
    let mut all = Map::new();
    for plane in Plane::ALL {
        if let Some(value) = values.of(plane) {
            all.insert(plane.key().into(), json!(picometres(value)));
        }
    }
    Value::Object(all)
}

fn axes<T>(of: impl Fn(Axis) -> T) -> Value
where
    Value: From<T>,
{
    let entries = Axis::ALL.map(|axis| (axis.key().to_string(), Value::from(of(axis))));
    Value::Object(entries.into_iter().collect())
}

fn vector(v: &PerAxis<f64>) -> Value {
    json!([v.x, v.y, v.z])
}

pub(super) fn separation(
    separation: &Separation,
    simulated: Option<&Simulated>,
) -> Result<Value, Problems> {
    let mut page = Map::new();
    page.insert("schema".into(), json!(1));
    page.insert("errors".into(), errors(separation));
    page.insert(
        "squareness_um_per_m".into(),
        planes(&separation.squareness_um_per_m),
    );
    page.insert(
        "u_squareness_um_per_m".into(),
        planes(&separation.u_squareness.map(|u| Some(u?.u_um_per_m))),
    );
    page.insert(
        "squareness_freedom".into(),
        planes(&separation.u_squareness.map(|u| u?.freedom)),
    );
    if let Some(found) = &separation.agreement {
        page.insert("redundancy".into(), super::words::agreement_json(found));
    }
    page.insert(
        "squareness_least_squares_um_per_m".into(),
        planes(&separation.squareness_least_squares_um_per_m),
    );
    if let Some(tilts) = &separation.tilts {
        let of = |value: &dyn Fn(Diagonal) -> Value| -> Value {
            let entries = Diagonal::ALL.map(|d| (d.name().to_string(), value(d)));
            Value::Object(entries.into_iter().collect())
        };
        page.insert(
            "setup_arcsec".into(),
            of(&|d| json!(picometres(tilts[d].arcsec))),
        );
        page.insert(
            "setup_direction".into(),
            of(&|d| vector(&tilts[d].direction)),
        );
    }
    let closure = &separation.closure;
    page.insert(
        "closure_um".into(),
        axes(|axis| rounded(&closure.by_interval[axis])),
    );
    page.insert(
        "mean_closure_um".into(),
        axes(|axis| picometres(closure.mean[axis])),
    );
    if let Some(noise) = separation.noise {
        page.insert(
            "closure_expected_um".into(),
            axes(|axis| picometres(closure.scatter[axis] * noise.sigma_um)),
        );
        page.insert(
            "mean_closure_expected_um".into(),
            axes(|axis| picometres(closure.u_mean_um(axis, noise.sigma_um))),
        );
    }
    if let Some(ramps) = &closure.ramps {
        page.insert(
            "closure_ramp".into(),
            json!({
                "change_um": axes(|axis| picometres(ramps.change_um[axis])),
                "probability": ramps.probability,
                "roll": ramps.is_roll(),
            }),
        );
    }
    page.insert(
        "rank".into(),
        json!({
            "rank": separation.rank().0,
            "unknowns": separation.rank().1,
            "undetermined": separation.undetermined,
            "advice": open_advice(separation),
        }),
    );
    page.insert(
        "outliers".into(),
        closure.outliers.iter().map(outlier).collect(),
    );
    page.insert("diagonals".into(), diagonals(separation)?);
    if let Some(found) = separation.noise {
        let mut entry = noise(found);
        let test = closure.test(&found);
        entry["closure_probability"] = json!(test.map(|test| test.probability));
        page.insert("noise".into(), entry);
    }
    if let Some(turn) = &separation.turn {
        reversal(&mut page, turn);
    }
    let slopes = separation.naive_slopes_um_per_m.iter();
    let slopes = slopes.map(|(term, slope)| (term.to_string(), json!(picometres(*slope))));
    page.insert(
        "separated_slope_um_per_m".into(),
        Value::Object(slopes.collect()),
    );
    let shapes = separation.shapes.iter();
    let shapes = shapes.map(|(term, shape)| (term.to_string(), json!(rounded(shape))));
    page.insert("shape_um".into(), Value::Object(shapes.collect()));
    if let Some(simulated) = simulated {
        page.insert("monte_carlo".into(), monte_carlo(simulated));
    }
    page.insert("doubts".into(), json!(separation.doubts));
    holds_below(&mut page, &separation.not_counted);
    page.insert("labels".into(), json!(separation.labels));
    Ok(Value::Object(page))
}

/// Bounds of what no U holds, below which it holds nevertheless.
pub(super) fn holds_below(page: &mut Map<String, Value>, not_counted: &NotCounted) {
    let causes = [
        ("holds_below_angle_urad", &not_counted.angles),
        ("holds_below_beam_mrad", &not_counted.beam),
    ];
    for (key, silent) in causes {
        if let Some(bound) = silent.as_ref().and_then(|silent| silent.holds_below) {
            page.insert(key.into(), json!(picometres(bound)));
        }
    }
}

/// Reversals of a turn: by term, at both ends of each axis, and from each diagonal alone.
fn reversal(page: &mut Map<String, Value>, turn: &Turn) {
    let known = |u: Option<f64>| u.map(picometres);
    let both = |b: Estimate| json!({"um": picometres(b.um), "u_um": known(b.u_um)});
    let by_term = |value: &dyn Fn(ErrorTerm) -> Value| {
        let all = ErrorTerm::ALL.map(|term| (term.to_string(), value(term)));
        Value::Object(all.into_iter().collect())
    };
    let um = by_term(&|term| json!(picometres(turn.reversal[term].um)));
    page.insert("reversal_um".into(), um);
    let u_um = by_term(&|term| json!(known(turn.reversal[term].u_um)));
    page.insert("u_reversal_um".into(), u_um);
    let held = by_term(&|term| json!(turn.in_curves[term]));
    page.insert("reversal_in_curves".into(), held);
    let ends = axes(|axis| {
        let [low, high] = turn.ends[axis];
        json!({"low": both(low), "high": both(high), "constancy_probability": turn.constancy[axis].map(picometres)})
    });
    page.insert("reversal_at_ends".into(), ends);
    let alone = turn.by_diagonal.iter();
    let alone = alone.map(|(d, all)| (d.name().to_string(), axes(|axis| both(all[axis]))));
    page.insert(
        "reversal_by_diagonal".into(),
        Value::Object(alone.collect()),
    );
}

fn repeatability(separation: &Separation, diagonal: Diagonal) -> Value {
    let of = |pass: Pass| {
        let found = repeatability_um(&separation.runs, diagonal, pass);
        (pass.word().to_string(), json!(found.map(picometres)))
    };
    Value::Object(Pass::BOTH.map(of).into_iter().collect())
}

fn outlier(outlier: &Outlier) -> Value {
    let readings: Vec<Value> = outlier
        .readings
        .iter()
        .map(|r| {
            json!({
                "diagonal": r.diagonal.name(),
                "run": r.run,
                "direction": r.pass.word(),
                "node": r.node,
            })
        })
        .collect();
    json!({
        "readings": readings,
        "size_um": picometres(outlier.size_um),
        "standard_deviations": picometres(outlier.ratio),
    })
}

/// σ of a single reading and where it comes from.
pub(super) fn noise(noise: Noise) -> Value {
    json!({
        "sigma_um": picometres(noise.sigma_um),
        "degrees_of_freedom": noise.freedom,
        "coverage_factor": picometres(coverage_factor(noise.freedom_f64())),
        "source": noise.source.words(),
    })
}

/// What would determine the scales that are open; nothing is asked for under an assumed set-up.
pub(super) fn open_advice(separation: &Separation) -> Vec<String> {
    match separation.setup {
        SetUp::Solve => advice(&separation.metric),
        SetUp::AssumePerfect => Vec::new(),
    }
}

fn diagonals(separation: &Separation) -> Result<Value, Problems> {
    let figures = StandardFigures::of(&separation.volume, PathKind::Step, &separation.zeroed_runs)?;
    let mut all = diagonal_totals(
        &figures.all,
        separation.range_over_all_um,
        separation.scale_sum_um_mm,
    );
    for (diagonal, of) in separation.diagonals.iter() {
        all.insert(
            diagonal.name().into(),
            json!({
                "end_reading_um": picometres(of.end_um),
                "range_um": picometres(of.range_um),
                "figures_um": figures.document(diagonal),
                "repeatability_um": repeatability(separation, diagonal),
            }),
        );
    }
    Ok(Value::Object(all))
}

/// The figures of all four diagonals together.
pub(super) fn diagonal_totals(
    figures: &Diagonals,
    range_over_all_um: f64,
    scale_sum_um_mm: f64,
) -> Map<String, Value> {
    let mut all = Map::new();
    all.insert(
        "range_over_all_um".into(),
        json!(picometres(range_over_all_um)),
    );
    all.insert("scale_sum_um_mm".into(), json!(picometres(scale_sum_um_mm)));
    all.insert("e_d_um".into(), json!(figures.e_d_um.map(picometres)));
    all.insert("b_d_um".into(), json!(figures.b_d_um.map(picometres)));
    all.insert("label".into(), json!(figures.label));
    all
}

fn monte_carlo(simulated: &Simulated) -> Value {
    let figures: Vec<Value> = simulated
        .figures
        .iter()
        .map(|f| {
            json!({
                "name": f.quantity.to_string(),
                "unit": f.quantity.unit(),
                "estimate": picometres(f.estimate),
                "bias": picometres(f.bias),
                "interval_95": rounded(&f.interval),
                "interval_coverage_measured": f.measured_coverage(),
                "u": picometres(f.u),
            })
        })
        .collect();
    json!({
        "trials": simulated.plan.trials,
        "seed": simulated.plan.seed,
        "figures": figures,
    })
}
