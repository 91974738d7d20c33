//! What the inputs have to say of how they were understood.

use crate::inputs::job::Frame;
use crate::quantity::diagonal::Diagonal;
use crate::quantity::units::Figure;
use crate::text::finding::findings;

findings! {
    /// What an error table or a file of readings says of itself, and what a job states for nothing.
    Remark {
        Doubtful { words: String } => Doubt, "{words}";
        MoreDoubts { count: usize } => Doubt, "doubts and errors not determined that are not listed: {count} more";
        MoreNotes { count: usize } => Note, "notes that are not listed: {count} more";
        OtherFrames { first: Frame, second: Frame } => Doubt, "the joined tables count from different frames ({} and {}): the slopes of their cross terms differ by a rotation that none of them measured; separate all axes from one measurement", first.word(), second.word();
        Simulated { words: String } => Note, "{words}";
        Said { words: String } => Note, "{words}";
        Zeroed { zeros_um: Vec<(Diagonal, f64)> } => Note, "the laser was not zeroed at node 0: subtracted from all readings of {}", zeros(zeros_um);
        NotUsed { key: &'static str } => Note, "`{key}` of [measurement.uncertainty] is not used by this version: the uncertainty of a term is what its `u_…` column, `noise_um` and `laser_ppm` state";
    }
}

/// `PPP 12.500 µm, NPP -3.000 µm`.
fn zeros(zeros_um: &[(Diagonal, f64)]) -> String {
    let of = |(diagonal, um): &(Diagonal, f64)| format!("{diagonal} {:.3} µm", Figure(*um));
    zeros_um.iter().map(of).collect::<Vec<_>>().join(", ")
}

findings! {
    /// How a part program was understood.
    PathFinding {
        WithoutPoint { count: u64, line: usize, meaning: &'static str } => Note, "coordinates without a decimal point: {count}, the first in line {line}; taken as {meaning}; see `without_point` in [path]";
        Deletable { count: u64, what: &'static str } => Note, "lines with `/`: {count}, {what}; see `block_delete` in [path]";
        LookAhead { count: u64 } => Note, "look-ahead (G5, G5.1, G8) is switched on {count} times: taken not to change the path";
        Blend { mm: f64, line: usize } => Note, "G64 (ADIS and CYCLE832 of Siemens too) lets the control leave the path by up to {mm:.3} mm (the first so in line {line}): the path is followed as it is written";
        RoughArcs { usual_mm: f64, count: u64, most_mm: f64, line: usize, allowed_mm: f64 } => Note, "arcs whose end misses the circle by more than {usual_mm} mm: {count}, most by {most_mm:.4} mm in line {line}; taken up to {allowed_mm:.3} mm, see `arc_mm` in [path]";
        OtherMode { line: usize } => Note, "G90 or G91 was changed inside a cycle in line {line}: R and Z are read as they were written, in the mode of the block that drills; some controls keep the levels";
        WithoutMotion { words: Vec<String> } => Note, "taken to be without motion: {}", words.join(", ");
    }
}
