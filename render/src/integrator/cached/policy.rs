//! Which surfaces are cached, and by which kind of record.

pub use super::grades::Finish;
use super::grades::{Graded, Grades};
pub use super::kinds::{Allowed, Glossy, Kinds};
use super::kinds::{COUNT, KINDS, Listed, PerKind, WithKind};
pub use super::materials::{approximation, specular};
use super::materials::{is_coated, is_diffuse};
use crate::bsdf::{Component, components_of, has_base};
use crate::scene::{Coordinates, Material, MaterialId, Scene};
use crate::world::{Interaction, World};
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

/// The materials of the components of one, and how each is treated, if not as it is on its own.
type Components = Box<[(MaterialId, Option<Finish>)]>;

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
    /// By material that shapes have.
    components: Vec<Option<Components>>,
    /// Whether the base of a material is held without what it reflects besides.
    splits: Vec<bool>,
    /// One line for each glossy material, for people.
    pub notes: Vec<String>,
}

impl Policy {
    /// Decides for every material of a scene; `table` finds or fits the table of a recipe.
    ///
    /// # Errors
    /// Those of `table`.
    pub fn new<E>(scene: &Scene, allowed: Allowed, table: impl FnMut(&Recipe) -> Result<Table, E>) -> Result<Self, E> {
        Self::with_bases(scene, allowed, true, table)
    }

    /// [`Policy::new`], which with `bases` holds the Lambertian base of what is too sharp for glossy records; else that is path
    /// traced whole.
    ///
    /// # Errors
    /// Those of `table`.
    pub fn with_bases<E>(
        scene: &Scene,
        allowed: Allowed,
        bases: bool,
        mut table: impl FnMut(&Recipe) -> Result<Table, E>,
    ) -> Result<Self, E> {
        let mut policy = Self::default();
        policy.asked = policy.kinds.ask(&allowed);
        (policy.treatments, policy.makers) = (vec![Treatment::Traced; scene.materials.len()], Vec::new());
        policy.makers.clone_from(&policy.treatments);
        let mut notes = Vec::new();
        for (i, material) in scene.materials.iter().enumerate() {
            let (grades, treatment, note) = match policy.graded(scene, material, &mut table)? {
                Some((grades, note)) => (grades, Treatment::Traced, Some(note)),
                None => {
                    let (treatment, note) = policy.decide(material, &mut table)?;
                    (None, treatment, note)
                }
            };
            // Where its lobe is too sharp for glossy records, its base is not.
            let traced = grades.is_none() && treatment == Treatment::Traced;
            // Below a mirror that pays; below a lobe no error was saved, and lamps in it became fireflies.
            let everywhere = allowed != Allowed::Auto && policy.asked.iter().any(|&asked| asked);
            policy.splits.push(bases && traced && (everywhere || is_coated(material)) && has_base(material));
            notes.push(note.map(|note| format!("{}: {note}", name(scene, i))));
            (policy.treatments[i], policy.makers[i]) = (treatment, treatment);
            policy.grades.push(grades);
        }
        policy.join(scene);
        let base = |i: usize| policy.splits[i] && policy.is_component(MaterialId(i as u32));
        let told = notes
            .into_iter()
            .enumerate()
            .filter_map(|(i, note)| Some(if base(i) { note?.replacen("path traced", BASE, 1) } else { note? }));
        policy.notes = told.collect();
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

    /// Which records the components of materials share.
    fn join(&mut self, scene: &Scene) {
        let coated = self.splits.contains(&true);
        let (treatment, class) = (self.treatments.len() as u32, self.makers.len() as u32);
        let irradiance = Finish { treatment, class, first: class };
        if coated {
            self.treatments.push(Treatment::Irradiance);
            self.makers.push(Treatment::Irradiance);
        }
        for id in 0..scene.materials.len() as u32 {
            let components =
                components_of(scene, MaterialId(id), &|id| self.splits(id)).map(|of| self.joined(&of, irradiance));
            let held = |of: &[(MaterialId, Option<Finish>)]| {
                let own = |id: MaterialId| {
                    self.grades[id.0 as usize].is_some() || self.treatments[id.0 as usize] != Treatment::Traced
                };
                of.iter().any(|(id, finish)| finish.is_some() || own(*id))
            };
            self.components.push(components.filter(|of| held(of)));
        }
    }

    /// The components of one of them: lobes that are the same everywhere by width, and what is diffuse with the broadest.
    fn joined(&mut self, of: &[MaterialId], irradiance: Finish) -> Components {
        let own = |id: &MaterialId| self.treatments[id.0 as usize];
        let mut lobes: Vec<(f32, MaterialId)> = (of.iter())
            .filter_map(|id| match own(id) {
                Treatment::Glossy(glossy) => Some((glossy.with(&self.kinds, LobeWidth), *id)),
                Treatment::Irradiance | Treatment::Traced => None,
            })
            .collect();
        lobes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let first = self.makers.len() as u32;
        let base = |id: &MaterialId| own(id) == Treatment::Irradiance || self.splits(*id);
        let bases: Vec<MaterialId> = of.iter().copied().filter(|id| base(id)).collect();
        let class = |i: usize| Finish { treatment: lobes[i].1.0, class: first + i as u32, first };
        let finish = |id: &MaterialId| match lobes.iter().position(|lobe| lobe.1 == *id) {
            Some(i) => Some(class(i)),
            None if !bases.contains(id) => None,
            None if lobes.is_empty() => self.splits(*id).then_some(irradiance),
            None => Some(class(lobes.len() - 1)),
        };
        let joined = of.iter().map(|id| (*id, finish(id))).collect();
        let makers: Vec<Treatment> = lobes.iter().map(|lobe| own(&lobe.1)).collect();
        self.makers.extend(makers);
        joined
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

    /// Whether a material is divided into its base and the rest.
    #[inline]
    pub(super) fn splits(&self, id: MaterialId) -> bool {
        self.splits[id.0 as usize]
    }

    /// Whether a component is one that records can hold: of what is divided, the base.
    pub(super) fn is_held(&self, component: &Component) -> bool {
        let Component { bsdf, .. } = component;
        bsdf.parts().is_some_and(|parts| !self.splits(bsdf.material()) || parts.is_diffuse())
    }

    /// Whether a material is treated as a component, on its own or of others.
    fn is_component(&self, material: MaterialId) -> bool {
        self.components.iter().flatten().any(|of| of.iter().any(|(id, _)| *id == material))
    }

    /// How a component of a surface is treated; `None` if it is traced.
    #[inline]
    pub(super) fn component_finish(&self, scene: &Scene, at: &Interaction, component: &Component) -> Option<Finish> {
        let material = component.bsdf.material();
        let known = self.components[at.material.0 as usize].as_ref()?;
        let (_, finish) = known.iter().find(|(id, _)| *id == material)?;
        let finish = finish.unwrap_or_else(|| self.finish(scene, material, &at.coordinates));
        (self.treatment(finish) != Treatment::Traced).then_some(finish)
    }

    /// The component of a surface whose records serve all that records hold of it; `None` where it is taken as one.
    #[inline(always)]
    pub(super) fn main_component<'a>(&self, world: &'a World, at: &Interaction) -> Option<(Component<'a>, Finish)> {
        self.components[at.material.0 as usize].as_ref()?;
        self.sharpest_component(world, at)
    }

    #[cold]
    #[inline(never)]
    fn sharpest_component<'a>(&self, world: &'a World, at: &Interaction) -> Option<(Component<'a>, Finish)> {
        let mut main: Option<(Component, Finish)> = None;
        world.components(
            at,
            |id| self.splits(id),
            |component| {
                let held = self.component_finish(&world.scene, at, &component).filter(|_| self.is_held(&component));
                let before = |finish: Finish| (self.treatment(finish) == Treatment::Irradiance, finish.class);
                if let Some(finish) = held
                    && main.is_none_or(|(_, main)| before(finish) < before(main))
                {
                    main = Some((component, finish));
                }
            },
        );
        main
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

/// What is said of a material whose base is held without its lobe.
const BASE: &str = "base cached, the rest path traced";

fn name(scene: &Scene, i: usize) -> String {
    let name = scene.material_names.get(i).filter(|n| !n.is_empty());
    name.cloned().unwrap_or_else(|| format!("material {i}"))
}

/// Width of the lobe of a material.
pub(super) struct LobeWidth;

impl WithKind for LobeWidth {
    type Out = f32;

    #[inline(always)]
    fn run<K: Listed>(self, kind: &K, held: K::Held) -> f32 {
        kind.lobe_width(held)
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
    if is_coated(material) && has_base(material) {
        return "irradiance records below a mirror, path traced where the picture is denoised".into();
    }
    match specular(material) {
        Ok(specular) => KINDS.iter().find_map(|kind| (kind.outlook)(&specular)).unwrap_or_else(|| "path traced".into()),
        Err(reason) => format!("path traced ({reason})"),
    }
}
