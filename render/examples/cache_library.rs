//! The cache without our scenes: incident radiance is a closure, the material a table.
//! `cargo run --release -p render --example cache_library -- tables/phong-100.tbl`

use brdf_tables::table::Table;
use glam::Vec3A;
use render::cache::{Cache, Weight};
use render::frame::Frame;
use render::hemisphere::{Incident, gather_uniform, hemisphere_directions};
use render::record::eas::{EasRecord, Estimator};
use render::record::{Albedo, Centroid, CutSettings, Receiver, Record, Reflector, Scratch, Tree, cut, reflect};
use render::sampler::Sampler;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("{}", run(&std::env::args().nth(1).ok_or("usage: cache_library TABLE")?)?);
    Ok(())
}

pub fn run(path: &str) -> Result<String, Box<dyn std::error::Error>> {
    let table = Table::load(path)?;
    let albedo = Albedo::new(&table);
    let reflector = Reflector::new(&table, Vec3A::splat(0.2), Vec3A::splat(0.6));

    // Your renderer: radiance, distance and normal along a ray from x. Here a bright strip on a ceiling at height 2.
    let light_from = |x: Vec3A, d: Vec3A| {
        let distance = (2.0 - x.z) / d.z.max(1e-4);
        let radiance = if (x.x + d.x * distance).abs() < 0.3 { Vec3A::splat(5.0) } else { Vec3A::splat(0.1) };
        Incident { radiance, distance, normal: -Vec3A::Z }
    };

    // A record: gather, build the tree, cut it, keep the cut.
    let mut cache = Cache::new(Vec3A::splat(-2.0), Vec3A::splat(2.0));
    for i in 0..9 {
        let (x, frame) = (Vec3A::new(0.25 * i as f32 - 1.0, 0.0, 0.0), Frame::from_normal(Vec3A::Z));
        let point = |number| Sampler::new(1, (i, 0), number).next_2d();
        let mut samples = gather_uniform(&frame, 4096, point, |d, _| light_from(x, d));
        let tree = Tree::new(&mut samples, 4, Centroid::Direction);
        let settings = CutSettings { tolerance: 0.02, max_eas: 300 };
        let cut = cut(&tree, &reflector, &hemisphere_directions(64), &settings);
        let mut record = EasRecord::new(x, &frame, 0, &tree, &cut, Estimator::Improved);
        record.set_radius(0.4);
        cache.insert(record);
    }

    // Shading: every record near, translated, weighted (eq. 17).
    let (position, wo) = (Vec3A::new(0.1, 0.05, 0.0), Vec3A::new(0.0, -0.6, 0.8));
    let at = Receiver { position, frame: Frame::from_normal(Vec3A::Z), wo };
    let (mut radiance, mut weights, mut scratch) = (Vec3A::ZERO, 0.0, Scratch::default());
    cache.interpolate(position, Vec3A::Z, Weight::Smooth, |record, w| {
        let part = reflect(record, &at, &reflector, &albedo, Estimator::Improved, &mut scratch);
        radiance += (reflector.diffuse / core::f32::consts::PI * part.irradiance + part.specular) * w;
        weights += w;
    });
    Ok(format!("{} records, {} bytes, radiance {:.4}", cache.records().len(), cache.bytes(), radiance / weights))
}
