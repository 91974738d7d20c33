//! Reads text and bytes, and reports problems with file, line and column.

mod delimited;
mod document;
mod finding;
pub(crate) mod plain;
mod problem;
mod refusals;

pub(crate) use self::document::{
    Pages, json_page, not_utf_8, part, read_page, refuse_large_page, refuse_long_lines,
    refuse_many_lines, section, states, template_text,
};

pub use self::delimited::{LengthUnit, Line, lines};
pub(crate) use self::delimited::{
    header_and_rows, plain_number, refuse_many_columns, refuse_other_first_line, unknown_column,
    written_number,
};
pub(crate) use self::document::keys::{LIMITS, Places};
pub use self::document::{
    Key, LARGEST_FILE_MIB, LARGEST_NUMBER, LARGEST_PAGE, LONGEST_LINE_BYTES, LONGEST_MM,
    MOST_LINES, MOST_POINTS, MOST_ROWS, Section, Source, sha256,
};
pub use self::finding::{Finding, FindingKind, Severity, of_severity};
pub(crate) use self::finding::{
    NamedEntries, Word, counted, findings, grouped, joined, listed, once, read_word, words,
};
pub(crate) use self::plain::{BLANK, BOX, escaped, marked};
pub use self::plain::{is_unseen, line, page};
pub use self::problem::{LineIndex, Place, Problem, Problems, nearest, shown};
pub(crate) use self::problem::{Notes, bounded, did_you_mean, refusals};
