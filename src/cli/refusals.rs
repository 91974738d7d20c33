//! What is refused of a command: each kind with its facts, its words and the next step, one a line.

#[cfg(feature = "disk")]
use crate::text::LARGEST_FILE_MIB;
use crate::text::refusals;

refusals! {
    // Options.
    travel_of_axes(count) => "`--travel` names {count} axes, expected X, Y and Z", "for instance `--travel 800,500,400`";
    both_on_standard_output(what) => "{what} and the document cannot both go to standard output", "name a file with `-o`, or leave `--format json` out";
    both_on_standard_input() => "the job and the program cannot both come from standard input", "name a file for one of them";
    no_meaning(option, what) => "`{option}` has no meaning for {what}", "leave it out";
    no_errors_to_write() => "straight runs hold no nine errors: four totals are three squareness errors and one combination of the scales", "leave `-o` out, or measure in single-axis steps (`kind = \"step\"`)";
    other_chain(own, stated) => "the job states the chain {own}, `--chain` says {stated}", "leave `--chain` out, or correct the job";
    one_node(axis, length) => "`--grid` has one node in {axis}, but {axis} is judged over {length} mm, of which one place says nothing", "give at least 2 nodes, or leave `--grid` out: the nodes are then those of the measurement";
    large_window(axis, size, length) => "the sub-volume is {size} mm long in {axis}, but the volume only {length} mm", "give the size of a part that fits, in mm, as X,Y,Z";
    no_texts(language, shipped) => "there are no texts `{language}`", format!("expected one of {shipped}, or a file of texts (docs/visit.md §11)");
    // Files of the user.
    no_runs_of_axis(name, kind) => "`{name}` is {kind}, expected runs of one axis (CSV)", "a table of targets and runs as in docs/interface.md §2.4";
    names_no_control(name) => "`{name}` is an error table, which names no control: tables cannot be read or made for it", "give the job that names it";
    no_move(program) => "`{program}` holds no move that counts", "G1, G2, G3 and the feed moves of cycles count; with `moves = \"all\"` in [path] rapid moves too";
    no_picture(name) => "`{name}` is no picture that a page can hold", "give a PNG, a JPEG or an SVG";
    // What the program could not make.
    no_page() => "this program was built without the page; a released one holds it, or one built as packaging/README.md says";
    no_manual(why) => "the manual page cannot be made: {why}";
    not_put_out(why) => "standard output cannot be written: {why}";
    // Kits of a chain.
    absent_kit(directory) => "`{directory}` cannot be read: it does not exist";
    no_kit(directory, manifest) => "`{directory}` holds no {manifest}, so it is no kit";
    damaged_kit(directory, why) => "manifest.json of `{directory}` is damaged: {why}";
}

#[cfg(feature = "disk")]
refusals! {
    // Files of this computer.
    not_regular(name) => "`{name}` is no regular file", "name a file";
    empty_pipe(name) => "`{name}` is a pipe, and nothing was written into it", "name a file";
    long_pipe(name, gib) => "{name} holds more than {gib} GiB, too much for a part program", "name the file in place of `-`";
    another_run(form) => "another run is filling in `{form}`", "look at what it wrote";
    control_character(path) => "`{path}` holds a control character, expected a path", "in a job a backslash between double quotes begins one: write `/`, or single quotes around the path";
    // Directories that are written.
    no_directory(name) => "`{name}` is a link or a file, expected a new or an empty directory", "choose another directory; of a link, name what it leads to";
    is_drive(name, below) => "`{name}` is a drive, expected a directory on it", format!("name one, e.g. `{below}`");
    unusable_directory(name, why) => "`{name}` cannot be used as the kit's directory: {why}", "choose another directory";
    not_empty(name) => "the directory `{name}` is not empty, expected a new or an empty one", "choose another directory, or `--force` to keep the old one as DIR.previous";
    nameless(name) => "`{name}` is no name for a new directory", "name a directory below it, e.g. `kit`";
    // Files that are written.
    is_directory(name) => "`{name}` is a directory, expected the name of a file", "name a file in it";
    is_link(name) => "`{name}` is a link, which would be replaced by a file", "name the file itself";
    is_no_file(name) => "`{name}` is no regular file", "name a file; `-` is standard output";
    exists(name) => "`{name}` exists, so it is not overwritten", "choose another name, or `--force` to replace it";
    // Questions and answers of a batch.
    no_pool(why) => "cannot work at once: {why}";
    no_answers_to_resume() => "answers on standard output cannot be gone on with", "name their file with `-o`";
    other_question(line, file) => "line {line} of `{file}` answers another question", THIS_RUN;
    more_answers(file) => "`{file}` has more answers than there are questions", THIS_RUN;
    long_question() => "the line holds {LARGEST_FILE_MIB} MiB or more", QUESTION;
    no_question(why) => "this is not a question: {why}", QUESTION;
    two_jobs(job) => "`{job}` is `job`, and stands among `files`, too", "call the other one differently";
    no_job(name, why) => "`{name}` is no job: {why}";
    no_column(name, column) => "`{name}`: the column `{column}` is no list of numbers or words";
    no_cell(name, cell) => "`{name}`: `{cell}` cannot stand in a cell";
    uneven_columns(name) => "`{name}`: its columns are not of one length";
}

#[cfg(feature = "disk")]
const THIS_RUN: &str = "name the file that this run wrote, or a new one";
#[cfg(feature = "disk")]
const QUESTION: &str = "a question is one line of JSON; see `nonius batch` in docs/interface.md";
