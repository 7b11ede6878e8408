//! The glossy cache in another renderer: what a pixel shows and what light comes along a ray are closures.
//! `cargo run --release -p burnish-render --no-default-features --example cache_library -- tables/phong-100.tbl`

use brdf_tables::table::Table;
use glam::Vec3A;
use render::cache::Grid;
use render::frame::Frame;
use render::glossy::{GlossyCache, Spot};
use render::hemisphere::Incident;
use render::record::Scratch;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("{}", run(&std::env::args().nth(1).ok_or("usage: cache_library TABLE")?)?);
    Ok(())
}

pub fn run(table: &str) -> Result<String, Box<dyn std::error::Error>> {
    let grid = Grid { width: 64, height: 48 };

    // Your renderer: what a pixel shows. Here a glossy floor of 2 by 1.5, seen from above its near edge.
    let eye = Vec3A::new(0.0, -2.0, 1.5);
    let spot = |pixel: usize| {
        let (x, y) = (pixel as u32 % grid.width, pixel as u32 / grid.width);
        let position = Vec3A::new((x as f32 - 31.5) / 32.0, (23.5 - y as f32) / 32.0, 0.0);
        Some(Spot {
            position,
            frame: Frame::from_normal(Vec3A::Z),
            wo: (eye - position).normalize(),
            material: 0,
            diffuse: Vec3A::splat(0.2),
            specular: Vec3A::splat(0.6),
            footprint: 1.0 / 32.0,
        })
    };
    // Your renderer: light along a ray, with the distance and normal of what it meets. Here a bright strip on a ceiling at height 2.
    let light = |from: &Spot, direction: Vec3A, _: &mut _| {
        let distance = 2.0 / direction.z.max(1e-4);
        let radiance = if (from.position + direction * distance).x.abs() < 0.3 { 5.0 } else { 0.1 };
        Incident { radiance: Vec3A::splat(radiance), distance, normal: -Vec3A::Z }
    };

    let mut cache = GlossyCache::new((Vec3A::splat(-2.0), Vec3A::splat(2.0)), vec![Table::load(table)?], 0.02)?;
    cache.fill(grid, 1, spot, light);

    let (mut scratch, mut sum, mut pixels) = (Scratch::default(), Vec3A::ZERO, 0);
    for found in (0..64 * 48).filter_map(spot).filter_map(|s| cache.light(&s, &mut scratch)) {
        sum += found.radiance;
        pixels += 1;
    }
    let (records, bytes) = (cache.records().records().len(), cache.records().bytes());
    Ok(format!("{records} records, {bytes} bytes, {pixels} pixels of mean radiance {:.4}", sum.x / pixels as f32))
}
