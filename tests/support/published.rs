//! Tables of docs/accuracy.md that simulations write, and how much of a simulation is run.

use std::path::Path;

/// Whether whole simulations are asked for (`NONIUS_SIMULATIONS=all`).
pub(crate) fn is_whole() -> bool {
    std::env::var("NONIUS_SIMULATIONS").is_ok_and(|asked| asked == "all")
}

/// So many trials of `all`: a twentieth, unless all are asked for.
pub(crate) fn share(all: u64) -> u64 {
    if is_whole() { all } else { all / 20 }
}

/// Compares a table with that between the markers `name` of `tests/<file>.rs`; with `NONIUS_UPDATE`
/// in the environment writes it there.
pub(crate) fn published(name: &str, file: &str, table: &str) {
    let begin = format!("<!-- {name}: written by tests/studies/{file}.rs -->\n");
    let end = format!("\n<!-- {name}: end -->");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/accuracy.md");
    let page = std::fs::read_to_string(&path).unwrap().replace('\r', "");
    let (head, rest) = page.split_once(&begin).expect("the page holds the marker");
    let (old, tail) = rest.split_once(&end).expect("the page holds the end marker");
    let table = table.trim_end();
    if std::env::var_os("NONIUS_UPDATE").is_some() {
        std::fs::write(&path, format!("{head}{begin}{table}{end}{tail}")).unwrap();
        return;
    }
    assert!(
        old == table,
        "docs/accuracy.md differs; if the new table is meant, run with NONIUS_UPDATE=1\n{table}"
    );
}
