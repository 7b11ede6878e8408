//! What a scene takes up in space, and a camera that sees all of it.

use crate::scene::{Camera, Film, Geometry, Projection, Scene, Shape};
use glam::{Affine3A, BVec3, Mat3, Vec3};

/// Rows of pictures whose size no file states.
pub const HEIGHT: u32 = 720;

/// Calls `f` with points in world space around everything: the vertices of shapes, and the corners of boxes around spheres
/// and around every placement of a group, of which there may be far too many to look at each vertex.
pub fn outline(scene: &Scene, mut f: impl FnMut(Vec3)) {
    for shape in &scene.shapes {
        points(shape, &mut f);
    }
    let boxes: Vec<_> =
        scene.groups.iter().map(|group| around(|f| group.shapes.iter().for_each(|s| points(s, f)))).collect();
    for instance in &scene.instances {
        if let Some((low, high)) = boxes[instance.group as usize] {
            corners(low, high).for_each(|p| f(instance.to_world.transform_point3(p)));
        }
    }
}

fn points(shape: &Shape, f: &mut dyn FnMut(Vec3)) {
    match &shape.geometry {
        Geometry::Mesh(mesh) => mesh.positions.iter().for_each(|&p| f(p)),
        Geometry::Sphere(s) => {
            let (center, radius) = (Vec3::from(s.center), Vec3::splat(s.radius));
            corners(center - radius, center + radius).for_each(f);
        }
    }
}

/// The corners of a box.
pub fn corners(low: Vec3, high: Vec3) -> impl Iterator<Item = Vec3> {
    (0..8).map(move |i| Vec3::select(BVec3::new(i & 1 == 1, i & 2 == 2, i & 4 == 4), low, high))
}

/// The box around the points that a function calls another one with; `None` where there are none.
fn around(points: impl FnOnce(&mut dyn FnMut(Vec3))) -> Option<(Vec3, Vec3)> {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    points(&mut |p| (low, high) = (low.min(p), high.max(p)));
    (low.is_finite() && high.is_finite()).then_some((low, high))
}

/// The lowest and the highest corner of everything; `None` where there is nothing.
pub fn bounds(scene: &Scene) -> Option<(Vec3, Vec3)> {
    around(|f| outline(scene, f))
}

/// A camera that sees the box around everything, from a corner, `up` being an axis; `None` where there is nothing.
pub fn frame_everything(scene: &Scene, up: Vec3) -> Option<Camera> {
    let (low, high) = bounds(scene)?;
    let radius = 0.5 * (high - low).length();
    if !radius.is_finite() || radius == 0.0 {
        return None;
    }
    let center = 0.5 * (low + high);
    let film = Film { width: HEIGHT * 16 / 9, height: HEIGHT, ..Camera::default().film };
    let half_height = 0.36f32;
    // y up is seen from +z, z up from −y: what programs call the front.
    let front = if up == Vec3::Z { Vec3::NEG_Y } else { Vec3::Z };
    let back = (0.5 * up.cross(front) + 0.4 * up + front).normalize();
    let distance = radius / half_height.sin();
    let left = up.cross(-back).normalize();
    let rotation = Mat3::from_cols(left, (-back).cross(left), -back);
    Some(Camera {
        to_world: Affine3A::from_mat3_translation(rotation, center + distance * back),
        projection: Projection::Perspective { fov_x: 2.0 * (half_height.tan() * 16.0 / 9.0).atan() },
        near: 1e-3 * radius,
        far: 10.0 * distance,
        film,
        ..Camera::default()
    })
}
