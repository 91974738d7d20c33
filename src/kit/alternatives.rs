//! The same measurement with tables that the job does not ask for: what they would leave. A kit is made for each,
//! from the inputs to the bytes and back, so that a job which asks for it later gets the same figures.

use crate::inputs::job::{BacklashPolicy, Compensation, GridRequest, one_for_all};
use crate::judge::conformity::Verdict;
use crate::judge::forecast::{Change, Forecast};
use crate::kit::inputs::Inputs;
use crate::kit::made::Made;
use crate::quantity::{Axis, PerAxis};
use crate::text::{Problems, Word, words};
use serde::Serialize;

/// The backlash policy of each axis.
type Policies = PerAxis<Option<BacklashPolicy>>;

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
        let Made { compiled, forecast, verdict, .. } = Made::of(&inputs)?;
        let (terms, diagonals) = (forecast.terms.iter(), forecast.diagonals.iter());
        Ok(Alternative {
            backlash: inputs.job.compensation.backlash,
            tables: compiled.placements.len(),
            points: compiled.placements.iter().map(|p| p.points).sum(),
            term: Worst::of(terms.map(|t| (t.term.to_string(), t.change))),
            diagonal: Worst::of(diagonals.map(|d| (d.name.to_string(), d.change))),
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
pub struct Compared {
    /// The backlash policy of each axis; `None` = none is stated.
    pub backlash: Policies,
    /// The spacing of the points.
    pub spacing: Spacing,
    /// What they would leave.
    pub result: Result<Alternative, Problems>,
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
    let compared = |(backlash, spacing): (Policies, Spacing)| Compared {
        backlash,
        spacing,
        result: Alternative::of(inputs, |asked| {
            asked.backlash = backlash;
            for axis in Axis::ALL {
                if let Some(settings) = &mut asked.axes[axis] {
                    settings.grid = settings.grid.map(|grid| spacing.of(grid));
                }
            }
        }),
    };
    pairs.chain(one).map(compared).collect()
}

/// The other policies that a job could state for all axes.
fn for_all(own: &Policies) -> Vec<Policies> {
    let all = BacklashPolicy::WORDS.iter().map(|(_, policy)| PerAxis::from_fn(|_| Some(*policy)));
    all.filter(|other| other != own).collect()
}

/// The policies that a job could state instead: of one for all axes every other one; of one for each axis
/// every other one for one of them.
pub(super) fn other_policies(own: &Policies) -> Vec<Policies> {
    match own.x.is_some() && one_for_all(own) {
        true => for_all(own),
        false => for_one(own),
    }
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
    let others = stated.flat_map(with);
    others.filter(|other| other != own).collect()
}
