//! Surfaces of several components: blends, coats, and smooth coats with their base.
//!
//! Records are light, so one record serves all components of a surface. Their classes are in order of the width of their lobes:
//! a surface has records for its sharpest lobe, and the broader ones read those.

use super::points::{Point, Walk};
use super::policy::Finish;
use super::shade::{Ended, Shader};
use crate::bsdf::Component;
use crate::scene::Rgb;

impl Shader<'_> {
    /// The light of a surface of several components, and of what those show that are followed as mirrors; returns what shines
    /// there.
    #[cold]
    #[inline(never)]
    pub(super) fn all_components(&self, point: Point, mut walk: Walk, ended: &mut Ended) -> Rgb {
        // Nothing beyond the first surface is seen at once.
        let (mut next, mut at_once, mut shines) = (Some(point), Rgb::ZERO, Rgb::ZERO);
        while let Some(point) = next {
            if !self.components(&point, &mut walk, ended) {
                break;
            }
            // What a coat mirrors is not what the pixel shows.
            let seen = self.seen(&mut walk, ended.sampler, ended.queries, (&mut at_once, &mut shines), |_| ());
            next = seen.and_then(|(point, bsdf)| {
                if point.component != 0 {
                    return Some(point);
                }
                let sample = ended.sampler.next_4x2d(&mut ended.queries.scrambles);
                self.light(&point, &bsdf, sample, ended);
                self.scattered(&point, &bsdf, sample, ended);
                None
            });
        }
        shines
    }

    /// The light of a surface of several components: records say what each of those that they hold reflects; direct light is
    /// sampled by one of these, and one of the others, at most, is followed. Whether the path goes on.
    fn components(&self, point: &Point, walk: &mut Walk, ended: &mut Ended) -> bool {
        let world = self.world;
        let sample = ended.sampler.next_4x2d(&mut ended.queries.scrambles);
        let [.., pick] = sample;
        let (mut held, mut others) = (0.0, 0.0);
        let (mut lit, mut at) = (None, pick.x);
        let splits = |id| self.policy.splits(id);
        world.components(&point.at, splits, |component| {
            let finish = self.policy.component_finish(&world.scene, &point.at, &component);
            let Some(finish) = finish.filter(|_| self.policy.is_held(&component)) else {
                others += wanted(&component);
                return;
            };
            held += component.weight;
            let share = component.weight / held;
            if at < share {
                (lit, at) = (Some((component, finish)), at / share);
            } else {
                at = (at - share) / (1.0 - share);
            }
            self.scattered(&point.of(&component, finish), &component.bsdf, sample, ended);
        });
        if let Some((component, finish)) = lit {
            let whole = Component { weight: held, ..component };
            self.light(&point.of(&whole, finish), &component.bsdf, sample, ended);
        }
        let (scale, mut place, mut followed) = (1.0 / f32::max(others, 1.0), pick.y, None);
        world.components(&point.at, splits, |component| {
            let finish = self.policy.component_finish(&world.scene, &point.at, &component);
            if finish.is_none() || !self.policy.is_held(&component) {
                let chance = scale * wanted(&component);
                if (0.0..chance).contains(&place) {
                    followed = Some((component, component.weight / chance));
                }
                place -= chance;
            }
        });
        let Some((component, factor)) = followed else { return false };
        let Component { bsdf, .. } = component;
        if bsdf.is_delta() {
            let [choice, _, scattering, _] = sample;
            let next = bsdf.sample(choice.y, scattering);
            return next.is_some_and(|next| walk.go_on(world, &point.at, &bsdf, &next, factor));
        }
        let traced = Component { weight: factor, ..component };
        let traced = point.of(&traced, Finish::plain(bsdf.material().0));
        self.light(&traced, &bsdf, sample, ended);
        let [choice, _, scattering, _] = sample;
        let Ended { out, sampler, queries, .. } = ended;
        out.indirect = out.indirect + self.traced(&traced, &bsdf, None, choice.y, scattering, sampler, queries);
        false
    }
}

/// The chance that a component which no record holds is followed, unless all together are above 1: what a faint mirror shows is
/// often bright, so that it is looked at more often than by its share.
fn wanted(component: &Component) -> f32 {
    let Component { weight, bsdf, .. } = component;
    let share = weight * bsdf.reflectance().max_element();
    // An estimate that is much too small would make paths that count too much.
    share.clamp(0.04 * weight, 1.0).sqrt().min(1.0)
}
