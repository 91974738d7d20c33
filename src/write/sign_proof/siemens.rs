//! ENC_COMP and CEC tables of the kit, zero but for the bump.

use super::Bump;
use crate::control::controller::{Mechanism, SiemensFacts, TableSign};
use crate::control::table::siemens::SiemensTables;
use crate::quantity::axis::ErrorTerm;
use crate::quantity::units::Deviation;
use crate::write::compensation::siemens::values;
use crate::write::plan::{Plan, Task, axis_pairs};

/// All tables of the kit of one mechanism. Every physical axis of the term has the bump, so that
/// the two sides of a gantry move alike; CEC tables of the term have it in both directions.
pub(super) fn tables(
    task: Task<'_>,
    plan: &Plan,
    facts: &SiemensFacts,
    kit: &SiemensTables,
    mechanism: Mechanism,
    (term, bump): (ErrorTerm, &Bump),
) -> SiemensTables {
    let pairs = axis_pairs(&plan.names, term);
    let contents = |pair: (&str, &str), sign: TableSign, count: usize| {
        let zero = || vec![Deviation::ZERO; count];
        let has_bump = pairs.contains(&pair);
        let deviations = if has_bump { bump.deviations() } else { zero() };
        values(task, facts, &deviations, sign)
    };
    let mut tables = SiemensTables::default();
    if mechanism == Mechanism::EncComp {
        tables.lec.clone_from(&kit.lec);
    } else {
        tables.cec.clone_from(&kit.cec);
    }
    for table in &mut tables.lec {
        let pair = (table.axis.as_str(), table.axis.as_str());
        table.values = contents(pair, facts.lec_sign.value, table.values.len());
    }
    for table in &mut tables.cec {
        let pair = (table.input_axis.as_str(), table.output_axis.as_str());
        table.values = contents(pair, facts.cec_sign.value, table.values.len());
    }
    tables
}
