//! `nonius import --form readings.csv --ppp FILE … -o readings.csv`

use crate::cli::outcome::{Content, Outcome, Output};
use crate::cli::screen::Screen;
use crate::inputs::import::stated::Stated;
use crate::inputs::import::{List, Measurement, fill};
use crate::kit::sha256;
use crate::quantity::diagonal::Diagonal;
use crate::text::document::Source;
use crate::text::problem::Problems;
use crate::visit::files::{Files, file_name};
use clap::Args;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

// Lists of captures, and the form that says where they were taken.
#[derive(Args, Debug)]
pub(super) struct Lists {
    /// Fill in these readings, as `new` and `program` write them, from lists of captures
    #[arg(long)]
    pub(super) form: Option<PathBuf>,
    /// With a form: the list of the diagonal PPP
    #[arg(long, value_name = "FILE", requires = "form")]
    ppp: Option<PathBuf>,
    /// With a form: that of NPP
    #[arg(long, value_name = "FILE", requires = "form")]
    npp: Option<PathBuf>,
    /// With a form: that of PNP
    #[arg(long, value_name = "FILE", requires = "form")]
    pnp: Option<PathBuf>,
    /// With a form: that of PPN
    #[arg(long, value_name = "FILE", requires = "form")]
    ppn: Option<PathBuf>,
}

/// A list as it was read: of which diagonal, path, name, hash and bytes.
type Read = (Option<Diagonal>, String, String, String, Vec<u8>);

fn read(
    files: &dyn Files,
    (of, file): (Option<Diagonal>, &Option<PathBuf>),
) -> Option<Result<Read, Problems>> {
    let file = file.as_deref()?;
    let read = files.argument(file);
    Some(read.map(|(path, bytes)| (of, path, file_name(file), sha256(&bytes), bytes)))
}

fn as_list((of, path, name, sha256, bytes): &Read) -> List<'_> {
    let file = Measurement { path, name, sha256, bytes };
    (*of, file)
}

/// Fills the form in; `file` is the list of an axis.
pub(super) fn run(
    files: &dyn Files,
    (form, lists): (&Path, &Lists),
    file: &Option<PathBuf>,
    (encoding, stated): (Option<&'static encoding_rs::Encoding>, &Stated),
    output: &Output,
) -> Result<Outcome, Problems> {
    output.ensure_new(files, "the readings")?;
    let (name, bytes) = files.form(form, output.place())?;
    let form = Source::from_bytes(&name, &bytes)?;
    let Lists { ppp, npp, pnp, ppn, .. } = lists;
    let of_diagonals = Diagonal::ALL.map(Some).into_iter().zip([ppp, npp, pnp, ppn]);
    let lists = of_diagonals.chain([(None, file)]).filter_map(|own| read(files, own));
    let lists: Vec<Read> = lists.collect::<Result<_, _>>()?;
    let named: Vec<List<'_>> = lists.iter().map(as_list).collect();
    let text = fill(&form, &named, encoding, stated)?;
    let screen = Screen {
        verdict: "every capture of the form has its value".to_string(),
        ..Screen::default()
    };
    let given = stated.given().into_iter();
    let given = given.map(|(option, value)| (option.to_string(), json!(value)));
    let sources = named.iter();
    let sources = sources.map(|(_, list)| json!({ "path": list.name, "sha256": list.sha256 }));
    let document = json!({
        "schema": 1,
        "format": "list",
        "lists": sources.collect::<Vec<Value>>(),
        "stated": given.collect::<Map<_, _>>(),
    });
    let bytes = Some(Content::Bytes(text.into_bytes()));
    output.deliver(bytes, || screen, || document, "")
}
