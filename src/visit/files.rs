//! Where the files of a run come from and go to: a disk, or the memory of a program that uses this one.

use crate::text::{LARGEST_FILE_MIB, Problem, Problems};
use crate::visit::refusals;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{Cursor, Error, ErrorKind, Read, Seek, Write};
use std::path::{Component, MAIN_SEPARATOR, MAIN_SEPARATOR_STR, Path, PathBuf};
use std::rc::Rc;

/// A file to be written: name and bytes.
pub type NamedBytes<'a> = (&'a str, &'a [u8]);

/// What may be too long to be held as bytes.
pub trait Long: Read + Write + Seek {}

impl<T: Read + Write + Seek> Long for T {}

/// What lies at a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathEntry {
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

/// What puts it there in the memory of a program.
impl<F: FnOnce()> Ready for F {
    fn put(self: Box<Self>) -> Result<(), Problems> {
        self();
        Ok(())
    }
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
    fn kind(&self, path: &Path) -> std::io::Result<PathEntry>;

    /// Whether two paths lead to the same.
    fn same(&self, one: &Path, other: &Path) -> bool;

    /// Refuses a file that exists, or a folder that holds something, before any work is done; with `force` anything but
    /// a regular file, or a folder.
    fn ensure(&self, place: &Path, kind: PathEntry, force: bool) -> Result<(), Problems>;

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
    fn is(&self, kind: PathEntry, path: &Path) -> bool {
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
    let words = match error.kind() {
        ErrorKind::NotFound => "it does not exist",
        ErrorKind::AlreadyExists => "it exists, so it is not overwritten",
        ErrorKind::NotADirectory => "a part of its path is a file",
        ErrorKind::PermissionDenied => "permission denied",
        ErrorKind::StorageFull => "no space left",
        _ => return error.to_string(),
    };
    words.to_string()
}

/// That something cannot be read; `what` as it stands in a sentence.
pub(crate) fn unreadable(what: &str, error: &Error) -> Problem {
    Problem::new(format!("{what} cannot be read: {}", plain_words(error)))
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

/// The same of whatever else has none of its own.
pub(crate) fn or_help(problem: Problem, help: &str) -> Problem {
    match problem.help {
        Some(_) => problem,
        None => problem.help(help),
    }
}

// Files in the memory of a program that uses this one, by their names.

type ByName = BTreeMap<PathBuf, Vec<u8>>;

/// Files by their names; a folder is what stands before a `/`.
///
/// ```
/// use nonius::visit::files::Memory;
/// let job = include_bytes!("../../fixtures/nine_errors_900/generic.toml");
/// let errors = include_bytes!("../../fixtures/nine_errors_900/errors.csv");
/// let files = Memory::of([("job.toml", &job[..]), ("errors.csv", &errors[..])]);
/// let answer = nonius::cli::answer(&files, ["generate", "job.toml", "-o", "kit"]);
/// assert_eq!(answer.status, 0, "{}", answer.err);
/// assert!(files.all().contains_key("kit/compensation.csv"));
/// let again = ["verify job.toml --tables kit", "generate job.toml -o kit --force"];
/// let again = again.map(|command| nonius::cli::answer(&files, command.split(' ')).status);
/// assert_eq!(again, [0, 0]);
/// ```
#[derive(Default)]
pub struct Memory {
    all: Rc<RefCell<ByName>>,
    read: RefCell<Vec<PathBuf>>,
    /// Where a file is looked for that is not here; nothing is written there.
    beneath: Option<Box<dyn Files>>,
}

impl Memory {
    /// These files.
    pub fn of<'a>(files: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> Memory {
        let all = files.into_iter().map(|(name, bytes)| (plain(Path::new(name)), bytes.to_vec()));
        Memory { all: Rc::new(RefCell::new(all.collect())), ..Memory::default() }
    }

    /// The same, and what is not there is read beneath it.
    #[must_use]
    pub fn over(self, beneath: Box<dyn Files>) -> Memory {
        Memory { beneath: Some(beneath), ..self }
    }

    /// What lies beneath, which is going to be read, where nothing lies here: a folder that is here hides one beneath it.
    fn beneath(&self, path: &Path) -> Option<&dyn Files> {
        let beneath = self.beneath.as_deref().filter(|_| self.own_kind(path).is_none())?;
        self.read.borrow_mut().push(plain(path));
        Some(beneath)
    }

    /// What lies here at a path.
    fn own_kind(&self, path: &Path) -> Option<PathEntry> {
        let (all, place) = (self.all.borrow(), plain(path));
        let has_inside = || all.keys().any(|path| path.starts_with(&place));
        let file = all.contains_key(&place).then_some(PathEntry::File);
        file.or_else(|| has_inside().then_some(PathEntry::Folder))
    }

    /// All files that are there now.
    pub fn all(&self) -> BTreeMap<String, Vec<u8>> {
        let all = self.all.borrow();
        let named = |(path, bytes): (&PathBuf, &Vec<u8>)| (shown(path), bytes.clone());
        all.iter().map(named).collect()
    }

    /// What was read and is, contains or lies in what is at `output`.
    fn refuse_input(&self, output: &Path) -> Result<(), Problem> {
        let read = self.read.borrow();
        let place = plain(output);
        let concerns = |input: &&PathBuf| input.starts_with(&place) || place.starts_with(input);
        match read.iter().find(concerns) {
            None => Ok(()),
            Some(input) => Err(refusals::written_over(printed(output), shown(input))),
        }
    }

    fn pending(&self, put: impl FnOnce(&mut ByName) + 'static) -> Box<dyn Ready> {
        let all = Rc::clone(&self.all);
        Box::new(move || put(&mut all.borrow_mut()))
    }
}

/// A path without `.`, and without what `..` takes back.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir if plain.file_name().is_some() => _ = plain.pop(),
            Component::CurDir => {}
            part => plain.push(part),
        }
    }
    plain
}

fn shown(path: &Path) -> String {
    path.to_string_lossy().replace('\\', "/")
}

impl Files for Memory {
    fn begin_run(&self) {
        self.read.borrow_mut().clear();
    }

    fn bytes(&self, path: &Path) -> Result<Vec<u8>, Problem> {
        if let Some(beneath) = self.beneath(path) {
            return beneath.bytes(path);
        }
        let what = format!("`{}`", path.display());
        let Some(bytes) = self.all.borrow().get(&plain(path)).cloned() else {
            return Err(match self.own_kind(path) {
                Some(_) => refusals::no_file(what),
                None => unreadable(&what, &ErrorKind::NotFound.into()),
            });
        };
        self.read.borrow_mut().push(plain(path));
        let fits = bytes.len() as u64 <= LARGEST_FILE_MIB << 20;
        if fits { Ok(bytes) } else { Err(refusals::too_long(what)) }
    }

    fn standard_input(&self) -> Result<Vec<u8>, Problem> {
        Err(refusals::no_standard_input(STANDARD_INPUT))
    }

    fn form(&self, path: &Path, _: Option<&Path>) -> Result<(String, Vec<u8>), Problems> {
        let form = self.argument(path)?;
        self.read.borrow_mut().pop();
        Ok(form)
    }

    fn long(&self, path: &Path) -> Result<(String, Box<dyn Long>), Problem> {
        if let Some(beneath) = self.beneath(path) {
            return beneath.long(path);
        }
        Ok((path.display().to_string(), Box::new(Cursor::new(self.bytes(path)?))))
    }

    fn names(&self, folder: &Path) -> std::io::Result<Vec<String>> {
        if let Some(beneath) = self.beneath(folder) {
            return beneath.names(folder);
        }
        let PathEntry::Folder = self.kind(folder)? else {
            return Err(ErrorKind::NotADirectory.into());
        };
        let place = plain(folder);
        let all = self.all.borrow();
        let inside = all.keys().filter(|path| path.parent() == Some(&place));
        let names = inside.filter_map(|path| path.file_name()?.to_str());
        self.read.borrow_mut().push(place.clone());
        Ok(names.map(str::to_string).collect())
    }

    fn kind(&self, path: &Path) -> std::io::Result<PathEntry> {
        match (self.own_kind(path), &self.beneath) {
            (Some(kind), _) => Ok(kind),
            (None, Some(beneath)) => beneath.kind(path),
            (None, None) => Err(Error::from(ErrorKind::NotFound)),
        }
    }

    fn same(&self, one: &Path, other: &Path) -> bool {
        plain(one) == plain(other)
    }

    fn ensure(&self, path: &Path, kind: PathEntry, force: bool) -> Result<(), Problems> {
        match self.own_kind(path) {
            Some(found) if found != kind || !force => {
                Err(refusals::is_there(path.display()).into())
            }
            _ => Ok(()),
        }
    }

    fn write(&self, file: &Path, bytes: &[u8], force: bool) -> Result<Box<dyn Ready>, Problems> {
        self.ensure(file, PathEntry::File, force)?;
        self.refuse_input(file)?;
        let (place, bytes) = (plain(file), bytes.to_vec());
        Ok(self.pending(move |all| _ = all.insert(place, bytes)))
    }

    fn write_folder(
        &self,
        folder: &Path,
        files: &[NamedBytes<'_>],
        force: bool,
    ) -> Result<Box<dyn Ready>, Problems> {
        self.ensure(folder, PathEntry::Folder, force)?;
        self.refuse_input(folder)?;
        let place = plain(folder);
        let files = files.iter().map(|(name, bytes)| (place.join(name), bytes.to_vec()));
        let files: ByName = files.collect();
        Ok(self.pending(move |all| {
            keep(all, &place);
            all.extend(files);
        }))
    }
}

/// What lies in a folder goes to where `--force` keeps it.
fn keep(all: &mut ByName, folder: &Path) {
    let is_free = |kept: &PathBuf| !all.keys().any(|path| path.starts_with(kept));
    let Some(kept) = (1..).map(|number| previous(folder, number)).find(is_free) else {
        return;
    };
    let old: Vec<PathBuf> = all.keys().filter(|path| path.starts_with(folder)).cloned().collect();
    for path in old {
        let bytes = all.remove(&path).unwrap_or_default();
        let rest = path.strip_prefix(folder).unwrap_or(&path);
        all.insert(kept.join(rest), bytes);
    }
}
