//! `--plot FILE`: what a command found, as a picture: in English, mm and µm.

use crate::cli::outcome::{Outcome, ToWrite};
use crate::page::{Locale, Picture, Shown, Texts};
use crate::text::problem::Problems;
use clap::Args;
use std::path::PathBuf;

/// The option of every command that can draw.
#[derive(Args, Debug)]
pub(super) struct Plot {
    /// Also draw it: a picture (SVG)
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

/// The option of a command that writes nothing but the picture.
#[derive(Args, Debug)]
pub(super) struct PlotOnly {
    #[command(flatten)]
    plot: Plot,
    /// Replace the picture that is there
    #[arg(long, requires = "plot")]
    force: bool,
}

impl Plot {
    /// The same outcome with the picture, if one is asked for; drawn only then.
    pub(super) fn beside(
        &self,
        outcome: Outcome,
        force: bool,
        picture: impl FnOnce(Locale<'_>) -> Result<Picture, Problems>,
    ) -> Result<Outcome, Problems> {
        let Some(place) = &self.plot else {
            return Ok(outcome);
        };
        let texts = Texts::english()?;
        let locale = Locale { texts: &texts, shown: Shown::Metric };
        let bytes = picture(locale)?.svg(locale).into_bytes();
        Ok(outcome.writing(ToWrite::File(place.clone(), bytes, force)))
    }
}

impl PlotOnly {
    /// The same outcome with the picture, if one is asked for.
    pub(super) fn beside(
        &self,
        outcome: Outcome,
        picture: impl FnOnce(Locale<'_>) -> Result<Picture, Problems>,
    ) -> Result<Outcome, Problems> {
        self.plot.beside(outcome, self.force, picture)
    }
}
