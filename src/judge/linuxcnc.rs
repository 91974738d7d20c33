//! LinuxCNC: what was read out of it, against a job and against a kit.

use crate::control::controller::{ControlUnit, LinuxcncFacts, Listed};
use crate::control::table::{ListedTable, ListedTables, Tables};
use crate::judge::active::{Found, Held, NamedBacklash, ReadOutReader};
use crate::judge::before::{Before, Old};
use crate::judge::declared;
use crate::judge::disagreement::entries::Entries;
use crate::judge::family::{Family, Side};
use crate::judge::findings::InControl;
use crate::quantity::{Direction, PerAxis, UM_PER_MM};
use crate::read::linuxcnc::{Contents, Joint, read};
use crate::text::Problems;

impl Family for LinuxcncFacts {
    fn read_out(&self, reading: &mut ReadOutReader<'_>) -> Result<Found, Problems> {
        let mut found = read(reading.texts, self)?;
        reading.findings.append(&mut found.notes);
        let held = Held::plain(Tables::Listed(found.tables.clone()));
        check_homes(reading, &found);
        tell_others(self, reading, &mut found.tables);
        Ok(Found {
            backlash: PerAxis::from_fn(|axis| backlash(&reading.names[axis], reading, &found)),
            tables: Tables::Listed(found.tables),
            held,
            unit: found.unit,
        })
    }

    fn left_over(&self, old: &Tables, new: &Tables) -> Vec<String> {
        let (old, new) = (declared::own(old), declared::own(new));
        let stays = |table: &&ListedTable| {
            table.is_own() && !new.iter().any(|own| own.is_for(&table.base, &table.output))
        };
        let stays = old.iter().filter(stays);
        let stays = stays.map(|table| format!("COMP_FILE of [JOINT_{}]", table.output));
        let has_cross = |tables: &[ListedTable]| tables.iter().any(|table| !table.is_own());
        let is_left = has_cross(old) && !has_cross(new);
        let hal = is_left.then(|| "the HAL file with the corrections".to_string());
        stays.chain(hal).collect()
    }

    fn entries(&self, side: &Side<'_>) -> Entries {
        declared::entries(self, side, 0)
    }

    /// A kit overwrites no file of the machine: the ini file that was kept is the rollback.
    fn old(&self, _before: &Before<'_>) -> Result<Old, Vec<String>> {
        Err(vec!["the ini file of the machine".to_string()])
    }
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
fn tell_others(facts: &LinuxcncFacts, reading: &mut ReadOutReader<'_>, found: &mut ListedTables) {
    for table in declared::take_others(reading, found) {
        let what = format!("the {}", facts.table_name(&table));
        let axes = "a joint";
        reading.tell(InControl::OfOthers { what, axes });
    }
}
