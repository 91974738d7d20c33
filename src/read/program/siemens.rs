//! SINUMERIK part programs: `;` begins a comment, `MSG("…")` is a text for the screen.

use crate::control::controller::LengthUnit;
use crate::read::program::blocks::{Meaning, Modal, Motion, Rules};
use crate::read::program::steps::Complaint;
use crate::read::program::words::{block, lines};
use crate::read::program::{Cancelled, OwnWords, Step};

pub(super) fn read(text: &str, words: &OwnWords<'_>) -> Result<Vec<Step>, Complaint> {
    let rules = Rules {
        meaning,
        seconds: words.seconds,
        increments_need_machine: true,
        letters: words.letters,
    };
    let mut modal = Modal::default();
    let mut steps = Vec::new();
    for (start, line) in lines(text) {
        let line = line.trim_end();
        if is_message(line) {
            continue;
        }
        let code = line.split(';').next().unwrap_or("");
        steps.extend(modal.block(&block(code, start)?, &rules)?);
    }
    Ok(steps)
}

/// `MSG("text")` shows a text, `MSG()` takes it away; nothing moves.
fn is_message(line: &str) -> bool {
    let Some(inside) = line
        .strip_prefix("MSG(")
        .and_then(|rest| rest.strip_suffix(')'))
    else {
        return false;
    };
    let text = inside
        .strip_prefix('"')
        .and_then(|rest| rest.strip_suffix('"'));
    inside.is_empty() || text.is_some_and(|text| !text.contains('"'))
}

/// Programming Manual; G17 and G60 (exact stop) do not change where the axes go.
fn meaning(word: &str) -> Option<Meaning> {
    Some(match word {
        "G0" => Meaning::Motion(Motion::Rapid),
        "G1" => Meaning::Motion(Motion::Feed),
        "G4" => Meaning::Dwell,
        "G17" | "G60" => Meaning::Neutral,
        "G94" => Meaning::FeedPerMinute,
        "G40" => Meaning::Cancel(Cancelled::ToolRadius),
        "D0" => Meaning::Cancel(Cancelled::ToolLength),
        "G500" => Meaning::Cancel(Cancelled::Offset),
        "TRANS" => Meaning::Cancel(Cancelled::Shift),
        "ROT" => Meaning::Cancel(Cancelled::Rotation),
        "SCALE" => Meaning::Cancel(Cancelled::Scaling),
        "MIRROR" => Meaning::Cancel(Cancelled::Mirroring),
        "TRAFOOF" => Meaning::Cancel(Cancelled::Transformation),
        "G90" => Meaning::Absolute,
        "G91" => Meaning::Incremental,
        "G700" => Meaning::Unit(LengthUnit::Inch),
        "G710" => Meaning::Unit(LengthUnit::Millimetre),
        "SUPA" => Meaning::Machine,
        "M0" => Meaning::Stop,
        "M30" => Meaning::End,
        _ => return None,
    })
}
