//! What the readers have to say of files that they take.

use crate::text::finding::findings;

findings! {
    /// What there is to know of a file that was read.
    ReadFinding {
        Stops { file: String } => Note, "`{file}`: M0 waits for cycle start before the program goes on";
        ActsLater { file: String, variable: String } => Note, "`{file}` sets {variable} and no NEWCONF follows: it acts from the next NEWCONF or reset on, wherever the axes stand then";
    }
}
