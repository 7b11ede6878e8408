//! The shaders, compiled once for the adapter of the process.

use crate::cache::{BEHIND, NORMAL_SPREAD};
use crate::gpu::{self, Device, GpuError, Program};
use crate::record::constants::{COARSE, FINE, MAX_RATIO, MIN_LENGTH2, ROOM, TRUSTED};
use crate::record::harmonics::flat::{COSINES, MAX_BANDS, PRODUCTS, QUARTERS, pairs};
use crate::record::harmonics::{COSINE_ORDER, MAX_ORDER, SAME_NORMAL, bands_for};
use brdf_tables::wgsl::{Buffer, source};
use core::f32::consts::{PI, TAU};
use std::sync::OnceLock;

/// Threads of a group.
const THREADS: u32 = 64;
/// Groups in a row of them: how many there may be in one dimension is limited.
pub const ROW: u32 = 32768;

const COMMON: &str = include_str!("common.wgsl");
const IRRADIANCE: &str = include_str!("irradiance.wgsl");
const EAS: &str = include_str!("eas.wgsl");
const HARMONICS: &str = include_str!("harmonics.wgsl");

/// A shader that sums records of a kind.
pub struct Kernel {
    pub program: Program,
    /// Records of a tile that one run adds: a driver may take a run of seconds for one that hangs.
    pub run: u32,
    /// Surfaces that a group takes.
    pub surfaces: u32,
}

/// What the card runs.
pub struct Programs {
    pub device: &'static Device,
    pub irradiance: Kernel,
    pub eas: Kernel,
    pub harmonics: Kernel,
}

/// How many records a run adds, and how many surfaces a group takes: a thread has a surface and walks the records, or a group has a
/// surface and its threads look at a record each, few of which reach it.
const BY_THREAD: (u32, u32) = (8, THREADS);
const BY_GROUP: (u32, u32) = (THREADS, 1);

/// Records of a tile that a run of [`irradiance_shader`] adds.
pub const IRRADIANCE_RUN: u32 = BY_THREAD.0;

/// The shader that sums irradiance records over tiles of 64 surfaces a group, for whoever sets another way beside it
/// (`examples/quads`). WGSL; what it binds is said in its text.
pub fn irradiance_shader() -> String {
    filled(&[COMMON, IRRADIANCE].join("\n"), IRRADIANCE_RUN)
}

impl Programs {
    /// Those of the process.
    ///
    /// # Errors
    /// There is no adapter.
    pub fn shared() -> Result<&'static Self, GpuError> {
        static PROGRAMS: OnceLock<Programs> = OnceLock::new();
        let device = gpu::shared()?;
        let kernel = |texts: &[&str], (run, surfaces)| Kernel {
            program: device.program(&filled(&texts.join("\n"), run)),
            run,
            surfaces,
        };
        Ok(PROGRAMS.get_or_init(|| Self {
            device,
            irradiance: Kernel {
                program: device.program(&irradiance_shader()),
                run: BY_THREAD.0,
                surfaces: BY_THREAD.1,
            },
            eas: kernel(&[COMMON, EAS, &source(&Buffer::Named("tables"))], BY_THREAD),
            harmonics: kernel(&[COMMON, HARMONICS], BY_GROUP),
        }))
    }
}

impl Kernel {
    /// Groups for so many tiles, the fullest of which has so many surfaces: tiles in two dimensions, and its surfaces.
    pub fn groups(&self, tiles: usize, surfaces: u32) -> [u32; 3] {
        let tiles = tiles as u32;
        [tiles.min(ROW), tiles.div_ceil(ROW).max(1), surfaces.div_ceil(self.surfaces)]
    }
}

/// A text with the constants that it shares with the processor.
fn filled(text: &str, run: u32) -> String {
    let number = |x: f32| format!("{x:?}f");
    let whole = |x: usize| format!("{x}u");
    let constants = [
        ("ROW", format!("{ROW}u")),
        ("THREADS", format!("{THREADS}u")),
        ("RUN", format!("{run}u")),
        ("BEHIND", number(BEHIND)),
        ("OVER_SPREAD", number(1.0 / NORMAL_SPREAD)),
        ("MIN_LENGTH2", number(MIN_LENGTH2)),
        ("MAX_RATIO", number(MAX_RATIO as f32)),
        ("OVER_MAX_RATIO", number(1.0 / MAX_RATIO as f32)),
        ("COARSE", number(COARSE)),
        ("FINE", number(FINE)),
        ("ROOM", number(ROOM)),
        ("WHOLE", number(TRUSTED[0])),
        ("NONE", number(TRUSTED[1])),
        ("PI", number(PI)),
        ("TWO_PI", number(TAU)),
        ("OVER_TWO_PI", number(1.0 / TAU)),
        ("TERMS", whole(pairs(MAX_BANDS) + pairs(bands_for(COSINE_ORDER)))),
        ("LOBE", whole(pairs(MAX_BANDS))),
        ("BANDS", whole(MAX_BANDS)),
        ("MAX_ORDER", whole(MAX_ORDER)),
        ("COSINE_ORDER", whole(COSINE_ORDER)),
        ("SAME_NORMAL", number(SAME_NORMAL)),
        ("PRODUCTS", whole(PRODUCTS)),
        ("COSINE_QUARTERS", whole(QUARTERS[0])),
        ("SINE_QUARTERS", whole(QUARTERS[1])),
        ("HEMISPHERICAL_COSINE", whole(COSINES[0])),
        ("SPHERICAL_COSINE", whole(COSINES[1])),
        ("TURNING_COSINE", whole(COSINES[2])),
    ];
    constants.iter().fold(text.to_string(), |text, (key, value)| text.replace(&format!("{{{{{key}}}}}"), value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_left_to_fill_in() {
        for text in [COMMON, IRRADIANCE, EAS, HARMONICS] {
            assert!(!filled(text, 8).contains("{{"));
        }
    }
}
