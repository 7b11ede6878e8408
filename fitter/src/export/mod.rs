//! The mean BRDF of a table on a plain grid, for programs that cannot link the library.

mod npy;
mod picture;
mod shader;

use brdf_tables::axis::Axes;
use brdf_tables::cap::Cap;
use brdf_tables::table::Table;
use core::f64::consts::{PI, TAU};
use glam::DVec3;
use rayon::prelude::*;
use serde_json::{Value, json};

pub use npy::npy;
pub use picture::{exr, exr_rgb};
pub use shader::wgsl;

/// Nodes along each axis.
#[derive(Clone, Copy, Debug)]
pub struct Nodes {
    /// Zenith angles of caps.
    pub theta: usize,
    /// Solid angles.
    pub omega: usize,
    /// Angles of the view from the mirror direction.
    pub delta: usize,
    /// Azimuths of the view about it.
    pub psi: usize,
}

/// The grid: the values of each axis, the slowest first, and the mean BRDF of the specular part at unit strength, sr⁻¹.
pub struct Grid {
    /// Name and values of each axis.
    pub axes: [(&'static str, Vec<f64>); 5],
    /// Values in the order of the axes.
    pub values: Vec<f32>,
}

/// How the axes are to be read, for the files themselves.
pub const FRAME: &str = "cap axis a = (sin theta_e cos phi_e, sin theta_e sin phi_e, cos theta_e), z is the normal; view wo = cos delta m + \
sin delta (cos psi u + sin psi v) with m = (-a.x, -a.y, a.z), u = (-cos theta_e cos phi_e, -cos theta_e sin phi_e, -sin theta_e), \
v = (sin phi_e, -cos phi_e, 0); values are 0 where wo is below the horizon; whole BRDF = kd/pi + ks * tint * value";

/// Samples the table.
pub fn grid(table: &Table, nodes: Nodes) -> Option<Grid> {
    let (mean, specular) = (table.mean()?, table.specular()?);
    let isotropic = specular.is_isotropic();
    let width = specular.lobe_width();
    let axes = Axes {
        theta: nodes.theta as u32,
        phi: if isotropic { 1 } else { 5 },
        omega: nodes.omega as u32,
        sharpness: width.powi(-2),
        stretch: 0.5,
    };
    let theta: Vec<f64> = (0..nodes.theta).map(|i| axes.theta_at(i)).collect();
    let phi: Vec<f64> = (0..axes.phi as usize).map(|i| axes.phi_at(i)).collect();
    let omega: Vec<f64> = (0..nodes.omega).map(|i| axes.omega_at(i).max(1e-12)).collect();
    // Half of the nodes within two lobe widths of the mirror direction: delta = k s / (1 - s²), the last at π.
    let k = 2.0 * width;
    let top = (-k + (k * k + 4.0 * PI * PI).sqrt()) / TAU;
    let delta: Vec<f64> = (0..nodes.delta)
        .map(|i| top * i as f64 / (nodes.delta - 1) as f64)
        .map(|s| (k * s / (1.0 - s * s)).min(PI))
        .collect();
    let turn = if isotropic { PI } else { TAU };
    let psi: Vec<f64> = (0..nodes.psi).map(|i| turn * i as f64 / (nodes.psi - 1) as f64).collect();
    let caps: Vec<(f64, f64, f64)> = theta
        .iter()
        .flat_map(|&t| phi.iter().flat_map(move |&p| [(t, p)]))
        .flat_map(|(t, p)| omega.iter().map(move |&o| (t, p, o)))
        .collect();
    let of = |&(theta, phi, omega): &(f64, f64, f64)| -> Vec<f32> {
        let Ok(cap) = Cap::new(theta, phi, omega) else { return vec![0.0; delta.len() * psi.len()] };
        let views = delta.iter().flat_map(|&d| psi.iter().map(move |&p| view(theta, phi, d, p)));
        views.map(|wo| if wo.z > 0.0 { mean.value(&cap, wo) as f32 } else { 0.0 }).collect()
    };
    let values = caps.par_iter().map(of).collect::<Vec<_>>().concat();
    Some(Grid { axes: [("theta_e", theta), ("phi_e", phi), ("omega", omega), ("delta", delta), ("psi", psi)], values })
}

/// The view of [`FRAME`].
fn view(theta: f64, phi: f64, delta: f64, psi: f64) -> DVec3 {
    let ((st, ct), (sp, cp)) = (theta.sin_cos(), phi.sin_cos());
    let mirror = DVec3::new(-st * cp, -st * sp, ct);
    let (u, v) = (DVec3::new(-ct * cp, -ct * sp, -st), DVec3::new(sp, -cp, 0.0));
    (delta.cos() * mirror + delta.sin() * (psi.cos() * u + psi.sin() * v)).normalize()
}

/// Everything as JSON.
pub fn json(table: &Table, grid: &Grid) -> String {
    let material = &table.header.material;
    let axes: serde_json::Map<String, Value> = grid.axes.iter().map(|(name, x)| (name.to_string(), json!(x))).collect();
    let order: Vec<&str> = grid.axes.iter().map(|(name, _)| *name).collect();
    let shape: Vec<usize> = grid.axes.iter().map(|(_, x)| x.len()).collect();
    let whole = json!({
        "material": material.recipe_text(),
        "kd": material.kd,
        "ks": material.ks,
        "units": "angles in radian, omega in sr, values in 1/sr",
        "frame": FRAME,
        "order": order,
        "shape": shape,
        "axes": axes,
        "values": grid.values,
    });
    whole.to_string() + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdf_tables::frame::mirror;

    #[test]
    fn views_are_about_the_mirror_direction() {
        let cap = Cap::new(0.7, 1.0, 0.1).unwrap();
        assert!((view(0.7, 1.0, 0.0, 0.3) - mirror(cap.axis())).length() < 1e-12);
        for psi in [0.0, 1.0, 3.0] {
            assert!((view(0.7, 1.0, 0.4, psi).dot(mirror(cap.axis())) - 0.4f64.cos()).abs() < 1e-12);
        }
        // ψ = 0 leads to the horizon, within the plane of incidence.
        assert!(view(0.7, 0.0, 0.4, 0.0).z < 0.7f64.cos() && view(0.7, 0.0, 0.4, 0.0).y.abs() < 1e-12);
    }

    #[test]
    fn a_grid_has_a_value_for_every_node() {
        let table = Table::from_bytes(include_bytes!("../../../tables/phong-100.tbl")).unwrap();
        let grid = grid(&table, Nodes { theta: 4, omega: 3, delta: 5, psi: 2 }).unwrap();
        assert_eq!(grid.values.len(), 4 * 3 * 5 * 2);
        assert_eq!(grid.axes[4].1, [0.0, PI]);
        // The smallest cap along the normal, seen from the mirror direction: f_r itself.
        assert!((f64::from(grid.values[0]) / (102.0 / TAU) - 1.0).abs() < 1e-3, "{}", grid.values[0]);
        let parsed: Value = serde_json::from_str(&json(&table, &grid)).unwrap();
        assert_eq!(parsed["shape"], json!([4, 1, 3, 5, 2]));
        assert_eq!(parsed["values"].as_array().unwrap().len(), 120);
    }
}
