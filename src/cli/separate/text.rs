//! What `separate` prints for people: what was determined and what not, then the figures; behind
//! them the closure, disturbed readings, the reversal at a turn and repeated runs.

use super::words::{self, Results, expanded, freedom};
use crate::cli::screen::{More, Screen, paragraphs, table};
use crate::cli::show::{figure, named, um};
use crate::inputs::job::SetUp;
use crate::machine::separation::campaign::Estimate;
use crate::machine::separation::closure::{Closure, Ramps};
use crate::machine::separation::curves::{ReferenceLine, range};
use crate::machine::separation::monte_carlo::{Figure as Simulation, Simulated};
use crate::machine::separation::readings::{
    FALSE_DOUBT, Noise, NoiseSource, Outlier, coverage_factor,
};
use crate::machine::separation::reversal::Turn;
use crate::machine::separation::solved::naive_squareness;
use crate::machine::separation::{SeparatedError, Separation};
use crate::machine::standards::{Diagonals, repeatability_um};
use crate::quantity::{Axis, Diagonal, Direction, ErrorTerm, Figure, Pass, PerAxis, Plane};
use crate::text::joined;

pub(super) fn screen((separation, figures, simulated): Results<'_>, advice: &[String]) -> Screen {
    let outliers = &separation.closure.outliers;
    let more = vec![
        More::part("directions", directions(separation)),
        More::part("linear axes and beams", separation.agreement.as_ref().map(words::agreement)),
        More::part("set-up", setup(separation)),
        More::part("closure", closure(separation)),
        More::part("reversal", reversal(separation)),
        More::part("diagonals", diagonals(separation, figures)),
        More::part("repeatability", repeatability(separation)),
        More::part("Monte Carlo", simulated.map(monte_carlo)),
    ];
    let mut screen = words::screen(
        &separation.doubts,
        outcome(separation),
        (&separation.undetermined, advice),
        paragraphs(&[terms(separation), squareness(separation)]),
        more,
        &separation.labels,
    );
    let disturbed = outliers.iter().map(Outlier::words);
    screen.findings =
        disturbed.map(|which| format!("disturbed reading, repeat the run: {which}")).collect();
    screen
}

/// What was determined, in one line, and what no U holds.
fn outcome(separation: &Separation) -> String {
    let errors = separation.errors.mean.iter();
    let count = errors.filter(|(_, found)| found.is_some()).count();
    let known = |plane: &Plane| separation.metric.squareness(*plane).um_per_m.is_some();
    let planes = Plane::ALL.into_iter().filter(known).map(|plane| plane.key().to_uppercase());
    let set_up = match (separation.setup, &separation.tilts) {
        (SetUp::AssumePerfect, _) => "set-up assumed perfect",
        (SetUp::Solve, Some(_)) => "set-up solved for",
        (SetUp::Solve, None) => "tilt of the mirror not determined",
    };
    let mut lines =
        vec![format!("Determined: {count} of 9 errors; squareness {}; {set_up}", joined(planes))];
    lines.extend(separation.silence.sentences());
    if separation.setup == SetUp::AssumePerfect {
        // The first thing to read there; the label says the rest.
        lines.push("WARNING: `setup = \"assume-perfect\"`: slopes that were separated hold the tilt of the mirror; for figures of the machine use `setup = \"solve\"` with two or three linear axes".to_string());
    }
    lines.join("\n")
}

fn terms(separation: &Separation) -> String {
    let rows = ErrorTerm::ALL.into_iter().map(|term| {
        let shape = um(Some(range(separation.shapes[term].iter().copied())));
        let Some(found) = &separation.errors.mean[term] else {
            return format!("{term}\tnot determined\t-\t-\t{shape}\t-\t-");
        };
        let curve = &found.deviation_um;
        let positions = separation.volume.positions(term.along);
        let positions: Vec<f64> = positions.iter().map(|at| at.mm()).collect();
        let slope = ReferenceLine::EndPoints.slope_um_per_m(&positions, curve);
        let [slope, end, range] = [slope, last(curve), range(curve.iter().copied())].map(Figure);
        let largest = largest_u(found);
        let (u, freedom) = (expanded(largest.map(|(um, _)| um)), freedom(largest.map(|(_, f)| f)));
        format!("{term}\t{slope:.3}\t{end:.3}\t{range:.3}\t{shape}\t{u}\t{freedom}")
    });
    let heading = "error\t>slope/(µm/m)\t>far end/µm\t>max - min/µm\t>straightness/µm\t>largest U(95 %)/µm\t>degrees of freedom";
    format!(
        "Errors (actual - commanded), zero at the low end of each axis\nslope, straightness: line through the end points; straightness of EXX, EYY, EZZ: residual from that line\n{}",
        table(heading, rows)
    )
}

fn last(values: &[f64]) -> f64 {
    values.last().copied().unwrap_or(0.0)
}

/// U where it is largest on the curve, often in the middle, and its effective degrees of freedom.
fn largest_u(found: &SeparatedError) -> Option<(f64, Option<f64>)> {
    let all = found.u.as_ref()?.iter().map(|point| (point.expanded(), point.freedom));
    all.max_by(|a, b| a.0.total_cmp(&b.0))
}

/// Both directions, where they stand apart.
fn directions(separation: &Separation) -> Option<String> {
    let plus = separation.errors.directed(Direction::Plus)?;
    let minus = separation.errors.directed(Direction::Minus)?;
    let rows = ErrorTerm::ALL.into_iter().filter_map(|term| {
        let (plus, minus) = (plus[term].as_ref()?, minus[term].as_ref()?);
        let both = [plus, minus].map(|found| &found.deviation_um);
        let [end, other_end] = both.map(|curve| Figure(last(curve)));
        let [size, other_size] = both.map(|curve| Figure(range(curve.iter().copied())));
        let u = |found: &SeparatedError| largest_u(found).map(|(um, _)| um);
        let either = expanded(u(plus).zip(u(minus)).map(|(a, b)| a.max(b)));
        Some(format!("{term}\t{end:.3}\t{other_end:.3}\t{size:.3}\t{other_size:.3}\t{either}"))
    });
    let apart = "+ is zero at the low end, - stands beside it by the reversal there";
    let open = "each is zero at its own low end: the reversal between them is not determined";
    let known = Axis::ALL.into_iter().filter(|axis| separation.is_directed(*axis));
    let known = joined(known.map(|axis| format!("E{axis}{axis}")));
    let zero = if separation.turn.is_some() {
        apart.to_string()
    } else if known.is_empty() {
        open.to_string()
    } else {
        format!("{known}: {apart}; others: {open}")
    };
    let heading = "error\t>far end +/µm\t>far end -/µm\t>max - min +/µm\t>max - min -/µm\t>largest U(95 %) of either/µm";
    let table = table(heading, rows);
    Some(format!("The same by direction of motion; {zero}\n{table}"))
}

fn squareness(separation: &Separation) -> String {
    let naive = separation.setup == SetUp::AssumePerfect;
    let by_least_squares = separation.errors.least_squares_squareness(&separation.volume);
    let more = |plane| {
        let sum = || Figure(naive_squareness(&separation.naive_slopes_um_per_m, plane));
        let sum = if naive { format!("\t{:.3}", sum()) } else { String::new() };
        format!("\t{}{sum}", um(by_least_squares.of(plane)))
    };
    let (column, legend) = match naive {
        true => (
            "\t>sum of separated slopes/(µm/m)",
            "\nsum of separated slopes: holds the tilt of the mirror, no figure of the machine; with `frame = \"as-measured\"` it is what the curves and the tables made from them carry",
        ),
        false => ("", ""),
    };
    format!(
        "{}\nsquareness and U: lines through the end points, from the totals of the diagonals; by least squares: lines through the curves above, with their straightness{legend}",
        words::squareness(&separation.metric, &format!("\t>by least squares/(µm/m){column}"), more)
    )
}

fn setup(separation: &Separation) -> Option<String> {
    let rows = separation.tilts.as_ref()?.iter().map(|(diagonal, tilt)| {
        let towards = tilt.direction;
        let [x, y, z] = [towards.x, towards.y, towards.z].map(Figure);
        format!("{diagonal}\t{:.1}\t{x:+.3}\t{y:+.3}\t{z:+.3}", tilt.arcsec)
    });
    Some(format!(
        "Tilt of the mirror: its normal against the nominal diagonal (solved for and taken out; no error of the machine)\n{}",
        table("set-up\t>tilt/arcsec\t>towards X\t>Y\t>Z", rows)
    ))
}

fn diagonals(separation: &Separation, figures: &Diagonals) -> String {
    let table = figures.as_read(|diagonal| separation.end_um[diagonal]);
    format!(
        "{table}\n`generate` computes its diagonals from the nine errors instead: without the tilt of the mirror, without noise between the nodes"
    )
}

fn monte_carlo(simulated: &Simulated) -> String {
    let rows = simulated.figures.iter().map(|f: &Simulation| {
        let [estimate, bias, from, to] =
            [f.estimate, f.bias, f.interval[0], f.interval[1]].map(Figure);
        let held = 100.0 * f.measured_coverage;
        format!(
            "{}\t{estimate:.3}\t{bias:+.3}\t{from:.3}\t{to:.3}\t{}\t{held:.1} %",
            f.name, f.unit
        )
    });
    let heading = "figure\t>estimate\t>bias by noise\t>from\t>to\tunit\t>held the truth";
    let hidden = if simulated.figures.iter().any(|f| f.unit == "µm" && f.interval[0] < 0.0) {
        "\na range or straightness whose interval reaches below 0 cannot be told from noise"
    } else {
        ""
    };
    format!(
        "Monte Carlo, {} trials, seed {}; range = max - min, straightness by least squares lines\nonly noise of the readings, the stated u of linear axes and beams and their `setup_ppm` are varied: no tilt, no angular errors\nintervals are made for 95 %; how often such intervals held the truth on simulated machines stands beside them\n{}{hidden}",
        simulated.plan.trials,
        simulated.plan.seed,
        table(heading, rows)
    )
}

fn closure(separation: &Separation) -> String {
    let (closure, noise) = (&separation.closure, separation.noise);
    let means = of_axes(&closure.mean, |axis| Some(closure.u_mean_um(axis, noise?.sigma_um)));
    let mut lines = vec![
        format!("Closure: mean over each axis (µm) {means}"),
        "  a constant is set-up error or, with a flat mirror, roll of an axis that carries others"
            .into(),
    ];
    lines.extend(noise.map(|noise| scatter(closure, noise)));
    lines.extend(closure.ramps.as_ref().map(|ramps| self::ramps(ramps, noise)));
    lines.push(test(closure, noise));
    lines.push("a clean closure proves nothing about pitch, yaw and five of eight patterns of set-up error".into());
    lines.join("\n")
}

/// A figure of each axis, with the standard deviation that is expected where it is known.
fn of_axes(um: &PerAxis<f64>, u_um: impl Fn(Axis) -> Option<f64>) -> String {
    joined(Axis::ALL.map(|axis| {
        let expected = u_um(axis).map(|um| format!(" (expected scatter {um:.3})"));
        format!("{axis} {:+.3}{}", Figure(um[axis]), expected.unwrap_or_default())
    }))
}

fn scatter(closure: &Closure, noise: Noise) -> String {
    let expected =
        Axis::ALL.map(|axis| format!("{axis} {:.3}", closure.scatter[axis] * noise.sigma_um));
    let found = closure.sigma_um().map_or_else(String::new, |sigma| {
        format!(
            "; the closure speaks for {sigma:.3} µm of a single reading ({} degrees of freedom)",
            closure.freedom
        )
    });
    format!(
        "expected standard deviation of a single w (2 sqrt(2) sigma with one run, µm): {}{found}",
        joined(expected)
    )
}

fn ramps(ramps: &Ramps, noise: Option<Noise>) -> String {
    let sigma = noise.map_or(0.0, |noise| noise.sigma_um);
    let verdict = if ramps.roll {
        "ROLL of an axis that carries others; the ramps are left out of the scatter"
    } else if ramps.probability < FALSE_DOUBT {
        "smaller than an instrument resolves"
    } else {
        "no roll is seen"
    };
    format!(
        "ramps over each axis, end to end (µm): {}: probability {:.3}, {verdict}",
        of_axes(&ramps.change_um, |axis| Some(ramps.u[axis] * sigma)),
        ramps.probability
    )
}

fn test(closure: &Closure, noise: Option<Noise>) -> String {
    let Some(noise) = noise else {
        return "no test of the scatter: the readings leave nothing over".into();
    };
    let Some(test) = closure.test(&noise) else {
        return "no chi-squared test: the noise that counts is that of this closure; repeat the runs".into();
    };
    let verdict = match (test.probability < FALSE_DOUBT, test.larger) {
        (false, _) => "in keeping with that noise",
        (true, true) => {
            "LARGER than that noise explains: the nine errors do not describe the readings (roll, drift, disturbed readings)"
        }
        (true, false) => {
            "SMALLER than that noise: single runs differ by what the closure does not see, or the noise is stated too large"
        }
    };
    let kind = match noise.source {
        NoiseSource::Repeats => "F test",
        NoiseSource::Stated | NoiseSource::Closure | NoiseSource::Joined => "chi-squared test",
    };
    let (sigma, from, p) = (noise.sigma_um, noise.source.word(), test.probability);
    format!(
        "{kind} of the scatter against {sigma:.3} µm {from}, two-sided: probability {p:.3}, {verdict}"
    )
}

fn reversal(separation: &Separation) -> Option<String> {
    let turn = separation.turn.as_ref()?;
    let k = coverage_factor(separation.noise.and_then(|noise| noise.freedom_f64()));
    let shown = |b: Estimate| {
        let u = figure(b.u_um.map(|u| k * u), "not known");
        format!("{:.3} ± {u}", Figure(b.um))
    };
    let cross = ErrorTerm::ALL.into_iter().filter(|term| term.is_cross());
    let cross = cross.map(|term| format!("{term} {}", shown(turn.reversal[term])));
    Some(paragraphs(&[
        reversal_of_axes(turn, shown),
        reversal_by_diagonal(turn, shown),
        format!("Reversal of cross terms, µm: {}", joined(cross)),
    ]))
}

fn reversal_of_axes(turn: &Turn, shown: impl Fn(Estimate) -> String) -> String {
    let rows = Axis::ALL.into_iter().map(|axis| {
        let own = ErrorTerm::positioning(axis);
        let [low, high] = turn.ends[axis];
        let constancy = turn.constancy[axis];
        let constancy = constancy.map_or_else(|| "-".into(), |p| format!("probability {p:.3}"));
        let (whole, low, high) = (shown(turn.reversal[own]), shown(low), shown(high));
        format!("{axis}\t{whole}\t{low}\t{high}\t{constancy}")
    });
    let heading = "axis\t>B/µm\t>at low end/µm\t>at high end/µm\t>constant?";
    format!(
        "Reversal from the turn (B = moving + minus moving -; ± U(95 %)): mean of both ends, and at each end as the curves hold it\n{}\na small probability in the last column: the reversal (of the axis or its cross terms) differs along the axis, and the first figure is no figure of the machine",
        table(heading, rows)
    )
}

fn reversal_by_diagonal(turn: &Turn, shown: impl Fn(Estimate) -> String) -> String {
    let rows = Axis::ALL.into_iter().map(|axis| {
        let each = turn.by_diagonal.iter().map(|(_, b)| format!("\t{}", shown(b[axis])));
        format!("{axis}{}", each.collect::<String>())
    });
    let heading = Diagonal::ALL.map(|d| format!("\t>{d}")).concat();
    format!(
        "From each diagonal alone, where the axis turned (X of NPP, Y of PNP, Z of PPN at the low end, all others at the high end)\n{}",
        table(&format!("B/µm{heading}"), rows)
    )
}

/// R of both passes along every diagonal.
fn repeatability(separation: &Separation) -> String {
    let passes = Diagonal::ALL.into_iter().flat_map(|d| Pass::BOTH.map(|pass| (d, pass)));
    let all = passes.filter_map(|(diagonal, pass)| {
        let found = repeatability_um(&separation.runs, diagonal, pass)?;
        Some(format!("{diagonal} {} {:.3}", pass.word(), Figure(found)))
    });
    named("Repeatability R = 4 s, the largest over all nodes (ISO 230-2), µm", all)
}
