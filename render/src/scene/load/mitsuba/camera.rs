//! `sensor`, `film`, `rfilter`, `sampler`.

use super::Builder;
use super::object::Object;
use crate::scene::load::error::LoadError;
use crate::scene::load::similarity::similarity;
use crate::scene::{Camera, Crop, Film, Filter, FovAxis, Lens, Projection};
use glam::{DAffine3, DMat3, Vec2};

/// Larger films are refused.
const MAX_PIXELS: u64 = 1 << 28;

impl Builder<'_> {
    pub(super) fn sensor(&mut self, object: &Object) -> Result<(), LoadError> {
        match object.plugin.as_str() {
            "perspective" | "orthographic" => object.ignore(&["focus_distance"]),
            "thinlens" => {}
            other => {
                return Err(object.error(format!(
                    "the sensor `{other}` is not supported (only `perspective`, `thinlens` and `orthographic`)"
                )));
            }
        }
        object.ignore(&["shutter_open", "shutter_close"]);
        let objects = self.objects;
        let film = match object.children_of(objects, "film").next() {
            Some((film, _)) => self.film(&objects[film])?,
            None => Camera::default().film,
        };
        if let Some((sampler, _)) = object.children_of(objects, "sampler").next() {
            let sampler = &objects[sampler];
            self.scene.integrator.spp = sampler.count_or("sample_count", self.scene.integrator.spp)?;
            sampler.ignore(&["seed", "scramble", "dimension"]);
        }
        let to_world = object.transform("to_world")?;
        let aspect = f64::from(film.width) / f64::from(film.height);
        let parallel = object.plugin == "orthographic";
        let Placed { rotation, projection, depth, axis } = if parallel {
            orthographic(object, to_world.matrix3)?
        } else {
            perspective(object, to_world.matrix3, aspect)?
        };
        let shift = |name| object.number_or(name, 0.0).map(|v| v as f32);
        let (near, far) = (object.number_or("near_clip", 1e-2)? as f32, object.number_or("far_clip", 1e4)? as f32);
        if !(0.0 <= near && near < far) {
            return Err(object.error(format!("clip distances of {near} and {far}")));
        }
        let lens = if object.plugin == "thinlens" { lens(object, far)? } else { None };
        self.fov_axis = axis;
        self.scene.camera = Camera {
            to_world: DAffine3 { matrix3: rotation, translation: to_world.translation }.as_affine3a(),
            projection,
            near: near * depth,
            far: far + near * (depth - 1.0),
            principal_point: Vec2::new(shift("principal_point_offset_x")?, shift("principal_point_offset_y")?),
            lens,
            film,
        };
        Ok(())
    }

    fn film(&mut self, object: &Object) -> Result<Film, LoadError> {
        if !matches!(object.plugin.as_str(), "hdrfilm" | "ldrfilm") {
            self.warn(object, format_args!("`{}` is treated as `hdrfilm`", object.plugin));
        }
        object.ignore(&["file_format", "component_format", "banner", "attach_log", "high_quality_edges", "filename"]);
        if let Some(format) = object.text("pixel_format")?
            && !matches!(format.to_ascii_lowercase().as_str(), "rgb" | "rgba")
        {
            self.warn(object, format_args!("pixel format `{format}`: the picture is written as rgb"));
        }
        let (width, height) = (object.count_or("width", 768)?, object.count_or("height", 576)?);
        if u64::from(width) * u64::from(height) > MAX_PIXELS {
            return Err(object.error(format!("a film of {width} × {height} pixels")));
        }
        let (crop_width, crop_height) = (object.number("crop_width")?, object.number("crop_height")?);
        let crop = Crop {
            x: object.count_or("crop_offset_x", 0)?,
            y: object.count_or("crop_offset_y", 0)?,
            width: object.count_or("crop_width", width)?,
            height: object.count_or("crop_height", height)?,
        };
        let cropped = crop_width.is_some() || crop_height.is_some() || crop.x > 0 || crop.y > 0;
        let fits = |start: u32, size: u32, all: u32| size > 0 && u64::from(start) + u64::from(size) <= u64::from(all);
        if !fits(crop.x, crop.width, width) || !fits(crop.y, crop.height, height) {
            return Err(object.error(format!(
                "a picture of {} × {} pixels at ({}, {}) in a film of {width} × {height}",
                crop.width, crop.height, crop.x, crop.y
            )));
        }
        let objects = self.objects;
        let filter = match object.children_of(objects, "rfilter").next() {
            Some((filter, _)) => self.filter(&objects[filter])?,
            None => Filter::Gaussian { stddev: 0.5 },
        };
        Ok(Film { width, height, crop: cropped.then_some(crop), filter })
    }

    fn filter(&mut self, object: &Object) -> Result<Filter, LoadError> {
        let filter = match object.plugin.as_str() {
            "box" => Filter::Box { radius: object.number_or("radius", 0.5)? as f32 },
            "tent" => Filter::Tent { radius: object.number_or("radius", 1.0)? as f32 },
            "gaussian" => Filter::Gaussian { stddev: object.number_or("stddev", 0.5)? as f32 },
            other => {
                self.warn(object, format_args!("the filter `{other}` is not supported: a gaussian is used instead"));
                Filter::Gaussian { stddev: 0.5 }
            }
        };
        match filter {
            Filter::Box { radius: r } | Filter::Tent { radius: r } | Filter::Gaussian { stddev: r }
                if !(1e-3..=16.0).contains(&r) =>
            {
                Err(object.error(format!("a filter of {r} pixels (0.001 to 16 are accepted)")))
            }
            filter => Ok(filter),
        }
    }
}

/// What the transform of a sensor says.
struct Placed {
    rotation: DMat3,
    projection: Projection,
    /// Factor on the distance of the near plane.
    depth: f32,
    axis: FovAxis,
}

/// No ray depends on the frame's scale as long as it is the same along all axes.
fn perspective(object: &Object, matrix: DMat3, aspect: f64) -> Result<Placed, LoadError> {
    let (rotation, _) = similarity(matrix)
        .ok_or_else(|| object.error("the transform distorts: its axes must be orthogonal and of equal length"))?;
    let (fov_x, axis) = fov_x(object, aspect)?;
    Ok(Placed { rotation, projection: Projection::Perspective { fov_x: fov_x as f32 }, depth: 1.0, axis })
}

/// The film is 2 units of the frame wide: the scale of x and y sets what it shows, that of z moves the near plane
/// only, the far one staying as far behind it, as in Mitsuba.
fn orthographic(object: &Object, matrix: DMat3) -> Result<Placed, LoadError> {
    let (width, depth) = (matrix.x_axis.length(), matrix.z_axis.length());
    let cubic = DMat3::from_cols(matrix.x_axis, matrix.y_axis, matrix.z_axis * (width / depth));
    let (rotation, _) = similarity(cubic)
        .ok_or_else(|| object.error("the transform distorts: its axes must be orthogonal, x and y of equal length"))?;
    let projection = Projection::Orthographic { half_width: width as f32 };
    Ok(Placed { rotation, projection, depth: depth as f32, axis: FovAxis::X })
}

/// The lens of a `thinlens`, lengths in scene units; one that is not focused is sharp at the far plane, one without radius
/// everywhere, as in Mitsuba.
fn lens(object: &Object, far: f32) -> Result<Option<Lens>, LoadError> {
    let radius = object.number("aperture_radius")?;
    let radius = radius.ok_or_else(|| object.error("the parameter `aperture_radius` is missing"))? as f32;
    let focus = object.number_or("focus_distance", far.into())? as f32;
    match Lens::new(radius, focus) {
        None if radius != 0.0 || focus <= 0.0 => {
            Err(object.error(format!("an aperture radius of {radius} and a focus distance of {focus}")))
        }
        lens => Ok(lens),
    }
}

/// Horizontal field of view in radians from `fov` and `fov_axis`, or from `focal_length`, and the axis; `aspect` is width over
/// height.
fn fov_x(object: &Object, aspect: f64) -> Result<(f64, FovAxis), LoadError> {
    let fov = object.number("fov")?;
    let axis = match object.text("fov_axis")?.unwrap_or("x").to_ascii_lowercase().as_str() {
        "x" => FovAxis::X,
        "y" => FovAxis::Y,
        "diagonal" => FovAxis::Diagonal,
        "smaller" => FovAxis::Smaller,
        "larger" => FovAxis::Larger,
        other => return Err(object.error(format!("no such field of view axis: `{other}`"))),
    };
    // Half the extent of the picture along the axis, at distance 1.
    let (half, axis) = match fov {
        Some(degrees) if degrees > 0.0 && degrees < 180.0 => ((0.5 * degrees.to_radians()).tan(), axis),
        Some(degrees) => return Err(object.error(format!("a field of view of {degrees} degrees"))),
        None => {
            let text = object.text("focal_length")?.unwrap_or("50mm");
            let millimetres = text.trim().trim_end_matches("mm").trim().parse::<f64>();
            let millimetres = millimetres.ok().filter(|f| *f > 0.0 && f.is_finite());
            let millimetres = millimetres.ok_or_else(|| object.error(format!("a focal length of `{text}`")))?;
            // The diagonal of 35 mm film, 36 mm × 24 mm.
            (0.5 * 36f64.hypot(24.0) / millimetres, FovAxis::Diagonal)
        }
    };
    Ok((2.0 * axis.half_width(half, aspect).atan(), axis))
}
