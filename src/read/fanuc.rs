//! Fanuc parameter and pitch-data files → [`FanucMemory`].
//!
//! ```text
//!   file → record (% … %) → block (N Q A P) → point or parameter → memory ─┐ merge
//!   file → …                                                     → memory ─┴──────→ one memory
//! ```
//! Written from the control's file formats alone: B-63950EN/02 §3.3 (30i class, with `Q`),
//! B-63330EN/03 §3 (15i), operator's manual B-63534EN (four digits, no `Q`). It reads more than
//! the program writes, as a control does, and says where a control would stop or where it would
//! understand something else than was meant.

mod block;
pub mod control;
mod record;
#[cfg(test)]
pub(crate) mod tests;

use self::control::FanucControl;
use crate::control::control_state::ControlState;
use crate::control::controller::{FanucFacts, LengthUnit, NumberRange};
use crate::control::table::Tables;
use crate::control::table::fanuc::{FanucMemory, ParameterKey, ParameterValue};
use crate::read::control_data;
use crate::read::emulate::{CannotEmulate, Emulator};
use crate::read::family::{Family, KitText, ReadBack, each, other_family};
use crate::text::problem::{Problem, Problems, refuse_long_lines};
use block::{Block, Identifier, Segment};
use record::{Source, Span};

/// What the data word of one point can hold (B-63330EN §3, B-63950EN §3.3: −128 to 127).
const POINT_VALUES: std::ops::RangeInclusive<i32> = -128..=127;
/// Values of one file that concern the compensation. A control of 32 axes has some 6000; each takes up
/// to a hundred bytes of memory.
const MOST_VALUES: usize = 100_000;
/// 1240, 3624 and 3625: lengths that depend on the unit of the machine.
const LENGTH_PARAMETERS: [u32; 3] = [1240, 3624, 3625];

impl Family for FanucFacts {
    fn read_kit(&self, files: &[KitText<'_>]) -> Result<ReadBack, Problems> {
        let memories = each(files, |path, text| read(path, text, self))?;
        Ok(Tables::Fanuc(merge(memories)?).into())
    }

    fn control(
        &self,
        tables: &Tables,
        state: &ControlState,
    ) -> Result<Box<dyn Emulator>, CannotEmulate> {
        let Tables::Fanuc(memory) = tables else {
            return Err(other_family());
        };
        Ok(Box::new(FanucControl::new(memory, self, state)?))
    }

    /// Numbered blocks.
    fn may_obey(&self, text: &str) -> bool {
        let numbered = |line: &str| {
            let number = line.trim_start().strip_prefix(['N', 'n']);
            number.is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
        };
        text.split(['\n', '\r']).any(numbered)
    }

    fn passed_over(&self, text: &str) -> usize {
        control_data::fanuc(text, self).1
    }
}

/// Reads one file of `N…P…` blocks: parameters, pitch points, or both.
///
/// unit   values as in the file: increments and amounts in detection units, 3624 in the control's unit
/// sign   as in the file ([`FanucFacts::pitch_sign`] says what it means)
/// source grammar of B-63950EN/02 §3.3 (`Q0` point, `Q1` parameter) and B-63330EN/03 §3 (number
///        from [`FanucFacts::point_offset`] on: point); a later block overwrites an earlier one,
///        but two different values of one point are a problem
/// limits path 1 only, no spindles, no G10 programs; after 200 problems it stops looking for more; `M` and `I` are refused, as
///        they mark lengths and feeds (§3.3.2) in a unit that the memory does not keep
///
/// All problems of the file come back together, each with its place.
pub fn read(file_name: &str, text: &str, facts: &FanucFacts) -> Result<FanucMemory, Problems> {
    Ok(read_from(Writer::Kit, file_name, text, facts)?.memory)
}

/// Reads a file that a control wrote of itself; as [`read`], but a parameter in the number space
/// of the points, such as 10800, is what it says it is, and `M` or `I` before a length are taken
/// where they are the control's `unit` (B-63950EN/02 §3.3.2).
pub fn read_out(
    file_name: &str,
    text: &str,
    facts: &FanucFacts,
    unit: LengthUnit,
) -> Result<ReadOut, Problems> {
    read_from(Writer::Control(unit), file_name, text, facts)
}

/// A file that a control wrote of itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOut {
    /// Parameters of no axis or an axis, and points.
    pub memory: FanucMemory,
    /// Parameters of spindles that are not 0, such as `3666 of S1 = 5`: they correct no axis of the
    /// job, but may take points.
    pub spindles: Vec<String>,
}

/// Who wrote a file.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Writer {
    /// A program or a person: `Q1` before the number of a point is a mistake.
    Kit,
    /// The control, which counts in this unit.
    Control(LengthUnit),
}

impl Writer {
    /// Whether a length behind this letter is in the unit of the control.
    fn may_write(self, letter: char) -> bool {
        let of_unit = match self {
            Writer::Kit => None,
            Writer::Control(LengthUnit::Millimetre) => Some('M'),
            Writer::Control(LengthUnit::Inch) => Some('I'),
        };
        letter == 'P' || Some(letter) == of_unit
    }
}

fn read_from(
    writer: Writer,
    file_name: &str,
    text: &str,
    facts: &FanucFacts,
) -> Result<ReadOut, Problems> {
    let source = Source::new(file_name, text);
    refuse_long_lines(file_name, source.text())?;
    let mut problems = Problems::none();
    let record = source.record(writer == Writer::Kit, &mut problems);
    let mut reader = Reader {
        source: &source,
        facts,
        writer,
        memory: FanucMemory::default(),
        spindles: Vec::new(),
        problems,
        in_program: false,
    };
    for span in source.blocks(record) {
        if reader.problems.is_full() {
            break; // nobody reads further, and a file of another kind has one in each line
        }
        if reader.values() > MOST_VALUES {
            let problem = source.problem(&span, format!("here are more than {MOST_VALUES} values for the compensation, too many for any control"));
            reader
                .problems
                .push(problem.help("check that this is a file of the control"));
            break;
        }
        reader.read_block(&span);
    }
    reader.problems.or_ok(ReadOut {
        memory: reader.memory,
        spindles: reader.spindles,
    })
}

/// The memory after all files of a kit are loaded, in any order.
///
/// limits the same parameter or point with different contents in two files is a problem: what
///        the control holds would then depend on the order of loading
pub fn merge(memories: Vec<FanucMemory>) -> Result<FanucMemory, Problems> {
    let mut all = FanucMemory::default();
    let mut problems = Problems::none();
    for memory in memories {
        for (key, value) in memory.parameters {
            if all
                .parameters
                .insert(key, value)
                .is_some_and(|old| old != value)
            {
                problems.push(two_files(&key.to_string()));
            }
        }
        for (point, value) in memory.points {
            if all
                .points
                .insert(point, value)
                .is_some_and(|old| old != value)
            {
                problems.push(two_files(&format!("point {point}")));
            }
        }
    }
    problems.or_ok(all)
}

fn two_files(what: &str) -> Problem {
    Problem::new(format!("{what} has different contents in two files"))
        .help("the control would keep whichever is loaded last; write it in one file only")
}

/// What the number of a block addresses.
enum Target {
    Point(u32),
    Parameter(u32),
}

struct Reader<'a> {
    source: &'a Source,
    facts: &'a FanucFacts,
    writer: Writer,
    memory: FanucMemory,
    spindles: Vec<String>,
    problems: Problems,
    /// Between a G code and `G11`; named once, not once for each of its blocks.
    in_program: bool,
}

impl Reader<'_> {
    fn values(&self) -> usize {
        self.memory.parameters.len() + self.memory.points.len() + self.spindles.len()
    }

    fn read_block(&mut self, span: &Span) {
        let text = self.source.slice(span).trim().to_ascii_uppercase();
        if self.in_program {
            self.in_program = text != "G11";
            return;
        }
        self.in_program = text.starts_with('G') && text != "G11";
        if let Err(problem) = self.store(span) {
            self.problems.push(problem);
        }
    }

    fn store(&mut self, span: &Span) -> Result<(), Problem> {
        let mut block = block::parse(self.source, span)?;
        if self.writer == Writer::Kit {
            self.refuse_others(&block)?;
        } else {
            // Another path and a spindle have parameters of their own, which correct no axis of the job.
            self.spindles.extend(self.of_spindles(&block));
            block
                .segments
                .retain(|segment| segment.other_path.is_none() && segment.spindle.is_none());
            if block.segments.is_empty() {
                return Ok(());
            }
        }
        match self.target(&block)? {
            Target::Point(point) => self.store_point(point, &block),
            Target::Parameter(number) => self.store_parameter(number, &block),
        }
    }

    /// Its values for spindles of this path, but zeros.
    fn of_spindles(&self, block: &Block) -> Vec<String> {
        let own = block.segments.iter().filter(|s| s.other_path.is_none());
        let words = own.filter_map(|segment| {
            let spindle = self.source.slice(segment.spindle.as_ref()?);
            let value = self.source.slice(&segment.value);
            let is_zero = value.bytes().all(|byte| matches!(byte, b'0' | b'.' | b'-'));
            (!is_zero).then(|| format!("{} of {spindle} = {value}", block.number))
        });
        words.collect()
    }

    fn refuse_others(&self, block: &Block) -> Result<(), Problem> {
        if let Some(span) = block.segments.iter().find_map(|s| s.spindle.as_ref()) {
            return Err(self
                .source
                .problem(span, "a spindle parameter is not ours")
                .help("compensation parameters belong to an axis (`A<n>`) or to none"));
        }
        match block.segments.iter().find_map(|s| s.other_path.as_ref()) {
            None => Ok(()),
            Some(path) => {
                let word = self.source.slice(path);
                let message = format!("`{word}` names path {}, expected path 1", &word[1..]);
                Err(self
                    .source
                    .problem(path, message)
                    .help("compensation data are written for path 1; split the file by path"))
            }
        }
    }

    fn target(&self, block: &Block) -> Result<Target, Problem> {
        let (number, offset) = (block.number, self.facts.point_offset.value);
        let large = number >= offset;
        match block.identifier {
            Some(Identifier::Point) if large => self.known_point(block),
            Some(Identifier::Point) => Err(self
                .at_number(
                    block,
                    format!("number {number} is marked as pitch data, below {offset}"),
                )
                .help(format!(
                    "point 33 is number {}; a parameter has `Q1`",
                    offset + 33
                ))),
            Some(Identifier::Parameter) if self.means_a_point(number) => Err(self
                .at_number(
                    block,
                    format!(
                        "this would address parameter {number}, not pitch point {}",
                        number - offset
                    ),
                )
                .help("pitch data carry `Q0`")),
            Some(Identifier::Parameter) => Ok(Target::Parameter(number)),
            None if large && self.facts.q_identifier.value => Err(self
                .at_number(block, format!("number {number} without `Q` is ambiguous"))
                .help(format!(
                    "`Q0` makes it point {}, `Q1` parameter {number}",
                    number - offset
                ))),
            None if large => self.known_point(block),
            None => Ok(Target::Parameter(number)),
        }
    }

    fn at_number(&self, block: &Block, message: String) -> Problem {
        self.source.problem(&block.number_span, message)
    }

    /// A `Q1` number in the space of the points that no known parameter has.
    fn means_a_point(&self, number: u32) -> bool {
        if self.writer != Writer::Kit {
            return false;
        }
        let facts = self.facts;
        let sets = facts.straightness_sets.value;
        let known = [
            facts.straightness_magnification_parameter.value,
            facts.straightness_start_parameter.value,
        ];
        let largest = self
            .point_blocks()
            .map(|block| block.last)
            .max()
            .unwrap_or(0);
        number
            .checked_sub(facts.point_offset.value)
            .is_some_and(|point| point <= largest)
            && !known
                .iter()
                .any(|first| (*first..*first + sets).contains(&number))
    }

    fn point_blocks(&self) -> impl Iterator<Item = NumberRange> {
        let facts = self.facts;
        [
            &facts.pitch_points,
            &facts.minus_points,
            &facts.straightness_points,
        ]
        .into_iter()
        .flat_map(|fact| fact.value.iter().copied())
    }

    fn known_point(&self, block: &Block) -> Result<Target, Problem> {
        let point = block.number - self.facts.point_offset.value;
        if self.point_blocks().any(|range| range.contains(point)) {
            return Ok(Target::Point(point));
        }
        Err(self
            .at_number(block, format!("this control has no point {point}"))
            .help("compare the number with the point numbers of the controller profile"))
    }

    fn store_point(&mut self, point: u32, block: &Block) -> Result<(), Problem> {
        let [segment] = block.segments.as_slice() else {
            return Err(self.at_number(block, format!("point {point} has more than one value")));
        };
        let value = self.point_value(point, segment)?;
        match self.memory.points.insert(point, value) {
            Some(old) if old != value => Err(self
                .at_number(
                    block,
                    format!("point {point} is {value} here and {old} in an earlier block"),
                )
                .help("two axes may share numbers by mistake; write each point once")),
            _ => Ok(()),
        }
    }

    fn point_value(&self, point: u32, segment: &Segment) -> Result<i32, Problem> {
        let text = self.source.slice(&segment.value);
        let at = |message: String| self.source.problem(&segment.value, message);
        if segment.axis.is_some() || segment.letter != 'P' {
            return Err(at(format!(
                "point {point} takes a plain `P` value, without axis or unit"
            ))
            .help("a point belongs to the axis whose 3621 to 3622 hold its number"));
        }
        if text.contains('.') {
            return Err(at(format!(
                "point {point} has the value `{text}`, expected a whole number"
            ))
            .help("pitch data count detection units"));
        }
        text.parse()
            .ok()
            .filter(|value| POINT_VALUES.contains(value))
            .ok_or_else(|| {
                at(format!(
                    "point {point} has the value `{text}`, expected -128 to 127"
                ))
                .help("larger steps need a larger magnification (3623) or a shorter interval")
            })
    }

    fn store_parameter(&mut self, number: u32, block: &Block) -> Result<(), Problem> {
        let mut keys = Vec::new();
        for segment in &block.segments {
            let axis = segment.axis;
            let key = ParameterKey { number, axis };
            let value = self.parameter_value(number, segment)?;
            if keys.contains(&key) {
                let message = format!("{key} has two values in one block");
                return Err(self.source.problem(&segment.value, message));
            }
            keys.push(key);
            let old = self.memory.parameters.insert(key, value);
            if let Some(old) = old.filter(|old| self.writer != Writer::Kit && *old != value) {
                return Err(self
                    .at_number(
                        block,
                        format!("{key} has another value here than in an earlier block ({old})"),
                    )
                    .help("name the files of one read-out"));
            }
        }
        Ok(())
    }

    fn parameter_value(&self, number: u32, segment: &Segment) -> Result<ParameterValue, Problem> {
        let text = self.source.slice(&segment.value);
        let at = |message: String| self.source.problem(&segment.value, message);
        let is_length = LENGTH_PARAMETERS.contains(&number) || self.writer == Writer::Kit;
        if is_length && !self.writer.may_write(segment.letter) {
            let letter = segment.letter;
            return Err(at(format!(
                "parameter {number} has the letter `{letter}`, expected `P`"
            ))
            .help("state the value in the unit of the machine, with `P`"));
        }
        if is_bit_parameter(number) {
            return bits(text).ok_or_else(|| {
                at(format!(
                    "parameter {number} has the value `{text}`, expected eight bits"
                ))
                .help("write all eight bits, bit 7 first, as in `P00000001`")
            });
        }
        whole_or_real(text).ok_or_else(|| at(format!("the value `{text}` is too large")))
    }
}

/// Bit parameters that compensation files hold (B-63950EN: 1006, 360x, 5700; 8135 on 0i).
fn is_bit_parameter(number: u32) -> bool {
    matches!(number, 1006 | 3601..=3605 | 5700 | 8135)
}

/// Exactly eight characters 0 or 1, bit 7 leftmost (B-63950EN/02 §3.3.2).
fn bits(text: &str) -> Option<ParameterValue> {
    let exact = text.len() == 8 && text.bytes().all(|c| matches!(c, b'0' | b'1'));
    let value = exact.then(|| u8::from_str_radix(text, 2).ok())?;
    value.map(ParameterValue::Bits)
}

fn whole_or_real(text: &str) -> Option<ParameterValue> {
    if text.contains('.') {
        let value: f64 = text.parse().ok()?;
        return value.is_finite().then_some(ParameterValue::Real(value));
    }
    text.parse().ok().map(ParameterValue::Integer)
}
