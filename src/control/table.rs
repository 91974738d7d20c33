//! What lies in a control's memory after its files are loaded.
//!
//! This is the only thing that the writing side (`compensation`, `emit`) and the reading side
//! (`read`) have in common. Values stand here exactly as in the file: in the
//! control's own unit, sense and numbering. A point that no file writes is missing (`None`).

pub mod fanuc;
pub mod isg;
pub mod siemens;

use crate::quantity::ErrorTerm;
use std::any::Any;

/// The memory of one of the format families.
#[derive(Clone, Debug, PartialEq)]
pub enum Tables {
    /// Siemens ENC_COMP and CEC tables.
    Siemens(siemens::SiemensTables),
    /// Fanuc parameters and points.
    Fanuc(fanuc::FanucMemory),
    /// Tables whose points stand one by one, of LinuxCNC, of a control whose profile declares its files, and the generic ones.
    Listed(ListedTables),
    /// Parameters of an ISG volumetric compensation.
    Isg(isg::IsgTables),
}

impl Tables {
    /// The tables of one family; those of another hold none of them.
    pub(crate) fn own<T: Memory>(&self) -> &T {
        let own: &dyn Any = match self {
            Tables::Siemens(own) => own,
            Tables::Fanuc(own) => own,
            Tables::Listed(own) => own,
            Tables::Isg(own) => own,
        };
        own.downcast_ref().unwrap_or(T::EMPTY)
    }

    /// Loads the tables of a file over those that are held: what stands at a place that the file writes is replaced,
    /// everything else stays. A volumetric compensation is one table.
    pub(crate) fn load(&mut self, file: Tables) {
        match (self, file) {
            (Tables::Siemens(held), Tables::Siemens(file)) => {
                held.tables.retain(|own| file.at(&own.place).is_none());
                held.tables.extend(file.tables);
            }
            (Tables::Fanuc(held), Tables::Fanuc(file)) => {
                held.parameters.extend(file.parameters);
                held.points.extend(file.points);
            }
            (Tables::Listed(held), Tables::Listed(file)) => {
                let is_new = |own: &ListedTable| file.at(&own.base, &own.output).is_some();
                held.tables.retain(|own| !is_new(own));
                held.tables.extend(file.tables);
            }
            (held, file) => *held = file,
        }
    }
}

/// The memory of a format family.
pub(crate) trait Memory: Any {
    /// One that holds nothing.
    const EMPTY: &'static Self;
}

impl Memory for siemens::SiemensTables {
    const EMPTY: &'static Self = &siemens::SiemensTables::NONE;
}

impl Memory for fanuc::FanucMemory {
    const EMPTY: &'static Self = &fanuc::FanucMemory::NONE;
}

impl Memory for isg::IsgTables {
    const EMPTY: &'static Self = &isg::IsgTables::NONE;
}

// Tables whose points stand one by one, with a column for both directions of travel or one for each.
//
// Positions and values are in the units of the file, in its order ([`crate::control::controller::Form`]).

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
pub struct ListedTable {
    /// Which error it is for, where the file says it.
    pub term: Option<ErrorTerm>,
    /// The axis that is looked up.
    pub base: String,
    /// The axis that is corrected.
    pub output: String,
    /// The points, in the order of the file.
    pub points: Vec<Point>,
}

impl ListedTable {
    /// Whether an axis corrects itself.
    pub(crate) fn is_own(&self) -> bool {
        self.base.eq_ignore_ascii_case(&self.output)
    }

    /// Whether two tables are for the same axes.
    pub(crate) fn is_for(&self, base: &str, output: &str) -> bool {
        self.base.eq_ignore_ascii_case(base) && self.output.eq_ignore_ascii_case(output)
    }

    /// Whether it has a column for each direction.
    pub(crate) fn has_two(&self) -> bool {
        self.points.iter().any(|point| point.reverse.is_some())
    }

    /// A factor, which stands for a table of one point.
    pub(crate) fn of_factor([base, output]: [&str; 2], factor: f64) -> ListedTable {
        let points = vec![Point { position: 0.0, forward: factor, reverse: None }];
        ListedTable { term: None, base: base.to_string(), output: output.to_string(), points }
    }

    /// The factor that it stands for.
    pub(crate) fn factor(&self) -> f64 {
        self.points.first().map_or(0.0, |point| point.forward)
    }

    /// Whether all that stands in it is 0.
    pub(crate) fn is_zero(&self) -> bool {
        let mut values = self.points.iter().flat_map(|point| [Some(point.forward), point.reverse]);
        values.all(|value| value.is_none_or(|value| value.abs() <= 0.0))
    }

    /// `table of X`, `table of Y by X`, or `EYX (Y while X moves)`.
    pub(crate) fn name(&self) -> String {
        match self.term {
            Some(term) => format!("{term} ({} while {} moves)", self.output, self.base),
            None => name(&self.base, &self.output),
        }
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
pub struct ListedTables {
    /// Ascending by corrected axis, then by the axis that is looked up.
    pub tables: Vec<ListedTable>,
    /// The name of their set, where the control loads one of several.
    pub set: Option<String>,
}

impl ListedTables {
    /// Tables in any order.
    pub(crate) fn of(mut tables: Vec<ListedTable>) -> ListedTables {
        let place = |name: &String| (name.len(), name.clone()); // 2 stands before 10
        tables.sort_by_cached_key(|own| (place(&own.output), place(&own.base)));
        ListedTables { tables, set: None }
    }

    /// The table of axes.
    pub(crate) fn at(&self, base: &str, output: &str) -> Option<&ListedTable> {
        self.tables.iter().find(|table| table.is_for(base, output))
    }

    /// The factor of axes; 0 = there is none.
    pub(crate) fn factor(&self, base: &str, output: &str) -> f64 {
        self.at(base, output).map_or(0.0, ListedTable::factor)
    }

    /// No table.
    pub(crate) const NONE: ListedTables = ListedTables { tables: Vec::new(), set: None };
}

impl Memory for ListedTables {
    const EMPTY: &'static Self = &ListedTables::NONE;
}
