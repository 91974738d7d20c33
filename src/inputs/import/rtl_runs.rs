//! Which runs of a Renishaw file went which way.

use crate::inputs::import::choices::Runs;
use crate::inputs::import::placing::{Placing, freedom_remark};
use crate::inputs::import::rtl_file::File;
use crate::inputs::import::stated::{Stated, missing};
use crate::quantity::axis::Direction;
use crate::text::problem::{Problem, Problems};

/// Numbers of the runs of each way.
pub(super) struct Travelled {
    pub(super) forward: Vec<usize>,
    pub(super) reverse: Vec<usize>,
    dropped: Vec<usize>,
}

impl Travelled {
    fn both(forward: Vec<usize>, reverse: Vec<usize>) -> Travelled {
        Travelled {
            forward,
            reverse,
            dropped: Vec::new(),
        }
    }

    /// Return runs were never made.
    fn outward(forward: Vec<usize>, dropped: Vec<usize>) -> Travelled {
        Travelled {
            forward,
            reverse: Vec::new(),
            dropped,
        }
    }

    pub(super) fn words(&self, placing: &Placing) -> Vec<String> {
        let of = |runs: &[usize], direction: Direction| {
            (!runs.is_empty()).then(|| format!("{} moving {direction}", runs.len()))
        };
        let counts = [
            of(&self.forward, placing.run),
            of(&self.reverse, placing.run.opposite()),
        ];
        let counts: Vec<String> = counts.into_iter().flatten().collect();
        let repeated = self.forward.len() > 1;
        let u = if repeated {
            "; mean of each direction, u = s/√runs (k = 1)"
        } else {
            "; one run tells nothing about the uncertainty"
        };
        let mut words = vec![format!("runs: {}{u}", counts.join(", "))];
        let targets = placing.positions_mm().len();
        let fewest = [self.forward.len(), self.reverse.len()];
        let fewest = fewest.into_iter().filter(|runs| *runs > 0).min();
        words.extend(freedom_remark(targets, fewest.unwrap_or(0)));
        if !self.dropped.is_empty() {
            let dropped: Vec<String> = self.dropped.iter().map(usize::to_string).collect();
            words.push(format!(
                "runs {} hold only zeros: they were never made and are left out",
                dropped.join(", ")
            ));
        }
        words
    }
}

impl File<'_> {
    /// Which runs went which way: from the flags, which `--runs` must not contradict.
    pub(super) fn runs_travelled(
        &self,
        stated: &Stated,
        problems: &mut Problems,
    ) -> Option<Travelled> {
        let flagged = self.flagged();
        if flagged == Some(Runs::Bidirectional) && self.no_way_back() {
            return self.only_zeros_back(stated, problems);
        }
        if let (Some(flagged), Some(stated), Some(flags)) = (flagged, stated.runs, self.flags)
            && flagged != stated
        {
            problems.push(
                Problem::new(format!(
                    "`--runs {}` contradicts the flags of the file, which say {}",
                    stated.word(),
                    flagged.word()
                ))
                .at(flags.place())
                .help("leave `--runs` out"),
            );
            return None;
        }
        let Some(runs) = flagged.or(stated.runs) else {
            problems.push(self.runs_not_known());
            return None;
        };
        let (odd, even) = self.odd_and_even();
        match runs {
            Runs::Bidirectional if odd.len() == even.len() => Some(Travelled::both(odd, even)),
            Runs::Bidirectional => {
                problems.push(self.odd_count());
                None
            }
            Runs::Unidirectional => self.one_way(odd, even, stated, problems),
        }
    }

    fn odd_and_even(&self) -> (Vec<usize>, Vec<usize>) {
        let odd = (1..=self.runs).step_by(2).collect();
        (odd, (2..=self.runs).step_by(2).collect())
    }

    /// Whether there are even runs, and they hold nothing but zeros.
    fn no_way_back(&self) -> bool {
        let is_empty = |run: &usize| self.run(*run).iter().all(|um| *um == 0.0);
        let (_, even) = self.odd_and_even();
        !even.is_empty() && even.iter().all(is_empty)
    }

    /// Zeros in every return run of a bidirectional file: measured or never made?
    fn only_zeros_back(&self, stated: &Stated, problems: &mut Problems) -> Option<Travelled> {
        let (odd, even) = self.odd_and_even();
        match stated.runs {
            Some(Runs::Unidirectional) => Some(Travelled::outward(odd, even)),
            Some(Runs::Bidirectional) if odd.len() == even.len() => {
                Some(Travelled::both(odd, even))
            }
            Some(Runs::Bidirectional) => {
                problems.push(self.odd_count());
                None
            }
            None => {
                problems.push(self.at_flags(missing(
                    "--runs",
                    "the flags say bidirectional, but every even run holds only zeros",
                    "add `--runs unidirectional` if the return runs were never made (they are left out), or `--runs bidirectional` if zero was measured",
                )));
                None
            }
        }
    }

    fn at_flags(&self, problem: Problem) -> Problem {
        match self.flags {
            Some(flags) => problem.at(flags.place()),
            None => problem,
        }
    }

    /// The second flag, where it is one of the two that are known.
    fn flagged(&self) -> Option<Runs> {
        match self.flags?.text.split_whitespace().nth(1)? {
            "0" => Some(Runs::Bidirectional),
            "1" => Some(Runs::Unidirectional),
            _ => None,
        }
    }

    fn runs_not_known(&self) -> Problem {
        let problem = missing(
            "--runs",
            "the second number of `Flags` does not say whether even runs go back",
            "add `--runs bidirectional` (even runs go back) or `--runs unidirectional`",
        );
        self.at_flags(problem)
    }

    fn odd_count(&self) -> Problem {
        let message = format!(
            "`Run-count` is {} in a bidirectional file, expected an even number: each direction counts as a run",
            self.runs
        );
        let problem = Problem::new(message)
            .help("complete the last return run, or save the file without its outward run");
        self.at_flags(problem)
    }

    /// Return runs that were never made stand in the file as zeros.
    fn one_way(
        &self,
        odd: Vec<usize>,
        even: Vec<usize>,
        stated: &Stated,
        problems: &mut Problems,
    ) -> Option<Travelled> {
        if even.is_empty() || self.no_way_back() {
            return Some(Travelled::outward(odd, even));
        }
        if stated.runs == Some(Runs::Unidirectional) {
            return Some(Travelled {
                forward: (1..=self.runs).collect(),
                reverse: Vec::new(),
                dropped: Vec::new(),
            });
        }
        let problem = missing(
            "--runs",
            "the flags say unidirectional, but the even runs are not empty",
            "add `--runs unidirectional` if every run went from the first target to the last; else save the file as bidirectional",
        );
        problems.push(self.at_flags(problem));
        None
    }
}
