//! What a command made, on its way out: standard output first, then the files into their places, then
//! the talk. Where one of the first two fails, nothing is written.
//! `--plot FILE` adds what was found as a picture: in English, mm and µm.

use crate::cli::refusals;
use crate::cli::screen::{Detail, Screen, spoken};
use crate::kit::manifest;
use crate::page::{DisplayUnit, Locale, Picture, Texts};
use crate::text::Problems;
use crate::visit::files::{Begun, Files, Long, NamedBytes, PathEntry, Ready, not_written, printed};
use clap::{Args, ValueEnum};
use serde::ser::Error as _;
use serde::{Serialize, Serializer};
use std::io::{Cursor, ErrorKind, Write};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    /// Tables for people
    #[default]
    Text,
    /// One JSON document for scripts
    Json,
}

/// Options of every command that prints.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(super) struct Print {
    /// What to print
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
    #[command(flatten)]
    pub(super) detail: Detail,
}

impl Print {
    /// The screen, or the document for scripts.
    pub(super) fn outcome<D: Serialize>(
        self,
        screen: impl FnOnce() -> Screen,
        document: impl FnOnce() -> D,
    ) -> Result<Outcome, Problems> {
        self.as_it_is(screen, || Versioned { schema: 1, document: document() })
    }

    /// The same of a document that states the version of its form itself.
    pub(super) fn as_it_is<D: Serialize>(
        self,
        screen: impl FnOnce() -> Screen,
        document: impl FnOnce() -> D,
    ) -> Result<Outcome, Problems> {
        match self.format {
            Format::Text => Ok(Outcome::text(&screen().page(self.detail))),
            Format::Json => Outcome::json(&document()),
        }
    }
}

/// Options of every command that writes.
#[derive(Args, Debug)]
pub(super) struct Output {
    /// The file to write (CSV); `-` = standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace what is there; a directory is kept as DIR.previous
    #[arg(long, requires = "output")]
    pub(super) force: bool,
    #[command(flatten)]
    pub(super) print: Print,
}

impl Output {
    /// Where it goes; standard output has no place.
    pub(super) fn place(&self) -> Option<&Path> {
        self.output.as_deref().filter(|path| *path != Path::new("-"))
    }

    /// Whether something is to be written at all.
    pub(super) fn is_asked_for(&self) -> bool {
        self.output.is_some()
    }

    /// Refuses a file that is there already, before anything is computed; `what` = what it will hold.
    pub(super) fn ensure_new(&self, files: &dyn Files, what: &str) -> Result<(), Problems> {
        if self.output.as_deref() == Some(Path::new("-")) && self.print.format == Format::Json {
            return Err(refusals::both_on_standard_output(what).into());
        }
        self.place().map_or(Ok(()), |place| files.ensure(place, PathEntry::File, self.force))
    }

    /// The screen or the document, and the file; where the file goes to standard output, the screen is
    /// talk. `next` is said behind the name of a file that was written.
    pub(super) fn deliver<D: Serialize>(
        &self,
        files: &dyn Files,
        content: Option<Begun>,
        screen: impl FnOnce() -> Screen,
        document: impl FnOnce() -> D,
        next: &str,
    ) -> Result<Outcome, Problems> {
        let detail = self.print.detail;
        let Some((mut long, ready)) = content else {
            return self.print.outcome(screen, document);
        };
        let Some(place) = self.place() else {
            return Ok(Outcome::of(long).saying(detail, screen().page(detail)));
        };
        let outcome = self.print.outcome(screen, document)?;
        let whole = || {
            let mut bytes = Vec::new();
            long.read_to_end(&mut bytes).map_err(|e| not_written("cannot write", place, &e))?;
            files.write(place, &bytes, self.force)
        };
        let ready = ready.map_or_else(whole, Ok)?;
        Ok(outcome.writing(ready).saying(detail, format!("wrote {}{next}", printed(place))))
    }

    /// Refuses a directory that is not free, before anything is computed.
    pub(super) fn free_directory(&self, files: &dyn Files) -> Result<&Path, Problems> {
        files.ensure(self.directory(), PathEntry::Folder, self.force)?;
        Ok(self.directory())
    }

    fn directory(&self) -> &Path {
        self.output.as_deref().unwrap_or(Path::new("."))
    }

    /// The files, and then the last one; `next_steps` are said.
    pub(super) fn deliver_files<'a>(
        &self,
        files: &dyn Files,
        outcome: Outcome,
        own: impl IntoIterator<Item = NamedBytes<'a>>,
        last: NamedBytes<'a>,
        next_steps: String,
    ) -> Result<Outcome, Problems> {
        let own: Vec<NamedBytes<'_>> = own.into_iter().chain([last]).collect();
        let ready = files.write_folder(self.directory(), &own, self.force)?;
        Ok(outcome.writing(ready).saying(self.print.detail, next_steps))
    }
}

/// A number within a range; beyond it a unit was mistaken.
pub(super) fn number(text: &str, range: RangeInclusive<f64>, unit: &str) -> Result<f64, String> {
    let number: Option<f64> = text.parse().ok();
    let (low, high) = (range.start(), range.end());
    let found = number.filter(|number| range.contains(number));
    found.ok_or_else(|| {
        format!("expected a number from {low} to {high} {unit}, with a decimal point")
    })
}

/// A number above 0.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok();
    let number = number.filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "expected a number above 0, e.g. 10".to_string())
}

/// What a file is to hold, where it is in memory.
pub(super) fn held(bytes: impl Into<Vec<u8>>) -> Begun {
    (Box::new(Cursor::new(bytes.into())), None)
}

/// What a command answered.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Answer {
    /// Exit status: 0 = done and within limits, 1 = the answer is no, 2 = could not do it.
    pub status: u8,
    /// What goes to standard output.
    pub out: Vec<u8>,
    /// What goes to standard error.
    pub err: String,
    /// The problems in it, where there are any; wrong usage is none.
    pub problems: Problems,
}

/// What a command made; nothing of it is outside yet.
pub(super) struct Outcome {
    yes: bool,
    /// What goes to standard output, from here to its end.
    data: Box<dyn Long>,
    /// What lies beside its place.
    ready: Vec<Box<dyn Ready>>,
    talk: String,
}

impl Outcome {
    fn of(data: Box<dyn Long>) -> Outcome {
        Outcome { yes: true, data, ready: Vec::new(), talk: String::new() }
    }

    /// A page for people.
    pub(super) fn text(page: &str) -> Outcome {
        Outcome::bytes(spoken(page).into_bytes())
    }

    /// A document for scripts: its figures rounded as in a manifest.
    pub(super) fn json(document: &impl Serialize) -> Result<Outcome, Problems> {
        Ok(Outcome::bytes(manifest::bytes(document)?))
    }

    /// A file, as it stands.
    pub(super) fn bytes(bytes: Vec<u8>) -> Outcome {
        Outcome::of(held(bytes).0)
    }

    /// The same with another answer: exit status 0 or 1.
    pub(super) fn answering(mut self, yes: bool) -> Outcome {
        self.yes = yes;
        self
    }

    /// The same, and this is put into its place.
    pub(super) fn writing(mut self, ready: Box<dyn Ready>) -> Outcome {
        self.ready.push(ready);
        self
    }

    /// The same, and this is said at the end, unless nobody wants to hear it.
    pub(super) fn saying(mut self, detail: Detail, text: impl Into<String>) -> Outcome {
        if !detail.quiet {
            self.talk += text.into().trim_end();
            self.talk.push('\n');
        }
        self
    }

    /// Lets everything out; the answer, and what is to be said.
    pub(super) fn deliver(mut self, out: &mut dyn Write) -> Result<(bool, String), Problems> {
        self.ready.iter().try_for_each(|ready| ready.complete())?;
        self.print(out).map_err(refusals::not_put_out)?;
        self.ready.into_iter().try_for_each(|ready| ready.put())?;
        Ok((self.yes, self.talk))
    }

    /// To standard output, flushed. A reader that went away (`| head`) is no failure.
    fn print(&mut self, out: &mut dyn Write) -> std::io::Result<()> {
        match std::io::copy(&mut self.data, out).and_then(|_| out.flush()) {
            Err(error) if is_reader_gone(&error) => Ok(()),
            printed => printed,
        }
    }
}

/// A document for scripts, which begins with the version of its form.
#[derive(Serialize)]
struct Versioned<D> {
    schema: u32,
    #[serde(flatten)]
    document: D,
}

/// A document without what is not known.
pub(super) struct Known<T>(pub(super) T);

impl<T: Serialize> Serialize for Known<T> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut document = serde_json::to_value(&self.0).map_err(S::Error::custom)?;
        if let Some(fields) = document.as_object_mut() {
            fields.retain(|_, value| !value.is_null());
        }
        document.serialize(to)
    }
}

/// Whether whoever reads the output went away (`| head`), which is no failure.
pub(super) fn is_reader_gone(error: &std::io::Error) -> bool {
    // ERROR_NO_DATA and ERROR_PIPE_NOT_CONNECTED of Windows; no other system has errors of these numbers.
    error.kind() == ErrorKind::BrokenPipe || matches!(error.raw_os_error(), Some(232 | 233))
}

/// The option of every command that can draw.
#[derive(Args, Debug)]
pub(super) struct Plot {
    /// Also draw it: a picture (SVG)
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

/// The options of a command that prints, and writes nothing but the picture.
#[derive(Args, Debug)]
pub(super) struct Shows {
    #[command(flatten)]
    plot: Plot,
    /// Replace the picture that is there
    #[arg(long, requires = "plot")]
    force: bool,
    #[command(flatten)]
    print: Print,
}

impl Plot {
    /// The same outcome with the picture, if one is asked for; drawn only then.
    pub(super) fn beside(
        &self,
        files: &dyn Files,
        outcome: Outcome,
        force: bool,
        picture: impl FnOnce(Locale<'_>) -> Picture,
    ) -> Result<Outcome, Problems> {
        let Some(place) = &self.plot else {
            return Ok(outcome);
        };
        let texts = Texts::english()?;
        let locale = Locale { texts: &texts, shown: DisplayUnit::Metric };
        Ok(outcome.writing(files.write(place, &picture(locale).svg(locale).into_bytes(), force)?))
    }
}

impl Shows {
    /// The screen or the document, with the picture, if one is asked for.
    pub(super) fn outcome<D: Serialize>(
        &self,
        files: &dyn Files,
        screen: impl FnOnce() -> Screen,
        document: impl FnOnce() -> D,
        picture: impl FnOnce(Locale<'_>) -> Picture,
    ) -> Result<Outcome, Problems> {
        self.plot.beside(files, self.print.outcome(screen, document)?, self.force, picture)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Error;

    struct Refusing(i32);

    impl Write for Refusing {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(Error::from_raw_os_error(self.0))
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_reader_that_went_away_is_no_failure_on_any_system() {
        let prints = |number| Outcome::bytes(b"page".to_vec()).print(&mut Refusing(number)).is_ok();
        let number = if cfg!(windows) { 109 } else { 32 };
        assert!([number, 232, 233].into_iter().all(prints));
        let full = if cfg!(windows) { 112 } else { 28 };
        assert!(!prints(full));
    }
}
