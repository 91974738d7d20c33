//! Numbers and lists in the text output.

/// More degrees of freedom than these need no exact number: k is 2.00.
const MANY: f64 = 1000.0;

/// The sentence of contract §1 that stands wherever φ stands.
pub(super) const SQUARENESS_SIGN: &str = "positive = the angle between the two positive axis directions is less than 90° (ISO 230-1: EC0Y = -xy, EB0Z = +xz, EA0Z = -yz)";

/// Three decimals, never −0.
pub(super) fn three(value: f64) -> String {
    format!("{:.3}", (value * 1000.0).round() / 1000.0 + 0.0)
}

/// The same with its sign.
pub(super) fn signed(value: f64) -> String {
    format!("{:+.3}", (value * 1000.0).round() / 1000.0 + 0.0)
}

/// Three decimals, or a dash where there is nothing.
pub(super) fn shown(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_string(), three)
}

/// U with its coverage factor; one that is known never reads 0 unless it is.
pub(super) fn expanded(expanded: Option<f64>) -> String {
    match expanded {
        None => "not known".to_string(),
        Some(expanded) if expanded > 0.0 && expanded < 0.0005 => "< 0.001".to_string(),
        Some(expanded) => three(expanded),
    }
}

/// Effective degrees of freedom of a known U; `None` inside = unlimited.
pub(super) fn freedom(known: Option<Option<f64>>) -> String {
    match known {
        None => "-".to_string(),
        Some(None) => "unlimited".to_string(),
        Some(Some(freedom)) if freedom > MANY => format!("> {MANY:.0}"),
        Some(Some(freedom)) => format!("{freedom:.0}"),
    }
}

/// What speaks against a result: the first thing to read.
pub(super) fn doubtful(doubts: &[String]) -> String {
    list("DOUBTFUL, so the answer is no:", doubts)
}

/// A heading with a line for each entry; nothing without entries.
pub(super) fn list(heading: &str, lines: &[String]) -> String {
    if lines.is_empty() {
        return String::new();
    }
    let lines: Vec<String> = lines.iter().map(|line| format!("- {line}")).collect();
    format!("{heading}\n{}", lines.join("\n"))
}

/// What is not determined, and below it how to determine it.
pub(super) fn undetermined(words: &[String], advice: &[String]) -> String {
    if words.is_empty() {
        return String::new();
    }
    let mut lines = vec!["NOT DETERMINED by these readings, and left out:".to_string()];
    lines.extend(words.iter().map(|words| format!("- {words}")));
    lines.extend(advice.iter().map(|advice| format!("    {advice}")));
    lines.join("\n")
}
