//! Shade one point lit by a few equivalent area light sources through a fitted table:
//! `cargo run --release -p brdf-tables --example lookup -- tables/phong-100.tbl`.

use brdf_tables::{CapBatch, Table};
use glam::Vec3;
use std::process::ExitCode;

/// A source as a cache stores it: unit direction in the local frame (z = normal), solid angle in sr, irradiance in W·m⁻².
struct Source {
    direction: Vec3,
    solid_angle: f32,
    irradiance: f32,
}

fn main() -> ExitCode {
    let Some(path) = std::env::args().nth(1) else {
        eprintln!("usage: lookup TABLE");
        return ExitCode::from(2);
    };
    // Once per material.
    let table = match Table::load(&path) {
        Ok(table) => table,
        Err(error) => {
            eprintln!("lookup: {path}: {error}");
            return ExitCode::from(2);
        }
    };
    let sources = [
        Source { direction: Vec3::new(0.60, 0.00, 0.80), solid_angle: 0.10, irradiance: 2.0 },
        Source { direction: Vec3::new(0.52, 0.30, 0.80), solid_angle: 0.05, irradiance: 1.0 },
        Source { direction: Vec3::new(0.00, -0.98, 0.20), solid_angle: 0.30, irradiance: 0.5 },
    ];

    // Once per shading point: the sources as caps.
    let mut caps = CapBatch::with_capacity(sources.len());
    for source in &sources {
        if let Err(error) = caps.push(source.direction.normalize(), source.solid_angle) {
            eprintln!("lookup: {error}");
            return ExitCode::from(2);
        }
    }
    // Once per view: F of every source, then L = Σ E F (eq. 8). The diffuse part needs the irradiance alone.
    let wo = Vec3::new(-0.60, 0.05, 0.80).normalize();
    let mut mean = vec![0.0; caps.len()];
    table.specular_values(&caps, wo, &mut mean);
    let irradiance: f32 = sources.iter().map(|s| s.irradiance).sum();
    let specular: f32 = sources.iter().zip(&mean).map(|(s, f)| s.irradiance * f).sum();
    let material = &table.header.material;
    for (channel, name) in ["red", "green", "blue"].into_iter().enumerate() {
        let (kd, ks) = (material.kd[channel] as f32, material.ks[channel] as f32);
        let radiance = kd / core::f32::consts::PI * irradiance + ks * specular;
        println!("{name}: {radiance:.5} W/(m² sr)");
    }
    ExitCode::SUCCESS
}
