//! What has to be known about the tables of a kit, one line each: for the page that is printed and
//! for the checklist that goes to the machine.

use crate::judge::forecast::Forecast;
use crate::quantity::axis::Axis;
use crate::quantity::units::Millimetres;
use crate::write::compensation::Compiled;
use crate::write::plan::Plan;

/// Terms without a table, parts of the travel that were not measured, figures that become worse,
/// and the notes.
pub fn remarks(plan: &Plan, compiled: &Compiled, forecast: Option<&Forecast>) -> Vec<String> {
    let omitted = plan.omitted.iter();
    let omitted = omitted.map(|o| format!("no table for {}: {}", o.term, o.reason));
    let unmeasured = forecast.map(not_measured).unwrap_or_default();
    let worsened = forecast.map(Forecast::worsened).unwrap_or_default();
    let worsened = worsened.iter().map(|words| format!("WARNING: {words}"));
    let notes = compiled.notes.iter().map(|note| format!("note: {note}"));
    omitted
        .chain(unmeasured)
        .chain(worsened)
        .chain(notes)
        .collect()
}

fn not_measured(forecast: &Forecast) -> Vec<String> {
    let sentence = |axis: Axis, (from, to): &(Millimetres, Millimetres)| {
        let shown = |at: &Millimetres| (at.mm() * 1e6).round() / 1e6 + 0.0;
        format!(
            "not measured: {axis} from {} to {} mm; the table holds the end value there",
            shown(from),
            shown(to)
        )
    };
    let of_axis = |axis: Axis| {
        forecast.unmeasured[axis]
            .iter()
            .map(move |part| sentence(axis, part))
    };
    Axis::ALL.into_iter().flat_map(of_axis).collect()
}
