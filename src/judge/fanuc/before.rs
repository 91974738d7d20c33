//! What a kit changes on a Fanuc control: parameters and points, 3605, 1851 and 1852.

use crate::control::table::Tables;
use crate::control::table::fanuc::{FanucMemory, ParameterKey};
use crate::judge::before::{Before, ChangedBy, Old, unknown};

/// What makes old compensation act that the new files do not overwrite: the magnification of the pitch points
/// of an axis, and the moving axes of straightness sets. A person sets it to 0.
pub(super) fn left_over(
    old: &FanucMemory,
    new: &FanucMemory,
) -> impl Iterator<Item = ParameterKey> {
    let stays = |key: &&ParameterKey| {
        let is_switch = matches!((key.number, key.axis), (3623, Some(_)) | (5711..=5720, None));
        let acts = old.whole(key.number, key.axis).is_some_and(|value| value != 0);
        is_switch && acts && !new.parameters.contains_key(key)
    };
    old.parameters.keys().filter(stays).copied()
}

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
    let mut lacking = Vec::new();
    for (key, by) in changed_by_hand(before, kit, acted) {
        match held.parameters.get(&key) {
            Some(value) => _ = old.parameters.insert(key, *value),
            None if by == ChangedBy::Nobody => {}
            None => {
                let words = key.words();
                let of_axis = words.rfind(' ').map_or(words.len(), |at| at + 1);
                let (name, axis) = words.split_at(of_axis);
                lacking.push((name.to_string(), axis.to_string(), by));
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
            let backlash = before.backlash(axis);
            list.extend(backlash.map(|by| (of_axis(1851), by)));
            list.extend(backlash.map(|by| (of_axis(1852), by)));
        }
    }
    list.extend(left_over(acted, kit).map(|key| (key, ChangedBy::Precondition)));
    list
}
