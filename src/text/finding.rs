//! What a room has to say of a result: a kind with its facts and how grave it is. The words of a kind
//! stand beside it, in the list of its room (`findings.rs`), and nowhere else; no code reads them again. Likewise
//! closed lists of values, each with its word: in profiles, jobs, documents; and figures by their names.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::any::Any;
use std::collections::HashSet;
use std::fmt::{self, Display};
use std::hash::Hash;
use std::sync::Arc;

/// How grave a finding is, the gravest last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// What a figure rests on.
    Label,
    /// What whoever uses the result has to know.
    Note,
    /// What whoever measured is asked to look at again; it stands beside the verdict.
    Question,
    /// Why the figures may be wrong: a verdict that rests on them is at most undecided.
    Doubt,
    /// Two sources that contradict each other.
    Disagreement,
}

/// The closed list of what one room can find; the macro `findings!` makes it.
pub trait FindingKind: Any + Send + Sync {
    /// How grave it is.
    fn severity(&self) -> Severity;
    /// One sentence for a person, with its facts.
    fn words(&self) -> String;
}

/// A finding of any room. In JSON it is its words.
#[derive(Clone)]
pub struct Finding(Arc<dyn FindingKind>);

impl Finding {
    /// The kind with its facts, if it is one of the room that is asked for.
    pub fn kind<K: FindingKind>(&self) -> Option<&K> {
        let kind: &dyn Any = &*self.0;
        kind.downcast_ref()
    }

    /// How grave it is.
    pub(crate) fn severity(&self) -> Severity {
        self.0.severity()
    }
}

impl<K: FindingKind> From<K> for Finding {
    fn from(kind: K) -> Finding {
        Finding(Arc::new(kind))
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.words())
    }
}

impl fmt::Debug for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}: {self}", self.severity())
    }
}

impl PartialEq for Finding {
    fn eq(&self, other: &Finding) -> bool {
        self.severity() == other.severity() && self.0.words() == other.0.words()
    }
}

impl Serialize for Finding {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(&self.0.words())
    }
}

/// The findings of one gravity.
pub fn of_severity(findings: &[Finding], severity: Severity) -> Vec<Finding> {
    findings.iter().filter(|f| f.severity() == severity).cloned().collect()
}

/// Each item once, where it stands first; the work grows with their number, not with its square.
pub(crate) fn once<T: Eq + Hash>(mut items: Vec<T>) -> Vec<T> {
    let mut known = HashSet::with_capacity(items.len());
    let mut is_new = items.iter().map(|item| known.insert(item)).collect::<Vec<_>>().into_iter();
    items.retain(|_| is_new.next().unwrap_or_default());
    items
}

/// What belongs to each key; keys in the order in which they are met.
pub(crate) fn grouped<K: PartialEq, T>(
    pairs: impl IntoIterator<Item = (K, T)>,
) -> Vec<(K, Vec<T>)> {
    let mut groups: Vec<(K, Vec<T>)> = Vec::new();
    for (key, item) in pairs {
        match groups.iter_mut().find(|(own, _)| *own == key) {
            Some((_, items)) => items.push(item),
            None => groups.push((key, vec![item])),
        }
    }
    groups
}

/// `EXX, EYY`
pub(crate) fn joined<T: ToString>(items: impl IntoIterator<Item = T>) -> String {
    items.into_iter().map(|item| item.to_string()).collect::<Vec<String>>().join(", ")
}

/// `1 row`, `2 rows`
pub(crate) fn counted<N: fmt::Display + PartialEq + From<u8>>(number: N, thing: &str) -> String {
    let plural = if number == N::from(1) { "" } else { "s" };
    format!("{number} {thing}{plural}")
}

/// `a, b, c and 4 more`
pub(crate) fn listed(names: &[String]) -> String {
    const MOST_NAMES: usize = 6;
    let shown = names[..names.len().min(MOST_NAMES)].join(", ");
    match names.len().saturating_sub(MOST_NAMES) {
        0 => shown,
        rest => format!("{shown} and {rest} more"),
    }
}

/// The list of what a room can find, one kind a line: its facts, how grave it is, its words. The words are
/// a format string that names facts; further arguments of `format!` may follow.
///
/// ```ignore
/// findings! {
///     /// What a reading can find.
///     ReadFinding {
///         NoGrid { table: String } => Doubt, "table {table} has no grid";
///         Idle { names: Vec<String> } => Note, "{} are not used", names.join(", ");
///     }
/// }
/// ```
macro_rules! findings {
    (
        $(#[$meta:meta])* $name:ident {
            $($kind:ident $({ $($fact:ident : $type:ty),* $(,)? })?
                => $severity:ident, $words:literal $(, $argument:expr)* ;)*
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq)]
        #[allow(
            missing_docs,
            unreachable_pub,
            reason = "the words of a kind name its facts; a room that shares no kind keeps its list to itself"
        )]
        pub enum $name {
            $(#[doc = $words] $kind $({ $($fact: $type),* })?,)*
        }

        impl $crate::text::FindingKind for $name {
            fn severity(&self) -> $crate::text::Severity {
                match self {
                    $(Self::$kind { .. } => $crate::text::Severity::$severity,)*
                }
            }

            #[allow(unused_variables, reason = "a fact may serve tests and JSON only")]
            fn words(&self) -> String {
                match self {
                    $(Self::$kind $({ $($fact),* })? => format!($words $(, $argument)*),)*
                }
            }
        }
    };
}
pub(crate) use findings;

/// Entries of a document by their names, in their order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NamedEntries<K, T>(Vec<(K, T)>);

impl<K, T> FromIterator<(K, T)> for NamedEntries<K, T> {
    fn from_iter<I: IntoIterator<Item = (K, T)>>(entries: I) -> Self {
        NamedEntries(entries.into_iter().collect())
    }
}

impl<K, T> NamedEntries<K, T> {
    /// Name and entry.
    pub(crate) fn iter(&self) -> std::slice::Iter<'_, (K, T)> {
        self.0.iter()
    }
}

impl<K: Display, T: Serialize> Serialize for NamedEntries<K, T> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_map(self.0.iter().map(|(name, entry)| (name.to_string(), entry)))
    }
}

/// Such a list.
pub(crate) trait Word: Copy + PartialEq + 'static {
    /// Each word with its value.
    const WORDS: &'static [(&'static str, Self)];
}

/// Reads a word of a list.
pub(crate) fn read_word<'de, T: Word, D: Deserializer<'de>>(from: D) -> Result<T, D::Error> {
    let word = String::deserialize(from)?;
    let found = T::WORDS.iter().find(|(own, _)| *own == word);
    found.map(|(_, value)| *value).ok_or_else(|| {
        D::Error::custom(format!(
            "`{word}` is none of {}",
            joined(T::WORDS.iter().map(|(own, _)| own))
        ))
    })
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

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
                $crate::text::read_word(from)
            }
        }
    };
}
pub(crate) use words;

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;
    use std::hash::Hasher;

    findings! {
        /// What a test can find.
        Found {
            NoGrid { table: String, points: usize } => Doubt, "table {table} has no grid";
            Idle { names: Vec<String> } => Note, "{} are not used", names.join(", ");
            Quiet => Label, "nothing moved";
        }
    }

    /// A text that counts how often it is looked at.
    #[derive(Debug)]
    struct Counted<'a>(String, &'a Cell<usize>);

    impl PartialEq for Counted<'_> {
        fn eq(&self, other: &Self) -> bool {
            self.1.set(self.1.get() + 1);
            self.0 == other.0
        }
    }

    impl Eq for Counted<'_> {}

    impl Hash for Counted<'_> {
        fn hash<H: Hasher>(&self, state: &mut H) {
            self.1.set(self.1.get() + 1);
            self.0.hash(state);
        }
    }

    #[test]
    fn equal_items_are_one_and_each_is_looked_at_a_few_times() {
        assert_eq!(once(vec!["b", "a", "b", "c", "a"]), ["b", "a", "c"]);
        for count in [1_000, 10_000, 100_000] {
            let looks = Cell::new(0);
            let items = (0..count).map(|n| Counted(format!("text {}", n / 2), &looks)).collect();
            assert_eq!(once(items).len(), count / 2);
            assert!(looks.get() <= 4 * count, "{} looks at {count} items", looks.get());
        }
    }

    #[test]
    fn a_finding_keeps_its_kind_and_says_its_words() {
        let facts = Found::NoGrid { table: "EXX".to_string(), points: 3 };
        let finding = Finding::from(facts.clone());
        assert_eq!(finding.to_string(), "table EXX has no grid");
        assert_eq!(finding.severity(), Severity::Doubt);
        assert_eq!(finding.kind(), Some(&facts));
        let idle = Found::Idle { names: vec!["a".to_string(), "b".to_string()] };
        assert_eq!(Finding::from(idle).to_string(), "a, b are not used");
        assert!(Finding::from(Found::Quiet).severity() < Severity::Doubt);
    }
}
