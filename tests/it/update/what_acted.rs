//! What acted is found in files that were read out of a control.

use super::*;

/// The deviation of a term at 100 mm once the old tables are taken off, µm.
fn at_end(found: &Inputs, name: &str) -> Option<f64> {
    let own = found.model.terms[term(name)].as_ref()?;
    Some(own.measured.curve(Direction::Plus).unwrap().at(Millimetres::new(100.0)).um())
}

#[test]
fn what_acted_is_found_in_a_siemens_archive() {
    let job = siemens(KEEP);
    let table = |number: u32, base: &str, output: &str, um: f64| {
        format!(
            "$AN_CEC[{number},0]=0\n$AN_CEC[{number},1]={:.6}\n$AN_CEC_INPUT_AXIS[{number}]=({base})\n$AN_CEC_OUTPUT_AXIS[{number}]=({output})\n$AN_CEC_STEP[{number}]=100\n$AN_CEC_MIN[{number}]=0\n$AN_CEC_MAX[{number}]=100\n",
            um / 1000.0
        )
    };
    let archive = |first: &str, switches: &str| {
        format!(
            "%_N_NC_TEA_INI\nN1 $MN_OTHER[0]=\"x\"\n{switches}M17\n%_N_NC_CEC_INI\nCHANDATA(1)\n{first}{}$AN_CEC_STEP[7]=0\n$AN_CEC_INPUT_AXIS[7]=()\n{}M17\n",
            table(3, "AX1", "AX2", 5.0),
            lec("0.010")
        )
    };
    let on = taken(&job, EXX_ONLY, &archive("", ""));
    is_near(at_end(&on, "EXX").unwrap(), 10.0 - 1.0);
    is_near(at_end(&on, "EYX").unwrap(), 5.0);
    assert!(on.active.unwrap().assumptions.iter().any(|a| a.fact.contains("SD41300")));
    let off = taken(&job, EXX_ONLY, &archive("", "N41300 $SN_CEC_TABLE_ENABLE[3]=0\n"));
    assert_eq!(at_end(&off, "EYX"), None, "a table that was off did nothing");
    let lec_off = taken(&job, EXX_ONLY, &archive("", "$MA_ENC_COMP_ENABLE[0,AX1]=0\n"));
    is_near(at_end(&lec_off, "EXX").unwrap(), -1.0);
    // A table of an axis that the job does not have lies where the new one would go.
    let other = taken(&job, EXX_ONLY, &archive(&table(0, "AX4", "AX5", 9.0), ""));
    let said = kit::generate(&other).unwrap_err().render();
    said_in(&said, "CEC table 0 is in use in the read-out");
    let inch = archive("", "$MN_SCALING_SYSTEM_IS_METRIC=0\n");
    refused(&job, EXX_ONLY, &inch, "counts in inch");
}

#[test]
fn a_backlash_parameter_that_is_replaced_has_to_be_known() {
    let file = |more: &str| format!("{more}{}M17\n", lec("0.010"));
    let job = |policy: &str, more: &str| {
        let (active, policy) = (format!("{ACTIVE}\n{more}"), format!("backlash = \"{policy}\""));
        small("siemens-840d-sl", &active, &policy, SIEMENS_AXES)
    };
    let replaced = |more: &str| job("curve-and-parameter", more);
    let says = "replace the backlash parameter of X";
    refused(&replaced(""), EXX_BOTH_WAYS, &file(""), says);
    taken(&job("mean", ""), EXX_BOTH_WAYS, &file("")); // which leaves the parameter alone
    // 7 µm acted and 1 µm was left: the new parameter is 8 µm.
    let in_file = file("N32450 $MA_BACKLASH[0,AX1]=0.007\n");
    let stated = "active_backlash_um = { x = 7.0 }";
    for (job, file) in [(replaced(""), &in_file), (replaced(stated), &file(""))] {
        let found = taken(&job, EXX_BOTH_WAYS, file);
        is_near(shown(kit::generate(&found)).plan.backlash_um[Axis::X].unwrap(), 8.0);
    }
    let other = replaced(&stated.replace('7', "6"));
    let says = "a backlash parameter of 7 µm for X, the job states 6 µm";
    refused(&other, EXX_BOTH_WAYS, &in_file, says);
}

#[test]
fn what_acted_is_found_in_a_fanuc_parameter_file() {
    let job = fanuc(KEEP);
    let (_, old) = generate(&fanuc(NONE), FULL);
    let mut file = String::from(
        "%\nN00010Q1L1P00000001\nN03701Q1S1P00000010\nN01240Q1A1P0.000A2P0.000A4P12.5\nN01851Q1A1P3A2P0A4P9\nN01852Q1A1P3A2P0A4P9\nN03620Q1A4P500\nN03621Q1A4P500\nN03622Q1A4P510\nN03623Q1A4P1\nN03624Q1A4P10.0\nN10900Q1P0\n",
    );
    let is_loaded = |role: Role| matches!(role, Role::Table | Role::Parameters);
    for kit_file in old.files.iter().filter(|file| is_loaded(file.role)) {
        let text = String::from_utf8_lossy(&kit_file.bytes).replace(['%', '\r'], "");
        file += &format!("{}\n", text.trim());
    }
    file += "%\n";
    let found = taken(&job, EXX_ONLY, &file);
    let active = found.active.as_ref().unwrap();
    assert_eq!(active.backlash_um[Axis::X], Some(3.0));
    assert_eq!(active.others.points.len(), 1, "{:?}", active.findings);
    let is = control(&found.profile, &shown(kit::generate(&found)));
    let at = |x| um_at(&response(is.as_ref(), "1", "1", Direction::Plus), x);
    // 4 + 1 and 8 − 1 µm of deviation.
    assert_eq!((at(50.0), at(100.0)), (-5.0, -7.0));
    let shifted = file.replace("N01240Q1A1P0.000", "N01240Q1A1P1.000");
    refused(&job, EXX_ONLY, &shifted, "1240 of axis 1 is 1 mm");
    let in_use = file
        .replace("P500\nN03622Q1A4P510", "P0\nN03622Q1A4P510")
        .replace("N03620Q1A4P500", "N03620Q1A4P1");
    let said = read_out(&job, EXX_ONLY, &in_use)
        .map_or_else(|said| said, |found| kit::generate(&found).unwrap_err().render());
    said_in(&said, "points 0 to 510");
}

/// Tables that lie in part programs beside active data were loaded or not: nobody knows.
#[test]
fn tables_in_part_programs_alone_are_no_old_tables() {
    let job = siemens(ACTIVE);
    let program = format!("%_N_EEC_MPF\n{}M30\n", lec("0.010"));
    let data = "%_N_TEA_INI\n$MA_BACKLASH[0,AX1]=0.001\nM17\n";
    let says = "holds tables in part programs only (EEC_MPF)";
    refused(&job, EXX_ONLY, &format!("{data}{program}"), says);
    let active = format!("%_N_AX_EEC_INI\n{}M17\n", lec("0.010"));
    let notes = |file: &str| notes_of(&taken(&job, EXX_ONLY, file).active.unwrap());
    said_in(&notes(&format!("{active}{program}")), "part programs were ignored (EEC_MPF)");
    said_in(&notes(&program), "count as run and active");
    let twice = active.replace("M17", "$AA_ENC_COMP[0,1,AX1]=0.012\nM17");
    refused(&job, EXX_ONLY, &twice, "$AA_ENC_COMP[0,1,AX1] has several values");
}
