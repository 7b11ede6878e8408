//! `Material`: what a table is made of.

use crate::arrays::{Input, common_shape, require_room};
use crate::error::{bad, recipe};
use crate::question::shape_of_vectors;
use ndarray::ArrayD;
use numpy::{IntoPyArray, PyArrayDyn};
use pyo3::prelude::*;
use std::path::PathBuf;

/// A material: a diffuse part and a specular part.
#[pyclass(frozen, module = "brdf_tables")]
pub struct Material {
    /// As the library has it.
    pub inner: brdf_tables::Material,
    /// As the caller named it, for messages.
    pub name: String,
    notes: Vec<String>,
}

impl Material {
    /// One that a table holds.
    pub fn of(inner: brdf_tables::Material) -> Self {
        Self { inner, name: inner.to_string(), notes: Vec::new() }
    }
}

/// A material, or what names one.
#[derive(FromPyObject)]
pub enum Named<'py> {
    /// As it is.
    Material(PyRef<'py, Material>),
    /// An inline recipe or the name of a file.
    Text(String),
    /// A file.
    Path(PathBuf),
}

impl Named<'_> {
    /// The material, its name, and what is told of it.
    pub fn load(&self, py: Python<'_>) -> PyResult<(brdf_tables::Material, String, Vec<String>)> {
        let text = match self {
            Self::Material(material) => return Ok((material.inner, material.name.clone(), material.notes.clone())),
            Self::Text(text) => text.clone(),
            Self::Path(path) => path.to_str().ok_or_else(|| bad(format!("{path:?}: not a name in UTF-8")))?.into(),
        };
        let read = py.detach(|| fitter::recipe::material_with_notes(&text)).map_err(|e| recipe(&e))?;
        Ok((read.0, text, read.1))
    }
}

#[pymethods]
impl Material {
    #[new]
    #[pyo3(signature = (recipe, /))]
    fn new(py: Python<'_>, recipe: Named<'_>) -> PyResult<Self> {
        let (inner, name, notes) = recipe.load(py)?;
        Ok(Self { inner, name, notes })
    }

    /// The canonical recipe.
    #[getter]
    fn recipe(&self) -> String {
        self.inner.to_string()
    }

    /// Name of the model.
    #[getter]
    fn model(&self) -> &'static str {
        self.inner.values().0
    }

    /// Albedo of the diffuse part.
    #[getter]
    fn kd(&self) -> [f64; 3] {
        self.inner.kd
    }

    /// Strength of the specular part.
    #[getter]
    fn ks(&self) -> [f64; 3] {
        self.inner.ks
    }

    /// What is told of measured data.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// Whether turning both directions about the normal changes nothing.
    #[getter]
    fn is_isotropic(&self) -> bool {
        self.inner.specular.is_none_or(|specular| specular.is_isotropic())
    }

    /// f_r for pairs of directions.
    fn eval<'py>(&self, wi: &Bound<'py, PyAny>, wo: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let py = wi.py();
        let inputs = (Input::new("wi", wi)?, Input::new("wo", wo)?);
        let (wi, wo) = (inputs.0.view(), inputs.1.view());
        let shapes = [shape_of_vectors("wi", &wi)?, shape_of_vectors("wo", &wo)?];
        let common = common_shape(&shapes)
            .ok_or_else(|| bad(format!("the shapes of wi {:?} and wo {:?} do not fit", shapes[0], shapes[1])))?;
        require_room(&common)?;
        let added = 2usize.saturating_sub(common.len());
        let shape = [&[1, 1][..added], &common, &[3]].concat();
        let fit = "broadcasts to the common shape";
        let (wi, wo) = (wi.broadcast(&shape).expect(fit), wo.broadcast(&shape).expect(fit));
        let (outer, sides) = shape[..shape.len() - 1].split_at(shape.len() - 3);
        let values = py.detach(|| {
            let mut out = Vec::with_capacity(shape.iter().product());
            for index in ndarray::indices(outer) {
                let index = ndarray::Dimension::slice(&index);
                let (wi, wo) = (wi.vectors(index), wo.vectors(index));
                for (row, i) in (0..sides[0]).flat_map(|row| (0..sides[1]).map(move |i| (row, i))) {
                    out.extend(self.inner.eval(wi.at(row, i), wo.at(row, i)));
                }
            }
            out
        });
        Ok(ArrayD::from_shape_vec(&shape[added..], values).expect("three values per pair").into_pyarray(py))
    }

    fn __repr__(&self) -> String {
        format!("Material({:?})", self.name)
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.inner == other.inner
    }
}
