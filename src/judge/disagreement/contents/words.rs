//! Words that all controls share.

/// Names that are listed before the rest is only counted.
const MOST_NAMES: usize = 6;

/// Numbers of files closer than this are equal, in their own unit.
const EQUAL: f64 = 1e-9;

pub(super) fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= EQUAL
}

/// `a, b, c and 4 more`
pub(super) fn listed(names: &[String]) -> String {
    let shown = names.iter().take(MOST_NAMES).cloned().collect::<Vec<_>>();
    match names.len().saturating_sub(MOST_NAMES) {
        0 => shown.join(", "),
        rest => format!("{} and {rest} more", shown.join(", ")),
    }
}

/// Ascending numbers as `point 7` or `points 3, 1200 to 1205`.
pub(super) fn runs(numbers: &[u32]) -> String {
    let mut runs: Vec<(u32, u32)> = Vec::new();
    for number in numbers {
        match runs.last_mut() {
            Some((_, last)) if *last + 1 == *number => *last = *number,
            _ => runs.push((*number, *number)),
        }
    }
    let texts: Vec<String> = runs
        .iter()
        .map(|(first, last)| match first == last {
            true => first.to_string(),
            false => format!("{first} to {last}"),
        })
        .collect();
    let word = if numbers.len() == 1 {
        "point"
    } else {
        "points"
    };
    format!("{word} {}", listed(&texts))
}

/// `it` or `them`, for as many as there are.
pub(super) fn it(count: usize) -> &'static str {
    if count == 1 { "it" } else { "them" }
}
