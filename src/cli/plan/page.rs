//! The screen of `plan`: the answer, the variants, their U, what it rests on.

use crate::cli::screen::{More, Screen, list, paragraphs, table, wrapped};
use crate::cli::show::um;
use crate::judge::findings::joined;
use crate::kit::visit_plan::{Design, Visit, VisitPlan, listed as in_words};
use crate::machine::separation::findings::SeparationFinding;
use crate::quantity::axis::{Axis, ErrorTerm};
use crate::text::finding::Finding;

/// A plan, to be shown.
pub(super) struct Page<'a> {
    pub(super) machine: &'a str,
    pub(super) design: &'a Design<'a>,
    pub(super) found: &'a VisitPlan,
}

impl Page<'_> {
    /// The page for people.
    pub(super) fn screen(&self) -> Screen {
        let described = &self.found.visits[0];
        let assumed = self.design.assumed(described);
        let assumed: Vec<String> = assumed.iter().map(|a| wrapped(&a.to_string())).collect();
        let labels = described.expected.labels.iter();
        // The noise is that of the assumptions.
        let is_noise =
            |label: &&Finding| matches!(label.kind(), Some(SeparationFinding::NoiseIs { .. }));
        let labels: Vec<&Finding> = labels.filter(|label| !is_noise(label)).collect();
        let lines = [Some(self.answer()), self.decided(), Some(self.proposed()), self.likely()];
        let lines: Vec<String> = lines.into_iter().flatten().collect();
        Screen {
            verdict: format!("{}: {}", self.machine, lines.join("\n")),
            figures: paragraphs(&[self.variants(), list("assumed", &assumed)]),
            findings: self
                .design
                .noise_asked()
                .iter()
                .map(ToString::to_string)
                .chain(described.shortcomings().iter().map(said))
                .collect(),
            more: vec![More::new(
                labels.len(),
                ["label", "labels"],
                list("labels of the separation", &labels),
            )],
            ..Screen::default()
        }
    }

    fn answer(&self) -> String {
        let described = &self.found.visits[0];
        let count = ErrorTerm::ALL.len() - described.expected.missing().len();
        let at_most = described.at_most_um().filter(|_| described.open.is_empty());
        let at_most = at_most.map(|um| format!(", the forecast is at most {um:.3} µm"));
        let keeps = match (self.limits(), described.reaches(self.design.acceptance())) {
            (None, _) => "; no acceptance is stated".to_string(),
            (Some(limits), true) => format!("; the acceptance ({limits}) is reached"),
            (Some(limits), false) => format!("; the acceptance ({limits}) is not reached"),
        };
        format!(
            "as described, {count} of 9 errors are determined{}{keeps}",
            at_most.unwrap_or_default()
        )
    }

    fn decided(&self) -> Option<String> {
        let parts = &self.found.decides;
        (!parts.is_empty()).then(|| format!("what decides: {}", in_words(parts)))
    }

    fn limits(&self) -> Option<String> {
        let acceptance = self.design.acceptance();
        let term = acceptance.max_deviation_um.map(|um| format!("{um} µm of every term"));
        let diagonal = acceptance.max_diagonal_um.map(|um| format!("{um} µm of every diagonal"));
        let limits: Vec<String> = term.into_iter().chain(diagonal).collect();
        (!limits.is_empty()).then(|| limits.join(", "))
    }

    fn proposed(&self) -> String {
        let aim = match self.limits() {
            None => "determines all wanted errors",
            Some(_) => "reaches the acceptance by its forecast",
        };
        match self.found.forecast {
            None => format!("no variant {aim}"),
            Some(index) => format!("the quickest that {aim}: {}", self.named(index)),
        }
    }

    /// What will pass after loading, too.
    fn likely(&self) -> Option<String> {
        self.limits()?;
        let aim = "passes its second measurement with 80 % or more";
        Some(match self.found.second {
            None => format!("no variant {aim}"),
            Some(index) => format!("the quickest that also {aim}: {}", self.named(index)),
        })
    }

    /// A visit by its letter, with what it needs of the tables.
    fn named(&self, index: usize) -> String {
        let visit = &self.found.visits[index];
        let (change, minutes) = (visit.variant.change(&self.design.described), visit.minutes);
        let grid = self
            .design
            .other_grid(&visit.variant)
            .map(|mm| format!("; change spacing_mm to x {}, y {}, z {}", mm.x, mm.y, mm.z));
        format!("{} ({change}), {minutes:.0} min{}", letter(index), grid.unwrap_or_default())
    }

    fn variants(&self) -> String {
        let row = |(index, visit): (usize, &Visit)| {
            let (name, change) = (letter(index), visit.variant.change(&self.design.described));
            let reversal = or_dash(Axis::letters(&visit.reversals()));
            let open = or_dash(joined(visit.expected.missing()));
            let chance =
                visit.chance.map_or("-".into(), |chance| format!("{:.0} %", 100.0 * chance));
            format!(
                "{name}\t{change}\t{:.0}\t{:.0}\t{open}\t{reversal}\t{}\t{chance}",
                visit.minutes,
                visit.variant.target_spacing_mm(),
                um(visit.at_most_um())
            )
        };
        let rows = self.found.visits.iter().enumerate().map(row);
        table(
            "\tvisit\t>min\t>targets/mm\tnot determined\treversal of\t>at most/µm\t>second passes",
            rows,
        )
    }
}

fn said(shortcoming: &Finding) -> String {
    format!("as described: {shortcoming}")
}

/// a, b, c …
pub(super) fn letter(index: usize) -> String {
    let letters = ('a'..='z').nth(index);
    letters.map_or_else(|| index.to_string(), String::from)
}

fn or_dash(words: String) -> String {
    match words.is_empty() {
        true => "-".to_string(),
        false => words,
    }
}
