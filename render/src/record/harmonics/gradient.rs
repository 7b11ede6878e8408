//! What moves, and how much, when a record moves along its tangent plane (Křivánek et al. 2005, §4.3 and Fig. 3): the
//! direction of a sample and the solid angle of the patch it stands for. The patch and its radiance stay.

use super::basis::Basis;
use glam::Vec3A;

/// How translational gradients are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Gradients {
    /// By differentiating every term of the projection (§4.3.2).
    #[default]
    Analytic,
    /// By projecting every sample again from a displaced point (§4.3.1).
    Numerical,
    /// None are stored: records are a third as large.
    None,
}

/// What a sample hits, as its record sees it. All in one frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    /// Unit direction to it.
    pub direction: Vec3A,
    /// Its unit normal, towards the record.
    pub normal: Vec3A,
    /// 1/distance; 0 at infinity.
    pub inv_distance: f32,
}

/// Derivatives along one axis, per unit of length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Change {
    /// Derivative of the solid angle, over the solid angle.
    pub solid_angle: f32,
    /// Derivative of the height z; over z in the hemispherical basis, whose slopes are infinite at the horizon.
    pub height: f32,
    /// Derivative of the azimuth, radian.
    pub azimuth: f32,
}

/// Cosine below which a patch is not seen to turn: its solid angle would change without bound.
const GRAZING: f32 = 0.05;

/// Displacement of the numerical gradient over the distance of the sample.
pub(super) const DISPLACEMENT: f32 = 1.0 / 1024.0;

/// Smallest x² + y² that azimuths are divided by.
const SMALLEST_RHO2: f32 = 1e-6;

impl Patch {
    fn facing(&self) -> (Vec3A, f32) {
        let normal = if self.normal == Vec3A::ZERO { -self.direction } else { self.normal };
        (normal, (-normal.dot(self.direction)).max(0.0))
    }

    /// Derivatives with respect to a step along the unit vector `axis`: q − p changes by −axis, Ω ∝ cosξ/r².
    #[inline(always)]
    pub(super) fn change(&self, basis: Basis, axis: Vec3A) -> Change {
        let (d, (normal, cos)) = (self.direction, self.facing());
        let along = d.dot(axis);
        let turned = normal.dot(axis) + cos * along;
        let solid_angle = 2.0 * along + cos * turned / (cos * cos + GRAZING * GRAZING);
        let height = match basis {
            // The axis lies in the tangent plane: z changes by z · along.
            Basis::Hemispherical => along,
            Basis::Spherical => d.z * along - axis.z,
        };
        let rho2 = (d.x * d.x + d.y * d.y).max(SMALLEST_RHO2);
        let azimuth = (d.y * axis.x - d.x * axis.y) / rho2;
        Change {
            solid_angle: solid_angle * self.inv_distance,
            height: height * self.inv_distance,
            azimuth: azimuth * self.inv_distance,
        }
    }

    /// Direction and ratio of the solid angles after a step of [`DISPLACEMENT`] times the distance along `axis`.
    #[inline(always)]
    pub(super) fn displaced(&self, axis: Vec3A) -> (Vec3A, f32) {
        let (normal, cos) = self.facing();
        let toward = self.direction - axis * DISPLACEMENT;
        let inv_length = toward.length_recip();
        let direction = toward * inv_length;
        let soft = |cos: f32| (cos * cos + GRAZING * GRAZING).sqrt();
        let ratio = inv_length * inv_length * soft((-normal.dot(direction)).max(0.0)) / soft(cos);
        (direction, ratio)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both ways see a patch move alike: to the size of the displacement.
    #[test]
    fn derivatives_agree_with_a_displacement() {
        let axis = Vec3A::new(0.6, -0.8, 0.0);
        for (direction, normal) in [
            (Vec3A::new(0.48, 0.6, 0.64), -Vec3A::Z),
            (Vec3A::new(-0.6, 0.0, 0.8), Vec3A::new(0.36, 0.48, -0.8)),
            (Vec3A::new(0.3, -0.2, 0.1).normalize(), Vec3A::ZERO),
        ] {
            let patch = Patch { direction, normal, inv_distance: 0.5 };
            let (moved, ratio) = patch.displaced(axis);
            let rate = |difference: f32| difference * patch.inv_distance / DISPLACEMENT;
            let change = patch.change(Basis::Spherical, axis);
            assert!((rate(ratio - 1.0) - change.solid_angle).abs() < 5e-3, "{direction}");
            assert!((rate(moved.z - direction.z) - change.height).abs() < 5e-3, "{direction}");
            let turn = moved.y.atan2(moved.x) - direction.y.atan2(direction.x);
            assert!((rate(turn) - change.azimuth).abs() < 1e-2, "{direction}");
            let hemispherical = patch.change(Basis::Hemispherical, axis);
            assert!((hemispherical.height * direction.z - change.height).abs() < 1e-6);
        }
    }

    /// Light at infinity does not move; grazing patches change at a bounded rate.
    #[test]
    fn changes_are_bounded() {
        let direction = Vec3A::new(0.8, 0.0, 0.6);
        for angle in [0.0, 0.001, 0.05, 0.3f32] {
            // Turned from edge-on by `angle`.
            let normal = Vec3A::new(-0.6, 0.0, 0.8) * angle.cos() - direction * angle.sin();
            let change = Patch { direction, normal, inv_distance: 1.0 }.change(Basis::Hemispherical, Vec3A::X);
            assert!(change.solid_angle.abs() < 2.0 + 0.5 / GRAZING);
            let far = Patch { direction, normal, inv_distance: 0.0 }.change(Basis::Hemispherical, Vec3A::X);
            assert_eq!((far.solid_angle, far.height, far.azimuth), (0.0, 0.0, 0.0));
        }
    }
}
