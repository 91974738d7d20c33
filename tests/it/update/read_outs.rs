//! What a read-out has to hold to be built on, and what is assumed where it is silent.

use super::*;

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
        (&job, two_lines.to_string(), "$MA_ENC_COMP_ENABLE[1,AX1] is 1"),
        (&second, two_lines.to_string(), "name the commissioning archive"),
        (&job, with("$MA_ENC_COMP_ENABLE[0,AX2]=1\n"), "$MA_ENC_COMP_ENABLE[0,AX2] is 1"),
        (&job, with("$SN_CEC_TABLE_ENABLE[3]=1\n"), "of CEC table 3 is 1"),
        (&job, with("$SN_CEC_TABLE_ENABLE[3]=1\n$MA_CEC_ENABLE[AX2]=1\n"), "of CEC table 3 is 1"),
        (&job, with("$MA_CEC_ENABLE[AX2]=1\n"), "MD32710 $MA_CEC_ENABLE of AX2 is 1"),
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
        found.active_notes.iter().any(|note| note.to_string() == says),
        "{:?}",
        found.active_notes
    );
    let others = zeros.replace("AX1", "AX7");
    assert!(read_out(&job, FULL, &others).unwrap_err().contains("correct nothing"));
}

/// Where nothing tells of a kind of tables, that there was none is an assumption.
#[test]
fn tables_that_no_file_speaks_of_are_assumed_to_be_absent() {
    let job = small("siemens-840d-sl", ACTIVE, "", SIEMENS_AXES);
    let lec = "$AA_ENC_COMP[0,0,AX1]=0\n$AA_ENC_COMP[0,1,AX1]=0.004\n$AA_ENC_COMP_STEP[0,AX1]=100\n$AA_ENC_COMP_MIN[0,AX1]=0\n$AA_ENC_COMP_MAX[0,AX1]=100\nM17\n";
    let found = read_out(&job, FULL, lec).unwrap();
    let facts: Vec<&str> =
        found.active.as_ref().unwrap().assumptions.iter().map(|a| a.fact.as_str()).collect();
    assert!(facts.contains(&"ENC_COMP of AX2") && facts.contains(&"CEC"), "{facts:?}");
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
        let open = assumptions.into_iter().find(|a| a.fact.contains("between two points"));
        (found, open)
    };
    let (found, open) = assumed(&table("0"));
    let open = open.unwrap();
    assert_eq!(open.fact, "$AN_CEC[0] behind 60 mm, where MAX lies between two points");
    assert!(open.consequence.contains("by up to 2.0 µm"), "{}", open.consequence);
    let nonius::control::table::Tables::Siemens(tables) = &found.active.as_ref().unwrap().tables
    else {
        panic!("Siemens")
    };
    assert_eq!((tables.cec[0].values.len(), tables.cec[0].grid.max), (2, 60.0));
    let (_, same) = assumed(&table("0.004"));
    assert_eq!(same, None, "both readings are the same");
    let inch = read_out(&job, FULL, &table("0").replace("METRIC", "INCH")).unwrap_err();
    assert!(inch.contains("is written in inch (`INCH`), the job counts in mm"), "{inch}");
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
        (bit, kit.compiled.state.axes.iter().all(|axis| axis.interpolated))
    };
    assert_eq!(asked(&job, "00000010"), ("1".to_string(), true));
    assert_eq!(asked(&job, "00000000"), ("0".to_string(), false));
    let stated = FANUC_AXES.replace("spacing_mm = 50", "spacing_mm = 50\ninterpolated = false");
    let stated = small("fanuc-30i", ACTIVE, "", &stated);
    assert_eq!(asked(&stated, "00000010"), ("0".to_string(), false));
}
