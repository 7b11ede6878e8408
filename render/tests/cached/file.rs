//! Cache files: the same picture again, records kept as the camera moves, and files that are not what they should be.

use crate::common::{table, world};
use render::cache::Spacing;
use render::integrator::cached::file::{CacheFileError, load, save};
use render::integrator::cached::policy::{Allowed, Policy};
use render::integrator::cached::{Interpolation, Settings, render_cached};
use render::picture::Budget;
use render::record::eas::Estimator;
use render::world::World;

const SIZE: [(&str, &str); 2] = [("width", "32"), ("height", "32")];
const TAU: f32 = 0.1;

fn policy(world: &World) -> Policy {
    Policy::new(&world.scene, Allowed::Eas, |r| Ok::<_, ()>(table(r))).expect("tables fit")
}

fn settings() -> Settings {
    Settings {
        tolerance: Some(TAU),
        estimator: Estimator::Improved,
        spacing: Spacing::default(),
        sources: None,
        budget: Budget::Samples(2),
        seed: 3,
        indirect_only: false,
        interpolation: Interpolation::Auto,
    }
}

#[test]
fn a_cache_file_gives_the_same_picture_and_serves_other_cameras() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("box.cache");
    let here = world("cornell-glossy.xml", &SIZE);
    let policy = policy(&here);
    let (picture, figures, caches) = render_cached(&here, &policy, &settings(), None, &|_| ());
    save(&path, &here, &policy, &settings(), TAU, &caches).unwrap();
    let bytes = std::fs::read(&path).unwrap();

    let kept = load(&path, &here, &policy, &settings(), TAU).unwrap();
    assert!(kept.complete);
    let (again, same, caches) = render_cached(&here, &policy, &settings(), Some(kept), &|_| ());
    assert_eq!((same.glossy.eas.records, same.bytes), (figures.glossy.eas.records, figures.bytes));
    assert!(again.image().pixels == picture.image().pixels);
    save(&path, &here, &policy, &settings(), TAU, &caches).unwrap();
    assert!(std::fs::read(&path).unwrap() == bytes);

    // The camera moves, by a pixel and by a step: what is there stays, a few records come.
    for (eye, most) in [("2.95 2.73 -8", 1.25), ("3.2 2.9 -7.6", 2.0)] {
        let moved = world("cornell-glossy.xml", &[SIZE[0], SIZE[1], ("eye", eye)]);
        let kept = load(&path, &moved, &policy, &settings(), TAU).unwrap();
        assert!(!kept.complete);
        let (_, more, _) = render_cached(&moved, &policy, &settings(), Some(kept), &|_| ());
        let grown = more.glossy.eas.records as f64 / figures.glossy.eas.records as f64;
        println!("records of a camera at {eye}: {grown:.2} times those of the first");
        assert!((1.0..most).contains(&grown), "{eye}: {grown}");
    }
}

#[test]
fn damaged_and_stale_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("box.cache");
    let here = world("cornell-glossy.xml", &SIZE);
    let policy_here = policy(&here);
    let (_, _, caches) = render_cached(&here, &policy_here, &settings(), None, &|_| ());
    save(&path, &here, &policy_here, &settings(), TAU, &caches).unwrap();
    let good = std::fs::read(&path).unwrap();
    let read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        load(&path, &here, &policy_here, &settings(), TAU).map(|l| l.complete)
    };
    assert!(read(&good).unwrap());
    for length in [0, 3, 8, 12, 15, 40, 200, good.len() / 2, good.len() - 1] {
        assert!(matches!(read(&good[..length]), Err(CacheFileError::Format(_))), "{length}");
    }
    // Any flipped bit is found; a repaired checksum does not open the door to numbers that are none.
    for at in (0..good.len()).step_by(good.len() / 97) {
        let mut bytes = good.clone();
        bytes[at] ^= 0x40;
        assert!(read(&bytes).is_err(), "{at}");
    }
    let start = 16 + u32::from_le_bytes(good[12..16].try_into().unwrap()) as usize;
    let words: Vec<usize> = (start..good.len() - 8).step_by(4).step_by(good.len() / 800).collect();
    let refused = |&at: &usize| {
        let mut bytes = good.clone();
        let body = good.len() - 4;
        bytes[at..at + 4].fill(0xff);
        let sum = crc32fast::hash(&bytes[..body]).to_le_bytes();
        bytes[body..].copy_from_slice(&sum);
        read(&bytes).is_err()
    };
    // All but packed normals, one word in ten, which have no bad values.
    let count = words.iter().filter(|at| refused(at)).count();
    assert!(count * 100 > words.len() * 80, "{count} of {}", words.len());
    // Another scene, other materials.
    std::fs::write(&path, &good).unwrap();
    for (scene, defines) in [("floor.xml", vec![("n", "100")]), ("materials.xml", vec![])] {
        let other = world(scene, &[&SIZE[..], &defines[..]].concat());
        let found = load(&path, &other, &policy(&other), &settings(), TAU);
        assert!(matches!(found, Err(CacheFileError::Stale(_))), "{scene}");
    }
    assert!(matches!(load(folder.path(), &here, &policy_here, &settings(), TAU), Err(CacheFileError::Io(_))));
}
