//! What a kit changes on a Fanuc control: parameters and points, 3605, 1851 and 1852.

use crate::control::table::Tables;
use crate::control::table::fanuc::{FanucMemory, ParameterKey, ParameterValue};
use crate::judge::before::{Before, ChangedBy, Lacking, Old, unknown};
use crate::quantity::axis::Axis;

/// The magnification of the pitch points of an axis, and the moving axes of straightness sets: what
/// a person sets to 0 to switch an old compensation off.
const OFF_BY: [std::ops::RangeInclusive<u32>; 2] = [3623..=3623, 5711..=5720];

/// Of the tables of a kit, of those held and of those that acted.
pub(super) fn old(
    before: &Before<'_>,
    [kit, held, acted]: [&FanucMemory; 3],
) -> Result<Old, Vec<String>> {
    let mut old = FanucMemory::default();
    let mut missing = Vec::new();
    for key in kit.parameters.keys() {
        let value = held.parameters.get(key);
        old.parameters.extend(value.map(|value| (*key, *value)));
        missing.extend(value.is_none().then(|| key.to_string()));
    }
    for point in kit.points.keys() {
        let value = held.points.get(point);
        old.points.extend(value.map(|value| (*point, *value)));
        missing.extend(value.is_none().then(|| format!("point {point}")));
    }
    if !missing.is_empty() {
        return Err(missing);
    }
    let mut lacking: Vec<Lacking> = Vec::new();
    for (key, by) in changed_by_hand(before, kit, acted) {
        match held.parameters.get(&key) {
            Some(value) => {
                old.parameters.insert(key, *value);
            }
            None if by == ChangedBy::Nobody => {}
            None => {
                let axis = key.axis.map(|axis| axis.to_string());
                let of = if axis.is_some() { " of axis " } else { "" };
                let name = format!("{}{of}", key.number);
                lacking.push((name, axis.unwrap_or_default(), ChangedBy::Precondition));
            }
        }
    }
    lacking.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(Old {
        tables: Tables::Fanuc(old),
        data: Vec::new(),
        unknown: unknown(lacking),
        stays: Vec::new(),
    })
}

/// Parameters that no file of the kit writes and its preconditions ask for.
fn changed_by_hand(
    before: &Before<'_>,
    kit: &FanucMemory,
    acted: &FanucMemory,
) -> Vec<(ParameterKey, ChangedBy)> {
    let mut list = Vec::new();
    for (axis, names) in before.plan.names.iter() {
        let ids = names.iter().filter_map(|name| name.parse().ok());
        for id in ids.filter(|id| kit.parameters.keys().any(|key| key.axis == Some(*id))) {
            let of_axis = |number| ParameterKey { number, axis: Some(id) };
            if !kit.parameters.contains_key(&of_axis(3605)) {
                list.push((of_axis(3605), ChangedBy::Precondition));
            }
            let backlash = backlash(before, axis);
            list.extend(backlash.map(|by| (of_axis(1851), by)));
            list.extend(backlash.map(|by| (of_axis(1852), by)));
        }
    }
    let switches = |key: &&ParameterKey| OFF_BY.iter().any(|of| of.contains(&key.number));
    let acts = |key: &&ParameterKey| acted.parameters[*key] != ParameterValue::Integer(0);
    let keys = acted.parameters.keys().filter(switches).filter(acts);
    let left_over = keys.filter(|key| !kit.parameters.contains_key(key));
    list.extend(left_over.map(|key| (*key, ChangedBy::Precondition)));
    list
}

/// Who changes 1851 and 1852 of an axis that gets pitch tables.
fn backlash(before: &Before<'_>, axis: Axis) -> Option<ChangedBy> {
    let own = |t: &crate::write::plan::PlannedTable| t.term.is_positioning() && t.term.of == axis;
    before.plan.tables.iter().any(own).then(|| {
        if before.plan.sets_backlash(axis) { ChangedBy::Precondition } else { ChangedBy::Nobody }
    })
}
