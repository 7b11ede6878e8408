//! What a cache file was made for.

use super::super::Settings;
use super::super::caches::Caches;
use super::super::kinds::{self, COUNT, EachKind, Listed};
use super::super::policy::Policy;
use super::error::CacheFileError;
use super::mark::WalkMark;
use crate::cache::Spacing;
use crate::record::eas::Estimator;
use crate::scene::checksum::{Checksums, Hash};
use crate::world::World;
use core::convert::Infallible;
use serde::{Deserialize, Serialize};

/// Most bytes of a header.
pub(super) const MAX_HEADER: usize = 1 << 16;

/// What a file was made for, and how many records it holds. Numbers are checksums, but for those.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Header {
    scene: u64,
    materials: u64,
    tables: u64,
    method: u64,
    camera: u64,
    estimator: Estimator,
    pub(super) tolerance: f32,
    spacing: Spacing,
    sources: Option<u64>,
    indirect_only: bool,
    pub(super) coarse: u64,
    pub(super) irradiance: u64,
    /// Number of records of each kind, in the order of the list.
    pub(super) glossy: [u64; COUNT],
    pub(super) walk: Option<WalkMark>,
}

impl Header {
    /// What a rendering would write, counts aside.
    pub(super) fn new(world: &World, policy: &Policy, settings: &Settings, tolerance: f32) -> Self {
        let Checksums { geometry, materials, camera } = Checksums::new(&world.scene);
        let mut keys = Keys { policy, tables: Hash::default(), method: Hash::default() };
        keys.method.encoded(&policy.treatments());
        let Ok(()) = kinds::each(&mut keys);
        Self {
            scene: geometry,
            materials,
            tables: keys.tables.finish(),
            method: keys.method.finish(),
            camera,
            estimator: settings.estimator,
            tolerance,
            spacing: settings.spacing,
            sources: settings.sources.map(|n| n as u64),
            indirect_only: settings.indirect_only,
            coarse: 0,
            irradiance: 0,
            glossy: [0; COUNT],
            walk: None,
        }
    }

    /// Bytes for a file.
    pub(super) fn encoded(&self) -> Result<Vec<u8>, CacheFileError> {
        bincode::serde::encode_to_vec(self, config()).map_err(|_| CacheFileError::Format("header"))
    }

    /// The header of these bytes, all of which it must take.
    pub(super) fn decoded(bytes: &[u8]) -> Result<Self, CacheFileError> {
        let (found, used) =
            bincode::serde::decode_from_slice(bytes, config()).map_err(|_| CacheFileError::Format("header"))?;
        if used == bytes.len() { Ok(found) } else { Err(CacheFileError::Format("header")) }
    }

    /// Refuses records of something else.
    pub(super) fn check(&self, wanted: &Self) -> Result<(), CacheFileError> {
        let same = [
            (self.scene == wanted.scene, "scene"),
            (self.materials == wanted.materials, "set of materials"),
            (self.method == wanted.method, "method"),
            (self.tables == wanted.tables, "set of tables"),
            (self.estimator == wanted.estimator, "estimator"),
            (self.indirect_only == wanted.indirect_only, "part of the light"),
            (self.sources == wanted.sources, "number of sources"),
        ];
        same.into_iter().find(|(same, _)| !same).map_or(Ok(()), |(_, what)| Err(CacheFileError::Stale(what)))
    }

    /// Whether records were made alike: at the same τ, as far from each other.
    pub(super) fn is_alike(&self, other: &Self) -> bool {
        self.tolerance == other.tolerance && self.spacing == other.spacing
    }

    /// The same at another τ.
    pub(super) fn at(&self, tolerance: f32) -> Self {
        Self { tolerance, ..self.clone() }
    }

    /// The same whatever the camera.
    pub(super) fn without_camera(&self) -> Self {
        Self { camera: 0, ..self.clone() }
    }

    /// Notes how many records there are, and for which walk.
    pub(super) fn count(&mut self, caches: &Caches) {
        self.coarse = caches.coarse.records().len() as u64;
        self.irradiance = caches.irradiance.records().len() as u64;
        for (count, kind) in self.glossy.iter_mut().zip(caches.glossy.figures().iter()) {
            *count = kind.records as u64;
        }
        self.walk.clone_from(&caches.walk);
    }

    /// Whether records are all that the camera needs.
    pub(super) fn is_complete(&self, wanted: &Self) -> bool {
        self.camera == wanted.camera && self.is_alike(wanted)
    }
}

/// Checksums of what the kinds made their records for.
struct Keys<'a> {
    policy: &'a Policy,
    tables: Hash,
    method: Hash,
}

impl EachKind for Keys<'_> {
    type Error = Infallible;

    fn run<K: Listed>(&mut self) -> Result<(), Infallible> {
        K::of(&self.policy.kinds).key(&mut self.tables, &mut self.method);
        Ok(())
    }
}

fn config() -> impl bincode::config::Config {
    bincode::config::legacy().with_limit::<MAX_HEADER>()
}
