//! What a pixel shows, for denoisers: the first surface that is not perfectly specular, as mirrors and clear glass show it.

use crate::bsdf::Bsdf;
use crate::picture::Radiance;
use crate::scene::Rgb;
use crate::world::Interaction;

/// A surface behind perfectly specular ones of the colour `through`.
#[inline]
pub(super) fn show(out: &mut Radiance, at: &Interaction, bsdf: &Bsdf, through: Rgb) {
    let n = bsdf.normal();
    out.albedo = bsdf.albedo() * through;
    out.normal = if n.dot(at.wo) < 0.0 { -n } else { n };
}

/// Light that a mirror shows, of infinity: it has no albedo, and its edges are those of its colour.
#[inline]
pub(super) fn show_light(out: &mut Radiance, light: Rgb) {
    out.albedo = light.min(Rgb::ONE);
}
