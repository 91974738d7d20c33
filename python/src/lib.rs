//! What `nonius` for Python asks of the program: everything else is in python/nonius.

/// Questions of `nonius batch` (JSON) and their answers.
#[pyo3::pymodule]
mod _core {
    use pyo3::{Python, pyfunction};

    /// The answer to a question, while other threads of the interpreter go on.
    #[pyfunction]
    fn ask(python: Python<'_>, question: &str) -> String {
        python.detach(|| nonius::cli::asked(question).line)
    }

    /// k with which U = k·u holds the true value in 95.45 % of all cases (Student; GUM, annex G).
    #[pyfunction]
    fn coverage_factor(degrees_of_freedom: f64) -> f64 {
        nonius::machine::separation::noise::coverage_factor(Some(degrees_of_freedom))
    }
}
