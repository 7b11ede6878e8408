//! Radiance caching with harmonics: records against the sums they stand for, pictures against the path tracer.

use crate::common::{cached, compare, gathered, phong, table, traced, world};
use brdf_tables::brdf::{Phong, Specular};
use glam::Vec3A;
use render::cache::Spacing;
use render::frame::Frame;
use render::hemisphere::{GatherSample, Incident, gather_uniform, hemisphere_directions};
use render::integrator::cached::file::{CacheFileError, load, save};
use render::integrator::cached::policy::{Allowed, Policy};
use render::integrator::cached::{Interpolation, Settings, render_cached};
use render::picture::{Budget, Picture};
use render::record::eas::Estimator;
use render::record::harmonics::{
    Basis, Gradients, HarmonicBrdf, HarmonicsRecord, HarmonicsSettings, OrderChoice, Reader,
};
use render::record::{Albedo, Receiver};
use render::sampler::Sampler;

const BASES: [Basis; 2] = [Basis::Hemispherical, Basis::Spherical];

fn settings(basis: Basis, gradients: Gradients, order: usize) -> HarmonicsSettings {
    HarmonicsSettings { basis, gradients, order: OrderChoice::Fixed(order) }
}

fn specular(exponent: f64) -> Specular {
    Specular::Phong(Phong { exponent })
}

/// Many stratified samples of light given by direction.
fn dense(frame: &Frame, light: impl Fn(Vec3A) -> Incident) -> Vec<GatherSample> {
    gather_uniform(frame, 20_000, |i| Sampler::new(5, (3, 4), i).next_2d(), |d, _| light(d))
}

/// Σ L f_r cosθ Ω over samples, with the normal and view of another point: (irradiance, specular).
fn sum(samples: &[GatherSample], from: &Frame, at: &Receiver, specular: &Specular) -> (f32, f32) {
    use brdf_tables::brdf::Brdf;
    let wo = at.wo.as_dvec3();
    let part = |s: &GatherSample| {
        let wi = at.frame.to_local(from.to_world(s.direction));
        let light = s.radiance.x * s.solid_angle * wi.z.max(0.0);
        let f = if wi.z > 0.0 { specular.eval(wi.as_dvec3(), wo) as f32 } else { 0.0 };
        (light, light * f)
    };
    samples.iter().map(part).fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1))
}

/// Constant light reflects the albedo: within 1 % for views up to 70° with the orders that the lobes ask for.
#[test]
fn constant_light_reflects_the_albedo() {
    let frame = Frame::from_normal(Vec3A::new(0.48, 0.6, 0.64));
    let light = Incident { radiance: Vec3A::ONE, distance: f32::INFINITY, normal: Vec3A::ZERO };
    let samples = gathered(&frame, 0.1, 0.5, 4, |_| light);
    for basis in BASES {
        for exponent in [5.0, 20.0, 40.0, 100.0] {
            let settings = HarmonicsSettings::new(basis, Gradients::None, 0.02, None);
            let brdf = HarmonicBrdf::new(specular(exponent), basis, settings.order);
            let (table, mut reader) = (phong(exponent), Reader::default());
            let albedo = Albedo::new(&table);
            let order = brdf.summary().orders.1;
            let record = HarmonicsRecord::new(Vec3A::ZERO, &frame, 1.0, 0, &samples, order, &settings);
            let mut worst = 0f32;
            for wo in hemisphere_directions(100).into_iter().filter(|d| d.z > 70f32.to_radians().cos()) {
                let outgoing = reader.look(&brdf, &Receiver { position: Vec3A::ZERO, frame, wo });
                if outgoing.traced > 0.0 {
                    continue;
                }
                let found = reader.read(&record, Vec3A::ZERO);
                worst = worst.max((found.specular.x / albedo.at(wo) - 1.0).abs());
                assert!((found.irradiance.x / core::f32::consts::PI - 1.0).abs() < 5e-3, "{}", found.irradiance);
            }
            println!("{basis:?}, n = {exponent}: order {order}, {:.2} % off", 100.0 * worst);
            assert!(worst < 0.01, "{basis:?} {exponent}: {worst}");
        }
    }
}

/// Read under a normal turned by up to 15°, a record gives what its own samples do: within 2 % of the largest sum.
#[test]
fn turned_normals_read_the_samples_turned() {
    let from = Frame::from_normal(Vec3A::new(0.1, -0.3, 0.9).normalize());
    let light = |d: Vec3A| {
        let spot = |x: f32, y: f32, z: f32| d.dot(Vec3A::new(x, y, z).normalize()).max(0.0).powf(30.0);
        Incident {
            radiance: Vec3A::splat(0.2 + spot(0.5, 0.2, 0.8) + 0.5 * spot(-0.6, -0.3, 0.5)),
            distance: f32::INFINITY,
            normal: Vec3A::ZERO,
        }
    };
    let samples = dense(&from, light);
    for basis in BASES {
        for exponent in [5.0, 40.0] {
            let settings = HarmonicsSettings::new(basis, Gradients::None, 0.02, None);
            let brdf = HarmonicBrdf::new(specular(exponent), basis, settings.order);
            let order = brdf.summary().orders.1;
            let record = HarmonicsRecord::new(Vec3A::ZERO, &from, 1.0, 0, &samples, order, &settings);
            let mut reader = Reader::default();
            for tilt in [0.0, 0.02, 0.1, 0.26] {
                let normal = (from.normal() + from.to_world(Vec3A::new(tilt, 0.3 * tilt, 0.0))).normalize();
                let (mut wrong, mut largest, mut diffuse) = (0f32, 0f32, 0f32);
                for wo in hemisphere_directions(60).into_iter().filter(|d| d.z > 0.35) {
                    let at = Receiver { position: Vec3A::ZERO, frame: Frame::from_normal(normal), wo };
                    reader.look(&brdf, &at);
                    let found = reader.read(&record, Vec3A::ZERO);
                    let (irradiance, exact) = sum(&samples, &from, &at, &brdf.specular);
                    wrong = wrong.max((found.specular.x - exact).abs());
                    largest = largest.max(exact);
                    diffuse = diffuse.max((found.irradiance.x / irradiance - 1.0).abs());
                }
                println!(
                    "{basis:?}, n = {exponent}, order {order}, tilt {tilt}: specular {:.2} % of the largest, irradiance {:.2} %",
                    100.0 * wrong / largest,
                    100.0 * diffuse
                );
                assert!(wrong < 0.02 * largest && diffuse < 0.02, "{basis:?} {exponent} {tilt}");
            }
        }
    }
}

/// A record read some way off agrees better with one made there when it has gradients; both ways to find them do alike.
#[test]
fn gradients_follow_the_light() {
    let wall = |x: Vec3A| {
        move |d: Vec3A| {
            let distance = (1.0 - x.z) / d.z.max(1e-4);
            let q = x + d * distance;
            Incident { radiance: Vec3A::splat((-q.length_squared()).exp()), distance, normal: -Vec3A::Z }
        }
    };
    let frame = Frame::from_normal(Vec3A::Z);
    let (x, y) = (Vec3A::new(0.3, 0.0, 0.0), Vec3A::new(0.45, 0.06, 0.0));
    let (here, there) = (dense(&frame, wall(x)), dense(&frame, wall(y)));
    for basis in BASES {
        let brdf = HarmonicBrdf::new(specular(20.0), basis, OrderChoice::Fixed(12));
        let at = Receiver { position: y, frame, wo: Vec3A::new(0.0, -0.5, 0.75f32.sqrt()) };
        let error = |gradients: Gradients| {
            let mut reader = Reader::default();
            let make = |p: Vec3A, samples: &[GatherSample]| {
                HarmonicsRecord::new(p, &frame, 0.3, 0, samples, 12, &settings(basis, gradients, 12))
            };
            reader.look(&brdf, &at);
            let found = reader.read(&make(x, &here), y);
            let exact = reader.read(&make(y, &there), y);
            [(found.specular.x / exact.specular.x - 1.0).abs(), (found.irradiance.x / exact.irradiance.x - 1.0).abs()]
        };
        let [none, analytic, numerical] = [Gradients::None, Gradients::Analytic, Gradients::Numerical].map(error);
        println!("{basis:?}: specular, irradiance off by {none:?} without, {analytic:?}, {numerical:?} with gradients");
        for i in 0..2 {
            assert!(analytic[i] < 0.35 * none[i] && numerical[i] < 0.35 * none[i]);
        }
    }
}

/// Pictures of the box with a glossy floor of exponent 20: small error in either basis.
#[test]
fn pictures_agree_with_the_path_tracer() {
    let world = world("floor.xml", &[("n", "20"), ("width", "64"), ("height", "64")]);
    let reference = traced(&world, 256);
    for basis in BASES {
        let allowed = Allowed::Harmonics(HarmonicsSettings::new(basis, Gradients::Analytic, 0.03, None));
        let (picture, figures) = cached(&world, allowed, 0.03, 32);
        let (error, bias) = compare(&picture, &reference);
        println!(
            "{basis:?}: rel_mse {error:.4}, bias {:.2} %, {} records of {} bytes",
            100.0 * bias,
            figures.glossy.harmonics.records,
            figures.glossy.harmonics.bytes / figures.glossy.harmonics.records.max(1)
        );
        assert!(figures.glossy.harmonics.records > 50 && figures.glossy.eas.records == 0);
        assert!(error < 0.002 && bias.abs() < 0.02, "{basis:?}: {error} {bias}");
    }
}

/// Rough metal of coloured Fresnel term, an anisotropic lobe and curved surfaces, whose records are turned: as near to the path
/// tracer as EAS come, which share everything but the representation, and with the bias that they have.
#[test]
fn curved_and_coloured_materials_are_drawn_as_well_as_with_eas() {
    for (scene, bound) in [("preview.xml", 0.004), ("materials.xml", 0.006)] {
        let world = world(scene, &[("width", "40"), ("height", "40")]);
        let reference = traced(&world, 256);
        let (eas, eas_bias) = compare(&cached(&world, Allowed::Eas, 0.03, 32).0, &reference);
        for basis in BASES {
            let allowed = Allowed::Harmonics(HarmonicsSettings::new(basis, Gradients::Analytic, 0.03, None));
            let (picture, figures) = cached(&world, allowed, 0.03, 32);
            let (error, bias) = compare(&picture, &reference);
            let records = figures.glossy.harmonics.records;
            println!(
                "{scene}, {basis:?}: rel_mse {error:.4}, bias {:.2} %, {records} records; EAS {eas:.4}, {:.2} %",
                100.0 * bias,
                100.0 * eas_bias
            );
            assert!(records > 50 && error < bound && error < 1.3 * eas + 2e-4, "{scene} {basis:?}: {error} {eas}");
            assert!((bias - eas_bias).abs() < 0.005, "{scene} {basis:?}: {bias} {eas_bias}");
        }
    }
}

/// The light of the glossy floor alone, where records are sparse: gradients bring it nearer to the path tracer.
#[test]
fn gradients_make_pictures_better() {
    let world = world("floor.xml", &[("n", "20"), ("width", "64"), ("height", "64")]);
    let glossy = |picture: &Picture| -> Vec<f64> {
        let scale = 1.0 / f64::from(picture.spp);
        picture.pixels.iter().map(|p| f64::from(p.sum().indirect.glossy.y) * scale).collect()
    };
    let reference = glossy(&traced(&world, 512));
    let error = |gradients: Gradients| -> f64 {
        let settings = HarmonicsSettings::new(Basis::Hemispherical, gradients, 0.02, None);
        let found = glossy(&cached(&world, Allowed::Harmonics(settings), 0.02, 16).0);
        let squares = found.iter().zip(&reference).map(|(a, b)| (a - b) * (a - b) / (b * b + 1e-4));
        squares.sum::<f64>() / reference.len() as f64
    };
    let [none, analytic, numerical] = [Gradients::None, Gradients::Analytic, Gradients::Numerical].map(error);
    println!("error of the glossy light: {none:.5} without, {analytic:.5} and {numerical:.5} with gradients");
    assert!(analytic < none && numerical < none);
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let world = world("floor.xml", &[("n", "20"), ("width", "40"), ("height", "40")]);
    let allowed = Allowed::Harmonics(HarmonicsSettings::new(Basis::Hemispherical, Gradients::Analytic, 0.1, None));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| cached(&world, allowed, 0.1, 4)).0.image().pixels
    };
    let one = with(1);
    assert!(one == with(2) && one == with(7));
}

/// What no order holds is path traced and the policy says so; an order that is given is used whatever it loses.
#[test]
fn the_policy_decides_by_the_error_of_the_brdf() {
    let decide = |n: &str, order: Option<usize>| {
        let world = world("floor.xml", &[("n", n), ("width", "16"), ("height", "16")]);
        let settings = HarmonicsSettings::new(Basis::Hemispherical, Gradients::Analytic, 0.02, order);
        let policy = Policy::new(&world.scene, Allowed::Harmonics(settings), |r| Ok::<_, ()>(table(r)));
        (cached(&world, Allowed::Harmonics(settings), 0.1, 2).1, policy.expect("no table is asked for").notes)
    };
    let (figures, notes) = decide("20", None);
    assert!(
        figures.glossy.harmonics.records > 0 && notes.iter().any(|n| n.contains("harmonics of order")),
        "{notes:?}"
    );
    let (figures, notes) = decide("5000", None);
    assert!(figures.glossy.harmonics.records == 0 && notes.iter().any(|n| n.contains("path traced")), "{notes:?}");
    let (figures, notes) = decide("5000", Some(9));
    assert!(figures.glossy.harmonics.records > 0 && notes.iter().any(|n| n.contains("of order 9")), "{notes:?}");
    assert_eq!(figures.glossy.harmonics.elements, 9 * figures.glossy.harmonics.records);
    // 81 coefficients of three channels and two gradients, and what a record holds besides.
    let bytes = figures.glossy.harmonics.bytes / figures.glossy.harmonics.records;
    assert!((81 * 9 * 4..81 * 9 * 4 + 128).contains(&bytes), "{bytes}");
}

/// A cache file gives the same picture; one of other settings is refused.
#[test]
fn harmonic_records_survive_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("floor.cache");
    let world = world("floor.xml", &[("n", "20"), ("width", "24"), ("height", "24")]);
    let policy = |gradients: Gradients| {
        let settings = HarmonicsSettings::new(Basis::Hemispherical, gradients, 0.1, None);
        Policy::new(&world.scene, Allowed::Harmonics(settings), |r| Ok::<_, ()>(table(r)))
            .expect("no table is asked for")
    };
    let settings = Settings {
        tolerance: Some(0.1),
        estimator: Estimator::Improved,
        spacing: Spacing::default(),
        sources: None,
        budget: Budget::Samples(2),
        seed: 3,
        indirect_only: false,
        interpolation: Interpolation::Auto,
    };
    let analytic = policy(Gradients::Analytic);
    let (picture, figures, caches) = render_cached(&world, &analytic, &settings, None, &|_| ());
    save(&path, &world, &analytic, &settings, 0.1, &caches).unwrap();
    let kept = load(&path, &world, &analytic, &settings, 0.1).unwrap();
    assert!(kept.complete && kept.caches.glossy.harmonics.records().len() == figures.glossy.harmonics.records);
    let (again, _, _) = render_cached(&world, &analytic, &settings, Some(kept), &|_| ());
    assert!(again.image().pixels == picture.image().pixels);
    let other = load(&path, &world, &policy(Gradients::None), &settings, 0.1);
    assert!(matches!(other, Err(CacheFileError::Stale(_))));
}
