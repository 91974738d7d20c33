//! ENC_COMP and CEC tables of the kit, zero but for the bump.

use super::Bump;
use crate::axis::ErrorTerm;
use crate::compensation::siemens::values;
use crate::controller::{SiemensFacts, TableSign};
use crate::plan::{Plan, Task, axis_pairs};
use crate::table::siemens::SiemensTables;
use crate::units::Deviation;

/// All ENC_COMP tables of the kit; every physical axis of the term has the bump, so that the two
/// sides of a gantry move alike.
pub(super) fn lec(
    task: Task<'_>,
    plan: &Plan,
    facts: &SiemensFacts,
    kit: &SiemensTables,
    (term, bump): (ErrorTerm, &Bump),
) -> SiemensTables {
    let pairs = axis_pairs(&plan.names, term);
    let mut lec = kit.lec.clone();
    for table in &mut lec {
        let has_bump = pairs.iter().any(|(_, output)| *output == table.axis);
        let sign = facts.lec_sign.value;
        table.values = contents(task, facts, sign, bump, has_bump, table.values.len());
    }
    SiemensTables {
        lec,
        cec: Vec::new(),
    }
}

/// All CEC tables of the kit; those of the term have the bump, in both directions.
pub(super) fn cec(
    task: Task<'_>,
    plan: &Plan,
    facts: &SiemensFacts,
    kit: &SiemensTables,
    (term, bump): (ErrorTerm, &Bump),
) -> SiemensTables {
    let pairs = axis_pairs(&plan.names, term);
    let mut cec = kit.cec.clone();
    for table in &mut cec {
        let own = (table.input_axis.as_str(), table.output_axis.as_str());
        let has_bump = pairs.contains(&own);
        let sign = facts.cec_sign.value;
        table.values = contents(task, facts, sign, bump, has_bump, table.values.len());
    }
    SiemensTables {
        lec: Vec::new(),
        cec,
    }
}

fn contents(
    task: Task<'_>,
    facts: &SiemensFacts,
    sign: TableSign,
    bump: &Bump,
    has_bump: bool,
    count: usize,
) -> Vec<Option<f64>> {
    let deviations = if has_bump {
        bump.deviations()
    } else {
        vec![Deviation::ZERO; count]
    };
    values(task, facts, &deviations, sign)
}
