//! The page for a browser: a visit in one file, which sends nothing anywhere.
//! Feature `page` puts it into the program as packaging/page/build made it.

use crate::cli::outcome::Outcome;
use crate::cli::screen::Detail;
use crate::text::{Problem, Problems};
use crate::visit::files::printed;
use clap::Args;
use std::path::{Path, PathBuf};

#[cfg(not(feature = "page"))]
const PAGE: Option<&[u8]> = None;
#[cfg(feature = "page")]
const PAGE: Option<&[u8]> = Some(include_bytes!("../../target/package/nonius.html"));

#[derive(Args, Debug)]
pub(super) struct Options {
    /// The file to write (HTML); `-` = standard output
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Replace the file that is there
    #[arg(long)]
    force: bool,
}

pub(super) fn run(options: &Options) -> Result<Outcome, Problems> {
    let missing = "this program was built without the page; a released one holds it, or one built as packaging/README.md says";
    let page = PAGE.ok_or_else(|| Problem::new(missing))?.to_vec();
    let (place, force) = (options.output.clone(), options.force);
    if place == Path::new("-") {
        return Ok(Outcome::bytes(page));
    }
    let said = format!("wrote {}: open it in a browser", printed(&place));
    let outcome = Outcome::bytes(Vec::new()).saying(Detail::default(), said);
    Ok(outcome.writing(move |files| files.write(&place, &page, force)))
}
