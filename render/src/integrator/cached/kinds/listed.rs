//! A kind by its place in the list of kinds, and what is done with whichever kind it is.

use super::{Allowed, Glossy, GlossyCaches, Kinds, PerKind, Scratches};
use crate::cache::Cache;
use crate::integrator::cached::kind::{GlossyKind, KindFigures};
use brdf_tables::brdf::Specular;

/// What a kind says of itself, for a command line.
#[derive(Clone, Copy)]
pub struct Description {
    /// [`GlossyKind::NAME`].
    pub name: &'static str,
    /// [`GlossyKind::ABOUT`].
    pub about: &'static str,
    /// [`GlossyKind::MEAN_KEY`].
    pub mean_key: &'static str,
    /// [`GlossyKind::TABLES`].
    pub tables: bool,
    /// [`GlossyKind::SALT`].
    pub salt: u64,
    /// What asks for it alone, with its own defaults, at the tolerance τ.
    pub alone: fn(f32) -> Allowed,
    /// [`GlossyKind::outlook`].
    pub outlook: fn(&Specular) -> Option<String>,
    /// [`GlossyKind::sentence`].
    pub sentence: fn(&KindFigures) -> String,
}

impl Description {
    /// That of a kind.
    pub const fn of<K: Listed>() -> Self {
        Self {
            name: K::NAME,
            about: K::ABOUT,
            mean_key: K::MEAN_KEY,
            tables: K::TABLES,
            salt: K::SALT,
            alone: K::alone,
            outlook: K::outlook,
            sentence: K::sentence,
        }
    }
}

/// A kind that stands in the list of kinds: where it has its part of what is kept for all.
pub trait Listed: GlossyKind {
    /// What asks for it alone, with its own defaults, at the tolerance τ.
    fn alone(tolerance: f32) -> Allowed;
    /// What is known of the materials.
    fn of(kinds: &Kinds) -> &Self;
    /// How a material is held, if by this kind.
    fn held(glossy: Glossy) -> Option<Self::Held>;
    /// The records.
    fn cache(caches: &GlossyCaches) -> &Cache<Self::Record>;
    /// The records, to add to.
    fn cache_mut(caches: &mut GlossyCaches) -> &mut Cache<Self::Record>;
    /// The memory for reading them.
    fn scratch(scratches: &mut Scratches) -> &mut Self::Scratch;
    /// Its part of what there is for each kind.
    fn part<T>(parts: &PerKind<T>) -> &T;
    /// Its part, to change.
    fn part_mut<T>(parts: &mut PerKind<T>) -> &mut T;
}

/// Something to do with the kind that holds a material.
pub trait WithKind {
    /// What comes of it.
    type Out;
    /// Does it.
    fn run<K: Listed>(self, kind: &K, held: K::Held) -> Self::Out;
}

/// Something to do with every kind.
pub trait EachKind {
    /// Why it may stop.
    type Error;
    /// Does it with one.
    ///
    /// # Errors
    /// To stop.
    fn run<K: Listed>(&mut self) -> Result<(), Self::Error>;
}
