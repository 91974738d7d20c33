//! What is refused of the tables that were active and of a second measurement: each kind with its facts, its words and
//! the next step, one a line.

use crate::text::refusals;

/// The next step where a kit is of another machine, by its serial number or by what is named.
pub(super) const LOADED: &str = "name the kit that was loaded into this machine";
pub(super) const LOADED_OR_NAMED: &str = "name the kit that was loaded into this machine; if it is the same machine, write `name` and `chain` as the manifest of the kit has them (the same `serial` in both would tell, too)";

refusals! {
    // What was active.
    from_control(finding, help) => "{finding}", help;
    not_of_tables(name, path) => "`{name}` of `{path}` is a file of a kit that is not loaded with its tables, so it does not tell what was active", "name the whole kit with its manifest.json, or files that were read out of the control";
    in_use(what, help) => "{what} is in use in the read-out, for axes that the job does not have or switched off: it would be overwritten", help;
    other_backlash(found, axis, own) => "the files hold a backlash parameter of {found} µm for {axis}, the job states {own} µm", "remove it from the job, or name the files of that day";
    // A kit.
    damaged_manifest(path, error) => "`{path}/manifest.json` is damaged: {error}", "name the kit as it was made, or the files read out of the control";
    other_control(made, own) => "the active tables were made for the control `{made}`, the job is for `{own}`", "name the kit that was loaded into this control";
    made_later(made, own) => "the active tables were made from a measurement of {made}, this one is of {own}: they cannot have been active", "correct `date`, or name what was active on that day";
    other_file(name, path, what) => "`{name}` of the kit `{path}` {what}, so what was active is not known", "name the kit as it was loaded, or the files read out of the control";
    other_machine(what, kit, own, help) => "the active tables were made for another machine: its {what} is `{kit}`, that of the job `{own}`", help;
    other_unit(unit, own) => "the active tables are in {unit}, the job in {own}", "correct `control_unit`, or make the new tables in the unit of the old ones";
    no_such_axis(name) => "the active tables are for an axis `{name}`, which the job does not have", "compare `id` of [compensation.axes] with the kit";
    other_axis(name, words) => "axis {name}: {words}", "correct the job; tables of another reference or unit cannot be added";
    // What they did.
    angles_active(rotation) => "the active tables hold angles ({rotation}): what they did at the levers cannot be added to the new ones", "measure with this compensation switched off, and write `active_while_measuring = \"none\"`";
    not_determined(reason) => "what the active tables did cannot be determined: {reason}", "name the complete files of the control as they were while measuring, or measure with the compensation switched off";
    nothing_active(found) => "the active tables correct nothing of the job's axes: {found}", "compare `id` of [compensation.axes] with the names in the files; write \"none\" if no compensation was active";
    no_backlash(axis) => "the new tables replace the backlash parameter of {axis}, but no file holds the one that acted while measuring", "name a file that holds it, or state `active_backlash_um = { x = …, y = …, z = … }` in [measurement]";
    gantry_differs(term, first, other) => "{term}: the active tables of {first} and {other} differ, and one table for both would lose the difference", "bring the axes of the gantry to the same table first, or measure with the compensation switched off";
    repeats(term) => "{term}: the active table repeats (modulo), which no table of a linear axis of this program does", "measure with this compensation switched off";
    not_zero(term, um, mm) => "the active tables correct {term} by {um:.3} µm at the reference {mm} mm, where tables are zero: they belong to another reference", "correct `reference_mm`; if the control really held this value there, `active_reference = \"rezero\"` in [measurement] takes it off";
    not_measured(term) => "the active tables correct {term}, which was not measured", "measure it, or write `active_terms_not_measured = \"keep\"` (its correction is carried over) or \"drop\" (the new tables do without it) in [measurement]";
    not_asked(term) => "the active tables correct {term}, but `terms` does not ask for it: the new tables would do without", "add it to `terms`, or write `active_terms_not_measured = \"drop\"` in [measurement]";
    // A second measurement.
    of_other_machine(what, there, here) => "the measurement afterwards is of another machine: {what} is {there}, as found {here}", "both jobs describe the same machine in the same coordinates";
    as_found(what, here) => "as found, {what} is {here}";
    no_material() => "the second job does not state [measurement.step_diagonal.material], the first one does", "state it with the temperatures of the second measurement: they are never taken from the first";
    other_limits() => "the second job asks for other limits than the first", "both are judged by those of the first job: state there what is asked, and nothing here";
    no_common_error(before, after) => "both measurements have no error in common: as found {before}, afterwards {after}", "measure the same errors again with the tables active";
    no_common_range(axis, from, to, low, high) => "axis {axis} was measured from {from} to {to} mm as found and from {low} to {high} mm afterwards: no position in common", "both files count in machine coordinates; measure the same range again";
    not_told(words) => "the first measurement does not tell what the straight runs show: {words}", "measure the errors of the first measurement there too, each by itself, or give the second one as an error table of what was measured first";
    nothing_twice() => "no position was measured both times", "measure the same range of the same axes again";
    slip_of_unit(words) => "the values measured afterwards are {words} a slip of their unit", "the unit is part of the column's name (`ex_um`, `ex_mm`); correct the column or its values";
}
