//! Fanuc: parameter and pitch-data files → [`FanucMemory`], and what the control does with it.
//!
//! ```text
//!   file → record (% … %) → block (N Q A P) → point or parameter → memory ─┐ merge
//!   file → …                                                     → memory ─┴──────→ one memory
//! ```
//! Written from the control's file formats alone: B-63950EN/02 §3.3 (30i class, with `Q`),
//! B-63330EN/03 §3 (15i), operator's manual B-63534EN (four digits, no `Q`). It reads more than
//! the program writes, as a control does, and says where a control would stop or where it would
//! understand something else than was meant.

pub(super) mod block;
mod control;
#[cfg(test)]
pub(crate) mod tests;

use crate::control::control_state::ControlState;
use crate::control::controller::{ControlUnit, FanucFacts, NumberRange, Role};
use crate::control::table::Tables;
use crate::control::table::fanuc::{FanucMemory, ParameterKey, ParameterValue};
use crate::read::emulate::{Emulated, Emulator};
use crate::read::family::{Family, READ_OUT_AS_A_WHOLE, ReadBack};
use crate::read::lexer::{Complaint, MOST_COMPLAINTS, located};
use crate::read::refusals;
use crate::text::{Problems, refuse_long_lines};
use block::{Block, Segment, blocks, number, parse, record, uniform_line_ends};
use std::ops::Range;

/// What the data word of one point can hold (B-63330EN §3, B-63950EN §3.3: −128 to 127).
const POINT_VALUES: std::ops::RangeInclusive<i32> = -128..=127;
/// Values of one file that concern the compensation. A control of 32 axes has some 6000; each takes up
/// to a hundred bytes of memory.
const MOST_VALUES: usize = 100_000;
/// Complaints that are looked for; a file of another kind has the same one in each block, which is said once.
const MOST_BLOCKS: usize = 10 * MOST_COMPLAINTS;
/// Lengths that depend on the unit of the machine.
const LENGTH_PARAMETERS: [u32; 5] = [1240, 1320, 1321, 3624, 3625];
/// First and last number of the parameters that pitch, straightness and backlash need, of those that
/// tell the machine of the job from another one, and of those whose compensation is not emulated and must
/// be seen.
const OF_CONCERN: [(u32, u32); 18] = [
    (1001, 1001),
    (1006, 1006),
    (1013, 1013),
    (1020, 1020),
    (1240, 1240),
    (1320, 1321),
    (1820, 1820),
    (1851, 1852),
    (3602, 3602),
    (3605, 3605),
    (3620, 3627),
    (3666, 3671),
    (3676, 3677),
    (5711, 5788),
    (5861, 5874),
    (8135, 8135),
    (10800, 10814),
    (14985, 14988),
];

impl Family for FanucFacts {
    fn read_kit(&self, texts: &[(&str, &str)], _roles: &[Role]) -> Result<ReadBack, Problems> {
        let memories = Problems::all(texts.iter().map(|(name, text)| read(name, text, self)))?;
        Ok(Tables::Fanuc(merge(memories)?).into())
    }

    fn control(&self, tables: &Tables, state: &ControlState) -> Emulated<Box<dyn Emulator>> {
        Ok(Box::new(control::control(tables.own(), self, state)?))
    }

    /// Numbered blocks.
    fn may_obey(&self, text: &str) -> bool {
        text.split(['\n', '\r']).any(|line| number(line).is_some())
    }

    fn is_whole(&self, text: &str) -> bool {
        let blocks = text.split('\n').filter_map(number);
        let others = blocks.filter(|block| !concerns(*block, self));
        others.count() > READ_OUT_AS_A_WHOLE
    }
}

/// Whether the number of a block, with what follows it, is of concern to the compensation.
fn concerns((number, rest): (u32, &str), facts: &FanucFacts) -> bool {
    let mut identifier = rest.chars().filter(|c| !c.is_whitespace());
    let identifier = (identifier.next(), identifier.next());
    let is_parameter = match identifier {
        (Some('Q' | 'q'), Some('0')) => false,
        (Some('Q' | 'q'), Some('1')) => true,
        _ => number < facts.point_offset.value,
    };
    !is_parameter
        || OF_CONCERN.iter().any(|(a, b)| (*a..=*b).contains(&number))
        || facts.is_of_per_point_set(number)
}

/// Reads one file of a kit, of `N…P…` blocks: parameters, pitch points, or both.
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

/// Reads a file that a control wrote of itself; as [`read`], but blocks of no concern are ignored, a
/// parameter in the number space of the points, such as 10800, is what it says it is, and `M` or `I` before
/// a length are taken where they are the control's `unit` (B-63950EN/02 §3.3.2).
pub fn read_out(
    file_name: &str,
    text: &str,
    facts: &FanucFacts,
    unit: ControlUnit,
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
    /// How many blocks of no concern were ignored.
    pub passed_over: usize,
}

/// Who wrote a file.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Writer {
    /// A program or a person: `Q1` before the number of a point is a mistake.
    Kit,
    /// The control, which counts in this unit.
    Control(ControlUnit),
}

impl Writer {
    /// Whether a length behind this letter is in the unit of the control.
    fn may_write(self, letter: char) -> bool {
        match letter {
            'M' => self == Writer::Control(ControlUnit::Millimetre),
            'I' => self == Writer::Control(ControlUnit::Inch),
            _ => true, // P, in either
        }
    }
}

fn read_from(
    writer: Writer,
    file_name: &str,
    text: &str,
    facts: &FanucFacts,
) -> Result<ReadOut, Problems> {
    let text = uniform_line_ends(text);
    refuse_long_lines(file_name, &text)?;
    let mut complaints = Vec::new();
    let record = record(&text, writer == Writer::Kit, &mut complaints);
    let mut reader = Reader { text: &text, facts, writer, found: ReadOut::default() };
    // Between a G code and `G11`; named once, not once for each of its blocks.
    let mut in_program = false;
    for span in blocks(&text, record) {
        if complaints.len() >= MOST_BLOCKS {
            break;
        }
        if reader.values() > MOST_VALUES {
            complaints.push(Complaint::new(span, refusals::many_values(MOST_VALUES)));
            break;
        }
        let block = text[span.clone()].trim();
        if in_program {
            in_program = !block.eq_ignore_ascii_case("G11");
            continue;
        }
        in_program = block.starts_with(['G', 'g']) && !block.eq_ignore_ascii_case("G11");
        complaints.extend(reader.read_block(span).err());
    }
    let found = reader.found;
    located(file_name, &text, complaints).or_ok(found)
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
            if all.parameters.insert(key, value).is_some_and(|old| old != value) {
                problems.push(refusals::two_files(key));
            }
        }
        for (point, value) in memory.points {
            if all.points.insert(point, value).is_some_and(|old| old != value) {
                problems.push(refusals::two_files(format!("point {point}")));
            }
        }
    }
    problems.or_ok(all)
}

struct Reader<'a> {
    text: &'a str,
    facts: &'a FanucFacts,
    writer: Writer,
    found: ReadOut,
}

impl Reader<'_> {
    fn values(&self) -> usize {
        let ReadOut { memory, spindles, .. } = &self.found;
        memory.parameters.len() + memory.points.len() + spindles.len()
    }

    fn read_block(&mut self, span: Range<usize>) -> Result<(), Complaint> {
        if self.is_passed_over(&self.text[span.clone()]) {
            self.found.passed_over += 1;
            return Ok(());
        }
        let mut block = parse(self.text, span)?;
        if self.writer == Writer::Kit {
            self.refuse_others(&block)?;
        } else {
            let spindles = self.of_spindles(&block);
            self.found.spindles.extend(spindles);
        }
        // Another path and a spindle have parameters of their own, which correct no axis of the job.
        block.segments.retain(|segment| segment.other_path.is_none() && segment.spindle.is_none());
        if block.segments.is_empty() {
            return Ok(());
        }
        if self.is_point(&block)? { self.store_point(&block) } else { self.store_parameter(&block) }
    }

    /// Of a control's file what is of no concern; what no line feed ends may hold other blocks.
    fn is_passed_over(&self, block: &str) -> bool {
        let is_one = || !block.contains(['\r', ';']);
        let is_other = || number(block).is_some_and(|block| !concerns(block, self.facts));
        self.writer != Writer::Kit && is_one() && is_other()
    }

    /// Its values for spindles of this path, but zeros.
    fn of_spindles(&self, block: &Block) -> Vec<String> {
        let own = block.segments.iter().filter(|s| s.other_path.is_none());
        let words = own.filter_map(|segment| {
            let spindle = &self.text[segment.spindle.clone()?];
            let value = &self.text[segment.value.clone()];
            (!self.is_zero(segment)).then(|| format!("{} of {spindle} = {value}", block.number))
        });
        words.collect()
    }

    fn is_zero(&self, segment: &Segment) -> bool {
        let mut value = self.text[segment.value.clone()].bytes();
        value.all(|byte| matches!(byte, b'0' | b'.' | b'-'))
    }

    /// A control writes zeros for each path that it reserves.
    fn refuse_others(&self, block: &Block) -> Result<(), Complaint> {
        if let Some(span) = block.segments.iter().find_map(|s| s.spindle.clone()) {
            return Err(Complaint::new(span, refusals::of_spindle()));
        }
        let mut used = block.segments.iter().filter(|segment| !self.is_zero(segment));
        match used.find_map(|segment| segment.other_path.clone()) {
            None => Ok(()),
            Some(span) => {
                let word = &self.text[span.clone()];
                Err(Complaint::new(span, refusals::other_path(word, &word[1..])))
            }
        }
    }

    /// Whether the number of a block addresses a point, else a parameter.
    fn is_point(&self, block: &Block) -> Result<bool, Complaint> {
        let (number, offset) = (block.number, self.facts.point_offset.value);
        let wrong = match (block.is_point, number.checked_sub(offset)) {
            (Some(true), None) => refusals::below_points(number, offset, offset + 33),
            (Some(false), Some(point)) if self.means_a_point(number, point) => {
                refusals::means_parameter(number, point)
            }
            (None, Some(point)) if self.facts.q_identifier.value => {
                refusals::without_identifier(number, point)
            }
            (Some(true) | None, Some(point)) => {
                if self.point_blocks().any(|range| range.contains(point)) {
                    return Ok(true);
                }
                refusals::no_such_point(point)
            }
            (Some(false) | None, _) => return Ok(false),
        };
        Err(Complaint::new(block.number_span.clone(), wrong))
    }

    /// A `Q1` number in the space of the points that no known parameter has.
    fn means_a_point(&self, number: u32, point: u32) -> bool {
        let largest = self.point_blocks().map(|block| block.last).max();
        self.writer == Writer::Kit
            && point <= largest.unwrap_or(0)
            && !self.facts.is_of_per_point_set(number)
    }

    fn point_blocks(&self) -> impl Iterator<Item = NumberRange> {
        let facts = self.facts;
        [&facts.pitch_points, &facts.minus_points, &facts.straightness_points]
            .into_iter()
            .flat_map(|fact| fact.value.iter().copied())
    }

    fn store_point(&mut self, block: &Block) -> Result<(), Complaint> {
        let point = block.number - self.facts.point_offset.value;
        let at_number = |wrong| Err(Complaint::new(block.number_span.clone(), wrong));
        let [segment] = block.segments.as_slice() else {
            return at_number(refusals::several_values(point));
        };
        let value = self.point_value(point, segment)?;
        match self.found.memory.points.insert(point, value) {
            Some(old) if old != value => at_number(refusals::point_twice(point, value, old)),
            _ => Ok(()),
        }
    }

    fn point_value(&self, point: u32, segment: &Segment) -> Result<i32, Complaint> {
        let text = &self.text[segment.value.clone()];
        let wrong = if segment.axis.is_some() || segment.letter != 'P' {
            refusals::no_plain_value(point)
        } else if text.contains('.') {
            refusals::no_whole_value(point, text)
        } else {
            match text.parse() {
                Ok(value) if POINT_VALUES.contains(&value) => return Ok(value),
                _ => refusals::large_value(point, text),
            }
        };
        Err(Complaint::new(segment.value.clone(), wrong))
    }

    fn store_parameter(&mut self, block: &Block) -> Result<(), Complaint> {
        let number = block.number;
        let mut keys = Vec::new();
        for segment in &block.segments {
            let axis = segment.axis;
            let key = ParameterKey { number, axis };
            let value = self.parameter_value(number, segment)?;
            if keys.contains(&key) {
                return Err(Complaint::new(segment.value.clone(), refusals::two_values(key)));
            }
            keys.push(key);
            let old = self.found.memory.parameters.insert(key, value);
            if let Some(old) = old.filter(|old| self.writer != Writer::Kit && *old != value) {
                let wrong = refusals::other_value(key, old);
                return Err(Complaint::new(block.number_span.clone(), wrong));
            }
        }
        Ok(())
    }

    fn parameter_value(&self, number: u32, segment: &Segment) -> Result<ParameterValue, Complaint> {
        let text = &self.text[segment.value.clone()];
        let refuse = |wrong| Err(Complaint::new(segment.value.clone(), wrong));
        let is_length = LENGTH_PARAMETERS.contains(&number) || self.writer == Writer::Kit;
        if is_length && !self.writer.may_write(segment.letter) {
            return refuse(refusals::other_letter(number, segment.letter));
        }
        // Bit parameters of concern (B-63950EN: 1001, 1006, 1013, 360x, 5700; 8135 on 0i).
        let is_bits = matches!(number, 1001 | 1006 | 1013 | 3601..=3605 | 5700 | 8135);
        let value = if is_bits { bits(text) } else { whole_or_real(text) };
        match value {
            Some(value) => Ok(value),
            None if is_bits => refuse(refusals::no_bits(number, text)),
            None => refuse(refusals::too_large(text)),
        }
    }
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
