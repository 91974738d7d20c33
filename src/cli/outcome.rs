//! What a command made, on its way out: standard output first, then the files into their places, then
//! the talk. Where one of the first two fails, nothing is written.

use crate::cli::write::Ready;
use crate::cli::{Answer, say};
use crate::kit::manifest;
use crate::text::plain;
use crate::text::problem::{Problem, Problems};
use serde::Serialize;
use std::fs::File;
use std::io::{ErrorKind, Write};

/// What a command made; nothing of it is outside yet.
pub(super) struct Outcome {
    answer: Answer,
    data: Data,
    ready: Option<Ready>,
    talk: Vec<String>,
}

/// What goes to standard output.
enum Data {
    Bytes(Vec<u8>),
    /// What is too long for the memory, from here to its end.
    File(File),
}

impl Outcome {
    fn of(data: Data) -> Outcome {
        Outcome {
            answer: Answer::Yes,
            data,
            ready: None,
            talk: Vec::new(),
        }
    }

    /// A page for people.
    pub(super) fn text(page: &str) -> Outcome {
        let page = format!("{}\n", plain::page(page.trim_end()));
        Outcome::bytes(page.into_bytes())
    }

    /// A document for scripts.
    pub(super) fn json(document: &impl Serialize) -> Result<Outcome, Problems> {
        Ok(Outcome::bytes(manifest::bytes(document)?))
    }

    /// A file, as it stands.
    pub(super) fn bytes(bytes: Vec<u8>) -> Outcome {
        Outcome::of(Data::Bytes(bytes))
    }

    /// A long file.
    pub(super) fn file(file: File) -> Outcome {
        Outcome::of(Data::File(file))
    }

    /// The same with another exit status.
    pub(super) fn answering(mut self, answer: Answer) -> Outcome {
        self.answer = answer;
        self
    }

    /// The same, and this is put into its place.
    pub(super) fn writing(mut self, ready: Ready) -> Outcome {
        self.ready = Some(ready);
        self
    }

    /// The same, and this is said at the end.
    pub(super) fn saying(mut self, text: impl Into<String>) -> Outcome {
        self.talk.push(text.into());
        self
    }

    /// Lets everything out.
    pub(super) fn deliver(self) -> Result<Answer, Problems> {
        self.data
            .print()
            .map_err(|error| Problem::new(format!("standard output cannot be written: {error}")))?;
        if let Some(ready) = self.ready {
            ready.put()?;
        }
        self.talk.iter().for_each(|text| say(text));
        Ok(self.answer)
    }
}

impl Data {
    /// To standard output, flushed. A reader that went away (`| head`) is no failure.
    fn print(self) -> std::io::Result<()> {
        let mut out = std::io::stdout().lock();
        let printed = match self {
            Data::Bytes(bytes) => out.write_all(&bytes),
            Data::File(mut file) => std::io::copy(&mut file, &mut out).map(|_| ()),
        };
        match printed.and_then(|()| out.flush()) {
            Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error),
            _ => Ok(()),
        }
    }
}
