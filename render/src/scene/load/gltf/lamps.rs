//! Punctual lights of glTF, and the units that exporters write them in.

use super::Builder;
use crate::scene::load::Options;
use crate::scene::load::error::FileError;
use crate::scene::load::framing::{bounds, corners, outline};
use crate::scene::{Falloff, Light, Rgb};
use core::f32::consts::PI;
use glam::{DAffine3, Vec3, Vec3A};
use gltf::khr_lights_punctual::{self as punctual, Kind};

/// Blender's exporter multiplies radiometric by this to get photometric units, lm/W.
const LUMENS_PER_WATT: f32 = 683.0;

/// In which units the lamps of a glTF file are: the lighting modes of Blender's exporter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightUnits {
    /// "Standard": candela and lux, at 683 lm/W.
    Standard,
    /// "Unitless": W·sr⁻¹ and, of suns, W·m⁻².
    Unitless,
    /// "Raw (Deprecated)": the numbers typed in Blender, W and, of suns, W·m⁻².
    Raw,
}

impl LightUnits {
    /// Factor on the intensity that a file states, to W·sr⁻¹ or W·m⁻².
    fn factor(self, kind: &Kind) -> f32 {
        match (self, kind) {
            (Self::Standard, _) => 1.0 / LUMENS_PER_WATT,
            (Self::Raw, Kind::Point | Kind::Spot { .. }) => 0.25 / PI,
            (Self::Unitless | Self::Raw, _) => 1.0,
        }
    }

    /// The units of a file, and whether they were guessed from its numbers. Blender does not say which mode it wrote, but
    /// people type round numbers: where all lamps are round in one mode, and not in the standard one, that is it.
    pub(super) fn of(document: &gltf::Document, blender: bool) -> (Self, bool) {
        let lights: Vec<_> = document.lights().into_iter().flatten().collect();
        let typed = |units: Self, light: &punctual::Light| {
            let watts = if matches!(light.kind(), Kind::Directional) { 1.0 } else { 4.0 * core::f64::consts::PI };
            match units {
                Self::Standard => f64::from(light.intensity()) * watts / f64::from(LUMENS_PER_WATT),
                Self::Unitless => f64::from(light.intensity()) * watts,
                Self::Raw => light.intensity().into(),
            }
        };
        let fits = |units| lights.iter().all(|light| is_round(typed(units, light)));
        if !blender || lights.is_empty() || fits(Self::Standard) {
            return (Self::Standard, false);
        }
        // Of suns alone both are the same.
        let suns = lights.iter().all(|light| matches!(light.kind(), Kind::Directional));
        match (fits(Self::Unitless), fits(Self::Raw)) {
            (false, true) => (Self::Raw, true),
            (true, raw) if !raw || suns => (Self::Unitless, true),
            _ => (Self::Standard, false),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Standard => "Standard",
            Self::Unitless => "Unitless",
            Self::Raw => "Raw",
        }
    }
}

/// Whether a number has at most three digits that count, up to the precision of single floats.
fn is_round(x: f64) -> bool {
    let digits = x.abs() / 10f64.powf(x.abs().log10().floor() - 2.0);
    x == 0.0 || (digits - digits.round()).abs() < 2e-6 * digits
}

impl Builder<'_> {
    pub(super) fn light(&mut self, light: &punctual::Light, to_world: DAffine3) -> Result<(), FileError> {
        let strength = Rgb::from(light.color()) * light.intensity() * self.units.factor(&light.kind());
        if !strength.is_finite() || strength.min_element() < 0.0 {
            return Err(self.data.error(format_args!("light {}: colour and intensity must be ≥ 0", light.index())));
        }
        let position = to_world.translation.as_vec3a();
        let direction = || -> Result<Vec3A, FileError> {
            let z = (-to_world.matrix3.z_axis).try_normalize();
            Ok(z.ok_or_else(|| self.data.error(format_args!("light {}: no direction", light.index())))?.as_vec3a())
        };
        let light = match light.kind() {
            Kind::Point => Light::Point { position, intensity: strength },
            Kind::Directional => Light::Directional { direction: direction()?, irradiance: strength },
            Kind::Spot { inner_cone_angle: inner, outer_cone_angle: cutoff } => {
                if !(0.0 <= inner && inner <= cutoff && cutoff <= PI) {
                    return Err(self
                        .data
                        .error(format_args!("light {}: cones of {inner} and {cutoff}", light.index())));
                }
                let (beam, falloff) =
                    if self.blender { (beam(inner, cutoff), Falloff::Smooth) } else { (inner, Falloff::Cosine) };
                Light::Spot { position, direction: direction()?, intensity: strength, beam, cutoff, falloff }
            }
        };
        self.scene.lights.push(light);
        Ok(())
    }

    /// Warns where the numbers of the lamps are clearly of other units than those they are read in: where the brightest
    /// leaves what is nearest to it dark, or even what is farthest from it far too bright.
    pub(super) fn judge_lamps(&mut self, guessed: bool, options: &Options) {
        let (name, given) = (self.units.name(), options.light_units.is_some());
        if guessed && !given {
            let what = format!(
                "the strengths of its lamps are round numbers in Blender's lighting mode \"{name}\", and not in \
                 \"Standard\": they are read so; --light-units overrides it"
            );
            self.warn(what);
        }
        let scene = &self.scene;
        let Some((low, high)) = bounds(scene).filter(|_| !scene.lights.is_empty()) else { return };
        let (mut count, mut nearest) = (0usize, vec![f32::INFINITY; scene.lights.len()]);
        outline(scene, |_| count += 1);
        // So many are enough to tell orders of magnitude.
        let step = count.saturating_mul(scene.lights.len()) / 1_000_000 + 1;
        let mut i = 0;
        outline(scene, |p| {
            if i % step == 0 {
                let pairs = scene.lights.iter().zip(&mut nearest);
                pairs.for_each(|(light, near)| *near = near.min(distance2(light, p)));
            }
            i += 1;
        });
        let far = |light| corners(low, high).map(|p| distance2(light, p)).fold(0.0, f32::max);
        let farthest: Vec<f32> = scene.lights.iter().map(far).collect();
        let most = |squares: &[f32]| {
            scene.lights.iter().zip(squares).map(|(light, d2)| strength(light) / d2).fold(0.0, f32::max)
        };
        let (least, most) = (most(&farthest), most(&nearest));
        let lamps_alone = options.environment.is_none() && scene.shapes.iter().all(|s| s.emitter.is_none());
        let what = match () {
            () if most > 0.0 && most < DARK && lamps_alone => {
                format!("at most about {most:.1e} W/m²: the picture is far too dark")
            }
            () if least > BRIGHT => format!("at least {least:.1e} W/m²: the picture is far too bright"),
            () => return,
        };
        let how = if given { "as --light-units says" } else { "as Blender writes them" };
        let what = format!(
            "its lamps, read in the units \"{name}\" {how}, give {what}; another of --light-units may be right"
        );
        self.warn(what);
    }
}

/// Irradiance in W·m⁻² below which a lit surface looks black, and above which no exposure meant for 1 shows it; far from
/// what lamps are meant to give, as a floor of two triangles is nearer to its lamp than its vertices are.
const DARK: f32 = 0.01;
const BRIGHT: f32 = 300.0;

fn strength(light: &Light) -> f32 {
    match light {
        Light::Point { intensity, .. } | Light::Spot { intensity, .. } => intensity.max_element(),
        Light::Directional { irradiance, .. } => irradiance.max_element(),
    }
}

/// The square of the distance to a lamp; 1 for suns.
fn distance2(light: &Light, p: Vec3) -> f32 {
    match light {
        Light::Point { position, .. } | Light::Spot { position, .. } => position.distance_squared(p.into()),
        Light::Directional { .. } => 1.0,
    }
}

/// Blender states the blend of a spot as an inner angle, (1 − blend) · cutoff, but means it as a share of 1 − cos:
/// the half angle of full intensity.
fn beam(inner: f32, cutoff: f32) -> f32 {
    let (inner, cutoff) = (f64::from(inner), f64::from(cutoff));
    let blend = if cutoff > 0.0 { 1.0 - inner / cutoff } else { 0.0 };
    // 1 − cos x is 2 sin² ½x.
    let half = (1.0 - blend).sqrt() * (0.5 * cutoff).sin();
    ((2.0 * half.min(1.0).asin()) as f32).min(cutoff as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_people_type() {
        for typed in [0.0, 1.0, 0.1f32, 100.0, 1250.0, 0.075, 1e6, 3.15] {
            assert!(is_round(typed.into()), "{typed}");
            assert!(typed == 0.0 || !is_round(f64::from(typed * 683.0 * 0.25 / PI)), "{typed}");
        }
        assert!(is_round(f64::from((54351.41306588226f64 / 683.0 * 4.0 * core::f64::consts::PI) as f32)));
        assert!(!is_round(123.456) && !is_round(f64::NAN) && !is_round(f64::INFINITY));
    }

    #[test]
    fn blend_is_a_share_of_the_cone() {
        let cutoff = 0.5f32;
        for blend in [0.0, 0.15, 0.5, 1.0f32] {
            let beam = beam((1.0 - blend) * cutoff, cutoff);
            let expected = cutoff.cos() + (1.0 - cutoff.cos()) * blend;
            assert!((beam.cos() - expected).abs() < 1e-6, "{blend}");
        }
        assert_eq!(beam(0.0, 0.0), 0.0);
    }
}
