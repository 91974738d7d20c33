//! The files that a job names: read, and hashed; and a measurement of body diagonals with everything that its job names.

use crate::control::controller::{Profile, ProfileSource, builtin, load};
use crate::inputs::error_table::{Draft, ErrorTable};
use crate::inputs::import::{Measurement, source_of};
use crate::inputs::job::{DiagonalMeasurement, Job, LinearSlope, MeasuredData, UseOf};
use crate::inputs::kind::FileKind;
use crate::inputs::readings::Readings;
use crate::judge::active::HashedFile;
use crate::judge::after::StraightRuns;
use crate::judge::causes::Slip;
use crate::kit::hashed;
use crate::machine::separation::campaign::{self, NamedTables};
use crate::machine::separation::readings::{Noise, figures, walks};
use crate::machine::separation::straight::{StraightResult, straight};
use crate::machine::separation::table::{self, ErrorSource};
use crate::machine::separation::{self, Campaign, Separation};
use crate::quantity::{Pass, PathKind, PerDiagonal, Run};
use crate::text::{Notes, Problem, Problems, Source, template_text};
use crate::visit::files::{Files, beside_job, file_name, printed};
use crate::visit::refusals;
use crate::write::emit::TOOL;
use std::cell::RefCell;
use std::path::Path;
use std::sync::Arc;

/// A file that a command names, as it was read.
pub(crate) struct InputFile<'a> {
    pub(crate) path: &'a Path,
    /// The path as people read it.
    pub(crate) name: String,
    pub(crate) bytes: Vec<u8>,
    /// Its name without folders, and the hash of its bytes.
    pub(crate) hash: HashedFile,
}

impl<'a> InputFile<'a> {
    /// `-` is standard input.
    pub(crate) fn read(files: &dyn Files, path: &'a Path) -> Result<InputFile<'a>, Problems> {
        let (name, bytes) = files.argument(path)?;
        let hash = hashed(&file_name(path), &bytes);
        Ok(InputFile { path, name, bytes, hash })
    }

    /// What kind of file it is.
    pub(crate) fn kind(&self) -> FileKind {
        FileKind::of(&self.name, &self.bytes)
    }

    /// Its text.
    pub(crate) fn source(&self) -> Result<Source, Problems> {
        Source::from_bytes(&self.name, &self.bytes)
    }

    /// As a file of another maker.
    pub(crate) fn measurement(&self) -> Measurement<'_> {
        let HashedFile { path: name, sha256, .. } = &self.hash;
        Measurement { path: &self.name, name, sha256, bytes: &self.bytes }
    }
}

/// A job and where it lies, with the hash of everything that was read for it.
pub(crate) struct JobFiles<'a> {
    pub(crate) files: &'a dyn Files,
    pub(crate) job: Job,
    pub(crate) folder: &'a Path,
    pub(crate) hashes: RefCell<Vec<HashedFile>>,
}

impl<'a> JobFiles<'a> {
    /// Of a job that was read from `path`.
    pub(crate) fn new(files: &'a dyn Files, job: Job, path: &'a Path) -> JobFiles<'a> {
        let folder = path.parent().unwrap_or(Path::new(""));
        JobFiles { files, job, folder, hashes: RefCell::default() }
    }

    /// Of a job; one that is refused is refused for everything at once.
    pub(crate) fn of(
        files: &'a dyn Files,
        file: &InputFile<'a>,
        use_of: UseOf,
    ) -> Result<JobFiles<'a>, Problems> {
        let folder = file.path.parent().unwrap_or(Path::new(""));
        let find = |word: &str| Ok(profile(files, word, folder)?.0);
        let look_at = |path: &str, are_readings: bool| {
            let path = folder.join(path);
            let Ok(bytes) = files.bytes(&path) else {
                return Ok(()); // told when the job can be read
            };
            let source = Source::from_bytes(&printed(&path), &bytes)?;
            match are_readings {
                true => Readings::look_at_cells(&source),
                false => ErrorTable::look_at_cells(source),
            }
        };
        let job = Job::read_with_its_tables(file.source()?, use_of, find, look_at)?;
        let job = JobFiles::new(files, job, file.path);
        job.hashes.borrow_mut().push(file.hash.clone());
        Ok(job)
    }

    /// A problem of what stands at `key`.
    pub(crate) fn at(&self, key: &str, mut problem: Problem) -> Problem {
        problem.place = self.job.source.place_of(key).or(problem.place);
        beside_job(problem)
    }

    /// The bytes of a file that stands at `key`.
    pub(crate) fn bytes(&self, path: &Path, key: &str) -> Result<Vec<u8>, Problem> {
        self.files.bytes(path).map_err(|problem| self.at(key, problem))
    }

    /// A text that stands at `key`, and its hash; the measurement that it came from is hashed too.
    pub(crate) fn source(&self, path: &str, key: &str) -> Result<(Source, String), Problems> {
        let full = self.folder.join(path);
        let bytes = self.bytes(&full, key)?;
        let hash = hashed(path, &bytes);
        let source = Source::from_bytes(&printed(&full), &bytes)?;
        let measured = source_of(&source.text).map(|(name, sha256)| HashedFile {
            path: name,
            role: None,
            sha256,
            through: Some(path.to_string()),
        });
        let sha256 = hash.sha256.clone();
        let new = std::iter::once(hash).chain(measured);
        let mut hashes = self.hashes.borrow_mut();
        let new: Vec<HashedFile> = new.filter(|hash| !hashes.contains(hash)).collect();
        hashes.extend(new);
        Ok((source, sha256))
    }

    /// An error table that stands at `key`.
    pub(crate) fn table(&self, path: &str, key: &str) -> Result<ErrorTable, Problems> {
        ErrorTable::read(self.source(path, key)?.0)
    }

    /// The profile of the job's control.
    pub(crate) fn profile(&self) -> Result<Profile, Problems> {
        let (profile, hashes) = profile(self.files, &self.job.compensation.controller, self.folder)
            .map_err(|problems| self.at_controller(&problems))?;
        self.hashes.borrow_mut().extend(hashes);
        Ok(profile)
    }

    /// Problems without a place of their own concern the key that named the controller.
    fn at_controller(&self, problems: &Problems) -> Problems {
        let mut placed = Problems::none();
        for problem in problems.iter() {
            let mut problem = problem.clone();
            let key = || self.job.source.place_of("compensation.controller");
            problem.place = problem.place.or_else(key);
            placed.push(problem);
        }
        placed
    }
}

/// A built-in profile by id, or a user's own by path (relative to `folder`), with the hashes of its files.
pub(crate) fn profile(
    files: &dyn Files,
    reference: &str,
    folder: &Path,
) -> Result<(Profile, Vec<HashedFile>), Problems> {
    let is_path =
        reference.to_ascii_lowercase().ends_with(".toml") || reference.contains(['/', '\\']);
    if !is_path {
        return Ok((builtin::profile(reference)?, Vec::new()));
    }
    let path = folder.join(reference.strip_prefix("./").unwrap_or(reference));
    let bytes = files.bytes(&path).map_err(beside_job)?;
    let source = Source::from_bytes(&printed(&path), &bytes)?;
    let beside = path.parent().unwrap_or(Path::new(""));
    let hashes = RefCell::new(vec![hashed(reference, &bytes)]);
    let unreadable = Notes::default();
    let find = |name: &str, is_own: bool| {
        let own = if is_own { own_template(files, beside, name) } else { Ok(None) };
        match unreadable.take(own) {
            None => Some("".into()),
            Some(None) => builtin::template(name),
            Some(Some((text, hash))) => {
                let mut hashes = hashes.borrow_mut();
                let is_known = hashes.iter().skip(1).any(|known| known.path == name);
                hashes.extend((!is_known).then_some(hash));
                Some(text.into())
            }
        }
    };
    let origin = ProfileSource::File(reference.to_string());
    let profile = load::profile(source, origin, &find, &builtin::page);
    unreadable.end(())?;
    Ok((profile?, hashes.into_inner()))
}

/// A template beside the profile, `None` if there is none; its name must be a plain file name.
fn own_template(
    files: &dyn Files,
    folder: &Path,
    name: &str,
) -> Result<Option<(String, HashedFile)>, Problems> {
    let path = folder.join(name);
    let plain = !name.contains(['/', '\\']) && !name.starts_with('.');
    let is_absent = |error: std::io::Error| error.kind() == std::io::ErrorKind::NotFound;
    if !plain || files.kind(&path).is_err_and(is_absent) {
        return Ok(None);
    }
    let bytes = files.bytes(&path)?;
    let text = template_text(&printed(&path), &bytes)?;
    Ok(Some((text, hashed(name, &bytes))))
}

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
            Some(run) => {
                let problem = refusals::overrun_missing(run.diagonal.reverse_name());
                Err(self.job.source.at("measurement.step_diagonal", problem).into())
            }
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
        Ok(StraightRuns {
            volume: self.measurement.volume.clone(),
            walks,
            range_um: PerDiagonal::from_fn(|d| figures[d].range_um),
            u_um: result.noise.map(|noise| noise.sigma_um / fewest.sqrt()),
            degrees_of_freedom: result.noise.and_then(Noise::freedom_f64),
            scale_um_per_m: self.job.measurement.uncertainty.of_length_ppm(),
            laser_um_per_m: self.job.measurement.uncertainty.of_laser_ppm(),
            labels: result.doubts.into_iter().chain(result.labels).collect(),
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
    let named = JobFiles::of(files, &InputFile::read(files, job_path)?, UseOf::Separation)?;
    let MeasuredData::Diagonals(measurement) = &named.job.measurement.data else {
        return Err(named
            .job
            .source
            .at("measurement.errors", refusals::separated_already())
            .into());
    };
    CampaignFiles::read(&named, measurement)
}
