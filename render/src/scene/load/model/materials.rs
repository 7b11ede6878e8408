//! Materials of MTL files as those of a scene.

use super::mtl::{self, Entry};
use crate::scene::load::error::{FileError, read_file};
use crate::scene::load::files::Folders;
use crate::scene::load::image::{self, Decoded, Images};
use crate::scene::{
    AreaEmitter, Bitmap, ColorTexture, FloatTexture, Interpolation, Material, MaterialId, Reading, Rgb, Scene, Stored,
    Texels, Texture, TextureId, Transfer, Wrap,
};
use glam::Affine2;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Larger files are refused.
const MAX_FILE: u64 = 1 << 28;

/// A material as shapes use it.
pub type Made = (MaterialId, Option<AreaEmitter>);

/// Materials by name, made where they are used.
pub struct Library<'a> {
    path: &'a Path,
    entries: HashMap<String, Entry>,
    made: HashMap<String, Made>,
    textures: HashMap<String, TextureId>,
    images: Images<PathBuf>,
    /// Files that were read.
    pub files: Vec<PathBuf>,
    skip_missing: bool,
}

impl<'a> Library<'a> {
    /// Reads the files that an OBJ file at `path` names. What is missing there is grey.
    pub fn new(
        path: &'a Path,
        files: &[String],
        skip_missing: bool,
        warnings: &mut Vec<String>,
    ) -> Result<Self, FileError> {
        let (entries, made, textures) = (HashMap::new(), HashMap::new(), HashMap::new());
        let mut library =
            Self { path, entries, made, textures, images: Images::new(skip_missing), files: Vec::new(), skip_missing };
        for name in files {
            let (found, folders) = (library.folders().resolve(path, name), library.folders());
            match read_file(&found, MAX_FILE) {
                Ok(bytes) => {
                    let (entries, ignored) = mtl::parse(&bytes, &found)?;
                    library.files.push(found.clone());
                    library.entries.extend(entries.into_iter().map(|e| (e.name.clone(), e)));
                    if !ignored.is_empty() {
                        let list = ignored.into_iter().collect::<Vec<_>>().join(", ");
                        warnings.push(format!("{}: not drawn: {list}", found.display()));
                    }
                }
                Err(e) if e.missing => {
                    warnings.push(format!("{}; its materials are grey", folders.advise(path, name, e)))
                }
                Err(e) => return Err(e),
            }
        }
        Ok(library)
    }

    fn folders(&self) -> Folders {
        Folders(vec![self.path.parent().unwrap_or(Path::new("")).into()])
    }

    /// Decodes together the images of the materials that will be asked for.
    pub fn announce<'n>(&mut self, names: impl Iterator<Item = &'n str>) {
        let maps = names.filter_map(|name| self.entries.get(name)?.diffuse_map.as_ref());
        let paths: Vec<PathBuf> = maps.map(|file| self.folders().resolve(self.path, file)).collect();
        self.images.announce(paths, |path| image::read(path));
    }

    /// The material of a name, made once; grey where there is none.
    pub fn material(&mut self, name: &str, scene: &mut Scene) -> Result<Made, FileError> {
        if let Some(made) = self.made.get(name) {
            return Ok(made.clone());
        }
        let entry = self.entries.get(name).cloned();
        let made = match &entry {
            Some(entry) => self.make(entry, scene)?,
            None => {
                (two_sided(Material::Diffuse { reflectance: ColorTexture::Constant(super::GREY) }, name, scene), None)
            }
        };
        self.made.insert(name.into(), made.clone());
        Ok(made)
    }

    fn make(&mut self, entry: &Entry, scene: &mut Scene) -> Result<Made, FileError> {
        let name = &entry.name;
        let color = |c: [f32; 3]| Rgb::from_array(c).min(Rgb::ONE);
        let (mut kd, mut ks) = (color(entry.diffuse), color(entry.specular));
        // No more light goes out than comes in.
        let most = (kd + ks).max_element().max(1.0);
        (kd, ks) = (kd / most, ks / most);
        let diffuse = match &entry.diffuse_map {
            // Some programs write a black colour beside a map.
            Some(file) => {
                let texture = self.texture(file, scene)?;
                ColorTexture::Scaled(texture, if kd == Rgb::ZERO { Rgb::ONE } else { kd })
            }
            None => ColorTexture::Constant(kd),
        };
        let glass = matches!(entry.model, 4 | 6 | 7 | 9) && entry.ior > 1.0;
        let mut id = if glass {
            let (reflectance, transmittance) = (ColorTexture::Constant(Rgb::ONE), ColorTexture::Constant(Rgb::ONE));
            push(Material::Dielectric { eta: entry.ior.min(10.0), reflectance, transmittance }, name, scene)
        } else if ks != Rgb::ZERO && entry.exponent > 0.0 {
            let exponent = FloatTexture::Constant(entry.exponent.min(1e5));
            two_sided(Material::Phong { diffuse, specular: ColorTexture::Constant(ks), exponent }, name, scene)
        } else {
            two_sided(Material::Diffuse { reflectance: diffuse }, name, scene)
        };
        if entry.opacity < 1.0 && !glass {
            id = push(Material::Mask { opacity: FloatTexture::Constant(entry.opacity), inner: id }, name, scene);
        }
        let radiance = Rgb::from_array(entry.emitted);
        let emitter = (radiance != Rgb::ZERO).then_some(AreaEmitter { radiance: ColorTexture::Constant(radiance) });
        Ok((id, emitter))
    }

    fn texture(&mut self, name: &str, scene: &mut Scene) -> Result<TextureId, FileError> {
        if let Some(&done) = self.textures.get(name) {
            return Ok(done);
        }
        let folders = self.folders();
        let path = folders.resolve(self.path, name);
        let read = self.images.get(&path, |path| image::read(path));
        let (width, height, texels) = match read {
            Ok(Decoded { raster, .. }) => {
                self.files.push(path);
                let transfer = if raster.is_display_referred() { Transfer::Srgb } else { Transfer::Linear };
                let (width, height) = (raster.width, raster.height);
                (width, height, Texels::Stored(Stored::new(raster, Reading::Color, transfer)))
            }
            Err(e) if e.missing && self.skip_missing => (1, 1, Texels::Rgb(vec![[0.5; 3]])),
            Err(e) if e.missing => {
                let e = folders.advise(self.path, name, e);
                return Err(e.advise("--skip-missing draws an even grey instead"));
            }
            Err(e) => return Err(e),
        };
        let (wrap, interpolation, second_uv) = ([Wrap::Repeat; 2], Interpolation::Bilinear, false);
        let to_uv = Affine2::IDENTITY;
        let bitmap = Bitmap { width, height, texels, wrap, interpolation, second_uv, to_uv };
        scene.textures.push(Texture::Bitmap(bitmap));
        let id = TextureId(scene.textures.len() as u32 - 1);
        self.textures.insert(name.into(), id);
        Ok(id)
    }
}

fn push(material: Material, name: &str, scene: &mut Scene) -> MaterialId {
    scene.materials.push(material);
    scene.material_names.push(name.into());
    MaterialId(scene.materials.len() as u32 - 1)
}

fn two_sided(material: Material, name: &str, scene: &mut Scene) -> MaterialId {
    let front = push(material, name, scene);
    push(Material::TwoSided { front, back: front }, name, scene)
}
