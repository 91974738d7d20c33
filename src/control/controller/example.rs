//! Examples of a profile: files as a manual prints them or a control wrote them, never as this program writes
//! them, and what the control adds for them. A reader and an emulator that agree with their own writer alone
//! would still read a foreign file wrongly.

use super::fact::ControlUnit;
use crate::control::control_state::{AxisState, ControlState};
use crate::quantity::{Direction, Millimetres};
use crate::text::{Section, Word, section};

section! {
    /// One `[[example]]` of a profile.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Example(section: &Section<'_>) {
        /// The manual with its page, or the control that wrote the files.
        pub source: String = text(), must "the manual with its page, or the control that wrote it";
        /// Unit of the control.
        pub unit: ControlUnit = choice(ControlUnit::WORDS), or ControlUnit::Millimetre;
        /// The files of the control.
        pub files: Vec<ExampleFile> => section.subs("file", ExampleFile::read);
        /// The axes that they name.
        pub axes: Vec<ExampleAxis> => section.subs("axis", ExampleAxis::read);
        /// What the control adds, place by place.
        pub adds: Vec<Added> => {
            section.require("adds", "what the control adds for them");
            section.subs("adds", Added::read)
        };
    }
}

section! {
    /// A file of an example.
    #[derive(Clone, Debug, PartialEq)]
    pub struct ExampleFile(section: &Section<'_>) {
        /// Its name on the control.
        pub path: String = text(), must "the name of the file";
        /// What stands in it.
        pub text: String = text(), must "what stands in the file";
    }
}

section! {
    /// An axis of an example.
    #[derive(Clone, Debug, PartialEq)]
    pub struct ExampleAxis(section: &Section<'_>) {
        /// The control's name of it.
        pub name: String = text(), must "the name of the axis on the control";
        /// Ends of its travel, mm.
        pub travel_mm: [f64; 2] = pair_of_millimetres(), must "its ends, e.g. [0.0, 900.0]";
        /// Its reference point, mm.
        pub reference_mm: f64 = millimetres(), or 0.0;
        /// Direction of its reference return.
        pub reference_direction: Direction = direction(), or Direction::Plus;
        /// Its detection unit, µm.
        pub detection_unit_um: Option<f64> = positive();
    }
}

section! {
    /// What an axis gets at a place.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Added(section: &Section<'_>) {
        /// The axis that is corrected.
        pub axis: String = text(), must "the axis that is corrected";
        /// The axis that stands there; its own position where it is not stated.
        pub by: Option<String> = text();
        /// Where, mm in machine coordinates.
        pub at_mm: f64 = millimetres(), must "where, mm";
        /// Coming in which direction; `None` = both.
        pub moving: Option<Direction> = direction();
        /// How far the control moves it further in +, µm.
        pub um: f64 = number(), must "what the control adds, µm";
    }
}

impl Example {
    /// The control of the example, without its files.
    pub(crate) fn state(&self) -> ControlState {
        let axis = |own: &ExampleAxis| {
            let [low, high] = own.travel_mm;
            let reference = own.reference_mm;
            let ends = [low, high].map(Millimetres::new);
            let reach = [low.min(reference), high.max(reference)].map(Millimetres::new);
            AxisState {
                name: own.name.clone(),
                reference: Millimetres::new(reference),
                reference_direction: own.reference_direction,
                detection_unit_um: own.detection_unit_um,
                backlash_um: 0.0,
                bidirectional: false,
                interpolated: false,
                travel: reach.into(),
                ends: ends.into(),
                rest: Millimetres::new(reference),
            }
        };
        ControlState { unit: self.unit, axes: self.axes.iter().map(axis).collect() }
    }
}
