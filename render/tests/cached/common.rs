//! What several of the tests need.

use brdf_tables::brdf::{Phong, Specular};
use brdf_tables::family;
use brdf_tables::material::Material as Recipe;
use brdf_tables::table::Table;
use glam::{Affine2, Vec3A};
use render::cache::Spacing;
use render::film::render;
use render::frame::Frame;
use render::hemisphere::{GatherSample, Guide, Incident, gather_cells};
use render::integrator::PathTracer;
use render::integrator::cached::policy::{Allowed, Policy};
use render::integrator::cached::{Caches, Figures, Settings, render_cached};
use render::picture::{Budget, Picture};
use render::record::eas::Estimator;
use render::sampler::Sampler;
use render::scene::{Bitmap, FloatTexture, Interpolation, Scene, Texels, Texture, TextureId, Wrap, load};
use render::tables::Tables;
use render::world::World;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock};

/// Folder of this project's scenes.
pub fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes")
}

/// Shipped tables and, in a folder of the build, those that the tests fit.
fn tables() -> &'static Mutex<Tables> {
    static TABLES: OnceLock<Mutex<Tables>> = OnceLock::new();
    TABLES.get_or_init(|| {
        let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tables");
        let own = Path::new(env!("CARGO_TARGET_TMPDIR")).join("tables");
        std::fs::create_dir_all(&own).expect("the build folder can be written");
        for entry in std::fs::read_dir(shipped).expect("the project's tables").flatten() {
            if entry.path().extension().is_some_and(|e| e == "tbl") {
                std::fs::copy(entry.path(), own.join(entry.file_name())).expect("tables can be copied");
            }
        }
        Mutex::new(Tables::open(&own).expect("tables can be read"))
    })
}

pub fn table(recipe: &Recipe) -> Table {
    tables().lock().expect("no test panics while it fits").find(recipe).expect("the material can be fitted")
}

pub fn phong(exponent: f64) -> Table {
    table(&Recipe::specular(Specular::Phong(Phong { exponent })))
}

/// Samples of a partition that is fine everywhere, under light given by direction.
pub fn gathered(
    frame: &Frame,
    lobe_width: f32,
    fineness: f32,
    per_cell: u32,
    light: impl Fn(Vec3A) -> Incident,
) -> Vec<GatherSample> {
    let cells = Guide::new(frame, &[], lobe_width, fineness).cells(4096);
    let cells: Vec<_> = cells.into_iter().map(|c| (c, per_cell)).collect();
    gather_cells(frame, &cells, |i| Sampler::new(3, (1, 2), i).next_2d(), |d, _| light(d))
}

/// A scene of this project at a small size.
pub fn world(scene: &str, defines: &[(&str, &str)]) -> World {
    let defines = defines.iter().map(|(n, v)| ((*n).into(), (*v).into())).collect();
    let options = load::Options { defines, ..load::Options::default() };
    let (scene, _) = load::load(&scenes().join(scene), &options).expect("the project's scenes load");
    World::new(scene).expect("the project's scenes are valid")
}

pub fn cached(world: &World, allowed: Allowed, tolerance: f32, spp: u32) -> (Picture, Figures) {
    let policy = Policy::new(&world.scene, allowed, |r| Ok::<_, ()>(table(r))).expect("no table is refused");
    let settings = Settings {
        tolerance: Some(tolerance),
        estimator: Estimator::Improved,
        spacing: Spacing::default(),
        sources: None,
        budget: Budget::Samples(spp),
        seed: 1,
        indirect_only: false,
        interpolation: render::integrator::cached::Interpolation::Auto,
    };
    let (picture, figures, _) = render_cached(world, &policy, &settings, None, &|_| ());
    (picture, figures)
}

pub fn traced(world: &World, spp: u32) -> Picture {
    let integrator = PathTracer { settings: world.scene.integrator, indirect_only: false };
    render(world, &integrator, Budget::Samples(spp), 7, &|_| ())
}

/// Relative mean square error over blocks of 4 × 4 pixels, where the noise of the reference is small, and bias.
pub fn compare(picture: &Picture, reference: &Picture) -> (f64, f64) {
    let (a, b) = (picture.image(), reference.image());
    let (columns, rows) = (a.width as usize / 4, a.height as usize / 4);
    let block = |pixels: &[[f32; 3]], bx: usize, by: usize, c: usize| {
        let at = |i: usize| pixels[(4 * by + i / 4) * a.width as usize + 4 * bx + i % 4][c];
        (0..16).map(|i| f64::from(at(i))).sum::<f64>() / 16.0
    };
    let (mut error, mut difference, mut total) = (0.0, 0.0, 0.0);
    for i in 0..columns * rows {
        for c in 0..3 {
            let (x, r) = (block(&a.pixels, i % columns, i / columns, c), block(&b.pixels, i % columns, i / columns, c));
            error += (x - r) * (x - r) / (r * r + 0.01);
            difference += x - r;
            total += r;
        }
    }
    (error / (3 * columns * rows) as f64, if total > 0.0 { difference / total } else { 0.0 })
}

/// Adds a texture of smooth noise between two numbers.
pub fn noise(scene: &mut Scene, low: f32, high: f32, to_uv: Affine2) -> FloatTexture {
    const SIDE: u32 = 16;
    let texel = |i: u32| low + (high - low) * ((i.wrapping_mul(2_654_435_769) >> 8) as f32 / (1 << 24) as f32);
    let texels = Texels::Gray((0..SIDE * SIDE).map(texel).collect());
    let (wrap, interpolation) = ([Wrap::Repeat; 2], Interpolation::Bilinear);
    let bitmap = Bitmap { width: SIDE, height: SIDE, texels, wrap, interpolation, second_uv: false, to_uv };
    scene.textures.push(Texture::Bitmap(bitmap));
    FloatTexture::Texture(TextureId(scene.textures.len() as u32 - 1))
}

/// A fill and samples that tell a percent.
pub fn settings() -> Settings {
    Settings {
        tolerance: Some(0.05),
        estimator: Estimator::Improved,
        spacing: Spacing::default(),
        sources: None,
        budget: Budget::Samples(48),
        seed: 1,
        indirect_only: false,
        interpolation: render::integrator::cached::Interpolation::Auto,
    }
}

/// Draws with tables of families alone: none is fitted.
pub fn drawn(world: &World, allowed: Allowed) -> (Policy, Picture, Figures, Caches) {
    let policy = Policy::new(&world.scene, allowed, |recipe| family::table(recipe).ok_or(recipe.recipe_text()));
    let policy = policy.expect("every lobe is of a family");
    let (picture, figures, caches) = render_cached(world, &policy, &settings(), None, &|_| ());
    (policy, picture, figures, caches)
}
