//! The blocks of a Fanuc parameter file that concern the compensation.

use crate::control::controller::FanucFacts;

/// First and last number of the Fanuc parameters that pitch, straightness and backlash need, and
/// of those whose compensation is not emulated and must be seen.
const PARAMETERS: [(u32, u32); 15] = [
    (1006, 1006),
    (1240, 1240),
    (1851, 1852),
    (3602, 3602),
    (3605, 3605),
    (3620, 3627),
    (3666, 3671),
    (3676, 3677),
    (5711, 5716),
    (5721, 5726),
    (5731, 5784),
    (5861, 5874),
    (8135, 8135),
    (10800, 10814),
    (14985, 14988),
];

/// The blocks of a Fanuc read-out that concern the compensation, and how many were passed over.
///
/// shape  as long as the file, byte for byte; other blocks are blanks
pub fn fanuc(text: &str, facts: &FanucFacts) -> (String, usize) {
    let mut kept = String::with_capacity(text.len());
    let mut passed_over = 0;
    for block in text.split_inclusive(['\n', '\r', ';']) {
        match number(block) {
            Some((number, rest)) if !concerns(number, rest, facts) => {
                passed_over += 1;
                kept.extend(block.chars().flat_map(|c| {
                    let blank = if matches!(c, '\n' | '\r' | ';') {
                        c
                    } else {
                        ' '
                    };
                    std::iter::repeat_n(blank, c.len_utf8())
                }));
            }
            _ => kept.push_str(block),
        }
    }
    (kept, passed_over)
}

/// The number after `N`, and what follows it.
fn number(block: &str) -> Option<(u32, &str)> {
    let rest = block.trim_start().strip_prefix(['N', 'n'])?.trim_start();
    let digits = rest
        .find(|c: char| !c.is_ascii_digit())
        .unwrap_or(rest.len());
    Some((rest[..digits].parse().ok()?, rest[digits..].trim_start()))
}

fn concerns(number: u32, rest: &str, facts: &FanucFacts) -> bool {
    let identifier: String = rest
        .chars()
        .filter(|c| !c.is_whitespace())
        .take(2)
        .collect();
    let is_large = number >= facts.point_offset.value;
    match identifier.to_ascii_uppercase().as_str() {
        "Q0" => return true,
        "Q1" => {}
        _ if is_large => return true,
        _ => {}
    }
    let sets = facts.straightness_sets.value;
    let per_point = [
        facts.straightness_magnification_parameter.value,
        facts.straightness_start_parameter.value,
    ];
    PARAMETERS.iter().any(|(a, b)| (*a..=*b).contains(&number))
        || per_point
            .iter()
            .any(|first| (*first..*first + sets).contains(&number))
}
