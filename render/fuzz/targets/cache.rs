//! A cache file: header and checksum are those of a small scene, its counts and records the bytes of the target. It is
//! refused, or gives a pixel of finite light.
#![no_main]

use libfuzzer_sys::fuzz_target;
use render::cache::Spacing;
use render::integrator::cached::file::{from_bytes, save};
use render::integrator::cached::kinds::COUNT;
use render::integrator::cached::policy::{Allowed, Policy};
use render::integrator::cached::{Caches, Settings, TOLERANCE, render_cached};
use render::picture::Budget;
use render::record::eas::Estimator;
use render::record::harmonics::{Basis, Gradients, HarmonicsSettings};
use render::scene::load::{Options, load};
use render::tables::Tables;
use render::world::World;
use std::path::Path;
use std::sync::LazyLock;

/// A method with what its files begin with: all but the counts of records that end the header.
struct Method {
    policy: Policy,
    prefix: Vec<u8>,
}

/// Place of the method's checksum in a file.
const METHOD: std::ops::Range<usize> = 40..48;
/// Bytes of the counts: coarse and other irradiance records, then each kind.
const COUNTS: usize = 8 * (2 + COUNT);

static WORLD: LazyLock<World> = LazyLock::new(|| {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/scenes/cornell-glossy.xml");
    let defines = ["width", "height"].map(|name| (name.to_owned(), "1".to_owned())).to_vec();
    let (scene, _) = load(&scene, &Options { defines, ..Options::default() }).expect("the scene is there");
    World::new(scene).expect("the scene is whole")
});

static METHODS: LazyLock<[Method; 2]> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tables");
    let mut tables = Tables::open(&folder).expect("the tables are there");
    let harmonics = HarmonicsSettings::new(Basis::default(), Gradients::default(), TOLERANCE, None);
    [Allowed::Auto, Allowed::Harmonics(harmonics)].map(|allowed| {
        let policy = Policy::new(&WORLD.scene, allowed, |recipe| tables.find(recipe)).expect("the tables fit");
        let (min, max) = WORLD.bounds();
        let path = std::env::temp_dir().join(format!("render-fuzz-{}.cache", std::process::id()));
        save(&path, &WORLD, &policy, &settings(), TOLERANCE, &Caches::new(min, max)).expect("a place for it");
        let mut prefix = std::fs::read(&path).expect("it was written");
        std::fs::remove_file(&path).expect("it is there");
        prefix.truncate(prefix.len() - 4 - COUNTS);
        Method { policy, prefix }
    })
});

fn settings() -> Settings {
    Settings {
        tolerance: Some(TOLERANCE),
        estimator: Estimator::Improved,
        spacing: Spacing::default(),
        sources: None,
        budget: Budget::Samples(1),
        seed: 0,
        indirect_only: false,
        interpolation: Default::default(),
    }
}

fuzz_target!(init: render_fuzz::one_thread(), |data: &[u8]| {
    // Whole files, the seeds, are of the method that they name.
    let named = METHODS.iter().find(|m| data.get(METHOD) == Some(&m.prefix[METHOD]));
    let method = named.unwrap_or(&METHODS[data.len() % 2]);
    let records = if named.is_some() { data.get(method.prefix.len()..).unwrap_or_default() } else { data };
    let mut bytes = [&method.prefix, records].concat();
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    match from_bytes(&bytes, &WORLD, &method.policy, &settings(), TOLERANCE) {
        Ok(mut loaded) => {
            // Nothing is added to the records.
            loaded.complete = true;
            let (picture, ..) = render_cached(&WORLD, &method.policy, &settings(), Some(loaded), &|_| ());
            assert!(picture.pixels.iter().all(|p| p.sum().is_finite()), "light that is not finite");
        }
        Err(error) => render_fuzz::check_message(&error.to_string()),
    }
});
