//! The kinds of glossy records. Adding one is a folder here with its `mod`, and a line of the list.

#[cfg(test)]
mod ambient;
pub mod eas;
pub mod harmonics;
mod list;
mod listed;

use crate::record::harmonics::HarmonicsSettings;
pub use listed::{Description, EachKind, Listed, WithKind};

list::kinds! {
    eas: Eas,
    harmonics: Harmonics(settings: HarmonicsSettings),
    #[cfg(test)]
    ambient: Ambient,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Kinds that had a name or their sample points in common could not be told apart.
    #[test]
    fn kinds_are_told_apart() {
        for (i, kind) in KINDS.iter().enumerate() {
            let others = || KINDS[..i].iter();
            assert!(others().all(|other| other.name != kind.name && other.mean_key != kind.mean_key), "{}", kind.name);
            assert!(others().all(|other| other.salt != kind.salt) && kind.salt > 2, "{}", kind.name);
        }
    }
}
