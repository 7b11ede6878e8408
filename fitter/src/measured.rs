//! A material from a file of measured data, and what a person should know of it before using it.

use brdf_tables::brdf::{Brdf, Specular};
use brdf_tables::frame::spherical;
use brdf_tables::material::Material;
use brdf_tables::measured::{self, Format, ReadError, Reading};
use glam::{DVec2, DVec3};
use std::path::Path;

/// Samples of an albedo, a side of the grid.
const SIDE: usize = 96;
/// Zenith angles at which the energy is looked at, degrees.
pub const VIEWS: [f64; 7] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0];

/// Whether an argument names a file of measured data: by what it ends in.
pub fn is_data(argument: &str) -> bool {
    Format::of(Path::new(argument)).is_some()
}

/// The data and the material of a file, and lines about both.
///
/// # Errors
/// What is wrong with the file, in one line.
pub fn load(path: &Path) -> Result<(Reading, Material, Vec<String>), ReadError> {
    let (reading, built) = measured::load(path)?;
    let mut notes = reading.notes.clone();
    if let Some(Specular::Measured(data)) = &built.material.specular {
        let sides = |lattice: [usize; 3]| lattice.map(|n| n.to_string()).join(" × ");
        let colors = data.tint_lattice().map_or("grey".into(), |l| format!("colours {}", sides(l)));
        let [median, p95] = built.difference;
        notes.push(format!(
            "kept as {} values over half and difference angles, {colors}, {} bytes; off the data between the nodes by {:.2} % \
            in the median, {:.2} % at the 95th percentile",
            sides(data.lattice()),
            data.bytes(),
            100.0 * median,
            100.0 * p95
        ));
    }
    let (nodes, missing) = built.nodes;
    if missing > 0 {
        let percent = 100.0 * missing as f64 / nodes as f64;
        notes.push(format!("{percent:.1} % of the directions are not in the data: continued from their neighbours"));
    }
    let too_bright: Vec<String> = VIEWS
        .into_iter()
        .map(|degrees| (degrees, albedo(&built.material, spherical(degrees.to_radians(), 0.0))))
        .filter(|(_, rgb)| rgb.iter().any(|x| *x > 1.005))
        .map(|(degrees, rgb)| format!("{degrees}°: {}", rgb.map(|x| format!("{x:.3}")).join(", ")))
        .collect();
    if !too_bright.is_empty() {
        notes.push(format!("ENERGY: more light leaves than arrives, albedo seen at {}", too_bright.join("; ")));
    }
    Ok((reading, built.material, notes))
}

/// Directional albedo: the light reflected towards `wo` under a white sky of radiance 1.
pub fn albedo(material: &Material, wo: DVec3) -> [f64; 3] {
    let mut sum = material.kd;
    let Some(specular) = &material.specular else { return sum };
    for i in 0..SIDE * SIDE {
        let u = (DVec2::new((i / SIDE) as f64, (i % SIDE) as f64) + 0.5) / SIDE as f64;
        let Some(wi) = specular.sample(wo, u) else { continue };
        let density = specular.pdf(wi, wo) * (SIDE * SIDE) as f64;
        if density > 0.0 {
            let (value, tint) = (specular.eval(wi, wo) * wi.z / density, specular.tint(wi, wo));
            (0..3).for_each(|c| sum[c] += material.ks[c] * value * tint[c]);
        }
    }
    sum
}
