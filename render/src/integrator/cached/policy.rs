//! Which surfaces are cached, and by which kind of record.

pub use super::grades::Finish;
use super::grades::{Graded, Grades};
pub use super::kinds::{Allowed, Glossy, Kinds};
use super::kinds::{COUNT, KINDS, PerKind};
use super::materials::is_diffuse;
pub use super::materials::specular;
use crate::scene::{Coordinates, Material, MaterialId, Scene};
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
    /// By [`Finish::treatment`]: of every material, then of the steps of those whose lobe a texture gives.
    treatments: Vec<Treatment>,
    /// How records are made, by [`Finish::class`]: for every material, then for the grades of those whose lobe a texture gives.
    makers: Vec<Treatment>,
    /// By material.
    grades: Vec<Option<Grades>>,
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
        (policy.treatments, policy.makers) = (vec![Treatment::Traced; scene.materials.len()], Vec::new());
        policy.makers.clone_from(&policy.treatments);
        for (i, material) in scene.materials.iter().enumerate() {
            let (grades, treatment, note) = match policy.graded(scene, material, &mut table)? {
                Some((grades, note)) => (grades, Treatment::Traced, Some(note)),
                None => {
                    let (treatment, note) = policy.decide(material, &mut table)?;
                    (None, treatment, note)
                }
            };
            let name = scene.material_names.get(i).filter(|n| !n.is_empty());
            let name = name.cloned().unwrap_or_else(|| format!("material {i}"));
            policy.notes.extend(note.map(|note| format!("{name}: {note}")));
            (policy.treatments[i], policy.makers[i]) = (treatment, treatment);
            policy.grades.push(grades);
        }
        Ok(policy)
    }

    /// The steps of a material of which a texture gives the width of the lobe, where any of them is held, and what becomes of
    /// it in words; `None` of other materials.
    fn graded<E>(
        &mut self,
        scene: &Scene,
        material: &Material,
        table: &mut impl FnMut(&Recipe) -> Result<Table, E>,
    ) -> Result<Option<(Option<Grades>, String)>, E> {
        let graded = Graded::of(material).filter(|_| !is_diffuse(material) && self.asked.iter().any(|&asked| asked));
        let Some(ladder) = graded.and_then(|g| g.ladder(scene)) else { return Ok(None) };
        let grades = ladder.at(self.treatments.len() as u32, self.makers.len() as u32);
        let (mut treatments, mut makers) = (Vec::new(), Vec::new());
        for (grade, lobe) in ladder.lobes() {
            let glossy = match lobe {
                Some(lobe) => self.kinds.hold(&self.asked, lobe, table)?.0,
                None => None,
            };
            let treatment = glossy.map_or(Treatment::Traced, Treatment::Glossy);
            treatments.push(treatment);
            // The sharpest that is held.
            makers.resize(grade as usize + 1, Treatment::Traced);
            if makers[grade as usize] == Treatment::Traced {
                makers[grade as usize] = treatment;
            }
        }
        let [sharp, broad] = ladder.widths().map(|width| width.min(1.0));
        let lobes = format!("lobe {sharp:.3} to {broad:.3} rad, from a texture");
        let held = treatments.iter().filter(|t| **t != Treatment::Traced).count();
        Ok(Some(match held {
            0 => (None, format!("path traced ({lobes}: too sharp to cache)")),
            _ => {
                let whole = held == treatments.len();
                self.treatments.extend(treatments);
                self.makers.extend(makers);
                (
                    Some(grades),
                    format!("cached ({lobes}){}", if whole { "" } else { ", path traced where it is sharper" }),
                )
            }
        }))
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

    /// Number of classes of records.
    pub(super) fn classes(&self) -> u32 {
        self.makers.len() as u32
    }

    /// How a surface of a material is treated, and which records it reads.
    #[inline]
    pub fn finish(&self, scene: &Scene, material: MaterialId, at: &Coordinates) -> Finish {
        match &self.grades[material.0 as usize] {
            Some(grades) => grades.finish(&scene.textures, at),
            None => Finish::plain(material.0),
        }
    }

    /// How a surface is treated.
    #[inline]
    pub fn treatment(&self, finish: Finish) -> Treatment {
        self.treatments[finish.treatment as usize]
    }

    /// How the records of a surface are made: for the sharpest lobe of its class.
    #[inline]
    pub fn maker(&self, finish: Finish) -> Treatment {
        self.makers[finish.class as usize]
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
    if Graded::of(material).is_some() {
        return "EAS records where its lobe, which a texture gives, is wide enough".into();
    }
    match specular(material) {
        Ok(specular) => KINDS.iter().find_map(|kind| (kind.outlook)(&specular)).unwrap_or_else(|| "path traced".into()),
        Err(reason) => format!("path traced ({reason})"),
    }
}
