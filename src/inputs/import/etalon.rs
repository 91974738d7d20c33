//! Etalon exchange format, variant "Vendor".
//!
//! ```text
//!   [C0Y]
//!   VALUE = 0.000012
//!   [EXX]
//!   Gridpoints = {
//!      0.0 0.0000
//!    100.0 0.0021
//!   } // end of EXX
//! ```

use crate::inputs::import::Reading;
use crate::inputs::import::components::{Parameter, assemble};
use crate::inputs::import::lines::{Line, lines};
use crate::inputs::import::stated::Stated;
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems, shown};

const AGAIN: &str = "the file is incomplete or damaged: export it again (variant `Vendor`)";

pub(super) fn read(source: &Source, stated: &Stated) -> Result<Reading, Problems> {
    let mut problems = Problems::none();
    let mut blocks = Blocks::default();
    for line in lines(source) {
        let line = line.before("//");
        if !line.is_blank() {
            blocks.take(&line, &mut problems);
        }
    }
    blocks.close(&mut problems);
    let sign = stated.required_sign(&mut problems);
    if let (Some(sign), true) = (sign, problems.is_empty()) {
        return assemble(&blocks.done, sign);
    }
    Err(problems)
}

/// Which of the two forms the values of a block have.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Form {
    Value,
    Grid,
}

#[derive(Default)]
struct Blocks {
    done: Vec<Parameter>,
    /// Between `Gridpoints = {` and `}`.
    inside: bool,
    /// How the values of the last block are given.
    form: Option<Form>,
}

impl Blocks {
    fn take(&mut self, line: &Line<'_>, problems: &mut Problems) {
        let text = line.text.trim();
        let compact: String = text.to_lowercase().split_whitespace().collect();
        if let Some(name) = text.strip_prefix('[').and_then(|t| t.strip_suffix(']')) {
            self.close(problems);
            self.form = None;
            self.done.push(Parameter {
                name: name.trim().to_uppercase(),
                place: line.place(),
                positions_mm: Vec::new(),
                values: Vec::new(),
            });
        } else if compact == "gridpoints={" && !self.inside && !self.done.is_empty() {
            self.inside = true;
            self.begin(Form::Grid, line, problems);
        } else if text == "}" && self.inside {
            self.inside = false;
        } else if self.inside {
            self.point(line, problems);
        } else if compact.starts_with("value=") && !self.done.is_empty() {
            self.begin(Form::Value, line, problems);
            self.value(line, problems);
        } else {
            problems.push_with(|| {
                Problem::new("expected `[NAME]`, `VALUE = …` or `Gridpoints = {`")
                    .at(line.place())
                    .help(AGAIN)
            });
        }
    }

    /// A block has one value or one grid.
    fn begin(&mut self, form: Form, line: &Line<'_>, problems: &mut Problems) {
        if self.form.replace(form).is_some() {
            let name = self.done.last().map_or("", |block| block.name.as_str());
            problems.push_with(|| {
                Problem::new(format!(
                    "`{}` has values already, expected one `VALUE` or one `Gridpoints` a block",
                    shown(name)
                ))
                .at(line.place())
                .help("which of the two is meant is not known: keep one of them")
            });
        }
    }

    fn point(&mut self, line: &Line<'_>, problems: &mut Problems) {
        let words = line.words(char::is_whitespace);
        let [argument, value] = words[..] else {
            problems.push_with(|| {
                Problem::new("expected an argument and a value, as in `100.0 0.0021`")
                    .at(line.place())
                    .help(AGAIN)
            });
            return;
        };
        let argument = argument.number("an argument", problems);
        let value = value.number("a value", problems);
        if let (Some(block), Some(argument), Some(value)) = (self.done.last_mut(), argument, value)
        {
            block.positions_mm.push(argument);
            block.values.push(value);
        }
    }

    fn value(&mut self, line: &Line<'_>, problems: &mut Problems) {
        let at = line.text.find('=').map_or(0, |at| at + 1);
        let word = line.part(at, line.text.len());
        if let (Some(block), Some(value)) = (self.done.last_mut(), word.number("a value", problems))
        {
            block.values.push(value);
        }
    }

    /// The block before must be complete.
    fn close(&mut self, problems: &mut Problems) {
        let Some(block) = self.done.last() else {
            return;
        };
        let name = &block.name;
        let message = if self.inside {
            format!("the grid of `{name}` is not closed by `}}`")
        } else if block.values.is_empty() && problems.is_empty() {
            format!("`{name}` has no value")
        } else {
            return;
        };
        problems.push(Problem::new(message).at(block.place.clone()).help(AGAIN));
        self.inside = false;
    }
}
