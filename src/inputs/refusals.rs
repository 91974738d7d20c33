//! What is refused of files that were measured: each kind with its facts, its words and the next step, one a line.

use crate::text::refusals;

/// The next step where a file cannot be what its program wrote.
pub(super) const AGAIN: &str = "the file is incomplete or was changed: save it again";
/// The next step where a value is not there.
pub(super) const MISSING: &str = "a missing value is never filled in: save the file again";
/// The next step where a line of a compensation table has another meaning.
pub(super) const SAVE_SO: &str = "save the table again so, or the measurement itself (`.rtl`)";
const SEPARATE: &str =
    "save separate forward and reverse tables, or the measurement itself (`.rtl`)";
const LEAVE_OUT: &str = "a missing value is never filled in: leave the run out";
const TERMS: &str = "write \"all\", or for instance [\"EXX\", \"EYX\"]";
const KEEP_ONE: &str = "keep one of the two";
const RIGHT_FILE: &str = "leave `--axis` out, or take the right file";
const SEPARATOR: &str = "the separator is `;`, a tab or a comma";
const PLAIN_DECIMALS: &str = "write all numbers with a decimal point or all with a comma, and nothing between thousands; `--decimal` says which of them stands before decimals";
const EXAMPLE: &str = "e.g. `--columns \"AXn [mm]=position_mm,Delta [mm]=ex_mm\"`";
const FORM: &str = "name `readings.csv` of `nonius new` or `nonius program`, or a `readings-x.csv`, with its last column empty";
/// The first line of runs of an axis.
pub(super) const RUNS: &str =
    "first line: target_mm,up1_mm,up2_mm,dn1_mm,dn2_mm or target_mm,run,direction,deviation_um";
pub(super) const STATE_VALUES: &str = "add `--values deviations` or `--values positions`";

pub(super) const ALL_DIAGONALS: &str = "the separation needs all four body diagonals";
pub(super) const ALL_BACK: &str = "the separation of the two directions needs the return pass on all four body diagonals; measure it, or leave its rows out";
pub(super) const MOVED: &str =
    "`moved` names the axis of the forward step that ends at the node, and is empty at node 0";

refusals! {
    // Whatever the format.
    not_recognised(name) => "the format of `{name}` is not recognised", "map its columns with `--columns`, or state `--from rtl`, `ren`, `pos`, `etalon` or `isg`. Of the files of Optodyne, CARTO and others nothing is known that could be relied on: export a CSV there";
    only_understood(options) => "understood from the file, but neither stated nor confirmed: {options}", "if it is so, add `--yes`, or these options";
    list_without_form() => "a list of captures does not say where they were taken", "name the form that says it, `--form readings.csv` (docs/measuring.md section 4)";
    other_count(found, expected) => "expected {expected} words in this row, found {found}", MISSING;
    something_else(what, found, expected, help) => "{what} is `{found}`, expected {expected}", help;
    no_sense_of_targets() => "the targets neither ascend nor descend, expected at least two in one sense", "a measurement on a line is needed; circular or repeated targets make no curve";
    // Statements.
    no_meaning(option, format, takes) => "`{option}` has no meaning for format `{format}`", format!("leave it out; `{format}` takes {takes}");
    contradicted(statement, says, option) => "`{statement}` contradicts the file, which says `{says}`", format!("leave `{option}` out");
    other_axis_stated(axis, term, along) => "`--axis {axis}` contradicts `--term {term}`, in which {along} moves", "the last letter of a term is the moving axis";
    other_term(term, format, held) => "`--term {term}` is not in a file of the format `{format}`, which holds {held}", "state the term that was measured, or take the right file";
    other_axis(entry, moved, help) => "the file names axis `{entry}`, but {moved} was stated as the moving axis", help;
    is_measured_less_target(whose, help) => "`--sign as-correction` contradicts the file, whose {whose} measured − target", help;
    // Bytes and kinds of files.
    no_spreadsheet(path) => "`--sheet` is stated, but `{path}` is not read as a spreadsheet", "leave it out, or name a file that ends with .xlsx, .xls or .ods";
    other_mark(stated, path, marked) => "`--encoding {stated}` contradicts `{path}`, which begins with the mark of {marked}", "leave `--encoding` out";
    unmarked(path, order) => "`{path}` looks like UTF-16 without its mark: every second byte is zero", format!("state its encoding: `--encoding {order}`");
    other_letter(name, others) => "the file holds a letter that is not {name}", format!("state its encoding: {others}");
    recording(path) => "`{path}` is a dynamic recording (`.rtx`), which has no targets", "measure at targets and save static data (`.rtl`)";
    spreadsheet(path) => "`{path}` is a spreadsheet", "save it as CSV, and map its columns with `--columns`";
    angles(path) => "`{path}` holds angles, and the unit of the values in this format is not known", "export a CSV with the unit, and map its columns: `--columns \"Position=target_mm,Pitch=eb_urad\"`";
    straightness(path) => "`{path}` holds straightness, squareness or flatness in a form that is not known", "export a CSV with the evaluated deviations, and map its columns: `--columns \"Position=target_mm,Deviation=ey_um\"`";
    // Sections and runs.
    no_section_at_all() => "there is no section such as `HEADER::`, expected a file of the format `rtl`", "take the file as it was saved, or leave `--from` out";
    there_is_no(what) => "there is no {what}", AGAIN;
    too_large(label, count, most) => "`{label}` is {count}, expected at most {most}", AGAIN;
    too_many_targets(most) => "here are more than {most} targets, expected at most so many", AGAIN;
    other_targets(listed, count) => "{listed} targets are listed, expected {count} as in `Target-count`", AGAIN;
    target_twice(target, run) => "target {target} of run {run} is given twice", AGAIN;
    beyond(what, number, key, most) => "{what} {number} is beyond `{key}`, which is {most}", AGAIN;
    run_missing(run, runs) => "run {run} is missing, expected {runs} runs as in `Run-count`", "a missing value is never filled in: save the file again, or without the broken run";
    targets_missing(run, targets) => "run {run} has no deviation at target {targets}", "a missing value is never filled in: save the file again, or without the broken run";
    odd_runs(count) => "`Run-count` is {count} in a bidirectional file, expected an even number: each direction counts as a run", "complete the last return run, or save the file without its outward run";
    // Compensation tables.
    no_table() => "there is no table with the heading `No.  Axis position`", "other layouts of compensation tables are not known: save the measurement itself (`.rtl`)";
    other_columns(found) => "the columns are `{found}`, expected `Combined`, or `Forward` and `Reverse`", "save the table again with these columns";
    other_point(number, expected) => "point {number} stands where point {expected} is expected", AGAIN;
    backlash(found) => "the table leaves out a backlash of `{found}`, whose sense is not known", SEPARATE;
    backlash_unknown() => "there is no line `Backlash error`, so it is not known whether the combined table leaves out a backlash", SEPARATE;
    end_unknown(label) => "there is no line `{label}`, so it cannot be seen whether rows are missing", AGAIN;
    other_spacing(from, to, spacing) => "the table goes from {from} to {to} mm, expected a spacing of {spacing} mm", AGAIN;
    other_end(found, mm, label) => "the table has {found} at this end, expected {mm} mm as in `{label}`", AGAIN;
    // Position exports.
    no_linear_data() => "the first line is not that of a full export of the format `pos`, expected a `Linear Data Table` of API", "save the linear measurement itself, not an evaluation; or export a CSV and map its columns: `--columns \"Position=target_mm,Error=ex_mm\"`";
    nothing_measured(columns) => "there is no table with the columns {columns}: the file holds no measured rows", "save the measurement with its readings, or map the columns of a CSV with `--columns`";
    other_rows(found, expected, positions, runs, ways) => "{found} rows are measured, expected {expected}: {positions} positions, {runs} runs{ways}", AGAIN;
    other_positions() => "a run has other positions than the first one", AGAIN;
    other_ways(forward, reverse, runs, back) => "{forward} runs go from the first position to the last and {reverse} go back, expected {runs} and {back} as in `RunNum` and `TestType`", "the order of the rows shows the way of the axis; it is known from no file of this kind, so it is not guessed";
    contradictory(count, rows, error, expected) => "{count} of {rows} rows contradict themselves: here the error is {error}, but reading less position is {expected:.6}", AGAIN;
    bad_status(status, state, count, rows) => "the laser's status is {status} ({state}) in {count} of {rows} rows", "such a reading is no measurement: measure the run again";
    // Parameters.
    same_parameter(name, twin) => "`{name}` gives the same as `{twin}` before it", KEEP_ONE;
    other_location(name) => "`{name}` is a location that is none of C0Y, B0Z, A0Z, and it is not zero", "export with the X axis as primary and the Y axis as secondary axis";
    unknown_parameter(name) => "unknown parameter `{name}`", "expected EXX … ECZ, or C0Y, B0Z, A0Z";
    no_single_value(name, count) => "`{name}` has {count} values, expected one without argument", "a squareness is one angle between two axes: export it as such";
    no_curve(name) => "`{name}` is no curve, expected two or more ascending positions with a value each", AGAIN;
    other_grid(component, along) => "{component} stands at other positions than the components of {along} before it", "export all components of an axis on one grid: a value between points is never made up";
    no_component() => "the file holds no component error of a linear axis, expected EXX … ECZ", "squareness alone makes no table: write it into the job";
    two_values(name) => "`{name}` has values already, expected one `VALUE` or one `Gridpoints` a block", "which of the two is meant is not known: keep one of them";
    no_block() => "expected `[NAME]`, `VALUE = …` or `Gridpoints = {{`", AGAIN;
    open_grid(name) => "the grid of `{name}` is not closed by `}}`", AGAIN;
    no_value(name) => "`{name}` has no value", AGAIN;
    no_names() => "numbers stand where the names of the columns are expected", "each block begins with its arguments and parameters, e.g. `X EXX EYX EZX`";
    many_arguments(count) => "the block has {count} arguments, expected one or none", "an error table holds curves along one axis; export component errors instead of a map";
    other_block(found) => "the block has {found} rows, expected one without an argument, else at least two", "put a line with `#` between the blocks; the file may be incomplete";
    other_argument(component, along) => "`{component}` is a curve along {along}, but it does not stand under this argument", "each block has its own moving axis";
    // The mapping of columns.
    unknown_column(target, help) => "unknown column `{target}` in `--columns`", help;
    no_equals(pair) => "`{pair}` of `--columns` has no `=`", format!("write NAME=COLUMN, {EXAMPLE}");
    mapped_like_another(target) => "`{target}` of `--columns` gives the same as a column before it", KEEP_ONE;
    only_numbers() => "`--columns` names no column, so the line above the numbers cannot be found", format!("give at least one column by its name, {EXAMPLE}");
    stated_and_mapped(option, mapped) => "`{option}` is stated, but the mapping gives `{mapped}`", KEEP_ONE;
    mapped_both(one, other) => "the mapping gives both {one} and {other}", KEEP_ONE;
    no_position() => "`--columns` maps no column to a position", "map one to `position_mm` (machine coordinate) or `target_mm` (counted from the laser's zero)";
    no_deviation() => "`--columns` maps no column to a deviation", "map one to `ex_um`, `ex_mm`, `ey_um` … `ec_urad`";
    no_target() => "`--columns` maps a reading, but no column to its target", "map one to `target_mm` or `target_in`, or the reading to a column such as `ex_um`";
    plus_of_nothing() => "`--plus-moves` is stated, but no column is mapped to `direction`", "leave it out, or map the column whose `+` it explains";
    term_of_nothing() => "`--term` is stated, but the mapping names the components itself", "leave it out, or map a column to `deviation_um` or `actual_mm`";
    position_of_straightness() => "a column says where the axis stood, which only positioning (EXX, EYY, EZZ) has", "map deviations, or state the term that was measured";
    // Mapped columns.
    no_axis(found) => "the axis is `{found}`, expected X, Y or Z", RIGHT_FILE;
    other_axis_in_row(axis, stated) => "the file says axis {axis}, but `--axis {stated}` was stated", RIGHT_FILE;
    no_column(name) => "the file has no column `{name}`", format!("copy the names for `--columns` from the file, letter by letter; {SEPARATOR}");
    no_further_column() => "the line with the names of `--columns` has no further column", SEPARATOR;
    no_such_number(number, width) => "`#{number}` of `--columns` is no column of the file, which has {width}", "columns are counted from 1";
    same_names(one, other, name) => "columns {one} and {other} are both called `{name}`", format!("map the one that is meant by its number: `#{one}=…` or `#{other}=…`");
    mapped_twice(column) => "column {column} is mapped twice", "a column holds one thing: map each once";
    other_unit(name, found, unit) => "the file gives `{name}` in {found}, but `--columns` maps it as {unit}", "map it to a column with the unit of the file";
    comma_not_point(number) => "`{number}` holds a comma, but `--decimal point` was stated", PLAIN_DECIMALS;
    point_not_comma(number) => "`{number}` holds a point, but `--decimal comma` was stated", PLAIN_DECIMALS;
    comma_between_commas(number) => "`{number}` holds a comma in a file whose columns are separated by commas: it may stand between thousands", PLAIN_DECIMALS;
    comma_and_point(number) => "`{number}` has another decimal separator than the numbers above it", PLAIN_DECIMALS;
    thousand_or_decimal(number) => "`{number}` may be a thousand or a decimal: no number of the file shows what its comma means", PLAIN_DECIMALS;
    two_axes() => "targets of two axes stand in one file, but one first target can be stated only", "import one axis at a time, or map machine coordinates to `position_mm`";
    no_first_target() => "the first row is not at an end of the targets, so the first target is not known", "sort the rows, beginning with target 1";
    other_first_target() => "these rows do not begin with the first target of the file", LEAVE_OUT;
    other_run(run) => "run {run} does not have the positions of the first run", LEAVE_OUT;
    single_position(axis) => "axis {axis} has a single position, expected at least two", "one position makes no curve: give another one, or leave the axis out";
    no_order(here, before, way) => "position {here} comes after {before}, but the rows above {way}: expected one order in a run", "look for a sign between thousands; else map the number of the run (`…=run`), or sort the rows";
    position_twice(position) => "position {position} is given twice", "map the number of the run (`…=run`) or the direction of travel (`…=direction`), or leave one row out";
    // Lists of captures and their form.
    no_readings(text) => "`{text}` of `--columns` names no readings", "write one column, `NAME=displacement_mm` or `#1=deviation_um`; units are mm, um, in and uin";
    no_list_column(list, column) => "`{list}` has no column `{column}` with numbers", "name it as the file writes it, or by its number, `#1=…`";
    other_list(needs, list) => "the form {needs} list named as {list}", "a form of diagonals takes `--ppp`, `--npp`, `--pnp` and `--ppn`, one of an axis a single FILE";
    other_captures(of, found, all, what, help) => "the list of {of} holds {found} values, expected {all} with `--captures cumulative`, one fewer with `incremental`: as stated, {what}", help;
    no_form(name) => "`{name}` is no form of readings", FORM;
    no_form_header() => "this is no header of a form of readings", FORM;
    filled_already() => "the form holds a value already, expected an empty cell", FORM;
    no_capture() => "this row names no capture", FORM;
    // Runs of one axis.
    unit_twice(unit) => "the unit {unit} was stated, but every column names its own", "leave out `--unit`";
    no_unit(name, more) => "column `{name}` has no unit, expected `{name}_mm`, `_um`, `_in` or `_uin`{more}", "name the unit in the header, or state it for all of them: `--unit mm`, `in`, `um` or `uin`";
    other_values(stated, name, named) => "{stated} were stated, but column `{name}` holds {named}", "leave out `--values`";
    two_units(name, target) => "column `{name}` has another unit than `{target}`, expected to be told whether it holds positions or deviations", STATE_VALUES;
    unclear_values(name, found, help) => "column `{name}` does not say whether its values are positions or deviations: {found}", help;
    other_table() => "this is an error table, expected the raw runs of a positioning test: repeatability cannot be taken from means", RUNS;
    targets_unnamed() => "there is no column for the targets, expected `target_mm`, `target_in` or `target_um`", RUNS;
    other_layout(name) => "column `{name}` belongs to another layout than `up1`, `dn1` …", RUNS;
    no_rows() => "the table has a header but no rows, expected readings", "write one row for each target, or one for each reading";
    few_targets() => "expected two targets or more, each larger than the one before";
    incomplete_runs(targets) => "the runs are not complete: expected one direction or both, and as many finite deviations at each of the {targets} targets";
    one_target() => "there is one target only, expected at least two", "a positioning test has five or more targets";
    read_twice(what, line) => "{what} stands here again, the first time in line {line}", "keep one of the two rows";
    no_reading(target, run, direction) => "target {target} mm has no reading of run {run} moving {direction}, which other targets have", "a missing reading is not filled in; write a target the same way in every row, or leave out the run or the target as a whole";
    far(off, target, limit, least, more, help) => "the reading is {off:.4} mm from its target at {target} mm, expected less than {limit:.4} mm (half the way to the next target, or {least} mm where they are closer){more}", help;
    too_many_readings(most) => "here are more than {most} readings, too many for a test", "check that the file is a test of one axis";
    // Whatever table.
    no_table_at_all(name, what, first_line) => "`{name}` holds no {what}", first_line;
    other_cell(what, found, expected, help) => "{what} `{found}`, expected {expected}", help;
    empty_cell(name, help) => "`{name}` is empty, expected a number", help;
    no_uncertainty(name, found) => "`{name}` is {found}, expected an uncertainty of at least 0", "give the standard uncertainty, k = 1";
    same_column(name, other) => "column `{name}` gives the same as column `{other}` before it", KEEP_ONE;
    no_column_for(what, example, first_line) => "there is no column for {what}, expected {example}", first_line;
    // Error tables.
    empty_position() => "the position is empty, expected a number", "every row needs its machine coordinate";
    no_positions() => "the table has a header but no rows, expected measured positions", "write one row for each measured position, e.g. x,0,0";
    mixed_directions(axis) => "axis {axis} has rows with and without a direction, expected one kind", "give every row of the axis `+` or `-`, or none";
    given_twice_along(position, unit, axis) => "position {position} {unit} of axis {axis} is given twice", "average repeated runs, or give them directions `+` and `-`";
    unordered(position, unit, axis, before) => "position {position} {unit} of axis {axis} comes after {before} {unit}, expected ascending positions", "sort the rows of each axis and direction by position";
    empty_in_one_row(name, axis) => "`{name}` is empty in one row of axis {axis}, expected a number as in its other rows", "a missing value is never filled in: measure it, or leave the whole column empty for this axis";
    holds_nothing() => "the table holds no deviation, expected ex, ey or ez of an axis", "fill in what was measured; angles alone make no table for a control";
    in_two_tables(names, one, two) => "{names} stands in two tables, `{one}` and `{two}`", "give each component of an axis in one table: the zeros of two measurements differ by what nobody measured";
    directed_in_one(axis) => "axis {axis} is given with directions in one table and without in another", "measure all components of an axis with `+` and `-`, or import them with `--direction both`";
    other_range(axis) => "axis {axis} was measured over another range than in the table before", "measure the components of an axis over the same range, in machine coordinates";
    // Readings of the diagonals.
    displacements_alone() => "the readings are displacements: their deviations need the box, which stands in the job", "give the job instead: `nonius standards job.toml`";
    no_walk(pass, diagonals, help) => "there is no {pass} run of {diagonals}", help;
    named_back(walk, name, diagonal) => "{walk}: `{name}` already names the return pass of {diagonal}", format!("write `{diagonal}` and `reverse`");
    walked_twice(walk, twin) => "{walk} stands a second time as {twin}", "keep one of the two, or give them different runs";
    no_forward_rows(walk) => "{walk} has no forward rows of the same run, whose start is its zero", "give both ways of a run the same number";
    node_twice(walk, node) => "{walk}: node {node} stands more than once", "number repeated runs in the column `run`, and mark the return pass in the column `direction`";
    beyond_last_node(walk, node, last) => "{walk} reaches node {node}, but the last node of this path is {last}", "nodes count from 0 at the start of the forward run; check `steps` and `kind` of the job";
    other_last_node(found, kind, steps, last, help) => "the runs end at node {found}, but {kind} runs with `steps = {steps}` end at node {last}", help;
    nodes_missing(walk, nodes) => "{walk}: {nodes} missing", "measure it again: a missing reading is never filled in";
    straight_moved() => "straight runs have no column `moved`: all axes move together", "remove the column, or write `kind = \"step\"` in the job";
    no_moved() => "there is no column `moved`, which runs of single-axis steps need", "name the axis of the forward step that ends at each node, or write `kind = \"straight\"` in the job";
    forward_order(walk, order, diagonal, back) => "{walk} takes the axes in the order {order}, as the forward run does, so its nodes are not those of {diagonal}: walked backwards, the order is {back}", format!("measure the return pass over the same nodes; if these are such rows with the numbers of the forward run, write `{diagonal}` and `reverse`");
    other_move(walk, node, found, expected, help) => "{walk}, node {node}: {found} moved, expected {expected}", help;
    no_such_deviation(walk, node, mm) => "{walk}, node {node}: the deviation is {mm} mm, which no machine has", "check the reading, and the unit in the column's name; a column of the displacement itself is named `displacement_mm`";
    other_displacement(walk, node, mm, expected, help) => "{walk}, node {node}: the displacement is {mm} mm, expected about {expected} mm", help;
    no_room_temperature(name, celsius, low, high) => "`{name}` is {celsius} °C, expected {low} … {high} °C", "give degrees Celsius";
    temperature_missing(walk, node, name) => "{walk}, node {node}: `{name}` is empty, expected a number as in the other rows of this run", "a missing value is never filled in: leave the column empty for the whole run";
    no_temperature(axis, key) => "there is no temperature of axis {axis}: neither a column `t_{key}_c` nor `temperature_c` in the job's [measurement.step_diagonal.material]", "give the mean temperature of the scale in the job, or a column with that of every reading";
    temperatures_for_what(column) => "`{column}` gives temperatures, but the job does not say whether the readings are corrected for them already", "add `[measurement.step_diagonal.material]` with `material_corrected` and `air_corrected`";
    two_temperatures(axis, column) => "the temperature of axis {axis} is given twice: by `{column}` and by `temperature_c` in the job", "keep one of the two";
    no_expansion(column, axis, key) => "`{column}` gives temperatures, but the job does not give the expansion of axis {axis}", format!("add `{key} = {{ alpha_per_k = … }}` to [measurement.step_diagonal.material]");
    // Jobs.
    without_grid(axis, path) => "axis {axis} is compensated, but [{path}] does not say how its points are chosen", "add `spacing_mm = …`, `points = …` or `max_residual_um = …`";
    without_unit(path, control) => "[{path}] has no `detection_unit_um`, and {control} counts in it", "read it from the control (CMR, DMR, feed gear); it is often 1.0 (IS-B) or 0.1 (IS-C), on a Fanuc inch machine 2.54 or 0.254";
    no_day(date) => "`date` is `{date}`, and there is no such day", "write the day of the measurement, e.g. \"2026-11-20\"";
    other_schema(found) => "`schema` is {found}, expected `schema = 1` in the first line", "add `schema = 1` above everything else; a job of another schema needs the version of the program that it was written for";
    table_not_job(name, what, key) => "`{name}` is {what}, expected the job (TOML) that names it", format!("give the job with `{key} = …` in [measurement]; fixtures/start holds jobs to begin with");
    far_reference(reference, outside, low, high, most, next) => "the reference point {reference} mm lies {outside} mm outside the travel {low} … {high} mm, expected at most {most} mm", format!("correct `reference_mm` or `travel_mm` (machine coordinates); if the axis really has it there, write `reference_outside_mm = {next}` below it");
    no_error_tables() => "the list of error tables is empty, expected at least one path", "write e.g. `errors = [\"x.csv\", \"y.csv\", \"z.csv\"]`";
    two_lines(axis) => "axis {axis} has two linear measurements, expected one", "keep one of the two, or give their mean";
    beam_inside(axis) => "beside straight runs the beam goes along {axis} inside the box, expected from end to end: nothing tells how much of the error lies outside it", "measure over the whole edge, or take step runs";
    beam_of_one_place() => "the beam begins and ends at one place, expected two", "give the two ends of the measured line";
    no_terms_word(word) => "`terms` is `{word}`, expected `all` or a list of terms", TERMS;
    no_term_at_all() => "`terms` names no term, expected at least one", TERMS;
    term_twice(name) => "`{name}` is given twice in `terms`", "remove one";
    unknown_term(name, help) => "unknown term `{name}`", help;
    no_axis_id(id, what) => "`{id}` {what}, expected letters, digits and `_`", "write every physical axis once, as the control shows it, e.g. `AX1`";
    block_backwards(first, last) => "the block [{first}, {last}] ends before it begins", "write [first, last]";
    other_axes() => "`program.axes` names each of `x`, `y`, `z` at most once, and at least one", "for instance `axes = [\"x\", \"z\"]`";
    no_overrun() => "`overrun_mm` is 0, so the last target would be approached from one side only", "give an overrun larger than the reversal of every axis, e.g. `overrun_mm = 2.0`";
    no_coordinate_system(name) => "`{name}` is no coordinate system", "expected G54 … G59, G59.1 … G59.3 or G54.1 P1 … P300; of Siemens G500, G54 … G57, G505 … G599";
    entry_twice(entry) => "`{entry}` is given twice", KEEP_ONE;
}
