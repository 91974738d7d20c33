//! `nonius history DIR`: the chain of tables that a kit stands in.
//!
//! ```text
//!   DIR/manifest.json ─ predecessor ─→ path, hash of its manifest ─→ found and compared ─→ …
//! ```
//! A predecessor is looked for inside the kit, beside it, and where `--force` left the old one
//! (`DIR.previous`); only a manifest of the stated hash counts. Exit status 1 where the chain
//! breaks or a file was changed.

use crate::cli::outcome::{Outcome, Print};
use crate::cli::refusals;
use crate::cli::screen::Screen;
use crate::control::controller::Role;
use crate::judge::active::{KitManifest, Predecessor, faults};
use crate::judge::findings::FileFault;
use crate::kit::manifest::MANIFEST;
use crate::kit::sha256;
use crate::text::{Finding, Problem, Problems, json_page, shown};
use crate::visit::files::{Files, previous, printed, with_slashes};
use clap::Args;
use serde::Serialize;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// A chain of hashes cannot close to a ring; this bounds one of damaged links.
const LONGEST_CHAIN: usize = 1000;
/// Kits that `--force` kept beside a place and that are looked at: some may be gone.
const MOST_KEPT: usize = 100;

// Options of `history`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// Directory of a kit
    directory: PathBuf,
    #[command(flatten)]
    print: Print,
}

pub(super) fn run(options: &Options, files: &dyn Files) -> Result<Outcome, Problems> {
    let chain = follow(files, &options.directory)?;
    let is_sound = chain.broken.is_none() && chain.kits.iter().all(|link| link.faults.is_empty());
    Ok(options.print.outcome(|| screen(&chain), || &chain)?.answering(is_sound))
}

/// One kit of the chain, as scripts read it.
#[derive(Serialize)]
struct Link {
    directory: String,
    manifest_sha256: String,
    tool: Option<String>,
    controller: Option<String>,
    machine: Option<String>,
    measured: Option<String>,
    /// Files that are missing or changed.
    faults: Vec<Finding>,
    #[serde(skip)]
    predecessor: Option<Predecessor>,
}

/// What scripts read.
#[derive(Serialize)]
struct Chain {
    kits: Vec<Link>,
    /// `first`: the first kit follows nothing. `read-out`: files that were read out of the control.
    /// `broken`: a predecessor that is not found, or is another one.
    end: &'static str,
    #[serde(rename = "break")]
    broken: Option<String>,
    read_out: Option<Predecessor>,
}

fn follow(files: &dyn Files, directory: &Path) -> Result<Chain, Problems> {
    let help = "name the directory of a kit, as `nonius generate` wrote it";
    let first = read_link(files, directory).map_err(|problem| problem.help(help))?;
    let mut chain = Chain { kits: vec![first], end: "first", broken: None, read_out: None };
    loop {
        let link = &chain.kits[chain.kits.len() - 1];
        let Some(Predecessor { path, manifest_sha256, .. }) = &link.predecessor else {
            return Ok(chain);
        };
        let Some(hash) = manifest_sha256 else {
            let read_out = link.predecessor.clone();
            return Ok(Chain { end: "read-out", read_out, ..chain });
        };
        let found = match chain.kits.len() < LONGEST_CHAIN {
            true => find(files, link, path, hash),
            false => Err("the chain is too long to be followed".to_string()),
        };
        match found {
            Ok(found) => chain.kits.push(found),
            Err(words) => return Ok(Chain { end: "broken", broken: Some(words), ..chain }),
        }
    }
}

fn read_link(files: &dyn Files, directory: &Path) -> Result<Link, Problem> {
    let name = printed(directory);
    let bytes = files.bytes(&directory.join(MANIFEST)).map_err(|problem| {
        match files.names(directory).map_err(|error| error.kind()) {
            Err(ErrorKind::PermissionDenied) => problem,
            Err(ErrorKind::NotFound) => refusals::absent_kit(&name),
            _ => refusals::no_kit(&name, MANIFEST),
        }
    })?;
    let manifest: KitManifest =
        json_page(&bytes).map_err(|error| refusals::damaged_kit(&name, error))?;
    let read = |name: &str| {
        let place = directory.join(name);
        match files.bytes(&place) {
            Ok(bytes) => Ok(Some((None, bytes.into()))),
            Err(problem) if files.kind(&place).is_ok() => Err(problem),
            Err(_) => Ok(None),
        }
    };
    let faults = faults(&manifest.files, read).into_iter().filter(|fault| {
        let written_into = fault.role.is_some_and(Role::is_written_into);
        !written_into || matches!(fault.kind, FileFault::Missing { .. })
    });
    Ok(Link {
        directory: with_slashes(directory),
        manifest_sha256: sha256(&bytes),
        tool: manifest.tool,
        controller: manifest.controller,
        machine: manifest.machine.name,
        measured: manifest.machine.measured,
        faults: faults.map(|fault| fault.kind.into()).collect(),
        predecessor: manifest.predecessor,
    })
}

/// The kit of this hash at one of the places where a predecessor lies.
fn find(files: &dyn Files, link: &Link, path: &str, hash: &str) -> Result<Link, String> {
    let kit = Path::new(&link.directory);
    let parent = kit.parent().unwrap_or(Path::new(""));
    let last = Path::new(path).file_name().unwrap_or_default();
    let beside = [kit.join(path), parent.join(path), parent.join(last)];
    let kept =
        beside.iter().flat_map(|place| (1..=MOST_KEPT).map(|number| previous(place, number)));
    let places = beside.iter().cloned().chain(kept);
    let links = places.filter_map(|place| read_link(files, &place).ok());
    let is_other = |own: &Link| own.manifest_sha256 != link.manifest_sha256;
    let found: Vec<Link> = links.filter(is_other).collect();
    let other = found.first().map(|link| link.directory.clone());
    match (found.into_iter().find(|link| link.manifest_sha256 == hash), other) {
        (Some(link), _) => Ok(link),
        (None, Some(place)) => Err(format!(
            "`{}` is another kit than the predecessor: the hash of its manifest differs",
            shown(&place)
        )),
        (None, None) => {
            Err(format!("the predecessor `{}` is not found beside the kit", shown(path)))
        }
    }
}

/// A text of a manifest; nobody vouches for it.
fn word(text: Option<&String>) -> String {
    text.map_or_else(|| "not stated".to_string(), |text| shown(text))
}

fn screen(chain: &Chain) -> Screen {
    const SHOWN_DIGITS: usize = 12;
    let mut lines = Vec::new();
    for (age, link) in chain.kits.iter().enumerate() {
        lines.push(format!("{age}  {}", printed(Path::new(&link.directory))));
        lines.push(format!(
            "   {}, {}, machine {}, measured {}, manifest {}",
            word(link.tool.as_ref()),
            word(link.controller.as_ref()),
            word(link.machine.as_ref()),
            word(link.measured.as_ref()),
            &link.manifest_sha256[..SHOWN_DIGITS],
        ));
        lines.push(match link.faults.as_slice() {
            [] => "   all files as they were made".to_string(),
            faults => {
                let faults: Vec<String> = faults.iter().map(ToString::to_string).collect();
                format!("   NOT as it was made: {}", faults.join("; "))
            }
        });
    }
    lines.push(match (&chain.broken, &chain.read_out) {
        (Some(words), _) => format!("the chain BREAKS here: {words}"),
        (None, Some(read_out)) => format!(
            "the chain begins with {} file(s) read out of the control (`{}`); what made them is not known",
            read_out.files.len(),
            shown(&read_out.path),
        ),
        (None, None) => {
            "the chain begins here: no tables of a predecessor are contained".to_string()
        }
    });
    Screen::of(lines.join("\n"))
}
