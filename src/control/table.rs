//! What lies in a control's memory after its files are loaded.
//!
//! This is the only thing that the writing side (`compensation`, `emit`) and the reading side
//! (`read`) have in common. Values stand here exactly as in the file: in the
//! control's own unit, sense and numbering. A point that no file writes is missing (`None`).

pub mod fanuc;
pub mod isg;
pub mod listed;
pub mod siemens;

use std::any::Any;

/// The memory of one of the format families.
#[derive(Clone, Debug, PartialEq)]
pub enum Tables {
    /// Siemens ENC_COMP and CEC tables.
    Siemens(siemens::SiemensTables),
    /// Fanuc parameters and points.
    Fanuc(fanuc::FanucMemory),
    /// Tables whose points stand one by one, of LinuxCNC, of a control whose profile declares its files, and the generic ones.
    Listed(listed::ListedTables),
    /// Parameters of an ISG volumetric compensation.
    Isg(isg::IsgTables),
}

impl Tables {
    /// The tables of one family; `None` in a memory of another.
    pub(crate) fn own<T: Any>(&self) -> Option<&T> {
        let own: &dyn Any = match self {
            Tables::Siemens(own) => own,
            Tables::Fanuc(own) => own,
            Tables::Listed(own) => own,
            Tables::Isg(own) => own,
        };
        own.downcast_ref()
    }
}
