//! What a separation assumed and what its uncertainty holds, in words.

use super::campaign::Campaign;
use super::curves::noise_gain;
use super::increments::Means;
use super::metric::Plane;
use super::noise::coverage_factor;
use super::reversal::Turn;
use super::uncertainty::Budget;
use crate::inputs::job::{Frame, LinearSlope, SetUp};
use crate::machine::separation::totals::u_squareness;
use crate::quantity::axis::{Axis, ErrorTerm};

/// What was assumed and what counts in the uncertainty, one sentence each.
pub(super) fn labels(
    campaign: &Campaign<'_>,
    budget: &Budget<'_>,
    means: &Means,
    overrun: Option<bool>,
    turn: Option<&Turn>,
) -> Vec<String> {
    let measurement = campaign.measurement;
    let mut labels = Vec::new();
    if measurement.setup == SetUp::AssumePerfect {
        let tilt = match campaign.stated.tilt_arcsec {
            Some(arcsec) => format!("included in U as {arcsec} arcsec (k = 1, tilt_arcsec) in each direction"),
            None => "not included, so that no U is given where the slope is a separated one: state `tilt_arcsec` in [measurement.uncertainty]".to_string(),
        };
        labels.push(format!("set-up assumed perfect: mirror and beam exactly along the four diagonals; a tilt of 10 arcsec falsifies slopes by tens of µm/m; it is {tilt}"));
    }
    labels.push(match measurement.frame {
        Frame::XPrimary => "frame: X primary, XY plane secondary (EYX, EZX, EZY without slope; EXY, EXZ, EYZ carry the squareness)".to_string(),
        Frame::AsMeasured => "frame as measured: slopes of cross terms hold an arbitrary rotation; only their sums, the squareness, are free of it".to_string(),
    });
    labels.extend(way_back(campaign, means, overrun));
    labels.extend(turn.map(of_the_turn));
    if means.reverse.is_some() {
        labels.push("directions are those in which each axis really moved: + curves from forward runs of the diagonals that travel it in +, reverse runs of the others".to_string());
    }
    for axis in Axis::ALL {
        let gain = noise_gain(&measurement.volume, axis);
        if gain > 3.0 {
            labels.push(format!("{axis} is a short edge of the box: noise of its deviations is {gain:.1} times that of an increment"));
        }
    }
    labels.extend(common_labels(campaign, budget));
    labels
}

/// What is assumed of readings of any kind, and what their uncertainty holds.
pub(super) fn common_labels(campaign: &Campaign<'_>, budget: &Budget<'_>) -> Vec<String> {
    let measurement = campaign.measurement;
    let mut labels = Vec::new();
    if measurement
        .material
        .is_some_and(|material| !material.air_corrected)
    {
        labels.push("the readings are not corrected for air, and nothing corrects them here: about 1 µm/m of scale for each K of air temperature or 3.7 hPa".to_string());
    }
    labels.extend(budget_labels(budget));
    let (angles, stated) = (campaign.angle_evidence(), campaign.stated.angle_urad);
    labels.extend(angles.sentences(stated));
    labels.extend(line_labels(campaign));
    labels
}

/// What is known of the reverse passes.
fn way_back(campaign: &Campaign<'_>, means: &Means, overrun: Option<bool>) -> Vec<String> {
    if means.reverse.is_none() {
        return vec!["forward runs only: NPP moves X in -, PNP moves Y in -, PPN moves Z in -, so reversal is mixed into the curves".into()];
    }
    let from = if campaign.measurement.overrun.is_some() {
        "as stated"
    } else {
        "judged from the readings"
    };
    let mut said = vec![match overrun {
        Some(true) => format!("the axes ran over the far end before the reverse runs ({from})"),
        Some(false) => format!("the axes turned at the far end without overrun ({from}): the lost motion is taken off the last cell of the reverse runs"),
        None => "whether the axes ran over the far end cannot be judged from the readings: no reversal stands out of their noise, or offset and jumps contradict each other. State `overrun`; until then a lost motion that is hidden in the noise may stand in the last interval".into(),
    }];
    if !campaign.reverse_zero_known {
        said.push(
            "reverse runs count from their own start, so only their increments are used".into(),
        );
    }
    said
}

/// What the turn's reversals rest on.
fn of_the_turn(turn: &Turn) -> String {
    let terms = ErrorTerm::ALL.into_iter();
    let kept: Vec<String> = terms
        .filter(|term| !term.is_positioning() && turn.in_curves[*term])
        .map(|term| term.to_string())
        .collect();
    let cross = if kept.is_empty() {
        "no reversal of a cross term stands out of its noise, so their - curves start at 0 like the + curves".to_string()
    } else {
        format!(
            "reversal of cross terms stands out of its noise in {}, taken as constant along the axis; the other - curves start at 0",
            kept.join(", ")
        )
    };
    format!(
        "reversal of each axis from the turn, at both ends of the axis (three diagonals turn at its high end, one at its low end); {cross}"
    )
}

/// What is assumed of linear axes and beams.
fn line_labels(campaign: &Campaign<'_>) -> Vec<String> {
    let mut said = Vec::new();
    if campaign.lines.iter().any(|line| line.u_um_per_m.is_none()) {
        said.push("a linear axis or beam states no uncertainty: it is weighed like a diagonal, and neither an uncertainty nor a simulated interval is given where a result depends on it; add `u_um_per_m`".to_string());
    }
    if campaign.lines.iter().any(|line| line.u_um_per_m.is_some()) {
        said.push("`u_um_per_m` of linear axes and beams is taken to hold everything that is uncertain of them, laser and temperature included, apart from the diagonals".to_string());
    }
    let volume = &campaign.measurement.volume;
    let stated = campaign.measurement.linear.iter();
    let stated = stated.filter(|linear| matches!(linear.slope, LinearSlope::Stated(_)));
    let spans: Vec<String> = stated
        .map(|linear| {
            let low = volume.start[linear.axis].mm();
            let high = low + volume.size[linear.axis].mm();
            format!("{} {low} to {high} mm", linear.axis)
        })
        .collect();
    if !spans.is_empty() {
        said.push(format!(
            "stated slopes of linear axes are taken as those between the ends of the box ({}); give what was measured over another length as a `beam` with its two ends",
            spans.join(", ")
        ));
    }
    said
}

/// What counts in the uncertainty and what does not, one sentence each.
fn budget_labels(budget: &Budget<'_>) -> Vec<String> {
    let mut said = Vec::new();
    match budget.noise {
        Some(noise) => {
            let k = coverage_factor(noise.freedom_f64());
            let freedom = noise.freedom.map_or_else(String::new, |freedom| {
                format!(", {freedom} degrees of freedom: k = {k:.2} by Student holds 95 %")
            });
            said.push(format!(
                "noise of a single reading {:.3} µm (k = 1), {}{freedom}",
                noise.sigma_um,
                noise.source.words()
            ));
        }
        None => said.push(
            "noise of the readings is not known (one run, no redundancy): no uncertainty is given"
                .to_string(),
        ),
    }
    said.extend(stated_labels(budget));
    said
}
/// What of `[measurement.uncertainty]` counts, and for which axes.
fn stated_labels(budget: &Budget<'_>) -> Vec<String> {
    let material = |axis: Axis| budget.material.and_then(|material| material.axes[axis]);
    let alpha = |axis: Axis| material(axis).map(|_| ());
    let warm = |axis: Axis| material(axis)?.temperature_c.map(|_| ());
    let mut said = vec![match budget.stated.laser_ppm {
        Some(_) => {
            "laser_ppm is included in the scales, as an error that all four set-ups share".into()
        }
        None => "laser_ppm is not stated and not included".into(),
    }];
    said.push(by_axis(
        "temperature_k",
        budget.stated.temperature_k,
        alpha,
        "alpha_per_k",
    ));
    said.push(by_axis(
        "alpha_per_k",
        budget.stated.alpha_per_k,
        warm,
        "alpha_per_k and temperature_c, or a column of temperatures",
    ));
    let each = u_squareness(budget.volume, budget.volume.diagonal_mm() / 1000.0);
    let each = Plane::ALL.map(|plane| format!("{} {:.2}", plane.key(), each.of(plane)));
    let each = each.join(", ");
    said.push(match budget.stated.setup_ppm {
        Some(ppm) => format!("setup_ppm ({ppm}) is included: laser, air and scales change so much from one set-up to the next; each ppm makes µm/m of squareness: {each}"),
        None => format!("setup_ppm is not stated: changes of laser, air and scale temperature between the four set-ups are not included; each ppm (0.09 K of steel) makes µm/m of squareness: {each}"),
    });
    said.push(match budget.stated.beam_mrad {
        Some(mrad) => format!("beam_mrad ({mrad}) is included: it takes up to {:.3} µm/m off every diagonal, and all of that counts as k = 1", budget.stated.beam_ppm()),
        None => "beam_mrad is not stated and not included".into(),
    });
    let s = budget.stated;
    let any = [
        s.laser_ppm,
        s.temperature_k,
        s.alpha_per_k,
        s.setup_ppm,
        s.angle_urad,
        s.beam_mrad,
    ];
    if any.iter().any(Option::is_some) {
        said.push(
            "simulated intervals hold the noise of the readings and of the linear axes, not these"
                .into(),
        );
    }
    said
}

/// Whether a stated contribution that needs the material of an axis is included, by axis.
fn by_axis(
    key: &str,
    stated: Option<f64>,
    known: impl Fn(Axis) -> Option<()>,
    needs: &str,
) -> String {
    if stated.is_none() {
        return format!("{key} is not stated and not included");
    }
    let names = |wanted: bool| {
        let axes = Axis::ALL
            .into_iter()
            .filter(|axis| known(*axis).is_some() == wanted);
        axes.map(|axis| axis.to_string())
            .collect::<Vec<_>>()
            .join(", ")
    };
    let (with, without) = (names(true), names(false));
    let missing = format!("the job gives no {needs} of it ([measurement.step_diagonal.material])");
    match (with.as_str(), without.as_str()) {
        (_, "") => format!("{key} is included in the scales, the same error on all axes"),
        ("", _) => format!(
            "{key} is stated but not included for any axis: {}",
            missing.replace(" of it", "")
        ),
        _ => format!(
            "{key} is included in the scales for {with}, the same error on them, but not for {without}: {missing}"
        ),
    }
}
