//! What to sweep.

use super::method::{Engine, Method, Size};
use super::setting::Setting;
use render::denoise::Denoiser;
use render::scene::load::Options;
use std::path::PathBuf;

/// Runs whose records have one size take the τ nearest to this: fine enough that the size shows, and soon done.
const SIZES_TAU: f32 = 0.04;

/// A reference that is traced: it ends at an error or a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference {
    /// Root of the rel_mse that its own noise may have.
    pub error: f64,
    /// Most seconds for it, about.
    pub seconds: f64,
}

impl Reference {
    /// Part of its file's name.
    pub fn id(self) -> String {
        format!("error{}-time{}", self.error, self.seconds)
    }
}

/// What is to be done, checked.
pub struct Plan {
    /// Scenes.
    pub scenes: Vec<PathBuf>,
    /// A reference for each, or none.
    pub references: Vec<PathBuf>,
    /// How references are traced.
    pub reference: Reference,
    /// Methods.
    pub methods: Vec<&'static Method>,
    /// Budgets, s.
    pub times: Vec<f64>,
    /// Qualities of caches.
    pub taus: Vec<f32>,
    /// Orders that every harmonic record has in runs of their own, at one τ.
    pub orders: Vec<u8>,
    /// The same for the number of EAS.
    pub sources: Vec<u16>,
    /// Samples per pixel of runs at a τ.
    pub spp: u32,
    /// Whether every method runs at one quality, and faults are judged.
    pub stability: bool,
    /// Width of the film.
    pub width: Option<u32>,
    /// How scenes are loaded: their parameters, and what may be missing.
    pub load: Options,
    /// What denoises the pictures of methods that ask for it.
    pub denoiser: Option<Denoiser>,
    /// Folder of tables.
    pub tables: PathBuf,
    /// Seed.
    pub seed: u64,
    /// Whether light that is scattered less than twice is left out.
    pub indirect_only: bool,
    /// Folder of the results.
    pub output: PathBuf,
    /// The command, for the page.
    pub command: String,
}

impl Plan {
    /// Settings of a method, in the order in which they are run.
    pub fn settings(&self, method: &Method) -> Vec<Setting> {
        let off = |tau: f32| (tau / SIZES_TAU).ln().abs();
        let tau = self.taus.iter().copied().min_by(|a, b| off(*a).total_cmp(&off(*b)));
        let sizes: Vec<Setting> = match method.size {
            Some(Size::Order) => tau.iter().flat_map(|t| self.orders.iter().map(|n| Setting::Order(*n, *t))).collect(),
            Some(Size::Sources) => {
                tau.iter().flat_map(|t| self.sources.iter().map(|n| Setting::Sources(*n, *t))).collect()
            }
            None => Vec::new(),
        };
        let quality = match method.engine {
            Engine::Traced if self.stability => vec![Setting::Spp(self.spp)],
            Engine::Traced => Vec::new(),
            Engine::Cached(..) => self.taus.iter().map(|t| Setting::Tau(*t)).collect(),
        };
        let times = self.times.iter().map(|t| Setting::Time(*t));
        // What noise is left at a quality is that of its samples: a denoiser is judged at equal time.
        if method.denoised && !self.times.is_empty() {
            times.collect()
        } else {
            times.chain(quality).chain(sizes).collect()
        }
    }

    /// All cells of a scene.
    pub fn cells(&self) -> Vec<(&'static Method, Setting)> {
        self.methods.iter().flat_map(|m| self.settings(m).into_iter().map(|s| (*m, s))).collect()
    }
}
