//! Figures by standard: by hand, independent, their laws; files of runs (refused: cases/refuses/standards.txt).
use crate::support::{DIAGONALS, Visit, holds, in_repository, is_shown, page, shared, source};
use nonius::inputs::target_runs::{RunFacts, Runs, Values};
use nonius::machine::findings::StandardFinding;
use nonius::machine::standards::iso_230_2::{self, AxisFigures, Travel};
use nonius::machine::standards::{ByDirection, Condition, Met, diagonal, vdi_3441};
use nonius::quantity::{Direction, PathKind};
use nonius::text::LengthUnit;
use proptest::prelude::*;
use serde_json::{Value, json};
use std::fs;

fn by_name(axis: &AxisFigures, name: &str) -> Option<f64> {
    let of = match name.split_at(1) {
        ("E", way) => (axis.e, way),
        ("R", way) => (axis.r, way),
        ("A", way) => (axis.a, way),
        ("M", _) => return axis.m_um,
        _ => return if name == "B" { axis.b_um } else { axis.b_mean_um },
    };
    match of.1 {
        "_up" => of.0.up_um,
        "_dn" => of.0.down_um,
        _ => of.0.both_um,
    }
}

#[test]
fn measured_stages_give_the_figures_of_an_independent_computation() {
    let Some(data) = shared("iso230-2") else { return };
    let expected = fs::read_to_string(data.join("expected.csv")).unwrap();
    let lines: Vec<&str> = expected.lines().skip(2).collect();
    assert_eq!(lines.len(), 48);
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let text = fs::read_to_string(data.join(format!("iso230_2_{}.csv", cells[0]))).unwrap();
        let runs = read(&text, RunFacts { unit: Some(LengthUnit::Mm), values: None }).unwrap();
        let um = by_name(&iso_230_2::figures(&runs).axis, cells[1]).unwrap();
        let mm: f64 = cells[2].parse().unwrap();
        // Half a unit of the last digit that is printed, and what rounding of the inputs adds.
        let (digits, power) = cells[2].split_once('e').unwrap_or((cells[2], "0"));
        let decimals = digits.split_once('.').map_or(0, |(_, after)| after.len());
        let half = 0.51 * 10_f64.powi(power.parse::<i32>().unwrap() - decimals as i32);
        assert!((um / 1000.0 - mm).abs() <= half, "{line}: got {um} µm");
    }
}

fn two_targets(up: Option<[[f64; 2]; 2]>, down: Option<[[f64; 2]; 2]>) -> Runs {
    let [up, down] = [up, down].map(|way| way.map(|um| um.map(Vec::from).to_vec()));
    Runs::new(vec![0.0, 100.0], up, down).unwrap()
}

/// Means up 0 and 4, down 3 and 3; s up √2 and √2, down 0 and √8.
fn by_hand() -> Runs {
    two_targets(Some([[-1.0, 1.0], [3.0, 5.0]]), Some([[3.0, 3.0], [1.0, 5.0]]))
}

const DUST: f64 = 1e-9;

#[track_caller]
fn near(found: Option<f64>, expected: f64) {
    let found = found.expect("a figure");
    assert!((found - expected).abs() < DUST, "{found}, expected {expected}");
}

#[track_caller]
fn all_near(found: ByDirection, [up, down, both]: [f64; 3]) {
    near(found.up_um, up);
    near(found.down_um, down);
    near(found.both_um, both);
}

#[test]
fn figures_of_iso_230_2_and_vdi_3441_by_hand() {
    let s = 2.0_f64.sqrt();
    let figures = iso_230_2::figures(&by_hand());
    let axis = figures.axis;
    all_near(axis.e, [4.0, 0.0, 4.0]);
    near(axis.m_um, 2.0); // 3.5 − 1.5
    near(axis.b_um, 3.0);
    near(axis.b_mean_um, -1.0); // (−3 + 1)/2
    // Target 1: 2√2 + 0 + 3 = 5.83; 5.66; 0. Target 2: 2√2 + 4√2 + 1 = 9.49; 5.66; 11.31.
    near(figures.targets[0].r.both_um, 2.0 * s + 3.0);
    near(figures.targets[1].r.both_um, 8.0 * s);
    all_near(axis.r, [4.0 * s, 8.0 * s, 8.0 * s]);
    // A down: 3 + 4√2 to 3 − 4√2; of both: 3 + 4√2 down to 0 − 2√2 up.
    all_near(axis.a, [4.0 + 4.0 * s, 8.0 * s, 3.0 + 6.0 * s]);
    // The two common mistakes: E of one direction only, and R without the reversal.
    let runs = two_targets(Some([[0.0; 2], [1.0; 2]]), Some([[10.0; 2], [11.0; 2]]));
    let axis = iso_230_2::figures(&runs).axis;
    all_near(axis.e, [1.0, 1.0, 11.0]);
    all_near(axis.r, [0.0, 0.0, 10.0]);
    let figures = vdi_3441::figures(&by_hand()).unwrap();
    near(Some(figures.u_um), 3.0);
    near(Some(figures.u_mean_um), 2.0);
    near(Some(figures.p_a_um), 2.0);
    near(figures.p_s_um, 9.0 * s); // s̄ = √2/2 and 3√2/2
    // Target 1: 1.5 ± (3 + 3√2)/2 = −2.12 … 5.12; target 2: 3.5 ± (1 + 9√2)/2 = −3.36 … 10.36.
    near(figures.p_um, 1.0 + 9.0 * s);
}

#[test]
fn one_direction_and_one_run_have_their_own_figures_only() {
    let runs = two_targets(None, Some([[0.0, 1.0], [2.0, 3.0]]));
    let axis = iso_230_2::figures(&runs).axis;
    near(axis.e.down_um, 2.0);
    assert!(axis.r.down_um.is_some() && axis.a.down_um.is_some());
    assert_eq!([axis.e.up_um, axis.e.both_um, axis.r.both_um, axis.a.both_um], [None; 4]);
    assert_eq!([axis.m_um, axis.b_um, axis.b_mean_um], [None; 3]);
    assert_eq!(vdi_3441::figures(&runs), None);
    let remarks = iso_230_2::remarks(&runs, span(&runs));
    assert_eq!(remarks[0], StandardFinding::OneWay { way: "up" }.into());
    let um = Some(vec![vec![0.0; 5]; 5]);
    for (up, down, word) in [(um.clone(), None, "down"), (None, um, "up")] {
        let runs = Runs::new(UNEVEN.to_vec(), up, down).unwrap();
        let not = "NOT according to ISO 230-2: unidirectional figures only";
        let expected = format!("{not}: moving {word} was not measured");
        assert_eq!(iso_230_2::label(&conditions(&runs)), expected);
    }
    let um = Some(vec![vec![0.0], vec![2.0]]);
    let runs = Runs::new(vec![0.0, 100.0], um.clone(), um).unwrap();
    let axis = iso_230_2::figures(&runs).axis;
    assert_eq!([axis.e.both_um, axis.b_um, axis.m_um], [Some(2.0), Some(0.0), Some(2.0)]);
    assert_eq!([axis.r, axis.a], [ByDirection::default(); 2]);
    let vdi = vdi_3441::figures(&runs).unwrap();
    assert_eq!((vdi.p_um, vdi.p_s_um), (None, None));
    let remarks = iso_230_2::remarks(&runs, span(&runs));
    assert!(matches!(remarks[0].kind(), Some(StandardFinding::OneRun { .. })));
}

/// Five targets on 400 mm as the standard asks for them.
const UNEVEN: [f64; 5] = [0.0, 101.0, 199.0, 305.0, 400.0];

fn flat(targets_mm: &[f64], count: usize) -> Runs {
    let um = vec![vec![0.0; count]; targets_mm.len()];
    Runs::new(targets_mm.to_vec(), Some(um.clone()), Some(um)).unwrap()
}

fn even(count: u32, step_mm: f64) -> Vec<f64> {
    (0..count).map(|i| step_mm * f64::from(i)).collect()
}

/// From the first to the last target: nothing was stated.
fn span(runs: &Runs) -> Travel {
    Travel::of(runs, None).unwrap()
}

fn conditions(runs: &Runs) -> Vec<Condition> {
    iso_230_2::conditions(runs, span(runs))
}

fn missed(targets_mm: &[f64], count: usize) -> usize {
    Condition::missed(&conditions(&flat(targets_mm, count))).len()
}

#[test]
fn conditions_are_judged_by_length_and_targets_in_a_heap_are_found() {
    for (targets, runs, misses, what) in [
        (&UNEVEN[..], 5, 0, "as the standard asks"),
        (&UNEVEN, 3, 1, "three runs"),
        (&UNEVEN[..4], 5, 1, "four targets"),
        (&even(5, 100.0), 5, 1, "equal distances"),
        (&[0.0, 301.0, 602.0, 901.0, 1202.0, 1500.0], 5, 1, "six targets on 1.5 m"),
        (&even(13, 250.0), 1, 0, "one run above 2 m"),
        (&even(7, 500.0), 1, 1, "every 500 mm"),
        // Five runs are not the one run of an axis above 2 m, and its R and A are not the standard's.
        (&even(10, 250.0), 1, 0, "every 250 mm"),
        (&[even(11, 1.0), vec![2400.0]].concat(), 1, 1, "above 2 m, every 218 mm on average"),
        // r of half a distance to either side: the widest that P_i = (i - 1)p + r can give.
        (&[0.0, 50.0, 250.0, 300.0, 400.0], 5, 0, "the widest"),
    ] {
        assert_eq!(missed(targets, runs), misses, "{what}");
    }
    let label = iso_230_2::label(&conditions(&flat(&UNEVEN, 3)));
    assert!(label.starts_with("NOT according to ISO 230-2: 3 runs up, 3 down"), "{label}");
    let runs = flat(&even(10, 250.0), 5);
    holds(&iso_230_2::label(&conditions(&runs)), &["5 runs up, 5 down"]);
    let remarks = iso_230_2::remarks(&runs, span(&runs));
    assert_eq!(remarks[0], StandardFinding::LongAxis.into());
    let words = Condition::missed(&conditions(&flat(&[0.0, 1.0, 2.2, 3.0, 990.0], 5)));
    assert_eq!(words, ["largest gap 987.0 mm, mean distance 247.5 mm"]);
    let all = conditions(&flat(&UNEVEN, 5));
    assert!(all[..7].iter().all(|of| of.editions == [1997, 2006, 2014]));
    assert_eq!(all[7].editions, [2014], "uncertainty");
    assert!(all.iter().all(|of| of.confidence == "likely"));
}

/// 24.4 to 1024.4 mm is 1000.0000000000001 mm in binary, and 48.3 to 2048.3 mm is more than 2 m.
#[test]
fn lengths_are_judged_without_the_dust_of_binary_fractions() {
    let metre = [24.4, 270.1, 530.3, 790.2, 1024.4];
    assert!(flat(&metre, 5).length_mm() > 1000.0);
    assert_eq!(missed(&metre, 5), 0);
    assert!(conditions(&flat(&metre, 5))[0].asked.ends_with("here 5 or more"));
    let two = [48.3, 270.1, 530.3, 790.2, 1024.4, 1200.0, 1400.0, 1600.0, 1800.0, 2048.3];
    let runs = flat(&two, 5);
    assert!(runs.length_mm() > 2000.0 && !span(&runs).is_long());
    assert_eq!(missed(&two, 5), 0);
}

#[test]
fn a_stated_travel_is_judged_in_place_of_the_targets() {
    let runs = flat(&UNEVEN, 5);
    let missed =
        |mm| Condition::missed(&iso_230_2::conditions(&runs, Travel::of(&runs, Some(mm)).unwrap()));
    assert!(missed(450.0).is_empty());
    assert_eq!(missed(1000.0).len(), 1, "600 mm without a target");
    assert_eq!(missed(1200.0)[0], "5 targets on 1200 mm of travel");
    assert!(missed(2500.0).contains(&"5 runs up, 5 down".to_string()));
    let short = Travel::of(&runs, Some(300.0)).unwrap_err();
    assert!(short.message.contains("the targets are 400 mm apart"));
    let noted = |travel| iso_230_2::remarks(&runs, travel).len();
    assert_eq!(noted(span(&runs)), 1, "judged on the targets, and said so");
    assert_eq!(noted(Travel::of(&runs, Some(450.0)).unwrap()), 0);
}

/// Straight runs carry the name of ISO 230-6 only if they meet what is known of its conditions.
#[test]
fn conditions_of_the_diagonals_are_tested() {
    let runs = flat(&UNEVEN, 3);
    let four = DIAGONALS.map(|name| (name, &runs));
    let straight = |of: &[(&str, &Runs)]| diagonal(of, PathKind::Straight, true).label;
    assert_eq!(straight(&four), "after ISO 230-6 (likely)");
    assert_eq!(straight(&four[..3]), "NOT after ISO 230-6: PPP, NPP, PNP");
    let few = flat(&[0.0, 100.0], 3);
    let with = |npp| straight(&[four[0], ("NPP", npp), four[2], four[3]]);
    assert_eq!(with(&few), "NOT after ISO 230-6: NPP: 2 targets on 100 mm");
    let one_way = Runs::new(UNEVEN.to_vec(), Some(vec![vec![0.0; 3]; 5]), None).unwrap();
    assert!(with(&one_way).ends_with("moving down was not measured"));
    let found = diagonal(&four, PathKind::Step, true);
    assert_eq!(found.conditions.list[0].met, Met::No, "single-axis steps");
    // Figures of the machine need all four.
    let runs = by_hand();
    let four = DIAGONALS.map(|name| (name, &runs));
    let found = diagonal(&four[..3], PathKind::Straight, true);
    assert_eq!((found.e_d_um, found.largest_range_um), (None, None));
    let found = diagonal(&four, PathKind::Straight, true);
    near(found.e_d_um, 4.0);
    near(found.b_d_um, 3.0);
    near(found.range_over_all_um, 4.0);
}

#[test]
fn the_page_shows_what_the_program_prints() {
    let printed = in_repository("standards fixtures/standards/x_axis.csv").ends(0).all();
    let printed = printed.replace('\\', "/"); // `\` of Windows
    is_shown(&page("docs/standards.md"), "checked by tests/it/standards.rs", &printed);
}

#[test]
fn the_json_names_units_and_leaves_absent_figures_null() {
    let visit = Visit::new();
    visit.put("runs.csv", "target_mm,up1_mm\n0,0.001\n100,100.003\n");
    let document = visit.run("standards --format json runs.csv").json();
    let iso = &document["iso_230_2"];
    assert_eq!((&document["schema"], &iso["E_up_um"]), (&json!(1), &json!(2.0)));
    assert_eq!([&iso["E_um"], &iso["R_up_um"], &document["vdi_dgq_3441"]], [&Value::Null; 3]);
    assert_eq!(iso["condition_missed"], true);
}

fn any_runs() -> impl Strategy<Value = (Vec<Vec<f64>>, Vec<Vec<f64>>)> {
    (2..6_usize, 2..6_usize).prop_flat_map(|(targets, count)| {
        let um = || prop::collection::vec(prop::collection::vec(-50.0..50.0, count), targets);
        (um(), um())
    })
}

fn runs_of(up: &[Vec<f64>], down: &[Vec<f64>]) -> Runs {
    let targets = (0..up.len()).map(|index| index as f64 * 100.0).collect();
    Runs::new(targets, Some(up.to_vec()), Some(down.to_vec())).unwrap()
}

/// A E R of three kinds, M, B, B̄, and P, P_a, P_s, U.
fn all_figures(runs: &Runs) -> Vec<f64> {
    let axis = iso_230_2::figures(runs).axis;
    let vdi = vdi_3441::figures(runs).unwrap();
    let triples = [axis.a, axis.e, axis.r].map(|of| [of.up_um, of.down_um, of.both_um]);
    let others = [axis.m_um, axis.b_um, axis.b_mean_um, vdi.p_um, vdi.p_s_um];
    let others = others.into_iter().chain([Some(vdi.p_a_um), Some(vdi.u_um)]);
    triples.into_iter().flatten().chain(others).map(|figure| figure.unwrap()).collect()
}

fn same(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < DUST)
}

proptest! {
    #[test]
    fn a_constant_moves_means_and_nothing_else((mut up, mut down) in any_runs(), constant in -100.0..100.0_f64) {
        let before = runs_of(&up, &down);
        up.iter_mut().chain(&mut down).flatten().for_each(|um| *um += constant);
        let after = runs_of(&up, &down);
        prop_assert!(same(&all_figures(&before), &all_figures(&after)));
        let pairs = (iso_230_2::figures(&before), iso_230_2::figures(&after));
        for (before, after) in pairs.0.targets.iter().zip(&pairs.1.targets) {
            let moved: f64 = after.mean.both_um.unwrap() - before.mean.both_um.unwrap();
            prop_assert!((moved - constant).abs() < DUST);
        }
    }

    #[test]
    fn directions_exchanged_turn_the_sign_of_the_reversal((up, down) in any_runs()) {
        let (a, b) = (runs_of(&up, &down), runs_of(&down, &up));
        let (a, b) = (iso_230_2::figures(&a).axis, iso_230_2::figures(&b).axis);
        near(b.b_mean_um, -a.b_mean_um.unwrap());
        near(b.b_um, a.b_um.unwrap());
        for (a, b) in [(a.a, b.a), (a.e, b.e), (a.r, b.r)] {
            all_near(b, [a.down_um, a.up_um, a.both_um].map(Option::unwrap));
        }
    }

    #[test]
    fn the_order_of_the_runs_does_not_matter((mut up, mut down) in any_runs(), by in 0..5_usize) {
        let before = all_figures(&runs_of(&up, &down));
        for of in up.iter_mut().chain(&mut down) {
            let by = by % of.len();
            let (one, other) = of.split_at_mut(by);
            one.reverse();
            other.reverse();
        }
        prop_assert!(same(&before, &all_figures(&runs_of(&up, &down))));
    }

    #[test]
    fn figures_keep_their_order((up, down) in any_runs()) {
        let axis = iso_230_2::figures(&runs_of(&up, &down)).axis;
        let [a, e, r] = [axis.a, axis.e, axis.r].map(|of| of.both_um.unwrap());
        prop_assert!(a >= e - DUST && e >= axis.m_um.unwrap() - DUST);
        prop_assert!(r >= axis.b_um.unwrap() - DUST && a >= r - DUST);
        prop_assert!(e >= axis.e.up_um.unwrap() && e >= axis.e.down_um.unwrap());
    }
}

fn read(text: &str, stated: RunFacts) -> Result<Runs, String> {
    Runs::read(&source("runs.csv", text), stated).map_err(|problems| problems.render())
}

fn first_run(runs: &Runs, direction: Direction) -> Vec<f64> {
    runs.deviations_um(direction).unwrap().iter().map(|um| um[0]).collect()
}

const DEVIATIONS: RunFacts = RunFacts { unit: None, values: Some(Values::Deviations) };

#[test]
fn layouts_units_and_values_agree() {
    let open = RunFacts::default();
    let by_sign =
        "run,direction,target_mm,deviation_um\n7,+,25.4,2\n7,+,50.8,4\n8,-,50.8,0\n8,-,25.4,1\n";
    let by_word = "run,direction,target_in,position_mm\n1,up,1,25.402\n1,up,2,50.804\n1,dn,2,50.8\n1,down,1,25.401\n";
    let unit = |unit| RunFacts { unit: Some(unit), values: None };
    let files = [
        ("target_mm,up1_mm,dn1_mm\n25.4,25.402,25.401\n50.8,50.804,50.8\n", open),
        ("i,target,up1,dn1\n1,25.4,25.402,25.401\n2,50.8,50.804,50.8\n", unit(LengthUnit::Mm)),
        ("target,up1,down1\n25400,25402,25401\n50800,50804,50800\n", unit(LengthUnit::Um)),
        ("target_in;up1_um;dn1_um\n2;4;0\n1;2;1\n", DEVIATIONS),
        ("target_uin,up1_mm,dn1_mm\n1000000,0.002,0.001\n2000000,0.004,0\n", DEVIATIONS),
        ("target_mm,\"up1_mm\",dn1_mm\n25.4,\"25.402\",25.401\n\"50.8\",50.804,50.8\n", open),
        ("target_mm;up1_mm;dn1_mm\r\n25,4;25,402;25,401\r\n50,8;50,804;50,8\r\n", open),
        ("target_mm,up1_mm,dn1_um\n25.4,0.002,1\n50.8,0.004,0\n", DEVIATIONS),
        (by_sign, open),
        (by_word, open),
    ];
    for (text, stated) in files {
        let runs = read(text, stated).unwrap_or_else(|words| panic!("{words}"));
        let [up, down] = Direction::BOTH.map(|direction| first_run(&runs, direction));
        let found = [runs.targets_mm().to_vec(), up, down].concat();
        assert!(same(&found, &[25.4, 50.8, 2.0, 4.0, 1.0, 0.0]), "{text}\n{found:?}");
    }
}

/// Positions are taken without a word only where the values leave no doubt (fixtures/cases/refuses/standards.txt).
#[test]
fn values_that_can_be_both_are_taken_as_stated_and_targets_may_be_closer_than_deviations() {
    let around_zero = "target_mm,up1_mm,dn1_mm\n-50,-0.003,-0.001\n50,0.003,0.002\n";
    let positions = "target_mm,up1_mm,dn1_mm\n-50,-50.003,-50.001\n50,50.003,50.002\n";
    assert!(read(positions, RunFacts::default()).is_ok());
    for (values, expected) in [(Values::Deviations, -3.0), (Values::Positions, 49997.0)] {
        let runs = read(around_zero, RunFacts { unit: None, values: Some(values) }).unwrap();
        near(Some(first_run(&runs, Direction::Plus)[0]), expected);
    }
    // Steps of 20 µm with a deviation of 11 µm: half the way to the next target is nothing unusual.
    let runs = "target_mm,up1_um\n0,1\n0.02,2\n0.04,11\n";
    let named = "target_mm,run,direction,deviation_um\n0,1,+,1\n0.02,1,+,2\n0.04,1,+,11\n";
    for (text, stated) in [(runs, DEVIATIONS), (named, RunFacts::default())] {
        near(Some(first_run(&read(text, stated).unwrap(), Direction::Plus)[0]), 1.0);
    }
}

#[test]
fn runs_that_are_not_complete_cannot_be_made() {
    for (targets, up, words) in [
        (vec![0.0], None, "expected two targets or more"),
        (vec![0.0, 0.0], None, "each larger"),
        (vec![0.0, f64::NAN], None, "each larger"),
        (vec![0.0, 1.0], None, "one direction or both"),
        (vec![0.0, 1.0], Some(vec![vec![0.0, 1.0], vec![0.0]]), "not complete"),
        (vec![0.0, 1.0], Some(vec![vec![], vec![]]), "not complete"),
        (vec![0.0, 1.0], Some(vec![vec![0.0], vec![f64::NAN]]), "as many finite"),
    ] {
        let message = Runs::new(targets, up, None).unwrap_err().message;
        assert!(message.contains(words), "{words}: {message}");
    }
}
