//! `verify` on a stick as it comes back: files of others, a kit of another control, a job that was changed since.

use crate::support::Visit;
use std::fs;

const VERIFY: &str = "verify job.toml --tables kit";

fn kit() -> Visit {
    Visit::of("start/errors").with_kit()
}

#[test]
fn what_operating_systems_leave_is_passed_over_with_or_without_manifest() {
    let visit = kit();
    visit
        .put("kit/.DS_Store", b"\0\0\0\x01Bud1\xff")
        .put("kit/Thumbs.db", b"\xd0\xcf\x11\xe0")
        .put("kit/desktop.ini", "[.ShellClassInfo]\r\n");
    fs::create_dir(visit.at("kit/System Volume Information")).unwrap();
    let words = "`.DS_Store` was ignored: an operating system left it";
    visit.run(VERIFY).ends(0).says(words);
    let manifest = visit.read("kit/manifest.json");
    fs::remove_file(visit.at("kit/manifest.json")).unwrap();
    visit.run(VERIFY).ends(0).says(words);
    // What is not listed, too, unless the control would read it.
    visit.put("kit/manifest.json", manifest);
    visit.put("kit/offer.pdf", b"%PDF-1.7\n\xff\xfe");
    visit.put("kit/notes.txt", "called the customer on Monday\n");
    let words = "`notes.txt` was ignored: manifest.json does not list it";
    visit.run(VERIFY).ends(0).says(words);
    visit.put("kit/OLD.MPF", "$AN_CEC[7,0]=0.01\n$AN_CEC[7,1]=0.02\n$AN_CEC_INPUT_AXIS[7]=(AX1)\n$AN_CEC_OUTPUT_AXIS[7]=(AX2)\n$AN_CEC_STEP[7]=100\n$AN_CEC_MIN[7]=0\n$AN_CEC_MAX[7]=100\nM30\n");
    let words = "`OLD.MPF` is not listed in manifest.json, and the control could read it";
    visit.run(VERIFY).ends(1).says(words);
    visit.put("kit/OLD.MPF", "$AN_CEC[7,0]=0.01\nM30\n");
    visit.run(VERIFY).ends(2).says("OLD.MPF");
}

#[test]
fn other_inputs_and_another_control_are_named() {
    let visit = kit();
    visit.put("job.toml", visit.read("job.toml") + "# a comment\n");
    let words = "the kit was made from other inputs: `job.toml` differ";
    visit.run(VERIFY).ends(0).says(words);
    let words = "the kit was made for another control: manifest.json names `siemens-840d-sl`";
    visit.edit("job.toml", "siemens-840d-sl", "siemens-828d");
    visit.run(VERIFY).ends(1).says(words);
    visit.edit("job.toml", "siemens-828d", "fanuc-30i");
    visit.edit("job.toml", "# detection_unit_um", "detection_unit_um");
    visit.run(VERIFY).ends(2).says(words);
}
