//! The same measurement with tables that the job does not ask for: what they would leave. A kit is made for each,
//! from the inputs to the bytes and back, so that a job which asks for it later gets the same figures.

use crate::inputs::job::{
    Acceptance, BacklashPolicy, Compensation, GridRequest, one_for_all, policies_as_stated,
};
use crate::judge::conformity::Verdict;
use crate::judge::field::Field;
use crate::judge::forecast::{Change, Forecast, Machine, forecast, judged_ranges};
use crate::kit::inputs::{Inputs, judged};
use crate::kit::loaded::BareKit;
use crate::quantity::{Axis, ErrorTerm, PerAxis, larger};
use crate::text::{Finding, Problems, Word, findings, joined, words};
use serde::Serialize;

/// The backlash policy of each axis.
pub type Policies = PerAxis<Option<BacklashPolicy>>;

/// What tables made otherwise would leave.
#[derive(Serialize)]
pub struct Alternative {
    /// The backlash policies.
    #[serde(skip)]
    pub backlash: Policies,
    /// How many tables the control gets.
    pub tables: usize,
    /// How many points they have together.
    pub points: usize,
    /// What they would leave.
    #[serde(skip)]
    pub forecast: Forecast,
    /// The forecast against the acceptance of the job.
    pub verdict: Verdict,
    /// The term of which most is left.
    pub term: Option<Worst>,
    /// The diagonal of which most is left.
    pub diagonal: Option<Worst>,
}

/// The term, or the diagonal, of which most is left.
#[derive(Serialize)]
pub struct Worst {
    /// Its name.
    pub name: String,
    /// As measured, µm.
    pub before_um: f64,
    /// With the tables, µm.
    pub after_um: f64,
    /// U of `after_um` with 95 %, µm; `None` = not stated.
    pub expanded_um: Option<f64>,
}

impl Worst {
    fn of(all: impl Iterator<Item = (String, Change)>) -> Option<Worst> {
        let (name, change) = all.reduce(|a, b| if b.1.after_um > a.1.after_um { b } else { a })?;
        let Change { before_um, after_um, expanded_um, .. } = change;
        Some(Worst { name, before_um, after_um, expanded_um })
    }
}

impl Alternative {
    /// What a job that asks for other tables would get.
    pub(super) fn of(
        inputs: &Inputs,
        change: impl FnOnce(&mut Compensation),
    ) -> Result<Alternative, Problems> {
        let inputs = inputs.asking_for(change)?;
        let BareKit { compiled, forecast, verdict, .. } = BareKit::of(&inputs)?;
        let (terms, diagonals) = (forecast.terms.iter(), forecast.diagonals.iter());
        Ok(Alternative {
            backlash: inputs.job.compensation.backlash,
            tables: compiled.placements.len(),
            points: compiled.placements.iter().map(|p| p.points).sum(),
            term: Worst::of(terms.map(|t| (t.term.to_string(), t.change))),
            diagonal: Worst::of(diagonals.map(|d| (d.diagonal.to_string(), d.change))),
            forecast,
            verdict,
        })
    }
}

words! {
    /// How far apart the points are, against what the job asks for.
    pub enum Spacing {
        /// As the job asks.
        AsAsked = "asked",
        /// Half of it.
        Half = "half",
        /// Twice as far.
        Twice = "twice",
    }
}

impl Spacing {
    /// All of them.
    pub const ALL: [Spacing; 3] = [Spacing::AsAsked, Spacing::Half, Spacing::Twice];

    /// What a job asks for in its place; of a residual half or twice as much.
    fn of(self, asked: GridRequest) -> GridRequest {
        let times = match self {
            Spacing::AsAsked => return asked,
            Spacing::Half => 0.5,
            Spacing::Twice => 2.0,
        };
        match (asked, self) {
            (GridRequest::Spacing(mm), _) => GridRequest::Spacing(times * mm),
            (GridRequest::MaxResidual(um), _) => GridRequest::MaxResidual(times * um),
            (GridRequest::Points(points), Spacing::Half) => {
                GridRequest::Points(points.saturating_mul(2) - 1)
            }
            (GridRequest::Points(points), _) => GridRequest::Points(points / 2 + 1),
        }
    }
}

/// A backlash policy and a spacing, with what they would leave, or why the job would be refused.
#[derive(Serialize)]
pub struct Compared {
    /// The backlash policy of each axis; `None` = none is stated.
    pub backlash: Policies,
    /// The spacing of the points.
    pub spacing: Spacing,
    /// Why the job would be refused; empty where it would not.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub refused: Vec<String>,
    /// What they would leave; `None` where it would be refused.
    #[serde(flatten)]
    pub made: Option<Alternative>,
}

/// Every backlash policy for all axes, that of the job first, each with every spacing; then every policy for one
/// axis, the others as the job states them. Of a job that states no policy, its spacings.
pub fn compare(inputs: &Inputs) -> Vec<Compared> {
    let own = inputs.job.compensation.backlash;
    let (all, one) = match own == Policies::default() {
        true => Default::default(),
        false => (for_all(&own), for_one(&own)),
    };
    let one = one.into_iter().filter(|policies| !all.contains(policies));
    let one: Vec<(Policies, Spacing)> = one.map(|own| (own, Spacing::AsAsked)).collect();
    let policies = std::iter::once(own).chain(all);
    let pairs = policies.flat_map(|policies| Spacing::ALL.map(|spacing| (policies, spacing)));
    let compared = |(backlash, spacing): (Policies, Spacing)| {
        let made = Alternative::of(inputs, |asked| {
            asked.backlash = backlash;
            for axis in Axis::ALL {
                if let Some(settings) = &mut asked.axes[axis] {
                    settings.grid = settings.grid.map(|grid| spacing.of(grid));
                }
            }
        });
        let problems = made.as_ref().err().into_iter().flat_map(Problems::iter);
        let refused = problems.map(|problem| problem.message.clone()).collect();
        Compared { backlash, spacing, refused, made: made.ok() }
    };
    pairs.chain(one).map(compared).collect()
}

/// The other policies that a job could state for all axes.
fn for_all(own: &Policies) -> Vec<Policies> {
    let all = BacklashPolicy::WORDS.iter().map(|(_, policy)| PerAxis::from_fn(|_| Some(*policy)));
    all.filter(|other| other != own).collect()
}

/// Every other policy for one axis, the other axes as stated.
fn for_one(own: &Policies) -> Vec<Policies> {
    let stated = Axis::ALL.into_iter().filter(|axis| own[*axis].is_some());
    let with = |axis: Axis| {
        BacklashPolicy::WORDS.iter().map(move |(_, policy)| {
            let mut others = *own;
            others[axis] = Some(*policy);
            others
        })
    };
    stated.flat_map(with).filter(|other| other != own).collect()
}

// What to change where a kit does not keep its limit: what other backlash policies would leave; and on a second
// visit, whether the control is best left as it is.

/// What the last printed digit does not show is no gain, µm.
const SHOWN_UM: f64 = 0.001;

findings! {
    /// What a person may change.
    Way {
        AsItIs { left: Left } => Label,
            "as measured, with what is active now, every limit is kept ({}): the control can be left as it is", left.words();
        Backlash { policies: PerAxis<Option<BacklashPolicy>>, left: Left, tables: usize, verdict: Verdict } => Label,
            "`backlash = {}` would leave {} with {tables} {}: {}", policies_as_stated(policies), left.words(), if *tables == 1 { "table" } else { "tables" }, verdict.word();
        Grid { terms: Vec<ErrorTerm>, largest_um: f64 } => Label,
            "{}: the points of the tables leave up to {largest_um:.3} µm of it; closer points (`spacing_mm`, `points`, `max_residual_um`) leave less", joined(terms);
        NoTable { terms: Vec<ErrorTerm> } => Label,
            "{}: no table holds it, so all of it is left", joined(terms);
    }
}

/// The largest of the figures that a job limits, µm; `None` = not limited, or there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Left {
    terms_um: Option<f64>,
    diagonals_um: Option<f64>,
}

impl Left {
    fn of(forecast: &Forecast, asked: Acceptance) -> Left {
        let terms_um = asked.max_deviation_um.map(|_| forecast.max_residual_um());
        let diagonals = forecast.diagonals.iter().filter(|_| asked.max_diagonal_um.is_some());
        Left { terms_um, diagonals_um: diagonals.map(|d| d.change.after_um).reduce(larger) }
    }

    /// By how much the worst of them exceeds its limit, µm; below 0 where all keep theirs.
    fn excess_um(self, asked: Acceptance) -> f64 {
        let over = |um: Option<f64>, limit: Option<f64>| Some(um? - limit?);
        let all = [
            over(self.terms_um, asked.max_deviation_um),
            over(self.diagonals_um, asked.max_diagonal_um),
        ];
        all.into_iter().flatten().reduce(f64::max).unwrap_or(f64::INFINITY)
    }

    fn words(self) -> String {
        let terms = self.terms_um.map(|um| format!("{um:.3} µm"));
        let diagonals = self.diagonals_um;
        let diagonals = diagonals.map(|um| format!("{um:.3} µm on the diagonals"));
        terms.into_iter().chain(diagonals).collect::<Vec<_>>().join(" and ")
    }
}

/// The ways to another answer; none where the kit keeps its limit and nothing was active.
pub(super) fn ways(made: &BareKit<'_>) -> Vec<Finding> {
    if made.inputs.job.acceptance.asks_nothing() {
        return Vec::new();
    }
    let mut ways: Vec<Way> = as_found(made).into_iter().collect();
    if made.verdict != Verdict::Pass {
        ways.extend(policies(made));
        ways.extend(of_terms(made).into_iter().flatten());
    }
    ways.into_iter().map(Finding::from).collect()
}

/// What keeps single terms from their limit: points too far apart, no table.
fn of_terms(made: &BareKit<'_>) -> Option<impl Iterator<Item = Way>> {
    let limit_um = made.inputs.job.acceptance.max_deviation_um?;
    let grid_um = |term: ErrorTerm| {
        let own = made.compiled.placements.iter().filter(|p| p.term == term);
        own.map(|p| p.grid_residual_um).fold(0.0, larger)
    };
    let left = made.forecast.terms.iter().filter(|t| t.change.after_um > limit_um);
    let (held, none): (Vec<_>, Vec<_>) = left.partition(|t| t.compensated);
    let grid = held.into_iter().filter(|t| 2.0 * grid_um(t.term) >= t.change.after_um);
    let grid: Vec<ErrorTerm> = grid.map(|t| t.term).collect();
    let none: Vec<ErrorTerm> = none.into_iter().map(|t| t.term).collect();
    let largest_um = grid.iter().map(|term| grid_um(*term)).fold(0.0, larger);
    let grid = (!grid.is_empty()).then_some(Way::Grid { terms: grid, largest_um });
    Some(grid.into_iter().chain((!none.is_empty()).then_some(Way::NoTable { terms: none })))
}

/// Where tables were active while measuring and what they left keeps every limit.
fn as_found(made: &BareKit<'_>) -> Option<Way> {
    let inputs = made.inputs;
    inputs.under_tables.as_ref()?;
    let model = inputs.as_measured();
    let ranges = judged_ranges(&inputs.job, model);
    let found = forecast(Machine::alone(model), &made.plan, &Field::default(), &ranges);
    let left = Left::of(&found, inputs.job.acceptance);
    (judged(&found, inputs, &made.doubts) == Verdict::Pass).then_some(Way::AsItIs { left })
}

/// The policies that come to a better verdict, or leave less where the limit is exceeded, the best first.
/// What the control refuses is no way.
fn policies(made: &BareKit<'_>) -> Vec<Way> {
    let asked = made.inputs.job.acceptance;
    let excess_um = |forecast: &Forecast| Left::of(forecast, asked).excess_um(asked);
    let own_um = excess_um(&made.forecast);
    let is_better = |(other, um): &(Alternative, f64)| {
        other.verdict < made.verdict || made.verdict == Verdict::Fail && *um < own_um - SHOWN_UM
    };
    // Of one policy for all axes every other one; of one for each axis every other one for one of them.
    let own = &made.inputs.job.compensation.backlash;
    let others = if own.x.is_some() && one_for_all(own) { for_all(own) } else { for_one(own) };
    let others = others.into_iter().filter_map(|policies| {
        let other = Alternative::of(made.inputs, |asked| asked.backlash = policies).ok()?;
        let um = excess_um(&other.forecast);
        Some((other, um))
    });
    let mut better: Vec<(Alternative, f64)> = others.filter(is_better).collect();
    better.sort_by(|a, b| a.0.verdict.cmp(&b.0.verdict).then(a.1.total_cmp(&b.1)));
    let way = |(other, _): (Alternative, f64)| Way::Backlash {
        policies: other.backlash,
        left: Left::of(&other.forecast, asked),
        tables: other.tables,
        verdict: other.verdict,
    };
    better.into_iter().map(way).collect()
}
