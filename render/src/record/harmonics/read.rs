//! What records reflect at a point: the dot product of eq. 13, with the BRDF turned into the frame of each record.

use super::basis::{Basis, PACKED, legendre, multiples, row};
use super::brdf::{HarmonicBrdf, Outgoing};
use super::conversion::{bands_for, to_hemisphere, to_sphere};
use super::projection::{Sum, compact};
use super::rotation::{Rotation, about_z};
use super::{HarmonicsRecord, MAX_ORDER};
use crate::frame::Frame;
use crate::record::{Receiver, Record, Reflected};
use brdf_tables::gauss::gauss_legendre;
use core::f64::consts::{PI, SQRT_2};
use glam::{Mat3A, Vec2, Vec3A};
use std::sync::OnceLock;

/// The functions of a point and view, in the frame of the record read last. Memory to be used again from point to point.
#[derive(Debug)]
pub struct Reader {
    basis: Basis,
    order: usize,
    /// Frame of the point, turned so that the eye has azimuth zero where the material is isotropic.
    frame: Frame,
    lobe: Box<Sum>,
    /// The lobe in spherical harmonics, once a record with another normal asks for it.
    sphere: Option<Box<Sum>>,
    /// Frame that the next two are for.
    ready: Option<Frame>,
    specular: Vec<f32>,
    cosine: [f32; COSINE_ORDER * COSINE_ORDER],
}

/// Bands of the cosine of the Lambertian part: in the hemispherical basis two hold it, but for turned normals.
pub(crate) const COSINE_ORDER: usize = 8;

/// Cosine between normals from which on they count as one: 0.15°.
pub(crate) const SAME_NORMAL: f32 = 1.0 - 3.5e-6;

impl Default for Reader {
    fn default() -> Self {
        Self {
            basis: Basis::Hemispherical,
            order: 0,
            frame: Frame::from_normal(Vec3A::Z),
            lobe: Box::new([[0.0; PACKED]; 2]),
            sphere: None,
            ready: None,
            specular: Vec::with_capacity(MAX_ORDER * MAX_ORDER),
            cosine: [0.0; COSINE_ORDER * COSINE_ORDER],
        }
    }
}

impl Reader {
    /// Looks at a point.
    #[inline(always)]
    pub fn look(&mut self, brdf: &HarmonicBrdf, at: &Receiver) -> Outgoing {
        let (outgoing, turn) = brdf.lobe(at.wo, &mut self.lobe);
        self.frame = turned(at, turn);
        (self.basis, self.order, self.sphere, self.ready) = (brdf.basis, outgoing.order, None, None);
        outgoing
    }

    /// Reflected light of a record at `position`. Ringing may make it negative.
    #[inline(always)]
    pub fn read(&mut self, record: &HarmonicsRecord, position: Vec3A) -> Reflected {
        let frame = record.frame();
        match self.basis {
            Basis::Spherical if self.ready.is_none() => self.turn_to_world(),
            Basis::Spherical => (),
            Basis::Hemispherical if self.ready != Some(frame) => self.turn_to_record(&frame),
            Basis::Hemispherical => (),
        }
        let offset = frame.to_local(position - record.position());
        Reflected {
            irradiance: record.dots(offset, &self.cosine),
            specular: record.dots(offset, &self.specular),
            trust: 1.0,
        }
    }

    /// Functions in the frame of the world.
    #[inline(always)]
    fn turn_to_world(&mut self) {
        let [x, y, z] = [Vec3A::X, Vec3A::Y, Vec3A::Z].map(|v| self.frame.to_world(v));
        let rotation = Rotation::new(Mat3A::from_cols(x, y, z));
        rotation.apply(self.order, &mut self.lobe);
        let mut cosine = constants().spherical;
        rotation.apply(COSINE_ORDER, &mut cosine);
        self.ready = Some(self.frame);
        let lobe = *self.lobe;
        self.store(&lobe, &cosine);
    }

    /// Functions in the frame of a record.
    #[inline(always)]
    fn turn_to_record(&mut self, frame: &Frame) {
        let [x, y, z] = [Vec3A::X, Vec3A::Y, Vec3A::Z].map(|v| frame.to_local(self.frame.to_world(v)));
        self.ready = Some(*frame);
        if z.z >= SAME_NORMAL {
            let turn = Vec2::new(x.x, x.y).normalize_or(Vec2::X);
            let mut lobe = *self.lobe;
            about_z(self.order, &mut lobe, &multiples(turn.x, turn.y));
            self.store(&lobe, &constants().hemispherical);
            return;
        }
        let rotation = Rotation::new(Mat3A::from_cols(x, y, z));
        let (order, lobe) = (self.order, &self.lobe);
        let mut sphere = **self.sphere.get_or_insert_with(|| Box::new(to_sphere(order, lobe)));
        rotation.apply(bands_for(order), &mut sphere);
        let mut cosine = constants().turning;
        rotation.apply(bands_for(COSINE_ORDER), &mut cosine);
        let (lobe, cosine) = (to_hemisphere(order, &sphere), to_hemisphere(COSINE_ORDER, &cosine));
        self.store(&lobe, &cosine);
    }

    #[inline(always)]
    fn store(&mut self, lobe: &Sum, cosine: &Sum) {
        self.specular.resize(self.order * self.order, 0.0);
        compact(self.order, lobe, &mut self.specular);
        compact(COSINE_ORDER, cosine, &mut self.cosine);
    }
}

/// The frame of a point, turned about its normal.
#[inline(always)]
fn turned(at: &Receiver, turn: Vec2) -> Frame {
    Frame::with_tangent(at.frame.normal(), at.frame.to_world(Vec3A::new(turn.x, turn.y, 0.0)))
}

/// The frame of the function that a BRDF has at a point and view.
#[cfg(feature = "gpu")]
pub(crate) fn frame_of(brdf: &HarmonicBrdf, at: &Receiver) -> Frame {
    turned(at, brdf.turn(at.wo))
}

/// cosθ over the upper hemisphere, 0 below.
struct Constants {
    hemispherical: Sum,
    spherical: Sum,
    /// In the bands that a hemispherical function is turned by.
    turning: Sum,
}

/// The cosine in hemispherical functions, in spherical ones, and in those that a hemispherical function is turned by.
#[cfg(feature = "gpu")]
pub(super) fn cosines() -> [&'static Sum; 3] {
    let Constants { hemispherical, spherical, turning } = constants();
    [hemispherical, spherical, turning]
}

fn constants() -> &'static Constants {
    static CONSTANTS: OnceLock<Constants> = OnceLock::new();
    CONSTANTS.get_or_init(|| {
        let zonal = |value: &dyn Fn(usize, f64) -> f64, bands: usize| {
            let mut sum = [[0f32; PACKED]; 2];
            for l in 0..bands {
                let integral = gauss_legendre(64).into_iter().map(|(x, weight)| {
                    let z = 0.5 * (x + 1.0);
                    0.5 * weight * 2.0 * PI * z * value(l, z)
                });
                sum[0][row(l)] = integral.sum::<f64>() as f32;
            }
            sum
        };
        let spherical = |l: usize, z: f64| legendre(l, 0, z);
        Constants {
            hemispherical: zonal(&|l, z| SQRT_2 * legendre(l, 0, 2.0 * z - 1.0), COSINE_ORDER),
            spherical: zonal(&spherical, COSINE_ORDER),
            turning: zonal(&spherical, bands_for(COSINE_ORDER)),
        }
    })
}
