//! What files hold beyond, short of or against what the job writes, in words.
//!
//! Emulation sees only what moves an axis of the job. A job owns its tables, their switches and
//! their memory and nothing else, so everything else in a file is told here: foreign points, foreign
//! parameters, foreign machine data. Every family lists what its tables hold, entry by entry; the lists
//! are compared alike.

use super::Disagreements;
use super::machine_data::{self, lec_name};
use crate::control::controller::{Dialect, Profile};
use crate::control::table::Tables;
use crate::control::table::fanuc::{FanucMemory, ParameterKey, ParameterValue};
use crate::control::table::generic::GenericTable;
use crate::control::table::siemens::{
    CecDirection, CecTable, LecTable, SiemensGrid, SiemensTables,
};
use crate::judge::findings::{InControl, it, listed};
use crate::quantity::units::rounded;
use crate::read::ReadBack;
use crate::text::finding::Finding;
use std::collections::BTreeMap;

/// Everything surplus, missing or contradictory, one sentence each.
///
/// **limits** what `diagnosis` already explains is not told again; without a diagnosis (tables
/// that cannot be emulated, whose reason is told elsewhere) only what is surplus is told of the
/// tables, and everything of the machine data.
pub fn contents(
    profile: &Profile,
    wanted: &Tables,
    read: &ReadBack,
    diagnosis: Option<&Disagreements>,
) -> Vec<Finding> {
    let mut words = match wanted == &read.tables {
        true => Vec::new(),
        false => {
            let own = entries(wanted, &read.tables, diagnosis);
            let found = entries(&read.tables, wanted, diagnosis);
            differences(&own, &found, diagnosis.is_some())
        }
    };
    if !read.unwritten.is_empty() {
        let (names, them) = (listed(&read.unwritten), it(read.unwritten.len()));
        words.push(format!(
            "no file writes {names}: the control keeps what it holds there, the job writes {them}"
        ));
    }
    if let (Dialect::Siemens(facts), Tables::Siemens(wanted)) = (&profile.dialect, wanted) {
        words.extend(machine_data::differences(wanted, &read.machine_data, facts));
    }
    let differs = |words| InControl::Differs { words }.into();
    words.into_iter().map(differs).collect()
}

/// What nobody can judge because the files for it are not there, and what to see to instead.
pub fn absent(profile: &Profile, wanted: &Tables, read: &ReadBack) -> Vec<Finding> {
    let mut found = match (&profile.dialect, wanted) {
        (Dialect::Siemens(facts), Tables::Siemens(wanted)) => {
            machine_data::absent(wanted, &read.machine_data, facts)
        }
        _ => Vec::new(),
    };
    found.extend(read.notes.iter().cloned());
    found
}

/// A number of a table, or a parameter by its name.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Item {
    Name(String),
    Point(u32),
}

enum Value {
    Numbers(Vec<Option<f64>>),
    Text(String),
}

impl Value {
    fn is(&self, other: &Value) -> bool {
        /// Numbers of files closer than this are equal, in their own unit.
        const EQUAL: f64 = 1e-9;
        let same = |(a, b): (&Option<f64>, &Option<f64>)| match (a, b) {
            (Some(a), Some(b)) => (a - b).abs() <= EQUAL,
            (a, b) => a.is_none() == b.is_none(),
        };
        match (self, other) {
            (Value::Numbers(a), Value::Numbers(b)) => a.iter().zip(b).all(same),
            (Value::Text(a), Value::Text(b)) => a == b,
            _ => false,
        }
    }

    /// Rounded, so that numbers that are equal read alike.
    fn words(&self) -> String {
        let number = |value: &Option<f64>| match value {
            Some(value) => rounded(*value, 9).to_string(),
            None => "none".to_string(),
        };
        match self {
            Value::Numbers(values) => values.iter().map(number).collect::<Vec<_>>().join(", "),
            Value::Text(text) => text.clone(),
        }
    }
}

struct Entry {
    value: Value,
    /// Whether it is told where the other side does not have it, and where the two differ.
    alone: bool,
    differing: bool,
}

/// What tables hold, by table (empty = the whole memory) and item.
type Entries = BTreeMap<(String, Item), Entry>;

fn entries(tables: &Tables, others: &Tables, diagnosis: Option<&Disagreements>) -> Entries {
    match (tables, others) {
        (Tables::Siemens(own), Tables::Siemens(others)) => siemens(own, others, diagnosis),
        (Tables::Fanuc(own), Tables::Fanuc(_)) => fanuc(own, diagnosis),
        (Tables::Generic(own), Tables::Generic(_)) => generic(own, diagnosis),
        _ => Entries::new(),
    }
}

/// One table of a control: its parameters and values.
fn table(
    entries: &mut Entries,
    name: &str,
    fields: &[(&str, String)],
    values: &[Option<f64>],
    (alone, differing): (bool, bool),
) {
    let fields = fields
        .iter()
        .map(|(field, value)| (Item::Name((*field).to_string()), Value::Text(value.clone())));
    let values = (0_u32..).zip(values);
    let values = values.map(|(point, value)| (Item::Point(point), Value::Numbers(vec![*value])));
    entries.extend(fields.chain(values).map(|(item, value)| {
        let entry = Entry {
            value,
            alone,
            differing,
        };
        ((name.to_string(), item), entry)
    }));
}

fn grid_fields(grid: SiemensGrid, modulo: bool) -> Vec<(&'static str, String)> {
    let number = |value: f64| Value::Numbers(vec![Some(value)]).words();
    vec![
        ("MIN", number(grid.min)),
        ("STEP", number(grid.step)),
        ("MAX", number(grid.max)),
        ("IS_MODULO", u8::from(modulo).to_string()),
    ]
}

fn siemens(
    own: &SiemensTables,
    others: &SiemensTables,
    diagnosis: Option<&Disagreements>,
) -> Entries {
    let explained = |base: &str, output: &str| diagnosis.is_some_and(|d| d.explains(base, output));
    let mut entries = Entries::new();
    for lec in &own.lec {
        // A table of the other measuring system is told as such (`measuring_systems`).
        let other_system = |t: &LecTable| t.axis == lec.axis && t.encoder != lec.encoder;
        let told = !explained(&lec.axis, &lec.axis) && !others.lec.iter().any(other_system);
        let fields = grid_fields(lec.grid, lec.modulo);
        table(
            &mut entries,
            &lec_name(lec),
            &fields,
            &lec.values,
            (told, told),
        );
    }
    for cec in &own.cec {
        let (moving, output) = (&cec.input_axis, &cec.output_axis);
        let same = others.cec.iter().find(|t| t.number == cec.number);
        let is_known = |t: &CecTable| explained(&t.input_axis, &t.output_axis);
        let told = !explained(moving, output) && !same.is_some_and(is_known);
        let direction = match cec.direction {
            CecDirection::Both => "0",
            CecDirection::Plus => "1",
            CecDirection::Minus => "-1",
        };
        let mut fields = grid_fields(cec.grid, cec.modulo);
        fields.extend([
            ("DIRECTION", direction.to_string()),
            ("MULT_BY_TABLE", cec.multiply_by.to_string()),
        ]);
        let name = format!("CEC table {} ({output} while {moving} moves)", cec.number);
        table(&mut entries, &name, &fields, &cec.values, (true, told));
    }
    entries
}

/// A parameter of an axis acts on the terms of that axis; one without axis on cross terms.
fn fanuc(own: &FanucMemory, diagnosis: Option<&Disagreements>) -> Entries {
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
        let value = match value {
            ParameterValue::Integer(whole) => Value::Numbers(vec![Some(*whole as f64)]),
            ParameterValue::Real(real) => Value::Numbers(vec![Some(*real)]),
            bits @ ParameterValue::Bits(_) => Value::Text(bits.to_string()),
        };
        (Item::Name(key.to_string()), value, !explained(key))
    });
    let points = own.points.iter().map(|(point, value)| {
        let value = Value::Numbers(vec![Some(f64::from(*value))]);
        (Item::Point(*point), value, !points_are_explained)
    });
    let entry = |(item, value, differing): (Item, Value, bool)| {
        let alone = true;
        let entry = Entry {
            value,
            alone,
            differing,
        };
        ((String::new(), item), entry)
    };
    parameters.chain(points).map(entry).collect()
}

fn generic(own: &GenericTable, diagnosis: Option<&Disagreements>) -> Entries {
    let entry = |row: &crate::control::table::generic::GenericRow| {
        let (base, output) = (&row.base_axis, &row.output_axis);
        let told = !diagnosis.is_some_and(|d| d.explains(base, output));
        let way = row
            .direction
            .map_or(String::new(), |way| format!(" in {way}"));
        let block = format!("{} ({output} while {base} moves{way})", row.term);
        let numbers = [row.position_mm, row.deviation_um, row.correction_um].map(Some);
        let value = Value::Numbers([&numbers[..], &[row.increment_um]].concat());
        let entry = Entry {
            value,
            alone: told,
            differing: told,
        };
        ((block, Item::Point(row.index)), entry)
    };
    own.rows.iter().map(entry).collect()
}

/// One sentence for what is surplus of a table, missing, and other; with `all` also the latter two.
fn differences(wanted: &Entries, found: &Entries, all: bool) -> Vec<String> {
    let surplus = found
        .iter()
        .filter(|(key, e)| e.alone && !wanted.contains_key(key));
    let mut words = by_table(surplus.map(|(key, e)| (key, &e.value)), wanted, |them| {
        format!("the job does not write {them}")
    });
    if !all {
        return words;
    }
    let missing = wanted
        .iter()
        .filter(|(key, e)| e.differing && !found.contains_key(key));
    words.extend(by_table(
        missing.map(|(key, e)| (key, &e.value)),
        found,
        |them| format!("missing, the job writes {them}"),
    ));
    let differing = wanted.iter().filter_map(|(key, own)| {
        let got = found.get(key).filter(|got| !got.value.is(&own.value))?;
        (own.differing && got.differing).then_some((key, &got.value, &own.value))
    });
    let differing: Vec<_> = differing.collect();
    for same in differing.chunk_by(|((a, _), ..), ((b, _), ..)| a == b) {
        let named = same.iter().filter_map(|((_, item), got, own)| match item {
            Item::Name(name) => Some(format!(
                "{name} is {}, the job writes {}",
                got.words(),
                own.words()
            )),
            Item::Point(_) => None,
        });
        let mut said: Vec<String> = named.collect();
        let points = same.iter().filter_map(|((_, item), got, own)| match item {
            Item::Point(point) => Some((*point, (got, own))),
            Item::Name(_) => None,
        });
        let (points, values): (Vec<u32>, Vec<_>) = points.unzip();
        if let (Some(first), Some((got, own))) = (points.first(), values.first()) {
            let (points, got, own) = (runs(&points), got.words(), own.words());
            said.push(format!(
                "{points}: other values (point {first} is {got}, the job writes {own})"
            ));
        }
        let block = &same[0].0.0;
        let block = if block.is_empty() {
            String::new()
        } else {
            format!("{block}: ")
        };
        words.push(format!("{block}{}", said.join("; ")));
    }
    words
}

/// What only one side has: a whole table, or some of its items.
fn by_table<'a>(
    alone: impl Iterator<Item = (&'a (String, Item), &'a Value)>,
    others: &Entries,
    says: impl Fn(&str) -> String,
) -> Vec<String> {
    let alone: Vec<_> = alone.collect();
    let sentence = |same: &[(&(String, Item), &Value)]| {
        let block = &same[0].0.0;
        if !block.is_empty() && !others.keys().any(|(other, _)| other == block) {
            return format!("{block}: {}", says("it"));
        }
        let (mut names, mut points) = (Vec::new(), Vec::new());
        for ((_, item), value) in same {
            match item {
                Item::Name(name) => names.push(format!("{name} = {}", value.words())),
                Item::Point(point) => points.push(*point),
            }
        }
        let names = (!names.is_empty()).then(|| listed(&names));
        let points = (!points.is_empty()).then(|| runs(&points));
        let block = (!block.is_empty()).then(|| block.clone());
        let what: Vec<String> = block.into_iter().chain(points).chain(names).collect();
        format!("{}: {}", what.join(", "), says(it(same.len())))
    };
    let tables = alone.chunk_by(|((a, _), _), ((b, _), _)| a == b);
    tables.map(sentence).collect()
}

/// Ascending numbers as `point 7` or `points 3, 1200 to 1205`.
fn runs(numbers: &[u32]) -> String {
    let runs: Vec<String> = numbers
        .chunk_by(|a, b| a + 1 == *b)
        .map(|run| match run {
            [one] => one.to_string(),
            run => format!("{} to {}", run[0], run[run.len() - 1]),
        })
        .collect();
    let word = if numbers.len() == 1 {
        "point"
    } else {
        "points"
    };
    format!("{word} {}", listed(&runs))
}
