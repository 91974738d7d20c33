//! What the figures of a volume rest on, in words.

use crate::quantity::{Axis, ErrorTerm};
use crate::text::{Finding, findings, joined};

findings! {
    /// What a model of the volume takes for granted.
    VolumeFinding {
        Doubtful { why: Finding } => Doubt, "doubt: {why}";
        Unlikely { name: String, largest: f64, unit: &'static str, limit: f64 } => Doubt, "doubt: {name} reaches {largest:.0} {unit}, and more than {limit:.0} {unit} is unlikely: check the unit of its column or key";
        NoJob => Label, "no job describes this machine: the curves are zero, and levers count from, the lowest measured position of each axis; whether a compensation was active during the measurement is not known";
        ActiveNotStated => Label, "`active_while_measuring` is not stated: if a compensation (or a backlash parameter) was active during the measurement, these figures are those of the machine with it; write \"none\", or the path of the kit or of the files read out of the control";
        OutOfReach { places: Vec<String> } => Label, "`offsets_mm` names a place that the machine does not reach: {}; levers count from there all the same", joined(places);
        NotDetermined { term: ErrorTerm, why: String } => Label, "{term} is not determined: {why}";
        ChainAssumed => Label, "the chain is not stated: without angles no figure depends on it; what missing angles leave out is told for axes that all move the tool";
        SquarenessInCurves => Label, "squareness is not stated apart: it counts as far as the slopes of the straightness curves hold it";
        SquarenessStated { stated: String } => Label, "squareness as stated: {stated}; positive = the angle between the two positive axis directions is less than 90°";
        LeverOrigin { second: String, third: String } => Label, "levers of the angles count from {second}, {third} (`offsets_mm`: the lines whose errors these are)";
        AnglesAtReference { angles: String } => Label, "angles count as given: at the reference {angles}. Squareness that was measured with an axis standing anywhere but where its angles are zero holds them already; then state `angles_zero_mm`";
        AnglesZero { axis: Axis, mm: f64 } => Label, "angles of {axis} count from {mm} mm, where they are taken as zero (`angles_zero_mm`)";
        OpticOnTable { axis: Axis, mm: f64 } => Label, "{axis} carries the workpiece and its straightness was measured on the table at {mm} mm (`straightness_optic_mm`): its own travel is a lever";
        OpticAtTool { axis: Axis } => Label, "{axis} carries the workpiece: its straightness counts as measured at the tool point, which holds its own lever already; an optic riding on the table needs `straightness_optic_mm`";
        BothDirections { axis: Axis } => Label, "{axis} was measured in both directions: the mean of both counts, the reversal is not in these figures";
        OneDirection { axis: Axis } => Label, "{axis} was measured in one direction: the figures hold for it only";
        JudgedPart { axis: Axis, judged: [f64; 2], travel: [f64; 2] } => Label, "{axis} is judged from {} to {} mm, where it was measured; its travel is {} … {} mm", judged[0], judged[1], travel[0], travel[1];
    }
}
