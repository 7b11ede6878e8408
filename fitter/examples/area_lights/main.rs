//! Area lights reflected by GGX, from a table of mean BRDFs and by linearly transformed cosines (Heitz et al. 2016), against many
//! samples: error and time of both. Both are made here, from the same model.
//! `cargo run --release -p fitter --example area_lights [LIGHTS [ROUGHNESS,…]]`

mod lights;
mod ltc;

use brdf_tables::brdf::{Distribution, Fresnel, Microfacet, Specular};
use brdf_tables::{Material, Table, family};
use glam::{DVec3, Vec3};
use lights::{Kind, Light, Memory};
use ltc::Ltc;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

/// Times that all lights are asked for, of which the fastest counts.
const TURNS: usize = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let lights: usize = words.next().map_or(Ok(1000), |word| word.parse())?;
    let alphas = words.next().unwrap_or("0.1,0.3".into());
    for alpha in alphas.split(',') {
        let alpha: f64 = alpha.parse()?;
        let facets =
            Microfacet { distribution: Distribution::Ggx, alpha_x: alpha, alpha_y: alpha, fresnel: Fresnel::None };
        let specular = Specular::Microfacet(facets);
        let table = family::table(&Material::specular(specular)).ok_or("the library has no table of this roughness")?;
        let begun = Instant::now();
        let ltc = Ltc::new(&specular);
        let [normal, slanted, grazing] = ltc.missed.map(|missed| 100.0 * missed);
        println!(
            "\ncosines of α = {alpha} fitted in {:.1} s; of the lobe they miss {normal:.1} % along the normal, {slanted:.1} % at 59°, {grazing:.1} % at 89°\n",
            begun.elapsed().as_secs_f64()
        );
        println!("| α | light | by | error | bias | 95 % below | ns |\n|---|---|---|---|---|---|---|");
        for kind in Kind::ALL {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(11);
            let asked: Vec<(Light, DVec3)> =
                (0..lights).map(|_| kind.random(specular.lobe_width(), &mut rng)).collect();
            let truth: Vec<f64> = asked.par_iter().map(|(light, wo)| light.truth(&specular, *wo)).collect();
            for (by, values, time) in answers(&asked, &table, &ltc, kind) {
                let Errors { rmse, bias, most } = Errors::new(&values, &truth);
                println!(
                    "| {alpha} | {} | {by} | {:.2} % | {:+.2} % | {:.1} % | {time:.0} |",
                    kind.name(),
                    100.0 * rmse,
                    100.0 * bias,
                    100.0 * most
                );
            }
        }
    }
    Ok(())
}

/// Who answers, what, and in how many nanoseconds a light.
fn answers(asked: &[(Light, DVec3)], table: &Table, ltc: &Ltc, kind: Kind) -> Vec<(String, Vec<f32>, f64)> {
    let mut memory = Memory::default();
    let mut all = Vec::new();
    let mut note = |by: String, answer: &mut dyn FnMut(&Light, Vec3) -> f32| {
        let mut values = vec![0.0; asked.len()];
        let mut best = f64::INFINITY;
        for _ in 0..TURNS {
            let begun = Instant::now();
            for ((light, wo), value) in asked.iter().zip(&mut values) {
                *value = answer(black_box(light), wo.as_vec3());
            }
            best = best.min(begun.elapsed().as_secs_f64());
        }
        all.push((by, values, 1e9 * best / asked.len() as f64));
    };
    if kind == Kind::Rectangle {
        for side in [1, 2, 4, 8] {
            note(format!("table, {} caps", side * side), &mut |light, wo| light.by_table(table, wo, side, &mut memory));
        }
    } else {
        note("table".into(), &mut |light, wo| light.by_table(table, wo, 1, &mut memory));
    }
    note("cosines".into(), &mut |light, wo| match *light {
        Light::Cap(axis, sigma) => ltc.cap(axis.as_vec3(), sigma as f32, wo),
        Light::Rectangle(center, x, y) => {
            let corners = [center - x - y, center + x - y, center + x + y, center - x + y];
            ltc.polygon(&corners.map(|v| v.as_vec3()), wo)
        }
    });
    all
}

/// Root mean square error and bias over the mean, and the relative error that 95 % of the lights stay below, of those that are
/// reflected by a hundredth of the mean at least.
struct Errors {
    rmse: f64,
    bias: f64,
    most: f64,
}

impl Errors {
    fn new(values: &[f32], truth: &[f64]) -> Self {
        let count = truth.len() as f64;
        let mean = truth.iter().sum::<f64>() / count;
        let off = || values.iter().zip(truth).map(|(value, truth)| f64::from(*value) - truth);
        let mut relative: Vec<f64> =
            off().zip(truth).filter(|(_, truth)| **truth > 0.01 * mean).map(|(off, truth)| off.abs() / truth).collect();
        relative.sort_by(f64::total_cmp);
        Self {
            rmse: (off().map(|x| x * x).sum::<f64>() / count).sqrt() / mean,
            bias: off().sum::<f64>() / count / mean,
            most: relative.get(relative.len() * 95 / 100).copied().unwrap_or(0.0),
        }
    }
}
