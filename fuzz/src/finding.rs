//! Cases that went wrong, in `fuzz/found/`: the input as `TARGET-HASH.case`, what went wrong beside it as `.txt`.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Something wrong on a target.
pub struct Finding<'a> {
    /// The target.
    pub target: &'a str,
    /// What went wrong.
    pub wrong: String,
}

/// How many bytes run to make a case smaller, in 400 runs at most, and how long: slow cases take seconds each.
const TRIED: usize = 16 << 20;
const LONGEST: Duration = Duration::from_secs(30);

/// Where findings are kept.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("found")
}

impl Finding<'_> {
    /// The same for all cases that go wrong in the same way: the words without figures and quoted parts.
    fn name(&self) -> String {
        let words: Vec<&str> = self.wrong.split(['"', '`']).step_by(2).collect();
        let letters: String =
            words.concat().chars().filter(|c| !c.is_ascii_digit()).take(120).collect();
        let place: String = self.wrong.split(": ").next().unwrap_or_default().to_string();
        let is_panic = self.wrong.starts_with("panic at") && !place.contains("/kits.rs");
        let key = match self.wrong.contains("control character") {
            true => "control character".to_string(),
            false if is_panic => place,
            false => letters,
        };
        format!("{}-{:08x}", self.target, hash(key.as_bytes()) & 0xffff_ffff)
    }

    /// Whether it is new, or smaller than what is known.
    pub fn is_wanted(&self, input: &[u8]) -> bool {
        let known = fs::metadata(folder().join(format!("{}.case", self.name())));
        known.is_ok_and(|known| known.len() <= input.len() as u64).eq(&false)
    }

    /// The input without parts that do not matter: halves, quarters, … that can be left out.
    pub fn smallest(
        &self,
        input: &[u8],
        mut again: impl FnMut(&[u8]) -> Option<String>,
    ) -> Vec<u8> {
        let mut small = input.to_vec();
        let mut part = small.len() / 2;
        let mut left = TRIED;
        let begun = Instant::now();
        let goes_on = |left: usize| left > 0 && begun.elapsed() < LONGEST;
        while part > 0 && goes_on(left) {
            let mut at = 0;
            while at < small.len() && goes_on(left) {
                let mut shorter = small.clone();
                shorter.drain(at..(at + part).min(small.len()));
                left = left.saturating_sub(shorter.len().max(TRIED / 400));
                let same = again(&shorter).is_some_and(|wrong| {
                    Finding { target: self.target, wrong }.name() == self.name()
                });
                match same {
                    true => small = shorter,
                    false => at += part,
                }
            }
            part /= 2;
        }
        small
    }

    /// Writes it down, and notes it for the run.
    pub fn write(&self, place: &Path, input: &[u8]) {
        let path = folder().join(self.name());
        let _ = fs::create_dir_all(folder());
        let _ = fs::write(path.with_extension("case"), input);
        let _ = fs::write(path.with_extension("txt"), format!("{}\n", self.wrong));
        let notes = fs::read_to_string(place.join("findings")).unwrap_or_default();
        let note = format!("{} {}\n", self.target, self.name());
        if !notes.contains(&note) {
            let _ = fs::write(place.join("findings"), notes + &note);
            eprintln!(
                "found: {}.case: {}",
                path.display(),
                self.wrong.lines().next().unwrap_or_default()
            );
        }
    }
}

/// A number for a text, the same on every machine (FNV-1a).
pub fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |sum, byte| {
        (sum ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    })
}
