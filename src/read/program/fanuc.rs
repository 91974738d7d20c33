//! FANUC part programs: `%` frames the program, `O` numbers it, `(…)` is a comment.

use crate::control::controller::LengthUnit;
use crate::read::program::blocks::{Meaning, Modal, Motion, Rules};
use crate::read::program::steps::Complaint;
use crate::read::program::words::{block, lines};
use crate::read::program::{Cancelled, OwnWords, Step};

pub(super) fn read(text: &str, words: &OwnWords<'_>) -> Result<Vec<Step>, Complaint> {
    let rules = Rules {
        meaning,
        seconds: words.seconds,
        increments_need_machine: false,
        letters: words.letters,
    };
    let mut modal = Modal::default();
    let mut steps = Vec::new();
    let (mut frames, mut numbered) = (0, false);
    for (start, line) in lines(text) {
        let code = without_comments(line, start)?;
        let code = code.trim();
        // The control stores what stands before the number, or behind a second one, as another program.
        let is_number = frames == 1 && !numbered && is_number_of_program(code);
        if code == "%" {
            frames += 1;
        } else if code.is_empty() || is_number {
            numbered |= is_number;
        } else if frames == 1 && !numbered {
            let span = start..start + line.len();
            return Err(Complaint::new(
                span,
                "a block before the number of the program (`O` and four digits)",
            ));
        } else if frames == 1 {
            steps.extend(modal.block(&block(code, start)?, &rules)?);
        } else {
            let span = start..start + line.len();
            return Err(Complaint::new(
                span,
                "a block outside the two `%` of a program",
            ));
        }
    }
    if frames == 2 {
        Ok(steps)
    } else {
        let end = text.len();
        Err(Complaint::new(end..end, "a program stands between two `%`"))
    }
}

fn is_number_of_program(code: &str) -> bool {
    let digits = code.strip_prefix('O').unwrap_or("");
    digits.len() == 4 && digits.bytes().all(|byte| byte.is_ascii_digit())
}

fn without_comments(line: &str, start: usize) -> Result<String, Complaint> {
    let mut code = String::new();
    let mut depth = 0;
    for letter in line.chars() {
        match (letter, depth) {
            ('(', 0) => depth = 1,
            (')', 1) => depth = 0,
            ('(' | ')', _) => depth = 2,
            (_, 0) => code.push(letter),
            _ => {}
        }
        if depth > 1 {
            break;
        }
    }
    if depth == 0 {
        Ok(code)
    } else {
        let span = start..start + line.len();
        Err(Complaint::new(
            span,
            "the brackets of a comment do not match",
        ))
    }
}

/// B-64484EN, G-code system of a machining centre; G17, G61 and G64 (exact stop,
/// cutting) do not change where the axes go.
fn meaning(word: &str) -> Option<Meaning> {
    Some(match word {
        "G00" => Meaning::Motion(Motion::Rapid),
        "G01" => Meaning::Motion(Motion::Feed),
        "G04" => Meaning::Dwell,
        "G17" | "G61" | "G64" => Meaning::Neutral,
        "G94" => Meaning::FeedPerMinute,
        "G20" => Meaning::Unit(LengthUnit::Inch),
        "G21" => Meaning::Unit(LengthUnit::Millimetre),
        "G40" => Meaning::Cancel(Cancelled::ToolRadius),
        "G49" => Meaning::Cancel(Cancelled::ToolLength),
        "G50" => Meaning::Cancel(Cancelled::Scaling),
        "G50.1" => Meaning::CancelOfAxes(Cancelled::Mirroring),
        "G53" => Meaning::Machine,
        "G69" => Meaning::Cancel(Cancelled::Rotation),
        "G80" => Meaning::Cancel(Cancelled::Cycle),
        "G90" => Meaning::Absolute,
        "G91" => Meaning::Incremental,
        "M00" => Meaning::Stop,
        "M30" => Meaning::End,
        _ => return None,
    })
}
