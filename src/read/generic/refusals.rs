//! What is refused of a generic table and of a list that was typed: each kind with its facts, its words and the next
//! step, one a line.

use crate::text::refusals;

/// The next step where a document of the generic table is none.
pub(super) const NINE_KEYS: &str =
    "expected {\"schema\":1,\"rows\":[…]} with the nine columns as keys of each row";

refusals! {
    other_term(term, names) => "`term` is `{term}`, expected the name of a term", format!("known terms: {names}");
    other_direction(symbol) => "`direction` is `{symbol}`, expected `+`, `-` or nothing", "an empty direction means both";
    nameless_axis(column, name) => "`{column}` is `{name}`, expected the name of an axis", "write the control's name of the axis, as in the job";
    not_opposite(correction, opposite) => "`correction_um` is {correction}, expected {opposite}, the opposite of the deviation", "a correction cancels the deviation of its row exactly";
    first_increment(um) => "`increment_um` is `{um}`, expected nothing at index 0", "there is no point before the first one";
    no_increment() => "`increment_um` is empty, expected a finite number", "only the first point of a block has none";
    with_and_without(base, output) => "from {base} to {output} there are blocks with and without direction; which one acts is not known", "a pair of axes has one block, or one for each direction";
    one_way_position() => "a position that the block of the other direction does not have", "both directions of a pair of axes lie at the same positions";
    another_axis(name, most) => "`{name}` is another axis, expected at most {most}", "no control has so many: check that this is a table of corrections";
    two_axes(name, axis, term, other) => "`{name}` stands for the {axis} axis in {term}, but for the {other} axis before", "EYX is Y while X moves: `base_axis` X, `output_axis` Y";
    not_next(index, expected) => "`index` is {index}, expected {expected} as the next of its block", "each term, pair of axes and direction is one block, counted from 0 without gaps and written once";
    one_point() => "a block of one point, expected two or more", "a line needs two points; the rows after this one may have been lost";
    not_behind(to, from) => "`position_mm` is {to}, expected more than {from} of the row before", "the positions of a block ascend";
    other_increment(increment, change) => "`increment_um` is {increment}, expected {change}, the change of the correction", "an increment is the correction minus the correction of the row before";
    other_spacing(step, usual) => "`position_mm` is {step} mm after the row before, expected {usual} mm", "the positions of a block are equally spaced; a row may be missing";
    no_json(what) => "the JSON cannot be read: {what}", format!("{NINE_KEYS}; the file may have been cut off");
    other_schema(schema) => "`schema` is {schema}, expected 1", NINE_KEYS;
    no_table(first_line) => "the file is empty, expected a generic table", first_line;
    no_rows() => "the table has no rows", "each row is one point; the file may have been cut off";
    many_rows(most) => "the table has more than {most} rows, too many for any control", "check that this is a table of corrections";
    unknown_column(name, help) => "unknown column `{name}`", help;
    column_twice(name) => "column `{name}` stands in the header twice", "remove one of the two";
    no_column(name, help) => "the header has no column `{name}`", help;
    no_index(index) => "`index` is `{index}`, expected a whole number from 0", "the points of a block are counted 0, 1, 2, …";
    no_list(file, column) => "`{file}` is no list with a column `{column}`", "this control holds what was typed in: take `typed.csv` of the kit";
    no_twins(difference) => "two files of the kit are not twins: {difference}", "CSV and JSON of a kit hold the same rows; one of them was changed or cut off, generate both again";
    empty(file) => "`{file}` is empty";
    columns_of_values(count, names) => "the list has {count} columns of values, expected one", format!("one of {names}");
    no_point(found, sum) => "`point` is `{found}`, expected the number of a point or `{sum}`", "take the list from the kit again";
    not_one_sum(page) => "page `{page}` has no sum, or more than one", "rows of this page may be missing: take the list from the kit again";
    other_sum(column, total, unit, page, stated, help) => "`{column}` adds up to {total} {unit} on page {page}, its sum is {stated} {unit}", help;
    not_seen(missing, all) => "`seen` is empty in {missing} of {all} lines", "read every point on the control's screen and fill in what it shows";
    nowhere_zero() => "no point of this table lies at `zero_mm`, where the correction is zero", "`zero_mm` is the reference point, in machine coordinates";
    increment_from_nothing(what) => "{what} has an increment, expected 0", "an increment is the change over the section before; there is none";
}
