//! Where the files of a run come from and go to: a disk, or the memory of a program that uses this one.

use crate::text::{Problem, Problems};
use std::io::{Cursor, Error, Read, Seek, Write};
use std::path::{MAIN_SEPARATOR, MAIN_SEPARATOR_STR, Path, PathBuf};

/// A file to be written: name and bytes.
pub type NamedBytes<'a> = (&'a str, &'a [u8]);

/// What may be too long to be held as bytes.
pub trait Long: Read + Write + Seek {}

impl<T: Read + Write + Seek> Long for T {}

/// What lies at a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A file, or a pipe.
    File,
    /// A folder.
    Folder,
}

/// An output that is complete, and not in its place yet. Dropped before it is there, it goes.
pub trait Ready {
    /// Waits until what was begun is where it stays.
    fn complete(&self) -> Result<(), Problems> {
        Ok(())
    }

    /// Puts it there, at once.
    fn put(self: Box<Self>) -> Result<(), Problems>;
}

/// What a run reads, and where it writes. Paths are as a user gives them, `-` is standard input.
///
/// Whatever is read is remembered: nothing is written over it, into it or around it.
pub trait Files {
    /// A command begins, which has read nothing yet.
    fn begin_run(&self) {}

    /// The bytes of a file; a folder, what is no file and what is too long is refused.
    fn bytes(&self, path: &Path) -> Result<Vec<u8>, Problem>;

    /// The bytes that come in by standard input.
    fn standard_input(&self) -> Result<Vec<u8>, Problem>;

    /// A form with its name, which `output` may replace: only as it was read, and no other run fills it in meanwhile.
    fn form(&self, path: &Path, output: Option<&Path>) -> Result<(String, Vec<u8>), Problems>;

    /// A text that may be too long for the memory, with its name.
    fn long(&self, path: &Path) -> Result<(String, Box<dyn Long>), Problem>;

    /// The names of the files in a folder, in order; links and folders are none.
    fn names(&self, folder: &Path) -> std::io::Result<Vec<String>>;

    /// What lies at a path.
    fn kind(&self, path: &Path) -> std::io::Result<Kind>;

    /// Whether two paths lead to the same.
    fn same(&self, one: &Path, other: &Path) -> bool;

    /// Refuses a file that exists, or a folder that holds something, before any work is done; with `force` anything but
    /// a regular file, or a folder.
    fn ensure(&self, place: &Path, kind: Kind, force: bool) -> Result<(), Problems>;

    /// Writes a file, whole; refuses what [`Files::ensure`] does.
    fn write(&self, file: &Path, bytes: &[u8], force: bool) -> Result<Box<dyn Ready>, Problems>;

    /// Writes the files of a folder, the last one last; refuses what [`Files::ensure`] does.
    fn write_folder(
        &self,
        folder: &Path,
        files: &[NamedBytes<'_>],
        force: bool,
    ) -> Result<Box<dyn Ready>, Problems>;

    /// Begins what may be too long for the memory: a file, or what goes to standard output. What has no place yet is
    /// written as a whole when it is complete.
    fn begin(&self, _file: Option<&Path>, _force: bool) -> Result<Begun, Problems> {
        Ok((Box::new(Cursor::new(Vec::new())), None))
    }

    /// What is called after each of so many steps of a long run, and shows how far it is to somebody who looks on.
    fn progress(&self, _steps: usize) -> Box<dyn FnMut()> {
        Box::new(|| {})
    }

    /// A file argument with its name: `-` is standard input.
    fn argument(&self, path: &Path) -> Result<(String, Vec<u8>), Problems> {
        if path == Path::new("-") {
            return Ok((STANDARD_INPUT.to_string(), self.standard_input()?));
        }
        let bytes = self.bytes(path).map_err(|p| or_help(p, "check the path"))?;
        Ok((printed(path), bytes))
    }

    /// Whether there is a file, or a folder.
    fn is(&self, kind: Kind, path: &Path) -> bool {
        self.kind(path).is_ok_and(|found| found == kind)
    }
}

/// What a long file is written into, and what puts it into its place.
pub type Begun = (Box<dyn Long>, Option<Box<dyn Ready>>);

/// How standard input is called.
pub const STANDARD_INPUT: &str = "standard input";

/// The last part of a path.
pub fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(|| "-".to_string(), |name| name.to_string_lossy().into_owned())
}

/// A path as people read it: with the separator of this computer, and no other.
pub(crate) fn printed(path: &Path) -> String {
    path.display().to_string().replace('/', MAIN_SEPARATOR_STR)
}

/// A path as scripts and jobs read it, the same on every computer.
pub(crate) fn with_slashes(path: &Path) -> String {
    path.display().to_string().replace(MAIN_SEPARATOR, "/")
}

/// What went wrong, the same on every operating system where it is common.
pub fn plain_words(error: &Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "it does not exist".to_string(),
        std::io::ErrorKind::NotADirectory => "a part of its path is a file".to_string(),
        std::io::ErrorKind::PermissionDenied => "permission denied".to_string(),
        std::io::ErrorKind::StorageFull => "no space left".to_string(),
        _ => error.to_string(),
    }
}

/// What stopped an output on its way to a place.
pub(crate) fn not_written(what: &str, path: &Path, error: &Error) -> Problems {
    Problem::new(format!("{what} `{}`: {}; nothing was written", printed(path), plain_words(error)))
        .help("check the place and its free space, then run the command again")
        .into()
}

/// The same on its way to standard output.
pub(crate) fn not_put_out(error: &Error) -> Problem {
    Problem::new(format!("standard output cannot be written: {}", plain_words(error)))
}

/// Refuses an output that the run reads, or that lies in or around what it reads.
pub(crate) fn written_over(output: &Path, input: &str) -> Problem {
    let name = printed(output);
    let message =
        format!("writing `{name}` would replace or change `{input}`, which this run reads");
    Problem::new(message).help("choose another name for `-o`")
}

/// Where the folder that `--force` replaces is kept: `DIR.previous`, `DIR.previous-2`, ….
pub fn previous(folder: &Path, number: usize) -> PathBuf {
    let mut name = folder.as_os_str().to_os_string();
    name.push(match number {
        0 | 1 => ".previous".to_string(),
        _ => format!(".previous-{number}"),
    });
    PathBuf::from(name)
}

/// The next step for a file that a job names.
pub(crate) fn beside_job(problem: Problem) -> Problem {
    or_help(problem, "relative paths in a job are relative to the job file")
}

fn or_help(problem: Problem, help: &str) -> Problem {
    match problem.help {
        Some(_) => problem,
        None => problem.help(help),
    }
}
