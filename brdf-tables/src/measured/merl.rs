//! MERL: three 32-bit counts, then three channels of 64-bit numbers over √θh, θd and φd (Matusik, Pfister, Brand and McMillan
//! 2003, "A data-driven reflectance model").
//!
//! The counts are 90 × 90 × 180 in the files that are published; smaller ones are read too. A number is the mean of a bin, as
//! the look-up that comes with the files has it, and stands at the middle of the bin; between the middles logarithms are
//! interpolated. A number below zero means that the bin was not measured.

use super::{Format, Place, ReadError, Reading, Source};
use crate::brdf::angles;
use core::f64::consts::{FRAC_1_PI, FRAC_2_PI};
use glam::DVec3;

/// What the numbers of each channel are multiplied by.
const SCALE: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];
/// Most bins along each axis.
const MOST: [u32; 3] = [90, 90, 360];
/// What stands for zero, sr⁻¹: a logarithm needs some number.
const SMALLEST: f32 = 1e-9;

/// The data of a file.
struct Merl {
    bins: [usize; 3],
    /// Logarithms of the scaled numbers, three a bin; NaN where it was not measured.
    logs: Vec<[f32; 3]>,
}

/// The counts in the first twelve bytes, if they fit a file of `length` bytes.
pub fn check(head: &[u8], length: u64) -> Result<[usize; 3], ReadError> {
    let word = |k: usize| head.get(4 * k..4 * k + 4).and_then(|b| b.first_chunk()).map(|b| u32::from_le_bytes(*b));
    let mut bins = [0; 3];
    for (k, name) in ["θh", "θd", "φd"].into_iter().enumerate() {
        let count = word(k).ok_or_else(|| ReadError::new(Place::File, format!("{length} bytes are no MERL file")))?;
        if !(2..=MOST[k]).contains(&count) {
            let what = format!("{} bins of {name}, a MERL file has 2 to {}", count.cast_signed(), MOST[k]);
            return Err(ReadError::new(Place::Byte(4 * k as u64), what));
        }
        bins[k] = count as usize;
    }
    let expected = 12 + 24 * bins.iter().product::<usize>() as u64;
    if length != expected {
        let [h, d, p] = bins;
        let what = format!("{h} × {d} × {p} bins need {expected} bytes, the file has {length}");
        return Err(ReadError::new(Place::Byte(length.min(expected)), what));
    }
    Ok(bins)
}

/// Reads the bytes of a file.
pub fn read(bytes: &[u8]) -> Result<Reading, ReadError> {
    let bins = check(bytes, bytes.len() as u64)?;
    let count: usize = bins.iter().product();
    let mut logs = vec![[f32::NAN; 3]; count];
    let (numbers, _) = bytes[12..].as_chunks::<8>();
    for (i, number) in numbers.iter().enumerate() {
        let value = f64::from_le_bytes(*number);
        // Beyond 1e12 there is no reflectance that an instrument could see.
        if value.is_nan() || value.abs() > 1e12 {
            return Err(ReadError::new(Place::Byte(12 + 8 * i as u64), format!("{value} where a reflectance belongs")));
        }
        let (channel, bin) = (i / count, i % count);
        if value >= 0.0 {
            logs[bin][channel] = ((value * SCALE[channel]) as f32).max(SMALLEST).ln();
        }
    }
    if logs.iter().flatten().all(|x| x.is_nan() || *x <= SMALLEST.ln()) {
        return Err(ReadError::new(Place::File, "no value is above zero"));
    }
    let unmeasured = logs.iter().filter(|rgb| rgb.iter().any(|x| x.is_nan())).count();
    let [h, d, p] = bins;
    let notes = vec![
        format!("MERL: {h} × {d} × {p} bins of √θh, θd and φd, {unmeasured} of them not measured"),
        "logarithms are interpolated between the middles of the bins; both mirror images are averaged".into(),
    ];
    Ok(Reading { format: Format::Merl, source: Box::new(Merl { bins, logs }), notes })
}

/// The azimuth of the difference about the half vector in [0, π): the same for exchanged directions.
fn azimuth(wi: DVec3, wo: DVec3, folded: f64) -> f64 {
    let (sum, difference) = (wi + wo, wi - wo);
    // Along increasing azimuth of the half vector, and against the normal: both parts of the difference.
    let around = difference.dot(DVec3::new(-sum.y, sum.x, 0.0));
    let along = -difference.z;
    if (around < 0.0) != (along < 0.0) { core::f64::consts::PI - folded } else { folded }
}

impl Source for Merl {
    fn rgb(&self, wi: DVec3, wo: DVec3) -> Option<[f64; 3]> {
        let [theta_h, theta_d, folded] = angles(wi, wo);
        let x = [(theta_h * FRAC_2_PI).sqrt(), theta_d * FRAC_2_PI, azimuth(wi, wo, folded) * FRAC_1_PI];
        let mut low = [[0; 2]; 3];
        let mut way = [0.0; 3];
        for k in 0..3 {
            let bins = self.bins[k];
            let at = x[k] * bins as f64 - 0.5;
            if k == 2 {
                // Half a turn is an exchange of the directions: the last bin is beside the first.
                let floor = at.floor();
                let first = (floor as i64).rem_euclid(bins as i64) as usize;
                (low[k], way[k]) = ([first, (first + 1) % bins], at - floor);
            } else {
                let at = at.clamp(0.0, (bins - 1) as f64);
                let first = (at as usize).min(bins - 2);
                (low[k], way[k]) = ([first, first + 1], at - first as f64);
            }
        }
        let (mut sum, mut weights) = ([0.0; 3], 0.0);
        for corner in 0..8 {
            let up = [corner >> 2 & 1, corner >> 1 & 1, corner & 1];
            let weight: f64 = (0..3).map(|k| if up[k] == 1 { way[k] } else { 1.0 - way[k] }).product();
            let [h, d, p] = core::array::from_fn(|k| low[k][up[k]]);
            let logs = self.logs[(h * self.bins[1] + d) * self.bins[2] + p];
            if weight > 0.0 && logs.iter().all(|x| !x.is_nan()) {
                (0..3).for_each(|c| sum[c] += weight * f64::from(logs[c]));
                weights += weight;
            }
        }
        (weights > 1e-3).then(|| sum.map(|x| (x / weights).exp()))
    }

    fn is_folded(&self) -> bool {
        false
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::brdf::directions;
    use core::f64::consts::{FRAC_PI_2, PI};

    /// The bytes of a file of a function.
    pub fn write(bins: [usize; 3], value: impl Fn(DVec3, DVec3) -> [f64; 3]) -> Vec<u8> {
        let mut bytes: Vec<u8> = bins.iter().flat_map(|n| (*n as u32).to_le_bytes()).collect();
        for (channel, scale) in SCALE.into_iter().enumerate() {
            for h in 0..bins[0] {
                for d in 0..bins[1] {
                    for p in 0..bins[2] {
                        let x = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
                        let h = x(h, bins[0]).powi(2) * FRAC_PI_2;
                        let (wi, wo) = directions([h, x(d, bins[1]) * FRAC_PI_2, x(p, bins[2]) * PI]);
                        let lit = wi.z > 0.0 && wo.z > 0.0;
                        let number = if lit { value(wi, wo)[channel] / scale } else { -1.0 };
                        bytes.extend(number.to_le_bytes());
                    }
                }
            }
        }
        bytes
    }

    /// What was written at the middles of bins is read there, channel by channel, with the azimuth on its own side.
    #[test]
    fn bins_are_read_where_they_stand() {
        let value = |wi: DVec3, wo: DVec3| {
            let side = (wi - wo).dot(DVec3::new(-(wi + wo).y, (wi + wo).x, 0.0)) * (wo - wi).z;
            [0.1, 0.2, if side < 0.0 { 0.3 } else { 0.6 }]
        };
        let reading = read(&write([10, 9, 36], value)).unwrap();
        for (h, d, p) in [(3.5, 2.5, 4.5), (6.5, 1.5, 30.5), (1.5, 4.5, 20.5)] {
            let (wi, wo) = directions([(h / 10.0f64).powi(2) * FRAC_PI_2, d / 9.0 * FRAC_PI_2, p / 36.0 * PI]);
            let (found, right) = (reading.source.rgb(wi, wo).unwrap(), value(wi, wo));
            assert!((0..3).all(|c| (found[c] / right[c] - 1.0).abs() < 1e-5), "{p}: {found:?} {right:?}");
            assert_eq!(reading.source.rgb(wo, wi), Some(found));
        }
    }

    #[test]
    fn bad_files_are_refused_with_their_place() {
        let good = write([4, 4, 4], |_, _| [0.1; 3]);
        assert!(read(&good).is_ok());
        let error = |bytes: &[u8]| read(bytes).err().unwrap().to_string();
        let with = |at: usize, with: &[u8]| {
            let mut bytes = good.clone();
            bytes[at..at + with.len()].copy_from_slice(with);
            bytes
        };
        assert!(error(&good[..5]).contains("no MERL file"));
        assert!(error(&good[..good.len() - 3]).contains("need 1548 bytes, the file has 1545"));
        assert!(error(&with(0, &(-1i32).to_le_bytes())).contains("byte 0: -1 bins of θh"));
        assert!(error(&with(8, &1_000_000u32.to_le_bytes())).contains("byte 8: 1000000 bins of φd"));
        assert!(error(&with(20, &f64::NAN.to_le_bytes())).contains("byte 20: NaN"));
        assert!(error(&with(28, &1e300f64.to_le_bytes())).contains("byte 28: "));
    }
}
