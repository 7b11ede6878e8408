//! What a cached rendering did.

use super::caches::Caches;
use super::kind::KindFigures;
use super::kinds::PerKind;
use std::time::Duration;

/// What a cached rendering did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Time to fill the caches.
    pub fill: Duration,
    /// Time from there to the picture.
    pub shade: Duration,
    /// The part of it for the indirect light of surfaces, from records and paths.
    pub indirect: Duration,
    /// Glossy records, by kind.
    pub glossy: PerKind<KindFigures>,
    /// Irradiance records, coarse ones included.
    pub irradiance_records: usize,
    /// Pixels whose indirect light is negative in some channel: ringing.
    pub negative_pixels: u64,
    /// As [`Shading::card_failed`].
    pub card_failed: bool,
    /// Bytes of all records.
    pub bytes: usize,
    /// τ in force.
    pub tolerance: f32,
}

/// What is told of the last pass over the pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shading {
    /// Pixels whose indirect light is negative in some channel.
    pub negative_pixels: u64,
    /// Time for the indirect light of all surfaces.
    pub indirect: Duration,
    /// Whether the graphics card was to sum records and failed: then the processor summed them.
    pub card_failed: bool,
}

impl Figures {
    /// Those of records; times and pixels are not known yet.
    pub(super) fn of(caches: &Caches, tolerance: f32) -> Self {
        Self {
            glossy: caches.glossy.figures(),
            irradiance_records: caches.irradiance.records().len() + caches.coarse.records().len(),
            bytes: caches.bytes(),
            tolerance,
            ..Self::default()
        }
    }

    /// Glossy records of all kinds together.
    pub fn all_glossy(&self) -> KindFigures {
        self.glossy.iter().copied().sum()
    }

    /// Records of all kinds.
    pub fn records(&self) -> usize {
        self.all_glossy().records + self.irradiance_records
    }
}
