//! The files that a job names: read, and hashed.

use crate::control::controller::{Profile, ProfileSource, builtin, load};
use crate::inputs::error_table::ErrorTable;
use crate::inputs::import::{Measurement, source_of};
use crate::inputs::job::{Job, UseOf};
use crate::inputs::kind::FileKind;
use crate::inputs::readings::Readings;
use crate::kit::hashed;
use crate::kit::manifest::HashedFile;
use crate::text::{Notes, Problem, Problems, Source, template_text};
use crate::visit::files::{Files, beside_job, file_name, printed};
use std::cell::RefCell;
use std::path::Path;

/// A file that a command names, as it was read.
pub(crate) struct Given<'a> {
    pub(crate) path: &'a Path,
    /// The path as people read it.
    pub(crate) name: String,
    pub(crate) bytes: Vec<u8>,
    /// Its name without folders, and the hash of its bytes.
    pub(crate) hash: HashedFile,
}

impl<'a> Given<'a> {
    /// `-` is standard input.
    pub(crate) fn read(files: &dyn Files, path: &'a Path) -> Result<Given<'a>, Problems> {
        let (name, bytes) = files.argument(path)?;
        let hash = hashed(&file_name(path), &bytes);
        Ok(Given { path, name, bytes, hash })
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
        file: &Given<'a>,
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
