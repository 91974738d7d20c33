//! What the program refuses, and in which words: the cases of `fixtures/cases/refuses`.
//!
//! The real program runs in a fresh directory that holds the inputs of the case only. It must end
//! with status 2, say exactly what the case expects, and leave the directory as it was.
//! `NONIUS_UPDATE=1 cargo test --test it refuses` rewrites the expectations (fixtures/cases/README.md).

use crate::support::refusals::{self, Case};
use crate::support::{Entry, Visit, fixtures, in_parallel, lay, program};
use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

fn pages() -> Vec<(PathBuf, String, Vec<Case>)> {
    let read = |path: PathBuf| {
        let page = fs::read_to_string(&path).unwrap().replace('\r', "");
        let cases = refusals::cases(&fixtures(""), &page);
        (path, page, cases)
    };
    refusals::pages(&fixtures("")).into_iter().map(read).collect()
}

#[test]
fn every_refusal_says_what_is_wrong_and_writes_nothing() {
    let pages = pages();
    let cases: Vec<&Case> = pages.iter().flat_map(|(_, _, cases)| cases).collect();
    assert!(cases.len() >= 500, "only {} cases found", cases.len());
    let told = in_parallel(&cases, |case| said(case));
    if std::env::var_os("NONIUS_UPDATE").is_some() {
        let mut told = told.into_iter();
        for (path, page, cases) in &pages {
            let said: Vec<String> = told.by_ref().take(cases.len()).collect();
            let written = refusals::with_expectations(page, &said);
            if written != *page {
                fs::write(path, written).unwrap();
            }
        }
        return;
    }
    let differs = |(case, said): (&&Case, &String)| {
        let (name, expected) = (&case.name, &case.expected);
        (expected != said).then(|| format!("{name}:\n--- expected\n{expected}--- got\n{said}"))
    };
    let failures: Vec<String> = cases.iter().zip(&told).filter_map(differs).collect();
    let (count, all, failures) = (failures.len(), cases.len(), failures.join("\n\n"));
    assert!(count == 0, "{count} of {all} cases differ; NONIUS_UPDATE=1 writes them\n\n{failures}");
}

/// Exit status, standard error, then standard output of a case, which writes nothing.
fn said(case: &Case) -> String {
    let visit = Visit::new();
    lay(&case.files, visit.folder());
    let before = visit.files();
    let output = program(visit.folder(), &case.command).output().unwrap();
    assert_eq!(before, visit.files(), "{}: written", case.name);
    let told = String::from_utf8([output.stderr, output.stdout].concat()).unwrap();
    let told = told.replace('\r', "").replace("nonius.exe", "nonius");
    assert_eq!(output.status.code(), Some(2), "{}: {told}", case.name);
    format!("exit status 2\n{told}")
}

/// A name is how a case is found again; where its expectation holds `NONIUS_UPDATE=1` writes the file as it was.
#[test]
fn every_case_has_a_name_of_its_own_and_its_expectation_is_written_as_it_stands() {
    let mut times: BTreeMap<String, usize> = BTreeMap::new();
    for (_, page, cases) in pages() {
        let said: Vec<String> = cases.iter().map(|case| case.expected.clone()).collect();
        assert_eq!(refusals::with_expectations(&page, &said), page);
        cases.into_iter().for_each(|case| *times.entry(case.name).or_default() += 1);
    }
    times.retain(|_, times| *times > 1);
    assert!(times.is_empty(), "{times:?}");
}

#[test]
fn lines_are_replaced_where_they_stand_once() {
    let page = "\n== a\n@ b.csv CR LF\n+ 1\n+ 2\n+ 1\n@ b.csv\n  2\n- 1\n+ \\u{202e}\n> c\n>\n";
    let case = refusals::cases(&fixtures(""), page).remove(0);
    assert_eq!(case.files["b.csv"], Entry::File("1\r\n2\r\n\u{202e}\r\n".into()));
    assert_eq!(case.expected, "c\n\n");
    assert_eq!(case.command, "generate job.toml -o kit");
}

#[test]
#[should_panic(expected = "times that these lines are found")]
fn lines_that_stand_twice_are_not_replaced() {
    refusals::cases(&fixtures(""), "\n== a\n@ b.csv\n+ 1\n+ 1\n@ b.csv\n- 1\n> c\n");
}
