//! Arrays as numpy has them: read where they lie, in either precision and any order.

use crate::error::bad;
use glam::{DVec3, Vec3};
use ndarray::{ArrayView2, ArrayView3, ArrayViewD, Axis, IxDyn};
use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn};
use pyo3::exceptions::PyMemoryError;
use pyo3::intern;
use pyo3::prelude::*;

/// Most numbers of the answer for an element: a colour and its standard errors.
const NUMBERS: usize = 6;

/// An array of a caller, held for reading.
pub enum Input<'py> {
    /// `float32`.
    Single(PyReadonlyArrayDyn<'py, f32>),
    /// `float64`.
    Double(PyReadonlyArrayDyn<'py, f64>),
}

impl<'py> Input<'py> {
    /// The array that `value` is; lists and whole numbers, and arrays that no processor reads as they are, become one of
    /// `float64`.
    ///
    /// # Errors
    /// It is not of numbers; `name` says which argument it is.
    pub fn new(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Self> {
        if let Some(input) = Self::in_place(value)? {
            return Ok(input);
        }
        let py = value.py();
        let array = py.import(intern!(py, "numpy"))?.call_method1(intern!(py, "array"), (value,));
        let keywords = pyo3::types::PyDict::new(py);
        keywords.set_item(intern!(py, "casting"), "same_kind")?;
        let array = array.and_then(|a| a.call_method(intern!(py, "astype"), ("float64",), Some(&keywords)));
        let array = array.map_err(|error| bad(format!("{name}: {}", error.value(py))))?;
        Ok(Self::Double(array.cast_into::<PyArrayDyn<f64>>()?.try_readonly()?))
    }

    /// An array that can be read where it lies.
    fn in_place(value: &Bound<'py, PyAny>) -> PyResult<Option<Self>> {
        let aligned =
            || value.getattr(intern!(value.py(), "flags"))?.getattr(intern!(value.py(), "aligned"))?.is_truthy();
        if let Ok(array) = value.cast::<PyArrayDyn<f32>>() {
            return Ok(if aligned()? { Some(Self::Single(array.try_readonly()?)) } else { None });
        }
        if let Ok(array) = value.cast::<PyArrayDyn<f64>>() {
            return Ok(if aligned()? { Some(Self::Double(array.try_readonly()?)) } else { None });
        }
        Ok(None)
    }

    /// Its elements.
    pub fn view(&self) -> View<'_> {
        match self {
            Self::Single(array) => View::Single(array.as_array()),
            Self::Double(array) => View::Double(array.as_array()),
        }
    }
}

/// Elements of an array, of which nothing is copied.
#[derive(Clone)]
pub enum View<'a> {
    /// `float32`.
    Single(ArrayViewD<'a, f32>),
    /// `float64`.
    Double(ArrayViewD<'a, f64>),
}

/// The same of either precision.
macro_rules! either {
    ($view:expr, $v:ident => $result:expr) => {
        match $view {
            View::Single($v) => View::Single($result),
            View::Double($v) => View::Double($result),
        }
    };
}

impl<'a> View<'a> {
    /// Lengths of its dimensions.
    pub fn shape(&self) -> &[usize] {
        match self {
            Self::Single(v) => v.shape(),
            Self::Double(v) => v.shape(),
        }
    }

    /// Whether all along a dimension is one element.
    pub fn is_constant(&self, dimension: usize) -> bool {
        let stride = match self {
            Self::Single(v) => v.strides()[dimension],
            Self::Double(v) => v.strides()[dimension],
        };
        stride == 0 || self.shape()[dimension] == 1
    }

    /// As numpy broadcasts it; `None` where it does not fit.
    pub fn broadcast<'b>(&'b self, shape: &[usize]) -> Option<View<'b>> {
        Some(match self {
            Self::Single(v) => View::Single(v.broadcast(IxDyn(shape))?),
            Self::Double(v) => View::Double(v.broadcast(IxDyn(shape))?),
        })
    }

    /// With two dimensions exchanged.
    pub fn swapped(self, a: usize, b: usize) -> Self {
        either!(self, v => {
            let mut v = v;
            v.swap_axes(a, b);
            v
        })
    }

    /// What is at `index` of the leading dimensions.
    fn at(&self, index: &[usize]) -> Self {
        let mut view = self.clone();
        for &i in index {
            view = either!(view, v => v.index_axis_move(Axis(0), i));
        }
        view
    }

    /// The numbers at `index` of all dimensions but the last two.
    pub fn numbers(&self, index: &[usize]) -> Numbers<'a> {
        match self.at(index) {
            Self::Single(v) => Numbers::Single(v.into_dimensionality().expect("two dimensions are left")),
            Self::Double(v) => Numbers::Double(v.into_dimensionality().expect("two dimensions are left")),
        }
    }

    /// The vectors at `index` of all dimensions but the last three, the last of which has the length three.
    pub fn vectors(&self, index: &[usize]) -> Vectors<'a> {
        match self.at(index) {
            Self::Single(v) => Vectors::Single(v.into_dimensionality().expect("three dimensions are left")),
            Self::Double(v) => Vectors::Double(v.into_dimensionality().expect("three dimensions are left")),
        }
    }
}

/// Rows of numbers.
pub enum Numbers<'a> {
    /// `float32`.
    Single(ArrayView2<'a, f32>),
    /// `float64`.
    Double(ArrayView2<'a, f64>),
}

impl Numbers<'_> {
    /// Number `i` of a row.
    #[inline]
    pub fn at(&self, row: usize, i: usize) -> f64 {
        match self {
            Self::Single(v) => v[[row, i]].into(),
            Self::Double(v) => v[[row, i]],
        }
    }
}

/// Rows of vectors.
pub enum Vectors<'a> {
    /// `float32`.
    Single(ArrayView3<'a, f32>),
    /// `float64`.
    Double(ArrayView3<'a, f64>),
}

impl Vectors<'_> {
    /// Vector `i` of a row.
    #[inline]
    pub fn at(&self, row: usize, i: usize) -> DVec3 {
        match self {
            Self::Single(v) => Vec3::new(v[[row, i, 0]], v[[row, i, 1]], v[[row, i, 2]]).as_dvec3(),
            Self::Double(v) => DVec3::new(v[[row, i, 0]], v[[row, i, 1]], v[[row, i, 2]]),
        }
    }
}

/// The shape that several broadcast to, as numpy does; `None` where they do not fit.
pub fn common_shape(shapes: &[&[usize]]) -> Option<Vec<usize>> {
    let dimensions = shapes.iter().map(|s| s.len()).max().unwrap_or(0);
    (0..dimensions)
        .map(|d| {
            let lengths = shapes.iter().filter_map(|s| (s.len() + d).checked_sub(dimensions).map(|at| s[at]));
            let mut length = 1;
            for other in lengths.filter(|&n| n != 1) {
                if length != 1 && length != other {
                    return None;
                }
                length = other;
            }
            Some(length)
        })
        .collect()
}

/// Refuses shapes whose answer would not fit into memory, before any of it is taken: arrays that are broadcast are small themselves.
///
/// # Errors
/// There are too many elements.
pub fn require_room(shape: &[usize]) -> PyResult<()> {
    let elements = shape.iter().try_fold(1usize, |product, &length| product.checked_mul(length.max(1)));
    let fits = elements.is_some_and(|n| Vec::<[f64; NUMBERS]>::new().try_reserve_exact(n).is_ok());
    if fits {
        Ok(())
    } else {
        Err(PyMemoryError::new_err(format!("an answer of the shape {shape:?} does not fit into memory")))
    }
}
