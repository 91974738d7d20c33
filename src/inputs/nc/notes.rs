//! What a person has to know of how a program was understood, in findings.

use crate::inputs::findings::PathFinding;
use crate::inputs::nc::interpreter::{RoughArcs, Tally};
use crate::inputs::nc::moves::USUAL_MISS_MM;
use crate::inputs::nc::{Setup, WithoutPoint};
use crate::text::finding::Finding;

pub(super) fn notes(tally: &Tally, deletable: u64, setup: &Setup) -> Vec<Finding> {
    let what = match setup.skip_deletable {
        true => "left out",
        false => "executed",
    };
    let count = deletable;
    let lines = PathFinding::Deletable { count, what };
    let count = tally.look_ahead;
    let look_ahead = PathFinding::LookAhead { count };
    let words = tally.m.iter();
    let words = words.map(|(m, count)| format!("M{m}{} ({count})", tally.with_words(*m)));
    let words: Vec<String> = words.collect();
    let has_words = !words.is_empty();
    let blend = |(mm, line)| PathFinding::Blend { mm, line };
    let found = [
        without_point(tally, setup),
        (deletable > 0).then_some(lines),
        (tally.look_ahead > 0).then_some(look_ahead),
        tally.blend.map(blend),
        tally.rough_arcs.as_ref().map(rough_arcs),
        tally.other_mode.map(|line| PathFinding::OtherMode { line }),
        has_words.then_some(PathFinding::WithoutMotion { words }),
    ];
    found.into_iter().flatten().map(Finding::from).collect()
}

fn without_point(tally: &Tally, setup: &Setup) -> Option<PathFinding> {
    let (count, line) = (tally.without_point, tally.first_without_point);
    let meaning = match setup.without_point {
        WithoutPoint::Unit => "whole mm or inches (`X100` = 100 mm)",
        WithoutPoint::Increment => "least input increments (`X100` = 0.1 mm)",
    };
    let found = PathFinding::WithoutPoint { count, line, meaning };
    (count > 0).then_some(found)
}

fn rough_arcs(arcs: &RoughArcs) -> PathFinding {
    PathFinding::RoughArcs {
        usual_mm: USUAL_MISS_MM,
        count: arcs.count,
        most_mm: arcs.most_mm,
        line: arcs.line,
        allowed_mm: arcs.allowed_mm,
    }
}
