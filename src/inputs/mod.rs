//! The user's files: job, error table, readings, files of other makers, part programs.

pub mod error_table;
pub mod findings;
pub mod import;
pub mod job;
pub mod kind;
pub mod readings;
mod refusals;
mod table;
pub mod target_runs;

use crate::text::{Place, Problem, Problems};
use part_program::Refused;

// What is wrong with a part program, as problems of its file. The crate `part_program` reads it.

/// The problems of a program, in the order they were found.
pub fn problems(file: &str, refused: Vec<Refused>) -> Problems {
    let mut problems = Problems::none();
    for Refused { message, help, place } in refused {
        let mut problem = Problem::new(message);
        problem.help = help;
        if let Some(part) = place {
            let (start, end) = part.span;
            let place = Place::in_text(file, &part.text, start, end);
            problem = problem.at(Place { line: part.line, ..place });
        }
        problems.push(problem);
    }
    problems
}
