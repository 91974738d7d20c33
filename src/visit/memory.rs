//! Files in the memory of a program that uses this one, by their names.

use super::files::{Files, Kind, Long, NamedBytes, Ready, STANDARD_INPUT, previous, written_over};
use crate::text::{LARGEST_FILE_MIB, Problem, Problems};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{Cursor, Error, ErrorKind};
use std::path::{Component, Path, PathBuf};
use std::rc::Rc;

type ByName = BTreeMap<PathBuf, Vec<u8>>;

/// Files by their names; a folder is what stands before a `/`.
///
/// ```
/// use nonius::visit::memory::Memory;
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

    /// What lies beneath, where nothing lies here: a folder that is here hides one beneath it.
    fn beneath(&self, path: &Path) -> Option<&dyn Files> {
        self.beneath.as_deref().filter(|_| self.own_kind(path).is_none())
    }

    /// What lies here at a path.
    fn own_kind(&self, path: &Path) -> Option<Kind> {
        let (all, place) = (self.all.borrow(), plain(path));
        let has_inside = || all.keys().any(|path| path.starts_with(&place));
        let file = all.contains_key(&place).then_some(Kind::File);
        file.or_else(|| has_inside().then_some(Kind::Folder))
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
            Some(input) => Err(written_over(output, &shown(input))),
        }
    }

    fn pending(&self, put: impl FnOnce(&mut ByName) + 'static) -> Box<dyn Ready> {
        Box::new(Pending(Rc::clone(&self.all), put))
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
            self.read.borrow_mut().push(plain(path));
            return beneath.bytes(path);
        }
        let name = path.display();
        let refused = |words: String| Err(Problem::new(format!("`{name}` {words}")));
        let Some(bytes) = self.all.borrow().get(&plain(path)).cloned() else {
            let is_folder = self.own_kind(path).is_some();
            return match is_folder {
                true => refused("is a directory, expected a file".to_string())
                    .map_err(|problem| problem.help("name a file in it")),
                false => refused("cannot be read: it does not exist".to_string()),
            };
        };
        self.read.borrow_mut().push(plain(path));
        match bytes.len() as u64 > LARGEST_FILE_MIB << 20 {
            true => {
                refused(format!("holds more than {LARGEST_FILE_MIB} MiB, too much for an input"))
            }
            false => Ok(bytes),
        }
    }

    fn standard_input(&self) -> Result<Vec<u8>, Problem> {
        Err(Problem::new(format!("there is no {STANDARD_INPUT}")).help("name a file"))
    }

    fn form(&self, path: &Path, _: Option<&Path>) -> Result<(String, Vec<u8>), Problems> {
        let form = self.argument(path)?;
        self.read.borrow_mut().pop();
        Ok(form)
    }

    fn long(&self, path: &Path) -> Result<(String, Box<dyn Long>), Problem> {
        if let Some(beneath) = self.beneath(path) {
            self.read.borrow_mut().push(plain(path));
            return beneath.long(path);
        }
        Ok((path.display().to_string(), Box::new(Cursor::new(self.bytes(path)?))))
    }

    fn names(&self, folder: &Path) -> std::io::Result<Vec<String>> {
        if let Some(beneath) = self.beneath(folder) {
            self.read.borrow_mut().push(plain(folder));
            return beneath.names(folder);
        }
        let Kind::Folder = self.kind(folder)? else {
            return Err(ErrorKind::NotADirectory.into());
        };
        let place = plain(folder);
        let all = self.all.borrow();
        let inside = all.keys().filter(|path| path.parent() == Some(&place));
        let names = inside.filter_map(|path| path.file_name()?.to_str());
        self.read.borrow_mut().push(place.clone());
        Ok(names.map(str::to_string).collect())
    }

    fn kind(&self, path: &Path) -> std::io::Result<Kind> {
        match (self.own_kind(path), &self.beneath) {
            (Some(kind), _) => Ok(kind),
            (None, Some(beneath)) => beneath.kind(path),
            (None, None) => Err(Error::from(ErrorKind::NotFound)),
        }
    }

    fn same(&self, one: &Path, other: &Path) -> bool {
        plain(one) == plain(other)
    }

    fn ensure(&self, path: &Path, kind: Kind, force: bool) -> Result<(), Problems> {
        match self.own_kind(path) {
            Some(found) if found != kind || !force => {
                let words = format!("`{}` is there, so it is not overwritten", path.display());
                Err(Problem::new(words)
                    .help("choose another name, or `--force` to replace it")
                    .into())
            }
            _ => Ok(()),
        }
    }

    fn write(&self, file: &Path, bytes: &[u8], force: bool) -> Result<Box<dyn Ready>, Problems> {
        self.ensure(file, Kind::File, force)?;
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
        self.ensure(folder, Kind::Folder, force)?;
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

/// An output on its way.
struct Pending<F>(Rc<RefCell<ByName>>, F);

impl<F: FnOnce(&mut ByName)> Ready for Pending<F> {
    fn put(self: Box<Self>) -> Result<(), Problems> {
        let Pending(all, put) = *self;
        put(&mut all.borrow_mut());
        Ok(())
    }
}
