//! A variable and its value.

use crate::read::lexer::Complaint;
use std::borrow::Cow;
use std::ops::Range;

/// `$NAME[index,…]=value`.
#[derive(Debug)]
pub(super) struct Assignment<'a> {
    /// Name without `$`, upper case.
    pub(super) name: Cow<'a, str>,
    /// Name and indices in the text.
    pub(super) head: Range<usize>,
    /// The indices, upper case.
    pub(super) indices: Vec<Cow<'a, str>>,
    /// Where the value stands.
    pub(super) value_span: Range<usize>,
    /// The value; a complaint if it cannot be read.
    pub(super) value: Result<Value, Complaint>,
}

/// The right side of an assignment.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    /// A number.
    Number(f64),
    /// `TRUE` or `FALSE`.
    Truth(bool),
    /// A name in parentheses or quotes, upper case.
    Name(String),
}

pub(super) fn is_digits(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}
