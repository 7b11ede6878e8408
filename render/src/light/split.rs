//! Light from infinity in two parts: a dim one, which records can hold, and what exceeds it, which is sampled directly.

use super::Lights;
use super::environment::MapSampler;
use crate::scene::{Bitmap, Environment, EnvironmentMap, Rgb, Texels};
use core::f64::consts::PI;

/// A texel may exceed the mean of the map by this factor and still belong to the dim part: the hemispheres of records
/// sample it well.
const BRIGHT: f32 = 6.0;

impl Environment {
    /// The dim part and the rest; both add up to the environment exactly.
    pub fn split(&self) -> (Self, Option<Self>) {
        let Self::Map(map) = self else { return (self.clone(), None) };
        let limit = BRIGHT * map.mean_brightness();
        let share = |c: Rgb| if c.max_element() > limit { limit / c.max_element() } else { 1.0 };
        let texels = &map.image.texels;
        let part = |of: &dyn Fn(Rgb) -> Rgb| {
            let texels = Texels::Rgb((0..texels.len()).map(|i| of(texels.get(i)).to_array()).collect());
            EnvironmentMap { image: Bitmap { texels, ..map.image.clone() }, ..map.clone() }
        };
        let any_bright = (0..texels.len()).any(|i| share(texels.get(i)) < 1.0);
        let rest = any_bright.then(|| Self::Map(part(&|c| c * (1.0 - share(c)))));
        (Self::Map(part(&|c| c * share(c))), rest)
    }

    /// Radiance from the unit direction `d`.
    #[inline]
    pub fn radiance(&self, d: glam::Vec3A) -> Rgb {
        match self {
            Self::Constant(radiance) => *radiance,
            Self::Map(map) => map.radiance(d),
        }
    }
}

impl EnvironmentMap {
    /// Mean of the largest channel over the sphere, before `scale`.
    fn mean_brightness(&self) -> f32 {
        let (w, h) = (self.image.width as usize, self.image.height as usize);
        let (mut sum, mut weights) = (0.0, 0.0);
        for y in 0..h {
            let sine = (PI * y as f64 / (h - 1).max(1) as f64).sin().max(1e-6);
            for x in 0..w {
                sum += sine * f64::from(self.image.texels.get(y * w + x).max_element());
                weights += sine;
            }
        }
        (sum / weights) as f32
    }
}

impl Lights {
    /// The same lights under another environment.
    pub fn with_environment(&self, environment: Option<Environment>) -> Self {
        let environment = environment.map(|e| {
            let sampler = match &e {
                Environment::Constant(_) => None,
                Environment::Map(map) => Some(MapSampler::new(map)),
            };
            (e, sampler)
        });
        Self { environment, ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Rows;
    use glam::{Affine2, Mat3A, Vec3A};

    #[test]
    fn the_parts_add_up_and_the_dim_one_is_dim() {
        let texels = Texels::Rgb((0..32).map(|i| if i == 13 { [100.0, 50.0, 0.0] } else { [0.5, 1.0, 0.2] }).collect());
        let (wrap, interpolation, second_uv) = Default::default();
        let image = Bitmap { width: 8, height: 4, texels, wrap, interpolation, second_uv, to_uv: Affine2::IDENTITY };
        let whole =
            Environment::Map(EnvironmentMap { image, to_world: Mat3A::IDENTITY, scale: 2.0, rows: Rows::Poles });
        let (dim, rest) = whole.split();
        let rest = rest.unwrap();
        for i in 0..200 {
            let (z, phi) = (-1.0 + (i as f32 + 0.5) / 100.0, 2.4 * i as f32);
            let r = (1.0 - z * z).sqrt();
            let d = Vec3A::new(r * phi.cos(), r * phi.sin(), z);
            assert!((dim.radiance(d) + rest.radiance(d) - whole.radiance(d)).abs().max_element() < 1e-3);
            assert!(dim.radiance(d).max_element() < 120.0);
        }
        let plain = Environment::Constant(Rgb::ONE);
        assert_eq!(plain.split(), (plain.clone(), None));
    }
}
