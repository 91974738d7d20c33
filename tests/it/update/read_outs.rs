//! What acted is found in files that were read out, or assumed (what they have to hold: cases/refuses/active.txt).

use super::*;

/// The deviation of a term at 100 mm once the old tables are taken off, µm.
fn at_end(found: &Inputs, name: &str) -> Option<f64> {
    let own = found.model.terms[term(name)].as_ref()?;
    Some(own.measured.curve(Direction::Plus).unwrap().at(Millimetres::new(100.0)).um())
}

#[test]
fn what_acted_is_found_in_a_siemens_archive() {
    let job = siemens(KEEP);
    let archive = |switches: &str| {
        let cec = cec(3, ["AX1", "AX2"], 100, [0.0, 0.005])
            + "$AN_CEC_STEP[7]=0\n$AN_CEC_INPUT_AXIS[7]=()\n";
        let (begin, data) =
            ("%_N_NC_TEA_INI\nN1 $MN_OTHER[0]=\"x\"\n", "M17\n%_N_NC_CEC_INI\nCHANDATA(1)\n");
        format!("{begin}{switches}{data}{cec}{}M17\n", lec("0.010"))
    };
    let on = taken(&job, EXX_ONLY, &archive(""));
    is_near(at_end(&on, "EXX").unwrap(), 10.0 - 1.0);
    is_near(at_end(&on, "EYX").unwrap(), 5.0);
    assert!(on.active.unwrap().assumptions.iter().any(|a| a.fact.contains("SD41300")));
    let off = taken(&job, EXX_ONLY, &archive("N41300 $SN_CEC_TABLE_ENABLE[3]=0\n"));
    assert_eq!(at_end(&off, "EYX"), None, "a table that was off did nothing");
    let lec_off = taken(&job, EXX_ONLY, &archive("$MA_ENC_COMP_ENABLE[0,AX1]=0\n"));
    is_near(at_end(&lec_off, "EXX").unwrap(), -1.0);
}

/// 7 µm acted and 1 µm was left: the new parameter is 8 µm. With the mean it stays as it is, whatever it was.
#[test]
fn a_backlash_parameter_that_is_replaced_adds_to_what_was_left() {
    let stated = "active_backlash_um = { x = 7.0 }";
    for (policy, stated, in_file, um) in [
        ("curve-and-parameter", "", "N32450 $MA_BACKLASH[0,AX1]=0.007\n", Some(8.0)),
        ("curve-and-parameter", stated, "", Some(8.0)),
        ("mean", "", "", None),
    ] {
        let (active, policy) = (format!("{ACTIVE}\n{stated}"), format!("backlash = \"{policy}\""));
        let job = small("siemens-840d-sl", &active, &policy, SIEMENS_AXES);
        let found = taken(&job, EXX_BOTH_WAYS, &format!("{in_file}{}M17\n", lec("0.010")));
        assert_eq!(shown(kit::generate(&found)).plan.backlash_um[Axis::X], um, "{policy}");
    }
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
}

#[test]
fn tables_in_part_programs_tables_of_zeros_and_tables_that_no_file_holds_are_told() {
    let program = format!("%_N_EEC_MPF\n{}M30\n", lec("0.010"));
    let active = format!("%_N_AX_EEC_INI\n{}M17\n", lec("0.010"));
    for (file, words) in [
        (active + &program, "part programs were ignored (EEC_MPF)"),
        (program, "count as run and active"),
        (lec("0") + "M17\n", "\nthe active tables of AX1 → AX1 hold zeros: old = 0\n"),
        (lec("0.004") + "M17\n", "\nassumed: ENC_COMP of AX2\n"),
        (lec("0.004") + "M17\n", "\nassumed: CEC\n"),
    ] {
        let found = taken(&siemens(ACTIVE), FULL, &file);
        let (active, notes) = (found.active.unwrap(), crate::support::words(&found.notes));
        let facts = active.assumptions.iter().map(|a| format!("assumed: {}", a.fact));
        let all: Vec<String> = notes.into_iter().chain(facts).collect();
        holds(&format!("{}\n{}\n", notes_of(&active), all.join("\n")), &[words]);
    }
}

/// Switches say that a table acts that was not read out; these do not, and a limit of CEC that is not reached cuts nothing.
#[test]
fn a_read_out_with_harmless_switches_is_taken() {
    let job = siemens(ACTIVE);
    for harmless in [
        "$SN_CEC_TABLE_ENABLE[3]=1\n$MA_CEC_ENABLE[AX1]=0\n$MA_CEC_ENABLE[AX2]=0\n",
        "$SN_CEC_TABLE_ENABLE[3]=1\n$MN_MM_CEC_MAX_POINTS[3]=0\n",
        "$MA_CEC_ENABLE[AX2]=1\n$SN_CEC_TABLE_ENABLE[3]=0\n",
        "$MA_ENC_COMP_ENABLE[0,AX2]=1\n$MA_MM_ENC_COMP_MAX_POINTS[0,AX2]=0\n",
        &(cec(0, ["AX1", "AX2"], 100, [0.0, 0.010])
            + "$AN_CEC_DIRECTION[0]=0\n$MA_CEC_MAX_SUM[AX2]=0.010\n"),
    ] {
        taken(&job, FULL, &format!("{}{harmless}M17\n", lec("0.004")));
    }
}

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
}

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
