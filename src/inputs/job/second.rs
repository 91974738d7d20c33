//! A second job that states only in what it differs from the first: the TOML of one over that of the other.

use toml::de::{DeTable, DeValue};

/// What was measured or noted on one day belongs to that day: a second job never takes it from the first.
const OF_THE_DAY: [&str; 8] = [
    "date",
    "protocol",
    "angles",
    "squareness_um_per_m",
    "active_while_measuring",
    "active_terms_not_measured",
    "active_reference",
    "active_backlash_um",
];
/// Likewise in `[measurement.step_diagonal]`.
const OF_THE_RUN: [&str; 3] = ["linear", "beam", "material"];

/// Takes from the job below what a page does not state; a list is taken whole. Errors and readings exclude each
/// other, so whoever states one takes nothing of the other.
pub(super) fn lay_over<'a>(own: &mut DeTable<'a>, mut below: DeTable<'a>) {
    if let Some(measured) = own.get("measurement").and_then(|m| m.get_ref().as_table())
        && let Some(DeValue::Table(first)) = below.get_mut("measurement").map(|m| m.get_mut())
    {
        let others: &[&str] = match measured.contains_key("errors") {
            true => &["readings", "step_diagonal"],
            false if measured.contains_key("readings") => &["errors"],
            false => &[],
        };
        let all = others.iter().chain(&OF_THE_DAY);
        all.for_each(|key| _ = first.remove(*key));
        if let Some(DeValue::Table(run)) = first.get_mut("step_diagonal").map(|run| run.get_mut()) {
            OF_THE_RUN.iter().for_each(|key| _ = run.remove(*key));
        }
    }
    take_missing(own, below);
}

fn take_missing<'a>(own: &mut DeTable<'a>, below: DeTable<'a>) {
    for (key, value) in below {
        let name: &str = key.get_ref();
        match own.get_mut(name).map(toml::Spanned::get_mut) {
            None => _ = own.insert(key, value),
            Some(DeValue::Table(own)) => {
                if let DeValue::Table(below) = value.into_inner() {
                    take_missing(own, below);
                }
            }
            Some(_) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A second job that states nothing but its readings takes the set-up of the first, nothing of its day.
    #[test]
    fn what_belongs_to_a_day_is_not_taken_over() {
        let day = OF_THE_DAY.map(|key| format!("{key} = 1\n")).concat();
        let run = OF_THE_RUN.map(|key| format!("{key} = 1\n")).concat();
        let first =
            format!("[measurement]\nnoise = 1\n{day}[measurement.step_diagonal]\nsteps = 4\n{run}");
        let below = DeTable::parse(&first).unwrap().into_inner();
        let mut own = DeTable::parse("[measurement]\nreadings = 'b.csv'").unwrap().into_inner();
        lay_over(&mut own, below);
        let measured = own.get("measurement").unwrap().get_ref().as_table().unwrap();
        let mut keys: Vec<&str> = measured.keys().map(|key| key.get_ref().as_ref()).collect();
        keys.sort_unstable();
        assert_eq!(keys, ["noise", "readings", "step_diagonal"]);
        let run = measured["step_diagonal"].get_ref().as_table().unwrap();
        assert_eq!(run.len(), 1, "only `steps` is taken over: {run:?}");
    }
}
