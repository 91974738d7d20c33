//! What is refused of the pages of controls: each kind with its facts, its words and the next step, one a line.

use crate::text::refusals;

refusals! {
    // Profiles.
    unknown_controller(word, help) => "unknown controller `{word}`", help;
    no_schema() => "a profile needs `schema = 1`", "write `schema = 1` in its first line";
    base_not_built_in(id) => "`based_on` names `{id}`, expected the id of a built-in profile", "`nonius controllers list` shows them";
    other_dialect(own, base) => "`dialect` is `{own}`, but the profile it builds on speaks `{base}`", "remove `dialect`, or build on another profile";
    // Facts.
    factors_and_points() => "factors stand in place of tables with points, of which there are facts too: one excludes the other", "leave them out, or build the profile on `klipper-skew`";
    not_three_names(names) => "`axis_names` has {names} names, expected three", "name the axes X, Y and Z of the machine, in this order";
    no_axis_name(name) => "`{name}` is no axis name, expected letters, digits and `_`", "write it as the control shows it, e.g. `AX1`";
    ends_before() => "a block ends before it begins", "write [first, last]";
    out_of_range(name, expected) => "`{name}` is out of range, expected {expected}", "check the number and its source";
    no_factors() => "factors are names with the terms whose slopes they take off", "for instance { xy_skew = \"EXY\", yz_skew = \"EYZ\" }";
    no_field(field, two) => "no pattern has the field `{field}`{two}", format!("write `(?<{field}>…)` where it stands in a line");
    no_axis_field() => "no pattern has the field `axis`, so no table says whose it is", "`axis` in a line before the values, in each line, or in `file_name`";
    // Files of a kit.
    no_template(name) => "there is no template `{name}`", "put it beside the profile, or name a built-in one (docs/own-control.md §3)";
    no_files() => "there is no section [[files]], expected one for each file", "add `[[files]]` with role, path and template";
    twice(path) => "two files are called `{path}`", "give each file a name of its own, in capitals or not";
    no_table() => "no file has the role `table`, expected at least one", "add a file with `role = \"table\"`";
    no_file_name(path) => "`{path}` is no file name that every control and laptop takes", "use letters, digits, `_`, `-` and `.`; `manifest.json` is taken";
    mechanism_of_proof() => "`mechanism` belongs to files of the role `sign-proof`, and to each of them", "for instance `role = \"sign-proof\"` with `mechanism = \"cec\"`";
    loaded_of_report() => "`loaded` belongs to files of the role `report`", "leave it out; docs/own-control.md §3 says what each role means";
    each_without_field() => "`each` and one field of its items in braces belong together", "for instance `each = \"joints\"` with `path = \"joint-{number}.comp\"`";
    // The checklist.
    no_part(part, parts) => "the checklist has no part `{part}`", format!("its parts: {parts}");
    not_filled_in(word) => "`{{{word}}}` cannot be filled in", "write the word of a role of file, for instance `{enable}`, or `{reference}`";
    no_condition(word) => "`{word}` is neither a role of file nor a mechanism", "for instance `when = \"cec\"`, `when = \"rollback\"`, `when = \"no rollback\"`";
    // Part programs.
    no_extension() => "`extension` is no ending of a file, expected letters and digits", "for instance `extension = \"MPF\"`";
    many_decimals(decimals, most) => "a position has {decimals} decimals, expected 0 … {most}", "write the decimals that the control reads";
    other_dwell(dwell, expected) => "`dwell` is `{dwell}`, expected the word of a dwell and the address of its seconds: {expected}", "seconds with a decimal point are written behind it";
    no_letters() => "`axis_letters` names the addresses of X, Y and Z, one letter each", "for instance [\"X\", \"Y\", \"Z\"]";
}
