//! What `nonius` for Python asks of the program: everything else is in python/nonius.

/// Questions of `nonius batch` (JSON) and their answers.
#[pyo3::pymodule]
mod _core {
    use nonius::page::picture::{Mark, Panel, Picture, Scale};
    use nonius::page::{DisplayUnit, Ink, Locale, Texts};
    use pyo3::exceptions::PyValueError;
    use pyo3::{PyResult, Python, pyfunction};

    /// How a page looks that the program writes (CSS).
    #[pymodule_export]
    const STYLE: &str = include_str!("../../templates/page.css");

    /// The answer to a question, while other threads of the interpreter go on.
    #[pyfunction]
    fn ask(python: Python<'_>, question: &str) -> String {
        python.detach(|| nonius::cli::asked(question.as_bytes()).json())
    }

    /// Quantile of Student's distribution: what lies below it with this share of all cases.
    #[pyfunction]
    fn student(share: f64, degrees_of_freedom: f64) -> f64 {
        nonius::machine::separation::readings::student(share, Some(degrees_of_freedom))
    }

    /// A label with its unit, and both ends.
    type Axis = (String, f64, f64);
    /// What is drawn, and three numbers each time: from, to and height of bars; place and both ends of a band; place, height
    /// and nothing of a line or a limit.
    type Drawn = (String, Vec<(f64, f64, f64)>);

    /// A picture (SVG) of panels side by side: title, the axes across and up, what is drawn.
    #[pyfunction]
    fn picture(title: String, panels: Vec<(String, Axis, Axis, Vec<Drawn>)>) -> PyResult<String> {
        let scale = |(label, from, to): Axis| Scale::new(&label, from, to);
        let columns = panels.len();
        let mut drawn = Vec::new();
        for (title, across, up, marks) in panels {
            let marks = marks.into_iter().map(mark).collect::<PyResult<_>>()?;
            let (across, up) = (scale(across), scale(up));
            drawn.push(Some(Panel { title, across, up, marks, is_view: false }));
        }
        let texts =
            Texts::english().map_err(|problems| PyValueError::new_err(problems.render()))?;
        let (description, note) = (title.clone(), String::new());
        let picture = Picture { title, description, columns, panels: drawn, note };
        Ok(picture.svg(Locale { texts: &texts, shown: DisplayUnit::Metric }))
    }

    fn mark((kind, numbers): Drawn) -> PyResult<Mark> {
        let pairs = || numbers.iter().map(|(place, height, _)| (*place, *height)).collect();
        match kind.as_str() {
            "bars" => Ok(Mark::Bars(Ink::AsFound, numbers)),
            "band" => Ok(Mark::Band(Ink::AsFound, numbers)),
            "line" => Ok(Mark::Line(Ink::AsFound, pairs())),
            "limit" => Ok(Mark::Line(Ink::Limit, pairs())),
            _ => Err(PyValueError::new_err(format!("nothing is drawn as {kind}"))),
        }
    }
}
