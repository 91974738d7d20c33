//! What is refused of pages and tables, whatever they hold: each kind with its facts, its words and the next step,
//! one a line.

use crate::text::refusals;

const KEEP_ONE: &str = "keep one of the two";
const CHECK_FILE: &str = "check that the file is what it should be";
const CHECK_UNIT: &str = "check the number and its unit";

refusals! {
    // Files.
    many_lines(file, most) => "`{file}` has more than {most} lines, too many for a measurement or a job", format!("{CHECK_FILE}; remove blank lines, and measure fewer points");
    long_line(line, file, most) => "line {line} of `{file}` has more than {most} bytes, too many for a line", format!("{CHECK_FILE}; lines end with LF or CR LF");
    large_page(file, kib) => "`{file}` holds more than {kib} KiB, too much for a job, a profile, a template or a manifest", CHECK_FILE;
    not_text(file, what) => "`{file}` {what}, expected UTF-8 text", "save it as plain text in UTF-8 (a spreadsheet: `CSV UTF-8`)";
    // Pages of TOML.
    not_toml(message) => "not valid TOML: {message}", "see https://toml.io; strings need quotes, numbers a decimal point";
    key_twice(key) => "`{key}` is given twice in its section", KEEP_ONE;
    escape() => "a backslash between double quotes begins an escape such as `\\n`, expected a text without it", r"write `/` in a path, which Windows takes as well, or single quotes around it: 'C:\data\x.csv'";
    comma_in_number(number) => "`,` in a number, expected a decimal point", format!("{number}; numbers of a list stand in brackets, as `[0, 500]`");
    // Keys.
    unexpected(path, found, expected, key) => "`{path}` is {found}, expected {expected}", format!("write `{key} = …` with {expected}");
    missing(place, expected, key) => "{place}, expected {expected}", format!("add `{key} = …`");
    no_section(name) => "there is no section [{name}]", format!("add `[{name}]`");
    too_large(path, written) => "`{path}` is `{written}`, which is too large for any machine", CHECK_UNIT;
    other_word(path, word, list, help) => "`{path}` is `{word}`, expected one of {list}", help;
    unknown_key(name, section, help) => "unknown key `{name}`{section}", help;
    only_with(path, with) => "`{path}` as it stands goes only with {with}", format!("remove or change it, or write {with}");
    not_both(key, other, help) => "`{other}` and `{key}` are both given, expected one of the two", help;
    other_value(key, found, expected, help) => "`{key}` is `{found}`, expected {expected}", help;
    backwards(path, low, high) => "`{path}` makes a range from {low} to {high} mm, expected the smaller coordinate first", "write the smallest machine coordinate, then the largest";
    outside(path, axis, at, range, low, high) => "`{path}` puts {axis} at {at} mm, outside {range} {low} … {high} mm", "machine coordinates are meant: check them, and `travel_mm`";
    unseen(path) => "`{path}` holds a line break or another character that is not seen", "write it in one line of plain letters and digits";
    // Tables.
    open_quote() => "a quotation mark is opened but not closed in this row", "remove it; numbers need none";
    other_length(found, expected, help) => "the row has {found}, expected {expected} as in the header", help;
    other_number(name, found, what, help) => "`{name}` is {found}, {what}", help;
    many_columns(count, most, help) => "the first line has {count} columns, at most {most} are read", help;
    column_unit(name, what, list) => "column `{name}` has {what}, expected {list}", "the unit is part of the column's name";
    unknown_column(name, help) => "unknown column `{name}`", help;
}
