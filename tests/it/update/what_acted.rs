//! What acted is found in files that were read out of a control.

use super::*;

#[test]
fn what_acted_is_found_in_a_siemens_archive() {
    let job = small(
        "siemens-840d-sl",
        &format!("{ACTIVE}\nactive_terms_not_measured = \"keep\""),
        "",
        SIEMENS_AXES,
    );
    let table = |number: u32, base: &str, output: &str, um: f64| {
        format!(
            "$AN_CEC[{number},0]=0\n$AN_CEC[{number},1]={:.6}\n$AN_CEC_INPUT_AXIS[{number}]=({base})\n$AN_CEC_OUTPUT_AXIS[{number}]=({output})\n$AN_CEC_STEP[{number}]=100\n$AN_CEC_MIN[{number}]=0\n$AN_CEC_MAX[{number}]=100\n",
            um / 1000.0
        )
    };
    let lec = "$AA_ENC_COMP[0,0,AX1]=0\n$AA_ENC_COMP[0,1,AX1]=0.010\n$AA_ENC_COMP_STEP[0,AX1]=100\n$AA_ENC_COMP_MIN[0,AX1]=0\n$AA_ENC_COMP_MAX[0,AX1]=100\n";
    let archive = |first: &str, switches: &str| {
        format!(
            "%_N_NC_TEA_INI\nN1 $MN_OTHER[0]=\"x\"\n{switches}M17\n%_N_NC_CEC_INI\nCHANDATA(1)\n{first}{}$AN_CEC_STEP[7]=0\n$AN_CEC_INPUT_AXIS[7]=()\n{lec}M17\n",
            table(3, "AX1", "AX2", 5.0)
        )
    };
    let on = read_out(&job, EXX_ONLY, &archive("", "")).unwrap_or_else(|p| panic!("{p}"));
    let at_end = |found: &Inputs, name| {
        let term =
            found.model.terms[nonius::quantity::axis::ErrorTerm::from_name(name).unwrap()].clone();
        term.map(|t| {
            t.measured
                .curve(Direction::Plus)
                .unwrap()
                .at(nonius::quantity::units::Millimetres::new(100.0))
                .um()
        })
    };
    assert!((at_end(&on, "EXX").unwrap() - (10.0 - 1.0)).abs() < 1e-9);
    assert!((at_end(&on, "EYX").unwrap() - 5.0).abs() < 1e-9);
    assert!(on.active.as_ref().unwrap().assumptions.iter().any(|a| a.fact.contains("SD41300")));
    let off = read_out(&job, EXX_ONLY, &archive("", "N41300 $SN_CEC_TABLE_ENABLE[3]=0\n")).unwrap();
    assert_eq!(at_end(&off, "EYX"), None, "a table that was off did nothing");
    let lec_off = read_out(&job, EXX_ONLY, &archive("", "$MA_ENC_COMP_ENABLE[0,AX1]=0\n")).unwrap();
    assert!((at_end(&lec_off, "EXX").unwrap() + 1.0).abs() < 1e-9);
    // A table of an axis that the job does not have lies where the new one would go.
    let other = read_out(&job, EXX_ONLY, &archive(&table(0, "AX4", "AX5", 9.0), "")).unwrap();
    let words = kit::generate(&other).unwrap_err().render();
    assert!(words.contains("CEC table 0 is in use in the read-out"), "{words}");
    let inch =
        read_out(&job, EXX_ONLY, &archive("", "$MN_SCALING_SYSTEM_IS_METRIC=0\n")).unwrap_err();
    assert!(inch.contains("counts in inch"), "{inch}");
}

#[test]
fn a_backlash_parameter_that_is_replaced_has_to_be_known() {
    let both = "axis,direction,position_mm,ex_um\nx,+,0,0\nx,+,100,2\nx,-,0,1\nx,-,100,3\n";
    let lec = |more: &str| {
        format!(
            "{more}$AA_ENC_COMP[0,0,AX1]=0\n$AA_ENC_COMP[0,1,AX1]=0.010\n$AA_ENC_COMP_STEP[0,AX1]=100\n$AA_ENC_COMP_MIN[0,AX1]=0\n$AA_ENC_COMP_MAX[0,AX1]=100\nM17\n"
        )
    };
    let job = |policy: &str, more: &str| {
        small(
            "siemens-840d-sl",
            &format!("{ACTIVE}\n{more}"),
            &format!("backlash = \"{policy}\""),
            SIEMENS_AXES,
        )
    };
    let unknown = read_out(&job("curve-and-parameter", ""), both, &lec("")).unwrap_err();
    assert!(unknown.contains("replace the backlash parameter of X"), "{unknown}");
    assert!(read_out(&job("mean", ""), both, &lec("")).is_ok(), "mean leaves the parameter alone");
    let parameter = |found: Inputs| {
        kit::generate(&found).unwrap().plan.backlash_um[nonius::quantity::axis::Axis::X].unwrap()
    };
    // 7 µm acted and 1 µm was left: the new parameter is 8 µm.
    let file =
        read_out(&job("curve-and-parameter", ""), both, &lec("N32450 $MA_BACKLASH[0,AX1]=0.007\n"))
            .unwrap();
    assert!((parameter(file) - 8.0).abs() < 1e-9);
    let stated =
        read_out(&job("curve-and-parameter", "active_backlash_um = { x = 7.0 }"), both, &lec(""))
            .unwrap();
    assert!((parameter(stated) - 8.0).abs() < 1e-9);
    let two = read_out(
        &job("curve-and-parameter", "active_backlash_um = { x = 6.0 }"),
        both,
        &lec("$MA_BACKLASH[0,AX1]=0.007\n"),
    )
    .unwrap_err();
    assert!(two.contains("a backlash parameter of 7 µm for X, the job states 6 µm"), "{two}");
}

#[test]
fn what_acted_is_found_in_a_fanuc_parameter_file() {
    let job = small(
        "fanuc-30i",
        &format!("{ACTIVE}\nactive_terms_not_measured = \"keep\""),
        "",
        FANUC_AXES,
    );
    let (_, old) =
        generate(&small("fanuc-30i", "active_while_measuring = \"none\"", "", FANUC_AXES), FULL);
    let mut file = String::from(
        "%\nN00010Q1L1P00000001\nN03701Q1S1P00000010\nN01240Q1A1P0.000A2P0.000A4P12.5\nN01851Q1A1P3A2P0A4P9\nN01852Q1A1P3A2P0A4P9\nN03620Q1A4P500\nN03621Q1A4P500\nN03622Q1A4P510\nN03623Q1A4P1\nN03624Q1A4P10.0\nN10900Q1P0\n",
    );
    let of_the_control = |f: &&nonius::write::emit::RenderedFile| {
        use nonius::control::controller::Role;
        matches!(f.role, Role::Table | Role::Parameters)
    };
    for kit_file in old.files.iter().filter(of_the_control) {
        let text = String::from_utf8_lossy(&kit_file.bytes).replace(['%', '\r'], "");
        file.push_str(text.trim());
        file.push('\n');
    }
    file.push_str("%\n");
    let found = read_out(&job, EXX_ONLY, &file).unwrap_or_else(|p| panic!("{p}"));
    let active = found.active.as_ref().unwrap();
    assert_eq!(active.backlash_um[nonius::quantity::axis::Axis::X], Some(3.0));
    assert_eq!(active.others.points.len(), 1, "{:?}", active.findings);
    let new = kit::generate(&found).unwrap_or_else(|p| panic!("{}", p.render()));
    let is = control(&found.profile, &new);
    let at = |x| um_at(&response(is.as_ref(), "1", "1", Direction::Plus), x);
    // 4 + 1 and 8 − 1 µm of deviation.
    assert_eq!((at(50.0), at(100.0)), (-5.0, -7.0));
    let shifted = file.replace("N01240Q1A1P0.000", "N01240Q1A1P1.000");
    let refused = read_out(&job, EXX_ONLY, &shifted).unwrap_err();
    assert!(refused.contains("1240 of axis 1 is 1 mm"), "{refused}");
    let taken = file
        .replace("P500\nN03622Q1A4P510", "P0\nN03622Q1A4P510")
        .replace("N03620Q1A4P500", "N03620Q1A4P1");
    let words = read_out(&job, EXX_ONLY, &taken)
        .map(|found| kit::generate(&found).unwrap_err().render())
        .unwrap_or_else(|p| p);
    assert!(words.contains("points 0 to 510"), "{words}");
}

/// Tables that lie in part programs beside active data were loaded or not: nobody knows.
#[test]
fn tables_in_part_programs_alone_are_no_old_tables() {
    let job = small("siemens-840d-sl", ACTIVE, "", SIEMENS_AXES);
    let lec = "$AA_ENC_COMP[0,0,AX1]=0\n$AA_ENC_COMP[0,1,AX1]=0.010\n$AA_ENC_COMP_STEP[0,AX1]=100\n$AA_ENC_COMP_MIN[0,AX1]=0\n$AA_ENC_COMP_MAX[0,AX1]=100\n";
    let program = format!("%_N_EEC_MPF\n{lec}M30\n");
    let data = "%_N_TEA_INI\n$MA_BACKLASH[0,AX1]=0.001\nM17\n";
    let refused = read_out(&job, EXX_ONLY, &format!("{data}{program}")).unwrap_err();
    assert!(refused.contains("holds tables in part programs only (EEC_MPF)"), "{refused}");
    let active = format!("%_N_AX_EEC_INI\n{lec}M17\n");
    let found = read_out(&job, EXX_ONLY, &format!("{active}{program}")).unwrap();
    let notes = notes_of(found.active.as_ref().unwrap());
    assert!(notes.contains("part programs were ignored (EEC_MPF)"), "{notes}");
    let alone = read_out(&job, EXX_ONLY, &program).unwrap();
    let notes = notes_of(alone.active.as_ref().unwrap());
    assert!(notes.contains("count as run and active"), "{notes}");
    let twice = active.replace("M17", "$AA_ENC_COMP[0,1,AX1]=0.012\nM17");
    let refused = read_out(&job, EXX_ONLY, &twice).unwrap_err();
    assert!(refused.contains("$AA_ENC_COMP[0,1,AX1] has several values"), "{refused}");
}
