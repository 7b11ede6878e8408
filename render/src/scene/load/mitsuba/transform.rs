//! `transform` elements: operations applied one after the other, each from the left.

use super::value::{numbers, real};
use super::xml::Element;
use crate::scene::load::error::LoadError;
use glam::{DAffine3, DMat3, DMat4, DVec3};

/// Composes the children of a `transform` element.
pub fn parse(element: &Element) -> Result<DAffine3, LoadError> {
    let mut matrix = DMat4::IDENTITY;
    for operation in &element.children {
        matrix = self::operation(operation)? * matrix;
    }
    if (matrix.row(3) - glam::DVec4::W).abs().max_element() > 1e-9 {
        return Err(element.error("the last row of the matrix must be 0 0 0 1"));
    }
    if !matrix.is_finite() || matrix.determinant() == 0.0 {
        return Err(element.error("the transform is singular"));
    }
    Ok(DAffine3::from_mat4(matrix))
}

fn operation(element: &Element) -> Result<DMat4, LoadError> {
    match element.tag.as_str() {
        "translate" => Ok(DMat4::from_translation(vector(element, 0.0)?)),
        "scale" => Ok(DMat4::from_scale(vector(element, 1.0)?)),
        "rotate" => {
            let axis = vector(element, 0.0)?.try_normalize().ok_or_else(|| element.error("the axis is zero"))?;
            Ok(DMat4::from_axis_angle(axis, attribute(element, "angle")?.to_radians()))
        }
        "matrix" => {
            let values = numbers(element.require("value")?).map_err(|e| element.error(e))?;
            match values.as_slice() {
                v if v.len() == 16 => Ok(DMat4::from_cols_slice(v).transpose()),
                v if v.len() == 9 => Ok(DMat4::from_mat3(DMat3::from_cols_slice(v).transpose())),
                v => Err(element.error(format!("a matrix has 9 or 16 numbers, not {}", v.len()))),
            }
        }
        "lookat" | "lookAt" | "look_at" => look_at(element),
        other => Err(element.error(format!("no such transform: `{other}`"))),
    }
}

/// Mitsuba's view frame: +z towards the target, +y up, +x left.
fn look_at(element: &Element) -> Result<DMat4, LoadError> {
    let point = |name: &str| -> Result<DVec3, LoadError> {
        let values = numbers(element.require(name)?).map_err(|e| element.error(e))?;
        <[f64; 3]>::try_from(values).map(DVec3::from).map_err(|_| element.error(format!("`{name}` needs 3 numbers")))
    };
    let (origin, target) = (point("origin")?, point("target")?);
    let forward = (target - origin).try_normalize().ok_or_else(|| element.error("origin and target coincide"))?;
    let up = if element.attribute("up").is_some() { point("up")? } else { forward.any_orthonormal_vector() };
    let left = up.cross(forward).try_normalize();
    let left = left.ok_or_else(|| element.error("`up` is parallel to the direction of view"))?;
    Ok(DMat4::from_cols(left.extend(0.0), forward.cross(left).extend(0.0), forward.extend(0.0), origin.extend(1.0)))
}

/// `x`, `y`, `z` attributes, or `value` with one or three numbers.
pub fn vector(element: &Element, missing: f64) -> Result<DVec3, LoadError> {
    if let Some(value) = element.attribute("value") {
        return match numbers(value).map_err(|e| element.error(e))?.as_slice() {
            &[v] => Ok(DVec3::splat(v)),
            &[x, y, z] => Ok(DVec3::new(x, y, z)),
            v => Err(element.error(format!("1 or 3 numbers needed, not {}", v.len()))),
        };
    }
    let component = |name: &str| match element.attribute(name) {
        Some(_) => attribute(element, name),
        None => Ok(missing),
    };
    Ok(DVec3::new(component("x")?, component("y")?, component("z")?))
}

fn attribute(element: &Element, name: &str) -> Result<f64, LoadError> {
    real(element.require(name)?).map_err(|e| element.error(e))
}
