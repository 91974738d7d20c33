//! What the inputs have to say of how they were understood.

use crate::inputs::job::Frame;
use crate::inputs::kind::Component;
use crate::quantity::{Axis, Diagonal, Direction, Figure};
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
        NotUsed { key: &'static str } => Note, "`{key}` of [measurement.uncertainty] concerns readings: the uncertainty of a term of an error table is what its header, its `u_…` column, `noise_um` and `laser_ppm` state";
    }
}

findings! {
    /// What an import finds.
    ImportFinding {
        // What the file states, and what was done with it.
        Encoding { name: String } => Label, "text: {name}";
        Understood { options: String } => Label, "understood from the file and confirmed with --yes: {options}";
        Says { entry: String } => Label, "the file says: {entry}";
        NoType => Label, "the file does not state its type: taken as linear, as `rtl` is";
        UnitOfFormat { unit: &'static str } => Label, "unit: {unit}";
        Units { positions: &'static str, values: &'static str } => Label, "unit of the positions: {positions}; of the values: {values}";
        ColumnsNamed { line: usize } => Label, "table: its columns are named in line {line}";
        PlusRows { moves: Direction, stated: bool } => Label, "direction: rows with `+` = the axis moving {moves}{}", if *stated { ", as stated" } else { "" };
        ForwardIs { moves: Direction } => Label, "direction: `Forward` is taken as the way from the first position to the last = the axis moving {moves}";
        Positions { count: usize, first: String, last: String } => Label, "positions: {count} targets at machine coordinates {first} … {last} mm";
        OwnZero => Label, "targets: counted from the zero of the file, not of the machine";
        Turned { component: Component } => Label, "sense: the file counts its targets against the axis, so {component} is turned as well";
        Runs { counts: Vec<(usize, Direction)>, fewest: usize } => Label, "runs: {}; {}", joined(counts.iter().map(|(runs, moving)| format!("{runs} moving {moving}"))), if *fewest > 1 { "mean of each direction, u = s/√runs (k = 1)" } else { "one run tells nothing about the uncertainty" };
        RunsOf { runs: usize, axis: Axis, direction: &'static str, u: &'static str } => Label, "runs: {runs} of {axis}, direction {direction}; their mean, {u}";
        Freedom { degrees: usize } => Label, "degrees of freedom: {degrees}";
        NeverMade { runs: Vec<usize> } => Label, "runs {} hold only zeros: they were never made and are left out", joined(runs);
        LeftOut { name: String, what: &'static str } => Label, "left out: {name} ({what})";
        Surroundings { values: Vec<String> } => Label, "air and material, the file names no units: {}", joined(values);
        NotMeasured { sensors: Vec<String> } => Label, "not measured (−1): {}", joined(sensors);

        // What to look at.
        OtherAxis { entry: String, axis: Axis } => Note, "the file names axis {entry}, but {axis} was stated as the moving axis (`--axis`): make sure that this is the file of {axis}";
        OtherVersion { version: String, known: &'static str } => Note, "`File Version` is {version}; the format is known from version {known} only: compare a value with the screen of the maker's program";
        WarmingUp { rows: usize, of: usize } => Note, "the laser was still warming up in {rows} of {of} rows";
        Material { state: &'static str, noted: String, stake: String } => Note, "{state}: the file notes {noted}, {stake}; away from 20 °C this table is not valid";
        UnlikelyReversal { axis: Axis, um: f64 } => Note, "E{axis}{axis}: B = {um:+.3} µm is above 0, ordinary lost motion gives B < 0: are the way of the targets, the directions or the sign stated as they were?";
    }
}
