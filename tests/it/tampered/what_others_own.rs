//! Contents that no job asks for: of other axes, beside the tables of a kit.

use super::*;

/// A file, what becomes of its text, and what `verify` says.
type Foreign = (&'static str, fn(&str) -> String, &'static str);

/// Kits without manifest, as they are read out of a control: only the contents can tell.
#[test]
fn what_the_job_does_not_own() {
    const ON: &str = "NONIUS_ENABLE.MPF";
    const OFF: &str = "NONIUS_DISABLE.MPF";
    const MEMORY: &str = "NONIUS_MEMORY.TXT";
    let siemens: [Foreign; 9] = [
        (
            ON,
            |text| text.replace("NEWCONF", "$MA_BACKLASH[0,AX1]=0.5\nNEWCONF"),
            "`NONIUS_ENABLE.MPF` sets $MA_BACKLASH[0,AX1] = 0.5: the job does not write it there",
        ),
        (
            ON,
            |text| text.replace("$MA_ENC_COMP_ENABLE[0,AX1]=1\n", ""),
            "the enable file does not switch on ENC_COMP[0,AX1] (MD32700): not written, expected 1",
        ),
        (
            ON,
            |_| "M30\n".to_string(),
            "the enable file does not switch on ENC_COMP[0,AX1] (MD32700), ENC_COMP[0,AX2]",
        ),
        (
            OFF,
            |text| text.replace("=0", "=1"),
            "the disable file does not switch off ENC_COMP[0,AX1] (MD32700), ENC_COMP[0,AX2]",
        ),
        (
            MEMORY,
            |text| text.replace("POINTS[0,AX1]=31", "POINTS[0,AX1]=3"),
            "the memory file does not reserve enough for ENC_COMP[0,AX1] (MD38000): set to 3, expected at least 31",
        ),
        (
            MEMORY,
            |text| text.replace("N38000 $MA_MM_ENC_COMP_MAX_POINTS[0,AX1]=31\n", ""),
            "the memory file does not reserve enough for ENC_COMP[0,AX1] (MD38000): not written, expected at least 31",
        ),
        (
            EEC,
            |text| text.replace("M30", "$MA_ENC_COMP_ENABLE[0,AX1]=1\nM30"),
            "`NONIUS_EEC.MPF` sets $MA_ENC_COMP_ENABLE[0,AX1] = 1: the job does not write it",
        ),
        (
            CEC,
            |text| {
                let table = "$AN_CEC[40,0]=0\n$AN_CEC[40,1]=0\n$AN_CEC_INPUT_AXIS[40]=(AX1)\n\
                             $AN_CEC_OUTPUT_AXIS[40]=(AX2)\n$AN_CEC_STEP[40]=50\n\
                             $AN_CEC_MIN[40]=0\n$AN_CEC_MAX[40]=50\n";
                text.replace("M30", &format!("{table}M30"))
            },
            "CEC table 40 (AX2 while AX1 moves): the job does not write it",
        ),
        (
            CEC,
            |text| {
                text.replace("$AN_CEC[0,", "$AN_CEC[50,")
                    .lines()
                    .map(|line| match line.starts_with("$AN_CEC_") {
                        true => line.replace("[0]=", "[50]=") + "\n",
                        false => line.to_string() + "\n",
                    })
                    .collect()
            },
            "CEC table 0 (AX2 while AX1 moves): missing, the job writes it",
        ),
    ];
    foreign_contents("siemens-840d-sl", &siemens);
    let (points, parameters) = ("PITCH.TXT", "CNC-PARA.TXT");
    let fanuc: [Foreign; 4] = [
        (
            points,
            |text| behind_first_percent(text, "N11200Q0P5\nN11201Q0P5\n"),
            "points 1200 to 1201: the job does not write them",
        ),
        (
            parameters,
            |text| behind_first_percent(text, "N01320Q1A1P100\n"),
            "parameter 1320 of axis 1 = 100: the job does not write it",
        ),
        (
            parameters,
            |text| behind_first_percent(text, "N01851Q1A4P20\n"),
            "parameter 1851 of axis 4 = 20: the job does not write it",
        ),
        (
            points,
            |text| behind_first_percent(text, "N11200Q0P0\n"),
            "point 1200: the job does not write it",
        ),
    ];
    foreign_contents("fanuc-30i", &fanuc);
}

fn foreign_contents(control: &str, cases: &[Foreign]) {
    let (directory, kit) = kit(control);
    fs::remove_file(kit.join("manifest.json")).expect("the file can be removed");
    expect_verdict(directory.path(), "untouched", 0, "job and tables agree");
    for (file, change, says) in cases {
        expect_of_changed(directory.path(), (file, file), change, (1, says));
    }
}
