//! The families of controls that there are.

use crate::control::controller::fact::{Facts, Mechanism};
use crate::control::controller::{
    DeclaredFacts, Dialect, Family, FanucFacts, IsgFacts, LinuxcncFacts, SiemensFacts,
};
use crate::control::controller::{declared, fanuc, generic, isg, linuxcnc, siemens};

/// A family, and how the facts of its controls are read.
pub(super) type Known = (&'static Family, fn(&Facts<'_>) -> Option<Dialect>);

/// All of them, in the order in which they are named.
pub(super) const FAMILIES: [Known; 6] = [
    (&siemens::FAMILY, |facts| SiemensFacts::read(facts).map(Dialect::Siemens)),
    (&fanuc::FAMILY, |facts| FanucFacts::read(facts).map(Dialect::Fanuc)),
    (&generic::FAMILY, |facts| DeclaredFacts::typed(facts).map(Dialect::Declared)),
    (&declared::FAMILY, |facts| DeclaredFacts::checked(facts).map(Dialect::Declared)),
    (&linuxcnc::FAMILY, |facts| LinuxcncFacts::read(facts).map(Dialect::Linuxcnc)),
    (&isg::FAMILY, |facts| IsgFacts::read(facts).map(Dialect::Isg)),
];

/// What sign proofs can prove, with the words of profiles.
pub(super) fn proved() -> Vec<(&'static str, Mechanism)> {
    let proofs = FAMILIES.iter().flat_map(|(family, _)| family.proofs);
    let mechanisms = proofs.map(|proof| proof.mechanism);
    mechanisms.map(|own| (own.word(), own)).collect()
}
