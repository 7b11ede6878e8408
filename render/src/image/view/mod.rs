//! From linear light to what a screen shows: exposure, then a view transform. For formats made for display only; OpenEXR keeps the
//! light as it is.

mod agx;
mod filmic;
mod grid;

use super::{Image, from_srgb, to_srgb};
use agx::Agx;
use filmic::Filmic;
use rayon::prelude::*;

/// How light becomes what a screen shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// The light itself, cut off at 1 (sRGB curve): for measuring and for textures.
    #[default]
    Standard,
    /// Blender's default: 16.5 stops, bright colours go to white as on film.
    Agx,
    /// Blender's default before 4.0: as AgX, with more colour in bright light and hues that turn.
    Filmic,
}

/// A view transform with an exposure, ready to be applied to many pixels.
#[derive(Clone, Debug)]
pub struct Display {
    /// Factor on the light, 2^EV.
    factor: f32,
    curve: Curve,
}

#[derive(Clone, Debug)]
enum Curve {
    Standard,
    Agx(Agx),
    Filmic(Filmic),
}

impl Default for Display {
    fn default() -> Self {
        Self::STANDARD
    }
}

impl Display {
    /// [`View::Standard`] without exposure.
    pub const STANDARD: Self = Self { factor: 1.0, curve: Curve::Standard };

    /// Prepares a view of light that is brighter by `exposure` stops; AgX and Filmic tabulate their formulas.
    pub fn new(view: View, exposure: f32) -> Self {
        let curve = match view {
            View::Standard => Curve::Standard,
            View::Agx => Curve::Agx(Agx::new()),
            View::Filmic => Curve::Filmic(Filmic::new()),
        };
        Self { factor: exposure.exp2(), curve }
    }

    /// Display values, 0 … 1 with the screen's curve in them, of linear Rec. 709.
    pub fn values(&self, linear: [f32; 3]) -> [f32; 3] {
        // Far above white, and far from the end of the numbers.
        let exposed = linear.map(|x| (x * self.factor).clamp(-1e30, 1e30));
        match &self.curve {
            Curve::Standard => exposed.map(to_srgb),
            Curve::Agx(agx) => agx.display(exposed),
            Curve::Filmic(filmic) => filmic.display(exposed),
        }
    }

    /// The light that a screen sends out for a picture: what [`Display::STANDARD`] shows as this view shows the picture.
    pub fn shown(&self, image: &Image) -> Image {
        let shown = |p: &[f32; 3]| self.values(*p).map(from_srgb);
        Image { pixels: image.pixels.par_iter().map(shown).collect(), ..*image }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEWS: [View; 3] = [View::Standard, View::Agx, View::Filmic];

    /// More light is never darker, every value can be shown, and a stop is a factor of two.
    #[test]
    fn every_view_is_a_view() {
        for view in VIEWS {
            let (plain, brighter) = (Display::new(view, 0.0), Display::new(view, 1.5));
            let mut before = 0.0;
            for i in 0..400 {
                let light = 1e-6 * 1.08f32.powi(i);
                let [r, g, b] = plain.values([light; 3]);
                assert!((0.0..=1.0).contains(&r) && r >= before - 1e-6, "{view:?} {light}: {r} after {before}");
                assert!((r - g).abs() < 2e-3 && (r - b).abs() < 2e-3, "{view:?}: grey stays grey: {r} {g} {b}");
                before = r;
                let same = plain.values([light * 1.5f32.exp2(), 0.3 * 1.5f32.exp2(), 0.0]);
                let exposed = brighter.values([light, 0.3, 0.0]);
                assert!(same.iter().zip(exposed).all(|(a, b)| (a - b).abs() < 1e-5), "{view:?} {light}");
            }
            assert!(before > 0.99, "{view:?} shows white: {before}");
            for hostile in [[f32::MAX; 3], [f32::MAX, 0.0, 0.0], [-1.0, 2.0, 1e-40], [0.0; 3]] {
                for exposure in [-64.0, 0.0, 64.0] {
                    let values = Display { factor: f32::exp2(exposure), ..plain.clone() }.values(hostile);
                    assert!(values.iter().all(|x| (0.0..=1.0).contains(x)), "{view:?} {hostile:?}: {values:?}");
                }
            }
        }
    }

    const REFERENCES: [(View, [f32; 3], [f32; 3]); 14] = [
        (View::Agx, [0.18, 0.18, 0.18], [117.64, 117.63, 117.63]),
        (View::Agx, [1.0, 0.0, 0.0], [218.79, 57.16, 32.96]),
        (View::Agx, [0.0, 1.0, 0.0], [110.27, 197.02, 81.20]),
        (View::Agx, [0.0, 0.0, 1.0], [20.13, 86.08, 209.47]),
        (View::Agx, [0.8, 0.3, 0.05], [197.28, 139.93, 81.75]),
        (View::Agx, [12.0, 9.0, 4.0], [251.52, 246.06, 235.92]),
        (View::Agx, [200.0, 3.0, 0.5], [255.00, 255.00, 253.01]),
        (View::Agx, [0.0141, 0.1149, 0.1549], [9.52, 94.19, 109.10]),
        (View::Filmic, [0.18, 0.18, 0.18], [127.55, 127.55, 127.55]),
        (View::Filmic, [1.0, 0.0, 0.0], [205.85, 0.00, 0.00]),
        (View::Filmic, [0.8, 0.3, 0.05], [197.32, 152.90, 69.63]),
        (View::Filmic, [12.0, 9.0, 4.0], [253.61, 251.69, 242.10]),
        (View::Filmic, [200.0, 3.0, 0.5], [255.00, 250.36, 245.56]),
        (View::Filmic, [0.0141, 0.1149, 0.1549], [32.44, 105.53, 120.07]),
    ];

    /// What OpenColorIO makes of Blender 4.5's configuration, in 8-bit levels.
    #[test]
    fn views_are_those_of_blender() {
        for (view, linear, right) in REFERENCES {
            let found = Display::new(view, 0.0).values(linear).map(|x| 255.0 * x);
            assert!(
                found.iter().zip(right).all(|(a, b)| (a - b).abs() < 0.2),
                "{view:?} {linear:?}: {found:?} not {right:?}"
            );
        }
    }
}
