//! Sign proofs as files: written, read back, and what their bytes do on the control.

use crate::control::controller::Role;
use crate::kit::made::{Made, as_kit_file};
use crate::quantity::axis::Direction;
use crate::quantity::units::Millimetres;
use crate::read::emulate::{CannotEmulate, Emulated, Emulator};
use crate::read::{KitFile, ReadBack, emulator, load, read_apart};
use crate::text::finding::Finding;
use crate::text::problem::{Problem, Problems};
use crate::write::emit::{self, Emitted, Instead, RenderedFile};
use crate::write::plan::{Plan, axis_pairs};
use crate::write::sign_proof::{SignProof, SignProofs, sign_proofs};
use serde_json::{Value, json};

/// The sign proofs of a kit, read back to what was meant.
pub(super) struct Proofs {
    /// As they were read from their files, each with the names of these.
    written: Vec<(SignProof, Vec<String>)>,
    pub(super) files: Vec<RenderedFile>,
    /// Mechanisms without a sign proof.
    pub(super) missing: Vec<Finding>,
}

/// A sign proof with what its bytes do.
pub(super) struct Shown {
    pub(super) proof: SignProof,
    pub(super) paths: Vec<String>,
    /// How the axis stands at the peak, less how it stands where the bump begins, µm.
    pub(super) shown_um: f64,
}

impl Proofs {
    /// Writes the proofs and reads each back through its own reader.
    pub(super) fn write(made: &Made<'_>) -> Result<Proofs, Problems> {
        let SignProofs { proofs, missing } = sign_proofs(made.task(), &made.plan, &made.compiled);
        let (mut written, mut files) = (Vec::new(), Vec::new());
        for proof in proofs {
            let own = proof_files(made, &proof)?;
            if own.is_empty() {
                continue; // a profile of one's own without a file for it
            }
            let tables = read_proof(made, &own)?.tables;
            if tables != proof.tables {
                return Err(shows_otherwise("they hold other tables than were meant"));
            }
            let paths = own.iter().map(|file| file.path.clone()).collect();
            written.push((SignProof { tables, ..proof }, paths));
            files.extend(own);
        }
        Ok(Proofs { written, files, missing })
    }

    /// What the emulated control does once they are loaded over the kit's own files.
    pub(super) fn shown(&self, made: &Made<'_>) -> Result<Vec<Shown>, Problems> {
        if self.written.is_empty() {
            return Ok(Vec::new());
        }
        let mut state = made.read.tables.clone();
        for (proof, _) in &self.written {
            load(&made.inputs.profile, &mut state, proof.tables.clone());
        }
        let control = emulator(&made.inputs.profile, &state, &made.compiled.state)
            .map_err(|reason| shows_otherwise(&reason.0))?;
        let shown = |(proof, paths): &(SignProof, Vec<String>)| {
            let shown_um = shown_um(&made.plan, control.as_ref(), proof)
                .map_err(|reason| shows_otherwise(&reason.0))?;
            Ok(Shown { proof: proof.clone(), paths: paths.clone(), shown_um })
        };
        self.written.iter().map(shown).collect()
    }
}

fn proof_files(made: &Made<'_>, proof: &SignProof) -> Result<Vec<RenderedFile>, Problems> {
    let slope = "SIGN PROOF: zero but for one slope; load the values of the kit again after it";
    let bump = "SIGN PROOF: zero but for one bump; load the table of the kit again after it";
    let instead =
        Instead { notice: if proof.bump.is_slope { slope } else { bump }, ..Instead::of_kit() };
    let wanted = Some(proof.of.mechanism);
    let emitted = Emitted {
        task: made.task(),
        compiled: &made.compiled,
        tables: &proof.tables,
        instead: &instead,
    };
    emit::render_those(&made.templates, &emitted, |file| {
        file.role == Role::SignProof && file.mechanism == wanted
    })
}

fn read_proof(made: &Made<'_>, files: &[RenderedFile]) -> Result<ReadBack, Problems> {
    let files: Vec<KitFile<'_>> = files.iter().map(as_kit_file).collect();
    let read = read_apart(&made.inputs.profile, &files, Role::SignProof)?;
    match read.machine_data.iter().find(|file| !file.data.is_empty()) {
        Some(file) => Err(shows_otherwise(&format!("`{}` sets machine data", file.path))),
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

/// The same in both directions and on every physical axis, and nothing beside the bump.
fn shown_um(plan: &Plan, control: &dyn Emulator, proof: &SignProof) -> Emulated<f64> {
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
                return Err(CannotEmulate("the bump does not come back to zero".to_string()));
            }
            shown.push(at(peak) - at(from));
        }
    }
    match shown.first() {
        Some(first) if shown.iter().all(|um| (um - first).abs() <= EQUAL_UM) => Ok(*first),
        _ => Err(CannotEmulate("the bump is not the same in both directions".to_string())),
    }
}

pub(super) fn document(shown: &Shown) -> Value {
    let proof = &shown.proof;
    let [from, peak, to] = proof.bump.places().map(|place| place.mm());
    let round = crate::quantity::units::picometres;
    json!({
        "files": shown.paths,
        "sign": proof.of.sign_fact,
        "term": proof.term.to_string(),
        "from_mm": from,
        "peak_mm": peak,
        "to_mm": to,
        "shows_um": round(shown.shown_um),
        "other_sign_um": round(-shown.shown_um),
    })
}
