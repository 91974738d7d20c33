use super::*;
use crate::control::controller::{Dialect, ProfileSource, builtin, load};
use crate::control::table::Point;
use crate::text::Source;

fn facts_of(profile: &str) -> DeclaredFacts {
    match builtin::profile(profile).unwrap().dialect {
        Dialect::Declared(facts) => facts,
        other => panic!("{other:?}"),
    }
}

fn weihong() -> DeclaredFacts {
    facts_of("weihong")
}

/// The facts of a profile on top of `weihong`.
fn own(facts: &[(&str, &str)]) -> Result<DeclaredFacts, Problems> {
    on_top_of("weihong", facts)
}

fn on_top_of(below: &str, facts: &[(&str, &str)]) -> Result<DeclaredFacts, Problems> {
    let mut page = format!("schema = 1\nid = \"own\"\nname = \"own\"\nbased_on = \"{below}\"\n");
    for (name, value) in facts {
        page += &format!(
            "[facts.{name}]\nvalue = {value}\nevidence = \"manual\"\nsource = \"a page\"\n"
        );
    }
    let source = Source::from_bytes("own.toml", page.as_bytes())?;
    let find = |name: &str, _: bool| builtin::template(name);
    let origin = ProfileSource::File("own.toml".to_string());
    match load::profile(source, origin, &find, &builtin::page)?.dialect {
        Dialect::Declared(facts) => Ok(facts),
        other => panic!("{other:?}"),
    }
}

fn refused(facts: &DeclaredFacts, text: &str) -> String {
    read(&[("file.dat", text)], facts).unwrap_err().render()
}

#[test]
fn sections_of_a_file_are_tables() {
    let text = "; screw, drilling unit 5\n;UNIT = MM\nunit=mm\n[X]\n-570.025, 0.027, 0.083\n-450.020, 0.025, 0.077\n\n[y]\r\n0.000, 0.000, 0.030\r\n1000.00,0.0,.03\r\n";
    let found = read(&[("axeserr.dat", text)], &weihong()).unwrap().tables;
    let point = |position, forward, reverse| Point { position, forward, reverse: Some(reverse) };
    assert_eq!(found.len(), 2);
    assert_eq!(found[0].name(), "table of X");
    assert_eq!(found[0].points, [point(-570.025, 0.027, 0.083), point(-450.02, 0.025, 0.077)]);
    assert_eq!(found[1].points[1], point(1000.0, 0.0, 0.03));
}

#[test]
fn what_is_lost_doubled_or_foreign_is_refused_at_its_place() {
    let facts = weihong();
    for (text, says) in [
        ("[X]\n0, 0, 0\nunits = mm\n1, 0, 0\n", "file.dat:3:1"),
        ("[X]\n0, 0, 0\nunits = mm\n1, 0, 0\n", "no pattern of the profile takes this line"),
        (";unit=inch\n[X]\n0, 0, 0\n1, 0, 0\n", "the file is in `inch`, the profile is not"),
        (";unit=inch\n[X]\n0, 0, 0\n1, 0, 0\n", "file.dat:1:7"),
        (" ;unit=inch\n[X]\n0, 0, 0\n1, 0, 0\n", "the file is in `inch`"),
        (";unit=inch ; NK200\n[X]\n0, 0, 0\n1, 0, 0\n", "a comment that may name a unit"),
        (";unit:inch\n[X]\n0, 0, 0\n1, 0, 0\n", "a comment that may name a unit"),
        ("; Unit inch\n[X]\n0, 0, 0\n1, 0, 0\n", "a comment that may name a unit"),
        ("; the unit is inch\n[X]\n0, 0, 0\n1, 0, 0\n", "a comment that may name a unit"),
        ("unit = furlong\n[X]\n0, 0, 0\n1, 0, 0\n", "the file is in `furlong`"),
        ("0, 0, 0\n1, 0, 0\n", "no line says of which axis"),
        ("[X]\n0, 0, 0\n0, 1, 0\n", "position 0 does not lie above 0"),
        ("[X]\n0, 0, 0\n", "has 1 points"),
        ("[X]\n0, 0, 0\n1, 0, 1.2.3\n", "`reverse` is `1.2.3`, expected a number"),
        ("; nothing\n", "no line of the files holds a value"),
        (
            "[X]\n0, 0, 0\n5, 0, 0\n[Y]\n0, 0, 0\n5, 0, 0\n[x]\n9, 0, 0\n8, 0, 0\n",
            "position 8 does not lie above 9",
        ),
    ] {
        let words = refused(&facts, text);
        assert!(words.contains(says), "{text}\n{words}");
    }
    let two = [("a.dat", "[X]\n0,0,0\n1,0,0\n"), ("b.dat", "[X]\n0,0,0\n1,0,0\n")];
    let words = read(&two, &facts).unwrap_err().render();
    assert!(words.contains("`b.dat` holds another table of X"), "{words}");
}

/// `table[3].pos 12`: the fields of a point stand in several lines, the axes in lines before them.
#[test]
fn fields_of_a_point_stand_in_several_lines() {
    let lines = r"['axis (?<axis>\d)', 'count (?<count>\d+)', 'master (?<base>\d)', 't.(?<point>\d+). at (?<position>\S+)', 't.(?<point>\d+). up (?<forward>\S+)', 't.(?<point>\d+). down (?<reverse>\S+)', 't.(?<point>\d+). v (?<value>\S+)']";
    let facts = own(&[("lines", lines), ("cross_terms", "2"), ("comments", "false")]).unwrap();
    let own_table =
        "axis 1\ncount 2\nt[0] at 0\nt[1] at 5\nt[0] up 1\nt[0] down 2\nt[1] up 3\nt[1] down 4\n";
    let cross = "master 2\nt[0] at 0\nt[0] v 7\nt[1] at 5\nt[1] v 8\n";
    let text = format!("{own_table}{cross}");
    let found = read(&[("a.lis", &text)], &facts).unwrap().tables;
    assert_eq!(found[0].points[1].reverse, Some(4.0));
    assert_eq!(found[1].name(), "table of 1 by 2");
    assert_eq!((found[1].points[0].forward, found[1].points[0].reverse), (7.0, None));
    for (changed, says) in [
        (text.replace("count 2", "count 3"), "the file says 3 here, its points make it 2"),
        (text.replace("t[1] up 3\n", ""), "a point without `forward`"),
        (text.replace("t[1] at 5\nt[0] up", "t[0] up"), "a point without `position`"),
        (text.replace("t[0] v 7", "t[0] up 7"), "a point without `value`"),
        (text.replace("t[1]", "t[2]"), "the point 1 of the table of 1 was expected here"),
        (format!("{text}t[0] v 7\n"), "a second `value` here"),
    ] {
        let words = refused(&facts, &changed);
        assert!(words.contains(says), "{says}\n{words}");
    }
}

#[test]
fn what_a_file_says_twice_is_the_same() {
    let text = "kopf.achs_nr 1\nkw.ssfk.kw_startpos 5\nkw.ssfk.table[0].setpoint 5\nkw.ssfk.table[0].pos 0\nkw.ssfk.table[0].neg 0\n\
                kw.ssfk.table[1].setpoint 9\nkw.ssfk.table[1].pos 0\nkw.ssfk.table[1].neg 0\n";
    let facts = facts_of("isg-axis");
    assert!(read(&[("a.lis", text)], &facts).is_ok());
    let words = refused(&facts, &text.replace("startpos 5", "startpos 1000000"));
    assert!(words.contains("file.dat:2:21"), "{words}");
    assert!(words.contains("the file says 1000000 here, its points make it 5"), "{words}");
}

#[test]
fn nothing_changes_before_the_first_point() {
    let lines = r"['AXIS (?<axis>[XYZ])', '(?<position>\S+) (?<value>\S+)']";
    let facts = own(&[
        ("lines", lines),
        ("value_form", "\"increment\""),
        ("backlash", "\"adds\""),
        ("comments", "false"),
    ]);
    let facts = facts.unwrap();
    let text = "AXIS X\n0 0\n100 7\n";
    assert!(read(&[("a.txt", text)], &facts).is_ok());
    let words = refused(&facts, &text.replace("0 0", "0 7"));
    assert!(words.contains("file.dat:2:1"), "{words}");
    assert!(words.contains("the first increment of the table of X is 7, expected 0"), "{words}");
}

/// The first position and the distance; the name of the file says the axis.
#[test]
fn places_are_counted_from_the_start_and_the_axis_stands_in_the_name() {
    let lines = r"['start (?<start>\S+) step (?<spacing>\S+)', '(?<forward>\S+) (?<reverse>\S+)']";
    let name = r"['(?<axis>[a-z])-table\.txt']";
    let facts = own(&[("lines", lines), ("file_name", name)]).unwrap();
    let found =
        read(&[("kit/x-table.txt", "start -10 step 2.5\n1 2\n3 4\n5 6\n")], &facts).unwrap();
    let places: Vec<f64> = found.tables[0].points.iter().map(|point| point.position).collect();
    assert_eq!(
        (found.tables[0].name().as_str(), &places[..]),
        ("table of x", &[-10.0, -7.5, -5.0][..])
    );
    assert!(refused(&facts, "start 0 step 1\n1 2\n3 4\n").contains("no line says of which axis"));
}

/// A .cma says by the names of files which table an axis has, so a table stands in the file of its axis.
#[test]
fn a_table_in_the_file_of_another_axis_is_refused() {
    let facts = facts_of("heidenhain-com");
    let of = |axis| format!("AXISPOS BACKLASH {axis}\n0.0 0.0 0.0\n100.0 0.001 0.002\n");
    let (x, y) = (of("X"), of("Y"));
    let all = |of_x: &str, of_y: &str, active: &str| {
        let texts = [("read-X.com", of_x), ("READ-Y.COM", of_y), ("config.cma", active)];
        read(&texts, &facts).map_err(|problems| problems.render())
    };
    let active = "ACTIVE X Y\n* read-X.com READ-Y.COM\n";
    assert_eq!(all(&x, &y, active).unwrap().tables.len(), 2);
    let words = all(&y, &x, active).unwrap_err();
    assert!(words.contains("read-X.com:1:18") && words.contains("READ-Y.COM:1:18"), "{words}");
    assert!(words.contains("another axis than `X` in the name of the file"), "{words}");
    let words = all(&x, &y, "ACTIVE X Y\n* READ-Y.COM read-X.com\n").unwrap_err();
    assert!(words.contains("config.cma:2:1"), "{words}");
}

/// ACS SPiiPlus: values by the name of their table, its axes in a formula that sums up to three.
#[test]
fn a_table_is_told_by_its_name() {
    let Dialect::Declared(facts) = builtin::profile("acs-spiiplus").unwrap().dialect else {
        panic!("it is declared");
    };
    let text = "GLOBAL REAL A(2)\nA(0) = 0.001\nA(1) = 0.002\nGLOBAL REAL B(2)\nB(0) = 0\nB(1) = -0.003\n\
                CONNECT RPOS(0) = APOS(0) + MAP(APOS(0), A, -10, 5) + MAP(APOS(1), B, 0, 2.5)\nSTOP\n";
    let found = read(&[("m.prg", text)], &facts).unwrap().tables;
    let seen = found.iter().map(|own| (own.name(), own.points[1].position, own.points[1].forward));
    let expected = [("table of 0", -5.0, 0.002), ("table of 0 by 1", 2.5, -0.003)];
    let expected = expected.map(|(name, place, value)| (name.to_string(), place, value));
    assert_eq!(seen.collect::<Vec<_>>(), expected);
    let again = "STOP\nCONNECT RPOS(1) = APOS(1) + MAP(APOS(1), A, -10, 5)";
    for (from, to, says) in [
        (", B, 0", ", C, 0", "no line says which axes the table `B` is for"),
        (", B, 0", ", C, 0", "the table of 0 by 1 has 0 points"),
        ("APOS(1), B", "APOS(0), B", "holds another table of 0"),
        ("STOP", again, "file.dat:9:1"),
        ("STOP", again, "a second pair of axes for this table"),
        ("= APOS(0) +", "= APOS(1) +", "file.dat:7:24"),
        ("= APOS(0) +", "= APOS(1) +", "another axis than `0`, which the line corrects"),
        ("B(2)", "B(3)", "the file says 3 here, its points make it 2"),
    ] {
        let words = refused(&facts, &text.replace(from, to));
        assert!(words.contains(says), "{to}\n{words}");
    }
}

#[test]
fn switches_and_patterns_that_do_not_fit_are_refused_with_their_place() {
    for (fact, value, says) in [
        (
            "lines",
            r"['(?<axis>[XYZ])', '(?<position>\S+) (?<foward>\S+) (?<reverse>\S+)']",
            "unknown field `foward`, did you mean `forward`?",
        ),
        (
            "lines",
            r"['(?<axis>[XYZ])', '(?<position>\S+) (?<forward>\S+)']",
            "no pattern has the field `value`",
        ),
        (
            "lines",
            r"['(?<position>\S+) (?<forward>\S+) (?<reverse>\S+)']",
            "no pattern has the field `axis`",
        ),
        ("lines", r"['(?<axis>[XYZ)']", "is no regular expression"),
        (
            "lines",
            r"['(?<axis>[XYZ])', '(?<forward>\S+) (?<reverse>\S+)']",
            "no pattern has the field `start`",
        ),
        ("value_form", "\"increment\"", "`value_form` is out of range, expected `amount`"),
        ("position_size", "12.5", "`position_size` is out of range"),
        ("value_size", "\"yard\"", "expected one of `mm`, `um`, `inch`, `detection_unit`"),
        ("comments", "true", "the sign that begins a comment"),
        ("outside", "\"fade\"", "expected one of `hold`, `zero`, `unknown`"),
    ] {
        let words = own(&[(fact, value)]).unwrap_err().render();
        assert!(words.contains(says), "{fact} = {value}\n{words}");
        assert!(words.contains("own.toml:"), "{fact} = {value}\n{words}");
    }
    let words = own(&[("cross_terms", "1")]).unwrap_err().render();
    assert!(words.contains("two columns of a table that follows another axis"), "{words}");
}

fn klipper() -> DeclaredFacts {
    facts_of("klipper-skew")
}

/// The set and the factors of a text of Klipper.
fn skew(text: &str) -> Result<(Option<String>, Vec<f64>), String> {
    let facts = klipper();
    let read = read(&[("printer.cfg", text)], &facts).map_err(|problems| problems.render())?;
    Ok((read.set, read.tables.iter().map(|own| own.points[0].forward).collect()))
}

/// A printer.cfg as SAVE_CONFIG leaves it: the profile stands behind `#*#`.
#[test]
fn a_saved_set_of_factors_is_read() {
    let text = "[printer]\nkinematics: corexy\n[skew_correction]\n#*# <---- SAVE_CONFIG ---->\n\
                #*# [skew_correction my_skew_profile]\n#*# xy_skew = -0.001\n#*# xz_skew = 0.0\n\
                #*# yz_skew = 2.5e-4\n#*#\n#*# [bed_mesh default]\n#*# version = 1\n";
    let expected = (Some("my_skew_profile".to_string()), vec![-0.001, 0.0, 0.000_25]);
    assert_eq!(skew(text), Ok(expected));
    assert_eq!(skew("[printer]\n[skew_correction]\n"), Ok((None, Vec::new())));
    assert!(skew("[skew_correction]\n").is_err());
    assert!(skew("[gcode_macro a]\ngcode = M117\n").is_err(), "the set may stand elsewhere");
    assert!(
        skew("[skew_correction a]\nxy_skew = 0.0e0\nxz_skew = 0e+00\nyz_skew = -.5e-3\n").is_ok()
    );
}

/// What the numbers of a fixed format mean is no fact of a control: a sign that is turned there would pass every check.
#[test]
fn a_format_that_has_a_rule_takes_no_fact_against_it() {
    for (below, facts) in [
        ("generic", ["own_sign", "cross_sign", "value_size", "value_form"]),
        ("klipper-skew", ["own_sign", "points", "value_size", "value_unit"]),
    ] {
        assert!(on_top_of(below, &[]).is_ok());
        for fact in facts {
            let words = on_top_of(below, &[(fact, "\"as_error\"")]).unwrap_err().render();
            assert_eq!(words.matches("problem: ").count(), 1, "{below}: {words}");
            let says = match (below, fact) {
                ("klipper-skew", "own_sign") => "one excludes the other".to_string(),
                _ => format!("unknown key `{fact}`"),
            };
            assert!(words.contains(&says), "{below}: {words}");
        }
    }
}

/// A machine with two axes has the factors of the third one, too: they are 0.
#[test]
fn a_factor_of_0_needs_no_axis() {
    use crate::control::control_state::AxisState;
    use crate::quantity::{Direction, Millimetres};
    let facts = klipper();
    let axis = |name: &str| AxisState {
        reference_direction: Direction::Minus,
        ..AxisState::plain(name, [0.0, 100.0])
    };
    let unit = crate::control::controller::ControlUnit::Millimetre;
    let state = ControlState { unit, axes: vec![axis("x"), axis("y")] };
    let of = |yz: &str| {
        let text = format!("[skew_correction a]\nxy_skew = 0.001\nxz_skew = 0\nyz_skew = {yz}\n");
        Tables::Listed(read(&[("printer.cfg", &text)], &facts).unwrap())
    };
    let control = facts.control(&of("0"), &state).expect("a control");
    let moved = control.response("y", "x", Direction::Plus).expect("a response");
    let um = moved.correction(Millimetres::new(100.0)).um();
    assert!((um + 100.0).abs() < 1e-9, "{um}");
    assert!(facts.control(&of("0.002"), &state).is_err());
}

/// A configuration that loads nothing is none of the kit's, and of two files with a set the control loads one.
#[test]
fn a_configuration_beside_the_kit_is_of_concern_with_a_set() {
    let set = "[printer]\n[skew_correction a]\nxy_skew = 0\nxz_skew = 0\nyz_skew = 0\n";
    assert!(!klipper().may_obey("[printer]\nkinematics: corexy\n"));
    assert!(klipper().may_obey(set));
    let both = read(&[("a.cfg", set), ("printer.cfg", set)], &klipper()).unwrap_err().render();
    assert!(both.contains("printer.cfg:2:18"), "{both}");
    assert!(both.contains("a second set beside `a`"), "{both}");
}

#[test]
fn factors_that_are_lost_doubled_or_foreign_are_refused_at_their_place() {
    let own = "[skew_correction a]\n# a comment\nxy_skew: 0.001 # half a degree\nxz_skew = 0\nyz_skew = 0\n";
    assert!(skew(own).is_ok());
    for (from, to, words) in [
        ("yz_skew = 0\n", "", "a set without yz_skew"),
        ("yz_skew = 0\n", "", "printer.cfg:1:18"),
        ("0.001", "0,001", "printer.cfg:3:1"),
        ("0.001", "1.5", "`1.5`, expected a factor below 1"),
        ("0.001", "15e-1", "`15e-1`, expected a factor below 1"),
        ("yz_skew", "[skew_correction]\nyz_skew", "a set without yz_skew"),
        ("xz_skew", "xy_skew", "a second `value` here"),
        ("xz_skew", "zx_skew", "no line says which axes the table `zx_skew` is for"),
        ("xz_skew = 0", "xz_skew", "printer.cfg:4:1"),
        ("yz_skew = 0", "yz_skew = 0\n[skew_correction b]\nxy_skew=0", "printer.cfg:6:18"),
        ("yz_skew = 0", "yz_skew = 0\n[skew_correction b]\nxy_skew=0", "a second set beside `a`"),
    ] {
        let told = skew(&own.replace(from, to)).unwrap_err();
        assert!(told.contains(words), "{to}: {told}");
    }
    for wrong in ["1.5", "1e9", "1.2.3", "0,001"] {
        let told = skew(&own.replace("0.001", wrong)).unwrap_err();
        assert_eq!(told.matches("printer.cfg:").count(), 1, "one complaint is enough: {told}");
    }
}
