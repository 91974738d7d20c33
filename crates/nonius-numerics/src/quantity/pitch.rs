//! Errors that repeat with a screw, a gear or a scale: whether targets can show them.

use crate::quantity::Millimetres;

/// Usual pitches of screws, racks and gears, mm; 0.2 in, 0.25 in and 0.5 in among them.
pub const USUAL_MM: [f64; 11] = [5.0, 5.08, 6.0, 6.35, 8.0, 10.0, 12.0, 12.7, 16.0, 20.0, 25.0];
/// Part of a pitch within which places count as one phase of it.
const SAME_PHASE: f64 = 0.02;
/// Of a pitch: rounding.
const ROUNDING: f64 = 1e-6;
/// Phases that show a sine, whatever its own is: a place in each fifth of the pitch.
const PHASES: f64 = 5.0;
/// Steps of a run are whole multiples of a tenth of a millimetre or 0.005 in, so that every control reaches each node.
pub const DIGIT_MM: [f64; 2] = [0.1, 0.127];

/// Which of [`USUAL_MM`] have all these places at one phase, so that an error of this pitch is the same at each.
pub fn unseen(places: &[Millimetres]) -> [bool; USUAL_MM.len()] {
    let is_at_one = |pitch: f64| {
        let turns = |pair: &[Millimetres]| (pair[1] - pair[0]).mm() / pitch;
        places.windows(2).map(turns).all(|turns| (turns - turns.round()).abs() < SAME_PHASE)
    };
    USUAL_MM.map(is_at_one)
}

/// How many of the usual pitches so many equal steps show at five phases or more.
pub fn seen(step_mm: f64, steps: u32) -> usize {
    let has_all = |pitch: f64| {
        let turns = (0..=steps).map(|k| f64::from(k) * step_mm / pitch + ROUNDING);
        let places = turns.map(|turns| PHASES * turns.fract());
        let is_met = |n: f64| places.clone().any(|at| (n..n + 1.0).contains(&at));
        [0.0, 1.0, 2.0, 3.0, 4.0].into_iter().all(is_met)
    };
    USUAL_MM.into_iter().filter(|pitch| has_all(*pitch)).count()
}

/// The longest step between two lengths, mm, that shows the most pitches; whole multiples of a length.
pub fn step_mm(shortest: f64, longest: f64, steps: u32, digit_mm: f64) -> f64 {
    let most = (longest / digit_mm + ROUNDING).floor();
    let lengths = std::iter::successors(Some(most), |digits| Some(digits - 1.0));
    let lengths = lengths.take_while(|digits| *digits >= (shortest / digit_mm).min(most));
    let better = |best: (usize, f64), next: (usize, f64)| if next.0 > best.0 { next } else { best };
    let rated = lengths.map(|digits| (seen(digits * digit_mm, steps), digits * digit_mm));
    rated.reduce(better).map_or(0.0, |(_, mm)| mm)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_that_are_no_multiple_show_every_pitch() {
        // 50 mm: 5.08, 6.35, 12, 12.7 and 16 mm only.
        assert_eq!([seen(50.0, 16), seen(49.0, 16)], [5, USUAL_MM.len()]);
        assert!((step_mm(46.0, 49.5, 16, 0.1) - 49.0).abs() < 1e-9);
        let places = [0.0, 50.0, 100.0].map(Millimetres::new);
        let hidden = USUAL_MM.iter().zip(unseen(&places)).filter(|(_, unseen)| *unseen);
        assert_eq!(hidden.map(|(mm, _)| *mm).collect::<Vec<_>>(), [5.0, 10.0, 25.0]);
    }
}
