//! Work for a graphics card.

mod device;
mod draw;

pub use device::{Device, GpuError, Program};
pub use draw::{Canvas, Drawing};
use std::sync::OnceLock;

/// The adapter of the process, opened when it is first asked for.
///
/// # Errors
/// There is none, or it cannot be used; then and whenever it is asked for again.
pub fn shared() -> Result<&'static Device, GpuError> {
    static DEVICE: OnceLock<Result<Device, GpuError>> = OnceLock::new();
    DEVICE.get_or_init(Device::open).as_ref().map_err(Clone::clone)
}
