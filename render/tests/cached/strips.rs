//! A picture whose surfaces do not all fit into memory is rendered strip by strip.

use crate::common::{settings, table, world};
use render::integrator::cached::policy::{Allowed, Policy};
use render::integrator::cached::{Interpolation, Rendering, Settings, kept_pixels};
use render::picture::{Budget, Picture};
use render::scene::Crop;
use std::time::Instant;

const TOLERANCE: f32 = 0.2;

/// Whatever the strips, and whoever sums the records: the same picture, of a part of a film too.
#[test]
fn strips_do_not_show() {
    let mut world = world("cornell-glossy.xml", &[("width", "40"), ("height", "56")]);
    world.scene.camera.film.crop = Some(Crop { x: 3, y: 5, width: 37, height: 49 });
    let policy = Policy::new(&world.scene, Allowed::Auto, |r| Ok::<_, ()>(table(r))).expect("no table is refused");
    for interpolation in [Interpolation::Octree, Interpolation::Splat] {
        let settings = Settings { tolerance: Some(TOLERANCE), budget: Budget::Samples(5), interpolation, ..settings() };
        let rendering = Rendering::new(&world, &policy, &settings);
        let filled = rendering.fill(&world, TOLERANCE, None, None, &|_| ());
        let picture = |rendering: &Rendering| -> Picture {
            rendering.shade(&world, TOLERANCE, &filled, (settings.budget, 5), Instant::now(), &|_| ()).0
        };
        let whole = picture(&rendering);
        for pixels in [1, 37 * 16, 37 * 32] {
            let strips = picture(&rendering.clone().in_strips(pixels));
            assert!(strips.image().pixels == whole.image().pixels, "{interpolation:?} {pixels}");
            assert_eq!(strips.counts, whole.counts);
        }
    }
}

#[test]
fn large_films_keep_the_surfaces_of_few_rows() {
    let film = |width, height| Crop { x: 0, y: 0, width, height };
    assert_eq!(kept_pixels(film(512, 512), true), 512 * 512);
    let large = kept_pixels(film(7680, 4320), true);
    assert!((1 << 20..(1 << 20) + 7680 * 16).contains(&large), "{large}");
    assert_eq!(kept_pixels(film(7680, 4320), false), 7680 * 4320);
}
