//! What there is to know of tables and programs before they are loaded.

use crate::quantity::{Axis, Direction, ErrorTerm, Rotation};
use crate::text::{findings, joined};

findings! {
    /// What is found while tables are planned and put into the control's numbers.
    TableFinding {
        OfTarget { terms: Vec<ErrorTerm>, note: String } => Note, "{}: {note}", joined(terms);
        MeanOnly { term: ErrorTerm, left: String, with_um: f64 } => Note, "{term}: the mean of both directions is used instead of two tables; {left} ({with_um:.1} µm with two tables for {term})";
        WrittenSpacing { axis: Axis, asked_mm: f64, written: f64, unit: &'static str, spacing_mm: f64 } => Note, "{axis}: the control writes a spacing of {asked_mm:.6} mm as {written} {unit} = {spacing_mm:.6} mm; points and values are those of the written spacing";
        ZeroPoints { axis: Axis, id: u32 } => Note, "{axis}: the pitch points of axis {id} are all zero; they carry the straightness of other axes only";
        ReferenceOff { axis: Axis, reference_mm: f64, beyond_mm: f64, travel_mm: [f64; 2] } => Note, "the reference point of {axis}, {reference_mm} mm, lies {beyond_mm:.2} mm outside the travel of the job, {} to {} mm: compare `reference_mm` and `travel_mm` with the machine; if the axis has its reference point elsewhere, switching a table on moves axes", travel_mm[0], travel_mm[1];
        OldAndResidual { path: String } => Note, "the tables of `{path}` were active during the measurement: these tables are old + residual and replace them";
        ParameterReplaced { parameter: &'static str, axes: Vec<Axis> } => Note, "the tables replace the {parameter} of {}, which is counted as 0 while measuring; a machine normally holds one even with its tables off: look, and if it was on, state `active_backlash_um = {{ … }}` beside `active_while_measuring = \"none\"`", joined(axes);
        UnlikelyReversal { term: ErrorTerm, um: f64 } => Question, "{term}: B = {um:+.3} µm without tables is above 0, ordinary lost motion gives B < 0: are the directions + and - exchanged?";
        LoneValue { term: ErrorTerm, direction: Option<Direction>, at_mm: f64, off_um: f64, rest_um: f64 } => Question, "{term} at {at_mm} mm{} stands {off_um:+.1} µm off the line through its neighbours, no other value more than {rest_um:.1} µm: a slip of sign or digit?", direction.map_or_else(String::new, |way| format!(" moving {way}"));
        Shifted { axis: Axis, um: f64 } => Note, "at the reference point the control adds {um:+.1} µm to {axis}, for its correction is zero at position 0: a shift of all positions, which no figure here contains";
        AnglesWritten { angles: Vec<Rotation> } => Note, "{}: also in the files. The control takes off what these angles do through the positions of the axes behind theirs, without a tool; no sign proof shows their sense", joined(angles);
        AnglesLeft { angles: Vec<Rotation> } => Note, "{}: not in the files, for no deviation along this axis has a table", joined(angles);
        NoSignProof { mechanism: &'static str, least_um: f64, slope_um_per_mm: f64 } => Note, "no sign proof of {mechanism}: no axis has a stretch, at least one section away from its reference and inside its travel, on which a bump rises to {least_um} µm with at most {slope_um_per_mm} µm/mm; measure after loading instead, one axis first";
        FormAssumed { source: String, if_wrong: String } => Note, "DRAFT: the form of the files is assumed, not read in a manual ({source}): compare them with a file that the control has written; if it is wrong: {if_wrong}";
        OtherLetters { key: &'static str, text: String, written: String } => Note, "{key} `{text}` stands as `{written}` in the control's files, which are ASCII";
    }
}

findings! {
    /// What is found while a measuring run is planned.
    RunFinding {
        FeedNotChecked { axes: Vec<Axis> } => Note, "the feed is not checked for {}: no `max_feed_mm_per_min` is stated", joined(axes);
        NearTheEnd { axes: Vec<Axis> } => Note, "{} moves to less than 1 mm from an end of the travel: the software limits have to allow it", joined(axes);
        OtherBox { turns_otherwise: bool } => Note, "box, steps, order{} or kind differ from [measurement.step_diagonal]: change that section before the readings of this run are separated", if *turns_otherwise { ", overrun" } else { "" };
        HidesPitches { axes: Vec<(Axis, f64, Option<f64>)> } => Note, "errors that repeat with a usual pitch are the same at all targets and will not be seen: {}", joined(axes.iter().map(|(axis, step, better)| format!("steps of {axis} {step} mm{}", better.map_or_else(String::new, |mm| format!(" (better {mm} mm)")))));
        ProtectedNumber { from: u32, by: &'static str } => Note, "program numbers from O{from} on may be protected against loading and editing ({by}; from memory, not in the manuals read): take another `number`, or see to it that they are not";
    }
}
