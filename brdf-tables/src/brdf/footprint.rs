//! Where the lobe of a model lies, and how wide it is, in the (a, q) coordinates of the cubature ([`crate::cubature`]).

use glam::{DVec2, DVec3};

/// Extent of a specular lobe seen from `wo`, in the frame of `wo`: centred at the meridian a₀ with width `width_a`; on the
/// meridian a, with X = sin a − sin a₀ and H = h0 + h1 cos a, centred at q = tilt · X with width² = k0 H² + k1 X².
#[derive(Clone, Copy, Debug)]
pub struct Footprint {
    /// sinθo.
    pub sin_o: f64,
    /// cosθo.
    pub cos_o: f64,
    /// sin a₀.
    pub sin_peak: f64,
    /// cos a₀.
    pub cos_peak: f64,
    /// Width in a, radian.
    pub width_a: f64,
    /// Slope of the ridge of a tilted (anisotropic) lobe.
    pub tilt: f64,
    /// Width in q at the peak, squared and divided by H².
    pub k0: f64,
    /// Growth of that width along the lobe (heavy tails), squared.
    pub k1: f64,
    /// Constant part of H.
    pub h0: f64,
    /// Cosine part of H.
    pub h1: f64,
}

/// Width of the rational map over the width of the lobe, the best measured at orders 4 to 8: cosine powers, Gaussian
/// slopes, and the long tails of GGX.
const COSINE: f64 = 4.0;
const GAUSSIAN: f64 = 3.0;
const LONG_TAIL: f64 = 2.0;

/// A direction to the eye in its own frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outgoing {
    /// sinθo.
    pub sin_o: f64,
    /// cosθo.
    pub cos_o: f64,
    /// Cosine and sine of the azimuth.
    pub rotation: (f64, f64),
}

impl Outgoing {
    pub fn new(wo: DVec3) -> Self {
        let sin_o = wo.truncate().length();
        let rotation = if sin_o > 1e-9 { (wo.x / sin_o, wo.y / sin_o) } else { (1.0, 0.0) };
        Self { sin_o, cos_o: wo.z, rotation }
    }
}

impl Footprint {
    /// cosⁿ about the in-plane vector `peak` (not normalised): e^(−n δ²/2), equally wide both ways.
    pub(crate) fn cosine(view: &Outgoing, peak: DVec2, exponent: f64) -> Self {
        let Outgoing { sin_o, cos_o, .. } = *view;
        let peak = peak.try_normalize().unwrap_or(DVec2::Y);
        let width = COSINE * (2.0 / exponent.max(1.0)).sqrt();
        Self {
            sin_o,
            cos_o,
            sin_peak: peak.x,
            cos_peak: peak.y,
            width_a: width,
            tilt: 0.0,
            k0: width * width,
            k1: 0.0,
            h0: 1.0,
            h1: 0.0,
        }
    }

    /// A distribution of half-vector slopes s = (wi + wo)_xy / (wi + wo)_z of roughness αx, αy, turned into the frame of
    /// `wo`: along the meridian a, s_x H = X and s_y H = q with H = cos a + cosθo, and D depends on
    /// Qxx s_x² + 2 Qxy s_x s_y + Qyy s_y².
    pub(crate) fn slopes(view: &Outgoing, alpha_x: f64, alpha_y: f64, long_tail: bool) -> Self {
        let Outgoing { sin_o, cos_o, rotation: (c, s) } = *view;
        let (ix, iy) = (alpha_x.powi(-2), alpha_y.powi(-2));
        let (qxx, qyy) = (c * c * ix + s * s * iy, s * s * ix + c * c * iy);
        let qxy = c * s * (iy - ix);
        let marginal = qxx - qxy * qxy / qyy;
        let scale = if long_tail { LONG_TAIL } else { GAUSSIAN };
        Self {
            sin_o,
            cos_o,
            sin_peak: -sin_o,
            cos_peak: cos_o,
            width_a: 2.0 * scale / marginal.sqrt(),
            tilt: -qxy / qyy,
            k0: scale * scale / qyy,
            k1: if long_tail { scale * scale * marginal / qyy } else { 0.0 },
            h0: cos_o,
            h1: 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::{ALL, Brdf, Specular};
    use crate::frame::spherical;

    /// The footprint is centred on the maximum of the lobe along the plane of incidence, where there is one, and about as
    /// wide as the lobe.
    #[test]
    fn centre_and_width_follow_the_lobe() {
        let narrow = |s: &Specular| s.lobe_width() < 0.2 && !matches!(s, Specular::Lafortune(_));
        for specular in ALL.iter().flat_map(|m| (m.examples)()).filter(narrow) {
            for phi in [0.0, 0.5 * core::f64::consts::PI] {
                let wo = spherical(0.5, phi);
                let (lobe, (c, s)) = specular.footprint(wo);
                let at = |a: f64| {
                    let (sin, cos) = a.sin_cos();
                    specular.eval(DVec3::new(sin * c, sin * s, cos), wo)
                };
                let centre = lobe.sin_peak.atan2(lobe.cos_peak);
                let top = (-400..400).map(|i| at(centre + 0.002 * f64::from(i))).fold(0.0, f64::max);
                assert!(at(centre) > 0.7 * top, "{specular:?}: {} of {top} at the centre", at(centre));
                let (inside, outside) = (at(centre + 0.1 * lobe.width_a), at(centre + 1.5 * lobe.width_a));
                assert!(inside > 0.5 * top && outside < 0.1 * top, "{specular:?}: {inside} {outside} of {top}");
            }
        }
    }
}
