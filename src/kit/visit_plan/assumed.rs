//! What the figures of a plan rest on, and what they do not hold.

use super::design::{Design, NOISE_UM};
use super::variant::Visit;
use crate::judge::findings::joined;
use crate::quantity::axis::{Axis, PerAxis};
use crate::text::finding::{Finding, findings};

findings! {
    /// What a plan rests on.
    Assumed {
        Noise { um: f64 } => Label, "noise of a reading {um} µm (noise_um)";
        NoiseNotStated { um: f64 } => Note, "noise of a reading {um} µm is assumed: state `noise_um` (instrument, air and machine together; the scatter of five readings at one place), because it decides how many runs are needed";
        NotCounted { words: String } => Label, "{words}";
        LinearAxes { runs: u32, u_um_per_m: PerAxis<f64>, named: Vec<Axis> } => Label, "linear axis: same laser, {runs} runs both ways, u_um_per_m = {:.2}, {:.2}, {:.2} (X, Y, Z; state it){}", u_um_per_m.x, u_um_per_m.y, u_um_per_m.z, match named.as_slice() {
            [] => String::new(),
            named => format!("; {} named by the job, no time", Axis::letters(named)),
        };
        Time { feed_mm_per_min: f64, dwell_s: f64, diagonal_min: f64, linear_min: f64 } => Label, "time: {feed_mm_per_min} mm/min, standstill {dwell_s} s, set-up {diagonal_min} min a diagonal, {linear_min} min a linear axis; no warm-up";
        Optics { circle_mm: f64 } => Label, "optics: flat mirror of {circle_mm:.1} mm and the diameter of the beam; retroreflector for linear axes";
        AtMost => Label, "at most: the largest of all errors in the forecast, with 95 %, before what the points of the tables leave";
        Second => Label, "second passes: share of 400 simulated second measurements, made like the first; the tables then leave the errors of the first and nothing else, and the machine stays as it is; measured angles are taken as known";
        NoU { terms: String } => Note, "U is not known for {terms}: with `setup = \"assume-perfect\"` state `tilt_arcsec`, or solve for the set-up; a beam needs `u_um_per_m`";
        OneDirection => Note, "one direction only: the reversal of every axis is mixed into the curves, and U does not hold it";
    }
}

impl Design<'_> {
    /// What the figures rest on.
    pub(crate) fn assumed(&self, described: &Visit) -> Vec<Finding> {
        let (run, times) = (&described.variant.run, self.times);
        let linear = Assumed::LinearAxes {
            runs: run.along(Axis::X).runs,
            u_um_per_m: self.u_um_per_m(described),
            named: self.axes_named(),
        };
        let time = Assumed::Time {
            feed_mm_per_min: run.feed_mm_per_min,
            dwell_s: run.dwell_s,
            diagonal_min: times.diagonal_min,
            linear_min: times.linear_min,
        };
        let optics = described.mirror.map(|mirror| Assumed::Optics { circle_mm: mirror.circle_mm });
        let own = [linear, time].into_iter().chain(optics);
        let all = self.of_instrument(described).into_iter().chain(own);
        all.chain([Assumed::AtMost, Assumed::Second]).map(Finding::from).collect()
    }

    /// What is asked for where the noise is not stated.
    pub(crate) fn noise_asked(&self) -> Option<Finding> {
        let is_stated = self.instrument.stated.noise_um.is_some();
        (!is_stated).then(|| Assumed::NoiseNotStated { um: NOISE_UM }.into())
    }

    /// Standard uncertainty of the slope of each axis: as the job states it, else as the laser gives it.
    pub(crate) fn u_um_per_m(&self, described: &Visit) -> PerAxis<f64> {
        PerAxis::from_fn(|axis| {
            let line = described.lines.iter();
            let mut line = line.filter(|line| line.direction[axis] > 0.999);
            let own = line.find_map(|line| line.u_um_per_m);
            own.unwrap_or_else(|| self.of_line(axis, &described.variant))
        })
    }

    /// What is known of the laser, and what U leaves out.
    fn of_instrument(&self, described: &Visit) -> Vec<Assumed> {
        let stated = self.instrument.stated;
        let noise = stated.noise_um.map(|um| Assumed::Noise { um });
        let not_counted = described.expected.silence.sentences().into_iter();
        let not_counted = not_counted.map(|words| Assumed::NotCounted { words });
        noise.into_iter().chain(not_counted).collect()
    }
}

impl Visit {
    /// What this visit leaves open or mixed up, the gravest first.
    pub(crate) fn shortcomings(&self) -> Vec<Finding> {
        let ranges = self.short_ranges().into_iter();
        let ranges = ranges.map(|words| Assumed::NotCounted { words }.into());
        let missing = self.expected.missing();
        let no_u = joined(self.open.iter().filter(|term| !missing.contains(term)));
        let no_u = (!no_u.is_empty()).then(|| Assumed::NoU { terms: no_u }.into());
        let open = self.expected.undetermined.iter().cloned();
        let one_way = !self.variant.run.bidirectional;
        let one_way = one_way.then(|| Assumed::OneDirection.into());
        ranges.chain(no_u).chain(open).chain(one_way).collect()
    }
}
