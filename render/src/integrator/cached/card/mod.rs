//! Records summed on a graphics card.
//!
//! The surfaces of the pixels are the geometry buffer, which the processor has traced. They go to the card tile by tile, with the
//! records drawn onto each tile (as the processor's splatting does); a group of threads takes a tile and walks its records in order, so that sums
//! are the same every time. What comes back is judged by the code that judges the processor's sums. Surfaces that the card has no
//! code for (colours of measured materials) are read by the processor.

mod batch;
mod eas;
mod frames;
mod harmonics;
mod irradiance;
mod programs;
mod rows;

pub(super) use frames::Card;
pub use irradiance::rows as irradiance_rows;
pub use programs::{IRRADIANCE_RUN, irradiance_shader};
