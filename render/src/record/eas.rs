//! A record of equivalent area light sources (eas-2015, §3.2).

use super::{Cut, Record, Tree, Zone};
use crate::frame::Frame;
use crate::scene::Rgb;
use brdf_tables::cap::projected_solid_angle;
use brdf_tables::real::Real;
use core::f32::consts::TAU;
use glam::{Vec2, Vec3A};

/// How EAS are moved and summed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Estimator {
    /// As published in "A Radiance Cache Method for Highly Glossy Surfaces", 2015: irradiance and solid angle by its eq. 16.
    Paper,
    /// Irradiance of clipped caps, bounded foreshortening, background plus residual, smooth weights.
    #[default]
    Improved,
}

/// One source: 40 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Eas {
    /// Unit direction from the record, world space.
    pub direction: [f32; 3],
    /// 1/d, 0 at infinity.
    pub inv_distance: f32,
    /// [`Estimator::Paper`]: irradiance E. [`Estimator::Improved`]: E less that of the background, over the projected solid
    /// angle of the cap: a radiance.
    pub light: [f32; 3],
    /// Solid angle Ω, sr.
    pub solid_angle: f32,
    /// Octahedral mean normal, two signed 16-bit fractions.
    pub normal: [i16; 2],
    /// What eq. 16 needs of the record: 1/(cosθ cosα) ([`Estimator::Paper`]; d² is in the homogeneous direction) or 1/cosα.
    pub factor: f32,
}

impl Eas {
    /// Its mean normal.
    #[cfg(feature = "gpu")]
    pub(crate) fn mean_normal(&self) -> Vec3A {
        let [u, v] = self.normal.map(f32::from);
        Vec3A::from_array(unpack_normal(u, v))
    }

    /// Little-endian bytes, for a file.
    pub fn to_bytes(&self) -> [u8; 40] {
        let [dx, dy, dz] = self.direction;
        let [r, g, b] = self.light;
        let numbers = [dx, dy, dz, self.inv_distance, r, g, b, self.solid_angle, self.factor];
        let mut bytes = [0; 40];
        for (to, x) in bytes.chunks_exact_mut(4).zip(numbers) {
            to.copy_from_slice(&x.to_le_bytes());
        }
        bytes[36..38].copy_from_slice(&self.normal[0].to_le_bytes());
        bytes[38..].copy_from_slice(&self.normal[1].to_le_bytes());
        bytes
    }

    /// Inverse of [`Eas::to_bytes`]; `None` if a number is not finite.
    pub fn from_bytes(bytes: [u8; 40]) -> Option<Self> {
        let word = |i: usize| [bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2], bytes[4 * i + 3]];
        let x: [f32; 9] = core::array::from_fn(|i| f32::from_le_bytes(word(i)));
        let [a, b, c, d] = word(9);
        x.iter().all(|x| x.is_finite()).then_some(Self {
            direction: [x[0], x[1], x[2]],
            inv_distance: x[3],
            light: [x[4], x[5], x[6]],
            solid_angle: x[7],
            factor: x[8],
            normal: [i16::from_le_bytes([a, b]), i16::from_le_bytes([c, d])],
        })
    }
}

/// Which views a record was made for: the directions that a mirror in its place would show them lie in this cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewCone {
    /// Unit axis, world space.
    pub axis: [f32; 3],
    /// Half angle, radian; π and more for any view.
    pub half_angle: f32,
}

impl ViewCone {
    /// Of a record that serves any view.
    pub const ALL: Self = Self { axis: [0.0, 0.0, 1.0], half_angle: core::f32::consts::PI };
    /// Distances from the cone, in lobe widths, up to which a record is as fine as it should be, and from which it says nothing: a
    /// guide divides finely up to two widths about every mirror direction.
    pub(super) const FINE: f32 = 1.0;
    pub(super) const COARSE: f32 = 3.0;

    /// Whether it holds any view.
    #[inline]
    pub fn is_all(&self) -> bool {
        self.half_angle >= core::f32::consts::PI
    }

    /// How far a record is fine enough, from 0 to 1, for a view whose mirror direction is this.
    #[inline]
    pub fn trust(&self, mirror: Vec3A, lobe_width: f32) -> f32 {
        if self.is_all() {
            return 1.0;
        }
        let angle = Vec3A::from_array(self.axis).dot(mirror).clamp(-1.0, 1.0).acos();
        let beyond = (angle - self.half_angle) / lobe_width;
        ((Self::COARSE - beyond) / (Self::COARSE - Self::FINE)).clamp(0.0, 1.0)
    }
}

/// All sources of one point.
#[derive(Clone, Debug)]
pub struct EasRecord {
    zone: Zone,
    /// The views that it was made for.
    pub views: ViewCone,
    /// Radiance that is everywhere, taken out of the sources.
    pub background: Rgb,
    /// The sources.
    pub sources: Box<[Eas]>,
}

/// Cosines below the sine of this angle are those of a patch that turns: it is never seen thinner than the cap is wide.
#[inline(always)]
pub(super) fn softened<T: Real>(cos: T, sin_half_angle: T) -> T {
    (cos.max(cos.lit(0.0)) + sin_half_angle) * (cos.lit(1.0) + sin_half_angle).recip()
}

/// Sine of the half angle of a cap of this solid angle, 1 from a hemisphere on.
#[inline(always)]
pub(super) fn cap_sine<T: Real>(solid_angle: T) -> T {
    let height = (solid_angle * solid_angle.lit(1.0 / core::f64::consts::TAU)).min(solid_angle.lit(1.0));
    (height * (height.lit(2.0) - height)).sqrt()
}

impl EasRecord {
    /// The sources of a cut, at `position` in the world frame of the samples.
    pub fn new(position: Vec3A, frame: &Frame, material: u32, tree: &Tree, cut: &Cut, estimator: Estimator) -> Self {
        let nodes: Vec<_> = cut.nodes.iter().map(|&i| &tree.nodes()[i]).collect();
        let areas: Vec<f32> =
            nodes.iter().map(|n| projected_solid_angle(n.direction.z, (n.solid_angle / TAU).min(1.0))).collect();
        let background = match estimator {
            Estimator::Paper => Rgb::ZERO,
            Estimator::Improved => background(nodes.iter().map(|n| (n.irradiance, n.projected))),
        };
        let sources = nodes
            .iter()
            .zip(&areas)
            .map(|(node, &area)| {
                let direction = frame.to_world(node.direction);
                let facing = if node.normal == Vec3A::ZERO { -direction } else { node.normal };
                let cos_alpha = -facing.dot(direction);
                let (light, factor) = match estimator {
                    // Grazing sources would explode: the cosines are kept off zero, as any implementation must.
                    Estimator::Paper => {
                        (node.irradiance, 1.0 / (node.direction.z.max(PAPER_MIN_COS) * cos_alpha.max(PAPER_MIN_COS)))
                    }
                    Estimator::Improved => (
                        (node.irradiance - background * node.projected) / area.max(f32::MIN_POSITIVE),
                        1.0 / softened(cos_alpha, cap_sine(node.solid_angle)),
                    ),
                };
                Eas {
                    direction: direction.to_array(),
                    inv_distance: node.inv_distance,
                    light: light.to_array(),
                    solid_angle: node.solid_angle,
                    normal: pack_normal(facing),
                    factor,
                }
            })
            .collect();
        Self { zone: Zone::at(position, frame, material), views: ViewCone::ALL, background, sources }
    }

    /// A record as a file holds it.
    pub fn restored(zone: Zone, views: ViewCone, background: Rgb, sources: Box<[Eas]>) -> Self {
        Self { zone, views, background, sources }
    }

    /// Irradiance at the record, W·m⁻².
    pub fn irradiance(&self, estimator: Estimator) -> Rgb {
        let of = |s: &Eas| match estimator {
            Estimator::Paper => Rgb::from_array(s.light),
            Estimator::Improved => {
                let z = self.zone.normal.dot(Vec3A::from_array(s.direction)).max(0.0);
                Rgb::from_array(s.light) * projected_solid_angle(z, (s.solid_angle / TAU).min(1.0))
            }
        };
        self.sources.iter().map(of).sum::<Rgb>() + self.background * core::f32::consts::PI
    }
}

/// Smallest cosine that eq. 16 divides by.
const PAPER_MIN_COS: f32 = 0.01;

/// Radiance that a quarter of the projected hemisphere stays below, per channel: what light there is nearly everywhere.
///
/// Summed with the material's exact albedo instead of with caps, which do not tile the hemisphere. A low share, because
/// what is taken out of dark caps comes back as the ripple of negative ones.
fn background(caps: impl Iterator<Item = (Rgb, f32)>) -> Rgb {
    let caps: Vec<(Rgb, f32)> = caps.collect();
    let quarter = 0.25 * caps.iter().map(|c| c.1).sum::<f32>();
    let channel = |c: usize| {
        let mut sorted: Vec<(f32, f32)> = caps.iter().map(|(e, a)| (e[c] / a.max(f32::MIN_POSITIVE), *a)).collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut sum = 0.0;
        sorted
            .iter()
            .find(|(_, area)| {
                sum += area;
                sum >= quarter
            })
            .map_or(0.0, |found| found.0)
    };
    Rgb::new(channel(0), channel(1), channel(2))
}

/// Octahedral projection (Cigolle et al. 2014) to two signed 16-bit fractions.
fn pack_normal(n: Vec3A) -> [i16; 2] {
    let p = Vec2::new(n.x, n.y) / n.abs().element_sum().max(f32::MIN_POSITIVE);
    let fold = |p: Vec2| (1.0 - Vec2::new(p.y.abs(), p.x.abs())) * Vec2::ONE.copysign(p);
    let p = if n.z < 0.0 { fold(p) } else { p };
    [p.x, p.y].map(|x| (x.clamp(-1.0, 1.0) * f32::from(i16::MAX)).round() as i16)
}

/// Inverse of [`pack_normal`], from the two numbers.
#[inline(always)]
pub(super) fn unpack_normal<T: Real>(u: T, v: T) -> [T; 3] {
    let (zero, scale) = (u.lit(0.0), u.lit(1.0 / f64::from(i16::MAX)));
    let (x, y) = (u * scale, v * scale);
    let z = u.lit(1.0) - x.abs() - y.abs();
    let fold = (-z).max(zero);
    let (x, y) = (T::select(x.lt(zero), x + fold, x - fold), T::select(y.lt(zero), y + fold, y - fold));
    let inverse = (x.sq() + y.sq() + z.sq()).sqrt().recip();
    [x * inverse, y * inverse, z * inverse]
}

impl Record for EasRecord {
    fn zone(&self) -> &Zone {
        &self.zone
    }
    fn zone_mut(&mut self) -> &mut Zone {
        &mut self.zone
    }
    fn bytes(&self) -> usize {
        size_of::<Self>() + size_of_val(&*self.sources)
    }
    fn is_finite(&self) -> bool {
        let of = |s: &Eas| [s.inv_distance, s.solid_angle, s.factor].into_iter().chain(s.direction).chain(s.light);
        self.zone.is_finite() && self.background.is_finite() && self.sources.iter().all(|s| of(s).all(f32::is_finite))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_source_takes_forty_bytes() {
        assert_eq!(size_of::<Eas>(), 40);
    }

    #[test]
    fn a_cone_trusts_the_views_that_it_holds() {
        let cone = ViewCone { axis: [0.0, 0.0, 1.0], half_angle: 0.2 };
        let trust = |angle: f32| cone.trust(Vec3A::new(angle.sin(), 0.0, angle.cos()), 0.1);
        assert_eq!((trust(0.0), trust(0.29), trust(0.51), trust(3.0)), (1.0, 1.0, 0.0, 0.0));
        assert!((trust(0.4) - 0.5).abs() < 1e-3);
        assert_eq!(ViewCone::ALL.trust(-Vec3A::Z, 0.1), 1.0);
    }

    #[test]
    fn normals_survive_packing() {
        for i in 0..1000 {
            let (z, phi) = (-1.0 + 2.0 * (i as f32 + 0.5) / 1000.0, 2.4 * i as f32);
            let r = (1.0 - z * z).sqrt();
            let n = Vec3A::new(r * phi.cos(), r * phi.sin(), z);
            let [u, v] = pack_normal(n).map(f32::from);
            assert!((Vec3A::from_array(unpack_normal(u, v)) - n).length() < 1e-4, "{n}");
        }
    }

    #[test]
    fn a_background_is_what_a_quarter_stays_below() {
        let caps = [(Rgb::splat(4.0), 1.0), (Rgb::splat(1.0), 1.0), (Rgb::splat(8.0), 2.0)];
        assert_eq!(background(caps.into_iter()), Rgb::ONE);
        assert_eq!(background(core::iter::empty()), Rgb::ZERO);
    }
}
