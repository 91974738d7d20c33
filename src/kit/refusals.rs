//! What is refused of kits, rehearsals, plans and visits: each kind with its facts, its words and the next step, one a
//! line.

use crate::text::refusals;

/// What to do where files do not read back.
const KEEP_TO_THE_FORMAT: &str =
    "a template of your own has to keep to the format of the dialect (docs/own-control.md §3)";

refusals! {
    // Kits and their files.
    not_emulated(why) => "the tables cannot be emulated: {why}", "nothing is written, because no forecast could be given";
    not_read_back() => "the files that the templates made cannot be read back, so nothing is written", KEEP_TO_THE_FORMAT;
    something_else_set() => "the files that the templates made set something else than was meant, so nothing is written", "a kit sets what its tables need and nothing else; `nonius context JOB` prints what a template sees";
    other_tables() => "the files that the templates made do not read back to the tables that were meant, so nothing is written", "a template leaves something out, doubles it or changes a number; `nonius context JOB` prints what it sees";
    other_proof(why) => "the files of the sign proof do not do what was meant, so nothing is written: {why}", KEEP_TO_THE_FORMAT;
    other_program(words) => "{words}", "nothing was written";
    not_written(why) => "the document cannot be written: {why}";
    // Directories.
    damaged_manifest(why) => "`manifest.json` is damaged: {why}", "make the kit again; without `manifest.json` the tables alone are judged";
    holds_input(directory, file) => "`{directory}` holds `{file}`, from which the tables are made, and no manifest.json: it is no kit", "name the directory that `nonius generate` wrote, or one that holds nothing but files read out of the control";
    other_control(words) => "{words}", "name the job that this kit was made from, or the kit of this job";
    // Rehearsals.
    no_diagonals() => "the job does not say how diagonals would be measured: it has neither readings nor a section [program]", "add `[program]` with `what = \"step-diagonal\"`, `start_mm`, `size_mm`, `steps` and `order` (docs/measuring.md), or predict single axes with `--errors`";
    single_axes_only() => "`[program]` measures single axes, so there are no diagonals to predict", "write `what = \"step-diagonal\"`, or predict single axes with `--errors`";
    many_readings(rows, most) => "there would be {rows} readings, expected at most {most}", "fewer runs, or fewer steps";
    not_measured(words) => "{words}", "measure them, or predict what was measured with `--errors`";
    outside_measured(words) => "{words}", "keep the box inside the measured range: nothing is extrapolated";
    // Plans.
    no_axis(axis, key) => "{axis} is to be measured, but [machine.axes.{key}] is missing", "add travel_mm and reference_mm of this axis";
    no_run() => "the job describes no run of step diagonals, so there is no visit to plan", "add `[program]` with `what = \"step-diagonal\"`, `start_mm`, `size_mm`, `steps` and `order` (docs/measuring.md); `nonius new … --readings` writes them";
    // Visits.
    no_job_keys(profile) => "the profile `{profile}` does not say which keys its job needs", "add them as `[[job]]` (docs/own-control.md section 3), or build it on a built-in one with `based_on`";
    short_travel(axis, length, steps) => "the travel of {axis}, {length} mm, is too short for {steps} steps", "ask for fewer with `--steps`";
    other_layout(job) => "`{job}` is laid out in a way that cannot be carried over", "copy it, write `active_while_measuring` and empty what belonged to that day";
}
