//! FANUC: what was read out of it, against a job and against a kit.

mod read_out;

use crate::control::controller::{FanucFacts, NumberRange, Profile};
use crate::control::table::Tables;
use crate::control::table::fanuc::{FanucMemory, ParameterKey};
use crate::inputs::job::Job;
use crate::judge::active::{ActiveControl, Others, ReadOutReader};
use crate::judge::disagreement::{Entries, Entry, Item, Value};
use crate::judge::family::{Before, ChangedBy, Family, Old, Side, unknown};
use crate::judge::findings::{InControl, InSum};
use crate::text::Problems;
use crate::write::plan::axis_names;

impl Family for FanucFacts {
    fn read_out(&self, reading: &mut ReadOutReader<'_>) -> Result<(), Problems> {
        read_out::read(reading, self)
    }

    fn taken(&self, others: &Others, new: &Tables) -> Vec<(String, &'static str)> {
        let new: &FanucMemory = new.own();
        let sets = others.sets.iter();
        let sets = sets.filter(|set| new.whole(5710 + *set, None).is_some_and(|axis| axis != 0));
        let sets = sets.map(|set| {
            (format!("straightness set {set}"), "state a `first_set` behind it in [compensation]")
        });
        let holds =
            |range: &&NumberRange| new.points.range(range.first..=range.last).next().is_some();
        let points = others.points.iter().filter(holds).map(|range| {
            let what = format!("the block of points {} to {}", range.first, range.last);
            (what, "name it in `reserved_points` of [compensation], or move `first_point`")
        });
        sets.chain(points).collect()
    }

    /// Parameters.
    fn left_over(&self, old: &Tables, new: &Tables) -> Vec<String> {
        left_over(old.own(), new.own()).map(|key| key.words()).collect()
    }

    /// 3605#1: lines or steps between the points.
    fn take_interpolation(
        &self,
        job: &mut Job,
        profile: &Profile,
        active: &ActiveControl,
    ) -> Vec<InSum> {
        let Ok(names) = axis_names(job, profile) else {
            return Vec::new();
        };
        let memory = active.tables.own();
        let (mut axes, mut turned) = (Vec::new(), Vec::new());
        for (axis, names) in names.iter() {
            let Some(settings) = &mut job.compensation.axes[axis] else {
                continue;
            };
            let in_state = |name: &String| active.state.axis(name).is_some_and(|a| a.interpolated);
            let held = interpolated(memory, names).or(names.iter().all(in_state).then_some(true));
            if settings.interpolated.is_none() && settings.parameter_3605.is_none() {
                settings.interpolated = held;
                axes.extend(names.iter().filter(|_| held == Some(true)).cloned());
            } else if held.is_some_and(|held| held != settings.is_interpolated()) {
                turned.extend(names.iter().cloned());
            }
        }
        let taken = (!axes.is_empty()).then_some(InSum::Interpolated { axes });
        let turned = (!turned.is_empty()).then_some(InSum::Turned { axes: turned });
        taken.into_iter().chain(turned).collect()
    }

    fn entries(&self, side: &Side<'_>) -> Entries {
        let Side { tables, diagnosis, .. } = side;
        let own: &FanucMemory = tables.own();
        let explained = |key: &ParameterKey| {
            let axis = key.axis.map(|axis| axis.to_string());
            let acts_on = |(base, output): &(String, String)| match &axis {
                Some(axis) => base == axis || output == axis,
                None => base != output,
            };
            diagnosis.is_some_and(|d| d.pairs.iter().any(acts_on))
        };
        let points_are_explained = diagnosis.is_some_and(|d| !d.findings.is_empty());
        let parameters = own.parameters.iter().map(|(key, value)| {
            let amount = own.amount(key.number, key.axis).map(|of| Value::Numbers(vec![Some(of)]));
            let value = amount.unwrap_or_else(|| Value::Text(value.to_string()));
            (Item::Name(key.to_string()), value, !explained(key))
        });
        let points = own.points.iter().map(|(point, value)| {
            let value = Value::Numbers(vec![Some(f64::from(*value))]);
            (Item::Point(*point), value, !points_are_explained)
        });
        let entry = |(item, value, differing): (Item, Value, bool)| {
            ((String::new(), item), Entry { value, alone: true, differing })
        };
        parameters.chain(points).map(entry).collect()
    }

    fn surroundings(&self, before: &Before<'_>) -> (Vec<InControl>, Vec<String>) {
        let wanted = before.compiled;
        let (state, tables) = (&wanted.state, wanted.tables.own());
        let held = before.held.own();
        let found = read_out::around(before.plan, state, tables, held);
        (found, read_out::absent(&state.axes, tables, held))
    }

    fn old(&self, before: &Before<'_>) -> Result<Old, Vec<String>> {
        let [kit, held, acted] = before.tables().map(Tables::own::<FanucMemory>);
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
        Ok(Old { tables: Tables::Fanuc(old), unknown: unknown(lacking), stays: Vec::new() })
    }
}

/// 3605#1 of an axis as files of the control hold it; `None` where none does, or the axes of a
/// gantry differ.
fn interpolated(memory: &FanucMemory, names: &[String]) -> Option<bool> {
    let bits = |name: &String| Some(memory.bits(3605, name.parse().ok())? & 0b10 != 0);
    let first = bits(names.first()?)?;
    names.iter().all(|name| bits(name) == Some(first)).then_some(first)
}

// What a kit changes on a Fanuc control: parameters and points, 3605, 1851 and 1852.

/// What makes old compensation act that the new files do not overwrite: the magnification of the pitch points
/// of an axis, and the moving axes of straightness sets. A person sets it to 0.
fn left_over(old: &FanucMemory, new: &FanucMemory) -> impl Iterator<Item = ParameterKey> {
    let stays = |key: &&ParameterKey| {
        let is_switch = matches!((key.number, key.axis), (3623, Some(_)) | (5711..=5720, None));
        let acts = old.whole(key.number, key.axis).is_some_and(|value| value != 0);
        is_switch && acts && !new.parameters.contains_key(key)
    };
    old.parameters.keys().filter(stays).copied()
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
