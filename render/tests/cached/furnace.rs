//! Constant light: whatever the estimator, the reflected radiance is the albedo.

use crate::common::{gathered, phong};
use glam::Vec3A;
use render::frame::Frame;
use render::hemisphere::{Incident, hemisphere_directions};
use render::record::eas::{EasRecord, Estimator};
use render::record::{Albedo, Centroid, CutSettings, Receiver, Reflector, Scratch, Tree, cut, reflect};

/// Largest deviation of (reflected radiance / albedo) from 1 over views up to 70°, and the number of sources.
fn furnace(exponent: f64, max_eas: usize, estimator: Estimator) -> (f32, usize) {
    let table = phong(exponent);
    let albedo = Albedo::new(&table);
    let reflector = Reflector::new(&table, Vec3A::ZERO, Vec3A::ONE);
    let frame = Frame::from_normal(Vec3A::new(0.48, 0.6, 0.64));
    let light = Incident { radiance: Vec3A::ONE, distance: f32::INFINITY, normal: Vec3A::ZERO };
    let mut samples = gathered(&frame, 0.1, 0.5, 4, |_| light);
    let centroid = match estimator {
        Estimator::Paper => Centroid::Position,
        Estimator::Improved => Centroid::Direction,
    };
    let tree = Tree::new(&mut samples, 4, centroid);
    // Every cut of a constant hemisphere is good: τ = 0 asks for the most sources.
    let settings = CutSettings { tolerance: 0.0, max_eas };
    let cut = cut(&tree, &reflector, &hemisphere_directions(64), &settings);
    let record = EasRecord::new(Vec3A::ZERO, &frame, 0, &tree, &cut, estimator);
    let mut scratch = Scratch::default();
    let worst = hemisphere_directions(200)
        .into_iter()
        .filter(|wo| wo.z > 70f32.to_radians().cos())
        .map(|wo| {
            let at = Receiver { position: Vec3A::ZERO, frame, wo };
            let found = reflect(&record, &at, &reflector, &albedo, estimator, &mut scratch).specular.x;
            (found / albedo.at(wo) - 1.0).abs()
        })
        .fold(0.0, f32::max);
    (worst, record.sources.len())
}

/// Within 1 % for every exponent; the paper's estimator, whose caps do not tile the hemisphere, is measured beside it.
#[test]
fn constant_light_reflects_the_albedo() {
    for exponent in [5.0, 40.0, 100.0, 200.0, 500.0] {
        for max_eas in [127, 511] {
            let (ours, count) = furnace(exponent, max_eas, Estimator::Improved);
            let (paper, _) = furnace(exponent, max_eas, Estimator::Paper);
            println!("n = {exponent}, {count} EAS: {:.2} % off, paper {:.2} %", 100.0 * ours, 100.0 * paper);
            assert!(ours <= 0.01, "n = {exponent}, {count} EAS: {ours}");
            assert!(ours <= paper + 1e-3, "n = {exponent}: {ours} against {paper}");
        }
    }
}

/// E of a record under constant light is π, and stays so when the record is read elsewhere.
#[test]
fn constant_light_gives_the_irradiance() {
    let frame = Frame::from_normal(Vec3A::Z);
    let light = Incident { radiance: Vec3A::splat(2.0), distance: f32::INFINITY, normal: Vec3A::ZERO };
    let mut samples = gathered(&frame, 0.3, 0.6, 2, |_| light);
    let table = phong(40.0);
    let reflector = Reflector::new(&table, Vec3A::ONE, Vec3A::ONE);
    for estimator in [Estimator::Paper, Estimator::Improved] {
        let tree = Tree::new(&mut samples, 2, Centroid::Direction);
        let settings = CutSettings { tolerance: 0.0, max_eas: 200 };
        let cut = cut(&tree, &reflector, &hemisphere_directions(16), &settings);
        let record = EasRecord::new(Vec3A::ONE, &frame, 0, &tree, &cut, estimator);
        let found = record.irradiance(estimator).x / (2.0 * core::f32::consts::PI);
        assert!((found - 1.0).abs() < 1e-3, "{estimator:?}: {found}");
    }
}
