//! AgX, Blender's default view ("AgX Base sRGB" of its OpenColorIO configuration, look "None"), from its published formula.
//!
//! Formed after Troy Sobotka's AgX by Zijun Eary Zhou; the scripts that made Blender's tables are at
//! <https://github.com/EaryChow/AgX_LUT_Gen>. In order:
//!
//! 1. Rec. 709 to FilmLight's E-gamut, whose logarithms the table is read by ([`Grid`], 57³);
//! 2. from there to Rec. 2020; colours outside of it are brought inside ([`Guard`]);
//! 3. the *inset* matrix, which moves and turns the primaries towards white, so that bright colours come to white;
//! 4. per channel: log₂ from 10 stops below middle grey to 6.5 above, a sigmoid, power 2.4;
//! 5. the hue (HSV) is 0.4 of that way from the hue before 4;
//! 6. the *outset* matrix, which gives some of the chroma back;
//! 7. Rec. 709, colours outside of it brought inside again, the sRGB curve.
//!
//! At the 57³ samples this differs from Blender's table by less than 0.001 of an 8-bit level; since it is read between
//! them as there, pictures are Blender's to rounding. `tests/peers/blender_views.py` measures it.

use super::grid::{GREY, Grid};
use crate::image::to_srgb;
use glam::{DMat3, DVec3, dmat3, dvec3};

/// Samples along an edge of Blender's table.
const SIZE: usize = 57;

/// Exponent that the table's values are stored with.
const ENCODING: f64 = 2.4;

/// Share of the change of hue by the curve that is kept.
const HUE_SHIFT: f64 = 0.4;

/// A matrix by rows.
const fn rows(r: [f64; 3], g: [f64; 3], b: [f64; 3]) -> DMat3 {
    dmat3(dvec3(r[0], g[0], b[0]), dvec3(r[1], g[1], b[1]), dvec3(r[2], g[2], b[2]))
}

/// XYZ (D65) to Rec. 709, as Blender's configuration rounds it for the light that comes in …
const XYZ_TO_LINEAR: DMat3 = rows(
    [3.240_437_356_492_007, -1.537_130_540_900_055, -0.498_528_824_075_693_3],
    [-0.969_267_498_268_759_7, 1.876_013_686_297_703_5, 0.041_556_080_458_799_7],
    [0.055_643_446_387_425_6, -0.204_025_970_087_227_2, 1.057_225_481_361_086_4],
);

/// … and as the scripts round it for the picture that goes out.
const XYZ_TO_REC_709: DMat3 = rows(
    [3.241_003_232_976_358_7, -1.537_398_969_488_785_5, -0.498_615_881_996_362_9],
    [-0.969_224_252_202_516_4, 1.875_929_983_695_176, 0.041_554_226_340_084_7],
    [0.055_639_419_851_975_5, -0.204_011_206_123_909_9, 1.057_148_977_187_533_3],
);

const XYZ_TO_REC_2020: DMat3 = rows(
    [1.716_663_427_795_880_5, -0.355_673_319_730_139_9, -0.253_368_087_890_247_8],
    [-0.666_673_836_198_886_9, 1.616_455_739_824_698_1, 0.015_768_297_096_133_7],
    [0.017_642_481_784_977_2, -0.042_776_976_382_753_2, 0.942_243_281_018_430_8],
);

const E_GAMUT_TO_XYZ: DMat3 = rows(
    [0.705_396_850_1, 0.164_041_328_3, 0.081_017_748_65],
    [0.280_130_724_1, 0.820_206_641_5, -0.100_337_365_6],
    [-0.103_781_511_6, -0.072_907_257_03, 1.265_746_519],
);

/// Primaries moved towards white by 0.33, 0.28, 0.12 and turned by 2.1°, −1.2°, −3.1°.
const INSET: DMat3 = rows(
    [0.856_627_153_315_983, 0.095_121_240_538_158_8, 0.048_251_606_145_858_3],
    [0.137_318_972_929_847, 0.761_241_990_602_591, 0.101_439_036_467_562],
    [0.111_898_212_999_95, 0.076_799_418_603_190_3, 0.811_302_368_396_859],
);

/// The inverse of moving them by 0.32, 0.28, 0.04 without a turn.
const OUTSET: DMat3 = rows(
    [1.127_100_581_814_436_9, -0.110_606_643_096_603_21, -0.016_493_938_717_834_25],
    [-0.141_329_763_498_438_3, 1.157_823_702_163_272_3, -0.016_493_938_717_834_27],
    [-0.141_329_763_498_438_26, -0.110_606_643_096_603_23, 1.251_936_406_595_040_5],
);

/// Luminance of the primaries of Rec. 2020, by the CIE's functions of 2015.
const LUMINANCE: DVec3 = dvec3(0.265_818_037_025_044_9, 0.598_469_860_453_65, 0.135_712_102_521_305_2);

/// The view, ready to be read.
#[derive(Clone, Debug)]
pub(super) struct Agx {
    to_e_gamut: glam::Mat3,
    grid: Grid,
}

impl Agx {
    /// Tabulates the formula: some hundredths of a second.
    pub fn new() -> Self {
        let to_e_gamut = E_GAMUT_TO_XYZ.inverse() * XYZ_TO_LINEAR.inverse();
        let formation = Formation::new();
        let encoded = |c: [f64; 3]| (formation.at(c.into()).map(|x| x.powf(1.0 / ENCODING))).to_array();
        Self { to_e_gamut: to_e_gamut.as_mat3(), grid: Grid::new(SIZE, encoded) }
    }

    /// The display value, 0 … 1, of linear Rec. 709.
    pub fn display(&self, linear: [f32; 3]) -> [f32; 3] {
        let stored = self.grid.at((self.to_e_gamut * glam::Vec3::from(linear)).to_array());
        stored.map(|x| to_srgb(x.powf(ENCODING as f32)))
    }
}

/// Steps 2 to 7 but for the last curve.
struct Formation {
    to_rec_2020: DMat3,
    to_rec_709: DMat3,
    wide: Guard,
    narrow: Guard,
    sigmoid: Sigmoid,
}

impl Formation {
    fn new() -> Self {
        let to_rec_709 = XYZ_TO_REC_709 * XYZ_TO_REC_2020.inverse();
        Self {
            to_rec_2020: XYZ_TO_REC_2020 * E_GAMUT_TO_XYZ,
            to_rec_709,
            wide: Guard { luminance: LUMINANCE, small_only: false },
            narrow: Guard { luminance: to_rec_709.inverse().transpose() * LUMINANCE, small_only: true },
            sigmoid: Sigmoid::new(),
        }
    }

    /// Linear light on the display, 0 … 1, of linear E-gamut.
    fn at(&self, linear: DVec3) -> DVec3 {
        let inset = INSET * self.wide.inside(self.to_rec_2020 * linear);
        let formed = inset.map(|x| self.sigmoid.at(x).powf(ENCODING));
        let (before, [after, saturation, value]) = (hsv(inset)[0], hsv(formed));
        // The shorter way around.
        let way = (after - before + 0.5).rem_euclid(1.0) - 0.5;
        let hue = (before + HUE_SHIFT * way).rem_euclid(1.0);
        let colour = OUTSET * rgb([hue, saturation, value]);
        self.narrow.inside(self.to_rec_709 * colour).clamp(DVec3::ZERO, DVec3::ONE)
    }
}

/// Brings colours with negative channels inside: adds white until none is left, and dims what became brighter by that.
/// Brightness is luminance plus what the opponent colour lacks of its own largest channel, since luminance alone may be
/// negative. By Sakari Kapanen.
struct Guard {
    luminance: DVec3,
    /// Whether luminance alone counts where it is not small.
    small_only: bool,
}

impl Guard {
    fn brightness(&self, c: DVec3) -> f64 {
        let opponent = c.max_element() - c;
        let luminance = self.luminance.dot(c);
        let all = opponent.max_element() - self.luminance.dot(opponent) + luminance;
        if self.small_only { all + (luminance - all) * luminance.max(0.0).powf(0.08).min(1.0) } else { all }
    }

    fn inside(&self, c: DVec3) -> DVec3 {
        let lifted = c - c.min_element().min(0.0);
        let (before, after) = (self.brightness(c), self.brightness(lifted));
        if after > before { lifted * (before / after) } else { lifted }
    }
}

/// Jed Smith's sigmoid in Sobotka's form, y = s·t/(1 + t^p)^(1/p) + y₀ with t = m (x − x₀)/s: slope m = 2.4 through the pivot
/// (x₀, y₀), middle grey; p = 1.5; s such that it passes through (0, 0) below and (1, 1) above.
struct Sigmoid {
    pivot: [f64; 2],
    toe: f64,
    shoulder: f64,
}

impl Sigmoid {
    const LOWEST: f64 = -10.0;
    const HIGHEST: f64 = 6.5;
    const SLOPE: f64 = 2.4;
    const POWER: f64 = 1.5;

    fn new() -> Self {
        let pivot = [-Self::LOWEST / (Self::HIGHEST - Self::LOWEST), GREY.powf(1.0 / ENCODING)];
        // From s·t/(1 + t^p)^(1/p) = h at x − x₀ = w, where t = m w/s.
        let scale = |w: f64, h: f64| {
            let (p, rise) = (Self::POWER, Self::SLOPE * w);
            (rise.powf(-p) * ((rise / h).powf(p) - 1.0)).powf(-1.0 / p)
        };
        Self { pivot, toe: scale(pivot[0], pivot[1]), shoulder: scale(1.0 - pivot[0], 1.0 - pivot[1]) }
    }

    /// The curve at a linear channel; it goes on above 1.
    fn at(&self, linear: f64) -> f64 {
        let stops = (linear.max(f64::MIN_POSITIVE) / GREY).log2();
        let x = (stops - Self::LOWEST) / (Self::HIGHEST - Self::LOWEST);
        // The toe is a shoulder turned about the pivot.
        let scale = if x < self.pivot[0] { -self.toe } else { self.shoulder };
        let t = (Self::SLOPE * (x - self.pivot[0]) / scale).max(0.0);
        (scale * t / (1.0 + t.powf(Self::POWER)).powf(1.0 / Self::POWER) + self.pivot[1]).max(0.0)
    }
}

/// Hue, saturation and value of Smith (1978), hue 0 … 1.
fn hsv(c: DVec3) -> [f64; 3] {
    let (value, range) = (c.max_element(), c.max_element() - c.min_element());
    if range <= 0.0 || value <= 0.0 {
        return [0.0, 0.0, value];
    }
    let sixths = if value == c.x {
        ((c.y - c.z) / range).rem_euclid(6.0)
    } else if value == c.y {
        (c.z - c.x) / range + 2.0
    } else {
        (c.x - c.y) / range + 4.0
    };
    [sixths / 6.0, range / value, value]
}

/// The inverse of [`hsv`].
fn rgb([hue, saturation, value]: [f64; 3]) -> DVec3 {
    let channel = |start: f64| {
        let k = (start + 6.0 * hue).rem_euclid(6.0);
        value - value * saturation * k.min(4.0 - k).clamp(0.0, 1.0)
    };
    dvec3(channel(5.0), channel(3.0), channel(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hue_saturation_value_have_an_inverse() {
        for c in [dvec3(0.2, 0.5, 0.1), dvec3(0.9, 0.1, 0.4), dvec3(0.3, 0.3, 0.3), dvec3(0.0, 0.2, 0.7), DVec3::ZERO] {
            assert!((rgb(hsv(c)) - c).abs().max_element() < 1e-12, "{c}");
        }
    }

    /// Middle grey is the pivot of the curve, and greys stay grey: 0.18 comes out as 0.18, black as black, and 6.5 stops
    /// above as white.
    #[test]
    fn greys_follow_the_curve() {
        let agx = Agx::new();
        for (stops, right) in [(0.0, 0.18), (6.5, 1.0), (9.0, 1.0), (-12.0, 0.0)] {
            let [r, g, b] = agx.display([0.18 * f32::exp2(stops); 3]);
            assert!(
                (r - to_srgb(right)).abs() < 2e-3 && (r - g).abs() < 1e-3 && (r - b).abs() < 1e-3,
                "{stops} {r} {g} {b}"
            );
        }
    }

    #[test]
    fn the_curve_passes_its_ends_with_its_slope() {
        let sigmoid = Sigmoid::new();
        let at = |x: f64| sigmoid.at(GREY * (Sigmoid::LOWEST + x * (Sigmoid::HIGHEST - Sigmoid::LOWEST)).exp2());
        assert!(at(0.0).abs() < 1e-12 && (at(1.0) - 1.0).abs() < 1e-12);
        let [x, y] = sigmoid.pivot;
        assert!((at(x) - y).abs() < 1e-12 && ((at(x + 1e-6) - at(x - 1e-6)) / 2e-6 - 2.4).abs() < 1e-2);
    }
}
