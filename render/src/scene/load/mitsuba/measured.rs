//! `bsdf` plugin `measured`: data of a file, of any format that `brdf-tables` reads.

use super::Builder;
use super::object::Object;
use crate::scene::load::error::{FileError, LoadError};
use crate::scene::{ColorTexture, Material, Rgb};
use brdf_tables::measured::{self, Place};

impl Builder<'_> {
    /// The material of `filename`; the part that all directions share is the diffuse one.
    pub(super) fn measured(&mut self, object: &Object) -> Result<Material, LoadError> {
        let name = object.require_text("filename")?;
        let path = self.objects.path(object, name);
        let (reading, built) = measured::load(&path).map_err(|error| {
            let missing = !path.exists();
            let error = match error.place {
                Place::Line(line) => FileError::at(&path, line, error.what),
                Place::File => FileError { missing, ..FileError::new(&path, error.what) },
                Place::Byte(_) | Place::Field(_) => FileError::new(&path, measured::ReadError { file: None, ..error }),
            };
            self.objects.asset(object, name, error)
        })?;
        for note in reading.notes.iter().filter(|note| note.starts_with("anisotropic")) {
            self.warn(object, note);
        }
        self.files.push(path);
        let constant = |rgb: [f64; 3]| ColorTexture::Constant(Rgb::from_array(rgb.map(|x| x as f32)));
        let none = || object.error("`measured` has no specular part");
        let model = built.material.specular.ok_or_else(none)?;
        Ok(Material::Lobe { diffuse: constant(built.material.kd), specular: constant(built.material.ks), model })
    }
}
