//! Measured while tables were active: new = old + residual.
//!
//! A machine with known errors gets tables of other errors (on another grid), is measured under
//! them, and the new tables have to hold old + residual at their points, whatever the control.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::float_cmp,
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a test that cannot go on has to stop"
)]

mod support;

use nonius::judge::active::{ActiveControl, ReadOutFor, from_kit, from_read_out};
use nonius::judge::findings::InForecast;
use nonius::kit::{self, Inputs, Kit};
use nonius::quantity::axis::Direction;
use nonius::read::emulate::Response;
use nonius::text::finding::{Finding, Severity, of_severity};
use nonius::write::findings::TableFinding;
use std::fmt::Write;
use support::{Random, control, generate, inputs, response, um_at, words};

const REFERENCE: f64 = 0.0;
const TRAVEL: f64 = 300.0;

/// One way of doing it.
#[derive(Clone, Debug)]
struct Case {
    controller: &'static str,
    policy: Option<&'static str>,
    gantry: bool,
    interpolated: bool,
    fit: &'static str,
    old_spacing: f64,
    new_spacing: f64,
    homing: &'static str,
}

impl Case {
    fn is_fanuc(&self) -> bool {
        self.controller.starts_with("fanuc")
    }

    fn is_linuxcnc(&self) -> bool {
        self.controller.starts_with("linuxcnc")
    }

    /// The name of an axis, counted from 1.
    fn name(&self, n: u32) -> String {
        match self.controller {
            c if c.starts_with("fanuc") => n.to_string(),
            c if c.starts_with("siemens") => format!("AX{n}"),
            c if c.starts_with("linuxcnc") => (n - 1).to_string(),
            _ => format!("A{n}"),
        }
    }

    fn id(&self, axis: char) -> String {
        let number = u32::from(axis) - u32::from('x') + 1;
        if self.gantry && axis == 'x' {
            format!("ids = [\"{}\", \"{}\"]", self.name(1), self.name(4))
        } else {
            format!("id = \"{}\"", self.name(number))
        }
    }

    fn job(&self, spacing: f64, active: &str) -> String {
        let mut job = format!(
            "schema = 1\n[machine]\nname = \"M\"\n[measurement]\nerrors = \"errors.csv\"\n{active}\n[compensation]\ncontroller = \"{}\"\nfit = \"{}\"\n",
            self.controller, self.fit
        );
        if let Some(policy) = self.policy {
            writeln!(job, "backlash = \"{policy}\"").unwrap();
        }
        for axis in ['x', 'y'] {
            writeln!(job, "[machine.axes.{axis}]\ntravel_mm = [0, {TRAVEL}]\nreference_mm = {REFERENCE}\nreference_direction = \"{}\"", self.homing).unwrap();
            writeln!(
                job,
                "[compensation.axes.{axis}]\nspacing_mm = {spacing}\n{}",
                self.id(axis)
            )
            .unwrap();
            if self.is_fanuc() {
                writeln!(
                    job,
                    "detection_unit_um = 1.0\ninterpolated = {}",
                    self.interpolated
                )
                .unwrap();
            }
        }
        job.push_str("[limits]\nmax_slope_um_per_mm = 5.0\n");
        job
    }
}

/// Deviations at targets: axis, direction, positions, ex, ey.
type Rows = Vec<(char, &'static str, Vec<(f64, f64, f64)>)>;

fn table(rows: &Rows) -> String {
    let mut text = "axis,direction,position_mm,ex_um,ey_um\n".to_string();
    for (axis, direction, points) in rows {
        for (mm, ex, ey) in points {
            writeln!(text, "{axis},{direction},{mm},{ex},{ey}").unwrap();
        }
    }
    text
}

/// Smooth random errors (sines of few waves), so that steps of a control stay small.
struct Wave([f64; 4]);

impl Wave {
    fn random(random: &mut Random, size: f64) -> Wave {
        Wave([
            random.between(-size, size),
            random.between(0.5, 2.0),
            random.between(-size / 2.0, size / 2.0),
            random.between(0.0, 6.0),
        ])
    }

    fn at(&self, x: f64) -> f64 {
        let [a, k, b, phase] = self.0;
        a * (k * x / 100.0 + phase).sin() + b * x / 300.0 - a * phase.sin()
    }
}

fn targets(step: f64) -> Vec<f64> {
    let count = (TRAVEL / step).round() as usize;
    (0..=count).map(|n| n as f64 * step).collect()
}

fn rows(case: &Case, waves: &[Wave; 4], reversal: f64, step: f64) -> Rows {
    let directions: &[&str] = if case.policy.is_some() {
        &["+", "-"]
    } else {
        &[""]
    };
    let mut rows = Rows::new();
    for (axis, ex, ey) in [('x', &waves[0], &waves[1]), ('y', &waves[2], &waves[3])] {
        for direction in directions {
            let against = *direction != case.homing && !direction.is_empty();
            let lag = if !against {
                0.0
            } else if case.homing == "+" {
                -reversal
            } else {
                reversal
            };
            let points = targets(step)
                .into_iter()
                .map(|x| {
                    let own = |is_x: bool| if (axis == 'x') == is_x { -lag } else { 0.0 };
                    (x, ex.at(x) - own(true), ey.at(x) - own(false))
                })
                .collect();
            rows.push((axis, direction, points));
        }
    }
    rows
}

fn active_of(case: &Case, inputs: &Inputs, old: &Kit) -> ActiveControl {
    let files = old.files.iter().map(|f| (f.path.clone(), f.bytes.clone()));
    from_kit(
        &inputs.job,
        &inputs.profile,
        "old",
        &old.manifest_bytes().unwrap(),
        files.collect(),
    )
    .unwrap_or_else(|p| panic!("{case:?}\n{}", p.render()))
}

/// What a control gives a term of X or Y: base, output.
fn pairs(case: &Case) -> Vec<(String, String)> {
    let name = |n| case.name(n);
    let mut all = vec![
        (name(1), name(1)),
        (name(1), name(2)),
        (name(2), name(2)),
        (name(2), name(1)),
    ];
    if case.gantry {
        all.push((name(4), name(4)));
    }
    all
}

/// Old kit, measurement under it, new kit.
fn visit(case: &Case, random: &mut Random) -> (Inputs, Kit, Kit) {
    let wave = |random: &mut Random, size| std::array::from_fn(|_| Wave::random(random, size));
    let before: [Wave; 4] = wave(random, 12.0);
    let residual: [Wave; 4] = wave(random, 4.0);
    let old_job = case.job(case.old_spacing, "active_while_measuring = \"none\"");
    let (_, old) = generate(
        &old_job,
        &table(&rows(case, &before, 6.0, case.old_spacing)),
    );
    let new_job = case.job(case.new_spacing, "active_while_measuring = \"old\"");
    let found = inputs(&new_job, &table(&rows(case, &residual, 2.0, 25.0)));
    let active = active_of(case, &found, &old);
    let found = found
        .with_active(active)
        .unwrap_or_else(|p| panic!("{case:?}\n{}", p.render()));
    let new = kit::generate(&found).unwrap_or_else(|p| panic!("{case:?}\n{}", p.render()));
    (found, old, new)
}

/// The measured residual of an (axis, output) pair, straight between targets.
fn measured(inputs: &Inputs, pair: usize, direction: Direction, x: f64) -> f64 {
    let names = ["EXX", "EYX", "EYY", "EXY", "EXX"];
    let term = nonius::quantity::axis::ErrorTerm::from_name(names[pair]).unwrap();
    let term = inputs.as_measured().terms[term].as_ref().unwrap();
    let curve = term.measured.curve(direction).unwrap();
    curve.at(nonius::quantity::units::Millimetres::new(x)).um()
}

fn all_cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for controller in [
        "siemens-840d-sl",
        "fanuc-30i",
        "fanuc-0i-f",
        "linuxcnc",
        "linuxcnc-hal",
        "generic",
    ] {
        for policy in [
            None,
            Some("mean"),
            Some("two-tables"),
            Some("curve-and-parameter"),
            Some("forward-only"),
        ] {
            for (old_spacing, new_spacing) in
                [(25.0, 25.0), (50.0, 25.0), (20.0, 25.0), (25.0, 30.0)]
            {
                for homing in ["+", "-"] {
                    cases.push(Case {
                        controller,
                        policy,
                        gantry: controller != "fanuc-0i-f" && homing == "-",
                        interpolated: controller == "fanuc-30i" && new_spacing > 29.0,
                        fit: "sample",
                        old_spacing,
                        new_spacing,
                        homing,
                    });
                }
            }
        }
    }
    cases
}

fn half_count(case: &Case) -> f64 {
    match case.controller {
        c if c.starts_with("fanuc") => 0.5,
        c if c.starts_with("siemens") => 0.000_5,
        // Old and new trim of a joint are C floats.
        c if c.starts_with("linuxcnc") => 0.000_5 + 2e-6,
        _ => 1e-6,
    }
}

/// The straight line through the nodes of a response; nodes are exact.
fn line(response: &Response, x: f64) -> f64 {
    um_at(&response.straightened(), x)
}

#[test]
fn new_is_old_plus_residual_at_every_point_of_the_new_tables() {
    let mut random = Random::new(7);
    let mut points = 0;
    for case in all_cases() {
        let (found, old, new) = visit(&case, &mut random);
        let (before, after) = (control(&found.profile, &old), control(&found.profile, &new));
        let two = case.policy == Some("two-tables");
        let plain = case.policy.is_none();
        for (index, (base, output)) in pairs(&case).iter().enumerate() {
            let own = base == output;
            // Neither has two tables for a straightness, and four points hold no more than they do.
            let cross = (case.is_fanuc() || case.is_linuxcnc()) && !own;
            if cross && (two || case.controller == "fanuc-0i-f") {
                continue;
            }
            if !(plain || two) {
                continue; // means and one-way curves are checked below
            }
            for direction in Direction::BOTH {
                let of =
                    |c: &dyn nonius::read::emulate::Emulator| response(c, base, output, direction);
                let (old, new) = (of(before.as_ref()), of(after.as_ref()));
                for (at, _) in new
                    .straightened()
                    .tables()
                    .iter()
                    .flat_map(|t| t.nodes().collect::<Vec<_>>())
                {
                    let x = at.mm();
                    let steps_known =
                        !case.is_fanuc() || (x / case.old_spacing).fract().abs() < 1e-9;
                    if !steps_known || new.straightened().tables().len() > 1 {
                        continue;
                    }
                    let wanted = line(&old, x) - measured(&found, index, direction, x);
                    let got = line(&new, x);
                    points += 1;
                    assert!(
                        (got - wanted).abs() <= half_count(&case) + 1e-9,
                        "{case:?}\n{base}→{output} {direction} at {x}: {got}, wanted {wanted}"
                    );
                }
            }
        }
    }
    assert!(points > 2000, "only {points} points were compared");
}

#[test]
fn before_is_what_was_measured_and_after_is_small() {
    let mut random = Random::new(11);
    for case in all_cases() {
        let (found, _, new) = visit(&case, &mut random);
        for term in &new.forecast.terms {
            let measured = found.as_measured().terms[term.term].as_ref().unwrap();
            assert_eq!(
                term.change.before_um,
                measured.largest_um(),
                "{case:?} {}",
                term.term
            );
        }
        if case.controller != "linuxcnc"
            && case.policy == Some("two-tables")
            && case.old_spacing > 49.0
            && !case.is_fanuc()
        {
            let left = new.forecast.max_residual_um();
            assert!(left < 0.01, "{case:?}: {left}");
        }
    }
}

#[test]
fn nothing_left_gives_the_same_tables_again() {
    for case in all_cases()
        .into_iter()
        .filter(|c| c.old_spacing == c.new_spacing && c.policy.is_none())
    {
        let mut random = Random::new(3);
        let waves: [Wave; 4] = std::array::from_fn(|_| Wave::random(&mut random, 10.0));
        let zero: [Wave; 4] = std::array::from_fn(|_| Wave([0.0; 4]));
        let (_, old) = generate(
            &case.job(25.0, "active_while_measuring = \"none\""),
            &table(&rows(&case, &waves, 0.0, 25.0)),
        );
        let found = inputs(
            &case.job(25.0, "active_while_measuring = \"old\""),
            &table(&rows(&case, &zero, 0.0, 50.0)),
        );
        let active = active_of(&case, &found, &old);
        let found = found.with_active(active).unwrap();
        let new = kit::generate(&found).unwrap();
        assert_eq!(old.compiled.tables, new.compiled.tables, "{case:?}");
        // Nothing becomes larger but by steps between the points, which were there before, too.
        let steps = |found: &Finding| {
            matches!(
                found.kind(),
                Some(InForecast::Worsened { by_steps: true, .. })
            )
        };
        let worsened = new.forecast.worsened();
        assert!(worsened.iter().all(steps), "{case:?}: {worsened:?}");
        let plays_steps = case.is_fanuc() && !case.interpolated;
        assert_eq!(!worsened.is_empty(), plays_steps, "{case:?}: {worsened:?}");
    }
}

/// What is told of the files that were active.
fn notes_of(active: &ActiveControl) -> String {
    words(&of_severity(&active.findings, Severity::Note)).join("\n")
}

#[test]
fn a_read_out_says_the_same_as_the_kit() {
    let case = Case {
        controller: "siemens-840d-sl",
        policy: Some("curve-and-parameter"),
        gantry: false,
        interpolated: false,
        fit: "sample",
        old_spacing: 25.0,
        new_spacing: 30.0,
        homing: "+",
    };
    let mut random = Random::new(5);
    let (found, old, new) = visit(&case, &mut random);
    let mut archive = String::from(
        "%_N_COMPLETE_TEA_INI\nCHANDATA(1)\nN10240 $MN_SCALING_SYSTEM_IS_METRIC=1\nN10000 $MN_AXCONF_MACHAX_NAME_TAB[0]=\"X1\"\nN32000 $MA_MAX_AX_VELO[AX1]=30000\n",
    );
    for axis in ["AX1", "AX2"] {
        let state = old.compiled.state.axis(axis).unwrap();
        writeln!(
            archive,
            "N32450 $MA_BACKLASH[0,{axis}]={:.6}",
            state.backlash_um / 1000.0
        )
        .unwrap();
        writeln!(
            archive,
            "N32700 $MA_ENC_COMP_ENABLE[0,{axis}]=1\nN32710 $MA_CEC_ENABLE[{axis}]=1"
        )
        .unwrap();
    }
    archive.push_str("M17\n");
    for file in old
        .files
        .iter()
        .filter(|f| f.role == nonius::control::controller::Role::Table)
    {
        archive.push_str(std::str::from_utf8(&file.bytes).unwrap());
    }
    let plain = inputs(
        &case.job(30.0, "active_while_measuring = \"read-out\""),
        "axis,direction,position_mm,ex_um\nx,+,0,0\nx,+,300,1\nx,-,0,0\nx,-,300,1\n",
    );
    let read = from_read_out(
        &plain.job,
        &plain.profile,
        "read-out",
        vec![("COMPLETE.ARC".into(), archive.into_bytes())],
        ReadOutFor::OldTables,
    )
    .unwrap_or_else(|p| panic!("{}", p.render()));
    let by_kit = found.active.as_ref().unwrap();
    assert_eq!(read.tables, by_kit.tables);
    assert!(
        (read.backlash_um[nonius::quantity::axis::Axis::X].unwrap()
            - by_kit.backlash_um[nonius::quantity::axis::Axis::X].unwrap())
        .abs()
            < 1e-9
    );
    assert!(
        notes_of(&read).contains("2 other machine data"),
        "{:?}",
        read.findings
    );
    let again = Inputs {
        active: None,
        under_tables: None,
        model: found.as_measured().clone(),
        ..found.clone()
    };
    let again = kit::generate(
        &again
            .with_active(read)
            .unwrap_or_else(|p| panic!("{}", p.render())),
    )
    .unwrap();
    assert_eq!(again.compiled.tables, new.compiled.tables);
}

/// A one-axis job with what is added to `[measurement]` and `[compensation]`.
fn small(controller: &str, measurement: &str, compensation: &str, axes: &str) -> String {
    format!(
        "schema = 1\n[machine]\nname = \"M\"\n[measurement]\nerrors = \"errors.csv\"\n{measurement}\n[compensation]\ncontroller = \"{controller}\"\n{compensation}\n[machine.axes.x]\ntravel_mm = [0, 100]\nreference_mm = 0\n[machine.axes.y]\ntravel_mm = [0, 100]\nreference_mm = 0\n{axes}"
    )
}

const ACTIVE: &str = "active_while_measuring = \"old\"";
const SIEMENS_AXES: &str = "[compensation.axes.x]\nspacing_mm = 50\nid = \"AX1\"\n[compensation.axes.y]\nspacing_mm = 50\nid = \"AX2\"\n";
const FANUC_AXES: &str = "[compensation.axes.x]\nspacing_mm = 50\nid = \"1\"\ndetection_unit_um = 1.0\n[compensation.axes.y]\nspacing_mm = 50\nid = \"2\"\ndetection_unit_um = 1.0\n";
const FULL: &str =
    "axis,position_mm,ex_um,ey_um\nx,0,0,0\nx,50,4,2\nx,100,8,-3\ny,0,0,0\ny,50,1,6\ny,100,5,3\n";
const EXX_ONLY: &str = "axis,position_mm,ex_um\nx,0,0\nx,50,1\nx,100,-1\n";

fn read_out(job: &str, errors: &str, file: &str) -> Result<Inputs, String> {
    let found = inputs(job, errors);
    from_read_out(
        &found.job,
        &found.profile,
        "old",
        vec![("old.txt".into(), file.into())],
        ReadOutFor::OldTables,
    )
    .and_then(|active| found.with_active(active))
    .map_err(|p| p.render())
}

/// Old tables that the control cut, or took in another unit, did not act as they stand.
#[test]
fn old_tables_that_the_control_cut_or_converted_are_refused() {
    let job = small("siemens-840d-sl", ACTIVE, "", SIEMENS_AXES);
    let cec = "$AN_CEC[0,0]=0\n$AN_CEC[0,1]=0.010\n$AN_CEC_INPUT_AXIS[0]=(AX1)\n$AN_CEC_OUTPUT_AXIS[0]=(AX2)\n$AN_CEC_STEP[0]=100\n$AN_CEC_MIN[0]=0\n$AN_CEC_MAX[0]=100\n$AN_CEC_DIRECTION[0]=0\n";
    for (more, says) in [
        ("$MA_CEC_MAX_SUM[AX2]=0.001\n", "MD32720 of AX2 is 0.001"),
        (
            "$MN_CONVERT_SCALING_SYSTEM=1\n$MA_CEC_SCALING_SYSTEM_METRIC[AX2]=0\n",
            "MD32711 of AX2 is 0",
        ),
    ] {
        let refused = read_out(&job, FULL, &format!("{cec}{more}M17\n")).unwrap_err();
        assert!(refused.contains(says), "{more}: {refused}");
    }
    let kept = format!("{cec}$MA_CEC_MAX_SUM[AX2]=0.010\nM17\n");
    let said = read_out(&job, FULL, &kept).err().unwrap_or_default();
    assert!(!said.contains("MD32720"), "{said}");
}

/// The smallest real case: switches and backlash were read out, the tables that they switch were not.
#[test]
fn a_read_out_with_switches_and_without_tables_is_refused() {
    let job = small("siemens-840d-sl", ACTIVE, "", SIEMENS_AXES);
    let two_lines = "N32450 $MA_BACKLASH[1,AX1]=0\nN32700 $MA_ENC_COMP_ENABLE[1,AX1]=1\nM17\n";
    let system = SIEMENS_AXES.replace("id = \"AX1\"", "id = \"AX1\"\nmeasuring_system = 2");
    let second = small("siemens-840d-sl", ACTIVE, "", &system);
    let lec = "$AA_ENC_COMP[0,0,AX1]=0\n$AA_ENC_COMP[0,1,AX1]=0.004\n$AA_ENC_COMP_STEP[0,AX1]=100\n$AA_ENC_COMP_MIN[0,AX1]=0\n$AA_ENC_COMP_MAX[0,AX1]=100\n";
    let with = |more: &str| format!("{lec}{more}M17\n");
    let cases = [
        (
            &job,
            two_lines.to_string(),
            "$MA_ENC_COMP_ENABLE[1,AX1] is 1",
        ),
        (
            &second,
            two_lines.to_string(),
            "name the commissioning archive",
        ),
        (
            &job,
            with("$MA_ENC_COMP_ENABLE[0,AX2]=1\n"),
            "$MA_ENC_COMP_ENABLE[0,AX2] is 1",
        ),
        (
            &job,
            with("$SN_CEC_TABLE_ENABLE[3]=1\n"),
            "of CEC table 3 is 1",
        ),
        (
            &job,
            with("$SN_CEC_TABLE_ENABLE[3]=1\n$MA_CEC_ENABLE[AX2]=1\n"),
            "of CEC table 3 is 1",
        ),
        (
            &job,
            with("$MA_CEC_ENABLE[AX2]=1\n"),
            "MD32710 $MA_CEC_ENABLE of AX2 is 1",
        ),
    ];
    for (job, file, says) in cases {
        let refused = read_out(job, FULL, &file).unwrap_err();
        assert!(refused.contains(says), "{file}\n{refused}");
    }
    let cec_off = "$MA_CEC_ENABLE[AX1]=0\n$MA_CEC_ENABLE[AX2]=0\n";
    for harmless in [
        format!("$SN_CEC_TABLE_ENABLE[3]=1\n{cec_off}"),
        "$SN_CEC_TABLE_ENABLE[3]=1\n$MN_MM_CEC_MAX_POINTS[3]=0\n".to_string(),
        "$MA_CEC_ENABLE[AX2]=1\n$SN_CEC_TABLE_ENABLE[3]=0\n".to_string(),
        "$MA_ENC_COMP_ENABLE[0,AX2]=1\n$MA_MM_ENC_COMP_MAX_POINTS[0,AX2]=0\n".to_string(),
    ] {
        read_out(&job, FULL, &with(&harmless)).unwrap_or_else(|p| panic!("{harmless}\n{p}"));
    }
}

/// Tables that were read out and hold zeros are known to have done nothing.
#[test]
fn tables_of_zeros_are_a_read_out_like_any_other() {
    let job = small("siemens-840d-sl", ACTIVE, "", SIEMENS_AXES);
    let zeros = "$AA_ENC_COMP[0,0,AX1]=0\n$AA_ENC_COMP[0,1,AX1]=0\n$AA_ENC_COMP_STEP[0,AX1]=100\n$AA_ENC_COMP_MIN[0,AX1]=0\n$AA_ENC_COMP_MAX[0,AX1]=100\nM17\n";
    let found = read_out(&job, FULL, zeros).unwrap();
    let says = "the active tables of AX1 → AX1 hold zeros: old = 0";
    assert!(
        found
            .active_notes
            .iter()
            .any(|note| note.to_string() == says),
        "{:?}",
        found.active_notes
    );
    let others = zeros.replace("AX1", "AX7");
    assert!(
        read_out(&job, FULL, &others)
            .unwrap_err()
            .contains("correct nothing")
    );
}

/// Where nothing tells of a kind of tables, that there was none is an assumption.
#[test]
fn tables_that_no_file_speaks_of_are_assumed_to_be_absent() {
    let job = small("siemens-840d-sl", ACTIVE, "", SIEMENS_AXES);
    let lec = "$AA_ENC_COMP[0,0,AX1]=0\n$AA_ENC_COMP[0,1,AX1]=0.004\n$AA_ENC_COMP_STEP[0,AX1]=100\n$AA_ENC_COMP_MIN[0,AX1]=0\n$AA_ENC_COMP_MAX[0,AX1]=100\nM17\n";
    let found = read_out(&job, FULL, lec).unwrap();
    let facts: Vec<&str> = found
        .active
        .as_ref()
        .unwrap()
        .assumptions
        .iter()
        .map(|a| a.fact.as_str())
        .collect();
    assert!(
        facts.contains(&"ENC_COMP of AX2") && facts.contains(&"CEC"),
        "{facts:?}"
    );
}

/// Real tables end between two points: what the control does there is not known.
#[test]
fn a_table_that_ends_between_two_points_is_taken_with_an_assumption() {
    let job = small("siemens-840d-sl", ACTIVE, "", SIEMENS_AXES);
    let table = |next: &str| {
        format!(
            "METRIC\n$AN_CEC[0,0]=0\n$AN_CEC[0,1]=0.004\n$AN_CEC[0,2]={next}\n$AN_CEC[0,3]=9\n$AN_CEC_INPUT_NCU[0]=1\n$AN_CEC_INPUT_AXIS[0]=(AX1)\n$AN_CEC_OUTPUT_NCU[0]=1\n$AN_CEC_OUTPUT_AXIS[0]=(AX2)\n$AN_CEC_STEP[0]=60\n$AN_CEC_MIN[0]=0\n$AN_CEC_MAX[0]=90\n$AN_CEC_DIRECTION[0]=0\n$AN_CEC_MULT_BY_TABLE[0]=0\n$AN_CEC_IS_MODULO[0]=0\nM17\n"
        )
    };
    let assumed = |file: &str| {
        let found = read_out(&job, FULL, file).unwrap();
        let assumptions = found.active.as_ref().unwrap().assumptions.clone();
        let open = assumptions
            .into_iter()
            .find(|a| a.fact.contains("between two points"));
        (found, open)
    };
    let (found, open) = assumed(&table("0"));
    let open = open.unwrap();
    assert_eq!(
        open.fact,
        "$AN_CEC[0] behind 60 mm, where MAX lies between two points"
    );
    assert!(
        open.consequence.contains("by up to 2.0 µm"),
        "{}",
        open.consequence
    );
    let nonius::control::table::Tables::Siemens(tables) = &found.active.as_ref().unwrap().tables
    else {
        panic!("Siemens")
    };
    assert_eq!(
        (tables.cec[0].values.len(), tables.cec[0].grid.max),
        (2, 60.0)
    );
    let (_, same) = assumed(&table("0.004"));
    assert_eq!(same, None, "both readings are the same");
    let inch = read_out(&job, FULL, &table("0").replace("METRIC", "INCH")).unwrap_err();
    assert!(
        inch.contains("is written in inch (`INCH`), the job counts in mm"),
        "{inch}"
    );
}

/// A control that plays lines between its points goes on doing so with the new ones.
#[test]
fn interpolation_is_taken_over_from_the_control() {
    let job = small("fanuc-30i", ACTIVE, "", FANUC_AXES);
    let points = "N10000Q0P0\nN10001Q0P2\nN10002Q0P1\n";
    let file = |bits: &str| {
        format!(
            "%\n{points}N03605Q1A1P{bits}A2P{bits}\nN03620Q1A1P0\nN03621Q1A1P0\nN03622Q1A1P2\nN03623Q1A1P1\nN03624Q1A1P50.0\n%\n"
        )
    };
    let asked = |job: &str, bits: &str| {
        let found = read_out(job, FULL, &file(bits)).unwrap();
        let kit = kit::generate(&found).unwrap_or_else(|p| panic!("{}", p.render()));
        let bit = kit
            .compiled
            .preconditions
            .iter()
            .find(|p| p.what.starts_with("3605#1"))
            .unwrap()
            .value
            .clone();
        (
            bit,
            kit.compiled.state.axes.iter().all(|axis| axis.interpolated),
        )
    };
    assert_eq!(asked(&job, "00000010"), ("1".to_string(), true));
    assert_eq!(asked(&job, "00000000"), ("0".to_string(), false));
    let stated = FANUC_AXES.replace("spacing_mm = 50", "spacing_mm = 50\ninterpolated = false");
    let stated = small("fanuc-30i", ACTIVE, "", &stated);
    assert_eq!(asked(&stated, "00000010"), ("0".to_string(), false));
}

#[test]
fn a_term_that_was_not_measured_is_kept_or_dropped_as_the_job_says() {
    let job = |more: &str| {
        small(
            "siemens-840d-sl",
            &format!("{ACTIVE}\n{more}"),
            "",
            SIEMENS_AXES,
        )
    };
    let (before, old) = generate(
        &small(
            "siemens-840d-sl",
            "active_while_measuring = \"none\"",
            "",
            SIEMENS_AXES,
        ),
        FULL,
    );
    let files = || {
        old.files
            .iter()
            .map(|f| (f.path.clone(), f.bytes.clone()))
            .collect()
    };
    let with = |more: &str| {
        let found = inputs(&job(more), EXX_ONLY);
        let active = from_kit(
            &found.job,
            &found.profile,
            "old",
            &old.manifest_bytes().unwrap(),
            files(),
        )
        .unwrap();
        found.with_active(active)
    };
    let refused = with("").unwrap_err().render();
    for term in ["EYX", "EXY", "EYY"] {
        assert!(
            refused.contains(&format!("correct {term}, which was not measured")),
            "{refused}"
        );
    }
    let kept = with("active_terms_not_measured = \"keep\"").unwrap();
    let new = kit::generate(&kept).unwrap();
    assert_eq!(new.forecast.terms.len(), 1, "only EXX was measured");
    let (was, is) = (control(&before.profile, &old), control(&kept.profile, &new));
    for (base, output) in [("AX1", "AX2"), ("AX2", "AX1"), ("AX2", "AX2")] {
        for x in [0.0, 20.0, 50.0, 90.0, 100.0] {
            let of = |c: &dyn nonius::read::emulate::Emulator| {
                um_at(&response(c, base, output, Direction::Plus), x)
            };
            assert!(
                (of(was.as_ref()) - of(is.as_ref())).abs() < 1e-9,
                "{base}→{output} at {x}"
            );
        }
    }
    let dropped = kit::generate(&with("active_terms_not_measured = \"drop\"").unwrap()).unwrap();
    let what: Vec<&str> = dropped
        .compiled
        .preconditions
        .iter()
        .map(|p| p.what.as_str())
        .collect();
    for stale in [
        "SD41300 $SN_CEC_TABLE_ENABLE[0]",
        "SD41300 $SN_CEC_TABLE_ENABLE[1]",
        "MD32700 $MA_ENC_COMP_ENABLE[0,AX2]",
    ] {
        assert!(what.contains(&stale), "{stale} in {what:?}");
    }
}

#[test]
fn steps_are_taken_off_where_the_laser_stood_and_lines_between() {
    let job = small("fanuc-30i", ACTIVE, "", FANUC_AXES);
    let errors = "axis,position_mm,ex_um\nx,0,0\nx,50,4\nx,100,8\n";
    let (_, old) = generate(
        &small(
            "fanuc-30i",
            "active_while_measuring = \"none\"",
            "",
            FANUC_AXES,
        ),
        errors,
    );
    // The machine errs by 0.08 µm/mm; at 20 mm the step of the first section has not come, at 40 mm it has.
    let residual = "axis,position_mm,ex_um\nx,0,0\nx,20,1.6\nx,40,-0.8\nx,50,0\nx,100,0\n";
    let found = inputs(&job, residual);
    let files = old
        .files
        .iter()
        .map(|f| (f.path.clone(), f.bytes.clone()))
        .collect();
    let active = from_kit(
        &found.job,
        &found.profile,
        "old",
        &old.manifest_bytes().unwrap(),
        files,
    )
    .unwrap();
    let found = found.with_active(active).unwrap();
    let exx = nonius::quantity::axis::ErrorTerm::from_name("EXX").unwrap();
    let measured = found.model.terms[exx].as_ref().unwrap();
    let curve = measured.measured.curve(Direction::Plus).unwrap();
    for x in [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 75.0, 100.0] {
        let um = curve.at(nonius::quantity::units::Millimetres::new(x)).um();
        assert!((um - 0.08 * x).abs() < 1e-9, "{um} at {x}");
    }
}

/// Both directions, so that every policy is possible; X and Y each correct the other too.
const BOTH_WAYS: &str = "axis,direction,position_mm,ex_um,ey_um\nx,+,0,0,0\nx,+,50,4,2\nx,+,100,8,-3\nx,-,0,5,1\nx,-,50,9,3\nx,-,100,13,-2\ny,+,0,0,0\ny,+,50,1,6\ny,+,100,5,3\ny,-,0,1,4\ny,-,50,2,10\ny,-,100,6,7\n";
/// The policy of the tables in the control, and of the new ones.
const WAYS: [(&str, &str); 5] = [
    ("mean", "mean"),
    ("mean", "curve-and-parameter"),
    ("two-tables", "two-tables"),
    ("two-tables", "mean"),
    ("mean", "two-tables"),
];

fn old_and_new(controller: &str, axes: &str, (old, new): (&str, &str)) -> (Kit, String, String) {
    let job = |active: &str, policy: &str| {
        small(
            controller,
            active,
            &format!("backlash = \"{policy}\""),
            axes,
        )
    };
    let none = "active_while_measuring = \"none\"";
    let (_, before) = generate(&job(none, old), BOTH_WAYS);
    let left = BOTH_WAYS.replace(",8,-3", ",3,1").replace(",13,-2", ",5,2");
    (before, job(ACTIVE, new), left)
}

fn files_of(kit: &Kit, role: nonius::control::controller::Role) -> Vec<nonius::read::KitFile<'_>> {
    let files = kit.files.iter().filter(|file| file.role == role);
    files
        .map(|file| nonius::read::KitFile {
            path: &file.path,
            role,
            bytes: &file.bytes,
        })
        .collect()
}

/// What the axes get, at places on and between the points, in both directions.
fn acts(control: &dyn nonius::read::emulate::Emulator, names: [&str; 2]) -> Vec<f64> {
    let mut all = Vec::new();
    for base in names {
        for output in names {
            for direction in Direction::BOTH {
                let response = response(control, base, output, direction);
                all.extend([0.0, 20.0, 50.0, 75.0, 100.0].map(|x| um_at(&response, x)));
            }
        }
    }
    all
}

#[path = "update/siemens_control.rs"]
mod siemens_control;

#[path = "update/fanuc_control.rs"]
mod fanuc_control;

#[path = "update/what_acted.rs"]
mod what_acted;

#[path = "update/kits_on_disk.rs"]
mod kits_on_disk;

#[test]
fn a_kit_of_another_machine_is_refused() {
    let job = |machine: &str| {
        let page = small("siemens-840d-sl", ACTIVE, "", SIEMENS_AXES);
        page.replace("name = \"M\"", machine)
    };
    let read = |kit_of: &str, job_of: &str| {
        let (_, old) = generate(&job(kit_of).replace("\"old\"", "\"none\""), FULL);
        let found = inputs(&job(job_of), FULL);
        let files = old.files.iter().map(|f| (f.path.clone(), f.bytes.clone()));
        let manifest = old.manifest_bytes().unwrap();
        from_kit(
            &found.job,
            &found.profile,
            "old",
            &manifest,
            files.collect(),
        )
        .map(|active| notes_of(&active))
        .map_err(|problems| problems.render())
    };
    let one = "name = \"M\"\nserial = \"1\"\nchain = \"wXYZt\"";
    assert_eq!(read(one, one).unwrap(), "");
    let other = read(&one.replace("\"1\"", "\"999\""), one).unwrap_err();
    assert!(
        other.contains("its serial number is `999`, that of the job `1`"),
        "{other}"
    );
    let renamed = read(&one.replace("\"M\"", "\"other mill\""), one).unwrap();
    assert!(
        renamed.contains("the machine name `other mill`, the job `M`"),
        "{renamed}"
    );
    let unsure = read("name = \"other mill\"", one).unwrap_err();
    assert!(
        unsure.contains("its name is `other mill`, that of the job `M`"),
        "{unsure}"
    );
    let chain = read("name = \"M\"\nchain = \"XwYZt\"", one).unwrap_err();
    assert!(
        chain.contains("its chain is `XwYZt`, that of the job `wXYZt`"),
        "{chain}"
    );
    assert_eq!(
        read("name = \"M\"", one).unwrap(),
        "",
        "what is not stated does not contradict"
    );
}

#[test]
fn a_parameter_that_acted_without_tables_is_in_the_new_ones() {
    let job = |policy: &str, more: &str| {
        small(
            "siemens-840d-sl",
            &format!("active_while_measuring = \"none\"\n{more}"),
            &format!("backlash = \"{policy}\""),
            SIEMENS_AXES,
        )
    };
    let both = "axis,direction,position_mm,ex_um\nx,+,0,0\nx,+,100,2\nx,-,0,1\nx,-,100,3\n";
    let with = |policy: &str, more: &str| {
        let found = inputs(&job(policy, more), both);
        let active = nonius::judge::active::without_tables(&found.job, &found.profile).unwrap();
        let found = match active {
            Some(active) => found.with_active(active).unwrap(),
            None => found,
        };
        kit::generate(&found).unwrap_or_else(|p| panic!("{}", p.render()))
    };
    let minus_at_reference = |kit: &Kit| match &kit.compiled.tables {
        nonius::control::table::Tables::Siemens(tables) => tables.cec[1].values[0].unwrap(),
        _ => panic!("it is a Siemens control"),
    };
    let (zero, four) = (
        with("two-tables", ""),
        with("two-tables", "active_backlash_um = { x = 4.0 }"),
    );
    // The laser saw 1 µm of lost motion; 4 µm more were taken up by the parameter that is now 0.
    assert_eq!(minus_at_reference(&zero), 0.001);
    assert_eq!(minus_at_reference(&four), 0.005);
    assert!(four.manifest.predecessor.is_none());
    let x = nonius::quantity::axis::Axis::X;
    let parameter = |more: &str| with("curve-and-parameter", more).plan.backlash_um[x].unwrap();
    assert!((parameter("") - 1.0).abs() < 1e-9);
    assert!((parameter("active_backlash_um = { x = 4.0 }") - 5.0).abs() < 1e-9);
    let says = |kit: &Kit| {
        let assumed = kit
            .manifest
            .assumptions
            .iter()
            .any(|a| a.fact == "backlash_while_measuring_x");
        let noted = kit
            .manifest
            .notes
            .iter()
            .any(|n| matches!(n.kind(), Some(TableFinding::ParameterReplaced { .. })));
        let demanded = kit
            .manifest
            .preconditions
            .iter()
            .any(|p| p.why.contains("as 0 while measuring"));
        [assumed, noted, demanded]
    };
    assert_eq!(says(&zero), [true; 3]);
    assert_eq!(says(&with("curve-and-parameter", "")), [true; 3]);
    assert_eq!(says(&four), [false; 3]);
    assert_eq!(
        says(&with("mean", "")),
        [false; 3],
        "the parameter stays as it was"
    );
}
