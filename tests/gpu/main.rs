//! What runs on a graphics card, or on what stands in for one; skipped, saying so, where there is none.

/// Pictures from records.
mod card;
/// Hemispheres drawn onto planes.
mod hemispheres;
/// Look-ups of tables.
mod shaders;

use render::gpu::GpuError;

/// The card, or `None` with a message where there is none.
fn present<D>(found: Result<D, GpuError>) -> Option<D> {
    match found {
        Ok(device) => Some(device),
        Err(GpuError::NoAdapter) => {
            eprintln!("skipped: {}", GpuError::NoAdapter);
            None
        }
        Err(e) => panic!("{e}"),
    }
}
