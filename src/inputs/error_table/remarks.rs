//! What a table says of itself: comment lines of a fixed form, so that a table which was
//! separated once does not lose its warnings on the way into a kit.
//!
//! ```text
//!   # doubt: why the values should not be trusted as they stand
//!   # not determined: EXX: why this term has no values
//!   # reversal not held: 9.146 um along the diagonals
//!   # degrees of freedom: 3
//!   # not stated: angle_urad, setup_ppm
//!   # neglected by decision: angle_urad
//!   # largest error (95 %), um, zero at X 0 +, Y 0 +, Z 0 +: all 3.91, EXX 1.032, …, PPP 2.5, …
//!   # as measured at most so much more (95 %), um, zero at X 0 +, Y 0 +, Z 0 +: all 1.8, EXX 0.721, …, PPP 1.1, …
//!   # u of what another measurement does not repeat, um: EXX 0.44, …
//!   # u of what another measurement with the same laser does not repeat, um: 0815: EXX 0.4, …
//!   # doubtful beside that, um: EXX 0.5, PPP 0.8
//!   # frame: x-primary
//!   # on the lines X, Y, Z, mm: 450, 360, 360
//!   # note: what whoever uses the values has to know
//! ```
//! Any other comment is free text and means nothing to the program.

use crate::inputs::findings::Remark;
use crate::inputs::job::Frame;
use crate::quantity::{Diagonal, ErrorTerm, Millimetres, PerAxis, PerDiagonal, PerTerm, smaller};
use crate::text::{Finding, Word, bounded, joined, once, words};
use serde::Serialize;
use std::fmt;

words! {
    /// How a remark begins.
    enum Key {
        Doubt = "doubt:",
        Unknown = "not determined:",
        Reversal = "reversal not held:",
        Freedom = "degrees of freedom:",
        NotStated = "not stated:",
        Largest = "largest error (95 %), um, zero at",
        Measured = "as measured at most so much more (95 %), um, zero at",
        Anew = "u of what another measurement does not repeat, um:",
        SameLaser = "u of what another measurement with the same laser does not repeat, um:",
        Doubtful = "doubtful beside that, um:",
        Neglected = "neglected by decision:",
        Frame = "frame:",
        Lines = "on the lines X, Y, Z, mm:",
        Note = "note:",
    }
}

/// Remarks of one kind that are kept: a screen shows five of them.
const MOST_REMARKS: usize = 1000;

/// How many were too many.
fn beyond<T>(remarks: &mut Vec<T>) -> usize {
    let more = remarks.len().saturating_sub(MOST_REMARKS);
    remarks.truncate(MOST_REMARKS);
    more
}

/// The words by which a simulation is told from a measurement: a note of the table begins so.
pub const SIMULATED: &str = "SIMULATED, not measured";

words! {
    /// A cause of uncertainty that the readings of a separation cannot show, each with the key of the job that states
    /// it, the usual largest first: who is silent about it gets no pass.
    pub enum Cause {
        /// Pitch, yaw and roll without a measurement.
        Angles = "angle_urad",
        /// A change of scale from one set-up to the next.
        SetUps = "setup_ppm",
        /// The slopes of linear axes and other beams.
        Slopes = "u_um_per_m",
        /// The tilt of a mirror whose set-up is assumed perfect.
        Tilt = "tilt_arcsec",
        /// The squareness of axes whose straightness has no slope that could hold it.
        Squareness = "squareness_um_per_m",
    }
}

impl Cause {
    fn listed(words: &str) -> Vec<Cause> {
        let keys: Vec<&str> = words.split(',').map(str::trim).collect();
        let known = Cause::WORDS.iter().filter(|(key, _)| keys.contains(key));
        known.map(|(_, cause)| *cause).collect()
    }
}

/// What a job leaves unsaid of a separation, or says to be nothing.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Silence {
    /// Neither stated nor measured: a verdict on these errors is at most undecided.
    pub not_stated: Vec<Cause>,
    /// Stated to be zero without a measurement.
    pub neglected: Vec<Cause>,
}

impl Silence {
    /// One comment for each of which there is anything.
    fn lines(&self) -> impl Iterator<Item = String> {
        let all = [(Key::NotStated, &self.not_stated), (Key::Neglected, &self.neglected)];
        let any = all.into_iter().filter(|(_, causes)| !causes.is_empty());
        any.map(|(key, causes)| format!("{} {}", key.word(), keys(causes)))
    }

    /// One sentence for each, for the lines beside a result.
    pub fn sentences(&self) -> Vec<String> {
        let open = "; a verdict on these errors is at most undecided";
        let of =
            |line: String| if line.starts_with(Key::NotStated.word()) { line + open } else { line };
        self.lines().map(of).collect()
    }
}

/// The largest |value| of each term, µm, and max − min along each body diagonal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sizes {
    /// By term; 0 where there is none.
    pub terms: PerTerm<f64>,
    /// By diagonal.
    pub diagonals: PerDiagonal<f64>,
}

impl Sizes {
    /// Both, one by one.
    pub(crate) fn joined(&self, other: &Sizes, of: impl Fn(f64, f64) -> f64) -> Sizes {
        Sizes {
            terms: PerTerm::from_fn(|term| of(self.terms[term], other.terms[term])),
            diagonals: PerDiagonal::from_fn(|d| of(self.diagonals[d], other.diagonals[d])),
        }
    }

    /// The largest of a term.
    pub(crate) fn all_um(&self) -> f64 {
        self.terms.iter().map(|(_, um)| *um).fold(0.0, f64::max)
    }

    /// The term with it.
    pub(crate) fn worst(&self) -> ErrorTerm {
        let all = self.terms.iter().max_by(|a, b| a.1.total_cmp(b.1));
        all.map_or(ErrorTerm::ALL[0], |(term, _)| term)
    }

    /// The largest of a diagonal.
    pub(crate) fn ranges_um(&self) -> f64 {
        self.diagonals.iter().map(|(_, um)| *um).fold(0.0, f64::max)
    }

    /// As the comment of a table has them.
    fn text(&self) -> String {
        joined(self.words())
    }

    /// Those that are more than nothing.
    fn words(&self) -> impl Iterator<Item = String> {
        let terms = self.terms.iter().map(|(term, um)| (term.to_string(), *um));
        let diagonals = self.diagonals.iter().map(|(d, um)| (d.to_string(), *um));
        let all = terms.chain(diagonals).filter(|(_, um)| *um > 0.0);
        all.map(|(name, um)| format!("{name} {um:.4}"))
    }

    /// The one of this name.
    fn named(&mut self, name: &str) -> Option<&mut f64> {
        if let Some(term) = ErrorTerm::from_name(name) {
            return Some(&mut self.terms[term]);
        }
        let diagonal = Diagonal::ALL.into_iter().find(|d| d.name() == name)?;
        Some(&mut self.diagonals[diagonal])
    }
}

/// A figure of this name.
type FigureOf<T> = for<'a> fn(&'a mut T, &str) -> Option<&'a mut f64>;

/// What is `named` by its names and sizes; `None` where a name or a size is none.
fn sized<T: Default>(words: &str, named: FigureOf<T>) -> Option<T> {
    let mut found = T::default();
    for pair in words.split(',') {
        let (name, um) = pair.trim().split_once(' ')?;
        let um: f64 = um.trim().parse().ok()?;
        *named(&mut found, name)? = Some(um).filter(|um| um.is_finite() && *um >= 0.0)?;
    }
    Some(found)
}

/// How far the largest of the errors may lie off, drawn together, with 95 %, µm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LargestErrors {
    /// The references where the errors are zero; of a job with others it says nothing.
    pub zero: String,
    /// Of all values of all terms.
    pub all_um: f64,
    /// Of max − min along any body diagonal.
    pub ranges_um: f64,
    /// Of all values of a term, of max − min along a diagonal.
    pub single: Sizes,
}

impl LargestErrors {
    /// Both, one by one.
    pub(crate) fn joined(&self, other: &LargestErrors, of: impl Fn(f64, f64) -> f64) -> Self {
        LargestErrors {
            zero: self.zero.clone(),
            all_um: of(self.all_um, other.all_um),
            ranges_um: of(self.ranges_um, other.ranges_um),
            single: self.single.joined(&other.single, of),
        }
    }

    fn read(words: &str) -> Option<LargestErrors> {
        let (zero, rest) = words.split_once(':')?;
        Some(LargestErrors { zero: zero.trim().to_string(), ..sized(rest, LargestErrors::named)? })
    }

    /// As the comment of a table has them.
    fn text(&self) -> String {
        let both = [("all", self.all_um), ("ranges", self.ranges_um)];
        let both = both.into_iter().map(|(name, um)| format!("{name} {um:.4}"));
        format!("{}: {}", self.zero, joined(both.chain(self.single.words())))
    }

    /// The one of this name.
    fn named(&mut self, name: &str) -> Option<&mut f64> {
        match name {
            "all" => Some(&mut self.all_um),
            "ranges" => Some(&mut self.ranges_um),
            name => self.single.named(name),
        }
    }
}

/// The remarks of a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Remarks {
    /// Why the values are doubtful: a verdict that rests on them is at most undecided.
    pub doubts: Vec<Finding>,
    /// Terms that the measurement was to give and did not, with the reason.
    pub not_determined: Vec<(ErrorTerm, String)>,
    /// Reversal along the body diagonals that the readings show and the curves do not hold, µm:
    /// it could not be told apart by axis.
    pub hidden_reversal_um: Option<f64>,
    /// Degrees of freedom of the estimate behind the `u_…` columns; `None` = as good as known.
    pub degrees_of_freedom: Option<f64>,
    /// What the job of a separation leaves unsaid.
    pub silence: Silence,
    /// The largest errors of a separation.
    pub largest: Option<LargestErrors>,
    /// How far its errors as measured may lie beyond the largest of them.
    pub measured: Option<LargestErrors>,
    /// Their largest u by what another measurement does not repeat, µm; `None` = it repeats nothing.
    pub anew: Option<Sizes>,
    /// Serial number of the laser, and the same where another measurement is made with it.
    pub same_laser: Option<(String, Sizes)>,
    /// How far what speaks against a separation may move its errors, beside their uncertainty, µm.
    pub doubtful: Option<Sizes>,
    /// Frame in which a separation gave the slopes of the cross terms; `None` = they are as given.
    pub frame: Option<Frame>,
    /// The lines whose errors these are, where the effects of angles were taken off: there the angles are zero.
    pub lines: Option<PerAxis<Millimetres>>,
    /// What whoever uses the values has to know.
    pub notes: Vec<Finding>,
}

impl Remarks {
    /// The remarks in the comments of a table, equal ones once; text that is none of them stays a comment.
    ///
    /// limits [`MOST_REMARKS`] of a kind, each of up to 1000 characters; the rest is counted
    pub fn read(table: &str) -> Remarks {
        let mut remarks = Remarks::default();
        let comments = table.lines().filter_map(|line| line.trim_start().strip_prefix('#'));
        // A program for tables fills a line up with separators.
        let comments = comments.map(|comment| comment.trim_end_matches([',', ';', ' ']).trim());
        for comment in once(comments.collect()) {
            remarks.hear(comment);
        }
        let doubts = beyond(&mut remarks.not_determined) + beyond(&mut remarks.doubts);
        let more = (doubts > 0).then(|| Finding::from(Remark::MoreDoubts { count: doubts }));
        remarks.doubts.extend(more);
        let notes = beyond(&mut remarks.notes);
        let more = (notes > 0).then(|| Finding::from(Remark::MoreNotes { count: notes }));
        remarks.notes.extend(more);
        remarks
    }

    /// The notes that say that the values were simulated.
    pub fn simulated(&self) -> impl Iterator<Item = &Finding> {
        self.notes.iter().filter(|note| is_simulated(note))
    }

    /// Largest u of each error by what the other measurement of this machine does not repeat, µm; `None` = it repeats
    /// nothing.
    pub(crate) fn anew_beside(&self, other: &Remarks) -> Option<&Sizes> {
        let others = other.same_laser.as_ref().map(|(serial, _)| serial);
        let same = self.same_laser.as_ref().filter(|(serial, _)| others == Some(serial));
        match (self.anew.is_some() == other.anew.is_some(), same) {
            (true, Some((_, sizes))) => Some(sizes),
            _ => self.anew.as_ref().filter(|_| other.anew.is_some()),
        }
    }

    /// Adds the remarks of another table of the same machine; of two hidden reversals the larger,
    /// of two degrees of freedom the fewer.
    pub(super) fn extend(&mut self, other: Remarks) {
        self.doubts.extend(other.doubts);
        self.not_determined.extend(other.not_determined);
        self.notes.extend(other.notes);
        if let (Some(first), Some(second)) = (self.frame, other.frame)
            && first != second
        {
            self.doubts.push(Remark::OtherFrames { first, second }.into());
        }
        self.frame = self.frame.or(other.frame);
        self.lines = self.lines.or(other.lines);
        self.hidden_reversal_um =
            of_both(self.hidden_reversal_um, other.hidden_reversal_um, f64::max);
        self.degrees_of_freedom =
            of_both(self.degrees_of_freedom, other.degrees_of_freedom, smaller);
        join(&mut self.silence.not_stated, other.silence.not_stated);
        join(&mut self.silence.neglected, other.silence.neglected);
        (self.largest, self.measured) = (None, None); // of each table by itself
        (self.anew, self.same_laser) = (None, None);
        let larger = |a: Sizes, b: Sizes| a.joined(&b, f64::max);
        self.doubtful = of_both(self.doubtful.take(), other.doubtful, larger);
    }

    fn hear(&mut self, comment: &str) {
        let mut known = Key::WORDS.iter();
        let own = known.find_map(|(begins, key)| Some((*key, comment.strip_prefix(begins)?)));
        let Some((key, words)) = own else { return };
        let words = bounded(words.trim().to_string());
        let doubtful = |words: String| Finding::from(Remark::Doubtful { words });
        match key {
            Key::Doubt => self.doubts.push(doubtful(words)),
            Key::Note => self.notes.push(note(words)),
            Key::Largest => self.largest = LargestErrors::read(&words),
            Key::Measured => self.measured = LargestErrors::read(&words),
            Key::Anew => self.anew = sized(&words, Sizes::named),
            Key::SameLaser => {
                let of = |(serial, words)| {
                    Some((str::trim(serial).to_string(), sized(words, Sizes::named)?))
                };
                self.same_laser = words.rsplit_once(':').and_then(of);
            }
            Key::Doubtful => match sized(&words, Sizes::named) {
                Some(sizes) => self.doubtful = Some(sizes),
                None => self.doubts.push(doubtful(comment.to_string())),
            },
            Key::Frame => {
                let known = Frame::WORDS.iter().find(|(word, _)| *word == words);
                self.frame = self.frame.or(known.map(|(_, frame)| *frame));
            }
            Key::Lines => {
                let places =
                    words.split(',').map(|mm| mm.trim().parse().ok().map(Millimetres::new));
                match places.collect::<Option<Vec<Millimetres>>>().as_deref() {
                    Some(&[x, y, z]) => self.lines = Some(PerAxis { x, y, z }),
                    _ => self.doubts.push(doubtful(comment.to_string())),
                }
            }
            Key::NotStated => {
                let causes = Cause::listed(&words);
                if causes.len() < words.split(',').count() {
                    self.doubts.push(doubtful(comment.to_string()));
                }
                join(&mut self.silence.not_stated, causes);
            }
            Key::Neglected => join(&mut self.silence.neglected, Cause::listed(&words)),
            Key::Reversal => {
                let um: Option<f64> =
                    words.split_whitespace().next().and_then(|um| um.parse().ok());
                self.hidden_reversal_um =
                    um.filter(|um| um.is_finite()).or(self.hidden_reversal_um);
            }
            Key::Freedom => {
                let freedom = words.parse().ok().filter(|freedom: &f64| *freedom >= 1.0);
                self.degrees_of_freedom = of_both(freedom, self.degrees_of_freedom, smaller);
            }
            Key::Unknown => {
                let (term, reason) = words.split_once(':').unwrap_or((&words, ""));
                match ErrorTerm::from_name(term.trim()) {
                    Some(term) => self.not_determined.push((term, reason.trim().to_string())),
                    None => self.notes.push(note(format!("{} {words}", key.word()))),
                }
            }
        }
    }

    /// The comment lines that read back to these remarks, without their `#`.
    pub fn lines(&self) -> Vec<String> {
        let missing = self.not_determined.iter().map(|(term, why)| format!("{term}: {why}"));
        let reversal = self.hidden_reversal_um.map(|um| format!("{um:.3} um along the diagonals"));
        let same_laser = self.same_laser.as_ref();
        let same_laser = same_laser.map(|(serial, sizes)| format!("{serial}: {}", sizes.text()));
        let places = self.lines.map(|at| joined(at.iter().map(|(_, place)| place.mm())));
        let mut lines = Vec::new();
        tell(&mut lines, Key::Doubt, &self.doubts);
        tell(&mut lines, Key::Unknown, missing);
        tell(&mut lines, Key::Reversal, reversal);
        tell(&mut lines, Key::Freedom, self.degrees_of_freedom);
        lines.extend(self.silence.lines());
        tell(&mut lines, Key::Largest, self.largest.as_ref().map(LargestErrors::text));
        tell(&mut lines, Key::Measured, self.measured.as_ref().map(LargestErrors::text));
        tell(&mut lines, Key::Anew, self.anew.as_ref().map(Sizes::text));
        tell(&mut lines, Key::SameLaser, same_laser);
        tell(&mut lines, Key::Doubtful, self.doubtful.as_ref().map(Sizes::text));
        tell(&mut lines, Key::Frame, self.frame.map(Frame::word));
        tell(&mut lines, Key::Lines, places);
        tell(&mut lines, Key::Note, &self.notes);
        lines
    }
}

/// A line for each remark of one kind.
fn tell<T: fmt::Display>(lines: &mut Vec<String>, key: Key, said: impl IntoIterator<Item = T>) {
    lines.extend(said.into_iter().map(|words| format!("{} {words}", key.word())));
}

/// A note of a table; whether its values were simulated stands at its beginning.
fn note(words: String) -> Finding {
    match words.starts_with(SIMULATED) {
        true => Remark::Simulated { words }.into(),
        false => Remark::Said { words }.into(),
    }
}

/// Whether a note says that the values were not measured.
pub fn is_simulated(note: &Finding) -> bool {
    matches!(note.kind(), Some(Remark::Simulated { .. }))
}

/// The keys of causes, one after the other.
pub fn keys(causes: &[Cause]) -> String {
    joined(causes.iter().map(|cause| cause.word()))
}

/// One of two values that may be absent.
fn of_both<T>(one: Option<T>, other: Option<T>, of: impl Fn(T, T) -> T) -> Option<T> {
    [one, other].into_iter().flatten().reduce(of)
}

fn join(own: &mut Vec<Cause>, other: Vec<Cause>) {
    own.extend(other);
    own.sort_by_key(|cause| *cause as usize);
    own.dedup();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remarks_read_back_and_other_comments_mean_nothing() {
        let sizes = Sizes {
            terms: PerTerm::from_fn(|term| if term.is_positioning() { 0.0 } else { 0.0625 }),
            diagonals: PerDiagonal::from_fn(|_| 2.25),
        };
        let largest = LargestErrors {
            zero: "X 0 +, Y -5.5 -".to_string(),
            all_um: 4.5,
            ranges_um: 3.5,
            single: sizes.clone(),
        };
        let remarks = Remarks {
            doubts: vec![
                Remark::Doubtful { words: "a reading is disturbed: PPP node 58".to_string() }
                    .into(),
            ],
            not_determined: ErrorTerm::from_name("EXX")
                .map(|term| (term, "two scales can be traded".to_string()))
                .into_iter()
                .collect(),
            hidden_reversal_um: Some(9.125),
            degrees_of_freedom: Some(3.0),
            silence: Silence {
                not_stated: vec![Cause::Angles, Cause::SetUps],
                neglected: vec![Cause::Slopes],
            },
            largest: Some(largest.clone()),
            measured: Some(LargestErrors { all_um: 1.25, ..largest }),
            anew: Some(sizes.clone()),
            same_laser: Some(("SN: 0815".to_string(), sizes.clone())),
            doubtful: Some(sizes),
            frame: Some(Frame::XPrimary),
            lines: Some(PerAxis::from_fn(|axis| Millimetres::new(1.5 * f64::from(axis as u8)))),
            notes: vec![
                note("frame: X primary".to_string()),
                note(format!("{SIMULATED}: predicted")),
            ],
        };
        let mut table = "# made by hand\n#doubtful\n".to_string();
        for line in remarks.lines() {
            table += &format!("# {line}\n");
        }
        table += "axis,position_mm,ex_um\nx,0,0\nx,1,note: none\n";
        let read = Remarks::read(&table);
        assert_eq!(read, remarks);
        let saved_again = table.replace('\n', ",,;;\n");
        assert_eq!(Remarks::read(&saved_again), remarks);
        assert_eq!(read.simulated().count(), 1);
        assert_eq!(Remarks::read("# made by hand\n"), Remarks::default());
        for damaged in ["# doubtful beside that, um: EXX", "# not stated: angles"] {
            assert_eq!(Remarks::read(damaged).doubts.len(), 1, "{damaged}");
        }
    }

    #[test]
    fn tables_of_different_frames_are_doubtful_together() {
        let of = |frame: &str| Remarks::read(&format!("# frame: {frame}\n"));
        let mut same = of("x-primary");
        same.extend(of("x-primary"));
        same.extend(Remarks::default());
        assert_eq!(same.doubts, []);
        same.extend(of("as-measured"));
        let [doubt] = same.doubts.as_slice() else { panic!("{:?}", same.doubts) };
        assert!(doubt.to_string().contains("different frames"), "{doubt}");
    }

    #[test]
    fn equal_remarks_are_one_and_too_many_are_counted() {
        let doubts =
            |count: usize| (0..count).map(|n| format!("# doubt: {}\n# note: {n}\n", n / 2));
        let few = Remarks::read(&doubts(100).collect::<String>());
        assert_eq!((few.doubts.len(), few.notes.len()), (50, 100));
        let many = Remarks::read(&doubts(3000).collect::<String>());
        assert_eq!((many.doubts.len(), many.notes.len()), (MOST_REMARKS + 1, MOST_REMARKS + 1));
        let last =
            [many.doubts.last(), many.notes.last()].map(|last| last.map(ToString::to_string));
        assert!(
            last.iter().flatten().eq(&[
                "doubts and errors not determined that are not listed: 500 more",
                "notes that are not listed: 2000 more",
            ]),
            "{last:?}"
        );
        let long = Remarks::read(&format!("# doubt: {}\n", "x".repeat(60_000)));
        assert_eq!(long.doubts[0].to_string().chars().count(), 1001);
    }

    #[test]
    fn what_names_no_term_is_kept_as_a_note() {
        let remarks = Remarks::read("# not determined: reversal of each axis\n");
        assert_eq!(remarks.notes, [note("not determined: reversal of each axis".to_string())]);
    }
}
