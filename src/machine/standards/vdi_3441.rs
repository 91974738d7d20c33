//! VDI/DGQ 3441: statistical testing of the operating and positioning accuracy of machine tools.
//!
//! Everything here is *likely*: from secondary sources, not compared with the text of the
//! guideline. Its conditions (number of targets and runs) are therefore not tested.

use crate::inputs::target_runs::Runs;
use crate::machine::standards::{iso_230_2, largest, range};

/// Width of the band of scatter in standard deviations (± 3 s).
const BAND: f64 = 6.0;

/// Figures of one target, µm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetFigures {
    /// Target, mm.
    pub target_mm: f64,
    /// x̿_j: mean of the means of both directions.
    pub mean_um: f64,
    /// U_j: reversal, without sign.
    pub u_um: f64,
    /// s̄_j: mean of the standard deviations of both directions; absent with one run.
    pub s_um: Option<f64>,
}

/// Figures of the guideline, µm.
#[derive(Clone, Debug, PartialEq)]
pub struct Figures {
    /// Of each target, ascending.
    pub targets: Vec<TargetFigures>,
    /// P: positioning uncertainty; absent with one run.
    pub p_um: Option<f64>,
    /// P_a: positioning deviation, the range of x̿_j.
    pub p_a_um: f64,
    /// P_s: largest positioning scatter; absent with one run.
    pub p_s_um: Option<f64>,
    /// U: largest reversal.
    pub u_um: f64,
    /// Ū: mean reversal.
    pub u_mean_um: f64,
}

/// Figures of VDI/DGQ 3441; `None` unless both directions were measured.
///
///   x̿_j = (x̄_j↑ + x̄_j↓)/2       U_j = |x̄_j↑ − x̄_j↓|       s̄_j = (s_j↑ + s_j↓)/2
///   U = max U_j       P_s = max 6 s̄_j       P_a = max x̿_j − min x̿_j
///   P = max[x̿_j + (U_j + 6 s̄_j)/2] − min[x̿_j − (U_j + 6 s̄_j)/2]
///
/// unit   µm
/// source VDI/DGQ 3441:1977, likely (secondary sources)
/// limits s̄_j, P_s and P need two runs of each direction or more
pub fn figures(runs: &Runs) -> Option<Figures> {
    let targets: Option<Vec<TargetFigures>> =
        iso_230_2::figures(runs).targets.iter().map(of_target).collect();
    let targets = targets?;
    let bands: Option<Vec<f64>> = targets.iter().map(|of| Some(BAND * of.s_um?)).collect();
    let ends = |(of, band): (&TargetFigures, &f64)| {
        let half = (of.u_um + band) / 2.0;
        [of.mean_um - half, of.mean_um + half]
    };
    let u = || targets.iter().map(|of| of.u_um);
    Some(Figures {
        p_um: bands.as_ref().and_then(|bands| range(targets.iter().zip(bands).flat_map(ends))),
        p_a_um: range(targets.iter().map(|of| of.mean_um))?,
        p_s_um: bands.and_then(largest),
        u_um: largest(u())?,
        u_mean_um: u().sum::<f64>() / targets.len() as f64,
        targets,
    })
}

fn of_target(of: &iso_230_2::TargetFigures) -> Option<TargetFigures> {
    let s = of.s.up_um.zip(of.s.down_um);
    Some(TargetFigures {
        target_mm: of.target_mm,
        mean_um: of.mean.both_um?,
        u_um: of.b_um?.abs(),
        s_um: s.map(|(up, down)| (up + down) / 2.0),
    })
}
