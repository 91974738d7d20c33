//! What no job asks for, without manifest, and a whole parameter file (what readers understand: src/read).

use super::*;

/// What the program prints of a machine with the tables in `kit`, without how they are called.
fn figures_of(kit: &Kit) -> String {
    let commands = ["assess job.toml", "simulate job.toml --errors --force -o simulated.csv"];
    let pages = commands.map(|command| kit.0.yes(&format!("{command} --tables kit -v")));
    let pages = pages.concat();
    pages.lines().filter(|line| !line.starts_with("note: ")).collect::<Vec<_>>().join("\n")
}

/// A control itself calls its whole parameter file `CNC-PARA.TXT`, with thousands of others in it.
#[test]
fn a_whole_parameter_file_is_judged_by_what_concerns_the_tables() {
    let visit = Visit::of("start/errors");
    visit.edit("job.toml", "siemens-840d-sl", "fanuc-30i");
    visit.edit("job.toml", "# detection_unit_um", "detection_unit_um");
    let kit = Kit::made(visit);
    let of_the_kit = figures_of(&kit);
    for file in ["manifest.json", "SIGN-PITCH.TXT", "SIGN-STRAIGHT.TXT", "checklist.md"] {
        kit.remove(file);
    }
    let others = |count: usize| -> String {
        (100..100 + count).map(|number| format!("N{number:05}Q1P0\n")).collect()
    };
    kit.no(PARAMETERS, behind_first_percent(&others(50)))
        .says("and 44 more: the job does not write them");
    let blocks = format!("{}N01240Q1A1P0.0A2P0.0A3P0.0A4P5.0\n", others(200));
    let whole = behind_first_percent(&blocks)(&kit.0.read("kit/CNC-PARA.TXT"));
    kit.0.put("kit/CNC-PARA.TXT", whole);
    kit.agrees()
        .says("`CNC-PARA.TXT` holds far more than a kit: taken as read out of the control")
        .says("`CNC-PARA.TXT`: 200 other parameters were ignored");
    assert_eq!(figures_of(&kit), of_the_kit, "the same tables, the same figures");
    kit.no(PARAMETERS, swap("N03620Q1A1P0A", "N03620Q1A1P1A"))
        .says("EXX (1 while 1 moves): shifted reference");
}

#[test]
fn what_the_job_does_not_own_on_siemens() {
    let kit = Kit::without_manifest("siemens-840d-sl");
    kit.agrees();
    for (file, sets) in [(ON, "MA_ENC_COMP_ENABLE[0,AX1]"), (OFF, "MA_CEC_ENABLE[AX1]")] {
        let says = format!("note: `{file}` sets ${sets} and no NEWCONF follows");
        kit.yes(file, |text| format!("NEWCONF\n{}", text.replace("NEWCONF\n", ""))).says(&says);
    }
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
    let table = cec(40, ["AX1", "AX2"], 50, [0.0; 2]);
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
    for (file, blocks, what) in [
        (POINTS, "N11200Q0P5\nN11201Q0P5", "points 1200 to 1201: the job does not write them"),
        (PARAMETERS, "N01320Q1A1P100", "parameter 1320 of axis 1 = 100: the job does not write it"),
        (PARAMETERS, "N01851Q1A4P20", "parameter 1851 of axis 4 = 20: the job does not write it"),
        (POINTS, "N11200Q0P0", "point 1200: the job does not write it"),
    ] {
        kit.no(file, behind_first_percent(&format!("{blocks}\n"))).says(what);
    }
}
