//! The way back on a Fanuc control, from what was read out of it.

use super::*;
use nonius::control::controller::Role;
use nonius::control::table::Tables;
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
            ParameterValue::Integer(number) => number.to_string(),
            ParameterValue::Real(number) => format!("{number:?}"),
            ParameterValue::Bits(bits) => format!("{bits:08b}"),
        };
        writeln!(text, "N{:05}Q1{axis}P{value}", key.number).unwrap();
    }
    for (point, value) in &memory.points {
        writeln!(text, "N{:05}Q0P{value}", point + 10000).unwrap();
    }
    text.push_str("%\n");
    text
}

fn set(memory: &mut FanucMemory, number: u32, axis: u32, value: ParameterValue) {
    let axis = Some(axis);
    memory.parameters.insert(ParameterKey { number, axis }, value);
}

#[test]
fn the_way_back_on_fanuc_brings_back_what_was_read_out() {
    let profile = nonius::control::controller::builtin::profile("fanuc-30i").unwrap();
    let load = |memory: &mut FanucMemory, file: FanucMemory| {
        memory.parameters.extend(file.parameters);
        memory.points.extend(file.points);
    };
    for way in WAYS {
        let (old, job, left) = old_and_new("fanuc-30i", FANUC_AXES, way);
        let mut before = memory(support::loaded(&profile, &old));
        let two = way.0 == "two-tables";
        for axis in [1, 2] {
            set(&mut before, 3605, axis, ParameterValue::Bits(0b1000_0000 | u8::from(two)));
            set(&mut before, 1851, axis, ParameterValue::Integer(3));
            set(&mut before, 1852, axis, ParameterValue::Integer(3));
            for number in [3626, 3627] {
                let key = ParameterKey { number, axis: Some(axis) };
                before.parameters.entry(key).or_insert(ParameterValue::Integer(0));
            }
        }
        for point in (0..100).chain(3000..3100) {
            before.points.entry(point).or_insert(0); // a dump holds them all
        }
        let found =
            read_out(&job, &left, &dump(&before)).unwrap_or_else(|p| panic!("{way:?}\n{p}"));
        let new = kit::generate(&found).unwrap_or_else(|p| panic!("{way:?}\n{}", p.render()));
        let page = String::from_utf8_lossy(files_of(&new, Role::Checklist)[0].bytes).into_owned();
        assert!(
            !page.contains("rollback files. A") && !page.contains("no rollback"),
            "{way:?}\n{page}"
        );
        let mut control = before.clone();
        let kit_files = read(
            &profile,
            &[files_of(&new, Role::Table), files_of(&new, Role::Parameters)].concat(),
        );
        load(&mut control, memory(kit_files.unwrap().tables));
        for axis in [1, 2] {
            set(
                &mut control,
                3605,
                axis,
                ParameterValue::Bits(0b1000_0000 | u8::from(way.1 == "two-tables")),
            );
            if way.1 != "mean" {
                set(&mut control, 1851, axis, ParameterValue::Integer(0));
                set(&mut control, 1852, axis, ParameterValue::Integer(0));
            }
        }
        assert_ne!(control, before, "{way:?}");
        let files = files_of(&new, Role::Rollback);
        load(&mut control, memory(read_apart(&profile, &files, Role::Rollback).unwrap().tables));
        assert_eq!(control, before, "{way:?}");
        let again = read_out(&job, &left, &dump(&control)).unwrap().active.unwrap();
        let was = found.active.as_ref().unwrap();
        let of = |active: &ActiveControl| {
            let control = kit::emulator(&profile, &active.tables, &active.state);
            acts(control.unwrap_or_else(|reason| panic!("{}", reason.0)).as_ref(), ["1", "2"])
        };
        assert_eq!(of(&again), of(was), "{way:?}");
    }
}

#[test]
fn sets_out_of_use_are_old_values_and_what_was_not_read_out_is_named() {
    let (old, job, left) = old_and_new("fanuc-30i", FANUC_AXES, ("mean", "two-tables"));
    let profile = nonius::control::controller::builtin::profile("fanuc-30i").unwrap();
    let mut before = memory(support::loaded(&profile, &old));
    for number in (5711..=5716).chain(5721..=5726) {
        let key = ParameterKey { number, axis: None };
        before.parameters.insert(key, ParameterValue::Integer(0));
    }
    for (axis, number) in [(1, 3626), (1, 3627), (2, 3626), (2, 3627)] {
        set(&mut before, number, axis, ParameterValue::Integer(0));
    }
    for point in (0..100).chain(3000..3100) {
        before.points.entry(point).or_insert(0);
    }
    let job = job.replace(ACTIVE, &format!("{ACTIVE}\nactive_backlash_um = {{ x = 0, y = 0 }}"));
    let found = read_out(&job, &left, &dump(&before)).unwrap_or_else(|p| panic!("{p}"));
    let new = kit::generate(&found).unwrap();
    let rollback = files_of(&new, Role::Rollback);
    let text = String::from_utf8_lossy(rollback[0].bytes);
    assert!(text.contains("N05711Q1P0"), "{text}");
    let page = String::from_utf8_lossy(files_of(&new, Role::Checklist)[0].bytes).into_owned();
    for lacking in
        ["1851 of axis 1, 2: not in", "1852 of axis 1, 2: not in", "3605 of axis 1, 2: not in"]
    {
        assert_eq!(page.matches(lacking).count(), 2, "{lacking}\n{page}");
    }
}
