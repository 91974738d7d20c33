//! Closed lists of values, each with its word: in profiles, jobs, documents; and figures by their names.

use serde::{Serialize, Serializer};
use std::fmt::Display;

/// Entries of a document by their names, in their order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Named<K, T>(Vec<(K, T)>);

impl<K, T> FromIterator<(K, T)> for Named<K, T> {
    fn from_iter<I: IntoIterator<Item = (K, T)>>(entries: I) -> Self {
        Named(entries.into_iter().collect())
    }
}

impl<K: Display, T: Serialize> Serialize for Named<K, T> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_map(self.0.iter().map(|(name, entry)| (name.to_string(), entry)))
    }
}

/// Such a list.
pub(crate) trait Word: Copy + PartialEq + 'static {
    /// Each word with its value.
    const WORDS: &'static [(&'static str, Self)];
}

/// The value and its word, side by side.
macro_rules! words {
    ($(#[$of:meta])* $how:vis enum $name:ident { $($(#[$value_of:meta])* $value:ident = $word:literal,)+ }) => {
        $(#[$of])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $how enum $name { $($(#[$value_of])* $value),+ }

        impl $crate::text::Word for $name {
            const WORDS: &'static [(&'static str, $name)] = &[$(($word, $name::$value)),+];
        }

        #[allow(dead_code, reason = "some are only read")]
        impl $name {
            /// Its word.
            $how const fn word(self) -> &'static str {
                match self { $($name::$value => $word),+ }
            }
        }

        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
                to.serialize_str(self.word())
            }
        }
    };
}
pub(crate) use words;
