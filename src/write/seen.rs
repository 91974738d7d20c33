//! What templates see: texts, lists and names, as the template engine holds them. Made once, so that no other tree of
//! the same texts stands between.

use tera::Map;
use tera::value::Key;

/// A finished text, a list, or names with what they stand for.
pub(crate) type Seen = tera::Value;

/// Names in this order.
pub(crate) fn named<const N: usize>(names: [(&'static str, Seen); N]) -> Seen {
    names.into_iter().map(|(name, own)| (Key::Str(name), own)).collect::<Map>().into()
}

/// Names, and one more.
pub(crate) fn with(names: Seen, name: &'static str, own: Seen) -> Seen {
    let mut names = names.into_map().unwrap_or_default();
    names.insert(Key::Str(name), own);
    names.into()
}

/// `seen! { "name": text, … }`: names in this order, each with a text, a list of texts, or what is seen of something.
macro_rules! seen {
    ($($name:literal: $own:expr),* $(,)?) => {
        $crate::write::seen::named([$(($name, $own.into())),*])
    };
}

pub(crate) use seen;
