//! The way back on a Fanuc control, from what was read out of it.

use super::*;
use ParameterValue::{Bits, Integer};
use nonius::control::table::fanuc::{FanucMemory, ParameterKey, ParameterValue};
use nonius::read::{read, read_apart};

fn memory(tables: Tables) -> FanucMemory {
    match tables {
        Tables::Fanuc(memory) => memory,
        _ => panic!("it is a Fanuc control"),
    }
}

fn dump(memory: &FanucMemory) -> String {
    let mut text = "%\nN00020Q1P4\nN01020Q1A1P88A2P89\n".to_string();
    for (key, value) in &memory.parameters {
        let axis = key.axis.map_or(String::new(), |axis| format!("A{axis}"));
        let value = match value {
            Integer(number) => number.to_string(),
            ParameterValue::Real(number) => format!("{number:?}"),
            Bits(bits) => format!("{bits:08b}"),
        };
        text += &format!("N{:05}Q1{axis}P{value}\n", key.number);
    }
    let point = |(point, value): (&u32, _)| format!("N{:05}Q0P{value}\n", point + 10000);
    text + &memory.points.iter().map(point).collect::<String>() + "%\n"
}

/// What a dump holds after the kit was loaded: all points, and both numbers of the points for moving −.
fn read_from(profile: &Profile, kit: &Kit) -> FanucMemory {
    let mut memory = memory(support::loaded(profile, kit));
    for (axis, number) in [(1, 3626), (1, 3627), (2, 3626), (2, 3627)] {
        memory.parameters.entry(ParameterKey { number, axis: Some(axis) }).or_insert(Integer(0));
    }
    for point in (0..100).chain(3000..3100) {
        memory.points.entry(point).or_insert(0);
    }
    memory
}

fn set(memory: &mut FanucMemory, number: u32, value: ParameterValue) {
    for axis in [1, 2] {
        memory.parameters.insert(ParameterKey { number, axis: Some(axis) }, value);
    }
}

/// 3605: whether an axis has a table for each direction.
fn bits_of(policy: &str) -> ParameterValue {
    Bits(0b1000_0000 | u8::from(policy == "two-tables"))
}

#[test]
fn the_way_back_on_fanuc_brings_back_what_was_read_out() {
    let profile = builtin::profile("fanuc-30i").unwrap();
    let load = |memory: &mut FanucMemory, file: FanucMemory| {
        memory.parameters.extend(file.parameters);
        memory.points.extend(file.points);
    };
    for way in WAYS {
        println!("{way:?}");
        let (old, job, left) = old_and_new("fanuc-30i", FANUC_AXES, way);
        let mut before = read_from(&profile, &old);
        set(&mut before, 3605, bits_of(way.0));
        set(&mut before, 1851, Integer(3));
        set(&mut before, 1852, Integer(3));
        let found = taken(&job, &left, &dump(&before));
        let new = shown(kit::generate(&found));
        let page = checklist(&new);
        assert!(!page.contains("rollback files. A") && !page.contains("no rollback"), "{page}");
        let mut control = before.clone();
        let files = [files_of(&new, Role::Table), files_of(&new, Role::Parameters)].concat();
        load(&mut control, memory(shown(read(&profile, &files)).tables));
        set(&mut control, 3605, bits_of(way.1));
        if way.1 != "mean" {
            set(&mut control, 1851, Integer(0));
            set(&mut control, 1852, Integer(0));
        }
        assert_ne!(control, before);
        let files = files_of(&new, Role::Rollback);
        load(&mut control, memory(shown(read_apart(&profile, &files, Role::Rollback)).tables));
        assert_eq!(control, before);
        let of = |found: &Inputs| {
            let active = found.active.as_ref().unwrap();
            acts(&profile, &active.tables, &active.state, ["1", "2"])
        };
        assert_eq!(of(&taken(&job, &left, &dump(&control))), of(&found));
    }
}

#[test]
fn sets_out_of_use_are_old_values_and_what_was_not_read_out_is_named() {
    let (old, job, left) = old_and_new("fanuc-30i", FANUC_AXES, ("mean", "two-tables"));
    let mut before = read_from(&builtin::profile("fanuc-30i").unwrap(), &old);
    for number in (5711..=5720).chain(5721..=5730) {
        before.parameters.insert(ParameterKey { number, axis: None }, Integer(0));
    }
    set(&mut before, 3626, Integer(0));
    set(&mut before, 3627, Integer(0));
    let job = job.replace(ACTIVE, &format!("{ACTIVE}\nactive_backlash_um = {{ x = 0, y = 0 }}"));
    let new = shown(kit::generate(&taken(&job, &left, &dump(&before))));
    holds(&String::from_utf8_lossy(&files_of(&new, Role::Rollback)[0].bytes), &["N05711Q1L1P0"]);
    let page = checklist(&new);
    for number in [1851, 1852, 3605] {
        let lacking = format!("{number} of axis 1, 2: not in");
        assert_eq!(page.matches(&lacking).count(), 2, "{lacking}\n{page}");
    }
}
