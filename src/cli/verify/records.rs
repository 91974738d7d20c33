//! The readings of the first measurement, read again as if one slip of their records were taken back.

use crate::cli::inputs::{CampaignFiles, campaign_files, table_of};
use crate::inputs::job::MeasuredData;
use crate::judge::causes::{Corrected, Slip};
use crate::kit::Inputs;
use crate::machine::model::ErrorModel;
use crate::quantity::diagonal::PathKind;
use crate::text::problem::Problems;
use std::path::Path;

/// The first measurement, and where its job lies.
#[derive(Clone, Copy)]
pub(super) struct First<'a> {
    pub(super) inputs: &'a Inputs,
    pub(super) folder: &'a Path,
}

impl First<'_> {
    /// The machine as found under each slip; none where the job gives errors, not readings.
    pub(super) fn corrected(self) -> Result<Vec<Corrected>, Problems> {
        let job = &self.inputs.job;
        let MeasuredData::Diagonals(measurement) = &job.measurement.data else {
            return Ok(Vec::new());
        };
        if measurement.kind != PathKind::Step {
            return Ok(Vec::new());
        }
        let files = campaign_files(job, measurement, self.folder, &mut Vec::new())?;
        let slips = Slip::all(measurement.volume.order).into_iter();
        // Readings that do not go through with a slip taken back do not hold it.
        let corrected = slips.filter_map(|slip| {
            let before = self.model(&files.without(slip)).ok()?;
            Some(Corrected { slip, before })
        });
        Ok(corrected.collect())
    }

    /// The machine without tables, by the way that the job itself is read.
    fn model(self, files: &CampaignFiles) -> Result<ErrorModel, Problems> {
        let Inputs { job, profile, .. } = self.inputs;
        let table = table_of(files)?;
        let inputs = Inputs::new(job.clone(), profile.clone(), &table, Vec::new())?;
        match self.inputs.active.clone() {
            Some(active) => Ok(inputs.with_active(active)?.model),
            None => Ok(inputs.model),
        }
    }
}
