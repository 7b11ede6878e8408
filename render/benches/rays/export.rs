//! Triangles and rays for another ray tracer, and our times for the same.

use crate::subjects::{PURPOSES, Purpose, Subject, names, subject};
use render::ray::Ray;
use render::scene::Geometry;
use render::world::Queries;
use std::path::Path;
use std::time::Instant;

/// Rounds of each set, of which the quickest counts.
const ROUNDS: usize = 5;

/// Writes raw little-endian f32: `NAME.triangles` (nine numbers each) and `NAME.PURPOSE` (origin, direction, t_max of each
/// ray); and to standard output a line `NAME PURPOSE rays seconds hits` for each set, on this core alone.
pub fn run(folder: &Path) {
    for name in names() {
        let subject = subject(name);
        write(folder, &format!("{name}.triangles"), triangles(subject));
        for purpose in PURPOSES {
            let rays = subject.rays(purpose);
            let numbers = |r: &Ray| {
                let (o, d) = (r.origin + r.direction * r.t_min, r.direction);
                [o.x, o.y, o.z, d.x, d.y, d.z, r.t_max - r.t_min]
            };
            write(folder, &format!("{name}.{purpose:?}"), rays.iter().flat_map(numbers));
            let (seconds, hits) = (0..ROUNDS).map(|_| time(subject, rays, purpose)).fold((f64::INFINITY, 0), least);
            println!("{name} {purpose:?} {} {seconds} {hits}", rays.len());
        }
    }
}

fn least(a: (f64, usize), b: (f64, usize)) -> (f64, usize) {
    if a.0 < b.0 { a } else { b }
}

fn time(subject: &Subject, rays: &[Ray], purpose: Purpose) -> (f64, usize) {
    let mut queries = Queries::default();
    let start = Instant::now();
    let hits = match purpose {
        Purpose::Shadow => rays.iter().filter(|ray| queries.occluded(&subject.world, ray)).count(),
        _ => rays.iter().filter(|ray| queries.intersect(&subject.world, ray).exists()).count(),
    };
    (start.elapsed().as_secs_f64(), hits)
}

/// Corners of all triangles outside of instances.
fn triangles(subject: &Subject) -> impl Iterator<Item = f32> {
    let meshes = subject.world.scene.shapes.iter().filter_map(|s| match &s.geometry {
        Geometry::Mesh(mesh) => Some(mesh),
        Geometry::Sphere(_) => None,
    });
    meshes.flat_map(|m| m.triangles.iter().flatten().flat_map(|&i| m.positions[i as usize].to_array()))
}

fn write(folder: &Path, name: &str, numbers: impl Iterator<Item = f32>) {
    let bytes: Vec<u8> = numbers.flat_map(f32::to_le_bytes).collect();
    std::fs::write(folder.join(name), bytes).expect("a folder that can be written");
}
