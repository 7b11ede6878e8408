//! The components of a material that is made of others: blends, coats and sheen; and of one of a Lambertian base and a lobe, where
//! the lobe is too sharp for records.
//!
//! [`World::bsdf`] picks one of them by the point, which is right on average. Here all of them are had, with their weights, so
//! that what is known of each can be summed without noise.

use super::layers::schlick_rise;
use super::resolve::{Choice, Pick};
use super::{Bsdf, Glossy, Mirror, Model, Parts, RoughCoat, SmoothCoat};
use crate::scene::{ColorTexture, FloatTexture, Material, MaterialId, Rgb, Scene};
use crate::world::{Interaction, World};

/// Most choices among others that a material may have.
const MOST_CHOICES: u32 = 6;

/// A component at a point of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Component<'a> {
    /// The choices that lead to it, a bit each, after a leading one.
    pub index: u8,
    /// Share of it; those of all may be more than 1, where a coat is added.
    pub weight: f32,
    /// How it scatters.
    pub bsdf: Bsdf<'a>,
}

/// The choices that lead to a component.
#[derive(Clone, Copy)]
struct Choices(u32);

impl Choices {
    const NONE: Self = Self(1);

    fn count(self) -> u32 {
        self.0.ilog2()
    }

    /// Choice number `i`; the first of two where there is none.
    fn get(self, i: u32) -> bool {
        self.count().checked_sub(i + 1).is_some_and(|shift| self.0 >> shift & 1 == 1)
    }

    fn with(self, second: bool) -> Self {
        Self(self.0 << 1 | u32::from(second))
    }

    /// What leads to the next component; `None` after the last.
    fn next(self) -> Option<Self> {
        let up = self.0 >> self.0.trailing_ones();
        (up > 0).then_some(Self(up | 1))
    }
}

impl World {
    /// Calls `each` with every component of some weight, in order. A material that `splits` gives its base and the rest.
    #[inline]
    pub fn components<'a>(
        &'a self,
        at: &Interaction,
        splits: impl Fn(MaterialId) -> bool,
        mut each: impl FnMut(Component<'a>),
    ) {
        let mut choices = Some(Choices::NONE);
        while let Some(lead) = choices {
            let (taken, weight, bsdf) = self.along(at, lead);
            choices = taken.next();
            let mut give = |taken: Choices, bsdf| {
                if weight > 0.0 {
                    each(Component { index: taken.0 as u8, weight, bsdf });
                }
            };
            match halves(&bsdf).filter(|_| splits(bsdf.material)) {
                Some(halves) => {
                    let [base, rest] = halves.map(|model| Bsdf { model, ..bsdf });
                    give(taken.with(false), base);
                    give(taken.with(true), rest);
                }
                None => give(taken, bsdf),
            }
        }
    }

    /// The component of this [`Component::index`].
    #[inline]
    pub fn component(&self, at: &Interaction, index: u8) -> Bsdf<'_> {
        let choices = Choices(u32::from(index));
        let (taken, _, bsdf) = self.along(at, choices);
        match halves(&bsdf).filter(|_| choices.count() > taken.count()) {
            Some(halves) => Bsdf { model: halves[usize::from(choices.get(taken.count()))], ..bsdf },
            None => bsdf,
        }
    }

    /// The component that choices lead to, the first of two where they end; all choices on the way, and its weight.
    #[inline]
    fn along(&self, at: &Interaction, choices: Choices) -> (Choices, f32, Bsdf<'_>) {
        let (mut taken, mut weight) = (Choices::NONE, 1.0);
        let bsdf = self.resolve(at, |choice, _| {
            let second = choices.get(taken.count());
            weight *= match (choice, second) {
                (Choice::Blend(share), true) => share,
                (Choice::Blend(share), false) => 1.0 - share,
                (Choice::Sum(strength), true) => strength,
                (Choice::Sum(_), false) => 1.0,
            };
            taken = taken.with(second);
            if second { Pick::Second } else { Pick::First }
        });
        (taken, weight, bsdf)
    }
}

impl Bsdf<'_> {
    /// Rough estimate of the share of light that is reflected but by a Lambertian part.
    pub(crate) fn reflectance(&self) -> Rgb {
        let own = match &self.model {
            Model::Glossy(m) => m.specular,
            Model::RoughCoat(m) => m.reflectance(self.wo),
            Model::MetallicRoughness(m) => {
                let Parts { specular, grazing, .. } = m.parts(self.wo);
                specular + (grazing - specular) * schlick_rise(self.wo.z)
            }
            _ => self.own_albedo(),
        };
        own + self.coat.map_or(Rgb::ZERO, |coat| coat.reflectance(self.wo))
    }
}

/// The Lambertian base of a model, and what it reflects besides.
fn halves<'a>(bsdf: &Bsdf<'a>) -> Option<[Model<'a>; 2]> {
    Some(match bsdf.model {
        Model::SmoothCoat(coat) => {
            let mirror = Mirror { eta: Rgb::splat(coat.eta), k: Rgb::ZERO, specular: coat.specular };
            [Model::SmoothCoat(SmoothCoat { specular: Rgb::ZERO, ..coat }), Model::Mirror(mirror)]
        }
        Model::RoughCoat(coat) => {
            [RoughCoat { specular: Rgb::ZERO, ..coat }, RoughCoat { diffuse: Rgb::ZERO, ..coat }].map(Model::RoughCoat)
        }
        Model::Glossy(m) => {
            [Glossy::new(m.diffuse, Rgb::ZERO, m.lobe), Glossy::new(Rgb::ZERO, m.specular, m.lobe)].map(Model::Glossy)
        }
        Model::MetallicRoughness(m) => m.halves().map(Model::MetallicRoughness),
        _ => return None,
    })
}

/// Whether a material has a Lambertian base beside what it reflects besides.
pub(crate) fn has_base(material: &Material) -> bool {
    let black = |color: &ColorTexture| matches!(color, ColorTexture::Constant(c) if *c == Rgb::ZERO);
    match material {
        Material::Phong { diffuse, .. }
        | Material::Ward { diffuse, .. }
        | Material::Lobe { diffuse, .. }
        | Material::Plastic { diffuse, .. }
        | Material::RoughPlastic { diffuse, .. } => !black(diffuse),
        Material::MetallicRoughness { base_color, metallic, .. } => {
            !black(base_color) && *metallic != FloatTexture::Constant(1.0)
        }
        Material::Principled { base_color, metallic, sheen, .. } => {
            let base = !black(base_color) || *sheen != FloatTexture::Constant(0.0);
            base && *metallic != FloatTexture::Constant(1.0)
        }
        _ => false,
    }
}

/// The materials that a material is made of, where it has components that only reflect and not too many choices; `None` of a
/// material that is but one, whatever wraps it.
pub(crate) fn components_of(
    scene: &Scene,
    id: MaterialId,
    splits: &impl Fn(MaterialId) -> bool,
) -> Option<Vec<MaterialId>> {
    let mut found = Vec::new();
    let choices = collect(scene, id, splits, &mut found)?;
    (1..=MOST_CHOICES).contains(&choices).then_some(found)
}

/// Adds the materials behind all wrappers; the number of choices before the last of them, `None` where one transmits light.
fn collect(
    scene: &Scene,
    id: MaterialId,
    splits: &impl Fn(MaterialId) -> bool,
    found: &mut Vec<MaterialId>,
) -> Option<u32> {
    let material = scene.materials.get(id.0 as usize)?;
    let own = match material {
        Material::Blend { .. } | Material::Coat { .. } | Material::Sheen { .. } => 1,
        Material::Dielectric { .. } | Material::ThinDielectric { .. } => return None,
        Material::RoughDielectric { .. } | Material::Glass { .. } => return None,
        _ => u32::from(splits(id)),
    };
    let mut below = 0;
    for child in material.children() {
        below = below.max(collect(scene, child, splits, found)?);
    }
    if material.children().next().is_none() && !found.contains(&id) {
        found.push(id);
    }
    Some(own + below)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_go_through_all() {
        // Of a tree whose second branch divides again.
        let (mut choices, mut seen) = (Some(Choices::NONE), Vec::new());
        while let Some(lead) = choices {
            let mut taken = Choices::NONE.with(lead.get(0));
            if taken.get(0) {
                taken = taken.with(lead.get(1));
            }
            seen.push(taken.0);
            choices = taken.next();
        }
        assert_eq!(seen, [0b10, 0b110, 0b111]);
        assert!(Choices::NONE.next().is_none());
    }
}
