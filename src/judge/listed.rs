//! What was read out of controls whose tables list their points one by one (declared, LinuxCNC, ISG kernel), against a
//! job and against a kit. The files that were kept are the rollback.

use crate::control::controller::{ControlUnit, DeclaredFacts, IsgFacts, LinuxcncFacts, PointLists};
use crate::control::table::isg::{IsgCurve, IsgTables};
use crate::control::table::{ListedTable, ListedTables, Point, Tables};
use crate::judge::active::ReadOutReader;
use crate::judge::disagreement::{Entries, Entry, Item, Value};
use crate::judge::family::{Before, Family, Old, Side};
use crate::judge::findings::InControl;
use crate::quantity::{Axis, Direction, PerAxis, UM_PER_MM};
use crate::read::declared::tables;
use crate::read::isg;
use crate::read::linuxcnc::{Contents, Joint, read};
use crate::text::Problems;

impl Family for DeclaredFacts {
    fn read_out(&self, reading: &mut ReadOutReader<'_>) -> Result<(), Problems> {
        let mut found = tables(reading.texts, self, true)?;
        let held = Tables::Listed(found.clone());
        // A new list takes the place of the whole old one: an old table of another axis would be lost, and is
        // refused where it is emulated.
        if self.typed.is_none() || reading.judges() {
            self.tell_others(reading, &mut found);
        }
        reading.found(Tables::Listed(found), held);
        Ok(())
    }

    fn left_over(&self, old: &Tables, new: &Tables) -> Vec<String> {
        let (old, new) = (own(old), own(new));
        // Typed by hand, a table for each direction stays beside one for both.
        let is_same = |one: &ListedTable, other: &ListedTable| {
            one.is_for(&other.base, &other.output)
                && (self.typed.is_none() || one.has_two() == other.has_two())
        };
        let stays = |table: &&ListedTable| !new.iter().any(|new| is_same(new, table));
        let stays = old.iter().filter(stays);
        stays.map(|table| format!("the old {}", self.table_name(table))).collect()
    }

    fn entries(&self, side: &Side<'_>) -> Entries {
        entries(self, side, self.first_point.value)
    }

    /// The files that were read out are the rollback.
    fn old(&self, _before: &Before<'_>) -> Result<Old, Vec<String>> {
        Err(vec!["tables of this format".to_string()])
    }
}

impl DeclaredFacts {
    /// Tables of axes that the job does not have; one that moves an axis of the job is told as such. A set of factors
    /// holds all, 0 for an axis that the machine does not have.
    fn tell_others(&self, reading: &mut ReadOutReader<'_>, found: &mut ListedTables) {
        let mut others = take_others(reading, found);
        others.retain(|table| self.factors.is_none() || !table.is_zero());
        for table in others {
            let what = format!("the {}", self.table_name(&table));
            let moving = table.base.clone();
            reading.tell(match reading.has(&table.output) {
                true => InControl::Follows { what, moving },
                false => InControl::OfOthers { what, axes: "axes" },
            });
        }
    }
}

// Tables that list their points one by one, as any control holds them.

/// The tables of a memory; a memory of another family holds none.
fn own(tables: &Tables) -> &[ListedTable] {
    &tables.own::<ListedTables>().tables
}

/// Point by point what tables hold, of which the first one has this number, and the name of their set.
fn entries(facts: &impl PointLists, side: &Side<'_>, first_point: u32) -> Entries {
    let of_table = |table: &ListedTable| {
        let told = side.tells(&table.base, &table.output);
        let name = facts.table_name(table);
        let entry = move |(index, point): (u32, &Point)| {
            let numbers = vec![Some(point.position), Some(point.forward), point.reverse];
            let key = (name.clone(), Item::Point(index));
            (key, Entry { value: Value::Numbers(numbers), alone: told, differing: told })
        };
        (first_point..).zip(&table.points).map(entry).collect::<Vec<_>>()
    };
    let set = side.tables.own::<ListedTables>().set.clone();
    let set = set.map(|name| {
        let key = ("set of tables".to_string(), Item::Name("its name".to_string()));
        (key, Entry { value: Value::Text(name), alone: true, differing: true })
    });
    own(side.tables).iter().flat_map(of_table).chain(set).collect()
}

/// Takes out tables of axes that the job does not have.
fn take_others(reading: &ReadOutReader<'_>, found: &mut ListedTables) -> Vec<ListedTable> {
    let has = |table: &ListedTable| reading.has(&table.base) && reading.has(&table.output);
    found.tables.extract_if(.., |table| !has(table)).collect()
}

// LinuxCNC: what was read out of it, against a job and against a kit.

impl Family for LinuxcncFacts {
    fn read_out(&self, reading: &mut ReadOutReader<'_>) -> Result<(), Problems> {
        let mut found = read(reading.texts, self)?;
        reading.active.findings.append(&mut found.notes);
        let held = Tables::Listed(found.tables.clone());
        check_homes(reading, &found);
        for table in take_others(reading, &mut found.tables) {
            let (what, axes) = (format!("the {}", self.table_name(&table)), "a joint");
            reading.tell(InControl::OfOthers { what, axes });
        }
        reading.active.held_backlash = reading.backlash(|_, name| backlash(name, reading, &found));
        reading.check_unit(found.unit);
        reading.found(Tables::Listed(found.tables), held);
        Ok(())
    }

    fn left_over(&self, old: &Tables, new: &Tables) -> Vec<String> {
        let (old, new) = (own(old), own(new));
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
        entries(self, side, 0)
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

/// BACKLASH of a joint, µm, as it acts: not beside a table.
fn backlash(name: &str, reading: &ReadOutReader<'_>, found: &Contents) -> Option<f64> {
    let joint = found.joints.get(&name.parse().ok()?)?;
    let acts = joint.backlash.filter(|_| joint.comp_file.is_none()).unwrap_or(0.0);
    Some(acts * (unit(reading, found).in_mm() * UM_PER_MM))
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
        if let Some(position) = settings.home_offset.or(found.is_whole.then_some(0.0))
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
            reading.tell(InControl::HomeDirection { joint: *joint, speed, own: machine.homing() });
        }
    }
}

// ISG kernel: what was read out of it, against a job and against a kit.

impl Family for IsgFacts {
    fn read_out(&self, reading: &mut ReadOutReader<'_>) -> Result<(), Problems> {
        let (tables, findings) = isg::read(reading.texts)?;
        reading.active.findings.extend(findings);
        reading.found(Tables::Isg(tables.clone()), Tables::Isg(tables));
        Ok(())
    }

    fn entries(&self, side: &Side<'_>) -> Entries {
        let tables: &IsgTables = side.tables.own();
        let name = |axis: Axis| tables.axes[axis].map_or(String::new(), |own| own.to_string());
        let letters = |chosen: PerAxis<bool>| {
            let chosen = Axis::ALL.into_iter().filter(|axis| chosen[*axis]);
            Axis::letters(&chosen.collect::<Vec<Axis>>())
        };
        let axes = Axis::ALL.map(|axis| (axis.to_string(), name(axis)));
        let settings = [
            ("chain".to_string(), Axis::letters(&tables.chain)),
            ("negate".to_string(), letters(tables.negated)),
            ("set_to_zero".to_string(), letters(tables.zeroed)),
        ];
        let stated = axes.into_iter().chain(settings);
        let stated = stated.map(|(key, value)| {
            let item = ("list".to_string(), Item::Name(key));
            (item, Entry { value: Value::Text(value), alone: true, differing: true })
        });
        let of_curve = |curve: &IsgCurve| {
            let block = curve.parameter.to_string();
            let pair = curve.parameter.pair();
            let told = pair.is_none_or(|(base, output)| side.tells(&name(base), &name(output)));
            (0_u32..).zip(curve.points.clone()).map(move |(index, point)| {
                let numbers = [point.position, point.value].map(Some).to_vec();
                let item = (block.clone(), Item::Point(index));
                (item, Entry { value: Value::Numbers(numbers), alone: told, differing: told })
            })
        };
        stated.chain(tables.curves.iter().flat_map(of_curve)).collect()
    }

    /// The files that were kept are the rollback.
    fn old(&self, _before: &Before<'_>) -> Result<Old, Vec<String>> {
        Err(vec!["the list and the parameter files of the control".to_string()])
    }
}
