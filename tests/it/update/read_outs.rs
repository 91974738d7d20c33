//! What acted is found in files that were read out of a control: what they have to hold, and what is assumed.

use super::*;

/// The deviation of a term at 100 mm once the old tables are taken off, µm.
fn at_end(found: &Inputs, name: &str) -> Option<f64> {
    let own = found.model.terms[term(name)].as_ref()?;
    Some(own.measured.curve(Direction::Plus).unwrap().at(Millimetres::new(100.0)).um())
}

/// A CEC table with 0 at 0 mm and a value at 100 mm.
fn cec(number: u32, base: &str, output: &str, mm: f64) -> String {
    format!(
        "$AN_CEC[{number},0]=0\n$AN_CEC[{number},1]={mm:.6}\n$AN_CEC_INPUT_AXIS[{number}]=({base})\n$AN_CEC_OUTPUT_AXIS[{number}]=({output})\n$AN_CEC_STEP[{number}]=100\n$AN_CEC_MIN[{number}]=0\n$AN_CEC_MAX[{number}]=100\n"
    )
}

#[test]
fn what_acted_is_found_in_a_siemens_archive() {
    let job = siemens(KEEP);
    let archive = |first: &str, switches: &str| {
        format!(
            "%_N_NC_TEA_INI\nN1 $MN_OTHER[0]=\"x\"\n{switches}M17\n%_N_NC_CEC_INI\nCHANDATA(1)\n{first}{}$AN_CEC_STEP[7]=0\n$AN_CEC_INPUT_AXIS[7]=()\n{}M17\n",
            cec(3, "AX1", "AX2", 0.005),
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
    let other = taken(&job, EXX_ONLY, &archive(&cec(0, "AX4", "AX5", 0.009), ""));
    let said = kit::generate(&other).unwrap_err().render();
    holds(&said, &["CEC table 0 is in use in the read-out"]);
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
    let (_, old) = generate(&fanuc(UNCORRECTED), FULL);
    let mut file = "%\nN00010Q1L1P00000001\nN03701Q1S1P00000010\nN01240Q1A1P0.000A2P0.000A4P12.5\nN01851Q1A1P3A2P0A4P9\nN01852Q1A1P3A2P0A4P9\nN03620Q1A4P500\nN03621Q1A4P500\nN03622Q1A4P510\nN03623Q1A4P1\nN03624Q1A4P10.0\nN10900Q1P0\n".to_string();
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
    holds(&said, &["points 0 to 510"]);
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
    holds(&notes(&format!("{active}{program}")), &["part programs were ignored (EEC_MPF)"]);
    holds(&notes(&program), &["count as run and active"]);
    let twice = active.replace("M17", "$AA_ENC_COMP[0,1,AX1]=0.012\nM17");
    refused(&job, EXX_ONLY, &twice, "$AA_ENC_COMP[0,1,AX1] has several values");
}

/// Old tables that the control cut, or took in another unit, did not act as they stand.
#[test]
fn old_tables_that_the_control_cut_or_converted_are_refused() {
    let job = siemens(ACTIVE);
    let cec = cec(0, "AX1", "AX2", 0.010) + "$AN_CEC_DIRECTION[0]=0\n";
    let cut = format!("{cec}$MA_CEC_MAX_SUM[AX2]=0.001\nM17\n");
    refused(&job, FULL, &cut, "MD32720 of AX2 is 0.001");
    let scaling = "$MN_CONVERT_SCALING_SYSTEM=1\n$MA_CEC_SCALING_SYSTEM_METRIC[AX2]=0\n";
    refused(&job, FULL, &format!("{cec}{scaling}M17\n"), "MD32711 of AX2 is 0");
    let kept = format!("{cec}$MA_CEC_MAX_SUM[AX2]=0.010\nM17\n");
    let said = read_out(&job, FULL, &kept).err().unwrap_or_default();
    assert!(!said.contains("MD32720"), "{said}");
}

/// The smallest real case: switches and backlash were read out, the tables that they switch were not.
#[test]
fn a_read_out_with_switches_and_without_tables_is_refused() {
    let job = siemens(ACTIVE);
    let two_lines = "N32450 $MA_BACKLASH[1,AX1]=0\nN32700 $MA_ENC_COMP_ENABLE[1,AX1]=1\nM17\n";
    let second = job.replace("id = \"AX1\"", "id = \"AX1\"\nmeasuring_system = 2");
    refused(&job, FULL, two_lines, "$MA_ENC_COMP_ENABLE[1,AX1] is 1");
    refused(&second, FULL, two_lines, "name all files together");
    let with = |more: &str| format!("{}{more}M17\n", lec("0.004"));
    for (more, says) in [
        ("$MA_ENC_COMP_ENABLE[0,AX2]=1\n", "$MA_ENC_COMP_ENABLE[0,AX2] is 1"),
        ("$SN_CEC_TABLE_ENABLE[3]=1\n", "of CEC table 3 is 1"),
        ("$SN_CEC_TABLE_ENABLE[3]=1\n$MA_CEC_ENABLE[AX2]=1\n", "of CEC table 3 is 1"),
        ("$MA_CEC_ENABLE[AX2]=1\n", "MD32710 $MA_CEC_ENABLE of AX2 is 1"),
    ] {
        refused(&job, FULL, &with(more), says);
    }
    for harmless in [
        "$SN_CEC_TABLE_ENABLE[3]=1\n$MA_CEC_ENABLE[AX1]=0\n$MA_CEC_ENABLE[AX2]=0\n",
        "$SN_CEC_TABLE_ENABLE[3]=1\n$MN_MM_CEC_MAX_POINTS[3]=0\n",
        "$MA_CEC_ENABLE[AX2]=1\n$SN_CEC_TABLE_ENABLE[3]=0\n",
        "$MA_ENC_COMP_ENABLE[0,AX2]=1\n$MA_MM_ENC_COMP_MAX_POINTS[0,AX2]=0\n",
    ] {
        taken(&job, FULL, &with(harmless));
    }
}

/// Tables that were read out and hold zeros are known to have done nothing.
#[test]
fn tables_of_zeros_are_a_read_out_like_any_other() {
    let job = siemens(ACTIVE);
    let zeros = lec("0") + "M17\n";
    let notes = words(&taken(&job, FULL, &zeros).notes);
    let says = "the active tables of AX1 → AX1 hold zeros: old = 0";
    assert!(notes.iter().any(|note| note == says), "{notes:?}");
    refused(&job, FULL, &zeros.replace("AX1", "AX7"), "correct nothing");
}

/// Where nothing tells of a kind of tables, that there was none is an assumption.
#[test]
fn tables_that_no_file_speaks_of_are_assumed_to_be_absent() {
    let active = taken(&siemens(ACTIVE), FULL, &(lec("0.004") + "M17\n")).active.unwrap();
    let facts: Vec<&str> = active.assumptions.iter().map(|a| a.fact.as_str()).collect();
    assert!(facts.contains(&"ENC_COMP of AX2") && facts.contains(&"CEC"), "{facts:?}");
}

/// Real tables end between two points: what the control does there is not known.
#[test]
fn a_table_that_ends_between_two_points_is_taken_with_an_assumption() {
    let job = siemens(ACTIVE);
    let table = |next: &str| {
        format!(
            "METRIC\n$AN_CEC[0,0]=0\n$AN_CEC[0,1]=0.004\n$AN_CEC[0,2]={next}\n$AN_CEC[0,3]=9\n$AN_CEC_INPUT_NCU[0]=1\n$AN_CEC_INPUT_AXIS[0]=(AX1)\n$AN_CEC_OUTPUT_NCU[0]=1\n$AN_CEC_OUTPUT_AXIS[0]=(AX2)\n$AN_CEC_STEP[0]=60\n$AN_CEC_MIN[0]=0\n$AN_CEC_MAX[0]=90\n$AN_CEC_DIRECTION[0]=0\n$AN_CEC_MULT_BY_TABLE[0]=0\n$AN_CEC_IS_MODULO[0]=0\nM17\n"
        )
    };
    let assumed = |next: &str| {
        let active = taken(&job, FULL, &table(next)).active.unwrap();
        let mut all = active.assumptions.clone().into_iter();
        (active, all.find(|a| a.fact.contains("between two points")))
    };
    let (active, open) = assumed("0");
    let open = open.unwrap();
    assert_eq!(open.fact, "$AN_CEC[0] behind 60 mm, where MAX lies between two points");
    holds(&open.consequence, &["by up to 2.0 µm"]);
    let Tables::Siemens(tables) = &active.tables else { panic!("Siemens") };
    assert_eq!((tables.tables[0].values.len(), tables.tables[0].grid.max), (2, 60.0));
    let (_, same) = assumed("0.004");
    assert_eq!(same, None, "both readings are the same");
    let inch = table("0").replace("METRIC", "INCH");
    refused(&job, FULL, &inch, "is written in inch (`INCH`), the job counts in mm");
}

/// A control that plays lines between its points goes on doing so with the new ones.
#[test]
fn interpolation_is_taken_over_from_the_control() {
    let file = |bits: &str| {
        format!(
            "%\nN10000Q0P0\nN10001Q0P2\nN10002Q0P1\nN03605Q1A1P{bits}A2P{bits}\nN03620Q1A1P0\nN03621Q1A1P0\nN03622Q1A1P2\nN03623Q1A1P1\nN03624Q1A1P50.0\n%\n"
        )
    };
    let asked = |job: &str, bits: &str| {
        let compiled = shown(kit::generate(&taken(job, FULL, &file(bits)))).compiled;
        let bit = compiled.preconditions.iter().find(|p| p.what.starts_with("3605#1")).unwrap();
        (bit.value.clone(), compiled.state.axes.iter().all(|axis| axis.interpolated))
    };
    let job = fanuc(ACTIVE);
    assert_eq!(asked(&job, "00000010"), ("1".to_string(), true));
    assert_eq!(asked(&job, "00000000"), ("0".to_string(), false));
    let stated = job.replace("spacing_mm = 50", "spacing_mm = 50\ninterpolated = false");
    assert_eq!(asked(&stated, "00000010"), ("0".to_string(), false));
}
