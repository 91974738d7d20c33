//! What is refused of a control's files: each kind with its facts, its words and the next step, one a line.

use crate::text::refusals;

/// The next step where a word does not belong into a Siemens file.
pub(super) const ONLY_DATA: &str = "a compensation file holds only `$` assignments, `CHANDATA(1)`, `NEWCONF`, `STOPRE`, `M0` and an end word; anything else could move the machine";
const OF_CONTROL: &str = "check that this is a file of the control";
const GRID: &str = "no control holds so many; correct MIN, STEP or MAX";

refusals! {
    // Siemens: lines.
    rest(rest) => "`{rest}` follows a complete statement", "one line holds one statement; remove the rest or give it its own line";
    unseen(kind, code) => "{kind}character U+{code} in the file", "transfer the file again as plain text";
    not_ascii_in_code(letter) => "`{letter}` is not an ASCII character", "outside comments the control reads ASCII only";
    header_elsewhere() => "a `%` header stands only in column 1 of the first line", "give every program its own file";
    other_header(text) => "`{text}` is not a header of the form `%_N_NAME_INI`", "letters, digits and `_`, a name of at most 24 characters and an ending of three";
    other_word(found, help) => "`{found}` does not belong here", help;
    other_channel(number) => "`CHANDATA({number})` names another channel, expected the first", CHANNEL;
    no_channel() => "`CHANDATA` needs a channel number in parentheses", CHANNEL;
    no_sign(head) => "`=` is missing after `{head}`", "write `$VARIABLE[index]=value`";
    in_index(expected, name) => "{expected} expected in the index of `${name}`", "write whole numbers and axis names between `[` and `]`, separated by commas";
    value(text, wrong, help) => "`{text}` {wrong}", help;
    no_value() => "the value is missing", "write a number after `=`; if the file ends here it is incomplete";
    no_index(indices, name, example) => "`[{indices}]` is not an index of `${name}`", format!("write it like `[{example}]`; measuring systems are 0 and 1");
    not_this_value(name, words) => "`${name}` cannot have this value", format!("write {words}");
    unknown_variable(name, help) => "unknown variable `${name}`", help;
    // Siemens: tables and files.
    contradiction(what) => "two files write {what} with different values", "what the control holds would depend on the order of loading; remove one of the two";
    points_together(points, most) => "the tables would have {points:.0} points together, expected at most {most}", GRID;
    parameter_missing(field, name) => "{field} of {name} is missing", "write it in the same file as the points";
    point_behind(name, point, last) => "{name} has point {point}, but MIN, STEP and MAX give points 0 to {last}", "remove the point or correct MIN, STEP or MAX";
    no_step(name, step) => "STEP of {name} is {step}, it must be greater than 0", "write the distance of two points";
    max_not_above(name, max, min) => "MAX of {name} is {max}, not greater than MIN {min}", "MIN is the position of point 0, MAX that of the last point";
    many_points(name, steps) => "{name} would have {steps:.0} points", GRID;
    no_whole_steps(name, steps) => "(MAX-MIN)/STEP of {name} is {steps}, expected a whole number from 1", "the last point must lie on MAX; controls differ in what they do otherwise";
    protected(switch) => "the table is written while `{switch}` is 1; the control stops with alarm 17070", format!("set `{switch}` to 0 before the table and to 1 after it");
    much_data(statements, tables, data) => "here are more than {statements} statements, {tables} tables or {data} machine data of the compensation, too many for any control", OF_CONTROL;
    after_end() => "a statement follows the end word", "the control does not read on; move the end word to the end of the file";
    no_end_word() => "the file has no end word; it is not complete", "a compensation file ends with `M17` or `M30`: transfer it again, or take it out of the directory if it is no file of the control";
    goes_elsewhere() => "the file does not go to the active data of the control", "write `;$PATH=/_N_NC_ACT_DIR`, or leave the line out";
    archive(name) => "`{name}` is a commissioning archive, which is not read", "export `AX_EEC.INI` (ENC_COMP) and `NC_CEC.INI` (CEC) from the NC active data, with `INITIAL.INI` for the switches and MD32450, and name them in its place";
}

refusals! {
    // ISG kernel.
    no_list(others) => "no list stands beside {others}: parameter files do not say their form, the axes or the chain", ONE_LIST;
    several_lists(lists) => "several lists, of which one can be read: {lists}", ONE_LIST;
    not_listed_file(list, path) => "`{list}` names `{path}`, which is not there", "name the parameter file together with the list";
    in_two_files(parameter, file) => "{parameter} stands in `{file}` and in a file before it", "give each parameter once";
    twice(parameter) => "{parameter} stands twice", "give each parameter once";
    points(file, parameter, points, most) => "`{file}`: {parameter} has {points} points, expected at most {most}", "name the files of the control";
    list_without(what) => "the list does not say {what}", "name the complete list of the control";
    other_setting(key, value, expected) => "`{key}` is `{value}`, expected {expected}", "a line holds a key and its value; `#` begins a comment";
    other_argument(parameter) => "{parameter} depends on something else than the position of its own axis, which is not emulated", "a block has the position of one axis and the parameters of this axis; constants stand in a block of their own";
    no_parameter(word) => "`{word}` is neither an axis nor a parameter", "the first line of a block names its columns, for instance `X EXX EYX EZX`";
    other_count(found, expected) => "{found} numbers, expected {expected} as in the header", "a row has a number for each column; `#` in a line ends a block";
    not_zero(name, value) => "{name} is {value}: this parameter is not emulated", "name files in which it is 0, or that do not hold it";
    second_row() => "a second row of constants", "a block without positions has one row";
    not_ascending(position, last, drops) => "position {position} does not lie above {last} of the row before{drops}", "rows ascend, each position once";
    no_number(word) => "`{word}` is no number that a machine can mean", "positions in mm, deviations in mm, angles in rad, with a decimal point";
    no_row() => "a header without a row", "the file may have been cut off";
    // LinuxCNC.
    no_ini(others) => "no ini file stands beside {others}: a table says neither its joint nor its type nor its unit", "name the ini file of the machine, or the lines of the kit, together with the tables";
    several_inis(inis) => "several ini files, of which one can be that of the machine: {inis}", "name one of them: the ini file that LinuxCNC is started with";
    no_comp_file(joint, path) => "COMP_FILE of [JOINT_{joint}] names `{path}`, which is not there: LinuxCNC does not start without it", "name the file together with the ini file; behind the name of a COMP_FILE no comment may stand";
    same_name(file) => "two COMP_FILE have the name `{file}` in different folders", "give the tables different names in the ini file and beside it";
    second_hal(file) => "`{file}` is a second HAL file", "name the file with the corrections alone; the machine's own HAL files are not read";
    hal(message) => "{message}", "a HAL file is read as `generate` writes it, line by line: name that of the kit; the machine's own HAL files are not read";
    includes() => "this line includes another file, which is not read here", "name the file that LinuxCNC makes of both when it starts: the ini file with `.expanded` behind its name";
    second_section(name) => "a second section [{name}], which LinuxCNC does not read", "put its lines into the first section of this name";
    ini_value(key, section, value, expected) => "`{key}` of [{section}] is `{value}`, expected {expected}", "a value goes to the end of its line, comments too";
    stops_reading() => "LinuxCNC stops reading here without a word: rows below this line do nothing", "a table holds no comment, header or blank line";
    no_first_row() => "no row begins the file: LinuxCNC runs without this table, and says nothing", "a table holds `nominal forward reverse` in each line and nothing else";
    long_row(length, most) => "a line of {length} characters, LinuxCNC takes {most}", "write three numbers in a line";
    beyond_machines() => "a number beyond every machine", "write positions and values in the machine unit";
    row_behind(most) => "a row behind the {most} that LinuxCNC takes: it runs without it", "use a larger spacing";
    // As a profile declares.
    another(file, table) => "`{file}` holds another {table}", "name the files that the control holds together";
    no_value_at_all() => "no line of the files holds a value", "compare the files with the patterns of the profile (`lines`)";
    set_without(name) => "a set without {name}: the control takes all together", "state all factors, 0 where nothing is to be corrected";
    no_pattern() => "no pattern of the profile takes this line", "the patterns of the profile (`lines`) say what a line can be; what the control makes of another one is not known";
    no_factor(found) => "`{found}`, expected a factor below 1", "a factor is how far an axis leans, mm in a mm";
    value_of_nobody() => "a value, and no line says of which axis", "a line before it, or the line itself, has to name the axis";
    second_set(own) => "a second set beside `{own}`, and one is loaded", "name a file that holds the one that is loaded";
    unit_in_comment() => "a comment that may name a unit", "the patterns of the profile (`lines`) say how a file names its unit; take the word out if the line means something else";
    another_axis(own) => "another axis than `{own}`, which the line corrects", "an axis that follows another one is not corrected so";
    other_than_name(own) => "another axis than `{own}` in the name of the file", "correct whichever is wrong: a control may go by either";
    another_unit(word) => "the file is in `{word}`, the profile is not", "`value_size` of the profile says the unit of the values: a file in another one is not read";
    second_pair() => "a second pair of axes for this table", "a table is for one pair of axes";
    table_of_nobody(name) => "no line says which axes the table `{name}` is for", WHOLE_FILE;
    first_increment(what, first) => "the first increment of the {what} is {first}, expected 0", "an increment is the change over the section before; there is none";
    no_cross_table(what) => "a {what}, and this control corrects an axis by itself only", "`cross_terms` of the profile says so";
    point_beyond(most) => "a point behind the {most} that the control takes", "use a larger spacing";
    few_points(what, points) => "the {what} has {points} points, expected at least 2", WHOLE_FILE;
    says_otherwise(said, is) => "the file says {said} here, its points make it {is}", "points are missing, too many, or elsewhere";
    gap(expected, what) => "the point {expected} of the {what} was expected here", "points follow each other without a gap";
    point_without(field) => "a point without `{field}`", WHOLE_FILE;
    other_order(position, word, before) => "position {position} does not lie {word} {before} of the point before", "`order` of the profile says how points follow each other; each position once";
    other_values(with, field) => "a point {with} `{field}`", "the patterns of the profile say which values a point has";
    second(field) => "a second `{field}` here", "of two values nobody knows which one the control takes";
    other_kind(field, found, kind) => "`{field}` is `{found}`, expected {kind}", "write digits with a decimal point";
    // Part programs.
    of_program(message) => "{message}", "a template of your own may lay out the words, not add others (docs/measuring.md)";
    otherwise(message) => "{message}", "this program must not be used; nothing was written";
    // Fanuc: blocks.
    frame(message) => "{message}", "a record begins with `%` and ends with `%`, each on a line of its own; the file may have been cut when it was copied; if it is no file of the control, take it out of the directory";
    not_ascii(letter) => "`{letter}` is not an ASCII character", "files of this control are plain ASCII; the file is damaged or of another kind";
    large_number(text) => "the number `{text}` is too large", GRAMMAR;
    other_identifier(digit) => "the data identifier `Q{digit}` is neither `Q0` nor `Q1`", "`Q0` marks pitch data, `Q1` a parameter";
    axis_0() => "axis numbers count from 1", GRAMMAR;
    block_ends(expected) => "the block ends where {expected} was expected", GRAMMAR;
    not_expected(found, expected) => "found `{found}` where {expected} was expected", GRAMMAR;
    carriage_return() => "found a carriage return alone, which ends no block on a control", END_OF_BLOCK;
    lower_case() => "found a letter in lower case, which a control skips", "write it in capitals";
    semicolon() => "found a `;`; in a file `;` ends no block", END_OF_BLOCK;
    comment() => "found a comment, which this control's data files cannot hold", "remove the text in parentheses";
    program_number() => "found a program number in a data file", G10;
    program_block() => "found a block of a G10 program", G10;
    percent_inside() => "found a `%` inside the record; a control reads no further", "keep one record in a file, with one `%` before and one after it";
    decimal_comma() => "found a decimal comma", "the decimal sign is a point";
    // Fanuc: points and parameters.
    many_values(most) => "here are more than {most} values for the compensation, too many for any control", OF_CONTROL;
    two_files(what) => "{what} has different contents in two files", "the control would keep whichever is loaded last; write it in one file only";
    of_spindle() => "a spindle parameter is not ours", "compensation parameters belong to an axis (`A<n>`) or to none";
    other_path(word, path) => "`{word}` names path {path}, expected path 1", "compensation data are written for path 1; split the file by path";
    below_points(number, offset, example) => "number {number} is marked as pitch data, below {offset}", format!("point 33 is number {example}; a parameter has `Q1`");
    means_parameter(number, point) => "this would address parameter {number}, not pitch point {point}", "pitch data carry `Q0`";
    without_identifier(number, point) => "number {number} without `Q` is ambiguous", format!("`Q0` makes it point {point}, `Q1` parameter {number}");
    no_such_point(point) => "this control has no point {point}", "compare the number with the point numbers of the controller profile";
    several_values(point) => "point {point} has more than one value", "write each point in a block of its own";
    point_twice(point, value, old) => "point {point} is {value} here and {old} in an earlier block", "two axes may share numbers by mistake; write each point once";
    no_plain_value(point) => "point {point} takes a plain `P` value, without axis or unit", "a point belongs to the axis whose 3621 to 3622 hold its number";
    no_whole_value(point, text) => "point {point} has the value `{text}`, expected a whole number", "pitch data count detection units";
    large_value(point, text) => "point {point} has the value `{text}`, expected -128 to 127", "larger steps need a larger magnification (3623) or a shorter interval";
    two_values(parameter) => "{parameter} has two values in one block", "write each value once";
    other_value(parameter, old) => "{parameter} has another value here than in an earlier block ({old})", "name the files of one read-out";
    other_letter(number, letter) => "parameter {number} has the letter `{letter}`, expected `P`", "state the value in the unit of the machine, with `P`";
    no_bits(number, text) => "parameter {number} has the value `{text}`, expected eight bits", "write all eight bits, bit 7 first, as in `P00000001`";
    too_large(text) => "the value `{text}` is too large", OF_CONTROL;
}

const ONE_LIST: &str =
    "name one list (`.lis`, the file of `vol_comp[0].file_name`) with the files of its `file[…]`";
const WHOLE_FILE: &str = "take the whole file";
const END_OF_BLOCK: &str = "a line feed (0A hexadecimal) ends a block; transfer the file again, without a change of its line ends";
const GRAMMAR: &str = "a block is `N<number>`, `Q0` or `Q1`, then `A<axis>P<value>` or `P<value>`";
const G10: &str =
    "this reader reads files of `N…P…` blocks only; a G10 program is loaded by running it";
const CHANNEL: &str = "write `CHANDATA(1)`, or leave it out where the file is a part program";
