//! What a run leaves open, said before it is measured, with the measurement that closes it.

use crate::inputs::job::{Job, MeasuredData, ProgramRequest, RunType};
use crate::quantity::Axis;
use crate::text::{Finding, findings};

/// Axes measured along their length that determine all scales (docs/method.md §5).
const LINEAR_AXES: usize = 2;

findings! {
    /// What a run alone cannot determine.
    Open {
        Scales { given: usize } => Label,
            "scales (positioning over the whole length): a tilt of the mirror looks the same, and the job names {given} linear axes; measure two axes along their length, three to check them";
        Reversal => Label,
            "reversal: every node is read in one direction; measure with `bidirectional = true`, or linear axes in both directions";
        ReversalOfAnAxis => Label,
            "reversal of a single axis: with overrun only its sum along each diagonal shows; `overrun_mm = 0`, or linear axes in both directions";
        NineErrors => Label,
            "the nine errors: straight runs give the lengths of the diagonals only; use `what = \"step-diagonal\"`";
        Straightness { axes: String } => Label,
            "straightness and squareness: runs along {axes} give the positioning only; use `what = \"step-diagonal\"`, or measure them separately";
        Angles => Label,
            "angular errors: what they do to the diagonals is taken for straightness; measure roll, pitch and yaw and give them as `angles`";
    }
}

/// What the run of a job cannot determine.
pub fn left_open(job: &Job, request: &ProgramRequest) -> Vec<Finding> {
    let is_step = request.what == RunType::StepDiagonal;
    let reversal = match (request.bidirectional, request.runs_over()) {
        (false, _) => Some(Open::Reversal),
        (true, Some(true)) if is_step => Some(Open::ReversalOfAnAxis),
        (true, _) => None,
    };
    let of_run = match request.what {
        RunType::StepDiagonal => scales(job).into_iter().chain([Open::Angles]).collect(),
        RunType::StraightDiagonal => vec![Open::NineErrors],
        RunType::SingleAxis => vec![Open::Straightness { axes: Axis::letters(&request.axes) }],
    };
    of_run.into_iter().chain(reversal).map(Finding::from).collect()
}

fn scales(job: &Job) -> Option<Open> {
    let given = match &job.measurement.data {
        MeasuredData::Diagonals(how) => how.linear.len(),
        MeasuredData::Errors(_) => 0,
    };
    (given < LINEAR_AXES).then_some(Open::Scales { given })
}
