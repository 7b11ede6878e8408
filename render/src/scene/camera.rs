//! The camera and its film.

use glam::{Affine3A, DAffine3, DMat3, DVec3, Vec2};
use serde::{Deserialize, Serialize};

/// A camera. In its own frame it looks along +z with y up and +x to the **left** of the picture (Mitsuba's frame), so a loader of a
/// format that looks along −z with x to the right turns it by half a turn about y.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Camera frame to world; its axes are of unit length, and orthogonal but for glTF's cameras that hang on what is
    /// stretched.
    pub to_world: Affine3A,
    /// What rays the film sends out.
    pub projection: Projection,
    /// Depth along the axis in front of which nothing is seen.
    pub near: f32,
    /// Depth along the axis behind which nothing is seen.
    pub far: f32,
    /// Shift of the film against the optical axis as a fraction of the whole film's width and height, right and down
    /// positive: what lies on the axis appears that much to the left of, and above, the middle of the film (as in
    /// Mitsuba 3).
    pub principal_point: Vec2,
    /// What makes a perspective camera see one distance sharp; `None` sees everything sharp.
    pub lens: Option<Lens>,
    /// Pixels and filter.
    pub film: Film,
}

/// A thin lens in the plane z = 0 of the camera's frame (Mitsuba's `thinlens`): all rays of a point of the film start on a disk about
/// the origin and meet again at the focus distance. What lies at depth z has a blur of radius R·|1/f − 1/z| in tangents of
/// the angle of view.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Lens {
    /// Radius R of the disk in scene units, > 0: half the focal length over the f-number.
    pub radius: f32,
    /// Depth f along the axis of the plane that is sharp, scene units, > 0.
    pub focus: f32,
}

impl Lens {
    /// A lens, if both lengths are finite and > 0, and the radius is no more than 1000 times the focus distance.
    pub fn new(radius: f32, focus: f32) -> Option<Self> {
        let size = |x: f32| x > 0.0 && x.is_finite();
        (size(radius) && size(focus) && radius <= 1000.0 * focus).then_some(Self { radius, focus })
    }
}

/// The rays of a camera. Pixels are squares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Projection {
    /// All through one point, the origin of the camera's frame.
    Perspective {
        /// Angle in radians between the left and the right edge of the whole film (loaders convert other axes).
        fov_x: f32,
    },
    /// All parallel to the axis, from the plane z = 0 of the camera's frame.
    Orthographic {
        /// Half the width that the whole film shows, in scene units.
        half_width: f32,
    },
}

/// Along which axis of the film an angle of view is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FovAxis {
    /// From left to right.
    #[default]
    X,
    /// From top to bottom.
    Y,
    /// From corner to corner.
    Diagonal,
    /// The shorter of width and height.
    Smaller,
    /// The longer of them.
    Larger,
}

impl FovAxis {
    /// Half the width of the picture at distance 1, from `half` its extent along this axis; `aspect` is width over height.
    pub fn half_width(self, half: f64, aspect: f64) -> f64 {
        match self {
            Self::X => half,
            Self::Y => half * aspect,
            Self::Diagonal => half / (1.0 + 1.0 / (aspect * aspect)).sqrt(),
            Self::Smaller if aspect > 1.0 => half * aspect,
            Self::Larger if aspect <= 1.0 => half * aspect,
            Self::Smaller | Self::Larger => half,
        }
    }

    /// Horizontal angle of view, in radian as `fov` along this axis.
    pub fn fov_x(self, fov: f64, aspect: f64) -> f64 {
        2.0 * self.half_width((0.5 * fov).tan(), aspect).atan()
    }
}

impl Camera {
    /// Camera frame to world of a camera at `eye` that sees `look` in its middle and `up` upwards; `None` where they leave it open.
    pub fn look_at(eye: DVec3, look: DVec3, up: DVec3) -> Option<Affine3A> {
        let forward = (look - eye).try_normalize()?;
        let left = up.try_normalize()?.cross(forward);
        let left = if left.length() > 1e-9 { left.normalize() } else { return None };
        let rotation = DMat3::from_cols(left, forward.cross(left), forward);
        let to_world = DAffine3 { matrix3: rotation, translation: eye }.as_affine3a();
        to_world.is_finite().then_some(to_world)
    }
}

/// The pixel grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Film {
    /// Width of the whole film in pixels.
    pub width: u32,
    /// Height of the whole film in pixels.
    pub height: u32,
    /// The part to render; the picture has its size.
    pub crop: Option<Crop>,
    /// Pixel reconstruction filter.
    pub filter: Filter,
}

impl Film {
    /// Largest width or height that is asked for.
    pub const MAX_SIZE: u32 = 1 << 15;

    /// Sets the size; one number alone keeps the aspect. A new size drops the crop, whose pixels are others.
    pub fn resize(&mut self, width: Option<u32>, height: Option<u32>) {
        let scaled = |x: u32, to: u32, from: u32| {
            let rounded = (u64::from(x) * u64::from(to) + u64::from(from) / 2) / u64::from(from);
            rounded.clamp(1, u64::from(Self::MAX_SIZE)) as u32
        };
        let (width, height) = match (width, height) {
            (None, None) => (self.width, self.height),
            (Some(w), Some(h)) => (w, h),
            (Some(w), None) => (w, scaled(self.height, w, self.width)),
            (None, Some(h)) => (scaled(self.width, h, self.height), h),
        };
        if (width, height) != (self.width, self.height) {
            (self.width, self.height, self.crop) = (width, height, None);
        }
    }

    /// The same view in at most so many pixels along its longer side; a part of it grows to whole pixels.
    pub fn at_most(&self, longest: u32) -> Self {
        let from = self.width.max(self.height);
        if from <= longest {
            return self.clone();
        }
        let scale = |x: u32| f64::from(x) * f64::from(longest) / f64::from(from);
        let size = |x: u32| (scale(x).round() as u32).max(1);
        let (width, height) = (size(self.width), size(self.height));
        let part = |start: u32, length: u32, whole: u32| {
            let first = (scale(start) as u32).min(whole - 1);
            (first, (scale(start + length).ceil() as u32).clamp(first + 1, whole) - first)
        };
        let crop = self.crop.map(|c| {
            let ((x, width), (y, height)) = (part(c.x, c.width, width), part(c.y, c.height, height));
            Crop { x, y, width, height }
        });
        Self { width, height, crop, ..self.clone() }
    }
}

/// A rectangle of pixels inside the film.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Crop {
    /// First column.
    pub x: u32,
    /// First row, from the top.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// Pixel reconstruction filter, separable; lengths in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Filter {
    /// 1 within `radius` (0.5: the pixel).
    Box {
        /// Half width.
        radius: f32,
    },
    /// Falls linearly to 0 at `radius`.
    Tent {
        /// Half width.
        radius: f32,
    },
    /// Gaussian cut off, and lowered to 0, at 4 standard deviations.
    Gaussian {
        /// Standard deviation.
        stddev: f32,
    },
}

impl Film {
    /// The part to render: the crop, or everything.
    pub fn window(&self) -> Crop {
        self.crop.unwrap_or(Crop { x: 0, y: 0, width: self.width, height: self.height })
    }
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            to_world: Affine3A::IDENTITY,
            projection: Projection::Perspective { fov_x: 50f32.to_radians() },
            near: 1e-2,
            far: 1e4,
            principal_point: Vec2::ZERO,
            lens: None,
            film: Film { width: 768, height: 576, crop: None, filter: Filter::Gaussian { stddev: 0.5 } },
        }
    }
}
