//! Vector lanes in single precision against the scalar twin in double; batches of every length; what does not belong in one.

use super::{any_cap, examples, lit_direction, representations, rng, scientific, synthetic_lobes};
use brdf_tables::batch::CapBatch;
use brdf_tables::brdf::Specular;
use brdf_tables::cap::Cap;
use brdf_tables::frame::mirror;
use brdf_tables::mean::MeanBrdf;
use brdf_tables::paper::Paper;
use core::f64::consts::{FRAC_PI_2, TAU};
use glam::{DVec3, Vec3};
use rand::{Rng, RngExt};

/// Every kind of table, lobes of nobody's fit included.
fn tables(specular: Specular) -> Vec<Box<dyn MeanBrdf>> {
    let sharpness = specular.lobe_width().powi(-2);
    let coefficients = (0..4 * 3 * 2).flat_map(|i| {
        let axis = Vec3::new(-0.4 - 0.02 * i as f32, 0.0, 0.8).normalize();
        [axis.x, axis.y, axis.z, sharpness as f32]
    });
    let coefficients = coefficients.collect();
    let lobes: [Box<dyn MeanBrdf>; 3] = [
        Box::new(synthetic_lobes(sharpness, 3, 7)),
        Box::new(synthetic_lobes(sharpness, 1, 3)),
        Box::new(Paper::new(4, 3, 2, coefficients).unwrap()),
    ];
    representations(specular).into_iter().chain(lobes).collect()
}

/// A third anywhere, a third below the lobe's width, a third across the horizon; as f32 holds them.
fn caps(specular: &Specular, count: usize, rng: &mut impl Rng) -> Vec<Cap> {
    let mut cap = |i: usize| match i % 3 {
        0 => any_cap(&mut *rng),
        1 => Cap::with_half_angle(
            1.5 * rng.random::<f64>(),
            TAU * rng.random::<f64>(),
            specular.lobe_width() * (0.01 + rng.random::<f64>()),
        )
        .unwrap(),
        _ => {
            let sigma = 0.01 + rng.random::<f64>();
            Cap::with_half_angle(FRAC_PI_2 - 0.9 * sigma * rng.random::<f64>(), TAU * rng.random::<f64>(), sigma)
                .unwrap()
        }
    };
    (0..count).map(&mut cap).collect()
}

/// Cap `i` in double precision.
fn held(batch: &CapBatch, i: usize) -> Cap {
    let (axis, omega) = batch.get(i);
    let axis = axis.as_dvec3().normalize();
    Cap::new(axis.z.clamp(0.0, 1.0).acos(), axis.y.atan2(axis.x), f64::from(omega).min(TAU)).unwrap()
}

/// F towards the mirror direction, or just above the horizon below it.
fn at_mirror(mean: &dyn MeanBrdf, cap: &Cap) -> f64 {
    mean.value(cap, mirror(cap.axis()).with_z(cap.axis().z.max(0.05)).normalize())
}

#[test]
fn batches_agree_with_scalars() {
    let mut worst = [0f64; 4];
    for (specular, name) in examples() {
        for table in tables(specular) {
            let mut rng = rng(7);
            let caps = caps(&specular, 96, &mut rng);
            let batch: CapBatch = caps.iter().collect();
            let mut out = vec![0f32; caps.len()];
            // The caps as the batch holds them, so that only the arithmetic differs, and the size of F for each.
            let held: Vec<Cap> = (0..caps.len()).map(|i| held(&batch, i)).collect();
            let kind = ["zonal", "cubature", "lobes", "paper"].iter().position(|n| *n == table.name()).unwrap();
            let scale = |cap: &Cap| if kind < 2 { at_mirror(&*table, cap) } else { 1.0 };
            let scales: Vec<f64> = held.iter().map(scale).collect();
            for at in 0..12 {
                let wo = lit_direction(&specular, &caps[at * 8], &mut rng).as_vec3().normalize();
                table.values(&batch, wo, &mut out);
                for (i, cap) in held.iter().enumerate() {
                    let scalar = table.value(cap, wo.as_dvec3().normalize());
                    let off = (f64::from(out[i]) - scalar).abs() / scales[i].max(scalar);
                    // cosⁿ magnifies the rounding of its base n times. AVX2 estimates reciprocals less precisely than AVX-512,
                    // which stays below 2e-4: a cap of half the hemisphere on the horizon is off by 2.2e-4 there.
                    let bound = 3e-4 + 2.5e-7 * specular.lobe_width().powi(-2);
                    worst[kind] = worst[kind].max(off / bound);
                    assert!(
                        off < bound,
                        "{} of {name}: {} instead of {scalar}, {off:.1e} of the peak, for {cap:?}, {wo}",
                        table.name(),
                        out[i]
                    );
                }
            }
        }
    }
    eprintln!("f32 lanes against f64, over the bound: zonal, cubature, lobes, paper {}", scientific(&worst));
}

/// Bound of the differences in rounding.
const ROUNDING: f32 = 3e-6;

/// Largest difference over the largest value.
fn off(found: &[f32], expected: &[f32]) -> f32 {
    let largest = expected.iter().fold(1e-6f32, |m, x| m.max(*x));
    found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) / largest
}

/// But for rounding (a few caps of a rule are summed in another order than many), a value does not depend on where in a
/// batch its cap stands, how long the batch is, or what was there before.
#[test]
fn every_length_of_batch() {
    for (specular, name) in examples().step_by(5) {
        for table in tables(specular) {
            let mut rng = rng(8);
            let caps = caps(&specular, 1000, &mut rng);
            let wo = lit_direction(&specular, &caps[1], &mut rng).as_vec3();
            let one = |cap: &Cap| {
                let mut out = [0f32; 1];
                table.values(&[*cap].iter().collect(), wo, &mut out);
                out[0]
            };
            let expected: Vec<f32> = caps.iter().map(one).collect();
            let mut batch = CapBatch::with_capacity(10);
            for length in [0, 1, 15, 16, 17, 255, 256, 257, 1000, 3] {
                batch.clear();
                assert!(batch.is_empty());
                caps[..length].iter().for_each(|c| batch.push_nearest(c.axis().as_vec3(), c.solid_angle() as f32));
                assert_eq!(batch.len(), length);
                let mut out = vec![-1f32; length + 5];
                table.values(&batch, wo, &mut out);
                let off = off(&out[..length], &expected[..length]);
                assert!(off < ROUNDING, "{} of {name}, {length} caps: {off:.1e}", table.name());
                assert!(out[length..].iter().all(|&x| x == -1.0), "written past the batch of {length}");
            }
        }
    }
}

/// Whatever is pushed, no look-up answers NaN, infinity or less than nothing, and the neighbours are untouched.
#[test]
fn nothing_foreign_gets_through_a_batch() {
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let axes = [
        Vec3::NAN,
        Vec3::new(nan, 0.0, 1.0),
        Vec3::new(0.0, 0.0, nan),
        Vec3::splat(inf),
        Vec3::new(-inf, 0.0, 0.0),
        Vec3::ZERO,
        Vec3::NEG_Z,
        Vec3::new(0.6, 0.0, -0.8),
        Vec3::new(3.0, 4.0, 5.0),
        Vec3::splat(1e-30),
        Vec3::splat(1e30),
    ];
    let solid_angles = [nan, inf, -inf, -1.0, 0.0, -0.0, 1e-40, 0.3, 7.0, 1e30];
    let neighbour = (Vec3::new(0.6, 0.0, 0.8), 0.3);
    let mut foreign = CapBatch::default();
    let mut clean = CapBatch::default();
    for (axis, omega) in axes.iter().flat_map(|a| solid_angles.map(|o| (*a, o))) {
        foreign.push_nearest(neighbour.0, neighbour.1);
        foreign.push_nearest(axis, omega);
        clean.push_nearest(neighbour.0, neighbour.1);
        clean.push_nearest(neighbour.0, neighbour.1);
    }
    for (specular, name) in examples() {
        for table in tables(specular) {
            for wo in
                [DVec3::new(-0.6, 0.0, 0.8), DVec3::Z, DVec3::new(0.8, 0.6, 1e-6)].map(|w| w.normalize().as_vec3())
            {
                let (mut out, mut expected) = (vec![0f32; foreign.len()], vec![0f32; clean.len()]);
                table.values(&foreign, wo, &mut out);
                table.values(&clean, wo, &mut expected);
                for (i, &value) in out.iter().enumerate() {
                    let (name_of, cap) = (table.name(), foreign.get(i));
                    assert!(value.is_finite() && value >= 0.0, "{name_of} of {name}: {value} for {cap:?}");
                }
                let even = |values: &[f32]| values.iter().step_by(2).copied().collect::<Vec<_>>();
                let off = off(&even(&out), &even(&expected));
                assert!(off < ROUNDING, "{} of {name}: a neighbour changed by {off:.1e}", table.name());
            }
        }
    }
}
