//! Caps and directions to the eye, as arrays that are broadcast against each other.

use crate::arrays::{Input, Numbers, Vectors, View, common_shape, require_room};
use crate::error::bad;
use brdf_tables::cap::{Cap, UNIT};
use brdf_tables::{CapBatch, CapError};
use glam::{DVec3, Vec3};
use ndarray::{ArrayD, Axis};
use pyo3::prelude::*;

/// Caps that are looked up at a time: few enough that they stay in the nearest cache.
const BLOCK: usize = 512;

/// The arrays of a call, held for reading.
struct Arrays<'py> {
    axis: Input<'py>,
    solid_angle: Input<'py>,
    wo: Input<'py>,
}

/// Arrays of a common shape of two dimensions or more, the one along which caps are best taken together last.
pub struct Question<'a> {
    axis: View<'a>,
    solid_angle: View<'a>,
    wo: View<'a>,
    /// Lengths after the exchange.
    shape: Vec<usize>,
    /// The two dimensions that were exchanged.
    swapped: (usize, usize),
    /// Dimensions of length one that were put before those of the caller.
    added: usize,
}

/// What is wrong, and with which element.
pub struct Refused {
    what: String,
    place: Vec<usize>,
}

impl Refused {
    /// As an exception.
    pub fn exception(self) -> PyErr {
        bad(if self.place.is_empty() { self.what } else { format!("at {:?}: {}", self.place, self.what) })
    }
}

/// Answers a question of arguments of Python, which are held for reading meanwhile.
pub fn ask<'py, T>(
    [axis, solid_angle, wo]: [&Bound<'py, PyAny>; 3],
    answer: impl FnOnce(&Question) -> PyResult<T>,
) -> PyResult<T> {
    let arrays = Arrays::new(axis, solid_angle, wo)?;
    let views = arrays.views();
    answer(&Question::new(&views)?)
}

impl<'py> Arrays<'py> {
    /// From arguments of Python.
    fn new(axis: &Bound<'py, PyAny>, solid_angle: &Bound<'py, PyAny>, wo: &Bound<'py, PyAny>) -> PyResult<Self> {
        Ok(Self {
            axis: Input::new("axis", axis)?,
            solid_angle: Input::new("solid_angle", solid_angle)?,
            wo: Input::new("wo", wo)?,
        })
    }

    /// Views of the arguments.
    fn views(&self) -> [View<'_>; 3] {
        [self.axis.view(), self.solid_angle.view(), self.wo.view()]
    }
}

/// The shape of the vectors in an array whose last dimension they are.
///
/// # Errors
/// It is none of length three.
pub fn shape_of_vectors<'v>(name: &str, view: &'v View) -> PyResult<&'v [usize]> {
    match view.shape().split_last() {
        Some((3, rest)) => Ok(rest),
        _ => Err(bad(format!("{name} has the shape {:?}: the last length must be 3", view.shape()))),
    }
}

/// Rows of elements: all dimensions but the last two are fixed.
struct Plane<'a> {
    index: Vec<usize>,
    axis: Vectors<'a>,
    solid_angle: Numbers<'a>,
    wo: Vectors<'a>,
}

impl<'a> Question<'a> {
    /// Broadcasts the views of [`Arrays::views`].
    ///
    /// # Errors
    /// Shapes that do not fit.
    pub fn new([axis, solid_angle, wo]: &'a [View<'a>; 3]) -> PyResult<Self> {
        let shapes = [shape_of_vectors("axis", axis)?, solid_angle.shape(), shape_of_vectors("wo", wo)?];
        let common = common_shape(&shapes).ok_or_else(|| {
            let [axis, solid_angle, wo] = shapes;
            bad(format!("the shapes of axis {axis:?}, solid_angle {solid_angle:?} and wo {wo:?} do not fit"))
        })?;
        require_room(&common)?;
        let added = 2usize.saturating_sub(common.len());
        let mut shape = [&[1, 1][..added], &common].concat();
        let of_vectors = [&shape[..], &[3]].concat();
        let fit = "broadcasts to the common shape";
        let (axis, wo) = (axis.broadcast(&of_vectors).expect(fit), wo.broadcast(&of_vectors).expect(fit));
        let solid_angle = solid_angle.broadcast(&shape).expect(fit);
        // Caps that are seen from one direction are looked up together.
        let last = shape.len() - 1;
        let together = (0..=last).filter(|&d| wo.is_constant(d)).max_by_key(|&d| (shape[d], d));
        let inner = together.filter(|&d| shape[d] > 1).unwrap_or(last);
        shape.swap(inner, last);
        let swap = |view: View<'a>| view.swapped(inner, last);
        Ok(Self {
            axis: swap(axis),
            solid_angle: swap(solid_angle),
            wo: swap(wo),
            shape,
            swapped: (inner, last),
            added,
        })
    }

    /// Elements.
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// Lengths of the last two dimensions.
    fn sides(&self) -> (usize, usize) {
        let n = self.shape.len();
        (self.shape[n - 2], self.shape[n - 1])
    }

    /// All planes, in their order.
    fn planes(&self) -> impl Iterator<Item = Plane<'a>> + '_ {
        let outer = &self.shape[..self.shape.len() - 2];
        (0..outer.iter().product()).map(move |mut plane: usize| {
            let mut index = vec![0; outer.len()];
            for (i, n) in index.iter_mut().zip(outer).rev() {
                (*i, plane) = (plane % n, plane / n);
            }
            let (axis, solid_angle) = (self.axis.vectors(&index), self.solid_angle.numbers(&index));
            Plane { wo: self.wo.vectors(&index), index, axis, solid_angle }
        })
    }

    /// What is wrong with an element, and where the caller finds it.
    fn refused(&self, plane: &Plane, row: usize, i: usize, what: impl ToString) -> Refused {
        let mut place = [&plane.index[..], &[row, i]].concat();
        place.swap(self.swapped.0, self.swapped.1);
        Refused { what: what.to_string(), place: place.split_off(self.added) }
    }

    /// An answer, element by element in the order of the planes, as the caller's shape has it; `per_element` numbers for each
    /// become one more dimension.
    pub fn shaped<T>(&self, values: Vec<T>, per_element: Option<usize>) -> ArrayD<T> {
        let shape: Vec<usize> = self.shape.iter().copied().chain(per_element).collect();
        let mut array = ArrayD::from_shape_vec(shape, values).expect("one value per element");
        array.swap_axes(self.swapped.0, self.swapped.1);
        (0..self.added).fold(array, |array, _| array.index_axis_move(Axis(0), 0))
    }

    /// `N` numbers per element: `look_up` gets caps that are seen from one direction, and room for their numbers.
    ///
    /// # Errors
    /// An element outside of the domain.
    pub fn answer<const N: usize>(
        &self,
        mut look_up: impl FnMut(&CapBatch, Vec3, &mut [f32]),
    ) -> Result<Vec<f32>, Refused> {
        let mut out = vec![0.0; self.len() * N];
        let mut caps = CapBatch::with_capacity(BLOCK);
        let ((rows, n), last) = (self.sides(), self.shape.len() - 1);
        let one_view = self.wo.is_constant(last);
        let same_caps = one_view && (0..last).all(|d| self.axis.is_constant(d) && self.solid_angle.is_constant(d));
        for start in (0..n).step_by(BLOCK) {
            let end = n.min(start + BLOCK);
            caps.clear();
            for (p, plane) in self.planes().enumerate() {
                for row in 0..rows {
                    let mut from = start;
                    while from < end {
                        let view = plane.wo.at(row, from);
                        let other = |&i: &usize| plane.wo.at(row, i) != view;
                        let to = if one_view { end } else { (from + 1..end).find(other).unwrap_or(end) };
                        let view = direction(view).map_err(|what| self.refused(&plane, row, from, what))?;
                        if !same_caps || caps.is_empty() {
                            caps.clear();
                            for i in from..to {
                                let solid_angle = plane.solid_angle.at(row, i) as f32;
                                let pushed = caps.push(plane.axis.at(row, i).as_vec3(), solid_angle);
                                pushed.map_err(|what| self.refused(&plane, row, i, what))?;
                            }
                        }
                        let first = (p * rows + row) * n;
                        look_up(&caps, view.as_vec3(), &mut out[(first + from) * N..(first + to) * N]);
                        from = to;
                    }
                }
            }
        }
        Ok(out)
    }

    /// Caps and directions, element by element in the order of the planes.
    pub fn elements(&self) -> impl Iterator<Item = Result<(Cap, DVec3), Refused>> + '_ {
        let (rows, n) = self.sides();
        self.planes().flat_map(move |plane| {
            (0..rows * n).map(move |k| {
                let (row, i) = (k / n, k % n);
                let cap = Cap::from_axis(plane.axis.at(row, i), plane.solid_angle.at(row, i));
                let cap = cap.map_err(|e: CapError| self.refused(&plane, row, i, e))?;
                let wo = direction(plane.wo.at(row, i)).map_err(|what| self.refused(&plane, row, i, what))?;
                Ok((cap, wo))
            })
        })
    }
}

/// A direction to the eye: of length one, above the horizon.
fn direction(wo: DVec3) -> Result<DVec3, String> {
    let length = wo.length();
    // A comparison with NaN fails.
    let unit = (length - 1.0).abs() <= UNIT;
    if !unit {
        return Err(format!("the length of wo is {length}, it must be 1"));
    }
    if wo.z > 0.0 { Ok(wo / length) } else { Err(format!("wo_z = {} is not above the horizon", wo.z)) }
}
