//! Part programs of measuring runs, each of them walked by code that knows nothing of how it was written.
use crate::snapshots::is_as_checked;
use crate::support::{holds, read_job, readings, replaced, source};
use nonius::control::controller::builtin;
use nonius::inputs::job::{DiagonalMeasurement, Job, MeasuredData};
use nonius::inputs::target_runs::{RunFacts, Runs};
use nonius::kit::program_kit::{ProgramKit, judge, make};
use nonius::text::Problems;
use nonius::write::program::{FileRole, Open, ProgramFile, RunTask, left_open};
use proptest::prelude::*;
use serde_json::json;

const STEP: &str = "what = \"step-diagonal\"";

/// A machine with its box, in mm, and the keys of [program].
#[derive(Clone, Debug)]
struct Case {
    control: &'static str,
    unit: &'static str,
    low: [f64; 3],
    high: [f64; 3],
    start: [f64; 3],
    size: [f64; 3],
    steps: usize,
    order: &'static str,
    keys: String,
}

impl Case {
    /// X 0 … 100, Y −80 … 0, Z −60 … 60, and a box of two steps with 5 mm to spare on every side.
    fn small(control: &'static str, keys: &str) -> Case {
        Case {
            control,
            unit: "mm",
            low: [0.0, -80.0, -60.0],
            high: [100.0, 0.0, 60.0],
            start: [5.0, -75.0, -55.0],
            size: [90.0, 70.0, 110.0],
            steps: 2,
            order: "ZXY",
            keys: keys.to_string(),
        }
    }

    /// The box of a paper, X 0 … 900, in a travel of −50 … 1000.
    fn large(keys: &str, [y, z]: [f64; 2]) -> Case {
        Case {
            low: [-50.0; 3],
            high: [1000.0; 3],
            start: [0.0; 3],
            size: [900.0, y, z],
            steps: 30,
            order: "XYZ",
            ..Case::small("siemens-840d-sl", keys)
        }
    }

    fn job(&self) -> String {
        let place = |[x, y, z]: [f64; 3]| format!("{{ x = {x:?}, y = {y:?}, z = {z:?} }}");
        let (start, size) = (place(self.start), place(self.size));
        let Case { control, unit, steps, order, keys, .. } = self;
        let mut page = "schema = 1\n[machine]\nname = \"VMC\"\nserial = \"7\"\n".to_string();
        for (axis, (low, high)) in ["x", "y", "z"].iter().zip(self.low.iter().zip(self.high)) {
            page += &format!(
                "axes.{axis} = {{ travel_mm = [{low:?}, {high:?}], reference_mm = {low:?}, \
                 max_feed_mm_per_min = 9000 }}\n"
            );
        }
        page + &format!(
            "[measurement]\nreadings = \"readings.csv\"\n[measurement.step_diagonal]\n\
             start_mm = {start}\nsize_mm = {size}\nsteps = {steps}\norder = \"{order}\"\n\
             [compensation]\ncontroller = \"{control}\"\ncontrol_unit = \"{unit}\"\n\
             [program]\n{keys}\n"
        )
    }

    fn read(&self) -> Job {
        read_job(&self.job())
    }

    fn made(&self) -> Result<ProgramKit, Problems> {
        make(&self.read(), &builtin::profile(self.control).unwrap(), &[])
    }

    fn kit(&self) -> ProgramKit {
        self.made().unwrap_or_else(|p| panic!("{}\n{}", p.render(), self.job()))
    }
}

fn siemens(keys: &str) -> Case {
    Case::small("siemens-840d-sl", &format!("{STEP}\n{keys}"))
}

fn fanuc(keys: &str) -> Case {
    Case::small("fanuc-30i", &format!("{STEP}\n{keys}"))
}

fn told(kit: &ProgramKit) -> String {
    kit.run.notes.iter().map(ToString::to_string).collect()
}

fn text(kit: &ProgramKit, path: &str) -> String {
    let file = kit.files.iter().find(|file| file.path == path).unwrap();
    std::str::from_utf8(&file.bytes).unwrap().replace('\r', "")
}

/// Positions stand in the order of the readings.
#[test]
fn programs_and_positions_are_those_that_were_checked() {
    let kit = siemens("").kit();
    is_as_checked("it__program__siemens_npp", &text(&kit, "NONIUS_NPP.MPF"));
    let all = text(&kit, "positions.csv");
    let two: Vec<&str> = all.lines().take(15).collect();
    is_as_checked("it__program__positions", &two.join("\n"));
    assert_eq!(all.lines().count(), 1 + 4 * 14);
    let kit = fanuc("return = \"diagonal\"\nruns = 2\nalignment_pass = false\nnumber = 4001").kit();
    is_as_checked("it__program__fanuc_ppn", &text(&kit, "O4004.NC"));
    let turn = text(&siemens("overrun_mm = 0").kit(), "NONIUS_PPP.MPF");
    holds(&turn, &["N7 G4 F3.0\n; PPP RUN 1 REVERSE\nN8 G4 F3.0\n"]);
    let keys = "what = \"single-axis\"\naxes = [\"x\"]\ntargets = \"offset\"\nruns = 1\nalignment_pass = false\nsteps = 5";
    let kit = Case::small("fanuc-0i-f", keys).kit();
    is_as_checked("it__program__offset_targets", &text(&kit, "positions.csv"));
}

#[test]
fn what_is_not_stated_has_its_default() {
    let asked = |keys: &str| Case::small("generic", keys).read().program.unwrap();
    let steps = asked(STEP);
    assert_eq!((steps.feed_mm_per_min, steps.dwell_s), (1000.0, 3.0));
    assert_eq!((steps.overrun.mm(), steps.preload.mm()), (2.0, 2.0));
    assert_eq!((steps.runs, steps.bidirectional), (1, true));
    assert_eq!((steps.volume.steps, steps.size_path), (2, "measurement.step_diagonal.size_mm"));
    assert_eq!(asked("what = \"single-axis\"").runs, 5);
    let forward = asked(&format!("{STEP}\nreturn = \"diagonal\"\nsteps = 3"));
    assert_eq!((forward.bidirectional, forward.volume.steps), (false, 3));
    let turning = asked(&format!("{STEP}\noverrun_mm = 0"));
    assert_eq!((turning.overrun.mm(), turning.preload.mm()), (0.0, 2.0));
}

/// Three steps show no pitch at five phases; 24.765 mm are 195 times 0.005 in.
#[test]
fn numbers_that_may_be_protected_and_better_steps_that_can_be_entered_are_noted() {
    let is_noted = |number| told(&fanuc(&format!("number = {number}")).kit()).contains("protected");
    assert_eq!([7996, 7997, 9001].map(is_noted), [false, true, true]);
    let noted = |unit, steps, mm| {
        told(&Case { unit, steps, size: [mm; 3], ..Case::large(STEP, [0.0; 2]) }.kit())
    };
    holds(&noted("mm", 3, 870.0), &["not be seen: steps of X 290 mm, steps of Y"]);
    holds(&noted("inch", 20, 508.0), &["steps of X 25.4 mm (better 24.765 mm), steps of Y"]);
    holds(&noted("inch", 20, 495.3), &["steps of X 24.765 mm"]);
}

/// Golden: step·√(1 − (V/R)²) of reference step-diagonal §1.1 for 900×720×720, n = 30.
#[test]
fn the_mirror_of_the_paper() {
    let keys = format!("{STEP}\npreload_mm = 0.01\noverrun_mm = 0");
    let mirror = Case::large(&keys, [720.0; 2]).kit().run.mirror.unwrap();
    let r2 = 900.0_f64.powi(2) + 2.0 * 720.0_f64.powi(2);
    let first = 30.0 * (1.0 - 900.0_f64.powi(2) / r2).sqrt();
    let second = 24.0 * (1.0 - 720.0_f64.powi(2) / r2).sqrt();
    assert!((mirror.excursion_mm[0] - first).abs() < 1e-9 && (first - 22.5).abs() < 0.05);
    assert!((mirror.excursion_mm[1] - second).abs() < 1e-9 && (second - 20.4).abs() < 0.05);
    // The triangle 22.5, 20.4, 20.4 is acute, so its circle is a·b·c / 2A.
    let height = (second.powi(2) - (first / 2.0).powi(2)).sqrt();
    let circle = first * second * second / (first * height);
    assert!((mirror.circle_mm - circle).abs() < 0.01, "{} {circle}", mirror.circle_mm);
    // Overrun lies beside the spots by 2 · √(3 − ((V_x + V_y + V_z)/R)²) = 0.38 mm.
    let beside = Case::large(&format!("{STEP}\noverrun_mm = 2"), [720.0; 2]).kit().run.mirror;
    assert!((0.0..0.4).contains(&(beside.unwrap().circle_mm - circle)), "{beside:?} {circle}");
}

#[test]
fn offset_targets_sample_every_phase_of_a_screw() {
    let keys = "what = \"single-axis\"\naxes = [\"x\"]\ntargets = \"offset\"";
    let kit = Case::large(keys, [900.0; 2]).kit();
    let readings = kit.run.programs[0].readings.iter().take(31);
    let targets: Vec<f64> = readings.map(|r| kit.run.resolution.mm(r.place.x)).collect();
    assert!(targets.windows(2).all(|pair| pair[0] < pair[1]));
    assert!(targets[0] >= 0.0 && targets[30] <= 900.0);
    // Equal targets 30 mm apart meet a screw of 10 mm at one phase; these meet each tenth of it.
    for tenth in 0..10 {
        let phase = f64::from(tenth)..f64::from(tenth + 1);
        let met = targets.iter().any(|target| phase.contains(&target.rem_euclid(10.0)));
        assert!(met, "no target meets {phase:?} mm of the screw: {targets:?}");
    }
}

#[test]
fn the_walk_finds_what_is_wrong_with_a_program_its_readings_and_positions() {
    let too_low = "before X and Y are there, or with them";
    let (x_y, z) = ("SUPA G90 G0 X97.000 Y-77.000", "SUPA G90 G0 Z-57.000");
    let [x_y_then_z, z_then_x_y] = [[x_y, z], [z, x_y]].map(|moves| moves.join("\n"));
    let overrun =
        "SUPA G91 G1 X-2.000 Y2.000 Z2.000 F1000.0\nSUPA G91 G1 X2.000 Y-2.000 Z-2.000 F1000.0\n";
    let two_moves = ["SUPA G91 G1 Z27.500 F1000.0"; 2].join("\n");
    let [long, wide] = ["\n", " G40"].map(|part| format!("M30{}", part.repeat(50_001)));
    let of_siemens = [
        ("N3 G4 F3.0\n", "", "of 14 readings are taken"),
        ("N3 G4 F3.0", "N3 G4 F0.3", "the standstill is 0.3 s"),
        ("N3 G4", "N4 G4", "has another number"),
        ("\nD0\n", "\n", "before ToolLength is cancelled"),
        ("G710", "G700", "outside its travel"),
        ("G0 X97.000", "G0 X-2097.000", "outside its travel"),
        ("G710", "", "before mm or inch is chosen"),
        ("SUPA G90 G0", "G90 G0", "this is neither"),
        ("SUPA G91 G1", "G91 G1", "this is neither"),
        ("Y-77.000\nSUPA G90 G0 Z-57.000", "Y-77.000 Z-57.000", too_low),
        (&*x_y_then_z, &*z_then_x_y, too_low),
        ("SUPA G90 G0 Z-57.000\n", "", "before all three axes are at machine coordinates"),
        ("SUPA G91 G1 Z55.000", "SUPA G91 G1 Z54.000", "is read at Z"),
        ("SUPA G91 G1 X2.000 Y-2.000 Z-2.000", "SUPA G91 G1 X2.000 Y-2.000", "is read at Z"),
        (overrun, "", "has not arrived at node 6 moving"),
        (" G94", "", "without a feed per minute"),
        ("F1000.0", "F12000.0", "is too high for X"),
        ("M30", "", "the program has no end"),
        ("M30", long.as_str(), "more than 50000 lines"),
        ("M30", wide.as_str(), "too many for a line"),
        ("M30", "M30\nG500", "follows the end"),
        ("G500", "G54", "`G54` is not a word"),
        ("G500", "$P_UIFR[1]=CTRANS(X,10)", "is no word"),
        ("MSG()", "M3 S100", "`M3` is not a word"),
        ("X-45.000", "X-45.000 X-45.000", "is given twice"),
        ("ZERO THE LASER", "NULL \u{c4} LASER", "not ASCII"),
        ("SUPA G91 G1 Z55.000 F1000.0", &two_moves, "not reached by one move of its own"),
    ];
    let of_fanuc = [
        ("G91 G01", "G90 G01", "this is neither"),
        ("G53 ", "", "this is neither"),
        ("G40 G49 G80", "G40 G80", "before ToolLength is cancelled"),
        ("G21", "G20", "outside its travel"),
        ("N3 G04 X3.0", "N3 G04 P3", "`P3` is not a word"),
        ("G69", "G10 L2 P1 X0", "`G10` is not a word"),
        ("(NPP RUN 1 REVERSE)", "(NPP (RUN 1)", "brackets"),
        ("M30", "M30\n%", "between two"),
        ("O1002", "%\nO1002", "outside the two"),
    ];
    for (case, path, spoilt) in [
        (siemens(""), "NONIUS_NPP.MPF", &of_siemens[..]),
        (siemens(""), "readings.csv", &[(",2,x,", ",2,y,", "has other rows than positions.csv")]),
        (siemens(""), "positions.csv", &[("50,-40,", "50,-41,", "is not where the job has it")]),
        (fanuc(""), "O1002.NC", &of_fanuc),
    ] {
        for (from, to, words) in spoilt {
            let mut files = case.kit().files;
            let file = files.iter_mut().find(|file| file.path == path).unwrap();
            let before = String::from_utf8(file.bytes.clone()).unwrap();
            file.bytes = replaced(&before, from, to).into_bytes();
            let (job, profile) = (case.read(), builtin::profile(case.control).unwrap());
            let found = judge(RunTask::of(&job, &profile).unwrap(), &files).map(|_| ());
            let said = found.expect_err("the walk must find it").render();
            assert!(said.contains(words), "{from} -> {to}:\n{said}");
        }
    }
}

fn filled<'a>(form: &ProgramFile, cell: impl Fn(usize) -> &'a str) -> String {
    let text = String::from_utf8(form.bytes.clone()).unwrap();
    let cell = |index| if index == 0 { "" } else { cell(index) };
    text.lines().enumerate().map(|(index, line)| format!("{line}{}\n", cell(index))).collect()
}

fn as_runs(form: &str) -> Result<Runs, String> {
    Runs::read(&source("readings-y.csv", form), RunFacts::default()).map_err(|p| p.render())
}

#[test]
fn a_reading_that_is_not_filled_in_is_refused_as_missing() {
    let case = siemens("");
    let MeasuredData::Diagonals(measurement) = case.read().measurement.data else { panic!() };
    let form = text(&case.kit(), "readings.csv");
    let head = "diagonal,run,direction,node,moved,displacement_mm\nPPP,1,forward,0,,\nPPP,1,forward,1,z,\n";
    assert!(form.starts_with(head), "{form}");
    holds(&readings(&form, &measurement).unwrap_err(), &["a missing reading is never filled in"]);
    let case = Case::small("fanuc-30i", "what = \"single-axis\"\nruns = 1");
    let form = text(&case.kit(), "readings-y.csv");
    let head = "target_mm,run,direction,deviation_um\n-75,1,+,\n-40,1,+,\n-5,1,+,\n-5,1,-,\n";
    assert!(form.starts_with(head), "{form}");
    holds(&as_runs(&form).unwrap_err(), &["`deviation_um` is empty, expected a number"]);
}

/// A wrong reversal would follow from the readings: the section and the run turn differently.
#[test]
fn the_job_must_not_describe_another_turn_than_the_run() {
    let turn = |overrun: &str, keys: &str| {
        let stated = format!("order = \"ZXY\"\noverrun = {overrun}");
        let job = read_job(&replaced(&siemens(keys).job(), "order = \"ZXY\"", &stated));
        make(&job, &builtin::profile("siemens-840d-sl").unwrap(), &[])
    };
    let says = "`overrun` is true, but this run turns at the last node";
    holds(&turn("true", "overrun_mm = 0").unwrap_err().render(), &[says]);
    let overrun = |made: Result<ProgramKit, _>| json!(made.unwrap())["overrun"].clone();
    assert_eq!(overrun(turn("true", "")), true);
    assert_eq!(overrun(turn("false", "overrun_mm = 0")), false);
    assert!(overrun(turn("false", "bidirectional = false")).is_null());
    // Another box is another measurement: a note, no refusal.
    holds(&told(&turn("false", "steps = 5").unwrap()), &["box, steps, order, overrun or kind"]);
}

#[test]
fn a_dwell_is_read_by_the_address_of_the_profile() {
    let mut profile = builtin::profile("fanuc-30i").unwrap();
    let facts = profile.program.as_mut().unwrap();
    facts.axis_letters.value = ["U", "V", "W"].map(String::from).to_vec();
    facts.cancel.value.pop();
    let kit = make(&fanuc("").read(), &profile, &[]).unwrap_or_else(|p| panic!("{}", p.render()));
    let program = text(&kit, "O1001.NC");
    assert!(program.contains("N1 G04 X3.0\n") && program.contains("G91 G01 W55.000"), "{program}");
    assert!(program.ends_with("\nG90 G64\nM30\n%\n"), "{program}");
}

#[test]
fn the_axes_that_rest_keep_their_part_of_the_proposed_box() {
    let mut case = Case::small("siemens-840d-sl", "what = \"single-axis\"\naxes = [\"x\"]");
    (case.start[0], case.size[0]) = (0.0, 100.0);
    let proposed = "start_mm = { x = 2.0, y = -75.0, z = -55.0 } and size_mm = { x = 96.0, y = 70.0, z = 110.0 }";
    holds(&case.made().unwrap_err().render(), &[proposed]);
}

fn cases() -> impl Strategy<Value = Case> {
    let of = |list: &'static [&'static str]| prop::sample::select(list);
    let controls = of(&["siemens-840d-sl", "siemens-828d", "fanuc-30i", "fanuc-0i-f", "fanuc-16i"]);
    let kinds = of(&[
        STEP,
        "what = \"straight-diagonal\"",
        "what = \"single-axis\"",
        "what = \"single-axis\"\ntargets = \"offset\"\naxes = [\"z\", \"x\"]",
    ]);
    let ways =
        of(&["", "return = \"diagonal\"", "bidirectional = false", "alignment_pass = false"]);
    let orders = of(&["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"]);
    let edge = (-2_000_000_i32..2_000_000, 500_i32..100_000, 0_i32..5_000);
    let run = (controls, any::<bool>(), kinds, ways, orders);
    (run, (1_usize..7, 1_u32..4, 10_i32..3_000), prop::array::uniform3(edge))
        .prop_map(|((control, inch, kind, way, order), (steps, runs, margin), edges)| {
            // Digits of the control: 0.001 mm, or 0.0001 inch = 0.00254 mm.
            let scale = if inch { 254.0 } else { 100.0 };
            let digit = |count: i32| f64::from(count) * scale / 100_000.0;
            let overrun = match way {
                "" | "alignment_pass = false" => format!("overrun_mm = {:?}\n", digit(margin)),
                _ => String::new(),
            };
            let count = i32::try_from(steps).unwrap();
            Case {
                control,
                unit: if inch { "inch" } else { "mm" },
                low: edges.map(|(start, _, spare)| digit(start - margin - spare)),
                high: edges.map(|(start, step, spare)| digit(start + step * count + margin + spare)),
                start: edges.map(|(start, _, _)| digit(start)),
                size: edges.map(|(_, step, _)| digit(step * count)),
                steps,
                order,
                keys: format!(
                    "{kind}\n{way}\n{overrun}preload_mm = {:?}\nruns = {runs}\nfeed_mm_per_min = 3000\ndwell_s = 2.5",
                    digit(margin)
                ),
            }
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// `make` itself walks its bytes; here the positions go on as a file of readings, taken without a word.
    #[test]
    fn every_machine_gets_programs_that_are_walked(case in cases()) {
        let kit = case.kit();
        let job = case.read();
        let MeasuredData::Diagonals(measurement) = &job.measurement.data else { panic!() };
        let Some(kind) = job.program.as_ref().unwrap().what.path() else {
            for form in kit.files.iter().filter(|file| file.role == FileRole::Readings) {
                let runs = as_runs(&filled(form, |_| "0"));
                prop_assert!(runs.is_ok(), "{}: {}", form.path, runs.unwrap_err());
            }
            return Ok(());
        };
        let measurement = DiagonalMeasurement { kind, ..measurement.clone() };
        let positions = text(&kit, "positions.csv");
        let nominal: Vec<&str> = positions.lines().map(|row| row.split(',').nth(5).unwrap()).collect();
        let form = kit.files.iter().find(|file| file.role == FileRole::Readings).unwrap();
        let read = readings(&filled(form, |line| nominal[line]), &measurement);
        let read = read.unwrap_or_else(|said| panic!("{said}\n{}", case.job()));
        for run in &read.runs {
            // Nominal displacements are no deviations; positions.csv has 1e-6 mm.
            prop_assert!(run.deviations.iter().all(|d| d.um().abs() < 1e-3));
        }
    }

    #[test]
    fn the_proposed_box_fits(case in cases()) {
        let mut large = case.clone();
        (large.start, large.size) = (case.low, [0, 1, 2].map(|i| case.high[i] - case.low[i]));
        let said = large.made().expect_err("the whole travel leaves no room").render();
        let Some((_, proposal)) = said.split_once("start_mm = {") else {
            prop_assert!(said.contains("no box of that many steps fits"), "{said}");
            return Ok(());
        };
        let proposal = proposal.split(" in [program]").next().unwrap().replace(" and ", "\n");
        large.keys += &format!("\nstart_mm = {{{proposal}");
        let kit = large.made();
        prop_assert!(kit.is_ok(), "{}\n{}", kit.unwrap_err().render(), large.job());
    }
}

#[test]
fn a_run_says_what_it_leaves_open() {
    let kinds = |keys: &str, linear: usize| {
        let mut page = Case::small("siemens-840d-sl", keys).job();
        for axis in &["x", "y", "z"][..linear] {
            let section = "[[measurement.step_diagonal.linear]]";
            page += &format!("{section}\naxis = \"{axis}\"\nslope_um_per_m = 1.0\n");
        }
        let job = read_job(&page);
        let open = left_open(&job, job.program.as_ref().unwrap());
        open.iter().map(|found| found.kind::<Open>().unwrap().clone()).collect::<Vec<_>>()
    };
    let [turning, forward] =
        ["overrun_mm = 0", "bidirectional = false"].map(|way| format!("{STEP}\n{way}"));
    let straight = "what = \"straight-diagonal\"\nbidirectional = false";
    let straightness = Open::Straightness { axes: "XY".to_string() };
    for (keys, linear, open) in [
        (&*turning, 0, vec![Open::Scales { given: 0 }, Open::Angles]),
        (&turning, 1, vec![Open::Scales { given: 1 }, Open::Angles]),
        (&turning, 2, vec![Open::Angles]),
        (STEP, 3, vec![Open::Angles, Open::ReversalOfAnAxis]),
        (&forward, 3, vec![Open::Angles, Open::Reversal]),
        (straight, 0, vec![Open::NineErrors, Open::Reversal]),
        ("what = \"single-axis\"\naxes = [\"x\", \"y\"]", 0, vec![straightness]),
    ] {
        assert_eq!(kinds(keys, linear), open, "{keys}, {linear}");
    }
}
