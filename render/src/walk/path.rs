//! The way of a camera: what it is in every frame.

use super::names::{LAST_FRAME, MAX_FRAMES};
use crate::scene::checksum::Hash;
use crate::scene::{Camera, FovAxis, Projection};
use core::ops::RangeInclusive;
use glam::DVec3;
use std::collections::BTreeMap;

/// A row of a path: where the camera is in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Place of the eye.
    pub eye: DVec3,
    /// A point in the middle of the picture.
    pub look: DVec3,
    /// What is up in the picture.
    pub up: DVec3,
    /// Angle of view along the axis that the scene names, degrees; `None` keeps that of the scene.
    pub fov: Option<f64>,
    /// Scene units that the width of the film shows, where rays are parallel; `None` keeps that of the scene.
    pub width: Option<f64>,
}

/// Cameras of frames that follow each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Walk {
    first: u32,
    cameras: Vec<Camera>,
}

impl Walk {
    /// From one camera for every frame.
    ///
    /// # Errors
    /// No frames, or too many.
    pub fn new(first: u32, cameras: Vec<Camera>) -> Result<Self, String> {
        if cameras.is_empty() {
            return Err("there is no frame".into());
        }
        if cameras.len() > MAX_FRAMES || first as usize + cameras.len() > LAST_FRAME as usize + 1 {
            return Err(format!("more than {MAX_FRAMES} frames, or a number above {LAST_FRAME}"));
        }
        Ok(Self { first, cameras })
    }

    /// From rows by the number of their frame: between them eye, look and up follow Catmull-Rom splines, and the angle of view a
    /// straight line, along `axis` of a film whose width is `aspect` times its height. All else is that of `camera`.
    ///
    /// # Errors
    /// One line with the frame in which there is no such camera.
    pub fn through(rows: &BTreeMap<u32, Row>, camera: &Camera, axis: FovAxis, aspect: f64) -> Result<Self, String> {
        let (Some((&first, _)), Some((&last, _))) = (rows.first_key_value(), rows.last_key_value()) else {
            return Err("there is no row".into());
        };
        if (last - first) as usize >= MAX_FRAMES || last > LAST_FRAME {
            return Err(format!("more than {MAX_FRAMES} frames, or a number above {LAST_FRAME}"));
        }
        let keys: Vec<(u32, Row)> = rows.iter().map(|(frame, row)| (*frame, *row)).collect();
        let at = |frame: u32| {
            camera_at(&row_at(&keys, frame), camera, axis, aspect).map_err(|what| format!("frame {frame}: {what}"))
        };
        Self::new(first, (first..=last).map(at).collect::<Result<_, _>>()?)
    }

    /// Numbers of its frames.
    pub fn frames(&self) -> RangeInclusive<u32> {
        self.first..=self.first + (self.cameras.len() as u32 - 1)
    }

    /// The camera of a frame; `None` outside of the path.
    pub fn camera(&self, frame: u32) -> Option<&Camera> {
        self.cameras.get(frame.checked_sub(self.first)? as usize)
    }

    /// Changes every camera.
    pub fn change(&mut self, change: impl FnMut(&mut Camera)) {
        self.cameras.iter_mut().for_each(change);
    }

    /// Tells whether a walk is the same.
    pub fn checksum(&self) -> u64 {
        let mut hash = Hash::default();
        hash.encoded(&(self.first, &self.cameras));
        hash.finish()
    }
}

/// The row of a frame between or at those of `keys`.
fn row_at(keys: &[(u32, Row)], frame: u32) -> Row {
    let after = keys.partition_point(|(key, _)| *key <= frame).min(keys.len() - 1);
    let before = after.saturating_sub(1);
    let ((start, a), (end, b)) = (keys[before], keys[after]);
    if start == end || frame >= end {
        return b;
    }
    if frame == start {
        return a;
    }
    let (length, t) = (f64::from(end - start), f64::from(frame - start) / f64::from(end - start));
    // Tangents at keys: the slope between their neighbours, whatever the distances; at the ends that of the one neighbour.
    let slope = |key: usize, of: fn(&Row) -> DVec3| {
        let (i, j) = (key.saturating_sub(1), (key + 1).min(keys.len() - 1));
        (of(&keys[j].1) - of(&keys[i].1)) / f64::from(keys[j].0 - keys[i].0)
    };
    let spline = |of: fn(&Row) -> DVec3| {
        let (t2, t3) = (t * t, t * t * t);
        of(&a) * (2.0 * t3 - 3.0 * t2 + 1.0)
            + slope(before, of) * (length * (t3 - 2.0 * t2 + t))
            + of(&b) * (3.0 * t2 - 2.0 * t3)
            + slope(after, of) * (length * (t3 - t2))
    };
    let line = |of: fn(&Row) -> Option<f64>| of(&a).zip(of(&b)).map(|(a, b)| a + (b - a) * t);
    let (fov, width) = (line(|r| r.fov), line(|r| r.width));
    Row { eye: spline(|r| r.eye), look: spline(|r| r.look), up: spline(|r| r.up), fov, width }
}

/// A camera that stands at a row.
fn camera_at(row: &Row, camera: &Camera, axis: FovAxis, aspect: f64) -> Result<Camera, String> {
    let Row { eye, look, up, fov, width } = *row;
    let to_world = Camera::look_at(eye, look, up);
    let to_world = to_world.ok_or("the camera looks nowhere: eye and look are one, or up is along the view")?;
    let projection = match (fov, camera.projection) {
        _ if width.is_some_and(|width| !(width > 0.0 && (width as f32).is_normal())) => {
            return Err("a width that is not positive".into());
        }
        (Some(degrees), _) if !(degrees > 0.0 && degrees < 180.0) => {
            return Err(format!("a field of view of {degrees} degrees"));
        }
        (Some(degrees), Projection::Perspective { .. }) => {
            Projection::Perspective { fov_x: axis.fov_x(degrees.to_radians(), aspect) as f32 }
        }
        (Some(_), Projection::Orthographic { .. }) => return Err("an orthographic camera has no field of view".into()),
        (None, Projection::Perspective { .. }) if width.is_some() => {
            return Err("a perspective camera has a field of view, no width".into());
        }
        (None, Projection::Orthographic { half_width }) => {
            Projection::Orthographic { half_width: width.map_or(half_width, |width| (0.5 * width) as f32) }
        }
        (None, projection) => projection,
    };
    Ok(Camera { to_world, projection, ..camera.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(x: f64) -> Row {
        let (eye, look) = (DVec3::new(x, 0.0, 4.0), DVec3::new(x, 0.0, 0.0));
        Row { eye, look, up: DVec3::Y, fov: Some(30.0 + x), width: None }
    }

    fn eye(walk: &Walk, frame: u32) -> f32 {
        walk.camera(frame).unwrap().to_world.translation.x
    }

    #[test]
    fn splines_pass_the_rows_smoothly() {
        let rows = BTreeMap::from([(1, row(0.0)), (5, row(4.0)), (9, row(8.0)), (19, row(0.0))]);
        let walk = Walk::through(&rows, &Camera::default(), FovAxis::X, 1.5).unwrap();
        assert_eq!(walk.frames(), 1..=19);
        for (frame, x) in [(1, 0.0), (3, 2.0), (5, 4.0), (9, 8.0), (19, 0.0)] {
            assert!((eye(&walk, frame) - x).abs() < 1e-5, "{frame}: {}", eye(&walk, frame));
        }
        // Without a kink at a row: straight lines would have steps of 1 and −0.8 on both sides of it.
        let steps = [eye(&walk, 9) - eye(&walk, 8), eye(&walk, 10) - eye(&walk, 9)];
        assert!((steps[0] - steps[1]).abs() < 0.8, "{steps:?}");
        let Projection::Perspective { fov_x } = walk.camera(3).unwrap().projection else { panic!() };
        assert!((fov_x.to_degrees() - 32.0).abs() < 1e-4);
        assert!(walk.camera(0).is_none() && walk.camera(20).is_none());
        let one = Walk::through(&BTreeMap::from([(7, row(1.0))]), &Camera::default(), FovAxis::Y, 1.5).unwrap();
        assert_eq!((one.frames(), eye(&one, 7)), (7..=7, 1.0));
        assert_ne!(one.checksum(), walk.checksum());
    }

    #[test]
    fn rows_without_a_camera_are_named() {
        let bad = |rows: &[(u32, Row)]| {
            Walk::through(&rows.iter().copied().collect(), &Camera::default(), FovAxis::X, 1.5).unwrap_err()
        };
        assert!(bad(&[(1, row(0.0)), (4, Row { look: DVec3::new(0.0, 0.0, 4.0), ..row(0.0) })]).starts_with("frame 4"));
        assert!(bad(&[(3, Row { up: DVec3::Z, ..row(0.0) })]).starts_with("frame 3"));
        assert!(bad(&[(3, Row { fov: Some(180.0), ..row(0.0) })]).contains("180"));
        assert!(bad(&[(3, Row { fov: None, width: Some(2.0), ..row(0.0) })]).contains("no width"));
        assert!(bad(&[(3, Row { fov: None, width: Some(-1.0), ..row(0.0) })]).contains("not positive"));
        assert!(bad(&[(0, row(0.0)), (u32::MAX, row(1.0))]).contains("frames"));
        assert!(bad(&[]).contains("no row"));
    }
}
