//! Seconds that look-ups of whole arrays take, for `brdf-tables/python/bench/speed.py`:
//! `arrays TABLE AXES SOLID_ANGLES VIEWS all|pairs`, files of f32 as they lie in memory.
//!
//! `all`: every cap from every view, `pairs`: cap i from view i. The least of five turns is printed.

use brdf_tables::{CapBatch, Table};
use glam::Vec3;
use std::error::Error;
use std::time::Instant;

fn numbers(file: &str) -> Result<Vec<f32>, Box<dyn Error>> {
    let bytes = std::fs::read(file)?;
    Ok(bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
}

fn vectors(file: &str) -> Result<Vec<Vec3>, Box<dyn Error>> {
    Ok(numbers(file)?.chunks_exact(3).map(Vec3::from_slice).collect())
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [table, axes, solid_angles, views, kind] = &arguments[..] else {
        return Err("arrays TABLE AXES SOLID_ANGLES VIEWS all|pairs".into());
    };
    let table = Table::load(table)?;
    let (axes, solid_angles, views) = (vectors(axes)?, numbers(solid_angles)?, vectors(views)?);
    let mut caps = CapBatch::with_capacity(axes.len());
    let mut least = f64::INFINITY;
    for _ in 0..5 {
        let start = Instant::now();
        let mut out = vec![0.0; if kind == "pairs" { axes.len() } else { axes.len() * views.len() }];
        caps.clear();
        if kind == "pairs" {
            for (i, value) in out.chunks_exact_mut(1).enumerate() {
                caps.clear();
                caps.push(axes[i], solid_angles[i])?;
                table.specular_values(&caps, views[i], value);
            }
        } else {
            for (&axis, &solid_angle) in axes.iter().zip(&solid_angles) {
                caps.push(axis, solid_angle)?;
            }
            for (&view, values) in views.iter().zip(out.chunks_exact_mut(axes.len())) {
                table.specular_values(&caps, view, values);
            }
        }
        least = least.min(start.elapsed().as_secs_f64());
        std::hint::black_box(&out);
    }
    println!("{least}");
    Ok(())
}
