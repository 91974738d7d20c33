//! How much of a simulation is run, what so many trials can decide, and the tables of
//! docs/accuracy.md that simulations write.
use statrs::distribution::{Binomial, DiscreteCDF};
use std::ops::RangeInclusive;

/// What `NONIUS_SIMULATIONS` asks for; without it a hundredth.
#[derive(Clone, Copy, PartialEq)]
enum Extent {
    Hundredth,
    Twentieth,
    All,
}

fn extent() -> Extent {
    match std::env::var("NONIUS_SIMULATIONS").as_deref() {
        Err(_) | Ok("") => Extent::Hundredth,
        Ok("twentieth") => Extent::Twentieth,
        Ok("all") => Extent::All,
        Ok(other) => panic!("NONIUS_SIMULATIONS is twentieth or all, not {other}"),
    }
}

pub(crate) fn is_whole() -> bool {
    extent() == Extent::All
}

/// A number of trials: the first in plain `cargo test`, the second where more is asked for.
pub(crate) fn short_or<T>(short: T, long: T) -> T {
    if extent() == Extent::Hundredth { short } else { long }
}

/// So many trials of `all`: a hundredth, but `least` at least; a twentieth or all where asked for.
pub(crate) fn share(all: u64, least: u64) -> u64 {
    match extent() {
        Extent::Hundredth => least.max(all / 100),
        Extent::Twentieth => all / 20,
        Extent::All => all,
    }
}

/// Whether a share is within `strict`; in plain `cargo test`, whether its few trials may come from within `stated`.
pub(crate) fn is_held(
    share: f64,
    trials: usize,
    stated: RangeInclusive<f64>,
    strict: RangeInclusive<f64>,
) -> bool {
    short_or(may_be(share, trials, stated), strict.contains(&share))
}

/// Whether no binomial test at 10⁻⁴ refutes that a trial succeeds with a probability within `stated`.
pub(crate) fn may_be(share: f64, trials: usize, stated: RangeInclusive<f64>) -> bool {
    let (count, trials) = (share * trials as f64, trials as u64);
    let [low, high] = [stated.start(), stated.end()].map(|p| Binomial::new(*p, trials).unwrap());
    // A mean over several figures need not be a whole count.
    let (above, below) = ((count - 1e-9).ceil() as u64, (count + 1e-9).floor() as u64);
    let as_many = if below == 0 { 1.0 } else { high.sf(below - 1) };
    low.cdf(above) >= 1e-4 && as_many >= 1e-4
}

/// What a share of 95.46 % of so many trials may scatter by, three standard deviations; nothing where all are run.
pub(crate) fn scatter(trials: usize) -> f64 {
    if is_whole() { 0.0 } else { 3.0 * (0.0454 * 0.9546 / trials as f64).sqrt() }
}

/// A table: the first column to the left, the others to the right.
pub(crate) fn markdown(head: &str, rows: impl IntoIterator<Item = String>) -> String {
    let columns = " ---: |".repeat(head.matches(" | ").count());
    let rows: String = rows.into_iter().map(|row| format!("\n| {row} |")).collect();
    format!("| {head} |\n| --- |{columns}{rows}")
}

/// Compares a table with that between the markers `name` of `tests/studies/<file>.rs`; with `NONIUS_UPDATE` writes it there.
pub(crate) fn published(name: &str, file: &str, table: &str) {
    let begin = format!("<!-- {name}: written by tests/studies/{file}.rs -->\n");
    let end = format!("\n<!-- {name}: end -->");
    stands_between("docs/accuracy.md", &begin, &end, table.trim_end());
}

/// The same, where the whole simulation is run.
pub(crate) fn published_if_whole(name: &str, file: &str, table: &str) {
    if is_whole() {
        published(name, file, table);
    }
}

/// Compares a table with that between two markers of a page, likewise.
pub(crate) fn stands_between(name: &str, begin: &str, end: &str, table: &str) {
    let page = super::page(name);
    let (head, rest) = page.split_once(begin).expect("the page holds the marker");
    let (old, tail) = rest.split_once(end).expect("the page holds the end marker");
    if std::env::var_os("NONIUS_UPDATE").is_some() {
        let page = format!("{head}{begin}{table}{end}{tail}");
        return std::fs::write(super::fixtures(&format!("../{name}")), page).unwrap();
    }
    let update = "if the new table is meant, run with NONIUS_UPDATE=1";
    assert!(old == table, "{name} differs; {update}\n{table}");
}
