//! `render info`.

use super::reading::Reading;
use anyhow::{Context, Result};
use render::integrator::cached::policy::{approximation, outlook};
use render::scene::load::{self, Loaded};
use render::scene::{
    ColorTexture, Environment, Geometry, Lens, Light, Material, Projection, Scene, Shape, Texels, Texture,
};
use serde::Serialize;
use std::collections::HashSet;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

/// Arguments of `render info`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene: Mitsuba XML or glTF; or a model (OBJ, PLY, STL), for a quick look.
    scene: PathBuf,
    /// Print as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    reading: Reading,
}

/// What a scene holds.
#[derive(Serialize)]
struct Report {
    cameras: Vec<CameraInfo>,
    picture: Picture,
    lamps: Vec<Lamp>,
    sky: Option<String>,
    meshes: Vec<MeshInfo>,
    triangles: usize,
    instances: usize,
    materials: Vec<MaterialInfo>,
    textures: Vec<TextureInfo>,
    texture_bytes: usize,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct CameraInfo {
    /// Of the node, and of the camera; or the id of the sensor.
    names: Vec<String>,
    takes_picture: bool,
}

#[derive(Serialize)]
struct Picture {
    width: u32,
    height: u32,
    /// In degrees, of a perspective camera.
    fov_x: Option<f32>,
    position: [f32; 3],
    lens: Option<LensInfo>,
}

/// In scene units.
#[derive(Serialize)]
struct LensInfo {
    radius: f32,
    focus: f32,
}

#[derive(Serialize)]
struct Lamp {
    kind: &'static str,
    /// W·sr⁻¹, or W·m⁻² of a directional one.
    strength: [f32; 3],
    position: Option<[f32; 3]>,
    direction: Option<[f32; 3]>,
}

#[derive(Serialize)]
struct MeshInfo {
    triangles: usize,
    material: String,
    /// Radiance, or its factor on a texture.
    emits: Option<[f32; 3]>,
    /// How often it is drawn.
    placements: usize,
}

#[derive(Serialize)]
struct MaterialInfo {
    name: String,
    model: String,
    /// How `--method auto` finds its indirect light.
    auto: String,
    /// What records take it for, where that is not quite what it is.
    approximated: Option<&'static str>,
}

#[derive(Serialize)]
struct TextureInfo {
    width: u32,
    height: u32,
    /// Other textures may share them.
    bytes: usize,
}

/// Loads, prints.
pub fn run(args: &Args) -> Result<ExitCode> {
    let report = Report::new(load::open(&args.scene, &args.reading.options()?)?);
    let text = if args.json { serde_json::to_string_pretty(&report)? + "\n" } else { report.text() };
    // A reader that has seen enough is no error.
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(e).context("standard output"),
        _ => Ok(ExitCode::SUCCESS),
    }
}

impl Report {
    fn new(loaded: Loaded) -> Self {
        let Loaded { scene, warnings, cameras, camera, .. } = loaded;
        let named = |(i, names)| CameraInfo { names, takes_picture: camera == Some(i) };
        let mesh = |shape: &Shape, placements| MeshInfo {
            triangles: match &shape.geometry {
                Geometry::Mesh(mesh) => mesh.triangles.len(),
                Geometry::Sphere(_) => 0,
            },
            material: scene.material_names.get(shape.material.0 as usize).cloned().unwrap_or_default(),
            emits: shape.emitter.as_ref().map(|e| match e.radiance {
                ColorTexture::Constant(c) | ColorTexture::Scaled(_, c) | ColorTexture::Painted(_, c) => c.to_array(),
                ColorTexture::Texture(_) => [1.0; 3],
            }),
            placements,
        };
        let mut placements = vec![0; scene.groups.len()];
        scene.instances.iter().for_each(|i| placements[i.group as usize] += 1);
        let groups = scene.groups.iter().zip(&placements);
        let grouped = groups.flat_map(|(group, n)| group.shapes.iter().map(|shape| mesh(shape, *n)));
        let meshes: Vec<_> = scene.shapes.iter().map(|shape| mesh(shape, 1)).chain(grouped).collect();
        let textures: Vec<_> = scene.textures.iter().map(texture).collect();
        let film = scene.camera.film.window();
        Self {
            cameras: cameras.into_iter().enumerate().map(named).collect(),
            picture: Picture {
                width: film.width,
                height: film.height,
                fov_x: match scene.camera.projection {
                    Projection::Perspective { fov_x } => Some(fov_x.to_degrees()),
                    Projection::Orthographic { .. } => None,
                },
                position: scene.camera.to_world.translation.to_array(),
                lens: scene.camera.lens.map(|Lens { radius, focus }| LensInfo { radius, focus }),
            },
            lamps: scene.lights.iter().map(lamp).collect(),
            sky: scene.environment.as_ref().map(|sky| match sky {
                Environment::Constant(c) => format!("radiance {} {} {}", c.x, c.y, c.z),
                Environment::Map(map) => format!("{} × {} pixels", map.image.width, map.image.height),
            }),
            triangles: meshes.iter().map(|m| m.triangles * m.placements).sum(),
            instances: scene.instances.len(),
            materials: materials(&scene),
            texture_bytes: texture_bytes(&scene),
            meshes,
            textures,
            warnings,
        }
    }

    fn text(&self) -> String {
        let mut out = String::new();
        let mut line = |what: &str, text: String| {
            let _ = writeln!(out, "{what:10}{text}");
        };
        for (i, CameraInfo { names, takes_picture }) in self.cameras.iter().enumerate() {
            line(
                "camera",
                format!(
                    "{i} {}{}",
                    if names.is_empty() { "unnamed".into() } else { names.join(" / ") },
                    if *takes_picture { " (takes the picture)" } else { "" }
                ),
            );
        }
        let Picture { width, height, fov_x, position: [x, y, z], ref lens } = self.picture;
        let view = fov_x.map_or("orthographic".into(), |fov| format!("{fov:.2}° across"));
        line("picture", format!("{width} × {height} pixels, {view}, from {x:.4} {y:.4} {z:.4}"));
        if let Some(LensInfo { radius, focus }) = lens {
            line("lens", format!("of radius {radius}, sharp at {focus}"));
        }
        for Lamp { kind, strength: [r, g, b], position, direction } in &self.lamps {
            let place = |what: &str, p: &Option<[f32; 3]>| {
                p.map_or(String::new(), |[x, y, z]| format!(", {what} {x:.3} {y:.3} {z:.3}"))
            };
            line(
                "lamp",
                format!("{kind} {r:.4} {g:.4} {b:.4}{}{}", place("at", position), place("towards", direction)),
            );
        }
        line("sky", self.sky.clone().unwrap_or_else(|| "none".into()));
        let emitting = self.meshes.iter().filter(|m| m.emits.is_some()).count();
        let (count, triangles, instances) = (self.meshes.len(), self.triangles, self.instances);
        line("shapes", format!("{count} ({emitting} emit light), {instances} instances, {triangles} triangles drawn"));
        for MaterialInfo { name, model, auto, approximated } in &self.materials {
            let approximated = approximated.map_or(String::new(), |what| format!("; in records {what}"));
            line("material", format!("{name}: {model}, {auto}{approximated}"));
        }
        for TextureInfo { width, height, bytes } in &self.textures {
            line("texture", format!("{width} × {height} pixels, {} KB", bytes.div_ceil(1000)));
        }
        line("textures", format!("{}, {} KB", self.textures.len(), self.texture_bytes.div_ceil(1000)));
        for warning in &self.warnings {
            line("warning", warning.clone());
        }
        out
    }
}

fn lamp(light: &Light) -> Lamp {
    let (kind, strength, position, direction) = match light {
        Light::Point { position, intensity } => ("point", intensity, Some(position), None),
        Light::Spot { position, direction, intensity, .. } => ("spot", intensity, Some(position), Some(direction)),
        Light::Directional { direction, irradiance } => ("directional", irradiance, None, Some(direction)),
    };
    let (position, direction) = (position.map(|p| p.to_array()), direction.map(|d| d.to_array()));
    Lamp { kind, strength: strength.to_array(), position, direction }
}

/// Those that scatter; what masks, blends and bends them is left out.
fn materials(scene: &Scene) -> Vec<MaterialInfo> {
    let named = scene.materials.iter().enumerate().filter(|(_, m)| m.children().next().is_none());
    let info = |(i, material): (usize, &Material)| {
        let debug = format!("{material:?}");
        let auto = outlook(material);
        let recorded = !auto.starts_with("path traced");
        MaterialInfo {
            name: scene.material_names.get(i).filter(|n| !n.is_empty()).cloned().unwrap_or(format!("material {i}")),
            model: debug.split([' ', '(']).next().unwrap_or_default().into(),
            approximated: approximation(material).filter(|_| recorded),
            auto,
        }
    };
    named.map(info).collect()
}

/// Images that textures share count once.
fn texture_bytes(scene: &Scene) -> usize {
    let mut shared = HashSet::new();
    let bitmaps = scene.textures.iter().filter_map(|t| if let Texture::Bitmap(b) = t { Some(&b.texels) } else { None });
    let counted = bitmaps.filter(|texels| match texels {
        Texels::Stored(stored) => shared.insert(Arc::as_ptr(stored.raster())),
        _ => true,
    });
    counted.map(Texels::bytes).sum()
}

fn texture(texture: &Texture) -> TextureInfo {
    match texture {
        Texture::Bitmap(b) => TextureInfo { width: b.width, height: b.height, bytes: b.texels.bytes() },
        Texture::Checkerboard { .. } => TextureInfo { width: 2, height: 2, bytes: 0 },
    }
}
