//! `nonius context JOB`

use crate::cli::{Answer, inputs, print_json};
use crate::kit::template_context;
use crate::problem::Problems;
use std::path::Path;

pub(super) fn run(job: &Path) -> Result<Answer, Problems> {
    print_json(&template_context(&inputs::read(job)?)?)
}
