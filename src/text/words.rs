//! Closed lists of values, each with its word: in profiles, jobs, documents.

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

        impl $crate::text::words::Word for $name {
            const WORDS: &'static [(&'static str, $name)] = &[$(($word, $name::$value)),+];
        }

        #[allow(dead_code, reason = "some are only read")]
        impl $name {
            /// Its word.
            $how const fn word(self) -> &'static str {
                match self { $($name::$value => $word),+ }
            }
        }
    };
}
pub(crate) use words;
