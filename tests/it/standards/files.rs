//! Files of runs of one axis: layouts, units, and what is wrong with them.

use super::*;

fn read(text: &str, stated: Stated) -> Result<Runs, String> {
    let source = Source::from_bytes("runs.csv", text.as_bytes()).unwrap();
    Runs::read(&source, stated).map_err(|problems| problems.render())
}

/// Deviations of the first run at every target.
fn first_run(runs: &Runs, direction: Direction) -> Vec<f64> {
    runs.deviations_um(direction).unwrap().iter().map(|um| um[0]).collect()
}

const DEVIATIONS: Stated = Stated { unit: None, values: Some(Values::Deviations) };

#[test]
fn layouts_units_and_values_agree() {
    let open = Stated::default();
    let unit = |unit| Stated { unit: Some(unit), values: None };
    let files = [
        ("target_mm,up1_mm,dn1_mm\n25.4,25.402,25.401\n50.8,50.804,50.8\n", open),
        ("i,target,up1,dn1\n1,25.4,25.402,25.401\n2,50.8,50.804,50.8\n", unit(LengthUnit::Mm)),
        ("target,up1,down1\n25400,25402,25401\n50800,50804,50800\n", unit(LengthUnit::Um)),
        ("target_in;up1_um;dn1_um\n2;4;0\n1;2;1\n", DEVIATIONS),
        ("target_uin,up1_mm,dn1_mm\n1000000,0.002,0.001\n2000000,0.004,0\n", DEVIATIONS),
        ("target_mm,\"up1_mm\",dn1_mm\n25.4,\"25.402\",25.401\n\"50.8\",50.804,50.8\n", open),
        ("target_mm;up1_mm;dn1_mm\r\n25,4;25,402;25,401\r\n50,8;50,804;50,8\r\n", open),
        ("target_mm,up1_mm,dn1_um\n25.4,0.002,1\n50.8,0.004,0\n", DEVIATIONS),
        (
            "run,direction,target_mm,deviation_um\n7,+,25.4,2\n7,+,50.8,4\n8,-,50.8,0\n8,-,25.4,1\n",
            open,
        ),
        (
            "run,direction,target_in,position_mm\n1,up,1,25.402\n1,up,2,50.804\n1,dn,2,50.8\n1,down,1,25.401\n",
            open,
        ),
    ];
    for (text, stated) in files {
        let runs = read(text, stated).unwrap_or_else(|words| panic!("{words}"));
        let [up, down] = Direction::BOTH.map(|direction| first_run(&runs, direction));
        let found = [runs.targets_mm().to_vec(), up, down].concat();
        assert!(same(&found, &[25.4, 50.8, 2.0, 4.0, 1.0, 0.0]), "{text}\n{found:?}");
    }
}

#[test]
fn a_separator_in_quotation_marks_separates_nothing() {
    let text = "target_mm;up1_mm;dn1_mm\n0;\"0,001\";\"0;002\"\n";
    let words = read(text, Stated::default()).unwrap_err();
    assert!(words.contains("`dn1_mm` is `0;002`, expected a finite number"), "{words}");
    assert!(!words.contains("cells"), "{words}");
}

/// Positions are taken without a word only where the values leave no doubt.
#[test]
fn values_that_can_be_both_are_asked_for() {
    let open = |text: &str| read(text, Stated::default()).unwrap_err();
    let around_zero = "target_mm,up1_mm,dn1_mm\n-50,-0.003,-0.001\n50,0.003,0.002\n";
    assert!(open(around_zero).contains("they look like deviations"));
    let tiny = "target_mm,up1_mm\n-0.001,-0.0013\n0.001,0.0004\n";
    assert!(open(tiny).contains("they are far from the targets as either"));
    let positions = "target_mm,up1_mm,dn1_mm\n-50,-50.003,-50.001\n50,50.003,50.002\n";
    assert!(read(positions, Stated::default()).is_ok());
    for (values, expected) in [(Values::Deviations, -3.0), (Values::Positions, 49997.0)] {
        let runs = read(around_zero, Stated { unit: None, values: Some(values) }).unwrap();
        near(Some(first_run(&runs, Direction::Plus)[0]), expected);
    }
}

/// Steps of 20 µm with a deviation of 11 µm: half the way to the next target is nothing unusual.
#[test]
fn targets_may_be_closer_than_the_deviations() {
    let runs = "target_mm,up1_um\n0,1\n0.02,2\n0.04,11\n";
    let named = "target_mm,run,direction,deviation_um\n0,1,+,1\n0.02,1,+,2\n0.04,1,+,11\n";
    for (text, stated) in [(runs, DEVIATIONS), (named, Stated::default())] {
        near(Some(first_run(&read(text, stated).unwrap(), Direction::Plus)[0]), 1.0);
    }
}

/// All problems of a file come at once, each with line and column.
#[test]
fn every_cell_that_is_wrong_is_named() {
    let text = "target_mm,up1_mm,up2_mm\n0,,0.001\nten,10.001,10.002\n20,20.001,1e12\n30,30.001\n";
    let words = read(text, Stated::default()).unwrap_err();
    for expected in [
        "runs.csv:2:3",
        "`up1_mm` is empty",
        "runs.csv:3:1",
        "`target_mm` is `ten`",
        "runs.csv:4:11",
        "too large for any machine",
        "the row has 2 cells, expected 3",
    ] {
        assert!(words.contains(expected), "`{expected}` is not said:\n{words}");
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
