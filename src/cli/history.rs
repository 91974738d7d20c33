//! `nonius history DIR`: the chain of tables that a kit stands in.
//!
//! ```text
//!   DIR/manifest.json ─ predecessor ─→ path, hash of its manifest ─→ found and compared ─→ …
//! ```
//! A predecessor is looked for inside the kit, beside it, and where `--force` left the old one
//! (`DIR.previous`); only a manifest of the stated hash counts. Exit status 1 where the chain
//! breaks or a file was changed.

use crate::cli::inputs::read_file;
use crate::cli::outcome::Outcome;
use crate::cli::write::previous;
use crate::cli::{Answer, Format};
use crate::control::controller::Role;
use crate::kit::manifest::MANIFEST;
use crate::kit::sha256;
use crate::text::document::json_page;
use crate::text::problem::{Problem, Problems, shown};
use clap::Args;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A chain of hashes cannot close to a ring; this bounds one of damaged links.
const LONGEST_CHAIN: usize = 1000;

// Options of `history`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// Directory of a kit
    directory: PathBuf,
    /// What to print
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

pub(super) fn run(options: &Options) -> Result<Outcome, Problems> {
    let chain = follow(&options.directory)?;
    let outcome = match options.format {
        Format::Json => Outcome::json(&document(&chain))?,
        Format::Text => Outcome::text(&text(&chain)),
    };
    Ok(outcome.answering(Answer::yes(chain.is_sound())))
}

/// One kit of the chain.
struct Link {
    directory: PathBuf,
    sha256: String,
    manifest: Value,
    /// Files that are missing or changed, one sentence each.
    faults: Vec<String>,
}

/// How a chain ends.
enum End {
    /// The first kit follows nothing.
    First,
    /// Files that were read out of the control; what made them is not known.
    ReadOut(Value),
    /// A predecessor that is not found, or is another one.
    Broken(String),
}

struct Chain {
    links: Vec<Link>,
    end: End,
}

impl Chain {
    fn is_sound(&self) -> bool {
        let whole = !matches!(self.end, End::Broken(_));
        whole && self.links.iter().all(|link| link.faults.is_empty())
    }
}

fn follow(directory: &Path) -> Result<Chain, Problems> {
    let help = "name the directory of a kit, as `nonius generate` wrote it";
    let first = read_link(directory).map_err(|problem| problem.help(help))?;
    let mut links = vec![first];
    let end = loop {
        let link = &links[links.len() - 1];
        let predecessor = &link.manifest["predecessor"];
        let path = predecessor["path"].as_str().unwrap_or_default();
        if predecessor.is_null() {
            break End::First;
        }
        let Some(hash) = predecessor["manifest_sha256"].as_str() else {
            break End::ReadOut(predecessor.clone());
        };
        if links.len() >= LONGEST_CHAIN {
            break End::Broken("the chain is too long to be followed".to_string());
        }
        match find(&link.directory, path, hash) {
            Ok(found) => links.push(found),
            Err(words) => break End::Broken(words),
        }
    };
    Ok(Chain { links, end })
}

fn read_link(directory: &Path) -> Result<Link, Problem> {
    let bytes = read_file(&directory.join(MANIFEST)).map_err(|_| {
        Problem::new(format!(
            "`{}` holds no {MANIFEST}, so it is no kit",
            directory.display()
        ))
    })?;
    let manifest = json_page(&bytes).map_err(|error| {
        Problem::new(format!(
            "manifest.json of `{}` is damaged: {error}",
            directory.display()
        ))
    })?;
    let mut faults = Vec::new();
    let mut seen = BTreeSet::new();
    for entry in manifest["files"].as_array().into_iter().flatten() {
        let name = entry["path"].as_str().unwrap_or_default();
        let role = entry["role"].as_str().and_then(Role::of_word);
        let place = directory.join(name);
        if !is_plain_name(name) {
            faults.push(format!("`{}` is no plain file name", shown(name)));
            continue;
        }
        if !seen.insert(name) {
            faults.push(format!("`{}` is listed twice", shown(name)));
            continue;
        }
        match read_file(&place) {
            Err(problem) if place.exists() => faults.push(problem.message),
            Err(_) => faults.push(format!("`{}` is missing", shown(name))),
            Ok(_) if role.is_some_and(Role::is_written_into) => {}
            Ok(bytes) if Some(sha256(&bytes).as_str()) != entry["sha256"].as_str() => {
                faults.push(format!("`{}` was changed after it was made", shown(name)));
            }
            Ok(_) => {}
        }
    }
    Ok(Link {
        directory: directory.to_path_buf(),
        sha256: sha256(&bytes),
        manifest,
        faults,
    })
}

/// A manifest lists files of its own directory and nothing else.
fn is_plain_name(name: &str) -> bool {
    Path::new(name).file_name() == Some(name.as_ref()) && !name.contains(['/', '\\', ':'])
}

/// The kit of this hash at one of the places where a predecessor lies.
fn find(kit: &Path, path: &str, hash: &str) -> Result<Link, String> {
    let parent = kit.parent().unwrap_or(Path::new(""));
    let last = Path::new(path).file_name().unwrap_or_default();
    let beside = [kit.join(path), parent.join(path), parent.join(last)];
    let kept = beside.iter().flat_map(|place| {
        let numbered = (1..).map(|number| previous(place, number));
        numbered.take_while(|kept| kept.exists())
    });
    let places: Vec<PathBuf> = beside.iter().cloned().chain(kept).collect();
    let found: Vec<Link> = places
        .iter()
        .filter_map(|place| read_link(place).ok())
        .collect();
    let other = found
        .first()
        .map(|link| link.directory.display().to_string());
    match (found.into_iter().find(|link| link.sha256 == hash), other) {
        (Some(link), _) => Ok(link),
        (None, Some(place)) => Err(format!(
            "`{}` is another kit than the predecessor: the hash of its manifest differs",
            shown(&place)
        )),
        (None, None) => Err(format!(
            "the predecessor `{}` is not found beside the kit",
            shown(path)
        )),
    }
}

fn word<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap_or("not stated")
}

fn text(chain: &Chain) -> String {
    const SHOWN_DIGITS: usize = 12;
    let mut lines = Vec::new();
    for (age, link) in chain.links.iter().enumerate() {
        let manifest = &link.manifest;
        lines.push(format!("{age}  {}", link.directory.display()));
        lines.push(format!(
            "   {}, {}, machine {}, measured {}, manifest {}",
            word(manifest, "tool"),
            word(manifest, "controller"),
            shown(word(&manifest["machine"], "name")),
            shown(word(&manifest["machine"], "measured")),
            &link.sha256[..SHOWN_DIGITS],
        ));
        let files = if link.faults.is_empty() {
            "all files as they were made".to_string()
        } else {
            format!("NOT as it was made: {}", link.faults.join("; "))
        };
        lines.push(format!("   {files}"));
    }
    lines.push(match &chain.end {
        End::First => "the chain begins here: no tables of a predecessor are contained".to_string(),
        End::ReadOut(read_out) => format!(
            "the chain begins with {} file(s) read out of the control (`{}`); what made them is not known",
            read_out["files"].as_array().map_or(0, Vec::len),
            shown(word(read_out, "path")),
        ),
        End::Broken(words) => format!("the chain BREAKS here: {words}"),
    });
    lines.join("\n")
}

fn document(chain: &Chain) -> Value {
    let link = |link: &Link| {
        json!({
            "directory": link.directory.display().to_string(),
            "manifest_sha256": link.sha256,
            "tool": link.manifest["tool"],
            "controller": link.manifest["controller"],
            "machine": link.manifest["machine"]["name"],
            "measured": link.manifest["machine"]["measured"],
            "faults": link.faults,
        })
    };
    let (end, words) = match &chain.end {
        End::First => ("first", None),
        End::ReadOut(_) => ("read-out", None),
        End::Broken(words) => ("broken", Some(words)),
    };
    let read_out = match &chain.end {
        End::ReadOut(read_out) => Some(read_out),
        _ => None,
    };
    json!({
        "schema": 1,
        "kits": chain.links.iter().map(link).collect::<Vec<_>>(),
        "end": end,
        "break": words,
        "read_out": read_out,
    })
}
