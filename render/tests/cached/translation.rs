//! Eq. 16 at its limits, the tree and the cut at theirs.

use crate::common::{gathered, phong};
use glam::Vec3A;
use render::frame::Frame;
use render::hemisphere::{GatherSample, Incident, hemisphere_directions};
use render::record::eas::{EasRecord, Estimator};
use render::record::{Albedo, Centroid, CutSettings, Receiver, Reflected, Reflector, Scratch, Tree, cut, reflect};

const ESTIMATORS: [Estimator; 2] = [Estimator::Paper, Estimator::Improved];

/// Light of a wall at height `h` that glows smoothly, from a point of the plane z = 0.
fn wall(x: Vec3A, h: f32) -> impl Fn(Vec3A) -> Incident {
    move |d: Vec3A| {
        let distance = (h - x.z) / d.z.max(1e-4);
        let q = x + d * distance;
        Incident {
            radiance: Vec3A::new(1.0, 0.6, 0.3) * (-q.length_squared() / (h * h)).exp(),
            distance,
            normal: -Vec3A::Z,
        }
    }
}

fn record(samples: &mut [GatherSample], x: Vec3A, estimator: Estimator, reflector: &Reflector) -> EasRecord {
    let tree = Tree::new(samples, 4, Centroid::Direction);
    let settings = CutSettings { tolerance: 1e-4, max_eas: 4000 };
    let cut = cut(&tree, reflector, &hemisphere_directions(64), &settings);
    EasRecord::new(x, &Frame::from_normal(Vec3A::Z), 0, &tree, &cut, estimator)
}

fn read(record: &EasRecord, position: Vec3A, normal: Vec3A, estimator: Estimator) -> Reflected {
    let table = phong(40.0);
    let albedo = Albedo::new(&table);
    let reflector = Reflector::new(&table, Vec3A::ZERO, Vec3A::ONE);
    let at = Receiver { position, frame: Frame::from_normal(normal), wo: Vec3A::new(0.0, -0.5, 0.75f32.sqrt()) };
    reflect(record, &at, &reflector, &albedo, estimator, &mut Scratch::default())
}

/// Near the foot of a bright wall, at y = 1, in dim surroundings; zones in pixels may reach far beyond what translations hold:
/// then the record is doubted, and the share that is doubted is path traced, which finds the truth.
#[test]
fn a_wall_does_not_explode_on_the_way_into_its_corner() {
    let table = phong(40.0);
    let reflector = Reflector::new(&table, Vec3A::ZERO, Vec3A::ONE);
    let frame = Frame::from_normal(Vec3A::Z);
    let light = |y: f32| {
        move |d: Vec3A| match d.y > 1e-3 {
            true => Incident { radiance: Vec3A::ONE, distance: (1.0 - y) / d.y, normal: -Vec3A::Y },
            false => Incident { radiance: Vec3A::splat(0.1), distance: 10.0, normal: -d },
        }
    };
    let (x, y) = (Vec3A::new(0.0, 0.9, 0.0), Vec3A::new(0.0, 0.995, 0.0));
    let mut here = gathered(&frame, 0.158, 0.4, 4, light(x.y));
    let mut there = gathered(&frame, 0.158, 0.4, 4, light(y.y));
    let ours = Estimator::Improved;
    let found = read(&record(&mut here, x, ours, &reflector), y, Vec3A::Z, ours);
    let truth = read(&record(&mut there, y, ours, &reflector), y, Vec3A::Z, ours);
    let (specular, irradiance) = (found.specular.x / truth.specular.x, found.irradiance.x / truth.irradiance.x);
    println!("specular {specular:.3}, trust {:.3} and {:.3}, irradiance {irradiance:.3}", found.trust, truth.trust);
    let shown = specular * found.trust + (1.0 - found.trust);
    assert!((0.9..1.1).contains(&shown) && (0.6..1.4).contains(&irradiance), "{shown} {irradiance}");
    assert!(truth.trust > 0.9, "a record is doubted where it lies: {}", truth.trust);
}

/// A record read a quarter of the distance away agrees with a record made there.
#[test]
fn translation_follows_the_light() {
    let table = phong(40.0);
    let reflector = Reflector::new(&table, Vec3A::ZERO, Vec3A::ONE);
    let frame = Frame::from_normal(Vec3A::Z);
    let (x, y) = (Vec3A::new(0.3, 0.0, 0.0), Vec3A::new(0.55, 0.1, 0.0));
    let mut here = gathered(&frame, 0.158, 0.4, 4, wall(x, 1.0));
    let mut there = gathered(&frame, 0.158, 0.4, 4, wall(y, 1.0));
    let ours = Estimator::Improved;
    let truth = read(&record(&mut there, y, ours, &reflector), y, Vec3A::Z, ours);
    for (estimator, bound) in [(Estimator::Improved, 0.03), (Estimator::Paper, 0.10)] {
        let found = read(&record(&mut here, x, estimator, &reflector), y, Vec3A::Z, estimator);
        let (specular, irradiance) = (found.specular.x / truth.specular.x, found.irradiance.x / truth.irradiance.x);
        println!("{estimator:?}: specular {specular:.4}, irradiance {irradiance:.4}");
        assert!(
            (specular - 1.0).abs() < bound && (irradiance - 1.0).abs() < bound,
            "{estimator:?} {specular} {irradiance}"
        );
    }
}

/// The point moves into the source, behind it, under the horizon; the source is seen edge-on or from behind: nothing is
/// negative, infinite or not a number.
#[test]
fn limits_stay_finite() {
    let table = phong(200.0);
    let reflector = Reflector::new(&table, Vec3A::ONE, Vec3A::ONE);
    let frame = Frame::from_normal(Vec3A::Z);
    let edge_on =
        |d: Vec3A| Incident { radiance: Vec3A::ONE, distance: 0.5, normal: d.cross(Vec3A::X).normalize_or_zero() };
    let behind = |d: Vec3A| Incident { radiance: Vec3A::ONE, distance: 1e-6, normal: d };
    let nothing = |_: Vec3A| Incident { radiance: Vec3A::ZERO, distance: f32::INFINITY, normal: Vec3A::ZERO };
    let broken = |_: Vec3A| Incident { radiance: Vec3A::NAN, distance: f32::NAN, normal: Vec3A::NAN };
    let lights: [&dyn Fn(Vec3A) -> Incident; 5] = [&wall(Vec3A::ZERO, 0.01), &edge_on, &behind, &nothing, &broken];
    for (i, light) in lights.into_iter().enumerate() {
        let mut samples = gathered(&frame, 0.3, 0.7, 2, light);
        for estimator in ESTIMATORS {
            let record = record(&mut samples, Vec3A::ZERO, estimator, &reflector);
            for position in [Vec3A::ZERO, Vec3A::new(0.0, 0.0, 0.01), Vec3A::new(0.3, 0.4, 0.0), Vec3A::splat(1e6)] {
                for normal in [Vec3A::Z, Vec3A::X, -Vec3A::Z, Vec3A::splat(1.0).normalize()] {
                    let found = read(&record, position, normal, estimator);
                    let sum = found.irradiance + found.specular;
                    assert!(
                        sum.is_finite() && sum.min_element() > -1e-3,
                        "{i} {estimator:?} {position} {normal}: {found:?}"
                    );
                }
            }
        }
    }
}

/// τ → ∞ keeps the first level, τ = 0 the leaves, and the bound on #EAS is kept; ties have one outcome.
#[test]
fn the_cut_goes_from_the_first_level_to_the_leaves() {
    let table = phong(40.0);
    let reflector = Reflector::new(&table, Vec3A::ZERO, Vec3A::ONE);
    let frame = Frame::from_normal(Vec3A::Z);
    let mut samples = gathered(&frame, 0.3, 0.5, 2, wall(Vec3A::ZERO, 1.0));
    let tree = Tree::new(&mut samples, 2, Centroid::Direction);
    let leaves = tree.nodes().iter().filter(|n| n.is_leaf()).count();
    let directions = hemisphere_directions(64);
    let with =
        |tolerance: f32, max_eas: usize| cut(&tree, &reflector, &directions, &CutSettings { tolerance, max_eas });
    assert_eq!(with(f32::INFINITY, 1000).nodes.len(), 7);
    assert_eq!(with(0.0, usize::MAX / 2).nodes.len(), leaves);
    let bounded = with(0.0, 50);
    assert!((45..=50).contains(&bounded.nodes.len()), "{}", bounded.nodes.len());
    assert_eq!(bounded.nodes, with(0.0, 50).nodes);
    let fine = with(0.005, 1000);
    assert!(fine.error <= 0.005 && fine.nodes.len() < leaves, "{} {}", fine.error, fine.nodes.len());
    // Whatever the cut, its irradiance is that of all samples, and its cells tile the hemisphere.
    let total: Vec3A = samples.iter().map(GatherSample::irradiance).sum();
    for cut in [with(f32::INFINITY, 1000), fine, bounded] {
        let nodes = || cut.nodes.iter().map(|&i| &tree.nodes()[i]);
        let (e, omega) = (nodes().map(|n| n.irradiance).sum::<Vec3A>(), nodes().map(|n| n.solid_angle).sum::<f32>());
        assert!((e / total - 1.0).abs().max_element() < 1e-4);
        assert!((omega / core::f32::consts::TAU - 1.0).abs() < 1e-4);
    }
}

/// Two colours of one luminance side by side keep their hues apart in space: the cut divides where the channels differ.
#[test]
fn colours_of_one_luminance_are_told_apart() {
    let table = phong(100.0);
    let reflector = Reflector::new(&table, Vec3A::ZERO, Vec3A::ONE);
    let frame = Frame::from_normal(Vec3A::Z);
    let (red, green) = (Vec3A::X / 0.2126, Vec3A::Y / 0.7152);
    let light = |d: Vec3A| Incident {
        radiance: if d.x > 0.0 { red } else { green },
        distance: f32::INFINITY,
        normal: Vec3A::ZERO,
    };
    let mut samples = gathered(&frame, 0.1, 0.6, 2, light);
    let tree = Tree::new(&mut samples, 2, Centroid::Direction);
    let settings = CutSettings { tolerance: 0.02, max_eas: 1000 };
    let cut = cut(&tree, &reflector, &hemisphere_directions(128), &settings);
    let record = EasRecord::new(Vec3A::ZERO, &frame, 0, &tree, &cut, Estimator::Improved);
    let albedo = Albedo::new(&table);
    for (x, lit, dark) in [(0.5f32, 1, 0), (-0.5, 0, 1)] {
        let wo = Vec3A::new(x, 0.0, (1.0 - x * x).sqrt());
        let at = Receiver { position: Vec3A::ZERO, frame, wo };
        let found = reflect(&record, &at, &reflector, &albedo, Estimator::Improved, &mut Scratch::default()).specular;
        // The mirror direction of a view from +x lies at −x, where the light is green.
        assert!(found[dark] < 0.02 * found[lit], "{x}: {found}");
    }
}
