//! `emitter`: lights without a surface, the environment, and the light that shapes give off.

use super::Builder;
use super::object::Object;
use super::texture::{own_transfer, transfer};
use crate::image::Pixels;
use crate::scene::load::error::LoadError;
use crate::scene::load::image;
use crate::scene::load::similarity::similarity;
use crate::scene::{
    AreaEmitter, Bitmap, ColorTexture, Environment, EnvironmentMap, Falloff, Interpolation, Light, Rgb, Rows, Texels,
    Wrap,
};
use glam::DAffine3;

impl Builder<'_> {
    /// An emitter at the top level.
    pub(super) fn emitter(&mut self, object: &Object) -> Result<(), LoadError> {
        object.ignore(&["sampling_weight"]);
        let to_world = object.transform("to_world")?;
        let mut color = |name| self.even_color(object, name);
        match object.plugin.as_str() {
            "point" => {
                let position = object.vector("position")?.unwrap_or(to_world.translation).as_vec3a();
                let intensity = color("intensity")?;
                self.scene.lights.push(Light::Point { position, intensity });
            }
            "spot" => self.spot(object, to_world)?,
            "directional" => {
                let direction = object.vector("direction")?.unwrap_or(to_world.matrix3.z_axis).try_normalize();
                let direction = direction.ok_or_else(|| object.error("the direction is zero"))?.as_vec3a();
                let irradiance = color("irradiance")?;
                self.scene.lights.push(Light::Directional { direction, irradiance });
            }
            "constant" => {
                let environment = Environment::Constant(color("radiance")?);
                self.set_environment(object, environment)?;
            }
            "envmap" => {
                let environment = self.environment_map(object, to_world)?;
                self.set_environment(object, environment)?;
            }
            other => return Err(object.error(format!("the emitter `{other}` is not supported"))),
        }
        Ok(())
    }

    fn set_environment(&mut self, object: &Object, environment: Environment) -> Result<(), LoadError> {
        if let Some(sky) = self.sky {
            let own = object.text("filename")?.map(|name| format!(" ({name})")).unwrap_or_default();
            let what = format!("the scene has this sky of its own{own}, so that --env {sky} cannot be used");
            return Err(object.error(what));
        }
        if self.scene.environment.replace(environment).is_some() {
            return Err(object.error("a scene has one environment, and this is the second"));
        }
        Ok(())
    }

    fn spot(&mut self, object: &Object, to_world: DAffine3) -> Result<(), LoadError> {
        if object.child_named("texture").is_some() {
            return Err(object.error("spot lights with a texture are not supported"));
        }
        let cutoff = object.number_or("cutoff_angle", 20.0)?;
        let beam = object.number_or("beam_width", 0.75 * cutoff)?;
        if !(0.0 < cutoff && cutoff <= 180.0 && (0.0..=cutoff).contains(&beam)) {
            return Err(object.error(format!("a beam of {beam} degrees inside a cone of {cutoff}")));
        }
        let direction = to_world.matrix3.z_axis.normalize().as_vec3a();
        let intensity = self.even_color(object, "intensity")?;
        self.scene.lights.push(Light::Spot {
            position: to_world.translation.as_vec3a(),
            direction,
            intensity,
            beam: beam.to_radians() as f32,
            cutoff: cutoff.to_radians() as f32,
            falloff: Falloff::Linear,
        });
        Ok(())
    }

    fn environment_map(&mut self, object: &Object, to_world: DAffine3) -> Result<Environment, LoadError> {
        object.ignore(&["cache"]);
        let scale = object.number_or("scale", 1.0)?;
        if scale < 0.0 {
            return Err(object.error(format!("a scale of {scale}")));
        }
        let (rotation, _) = similarity(to_world.matrix3)
            .ok_or_else(|| object.error("the transform distorts: its axes must be orthogonal and of equal length"))?;
        let name = object.require_text("filename")?;
        let transfer = transfer(object, false)?;
        let path = self.objects.path(object, name);
        let pixels = image::read(&path);
        let Pixels { raster, warnings, .. } = pixels.map_err(|error| self.objects.asset(object, name, error))?;
        self.files.push(path);
        self.warn_of(object, name, &warnings);
        let transfer = transfer.unwrap_or_else(|| own_transfer(&raster));
        let decoded = raster.pixels().map(|[r, g, b, _]| [r, g, b].map(|c| transfer.decode(c)));
        let mut texels: Vec<[f32; 3]> = decoded.collect();
        // Resampled high dynamic range images often ring below zero.
        let negative = texels.iter_mut().flatten().filter(|c| **c < 0.0).map(|c| *c = 0.0).count();
        if negative > 0 {
            self.warn(object, format_args!("{negative} negative values of {name} became 0"));
        }
        let image = Bitmap {
            width: raster.width,
            height: raster.height,
            texels: Texels::Rgb(texels),
            wrap: [Wrap::Repeat; 2],
            second_uv: false,
            interpolation: Interpolation::Bilinear,
            to_uv: glam::Affine2::IDENTITY,
        };
        let to_world = rotation.as_mat3().into();
        Ok(Environment::Map(EnvironmentMap { image, to_world, scale: scale as f32, rows: Rows::Poles }))
    }

    /// The emitter of a shape.
    pub(super) fn area_emitter(&mut self, object: &Object) -> Result<AreaEmitter, LoadError> {
        if object.plugin != "area" {
            return Err(object.error(format!("the emitter `{}` cannot belong to a shape", object.plugin)));
        }
        object.ignore(&["sampling_weight"]);
        let radiance = self.color_texture(object, "radiance", ColorTexture::Constant(Rgb::ONE))?;
        Ok(AreaEmitter { radiance })
    }
}
