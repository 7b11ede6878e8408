//! `.openpbr`: parameters of the opaque part of OpenPBR 1.1 (Academy Software Foundation 2024), by the names of its specification:
//! base (diffuse and metal), specular, coat and fuzz. Keys that are left out have the specification's defaults.
//!
//! - Diffuse: the energy-preserving model of Oren and Nayar's kind (Portsmouth, Kutz and Hill 2025, "EON").
//! - Facets: GGX of α = roughness², which scatter once; a dielectric by Fresnel's equations, its index changed by
//!   `specular_weight`, and a metal by Schlick's formula with the tint at 82° (Kutz, Hasan and Edmondson 2021).
//! - Layers: an upper one of albedo E leaves (1 − E(i)) (1 − E(o)) / (1 − Ē) of the diffuse light below, and that of what is
//!   glossy below as well: reciprocal, and white layers on white lose nothing.
//! - Fuzz: the fibres of Estevez and Kulla in place of the fitted lobe of Zeltner et al., which asks for their tables.

use super::fits::{Key, found};
use super::shape::dielectric;
use super::{Format, ReadError, Reading, Source};
use crate::brdf::{Brdf, Distribution, Fresnel, Microfacet, Sheen};
use core::f64::consts::{FRAC_1_PI, PI};
use glam::{DVec2, DVec3};

const KEYS: [Key; 15] = [
    Key("base_weight", 0.0, 1.0, false),
    Key("base_color", 0.0, 1.0, true),
    Key("base_diffuse_roughness", 0.0, 1.0, false),
    Key("base_metalness", 0.0, 1.0, false),
    Key("specular_weight", 0.0, 1.0, false),
    Key("specular_color", 0.0, 1.0, true),
    Key("specular_roughness", 0.0, 1.0, false),
    Key("specular_ior", 1.0, 3.0, false),
    Key("coat_weight", 0.0, 1.0, false),
    Key("coat_color", 0.0, 1.0, true),
    Key("coat_roughness", 0.0, 1.0, false),
    Key("coat_ior", 1.0, 3.0, false),
    Key("fuzz_weight", 0.0, 1.0, false),
    Key("fuzz_color", 0.0, 1.0, true),
    Key("fuzz_roughness", 0.0, 1.0, false),
];
const DEFAULTS: [f64; 15] = [1.0, 0.8, 0.0, 0.0, 1.0, 1.0, 0.3, 1.5, 0.0, 1.0, 0.0, 1.6, 0.0, 1.0, 0.5];

/// Smallest α of facets: a lattice of values holds no sharper ones.
const LEAST_ALPHA: f64 = 0.02;
/// That of fibres, as their recipe has it.
const LEAST_FUZZ: f64 = 0.07;

/// Reads the bytes of a file.
pub(super) fn read(bytes: &[u8]) -> Result<Reading, ReadError> {
    let found = found(bytes, &KEYS)?;
    let numbers: [[f64; 3]; 15] = core::array::from_fn(|k| found[k].unwrap_or([DEFAULTS[k]; 3]));
    let mut notes = vec!["OpenPBR: base, specular, coat and fuzz, by its parameters; facets scatter once".to_string()];
    let [roughness, coat, coat_roughness, fuzz] = [6, 8, 10, 12].map(|k: usize| numbers[k][0]);
    if roughness.powi(2) < LEAST_ALPHA || coat > 0.0 && coat_roughness.powi(2) < LEAST_ALPHA {
        notes.push(
            "facets of a roughness below 0.141 are taken with that: values on a lattice hold no sharper ones".into(),
        );
    }
    if fuzz > 0.0 {
        notes.push("fuzz: fibres of Estevez and Kulla, with α the square of its roughness, at least 0.07".into());
    }
    Ok(Reading { format: Format::OpenPbr, source: Box::new(Surface::new(&numbers)), notes })
}

/// Albedo of a layer by the cosine of the view, and its mean over a cosine-weighted hemisphere.
struct Layer {
    albedo: [f64; Self::NODES],
    mean: f64,
}

impl Layer {
    /// Nodes at cosines from 0 to 1.
    const NODES: usize = 32;
    /// Points a side of the rule over the samples of a view.
    const SIDE: usize = 20;

    /// Of a lobe with its sampling, times a reflectance at the cosine to the half vector.
    fn new(lobe: &impl Brdf, reflectance: impl Fn(f64) -> f64) -> Self {
        let node = |i: usize| {
            let cos = (i as f64 / (Self::NODES - 1) as f64).max(1e-3);
            let wo = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            let mut sum = 0.0;
            for k in 0..Self::SIDE * Self::SIDE {
                let u = (DVec2::new((k % Self::SIDE) as f64, (k / Self::SIDE) as f64) + 0.5) / Self::SIDE as f64;
                let Some(wi) = lobe.sample(wo, u).filter(|wi| wi.z > 0.0) else { continue };
                let density = lobe.pdf(wi, wo);
                if density > 0.0 {
                    sum += lobe.eval(wi, wo) * wi.z / density * reflectance((0.5 * (wi + wo).length()).min(1.0));
                }
            }
            (sum / (Self::SIDE * Self::SIDE) as f64).min(1.0)
        };
        let albedo: [f64; Self::NODES] = core::array::from_fn(node);
        // ∫ 2 c E dc of what is linear between the nodes.
        let h = 1.0 / (Self::NODES - 1) as f64;
        let part = |i: usize| {
            let (c, a, b) = ((i - 1) as f64 * h, albedo[i - 1], albedo[i]);
            h * (c * (a + b) + h * (a + 2.0 * b) / 3.0)
        };
        Self { albedo, mean: (1..Self::NODES).map(part).sum() }
    }

    fn at(&self, cos: f64) -> f64 {
        let x = cos.clamp(0.0, 1.0) * (Self::NODES - 1) as f64;
        let i = (x as usize).min(Self::NODES - 2);
        self.albedo[i] + (self.albedo[i + 1] - self.albedo[i]) * (x - i as f64)
    }

    /// What it leaves of diffuse light below, for the cosines of both directions.
    fn below(&self, cos_i: f64, cos_o: f64) -> f64 {
        (1.0 - self.at(cos_i)) * (1.0 - self.at(cos_o)) / (1.0 - self.mean).max(1e-3)
    }
}

struct Surface {
    /// Of the diffuse part: roughness and albedo.
    roughness: f64,
    diffuse: [f64; 3],
    metalness: f64,
    specular_weight: f64,
    specular_color: [f64; 3],
    metal: [f64; 3],
    /// Index of the dielectric, with its weight in it.
    index: f64,
    facets: Microfacet,
    specular: Layer,
    coat: Option<Coat>,
    fuzz: Option<Fuzz>,
}

struct Coat {
    weight: f64,
    color: [f64; 3],
    index: f64,
    facets: Microfacet,
    layer: Layer,
}

struct Fuzz {
    weight: f64,
    color: [f64; 3],
    fibres: Sheen,
    layer: Layer,
}

fn facets(roughness: f64) -> Microfacet {
    let alpha = (roughness * roughness).max(LEAST_ALPHA);
    Microfacet { distribution: Distribution::Ggx, alpha_x: alpha, alpha_y: alpha, fresnel: Fresnel::None }
}

impl Surface {
    fn new(numbers: &[[f64; 3]; 15]) -> Self {
        let one = |k: usize| numbers[k][0];
        let base = numbers[1].map(|c| c * one(0));
        // specular_weight scales the reflectance at normal incidence through the index.
        let normal = one(4) * ((one(7) - 1.0) / (one(7) + 1.0)).powi(2);
        let index = (1.0 + normal.sqrt()) / (1.0 - normal.sqrt());
        let lobe = facets(one(6));
        let coat = (one(8) > 0.0).then(|| {
            let (index, facets) = (one(11), facets(one(10)));
            let layer = Layer::new(&facets, |cos| dielectric(cos, index));
            Coat { weight: one(8), color: numbers[9], index, facets, layer }
        });
        let fuzz = (one(12) > 0.0).then(|| {
            let fibres = Sheen { alpha: (one(14) * one(14)).max(LEAST_FUZZ) };
            Fuzz { weight: one(12), color: numbers[13], fibres, layer: Layer::new(&fibres, |_| 1.0) }
        });
        Self {
            roughness: one(2),
            diffuse: base,
            metalness: one(3),
            specular_weight: one(4),
            specular_color: numbers[5],
            metal: base,
            index,
            facets: lobe,
            specular: Layer::new(&lobe, |cos| dielectric(cos, index)),
            coat,
            fuzz,
        }
    }

    /// The diffuse model of Portsmouth, Kutz and Hill for an albedo.
    fn oren_nayar(&self, albedo: f64, wi: DVec3, wo: DVec3) -> f64 {
        let r = self.roughness;
        let share = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * r);
        let s = wi.dot(wo) - wi.z * wo.z;
        let s = if s > 0.0 { s / wi.z.max(wo.z).max(1e-6) } else { s };
        let once = albedo * share * (1.0 + r * s);
        let reflected = |cos: f64| {
            let cos = cos.clamp(1e-6, 1.0);
            let sin = (1.0 - cos * cos).sqrt();
            let g = sin * (cos.acos() - sin * cos) + 2.0 / 3.0 * (sin / cos * (1.0 - sin.powi(3)) - sin);
            share * (1.0 + r * g * FRAC_1_PI)
        };
        let mean = share * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * r);
        let further = albedo * albedo * mean / (1.0 - albedo * (1.0 - mean)).max(1e-6);
        let again = further * (1.0 - reflected(wi.z)).max(0.0) * (1.0 - reflected(wo.z)).max(0.0);
        FRAC_1_PI * (once + again / (1.0 - mean).max(1e-7))
    }

    /// Reflectance of the metal: that of Schlick, less what the tint at 82° takes.
    fn tinted(&self, cos: f64, c: usize) -> f64 {
        const EDGE: f64 = 1.0 / 7.0;
        let schlick = |cos: f64| self.metal[c] + (1.0 - self.metal[c]) * (1.0 - cos).powi(5);
        let taken = schlick(EDGE) * (1.0 - self.specular_color[c]) / (EDGE * (1.0 - EDGE).powi(6));
        self.specular_weight * (schlick(cos) - taken * cos * (1.0 - cos).powi(6)).max(0.0)
    }
}

impl Source for Surface {
    fn rgb(&self, wi: DVec3, wo: DVec3) -> Option<[f64; 3]> {
        let cos = (0.5 * (wi + wo).length()).min(1.0);
        let (lobe, reflectance) = (self.facets.eval(wi, wo), dielectric(cos, self.index));
        let below = self.specular.below(wi.z, wo.z);
        let mut rgb: [f64; 3] = core::array::from_fn(|c| {
            let plastic =
                self.specular_color[c] * reflectance * lobe + below * self.oren_nayar(self.diffuse[c], wi, wo);
            (1.0 - self.metalness) * plastic + self.metalness * self.tinted(cos, c) * lobe
        });
        if let Some(coat) = &self.coat {
            let (own, below) = (dielectric(cos, coat.index) * coat.facets.eval(wi, wo), coat.layer.below(wi.z, wo.z));
            for (f, color) in rgb.iter_mut().zip(coat.color) {
                *f += coat.weight * (own + (below * color - 1.0) * *f);
            }
        }
        if let Some(fuzz) = &self.fuzz {
            let (own, below) = (fuzz.fibres.eval(wi, wo), fuzz.layer.below(wi.z, wo.z));
            for (f, color) in rgb.iter_mut().zip(fuzz.color) {
                *f += fuzz.weight * (own * color + (below - 1.0) * *f);
            }
        }
        Some(rgb)
    }

    fn is_folded(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::spherical;

    fn source(text: &str) -> Box<dyn Source> {
        read(text.as_bytes()).unwrap().source
    }

    /// ∫ f cos dω over the hemisphere, by the midpoint rule in cosine and azimuth.
    fn albedo(source: &dyn Source, theta: f64) -> [f64; 3] {
        let (rows, columns) = (400, 200);
        let mut sum = [0.0; 3];
        for i in 0..rows {
            let cos = (f64::from(i) + 0.5) / f64::from(rows);
            for k in 0..columns {
                let wi = spherical(cos.acos(), PI * (f64::from(k) + 0.5) / f64::from(columns));
                let rgb = source.rgb(wi, spherical(theta, 0.0)).unwrap();
                (0..3).for_each(|c| sum[c] += rgb[c] * cos * 2.0 * PI / f64::from(rows * columns));
            }
        }
        sum
    }

    /// A Lambertian base, a rough white one, and layers on white keep the light that the specification says.
    #[test]
    fn energy_is_kept() {
        let lambert = source("specular_weight 0\nbase_color .2 .4 .6\n");
        let (wi, wo) = (spherical(0.9, 0.3), spherical(0.4, 2.0));
        assert!((lambert.rgb(wi, wo).unwrap()[1] - 0.4 / PI).abs() < 1e-9);
        for (text, tolerance) in [
            ("specular_weight 0\nbase_color 1\nbase_diffuse_roughness 1\n", 2e-3),
            ("base_color 1\nspecular_roughness .6\n", 0.01),
            (
                "base_color 1\nspecular_roughness .6\nbase_diffuse_roughness .7\nfuzz_weight .5\nfuzz_roughness .7\n",
                0.04,
            ),
        ] {
            let source = source(text);
            for theta in [0.0, 0.7, 1.3] {
                let found = albedo(source.as_ref(), theta);
                assert!((found[0] - 1.0).abs() < tolerance, "{text} {theta}: {found:?}");
            }
        }
        let all = source("base_color .9 .5 .1\nbase_metalness .5\ncoat_weight 1\ncoat_roughness .5\nfuzz_weight 1\n");
        for theta in [0.0, 0.9, 1.4] {
            let found = albedo(all.as_ref(), theta);
            assert!(found.iter().all(|x| (0.0..=1.01).contains(x)), "{theta}: {found:?}");
        }
        let exchanged = all.rgb(wo, wi).unwrap();
        let here = all.rgb(wi, wo).unwrap();
        assert!((0..3).all(|c| (here[c] / exchanged[c] - 1.0).abs() < 1e-9));
    }

    /// Closed forms at normal incidence: D = 1/π α², F that of the index or of the metal.
    #[test]
    fn closed_forms() {
        let at = |text: &str| source(text).rgb(DVec3::Z, DVec3::Z).unwrap();
        let d = 1.0 / (PI * 0.25f64.powi(2));
        let plastic = at("base_color 0\nspecular_roughness .5\nspecular_color 1 .5 0\n");
        assert!((plastic[0] - 0.04 * d / 4.0).abs() < 1e-6 && (plastic[1] - 0.02 * d / 4.0).abs() < 1e-6);
        let weak = at("base_color 0\nspecular_roughness .5\nspecular_weight .25\n");
        assert!((weak[0] - 0.01 * d / 4.0).abs() < 1e-6);
        let metal = at("base_color .9 .6 .3\nbase_metalness 1\nspecular_roughness .5\n");
        assert!((metal[1] - 0.6 * d / 4.0).abs() < 1e-6);
        // The tint of the edge is what is left at a cosine of 1/7.
        let gold = Surface::new(&{
            let mut numbers: [[f64; 3]; 15] = core::array::from_fn(|k| [DEFAULTS[k]; 3]);
            numbers[5] = [0.5; 3];
            numbers
        });
        let schlick = 0.8 + 0.2 * (6.0f64 / 7.0).powi(5);
        assert!((gold.tinted(1.0 / 7.0, 0) - 0.5 * schlick).abs() < 1e-9 && (gold.tinted(1.0, 0) - 0.8).abs() < 1e-12);
    }

    #[test]
    fn bad_lines_are_named() {
        let error = |text: &str| read(text.as_bytes()).err().unwrap().to_string();
        assert!(error("transmission_weight 1\n").contains("line 1: the key must be one of base_weight, base_color"));
        assert!(error("base_color 2\n").contains("line 1: base_color is 2, outside 0 to 1"));
        assert!(error("\nfuzz_weight 1 1 1\n").contains("line 2: fuzz_weight has one number"));
        assert!(read(b"").is_ok());
    }
}
