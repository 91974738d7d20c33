//! A switch of the control.

use serde::Serialize;

/// A machine or setting datum with its value, as found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Switch {
    /// Name without `$`.
    pub name: String,
    /// What stands in brackets.
    pub indices: String,
    /// Its value.
    pub value: String,
}
