//! Transforms without distortion, which cameras, spheres and environments need.

use glam::DMat3;

/// Rotation (or reflection) and scale of a matrix whose columns are orthogonal and of equal length to 10⁻³.
pub fn similarity(matrix: DMat3) -> Option<(DMat3, f64)> {
    let scale = matrix.determinant().abs().cbrt();
    let unit = matrix * (1.0 / scale);
    let error = unit.transpose() * unit - DMat3::IDENTITY;
    // Gram-Schmidt takes off what rounding in the file left of the error.
    let z = unit.z_axis.normalize();
    let y = (unit.y_axis - z * z.dot(unit.y_axis)).normalize();
    let x = y.cross(z) * unit.determinant().signum();
    error.to_cols_array().iter().all(|e| e.abs() < 1e-3).then_some((DMat3::from_cols(x, y, z), scale))
}

/// The rotation of a matrix that scales, shears or mirrors: its z axis keeps its direction, y is made orthogonal to it,
/// x follows. `None` where y and z span no plane.
pub fn without_scale(matrix: DMat3) -> Option<DMat3> {
    let z = matrix.z_axis.try_normalize()?;
    let y = matrix.y_axis.try_normalize()?;
    let y = (y - z * z.dot(y)).try_normalize()?;
    Some(DMat3::from_cols(y.cross(z), y, z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn scale_shear_and_mirrors_are_taken_off() {
        let turn = DMat3::from_euler(glam::EulerRot::YXZ, 0.4, -1.1, 0.3);
        for scale in [DVec3::ONE, DVec3::new(1e-9, 3.0, 1e9), DVec3::new(-1.0, 1.0, 1.0)] {
            let rotation = without_scale(turn * DMat3::from_diagonal(scale)).unwrap();
            assert!((rotation - turn).to_cols_array().iter().all(|e| e.abs() < 1e-12), "{scale}");
        }
        let sheared = without_scale(DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.7), DVec3::Z)).unwrap();
        assert!((sheared.determinant() - 1.0).abs() < 1e-12 && sheared.z_axis == DVec3::Z);
        assert_eq!(without_scale(DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Z)), None);
        assert_eq!(without_scale(DMat3::ZERO), None);
    }
}
