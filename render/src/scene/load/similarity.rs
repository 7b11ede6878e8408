//! Transforms without distortion, which cameras, spheres and environments need.

use glam::{DMat3, DVec3};

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

/// A matrix without the lengths of its axes, and without a mirror. What scaling bent stays so: a frame that hangs on a
/// stretched one has axes that are not orthogonal. `None` where they span no volume.
pub fn without_scale(matrix: DMat3) -> Option<DMat3> {
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec3::try_normalize);
    let unit = DMat3::from_cols(x?, y?, z?);
    let volume = unit.determinant();
    let whole = DMat3::from_cols(unit.x_axis * volume.signum(), unit.y_axis, unit.z_axis);
    (volume.abs() > 1e-6).then_some(whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_shear_and_mirrors_are_taken_off() {
        let turn = DMat3::from_euler(glam::EulerRot::YXZ, 0.4, -1.1, 0.3);
        for scale in [DVec3::ONE, DVec3::new(1e-9, 3.0, 1e9), DVec3::new(-1.0, 1.0, 1.0)] {
            let rotation = without_scale(turn * DMat3::from_diagonal(scale)).unwrap();
            assert!((rotation - turn).to_cols_array().iter().all(|e| e.abs() < 1e-12), "{scale}");
        }
        let stretched = without_scale(DMat3::from_diagonal(DVec3::new(1.0, 1.0, 2.0)) * turn).unwrap();
        assert!(stretched.z_axis.z > turn.z_axis.z && stretched.x_axis.is_normalized());
        assert_eq!(without_scale(DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Z)), None);
        assert_eq!(without_scale(DMat3::ZERO), None);
    }
}
