//! What the steps in lanes read and write: a column per number, a lane per path.

use super::lanes::{Column, Column3, LANES};
use crate::bsdf::{Bsdf, CoatTable, LaneFresnel, LaneLobe, Lanes};
use crate::light::{FlatLamp, LightSample, Target};
use crate::scene::{Distribution, Rgb};
use crate::world::Interaction;
use glam::Vec3A;

/// Surfaces where paths arrived. What a model lacks keeps what an earlier one left there.
#[repr(C, align(64))]
#[derive(Clone, Default)]
pub struct Surfaces<'w> {
    pub p: Column3,
    /// Normal of the geometry, and the step away from it.
    pub normal: Column3,
    pub offset: Column,
    /// Axes of the local frame.
    pub axes: [Column3; 3],
    /// To the eye, local.
    pub wo: Column3,
    pub diffuse: Column3,
    pub specular: Column3,
    /// Probability of sampling the diffuse part.
    pub p_diffuse: Column,
    /// Exponent of the cosine lobe.
    pub exponent: Column,
    /// Roughness of the facets.
    pub alpha: [Column; 2],
    /// Complex index of the metal.
    pub eta: Column3,
    pub k: Column3,
    /// Index of the coat.
    pub coat_eta: Column,
    pub tables: [Option<&'w CoatTable>; LANES],
    /// Which lanes have what, by bit.
    pub cosine: u32,
    pub facets: u32,
    pub beckmann: u32,
    pub coats: u32,
}

/// Light for the surfaces: a place on a flat lamp that is yet to be found, or a direction.
#[repr(C, align(64))]
#[derive(Clone, Default)]
pub struct Light {
    /// Number of the flat lamp of which the next columns are, plus one.
    known: [u32; LANES],
    pub p0: Column3,
    pub e1: Column3,
    pub e2: Column3,
    pub normal: Column3,
    pub area: Column,
    pub lamp_clearance: Column,
    pub lamp_radiance: Column3,
    /// Which lamps are parallelograms, by bit.
    pub square: u32,
    pub probability: Column,
    /// Which lanes have a lamp, and which a direction, by bit.
    pub lamps: u32,
    pub samples: u32,
    /// Of the directions.
    pub wi: Column3,
    pub target: Column3,
    pub clearance: Column,
    pub radiance: Column3,
    pub pdf: Column,
    /// Which have a target, and which are met in no other way, by bit.
    pub points: u32,
    pub deltas: u32,
}

/// What comes of it.
#[repr(C, align(64))]
#[derive(Clone, Default)]
pub struct Scattered {
    /// Light reflected if it is in sight, throughput aside, by part.
    pub reflected: [Column3; 2],
    /// The shadow ray.
    pub shadow_origin: Column3,
    pub shadow_direction: Column3,
    pub shadow_end: Column,
    /// The sampled direction, the origin of the ray that leaves in it, its density, f_r cos / density by part.
    pub wi: Column3,
    pub origin: Column3,
    pub pdf: Column,
    pub weight: [Column3; 2],
    /// Which lanes have light that may be in sight, and which a sampled direction, by bit.
    pub lit: u32,
    pub sampled: u32,
}

/// Writes a vector to a lane.
#[inline(always)]
fn put(column: &mut Column3, lane: usize, v: Vec3A) {
    (column[0][lane], column[1][lane], column[2][lane]) = (v.x, v.y, v.z);
}

/// The vector of a lane.
#[inline(always)]
pub fn get(column: &Column3, lane: usize) -> Vec3A {
    Vec3A::new(column[0][lane], column[1][lane], column[2][lane])
}

impl<'w> Surfaces<'w> {
    /// Forgets which lanes have what.
    #[inline(always)]
    pub fn clear(&mut self) {
        (self.cosine, self.facets, self.beckmann, self.coats) = (0, 0, 0, 0);
    }

    /// A surface whose scattering is computed in lanes.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, at: &Interaction, bsdf: &Bsdf, model: &Lanes<'w>) {
        put(&mut self.p, lane, at.p);
        put(&mut self.normal, lane, at.normal);
        self.offset[lane] = at.offset;
        for (column, axis) in self.axes.iter_mut().zip(bsdf.frame().axes()) {
            put(column, lane, axis);
        }
        put(&mut self.wo, lane, bsdf.wo());
        put(&mut self.diffuse, lane, model.diffuse);
        self.p_diffuse[lane] = model.p_diffuse;
        put(&mut self.specular, lane, model.specular);
        match &model.lobe {
            LaneLobe::None => {}
            LaneLobe::Cosine(exponent) => {
                self.exponent[lane] = *exponent;
                self.cosine |= 1 << lane;
            }
            LaneLobe::Facets(facets, fresnel) => {
                (self.alpha[0][lane], self.alpha[1][lane]) = facets.alpha().into();
                self.facets |= 1 << lane;
                self.beckmann |= u32::from(facets.distribution() == Distribution::Beckmann) << lane;
                match *fresnel {
                    LaneFresnel::Conductor { eta, k } => {
                        put(&mut self.eta, lane, eta);
                        put(&mut self.k, lane, k);
                    }
                    LaneFresnel::Coat { eta, table } => {
                        self.coat_eta[lane] = eta;
                        self.tables[lane] = Some(table);
                        self.coats |= 1 << lane;
                    }
                }
            }
        }
    }
}

impl Light {
    /// Forgets what an earlier step left, lamps aside.
    #[inline(always)]
    pub fn clear(&mut self) {
        (self.lamps, self.samples, self.points, self.deltas) = (0, 0, 0, 0);
    }

    /// A lamp, of which a lane may know the columns from an earlier step.
    #[inline(always)]
    pub fn set_lamp(
        &mut self,
        lane: usize,
        index: usize,
        probability: f32,
        lamp: impl FnOnce() -> Option<FlatLamp>,
    ) -> bool {
        if self.known[lane] != index as u32 + 1 {
            let Some(lamp) = lamp() else { return false };
            self.known[lane] = index as u32 + 1;
            put(&mut self.p0, lane, lamp.p0);
            put(&mut self.e1, lane, lamp.e1);
            put(&mut self.e2, lane, lamp.e2);
            put(&mut self.normal, lane, lamp.normal);
            put(&mut self.lamp_radiance, lane, lamp.radiance);
            (self.area[lane], self.lamp_clearance[lane]) = (lamp.area, lamp.clearance);
            self.square = self.square & !(1 << lane) | u32::from(lamp.square) << lane;
        }
        self.probability[lane] = probability;
        self.lamps |= 1 << lane;
        true
    }

    /// A direction.
    #[inline(always)]
    pub fn set_sample(&mut self, lane: usize, sample: &LightSample) {
        let (point, target, clearance) = match sample.target {
            Target::Point { p, clearance } => (true, p, clearance),
            Target::Direction(d) => (false, d, 0.0),
        };
        put(&mut self.wi, lane, sample.wi);
        put(&mut self.target, lane, target);
        put(&mut self.radiance, lane, sample.radiance);
        (self.clearance[lane], self.pdf[lane]) = (clearance, sample.pdf);
        self.samples |= 1 << lane;
        self.points |= u32::from(point) << lane;
        self.deltas |= u32::from(sample.delta) << lane;
    }
}

/// A colour of two parts of a lane.
#[inline(always)]
pub fn split(columns: &[Column3; 2], lane: usize) -> crate::bsdf::Split {
    let [diffuse, glossy]: [Rgb; 2] = [get(&columns[0], lane), get(&columns[1], lane)];
    crate::bsdf::Split { diffuse, glossy }
}
