//! Keys of a job that a control needs: what only a person at the machine knows, and where it is read there.

use crate::control::controller::fact::{Evidence, Fact, origin_or_rule};
use crate::text::document::Section;
use crate::text::words::{Word, words};
use serde::Serialize;

words! {
    /// The section of a job that a key stands in, without the axis.
    #[derive(Serialize)]
    pub enum JobSection {
        /// Each `[machine.axes.x]`.
        #[serde(rename = "machine.axes")]
        MachineAxes = "machine.axes",
        /// `[measurement]`.
        #[serde(rename = "measurement")]
        Measurement = "measurement",
        /// `[compensation]`.
        #[serde(rename = "compensation")]
        Compensation = "compensation",
        /// Each `[compensation.axes.x]`.
        #[serde(rename = "compensation.axes")]
        CompensationAxes = "compensation.axes",
    }
}

/// One `[[job]]` of a profile.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct JobKey {
    /// Where it stands in a job.
    pub section: JobSection,
    /// The key.
    pub key: String,
    /// What an optional key may hold, as it is written; `None` = the job has to state it.
    pub example: Option<String>,
    /// What to write, and where it is read on the control.
    pub text: String,
    /// How well that is known.
    pub evidence: Evidence,
    /// Where it is from.
    pub source: String,
    /// What happens if it is wrong.
    pub consequence: Option<String>,
}

/// The keys of a page, in its order; none where it names none.
pub(super) fn job_keys(root: &Section<'_>) -> Option<Vec<JobKey>> {
    let sections = root.sections("job");
    let keys: Vec<Option<JobKey>> = sections.iter().map(job_key).collect();
    keys.into_iter().collect()
}

fn job_key(section: &Section<'_>) -> Option<JobKey> {
    if !section.has("section") {
        section.missing("section", "the section of a job that the key stands in");
    }
    let of_job = section.choice("section", JobSection::WORDS);
    let key = section.required_text("key", "a key of a job");
    let text = section.required_text("text", "what to write, and where the control shows it");
    let example = section.text("example");
    let origin = origin_or_rule(section);
    section.refuse_unknown_keys();
    let Fact { evidence, source, consequence, .. } = origin?;
    Some(JobKey {
        section: of_job?,
        key: key?,
        example,
        text: text?,
        evidence,
        source,
        consequence,
    })
}
