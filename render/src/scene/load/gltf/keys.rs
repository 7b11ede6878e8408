//! Curves through keys (glTF 2.0, appendix C).

use glam::DQuat;
use serde::Deserialize;

/// What is between two keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum Interpolation {
    Step,
    #[default]
    Linear,
    CubicSpline,
}

/// Values of a property over time.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Seconds, in order; at least one.
    times: Vec<f32>,
    /// For each key a value or, of a spline, the tangent before it, the value, and the tangent after it.
    values: Vec<f32>,
    /// Numbers in a value.
    width: usize,
    interpolation: Interpolation,
}

impl Curve {
    /// `width` is measured where it is `None`.
    ///
    /// # Errors
    /// What is wrong with the keys.
    pub fn new(
        times: Vec<f32>,
        values: Vec<f32>,
        width: Option<usize>,
        interpolation: Interpolation,
    ) -> Result<Self, String> {
        if times.is_empty() {
            return Err("no keys".into());
        }
        if times.iter().chain(&values).any(|x| !x.is_finite()) {
            return Err("a time or value is not finite".into());
        }
        if !times.is_sorted() {
            return Err("the times of the keys do not increase".into());
        }
        let per_value = times.len() * if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let width = width.unwrap_or(values.len() / per_value);
        if values.len() != per_value * width {
            return Err(format!("{} numbers for {} keys", values.len(), times.len()));
        }
        Ok(Self { times, values, width, interpolation })
    }

    /// Time of the last key.
    pub fn end(&self) -> f32 {
        self.times.last().copied().unwrap_or_default()
    }

    /// The key before a time, the one after it, and where between them the time is, from 0 to 1.
    fn keys(&self, time: f32) -> (usize, usize, f64) {
        let after = self.times.partition_point(|t| *t <= time);
        let (from, to) = (after.saturating_sub(1), after.min(self.times.len() - 1));
        let [start, end, time] = [self.times[from], self.times[to], time].map(f64::from);
        (from, to, if from < to { (time - start) / (end - start) } else { 0.0 })
    }

    /// A part of a key: 0 is its value; of a spline, −1 is the tangent before it and 1 the one after it.
    fn part(&self, key: usize, part: isize) -> impl Iterator<Item = f64> + '_ {
        let block = match self.interpolation {
            Interpolation::CubicSpline => (3 * key + 1).wrapping_add_signed(part),
            Interpolation::Step | Interpolation::Linear => key,
        };
        self.values[block * self.width..][..self.width].iter().map(|x| f64::from(*x))
    }

    /// The value at a time, each number for itself.
    pub fn at(&self, time: f32) -> Vec<f64> {
        let (from, to, t) = self.keys(time);
        match self.interpolation {
            Interpolation::Step => self.part(from, 0).collect(),
            Interpolation::Linear => self.part(from, 0).zip(self.part(to, 0)).map(|(a, b)| a + (b - a) * t).collect(),
            Interpolation::CubicSpline => {
                // Tangents are per second.
                let seconds = f64::from(self.times[to]) - f64::from(self.times[from]);
                let (t2, t3) = (t * t, t * t * t);
                let points = self.part(from, 0).zip(self.part(to, 0));
                let tangents = self.part(from, 1).zip(self.part(to, -1));
                let hermite = |((a, b), (out, into)): ((f64, f64), (f64, f64))| {
                    (2.0 * t3 - 3.0 * t2 + 1.0) * a
                        + (3.0 * t2 - 2.0 * t3) * b
                        + seconds * ((t3 - 2.0 * t2 + t) * out + (t3 - t2) * into)
                };
                points.zip(tangents).map(hermite).collect()
            }
        }
    }

    /// The value at a time of a curve of quaternions: of unit length, but for a value of length zero.
    pub fn rotation_at(&self, time: f32) -> DQuat {
        let unit = |x: Vec<f64>| {
            let rotation = DQuat::from_slice(&x);
            let length = rotation.length();
            if length > 0.0 { rotation / length } else { rotation }
        };
        match self.interpolation {
            Interpolation::Linear => {
                let (from, to, t) = self.keys(time);
                // Along the shorter arc.
                unit(self.part(from, 0).collect()).slerp(unit(self.part(to, 0).collect()), t)
            }
            Interpolation::Step | Interpolation::CubicSpline => unit(self.at(time)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use std::f64::consts::FRAC_PI_2;

    fn near(found: &[f64], right: &[f64]) {
        let near = found.len() == right.len() && found.iter().zip(right).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(near, "{found:?}, right {right:?}");
    }

    fn curve(times: &[f32], values: &[f32], width: usize, interpolation: Interpolation) -> Curve {
        Curve::new(times.to_vec(), values.to_vec(), Some(width), interpolation).unwrap()
    }

    #[test]
    fn steps_and_lines() {
        let keys = (&[1.0, 2.0, 4.0], &[1.0, 10.0, 3.0, 30.0, 7.0, 70.0]);
        let (step, linear) =
            (curve(keys.0, keys.1, 2, Interpolation::Step), curve(keys.0, keys.1, 2, Interpolation::Linear));
        for (time, on_step, on_line) in [
            (-1.0, 1.0, 1.0),
            (1.0, 1.0, 1.0),
            (1.5, 1.0, 2.0),
            (2.0, 3.0, 3.0),
            (3.0, 3.0, 5.0),
            (4.0, 7.0, 7.0),
            (9.0, 7.0, 7.0),
        ] {
            near(&step.at(time), &[on_step, 10.0 * on_step]);
            near(&linear.at(time), &[on_line, 10.0 * on_line]);
        }
    }

    #[test]
    fn splines_are_cubic_polynomials_in_seconds() {
        // x(s) = s³ − 2s between 1 and 3 seconds, x' = 3s² − 2, with tangents that nobody looks at on both ends.
        let spline = curve(&[1.0, 3.0], &[9.0, -1.0, 1.0, 25.0, 21.0, 9.0], 1, Interpolation::CubicSpline);
        for s in [1.0f64, 1.25, 2.0, 2.9, 3.0] {
            near(&spline.at(s as f32), &[(s as f32 as f64).powi(3) - 2.0 * (s as f32 as f64)]);
        }
        near(&spline.at(0.0), &[-1.0]);
        near(&spline.at(5.0), &[21.0]);
    }

    #[test]
    fn rotations_turn_evenly_along_the_shorter_arc() {
        let half = (0.5f32).sqrt();
        // A quarter turn about z, written as the quaternion on the other side, of twice the length.
        let turn =
            curve(&[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -2.0 * half, -2.0 * half], 4, Interpolation::Linear);
        for t in [0.0f32, 0.25, 0.5, 1.0] {
            let (sine, cosine) = (f64::from(t) * FRAC_PI_2).sin_cos();
            near(&(turn.rotation_at(t) * DVec3::X).to_array(), &[cosine, sine, 0.0]);
        }
        let zeros = [0.0; 4];
        let spline = [&zeros[..], &[0.0, 0.0, 0.0, 1.0], &zeros, &zeros, &[0.0, 0.0, 1.0, 0.0], &zeros].concat();
        let middle = curve(&[0.0, 1.0], &spline, 4, Interpolation::CubicSpline).rotation_at(0.5);
        near(&middle.to_array(), &[0.0, 0.0, half.into(), half.into()]);
    }

    #[test]
    fn keys_that_are_none() {
        let new = |times: &[f32], values: &[f32]| {
            Curve::new(times.to_vec(), values.to_vec(), Some(1), Interpolation::Linear).unwrap_err()
        };
        assert_eq!(new(&[], &[]), "no keys");
        assert_eq!(new(&[1.0, 0.0], &[1.0, 2.0]), "the times of the keys do not increase");
        assert_eq!(new(&[0.0, 1.0], &[1.0]), "1 numbers for 2 keys");
        assert_eq!(new(&[0.0], &[f32::NAN]), "a time or value is not finite");
        // Two keys at one time: a jump.
        let jump = curve(&[0.0, 1.0, 1.0, 2.0], &[0.0, 1.0, 5.0, 6.0], 1, Interpolation::Linear);
        near(&[jump.at(0.5)[0], jump.at(1.0)[0], jump.at(1.5)[0]], &[0.5, 5.0, 5.5]);
    }
}
