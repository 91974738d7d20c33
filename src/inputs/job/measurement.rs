//! `[measurement]`: what was measured, and with which compensation.

use crate::inputs::error_table::Sizes;
use crate::inputs::findings::Remark;
use crate::inputs::job::diagonals::DiagonalMeasurement;
use crate::inputs::job::machine::Axes;
use crate::inputs::refusals;
use crate::quantity::{Axis, ErrorTerm, Millimetres, PerAxis, PerDiagonal, PerTerm, Plane};
use crate::text::{Finding, Section, Word, section, words};
use toml::value::{Date, Datetime};

/// Whether a compensation was active while measuring.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ActiveTables {
    /// `"none"`: the machine was measured without compensation.
    None,
    /// The job does not say; warned about in every output.
    NotStated,
    /// Path of a kit, or of files read out of the control, relative to the job.
    Path(String),
}

words! {
    /// What becomes of a term that the active tables correct and that was not measured.
    pub enum NotMeasured {
        /// Its correction is carried over into the new tables.
        Keep = "keep",
        /// The new tables do without it; the old table has to be switched off.
        Drop = "drop",
    }
}

section! {
    /// What the job says to the active tables beyond their path.
    #[derive(Clone, Debug, Default, PartialEq)]
    pub struct ActiveSettings(section: &Section<'_>) {
        /// or "drop": what becomes of terms that the active tables correct and that were not measured; no default
        pub not_measured as active_terms_not_measured: Option<NotMeasured> =
            choice(NotMeasured::WORDS);
        /// or "rezero": the value of an active table at the reference is taken off; default "same"
        pub rezero as active_reference: bool =
            choice(&[("same", false), ("rezero", true)]), or false;
        /// backlash parameter of each axis while measuring, µm, where no file holds it or no table was active;
        /// positive = ordinary lost motion; likewise y, z
        pub backlash_um as active_backlash_um: PerAxis<Option<f64>> =
            axes(|s, axis| s.number(axis.key()));
    }
}

/// Scale of the laser that counts where the job of readings states none, 10⁻⁶ (k = 1).
const LASER_PPM: f64 = 0.5;
/// Angle of the beam that counts where the job states none, mrad: a spot 1 mm off at 1 m.
const BEAM_MRAD: f64 = 1.0;

/// An error of a screw, gear or scale has one sign at a target and may have the other between two.
const BOTH_SIDES: f64 = 2.0;

section! {
    /// `[measurement.uncertainty]`: standard uncertainties (k = 1).
    #[derive(Clone, Copy, Debug, PartialEq, Default)]
    pub struct StatedUncertainty(section: &Section<'_>) {
        /// scatter of a single reading (k = 1)
        pub noise_um: Option<f64> = not_negative();
        /// scale of the laser (wavelength, air), 10⁻⁶
        pub laser_ppm: Option<f64> = not_negative();
        /// of the scales, K
        pub temperature_k: Option<f64> = not_negative();
        /// of the coefficient of expansion, 1/K
        pub alpha_per_k: Option<f64> = not_negative();
        /// change of scale between set-ups (k = 1): 0.2 K x 11.5 = 2.3 unless the scales are compensated
        pub setup_ppm: Option<f64> = not_negative();
        /// amplitude of errors that repeat between the targets (screw, gear, scale), where known
        pub periodic_um: Option<f64> = not_negative();
        // Of each that was not measured: a straight part and a bow about its value in the middle of the box, each within
        // half of this.
        /// how far pitch, yaw and roll of an axis go over the box: 5 to 20 on a machining centre (maker's sheet, level,
        /// autocollimator)
        pub angle_urad: Option<f64> = not_negative();
        /// bound on the angle between the beam and the mirror's normal (straight runs: and the diagonal)
        pub beam_mrad: Option<f64> = not_negative();
        /// tilt of the mirror in each direction across the diagonal, with setup = "assume-perfect"
        pub tilt_arcsec: Option<f64> = not_negative();
    }
}

impl StatedUncertainty {
    /// Scale of the laser behind readings, 10⁻⁶: as stated, else a usual one.
    pub(crate) fn of_laser_ppm(&self) -> f64 {
        self.laser_ppm.unwrap_or(LASER_PPM)
    }

    /// How far an error may leave the curve through its targets between two of them, µm; 0 = not stated.
    pub(crate) fn between_um(&self) -> f64 {
        BOTH_SIDES * self.periodic_um.unwrap_or(0.0)
    }

    /// The same of each error, and of max − min along the diagonals, where the positioning of three axes adds up: the sum
    /// of three direction cosines is at most √3.
    pub(crate) fn between(&self) -> Sizes {
        let um = self.between_um();
        Sizes {
            terms: PerTerm::from_fn(|_| um),
            diagonals: PerDiagonal::from_fn(|_| 3.0_f64.sqrt() * um),
        }
    }

    /// Angle of the beam, mrad: as stated, else a usual one.
    pub(crate) fn of_beam_mrad(&self) -> f64 {
        self.beam_mrad.unwrap_or(BEAM_MRAD)
    }

    /// Of a length read in one set-up, 10⁻⁶: laser, what changes from one set-up to the next, beam.
    pub(crate) fn of_length_ppm(&self) -> f64 {
        self.of_laser_ppm().hypot(self.setup_ppm.unwrap_or(0.0)).hypot(self.beam_ppm())
    }

    /// What the beam may take off every length, 10⁻⁶: 1 − cos of its angle. All of it counts as a
    /// standard uncertainty: it has one sign and stays in the readings.
    pub(crate) fn beam_ppm(&self) -> f64 {
        self.of_beam_mrad() * self.of_beam_mrad() / 2.0
    }
}

section! {
    /// Places that the lever arms of angular errors are counted from; machine coordinates, `None` =
    /// not stated.
    #[derive(Clone, Copy, Debug, PartialEq, Default)]
    pub struct Levers(section: &Section<'_>) {
        /// where the axes rested while the others were measured; angles only
        pub offsets as offsets_mm: PerAxis<Option<Millimetres>> = some_places();
        /// from the measured point to the tool point; all three
        pub tool as tool_offset_mm: Option<PerAxis<Millimetres>> = place();
        /// assess, path: where the angles of an axis count as zero
        pub angles_zero as angles_zero_mm: PerAxis<Option<Millimetres>> = some_places();
        /// assess, path: place of the optic on a table that carries the workpiece; absent: it was measured at the tool point
        pub straightness_optic as straightness_optic_mm: PerAxis<Option<Millimetres>> =
            some_places();
    }
}

impl Levers {
    /// What is not stated of them where the nine errors are those of these lines: levers count from the lines, and an
    /// angle is zero where its axis stands on them, since a constant angle is squareness there.
    pub(crate) fn or_lines(&mut self, lines: PerAxis<Millimetres>) {
        for axis in Axis::ALL {
            self.offsets[axis] = self.offsets[axis].or(Some(lines[axis]));
            self.angles_zero[axis] = self.angles_zero[axis].or(self.offsets[axis]);
        }
    }

    /// Where the levers of the angles count from: the stated `offsets_mm`, else the reference
    /// (machine zero of an axis that the job does not have). One rule for everyone: curves that
    /// were separated with one origin and judged with another are those of no machine.
    pub fn origin(&self, axes: &Axes) -> PerAxis<f64> {
        PerAxis::from_fn(|axis| {
            let place = self.offsets[axis].or(axes[axis].map(|machine| machine.reference));
            place.map_or(0.0, Millimetres::mm)
        })
    }
}

/// Where the nine errors come from.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "there is one of them in a job")]
pub enum MeasuredData {
    /// Error tables, which are merged into one: their paths, relative to the job.
    Errors(Vec<String>),
    /// Readings of the body diagonals, which are separated first.
    Diagonals(DiagonalMeasurement),
}

section! {
    /// What was measured.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Measurement(section: &Section<'_>, axes: &Axes) {
        /// The error table, or the readings.
        pub data: MeasuredData => data(section, axes), must;
        /// ea_, eb_, ec_ columns of section 2.1; optional
        pub angles: Option<String> = text();
        /// What the lever arms of the angular errors are counted from.
        pub levers: Levers => levers(section, data.as_ref().filter(|_| angles.is_some())), must;
        /// "none", or the folder with the compensation that was active, read out of the control
        pub active as active_while_measuring: ActiveTables = with(active);
        /// of the measurement, e.g. "2026-11-20"
        pub date: Option<String> = with(date);
        /// serial number of the laser: the second measurement repeats the error of its scale, if it is made with the same
        /// one
        pub instrument: Option<String> = plain_text();
        /// What the job says to it.
        pub active_settings: ActiveSettings => active_settings(section, &active), must;
        /// where the slopes of the cross terms do not contain it: needed there (section 2.1), nowhere else
        pub squareness as squareness_um_per_m: Vec<(ErrorTerm, f64)> = with(squareness);
        /// any keys with texts or numbers; kept in manifest.json
        pub protocol: Vec<(String, String)> = entries();
        /// k = 1; all optional
        pub uncertainty: StatedUncertainty = sub_or_usual(StatedUncertainty::read), must;
    }
}

impl Measurement {
    /// How the diagonals were measured; `None` = there are error tables.
    pub(crate) const fn diagonals(&self) -> Option<&DiagonalMeasurement> {
        match &self.data {
            MeasuredData::Diagonals(how) => Some(how),
            MeasuredData::Errors(_) => None,
        }
    }

    /// Keys of `[measurement.uncertainty]` that are stated and count in no figure: those that only
    /// readings of the diagonals have a use for.
    pub(crate) fn unused_keys(&self) -> Vec<&'static str> {
        let stated = &self.uncertainty;
        let all = [
            ("temperature_k", stated.temperature_k),
            ("alpha_per_k", stated.alpha_per_k),
            ("setup_ppm", stated.setup_ppm),
            ("angle_urad", stated.angle_urad),
            ("beam_mrad", stated.beam_mrad),
            ("tilt_arcsec", stated.tilt_arcsec),
        ];
        let is_table = matches!(self.data, MeasuredData::Errors(_));
        let unused = all.into_iter().filter(|(_, value)| is_table && value.is_some());
        unused.map(|(key, _)| key).collect()
    }

    /// What every output has to say of the measurement: what is stated and not used, one sentence each.
    pub(crate) fn notes(&self) -> Vec<Finding> {
        self.unused_keys().into_iter().map(|key| Remark::NotUsed { key }.into()).collect()
    }
}

/// What the section says, or the middle of the box of readings, of which angles are taken off.
fn levers(section: &Section<'_>, data: Option<&MeasuredData>) -> Option<Levers> {
    let mut levers = Levers::read(section)?;
    if let Some(MeasuredData::Diagonals(measured)) = data {
        levers.or_lines(measured.volume.middle());
    }
    Some(levers)
}

fn active(section: &Section<'_>, key: &'static str) -> ActiveTables {
    match section.text(key).as_deref() {
        None => ActiveTables::NotStated,
        Some("none") => ActiveTables::None,
        Some(path) => ActiveTables::Path(path.to_string()),
    }
}

fn active_settings(section: &Section<'_>, active: &ActiveTables) -> Option<ActiveSettings> {
    let is_named = matches!(active, ActiveTables::Path(_));
    let path = "`active_while_measuring = \"PATH\"`";
    section.only_with("active_terms_not_measured", is_named, path);
    section.only_with("active_reference", is_named, path);
    let is_stated = section.has("active_while_measuring"); // or is to be filled in
    section.only_with("active_backlash_um", is_stated, "`active_while_measuring = …`");
    ActiveSettings::read(section)
}

/// Exactly one of `errors` and `readings`.
fn data(section: &Section<'_>, axes: &Axes) -> Option<MeasuredData> {
    let errors = error_tables(section);
    let readings = section.text("readings");
    let has_readings = section.has("readings");
    let help = "keep `readings` to separate them now, or `errors` if they are separated already";
    section.not_both("readings", "errors", help);
    if section.has("errors") {
        section.only_with("step_diagonal", has_readings, "`readings`");
        return errors.map(MeasuredData::Errors);
    }
    if has_readings {
        section.required_section("step_diagonal");
    } else if section.has("step_diagonal") {
        let described = "the path of the readings that [measurement.step_diagonal] describes";
        section.require("readings", described);
    } else {
        let either = "the path of an error table (or `readings` of the body diagonals)";
        section.require("errors", either);
    }
    let readings = readings.unwrap_or_default();
    let measured =
        section.sub("step_diagonal", |how| DiagonalMeasurement::read(how, axes, readings));
    measured.map(MeasuredData::Diagonals)
}

/// The tables that the section names: of errors, of readings.
pub(super) fn tables(section: &Section<'_>) -> (Vec<String>, Option<String>) {
    (error_tables(section).unwrap_or_default(), section.text("readings"))
}

/// The path of an error table, or a list of them.
fn error_tables(section: &Section<'_>) -> Option<Vec<String>> {
    if !section.is_list("errors") {
        return section.text("errors").map(|path| vec![path]);
    }
    let paths = section.texts("errors")?;
    if paths.is_empty() {
        section.refuse("errors", refusals::no_error_tables());
    }
    Some(paths)
}

/// A date that is written as 2026-11-24: such dates have an order.
pub(crate) fn day(date: Option<&String>) -> Option<Date> {
    date?.parse::<Datetime>().ok()?.date
}

/// What is written like a day has to be one of the calendar.
fn date(section: &Section<'_>, key: &'static str) -> Option<String> {
    let date = section.plain_text(key)?;
    if date.split('-').map(str::len).eq([4, 2, 2]) && day(Some(&date)).is_none() {
        section.refuse(key, refusals::no_day(&date));
    }
    Some(date)
}

fn squareness(measurement: &Section<'_>, key: &'static str) -> Vec<(ErrorTerm, f64)> {
    let is_table = !measurement.has("readings");
    measurement.only_with(key, is_table, "`errors`"); // readings measure the squareness themselves
    let read = |section: &Section<'_>| {
        let given = Plane::ALL.into_iter();
        Some(given.filter_map(|own| Some((own.carrier(), section.number(own.key())?))).collect())
    };
    measurement.sub(key, read).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use crate::inputs::job::Job;
    use crate::text::Source;

    const PAGE: &str = r#"
schema = 1
[machine]
name = "VMC"
[measurement]
errors = "errors.csv"
angles = "angles.csv"
offsets_mm = { x = 1.0, y = 2.0, z = 3.0 }
[measurement.uncertainty]
noise_um = 0.5
laser_ppm = 0.1
temperature_k = 0.3
[compensation]
controller = "generic"
"#;

    #[test]
    fn what_is_stated_and_not_used_is_named() {
        let source = Source::from_bytes("job.toml", PAGE.as_bytes()).expect("it is text");
        let measurement = Job::read(source).expect("it is a job").measurement;
        assert_eq!(measurement.uncertainty.noise_um, Some(0.5));
        let key = "temperature_k";
        let noted = crate::inputs::findings::Remark::NotUsed { key };
        assert_eq!(measurement.notes(), [noted.into()]);
    }
}
