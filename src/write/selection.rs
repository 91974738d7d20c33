//! A control with fewer tables than terms: which terms get one, and which get two.
//!
//! A term can be left without a table, take the mean of both directions, or take what the policy
//! asks for (two tables, one for each direction). The tables go to the combination that leaves
//! the smallest largest error in the volume. For every combination that the control can hold and
//! that cannot be enlarged, the error vector left at a point is the sum of what the three axes
//! leave,
//!
//! ```text
//!   e(x, y, z) = v_X(x) + v_Y(y) + v_Z(z),   v_A = Σ terms along A of deviation(direction) − table(direction)
//! ```
//! and its largest length over all measured positions and directions decides. On straight curve
//! pieces a length is largest at the ends of the pieces, so with linear curves the search over
//! the measured positions is exact; with cubic ones it is exact at the measured positions.
//! Angular errors are not part of it; grid and rounding are not either, they are far smaller than
//! a term without a table.

use crate::machine::model::{ErrorModel, MeasuredTerm, TermCurves};
use crate::quantity::{Axis, Direction, ErrorCurve, ErrorTerm, Millimetres, PerAxis};
use crate::write::findings::TableFinding;
use crate::write::task::{Omission, TermTargets};

/// What one term costs of a limited resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cost {
    /// Which error.
    pub term: ErrorTerm,
    /// Tables (or straightness sets) that it takes as the policy asks.
    pub tables: u32,
    /// Tables that the mean of both directions takes, where that can stand in for two tables.
    pub mean_tables: Option<u32>,
}

/// How many tables of a kind a control has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TableStock {
    /// Tables of the control.
    pub tables: u32,
    /// How many of them are in use already.
    pub used: u32,
    /// What they are called.
    pub resource: &'static str,
    /// The key of the job that says which are in use.
    pub key: &'static str,
    /// Whether the two tables of an axis that corrects itself are of this kind.
    pub takes_pairs: bool,
    /// How many other axes an axis can follow; `None` = all that there are.
    pub masters: Option<u32>,
}

impl TableStock {
    /// That of a control on which an axis can follow so many others; `None` = all that there are.
    pub(crate) fn of_cross_terms(masters: u32) -> Option<TableStock> {
        let resource = match masters {
            0 => "tables for cross terms that this profile writes (fact `cross_terms`)",
            1 => "tables for cross terms, one for each axis that is corrected,",
            _ => return None,
        };
        Some(TableStock {
            tables: if masters == 0 { 0 } else { u32::MAX },
            resource,
            key: "terms",
            masters: Some(masters),
            ..TableStock::default()
        })
    }

    /// Whether costs of these forms are within it.
    fn holds(&self, costs: &[Cost], forms: &[Form]) -> bool {
        let pairs = || costs.iter().zip(forms);
        let used: u32 = pairs().map(|(cost, form)| cost.of_form(*form)).sum();
        let followed = |axis: Axis| {
            let of_axis =
                pairs().filter(|(cost, form)| cost.term.of == axis && **form > Form::Nothing);
            of_axis.filter(|(cost, _)| cost.term.is_cross()).count()
        };
        let most = self.masters.map_or(usize::MAX, |most| most as usize);
        used <= self.free() && Axis::ALL.into_iter().all(|axis| followed(axis) <= most)
    }

    fn free(&self) -> u32 {
        self.tables.saturating_sub(self.used)
    }

    fn words(&self, wanted: u32) -> String {
        let TableStock { tables, used, resource, key, .. } = self;
        if *tables == 0 {
            format!("the control has no {resource}")
        } else if *tables == u32::MAX {
            format!("the control has {resource} and more are asked for")
        } else if *used == 0 {
            format!("the control has {tables} {resource} for {wanted}")
        } else {
            format!(
                "the control has {tables} {resource}, of which {used} are in use (`{key}`), for {wanted}"
            )
        }
    }
}

/// The outcome of a choice.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Terms that get no table.
    pub omitted: Vec<Omission>,
    /// Terms that get the mean of both directions instead of two tables, and why.
    pub reduced: Vec<(ErrorTerm, TableFinding)>,
}

/// What a term gets; in the order of what it costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Form {
    Nothing,
    Mean,
    Whole,
}

impl Cost {
    /// What the term can get. A mean that costs nothing is always taken rather than nothing.
    fn forms(&self) -> impl Iterator<Item = Form> + use<> {
        let nothing = (self.mean_tables != Some(0)).then_some(Form::Nothing);
        let mean = self.mean_tables.map(|_| Form::Mean);
        [nothing, mean, Some(Form::Whole)].into_iter().flatten()
    }

    fn of_form(&self, form: Form) -> u32 {
        match form {
            Form::Nothing => 0,
            Form::Mean => self.mean_tables.unwrap_or(0),
            Form::Whole => self.tables,
        }
    }
}

/// The best combination within a budget; `None` if all terms fit as they are wanted.
pub(crate) fn choose(
    model: &ErrorModel,
    targets: &[TermTargets],
    costs: &[Cost],
    budget: TableStock,
) -> Option<Choice> {
    if budget.holds(costs, &vec![Form::Whole; costs.len()]) {
        return None;
    }
    let parts = Parts { states: PerAxis::from_fn(|axis| states_of(model, targets, axis)), costs };
    let mut best: Option<(f64, Vec<Form>)> = None;
    for forms in maximal(costs, &budget) {
        let limit = best.as_ref().map_or(f64::INFINITY, |(least, _)| *least);
        let left = parts.largest(&forms, limit + TIE_UM);
        // A hair's breadth of a difference is no reason to prefer a combination of fewer terms.
        let better = best.as_ref().is_none_or(|(least, chosen)| {
            left < least - TIE_UM || (left < least + TIE_UM && weight(&forms) > weight(chosen))
        });
        if better {
            best = Some((left, forms));
        }
    }
    let (left_um, forms) = best?;
    Some(parts.explain(&forms, left_um, budget))
}

/// Two largest errors closer than this are equal, µm.
const TIE_UM: f64 = 1e-9;

/// Terms with a table, then terms with all their tables.
fn weight(forms: &[Form]) -> (usize, usize) {
    let count = |least: Form| forms.iter().filter(|form| **form >= least).count();
    (count(Form::Mean), count(Form::Whole))
}

/// All combinations within a stock of which no term can get more.
fn maximal(costs: &[Cost], stock: &TableStock) -> Vec<Vec<Form>> {
    let mut combinations: Vec<Vec<Form>> = vec![Vec::new()];
    for cost in costs {
        let longer = |forms: &Vec<Form>| {
            let forms = forms.clone();
            let with = move |form| [&forms[..], &[form]].concat();
            cost.forms().map(with).filter(|forms: &Vec<Form>| stock.holds(costs, forms))
        };
        combinations = combinations.iter().flat_map(longer).collect();
    }
    let can_get_more = |forms: &Vec<Form>| {
        let more = |(index, cost): (usize, &Cost)| {
            let mut fuller = forms.clone();
            cost.forms().any(|form| {
                fuller[index] = form;
                form > forms[index] && stock.holds(costs, &fuller)
            })
        };
        costs.iter().enumerate().any(more)
    };
    combinations.retain(|forms| !can_get_more(forms));
    combinations
}

/// What one axis contributes at one of its positions in one direction: for each term along the axis what is left
/// without a table, with the mean, with all.
type State = Vec<(ErrorTerm, [f64; 3])>;

/// What the axes leave.
struct Parts<'a> {
    states: PerAxis<Vec<State>>,
    costs: &'a [Cost],
}

impl Parts<'_> {
    fn explain(&self, forms: &[Form], left_um: f64, budget: TableStock) -> Choice {
        let shortage = budget.words(self.costs.iter().map(|cost| cost.tables).sum());
        let mut choice = Choice { omitted: Vec::new(), reduced: Vec::new() };
        for (index, (cost, form)) in self.costs.iter().zip(forms).enumerate() {
            let mut fuller = forms.to_vec();
            fuller[index] = Form::Whole;
            if *form == Form::Whole {
                continue;
            }
            let (term, with_um) = (cost.term, self.largest(&fuller, f64::INFINITY));
            let left = format!(
                "{shortage}; the chosen tables leave at most {left_um:.1} µm in the volume"
            );
            if *form == Form::Mean && budget.tables > 0 {
                choice.reduced.push((term, TableFinding::MeanOnly { term, left, with_um }));
                continue;
            }
            let reason = match budget.tables {
                0 => shortage.clone(),
                _ => format!("{left} ({with_um:.1} µm if there were a table for {term} too)"),
            };
            choice.omitted.push(Omission { term, reason });
        }
        choice
    }

    /// Largest error vector if the terms have tables of these forms, and all terms that cost
    /// nothing have theirs. Above `enough` any larger value may be returned.
    fn largest(&self, forms: &[Form], enough: f64) -> f64 {
        let [x, y, z] = Axis::ALL.map(|axis| self.vectors(axis, forms));
        largest_sum([&x, &y, &z], enough)
    }

    /// What the states of an axis leave, longest first, so that a search can end early.
    fn vectors(&self, axis: Axis, forms: &[Form]) -> Vec<PerAxis<f64>> {
        let vector = |state: &State| {
            let mut vector = PerAxis::default();
            for (term, left) in state {
                let index = self.costs.iter().position(|own| own.term == *term);
                let form = index.map_or(Form::Whole, |index| forms[index]);
                vector[term.of] += left[form as usize];
            }
            vector
        };
        let mut vectors: Vec<PerAxis<f64>> = self.states[axis].iter().map(vector).collect();
        vectors.sort_by(|a, b| b.length().total_cmp(&a.length()));
        if vectors.iter().all(|v| v.length() < TIE_UM) {
            vectors.truncate(1);
        }
        if vectors.is_empty() {
            vectors.push(PerAxis::default());
        }
        vectors
    }
}

fn states_of(model: &ErrorModel, targets: &[TermTargets], axis: Axis) -> Vec<State> {
    let mut states = Vec::new();
    let is_undirected = |own: &MeasuredTerm| matches!(own.measured, TermCurves::Undirected(_));
    let is_one = model.measured_along(axis).all(|(_, own)| is_undirected(own));
    for direction in if is_one { &[Direction::Plus][..] } else { &Direction::BOTH } {
        for position in positions_of(model, axis, *direction) {
            let state = model.measured_along(axis).filter_map(|(term, measured)| {
                let curve = measured.measured.curve(*direction)?;
                let deviation = curve.at(position).um();
                let own = targets.iter().find(|t| t.term == term);
                let whole = own.and_then(|t| t.curve(*direction));
                let mean = own.and_then(|t| t.mean.as_ref()).or(whole);
                let left = |table: Option<&ErrorCurve>| {
                    deviation - table.map_or(0.0, |curve| curve.at(position).um())
                };
                Some((term, [deviation, left(mean), left(whole)]))
            });
            states.push(state.collect());
        }
    }
    states
}

fn positions_of(model: &ErrorModel, axis: Axis, direction: Direction) -> Vec<Millimetres> {
    let curves = model.measured_along(axis).filter_map(|(_, own)| own.measured.curve(direction));
    let mut positions: Vec<Millimetres> = curves.flat_map(|own| own.knots().to_vec()).collect();
    positions.sort_by(|a, b| a.mm().total_cmp(&b.mm()));
    positions.dedup();
    positions
}

/// Largest |a + b + c| over three sets of vectors, each with its longest first; the search ends
/// as soon as it is above `enough`. A partial sum that cannot beat the best even with the longest
/// partner is ignored.
fn largest_sum([first, second, third]: [&[PerAxis<f64>]; 3], enough: f64) -> f64 {
    let longest = |set: &[PerAxis<f64>]| set.first().map_or(0.0, |v| v.length());
    let (of_second, of_third) = (longest(second), longest(third));
    let mut best = 0.0_f64;
    for a in first {
        if a.length() + of_second + of_third <= best {
            break;
        }
        for b in second {
            let partial = a.plus(*b);
            if partial.length() + of_third <= best {
                continue;
            }
            for c in third {
                best = best.max(partial.plus(*c).length());
            }
            if best > enough {
                return best;
            }
        }
    }
    best
}
