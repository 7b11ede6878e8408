//! Which surfaces are cached, and by which kind of record.

pub use super::kinds::{Allowed, Glossy, Kinds};
use super::kinds::{COUNT, KINDS, PerKind};
use super::materials::is_diffuse;
pub use super::materials::specular;
use crate::scene::{Material, Scene};
use brdf_tables::material::Material as Recipe;
use brdf_tables::table::Table;
use serde::{Serialize, Serializer};

/// How the indirect light of a material is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Treatment {
    /// Irradiance records: nothing but a Lambertian part.
    Irradiance,
    /// Records of a kind.
    Glossy(Glossy),
    /// Path traced.
    Traced,
}

/// As one enum with the kinds between the two others.
impl Serialize for Treatment {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Irradiance => to.serialize_unit_variant("Treatment", 0, "Irradiance"),
            Self::Glossy(glossy) => glossy.serialize(to),
            Self::Traced => to.serialize_unit_variant("Treatment", 1 + COUNT as u32, "Traced"),
        }
    }
}

/// Treatment of every material.
#[derive(Clone, Debug, Default)]
pub struct Policy {
    /// What the kinds know of the materials.
    pub kinds: Kinds,
    /// Kinds that were asked for.
    asked: PerKind<bool>,
    /// By material.
    treatments: Vec<Treatment>,
    /// One line for each glossy material, for people.
    pub notes: Vec<String>,
}

impl Policy {
    /// Decides for every material of a scene; `table` finds or fits the table of a recipe.
    ///
    /// # Errors
    /// Those of `table`.
    pub fn new<E>(
        scene: &Scene,
        allowed: Allowed,
        mut table: impl FnMut(&Recipe) -> Result<Table, E>,
    ) -> Result<Self, E> {
        let mut policy = Self::default();
        policy.asked = policy.kinds.ask(&allowed);
        for (i, material) in scene.materials.iter().enumerate() {
            let (treatment, note) = policy.decide(material, &mut table)?;
            let name = scene.material_names.get(i).filter(|n| !n.is_empty());
            let name = name.cloned().unwrap_or_else(|| format!("material {i}"));
            policy.notes.extend(note.map(|note| format!("{name}: {note}")));
            policy.treatments.push(treatment);
        }
        Ok(policy)
    }

    /// The treatment of a material, and why.
    fn decide<E>(
        &mut self,
        material: &Material,
        table: &mut impl FnMut(&Recipe) -> Result<Table, E>,
    ) -> Result<(Treatment, Option<String>), E> {
        if is_diffuse(material) {
            return Ok((Treatment::Irradiance, None));
        }
        let any = self.asked.iter().any(|&asked| asked);
        let only = |specular| if any { Ok(specular) } else { Err("the method caches irradiance only") };
        let specular = match specular(material).and_then(only) {
            Ok(specular) => specular,
            Err(reason) => {
                // Of those that wrap others, the others tell.
                let own = material.children().next().is_none();
                return Ok((Treatment::Traced, own.then(|| format!("path traced ({reason})"))));
            }
        };
        let (held, note) = self.kinds.hold(&self.asked, specular, table)?;
        Ok((held.map_or(Treatment::Traced, Treatment::Glossy), note))
    }

    /// Whether a kind that was asked for made all it needs by itself, without tables.
    pub fn is_without_tables(&self) -> bool {
        self.asked.iter().zip(&KINDS).any(|(asked, kind)| *asked && !kind.tables)
    }

    /// How every material is treated.
    pub(super) fn treatments(&self) -> &[Treatment] {
        &self.treatments
    }

    /// How material number `index` is treated.
    #[inline]
    pub fn treatment(&self, index: u32) -> Treatment {
        self.treatments[index as usize]
    }
}

impl Allowed {
    /// Whether a kind that may be used looks anything up in tables.
    pub fn needs_tables(&self) -> bool {
        Kinds::default().ask(self).iter().zip(&KINDS).any(|(asked, kind)| *asked && kind.tables)
    }
}

/// What [`Policy::new`] with [`Allowed::Auto`] does with a material, in words, without its table.
pub fn outlook(material: &Material) -> String {
    if is_diffuse(material) {
        return "irradiance records".into();
    }
    match specular(material) {
        Ok(specular) => KINDS.iter().find_map(|kind| (kind.outlook)(&specular)).unwrap_or_else(|| "path traced".into()),
        Err(reason) => format!("path traced ({reason})"),
    }
}
