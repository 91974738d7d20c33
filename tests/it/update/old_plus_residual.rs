//! A machine of random errors under tables of other errors, on every control: new = old + residual.

use super::*;

const TRAVEL: f64 = 300.0;

#[derive(Clone, Debug)]
struct Case {
    controller: &'static str,
    policy: Option<&'static str>,
    gantry: bool,
    interpolated: bool,
    old_spacing: f64,
    new_spacing: f64,
    homing: &'static str,
}

impl Case {
    fn is_of(&self, family: &str) -> bool {
        self.controller.starts_with(family)
    }

    fn name(&self, n: u32) -> String {
        match self.controller.split('-').next() {
            Some("fanuc") => n.to_string(),
            Some("siemens") => format!("AX{n}"),
            Some("linuxcnc") => (n - 1).to_string(),
            _ => format!("A{n}"),
        }
    }

    fn job(&self, spacing: f64, active: &str) -> String {
        let (controller, homing) = (self.controller, self.homing);
        let mut job = format!(
            "schema = 1\n[machine]\nname = \"M\"\n[measurement]\nerrors = \"errors.csv\"\n{active}\n[compensation]\ncontroller = \"{controller}\"\nfit = \"sample\"\n"
        );
        job.extend(self.policy.map(|policy| format!("backlash = \"{policy}\"\n")));
        for (axis, number) in [("x", 1), ("y", 2)] {
            let ids = match self.gantry && axis == "x" {
                true => format!("ids = [\"{}\", \"{}\"]", self.name(1), self.name(4)),
                false => format!("id = \"{}\"", self.name(number)),
            };
            job += &format!(
                "[machine.axes.{axis}]\ntravel_mm = [0, {TRAVEL}]\nreference_mm = 0\nreference_direction = \"{homing}\"\n[compensation.axes.{axis}]\nspacing_mm = {spacing}\n{ids}\n"
            );
            if self.is_of("fanuc") {
                let interpolated = self.interpolated;
                job += &format!("detection_unit_um = 1.0\ninterpolated = {interpolated}\n");
            }
        }
        job + "[limits]\nmax_slope_um_per_mm = 5.0\n"
    }

    /// What a control gives a term of X or Y: term, base, output.
    fn pairs(&self) -> Vec<(&'static str, String, String)> {
        let mut all = vec![("EXX", 1, 1), ("EYX", 1, 2), ("EYY", 2, 2), ("EXY", 2, 1)];
        all.extend(self.gantry.then_some(("EXX", 4, 4)));
        all.into_iter().map(|(term, b, o)| (term, self.name(b), self.name(o))).collect()
    }

    fn half_count(&self) -> f64 {
        match self.controller.split('-').next() {
            Some("fanuc") => 0.5,
            Some("siemens") => 0.000_5,
            Some("linuxcnc") => 0.000_5 + 2e-6, // old and new trim of a joint are C floats
            _ => 1e-6,
        }
    }
}

/// Smooth random errors (sines of few waves), so that steps of a control stay small.
struct Wave([f64; 4]);

impl Wave {
    /// EXX, EYX, EXY, EYY.
    fn four(random: &mut Random, size: f64) -> [Wave; 4] {
        let ranges = [(-size, size), (0.5, 2.0), (-size / 2.0, size / 2.0), (0.0, 6.0)];
        std::array::from_fn(|_| Wave(ranges.map(|(low, high)| random.between(low, high))))
    }

    fn at(&self, x: f64) -> f64 {
        let [a, k, b, phase] = self.0;
        a * (k * x / 100.0 + phase).sin() + b * x / 300.0 - a * phase.sin()
    }
}

/// The error table of deviations at targets, with a reversal where both directions are measured.
fn table(case: &Case, waves: &[Wave; 4], reversal: f64, step: f64) -> String {
    let ways: &[&str] = if case.policy.is_some() { &["+", "-"] } else { &[""] };
    let targets = || (0..=(TRAVEL / step).round() as usize).map(|n| n as f64 * step).collect();
    let axes = ["x", "y"].map(|axis| (axis, targets()));
    error_rows("ex_um,ey_um", &axes, ways, |axis, way, x| {
        let lost = match (way, case.homing) {
            ("-", "+") => reversal,
            ("+", "-") => -reversal,
            _ => 0.0,
        };
        match axis {
            "x" => [waves[0].at(x) + lost, waves[1].at(x)],
            _ => [waves[2].at(x), waves[3].at(x) + lost],
        }
    })
}

fn under(case: &Case, old: &Kit, errors: &str) -> Inputs {
    println!("{case:?}"); // which one it is, where a check fails
    let found = inputs(&case.job(case.new_spacing, ACTIVE), errors);
    let active = shown(of_kit(&found, old));
    shown(found.with_active(active))
}

fn visit(case: &Case, before: &[Wave; 4], residual: &[Wave; 4]) -> (Inputs, Kit, Kit) {
    let old_job = case.job(case.old_spacing, UNCORRECTED);
    let (_, old) = generate(&old_job, &table(case, before, 6.0, case.old_spacing));
    let found = under(case, &old, &table(case, residual, 2.0, 25.0));
    let new = shown(kit::generate(&found));
    (found, old, new)
}

fn all_cases() -> Vec<Case> {
    let controllers =
        ["siemens-840d-sl", "fanuc-30i", "fanuc-0i-f", "linuxcnc", "linuxcnc-hal", "generic"];
    let policies = ["mean", "two-tables", "curve-and-parameter", "forward-only"].map(Some);
    let policies = [&[None], &policies[..]].concat();
    let spacings = [(25.0, 25.0), (50.0, 25.0), (20.0, 25.0), (25.0, 30.0)];
    let of = |index: usize| {
        let (controller, policy) = (controllers[index / 40], policies[index / 8 % 5]);
        let ((old_spacing, new_spacing), homing) = (spacings[index / 2 % 4], ["+", "-"][index % 2]);
        let gantry = controller != "fanuc-0i-f" && homing == "-";
        let interpolated = controller == "fanuc-30i" && new_spacing > 29.0;
        Case { controller, policy, gantry, interpolated, old_spacing, new_spacing, homing }
    };
    (0..240).map(of).collect()
}

/// Compares the tables at their points, and says at how many.
fn points_hold_the_sum(case: &Case, found: &Inputs, old: &Kit, new: &Kit) -> usize {
    let mut compared = 0;
    let (before, after) = (control(&found.profile, old), control(&found.profile, new));
    for (name, base, output) in case.pairs() {
        // Neither has two tables for a straightness, and four points hold no more than they do.
        let cross = (case.is_of("fanuc") || case.is_of("linuxcnc")) && base != output;
        if cross && (case.policy.is_some() || case.controller == "fanuc-0i-f") {
            continue;
        }
        let measured = found.as_measured().terms[term(name)].as_ref().unwrap();
        for direction in Direction::BOTH {
            // The straight lines through the nodes of a response; nodes are exact.
            let of = |c: &dyn Emulator| response(c, &base, &output, direction).straightened();
            let (old, new) = (of(before.as_ref()), of(after.as_ref()));
            let [table] = new.tables() else { continue };
            let residual = measured.measured.curve(direction).unwrap();
            for (at, _) in table.nodes() {
                let x = at.mm();
                if case.is_of("fanuc") && (x / case.old_spacing).fract().abs() >= 1e-9 {
                    continue; // where the step of the old table is not known
                }
                let (got, wanted) = (um_at(&new, x), um_at(&old, x) - residual.at(at).um());
                let what = format!("{base}→{output} {direction} at {x}: {got}, wanted {wanted}");
                assert!((got - wanted).abs() <= case.half_count() + 1e-9, "{what}");
                compared += 1;
            }
        }
    }
    compared
}

/// Of every control as many points at least are compared.
#[test]
fn new_is_old_plus_residual_on_every_control() {
    let families =
        [(&["siemens", "generic"][..], 3_000), (&["fanuc"], 1_000), (&["linuxcnc"], 2_000)];
    in_parallel(families, |(families, points)| {
        let (mut random, mut compared) = (Random::new(7), 0);
        for case in all_cases() {
            let (before, residual) = (Wave::four(&mut random, 12.0), Wave::four(&mut random, 4.0));
            if !families.iter().any(|family| case.is_of(family)) {
                continue;
            }
            let (found, old, new) = visit(&case, &before, &residual);
            for term in &new.forecast.terms {
                let measured = found.as_measured().terms[term.term].as_ref().unwrap();
                assert_eq!(term.change.before_um, measured.largest_um(), "{}", term.term);
            }
            let is_exact = case.controller != "linuxcnc" && !case.is_of("fanuc");
            if is_exact && case.policy == Some("two-tables") && case.old_spacing > 49.0 {
                let left = new.forecast.max_residual_um();
                assert!(left < 0.01, "{left}");
            }
            // Means and one-way curves are checked by what is forecast alone.
            if matches!(case.policy, None | Some("two-tables")) {
                compared += points_hold_the_sum(&case, &found, &old, &new);
            }
        }
        assert!(compared >= points, "{families:?}: only {compared} points were compared");
    });
}

#[test]
fn nothing_left_gives_the_same_tables_again() {
    let is_plain = |case: &Case| case.old_spacing == case.new_spacing && case.policy.is_none();
    for case in all_cases().into_iter().filter(is_plain) {
        let waves = Wave::four(&mut Random::new(3), 10.0);
        let zero: [Wave; 4] = std::array::from_fn(|_| Wave([0.0; 4]));
        let (_, old) = generate(&case.job(25.0, UNCORRECTED), &table(&case, &waves, 0.0, 25.0));
        let new = shown(kit::generate(&under(&case, &old, &table(&case, &zero, 0.0, 50.0))));
        assert_eq!(old.compiled.tables, new.compiled.tables);
        // Nothing becomes larger but by steps between the points, which were there before, too.
        let steps = |found: &Finding| {
            matches!(found.kind(), Some(InForecast::Worsened { by_steps: true, .. }))
        };
        let worsened = new.forecast.worsened();
        assert!(worsened.iter().all(steps), "{worsened:?}");
        let plays_steps = case.is_of("fanuc") && !case.interpolated;
        assert_eq!(!worsened.is_empty(), plays_steps, "{worsened:?}");
    }
}

#[test]
fn a_read_out_says_the_same_as_the_kit() {
    let is_it = |case: &Case| case.policy == Some("curve-and-parameter") && case.new_spacing > 25.0;
    let case = all_cases().into_iter().find(is_it).unwrap();
    assert_eq!((case.controller, case.homing), ("siemens-840d-sl", "+"));
    let mut random = Random::new(5);
    let (before, residual) = (Wave::four(&mut random, 12.0), Wave::four(&mut random, 4.0));
    let (found, old, new) = visit(&case, &before, &residual);
    let mut archive = "%_N_COMPLETE_TEA_INI\nCHANDATA(1)\nN10240 $MN_SCALING_SYSTEM_IS_METRIC=1\nN10000 $MN_AXCONF_MACHAX_NAME_TAB[0]=\"X1\"\nN32000 $MA_MAX_AX_VELO[AX1]=30000\n".to_string();
    for axis in ["AX1", "AX2"] {
        let mm = old.compiled.state.axis(axis).unwrap().backlash_um / 1000.0;
        archive += &format!(
            "N32450 $MA_BACKLASH[0,{axis}]={mm:.6}\nN32700 $MA_ENC_COMP_ENABLE[0,{axis}]=1\nN32710 $MA_CEC_ENABLE[{axis}]=1\n"
        );
    }
    archive.push_str("M17\n");
    for file in files_of(&old, Role::Table) {
        archive.push_str(std::str::from_utf8(&file.bytes).unwrap());
    }
    let plain = inputs(
        &case.job(30.0, "active_while_measuring = \"read-out\""),
        "axis,direction,position_mm,ex_um\nx,+,0,0\nx,+,300,1\nx,-,0,0\nx,-,300,1\n",
    );
    let files = vec![("COMPLETE.ARC".into(), archive.into_bytes())];
    let kind = ReadOutFor::OldTables;
    let read = shown(from_read_out(&plain.job, &plain.profile, "read-out", files, kind));
    let by_kit = found.active.as_ref().unwrap();
    assert_eq!(read.tables, by_kit.tables);
    is_near(read.backlash_um[Axis::X].unwrap(), by_kit.backlash_um[Axis::X].unwrap());
    holds(&notes_of(&read), &["2 other machine data"]);
    let model = found.as_measured().clone();
    let again = Inputs { active: None, under_tables: None, model, ..found.clone() };
    let again = shown(kit::generate(&shown(again.with_active(read))));
    assert_eq!(again.compiled.tables, new.compiled.tables);
}
