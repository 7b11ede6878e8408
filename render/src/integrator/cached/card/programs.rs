//! The shaders, compiled once for the adapter of the process.

use crate::cache::{BEHIND, NORMAL_SPREAD};
use crate::gpu::{self, Device, GpuError, Program};
use crate::record::constants::{COARSE, FINE, MAX_RATIO, MIN_LENGTH2, ROOM, TRUSTED};
use brdf_tables::wgsl::{Buffer, source};
use core::f32::consts::{PI, TAU};
use std::sync::OnceLock;

/// Threads of a group, which share a tile.
const THREADS: u32 = 64;
/// Records of a tile that one run adds: a driver may take a run of seconds for one that hangs.
pub const RUN: u32 = 8;
/// Groups in a row of them: how many there may be in one dimension is limited.
pub const ROW: u32 = 32768;

const COMMON: &str = include_str!("common.wgsl");
const IRRADIANCE: &str = include_str!("irradiance.wgsl");
const EAS: &str = include_str!("eas.wgsl");

/// What the card runs.
pub struct Programs {
    pub device: &'static Device,
    pub irradiance: Program,
    pub eas: Program,
}

impl Programs {
    /// Those of the process.
    ///
    /// # Errors
    /// There is no adapter.
    pub fn shared() -> Result<&'static Self, GpuError> {
        static PROGRAMS: OnceLock<Programs> = OnceLock::new();
        let device = gpu::shared()?;
        Ok(PROGRAMS.get_or_init(|| Self {
            device,
            irradiance: device.program(&filled(&[COMMON, IRRADIANCE].join("\n"))),
            eas: device.program(&filled(&[COMMON, EAS, &source(&Buffer::Named("tables"))].join("\n"))),
        }))
    }
}

/// Groups for so many tiles, the fullest of which has so many surfaces: tiles in two dimensions, and its surfaces.
pub fn groups(tiles: usize, surfaces: u32) -> [u32; 3] {
    let tiles = tiles as u32;
    [tiles.min(ROW), tiles.div_ceil(ROW).max(1), surfaces.div_ceil(THREADS)]
}

/// A text with the constants that it shares with the processor.
fn filled(text: &str) -> String {
    let number = |x: f32| format!("{x:?}f");
    let constants = [
        ("ROW", format!("{ROW}u")),
        ("THREADS", format!("{THREADS}u")),
        ("RUN", format!("{RUN}u")),
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
    ];
    constants.iter().fold(text.to_string(), |text, (key, value)| text.replace(&format!("{{{{{key}}}}}"), value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_left_to_fill_in() {
        for text in [COMMON, IRRADIANCE, EAS] {
            assert!(!filled(text).contains("{{"));
        }
    }
}
