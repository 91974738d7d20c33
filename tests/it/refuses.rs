//! What the program refuses, and in which words: the cases of `fixtures/cases/refuses`.
//!
//! The real program runs in a fresh directory that holds the inputs of the case only. It must end
//! with status 2, say exactly what the case expects, and leave the directory as it was.
//! `NONIUS_UPDATE=1 cargo test --test refuses` rewrites the expectations (fixtures/cases/README.md).

use crate::support::refusals;
use crate::support::refusals::Case;
use crate::support::run;
use crate::support::tree;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// A search that finds nothing must not pass.
const LEAST_CASES: usize = 500;

fn fixtures() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures"))
}

#[test]
fn every_refusal_says_what_is_wrong_and_writes_nothing() {
    let (mut failures, mut count) = (Vec::new(), 0);
    for path in refusals::pages(fixtures()) {
        let page = fs::read_to_string(&path).expect("it is text");
        let cases = refusals::cases(fixtures(), &page);
        count += cases.len();
        let said: Vec<String> = cases.iter().map(said).collect();
        if std::env::var_os("NONIUS_UPDATE").is_some() {
            let written = refusals::with_expectations(&page, &said);
            if written != page {
                fs::write(&path, written).expect("the page can be written");
            }
        } else {
            failures.extend(cases.iter().zip(&said).filter_map(differs));
        }
    }
    assert!(count >= LEAST_CASES, "only {count} cases found");
    assert!(
        failures.is_empty(),
        "{} of {count} cases differ; if the new words are meant, run with NONIUS_UPDATE=1\n\n{}",
        failures.len(),
        failures.join("\n\n")
    );
}

fn differs((case, said): (&Case, &String)) -> Option<String> {
    let (name, expected) = (&case.name, &case.expected);
    (expected != said).then(|| format!("{name}:\n--- expected\n{expected}--- got\n{said}"))
}

/// Exit status, standard error, then standard output of a case, which writes nothing.
fn said(case: &Case) -> String {
    let place = tempfile::tempdir().expect("a temporary directory can be made");
    case.lay_out(place.path());
    let before = tree::tree(place.path());
    let output = run::nonius(place.path(), &case.command);
    assert_eq!(before, tree::tree(place.path()), "{}: written", case.name);
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("the program prints UTF-8");
    let told = text(output.stderr) + &text(output.stdout);
    let told = told.replace('\r', "").replace("nonius.exe", "nonius");
    assert_eq!(output.status.code(), Some(2), "{}: {told}", case.name);
    format!("exit status 2\n{told}")
}

/// A name is how a case is found again.
#[test]
fn every_case_has_a_name_of_its_own() {
    let mut times: BTreeMap<String, usize> = BTreeMap::new();
    for case in refusals::all(fixtures()) {
        *times.entry(case.name).or_default() += 1;
    }
    times.retain(|_, times| *times > 1);
    assert!(times.is_empty(), "{times:?}");
}

/// What `NONIUS_UPDATE=1` writes of expectations that hold is the file as it was.
#[test]
fn expectations_are_written_as_they_stand() {
    for path in refusals::pages(fixtures()) {
        let page = fs::read_to_string(&path).expect("it is text");
        let page = page.replace('\r', "");
        let cases = refusals::cases(fixtures(), &page);
        let said: Vec<String> = cases.into_iter().map(|case| case.expected).collect();
        assert_eq!(refusals::with_expectations(&page, &said), page);
    }
}

#[test]
fn lines_are_replaced_where_they_stand_once() {
    let page = "\n== a\n@ b.csv CR LF\n+ 1\n+ 2\n+ 1\n@ b.csv\n  2\n- 1\n+ \\u{202e}\n> c\n>\n";
    let case = refusals::cases(fixtures(), page).remove(0);
    assert_eq!(case.files["b.csv"], "1\r\n2\r\n\u{202e}\r\n".as_bytes());
    assert_eq!(case.expected, "c\n\n");
    assert_eq!(case.command, "generate job.toml -o kit");
}

#[test]
#[should_panic(expected = "times that these lines are found")]
fn lines_that_stand_twice_are_not_replaced() {
    refusals::cases(fixtures(), "\n== a\n@ b.csv\n+ 1\n+ 1\n@ b.csv\n- 1\n> c\n");
}
