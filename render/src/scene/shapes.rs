//! Mitsuba's elementary shapes as meshes, and which side of a shape is its front.
//!
//! # The front
//! The front is the side that normals point to: lamps shine from it, and the materials of [`super::Material::TwoSided`] and
//! the inside of a dielectric are told apart by it. One rule holds where a transform mirrors:
//!
//! **Normals are carried along.** Where a surface has normals of its own, the front is the image of the front, as if the
//! mirrored object were seen in a mirror. A surface without normals has none to carry: its front is the side from which its
//! corners run counterclockwise *where they end up*, so that a mirror exchanges its sides. `flip_normals` exchanges them
//! once more, after all transforms.
//!
//! | shape | normals | mirrored |
//! |---|---|---|
//! | `rectangle`, `disk`, `cube`, `cylinder` | those of the shape | image of the front |
//! | `sphere` | outward | image of the front: outward still |
//! | `obj`, `ply`, `serialized` with vertex normals | the file's; triangles that disagree are turned | image of the front |
//! | the same without normals, or with `face_normals` | by winding, after the transform | front and back exchanged |
//! | an instance of any of these | those that the shape has in its group | image of the front |
//! | glTF, with normals or without | by winding, which a negative determinant reverses (2.0, §3.7.4) | image of the front |
//!
//! Mitsuba 3.9.1 does the same (`tests/peers/mitsuba_inputs.py` asks it, inputs `mirrored-shapes`), but for the sphere:
//! there a mirror turns the radius negative and the front inwards, while cubes, cylinders and even instances of spheres keep
//! theirs outside. The rule above follows the majority.

use super::Mesh;
use core::f32::consts::TAU;
use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec3A, Vec3Swizzles};

/// Segments of a circle; a chord of 1/96 turn leaves its circle by 5·10⁻⁴ of the radius.
const SEGMENTS: u32 = 96;

impl Mesh {
    /// The same mesh under `to_world`: normals follow, and a reflection turns the winding so that fronts stay fronts. Where
    /// winding alone marks the front, the caller has it turned back (see above).
    pub fn transformed(mut self, to_world: Affine3A) -> Self {
        let m = to_world.matrix3;
        let normal = Mat3A::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        let sign = m.determinant().signum();
        for p in &mut self.positions {
            *p = to_world.transform_point3(*p);
        }
        for n in &mut self.normals {
            *n = (normal * Vec3A::from(*n) * sign).normalize_or_zero().into();
        }
        if sign < 0.0 {
            self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        self
    }

    /// The same mesh with front and back exchanged.
    pub fn flipped(mut self) -> Self {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        self.normals.iter_mut().for_each(|n| *n = -*n);
        self
    }

    /// The square [−1, 1]² in z = 0, front +z, uv over [0, 1]².
    pub fn rectangle(to_world: Affine3A) -> Self {
        let corners = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(u, v)| Vec2::new(u, v));
        Self {
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            positions: corners.map(|c| (2.0 * c - 1.0).extend(0.0)).to_vec(),
            uvs: corners.to_vec(),
            ..Self::default()
        }
        .transformed(to_world)
    }

    /// The cube [−1, 1]³, front outwards, uv over [0, 1]² on every face.
    pub fn cube(to_world: Affine3A) -> Self {
        let mut cube = Self::default();
        for axis in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z] {
            let u = axis.yzx().abs();
            let face =
                Self::rectangle(Affine3A::from_mat3_translation(glam::Mat3::from_cols(u, axis.cross(u), axis), axis));
            let base = cube.positions.len() as u32;
            cube.triangles.extend(face.triangles.iter().map(|t| t.map(|i| i + base)));
            cube.positions.extend(face.positions);
            cube.uvs.extend(face.uvs);
        }
        cube.transformed(to_world)
    }

    /// The unit disk in z = 0, front +z, u = radius, v = azimuth / 2π: a polygon of the same area.
    pub fn disk(to_world: Affine3A) -> Self {
        let step = TAU / SEGMENTS as f32;
        let radius = (step / step.sin()).sqrt();
        let mut disk = Self::default();
        for i in 0..SEGMENTS {
            let at = |k: u32| Vec3::new(radius * (step * k as f32).cos(), radius * (step * k as f32).sin(), 0.0);
            let v = |k: f32| k / SEGMENTS as f32;
            disk.positions.extend([Vec3::ZERO, at(i), at((i + 1) % SEGMENTS)]);
            disk.uvs.extend([
                Vec2::new(0.0, v(i as f32 + 0.5)),
                Vec2::new(1.0, v(i as f32)),
                Vec2::new(1.0, v(i as f32 + 1.0)),
            ]);
            disk.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
        }
        disk.transformed(to_world)
    }

    /// The side of the cylinder of `radius` around the segment p0 p1, front outwards, u around, v along.
    pub fn cylinder(p0: Vec3, p1: Vec3, radius: f32, to_world: Affine3A) -> Self {
        let (x, y) = (p1 - p0).normalize_or(Vec3::Z).any_orthonormal_pair();
        let mut side = Self::default();
        for i in 0..=SEGMENTS {
            let u = i as f32 / SEGMENTS as f32;
            let (s, c) = (TAU * (i % SEGMENTS) as f32 / SEGMENTS as f32).sin_cos();
            let n = c * x + s * y;
            side.positions.extend([p0 + radius * n, p1 + radius * n]);
            side.normals.extend([n, n]);
            side.uvs.extend([Vec2::new(u, 0.0), Vec2::new(u, 1.0)]);
        }
        side.triangles = (0..SEGMENTS).map(|i| 2 * i).flat_map(|a| [[a, a + 2, a + 3], [a, a + 3, a + 1]]).collect();
        side.transformed(to_world)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area_vector(m: &Mesh, t: &[u32; 3]) -> Vec3 {
        let [a, b, c] = t.map(|i| m.positions[i as usize]);
        (b - a).cross(c - a) / 2.0
    }

    #[test]
    fn fronts_face_out_and_areas_hold() {
        let mirrored = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
        for to_world in [Affine3A::IDENTITY, mirrored] {
            let cube = Mesh::cube(to_world);
            let cylinder = Mesh::cylinder(-Vec3::Z, Vec3::Z, 1.0, to_world);
            for m in [&cube, &cylinder] {
                for t in &m.triangles {
                    assert!(area_vector(m, t).dot(m.positions[t[0] as usize]) > 0.0);
                }
            }
            let area: f32 = cube.triangles.iter().map(|t| area_vector(&cube, t).length()).sum();
            assert!((area - 24.0).abs() < 1e-4);
            let disk = Mesh::disk(to_world);
            let sum: Vec3 = disk.triangles.iter().map(|t| area_vector(&disk, t)).sum();
            assert!((sum.z - core::f32::consts::PI).abs() < 1e-4, "{sum}");
        }
    }
}
