//! What the model of the errors has to say of the measurement behind it.

use crate::quantity::ErrorTerm;
use crate::text::{findings, joined};

findings! {
    /// What is found while the curves are made.
    ModelFinding {
        NotDetermined { terms: Vec<ErrorTerm> } => Doubt, "not determined by this measurement, so not judged: {}", joined(terms);
        HiddenReversal { um: f64 } => Doubt, "the readings show a reversal of about {um:.3} µm along the diagonals, which these curves do not hold: every figure here is without it";
        UnlikelySmall { largest_um: f64, least_um: f64 } => Doubt, "no error exceeds {} µm, and a machine tool below {least_um} µm throughout is unlikely: check the unit of the columns (mm under `_um`?), or state a `noise_um` below it", two_digits(*largest_um);
        SquarenessTwice { terms: [ErrorTerm; 2], stated: f64, slopes: f64 } => Doubt, "squareness {}{} is stated as {stated:.3} µm/m, and the slopes of {} and {} hold {slopes:.3} µm/m: both count; leave the key out, or give both straightnesses without their slopes", terms[0].of.key(), terms[0].along.key(), terms[0], terms[1];
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
    let rounded = format!("{number:.1e}").parse::<f64>();
    rounded.unwrap_or(number).to_string()
}
