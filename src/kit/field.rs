//! The field kit: sign proofs, rollback and checklist, made and read back (docs/field-kit.md).
//!
//! ```text
//!   sign_proof ─→ emit ─→ BYTES ─→ readback ─→ emulate ─→ what a gauge has to show ─┐
//!   read-out   ─→ emit ─→ BYTES ─→ readback ─→ equal? ──────────────────────────────┼→ checklist
//!   control with the real tables ─→ largest movement of each axis (movement) ───────┘
//! ```

mod head;
mod lists;
mod movement;
mod reading;

use super::rollback;
use super::{Inputs, cannot_emulate, emulator};
use crate::axis::{Axis, Direction};
use crate::checklist::{KitFacts, parts};
use crate::compensation::siemens::reference_text;
use crate::compensation::{Compiled, uses};
use crate::controller::checklist::List;
use crate::controller::{Mechanism, Role};
use crate::emit::{self, Context, Instead, RenderedFile, Templates};
use crate::emulate::{CannotEmulate, Emulator};
use crate::forecast::Verdict;
use crate::plan::{Plan, Task, axis_pairs};
use crate::problem::{Problem, Problems};
use crate::readback::kit::{KitFile, ReadBack, read_apart};
use crate::sign_proof::{SignProof, SignProofs, sign_fact, sign_proofs};
use crate::table::Tables;
use crate::table::siemens::LecTable;
use crate::units::Millimetres;
use serde_json::{Value, json};

/// What is written beside the tables of a kit.
pub(super) struct FieldKit {
    pub(super) files: Vec<RenderedFile>,
    /// What each sign proof has to show, for the manifest.
    pub(super) sign_proofs: Vec<Value>,
    /// Mechanisms without a sign proof, and a rollback that is not whole, one sentence each.
    pub(super) notes: Vec<String>,
}

/// What a field kit is made from.
pub(super) struct Made<'a> {
    pub(super) inputs: &'a Inputs,
    pub(super) plan: &'a Plan,
    pub(super) compiled: &'a Compiled,
    pub(super) context: &'a Context,
    pub(super) templates: &'a Templates,
    /// The files of the kit itself.
    pub(super) files: &'a [RenderedFile],
    /// What was read back from them.
    pub(super) read: &'a ReadBack,
    /// Forecast against the acceptance of the job.
    pub(super) verdict: Verdict,
    /// Why the measured errors are doubtful.
    pub(super) doubts: &'a [String],
}

impl Made<'_> {
    fn task(&self) -> Task<'_> {
        self.inputs.task()
    }

    /// `X (AX1)`, or `X (AX1 and AX4)` for a gantry.
    fn axes(&self, axis: Axis) -> String {
        format!("{axis} ({})", self.plan.names[axis].join(" and "))
    }
}

/// A sign proof with what its bytes do.
struct Shown {
    proof: SignProof,
    paths: Vec<String>,
    /// How the axis stands at the peak, less how it stands where the bump begins, µm.
    shown_um: f64,
}

/// Makes the field kit; refused unless every file reads back to what was meant.
pub(super) fn make(made: &Made<'_>) -> Result<FieldKit, Problems> {
    let SignProofs { proofs, missing } = sign_proofs(made.task(), made.plan, made.compiled);
    let mut files = Vec::new();
    let shown = prove(made, proofs, &mut files)?;
    let mut not_written = missing.clone();
    let rollback = rollback::make(made)?;
    let notes = [missing, rollback.note().into_iter().collect()].concat();
    files.extend(rollback.files);
    not_written.extend(rollback.not_written);
    let movement = movement::movement(made).map_err(|reason| cannot_emulate(&reason))?;
    let lists = |list: List| match list {
        List::Places => lists::places(made),
        List::Preconditions => lists::preconditions(made.compiled),
        List::Movement => movement.clone(),
        List::SignProofs => shown.iter().flat_map(|s| reading::items(made, s)).collect(),
        List::Display => lists::display(made),
        List::NotWritten => not_written.clone(),
        List::WayBack => rollback.by_hand.clone(),
    };
    let (task, compiled) = (made.task(), made.compiled);
    let facts = KitFacts {
        files: made
            .files
            .iter()
            .chain(&files)
            .map(|file| (file.role, file.path.clone()))
            .collect(),
        reference: reference_text(task),
        uses: &|mechanism| uses(task, made.plan, &compiled.tables, mechanism),
        list: &lists,
    };
    let parts = parts(&task.profile.checklist, &facts);
    let sign_proofs = shown.iter().map(document).collect();
    files.extend(emit::render_checklist(
        task,
        made.templates,
        made.context,
        &head::lines(made),
        &parts,
    )?);
    Ok(FieldKit {
        files,
        sign_proofs,
        notes,
    })
}

/// A file as the readers take it.
pub(super) fn as_kit_file(file: &RenderedFile) -> KitFile<'_> {
    KitFile {
        path: &file.path,
        role: file.role,
        bytes: &file.bytes,
    }
}

/// Writes the proofs, reads each back through its own reader, and asks the emulator what they do.
fn prove(
    made: &Made<'_>,
    proofs: Vec<SignProof>,
    files: &mut Vec<RenderedFile>,
) -> Result<Vec<Shown>, Problems> {
    let mut written = Vec::new();
    let mut state = made.read.tables.clone();
    for proof in proofs {
        let own = proof_files(made, &proof)?;
        if own.is_empty() {
            continue; // a profile of one's own without a file for it
        }
        let tables = read_proof(made, &own)?.tables;
        if tables != proof.tables {
            return Err(shows_otherwise("they hold other tables than were meant"));
        }
        load(&mut state, tables);
        written.push((
            proof,
            own.iter().map(|f| f.path.clone()).collect::<Vec<_>>(),
        ));
        files.extend(own);
    }
    if written.is_empty() {
        return Ok(Vec::new());
    }
    let control = emulator(&made.inputs.profile, &state, &made.compiled.state)
        .map_err(|reason| shows_otherwise(&reason.0))?;
    let shown = |(proof, paths)| {
        let shown_um = shown_um(made.plan, control.as_ref(), &proof)
            .map_err(|reason| shows_otherwise(&reason.0))?;
        Ok(Shown {
            proof,
            paths,
            shown_um,
        })
    };
    written.into_iter().map(shown).collect()
}

fn proof_files(made: &Made<'_>, proof: &SignProof) -> Result<Vec<RenderedFile>, Problems> {
    let instead = Instead {
        notice: "SIGN PROOF: zero but for one bump; load the table of the kit again after it",
        names_terms: true,
        ..Instead::default()
    };
    let wanted = Some(proof.mechanism);
    emit::render_apart(
        made.task(),
        made.templates,
        made.compiled,
        &proof.tables,
        &instead,
        |file| file.role == Role::SignProof && file.mechanism == wanted,
    )
}

fn read_proof(made: &Made<'_>, files: &[RenderedFile]) -> Result<ReadBack, Problems> {
    let files: Vec<KitFile<'_>> = files.iter().map(as_kit_file).collect();
    let read = read_apart(&made.inputs.profile, &files, Role::SignProof)?;
    match read.machine_data.iter().find(|file| !file.data.is_empty()) {
        Some(file) => Err(shows_otherwise(&format!(
            "`{}` sets machine data",
            file.path
        ))),
        None => Ok(read),
    }
}

fn shows_otherwise(why: &str) -> Problems {
    Problem::new(format!(
        "the files of the sign proof do not do what was meant, so nothing is written: {why}"
    ))
    .help("a template of your own has to keep to the format of the dialect (docs/templates.md)")
    .into()
}

/// What the control holds once a file that stands apart is loaded: tables and points of the same
/// number are replaced, everything else stays.
fn load(state: &mut Tables, file: Tables) {
    match (state, file) {
        (Tables::Siemens(state), Tables::Siemens(file)) => {
            for table in file.lec {
                let is_other = |t: &LecTable| (t.encoder, &t.axis) != (table.encoder, &table.axis);
                state.lec.retain(is_other);
                state.lec.push(table);
            }
            for table in file.cec {
                state.cec.retain(|t| t.number != table.number);
                state.cec.push(table);
            }
        }
        (Tables::Fanuc(state), Tables::Fanuc(file)) => {
            state.parameters.extend(file.parameters);
            state.points.extend(file.points);
        }
        _ => {}
    }
}

/// The same in both directions and on every physical axis, and nothing beside the bump.
fn shown_um(plan: &Plan, control: &dyn Emulator, proof: &SignProof) -> Result<f64, CannotEmulate> {
    // The grid of an inch control is rounded to its last digit, 0.03 µm beside the place asked for;
    // on the slope of a bump that is less than a nanometre.
    const EQUAL_UM: f64 = 1e-3;
    let [from, peak, to] = proof.bump.places();
    let mut shown = Vec::new();
    for (base, output) in axis_pairs(&plan.names, proof.term) {
        for direction in Direction::BOTH {
            let response = control.response(base, output, direction)?;
            let at = |place: Millimetres| response.correction(place).um();
            if (at(from) - at(to)).abs() > EQUAL_UM {
                return Err(CannotEmulate(
                    "the bump does not come back to zero".to_string(),
                ));
            }
            shown.push(at(peak) - at(from));
        }
    }
    match shown.first() {
        Some(first) if shown.iter().all(|um| (um - first).abs() <= EQUAL_UM) => Ok(*first),
        _ => Err(CannotEmulate(
            "the bump is not the same in both directions".to_string(),
        )),
    }
}

fn document(shown: &Shown) -> Value {
    let proof = &shown.proof;
    let [from, peak, to] = proof.bump.places().map(|place| place.mm());
    let round = crate::manifest::picometres;
    json!({
        "files": shown.paths,
        "sign": sign_fact(proof.mechanism),
        "term": proof.term.to_string(),
        "from_mm": from,
        "peak_mm": peak,
        "to_mm": to,
        "shows_um": round(shown.shown_um),
        "other_sign_um": round(-shown.shown_um),
    })
}

/// How the files of a directory that stand apart differ from those of the job, one sentence each.
pub(super) fn differences(
    inputs: &Inputs,
    plan: &Plan,
    compiled: &Compiled,
    files: &[KitFile<'_>],
) -> Result<Vec<String>, Problems> {
    let mut words = Vec::new();
    if files.iter().any(|file| file.role == Role::SignProof) {
        let wanted = sign_proofs(inputs.task(), plan, compiled).proofs;
        for file in files.iter().filter(|file| file.role == Role::SignProof) {
            let read = read_apart(&inputs.profile, &[*file], Role::SignProof)?;
            let proof = proof_of(inputs, &wanted, file.path);
            if proof.is_none_or(|p| p.tables != read.tables) || sets_machine_data(&read) {
                words.push(format!(
                    "`{}` is not the sign proof of this job: it holds other values",
                    file.path
                ));
            }
        }
    }
    words.extend(rollback::differences(inputs, plan, compiled, files)?);
    Ok(words)
}

fn sets_machine_data(read: &ReadBack) -> bool {
    read.machine_data.iter().any(|file| !file.data.is_empty())
}

fn proof_of<'a>(inputs: &Inputs, proofs: &'a [SignProof], path: &str) -> Option<&'a SignProof> {
    let mut files = inputs.profile.files.iter();
    let known = files.find(|file| file.path.eq_ignore_ascii_case(path))?;
    let mechanism: Mechanism = known.mechanism?;
    proofs.iter().find(|proof| proof.mechanism == mechanism)
}
