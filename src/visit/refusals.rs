//! What is refused of files and of what a job names: each kind with its facts, its words and the next step, one a line.

use crate::text::{LARGEST_FILE_MIB, refusals};

const OF_KIT: &str = "name the directory with the control's files, as `nonius generate` wrote it";

refusals! {
    // Files.
    no_file(what) => "{what} is a directory, expected a file", "name a file in it";
    too_long(what) => "{what} holds more than {LARGEST_FILE_MIB} MiB, too much for an input";
    written_over(output, input) => "writing `{output}` would replace or change `{input}`, which this run reads", "choose another name for `-o`";
    no_standard_input(name) => "there is no {name}", "name a file";
    is_there(place) => "`{place}` is there, so it is not overwritten", "choose another name, or `--force` to replace it";
    // Files of a control.
    no_control_file(path) => "`{path}` holds no file of a control", "name the directory with the control's files";
    file_not_kit(name) => "`{name}` is a file, expected the directory that holds it", OF_KIT;
    unreadable_kit(name, why) => "`{name}` cannot be read: {why}", OF_KIT;
    empty_kit(name) => "`{name}` holds no file of a control, expected its tables", OF_KIT;
    not_emulated(why) => "the tables cannot be emulated: {why}", "nothing can be said of the machine with them";
    // Jobs and what they name.
    table_without_chain() => "the table holds angles, which act through levers: the order of the axes is missing", "give a job with `machine.chain`, or state it: `assess --chain wXYZt`";
    only_straight_runs() => "straight runs of the diagonals hold no nine errors, so there is nothing to compensate", "measure in single-axis steps (`kind = \"step\"`); `nonius separate` prints what straight runs hold";
    no_error_table() => "no error table is named";
    overrun_missing(name) => "the runs under the name {name} count from their own start, so the readings do not tell whether the axes ran past the end point: `overrun` is missing", "state `overrun = true` or `overrun = false` as it was measured; without overrun the first moves back hold the lost motion of the axes";
    separated_already() => "this job gives `errors`, which are separated already", "a job with `readings` is needed here";
    // Second measurements.
    says_without_tables(tables) => "the measurement afterwards shows the machine with `{tables}` active, but its job says that no table was", "name the kit that was loaded, relative to this job; if none was loaded, it is a measurement to make tables from";
    other_tables_active() => "the measurement afterwards was taken with other tables active than those that are judged; below, `the tables` are the active ones and `the job` stands for the judged ones", "name with `--tables` what was active, or with `active_while_measuring` what was loaded";
    squareness_unclear() => "the first job adds `squareness_um_per_m` to its errors; whether the slopes of this table hold the squareness is not stated", "give a job with `errors` and its own `squareness_um_per_m` (none, if the slopes hold it)";
    readings_alone() => "these are readings of the diagonals, expected an error table (CSV) or a job (TOML)", "give the job that names them (`after.toml` of `nonius new`): how they were walked stands there";
}
