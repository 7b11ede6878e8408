//! What the targets share: what must hold of a mesh, a picture, a scene once they are read.

use glam::Affine3A;
use render::film;
use render::image::{self, ImageError};
use render::integrator::PathTracer;
use render::picture::Budget;
use render::scene::load::mesh::{Finish, Mirrored, Parsed, finish};
use render::scene::load::{self, FileError, LoadError, Options};
use render::scene::{ColorTexture, Crop, Geometry, Material, MaterialId, Rgb, Scene, Shape};
use render::world::World;
use std::path::{Path, PathBuf};

/// Larger numbers of instances and triangles are read, but not drawn.
const MOST_DRAWN: usize = 1 << 12;

/// Parallel loops run on the thread of the target: handing work over costs more than the work of a small input.
pub fn one_thread() {
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global().expect("one pool");
}

/// An error is one line, and no longer than a person reads.
pub fn check_message(line: &str) {
    assert!(!line.contains(char::is_control) && line.len() <= 4096, "{line:?}");
}

/// A mesh that is read enters a scene, or is refused there.
pub fn check_mesh(parsed: Result<Parsed, FileError>) {
    let parsed = match parsed {
        Ok(parsed) => parsed,
        Err(error) => return check_message(&error.to_string()),
    };
    parsed.warnings.iter().for_each(|w| check_message(w));
    for (face_normals, mirrored) in [(false, Mirrored::ByWinding), (true, Mirrored::Image)] {
        let asked = Finish { to_world: Affine3A::IDENTITY, face_normals, flip_normals: face_normals, mirrored };
        let (mesh, _) = match finish(parsed.mesh.clone(), asked, Path::new("m")) {
            Ok(finished) => finished,
            Err(error) => return check_message(&error.to_string()),
        };
        let shape = Shape { geometry: Geometry::Mesh(mesh), material: MaterialId(0), emitter: None };
        let materials = vec![Material::Diffuse { reflectance: ColorTexture::Constant(Rgb::ONE) }];
        let scene = Scene { shapes: vec![shape], materials, ..Scene::default() };
        scene.validate().expect("a finished mesh keeps the promises of a scene");
    }
}

/// A picture that is read has as many pixels as it says, and finite colours.
pub fn check_picture(bytes: &[u8]) {
    match image::decode(bytes, Path::new("p")) {
        Ok(pixels) => {
            let raster = &pixels.raster;
            let count = raster.width as usize * raster.height as usize;
            assert_eq!(raster.samples.len(), count * raster.channels.count());
            assert!(raster.pixels().all(|p| p[..3].iter().all(|c| c.is_finite())));
            pixels.warnings.iter().for_each(|w| check_message(w));
        }
        Err(ImageError::Content { reason, .. }) => check_message(&reason),
        Err(error) => panic!("a picture in memory: {error}"),
    }
}

/// A folder of this process with a file for the input, and a few that scenes may name.
pub struct Scratch {
    file: PathBuf,
}

impl Scratch {
    /// Makes the folder; the input's name ends in `extension`.
    pub fn new(extension: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("render-fuzz-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder for scenes");
        let inputs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/inputs/valid");
        for (from, to) in [
            ("mirrored-shapes/normals.obj", "m.obj"),
            ("mirrored-shapes/normals.ply", "m.ply"),
            ("mirrored-shapes/normals.serialized", "m.serialized"),
            ("exr-colour/rgb.exr", "t.exr"),
        ] {
            std::fs::copy(inputs.join(from), folder.join(to)).expect("a file for scenes");
        }
        Self { file: folder.join("scene").with_extension(extension) }
    }

    /// Loads the scene and draws one pixel of it: what is loaded can be drawn, and gives finite light.
    pub fn check_scene(&self, bytes: &[u8]) {
        std::fs::write(&self.file, bytes).expect("a scene on disk");
        let scene = load::load(&self.file, &Options { skip_missing: true, ..Options::default() });
        match scene {
            Ok((scene, warnings)) => {
                warnings.iter().for_each(|w| check_message(w));
                draw(scene);
            }
            Err(error) => check_error(&error),
        }
    }
}

fn check_error(error: &LoadError) {
    check_message(&error.to_string());
}

/// Draws the pixel in the middle of a small scene.
fn draw(mut scene: Scene) {
    let triangles = |s: &Shape| match &s.geometry {
        Geometry::Mesh(mesh) => mesh.triangles.len(),
        Geometry::Sphere(_) => 1,
    };
    let shapes = scene.shapes.iter().chain(scene.groups.iter().flat_map(|g| &g.shapes));
    if shapes.map(triangles).sum::<usize>() + scene.instances.len() > MOST_DRAWN {
        return;
    }
    let film = &mut scene.camera.film;
    let window = film.window();
    film.crop = Some(Crop { x: window.x + window.width / 2, y: window.y + window.height / 2, width: 1, height: 1 });
    scene.integrator.max_depth = scene.integrator.max_depth.min(6);
    let settings = scene.integrator;
    let world = World::new(scene).expect("a scene that is loaded can be drawn");
    let tracer = PathTracer { settings, indirect_only: false };
    let picture = film::render(&world, &tracer, Budget::Samples(1), 0, &|_| ());
    assert!(picture.pixels.iter().all(|p| p.sum().is_finite()), "light that is not finite");
}
