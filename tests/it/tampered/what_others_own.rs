//! Contents that no job asks for: of other axes, beside the tables of a kit.

use super::*;

#[test]
fn what_the_job_does_not_own_on_siemens() {
    let kit = Kit::without_manifest("siemens-840d-sl");
    kit.agrees();
    kit.no(ON, swap("NEWCONF", "$MA_BACKLASH[0,AX1]=0.5\nNEWCONF")).says(
        "`NONIUS_ENABLE.MPF` sets $MA_BACKLASH[0,AX1] = 0.5: the job does not write it there",
    );
    kit.no(ON, swap("$MA_ENC_COMP_ENABLE[0,AX1]=1\n", "")).says(
        "the enable file does not switch on ENC_COMP[0,AX1] (MD32700): not written, expected 1",
    );
    kit.no(ON, |_| "M30\n".to_string())
        .says("the enable file does not switch on ENC_COMP[0,AX1] (MD32700), ENC_COMP[0,AX2]");
    kit.no(OFF, swap("=0", "=1"))
        .says("the disable file does not switch off ENC_COMP[0,AX1] (MD32700), ENC_COMP[0,AX2]");
    let memory = "the memory file does not reserve enough for ENC_COMP[0,AX1] (MD38000)";
    kit.no(MEMORY, swap("POINTS[0,AX1]=31", "POINTS[0,AX1]=3"))
        .says(&format!("{memory}: set to 3, expected at least 31"));
    kit.no(MEMORY, swap("N38000 $MA_MM_ENC_COMP_MAX_POINTS[0,AX1]=31\n", ""))
        .says(&format!("{memory}: not written, expected at least 31"));
    kit.no(EEC, swap("M30", "$MA_ENC_COMP_ENABLE[0,AX1]=1\nM30"))
        .says("`NONIUS_EEC.MPF` sets $MA_ENC_COMP_ENABLE[0,AX1] = 1: the job does not write it");
    let table = "$AN_CEC[40,0]=0\n$AN_CEC[40,1]=0\n$AN_CEC_INPUT_AXIS[40]=(AX1)\n\
        $AN_CEC_OUTPUT_AXIS[40]=(AX2)\n$AN_CEC_STEP[40]=50\n$AN_CEC_MIN[40]=0\n$AN_CEC_MAX[40]=50\n";
    kit.no(CEC, swap("M30", &format!("{table}M30")))
        .says("CEC table 40 (AX2 while AX1 moves): the job does not write it");
    // Table 0 under another number.
    let renumbered = |line: &str| match line.starts_with("$AN_CEC_") {
        true => line.replace("[0]=", "[50]="),
        false => line.replace("$AN_CEC[0,", "$AN_CEC[50,"),
    };
    kit.no(CEC, lines(|line| Some(renumbered(line))))
        .says("CEC table 0 (AX2 while AX1 moves): missing, the job writes it");
}

#[test]
fn what_the_job_does_not_own_on_fanuc() {
    let kit = Kit::without_manifest("fanuc-30i");
    kit.agrees();
    for (file, blocks, says) in [
        (POINTS, "N11200Q0P5\nN11201Q0P5\n", "points 1200 to 1201: the job does not write them"),
        (
            PARAMETERS,
            "N01320Q1A1P100\n",
            "parameter 1320 of axis 1 = 100: the job does not write it",
        ),
        (PARAMETERS, "N01851Q1A4P20\n", "parameter 1851 of axis 4 = 20: the job does not write it"),
        (POINTS, "N11200Q0P0\n", "point 1200: the job does not write it"),
    ] {
        kit.no(file, behind_first_percent(blocks)).says(says);
    }
}
