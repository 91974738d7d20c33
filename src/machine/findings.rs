//! What is found of the errors of a machine, in words: of their separation, of their model, of figures by standard.

use super::separation::readings::{Noise, coverage_factor};
use crate::inputs::job::{Frame, StatedUncertainty};
use crate::quantity::{Axis, ErrorTerm, Figure, PerAxis, PerTerm, larger};
use crate::text::{Finding, findings, joined};

/// What to do about lines that contradict the diagonals.
pub const CHECK: &str = "check sign, unit, `laser_sign`, the size of the box, temperature and air";

findings! {
    /// What a separation can find.
    SeparationFinding {
        // Doubts.
        Disturbed { um: f64, which: String } => Note, "disturbed reading, which stays in the curves and moves them by up to {um:.3} µm: {which}; this counts in full beside U: repeat that run";
        OtherTurn { ran_over: bool } => Doubt, "`overrun = {}` is stated, but the readings are those of axes that {}", !ran_over, if *ran_over { "ran past the end point" } else { "turned at the end point" };
        OtherErrors => Doubt, "the nine errors of `closure_errors` do not describe this machine as it is now (closure test)";
        DisturbedTotal { which: String } => Doubt, "disturbed reading, which stays in the result: {which}; repeat that run";
        MoreDisturbed { more: usize } => Note, "{more} more disturbed readings stay in the result";
        Roll { changes: PerAxis<f64> } => Note, "the closure runs in straight ramps over the axes ({} µm from end to end): roll of an axis that carries others, which the nine errors do not hold; what is beyond `angle_urad` counts in full beside U: measure the roll and give it as `angles`", by_axis(changes, &Axis::ALL);
        SetUpNotPerfect { means: PerAxis<f64>, off: Vec<Axis> } => Doubt, "the set-up is assumed perfect, but the mean of the closure is not zero ({} µm): tilt of the mirror, or roll; solve for the set-up", by_axis(means, off);
        NoiseFar { noise: Noise, times: f64, stated_um: f64 } => Doubt, "noise of a single reading {noise}: more than {times} times the {stated_um} µm that `noise_um` states; a disturbed reading of any size may sit in it; repeat the runs, or correct `noise_um`";
        NoiseLarge { noise: Noise, assumed_um: f64 } => Doubt, "noise of a single reading {noise}: above the {assumed_um} µm that are assumed where `noise_um` is not stated; a disturbed reading of any size may sit in it; repeat the runs, or state `noise_um`";
        OtherNames { walked: String, after_um: f64, before_um: f64, odds: f64, is_order: bool } => Doubt, "as if {walked}: then the closure speaks for {after_um:.3} µm of noise, as recorded for {before_um:.3} µm, and nothing of it is against the nine errors (odds e^{odds:.0} to 1){}; compare the names in the file and the order in the job with the programs that were run", if *is_order { "; the closure cannot tell these apart" } else { "" };
        LinesDisagree { lines: String, taken_as_exact: bool } => Note, "linear axes and diagonals DISAGREE: each against all others, {lines}; {CHECK}{}; what the worst of them may falsify counts in full beside U", if *taken_as_exact { "; a line without `u_um_per_m` counts as exact here: state it" } else { "" };
        TurnAgainstLinear { axis: Axis, turn_um: f64, linear_um: f64 } => Disagreement, "the reversal of {axis} is {turn_um:.3} µm by the turn, {linear_um:.3} µm by its linear measurement: check `overrun`, and whether both were measured in the same state";

        // What stays undetermined.
        OpenScales { axes: Vec<Axis> } => Note, "{}", open_scales(axes);
        OpenSquareness { of: Axis, along: Axis } => Note, "squareness of {of} and {along}; measure a face diagonal of their plane";
        OpenReversal { of: String } => Note, "reversal of {of}: with overrun (or a zero of their own) the reverse runs hold at most its sum along the diagonals; reverse once without overrun and state `overrun = false`, or name a linear measurement of the axis with rows of both directions (`errors` of [[measurement.step_diagonal.linear]])";
        StillOpen { what: Finding } => Note, "not determined: {what}";

        // What is assumed of set-up, frame and passes.
        SetUpAssumed { tilt_arcsec: Option<f64> } => Label, "set-up assumed perfect: mirror and beam exactly along the four diagonals; a tilt of 10 arcsec falsifies slopes by tens of µm/m; it is {}", match tilt_arcsec {
            Some(arcsec) => format!("included in U as {arcsec} arcsec (k = 1, tilt_arcsec) in each direction"),
            None => "not included, so that no U is given where the slope is a separated one: state `tilt_arcsec` in [measurement.uncertainty]".to_string(),
        };
        FrameOf { frame: Frame } => Label, "{}", match frame {
            Frame::XPrimary => "frame: X primary, XY plane secondary (EYX, EZX, EZY without slope; EXY, EXZ, EYZ carry the squareness)",
            Frame::AsMeasured => "frame as measured: slopes of cross terms hold an arbitrary rotation; only their sums, the squareness, are free of it",
        };
        ForwardOnly => Label, "forward runs only: NPP moves X in -, PNP moves Y in -, PPN moves Z in -, so reversal is mixed into the curves";
        Overran { from: &'static str } => Label, "the axes ran past the end point before the reverse runs ({from})";
        Turned { from: &'static str } => Label, "the axes turned at the far end without overrun ({from}): the lost motion is taken off the last cell of the reverse runs";
        OverrunOpen => Label, "whether the axes ran past the end point cannot be judged from the readings: no reversal stands out of their noise, or offset and jumps contradict each other. State `overrun`; until then a lost motion that is hidden in the noise may stand in the last interval";
        OwnZero => Label, "reverse runs count from their own start, so only their increments are used";
        FromTurn { change_um: PerTerm<f64> } => Label, "reversal of each term from the turn and the return pass, as a curve along its axis; each is taken to change from end to end by as much as these readings show with their noise, at most by {:.3} µm (k = 1), and U holds that", change_um.iter().map(|(_, um)| *um).fold(0.0, larger);
        Directions => Label, "directions are those in which each axis really moved: + curves from forward runs of the diagonals that travel it in +, reverse runs of the others";
        LinearReversals { found: String, forward_only: bool } => Label, "reversal of single axes from their linear measurements in both directions (smallest to largest B, µm: {found}){}; their cross terms hold the mean of both directions, because nothing tells the reversal of those", if *forward_only { "; as far as it changes along the axis it is mixed into the curves of forward runs" } else { "" };
        ShortEdge { axis: Axis, gain: f64 } => Label, "{axis} is a short edge of the box: noise of its deviations is {gain:.1} times that of an increment";
        StraightForwardOnly => Label, "forward runs only: E, B and a reversal need both directions, and NPP moves X in -, PNP moves Y in -, PPN moves Z in -, so reversal is mixed into the squareness";
        StraightOneZero => Label, "both directions count from the start of the forward run";
        StraightOwnZero => Label, "reverse runs count from their own start: E, B and ranges are those of the forward runs alone; the totals are the mean of both directions";

        // What the uncertainty holds.
        NoAir => Label, "the readings are not corrected for air, and nothing corrects them here: about 1 µm/m of scale for each K of air temperature or 3.7 hPa";
        NoiseIs { noise: Noise } => Label, "noise of a single reading {:.3} µm (k = 1), {}{}", noise.sigma_um, noise.source.word(), noise.freedom.map_or_else(String::new, |freedom| format!(", {freedom} degrees of freedom: k = {:.2} by Student holds 95 %", coverage_factor(noise.freedom_f64())));
        Scatter { um: f64, repeated_um: f64 } => Note, "the closure scatters by {um:.3} µm, repeated runs by {repeated_um:.3} µm: the walks differ by more than the runs show, and the larger counts";
        NoiseContradicted { noise: Noise, stated_um: f64 } => Note, "noise of a single reading {noise}: `noise_um = {stated_um}` contradicts it and does not count";
        NoiseUnknown => Label, "noise of the readings is not known (one run, no redundancy): no uncertainty is given";
        LaserCounts { ppm: f64, is_stated: bool } => Label, "laser_ppm {} counts in the scales ({ppm}, k = 1), as an error that all four set-ups share", if *is_stated { "as stated" } else { "is not stated: a usual one" };
        OfMaterial { key: &'static str, is_stated: bool, known: PerAxis<bool>, needs: &'static str } => Label, "{}", of_material(key, *is_stated, known, needs);
        SetUpCounts { ppm: Option<f64>, each: String } => Label, "{}{each}", match ppm {
            Some(ppm) => format!("setup_ppm ({ppm}) is included: laser, air and scales change so much from one set-up to the next; each ppm makes µm/m of squareness: "),
            None => "setup_ppm is not stated: changes of laser, air and scale temperature between the four set-ups are not included; each ppm (0.09 K of steel) makes µm/m of squareness: ".to_string(),
        };
        BeamCounts { stated: StatedUncertainty } => Label, "beam_mrad {} counts ({}): it takes up to {:.3} µm/m off every diagonal, and all of that as k = 1", if stated.beam_mrad.is_some() { "as stated" } else { "is not stated: a usual one" }, stated.of_beam_mrad(), stated.beam_ppm();
        SimulatedHold => Label, "simulated intervals hold the noise of the readings and what is uncertain of linear axes, not these";
        AnglesMissing { names: String, urad: Option<f64>, chain_is_stated: bool } => Label, "angular errors without a measurement, counted as zero: {names}; no reading shows pitch and yaw, and the figures are meant for the lines through the middle of the box; {}", match urad {
            None => "not included in U: state `angle_urad` in [measurement.uncertainty]".to_string(),
            Some(urad) => format!("included in U: a straight part and a bow about the middle of the box, each within half of {urad} µrad (angle_urad){}", if *chain_is_stated { "" } else { ", for the worst order of the axes (`machine.chain` is not stated)" }),
        };
        OnLines { lines: PerAxis<f64>, without_u: bool } => Label, "the nine errors and squareness are those of the lines through X {}, Y {}, Z {} mm: the levers of the measured angles count from there, and the angles are zero there (`offsets_mm`, `angles_zero_mm`){}", lines.x, lines.y, lines.z, if *without_u { "; U of the angles is not stated (columns `u_ea_urad` …) and counts as 0" } else { "" };
        ToolAssumed { far_um: f64 } => Label, "tool_offset_mm is not stated: the mirror is taken to sit at the point that the axes carry; each 100 mm between them falsifies deviations by up to {far_um:.3} µm";
        LineNotKnown => Label, "a linear axis or beam states no uncertainty: it is weighed like a diagonal, and neither an uncertainty nor a simulated interval is given where a result depends on it; add `u_um_per_m`";
        LinesHoldAll => Label, "`u_um_per_m` of linear axes and beams is taken to hold everything that is uncertain of them, laser and temperature included, but `setup_ppm`";
        SlopesOverBox { spans: String } => Label, "stated slopes of linear axes are taken as those between the ends of the box ({spans}); give what was measured over another length as a `beam` with its two ends";
        SeparatedSlopesKept { separated: String, totals: String } => Label, "the curves keep their separated slopes, whose squareness (µm/m: {separated}) holds the tilt of the mirror and the noise of all increments; that of the totals ({totals}) holds neither: believe the totals";
        Unchecked => Label, "nothing checks the linear axes and beams: with no redundancy a slope of the wrong sign or unit goes unnoticed; measure the third axis along its length";
        Leak { by_plane: String } => Label, "the uncertainty of the squareness leaves out what is not determined of the scales: through the tilts of the mirror each 10 µm/m of it moves the squareness by up to (µm/m) {by_plane}";
        RotationOfCrossTerms => Label, "uncertainties of the cross terms hold the noise of their rotation, not the tilt of the mirror that is in it";
        HardlyShown { pairs: String, orders: String } => Note, "these readings cannot detect whether {}", swapped(pairs, orders);
        NothingShown => Note, "these readings cannot detect whether diagonals were swapped, or whether the steps went in another order: check the file names and the order of the steps";
    }
}

fn by_axis(um: &PerAxis<f64>, axes: &[Axis]) -> String {
    joined(axes.iter().map(|axis| format!("{axis} {:+.3}", Figure(um[*axis]))))
}

fn open_scales(axes: &[Axis]) -> String {
    match axes {
        [x, y, z] => format!(
            "scale of {x}, {y} and {z} can be traded against each other; measure two axes along their length"
        ),
        [a, b] => format!(
            "scale of {a} and {b} can be traded against each other; measure one axis along its length"
        ),
        other => format!("scale of {}", Axis::letters(other)),
    }
}

/// Whether a contribution that needs the material of an axis is stated and included, by axis.
fn of_material(key: &str, is_stated: bool, known: &PerAxis<bool>, needs: &str) -> String {
    let material = "[measurement.step_diagonal.material]";
    let axes = |wanted| joined(Axis::ALL.into_iter().filter(|axis| known[*axis] == wanted));
    let (with, without) = (axes(true), axes(false));
    match (with.as_str(), without.as_str()) {
        _ if !is_stated => format!("{key} is not stated and not included"),
        (_, "") => format!("{key} is included in the scales, the same error on all axes"),
        ("", _) => format!(
            "{key} is stated but not included for any axis: the job gives no {needs} ({material})"
        ),
        _ => format!(
            "{key} is included in the scales for {with}, the same error on them, but not for {without}: the job gives no {needs} of it ({material})"
        ),
    }
}

fn swapped(pairs: &str, orders: &str) -> String {
    match (pairs, orders) {
        (pairs, "") => format!("{pairs} were swapped: check the file names"),
        ("", orders) => format!("the steps went {orders}: check the order of the steps"),
        (pairs, orders) => format!(
            "{pairs} were swapped, or whether the steps went {orders}: check the file names and the order of the steps"
        ),
    }
}

findings! {
    /// What is found while the curves are made.
    ModelFinding {
        NotDetermined { terms: Vec<ErrorTerm> } => Doubt, "not determined by this measurement, so not judged: {}", joined(terms);
        HiddenReversal { um: f64 } => Doubt, "the readings show a reversal of about {um:.3} µm along the diagonals, which these curves do not hold: every figure here is without it";
        UnlikelySmall { largest_um: f64, least_um: f64 } => Doubt, "no error exceeds {} µm, and a machine tool below {least_um} µm throughout is unlikely: check the unit of the columns (mm under `_um`?), or state a `noise_um` below it", two_digits(*largest_um);
        SquarenessTwice { terms: [ErrorTerm; 2], stated: f64, slopes: f64 } => Doubt, "squareness {}{} is stated as {stated:.3} µm/m, and the slopes of {} and {} hold {slopes:.3} µm/m: both count; leave the key out, or give both straightnesses without their slopes", terms[0].of.key(), terms[0].along.key(), terms[0], terms[1];
        OpticNotInTables { axes: Vec<Axis> } => Doubt, "the straightness of {} was measured on the table (`straightness_optic_mm`), and tables hold it as measured, without what the angles do at that lever: convert it to the tool point (docs/volume.md §2) and leave the key out", Axis::letters(axes);
        OtherReference { zero: String } => Note, "the error table says what its largest errors are at most for a zero at {zero}; for other reference points the u of each value counts, as if the values were independent";
        AnglesNotCompensated => Note, "angular errors (`ea_…`, `eb_…`, `ec_…`) are not compensated by these tables; `nonius assess` counts what they do in the volume";
        DeviationsBeside { file: String } => Note, "`{file}` is named as `angles`; the deviations that stand beside them are not used";
    }
}

findings! {
    /// What has to be said beside the figures of a standard.
    StandardFinding {
        OneWay { way: &'static str } => Note, "not measured moving {way}: B, M and every figure of both directions are absent";
        OneRun { way: &'static str } => Note, "one run moving {way}: s, R and A are absent, they need two runs or more";
        LongAxis => Note, "above 2 m the standard reports E, B and M only; R and A are not according to it";
        TravelNotStated { measured: String } => Note, "the travel is not stated: the conditions are judged on the {measured} from the first to the last target";
        UpIsForward => Note, "up = the forward run, in the direction of the diagonal's name";
        ReverseNames => Note, "runs under the names of reverse runs (NNN …) are left out: their offset to the forward runs is not known";
        NoJob => Note, "no job: the readings are taken to be positive along the forward run (`laser_sign = \"+\"`), and nothing is corrected; give the job instead of the readings if that is not so";
    }
}

/// A number with its first two digits that are not zero, as in `0.018`.
pub(super) fn two_digits(number: f64) -> String {
    format!("{number:.1e}").parse::<f64>().unwrap_or(number).to_string()
}
