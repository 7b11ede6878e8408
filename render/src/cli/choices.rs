//! Choices of the library by name: what `--help` lists, and what may be typed.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use render::image::Part;
use render::image::view::View;
use render::integrator::cached::Interpolation;
use render::record::eas::Estimator;
use render::record::harmonics::{Basis, Gradients};

/// A name, what it stands for, and what `--help` says of it.
pub(super) type Choice<T> = (&'static str, T, &'static str);

/// How EAS are moved and summed.
pub(super) const ESTIMATORS: [Choice<Estimator>; 2] = [
    ("paper", Estimator::Paper, "As published in 2015: E′ and Ω′ of eq. 16, Ward's weights"),
    (
        "improved",
        Estimator::Improved,
        "Irradiance of clipped caps, bounded foreshortening, background plus residual, smooth weights",
    ),
];

/// Which harmonics.
pub(super) const BASES: [Choice<Basis>; 2] = [
    (
        "hemispherical",
        Basis::Hemispherical,
        "Hemispherical harmonics in the frame of the record: Legendre functions of 2cosθ − 1",
    ),
    (
        "spherical",
        Basis::Spherical,
        "Spherical harmonics in the frame of the world, of light that is zero below the horizon (Křivánek 2005, §6.2)",
    ),
];

/// How harmonic records change with position.
pub(super) const GRADIENTS: [Choice<Gradients>; 3] = [
    ("analytic", Gradients::Analytic, "By differentiating every term of the projection (§4.3.2)"),
    ("numerical", Gradients::Numerical, "By projecting every sample again from a displaced point (§4.3.1)"),
    ("none", Gradients::None, "None are stored: records are a third as large"),
];

/// Who sums the records of a pixel.
pub(super) const INTERPOLATIONS: &[Choice<Interpolation>] = &[
    ("auto", Interpolation::Auto, "Whoever is faster"),
    ("octree", Interpolation::Octree, "Pixels look for records, in an octree"),
    ("splat", Interpolation::Splat, "Records are drawn onto the tiles of pixels that they reach (Gautron 2005)"),
    #[cfg(feature = "gpu")]
    ("gpu", Interpolation::Gpu, "The same, summed on the graphics card (Vulkan)"),
];

/// How a screen shows light.
pub(super) const VIEWS: [Choice<View>; 3] = [
    ("standard", View::Standard, "The light itself, cut off at 1 (sRGB curve): for measuring and for textures"),
    ("agx", View::Agx, "Blender's default: 16.5 stops, bright colours go to white as on film"),
    (
        "filmic",
        View::Filmic,
        "Blender's default before 4.0: as AgX, with more colour in bright light and hues that turn",
    ),
];

/// Layers of an EXR.
pub(super) const PARTS: [Choice<Option<Part>>; 9] = [
    (Part::Noisy.name(), Some(Part::Noisy), "The picture before it was denoised"),
    (
        Part::Variance.name(),
        Some(Part::Variance),
        "Variance of its pixels, from 17 samples on: `render compare --z-test`",
    ),
    (Part::Emission.name(), Some(Part::Emission), "Light that comes straight from lamps and the sky"),
    (Part::Direct.name(), Some(Part::Direct), "Light that was scattered once, diffuse and glossy"),
    (Part::Indirect.name(), Some(Part::Indirect), "Light that was scattered more often, diffuse and glossy"),
    (Part::Albedo.name(), Some(Part::Albedo), "Reflectance, as mirrors and clear glass show it"),
    (Part::Normal.name(), Some(Part::Normal), "Shading normal, likewise"),
    (Part::Depth.name(), Some(Part::Depth), "Depth along the camera's axis"),
    ("none", None, "The picture alone"),
];

/// A parser of one of the choices.
pub(super) fn choices<T: Copy + Send + Sync + 'static>(all: &'static [Choice<T>]) -> impl TypedValueParser<Value = T> {
    let values = all.iter().map(|(name, _, help)| PossibleValue::new(*name).help(*help));
    PossibleValuesParser::new(values).try_map(|typed| {
        let found = all.iter().find(|(name, ..)| *name == typed);
        found.map(|(_, value, _)| *value).ok_or("not one of the choices")
    })
}
