//! Whether the work of a run grows with its input and not with its square: the steps (edges taken) of runs on inputs of
//! the most lines that are read, of a seventh and of a forty-ninth.

use crate::bundle::Bundle;
use crate::{commands, coverage};
use std::path::Path;

/// Steps grow with this power of the lines at most.
const STEEPEST: f64 = 1.15;

/// A command, the largest number of lines that it reads, and its files for a number of lines.
type Case = (&'static str, usize, fn(usize) -> Vec<(&'static str, String)>);

const CASES: [Case; 6] = [
    (
        "import list.txt --form form.csv --columns #1=displacement_mm --captures cumulative -o out.csv",
        49_000,
        |count| vec![("form.csv", form(count)), ("list.txt", lines(count, |n| n.to_string()))],
    ),
    (
        "import list.txt --form form.csv --columns #1=displacement_mm --captures cumulative -o missing.csv",
        49_000,
        |count| vec![("form.csv", form(count)), ("list.txt", lines(count - 1, |n| n.to_string()))],
    ),
    ("report errors.csv -o page.html", 49_000, |count| {
        vec![("errors.csv", lines(count, |n| format!("# doubt: number {n}")) + ERRORS)]
    }),
    ("report errors.csv -o notes.html", 49_000, |count| {
        vec![("errors.csv", lines(count, |n| format!("# note: number {n}")) + ERRORS)]
    }),
    ("generate job.toml -o kit", 17_000, |count| {
        vec![("job.toml", lines(count, |n| format!("k{n} = {n}")))]
    }),
    // One line of up to 60 kB with a complaint every dozen bytes.
    ("generate job.toml -o commas", 49_000, |count| {
        let commas = lines(count / 12, |_| ", y = 300.0,".to_string()).replace('\n', "");
        vec![(
            "job.toml",
            format!("[measurement.step_diagonal]\nsize_mm = {{ x = 1.0{commas} }}\n"),
        )]
    }),
];

const ERRORS: &str = "axis,position_mm,ex_um\nx,0,0\nx,100,5\n";

fn lines(count: usize, line: impl Fn(usize) -> String) -> String {
    (0..count).map(|number| line(number) + "\n").collect()
}

fn form(count: usize) -> String {
    "target_mm,run,direction,deviation_um\n".to_string() + &lines(count, |n| format!("{n},1,+,"))
}

/// Runs all cases in a folder and prints what they take; whether none grows too fast, and nothing else is wrong.
pub fn judge(place: &Path) -> bool {
    if coverage::edges() == 0 {
        println!("the compiler counts no edges: nothing is compared");
        return false;
    }
    let job = include_str!("../../fixtures/nine_errors_900/generic.toml");
    let mut is_good = true;
    for (command, most, files) in CASES {
        let taken = [most / 49, most / 7, most].map(|count| {
            let mut bundle = Bundle(vec![("command".to_string(), command.into())]);
            bundle.0.extend(
                files(count).into_iter().map(|(name, text)| (name.to_string(), text.into())),
            );
            if bundle.file("job.toml").is_none() {
                bundle.0.push(("job.toml".to_string(), job.into()));
            }
            let ran = commands::run(place, &bundle.bytes());
            if let Some(wrong) = ran.wrong {
                println!("{command}, {count} lines: {wrong}");
                is_good = false;
            }
            (count as f64, ran.steps as f64)
        });
        for (less, more) in taken.iter().zip(&taken[1..]) {
            let power = (more.1 / less.1).ln() / (more.0 / less.0).ln();
            println!("{power:5.2}  {:>11} steps for {} lines: {command}", more.1, more.0);
            is_good &= power <= STEEPEST;
        }
    }
    is_good
}
