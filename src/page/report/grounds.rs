//! The verdict in the reader's language and unit, made from its facts: the limits, what it rests on, what does
//! not keep a limit. Sentences of the program stand on the first page where its language and unit are the reader's;
//! elsewhere a line says how many there are, and in which part.

use super::{FigureKind, Report};
use crate::inputs::error_table::Cause;
use crate::judge::conformity::Verdict;
use crate::judge::forecast::{JudgedRange, Miss, Of, RestsOn, is_whole_travel, widest_gap_mm};
use crate::kit::visit_plan::{Remeasurement, Share};
use crate::machine::separation::Part;
use crate::quantity::{Axis, ErrorTerm, Millimetres};
use crate::text::{escaped, joined};

/// So many of a kind stand on the first page; the parts behind it have all.
const MOST: usize = 3;
/// So many errors are named one by one.
const FEW: usize = 4;

/// One of the facts in a text, and what stands for it.
type Fact = (&'static str, String);

impl Report<'_> {
    /// The words of a key with its facts; `{error}` is the place of the fact `error`.
    pub(super) fn fill<const N: usize>(&self, key: &str, facts: [Fact; N]) -> String {
        let fact = |text: String, (name, words): Fact| text.replace(&format!("{{{name}}}"), &words);
        facts.into_iter().fold(self.t(key), fact)
    }

    /// A part behind the first page, by its title.
    fn link(&self, part: &str) -> String {
        format!("<a href=\"#{part}\">{}</a>", self.t(part))
    }

    /// A line of the limits, one of what the verdict rests on and does not count.
    pub(super) fn asked(&self) -> Vec<String> {
        // As found nothing is judged: a limit beside the figures would read as a result.
        if self.is_found() {
            return Vec::new();
        }
        let asked = self.job.acceptance;
        let limit = |what: String, um: f64| format!("{what}: \u{2264} {}", self.length(um));
        let deviation = asked.max_deviation_um.map(|um| limit(self.asked_errors(), um));
        let diagonal = asked.max_diagonal_um.map(|um| limit(self.t("asked_diagonal"), um));
        let limits: Vec<String> = deviation.into_iter().chain(diagonal).collect();
        let rests_on = self.visit.grounds.rests_on.iter();
        let rests_on: Vec<String> = rests_on.map(|part| self.rests_on(part)).collect();
        let lines = [limits, rests_on].map(|parts| parts.join("; "));
        lines.into_iter().filter(|line| !line.is_empty()).collect()
    }

    /// Never more than were measured.
    fn asked_errors(&self) -> String {
        let terms = &self.visit.grounds.terms;
        match terms.len() {
            0 => self.t("asked_deviation"),
            all if all == ErrorTerm::ALL.len() => self.t("asked_deviation"),
            few if few <= FEW => self.fill("asked_of", [("errors", joined(terms))]),
            some => self.fill("asked_of_some", [("count", some.to_string())]),
        }
    }

    fn rests_on(&self, part: &RestsOn) -> String {
        match part {
            RestsOn::Ranges(ranges) => self.ranges(ranges),
            RestsOn::Between { periodic_um, .. } if *periodic_um > 0.0 => {
                self.fill("between_added", [("um", self.length(*periodic_um))])
            }
            RestsOn::Between { ranges, .. } => {
                let mm = self.locale.mm();
                let pitches = JudgedRange::hidden_pitches(ranges, (mm.each, mm.sign));
                let key = if pitches.is_empty() { "between" } else { "between_hidden" };
                self.fill(key, [("pitches", self.locale.decimal(&pitches))])
            }
            RestsOn::OneWay(way) => {
                self.fill("one_way", [("way", way.symbol().replace('-', "\u{2212}"))])
            }
            RestsOn::ReversalNotCounted => self.t("reversal_not_counted"),
            RestsOn::NoReversal(terms) if terms.is_empty() => self.t("no_reversal"),
            RestsOn::NoReversal(terms) => self.fill("no_reversal_of", [("errors", joined(terms))]),
            RestsOn::WithoutU(terms) if terms.is_empty() => self.t("without_u"),
            RestsOn::WithoutU(terms) => self.fill("without_u_of", [("errors", joined(terms))]),
            RestsOn::Neglected(causes) => self.neglected(causes),
            RestsOn::Unused(keys) => self.fill("unused", [("keys", keys.join(", "))]),
            RestsOn::NineNeeded => self.t("nine_needed"),
        }
    }

    fn ranges(&self, ranges: &[JudgedRange]) -> String {
        let gap = ("gap", self.locale.position(widest_gap_mm(ranges)));
        if is_whole_travel(ranges) {
            return self.fill("over_travel", [gap]);
        }
        let one = |range: &JudgedRange| {
            let [low, high] = self.ends(range.judged);
            let share = self.share(range);
            let [axis, low, high, share] =
                [("axis", range.axis.to_string()), ("low", low), ("high", high), ("share", share)];
            match (range.is_stated, range.is_whole()) {
                (true, true) => self.fill("part_stated", [axis, low, high]),
                (true, false) => self.fill("part_of_stated", [axis, low, high, share]),
                (false, _) => self.fill("part_of_travel", [axis, share]),
            }
        };
        self.fill("over_parts", [("parts", joined(ranges.iter().map(one))), gap])
    }

    fn ends(&self, (low, high): (Millimetres, Millimetres)) -> [String; 2] {
        [low, high].map(|end| self.locale.position(end.mm()))
    }

    fn share(&self, range: &JudgedRange) -> String {
        match range.share * 100.0 {
            small if small > 0.0 && small < 1.0 => "&lt; 1 %".to_string(),
            percent => format!("{percent:.0} %"),
        }
    }

    fn neglected(&self, causes: &[Cause]) -> String {
        let words = causes.iter().map(|cause| self.t(&format!("cause_{}", cause.word())));
        self.fill("neglected", [("causes", joined(words))])
    }

    /// Why the verdict is no pass, the gravest first, short enough for the first page.
    pub(super) fn because(&self) -> Vec<String> {
        let visit = self.visit;
        let off = self.document("verify").pointer("/diagnosis/as_forecast") == Some(&false.into());
        let off = off.then(|| self.fill("not_as_forecast", [("part", self.link("findings"))]));
        let misses = self.misses();
        let more = misses.len().saturating_sub(MOST);
        let more = (more > 0).then(|| {
            self.fill("more", [("count", more.to_string()), ("part", self.link("reasons"))])
        });
        let misses = misses.into_iter().take(MOST).chain(more);
        let differences = self.said("files_differ", &visit.disagreements);
        let doubts = self.said("doubts", &visit.doubts);
        differences.into_iter().chain(misses).chain(off).chain(doubts).collect()
    }

    /// What decides and the smallest limit that is proved, then a line for each act.
    pub(super) fn decides(&self) -> Vec<String> {
        let Some(found) = &self.visit.decides else { return Vec::new() };
        let um = |at: &str| {
            let figure = self.figure("verify", &format!("/what_decides/{at}"), FigureKind::Reason);
            ("um", format!("{figure} {}", self.unit()))
        };
        let parts = found.parts.iter().enumerate();
        let parts = parts.map(|(index, part)| {
            self.fill("part", [("what", self.part_of_u(part)), um(&format!("parts/{index}/um"))])
        });
        let is_error = ErrorTerm::from_name(&found.term).is_some();
        let diagonal = || format!("{} {}", self.t("diagonal"), found.term);
        let facts = [
            ("what", if is_error { found.term.clone() } else { diagonal() }),
            ("left", um("left_um").1),
            ("parts", joined(parts)),
            um("at_most_um"),
        ];
        let acts = found.acts.iter().enumerate().map(|(index, act)| {
            let minutes = format!("/what_decides/acts/{index}/minutes");
            let minutes = ("minutes", self.figure("verify", &minutes, FigureKind::Count));
            let minutes = act.minutes.map(|_| self.fill("act_minutes", [minutes]));
            let what = [Some(self.act(&act.measured)), minutes];
            let what = what.into_iter().flatten().collect::<Vec<_>>().join(" ");
            let verdict = ("verdict", self.t(act.verdict.word()));
            self.fill("act", [("what", what), um(&format!("acts/{index}/at_most_um")), verdict])
        });
        std::iter::once(self.fill("decides", facts)).chain(acts).collect()
    }

    fn part_of_u(&self, share: &Share) -> String {
        match (share.part, share.linear) {
            (Part::Noise, _) => self.t("part_noise"),
            (Part::Laser, _) => self.t("part_laser"),
            (Part::Mirror, _) => self.t("cause_tilt_arcsec"),
            (Part::SetUps, _) => self.t("cause_setup_ppm"),
            (Part::Beam, _) => self.t("part_beam"),
            (Part::Stated, _) => self.t("part_table"),
            (Part::Line(_), None) => self.t("part_line"),
            (Part::Line(_), Some(axis)) => self.fill("part_linear", [("axis", axis.to_string())]),
            (Part::Angle(angle), _) => angle.to_string(),
        }
    }

    fn act(&self, measured: &Remeasurement) -> String {
        let Remeasurement { linear, angles, runs, new_tables } = measured;
        let linear = (!linear.is_empty()).then(|| ("act_linear", Axis::letters(linear)));
        let angles = match angles.as_slice() {
            [] => None,
            [one] => Some(("act_angle", one.to_string())),
            all => Some(("act_angles", all.len().to_string())),
        };
        let runs = runs.map(|runs| ("act_runs", runs.to_string()));
        let all = [linear, angles, runs].into_iter().flatten();
        let all: Vec<String> = all.map(|(key, fact)| self.fill(key, [("what", fact)])).collect();
        let made = if all.is_empty() { "act_new_tables" } else { "act_then_tables" };
        let made = new_tables.then(|| self.t(made));
        joined(all.into_iter().chain(made))
    }

    /// Sentences of the program under the words of a key, or how many there are.
    fn said(&self, key: &str, sentences: &[String]) -> Vec<String> {
        if sentences.is_empty() {
            return Vec::new();
        }
        let facts = [("count", sentences.len().to_string()), ("part", self.link("findings"))];
        let line = self.fill(key, facts);
        let shown = if self.is_as_said() { MOST } else { 0 };
        let line = (sentences.len() > shown).then_some(line);
        sentences.iter().take(shown).map(|words| escaped(words)).chain(line).collect()
    }

    /// What does not keep a limit, a line each, the worst first.
    pub(super) fn misses(&self) -> Vec<String> {
        let mut misses: Vec<&Miss> = self.visit.grounds.misses.iter().collect();
        misses.sort_by(|a, b| a.worst_first(b));
        misses.into_iter().map(|miss| self.miss(miss)).collect()
    }

    fn miss(&self, miss: &Miss) -> String {
        let (of, um, at_most_um, limit_um, verdict) = match miss {
            Miss::Range(range) => return self.too_little(range),
            Miss::NotStated(cause) => {
                let facts = [
                    ("cause", self.t(&format!("cause_{}", cause.word()))),
                    ("key", cause.word().to_string()),
                    ("verdict", self.t(Verdict::Undecided.word())),
                ];
                return self.fill("reason_not_stated", facts);
            }
            Miss::Figure { of, um, at_most_um, limit_um, verdict } => {
                (*of, *um, *at_most_um, *limit_um, *verdict)
            }
        };
        let unit = self.unit();
        let bound = |um: f64| ("um", format!("{} {unit}", self.reason(of, true, um)));
        let u = at_most_um.map(|um| self.fill("at_most", [bound(um)]));
        let facts = [
            ("what", self.what(of)),
            ("left", format!("{} {unit}", self.reason(of, false, um))),
            ("u", u.unwrap_or_else(|| self.t("u_not_stated"))),
            ("limit", self.length(limit_um)),
            ("verdict", self.t(verdict.word())),
        ];
        self.fill("reason", facts)
    }

    fn what(&self, of: Of) -> String {
        match of {
            Of::Term(term) => term.to_string(),
            Of::Terms => self.t("all_errors"),
            Of::Diagonal(name) => format!("{} {name}", self.t("diagonal")),
            Of::Diagonals => self.t("all_diagonals"),
        }
    }

    /// What is left, or its U, with three decimals: two may hide that it lies beyond the limit. The document
    /// has no figure of all diagonals together.
    fn reason(&self, of: Of, is_bound: bool, um: f64) -> String {
        let key = match (is_bound, self.visit.is_measured) {
            (true, _) => "at_most_um",
            (false, true) => "after_um",
            (false, false) => "forecast_um",
        };
        let at = match of {
            Of::Term(term) => format!("/terms/{term}/{key}"),
            Of::Diagonal(name) => format!("/diagonals/{name}/{key}"),
            Of::Terms if is_bound => "/max_residual_at_most_um".to_string(),
            Of::Terms => "/max_residual_um".to_string(),
            Of::Diagonals => return self.locale.deviation(um, 3),
        };
        self.figure("verify", &at, FigureKind::Reason)
    }

    fn too_little(&self, range: &JudgedRange) -> String {
        let [from, to] = self.ends(range.measured);
        let [low, high] = self.ends(range.judged);
        let facts = [
            ("axis", range.axis.to_string()),
            ("from", from),
            ("to", to),
            ("low", low),
            ("high", high),
            ("gap", self.locale.position(range.gap_mm)),
            ("share", self.share(range)),
            ("verdict", self.t(Verdict::Undecided.word())),
        ];
        self.fill("reason_range", facts)
    }
}
