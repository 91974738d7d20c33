//! Components and signals of a HAL file, as its statements make them.

use crate::control::controller::LinuxcncFacts;
use crate::control::table::linuxcnc::MOST_JOINTS;
use crate::read::lexer::Complaint;
use crate::read::linuxcnc::hal::statement::Word;
use crate::text::problem::shown;
use std::collections::BTreeMap;
use std::ops::Range;

/// What `help` says of anything else.
const ONLY: &str = "name the file of the kit alone: of HAL files only curves (lincurve) and sums (sum2) of the positions of joints are read";

/// A pin of a joint or of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Pin {
    /// `joint.N.pos-cmd`: where a joint is meant to be.
    Position(u32),
    /// `joint.N.motor-pos-cmd`: what its drive is told without the file.
    Command(u32),
    /// `joint.N.motor-pos-fb`: what the control takes for its position.
    Feedback(u32),
    /// `lincurve.N.in`.
    CurveIn(usize),
    /// `lincurve.N.out`.
    CurveOut(usize),
    /// `sum2.N.in0`, `sum2.N.in1`.
    SumIn(usize, usize),
    /// `sum2.N.out`.
    SumOut(usize),
}

impl Pin {
    /// Whether it drives its signal.
    const fn is_output(self) -> bool {
        matches!(self, Pin::Position(_) | Pin::Command(_) | Pin::CurveOut(_) | Pin::SumOut(_))
    }
}

/// A curve: its points by index, those that are set.
#[derive(Clone, Default)]
pub(super) struct Curve {
    pub(super) positions: Vec<Option<f64>>,
    pub(super) values: Vec<Option<f64>>,
}

/// A component whose function runs in a thread.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Function {
    Curve(usize),
    Sum(usize),
}

/// A signal: what drives it, and the pins that it is linked to.
#[derive(Default)]
pub(super) struct Signal {
    pub(super) driver: Option<Pin>,
    pub(super) readers: Vec<Pin>,
}

/// What the statements make.
#[derive(Default)]
pub(super) struct Netlist<'a> {
    pub(super) curves: Vec<Curve>,
    /// Gains of the two inputs.
    pub(super) sums: Vec<[f64; 2]>,
    pub(super) signals: BTreeMap<&'a str, Signal>,
    /// The signal of each pin, and where it is linked.
    pub(super) pins: BTreeMap<Pin, (&'a str, Range<usize>)>,
    /// Functions in the order in which they run.
    pub(super) order: Vec<(Function, Range<usize>)>,
    /// Where the components are loaded.
    pub(super) loaded: BTreeMap<&'a str, Range<usize>>,
    thread: Option<&'a str>,
}

impl<'a> Netlist<'a> {
    /// Takes a statement.
    pub(super) fn take(
        &mut self,
        words: &[Word<'a>],
        facts: &LinuxcncFacts,
    ) -> Result<(), Complaint> {
        match (words[0].text, &words[1..]) {
            ("loadrt", [component, options @ ..]) => self.load(component, options, facts),
            ("addf", [function, thread]) => self.add(function, thread),
            ("net", [signal, pins @ ..]) if !pins.is_empty() => self.net(signal, pins),
            ("setp", [name, value]) => self.set(name, value),
            _ => {
                let message = format!("`{}` is not read here", shown(words[0].text));
                Err(words[0].wrong(message, ONLY))
            }
        }
    }

    fn load(
        &mut self,
        component: &Word<'a>,
        options: &[Word<'a>],
        facts: &LinuxcncFacts,
    ) -> Result<(), Complaint> {
        let option = |name: &str| {
            let mut values = options.iter().filter_map(move |word| {
                let value = word.text.strip_prefix(name)?.strip_prefix('=')?;
                Some(value)
            });
            values.next()
        };
        let count = option("count").and_then(|count| count.parse::<usize>().ok());
        let most = facts.curves.value as usize;
        let lengths = option("personality").map(|list| lengths(list, count?, facts));
        let help = "`loadrt sum2 count=N`, `loadrt lincurve count=N personality=LIST`, each once";
        match (component.text, options.len(), count, lengths.flatten()) {
            (name, ..) if self.loaded.contains_key(name) => {
                let message =
                    format!("`{}` is loaded a second time: LinuxCNC does not start", shown(name));
                return Err(component.wrong(message, help));
            }
            ("lincurve", 2, Some(count), _) if count > most => {
                let message =
                    format!("{count} curves, more than the {most} that the memory of HAL holds");
                return Err(component.wrong(message, "use a larger spacing"));
            }
            ("lincurve", 2, Some(_), Some(lengths)) => {
                self.curves = lengths.into_iter().map(Curve::of).collect()
            }
            ("sum2", 1, Some(count @ 1..=MOST_SUMS), _) => self.sums = vec![[1.0; 2]; count],
            ("lincurve" | "sum2", ..) => {
                let message =
                    format!("`{}` is loaded in a way that is not read", shown(component.text));
                return Err(component.wrong(message, help));
            }
            (name, ..) => {
                let message = format!("`{}` is a component that is not read here", shown(name));
                return Err(component.wrong(message, ONLY));
            }
        }
        self.loaded.insert(component.text, component.span());
        Ok(())
    }

    /// Functions run in the order in which they are added.
    fn add(&mut self, function: &Word<'a>, thread: &Word<'a>) -> Result<(), Complaint> {
        let known = match numbered(function.text, "lincurve", "").filter(|n| *n < self.curves.len())
        {
            Some(curve) => Some(Function::Curve(curve)),
            None => numbered(function.text, "sum2", "")
                .filter(|n| *n < self.sums.len())
                .map(Function::Sum),
        };
        let Some(known) = known else {
            return Err(self.unknown(function));
        };
        if self.order.iter().any(|(own, _)| *own == known) {
            let message = format!("`{}` is added a second time", shown(function.text));
            return Err(function.wrong(message, "add each function once"));
        }
        if *self.thread.get_or_insert(thread.text) != thread.text {
            let message =
                format!("`{}` is another thread than that of the lines above", shown(thread.text));
            return Err(
                thread.wrong(message, "add all functions to the thread of the motion controller")
            );
        }
        self.order.push((known, function.span()));
        Ok(())
    }

    fn net(&mut self, name: &Word<'a>, pins: &[Word<'a>]) -> Result<(), Complaint> {
        let is_arrow = |word: &&Word<'a>| ["=>", "<=", "<=>"].contains(&word.text);
        for word in pins.iter().filter(|word| !is_arrow(word)) {
            let pin = self.pin(word.text).ok_or_else(|| self.unknown(word))?;
            if self.pins.contains_key(&pin) {
                let message = format!("`{}` is linked a second time", shown(word.text));
                return Err(word.wrong(message, "a pin has one signal"));
            }
            let signal = self.signals.entry(name.text).or_default();
            if !pin.is_output() {
                signal.readers.push(pin);
            } else if signal.driver.replace(pin).is_some() {
                let message = format!("signal `{}` has two sources", shown(name.text));
                return Err(word.wrong(message, "give each source a signal of its own"));
            }
            self.pins.insert(pin, (name.text, word.span()));
        }
        Ok(())
    }

    /// A pin of a joint, or of a component that was loaded.
    fn pin(&self, text: &str) -> Option<Pin> {
        let joint = |pin: &str| {
            let number = u32::try_from(numbered(text, "joint", pin)?).ok();
            number.filter(|number| *number < MOST_JOINTS)
        };
        let curve = |pin: &str| numbered(text, "lincurve", pin).filter(|n| *n < self.curves.len());
        let sum = |pin: &str| numbered(text, "sum2", pin).filter(|n| *n < self.sums.len());
        joint(".pos-cmd")
            .map(Pin::Position)
            .or_else(|| joint(".motor-pos-cmd").map(Pin::Command))
            .or_else(|| joint(".motor-pos-fb").map(Pin::Feedback))
            .or_else(|| curve(".in").map(Pin::CurveIn))
            .or_else(|| curve(".out").map(Pin::CurveOut))
            .or_else(|| sum(".in0").map(|n| Pin::SumIn(n, 0)))
            .or_else(|| sum(".in1").map(|n| Pin::SumIn(n, 1)))
            .or_else(|| sum(".out").map(Pin::SumOut))
    }

    fn set(&mut self, name: &Word<'a>, value: &Word<'a>) -> Result<(), Complaint> {
        let number = value.text.parse::<f64>().ok().filter(|number| number.abs() < LARGEST);
        let Some(number) = number else {
            let message = format!("`{}` is no number that a machine can mean", shown(value.text));
            return Err(value.wrong(message, "write a decimal number"));
        };
        if let Some(gain) = self.gain(name.text) {
            *gain = number;
            return Ok(());
        }
        match self.coordinate(name.text) {
            Some(place) => {
                *place = Some(number + 0.0); // −0 is 0
                Ok(())
            }
            None => Err(self.unknown(name)),
        }
    }

    fn gain(&mut self, name: &str) -> Option<&mut f64> {
        let (component, input) = name.rsplit_once('.')?;
        let gains = self.sums.get_mut(numbered(component, "sum2", "")?)?;
        match input {
            "gain0" => Some(&mut gains[0]),
            "gain1" => Some(&mut gains[1]),
            _ => None,
        }
    }

    fn coordinate(&mut self, name: &str) -> Option<&mut Option<f64>> {
        let (component, field) = name.rsplit_once('.')?;
        let curve = self.curves.get_mut(numbered(component, "lincurve", "")?)?;
        let (axis, index) = field.split_once("-val-")?;
        let index = (index.len() == 2).then(|| index.parse::<usize>().ok())??;
        match axis {
            "x" => curve.positions.get_mut(index),
            "y" => curve.values.get_mut(index),
            _ => None,
        }
    }

    fn unknown(&self, word: &Word<'_>) -> Complaint {
        let message = format!(
            "there is no `{}` among what the lines above load and this program reads",
            shown(word.text)
        );
        word.wrong(message, ONLY)
    }
}

impl Curve {
    fn of(points: usize) -> Curve {
        Curve { positions: vec![None; points], values: vec![None; points] }
    }
}

/// Sums fill the memory of HAL before.
const MOST_SUMS: usize = 100_000;

/// Positions, values and gains lie below it.
const LARGEST: f64 = 1e6;

/// The number N of `lincurve.N.in`, as HAL writes it.
fn numbered(text: &str, component: &str, pin: &str) -> Option<usize> {
    let number = text.strip_prefix(component)?.strip_prefix('.')?.strip_suffix(pin)?;
    number.parse().ok().filter(|n: &usize| n.to_string() == number)
}

/// Points of each curve: a list is used from its beginning again where there are more curves.
fn lengths(list: &str, count: usize, facts: &LinuxcncFacts) -> Option<Vec<usize>> {
    let (most, points) = (facts.personalities.value as usize, facts.curve_points.value as usize);
    let numbers: Option<Vec<usize>> = list.split(',').map(|number| number.parse().ok()).collect();
    let numbers = numbers.filter(|numbers| numbers.iter().all(|n| (2..=points).contains(n)))?;
    let is_whole = numbers.len() == count.min(most);
    (is_whole && count <= facts.curves.value as usize)
        .then(|| (0..count).map(|i| numbers[i % most]).collect())
}
