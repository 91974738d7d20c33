//! A struct that is its own schema: what a section of a page may hold stands once.

/// A key of a section, for those who write pages and for the documents about them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// The key.
    pub name: &'static str,
    /// What it says, with unit and default.
    pub words: &'static str,
    /// The type that it is read into.
    pub of: &'static str,
}

/// A struct that is read from a section of a page. Each key stands here once, with its words, how it is
/// read, and what stands for an absent one:
///
/// ```text
/// key: Type = method(arguments)           what that method of the section makes of the key
/// field as key: Type = method(arguments)  the same, under another name
/// field: Type => expression               made of the section; fields above can be named
///   , or usual                            what stands for nothing
///   , must "words"                        the key has to be there, with what it is
///   , must                                nothing is made without it; why, is told already
/// ```
///
/// Every field is read before a missing one ends it, so all problems of the section are told at once.
macro_rules! section {
    (
        $(#[$of:meta])*
        $how:vis struct $name:ident($section:ident: $from:ty $(, $given:ident: $given_type:ty)*) {
            $(
                $(#[doc = $words:literal])*
                $shown:vis $field:ident $(as $key:ident)?: $type:ty
                    $(= $read:ident($($with:expr),*))? $(=> $value:expr)?
                    $(, or $usual:expr)? $(, must $($what:expr)?)?;
            )+
        }
    ) => {
        $(#[$of])*
        $how struct $name { $($(#[doc = $words])* $shown $field: $type,)+ }

        impl $name {
            /// Its keys, in the order in which they are read.
            $how const KEYS: &'static [Option<$crate::text::Key>] = &[$(
                $crate::text::part!(
                    @key $crate::text::part!(@name $field $($key)?),
                    concat!($($words),*), $type $(, $read)?
                )
            ),+];

            pub(crate) fn read($section: $from $(, $given: $given_type)*) -> Option<Self> {
                $(
                    $crate::text::part!(
                        @require $section $crate::text::part!(@name $field $($key)?) $($(, $what)?)?
                    );
                    let $field = $crate::text::part!(
                        @read $crate::text::part!(@name $field $($key)?),
                        $($section.$read($($with),*))? $(=> $value)?
                    )$(.unwrap_or($usual))?;
                )+
                Some(Self {
                    $($field: $crate::text::part!(@field $field $(or $usual)? $(must $($what)?)?)),+
                })
            }
        }
    };
}
pub(crate) use section;

/// A part of what [`section!`] makes of a field.
macro_rules! part {
    (@name $field:ident) => { stringify!($field) };
    (@name $field:ident $key:ident) => { stringify!($key) };
    (@key $name:expr, $words:expr, $type:ty) => { None };
    (@key $name:expr, $words:expr, $type:ty, $read:ident) => {
        Some($crate::text::Key {
            name: $name,
            words: $words,
            of: stringify!($type),
        })
    };
    (@require $section:ident $name:expr) => {};
    (@require $section:ident $name:expr, $what:expr) => { $section.require($name, $what) };
    (@read $name:expr, $section:ident.$read:ident($($with:expr),*)) => {
        $section.$read($name, $($with),*)
    };
    (@read $name:expr, => $value:expr) => { $value };
    (@field $field:ident must $($what:expr)?) => { $field? };
    (@field $field:ident $($or:tt)*) => { $field };
}
pub(crate) use part;
