//! What the user states because the file does not carry it.

use crate::inputs::import::choices::{
    Decimal, MaterialCorrected, Rows, Runs, Sign, Travel, Values,
};
use crate::inputs::import::{Component, Kind};
use crate::quantity::axis::{Axis, Direction};
use crate::text::delimited::LengthUnit;
use crate::text::problem::{Problem, Problems};

/// What was stated on the command line; `None` = nothing.
#[derive(Clone, Debug, Default)]
pub struct Stated {
    /// `--axis`: the moving axis.
    pub axis: Option<Axis>,
    /// `--term`: which component was measured.
    pub term: Option<Component>,
    /// `--first-target-at-mm`: machine coordinate of the first target.
    pub first_target_at_mm: Option<f64>,
    /// `--targets-run`: the way of the axis from the first target to the last.
    pub targets_run: Option<Direction>,
    /// `--direction`: travel of rows without one.
    pub travel: Option<Travel>,
    /// `--sign`: what the values mean.
    pub sign: Option<Sign>,
    /// `--plus-moves`: the way of the axis in rows whose direction is `+`.
    pub plus_moves: Option<Direction>,
    /// `--unit`: of the values.
    pub unit: Option<LengthUnit>,
    /// `--values`: absolute or incremental.
    pub values: Option<Values>,
    /// `--runs`: how they were travelled.
    pub runs: Option<Runs>,
    /// `--rows`: which table of the file.
    pub rows: Option<Rows>,
    /// `--material-corrected`: whether the instrument took the expansion of the material out.
    pub material_corrected: Option<MaterialCorrected>,
    /// `--decimal`: the sign before the decimals.
    pub decimal: Option<Decimal>,
    /// `--columns`: `NAME=COLUMN,…`.
    pub columns: Option<String>,
}

impl Stated {
    /// Every option with its value, in a fixed order.
    pub fn given(&self) -> Vec<(&'static str, String)> {
        let text = |word: &str| word.to_string();
        let all = [
            (
                "--columns",
                self.columns.as_ref().map(|c| format!("\"{c}\"")),
            ),
            ("--axis", self.axis.map(|a| text(a.key()))),
            ("--term", self.term.map(|t| t.to_string())),
            (
                "--first-target-at-mm",
                self.first_target_at_mm.map(|mm| format!("{}", mm + 0.0)),
            ),
            ("--targets-run", self.targets_run.map(|d| text(d.symbol()))),
            ("--direction", self.travel.map(|t| text(t.word()))),
            ("--plus-moves", self.plus_moves.map(|d| text(d.symbol()))),
            ("--sign", self.sign.map(|s| text(s.word()))),
            ("--unit", self.unit.map(|u| text(u.word()))),
            ("--values", self.values.map(|v| text(v.word()))),
            ("--runs", self.runs.map(|r| text(r.word()))),
            ("--rows", self.rows.map(|r| text(r.word()))),
            (
                "--material-corrected",
                self.material_corrected.map(|m| text(m.word())),
            ),
            ("--decimal", self.decimal.map(|d| text(d.word()))),
        ];
        let given = all.into_iter();
        given
            .filter_map(|(option, value)| Some((option, value?)))
            .collect()
    }

    /// A statement that has no meaning for the format is a mistake of the user.
    pub(super) fn foreign_to(&self, format: &str, takes: &[&str]) -> Problems {
        let mut problems = Problems::none();
        for (option, _) in self.given() {
            if !takes.contains(&option) {
                problems.push(
                    Problem::new(format!("`{option}` has no meaning for format `{format}`")).help(
                        format!("leave it out; `{format}` takes {}", takes.join(", ")),
                    ),
                );
            }
        }
        problems
    }

    /// The sign, or the problem that it is missing.
    pub(super) fn required_sign(&self, problems: &mut Problems) -> Option<Sign> {
        if self.sign.is_none() {
            problems.push(missing(
                "--sign",
                "the file does not say whether its values are deviations or corrections",
                "add `--sign as-error` (measured - target) or `--sign as-correction` (what has to be added)",
            ));
        }
        self.sign
    }

    /// The component, whose axis must be that of `--axis`.
    pub(super) fn required_term(&self, problems: &mut Problems) -> Option<Component> {
        let Some(term) = self.term else {
            problems.push(missing(
                "--term",
                "the file does not say which deviation was measured",
                "add e.g. `--term EXX` (positioning of X) or `--term EYX` (deviation in Y while X moves)",
            ));
            return None;
        };
        if let Some(axis) = self.axis.filter(|axis| *axis != term.along) {
            problems.push(
                Problem::new(format!(
                    "`--axis {}` contradicts `--term {term}`, in which {} moves",
                    axis.key(),
                    term.along
                ))
                .help("the last letter of a term is the moving axis"),
            );
        }
        Some(term)
    }

    /// The component, which must be a deviation: a file of lengths holds no angles.
    pub(super) fn required_deviation(&self, problems: &mut Problems) -> Option<Component> {
        let term = self.required_term(problems)?;
        if let Kind::Angle(_) = term.kind {
            problems.push(
                Problem::new(format!(
                    "`--term {term}` is an angle, but the file holds lengths"
                ))
                .help("state one of EXX, EYX, EZX, EXY, EYY, EZY, EXZ, EYZ, EZZ"),
            );
        }
        Some(term)
    }
}

/// A statement that the file cannot do without.
pub(super) fn missing(option: &str, why: &str, help: &str) -> Problem {
    Problem::new(format!("`{option}` is not stated: {why}")).help(help)
}
