//! What is found in the files of a control against a job, and in a second measurement: each kind with its facts, how grave it is, its words.

use crate::control::controller::ControlUnit;
use crate::inputs::job::Frame;
use crate::quantity::{Axis, Direction, ErrorTerm, Figure, MM_PER_INCH, PerAxis, rounded};
use crate::read::emulate::CannotEmulate;
use crate::text::{Finding, findings};
pub(crate) use crate::text::{joined, listed};
use toml::value::Date;

fn frame_word(frame: Option<Frame>) -> &'static str {
    frame.map_or("as given", Frame::word)
}

/// `it` or `them`, for as many as there are.
pub(crate) fn it(count: usize) -> &'static str {
    if count == 1 { "it" } else { "them" }
}

fn limits(axis: &str, held: [f64; 2], own: [f64; 2]) -> String {
    let ([low, high], [from, to]) = (held.map(Figure), own.map(Figure));
    format!(
        "the stored stroke limits 1321 and 1320 of axis {axis} are {low:.3} and {high:.3} mm, the job has the travel {from:.3} to {to:.3} mm"
    )
}

/// Tables whose effect is not known contradict whatever is asked of them.
pub(crate) fn not_emulated(reason: CannotEmulate) -> Finding {
    InControl::NotEmulated { reason: reason.0 }.into()
}

findings! {
    /// What a control holds, or held while measuring. A disagreement contradicts the job; a doubt acts on its
    /// axes and is not emulated.
    InControl {
        NoFile { does: &'static str, data: Vec<String> } => Note, "no file {does}; see to {} on the control", joined(data);
        PassedOver { file: String, count: usize, what: &'static str } => Note, "`{file}`: {count} {what} were ignored";
        NotWritten { parameters: Vec<String> } => Note, "no file holds {}: 0 is assumed", listed(parameters);
        Idle { tables: Vec<String> } => Note, "{}: zeros without a usable grid, ignored", listed(tables);
        NotLoaded { file: String } => Note, "`{file}` is a file of a kit that is not loaded with its tables: ignored";
        OfOthers { what: String, axes: &'static str } => Note, "{what} belongs to {axes} that the job does not have: ignored (under another name? state `id`)";
        SwitchedOff { table: String, by: &'static str } => Note, "{table} is switched off ({by} = 0), so it does nothing";
        OtherSystem { table: String, off: &'static str } => Note, "{table} is for the other measuring system{off}: ignored";
        ProgramsPassedOver { names: String } => Note, "part programs were ignored ({names}), they do nothing before they are run";
        ProgramsCount { names: String } => Note, "part programs ({names}) count as run and active: nothing else was read out";
        ProgramsOnly { names: String } => Doubt, "nothing but part programs was read out ({names}): what they write acts only once they were run, and as long as nothing else was loaded";
        TablesInPrograms { names: String } => Disagreement, "the read-out holds tables in part programs only ({names}), and whether they were run it does not tell";
        SeveralOfOthers { name: String } => Note, "{name}, of others, has several values in the files: ignored";
        LastCounts { name: String } => Note, "{name} has several values in the files: the last of them, by the names of the files and by their lines, counts as active, and the way back leaves it to a person";
        SeveralValues { name: String } => Disagreement, "{name} has several values in the files, so which of them the control holds is not known";
        FileUnit { file: String, unit: &'static str, word: &'static str, own: &'static str } => Disagreement, "`{file}` is written in {unit} (`{word}`), the job counts in {own}";
        ControlUnit { unit: &'static str, own: &'static str } => Disagreement, "the control that was read out counts in {unit}, the job in {own}";
        EitherSystem { table: String, system: u32 } => Doubt, "{table} is for measuring system {system}, and the files do not tell which of the two is active: state `measuring_system`";
        WrongSystem { table: String, system: u32 } => Disagreement, "{table} is for measuring system {system}, and there is none for the one of the job";
        OpenEnd { place: String, point: u32, other: String, by: String } => Doubt, "{place}: the value of point {point} is taken to be held; if {other}, the correction differs {by} there";
        LecNotRead { switches: Vec<String> } => Doubt, "MD32700 $MA_ENC_COMP_ENABLE{} is 1, so an ENC_COMP table acts, and no file holds it", listed(switches);
        CecNotRead { tables: String } => Doubt, "SD41300 $SN_CEC_TABLE_ENABLE of CEC {tables} is 1, and no file holds it";
        CecUnknown { axes: Vec<String> } => Doubt, "MD32710 $MA_CEC_ENABLE of {} is 1, and no file holds a CEC table or SD41300", listed(axes);
        Untold { what: String } => Note, "{what}: no file holds such a table or its switches, so none is taken to act";
        TakenAsOn { facts: Vec<String> } => Note, "no file holds {}: taken to be on", facts.join(", ");
        CutOff { axis: String, limit: f64, sum: f64, unit: &'static str } => Disagreement, "MD32720 of {axis} is {limit} {unit}, and its CEC corrections may add up to {sum:.6} {unit}: what is more is cut off (alarm 20124)";
        CecUnit { axis: String, metric: f64, unit: &'static str } => Disagreement, "MD32711 of {axis} is {metric}, the job has its CEC tables in {unit}";
        MayBeCecUnit { axis: String, metric: f64, unit: &'static str } => Doubt, "MD32711 of {axis} is {metric}, the job has its CEC tables in {unit}; it counts where MD10260 = 1, which no file holds";
        Weight { number: u32, weight: f64 } => Disagreement, "SD41310 $SN_CEC_TABLE_WEIGHT[{number}] is {weight}, expected 1: the table acts with this factor, which is not emulated";
        Factor { table: String, factor: u32 } => Doubt, "{table}, of axes that the job does not have, multiplies by $AN_CEC[{factor}] of the job: whether that one still acts by itself is not known";
        Follows { what: String, moving: String } => Doubt, "{what} follows axis {moving}, which the job does not have: it is not in the forecast, and changes the error wherever {moving} stands elsewhere";
        ReferencePoint { axis: String, position: f64, unit: &'static str, own_mm: f64 } => Doubt, "MD34100 $MA_REFP_SET_POS[0,{axis}] is {position} {unit}, the job has the reference point at {own_mm} mm: with an incremental measuring system the tables are not zero where the axis is referenced";
        Spindle { parameter: String } => Note, "{parameter}: a spindle corrects no axis of the job, ignored";
        Slave { other: u32, axis: u32 } => Note, "axis {other}, which the job does not have, takes the points of axis {axis}, as the slave of a gantry does";
        SharedPoints { other: u32, axis: u32 } => Doubt, "axis {other}, which the job does not have, takes points of axis {axis} in another way than it: it is corrected by errors that are not its own";
        PointsOfNobody { points: usize } => Doubt, "the files hold {points} points and no parameter 3620 to 3624, so which axes they correct is not known";
        CuttingFeed { axis: String, cutting: f64, rapid: f64 } => Note, "axis {axis}: 1851 is {cutting} and 1852 is {rapid}; 1851 (cutting feed) is taken";
        Reference { axis: String, position: f64, unit: &'static str, own_mm: f64 } => Disagreement, "1240 of axis {axis} is {position} {unit}, the job has the reference at {own_mm} mm";
        OtherName { axis: String, code: u32, letter: char, own: Axis } => Disagreement, "1020 of axis {axis} is {code}, which is {letter}; in the job the axis is {own}";
        DetectionUnit { axis: String, cmr: u32, system: &'static str, um: f64, own_um: f64 } => Doubt, "1820 of axis {axis} is {cmr} and 1013 says {system}: a detection unit of {um} µm (from memory); the job states {own_um} µm, so every correction would be {} times as large", rounded(um / own_um, 3);
        TravelBeyond { axis: String, held_mm: [f64; 2], own_mm: [f64; 2] } => Doubt, "{}: the axis does not reach all of it", limits(axis, *held_mm, *own_mm);
        OtherTravel { axis: String, held_mm: [f64; 2], own_mm: [f64; 2] } => Note, "{}", limits(axis, *held_mm, *own_mm);
        HomeOffset { joint: u32, position: f64, unit: &'static str, own_mm: f64 } => Disagreement, "HOME_OFFSET of [JOINT_{joint}] is {position} {unit}, the job has the reference at {own_mm} mm";
        HomeDirection { joint: u32, speed: f64, own: Direction } => Disagreement, "HOME_LATCH_VEL of [JOINT_{joint}] is {speed}, the job has `reference_direction = \"{}\"`", own.symbol();
        SecondTables { axes: Vec<String> } => Doubt, "no file holds 3605 of axis {}, whose bit 0 decides whether values for travel in - (3626, 3627, points) act: read it out with them", axes.join(", ");
        OtherSwitch { bit: usize, axis: String, is: u8, asked: u8, meaning: &'static str } => Disagreement, "3605#{bit} of axis {axis} is {is}, the job is for {asked} (1 = {meaning})";
        RapidDiffers { axis: String, rapid: String, cutting: String } => Doubt, "1852 of axis {axis} is {rapid}, 1851 is {cutting}, and the job asks for the same in both: where the control takes 1852 in rapid traverse, the axis stands elsewhere than forecast after it";
        NoRapid { axis: String } => Note, "no file holds 1852 of axis {axis}: taken as its 1851";
        AsAsked { what: Vec<String> } => Note, "no file holds {}: taken as the job asks, see to the preconditions", what.join(", ");
        GantryDiffers { axes: Vec<String> } => Disagreement, "the axes {} have different backlash parameters", axes.join(", ");
        GantryUnknown { parameter: &'static str, axis: String } => Note, "no file holds the {parameter} of axis {axis}, and that of the other axis of the gantry does not tell it";
        SameSerial { key: &'static str, kit: String, own: String } => Note, "the kit of the active tables has the machine {key} `{kit}`, the job `{own}`; the serial number is the same, so it counts as the same machine";
        FarMore { file: String } => Note, "`{file}` holds far more than a kit: taken as read out of the control, not as to be loaded";
        NoManifest { axis: String, um: String } => Note, "no manifest names the backlash parameter of axis {axis}: taken as the job asks, {um}";
        NoParameter { parameter: &'static str, axis: String, um: String } => Note, "no file holds the {parameter} of axis {axis}: taken as the job asks, {um}";
        Unchanged { parameter: &'static str, axis: String, um: String } => Note, "the {parameter} of axis {axis} is {um}; the job does not set it, so it counts as unchanged since the measurement";
        OtherBacklash { axis: String, who: &'static str, named: String, wanted: String } => Disagreement, "backlash parameter of axis {axis}: {who} {named}, the job asks for {wanted}";
        NotEmulated { reason: String } => Disagreement, "{reason}";
    }
}

impl InControl {
    /// The key of a job that it contradicts, and what the control has for it; `names` = those of the control's axes.
    /// Where a gantry has several, its first counts.
    pub(crate) fn key(&self, names: &PerAxis<Vec<String>>) -> Option<(String, String)> {
        let of = |section: &str, name: &str, key: &str| {
            let own = names.iter().find(|(_, names)| names.first().is_some_and(|own| own == name));
            own.map(|(axis, _)| format!("{section}.axes.{}.{key}", axis.key()))
        };
        let mm = |position: &f64, unit: &str| {
            let is_inch = unit == ControlUnit::Inch.word();
            format!("{:?}", rounded(position * if is_inch { MM_PER_INCH } else { 1.0 }, 6))
        };
        Some(match self {
            Self::ControlUnit { unit, .. } => {
                ("compensation.control_unit".to_string(), format!("\"{unit}\""))
            }
            Self::Reference { axis, position, unit, .. }
            | Self::ReferencePoint { axis, position, unit, .. } => {
                (of("machine", axis, "reference_mm")?, mm(position, unit))
            }
            Self::HomeOffset { joint, position, unit, .. } => {
                (of("machine", &joint.to_string(), "reference_mm")?, mm(position, unit))
            }
            Self::HomeDirection { joint, own, .. } => {
                let word = format!("\"{}\"", own.opposite().symbol());
                (of("machine", &joint.to_string(), "reference_direction")?, word)
            }
            Self::TravelBeyond { axis, held_mm, .. } | Self::OtherTravel { axis, held_mm, .. } => {
                let ends = held_mm.map(|mm| rounded(mm, 6));
                (of("machine", axis, "travel_mm")?, format!("{ends:?}"))
            }
            Self::DetectionUnit { axis, um, .. } => {
                (of("compensation", axis, "detection_unit_um")?, format!("{um:?}"))
            }
            _ => return None,
        })
    }

    /// What to do where old tables are refused for it.
    pub(super) const fn help(&self) -> &'static str {
        match self {
            Self::FileUnit { .. } => {
                "correct `control_unit`, or read the files out again in the basic system of the control"
            }
            Self::TablesInPrograms { .. } => {
                "read out the active data (…_EEC_INI, …_CEC_INI), or name the kit that was loaded"
            }
            Self::SeveralValues { .. } => "name the files of one read-out",
            Self::ControlUnit { .. } => "correct `control_unit`",
            Self::WrongSystem { .. } => {
                "state `measuring_system` in [compensation.axes] as it is active on the control"
            }
            Self::LecNotRead { .. } => {
                "read out the tables too ($AA_ENC_COMP, `AX_EEC.INI`) and name all files together"
            }
            Self::CecNotRead { .. } | Self::CecUnknown { .. } => {
                "read out the tables too ($AN_CEC, `NC_CEC.INI`) and name all files together"
            }
            Self::CecUnit { .. } | Self::MayBeCecUnit { .. } => {
                "state the `control_unit` of the tables, or read out MD10260 = 0 as well"
            }
            Self::PointsOfNobody { .. } => {
                "read out the parameters too (`CNC-PARA.TXT`) and name both files together"
            }
            Self::SecondTables { .. } => {
                "name all parameters of that day, or state `parameter_3605` as it was found"
            }
            Self::Reference { .. } | Self::HomeOffset { .. } => {
                "correct `reference_mm`; tables of another reference cannot be added"
            }
            Self::OtherName { .. } => "correct `id`, or name the files of this machine",
            Self::DetectionUnit { .. } => {
                "correct `detection_unit_um`; where a bump has shown that it is right, leave 1820 out of the files"
            }
            Self::TravelBeyond { .. } => "correct `travel_mm`, or name the files of this machine",
            Self::HomeDirection { .. } => {
                "correct `reference_direction`: the column of this direction is zero at the reference"
            }
            Self::GantryDiffers { .. } => "bring the axes of the gantry to one value first",
            _ => "measure with these tables switched off",
        }
    }
}

findings! {
    /// How files differ from what a job asks for.
    Difference {
        Effect { term: ErrorTerm, base: String, output: String, direction: Option<Direction>, how: String } => Disagreement, "{term} ({output} while {base} moves{}): {how}", direction.map_or_else(String::new, |way| format!(" in {way}"));
        ForeignAxis { base: String, output: String } => Disagreement, "foreign axis: the tables correct {output} while {base} moves, which the job does not ask for";
        ForeignSystem { axis: String, is: u32, asked: u32 } => Disagreement, "foreign measuring system: the ENC_COMP table of {axis} is for system {is}, the job is for {asked}";
        NotWritten { parameters: Vec<String> } => Disagreement, "no file writes {}: the control keeps what it holds there, the job writes {}", listed(parameters), it(parameters.len());
        Surplus { what: String, items: usize } => Disagreement, "{what}: the job does not write {}", it(*items);
        Missing { what: String, items: usize } => Disagreement, "{what}: missing, the job writes {}", it(*items);
        OtherValues { table: String, values: Vec<String> } => Disagreement, "{}{}", if table.is_empty() { String::new() } else { format!("{table}: ") }, values.join("; ");
        SetsMore { file: String, data: Vec<String> } => Disagreement, "`{file}` sets {}: the job does not write {} there", listed(data), it(data.len());
        NotSet { task: &'static str, data: Vec<String>, stands: String } => Disagreement, "{task} {}: {stands}", listed(data);
    }
}

findings! {
    /// What is found while the errors of the machine without tables are made from those with them.
    InSum {
        Dropped { term: ErrorTerm } => Note, "{term}: the active tables correct it, it was not measured, and the new tables do without it (`active_terms_not_measured = \"drop\"`)";
        Kept { term: ErrorTerm } => Note, "{term}: it was not measured; the correction of the active tables is carried over (`active_terms_not_measured = \"keep\"`), and nothing is forecast for it";
        DirectionsKept { term: ErrorTerm } => Note, "{term}: what was active differs with the direction (tables, or the backlash parameter) and the measurement does not tell how; the difference is carried over from it";
        Zeros { tables: String } => Note, "the active tables of {tables} hold zeros: old = 0";
        Interpolated { axes: Vec<String> } => Note, "3605#1 of axis {} was 1 while measuring: the forecast is for interpolated pitch compensation, lines between the points", axes.join(", ");
        Turned { axes: Vec<String> } => Note, "3605#1 of axis {} was not what the job states (`interpolated`) while measuring: the forecast is for what the job states", axes.join(", ");
    }
}

findings! {
    /// What is found in a forecast.
    InForecast {
        Worsened { what: String, before_um: f64, after_um: f64, by_steps: bool } => Note, "{what} becomes larger with the tables: {before_um:.3} → {after_um:.3} µm{}", if *by_steps { ", by the steps between the points; those of the old tables are not in the figure as measured" } else { "" };
    }
}

findings! {
    /// What a term looks like by itself, where no single cause fits all.
    OfTerm {
        AsForecast { term: ErrorTerm } => Note, "{term}: as forecast";
        OffForecast { term: ErrorTerm, off: String, faults: Vec<&'static str> } => Note, "{term}: {off}{}", if faults.is_empty() { "no single fault fits".to_string() } else { faults.join(" or ") };
    }
}

findings! {
    /// What is found in the measurement afterwards. With a doubt the figures decide nothing in favour.
    AsLeft {
        Simulated => Doubt, "the values afterwards were simulated, those as found were measured: a rehearsal says nothing of this machine";
        Flat { what: String } => Doubt, "the values afterwards are the same at all positions, which no laser reads: {what}; an empty column, no measurement";
        Copy => Doubt, "the values afterwards are those of the first measurement: the same file, or a copy of it";
        SameSlopes { axes: Vec<Axis> } => Doubt, "`slope_um_per_m` of {} afterwards is that of the first job to the last digit: a copy, so nothing shows what the tables do there; state what was measured with the tables active", Axis::letters(axes);
        Earlier { first: Date, second: Date } => Doubt, "measured on {second}, before the first measurement ({first}): these tables cannot have been active; correct the `date` that is wrong";
        Sparse { axis: Axis, first_mm: f64, second_mm: f64 } => Doubt, "the target spacing of axis {axis} was {first_mm:.3} mm as found and is up to {second_mm:.3} mm afterwards: the residual between the targets is not known";
        ReversalNotSeen { terms: Vec<ErrorTerm> } => Doubt, "both directions are known as found (measured, or by the backlash that was active) and were not both measured afterwards, so nothing is known of the reversal that is left: {}", joined(terms);
        OtherFrame { first: Option<Frame>, second: Option<Frame> } => Doubt, "the two measurements count from different frames (as found: {}; afterwards: {}): the slopes of their cross terms differ by a rotation that neither measured, so what is off the forecast there, and the causes, may be the frame", frame_word(*first), frame_word(*second);
        OwnFrames => Note, "both measurements count from a frame as measured, which is another one each time: the slopes of their cross terms differ by a rotation that neither measured, so what is off the forecast there, and the causes, may be the frame; `frame = \"x-primary\"` in both jobs tells";
        RestsOn { label: Finding } => Note, "{label}";
        RepeatsBias { what: &'static str, at_most: &'static str } => Note, "the same method repeats its bias: what {what} is the same in both measurements, so that as left agrees with the forecast does not show it; {at_most}";
        LostMotion { reversals_um: Vec<(ErrorTerm, f64)> } => Note, "the first measurement did not tell the directions apart, so it did not see the lost motion, and its tables leave it; B (mean moving + minus mean moving -), µm: {}", joined(reversals_um.iter().map(|(term, um)| format!("{term} {:+.3}", Figure(*um))));
        DiagonalsOnly => Note, "straight runs show the body diagonals only: the nine errors were not measured afterwards";
        OffForecast { terms: Vec<(ErrorTerm, f64, f64)> } => Note, "off the forecast at some position by more than both measurements explain (99.9 %, all positions together): {}", joined(terms.iter().map(|(term, um, u_um)| format!("{term} {um:.3} µm (U = {u_um:.3} µm)")));
    }
}

findings! {
    /// How a file differs from what the manifest beside it lists.
    FileFault {
        Missing { file: String } => Disagreement, "`{file}` is listed in manifest.json but missing";
        Changed { file: String } => Disagreement, "`{file}` was changed after it was made: its hash is not that of manifest.json";
        ListedTwice { file: String } => Disagreement, "`{file}` is listed twice in manifest.json";
        NoPlainName { file: String } => Disagreement, "`{file}` is no plain file name";
        NotReadable { message: String } => Disagreement, "{message}";
    }
}
