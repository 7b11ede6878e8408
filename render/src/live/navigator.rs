//! Where the eye is, and how it moves.

use crate::scene::{Camera, FovAxis, Projection};
use crate::walk::Row;
use core::f64::consts::FRAC_PI_2;
use glam::{DMat3, DQuat, DVec3};

/// Nearest that the view comes to the vertical, radian.
const FROM_VERTICAL: f64 = 0.02;

/// How far from the middle of the scene the eye may go, in diagonals of the scene.
const FARTHEST: f64 = 50.0;

/// What a film of parallel rays may show, in diagonals of the scene.
const SHOWN: [f64; 2] = [1e-4, 50.0];

/// How many times nearer a second of walking brings what is seen with parallel rays: that of what one walks up to with others.
const NEARER: f64 = 1.5;

/// A camera that turns and walks.
///
/// It turns about the axis of the world that is nearest to the camera's own upwards: scenes may have y or z up.
#[derive(Clone, Debug)]
pub struct Navigator {
    home: Camera,
    camera: Camera,
    eye: DVec3,
    /// Left, up and forward.
    axes: DMat3,
    up: DVec3,
    /// Scene units that the eye walks in a second.
    pace: f64,
    /// Middle and diagonal of the scene.
    middle: DVec3,
    size: f64,
}

impl Navigator {
    /// From the camera of a scene with these corners; `pace` are scene units in a second.
    pub fn new(camera: &Camera, corners: [DVec3; 2], pace: f64) -> Self {
        let axes = camera.to_world.matrix3.as_dmat3();
        let [left, up] = [axes.x_axis, axes.y_axis];
        let forward = axes.z_axis.normalize_or(DVec3::Z);
        let upright =
            (up - forward * up.dot(forward)).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        // Cameras of files may be skewed or mirrored: what moves is neither.
        let right_handed = upright.cross(forward);
        let left = if right_handed.dot(left) < 0.0 { -right_handed } else { right_handed };
        let largest = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().max_by(|a, b| {
            let along = |axis: &DVec3| upright.dot(*axis).abs();
            along(a).total_cmp(&along(b))
        });
        let axis = largest.unwrap_or(DVec3::Y);
        let [low, high] = corners;
        let size = (high - low).length();
        Self {
            home: camera.clone(),
            camera: camera.clone(),
            eye: camera.to_world.translation.as_dvec3(),
            axes: DMat3::from_cols(left, upright, forward),
            up: axis * 1f64.copysign(upright.dot(axis)),
            pace,
            middle: 0.5 * (low + high),
            size: if size.is_finite() && size > 0.0 { size } else { 1.0 },
        }
    }

    /// The camera now.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Turns to the left, and upwards, by angles in radian.
    pub fn turn(&mut self, yaw: f64, pitch: f64) {
        let forward = self.axes.z_axis;
        let height = forward.dot(self.up).clamp(-1.0, 1.0).asin();
        let most = FRAC_PI_2 - FROM_VERTICAL;
        // What stands steeper at first may come back only.
        let pitch = (height + pitch).clamp(most.min(height).min(-most), most.max(height)) - height;
        let about = |axis: DVec3, angle: f64| DMat3::from_quat(DQuat::from_axis_angle(axis, angle));
        let axes = about(self.up, yaw) * about(self.axes.x_axis, -pitch * self.handedness()) * self.axes;
        // Rounding must not add up.
        let forward = axes.z_axis.normalize();
        let up = (axes.y_axis - forward * axes.y_axis.dot(forward)).normalize();
        self.place(self.eye, DMat3::from_cols(up.cross(forward) * self.handedness(), up, forward));
    }

    /// Goes forward, to the right and upwards for so many seconds.
    pub fn go(&mut self, [forward, right, up]: [f64; 3]) {
        let DMat3 { x_axis: left, z_axis, .. } = self.axes;
        let way = z_axis * forward - left * right + self.up * up;
        let offset = self.eye + way * self.pace - self.middle;
        self.place(self.middle + offset.clamp_length_max(FARTHEST * self.size), self.axes);
    }

    /// Goes a way at once. With parallel rays nothing is seen nearer by going there: the film shows less instead.
    pub fn step(&mut self, [forward, right, up]: [f64; 3]) {
        let Projection::Orthographic { half_width } = self.camera.projection else {
            return self.go([forward, right, up]);
        };
        let [least, most] = SHOWN.map(|share| 0.5 * share * self.size);
        let wide = f64::from(half_width);
        let shown = (wide * NEARER.powf(-forward)).clamp(least.min(wide), most.max(wide)) as f32;
        self.camera.projection = Projection::Orthographic { half_width: shown };
        self.go([0.0, right, up]);
    }

    /// Goes back to where it began.
    pub fn home(&mut self) {
        let corners = [self.middle - DVec3::X * (0.5 * self.size), self.middle + DVec3::X * (0.5 * self.size)];
        *self = Self::new(&self.home, corners, self.pace);
    }

    /// Walks so many times as fast.
    pub fn hurry(&mut self, factor: f64) {
        self.pace *= factor;
    }

    /// The camera as a row of a path, along `axis` of a film whose width is `aspect` times its height.
    pub fn row(&self, axis: FovAxis, aspect: f64) -> Row {
        let (fov, width) = match self.camera.projection {
            Projection::Perspective { fov_x } => {
                let half = (0.5 * f64::from(fov_x)).tan() / axis.half_width(1.0, aspect);
                (Some((2.0 * half.atan()).to_degrees()), None)
            }
            Projection::Orthographic { half_width } => (None, Some(2.0 * f64::from(half_width))),
        };
        Row { eye: self.eye, look: self.eye + self.axes.z_axis, up: self.axes.y_axis, fov, width }
    }

    fn place(&mut self, eye: DVec3, axes: DMat3) {
        let camera = &mut self.camera;
        if eye.is_finite() && axes.is_finite() {
            (self.eye, self.axes) = (eye, axes);
            camera.to_world.matrix3 = axes.as_mat3().into();
            camera.to_world.translation = eye.as_vec3a();
        }
    }

    /// −1 where the picture is mirrored.
    fn handedness(&self) -> f64 {
        1f64.copysign(self.axes.determinant())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walk::Walk;
    use std::collections::BTreeMap;

    const CORNERS: [DVec3; 2] = [DVec3::NEG_ONE, DVec3::ONE];

    fn navigator(eye: DVec3, look: DVec3, up: DVec3) -> Navigator {
        let to_world = Camera::look_at(eye, look, up).unwrap();
        Navigator::new(&Camera { to_world, ..Camera::default() }, CORNERS, 2.0)
    }

    fn forward(n: &Navigator) -> DVec3 {
        n.camera().to_world.matrix3.z_axis.as_dvec3()
    }

    #[test]
    fn turns_and_walks() {
        let mut n = navigator(DVec3::new(0.0, 1.0, -4.0), DVec3::new(0.0, 1.0, 0.0), DVec3::Y);
        let left = n.camera().to_world.matrix3.x_axis.as_dvec3();
        n.turn(0.3, 0.0);
        assert!(forward(&n).dot(left) > 0.29, "to the left");
        n.turn(-0.3, 0.2);
        assert!((forward(&n).y - 0.2f64.sin()).abs() < 1e-6 && forward(&n).x.abs() < 1e-6, "up: {}", forward(&n));
        n.turn(0.0, -0.2);
        n.go([1.0, 0.5, 0.25]);
        let eye = n.camera().to_world.translation.as_dvec3();
        assert!((eye - (DVec3::new(0.0, 1.5, -2.0) - left)).length() < 1e-6, "{eye}");
        n.home();
        assert_eq!(n.camera(), &n.home);
    }

    /// Parallel rays: a step ahead shows less of the scene, from where it was; its row gives the same camera again.
    #[test]
    fn parallel_rays_come_nearer() {
        let to_world = Camera::look_at(DVec3::NEG_Z, DVec3::ZERO, DVec3::Y).unwrap();
        let projection = Projection::Orthographic { half_width: 3.0 };
        let mut n = Navigator::new(&Camera { to_world, projection, ..Camera::default() }, CORNERS, 2.0);
        let wide = |camera: &Camera| match camera.projection {
            Projection::Orthographic { half_width } => half_width,
            Projection::Perspective { .. } => panic!("it has become another"),
        };
        n.step([1.0, 0.0, 0.0]);
        assert!((wide(n.camera()) - 2.0).abs() < 1e-6 && n.eye == DVec3::NEG_Z);
        let rows = BTreeMap::from([(1, n.row(FovAxis::X, 1.0))]);
        let walk = Walk::through(&rows, &n.home, FovAxis::X, 1.0).unwrap();
        assert_eq!(wide(walk.camera(1).unwrap()), wide(n.camera()));
        n.step([-1.0, 0.0, 0.0]);
        assert!((wide(n.camera()) - 3.0).abs() < 1e-5);
        for forward in [1e4, -1e4] {
            n.step([forward, 0.0, 0.0]);
            assert!(wide(n.camera()).is_normal(), "{forward}");
        }
        n.home();
        assert_eq!(n.camera(), &n.home);
    }

    /// However it is turned, the view stays upright, finite and off the vertical.
    #[test]
    fn stays_upright() {
        for up in [DVec3::Y, DVec3::Z, DVec3::NEG_X] {
            let mut n = navigator(DVec3::new(0.3, 0.1, 0.2), DVec3::new(0.4, 0.2, 0.3), up);
            for i in 0..2000 {
                n.turn(0.37, if i / 100 % 2 == 0 { 0.9 } else { -0.4 });
                n.go([1e6, -3.0, 2.0]);
                let m = n.camera().to_world.matrix3;
                assert!(m.y_axis.as_dvec3().dot(up) > 0.0 && forward(&n).dot(up).abs() < 0.9999, "{up} {i}");
                assert!((m.determinant() - 1.0).abs() < 1e-5 && n.eye.length() < 1000.0);
            }
        }
    }

    /// A view from straight above can be left, but not turned over.
    #[test]
    fn from_straight_above() {
        let mut n = navigator(DVec3::new(0.0, 5.0, 0.0), DVec3::ZERO, DVec3::Z);
        n.turn(0.5, 0.3);
        n.turn(0.0, -9.0);
        assert!(n.camera().to_world.is_finite());
        let mut mirrored =
            Camera { to_world: Camera::look_at(DVec3::Z, DVec3::ZERO, DVec3::Y).unwrap(), ..Camera::default() };
        mirrored.to_world.matrix3.x_axis *= -1.0;
        let mut n = Navigator::new(&mirrored, CORNERS, 1.0);
        n.turn(0.1, 0.2);
        assert!(n.camera().to_world.matrix3.determinant() < 0.0 && forward(&n).y > 0.19);
    }

    /// A row gives the same camera again, whatever axis the scene measures its angle along.
    #[test]
    fn rows_give_the_camera_again() {
        for axis in [FovAxis::X, FovAxis::Y, FovAxis::Diagonal, FovAxis::Smaller, FovAxis::Larger] {
            let mut n = navigator(DVec3::new(0.3, 0.1, -2.0), DVec3::ZERO, DVec3::Y);
            n.turn(0.2, -0.1);
            n.go([0.3, 0.2, 0.1]);
            let walk = Walk::through(&BTreeMap::from([(1, n.row(axis, 1.6))]), &n.home, axis, 1.6).unwrap();
            let (found, expected) = (walk.camera(1).unwrap(), n.camera());
            assert!(found.to_world.abs_diff_eq(expected.to_world, 1e-6), "{axis:?}");
            let fov = |camera: &Camera| match camera.projection {
                Projection::Perspective { fov_x } => fov_x,
                Projection::Orthographic { .. } => 0.0,
            };
            assert!((fov(found) - fov(expected)).abs() < 1e-6);
        }
    }
}
