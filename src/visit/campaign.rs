//! A measurement of body diagonals with everything that its job names.

use crate::inputs::error_table::{Draft, ErrorTable};
use crate::inputs::job::{DiagonalMeasurement, Job, LinearSlope, MeasuredData, UseOf};
use crate::inputs::readings::Readings;
use crate::judge::after::StraightRuns;
use crate::judge::causes::Slip;
use crate::machine::separation::campaign::{self, NamedTables};
use crate::machine::separation::readings::{Noise, figures, repeats, walks};
use crate::machine::separation::straight::{StraightResult, straight};
use crate::machine::separation::table::{self, ErrorSource};
use crate::machine::separation::{self, Campaign, Separation};
use crate::quantity::{Pass, PathKind, PerDiagonal, Run};
use crate::text::Problems;
use crate::visit::files::Files;
use crate::visit::job_files::{Given, JobFiles};
use crate::write::emit::TOOL;
use std::path::Path;
use std::sync::Arc;

/// A measurement of diagonals with everything that its job names.
#[derive(Clone)]
pub(crate) struct CampaignFiles {
    /// The job itself.
    pub(crate) job: Job,
    /// How it was measured.
    pub(crate) measurement: DiagonalMeasurement,
    pub(crate) readings: Readings,
    tables: NamedTables,
    closure_errors: Option<ErrorTable>,
    readings_sha256: String,
}

impl CampaignFiles {
    /// The readings of a job, and every file that it names for them.
    pub(crate) fn read(
        files: &JobFiles<'_>,
        measurement: &DiagonalMeasurement,
    ) -> Result<CampaignFiles, Problems> {
        const KEY: &str = "measurement.step_diagonal";
        let (source, readings_sha256) =
            files.source(&measurement.readings, "measurement.readings")?;
        let readings = Readings::read(source, measurement)?;
        let mut tables = NamedTables::default();
        for (index, linear) in measurement.linear.iter().enumerate() {
            tables.linear.push(match &linear.slope {
                LinearSlope::Stated(_) | LinearSlope::NotYet => None,
                LinearSlope::Errors(path) => {
                    Some(files.table(path, &format!("{KEY}.linear[{index}].errors"))?)
                }
            });
        }
        let job = &files.job;
        let table = |path: &Option<String>, key: &str| {
            let table = path.as_ref().map(|path| files.table(path, key));
            table.transpose()
        };
        tables.angles = table(&job.measurement.angles, "measurement.angles")?;
        let closure_errors = table(&measurement.closure_errors, &format!("{KEY}.closure_errors"))?;
        let (job, measurement) = (job.clone(), measurement.clone());
        Ok(CampaignFiles { job, measurement, readings, tables, closure_errors, readings_sha256 })
    }

    /// The nine errors, for any backlash policy.
    pub(crate) fn errors(&self) -> Result<ErrorSource, Problems> {
        Ok(ErrorSource::Separated {
            separation: Arc::new(self.separate()?),
            readings: self.measurement.readings.clone(),
            comments: self.comments(),
        })
    }

    /// What goes into a separation beside the readings.
    pub(crate) fn campaign(&self) -> Result<Campaign<'_>, Problems> {
        let known = |run| self.readings.offset_known(run);
        let reverse_zero_known = self.readings.runs.iter().all(known);
        campaign::campaign(&self.job, &self.measurement, &self.tables, reverse_zero_known)
    }

    /// The nine errors.
    pub(crate) fn separate(&self) -> Result<Separation, Problems> {
        self.check_turn()?;
        let mut separation = separation::separate(&self.campaign()?, &self.readings.runs);
        separation.labels.splice(0..0, self.readings.notes());
        Ok(separation)
    }

    /// The same with a slip of the records taken back.
    pub(crate) fn without(&self, slip: Slip) -> CampaignFiles {
        let mut files = self.clone();
        match slip {
            Slip::Names(one, other) => files.readings.exchange(one, other),
            Slip::Order(order) => files.measurement.volume.order = order,
        }
        files
    }

    /// Reverse runs with a zero of their own hide where the axes reversed.
    fn check_turn(&self) -> Result<(), Problems> {
        let back = |run: &&Run| run.pass == Pass::Reverse && !self.readings.offset_known(run);
        let hidden = self.readings.runs.iter().find(back);
        match hidden.filter(|_| self.measurement.overrun.is_none()) {
            None => Ok(()),
            Some(run) => Err(self
                .job
                .problem_at(
                    "measurement.step_diagonal",
                    format!(
                        "the runs under the name {} count from their own start, so the readings do not tell whether the axes ran past the end point: `overrun` is missing",
                        run.diagonal.reverse_name()
                    ),
                )
                .help("state `overrun = true` or `overrun = false` as it was measured; without overrun the first moves back hold the lost motion of the axes")
                .into()),
        }
    }

    /// What straight runs say.
    pub(crate) fn straight(&self) -> Result<StraightResult, Problems> {
        let mut result =
            straight(&self.campaign()?, &self.readings.runs, self.closure_errors.as_ref())?;
        result.labels.splice(0..0, self.readings.notes());
        Ok(result)
    }

    /// Means and figures of straight runs, for a comparison with a forecast.
    pub(crate) fn straight_runs(&self) -> Result<StraightRuns, Problems> {
        let result = self.straight()?;
        let (figures, _) = figures(&result.zeroed_runs, PathKind::Straight);
        let mut walks = walks(&result.runs);
        walks.sort_by_key(|walk| walk.diagonal);
        let fewest = walks.iter().map(|walk| walk.runs).fold(f64::INFINITY, f64::min);
        let stated = self.job.measurement.uncertainty.noise_um;
        let (repeated, _) = repeats(&result.runs);
        let sigma_um = repeated.map(|noise| noise.sigma_um).or(stated);
        Ok(StraightRuns {
            volume: self.measurement.volume.clone(),
            walks,
            range_um: PerDiagonal::from_fn(|d| figures[d].range_um),
            u_um: sigma_um.map(|sigma| sigma / fewest.sqrt()),
            degrees_of_freedom: repeated.and_then(Noise::freedom_f64),
            scale_um_per_m: self.job.measurement.uncertainty.of_length_ppm(),
            laser_um_per_m: self.job.measurement.uncertainty.of_laser_ppm(),
            labels: result.labels,
            one_zero: self.readings.runs.iter().all(|run| self.readings.offset_known(run)),
        })
    }

    /// The error table, with where it comes from and what it rests on.
    pub(crate) fn draft(&self, separation: &Separation) -> Draft {
        table::draft(separation, &self.job, self.comments())
    }

    /// Where an error table comes from.
    fn comments(&self) -> Vec<String> {
        vec![
            format!("nine errors separated from step diagonals by {TOOL}"),
            format!("source: {} sha256 {}", self.measurement.readings, self.readings_sha256),
        ]
    }
}

/// Reads a job with readings and everything it names.
pub(crate) fn read_campaign(files: &dyn Files, job_path: &Path) -> Result<CampaignFiles, Problems> {
    let named = JobFiles::of(files, &Given::read(files, job_path)?, UseOf::Separation)?;
    let MeasuredData::Diagonals(measurement) = &named.job.measurement.data else {
        return Err(named
            .job
            .problem_at(
                "measurement.errors",
                "this job gives `errors`, which are separated already",
            )
            .help("a job with `readings` is needed here")
            .into());
    };
    CampaignFiles::read(&named, measurement)
}
