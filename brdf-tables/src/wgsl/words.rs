//! Tables as words of a storage buffer.

use super::model;
use crate::cubature::{Cubature, RULES, rule_numbers};
use crate::lobes::Lobes;
use crate::table::{Representation, Table};
use crate::zonal::Zonal;
use core::f64::consts::PI;

/// Representations, in the first word of a table.
pub const DIFFUSE: u32 = 0;
pub const ZONAL: u32 = 1;
pub const CUBATURE: u32 = 2;
const LOBES: u32 = 3;

/// Where it stands in the buffer whether a rule is a product: after count and place of the nodes of each.
pub const RULE_KINDS: u32 = 2 * RULES.len() as u32;

/// Words of a table before its parts: representation, places of model and representation, kd, ks.
const HEAD: usize = 9;

/// Why a table has no place in a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WgslError {
    /// It is stored as published in 2015, for comparison; shaders have no look-up for that.
    #[error("a table in the layout of 2015 has no look-up in WGSL; fit it without --solver ga")]
    Paper,
    /// The buffer would have more than 2³² words.
    #[error("too many tables for one buffer")]
    Full,
}

/// Tables in one buffer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tables {
    words: Vec<u32>,
}

impl Default for Tables {
    fn default() -> Self {
        Self::new()
    }
}

impl Tables {
    /// No table yet, but the rules that all share.
    pub fn new() -> Self {
        let rules = RULES.len();
        let mut words = vec![0; 3 * rules];
        for (i, rule) in RULES.iter().enumerate() {
            let (is_product, size, numbers) = rule_numbers(*rule);
            (words[2 * i], words[2 * i + 1]) = ((numbers.len() / size) as u32, words.len() as u32);
            words[2 * rules + i] = is_product.into();
            words.extend(numbers.iter().map(|x| (*x as f32).to_bits()));
        }
        Self { words }
    }

    /// Adds a table. Returns its place, which the functions of the shader take.
    ///
    /// # Errors
    /// A table that has no place in a buffer; the others are left as they are.
    pub fn push(&mut self, table: &Table) -> Result<u32, WgslError> {
        let place = self.place(self.words.len())?;
        let material = &table.header.material;
        let colors = material.kd.into_iter().chain(material.ks).map(|x| (x as f32).to_bits());
        let mut words = vec![0; 3];
        words.extend(colors);
        debug_assert_eq!(words.len(), HEAD);
        let at = |words: &[u32]| self.place(self.words.len() + words.len());
        if let Some(specular) = table.specular() {
            words[1] = at(&words)?;
            let model = model::words(specular, words[1]);
            words.extend(model);
        }
        words[2] = at(&words)?;
        let (kind, own) = match &table.representation {
            Representation::Diffuse => (DIFFUSE, Vec::new()),
            Representation::Zonal(zonal) => (ZONAL, self::zonal(zonal, table)),
            Representation::Cubature(cubature) => (CUBATURE, self::cubature(cubature)),
            Representation::Lobes(lobes) => (LOBES, self::lobes(lobes)),
            Representation::Paper(_) => return Err(WgslError::Paper),
        };
        words[0] = kind;
        words.extend(own);
        at(&words)?;
        self.words.extend(words);
        Ok(place)
    }

    fn place(&self, at: usize) -> Result<u32, WgslError> {
        u32::try_from(at).map_err(|_| WgslError::Full)
    }

    /// The buffer, in words.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// The buffer, in bytes of this machine's order, as a graphics card takes it.
    pub fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.words)
    }
}

fn bits(x: f64) -> u32 {
    (x as f32).to_bits()
}

fn zonal(zonal: &Zonal, table: &Table) -> Vec<u32> {
    let (rows, columns, cells, [p, r]) = zonal.parts();
    let (amplitude, exponent) = table.specular().and_then(|s| s.radial_exponent()).unwrap_or_default();
    let mut words = vec![bits(exponent), bits(2.0 * PI * amplitude / (exponent + 2.0)), columns as u32, rows as u32];
    words.extend(p.into_iter().chain(r).map(bits));
    words.push(zonal.clipping_rule() as u32);
    words.extend(cells);
    words
}

fn cubature(cubature: &Cubature) -> Vec<u32> {
    let (azimuths, scale, [first, last], cells) = cubature.bins().parts();
    let mut words = vec![azimuths as u32, scale.to_bits(), first, last - first + 1];
    words.extend(cells);
    words
}

fn lobes(lobes: &Lobes) -> Vec<u32> {
    let (axes, count, _) = lobes.parts();
    let mut words = vec![axes.theta, axes.phi, axes.omega];
    let half = 0.5 * axes.sharpness;
    words.extend([half, half.ln_1p().recip(), axes.stretch].map(bits));
    words.push(count as u32);
    for node in 0..axes.len() {
        for lobe in lobes.node(node) {
            let a = lobe.axis;
            // The exponent magnifies what the axis is longer than 1.
            let short = 0.5 - 0.5 * a.length_squared();
            words.extend([a.x, a.y, 1.0 - a.z, lobe.amplitude, lobe.exponent, short].map(bits));
        }
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Material;

    #[test]
    fn tables_follow_one_another() {
        let phong = Table::from_bytes(include_bytes!("../../../tables/phong-20.tbl")).unwrap();
        let ggx = Table::from_bytes(include_bytes!("../../../tables/ggx-0.1.tbl")).unwrap();
        let mut tables = Tables::new();
        let rules = tables.words().len();
        let places = [&phong, &ggx, &phong].map(|t| tables.push(t).unwrap() as usize);
        assert_eq!(places[0], rules);
        assert!(places[1] > places[0] && places[2] > places[1]);
        assert_eq!([0, 1, 2].map(|i| tables.words()[places[i]]), [ZONAL, CUBATURE, ZONAL]);
        assert_eq!(tables.bytes().len(), 4 * tables.words().len());
        assert!(matches!(phong.header.material, Material { specular: Some(_), .. }));
    }
}
