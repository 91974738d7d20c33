//! What a person has to know of how a program was understood, in sentences.

use crate::interpreter::{RoughArcs, Tally};
use crate::moves::USUAL_MISS_MM;
use crate::{Setup, WithoutPoint};

pub(super) fn notes(tally: &Tally, deletable: u64, setup: &Setup) -> Vec<String> {
    let any = |count: u64| (count > 0).then_some(count);
    let meaning = match setup.without_point {
        WithoutPoint::Unit => "whole mm or inches (`X100` = 100 mm)",
        WithoutPoint::Increment => "least input increments (`X100` = 0.1 mm)",
    };
    let what = if setup.skip_deletable { "left out" } else { "executed" };
    let words = tally.m.iter().map(|(m, (count, letters))| {
        let letters: String = letters.iter().map(|letter| format!(" {letter}")).collect();
        format!("M{m}{letters} ({count})")
    });
    let words = words.collect::<Vec<String>>().join(", ");
    let found = [
        tally.without_unit.map(|line| format!("lengths are taken as mm from line {line} on: neither the program (G20, G21; G70, G71) nor `program_unit` in [path] says their unit")),
        tally.without_point.map(|(count, first)| format!("coordinates without a decimal point: {count}, the first in line {first}; taken as {meaning}; see `without_point` in [path]")),
        any(deletable).map(|count| format!("lines with `/`: {count}, {what}; see `block_delete` in [path]")),
        any(tally.look_ahead).map(|count| format!("look-ahead (G5, G5.1, G8) is switched on {count} times: taken not to change the path")),
        tally.blend.map(|(mm, line)| format!("G64 (ADIS and CYCLE832 of Siemens too) lets the control leave the path by up to {mm:.3} mm (the first so in line {line}): the path is followed as it is written")),
        tally.rough_arcs.map(|RoughArcs { count, most_mm, line, allowed_mm }| format!("arcs whose end misses the circle by more than {USUAL_MISS_MM} mm: {count}, most by {most_mm:.4} mm in line {line}; taken up to {allowed_mm:.3} mm, see `arc_mm` in [path]")),
        tally.other_mode.map(|line| format!("G90 or G91 was changed inside a cycle in line {line}: R and Z are read as they were written, in the mode of the block that drills; some controls keep the levels")),
        (!words.is_empty()).then(|| format!("taken to be without motion: {words}")),
    ];
    found.into_iter().flatten().collect()
}
