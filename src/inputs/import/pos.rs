//! API XD Laser position export (`.pos`), linear.
//!
//! ```text
//!   API X-D Laser Measurement Linear Data Table …
//!   TestAxis: (X)   Unit: inch   RunNum: 1   NumofPos: 27   TestType: Unidirection
//!   Position  LasRead  LinearError  Status  AirTemp  AirPress  MatTemp …   ← what was measured
//!   API Linear Error Compensation Table
//!   Position  Unidirectional Avg Error                                    ← what the maker made of it
//! ```
//! The measured rows are used. Error = ± reading − position holds in each of them, which shows that
//! the values are measured − target. The maker's averages are the same to the seventh digit of the
//! position; where they are not, the file was edited, and `--rows` says which to take.
//! docs/import.md §6 names the sources.

use crate::inputs::error_table::DraftSeries;
use crate::inputs::import::choices::{MaterialCorrected, Rows, Sign};
use crate::inputs::import::placing::{Placing, freedom_remark, mean, pooled};
use crate::inputs::import::pos_header::Header;
use crate::inputs::import::pos_rows::{Averages, Measured, Passes, Relation};
use crate::inputs::import::stated::{Stated, missing};
use crate::inputs::import::{Component, Reading};
use crate::quantity::axis::Direction;
use crate::text::delimited::LengthUnit;
use crate::text::document::Source;
use crate::text::problem::{Place, Problem, Problems, shown};

pub(super) fn read(source: &Source, stated: &Stated) -> Result<Reading, Problems> {
    let mut problems = Problems::none();
    let header = Header::of(source)?;
    header.check(&mut problems);
    let term = required_positioning(stated, &mut problems);
    let sign = stated.required_sign(&mut problems);
    let axis = axis_words(&header, stated, &mut problems);
    let unit = header.unit("unit", "Unit", &mut problems);
    let measured = problems.take(Measured::read(source));
    let averages = problems.take(Averages::read(source));
    let (Some(measured), Some(averages)) = (measured, averages) else {
        return Err(problems);
    };
    let air = material_words(&measured, stated, &mut problems);
    let taken = taken(&header, &measured, averages.as_ref(), stated, &mut problems);
    let (Some(unit), Some(taken)) = (unit, taken) else {
        return Err(problems);
    };
    let targets: Vec<f64> = taken
        .targets
        .iter()
        .map(|target| target * unit.um() / LengthUnit::Mm.um())
        .collect();
    let placing = Placing::of(&targets, &taken.place, stated, &mut problems);
    let error_unit = taken.error_unit(&header, unit, &mut problems);
    let (Some(term), Some(sign), Some(placing), Some(error_unit)) =
        (term, sign, placing, error_unit)
    else {
        return Err(problems);
    };
    taken.refuse_sign(sign, &mut problems);
    let (axis_facts, mut warnings) = axis;
    let mut facts = header.facts();
    facts.extend(axis_facts);
    facts.extend(taken.words(&measured, (unit, error_unit), (term, &placing)));
    warnings.extend(header.version_warning());
    warnings.extend(taken.warnings.iter().cloned());
    warnings.extend(air);
    problems.or_ok(Reading {
        series: taken.series(term, sign, error_unit, &placing),
        facts,
        warnings,
        ..Reading::default()
    })
}

fn required_positioning(stated: &Stated, problems: &mut Problems) -> Option<Component> {
    let term = stated.required_term(problems)?;
    if !term.is_positioning() {
        problems.push(
            Problem::new(format!(
                "`--term {term}` is no positioning, but a linear file (`pos`) holds one"
            ))
            .help("state EXX, EYY or EZZ, or take the right file"),
        );
    }
    Some(term)
}

/// The rows that become the table, in the file's unit.
struct Taken {
    place: Place,
    targets: Vec<f64>,
    /// Values of each pass from the first target to the last, in the order of the targets.
    forward: Vec<Vec<f64>>,
    /// Values of each pass back, in the order of the targets.
    reverse: Vec<Vec<f64>>,
    relation: Option<Relation>,
    is_averages: bool,
    facts: Vec<String>,
    warnings: Vec<String>,
}

/// Which rows are taken: the measured ones, unless the averages are asked for.
fn taken(
    header: &Header<'_>,
    measured: &Measured<'_>,
    averages: Option<&Averages<'_>>,
    stated: &Stated,
    problems: &mut Problems,
) -> Option<Taken> {
    if stated.rows == Some(Rows::Averages) {
        return of_averages(measured, averages, problems);
    }
    let before = problems.iter().count();
    let relation = measured.relation(problems);
    measured.refuse_bad_status(problems);
    header.compare_ends(measured, problems);
    let passes = measured.passes(header, problems)?;
    if problems.iter().count() > before {
        return None;
    }
    let difference = averages.and_then(|averages| averages.difference(&passes));
    let mut warnings: Vec<String> = measured.warm_up().into_iter().collect();
    if let Some((words, place)) = difference {
        if stated.rows.is_none() {
            problems.push(
                missing(
                    "--rows",
                    &format!("the maker's averages are not those of the measured rows: {words}"),
                    "add `--rows measured`, or `--rows averages` if they were changed on purpose",
                )
                .at(place),
            );
            return None;
        }
        warnings.push(format!(
            "the maker's averages are not those of the measured rows ({words}), so the file was edited; the measured rows were taken"
        ));
    }
    Some(of_measured(measured, passes, relation, warnings))
}

fn of_measured(
    measured: &Measured<'_>,
    passes: Passes,
    relation: Option<Relation>,
    warnings: Vec<String>,
) -> Taken {
    let facts = relation.map(|relation| {
        format!(
            "values: in every row LinearError = {} − Position, so they are measured − target as the file counts",
            relation.word()
        )
    });
    Taken {
        place: measured.place(),
        targets: passes.targets,
        forward: passes.forward,
        reverse: passes.reverse,
        relation,
        is_averages: false,
        facts: facts.into_iter().collect(),
        warnings,
    }
}

/// The maker's averages, as stated; what does not go with the measured rows is said.
fn of_averages(
    measured: &Measured<'_>,
    averages: Option<&Averages<'_>>,
    problems: &mut Problems,
) -> Option<Taken> {
    let Some(averages) = averages else {
        problems.push(
            Problem::new("`--rows averages` is stated, but the file holds no table `Unidirectional Avg Error`")
                .at(measured.place())
                .help("leave `--rows` out"),
        );
        return None;
    };
    let alone = averages.without_row(measured);
    let warning = (alone > 0).then(|| {
        format!(
            "the maker's averages were taken: {alone} of their {} positions stand in none of the {} measured rows, so the file was edited; nothing shows that the values there were measured",
            averages.targets.len(),
            measured.rows.len()
        )
    });
    Some(Taken {
        place: averages.place.clone(),
        targets: averages.targets.clone(),
        forward: vec![averages.values.clone()],
        reverse: Vec::new(),
        relation: None,
        is_averages: true,
        facts: vec![
            "rows: the maker's averages (`API Linear Error Compensation Table`)".to_string(),
        ],
        warnings: warning.into_iter().collect(),
    })
}

impl Taken {
    /// Rows that hold reading and position show what the values are.
    fn refuse_sign(&self, sign: Sign, problems: &mut Problems) {
        if let (Some(relation), Sign::AsCorrection) = (self.relation, sign) {
            problems.push(
                Problem::new(format!(
                    "`--sign as-correction` contradicts the file: in every row LinearError = {} − Position, measured − target",
                    relation.word()
                ))
                .at(self.place.clone())
                .help("state `--sign as-error`"),
            );
        }
    }

    /// Measured errors have the unit of reading and position, from which they follow.
    fn error_unit(
        &self,
        header: &Header<'_>,
        unit: LengthUnit,
        problems: &mut Problems,
    ) -> Option<LengthUnit> {
        match self.is_averages {
            true => header.unit("errorunit", "ErrorUnit", problems),
            false => Some(unit),
        }
    }

    /// Unit, values, surroundings, places and runs.
    fn words(
        &self,
        measured: &Measured<'_>,
        (unit, error_unit): (LengthUnit, LengthUnit),
        (term, placing): (Component, &Placing),
    ) -> Vec<String> {
        let (position, value) = (unit.word(), error_unit.word());
        let mut words = vec![format!(
            "unit of the positions: {position}; of the values: {value}"
        )];
        words.extend(self.facts.iter().cloned());
        words.extend(measured.surroundings());
        words.extend(placing.words());
        words.extend(placing.sense_words(term));
        words.extend(self.passes_words(placing));
        let runs = self.forward.len();
        let targets = self.forward.first().map_or(0, Vec::len);
        words.extend(freedom_remark(targets, runs).filter(|_| !self.is_averages));
        words
    }

    fn passes_words(&self, placing: &Placing) -> Option<String> {
        let of = |passes: &[Vec<f64>], direction: Direction| {
            (!passes.is_empty()).then(|| format!("{} moving {direction}", passes.len()))
        };
        let counts = [
            of(&self.forward, placing.run),
            of(&self.reverse, placing.run.opposite()),
        ];
        let counts: Vec<String> = counts.into_iter().flatten().collect();
        let u = match self.forward.len() {
            1 => "one run tells nothing about the uncertainty",
            _ => "mean of each direction, u = s/√runs (k = 1)",
        };
        (!self.is_averages).then(|| format!("runs: {}; {u}", counts.join(", ")))
    }

    fn series(
        &self,
        term: Component,
        sign: Sign,
        unit: LengthUnit,
        placing: &Placing,
    ) -> Vec<DraftSeries> {
        let ways = [
            (&self.forward, placing.run),
            (&self.reverse, placing.run.opposite()),
        ];
        let made = ways.into_iter().filter(|(passes, _)| !passes.is_empty());
        let mut series: Vec<DraftSeries> = made
            .map(|(passes, direction)| one_series(passes, direction, (term, sign, unit), placing))
            .collect();
        series.sort_by_key(|series| series.direction);
        series
    }
}

fn one_series(
    passes: &[Vec<f64>],
    direction: Direction,
    (term, sign, unit): (Component, Sign, LengthUnit),
    placing: &Placing,
) -> DraftSeries {
    let count = passes.first().map_or(0, Vec::len);
    let figures: Vec<(f64, Option<f64>)> = (0..count)
        .map(|target| {
            let um = passes.iter().filter_map(|pass| pass.get(target));
            mean(&um.map(|value| value * unit.um()).collect::<Vec<f64>>())
        })
        .collect();
    let means: Vec<f64> = figures.iter().map(|(mean, _)| *mean).collect();
    let spread: Option<Vec<f64>> = figures.iter().map(|(_, u)| *u).collect();
    let mut series = DraftSeries::new(term.along, Some(direction), placing.positions_mm());
    term.put(&mut series, placing.deviations(&means, term, sign));
    series.uncertainties_um[term.along] = spread.map(|u| placing.uncertainties(&pooled(&u)));
    series
}

/// The axis that the file names. Operators leave it as it was, so `--axis` may state another one,
/// which is said: facts and warnings.
fn axis_words(
    header: &Header<'_>,
    stated: &Stated,
    problems: &mut Problems,
) -> (Vec<String>, Vec<String>) {
    let Some(word) = header.value("testaxis") else {
        return Default::default();
    };
    let said = format!("the file says: TestAxis: {}", shown(word.text));
    let named = word.text.trim_matches(['(', ')', ' ']).to_uppercase();
    let other = stated.term.map(|term| term.along);
    let Some(other) = other.filter(|axis| axis.letter().to_string() != named) else {
        return (vec![said], Vec::new());
    };
    if stated.axis == Some(other) {
        let warning = format!(
            "the file names axis {}, but {other} was stated as the moving axis (`--axis`): make sure that this is the file of {other}",
            shown(word.text)
        );
        return (vec![said], vec![warning]);
    }
    problems.push(
        Problem::new(format!(
            "the file names axis `{}`, but {other} was stated as the moving axis",
            shown(word.text)
        ))
        .at(word.place())
        .help(format!(
            "take the file of {other}; if the entry was only left as it was, add `--axis {}`",
            other.key()
        )),
    );
    Default::default()
}

/// Whether the expansion of the material was taken out does not stand in the file, nor the unit of
/// its temperatures.
fn material_words(
    measured: &Measured<'_>,
    stated: &Stated,
    problems: &mut Problems,
) -> Option<String> {
    let (name, shown_values) = measured.material()?;
    match stated.material_corrected {
        Some(MaterialCorrected::Yes) => None,
        Some(corrected) => Some(format!(
            "{}: the file notes {name} {shown_values} without a unit; at another temperature than 20 °C this table is not valid",
            match corrected {
                MaterialCorrected::No => "the expansion of the material is still in the deviations",
                _ => "whether the expansion of the material is in the deviations is not stated",
            }
        )),
        None => {
            problems.push(
                missing(
                    "--material-corrected",
                    &format!("the file notes a temperature of the material ({name} {shown_values}), but not whether the readings were brought to 20 °C"),
                    "add `--material-corrected yes` (the instrument did it), `no`, or `not-stated`",
                )
                .at(measured.place()),
            );
            None
        }
    }
}
