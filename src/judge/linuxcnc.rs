//! LinuxCNC: what was read out of it, against a job and against a kit.

use crate::control::controller::{ControlUnit, LinuxcncFacts};
use crate::control::table::Tables;
use crate::control::table::linuxcnc::{CompTable, CrossTable, LinuxcncTables, Point, Row};
use crate::judge::active::{Found, Held, NamedBacklash, ReadOutReader};
use crate::judge::before::{Before, Old};
use crate::judge::disagreement::entries::{Entries, Entry, Item, Value};
use crate::judge::family::{Family, Side};
use crate::judge::findings::InControl;
use crate::quantity::axis::{Direction, PerAxis};
use crate::quantity::units::UM_PER_MM;
use crate::read::linuxcnc::{Contents, Joint, read};
use crate::text::problem::Problems;

impl Family for LinuxcncFacts {
    fn read_out(&self, reading: &mut ReadOutReader<'_>) -> Result<Found, Problems> {
        let mut found = read(reading.texts, self)?;
        reading.findings.extend(found.not_named());
        let held = Held::plain(Tables::Linuxcnc(found.tables.clone()));
        check_homes(reading, &found);
        tell_others(reading, &mut found.tables);
        Ok(Found {
            backlash: PerAxis::from_fn(|axis| backlash(&reading.names[axis], reading, &found)),
            tables: Tables::Linuxcnc(found.tables),
            held,
            unit: found.unit,
        })
    }

    fn left_over(&self, old: &Tables, new: &Tables) -> Vec<String> {
        let (old, new) = (own(old), own(new));
        let stays = |table: &&CompTable| new.of_joint(table.joint).is_none();
        let stays = old.joints.iter().filter(stays);
        let stays = stays.map(|table| format!("COMP_FILE of [{}]", table.name()));
        let is_left = !old.cross.is_empty() && new.cross.is_empty();
        let hal = is_left.then(|| "the HAL file with the corrections".to_string());
        stays.chain(hal).collect()
    }

    fn entries(&self, side: &Side<'_>) -> Entries {
        let of_table = |table: &CompTable| {
            let joint = table.joint.to_string();
            let told = side.tells(&joint, &joint);
            let name = table.name();
            let entry = move |item, value| ((name.clone(), item), Entry::of(value, told, told));
            let columns = Value::Text(table.columns.number().to_string());
            let mut entries = vec![entry(Item::Name("COMP_FILE_TYPE".to_string()), columns)];
            entries.extend((0_u32..).zip(&table.rows).map(|(index, row)| {
                let Row { nominal, forward, reverse } = *row;
                let numbers = [nominal, forward, reverse].map(Some).to_vec();
                entry(Item::Point(index), Value::Numbers(numbers))
            }));
            entries
        };
        let of_cross = |table: &CrossTable| {
            let (base, output) = (table.base.to_string(), table.output.to_string());
            let told = side.tells(&base, &output);
            let name = format!("HAL: {}", table.name());
            let points = (0_u32..).zip(table.pieces.iter().flatten());
            let entry = move |(index, point): (u32, &Point)| {
                let numbers = [point.position, point.value].map(Some).to_vec();
                let value = Value::Numbers(numbers);
                ((name.clone(), Item::Point(index)), Entry::of(value, told, told))
            };
            points.map(entry).collect::<Vec<_>>()
        };
        let tables = own(side.tables);
        let joints = tables.joints.iter().flat_map(of_table);
        joints.chain(tables.cross.iter().flat_map(of_cross)).collect()
    }

    /// A kit overwrites no file of the machine: the ini file that was kept is the rollback.
    fn old(&self, _before: &Before<'_>) -> Result<Old, Vec<String>> {
        Err(vec!["the ini file of the machine".to_string()])
    }
}

/// The tables of a memory; a memory of another family holds none.
fn own(tables: &Tables) -> &LinuxcncTables {
    const NONE: &LinuxcncTables = &LinuxcncTables { joints: Vec::new(), cross: Vec::new() };
    tables.own().unwrap_or(NONE)
}

/// The unit of the files: what they say, else the job.
fn unit(reading: &ReadOutReader<'_>, found: &Contents) -> ControlUnit {
    found.unit.unwrap_or(reading.job.compensation.control_unit)
}

/// BACKLASH of each joint of an axis, µm, as it acts: not beside a table.
fn backlash(names: &[String], reading: &ReadOutReader<'_>, found: &Contents) -> NamedBacklash {
    let um_per_unit = unit(reading, found).in_mm() * UM_PER_MM;
    let of_joint = |name: &String| {
        let joint = found.joints.get(&name.parse().ok()?)?;
        let is_ignored = joint.comp_file.is_some();
        let acts = joint.backlash.filter(|_| !is_ignored).unwrap_or(0.0);
        Some(acts * um_per_unit)
    };
    let named = names.iter().map(|name| (name.clone(), of_joint(name)));
    named.collect()
}

/// Where homing sets the position and in which direction, against the reference of the job: a table has to be zero there.
fn check_homes(reading: &mut ReadOutReader<'_>, found: &Contents) {
    const SAME_MM: f64 = 1e-3;
    let unit = unit(reading, found);
    let with_table = |(_, settings): &(&u32, &Joint)| settings.comp_file.is_some();
    for (joint, settings) in found.joints.iter().filter(with_table) {
        let axis = reading.axis(&joint.to_string());
        let Some(machine) = axis.and_then(|axis| reading.job.machine.axes[axis]) else {
            continue;
        };
        let own_mm = machine.reference.mm();
        let default = found.is_whole.then_some(0.0);
        if let Some(position) = settings.home_offset.or(default)
            && (position * unit.in_mm() - own_mm).abs() > SAME_MM
        {
            let (joint, unit) = (*joint, unit.word());
            reading.tell(InControl::HomeOffset { joint, position, unit, own_mm });
        }
        let latch = settings.home_latch.filter(|speed| speed.abs() > 0.0);
        let is_up = machine.homing() == Direction::Plus;
        if let Some(speed) = latch
            && (speed > 0.0) != is_up
        {
            let own = machine.homing();
            reading.tell(InControl::HomeDirection { joint: *joint, speed, own });
        }
    }
}

/// Tables of joints that the job does not have.
fn tell_others(reading: &mut ReadOutReader<'_>, tables: &mut LinuxcncTables) {
    let own = |table: &CompTable| [table.joint, table.joint].map(|joint| joint.to_string());
    for table in reading.take_others(&mut tables.joints, own) {
        let what = format!("the table of {}", table.name());
        let axes = "a joint";
        reading.tell(InControl::OfOthers { what, axes });
    }
    let cross = |table: &CrossTable| [table.base, table.output].map(|joint| joint.to_string());
    for table in reading.take_others(&mut tables.cross, cross) {
        let what = format!("the correction of {}", table.name());
        let axes = "a joint";
        reading.tell(InControl::OfOthers { what, axes });
    }
}
