//! Targets as the instrument counts them → machine coordinates; runs → mean and uncertainty.

use crate::inputs::import::Component;
use crate::inputs::import::choices::{Sign, turned};
use crate::inputs::import::stated::{Stated, missing};
use crate::quantity::axis::Direction;
use crate::quantity::units::Squared;
use crate::text::problem::{Place, Problem, Problems};

/// Nine decimals: far below what can be measured, and free of the dust of binary sums.
pub(super) fn tidy(number: f64) -> f64 {
    (number * 1e9).round() / 1e9 + 0.0
}

/// Where the targets of a file stand on the machine.
pub(super) struct Placing {
    /// Machine coordinate of each target, in the order of the targets.
    positions_mm: Vec<f64>,
    /// The way of the axis from the first target to the last.
    pub(super) run: Direction,
    /// The file counts its targets against the axis.
    turned: bool,
}

impl Placing {
    /// From what was stated; what is missing is noted.
    pub(super) fn of(
        targets: &[f64],
        at: &Place,
        stated: &Stated,
        problems: &mut Problems,
    ) -> Option<Placing> {
        let ascending = sense(targets, at, problems);
        if stated.first_target_at_mm.is_none() {
            problems.push(
                missing(
                    "--first-target-at-mm",
                    "the targets of the file count from the laser's zero, not from the machine's",
                    "add the machine coordinate of target 1, e.g. `--first-target-at-mm -200`",
                )
                .at(at.clone()),
            );
        }
        if stated.targets_run.is_none() {
            problems.push(
                missing(
                    "--targets-run",
                    "the file does not say whether the targets go towards larger or smaller machine coordinates",
                    "add `--targets-run +` or `--targets-run -`: the way of the axis from the first target to the last",
                )
                .at(at.clone()),
            );
        }
        let (ascending, run) = (ascending?, stated.targets_run?);
        let first_mm = stated.first_target_at_mm?;
        let is_turned = ascending != (run == Direction::Plus);
        let positions_mm = targets.iter().map(|target| {
            let way = target - targets[0];
            tidy(first_mm + if is_turned { -way } else { way })
        });
        Some(Placing {
            positions_mm: positions_mm.collect(),
            run,
            turned: is_turned,
        })
    }

    /// Values of the targets in the order of the machine.
    fn ascending<T: Clone>(&self, of_targets: &[T]) -> Vec<T> {
        let mut values = of_targets.to_vec();
        if self.run == Direction::Minus {
            values.reverse();
        }
        values
    }

    /// Machine coordinates, ascending.
    pub(super) fn positions_mm(&self) -> Vec<f64> {
        self.ascending(&self.positions_mm)
    }

    /// Values of a file, µm and in the order of its targets → deviations in the order of the machine.
    pub(super) fn deviations(&self, um: &[f64], component: Component, sign: Sign) -> Vec<f64> {
        let against = self.turned && component.is_positioning();
        let deviation = |um: &f64| {
            let um = sign.deviation(*um);
            tidy(if against { turned(um) } else { um })
        };
        let of_targets: Vec<f64> = um.iter().map(deviation).collect();
        self.ascending(&of_targets)
    }

    /// Uncertainties in the order of the machine; they have no sign.
    pub(super) fn uncertainties(&self, um: &[f64]) -> Vec<f64> {
        let of_targets: Vec<f64> = um.iter().map(|um| tidy(*um)).collect();
        self.ascending(&of_targets)
    }

    /// Where the targets stand, in words.
    pub(super) fn words(&self) -> Option<String> {
        let positions = self.positions_mm();
        let (first, last) = (positions.first()?, positions.last()?);
        Some(format!(
            "positions: {} targets at machine coordinates {first} … {last} mm",
            positions.len()
        ))
    }

    /// What was done with the sense of the deviations, where something was done.
    pub(super) fn sense_words(&self, component: Component) -> Option<String> {
        (self.turned && component.is_positioning()).then(|| {
            format!("sense: the file counts its targets against the axis, so {component} is turned as well")
        })
    }
}

/// Whether targets ascend; neither is a problem.
fn sense(targets: &[f64], at: &Place, problems: &mut Problems) -> Option<bool> {
    if targets.len() >= 2 && targets.windows(2).all(|pair| pair[0] < pair[1]) {
        return Some(true);
    }
    if targets.len() >= 2 && targets.windows(2).all(|pair| pair[0] > pair[1]) {
        return Some(false);
    }
    problems.push(
        Problem::new("the targets neither ascend nor descend, expected at least two in one sense")
            .at(at.clone())
            .help("a measurement on a line is needed; circular or repeated targets make no curve"),
    );
    None
}

/// One u for all targets, from their scatter together: that of a single one is known too badly, and two
/// equal readings at a target do not make it exact.
pub(super) fn pooled(um: &[f64]) -> Vec<f64> {
    #[allow(clippy::cast_precision_loss, reason = "a measurement has few targets")]
    let count = um.len() as f64;
    let mean_square = um.iter().map(|um| um.squared()).sum::<f64>() / count;
    vec![mean_square.sqrt(); um.len()]
}

/// The remark of an error table on how well such a u is known: targets · (runs − 1).
pub(super) fn freedom_remark(targets: usize, runs: usize) -> Option<String> {
    let freedom = targets * runs.saturating_sub(1);
    (freedom > 0).then(|| format!("degrees of freedom: {freedom}"))
}

/// Mean of the runs, and with two runs or more its standard uncertainty s/√n.
pub(super) fn mean(values: &[f64]) -> (f64, Option<f64>) {
    #[allow(clippy::cast_precision_loss, reason = "a measurement has few runs")]
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    if values.len() < 2 {
        return (mean, None);
    }
    let squares = values
        .iter()
        .map(|value| (value - mean).squared())
        .sum::<f64>();
    (mean, Some((squares / (count - 1.0) / count).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uncertainty_of_a_mean_is_s_over_the_root_of_n() {
        // Two readings d apart: s = d/√2, s/√2 = d/2.
        assert_eq!(mean(&[1.0, 3.0]), (2.0, Some(1.0)));
        assert_eq!(mean(&[4.0]), (4.0, None));
    }
}
