//! The adaptive parametrisation of Dupuy and Jakob 2018, "An adaptive parameterization for efficient material acquisition and
//! rendering": what Mitsuba's plugin `measured` reads, and the database of RGL consists of.
//!
//! With u = (√(2θ/π), (φ + π)/2π) of a half vector, and the visible normals of the view that the file has as a density over u,
//! f_r cosθ = D(u) S(w) / 4 σ, where w is the point of the unit square that the density of visible normals takes to u: a smooth
//! S needs few numbers. All of that is tabulated over the azimuth and the zenith angle of the view. Here the view is `wo` and
//! the light `wi`; the plugin names them the other way.

mod tensor;
mod warp;

use super::{Format, Place, ReadError, Reading, Source, spectrum};
use core::f64::consts::{FRAC_2_PI, FRAC_PI_2, PI, TAU};
use glam::{DVec2, DVec3};
use tensor::Tensors;
use warp::Warp;

/// Most nodes of a parameter, of a side of a grid, and of wavelengths.
const MOST: usize = 4096;

/// A material in this parametrisation.
pub struct Rgl {
    ndf: Warp,
    sigma: Warp,
    vndf: Warp,
    luminance: Warp,
    /// S of the three channels.
    colors: [Warp; 3],
    isotropic: bool,
    /// How many times the measured azimuths repeat in a turn: 1, 2 or 4.
    repeats: u32,
    jacobian: bool,
    description: String,
    spectral: Option<usize>,
}

/// As [`Reading::from_bytes`] has it.
pub(super) fn reading(bytes: &[u8]) -> Result<Reading, ReadError> {
    let rgl = Rgl::read(bytes)?;
    let colors = match rgl.spectral {
        Some(count) => format!("{count} wavelengths, as linear sRGB under D65"),
        None => "RGB".into(),
    };
    let kind = if rgl.isotropic { "isotropic" } else { "anisotropic" };
    let mut notes =
        vec![format!("RGL: {kind}, {colors}{}{}", if rgl.description.is_empty() { "" } else { ": " }, rgl.description)];
    if !rgl.isotropic {
        notes.push(
            "anisotropic data: the mean over all azimuths is taken, as tables of measured values are isotropic".into(),
        );
    }
    Ok(Reading { format: Format::Rgl, source: Box::new(rgl), notes })
}

impl Rgl {
    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn read(bytes: &[u8]) -> Result<Self, ReadError> {
        let tensors = Tensors::new(bytes)?;
        let fail = |field: &str, what: String| ReadError::new(Place::Field(field.into()), what);
        // The views.
        let parameter = |name: &str| {
            let (_, values) = tensors.floats(name, 1)?;
            let rising = values.windows(2).all(|w| w[0] < w[1]);
            let valid = rising && (1..=MOST).contains(&values.len());
            if valid { Ok(values) } else { Err(fail(name, format!("1 to {MOST} rising numbers are needed"))) }
        };
        let (phi, theta) = (parameter("phi_i")?, parameter("theta_i")?);
        let isotropic = phi.len() <= 2;
        let span = f64::from(phi[phi.len() - 1] - phi[0]);
        // An isotropic material is the same turned by half: as the plugin does it, which is seen where σ depends on the azimuth.
        let repeats = if isotropic { 2 } else { (TAU / span).round().clamp(1.0, 4.0) as u32 };
        // Grids over the unit square.
        let grid = |name: &str, between: &[usize]| {
            let (shape, values) = tensors.floats(name, between.len() + 2)?;
            let (leading, sides) = shape.split_at(between.len());
            if leading != between {
                return Err(fail(
                    name,
                    format!("shape {shape:?} where the other fields ask for {between:?} and two more"),
                ));
            }
            if sides.iter().any(|n| !(2..=MOST).contains(n)) {
                return Err(fail(name, format!("a grid of {} × {} nodes", sides[0], sides[1])));
            }
            Ok(([sides[1], sides[0]], values))
        };
        let views = [phi.len(), theta.len()];
        let parameters = || vec![phi.clone(), theta.clone()];
        let plain = |name: &str| grid(name, &[]).map(|(size, values)| Warp::values(size, Vec::new(), values));
        let density = |name: &str| {
            let (size, values) = grid(name, &views)?;
            if let Some(at) = values.iter().position(|x| *x < 0.0) {
                return Err(fail(name, format!("number {at} is {}", values[at])));
            }
            Warp::density(size, parameters(), values).ok_or_else(|| fail(name, "a view whose density is zero".into()))
        };
        let (ndf, sigma, vndf, luminance) = (plain("ndf")?, plain("sigma")?, density("vndf")?, density("luminance")?);
        // S per channel.
        let spectral = !tensors.has("rgb");
        let (name, bands) = if spectral {
            let (_, wavelengths) = tensors.floats("wavelengths", 1)?;
            let wavelengths: Vec<f64> = wavelengths.into_iter().map(f64::from).collect();
            let rising = wavelengths.windows(2).all(|w| w[0] < w[1]);
            if !rising || !(1..=MOST).contains(&wavelengths.len()) {
                return Err(fail("wavelengths", format!("1 to {MOST} rising numbers are needed")));
            }
            ("spectra", spectrum::weights(&wavelengths))
        } else {
            ("rgb", vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
        };
        let (size, values) = grid(name, &[views[0], views[1], bands.len()])?;
        let nodes = size[0] * size[1];
        let color = |c: usize| {
            let mut channel = Vec::with_capacity(views[0] * views[1] * nodes);
            for view in values.chunks_exact(bands.len() * nodes) {
                for node in 0..nodes {
                    let sum: f64 =
                        bands.iter().enumerate().map(|(k, w)| w[c] * f64::from(view[k * nodes + node])).sum();
                    channel.push(sum as f32);
                }
            }
            Warp::values(size, parameters(), channel)
        };
        Ok(Self {
            colors: [color(0), color(1), color(2)],
            ndf,
            sigma,
            vndf,
            luminance,
            isotropic,
            repeats,
            jacobian: tensors.byte("jacobian").is_some_and(|j| j != 0),
            description: tensors.text("description").unwrap_or_default(),
            spectral: spectral.then_some(bands.len()),
        })
    }

    /// Whether values depend on the azimuths only through their difference.
    pub fn is_isotropic(&self) -> bool {
        self.isotropic
    }

    /// What the file says of itself.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// The view within the measured azimuths, and what both directions are multiplied by to get there.
    fn turned(&self, wo: DVec3) -> (DVec3, DVec3) {
        let sign = |x: f64| if x.is_sign_negative() { 1.0 } else { -1.0 };
        let flip = match self.repeats {
            1 => DVec3::ONE,
            4 => DVec3::new(sign(wo.x), sign(wo.y), 1.0),
            _ => DVec3::new(sign(wo.y), sign(wo.y), 1.0),
        };
        (wo * flip, flip)
    }

    fn view(&self, wo: DVec3) -> View {
        let (theta, phi) = (elevation(wo), wo.y.atan2(wo.x));
        View { phi, parameters: [phi as f32, theta as f32], u: unit(theta, phi) }
    }

    /// The point of a half vector.
    fn normal(&self, view: &View, m: DVec3) -> ([f32; 2], f64) {
        let (theta, phi) = (elevation(m), m.y.atan2(m.x));
        let mut u = unit(theta, if self.isotropic { phi - view.phi } else { phi });
        u[1] -= u[1].floor();
        (u, theta)
    }

    fn strength(&self, view: &View, u: [f32; 2], w: [f32; 2]) -> [f64; 3] {
        let scale = if self.jacobian {
            f64::from(self.ndf.eval(u, &[])) / (4.0 * f64::from(self.sigma.eval(view.u, &[]))).max(1e-20)
        } else {
            1.0
        };
        core::array::from_fn(|c| (f64::from(self.colors[c].eval(w, &view.parameters)) * scale).max(0.0))
    }

    /// f_r(wi, wo) cosθi in sr⁻¹, RGB; 0 where either direction is below the horizon.
    pub fn eval_cos(&self, wi: DVec3, wo: DVec3) -> [f64; 3] {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return [0.0; 3];
        }
        let (wo, flip) = self.turned(wo);
        let view = self.view(wo);
        let (u, _) = self.normal(&view, (wo + wi * flip).normalize());
        let (w, _) = self.vndf.invert(u, &view.parameters);
        self.strength(&view, u, w)
    }

    /// A direction `wi` for the point `u` of the unit square, drawn by luminance and visible normals, with
    /// f_r cosθi / [`Rgl::pdf`] and the density; `None` where it is below the horizon.
    pub fn sample(&self, wo: DVec3, u: DVec2) -> Option<(DVec3, [f64; 3], f64)> {
        if wo.z <= 0.0 {
            return None;
        }
        let (wo, flip) = self.turned(wo);
        let view = self.view(wo);
        let (w, chosen) = self.luminance.sample([u.y as f32, u.x as f32], &view.parameters);
        let (m, visible) = self.vndf.sample(w, &view.parameters);
        let theta = f64::from(m[0]).powi(2) * FRAC_PI_2;
        let phi = (2.0 * f64::from(m[1]) - 1.0) * PI + if self.isotropic { view.phi } else { 0.0 };
        let half = crate::frame::spherical(theta, phi);
        let wi = 2.0 * wo.dot(half) * half - wo;
        let density = f64::from(chosen * visible) / jacobian(f64::from(m[0]), theta, wo.dot(half));
        if wi.z <= 0.0 || density <= 0.0 {
            return None;
        }
        let value = self.strength(&view, m, w).map(|x| x / density);
        Some((wi * flip, value, density))
    }

    /// Density of [`Rgl::sample`] at `wi`, in sr⁻¹.
    pub fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let (wo, flip) = self.turned(wo);
        let view = self.view(wo);
        let half = (wo + wi * flip).normalize();
        let (u, theta) = self.normal(&view, half);
        let (w, visible) = self.vndf.invert(u, &view.parameters);
        let chosen = self.luminance.eval(w, &view.parameters);
        f64::from(chosen * visible) / jacobian(f64::from(u[0]), theta, wo.dot(half))
    }
}

/// What is known of a view.
struct View {
    phi: f64,
    parameters: [f32; 2],
    u: [f32; 2],
}

/// Zenith angle, with all digits near the normal.
fn elevation(w: DVec3) -> f64 {
    2.0 * (0.5 * (w - DVec3::Z).length()).min(1.0).asin()
}

fn unit(theta: f64, phi: f64) -> [f32; 2] {
    [(theta * FRAC_2_PI).sqrt() as f32, ((phi + PI) / TAU) as f32]
}

/// dωi over du.
fn jacobian(u: f64, theta: f64, cos: f64) -> f64 {
    (2.0 * PI * PI * u * theta.sin()).max(1e-6) * 4.0 * cos
}

impl Source for Rgl {
    fn rgb(&self, wi: DVec3, wo: DVec3) -> Option<[f64; 3]> {
        // The tabulated product vanishes with the cosine: both are taken a little above the horizon.
        const TURNS: usize = 16;
        let value = |wi: DVec3, wo: DVec3| self.eval_cos(wi, wo).map(|x| x / wi.z.max(1e-4));
        if self.isotropic {
            return Some(value(wi, wo));
        }
        let mut sum = [0.0; 3];
        for k in 0..TURNS {
            let (s, c) = (TAU * (k as f64 + 0.5) / TURNS as f64).sin_cos();
            let turn = |w: DVec3| DVec3::new(c * w.x - s * w.y, s * w.x + c * w.y, w.z);
            let rgb = value(turn(wi), turn(wo));
            (0..3).for_each(|c| sum[c] += rgb[c] / TURNS as f64);
        }
        Some(sum)
    }

    fn is_folded(&self) -> bool {
        false
    }
}
