//! Files that were read out of the control: what concerns the job's axes, through the readers.

use super::{ActiveControl, Held, Origin, Others, backlash_of, problem, stated};
use crate::axis::PerAxis;
use crate::claims::Assumption;
use crate::controller::{Dialect, LengthUnit, Profile, Role};
use crate::job::Job;
use crate::plan::axis_names;
use crate::problem::{Problem, Problems};
use crate::readback::generic;
use crate::table::Tables;

/// What the reader of a dialect found.
pub(super) struct Found {
    /// What acted on the job's axes.
    pub(super) tables: Tables,
    /// What the files hold.
    pub(super) held: Held,
    pub(super) backlash_um: PerAxis<Option<f64>>,
    pub(super) others: Others,
    pub(super) assumptions: Vec<Assumption>,
    pub(super) notes: Vec<String>,
    /// Unit of the control, where a file holds it.
    pub(super) unit: Option<LengthUnit>,
}

/// A file as text.
pub(super) type Text<'a> = (&'a str, &'a str);

/// Sign proofs, rollbacks and checklists of a kit, by their names.
fn stands_apart(profile: &Profile, name: &str) -> bool {
    let apart = |role: Role| role.stands_apart() || role == Role::Checklist;
    let mut own = profile.files.iter().filter(|file| apart(file.role));
    let name = name.rsplit(['/', '\\']).next().unwrap_or(name);
    own.any(|file| file.path.eq_ignore_ascii_case(name))
}

/// Reads files of the control: tables, parameters, archives.
pub fn from_read_out(
    job: &Job,
    profile: &Profile,
    path: &str,
    files: Vec<(String, Vec<u8>)>,
) -> Result<ActiveControl, Problems> {
    let names = axis_names(job, profile)?;
    let mut problems = Problems::none();
    let mut texts: Vec<Text<'_>> = Vec::new();
    for (name, bytes) in &files {
        if stands_apart(profile, name) {
            problems.push(
                Problem::new(format!(
                    "`{name}` of `{path}` is a file of a kit that is not loaded with its tables, so it does not tell what was active"
                ))
                .help("name the whole kit with its manifest.json, or files that were read out of the control"),
            );
        }
        match std::str::from_utf8(bytes) {
            Ok(text) => texts.push((name, text)),
            Err(_) => problems.push(
                Problem::new(format!("`{name}` is not text"))
                    .help("name the files that the control wrote as text"),
            ),
        }
    }
    problems.or_ok(())?;
    let mut problems = Problems::none();
    let found = match &profile.dialect {
        Dialect::Siemens(_) => super::siemens::read(job, &names, &texts)?,
        Dialect::Fanuc(facts) => super::fanuc::read(job, &names, facts, &texts)?,
        Dialect::Generic(_) => generic_tables(&texts)?,
    };
    let own = job.compensation.control_unit;
    if let Some(unit) = found.unit.filter(|unit| *unit != own) {
        problems.push(problem(
            job,
            format!(
                "the control that was read out counts in {}, the job in {}",
                unit.word(),
                own.word()
            ),
            "correct `control_unit`",
        ));
    }
    let backlash_um = backlash_of(job, &found.backlash_um, &mut problems);
    let state = stated(job, profile, &backlash_um)?;
    problems.or_ok(ActiveControl {
        tables: found.tables,
        state,
        path: path.to_string(),
        origin: Origin::ReadOut(found.held),
        backlash_um,
        others: found.others,
        assumptions: found.assumptions,
        notes: found.notes,
        files,
    })
}

fn generic_tables(texts: &[Text<'_>]) -> Result<Found, Problems> {
    let mut problems = Problems::none();
    let mut tables = Vec::new();
    for (name, text) in texts {
        tables.extend(problems.take(generic::read(name, text)));
    }
    let tables = Tables::Generic(generic::merge(problems.or_ok(tables)?)?);
    Ok(Found {
        held: Held::plain(tables.clone()),
        tables,
        backlash_um: PerAxis::default(),
        others: Others::default(),
        assumptions: Vec::new(),
        notes: Vec::new(),
        unit: None,
    })
}
