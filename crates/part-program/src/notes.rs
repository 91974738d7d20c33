//! What a person has to know of how a program was understood, in sentences.

use crate::interpreter::{RoughArcs, Tally};
use crate::moves::USUAL_MISS_MM;
use crate::{Setup, WithoutPoint};
use std::collections::BTreeSet;

pub(super) fn notes(tally: &Tally, deletable: u64, setup: &Setup) -> Vec<String> {
    let what = if setup.skip_deletable { "left out" } else { "executed" };
    let deletable = (deletable > 0)
        .then(|| format!("lines with `/`: {deletable}, {what}; see `block_delete` in [path]"));
    let count = tally.look_ahead;
    let look_ahead = (count > 0).then(|| {
        format!(
            "look-ahead (G5, G5.1, G8) is switched on {count} times: taken not to change the path"
        )
    });
    let blend = tally.blend.map(|(mm, line)| format!("G64 (ADIS and CYCLE832 of Siemens too) lets the control leave the path by up to {mm:.3} mm (the first so in line {line}): the path is followed as it is written"));
    let other_mode = tally.other_mode.map(|line| format!("G90 or G91 was changed inside a cycle in line {line}: R and Z are read as they were written, in the mode of the block that drills; some controls keep the levels"));
    let beside =
        |letters: &BTreeSet<char>| letters.iter().map(|l| format!(" {l}")).collect::<String>();
    let words =
        tally.m.iter().map(|(m, (count, letters))| format!("M{m}{} ({count})", beside(letters)));
    let words: Vec<String> = words.collect();
    let without_motion =
        (!words.is_empty()).then(|| format!("taken to be without motion: {}", words.join(", ")));
    let rough = tally.rough_arcs.as_ref().map(rough_arcs);
    let found = [
        without_point(tally, setup),
        deletable,
        look_ahead,
        blend,
        rough,
        other_mode,
        without_motion,
    ];
    found.into_iter().flatten().collect()
}

fn without_point(tally: &Tally, setup: &Setup) -> Option<String> {
    let (count, line) = (tally.without_point, tally.first_without_point);
    let meaning = match setup.without_point {
        WithoutPoint::Unit => "whole mm or inches (`X100` = 100 mm)",
        WithoutPoint::Increment => "least input increments (`X100` = 0.1 mm)",
    };
    (count > 0).then(|| format!("coordinates without a decimal point: {count}, the first in line {line}; taken as {meaning}; see `without_point` in [path]"))
}

fn rough_arcs(RoughArcs { count, most_mm, line, allowed_mm }: &RoughArcs) -> String {
    format!(
        "arcs whose end misses the circle by more than {USUAL_MISS_MM} mm: {count}, most by {most_mm:.4} mm in line {line}; taken up to {allowed_mm:.3} mm, see `arc_mm` in [path]"
    )
}
