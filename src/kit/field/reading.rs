//! What a person reads of a sign proof: the difference of two places, with and without compensation.
//!
//! A laser loses its beam when the other axes go to the reference point, and on Fanuc the power goes
//! off between the two states. So the reading is one of two places in **one** state, which needs no
//! common zero of both: (peak − start) with compensation, less (peak − start) without.

use super::proofs::Shown;
use crate::control::checklist::Listed;
use crate::control::controller::Evidence;
use crate::kit::made::Made;
use crate::quantity::axis::Axis;
use crate::text::html::BLANK;
use crate::write::compensation::trimmed;

/// What one proof is and what has to be seen; how it is read, and what that means.
pub(super) fn listed(made: &Made<'_>, shown: &[Shown]) -> Listed {
    let mut all = Listed::default();
    for shown in shown {
        let beside = shown.proof.of.beside.map(str::to_string);
        all.items.extend([two_places(made, shown), expected(made, shown)]);
        all.items.extend(beside);
        all.items.push(format!("seen: {BLANK} µm"));
        all.notes.extend([
            bump(made, shown),
            with_a_gauge(made, shown),
            sign(made, shown),
            other_way_round(shown),
        ]);
    }
    all
}

/// Where the bump begins, is highest and ends, mm.
fn places(shown: &Shown) -> [String; 3] {
    shown.proof.bump.places().map(|place| trimmed(place.mm(), 6))
}

fn bump(made: &Made<'_>, shown: &Shown) -> String {
    let (proof, [from, peak, to]) = (&shown.proof, places(shown));
    let files: Vec<String> = shown.paths.iter().map(|path| format!("`{path}`")).collect();
    if proof.bump.is_slope {
        let (name, term) = (proof.of.name, proof.term);
        let (files, along) = (files.join(", "), made.axes(term.along));
        return format!(
            "{name}, {files}: {term} is a straight line, zero at {along} = {from} mm and full at {peak} mm; everything else is zero"
        );
    }
    format!(
        "{}, {}: the table of {} holds one bump, zero up to {} = {from} mm, full at {peak} mm, zero from {to} mm on; zero everywhere else. The place is the legal bump that is highest and narrowest, nearest to the middle of the travel",
        proof.of.name,
        files.join(", "),
        proof.term,
        made.axes(proof.term.along),
    )
}

fn two_places(made: &Made<'_>, shown: &Shown) -> String {
    let (term, [from, peak, _]) = (shown.proof.term, places(shown));
    let (moving, seen) = (made.axes(term.along), made.axes(term.of));
    let files: Vec<String> = shown.paths.iter().map(|path| format!("`{path}`")).collect();
    format!(
        "{}, {}: read the laser or gauge that looks at {seen} (tool against workpiece, positive towards +{}) with {moving} at {from} mm and at {peak} mm, moving the same way to both, from {from} towards {peak} mm; once with the compensation off, once with it on. Only the difference of the two places counts: between off and on a laser may lose its beam and start from zero again, between the two places not",
        shown.proof.of.name,
        files.join(", "),
        term.of
    )
}

fn expected(made: &Made<'_>, shown: &Shown) -> String {
    let [from, peak, to] = places(shown);
    let behind = match shown.proof.bump.is_slope {
        true => String::new(),
        false => format!(" With {to} mm in place of {peak} mm: 0"),
    };
    format!(
        "**(reading at {peak} mm − reading at {from} mm) with the compensation on, less the same with it off: {} if the sign is {}; {} if it is the other way round.**{behind}",
        signed(shown.shown_um),
        as_known(evidence(made, shown)),
        signed(-shown.shown_um),
    )
}

/// A gauge that is not moved needs one place where nothing is found anew between off and on.
fn with_a_gauge(made: &Made<'_>, shown: &Shown) -> String {
    let (of, [from, peak, _]) = (shown.proof.term.of, places(shown));
    match made.inputs.profile.family.restarts {
        false => format!(
            "a dial gauge that stays where it is needs {peak} mm only: zero with the compensation off, read with it on, coming from {from} mm both times: {}, or {} if the sign is the other way round. Nothing else may have been moved or have warmed up",
            towards(shown.shown_um, of),
            towards(-shown.shown_um, of),
        ),
        true => "a dial gauge stays where it is between off and on and is not set again; where one cannot reach both places, put one at each. One place alone proves nothing: off and on need not have a common zero".to_string(),
    }
}

fn sign(made: &Made<'_>, shown: &Shown) -> String {
    let fact = shown.proof.of.sign_fact;
    let statements = made.inputs.profile.statements.iter();
    let known = statements.filter(|s| s.fact == fact);
    let known =
        known.map(|s| format!("`{fact}` = {}, {}: {}", s.value, s.evidence.word(), s.source));
    format!("the sign: {}", known.collect::<Vec<_>>().join("; "))
}

fn evidence(made: &Made<'_>, shown: &Shown) -> Evidence {
    let fact = shown.proof.of.sign_fact;
    let mut statements = made.inputs.profile.statements.iter();
    let known = statements.find(|s| s.fact == fact);
    known.map_or(Evidence::Assumed, |s| s.evidence)
}

fn as_known(evidence: Evidence) -> &'static str {
    match evidence {
        Evidence::Assumed => "as assumed",
        Evidence::Manual => "as the manual says",
        Evidence::Executed => "as seen on a control",
    }
}

fn other_way_round(shown: &Shown) -> String {
    format!(
        "the other way round, or nothing: take the bump off (switch the compensation off, then \"Rollback\") and load no table. Other sign: turn `{}` in a profile of your own (docs/controllers.md section 4) and generate again; nothing: see the preconditions, options and reference",
        shown.proof.of.sign_fact
    )
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
