//! `Table`: the look-up.

use crate::error::{format, output};
use crate::material::{Material, Named};
use crate::question::ask;
use brdf_tables::brdf::Fresnel;
use brdf_tables::errors::{Errors, Summary};
use core::f32::consts::FRAC_1_PI;
use numpy::{IntoPyArray, PyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::PathBuf;

/// A table of the mean BRDF of one material.
#[pyclass(frozen, module = "brdf_tables")]
pub struct Table {
    /// As the library has it.
    pub inner: brdf_tables::Table,
}

/// Names of the families that the library holds.
#[pyfunction]
pub fn families() -> Vec<&'static str> {
    brdf_tables::family::families().iter().map(|family| family.header.kin.name()).collect()
}

#[pymethods]
impl Table {
    #[staticmethod]
    #[pyo3(signature = (path, /))]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let name = path.display().to_string();
        let inner = py.detach(|| brdf_tables::Table::load(&path)).map_err(|e| format(Some(&name), &e))?;
        Ok(Self { inner })
    }

    #[staticmethod]
    #[pyo3(signature = (data, /))]
    fn from_bytes(data: &[u8]) -> PyResult<Self> {
        Ok(Self { inner: brdf_tables::Table::from_bytes(data).map_err(|e| format(None, &e))? })
    }

    #[staticmethod]
    #[pyo3(signature = (material, /))]
    fn of_family(py: Python<'_>, material: Named<'_>) -> PyResult<Option<Self>> {
        let (material, ..) = material.load(py)?;
        Ok(py.detach(|| brdf_tables::family::table(&material)).map(|inner| Self { inner }))
    }

    #[pyo3(signature = (path, /))]
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let bytes = self.inner.to_bytes().map_err(|e| format(None, &e))?;
        py.detach(|| kit::output::write(&path, &bytes)).map_err(|e| output(&e))
    }

    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.inner.to_bytes().map_err(|e| format(None, &e))?))
    }

    #[getter]
    fn material(&self) -> Material {
        Material::of(self.inner.header.material)
    }

    #[getter]
    fn representation(&self) -> &'static str {
        self.inner.representation_name()
    }

    fn info<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let header = &self.inner.header;
        let dict = PyDict::new(py);
        dict.set_item("material", header.material.to_string())?;
        dict.set_item("representation", self.inner.representation_name())?;
        dict.set_item("bytes", self.inner.to_bytes().map_err(|e| format(None, &e))?.len())?;
        dict.set_item("tolerance", header.tolerance)?;
        dict.set_item("promise", named(py, ["median", "p95", "worst"].into_iter().zip(header.promise))?)?;
        dict.set_item("creator", &header.creator)?;
        dict.set_item("command", &header.command)?;
        dict.set_item("seed", header.seed)?;
        dict.set_item("notes", &header.notes)?;
        for (name, summary) in
            [("at_nodes", header.at_nodes), ("off_nodes", header.off_nodes), ("clipped", header.clipped)]
        {
            dict.set_item(name, summary_dict(py, &summary)?)?;
        }
        Ok(dict)
    }

    fn specular<'py>(
        &self,
        axis: &Bound<'py, PyAny>,
        solid_angle: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let py = axis.py();
        ask([axis, solid_angle, wo], |question| {
            let answer = py.detach(|| question.answer::<1>(|caps, wo, out| self.inner.specular_values(caps, wo, out)));
            Ok(question.shaped(answer.map_err(|e| e.exception())?, None).into_pyarray(py))
        })
    }

    fn rgb<'py>(
        &self,
        axis: &Bound<'py, PyAny>,
        solid_angle: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let py = axis.py();
        ask([axis, solid_angle, wo], |question| {
            let material = &self.inner.header.material;
            let (kd, ks) = (material.kd.map(|x| x as f32 * FRAC_1_PI), material.ks.map(|x| x as f32));
            let model = material.specular.filter(|_| has_colour(material));
            let mut values = Vec::new();
            let answer = py.detach(|| {
                question.answer::<3>(|caps, wo, out| {
                    values.resize(caps.len(), 0.0);
                    self.inner.specular_values(caps, wo, &mut values);
                    for ((i, rgb), &value) in out.chunks_exact_mut(3).enumerate().zip(&values) {
                        // The colour is taken at the axis of the cap.
                        let tint = model.map_or([1.0; 3], |m| m.tint(caps.get(i).0.as_dvec3(), wo.as_dvec3()));
                        (0..3).for_each(|c| rgb[c] = kd[c] + ks[c] * tint[c] as f32 * value);
                    }
                })
            });
            Ok(question.shaped(answer.map_err(|e| e.exception())?, Some(3)).into_pyarray(py))
        })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        Ok((py.get_type::<Self>().getattr("from_bytes")?, (self.to_bytes(py)?,)))
    }

    fn __repr__(&self) -> String {
        format!("<Table of {}, {}>", self.inner.header.material, self.inner.representation_name())
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.inner == other.inner
    }
}

/// Whether the specular part changes its colour with the directions.
fn has_colour(material: &brdf_tables::Material) -> bool {
    material.specular.is_some_and(|specular| !matches!(specular.fresnel(), None | Some(Fresnel::None)))
        || material.specular.is_some_and(|specular| matches!(specular, brdf_tables::Specular::Measured(_)))
}

/// Numbers by name.
fn named<'py>(py: Python<'py>, entries: impl IntoIterator<Item = (&'static str, f64)>) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    entries.into_iter().try_for_each(|(name, x)| dict.set_item(name, x))?;
    Ok(dict)
}

/// The five errors of a set of caps, as `fitter info --json` has them.
fn summary_dict<'py>(py: Python<'py>, summary: &Summary) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("caps", summary.caps)?;
    for (name, errors) in [("median", summary.median), ("p95", summary.p95), ("worst", summary.worst)] {
        dict.set_item(name, named(py, Errors::NAMES.into_iter().zip(errors.to_array().map(f64::from)))?)?;
    }
    Ok(dict)
}
