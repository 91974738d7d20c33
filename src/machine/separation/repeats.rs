//! What repeated runs say: the standard deviation of a single reading, and the readings of single
//! runs that spoil it.
//!
//! In each pass along a diagonal a reading is the mean of its node plus an offset of its run (each
//! run has a zero of its own) plus noise. A disturbed reading of one run stands out from the
//! others at its node; the closure sees only 1/r of it, and the scatter all of it. So these are
//! named first, and the noise is that of the others.

use super::noise::{CorrectedRun, Noise, NoiseSource};
use super::outlier::{MOST_OUTLIERS, Outlier, ReadingPlace, float, stands_out};
use crate::quantity::diagonal::{Diagonal, Pass};

/// What repeated runs say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Repeats {
    /// σ of a single reading, without the disturbed ones; `None` where no pass was repeated.
    pub noise: Option<Noise>,
    /// Disturbed readings of single runs, the largest first.
    pub outliers: Vec<Outlier>,
}

/// σ of a single reading and the disturbed readings of repeated runs, pooled over all passes.
pub fn repeats(runs: &[CorrectedRun]) -> Repeats {
    let mut passes = passes(runs);
    let readings: usize = passes
        .iter()
        .map(|pass| pass.left.len() * pass.nodes())
        .sum();
    let freedom: usize = passes.iter().map(RepeatedPass::freedom).sum();
    let mut outliers: Vec<Outlier> = Vec::new();
    while outliers.len() < MOST_OUTLIERS {
        let square = passes.iter().map(RepeatedPass::square).sum();
        let largest = passes.iter().enumerate();
        let largest = largest.filter_map(|(at, pass)| Some((at, pass.largest()?)));
        let Some((at, candidate)) = largest.max_by(|(_, a), (_, b)| a.drop.total_cmp(&b.drop))
        else {
            break;
        };
        let found = (square, freedom - outliers.len());
        let size = (candidate.size_um, candidate.drop);
        let Some(ratio) = stands_out(size, found, None, readings) else {
            break;
        };
        outliers.push(passes[at].named(&candidate, ratio));
        passes[at].take_off(&candidate);
    }
    let square: f64 = passes.iter().map(RepeatedPass::square).sum();
    let freedom = freedom - outliers.len();
    let noise = (freedom > 0).then(|| Noise {
        sigma_um: (square / float(freedom)).sqrt(),
        freedom: Some(freedom),
        source: NoiseSource::Repeats,
    });
    Repeats { noise, outliers }
}

/// Readings of one pass along a diagonal that was walked more than once.
struct RepeatedPass {
    diagonal: Diagonal,
    pass: Pass,
    runs: Vec<u32>,
    /// By run and node: readings less the mean of their node and the mean of their run, µm.
    left: Vec<Vec<f64>>,
}

/// The reading that stands out most.
struct Candidate {
    run: usize,
    node: usize,
    size_um: f64,
    drop: f64,
}

fn passes(runs: &[CorrectedRun]) -> Vec<RepeatedPass> {
    let mut passes = Vec::new();
    for diagonal in Diagonal::ALL {
        for pass in Pass::BOTH {
            let of = |run: &&CorrectedRun| run.diagonal == diagonal && run.pass == pass;
            let walked: Vec<&CorrectedRun> = runs.iter().filter(of).collect();
            if walked.len() > 1 {
                let readings = walked.iter().map(|run| run.readings_um.clone());
                passes.push(RepeatedPass {
                    diagonal,
                    pass,
                    runs: walked.iter().map(|run| run.number).collect(),
                    left: residuals(readings.collect()),
                });
            }
        }
    }
    passes
}

impl RepeatedPass {
    fn nodes(&self) -> usize {
        self.left.first().map_or(0, Vec::len)
    }

    fn freedom(&self) -> usize {
        (self.left.len() - 1) * self.nodes().saturating_sub(1)
    }

    fn square(&self) -> f64 {
        self.left.iter().flatten().map(|r| r * r).sum()
    }

    /// What is left of a reading of size 1 in a complete table of runs and nodes.
    fn share(&self) -> f64 {
        (1.0 - 1.0 / float(self.left.len())) * (1.0 - 1.0 / float(self.nodes()))
    }

    fn largest(&self) -> Option<Candidate> {
        let cells = self.left.iter().enumerate();
        let cells = cells.flat_map(|(run, left)| {
            let nodes = left.iter().enumerate();
            nodes.map(move |(node, left)| (run, node, *left))
        });
        let (run, node, left) = cells.max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()))?;
        let share = self.share();
        (share > 0.0).then(|| Candidate {
            run,
            node,
            size_um: left / share,
            drop: left * left / share,
        })
    }

    /// With two runs their difference does not say which one is disturbed.
    fn named(&self, found: &Candidate, ratio: f64) -> Outlier {
        let place = |run: &u32| ReadingPlace {
            diagonal: self.diagonal,
            pass: self.pass,
            run: Some(*run),
            node: found.node,
        };
        let others = self.runs.iter().enumerate();
        let others = others.filter(|(at, _)| *at != found.run && self.runs.len() == 2);
        let first = std::iter::once(place(&self.runs[found.run]));
        Outlier {
            readings: first.chain(others.map(|(_, run)| place(run))).collect(),
            size_um: found.size_um,
            ratio,
            of_mean_um: found.size_um / float(self.runs.len()),
        }
    }

    fn take_off(&mut self, found: &Candidate) {
        self.left[found.run][found.node] -= found.size_um;
        self.left = residuals(std::mem::take(&mut self.left));
    }
}

/// Readings less the mean of their node and the mean of their run.
fn residuals(mut runs: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let nodes = runs.first().map_or(0, Vec::len);
    let count = float(runs.len());
    for node in 0..nodes {
        let middle = runs.iter().map(|run| run[node]).sum::<f64>() / count;
        runs.iter_mut().for_each(|run| run[node] -= middle);
    }
    for run in &mut runs {
        let offset = run.iter().sum::<f64>() / float(nodes);
        run.iter_mut().for_each(|left| *left -= offset);
    }
    runs
}
