use super::read;
use crate::control::table::klipper::Skew;

fn skew(text: &str) -> Result<Option<Skew>, String> {
    let read = read(&[("printer.cfg", text)]);
    read.map(|tables| tables.skew).map_err(|problems| problems.render())
}

/// A printer.cfg as SAVE_CONFIG leaves it: the profile stands behind `#*#`.
#[test]
fn a_saved_profile_is_read() {
    let text = "[printer]\nkinematics: corexy\n[skew_correction]\n#*# <---- SAVE_CONFIG ---->\n\
                #*# [skew_correction my_skew_profile]\n#*# xy_skew = -0.001\n#*# xz_skew = 0.0\n\
                #*# yz_skew = 2.5e-4\n#*#\n#*# [bed_mesh default]\n#*# version = 1\n";
    let own = skew(text).unwrap().unwrap();
    assert_eq!(own.name, "my_skew_profile");
    let expected = [-0.001, 0.0, 0.000_25].map(f64::to_bits);
    assert_eq!(own.factors().map(f64::to_bits), expected);
    assert_eq!(skew("[printer]\n[skew_correction]\n"), Ok(None));
}

#[test]
fn what_klipper_or_this_program_cannot_take_is_refused_at_its_place() {
    let own = "[skew_correction a]\nxy_skew: 0.001 # half a degree\nxz_skew = 0\nyz_skew = 0\n";
    assert!(skew(own).unwrap().is_some());
    for (from, to, words) in [
        ("yz_skew = 0\n", "", "no yz_skew: Klipper does not start"),
        ("0.001", "0,001", "printer.cfg:2:1"),
        ("0.001", "1.5", "a factor below 1"),
        ("xz_skew", "xy_skew", "each factor once"),
        ("xz_skew", "zx_skew", "xy_skew, xz_skew or yz_skew"),
        ("xz_skew = 0", "xz_skew", "`xy_skew = …`"),
        (
            "yz_skew = 0",
            "yz_skew = 0\n[skew_correction b]\nxy_skew=0\nxz_skew=0\nyz_skew=0",
            "several skew profiles",
        ),
    ] {
        let told = skew(&own.replace(from, to)).unwrap_err();
        assert!(told.contains(words), "{to}: {told}");
    }
}
