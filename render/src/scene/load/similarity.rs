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
