//! Keys of a job that a control needs: what only a person at the machine knows, and where it is read there.

use crate::control::controller::fact::{Evidence, Fact, origin_or_rule};
use crate::text::{Section, Word, section, words};
use serde::Serialize;

words! {
    /// The section of a job that a key stands in, without the axis.
    pub enum JobSection {
        /// Each `[machine.axes.x]`.
        MachineAxes = "machine.axes",
        /// `[measurement]`.
        Measurement = "measurement",
        /// `[compensation]`.
        Compensation = "compensation",
        /// Each `[compensation.axes.x]`.
        CompensationAxes = "compensation.axes",
    }
}

section! {
    /// One `[[job]]` of a profile.
    #[derive(Clone, Debug, PartialEq, Eq, Serialize)]
    pub struct JobKey(page: &Section<'_>, origin: Option<Fact<()>>) {
        /// Where it stands in a job.
        pub section: JobSection = choice(JobSection::WORDS),
            must "the section of a job that the key stands in";
        /// The key.
        pub key: String = text(), must "a key of a job";
        /// What an optional key may hold, as it is written; `None` = the job has to state it.
        pub example: Option<String> = text();
        /// What to write, and where it is read on the control.
        pub text: String = text(), must "what to write, and where the control shows it";
        /// How well that is known.
        pub evidence: Evidence => origin.as_ref().map(|origin| origin.evidence), must;
        /// Where it is from.
        pub source: String => origin.as_ref().map(|origin| origin.source.clone()), must;
        /// What happens if it is wrong.
        pub consequence: Option<String> => origin.and_then(|origin| origin.consequence);
    }
}

/// The keys of a page, in its order; none where it names none.
pub(super) fn job_keys(root: &Section<'_>) -> Vec<JobKey> {
    root.subs("job", |section| JobKey::read(section, origin_or_rule(section)))
}
