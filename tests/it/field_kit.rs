//! The field kit: sign proofs, a rollback to what was read out, what the checklist says, what is refused.
use crate::support::machine::machine;
use crate::support::{self, *};
use nonius::control::controller::{Dialect, Evidence, Profile, Role, builtin};
use nonius::control::table::Tables;
use nonius::inputs::job::ActiveTables;
use nonius::judge::active::{Origin, ReadOutFor, from_read_out};
use nonius::kit::findings::FieldFault;
use nonius::kit::{self, Inputs, Kit};
use nonius::quantity::{Direction, ErrorTerm};
use nonius::read::emulate::{Emulator, Response};
use nonius::read::read_apart;
use nonius::text::Finding;
use nonius::write::findings::TableFinding;
use nonius::write::plan::axis_pairs;
use serde_json::Value;

/// Places of an inch control are rounded to its last digit; less than a nanometre on a bump.
const DUST_UM: f64 = 1e-3;
const TWO_TABLES: &str = "backlash = \"two-tables\"\n";
const PARAMETER: &str = "curve-and-parameter";

#[track_caller]
fn kit_with(profile: &str, old: &str, new: &str) -> Kit {
    let (job, errors) = five_points(profile);
    support::generate(&replaced(&job, old, new), &errors).1
}

/// The control after the kit's parameters and all sign proofs were loaded, as `profile` reads them.
fn proving(profile: &Profile, kit: &Kit) -> Box<dyn Emulator> {
    let proof = read_apart(profile, &files_of(kit, Role::SignProof), Role::SignProof).unwrap();
    let tables = match (support::loaded(profile, kit), proof.tables) {
        (Tables::Fanuc(mut memory), Tables::Fanuc(proof)) => {
            memory.parameters.extend(proof.parameters);
            memory.points.extend(proof.points);
            Tables::Fanuc(memory)
        }
        (_, tables) => tables,
    };
    let made = kit::emulator(profile, &tables, &kit.compiled.state);
    made.unwrap_or_else(|reason| panic!("{}", reason.0))
}

fn proofs_of(kit: &Kit) -> Vec<Value> {
    kit.manifest.sign_proofs.iter().map(|proof| serde_json::to_value(proof).unwrap()).collect()
}

fn term_of(proof: &Value) -> ErrorTerm {
    support::term(proof["term"].as_str().unwrap())
}

/// `controls`: the one that the profile describes, and one that takes every sign the other way round.
fn ensure_legal(
    name: &str,
    inputs: &Inputs,
    kit: &Kit,
    proof: &Value,
    controls: &[Box<dyn Emulator>; 2],
) {
    let term = term_of(proof);
    let places = ["from_mm", "peak_mm", "to_mm"].map(|key| number(&proof[key]));
    let axis = inputs.job.machine.axes[term.along].unwrap();
    let spacing = kit.plan.grids[term.along].unwrap().spacing().mm();
    let shows = number(&proof["shows_um"]);
    assert!((5.0 - DUST_UM..=20.0 + DUST_UM).contains(&shows.abs()), "{name}: {shows} µm");
    assert!(shows < 0.0, "{name}: the control pulls back what it takes for too far");
    for place in places {
        let inside = axis.low.mm() - 1e-6 <= place && place <= axis.high.mm() + 1e-6;
        assert!(inside, "{name}: {place} mm is outside the travel");
        let away = (place - axis.reference.mm()).abs();
        assert!(away > spacing * (1.0 - 1e-6), "{name}: {place} mm is at the reference");
    }
    let limit = inputs.job.limits.max_slope_um_per_mm * spacing + DUST_UM;
    for (control, key) in controls.iter().zip(["shows_um", "other_sign_um"]) {
        for (base, output) in axis_pairs(&kit.plan.names, term) {
            for direction in Direction::BOTH {
                let response = support::response(control.as_ref(), base, output, direction);
                let [from, peak, to] = places.map(|place| um_at(&response, place));
                let height = peak - from;
                assert!((height - number(&proof[key])).abs() < DUST_UM, "{name}: {height}");
                assert!((to - from).abs() < DUST_UM, "{name}");
                let change = steepest(&response);
                assert!(change <= limit, "{name}: {change} µm in one section");
            }
        }
    }
}

/// µm from one point of a table to the next.
fn steepest(response: &Response) -> f64 {
    let nodes: Vec<f64> = response.tables()[0].nodes().map(|(_, c)| c.um()).collect();
    nodes.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max)
}

/// Nothing but the bumps: every other term is constant, and so is the term beside its bump.
fn ensure_zero_elsewhere(name: &str, kit: &Kit, proofs: &[Value], control: &dyn Emulator) {
    for planned in &kit.plan.tables {
        let (term, grid) = (planned.term, &planned.grid);
        let bump = proofs.iter().find(|proof| term_of(proof) == term);
        let bump = bump.map(|proof| (number(&proof["from_mm"]), number(&proof["to_mm"])));
        let direction = planned.direction.unwrap_or(Direction::Plus);
        for (base, output) in axis_pairs(&kit.plan.names, term) {
            let Ok(response) = control.response(base, output, direction) else { continue };
            let zero = um_at(&response, grid.reference.mm());
            for place in (grid.first..=grid.last).map(|index| grid.position(index).mm()) {
                let is_in = |(from, to)| from < place - 1e-6 && place + 1e-6 < to;
                let um = um_at(&response, place) - zero;
                let is_meant = bump.is_some_and(is_in) || um.abs() < DUST_UM;
                assert!(is_meant, "{name}: {term} at {place} mm: {um}");
            }
        }
    }
}

fn unproved(kit: &Kit) -> usize {
    let is_reason = |note: &&Finding| matches!(note.kind(), Some(TableFinding::NoSignProof { .. }));
    kit.compiled.notes.iter().filter(is_reason).count()
}

fn ensure_contract(id: &str) {
    let profile = builtin::profile(id).unwrap();
    let (machines, mut proved) = (short_or(10, 40), 0);
    for seed in 0..machines {
        let machine = machine(&profile, seed);
        let (inputs, kit) = support::generate(&machine.job, &machine.csv);
        let proofs = &proofs_of(&kit);
        let unproved = unproved(&kit);
        assert!(proofs.len() + unproved > 0, "{id} {seed}: neither a proof nor a reason");
        let names = proofs.iter().flat_map(|p| p["files"].as_array().unwrap());
        assert_eq!(names.count(), files_of(&kit, Role::SignProof).len());
        if proofs.is_empty() {
            continue;
        }
        let turned = support::with_signs_turned(&inputs.profile);
        let controls = [&inputs.profile, &turned].map(|profile| proving(profile, &kit));
        for proof in proofs {
            let name = format!("{id}, machine {seed}, {proof}");
            ensure_legal(&name, &inputs, &kit, proof, &controls);
            let sign = profile.statements.iter().find(|s| proof["sign"] == s.fact.as_str());
            let known = match sign.unwrap().evidence {
                Evidence::Assumed => "as assumed",
                Evidence::Manual => "as the manual says",
                Evidence::Executed => "as seen on a control",
            };
            let (shows, other) =
                (number(&proof["shows_um"]).abs(), number(&proof["other_sign_um"]));
            let words = format!("−{shows:.1} µm if the sign is {known}; +{other:.1} µm");
            let off = "with the compensation on, less the same with it off";
            holds(checklist(&kit), &[&format!("{off}: {words}")]);
            let gauge = format!("µm towards −{}, or", term_of(proof).of);
            let restarts = !id.starts_with("siemens") && id != "isg-volcomp";
            assert_eq!(checklist(&kit).contains(&gauge), !restarts, "{name}");
            proved += 1;
        }
        if unproved == 0 {
            ensure_zero_elsewhere(&format!("{id} {seed}"), &kit, proofs, controls[0].as_ref());
        }
    }
    assert!(proved > machines / 4, "{id}: only {proved} proofs");
}

/// A sheet of values has nothing to load, and a skew no bump.
#[test]
fn sign_proofs_are_legal_and_move_nothing_else() {
    let has_bump = |id: &&str| match builtin::profile(id).unwrap().dialect {
        Dialect::Declared(facts) => facts.factors.is_none() && facts.typed.is_none(),
        _ => true,
    };
    in_parallel(builtin::ids().into_iter().filter(has_bump), ensure_contract);
}

/// Last year's kit lies in the control: half the errors, and on Siemens its switches are on.
fn with_read_out(id: &str) -> (Inputs, Tables) {
    let (job, errors) = five_points(id);
    let job = job.replace("detection_unit", "parameter_3605 = \"00000001\"\ndetection_unit");
    let profile = builtin::profile(id).unwrap();
    let (_, before) = support::generate(&job, &replaced(&errors, "8,", "4,"));
    let tables = support::loaded(&profile, &before);
    let beside = if id.starts_with("fanuc") { Role::Parameters } else { Role::Enable };
    let files = before.files.iter().filter(|file| [Role::Table, beside].contains(&file.role));
    let files = files.map(|f| (f.path.clone(), f.bytes.clone())).collect();
    let mut inputs = support::inputs(&job, &errors);
    let active = from_read_out(&inputs.job, &profile, "read-out", files, ReadOutFor::OldTables);
    inputs.active = Some(shown(active));
    (inputs, tables)
}

#[test]
fn rollback_is_what_was_read_out_and_an_incomplete_read_out_gives_none() {
    for id in ["siemens-840d-sl", "siemens-828d", "fanuc-30i", "fanuc-0i-f", "fanuc-16i"] {
        let (inputs, tables) = with_read_out(id);
        let kit = shown(kit::generate(&inputs));
        let files = files_of(&kit, Role::Rollback);
        let mut read = read_apart(&inputs.profile, &files, Role::Rollback).unwrap().tables;
        let set = match &mut read {
            Tables::Siemens(held) => std::mem::take(&mut held.data).len(),
            _ => 0,
        };
        assert_eq!(read, tables, "{id}");
        assert_ne!(support::loaded(&inputs.profile, &kit), tables, "{id}: nothing to go back to");
        files.iter().for_each(|file| holds(checklist(&kit), &[&file.path]));
        assert!(!checklist(&kit).contains("no rollback file"), "{id}");
        assert_eq!(set > 0, id.starts_with("siemens"), "{id}: switches as found");
    }
    let (mut inputs, _) = with_read_out("siemens-840d-sl");
    let active = inputs.active.as_mut().unwrap();
    let Origin::ReadOut(held) = &mut active.origin else { unreachable!("it was read out") };
    let Tables::Siemens(tables) = held else { unreachable!("a Siemens control") };
    let mut cec = tables.tables.iter_mut().filter(|table| table.place.cec().is_some());
    cec.nth(3).unwrap().values[2] = None;
    let kit = shown(kit::generate(&inputs));
    assert!(files_of(&kit, Role::Rollback).is_empty());
    holds(checklist(&kit), &["do not hold all that this kit overwrites; missing: CEC table 3\n"]);
}

#[test]
fn a_changed_sign_proof_is_found_and_does_not_reach_the_tables() {
    let (job, errors) = five_points("siemens-840d-sl");
    let (inputs, mut kit) = support::generate(&job, &errors);
    let mut judged = |old: &str, new: &str| {
        let mut files = kit.files.iter_mut();
        let proof = files.find(|file| file.path == "NONIUS_SIGN_EEC.MPF").unwrap();
        proof.bytes = replaced(str::from_utf8(&proof.bytes).unwrap(), old, new).into_bytes();
        kit::verify(&inputs, &kit.files, None, Vec::new()).unwrap()
    };
    let same = judged("", "");
    assert!(same.agrees(), "{:?}", same.disagreements());
    let higher = judged("=0.020000", "=0.200000");
    let file = "`NONIUS_SIGN_EEC.MPF`".to_string();
    assert_eq!(higher.disagreements(), [FieldFault::OtherProof { file }.into()]);
    assert_eq!(higher.forecast, same.forecast);
}

fn kit_of_x(profile: &str, rows: &str, limits: &str) -> Kit {
    let job = replaced(&five_points(profile).0, TWO_TABLES, "") + limits;
    support::generate(&job, &format!("axis,position_mm,ex_um,ey_um,ez_um\nx,0,0,0,0\n{rows}")).1
}

#[test]
fn no_legal_place_is_said_with_how_to_switch_off_and_the_limit_of_the_sum_lets_a_bump_through() {
    let limits = "\n[limits]\nmax_slope_um_per_mm = 0.049\n";
    let kit = kit_of_x("siemens-840d-sl", "x,400,1,1,1\n", limits);
    let proofs = files_of(&kit, Role::SignProof);
    assert!(proofs.is_empty(), "4.9 µm in one section, and two sections do not fit");
    assert_eq!(unproved(&kit), 2, "ENC_COMP and CEC: {:?}", kit.compiled.notes);
    for (id, words) in [("fanuc-30i", "13381 for set 1"), ("fanuc-0i-f", "5711 for set 1")] {
        let kit = kit_of_x(id, "x,400,1,1,1\n", &format!("{limits}max_correction_um = 4.0\n"));
        assert!(files_of(&kit, Role::SignProof).is_empty(), "{id}");
        for words in ["note 3623 of each axis, set it to 0", words, "## Rollback"] {
            holds(checklist(&kit), &[words]);
        }
    }
    let kit = kit_of_x("siemens-840d-sl", "x,200,1,1,1\nx,400,1,1,1\n", "");
    let found = &kit.compiled.preconditions.iter().find(|p| p.what.contains("MD32720")).unwrap();
    assert_eq!(found.value, "at least 0.020 mm", "{}", found.why);
    holds(&found.why, &["up to 0.001 mm"]);
}

/// What the tables move and what the display shows: tests/it/snapshots.rs.
#[test]
fn a_checklist_says_what_a_parameter_does_not_move_what_was_not_measured_and_what_misses() {
    let not_measured =
        "\n- not measured: X from 400 to 500 mm; the table holds the end value there\n";
    let nine = replaced(&nine_errors("siemens-840d-sl.toml"), "= 30.0", "= 450.0");
    let nine = replaced(&nine, "max_deviation_um = 10.0", "max_deviation_um = 2.0");
    // Points at 0, 450 and 900 mm: 3.978 µm is the largest distance of EXX from the lines between.
    let misses = "of the job, over the whole travel, target spacing up to 30 mm: **fail**.\n- EXX leaves 3.978 µm, U not stated, the limit is 2 µm: fail\n\nMachine";
    for (kit, words, has_parameter) in [
        // A backlash parameter is not switched with the tables.
        (
            kit_with("fanuc-30i", "two-tables", PARAMETER),
            "X (1): at most 0.000 µm at the reference",
            true,
        ),
        (kit_with("siemens-840d-sl", "[0.0, 400.0]", "[0.0, 500.0]"), not_measured, false),
        (support::generate(&nine, &nine_errors("errors.csv")).1, misses, false),
    ] {
        holds(checklist(&kit), &[words]);
        assert_eq!(kit.compiled.state.axes[0].backlash_um > 0.0, has_parameter, "{words}");
    }
}

/// The bump of a straightness, which is 20 µm high.
fn cross_proof(kit: &Kit) -> Value {
    let mut proofs = proofs_of(kit).into_iter();
    let proof = proofs.find(|proof| term_of(proof).is_cross()).unwrap();
    assert!((number(&proof["shows_um"]) + 20.0).abs() < DUST_UM, "{proof}");
    proof
}

fn nine_errors(job: &str) -> String {
    fixture(&format!("nine_errors_900/{job}"))
}

#[test]
fn a_bump_of_four_points_rises_like_one_of_pitch_points() {
    let [job, errors] = ["fanuc-0i-f.toml", "errors.csv"].map(nine_errors);
    let (inputs, kit) = support::generate(&job, &errors);
    let (base, output) = axis_pairs(&kit.plan.names, term_of(&cross_proof(&kit)))[0];
    let control = proving(&inputs.profile, &kit);
    let most = steepest(&support::response(control.as_ref(), base, output, Direction::Plus));
    assert!(most <= 7.0, "{most} µm in one section");
    // Steeper where there is no room: seven units of 0.1 µm in one of two sections show on no gauge.
    let unit = "detection_unit_um =";
    cross_proof(&kit_with("fanuc-0i-f", &format!("{unit} 1.0"), &format!("{unit} 0.1")));
}

#[test]
fn headers_say_only_what_their_file_holds() {
    let (mut inputs, _) = with_read_out("siemens-840d-sl");
    inputs.job.measurement.active = ActiveTables::Path("read-out".to_string());
    let kit = shown(kit::generate(&inputs));
    let contained = "compensation active while measuring: yes, the tables of this kit contain it";
    let mut seen = 0;
    for file in kit.files.iter().filter(|file| file.role != Role::Checklist) {
        let text = text_of(&kit, &file.path);
        assert_ne!(text.contains(contained), file.role.stands_apart(), "{}\n{text}", file.path);
        // X− has 3 µm and EYX− 1 µm at the reference, before as well; bumps have nothing there
        let holds_tables = matches!(file.role, Role::Table | Role::Rollback);
        let moves = holds_tables && file.path.contains("CEC");
        let exception = ", but for\n;   CEC table 1: 0.003000 mm while AX1 moves in -\n";
        assert_eq!(text.contains(exception), moves, "{}\n{text}", file.path);
        seen += usize::from(moves);
    }
    assert_eq!(seen, 2, "tables of the kit and of the rollback");
}

#[test]
fn a_rehearsal_and_doubts_are_seen_in_the_files() {
    let (job, errors) = five_points("siemens-840d-sl");
    let remarks = "# note: SIMULATED, not measured: predicted\n# doubt: a reading is disturbed\n";
    let (_, kit) = support::generate(&job, &format!("{remarks}{errors}"));
    let head = checklist(&kit).split("## ").next().unwrap();
    let doubtful = "**INCONSISTENT:** a reading is disturbed";
    holds(head, &["**SIMULATED, not measured: predicted**", doubtful, "**undecided**"]);
    for file in &kit.files {
        holds(text_of(&kit, &file.path), &["SIMULATED"]);
    }
}

/// Controls that refuse points beyond the travel: tests/it/declared.rs.
#[test]
fn a_reference_point_off_the_travel_is_noted() {
    in_parallel(support::any_grid_ids(), |id| {
        let words = "mm outside the travel of the job";
        let (job, errors) = five_points(id);
        // No table is looked up along an axis that was not measured.
        let others = errors.split_inclusive('\n').filter(|line| !line.starts_with("x,"));
        let others: String = others.collect();
        for (reference, beyond) in [
            ("460.0", Some("460 mm, lies 60.00")),
            ("-0.02", Some("-0.02 mm, lies 0.02")),
            ("400.009", None),
            ("400.0", None),
        ] {
            let job = job.replacen("reference_mm = 0.0", &format!("reference_mm = {reference}"), 1);
            let (_, kit) = support::generate(&job, &errors);
            let (_, unmeasured) = support::generate(&job.replace(TWO_TABLES, ""), &others);
            let notes = |kit: &Kit| support::words(&kit.manifest.notes).join("\n");
            if let Some(beyond) = beyond {
                let told =
                    format!("the reference point of X, {beyond} {words}, 0 to 400 mm: compare");
                holds(&notes(&kit), &[&told]);
                let (work, _) = checklist(&kit).split_once("## Annex").unwrap();
                holds(work, &[&format!("- [ ] {told}")]);
            }
            assert_eq!(notes(&kit).contains(words), beyond.is_some(), "{id}, {reference}");
            assert!(!notes(&unmeasured).contains(words), "{id}, {reference}");
        }
    });
}

#[test]
fn a_backlash_value_is_entered_with_the_tables_and_put_back() {
    for id in ["siemens-840d-sl", "fanuc-30i", "generic"] {
        let kit = kit_with(id, "two-tables", PARAMETER);
        let of = |part: &str| checklist(&kit).split_once(part)?.1.split("\n## ").next();
        holds(of("## Before anything").unwrap(), &["found ________"]);
        let (load, back) = (of("## The real tables").unwrap(), of("## Rollback").unwrap());
        let entered: Vec<&str> = load.lines().filter(|line| line.contains(": enter ")).collect();
        assert_eq!(entered.len(), 1, "{id}: X alone has a reversal\n{load}");
        let (what, _) = entered[0].split_once(": enter ").unwrap();
        let put_back = format!("{what}: enter what was found");
        holds(back, &[&put_back]);
        // Where a person switches the compensation off, its backlash goes too.
        if let Some(off) = of("\n## Switching off and on, by hand") {
            holds(off, &[&put_back]);
        }
        let stop = back.split("To stop this compensation").nth(1);
        assert!(stop.is_none_or(|stop| stop.contains("backlash")), "{id}\n{back}");
    }
}

fn seen(page: &str) -> String {
    let (_, body) = page.split_once("<body>").unwrap();
    let body = body.replace("<span class=\"blank\">&#160;</span>", "________");
    let parts = body.split('<').map(|part| part.split_once('>').map_or(part, |(_, text)| text));
    let named = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&#39;", "'"), ("&amp;", "&")];
    named.iter().fold(parts.collect::<String>(), |text, (name, c)| text.replace(name, c))
}

#[test]
fn the_printed_checklist_has_every_line_of_the_other_in_its_order() {
    for id in builtin::ids() {
        let (job, errors) = five_points(id);
        let (_, kit) = support::generate(&job, &format!("# doubt: <b>\"a\" & 'b'; *c\n{errors}"));
        let page = text_of(&kit, "checklist.html");
        let steps = page.matches("class=\"box\"").count();
        let (text, checklist) = (seen(page), checklist(&kit));
        let boxes = checklist.matches(" [ ] ").count();
        assert!(steps == boxes && boxes > 5, "{id}: {steps} of {boxes} boxes");
        let plain = |text: &str| text.replace(['*', '`'], "");
        let text = plain(&text);
        let mut rest = text.as_str();
        let is_head = |line: &&str| line.starts_with("# ") || line.starts_with("Machine ");
        let lines: Vec<&str> = checklist.lines().filter(|line| !is_head(line)).collect();
        assert!(lines.len() > boxes, "{id}");
        for line in lines.into_iter().map(plain) {
            let line = line.trim_start_matches(|c| "0123456789 .-[]#".contains(c));
            (_, rest) = rest.split_once(line).unwrap_or_else(|| panic!("{id}: {line}\n{rest}"));
        }
        let mut of_others = ["<b>", "<script", "http", "src=", "url("].into_iter();
        let found = of_others.find(|word| page.contains(word));
        assert_eq!(found, None, "{id}: nothing of others is obeyed, nothing is fetched");
    }
}
