//! A record of incident radiance.

use super::projection::Projector;
use super::{Basis, HarmonicsSettings, MAX_ORDER};
use crate::frame::Frame;
use crate::hemisphere::GatherSample;
use crate::record::{Record, Zone};
use crate::scene::Rgb;
use glam::Vec3A;

/// Incident radiance at a point, as coefficients.
#[derive(Clone, Debug)]
pub struct HarmonicsRecord {
    zone: Zone,
    /// Axes x and y of the frame, whose z is the normal of the zone.
    tangents: [Vec3A; 2],
    /// Order n.
    order: u8,
    /// Red, green, blue, n² numbers each; then their derivatives along the axes x and y of the frame.
    numbers: Box<[f32]>,
}

impl HarmonicsRecord {
    /// Projects the samples of a gather at `position` over the hemisphere of `frame`, to order `order`. The radius is that of
    /// the zone of influence.
    pub fn new(
        position: Vec3A,
        frame: &Frame,
        radius: f32,
        material: u32,
        samples: &[GatherSample],
        order: usize,
        settings: &HarmonicsSettings,
    ) -> Self {
        let order = order.clamp(1, MAX_ORDER);
        let projector = Projector { basis: settings.basis, order, gradients: settings.gradients };
        let numbers = projector.project(samples, frame, radius);
        let zone = Zone { radius, ..Zone::at(position, frame, material) };
        Self { zone, tangents: tangents(frame), order: order as u8, numbers }
    }

    /// A record as a file holds it, `tangents` the axes x and y of its frame; `None` if the count of the numbers is none of a
    /// record.
    pub fn restored(zone: Zone, tangents: [Vec3A; 2], order: u32, numbers: Box<[f32]>) -> Option<Self> {
        let size = (order as usize).checked_mul(order as usize)?;
        let fits = (1..=MAX_ORDER as u32).contains(&order) && (numbers.len() == 3 * size || numbers.len() == 9 * size);
        fits.then_some(Self { zone, tangents, order: order as u8, numbers })
    }

    /// Order n of the coefficients.
    pub fn order(&self) -> usize {
        self.order.into()
    }

    /// The frame of the coefficients (hemispherical basis) and of the gradients.
    #[inline(always)]
    pub fn frame(&self) -> Frame {
        let [x, y] = self.tangents;
        Frame::from_axes(x, y, self.zone.normal)
    }

    /// All coefficients, as they are stored.
    pub fn numbers(&self) -> &[f32] {
        &self.numbers
    }

    /// Coefficients of channel `c` at a point `offset` away, dotted with those of a function: first order in the offset, along
    /// the tangent plane (eq. 12 within eq. 13).
    #[inline(always)]
    fn dot(&self, channel: usize, offset: Vec3A, function: &[f32]) -> f32 {
        let size = self.order() * self.order();
        let used = size.min(function.len());
        let place = |vector: usize| vector * size..vector * size + used;
        let function = &function[..used];
        let value = dot(&self.numbers[place(channel)], function);
        if self.numbers.len() == 3 * size {
            return value;
        }
        let along_x = dot(&self.numbers[place(3 + channel)], function);
        let along_y = dot(&self.numbers[place(6 + channel)], function);
        value + offset.x * along_x + offset.y * along_y
    }

    /// All channels of [`Self::dot`].
    #[inline(always)]
    pub(super) fn dots(&self, offset: Vec3A, function: &[f32]) -> Rgb {
        Rgb::new(self.dot(0, offset, function), self.dot(1, offset, function), self.dot(2, offset, function))
    }

    /// Radiance from a world direction, RGB, for tests and pictures.
    pub fn radiance(&self, basis: Basis, direction: Vec3A) -> Rgb {
        let local = if basis == Basis::Spherical { direction } else { self.frame().to_local(direction) };
        let values = basis.values(self.order(), local);
        self.dots(Vec3A::ZERO, &values)
    }
}

fn tangents(frame: &Frame) -> [Vec3A; 2] {
    let [x, y, _] = frame.axes();
    [x, y]
}

/// Σ ab with as many running sums as a vector has lanes, twice.
#[inline(always)]
fn dot(a: &[f32], b: &[f32]) -> f32 {
    const LANES: usize = 16;
    let mut sums = [0f32; LANES];
    let (chunks_a, chunks_b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f32 = chunks_a.remainder().iter().zip(chunks_b.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in chunks_a.zip(chunks_b) {
        for i in 0..LANES {
            sums[i] += x[i] * y[i];
        }
    }
    sums.iter().sum::<f32>() + rest
}

impl Record for HarmonicsRecord {
    fn zone(&self) -> &Zone {
        &self.zone
    }
    fn zone_mut(&mut self) -> &mut Zone {
        &mut self.zone
    }
    fn bytes(&self) -> usize {
        size_of::<Self>() + size_of_val(&*self.numbers)
    }
    fn is_finite(&self) -> bool {
        self.zone.is_finite()
            && self.tangents.iter().all(|t| t.is_finite())
            && self.numbers.iter().all(|x| x.is_finite())
    }
}
