//! The look-up of a table as WGSL.

use brdf_tables::table::Table;
use brdf_tables::wgsl::{Buffer, Tables, WgslError, source};

/// A shader module and the storage buffer that it reads.
pub struct Shader {
    /// WGSL.
    pub text: String,
    /// 32-bit words, little-endian.
    pub buffer: Vec<u8>,
}

/// A text in one line of a comment, whatever it is: WGSL ends lines at more characters than Rust does.
fn in_a_line(text: &str) -> String {
    text.replace(|c: char| c.is_control() || matches!(c, '\u{2028}' | '\u{2029}'), " ")
}

/// The functions that look a table up, bound to this group and binding; `name` is what the buffer's file is called.
///
/// # Errors
/// A table in the layout of 2015.
pub fn wgsl(table: &Table, (group, binding): (u32, u32), name: &str) -> Result<Shader, WgslError> {
    let mut tables = Tables::new();
    let (place, name) = (tables.push(table)?, in_a_line(name));
    let text = format!(
        "// {}\n// The mean BRDF over a cap of directions, sr^-1: mean_brdf(MEAN_BRDF_TABLE, axis, solid_angle, wo), with unit vectors\n\
         // in the local frame (z = normal); whole BRDF = mean_brdf_diffuse(..)/pi + mean_brdf_specular(..) * tint * mean_brdf(..).\n\
         // Bind the {} bytes of {name} as a read-only storage buffer: group {group}, binding {binding}.\n\
         const MEAN_BRDF_TABLE: u32 = {place}u;\n\n{}",
        in_a_line(&table.header.material.recipe_text()),
        tables.bytes().len(),
        source(&Buffer::Bound { group, binding }),
    );
    let buffer = tables.words().iter().flat_map(|word| word.to_le_bytes()).collect();
    Ok(Shader { text, buffer })
}
