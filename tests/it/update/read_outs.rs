//! What a read-out has to hold to be built on, and what is assumed where it is silent.

use super::*;

/// Old tables that the control cut, or took in another unit, did not act as they stand.
#[test]
fn old_tables_that_the_control_cut_or_converted_are_refused() {
    let job = siemens(ACTIVE);
    let cec = "$AN_CEC[0,0]=0\n$AN_CEC[0,1]=0.010\n$AN_CEC_INPUT_AXIS[0]=(AX1)\n$AN_CEC_OUTPUT_AXIS[0]=(AX2)\n$AN_CEC_STEP[0]=100\n$AN_CEC_MIN[0]=0\n$AN_CEC_MAX[0]=100\n$AN_CEC_DIRECTION[0]=0\n";
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
    refused(&second, FULL, two_lines, "name the commissioning archive");
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
    let notes = words(&taken(&job, FULL, &zeros).active_notes);
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
    said_in(&open.consequence, "by up to 2.0 µm");
    let Tables::Siemens(tables) = &active.tables else { panic!("Siemens") };
    assert_eq!((tables.cec[0].values.len(), tables.cec[0].grid.max), (2, 60.0));
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
