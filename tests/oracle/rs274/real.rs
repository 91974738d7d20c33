//! The programs of the real collection: name, unit or language, and what is expected.

use super::Unit::{self, Inch, Mm, Siemens};

/// What is expected of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Expected {
    /// Runs, and goes where LinuxCNC goes.
    Same,
    /// Refused with these words.
    Refused(&'static str),
    /// Runs; the box is apart by this, for a reason that docs/path.md §4 states.
    Apart(&'static str),
}
use Expected::{Apart, Refused, Same};

/// Keys of `[path]` for all of them.
pub(crate) const KEYS: &str = "g43_without_h = \"tool\"\n";

/// What LinuxCNC writes in another way, with the same moves.
pub(crate) const DIALECT: &[(&str, &str)] = &[
    ("G0 G91 G28", "G91 G28"), // G28 beside a motion word
    ("G0G91G28", "G91G28"),
    ("G28G91G0Z0", "G28G91Z0"),
    ("G04 X9999", "G04 P1"), // the time of a dwell
    ("H1(MAKE", "(MAKE"),    // H without G43
];

const TURNING: Expected = Refused("stands in turning programs");
const FAR: Expected = Refused("the end of the arc lies 162.1197 mm from the centre");
const SUBPROGRAM: Expected = Refused("`L340` calls a subprogram");

pub(crate) const PROGRAMS: &[(&str, Unit, Expected)] = &[
    ("CNC_Training__NC_Files_Cline_Maze.nc", Inch, Same),
    ("GCodeWorkShop__examples_FANUC0T.nc", Mm, TURNING),
    ("GCodeWorkShop__examples_FLANGE.nc", Mm, Refused("`P` has no number")),
    ("GCodeWorkShop__examples_SINUMERIK850.nc", Siemens, Refused("a sign that begins no word")),
    ("GCodeWorkShop__template_FANUC0T.nc", Mm, TURNING),
    ("Hass-CNC-Programs__CNC_MILL_3x3_face_-_o78237.nc", Inch, Same),
    ("Hass-CNC-Programs__CNC_MILL_4X2.95_BLOCK_-_o78242.nc", Inch, Same),
    ("Hass-CNC-Programs__CNC_MILL_Ckiely_-_o78234.nc", Inch, Same),
    ("Hass-CNC-Programs__CNC_MILL_Ckiely_-_o78235.nc", Inch, Same),
    ("Hass-CNC-Programs__CNC_MILL_O78240.nc", Inch, Same),
    ("Hass-CNC-Programs__CNC_MILL_step-part.nc", Inch, Same),
    ("Hass-CNC-Programs__CNC_MILL_stepblock_-_o78240.nc", Inch, Same),
    ("SK7420_750_N12_FAN__O300", Mm, Same),
    ("SK7420_750_N12_FAN__O8100", Mm, Refused("`#5021` is a variable of the control")),
    ("SK7420_750_N12_FAN__O8200", Mm, Refused("`#710` has no value")),
    ("SK7420_750_N12_FAN__O8501", Mm, Refused("`#671` has no value")),
    ("cnc-sprayer__deprecated_QUAD-ABCD_v1.tap", Inch, Same),
    ("cnc-sprayer__deprecated_QUAD-AC_v1.tap", Inch, Same),
    ("cnc-sprayer__deprecated_QUAD-A_v1.tap", Inch, Same),
    ("cnc-sprayer__deprecated_QUAD-CD_v1.tap", Inch, Same),
    ("cnc-sprayer__quads_QUAD-B.tap", Inch, Same),
    ("cnc-sprayer__quads_QUAD-CD.tap", Inch, Same),
    ("cnc-sprayer__quads_QUAD-D.tap", Inch, Same),
    ("cnc-sprayer__tests_fusion-inch.nc", Inch, Same),
    ("cnc-sprayer__tests_fusion-inchV8.nc", Inch, FAR),
    ("cnc-sprayer__tests_spray-test-working.nc", Inch, Same),
    ("cnc-sprayer__tests_spray-test.nc", Inch, Same),
    ("easy_gcode_plot__cnc_programs_CONTOUR.NC", Mm, Same),
    ("easy_gcode_plot__cnc_programs_CONTOUR_ABS.NC", Mm, Refused("write G90.1 before")),
    ("easy_gcode_plot__cnc_programs_CONTOUR_R.NC", Mm, Same),
    ("easy_gcode_plot__cnc_programs_G17_18_19.NC", Mm, Same),
    ("easy_gcode_plot__cnc_programs_G81.NC", Mm, Same),
    ("easy_gcode_plot__cnc_programs_G81_G91.NC", Mm, Same),
    ("easy_gcode_plot__cnc_programs_G82.NC", Mm, Same),
    ("easy_gcode_plot__cnc_programs_TEST.NC", Mm, Same),
    ("easy_gcode_plot__cnc_programs_TEST4.NC", Mm, Same),
    ("easy_gcode_plot__cnc_programs_TEST_G91.NC", Mm, Apart("box by 50.8000 mm")),
    ("easy_gcode_plot__cnc_programs_TEST_TURN.NC", Mm, TURNING),
    ("easy_gcode_plot__cnc_programs_VINT_REV_360arc.NC", Mm, Same),
    ("led_floor__cad_nc_1072_face_otherside.nc", Mm, Same),
    ("led_floor__cad_nc_1074_wall_27bit_ch_gap_depth_tab_pos.nc", Mm, Same),
    ("led_floor__cad_nc_1075_27bit_deeper_bore.nc", Mm, Same),
    ("led_floor__cad_nc_1076_light_holes_fix.nc", Mm, Same),
    ("led_floor__cad_nc_1077_bore_speed_test.nc", Mm, Same),
    ("led_floor__cad_nc_1079_light_holder_27bit.nc", Mm, Same),
    ("led_floor__cad_nc_1080_light_holder_27bit_longer_thinner_extrude.nc", Mm, Same),
    ("led_floor__d_nc_1078_wall_27bit_slower_feeds_wider_light_holder_hole.nc", Mm, Same),
    ("led_floor__nc_1080_light_holder_27bit_longer_thinner_extrude_no_lead.nc", Mm, Same),
    ("sublime-s840d__gcode_tests_syntax_test_cycle.spf", Siemens, SUBPROGRAM),
    ("sublime-s840d__gcode_tests_syntax_test_if.spf", Siemens, Refused("`IF` is not executed")),
];

/// Whether that was found.
pub(crate) fn is_so(expected: Expected, found: &Result<(), String>) -> bool {
    let says = |begin: &str, words: &str| {
        found.as_ref().is_err_and(|said| said.starts_with(begin) && said.contains(words))
    };
    match expected {
        Same => found.is_ok(),
        Refused(words) => says("refused: ", words),
        Apart(words) => says("length by ", words),
    }
}
