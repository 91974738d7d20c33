//! Quantities with their unit and their sign in the type.
//!
//! Two units live inside the program: positions in millimetres, deviations in micrometres.
//! A [`Deviation`] is what the machine does wrong (actual − commanded, ISO 230-1); a
//! [`Correction`] is what a control must add to the command. **The only place in the program
//! where one turns into the other is the minus sign at the end of this page**; every table
//! value, forecast and report goes through it. Which of the two a *control's table* holds is a
//! fact of its profile, see [`crate::controller::TableSign`].

use std::ops::{Add, Neg, Sub};

/// Millimetres in one inch, exactly (contract §1).
pub const MM_PER_INCH: f64 = 25.4;
/// Micrometres in one millimetre.
pub const UM_PER_MM: f64 = 1000.0;

/// A position on an axis, machine coordinates, or a length; millimetres.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Millimetres(f64);

impl Millimetres {
    /// A position or length given in millimetres.
    pub const fn new(mm: f64) -> Self {
        Self(mm)
    }

    /// The plain number, in millimetres.
    pub const fn mm(self) -> f64 {
        self.0
    }

    /// The number as a sentence shows it: to the micrometre, without the dust of binary fractions.
    pub fn shown(self) -> f64 {
        (self.0 * 1000.0).round() / 1000.0 + 0.0
    }
}

impl Add for Millimetres {
    type Output = Millimetres;
    fn add(self, other: Millimetres) -> Millimetres {
        Millimetres(self.0 + other.0)
    }
}

impl Sub for Millimetres {
    type Output = Millimetres;
    fn sub(self, other: Millimetres) -> Millimetres {
        Millimetres(self.0 - other.0)
    }
}

/// The machine's error at a place: actual − commanded, tool relative to workpiece, machine
/// coordinates (contract §1; ISO 230-1). Micrometres.
///
/// Two deviations cannot be added by mistake:
/// ```compile_fail
/// use nonius::units::Deviation;
/// let _ = Deviation::from_um(1.0) + Deviation::from_um(1.0);
/// ```
/// The difference of two deviations of one curve is a deviation again (re-zeroing):
/// ```
/// use nonius::units::Deviation;
/// let zeroed = Deviation::from_um(3.0) - Deviation::from_um(1.0);
/// assert_eq!(zeroed, Deviation::from_um(2.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Deviation(f64);

impl Deviation {
    /// No deviation.
    pub const ZERO: Deviation = Deviation(0.0);

    /// A deviation of `um` micrometres, positive where the machine goes too far in +.
    pub const fn from_um(um: f64) -> Self {
        Self(um)
    }

    /// The plain number, in micrometres.
    pub const fn um(self) -> f64 {
        self.0
    }
}

impl Sub for Deviation {
    type Output = Deviation;
    fn sub(self, other: Deviation) -> Deviation {
        Deviation(self.0 - other.0)
    }
}

/// What a control adds to the commanded position: positive moves the axis further in +.
/// Micrometres.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Correction(f64);

impl Correction {
    /// No correction.
    pub const ZERO: Correction = Correction(0.0);

    /// A correction of `um` micrometres.
    pub const fn from_um(um: f64) -> Self {
        Self(um)
    }

    /// The plain number, in micrometres.
    pub const fn um(self) -> f64 {
        self.0
    }
}

/// The corrections of several tables on one axis add (docs/siemens.md §2.3, docs/fanuc.md §2.3).
impl Add for Correction {
    type Output = Correction;
    fn add(self, other: Correction) -> Correction {
        Correction(self.0 + other.0)
    }
}

/// What is left: deviation + correction, micrometres.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Residual(f64);

impl Residual {
    /// The plain number, in micrometres.
    pub const fn um(self) -> f64 {
        self.0
    }
}

impl Add<Correction> for Deviation {
    type Output = Residual;
    fn add(self, correction: Correction) -> Residual {
        Residual(self.0 + correction.0)
    }
}

/// **The change of sign**: the correction that cancels a deviation, and back.
///
/// ```
/// use nonius::units::{Correction, Deviation};
/// assert_eq!(-Deviation::from_um(2.5), Correction::from_um(-2.5));
/// ```
impl Neg for Deviation {
    type Output = Correction;
    fn neg(self) -> Correction {
        Correction(-self.0)
    }
}

/// The way back: another maker's table of corrections, read as the deviations it cancels.
impl Neg for Correction {
    type Output = Deviation;
    fn neg(self) -> Deviation {
        Deviation(-self.0)
    }
}
