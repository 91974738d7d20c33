//! What there is to know of a kit, of a directory that holds one, and of a rehearsal.

use crate::quantity::{Axis, ErrorTerm, Figure};
use crate::text::{Finding, findings, joined, listed};

findings! {
    /// What is found beside the errors and the tables of a kit.
    KitFinding {
        ActiveNotStated => Doubt, "`active_while_measuring` is not stated: if a compensation (or a backlash parameter) was active during the measurement, these tables are wrong; write \"none\", or the path of the kit or of the files read out of the control, which are then added";
        NotMeasuredAfterwards { terms: Vec<ErrorTerm> } => Doubt, "not measured afterwards, so the residual is not known: {}", joined(terms);
        LeftToAPerson { left: usize } => Note, "the rollback files leave {left} kind(s) of settings to a person, because the files that were read out do not hold them: see \"Not written\" and \"Rollback\" of the checklist";
        TakenToBeActive { tables: String } => Note, "the job of the second measurement does not state `active_while_measuring`: the tables in {tables} are taken to have been active";
    }
}

findings! {
    /// What a rollback leaves to a person, and what happens meanwhile.
    InRollback {
        OfAKit { path: String } => Note, "no rollback file: `{path}` is a kit, not files that were read out of the control; to roll back, load that kit again to it";
        NothingReadOut => Note, "no rollback file: `active_while_measuring` names no files that were read out of the control, and zeros do not restore it";
        Incomplete { missing: Vec<String> } => Note, "no rollback file: the files read out of the control do not hold all that this kit overwrites; missing: {}", listed(missing);
        OtherForm => Note, "no rollback file: what was read out does not read back from files in the form of this profile; keep the files that were read out";
        Look { what: String, by_file: bool } => Note, "{what}: not in the rollback files. {}, and the files that were read out hold it not at all or with several values. Look at it now and note it", if *by_file { "The files of this kit switch it" } else { "A precondition may make you change it" };
        BringBack { what: String, by_file: bool } => Note, "{what}: not in the rollback files; {}", if *by_file { "switch on what was on before this kit, as noted" } else { "where it was changed, bring back what was noted before this kit" };
        Stays { table: String } => Note, "{table} was reserved without a grid: the values of this kit stay in it, switched off as it was";
        MovesAtReference { axis: Axis, name: String, um: f64 } => Note, "at the reference point {axis} ({name}) moves by {:.3} µm towards {}{axis} when the old tables act again: they are not zero there", um.abs(), if *um > 0.0 { "+" } else { "−" };
        MovementUnknown { reason: String } => Note, "what moves at the reference point when the old tables act again cannot be determined: {reason}";
    }
}

findings! {
    /// How files that stand apart from the tables differ from those of the job.
    FieldFault {
        OtherProof { file: String } => Disagreement, "{file}: other values than those of the sign proof of this job";
        PartOfProof { file: String, lacking: String } => Disagreement, "the sign proof of this job is not whole: {file} without {lacking}";
        NotWritten { file: String, parameter: String } => Disagreement, "{file} does not write {parameter}: the control keeps what it holds there";
        OtherRollback => Disagreement, "the rollback files do not hold what `active_while_measuring` names as read out of the control";
    }
}

findings! {
    /// What is found in a directory with files of a control.
    InDirectory {
        NotListed { file: String } => Disagreement, "`{file}` is not listed in manifest.json, and the control could read it";
        OtherControl { made_for: String, own: String } => Disagreement, "the kit was made for another control: manifest.json names `{made_for}`, the job `{own}`";
        WrittenInto { fault: Finding } => Note, "{fault}";
        Ignored { file: String, why: &'static str } => Note, "`{file}` was ignored: {why}";
        WholeControl { file: String } => Note, "`{file}` holds far more than a kit, so it is the control's own: put what was read out into a directory without manifest.json and name that";
        OtherInputs { names: Vec<String> } => Note, "the kit was made from other inputs: {} differ{} from what manifest.json has", joined(names), if names.len() == 1 { "s" } else { "" };
        NoManifest => Note, "there is no manifest.json, so nothing tells whether all files are there and as they were made";
        CalledAsAKit { file: String } => Note, "judged as a kit that is to be loaded, because `{file}` is called as in one: give files that were read out of the control other names";
        ActsTheSame => Note, "read back, tables and switches are as the job asks: what differs is something else (line ends, comments, words such as NEWCONF, more memory); copy the files from the kit again";
    }
}

findings! {
    /// What a rehearsal takes for granted.
    InRehearsal {
        OverrunAssumed => Note, "the job does not state `overrun`: every axis is taken to run past the end point before the return pass";
        RestsOnDoubtful { doubt: Finding } => Note, "the errors it rests on are doubtful: {doubt}";
        RestsOnSimulated { note: Finding } => Note, "the errors it rests on are {note}";
        Backlash { axis: Axis, um: f64, is_named: bool } => Note, "backlash parameter of {axis}: {:.3} µm as {}; no file for the control holds it", Figure(*um), if *is_named { "manifest.json of the kit names it" } else { "this job asks for it" };
    }
}
