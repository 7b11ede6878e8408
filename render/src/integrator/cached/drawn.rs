//! What the records drawn onto a tile say of its surfaces: those that are held alike at once.

use super::kind::{Found, Shaded};
use super::kinds::{Glossy, Listed, Scratches, WithKind};
use super::policy::Treatment;
use super::shade::Shader;
use super::splat::Tile;
use super::surface::Surface;
use crate::cache::Drawn;
use crate::simd::widest;
use fearless_simd::Level;

/// What records say of each surface, as [`Shader::found`] says it.
pub(super) fn found(shader: &Shader, tile: &Tile, surfaces: &[&Surface], scratch: &mut Scratches) -> Vec<Found> {
    let mut found = vec![Found::NOTHING; surfaces.len()];
    let mut alike: Vec<(Glossy, Vec<usize>)> = Vec::new();
    let irradiance = Drawn { cache: &shader.caches.irradiance, near: &tile.irradiance };
    widest(
        Level::new(),
        #[inline(always)]
        || {
            for (i, s) in surfaces.iter().enumerate() {
                match shader.policy.treatment(s.finish()) {
                    Treatment::Irradiance => found[i] = shader.diffuse(s, &s.parts, &irradiance),
                    Treatment::Glossy(glossy) => match alike.iter_mut().find(|(other, _)| *other == glossy) {
                        Some((_, members)) => members.push(i),
                        None => alike.push((glossy, vec![i])),
                    },
                    Treatment::Traced => (),
                }
            }
            for (glossy, members) in &alike {
                let surfaces: Vec<_> =
                    members.iter().map(|&i| Shader::shaded(surfaces[i], &surfaces[i].parts)).collect();
                let light = glossy.with(&shader.policy.kinds, Splat { shader, tile, surfaces: &surfaces, scratch });
                members.iter().zip(light).for_each(|(&i, light)| found[i] = light);
            }
        },
    );
    found
}

/// Reads the records of a kind at surfaces that are held alike.
struct Splat<'a> {
    shader: &'a Shader<'a>,
    tile: &'a Tile,
    surfaces: &'a [Shaded<'a>],
    scratch: &'a mut Scratches,
}

impl WithKind for Splat<'_> {
    type Out = Vec<Found>;

    #[inline(always)]
    fn run<K: Listed>(self, kind: &K, held: K::Held) -> Vec<Found> {
        let Shader { caches, quality, .. } = self.shader;
        let records = Drawn { cache: K::cache(&caches.glossy), near: K::part(&self.tile.glossy) };
        kind.splat(held, &records, self.surfaces, quality, K::scratch(self.scratch))
    }
}
