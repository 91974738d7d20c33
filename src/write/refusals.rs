//! What is refused of a plan, of tables and of programs before a byte is written: each kind with its facts, its words and
//! the next step, one a line.

use crate::text::refusals;

const CHECK: &str = "check the measurement and `detection_unit_um`";
const FEWER_POINTS: &str = "use a larger spacing, or `points`, or `max_residual_um`";
const ONE_LOOP: &str =
    "a loop inside another one runs once for each of its items: loop over the lists of that item";
const LARGER_SPACING: &str = "use a larger spacing";
/// The next step where angles are to be written and the chain is not stated.
pub(super) const STATE_CHAIN: &str =
    "state it, e.g. `chain = \"wXYZt\"`; or list `terms`, then no angles are written";

refusals! {
    // Directions.
    term_not_measured(term) => "`terms` asks for {term}, which was not measured", "remove it, or measure it";
    no_policy(known) => "the errors {known} in both directions, but `backlash` is not stated; there is no default", "write `backlash = \"mean\"`, \"two-tables\", \"forward-only\" or \"curve-and-parameter\"";
    no_directions(policy) => "`backlash = \"{policy}\"` needs errors measured in both directions", "give the error table a `direction` column with `+` and `-` rows, or leave `backlash` out";
    no_directions_along(key, policy, axis, found) => "`{key} = \"{policy}\"` of `backlash` needs errors along {axis} measured in both directions; {found}", format!("give the error table rows of {axis} with `+` and `-` in `direction`, or take `{key}` out of `backlash`");
    one_way(policy, needs, axis, direction, terms, help) => "`backlash = \"{policy}\"` {needs}, but axis {axis} was measured in {direction} only ({terms})", help;
    no_common_range(term) => "the two directions of {term} have no common range";
    // Programs of measuring runs.
    no_run() => "the job has no section [program], so there is no run to write programs for", "add `[program]` with `what = \"step-diagonal\"`, `\"straight-diagonal\"` or `\"single-axis\"` (docs/measuring.md); `nonius new … --readings` writes one";
    no_language(control, known) => "`{control}` says nothing about part programs, so none can be written", format!("choose the control that will run the program: {known}; or a profile of your own with [program]");
    text_of_profile(text, expected) => "the profile's text `{text}` cannot stand in a program", format!("expected {expected}");
    many_readings(readings, most) => "one program would take {readings} readings, expected at most {most}", "fewer runs or steps: four digits number the blocks of a program";
    large_feed(feed, axis, largest) => "the feed is {feed} mm/min, but {axis} is stated with at most {largest} mm/min", "write `feed_mm_per_min` with a feed that every axis reaches";
    large_shift(step, axis, shift) => "targets {step} mm apart on {axis} are shifted by up to {shift} mm, expected less than half the step", "a smaller shift, or fewer steps";
    other_turn(stated, does, over, other) => "`overrun` is {stated}, but this run {does}: its readings would be separated with the wrong reversal", format!("write `overrun = {over}`, or {other}");
    no_number(control) => "`number` is stated, but programs of `{control}` have names", "remove it";
    no_travel(axis, key) => "the travel of {axis} is not stated, so nobody could tell where the program leaves it", format!("add [machine.axes.{key}] with travel_mm and reference_mm");
    leaves(preload, overrun, needs, help) => "with {preload} mm of preload and {overrun} mm of overrun the run needs {needs}", help;
    rests(axis, at, low, high) => "{axis} would rest at {at} mm, but the travel is {low} … {high} mm", "write `rest_mm = { x = …, y = …, z = … }` with places inside the travel";
    start_between(axis, start, digit, nearest) => "the start of {axis} is {start} mm, expected a multiple of {digit}, the last digit of a position", format!("the nearest is {nearest} mm");
    step_between(size, axis, steps, step, digit, nearest, below) => "{size} mm of {axis} in {steps} steps are {step:.6} mm each, expected a multiple of {digit}, the last digit of a position", format!("the nearest below is {nearest} mm ({steps} x {below} mm)");
    // Templates and texts.
    no_such_list(key, list, path) => "`{key} = \"{list}\"` of `{path}`: this control has no such list", "`nonius context JOB` prints its lists";
    no_comment(what, files, expected) => "{what} goes into comments of {files}, expected {expected}", "write it in plain letters and digits";
    unseen(line, path, text) => "line {line} of `{path}` would hold a character that is not seen: `{text}`", "a control may obey it: take it out of the template, or out of the text that it prints";
    no_context(error) => "the context of the templates cannot be made: {error}";
    no_text(template) => "template `{template}` does not write text";
    much_work(template, most) => "template `{template}` executes more than {most} tags, counted from the lists of its loops, too much for a file of a kit", ONE_LOOP;
    much_text(template, mib) => "template `{template}` writes more than {mib} MiB, too much for a file of a kit", ONE_LOOP;
    no_layout(template, message) => "template `{template}` is refused: {message}", "a template prints names of the context with `{{ … }}`, loops over its lists with `for … in` and chooses with `if` (docs/own-control.md §3)";
    not_rendered(template, message) => "template `{template}` cannot be rendered: {message}", "`nonius context JOB` prints what a template sees";
    // Axes.
    no_such_axis(path) => "[{path}] names an axis that [machine] does not have", "add it to [machine.axes], or take it out here";
    no_axis_name(name, expected, usual) => "`{name}` is no axis of this control, expected {expected}", format!("write it as the control shows it, for instance `{usual}`");
    two_axes(name, axis) => "`{name}` names two axes, expected a name of its own for {axis}", "correct `id` or `ids`";
    corrected_axis_missing(axis, key) => "axis {axis} is corrected, but [machine.axes.{key}] is missing", "add travel_mm and reference_mm of this axis";
    needs_all_axes(key) => "the volumetric compensation needs X, Y and Z, and [machine.axes.{key}] is missing", "add `travel_mm` and `reference_mm` of this axis, and its `id` in [compensation.axes]";
    takes_one_axis(count, axis) => "`ids` names {count} axes for {axis}, the volumetric compensation takes one", "name the master: the control gives the slaves of a gantry what it gets";
    // Which terms get a table.
    no_table(control, reasons) => "no measured term gets a table on {control}, so there is nothing to write ({reasons})", "free tables on the control, or compensate terms that need none of them";
    none_left(key, tables, resource, control) => "`{key}` lies behind the {tables} {resource} of {control}, expected a smaller number", "give the number of the first one that is free on the control";
    // Points.
    needs_spacing(key) => "`{key}` needs a grid of stated spacing", "give `spacing_mm`, or leave `start_mm` and `end_mm` out";
    no_grid(most, limit_um, axis, least) => "no grid of up to {most} points keeps {limit_um} µm on axis {axis}; the best leaves {least:.3} µm", "allow a larger residual, or compensate fewer terms";
    small_spacing(spacing, least, control, feed) => "a spacing of {spacing} mm is below {least} mm, the smallest that {control} takes at {feed} mm/min", LARGER_SPACING;
    below_digit(spacing, last, unit) => "a spacing of {spacing} mm is below the last digit of the control ({last} {unit})", LARGER_SPACING;
    beyond_with_spacing(axis, control, spacing) => "the table of axis {axis} would have points beyond the travel, and {control} uses none there", format!("`spacing_mm = {spacing}` has points at both ends of the travel and none beyond");
    beyond(axis, control) => "the table of axis {axis} would have points beyond the travel, and {control} uses none there", "no spacing has points at both ends of this travel: state as `travel_mm` ends that lie whole spacings from the reference point, which lies between them";
    not_measured(axis, first, last, low, high) => "the table of axis {axis} runs from {first} to {last} mm, but only {low} … {high} mm was measured", "measure the whole travel, give `start_mm` and `end_mm`, or hold the end value with `outside = \"hold\"`";
    without_reference(axis, mm) => "the table of axis {axis} would not hold the reference point {mm} mm, where it must be zero", "let the table begin at or before the reference and end at or behind it";
    single_point(axis) => "the table of axis {axis} would have a single point", "use a smaller spacing";
    off_grid(place, spacing, reference, below, above) => "{place} mm is not on the grid of {spacing} mm anchored on the reference {reference} mm", format!("the nearest grid points are {below} mm and {above} mm");
    two_points(points, reference) => "{points} points cannot be anchored on the reference {reference} mm and cover the travel on both sides", "3 points are needed where the reference lies inside the travel";
    many_points(axis, count, most, holder) => "axis {axis} would have {count} points, more than the {most} of {holder}", FEWER_POINTS;
    many_points_in_all(points, most) => "the tables would have {points} points, expected at most {most}", FEWER_POINTS;
    ends_inside(axis, why) => "the table of axis {axis} ends inside the travel, and {why}", "leave out `start_mm` and `end_mm`: the table then covers the travel";
    // Values.
    large_correction(term, um, place, most, first) => "{term} would need a correction of {um:.1} µm at {place} mm, the limit is {most} µm", format!("{first} else raise `max_correction_um` in [limits]");
    large_slope(term, slope, from, to, most) => "{term} would change by {slope:.3} µm/mm between {from} and {to} mm, the limit is {most} µm/mm", "check the unit and the measurement there; else raise `max_slope_um_per_mm` in [limits]";
    slip_of_unit(names, um, slope, most_um, steepest, in_um) => "{names} would need corrections of up to {um:.1} µm and {slope:.3} µm/mm, the limits are {most_um} µm and {steepest} µm/mm; read as µm the same numbers keep them", format!("if the numbers are micrometres, rename to {in_um}; else raise `max_correction_um` and `max_slope_um_per_mm` in [limits]");
    large_value(table, largest, most) => "the {table} would hold {largest}, the control takes {most} at most", "`largest_value` of the profile; with increments use a smaller spacing";
    cut_off(sum, limit) => "CEC corrections may add up to {sum:.0} µm, more than the {limit} µm at which the control cuts off (MD32720)", "check the measurement; a control with another MD32720 needs a profile with its own `cec_max_sum_um`";
    many_curves(curves, points, most) => "the HAL file would have {curves} curves of {points} points, more than the {most} that the memory of HAL holds", "use a larger spacing, or `points`, or `max_residual_um`, or list fewer `terms`";
    // Fanuc.
    points_taken(first, last, axis, blocks) => "points {first}…{last} of axis {axis} are reserved, in use by another axis, or outside the control's {blocks}", "choose another `first_point`, or leave it out";
    no_room(count, axis, id, blocks) => "there is no room for {count} points of axis {axis} ({id}) in {blocks}", "use a larger spacing, or free `reserved_points`";
    no_room_for_data(count, term) => "there is no room for the {count} straightness data of {term}", "free `reserved_points`, or use a larger spacing";
    steep(term, change, increment, magnification, unit, most) => "{term} changes by {change:.1} µm between two points, more than {increment} × {magnification} × {unit} µm = {most:.3} µm that the control can add", "use a smaller spacing, or check the measurement and `detection_unit_um`";
    large_reversal(axis, reversal, unit, most) => "the reversal of axis {axis} at the reference is {reversal} × {unit} µm, more than ±{most} that parameter 3627 holds", CHECK;
    large_amount(term, most) => "{term} needs a straightness amount beyond ±{most} detection units", CHECK;
    large_backlash(axis, counts, unit, most) => "axis {axis} would need a backlash parameter of {counts} × {unit} µm, the control takes ±{most}", CHECK;
    other_bits() => "3605 with bit 2 or 3 (arbitrary-pitch, cyclic second compensation) is not emulated", "such a control is not served; are the bits those of this axis?";
    other_bit_1(stated, found) => "`interpolated` is {stated}, but 3605#1 was found as {found}", "leave `interpolated` out: 3605#1 stays as it was found";
}
