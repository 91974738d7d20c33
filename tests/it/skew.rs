//! Klipper's skew correction against its formula: the bytes take off the lean, and nothing else, wherever it homes.
use crate::support::{self, Random, Visit, holds, number, um_at};
use nonius::control::controller::builtin;
use nonius::quantity::Direction;

/// A printer that leans by so many µm in 100 mm: X by Y, X by Z, Y by Z; Z bends by `bent` µm in the middle of Y.
fn texts(lean: [f64; 3], bent: f64, reference: [f64; 3]) -> (String, String) {
    let [xy, xz, yz] = lean;
    let mut errors =
        "axis,position_mm,ex_um,ey_um,ez_um\nx,0,5,0,0\nx,100,9,0,0\nx,200,15,0,0\n".to_string();
    for (mm, part) in [(0.0, 0.0), (100.0, 1.0), (200.0, 0.0)] {
        errors += &format!("y,{mm:?},{:?},0,{:?}\n", xy * mm / 100.0, bent * part);
        errors += &format!("z,{mm:?},{:?},{:?},0\n", xz * mm / 100.0, yz * mm / 100.0);
    }
    let axes = ["x", "y", "z"].into_iter().zip(reference);
    let axes = axes.map(|(axis, mm)| (axis, [0.0, 200.0], mm, "spacing_mm = 20".to_string()));
    let job = support::job_of(support::UNCORRECTED, "controller = \"klipper-skew\"", axes)
        + "[limits]\nmax_slope_um_per_mm = 20\nmax_correction_um = 5000\n[acceptance]\nmax_deviation_um = 50\n";
    (job, errors)
}

/// How far the tool is off in X and Y on a machine that leans with its motors, mm.
fn off(skew: [f64; 3], [xy, xz, yz]: [f64; 3], [_, y, z]: [f64; 3]) -> [f64; 2] {
    // x' - x and y' - y of Klipper's calc_skew, written here once more.
    let (dx, dy) = (-y * skew[0] - z * (skew[1] - skew[0] * skew[2]), -z * skew[2]);
    [dx + (y + dy) * xy + z * xz, dy + z * yz]
}

#[test]
fn the_bytes_take_off_the_lean_by_klippers_formula() {
    let profile = builtin::profile("klipper-skew").unwrap();
    let turned = support::with_signs_turned(&profile);
    let mut random = Random::new(7);
    for _ in 0..40 {
        let lean = [0; 3].map(|_| random.between(-300.0, 300.0));
        let reference = [0; 3].map(|_| random.of(&[0.0, 100.0, 200.0]));
        let (job, errors) = texts(lean, 8.0, reference);
        let (_, kit) = support::generate(&job, &errors);
        let text = support::text_of(&kit, "nonius-skew.cfg");
        let factor = |name: &str| -> f64 {
            let line = text.lines().find(|line| line.starts_with(name)).unwrap();
            line.split(" = ").nth(1).unwrap().parse().unwrap()
        };
        let factors = ["xy_skew", "xz_skew", "yz_skew"].map(factor);
        for (factor, lean) in factors.iter().zip(lean) {
            assert!((factor - lean * 1e-5).abs() <= 0.51e-9, "{factor} {lean}");
        }
        let (right, wrong) = (support::control(&profile, &kit), support::control(&turned, &kit));
        for (base, output, index) in [("y", "x", 1), ("z", "x", 2), ("z", "y", 2)] {
            let of = usize::from(output == "y");
            for mm in [0.0, 37.0, 200.0] {
                let mut at = reference;
                at[index] = mm;
                let own = factors[if of == 1 { 2 } else { index - 1 }] * (mm - reference[index]);
                let (expected, turned) = (-own, own);
                for at in [at, [0.0, 200.0, 200.0]] {
                    let [x, y] = off(factors, lean.map(|um| um * 1e-5), at);
                    assert!(x.abs().max(y.abs()) < 2.1e-7, "half of the last digit: {x} {y}");
                }
                for direction in Direction::BOTH {
                    let response = support::response(right.as_ref(), base, output, direction);
                    let um = um_at(&response, mm);
                    assert!((um - expected * 1000.0).abs() < 1e-9, "{base} {output}: {um}");
                    let response = support::response(wrong.as_ref(), base, output, direction);
                    assert!((um_at(&response, mm) - turned * 1000.0).abs() < 1e-9);
                }
            }
        }
        // What it cannot hold is as it was.
        let left = |name: &str| {
            let own = kit.forecast.terms.iter().find(|own| own.term == support::term(name));
            let own = own.unwrap();
            (own.change.before_um, own.change.after_um)
        };
        for name in ["EXY", "EXZ", "EYZ"] {
            assert!(left(name).1 < 0.001, "{name}: {:?}", left(name));
        }
        for name in ["EXX", "EZY"] {
            let (before, after) = left(name);
            assert!((before - after).abs() < 1e-12 && before > 1.0, "{name}");
        }
    }
}

/// Home at 200 mm of Z: Klipper adds -(2e-5 * 200 mm) = -4 um to X there, and says so as a shift.
#[test]
fn a_correction_that_is_not_zero_at_the_reference_is_named() {
    let (job, errors) = texts([0.0, 2.0, 0.0], 0.0, [0.0, 0.0, 200.0]);
    let visit = Visit::with(job, errors);
    visit.edit("job.toml", "[compensation]\n", "[compensation]\nterms = [\"EXZ\"]\n");
    let kit = visit.run("generate job.toml -o kit --format json").json();
    holds(&kit["notes"].to_string(), &["adds -4.0 µm to X"]);
    let proof = &kit["sign_proofs"][0];
    // From 200 to 0 mm, where the file pretends +20 um.
    assert_eq!((&proof["from_mm"], &proof["peak_mm"]), (&200.0.into(), &0.0.into()));
    assert!((number(&proof["shows_um"]) + 20.0).abs() < 0.001);
    holds(&visit.read("kit/nonius-sign-skew.cfg"), &["xz_skew = -0.000100000"]);
}

/// Somebody's changes are found; factors that acted are part of the new ones.
#[test]
fn files_are_judged_and_old_factors_are_added() {
    let (job, errors) = texts([10.0, -20.0, 5.0], 8.0, [0.0; 3]);
    let visit = Visit::with(job, errors).with_kit();
    visit.yes("verify job.toml --tables kit");
    let own = visit.read("kit/nonius-skew.cfg");
    let saved: String = own.lines().map(|line| format!("#*# {line}\n")).collect();
    let saved = format!("[printer]\nkinematics = corexy\n{saved}");
    for (from, to, expected, words) in [
        ("0.000100000", "0.000100000", 0, "agree"),
        ("0.000100000", "-0.000100000", 1, "EXY"),
        ("[skew_correction nonius]", "[skew_correction other]", 0, "agree"),
    ] {
        visit.put("out/printer.cfg", saved.replace(from, to));
        visit.run("verify job.toml --tables out --explain").ends(expected).says(words);
    }
    visit.put("out/printer.cfg", &saved);
    visit.edit("job.toml", "\"none\"", "\"out\"\nactive_terms_not_measured = \"keep\"");
    visit.yes("generate job.toml -o new");
    holds(&visit.read("new/nonius-skew.cfg"), &["xy_skew = 0.000200000", "yz_skew = 0.000100000"]);
}
