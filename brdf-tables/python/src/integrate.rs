//! The mean BRDF without a table: quadrature and Monte Carlo.

use crate::error::bad;
use crate::material::Named;
use crate::question::{Question, ask};
use brdf_tables::cap::Cap;
use brdf_tables::quadrature::mean_brdf;
use core::f64::consts::FRAC_1_PI;
use fitter::integrate::mean_brdf_mc_rgb;
use glam::DVec3;
use numpy::{IntoPyArray, PyArrayDyn};
use pyo3::prelude::*;
use rayon::prelude::*;

/// Elements between two looks at whether the person wants to stop.
const BATCH: usize = 256;

/// Numbers per element, in parallel, batch by batch.
fn each<const N: usize>(
    py: Python<'_>,
    question: &Question,
    value: impl Fn(u64, &Cap, DVec3) -> [f64; N] + Sync,
) -> PyResult<Vec<[f64; N]>> {
    let mut out = Vec::with_capacity(question.len());
    let mut elements = question.elements();
    loop {
        let batch: Result<Vec<_>, _> = elements.by_ref().take(BATCH).collect();
        let batch = batch.map_err(|e| e.exception())?;
        if batch.is_empty() {
            return Ok(out);
        }
        let first = out.len();
        let value = |(i, (cap, wo)): (usize, &(Cap, DVec3))| value((first + i) as u64, cap, *wo);
        out.extend(py.detach(|| batch.par_iter().enumerate().map(value).collect::<Vec<_>>()));
        py.check_signals()?;
    }
}

#[pyfunction]
#[pyo3(signature = (material, axis, solid_angle, wo, *, tolerance = 1e-6))]
pub fn integrate<'py>(
    py: Python<'py>,
    material: Named<'py>,
    axis: &Bound<'py, PyAny>,
    solid_angle: &Bound<'py, PyAny>,
    wo: &Bound<'py, PyAny>,
    tolerance: f64,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    if !(1e-12..=1.0).contains(&tolerance) {
        return Err(bad(format!("tolerance {tolerance} is not between 1e-12 and 1")));
    }
    let (material, ..) = material.load(py)?;
    ask([axis, solid_angle, wo], |question| {
        let values = each(py, question, |_, cap, wo| {
            [material.specular.map_or(0.0, |specular| mean_brdf(&specular, cap, wo, tolerance, 0.0))]
        })?;
        Ok(question.shaped(values.into_iter().flatten().collect(), None).into_pyarray(py))
    })
}

/// Means and their standard errors.
type Estimates<'py> = (Bound<'py, PyArrayDyn<f64>>, Bound<'py, PyArrayDyn<f64>>);

#[pyfunction]
#[pyo3(signature = (material, axis, solid_angle, wo, *, samples = 65536, seed = 1))]
pub fn monte_carlo<'py>(
    py: Python<'py>,
    material: Named<'py>,
    axis: &Bound<'py, PyAny>,
    solid_angle: &Bound<'py, PyAny>,
    wo: &Bound<'py, PyAny>,
    samples: u64,
    seed: u64,
) -> PyResult<Estimates<'py>> {
    if !(32..=1 << 32).contains(&samples) {
        return Err(bad(format!("{samples} samples: 32 to 4294967296 are possible")));
    }
    let (material, ..) = material.load(py)?;
    ask([axis, solid_angle, wo], |question| {
        let values = each(py, question, |i, cap, wo| {
            // The diffuse part is known; only the specular one is estimated.
            let mut out = [material.kd.map(|kd| kd * FRAC_1_PI), [0.0; 3]];
            if let Some(specular) = &material.specular {
                let seed = seed.wrapping_add(i << 32);
                for (c, e) in mean_brdf_mc_rgb(specular, cap, wo, samples as usize, seed).into_iter().enumerate() {
                    out[0][c] += material.ks[c] * e.value;
                    out[1][c] = material.ks[c] * e.stderr;
                }
            }
            [out[0][0], out[0][1], out[0][2], out[1][0], out[1][1], out[1][2]]
        })?;
        let part = |from: usize| {
            let values = values.iter().flat_map(|v| v[from..from + 3].iter().copied()).collect();
            question.shaped(values, Some(3)).into_pyarray(py)
        };
        Ok((part(0), part(3)))
    })
}

#[pyfunction]
pub fn projected_solid_angle<'py>(
    axis: &Bound<'py, PyAny>,
    solid_angle: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let py = axis.py();
    let up = [0.0, 0.0, 1.0].into_pyobject(py)?;
    ask([axis, solid_angle, up.as_any()], |question| {
        let values = py.detach(|| {
            question
                .elements()
                .map(|element| element.map(|(cap, _)| cap.projected_solid_angle()))
                .collect::<Result<Vec<_>, _>>()
        });
        Ok(question.shaped(values.map_err(|e| e.exception())?, None).into_pyarray(py))
    })
}
