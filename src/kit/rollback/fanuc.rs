//! What a kit changes on a Fanuc control: parameters and points, 3605, 1851 and 1852.

use super::{Before, Old, Unknown};
use crate::control::table::Tables;
use crate::control::table::fanuc::{FanucMemory, ParameterKey, ParameterValue};
use crate::kit::rollback::before::ChangedBy;
use crate::quantity::axis::Axis;
use std::collections::BTreeMap;

/// The magnification of the pitch points of an axis, and the moving axes of straightness sets: what
/// a person sets to 0 to switch an old compensation off.
const OFF_BY: [std::ops::RangeInclusive<u32>; 2] = [3623..=3623, 5711..=5716];

pub(super) fn old(
    before: &Before<'_>,
    kit: &FanucMemory,
    held: &FanucMemory,
) -> Result<Old, Vec<String>> {
    let mut old = FanucMemory::default();
    let mut missing = Vec::new();
    for key in kit.parameters.keys() {
        match held.parameters.get(key) {
            Some(value) => {
                old.parameters.insert(*key, *value);
            }
            None => missing.push(format!("parameter {}", name(*key))),
        }
    }
    for point in kit.points.keys() {
        match held.points.get(point) {
            Some(value) => {
                old.points.insert(*point, *value);
            }
            None => missing.push(format!("point {point}")),
        }
    }
    if !missing.is_empty() {
        return Err(missing);
    }
    let mut lacking = Vec::new();
    for (key, by) in changed_by_hand(before, kit) {
        match held.parameters.get(&key) {
            Some(value) => {
                old.parameters.insert(key, *value);
            }
            None if by == ChangedBy::Nobody => {}
            None => lacking.push((key, by)),
        }
    }
    Ok(Old {
        tables: Tables::Fanuc(old),
        data: Vec::new(),
        unknown: named(&lacking),
        stays: Vec::new(),
    })
}

/// One name for a parameter of several axes: `3605 of axis 1, 2`.
fn named(lacking: &[(ParameterKey, ChangedBy)]) -> Vec<Unknown> {
    let mut groups: BTreeMap<u32, Vec<String>> = BTreeMap::new();
    for (key, _) in lacking {
        let axes = groups.entry(key.number).or_default();
        axes.extend(key.axis.map(|axis| axis.to_string()));
    }
    let named = |(number, axes): (u32, Vec<String>)| Unknown {
        what: match axes.as_slice() {
            [] => number.to_string(),
            axes => format!("{number} of axis {}", axes.join(", ")),
        },
        by: ChangedBy::Precondition,
    };
    groups.into_iter().map(named).collect()
}

fn name(key: ParameterKey) -> String {
    let axis = key.axis.map(|axis| format!(" of axis {axis}"));
    format!("{}{}", key.number, axis.unwrap_or_default())
}

/// Parameters that no file of the kit writes and its preconditions ask for.
fn changed_by_hand(before: &Before<'_>, kit: &FanucMemory) -> Vec<(ParameterKey, ChangedBy)> {
    let mut list = Vec::new();
    for (axis, names) in before.plan.names.iter() {
        let ids = names.iter().filter_map(|name| name.parse().ok());
        for id in ids.filter(|id| kit.parameters.keys().any(|key| key.axis == Some(*id))) {
            let of_axis = |number| ParameterKey {
                number,
                axis: Some(id),
            };
            if !kit.parameters.contains_key(&of_axis(3605)) {
                list.push((of_axis(3605), ChangedBy::Precondition));
            }
            let backlash = backlash(before, axis);
            list.extend(backlash.map(|by| (of_axis(1851), by)));
            list.extend(backlash.map(|by| (of_axis(1852), by)));
        }
    }
    if let Tables::Fanuc(acted) = &before.active.tables {
        let switches = |key: &&ParameterKey| OFF_BY.iter().any(|of| of.contains(&key.number));
        let acts = |key: &&ParameterKey| acted.parameters[*key] != ParameterValue::Integer(0);
        let keys = acted.parameters.keys().filter(switches).filter(acts);
        let left_over = keys.filter(|key| !kit.parameters.contains_key(key));
        list.extend(left_over.map(|key| (*key, ChangedBy::Precondition)));
    }
    list
}

/// Who changes 1851 and 1852 of an axis that gets pitch tables.
fn backlash(before: &Before<'_>, axis: Axis) -> Option<ChangedBy> {
    let own = |t: &crate::write::plan::PlannedTable| t.term.is_positioning() && t.term.of == axis;
    before.plan.tables.iter().any(own).then(|| {
        if before.plan.sets_backlash(axis) {
            ChangedBy::Precondition
        } else {
            ChangedBy::Nobody
        }
    })
}
