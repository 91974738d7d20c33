//! Tables of a control whose profile declares how they are written and read back.
//!
//! Positions and values are in the units that the profile states, in the order of the file.

/// One point of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Where.
    pub position: f64,
    /// What stands there, of a table with two columns while the base axis moves in +.
    pub forward: f64,
    /// Of a table with two columns what stands there while it moves in −.
    pub reverse: Option<f64>,
}

/// What one axis gets because another one, or itself, stands somewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct DeclaredTable {
    /// The axis that is looked up.
    pub base: String,
    /// The axis that is corrected.
    pub output: String,
    /// The points, in the order of the file.
    pub points: Vec<Point>,
}

impl DeclaredTable {
    /// Whether an axis corrects itself.
    pub(crate) fn is_own(&self) -> bool {
        self.base.eq_ignore_ascii_case(&self.output)
    }

    /// Whether two tables are for the same axes.
    pub(crate) fn is_for(&self, base: &str, output: &str) -> bool {
        self.base.eq_ignore_ascii_case(base) && self.output.eq_ignore_ascii_case(output)
    }

    /// `table of X`, or `table of Y by X`.
    pub(crate) fn name(&self) -> String {
        name(&self.base, &self.output)
    }
}

/// The same of axes.
pub(crate) fn name(base: &str, output: &str) -> String {
    match base.eq_ignore_ascii_case(output) {
        true => format!("table of {output}"),
        false => format!("table of {output} by {base}"),
    }
}

/// All tables.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DeclaredTables {
    /// Ascending by corrected axis, then by the axis that is looked up.
    pub tables: Vec<DeclaredTable>,
}

impl DeclaredTables {
    /// Tables in any order.
    pub(crate) fn of(mut tables: Vec<DeclaredTable>) -> DeclaredTables {
        tables.sort_by(|a, b| (&a.output, &a.base).cmp(&(&b.output, &b.base)));
        DeclaredTables { tables }
    }
}
