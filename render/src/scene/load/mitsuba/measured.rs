//! `bsdf` plugin `measured`: data of a file, of any format that `brdf-tables` reads.

use super::Builder;
use super::object::Object;
use crate::scene::checksum::Hash;
use crate::scene::load::error::{FileError, LoadError};
use crate::scene::{ColorTexture, Function, Material, Reflection, Rgb};
use brdf_tables::measured::rgl::Rgl;
use brdf_tables::measured::{Format, Place, ReadError, Reading};
use glam::{Vec2, Vec3A};
use std::path::Path;
use std::sync::Arc;

/// Anisotropic data in the parametrisation of RGL.
struct Adaptive(Rgl);

impl std::fmt::Debug for Adaptive {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "Adaptive({})", self.0.description())
    }
}

impl Reflection for Adaptive {
    fn eval(&self, wi: Vec3A, wo: Vec3A) -> (Rgb, f32) {
        let [wi, wo] = [wi, wo].map(|w| w.as_dvec3());
        let f = self.0.eval_cos(wi, wo).map(|x| (x / wi.z) as f32);
        (Rgb::from_array(f), self.0.pdf(wi, wo) as f32)
    }

    fn sample(&self, wo: Vec3A, u: Vec2) -> Option<Vec3A> {
        self.0.sample(wo.as_dvec3(), u.as_dvec2()).map(|(wi, ..)| wi.as_vec3a())
    }
}

impl Builder<'_> {
    /// The material of `filename`: that of a table, whose part that all directions share is the diffuse one, or anisotropic data as
    /// they are.
    pub(super) fn measured(&mut self, object: &Object) -> Result<Material, LoadError> {
        let name = object.require_text("filename")?;
        let path = self.objects.path(object, name);
        let material = read(&path).map_err(|error| {
            let missing = !path.exists();
            let error = match error.place {
                Place::Line(line) => FileError::at(&path, line, error.what),
                Place::File => FileError { missing, ..FileError::new(&path, error.what) },
                Place::Byte(_) | Place::Field(_) => FileError::new(&path, ReadError { file: None, ..error }),
            };
            self.objects.asset(object, name, error)
        })?;
        self.files.push(path);
        material.ok_or_else(|| object.error("`measured` has no specular part"))
    }
}

/// The material of a file; `None` of one without a specular part.
fn read(path: &Path) -> Result<Option<Material>, ReadError> {
    let (format, bytes) = Reading::bytes(path)?;
    if format == Format::Rgl {
        let rgl = Rgl::read(&bytes)?;
        if !rgl.is_isotropic() {
            let mut hash = Hash::default();
            hash.bytes(&bytes);
            let function = Function::new(hash.finish(), Arc::new(Adaptive(rgl)));
            return Ok(Some(Material::Function { function }));
        }
    }
    let name = path.file_name().and_then(|n| n.to_str()).unwrap_or("measured");
    let built = Reading::from_bytes(format, &bytes)?.material(name)?.material;
    let constant = |rgb: [f64; 3]| ColorTexture::Constant(Rgb::from_array(rgb.map(|x| x as f32)));
    let (diffuse, specular) = (constant(built.kd), constant(built.ks));
    Ok(built.specular.map(|model| Material::Lobe { diffuse, specular, model }))
}
