//! The way back on a Siemens control, from what was read out of it.

use super::*;
use nonius::control::table::siemens::MachineValue;
use nonius::control::table::siemens::{Place, SiemensTable, SiemensTables};
use nonius::read::{ReadBack, read, read_apart};
use std::collections::BTreeMap;

/// What lies in a control: its tables, and machine data by name and indices.
#[derive(Clone, Debug, Default, PartialEq)]
struct Control {
    tables: SiemensTables,
    data: BTreeMap<String, f64>,
}

impl Control {
    fn load(&mut self, files: ReadBack) {
        let Tables::Siemens(tables) = files.tables else { panic!("it is a Siemens control") };
        for new in tables.tables {
            self.tables.tables.retain(|t| t.place != new.place);
            self.tables.tables.push(new);
        }
        self.tables.tables.sort_by_key(|t| t.place.clone());
        for datum in files.machine_data.into_iter().flat_map(|file| file.data) {
            let MachineValue::Number(value) = datum.value else { panic!("a number") };
            self.data.insert(datum.variable.trim_start_matches('$').to_string(), value);
        }
    }

    fn set(&mut self, datum: &str, value: f64) {
        self.data.insert(datum.to_string(), value);
    }

    fn is_on(&self, switch: String) -> bool {
        self.data.get(&switch).is_some_and(|value| *value > 0.0)
    }

    /// What acts on AX1 and AX2.
    fn acts(&self, profile: &Profile, state: &ControlState) -> Vec<f64> {
        let mut on = self.tables.clone();
        on.tables.retain(|t| match &t.place {
            Place::Lec { axis, encoder } => {
                axis != "AX4" && self.is_on(format!("MA_ENC_COMP_ENABLE[{encoder},{axis}]"))
            }
            Place::Cec(number) => {
                t.output_axis != "AX5"
                    && self.is_on(format!("SN_CEC_TABLE_ENABLE[{number}]"))
                    && self.is_on(format!("MA_CEC_ENABLE[{}]", t.output_axis))
            }
        });
        let mut state = state.clone();
        for axis in &mut state.axes {
            let key = format!("MA_BACKLASH[0,{}]", axis.name);
            axis.backlash_um = self.data.get(&key).map_or(0.0, |mm| mm * 1000.0);
        }
        super::acts(profile, &Tables::Siemens(on), &state, ["AX1", "AX2"])
    }

    /// The control as an archive writes it, with what has nothing to do with it.
    fn archive(&self, more: &str) -> String {
        let mut text = "%_N_COMPLETE_TEA_INI\n;$PATH=/_N_NC_ACT_DIR\nCHANDATA(1)\nN10000 $MN_AXCONF_MACHAX_NAME_TAB[0]=\"X1\"\nN20050 $MC_AXCONF_GEOAX_ASSIGN_TAB[0]=1\nN32000 $MA_MAX_AX_VELO[AX1]=10000\n$MN_HEX='H1F'\n".to_string();
        text.extend(self.data.iter().map(|(key, value)| format!("N1 ${key}={value}\n")));
        text += &format!("{more}M17\n%_N_NC_EEC_INI\nCHANDATA(1)\n");
        for SiemensTable { place, grid, values, .. } in self.tables.lec() {
            let (axis, encoder) = place.lec().unwrap();
            for (index, value) in values.iter().enumerate() {
                text += &format!("$AA_ENC_COMP[{encoder},{index},{axis}]={}\n", value.unwrap());
            }
            for (name, mm) in [("STEP", grid.step), ("MIN", grid.min), ("MAX", grid.max)] {
                text += &format!("$AA_ENC_COMP_{name}[{encoder},{axis}]={mm}\n");
            }
        }
        for t in self.tables.cec() {
            let (n, from, to, grid) = (t.place.index(), &t.input_axis, &t.output_axis, t.grid);
            for (index, value) in t.values.iter().enumerate() {
                text += &format!("$AN_CEC[{n},{index}]={}\n", value.unwrap());
            }
            let direction: f64 = t.direction_text().parse().unwrap();
            text += &format!("$AN_CEC_INPUT_AXIS[{n}]=({from})\n$AN_CEC_OUTPUT_AXIS[{n}]=({to})\n");
            let numbers = [("STEP", grid.step), ("MIN", grid.min), ("MAX", grid.max)];
            for (name, number) in numbers.into_iter().chain([("DIRECTION", direction)]) {
                text += &format!("$AN_CEC_{name}[{n}]={number}\n");
            }
        }
        text + "M17\n"
    }
}

/// A control with the tables of `old`, others that are switched off or of other axes, and its machine data.
fn before(old: &Kit, policy: &str) -> Control {
    let profile = builtin::profile("siemens-840d-sl").unwrap();
    let mut control = Control::default();
    let (mean, ..) = old_and_new("siemens-840d-sl", SIEMENS_AXES, ("mean", "mean"));
    for kit in [&mean, old] {
        control.load(shown(read(&profile, &files_of(kit, Role::Table))));
    }
    // The numbers of the CEC tables that other policies use: there, and switched off.
    for number in 0..8 {
        let is_used = control.tables.at(&Place::Cec(number)).is_some();
        if !is_used {
            let (spare, input_axis) = (first_cec(&control), "AX1".to_string());
            let place = Place::Cec(number);
            control.tables.tables.push(SiemensTable { place, input_axis, ..spare });
        }
        control.set(&format!("SN_CEC_TABLE_ENABLE[{number}]"), f64::from(u8::from(is_used)));
    }
    let (input_axis, output_axis) = ("AX4".to_string(), "AX5".to_string());
    let (foreign, place) = (first_cec(&control), Place::Cec(9));
    control.tables.tables.push(SiemensTable { place, input_axis, output_axis, ..foreign });
    let foreign = control.tables.tables[0].clone();
    let [input_axis, output_axis, axis] = [(); 3].map(|()| "AX4".to_string());
    let place = Place::Lec { axis, encoder: 0 };
    control.tables.tables.push(SiemensTable { place, input_axis, output_axis, ..foreign });
    control.tables.tables.sort_by_key(|t| t.place.clone());
    control.tables.tables[0].values[1] = Some(0.004_123_456_78); // more digits than a profile writes
    let lec_on = f64::from(u8::from(policy == "mean"));
    for axis in ["AX1", "AX2"] {
        control.set(&format!("MA_ENC_COMP_ENABLE[0,{axis}]"), lec_on);
        control.set(&format!("MA_CEC_ENABLE[{axis}]"), 1.0);
        control.set(&format!("MA_CEC_MAX_SUM[{axis}]"), 0.5);
        control.set(&format!("MA_BACKLASH[0,{axis}]"), 0.003);
    }
    for number in 0..10 {
        control.set(&format!("SN_CEC_TABLE_WEIGHT[{number}]"), 1.0);
    }
    for on in ["MA_ENC_COMP_ENABLE[0,AX4]", "MA_CEC_ENABLE[AX5]", "SN_CEC_TABLE_ENABLE[9]"] {
        control.set(on, 1.0);
    }
    control
}

fn first_cec(control: &Control) -> SiemensTable {
    control.tables.cec().next().unwrap().clone()
}

#[test]
fn the_way_back_on_siemens_brings_back_what_acted() {
    let profile = builtin::profile("siemens-840d-sl").unwrap();
    for way in WAYS.into_iter().filter(|way| *way != ("mean", "two-tables")) {
        println!("{way:?}");
        let (old, job, left) = old_and_new("siemens-840d-sl", SIEMENS_AXES, way);
        let before = before(&old, way.0);
        let found = taken(&job, &left, &before.archive(""));
        let new = shown(kit::generate(&found));
        let page = checklist(&new);
        assert!(!page.contains("not in the rollback files"), "{page}");
        let mut control = before.clone();
        let of = |role: Role| shown(read(&profile, &files_of(&new, role)));
        for role in [Role::Disable, Role::Table, Role::Enable] {
            control.load(of(role));
        }
        // What a person does whom the preconditions of the kit tell so.
        for precondition in &new.compiled.preconditions {
            let datum = precondition.what.split_once(" $").map_or("", |(_, datum)| datum);
            let key = datum.split(" and ").next().unwrap();
            let value = precondition.value.split(' ').next().unwrap().parse();
            let is_now = control.data.contains_key(key) && !precondition.value.contains("while");
            if let Some(value) = value.ok().filter(|_| is_now) {
                control.set(key, value);
            }
        }
        let state = &found.active.as_ref().unwrap().state;
        let acts = |control: &Control| control.acts(&profile, state);
        assert_ne!(acts(&control), acts(&before));
        control.load(of(Role::Disable));
        control.load(shown(read_apart(&profile, &files_of(&new, Role::Rollback), Role::Rollback)));
        assert_eq!(control, before);
        assert_eq!(acts(&control), acts(&before));
    }
}

#[test]
fn what_no_file_holds_is_left_to_a_person_and_named() {
    let way = ("mean", "curve-and-parameter");
    let (old, job, left) = old_and_new("siemens-840d-sl", SIEMENS_AXES, way);
    let mut before = before(&old, "mean");
    let acted = format!("{ACTIVE}\nactive_backlash_um = {{ x = 3.0, y = 3.0 }}");
    let job = job.replace(ACTIVE, &acted);
    let page = |control: &Control, more: &str| {
        let new = shown(kit::generate(&taken(&job, &left, &control.archive(more))));
        checklist(&new).to_string() + &words(&new.manifest.notes).join("\n")
    };
    for gone in ["MA_ENC_COMP_ENABLE[0,AX1]", "SN_CEC_TABLE_ENABLE[1]", "MA_BACKLASH[0,AX2]"] {
        before.data.remove(gone);
    }
    let words = page(&before, "");
    assert_eq!(words.matches("not in the rollback files").count(), 6, "{words}");
    for lacking in [
        "MD32700 $MA_ENC_COMP_ENABLE[0,AX1]: not in the rollback files. The files of this kit switch it",
        "SD41300 $SN_CEC_TABLE_ENABLE[1]: not in the rollback files; switch on what was on",
        "MD32450 $MA_BACKLASH[0,AX2]: not in the rollback files. A precondition may make you change it",
    ] {
        holds(&words, &[lacking]);
    }
    assert!(!words.contains("[0,AX2]: not in the rollback files. The files"), "{words}");
    // A table that the control only reserves: off, it may keep the new values; on, it may not.
    before.tables.tables.retain(|t| t.place.lec().is_none_or(|(axis, _)| axis != "AX2"));
    let reserved = "$AA_ENC_COMP_STEP[0,AX2]=0\n$AA_ENC_COMP[0,0,AX2]=0\n";
    let on = "missing: ENC_COMP[0,AX2] (read out without a grid, and not as switched off)";
    holds(&page(&before, reserved), &[on]);
    before.set("MA_ENC_COMP_ENABLE[0,AX2]", 0.0);
    let off = "ENC_COMP[0,AX2] was reserved without a grid: the values of this kit stay in it";
    holds(&page(&before, reserved), &[off]);
}

#[test]
fn a_switch_that_an_archive_holds_with_two_values_is_left_to_a_person() {
    let (old, job, left) = old_and_new("siemens-840d-sl", SIEMENS_AXES, ("mean", "mean"));
    let before = before(&old, "mean");
    let set_back = |more: &str| {
        let new = shown(kit::generate(&taken(&job, &left, &before.archive(more))));
        let files = files_of(&new, Role::Rollback);
        let texts = files.iter().map(|file| String::from_utf8_lossy(&file.bytes));
        texts.filter(|text| text.contains("$MA_ENC_COMP_ENABLE[0,AX1]=")).count()
    };
    assert_eq!([set_back(""), set_back("$MA_ENC_COMP_ENABLE[0,AX1]=0\n")], [1, 0]);
}

#[test]
fn a_way_back_that_moves_an_axis_at_its_reference_says_so() {
    let (old, job, left) = old_and_new("siemens-840d-sl", SIEMENS_AXES, ("mean", "mean"));
    let mut before = before(&old, "mean");
    for value in before.tables.tables[0].values.iter_mut().flatten() {
        *value += 0.005;
    }
    let job = job.replace(ACTIVE, &format!("{ACTIVE}\nactive_reference = \"rezero\""));
    let new = shown(kit::generate(&taken(&job, &left, &before.archive(""))));
    let moves = "X (AX1) moves by 5.000 µm towards −X when the old tables act again";
    holds(checklist(&new), &[&format!("at the reference point {moves}")]);
    for file in files_of(&new, Role::Rollback) {
        let text = String::from_utf8_lossy(&file.bytes);
        assert!(!text.contains("contained in these"), "{text}");
        let differs = ", but for\n;   ENC_COMP[0,AX1]: 0.005000 mm\n";
        assert!(text.contains(differs) || !text.contains("$AA_ENC_COMP"), "{text}");
    }
}
