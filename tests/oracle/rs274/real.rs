//! The programs of the real collection: unit or language, and what is expected.

use super::Unit::{self, Inch, Mm, Siemens};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Expected {
    /// Runs, and goes where LinuxCNC goes.
    Same,
    Refused(&'static str),
    /// Runs; the box is apart by this, for a reason that docs/volume.md §10 states.
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

pub(crate) fn unit(name: &str) -> Unit {
    match name.split("__").next() {
        Some("CNC_Training" | "Hass-CNC-Programs" | "cnc-sprayer") => Inch,
        _ if name.contains("s840d") || name.contains("SINUMERIK") => Siemens,
        _ => Mm,
    }
}

const TURNING: Expected = Refused("stands in turning programs");

/// What does not go where LinuxCNC goes, by the end of its name.
const OTHERS: [(&str, Expected); 13] = [
    ("examples_FANUC0T.nc", TURNING),
    ("template_FANUC0T.nc", TURNING),
    ("TEST_TURN.NC", TURNING),
    ("FLANGE.nc", Refused("`P` has no number")),
    ("SINUMERIK850.nc", Refused("a sign that begins no word")),
    ("__O8100", Refused("`#5021` is a variable of the control")),
    ("__O8200", Refused("`#710` has no value")),
    ("__O8501", Refused("`#671` has no value")),
    ("inchV8.nc", Refused("the end of the arc lies 162.1197 mm from the centre")),
    ("CONTOUR_ABS.NC", Refused("write G90.1 before")),
    ("TEST_G91.NC", Apart("box by 50.8000 mm")),
    ("syntax_test_cycle.spf", Refused("`L340` calls a subprogram")),
    ("syntax_test_if.spf", Refused("`IF` is not executed")),
];

pub(crate) fn expected(name: &str) -> Expected {
    let own = OTHERS.iter().find(|(end, _)| name.ends_with(end));
    own.map_or(Same, |(_, expected)| *expected)
}

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
