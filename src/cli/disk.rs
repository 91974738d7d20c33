//! The files of this computer; and what was read of them in this run, over which nothing is written.

use crate::cli::refusals;
use crate::cli::write::{self, Output, written};
use crate::text::{LARGEST_FILE_MIB, Problem, Problems};
use crate::visit::files::{
    Begun, Files, Long, NamedBytes, PathEntry, Ready, STANDARD_INPUT, not_put_out, not_written,
    printed, unreadable,
};
use crate::visit::refusals as in_files;
use indicatif::ProgressBar;
use std::cell::RefCell;
use std::fs::{File, Metadata, TryLockError};
use std::io::{Error, Read, Seek};
use std::path::{Path, PathBuf};

/// A file or directory that was read.
struct Input {
    name: String,
    /// Without links; empty of standard input.
    place: PathBuf,
    is_directory: bool,
    identity: Option<Identity>,
}

/// The same for all names of a file: device and number on it.
type Identity = (u64, u64);

/// The files of this computer, and what was read of them.
#[derive(Default)]
pub(super) struct Disk {
    read: RefCell<Vec<Input>>,
    form: RefCell<Option<Form>>,
}

/// A form that this run fills in where it lies.
struct Form {
    place: PathBuf,
    /// As it was read.
    bytes: Vec<u8>,
    /// Locked, so that no other run fills it in; on Windows nothing is.
    _lock: Option<File>,
}

/// What is taken of a long text that comes through a pipe (it is kept on disk, because subprograms are gone back to).
const LARGEST_PIPE_BYTES: u64 = 16 * 1024 * 1024 * 1024;

impl Disk {
    fn remember(&self, name: &str, place: Option<&Path>, metadata: &Metadata) {
        self.read.borrow_mut().push(Input {
            name: name.to_string(),
            place: place.map(resolved).unwrap_or_default(),
            is_directory: metadata.is_dir(),
            identity: identity(metadata),
        });
    }

    /// Refuses an output that this run read, that contains something that it read, or that would lie in a directory that
    /// it read (it need not exist): asked when everything was read and nothing is written.
    fn refuse_input(&self, output: &Path) -> Result<(), Problem> {
        plain_name(output)?;
        let place = resolved(output);
        let own = identity_of(output.metadata());
        let read = self.read.borrow();
        let concerns = |input: &&Input| {
            (own.is_some() && own == input.identity)
                || input.place.starts_with(&place)
                || (input.is_directory && place.starts_with(&input.place))
        };
        let input = read.iter().find(concerns);
        let over = |input: &Input| Err(in_files::written_over(printed(output), &input.name));
        input.map_or(Ok(()), over)
    }

    /// Opens a regular file or a pipe, without waiting for somebody who writes into it.
    fn open(&self, path: &Path) -> Result<(File, Metadata), Problem> {
        let name = plain_name(path)?;
        let what = format!("`{name}`");
        let refuse = |error: Error| unreadable(&what, &error);
        let metadata = std::fs::metadata(path).map_err(refuse)?;
        if metadata.is_dir() {
            return Err(in_files::no_file(what));
        }
        if !metadata.is_file() && !is_pipe(&metadata) {
            return Err(refusals::not_regular(name));
        }
        let file = if metadata.is_file() { File::open(path) } else { open_pipe(path) };
        let file = file.map_err(refuse)?;
        self.remember(&name, Some(path), &metadata);
        Ok((file, metadata))
    }

    fn new_file(&self, file: &Path, force: bool) -> Result<(Output, File), Problems> {
        write::ensure_new(file, force)?;
        self.refuse_input(file)?;
        let (mut output, handle) = Output::file(file, force)?;
        let form = self.form.borrow();
        let form = form.as_ref().filter(|form| form.place == resolved(file));
        output.over = form.map(|form| form.bytes.clone());
        Ok((output, handle))
    }

    /// Standard input, which may be a file into which something else is to be written.
    fn piped(&self) -> impl Read {
        let input = std::io::stdin();
        #[cfg(unix)]
        {
            use std::os::fd::AsFd;
            let handle = input.as_fd().try_clone_to_owned().map(File::from);
            if let Ok(metadata) = handle.and_then(|file| file.metadata()) {
                self.remember(STANDARD_INPUT, None, &metadata);
            }
        }
        input.lock()
    }
}

impl Files for Disk {
    fn bytes(&self, path: &Path) -> Result<Vec<u8>, Problem> {
        let name = printed(path);
        let (file, metadata) = self.open(path)?;
        let bytes = bounded(&format!("`{name}`"), metadata.len(), file)?;
        if bytes.is_empty() && !metadata.is_file() {
            return Err(refusals::empty_pipe(name));
        }
        Ok(bytes)
    }

    fn standard_input(&self) -> Result<Vec<u8>, Problem> {
        bounded(STANDARD_INPUT, 0, self.piped())
    }

    fn form(&self, path: &Path, output: Option<&Path>) -> Result<(String, Vec<u8>), Problems> {
        let place = resolved(path);
        if !path.is_file() || output.is_none_or(|own| resolved(own) != place) {
            return self.argument(path);
        }
        let lock = locked(path)?;
        let (name, bytes) = self.argument(path)?;
        self.read.borrow_mut().pop();
        *self.form.borrow_mut() = Some(Form { place, bytes: bytes.clone(), _lock: lock });
        Ok((name, bytes))
    }

    fn long(&self, path: &Path) -> Result<(String, Box<dyn Long>), Problem> {
        if path == Path::new("-") {
            let file = spooled(STANDARD_INPUT, self.piped())?;
            return Ok((STANDARD_INPUT.to_string(), Box::new(file)));
        }
        let name = printed(path);
        let (file, metadata) = self.open(path)?;
        let file = if metadata.is_file() { file } else { spooled(&format!("`{name}`"), file)? };
        Ok((name, Box::new(file)))
    }

    fn names(&self, folder: &Path) -> std::io::Result<Vec<String>> {
        let mut names = Vec::new();
        for entry in std::fs::read_dir(folder)? {
            let entry = entry?;
            if entry.file_type()?.is_file() {
                names.push(entry.file_name().into_string().map_err(|name| {
                    Error::other(format!("the name {name:?} of a file in it is not UTF-8"))
                })?);
            }
        }
        names.sort();
        self.remember(&printed(folder), Some(folder), &folder.metadata()?);
        Ok(names)
    }

    fn kind(&self, path: &Path) -> std::io::Result<PathEntry> {
        let found = std::fs::metadata(path).map_err(|error| match path.is_symlink() {
            true => Error::other(error.to_string()), // it leads nowhere, but it is there
            false => error,
        });
        Ok(if found?.is_dir() { PathEntry::Folder } else { PathEntry::File })
    }

    fn same(&self, one: &Path, other: &Path) -> bool {
        let place = |path: &Path| std::fs::canonicalize(path).ok();
        place(one).is_some_and(|place_of_one| Some(place_of_one) == place(other))
    }

    fn ensure(&self, place: &Path, kind: PathEntry, force: bool) -> Result<(), Problems> {
        match kind {
            PathEntry::File => write::ensure_new(place, force),
            PathEntry::Folder => write::ensure_free(place, force),
        }
    }

    fn write(&self, file: &Path, bytes: &[u8], force: bool) -> Result<Box<dyn Ready>, Problems> {
        let (ready, mut handle) = self.new_file(file, force)?;
        written(&mut handle, bytes).map_err(|e| not_written("cannot write", file, &e))?;
        Ok(Box::new(ready))
    }

    fn write_folder(
        &self,
        folder: &Path,
        files: &[NamedBytes<'_>],
        force: bool,
    ) -> Result<Box<dyn Ready>, Problems> {
        write::ensure_free(folder, force)?;
        let place = write::named(folder)?;
        self.refuse_input(&place)?;
        Ok(Box::new(Output::folder(place, files, force)?))
    }

    fn begin(&self, file: Option<&Path>, force: bool) -> Result<Begun, Problems> {
        let Some(file) = file else {
            let file = tempfile::tempfile().map_err(|error| not_put_out(&error))?;
            return Ok((Box::new(file), None));
        };
        let (ready, handle) = self.new_file(file, force)?;
        Ok((Box::new(handle), Some(Box::new(ready))))
    }

    fn progress(&self, steps: usize) -> Box<dyn FnMut()> {
        let bar = ProgressBar::new(steps as u64);
        Box::new(move || bar.inc(1))
    }
}

/// A file that is locked by this run alone; `None` where the system locks nothing.
fn locked(path: &Path) -> Result<Option<File>, Problem> {
    while cfg!(unix) {
        let Ok(file) = File::open(path) else { break };
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(refusals::another_run(printed(path)));
        }
        if identity_of(path.metadata()) == identity_of(file.metadata()) {
            return Ok(Some(file)); // else another run put its own there meanwhile
        }
    }
    Ok(None)
}

/// A path in words, which has no control characters.
fn plain_name(path: &Path) -> Result<String, Problem> {
    let name = printed(path);
    match name.chars().any(char::is_control) {
        true => Err(refusals::control_character(name.escape_debug())),
        false => Ok(name),
    }
}

/// A path without links, also of something that does not exist yet.
fn resolved(path: &Path) -> PathBuf {
    match (path.canonicalize(), path.parent(), path.file_name()) {
        (Ok(found), _, _) => found,
        (Err(_), Some(parent), Some(name)) if parent != Path::new("") => {
            resolved(parent).join(name)
        }
        (Err(_), _, Some(name)) => resolved(Path::new(".")).join(name),
        (Err(_), _, None) => path.to_path_buf(),
    }
}

fn identity_of(metadata: std::io::Result<Metadata>) -> Option<Identity> {
    metadata.ok().and_then(|found| identity(&found))
}

#[cfg(unix)]
fn identity(metadata: &Metadata) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    Some((metadata.dev(), metadata.ino()))
}

/// Elsewhere a file is known by its path alone.
#[cfg(not(unix))]
fn identity(_: &Metadata) -> Option<Identity> {
    None
}

#[cfg(unix)]
fn is_pipe(metadata: &Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_fifo(&metadata.file_type())
}

#[cfg(not(unix))]
fn is_pipe(_: &Metadata) -> bool {
    false
}

/// A pipe that nobody writes into would be waited for when it is opened; when it is read, it ends.
#[cfg(unix)]
fn open_pipe(path: &Path) -> std::io::Result<File> {
    use rustix::fs::{CWD, Mode, OFlags, fcntl_setfl, openat};
    let flags = OFlags::RDONLY | OFlags::CLOEXEC | OFlags::NONBLOCK;
    let file = openat(CWD, path, flags, Mode::empty())?;
    fcntl_setfl(&file, OFlags::empty())?;
    Ok(file.into())
}

#[cfg(not(unix))]
fn open_pipe(path: &Path) -> std::io::Result<File> {
    File::open(path)
}

/// All bytes of an input, or a refusal; `length` is what the system says that there are, `name` as
/// it stands in a sentence.
fn bounded(name: &str, length: u64, input: impl Read) -> Result<Vec<u8>, Problem> {
    let limit = LARGEST_FILE_MIB << 20;
    if length > limit {
        return Err(in_files::too_long(name));
    }
    let expected = usize::try_from(length).unwrap_or(0);
    let mut bytes = Vec::with_capacity(expected + 1);
    input.take(limit + 1).read_to_end(&mut bytes).map_err(|error| unreadable(name, &error))?;
    if bytes.len() as u64 > limit {
        return Err(in_files::too_long(name));
    }
    Ok(bytes)
}

/// What comes through a pipe, as a file without a name.
fn spooled(name: &str, input: impl Read) -> Result<File, Problem> {
    let refuse = |error: Error| unreadable(name, &error);
    let mut file = tempfile::tempfile().map_err(refuse)?;
    let mut input = input.take(LARGEST_PIPE_BYTES + 1);
    if std::io::copy(&mut input, &mut file).map_err(refuse)? > LARGEST_PIPE_BYTES {
        return Err(refusals::long_pipe(name, LARGEST_PIPE_BYTES >> 30));
    }
    file.rewind().map_err(refuse)?;
    Ok(file)
}
