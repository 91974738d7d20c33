//! What the readers have to say of files that they take.

use crate::text::{findings, joined};

findings! {
    /// What there is to know of a file that was read.
    ReadFinding {
        Stops { file: String } => Note, "`{file}`: M0 waits for cycle start before the program goes on";
        ActsLater { file: String, variable: String } => Note, "`{file}` sets {variable} and no NEWCONF follows: it acts from the next NEWCONF or reset on, wherever the axes stand then";
        NotNamed { file: String } => Note, "`{file}`: the ini file of the machine does not name it, so it does nothing";
        NotListed { file: String } => Note, "`{file}`: the list does not name it, so it does nothing";
        Unread { files: Vec<String> } => Doubt, "{}", unread(files);
    }
}

fn unread(files: &[String]) -> String {
    let (is, it) = match files {
        [_] => ("is", "it"),
        _ => ("are", "them"),
    };
    format!(
        "{} {is} not read back (role `report`), so nothing shows what a control holds that loads {it}: give {it} the role `table` in the layout of the dialect, or, if no control loads {it}, state `loaded = false` in the profile",
        joined(files)
    )
}
