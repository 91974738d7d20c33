//! What each corrected joint gets, and whether all of it is taken out of its feedback again.
//!
//! Functions run one after the other, so each signal is a sum of what was there before:
//!
//! ```text
//!   drive    = command + Σ gain · curve       feedback = encoder − Σ gain · curve
//! ```

use super::netlist::{Curve, Function, Netlist, Pin};
use crate::control::table::linuxcnc::{CrossTable, Point};
use crate::read::lexer::Complaint;
use crate::text::problem::shown;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// What a signal is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Source<'a> {
    Command(u32),
    Position(u32),
    Curve(usize),
    /// What the rest of the machine's configuration puts on a signal.
    Outside(&'a str),
}

/// A sum of sources with their gains.
type Form<'a> = BTreeMap<Source<'a>, f64>;

/// Gains closer than this are equal.
const SAME_GAIN: f64 = 1e-12;

/// The tables of all corrected joints.
pub(super) fn of(netlist: &Netlist<'_>) -> Result<Vec<CrossTable>, Complaint> {
    let curves = (0..netlist.curves.len()).map(|number| points(netlist, number));
    let curves: Vec<Vec<Point>> = curves.collect::<Result<_, _>>()?;
    let run = Run::of(netlist)?;
    let mut tables = Found::new();
    for joint in run.joints() {
        run.correct(joint, &curves, &mut tables)?;
    }
    run.expect_all_used(&tables)?;
    Ok(tables.into_values().map(|(table, _)| table).collect())
}

/// Tables by output and base, with the curves they are made of.
type Found = BTreeMap<(u32, u32), (CrossTable, Vec<usize>)>;

/// The points of a curve, all set and ascending.
fn points(netlist: &Netlist<'_>, number: usize) -> Result<Vec<Point>, Complaint> {
    let Curve { positions, values } = &netlist.curves[number];
    let points = positions.iter().zip(values);
    let points =
        points.map(|(position, value)| Some(Point { position: (*position)?, value: (*value)? }));
    let at = || loaded(netlist, "lincurve");
    let Some(points) = points.collect::<Option<Vec<Point>>>() else {
        let message = format!("a point of lincurve.{number} is not set, and counts as 0 at 0");
        return Err(Complaint::new(at(), message, "set x-val and y-val of each point"));
    };
    if points.windows(2).any(|pair| pair[1].position <= pair[0].position) {
        let message = format!("the points of lincurve.{number} do not ascend");
        return Err(Complaint::new(at(), message, "points ascend, each position once"));
    }
    Ok(points)
}

fn loaded(netlist: &Netlist<'_>, component: &str) -> Range<usize> {
    netlist.loaded.get(component).cloned().unwrap_or(0..0)
}

/// A cycle of the thread.
struct Run<'a, 'n> {
    netlist: &'n Netlist<'a>,
    /// What each signal that something drives holds at the end.
    forms: BTreeMap<&'a str, Form<'a>>,
    /// The joint that each curve looks up.
    bases: BTreeMap<usize, u32>,
}

impl<'a, 'n> Run<'a, 'n> {
    fn of(netlist: &'n Netlist<'a>) -> Result<Run<'a, 'n>, Complaint> {
        let mut run = Run { netlist, forms: BTreeMap::new(), bases: BTreeMap::new() };
        for (name, signal) in &netlist.signals {
            let source = match signal.driver {
                Some(Pin::Position(joint)) => Source::Position(joint),
                Some(Pin::Command(joint)) => Source::Command(joint),
                Some(_) => continue,
                None => Source::Outside(name),
            };
            run.forms.insert(name, Form::from([(source, 1.0)]));
        }
        for (function, span) in &netlist.order {
            run.step(*function, span)?;
        }
        run.expect_all_run()?;
        Ok(run)
    }

    /// Runs one function.
    fn step(&mut self, function: Function, span: &Range<usize>) -> Result<(), Complaint> {
        let (inputs, output) = match function {
            Function::Curve(n) => (vec![(Pin::CurveIn(n), 1.0)], Pin::CurveOut(n)),
            Function::Sum(n) => {
                let gain = |input: usize| (Pin::SumIn(n, input), self.netlist.sums[n][input]);
                (vec![gain(0), gain(1)], Pin::SumOut(n))
            }
        };
        let mut sum = Form::new();
        for (pin, gain) in inputs {
            for (source, own) in self.input(pin, span)? {
                *sum.entry(*source).or_default() += own * gain;
            }
        }
        if let Function::Curve(n) = function {
            self.bases.insert(n, base(&sum).ok_or_else(|| self.no_position(n))?);
            sum = Form::from([(Source::Curve(n), 1.0)]);
        }
        let (signal, _) = self.linked(output, span)?;
        self.forms.insert(signal, sum);
        Ok(())
    }

    fn linked(
        &self,
        pin: Pin,
        span: &Range<usize>,
    ) -> Result<&'n (&'a str, Range<usize>), Complaint> {
        let linked = self.netlist.pins.get(&pin);
        linked.ok_or_else(|| {
            Complaint::new(
                span.clone(),
                "a pin of this component has no signal",
                "link its inputs and its output with `net`",
            )
        })
    }

    /// What stands on an input when its function runs.
    fn input(&self, pin: Pin, span: &Range<usize>) -> Result<&Form<'a>, Complaint> {
        let (signal, _) = self.linked(pin, span)?;
        self.forms.get(signal).ok_or_else(|| {
            let message = format!(
                "this runs before `{}` is made, so it takes that of the cycle before",
                shown(signal)
            );
            Complaint::new(
                span.clone(),
                message,
                "add curves first, then sums, each after those that it reads",
            )
        })
    }

    fn no_position(&self, curve: usize) -> Complaint {
        let at = self.netlist.pins.get(&Pin::CurveIn(curve)).map_or(0..0, |(_, span)| span.clone());
        let message =
            format!("lincurve.{curve} looks up something other than the position of a joint");
        Complaint::new(at, message, "link it to joint.N.pos-cmd")
    }

    /// A component that no thread runs does nothing.
    fn expect_all_run(&self) -> Result<(), Complaint> {
        let (curves, sums) = (self.netlist.curves.len(), self.netlist.sums.len());
        let all = (0..curves).map(Function::Curve).chain((0..sums).map(Function::Sum));
        let is_run =
            |function: &Function| self.netlist.order.iter().any(|(own, _)| own == function);
        let mut idle = all.filter(|function| !is_run(function));
        idle.next().map_or(Ok(()), |function| {
            let (component, number) = match function {
                Function::Curve(number) => ("lincurve", number),
                Function::Sum(number) => ("sum2", number),
            };
            let message = format!("no thread runs {component}.{number}");
            Err(Complaint::new(
                loaded(self.netlist, component),
                message,
                "add its function with `addf`",
            ))
        })
    }

    /// Joints of which a pin is linked that a correction needs.
    fn joints(&self) -> BTreeSet<u32> {
        let pins = self.netlist.pins.keys();
        pins.filter_map(|pin| match pin {
            Pin::Command(joint) | Pin::Feedback(joint) => Some(*joint),
            _ => None,
        })
        .collect()
    }

    /// Puts what a joint gets into `tables`.
    fn correct(
        &self,
        joint: u32,
        curves: &[Vec<Point>],
        tables: &mut Found,
    ) -> Result<(), Complaint> {
        let drive = self.drive(joint)?;
        let feedback = self.feedback(joint)?;
        let taken_out = feedback.len() == drive.len()
            && drive.iter().all(|(curve, gain)| {
                feedback.get(curve).is_some_and(|own| (own + gain).abs() <= SAME_GAIN)
            });
        if !taken_out {
            let message = format!(
                "what is added to the drive of joint {joint} is not what is taken out of its feedback"
            );
            return Err(self.at(Pin::Feedback(joint), message));
        }
        for (curve, gain) in drive {
            let base = self.bases[&curve];
            let (table, own) = tables.entry((joint, base)).or_insert_with(|| {
                (CrossTable { base, output: joint, pieces: Vec::new() }, Vec::new())
            });
            let scaled = |point: &Point| Point { value: point.value * gain + 0.0, ..*point };
            table.pieces.push(curves[curve].iter().map(scaled).collect());
            own.push(curve);
        }
        Ok(())
    }

    /// The curves in the signal that goes to the drive: the one with the command that nothing here reads.
    fn drive(&self, joint: u32) -> Result<BTreeMap<usize, f64>, Complaint> {
        let is_end = |name: &&str| {
            self.netlist.signals.get(*name).is_some_and(|signal| signal.readers.is_empty())
        };
        let command = Source::Command(joint);
        let mut ends =
            self.forms.iter().filter(|(name, form)| is_end(name) && form.contains_key(&command));
        let (one, other) = (ends.next(), ends.next());
        let curves = one
            .filter(|_| other.is_none())
            .and_then(|(_, form)| curves_beside(form, |source| source == command));
        curves.ok_or_else(|| {
            let message = format!(
                "joint {joint} has no signal that is its command and a correction, and nothing else"
            );
            self.at(Pin::Command(joint), message)
        })
    }

    /// The curves in its feedback, beside the encoder.
    fn feedback(&self, joint: u32) -> Result<BTreeMap<usize, f64>, Complaint> {
        let signal = self.netlist.pins.get(&Pin::Feedback(joint));
        let form = signal.and_then(|(name, _)| self.forms.get(name));
        let is_encoder = |source| matches!(source, Source::Outside(_));
        let curves = form.and_then(|form| curves_beside(form, is_encoder));
        curves.ok_or_else(|| {
            let message = format!("the feedback of joint {joint} is not its encoder and a correction, and nothing else");
            self.at(Pin::Feedback(joint), message)
        })
    }

    /// A complaint about a joint, where one of its pins is linked.
    fn at(&self, pin: Pin, message: String) -> Complaint {
        let (Pin::Command(joint) | Pin::Feedback(joint)) = pin else {
            return Complaint::new(0..0, message, HELP);
        };
        let pins = [pin, Pin::Command(joint), Pin::Feedback(joint)];
        let mut places = pins.iter().filter_map(|pin| self.netlist.pins.get(pin));
        let at = places.next().map_or(0..0, |(_, span)| span.clone());
        Complaint::new(at, message, HELP)
    }

    /// A curve that reaches no joint is meant for one.
    fn expect_all_used(&self, tables: &Found) -> Result<(), Complaint> {
        let used: BTreeSet<&usize> = tables.values().flat_map(|(_, curves)| curves).collect();
        let unused = (0..self.netlist.curves.len()).find(|curve| !used.contains(curve));
        unused.map_or(Ok(()), |curve| {
            let message = format!("lincurve.{curve} reaches no joint");
            Err(Complaint::new(loaded(self.netlist, "lincurve"), message, HELP))
        })
    }
}

const HELP: &str = "joint.N.motor-pos-cmd plus the correction goes to the drive, the encoder less the correction to joint.N.motor-pos-fb";

/// The joint whose position a form is.
fn base(form: &Form<'_>) -> Option<u32> {
    let mut sources = form.iter();
    match (sources.next(), sources.next()) {
        (Some((Source::Position(joint), gain)), None) if (gain - 1.0).abs() <= SAME_GAIN => {
            Some(*joint)
        }
        _ => None,
    }
}

/// The curves of a form, where all else is one source of gain 1.
fn curves_beside<'a>(
    form: &Form<'a>,
    is_other: impl Fn(Source<'a>) -> bool,
) -> Option<BTreeMap<usize, f64>> {
    let mut curves = BTreeMap::new();
    let mut others = 0;
    for (source, gain) in form {
        match source {
            Source::Curve(number) => _ = curves.insert(*number, *gain),
            source if is_other(*source) && (gain - 1.0).abs() <= SAME_GAIN => others += 1,
            _ => return None,
        }
    }
    (others == 1).then_some(curves)
}
