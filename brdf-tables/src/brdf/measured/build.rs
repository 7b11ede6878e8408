//! From any function of two directions to a measured material.

use super::lattice::Shape;
use super::{Data, Measured, coordinates, data, sampler};
use crate::brdf::Specular;
use crate::material::Material;
use core::f64::consts::{FRAC_PI_2, PI};
use glam::DVec3;

/// The lattice that values are taken at: θh in halves of the bins of MERL, θd to a degree, and twelve steps to the horizon.
/// Coarser ones are chosen among its divisions.
const FINEST: [usize; 3] = [181, 91, 13];
/// Divisions of the axes of the finest lattice, from the coarsest.
const STEPS: [&[usize]; 3] = [&[6, 4, 3, 2, 1], &[5, 3, 2, 1], &[6, 4, 3, 2, 1]];
/// The same for colours.
const TINT_STEPS: [&[usize]; 3] = [&[36, 12, 6, 2], &[18, 6, 3, 2], &[12, 6, 3]];
/// A coarser lattice is good enough when this part of the nodes left out is met to within that fraction.
const QUANTILE: f64 = 0.95;
const TOLERANCE: f64 = 0.005;
/// Part of the smallest value that is split off as the diffuse part: not all of it, so that the logarithm of the rest, which is
/// what the lattice holds, stays finite.
const DIFFUSE: f64 = 0.9;
/// Colours whose channels are apart by less than this fraction are grey.
const GREY: f64 = 1e-4;

/// A material, and what became of the values on the way.
#[derive(Clone, Copy, Debug)]
pub struct Built {
    /// Diffuse part, and [`Specular::Measured`].
    pub material: Material,
    /// Nodes of the finest lattice, and how many of them had no value and took one from their neighbours.
    pub nodes: (usize, usize),
    /// Relative difference of the lattice from the function at directions between its nodes: median and 95th percentile.
    pub difference: [f64; 2],
}

/// Why a function makes no material.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// It has no value for any pair of directions above the horizon.
    #[error("there is no value above the horizon")]
    Empty,
    /// A value is negative or not finite.
    #[error("f_r is {value} at θh {:.3}, θd {:.3}, φd {:.3} rad", angles[0], angles[1], angles[2])]
    Number {
        /// The value.
        value: f64,
        /// Where.
        angles: [f64; 3],
    },
    /// All values are zero, or beyond what the lattice holds.
    #[error("the largest f_r is {0} sr⁻¹, outside 1e-12 to 1e12")]
    Range(f64),
    /// The name cannot be kept.
    #[error("{0}")]
    Name(&'static str),
}

/// Makes a material of `value`: f_r in sr⁻¹, RGB, of two directions above the horizon, or `None` where it is not known, which
/// takes a value from its neighbours. Values are averaged over both mirror images and over the exchange of the two directions,
/// unless the function is `folded`: the same for all of these.
/// `name` is kept with it: its first 64 letters, digits and `._-`.
///
/// # Errors
/// The function has no values, or values that are no reflectance.
pub fn build(
    name: &str,
    is_folded: bool,
    value: impl Fn(DVec3, DVec3) -> Option<[f64; 3]>,
) -> Result<Built, BuildError> {
    let fine = Shape::new(FINEST).expect("the finest lattice is one");
    let folded = |angles: [f64; 3]| -> Result<Option<[f64; 3]>, BuildError> {
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        let images = [angles[2], PI - angles[2], -angles[2], angles[2] - PI];
        for &phi in if is_folded { &images[..1] } else { &images[..] } {
            let (wi, wo) = coordinates::directions([angles[0], angles[1], phi]);
            if wi.z <= 0.0 || wo.z <= 0.0 {
                continue;
            }
            if let Some(rgb) = value(wi, wo) {
                if let Some(value) = rgb.into_iter().find(|x| !(x.is_finite() && *x >= 0.0)) {
                    return Err(BuildError::Number { value, angles });
                }
                (0..3).for_each(|c| sum[c] += rgb[c]);
                count += 1.0;
            }
        }
        Ok((count > 0.0).then(|| sum.map(|x| x / count)))
    };

    // The values at all nodes, and how many had none.
    let angles = |at: [usize; 3]| coordinates::node(fine.coordinates(at));
    let mut values = (0..fine.len()).map(|i| folded(angles(fine.place(i)))).collect::<Result<Vec<_>, _>>()?;
    let nodes = (fine.len(), values.iter().filter(|value| value.is_none()).count());

    // Split off the diffuse part, and carry the rest on to where there is none.
    let measured = || values.iter().flatten();
    let smallest: [f64; 3] = core::array::from_fn(|c| measured().map(|rgb| rgb[c]).fold(f64::INFINITY, f64::min));
    if measured().next().is_none() {
        return Err(BuildError::Empty);
    }
    let kd = smallest.map(|x| (DIFFUSE * PI * x).min(1.0));
    for rgb in values.iter_mut().flatten() {
        (0..3).for_each(|c| rgb[c] -= kd[c] / PI);
    }
    let largest = values.iter().flatten().map(mean).fold(0.0, f64::max);
    if !(1e-12..=1e12).contains(&largest) {
        return Err(BuildError::Range(largest));
    }
    let floor = largest * (-data::OCTAVES).exp2();
    let rest = fill(&fine, &values, floor);

    // Grey values on the coarsest lattice that is good enough.
    // What is carried on does not pass what is there.
    let logs: Vec<f64> = rest.iter().map(|rgb| mean(rgb).clamp(floor, largest).log2()).collect();
    let error = |a: &f64, b: &f64| (a - b).abs() * core::f64::consts::LN_2;
    let mix = |corners: &[(usize, f64); 8], of: &[f64]| corners.iter().map(|&(i, w)| w * of[i]).sum::<f64>();
    let (shape, picked) = coarsest(&fine, &STEPS, &logs, mix, error);
    let (low, high) = picked.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &x| (a.min(x), b.max(x)));
    let step = (high - low).max(1e-9) / 65535.0;
    let quantized = picked.iter().map(|x| ((x - low) / step).round().clamp(0.0, 65535.0) as u16).collect();

    // Colours likewise.
    let tints: Vec<[f64; 3]> = rest.iter().map(|rgb| tint(rgb, floor)).collect();
    let colored = tints.iter().flatten().any(|t| (t - 1.0).abs() > GREY);
    let (tint_lattice, tint) = if colored {
        let apart = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max);
        let mix = |corners: &[(usize, f64); 8], of: &[[f64; 3]]| {
            core::array::from_fn(|c| corners.iter().map(|&(i, w)| w * of[i][c]).sum())
        };
        let (shape, picked) = coarsest(&fine, &TINT_STEPS, &tints, mix, apart);
        let channel = |t: f64| (t / 3.0 * 65535.0).round().clamp(0.0, 65535.0) as u16;
        (Some(counts(&shape)), picked.into_iter().flatten().map(channel).collect())
    } else {
        (None, Vec::new())
    };

    let name: String = name.chars().filter(|c| c.is_alphanumeric() || "._-".contains(*c)).take(64).collect();
    let name = if name.len() > 64 { name.chars().filter(char::is_ascii).collect() } else { name };
    let range = [low, low + 65535.0 * step];
    let stored = |(alpha, share): (f64, f64)| data::Stored {
        name: name.clone(),
        lattice: counts(&shape),
        range,
        values: Vec::clone(&quantized),
        tint_lattice,
        tint: Vec::clone(&tint),
        alpha,
        share,
    };
    // The sampler is fitted to what will be looked up.
    let bare = Data::new(stored((0.5, 0.5))).map_err(BuildError::Name)?;
    let fitted = sampler::fit(|wi, wo| bare.value(coordinates::unit(wi.to_array(), wo.to_array())));
    let measured = Measured(data::keep(Data::new(stored(fitted)).map_err(BuildError::Name)?));
    let material = Material { kd, ks: [1.0; 3], specular: Some(Specular::Measured(measured)) };
    Ok(Built { material, nodes, difference: difference(&material, &folded)? })
}

fn mean(rgb: &[f64; 3]) -> f64 {
    (rgb[0] + rgb[1] + rgb[2]) / 3.0
}

/// Channels over their mean.
fn tint(rgb: &[f64; 3], floor: f64) -> [f64; 3] {
    let mean = mean(rgb);
    if mean > floor { rgb.map(|x| x / mean) } else { [1.0; 3] }
}

fn counts(shape: &Shape) -> [u16; 3] {
    shape.nodes().map(|n| n as u16)
}

/// The values with those that are not known carried on: along the last coordinate, from where both directions are equally far
/// from the horizon up to it, by the slope of the logarithm between the last two that are known; a whole row that is not known
/// is the row before it.
fn fill(shape: &Shape, values: &[Option<[f64; 3]>], floor: f64) -> Vec<[f64; 3]> {
    let [rows, columns, depth] = shape.nodes();
    let mut filled = vec![[0.0; 3]; values.len()];
    let mut last = None;
    for row in 0..rows * columns {
        let start = row * depth;
        let known = &values[start..start + depth];
        // At the end of a row of θd begins one of another θh: it continues what stands above it.
        let before = if row % columns == 0 && row > 0 { Some(start - columns * depth) } else { last };
        let out: Vec<[f64; 3]> = match known.iter().position(Option::is_some) {
            None => match before {
                Some(before) => filled[before..before + depth].to_vec(),
                None => vec![*values.iter().flatten().next().unwrap_or(&[floor; 3]); depth],
            },
            Some(first) => {
                let mut out = vec![known[first].unwrap_or([floor; 3]); depth];
                for p in first + 1..depth {
                    out[p] = known[p].unwrap_or_else(|| {
                        let (last, before) = (out[p - 1], out[p.saturating_sub(2)]);
                        core::array::from_fn(|c| last[c] * (last[c].max(floor) / before[c].max(floor)).clamp(0.5, 2.0))
                    });
                }
                out
            }
        };
        filled[start..start + depth].copy_from_slice(&out);
        last = Some(start);
    }
    filled
}

/// The smallest division of a lattice whose interpolation meets the nodes left out, and what it holds.
fn coarsest<T: Copy>(
    fine: &Shape,
    steps: &[&[usize]; 3],
    values: &[T],
    mix: impl Fn(&[(usize, f64); 8], &[T]) -> T,
    error: impl Fn(&T, &T) -> f64,
) -> (Shape, Vec<T>) {
    let mut divisions: Vec<(Shape, [usize; 3])> = Vec::new();
    for &h in steps[0] {
        for &d in steps[1] {
            divisions.extend(steps[2].iter().filter_map(|&p| Some((fine.every([h, d, p])?, [h, d, p]))));
        }
    }
    divisions.sort_by_key(|(shape, _)| shape.len());
    let last = divisions.len() - 1;
    for (i, (shape, steps)) in divisions.into_iter().enumerate() {
        let picked = fine.pick(values, steps, &shape);
        if i == last {
            return (shape, picked);
        }
        // A part of the nodes will do to tell: a stride that shares no factor with the lattice.
        let mut errors: Vec<f64> = (0..fine.len())
            .step_by(7)
            .map(|i| error(&mix(&shape.corners(fine.coordinates(fine.place(i))), &picked), &values[i]))
            .collect();
        errors.sort_by(f64::total_cmp);
        if errors.get((errors.len() as f64 * QUANTILE) as usize).is_some_and(|&e| e <= TOLERANCE) {
            return (shape, picked);
        }
    }
    unreachable!("the last division is returned")
}

/// Relative difference of a material from a function of the angles, at points between the nodes: a sequence that fills the cube
/// evenly (Roberts 2018).
fn difference(
    material: &Material,
    value: &impl Fn([f64; 3]) -> Result<Option<[f64; 3]>, BuildError>,
) -> Result<[f64; 2], BuildError> {
    let mut errors = Vec::new();
    for i in 0..4000 {
        let [h, d, p] = [0.819_172_5, 0.671_043_6, 0.549_700_5].map(|a: f64| (0.5 + f64::from(i) * a).fract());
        let angles = [h * h * FRAC_PI_2, d * FRAC_PI_2, p * FRAC_PI_2];
        let (wi, wo) = coordinates::directions(angles);
        if wi.z < 0.02 || wo.z < 0.02 {
            continue;
        }
        if let Some(rgb) = value(angles)? {
            let found = material.eval(wi, wo);
            let apart = (0..3).map(|c| (found[c] - rgb[c]).abs()).fold(0.0, f64::max);
            errors.push(apart / mean(&rgb).max(1e-12));
        }
    }
    errors.sort_by(f64::total_cmp);
    let at = |q: f64| errors.get((errors.len() as f64 * q) as usize).copied().unwrap_or(0.0);
    Ok([at(0.5), at(0.95)])
}
