//! What the inputs have to say of how they were understood.

use crate::inputs::job::Frame;
use crate::quantity::{Diagonal, Figure};
use crate::text::{findings, joined};

findings! {
    /// What an error table or a file of readings says of itself, and what a job states for nothing.
    Remark {
        Doubtful { words: String } => Doubt, "{words}";
        MoreDoubts { count: usize } => Doubt, "doubts and errors not determined that are not listed: {count} more";
        MoreNotes { count: usize } => Note, "notes that are not listed: {count} more";
        OtherFrames { first: Frame, second: Frame } => Doubt, "the joined tables count from different frames ({} and {}): the slopes of their cross terms differ by a rotation that none of them measured; separate all axes from one measurement", first.word(), second.word();
        Simulated { words: String } => Note, "{words}";
        Said { words: String } => Note, "{words}";
        Zeroed { zeros_um: Vec<(Diagonal, f64)> } => Note, "the laser was not zeroed at node 0: subtracted from all readings of {}", joined(zeros_um.iter().map(|(of, um)| format!("{of} {:.3} µm", Figure(*um))));
        NotUsed { key: &'static str } => Note, "`{key}` of [measurement.uncertainty] is not used by this version: the uncertainty of a term is what its `u_…` column, `noise_um` and `laser_ppm` state";
    }
}
