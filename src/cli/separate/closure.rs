//! What `separate` prints of the closure, of disturbed readings, of the reversal at a turn and of repeated
//! runs.

use crate::cli::screen::{paragraphs, table};
use crate::machine::separation::Separation;
use crate::machine::separation::closure::Closure;
use crate::machine::separation::noise::{
    FALSE_DOUBT, Noise, NoiseSource, Outlier, coverage_factor,
};
use crate::machine::separation::patterns::Ramps;
use crate::machine::separation::readings::repeatability_um;
use crate::machine::separation::reversal::{Estimate, Turn};
use crate::quantity::axis::{Axis, ErrorTerm};
use crate::quantity::diagonal::{Diagonal, Pass};
use crate::quantity::units::Figure;

pub(super) fn closure(separation: &Separation) -> String {
    let closure = &separation.closure;
    let mut lines = vec![format!("Closure: mean over each axis (µm) {}", means(separation))];
    lines.push(
        "  a constant is set-up error or, with a flat mirror, roll of an axis that carries others"
            .into(),
    );
    if let Some(noise) = separation.noise {
        lines.push(scatter(closure, noise));
    }
    lines.extend(closure.ramps.as_ref().map(|ramps| self::ramps(ramps, separation.noise)));
    lines.push(test(closure, separation.noise));
    lines.push("a clean closure proves nothing about pitch, yaw and five of eight patterns of set-up error".into());
    lines.join("\n")
}

/// Each with its expected standard deviation.
fn means(separation: &Separation) -> String {
    let closure = &separation.closure;
    let mean = |axis: Axis| match separation.noise {
        Some(noise) => format!(
            "{axis} {:+.3} (expected scatter {:.3})",
            Figure(closure.mean[axis]),
            closure.u_mean_um(axis, noise.sigma_um)
        ),
        None => format!("{axis} {:+.3}", Figure(closure.mean[axis])),
    };
    Axis::ALL.map(mean).join(", ")
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
        expected.join(", ")
    )
}

fn ramps(ramps: &Ramps, noise: Option<Noise>) -> String {
    let sigma = noise.map_or(0.0, |noise| noise.sigma_um);
    let each = Axis::ALL.map(|axis| {
        format!(
            "{axis} {:+.3} (expected scatter {:.3})",
            Figure(ramps.change_um[axis]),
            ramps.u[axis] * sigma
        )
    });
    let verdict = if ramps.is_roll() {
        "ROLL of an axis that carries others; the ramps are left out of the scatter"
    } else if ramps.probability < FALSE_DOUBT {
        "smaller than an instrument resolves"
    } else {
        "no roll is seen"
    };
    format!(
        "ramps over each axis, end to end (µm): {}: probability {:.3}, {verdict}",
        each.join(", "),
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
    let (sigma, from, p) = (noise.sigma_um, noise.source.words(), test.probability);
    format!(
        "{kind} of the scatter against {sigma:.3} µm {from}, two-sided: probability {p:.3}, {verdict}"
    )
}

/// A disturbed reading; it stays in the result.
pub(super) fn disturbed(outlier: &Outlier) -> String {
    format!("disturbed reading, repeat the run: {}", outlier.words())
}

pub(super) fn reversal(separation: &Separation) -> String {
    let Some(turn) = &separation.turn else {
        return String::new();
    };
    let k = coverage_factor(separation.noise.and_then(|noise| noise.freedom_f64()));
    let shown = |b: Estimate| {
        let u = b.u_um.map_or_else(|| "not known".into(), |u| format!("{:.3}", Figure(k * u)));
        format!("{:.3} ± {u}", Figure(b.um))
    };
    paragraphs(&[
        reversal_of_axes(turn, shown),
        reversal_by_diagonal(turn, shown),
        reversal_of_cross_terms(turn, shown),
    ])
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
        let each = turn.by_diagonal.iter();
        let each = each.map(|(_, b)| format!("\t{}", shown(b[axis])));
        format!("{axis}{}", each.collect::<String>())
    });
    let heading = Diagonal::ALL.map(|d| format!("\t>{d}")).concat();
    format!(
        "From each diagonal alone, where the axis turned (X of NPP, Y of PNP, Z of PPN at the low end, all others at the high end)\n{}",
        table(&format!("B/µm{heading}"), rows)
    )
}

fn reversal_of_cross_terms(turn: &Turn, shown: impl Fn(Estimate) -> String) -> String {
    let cross = ErrorTerm::ALL.into_iter().filter(|t| !t.is_positioning());
    let said: Vec<String> =
        cross.map(|term| format!("{term} {}", shown(turn.reversal[term]))).collect();
    format!("Reversal of cross terms, µm: {}", said.join(", "))
}

/// R of both passes along every diagonal.
pub(super) fn repeatability(separation: &Separation) -> String {
    let of = |diagonal: Diagonal| {
        let pass = |pass: Pass| {
            let found = repeatability_um(&separation.runs, diagonal, pass)?;
            Some(format!("{diagonal} {} {:.3}", pass.word(), Figure(found)))
        };
        Pass::BOTH.into_iter().filter_map(pass).collect::<Vec<_>>()
    };
    let all: Vec<String> = Diagonal::ALL.into_iter().flat_map(of).collect();
    if all.is_empty() {
        return String::new();
    }
    format!("Repeatability R = 4 s, the largest over all nodes (ISO 230-2), µm: {}", all.join(", "))
}
