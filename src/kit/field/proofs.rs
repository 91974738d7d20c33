//! Sign proofs as files: written, read back, and what their bytes do on the control; and what a person
//! reads: the difference of two places, with and without compensation.
//!
//! A laser loses its beam when the other axes go to the reference point, and on Fanuc the power goes
//! off between the two states. So the reading is one of two places in **one** state, which needs no
//! common zero of both: (peak − start) with compensation, less (peak − start) without.

use crate::control::checklist::ListText;
use crate::control::controller::{Evidence, KitFile, Role, Statement};
use crate::kit::loaded::BareKit;
use crate::kit::refusals;
use crate::quantity::{Axis, Direction, ErrorTerm, Millimetres};
use crate::read::emulate::{CannotEmulate, Emulated, Emulator};
use crate::read::{ReadBack, emulator, read_apart};
use crate::text::{BLANK, Finding, Problems, joined};
use crate::write::compensation::{Compiled, trimmed};
use crate::write::emit::{self, FileSource};
use crate::write::plan::{Plan, Task, axis_pairs};
use crate::write::sign_proof::{SignProof, SignProofs, sign_proofs};
use serde::Serialize;

/// The sign proofs of a kit, read back to what was meant.
pub(super) struct Proofs {
    pub(super) shown: Vec<ProofFigures>,
    pub(super) files: Vec<KitFile>,
    /// Mechanisms without a sign proof.
    pub(super) missing: Vec<Finding>,
}

/// A sign proof with what its bytes do, as the manifest has it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProofFigures {
    #[serde(skip)]
    proof: SignProof,
    files: Vec<String>,
    sign: &'static str,
    term: ErrorTerm,
    from_mm: Millimetres,
    peak_mm: Millimetres,
    to_mm: Millimetres,
    /// How the axis stands at the peak, less how it stands where the bump begins.
    shows_um: f64,
    other_sign_um: f64,
}

impl Proofs {
    /// Writes the proofs and reads each back through its own reader; what the emulated control does once they
    /// are loaded over the kit's own files.
    pub(super) fn of(made: &BareKit<'_>) -> Result<Proofs, Problems> {
        let profile = &made.inputs.profile;
        let SignProofs { proofs, missing } = sign_proofs(made.task(), &made.plan, &made.compiled);
        let mut loaded = made.compiled.tables.clone();
        let (mut written, mut files) = (Vec::new(), Vec::new());
        for proof in proofs {
            let own = files_of(made.task(), &made.compiled, &proof)?;
            if own.is_empty() {
                continue; // a profile of one's own without a file for it
            }
            let tables = read_proof(made, &own)?.tables;
            if tables != proof.tables {
                let why = "they hold other tables than were meant";
                return Err(refusals::other_proof(why).into());
            }
            loaded.load(tables);
            written.push((proof, own.iter().map(|file| file.path.clone()).collect::<Vec<_>>()));
            files.extend(own);
        }
        let control = emulator(profile, &loaded, &made.compiled.state)
            .map_err(|reason| refusals::other_proof(reason.0))?;
        let shown = written.into_iter().map(|(proof, files)| {
            let shows_um = shown_um(&made.plan, control.as_ref(), &proof)
                .map_err(|reason| refusals::other_proof(reason.0))?;
            let (sign, term) = (proof.of.sign_fact, proof.term);
            let [from_mm, peak_mm, to_mm] = proof.bump.places();
            let other_sign_um = -shows_um;
            Ok(ProofFigures {
                proof,
                files,
                sign,
                term,
                from_mm,
                peak_mm,
                to_mm,
                shows_um,
                other_sign_um,
            })
        });
        Ok(Proofs { shown: shown.collect::<Result<_, Problems>>()?, files, missing })
    }
}

pub(super) fn files_of(
    task: Task<'_>,
    compiled: &Compiled,
    proof: &SignProof,
) -> Result<Vec<KitFile>, Problems> {
    let slope = "SIGN PROOF: zero but for one slope; load the values of the kit again after it";
    let bump = "SIGN PROOF: zero but for one bump; load the table of the kit again after it";
    let notice = Some(if proof.bump.is_slope { slope } else { bump });
    let of_kit = FileSource::of_kit(task, compiled);
    let emitted = FileSource { tables: &proof.tables, notice, ..of_kit };
    let wanted = Some(proof.of.mechanism);
    emit::render_those(&emitted, |file| file.role == Role::SignProof && file.mechanism == wanted)
}

fn read_proof(made: &BareKit<'_>, files: &[KitFile]) -> Result<ReadBack, Problems> {
    let read = read_apart(&made.inputs.profile, files, Role::SignProof)?;
    match read.machine_data.iter().find(|file| !file.data.is_empty()) {
        Some(file) => {
            Err(refusals::other_proof(format!("`{}` sets machine data", file.path)).into())
        }
        None => Ok(read),
    }
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

/// What one proof is and what has to be seen; how it is read, and what that means.
pub(super) fn listed(made: &BareKit<'_>, shown: &[ProofFigures]) -> ListText {
    let mut all = ListText::default();
    for shown in shown {
        let beside = shown.proof.of.beside.map(str::to_string);
        all.items.extend([shown.two_places(made), shown.expected(made)]);
        all.items.extend(beside);
        all.items.push(format!("seen: {BLANK} µm"));
        all.notes.extend([
            shown.bump(made),
            shown.with_a_gauge(made),
            shown.sign(made),
            shown.other_way_round(),
        ]);
    }
    all
}

impl ProofFigures {
    /// Where the bump begins, is highest and ends, and the unit of the control that this is in.
    fn places(&self, made: &BareKit<'_>) -> ([String; 3], &'static str) {
        let unit = made.inputs.job.compensation.control_unit;
        let text = |place: Millimetres| trimmed(place.mm() / unit.in_mm(), 6);
        ([self.from_mm, self.peak_mm, self.to_mm].map(text), unit.word())
    }

    /// What is proved, and by which files.
    fn heading(&self) -> String {
        let files = joined(self.files.iter().map(|path| format!("`{path}`")));
        format!("{}, {files}", self.proof.of.name)
    }

    fn bump(&self, made: &BareKit<'_>) -> String {
        let (term, ([from, peak, to], unit)) = (self.term, self.places(made));
        let (heading, along) = (self.heading(), made.axes(term.along));
        match self.proof.bump.is_slope {
            true => format!(
                "{heading}: {term} is a straight line, zero at {along} = {from} {unit} and full at {peak} {unit}; everything else is zero"
            ),
            false => format!(
                "{heading}: the table of {term} holds one bump, zero up to {along} = {from} {unit}, full at {peak} {unit}, zero from {to} {unit} on; zero everywhere else. The place is the legal bump that is highest and narrowest, nearest to the middle of the travel"
            ),
        }
    }

    fn two_places(&self, made: &BareKit<'_>) -> String {
        let (term, ([from, peak, _], unit)) = (self.term, self.places(made));
        let (moving, seen) = (made.axes(term.along), made.axes(term.of));
        format!(
            "{}: read the laser or gauge that looks at {seen} (tool against workpiece, positive towards +{}) with {moving} at {from} {unit} and at {peak} {unit}, moving the same way to both, from {from} towards {peak} {unit}; once with the compensation off, once with it on. Only the difference of the two places counts: between off and on a laser may lose its beam and start from zero again, between the two places not",
            self.heading(),
            term.of
        )
    }

    fn expected(&self, made: &BareKit<'_>) -> String {
        let ([from, peak, to], unit) = self.places(made);
        let behind = match self.proof.bump.is_slope {
            true => String::new(),
            false => format!(" With {to} {unit} in place of {peak} {unit}: 0"),
        };
        format!(
            "**(reading at {peak} {unit} − reading at {from} {unit}) with the compensation on, less the same with it off: {} if the sign is {}; {} if it is the other way round.**{behind}",
            signed(self.shows_um),
            self.as_known(made),
            signed(-self.shows_um),
        )
    }

    /// A gauge that is not moved needs one place where nothing is found anew between off and on.
    fn with_a_gauge(&self, made: &BareKit<'_>) -> String {
        let (of, ([from, peak, _], unit)) = (self.term.of, self.places(made));
        match made.inputs.profile.family.restarts {
        false => format!(
            "a dial gauge that stays where it is needs {peak} {unit} only: zero with the compensation off, read with it on, coming from {from} {unit} both times: {}, or {} if the sign is the other way round. Nothing else may have been moved or have warmed up",
            towards(self.shows_um, of),
            towards(-self.shows_um, of),
        ),
        true => "a dial gauge stays where it is between off and on and is not set again; where one cannot reach both places, put one at each. One place alone proves nothing: off and on need not have a common zero".to_string(),
    }
    }

    /// What is known of the sign.
    fn known<'a>(&self, made: &'a BareKit<'_>) -> impl Iterator<Item = &'a Statement> {
        let sign = self.sign;
        made.inputs.profile.statements.iter().filter(move |s| s.fact == sign)
    }

    fn sign(&self, made: &BareKit<'_>) -> String {
        let known = self.known(made);
        let known = known
            .map(|s| format!("`{}` = {}, {}: {}", s.fact, s.value, s.evidence.word(), s.source));
        format!("the sign: {}", known.collect::<Vec<_>>().join("; "))
    }

    fn as_known(&self, made: &BareKit<'_>) -> &'static str {
        match self.known(made).next().map(|s| s.evidence) {
            None | Some(Evidence::Assumed) => "as assumed",
            Some(Evidence::Manual) => "as the manual says",
            Some(Evidence::Executed) => "as seen on a control",
        }
    }

    fn other_way_round(&self) -> String {
        format!(
            "the other way round, or nothing: take the bump off (switch the compensation off, then \"Rollback\") and load no table. Other sign: turn `{}` in a profile of your own (docs/own-control.md section 4) and generate again; nothing: see the preconditions, options and reference",
            self.sign
        )
    }
}

/// `−20.0 µm`
fn signed(um: f64) -> String {
    let sign = if um < 0.0 { "−" } else { "+" };
    format!("{sign}{:.1} µm", um.abs())
}

/// `20.0 µm towards −X`
fn towards(um: f64, axis: Axis) -> String {
    let side = if um > 0.0 { "+" } else { "−" };
    format!("{:.1} µm towards {side}{axis}", um.abs())
}
